"""One loading path: a sequence of equilibria, each started from those before it.

Control is by separation or by mean gap.  Two models with different mean compliance are compared at equal mean
gap: there the mean mode takes no part, and the separation follows from the mean pressure P as
``separation = mean gap - mean height - P/K_0`` (no value where the mean is free).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from continuum.constrained import Pressed, constrain
from continuum.grid import Real
from continuum.minimise import Settings, Solution, Status, minimise
from continuum.problem import ContactProblem
from continuum.wall import HardWall, Wall

__all__ = ["Branch", "Control", "State", "follow", "solve", "traction"]

Control = Literal["separation", "mean-gap"]
Branch = Literal["start", "approach", "retract"]


@dataclass(frozen=True, eq=False)
class State:
    """One equilibrium under load."""

    target: float
    """Value of the controlled quantity, in a0."""
    branch: Branch
    """Direction from which it was reached."""
    separation: float
    """Height of the wall's zero above the undeformed surface, in a0; not a number where the mean is free."""
    mean_gap: float
    """In a0."""
    mean_pressure: float
    """Load per area, in E*."""
    solution: Solution = field(repr=False)

    @property
    def gap(self) -> Real:
        """Height of the wall above the deformed surface, shape ``grid.shape``, in a0."""
        return self.solution.points

    @property
    def status(self) -> Status:
        """How the solve ended."""
        return self.solution.status


def solve(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    start: Real | None = None,
    branch: Branch = "start",
) -> State:
    """Equilibrium at one separation or mean gap.

    Parameters
    ----------
    control, target : what is given, and its value, in a0.
    settings : of the minimisation.
    start : gap to start from; the undeformed surface if None.
    branch : name of the direction of loading, kept with the state.
    """
    lift, mean_stiffness = target, problem.mean_stiffness
    if control == "mean-gap":
        # The mean displacement is given; which separation and base belong to it is found afterwards.
        lift, mean_stiffness = target - problem.mean_height, np.inf
    grid, wall = problem.grid, problem.wall
    posed = {"lift": lift, "mean_stiffness": mean_stiffness}
    solution: Solution
    if isinstance(wall, HardWall):
        solution = constrain(grid, problem.stiffness_q, problem.heights, start, settings, **posed)
    else:
        solution = minimise(grid, problem.stiffness_q, wall.law, problem.heights, start, settings, **posed)
    if solution.status.ok and solution.points.min() < problem.wall.core:
        solution = replace(solution, status=Status.BELOW_CORE)
    gap = solution.points
    pressure = problem.grid.mean(traction(problem.wall, solution))
    mean_gap = problem.grid.mean(gap)
    separation = target
    if control == "mean-gap":
        k = problem.mean_stiffness
        separation = target - problem.mean_height - (pressure / k if k > 0 else np.nan)
    return State(target, branch, separation, mean_gap, pressure, solution)


def traction(wall: Wall, solution: Solution) -> Real:
    """Traction of the wall on the surface at each point, in E*: of its law, or what a hard wall carries."""
    return solution.traction if isinstance(solution, Pressed) else wall.evaluate(solution.points).traction


def follow(
    problem: ContactProblem,
    control: Control,
    targets: Iterable[float],
    settings: Settings,
    previous: Sequence[State] = (),
) -> Iterator[State]:
    """Equilibria at each target in turn, in the order given.

    Each starts from the linear extrapolation of the last two converged states of the same direction, never
    from a state that failed.  ``previous`` resumes a path: its last two converged states, in order.

    Yields
    ------
    State
        One for each target, converged or not: look at its status.
    """
    good = [state for state in previous if state.status.ok]
    for target in targets:
        if good and target == good[-1].target:
            branch: Branch = good[-1].branch
        else:
            branch = "start" if not good else "approach" if target < good[-1].target else "retract"
        state = solve(problem, control, target, settings, _extrapolate(problem, good, target, branch), branch)
        yield state
        if state.status.ok:
            good = [*good[-1:], state]


def _extrapolate(problem: ContactProblem, good: Sequence[State], target: float, branch: Branch) -> Real | None:
    """Gap to start from: linear in the target along one branch, else the last state shifted rigidly."""
    if not good:
        return None
    last = good[-1]
    if len(good) == 2 and good[0].target != last.target and branch == last.branch:
        weight = (target - last.target) / (last.target - good[0].target)
        # An extrapolation far beyond the two states is a guess; the shifted state is as good and safer.
        if weight <= 2:
            guess = last.gap + weight * (last.gap - good[0].gap)
            if guess.min() > problem.wall.core:
                return guess
    return last.gap + (target - last.target)
