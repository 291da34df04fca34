"""Interatomic models: what holds the atoms of the substrate together.

A model is a frozen set of parameters.  The other modules ask it for the members of :class:`Model` and no
more, so that a further potential is one more class here.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Protocol

import numpy as np

from atomistic.elastic import CubicConstants, contact_modulus
from continuum.grid import Real

__all__ = ["Model", "Springs"]


class Model(Protocol):
    """What a substrate must know of its atoms, in units of a0 and E*."""

    @property
    def lattice_constant(self) -> float:
        """Edge of the cubic cell at zero pressure, in a0: sqrt(2), so that surface atoms are a0 apart."""

    @property
    def reach(self) -> int:
        """Number of (100) layers that forces reach: the frozen base has at least so many."""

    @property
    def elastic_constants(self) -> CubicConstants:
        """C11, C12, C44, in E*."""

    @property
    def reference(self) -> str:
        """Where the model comes from, in words; stored with results."""

    def settings(self) -> str:
        """LAMMPS commands that come before the atoms are read."""

    @property
    def timestep(self) -> float:
        """A stable time step of damped dynamics with unit masses, in a0 (m/(E* a0))^(1/2) units."""

    def interactions(self) -> str:
        """LAMMPS commands that define the forces, on the perfect lattice."""


@dataclass(frozen=True)
class Springs:
    """Harmonic springs between nearest neighbours, at rest at the distance a0: V(r) = stiffness/2 (r - a0)².

    The springs are bonds of a fixed topology: no spring ever breaks or forms, however large the strain.

    Parameters
    ----------
    stiffness : k_s, in E* a0.  :meth:`reduced` gives the one for which the mean E*(100) is 1.
    """

    stiffness: float

    def __post_init__(self) -> None:
        """Refuse what has no meaning."""
        if not (np.isfinite(self.stiffness) and self.stiffness > 0):
            msg = f"the stiffness of a spring is a positive finite number, got {self.stiffness}"
            raise ValueError(msg)

    @classmethod
    def reduced(cls) -> Springs:
        """The springs whose (100) surface has the mean contact modulus 1."""
        return cls(1 / contact_modulus(cls(1.0).elastic_constants))

    @property
    def lattice_constant(self) -> float:
        """Edge of the cubic cell, sqrt(2) a0: the springs are at rest."""
        return float(np.sqrt(2))

    @property
    def reach(self) -> int:
        """Springs join adjacent layers only."""
        return 1

    @property
    def bonds(self) -> Real:
        """Vectors to the 12 neighbours, shape (12, 3), in a0: x and y along <110>, z up."""
        h = np.sqrt(0.5)
        in_plane = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
        between = [(sx / 2, sy / 2, sz * h) for sx, sy, sz in product((1, -1), repeat=3)]
        return np.array(in_plane + between, dtype=np.float64)

    @property
    def elastic_constants(self) -> CubicConstants:
        """C_abcd = (1/2V) Σ k_s r² n_a n_b n_c n_d over the 12 neighbours, V = a0³/√2 (Born and Huang, 1954).

        Gives C11 = √2 k_s/a0 and C12 = C44 = k_s/(√2 a0): a central force at zero pressure obeys Cauchy's
        relation.
        """
        x, y, z = self.bonds.T
        # The cubic axes lie at 45 degrees to those of the slab.
        a, b = (x + y) / np.sqrt(2), (x - y) / np.sqrt(2)
        scale = self.stiffness / float(np.sqrt(2))
        c11, c12 = scale * float(np.sum(a**4)), scale * float(np.sum(a**2 * z**2))
        # C44 = C_xyxy is the same sum as C12 = C_xxyy, taken over another pair of axes.
        return CubicConstants(c11, c12, c44=scale * float(np.sum(a**2 * b**2)))

    @property
    def reference(self) -> str:
        """Where the model comes from."""
        return (
            f"nearest-neighbour harmonic springs on the fcc lattice, k_s = {self.stiffness:.10g} E* a0, "
            "as in Pastewka and Robbins, PNAS 111, 3298 (2014), Methods"
        )

    def settings(self) -> str:
        """Bonds, with room for the 12 of each atom (each bond is stored once, its partners on both sides)."""
        return "atom_style      bond\nspecial_bonds   lj/coul 0 1 1"

    @property
    def timestep(self) -> float:
        """0.2 (m/k_s)^(1/2): ω² = 8 k_s/m is the fastest vibration, and FIRE's step grows to 3 of these."""
        return 0.2 / float(np.sqrt(self.stiffness))

    def interactions(self) -> str:
        """Bonds between all pairs closer than 1.1 a0; a pair style without force makes the neighbour list."""
        return (
            "pair_style      zero 1.2 nocoeff\n"
            "pair_coeff      * *\n"
            "bond_style      harmonic              # E = K (r - r0)^2: K is half the spring constant\n"
            f"bond_coeff      1 {self.stiffness / 2:.17g} 1\n"
            "create_bonds    many all all 1 0.9 1.1"
        )
