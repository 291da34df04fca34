"""Figure 4 from surfaces pressed once without adhesion: ``python -m docs.studies.kappa_of_one_state``.

The surfaces of the sweep ``figure4`` on 1024² points, of both slopes, at 1 and 4 % of the area, beside the
points that were measured with adhesion (``docs/measured/paper-figure4-1024-points.csv``).  Of each state without
adhesion follow, for each law, the load, and so κ, by both terms of :mod:`continuum.path.threshold`; A_att by the gaps;
and what Eq. (4) says of it from the measured diameter.  With ``--run`` all are pressed, ten minutes on one core, and
``one-state-kappa.csv`` is written; without it that file is read.

The last table asks of all stored sweeps of Figure 4 and of Figure 2, 512² to 4096², whether the diameter of contacts,
and A_rep/A_att, follow the bandwidth or the points to λ_s.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator

import numpy as np
from pandas import DataFrame, concat, read_csv

import continuum as c
from continuum.measure.outline import perimeter_map
from continuum.model.grid import Grid
from continuum.model.surface import moments
from continuum.model.walls import LennardJonesSpline
from continuum.path.threshold import PressedState, press_without_adhesion
from continuum.theory import paper
from docs.studies.judgement import MEASURED

N, LONG, AREAS = 1024, 512.0, (0.01, 0.04)
LENGTHS = (0.0005, 0.005, 0.05)
SURFACE = ("seed", "lambda_s", "hurst", "slope")
FILE = MEASURED / "one-state-kappa.csv"


def row(state: PressedState, slope: float, curvature: float, length: float) -> dict[str, float]:
    """What a state says of a law, per h' E* A_rep: loads; the attracted area over the repulsive one."""
    wall = LennardJonesSpline(adhesion_length=length)
    response = state.response(*state.attraction(wall))
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


def rows(there: set[tuple[float, ...]]) -> Iterator[list[dict[str, float]]]:
    """Every measured point at these areas, with what the state without adhesion says, surface by surface."""
    points = read_csv(MEASURED / "paper-figure4-1024-points.csv")
    points = points[points.approach & points.valid]
    grid = Grid.square(N)
    slopes = points["sweep.surface.rms_slope"]
    for (seed, lambda_s, hurst, slope), part in points.groupby([points.seed, points.lambda_s, points.hurst, slopes]):
        surface = seed, lambda_s, hurst, slope
        if surface in there:
            continue
        heights = c.SelfAffine(hurst, slope, lambda_s, LONG).synthesise(grid, np.random.default_rng(seed))
        made, found = moments(grid, heights), []
        problem = c.Contact(heights, c.HardWall(), c.HalfSpace("clamped"), tolerance=1e-4)
        for area in AREAS:
            nearest = part.iloc[(part.area_rep / area).apply(lambda x: abs(np.log(x))).argsort()]
            state = press_without_adhesion(problem.problem, area, problem.settings, 0.5)
            for length in LENGTHS:
                near = nearest[nearest.length == length]
                if near.empty or not 0.7 < near.area_rep.iloc[0] / area < 1.4:
                    continue
                at = near.iloc[0]
                said = row(state, made.rms_slope, made.rms_curvature, length)
                found.append({
                    **dict(zip(SURFACE, surface, strict=True)), "area": area, "length": length,
                    "inverse": 1 / at.kappa, "inverse_rep": 1 / at.kappa_rep, "inverse_att": 1 / at.kappa_att,
                    "measured_ratio": at.area_rep / at.area_att, **said,
                })  # fmt: skip
        sys.stderr.write(f"{surface}\n")
        yield found


def run() -> None:
    """Add the surfaces that are missing."""
    found = read_csv(FILE)
    for more in rows(set(found[list(SURFACE)].itertuples(index=False, name=None))):
        found = concat([found, DataFrame(more)], ignore_index=True)
        found.to_csv(FILE, index=False, float_format="%.6g", lineterminator="\n")


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


def taken(found: DataFrame) -> Iterator[str]:
    """What adhesion takes from 1/κ, measured and by one state, and A_rep/A_att over that of the gaps."""
    points = read_csv(MEASURED / "paper-figure4-1024-points.csv")
    free = points[points.approach & points.valid & (points.length == 0)].rename(
        columns={"sweep.surface.rms_slope": "slope"}
    )
    yield "| l_a | h' | points, surfaces | 1/κ without adhesion less that with it | by one state | rms difference | A_rep/A_att over that of the gaps, scatter |"  # noqa: E501
    yield "|---|---|---|---|---|---|---|"
    for (length, slope), part in found.groupby(["length", "slope"]):
        measured = []
        for row in part.itertuples():
            same = np.logical_and.reduce([free[name] == getattr(row, name) for name in SURFACE])
            away = np.abs(np.log(free[same].area_rep / row.area))
            measured.append(1 / free.kappa[away.idxmin()] - row.inverse)
        said = part.zero - part.two_terms
        off, ratio = np.sqrt(((measured - said) ** 2).mean()), np.log(part.measured_ratio / part.ratio)
        surfaces = len(part.drop_duplicates(list(SURFACE)))
        yield (
            f"| {length:g} | {slope:g} | {len(part)}, {surfaces} | {np.mean(measured):.3f} | {said.mean():.3f} "
            f"| {off:.3f} | {np.exp(ratio.mean()):.2f}, {np.exp(ratio.std()):.2f} |"
        )


SWEEPS = ("4-reduced", "4-1024", "4-2048", "2-4096")


def drifts() -> Iterator[str]:
    """Of the diameter and of A_rep/A_att over Eq. (4): what the bandwidth does, and the points to λ_s.

    ln y is fitted by ln of the bandwidth, of h', and one over the points to λ_s, as a counted patch is wider by about a
    point.  Of the sweeps of 512² to 4096² points together, in which one bandwidth has several λ_s, below 3 % of the
    area.
    """
    points = concat([read_csv(MEASURED / f"paper-figure{name}-points.csv") for name in SWEEPS], ignore_index=True)
    points = points[points.approach & points.valid & (points.area_rep < 0.03)]
    points = points.assign(bandwidth=np.log(points.lambda_L / points.lambda_s), points=1 / points.lambda_s)
    adhesive = points[points.length == LENGTHS[0]]
    ratio = np.log(adhesive.area_rep / adhesive.area_att / adhesive.expected_ratio)
    free = points[points.length == 0]
    asked = {
        "d_rep over 4h'/h''": free.assign(y=np.log(free.diameter_ratio)),
        "A_rep/A_att over Eq. (4)": adhesive.assign(y=ratio),
        "the same, with d_rep as measured": adhesive.assign(y=ratio - 2 / 3 * np.log(adhesive.diameter_ratio)),
    }
    yield "| H | | points | eight times the bandwidth | 4 points to λ_s over 32 | scatter |"
    yield "|---|---|---|---|---|---|"
    for name, part in asked.items():
        for hurst, of in part.groupby("hurst"):
            terms = np.column_stack([np.ones(len(of)), of.bandwidth, of.points, np.log(of.rms_slope)])
            fitted, *_ = np.linalg.lstsq(terms, of.y.to_numpy(), rcond=None)
            left, reduced = np.exp(np.std(of.y - terms @ fitted)), np.exp(fitted[2] * (1 / 4 - 1 / 32))
            yield f"| {hurst:g} | {name} | {len(of)} | {8 ** fitted[1]:.2f} | {reduced:.2f} | {left:.2f} |"


def main() -> None:
    """Print measured over computed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", action="store_true", help="press the surfaces that are missing in the file")
    if parser.parse_args().run:
        run()
    sys.stdout.write("\n".join((*taken(read_csv(FILE)), "", *tables(read_csv(FILE)), "", *drifts())) + "\n")


if __name__ == "__main__":
    main()
