"""What the size of the period changes, from its stored points: ``python -m docs.studies.finite_size``.

Means over surfaces at 1 % of the area; 1/κ is averaged, as κ diverges where surfaces become sticky.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from pandas import DataFrame, read_csv

from docs.studies.judgement import MEASURED, held, spread, verdict

SAID = {16: (2.95, 0.2), 32: (2.70, 0.12), 64: (2.52, 0.08), 128: (2.40, 0.08), 256: (2.30, 0.08)}
"""κ_rep without adhesion and its bound, at each bandwidth."""
LOWERED, CLOSE = (0.125, 0.03), 0.03
LENGTH = 0.005


def stored() -> DataFrame:
    """One row a surface and bandwidth, ``kappa`` without adhesion and 1/κ of both lengths."""
    points = read_csv(MEASURED / "paper-finite-size-points.csv").query("approach")
    points = points.assign(width=(points.lambda_L / points.lambda_s).astype(int), inverse=1 / points.kappa)
    found = points.pivot(index=["width", "seed"], columns="length", values="inverse")
    return DataFrame({"kappa": 1 / found[0.0], "without": found[0.0], "adhesive": found[LENGTH]}).reset_index()


def lines() -> Iterator[str]:
    """A row for each period: κ_rep as said and as found, and 1/κ."""
    yield "| points | λ_L/λ_s | surfaces | κ_rep, l_a = 0 | said | | 1/κ, l_a = 0 | 1/κ, l_a = 0.005 | difference |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for width, part in stored().groupby("width"):
        said, bound = SAID[width]
        means = (spread(part[name]) for name in ("without", "adhesive"))
        yield (
            f"| {32 * width}² | {width} | {len(part)} | {part.kappa.mean():.2f} | {said} ± {bound} "
            f"| {verdict(part.kappa.to_numpy(), said, bound)} | {' | '.join(means)} "
            f"| {(part.without - part.adhesive).mean():.3f} |"
        )


def judged() -> Iterator[str]:
    """What became of each statement."""
    rows = stored()
    kappa = rows.groupby("width").kappa.mean()
    # One surface is compared with itself: the mean of three is another.
    last = rows[rows.seed.isin(rows[rows.width == 256].seed)].set_index("width")
    falling = bool((np.diff(kappa[:-1]) < 0).all() and last.kappa[256] < last.kappa[128])
    yield f"* 1: the five values are judged in the table; κ_rep falls with each doubling: **{held(falling)}**."
    lowered = (rows.without - rows.adhesive).groupby(rows.width)
    first = verdict(lowered.get_group(64).to_numpy(), *LOWERED)
    ends = [abs(lowered.mean()[width] - lowered.mean()[64]) for width in (128, 256)]
    yield (
        f"* 2: **{first}**, and by the same to {ends[0]:.3f} at 128 and {ends[1]:.3f} at 256: "
        f"**{held(max(ends) <= CLOSE)}**."
    )
    changes = [abs(last[name][256] - last[name][128]) for name in ("without", "adhesive")]
    yield (
        f"* 3: of the one surface of both sizes 1/κ changes by {changes[0]:.3f} without and {changes[1]:.3f} with "
        f"adhesion: **{held(max(changes) < CLOSE)}**, of one surface."
    )
    apart = rows.groupby("width")[["without", "adhesive"]].std()
    shares = (apart.loc[128] / apart.loc[16]).tolist()
    said = [f"**{held(share < 1 / 2)}**" for share in shares]
    yield (
        f"* 4, of 4096²: the standard deviation is {shares[0]:.2f} of that of 512² without adhesion, {said[0]}, "
        f"and {shares[1]:.2f} with it, {said[1]}."
    )


if __name__ == "__main__":
    sys.stdout.write("\n".join([*lines(), "", *judged()]) + "\n")
