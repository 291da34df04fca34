"""The formulas of the wall laws, compiled, and the fused sweeps over the points of the surface that call them.

A law is a number, its kind, and an array of parameters; :func:`respond` is the one function that all sweeps call, so
that they are compiled once for all laws.  They stand in one file because numba's cache on disk looks at the file of a
function only, not at those of the functions that it calls: elsewhere they would go on with formulas long changed.
What the parameters are is written in :mod:`continuum.model.walls`, whose classes make them and are what users see.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from continuum.model.grid import Real

__all__ = [
    "EXPONENTIAL",
    "INVERSE_POWERS",
    "SPLINE",
    "TABLE",
    "TILE",
    "Law",
    "Mask",
    "compiled",
    "evaluate",
    "line",
    "move",
    "press",
    "respond",
    "turn",
]

SPLINE, INVERSE_POWERS, EXPONENTIAL, TABLE = 0, 1, 2, 3
"""Kinds of laws."""
TILE = 64
"""Length in points of the pieces of a row that are marked as near the wall or not."""

Mask = NDArray[np.bool_]
"""Which tiles are near the wall, one row per row of points."""
Kernel = TypeVar("Kernel", bound=Callable[..., None])


def compiled(function: Kernel) -> Kernel:
    """Compile a sweep, so that it releases the lock of the interpreter, and keep the result on disk.

    Sums may be reordered and a division by zero is infinite instead of an error: only so do loops vectorise.
    A NaN stays a NaN.
    """
    fast = {"reassoc", "contract", "nsz", "arcp"}
    return cast("Kernel", njit(nogil=True, cache=True, error_model="numpy", fastmath=fast)(function))


class Law(NamedTuple):
    """A wall law as compiled code takes it."""

    kind: int
    parameters: Real
    """One-dimensional."""
    reach: float
    """Gap beyond which traction and energy vanish, in a0; infinite if they do not."""


@njit(cache=True, error_model="numpy", inline="always")
def _below(z: float, core: float, at_core: tuple[float, float, float]) -> tuple[float, float, float]:
    """Continue a law below its core with constant stiffness."""
    energy, traction, stiffness = at_core
    x = z - core
    return energy + x * (0.5 * x * stiffness - traction), traction - x * stiffness, stiffness


@njit(cache=True, error_model="numpy")
def _multiply_power(base: Real, exponent: int, out: Real) -> None:
    """Multiply by an integer power of each number, by squaring."""
    square = base.copy()
    while exponent > 0:
        if exponent & 1:
            for j in range(out.size):
                out[j] *= square[j]
        exponent >>= 1
        for j in range(out.size):
            square[j] *= square[j]


@njit(cache=True, error_model="numpy")
def _inverse_powers(gap: Real, p: Real, response: Real) -> None:
    """Energy c [z^-m/m - z^-n/n], p = (k, core, m, n): zero at infinity."""
    k, core, m, n = p[0], p[1], p[2], p[3]
    c = k / (m - n)
    repulsion, attraction, inverse = response[0], response[1], response[2]
    for j in range(gap.size):
        z = gap[j]
        inverse[j] = 1.0 / (z if z > core else core)
        attraction[j] = 1.0
    _multiply_power(inverse, int(n), attraction)
    for j in range(gap.size):
        repulsion[j] = attraction[j]
    _multiply_power(inverse, int(m - n), repulsion)
    for j in range(gap.size):
        i, high, low = inverse[j], repulsion[j], attraction[j]
        energy = c * (high / m - low / n)
        traction = c * (high - low) * i
        stiffness = c * ((m + 1) * high - (n + 1) * low) * i * i
        below = gap[j] - core if gap[j] < core else 0.0
        response[0, j] = energy + below * (0.5 * below * stiffness - traction)
        response[1, j] = traction - below * stiffness
        response[2, j] = stiffness


@njit(cache=True, error_model="numpy", inline="always")
def _spline(z: float, p: Real) -> tuple[float, float, float]:
    """The paper's Eq. (S-6), p = (k, core, range, work of adhesion).

    Both pieces are computed and one is chosen: without branches the loops over it vectorise.
    """
    k, core, r, work = p[0], p[1], p[2], p[3]
    x = z - 1.0
    t = x / r
    t = t if t < 1.0 else 1.0
    u = 1.0 - t
    pull_energy = k * r * r * t * t * (0.5 + t * (t / 4 - 2 / 3)) - work
    pull_energy = pull_energy if t < 1.0 else 0.0
    y = z if z < 1.0 else 1.0
    y = y if y > core else core
    below = z - y  # counts where z < core: there the law goes on with constant stiffness
    i = 1.0 / y
    i3 = i * i * i
    # z^-9/9 - z^-3/3 + 2/9, factored: near the minimum the terms cancel to second order.
    energy = k / 54 * (i3 - 1) * (i3 - 1) * (i3 + 2) - work
    traction = k / 6 * i3 * i * (i3 * i3 - 1)
    stiffness = k / 6 * i3 * i * i * (10 * i3 * i3 - 4)
    attracts = x > 0.0
    return (
        pull_energy if attracts else energy + below * (0.5 * below * stiffness - traction),
        -k * x * u * u if attracts else traction - below * stiffness,
        k * u * (1 - 3 * t) if attracts else stiffness,
    )


@njit(cache=True, error_model="numpy")
def _exponential(z: float, p: Real) -> tuple[float, float, float]:
    """Exponential attraction outside, a harmonic core inside, p = (K, γ, ρ)."""
    core_stiffness, gamma, rho = p[0], p[1], p[2]
    if z < 0.0:
        return gamma * (z / rho - 1) + 0.5 * core_stiffness * z * z, -gamma / rho - core_stiffness * z, core_stiffness
    pull = gamma * np.exp(-z / rho)
    return -pull, -pull / rho, -pull / (rho * rho)


@njit(cache=True, error_model="numpy")
def _table(z: float, p: Real) -> tuple[float, float, float]:
    """Cubic pieces of the traction, p = (number of pieces N, N + 1 knots, N energies, 4 N coefficients)."""
    n = int(p[0])
    last = p[n + 1]
    if z >= last:
        return 0.0, 0.0, 0.0
    y = max(z, p[1])
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if p[1 + middle] <= y:
            low = middle
        else:
            high = middle
    x = y - p[1 + low]
    at = 2 + 2 * n + 4 * low
    a, b, c, d = p[at], p[at + 1], p[at + 2], p[at + 3]
    here = (
        p[2 + n + low] - x * (d + x * (c / 2 + x * (b / 3 + x * a / 4))),
        d + x * (c + x * (b + x * a)),
        -(c + x * (2 * b + x * 3 * a)),
    )
    return _below(z, p[1], here) if z < p[1] else here


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"})
def respond(kind: int, gap: Real, p: Real, response: Real) -> None:
    """Energy, traction and stiffness per area of a law, the rows of ``response``, at each gap of a tile."""
    if kind == SPLINE:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = _spline(gap[j], p)
    elif kind == INVERSE_POWERS:
        _inverse_powers(gap, p, response)
    elif kind == EXPONENTIAL:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = _exponential(gap[j], p)
    else:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = _table(gap[j], p)


def evaluate(law: Law, gap: Real) -> tuple[Real, Real, Real]:
    """Energy, traction and stiffness at each gap, in the shape of the gaps."""
    flat = np.ascontiguousarray(gap, dtype=np.float64).ravel()
    response = np.empty((3, flat.size))
    respond(law.kind, flat, law.parameters, response)
    energy, traction, stiffness = response.reshape(3, *np.shape(gap))
    return energy, traction, stiffness


# --- sweeps ------------------------------------------------------------------------------------------------
#
# A sweep is a function of the rows first:last of a block, which writes that block's sums.  Fields are whole arrays
# with padded rows, of which n points count; ``out`` and ``s`` are buffers of the block alone, which is transformed
# while it stays in the cache.  Tiles of a row are followed by the line search where they are marked as near; points
# that are NaN are near, so that they are not lost.


@compiled
def press(
    first: int,
    last: int,
    sums: Real,
    out: Real,
    z: Real,
    n: int,
    kind: int,
    p: Real,
    reach: float,
    near_gap: float,
    near: Mask,
) -> None:
    """Traction into ``out``.  Marks the tiles."""
    here = np.empty((3, TILE))
    for i in range(first, last):
        for t in range(near.shape[1]):
            gap = z[i, t * TILE : min(n, (t + 1) * TILE)]
            traction = out[i - first, t * TILE : min(n, (t + 1) * TILE)]
            close = touching = 0
            for j in range(gap.size):
                close += not gap[j] >= near_gap
                touching += not gap[j] >= reach
            near[i, t] = close > 0
            if touching:
                respond(kind, gap, p, here)
                for j in range(gap.size):
                    traction[j] = here[1, j]
            else:
                for j in range(gap.size):
                    traction[j] = 0.0


@compiled
def turn(
    first: int,
    last: int,
    sums: Real,
    s: Real,
    d: Real,
    n: int,
    beta: float,
    z: Real,
    kind: int,
    p: Real,
    near: Mask,
) -> None:
    """New direction, d <- beta d - s.  sums, over the marked tiles: of stiffness d²."""
    curvature = 0.0
    here = np.empty((3, TILE))
    for i in range(first, last):
        direction, step = d[i, :n], s[i - first, :n]
        for j in range(n):
            direction[j] = beta * direction[j] - step[j]
        for t in range(near.shape[1]):
            if near[i, t]:
                gap = z[i, t * TILE : min(n, (t + 1) * TILE)]
                e = d[i, t * TILE : min(n, (t + 1) * TILE)]
                respond(kind, gap, p, here)
                for j in range(gap.size):
                    curvature += here[2, j] * e[j] * e[j]
    sums[0] = curvature


@compiled
def line(
    first: int,
    last: int,
    sums: Real,
    z: Real,
    d: Real,
    n: int,
    alpha: float,
    kind: int,
    p: Real,
    near: Mask,
) -> None:
    """At z - alpha d.  sums, over the marked tiles: of (change of traction) d; of stiffness d²."""
    slope = curvature = 0.0
    here, there, trial = np.empty((3, TILE)), np.empty((3, TILE)), np.empty(TILE)
    for i in range(first, last):
        for t in range(near.shape[1]):
            if near[i, t]:
                gap = z[i, t * TILE : min(n, (t + 1) * TILE)]
                e = d[i, t * TILE : min(n, (t + 1) * TILE)]
                for j in range(gap.size):
                    trial[j] = gap[j] - alpha * e[j]
                respond(kind, gap, p, here)
                respond(kind, trial[: gap.size], p, there)
                for j in range(gap.size):
                    slope += (there[1, j] - here[1, j]) * e[j]
                    curvature += there[2, j] * e[j] * e[j]
    sums[0] = slope
    sums[1] = curvature


@compiled
def move(
    first: int,
    last: int,
    sums: Real,
    out: Real,
    z: Real,
    d: Real,
    n: int,
    step: float,
    alpha: float,
    kind: int,
    p: Real,
    reach: float,
    near_gap: float,
    near: Mask,
) -> None:
    """Step z <- z - step d, the last of several that add up to alpha.  Marks the tiles anew.

    The change of the traction since alpha = 0 goes into ``out``.
    sums: of that change times d; of what the energy changes beyond first order; of |energy|.
    """
    slope = second = size = 0.0
    here, there, old = np.empty((3, TILE)), np.empty((3, TILE)), np.empty(TILE)
    for i in range(first, last):
        for t in range(near.shape[1]):
            gap = z[i, t * TILE : min(n, (t + 1) * TILE)]
            e = d[i, t * TILE : min(n, (t + 1) * TILE)]
            change = out[i - first, t * TILE : min(n, (t + 1) * TILE)]
            close = touching = 0
            for j in range(gap.size):
                gap[j] -= step * e[j]
                old[j] = gap[j] + alpha * e[j]
            for j in range(gap.size):
                lower = old[j] if old[j] < gap[j] else gap[j]
                close += not lower >= near_gap
                touching += not lower >= reach
            near[i, t] = close > 0
            if touching:
                respond(kind, old[: gap.size], p, here)
                respond(kind, gap, p, there)
                for j in range(gap.size):
                    change[j] = there[1, j] - here[1, j]
                    slope += change[j] * e[j]
                    second += there[0, j] - here[0, j] - alpha * here[1, j] * e[j]
                    size += abs(there[0, j])
            else:
                for j in range(gap.size):
                    change[j] = 0.0
    sums[0] = slope
    sums[1] = second
    sums[2] = size
