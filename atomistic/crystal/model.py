"""Models of the substrate: interatomic potentials, and their fcc crystals at zero pressure in units of a0 and E*.

A :data:`Potential` is a frozen set of parameters in the units that LAMMPS is given, ``lj`` (pure numbers) or ``metal``
(eV, Å).  Other modules use these members only, so that a further potential is one more class, named here::

    units, atom_style    styles of LAMMPS
    mass, element        of an atom; the element is "X", ASE's symbol for none, if the model has none
    cutoff               of the formulas
    force_range          largest distance at which a displaced atom changes forces
    guess                volume per atom of the fcc crystal, roughly; 0 if unknown
    files                contents of the files that its commands read, by the names that they use
    identity             names and numbers that determine results
    reference            source of the model, stored with results
    settings()           LAMMPS commands that come before the atoms are read
    interactions()       LAMMPS commands that define the forces, on the perfect lattice

With its crystal it is a :data:`Model`: springs are one already, all others become one by measuring that crystal
(:func:`atomistic.response.material.measure_crystal`).  Its further members, in units of a0 and E*::

    lattice_constant     edge of the cubic cell at zero pressure: sqrt(2), so that surface atoms are a0 apart
    harmonic             whether forces are linear in the stretch of fixed bonds, so that the response is exact
    coupled_layers       number of (100) layers that forces reach: the frozen base has at least so many
    elastic_constants    C11, C12, C44
    timestep             a stable time step of damped dynamics with unit masses, in a0 (m/(E* a0³))^(1/2)
    length, energy       a0 and E* a0³ in LAMMPS' units; E* a0² is their quotient in that of force
    real_units           size of a0 and E* in SI; None for a crystal without length scale
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from typing import Any, Literal, Self, TypeGuard

import numpy as np

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.pair_style import PairStyle
from atomistic.crystal.potentials import EmbeddedAtom
from continuum.arguments import ArgumentError
from continuum.model.cubic import CubicConstants, contact_modulus, directional_contact_modulus
from continuum.model.fourier import Real
from continuum.units import Units

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


@dataclass(frozen=True)
class CrystalModel:
    """A potential and its crystal, in units of a0 and E*: a :class:`~atomistic.crystal.interatomic.Model`."""

    potential: Potential
    crystal: Crystal
    harmonic: Literal[False] = field(default=False, init=False)

    units = _of_potential("units")
    atom_style = _of_potential("atom_style")
    mass = _of_potential("mass")
    element = _of_potential("element")
    cutoff = _of_potential("cutoff")
    force_range = _of_potential("force_range")
    files = _of_potential("files")
    identity = _of_potential("identity")
    reference = _of_potential("reference")
    settings = _of_potential("settings")
    interactions = _of_potential("interactions")

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
    def energy(self) -> float:
        return self.contact_modulus * self.length**3

    @property
    def elastic_constants(self) -> CubicConstants:
        return CubicConstants(*(c / self.contact_modulus for c in self.crystal.constants))

    @property
    def coupled_layers(self) -> int:
        # A layer exactly at the range, where forces are zero, does not count.
        return max(1, int(np.ceil(self.force_range / self.length / LAYER_SPACING - 1e-9)) - 1)

    @property
    def timestep(self) -> float:
        """0.1/√k with k = √2 C44 a0 or C11 a0/√2, which are those of springs with the same constants.

        Half that of springs: bonds of atoms grow several times stiffer where they are compressed, and FIRE's step,
        which grows to 3 of these, would no longer be stable.
        """
        c11, _, c44 = self.elastic_constants
        return 0.1 / float(np.sqrt(max(np.sqrt(2) * c44, c11 / np.sqrt(2))))

    @property
    def real_units(self) -> Units | None:
        """Size of a0 and E*; None for Lennard-Jones, which has no length scale."""
        return Units.metal(self.length, self.contact_modulus, self.mass) if self.units == "metal" else None


Model = Springs | CrystalModel
Potential = Model | LennardJones | EmbeddedAtom | PairStyle


def check_potential(name: str, value: Any) -> Potential:
    """Check that an argument is an interatomic model, measured or not; raises ArgumentError otherwise."""
    if not isinstance(value, Potential):
        models = "Springs(), LennardJones(), EmbeddedAtom.read(...), PairStyle(...)"
        raise ArgumentError(name, value, f"an interatomic model: {models}")
    return value


def is_model(value: Any) -> TypeGuard[Model]:
    """Whether the crystal of a potential has been measured, or needs no measurement."""
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
        """θ = π/4: along the rows of nearest neighbours, which are the axes of the surface grid."""
        return float(self.values[_DIRECTIONS // 2])
