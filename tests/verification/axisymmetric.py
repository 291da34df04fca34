"""A sphere under any wall law on an infinite half-space, by annuli of constant traction: no grid, no period.

The surface under a disc of radius b that carries a pressure p sinks by (4 p b/(π E*)) E(m), m = r²/b², inside and by
(4 p r/(π E*)) [E(m) - (1 - m) K(m)], m = b²/r², outside (Johnson, Contact Mechanics, 1985, section 3.4); an annulus is
the difference of two discs.  Equilibrium is z = D + r²/(2R) + C p(z) at the middle of each annulus, by Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ellipe, ellipk

from continuum.model.fourier import Real
from continuum.model.walls import Wall

__all__ = ["AxisymmetricSphere"]


def _sunk(r: Real, disc: Real) -> Real:
    """Displacement at r, shape (n, 1), under unit pressure on discs of given radii, shape (1, m); E* = 1."""
    inside = r < disc
    m = np.where(inside, (r / np.where(inside, disc, 1.0)) ** 2, (disc / np.where(inside, 1.0, r)) ** 2)
    far = r * (ellipe(m) - (1 - m) * ellipk(np.where(inside, 0.0, m)))
    return np.asarray(4 / np.pi * np.where(inside, disc * ellipe(m), far))


@dataclass(frozen=True, eq=False)
class AxisymmetricSphere:
    """Annuli of equal width up to ``reach``, beyond which the law must have vanished."""

    radius: float
    wall: Wall
    reach: float
    annuli: int

    @cached_property
    def _edges(self) -> Real:
        return np.linspace(0, self.reach, self.annuli + 1)

    @cached_property
    def _middles(self) -> Real:
        return (self._edges[1:] + self._edges[:-1]) / 2

    @cached_property
    def _compliance(self) -> Real:
        discs = _sunk(self._middles[:, None], self._edges[None, 1:])
        return np.diff(discs, axis=1, prepend=0.0)

    def gap(self, indentation: float, near: tuple[Real, Real]) -> Real:
        """Gap at the middle of each annulus, to 1e-11.

        Parameters
        ----------
        indentation : δ.
        near : radii and gaps of a state that is close, where Newton's method starts.

        Raises
        ------
        RuntimeError
            If it does not get there.
        """
        rigid = self.wall.zero_gap - indentation + self._middles**2 / (2 * self.radius)

        def residual(z: Real) -> Real:
            missed: Real = rigid + self._compliance @ self.wall.evaluate(z).traction - z
            return missed

        z = np.interp(self._middles, *near)
        missed = residual(z)
        for _ in range(200):
            if np.abs(missed).max() < 1e-11:
                return z
            # d traction/d gap = - stiffness.
            stiffness = self.wall.evaluate(z).stiffness
            step = np.linalg.solve(np.eye(self.annuli) + self._compliance * stiffness, missed)
            part = 1.0
            while np.linalg.norm(residual(z + part * step)) > np.linalg.norm(missed) and part > 1e-3:
                part /= 2
            z += part * step
            missed = residual(z)
        msg = f"no equilibrium of annuli found at an indentation of {indentation}"
        raise RuntimeError(msg)

    def load(self, gap: Real) -> float:
        """N."""
        areas = np.pi * np.diff(self._edges**2)
        return float(np.sum(areas * self.wall.evaluate(gap).traction))
