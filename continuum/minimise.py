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

import enum
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from continuum import laws, sweeps
from continuum.grid import Complex, Grid, Real
from continuum.laws import Law
from continuum.levels import LEVELS, SMALLEST, Level, Work, parts, prolong, restrict

__all__ = ["NotConvergedError", "Settings", "Solution", "Status", "Work", "minimise"]

COARSE_TOLERANCES = (3e1, 1e2, 1e3, 1e4)
"""Of a cold start on the grids of n/2, n/4, ... points, in units of the tolerance asked for; measured optimum."""
COARSE_ITERATIONS, COARSE_REDUCTION = 4, 0.3
"""A coarse step ends after so many iterations, or when the coarse gradient has fallen by this factor."""
SLOPE_REDUCTION, SLOPE_ACCEPTED = 0.1, 0.5
"""The line search follows the points near the wall down to the first; over all points the second must hold."""
NEAR = 0.5
"""Points within this distance of the reach of the law are near the wall, in a0."""


class Status(enum.Enum):
    """How a solve ended.  Each failure names its usual cause and what helps."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit reached: allow more iterations, or take a smaller step along the path"
    LINE_SEARCH = "line search found no minimum: the tolerance is below the rounding error of this problem"
    ENERGY_ROSE = "energy rose: energy and traction of the wall law do not belong to one another"
    NON_FINITE = "a value is not finite: the start or the input is out of range"
    BELOW_CORE = "the surface went below the core of the wall law, where it is only continued: lower the core"

    @property
    def ok(self) -> bool:
        """Whether the state is an equilibrium of the problem as posed."""
        return self is Status.CONVERGED


class NotConvergedError(RuntimeError):
    """A solution was required and there is none: the message says how far it came and what helps."""


@dataclass(frozen=True)
class Settings:
    """When to stop, and how to precondition.

    Parameters
    ----------
    tolerance : largest root-mean-square gradient, in E*.
    max_iterations : iterations after which a solve gives up.
    shift : c0 of the preconditioner 1/(K + c0), in E*/a0; the optimum is flat (0.001 - 0.03).
    """

    tolerance: float
    max_iterations: int = 5000
    shift: float = 0.01


class Iteration(NamedTuple):
    """One line of the history of a solve, on the finest grid."""

    residual: float
    """Root-mean-square gradient, in E*."""
    energy: float
    """Energy per area relative to the start, in E* a0."""
    step: float
    """Length α of the step along the direction."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What a solve found, and how."""

    points: Real = field(repr=False)
    """Gap z = offset - u at each point."""
    status: Status
    residual: float
    """Root-mean-square gradient of the final state, computed afresh, in E*."""
    iterations: int
    """On the finest grid."""
    work: tuple[Work, ...] = ()
    """On each grid, the finest first."""
    seconds: float = field(default=0.0, compare=False)
    history: tuple[Iteration, ...] = field(repr=False, default=())

    @property
    def fft_pairs(self) -> float:
        """Transforms of all grids, halved and weighted by their numbers of points."""
        return sum(w.fft_pairs * w.shape[0] * w.shape[1] for w in self.work) / self.points.size

    @property
    def sweeps(self) -> int:
        """Evaluations of the line search on the finest grid."""
        return self.work[0].sweeps if self.work else 0

    def require(self) -> Solution:
        """Return the solution itself, if converged.

        Raises
        ------
        NotConvergedError
            Otherwise.
        """
        if not self.status.ok:
            msg = f"{self.status.value} (residual {self.residual:.2e} after {self.iterations} iterations)"
            raise NotConvergedError(msg)
        return self


def minimise(
    grid: Grid,
    stiffness_q: Real,
    law: Law,
    offset: Real,
    start: Real | None,
    settings: Settings,
    force: float = 0.0,
) -> Solution:
    """Minimise ½ <u, K u> + <φ(offset - u)> - F <u> over u.

    Parameters
    ----------
    grid : gives transforms, means and threads.
    stiffness_q : K >= 0 over the half spectrum, in E*/a0; an infinite mean stiffness holds the mean of u at zero.
    law : φ, per area, as compiled code takes it.
    offset : z at u = 0, shape ``grid.shape``.
    start : z at the start, same shape; None starts on a cascade of coarser grids, from u = 0 on the coarsest.
    settings : when to stop.
    force : F, a uniform force per area along u, in E*; of no effect where the mean of u is held.
    """
    began = time.perf_counter()
    if not np.isfinite(offset).all() or (start is not None and not np.isfinite(start).all()):
        return Solution(offset if start is None else start, Status.NON_FINITE, np.inf, 0)
    level = Level(grid, stiffness_q, LEVELS)
    done: list[Work] = []
    if start is None:
        displacement_q = _cascade(grid, stiffness_q, law, offset, settings, force, done)
        level.work_q[...] = displacement_q
        level.g_q[...] = level.K * displacement_q
        level.inverse()
        level.z[...] = offset - level.work
    else:
        level.work[...] = offset - start
        level.forward()
        level.g_q[...] = level.K * level.work_q
        if level.held:
            level.inverse()
            level.z[...] = offset - level.work
        else:
            level.z[...] = start
    level.g_q[0, 0] = 0.0 if level.held else level.g_q[0, 0] - force
    history: list[Iteration] = []
    status = _descend(level, law, settings, settings.max_iterations, history)

    # The gradient afresh, from z alone: g has gathered rounding errors on the way.
    level.work[...] = offset - level.z
    level.forward()
    level.d_q[...] = level.K * level.work_q
    level.sweep(laws.begin, level.z, level.work, law.kind, law.parameters, -np.inf, level.near)
    level.forward()
    level.d_q += level.work_q
    level.d_q[0, 0] = 0.0 if level.held else level.d_q[0, 0] - force
    residual = float(np.sqrt(grid.inner_q(level.d_q, level.d_q)))
    if status is Status.CONVERGED and not residual <= 2 * settings.tolerance:
        status = Status.LINE_SEARCH
    work = [Work(one.grid.shape, one.transforms / 2, one.sweeps, one.fft_seconds) for one in level.chain]
    seconds = time.perf_counter() - began
    return Solution(
        np.ascontiguousarray(level.z),
        status,
        residual,
        len(history) - 1,
        _joined([*work, *done]),
        seconds,
        tuple(history),
    )


def _joined(parts: list[Work]) -> tuple[Work, ...]:
    """Work of the same grid added up, the finest grid first."""
    shapes = sorted({part.shape for part in parts}, key=lambda shape: -shape[0] * shape[1])
    groups = ([part for part in parts if part.shape == shape] for shape in shapes)
    return tuple(Work(group[0].shape, *map(sum, list(zip(*group, strict=True))[1:])) for group in groups)


def _cascade(
    grid: Grid, stiffness_q: Real, law: Law, offset: Real, settings: Settings, force: float, done: list[Work]
) -> Complex:
    """Displacement to start from, over the half spectrum: solved on the coarsest grid first, then carried up."""
    grids = [grid]
    while len(grids) <= len(COARSE_TOLERANCES) and min(grids[-1].shape) > SMALLEST and grids[-1].coarser:
        grids.append(grids[-1].coarser)
    displacement_q = np.zeros(grids[-1].shape_q, dtype=np.complex128)
    if len(grids) == 1:
        return displacement_q
    offset_q = grid.forward(offset)
    for depth in range(len(grids) - 1, 0, -1):
        here = grids[depth]
        rows, columns = here.shape_q
        cut = np.r_[: rows // 2, grid.shape[0] - rows // 2 : grid.shape[0]]
        coarse_offset_q = here.empty_q()
        restrict(offset_q, coarse_offset_q)
        coarse_offset = here.inverse(coarse_offset_q)
        loose = replace(settings, tolerance=settings.tolerance * COARSE_TOLERANCES[depth - 1], max_iterations=400)
        start = coarse_offset - here.inverse(displacement_q)
        found = minimise(here, stiffness_q[cut, :columns], law, coarse_offset, start, loose, force)
        done.extend(found.work)
        solved_q = here.forward(coarse_offset - found.points)
        displacement_q = np.zeros(grids[depth - 1].shape_q, dtype=np.complex128)
        # A coarse grid that failed is no start: the next one begins from rest.
        if np.isfinite(found.residual):
            prolong(solved_q, displacement_q)
    return displacement_q


def _descend(
    level: Level,
    law: Law,
    settings: Settings,
    iterations: int,
    history: list[Iteration] | None = None,
    tolerance: float | None = None,
) -> Status:
    """Minimise on one level from its z and g_q; with a history g_q is without its traction, else complete."""
    z, d, s, near = level.z, level.direction, level.work, level.near
    g, d_parts, work = parts(level.g_q), parts(level.d_q), parts(level.work_q)
    K, c0, size, coarse, low = level.K, settings.shift, level.grid.size, level.coarser, level.low
    bound = settings.tolerance if tolerance is None else tolerance
    near_gap = law.reach + NEAR if np.isfinite(law.reach) else np.inf
    level.sweep(laws.begin, z, s, law.kind, law.parameters, near_gap, near)
    if history is None:
        work[...] = 0.0
    else:
        level.forward()
    d_parts[...] = 0.0
    d[...] = 0.0
    alpha = beta = energy = 0.0
    for iteration in range(iterations + 1):
        sums = level.sweep(sweeps.gradient, g, d_parts, work, K, c0, alpha, beta, *low, level.single)
        residual = float(np.sqrt(sums[0]))
        if history is not None:
            history.append(Iteration(residual, energy, alpha))
        if not np.isfinite(residual):
            return Status.NON_FINITE
        if residual <= bound:
            return Status.CONVERGED
        if iteration == iterations:
            return Status.ITERATION_LIMIT
        if coarse is not None:
            e = _coarse_step(level, coarse, law, settings)
            plain = sums
            sums = sums + level.sweep(sweeps.low_modes, g, d_parts, work, K, c0, *low, e)
            if not (np.isfinite(sums).all() and sums[1] > 0):
                # The coarse step does not descend: the gradient's own does.
                sums = plain + level.sweep(sweeps.low_gradient, g, work, K, c0, *low)
                sums[5] = 0.0
        _, gs, ys, ym, dg, dy, ss, sd, dd = sums[:9]
        # Hager and Zhang's beta, SIAM J. Optim. 16, 170 (2005); steepest descent where it does not descend.
        beta = max(0.0, (ys - 2 * dg * ym / dy) / dy) if iteration and dy > 0 else 0.0
        if beta * dg >= gs:
            beta = 0.0
        slope = beta * dg - gs
        curvature = ss - 2 * beta * sd + beta * beta * dd
        if coarse is not None:
            level.sweep(sweeps.low_direction, d_parts, work, *low, beta)
        level.inverse()
        alpha, rise, size_of_energy = _step(level, law, slope, curvature, beta, near_gap)
        if not np.isfinite(alpha):
            return Status.LINE_SEARCH
        if history is not None and rise > 1e-12 * size_of_energy / size:
            history.append(Iteration(residual, energy + rise, alpha))
            return Status.ENERGY_ROSE
        energy += rise
        level.forward()
    return Status.ITERATION_LIMIT


def _coarse_step(level: Level, coarse: Level, law: Law, settings: Settings) -> Real:
    """Step of the displacement that the coarser grid takes from here, as a spectrum in parts."""
    coarse.z[...] = level.z[::2, ::2]
    restrict(level.g_q, coarse.g_q)
    gradient = float(np.sqrt(coarse.grid.inner_q(coarse.g_q, coarse.g_q)))
    _descend(coarse, law, settings, COARSE_ITERATIONS, None, COARSE_REDUCTION * gradient)
    np.subtract(level.z[::2, ::2], coarse.z, out=coarse.work)
    coarse.forward()
    return parts(coarse.work_q)


def _step(
    level: Level, law: Law, slope: float, curvature: float, beta: float, near_gap: float
) -> tuple[float, float, float]:
    """Step along beta d - s; returns its length (NaN if none was found), the change of energy and the sum of |φ|."""
    z, d, s, near, size = level.z, level.direction, level.work, level.near, level.grid.size

    def along(alpha: float) -> tuple[float, float]:
        level.sweeps += 1
        f, c = level.sweep(laws.line, z, d, s, beta, alpha, law.kind, law.parameters, near)[:2]
        return slope + alpha * curvature + f / size, curvature + c / size

    alpha = _line_search(along, slope, curvature)
    sums: Any = level.sweep(laws.move, z, d, s, beta, alpha, law.kind, law.parameters, law.reach, near_gap, near)
    rise = alpha * (slope + 0.5 * alpha * curvature) + sums[1] / size
    f = slope + alpha * curvature + sums[0] / size
    low, high = 0.0, np.inf
    for _ in range(60):
        if abs(f) <= SLOPE_ACCEPTED * abs(slope):
            return alpha, rise, sums[2]
        # Points far from the wall have come near it, which the line search did not see: rare.
        low, high = (low, alpha) if f > 0 else (alpha, high)
        target = (low + high) / 2 if np.isfinite(high) else 2 * alpha
        more = level.sweep(laws.move_on, z, d, s, target - alpha, law.kind, law.parameters)
        alpha = target
        f = slope + alpha * curvature + more[0] / size
        rise = min(rise, 0.0)
    return np.nan, 0.0, 0.0


def _line_search(along: Callable[[float], tuple[float, float]], slope: float, curvature: float) -> float:
    """Step length at which the slope has fallen to a part of the first: Newton's method inside a bracket."""
    _, c = along(0.0)
    alpha = -slope / max(c, curvature) if c > 0 else -slope / curvature if curvature > 0 else 1.0
    low, high = 0.0, np.inf
    for _ in range(40):
        f, c = along(alpha)
        if not np.isfinite(f) or abs(f) <= SLOPE_REDUCTION * abs(slope):
            break
        low, high = (alpha, high) if f < 0 else (low, alpha)
        newton = alpha - f / c if c > 0 else np.inf
        if not low < newton < high:
            newton = (low + high) / 2 if np.isfinite(high) else 4 * alpha
        alpha = min(newton, 10 * alpha)
    return alpha
