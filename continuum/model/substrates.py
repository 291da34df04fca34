"""Elastic response of the substrate: the stiffness K_q of its surface at each wavevector.

``K_q = 1/G_zz(q)``: vertical traction per vertical displacement when lateral tractions vanish.  It is not the
zz entry of the 3 x 3 stiffness matrix, which holds the lateral displacements at zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np
from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from continuum.arguments import ArgumentError, array, instance, number, pair
from continuum.model.cubic import (
    THICK,
    CubicConstants,
    contact_modulus,
    directional_contact_modulus,
    surface_stiffness,
)
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.tables import Fault, Positive, TableFamily, constraint

OTHER_MEAN = 1.5
"""By this factor at most E*, as a mean over directions, depends on which mean is taken (fcc metals: 1.2)."""

MeanMode = float | Literal["clamped", "free"]
"""Stiffness of the mean displacement: a number in E*/a0, "clamped" (infinite) or "free" (zero)."""


class Substrate(Protocol):
    """What every substrate offers."""

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum of the grid, in E*/a0; infinite at q = 0 where the mean is clamped."""


def _with_mean(stiffness_q: Real, mean: MeanMode) -> Real:
    """Set the stiffness of the mean mode, the one place where the three choices are turned into a number."""
    if mean == "clamped":
        stiffness_q[0, 0] = np.inf
    elif mean == "free":
        stiffness_q[0, 0] = 0.0
    else:
        stiffness_q[0, 0] = mean
    return stiffness_q


def _check_mean(mean: object) -> None:
    if isinstance(mean, str) and mean in ("clamped", "free"):
        return
    try:
        number("mean", mean, least=0)
    except ArgumentError:
        raise ArgumentError("mean", mean, '"clamped", "free", or a number >= 0') from None


def _mean_mode(value: Any) -> Any:
    try:
        _check_mean(value)
    except ArgumentError as error:
        raise PydanticCustomError("mean_mode", "{allowed}", {"allowed": error.allowed}) from None
    return value if isinstance(value, str) else float(value)


_MeanMode = Annotated[MeanMode, BeforeValidator(_mean_mode)]


class SubstrateTable(TableFamily):
    """[substrate]: elastic response."""

    kind_key: ClassVar[str] = "response"

    response: str
    mean: _MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def build(self) -> Substrate:
        """The response."""
        raise NotImplementedError


@dataclass(frozen=True)
class HalfSpace:
    """Isotropic half-space: ``K_q = E* |q|/2`` (Johnson, Contact Mechanics, 1985, section 13.1).

    E* is the unit of pressure, here as everywhere: all tractions of wall and substrate are multiples of it.

    Parameters
    ----------
    mean : the mean mode; see :data:`MeanMode`.  "clamped" is the paper's: an incompressible substrate on a rigid base.
    """

    mean: MeanMode = "clamped"

    def __post_init__(self) -> None:
        _check_mean(self.mean)

    def stiffness(self, grid: Grid) -> Real:
        return _with_mean(instance("grid", grid, Grid).wavenumber / 2, self.mean)


class HalfSpaceTable(SubstrateTable):
    """[substrate] of response "half-space"."""

    response: Literal["half-space"]

    def build(self) -> Substrate:
        return HalfSpace(**self.keywords())


@dataclass(frozen=True)
class Layer:
    """Isotropic layer bonded to a rigid base, any Poisson ratio up to and including 1/2.

    With x = q depth, from plane-strain elasticity with u = 0 at the base and no lateral traction on top (the
    tests integrate that boundary-value problem numerically)::

        K_q = E* q/2  [(3 - 4ν) cosh 2x + 2x² + 5 - 12ν + 8ν²] / [(3 - 4ν) sinh 2x - 2x]

    computed with sinh 2x - 2x by its series where x is small, since there an incompressible layer is that difference
    alone (K_q = E* 3/(4 q² depth³) to leading order): to 1e-12 at any depth and Poisson ratio.

    Parameters
    ----------
    depth : thickness of the layer, in a0.
    poisson : ν.
    mean : the mean mode; :attr:`compressive_stiffness` is that of the layer itself.
    """

    depth: float
    poisson: float
    mean: MeanMode

    def __post_init__(self) -> None:
        number("depth", self.depth, above=0)
        number("poisson", self.poisson, above=-1, most=0.5)
        _check_mean(self.mean)

    @property
    def compressive_stiffness(self) -> float:
        """Pressure per mean displacement, (1-ν)² E*/((1-2ν) depth), in E*/a0; infinite at ν = 1/2."""
        if self.poisson == 0.5:
            return float("inf")
        nu = self.poisson
        return (1 - nu) ** 2 / ((1 - 2 * nu) * self.depth)

    def stiffness(self, grid: Grid) -> Real:
        nu, q = self.poisson, instance("grid", grid, Grid).wavenumber
        q[0, 0] = 1.0  # its value is set below
        x = q * self.depth
        # Multiplied through by exp(-2x), so that no hyperbolic function overflows.
        decay = np.exp(-2 * x)
        a = 3 - 4 * nu
        above = a * (1 + decay**2) / 2 + decay * (2 * x**2 + 5 - 12 * nu + 8 * nu**2)
        # All terms positive: none cancels another.
        below = a * _decayed_sinh_less(2 * x) + 4 * (1 - 2 * nu) * x * decay
        return _with_mean(q / 2 * above / below, self.mean)


class LayerTable(SubstrateTable):
    """[substrate] of response "layer", bonded to a rigid base."""

    response: Literal["layer"]
    depth: Positive
    """thickness, in a0"""
    poisson: Annotated[float, Field(gt=-1, le=0.5)]
    """Poisson's ratio"""

    def build(self) -> Substrate:
        return Layer(**self.keywords())


def _decayed_sinh_less(y: Real) -> Real:
    """exp(-y) (sinh y - y), to rounding: by the series y³/6 + y⁵/120 + ... where the difference would lose digits."""
    small = np.minimum(y, 1.0) ** 2
    series = np.ones_like(y)
    for k in range(10, 0, -1):  # the first term left out, 1/(23!/3!), is below rounding at y = 1
        series = 1 + series * small / ((2 * k + 2) * (2 * k + 3))
    direct = -np.expm1(-2 * y) / 2 - y * np.exp(-y)
    return np.where(y < 1, np.exp(-y) * np.minimum(y, 1.0) ** 3 / 6 * series, direct)


@dataclass(frozen=True)
class CubicLayer:
    """Cubic crystal with a (100) surface, a half-space or a layer bonded to a rigid base.

    Parameters
    ----------
    depth : thickness of the layer, in a0; infinite for a half-space.
    constants : (C11, C12, C44), in E*: the contact modulus of the crystal, in some mean over directions, is the unit.
    mean : the mean mode; :attr:`compressive_stiffness` is that of the layer itself.
    axis : angle of the grid's x axis to the cubic axis <100>, in radians; π/4 for the square of surface atoms,
        whose sides are <110>.
    """

    depth: float
    constants: CubicConstants
    mean: MeanMode
    axis: float = np.pi / 4

    def __post_init__(self) -> None:
        if not (isinstance(self.depth, float) and np.isposinf(self.depth)):  # a half-space
            number("depth", self.depth, above=0)
        _check_mean(self.mean)
        number("axis", self.axis)
        given = self.constants
        if isinstance(given, str) or not isinstance(given, Sequence | np.ndarray) or np.shape(given)[:1] != (3,):
            raise ArgumentError("constants", given, "three elastic constants, (C11, C12, C44), in E*")
        constants = CubicConstants(*(number("constants", constant) for constant in given))
        modulus = contact_modulus(constants)
        if not 1 / OTHER_MEAN <= modulus <= OTHER_MEAN:
            what = f"elastic constants in E*, of a contact modulus of about 1; of these it is {modulus:.6g}"
            raise ArgumentError("constants", tuple(constants), f"{what}: divide them, and all tractions, by that")
        object.__setattr__(self, "constants", constants)

    @property
    def compressive_stiffness(self) -> float:
        """Pressure per mean displacement, C11/depth, in E*/a0."""
        return self.constants.c11 / self.depth

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0.

        Costs about 50 µs for each mode whose wavelength exceeds a sixth of the depth; all others are those of a
        half-space.
        """
        qx, qy = np.broadcast_arrays(*instance("grid", grid, Grid).wavevectors)
        q = grid.wavenumber
        angle = np.arctan2(qy, qx) + self.axis
        stiffness_q = q * directional_contact_modulus(self.constants, angle) / 2
        long_wave = q < THICK / self.depth
        long_wave[0, 0] = False  # its value is set below
        layer = surface_stiffness(self.constants, angle[long_wave], q[long_wave] * self.depth)
        stiffness_q[long_wave] = q[long_wave] * layer
        return _with_mean(stiffness_q, self.mean)


class CrystalTable(SubstrateTable):
    """[substrate] of response "crystal": cubic, (100) surface, the grid's axes along <110>."""

    response: Literal["crystal"]
    c11: Positive
    """elastic constant, in E*"""
    c12: float
    """elastic constant, in E*"""
    c44: Positive
    """elastic constant, in E*"""
    depth: Positive | None = None
    """of a layer bonded to a rigid base, in a0; a half-space if not given"""

    @constraint
    def _stable(self) -> Iterator[Fault]:
        if not (self.c11 > abs(self.c12) and self.c11 + 2 * self.c12 > 0):
            yield Fault(("c12",), "C11 > |C12| and C11 + 2 C12 > 0, or the crystal is not stable")
            return
        modulus = contact_modulus(CubicConstants(self.c11, self.c12, self.c44))
        if not 1 / OTHER_MEAN <= modulus <= OTHER_MEAN:
            cause = f"constants in another unit than E*: divide all three by {modulus:.6g}"
            yield Fault(("c11",), f"constants of a contact modulus of about 1, not {modulus:.6g}", cause)

    def build(self) -> Substrate:
        return CubicLayer(self.depth or np.inf, CubicConstants(self.c11, self.c12, self.c44), self.mean)


@dataclass(frozen=True, eq=False)
class TabulatedSubstrate:
    """A response measured elsewhere, on one grid: K_q over its half spectrum, q = 0 included.

    Parameters
    ----------
    table : K_q, shape ``grid.shape_q``, in E*/a0; positive, except that q = 0 may be zero or infinite.
    lengths : periods of the grid it belongs to, in a0.
    source : where it comes from, in words; stored with results.
    """

    table: Real = field(repr=False)
    lengths: tuple[float, float]
    source: str

    def __post_init__(self) -> None:
        what = "a half spectrum of positive finite numbers (q = 0: zero or more, or infinite)"
        table = np.array(array("table", self.table), dtype=np.float64)
        others = table.ravel()[1:]
        if (
            table.ndim != 2
            or not table.size
            or not (np.isfinite(others).all() and (others > 0).all() and table[0, 0] >= 0)
        ):
            raise ArgumentError("table", table, what)
        lengths = tuple(number("lengths", length, above=0) for length in pair("lengths", self.lengths))
        instance("source", self.source, str, "a text that says where the table comes from")
        table.flags.writeable = False
        object.__setattr__(self, "table", table)
        object.__setattr__(self, "lengths", lengths)

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0; refused on a grid that it was not made for."""
        instance("grid", grid, Grid)
        if grid.shape_q != self.table.shape or not np.allclose(grid.lengths, self.lengths, rtol=1e-12):
            msg = (
                f"grid: {grid.shape_q} modes of periods {grid.lengths}, where the table of stiffness has "
                f"{self.table.shape} and {self.lengths}"
            )
            raise ValueError(msg)
        return np.array(self.table)
