"""Equations of the paper and the classical solutions that the solver is held against.

Independent of the solver: numpy and scipy only.  Reduced units unless a modulus is given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

__all__ = [
    "PERIMETER_FACTOR",
    "PERIMETER_FACTOR_PAPER",
    "Hertz",
    "Westergaard",
    "effective_range",
    "snap_in_wavelength",
    "spline_adhesion_length",
]

Real = NDArray[np.float64]

PERIMETER_FACTOR_PAPER = float(4 * np.arcsinh(1) / np.pi)
"""β = 1.1222 in P = β a0 N_P (Suppl. S-II): the mean of 1/cos θ over -π/4 < θ < π/4."""

PERIMETER_FACTOR = float(np.pi / (2 * np.sqrt(2)))
"""β = 1.1107, which counted discs confirm: a line of length L has L cos θ/a0 perimeter cells (the paper prints
L/(a0 cos θ)), so that an isotropic perimeter has P <cos θ>/a0 of them and β = 1/<cos θ>."""


def spline_adhesion_length(range: float) -> float:
    """Length l_a = w/E* = Δr²/(24 a0) of the paper's law with k = E* a0/2, in a0; the paper's Methods."""
    return range**2 / 24


def effective_range(attraction: Callable[[float], float], cutoff: float = np.inf) -> float:
    """Effective range of an attractive law, Eq. (deltar).

    ::

        Δr^(-1/3) = (2/3) ∫ Δ^(-1/3) p(Δ) dΔ / ∫ p(Δ) dΔ

    With Δ = s³ both integrands are smooth at contact.

    Parameters
    ----------
    attraction : p(Δ), attractive pressure at a distance Δ > 0 beyond the minimum of the energy, positive.
        (In the paper's Eq. (potential) the pressure has the other sign.)
    cutoff : distance beyond which p vanishes, in the same unit; infinite if it does not.
    """
    end = np.cbrt(cutoff)
    weighted = quad(lambda s: 3 * s * attraction(s**3), 0, end, epsabs=0, epsrel=1e-11, limit=400)[0]
    work = quad(lambda s: 3 * s**2 * attraction(s**3), 0, end, epsabs=0, epsrel=1e-11, limit=400)[0]
    return float((2 / 3 * weighted / work) ** -3)


def snap_in_wavelength(largest_softening: float, contact_modulus: float = 1.0) -> float:
    """Wavelength above which two flats snap together: where E* q/2 falls below the law's softening, in a0.

    For the paper's law the softening is at most E*/(6 a0), whatever its range: 6π a0.
    """
    return np.pi * contact_modulus / largest_softening


@dataclass(frozen=True)
class Hertz:
    """A rigid sphere on an elastic half-space (Johnson, Contact Mechanics, 1985, section 4.2).

    Parameters
    ----------
    radius : of the sphere, in a0.
    contact_modulus : E*.
    load : N, in E* a0².
    """

    radius: float
    load: float
    contact_modulus: float = 1.0

    @property
    def contact_radius(self) -> float:
        """Radius a, a³ = 3 N R/(4 E*)."""
        return float(np.cbrt(0.75 * self.load * self.radius / self.contact_modulus))

    @property
    def indentation(self) -> float:
        """Approach of distant points, a²/R."""
        return self.contact_radius**2 / self.radius

    def pressure(self, r: Real) -> Real:
        """Pressure p0 sqrt(1 - r²/a²) with p0 = 3 N/(2π a²), at a distance r from the axis."""
        a = self.contact_radius
        return 1.5 * self.load / (np.pi * a**2) * np.sqrt(np.maximum(1 - (r / a) ** 2, 0.0))


@dataclass(frozen=True)
class Westergaard:
    """A rigid one-dimensional wave, height Δ cos(2πx/λ), on an elastic half-space (Johnson, section 13.2).

    Parameters
    ----------
    amplitude : Δ, in a0.
    wavelength : λ, in a0.
    pressure : mean pressure p̄, in E*; full contact at p* = π E* Δ/λ.
    contact_modulus : E*.
    """

    amplitude: float
    wavelength: float
    mean_pressure: float
    contact_modulus: float = 1.0

    @property
    def full_pressure(self) -> float:
        """Mean pressure p* = π E* Δ/λ at which contact is complete."""
        return np.pi * self.contact_modulus * self.amplitude / self.wavelength

    @property
    def half_width(self) -> float:
        """Half-width a of a contact, p̄ = p* sin²(πa/λ)."""
        return float(self.wavelength / np.pi * np.arcsin(np.sqrt(min(self.mean_pressure / self.full_pressure, 1))))

    def pressure(self, x: Real) -> Real:
        """Pressure 2p̄ cos ψ sqrt(sin² ψ_a - sin² ψ)/sin² ψ_a, ψ = πx/λ, at x from a crest; zero outside."""
        psi, edge = np.pi * x / self.wavelength, np.sin(np.pi * self.half_width / self.wavelength) ** 2
        inside = np.maximum(edge - np.sin(psi) ** 2, 0.0)
        pressure: Real = 2 * self.mean_pressure * np.abs(np.cos(psi)) * np.sqrt(inside) / edge
        return pressure
