"""The input files of a cross-validation, of a deck and of a crystal, table by table."""

from atomistic.config.crystal import (
    ElasticConfig,
    EmbeddedAtomTable,
    Interatomic,
    LennardJonesTable,
    PairStyleTable,
    SpringsTable,
)
from atomistic.config.deck import DeckConfig, MeanPressuresTable, SeparationsTable, Steps, TopographySurface
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
    "SeparationsTable",
    "SlabTable",
    "SpringsTable",
    "Steps",
    "SurfacesTable",
    "TopographySurface",
    "ValidateConfig",
]
