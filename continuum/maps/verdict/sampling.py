"""The sampling error of a threshold: how far a map speaks for the surface from which it was cut.

A spot of a surface has its own summits.  Its state is cut into blocks of one roll-off length, which are nearly
independent samples of the surface.  Block b has the load N_b, the attraction T_b = <τ>_b and the contact area A_b, per
its own area.  The threshold at a given area is w_c = N/T, which changes with the area as A^s, where s is known from a
second state.  At the area of the map, to first order in its blocks::

    ln w_c = ln w + mean of e_b,    e_b = N_b/N - T_b/T - s A_b/A

so that the scatter of e_b over the root of their number is the standard error.  Waves longer than the map are not in
it: without a roll-off inside the map nothing is known of the surface.  Stated and tested in docs/studies/spots.md.
"""

from typing import NamedTuple

import numpy as np
import scipy

from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.path.threshold import PressedState

FEWEST_BLOCKS = 16
"""Blocks that a map needs: four roll-off lengths along each side.  Of fewer a fit also finds some where there are none,
by chance of the longest waves (docs/studies/spots.md)."""
FLOOR = 0.03
"""Relative error that is added in quadrature, of the area and of what the blocks share."""
WHOLE = 0.15
"""Part of a block that may be missing at the end of a map: a fitted roll-off is known to a band of its spectrum."""
ERRORS, CONFIDENCE = 2.0, 0.95
"""Standard errors of an interval, and how often it holds."""


class Blocks(NamedTuple):
    """Numbers of blocks, one roll-off length long, along each side of a map."""

    nx: int
    ny: int

    @property
    def enough(self) -> bool:
        """True if they tell a sampling error."""
        return self.nx * self.ny >= FEWEST_BLOCKS

    @classmethod
    def of(cls, lengths: tuple[float, float], roll_off: float) -> "Blocks":
        """Blocks of a map, at least one along each side."""
        nx, ny = (max(1, int(length / roll_off + WHOLE)) for length in lengths)
        return cls(nx, ny)

    def means(self, values: Real) -> Real:
        """Means of a field over each block, shape (nx, ny)."""
        for axis, count in enumerate(self):
            edges = np.rint(np.linspace(0, values.shape[axis], count + 1)).astype(int)
            sizes = np.diff(edges).reshape((-1, 1) if axis == 0 else (1, -1))
            values = np.add.reduceat(values, edges[:-1], axis) / sizes
        return values


def sampling_error(
    state: PressedState, beside: PressedState, wall: Wall, shape: tuple[int, int], blocks: Blocks
) -> float:
    """Standard error of the logarithm of w_c, as of another spot of the same size; NaN without enough blocks.

    Two such errors hold the threshold of the surface with 95 %: where blocks are few the error is that of Student.

    Parameters
    ----------
    state, beside : of the map at its area, and at another one.
    wall : the law.
    shape : points of the map itself, without its mirror images.
    blocks : of one roll-off length each.
    """
    if not blocks.enough or min(shape[0] // blocks.nx, shape[1] // blocks.ny) < 1:
        return np.nan
    pull, load, area = _fields(state, wall)
    ratios = [np.log(one.load / one.grid.mean(tau)) for one, tau in ((state, pull), (beside, _fields(beside, wall)[0]))]
    slope = (ratios[0] - ratios[1]) / np.log(state.area_rep / beside.area_rep)
    own = np.s_[: shape[0], : shape[1]]
    parts = [blocks.means(field[own]) / field.mean() for field in (load, pull, area)]
    scatter = parts[0] - parts[1] - slope * parts[2]
    student = float(scipy.special.stdtrit(scatter.size - 1, (1 + CONFIDENCE) / 2)) / ERRORS
    return float(np.hypot(student * scatter.std(ddof=1) / np.sqrt(scatter.size), FLOOR))


def _fields(state: PressedState, wall: Wall) -> tuple[Real, Real, Real]:
    """Attraction per work, pressure, and contact of each point."""
    return state.attraction(wall)[0], np.maximum(-state.distance, 0.0), state.contact.astype(np.float64)
