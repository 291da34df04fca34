"""What the noise of an instrument adds to the error of a number whose derivative by the heights is known."""

from __future__ import annotations

import numpy as np

from continuum.arguments import field, instance, number
from continuum.model.fourier import Real
from continuum.model.grid import Grid


def noise_error(grid: Grid, gradient: Real, rms: float, correlation_length: float = 0.0) -> float:
    """Standard deviation of a number by noise of the heights: sqrt(Σ g²) σ where the noise of points is independent.

    To first order in the noise, which holds while it is small beside what the number depends on: the range of the
    attraction, and the gaps beside the contact.  What a known change dh adds, as that of a scar, is the sum of g dh.

    Parameters
    ----------
    grid : the points of the surface.
    gradient : g, the derivative of the number by the height of every point, shape ``grid.shape``, per a0.
    rms : σ, the root mean square of the noise, in a0.
    correlation_length : ξ of noise whose correlation over a distance r is exp(-r²/ξ²), in a0, at most half
        of the shorter period; 0 for independent points.

    Returns
    -------
    float
        In the unit of the number.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> c.noise_error(c.Grid.square(2), np.ones((2, 2)), 0.1)
    0.2
    """
    instance("grid", grid, Grid)
    g = field("gradient", gradient, grid.shape)
    sigma = number("rms", rms, least=0)
    length = number("correlation_length", correlation_length, least=0, most=grid.shortest_period / 2)
    if length == 0:
        return float(sigma * np.sqrt((g**2).sum()))
    offsets = (np.minimum(x, period - x) for x, period in zip(grid.positions, grid.lengths, strict=True))
    with np.errstate(over="ignore"):  # of a length far below the spacing
        correlation = np.exp(-sum((x / length) ** 2 for x in offsets))
    neighbours = grid.size * grid.inverse(grid.forward(correlation) * grid.forward(g), overwrite=True)
    return float(sigma * np.sqrt(max(0.0, (g * neighbours).sum())))
