"""The paper's own system, 4096² points, from its stored points: ``python -m docs.studies.figure2``.

With ``--figure`` the table of Figure 2 is made from them, too; ``python -m docs.studies.redraw`` draws it.

Means over three surfaces of each area that was asked for; 1/κ is averaged, as κ diverges where surfaces become sticky.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from pandas import DataFrame, concat, read_csv

from continuum.paper.claims import stored_points
from continuum.paper.figures import FIGURES
from docs.studies.judgement import MEASURED, held, spread, verdict

LENGTHS = (0.0, 0.0005, 0.005, 0.05)
OFF = 0.3
"""How far, in its logarithm, an area may be from the one that was asked for."""


def lines() -> Iterator[str]:
    """κ_rep without adhesion, 1/κ, A_rep/A_att over Eq. (4), and the mean diameter over 4h'/h'', by area."""
    points = read_csv(MEASURED / "paper-figure2-4096-points.csv").query("approach and valid")
    # Areas of 0.25 % and its doublings are met to 30 %.
    points = points.assign(
        target=0.0025 * 2 ** np.round(np.log2(points.area_rep / 0.0025)),
        ratio=points.area_rep / points.area_att / points.expected_ratio,
        inverse=1 / points.kappa,
        inverse_rep=1 / points.kappa_rep,
    )
    said = "; ".join(f"{length:g}" for length in LENGTHS)
    yield f"| area | κ_rep, l_a = 0 | 1/κ: {said} | A_rep/A_att over Eq. (4): {said[3:]} | d_rep h''/(4h'), all |"
    yield "|---|---|---|---|---|"
    for target, part in points.groupby("target"):
        means = part.groupby("length")[["inverse", "inverse_rep", "ratio"]].mean()
        cells = (
            f"{100 * target:g} %", f"{1 / means.inverse_rep[0.0]:.2f}",
            "; ".join(f"{means.inverse[length]:.3f}" for length in LENGTHS),
            "; ".join(f"{means.ratio[length]:.2f}" for length in LENGTHS[1:]), f"{part.diameter_ratio.mean():.2f}",
        )  # fmt: skip
        yield f"| {' | '.join(cells)} |"


AREAS = (0.01, 0.02, 0.045, 0.095, 0.14)
"""Areas that the paths to 14 % and back were to meet, over A0."""


def cycles() -> DataFrame:
    """A point for each surface, length, way and area of the paths to 14 % and back."""
    points = read_csv(MEASURED / "figure2-4096-cycles.csv")
    off = np.abs(np.log(points.area_rep.to_numpy()[:, None] / np.array(AREAS)))
    points = points.assign(
        target=np.array(AREAS)[off.argmin(axis=1)], off=off.min(axis=1), tension=-points.load / points.rms_slope,
        ratio=points.area_rep / points.area_att / points.expected_ratio, inverse=1 / points.kappa,
    )  # fmt: skip
    nearest = points.sort_values("off").drop_duplicates(["length", "seed", "approach", "target"])
    return nearest[nearest.off < OFF]


def returns() -> Iterator[str]:
    """1/κ there and back at each area, means over surfaces."""
    rows = cycles()
    yield "| l_a | area | surfaces | 1/κ there | 1/κ back | A_rep/A_att over Eq. (4) there | d_rep h''/(4h') there |"
    yield "|---|---|---|---|---|---|---|"
    for (length, target), part in rows.groupby(["length", "target"]):
        there, back = part[part.approach], part[~part.approach]
        yield (
            f"| {length:g} | {100 * target:g} % | {there.seed.nunique()} | {spread(there.inverse)} "
            f"| {spread(back.inverse)} | {spread(there.ratio[there.area_att > 0])} "
            f"| {spread(there.diameter_ratio)} |"
        )


STEM = MEASURED / "paper-figure2-4096-figure2"
"""Figure 2 at the paper's own size: its table, and what is drawn of it."""


def drawn() -> DataFrame:
    """The numbers of Figure 2: the paths to 14 % and back and, at the lengths without them, the approach."""
    there = stored_points(MEASURED / "paper-figure2-4096-points.csv")
    whole = stored_points(MEASURED / "figure2-4096-cycles.csv")
    rows = concat([there[~there.length.isin(whole.length)], whole], ignore_index=True)
    return FIGURES["figure2"].numbers(rows.sort_values(["length", "seed"], kind="stable"))


def judged() -> Iterator[str]:
    """What became of the statements of the paths to 14 % and back."""
    rows = cycles()

    def at(length: float, target: float, column: str, *, approach: bool = True) -> np.ndarray:
        part = rows[(rows.length == length) & (rows.target == target) & (rows.approach == approach)]
        return part.sort_values("seed")[column].to_numpy()

    def said(values: np.ndarray, expected: float, bound: float) -> str:
        if len(values) == 0:
            return "**not tested**"
        return f"{values.mean():.3g} for {expected} ± {bound}, **{verdict(values, expected, bound)}**"

    strong = 0.05
    there, back = at(strong, 0.01, "inverse"), at(strong, 0.01, "inverse", approach=False)
    more = int((back < there).sum())
    yield (
        f"* 8: at 1 % {more} of {len(back)} surfaces pull more on the way back than on approach, "
        f"**{held(more == len(back))}**; the mean of 1/κ there is {said(back, -0.15, 0.15)}."
    )
    yield (
        f"* 10: κ_rep is {said(at(0.0, 0.045, 'kappa'), 2.22, 0.06)}, at 4.5 %, and "
        f"{said(at(0.0, 0.14, 'kappa'), 2.15, 0.05)}, at 14 %."
    )
    yield (
        f"* 11: d_rep over 4h'/h'' is {said(at(0.0, 0.045, 'diameter_ratio'), 1.0, 0.06)}, at 4.5 %, and "
        f"{said(at(0.0, 0.14, 'diameter_ratio'), 1.12, 0.06)}, at 14 %."
    )
    yield (
        f"* 12: A_rep/A_att over Eq. (4) is {said(at(0.005, 0.045, 'ratio'), 1.08, 0.08)}, at 4.5 %, and "
        f"{said(at(0.005, 0.14, 'ratio'), 1.22, 0.08)}, at 14 %."
    )
    changes = [
        np.abs(at(0.0, target, "inverse") - at(0.0, target, "inverse", approach=False)) for target in AREAS[:3:2]
    ]
    change = float(np.concatenate(changes).max(initial=0.0))
    bare = f"changes by {change:.4f} at most, **{held(change <= 0.005)}**"
    if not changes[0].size:
        bare = "is **not tested**"
    less = at(0.005, 0.01, "inverse") - at(0.005, 0.01, "inverse", approach=False)
    yield (f"* 13: without adhesion 1/κ {bare}; at 0.005 it is less by {said(less, 0.02, 0.02)}, at 1 %.")
    largest = rows[rows.length == strong].sort_values("tension").groupby("seed").tail(1).sort_values("seed")
    as_said = (~largest.approach & largest.area_rep.between(0.03, 0.14)).all()
    inside = largest.tension.between(0.005, 0.035).all()
    where = "; ".join(
        f"{-row.tension:.4f} at {100 * row.area_rep:.1f} % {'there' if row.approach else 'back'}"
        for row in largest.itertuples()
    )
    yield f"* 14: from 1 % on the smallest loads, in h' E* A0, are {where}: **{held(as_said and inside)}**."


if __name__ == "__main__":
    if sys.argv[1:] == ["--figure"]:
        drawn().to_csv(STEM.with_suffix(".csv"), index=False, lineterminator="\n")
    sys.stdout.write("\n".join([*lines(), "", *returns(), "", *judged()]) + "\n")
