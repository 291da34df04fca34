"""The formulas of the wall laws, compiled: energy, traction and stiffness per area at one gap.

A law is a number, its kind, and an array of parameters; :func:`respond` is the one function that all sweeps call, so
that they are compiled once for all laws.  What the parameters are is written in :mod:`continuum.wall`, whose
classes make them and are what users see.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from continuum.grid import Real

__all__ = ["EXPONENTIAL", "INVERSE_POWERS", "SPLINE", "TABLE", "Law", "evaluate", "respond"]

SPLINE, INVERSE_POWERS, EXPONENTIAL, TABLE = 0, 1, 2, 3
"""Kinds of laws."""


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
    """Exponential attraction on a harmonic core, p = (K, γ, ρ, .)."""
    core_stiffness, gamma, rho = p[0], p[1], p[2]
    pull = gamma * np.exp(-max(z, -1.0) / rho)
    energy, traction, stiffness = -pull, -pull / rho, -pull / (rho * rho)
    if z < -1.0:
        energy, traction, stiffness = _below(z, -1.0, (energy, traction, stiffness))
    if z < 0.0:
        return energy + 0.5 * core_stiffness * z * z, traction - core_stiffness * z, stiffness + core_stiffness
    return energy, traction, stiffness


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
