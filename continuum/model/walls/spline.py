"""The wall law of the paper."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import scipy
from pydantic import Field, model_validator

from continuum.inputs.keys import LARGEST, Fraction, InInputs, Positive
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.wall import CORE, NOT_GIVEN, Instead, Wall
from continuum.theory import paper

LARGEST_RANGE = 3.0
"""Largest range of the paper's law in an input, in a0.  Its largest tension is (2/27) E* r/a0: at 3 a0 it is 0.22 E*,
the ideal strength of a crystal, far beyond where linear elasticity says anything."""
AdhesionLength = Annotated[float, Field(ge=0, le=LARGEST), InInputs(le=LARGEST_RANGE**2 / 24)]
"""l_a = w/E*, in a0; in an input at most that of the largest range."""


class LennardJonesSpline(Wall, kind="lennard-jones-spline"):
    """The paper's law, Eq. (S-6): repulsive 9-3 core, cubic-spline attraction of finite range.

    With z the gap, x = z - a0, k the stiffness at the minimum and r the range::

        p(z) = (k/a0²) a0/6 [(a0/z)^10 - (a0/z)^4]        z <= a0
             = -(k/a0²) x (1 - x/r)²                      a0 < z < a0 + r
             = 0                                          z >= a0 + r

    Work of adhesion w = k r²/(12 a0²): with the paper's k = E* a0/2, w = E* r²/(24 a0), largest tension
    (2/27) E* r/a0 at x = r/3, largest softening E*/(6 a0), independent of the range.  ``range = 0`` is the purely
    repulsive wall of the paper's nonadhesive runs.

    Examples
    --------
    >>> import continuum as c
    >>> wall = c.LennardJonesSpline(adhesion_length=0.05)
    >>> round(wall.work_of_adhesion, 6), round(wall.range, 4)  # w = l_a E*, in E* a0; Δr in a0
    (0.05, 1.0954)
    """

    example: ClassVar[Mapping[str, Any]] = {"adhesion_length": 0.005}
    newer: ClassVar[frozenset[str]] = frozenset({"minimum_stiffness"})
    work_key: ClassVar[str] = "adhesion_length"
    instead: ClassVar[Mapping[str, str]] = {"adhesion_length": "range"}
    zero_gap: ClassVar[float] = 1.0

    range: Annotated[float, Field(ge=0, le=LARGEST), InInputs(le=LARGEST_RANGE), Instead] = NOT_GIVEN
    """distance over which the wall attracts, in a0; 0 for no adhesion; at most 3 in an input, where the tension reaches
    0.2 E*, the strength of crystals; instead of adhesion_length"""
    minimum_stiffness: Positive = 0.5
    """stiffness per area at the minimum, in E*/a0; the paper's is 1/2"""
    core: Fraction = CORE
    """gap below which the law is continued with constant stiffness, in a0"""
    adhesion_length: AdhesionLength | None = None
    """l_a = w/E*, in a0 (the paper's: 0.0005, 0.005, 0.05); instead of range"""

    @model_validator(mode="after")
    def _range_of_work(self) -> Self:
        if self.adhesion_length is not None:
            vars(self)["range"] = float(np.sqrt(12 * self.adhesion_length / self.minimum_stiffness))
        return self

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

    @property
    def effective_range(self) -> float:
        """Effective range of the attraction, Eq. (S-5), with p ~ t (1 - t)²: 1.05659 ranges."""
        weighted, work = scipy.special.beta(5 / 3, 3), scipy.special.beta(2, 3)
        return self.range * paper.range_of_integrals(weighted, work)

    @property
    def equivalent_range(self) -> float:
        return float(np.sqrt(24 * self.work_of_adhesion))
