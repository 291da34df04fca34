"""The state at a given repulsive area: a root in the mean gap, on one branch.

The area is a count of points that falls with the gap, but with jumps, and differs between approach and retraction.  So
root finders that may evaluate anywhere do not serve: a trial must start from a state on its own side of the root.  The
root is kept in a bracket of two equilibria, ``before`` and ``after`` in the direction of the search, by the secant of
the logarithm of the area, or by halving where that is slow; each trial starts from ``before``.  Without adhesion there
is one state at each mean gap, and trials have a looser tolerance: a state that meets the target is solved to the full
one and looked at again.  With adhesion a loose trial may be about to jump, and there is no way back from that.

Where no state is known, the approach is followed on the coarsest grid that carries the surface, up to just before the
target, and carried from grid to grid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from continuum.model.grid import Grid, Real
from continuum.model.problem import ContactProblem
from continuum.path.state import Branch, Outcome, Search, State, event, numbers
from continuum.solve.cpu.levels import SMALLEST, prolong, restrict
from continuum.solve.smooth import Settings

__all__ = ["AtMeanGap", "find_area"]

AtMeanGap = Callable[[ContactProblem, float, Settings, Real | None, Branch], State]
"""Equilibrium at a mean gap, from a start."""

LOOSE, LOOSEST = 100.0, 1e-5
"""Tolerance of trials, in units of the tolerance asked for, but at most so much, in E*: beyond, areas say nothing."""
COARSER = 3.0
"""Tolerances and resolution of the search on the next coarser grid, in units of those on this one."""
MOST_TRIALS = 80
"""A search gives up after so many equilibria."""
RIGID = (0.2, 100.0)
"""Step of a search at least and at most, in units of the one that would do if the surface moved rigidly: it gives way,
the less there is left to go the more."""
LOST_SLOPE = 0.01
"""A grid carries a surface if the waves that it cannot resolve hold at most this part of the mean square slope."""


class _Work:
    """What a search has cost, in FFT pairs of one grid, and the last d ln(area)/d(mean gap) that it saw."""

    def __init__(self, size: int) -> None:
        self.size, self.pairs, self.solves, self.slope = size, 0.0, 0, np.nan

    def add(self, state: State) -> State:
        self.pairs += state.solution.fft_pairs * state.solution.gap.size / self.size
        self.solves += 1
        return state


def find_area(
    at: AtMeanGap,
    problem: ContactProblem,
    target: float,
    settings: Settings,
    search: Search,
    previous: Sequence[State] = (),
    branch: Branch = "start",
    *,
    loose: Settings | None = None,
    work: _Work | None = None,
) -> State:
    """State of a given repulsive area, as a fraction of A0.

    Parameters
    ----------
    at : solves at a mean gap.
    search : tolerance of the area, and resolution of a jump over it.
    previous : the last state of the path and, before it, the numbers of another one of it, or of the state beyond a
        jump that it has met; none to begin apart.  A list is left with the last state before the target that was found.
    branch : direction, kept with the state.
    loose, work : settings of trials and work so far, where a search is part of another.

    Returns
    -------
    State
        With the work of the search apart from that of its own solve.  :attr:`Outcome.JUMPED_OVER` where the area jumps
        over the target: the state is then the one before the jump, and has the one beyond it and the event.
    """
    size = problem.grid.size
    allowed = max(search.area_tolerance * target, 0.5 / size) * (1 + 1e-9)
    work = work or _Work(size)
    known = previous if isinstance(previous, list) else list(previous)
    adhesive = problem.wall.work_of_adhesion > 0
    loose = loose or (settings if adhesive else _loosened(settings))

    def trial(mean_gap: float, settings: Settings, start: Real, *, near: bool) -> State:
        # Without adhesion there is one basin only.
        settings = replace(settings, warm_grids=0) if near and adhesive else settings
        return work.add(at(problem, mean_gap, settings, start, branch))

    def met(state: State) -> bool:
        return abs(state.totals.area_rep - target) <= allowed

    def done(state: State, outcome: Outcome | None = None, beyond: State | None = None) -> State:
        events = () if beyond is None else (event("mean-gap", branch, state, beyond),)
        return replace(
            state,
            control="repulsive-area",
            target=target,
            branch=branch,
            outcome=outcome,
            beyond=beyond,
            events=events,
            search_pairs=max(0.0, work.pairs - state.solution.fft_pairs),
            search_solves=max(0, work.solves - 1),
        )

    def settled() -> State:
        """The last state to the full tolerance."""
        return trial(known[0].mean_gap, settings, known[0].gap, near=True)

    now, after, stalled, misled, step = loose, None, False, False, 0.0
    if known:
        older = known[0] if len(known) == 2 else None
        del known[:-1]
        if met(known[0]):
            return replace(done(known[0]), solution=replace(known[0].solution, work=(), iterations=0, seconds=0.0))
        if older is not None:
            work.slope = _slope(older, known[0], size)
            if _beyond(older, known[0], target, branch):
                after = older
    else:
        known.append(_apart(at, problem, target, allowed, search, loose, work, branch))
        if not known[0].status.ok:
            return done(known.pop())
    width, span, slow = np.inf, np.inf, 0
    while work.solves < MOST_TRIALS:
        before = known[0]
        if met(before) and now == settings:
            return done(before)
        sign = 1.0 if before.totals.area_rep < target else -1.0
        if after is not None and (after.totals.area_rep - target) * sign < 0:
            after = None
        closed = False
        if after is None:
            width, span, slow = np.inf, np.inf, 0
            step = max(abs(_step(problem, before, target, work.slope)), 2 * step if stalled else search.area_resolution)
            mean_gap = before.mean_gap - sign * step
            if before.mean_gap > problem.wall.zero_gap:
                # Full contact is near a mean gap of zero_gap: not beyond it, where a law ends at its core.
                mean_gap = max(mean_gap, (before.mean_gap + problem.wall.zero_gap) / 2)
        else:
            old, width = width, abs(before.mean_gap - after.mean_gap)
            wider, span = span, abs(before.totals.area_rep - after.totals.area_rep)
            # As for all jumps: the change of the area no longer shrinks with the bracket.
            closed = width <= search.area_resolution * (1.0 if span > 0.75 * wider else 1 / 16)
            slow += width > old / 2
            fraction = 1.0 if closed else 0.5 if slow > 1 else _fraction(before, after, target, size)
            mean_gap = before.mean_gap + fraction * (after.mean_gap - before.mean_gap)
        if now != settings and (closed or met(before)):
            now = settings
            state = settled()
        else:
            state = trial(mean_gap, now, before.gap, near=misled or after is not None)
            if closed:
                if state.status.ok and not met(state) and (state.totals.area_rep - target) * sign > 0:
                    return done(before, Outcome.JUMPED_OVER, state)
                after, misled = None, True  # by a looser trial, or one over coarser grids, or from another start
        if not state.status.ok:
            return done(state)
        if closed or met(state) or met(before) or (target - state.totals.area_rep) * sign > 0:
            stalled = state.totals.area_rep == before.totals.area_rep
            if state.mean_gap != before.mean_gap:
                work.slope = _slope(before, state, size)
            known[:] = [state]
        else:
            after = numbers(state)
        del before, state  # while the next one is looked for, one field is held
    return done(known[0], Outcome.NOT_FOUND)


def _loosened(settings: Settings) -> Settings:
    return replace(settings, tolerance=max(settings.tolerance, min(LOOSE * settings.tolerance, LOOSEST)))


def _beyond(older: State, last: State, target: float, branch: Branch) -> bool:
    """Whether the path has jumped over the target before, from the last state to the older one."""
    same = (older.branch == "retract") == (branch == "retract")
    return same and (older.totals.area_rep - target) * (last.totals.area_rep - target) < 0


def _log(state: State, size: int) -> float:
    """Logarithm of the area, of half a point where there is none."""
    return float(np.log(max(state.totals.area_rep, 0.5 / size)))


def _slope(one: State, other: State, size: int) -> float:
    change = other.mean_gap - one.mean_gap
    return (_log(other, size) - _log(one, size)) / change if change else np.nan


def _fraction(before: State, after: State, target: float, size: int) -> float:
    """Part of the way from ``before`` to ``after`` at which the secant meets the target."""
    low, high = _log(before, size), _log(after, size)
    return float(np.clip((np.log(target) - low) / (high - low), 0.02, 0.98))


def _step(problem: ContactProblem, before: State, target: float, slope: float) -> float:
    """By how much to lower the mean gap.

    The area changes less than if the surface were moved rigidly, which gives the scale.
    """
    wall, gap = problem.wall, _sample(before.gap)
    rigid = float(np.quantile(gap, target)) - wall.zero_gap
    if not slope < 0 or before.totals.area_rep == 0:
        return rigid
    secant = float(np.log(before.totals.area_rep / target)) / slope
    return float(np.clip(secant / rigid, *RIGID)) * rigid if rigid else secant


def _sample(field: Real) -> Real:
    """Every k-th row and column, about a million points."""
    k = max(1, round((field.size / 1e6) ** 0.5))
    return field[::k, ::k]


# --- where no state is known -------------------------------------------------------------------------------


def _apart(
    at: AtMeanGap,
    problem: ContactProblem,
    target: float,
    allowed: float,
    search: Search,
    loose: Settings,
    work: _Work,
    branch: Branch,
) -> State:
    """A state on the approach, at the target or just before."""
    for part in (1 - search.area_tolerance, 0.8, 0.5):
        guess = _from_coarser(at, problem, part * target, search, loose, work, branch)
        if guess is None:
            break
        state = work.add(at(problem, guess[0], loose, guess[1], branch))
        if state.status.ok and state.totals.area_rep <= target + allowed:
            return state
        del guess, state
    heights = _sample(problem.heights)

    def rest(part: float, reach: float) -> State:
        """Where, undeformed, this part of the target would overlap, or ``reach`` above."""
        mean_gap = problem.wall.zero_gap + reach + problem.mean_height - float(np.quantile(heights, part * target))
        return work.add(at(problem, mean_gap, loose, None, branch))

    for part in (0.5, 0.1):
        state = rest(part, 0.0)
        if state.status.ok and state.totals.area_rep <= target + allowed:
            return state
        del state
    return rest(0.0, min(problem.wall.range, 10.0))


def _from_coarser(
    at: AtMeanGap, problem: ContactProblem, target: float, search: Search, loose: Settings, work: _Work, branch: Branch
) -> tuple[float, Real] | None:
    """Mean gap and gap of the state of that area on the next coarser grid, if that carries the surface."""
    coarse = _coarser(problem)
    if coarse is None:
        return None
    rough = replace(loose, tolerance=max(COARSER * loose.tolerance, _loosened(loose).tolerance))
    # Never so rough that the guess says nothing: after many grids the tolerance would exceed the area itself.
    tolerance = max(search.area_tolerance, min(COARSER * search.area_tolerance, 0.3))
    roughly = replace(search, area_tolerance=tolerance, area_resolution=COARSER * search.area_resolution)
    found = find_area(at, coarse, target, rough, roughly, (), branch, loose=rough, work=work)
    return (found.mean_gap, _carried(coarse, problem, found)) if found.solution.status.ok else None


@dataclass(frozen=True, eq=False)
class _Cut:
    """The response of a finer grid on the waves of a coarser one."""

    stiffness_q: Real

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum."""
        assert grid.shape_q == self.stiffness_q.shape
        return self.stiffness_q


def _coarser(problem: ContactProblem) -> ContactProblem | None:
    """The same contact on every second point, if that still shows four points for each wave."""
    grid, coarse = problem.grid, problem.grid.coarser
    if coarse is None or coarse.coarser is None or min(coarse.shape) < SMALLEST:
        return None
    heights_q = grid.forward(problem.heights)
    power = (heights_q.real**2 + heights_q.imag**2) * grid.mode_weights * grid.wavenumber**2
    rows, columns = coarse.coarser.shape_q
    carried = power[np.r_[: rows // 2, grid.shape[0] - rows // 2 : grid.shape[0]], : columns - 1].sum()
    if carried < (1 - LOST_SLOPE) * power.sum():
        return None
    coarse_q = coarse.empty_q()
    restrict(heights_q, coarse_q)
    rows, columns = coarse.shape_q
    cut = np.r_[: rows // 2, grid.shape[0] - rows // 2 : grid.shape[0]]
    response = _Cut(problem.stiffness_q[cut, :columns])
    return ContactProblem(coarse, problem.wall, coarse.inverse(coarse_q), response)


def _carried(coarse: ContactProblem, fine: ContactProblem, state: State) -> Real:
    """The gap of a coarse state on the finer grid."""
    displacement_q = fine.grid.empty_q()
    level = state.mean_gap - coarse.mean_height
    prolong(coarse.grid.forward(coarse.heights + level - state.gap), displacement_q)
    gap = fine.grid.inverse(displacement_q, overwrite=True)
    np.subtract(fine.heights, gap, out=gap)
    gap += state.mean_gap - fine.mean_height
    return gap
