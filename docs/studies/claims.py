"""Claims of the paper that no sweep was made for, from the stored points of others: ``python -m docs.studies.claims``.

The power of w with which 1/κ_att rises; how far tensions of one h_rms/δ_c lie apart, and whether w A0/Δr orders them
better than N P_c; how much of the binding energy lies within the effective range; the least l_a/(h' a0) that sticks.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from pandas import DataFrame, read_csv
from scipy.stats import spearmanr, t

from continuum.model.walls.inverse_powers import InversePowers
from continuum.paper.relations import largest_tension
from docs.studies.judgement import MEASURED

SWEEPS = {"figure2-4096": "4096², λ_L/λ_s = 64", "figure4-1024": "1024², 16 to 128", "figure4-2048": "2048², 16"}
NEAR = 1.1
"""Factor within which h_rms/δ_c counts as one."""


def points(name: str) -> DataFrame:
    """Those on approach with enough asperities."""
    rows = read_csv(MEASURED / f"paper-{name}-points.csv")
    return rows[rows.approach & rows.valid]


def powers(rows: DataFrame) -> Iterator[tuple[str, str]]:
    """Exponent of w in 1/κ_att between neighbouring l_a of a surface, with its 95 % interval."""
    chosen = rows[rows.reference & (rows.length > 0)]
    table = np.log(chosen.pivot_table(index="surface", columns="length", values="kappa_att"))
    for low, high in zip(table.columns, table.columns[1:], strict=False):
        each = ((table[low] - table[high]) / np.log(high / low)).replace([np.inf, -np.inf], np.nan).dropna()
        half = t.ppf(0.975, len(each) - 1) * each.std() / np.sqrt(len(each))
        yield f"l_a = {low:g} to {high:g}", f"{each.mean():.2f} ± {half:.2f} of {len(each)} surfaces"


def tensions(rows: DataFrame) -> tuple[str, str] | None:
    """Largest ratio of tensions of one h_rms/δ_c; rank correlations with it, by N P_c and by w A0/Δr."""
    pulling = largest_tension(rows).query("tension > 0")
    if len(pulling) < 20:
        return None
    ratio, tension = pulling.ratio.to_numpy(), pulling.tension.to_numpy()
    apart = max(np.ptp(np.log(tension[np.abs(np.log(ratio / one)) < np.log(NEAR) / 2])) for one in ratio)
    # N P_c goes as w A0/h_rms.
    smooth = tension * (pulling["range"] / pulling.rms_height).to_numpy()
    by = (spearmanr(ratio, values).statistic for values in (tension, smooth))
    return f"a factor of {np.exp(apart):.0f}", " and ".join(f"{value:.2f}" for value in by)


def within_range() -> Iterator[str]:
    """Part of the work of adhesion that lies within Δr of the minimum."""
    for name, powers_of in (("9-3", (9, 3)), ("12-6", (12, 6))):
        wall = InversePowers(powers_of, 1.0)
        least, there = (float(wall.evaluate(wall.zero_gap + gap).energy) for gap in (0.0, wall.effective_range))
        yield f"{name}: {100 * (1 - there / least):.0f} %"


def necessary(rows: DataFrame) -> str:
    """The least l_a/(h' a0) of those that stick where κ is read and δh is a0 or more."""
    sticky = rows[rows.reference & (rows.load < 0) & (rows.rms_slope**2 / rows.rms_curvature >= 1)]
    return f"{(sticky.length / sticky.rms_slope).min():.2f} of {len(sticky)}" if len(sticky) else "none sticks"


def lines() -> Iterator[str]:
    """A table, by claim and sweep."""
    yield "| what | sweep | found |\n|---|---|---|"
    for name, said in SWEEPS.items():
        for between, found in powers(points(name)):
            yield f"| exponent of w in 1/κ_att, {between} | {said} | {found} |"
    for name, said in SWEEPS.items():
        yield f"| least l_a/(h' a0) that sticks, δh of a0 or more | {said} | {necessary(points(name))} |"
    for name, said in SWEEPS.items():
        if found := tensions(points(name)):
            yield f"| largest tensions over N P_c apart, at one h_rms/δ_c within 10 % | {said} | {found[0]} |"
            yield f"| rank correlation with h_rms/δ_c, of tensions over N P_c and over w A0/Δr | {said} | {found[1]} |"
    yield f"| binding energy within Δr | exact | {', '.join(within_range())} |"


if __name__ == "__main__":
    sys.stdout.write("\n".join(lines()) + "\n")
