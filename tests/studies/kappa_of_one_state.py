"""Figure 4 from surfaces pressed once without adhesion: ``python -m tests.studies.kappa_of_one_state``.

The surfaces of the sweep ``figure4`` on 1024² points, seed 1, of both slopes, at 1 and 4 % of the area, beside the
points that were measured with adhesion (``docs/measured/paper-figure4-1024-points.csv``).  Of each state without
adhesion follow, for each law, the load, and so κ, by both terms of :mod:`continuum.path.threshold`; A_att by the gaps;
and what Eq. (4) says of it from the measured diameter.  Three minutes on one core.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from pandas import DataFrame, read_csv

import continuum as c
from continuum.measure.outline import perimeter_map
from continuum.model.grid import Grid
from continuum.model.surface import moments
from continuum.model.walls import LennardJonesSpline
from continuum.path.threshold import PressedState, press_without_adhesion
from continuum.theory import paper
from tests.studies.judgement import MEASURED

N, LONG, SEED, AREAS = 1024, 512.0, 1, (0.01, 0.04)
LENGTHS = (0.0005, 0.005, 0.05)


def row(state: PressedState, slope: float, curvature: float, length: float) -> dict[str, float]:
    """What a state says of a law, per h' E* A_rep: loads; the attracted area over the repulsive one."""
    wall = LennardJonesSpline(adhesion_length=length)
    response = state._response(*state.attraction(wall))
    unit, w = slope * state.area_rep, wall.work_of_adhesion
    attracted = float(((state.distance >= 0) & (state.distance < wall.range)).mean())
    ring = float(perimeter_map(state.contact).mean()) * paper.PERIMETER_FACTOR_PAPER
    diameter = np.pi * state.area_rep / ring
    return {
        "zero": state.load / unit,
        "one_term": (state.load - w * state.grid.mean(state.attraction(wall)[0])) / unit,
        "two_terms": (state.load + response.first * w + response.second * w**2) / unit,
        "pull": w * state.grid.mean(state.attraction(wall)[0]) / unit,
        "ratio": attracted and state.area_rep / attracted,
        # Eq. (4) with the diameter of this contact, in place of 4 h'/h''.
        "eq4": paper.area_ratio(slope, paper.contact_diameter(slope, curvature), wall.effective_range),
        "eq4_own": paper.area_ratio(slope, diameter, wall.effective_range),
    }


def rows() -> Iterator[dict[str, float]]:
    """Every measured point at these areas, with what the state without adhesion says."""
    points = read_csv(MEASURED / "paper-figure4-1024-points.csv")
    points = points[points.approach & points.valid & (points.seed == SEED)]
    grid = Grid.square(N)
    slopes = points["sweep.surface.rms_slope"]
    for (lambda_s, hurst, slope), part in points.groupby([points.lambda_s, points.hurst, slopes]):
        heights = c.SelfAffine(hurst, slope, lambda_s, LONG).synthesise(grid, np.random.default_rng(SEED))
        made = moments(grid, heights)
        problem = c.Contact(heights, c.HardWall(), c.HalfSpace("clamped"), tolerance=1e-4)
        for area in AREAS:
            there = part.iloc[(part.area_rep / area).apply(lambda x: abs(np.log(x))).argsort()]
            state = press_without_adhesion(problem.problem, area, problem.settings, 0.5)
            for length in LENGTHS:
                near = there[there.length == length]
                if near.empty or not 0.7 < near.area_rep.iloc[0] / area < 1.4:
                    continue
                at = near.iloc[0]
                said = row(state, made.rms_slope, made.rms_curvature, length)
                yield {"lambda_s": lambda_s, "hurst": hurst, "slope": slope, "area": area, "length": length,
                       "inverse": 1 / at.kappa, "inverse_rep": 1 / at.kappa_rep, "inverse_att": 1 / at.kappa_att,
                       "measured_ratio": at.area_rep / at.area_att, **said}  # fmt: skip
        sys.stderr.write(f"{lambda_s} {hurst} {slope}\n")


def main() -> None:
    """Print measured over computed."""
    found = DataFrame(rows())
    found.to_csv(MEASURED / "one-state-kappa.csv", index=False, float_format="%.6g", lineterminator="\n")
    sys.stdout.write("\n".join(tables(found)) + "\n")


def tables(found: DataFrame) -> Iterator[str]:
    """Differences of 1/κ, and ratios of areas, for each law and bandwidth."""
    yield "| l_a | points | 1/κ measured - two terms: mean, rms | one term | 1/κ_att over <τ>: mean | A_rep/A_att over that of the gaps | over Eq. (4) | gaps over Eq. (4) with its own d |"  # noqa: E501
    yield "|---|---|---|---|---|---|---|---|"
    for names in (["length"], ["length", "lambda_s"]):
        for key, part in found.groupby(names):
            two, one = part.inverse - part.two_terms, part.inverse - part.one_term
            ratio = (part.inverse_att / part.pull, part.measured_ratio / part.ratio, part.measured_ratio / part.eq4,
                     part.ratio / part.eq4_own)  # fmt: skip
            yield (
                f"| {', '.join(f'{value:g}' for value in key)} | {len(part)} "
                + " ".join(f"| {x.mean():+.3f}, {np.sqrt((x**2).mean()):.3f}" for x in (two, one))
                + " "
                + " ".join(f"| {np.exp(np.log(x).mean()):.2f}, {np.exp(np.log(x).std()):.2f}" for x in ratio)
                + " |"
            )


if __name__ == "__main__":
    main()
