"""The cubic crystal, a half-space or a layer on a rigid base."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from continuum.inputs.arguments import ArgumentError, instance
from continuum.inputs.keys import OrInfinite, frozen
from continuum.inputs.tables import Fault, constraint
from continuum.model import anisotropic
from continuum.model.anisotropic import CubicConstants
from continuum.model.fourier import Real
from continuum.model.grid import LONGEST, Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicResponse, with_mean

OTHER_MEAN = 1.5
"""Largest factor between E* and 1: different means over directions differ by less (fcc metals: 1.2)."""


class CubicLayer(PeriodicResponse, kind="crystal"):
    """Cubic crystal with a (100) surface, a half-space or a layer bonded to a rigid base.

    In Python its constants, in E*, are one argument: ``CubicLayer(depth, (c11, c12, c44), mean)``.
    :attr:`compressive_stiffness` is the mean mode of the layer itself.
    """

    example: ClassVar[Mapping[str, Any]] = {"c11": 1.2, "c12": 0.6, "c44": 0.5, "depth": 4.0, "mean": 0.3}
    newer: ClassVar[frozenset[str]] = frozenset({"axis"})

    c11: Annotated[float, Field(gt=0, le=LONGEST)]
    """elastic constant, in E*"""
    c12: Annotated[float, Field(ge=-LONGEST, le=LONGEST)]
    """elastic constant, in E*"""
    c44: Annotated[float, Field(gt=0, le=LONGEST)]
    """elastic constant, in E*"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""
    depth: OrInfinite = np.inf
    """thickness of a layer bonded to a rigid base, in a0; a half-space if not given"""
    axis: float = np.pi / 4
    """angle of the x axis of the grid to the cubic axis <100>, in radians; by default the sides of the grid are <110>,
    those of the square of surface atoms"""

    def __init__(self, depth: float, constants: Sequence[float], mean: MeanMode, axis: float = np.pi / 4) -> None:
        values, names = frozen(constants), ("c11", "c12", "c44")
        if not isinstance(values, tuple) or len(values) != 3:
            raise ArgumentError("constants", constants, "three elastic constants, (C11, C12, C44), in E*")
        try:
            self._take(**dict(zip(names, values, strict=True)), depth=depth, mean=mean, axis=axis)
        except ArgumentError as error:
            if error.name in names:
                raise ArgumentError("constants", constants, f"{error.name}: {error.allowed}") from None
            raise

    @constraint
    def _stable(self) -> Iterator[Fault]:
        if not (self.c11 > abs(self.c12) and self.c11 + 2 * self.c12 > 0):
            yield Fault(("c12",), "C11 > |C12| and C11 + 2 C12 > 0, or the crystal is not stable")
            return
        try:
            modulus = anisotropic.contact_modulus(self.constants)
        except ValueError as error:
            yield Fault(("c44",), f"the ratio of constants that a crystal has: {error}")
            return
        if not 1 / OTHER_MEAN <= modulus <= OTHER_MEAN:
            allowed = f"constants of a contact modulus of about 1, in E*; of these it is {modulus:.6g}"
            yield Fault(("c11",), allowed, "divide them, and all tractions, by that")

    @property
    def constants(self) -> CubicConstants:
        """C11, C12 and C44, in E*."""
        return CubicConstants(self.c11, self.c12, self.c44)

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
        stiffness_q = q * anisotropic.directional_contact_modulus(self.constants, angle) / 2
        long_wave = q < anisotropic.THICK / self.depth
        grid.mean_mode(long_wave)[...] = False  # its value follows below
        layer = anisotropic.surface_stiffness(self.constants, angle[long_wave], q[long_wave] * self.depth)
        stiffness_q[long_wave] = q[long_wave] * layer
        return with_mean(grid, stiffness_q, self.mean)
