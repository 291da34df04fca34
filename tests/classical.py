"""A wave without adhesion, and with adhesion of short range: exact solutions by which the solver is tested.

A rigid wave on an elastic half-space; E* = 1 unless given, and any consistent units.  Compression is positive.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from continuum.model.fourier import Real


@dataclass(frozen=True)
class Westergaard:
    """A rigid one-dimensional wave, height Δ cos(2πx/λ), on an elastic half-space (Johnson, section 13.2).

    Parameters
    ----------
    amplitude : Δ, in a0.
    wavelength : λ, in a0.
    mean_pressure : p̄, in E*; full contact at p* = π E* Δ/λ.
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


@dataclass(frozen=True)
class AdhesiveWave:
    """A rigid wave, height Δ cos(2πx/λ), with adhesion of short range (Johnson, Int. J. Solids Struct. 32, 423 (1995)).

    Westergaard's contact of half-width a under p* sin² ψ, ψ = πa/λ, and on it the tension of a row of bonded strips,
    σ cos ψ_x/sqrt(sin² ψ - sin² ψ_x), of mean σ.  Its stress intensity K_I = σ sqrt(λ cot ψ) releases w = K_I²/(2E*)
    at the edge::

        p̄/p* = sin² ψ - α sqrt(tan ψ),         α = sqrt(2 w E*/λ)/p* = sqrt(2 λ l_a)/(π Δ)

    Parameters
    ----------
    amplitude, wavelength, work_of_adhesion, contact_modulus : Δ, λ, w, E*.
    """

    amplitude: float
    wavelength: float
    work_of_adhesion: float
    contact_modulus: float = 1.0

    full_pressure = Westergaard.full_pressure

    @property
    def alpha(self) -> float:
        """Johnson's α.  Above 0.570 the wave jumps to full contact without load; above 1.065 no width is stable."""
        length = self.work_of_adhesion / self.contact_modulus
        return float(np.sqrt(2 * self.wavelength * length) / (np.pi * self.amplitude))

    def mean_pressure(self, half_width: float) -> float:
        """p̄ of a contact of a given half-width, below λ/2."""
        psi = np.pi * half_width / self.wavelength
        return float(self.full_pressure * (np.sin(psi) ** 2 - self.alpha * np.sqrt(np.tan(psi))))

    def pressure(self, x: Real, half_width: float) -> Real:
        """Pressure at x from a crest, inside the contact."""
        psi, edge = np.pi * np.asarray(x) / self.wavelength, np.pi * half_width / self.wavelength
        root = np.sqrt(np.sin(edge) ** 2 - np.sin(psi) ** 2)
        pull = self.alpha * np.sqrt(np.tan(edge))
        pressure: Real = self.full_pressure * np.cos(psi) * (2 * root - pull / root)
        return pressure

    def _stationary_width(self, first: bool) -> float:
        # dp̄/dψ = 0 where 4 sin^(3/2) ψ cos^(5/2) ψ = α; the left side is largest at tan² ψ = 3/5.
        top = np.arctan(np.sqrt(0.6))

        def left(psi: float) -> float:
            return float(4 * np.sin(psi) ** 1.5 * np.cos(psi) ** 2.5 - self.alpha)

        if left(top) <= 0:
            raise ValueError(f"a wave of alpha = {self.alpha:.3g}, above 1.065, has no stable partial contact")
        psi = scipy.optimize.brentq(left, *((0.0, top) if first else (top, np.pi / 2)), rtol=1e-13)
        return float(psi * self.wavelength / np.pi)

    @property
    def pull_off_width(self) -> float:
        """Half-width of the contact at the largest tension; raises ValueError if there is none."""
        return self._stationary_width(True)

    @property
    def pull_off_pressure(self) -> float:
        """Largest tension of partial contact, as a positive mean pressure."""
        return -self.mean_pressure(self.pull_off_width)

    @property
    def snap_in_width(self) -> float:
        """Half-width at which the contact jumps to full contact under more load; raises ValueError if there is none."""
        return self._stationary_width(False)
