"""Equations of the paper and of its supplement, as functions.

Independent of the solver: numpy and scipy only.  Lengths are in any one unit, a0 in reduced units, and so are moduli;
where E* enters it is the last argument, 1 unless given.  Whether they hold for a given contact is judged in
:mod:`continuum.maps.verdict.criteria`.  Smooth contacts are in :mod:`continuum.theory.smooth`, other theories of rough
contact in :mod:`continuum.theory.rough`.

Equations carry the numbers of the printed paper; in its source they have the labels (1) eqkappa, (3) eqrenkappa,
(4) attrep, (6) adcond, (S-1) gap, (S-2) datt, (S-3) Natt, (S-4) datt2, (S-5) deltar, (S-6) potential; (2), (5) and
(S-7) have none.

Symbols: h' = ``rms_slope``, h'' = ``rms_curvature`` = sqrt<(laplacian h)²>, Δr = ``range``, w = ``work_of_adhesion``,
l_a = w/E* = ``adhesion_length``, d_rep = ``diameter``.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

Real = NDArray[np.float64]

KAPPA_REP = 2.0
"""κ_rep of rough contact without adhesion, "close to 2" in the paper.  It depends on the softness of the wall and the
number of asperities: 2.2 - 2.4 for the paper's wall at 1 % area, 2.04 for a hard one."""

PERIMETER_FACTOR_PAPER = float(4 * np.arcsinh(1) / np.pi)
"""β = 1.1222 in P = β a0 N_P (Suppl. S-II): the mean of 1/cos θ over -π/4 < θ < π/4."""

PERIMETER_FACTOR = float(np.pi / (2 * np.sqrt(2)))
"""β = 1.1107, which counted discs confirm: a line of length L has L cos θ/a0 perimeter cells (the paper prints
L/(a0 cos θ)), so that an isotropic perimeter has P <cos θ>/a0 of them and β = 1/<cos θ>."""


# --- load and area -----------------------------------------------------------------------------------------


def repulsive_pressure(rms_slope: float, kappa_rep: float = KAPPA_REP, contact_modulus: float = 1.0) -> float:
    """Mean pressure in repulsive contact, p_rep = N_rep/A_rep = h' E*/κ_rep, Eq. (1).

    For A_rep much smaller than A0; the paper finds it unchanged by adhesion.
    """
    return rms_slope * contact_modulus / kappa_rep


def adhesive_pressure(work_of_adhesion: float, range: float) -> float:
    """Mean tension w/Δr over the attracted area A_att, after Eq. (1)."""
    return work_of_adhesion / range


def kappa_att(rms_slope: float, range: float, adhesion_length: float, area_ratio: float) -> float:
    """κ_att = h' (Δr/l_a) A_rep/A_att, Eq. (3), with ``area_ratio`` = A_rep/A_att; infinite for l_a = 0."""
    return np.inf if adhesion_length == 0 else rms_slope * range / adhesion_length * area_ratio


def area_ratio(rms_slope: float, diameter: float, range: float) -> float:
    """A_rep/A_att = d_rep/(π d_att) = (16/9π)^(1/3) (h' d_rep/(π Δr))^(2/3), Eq. (4).

    For a thin rim: A_att < A_rep and d_att < d_rep/2.
    """
    return float(np.cbrt(16 / (9 * np.pi)) * np.cbrt(rms_slope * diameter / (np.pi * range)) ** 2)


# --- geometry of a patch -----------------------------------------------------------------------------------


def asperity_radius(rms_curvature: float) -> float:
    """Radius of the cylinder that stands for an asperity, R = 2/h''."""
    return 2 / rms_curvature


def contact_diameter(rms_slope: float, rms_curvature: float) -> float:
    """Mean width of contact patches from the undeformed surface, d_rep = 2 R h' = 4 h'/h''.

    Measured widths lie within a factor of two of it (the paper's Fig. 3).
    """
    return 4 * rms_slope / rms_curvature


def height_change(rms_slope: float, rms_curvature: float) -> float:
    """Height between the edge and the middle of a contact, δh = h'²/h'' = h' d_rep/4."""
    return rms_slope**2 / rms_curvature


def gap_scale(rms_slope: float, rms_curvature: float) -> float:
    """Gap one patch width outside the edge of a contact, g0 = (16/3) h'²/h'': Eq. (S-1) at x = d_rep = 4h'/h''."""
    return 16 / 3 * height_change(rms_slope, rms_curvature)


def perimeter(area: float, diameter: float) -> float:
    """Perimeter of an area of mean chord d_rep whose edge points in all directions alike, P = π A_rep/d_rep."""
    return np.pi * area / diameter


def gap_outside_contact(x: Real | float, rms_slope: float, diameter: float) -> Real:
    """Gap at a distance x outside the edge of a contact, Eq. (S-1).

    ::

        2 Δ/d_rep = (sqrt(8)/3) h' (2x/d_rep)^(3/2)

    The first term outside a cylinder whose slope is h' at the edge, without adhesion; for x well below d_rep.
    """
    profile: Real = diameter / 2 * np.sqrt(8) / 3 * rms_slope * (2 * np.asarray(x) / diameter) ** 1.5
    return profile


def attraction_width(rms_slope: float, diameter: float, range: float) -> float:
    """Width of the attracted rim, where the gap of Eq. (S-1) reaches Δr, Eq. (S-2).

    ::

        d_att/d_rep = (3Δr/(4 h' d_rep))^(2/3)
    """
    return float(diameter * np.cbrt(0.75 * range / (rms_slope * diameter)) ** 2)


@dataclass(frozen=True)
class ExpectedContact:
    """Predictions of the paper for a contact, from the undeformed surface and the wall.

    Parameters
    ----------
    rms_slope, rms_curvature : h' and h'' of the surface.
    range : Δr of the wall, in κ_att the effective one of Eq. (S-5); 0 without attraction.
    adhesion_length : l_a = w/E*, in E* = 1 also the work of adhesion w.
    """

    rms_slope: float
    rms_curvature: float
    range: float = 0.0
    adhesion_length: float = 0.0

    @property
    def diameter(self) -> float:
        """d_rep = 4h'/h''."""
        return contact_diameter(self.rms_slope, self.rms_curvature)

    @property
    def width(self) -> float:
        """d_att, Eq. (S-2); 0 without attraction."""
        return attraction_width(self.rms_slope, self.diameter, self.range)

    @property
    def area_ratio(self) -> float:
        """A_rep/A_att, Eq. (4); infinite without attraction."""
        return area_ratio(self.rms_slope, self.diameter, self.range) if self.range > 0 else np.inf

    @property
    def kappa_att(self) -> float:
        """κ_att, Eqs. (3) and (4); infinite without attraction."""
        return kappa_att(self.rms_slope, self.range, self.adhesion_length, self.area_ratio) if self.range else np.inf

    @property
    def pressure_att(self) -> float:
        """w/Δr in units of E*; NaN without attraction."""
        return adhesive_pressure(self.adhesion_length, self.range) if self.range > 0 else np.nan


# --- the onset of stickiness -------------------------------------------------------------------------------


def onset(
    rms_slope: float, height_change: float, adhesion_length: float, range: float, kappa_rep: float = KAPPA_REP
) -> float:
    """Left side of Eq. (6) over its right side: sticky where it is below 1; equal to κ_att/κ_rep.

    ::

        h' Δr/(κ_rep l_a) (δh/Δr)^(2/3) < π (3/16)^(2/3) = 1.029
    """
    left = rms_slope * range / (kappa_rep * adhesion_length) * np.cbrt(height_change / range) ** 2
    return float(left / (np.pi * np.cbrt(3 / 16) ** 2))


def critical_modulus(
    rms_slope: float, height_change: float, work_of_adhesion: float, range: float, kappa_rep: float = KAPPA_REP
) -> float:
    """Contact modulus E* below which Eq. (6) holds.

    The paper's example - w = 50 mJ/m², h' = 1, Δr = 0.5 nm, d_rep = 10 nm - gives 70 MPa; its text says 10 MPa.
    """
    return 1 / onset(rms_slope, height_change, work_of_adhesion, range, kappa_rep)


def necessary_adhesion_length(rms_slope: float, spacing: float = 1.0) -> float:
    """Smallest l_a that can be sticky: 0.5 h' a0, necessary, not sufficient.

    Eq. (6) with δh = Δr = a0 and κ_rep = 2 (which gives 0.486; the text says that the bound is inserted in
    Eq. (4)), as roughness of atomic crystals has steps of at least a0.
    """
    return 0.5 * rms_slope * spacing


# --- the law of attraction ---------------------------------------------------------------------------------


def maugis_parameter(radius: float, adhesion_length: float, range: float) -> float:
    """λ_Maugis = (9 R l_a²/(2π Δr³))^(1/3), Suppl. S-I: DMT where small, JKR above 5.

    The same number as :attr:`continuum.theory.smooth.MaugisDugdale.parameter`.
    """
    return float(np.cbrt(9 * radius * adhesion_length**2 / (2 * np.pi)) / range)


def effective_range(attraction: Callable[[float], float], cutoff: float = np.inf) -> float:
    """Effective range of an attractive law, Eq. (S-5).

    ::

        Δr^(-1/3) = (2/3) ∫ Δ^(-1/3) p(Δ) dΔ / ∫ p(Δ) dΔ

    With Δ = s³ both integrands are smooth at contact.

    Parameters
    ----------
    attraction : p(Δ), attractive pressure at a distance Δ > 0 beyond the minimum of the energy, positive.
        (In the paper's Eq. (S-6) the pressure has the other sign.)
    cutoff : distance beyond which p vanishes, in the same unit; infinite if it does not.
    """
    end = np.cbrt(cutoff)
    weighted = scipy.integrate.quad(lambda s: 3 * s * attraction(s**3), 0, end, epsabs=0, epsrel=1e-11, limit=400)[0]
    work = scipy.integrate.quad(lambda s: 3 * s**2 * attraction(s**3), 0, end, epsabs=0, epsrel=1e-11, limit=400)[0]
    return range_of_integrals(weighted, work)


def range_of_integrals(weighted: float | np.floating, work: float | np.floating) -> float:
    """Effective range from ∫ Δ^(-1/3) p(Δ) dΔ and ∫ p(Δ) dΔ, Eq. (S-5)."""
    return float((2 / 3 * weighted / work) ** -3)


def snap_in_wavelength(largest_softening: float, contact_modulus: float = 1.0) -> float:
    """Wavelength above which two flats snap together: where E* q/2 falls below the law's softening.

    For the paper's law the softening is at most E*/(6 a0), whatever its range: 6π a0.  Infinite without softening.
    """
    return np.pi * contact_modulus / largest_softening if largest_softening > 0 else np.inf
