"""Areas, loads and contact map of a state, and the numbers by which the paper compares contacts."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.measure.outline import Mask, Outline, outline, ratio
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall

OUT_OF_RANGE, ATTRACTED, REPULSIVE = np.uint8(0), np.uint8(1), np.uint8(2)
_ROWS = 256


def quantity(units: str, long_name: str) -> Any:
    """A stored field of a record, with its unit and its description."""
    return field(metadata={"units": units, "long_name": long_name})


@dataclass(frozen=True)
class Totals:
    """Areas and loads of one state.  Areas are fractions of A0, loads are per A0, in E*."""

    area_rep: float = quantity("1", "repulsive area A_rep/A0")
    """Points with gap < zero_gap; under a hard wall, with gap = 0."""
    area_att: float = quantity("1", "attracted area A_att/A0")
    """Points with zero_gap <= gap < zero_gap + range."""
    load_rep: float = quantity("E*", "repulsive load N_rep/A0")
    """Load N_rep/A0 of the points that push, in E*."""
    load_att: float = quantity("E*", "attractive load N_att/A0")
    """Load N_att/A0 of the points that pull, as a positive number, in E*."""
    load: float = quantity("E*", "load N/A0, compression positive")
    """N = N_rep - N_att."""
    wall_energy: float = quantity("E* a0", "interaction energy per area")
    smallest_gap: float = quantity("a0", "smallest gap")


def contact_map(wall: Wall, gap: Real) -> NDArray[np.uint8]:
    """REPULSIVE, ATTRACTED or OUT_OF_RANGE at each point."""
    repulsive = wall.touches(gap)
    attracted = ~repulsive & (gap < wall.zero_gap + wall.range)
    return np.where(repulsive, REPULSIVE, np.where(attracted, ATTRACTED, OUT_OF_RANGE))


def totals_of(grid: Grid, wall: Wall, gap: Real, traction: Real | None = None) -> Totals:
    """Areas and loads of a state, from its gap and, where the wall has no law of the gap, from its traction.

    Parameters
    ----------
    gap, traction : shape ``grid.shape``, in a0 and E*.
    """
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
    return Totals(
        area_rep=repulsive / grid.size,
        area_att=attracted / grid.size,
        load_rep=load_rep,
        load_att=load_att,
        load=load_rep - load_att,
        wall_energy=energy_per_area,
        smallest_gap=float(gap.min()),
    )


@dataclass(frozen=True)
class Measurement:
    """Areas and loads of a contact, the outline of A_rep, and the numbers that the paper derives from them.

    A ratio whose two sides are zero is NaN: without contact there is no κ and no diameter.
    """

    totals: Totals
    outline: Outline = field(repr=False)
    """Outline of A_rep."""
    rms_slope: float
    """h'rms of the undeformed surface."""

    @property
    def area_rep(self) -> float:
        """A_rep/A0."""
        return self.totals.area_rep

    @property
    def area_att(self) -> float:
        """A_att/A0."""
        return self.totals.area_att

    @property
    def load(self) -> float:
        """N/A0, in E*."""
        return self.totals.load

    @property
    def pressure_rep(self) -> float:
        """p_rep = N_rep/A_rep, in E*."""
        return ratio(self.totals.load_rep, self.totals.area_rep)

    @property
    def pressure_att(self) -> float:
        """Mean attractive pressure N_att/A_att, in E*, positive; w/Δr in the paper's theory."""
        return ratio(self.totals.load_att, self.totals.area_att)

    def _kappa(self, load: float) -> float:
        return ratio(self.rms_slope * self.totals.area_rep, load)

    @property
    def kappa(self) -> float:
        """κ = h'rms E* A_rep/N, Eq. (1): negative where the load is; infinite where it vanishes."""
        return self._kappa(self.totals.load)

    @property
    def kappa_rep(self) -> float:
        """κ_rep = h'rms E* A_rep/N_rep."""
        return self._kappa(self.totals.load_rep)

    @property
    def kappa_att(self) -> float:
        """κ_att = h'rms E* A_rep/N_att, so that 1/κ = 1/κ_rep - 1/κ_att; infinite without attraction."""
        return self._kappa(self.totals.load_att)

    @property
    def perimeter_cells(self) -> int:
        """Number of cells of the perimeter, N_P."""
        return self.outline.perimeter_cells

    @property
    def perimeter(self) -> float:
        """P, in a0, with the paper's correction 1.1222."""
        return self.outline.perimeter("paper")

    @property
    def perimeter_exact(self) -> float:
        """P, in a0, with the correction 1.1107."""
        return self.outline.perimeter("exact")

    @property
    def diameter(self) -> float:
        """d_rep = π A_rep/P, in a0, with the paper's correction."""
        return self.outline.diameter("paper")

    @property
    def diameter_exact(self) -> float:
        """d_rep with the correction 1.1107."""
        return self.outline.diameter("exact")

    @property
    def chord(self) -> float:
        """Mean chord of A_rep in both directions, in a0."""
        return self.outline.chord

    def numbers(self) -> dict[str, float]:
        """Every number of :data:`MEASURED`, by name."""
        return {name: float(getattr(self, name)) for name in MEASURED}


MEASURED: Mapping[str, tuple[str, str]] = {
    "pressure_rep": ("E*", "mean repulsive pressure p_rep = N_rep/A_rep"),
    "pressure_att": ("E*", "mean attractive pressure N_att/A_att"),
    "kappa": ("1", "κ = h'rms E* A_rep/N"),
    "kappa_rep": ("1", "κ_rep = h'rms E* A_rep/N_rep"),
    "kappa_att": ("1", "κ_att = h'rms E* A_rep/N_att"),
    "perimeter_cells": ("1", "cells of the perimeter, N_P"),
    "perimeter": ("a0", "perimeter P of A_rep, with the paper's correction 1.1222"),
    "perimeter_exact": ("a0", "perimeter P of A_rep, with the correction 1.1107"),
    "diameter": ("a0", "mean diameter d_rep = π A_rep/P, with the paper's correction"),
    "diameter_exact": ("a0", "mean diameter d_rep, with the correction 1.1107"),
    "chord": ("a0", "mean chord of A_rep in both directions"),
}
"""Unit and description of the numbers that a :class:`Measurement` adds to the totals."""


def measure(grid: Grid, totals: Totals, repulsive: Mask, rms_slope: float) -> Measurement:
    """Measure the numbers of the paper on one state.

    Parameters
    ----------
    totals : areas and loads, from :func:`totals_of`.
    repulsive : the cells of A_rep: ``contact_map(wall, gap) == REPULSIVE``, or the map stored with a run.
    rms_slope : h'rms of the undeformed surface; its spectral moment, not the target of its synthesis.

    Raises ValueError if the map does not fit the grid, or the areas.
    """
    rim = outline(grid, repulsive)
    if abs(rim.cells - totals.area_rep * grid.size) > 0.5:
        msg = f"the map has {rim.cells} cells, but A_rep/A0 = {totals.area_rep} is {totals.area_rep * grid.size:g}"
        raise ValueError(msg)
    return Measurement(totals, rim, rms_slope)
