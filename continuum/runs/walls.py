"""The table [wall] of an input, which builds the law between wall and surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from continuum.files.arrays import read_text
from continuum.files.tables import InputFile, Positive, Table, constraint
from continuum.files.toml import Fault
from continuum.model.attraction import Shape, attraction_on_core
from continuum.model.tabulated_wall import TabulatedWall
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.runs.tables import Fraction

LARGEST_RANGE = 3.0
"""Of the paper's law, in a0.  Its largest tension is (2/27) E* r/a0: at 3 a0 it is 0.22 E*, the ideal strength of a
crystal, far beyond where linear elasticity says anything."""


class _Wall(Table):
    """What all tables of walls have."""

    @property
    def equivalent_range(self) -> float:
        """Range that the paper's law of the same work of adhesion has, in a0: by it equilibria cost more."""
        return 0.35  # of a law of which nothing is known: l_a = 0.005 a0


class SplineWall(_Wall):
    """[wall] of law "lennard-jones-spline", the paper's, Eq. (S-6)."""

    law: Literal["lennard-jones-spline"]
    adhesion_length: Annotated[float, Field(ge=0)] | None = None
    """l_a = w/E*, in a0 (the paper's: 0.0005, 0.005, 0.05); instead of range"""
    range: Annotated[float, Field(ge=0)] | None = None
    """distance over which the wall attracts, in a0; 0 for no adhesion; instead of adhesion_length"""
    core: Fraction = 0.7
    """gap below which the law is only continued, in a0"""

    @constraint
    def _one_strength(self) -> Iterator[Fault]:
        if (self.adhesion_length is None) == (self.range is None):
            cause = "both are given" if self.range is not None else "neither is given; range = 0 is no adhesion"
            yield Fault(("adhesion_length",), "exactly one of adhesion_length and range", cause)

    @constraint
    def _within_elasticity(self) -> Iterator[Fault]:
        cause = "given in other units than a0, or range and adhesion_length exchanged"
        if self.range is not None and self.range > LARGEST_RANGE:
            limit = f"at most {LARGEST_RANGE:g} a0: beyond, the tension exceeds 0.2 E*, the strength of crystals"
            yield Fault(("range",), limit, cause)
        largest = LARGEST_RANGE**2 / 24
        if self.adhesion_length is not None and self.adhesion_length > largest:
            limit = f"at most {largest:g} a0, a range of {LARGEST_RANGE:g} a0: see range"
            yield Fault(("adhesion_length",), limit, cause)

    @property
    def equivalent_range(self) -> float:
        """The range itself."""
        return self.range if self.range is not None else float((24 * (self.adhesion_length or 0.0)) ** 0.5)

    def build(self) -> Wall:
        """The law."""
        if self.range is not None:
            return LennardJonesSpline(self.range, core=self.core)
        return LennardJonesSpline(adhesion_length=self.adhesion_length, core=self.core)


class TableWall(_Wall):
    """[wall] of law "table"."""

    law: Literal["table"]
    path: InputFile
    """text, two columns: gap in a0 (increasing) and traction in E* (compression positive, zero at the end)"""

    def build(self) -> Wall:
        """The law.

        Raises
        ------
        ValueError, OSError
            If the file is no table of a wall.
        """
        columns = read_text(self.path)
        if columns.shape[1] != 2:
            msg = f"{self.path} has {columns.shape[1]} columns, a wall has 2: gap and traction"
            raise ValueError(msg)
        return TabulatedWall(columns[:, 0], columns[:, 1])


class InversePowersWall(_Wall):
    """[wall] of law "lennard-jones-9-3" or "lennard-jones-12-6", not truncated."""

    law: Literal["lennard-jones-9-3", "lennard-jones-12-6"]
    adhesion_length: Annotated[float, Field(gt=0, le=LARGEST_RANGE**2 / 24)]
    """l_a = w/E*, in a0; the stiffness of the law follows from it"""
    core: Fraction = 0.7
    """gap below which the law is only continued, in a0"""

    @property
    def equivalent_range(self) -> float:
        """Of this work of adhesion."""
        return float((24 * self.adhesion_length) ** 0.5)

    def build(self) -> Wall:
        """The law."""
        powers = (9, 3) if self.law == "lennard-jones-9-3" else (12, 6)
        return InversePowers(powers, core=self.core, adhesion_length=self.adhesion_length)


class ExponentialWall(_Wall):
    """[wall] of law "exponential": attraction on a stiff core."""

    law: Literal["exponential"]
    surface_energy: Positive
    """gamma, in E* a0"""
    decay_length: Positive
    """rho, in a0"""
    core_stiffness: Positive
    """K, in E*/a0"""

    @property
    def equivalent_range(self) -> float:
        """Of this surface energy."""
        return float((24 * self.surface_energy) ** 0.5)

    def build(self) -> Wall:
        """The law."""
        return Exponential(self.surface_energy, self.decay_length, self.core_stiffness)


class AttractionWall(_Wall):
    """[wall] of law "attraction-on-core": work, range and core chosen apart, which the paper's law ties together."""

    law: Literal["attraction-on-core"]
    shape: Shape
    """attraction of the paper's law, "spline", or one without end, "exponential"
    """
    adhesion_length: Positive
    """l_a = w/E*, in a0"""
    effective_range: Positive
    """distance over which the wall attracts, Eq. (S-5), in a0"""
    core_stiffness: Positive
    """traction per overlap, in E*/a0; at least the attraction's own stiffness"""

    def build(self) -> Wall:
        """The law."""
        return attraction_on_core(self.shape, self.adhesion_length, self.effective_range, self.core_stiffness)


class RigidWall(_Wall):
    """[wall] of law "hard": non-overlap, no adhesion."""

    law: Literal["hard"]

    @property
    def equivalent_range(self) -> float:
        """None."""
        return 0.0

    def build(self) -> Wall:
        """The bound."""
        return HardWall()


WallTable = Annotated[
    SplineWall | InversePowersWall | ExponentialWall | AttractionWall | TableWall | RigidWall,
    Field(discriminator="law"),
]
"""[wall]: law between wall and surface."""
