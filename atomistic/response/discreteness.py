"""Convergence of the lattice to the continuum: its surface stiffness and that of the cubic layer of its constants."""

from dataclasses import dataclass, field

import numpy as np

from atomistic.response.lattice import LatticeResponse
from continuum.model.cubic import CubicConstants
from continuum.model.fourier import Real
from continuum.model.substrates import CubicLayer

_LONG = 12.0
"""Wavelengths, in a0, from which the first order in q is read: its neighbours are then below a tenth of it."""
_ALIKE = 0.03
"""Relative width of a bin of wavelengths."""


@dataclass(frozen=True, eq=False)
class Discreteness:
    """K_lattice/K_continuum - 1 over the waves of a grid, without its mean."""

    wavelength: Real = field(repr=False)
    """2π/q of each wave, shape (waves,), in a0."""
    angle: Real = field(repr=False)
    """Angle of each wave to <110>, the axis of the surface grid, in radians."""
    difference: Real = field(repr=False)
    """K_lattice/K_continuum - 1 of each wave."""
    along_110: float
    """Limit of difference/q for long waves along <110>, in a0: the difference is linear in q."""
    along_100: float
    """Stiffness along <100>, likewise."""

    def worst(self, wavelength: float) -> float:
        """Largest difference, with its sign, over the directions of waves of about this length.

        Raises ValueError if there is no such wave.
        """
        near = self.difference[np.abs(self.wavelength / wavelength - 1) < _ALIKE]
        if near.size == 0:
            raise ValueError(f"this grid has no wave of {wavelength} a0")
        return float(near[np.argmax(np.abs(near))])


def discreteness(response: LatticeResponse, constants: CubicConstants) -> Discreteness:
    """Compare a lattice with the cubic layer of its depth and elastic constants, in E*.

    Raises ValueError if the grid is too small for the long waves that the limit is read from.
    """
    grid, depth = response.slab.grid, response.slab.depth
    layer = CubicLayer(depth, constants, constants.c11 / depth).stiffness(grid)
    qx, qy = np.broadcast_arrays(*grid.wavevectors)
    q = grid.wavenumber.ravel()[1:]
    angle = np.arctan2(qy, qx).ravel()[1:]
    difference = (response.stiffness_q / layer - 1).ravel()[1:]
    # Not the very longest, which feel that the base lies a small fraction of a0 from where the continuum has it.
    fitted = (2 * np.pi / q >= _LONG) & (q * depth > 4)
    if np.count_nonzero(fitted) < 20:
        raise ValueError(f"a slab {response.slab.shape} has too few long waves: take 48 x 48 surface atoms or more")
    powers, of_angle = (
        q[fitted, None] ** np.arange(3),
        np.stack([np.ones(fitted.sum()), np.cos(4 * angle[fitted])], axis=1),
    )
    basis = (powers[:, :, None] * of_angle[:, None, :]).reshape(fitted.sum(), -1)
    found = np.linalg.lstsq(basis, difference[fitted] / q[fitted])[0]
    return Discreteness(2 * np.pi / q, angle, difference, float(found[0] + found[1]), float(found[0] - found[1]))
