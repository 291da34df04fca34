"""Outline of a contact: perimeter, chords, patches, areas by several definitions; gap and pressure near it.

A contact is a map of cells, one around each point of a periodic grid, inside or outside.  Cells are neighbours if they
share an edge; the map is periodic.  Numbers are counted on the cells, so that
turning or shifting the map changes none of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall
from continuum.theory import paper

Mask = NDArray[np.bool_]
EDGE_SHARE = float((np.pi - 1 + np.log(2)) / 24)
"""Area counted too much per edge, 0.118 cells: Yastrebov, Anciaux, Molinari, Tribol. Int. 114, 161 (2017)."""
Correction = Literal["paper", "exact", "edges"]
"""Relation between perimeter cells and length: see :meth:`Outline.perimeter`."""


def ratio(numerator: float, denominator: float) -> float:
    """Quotient of two numbers: infinite with the sign of the numerator over zero, NaN for 0/0."""
    if denominator == 0:
        return np.nan if numerator == 0 else float(np.copysign(np.inf, numerator))
    return float(numerator / denominator)


@dataclass(frozen=True)
class Outline:
    """Area, perimeter and chords of a map of cells, as counted."""

    spacing: tuple[float, float]
    """Sides of a cell along x and y, in a0."""
    cells: int
    """Number of cells inside."""
    perimeter_cells: int
    """N_P: cells inside that have fewer than four neighbours inside."""
    edges: tuple[int, int]
    """Number of edges between a cell inside and one outside, along x and along y."""

    @property
    def area(self) -> float:
        """Area A, in a0²: all cells inside."""
        return self.cells * self.spacing[0] * self.spacing[1]

    def perimeter(self, correction: Correction = "paper") -> float:
        """Length P of the perimeter, in a0.

        Parameters
        ----------
        correction : "paper", P = β a0 N_P with the paper's β = 1.1222 (Suppl. S-II); "exact", with β = 1.1107, which
            is right for a smooth perimeter that points in all directions alike; "edges", π/4 times the length of the
            stepped outline, equally right there (Cauchy and Crofton), and the one that is exact for chords:
            P = π A/chord.  Where patches are a few cells wide they differ: a cell may have several edges.
        """
        dx, dy = self.spacing
        if correction == "edges":
            return np.pi / 4 * (self.edges[0] * dy + self.edges[1] * dx)
        # A line at θ to the x axis has max(|cos θ|/dx, |sin θ|/dy) cells per length: on average (2/π)/(that of a
        # square cell), with the side below for the square.
        side = np.sqrt(2) * dx * dy / np.hypot(dx, dy)
        factor = paper.PERIMETER_FACTOR_PAPER if correction == "paper" else paper.PERIMETER_FACTOR
        return float(factor * side * self.perimeter_cells)

    def diameter(self, correction: Correction = "paper") -> float:
        """Mean diameter d = π A/P, in a0; infinite without perimeter, NaN without area."""
        return ratio(np.pi * self.area, self.perimeter(correction))

    @property
    def chords(self) -> tuple[float, float]:
        """Mean length of the contiguous segments of slices along x and along y, in a0.

        A slice entirely inside has no end: it adds to the length, not to the number of segments.
        """
        dx, dy = self.spacing
        along_x, along_y = self.edges
        return ratio(2 * self.cells * dx, along_x), ratio(2 * self.cells * dy, along_y)

    @property
    def chord(self) -> float:
        """Mean chord over all segments of both directions, in a0."""
        return self.diameter("edges")


def outline(grid: Grid, inside: Mask) -> Outline:
    """Count cells, perimeter cells and edges of a map, shape ``grid.shape``.

    Raises ValueError if the map does not fit the grid.
    """
    inside = mask_on_grid(grid, inside)
    cells, edges = int(np.count_nonzero(inside)), [np.count_nonzero(inside != np.roll(inside, 1, a)) for a in (0, 1)]
    return Outline(grid.spacing, cells, int(np.count_nonzero(perimeter_map(inside))), (int(edges[0]), int(edges[1])))


def perimeter_map(inside: Mask) -> Mask:
    """Cells inside that have fewer than four neighbours inside."""
    core = inside.copy()
    for axis in (0, 1):
        for step in (1, -1):
            core &= np.roll(inside, step, axis)
    core ^= inside
    return core


def mask_on_grid(grid: Grid, inside: Mask) -> Mask:
    """Convert a map to booleans, and check that it has the shape of the grid.

    Raises ValueError if it has another shape.
    """
    inside = np.asarray(inside, dtype=np.bool_)
    if inside.shape != grid.shape:
        raise ValueError(f"a map of shape {inside.shape} does not fit a grid of shape {grid.shape}")
    return inside


@dataclass(frozen=True, eq=False)
class Patches:
    """The connected parts of a map: cells that share an edge, also over the seam of the period."""

    labels: NDArray[np.int32]
    """1, 2, ... inside, the number of the patch; 0 outside; shape of the map."""
    cells: NDArray[np.int64]
    """Cells of each patch, in the order of their numbers."""
    perimeter_cells: NDArray[np.int64]
    """Perimeter cells of each patch."""
    cell_area: float
    """Area of a cell, in a0²."""

    @property
    def areas(self) -> Real:
        """Area of each patch, in a0²."""
        return self.cells.astype(np.float64) * self.cell_area


def patches(grid: Grid, inside: Mask) -> Patches:
    """The connected patches of a map, shape ``grid.shape``.

    Raises ValueError if the map does not fit the grid.
    """
    inside = mask_on_grid(grid, inside)
    labels = np.zeros(grid.shape, dtype=np.int32)
    found = scipy.ndimage.label(inside, output=labels)
    # Patches that meet over the seam are one: components of the graph of such meetings, node 0 being the outside.
    first = np.concatenate([labels[0], labels[:, 0]])
    last = np.concatenate([labels[-1], labels[:, -1]])
    meet = (first > 0) & (last > 0)
    graph = scipy.sparse.coo_array((np.ones(int(meet.sum())), (first[meet], last[meet])), shape=(found + 1, found + 1))
    count, number = scipy.sparse.csgraph.connected_components(graph, directed=False)
    if count <= found:
        labels = np.asarray(number, dtype=np.int32)[labels]
    # Counted on the cells inside only, which are few.
    cells, rim = (np.bincount(labels[cell], minlength=count)[1:] for cell in (inside, perimeter_map(inside)))
    return Patches(labels, cells, rim, grid.cell_area)


def size_distribution(areas: Real, per_decade: int = 5) -> tuple[Real, Real]:
    """Number of patches per area of a patch, n(A), in logarithmic bins from the smallest to the largest area, in a0².

    Returns the geometric mean of the ends of each bin, in a0², and patches per a0² of patch size, in 1/a0²; bins
    without patches are left out.
    """
    if areas.size == 0:
        return np.empty(0), np.empty(0)
    low, high = np.log10(areas.min()), np.log10(areas.max())
    edges = 10 ** (low + np.arange(int(np.floor((high - low) * per_decade + 1e-9)) + 2) / per_decade)
    edges[0] *= 1 - 1e-9  # the smallest lies on the edge
    count = np.histogram(areas, edges)[0]
    filled = count > 0
    return np.sqrt(edges[1:] * edges[:-1])[filled], (count / np.diff(edges))[filled]


# --- area ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Areas:
    """Contact area of one state, as fractions of A0."""

    repulsive: float
    """A_rep: cells with gap < zero_gap; the paper's definition, and the only one for atoms, where a cell is an atom."""
    attracted: float
    """A_att: cells with zero_gap <= gap < zero_gap + range."""
    within_range: float
    """A_rep + A_att: cells that feel the wall."""
    corrected: float
    """``repulsive`` less 0.118 cells per edge of its outline, for points that sample a continuum under a hard wall.

    There a cell at the edge counts as a whole as soon as its point carries pressure.  For Hertz contacts this is
    right within 1 % from a radius of two cells on (docs/model.md).
    """
    contour: float
    """Area inside the line gap = zero_gap, by linear interpolation between points.

    NaN where the gap does not cross it: in contact with a hard wall it is zero.
    """
    interior: float
    """Cells of A_rep with four neighbours in it: a lower bound."""
    dilated: float
    """A_rep and all cells next to it: an upper bound."""
    uncertainty: float
    """Standard deviation of ``repulsive`` as an estimate of the area of a smooth patch that lies anywhere on the grid.

    Each perimeter cell is taken to be cut at random: sqrt(N_P/12) cells, an upper bound for smooth edges.
    """


def areas(grid: Grid, wall: Wall, gap: Real) -> Areas:
    """Areas of a state, from its gap, shape ``grid.shape``."""
    inside = wall.touches(gap)
    rim, outer = outline(grid, inside), outline(grid, ~inside)
    within = np.count_nonzero(gap < wall.zero_gap + wall.range) if wall.range > 0 else rim.cells
    crosses = bool((gap[inside] < wall.zero_gap).all())
    contour = _contour(inside, gap, wall.zero_gap, rim.cells) if crosses else np.nan
    counts = (
        rim.cells,
        within - rim.cells,
        within,
        rim.cells - EDGE_SHARE * sum(rim.edges),
        contour,
        rim.cells - rim.perimeter_cells,
        rim.cells + outer.perimeter_cells,
        np.sqrt(rim.perimeter_cells / 12),
    )
    return Areas(*(float(count) / grid.size for count in counts))


def _contour(inside: Mask, gap: Real, level: float, cells: int) -> float:
    """Cells inside the contour: the mean over the lines along x and along y of the length on which the gap is below.

    Each link between two points counts with its part inside; links between two points inside count whole, so that only
    links across the contour are computed.
    """
    length = 0.0
    for axis in (0, 1):
        crossing = np.flatnonzero(inside != np.roll(inside, -1, axis))
        i, j = np.unravel_index(crossing, gap.shape)
        here = gap[i, j] - level
        there = (gap[(i + 1) % gap.shape[0], j] if axis == 0 else gap[i, (j + 1) % gap.shape[1]]) - level
        part = np.minimum(here, there) / (np.minimum(here, there) - np.maximum(here, there))
        # Every patch of a line has one link less inside than points inside: half a link for each end.
        length += cells - crossing.size / 2 + float(part.sum())
    return length / 2


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
