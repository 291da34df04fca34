"""The input files of a cross-validation, of a deck and of a crystal, table by table."""

from atomistic.config.crystal import (
    ElasticConfig,
    EmbeddedAtomTable,
    Interatomic,
    LennardJonesTable,
    PairStyleTable,
    SpringsTable,
)
from atomistic.config.deck import (
    DeckConfig,
    MeanPressuresTable,
    ProtocolTable,
    SeparationsTable,
    Steps,
    TopographySurface,
    steps_of,
)
from atomistic.config.motion import SlidingTable, VelocityTable, Windows, kelvin
from atomistic.config.slab import AtomsSolverTable, SlabTable
from atomistic.config.validate import BoundTable, CaseTable, ExponentTable, SurfacesTable, ValidateConfig

__all__ = [
    "AtomsSolverTable",
    "BoundTable",
    "CaseTable",
    "DeckConfig",
    "ElasticConfig",
    "EmbeddedAtomTable",
    "ExponentTable",
    "Interatomic",
    "LennardJonesTable",
    "MeanPressuresTable",
    "PairStyleTable",
    "ProtocolTable",
    "SeparationsTable",
    "SlabTable",
    "SlidingTable",
    "SpringsTable",
    "Steps",
    "SurfacesTable",
    "TopographySurface",
    "ValidateConfig",
    "VelocityTable",
    "Windows",
    "kelvin",
    "steps_of",
]
