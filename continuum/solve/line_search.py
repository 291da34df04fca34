"""How far a step goes along a direction, on any grid of the smooth solver."""

from typing import NamedTuple

import numpy as np

from continuum.solve.conjugate import Line
from continuum.solve.grids import SmoothGrid

LARGEST_RISE = 1e-12
"""A rise of the energy by this part of its size is rounding."""
SLOPE_REDUCTION, SLOPE_ACCEPTED = 0.1, 0.5
"""A Newton step made at once, or a line search near the wall, lowers the slope to the first part; over all points the
second must hold after a line search."""


class Step(NamedTuple):
    """A step along the direction."""

    length: float = 0.0
    """α; NaN if none was found."""
    slope: float = 0.0
    """Slope after it."""
    rise: float = 0.0
    """Change of the energy per point."""
    size_of_energy: float = 0.0
    """Mean of |φ|."""
    newton: bool = True
    """Whether Newton's first step was good enough."""


def take_step(grid: SmoothGrid, line: Line, stiffness: float, *, newton: bool) -> Step:
    """Step along d: Newton's; where the wall softens, of the substrate alone.

    It is made at once if the last one was good, since it then mostly is again; else the points near the wall are asked
    first how far to go.
    """
    _, slope, curvature = line
    first = curvature + max(stiffness, 0.0)
    alpha = first = -slope / first if first > 0 else 1.0
    if not newton:
        alpha = _line_search(grid, line, first, 0.0, slope)
    step = alpha
    low, high = 0.0, np.inf
    for trial in range(60):
        f, second, size_of_energy = grid.move(step, alpha)
        after = slope + alpha * curvature + f
        surprised = trial > 0 or not newton
        if abs(after) <= (SLOPE_ACCEPTED if surprised else SLOPE_REDUCTION) * abs(slope):
            rise = alpha * (slope + 0.5 * alpha * curvature) + second
            return Step(alpha, after, rise if trial == 0 else min(rise, 0.0), size_of_energy, alpha == first)
        low, high = (alpha, high) if after < 0 else (low, alpha)
        if surprised:
            # Points far from the wall have come near it, which the line search did not see: rare.
            target = (low + high) / 2 if np.isfinite(high) else 2 * alpha
        else:
            secant = alpha * min(slope / (slope - after), 4.0) if after > slope else 4 * alpha
            target = _line_search(grid, line, secant, alpha, after)
        step, alpha = target - alpha, target
    return Step(np.nan)


def _line_search(grid: SmoothGrid, line: Line, alpha: float, here: float, after: float) -> float:
    """Step length at which the slope, ``after`` where the gap is ``here``, has fallen to a part of the first.

    Newton's method from alpha, inside a bracket, over the points near the wall.
    """
    low, high = (here, np.inf) if after < 0 else (0.0, here)
    for _ in range(40):
        f, c = grid.line(alpha - here)
        f, c = after + (alpha - here) * line.curvature + f, line.curvature + c
        if not np.isfinite(f) or abs(f) <= SLOPE_REDUCTION * abs(line.slope):
            break
        low, high = (alpha, high) if f < 0 else (low, alpha)
        newton = alpha - f / c if c > 0 else np.inf
        if not low < newton < high:
            newton = (low + high) / 2 if np.isfinite(high) else 4 * alpha
        alpha = min(newton, 10 * alpha)
    return alpha
