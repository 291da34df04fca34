"""The formulas of the wall laws, compiled, and the fused sweeps over the points of the surface that call them.

A law is a number, its kind, and an array of parameters; :func:`respond` is the one function that all sweeps call, so
that they are compiled once for all laws.  They stand in one file because numba's cache on disk looks at the file of a
function only, not at those of the functions that it calls: elsewhere they would go on with formulas long changed.
What the parameters are is written in :mod:`continuum.wall`, whose classes make them and are what users see.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from continuum.grid import Real

__all__ = [
    "EXPONENTIAL",
    "INVERSE_POWERS",
    "SPLINE",
    "TABLE",
    "TILE",
    "Law",
    "begin",
    "compiled",
    "evaluate",
    "line",
    "move",
    "move_on",
    "respond",
]

SPLINE, INVERSE_POWERS, EXPONENTIAL, TABLE = 0, 1, 2, 3
"""Kinds of laws."""
TILE = 64
"""Length in points of the pieces of a row that are marked as near the wall or not."""

Mask = NDArray[np.bool_]
Kernel = TypeVar("Kernel", bound=Callable[..., None])


def compiled(function: Kernel) -> Kernel:
    """Compile a sweep, so that it releases the lock of the interpreter, and keep the result on disk.

    Sums may be reordered, so that they vectorise; a NaN stays a NaN.
    """
    return cast("Kernel", njit(nogil=True, cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"})(function))


class Law(NamedTuple):
    """A wall law as compiled code takes it."""

    kind: int
    parameters: Real
    """One-dimensional."""
    reach: float
    """Gap beyond which traction and energy vanish, in a0; infinite if they do not."""


@njit(cache=True, inline="always")
def _below(z: float, core: float, at_core: tuple[float, float, float]) -> tuple[float, float, float]:
    """Continue a law below its core with constant stiffness."""
    energy, traction, stiffness = at_core
    x = z - core
    return energy + x * (0.5 * x * stiffness - traction), traction - x * stiffness, stiffness


@njit(cache=True)
def _inverse_powers(z: float, p: Real) -> tuple[float, float, float]:
    """Energy c [z^-m/m - z^-n/n], p = (k, core, m, n, .): zero at infinity."""
    k, core, m, n = p[0], p[1], p[2], p[3]
    c = k / (m - n)
    x = max(z, core)
    repulsion, attraction = x**-m, x**-n
    here = (
        c * (repulsion / m - attraction / n),
        c * (repulsion - attraction) / x,
        c * ((m + 1) * repulsion - (n + 1) * attraction) / (x * x),
    )
    return _below(z, core, here) if z < core else here


@njit(cache=True)
def _spline(z: float, p: Real) -> tuple[float, float, float]:
    """The paper's Eq. (potential), p = (k, core, range, work of adhesion)."""
    k, core, r, work = p[0], p[1], p[2], p[3]
    x = z - 1.0
    if x > 0.0:
        if x >= r:
            return 0.0, 0.0, 0.0
        t = x / r
        energy = k * r * r * t * t * (0.5 + t * (t / 4 - 2 / 3)) - work
        return energy, -k * x * (1 - t) * (1 - t), k * (1 - t) * (1 - 3 * t)
    y = max(z, core)
    i3 = 1 / (y * y * y)
    here = (
        # z^-9/9 - z^-3/3 + 2/9, factored: near the minimum the terms cancel to second order.
        k / 54 * (i3 - 1) * (i3 - 1) * (i3 + 2) - work,
        k / 6 * i3 / y * (i3 * i3 - 1),
        k / 6 * i3 / (y * y) * (10 * i3 * i3 - 4),
    )
    return _below(z, core, here) if z < core else here


@njit(cache=True)
def _exponential(z: float, p: Real) -> tuple[float, float, float]:
    """Exponential attraction outside, a harmonic core inside, p = (K, γ, ρ)."""
    core_stiffness, gamma, rho = p[0], p[1], p[2]
    if z < 0.0:
        return gamma * (z / rho - 1) + 0.5 * core_stiffness * z * z, -gamma / rho - core_stiffness * z, core_stiffness
    pull = gamma * np.exp(-z / rho)
    return -pull, -pull / rho, -pull / (rho * rho)


@njit(cache=True)
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


@njit(cache=True)
def respond(kind: int, z: float, p: Real) -> tuple[float, float, float]:
    """Energy, traction and stiffness per area of a law at a gap."""
    if kind == SPLINE:
        return _spline(z, p)
    if kind == INVERSE_POWERS:
        return _inverse_powers(z, p)
    if kind == EXPONENTIAL:
        return _exponential(z, p)
    return _table(z, p)


@njit(cache=True)
def _evaluate(kind: int, p: Real, gap: Real, energy: Real, traction: Real, stiffness: Real) -> None:
    for i in range(gap.size):
        energy[i], traction[i], stiffness[i] = respond(kind, gap[i], p)


def evaluate(law: Law, gap: Real) -> tuple[Real, Real, Real]:
    """Energy, traction and stiffness at each gap, in the shape of the gaps."""
    flat = np.ascontiguousarray(gap, dtype=np.float64).ravel()
    results = tuple(np.empty(flat.size) for _ in range(3))
    _evaluate(law.kind, law.parameters, flat, *results)
    energy, traction, stiffness = (values.reshape(np.shape(gap)) for values in results)
    return energy, traction, stiffness


# --- sweeps ------------------------------------------------------------------------------------------------


@compiled
def begin(
    start: int,
    stop: int,
    sums: Real,
    z: Real,
    out: Real,
    kind: int,
    p: Real,
    near_gap: float,
    near: Mask,
) -> None:
    """Traction into ``out``; tiles with a gap below ``near_gap`` are marked."""
    n = z.shape[1]
    for i in range(start, stop):
        for t in range(near.shape[1]):
            smallest = np.inf
            for j in range(t * TILE, min(n, (t + 1) * TILE)):
                out[i, j] = respond(kind, z[i, j], p)[1]
                smallest = min(smallest, z[i, j])
            near[i, t] = smallest < near_gap


@compiled
def line(
    start: int,
    stop: int,
    sums: Real,
    z: Real,
    d: Real,
    s: Real,
    beta: float,
    alpha: float,
    kind: int,
    p: Real,
    near: Mask,
) -> None:
    """Along e = beta d - s at z - alpha e, over the marked tiles: sums of (change of traction) e, stiffness e²."""
    n = z.shape[1]
    f = 0.0
    c = 0.0
    for i in range(start, stop):
        for t in range(near.shape[1]):
            if near[i, t]:
                for j in range(t * TILE, min(n, (t + 1) * TILE)):
                    e = beta * d[i, j] - s[i, j]
                    _, traction, stiffness = respond(kind, z[i, j] - alpha * e, p)
                    f += (traction - respond(kind, z[i, j], p)[1]) * e
                    c += stiffness * e * e
    sums[0] = f
    sums[1] = c


@compiled
def move(
    start: int,
    stop: int,
    sums: Real,
    z: Real,
    d: Real,
    s: Real,
    beta: float,
    alpha: float,
    kind: int,
    p: Real,
    reach: float,
    near_gap: float,
    near: Mask,
) -> None:
    """Step: d <- beta d - s; z <- z - alpha d; s <- change of traction.  Marks the tiles anew.

    sums: of s d; of what the energy changes beyond first order; of |energy|.
    """
    n = z.shape[1]
    f = second = size = 0.0
    for i in range(start, stop):
        for t in range(near.shape[1]):
            lo = t * TILE
            hi = min(n, lo + TILE)
            smallest = np.inf
            for j in range(lo, hi):
                e = beta * d[i, j] - s[i, j]
                old = z[i, j]
                new = old - alpha * e
                d[i, j] = e
                z[i, j] = new
                smallest = min(smallest, min(new, old))
            near[i, t] = smallest < near_gap
            if smallest < reach:
                for j in range(lo, hi):
                    e = d[i, j]
                    before, pressed, _ = respond(kind, z[i, j] + alpha * e, p)
                    after, presses, _ = respond(kind, z[i, j], p)
                    change = presses - pressed
                    s[i, j] = change
                    f += change * e
                    second += after - before - alpha * pressed * e
                    size += abs(after)
            else:
                for j in range(lo, hi):
                    s[i, j] = 0.0
    sums[0] = f
    sums[1] = second
    sums[2] = size


@compiled
def move_on(
    start: int,
    stop: int,
    sums: Real,
    z: Real,
    d: Real,
    s: Real,
    step: float,
    kind: int,
    p: Real,
) -> None:
    """A further step of the same direction: z <- z - step d; s <- s + change of traction; sums: of s d."""
    for i in range(start, stop):
        for j in range(z.shape[1]):
            old = z[i, j]
            new = old - step * d[i, j]
            z[i, j] = new
            s[i, j] += respond(kind, new, p)[1] - respond(kind, old, p)[1]
            sums[0] += s[i, j] * d[i, j]
