"""Isotropic solids: the half-space, a layer on a rigid base, and layers bonded to one another and to a half-space.

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

from collections.abc import Iterator, Mapping, Sequence
from math import factorial
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from continuum.inputs.arguments import instance
from continuum.inputs.keys import Positive
from continuum.inputs.tables import Description, Fault, constraint
from continuum.model.fourier import Real
from continuum.model.grid import LONGEST, Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicResponse, Poisson, with_mean

OPAQUE = 40.0
"""q times depth beyond which deeper layers are neglected: they contribute exp(-80)."""
CONTRAST = 1e12
"""Largest ratio of a modulus to E*, or its inverse: beyond it one material is rigid compared with another."""
MOST_LAYERS = 1000
Modulus = Annotated[float, Field(ge=1 / CONTRAST, le=CONTRAST)]
"""A contact modulus, in E*."""


class HalfSpace(PeriodicResponse, kind="half-space"):
    """Isotropic half-space: ``K_q = E* |q|/2`` (Johnson, Contact Mechanics, 1985, section 13.1).

    E* is the unit of all tractions of wall and substrate.  The mean "clamped" is the paper's: an incompressible
    substrate on a rigid base.

    Examples
    --------
    >>> import continuum as c
    >>> round(float(c.HalfSpace().stiffness(c.Grid.square(8))[0, 1]), 4)  # |q|/2 with q = 2π/8
    0.3927
    """

    example: ClassVar[Mapping[str, Any]] = {"mean": "clamped"}

    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def __init__(self, mean: MeanMode = "clamped") -> None:
        self._take(mean=mean)

    def stiffness(self, grid: Grid) -> Real:
        return with_mean(grid, instance("grid", grid, Grid).wavenumber / 2, self.mean)


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


class Layer(PeriodicResponse, kind="layer"):
    """Isotropic layer bonded to a rigid base, any Poisson ratio up to and including 1/2.

    With x = q depth, from plane-strain elasticity with u = 0 at the base and no lateral traction on top (the
    tests integrate that boundary-value problem numerically)::

        K_q = E* q/2  [(3 - 4ν) cosh 2x + 2x² + 5 - 12ν + 8ν²] / [(3 - 4ν) sinh 2x - 2x]

    computed with sinh 2x - 2x by its series where x is small, since there an incompressible layer is that difference
    alone (K_q = E* 3/(4 q² depth³) to leading order): to 1e-12 at any depth and Poisson ratio.
    :attr:`compressive_stiffness` is the mean mode of the layer itself.

    Examples
    --------
    >>> import continuum as c
    >>> grid = c.Grid.square(8)
    >>> thin, thick = (c.Layer(depth, 0.3, "clamped").stiffness(grid)[0, 1] for depth in (1, 100))
    >>> round(float(thin), 4), round(float(thick), 4)  # the last is |q|/2, that of a half-space
    (1.2019, 0.3927)
    """

    example: ClassVar[Mapping[str, Any]] = {"depth": 5.0, "poisson": 0.3, "mean": "clamped"}

    depth: Positive
    """thickness, in a0"""
    poisson: Poisson
    """Poisson's ratio"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    @property
    def compressive_stiffness(self) -> float:
        """Pressure per mean displacement, (1-ν)² E*/((1-2ν) depth), in E*/a0; infinite at ν = 1/2."""
        if self.poisson == 0.5:
            return float("inf")
        nu = self.poisson
        return (1 - nu) ** 2 / ((1 - 2 * nu) * self.depth)

    def stiffness(self, grid: Grid) -> Real:
        nu, q = self.poisson, instance("grid", grid, Grid).wavenumber
        grid.mean_mode(q)[...] = 1.0  # its value is set below
        x = q * self.depth
        # Multiplied through by exp(-2x), so that no hyperbolic function overflows.
        decay = np.exp(-2 * x)
        a = 3 - 4 * nu
        above = a * (1 + decay**2) / 2 + decay * (2 * x**2 + 5 - 12 * nu + 8 * nu**2)
        # All terms positive: none cancels another.
        below = a * decayed_remainder(2 * x, 3) + 4 * (1 - 2 * nu) * x * decay
        return with_mean(grid, q / 2 * above / below, self.mean)


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


def _other_unit(moduli: Sequence[float]) -> str:
    """Allowed moduli, if the unit of pressure is not among those given."""
    least, most = min(moduli), max(moduli)
    if least <= 1 <= most:
        return ""
    return f"contact moduli in E*: one is 1, or some are above and some below, not all from {least:g} to {most:g}"


class Base(Description):
    """[substrate.base]: the half-space below."""

    contact_modulus: Modulus
    """E/(1-ν²), in E*"""
    poisson: Poisson
    """Poisson's ratio"""


class Film(Description):
    """One of the layers of [substrate]."""

    thickness: Annotated[float, Field(gt=0, le=LONGEST)]
    """in a0"""
    contact_modulus: Modulus
    """E/(1-ν²), in E*"""
    poisson: Poisson
    """Poisson's ratio"""


class LayeredHalfSpace(PeriodicResponse, kind="layered-half-space"):
    """Isotropic layers, bonded to one another and to an isotropic half-space; a graded solid is many layers.

    E*, the unit of pressure, is one of the contact moduli E/(1-ν²), or between them.  It is best that of the top
    layer, on which short waves depend: areas, κ and warnings then have the same meaning as on a half-space, and layers
    on a stiff base agree with :class:`Layer`.  K_q is accurate to 1e-13 for any thickness and Poisson's ratio
    (:func:`layered_stiffness`).

    In Python layers are tuples (thickness in a0, contact modulus in E*, Poisson's ratio), and so is the base (contact
    modulus in E*, Poisson's ratio).

    Examples
    --------
    >>> import continuum as c
    >>> film = (2.0, 10.0, 0.3)  # 2 a0 thick, ten times as stiff as the base
    >>> stiffness = c.LayeredHalfSpace([film], base=(1.0, 0.5)).stiffness(c.Grid.square(64))
    >>> plain = c.HalfSpace().stiffness(c.Grid.square(64))
    >>> [round(float(stiffness[0, n] / plain[0, n]), 2) for n in (1, 32)]  # long waves, short waves
    [1.01, 9.99]
    """

    example: ClassVar[Mapping[str, Any]] = {
        "layers": ({"thickness": 2.0, "contact_modulus": 1.0, "poisson": 0.3},),
        "base": {"contact_modulus": 0.4, "poisson": 0.5},
        "mean": "clamped",
    }

    layers: Annotated[tuple[Film, ...], Field(max_length=MOST_LAYERS)]
    """from the surface down: {thickness, contact_modulus, poisson} of each, in a0 and E*"""
    base: Base
    """half-space below: {contact_modulus, poisson}, in E*"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def __init__(
        self,
        layers: Sequence[tuple[float, float, float] | Film],
        base: tuple[float, float] | Base,
        mean: MeanMode = "clamped",
    ) -> None:
        self._take(layers=layers, base=base, mean=mean)

    @constraint
    def _unit(self) -> Iterator[Fault]:
        if not self.layers:
            yield Fault(("layers",), "at least one layer", 'response = "half-space" has none')
            return
        moduli = [film.contact_modulus for film in self.layers]
        if other := _other_unit([*moduli, self.base.contact_modulus]):
            yield Fault(("layers",), other, "moduli in another unit: divide them by that of the top layer")

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0; 0.1 µs for each layer and different length of a wavevector."""
        layers = [(film.thickness, Solid(film.contact_modulus, film.poisson)) for film in self.layers]
        base = Solid(self.base.contact_modulus, self.base.poisson)
        q = instance("grid", grid, Grid).wavenumber
        return with_mean(grid, layered_stiffness(layers, base, q), self.mean)
