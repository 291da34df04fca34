"""The cubic crystal, a half-space or a layer on a rigid base."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from continuum.arguments import ArgumentError, instance, number
from continuum.model.cubic import (
    THICK,
    CubicConstants,
    contact_modulus,
    directional_contact_modulus,
    surface_stiffness,
)
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicTable, Substrate, check_mean, with_mean
from continuum.tables import Fault, Positive, constraint

OTHER_MEAN = 1.5
"""Largest factor between E* and 1: different means over directions differ by less (fcc metals: 1.2)."""


@dataclass(frozen=True)
class CubicLayer:
    """Cubic crystal with a (100) surface, a half-space or a layer bonded to a rigid base.

    Parameters
    ----------
    depth : thickness of the layer, in a0; infinite for a half-space.
    constants : (C11, C12, C44), in E*: the unit is the mean contact modulus of the crystal.
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
        check_mean(self.mean)
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

        Costs about 50 µs for each mode whose wavelength exceeds a sixth of the depth; other modes are those of a
        half-space.
        """
        qx, qy = np.broadcast_arrays(*instance("grid", grid, Grid).wavevectors)
        q = grid.wavenumber
        angle = np.arctan2(qy, qx) + self.axis
        stiffness_q = q * directional_contact_modulus(self.constants, angle) / 2
        long_wave = q < THICK / self.depth
        long_wave[0, 0] = False  # its value follows below
        layer = surface_stiffness(self.constants, angle[long_wave], q[long_wave] * self.depth)
        stiffness_q[long_wave] = q[long_wave] * layer
        return with_mean(stiffness_q, self.mean)


class CrystalTable(PeriodicTable):
    """[substrate] of response "crystal": cubic, (100) surface, the grid's axes along <110>."""

    response: Literal["crystal"]
    c11: Positive
    """elastic constant, in E*"""
    c12: float
    """elastic constant, in E*"""
    c44: Positive
    """elastic constant, in E*"""
    depth: Positive | None = None
    """thickness of a layer bonded to a rigid base, in a0; a half-space if not given"""

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
