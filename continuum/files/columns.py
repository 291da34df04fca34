"""Points with positions, in columns x and z of a line scan or x, y and z of a map, put on an even grid."""

import numpy as np

from continuum.model.fourier import Real

_EVEN = 1e-3
"""Largest deviation of points of a line scan from equal distances, as a part of the spacing."""
_SAME = 1e-4
"""Positions that differ by less than this part of the extent are taken as equal."""
_OFF_GRID = 0.2
"""Largest distance of a position from its place on the grid, as a part of the spacing."""
_SPARSE = 10
"""Largest ratio of places on the grid to points; with more, the points are not on a grid."""


Placed = tuple[Real, tuple[float, ...], tuple[str, ...]]
"""Heights, their size in the unit of their positions, and the steps taken."""


def evenly_spaced(where: Real, heights: Real) -> tuple[Real, tuple[str, ...]]:
    """A line scan at equidistant points, interpolated if necessary, and the steps taken.

    The positions ascend.
    """
    even = np.linspace(where[0], where[-1], where.size)
    steps = np.diff(where)
    if np.abs(where - even).max() <= _EVEN * (even[1] - even[0]):
        return heights, ()
    widest = steps.max() / np.median(steps)
    return np.interp(even, where, heights), (
        f"resampled to points an equal distance apart, by straight lines over up to {widest:.3g} spacings",
    )


def line_of(x: Real, z: Real) -> Placed:
    """A line scan of points in any order."""
    if not np.isfinite(x).all():
        raise ValueError("a position is missing")
    order = np.argsort(x, kind="stable")
    x, z = x[order], z[order]
    steps = np.diff(x)
    if not np.all(steps > 0):
        raise ValueError("two heights have the same position")
    length = float((x[-1] - x[0]) * x.size / (x.size - 1))
    z, how = evenly_spaced(x, z)
    return z, (length,), ("columns of position and height", *how)


def grid_of(x: Real, y: Real, z: Real) -> Placed:
    """Put points in any order on a grid; places without a point are holes."""
    (i, dx), (j, dy) = places_of(x, "x"), places_of(y, "y")
    nx, ny = int(i.max()) + 1, int(j.max()) + 1
    if nx * ny > _SPARSE * z.size:
        raise ValueError(f"{z.size} points are not on a grid: most of {nx} x {ny} places are empty")
    if np.unique(i * ny + j).size < z.size:
        raise ValueError("two heights have the same position")
    heights = np.full((nx, ny), np.nan)
    heights[i, j] = z
    how = (f"columns of positions and heights put on a grid of {nx} x {ny} points",)
    if min(nx, ny) == 1:
        return heights.ravel(), (max(nx * dx, ny * dy),), how
    return heights, (nx * dx, ny * dy), how


def places_of(x: Real, name: str) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], float]:
    """The place of each position on an even grid, and the spacing of the grid; 0 if there is one position only."""
    if not np.isfinite(x).all():
        raise ValueError("a position is missing")
    span = float(np.ptp(x))
    if span == 0:
        return np.zeros(x.size, dtype=np.int64), 0.0
    ordered = np.sort(x)
    distinct = ordered[np.append(True, np.diff(ordered) > _SAME * span)]
    step = float(np.median(np.diff(distinct)))
    # The mean over all differences is more accurate than one, as numbers are rounded.
    count = round(span / step)
    step = span / count if count else step
    place = (x - ordered[0]) / step
    index = np.rint(place).astype(np.int64)
    if np.abs(place - index).max() > _OFF_GRID:
        raise ValueError(f"the positions along {name} are not equidistant")
    return index, step
