"""Springs, Lennard-Jones, and what potentials without fixed bonds share; all kinds: :mod:`atomistic.crystal.model`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from atomistic.crystal.crystal import standard_mass
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError, choice, number
from continuum.model.fourier import Real
from continuum.model.substrates.crystal import CubicConstants, contact_modulus


class Species:
    """The elements of a potential: one, and further ones of an alloy."""

    element: str
    mass: float
    others: tuple[tuple[str, float], ...] = ()
    """Symbols and masses of the further elements."""

    @property
    def elements(self) -> tuple[str, ...]:
        """Chemical symbols, in the order of LAMMPS' types."""
        return (self.element, *(name for name, _ in self.others))

    @property
    def masses(self) -> tuple[float, ...]:
        """Mass of an atom of each element."""
        return (self.mass, *(mass for _, mass in self.others))


def check_others(others: Any) -> None:
    """Check that further elements are pairs; raises ArgumentError otherwise."""
    if not isinstance(others, tuple) or not all(isinstance(pair, tuple) and len(pair) == 2 for pair in others):
        raise ArgumentError("others", others, '(symbol, mass) of each further element, as (("Ni", 58.7),)')


def check_masses(species: Species) -> None:
    """Check that each mass is that of an isotope of its element; raises ArgumentError otherwise."""
    for element, mass in zip(species.elements, species.masses, strict=True):
        possible.mass("mass", mass, element, standard_mass(element))


class BondlessPotential(Species):
    """Common part of all potentials without fixed bonds."""

    atom_style: Literal["atomic"] = "atomic"

    @property
    def files(self) -> Mapping[str, bytes]:
        """Files that the LAMMPS commands read."""
        return {}

    @property
    def names(self) -> Mapping[str, str]:
        """Names of these files as they were given."""
        return {}

    def settings(self) -> str:
        """LAMMPS commands that come before the atoms are read."""
        return f"atom_style      {self.atom_style}"


class OfCube:
    """Quantities from the elastic constants of an fcc crystal with a (100) face, in units of a0, E* and a mass."""

    if TYPE_CHECKING:

        @property
        def elastic_constants(self) -> CubicConstants: ...

    density: float = float(np.sqrt(2))
    """Atoms per a0³."""

    @property
    def normal_stiffness(self) -> float:
        """Pressure per strain across the slab, which is as wide as before."""
        return self.elastic_constants[0]

    @property
    def stiffest(self) -> float:
        """ω² of the stiffest vibration, that of springs with the same constants, k = √2 C44 a0 or C11 a0/√2."""
        c11, _, c44 = self.elastic_constants
        return float(8 * max(np.sqrt(2) * c44, c11 / np.sqrt(2)))


@dataclass(frozen=True)
class Springs(Species, OfCube):
    """Harmonic springs between nearest neighbours, at rest at the distance a0: V(r) = stiffness/2 (r - a0)².

    The springs are bonds of a fixed topology: none breaks or forms at any strain.

    Parameters
    ----------
    stiffness : k_s, in E* a0; the one for which the mean E*(100) is 1 if not given.

    Examples
    --------
    >>> import atomistic as a
    >>> round(a.Springs().stiffness, 3)  # in E* a0, so that E*(100) is 1
    0.729
    """

    stiffness: float = field(default_factory=lambda: 1 / contact_modulus(Springs(1.0).elastic_constants))

    harmonic: Literal[True] = field(default=True, init=False)
    units: Literal["lj"] = field(default="lj", init=False)
    atom_style: Literal["bond"] = field(default="bond", init=False)
    mass: float = field(default=1.0, init=False)
    element: str = field(default="X", init=False)
    cutoff: float = field(default=1.1, init=False)
    force_range: float = field(default=1.0, init=False)
    guess: float = field(default=float(np.sqrt(0.5)), init=False)
    length: float = field(default=1.0, init=False)
    energy: float = field(default=1.0, init=False)
    real_units: None = field(default=None, init=False)
    expands: Literal[False] = field(default=False, init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", number("stiffness", self.stiffness, above=0))

    @property
    def lattice_constant(self) -> float:
        """Edge of the cubic cell, sqrt(2) a0: the springs are at rest."""
        return float(np.sqrt(2))

    @property
    def coupled_layers(self) -> int:
        """Number of layers that forces reach: 1, because springs join only adjacent layers."""
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
    def files(self) -> Mapping[str, bytes]:
        return {}

    @property
    def names(self) -> Mapping[str, str]:
        return {}

    @property
    def identity(self) -> Mapping[str, str | float]:
        return {"kind": "springs", "stiffness": self.stiffness}

    @property
    def reference(self) -> str:
        return (
            f"nearest-neighbour harmonic springs on the fcc lattice, k_s = {self.stiffness:.10g} E* a0, "
            "as in Pastewka and Robbins, PNAS 111, 3298 (2014), Methods"
        )

    def settings(self) -> str:
        """LAMMPS commands for bonds, with room for 12 of each atom (stored once, partners on both sides)."""
        return "atom_style      bond\nspecial_bonds   lj/coul 0 1 1"

    @property
    def timestep(self) -> float:
        """0.2 (m/k_s)^(1/2): ω² = 8 k_s/m is the fastest vibration, and FIRE's step grows to 3 of these."""
        return 0.2 / float(np.sqrt(self.stiffness))

    def interactions(self) -> str:
        """Bonds between all pairs closer than 1.1 a0; a pair style without force makes the neighbour list."""
        return (
            "comm_modify     cutoff 1.8                      # longer than a spring stretched by 80 %\n"
            "pair_style      zero 1.2 nocoeff\n"
            "pair_coeff      * *\n"
            "bond_style      harmonic              # E = K (r - r0)^2: K is half the spring constant\n"
            f"bond_coeff      1 {self.stiffness / 2:.17g} 1\n"
            "create_bonds    many all all 1 0.9 1.1"
        )


@dataclass(frozen=True)
class LennardJones(BondlessPotential):
    """V(r) = 4 ε ((σ/r)¹² - (σ/r)⁶), truncated so that force and energy are continuous, in units of ε and σ.

    A plain cut-off leaves a jump in the force, so that energy is not conserved when pairs cross it.  The ways to avoid
    it are LAMMPS' ``lj/smooth/linear`` (V minus its tangent at the cut-off), ``lj/smooth`` and ``lj/mdf`` (V up to
    ``inner``, then a polynomial that ends it).

    Parameters
    ----------
    cutoff : in σ.
    truncation : which of these.
    inner : where the polynomial begins, in σ; none for "smooth/linear".

    Examples
    --------
    >>> import atomistic as a
    >>> crystal = a.elastic(a.LennardJones(cutoff=2.5)).model.crystal
    >>> round(crystal.lattice_constant, 4)  # in σ
    1.558
    """

    cutoff: float = 2.5
    truncation: Literal["smooth/linear", "smooth", "mdf"] = "smooth/linear"
    inner: float | None = None

    units: Literal["lj"] = field(default="lj", init=False)
    mass: float = field(default=1.0, init=False)
    element: str = field(default="X", init=False)
    guess: float = field(default=0.92, init=False)

    def __post_init__(self) -> None:
        choice("truncation", self.truncation, ("smooth/linear", "smooth", "mdf"))
        number("cutoff", self.cutoff, least=1.2, most=10)
        if self.truncation != "smooth/linear":
            if number("inner", self.inner, least=1) >= self.cutoff:
                raise ArgumentError("inner", self.inner, f"less than the cutoff, {self.cutoff:g}")
        elif self.inner is not None:
            raise ArgumentError("inner", self.inner, 'only with truncation="smooth" or "mdf"')

    @property
    def force_range(self) -> float:
        """Largest distance at which a displaced atom changes forces: the cut-off."""
        return self.cutoff

    @property
    def identity(self) -> Mapping[str, str | float]:
        inner = {} if self.inner is None else {"inner": self.inner}
        return {"kind": "lennard-jones", "truncation": self.truncation, "cutoff": self.cutoff, **inner}

    @property
    def reference(self) -> str:
        inner = "" if self.inner is None else f", from {self.inner:g} σ on"
        return f"Lennard-Jones 12-6, pair_style lj/{self.truncation}, cut at {self.cutoff:g} σ{inner}"

    def interactions(self) -> str:
        """LAMMPS commands that define the forces."""
        radii = " ".join(f"{r:.17g}" for r in (self.inner, self.cutoff) if r is not None)
        return f"pair_style      lj/{self.truncation} {radii}\npair_coeff      * * 1 1"
