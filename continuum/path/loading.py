"""Loading: one equilibrium at a given control, and paths of them, each started from those before it.

Control is by separation, mean gap or mean pressure, each one solve (:mod:`continuum.path.equilibrium`), or by repulsive
area, which is searched for (:mod:`continuum.path.area`).  The arrays of the solver are those of the whole path.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from continuum.arguments import ArgumentError, field, number
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.area import find_area
from continuum.path.equilibrium import equilibrium, moved_rigidly, solver_of
from continuum.path.state import (
    YIELDS,
    Branch,
    Control,
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
    state_of,
)
from continuum.path.walk import walk
from continuum.solve.solution import Settings
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
    start : gap to start from; the undeformed surface if None.  A given area is searched for from there, always from
        the side on which the start lies.  Under given mean pressure and mean gap its mean does not matter.
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
        field("start", start, problem.grid.shape)
    if control != "repulsive-area":
        return equilibrium(problem, control, target, settings, start, branch, solver)
    previous = [] if start is None else [_known(problem, start, branch)]
    return find_area(problem, target, settings, search or Search(), previous, branch, solver)


def _known(problem: ContactProblem, gap: Real, branch: Branch) -> PathState:
    """The state from whose gap a search begins."""
    control, mean_gap = nearness(problem), problem.grid.mean(gap)
    state = state_of(problem, "mean-gap", mean_gap, branch, gap)
    return replace(state, control=control, target=coordinate(control, state))


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
        imprint = good[-1].imprint if good else None
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
        state = replace(state, imprint=imprint)
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
