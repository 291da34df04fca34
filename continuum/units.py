"""Where SI, eV/Å and reduced units meet, and nowhere else.

Reduced units are a0 = 1 and E* = 1 (see :mod:`continuum`): a quantity of dimension pressure^i length^j has
the unit E*^i a0^j.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.constants

__all__ = ["ANGSTROM", "GPA_PER_EV_PER_A3", "Quantity", "Units"]

ANGSTROM: float = scipy.constants.angstrom
"""In m."""
GPA_PER_EV_PER_A3: float = scipy.constants.electron_volt / ANGSTROM**3 / scipy.constants.giga
"""160.2177: a pressure of 1 eV/Å³ in GPa."""

Quantity = Literal[
    "length", "area", "pressure", "stiffness_per_area", "energy_per_area", "stiffness", "force", "energy"
]

# Powers of pressure and of length.
_POWERS: dict[Quantity, tuple[int, int]] = {
    "length": (0, 1),
    "area": (0, 2),
    "pressure": (1, 0),
    "stiffness_per_area": (1, -1),
    "energy_per_area": (1, 1),
    "stiffness": (1, 1),
    "force": (1, 2),
    "energy": (1, 3),
}


@dataclass(frozen=True)
class Units:
    """A material that gives the reduced units their size.

    Parameters
    ----------
    a0 : spacing of the surface atoms, in m.
    contact_modulus : E* = E/(1 - ν²), in Pa.

    Examples
    --------
    >>> units = Units(a0=0.3e-9, contact_modulus=1e9)
    >>> round(units.to_si(0.05, "energy_per_area"), 6)  # w = l_a E*, in J/m²
    0.015
    """

    a0: float
    contact_modulus: float

    def __post_init__(self) -> None:
        """Refuse what has no meaning."""
        for name, value in (("a0", self.a0), ("contact_modulus", self.contact_modulus)):
            if not (np.isfinite(value) and value > 0):
                msg = f"{name} is a positive finite number in SI units, got {value}"
                raise ValueError(msg)

    @classmethod
    def metal(cls, a0: float, contact_modulus: float) -> Units:
        """From a0 in Å and E* in eV/Å³, LAMMPS' ``units metal`` but for its pressure."""
        return cls(a0 * ANGSTROM, contact_modulus * GPA_PER_EV_PER_A3 * scipy.constants.giga)

    def si(self, quantity: Quantity) -> float:
        """Size of the reduced unit in SI: m, m², Pa, Pa/m, J/m², N/m, N, J."""
        i, j = _POWERS[quantity]
        return float(self.contact_modulus**i * self.a0**j)

    def ev_angstrom(self, quantity: Quantity) -> float:
        """Size of the reduced unit in eV and Å: Å, Å², eV/Å³, eV/Å⁴, eV/Å², eV/Å², eV/Å, eV."""
        i, j = _POWERS[quantity]
        modulus = self.contact_modulus / scipy.constants.giga / GPA_PER_EV_PER_A3
        return float(modulus**i * (self.a0 / ANGSTROM) ** j)

    def to_si(self, value: float, quantity: Quantity) -> float:
        """A reduced value in SI units."""
        return value * self.si(quantity)

    def from_si(self, value: float, quantity: Quantity) -> float:
        """A value in SI units, reduced."""
        return value / self.si(quantity)

    def to_ev_angstrom(self, value: float, quantity: Quantity) -> float:
        """A reduced value in eV and Å."""
        return value * self.ev_angstrom(quantity)

    def from_ev_angstrom(self, value: float, quantity: Quantity) -> float:
        """A value in eV and Å, reduced."""
        return value / self.ev_angstrom(quantity)
