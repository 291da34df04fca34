"""The direction of a step of the smooth solver, from sums over the modes of a spectrum: scalars only.

Coarser grids find their part of it in a linear problem, whose minimum need not be found, as it is a direction only.
"""

from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.solve.grids import Descending

COARSE_ITERATIONS, COARSE_REDUCTION = 4, 0.3
"""A coarse step ends after so many iterations, or when the coarse gradient has fallen by this factor.

Four on n/2, and in each of them four on n/4, do as well as an exact solution.
"""


class Line(NamedTuple):
    """The energy of the substrate along a direction d, which keeps a part β of the one before."""

    beta: float = 0.0
    slope: float = 0.0
    """E' where the step begins, of the wall as well."""
    curvature: float = 0.0
    """<d K d>."""


def conjugate_line(sums: Real, last: Line, after: float, conjugate: bool) -> Line:
    """The next direction, by Hager and Zhang's beta, SIAM J. Optim. 16, 170 (2005); else steepest descent.

    On the last line the slope fell to ``after``.  The new direction is the last one's β-fold minus s.  ``sums`` are
    those of :mod:`continuum.solve.grids`.
    """
    gs, ys, ym, ss, sd = sums[1], sums[2], sums[3], sums[4], sums[5]
    dg, dd = after, last.curvature
    dy = after - last.slope if conjugate else 0.0
    beta = max(0.0, (ys - 2 * dg * ym / dy) / dy) if dy > 0 else 0.0
    if beta * dg >= gs:
        beta = 0.0
    return Line(beta, beta * dg - gs, ss - 2 * beta * sd + beta * beta * dd)


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
