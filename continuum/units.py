"""Conversion between SI, eV/Å and reduced units; nothing else converts.

Reduced units are a0 = 1 and E* = 1 (see :mod:`continuum`): a quantity of dimension pressure^i length^j has
the unit E*^i a0^j.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.constants

ANGSTROM: float = scipy.constants.angstrom
"""One ångström, in m."""
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
        for name, value in (("a0", self.a0), ("contact_modulus", self.contact_modulus)):
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} is a positive finite number in SI units, got {value}")

    @classmethod
    def metal(cls, a0: float, contact_modulus: float) -> Units:
        """Units from a0 in Å and E* in eV/Å³: LAMMPS' ``units metal`` but for its pressure."""
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
        return value * self.si(quantity)


_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "A": ANGSTROM, "pm": 1e-12}
_EV_PER_A2 = scipy.constants.electron_volt / ANGSTROM**2
# Sizes in SI of the units that are understood, the ones to print first.
_UNITS: dict[Quantity, Mapping[str, float]] = {
    "length": _LENGTHS,
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "N/m2": 1.0,
                 "eV/A3": GPA_PER_EV_PER_A3 * scipy.constants.giga},
    "energy_per_area": {"J/m2": 1.0, "mJ/m2": 1e-3, "N/m": 1.0, "mN/m": 1e-3, "erg/cm2": 1e-3, "eV/A2": _EV_PER_A2},
}  # fmt: skip
_SHOWN = {"m", "mm", "um", "nm", "pm", "Pa", "kPa", "MPa", "GPa", "TPa", "J/m2", "mJ/m2"}


def unit_size(unit: str, quantity: Quantity) -> float:
    """Size in SI of a unit given by name: µm, um, nm, Å, GPa, mJ/m² or mJ/m^2, ...

    Raises ValueError if there is no such unit of this quantity; the message lists those that there are.
    """
    # NFKC turns the micro sign into a Greek mu, the Ångström sign into a letter and ² into 2.
    plain = unicodedata.normalize("NFKC", unit).replace("μ", "u").replace("Å", "A").replace("^", "").strip()
    known = _UNITS[quantity]
    if plain not in known:
        what = f"{unit!r} is no unit of {_words(quantity)}" if plain else f"a unit of {_words(quantity)} is missing"
        raise ValueError(f"{what}: write one of {', '.join(known)}")
    return known[plain]


def parse(text: str, quantity: Quantity) -> float:
    """A positive quantity with its unit, in SI: ``parse("50 mJ/m²", "energy_per_area")`` is 0.05.

    Raises ValueError if it is no positive number, or its unit is missing or of another quantity.
    """
    found = re.fullmatch(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", text)
    if found is None:
        example = f"1.5{next(iter(_UNITS[quantity]))}"
        raise ValueError(f"{text!r} is not a number with a unit of {_words(quantity)}: write one like {example}")
    try:
        value = float(found[1]) * unit_size(found[2], quantity)
    except ValueError as error:
        raise ValueError(f"{text!r}: {error}") from error
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"{text!r}: a {_words(quantity)} here is positive and finite")
    return value


def readable(value: float, quantity: Quantity, digits: int = 4) -> str:
    """A quantity in SI as text with the unit that suits its size."""
    if not (np.isfinite(value) and value):
        return f"{value:g}"
    sizes = {unit: size for unit, size in _UNITS[quantity].items() if unit in _SHOWN}
    # The unit in which the number is nearest to 10 and, if possible, between 1 and 1000.
    places = {unit: np.log10(abs(value) / size) for unit, size in sizes.items()}
    unit = min(places, key=lambda u: (not 0 <= places[u] < 3, abs(places[u] - 1)))
    return f"{value / sizes[unit]:.{digits}g} {unit.replace('2', '²').replace('um', 'µm')}"


def _words(quantity: Quantity) -> str:
    return quantity.replace("_", " ")
