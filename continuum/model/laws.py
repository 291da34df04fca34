"""The formulas of the wall laws, each written once, compiled for one gap and called with whole arrays.

A law is a number (its kind) and an array of parameters, which the classes in :mod:`continuum.model.walls` make.
Compiled code calls :func:`respond`, which is compiled once for all laws; grids of arrays ask :data:`ON_ARRAYS`.

The cache on disk checks the file of a function only, not those of the functions that it calls; see
:mod:`continuum.solve.compiled.compiling`.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable

from continuum.model.fourier import Real
from continuum.model.kept import kept_on_disk

SPLINE, INVERSE_POWERS, EXPONENTIAL, TABLE = range(4)
"""Kinds of laws, named in :func:`respond` and in :data:`ON_ARRAYS`."""


Array = Any
"""An array of any library of the array API."""
Response = tuple[Array, Array, Array]
"""Energy, traction and stiffness."""
OnArrays = Callable[[Any, Array, Array], Response]
"""Law as a function of an array library's namespace, gaps and parameters."""


class Law(NamedTuple):
    """A wall law for compiled code."""

    kind: int
    parameters: Real
    """Parameters of the formula, one-dimensional."""
    reach: float
    """Gap beyond which traction and energy vanish, in a0; infinite if they do not."""


# --- The formulas, each of one gap or of an array: ``where`` and ``exp`` are those of either -------------------------


@register_jitable(inline="always")
def continued(where: Any, z: Array, core: Array, at_core: Response) -> Response:
    """Continue a law below its core with constant stiffness; ``at_core``: its response at z or, below, at the core."""
    energy, traction, stiffness = at_core
    below = where(z < core, z - core, 0.0)
    return energy + below * (0.5 * below * stiffness - traction), traction - below * stiffness, stiffness


def spline(where: Any, z: Array, p: Array) -> Response:
    """The paper's Eq. (S-6), p = (k, core, range, work of adhesion).

    Both pieces are computed and one is chosen: without branches the loops over it vectorise.
    """
    k, core, r, work = p[0], p[1], p[2], p[3]
    x = z - 1.0
    t = x / r
    t = where(t < 1.0, t, 1.0)  # also without a range, where it is infinite or no number
    u = 1.0 - t
    pull_energy = where(t < 1.0, k * r * r * t * t * (0.5 + t * (t / 4 - 2 / 3)) - work, 0.0)
    i = 1.0 / where(z > core, z, core)
    i3 = i * i * i
    # z^-9/9 - z^-3/3 + 2/9, factored: near the minimum the terms cancel to second order.
    energy = k / 54 * (i3 - 1) * (i3 - 1) * (i3 + 2) - work
    push = energy, k / 6 * i3 * i * (i3 * i3 - 1), k / 6 * i3 * i * i * (10 * i3 * i3 - 4)
    energy, traction, stiffness = continued(where, z, core, push)
    attracts = x > 0.0
    return (
        where(attracts, pull_energy, energy),
        where(attracts, -k * x * u * u, traction),
        where(attracts, k * u * (1 - 3 * t), stiffness),
    )


def inverse_powers(where: Any, z: Array, p: Array, inverse: Array, high: Array, low: Array) -> Response:
    """Energy c [z^-m/m - z^-n/n], p = (k, core, m, n): zero at infinity.

    ``inverse`` is 1/z, at most that at the core, ``high`` and ``low`` its powers m and n.
    """
    k, core, m, n = p[0], p[1], p[2], p[3]
    c = k / (m - n)
    stiffness = c * ((m + 1) * high - (n + 1) * low) * inverse * inverse
    return continued(where, z, core, (c * (high / m - low / n), c * (high - low) * inverse, stiffness))


def exponential(where: Any, exp: Any, z: Array, p: Array) -> Response:
    """Exponential attraction outside, a harmonic core inside, p = (K, γ, ρ)."""
    core_stiffness, gamma, rho = p[0], p[1], p[2]
    pull = gamma * exp(-where(z > 0.0, z, 0.0) / rho)
    inside = z < 0.0
    return (
        where(inside, gamma * (z / rho - 1) + 0.5 * core_stiffness * z * z, -pull),
        where(inside, -gamma / rho - core_stiffness * z, -pull / rho),
        where(inside, core_stiffness, -pull / (rho * rho)),
    )


def piece(
    where: Any, z: Array, ends: tuple[Array, Array], x: Array, start: Array, cubic: tuple[Array, ...]
) -> Response:
    """A cubic piece of the traction, of powers 3 to 0 of the distance x from its knot, where the energy is ``start``.

    Before the first of the ``ends`` of the table the law is continued, beyond the last it is zero.
    """
    a, b, c, d = cubic
    energy = start - x * (d + x * (c / 2 + x * (b / 3 + x * a / 4)))
    inside = energy, d + x * (c + x * (b + x * a)), -(c + x * (2 * b + x * 3 * a))
    energy, traction, stiffness = continued(where, z, ends[0], inside)
    within = z < ends[1]
    return where(within, energy, 0.0), where(within, traction, 0.0), where(within, stiffness, 0.0)


# --- The same compiled ---------------------------------------------------------------------------------------------


@njit(error_model="numpy", inline="always")
def _choose(condition: bool, one: float, other: float) -> float:
    return one if condition else other


_spline, _inverse_powers, _exponential, _piece = (
    njit(error_model="numpy", inline="always")(law) for law in (spline, inverse_powers, exponential, piece)
)


@kept_on_disk(error_model="numpy")
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


@kept_on_disk(error_model="numpy")
def _powers(gap: Real, p: Real, response: Real) -> None:
    """Inverse powers of a tile of gaps: loops by themselves for the powers, which vectorise."""
    core, m, n = p[1], int(p[2]), int(p[3])
    high, low, inverse = response[0], response[1], response[2]
    for j in range(gap.size):
        inverse[j] = 1.0 / (gap[j] if gap[j] > core else core)
        low[j] = 1.0
    _multiply_power(inverse, n, low)
    for j in range(gap.size):
        high[j] = low[j]
    _multiply_power(inverse, m - n, high)
    for j in range(gap.size):
        answer = _inverse_powers(_choose, gap[j], p, inverse[j], high[j], low[j])
        response[0, j], response[1, j], response[2, j] = answer


@kept_on_disk(error_model="numpy")
def _table(z: float, p: Real) -> tuple[float, float, float]:
    """A table, p = (number of pieces N, N + 1 knots, N energies, 4 N coefficients)."""
    n = int(p[0])
    if z >= p[n + 1]:
        return 0.0, 0.0, 0.0  # most points are out of reach: no search
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if p[1 + middle] <= z:
            low = middle
        else:
            high = middle
    x = max(z, p[1]) - p[1 + low]
    at = 2 + 2 * n + 4 * low
    cubic = p[at], p[at + 1], p[at + 2], p[at + 3]
    return _piece(_choose, z, (p[1], p[n + 1]), x, p[2 + n + low], cubic)


@kept_on_disk(error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"})
def respond(kind: int, gap: Real, p: Real, response: Real) -> None:
    """Energy, traction and stiffness per area of a law, the rows of ``response``, at each gap of a tile.

    The formulas are :func:`spline`, :func:`inverse_powers`, :func:`exponential` and :func:`piece`, compiled.
    """
    if kind == SPLINE:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = _spline(_choose, gap[j], p)
    elif kind == INVERSE_POWERS:
        _powers(gap, p, response)
    elif kind == EXPONENTIAL:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = _exponential(_choose, math.exp, gap[j], p)
    elif kind == TABLE:
        for j in range(gap.size):
            response[0, j], response[1, j], response[2, j] = _table(gap[j], p)
    else:
        response[:] = math.nan


def evaluate(law: Law, gap: Real) -> tuple[Real, Real, Real]:
    """Energy, traction and stiffness at each gap, in the shape of the gaps."""
    flat = np.require(gap, np.float64, ("C", "W")).ravel()  # for gaps that are read only, all would be compiled again
    response = np.empty((3, flat.size))
    respond(law.kind, flat, law.parameters, response)
    energy, traction, stiffness = response.reshape(3, *np.shape(gap))
    return energy, traction, stiffness


# --- The same on whole arrays of any library, xp being its namespace ------------------------------------------------


def _raise(base: Array, exponent: int) -> Array:
    """Integer power, by squaring."""
    half = _raise(base, exponent // 2) if exponent > 1 else 1.0
    return half * half * base if exponent % 2 else half * half


def powers_on_arrays(xp: Any, z: Array, p: Array, m: int, n: int) -> Response:
    """Inverse powers for whole arrays; the exponents are Python numbers."""
    inverse = 1.0 / xp.where(z > p[1], z, p[1])
    low = _raise(inverse, n)
    return inverse_powers(xp.where, z, p, inverse, low * _raise(inverse, m - n), low)


def _table_on_arrays(xp: Any, z: Array, p: Array) -> Response:
    n = (p.shape[0] - 2) // 6
    knots, energies, pieces = p[1 : n + 2], p[n + 2 : 2 * n + 2], xp.reshape(p[2 * n + 2 :], (n, 4))
    y = xp.reshape(xp.where(z > p[1], z, p[1]), (-1,))
    at = xp.clip(xp.searchsorted(knots, y, side="right") - 1, 0, n - 1)
    found = (y - xp.take(knots, at), xp.take(energies, at), *(xp.take(pieces[:, j], at) for j in range(4)))
    x, start, *cubic = (xp.reshape(each, z.shape) for each in found)
    return piece(xp.where, z, (p[1], p[n + 1]), x, start, tuple(cubic))


ON_ARRAYS: dict[int, OnArrays] = {
    SPLINE: lambda xp, z, p: spline(xp.where, z, p),
    EXPONENTIAL: lambda xp, z, p: exponential(xp.where, xp.exp, z, p),
    TABLE: _table_on_arrays,
}
"""Formulas by the kind of a law, except inverse powers, whose exponents are Python numbers."""
