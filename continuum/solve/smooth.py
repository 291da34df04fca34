"""Equilibrium of a smooth energy: preconditioned conjugate gradients with steps of coarser grids.

The energy is a quadratic form, diagonal in Fourier space, plus a sum over points::

    E(u) = ½ <u, K u> + <φ(z)> - F <u>,     z = offset - u,     gradient g = K u + p(z) - F,  p = -φ'

One iteration costs one pair of Fourier transforms on its grid.  The state is z in real space and g_q in Fourier
space; a step u -> u + α d changes them by -α d and by α K d_q + FFT(p(new z) - p(old z)), so that neither u nor the
offset is needed.  The line search needs no transform, since along d::

    E'(α) = <d, g> + α <d, K d> + <(p(z - α d) - p(z)) d>

The preconditioned gradient is M g, M = 1/(K + c0), for short waves.  For waves that the next coarser grid carries it is
minus the step that this grid takes from (every second z, its part of g): a full approximation scheme.  Stiff contacts
and rims close to snapping, which make M g slow, are found there at a fraction of the cost.  The coarse step is a
direction only: line search and gradient are those of the fine grid.

No contact mechanics here: K, the offset and a law of the gap are all that it knows.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from continuum.model import laws
from continuum.model.grid import Grid, Real
from continuum.model.laws import Law
from continuum.solve.cpu import sweeps
from continuum.solve.cpu.levels import Level, Work, prolong, restrict
from continuum.solve.solution import Iteration, NotConvergedError, Settings, Solution, Status

__all__ = ["NotConvergedError", "Settings", "Solution", "Status", "Work", "minimise"]

LEVELS = 3
"""Grids that a step uses, at most."""
COARSE_TOLERANCES = (3e1, 1e2, 1e3, 1e4)
"""Of a cold start on the grids of n/2, n/4, ... points, in units of the tolerance asked for; measured optimum."""
CLOSE = 1e3
"""A start whose residual is at most so many tolerances is not taken to coarser grids: these bring it no closer."""
COARSE_LIMIT = 400
"""Iterations on each coarser grid of a cold start, at most."""
COARSE_ITERATIONS, COARSE_REDUCTION = 4, 0.3
"""A coarse step ends after so many iterations, or when the coarse gradient has fallen by this factor."""
SLOPE_REDUCTION, SLOPE_ACCEPTED = 0.1, 0.5
"""A Newton step made at once, or a line search near the wall, lowers the slope to the first part; over all points the
second must hold after a line search."""
NEAR = 0.5
"""Points within this distance of the reach of the law are near the wall, in a0."""


def minimise(
    grid: Grid,
    stiffness_q: Real,
    law: Law,
    offset: Real,
    start: Real | None,
    settings: Settings,
    *,
    pressure: float = 0.0,
    lift: float = 0.0,
    mean_stiffness: float | None = None,
) -> Solution:
    """Minimise ½ <u, K u> + <φ(offset + lift - u)> - F <u> over u.

    Parameters
    ----------
    grid : gives transforms, means and threads.
    stiffness_q : K >= 0 over the half spectrum, in E*/a0.
    law : φ, per area, as compiled code takes it.
    offset, lift : z at u = 0, an array of shape ``grid.shape`` and a number, in a0.
    start : z at the start, shape ``grid.shape``; None starts on a cascade of coarser grids, from u = 0 on the coarsest.
    settings : when to stop.
    pressure : F, a uniform pressure along u, in E*; of no effect where the mean of u is held.
    mean_stiffness : K at q = 0 instead of that of ``stiffness_q``; infinite holds the mean of u at zero.
    """
    began = time.perf_counter()
    points = offset if start is None else start
    # A sum is finite only if all its terms are, and needs no memory.
    if not np.isfinite(points.sum() + offset.sum() + lift):
        return Solution(points, Status.NON_FINITE, np.inf, 0, by=law)
    mean_stiffness = float(stiffness_q[0, 0]) if mean_stiffness is None else mean_stiffness
    level = Level(grid, stiffness_q, mean_stiffness, len(COARSE_TOLERANCES))
    problem = _Problem(law, settings, pressure, lift)
    offset = np.ascontiguousarray(offset)
    history: list[Iteration] = []
    status = _solve(level, problem, offset, start, 0, history)

    # The gradient afresh, from z alone: g has gathered rounding errors on the way.
    _displacement(level, problem, offset)
    _elastic(level, problem)
    problem.press(level)
    level.spectral(level.column_edges, None, forward=True)
    level.g_q += level.work_q
    residual = float(np.sqrt(level.spectral(level.column_edges, sweeps.square, level.g, level.weights)[0]))
    if status is Status.CONVERGED and not residual <= 2 * settings.tolerance:
        status = Status.LINE_SEARCH
    # Near the end of its range the energy of a law is the difference of far larger numbers: by their rounding the last
    # step of a solve may seem to rise.
    if status is Status.ENERGY_ROSE and residual <= settings.tolerance:
        status = Status.CONVERGED
    work = tuple(each.done for each in level.chain if each.transforms)
    seconds = time.perf_counter() - began
    return Solution(level.gap, status, residual, len(history) - 1, work, seconds, tuple(history), by=law)


class _Problem(NamedTuple):
    """What is minimised, on whatever grid, and how."""

    law: Law
    settings: Settings
    pressure: float
    lift: float

    @property
    def near_gap(self) -> float:
        """Gap below which a point is near the wall."""
        return self.law.reach + NEAR

    def press(self, level: Level) -> None:
        """Traction of a level's gap, transformed along the rows."""
        law = self.law
        level.into_rows(laws.press, level.z, level.n, law.kind, law.parameters, law.reach, self.near_gap, level.near)


def _displacement(level: Level, problem: _Problem, offset: Real) -> float:
    """Spectrum of the displacement into the work of a level; returns its mean."""
    sums = level.into_rows(sweeps.displace, level.z, level.n, offset, problem.lift)
    level.spectral(level.column_edges, None, forward=True)
    return float(sums[0]) / level.grid.size


def _elastic(level: Level, problem: _Problem) -> None:
    """Gradient without the traction of the wall, from the spectrum of the displacement: K u - F."""
    np.multiply(level.K, level.work_q, out=level.g_q)
    if not level.held:
        level.g_q[0, 0] -= problem.pressure


def _solve(
    level: Level, problem: _Problem, offset: Real, start: Real | None, depth: int, history: list[Iteration]
) -> Status:
    """Minimise on one level, from the solution on the next coarser grid, that one's from the next, and so on.

    The coarsest begins from u = 0 or, if there is a start, from its part of that.
    """
    settings = problem.settings
    tolerance, iterations = settings.tolerance, settings.max_iterations
    if depth:
        tolerance, iterations = tolerance * COARSE_TOLERANCES[depth - 1], min(iterations, COARSE_LIMIT)
    coarse = level.coarser if depth < (len(COARSE_TOLERANCES) if start is None else settings.warm_grids) else None
    if start is not None:
        level.gap[...] = start
        mean = _displacement(level, problem, offset)
        if level.held:
            level.gap[...] += mean
        if coarse is not None:
            restrict(level.work_q, coarse.work_q)
        _elastic(level, problem)
        problem.press(level)
        status = _descend(level, problem, tolerance, 0 if coarse else iterations, LEVELS, history)
        if coarse is None or status is not Status.ITERATION_LIMIT:
            return status
        if history.pop().residual <= CLOSE * tolerance:
            return _descend(level, problem, tolerance, iterations, LEVELS, history, complete=True)
    if coarse is None:
        level.gap[...] = offset + problem.lift
        level.work_q[...] = 0.0
        _elastic(level, problem)
    else:
        # The direction is not in use yet: what the coarse grid needs meanwhile lies in its memory.
        lent = level.direction.ravel()[: 2 * coarse.grid.size].reshape(2, *coarse.grid.shape)
        part = None if start is None else coarse.grid.inverse(coarse.work_q, lent[1], overwrite=True)
        mean = level.into_rows(sweeps.copy, offset, level.n)[0] / level.grid.size
        level.spectral(level.column_edges, None, forward=True)
        level.work_q[0, 0] = mean
        restrict(level.work_q, coarse.work_q)
        coarse_offset = coarse.grid.inverse(coarse.work_q, lent[0], overwrite=True)
        if part is not None:
            np.subtract(coarse_offset, part, out=part)
            part += problem.lift
        _solve(coarse, problem, coarse_offset, part, depth + 1, [])
        # A coarse grid that failed is no start: this one begins from rest.
        if not np.isfinite(_displacement(coarse, problem, coarse_offset)):
            coarse.clear()
        prolong(coarse.work_q, level.work_q)
        _elastic(level, problem)
        level.spectral(level.column_edges, None, inverse=True)
        level.from_rows(sweeps.lay, level.z, level.n, offset, problem.lift)
    problem.press(level)
    return _descend(level, problem, tolerance, iterations, LEVELS, history)


def _descend(
    level: Level,
    problem: _Problem,
    bound: float,
    iterations: int,
    levels: int,
    history: list[Iteration] | None = None,
    *,
    complete: bool = False,
) -> Status:
    """Minimise on one level from its z, its g_q without the traction of the wall, and that, transformed along rows.

    Or from its complete g_q.  Without a history the bound is relative to that, as for a step for a finer grid.
    """
    law, c0, size = problem.law, problem.settings.shift, level.grid.size
    coarse = level.coarser if levels > 1 else None
    low_rows, low_columns = level.low if coarse else (0, 0)
    g, d, work, K, weights = level.g, level.d, level.work, level.K, level.weights
    alpha = beta = energy = slope = curvature = after = 0.0
    step = _Step(0.0, 0.0, 0.0, 0.0, newton=True)
    if complete:
        level.work_q[...] = 0.0
    for iteration in range(iterations + 1):
        arguments = g, d, work, K, c0, alpha, beta, low_rows, low_columns, weights
        forward = iteration > 0 or not complete
        if coarse is None:
            sums = level.spectral(level.column_edges, sweeps.gradient, *arguments, forward=forward, inverse=True)
        else:
            sums = level.spectral(level.low_edges, sweeps.gradient, *arguments, forward=forward)
            sums += level.spectral(level.high_edges, sweeps.gradient, *arguments, forward=forward, inverse=True)
        residual = float(np.sqrt(sums[0]))
        if history is not None:
            history.append(Iteration(residual, energy, alpha))
        elif iteration == 0:
            bound *= residual
        if not np.isfinite(residual):
            level.clear()
            return Status.NON_FINITE
        if residual <= bound:
            return Status.CONVERGED
        if iteration == iterations:
            return Status.ITERATION_LIMIT
        # Of the last step, whose slope fell from `slope` to `after` and whose curvature is that of d.
        dg, dy, dd = after, after - slope, curvature
        if coarse is not None:
            e = _coarse_step(level, coarse, problem, levels - 1)
            plain = sums
            seen = level.spectral(level.low_edges, sweeps.low_modes, g, d, work, K, c0, low_rows, weights, e)
            sums = plain + seen
            if not (np.isfinite(sums).all() and sums[1] > 0):
                # The coarse step does not descend: the gradient's own does.
                seen = level.spectral(level.low_edges, sweeps.low_gradient, g, work, K, c0, low_rows, weights)
                sums = plain + seen
                dy = 0.0
        _, gs, ys, ym, ss, sd = sums
        # Hager and Zhang's beta, SIAM J. Optim. 16, 170 (2005); steepest descent where it does not descend.
        beta = max(0.0, (ys - 2 * dg * ym / dy) / dy) if iteration and dy > 0 else 0.0
        if beta * dg >= gs:
            beta = 0.0
        slope = beta * dg - gs
        curvature = ss - 2 * beta * sd + beta * beta * dd
        if coarse is not None:
            level.spectral(level.low_edges, sweeps.low_direction, d, work, low_rows, beta, inverse=True)
        stiffness = level.from_rows(
            laws.turn, level.direction, level.n, beta, level.z, law.kind, law.parameters, level.near
        )
        step = _step(level, problem, slope, curvature, stiffness[0] / size, newton=step.newton)
        alpha, after = step.length, step.slope
        if not np.isfinite(alpha):
            return Status.LINE_SEARCH
        if history is not None and step.rise > 1e-12 * step.size_of_energy / size:
            history.append(Iteration(residual, energy + step.rise, alpha))
            return Status.ENERGY_ROSE
        energy += step.rise
    return Status.ITERATION_LIMIT


def _coarse_step(level: Level, coarse: Level, problem: _Problem, levels: int) -> Real:
    """Step of the displacement that the coarser grid takes from here, as a spectrum."""
    coarse.real(sweeps.every_second, level.z, coarse.z, coarse.n, problem.near_gap, coarse.near)
    restrict(level.g_q, coarse.g_q)
    _descend(coarse, problem, COARSE_REDUCTION, COARSE_ITERATIONS, levels, complete=True)
    coarse.into_rows(sweeps.moved, level.z, coarse.z, coarse.n)
    coarse.spectral(coarse.column_edges, None, forward=True)
    return coarse.work


class _Step(NamedTuple):
    """A step along the direction."""

    length: float
    """α; NaN if none was found."""
    slope: float
    """Slope after it."""
    rise: float
    """Change of the energy."""
    size_of_energy: float
    """Sum of |φ|."""
    newton: bool
    """Whether Newton's first step was good enough."""


def _step(level: Level, problem: _Problem, slope: float, curvature: float, stiffness: float, *, newton: bool) -> _Step:
    """Step along d: Newton's; where the wall softens, of the substrate alone.

    It is made at once if the last one was good, since it then mostly is again; else the points near the wall are asked
    first how far to go.
    """
    law, size = problem.law, level.grid.size
    first = curvature + max(stiffness, 0.0)
    alpha = first = -slope / first if first > 0 else 1.0
    if not newton:
        alpha = _line_search(level, problem, first, 0.0, slope, slope, curvature)
    step = alpha
    low, high = 0.0, np.inf
    for trial in range(60):
        f, second, size_of_energy = level.into_rows(
            laws.move, level.z, level.direction, level.n, step, alpha,
            law.kind, law.parameters, law.reach, problem.near_gap, level.near,
        )[:3]  # fmt: skip
        after = slope + alpha * curvature + f / size
        surprised = trial > 0 or not newton
        if abs(after) <= (SLOPE_ACCEPTED if surprised else SLOPE_REDUCTION) * abs(slope):
            rise = alpha * (slope + 0.5 * alpha * curvature) + second / size
            return _Step(alpha, after, rise if trial == 0 else min(rise, 0.0), size_of_energy, alpha == first)
        low, high = (alpha, high) if after < 0 else (low, alpha)
        if surprised:
            # Points far from the wall have come near it, which the line search did not see: rare.
            target = (low + high) / 2 if np.isfinite(high) else 2 * alpha
        else:
            secant = alpha * min(slope / (slope - after), 4.0) if after > slope else 4 * alpha
            target = _line_search(level, problem, secant, alpha, slope, after, curvature)
        step, alpha = target - alpha, target
    return _Step(np.nan, 0.0, 0.0, 0.0, newton=False)


def _line_search(
    level: Level, problem: _Problem, alpha: float, here: float, slope: float, after: float, curvature: float
) -> float:
    """Step length at which the slope, ``after`` where the gap is ``here``, has fallen to a part of the first.

    Newton's method from alpha, inside a bracket, over the points near the wall.
    """
    law, size = problem.law, level.grid.size
    low, high = (here, np.inf) if after < 0 else (0.0, here)
    for _ in range(40):
        level.sweeps += 1
        f, c = level.real(
            laws.line, level.z, level.direction, level.n, alpha - here, law.kind, law.parameters, level.near
        )[:2]
        f, c = after + (alpha - here) * curvature + f / size, curvature + c / size
        if not np.isfinite(f) or abs(f) <= SLOPE_REDUCTION * abs(slope):
            break
        low, high = (alpha, high) if f < 0 else (low, alpha)
        newton = alpha - f / c if c > 0 else np.inf
        if not low < newton < high:
            newton = (low + high) / 2 if np.isfinite(high) else 4 * alpha
        alpha = min(newton, 10 * alpha)
    return alpha
