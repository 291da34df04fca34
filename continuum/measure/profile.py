"""Gap against distance from the edge of a contact, and distributions of gap and pressure."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.measure.outline import Mask, mask_on_grid
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall

EDGE_DEPTH = 3 / 8
"""Mean depth of the nearest centre inside the edge, in cells.

Measured on discs of radius 5 - 80 cells: 0.48 in the next cell, 0.37 at 2 - 4 cells, 0.3 at 5 - 8.
"""

_ROWS = 128  # fields are processed in blocks: several of the whole grid would not fit beside it


@dataclass(frozen=True, eq=False)
class GapProfile:
    """Mean gap outside a contact against the distance x from its edge; one entry for each cell width that holds cells.

    x is the distance from the centre of a cell to the nearest centre inside, less :data:`EDGE_DEPTH` cells, which is
    the depth of that centre inside the edge: half a cell for an edge along the axes, less for others.
    """

    distance: Real
    """Mean of x, in a0."""
    gap: Real
    """Mean gap above that of the edge, in a0."""
    spread: Real
    """Standard deviation of the gap over the surface, in a0; not the error of the mean."""
    cells: NDArray[np.int64]
    """Number of cells at that distance."""
    depth: float
    """Depth of the nearest centre inside the edge, in a0."""

    @property
    def from_perimeter_cells(self) -> Real:
        """Distance from the centres of the perimeter cells instead of the edge, in a0: the paper's perimeter."""
        return self.distance + self.depth

    def width(self, range: float) -> float:
        """Distance d_att at which the mean gap reaches the range of the attraction, in a0.

        NaN if it does not.  Between two distances gap^(2/3) is taken as linear, as in Eq. (S-1).
        """
        reached = np.flatnonzero(self.gap >= range)
        if reached.size == 0:
            return float("nan")
        last = int(reached[0])
        x = np.concatenate([[0.0], self.distance[: last + 1]])
        rise = np.concatenate([[0.0], np.cbrt(np.maximum(self.gap[: last + 1], 0.0)) ** 2])
        return float(np.interp(np.cbrt(range) ** 2, rise[-2:], x[-2:]))


def gap_profile(grid: Grid, gap: Real, inside: Mask, farthest: float, zero_gap: float) -> GapProfile:
    """Mean gap against distance from the edge of a contact.

    Parameters
    ----------
    gap : shape ``grid.shape``, in a0.
    inside : the cells of the contact.
    farthest : distance up to which the profile reaches, in a0; the map is held with a margin that wide.
    zero_gap : gap of the edge, in a0.

    Raises ValueError if the map does not fit the grid, or the distance is not positive.
    """
    inside = mask_on_grid(grid, inside)
    if not 0 < farthest < np.inf:
        raise ValueError(f"the farthest distance from an edge is a positive finite number, got {farthest}")
    depth, bins = EDGE_DEPTH * sum(grid.spacing) / 2, int(np.ceil(farthest / min(grid.spacing)))
    sums = np.zeros((4, bins))
    for x, rise in _outside(grid, gap, inside, farthest + depth):
        bin = np.minimum((np.maximum(x - depth, 0.0) / farthest * bins).astype(np.intp), bins - 1)
        above = rise - zero_gap
        for row, weights in enumerate((None, x - depth, above, above**2)):
            sums[row] += np.bincount(bin, weights, minlength=bins)
    count, distance, mean, square = sums[:, sums[0] > 0]
    variance = np.maximum(square / count - (mean / count) ** 2, 0.0)
    return GapProfile(distance / count, mean / count, np.sqrt(variance), count.astype(np.int64), depth)


def _outside(grid: Grid, gap: Real, inside: Mask, farthest: float) -> Iterator[tuple[Real, Real]]:
    """Distance to the nearest cell inside, and gap, of the cells outside near the contact, block by block."""
    if not inside.any():
        return
    (dx, dy), (nx, ny) = grid.spacing, grid.shape
    margin = [int(np.ceil(farthest / spacing)) for spacing in (dx, dy)]
    # With a margin of the images, distances up to it are those of the periodic map.  Indices instead of distances:
    # these would take several arrays of the whole map.
    padded = np.pad(~inside, [(m, m) for m in margin], mode="wrap")
    nearest = scipy.ndimage.distance_transform_edt(
        padded, sampling=(dx, dy), return_distances=False, return_indices=True
    )
    columns = slice(margin[1], margin[1] + ny)
    y = np.arange(ny) + margin[1]
    for start in range(0, nx, _ROWS):
        rows = slice(margin[0] + start, margin[0] + min(start + _ROWS, nx))
        x = np.arange(rows.start, rows.stop)[:, None]
        i, j = nearest[:, rows, columns]
        distance = np.hypot((x - i) * dx, (y - j) * dy)
        near = (distance > 0) & (distance < farthest)
        yield distance[near], gap[start : start + _ROWS][near]


@dataclass(frozen=True, eq=False)
class Distribution:
    """A histogram over the area: the density of A/A0 over a quantity."""

    edges: Real
    """Edges of the bins, one more than there are bins."""
    density: Real
    """Fraction of A0 in each bin, divided by its width."""


def gap_distribution(grid: Grid, gap: Real, bins: int = 80) -> Distribution:
    """Distribution of the gap, in a0, from the smallest to the largest: its integral is 1."""
    edges = np.linspace(float(gap.min()), float(gap.max()), bins + 1)
    if edges[0] == edges[-1]:
        edges += np.linspace(-0.5, 0.5, bins + 1)  # a flat surface: all points in the middle bin
    blocks = (gap[start : start + _ROWS] for start in range(0, grid.shape[0], _ROWS))
    return Distribution(edges, _histogram(blocks, edges) / (grid.size * np.diff(edges)))


def pressure_distribution(
    grid: Grid, wall: Wall, gap: Real, traction: Real | None = None, bins: int = 80
) -> Distribution:
    """Distribution of the pressure, in E*, compression positive, over the cells with non-zero pressure.

    Its integral is the fraction of A0 that feels the wall, its first moment the load.  The traction of the state is
    needed under a hard wall only, otherwise it follows from the gap.
    """

    def blocks() -> Iterator[Real]:
        for start in range(0, grid.shape[0], _ROWS):
            rows = slice(start, start + _ROWS)
            pressure = wall.evaluate(gap[rows]).traction if traction is None else traction[rows]
            yield pressure[pressure != 0]

    ends = [(block.min(), block.max()) for block in blocks() if block.size]
    low, high = (min(e[0] for e in ends), max(e[1] for e in ends)) if ends else (0.0, 1.0)
    if low == high:
        low, high = low - abs(low) / 2, high + abs(high) / 2
    edges = np.linspace(low, high, bins + 1)
    return Distribution(edges, _histogram(blocks(), edges) / (grid.size * np.diff(edges)))


def _histogram(blocks: Iterator[Real], edges: Real) -> Real:
    count = np.zeros(edges.size - 1)
    for block in blocks:
        count += np.histogram(block, bins=edges.size - 1, range=(edges[0], edges[-1]))[0]
    return count
