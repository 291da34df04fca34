"""The wall laws on whole arrays: energy, traction and stiffness per area at each gap.

The same formulas as those of :mod:`continuum.model.laws`, in which their parameters are described.  Both sides of a
branch are computed, and one is chosen.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

from continuum.model import laws
from continuum.solve.arrays.library import Array, Library

Response = tuple[Array, Array, Array]
"""Energy, traction and stiffness."""
Formula = Callable[[Any, Array, Array], Response]
"""A law, from the namespace of a library, gaps and parameters."""


def _below(xp: Any, z: Array, core: Array, at_core: Response) -> Response:
    """Continue a law below its core with constant stiffness."""
    energy, traction, stiffness = at_core
    x = xp.where(z < core, z - core, 0.0)
    return energy + x * (0.5 * x * stiffness - traction), traction - x * stiffness, stiffness


def _spline(xp: Any, z: Array, p: Array) -> Response:
    k, core, r, work = p[0], p[1], p[2], p[3]
    x = z - 1.0
    t = xp.where(x < r, x / xp.where(r > 0, r, 1.0), 1.0)
    u = 1.0 - t
    pull = (
        xp.where(t < 1.0, k * r * r * t * t * (0.5 + t * (t / 4 - 2 / 3)) - work, 0.0),
        -k * x * u * u,
        k * u * (1 - 3 * t),
    )
    y = xp.where(z < 1.0, z, 1.0)
    i = 1.0 / xp.where(y > core, y, core)
    i3 = i * i * i
    push = (
        k / 54 * (i3 - 1) * (i3 - 1) * (i3 + 2) - work,
        k / 6 * i3 * i * (i3 * i3 - 1),
        k / 6 * i3 * i * i * (10 * i3 * i3 - 4),
    )
    push = _below(xp, z, core, push)
    return xp.where(x > 0, pull[0], push[0]), xp.where(x > 0, pull[1], push[1]), xp.where(x > 0, pull[2], push[2])


def _power(base: Array, exponent: int) -> Array:
    """Integer power, by squaring."""
    half = _power(base, exponent // 2) if exponent > 1 else 1.0
    return half * half * base if exponent % 2 else half * half


def _inverse_powers(xp: Any, z: Array, p: Array, m: int, n: int) -> Response:
    core, c = p[1], p[0] / (m - n)
    i = 1.0 / xp.where(z > core, z, core)
    low = _power(i, n)
    high = low * _power(i, m - n)
    law = c * (high / m - low / n), c * (high - low) * i, c * ((m + 1) * high - (n + 1) * low) * i * i
    return _below(xp, z, core, law)


def _exponential(xp: Any, z: Array, p: Array) -> Response:
    K, gamma, rho = p[0], p[1], p[2]
    pull = gamma * xp.exp(-xp.where(z > 0.0, z, 0.0) / rho)
    inside = z < 0.0
    return (
        xp.where(inside, gamma * (z / rho - 1) + 0.5 * K * z * z, -pull),
        xp.where(inside, -gamma / rho - K * z, -pull / rho),
        xp.where(inside, K, -pull / (rho * rho)),
    )


def _table(xp: Any, z: Array, p: Array) -> Response:
    n = (p.shape[0] - 2) // 6
    knots, energies, pieces = p[1 : n + 2], p[n + 2 : 2 * n + 2], xp.reshape(p[2 * n + 2 :], (n, 4))
    first, last = p[1], p[n + 1]
    y = xp.reshape(xp.where(z > first, z, first), (-1,))
    at = xp.clip(xp.searchsorted(knots, y, side="right") - 1, 0, n - 1)
    x = y - xp.take(knots, at)
    a, b, c, d = (xp.take(pieces[:, j], at) for j in range(4))
    e = xp.take(energies, at) - x * (d + x * (c / 2 + x * (b / 3 + x * a / 4)))
    law = e, d + x * (c + x * (b + x * a)), -(c + x * (2 * b + x * 3 * a))
    energy, traction, stiffness = _below(xp, z, first, tuple(xp.reshape(each, z.shape) for each in law))
    beyond = z >= last
    return xp.where(beyond, 0.0, energy), xp.where(beyond, 0.0, traction), xp.where(beyond, 0.0, stiffness)


FORMULAS: dict[int, Formula] = {laws.SPLINE: _spline, laws.EXPONENTIAL: _exponential, laws.TABLE: _table}
"""By the kind of a law."""


@cache
def _powers(m: int, n: int) -> Formula:
    """The formula of two exponents, for which it is compiled."""
    return partial(_inverse_powers, m=m, n=n)


class Wall(NamedTuple):
    """A law on a device."""

    parameters: Array
    formula: Formula

    @classmethod
    def on(cls, library: Library, law: laws.Law) -> Wall:
        """A law for the arrays of a library."""
        p, powers = law.parameters, law.kind == laws.INVERSE_POWERS
        return cls(library.put(p), _powers(int(p[2]), int(p[3])) if powers else FORMULAS[law.kind])
