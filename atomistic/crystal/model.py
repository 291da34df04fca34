"""Models of the substrate: interatomic potentials, and their fcc crystals at zero pressure in units of a0 and E*.

A :data:`Potential` is a frozen set of parameters in the units that LAMMPS is given, ``lj`` (pure numbers) or ``metal``
(eV, Å).  Other modules use these members only, so that a further potential is one more class, named here::

    units, atom_style    styles of LAMMPS
    mass, element        of an atom; the element is "X", ASE's symbol for none, if the model has none
    masses, elements     of all types of atoms, of which an alloy has several
    cutoff               of the formulas
    force_range          largest distance at which a displaced atom changes forces
    guess                volume per atom of the fcc crystal, roughly; 0 if unknown
    files                contents of the files that its commands read, by the names that they use
    names                names of these files as they were given, by the names that commands use
    identity             names and numbers that determine results
    reference            source of the model, stored with results
    settings()           LAMMPS commands that come before the atoms are read
    interactions()       LAMMPS commands that define the forces, on the perfect lattice

With its crystal it is a :data:`Model`: springs are one already, all others become one by measuring that crystal
(:func:`atomistic.response.material.measure_crystal`).  Its further members, in units of a0 and E*::

    density              atoms per a0³
    normal_stiffness     pressure per strain across the slab, which is as wide as before
    stiffest             ω² of the stiffest vibration, of an atom of the mass 1
    timestep             a stable time step of damped dynamics with unit masses, in a0 (m/(E* a0³))^(1/2)
    length, energy       a0 and E* a0³ in LAMMPS' units; E* a0² is their quotient in that of force
    real_units           size of a0 and E* in SI; None for a crystal without length scale
    expands              whether it is a crystal that expands when it is warm, and then has further members:
    supercell            a periodic block of it, :class:`Supercell`
    dilation             pressure per strain along all axes
    stretched(stretch)   the model with longer distances, by a factor

A model of fcc(100) also has, for its lattice response::

    lattice_constant     edge of the cubic cell at zero pressure: sqrt(2), so that surface atoms are a0 apart
    harmonic             whether forces are linear in the stretch of fixed bonds, so that the response is exact
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Self, TypeGuard

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.faces import CrystalCell
from atomistic.crystal.interatomic import LennardJones, OfCube, Springs
from atomistic.crystal.potentials import EmbeddedAtom, PairStyle
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.units import Units
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.crystal import (
    CubicConstants,
    anisotropic_contact_modulus,
    contact_modulus,
    directional_contact_modulus,
)

_DIRECTIONS = 128


@dataclass(frozen=True)
class Crystal:
    """An fcc crystal at zero pressure, in the units of its potential: lengths, energies, energies per volume."""

    lattice_constant: float
    """Edge of the cubic cell."""
    energy: float
    """Energy per atom."""
    constants: CubicConstants
    others: Mapping[str, float]
    """Energy per atom of other structures at their best volume."""


def _of_potential(name: str) -> Any:
    """A member of a model that is that of its potential."""
    return property(attrgetter(f"potential.{name}"))


class OfPotential:
    """Members of a model that are those of its potential."""

    potential: Any

    if TYPE_CHECKING:

        @property
        def length(self) -> float: ...

        @property
        def contact_modulus(self) -> float: ...

        @property
        def mass(self) -> float: ...

        @property
        def stiffest(self) -> float: ...

    units = _of_potential("units")
    atom_style = _of_potential("atom_style")
    element = _of_potential("element")
    elements = _of_potential("elements")
    masses = _of_potential("masses")
    cutoff = _of_potential("cutoff")
    force_range = _of_potential("force_range")
    files = _of_potential("files")
    names = _of_potential("names")
    identity = _of_potential("identity")
    reference = _of_potential("reference")
    settings = _of_potential("settings")
    interactions = _of_potential("interactions")

    @property
    def timestep(self) -> float:
        """0.1/√k of the springs of :attr:`stiffest`.

        Half that of springs: bonds of atoms grow several times stiffer where they are compressed, and FIRE's step,
        which grows to 3 of these, would no longer be stable.
        """
        return 0.1 / float(np.sqrt(self.stiffest / 8))

    @property
    def energy(self) -> float:
        return self.contact_modulus * self.length**3

    @property
    def real_units(self) -> Units | None:
        """Size of a0 and E*; None for Lennard-Jones, which has no length scale."""
        return Units.metal(self.length, self.contact_modulus, self.mass) if self.units == "metal" else None


class Supercell(NamedTuple):
    """A periodic block of a crystal."""

    edge: float
    """Unit of its sites and periods, in a0."""
    sites: Real
    periods: Real
    types: NDArray[np.int64]
    """Index of the element of each atom, from 0."""
    volume: float
    """Volume of the block, in a0³."""


_CELLS = 4
"""Cubic cells along each side of a block of fcc: 256 atoms."""
_SIDE = 6.0
"""Side of a block of another crystal, in a0: some 200 to 300 atoms."""


@dataclass(frozen=True)
class CrystalModel(OfPotential, OfCube):
    """A potential and its crystal, in units of a0 and E*: a :class:`~atomistic.crystal.interatomic.Model`."""

    potential: Potential
    crystal: Crystal
    harmonic: Literal[False] = field(default=False, init=False)
    expands: Literal[True] = field(default=True, init=False)

    mass = _of_potential("mass")

    @property
    def guess(self) -> float:
        return self.crystal.lattice_constant**3 / 4

    @property
    def lattice_constant(self) -> float:
        return float(np.sqrt(2))

    @property
    def length(self) -> float:
        return self.crystal.lattice_constant / float(np.sqrt(2))

    @cached_property
    def contact_modulus(self) -> float:
        """Mean E*(100), in LAMMPS' units of energy per volume."""
        return contact_modulus(self.crystal.constants)

    @property
    def elastic_constants(self) -> CubicConstants:
        return CubicConstants(*(c / self.contact_modulus for c in self.crystal.constants))

    @property
    def dilation(self) -> float:
        c11, c12, _ = self.elastic_constants
        return c11 + 2 * c12

    @property
    def supercell(self) -> Supercell:
        corners = np.stack(np.meshgrid(*3 * [np.arange(_CELLS)], indexing="ij"), axis=-1).reshape(-1, 1, 3)
        sites = (corners + np.array([[0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]]) / 2).reshape(-1, 3)
        edge, none = np.sqrt(2), np.zeros(len(sites), np.int64)
        return Supercell(edge, sites, np.full(3, float(_CELLS)), none, _CELLS**3 * np.sqrt(8))

    def stretched(self, stretch: float) -> CrystalModel:
        crystal = replace(self.crystal, lattice_constant=self.crystal.lattice_constant * stretch)
        return replace(self, crystal=crystal)

    @property
    def coupled_layers(self) -> int:
        # A layer exactly at the range, where forces are zero, does not count.
        return max(1, int(np.ceil(self.force_range / self.length / LAYER_SPACING - 1e-9)) - 1)


@dataclass(frozen=True, eq=False)
class AnyCrystalModel(OfPotential):
    """A potential and its crystal below any face, or atoms that are given: what a deck of them needs of it.

    Parameters
    ----------
    potential : in its own units.
    length : a0, the distance of nearest neighbours, in LAMMPS' unit.
    contact_modulus : mean E* of the face, in LAMMPS' unit of energy per volume.
    tensor : C_ijkl along the axes of the face, in E*, shape (3, 3, 3, 3).
    density : atoms per a0³.
    stiffest : ω² of the stiffest vibration, of an atom of the mean mass, in E* a0.
    mass : mean of the atoms.
    cell : of the crystal, at zero pressure; None for atoms that are given.
    """

    potential: Potential
    length: float
    contact_modulus: float
    tensor: Real = field(repr=False)
    density: float
    mass: float
    cell: CrystalCell | None = field(repr=False)
    stiffest: float = 8.0

    @property
    def identity(self) -> Mapping[str, Any]:
        return {**self.potential.identity, "crystal": "given" if self.cell is None else self.cell.name}

    @property
    def expands(self) -> bool:
        return self.cell is not None and self.atom_style == "atomic"

    @property
    def dilation(self) -> float:
        return float(np.einsum("iijj", self.tensor)) / 3

    @property
    def supercell(self) -> Supercell:
        assert self.cell is not None
        x, y, z = (max(1, round(_SIDE / period)) for period in self.cell.periods)
        sites, types = self.cell.repeated((x, y, z))
        periods = self.cell.periods * np.array([x, y, z])
        return Supercell(1.0, sites, periods, types, float(np.prod(periods)))

    def stretched(self, stretch: float) -> AnyCrystalModel:
        return replace(self, length=self.length * stretch)

    @property
    def reach(self) -> float:
        """Largest distance at which a displaced atom changes forces, in a0."""
        return float(self.force_range / self.length)

    @property
    def normal_stiffness(self) -> float:
        """Pressure per strain across the slab, 1/(nn)⁻¹_zz: layers may shift."""
        return float(1 / np.linalg.inv(self.tensor[2, :, :, 2])[2, 2])

    def moduli(self, count: int = 64) -> Real:
        """E*(θ) over so many wavevectors, from the x axis of the face through half a turn, in E*."""
        return anisotropic_contact_modulus(self.tensor, np.arange(count) * np.pi / count)

    def stiffness_q(self, grid: Grid, depth: float) -> Real:
        """K_q of the half-space of the crystal, at q = 0 that of a slab of the depth; shape ``grid.shape_q``, in E*/a0.

        E*(θ) has the period π: a Fourier series, exact to rounding unless the crystal is close to an instability.
        """
        series, (qx, qy) = np.fft.rfft(self.moduli()) / 64, grid.wavevectors
        series[1:-1] *= 2
        turn = np.exp(2j * np.arctan2(qy, qx))
        found = np.polynomial.polynomial.polyval(turn, series).real * grid.wavenumber / 2
        found[0, 0] = self.normal_stiffness / depth
        return np.asarray(found)


Model = Springs | CrystalModel
"""Models of fcc(100), one atom for one point of a grid, of which there is a lattice response."""
AnyModel = Model | AnyCrystalModel
Potential = Model | LennardJones | EmbeddedAtom | PairStyle


def check_potential(name: str, value: Any) -> Potential:
    """Check that an argument is an interatomic model, measured or not; raises ArgumentError otherwise."""
    if not isinstance(value, Potential):
        models = "Springs(), LennardJones(), EmbeddedAtom.read(...), PairStyle(...)"
        raise ArgumentError(name, value, f"an interatomic model: {models}")
    return value


def is_model(value: Any) -> TypeGuard[Model]:
    """True if the crystal of a potential has been measured, or needs no measurement."""
    return isinstance(value, Model)


def check_model(name: str, value: Any) -> Model:
    """Check that an argument is an interatomic model with its crystal; raises ArgumentError otherwise."""
    if not is_model(value):
        raise ArgumentError(name, value, "a model whose crystal is known: Springs(), or elastic(...).model")
    return value


def measured(model: Model) -> CrystalModel | None:
    """The measured crystal of a model; None for springs, whose constants are exact lattice sums."""
    return model if isinstance(model, CrystalModel) else None


@dataclass(frozen=True, eq=False)
class ContactModulus:
    """E*(θ) of the (100) surface, for wavevectors at angles θ to the cubic axis <100>, in the unit of the constants."""

    angles: Real = field(repr=False)
    """θ over a period, from <100> by <110> at π/4 to the next <100>, in radians."""
    values: Real = field(repr=False)
    """Contact modulus E*(θ), same shape."""
    mean: float
    """1/<1/E*>: the mean of the compliance is the compliance of the axially symmetric part of the response."""

    @classmethod
    def of(cls, constants: CubicConstants) -> Self:
        """Contact modulus from elastic constants.

        Raises ValueError if the crystal is not stable.
        """
        angles = np.arange(_DIRECTIONS + 1, dtype=np.float64) * (np.pi / 2 / _DIRECTIONS)
        values = directional_contact_modulus(constants, angles)
        return cls(angles, values, contact_modulus(constants, _DIRECTIONS))

    @property
    def smallest(self) -> float:
        """Contact modulus in the softest direction."""
        return float(self.values.min())

    @property
    def largest(self) -> float:
        """Contact modulus in the stiffest direction."""
        return float(self.values.max())

    @property
    def along_100(self) -> float:
        """Contact modulus along <100>, θ = 0."""
        return float(self.values[0])

    @property
    def along_110(self) -> float:
        """Contact modulus along <110>, θ = π/4: the rows of nearest neighbours and the axes of the surface grid."""
        return float(self.values[_DIRECTIONS // 2])
