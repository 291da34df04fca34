"""Conversion between SI, eV/Å and reduced units.

Reduced units are a0 = 1 and E* = 1 (see :mod:`continuum`): a quantity of dimension pressure^i length^j has
the unit E*^i a0^j.  With moving atoms of mass m, times and velocities also have a unit, and temperatures that of k_B T.
"""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
import scipy

ANGSTROM = 1e-10
"""One ångström, in m."""
_EV, _GIGA = 1.602176634e-19, 1e9  # the electronvolt in J is exact by the definition of the SI
GPA_PER_EV_PER_A3 = _EV / ANGSTROM**3 / _GIGA
"""160.2177: a pressure of 1 eV/Å³ in GPa."""

Quantity = Literal[
    "length", "area", "pressure", "stiffness_per_area", "energy_per_area", "stiffness", "force", "energy"
]

Motion = Literal["time", "velocity", "temperature"]
"""Quantities of atoms that move."""

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
    mass : of an atom, in kg, which times and velocities need; None if there are no atoms.

    Examples
    --------
    >>> units = Units(a0=0.3e-9, contact_modulus=1e9)
    >>> round(units.to_si(0.05, "energy_per_area"), 6)  # w = l_a E*, in J/m²
    0.015
    """

    a0: float
    contact_modulus: float
    mass: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} is a positive finite number in SI units, got {value}")

    @classmethod
    def metal(cls, a0: float, contact_modulus: float, mass: float | None = None) -> Self:
        """Units from a0 in Å, E* in eV/Å³ and a mass in g/mol: LAMMPS' ``units metal`` but for its pressure."""
        kilograms = None if mass is None else mass * scipy.constants.atomic_mass
        return cls(a0 * ANGSTROM, contact_modulus * GPA_PER_EV_PER_A3 * _GIGA, kilograms)

    def si(self, quantity: Quantity | Motion) -> float:
        """Size of the reduced unit in SI: m, m², Pa, Pa/m, J/m², N/m, N, J; s, m/s and K.

        Time a0 (m/(E* a0³))^(1/2), velocity (E* a0³/m)^(1/2) and temperature E* a0³/k_B are those of atoms.  Raises
        ValueError for the first two if there is no mass.
        """
        if quantity == "temperature":
            return self.si("energy") / scipy.constants.k
        if quantity == "velocity" or quantity == "time":
            if self.mass is None:
                raise ValueError(f"a {quantity} has a unit where atoms have a mass")
            velocity = float((self.si("energy") / self.mass) ** 0.5)
            return velocity if quantity == "velocity" else self.a0 / velocity
        i, j = _POWERS[quantity]
        return float(self.contact_modulus**i * self.a0**j)

    def to_si(self, value: float, quantity: Quantity | Motion) -> float:
        return value * self.si(quantity)


_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "A": ANGSTROM, "pm": 1e-12}
_EV_PER_A = _EV / ANGSTROM
_EV_PER_A2 = _EV / ANGSTROM**2
# Sizes in SI of the known units; those for printing come first.
_UNITS: dict[Quantity | Motion, Mapping[str, float]] = {
    "length": _LENGTHS,
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "N/m2": 1.0,
                 "eV/A3": GPA_PER_EV_PER_A3 * _GIGA},
    "energy_per_area": {"J/m2": 1.0, "mJ/m2": 1e-3, "N/m": 1.0, "mN/m": 1e-3, "erg/cm2": 1e-3, "eV/A2": _EV_PER_A2},
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "nN": 1e-9, "pN": 1e-12, "eV/A": _EV_PER_A},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "ps": 1e-12, "fs": 1e-15},
    "velocity": {"m/s": 1.0, "km/s": 1e3, "mm/s": 1e-3, "um/s": 1e-6, "nm/s": 1e-9, "nm/ns": 1.0, "A/ps": 100.0},
    "temperature": {"K": 1.0, "mK": 1e-3},
}  # fmt: skip
_NEVER_SHOWN = {
    "A", "N/m2", "eV/A3", "N/m", "mN/m", "erg/cm2", "eV/A2", "eV/A", "ms", "um/s", "nm/s",
    "nm/ns", "A/ps", "mK",
}  # fmt: skip


def unit_size(unit: str, quantity: Quantity | Motion) -> float:
    """Size in SI of a unit given by name: µm, um, nm, Å, GPa, mJ/m² or mJ/m^2, ...

    Raises ValueError if this quantity has no such unit; the message lists the known ones.
    """
    # NFKC turns the micro sign into a Greek mu, the Ångström sign into a letter and ² into 2.
    plain = unicodedata.normalize("NFKC", unit).replace("μ", "u").replace("Å", "A").replace("^", "").strip()
    known = _UNITS[quantity]
    if plain not in known:
        what = f"{unit!r} is not a unit of {_words(quantity)}" if plain else f"a unit of {_words(quantity)} is missing"
        raise ValueError(f"{what}: write one of {', '.join(known)}")
    return known[plain]


def parse(text: str, quantity: Quantity | Motion, *, signed: bool = False) -> float:
    """A quantity with its unit, in SI: ``parse("50 mJ/m²", "energy_per_area")`` is 0.05.

    Raises ValueError if it is not a positive number (with ``signed``: not finite), or its unit is missing or wrong.
    """
    found = re.fullmatch(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", text)
    if found is None:
        example = f"1.5{next(iter(_UNITS[quantity]))}"
        raise ValueError(f"{text!r} is not a number with a unit of {_words(quantity)}: write one like {example}")
    try:
        value = float(found[1]) * unit_size(found[2], quantity)
    except ValueError as error:
        raise ValueError(f"{text!r}: {error}") from error
    if not (np.isfinite(value) and (signed or value > 0)):
        raise ValueError(f"{text!r}: a {_words(quantity)} here is {'finite' if signed else 'positive and finite'}")
    return value


def readable(value: float, quantity: Quantity | Motion, digits: int = 4) -> str:
    """A quantity in SI as text with the unit that suits its size."""
    if not (np.isfinite(value) and value):
        return f"{value:g}"
    sizes = {unit: size for unit, size in _UNITS[quantity].items() if unit not in _NEVER_SHOWN}
    # The unit in which the number is nearest to 10 and, if possible, between 1 and 1000.
    places = {unit: np.log10(abs(value) / size) for unit, size in sizes.items()}
    unit = min(places, key=lambda u: (not 0 <= places[u] < 3, abs(places[u] - 1)))
    return f"{value / sizes[unit]:.{digits}g} {re.sub('^u', 'µ', unit).replace('2', '²')}"


def per_area(value: float, units: Units | None) -> str:
    """A work of adhesion in E* a0, which is the adhesion length in a0, as text; also in J/m² where there are units."""
    real = "" if units is None else f" = {readable(units.to_si(value, 'energy_per_area'), 'energy_per_area')}"
    return f"{value:.4g} E* a0{real}"


def _words(quantity: Quantity | Motion) -> str:
    return quantity.replace("_", " ")
