"""The threshold: the work of adhesion at which a surface becomes sticky, where the load at a given area changes sign.

At a given repulsive area the attraction pulls the more the larger the work of adhesion w is.  A surface is sticky, in
the sense of the paper, from the w on at which the attraction over the repulsion, r = load_att/load_rep, exceeds 1.
Mean gap and w are looked for together, by Broyden's method for ln A and ln r, which are nearly linear in the mean gap
and in ln w; first on coarser grids, which tell where to begin.  Each trial is a state from the undeformed surface, and
so on the approach: that of a neighbouring w, followed to another w, need not be.

Where that does not end, as beside jumps, the area is searched for at each w, and w is bracketed by these searches.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.path.area import find_area
from continuum.path.coarser import coarser_problem
from continuum.path.crossing import Bracket
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.estimates import area_logarithm, asperity_slope, rough_slope, sample
from continuum.path.state import Control, Event, JumpSide, Outcome, PathState, Search, side_of
from continuum.solve.solution import Settings, Status
from continuum.solve.solver import Solver
from continuum.theory.paper import snap_in_wavelength

WallOfWork = Callable[[float], Wall]
"""The law of a given work of adhesion, in E* a0."""
Kept = Callable[[tuple[Any, ...], Callable[[], list[Any]]], list[Any]]
"""Function that returns what was found at the place of a trial, and calls the other one only where nothing is kept."""
MOST_TOGETHER, MOST_SEARCHES = 12, 16
"""Trials of both unknowns on each grid, and of w alone where these did not end."""
COARSER = 3.0
"""Tolerances on the next coarser grid, in units of those on this one."""
FARTHEST = float(np.log(30.0))
"""Distance of ln r from 0 that still tells something."""
STEP, STEP_OF_WORK = 2.0, 1.0
"""Largest change of ln A that a step of the mean gap may aim at, and of ln w."""
RESOLVED, LEAST_RESOLVED = 2.0, 0.5
"""Points of the shortest wave that snaps.  Where it has fewer than the first, single points do, and a coarser grid
tells nothing of w; by the second a law is so strong that the load hardly depends on w: there is no threshold to be
found."""
AREA_BY_WORK = 0.5
"""d ln A/d ln w at a given mean gap, to begin with; d ln r/d ln w is 1."""
AT_ONCE = 4.0
"""Slope of the area, over that of rough surfaces, beyond which it is the summits' own that is begun with."""
JUMP = 0.5
"""A change of ln r over the bracket by more is a jump of the state: ln r rises about as ln w, by the width."""


@dataclass(frozen=True)
class _Trial:
    """The numbers of a state under the law of one work of adhesion: all that the search goes on from, and is kept."""

    control: Control
    """What was given: a mean gap, or an area that was searched for."""
    points: int
    """Points of the grid."""
    given: float
    work: float
    """The work of adhesion."""
    side: JumpSide
    """Its numbers, at the work of adhesion."""
    load_rep: float
    load_att: float
    pairs: float
    """FFT pairs of its grid."""
    solves: int
    status: str
    """Name of its status."""

    @property
    def place(self) -> float:
        """Ln w."""
        return float(np.log(self.work))

    @property
    def ratio(self) -> float:
        """ln(load_att/load_rep)."""
        pull, push = self.load_att, self.load_rep
        if pull <= 0 or push <= 0:
            return FARTHEST if pull > push else -FARTHEST
        return float(np.clip(np.log(pull / push), -FARTHEST, FARTHEST))

    @property
    def jumped(self) -> bool:
        """Whether the area is jumped over: the state is the one before."""
        return self.status == Outcome.JUMPED_OVER.name

    @property
    def ok(self) -> bool:
        """Whether it is an equilibrium at what was given."""
        return self.status == Status.CONVERGED.name


@dataclass(eq=False)
class _Trials:
    """The last trials on both sides of the threshold, and what all of them have cost."""

    width: float
    """Width of the bracket that is looked for, in ln w."""
    size: int
    """Points of the grid, in whose transforms the work is counted."""
    bracket: Bracket = field(default_factory=Bracket)
    """In ln w, of ln r."""
    ends: tuple[_Trial, ...] = ()
    """The trials at its ends."""
    pairs: float = 0.0
    solves: int = 0

    def pay(self, trial: _Trial) -> None:
        """Count the work of a trial."""
        self.pairs += trial.pairs * trial.points / self.size
        self.solves += trial.solves

    def add(self, trial: _Trial) -> None:
        """Take a trial at the area that is asked for; the last one on a side is that whose area is closest."""
        self.bracket = self.bracket.add(trial.place, trial.ratio)
        ends, above = (self.bracket.lower, self.bracket.upper), trial.ratio >= 0
        self.ends = (*(one for one in self.ends if (one.ratio >= 0) != above and one.place in ends), trial)

    def between(self) -> float | None:
        """Ln w of the next trial, by the secant of both ends, where it may close the bracket; None without both."""
        if not self.bracket.known:
            return None
        jumps = self.bracket.at_upper - self.bracket.at_lower - self.bracket.width > JUMP
        return self.bracket.middle if jumps else self.bracket.closing(self.width)

    @property
    def closed(self) -> bool:
        """Whether the threshold lies between two works as close as asked for."""
        return self.bracket.width <= self.width

    def aim(self, ratio: float) -> float:
        """Ln r at which the trial after one of this ln r aims: on the other side, so that the bracket closes.

        Farther beyond after each trial that has not come there: the load may depend on the work by less than it seems.
        """
        again = self.bracket.again
        aim = self.width / 3 if -self.width / 2 < ratio <= 0 or (ratio < 0 and again) else -self.width / 3
        return aim * 2.0**again


def afresh(place: tuple[Any, ...], find: Callable[[], list[Any]]) -> list[Any]:
    """Keep nothing."""
    del place
    return find()


def first_work(problem: ContactProblem) -> float:
    """Where the search begins: half of the energy of full contact, less where the range is as large as the heights."""
    energy = problem.elastic_energy(np.zeros(problem.grid.shape))
    height = float(problem.heights.std())
    return energy / 2 / (1 + problem.wall.effective_range / height)


def _resolved(wall: Wall, problem: ContactProblem, points: float) -> float:
    """Work of adhesion at which the shortest wave that snaps under a law of this kind has so many points of a grid."""
    softening = wall.largest_softening
    needed = points * problem.grid.widest_step
    return wall.work_of_adhesion * snap_in_wavelength(softening) / needed if softening > 0 else np.inf


def bracket_threshold(
    problem: ContactProblem,
    wall_of: WallOfWork,
    area: float,
    settings: Settings,
    search: Search,
    width: float,
    solver: Solver | None = None,
    first: tuple[float, float] | None = None,
    kept: Kept = afresh,
) -> tuple[ContactProblem, PathState]:
    """The state at a given area whose load is nearest to zero, and its contact, with the law of that work of adhesion.

    Parameters
    ----------
    problem : the contact; of its wall only the range is looked at, for where to begin.
    wall_of : law for each work of adhesion in E* a0.
    area : repulsive area, as a fraction of A0.
    settings, search : of each state.
    width : of the bracket of the threshold, relative to it.
    first : mean gap and work of adhesion of an estimate, as of a state without adhesion; coarser grids are left out.
    kept : answers with the numbers of a trial that was made before, or else of the one that it has made.

    Returns
    -------
    problem, state
        The state has the bracket as its event, with the works as values: a "threshold", or a "jump-in" where the load
        jumps over zero.  :attr:`Outcome.NO_THRESHOLD` where no bracket was found; another where a state was not.
    """
    solver = solver or solver_of(problem, settings)
    trials = _Trials(float(np.log1p(width)), problem.grid.size)
    work = first_work(problem) if first is None else first[1]
    most = _resolved(wall_of(work), problem, LEAST_RESOLVED)
    place = _Place(problem, wall_of, area, settings, search, solver, trials, most, kept)
    together = place.together(*(place.coarsely(work) if first is None else first))
    if trials.closed:
        return _found(place)
    if any(map(place.none_below, trials.ends)):
        return _none(place)
    # The searches begin where the trials ended.
    return _searched(replace(place, trials=replace(trials, bracket=Bracket(), ends=())), together[1])


@dataclass(frozen=True, eq=False)
class _Place:
    """What is looked for on one grid."""

    problem: ContactProblem
    wall_of: WallOfWork
    area: float
    settings: Settings
    search: Search
    solver: Solver
    trials: _Trials = field(repr=False)
    most: float = np.inf
    """Work of adhesion up to which the grid tells something of the load."""
    kept: Kept = afresh
    states: dict[_Trial, PathState] = field(default_factory=dict, repr=False)
    """States of this process at the ends of the bracket."""

    def trial(self, control: Control, given: float, work: float) -> _Trial:
        """The trial at a mean gap, or at an area; it is made only if it was not before."""
        made = list[PathState]()

        def numbers() -> list[Any]:
            made.append(state := self.state(control, given, work))
            cost = state.solution.fft_pairs + state.search_pairs, state.search_solves + 1
            side = side_of(state, state.work_of_adhesion)
            return [*side, state.load_rep, state.load_att, *cost, state.status.name]

        points = self.problem.grid.size
        *side, load_rep, load_att, pairs, solves, status = self.kept((control, points, given, work), numbers)
        trial = _Trial(control, points, given, work, JumpSide(*side), load_rep, load_att, pairs, solves, status)
        self.trials.pay(trial)
        # Of a state that is no end of the bracket the numbers do.
        for other in self.states.keys() - set(self.trials.ends):
            del self.states[other]
        self.states.update((trial, state) for state in made)
        return trial

    def state(self, control: Control, given: float, work: float) -> PathState:
        """The state from the undeformed surface, under the law of a work of adhesion."""
        problem = self.at(work)
        if control == "repulsive-area":
            return find_area(problem, given, self.settings, self.search, (), "start", self.solver)
        return equilibrium(problem, control, given, self.settings, None, "start", self.solver)

    def at(self, work: float) -> ContactProblem:
        """The contact under the law of a work of adhesion."""
        return replace(self.problem, wall=self.wall_of(work))

    def state_at(self, trial: _Trial, **changes: Any) -> tuple[ContactProblem, PathState]:
        """The contact and the state of a trial, with what the search has taken."""
        state = self.states.pop(trial, None) or self.state(trial.control, trial.given, trial.work)
        pairs, solves = self.trials.pairs - state.solution.fft_pairs, self.trials.solves - 1
        found = replace(state, control="repulsive-area", target=self.area, search_pairs=pairs, search_solves=solves)
        return self.at(trial.work), replace(found, **changes)

    def coarsely(self, work: float) -> tuple[float, float]:
        """Mean gap and work at the threshold of the next coarser grid; a guess where there is none."""
        coarse = coarser_problem(self.problem, self.solver.smallest) or coarser_problem(
            self.problem, self.solver.smallest, roughly=True
        )
        if coarse is None:
            wall, heights = self.problem.wall, sample(self.problem.grid, self.problem.heights)
            # Of what would overlap, undeformed, about a half touches.
            overlap = float(np.quantile(heights, 0.5 * self.area))
            return wall.zero_gap + self.problem.mean_height - overlap, work
        trials = self.trials
        roughly = replace(
            self,
            problem=coarse,
            most=_resolved(self.wall_of(work), coarse, RESOLVED),
            settings=replace(self.settings.coarser(), tolerance=COARSER * self.settings.tolerance),
            search=self.search.model_copy(update={"area_tolerance": min(COARSER * self.search.area_tolerance, 0.3)}),
            solver=solver_of(coarse, self.settings),
            trials=replace(trials, width=min(COARSER * trials.width, 0.3), bracket=Bracket(), ends=()),
        )
        found = roughly.together(*roughly.coarsely(work), bracketed=False)
        trials.pairs, trials.solves = roughly.trials.pairs, roughly.trials.solves
        return found

    def together(self, mean_gap: float, work: float, *, bracketed: bool = True) -> tuple[float, float]:
        """Trials of mean gap and work, until the threshold is bracketed, or met; returns the last, or the next ones.

        A work beyond :attr:`most` is left as it is, and only the mean gap is looked for.
        """
        apart = work > self.most
        here = np.array([mean_gap, np.log(min(work, self.most))])
        # Tops of one height touch at once: more steeply than rough surfaces by far.
        slope, summits = rough_slope(self.problem), asperity_slope(self.problem, self.area)
        slope = summits if summits < AT_ONCE * slope else slope
        slopes = np.array([[slope, AREA_BY_WORK], [0.0, 1.0]])
        before: tuple[Real, Real] | None = None
        for _ in range(MOST_TOGETHER):
            trial = self.trial("mean-gap", float(here[0]), float(np.exp(here[1])))
            if not trial.ok:
                break
            if self._at_area(trial):
                self.trials.add(trial)
                if self.trials.closed or self.none_below(trial):
                    break
                if not bracketed and (apart or abs(trial.ratio) <= self.trials.width):
                    break
            size = self.problem.grid.size
            left = area_logarithm(self.area, size) - area_logarithm(trial.side.area_rep, size)
            off = np.array([-left, trial.ratio - (self.trials.aim(trial.ratio) if bracketed else 0.0)])
            if abs(trial.ratio) == FARTHEST:
                # Nothing touches, or nothing pulls: only the area, or the work, says where to go.
                step = np.array([np.clip(left, -STEP, STEP) / slope, 0.0 if left > 0 else -off[1] / 2])
                before = None
            else:
                now = np.array([-left, trial.ratio])
                if before is not None:
                    slopes = _updated(slopes, here - before[0], now - before[1], slope)
                before = here, now
                step = -np.linalg.solve(slopes, off)
            between = self.trials.between()
            if between is not None or apart:
                # The work is by the secant of both ends, which are at the area, and the mean gap by what is left of it.
                step[1] = 0.0 if between is None or apart else between - here[1]
                step[0] = -(off[0] + slopes[0, 1] * step[1]) / slopes[0, 0]
            most = np.array([STEP / abs(slope), STEP_OF_WORK])
            here = here + np.clip(step, -most, most)
            here[1] = min(here[1], np.log(self.most))
        return float(here[0]), work if apart else float(np.exp(here[1]))

    def none_below(self, trial: _Trial) -> bool:
        """Whether the surface does not pull yet at the largest work."""
        return trial.ratio <= 0 and trial.work >= self.most * (1 - 1e-9)

    def _at_area(self, trial: _Trial) -> bool:
        allowed = max(self.search.area_tolerance * min(self.area, 1 - self.area), 0.5 / self.problem.grid.size)
        return abs(trial.side.area_rep - self.area) <= allowed


def _updated(slopes: Real, moved: Real, changed: Real, slope: float) -> Real:
    """Broyden's update, with lengths in units in which both unknowns count alike; refused if the area no longer falls
    as the gap grows, or the attraction as the work falls.
    """
    scaled = moved * np.array([slope**2, 1.0])
    if not (length := float(moved @ scaled)) > 0:
        return slopes
    new: Real = slopes + np.outer(changed - slopes @ moved, scaled) / length
    sound = new[0, 0] < 0.1 * slope and new[1, 1] > 0.2 and np.linalg.det(new) < 0.1 * slope
    return new if sound else slopes


def _searched(place: _Place, work: float) -> tuple[ContactProblem, PathState]:
    """The threshold by a search for the area at each work."""
    trials, guess = place.trials, work
    for _ in range(MOST_SEARCHES):
        trial = place.trial("repulsive-area", place.area, min(guess, place.most))
        if not (trial.ok or trial.jumped):
            return place.state_at(trial)
        trials.add(trial)
        if trials.closed:
            return _found(place)
        if place.none_below(trial):
            break
        # By the secant of both ends; with one of them by ln r, which rises as ln w.
        between = trials.between()
        guess = float(np.exp(trial.place - trial.ratio + trials.aim(trial.ratio) if between is None else between))
    return _none(place)


def _none(place: _Place) -> tuple[ContactProblem, PathState]:
    """The last state below the threshold, or else above, and that there is none."""
    return place.state_at(min(place.trials.ends, key=lambda trial: trial.ratio), outcome=Outcome.NO_THRESHOLD)


def _found(place: _Place) -> tuple[ContactProblem, PathState]:
    """The state of the smaller load at the ends of the bracket, with that as its event."""
    below, above = sorted(place.trials.ends, key=lambda trial: trial.ratio)
    nearest = min(below, above, key=lambda trial: (trial.jumped, abs(trial.ratio)))
    jumps = above.ratio - below.ratio > JUMP or above.jumped
    found = Event("jump-in" if jumps else "threshold", "work-of-adhesion", "start", below.side, above.side)
    return place.state_at(nearest, events=(found,))


def laws_of(wall: WallOfWork, problem: ContactProblem) -> WallOfWork:
    """The laws of each work of adhesion, each looked at before it is used; raises ArgumentError."""
    allowed = "a function that returns the law of a work of adhesion, as LennardJonesSpline(adhesion_length=w)"
    if not callable(wall):
        raise ArgumentError("wall", wall, allowed)
    if problem.open_boundary is not None:
        raise ArgumentError("substrate", problem.substrate, "a periodic one: a threshold is that of a mean gap")

    def law_of(work: float) -> Wall:
        made = wall(work)
        if getattr(made, "law", None) is None:
            raise ArgumentError("wall", wall, allowed)
        return made

    return law_of
