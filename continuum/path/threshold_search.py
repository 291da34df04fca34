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

import numpy as np

from continuum.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.path.aim import area_logarithm, coarser_problem, rough_slope, sample
from continuum.path.area import find_area
from continuum.path.crossing import Bracket
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import Event, Outcome, PathState, Search, side_of
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver
from continuum.theory.paper import snap_in_wavelength

WallOfWork = Callable[[float], Wall]
"""The law of a given work of adhesion, in E* a0."""
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
JUMP = 0.5
"""A change of ln r over the bracket by more is a jump of the state: ln r rises about as ln w, by the width."""


@dataclass(frozen=True, eq=False)
class _Trial:
    """A state under the law of one work of adhesion."""

    problem: ContactProblem
    state: PathState

    @property
    def work(self) -> float:
        """The work of adhesion."""
        return self.problem.wall.work_of_adhesion

    @property
    def place(self) -> float:
        """Ln w."""
        return float(np.log(self.work))

    @property
    def ratio(self) -> float:
        """ln(load_att/load_rep)."""
        pull, push = self.state.load_att, self.state.load_rep
        if pull <= 0 or push <= 0:
            return FARTHEST if pull > push else -FARTHEST
        return float(np.clip(np.log(pull / push), -FARTHEST, FARTHEST))


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

    def pay(self, state: PathState, searches: bool = False) -> None:
        """Count the work of a state."""
        part = state.solution.gap.size / self.size
        self.pairs += part * (state.solution.fft_pairs + (state.search_pairs if searches else 0.0))
        self.solves += 1 + (state.search_solves if searches else 0)

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
    place = _Place(problem, wall_of, area, settings, search, solver, trials, most)
    together = place.together(*(place.coarsely(work) if first is None else first))
    if trials.closed:
        return _found(trials, area)
    if any(map(place.none_below, trials.ends)):
        return _none(trials, area)
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

    def coarsely(self, work: float) -> tuple[float, float]:
        """Mean gap and work at the threshold of the next coarser grid; a guess where there is none."""
        coarse = coarser_problem(self.problem, self.solver.smallest) or coarser_problem(
            self.problem, self.solver.smallest, roughly=True
        )
        if coarse is None:
            wall, heights = self.problem.wall, sample(self.problem.heights)
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
        slope = rough_slope(self.problem)
        slopes = np.array([[slope, AREA_BY_WORK], [0.0, 1.0]])
        before: tuple[Real, Real] | None = None
        for _ in range(MOST_TOGETHER):
            problem = replace(self.problem, wall=self.wall_of(float(np.exp(here[1]))))
            state = equilibrium(problem, "mean-gap", float(here[0]), self.settings, None, "start", self.solver)
            self.trials.pay(state)
            if not state.status.ok:
                break
            trial = _Trial(problem, state)
            if self._at_area(state):
                self.trials.add(trial)
                if self.trials.closed or self.none_below(trial):
                    break
                if not bracketed and (apart or abs(trial.ratio) <= self.trials.width):
                    break
            size = self.problem.grid.size
            left = area_logarithm(self.area, size) - area_logarithm(state.area_rep, size)
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

    def _at_area(self, state: PathState) -> bool:
        allowed = max(self.search.area_tolerance * min(self.area, 1 - self.area), 0.5 / self.problem.grid.size)
        return abs(state.area_rep - self.area) <= allowed


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
        problem = replace(place.problem, wall=place.wall_of(min(guess, place.most)))
        state = find_area(problem, place.area, place.settings, place.search, (), "start", place.solver)
        trials.pay(state, searches=True)
        if not (state.status.ok or state.outcome is Outcome.JUMPED_OVER):
            return problem, _with_work(state, trials)
        trial = _Trial(problem, state)
        trials.add(trial)
        if trials.closed:
            return _found(trials, place.area)
        if place.none_below(trial):
            break
        # By the secant of both ends; with one of them by ln r, which rises as ln w.
        between = trials.between()
        guess = float(np.exp(trial.place - trial.ratio + trials.aim(trial.ratio) if between is None else between))
    return _none(trials, place.area)


def _none(trials: _Trials, area: float) -> tuple[ContactProblem, PathState]:
    """The last state below the threshold, or else above, and that there is none."""
    last = min(trials.ends, key=lambda trial: trial.ratio)
    found = replace(last.state, control="repulsive-area", target=area, outcome=Outcome.NO_THRESHOLD)
    return last.problem, _with_work(found, trials)


def _with_work(state: PathState, trials: _Trials) -> PathState:
    return replace(state, search_pairs=trials.pairs - state.solution.fft_pairs, search_solves=trials.solves - 1)


def _found(trials: _Trials, area: float) -> tuple[ContactProblem, PathState]:
    below, above = sorted(trials.ends, key=lambda trial: trial.ratio)
    nearest = min(below, above, key=lambda trial: (trial.state.outcome is not None, abs(trial.ratio)))
    jumped = above.ratio - below.ratio > JUMP or above.state.outcome is not None
    sides = (side_of(trial.state, trial.work) for trial in (below, above))
    found = Event("jump-in" if jumped else "threshold", "work-of-adhesion", "start", *sides)
    at = replace(nearest.state, control="repulsive-area", target=area, events=(found,))
    return nearest.problem, _with_work(at, trials)


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
