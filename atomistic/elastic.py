"""Contact modulus of the (100) surface of a cubic crystal, by direction and as a mean."""

from __future__ import annotations

import numpy as np

from continuum.anisotropic import CubicConstants, directional_contact_modulus

__all__ = ["CubicConstants", "contact_modulus", "directional_contact_modulus"]

# The integrand is smooth and periodic, so that equal weights converge exponentially.
_DIRECTIONS = 128


def contact_modulus(constants: CubicConstants) -> float:
    """Mean contact modulus of the (100) surface, 1/<1/E*(θ)> over all directions, in the unit of the constants.

    The mean of the compliance is the compliance of the axially symmetric part of the response.

    Raises
    ------
    ValueError
        If the crystal is not stable.
    """
    angles = np.arange(_DIRECTIONS, dtype=np.float64) * (np.pi / 2 / _DIRECTIONS)
    return float(1 / np.mean(1 / directional_contact_modulus(constants, angles)))
