"""A wall law given as a table of traction against gap."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike

from continuum.inputs.arguments import array
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.wall import Wall
from continuum.theory import paper


class TabulatedWall(Wall):
    """A law given as a table of traction against gap: a cubic spline through the knots.

    The energy is the integral of the spline, zero at the last knot, so that energy, traction and stiffness are
    consistent.  Below the first knot the traction continues linearly, beyond the last it is zero.

    A_att counts the points up to the last knot: end the table where the traction no longer matters.

    Raises ValueError unless gap and traction are such columns.  Two walls are equal only if they are one object.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> gap = np.linspace(0, 2, 201)
    >>> wall = c.TabulatedWall(gap, 0.1 * (1 - gap) * (2 - gap) ** 2)  # any traction, in E*
    >>> round(wall.work_of_adhesion, 4)
    0.0083
    """

    gap: Real
    """increasing knots, in a0, at least four"""
    traction: Real
    """traction at each knot, in E*, compression positive; zero at the last knot"""

    def __init__(self, gap: ArrayLike, traction: ArrayLike) -> None:
        given = {"gap": gap, "traction": traction}
        gap, traction = (np.array(array(name, value), np.float64) for name, value in given.items())
        if gap.ndim != 1 or gap.shape != traction.shape or gap.size < 4:
            msg = f"gap, traction: a wall table is two columns of at least 4 rows, not {gap.shape} and {traction.shape}"
            raise ValueError(msg)
        if not (np.isfinite(gap).all() and np.isfinite(traction).all()):
            raise ValueError("gap, traction: a wall table holds finite numbers only")
        if not (np.diff(gap) > 0).all():
            raise ValueError("gap: the gaps of a wall table increase from row to row")
        if not (traction[0] > 0 and abs(traction[-1]) <= 1e-12 * np.abs(traction).max()):
            msg = "traction: a wall table starts repulsive (traction > 0) and ends where the traction has vanished"
            raise ValueError(msg)
        gap.flags.writeable = traction.flags.writeable = False
        self._take(gap=gap, traction=traction)

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def knots(self) -> Mapping[str, Real]:
        return {"gap": self.gap, "traction": self.traction}

    @cached_property
    def _spline(self) -> scipy.interpolate.CubicSpline:
        return scipy.interpolate.CubicSpline(self.gap, self.traction)

    @cached_property
    def law(self) -> Law:
        integral = self._spline.antiderivative()
        energy = float(integral(self.gap[-1])) - integral(self.gap[:-1])
        parts = (np.array([self.gap.size - 1.0]), self.gap, energy, self._spline.c.T.ravel())
        return Law(laws.TABLE, np.concatenate(parts), float(self.gap[-1]))

    @cached_property
    def zero_gap(self) -> float:
        """First gap at which the traction vanishes: its change of sign, or the end of a repulsive law."""
        # A piece whose Bezier coefficients are all positive has no root, and none is sought beyond the first knot that
        # is not repulsive.  The pieces on both sides of what remains: a root may lie at a knot.
        h, (_, b, c, d) = np.diff(self.gap), self._spline.c
        bezier = np.array([d, d + c * h / 3, d + (2 * c + b * h) * h / 3, self.traction[1:]])
        first = max(int(np.argmax(bezier.min(axis=0) <= 0)) - 1, 0)
        last = int(np.argmax(self.traction <= 0)) or h.size
        piece = slice(first, last + 1)
        near = scipy.interpolate.PPoly(self._spline.c[:, piece], self.gap[first : last + 2])
        roots = near.roots(extrapolate=False)
        return float(min(roots[np.isfinite(roots)], default=self.gap[-1]))

    @cached_property
    def stationary_gaps(self) -> Real:
        """The knots, and where between them the traction of a piece, or its slope, is stationary.

        The slope ends at the last knot, with a jump: it is the one just before that counts.
        """
        roots = (self._spline.derivative(order).roots(extrapolate=False) for order in (1, 2))
        found: Real = np.concatenate([self.gap, *roots, [np.nextafter(self.gap[-1], -np.inf)]])
        return found[np.isfinite(found)]

    @property
    def range(self) -> float:
        """Distance from ``zero_gap`` to the last knot, in a0."""
        return float(self.gap[-1]) - self.zero_gap

    @cached_property
    def effective_range(self) -> float:
        """Effective range of the attraction, Eq. (S-5): both integrands are polynomials of Δ^(1/3) between knots."""
        ends = np.cbrt(np.append(self.zero_gap, self.gap[self.gap > self.zero_gap]) - self.zero_gap)[:, np.newaxis]
        nodes, weights = np.polynomial.legendre.leggauss(6)  # exact to the power of 11
        s = (ends[:-1] * (1 - nodes) + ends[1:] * (1 + nodes)) / 2
        pull = -self.evaluate(self.zero_gap + s**3).traction * weights * np.diff(ends, axis=0)
        weighted, work = np.sum(pull * s), np.sum(pull * s * s)
        return paper.range_of_integrals(weighted, work) if work > 0 else 0.0

    @property
    def core(self) -> float:
        """The first knot, in a0."""
        return float(self.gap[0])
