"""Wall laws of two inverse powers, such as the 9-3 law of an atom above a half-space."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import scipy
from pydantic import BeforeValidator, Field, model_validator

from continuum.inputs.keys import Fraction, InInputs, Positive, frozen
from continuum.inputs.tables import Fault, constraint
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.spline import LARGEST_RANGE
from continuum.model.walls.wall import CORE, NOT_GIVEN, Instead, Wall
from continuum.theory import paper

_Power = Annotated[int, Field(ge=2)]


class InversePowers(Wall):
    """Two inverse powers without cut-off: energy c [(a0/z)^m/m - (a0/z)^n/n], c = k a0/(m - n), minimum at a0.

    (m, n) = (9, 3) integrates the 12-6 potential between atoms over a half-space; (12, 6) is the 12-6 law taken
    for the surface itself, with a pressure of (a0/z)^13 - (a0/z)^7.  Work of adhesion k a0/(m n).

    Examples
    --------
    >>> import continuum as c
    >>> round(c.InversePowers((9, 3), adhesion_length=0.05).work_of_adhesion, 6)
    0.05
    """

    instead: ClassVar[Mapping[str, str]] = {"adhesion_length": "minimum_stiffness"}
    zero_gap: ClassVar[float] = 1.0

    powers: Annotated[tuple[_Power, _Power], BeforeValidator(frozen)]
    """whole powers (m, n) of the energy, m > n > 1"""
    minimum_stiffness: Annotated[Positive, Instead] = NOT_GIVEN
    """stiffness per area at the minimum, in E*/a0; instead of adhesion_length"""
    core: Fraction = CORE
    """gap below which the law is continued with constant stiffness, in a0"""
    adhesion_length: Annotated[Positive, InInputs(le=LARGEST_RANGE**2 / 24)] | None = None
    """l_a = w/E*, in a0; the stiffness of the law follows from it"""

    @constraint
    def _repels(self) -> Iterator[Fault]:
        if not self.powers[0] > self.powers[1]:
            yield Fault(("powers",), "(m, n) with m > n > 1")

    @model_validator(mode="after")
    def _stiffness_of_work(self) -> Self:
        if self.adhesion_length is not None:
            vars(self)["minimum_stiffness"] = self.adhesion_length * self.powers[0] * self.powers[1]
        return self

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

    @cached_property
    def effective_range(self) -> float:
        """Effective range of the attraction, Eq. (S-5): beta functions of the powers alone."""
        m, n = self.powers
        weighted = scipy.special.beta(2 / 3, n + 1 / 3) - scipy.special.beta(2 / 3, m + 1 / 3)
        return paper.range_of_integrals(weighted, 1 / n - 1 / m)

    @property
    def equivalent_range(self) -> float:
        return float(np.sqrt(24 * self.work_of_adhesion))


class LennardJones93(InversePowers, kind="lennard-jones-9-3"):
    """[wall] of law "lennard-jones-9-3", without cut-off: a 12-6 potential over a half-space of atoms."""

    example: ClassVar[Mapping[str, Any]] = {"adhesion_length": 0.02}
    newer: ClassVar[frozenset[str]] = frozenset({"minimum_stiffness"})
    powers: ClassVar[tuple[int, int]] = (9, 3)  # type: ignore[misc]

    def build(self) -> Wall:
        return InversePowers(self.powers, self.minimum_stiffness, self.core)


class LennardJones126(LennardJones93, kind="lennard-jones-12-6"):
    """[wall] of law "lennard-jones-12-6", without cut-off: a 12-6 potential of the surface itself."""

    powers: ClassVar[tuple[int, int]] = (12, 6)  # type: ignore[misc]
