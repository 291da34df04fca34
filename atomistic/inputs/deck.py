"""The input file of a deck, table by table.  Lengths are in a0, pressures in E*.

Keys of quantities accept text with a unit, as "10m/s", "5ps", "1GPa", "2.5Å", "20nN" or "300K", if the crystal has a
length scale, which is known once it has been measured.
"""

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from atomistic.inputs.crystal import CrystalTable, DeckSlabTable, DeckSolverTable, Interatomic
from atomistic.inputs.motion import ProtocolTable, Steps, beyond_strength
from atomistic.lammps.crystal_wall import OWN, WallCrystal
from continuum.inputs.keys import Fraction, InputFile
from continuum.inputs.reading import parsed, source_of
from continuum.inputs.tables import Fault, Key, constraint
from continuum.inputs.toml import Document, Source
from continuum.inputs.units import Motion, Quantity, Units, parse, readable
from continuum.maps.map import Topography, sizes_of, units_of
from continuum.maps.mending import wall_from_map
from continuum.maps.reading import read_topography
from continuum.maps.verdict.tables import Length
from continuum.model.grid import Grid
from continuum.model.surface import Surface
from continuum.model.walls import Wall
from continuum.store.runs import config as config  # defines the tables that an input knows

QUANTITIES: dict[str, Quantity | Motion] = {
    **dict.fromkeys(
        ("separation", "separations", "distance", "depth", "radius", "flat_radius", "edge_radius", "amplitude",
         "rms_height", "lambda_s", "lambda_L", "range", "effective_range", "decay_length", "adhesion_length"), "length"
    ),
    "pressures": "pressure",
    "pressure": "pressure",
    "surface_energy": "energy_per_area",
    "velocity": "velocity",
    "window": "time",
    "damping": "time",
    "temperature": "temperature",
}  # fmt: skip
"""Keys of the input of a deck that accept a unit, with their quantity."""
_TABLES = ("slab", "surface", "wall", "protocol")
_REDUCED: dict[Quantity | Motion, str] = {
    "length": "a0",
    "pressure": "E*",
    "energy_per_area": "E* a0",
    "force": "E* a0²",
    "velocity": "(E* a0³/m)^(1/2)",
    "time": "a0 (m/(E* a0³))^(1/2)",
    "temperature": "E* a0³",
}
MOST_STEPS = 10_000
"""Equilibria of a protocol."""


def with_units(data: Mapping[str, Any]) -> list[Key]:
    """Keys of an input whose value is or contains a text with a unit, except temperatures."""
    return [
        key
        for key, value in _quantities(data)
        if key[-1] != "temperature" and any(isinstance(item, str) for item in _items(value))
    ]


def in_reduced(data: Mapping[str, Any], units: Units | None) -> tuple[dict[str, Any], list[Fault]]:
    """The input with texts with units replaced by reduced numbers, and the faults of these texts.

    Parameters
    ----------
    data : tables and keys of an input, or of a part of it.
    units : units of the crystal; None if it has no length scale.
    """
    found: dict[str, Any] = {n: dict(value) if isinstance(value, Mapping) else value for n, value in data.items()}
    faults = []
    for key in with_units(data):
        table, name = found[str(key[0])] if len(key) == 2 else found, str(key[-1])
        quantity = QUANTITIES[name]
        try:
            if units is None:
                raise ValueError("this crystal has no length scale, and so no units")
            table[name] = _number(table[name], quantity, units)
        except ValueError as error:
            allowed = f"a number, in {_REDUCED[quantity]}"
            if units is not None:
                size = readable(units.si(quantity), quantity)
                allowed += f"; or one with its unit, as {size.replace(' ', '')!r}, which 1 is"
            faults.append(Fault(key, allowed, str(error)))
    return found, faults


def in_both(data: Mapping[str, Any], units: Units | None, rest: Units | None = None) -> Iterator[tuple[str, str]]:
    """Quantities of an input in reduced and real units, if its crystal has a length scale: dotted keys and texts.

    Temperatures are in units of the crystal at ``rest``, if that is another one.
    """
    if units is None:
        return
    for key, value in _quantities(in_reduced(data, units)[0]):
        quantity, name = QUANTITIES[str(key[-1])], ".".join(map(str, key))
        size = (rest or units if quantity == "temperature" else units).si(quantity)
        if isinstance(value, str):  # a temperature
            value = parse(value, quantity, signed=True) / size
        numbers = [number for number in _items(value) if isinstance(number, int | float)]
        shown = numbers if len(numbers) <= 4 else [numbers[0], numbers[-1]]
        join = ", " if len(numbers) <= 4 else " ... "
        if shown:
            real = join.join(readable(number * size, quantity) for number in shown)
            if key[-1] == "adhesion_length":  # l_a = w/E*
                real += "; w = " + join.join(
                    readable(units.to_si(n, "energy_per_area"), "energy_per_area") for n in shown
                )
            yield name, f"{join.join(f'{number:.4g}' for number in shown)} {_REDUCED[quantity]} = {real}"


def _quantities(data: Mapping[str, Any]) -> Iterator[tuple[Key, Any]]:
    """Keys that take a unit, with their values: of the top and of the tables of a deck."""
    for name, value in data.items():
        if isinstance(value, Mapping) and name in _TABLES:
            yield from (((name, inner), item) for inner, item in value.items() if inner in QUANTITIES)
        elif name in QUANTITIES:
            yield (name,), value


def _items(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else [value]


def _number(value: Any, quantity: Quantity | Motion, units: Units) -> Any:
    """A value, or each of a list, in reduced units."""
    if isinstance(value, list | tuple):
        return [_number(item, quantity, units) for item in value]
    return parse(value, quantity, signed=True) / units.si(quantity) if isinstance(value, str) else value


class DeckSurface(Surface):
    """[surface] of a deck: those of a run, and parts of measured maps."""

    kind_key: ClassVar[str] = "kind"


class TopographySurface(DeckSurface, kind="topography"):
    """[surface] of kind "topography": part of a measured map, at points about a0 apart: above each atom of fcc(100)."""

    newer: ClassVar[frozenset[str]] = frozenset({"void", "fill"})

    path: InputFile
    """map of heights: npy, text, HDF5, or a format of SurfaceTopography"""
    edges: Literal["mirror", "window"] = "mirror"
    """method to make it periodic: mirror images, or a window that brings it to its mean"""
    centre: tuple[Fraction, Fraction] = (0.5, 0.5)
    """centre of the part, as fractions of the map"""
    size: str | None = None
    """size LX or LX,LY of the map with its unit, as "100nm"; only if the file does not have it"""
    unit: str | None = None
    """unit of the heights, as "nm", or of positions and heights, as "um,nm"; only if the file does not have it"""
    dataset: str | None = None
    """in an HDF5 file"""
    part: str | None = None
    """name of a map in a container"""
    void: float | None = None
    """number that stands for a missing height, in the unit of the file"""
    fill: Annotated[float, Field(gt=0, le=0.5)] | None = None
    """share of the points up to which missing heights are filled (default: 0.01)"""
    spacing: Length | None = None
    """a0 with its unit, as "0.3nm", if the crystal has no length scale"""

    @constraint
    def _lengths(self) -> Iterator[Fault]:
        for key, read in (("size", sizes_of), ("unit", units_of)):
            try:
                read(self.path.name, getattr(self, key))
            except ValueError as error:
                yield Fault((key,), str(error))

    def read(self, n: tuple[int, int], spacing: tuple[float, float]) -> Topography:
        """The wall, in m, at n points with these spacings, in m, along x and along y.

        Raises TopographyError if the file has no such map, or the part does not lie within it.
        """
        void = () if self.void is None else (self.void,)
        given = {"dataset": self.dataset, "part": self.part, "void": void}
        found = topography_of(self.path, size=self.size, unit=self.unit, fill=self.fill or 0.0, **given)
        return wall_from_map(found, n, spacing, self.edges, self.centre)


def topography_of(path: Path, *, size: str | None, unit: str | None, fill: float, **given: Any) -> Topography:
    """Read a measured map, with the texts by which an input or a command says size and unit."""
    of_heights, of_positions = units_of(path.name, unit)
    return read_topography(
        path, size=sizes_of(path.name, size), unit=of_heights, position_unit=of_positions, fill=fill, **given
    )


class SeparationsTable(ProtocolTable):
    """[protocol] of kind "separations": equilibria at several separations."""

    kind: Literal["separations"]
    separations: Annotated[tuple[float, ...], Field(min_length=1, max_length=MOST_STEPS)]
    """heights of the plane h = 0 of the wall above the surface at rest, in a0, in order"""
    retract: bool = False
    """whether to go back through the same values"""

    def steps(self) -> Steps:
        back = self.separations[-2::-1] if self.retract else ()
        return Steps("separation", self.separations + back)


class MeanPressuresTable(ProtocolTable):
    """[protocol] of kind "mean-pressures": equilibria at several mean pressures."""

    kind: Literal["mean-pressures"]
    pressures: Annotated[tuple[float, ...], Field(min_length=1, max_length=MOST_STEPS)]
    """load over A0, in E*, compression positive, from -1 to 1"""

    @constraint
    def _within_the_strength(self) -> Iterator[Fault]:
        yield from beyond_strength("pressures", *self.pressures)
        if 0 in self.pressures:
            yield Fault(("pressures",), "other than zero: the tolerance is relative to the pressure")

    def steps(self) -> Steps:
        return Steps("mean-pressure", self.pressures)


class _Parts(Document):
    """Tables of an input that arguments of a call may be."""

    protocol: ProtocolTable | None = None
    """the protocol"""
    crystal: CrystalTable = CrystalTable()
    """the crystal and its face"""
    wall_crystal: WallCrystal = OWN
    """the crystal of a wall of atoms"""


def steps_of(protocol: Mapping[str, Any]) -> Steps:
    """The steps of a table [protocol]; its numbers may be NumPy's.

    Raises ConfigError with all faults of the table.
    """
    plain = {name: v.tolist() if isinstance(v, np.ndarray | np.generic) else v for name, v in protocol.items()}
    table = parsed(Source(Path("protocol"), "", {"protocol": plain}), _Parts).protocol
    assert table is not None
    return table.steps()


def crystals_of(**given: Mapping[str, Any]) -> tuple[CrystalTable, WallCrystal]:
    """The crystals of tables [crystal] and [wall_crystal], if they are given; their numbers may be NumPy's.

    Raises ConfigError with all faults of the tables.
    """
    parts = parsed(source_of(given, " and ".join(given)), _Parts)
    return parts.crystal, parts.wall_crystal


class DeckConfig(Document):
    """Input of ``atomistic deck``."""

    interatomic: Interatomic
    """what holds the atoms together"""
    crystal: CrystalTable = CrystalTable()
    """the crystal and its face, if it is not fcc(100)"""
    slab: DeckSlabTable
    surface: DeckSurface
    """heights of the rigid wall above each surface atom"""
    wall: Wall
    """law between wall and surface"""
    follows: Literal["site", "atom"] = "site"
    """where the height of the wall is taken: above the lattice site of an atom, as in the paper ("site"), or above its
    position ("atom"), which also gives a lateral force"""
    wall_force: Literal["formulas", "plugin", "atoms"] = "formulas"
    """how the wall acts: by formulas of LAMMPS, by a faster plugin that a C++ compiler builds here, or by the atoms of
    a rigid crystal that follows the heights, with a pair law of the same work of adhesion"""
    wall_crystal: WallCrystal = OWN
    """the crystal of a wall of atoms"""
    separation: float | None = None
    """height of the plane h = 0 of the wall above the surface at rest, in a0: one equilibrium"""
    protocol: ProtocolTable | None = None
    """several steps, instead of separation"""
    solver: DeckSolverTable = DeckSolverTable()

    @cached_property
    def grid(self) -> Grid:
        """The grid of the wall: the surface atoms of fcc(100), else points about a0 apart."""
        lengths = self.crystal.width(self.slab.n)
        return Grid((max(2, round(lengths[0])), max(2, round(lengths[1]))), lengths)

    @constraint
    def _has_a_width(self) -> Iterator[Fault]:
        if (self.slab.n == (0, 0)) != (self.crystal.atoms is not None):
            yield Fault(("slab", "n"), "a number of atoms; left out with atoms of a file, which have their own period")

    @constraint
    def _stands_on_a_grid(self) -> Iterator[Fault]:
        if not self.crystal.own and self.wall_force == "atoms":
            yield Fault(("wall_force",), "another one above this crystal: walls of atoms stand above fcc(100)")

    @constraint
    def _fits_the_surface(self) -> Iterator[Fault]:
        if (self.slab.n == (0, 0)) != (self.crystal.atoms is not None) or any(self.crystal.faults()):
            return
        yield from self.surface.too_short(self.grid.shape, self.grid.lengths)
        yield from self.surface.too_long(self.grid.shape, self.grid.lengths)

    @constraint
    def _native(self) -> Iterator[Fault]:
        if not self.wall.has_law:
            cause = "its traction is not a function of the gap; use range = 0 for a repulsive wall"
            yield Fault(("wall", "law"), 'a law with a traction, such as "lennard-jones-spline"', cause)

    @constraint
    def _something_is_done(self) -> Iterator[Fault]:
        if (self.separation is None) == (self.protocol is None):
            cause = "both are given" if self.protocol is not None else "neither is given"
            yield Fault(("separation",), "exactly one of separation and a table [protocol]", cause)

    @constraint
    def _slides(self) -> Iterator[Fault]:
        if self.protocol is not None and self.protocol.slides and self.follows == "site":
            cause = "a wall of the lattice sites cannot slide"
            yield Fault(("follows",), '"atom" with a protocol of kind "sliding"', cause)

    @constraint
    def _of_atoms(self) -> Iterator[Fault]:
        if self.wall_force == "atoms" and self.follows == "site":
            cause = "atoms of the wall act at the positions of the atoms, not at lattice sites"
            yield Fault(("follows",), '"atom" with wall_force = "atoms"', cause)

    @constraint
    def _has_a_crystal(self) -> Iterator[Fault]:
        if self.wall_force != "atoms" and self.wall_crystal != OWN:
            yield Fault(("wall_crystal",), 'a table of a wall with wall_force = "atoms"')

    def steps(self) -> Steps:
        if self.protocol is not None:
            return self.protocol.steps()
        assert self.separation is not None
        return Steps("separation", (self.separation,), single=True)
