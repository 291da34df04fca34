"""Loading: one equilibrium at a given control, and paths of them, each started from those before it.

Control is by separation, mean gap, mean pressure or repulsive area.  Two models with different mean compliance are
compared at equal mean gap: there the mean mode takes no part, and the separation follows from the mean pressure P as
``separation = mean gap - mean height - P/K_0`` (no value where the mean is free).  At given mean pressure the mean is
free and a uniform pressure presses: one solve as well.  A given area is searched for: :mod:`continuum.path.area`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from continuum.measure.contact import Totals
from continuum.model.grid import Real
from continuum.model.problem import ContactProblem
from continuum.path.area import find_area
from continuum.path.state import (
    Branch,
    Control,
    Event,
    Outcome,
    Search,
    State,
    coordinate,
    event,
    gone,
    kept,
    numbers,
    state_of,
)
from continuum.solve.hard import constrain
from continuum.solve.smooth import Settings, Solution, Status, Work, minimise

__all__ = ["Branch", "Control", "Search", "State", "follow", "solve"]

STRETCH = 50
"""Under tension a solve is looked at after so many iterations."""


def solve(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    start: Real | None = None,
    branch: Branch = "start",
    search: Search | None = None,
) -> State:
    """Equilibrium at one separation, mean gap, mean pressure or repulsive area.

    Parameters
    ----------
    control, target : what is given, and its value: in a0, in E* (mean pressure, compression positive), or as a
        fraction of A0 (repulsive area).
    settings : of the minimisation.
    start : gap to start from; the undeformed surface if None.  A given area is searched for from there, always from
        the side on which the start lies.  Under given mean pressure and mean gap its mean does not matter.
    branch : name of the direction of loading, kept with the state.
    search : how closely a given area is met.

    Returns
    -------
    State
        Look at its status: a tension may be too large to be held (:attr:`Outcome.PULLED_OFF`), an area may be jumped
        over (:attr:`Outcome.JUMPED_OVER`).
    """
    if control == "repulsive-area":
        previous = [] if start is None else [state_of(problem, "mean-gap", problem.grid.mean(start), branch, start)]
        return find_area(_at_mean_gap, problem, target, settings, search or Search(), previous, branch)
    if control == "mean-pressure" and target < 0 and start is None:
        # Surfaces apart hold no tension: it is applied to what rests at zero load.
        rest = solve(problem, control, 0.0, settings, None, branch)
        if not rest.status.ok:
            return replace(rest, target=target)
        pulled = solve(problem, control, target, settings, rest.gap, branch)
        return replace(pulled, search_pairs=rest.solution.fft_pairs, search_solves=1)
    lift, mean, pressure = target, problem.mean_stiffness, 0.0
    if control == "mean-gap":
        # The mean displacement is given; which separation and base belong to it is found afterwards.
        lift, mean = target - problem.mean_height, np.inf
    elif control == "mean-pressure":
        # The mean displacement is free, and counted from first touch.
        lift, mean, pressure = problem.wall.zero_gap - float(problem.heights.min()), 0.0, target
    if pressure < 0 and problem.wall.largest_tension == 0:
        return gone(problem, target, branch)
    if pressure < 0 and mean == 0:
        solution = _pull(problem, lift, start, settings, pressure)
        if not _may_hold(problem, solution.gap, -pressure):
            return gone(problem, target, branch, solution)
    else:
        solution = _minimise(problem, lift, mean, pressure, start, settings)
    if solution.status.ok and solution.gap.min() < problem.wall.core:
        solution = replace(solution, status=Status.BELOW_CORE)
    return state_of(problem, control, target, branch, solution)


def _at_mean_gap(
    problem: ContactProblem, target: float, settings: Settings, start: Real | None, branch: Branch
) -> State:
    return solve(problem, "mean-gap", target, settings, start, branch)


def _minimise(
    problem: ContactProblem, lift: float, mean: float, pressure: float, start: Real | None, settings: Settings
) -> Solution:
    """Where the solver is chosen: by whether the wall has a law, or only a bound."""
    grid, stiffness_q, law, heights = problem.grid, problem.stiffness_q, problem.wall.law, problem.heights
    posed = {"pressure": pressure, "lift": lift, "mean_stiffness": mean}
    if law is None:
        return constrain(grid, stiffness_q, heights, start, settings, **posed)
    return minimise(grid, stiffness_q, law, heights, start, settings, **posed)


def _pull(problem: ContactProblem, lift: float, start: Real | None, settings: Settings, pressure: float) -> Solution:
    """Minimise under a tension, by stretches: a surface that has left the wall would fly on to the last iteration.

    What a coarser grid does not hold this one may.
    """
    done: Solution | None = None
    while True:
        left = settings.max_iterations - (done.iterations if done else 0)
        stretch = replace(settings, max_iterations=min(left, STRETCH), warm_grids=0)
        last = _minimise(problem, lift, 0.0, pressure, start, stretch)
        done = last if done is None else _joined(done, last)
        ended = last.status is not Status.ITERATION_LIMIT or done.iterations >= settings.max_iterations
        if ended or not _may_hold(problem, last.gap, -pressure):
            return done
        start = last.gap


def _joined(first: Solution, second: Solution) -> Solution:
    """The second of two stretches, with the work of both."""
    work = tuple(
        Work(a.shape, a.fft_pairs + b.fft_pairs, a.sweeps + b.sweeps, a.fft_seconds + b.fft_seconds)
        for a, b in zip(first.work, second.work, strict=True)
    )
    return replace(
        second,
        iterations=first.iterations + second.iterations,
        work=work,
        seconds=first.seconds + second.seconds,
        history=first.history + second.history,
    )


def _may_hold(problem: ContactProblem, gap: Real, tension: float) -> bool:
    """Whether the law pulls as hard as the mean tension asks for at any gap from the smallest one on.

    Where it does not, no point pulls as hard as the mean should, and moving away makes it worse: the surface has left.
    """
    nearest = float(gap.min())
    if not np.isfinite(nearest):
        return not np.isposinf(nearest)  # a failure of another kind
    end = max(nearest, min(problem.wall.reach, nearest + 20.0))
    return -float(problem.wall.evaluate(np.linspace(nearest, end, 2001)).traction.min()) >= tension


# --- paths -------------------------------------------------------------------------------------------------


def follow(
    problem: ContactProblem,
    control: Control,
    targets: Iterable[float],
    settings: Settings,
    previous: Sequence[State] = (),
    search: Search | None = None,
) -> Iterator[State]:
    """Equilibria at each target in turn, in the order given.

    Each starts from the last converged state, shifted rigidly, never from one that failed; where an area is jumped
    over, from the state before the jump.  With ``search.event_resolution`` the way to it goes by steps that are halved
    where more changes than the threshold of an event, so that jumps on the way are bracketed.

    Parameters
    ----------
    previous : what the path goes on from: its last converged state, and the numbers of one more
        (:func:`continuum.path.state.numbers`), in order.  A list is kept up to date: what it holds after each state is
        all that the next one needs.  No other field is held.
    search : how closely areas are met and jumps are looked for.

    Yields
    ------
    State
        One for each target, converged or not: look at its status.
    """
    search = search or Search()
    good = previous if isinstance(previous, list) else list(previous)
    lost = good[-1] if good and good[-1].outcome is Outcome.PULLED_OFF else None
    good[:] = [state for state in good if state.status.ok][-2:]
    for target in targets:
        branch = _branch(control, target, good)
        if lost is not None and control == "mean-pressure" and target <= lost.target:
            yield gone(problem, target, branch)
            continue
        if control == "repulsive-area":
            state = find_area(_at_mean_gap, problem, target, settings, search, good, branch)
        elif good and search.event_resolution is not None and problem.wall.work_of_adhesion > 0:
            state = _walk(problem, control, target, settings, good, branch, search)
        else:
            start = _shifted(problem, control, good[-1], target) if good else None
            state = solve(problem, control, target, settings, start, branch)
            del start
        lost = state if state.outcome is Outcome.PULLED_OFF else None
        if lost is not None and good and not state.events:
            state = replace(state, events=(event(control, branch, good[-1], state),))
        if state.status.ok:
            good[:] = [*map(numbers, good[-1:]), kept(state)]
        elif state.beyond is not None:
            good[:] = [numbers(state.beyond), kept(state)]
        yield state
        del state


def _branch(control: Control, target: float, good: Sequence[State]) -> Branch:
    """Direction of the next target from the last state."""
    if not good:
        return "start"
    here = coordinate(control, good[-1])
    if target == here:
        return good[-1].branch
    nearer = target < here if control in ("separation", "mean-gap") else target > here
    return "approach" if nearer else "retract"


def _shifted(problem: ContactProblem, control: Control, state: State, target: float) -> Real:
    """Gap of a state moved rigidly; where the mean displacement is held or free, the solver does that by itself."""
    if control == "separation" and np.isfinite(problem.mean_stiffness):
        return state.gap + (target - coordinate(control, state))
    return state.gap


def _walk(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    good: list[State],
    branch: Branch,
    search: Search,
) -> State:
    """State at a target, with the jumps on the way to it; the last state before it is kept in ``good``.

    The first step is the whole way.  A step on which areas or attractive load change by more than the threshold is
    halved, from the same state and strictly in its basin, until it is as narrow as the resolution.  It is an event if
    the largest change of the gap does not shrink with the step.  Where it still does the path is steep, or flats pass
    through the gap at which repulsion begins: that is looked at down to 1/16 of the resolution.

    On the way back, a step on which a load that fell begins to rise is halved in the same way, so that the largest
    tension is seen although nothing jumps.
    """
    resolution, threshold = search.event_resolution or 0.0, search.event_threshold
    tension = problem.wall.largest_tension
    events: list[Event] = []
    pairs, solves = 0.0, 0
    here = coordinate(control, good[-1])
    step, wider = target - here, np.inf
    lowest = good[-1].load, good[-1].mean_gap
    falls = len(good) == 2 and good[0].load > good[1].load

    while True:
        at = target if abs(step) >= abs(target - here) else here + step
        trial = solve(problem, control, at, settings, _shifted(problem, control, good[-1], at), branch)
        settings = replace(settings, warm_grids=0)
        left = trial.outcome is Outcome.PULLED_OFF
        if not (left or trial.status.ok):
            break
        before = good[-1]
        change, width = np.inf if left else _difference(before.totals, trial.totals, tension), abs(at - here)
        moved = np.inf if left else _largest_change(before.gap, trial.gap)
        shrinks = moved < 0.75 * wider
        turns = branch == "retract" and falls and 0 > trial.load > before.load and not left
        narrow = resolution / 16 if change > threshold and shrinks else resolution
        if (change > threshold or turns) and width > narrow:
            step, wider = (at - here) / 2, moved
        else:
            if change > threshold and not shrinks:
                events.append(event(control, branch, before, trial))
            falls = trial.load < before.load
            lowest = min(lowest, (trial.load, trial.mean_gap))
            if left or at == target:
                break
            good[:] = [trial]
            here, step, wider = at, 2 * (at - here), np.inf
        pairs, solves = pairs + trial.solution.fft_pairs, solves + 1
        del before, trial  # while the next one is looked for, one field is held
    return replace(trial, target=target, events=tuple(events), search_pairs=pairs, search_solves=solves, lowest=lowest)


def _difference(one: Totals, other: Totals, tension: float) -> float:
    """How far two contacts differ, as a fraction of A0: no more than one, so that a path needs few halvings."""
    repulsive = other.area_rep - one.area_rep
    load = (other.load_att - one.load_att) / tension
    return max(abs(repulsive), abs(repulsive + other.area_att - one.area_att), abs(load))


def _largest_change(before: Real, after: Real) -> float:
    """Largest difference of two gaps, row by row: a field of differences need not be held."""
    return max(float(np.abs(a - b).max()) for a, b in zip(before, after, strict=True))
