"""A wall of atoms: a rigid fcc crystal that follows a map of heights, with a pair law to the substrate.

The crystal is fcc(100).  Its first plane is cut along the heights, to half a plane, or bent along them; its rows are
those of the substrate, in whose hollows it stands, or others of the same period, so that the two are incommensurate.
The pair law is V(r) = v(r) - v(c) - (r - c) v'(c) with v(r) = 4 ε ((σ/r)¹² - (σ/r)⁶), that of
``pair_style lj/smooth/linear``, at rest at the distance a0.  Its depth ε is that at which two flat halves, each at its
lattice sites, have the work of adhesion of the law of the wall; and the crystal stands where their load is zero at the
gap where the traction of that law is.  Loads and separations are thus close to those of the smooth wall.  Energy and
load of incommensurate halves are means over all registries.

LAMMPS moves the crystal as atoms of a second type, which have no forces among themselves.
"""

from typing import Literal, NamedTuple

import numpy as np
import scipy

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.model import AnyModel
from atomistic.lammps.language import formatted
from atomistic.lammps.shape import Shape
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.tables import Table
from continuum.model.fourier import Real
from continuum.model.walls import Wall

DATA = "wall.data"
"""File of the atoms of the wall in a deck."""
PAIR = "lj/smooth/linear"
"""LAMMPS' name of the pair law."""
SIGMA = 2 ** (-1 / 6)
"""σ of the pair law, in a0: v(r) is lowest at a0."""
CUTOFF = 2.5 * SIGMA
"""Distance at which the pair law ends, in a0."""
_DEPTH = 2 * CUTOFF
"""Thickness of the crystal above its surface, in a0: more than the cut-off even at slopes of 60 degrees."""
_SPACINGS = 0.8, 1.25
"""Smallest and largest spacing of the atoms of the wall, in a0."""
_REGISTRIES = 6
"""Registries along x and y over which incommensurate halves are averaged: their mean energy then errs by 1e-5, as the
force has a kink at the cut-off."""
LEAST_KEPT = 0.5
"""Part of the rms height of a map that the atoms keep at least."""


class WallCrystal(Table):
    """[wall_crystal]: the crystal of a wall of atoms."""

    form: Literal["cut", "bent"] = "cut"
    """"cut": flat planes end at the heights, in terraces; "bent": each plane follows the heights"""
    rows: tuple[int, int] | None = None
    """(p, q): the period is p spacings of the wall along one row of its atoms and q across, so that its spacing is
    n a0/√(p² + q²), from 0.8 to 1.25 a0, and its rows are turned by atan(q/p); those of the substrate if left out"""

    def lattice(self, size: tuple[int, int]) -> tuple[Real, float, bool]:
        """Sites of two planes over a period of ``size`` sites, shape (2, n, 2), and their spacing, in a0.

        The first plane stands in the middles of the cells of the second.  The last is whether the second plane is one
        of the substrate.  Raises ArgumentError if the period has no such rows.
        """
        n = size[0]
        p, q = self.rows or (n, 0)
        if self.rows is None or (size == (n, n) and {p, q} == {0, n}):
            x, y = np.meshgrid(*map(np.arange, size), indexing="ij")
            corners = np.column_stack([x.ravel(), y.ravel()])
            return np.stack([corners + 0.5, corners]), 1.0, True
        cells = p * p + q * q
        spacing = n / max(cells, 1) ** 0.5
        low, high = _SPACINGS
        if size != (n, n) or min(p, q) < 0 or not low <= spacing <= high:
            allowed = (
                f"(p, q) of 0 or more in a square period, with √(p² + q²) from {n / high:.4g} to {n / low:.4g} for "
                f"{n} sites; here the period is {size[0]} x {size[1]}"
            )
            raise ArgumentError("rows", self.rows, allowed)
        i, j = np.meshgrid(np.arange(-q, p + 1), np.arange(p + q + 1), indexing="ij")
        x, y = p * i + q * j, p * j - q * i  # in n/cells of a0
        inside = (x >= 0) & (x < cells) & (y >= 0) & (y < cells)
        corners = np.column_stack([x[inside], y[inside]])
        middles = corners + np.array([p + q, p - q]) / 2
        return np.stack([middles, corners]) * n / cells % n, float(spacing), False


OWN = WallCrystal()
"""The crystal of the substrate continued upwards, and cut."""


class CrystalWall(NamedTuple):
    """A rigid crystal and its pair law, in a0 and E*."""

    sites: Real
    """Positions of its atoms, shape (n, 3), in a0: x and y over the period, z above the plane h = 0 of the heights."""
    strength: float
    """ε of the pair law, in E* a0³."""
    rms_height: float
    """Rms height of the map at the sites of the substrate, in a0."""
    rms_lost: float
    """Rms difference of the outermost atoms, one in each cell of the crystal, from the map above them, in a0."""
    rms_kept: float
    """Rms height of the map that these atoms keep, in a0: that of the map above them, whose square is less by what they
    lose."""

    @property
    def about(self) -> str:
        """Sentence about the part of the heights that the atoms keep."""
        return (
            f"{len(self.sites)} atoms, which keep an rms height of {self.rms_kept:.3g} a0 of the {self.rms_height:.3g} "
            f"a0 of the map (rms difference {self.rms_lost:.3g} a0)"
        )


def pair_law(r: Real) -> Real:
    """V(r)/ε of two atoms at distances r, in a0."""
    s6, end = (SIGMA / r) ** 6, (SIGMA / CUTOFF) ** 6
    slope = -24 * end * (2 * end - 1) / CUTOFF
    return np.where(r < CUTOFF, 4 * s6 * (s6 - 1) - 4 * end * (end - 1) - (r - CUTOFF) * slope, 0.0)


def energy_of_flat_halves(distance: float, spacing: float = 1.0, commensurate: bool = True) -> float:
    """Energy per area of two flat fcc(100) halves, in ε/a0².

    Parameters
    ----------
    distance : distance of their outermost planes, in a0; 1/√2 in one crystal.
    spacing : spacing of the atoms of the upper half, in a0.
    commensurate : whether they are parts of one crystal; the mean over all registries otherwise.
    """
    reach = int(np.ceil(CUTOFF)) + 1
    x, y = np.meshgrid(*2 * [np.arange(-reach, reach + 1.0)], indexing="ij")
    registries = np.array([*np.ndindex(_REGISTRIES, _REGISTRIES)]).reshape(-1, 2, 1, 1) / _REGISTRIES
    energy = 0.0
    # Planes are counted from the outermost of each half.  Every second one of a crystal stands in the hollows.
    planes = int(CUTOFF / min(1.0, spacing) / LAYER_SPACING) + 1
    for upper, lower in np.ndindex(planes, planes):
        at = np.full((1, 2, 1, 1), 0.5 if (upper + lower) % 2 == 0 else 0.0) if commensurate else registries
        z = distance + (upper * spacing + lower) * LAYER_SPACING
        r = np.sqrt((x - at[:, 0]) ** 2 + (y - at[:, 1]) ** 2 + z**2)
        energy += float(pair_law(r).sum()) / len(at) / spacing**2
    return energy


def flat_halves(spacing: float = 1.0, commensurate: bool = True) -> tuple[float, float]:
    """Equilibrium distance of flat halves, in a0, and their work of adhesion, in ε/a0²."""
    found = scipy.optimize.minimize_scalar(
        energy_of_flat_halves,
        bounds=(0.5, 1.2),
        args=(spacing, commensurate),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return float(found.x), -float(found.fun)


def crystal_wall(wall: Wall, shape: Shape, size: tuple[int, int], crystal: WallCrystal = OWN) -> CrystalWall:
    """The crystal above a period of ``size`` sites.

    Raises ArgumentError if the law of the wall has no work of adhesion, as the pair law attracts; if the period has no
    such rows; or if the atoms keep less than half of the rms height of the map.
    """
    work = float(wall.work_of_adhesion)
    if not (np.isfinite(work) and work > 0):
        raise ArgumentError("wall", wall, "a law with a work of adhesion, which is that of the atoms of the wall")
    columns, spacing, commensurate = crystal.lattice(size)
    rest, unit = flat_halves(spacing, commensurate)
    plane = spacing * LAYER_SPACING
    heights = np.stack([shape.evaluate(*at.T).height for at in columns])
    base = heights if crystal.form == "bent" else np.zeros_like(heights)
    odd = np.array([[0.0], [1.0]])  # which of the planes an atom may belong to
    lowest = base + plane * (odd + 2 * np.ceil((heights - base) / plane / 2 - 0.25 - odd / 2))
    above = lowest + 2 * plane * np.arange(int(_DEPTH / plane / 2 + 0.25) + 1)[:, None, None]
    there = above - heights < _DEPTH
    sites = np.column_stack([np.broadcast_to(columns, (*above.shape, 2))[there], above[there]])
    sites[:, 2] += rest - wall.zero_gap
    outer = np.argmin(lowest, axis=0), np.arange(lowest.shape[1])
    at_sites = shape.evaluate(*np.meshgrid(*(np.arange(float(n)) for n in size), indexing="ij")).height
    lost = float((lowest - heights)[outer].std())
    kept = max(0.0, float(heights[outer].var()) - lost**2) ** 0.5
    found = CrystalWall(sites, work / unit, float(at_sites.std()), lost, kept)
    if found.rms_height > 0 and not found.rms_kept >= LEAST_KEPT * found.rms_height:
        allowed = f'"bent" where planes {plane:.2g} a0 apart are too coarse: {found.about}'
        raise ArgumentError("form", crystal.form, allowed)
    return found


def first_touch(found: CrystalWall) -> float:
    """Smallest separation at which no atom of the wall is closer than σ to one of the flat surface, in a0.

    Closer, their energy grows with the twelfth power, from which neither a minimiser nor a motion can start.
    """
    apart = np.sum((found.sites[:, :2] - np.round(found.sites[:, :2])) ** 2, axis=1)
    return float(np.max(np.sqrt(np.maximum(SIGMA**2 - apart, 0.0)) - found.sites[:, 2]))


def crystal_data(found: CrystalWall, model: AnyModel, size: tuple[int, int], surface: float) -> str:
    """``wall.data``: atoms of the wall at the separation zero, as LAMMPS adds them to those of the slab.

    Parameters
    ----------
    size : period, in sites.
    surface : height of the surface at rest, in a0.
    """
    at = model.length * (found.sites + np.array([0, 0, surface]))
    ends = [*(model.length * n for n in size), at[:, 2].min() - model.length, at[:, 2].max() + model.length]
    x, y, low, high = map(formatted, ends)
    kind = "2 2" if model.atom_style == "bond" else "2"  # molecule and type, or type
    lines = [
        "Atoms of a rigid wall at the separation 0",
        "",
        f"{len(at)} atoms\n2 atom types",
        "",
        f"0 {x} xlo xhi\n0 {y} ylo yhi\n{low} {high} zlo zhi",
        "",
        f"Atoms # {model.atom_style}",
        "",
        *(f"{i} {kind} {' '.join(map(formatted, site))}" for i, site in enumerate(at, 1)),
    ]
    return "\n".join(lines) + "\n"


def interactions_beside(model: AnyModel, strength: float) -> str:
    """Commands for the forces of a substrate, and for the pair law between its atoms and those of the wall, type 2.

    Parameters
    ----------
    strength : ε of the pair law, in E* a0³.
    """
    lines, style, same = list[str](), "", 0
    for line in model.interactions().splitlines():
        command, *words = line.split()
        if command == "pair_style":
            # A style that combines others names one of them in each of its pair_coeff.
            combined = words[0].startswith("hybrid")
            style, words = ("", words[1:]) if combined else (f"{words[0]} ", words)
            same = words.count(PAIR)
            numbered = f"{PAIR} {same + 1}" if same else PAIR
            cutoff, depth, sigma = map(
                formatted, (CUTOFF * model.length, strength * model.energy, SIGMA * model.length)
            )
            lines += [
                f"pair_style      hybrid/overlay {' '.join(words)} {PAIR} {cutoff}",
                f"pair_coeff      1 2 {numbered} {depth} {sigma}",
                "pair_coeff      2 2 none",
                "neigh_modify    exclude type 2 2",
            ]
        elif command == "pair_coeff":
            # Styles that name the element of each type have none for the wall; others are of pairs of type 1.
            types, element = ("* *", " NULL") if model.element in words[2:] else ("1 1", "")
            own = f"{style}{' '.join(words[2:])}{element}".strip()
            lines.append(f"pair_coeff      {types} {own.replace(PAIR, f'{PAIR} 1') if same == 1 else own}")
        else:
            lines.append(line)
    return "\n".join(lines)
