"""The exponential wall law."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import scipy

from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.wall import Wall
from continuum.tables import Positive

_NODES, _WEIGHTS = np.polynomial.laguerre.laggauss(20)
"""Of integrals of a smooth function times exp(-y)."""


class Exponential(Wall, kind="exponential"):
    """Exponential attraction on a harmonic core: energy -γ exp(-z/ρ) outside, γ (z/ρ - 1) + K z²/2 for z < 0.

    The literature's hard wall with exponential adhesion is its limit of large K.  The traction changes sign at
    z = -γ/(ρ K), and the work of adhesion is γ + γ²/(2 ρ² K).
    """

    example: ClassVar[Mapping[str, Any]] = {"surface_energy": 0.01, "decay_length": 0.3, "core_stiffness": 2.0}
    core: ClassVar[float] = -np.inf
    """A harmonic core holds at any gap."""

    surface_energy: Positive
    """γ, in E* a0"""
    decay_length: Positive
    """ρ, in a0"""
    core_stiffness: Positive
    """K, in E*/a0"""

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

    @cached_property
    def effective_range(self) -> float:
        """Effective range of the attraction, Eq. (S-5), in closed form."""
        end = -self.zero_gap  # of the core: the tension K Δ grows up to γ/ρ there, and then decays
        x = end / self.decay_length
        # ∫ (x + y)^(-1/3) exp(-y) dy: in a long way Gauss's nodes, where exp(x) would be infinite, have every digit.
        beyond = (
            np.exp(x) * scipy.special.gamma(2 / 3) * scipy.special.gammaincc(2 / 3, x)
            if x < 100
            else np.sum(_WEIGHTS / np.cbrt(x + _NODES))
        )
        # Both integrals over γ/ρ, in powers of ρ.
        weighted, work = 0.6 * np.cbrt(x) ** 2 + beyond, x / 2 + 1
        return self.decay_length * float((2 / 3 * weighted / work) ** -3)

    @property
    def equivalent_range(self) -> float:
        return float((24 * self.surface_energy) ** 0.5)
