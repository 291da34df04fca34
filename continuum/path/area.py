"""The state at a given repulsive area: a root in the mean gap, on one branch.

The area is a count of points that falls with the gap, but with jumps, and differs between approach and retraction.  So
root finders that may evaluate anywhere do not serve: a trial must start from a state on its own side of the root.  The
root is kept in a bracket of two equilibria, ``before`` and ``after`` in the direction of the search, by the secant of
the logarithm of the area (near full contact of what is left of the surface), or by halving where that is slow; each
trial starts from ``before``.  Without adhesion there
is one state at each mean gap, and trials have a looser tolerance: a state that meets the target is solved to the full
one and looked at again.  With adhesion a loose trial may be about to jump, and there is no way back from that.

Where no state is known, the approach is followed on the coarsest grid that carries the surface, up to just before the
target, and carried from grid to grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.coarser import carried_gap, coarser_problem
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import Branch, Outcome, PathState, Search, event, numbers
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver

LOOSE, LOOSEST = 100.0, 1e-5
"""Tolerance of trials, in units of the tolerance asked for, but at most so much, in E*: beyond, areas say nothing."""
NARROW = 0.5
"""Beyond this contact trials have the full tolerance: what is left of the gap is too small for a loose one."""
FEW_POINTS = 4.5
"""A change of the area by fewer points is no jump before the bracket is a sixteenth of the resolution."""
COARSER = 3.0
"""Tolerances and resolution of the search on the next coarser grid, in units of those on this one."""
MOST_TRIALS = 80
"""A search gives up after so many equilibria."""
RIGID = (0.2, 100.0)
"""Step of a search at least and at most, in units of the one that would do if the surface moved rigidly: it gives way,
the less there is left to go the more."""
DECAY, FIRST = 2.2, 4.0
"""The area of rough surfaces decays with the mean gap as exp(-2.2 u/h_rms) (Persson, Phys. Rev. Lett. 99, 125502
(2007), has 2 - 2.5); a first step by that is at most so many times the rigid one."""
WEAK = 0.3
"""Range, in h_rms, up to which the attraction adds little to the area where a search begins."""


class _Work:
    """What a search has cost, in FFT pairs of one grid, and the last d ln(area)/d(mean gap) that it saw."""

    def __init__(self, size: int) -> None:
        self.size, self.pairs, self.solves, self.slope = size, 0.0, 0, np.nan

    def add(self, state: PathState) -> PathState:
        self.pairs += state.solution.fft_pairs * state.solution.gap.size / self.size
        self.solves += 1
        return state


@dataclass(frozen=True)
class _Aim:
    """What is looked for, and how."""

    problem: ContactProblem
    target: float
    settings: Settings
    loose: Settings
    """Tolerance of trials."""
    search: Search
    branch: Branch
    solver: Solver
    work: _Work

    @property
    def allowed(self) -> float:
        """Largest difference from the target: relative to the contact, or to what is left of the surface beside it."""
        smaller = min(self.target, 1 - self.target)
        return max(self.search.area_tolerance * smaller, 0.5 / self.problem.grid.size) * (1 + 1e-9)

    def met(self, state: PathState) -> bool:
        return abs(state.totals.area_rep - self.target) <= self.allowed

    def short(self, state: PathState, before: PathState) -> bool:
        """Whether a state is on that side of the target on which the one before it is."""
        sign = 1.0 if before.totals.area_rep < self.target else -1.0
        return (self.target - state.totals.area_rep) * sign > 0

    def trial(self, mean_gap: float, settings: Settings, start: Real | None, *, near: bool = False) -> PathState:
        """Equilibrium at a mean gap; near its start it is looked for in the basin of that only."""
        # Without adhesion there is one basin only.
        if near and self.problem.wall.work_of_adhesion > 0:
            settings = replace(settings, warm_grids=0)
        state = equilibrium(self.problem, "mean-gap", mean_gap, settings, start, self.branch, self.solver)
        return self.work.add(state)

    def done(self, state: PathState, outcome: Outcome | None = None, beyond: PathState | None = None) -> PathState:
        events = () if beyond is None else (event("mean-gap", self.branch, state, beyond),)
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


def find_area(
    problem: ContactProblem,
    target: float,
    settings: Settings,
    search: Search,
    previous: Sequence[PathState] = (),
    branch: Branch = "start",
    solver: Solver | None = None,
    *,
    loose: Settings | None = None,
    work: _Work | None = None,
) -> PathState:
    """State of a given repulsive area, as a fraction of A0.

    Parameters
    ----------
    search : tolerance of the area, and resolution of a jump over it.
    previous : the last state of the path and, before it, the numbers of another one of it, or of the state beyond a
        jump that it has met; none to begin apart.  A list is left with the last state before the target that was found.
    branch : direction, kept with the state.
    solver : of this problem's grid and response; one of its own if None.
    loose, work : settings of trials and work so far, where a search is part of another.

    Returns
    -------
    State
        With the work of the search apart from that of its own solve.  :attr:`Outcome.JUMPED_OVER` where the area jumps
        over the target: the state is then the one before the jump, and has the one beyond it and the event.
    """
    solver, work = solver or solver_of(problem, settings), work or _Work(problem.grid.size)
    careful = problem.wall.work_of_adhesion > 0 or target > NARROW
    loose = loose or (settings if careful else _loosened(settings))
    aim = _Aim(problem, target, settings, loose, search, branch, solver, work)
    known = previous if isinstance(previous, list) else list(previous)
    after = None
    if known:
        older = known[0] if len(known) == 2 else None
        del known[:-1]
        if aim.met(known[0]):
            return replace(aim.done(known[0]), solution=replace(known[0].solution, work=(), iterations=0, seconds=0.0))
        if older is not None:
            work.slope = _slope(older, known[0], problem.grid.size)
            after = older if _beyond(older, known[0], target, branch) else None
    else:
        known.append(_apart(aim))
        if not known[0].status.ok:
            return aim.done(known.pop())
    return _close_in(aim, known, _Bracket(aim, after))


def _close_in(aim: _Aim, known: list[PathState], bracket: _Bracket) -> PathState:
    """Trials from the last state before the target, the one in ``known``, until one of them meets it."""
    now, misled = aim.loose, False
    while aim.work.solves < MOST_TRIALS:
        before = known[0]
        if aim.met(before) and now == aim.settings:
            return aim.done(before)
        mean_gap, closed = bracket.next(before)
        if now != aim.settings and (closed or aim.met(before)):
            # The last state to the full tolerance.
            now = aim.settings
            state = aim.trial(before.mean_gap, now, before.gap, near=True)
        else:
            state = aim.trial(mean_gap, now, before.gap, near=misled or bracket.after is not None)
            if closed:
                if state.status.ok and not (aim.met(state) or aim.short(state, before)):
                    return aim.done(before, Outcome.JUMPED_OVER, state)
                # The end beyond was found by a looser trial, or one over coarser grids, or from another start.
                bracket.after, misled = None, True
        if not state.status.ok:
            return aim.done(state)
        if closed or aim.met(state) or aim.met(before) or aim.short(state, before):
            bracket.stalled = state.totals.area_rep == before.totals.area_rep
            if state.mean_gap != before.mean_gap:
                aim.work.slope = _slope(before, state, aim.problem.grid.size)
            known[:] = [state]
        else:
            bracket.after = numbers(state)
        del before, state  # while the next one is looked for, one field is held
    return aim.done(known[0], Outcome.NOT_FOUND)


class _Bracket:
    """The mean gaps between which the target lies: of the last state before it and, if known, of one beyond it."""

    def __init__(self, aim: _Aim, after: PathState | None) -> None:
        self.aim, self.after = aim, after
        self.width, self.span, self.slow = np.inf, np.inf, 0
        self.step, self.stalled = 0.0, False

    def next(self, before: PathState) -> tuple[float, bool]:
        """Mean gap of the next trial, and whether it is the far end of a bracket that is to be made no narrower."""
        if self.after is not None and self.aim.short(self.after, before):
            self.after = None
        if self.after is None:
            return self._onward(before), False
        return self._between(before, self.after)

    def _onward(self, before: PathState) -> float:
        """Next mean gap outside of the bracket; farther if the area did not change on the last step."""
        problem, target, resolution = self.aim.problem, self.aim.target, self.aim.search.area_resolution
        self.width, self.span, self.slow = np.inf, np.inf, 0
        guess = abs(_step(problem, before, target, self.aim.work.slope))
        self.step = max(guess, 2 * self.step if self.stalled else resolution)
        mean_gap = before.mean_gap - (self.step if before.totals.area_rep < target else -self.step)
        return max(mean_gap, (before.mean_gap + _lowest(problem)) / 2)

    def _between(self, before: PathState, after: PathState) -> tuple[float, bool]:
        """Next mean gap inside of the bracket: by the secant, or half the way where that is slow."""
        old, self.width = self.width, abs(before.mean_gap - after.mean_gap)
        wider, self.span = self.span, abs(before.totals.area_rep - after.totals.area_rep)
        # Close to the bound of a hard wall all that is left of the mean gap may be less than the resolution.
        resolution = self.aim.search.area_resolution * min(1.0, before.mean_gap - self.aim.problem.wall.bound)
        # As for all jumps: the change of the area no longer shrinks with the bracket.  That of a few points shrinks by
        # steps only.
        shrinks = self.span <= 0.75 * wider or self.span * self.aim.problem.grid.size < FEW_POINTS
        closed = self.width <= resolution * (1 / 16 if shrinks else 1.0)
        self.slow += self.width > old / 2
        fraction = 1.0 if closed else 0.5
        if not closed and self.slow <= 1:
            fraction = _fraction(before, after, self.aim.target, self.aim.problem.grid.size)
        return before.mean_gap + fraction * (after.mean_gap - before.mean_gap), closed


def _lowest(problem: ContactProblem) -> float:
    """Mean gap below which there is no state: in full contact a soft wall gives way below zero_gap, up to its core."""
    return max(problem.wall.core, problem.wall.bound)


def _weak(problem: ContactProblem) -> bool:
    """Whether a search may count on the area of rough surfaces without adhesion, or nearly so."""
    return problem.wall.range < WEAK * float(_sample(problem.heights).std())


def _loosened(settings: Settings) -> Settings:
    return replace(settings, tolerance=max(settings.tolerance, min(LOOSE * settings.tolerance, LOOSEST)))


def _beyond(older: PathState, last: PathState, target: float, branch: Branch) -> bool:
    """Whether the path has jumped over the target before, from the last state to the older one."""
    same = (older.branch == "retract") == (branch == "retract")
    return same and (older.totals.area_rep - target) * (last.totals.area_rep - target) < 0


def _logarithm(area: float, size: int) -> float:
    """The area on a scale on which it is nearly linear in the mean gap: ln A, but -ln(1 - A) beyond half contact.

    Both are joined with one value and slope.  No area, and full contact, count as half a point less.
    """
    half = 0.5 / size
    area = min(max(area, half), 1 - half)
    return float(np.log(area) if area <= 0.5 else 2 * np.log(0.5) - np.log(1 - area))


def _slope(one: PathState, other: PathState, size: int) -> float:
    change = other.mean_gap - one.mean_gap
    rise = _logarithm(other.totals.area_rep, size) - _logarithm(one.totals.area_rep, size)
    return rise / change if change else np.nan


def _fraction(before: PathState, after: PathState, target: float, size: int) -> float:
    """Part of the way from ``before`` to ``after`` at which the secant meets the target."""
    low, high = (_logarithm(state.totals.area_rep, size) for state in (before, after))
    return float(np.clip((_logarithm(target, size) - low) / (high - low), 0.02, 0.98))


def _step(problem: ContactProblem, before: PathState, target: float, slope: float) -> float:
    """Step by which the mean gap is lowered.

    The area changes less than if the surface were moved rigidly, which gives the scale.
    """
    wall, gap = problem.wall, _sample(before.gap)
    rigid = float(np.quantile(gap, target)) - wall.zero_gap
    if before.totals.area_rep == 0:
        return rigid
    fewest, most = RIGID
    if not slope < 0:
        if not _weak(problem):
            return rigid
        slope, fewest, most = -DECAY / float(_sample(problem.heights).std()), 1.0, FIRST
    size = problem.grid.size
    secant = (_logarithm(before.totals.area_rep, size) - _logarithm(target, size)) / slope
    return float(np.clip(secant / rigid, fewest, most)) * rigid if rigid else secant


def _sample(field: Real) -> Real:
    """Every k-th row and column, about a million points."""
    k = max(1, round((field.size / 1e6) ** 0.5))
    return field[::k, ::k]


# --- where no state is known -------------------------------------------------------------------------------


def _apart(aim: _Aim) -> PathState:
    """A state on the approach, at the target or just before; without adhesion, where there is one branch, beside it."""
    problem, target = aim.problem, aim.target
    adhesive, tolerance = problem.wall.work_of_adhesion > 0, aim.search.area_tolerance

    def short(state: PathState) -> bool:
        return state.status.ok and (not adhesive or state.totals.area_rep <= target + aim.allowed)

    weak = _weak(problem)
    # A grid of half the points sees up to a hundredth more area; what is found beyond the target is of no use on a
    # branch, and costs most where attraction is strong.
    parts: tuple[float, ...] = (1 - tolerance, 0.8, 0.5)
    if not adhesive:
        parts = (1 + 0.8 * tolerance,)
    elif weak:
        parts = (1 - 0.5 * tolerance, 1 - 3 * tolerance, 0.8, 0.5)
    for part in parts:
        guess = _from_coarser(aim, min(part * target, 1.0))
        if guess is None:
            break
        state = aim.trial(guess[0], aim.loose, guess[1])
        if short(state):
            return state
        del guess, state
    heights = _sample(problem.heights)

    def overlapping(part: float) -> float:
        """Mean gap at which, undeformed, this part of the target would overlap."""
        return problem.wall.zero_gap + problem.mean_height - float(np.quantile(heights, min(part * target, 1.0)))

    # Of what would overlap, a little less than a half touches; strong attraction adds to it.
    for part in (1.2, 0.5, 0.1) if weak else (0.5, 0.1):
        if (mean_gap := overlapping(part)) <= _lowest(problem):
            continue
        state = aim.trial(mean_gap, aim.loose, None)
        if short(state):
            return state
        del state
    return aim.trial(overlapping(0.0) + min(problem.wall.range, 10.0), aim.loose, None)


def _from_coarser(aim: _Aim, target: float) -> tuple[float, Real] | None:
    """Mean gap and gap of the state of that area on the next coarser grid, if that carries the surface."""
    coarse, loose, search = coarser_problem(aim.problem, aim.solver.smallest), aim.loose, aim.search
    if coarse is None:
        return None
    rough = replace(loose, tolerance=max(COARSER * loose.tolerance, _loosened(loose).tolerance))
    # Never so rough that the guess says nothing: after many grids the tolerance would exceed the area itself.
    tolerance = max(search.area_tolerance, min(COARSER * search.area_tolerance, 0.3))
    roughly = replace(search, area_tolerance=tolerance, area_resolution=COARSER * search.area_resolution)
    found = find_area(coarse, target, rough, roughly, (), aim.branch, loose=rough, work=aim.work)
    if not found.solution.status.ok:
        return None
    # What is left to the target, by the slope that the search saw last.
    size, slope = coarse.grid.size, aim.work.slope
    left = _logarithm(target, size) - _logarithm(found.totals.area_rep, size)
    step = left / slope if slope < 0 and _weak(coarse) else 0.0
    return found.mean_gap + step, carried_gap(coarse, aim.problem, found)
