"""What a contact looks like: areas, loads, maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from continuum.model.grid import Grid, Real
from continuum.model.walls import Wall

__all__ = ["ATTRACTED", "OUT_OF_RANGE", "REPULSIVE", "Contact", "contact_map", "measure"]

OUT_OF_RANGE, ATTRACTED, REPULSIVE = np.uint8(0), np.uint8(1), np.uint8(2)
_ROWS = 256


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
    wall_energy: float
    """Interaction energy per area, in E* a0."""
    smallest_gap: float
    """In a0."""


def contact_map(wall: Wall, gap: Real) -> NDArray[np.uint8]:
    """REPULSIVE, ATTRACTED or OUT_OF_RANGE at each point."""
    repulsive = wall.touches(gap)
    attracted = ~repulsive & (gap < wall.zero_gap + wall.range)
    return np.where(repulsive, REPULSIVE, np.where(attracted, ATTRACTED, OUT_OF_RANGE))


def measure(grid: Grid, wall: Wall, gap: Real, traction: Real | None = None) -> Contact:
    """Areas and loads of a state, from its gap; a hard wall also needs the state's traction."""
    sums = np.zeros(3)
    repulsive = attracted = 0
    for start in range(0, gap.shape[0], _ROWS):  # in blocks: three fields of a large grid would not fit
        block = gap[start : start + _ROWS]
        if traction is None:
            energy, pressure, _ = wall.evaluate(block)
        else:
            energy, pressure = wall.energy(block), traction[start : start + _ROWS]
        kind = contact_map(wall, block)
        repulsive += int(np.count_nonzero(kind == REPULSIVE))
        attracted += int(np.count_nonzero(kind == ATTRACTED))
        sums += np.maximum(pressure, 0.0).sum(), np.maximum(-pressure, 0.0).sum(), energy.sum()
    load_rep, load_att, energy_per_area = (float(total) / grid.size for total in sums)
    return Contact(
        area_rep=repulsive / grid.size,
        area_att=attracted / grid.size,
        load_rep=load_rep,
        load_att=load_att,
        load=load_rep - load_att,
        wall_energy=energy_per_area,
        smallest_gap=float(gap.min()),
    )
