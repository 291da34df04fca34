"""The public names, each with its module: for type checkers, and for ``__init__.py``, which imports them when asked."""

from atomistic.atoms.relaxation import GreensRelaxation as GreensRelaxation
from atomistic.atoms.response import SlabResponse as SlabResponse
from atomistic.atoms.wall import RoughWall as RoughWall
from atomistic.crystal.crystal import Slab as Slab
from atomistic.crystal.interatomic import LennardJones as LennardJones
from atomistic.crystal.interatomic import Springs as Springs
from atomistic.crystal.pair_style import PairStyle as PairStyle
from atomistic.crystal.potentials import EmbeddedAtom as EmbeddedAtom
from atomistic.crystal.potentials import PotentialError as PotentialError
from atomistic.crystal.potentials import find_potential as find_potential
from atomistic.front.doctor import doctor as doctor
from atomistic.front.functions import DeckRun as DeckRun
from atomistic.front.functions import Elastic as Elastic
from atomistic.front.functions import check as check
from atomistic.front.functions import deck as deck
from atomistic.front.functions import elastic as elastic
from atomistic.front.functions import read as read
from atomistic.front.functions import run_deck as run_deck
from atomistic.front.validation import Validation as Validation
from atomistic.front.validation import validate as validate
from atomistic.lammps.deck import Deck as Deck
from atomistic.lammps.result import LammpsError as LammpsError
from atomistic.lammps.shape import Round as Round
from atomistic.lammps.shape import Waves as Waves
from atomistic.relax.certify import DeckCertificate as DeckCertificate
from atomistic.response.lattice import LatticeResponse as LatticeResponse
