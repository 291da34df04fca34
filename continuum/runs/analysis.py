"""Measurements on the stored points of a run, with the paper's predictions beside them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from continuum.measure.contact import Measurement, measure
from continuum.measure.curve import Adhesion, Curve, adhesion, normal_stiffness
from continuum.measure.outline import Areas, Mask, areas, patches
from continuum.measure.profile import (
    Distribution,
    GapProfile,
    gap_distribution,
    gap_profile,
    pressure_distribution,
)
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall
from continuum.runs.record import Point
from continuum.runs.result import Result
from continuum.theory import paper
from continuum.theory.paper import ExpectedContact

if TYPE_CHECKING:
    from continuum.show.sheet import Sheet


@dataclass(frozen=True, eq=False)
class FieldMeasurement:
    """Measurements that need the gap at each point."""

    areas: Areas
    profile: GapProfile
    """Mean gap above zero_gap, up to twice the mean diameter from the edge."""
    width: float
    """d_att, in a0: where the mean gap above zero_gap reaches the range; NaN without attraction."""
    expected_width: float
    """d_att of Eq. (S-2) with the measured d_rep, in a0."""
    gap_ratio: tuple[float, float]
    """Smallest and largest ratio of the mean gap to Eq. (S-1), see :func:`gap_ratio`."""
    gaps: Distribution
    pressures: Distribution | None
    """None under a hard wall, as the traction is not stored and does not follow from the gap."""


@dataclass(frozen=True, eq=False)
class MeasuredPoint:
    """A stored equilibrium with its measurements."""

    step: int
    """Its index on the path."""
    point: Point
    numbers: Measurement
    patch_areas: Real
    """Area of each connected patch of A_rep, in a0²."""
    stiffness: float
    """k_N = -dN/d(mean gap), in E*/a0."""
    fields: FieldMeasurement | None
    """None where the run did not store gaps."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """A stored run with all its measurements."""

    result: Result
    expected: ExpectedContact
    """Predictions of the paper for the undeformed surface and the wall; lengths in a0, pressures in E*."""
    points: tuple[MeasuredPoint, ...]
    """The equilibria, in the order of the path."""
    adhesion: Adhesion | None
    """Pull-off and work of separation; None without equilibria."""
    notes: tuple[str, ...]
    """Missing measurements, with a remedy."""

    def __repr__(self) -> str:
        return f"Analysis({self.result!r})"

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())

    def sheets(self) -> list[Sheet]:
        """Each point, and the run as a whole."""
        from continuum.show.runs import analysis_sheets

        return analysis_sheets(self)

    def plot(self, folder: Path | None = None) -> list[Path]:
        """Draw its figures, beside the run or into a folder; returns the PNG files."""
        from continuum.show.run_figures import draw_analysis

        return draw_analysis(self, folder)


def analyse_run(result: Result) -> Analysis:
    """Measure every equilibrium of a stored run."""
    good = [(step, point) for step, point in enumerate(result.points) if point.converged]
    notes = []
    if result.wall.law is None:
        notes.append("no distribution of pressures: under a hard wall they do not follow from the stored data")
    if missing := len(result.points) - len(good):
        notes.append(f"{missing} points that did not converge are left out")
    if not result.finished:
        notes.append("the run is not finished: `continuum run` with its input continues it")
    if result.points and result.gap(0) is None:
        notes.append(
            "areas under other definitions, gap profile, d_att and distributions need the gap at each point, which "
            "this run did not store: set fields = true in [output] of its input and run it again into the same folder"
        )
    curve = Curve.of([point for _, point in good])
    moments, wall = result.moments, result.wall
    expected = ExpectedContact(moments.rms_slope, moments.rms_curvature, wall.range, wall.work_of_adhesion)
    each = zip(good, normal_stiffness(curve).tolist(), strict=True)
    points = tuple(_measured(result, step, point, stiffness) for (step, point), stiffness in each)
    return Analysis(result, expected, points, adhesion(curve) if good else None, tuple(notes))


def _measured(result: Result, step: int, point: Point, stiffness: float) -> MeasuredPoint:
    repulsive, slope = result.repulsive(step), result.moments.rms_slope
    numbers, gap = measure(result.grid, point, repulsive, slope), result.gap(step)
    found = None if gap is None else _fields(result.grid, result.wall, gap, repulsive, numbers)
    return MeasuredPoint(step, point, numbers, patches(result.grid, repulsive).areas, stiffness, found)


def _fields(grid: Grid, wall: Wall, gap: Real, repulsive: Mask, numbers: Measurement) -> FieldMeasurement:
    slope, edge = numbers.rms_slope, bool(np.isfinite(numbers.diameter))  # full contact has none
    profile = profile_outside(grid, wall, gap, repulsive, numbers.diameter)
    return FieldMeasurement(
        areas(grid, wall, gap),
        profile,
        profile.width(wall.range) if wall.range > 0 else np.nan,
        paper.attraction_width(slope, numbers.diameter, wall.range) if edge and wall.range > 0 else np.nan,
        gap_ratio(profile, slope, numbers.diameter),
        gap_distribution(grid, gap),
        None if wall.law is None else pressure_distribution(grid, wall, gap),
    )


def profile_outside(grid: Grid, wall: Wall, gap: Real, repulsive: Mask, diameter: float) -> GapProfile:
    """Mean gap above zero_gap outside a contact, up to twice its mean diameter."""
    # Farther out it is the gap between patches; the limit also bounds the memory for the margin of the map.
    reach = 2 * diameter if np.isfinite(diameter) else 0.0
    farthest = min(max(reach, 16 * grid.widest_step), grid.shortest_period / 8)
    return gap_profile(grid, gap, repulsive, farthest, wall.zero_gap)


def gap_ratio(
    profile: GapProfile, rms_slope: float, diameter: float, *, from_perimeter_cells: bool = False
) -> tuple[float, float]:
    """Smallest and largest ratio of a mean gap to Eq. (S-1) with the measured d_rep, for 2 a0 <= x <= d_rep/4.

    Parameters
    ----------
    profile : gap profile above zero_gap.
    rms_slope, diameter : h'rms and the measured d_rep.
    from_perimeter_cells : count x from the centres of the perimeter cells instead of the edge.

    Returns
    -------
    lowest, highest : NaN if no distance lies in that interval.
    """
    x = profile.from_perimeter_cells if from_perimeter_cells else profile.distance
    near = (x >= 2) & (x <= diameter / 4)
    if not near.any():
        return np.nan, np.nan
    ratio = profile.gap[near] / paper.gap_outside_contact(x[near], rms_slope, diameter)
    return float(ratio.min()), float(ratio.max())
