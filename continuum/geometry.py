"""What a contact looks like: areas, loads, maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from continuum.grid import Grid, Real
from continuum.wall import Wall

__all__ = ["ATTRACTED", "OUT_OF_RANGE", "REPULSIVE", "Contact", "contact_map", "measure"]

OUT_OF_RANGE, ATTRACTED, REPULSIVE = np.uint8(0), np.uint8(1), np.uint8(2)


@dataclass(frozen=True)
class Contact:
    """Areas and loads of one state.  Areas are fractions of A0, loads are per A0, in E*."""

    area_rep: float
    """A_rep/A0: points with gap < zero_gap; under a hard wall, with gap = 0."""
    area_att: float
    """A_att/A0: points with zero_gap <= gap < zero_gap + range."""
    load_rep: float
    """N_rep/(E* A0): the pushing points."""
    load_att: float
    """N_att/(E* A0): the pulling points, as a positive number."""
    load: float
    """N/(E* A0) = (N_rep - N_att)/(E* A0)."""
    smallest_gap: float
    """In a0."""


def contact_map(wall: Wall, gap: Real) -> NDArray[np.uint8]:
    """REPULSIVE, ATTRACTED or OUT_OF_RANGE at each point."""
    repulsive = wall.touches(gap)
    attracted = ~repulsive & (gap < wall.zero_gap + wall.range)
    return np.where(repulsive, REPULSIVE, np.where(attracted, ATTRACTED, OUT_OF_RANGE))


def measure(grid: Grid, wall: Wall, gap: Real, traction: Real | None = None) -> Contact:
    """Areas and loads of a state, from its gap; a hard wall also needs the state's traction."""
    if traction is None:
        traction = wall.evaluate(gap).traction
    kind = contact_map(wall, gap)
    load_rep = grid.mean(np.maximum(traction, 0.0))
    load_att = grid.mean(np.maximum(-traction, 0.0))
    return Contact(
        area_rep=np.count_nonzero(kind == REPULSIVE) / grid.size,
        area_att=np.count_nonzero(kind == ATTRACTED) / grid.size,
        load_rep=load_rep,
        load_att=load_att,
        load=load_rep - load_att,
        smallest_gap=float(gap.min()),
    )
