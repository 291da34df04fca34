"""One equilibrium at a given separation, mean gap or mean pressure.

Two models with different mean compliance are compared at equal mean gap: there the mean mode takes no part, and the
separation follows from the mean pressure P as ``separation = mean gap - mean height - P/K_0`` (no value where the mean
is free).  At given mean pressure the mean is free and a uniform pressure presses: one solve as well.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.state import Branch, Control, PathState, coordinate, gone, state_of
from continuum.solve.non_periodic import NonPeriodicSolver
from continuum.solve.solution import FinerTolerance, Settings, Solution, Status
from continuum.solve.solver import Solver

STRETCH = 50
"""A solve that may turn out not to be wanted is looked at after so many iterations; a fine grid seldom takes more."""

LOOSE, LOOSEST = 100.0, 1e-5
"""Tolerance of trials, in units of the tolerance asked for, but at most so much, in E*: beyond, areas say nothing."""
NO_MEAN_GAP = "another control where nothing is repeated: a part of a half-space has no mean displacement of its own"


def solver_of(problem: ContactProblem, settings: Settings) -> Solver:
    """The solver of a problem's surface, for as many states of it as are wanted."""
    if problem.open_boundary is not None:
        return NonPeriodicSolver(problem.open_boundary, settings.threads, settings.device, shards=settings.shards)
    return Solver(problem.grid, problem.stiffness_q, settings.threads, settings.device, shards=settings.shards)


def loosened(settings: Settings, factor: float = LOOSE, most: float = LOOSEST) -> Settings:
    """Settings of trials, of which few are worth the tolerance asked for."""
    return replace(settings, tolerance=max(settings.tolerance, min(factor * settings.tolerance, most)))


def equilibrium(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    start: Real | None = None,
    branch: Branch = "start",
    solver: Solver | None = None,
    finer: FinerTolerance | None = None,
) -> PathState:
    """Equilibrium at one separation, mean gap or mean pressure: as :func:`continuum.path.loading.solve` says.

    ``finer`` is a finer tolerance, if the gap at that of the settings is worth it; under a bound it is left alone,
    under a tension it holds from the beginning.
    """
    if control == "mean-gap" and problem.open_boundary is not None:
        raise ArgumentError("mean-gap", target, NO_MEAN_GAP)
    if control == "mean-pressure" and target < 0 and start is None:
        # Surfaces apart hold no tension: it is applied to what rests at zero load.
        rest = equilibrium(problem, control, 0.0, settings, None, branch, solver)
        if not rest.status.ok:
            return replace(rest, target=target)
        pulled = equilibrium(problem, control, target, settings, rest.gap, branch, solver)
        return replace(pulled, search_pairs=rest.solution.fft_pairs, search_solves=1)
    lift, mean, pressure = target, problem.mean_stiffness, 0.0
    if control == "mean-gap":
        # The mean displacement is given; which separation and base belong to it is found afterwards.
        lift, mean = target - problem.mean_height, np.inf
    elif control == "mean-pressure":
        # The mean displacement is free, and counted from first touch.
        lift, mean, pressure = problem.wall.zero_gap - problem.grid.least(problem.heights), 0.0, target
    if mean == 0 and not pressure < problem.wall.hardness:
        allowed = f"a pressure below the hardness of {problem.wall.hardness:g} E*, at which all of the surface yields"
        raise ArgumentError("mean-pressure", target, allowed)
    if pressure < 0 and problem.wall.largest_tension == 0:
        return gone(problem, target, branch)
    # A solver made here is not kept for longer than it solves.
    solver = solver or solver_of(problem, settings)
    if pressure < 0 and mean == 0:
        tight = settings if finer is None else replace(settings, tolerance=finer.tolerance)
        solve = partial(_solution, problem, solver, lift, 0.0, pressure, None)
        # Once it has detached, the surface would recede until max_iterations.  No coarser grid is used: it may detach
        # at a tension that this one holds.
        left, growth = partial(_has_left, problem, -pressure), 1 if problem.open_boundary is None else 2
        solution = _in_stretches(solve, start, replace(tight, warm_grids=0), left, growth)
        if _has_left(problem, -pressure, solution.gap):
            return gone(problem, target, branch, solution)
    elif finer is not None and finer.hopeless is not None and problem.open_boundary is None:
        # Where nothing is repeated each stretch would begin with a residual as large as the first one's: the gap of the
        # window tells the displacement beside it in equilibrium only.  A solve of 90 iterations took 3733.
        solve = partial(_solution, problem, solver, lift, mean, pressure, finer)
        solution = _in_stretches(solve, start, settings, finer.hopeless)
    else:
        solution = _solution(problem, solver, lift, mean, pressure, finer, start, settings)
    if solution.status.ok and problem.grid.least(solution.gap) < problem.wall.core:
        solution = replace(solution, status=Status.BELOW_CORE)
    law = problem.wall.law
    if solution.status.ok and settings.stability and law is not None:  # a bound makes the energy convex
        found = solver.stability(law, solution.gap, mean, settings.shift)
        status = Status.SADDLE if found.is_saddle else solution.status
        solution = replace(solution, lowest_eigenvalue=found.eigenvalue, status=status)
    return state_of(problem, control, target, branch, solution)


def moved_rigidly(problem: ContactProblem, control: Control, state: PathState, target: float) -> Real:
    """Gap of a state moved rigidly; where the mean displacement is held or free, the solver does that by itself."""
    if control == "separation" and np.isfinite(problem.mean_stiffness) and problem.open_boundary is None:
        return state.gap + (target - coordinate(control, state))
    return state.gap


def _solution(
    problem: ContactProblem,
    solver: Solver,
    lift: float,
    mean: float,
    pressure: float,
    finer: FinerTolerance | None,
    start: Real | None,
    settings: Settings,
) -> Solution:
    """Solve with the solver that the wall asks for: the smooth one for a law, the constrained one for a bound."""
    law, heights = problem.wall.law, problem.heights
    if law is None:
        most = problem.wall.hardness
        return solver.constrain(heights, start, settings, pressure=pressure, lift=lift, mean_stiffness=mean, most=most)
    posed = {"pressure": pressure, "lift": lift, "mean_stiffness": mean}
    return solver.minimise(law, heights, start, settings, finer=finer, **posed)


def _in_stretches(
    solve: Callable[[Real | None, Settings], Solution],
    start: Real | None,
    settings: Settings,
    ends: Callable[[Real], bool],
    growth: int = 1,
) -> Solution:
    """Solve in stretches, between which the gap is looked at: whether it is known by now that it need not go on.

    Each is longer than the last by a factor of ``growth``: 2 where a stretch does not go on where the last one ended,
    as the gap of a window does not tell the displacement beside it, so that one of them has to come to an end.
    """
    done: Solution | None = None
    stretch = STRETCH
    while True:
        left = settings.max_iterations - (done.iterations if done else 0)
        last = solve(start, replace(settings, max_iterations=min(left, stretch)))
        done = last if done is None else _joined(done, last)
        if last.status is not Status.ITERATION_LIMIT or done.iterations >= settings.max_iterations:
            return done
        if ends(last.gap):
            return replace(done, status=Status.STOPPED)
        start, settings, stretch = last.gap, replace(settings, warm_grids=0), growth * stretch


def _joined(first: Solution, second: Solution) -> Solution:
    """The second of two stretches, with the work of both."""
    (a, *others), (b, *more) = first.work, second.work
    work = (a.plus(b), *others, *more)  # coarser grids, and boxes, are not those of each stretch
    return replace(
        second,
        iterations=first.iterations + second.iterations,
        work=work,
        seconds=first.seconds + second.seconds,
        history=first.history + second.history,
    )


def _has_left(problem: ContactProblem, tension: float, gap: Real) -> bool:
    """Whether the law pulls less than the mean tension asks for at any gap from the smallest one on.

    Then no point pulls as hard as the mean should, and moving away makes it worse: the surface has left.
    """
    nearest = problem.grid.least(gap)
    if not np.isfinite(nearest):
        return bool(np.isposinf(nearest))  # else a failure of another kind
    return problem.wall.largest_tension_from(nearest) < tension
