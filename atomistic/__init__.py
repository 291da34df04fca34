"""Explicit fcc(100) atoms under a rigid rough wall, in LAMMPS: the check on the Green's-function model.

Units, signs and names are those of :mod:`continuum`, with one addition: a surface atom stands for one point
of the grid, of area a0², so that the force of the wall on it is traction x a0² and its wall energy is energy
per area x a0². Forces and displacements of atoms are vectors, positive towards the wall (+z); tractions are
positive in compression.

Arrays over the atoms of a slab have the shape (layers, nx, ny) or (layers, nx, ny, 3): layer 0 is the
surface, and atom [0, i, j] is the point [i, j] of the grid.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from atomistic.crystal.crystal import Slab as Slab
    from atomistic.crystal.interatomic import LennardJones as LennardJones
    from atomistic.crystal.interatomic import Springs as Springs
    from atomistic.crystal.pair_style import PairStyle as PairStyle
    from atomistic.crystal.potentials import EmbeddedAtom as EmbeddedAtom
    from atomistic.crystal.potentials import PotentialError as PotentialError
    from atomistic.crystal.potentials import find_potential as find_potential
    from atomistic.front import Elastic as Elastic
    from atomistic.front import check as check
    from atomistic.front import deck as deck
    from atomistic.front import elastic as elastic
    from atomistic.front import read as read
    from atomistic.front import run_deck as run_deck
    from atomistic.ladder.validate import Validation as Validation
    from atomistic.ladder.validate import validate as validate
    from atomistic.lammps.deck import Deck as Deck
    from atomistic.lammps.engine import doctor as doctor
    from atomistic.lammps.result import LammpsError as LammpsError
    from atomistic.lammps.shape import Round as Round
    from atomistic.lammps.shape import Waves as Waves
    from atomistic.relax.certify import DeckCertificate as DeckCertificate
    from atomistic.relax.deckrun import DeckRun as DeckRun
    from atomistic.response.lattice import LatticeResponse as LatticeResponse

_WHERE = {
    "front": ("Elastic", "check", "deck", "elastic", "read", "run_deck"),
    "ladder.validate": ("Validation", "validate"),
    "lammps.deck": ("Deck",),
    "lammps.engine": ("doctor",),
    "relax.certify": ("DeckCertificate",),
    "relax.deckrun": ("DeckRun",),
    "crystal.crystal": ("Slab",),
    "crystal.interatomic": ("LennardJones", "Springs"),
    "crystal.pair_style": ("PairStyle",),
    "crystal.potentials": ("EmbeddedAtom", "PotentialError", "find_potential"),
    "lammps.result": ("LammpsError",),
    "lammps.shape": ("Round", "Waves"),
    "response.lattice": ("LatticeResponse",),
}
# Imported when they are used: `atomistic --help` needs none of them.
_MODULES = {name: module for module, names in _WHERE.items() for name in names}
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'atomistic' has no attribute {name!r}")
    return getattr(import_module(f"atomistic.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
