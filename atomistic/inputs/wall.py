"""The wall of a LAMMPS script, from a map, a contact or a formula, a law, and sizes with their units, all judged."""

import os
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast, get_args

import numpy as np
from pydantic import ConfigDict

from atomistic.crystal.crystal import exposed, layer_depth
from atomistic.crystal.faces import read_atoms, spacing_of
from atomistic.inputs.deck import topography_of
from atomistic.lammps.include import DEEP, UnitStyle, WallInclude
from atomistic.lammps.law import native_law
from atomistic.lammps.shape import Shape, check_shape, shape_of
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError, choice, count, file_name, instance, pair
from continuum.inputs.reading import load
from continuum.inputs.toml import Document, find
from continuum.inputs.units import ANGSTROM, GPA_PER_EV_PER_A3, parse
from continuum.maps.map import FEWEST, share
from continuum.maps.mending import wall_from_map
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.model.walls.spline import LARGEST_RANGE

_HEAD = 100
"""Lines of a data file of LAMMPS among which its box stands."""
_ALIKE = 0.02
"""Relative difference of two periods up to which the wall is stretched to the box, as in its script."""

_LEAST = {"mirror": 2 * FEWEST, "window": FEWEST}
"""Points a side, about a0 apart, of a part of a map: mirror images take half of it."""
Edges = Literal["mirror", "window", "periodic"]
"""How a map becomes periodic: a part of the size of the box by mirror images or a window; or the whole as it is."""


class LawConfig(Document):
    """The law of any input: all other tables are ignored."""

    model_config = ConfigDict(extra="ignore")

    wall: Wall
    """law between wall and surface"""


class SlabFacts(NamedTuple):
    """Facts about the slab that a wall needs."""

    period: tuple[float, float]
    """In Å."""
    exposed: int
    """Number of exposed atoms."""
    layer: float
    """Mean distance of layers of so many atoms, in Å."""


def facts_of(path: Path) -> SlabFacts:
    """Period, exposed atoms and distance of layers of a slab from a file that ASE reads.

    Raises ArgumentError if it has no atoms in a rectangular period.
    """
    allowed = "a file of atoms in a rectangular period that ASE reads, or a data file of LAMMPS"
    try:
        atoms = read_atoms(path, "lammps-data" if _is_data(path) else None)
        lengths, cell = atoms.cell.lengths(), atoms.cell.array
    except Exception as error:  # whatever a reader of ASE raises
        raise ArgumentError("slab", str(path), f"{allowed} ({type(error).__name__}: {error})") from None
    skewed = np.abs(cell[:2] - np.diag(np.diag(cell))[:2]).max() if len(atoms) else np.inf
    if not (lengths[:2] > 0).all() or not skewed <= 1e-6 * lengths[:2].max():
        raise ArgumentError("slab", str(path), allowed)
    top = int(exposed(atoms.positions, cell[:2, :2], spacing_of(atoms)).sum())
    return SlabFacts((float(lengths[0]), float(lengths[1])), top, layer_depth(atoms.positions[:, 2], top))


def _is_data(path: Path) -> bool:
    """True if a file is a data file of LAMMPS, whose name may end in any way."""
    with path.open(encoding="utf-8", errors="replace") as file:
        return any(line.split("#")[0].split()[-2:] == ["xlo", "xhi"] for line in islice(file, _HEAD))


@dataclass(frozen=True)
class MapReading:
    """How a measured map is read and made periodic, as in ``[surface]`` of a deck."""

    edges: Edges = "mirror"
    size: str | None = None
    unit: str | None = None
    fill: str | float | None = None


def include_of(
    surface: Shape | str | Path,
    lengths: tuple[float, float] | None,
    *,
    a0: float | str | None,
    contact_modulus: float | str | None,
    law: Wall | str | Path | None,
    work: str | None,
    slab: str | Path | None,
    period: str | None,
    surface_atoms: int | None,
    layer: str | None,
    units: UnitStyle,
    wall_force: Literal["formulas", "plugin"],
    reading: MapReading,
) -> WallInclude:
    """The wall of these arguments, which are those of :func:`atomistic.front.functions.write_wall`.

    Parameters
    ----------
    lengths : periods of a shape that has none of its own, in a0.
    """
    if a0 is None:
        raise ArgumentError(
            "a0",
            a0,
            'the gap at which the traction vanishes, about the nearest-neighbour distance, as "2.55Å" (--a0)',
        )
    if contact_modulus is None:
        raise ArgumentError("contact_modulus", contact_modulus, 'E* of the slab, as "135GPa" (--estar)')
    spacing = possible.given("a0", a0, "spacing", "A")
    modulus = possible.given("contact_modulus", contact_modulus, "modulus", "eV/A3")
    choice("units", units, ("metal", "real"))
    share(reading.fill)
    choice("wall_force", wall_force, ("formulas", "plugin"))
    facts = None if slab is None else facts_of(file_name("slab", slab))
    wall = _law(law, work, spacing * ANGSTROM * modulus * GPA_PER_EV_PER_A3 * 1e9)
    box = facts.period if facts else _period(period)
    if facts is not None and period is not None:
        raise ArgumentError("period", period, "left out: the slab has its own")
    shape, lengths = _shape(surface, lengths, spacing, box, reading)
    if box is not None and max(abs(b / spacing / own - 1) for b, own in zip(box, lengths, strict=True)) > _ALIKE:
        here = " x ".join(f"{spacing * own:.6g}" for own in lengths)
        raise ArgumentError("period", box, f"that of the wall, {here} Å, within {_ALIKE:.0%}")
    # Without a slab the next layer is taken as out of reach, which holds for short laws: a longer one needs `layer`.
    depth = facts.layer / spacing if facts else np.inf
    if layer is not None:
        try:
            depth = possible.from_text(instance("layer", layer, str, 'a text, as "2.1Å"'), "spacing") / (
                spacing * ANGSTROM
            )
        except ValueError as error:
            raise ArgumentError("layer", layer, f'the distance of layers of atoms, as "2.1Å" ({error})') from None
    elif facts is None and wall.reach > wall.zero_gap + DEEP:
        allowed = f'the distance of layers of atoms, as "2.1Å", or a slab: the law reaches layers deeper than {DEEP} a0'
        raise ArgumentError("layer", layer, allowed)
    atoms = facts.exposed if facts else 0
    if surface_atoms is not None:
        atoms = count("surface_atoms", surface_atoms)
    # Each atom of a plane has 0.87 a0² on fcc(111), 1 on (100), 1.41 on (110): far from these a0 is another length.
    if atoms and not 0.2 < (each := lengths[0] * lengths[1] / atoms) < 10:
        with_it = f"with it, each of {atoms} atoms of the surface has {each:.3g} a0²"
        if surface_atoms is None:
            raise ArgumentError("a0", a0, f"about the distance of neighbours in the slab: {with_it}")
        raise ArgumentError("surface_atoms", surface_atoms, f"the number of atoms of the surface plane: {with_it}")
    return WallInclude(shape, lengths, wall, spacing, modulus, atoms, depth, units, wall_force)


def _law(law: Wall | str | Path | None, work: str | None, unit: float) -> Wall:
    """The law that was given; ``unit`` is E* a0, in J/m²."""
    if (law is None) == (work is None):
        raise ArgumentError("work", work, 'a work of adhesion, as "50mJ/m2" (--work), or a law (--law), and not both')
    if work is not None:
        try:
            length = possible.from_text(instance("work", work, str, 'a text, as "50mJ/m2"'), "work") / unit
        except ValueError as error:
            raise ArgumentError("work", work, f'a work of adhesion, as "50mJ/m2" ({error})') from None
        most = LARGEST_RANGE**2 / 24  # the adhesion length of the spline, in a0, is range²/24
        if length > most:
            allowed = (
                f"at most {most * unit:.3g} J/m² on this solid: the law would reach further than {LARGEST_RANGE:g} a0"
            )
            raise ArgumentError("work", work, allowed)
        found: Wall = LennardJonesSpline(adhesion_length=length)
    elif isinstance(law, str | os.PathLike):
        found = load(file_name("law", law), LawConfig).wall
    else:
        found = instance("law", law, Wall, "a wall law of continuum, or an input with a table [wall]")
    try:
        native_law(found)
    except TypeError as error:
        raise ArgumentError("law", found, f"a law with a traction at each gap: {error}") from None
    return found


def _period(text: str | None) -> tuple[float, float] | None:
    """Lx and Ly of the box, in Å."""
    if text is None:
        return None
    allowed = 'lengths of the box along x and y, as "102Å,88Å"'
    try:
        lengths = [parse(one, "length") / ANGSTROM for one in instance("period", text, str, allowed).split(",")]
    except ValueError as error:
        raise ArgumentError("period", text, f"{allowed} ({error})") from None
    if len(lengths) > 2:
        raise ArgumentError("period", text, allowed)
    return lengths[0], lengths[-1]


def _shape(
    surface: Shape | str | Path,
    lengths: tuple[float, float] | None,
    spacing: float,
    box: tuple[float, float] | None,
    reading: MapReading,
) -> tuple[Shape, tuple[float, float]]:
    """The wall as a function of the position, and its period, in a0."""
    edges = choice("edges", reading.edges, get_args(Edges))
    if not isinstance(surface, str | os.PathLike):
        for name in ("size", "unit", "fill"):
            if value := getattr(reading, name):
                raise ArgumentError(name, value, "left out: only a map, a file, has it")
        shape = check_shape("surface", surface)
        own: Any = lengths or getattr(shape, "period", None)
        if own is None and box is None:
            raise ArgumentError("period", box, 'lengths of the box, as "102Å,88Å": this shape has none of its own')
        x, y = (length / spacing for length in cast("tuple[float, float]", box)) if own is None else pair("period", own)
        return shape, (float(x), float(y))
    path = find(file_name("surface", surface))
    found = topography_of(path, size=reading.size, unit=reading.unit, fill=share(reading.fill))
    if edges == "periodic":
        x, y = (length / ANGSTROM / spacing for length in found.lengths)
        # Summits of a map are lowest in the wall.
        return shape_of(-(found.heights - found.heights.mean()) / (spacing * ANGSTROM), (x, y)), (x, y)
    if box is None:
        raise ArgumentError("period", box, 'lengths of the box, as "102Å,88Å", or a slab: a map is cut to its size')
    # About a0 apart, as above each atom; mirrors need an even number.
    n = (2 * max(2, round(box[0] / spacing / 2)), 2 * max(2, round(box[1] / spacing / 2)))
    if min(n) < _LEAST[edges]:
        allowed = (
            f'a box of at least {_LEAST[edges]} a0 a side for "{edges}", here {n[0]} x {n[1]} a0; "periodic" takes a '
            "map of the size of the box as it is"
        )
        raise ArgumentError("edges", edges, allowed)
    cut = wall_from_map(found, n, (box[0] * ANGSTROM / n[0], box[1] * ANGSTROM / n[1]), edges)
    lengths = (box[0] / spacing, box[1] / spacing)
    return shape_of(cut.heights / (spacing * ANGSTROM), lengths), lengths
