"""A wall of atoms: a rigid fcc crystal, cut along a map of heights, with a pair law to the substrate.

The crystal is that of the substrate continued upwards, fcc(100) of the spacing a0, in the hollows of the surface at
rest.  The pair law is V(r) = v(r) - v(c) - (r - c) v'(c) with v(r) = 4 ε ((σ/r)¹² - (σ/r)⁶), that of
``pair_style lj/smooth/linear``, at rest at the distance a0.  Its depth ε is that at which two flat halves, each at its
lattice sites, have the work of adhesion of the law of the wall; and the crystal stands where their load is zero at the
gap where the traction of that law is.  Loads and separations are thus close to those of the smooth wall.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.lammps.language import formatted
from atomistic.lammps.shape import Shape
from continuum.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.walls import Wall

SIGMA = 2 ** (-1 / 6)
"""σ of the pair law, in a0: v(r) is lowest at a0."""
CUTOFF = 2.5 * SIGMA
"""Distance at which the pair law ends, in a0."""
_DEPTH = 2 * CUTOFF
"""Thickness of the crystal above its surface, in a0: more than the cut-off even at slopes of 60 degrees."""


class CrystalWall(NamedTuple):
    """A rigid crystal and its pair law, in a0 and E*."""

    sites: Real
    """Positions of its atoms, shape (n, 3), in a0: x and y over the period, z above the plane h = 0 of the heights."""
    strength: float
    """ε of the pair law, in E* a0³."""


def pair_law(r: Real) -> Real:
    """V(r)/ε of two atoms at distances r, in a0."""
    s6, end = (SIGMA / r) ** 6, (SIGMA / CUTOFF) ** 6
    slope = -24 * end * (2 * end - 1) / CUTOFF
    return np.where(r < CUTOFF, 4 * s6 * (s6 - 1) - 4 * end * (end - 1) - (r - CUTOFF) * slope, 0.0)


def energy_of_flat_halves(distance: float) -> float:
    """Energy per area of two flat fcc(100) halves in one registry, in ε/a0².

    Parameters
    ----------
    distance : distance of their outermost planes, in a0; 1/√2 in one crystal.
    """
    reach = int(np.ceil(CUTOFF)) + 1
    x, y = np.meshgrid(*2 * [np.arange(-reach, reach + 1.0)], indexing="ij")
    energy = 0.0
    # k and l count planes from the outermost of each half: an atom of the one over the plane of the other, one for
    # each a0²; every second plane stands in the hollows of those beside it.
    for planes in range(int(CUTOFF / LAYER_SPACING) + 1):
        hollow = 0.5 if planes % 2 == 0 else 0.0
        r = np.sqrt((x - hollow) ** 2 + (y - hollow) ** 2 + (distance + planes * LAYER_SPACING) ** 2)
        energy += (planes + 1) * float(pair_law(r).sum())  # k + l = planes
    return energy


def flat_halves() -> tuple[float, float]:
    """Equilibrium distance of flat halves, in a0, and their work of adhesion, in ε/a0²."""
    found = minimize_scalar(energy_of_flat_halves, bounds=(0.5, 1.2), method="bounded", options={"xatol": 1e-12})
    return float(found.x), -float(found.fun)


def crystal_wall(wall: Wall, shape: Shape, size: tuple[int, int]) -> CrystalWall:
    """The crystal above a period: all sites whose plane is not below the heights, to half a plane.

    Raises ArgumentError if the law of the wall has no work of adhesion, as the pair law attracts.
    """
    work = float(wall.work_of_adhesion)
    if not (np.isfinite(work) and work > 0):
        raise ArgumentError("wall", wall, "a law with a work of adhesion, which is that of the atoms of the wall")
    rest, unit = flat_halves()
    found = []
    x, y = np.meshgrid(*(np.arange(n, dtype=np.float64) for n in size), indexing="ij")
    heights = [shape.evaluate(x + hollow, y + hollow).height for hollow in (0.5, 0.0)]
    lowest = round(min(map(np.min, heights)) / LAYER_SPACING) - 1
    highest = round((max(map(np.max, heights)) + _DEPTH) / LAYER_SPACING)
    for plane in range(lowest, highest + 1):
        hollow, z = (0.5, 0.0)[plane % 2], plane * LAYER_SPACING
        above = z - heights[plane % 2]
        here = (above >= -LAYER_SPACING / 2) & (above < _DEPTH)
        found.append(np.column_stack([x[here] + hollow, y[here] + hollow, np.full(np.count_nonzero(here), z)]))
    sites = np.concatenate(found)
    sites[:, 2] += rest - wall.zero_gap
    return CrystalWall(sites, work / unit)


def first_touch(found: CrystalWall) -> float:
    """Smallest separation at which no atom of the wall is closer than σ to one of the flat surface, in a0.

    Closer, their energy grows with the twelfth power, from which neither a minimiser nor a motion can start.
    """
    apart = np.sum((found.sites[:, :2] - np.round(found.sites[:, :2])) ** 2, axis=1)
    return float(np.max(np.sqrt(np.maximum(SIGMA**2 - apart, 0.0)) - found.sites[:, 2]))


def crystal_text(found: CrystalWall, size: tuple[int, int]) -> str:
    """``wall.crystal``: atoms of the wall and their pair law, as the plugin reads them."""
    lines = [
        "# Atoms of a rigid wall and their pair law, for fix wall/crystal: crystal.cpp says what stands here.  "
        "Units: a0, E*.",
        f"law {formatted(found.strength)} {formatted(SIGMA)} {formatted(CUTOFF)}",
        f"period {size[0]} {size[1]}",
        f"atoms {len(found.sites)}",
    ]
    return "\n".join([*lines, *(" ".join(map(formatted, site)) for site in found.sites)]) + "\n"
