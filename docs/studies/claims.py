"""Claims of the paper that no sweep was made for, from the stored points of others: ``python -m docs.studies.claims``.

The power of w with which 1/κ_att rises; how many systems of one h_rms/δ_c pull, and whether w A0/Δr orders tensions
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
from continuum.theory import paper
from docs.studies.tables import points_of

SWEEPS = {"figure2-4096": "4096², λ_L/λ_s = 64", "figure4-1024": "1024², 16 to 128", "figure4-2048": "2048², 16"}
MANY = ("figure4-1024", "figure4-2048")
"""Sweeps of many surfaces."""


def points(name: str) -> DataFrame:
    """Those on approach with enough asperities."""
    rows = read_csv(points_of(name))
    return rows[rows.approach & rows.valid]


def powers(rows: DataFrame) -> Iterator[tuple[str, str]]:
    """Exponent of w in 1/κ_att between neighbouring l_a of a surface, with its 95 % interval."""
    chosen = rows[rows.reference & (rows.length > 0)]
    table = np.log(chosen.pivot_table(index="surface", columns="length", values="kappa_att"))
    for low, high in zip(table.columns, table.columns[1:], strict=False):
        each = ((table[low] - table[high]) / np.log(high / low)).replace([np.inf, -np.inf], np.nan).dropna()
        half = t.ppf(0.975, len(each) - 1) * each.std() / np.sqrt(len(each))
        yield f"l_a = {low:g} to {high:g}", f"{each.mean():.2f} ± {half:.2f} of {len(each)} surfaces"


def tensions(rows: DataFrame) -> tuple[str, str]:
    """What h_rms/δ_c tells of the largest tension on approach, over all systems with adhesion.

    Returns how many pull and how many never do at one h_rms/δ_c: from the least at which some never do to the largest
    at which some pull.  And the rank correlation of the tension with it, by N P_c and by w A0/Δr, in which those that
    never pull share the lowest rank.
    """
    found = largest_tension(rows)
    ratio, pulls = found.ratio, found.tension > 0
    low, high = ratio[~pulls].min(), ratio[pulls].max()
    inside = ratio.between(low, high)
    both = f"{low:.1f} to {high:.1f}: {(inside & pulls).sum()} pull, {(inside & ~pulls).sum()} never do"
    # N P_c goes as w A0/h_rms.
    smooth = found.tension * found["range"] / found.rms_height
    by = " and ".join(f"{spearmanr(ratio, values).statistic:.2f}" for values in (found.tension, smooth))
    return both if low < high else "none", by


def within_range() -> Iterator[str]:
    """Part of the work of adhesion that lies within Δr of the minimum."""
    for name, powers_of in (("9-3", (9, 3)), ("12-6", (12, 6))):
        wall = InversePowers(powers_of, 1.0)
        least, there = (float(wall.evaluate(wall.zero_gap + gap).energy) for gap in (0.0, wall.effective_range))
        yield f"{name}: {100 * (1 - there / least):.0f} %"


def necessary(rows: DataFrame) -> str:
    """The least l_a/(h' a0) of those that stick where κ is read and δh is a0 or more."""
    tall = rows[rows.reference & (rows.length > 0) & (rows.rms_slope**2 / rows.rms_curvature >= 1)]
    sticky = tall[tall.load < 0]
    least = f"{(sticky.length / sticky.rms_slope).min():.2f}" if len(sticky) else "-"
    return f"{least}; {len(sticky)} of {len(tall)} stick"


def maugis(rows: DataFrame) -> float:
    """Largest λ_Maugis of the contacts at which κ is read, with the measured d_rep."""
    adhesive = rows[rows.reference & (rows.area_att > 0)]
    measured = zip(adhesive.diameter / (2 * adhesive.rms_slope), adhesive.length, adhesive["range"], strict=True)
    return max(paper.maugis_parameter(*each) for each in measured)


def lines() -> Iterator[str]:
    """A table, by claim and sweep."""
    yield "| what | sweep | found |\n|---|---|---|"
    for name, said in SWEEPS.items():
        for between, found in powers(points(name)):
            yield f"| exponent of w in 1/κ_att, {between} | {said} | {found} |"
    for name, said in SWEEPS.items():
        yield f"| least l_a/(h' a0) that sticks, δh of a0 or more | {said} | {necessary(points(name))} |"
    for name in MANY:
        rows, said = points(name), f"{SWEEPS[name]}, {largest_tension(points(name)).system.nunique()} systems"
        both, by = tensions(rows)
        yield f"| h_rms/δ_c at which some pull and others never do | {said} | {both} |"
        yield f"| rank correlation with h_rms/δ_c, of tensions over N P_c and over w A0/Δr | {said} | {by} |"
    for name, said in SWEEPS.items():
        yield f"| largest λ_Maugis at 1 % | {said} | {maugis(points(name)):.2f} |"
    yield f"| binding energy within Δr | exact | {', '.join(within_range())} |"


if __name__ == "__main__":
    sys.stdout.write("\n".join(lines()) + "\n")
