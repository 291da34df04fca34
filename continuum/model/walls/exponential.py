"""The exponential wall law."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import scipy

from continuum.inputs.keys import Positive
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.walls.wall import Wall
from continuum.theory import paper


class Exponential(Wall, kind="exponential"):
    """Exponential attraction on a harmonic core: energy -γ exp(-z/ρ) outside, γ (z/ρ - 1) + K z²/2 for z < 0.

    The literature's hard wall with exponential adhesion is its limit of large K.  The traction changes sign at
    z = -γ/(ρ K), and the work of adhesion is γ + γ²/(2 ρ² K).

    Examples
    --------
    >>> import continuum as c
    >>> wall = c.Exponential(surface_energy=0.01, decay_length=0.2, core_stiffness=5)
    >>> round(wall.work_of_adhesion, 6)  # γ + γ²/(2 ρ² K)
    0.01025
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
        """Effective range of the attraction, Eq. (S-5), in closed form, to ten digits."""
        x = -self.zero_gap / self.decay_length  # the end of the core: tension grows up to γ/ρ there, and then decays
        # Both integrals over γ/ρ, in powers of ρ; Tricomi's U is exp(x) Γ(2/3, x), which is finite for any x.
        weighted, work = 0.6 * np.cbrt(x) ** 2 + scipy.special.hyperu(1 / 3, 1 / 3, x), x / 2 + 1
        return self.decay_length * paper.range_of_integrals(weighted, work)

    @property
    def equivalent_range(self) -> float:
        return float((24 * self.surface_energy) ** 0.5)
