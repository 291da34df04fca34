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
    LARGEST_PRESSURE,
    MOST_STEPS,
    DeckConfig,
    MeanPressuresTable,
    ProtocolTable,
    SeparationsTable,
    Steps,
    TopographySurface,
    steps_of,
)
from atomistic.config.motion import (
    FASTEST,
    HOTTEST,
    Scale,
    SlidingTable,
    VelocityTable,
    Windows,
    beyond_physics,
    kelvin,
)
from atomistic.config.slab import DEEPEST, SHALLOWEST, AtomsSolverTable, SlabTable
from atomistic.config.validate import BoundTable, CaseTable, ExponentTable, SurfacesTable, ValidateConfig

__all__ = [
    "DEEPEST",
    "FASTEST",
    "HOTTEST",
    "LARGEST_PRESSURE",
    "MOST_STEPS",
    "SHALLOWEST",
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
    "Scale",
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
    "beyond_physics",
    "kelvin",
    "steps_of",
]
