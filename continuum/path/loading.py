"""Loading: one equilibrium at a given control, and paths of them, each started from those before it.

Control is by separation, mean gap or mean pressure, each one solve (:mod:`continuum.path.equilibrium`), or by repulsive
area, which is searched for (:mod:`continuum.path.area`).  A path goes to each target at once or, where jumps on the way
are looked for, by steps.  The arrays of the solver are those of the whole path.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from continuum.inputs.arguments import ArgumentError, field_of, number
from continuum.measure.contact import Totals, totals_of
from continuum.model.fourier import Real
from continuum.model.laws import evaluate
from continuum.model.problem import ContactProblem
from continuum.path.area import find_area
from continuum.path.equilibrium import equilibrium, loosened, moved_rigidly, solver_of
from continuum.path.estimates import lowest_height
from continuum.path.state import (
    YIELDS,
    Branch,
    Control,
    Event,
    Outcome,
    PathState,
    Search,
    check_target,
    coordinate,
    event,
    gone,
    kept,
    nearness,
    numbers,
    settled,
)
from continuum.solve.solution import FinerTolerance, Settings
from continuum.solve.solver import Solver

_CONTROLS: dict[str, Control] = {
    "area": "repulsive-area",
    "mean_gap": "mean-gap",
    "separation": "separation",
    "pressure": "mean-pressure",
}
"""A control by the name of the argument that gives it."""
FARTHEST = 1e12
"""Larger gaps (in a0) or pressures (in E*) are refused: they would overflow in the energy."""
GROWTH = 2.0
"""Step over the last one, at most, and how much farther than over its length the last change is believed to go on."""
SAFETY = 0.8
"""Next step in units of that on which the contact would depart by the threshold, as its square."""
STEADY = 0.75
"""The largest change of the gap shrinks with the step if it is below this part of that over a wider one."""


def solve(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    start: Real | None = None,
    branch: Branch = "start",
    search: Search | None = None,
    solver: Solver | None = None,
) -> PathState:
    """Equilibrium at one separation, mean gap, mean pressure or repulsive area.

    Parameters
    ----------
    control, target : what is given, and its value: in a0, in E* (mean pressure, compression positive), or as a
        fraction of A0 (repulsive area).
    settings : of the minimisation.
    start : gap to start from; the undeformed surface if None.  A given area is searched for from the equilibrium at
        the mean gap of the start, always from the side on which that lies.  Under given mean pressure and mean gap its
        mean does not matter.
    branch : name of the direction of loading, kept with the state.
    search : how closely a given area is met.
    solver : of this problem's grid and response, where several states are wanted; one of its own if None.

    Returns
    -------
    State
        Look at its status: a tension may be too large to be held (:attr:`Outcome.PULLED_OFF`), an area may be jumped
        over (:attr:`Outcome.JUMPED_OVER`).
    """
    check_target(control, target)
    if start is not None:
        field_of("start", start, problem.grid.shape_here)
    if control != "repulsive-area":
        return equilibrium(problem, control, target, settings, start, branch, solver)
    solver, search = solver or solver_of(problem, settings), search or Search()
    at = None if start is None else _height_of(problem, start)
    if start is None or at is None:
        return find_area(problem, target, settings, search, (), branch, solver)
    first = equilibrium(problem, nearness(problem), at, replace(settings, warm_grids=0), start, branch, solver)
    if not first.status.ok:
        return replace(first, control=control, target=target)
    found = find_area(problem, target, settings, search, [first], branch, solver)
    pairs, solves = found.search_pairs + first.solution.fft_pairs, found.search_solves + 1
    return replace(found, search_pairs=pairs, search_solves=solves)


def _height_of(problem: ContactProblem, start: Real) -> float | None:
    """Mean gap, or separation, at which a start is solved before an area is searched for from there.

    None where it makes no difference: a hard wall has one state of each area, and none at a mean gap of zero.
    """
    mean, law = problem.grid.mean(start), problem.wall.law
    if problem.open_boundary is None:
        return mean if mean > lowest_height(problem) else None
    if law is None:
        return None
    return problem.separation(mean, np.nan, lambda: evaluate(law, start)[1])


# --- paths -------------------------------------------------------------------------------------------------


def follow(
    problem: ContactProblem,
    control: Control,
    targets: Iterable[float],
    settings: Settings,
    previous: Sequence[PathState] = (),
    search: Search | None = None,
    solver: Solver | None = None,
) -> Iterator[PathState]:
    """Equilibria at each target in turn, in the order given.

    Each starts from the last converged state, shifted rigidly, never from one that failed; where an area is jumped
    over, from the state before the jump.  With ``search.event_resolution`` the way to it goes by steps that are halved
    where more changes than the threshold of an event, so that jumps on the way are bracketed.
    Where the wall has yielded it keeps its imprint for the states that follow.

    Parameters
    ----------
    previous : what the path goes on from: its last converged state, and the numbers of one more
        (:func:`continuum.path.state.numbers`), in order.  A list is kept up to date: what it holds after each state is
        all that the next one needs.  No other field is held.
    search : how closely areas are met and jumps are looked for.
    solver : of this problem's grid and response, where it serves longer than the path; one of its own if None.

    Yields
    ------
    State
        One for each target, converged or not: look at its status.
    """
    search, solver = search or Search(), solver or solver_of(problem, settings)
    good = previous if isinstance(previous, list) else list(previous)
    lost = good[-1] if good and good[-1].outcome is Outcome.PULLED_OFF else None
    good[:] = [state for state in good if state.status.ok][-2:]
    for target in targets:
        check_target(control, target)
        if control == "mean-gap" and np.isfinite(problem.wall.hardness):
            raise ArgumentError("mean-gap", target, f"another control along a path where the wall yields: {YIELDS}")
        here = settled(problem, good)
        imprint = good[-1].imprint_before if good else None
        branch, last = _branch(control, target, good), [numbers(state) for state in good[-1:]]
        if lost is not None and control == "mean-pressure" and target <= lost.target:
            yield gone(here, target, branch)
            continue
        if control == "repulsive-area":
            known = good if np.isinf(problem.wall.hardness) else list(good)  # trials leave no imprint
            state = find_area(here, target, settings, search, known, branch, solver)
        elif good and search.event_resolution is not None and problem.wall.work_of_adhesion > 0:
            state = walk(here, control, target, settings, good, branch, search, solver)
        else:
            start = moved_rigidly(here, control, good[-1], target) if good else None
            state = equilibrium(here, control, target, settings, start, branch, solver)
            del start
        state = replace(state, imprint_before=imprint)
        lost = state if state.outcome is Outcome.PULLED_OFF else None
        if lost is not None and good and not state.events:
            state = replace(state, events=(event(control, branch, good[-1], state),))
        if state.status.ok:
            good[:] = [*(last if control == "repulsive-area" else map(numbers, good[-1:])), kept(state)]
        elif state.beyond is not None:
            good[:] = [numbers(state.beyond), kept(state)]
        yield state
        del state


def _branch(control: Control, target: float, good: Sequence[PathState]) -> Branch:
    """Direction of the next target from the last state."""
    if not good:
        return "start"
    here = coordinate(control, good[-1])
    if target == here:
        return good[-1].branch
    nearer = target < here if control in ("separation", "mean-gap") else target > here
    return "approach" if nearer else "retract"


def controlled(**given: Any) -> tuple[Control, str, Any]:
    """The one control that is given, its name as an argument, and its value."""
    chosen = [name for name, value in given.items() if value is not None]
    if len(chosen) != 1:
        what = " and ".join(chosen) if chosen else "none"
        raise ValueError(f"give one of {', '.join(given)}; here: {what}")
    return _CONTROLS[chosen[0]], chosen[0], given[chosen[0]]


def target(name: str, value: Any) -> float:
    """The value of a control, within what makes sense; raises ArgumentError."""
    if name == "area":
        return number(name, value, above=0, below=1)
    return number(name, value, least=-FARTHEST, most=FARTHEST)


# --- the way to a target by steps, so that jumps on it are bracketed, and the largest tension is seen -----------


class _Way:
    """The steps of a way: where it stands, how far it goes at once, and beyond what it expects something to happen.

    Expected is that the contact changes on as it did on the last step, or not at all; only what departs from both by
    more than the threshold may be a jump.  So it is a bent path that needs short steps, not a steep one.
    """

    def __init__(self, here: float, target: float, search: Search) -> None:
        self.here, self.target, self.search = here, target, search
        self.resolution = search.event_resolution or 0.0
        self.stride, self.last, self.width = target - here, np.zeros(3), np.inf
        self.wider, self.bound, self.reach = np.inf, self.resolution, 0.0
        self.far: tuple[float, Real] | None = None

    def next(self) -> float:
        """Value at which to look next."""
        if self.far is None:
            return self.target if abs(self.stride) >= abs(self.target - self.here) else self.here + self.stride
        at, change = self.far
        steady = self.departs(change, at) <= self.search.event_threshold
        return at if steady or abs(at - self.here) <= self.bound else (self.here + at) / 2

    def departs(self, change: Real, at: float) -> float:
        """How far the change of a contact from here departs from what is expected, as a fraction of A0."""
        expected = self.last * min(abs(at - self.here) / self.width, GROWTH)
        return float(np.minimum(np.abs(change), np.abs(change - expected)).max())

    def refuse(self, at: float, change: Real, moved: float, *, reverses: bool) -> bool:
        """Whether what happens before ``at`` has to be looked at nearer: then it is remembered."""
        jumps = self.departs(change, at) > self.search.event_threshold
        self.bound = self.resolution / 16 if jumps and moved < STEADY * self.wider else self.resolution
        if not (jumps or reverses) or abs(at - self.here) <= self.bound:
            return False
        self.far, self.wider = (at, change if jumps else np.full(3, np.inf)), moved
        return True

    def go(self, at: float, change: Real, moved: float) -> bool:
        """Go on from there; whether that was a jump."""
        departs, threshold = self.departs(change, at), self.search.event_threshold
        jumped, step = departs > threshold and not moved < STEADY * self.wider, at - self.here
        if self.far is not None and at != self.far[0]:
            self.far, self.reach = (self.far[0], self.far[1] - change), max(self.reach, abs(step))
        else:
            if self.far is None and not jumped:
                growth = min(SAFETY * (threshold / departs) ** 0.5, GROWTH) if departs > 0 else GROWTH
                self.stride = growth * step
            else:
                # Beyond what has been bracketed steps are as long as before it.
                longest = min(abs(self.stride), GROWTH * max(self.reach, abs(step)))
                self.stride = float(np.copysign(longest, step))
            self.far, self.wider, self.reach = None, np.inf, 0.0
        if not jumped:
            self.last, self.width = change, abs(step)
        self.here = at
        return jumped


def walk(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    good: list[PathState],
    branch: Branch,
    search: Search,
    solver: Solver,
) -> PathState:
    """State at a target, with the jumps on the way to it; the last state before it is kept in ``good``.

    The first step is the whole way.  Where a step meets more than is expected of it by the threshold, or pulls off,
    the place is bracketed by halving, each time from the last state before it and strictly in the basin of that, until
    it is as narrow as the resolution.  It is an event if the largest change of the gap does not shrink with the step.
    Where it still does the path is steep, or flats pass through the gap at which repulsion begins: that is looked at
    down to 1/16 of the resolution.

    On the way back, a step on which a load that fell begins to rise is halved in the same way where the load may have
    been the lowest one, so that the largest tension is seen although nothing jumps.
    """
    way = _Way(coordinate(control, good[-1]), target, search)
    events: list[Event] = []
    pairs, solves = 0.0, 0
    lowest = good[-1].load, good[-1].mean_gap
    fell = good[0].load - good[1].load if len(good) == 2 else 0.0
    while True:
        at, before = way.next(), good[-1]
        worth = partial(_worth, problem, before, way, at)
        finer = FinerTolerance(settings.tolerance, worth)
        start = moved_rigidly(problem, control, before, at)
        trial = equilibrium(problem, control, at, loosened(settings), start, branch, solver, finer)
        del start
        settings = replace(settings, warm_grids=0)
        left = trial.outcome is Outcome.PULLED_OFF
        if not (left or trial.status.ok):
            break
        change = np.full(3, np.inf) if left else _change(problem, before, trial)
        # The largest change of the gap, row by row: a field of differences need not be held.
        moved = np.inf if left else problem.grid.greatest(_moves(before.gap, trial.gap))
        # What lies between is hardly lower than before by more than it fell on the last step.
        rises = 0 > trial.load > before.load and fell > max(before.load - lowest[0], 0.0)
        if not way.refuse(at, change, moved, reverses=branch == "retract" and rises and not left):
            if left or way.go(at, change, moved):
                events.append(event(control, branch, before, trial))
            fell = before.load - trial.load
            lowest = min(lowest, (trial.load, trial.mean_gap))
            if left or at == target:
                break
            good[:] = [trial]
        pairs, solves = pairs + trial.solution.fft_pairs, solves + 1
        del before, trial  # while the next one is looked for, one field is held
    return replace(trial, target=target, events=tuple(events), search_pairs=pairs, search_solves=solves, lowest=lowest)


def _moves(one: Real, other: Real) -> Real:
    """Largest difference of two gaps in each row."""
    return np.array([np.abs(a - b).max() for a, b in zip(one, other, strict=True)])


def _worth(problem: ContactProblem, before: Totals, way: _Way, at: float, gap: Real) -> bool:
    """Whether a trial is more than the end of a step that will be halved, for which a loose one does."""
    if abs(at - way.here) <= way.resolution:
        return True
    change = _change(problem, before, totals_of(problem.grid, problem.wall, gap))
    return way.departs(change, at) <= way.search.event_threshold


def _change(problem: ContactProblem, one: Totals, other: Totals) -> Real:
    """By how much two contacts differ: in repulsive area, in all area, and in attractive load, as fractions of A0."""
    repulsive = other.area_rep - one.area_rep
    load = (other.load_att - one.load_att) / problem.wall.largest_tension
    return np.array([repulsive, repulsive + other.area_att - one.area_att, load])
