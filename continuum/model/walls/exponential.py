"""The exponential wall law."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from continuum.arguments import number
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.wall import Wall, WallTable
from continuum.tables import Positive


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
    core: ClassVar[float] = -np.inf
    """A harmonic core holds at any gap."""

    def __post_init__(self) -> None:
        for name in ("surface_energy", "decay_length", "core_stiffness"):
            number(name, getattr(self, name), above=0)

    @cached_property
    def law(self) -> Law:
        parameters = np.array([self.core_stiffness, self.surface_energy, self.decay_length])
        return Law(laws.EXPONENTIAL, parameters, np.inf)

    @property
    def zero_gap(self) -> float:
        """Gap where core and attraction balance."""
        return -self.surface_energy / (self.decay_length * self.core_stiffness)

    @property
    def stationary_gaps(self) -> Real:
        """0, where the core ends: the largest tension is γ/ρ, the largest softening γ/ρ²."""
        return np.zeros(1)


class ExponentialWall(WallTable):
    """[wall] of law "exponential": attraction on a stiff core."""

    law: Literal["exponential"]
    surface_energy: Positive
    """γ, in E* a0"""
    decay_length: Positive
    """ρ, in a0"""
    core_stiffness: Positive
    """K, in E*/a0"""

    @property
    def equivalent_range(self) -> float:
        return float((24 * self.surface_energy) ** 0.5)

    def build(self) -> Wall:
        return Exponential(**self.keywords())
