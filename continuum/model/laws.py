"""The formulas of the wall laws, compiled, and on whole arrays.

A law is a number (its kind) and an array of parameters, which the classes in :mod:`continuum.model.walls` make.
Compiled code calls :func:`respond`, which is compiled once for all laws; grids of arrays ask :data:`ON_ARRAYS`.

numba's cache on disk checks the file of a function only, not those of the functions that it calls; see
:mod:`continuum.solve.compiled.compiling`.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from continuum.model.fourier import Real

SPLINE, INVERSE_POWERS, EXPONENTIAL, TABLE = range(4)
"""Kinds of laws, named in :func:`respond` and in :data:`ON_ARRAYS`."""


Array = Any
"""An array of any library of the array API."""
Response = tuple[Array, Array, Array]
"""Energy, traction and stiffness."""
OnArrays = Callable[[Any, Array, Array], Response]
"""A law of the namespace of a library, gaps and parameters."""


class Law(NamedTuple):
    """A wall law for compiled code."""

    kind: int
    parameters: Real
    """One-dimensional."""
    reach: float
    """Gap beyond which traction and energy vanish, in a0; infinite if they do not."""


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
        energy, traction = c * (high / m - low / n), c * (high - low) * i
        stiffness = c * ((m + 1) * high - (n + 1) * low) * i * i
        below = gap[j] - core if gap[j] < core else 0.0
        response[0, j] = energy + below * (0.5 * below * stiffness - traction)
        response[1, j] = traction - below * stiffness
        response[2, j] = stiffness


@njit(cache=True, error_model="numpy", inline="always")
def spline(z: float, p: Real) -> tuple[float, float, float]:
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
    y = z if z > core else core
    below = z - y  # used where z < core: there the law continues with constant stiffness
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
def exponential(z: float, p: Real) -> tuple[float, float, float]:
    """Exponential attraction outside, a harmonic core inside, p = (K, γ, ρ)."""
    core_stiffness, gamma, rho = p[0], p[1], p[2]
    if z < 0.0:
        return gamma * (z / rho - 1) + 0.5 * core_stiffness * z * z, -gamma / rho - core_stiffness * z, core_stiffness
    pull = gamma * math.exp(-z / rho)
    return -pull, -pull / rho, -pull / (rho * rho)


@njit(cache=True, error_model="numpy")
def table(z: float, p: Real) -> tuple[float, float, float]:
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
    energy = p[2 + n + low] - x * (d + x * (c / 2 + x * (b / 3 + x * a / 4)))
    traction, stiffness = d + x * (c + x * (b + x * a)), -(c + x * (2 * b + x * 3 * a))
    below = z - y  # below the first knot the law continues with constant stiffness
    return energy + below * (0.5 * below * stiffness - traction), traction - below * stiffness, stiffness


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"})
def respond(kind: int, gap: Real, p: Real, response: Real) -> None:
    """Energy, traction and stiffness per area of a law, the rows of ``response``, at each gap of a tile."""
    if kind == SPLINE:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = spline(gap[j], p)
    elif kind == INVERSE_POWERS:
        _inverse_powers(gap, p, response)
    elif kind == EXPONENTIAL:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = exponential(gap[j], p)
    elif kind == TABLE:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = table(gap[j], p)
    else:
        response[:] = math.nan


def evaluate(law: Law, gap: Real) -> tuple[Real, Real, Real]:
    """Energy, traction and stiffness at each gap, in the shape of the gaps."""
    flat = np.require(gap, np.float64, ("C", "W")).ravel()  # for gaps that are read only, all would be compiled again
    response = np.empty((3, flat.size))
    respond(law.kind, flat, law.parameters, response)
    energy, traction, stiffness = response.reshape(3, *np.shape(gap))
    return energy, traction, stiffness


# --- The same on whole arrays of any library, xp being its namespace: both sides of a branch are computed -------------


def _continue(xp: Any, z: Array, core: Array, at_core: Response) -> Response:
    """Continue a law below its core with constant stiffness."""
    energy, traction, stiffness = at_core
    x = xp.where(z < core, z - core, 0.0)
    return energy + x * (0.5 * x * stiffness - traction), traction - x * stiffness, stiffness


def _spline_on_arrays(xp: Any, z: Array, p: Array) -> Response:
    k, core, r, work = p[0], p[1], p[2], p[3]
    x = z - 1.0
    t = xp.where(x < r, x / xp.where(r > 0, r, 1.0), 1.0)
    u = 1.0 - t
    pull = (
        xp.where(t < 1.0, k * r * r * t * t * (0.5 + t * (t / 4 - 2 / 3)) - work, 0.0),
        -k * x * u * u,
        k * u * (1 - 3 * t),
    )
    i = 1.0 / xp.where(z > core, z, core)
    i3 = i * i * i
    push = (
        k / 54 * (i3 - 1) * (i3 - 1) * (i3 + 2) - work,
        k / 6 * i3 * i * (i3 * i3 - 1),
        k / 6 * i3 * i * i * (10 * i3 * i3 - 4),
    )
    push = _continue(xp, z, core, push)
    return xp.where(x > 0, pull[0], push[0]), xp.where(x > 0, pull[1], push[1]), xp.where(x > 0, pull[2], push[2])


def _raise(base: Array, exponent: int) -> Array:
    """Integer power, by squaring."""
    half = _raise(base, exponent // 2) if exponent > 1 else 1.0
    return half * half * base if exponent % 2 else half * half


def powers_on_arrays(xp: Any, z: Array, p: Array, m: int, n: int) -> Response:
    """Inverse powers, p as of the compiled ones."""
    core, c = p[1], p[0] / (m - n)
    i = 1.0 / xp.where(z > core, z, core)
    low = _raise(i, n)
    high = low * _raise(i, m - n)
    law = c * (high / m - low / n), c * (high - low) * i, c * ((m + 1) * high - (n + 1) * low) * i * i
    return _continue(xp, z, core, law)


def _exponential_on_arrays(xp: Any, z: Array, p: Array) -> Response:
    K, gamma, rho = p[0], p[1], p[2]
    pull = gamma * xp.exp(-xp.where(z > 0.0, z, 0.0) / rho)
    inside = z < 0.0
    return (
        xp.where(inside, gamma * (z / rho - 1) + 0.5 * K * z * z, -pull),
        xp.where(inside, -gamma / rho - K * z, -pull / rho),
        xp.where(inside, K, -pull / (rho * rho)),
    )


def _table_on_arrays(xp: Any, z: Array, p: Array) -> Response:
    n = (p.shape[0] - 2) // 6
    knots, energies, pieces = p[1 : n + 2], p[n + 2 : 2 * n + 2], xp.reshape(p[2 * n + 2 :], (n, 4))
    first, last = p[1], p[n + 1]
    y = xp.reshape(xp.where(z > first, z, first), (-1,))
    at = xp.clip(xp.searchsorted(knots, y, side="right") - 1, 0, n - 1)
    x = y - xp.take(knots, at)
    a, b, c, d = (xp.take(pieces[:, j], at) for j in range(4))
    e = xp.take(energies, at) - x * (d + x * (c / 2 + x * (b / 3 + x * a / 4)))
    law = e, d + x * (c + x * (b + x * a)), -(c + x * (2 * b + x * 3 * a))
    energy, traction, stiffness = _continue(xp, z, first, tuple(xp.reshape(each, z.shape) for each in law))
    beyond = z >= last
    return xp.where(beyond, 0.0, energy), xp.where(beyond, 0.0, traction), xp.where(beyond, 0.0, stiffness)


ON_ARRAYS: dict[int, OnArrays] = {
    SPLINE: _spline_on_arrays,
    EXPONENTIAL: _exponential_on_arrays,
    TABLE: _table_on_arrays,
}
"""By the kind of a law, but for inverse powers, whose exponents are numbers of Python."""
