"""The outline of a contact: perimeter, chords, connected patches, and areas by several definitions.

A contact is a map of cells, one around each point of a periodic grid, inside or outside.  Cells are neighbours if they
share an edge; the map is periodic.  Numbers are counted on the cells, so that
turning or shifting the map changes none of them.
"""

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
