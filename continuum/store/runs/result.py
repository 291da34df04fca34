"""A stored run, the measurements on its points with the paper's predictions beside them, and both as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.arguments import count
from continuum.measure.contact import (
    ATTRACTED,
    REPULSIVE,
    Adhesion,
    Curve,
    Measurement,
    adhesion,
    measure,
    normal_stiffness,
)
from continuum.measure.outline import (
    Areas,
    Distribution,
    GapProfile,
    Mask,
    areas,
    gap_distribution,
    gap_profile,
    patches,
    pressure_distribution,
)
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Moments
from continuum.model.walls import Wall
from continuum.path.state import FEW_POINTS, HYSTERESIS, NEAREST, NOT_LOOKED, counts_few, not_looked_at
from continuum.store import datasets as store
from continuum.store.datasets import Attribute
from continuum.store.hdf5 import StoreError, understood
from continuum.store.identity import restored
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import EVENT_DATASETS, PathEvent, Point, events_of, frame_of, points_of
from continuum.store.sheet import Column, Sheet, Shown, pairs, words
from continuum.theory import paper
from continuum.theory.paper import ExpectedContact

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, eq=False)
class Result(Shown):
    """A run on disk: numbers in memory, maps and fields read from the file on demand.

    :func:`continuum.plot` draws its figures.

    Examples
    --------
    >>> import continuum as c
    >>> path = c.run("inputs/smoke/sphere.toml").path
    >>> result = c.Result.read(path)
    >>> result.points[0].status
    'CONVERGED'
    >>> round(float(result.to_pandas()["area_rep"].max()), 3)  # columns as in the file
    0.085
    """

    path: Path
    config: RunConfig = field(repr=False)
    """Input with defaults; of other files that it reads only the names."""
    attributes: Mapping[str, Attribute] = field(repr=False)
    points: tuple[Point, ...]
    """Points of the path, converged or not."""
    events: tuple[PathEvent, ...]
    """Jumps on the path."""
    wall: Wall
    resumed: int = 0
    """Number of points that were stored before this call."""
    seconds: float = 0.0
    """Wall time of that call."""

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a stored run; raises StoreError if the file is missing, damaged or not a run."""
        path = Path(path)
        names = {column.name for column in fields(Point)} | {*EVENT_DATASETS, "step", "wall/gap", "wall/traction"}
        file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version, names)
        with understood(path):
            knots = {name.removeprefix("wall/"): file[name] for name in file.datasets if name.startswith("wall/")}
            try:
                found = cls.of(path, file.attributes, points_of(file), events_of(file), knots)
            except KeyError as error:
                msg = f"{path}: lacks the table of its wall, which older versions did not store: run it again"
                raise StoreError(msg) from error
            # What is derived from the file later is derived once here, where damage is an error of reading.
            _ = found.identity, found.finished, found.grid, found.moments
        return found

    @classmethod
    def of(
        cls,
        path: Path,
        attributes: Mapping[str, Attribute],
        points: Sequence[Point],
        events: Sequence[PathEvent],
        knots: Mapping[str, Real],
        resumed: int = 0,
        seconds: float = 0.0,
    ) -> Self:
        """The run of what its file holds, with the knots of the law of its wall, if it has any."""
        config = restored(RunConfig, str(attributes["config_resolved"]))
        wall = config.wall.restored(knots)
        return cls(path, config, attributes, tuple(points), tuple(events), wall, resumed, seconds)

    def __repr__(self) -> str:
        good = sum(point.converged for point in self.points)
        return f"Result({str(self.path)!r}, {len(self.points)} points, {good} converged, {len(self.events)} jumps)"

    @property
    def identity(self) -> str:
        """Hash of the physics and of the solver's settings."""
        return str(self.attributes["identity"])

    @property
    def finished(self) -> bool:
        """Whether every point of the path is there."""
        return bool(self.attributes["finished"])

    @property
    def converged(self) -> bool:
        """True if there are points, and each is an equilibrium at its target."""
        return bool(self.points) and all(point.converged for point in self.points)

    @cached_property
    def grid(self) -> Grid:
        return self.config.grid.build()

    @property
    def moments(self) -> Moments:
        """Spectral moments of the heights."""
        return Moments(*(float(self.attributes[f"realised_{name}"]) for name in Moments._fields))

    def wall_at(self, point: Point) -> Wall:
        """The wall of a point: in a search for thresholds each has its own work of adhesion."""
        if self.config.loading.threshold is None:
            return self.wall
        return self.config.wall.at_work(point.work_of_adhesion)

    def repulsive(self, index: int) -> Mask:
        """The cells of A_rep of a point, shape ``grid.shape``.

        Points are counted from 0, or from the last one, -1, as in Python; ArgumentError if there is no such point.
        """
        return self._mask("repulsive", index)

    def contact_map(self, index: int) -> NDArray[np.uint8]:
        """REPULSIVE, ATTRACTED or OUT_OF_RANGE at each cell, shape ``grid.shape``; points as :meth:`repulsive`."""
        pushed, pulled = self._mask("repulsive", index), self._mask("attracted", index)
        return REPULSIVE * pushed.astype(np.uint8) + ATTRACTED * pulled.astype(np.uint8)

    def _place(self, index: int) -> int:
        """Place of a point in the file."""
        points = len(self.points)
        return count("index", index, -points, points - 1, why=f"the run has {points} points") % points

    def _mask(self, name: str, index: int) -> Mask:
        packed = store.read_part(self.path, name, self._place(index))
        if packed is None:
            raise StoreError(f"{self.path}: holds no map {name!r}")
        nx, ny = self.grid.shape
        if packed.shape != (nx, (ny + 7) // 8) or packed.dtype != np.uint8:
            raise StoreError(f"{self.path}: the map {name!r} is not one of the points of the grid")
        return store.unpack(packed, ny)

    def gap(self, index: int) -> Real | None:
        """Gap of a point, shape ``grid.shape``, in a0, from single precision; None if the run did not store gaps.

        Points as :meth:`repulsive`.
        """
        stored = store.read_part(self.path, "gap", self._place(index))
        return None if stored is None else stored.astype(np.float64)

    def heights(self) -> Real | None:
        """Heights of the wall, shape ``grid.shape``, in a0, from single precision; None if the run stored no fields."""
        names = {"heights"}
        file = store.read_datasets(self.path, RunConfig.result_schema, RunConfig.result_version, names)
        return file["heights"].astype(np.float64) if names <= set(file.datasets) else None

    def analyse(self) -> Analysis:
        """Measure all stored equilibria: patches, perimeter, κ, gap profile, pull-off."""
        good = [(step, point) for step, point in enumerate(self.points) if point.converged]
        notes = []
        if self.wall.law is None:
            notes.append("no distribution of pressures: under a hard wall they do not follow from the stored data")
        if missing := len(self.points) - len(good):
            notes.append(f"{missing} points that did not converge are left out")
        if not self.finished:
            notes.append("the run is not finished: `continuum run` with its input continues it")
        if self.points and self.gap(0) is None:
            notes.append(
                "areas under other definitions, gap profile, d_att and distributions need the gap at each point, which "
                "this run did not store: set fields = true in [output] of its input, and run it again into that folder"
            )
        curve = Curve.of([point for _, point in good])
        moments, wall = self.moments, self.wall
        expected = ExpectedContact(moments.rms_slope, moments.rms_curvature, wall.range, wall.work_of_adhesion)
        each = zip(good, normal_stiffness(curve).tolist(), strict=True)
        with understood(self.path):  # a map may not be that of its point
            points = tuple(_measured(self, step, point, stiffness) for (step, point), stiffness in each)
        return Analysis(self, expected, points, adhesion(curve) if good else None, tuple(notes))

    def sheets(self) -> list[Sheet]:
        """Tables of the points and of the jumps."""
        columns = (
            Column("step"), Column("branch"), Column("mean gap", "a0", ".5g"), Column("separation", "a0", ".5g"),
            Column("A_rep/A0"), Column("A_att/A0"), Column("N/A0", "E*", ".4e"), Column("N_rep/A0", "E*", ".4e"),
            Column("residual", "E*", ".1e"), Column("FFT pairs", "", ".0f"), Column("status"),
        )  # fmt: skip
        passed, few = self._not_looked_at(), self._count_few()
        rows = [
            (i, p.branch, p.mean_gap, p.separation, p.area_rep, p.area_att, p.load, p.load_rep, p.residual,
             p.fft_pairs + p.search_pairs, words(p.status) + (f", {NOT_LOOKED}" if over else "") + nearest)
            for i, (p, over, nearest) in enumerate(zip(self.points, passed, few, strict=True))
        ]  # fmt: skip
        notes = [f"{self.resumed} points were stored before"] if self.resumed else []
        notes += [HYSTERESIS] * any(passed) + [FEW_POINTS] * any(few)
        sheets = [Sheet.of("Points of the path", columns, rows, "; ".join(notes))]
        return [*sheets, _jumps(self.events)] if self.events else sheets

    def _count_few(self) -> list[str]:
        """Remarks on the points whose area is met to half a grid point only, or nothing."""
        asked = zip(self.points, self.config.loading.aims, strict=False)
        few = [p.converged and counts_few(p, search.area_tolerance) for p, (_, _, search) in asked]
        return [f", {NEAREST}" * one for one in few]

    def _not_looked_at(self) -> list[bool]:
        """Points to which the way back may have passed over jumps; none without adhesion, where there is one branch."""
        loading = self.config.loading
        looks = loading.event_resolution is not None
        one_branch = not self.wall.work_of_adhesion > 0
        points = [(p, one_branch or (looks and p.control != "repulsive-area")) for p in self.points]
        return not_looked_at(points, loading.event_threshold)

    def threshold_sheet(self) -> Sheet:
        """The threshold at each area of a result of :func:`continuum.threshold`, with its bracket."""
        columns = (
            Column("A_rep/A0"), Column("w at the threshold", "E* a0", ".4g"), Column("below", "E* a0", ".5g"),
            Column("above", "E* a0", ".5g"), Column("N_rep/A0", "E*", ".3e"), Column("N/A0", "E*", ".1e"),
            Column("A_att/A0"), Column("FFT pairs", "", ".0f"), Column("status"),
        )  # fmt: skip
        brackets, few, rows = dict(self.events), self._count_few(), []
        for i, (p, nearest) in enumerate(zip(self.points, few, strict=True)):
            ends = (brackets[i].before.value, brackets[i].after.value) if i in brackets else (np.nan, np.nan)
            jump = ", the load jumps over zero" if i in brackets and brackets[i].kind == "jump-in" else ""
            pairs = p.fft_pairs + p.search_pairs
            rows.append(
                (
                    p.area_rep,
                    p.work_of_adhesion,
                    *ends,
                    p.load_rep,
                    p.load,
                    p.area_att,
                    pairs,
                    words(p.status) + jump + nearest,
                )
            )
        note = FEW_POINTS if any(few) else ""
        return Sheet.of("Work of adhesion above which the surface is sticky", columns, rows, note)

    def to_pandas(self) -> pandas.DataFrame:
        """One row for each point; ``attrs["units"]`` has the unit of each column."""
        return frame_of(self.points, Point)

    def to_xarray(self) -> xarray.Dataset:
        """The run with axes (step, x, y), contact maps as booleans, and words as CF flags; maps are read when used.

        ``load`` is called ``load_net``, as each dataset has a method ``load``.
        """
        from continuum.store.runs.maps import dataset_of  # xarray takes a while to import

        return dataset_of(self.path, self.points, self.attributes)


def _jumps(events: Sequence[PathEvent]) -> Sheet:
    """Two rows for each jump: its state before and after."""
    columns = (
        Column("before step"), Column("jump"), Column("state"), Column("control"), Column("value", "", ".6g"),
        Column("mean gap", "a0"), Column("A_rep/A0"), Column("N/A0", "E*", ".3e"),
    )  # fmt: skip
    rows = [
        (step, e.kind, side, e.control.replace("-", " "), state.value, state.mean_gap, state.area_rep, state.load)
        for step, e in events
        for side, state in (("before", e.before), ("after", e.after))
    ]
    return Sheet.of("Jumps and thresholds, with the states on both sides", columns, rows)


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
class Analysis(Shown):
    """A stored run with all its measurements, which :func:`continuum.plot` draws."""

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

    def sheets(self) -> list[Sheet]:
        """Each point, and the run as a whole."""
        sheets = [_loads(self), _geometry(self)]
        if any(point.fields for point in self.points):
            sheets += [_outside(self), _areas(self)]
        return [*sheets, _whole(self)]


def _measured(result: Result, step: int, point: Point, stiffness: float) -> MeasuredPoint:
    repulsive, slope = result.repulsive(step), result.moments.rms_slope
    numbers, gap = measure(result.grid, point, repulsive, slope), result.gap(step)
    found = None if gap is None else _fields(result.grid, result.wall_at(point), gap, repulsive, numbers)
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


_POINT = (Column("step"), Column("branch"), Column("mean gap", "a0"))


def _head(measured: MeasuredPoint) -> tuple[int, str, float]:
    return measured.step, measured.point.branch, measured.point.mean_gap


def _loads(analysis: Analysis) -> Sheet:
    columns = (
        *_POINT, Column("A_rep/A0"), Column("A_att/A0"), Column("N/A0", "E*", ".3e"), Column("p_rep", "E*"),
        Column("p_att", "E*"), Column("1/κ"), Column("κ_rep"), Column("κ_att"), Column("k_N", "E*/a0", ".3e"),
    )  # fmt: skip
    rows = []
    for measured in analysis.points:
        n = measured.numbers
        inverse = 1 / n.kappa if n.kappa else np.nan
        rows.append(
            (*_head(measured), n.area_rep, n.area_att, n.load, n.pressure_rep, n.pressure_att, inverse, n.kappa_rep,
             n.kappa_att, measured.stiffness)
        )  # fmt: skip
    return Sheet.of("Loads", columns, rows)


def _geometry(analysis: Analysis) -> Sheet:
    names = ("P", "d_rep", "d_rep with 1.1107", "chord", "along x", "along y")
    columns = (*_POINT, Column("N_P"), *(Column(n, "a0") for n in names), Column("patches"), Column("largest", "a0²"))
    rows = []
    for measured in analysis.points:
        n, size = measured.numbers, measured.patch_areas
        lengths = (n.perimeter, n.diameter, n.diameter_exact, n.chord, *n.outline.chords)
        rows.append((*_head(measured), n.perimeter_cells, *lengths, size.size, float(size.max(initial=0.0))))
    return Sheet.of("Repulsive contact: P and d_rep with the paper's factor 1.1222", columns, rows)


def _outside(analysis: Analysis) -> Sheet:
    columns = (
        *_POINT, Column("d_att", "a0"), Column("A_att/P", "a0"), Column("Eq. (S-2)", "a0"), Column("gap/Eq. (S-1)"),
        Column("to"),
    )  # fmt: skip
    rows = []
    for measured in analysis.points:
        n, found = measured.numbers, measured.fields
        if found is not None:
            rim = n.area_att * analysis.result.grid.area / n.perimeter if n.perimeter else np.nan
            rows.append((*_head(measured), found.width, rim, found.expected_width, *found.gap_ratio))
    return Sheet.of("Gap outside the contact", columns, rows)


def _areas(analysis: Analysis) -> Sheet:
    names = ("repulsive", "uncertainty", "corrected", "contour", "interior", "dilated")
    columns = (*_POINT, Column("A_rep/A0"), Column("±"), *map(Column, names[2:]))
    rows = [
        (*_head(measured), *(getattr(measured.fields.areas, name) for name in names))
        for measured in analysis.points
        if measured.fields is not None
    ]
    return Sheet.of("Repulsive areas by other definitions, as fractions of A0", columns, rows)


def _whole(analysis: Analysis) -> Sheet:
    expected, found = analysis.expected, analysis.adhesion
    rows: list[tuple[str, str]] = [
        ("rms slope h'rms", f"{expected.rms_slope:.4g}"),
        ("rms curvature h''rms", f"{expected.rms_curvature:.4g} 1/a0"),
        ("d_rep, theory 4h'/h''", f"{expected.diameter:.4g} a0"),
        ("d_att, theory Eq. (S-2)", f"{expected.width:.4g} a0"),
        ("A_rep/A_att, theory Eq. (4)", f"{expected.area_ratio:.4g}"),
        ("p_att, theory w/Δr", f"{expected.pressure_att:.4g} E*"),
    ]
    if found is not None:
        ends = "" if found.separated or np.isnan(found.pull_off) else " (path ends under tension: too small)"
        # The error of the trapezoidal rule has either sign.
        lost = f"{found.loss:.4g} E* a0" if found.loss > 1e-6 * found.work_of_separation else "none"
        rows += [
            ("peak load N/A0", f"{found.peak_load:.4g} E*"),
            ("largest tension on approach", f"{found.largest_tension:.4g} E*"),
            ("pull-off tension on retraction", f"{found.pull_off:.4g} E*"),
            ("work of separation per A0", f"{found.work_of_separation:.4g} E* a0{ends}"),
            ("work lost in the cycle per A0", lost),
        ]
    return pairs("Theory and adhesion", rows)
