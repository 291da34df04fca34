"""What a search for an area looks for, how closely, and what it has cost."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import equilibrium
from continuum.path.secant import area_logarithm
from continuum.path.state import Branch, Outcome, PathState, Search, event, nearness
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver

CLOSE = 10.0
"""A loose trial that misses the area by fewer tolerances is not repeated: the next one has the full tolerance."""


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

    @property
    def allowed(self) -> float:
        """Largest difference from the target: relative to the contact, or to what is left of the surface beside it."""
        smaller = min(self.target, 1 - self.target)
        return max(self.search.area_tolerance * smaller, 0.5 / self.problem.grid.size) * (1 + 1e-9)

    def met(self, state: PathState) -> bool:
        return abs(state.totals.area_rep - self.target) <= self.allowed

    def serves(self, state: PathState) -> bool:
        """Whether a search may go on from a state: on a branch, from none beyond the target."""
        return state.status.ok and (not self.adhesive or state.totals.area_rep <= self.target + self.allowed)

    def left(self, state: PathState, part: float = 1.0) -> float:
        """What is left from a state to a part of the target, in the logarithm of the area."""
        size = self.problem.grid.size
        return area_logarithm(part * self.target, size) - area_logarithm(state.totals.area_rep, size)

    def close(self, state: PathState) -> bool:
        """Whether what is left to the target is so little that the next trial may be the last."""
        return abs(state.totals.area_rep - self.target) <= CLOSE * self.allowed

    def short(self, state: PathState, before: PathState) -> bool:
        """Whether a state is on that side of the target on which the one before it is."""
        sign = 1.0 if before.totals.area_rep < self.target else -1.0
        return (self.target - state.totals.area_rep) * sign > 0

    @property
    def adhesive(self) -> bool:
        return self.problem.wall.work_of_adhesion > 0

    def trial(self, at: float, settings: Settings, start: Real | None, *, near: bool = False) -> PathState:
        """Equilibrium at a mean gap; near its start it is looked for on the fine grid, and in that basin, only."""
        if near:
            settings = replace(settings, warm_grids=0)
        state = equilibrium(self.problem, nearness(self.problem), at, settings, start, self.branch, self.solver)
        return self.work.add(state)

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
