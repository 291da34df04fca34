"""Areas, loads and contact map of a state; pull-off and work of a loading path.

A :class:`Curve` is the load of a path against distance: loads per A0, in E*, compression positive; distances in a0.
Nothing is known between the points of a path: a jump appears as a steep piece, and an extreme is that of the points, so
that its error is the change to the next point.
"""

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from continuum.measure.outline import Mask, Outline, outline, ratio
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall

OUT_OF_RANGE, ATTRACTED, REPULSIVE = np.uint8(0), np.uint8(1), np.uint8(2)
_ROWS = 256


def quantity(units: str, long_name: str, default: Any = MISSING) -> Any:
    """Stored field of a record, with unit and description; without a default every stored record must have it."""
    return field(default=default, metadata={"units": units, "long_name": long_name})


@dataclass(frozen=True)
class Totals:
    """Areas and loads of one state.  Areas are fractions of A0, loads are per A0, in E*."""

    area_rep: float = quantity("1", "repulsive area A_rep/A0")
    """A_rep: fraction of the points with gap < zero_gap; under a hard wall, with gap = 0."""
    area_att: float = quantity("1", "attracted area A_att/A0")
    """A_att: fraction of the points with zero_gap <= gap < zero_gap + range."""
    load_rep: float = quantity("E*", "repulsive load N_rep/A0")
    """Load N_rep/A0 of the points that push, in E*."""
    load_att: float = quantity("E*", "attractive load N_att/A0")
    """Load N_att/A0 of the points that pull, as a positive number, in E*."""
    load: float = quantity("E*", "load N/A0, compression positive")
    """Load N = N_rep - N_att, in E*."""
    wall_energy: float = quantity("E* a0", "interaction energy per area")
    smallest_gap: float = quantity("a0", "smallest gap")


@dataclass(frozen=True, kw_only=True)
class Equilibrium(Totals):
    """A point of a path: its control and branch, and its areas and loads.

    Fields with a unit and a description are the columns of a point wherever one is stored or shown; records of more,
    as of a state with its gap, or of a point as it is stored, add theirs.
    """

    control: str = quantity("", "controlled quantity")
    """Name of the given quantity."""
    target: float = quantity("", "value of the control: in a0, in E* (mean pressure), or a fraction of A0 (area)")
    """Target value: in a0, in E* (mean pressure), or a fraction of A0 (repulsive area)."""
    branch: str = quantity("", "direction from which the point was reached")
    """Direction from which the point was reached: start, approach or retract."""
    work_of_adhesion: float = quantity("E* a0", "work of adhesion w of the wall; in reduced units l_a", np.nan)
    """Work of adhesion of the wall, in E* a0; NaN where it is not known."""
    separation: float = quantity("a0", "height of the wall's zero above the undeformed surface")
    """Separation, in a0; NaN where the mean displacement of the substrate is free."""
    mean_gap: float = quantity("a0", "mean gap")
    """Mean gap, in a0."""


def shared(kind: type[Totals], record: Any) -> dict[str, Any]:
    """Values of the fields of a class of records, from a record of another class with the same fields."""
    return {one.name: getattr(record, one.name) for one in fields(kind)}


def contact_map(wall: Wall, gap: Real) -> NDArray[np.uint8]:
    """REPULSIVE, ATTRACTED or OUT_OF_RANGE at each point."""
    repulsive = wall.touches(gap)
    attracted = ~repulsive & (gap < wall.zero_gap + wall.range)
    return np.where(repulsive, REPULSIVE, np.where(attracted, ATTRACTED, OUT_OF_RANGE))


def totals_of(grid: Grid, wall: Wall, gap: Real, traction: Real | None = None) -> Totals:
    """Areas and loads of a state, from its gap and, where the wall has no law of the gap, from its traction.

    Both have the shape ``grid.shape_here``, in a0 and E*.
    """
    parts = [_sums(wall, gap[slab], None if traction is None else traction[slab]) for slab in grid.slabs]
    area_rep, area_att, load_rep, load_att, energy = (grid.together(np.array(parts)) / grid.size).tolist()
    return Totals(area_rep, area_att, load_rep, load_att, load_rep - load_att, energy, grid.least(gap))


def _sums(wall: Wall, gap: Real, traction: Real | None) -> Real:
    """Repulsive and attracted points, sums of repulsive and attractive tractions, and of energies."""
    sums = np.zeros(5)
    for start in range(0, gap.shape[0], _ROWS):  # in blocks: three fields of a large grid would not fit
        block = gap[start : start + _ROWS]
        if traction is None:
            energy, pressure, _ = wall.evaluate(block)
        else:
            energy, pressure = wall.energy(block), traction[start : start + _ROWS]
        kind = contact_map(wall, block)
        counts = np.count_nonzero(kind == REPULSIVE), np.count_nonzero(kind == ATTRACTED)
        sums += *counts, np.maximum(pressure, 0.0).sum(), np.maximum(-pressure, 0.0).sum(), energy.sum()
    return sums


def area_by_lines(distance: Real, *, periodic: bool = True) -> tuple[float, Real]:
    """Repulsive area as a smooth number, and its derivative by the distance at each point.

    A count of points has no derivative.  This is the part of the lines between neighbouring points along which the gap,
    linear from point to point, is below ``zero_gap``: it has one, and agrees with the count but for what the grid does
    not resolve.

    Parameters
    ----------
    distance : gap - zero_gap, in a0; of shape (1, n) for a line.
    periodic : whether the last point of a line is the neighbour of the first.

    Returns
    -------
    area, slope
        A fraction of A0, and its derivative by the distance of each point, shape of ``distance``, in 1/a0.
    """
    area, slope = 0.0, np.zeros(distance.shape)
    axes = [axis for axis in (0, 1) if distance.shape[axis] > 1]
    for axis in axes:
        beyond = np.roll(distance, -1, axis)
        below, crosses = (distance < 0) & (beyond < 0), (distance < 0) != (beyond < 0)
        if not periodic:
            for kind in (below, crosses):
                np.moveaxis(kind, axis, 0)[-1] = False
        lines = len(axes) * (distance.size - (0 if periodic else distance.size // distance.shape[axis]))
        one, other, span = (np.abs(values[crosses]) for values in (distance, beyond, distance - beyond))
        inside = np.where(distance[crosses] < 0, one, other)
        area += float(np.count_nonzero(below) + (inside / span).sum()) / lines
        for_one, for_other = np.zeros(distance.shape), np.zeros(distance.shape)
        for_one[crosses], for_other[crosses] = other / span**2, one / span**2
        # The share inside of a link is |one|/(|one| + |other|); each of its two ends gets its part of the derivative.
        slope -= (for_one + np.roll(for_other, 1, axis)) / lines
    return area, slope


@dataclass(frozen=True, kw_only=True)
class Measurement(Totals):
    """Areas and loads of a contact, the outline of A_rep, and the numbers that the paper derives from them.

    A ratio whose two sides are zero is NaN: without contact there is no κ and no diameter.
    """

    outline: Outline = field(repr=False)
    """Outline of A_rep."""
    rms_slope: float
    """h'rms of the undeformed surface."""
    pressure_rep: float = quantity("E*", "mean repulsive pressure p_rep = N_rep/A_rep")
    pressure_att: float = quantity("E*", "mean attractive pressure N_att/A_att")
    """Mean attractive pressure as a positive number, in E*; w/Δr in the paper's theory."""
    kappa: float = quantity("1", "κ = h'rms E* A_rep/N")
    """κ of Eq. (1): negative under a tensile load, infinite without load."""
    kappa_rep: float = quantity("1", "κ_rep = h'rms E* A_rep/N_rep")
    kappa_att: float = quantity("1", "κ_att = h'rms E* A_rep/N_att")
    """κ_att, with 1/κ = 1/κ_rep - 1/κ_att; infinite without attraction."""
    perimeter_cells: int = quantity("1", "cells of the perimeter, N_P")
    perimeter: float = quantity("a0", "perimeter P of A_rep, with the paper's correction 1.1222")
    perimeter_exact: float = quantity("a0", "perimeter P of A_rep, with the correction 1.1107")
    diameter: float = quantity("a0", "mean diameter d_rep = π A_rep/P, with the paper's correction")
    diameter_exact: float = quantity("a0", "mean diameter d_rep, with the correction 1.1107")
    chord: float = quantity("a0", "mean chord of A_rep in both directions")

    def numbers(self) -> dict[str, float]:
        """Every number of :data:`MEASURED`, by name."""
        return {name: float(getattr(self, name)) for name in MEASURED}


MEASURED: Mapping[str, tuple[str, str]] = {
    one.name: (one.metadata["units"], one.metadata["long_name"])
    for one in fields(Measurement)
    if one.metadata and one not in fields(Totals)
}
"""Unit and description of the numbers that a :class:`Measurement` adds to the totals."""


def measure(grid: Grid, totals: Totals, repulsive: Mask, rms_slope: float) -> Measurement:
    """Measure the numbers of the paper on one state.

    Parameters
    ----------
    totals : areas and loads, from :func:`totals_of`.
    repulsive : the cells of A_rep: ``contact_map(wall, gap) == REPULSIVE``, or the map stored with a run.
    rms_slope : h'rms of the undeformed surface; its spectral moment, not the target of its synthesis.

    Raises ValueError if the map does not fit the grid, or the areas.
    """
    rim = outline(grid, repulsive)
    if not abs(rim.cells - totals.area_rep * grid.size) <= 0.5:
        msg = f"the map has {rim.cells} cells, but A_rep/A0 = {totals.area_rep} is {totals.area_rep * grid.size:g}"
        raise ValueError(msg)
    hold = rms_slope * totals.area_rep
    return Measurement(
        **shared(Totals, totals),
        outline=rim,
        rms_slope=rms_slope,
        pressure_rep=ratio(totals.load_rep, totals.area_rep),
        pressure_att=ratio(totals.load_att, totals.area_att),
        kappa=ratio(hold, totals.load),
        kappa_rep=ratio(hold, totals.load_rep),
        kappa_att=ratio(hold, totals.load_att),
        perimeter_cells=rim.perimeter_cells,
        perimeter=rim.perimeter("paper"),
        perimeter_exact=rim.perimeter("exact"),
        diameter=rim.diameter("paper"),
        diameter_exact=rim.diameter("exact"),
        chord=rim.chord,
    )


@dataclass(frozen=True, eq=False)
class Curve:
    """The equilibria of a path in the order in which they were reached."""

    mean_gap: Real
    separation: Real
    """Separation, in a0; NaN if the mean displacement of the substrate is free."""
    load: Real
    retracting: NDArray[np.bool_]
    """True on retraction, False on approach."""

    @classmethod
    def of(cls, points: Sequence[Equilibrium]) -> Self:
        """Build the curve of the equilibria among some points, in their order."""
        columns = [(point.mean_gap, point.separation, point.load) for point in points]
        mean_gap, separation, load = np.array(columns, dtype=np.float64).reshape(-1, 3).T
        return cls(mean_gap, separation, load, np.array([point.branch == "retract" for point in points], dtype=bool))

    def branches(self) -> list[NDArray[np.intp]]:
        """Indices of the points of each stretch in one direction; the point of reversal belongs to both."""
        reversals = np.flatnonzero(np.diff(self.retracting.astype(np.int8))) + 1
        starts = [0, *(reversals - 1)]
        return [np.arange(s, e) for s, e in zip(starts, [*reversals, self.load.size], strict=True) if e > s]


def normal_stiffness(curve: Curve) -> Real:
    """k_N = -dN/d(mean gap) per A0 at each point, in E*/a0; NaN where a stretch has one point.

    Differences of second order along each stretch of approach or retraction; the point of reversal takes that of the
    approach.  In the paper it is proportional to the load, and lowered by adhesion by the factor κ_rep/κ.
    """
    stiffness = np.full(curve.load.size, np.nan)
    for points in reversed(curve.branches()):
        gap, load = curve.mean_gap[points], curve.load[points]
        if points.size > 1 and (np.diff(gap) != 0).all():
            stiffness[points] = -np.gradient(load, gap, edge_order=2 if points.size > 2 else 1)
    return stiffness


@dataclass(frozen=True)
class Adhesion:
    """Pull-off and work of adhesion of a path, per A0."""

    peak_load: float
    """Largest load of the path, in E*, on which pull-off depends."""
    largest_tension: float
    """Largest tension on approach, in E*, not negative: the paper's N_max (Suppl. S-III)."""
    pull_off: float
    """Largest tension on retraction, in E*, not negative; NaN without retraction."""
    work_of_separation: float
    """Work against tension on retraction, in E* a0: from where the load becomes tensile to the end."""
    loss: float
    """Work lost in the cycle, in E* a0: work done on approach less work regained over the same distances."""
    separated: bool
    """True if the tension at the end of the retraction is below 1 % of the pull-off, so that the work is complete."""


def adhesion(curve: Curve) -> Adhesion:
    """Pull-off and work of a path of one approach and one retraction, without which only the tension on approach is
    known.

    Work is the integral of the load over the separation, or over the mean gap if the mean displacement is free, by the
    trapezoidal rule over the points of the path.

    Raises ValueError if there is no point.
    """
    if curve.load.size == 0:
        raise ValueError("the path has no equilibrium, so that nothing can be measured")
    distance = curve.separation if np.isfinite(curve.separation).all() else curve.mean_gap
    away = curve.retracting
    tension = np.maximum(-curve.load, 0.0)
    peak = float(curve.load.max())
    approach = float(tension[~away].max(initial=0.0))
    if not away.any():
        return Adhesion(peak, approach, np.nan, np.nan, np.nan, separated=False)
    last = int(np.argmax(away)) - 1  # the last point of the approach
    back = np.arange(max(last, 0), curve.load.size)
    pull_off = float(tension[back].max())
    work = _tensile_work(distance[back], curve.load[back])
    loss = np.nan
    if last >= 0:
        to, fro = np.arange(last + 1), back
        loss = _overlap_work(distance[to][::-1], curve.load[to][::-1], distance[fro], curve.load[fro])
    return Adhesion(peak, approach, pull_off, work, loss, separated=bool(tension[-1] <= 0.01 * pull_off))


def _tensile_work(distance: Real, load: Real) -> float:
    largest = int(np.argmin(load))
    if load[largest] >= 0:
        return 0.0
    pushing = np.flatnonzero(load[:largest] >= 0)
    first = int(pushing[-1]) if pushing.size else 0
    distance, load = distance[first:], load[first:]
    if pushing.size:  # from where the load crosses zero
        share = load[0] / (load[0] - load[1])
        distance = np.concatenate([[distance[0] + share * (distance[1] - distance[0])], distance[1:]])
        load = np.concatenate([[0.0], load[1:]])
    return float(np.trapezoid(-load, distance))


def _overlap_work(d1: Real, load1: Real, d2: Real, load2: Real) -> float:
    """Integral of load1 - load2 over the distances that both curves cover; both begin where the path reverses."""
    distance = np.unique(np.concatenate([d1, d2]))
    distance = distance[distance <= min(d1[-1], d2[-1])]
    if distance.size < 2 or (np.diff(d1) <= 0).any() or (np.diff(d2) <= 0).any():
        return float("nan")
    difference = np.interp(distance, d1, load1) - np.interp(distance, d2, load2)
    return float(np.trapezoid(difference, distance))
