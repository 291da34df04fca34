"""A step of coarser grids: of a linear problem, whose minimum need not be found, as it is a direction only."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real
from continuum.solve.grids import Descending

COARSE_ITERATIONS, COARSE_REDUCTION = 4, 0.3
"""A coarse step ends after so many iterations, or when the coarse gradient has fallen by this factor."""


def coarse_step(grid: Descending, levels: int, shift: float, sums: Real) -> tuple[Real, bool]:
    """Let the coarser grid find its part of the step; returns the sums over all modes, and whether that descends."""
    size = float(np.sqrt(sums[0]))
    grid.restrict(size)
    assert grid.linear is not None
    if grid.linear.relax(levels - 1, shift, COARSE_ITERATIONS, COARSE_REDUCTION):
        both = sums + grid.low_modes(shift, size)
        if np.isfinite(both).all() and both[1] > 0:
            return both, True
    # It does not: the gradient's own does.
    return sums + grid.low_gradient(shift), False
