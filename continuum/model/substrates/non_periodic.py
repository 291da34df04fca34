"""The isotropic half-space without periodic images."""

from collections.abc import Mapping
from typing import Any, ClassVar

from continuum.inputs.arguments import ArgumentError, instance
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.open_boundary import OpenBoundary
from continuum.model.substrates.substrate import Response, with_mean

NO_LINE = "a two-dimensional grid: under a line load the displacement of a half-space without images is infinite"


class NonPeriodicHalfSpace(Response, kind="non-periodic-half-space"):
    """Isotropic half-space without periodic images: tractions act on the grid only.

    For spheres, indenters and maps without mirror images.  Each point is a cell under uniform traction, whose
    displacements are those of Love's formula (:mod:`continuum.model.open_boundary`): a solve takes as long as one of
    a periodic surface of twice the points along x and y.  Far away the half-space is at rest, and separations are
    counted from there.  Mean pressure and areas are per area of the grid.  The mean gap cannot be prescribed, since
    the mean displacement of a window is not an independent mode.
    """

    example: ClassVar[Mapping[str, Any]] = {}
    repeats: ClassVar[bool] = False

    def stiffness(self, grid: Grid) -> Real:
        """K_q of a periodic surface, E* q/2, and at q = 0 uniform pressure over mean displacement.

        Used for estimates only; the solver uses :meth:`open_boundary`.
        """
        return with_mean(instance("grid", grid, Grid).wavenumber / 2, self.open_boundary(grid).mean_stiffness)

    def open_boundary(self, grid: Grid) -> OpenBoundary:
        """The response to tractions on the points of a grid."""
        if instance("grid", grid, Grid).is_line:
            raise ArgumentError("grid", grid, NO_LINE)
        return OpenBoundary(grid)

    def without(self, control: str) -> str:
        return "without periodic images the mean gap cannot be prescribed" if control == "mean-gap" else ""
