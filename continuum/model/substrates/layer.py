"""An isotropic layer on a rigid base."""

from collections.abc import Mapping
from math import factorial
from typing import Any, ClassVar

import numpy as np

from continuum.inputs.arguments import instance
from continuum.inputs.keys import Positive
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicResponse, Poisson, with_mean


def decayed_remainder(y: Real, order: int) -> Real:
    """exp(-y) times sinh y - y (order 3) or cosh y - 1 - y²/2 (order 4), to rounding.

    By the series y^n/n! + y^(n+2)/(n+2)! + ... where the difference would lose digits.
    """
    small = np.minimum(y, 1.0) ** 2
    series = np.ones_like(y)
    for k in range(10, 0, -1):  # the first term left out, n!/(n+22)!, is below rounding at y = 1
        series = 1 + series * small / ((2 * k + order - 1) * (2 * k + order))
    series *= np.exp(-y) * np.minimum(y, 1.0) ** order / factorial(order)
    sign, left_out = (-1, y) if order == 3 else (1, 1 + y**2 / 2)
    direct = (1 + sign * np.exp(-2 * y)) / 2 - left_out * np.exp(-y)
    return np.where(y < 1, series, direct)


class Layer(PeriodicResponse, kind="layer"):
    """Isotropic layer bonded to a rigid base, any Poisson ratio up to and including 1/2.

    With x = q depth, from plane-strain elasticity with u = 0 at the base and no lateral traction on top (the
    tests integrate that boundary-value problem numerically)::

        K_q = E* q/2  [(3 - 4ν) cosh 2x + 2x² + 5 - 12ν + 8ν²] / [(3 - 4ν) sinh 2x - 2x]

    computed with sinh 2x - 2x by its series where x is small, since there an incompressible layer is that difference
    alone (K_q = E* 3/(4 q² depth³) to leading order): to 1e-12 at any depth and Poisson ratio.
    :attr:`compressive_stiffness` is the mean mode of the layer itself.
    """

    example: ClassVar[Mapping[str, Any]] = {"depth": 5.0, "poisson": 0.3, "mean": "clamped"}

    depth: Positive
    """thickness, in a0"""
    poisson: Poisson
    """Poisson's ratio"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    @property
    def compressive_stiffness(self) -> float:
        """Pressure per mean displacement, (1-ν)² E*/((1-2ν) depth), in E*/a0; infinite at ν = 1/2."""
        if self.poisson == 0.5:
            return float("inf")
        nu = self.poisson
        return (1 - nu) ** 2 / ((1 - 2 * nu) * self.depth)

    def stiffness(self, grid: Grid) -> Real:
        nu, q = self.poisson, instance("grid", grid, Grid).wavenumber
        grid.mean_mode(q)[...] = 1.0  # its value is set below
        x = q * self.depth
        # Multiplied through by exp(-2x), so that no hyperbolic function overflows.
        decay = np.exp(-2 * x)
        a = 3 - 4 * nu
        above = a * (1 + decay**2) / 2 + decay * (2 * x**2 + 5 - 12 * nu + 8 * nu**2)
        # All terms positive: none cancels another.
        below = a * decayed_remainder(2 * x, 3) + 4 * (1 - 2 * nu) * x * decay
        return with_mean(grid, q / 2 * above / below, self.mean)
