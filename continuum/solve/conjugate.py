"""The direction of a step of the smooth solver, from sums over the modes of a spectrum: scalars only."""

from __future__ import annotations

from typing import NamedTuple

from continuum.model.fourier import Real


class Line(NamedTuple):
    """The energy of the substrate along a direction d, which keeps a part β of the one before."""

    beta: float
    slope: float
    """E' where the step begins, of the wall as well."""
    curvature: float
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
