"""Tables common to the inputs of validations and decks: the slab, and tolerances."""

from typing import Annotated

from pydantic import Field

from continuum.runs.config import ToleranceTable
from continuum.tables import Fraction, Table

SHALLOWEST, DEEPEST = 2.0, 512.0
"""Depth of a slab, in a0."""


class SlabTable(Table):
    """The atoms."""

    n: Annotated[int, Field(ge=8, le=512)]
    """surface atoms along x and along y; the period is n a0"""
    depth: Annotated[float, Field(ge=SHALLOWEST, le=DEEPEST)]
    """from the surface plane to the frozen base, in a0, rounded to whole layers"""

    @property
    def points(self) -> tuple[int, int]:
        return self.n, self.n

    @property
    def lengths(self) -> tuple[float, float]:
        return float(self.n), float(self.n)


class AtomsSolverTable(ToleranceTable):
    """[solver]: tolerances of equilibria."""

    tolerance: Fraction = 1e-9
    """largest rms residual of the continuum rungs, relative to rms_slope E*"""
    force_tolerance: Annotated[float, Field(gt=0, le=1e-8)] = 1e-8
    """largest force left on an atom, relative to rms_slope E* a0²"""


class DeckSolverTable(AtomsSolverTable):
    """[solver] of a deck: tolerances of equilibria and of a tabulated wall."""

    wall_tolerance: Annotated[float, Field(ge=1e-10, le=1e-2)] = 1e-5
    """of the tractions of a wall that is a table, relative to its largest tension, or to the traction where that is
    larger; other laws are formulas, and exact"""
