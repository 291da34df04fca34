"""What every wall law offers: energy, traction and stiffness per area of the rigid wall on the surface, at a given gap.

A law is a pure function of the gap.  Its core, where (a0/z)^10 would overflow, is continued with constant
stiffness below ``core``: finite everywhere, and exact for every state whose smallest gap is above it, which
:mod:`continuum.path.loading` checks at the end of each solve.  The formulas are those of :mod:`continuum.model.laws`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from continuum.arguments import array
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.tables import TableFamily
from continuum.theory import paper

CORE = 0.7
"""Gap below which a law of inverse powers is continued, in a0, unless another is given."""


class Interaction(NamedTuple):
    """What the wall does to the surface at each point, per area."""

    energy: Real
    """Interaction energy, zero at infinite gap, in E* a0."""
    traction: Real
    """-d energy/d gap, in E*; compression positive."""
    stiffness: Real
    """d²energy/d gap² = -d traction/d gap, in E*/a0; negative where the law softens."""


class Wall:
    """What every wall law offers.  Laws are frozen; lengths are in a0, tractions in E*."""

    if TYPE_CHECKING:  # fields in one law, derived in another: a property here would hide the field

        @property
        def law(self) -> Law | None:
            """The law as compiled code takes it; None for a wall that only bounds the gap."""

        @property
        def zero_gap(self) -> float:
            """Gap at which the traction changes sign."""

        @property
        def range(self) -> float:
            """Distance beyond ``zero_gap`` over which the wall attracts: its cut-off, or its effective range."""

        @property
        def core(self) -> float:
            """Gap below which the law is continued with constant stiffness."""

    hardness: float = np.inf
    """Traction at which one of the bodies yields, in E*; infinite where none does."""

    @property
    def bound(self) -> float:
        """Gap below which no point can go, in a0; none for a law."""
        return -np.inf

    @property
    def reach(self) -> float:
        """Gap beyond which the wall does nothing, in a0; infinite if there is none."""
        return self.zero_gap if self.law is None else self.law.reach

    @property
    def knots(self) -> Mapping[str, Real]:
        """What determines the law beside numbers, to be stored with results: gap and traction of a table."""
        return {}

    def evaluate(self, gap: Real) -> Interaction:
        """Energy, traction and stiffness per area at each gap.

        Raises TypeError if the wall has no law, as a hard wall: no traction belongs to a gap.
        """
        if self.law is None:
            raise TypeError("a hard wall has no traction as a function of the gap: take that of the solution")
        return Interaction(*laws.evaluate(self.law, array("gap", gap)))

    def energy(self, gap: Real) -> Real:
        """Energy per area at each gap, in E* a0."""
        return self.evaluate(gap).energy

    def touches(self, gap: Real) -> NDArray[np.bool_]:
        """Where the surface is in repulsive contact: gap below ``zero_gap``."""
        return np.asarray(gap < self.zero_gap)

    @property
    def work_of_adhesion(self) -> float:
        """Depth of the energy at ``zero_gap``, w, in E* a0; in reduced units also l_a = w/E*."""
        return -float(self.evaluate(np.array(self.zero_gap)).energy)

    @cached_property
    def effective_range(self) -> float:
        """Effective range of the attraction, Eq. (S-5); 0 without attraction."""
        if self.work_of_adhesion <= 0:
            return 0.0
        cutoff = self.reach - self.zero_gap
        return paper.effective_range(lambda x: -float(self.evaluate(np.array(self.zero_gap + x)).traction), cutoff)

    @property
    def largest_tension(self) -> float:
        """Largest attractive traction, in E*."""
        return self._largest(lambda gap: -self.evaluate(gap).traction)

    @property
    def largest_softening(self) -> float:
        """Largest negative stiffness as a positive number, in E*/a0.

        Flats snap together for wavelengths above :func:`continuum.theory.paper.snap_in_wavelength` of it.
        """
        return self._largest(lambda gap: -self.evaluate(gap).stiffness)

    def _largest(self, values: Callable[[Real], Real]) -> float:
        end = min(self.reach, self.zero_gap + 20.0)
        gaps = np.linspace(self.zero_gap, end, 20001)
        i = int(np.argmax(values(gaps)))
        bounds = gaps[max(i - 1, 0)], gaps[min(i + 1, gaps.size - 1)]
        found = minimize_scalar(lambda gap: -float(values(np.array(gap))), bounds=bounds, method="bounded")
        return max(0.0, -float(found.fun), float(values(gaps[i : i + 1])[0]))


def is_missing(value: object) -> bool:
    """Whether a number was not given, which its default, NaN, says."""
    return isinstance(value, float) and np.isnan(value)


class WallTable(TableFamily):
    """[wall]: law between wall and surface.

    A law and its table are two classes: a file holds what an experiment knows, such as the work of adhesion, and stays
    within what linear elasticity can describe, while a law holds what its formula needs.
    """

    kind_key: ClassVar[str] = "law"
    has_law: ClassVar[bool] = True

    @property
    def largest_pressure(self) -> float:
        """Mean pressure that no state reaches, in E*; infinite if there is none."""
        return np.inf

    """Whether the traction is a function of the gap."""
    work_key: ClassVar[str] = ""
    """The key that gives the work of adhesion, or most of it; empty where there is none."""

    law: str

    @property
    def equivalent_range(self) -> float:
        """Range of the paper's law of the same work of adhesion, in a0: by it equilibria cost more."""
        return 0.35  # of a law of which nothing is known: l_a = 0.005 a0

    @property
    def pull(self) -> float | None:
        """Stiffness of the attraction in E*/a0, for its cost, where it is chosen apart from that of the core."""
        return None

    def build(self) -> Wall:
        raise NotImplementedError

    def at_work(self, work: float) -> Wall:
        """The law with another work of adhesion, and all else as it is given."""
        return self.model_copy(update={self.work_key: work}).build()

    def restored(self, stored: Mapping[str, Any]) -> Wall:
        """The law of a run whose input files are gone, with the ``knots`` that were stored with its result."""
        return self.build()
