"""Contact modulus of the (100) surface of a cubic crystal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from continuum.grid import Real

__all__ = ["CubicConstants", "contact_modulus", "directional_contact_modulus"]


class CubicConstants(NamedTuple):
    """Elastic constants of a cubic crystal, referred to its cubic axes, all in one unit."""

    c11: float
    c12: float
    c44: float

    def stiffness_tensor(self) -> Real:
        """C_ijkl, shape (3, 3, 3, 3): isotropic part plus what the cubic axes add."""
        d = np.eye(3)
        c: Real = self.c12 * np.einsum("ij,kl->ijkl", d, d)
        c += self.c44 * (np.einsum("ik,jl->ijkl", d, d) + np.einsum("il,jk->ijkl", d, d))
        for i in range(3):
            c[i, i, i, i] += self.c11 - self.c12 - 2 * self.c44
        return c


# Integrands are smooth and periodic, so that equal weights converge exponentially: 128 points give all digits
# unless the crystal is close to an instability.
_POINTS = 128


def directional_contact_modulus(constants: CubicConstants, angle: float) -> float:
    """E*(θ) of the (100) surface for a wavevector in the surface at an angle to the cubic axis <100>.

    A vertical traction of wavevector q on a half-space without lateral traction displaces its surface
    vertically by 2/(E*(θ) q) times the traction.  With m along q and n normal to the surface this is the
    element [n, n] of the inverse of the Barnett-Lothe tensor L (Ting, Anisotropic Elasticity, 1996, sections
    7.1 - 7.4)::

        L = (1/π) ∫ [(mm) - (mn)(nn)^-1(nm)] dω from 0 to π,    1/E*(θ) = ½ (L^-1)_nn

    with m and n turned by ω in their plane inside the integral, and (ab)_jk = Σ_il a_i C_ijkl b_l.

    Parameters
    ----------
    constants : elastic constants; the result has their unit.
    angle : θ, in radians; 0 is <100>, π/4 is <110>, the axes of the surface grid.

    Raises
    ------
    ValueError
        If the crystal is not stable: C11 > |C12|, C11 + 2 C12 > 0 and C44 > 0 are required.
    """
    if not (constants.c44 > 0 and constants.c11 > abs(constants.c12) and constants.c11 + 2 * constants.c12 > 0):
        msg = f"a cubic crystal is stable if C11 > |C12|, C11 + 2 C12 > 0 and C44 > 0, got {constants}"
        raise ValueError(msg)
    c = constants.stiffness_tensor()
    along, up = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])
    turn = np.arange(_POINTS)[:, None] * np.pi / _POINTS
    m, n = np.cos(turn) * along + np.sin(turn) * up, np.cos(turn) * up - np.sin(turn) * along

    def contract(a: Real, b: Real) -> Real:
        contracted: Real = np.einsum("pi,ijkl,pl->pjk", a, c, b)
        return contracted

    mn = contract(m, n)
    minus_n3 = contract(m, m) - mn @ np.linalg.solve(contract(n, n), mn.transpose(0, 2, 1))
    compliance = np.linalg.inv(minus_n3.mean(axis=0))
    return float(2 / (up @ compliance @ up))


def contact_modulus(constants: CubicConstants) -> float:
    """Mean contact modulus of the (100) surface, 1/<1/E*(θ)> over all directions, in the unit of the
    constants.

    The mean of the compliance is the compliance of the axially symmetric part of the response.
    """
    # E*(θ) has the period π/2.
    angles = np.arange(_POINTS) * (np.pi / 2 / _POINTS)
    return float(1 / np.mean([1 / directional_contact_modulus(constants, angle) for angle in angles]))
