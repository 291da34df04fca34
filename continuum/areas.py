"""Contact areas under several definitions, side by side, and how far they may be trusted on a grid of points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from continuum.grid import Grid, Real
from continuum.outline import outline
from continuum.wall import HardWall, Wall

__all__ = ["EDGE_SHARE", "Areas", "areas"]

EDGE_SHARE = float((np.pi - 1 + np.log(2)) / 24)
"""Area counted too much per edge, 0.118 cells: Yastrebov, Anciaux, Molinari, Tribol. Int. 114, 161 (2017)."""


@dataclass(frozen=True)
class Areas:
    """Contact area of one state, as fractions of A0."""

    repulsive: float
    """A_rep: cells with gap < zero_gap; the paper's.  For atoms there is no other: a cell is an atom."""
    attracted: float
    """A_att: cells with zero_gap <= gap < zero_gap + range."""
    within_range: float
    """A_rep + A_att: cells that feel the wall."""
    corrected: float
    """``repulsive`` less 0.118 cells per edge of its outline: for points that sample a continuum under a hard wall.

    There a cell at the edge counts as a whole as soon as its point carries pressure.  Patches that are a few cells wide
    are corrected too much.
    """
    contour: float
    """Area inside the line gap = zero_gap, which lies between points where linear interpolation puts it.

    Not a number under a hard wall, where the gap does not cross zero.
    """
    interior: float
    """Cells of A_rep with four neighbours in it: a lower bound."""
    dilated: float
    """A_rep and all cells next to it: an upper bound."""
    uncertainty: float
    """Standard deviation of ``repulsive`` as an estimate of the area of a smooth patch that lies anywhere on the grid.

    As if each perimeter cell were cut at random: sqrt(N_P/12) cells, an upper bound for smooth edges.
    """


def areas(grid: Grid, wall: Wall, gap: Real) -> Areas:
    """Areas of a state, from its gap, shape ``grid.shape``."""
    inside = wall.touches(gap)
    rim, outer = outline(grid, inside), outline(grid, ~inside)
    within = np.count_nonzero(gap < wall.zero_gap + wall.range) if wall.range > 0 else rim.cells
    contour = np.nan if isinstance(wall, HardWall) else _contour(inside, gap, wall.zero_gap, rim.cells)
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


def _contour(inside: np.ndarray, gap: Real, level: float, cells: int) -> float:
    """Cells inside the contour: the mean over the lines along x and along y of the length on which the gap is below.

    Each link between two points counts with its part inside; links between points inside count whole, so only those
    that cross the contour have to be looked at.
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
