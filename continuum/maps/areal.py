"""Areal parameters of a map by ISO 25178-2, as instruments print them."""

from typing import NamedTuple

import numpy as np

from continuum.maps.map import Topography, means, once
from continuum.model.fourier import Real


class ArealParameters(NamedTuple):
    """Parameters of the whole map, without the filters of the standard; lengths in the unit of the map."""

    Sq: float
    """Root mean square height."""
    Sa: float
    """Arithmetic mean height."""
    Sz: float
    """Maximum height: from the lowest to the highest point."""
    Ssk: float
    """Skewness of the heights."""
    Sku: float
    """Kurtosis of the heights: 3 for a Gaussian surface."""
    Sdq: float
    """Root mean square gradient."""
    Sdr: float
    """Developed area over the projected one, less one."""


@once
def areal_parameters(topography: Topography) -> ArealParameters:
    """The parameters of a map; gradients and areas are those of the triangles between neighbouring points.

    Raises ArgumentError if it is no topography.
    """
    heights = topography.heights
    z = heights - heights.mean()

    def powers(part: Real) -> tuple[Real, ...]:
        square = part * part
        return square, np.abs(part), square * part, square * square

    def gradients(part: Real) -> tuple[Real, Real]:
        """Squared gradients of two triangles between four points, each with an edge along x and one along y; areas."""
        along_x, along_y = (np.square(np.diff(part, axis=axis) / topography.grid.spacing[axis]) for axis in (0, 1))
        squares = np.concatenate([along_x[:, :-1] + along_y[:-1], along_x[:, 1:] + along_y[1:]])
        return squares, np.sqrt(1 + squares) - 1

    (square, mean, third, fourth), (gradient, area) = means(z, powers), means(z, gradients, 1)
    rms = float(np.sqrt(square))
    return ArealParameters(
        Sq=rms,
        Sa=float(mean),
        Sz=float(np.ptp(z)),
        Ssk=float(third) / rms**3,
        Sku=float(fourth) / rms**4,
        Sdq=float(np.sqrt(gradient)),
        Sdr=float(area),
    )
