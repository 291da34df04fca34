"""What a search for an area looks for, its steps, the coarser grids where it begins, and what it has cost."""

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from continuum.model.fourier import Real, cut, padded, prolong, restrict
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import equilibrium
from continuum.path.state import Branch, Control, Outcome, PathState, Search, event, height, nearness
from continuum.solve.solution import Closer, Settings
from continuum.solve.solver import Solver

LITTLE = 0.3
"""What is left of ln(area) at most for a step without a trial: by the slope, which is known to a fifth or so."""
NEAR = 3.0
"""Tolerances from the target that a coarser grid comes to in any case; it is asked for where to begin only."""
FEWEST, STEEPEST = 10.0, 2.0
"""Points by which areas must differ to tell a slope, and the largest one, in units of that of the surface: beyond, the
area has jumped."""
LOOSE, LOOSEST = 100.0, 1e-5
"""Tolerance of trials, in units of the tolerance asked for, but at most so much, in E*: beyond, areas say nothing."""

RESOLUTION = 1e-3
"""Width in mean gap down to which jumps are bracketed, in rms heights, where none is given."""
RIGID = (0.2, 100.0)
"""Step of a search at least and at most, in units of the one that would do if the surface moved rigidly: it gives way,
the less there is left to go the more."""
DECAY, FIRST = 2.2, 4.0
"""The area of rough surfaces decays with the mean gap as exp(-2.2 u/h_rms) (Persson, Phys. Rev. Lett. 99, 125502
(2007), has 2 - 2.5); a first step by that, to e times the area, is at most so many times the rigid one.  Beside a
contact the gap rises as the 3/2 power of the distance, so that shorter steps give way the more, as 1/sqrt(ln A)."""
WEAK = 0.3
"""Range, in h_rms, up to which the attraction adds little to the area where a search begins."""
LOST_SLOPE = 0.01
"""A grid carries a surface if the waves that it cannot resolve hold at most this part of the mean square slope."""


# --- how the area changes with the mean gap


def searched_range(problem: ContactProblem) -> float:
    """Range of the attraction as a search takes it into account, in a0: a cut-off may lie beyond all that is felt."""
    return min(problem.wall.range, problem.wall.effective_range)


def excess_range(problem: ContactProblem) -> float:
    """Range of the attraction beyond that which adds little to the area, in a0."""
    return max(searched_range(problem) - WEAK * float(sample(problem.heights).std()), 0.0)


def attracts_little(problem: ContactProblem) -> bool:
    """Whether a search may count on the area of rough surfaces without adhesion, or nearly so."""
    return problem.wall.range < WEAK * float(sample(problem.heights).std())


def rough_slope(problem: ContactProblem) -> float:
    """Slope d ln(area)/d(mean gap) of a rough surface without adhesion, roughly, in 1/a0; none of a flat one: -inf."""
    rms = float(sample(problem.heights).std())
    return -DECAY / rms if rms > 0 else -np.inf


def asperity_slope(problem: ContactProblem, area: float) -> float:
    """As :func:`rough_slope`, at a small area: by the summits of the surface at hand, of which there may be few.

    That of the area that would overlap, undeformed, about a contact of 1.5 times the area.
    """
    rough, part = rough_slope(problem), np.clip(1.5 * area, 0.0, 1 / 1.3) * np.array([1 / 1.3, 1.3])
    low, high = np.quantile(sample(problem.heights), part)
    return min(0.8 * rough, -2 * np.log(1.3) / float(high - low)) if high > low else rough


def lowest_height(problem: ContactProblem) -> float:
    """Mean gap down to which there are states: in full contact a soft wall gives way below zero_gap, up to its core.

    No separation is too low: a half-space gives way.
    """
    return -np.inf if problem.open_boundary is not None else max(problem.wall.core, problem.wall.bound)


def area_logarithm(area: float, size: int) -> float:
    """The area on a scale on which it is nearly linear in the mean gap: ln A, but -ln(1 - A) beyond half contact.

    Both are joined with one value and slope.  No area, and full contact, count as half a point less.
    """
    half = 0.5 / size
    area = min(max(area, half), 1 - half)
    return float(np.log(area) if area <= 0.5 else 2 * np.log(0.5) - np.log(1 - area))


def secant_fraction(before: PathState, after: PathState, target: float, size: int) -> float:
    """Part of the way from ``before`` to ``after`` at which the secant meets the target."""
    low, high = (area_logarithm(state.area_rep, size) for state in (before, after))
    return float(np.clip((area_logarithm(target, size) - low) / (high - low), 0.02, 0.98))


def step_to(problem: ContactProblem, before: PathState, target: float, slope: float) -> float:
    """Step of the mean gap towards the target, its length.

    The area changes less than if the surface were moved rigidly, which gives the scale.
    """
    wall, gap = problem.wall, sample(before.gap)
    rigid = abs(float(np.quantile(gap, target)) - wall.zero_gap)
    if before.area_rep == 0:
        return rigid
    size = problem.grid.size
    left = abs(area_logarithm(target, size) - area_logarithm(before.area_rep, size))
    (fewest, most), rough = RIGID, left / -asperity_slope(problem, target)
    if slope < 0:
        # Under strong attraction the rigid step ends at the rim of the contact and tells nothing.
        return float(np.clip(left / -slope, fewest * rigid, max(most * rigid, FIRST * rough)))
    if not attracts_little(problem):
        return max(rigid, rough)
    return float(np.clip(rough, rigid, FIRST * rigid / min(left, 1.0) ** 0.5)) if left else rigid


def sample(field: Real) -> Real:
    """Every k-th row and column, about a million points."""
    k = max(1, round((field.size / 1e6) ** 0.5))
    return field[::k, ::k]


# --- the contact on every second point of its grid, and the way back from there


@dataclass(frozen=True, eq=False)
class _Cut:
    """The response of a finer grid on the waves of a coarser one."""

    stiffness_q: Real

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum."""
        assert grid.shape_q == self.stiffness_q.shape
        return self.stiffness_q


def coarser_problem(problem: ContactProblem, smallest: int, *, roughly: bool = False) -> ContactProblem | None:
    """The same contact on every second point, if that still shows four points for each wave, or two: roughly."""
    grid, coarse = problem.grid, problem.grid.coarser
    if problem.open_boundary is not None or coarse is None or coarse.coarser is None or coarse.narrowest < smallest:
        return None
    heights_q = grid.forward(problem.heights)
    power = (heights_q.real**2 + heights_q.imag**2) * grid.mode_weights * grid.wavenumber**2
    rows, columns = (coarse if roughly else coarse.coarser).shape_q
    carried = cut(power, (rows, columns - 1)).sum()
    if carried < (1 - LOST_SLOPE) * power.sum():
        return None
    coarse_q = padded(coarse.shape_q, np.complex128)
    restrict(heights_q, coarse_q)
    response = _Cut(cut(problem.stiffness_q, coarse.shape_q))
    return ContactProblem(coarse, problem.wall, coarse.inverse(coarse_q), response)


def carried_gap(coarse: ContactProblem, fine: ContactProblem, state: PathState) -> Real:
    """The gap of a coarse state on the finer grid."""
    displacement_q = padded(fine.grid.shape_q, np.complex128)
    level = state.mean_gap - coarse.mean_height
    prolong(coarse.grid.forward(coarse.heights + level - state.gap), displacement_q)
    gap = fine.grid.inverse(displacement_q, overwrite=True)
    np.subtract(fine.heights, gap, out=gap)
    gap += state.mean_gap - fine.mean_height
    return gap


# --- the search


def loosened(settings: Settings, factor: float = LOOSE, most: float = LOOSEST) -> Settings:
    """Settings of trials, of which few are worth the tolerance asked for."""
    return replace(settings, tolerance=max(settings.tolerance, min(factor * settings.tolerance, most)))


class SearchWork:
    """What a search has cost, in FFT pairs of one grid, and the last d ln(area)/d(mean gap) that it saw.

    ``jump`` is the width of the bracket of a jump over the area that a coarser grid has; 0 without one.
    """

    def __init__(self, size: int) -> None:
        self.size, self.pairs, self.solves, self.slope, self.jump = size, 0.0, 0, np.nan, 0.0

    def add(self, state: PathState) -> PathState:
        self.pairs += state.solution.fft_pairs * state.solution.gap.size / self.size
        self.solves += 1
        return state


@dataclass(frozen=True)
class Aim:
    """What is looked for, and how."""

    problem: ContactProblem
    target: float
    settings: Settings
    loose: Settings
    """Tolerance of trials."""
    search: Search
    branch: Branch
    solver: Solver
    work: SearchWork
    side: float = 0.0
    """1 where a branch is followed from less than the target, -1 from more; 0 apart, where no state is known."""

    @property
    def allowed(self) -> float:
        """Largest difference from the target: relative to the contact, or to what is left of the surface beside it."""
        smaller = min(self.target, 1 - self.target)
        return max(self.search.area_tolerance * smaller, 0.5 / self.problem.grid.size) * (1 + 1e-9)

    @cached_property
    def height(self) -> float:
        """What mean gaps are measured in: the rms height or, of a flat surface, the range of the attraction, in a0."""
        return float(sample(self.problem.heights).std()) or self.problem.wall.range

    @property
    def resolution(self) -> float:
        """Width in mean gap down to which a jump over the target is bracketed, in a0."""
        given = self.search.area_resolution
        return RESOLUTION * self.height if given is None else given

    def met(self, state: PathState) -> bool:
        return abs(state.area_rep - self.target) <= self.allowed

    def serves(self, state: PathState) -> bool:
        """Whether a search may go on from a state: on a branch, from none beyond the target."""
        return state.status.ok and (not self.adhesive or state.area_rep <= self.target + self.allowed)

    def left(self, state: PathState, part: float = 1.0) -> float:
        """What is left from a state to a part of the target, in the logarithm of the area."""
        size = self.problem.grid.size
        return area_logarithm(part * self.target, size) - area_logarithm(state.area_rep, size)

    def saw(self, one: PathState, other: PathState) -> None:
        """Keep the slope between two states for the steps to come, unless a few points say nothing of it."""
        problem, size = self.problem, self.problem.grid.size
        change = height(problem, other) - height(problem, one)
        if change and abs(other.area_rep - one.area_rep) * size > FEWEST:
            slope = (area_logarithm(other.area_rep, size) - area_logarithm(one.area_rep, size)) / change
            if STEEPEST * asperity_slope(problem, self.target) < slope < 0:
                self.work.slope = slope

    @property
    def slope(self) -> float:
        """Change of ln(area) over that of the mean gap that the search saw last, or that of the surface, in 1/a0."""
        return self.work.slope if self.work.slope < 0 else asperity_slope(self.problem, self.target)

    def short(self, state: PathState, before: PathState) -> bool:
        """Whether a state is on that side of the target on which the one before it is."""
        sign = 1.0 if before.area_rep < self.target else -1.0
        return (self.target - state.area_rep) * sign > 0

    @property
    def guesses(self) -> bool:
        """Whether this is a coarser grid, which is asked for where to begin only."""
        return self.problem.grid.size < self.work.size

    def near(self, state: PathState) -> bool:
        """Whether a coarser grid need not come closer to its target, where that is costly, as near a jump."""
        return self.guesses and abs(self.left(state)) <= NEAR * self.search.area_tolerance

    @property
    def adhesive(self) -> bool:
        return self.problem.wall.work_of_adhesion > 0

    def trial(
        self,
        at: float,
        settings: Settings,
        start: Real | None,
        *,
        near: bool = False,
        before: PathState | None = None,
        jump: float = np.inf,
        stop: bool = False,
        control: Control | None = None,
    ) -> PathState:
        """Equilibrium at a mean gap, or another control.

        Near its start it is looked for on the fine grid, and in that basin, only.

        With the tolerance of trials it goes on to the one asked for if its area serves, or differs from that of
        ``before`` by more than ``jump``.  With ``stop`` it need not end once it has gone far over the target.
        """
        if near:
            settings = replace(settings, warm_grids=0)
        worth = partial(self._worth, None if before is None else before.area_rep, jump)
        passed = partial(self._passed, before.area_rep) if before is not None and stop else None
        closes = passed is not None or self.rough_at(settings.tolerance)
        closer = Closer(self.settings.tolerance, worth, passed) if closes else None
        state = equilibrium(
            self.problem, control or nearness(self.problem), at, settings, start, self.branch, self.solver, closer
        )
        return self.work.add(state)

    def _worth(self, before: float | None, jump: float, gap: Real) -> bool:
        """Whether the area of a trial meets the target, on a branch has not gone beyond it, or is that after a jump."""
        area = np.count_nonzero(self.problem.wall.touches(gap)) / self.problem.grid.size
        over = area - self.target
        serves = (over * self.side if self.side else abs(over)) <= self.allowed
        return bool(serves or (before is not None and abs(area - before) > jump))

    def _passed(self, before: float, gap: Real) -> bool:
        """Whether a trial on its way has gone far over the target, seen from an area before it: there is a jump."""
        size, area = self.problem.grid.size, np.count_nonzero(self.problem.wall.touches(gap)) / self.problem.grid.size
        over = area_logarithm(area, size) - area_logarithm(self.target, size)
        return bool(over * np.sign(self.target - before) > LITTLE)

    def rough_at(self, residual: float) -> bool:
        """Whether a state of this residual, or a tolerance, is not what is asked for."""
        return residual > 2 * self.settings.tolerance

    def done(self, state: PathState, outcome: Outcome | None = None, beyond: PathState | None = None) -> PathState:
        events = () if beyond is None else (event(nearness(self.problem), self.branch, state, beyond),)
        return replace(
            state,
            control="repulsive-area",
            target=self.target,
            branch=self.branch,
            outcome=outcome,
            beyond=beyond,
            events=events,
            search_pairs=max(0.0, self.work.pairs - state.solution.fft_pairs),
            search_solves=max(0, self.work.solves - 1),
        )
