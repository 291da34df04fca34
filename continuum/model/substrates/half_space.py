"""The isotropic half-space."""

from collections.abc import Mapping
from typing import Any, ClassVar

from continuum.inputs.arguments import instance
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicResponse, with_mean


class HalfSpace(PeriodicResponse, kind="half-space"):
    """Isotropic half-space: ``K_q = E* |q|/2`` (Johnson, Contact Mechanics, 1985, section 13.1).

    E* is the unit of all tractions of wall and substrate.  The mean "clamped" is the paper's: an incompressible
    substrate on a rigid base.
    """

    example: ClassVar[Mapping[str, Any]] = {"mean": "clamped"}

    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def __init__(self, mean: MeanMode = "clamped") -> None:
        self._take(mean=mean)

    def stiffness(self, grid: Grid) -> Real:
        return with_mean(grid, instance("grid", grid, Grid).wavenumber / 2, self.mean)
