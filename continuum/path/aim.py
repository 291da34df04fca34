"""What a search for an area looks for, how closely, and what it has cost."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import equilibrium
from continuum.path.secant import area_logarithm, area_slope, asperity_slope, sample
from continuum.path.state import Branch, Control, Outcome, PathState, Search, event, nearness
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
        return abs(state.totals.area_rep - self.target) <= self.allowed

    def serves(self, state: PathState) -> bool:
        """Whether a search may go on from a state: on a branch, from none beyond the target."""
        return state.status.ok and (not self.adhesive or state.totals.area_rep <= self.target + self.allowed)

    def left(self, state: PathState, part: float = 1.0) -> float:
        """What is left from a state to a part of the target, in the logarithm of the area."""
        size = self.problem.grid.size
        return area_logarithm(part * self.target, size) - area_logarithm(state.totals.area_rep, size)

    def saw(self, one: PathState, other: PathState) -> None:
        """Keep the slope between two states for the steps to come, unless a few points say nothing of it."""
        if abs(other.totals.area_rep - one.totals.area_rep) * self.problem.grid.size > FEWEST:
            slope = area_slope(self.problem, one, other)
            if STEEPEST * asperity_slope(self.problem, self.target) < slope < 0:
                self.work.slope = slope

    def saw_on_path(self, one: PathState, other: PathState) -> None:
        """Keep the slope between two states of a path, halfway to that of the summits at the target."""
        self.saw(one, other)
        self.work.slope = -float(np.sqrt(self.work.slope * asperity_slope(self.problem, self.target)))

    def jumped_over(self, last: PathState, older: PathState) -> bool:
        """Whether a path has jumped over the target, from its last state to the older one."""
        same = (older.branch == "retract") == (self.branch == "retract")
        return same and (older.totals.area_rep - self.target) * (last.totals.area_rep - self.target) < 0

    def jumped_towards(self, last: PathState, older: PathState) -> bool:
        """Whether it has jumped from its last state to the older one, and the target lies farther on."""
        return (older.totals.area_rep - last.totals.area_rep) * (self.target - older.totals.area_rep) > 0

    @property
    def slope(self) -> float:
        """Change of ln(area) over that of the mean gap that the search saw last, or that of the surface, in 1/a0."""
        return self.work.slope if self.work.slope < 0 else asperity_slope(self.problem, self.target)

    def short(self, state: PathState, before: PathState) -> bool:
        """Whether a state is on that side of the target on which the one before it is."""
        sign = 1.0 if before.totals.area_rep < self.target else -1.0
        return (self.target - state.totals.area_rep) * sign > 0

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
        worth = partial(self._worth, None if before is None else before.totals.area_rep, jump)
        passed = partial(self._passed, before.totals.area_rep) if before is not None and stop else None
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
