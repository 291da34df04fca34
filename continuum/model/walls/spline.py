"""The wall law of the paper."""

from collections.abc import Iterator
from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from continuum.arguments import ArgumentError, number
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.wall import CORE, Wall, WallTable, is_missing
from continuum.tables import Fault, Fraction, constraint

LARGEST_RANGE = 3.0
"""Largest range of the paper's law in an input, in a0.  Its largest tension is (2/27) E* r/a0: at 3 a0 it is 0.22 E*,
the ideal strength of a crystal, far beyond where linear elasticity says anything."""
AdhesionLength = Annotated[float, Field(ge=0, le=LARGEST_RANGE**2 / 24)]
"""Largest l_a = w/E*, that of the largest range, in a0."""


@dataclass(frozen=True)
class LennardJonesSpline(Wall):
    """The paper's law, Eq. (S-6): repulsive 9-3 core, cubic-spline attraction of finite range.

    With z the gap, x = z - a0, k the stiffness at the minimum and r the range::

        p(z) = (k/a0²) a0/6 [(a0/z)^10 - (a0/z)^4]        z <= a0
             = -(k/a0²) x (1 - x/r)²                      a0 < z < a0 + r
             = 0                                          z >= a0 + r

    Work of adhesion w = k r²/(12 a0²): with the paper's k = E* a0/2, w = E* r²/(24 a0), largest tension
    (2/27) E* r/a0 at x = r/3, largest softening E*/(6 a0), independent of the range.  ``range = 0`` is the purely
    repulsive wall of the paper's nonadhesive runs.

    Parameters
    ----------
    range : Δr, distance from the minimum at a0 to the cut-off, in a0; 0 for no adhesion.
    minimum_stiffness : k/a0², stiffness per area at the minimum, in E*/a0 (the paper's is 1/2).
    core : gap below which the traction continues linearly, in a0.
    adhesion_length : l_a = w/E*, in a0, instead of the range: with the paper's stiffness l_a = Δr²/(24 a0).
    """

    range: float = field(default=np.nan)
    minimum_stiffness: float = 0.5
    core: float = CORE
    adhesion_length: InitVar[float | None] = None
    zero_gap: ClassVar[float] = 1.0

    def __post_init__(self, adhesion_length: float | None) -> None:
        number("minimum_stiffness", self.minimum_stiffness, above=0)
        number("core", self.core, above=0, below=1)
        if (adhesion_length is None) == is_missing(self.range):
            raise ArgumentError("adhesion_length", adhesion_length, "exactly one of adhesion_length and range")
        if adhesion_length is not None:
            number("adhesion_length", adhesion_length, least=0)
            object.__setattr__(self, "range", float(np.sqrt(12 * adhesion_length / self.minimum_stiffness)))
        number("range", self.range, least=0)

    @cached_property
    def law(self) -> Law:
        parameters = np.array([self.minimum_stiffness, self.core, self.range, self.work_of_adhesion])
        return Law(laws.SPLINE, parameters, 1.0 + self.range)

    @property
    def work_of_adhesion(self) -> float:
        """Depth w = k Δr²/(12 a0²), in E* a0."""
        return self.minimum_stiffness * self.range**2 / 12

    @property
    def stationary_gaps(self) -> Real:
        """Tension is largest at a0 + Δr/3, (4/27) k Δr/a0², and softening at a0 + 2Δr/3, k/3 for any range above 0."""
        return 1.0 + self.range * np.array([1 / 3, 2 / 3])


class SplineWall(WallTable):
    """[wall] of law "lennard-jones-spline", the paper's, Eq. (S-6)."""

    law: Literal["lennard-jones-spline"]
    adhesion_length: AdhesionLength | None = None
    """l_a = w/E*, in a0 (the paper's: 0.0005, 0.005, 0.05); instead of range"""
    range: Annotated[float, Field(ge=0, le=LARGEST_RANGE)] | None = None
    """distance over which the wall attracts, 0 for no adhesion, at most 3 a0: beyond, the tension exceeds 0.2 E*, the
    strength of crystals; instead of adhesion_length"""
    core: Fraction = CORE
    """gap below which the law is continued with constant stiffness, in a0"""
    work_key: ClassVar[str] = "adhesion_length"

    @constraint
    def _one_strength(self) -> Iterator[Fault]:
        if (self.adhesion_length is None) == (self.range is None):
            cause = "both are given" if self.range is not None else "neither is given; range = 0 is no adhesion"
            yield Fault(("adhesion_length",), "exactly one of adhesion_length and range", cause)

    @property
    def equivalent_range(self) -> float:
        return self.range if self.range is not None else float((24 * (self.adhesion_length or 0.0)) ** 0.5)

    def at_work(self, work: float) -> Wall:
        """The paper's law of another work of adhesion; its range grows as the square root of that."""
        return LennardJonesSpline(adhesion_length=work, core=self.core)

    def build(self) -> Wall:
        if self.range is not None:
            return LennardJonesSpline(self.range, core=self.core)
        return LennardJonesSpline(adhesion_length=self.adhesion_length, core=self.core)
