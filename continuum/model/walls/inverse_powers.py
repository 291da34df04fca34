"""Wall laws of two inverse powers, such as the 9-3 law of an atom above a half-space."""

from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from continuum.arguments import ArgumentError, number, pair
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.spline import LARGEST_RANGE
from continuum.model.walls.wall import CORE, Wall, WallTable, is_missing
from continuum.tables import Fraction


@dataclass(frozen=True)
class InversePowers(Wall):
    """Two inverse powers without cut-off: energy c [(a0/z)^m/m - (a0/z)^n/n], c = k a0/(m - n), minimum at a0.

    (m, n) = (9, 3) integrates the 12-6 potential between atoms over a half-space; (12, 6) is the 12-6 law taken
    for the surface itself, with a pressure of (a0/z)^13 - (a0/z)^7.  Work of adhesion k a0/(m n).

    Parameters
    ----------
    powers : (m, n) of the energy, m > n > 1.
    minimum_stiffness : k/a0², stiffness per area at the minimum, in E*/a0.
    core : gap below which the traction continues linearly, in a0.
    adhesion_length : l_a = w/E*, in a0, instead of the stiffness, which follows from it: l_a = k/(m n E*).
    """

    powers: tuple[int, int]
    minimum_stiffness: float = field(default=np.nan)
    core: float = CORE
    adhesion_length: InitVar[float | None] = None
    zero_gap: ClassVar[float] = 1.0

    def __post_init__(self, adhesion_length: float | None) -> None:
        repulsion, attraction = pair("powers", self.powers)
        number("powers", repulsion, above=number("powers", attraction, above=1))
        number("core", self.core, above=0, below=1)
        if (adhesion_length is None) == is_missing(self.minimum_stiffness):
            what = "exactly one of adhesion_length and minimum_stiffness"
            raise ArgumentError("adhesion_length", adhesion_length, what)
        if adhesion_length is not None:
            number("adhesion_length", adhesion_length, above=0)
            object.__setattr__(self, "minimum_stiffness", adhesion_length * self.powers[0] * self.powers[1])
        number("minimum_stiffness", self.minimum_stiffness, above=0)

    @cached_property
    def law(self) -> Law:
        m, n = self.powers
        parameters = np.array([self.minimum_stiffness, self.core, float(m), float(n)])
        return Law(laws.INVERSE_POWERS, parameters, np.inf)

    @property
    def stationary_gaps(self) -> Real:
        """Tension is largest where (z/a0)^(m-n) = (m+1)/(n+1), softening at (m+2)/(n+2) times that."""
        m, n = self.powers
        strongest = (m + 1) / (n + 1)
        return np.array([strongest, strongest * (m + 2) / (n + 2)]) ** (1 / (m - n))


class InversePowersWall(WallTable):
    """[wall] of law "lennard-jones-9-3" or "lennard-jones-12-6", without cut-off."""

    law: Literal["lennard-jones-9-3", "lennard-jones-12-6"]
    adhesion_length: Annotated[float, Field(gt=0, le=LARGEST_RANGE**2 / 24)]
    """l_a = w/E*, in a0; the stiffness of the law follows from it"""
    core: Fraction = CORE
    """gap below which the law is continued with constant stiffness, in a0"""

    @property
    def equivalent_range(self) -> float:
        return float((24 * self.adhesion_length) ** 0.5)

    def build(self) -> Wall:
        powers = (9, 3) if self.law == "lennard-jones-9-3" else (12, 6)
        return InversePowers(powers, core=self.core, adhesion_length=self.adhesion_length)
