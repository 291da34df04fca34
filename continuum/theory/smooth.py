"""Spheres: Hertz, JKR, DMT, and Maugis and Dugdale between, for probes and estimates, and to test the solver by.

Independent of the solver.  A rigid sphere on an elastic half-space; E* = 1 unless given, and any consistent units.
Compressive loads are positive.  Adhesion has a work w per area; JKR is the limit of short range, DMT that of long
range, and Maugis and Dugdale's constant tension w/h0 over a distance h0 lies between.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

Real = NDArray[np.float64]
HARD, SOFT = 1e-3, 1e3
"""Maugis' λ below and above which the force is that of DMT and JKR to one part in a thousand, and the equations lose
digits."""


def tabor_parameter(radius: float, work_of_adhesion: float, distance: float, contact_modulus: float = 1.0) -> float:
    """μ = (R w²/(E*² h0³))^(1/3): elastic stretch of a sphere's edge over the range h0 of its adhesion.

    JKR holds above about 5, DMT below about 0.1 (Tabor, J. Colloid Interface Sci. 58, 2 (1977)).  With the distance of
    Maugis and Dugdale, h0 = w/(largest tension), their λ is (9/2π)^(1/3) μ = 1.127 μ.
    """
    return float(np.cbrt(radius * (work_of_adhesion / contact_modulus) ** 2) / distance)


@dataclass(frozen=True)
class Hertz:
    """A rigid sphere on an elastic half-space (Johnson, Contact Mechanics, 1985, section 4.2).

    Parameters
    ----------
    radius : radius of the sphere, in a0.
    load : N, in E* a0².
    contact_modulus : E*.
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
class AdhesiveSphere:
    """An adhesive rigid sphere.

    Parameters
    ----------
    radius, work_of_adhesion, contact_modulus : R, w, E*.
    """

    radius: float
    work_of_adhesion: float
    contact_modulus: float = 1.0


class DMT(AdhesiveSphere):
    """Adhesive sphere, range of adhesion long against its deformation: Hertz under the load N + 2π w R.

    Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53, 314 (1975), in the form of Maugis (1992).
    """

    @property
    def pull_off_force(self) -> float:
        """Largest tension, 2π w R."""
        return 2 * np.pi * self.work_of_adhesion * self.radius

    def contact_radius(self, load: float) -> float:
        """Radius of contact under a load above -2π w R."""
        return Hertz(self.radius, load + self.pull_off_force, self.contact_modulus).contact_radius


class JKR(AdhesiveSphere):
    """Adhesive sphere, range of adhesion short against its deformation.

    Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 301 (1971): Hertz minus a flat punch whose edge releases w.
    """

    @property
    def pull_off_force(self) -> float:
        """Largest tension, (3/2)π w R, independent of E*; the sphere jumps out there under a given load."""
        return 1.5 * np.pi * self.work_of_adhesion * self.radius

    @property
    def separation_force(self) -> float:
        """Tension at which the sphere jumps out under a given indentation, (5/6)π w R."""
        return 5 / 6 * np.pi * self.work_of_adhesion * self.radius

    @property
    def separation_distance(self) -> float:
        """Stretch at which the sphere jumps out, δ_c = (3/4)(π² w² R/E*²)^(1/3): the paper's δ_c."""
        return float(0.75 * np.cbrt((np.pi * self.work_of_adhesion / self.contact_modulus) ** 2 * self.radius))

    @property
    def zero_load_radius(self) -> float:
        """Radius of contact without load, (9π w R²/(2 E*))^(1/3)."""
        return float(np.cbrt(4.5 * np.pi * self.work_of_adhesion * self.radius**2 / self.contact_modulus))

    def load(self, contact_radius: float) -> float:
        """N = 4 E* a³/(3R) - sqrt(8π w E* a³)."""
        a, modulus = contact_radius, self.contact_modulus
        return float(
            4 * modulus * a**3 / (3 * self.radius) - np.sqrt(8 * np.pi * self.work_of_adhesion * modulus * a**3)
        )

    def indentation(self, contact_radius: float) -> float:
        """δ = a²/R - sqrt(2π w a/E*)."""
        a = contact_radius
        return float(a**2 / self.radius - np.sqrt(2 * np.pi * self.work_of_adhesion * a / self.contact_modulus))

    def contact_radius(self, load: float) -> float:
        """Radius of contact under a load above the pull-off force, on the stable branch.

        ::

            a³ = (3R/(4E*)) (N + 3π w R + sqrt(6π w R N + (3π w R)²))
        """
        w = 3 * np.pi * self.work_of_adhesion * self.radius
        square = w * (2 * load + w)
        if abs(square) < 1e-14 * w**2:
            square = 0.0  # at the pull-off force, but for rounding
        return float(np.cbrt(0.75 * self.radius / self.contact_modulus * (load + w + np.sqrt(square))))

    def pressure(self, r: Real, contact_radius: float) -> Real:
        """Pressure (2E*a/πR) sqrt(1 - r²/a²) - sqrt(2 w E*/(π a))/sqrt(1 - r²/a²) inside the contact."""
        a = contact_radius
        root = np.sqrt(1 - (r / a) ** 2)
        edge = np.sqrt(2 * self.work_of_adhesion * self.contact_modulus / (np.pi * a))
        pressure: Real = 2 * self.contact_modulus * a / (np.pi * self.radius) * root - edge / root
        return pressure


class SphereState(NamedTuple):
    """One equilibrium of an adhesive sphere."""

    contact_radius: float
    """Radius a of the contact."""
    rim_radius: float
    """Radius c up to which the surfaces attract one another."""
    load: float
    """Load N; negative under tension."""
    indentation: float
    """Indentation δ, the approach of distant points."""


@dataclass(frozen=True)
class MaugisDugdale:
    """Adhesive sphere with a constant tension w/h0 up to a gap h0: from DMT to JKR.

    Maugis, J. Colloid Interface Sci. 150, 243 (1992).  With K = 4E*/3, lengths in (π w R²/K)^(1/3), loads in π w R,
    m = c/a and λ the parameter, the gap at the rim equals h0 where::

        λ a²/2 [sqrt(m²-1) + (m²-2) asec m] + 4λ² a/3 [sqrt(m²-1) asec m - m + 1] = 1
        N = a³ - λ a² [sqrt(m²-1) + m² asec m]
        δ = a² - 4λ a/3 sqrt(m²-1)                               in (π² w² R/K²)^(1/3)

    Parameters
    ----------
    radius, work_of_adhesion, contact_modulus : R, w, E*.
    distance : h0, gap up to which the tension w/h0 acts.
    """

    radius: float
    work_of_adhesion: float
    distance: float
    contact_modulus: float = 1.0

    @property
    def parameter(self) -> float:
        """λ = 2 (w/h0) (R/(π w K²))^(1/3) = (9 R w²/(2π E*² h0³))^(1/3)."""
        mu = tabor_parameter(self.radius, self.work_of_adhesion, self.distance, self.contact_modulus)
        return float(np.cbrt(9 / (2 * np.pi)) * mu)

    @property
    def _length(self) -> float:
        return float(np.cbrt(0.75 * np.pi * self.work_of_adhesion * self.radius**2 / self.contact_modulus))

    @property
    def _force(self) -> float:
        return np.pi * self.work_of_adhesion * self.radius

    def state(self, contact_radius: float) -> SphereState:
        """The equilibrium at a given radius of contact, above zero."""
        a, unit = contact_radius / self._length, self.parameter

        def rim(excess: float) -> float:
            root, angle = _rim(excess)
            m = 1 + excess
            opening = root + (m * m - 2) * angle
            return unit * a * a / 2 * opening + 4 * unit**2 * a / 3 * (root * angle - excess) - 1

        high = 1.0
        while rim(high) < 0:
            high *= 4
        excess = scipy.optimize.brentq(rim, 0.0, high, xtol=1e-15, rtol=1e-14)
        root, angle = _rim(excess)
        load = self._force * (a**3 - unit * a * a * (root + (1 + excess) ** 2 * angle))
        indentation = (a * a - 4 * unit * a / 3 * root) * self._length**2 / self.radius
        return SphereState(contact_radius, contact_radius * (1 + excess), float(load), float(indentation))

    @property
    def _pull_off(self) -> tuple[float, float]:
        """Radius of contact at the largest tension, and that tension."""

        def load(a: float) -> float:
            return self.state(a * self._length).load / self._force

        # JKR pulls off at 1.145 units, longer ranges at smaller contacts, DMT at zero.
        found = scipy.optimize.minimize_scalar(load, bounds=(1e-4, 1.3), method="bounded", options={"xatol": 1e-7})
        return float(found.x * self._length), float(-found.fun * self._force)

    @property
    def pull_off_force(self) -> float:
        """Largest tension, between (3/2)π w R (λ large) and 2π w R (λ small)."""
        if self.parameter <= HARD:
            return float(2 * np.pi * self.work_of_adhesion * self.radius)
        if self.parameter >= SOFT:
            return JKR(self.radius, self.work_of_adhesion, self.contact_modulus).pull_off_force
        return self._pull_off[1]

    @property
    def pull_off_radius(self) -> float:
        """Radius of contact at the largest tension."""
        return self._pull_off[0]

    def contact_radius(self, load: float) -> float:
        """Radius of contact under a load above the pull-off force, on the stable branch."""
        low = self._pull_off[0] / self._length
        high = max(low, 1.0)

        def excess(a: float) -> float:
            return (self.state(a * self._length).load - load) / self._force

        while excess(high) < 0:
            high *= 2
        return float(scipy.optimize.brentq(excess, low, high, xtol=1e-12) * self._length)


def _rim(excess: float) -> tuple[float, float]:
    """sqrt(m² - 1) and asec m = arctan sqrt(m² - 1), from m - 1 without cancellation."""
    root = np.sqrt(excess * (2 + excess))
    return float(root), float(np.arctan(root))
