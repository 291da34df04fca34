"""Interface of all wall laws: energy, traction and stiffness per area at a given gap.

A law is a function of the gap.  Below ``core``, where (a0/z)^10 would overflow, it is continued with constant
stiffness.  States whose smallest gap is above that are not affected, which :mod:`continuum.path.loading` checks after
each solve.  The formulas are those of :mod:`continuum.model.laws`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, WrapValidator

from continuum.inputs.arguments import array
from continuum.inputs.tables import Description, Fault, constraint
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.theory import paper

CORE = 0.7
"""Default gap below which a law of inverse powers is continued with constant stiffness, in a0."""


class Interaction(NamedTuple):
    """Energy, traction and stiffness of the wall at each point, per area."""

    energy: Real
    """Interaction energy, zero at infinite gap, in E* a0."""
    traction: Real
    """-d energy/d gap, in E*; compression positive."""
    stiffness: Real
    """d²energy/d gap² = -d traction/d gap, in E*/a0; negative where the law softens."""


class DerivedNumber(cached_property[float]):
    """A number that follows from the others, except in kinds that have a field of its name.

    The class itself has no such attribute, which a field would shadow.
    """

    def __get__(self, wall: Any, owner: Any = None) -> Any:
        if wall is None or self.attrname in type(wall).model_fields:  # where it is faulty, in an input
            raise AttributeError(self.attrname)
        return super().__get__(wall, owner)


class Wall(Description):
    """[wall]: law between wall and surface; lengths are in a0, tractions in E*."""

    model_config = ConfigDict(ignored_types=(DerivedNumber,))
    kind_key: ClassVar[str] = "law"
    has_law: ClassVar[bool] = True
    """True if the traction is a function of the gap."""
    work_key: ClassVar[str] = ""
    """The key that sets the work of adhesion, or most of it; empty if there is none."""
    instead: ClassVar[Mapping[str, str]] = {}
    """Keys that may be given instead of another one, whose value then follows from them."""

    if TYPE_CHECKING:  # fields in one law, derived in another: a property here would hide the field

        @property
        def law(self) -> Law | None:
            """The law for compiled code; None for a hard wall."""

        @property
        def zero_gap(self) -> float:
            """Gap at which the traction changes sign."""

        @property
        def core(self) -> float:
            """Gap below which the law is continued with constant stiffness."""

        @property
        def stationary_gaps(self) -> Real:
            """Gaps at which tension or softening may be largest: where they are stationary, or have a kink."""

        @property
        def range(self) -> float:
            """Distance beyond ``zero_gap`` over which the wall attracts: its cut-off, or its effective range."""

        @property
        def hardness(self) -> float:
            """Traction at which one of the bodies yields, in E*; infinite where none does."""

        @property
        def effective_range(self) -> float:
            """Effective range of the attraction, Eq. (S-5); 0 without attraction."""

    else:
        hardness = DerivedNumber(lambda self: np.inf)
        range = DerivedNumber(lambda self: self.effective_range)
        effective_range = DerivedNumber(lambda self: self.integrated_range())

    def build(self) -> Wall:
        """The wall that presses: this one, unless a kind describes another, as by a table of its law."""
        return self

    def at_work(self, work: float) -> Wall:
        """The wall with another work of adhesion and all other parameters unchanged."""
        other = {self.instead[self.work_key]: None} if self.work_key in self.instead else {}
        return self.model_copy(update={self.work_key: work} | other).build()

    def restored(self, stored: Mapping[str, Any]) -> Wall:
        """The wall of a stored run, from the ``knots`` stored with it, without its input files."""
        return self.build()

    @property
    def numbers(self) -> dict[str, Any]:
        """The parameters of the law by their names, by which walls compare."""
        return {name: getattr(self, name) for name in type(self).model_fields if name not in self.instead}

    def value(self, name: str) -> Any:
        replaced = any(name == other and getattr(self, key) is not None for key, other in self.instead.items())
        return None if replaced else super().value(name)

    @constraint
    def _one_strength(self) -> Iterator[Fault]:
        for key, other in self.instead.items():
            absent = getattr(self, key) is None
            if absent == (getattr(self, other) is None):
                cause = "neither is given" if absent else "both are given"
                yield Fault((key,), f"exactly one of {key} and {other}", cause)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.numbers == other.numbers

    def __hash__(self) -> int:
        return hash((type(self), *self.numbers.values()))

    def __repr_args__(self) -> Iterable[tuple[str, Any]]:
        return self.numbers.items()

    @property
    def equivalent_range(self) -> float:
        """Range of the paper's law with the same work of adhesion, in a0, on which the cost of equilibria depends."""
        return 0.35  # of a law with unknown work: that of l_a = 0.005 a0

    @property
    def pull(self) -> float | None:
        """Stiffness of the attraction in E*/a0 if it is independent of the core; used to estimate cost."""
        return None

    @property
    def bound(self) -> float:
        """Smallest possible gap, in a0; minus infinity for a law."""
        return -np.inf

    @property
    def reach(self) -> float:
        """Gap beyond which the traction is zero, in a0; infinite without cut-off."""
        return self.zero_gap if self.law is None else self.law.reach

    @property
    def knots(self) -> Mapping[str, Real]:
        """Gap and traction of a tabulated law, which are stored with results; empty for other laws."""
        return {}

    def evaluate(self, gap: Real) -> Interaction:
        """Energy, traction and stiffness per area at each gap.

        Raises TypeError for a hard wall, whose traction is not a function of the gap.
        """
        if self.law is None:
            raise TypeError("the traction of a hard wall is not a function of the gap: use that of the solution")
        return Interaction(*laws.evaluate(self.law, array("gap", gap)))

    def energy(self, gap: Real) -> Real:
        """Energy per area at each gap, in E* a0."""
        return self.evaluate(gap).energy

    def touches(self, gap: Real) -> NDArray[np.bool_]:
        """Mask of the points in repulsive contact, whose gap is below ``zero_gap``."""
        return np.asarray(gap < self.zero_gap)

    @property
    def work_of_adhesion(self) -> float:
        """Depth of the energy at ``zero_gap``, w, in E* a0; in reduced units also l_a = w/E*."""
        return -float(self.evaluate(np.array(self.zero_gap)).energy)

    def integrated_range(self) -> float:
        """Effective range of the attraction, Eq. (S-5), by quadrature of the law, where it has no closed form."""
        if self.work_of_adhesion <= 0:
            return 0.0
        unit = self.work_of_adhesion / self.largest_tension  # an integral to infinity has to know where to look
        cutoff = (self.reach - self.zero_gap) / unit

        def attraction(x: float) -> float:
            return -float(self.evaluate(np.array(self.zero_gap + unit * x)).traction)

        return unit * paper.effective_range(attraction, cutoff)

    @cached_property
    def largest_tension(self) -> float:
        """Largest attractive traction, in E*."""
        return self.largest_tension_from(self.zero_gap)

    def largest_tension_from(self, gap: float) -> float:
        """Largest attractive traction at this gap or any larger one, in E*; 0 where nothing attracts."""
        gaps = np.append(self.stationary_gaps[self.stationary_gaps > gap], gap)
        return max(0.0, -float(self.evaluate(gaps).traction.min()))

    @cached_property
    def largest_softening(self) -> float:
        """Largest negative stiffness as a positive number, in E*/a0.

        Flat surfaces snap together at wavelengths above :func:`continuum.theory.paper.snap_in_wavelength` of it.
        """
        gaps = self.stationary_gaps[self.stationary_gaps >= self.zero_gap]
        return max(0.0, -float(self.evaluate(gaps).stiffness.min(initial=0.0)))


Instead = WrapValidator(lambda value, given: None if value is None else given(value))
"""Marks a key in whose place another one may be given (:attr:`Wall.instead`); its default is :data:`NOT_GIVEN`."""
NOT_GIVEN: Any = None
