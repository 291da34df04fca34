"""The systems of Figure 4 at 512² to 2048², from their stored points: ``python -m docs.studies.figure4``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache

import numpy as np
from pandas import DataFrame, Series, concat, read_csv

from continuum.paper.claims import stored_points
from docs.studies.judgement import MEASURED
from docs.studies.tables import points_of

SWEEPS = {"figure4-reduced": "512²", "figure4-1024": "1024²", "figure4-2048": "2048²"}
WEAK = 0.005
"""Largest l_a of the table of ratios, in a0; under stronger adhesion few contacts have A_att < A_rep."""


@cache
def points(name: str) -> DataFrame:
    """Points with enough asperities."""
    rows = stored_points(points_of(name))
    return rows[rows.valid].assign(width=(rows.lambda_L / rows.lambda_s).round().astype(int))


def at_one_percent(name: str) -> DataFrame:
    """The point of each system at which κ is read: the first on approach from 1 % of the area on."""
    rows = points(name)
    return rows[rows.reference & rows.approach]


def geometric(values: Series) -> float:
    return float(np.exp(np.log(values).mean()))


def ratios() -> Iterator[str]:
    """Geometric means of what is measured over theory, by bandwidth and size."""
    yield "| λ_L/λ_s | λ_L, λ_s | systems | 1/κ_att | A_rep/A_att | d_rep |\n|---|---|---|---|---|---|"
    rows = concat([at_one_percent(name) for name in ("figure4-1024", "figure4-2048")])
    rows = rows[(rows.length > 0) & (rows.length <= WEAK) & (rows.area_att < rows.area_rep)]
    for (width, lambda_L), part in rows.groupby(["width", "lambda_L"]):
        ratio = part.area_rep / part.area_att / part.expected_ratio
        cells = (part.expected_kappa_att / part.kappa_att, ratio, part.diameter_ratio)
        means = " | ".join(f"{geometric(values):.2f}" for values in cells)
        yield f"| {width} | {lambda_L:g}, {part.lambda_s.iloc[0]:g} | {len(part)} | {means} |"


def sticky() -> Iterator[str]:
    """How many stick, and how many of them theory misses, with κ_rep = 2 and as measured."""
    yield (
        "| grid | systems | stick | missed with κ_rep = 2 | their λ_s | missed with κ_rep as measured "
        "| said to stick, do not: κ_rep = 2; as measured |\n|---|---|---|---|---|---|---|"
    )
    for name, grid in SWEEPS.items():
        rows = at_one_percent(name).query("length > 0")
        pulls, said = rows.load < 0, 1 / rows.expected_kappa_att
        two, own = said > 0.5, said > 1 / rows.kappa_rep
        counts = rows[pulls & ~two].lambda_s.value_counts().sort_index()
        sizes = ", ".join(f"{size:g}: {count}" for size, count in counts.items())
        yield (
            f"| {grid} | {len(rows)} | {pulls.sum()} | {(pulls & ~two).sum()} | {sizes} | {(pulls & ~own).sum()} "
            f"| {(two & ~pulls).sum()}; {(own & ~pulls).sum()} |"
        )


def kappa_rep() -> str:
    """κ_rep without adhesion, by λ_s."""
    rows = concat([at_one_percent(name) for name in ("figure4-1024", "figure4-2048")]).query("length == 0")
    means = 1 / (1 / rows.kappa_rep).groupby(rows.lambda_s).mean()
    return ", ".join(f"{value:.1f} at λ_s = {size:g}" for size, value in means.items())


def off_by_two(name: str) -> str:
    """Points whose d_rep is not within a factor of two of 4h'/h''."""
    rows = points(name).query("diameter > 0")
    return f"{(~rows.diameter_ratio.between(0.5, 2)).sum()} of {len(rows)}"


def roll_off() -> str:
    """1/κ at the shortest and the longest λ_L of one period, l_a = 0.005."""
    rows = read_csv(MEASURED / "paper-lambda-L-reduced-lambda-L.csv")
    rows = rows[rows["l_a (a0)"] == WEAK].sort_values("surface.lambda_L")
    ends = (f"{row['1/kappa']:.2f} at λ_L = {row['surface.lambda_L']:g}" for _, row in rows.iloc[[0, -1]].iterrows())
    return " to ".join(ends)


if __name__ == "__main__":
    sys.stdout.write("\n".join([*ratios(), "", *sticky(), "", kappa_rep(), roll_off(),
                                off_by_two("figure4-1024"), off_by_two("figure4-2048")]) + "\n")  # fmt: skip
