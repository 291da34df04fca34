"""Wall laws: energy, traction and stiffness per area of the rigid wall on the surface, at a given gap.

A law is a pure function of the gap.  Its core, where the paper's (a0/z)^10 would overflow, is continued with
constant stiffness below ``core``: finite everywhere, and exact for every state whose smallest gap is above
it, which :mod:`continuum.loading` checks at the end of each solve.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from continuum.grid import Real

__all__ = ["LennardJonesSpline", "Response", "Tabulated", "Wall"]


class Response(NamedTuple):
    """What the wall does to the surface at each point, per area."""

    energy: Real
    """Interaction energy, zero at infinite gap, in E* a0."""
    traction: Real
    """-d energy/d gap, in E*; compression positive."""
    stiffness: Real
    """d²energy/d gap² = -d traction/d gap, in E*/a0; negative where the law softens."""


class Wall(Protocol):
    """The interface of a wall law."""

    @property
    def zero_gap(self) -> float:
        """Gap at which the traction changes sign, in a0."""

    @property
    def range(self) -> float:
        """Distance beyond ``zero_gap`` over which the wall attracts, in a0."""

    @property
    def core(self) -> float:
        """Gap below which the law is continued with constant stiffness, in a0."""

    @property
    def work_of_adhesion(self) -> float:
        """Depth of the energy minimum, w, in E* a0."""

    def evaluate(self, gap: Real) -> Response:
        """Energy, traction and stiffness per area at each gap."""


@dataclass(frozen=True)
class LennardJonesSpline:
    """The paper's law, Eq. (potential): repulsive 9-3 core, cubic-spline attraction of finite range.

    With z the gap, x = z - a0, k the stiffness at the minimum and r the range::

        p(z) = (k/a0²) a0/6 [(a0/z)^10 - (a0/z)^4]        z <= a0
             = -(k/a0²) x (1 - x/r)²                      a0 < z < a0 + r
             = 0                                          z >= a0 + r

    Work of adhesion w = k r²/(12 a0²): with the paper's k = E* a0/2, w = E* r²/(24 a0), largest tension
    (2/27) E* r/a0 at x = r/3, largest softening E*/(6 a0), whatever the range.  ``range = 0`` is the purely
    repulsive wall of the paper's nonadhesive runs.

    Parameters
    ----------
    range : Δr, distance from the minimum at a0 to the cut-off, in a0; 0 for no adhesion.
    minimum_stiffness : k/a0², stiffness per area at the minimum, in E*/a0 (the paper's is 1/2).
    core : gap below which the traction continues linearly, in a0.
    """

    range: float
    minimum_stiffness: float = 0.5
    core: float = 0.7

    def __post_init__(self) -> None:
        """Refuse what has no meaning."""
        if not (np.isfinite(self.range) and self.range >= 0):
            msg = f"the range of a wall is a finite number, zero or positive, got {self.range}"
            raise ValueError(msg)
        if not 0 < self.core < 1:
            msg = f"the core of a 9-3 wall lies between 0 and a0, got {self.core}"
            raise ValueError(msg)

    @classmethod
    def from_adhesion_length(cls, adhesion_length: float) -> LennardJonesSpline:
        """The paper's family: k = E* a0/2 and l_a = w/E* = Δr²/(24 a0)."""
        return cls(range=float(np.sqrt(24 * adhesion_length)))

    @property
    def zero_gap(self) -> float:
        """The minimum of the energy, a0."""
        return 1.0

    @property
    def work_of_adhesion(self) -> float:
        """Depth w = k Δr²/(12 a0²), in E* a0; equal to l_a in reduced units."""
        return self.minimum_stiffness * self.range**2 / 12

    @property
    def largest_tension(self) -> float:
        """(4/27) k Δr/a0², in E*, reached at a0 + Δr/3."""
        return 4 / 27 * self.minimum_stiffness * self.range

    def evaluate(self, gap: Real) -> Response:
        """Energy, traction and stiffness per area at each gap, Eq. (potential)."""
        k, r = self.minimum_stiffness, self.range
        x = np.asarray(gap, dtype=np.float64) - 1.0

        # Repulsive side, with the traction continued linearly below the core.
        z = 1.0 + np.clip(x, self.core - 1.0, 0.0)
        inv3 = 1 / (z * z * z)
        below = np.minimum(x + 1.0 - self.core, 0.0)
        core_stiffness = k / 6 * (10 * inv3**3 / z**2 - 4 * inv3 / z**2)
        core_traction = k / 6 * (inv3**3 / z - inv3 / z)
        # z^-9/9 - z^-3/3 + 2/9, factored: near the minimum the terms cancel to second order.
        energy = k / 54 * (inv3 - 1) ** 2 * (inv3 + 2) - self.work_of_adhesion
        energy += below * (0.5 * below * core_stiffness - core_traction)
        traction = core_traction - below * core_stiffness
        stiffness = core_stiffness

        outside = x > 0
        if r == 0:
            return Response(energy, traction, np.where(outside, 0.0, stiffness))
        t = np.clip(x / r, 0.0, 1.0)
        energy += k * r**2 * t**2 * (0.5 + t * (-2 / 3 + t / 4))
        traction -= k * r * t * (1 - t) ** 2
        return Response(energy, traction, np.where(outside, k * (1 - t) * (1 - 3 * t), stiffness))


@dataclass(frozen=True, eq=False)
class Tabulated:
    """A law given as a table of traction against gap: a cubic spline through the knots.

    The energy is the spline's integral, zero at the last knot, so that energy, traction and stiffness belong
    to one another exactly.  Below the first knot the traction continues linearly, beyond the last it is zero.

    Parameters
    ----------
    gap : increasing knots, in a0, at least four.
    traction : traction at each knot, in E*, compression positive; zero at the last knot.

    Raises
    ------
    ValueError
        If the table is not increasing, not finite, not repulsive at its first knot or not zero at its last.
    """

    gap: Real
    traction: Real

    def __post_init__(self) -> None:
        """Refuse tables that are no wall."""
        gap, traction = (np.array(a, dtype=np.float64) for a in (self.gap, self.traction))
        if gap.ndim != 1 or gap.shape != traction.shape or gap.size < 4:
            msg = f"a wall table is two columns of at least 4 rows, got {gap.shape} and {traction.shape}"
            raise ValueError(msg)
        if not (np.isfinite(gap).all() and np.isfinite(traction).all()):
            msg = "a wall table holds finite numbers only"
            raise ValueError(msg)
        if not (np.diff(gap) > 0).all():
            msg = "the gaps of a wall table increase from row to row"
            raise ValueError(msg)
        if not (traction[0] > 0 and abs(traction[-1]) <= 1e-12 * np.abs(traction).max()):
            msg = "a wall table starts repulsive (traction > 0) and ends where the traction has vanished"
            raise ValueError(msg)
        for name, values in (("gap", gap), ("traction", traction)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @cached_property
    def _splines(self) -> tuple[PPoly, PPoly, PPoly]:
        traction = CubicSpline(self.gap, self.traction)
        return traction.antiderivative(), traction, traction.derivative()

    @cached_property
    def zero_gap(self) -> float:
        """First gap at which the traction vanishes: the sign change, or where a repulsive law ends."""
        roots = self._splines[1].roots(extrapolate=False)
        return float(min(roots[np.isfinite(roots)], default=self.gap[-1]))

    @property
    def range(self) -> float:
        """From ``zero_gap`` to the last knot, in a0."""
        return float(self.gap[-1]) - self.zero_gap

    @property
    def core(self) -> float:
        """The first knot, in a0."""
        return float(self.gap[0])

    @cached_property
    def work_of_adhesion(self) -> float:
        """-energy at ``zero_gap``, in E* a0."""
        return -float(self.evaluate(np.array([self.zero_gap])).energy[0])

    def evaluate(self, gap: Real) -> Response:
        """Energy, traction and stiffness per area at each gap."""
        integral, p, slope = self._splines
        gap = np.asarray(gap, dtype=np.float64)
        z = np.clip(gap, self.gap[0], self.gap[-1])
        below = np.minimum(gap - self.gap[0], 0.0)
        inside = gap < self.gap[-1]
        traction, stiffness = p(z) * inside, -slope(z) * inside
        energy = float(integral(self.gap[-1])) - integral(z)
        energy += below * (0.5 * below * stiffness - traction)
        return Response(energy, traction - below * stiffness, stiffness)
