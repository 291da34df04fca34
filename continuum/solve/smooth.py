"""Equilibrium of a smooth energy: preconditioned conjugate gradients with steps of coarser grids.

The energy is a quadratic form, diagonal in Fourier space, plus a sum over points::

    E(u) = ½ <u, K u> + <φ(z)> - F <u>,     z = offset - u,     gradient g = K u + p(z) - F,  p = -φ'

One iteration costs one pair of Fourier transforms on its grid.  The state is z in real space and g_q in Fourier
space; a step u -> u + α d changes them by -α d and by α K d_q + FFT(p(new z) - p(old z)), so that neither u nor the
offset is needed.  The line search needs no transform, since along d::

    E'(α) = <d, g> + α <d, K d> + <(p(z - α d) - p(z)) d>

The preconditioned gradient is M g, M = 1/(K + c0), for short waves, with a c0 of half the largest K, as in a contact a
step of the substrate alone is too long.  For waves that the next coarser grid carries it is minus the step that this
grid finds in the linear problem (K + φ'') x = -g, with φ'' at every second point and its part of g, by a few conjugate
directions that the grid below it helps in the same way.  Stiff contacts and rims close to snapping, which make M g
slow, are resolved there at a fraction of the cost.  The coarse step is a direction only: line search and gradient are
those of the fine grid.  Where a rim snaps, from one row of points to the next, that does not help either: a solve that
stalls goes down in small boxes there (:mod:`continuum.solve.boxes`), and on from that state.
If it stalls far from equilibrium, as a large part of the contact snaps, coarser grids carry it over, in fewer steps.

On large grids with little contact all of this is what remains where tiles near the wall do not lead to the end
(:mod:`continuum.solve.compiled.corrections`): these need three pairs of the whole grid.

No contact mechanics here: K, the offset and a law of the gap are all that it knows.  No field either: those belong to
the grids, whose operations (:class:`continuum.solve.grids.SmoothGrid`) return scalars.
"""

import time
from dataclasses import replace
from functools import partial

import numpy as np

from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.solve import contact
from continuum.solve.conjugate import Line, coarse_step, conjugate_line
from continuum.solve.contact import ContactSteps
from continuum.solve.grids import SmoothGrid
from continuum.solve.line_search import LARGEST_RISE, Step, take_step
from continuum.solve.solution import FinerTolerance, Goal, Iteration, Settings, Solution, Status

COARSE_TOLERANCES, WARM_TOLERANCES = (3e1, 1e2, 1e3, 1e4), (1e2, 1e3, 1e3, 1e4)
"""Tolerances of a cold start on the grids of n/2, n/4, ... points, in units of that asked for, and of one from a state
that is at hand; measured optimum."""
CLOSE = 5e3
"""A start whose residual is at most so many tolerances is not taken to coarser grids: these bring it no closer.

Others are: states of paths then take 62 to 127 pairs instead of 92 to 460.
"""
SNAPS = 1e3
"""A solve that stalls farther from equilibrium, in tolerances, is: a part of the surface snaps there.

A threefold rise of the residual as the sign took 20 % more pairs.  One per cent of the wall's traction took 0.9 to 1.05
times the pairs, and to a looser tolerance a search then missed an area.
"""
FAR = 1e5
"""A start whose residual is larger is not taken to tiles: conjugate gradients bring it closer in fewer pairs."""
COARSE_LIMIT = 400
"""Iterations on each coarser grid of a cold start, at most."""
PATIENCE, SLOW = 8, 0.2
"""A solve stalls where its residual, over so many iterations, does not fall below this part.

Systems about to snap take 1.83 times the pairs without the boxes that are asked then.
"""
BOX_TOLERANCE, BOX_ITERATIONS = 0.1, 400
"""Tolerance in a box, in units of that of the surface if all of its residual were there; and iterations, at most."""


def minimise(
    grid: SmoothGrid,
    levels: int,
    law: Law,
    offset: Real,
    start: Real | None,
    settings: Settings,
    *,
    pressure: float,
    lift: float,
    mean_stiffness: float,
    finer: FinerTolerance | None = None,
) -> Solution:
    """Minimise ½ <u, K u> + <φ(offset + lift - u)> - F <u> over u, on a level that knows K.

    ``levels`` is the number of grids that a step uses; the rest as for :meth:`continuum.solve.solver.Solver.minimise`.
    """
    began = time.perf_counter()
    if not grid.set_problem(law, offset, start, lift=lift, pressure=pressure, mean_stiffness=mean_stiffness):
        return Solution(offset if start is None else start, Status.NON_FINITE, np.inf, 0, law=law)
    history: list[Iteration] = []
    status = _solve(grid, levels, settings, 0, history, started=start is not None, finer=finer)
    tolerance = settings.tolerance
    if finer is not None and history[-1].residual <= finer.tolerance:
        tolerance = finer.tolerance

    # The gradient afresh, from z alone: g has gathered rounding errors on the way; corrections have none.
    residual = history[-1].residual if grid.corrected else grid.residual()
    if status is Status.CONVERGED and not residual <= 2 * tolerance:
        status = Status.LINE_SEARCH
    # Near the end of its range the energy of a law is the difference of far larger numbers: by their rounding the last
    # step of a solve may seem to rise.
    if status is Status.ENERGY_ROSE and residual <= tolerance:
        status = Status.CONVERGED
    work = tuple(each for each in grid.work if each.fft_pairs)
    seconds = time.perf_counter() - began
    gap, processes = grid.hand_out(), grid.size // offset.size
    found = gap, status, residual, len(history) - 1, work, seconds, tuple(history)
    return Solution(*found, law=law, processes=processes)


def _solve(
    grid: SmoothGrid,
    levels: int,
    settings: Settings,
    depth: int,
    history: list[Iteration],
    *,
    started: bool,
    finer: FinerTolerance | None = None,
) -> Status:
    """Minimise on one level, from the solution on the next coarser grid, that one's from the next, and so on.

    The coarsest begins from u = 0 or, if there is a start, from its part of that.
    """
    tolerance, iterations = settings.tolerance, settings.max_iterations
    if finer is not None:
        # Coarser grids prepare for the finer tolerance, which the solve may go on to.
        settings = replace(settings, tolerance=finer.tolerance)
    if depth:
        factors = WARM_TOLERANCES if started else COARSE_TOLERANCES
        tolerance, iterations = tolerance * factors[depth - 1], min(iterations, COARSE_LIMIT)
    goal = Goal(tolerance, finer)
    coarse = grid.coarser if depth < (settings.warm_grids if started else len(COARSE_TOLERANCES)) else None
    descend = partial(_descend, grid, levels, settings.shift, goal, depth=depth, boxes=not (depth and started))
    if started:
        grid.go_to_start()
        tiled = grid.has_tiles()
        # The residual of the start decides where it goes on; where there is no choice it goes on at once.
        status = descend(0 if coarse or tiled else iterations, history)
        if not (coarse or tiled) or status is not Status.ITERATION_LIMIT:
            return status
        distance = history.pop().residual / settings.tolerance
        if coarse is None or distance <= CLOSE:
            near = tiled and distance <= FAR
            corrected = grid.correct(goal, history, iterations, coarser=False) if near else None
            if corrected:
                return Status.CONVERGED
            # Tiles that were tried leave a z of their own, whose gradient has to be made; without them it is at hand.
            return descend(iterations, history, complete=corrected is None)
    if coarse is None:
        grid.go_to_zero()
    else:
        grid.set_coarser_problem(started=started)
        _solve(coarse, levels, settings, depth + 1, [], started=started)
        tiled = grid.has_tiles(below=True)
        corrected = grid.correct(goal, history, iterations, coarser=True) if tiled else None
        if corrected:
            return Status.CONVERGED
        if corrected is None:
            # Tiles that were tried began from the coarser grid's traction, and leave a z of their own.
            grid.go_to_coarser()
    return descend(iterations, history)


def _stalls(history: list[Iteration], iterations: int) -> bool:
    """Whether the residual has hardly fallen over the last of so many iterations."""
    return iterations >= PATIENCE and history[-1].residual > SLOW * history[-1 - PATIENCE].residual


def _relax_boxes(grid: SmoothGrid, shift: float, bound: float) -> float:
    """Go down in boxes around the largest residuals; returns what that has changed the energy by, per point."""
    assert grid.boxes is not None
    settings = Settings(BOX_TOLERANCE * bound * (grid.size / grid.boxes.grid.size) ** 0.5, BOX_ITERATIONS, shift)
    mean = float(grid.boxes.stiffness_q[0, 0])

    def descend(box: SmoothGrid, law: Law, offset: Real, start: Real) -> Solution:
        return minimise(box, 1, law, offset, start, settings, pressure=0.0, lift=0.0, mean_stiffness=mean)

    return grid.relax_boxes(descend)


def _unstick(grid: SmoothGrid, levels: int, shift: float, goal: Goal, *, snaps: bool) -> float:
    """Go on where a solve stalls: on coarser grids, or in boxes; returns the change of the energy, or NaN."""
    if snaps and grid.hand_down():
        assert grid.coarser is not None
        _solve(grid.coarser, levels, Settings(goal.last, shift=shift), 1, [], started=True)
        grid.go_to_coarser()
        return np.nan
    return _relax_boxes(grid, shift, goal.bound)


def _descend(
    grid: SmoothGrid,
    levels: int,
    shift: float,
    goal: Goal,
    iterations: int,
    history: list[Iteration],
    *,
    depth: int,
    complete: bool = False,
    boxes: bool = True,
) -> Status:
    """Minimise on one level from its z and g, which is complete or lacks the traction of the wall.

    Without ``boxes`` it is only a start that is looked for, and may stall.
    """
    own = bool(iterations) and grid.contact is not None and contact.pays(grid.contact, depth)
    steps = ContactSteps(grid.contact, depth) if own and grid.contact else _LongSteps(grid, levels, shift)
    line, step, energy = Line(), Step(), 0.0
    first = moved = since = len(history)
    carried = 0
    while True:
        residual = steps.gradient(line, step, complete=complete)
        complete = False
        history.append(Iteration(residual, energy, step.length))
        if not np.isfinite(residual):
            grid.clear()
            return Status.NON_FINITE
        if goal.reached(residual, grid.look):
            return Status.CONVERGED
        if len(history) > first + iterations:
            return Status.ITERATION_LIMIT
        if boxes and not own and grid.boxes is not None and _stalls(history, len(history) - 1 - moved):
            moved = len(history) - 1
            if goal.hopeless(grid.look):
                return Status.STOPPED
            # Twice as many iterations have to pass before each coarser grid as before the last one, so that a solve
            # that these do not carry over goes on with boxes, which only go down.
            snaps = residual > SNAPS * goal.last and len(history) - since > PATIENCE << carried
            change = _unstick(grid, levels, shift, goal, snaps=snaps)
            if not np.isfinite(change):
                since, carried = len(history), carried + 1
            energy += change
            line, step = Line(), Step()
            continue
        found = steps.direction(line, step)
        if found is None:  # those of the contact pay no more
            own, steps = False, _LongSteps(grid, levels, shift)
            line, step, complete = Line(), Step(), True
            history.pop()
            moved = since = len(history)
            continue
        line, stiffness = found
        step = take_step(grid, line, stiffness, newton=step.newton)
        if not np.isfinite(step.length):
            return Status.LINE_SEARCH
        if step.rise > LARGEST_RISE * step.size_of_energy:
            history.append(Iteration(residual, energy + step.rise, step.length))
            return Status.ENERGY_ROSE
        energy += step.rise


class _LongSteps:
    """Steps of the whole grid, whose long waves a coarser one finds; in the same words as those of the contact."""

    def __init__(self, grid: SmoothGrid, levels: int, shift: float) -> None:
        self.grid, self.levels, self.shift = grid, levels, shift
        self.coarse = grid.linear is not None and levels > 1

    def gradient(self, line: Line, step: Step, *, complete: bool) -> float:
        given = self.shift, step.length, line.beta
        self.sums = self.grid.gradient(*given, coarse=self.coarse, complete=complete)
        return float(np.sqrt(self.sums[0]))

    def direction(self, line: Line, step: Step) -> tuple[Line, float]:
        sums, conjugate = self.sums, True
        if self.coarse:
            sums, conjugate = coarse_step(self.grid, self.levels, self.shift, sums)
        line = conjugate_line(sums, line, step.slope, conjugate)
        return line, self.grid.new_direction(line.beta, coarse=self.coarse)
