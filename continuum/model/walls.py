"""Wall laws: energy, traction and stiffness per area of the rigid wall on the surface, at a given gap.

A law is a pure function of the gap.  Its core, where (a0/z)^10 would overflow, is continued with constant
stiffness below ``core``: finite everywhere, and exact for every state whose smallest gap is above it, which
:mod:`continuum.path.loading` checks at the end of each solve.  The formulas are those of :mod:`continuum.model.laws`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from continuum.arguments import ArgumentError, array, number, pair
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.theory import paper

_CORE = 0.7


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

    bound: ClassVar[float] = -np.inf
    """Gap below which no point can go, in a0; none for a law."""

    @property
    def reach(self) -> float:
        """Gap beyond which the wall does nothing, in a0; infinite if there is none."""
        return self.zero_gap if self.law is None else self.law.reach

    def evaluate(self, gap: Real) -> Interaction:
        """Energy, traction and stiffness per area at each gap.

        Raises
        ------
        TypeError
            If the wall has no law, as a hard wall: no traction belongs to a gap.
        """
        if self.law is None:
            msg = "a hard wall has no traction as a function of the gap: take that of the solution"
            raise TypeError(msg)
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


def _is_missing(value: object) -> bool:
    """Whether a number was not given, which its default, NaN, says."""
    return isinstance(value, float) and np.isnan(value)


@dataclass(frozen=True)
class HardWall(Wall):
    """Non-overlap, no adhesion: gap >= 0, traction >= 0, and one of them zero at each point.

    It has no law: its traction is not a function of the gap but what holds the surface, as the solution says.  Contact
    is where the gap is exactly zero.
    """

    law: ClassVar[None] = None
    zero_gap: ClassVar[float] = 0.0
    range: ClassVar[float] = 0.0
    core: ClassVar[float] = -np.inf
    bound: ClassVar[float] = 0.0
    work_of_adhesion: ClassVar[float] = 0.0
    largest_tension: ClassVar[float] = 0.0
    largest_softening: ClassVar[float] = 0.0

    def energy(self, gap: Real) -> Real:
        """Zero, infinite where the surface would overlap."""
        return np.where(gap < 0, np.inf, 0.0)

    def touches(self, gap: Real) -> NDArray[np.bool_]:
        """Where the gap is exactly zero, which is where the wall pushes."""
        return np.asarray(gap <= 0.0)


@dataclass(frozen=True)
class LennardJonesSpline(Wall):
    """The paper's law, Eq. (S-6): repulsive 9-3 core, cubic-spline attraction of finite range.

    With z the gap, x = z - a0, k the stiffness at the minimum and r the range::

        p(z) = (k/a0²) a0/6 [(a0/z)^10 - (a0/z)^4]        z <= a0
             = -(k/a0²) x (1 - x/r)²                      a0 < z < a0 + r
             = 0                                          z >= a0 + r

    Work of adhesion w = k r²/(12 a0²): with the paper's k = E* a0/2, w = E* r²/(24 a0), largest tension
    (2/27) E* r/a0 at x = r/3, largest softening E*/(6 a0), whatever the range.  ``range = 0`` is the purely
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
    core: float = _CORE
    adhesion_length: InitVar[float | None] = None

    def __post_init__(self, adhesion_length: float | None) -> None:
        number("minimum_stiffness", self.minimum_stiffness, above=0)
        number("core", self.core, above=0, below=1)
        if (adhesion_length is None) == _is_missing(self.range):
            raise ArgumentError("adhesion_length", adhesion_length, "exactly one of adhesion_length and range")
        if adhesion_length is not None:
            number("adhesion_length", adhesion_length, least=0)
            object.__setattr__(self, "range", float(np.sqrt(12 * adhesion_length / self.minimum_stiffness)))
        number("range", self.range, least=0)

    @cached_property
    def law(self) -> Law:
        """The law as compiled code takes it."""
        parameters = np.array([self.minimum_stiffness, self.core, self.range, self.work_of_adhesion])
        return Law(laws.SPLINE, parameters, 1.0 + self.range)

    @property
    def work_of_adhesion(self) -> float:
        """Depth w = k Δr²/(12 a0²), in E* a0."""
        return self.minimum_stiffness * self.range**2 / 12

    @property
    def largest_tension(self) -> float:
        """(4/27) k Δr/a0², in E*, at a0 + Δr/3."""
        return 4 / 27 * self.minimum_stiffness * self.range

    @property
    def largest_softening(self) -> float:
        """k/3, in E*/a0, at a0 + 2Δr/3; whatever the range, if there is one."""
        return self.minimum_stiffness / 3 if self.range > 0 else 0.0

    @property
    def zero_gap(self) -> float:
        """The minimum of the energy, a0."""
        return 1.0


@dataclass(frozen=True)
class InversePowers(Wall):
    """Two inverse powers, not truncated: energy c [(a0/z)^m/m - (a0/z)^n/n], c = k a0/(m - n), minimum at a0.

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
    core: float = _CORE
    adhesion_length: InitVar[float | None] = None

    def __post_init__(self, adhesion_length: float | None) -> None:
        repulsion, attraction = pair("powers", self.powers)
        number("powers", repulsion, above=number("powers", attraction, above=1))
        number("core", self.core, above=0, below=1)
        if (adhesion_length is None) == _is_missing(self.minimum_stiffness):
            what = "exactly one of adhesion_length and minimum_stiffness"
            raise ArgumentError("adhesion_length", adhesion_length, what)
        if adhesion_length is not None:
            number("adhesion_length", adhesion_length, above=0)
            object.__setattr__(self, "minimum_stiffness", adhesion_length * self.powers[0] * self.powers[1])
        number("minimum_stiffness", self.minimum_stiffness, above=0)

    @cached_property
    def law(self) -> Law:
        """The law as compiled code takes it."""
        m, n = self.powers
        parameters = np.array([self.minimum_stiffness, self.core, float(m), float(n)])
        return Law(laws.INVERSE_POWERS, parameters, np.inf)

    @property
    def zero_gap(self) -> float:
        """The minimum of the energy, a0."""
        return 1.0

    @property
    def range(self) -> float:
        """The effective range: there is no cut-off."""
        return self.effective_range


@dataclass(frozen=True)
class Exponential(Wall):
    """Exponential attraction on a harmonic core: energy -γ exp(-z/ρ) outside, γ (z/ρ - 1) + K z²/2 for z < 0.

    The literature's hard wall with exponential adhesion is its limit of large K.  The traction changes sign at
    z = -γ/(ρ K), and the work of adhesion is γ + γ²/(2 ρ² K).

    Parameters
    ----------
    surface_energy : γ, in E* a0.
    decay_length : ρ, in a0.
    core_stiffness : K, in E*/a0.
    """

    surface_energy: float
    decay_length: float
    core_stiffness: float

    def __post_init__(self) -> None:
        for name in ("surface_energy", "decay_length", "core_stiffness"):
            number(name, getattr(self, name), above=0)

    @property
    def core(self) -> float:
        """No gap is too small for a harmonic core."""
        return -np.inf

    @cached_property
    def law(self) -> Law:
        """The law as compiled code takes it."""
        parameters = np.array([self.core_stiffness, self.surface_energy, self.decay_length])
        return Law(laws.EXPONENTIAL, parameters, np.inf)

    @property
    def zero_gap(self) -> float:
        """Where core and attraction balance."""
        return -self.surface_energy / (self.decay_length * self.core_stiffness)

    @property
    def range(self) -> float:
        """The effective range: there is no cut-off."""
        return self.effective_range

    @property
    def largest_tension(self) -> float:
        """γ/ρ, in E*, where the core ends."""
        return self.surface_energy / self.decay_length

    @property
    def largest_softening(self) -> float:
        """γ/ρ², in E*/a0, where the core ends."""
        return self.surface_energy / self.decay_length**2
