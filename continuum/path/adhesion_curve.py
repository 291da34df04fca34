"""The adhesion curve on approach, from states without adhesion: load, area and gap for every work of adhesion.

A surface is pressed without attraction to several repulsive areas A.  Each state has its load N0, its mean gap D0, and
what an attraction does to it (:mod:`continuum.path.threshold`).  With x = -c2 w/c1, at the same area::

    w^ = w/(1 + max(x, 0))          the part of w that still acts, as the attraction opens the gaps by w^ z1
    N(A, w) = N0 + c1 w^            load per A0, to second order in w
    D(A, w) = D0 + D_A w^           mean gap

Before first touch the load is -w <τ> over the gaps of the undeformed surface.  The form is derived in docs/law.md,
stated and tested in docs/studies/adhesion_curve.md.  It is that of slow approach: where summits snap, the load on
retraction is lower.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.walls import HardWall, Wall
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import PathState
from continuum.path.threshold import PressedState, on_core
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver

AREAS = tuple(float(one) for one in np.geomspace(5e-4, 0.12, 14))
"""Repulsive areas to which a surface is pressed, as fractions of A0, about."""
FEWEST_POINTS = 8
"""Points that touch in the first state, at least: with fewer their area is no number."""
STEEPEST, FLATTEST = 1.6, 0.6
"""Powers of the area between which the pressure of the next state is extrapolated."""
SAME = 0.1
"""Logarithm of two areas below which one state stands for both."""
DENSE = 400
"""Points of a curve between its first and its last state."""
APART, BINS, FAR = 33, 2000, 12.0
"""States before first touch, classes of the heights that are within reach, and ranges to which an attraction without
end is followed."""


@dataclass(frozen=True, eq=False)
class PressedSeries:
    """A surface that is pressed without adhesion to several areas, in ascending order; lengths in a0."""

    states: tuple[PressedState, ...] = field(repr=False)
    heights: Real = field(repr=False)
    """Heights of the wall, shape ``grid.shape``."""

    def curve(self, wall: Wall) -> "AdhesionCurve":
        """The curve under a law, whose work of adhesion may be any: its shape should not depend on it."""
        responses = [state.response(*state.attraction(wall)) for state in self.states]
        first, second, withdrawal, moved = np.array(responses).T
        gaps_apart, pull_apart = self._apart(wall)
        return AdhesionCurve(
            areas=np.array([state.area_rep for state in self.states]),
            load=np.array([state.load for state in self.states]),
            mean_gap=np.array([state.grid.mean(state.distance) for state in self.states]),
            first=first, second=second, withdrawal=withdrawal, moved=moved,
            patches=np.array([state.patches for state in self.states]), gaps_apart=gaps_apart, pull_apart=pull_apart,
        )  # fmt: skip

    def _apart(self, wall: Wall) -> tuple[Real, Real]:
        """Mean gaps before first touch, the nearest first, and <τ> there."""
        above = self.heights - self.heights.min()
        reach = min(wall.reach - wall.zero_gap, FAR * wall.effective_range)
        counts, edges = np.histogram(above, BINS, (0.0, reach))
        away = reach * np.linspace(0.0, 1.0, APART) ** 2
        gaps = away[:, None] + (edges[1:] + edges[:-1]) / 2
        pull = np.where(gaps < reach, -wall.evaluate(wall.zero_gap + gaps).traction, 0.0) / wall.work_of_adhesion
        return float(above.mean()) + away, pull @ counts / above.size


class Reading(NamedTuple):
    """What is read off a curve at one place: per A0, in E* and a0."""

    load: float
    area: float
    """Repulsive area, as a fraction of A0; 0 before first touch."""
    mean_gap: float
    """Beyond the gap of zero traction."""
    x: float
    """x = -c2 w/c1, how far the attraction opens the gaps; NaN before first touch."""
    patches: float
    inside: bool
    """Whether it lies between states, not at the end of the curve."""


@dataclass(frozen=True, eq=False)
class AdhesionCurve:
    """Load, area and gap on approach for every work of adhesion, under one law.

    Arrays have one value for each state, areas ascending.
    """

    areas: Real
    """Repulsive areas, fractions of A0."""
    load: Real
    """N0, per A0."""
    mean_gap: Real
    """D0, beyond the gap of zero traction."""
    first: Real
    """c1."""
    second: Real
    """c2."""
    withdrawal: Real
    """D_A."""
    moved: Real
    """<|τ' z1|>/<τ>."""
    patches: Real
    gaps_apart: Real = field(repr=False)
    """Mean gaps before first touch, the nearest first."""
    pull_apart: Real = field(repr=False)
    """<τ> there."""

    def remaining(self, work: float) -> Real:
        """w^, the part of the work that still acts, at each state."""
        return np.asarray(work / (1 + np.maximum(self.x(work), 0.0)))

    def x(self, work: float) -> Real:
        """Relative loss x = -c2 w/c1 of the attraction at each state, as it opens the gaps."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = -self.second * work / self.first
        return np.asarray(np.where(self.first < 0, found, 0.0))

    def at(self, areas: Real | Sequence[float]) -> "AdhesionCurve":
        """The curve at other areas, between its states: interpolated in the logarithms of area and load."""
        given, known = np.log(np.asarray(areas, dtype=np.float64)), np.log(self.areas)

        def between(values: Real, power: bool = False) -> Real:
            # At few points an attraction may be none, or a repulsion.
            power = power and bool(np.all(values > 0))
            found: Real = np.interp(given, known, np.log(values) if power else values)
            return np.exp(found) if power else found

        ratio = np.divide(self.second, self.first, out=np.zeros_like(self.first), where=self.first < 0)

        first = -between(-self.first, power=True)
        return replace(
            self, areas=np.exp(given), load=between(self.load, power=True), mean_gap=between(self.mean_gap),
            first=first, second=between(ratio) * first, withdrawal=between(self.withdrawal),
            moved=between(self.moved), patches=between(self.patches),
        )  # fmt: skip

    @property
    def dense(self) -> "AdhesionCurve":
        """The same at many areas."""
        return self.at(np.geomspace(self.areas[0], self.areas[-1], DENSE))

    def loads(self, work: float) -> Real:
        """N(A, w) at each state."""
        return np.asarray(self.load + self.first * self.remaining(work))

    def gaps(self, work: float) -> Real:
        """D(A, w) at each state."""
        return np.asarray(self.mean_gap + self.withdrawal * self.remaining(work))

    def thresholds(self) -> Real:
        """The work of adhesion at which the load vanishes at each area: w1/(1 - χ); infinite where there is none."""
        with np.errstate(divide="ignore", invalid="ignore"):
            first = -self.load / self.first
            chi = self.x(1.0) * first
            found = np.where(chi > 0, np.where(chi < 1, first / np.maximum(1 - chi, 0), np.inf), first)
        return np.asarray(np.where(self.first < 0, found, np.inf))

    def whole(self, work: float) -> tuple[Real, Real, Real]:
        """Mean gaps, loads and areas from far away to the last state."""
        dense = self.dense
        apart = self.gaps_apart[::-1], -work * self.pull_apart[::-1], np.zeros(self.gaps_apart.size)
        here = dense.gaps(work), dense.loads(work), dense.areas
        gaps, loads, areas = (np.concatenate(both) for both in zip(apart, here, strict=True))
        return gaps, loads, areas

    def _read(self, work: float, i: int) -> Reading:
        gaps, loads, areas = self.whole(work)
        inside = 0 < i < gaps.size - 1
        if i < self.gaps_apart.size:
            return Reading(float(loads[i]), 0.0, float(gaps[i]), np.nan, 0.0, inside)
        one = self.at([float(areas[i])])
        return Reading(
            float(loads[i]), float(areas[i]), float(gaps[i]), float(one.x(work)[0]), float(one.patches[0]), inside
        )

    def least(self, work: float) -> Reading:
        """The least load on approach: with the other sign, the largest tension that slow approach meets."""
        return self._read(work, int(np.argmin(self.whole(work)[1])))

    def at_load(self, work: float, load: float) -> Reading | None:
        """The state of a load on approach, the one with the largest area; None where the curve has none."""
        _, loads, _ = self.whole(work)
        crossings = np.flatnonzero((loads[:-1] < load) & (loads[1:] >= load))
        if not crossings.size:
            return None
        return self._read(work, int(crossings[-1]) + 1)

    def forces(self, work: float) -> tuple[Real, Real]:
        """Force on a sphere over 2π R, at the gaps of :meth:`whole` to its lowest point, by Derjaguin's integral."""
        gaps, loads, _ = self.whole(work)
        steps = (loads[1:] + loads[:-1]) / 2 * -np.diff(gaps)
        return gaps, np.concatenate([[0.0], np.cumsum(steps)])

    def tension_on_sphere(self, work: float) -> tuple[float, bool]:
        """The largest tension on a sphere over 2π R, and whether it is no end of the curve."""
        _, forces = self.forces(work)
        i = int(np.argmin(forces))
        return -float(forces[i]), 0 < i < forces.size - 1


def press_series(
    problem: ContactProblem,
    first: PathState,
    settings: Settings,
    core_stiffness: float,
    areas: Sequence[float] = AREAS,
    solver: Solver | None = None,
) -> PressedSeries:
    """The states of a surface without adhesion at about these areas, each by one solve at a given pressure.

    Parameters
    ----------
    problem : grid, heights and response; its wall is not used.
    first : a state of it under a hard wall, from which on pressures are extrapolated.
    settings : of each solve.
    core_stiffness : of the law where it repels, in E*/a0.
    areas : those of fewer than :data:`FEWEST_POINTS` points are left out.
    solver : of this problem's grid and response.
    """
    hard = replace(problem, wall=HardWall())
    solver = solver or solver_of(hard, settings)
    found = [first]
    # From the first state on in both directions, so that the next one is near.
    for area in sorted(areas, key=lambda area: abs(np.log(area / first.area_rep))):
        if area * problem.grid.size < FEWEST_POINTS:
            continue
        near = sorted(found, key=lambda state: abs(np.log(state.area_rep / area)))[:2]
        if abs(np.log(near[0].area_rep / area)) > SAME:
            pressure = _pressure(near, area)
            state = equilibrium(hard, "mean-pressure", pressure, settings, near[0].gap, "approach", solver)
            if state.converged and state.area_rep > 0:
                found.append(state)
    found.sort(key=lambda state: state.area_rep)
    apart = [one for i, one in enumerate(found) if i == 0 or one.area_rep > (1 + SAME / 5) * found[i - 1].area_rep]
    return PressedSeries(tuple(on_core(hard, state, core_stiffness) for state in apart), problem.heights)


def _pressure(near: Sequence[PathState], area: float) -> float:
    """The pressure of an area, as a power of it through the two states nearest to it."""
    one, other = near[0], near[-1]
    power = 1.0
    if other is not one and other.area_rep != one.area_rep:
        power = float(np.log(one.load / other.load) / np.log(one.area_rep / other.area_rep))
    return float(one.load * (area / one.area_rep) ** min(max(power, FLATTEST), STEEPEST))
