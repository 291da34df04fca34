"""Response of isotropic layers bonded to one another and to an isotropic half-space.

With s = q z upwards, compliances C = q u/t of the plane through the wavevector obey, in a material of contact modulus E
and Poisson's ratio ν, with a = C_xx, b = C_zz, c = C_xz (displacement i u_x, traction i t_x)::

    a' = 2c + 2/((1-ν) E) - E a²
    b' = -2ν/(1-ν) c + (1-2ν)/((1-ν)² E) - E c²
    c' = b - ν/(1-ν) a - E a c

Of the minors y = w (1, a, b, c, ab - c²) of displacements and tractions this is a linear equation, y' = G y (delta
matrices: Dunkin, Bull. Seismol. Soc. Am. 55, 335 (1965)).  G has the eigenvalues ±2 and 0, three times, so that with
x = q h::

    exp(G x) = 1 + x G + x²/2 G² + (sinh 2x - 2x)/8 G³ + (cosh 2x - 1 - 2x²)/16 G⁴

No digits are lost, however thin, thick, stiff or incompressible a layer is, where matrices of stiffness (as those of
the crystal) lose them as 1/(q h): the largest eigenvalue is a single one, and the small terms stand apart.
"""

from collections.abc import Sequence
from math import factorial
from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real

OPAQUE = 40.0
"""q times depth beyond which deeper layers are neglected: they contribute exp(-80)."""


class Solid(NamedTuple):
    """An isotropic solid."""

    contact_modulus: float
    """E/(1-ν²), in E*."""
    poisson: float
    """ν, up to and including 1/2."""


def layered_stiffness(layers: Sequence[tuple[float, Solid]], base: Solid, wavenumber: Real) -> Real:
    """K_q of layers on a half-space, in E*/a0: zero at q = 0.

    Parameters
    ----------
    layers : thickness, in a0, and material of each, from the surface down.
    base : material of the half-space.
    wavenumber : q, in 1/a0, any shape; each of its values is computed once.
    """
    q, inverse = np.unique(wavenumber, return_inverse=True)
    modulus, c = base.contact_modulus, (1 - 2 * base.poisson) / (1 - base.poisson)
    # Of the half-space a = b = 2/E, c = (1-2ν)/((1-ν) E).
    half_space = np.array([1.0, 2 / modulus, 2 / modulus, c / modulus, (4 - c**2) / modulus**2])
    minors = np.repeat(half_space[:, None], q.size, axis=1)
    above = np.cumsum([0.0, *(thickness for thickness, _ in layers)])
    for (thickness, solid), top in reversed(list(zip(layers, above[:-1], strict=True))):
        # Waves that have died out above a layer do not feel it: their minors stay as they are.
        felt = slice(np.searchsorted(q * top, OPAQUE))
        minors[:, felt] = _raised(minors[:, felt], solid, np.minimum(q[felt] * thickness, OPAQUE))
    stiffness: Real = (q * minors[0] / minors[2])[inverse].reshape(wavenumber.shape)
    return stiffness


def _raised(minors: Real, solid: Solid, x: Real) -> Real:
    """Minors at the upper face of a layer from those at its lower face, shape (5, n), scaled by the first of them."""
    modulus, nu = solid
    r, pressed, sheared = nu / (1 - nu), (1 - 2 * nu) / (1 - nu) ** 2 / modulus, 2 / (1 - nu) / modulus
    decay = np.exp(-2 * x)
    powers = x * decay, x**2 / 2 * decay, decayed_remainder(2 * x, 3) / 8, decayed_remainder(2 * x, 4) / 16
    above, change = minors * decay, minors
    for power in powers:
        w, a, b, c, d = change
        change = np.stack(
            [
                modulus * a,
                sheared * w + 2 * c,
                pressed * w - 2 * r * c + modulus * d,
                b - r * a,
                pressed * a + sheared * b,
            ]
        )
        above += power * change
    raised: Real = above / above[0]
    return raised


def decayed_remainder(y: Real, order: int) -> Real:
    """exp(-y) times sinh y - y (order 3) or cosh y - 1 - y²/2 (order 4), to rounding.

    By the series y^n/n! + y^(n+2)/(n+2)! + ... where the difference would lose digits.
    """
    small = np.minimum(y, 1.0) ** 2
    series = np.ones_like(y)
    for k in range(10, 0, -1):  # the first term left out, n!/(n+22)!, is below rounding at y = 1
        series = 1 + series * small / ((2 * k + order - 1) * (2 * k + order))
    series *= np.exp(-y) * np.minimum(y, 1.0) ** order / factorial(order)
    sign, left_out = (-1, y) if order == 3 else (1, 1 + y**2 / 2)
    direct = (1 + sign * np.exp(-2 * y)) / 2 - left_out * np.exp(-y)
    return np.where(y < 1, series, direct)
