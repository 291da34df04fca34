"""Areal parameters of a map by ISO 25178-2, as instruments print them."""

from typing import NamedTuple

import numpy as np

from continuum.topography.map import Topography, once


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
    along_x, along_y = (np.diff(z, axis=axis) / topography.grid.spacing[axis] for axis in (0, 1))
    # Two triangles between four points, each with an edge along x and one along y.
    squares = np.concatenate([along_x[:, :-1] ** 2 + along_y[:-1] ** 2, along_x[:, 1:] ** 2 + along_y[1:] ** 2])
    square = z * z
    rms = float(np.sqrt(square.mean()))
    return ArealParameters(
        Sq=rms,
        Sa=float(np.abs(z).mean()),
        Sz=float(np.ptp(z)),
        Ssk=float(np.mean(square * z)) / rms**3,
        Sku=float(np.mean(square * square)) / rms**4,
        Sdq=float(np.sqrt(squares.mean())),
        Sdr=float(np.mean(np.sqrt(1 + squares)) - 1),
    )
