"""The state at a given repulsive area: a root, looked for on one branch.

The area is a count of points that rises as the wall comes nearer, but with jumps, and differs between approach and
retraction.  So root finders that may evaluate anywhere do not serve: a trial must start from a state on its own side of
the root, or from the undeformed surface.  The root is kept in the bracket of all searches
(:class:`continuum.path.crossing.Bracket`), between the last equilibrium before the target, in the direction of the
search, and one beyond it.  Its places are mean gaps or, under a hard wall, where the area follows the load and the mean
gap vanishes towards full contact, logarithms of the mean pressure.

A trial is looked at when it has reached a looser tolerance, and goes on to the one asked for only if its area serves:
if it meets the target or, where a branch is followed, has not gone beyond it.

Where no state is known, the same search on a coarser grid tells where to begin, and with which gap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.coarser import carried_gap, coarser_problem
from continuum.path.crossing import Bracket
from continuum.path.equilibrium import equilibrium, loosened, solver_of
from continuum.path.estimates import (
    area_argument,
    asperity_slope,
    attracts_little,
    first_height,
    lowest_height,
    pressure_of_full_contact,
    sample,
    step_to,
    usual_pressure,
)
from continuum.path.state import Branch, Control, Outcome, PathState, Search, event, height, nearness, numbers
from continuum.solve.solution import FinerTolerance, Settings, Status
from continuum.solve.solver import Solver

MOST_TRIALS = 40
"""A search gives up after so many equilibria on its grid."""
RESOLUTION = 1e-3
"""Width in mean gap down to which jumps are bracketed, in rms heights, where none is given."""
FEW_POINTS = 4.5
"""A change of the area by fewer points is no jump before the bracket is a sixteenth of the resolution."""
NEARLY = 8.0
"""Width of a bracket, in resolutions, from which on it is halved: there is a jump, which no secant finds."""
LITTLE = 0.3
"""What is left of ln(area) at most for a step without a trial: by the slope, which is known to a fifth or so."""
FEWEST, STEEPEST = 10.0, (4.0, 40.0)
"""Points by which areas must differ to tell a slope, and the largest one of small areas and of large ones, in units of
that of the surface."""
GROWTH, JUMP_STEP = 8.0, 4.0
"""Steps outside of the bracket, over the last one at most, and where a coarser grid has jumped over the area: there
the first is as long as the coarse bracket.  Steps as long as the resolution took 1.03 to 1.36 times the pairs."""
NO_PRESSURE = 1e-6
"""Mean pressure of a hard wall that is none, in tolerances."""
LARGE, BY_PRESSURE = 0.5, 2
"""Areas beyond this, of contacts that are apart, are looked for by mean pressure first, in so many trials: it tells
more there than the mean gap, of which hardly any is left.  Under a hard wall, whose places are pressures throughout, a
solve of 95 % takes 25 pairs, and 250 to 1000 at its mean gap."""
COARSER, LAST = 3.0, 0.5
"""Resolution of the search on the next coarser grid and tolerance of its area, in units of those on this one; on the
last one before the finest the second."""
CARRIED, FARTHER, NO_FARTHER = 30.0, 1000.0, 1e-4
"""Tolerances on a coarser grid, in units of that of the finest one: of the state that is carried from there, and of
trials, which only tell where to begin; but at most the last, in E*."""


def find_area(
    problem: ContactProblem,
    target: float,
    settings: Settings,
    search: Search,
    previous: Sequence[PathState] = (),
    branch: Branch = "start",
    solver: Solver | None = None,
) -> PathState:
    """State of a given repulsive area, as a fraction of A0.

    Parameters
    ----------
    search : tolerance of the area, and resolution of a jump over it.
    previous : the last state of the path and, before it, the numbers of another one of it, or of the state beyond a
        jump that it has met; none to begin apart.  A list is left with the last state before the target that was found.
    branch : direction, kept with the state.
    solver : of this problem's grid and response; one of its own if None.

    Returns
    -------
    State
        With the work of the search apart from that of its own solve.  :attr:`Outcome.JUMPED_OVER` where the area jumps
        over the target, :attr:`Outcome.NOT_FOUND` where the search was given up: the state is then the one before the
        target, and has numbers of the one beyond it, if some was met, and both as its event.
    """
    known = previous if isinstance(previous, list) else list(previous)
    seek = _AreaSearch(problem, target, settings, loosened(settings), search, branch, solver, _Work(problem.grid.size))
    found = None
    if known:
        found = seek.follow(known[-1], known[0] if len(known) == 2 else None)
        # While the next states are looked for, none but theirs is held.
        del known[:]
    found = found or seek.run()
    known.extend([] if seek.start is None else [seek.start])
    return found


class _Work:
    """What a search has cost on all grids, in FFT pairs of the finest one, whose points are given."""

    def __init__(self, size: int) -> None:
        self.size, self.pairs, self.solves = size, 0.0, 0

    def add(self, state: PathState) -> PathState:
        self.pairs += state.solution.fft_pairs * state.solution.points / self.size
        self.solves += 1
        return state


class _AreaSearch:
    """The search on one grid: what is looked for, and how far it has come."""

    def __init__(
        self,
        problem: ContactProblem,
        target: float,
        settings: Settings,
        loose: Settings,
        search: Search,
        branch: Branch,
        solver: Solver | None,
        work: _Work,
    ) -> None:
        self.problem, self.target, self.search, self.branch, self.work = problem, target, search, branch, work
        self.solver = solver or solver_of(problem, settings)
        self.settings, self.loose = settings, loose
        """Settings for the state that is sought, and for its trials."""
        self.hard, self.adhesive = problem.wall.bound == 0, problem.wall.work_of_adhesion > 0
        self.is_coarse = problem.grid.size < work.size
        """Whether this is a coarser grid, which is asked for where to begin only."""
        self.along = False
        """Whether a branch is followed, so that what a trial starts from has to be an equilibrium of it."""
        self.sign = 1.0
        """1 from less than the target to more, -1 on the way back."""
        self.bracket = Bracket()
        self.before: PathState | None = None
        """Last state before the target; its numbers only, where the next trial does not start from it."""
        self.beyond: PathState | None = None
        """Numbers of the state at the other end of the bracket."""
        self.beyond_solved = False
        """Whether that was solved to the tolerance asked for, from a state before the target within the resolution.

        Found from farther away it may be another one, of 1.39 % of the area instead of 1.32 %.
        """
        self.start: PathState | None = None
        """State that the next trial starts from: the one before or, without adhesion, the last one."""
        self.carried: tuple[Real, float] | None = None
        """Gap from a coarser grid, and its place."""
        self.slope, self.step, self.stalled = np.nan, 0.0, False
        """Change of ln(area) with the place, as seen last; the last step outside of the bracket, and whether it did not
        get halfway."""
        self.ahead: float | None = None
        """Place of the first trial on a path, where it has met a state between the last one and the target."""
        self.hint = 0.0
        """Step in which a jump over the area is looked for, where a coarser grid has met one."""
        self.wider = self.span = np.inf
        """Change of the area over the last bracket, and over this one."""
        self.jumps = False
        """Whether there is a jump in the bracket, to which no secant leads."""
        self.trials = 0

    # --- places: the area rises with them ---

    def place(self, state: PathState) -> float:
        """Coordinate of the search: ln P of a state under a hard wall, else the negative of its mean gap."""
        return float(np.log(state.load)) if self.hard else -height(self.problem, state)

    def scale(self, area: float) -> float:
        """What the bracket is about: 0 at the target, and near it ln(area/target), nearly.

        The logarithm of the pressure that random surfaces have at this area, as they have without adhesion; of large
        areas, where a soft wall gives way in proportion, the pressure.
        """
        wanted, found = (area_argument(each, self.problem.grid.size) for each in (self.target, area))
        return found / wanted - 1 if self.target > LARGE and not self.hard else float(np.log(found / wanted))

    def left(self, state: PathState, part: float = 1.0) -> float:
        """What is left from a state to a part of the target, in ln(area)."""
        return self.scale(part * self.target) - self.scale(state.area_rep)

    @cached_property
    def usual_slope(self) -> float:
        """Change of ln(area) with the place, of a surface like this one without adhesion."""
        return 1.0 if self.hard else -asperity_slope(self.problem, self.target)

    @property
    def steepest(self) -> float:
        """Slope beyond which the area has jumped; a soft wall near full contact gives way by little."""
        return STEEPEST[self.target > LARGE] * self.usual_slope

    @property
    def known_slope(self) -> float:
        """Slope that the search has seen last, or else the usual one."""
        return self.slope if self.slope > 0 else self.usual_slope

    @cached_property
    def height(self) -> float:
        """What mean gaps are measured in: the rms height or, of a flat surface, the range of the attraction, in a0."""
        return float(sample(self.problem.grid, self.problem.heights).std()) or self.problem.wall.range

    @property
    def resolution(self) -> float:
        """Width in places down to which a jump is bracketed: pressures that differ by the tolerance are the same."""
        if self.hard:
            return self.settings.tolerance / self.full if np.isfinite(self.full) else self.settings.tolerance
        given = self.search.area_resolution
        return RESOLUTION * self.height if given is None else given

    @property
    def least(self) -> float:
        """Mean pressure under a hard wall that is none."""
        return NO_PRESSURE * self.settings.tolerance

    @cached_property
    def full(self) -> float:
        """Mean pressure of full contact under a hard wall, or that at which it yields; infinite if unknown."""
        full = np.inf if self.problem.open_boundary is not None else pressure_of_full_contact(self.problem)
        return min(full, self.problem.wall.hardness) if full > 0 else np.inf

    # --- what serves ---

    @cached_property
    def allowed(self) -> float:
        """Largest difference from the target: relative to the contact, or to what is left of the surface beside it."""
        smaller = min(self.target, 1 - self.target)
        return max(self.search.area_tolerance * smaller, 0.5 / self.problem.grid.size) * (1 + 1e-9)

    def met(self, area: float) -> bool:
        return abs(area - self.target) <= self.allowed

    def short(self, area: float) -> bool:
        """Whether an area is on the near side of the target."""
        return self.sign * (self.target - area) > 0

    def rough(self, state: PathState) -> bool:
        """Whether a state is not solved to the tolerance that is asked for."""
        return state.solution.residual > 2 * self.settings.tolerance

    # --- where it begins ---

    def follow(self, last: PathState, older: PathState | None) -> PathState | None:
        """Begin from the last state of a path, and what is known of an older one; the state, if it is the last one."""
        if self.hard and not last.load > 0:
            return None
        self.along = self.adhesive
        if self.met(last.area_rep):
            # What is kept of a state is no solution, and may have been found to another tolerance.
            self.start = last
            state = self._trial(self._control(self.place(last)), tight=True, near=True)
            if self.met(state.area_rep) or not state.status.ok:
                return self._done(state)
            last, older = state, None
        self.sign = 1.0 if last.area_rep < self.target else -1.0
        self._take(last)
        if older is None or not (self.adhesive or older.load > 0):
            return None
        # Whether the path has jumped from its last state to the older one: over the target, or towards it.
        same = (older.branch == "retract") == (self.branch == "retract")
        if same and not self.short(older.area_rep):
            self._take(older, holds=False)
        if self.branch == "approach":
            # On the way back contacts are held that long steps lose.  The slope is halfway to that of the summits.
            self._see(older, last)
            if self.slope > 0:
                self.slope = float(np.sqrt(self.slope * self.usual_slope))
            if self.sign * (older.area_rep - last.area_rep) > 0 and self.short(older.area_rep):
                self.ahead = self.place(older) + self.left(older) / self.known_slope
        return None

    def _begin(self) -> tuple[Control, float]:
        """Control of the first trial where no state is known, and its value: from the next coarser grid, or a guess."""
        few = self.hard and self.target <= self.allowed
        if not few and (place := self._on_coarser_grid()) is not None:
            return self._control(place)
        problem, size = self.problem, self.problem.grid.size
        if self.hard or self._by_pressure():
            pressure = usual_pressure(problem) * area_argument(self.target, size)
            if few:
                # No point has to touch.
                pressure = 0.0
            elif self.hard and 1 - self.target <= self.allowed and np.isfinite(self.full):
                # So much more than it takes that the tolerance leaves no point open.
                pressure = self.full + self.settings.tolerance
            elif pressure == 0:
                # A flat surface touches everywhere at any pressure.
                pressure = self.settings.tolerance
            return "mean-pressure", min(pressure, 0.9 * problem.wall.hardness)
        return nearness(problem), first_height(problem, self.target)

    def _on_coarser_grid(self) -> float | None:
        """Place of that area on the next coarser grid, if there is one; a grid that carries the surface gives a gap.

        One that carries it roughly tells no more than the place, but where attraction adds little.
        """
        smallest, tolerance = self.solver.smallest, self.search.area_tolerance
        coarse, weak = coarser_problem(self.problem, smallest), attracts_little(self.problem)
        carries = coarse is not None
        coarse = coarse or coarser_problem(self.problem, smallest, roughly=True)
        if coarse is None:
            return None
        # On the last grid before the finest one the area is met so closely that no step is left.
        roughly = (COARSER if self.is_coarse or not carries else LAST) * tolerance
        roughly = min(max(roughly, FEW_POINTS / (self.target * coarse.grid.size)), max(tolerance, 0.3))
        search = self.search.model_copy(
            update={"area_tolerance": roughly, "area_resolution": None if self.hard else COARSER * self.resolution}
        )
        close = loosened(self.settings.coarser(), CARRIED, NO_FARTHER)
        loose = loosened(close, FARTHER, NO_FARTHER)
        # A grid of half the points sees up to a hundredth more area; on a branch what is beyond is of no use.
        part = 1.0 if self.target > LARGE else 1 - tolerance / 2 if self.adhesive else 1 + 0.8 * tolerance
        solver = solver_of(coarse, self.settings)
        below = _AreaSearch(coarse, part * self.target, close, loose, search, self.branch, solver, self.work)
        found = below.run()
        if not found.solution.status.ok or (self.hard and not found.load > 0):
            return None
        place, self.slope = self.place(found), below.slope
        if carries or weak:
            self.carried = carried_gap(coarse, self.problem, found), place
        if found.beyond is not None:
            # The jump is looked for where it was.
            self.hint = abs(below.place(found.beyond) - place)
        elif found.outcome is None and not self.is_coarse and tolerance / 2 < abs(left := below.left(found)) < LITTLE:
            # The finest grid is to meet the area at once, however few points a coarser one has in contact.
            place += left / self.known_slope if left > 0 or not self.adhesive else 0.0
        return place

    # --- the search ---

    def run(self) -> PathState:
        """Trials, each from the last state before the target, until one of them meets it."""
        while self.trials < MOST_TRIALS:
            if self._closed():
                found = self._at_jump()
                if found is not None:
                    return found
                continue
            if self.hard and self.before is None and self.start is not None and self.start.load < self.least:
                # Exit: the area jumps over the target at no load, where tops of one height touch at once.
                touch = self._trial(("mean-pressure", 0.0), tight=True)
                return self._done(touch, Outcome.JUMPED_OVER, self.start)
            control, at = self._next()
            before, near = self.before, self.bracket.known
            last = near and before is not None and self._within(control, at)
            state = self._trial((control, at), tight=last or self.jumps, near=near and self.adhesive, last=last)
            if state.status is Status.STOPPED:
                self.jumps = True
            elif not state.status.ok or (self.met(state.area_rep) and not self.rough(state)):
                # Exits: the state that was asked for; or no equilibrium, and why.
                return self._done(state)
            self._take(state, beyond_solved=last and before is self.start and not self.rough(state) and state.status.ok)
            del state, before  # while the next one is looked for, one field is held
        # Exit: the work allowed is done.  Known is between which states the area lies.
        nearest = self.before or self.beyond
        assert nearest is not None
        return self._done(nearest, Outcome.NOT_FOUND, self.beyond if self.before is not None else None)

    def _at_jump(self) -> PathState | None:
        """Both ends of a bracket that is to be made no narrower, as the state that was found; None to search on."""
        assert self.before is not None
        assert self.beyond is not None
        if self.is_coarse:
            # Exit: where a coarser grid jumps over the area tells where to begin; the ends are not asked for.
            return self._done(self.before, Outcome.JUMPED_OVER, self.beyond)
        if self.before is not self.start or self.rough(self.before):
            state = self._trial(self._control(self.place(self.before)), tight=True, near=True, last=True)
            if not state.status.ok or self.met(state.area_rep):
                # Exits: no equilibrium; or it has this area, once it is solved to the tolerance that is asked for.
                return self._done(state)
            self.before = self.start = state
            if not self.short(state.area_rep):
                # It was about to jump: once more from before that.
                self.before = self.start = self.carried = None
                self.bracket = self.bracket.without(upper=self.sign < 0)
                self._take(state)
                self.along = self.adhesive
                return None
        if self.beyond_solved:
            # Exit: the area jumps over the target, between two equilibria as near as asked for.
            return self._done(self.before, Outcome.JUMPED_OVER, self.beyond)
        state = self._trial(self._control(self.place(self.beyond)), tight=True, near=True, last=True)
        if not state.status.ok or self.met(state.area_rep):
            # Exits, as above.
            return self._done(state)
        if not self.short(state.area_rep):
            # Exit: the area jumps over the target.
            return self._done(self.before, Outcome.JUMPED_OVER, numbers(state))
        # The end beyond was found by a looser trial, or over coarser grids, or from another start.
        self.beyond, self.bracket = None, self.bracket.without(upper=self.sign > 0)
        self.wider = self.span = np.inf
        self._take(state)
        return None

    def _control(self, place: float) -> tuple[Control, float]:
        """Control of a place, and its value."""
        return ("mean-pressure", float(np.exp(place))) if self.hard else (nearness(self.problem), -place)

    def _by_pressure(self) -> bool:
        """Whether the next trial is by mean pressure, although places are mean gaps."""
        return not (self.along or self.hard) and self.target > LARGE and self.trials < BY_PRESSURE

    def _closed(self) -> bool:
        """Whether the bracket is to be made no narrower.

        As for all jumps: the change of the area no longer shrinks with the bracket.  That of a few points shrinks by
        steps only.
        """
        shrinks = self.span <= 0.75 * self.wider or self.span * self.problem.grid.size < FEW_POINTS
        return self.bracket.known and self.bracket.width <= self.resolution * (1 / 16 if shrinks else 1.0)

    def _within(self, control: Control, at: float) -> bool:
        """Whether a trial is within the resolution of the last state before."""
        place = float(np.log(at)) if self.hard else -at
        assert self.before is not None
        comparable = self.hard or control != "mean-pressure"
        return comparable and abs(place - self.place(self.before)) <= self.resolution

    def _next(self) -> tuple[Control, float]:
        """The next trial: where it begins, inside of the bracket, or farther on."""
        here = self.before or self.beyond
        if here is None:
            return self._begin()
        if self._by_pressure():
            arguments = [area_argument(area, self.problem.grid.size) for area in (self.target, here.area_rep)]
            pressure = here.load + usual_pressure(self.problem) * (arguments[0] - arguments[1])
            if 0 < pressure < self.problem.wall.hardness:
                return "mean-pressure", pressure
        if self.bracket.known:
            steep = self.bracket.at_upper - self.bracket.at_lower > self.steepest * self.bracket.width
            self.jumps |= steep and self.bracket.width <= NEARLY * self.resolution
            return self._control(self.bracket.inside(halve=self.jumps))
        return self._control(self._possible(self._onward(here), self.place(here)))

    def _onward(self, here: PathState) -> float:
        """Next place outside of the bracket; farther if the last step did not get halfway."""
        at, back = self.place(here), here is self.beyond
        if self.ahead is not None:
            # The step is also over what the path has jumped over.
            place, self.ahead = self.ahead, None
            self.step = abs(place - at)
            return place
        left, again = self.left(here), self.bracket.again
        if self.hint > 0:
            step, self.hint = self.hint, JUMP_STEP * self.hint
        elif back and self.adhesive:
            # To a state from rest that is short of the target: by little, then by more each time.
            part = 1 - self.search.area_tolerance / 2 if again == 0 and left > -LITTLE else 0.9 ** (again + 1)
            step = -self.left(here, part) / self.known_slope
        elif self.slope > 0 or self.hard or here is not self.start:
            step = abs(left) / self.known_slope
            step = min(step, max(GROWTH * self.step, 4 * abs(left) / self.usual_slope))
        else:
            step = step_to(self.problem, here, self.target)
        if self.hint == 0:
            step = max(step, 2 * self.step if self.stalled else self.resolution)
        self.step = step
        return at - self.sign * step if back else at + self.sign * step

    def _possible(self, place: float, here: float) -> float:
        """A place up to which there are states: full contact, or the pressure at which all yields, is not passed."""
        if self.hard:
            most = float(np.log(self.full))
            place = max(place, float(np.log(self.least / 2)))
            return place if place < most or here >= most else (here + most) / 2
        return min(place, (here - lowest_height(self.problem)) / 2)

    def _trial(
        self, given: tuple[Control, float], *, tight: bool = False, near: bool = False, last: bool = False
    ) -> PathState:
        """Equilibrium at a control.

        Near its start it is looked for on the fine grid, and in that basin, only.  With the tolerance of trials it goes
        on to the one asked for if its area serves.  It need not end once it has gone far over the target, unless it is
        the last one: that there is a jump is known by then.
        """
        control, at = given
        start = None if self.start is None else self.start.gap
        if start is None and self.carried is not None:
            gap, place = self.carried
            here = place if control == "mean-pressure" and not self.hard else (np.log(at) if self.hard else -at)
            # Attraction holds what has snapped in: from there only steps onward lead to states of the approach.
            if not self.adhesive or here >= place:
                start, near = gap, near or here == place
        settings = self.settings if tight or self.hard else self.loose
        finer = None
        if not self.hard:
            stops = self.adhesive and self.before is not None and not last and self.start is not None
            finer = FinerTolerance(self.settings.tolerance, self._worth, self._passed if stops else None)
        if near:
            settings = replace(settings, warm_grids=0)
        state = equilibrium(self.problem, control, at, settings, start, self.branch, self.solver, finer)
        self.carried = None if self.start is not None else self.carried
        self.trials += 1
        return self.work.add(state)

    def _area(self, gap: Real) -> float:
        return self.problem.grid.total(self.problem.wall.touches(gap)) / self.problem.grid.size

    def _worth(self, gap: Real) -> bool:
        """Whether a trial is to be solved to the tolerance asked for: it meets the target or, on a branch, is short."""
        area = self._area(gap)
        return self.met(area) or (self.along and self.short(area))

    def _passed(self, gap: Real) -> bool:
        """Whether a trial on its way has gone far over the target: there is a jump.

        Stopped wherever it has gone over, a search for 80 % without a jump took 1.5 times the pairs.
        """
        return self.sign * self.scale(self._area(gap)) > LITTLE

    def _take(self, state: PathState, *, holds: bool = True, beyond_solved: bool = False) -> None:
        """Go on from a state, on its side of the target; without ``holds`` from its numbers."""
        nearest = min(
            (one for one in (self.before, self.beyond) if one), key=lambda one: abs(self.left(one)), default=None
        )
        if nearest is not None and state.status is not Status.STOPPED:
            same = self.short(nearest.area_rep) == self.short(state.area_rep)
            self.stalled = same and abs(self.left(state)) > 0.5 * abs(self.left(nearest))
            if same or abs(self.left(state)) < LITTLE:
                self._see(nearest, state)
        self.bracket = self.bracket.add(self.place(state), self.scale(state.area_rep))
        if self.short(state.area_rep):
            self.before = state
            self.start = state if holds else self.start
        else:
            self.beyond, self.beyond_solved = numbers(state), beyond_solved
            if holds and not self.adhesive:
                # There is one state, from wherever it is reached: the last one serves, and one field is held.
                self.start, self.before = state, self.before and numbers(self.before)
        if np.isnan(self.bracket.at_upper if self.sign > 0 else self.bracket.at_lower):
            self.beyond = None
        if np.isnan(self.bracket.at_lower if self.sign > 0 else self.bracket.at_upper):
            self.before = None
        if self.before is not None and self.beyond is not None:
            self.wider, self.span = self.span, abs(self.before.area_rep - self.beyond.area_rep)

    def _see(self, one: PathState, other: PathState) -> None:
        """Keep the slope between two states for the steps to come, unless a few points say nothing of it."""
        if abs(other.area_rep - one.area_rep) * self.problem.grid.size > FEWEST:
            change = self.place(other) - self.place(one)
            slope = (self.scale(other.area_rep) - self.scale(one.area_rep)) / change if change else np.nan
            if 0 < slope < self.steepest:
                self.slope = float(slope)

    def _done(self, state: PathState, outcome: Outcome | None = None, beyond: PathState | None = None) -> PathState:
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
