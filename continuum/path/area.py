"""The state at a given repulsive area: a root in the mean gap, on one branch.

The area is a count of points that falls with the gap, but with jumps, and differs between approach and retraction.  So
root finders that may evaluate anywhere do not serve: a trial must start from a state on its own side of the root.  The
root is kept in a bracket of two equilibria, ``before`` and ``after`` in the direction of the search, by the secant of
the logarithm of the area (near full contact of what is left of the surface), or by halving where that is slow; each
trial starts from ``before``.

A trial is looked at when it has reached a looser tolerance, and goes on to the one asked for only if its area serves:
if it meets the target or, where a branch is followed, has not gone beyond it.  A search that begins apart may go on
from a loose trial, which may be about to jump.  If it does, the search begins again before that.

Where no state is known, the approach is followed on the coarsest grid that carries the surface, up to just before the
target, and carried from grid to grid.  On the last one before the finest the area is met so closely that the finest
grid mostly begins where it ends.  A grid that carries the surface only roughly still tells at which mean gap to begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.aim import (
    LITTLE,
    NEAR,
    Aim,
    SearchWork,
    area_logarithm,
    asperity_slope,
    attracts_little,
    carried_gap,
    coarser_problem,
    excess_range,
    loosened,
    lowest_height,
    rough_slope,
    sample,
    searched_range,
    secant_fraction,
    step_to,
)
from continuum.path.equilibrium import solver_of
from continuum.path.full_contact import LARGE, LAST_POINTS, find_nearly_full, press_towards
from continuum.path.state import Branch, Outcome, PathState, Search, height, nearness, numbers
from continuum.solve.solution import Settings, Status
from continuum.solve.solver import Solver

FEW_POINTS = 4.5
"""A change of the area by fewer points is no jump before the bracket is a sixteenth of the resolution."""
FARTHER, NO_FARTHER = 1000.0, 1e-4
"""Tolerance of trials on coarser grids, as LOOSE and LOOSEST: they only tell where to begin."""
COLD_TRIALS = 4
"""Mean gaps that are tried from the undeformed surface, before the search begins where nothing touches."""
JUMP_STEP, JUMP_TRIALS = 4.0, 4
"""Where a coarser grid has jumped over the area: steps, the first as long as its bracket and each so many times the
last, in which a state before the jump is looked for."""
APART_TRIALS = 3
"""Trials from the state of a coarser grid, one after the other, by a little of ln(area)."""
CARRIED = 30.0
"""Tolerance of the state that is carried to a finer grid, in units of that grid's: what the finer grid adds is more."""
COARSER, LAST = 3.0, 0.5
"""Resolution of the search on the next coarser grid and tolerance of its area, in units of those on this one; on the
last one before the finest the second."""
MOST_TRIALS = 80
"""A search gives up after so many equilibria."""


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
    work: SearchWork | None = None,
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
    solver, work = solver or solver_of(problem, settings), work or SearchWork(problem.grid.size)
    known = previous if isinstance(previous, list) else list(previous)
    loose = loose or loosened(settings)
    side = float(np.sign(target - known[-1].area_rep)) if known and problem.wall.work_of_adhesion > 0 else 0.0
    aim = Aim(problem, target, settings, loose, search, branch, solver, work, side)
    if known and aim.met(known[-1]):
        # What is kept of a state is no solution, and may have been found to another tolerance.
        again = aim.trial(height(problem, known[-1]), settings, known[-1].gap, near=True)
        if aim.met(again) or not again.status.ok:
            return aim.done(again)
        known[:] = [again]
    after = ahead = None
    if known:
        older = known[0] if len(known) == 2 else None
        del known[:-1]
        if older is not None:
            # Whether the path has jumped from its last state to the older one: over the target, or towards it.
            same, over = (older.branch == "retract") == (branch == "retract"), older.area_rep - target
            after = older if same and over * (known[0].area_rep - target) < 0 else None
            if branch == "approach":
                # On the way back contacts are held that long steps lose.  The slope is halfway to that of the summits.
                aim.saw(older, known[0])
                aim.work.slope = -float(np.sqrt(aim.work.slope * asperity_slope(problem, target)))
                ahead = older if (older.area_rep - known[0].area_rep) * over < 0 else None
    hard = problem.wall.bound == 0
    if target > LARGE and problem.open_boundary is None and (hard or after is ahead is None):
        if not (hard and target > LAST_POINTS):
            after = press_towards(aim, known)
            if known and aim.met(known[0]) and not aim.rough_at(known[0].solution.residual):
                return aim.done(known[0])
        if hard and not (known and aim.met(known[0])):
            return find_nearly_full(aim)
    if not known:
        first, beyond = _apart(aim)
        after = after or beyond
        known.append(first)
        if not first.status.ok:
            return aim.done(known.pop())
    return _close_in(aim, known, _Bracket(aim, after, ahead))


def _close_in(aim: Aim, known: list[PathState], bracket: _Bracket) -> PathState:
    """Trials from the last state before the target, the one in ``known``, until one of them meets it."""
    now, misled = aim.loose, False
    while aim.work.solves < MOST_TRIALS:
        before = known[0]
        rough = aim.rough_at(before.solution.residual)
        enough = aim.met(before) or (bracket.trials > 1 and aim.near(before))
        if enough and not rough:
            return aim.done(before)
        at, closed = bracket.next(before)
        if closed and aim.guesses and not rough:
            # Where the jump is tells where to begin; the state beyond it is not asked for.
            return aim.done(before, Outcome.JUMPED_OVER, bracket.after)
        if rough and (closed or enough):
            # The last state to the full tolerance.
            now = aim.settings
            state = aim.trial(height(aim.problem, before), now, before.gap, near=True)
            if aim.adhesive and state.status.ok and not (aim.met(state) or aim.short(state, before)):
                # It was about to jump: once more from before that.
                if aim.near(state):
                    return aim.done(state)
                after = numbers(state)
                del before, state
                known[:] = [_before(aim, after)]
                if not known[0].status.ok:
                    return aim.done(known[0])
                bracket = _Bracket(aim, after)
                continue
        else:
            # Without adhesion there is one state, however it is reached: coarser grids may help as they like.
            near = aim.adhesive and (misled or closed or bracket.trials > 1)
            jump = bracket.jump(before, at) if near and not (rough or closed) else np.inf
            # A trial short of a jump is cheap, and a loose one may be about to jump.
            now = aim.settings if closed or bracket.jumps else now
            stop = aim.guesses or (near and not closed and jump == np.inf)
            state = aim.trial(at, now, before.gap, near=near, before=before, jump=jump, stop=stop)
            if state.status is Status.STOPPED:
                # It is known by now that there is a jump: how far it goes is not asked for, but at the end.
                bracket.after, bracket.jumps = numbers(state), True
                continue
            over = state.status.ok and not (aim.met(state) or aim.short(state, before))
            far = abs(state.area_rep - before.area_rep) > jump and not aim.rough_at(state.solution.residual)
            if over and (closed or far):
                return aim.done(before, Outcome.JUMPED_OVER, state)
            if closed:
                # The end beyond was found by a looser trial, or one over coarser grids, or from another start.
                bracket.after, misled = None, True
        if not state.status.ok:
            return aim.done(state)
        if closed or aim.met(state) or aim.met(before) or aim.short(state, before):
            bracket.stalled = abs(aim.left(state)) > 0.5 * abs(aim.left(before))
            aim.saw(before, state)
            known[:] = [state]
        else:
            if aim.left(before) - aim.left(state) < LITTLE:
                aim.saw(before, state)
            bracket.after = numbers(state)
        del before, state  # while the next one is looked for, one field is held
    return aim.done(known[0], Outcome.NOT_FOUND)


def _before(aim: Aim, beyond: PathState) -> PathState:
    """An equilibrium short of the target, apart from a state that has gone beyond: from the undeformed surface."""
    problem = aim.problem
    for attempt in range(COLD_TRIALS):
        at = height(problem, beyond) + aim.left(beyond, 1 - aim.search.area_tolerance * 4**attempt) / aim.slope
        state = aim.trial(at, aim.settings, None)
        if aim.serves(state) or not state.status.ok:
            return state
    return _apart(replace(aim, loose=aim.settings))[0]


class _Bracket:
    """The mean gaps between which the target lies: of the last state before it and, if known, of one beyond it."""

    def __init__(self, aim: Aim, after: PathState | None, ahead: PathState | None = None) -> None:
        self.aim, self.after, self.ahead = aim, after, ahead
        self.width, self.span, self.slow = np.inf, np.inf, 0
        self.step, self.stalled, self.jumps = 0.0, False, False
        self.trials = 0

    def next(self, before: PathState) -> tuple[float, bool]:
        """Mean gap of the next trial, and whether it is the far end of a bracket that is to be made no narrower."""
        if self.after is not None and self.aim.short(self.after, before):
            self.after = None
        if self.after is None:
            return self._onward(before), False
        return self._between(before, self.after)

    def jump(self, before: PathState, at: float) -> float:
        """Change of the area beyond which a trial within the bracket is the far end of a jump; infinite if too wide."""
        if self.after is None or abs(height(self.aim.problem, before) - at) > self._resolution(before):
            return np.inf
        return max(0.75 * self.span, FEW_POINTS / self.aim.problem.grid.size)

    def _resolution(self, before: PathState) -> float:
        """Close to the bound of a hard wall all that is left of the mean gap may be less than what is asked for."""
        return self.aim.resolution * min(1.0, (before.mean_gap - self.aim.problem.wall.bound) / self.aim.height)

    def _onward(self, before: PathState) -> float:
        """Next mean gap outside of the bracket; farther if the last step did not get halfway."""
        problem, target, resolution = self.aim.problem, self.aim.target, self.aim.resolution
        self.width, self.span, self.slow, self.trials = np.inf, np.inf, 0, 0
        ahead, self.ahead = self.ahead, None
        if ahead is not None:
            # From beyond the jump; the step is also over what has been jumped over.
            at = max(height(problem, ahead) + self.aim.left(ahead) / self.aim.slope, lowest_height(problem))
            self.step = abs(height(problem, before) - at)
            return at
        guess = step_to(problem, before, target, self.aim.work.slope)
        if self.aim.work.jump > 0:
            # A trial short of the jump is cheap, one beyond is not.
            guess, self.aim.work.jump, self.jumps = self.aim.work.jump, 0.0, True
        self.step = max(guess, 2 * self.step if self.stalled else resolution)
        at, step = height(problem, before), self.step if before.area_rep < target else -self.step
        return max(at - step, (at + lowest_height(problem)) / 2)

    def _between(self, before: PathState, after: PathState) -> tuple[float, bool]:
        """Next mean gap inside of the bracket: by the secant, or half the way where that is slow."""
        self.trials += 1
        near, far = height(self.aim.problem, after), height(self.aim.problem, before)
        old, self.width = self.width, abs(far - near)
        wider, self.span = self.span, abs(before.area_rep - after.area_rep)
        # As for all jumps: the change of the area no longer shrinks with the bracket.  That of a few points shrinks by
        # steps only.
        shrinks = self.span <= 0.75 * wider or self.span * self.aim.problem.grid.size < FEW_POINTS
        closed = self.width <= self._resolution(before) * (1 / 16 if shrinks else 1.0)
        self.slow += self.width > old / 2
        fraction = 1.0 if closed else 0.5
        if not (closed or self.slow > 1 or (self.jumps and abs(self.aim.left(after)) > LITTLE)):
            fraction = secant_fraction(before, after, self.aim.target, self.aim.problem.grid.size)
        return far + fraction * (near - far), closed


# --- where no state is known -------------------------------------------------------------------------------


def _apart(aim: Aim) -> tuple[PathState, PathState | None]:
    """A state on the approach, at the target or just before, and the numbers of one beyond it if some was met.

    Without adhesion, where there is one branch, the state may lie on either side.
    """
    tolerance = aim.search.area_tolerance
    # A grid of half the points sees up to a hundredth more area; on a branch what is found beyond the target is of no
    # use.
    parts = (1 - 0.5 * tolerance, 0.8, 0.5) if aim.adhesive else (1 + 0.8 * tolerance,)
    beyond: PathState | None = None
    for part in parts:
        guess = _from_coarser(aim, min(part * aim.target, 1.0))
        if guess is None:
            break
        at, jump, step = guess.mean_gap, guess.jump, 0.0
        for attempt in range(JUMP_TRIALS if jump > 0 else APART_TRIALS):
            start = guess.start if at <= guess.farthest else None
            state = aim.trial(at, aim.loose, start, near=at == guess.found)
            if aim.serves(state):
                aim.work.jump = jump
                return state, beyond
            if not state.status.ok:
                break
            stalled = beyond is not None and abs(aim.left(state)) > 0.5 * abs(aim.left(beyond))
            if beyond is not None and jump == 0:
                aim.saw(beyond, state)
            beyond = numbers(state)
            if jump > 0:
                jump *= JUMP_STEP
                at += jump
            elif aim.guesses or aim.left(state) > -LITTLE:
                # Back by what it is beyond the target, and by a tolerance, or two; farther if the last step did not
                # get halfway.
                back = aim.left(state, 1 - (attempt + 0.5) * tolerance) / aim.slope
                step = max(back, 2 * step if stalled else 0.0)
                at += step
            else:
                break
        del guess, state
    return _undeformed(aim, beyond)


def _undeformed(aim: Aim, beyond: PathState | None) -> tuple[PathState, PathState | None]:
    """As :func:`_apart`, from the undeformed surface."""
    problem, heights, weak = aim.problem, sample(aim.problem.heights), attracts_little(aim.problem)

    level = problem.mean_height if nearness(problem) == "mean-gap" else 0.0

    def overlapping(part: float) -> float:
        """Where, undeformed, this part of the target would overlap."""
        return problem.wall.zero_gap + level - float(np.quantile(heights, min(part * aim.target, 1.0)))

    # Of what would overlap, a little less than a half touches; strong attraction adds what it reaches.
    first = [overlapping(part) + excess_range(problem) for part in (1.2 if weak else 0.8, 0.5, 0.1)]
    at = next((each for each in first if each > lowest_height(problem)), np.nan)
    for attempt in range(COLD_TRIALS if np.isfinite(at + rough_slope(problem)) else 0):
        state = aim.trial(at, aim.loose, None)
        if aim.serves(state):
            return state, beyond
        if not state.status.ok:
            break
        if attempt > 0 and beyond is not None:
            aim.saw(beyond, state)
        # Back to nine tenths of the target, and to less each time.
        beyond = numbers(state)
        at += aim.left(state, 0.9 ** (attempt + 1)) / aim.slope
        del state
    return aim.trial(overlapping(0.0) + searched_range(problem), aim.loose, None), beyond


class _Guess(NamedTuple):
    """What the next coarser grid says of an area."""

    mean_gap: float
    """At which to look for it."""
    start: Real | None
    """Gap to begin from; None to begin at rest."""
    found: float
    """Mean gap of that start."""
    farthest: float
    """Mean gap up to which to begin there: beyond, it would be the way back, on another branch."""
    jump: float
    """Width of the bracket, where the area jumps over the target there; the rest is of the state before."""


def _from_coarser(aim: Aim, target: float) -> _Guess | None:
    """Where the state of that area is on the next coarser grid, if that carries the surface.

    One that carries it roughly tells no more than the mean gap, but where attraction adds little.
    """
    coarse, search = coarser_problem(aim.problem, aim.solver.smallest), aim.search
    weak, carries = attracts_little(aim.problem), coarse is not None
    if not carries:
        coarse = coarser_problem(aim.problem, aim.solver.smallest, roughly=True)
    if coarse is None:
        return None
    close = loosened(aim.settings.coarser(), CARRIED, NO_FARTHER)
    rough = loosened(close, FARTHER, NO_FARTHER)
    # On the last grid before the finest one the area is met so closely that no step is left.
    tolerance = (COARSER if aim.guesses or not carries else LAST) * search.area_tolerance
    tolerance = min(max(tolerance, FEW_POINTS / (target * coarse.grid.size)), max(search.area_tolerance, 0.3))
    # Attraction holds what has snapped in: from there only steps onward lead to states of the approach.
    short = 1.0 - tolerance if aim.adhesive and aim.guesses else 1.0
    roughly = search.model_copy(update={"area_tolerance": tolerance, "area_resolution": COARSER * aim.resolution})
    found = find_area(coarse, short * target, close, roughly, (), aim.branch, loose=rough, work=aim.work)
    if not found.solution.status.ok:
        return None
    # What is left to the target, by the slope that the search saw last.
    size = coarse.grid.size
    left = area_logarithm(target, size) - area_logarithm(found.area_rep, size)
    # The finest grid is to meet the area at once, however few points a coarser one has in contact.
    few = tolerance if aim.guesses else min(tolerance, search.area_tolerance)
    few = few if left > 0 or not aim.adhesive else NEAR * tolerance
    step = left / aim.slope if found.outcome is None and few < abs(left) < LITTLE else 0.0
    jump = 0.0 if found.beyond is None else abs(found.mean_gap - found.beyond.mean_gap)
    start = carried_gap(coarse, aim.problem, found) if carries or weak else None
    farthest = found.mean_gap if aim.adhesive else np.inf
    return _Guess(found.mean_gap + step, start, found.mean_gap if start is not None else np.nan, farthest, jump)
