"""Equilibrium of a smooth energy: nonlinear conjugate gradients with a Fourier preconditioner.

The energy is a quadratic form, diagonal in Fourier space, plus a sum over points::

    E(u) = ½ <u, K u> + <φ(offset - u)>

The gap ``z = offset - u`` is carried in real space and ``w = K u`` in Fourier space.  The direction d of each
step needs one transform back (d_q -> d) and its new gradient one forward (p(z) -> p_q): one pair per
iteration.  The line search needs none, since along d::

    E'(α) = <d, w> + α <d, K d> + <p(z - α d) d>

No contact mechanics here: K, offset and φ are all that it knows.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from continuum.grid import Complex, Grid, Real

__all__ = ["NotConvergedError", "Settings", "Solution", "Status", "minimise"]


class PointEnergy(Protocol):
    """Energy φ(z) of a point, its force -φ' and stiffness φ''."""

    @property
    def energy(self) -> Real:
        """φ."""

    @property
    def traction(self) -> Real:
        """-dφ/dz."""

    @property
    def stiffness(self) -> Real:
        """d²φ/dz²."""


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
    """One line of the history of a solve."""

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
    """z = offset - u at each point."""
    status: Status
    residual: float
    """Root-mean-square gradient of the final state, computed afresh, in E*."""
    iterations: int
    fft_pairs: float
    """Forward and inverse transforms, halved."""
    sweeps: int
    """Evaluations of the point energy."""
    history: tuple[Iteration, ...] = field(repr=False, default=())

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
    points: Callable[[Real], PointEnergy],
    offset: Real,
    start: Real,
    settings: Settings,
) -> Solution:
    """Minimise ½ <u, K u> + <φ(offset - u)> over u.

    Parameters
    ----------
    grid : gives transforms and means.
    stiffness_q : K >= 0 over the half spectrum, in E*/a0; a mode of infinite stiffness does not move.
    points : z -> (φ, -φ', φ''), per area.
    offset : z at u = 0, shape ``grid.shape``.
    start : z at the start, same shape.  Modes of infinite stiffness are reset to u = 0.
    settings : when to stop.
    """
    free = np.isfinite(stiffness_q)
    stiffness = np.where(free, stiffness_q, 0.0)
    inverse_metric = free / (stiffness + settings.shift)

    u_q = grid.forward(offset - start) * free
    z = offset - grid.inverse(u_q)
    w_q = stiffness * u_q
    here = points(z)
    g_q = (w_q + grid.forward(here.traction)) * free
    transforms, sweeps = 3, 1

    energy_start = 0.5 * grid.inner_q(u_q, w_q) + grid.mean(here.energy)
    quadratic = 0.5 * grid.inner_q(u_q, w_q)
    energy = energy_start
    d_q: Complex = np.zeros_like(g_q)
    g_old_q, g_s = d_q, 1.0
    history: list[Iteration] = []
    step = 0.0
    status: Status | None = None

    for iteration in range(settings.max_iterations + 1):
        residual = float(np.sqrt(max(grid.inner_q(g_q, g_q), 0.0)))
        history.append(Iteration(residual, energy - energy_start, step))
        if not np.isfinite(residual):
            status = Status.NON_FINITE
        elif residual <= settings.tolerance:
            status = Status.CONVERGED
        elif iteration == settings.max_iterations:
            status = Status.ITERATION_LIMIT
        if status is not None:
            break

        s_q = inverse_metric * g_q
        # Polak-Ribiere, never negative: (g_new - g_old).s_new / g_old.s_old.
        g_s_new = grid.inner_q(g_q, s_q)
        beta = max(0.0, (g_s_new - grid.inner_q(g_old_q, s_q)) / g_s) if iteration else 0.0
        d_q = beta * d_q - s_q
        if grid.inner_q(d_q, g_q) >= 0:
            d_q = -s_q
        g_s, g_old_q = g_s_new, g_q
        d = grid.inverse(d_q)
        transforms += 1

        slope, curvature = grid.inner_q(d_q, w_q), grid.inner_q(d_q, stiffness * d_q)
        found = _line_search(grid, points, z, d, slope, curvature, here)
        sweeps += found.sweeps
        if found.here is None:
            status = Status.LINE_SEARCH
            break
        step, here = found.step, found.here
        z -= step * d
        w_q += step * stiffness * d_q
        quadratic += step * (slope + 0.5 * step * curvature)
        new_energy = quadratic + grid.mean(here.energy)
        # Far above rounding, far below any rise that a step of this line search could make by mistake.
        if new_energy - energy > 1e-9 * (quadratic + grid.mean(np.abs(here.energy))):
            status = Status.ENERGY_ROSE
            break
        energy = new_energy
        g_q = (w_q + grid.forward(here.traction)) * free
        transforms += 1

    # The gradient afresh, from the points alone: w has gathered rounding errors on the way.
    g_q = (stiffness * grid.forward(offset - z) + grid.forward(points(z).traction)) * free
    residual = float(np.sqrt(grid.inner_q(g_q, g_q)))
    if status is Status.CONVERGED and not residual <= 2 * settings.tolerance:
        status = Status.LINE_SEARCH
    assert status is not None
    return Solution(z, status, residual, len(history) - 1, transforms / 2 + 1, sweeps + 1, tuple(history))


class _Found(NamedTuple):
    step: float
    here: PointEnergy | None
    sweeps: int


def _line_search(
    grid: Grid,
    points: Callable[[Real], PointEnergy],
    z: Real,
    d: Real,
    slope: float,
    curvature: float,
    here: PointEnergy,
) -> _Found:
    """A step α > 0 at which |E'(α)| has fallen to 0.3 |E'(0)|: Newton's, kept inside a bracket."""
    first = slope + grid.mean(here.traction * d)
    second = curvature + grid.mean(here.stiffness * d * d)
    low, high = 0.0, np.inf
    step = -first / second if second > 0 else 1.0
    for sweep in range(1, 60):
        there = points(z - step * d)
        derivative = slope + step * curvature + grid.mean(there.traction * d)
        if abs(derivative) <= 0.3 * abs(first):
            return _Found(step, there, sweep)
        low, high = (step, high) if derivative < 0 else (low, step)
        second = curvature + grid.mean(there.stiffness * d * d)
        newton = step - derivative / second if second > 0 else np.inf
        if low < newton < min(high, 4 * max(low, step)):
            step = newton
        else:
            step = 4 * low if np.isinf(high) else 0.5 * (low + high)
        if not np.isfinite(derivative) or (np.isfinite(high) and high - low <= 1e-14 * high):
            break
    return _Found(0.0, None, 60)
