"""The isotropic half-space."""

from dataclasses import dataclass
from typing import Literal

from continuum.arguments import instance
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicTable, Substrate, check_mean, with_mean


@dataclass(frozen=True)
class HalfSpace:
    """Isotropic half-space: ``K_q = E* |q|/2`` (Johnson, Contact Mechanics, 1985, section 13.1).

    E* is the unit of all tractions of wall and substrate.

    Parameters
    ----------
    mean : the mean mode; see :data:`MeanMode`.  "clamped" is the paper's: an incompressible substrate on a rigid base.
    """

    mean: MeanMode = "clamped"

    def __post_init__(self) -> None:
        check_mean(self.mean)

    def stiffness(self, grid: Grid) -> Real:
        return with_mean(instance("grid", grid, Grid).wavenumber / 2, self.mean)


class HalfSpaceTable(PeriodicTable):
    """[substrate] of response "half-space"."""

    response: Literal["half-space"]

    def build(self) -> Substrate:
        return HalfSpace(**self.keywords())
