"""Contact modulus of the (100) surface of a cubic crystal, by direction and as a mean."""

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from continuum.model.cubic import CubicConstants, contact_modulus, directional_contact_modulus
from continuum.model.fourier import Real

_DIRECTIONS = 128


@dataclass(frozen=True, eq=False)
class ContactModulus:
    """E*(θ) of the (100) surface, for wavevectors at angles θ to the cubic axis <100>, in the unit of the constants."""

    angles: Real = field(repr=False)
    """θ over a period, from <100> by <110> at π/4 to the next <100>, in radians."""
    values: Real = field(repr=False)
    """Contact modulus E*(θ), same shape."""
    mean: float
    """1/<1/E*>: the mean of the compliance is the compliance of the axially symmetric part of the response."""

    @classmethod
    def of(cls, constants: CubicConstants) -> Self:
        """Contact modulus from elastic constants.

        Raises ValueError if the crystal is not stable.
        """
        angles = np.arange(_DIRECTIONS + 1, dtype=np.float64) * (np.pi / 2 / _DIRECTIONS)
        values = directional_contact_modulus(constants, angles)
        return cls(angles, values, contact_modulus(constants, _DIRECTIONS))

    @property
    def smallest(self) -> float:
        """Contact modulus in the softest direction."""
        return float(self.values.min())

    @property
    def largest(self) -> float:
        """Contact modulus in the stiffest direction."""
        return float(self.values.max())

    @property
    def along_100(self) -> float:
        """Contact modulus along <100>, θ = 0."""
        return float(self.values[0])

    @property
    def along_110(self) -> float:
        """θ = π/4: along the rows of nearest neighbours, which are the axes of the surface grid."""
        return float(self.values[_DIRECTIONS // 2])
