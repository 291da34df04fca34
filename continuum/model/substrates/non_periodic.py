"""The isotropic half-space without periodic images: the exact response to tractions in a window.

Each point of the grid is a cell under uniform traction.  The influence of one cell on another depends on their
distance only, so that the displacements of a window are a convolution, which is periodic on a grid of twice the points
along x and y (Hockney, Methods Comput. Phys. 9, 135 (1970); Liu, Wang and Liu, Wear 243, 101 (2000)).  Its spectrum
G_q is positive, so that 1/G_q is the stiffness of a periodic surface of twice the size that moves inside the window as
the half-space does if no traction acts outside.  The solvers need nothing else.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from continuum.inputs.arguments import ArgumentError, instance
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.substrate import Response, with_mean

FAR = 40.0
"""Distance, in longer sides of a cell, beyond which the influence is computed from moments: both errors are then about
1e-11, as the closed formula is a difference of large numbers."""


def cell_influence(x: Real, y: Real, spacing: tuple[float, float]) -> Real:
    """Displacement at (x, y) by a uniform traction of one E* on the rectangle about the origin, in a0.

    Love, Phil. Trans. R. Soc. A 228, 377 (1929); Johnson, Contact Mechanics (1985), Eq. (3.25).

    Parameters
    ----------
    x, y : distances, in a0, no corner of the rectangle.
    spacing : sides of the rectangle, in a0.
    """
    a, b = spacing[0] / 2, spacing[1] / 2
    # The moments diverge in the cell itself; there, as near it, the closed formula takes their place.
    r2 = np.maximum(x**2 + y**2, (a * b) / 4)
    # Moments of the cell up to the fourth order, from the derivatives of 1/r.
    cos2, sin2, p, q = x**2 / r2, y**2 / r2, a**2 / r2, b**2 / r2
    second = p / 6 * (3 * cos2 - 1) + q / 6 * (3 * sin2 - 1)
    fourth = (p**2 * (105 * cos2**2 - 90 * cos2 + 9) + q**2 * (105 * sin2**2 - 90 * sin2 + 9)) / 120
    found: Real = 4 * a * b / (np.pi * np.sqrt(r2)) * (1 + second + fourth + p * q * (105 * cos2 * sin2 - 12) / 36)
    # Beyond this distance the closed formula is the difference of large numbers.
    near = r2 < (FAR * max(spacing)) ** 2
    x, y = x[near], y[near]
    found[near] = (
        _corner(x + a, y + b) - _corner(x - a, y + b) - _corner(x + a, y - b) + _corner(x - a, y - b)
    ) / np.pi
    return found


def _corner(x: Real, y: Real) -> Real:
    return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))


@dataclass(frozen=True, eq=False)
class OpenBoundary:
    """The periodic surface of twice the size whose first quarter, the window, responds as a half-space.

    Tractions act on the points of the window.
    """

    window: Grid

    @cached_property
    def grid(self) -> Grid:
        """The grid of twice the points along x and y."""
        (nx, ny), (along_x, along_y) = self.window.shape, self.window.lengths
        return Grid((2 * nx, 2 * ny), (2 * along_x, 2 * along_y))

    @cached_property
    def stiffness_q(self) -> Real:
        """K_q over the half spectrum of :attr:`grid`, in E*/a0, positive."""
        spacing, (nx, ny) = self.window.spacing, self.grid.shape
        x = (np.minimum(np.arange(nx), nx - np.arange(nx)) * spacing[0])[:, None]
        y = (np.minimum(np.arange(ny), ny - np.arange(ny)) * spacing[1])[None, :]
        x, y = np.broadcast_arrays(x, y)
        influence = cell_influence(x, y, spacing)
        compliance = self.grid.forward(influence).real * self.grid.size
        assert compliance.min() > 0
        return 1 / compliance

    def around(self, values: Real, outside: float) -> Real:
        """A field of the window on :attr:`grid`, with one value outside of the window."""
        field = np.full(self.grid.shape, outside)
        self.inside(field)[...] = values
        return field

    def inside(self, field: Real) -> Real:
        """The part of a field on :attr:`grid` that lies in the window."""
        nx, ny = self.window.shape
        return field[:nx, :ny]

    def displacement(self, traction: Real) -> Real:
        """Displacement on :attr:`grid`, in a0, under tractions of the window, compression positive."""
        pressed_q = self.grid.forward(self.around(traction, 0.0))
        pressed_q /= -self.stiffness_q
        return self.grid.inverse(pressed_q, overwrite=True)

    def mean_displacement(self, traction: Real) -> float:
        """Mean displacement of the window under tractions of it, in a0."""
        return self.window.mean(self._mean_influence * traction)

    def elastic_energy(self, traction: Real) -> float:
        """Elastic energy ½ <u, K u> under tractions, per area of the window, in E* a0."""
        return -0.5 * self.window.mean(traction * self.inside(self.displacement(traction)))

    @cached_property
    def _mean_influence(self) -> Real:
        """Displacement at each point under a uniform unit traction; by reciprocity also the effect of a traction there
        on the mean displacement.
        """
        return self.inside(self.displacement(np.ones(self.window.shape))).copy()

    @property
    def mean_stiffness(self) -> float:
        """Uniform traction over the mean displacement of the window, in E*/a0."""
        return -1 / self.mean_displacement(np.ones(self.window.shape))


NO_LINE = "a two-dimensional grid: under a line load the displacement of a half-space without images is infinite"


class NonPeriodicHalfSpace(Response, kind="non-periodic-half-space"):
    """Isotropic half-space without periodic images: tractions act on the grid only.

    For spheres, indenters and maps without mirror images.  Each point is a cell under uniform traction, whose
    displacements are those of Love's formula (:func:`cell_influence`): a solve takes as long as one of
    a periodic surface of twice the points along x and y.  Far away the half-space is at rest, and separations are
    counted from there.  Mean pressure and areas are per area of the grid.  The mean gap cannot be prescribed, since
    the mean displacement of a window is not an independent mode.

    Examples
    --------
    >>> import continuum as c
    >>> sphere = c.sphere(c.Grid.square(32), radius=100)
    >>> contact = c.Contact(sphere, c.HardWall(), c.NonPeriodicHalfSpace())
    >>> round(contact.press(pressure=0.001).area_rep, 3)
    0.06
    """

    example: ClassVar[Mapping[str, Any]] = {}
    repeats: ClassVar[bool] = False

    def stiffness(self, grid: Grid) -> Real:
        """K_q of a periodic surface, E* q/2, and at q = 0 uniform pressure over mean displacement.

        Used for estimates only; the solver uses :meth:`open_boundary`.
        """
        return with_mean(grid, instance("grid", grid, Grid).wavenumber / 2, self.open_boundary(grid).mean_stiffness)

    def open_boundary(self, grid: Grid) -> OpenBoundary:
        """The response to tractions on the points of a grid."""
        if instance("grid", grid, Grid).is_line:
            raise ArgumentError("grid", grid, NO_LINE)
        return OpenBoundary(grid)

    def without(self, control: str) -> str:
        return "without periodic images the mean gap cannot be prescribed" if control == "mean-gap" else ""
