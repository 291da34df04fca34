"""Other theories of rough contact: Persson, Fuller and Tabor, bearing area, and the energy of full contact.

Independent of the solver.  Any consistent units; E* = 1 unless given.  The range of validity of each is in
:mod:`continuum.maps.verdict.criteria`.
"""

import math
from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import NDArray

Real = NDArray[np.float64]

KAPPA_BGT = float(np.sqrt(2 * np.pi))
"""κ of A = κ N/(h' E*) at vanishing load in asperity theories, 2.507 (the paper prints 2.6): Bush, Gibson and Thomas,
Wear 35, 87 (1975), and Greenwood and Williamson with the summits of a Gaussian surface."""

KAPPA_PERSSON = float(np.sqrt(8 / np.pi))
"""κ at vanishing load in Persson's theory, 1.596."""


def asperity_limit(work_of_adhesion: float, rms_height: float) -> float:
    """N P_c/A0 of N JKR asperities that all pull at once: (3π/2) w R n = 0.2356 w/h_rms, the paper's Suppl. S-III.

    With the number of summits of rough surfaces, n R h_rms = 0.05; independent of R.
    """
    return 0.05 * 1.5 * np.pi * work_of_adhesion / rms_height


def fuller_tabor(ratio: float) -> float:
    """Pull-off force of N JKR asperities of Gaussian heights over N P_c, P_c = (3/2)π w R.

    Fuller and Tabor, Proc. R. Soc. A 345, 327 (1975).  Each asperity follows the JKR curve until it separates at a
    stretch of δ_c; all have touched before (a high peak load).  The ratio is h_rms/δ_c, with δ_c of
    :attr:`continuum.theory.smooth.JKR.separation_distance`.
    """
    # JKR in Maugis' units: N = a³ - a sqrt(6a) in π w R, δ = a² - (2/3) sqrt(6a), separation at a³ = 1/6.
    ratio = min(max(ratio, 1e-6), 1e6)  # beyond, 1 and 0 to more digits than a sum has
    unit = 3 * math.cbrt(1 / 6) ** 2 * ratio  # h_rms in the unit of δ, which is -3 a² at separation

    def radius(delta: Real) -> Real:
        """Contact radius of an indentation, at least that of separation: a root of s⁴ - sqrt(8/3) s = δ, a = s²."""
        u = np.cbrt(1 / 6 + np.sqrt(np.maximum(1 / 36 + (delta / 3) ** 3, 0.0)))
        v = delta / (3 * u)
        m = 1 / (3 * (u * u + u * v + v * v))
        return np.asarray((np.sqrt(m / 2) + np.sqrt(1 / np.sqrt(3 * m) - m / 2)) ** 2)

    def load(t: Real | float, parts: int = 1000) -> Real:
        """Force, over N π w R, of a plane t h_rms above the mean of the summits."""
        t = np.asarray(t)[..., np.newaxis]
        # Summits of 9 h_rms and more above and below the mean do not count.
        bottom, top = (radius(np.maximum((side - t) * unit, -unit / ratio)) for side in (-9, 9))
        # To ten digits: the Gaussian has 50 of these parts, as its width in a is at least 1/20 of the interval.
        a = bottom + (top - bottom) * np.linspace(0, 1, parts + 1)
        root = np.sqrt(6 * a)
        z = t + (a * a - 2 / 3 * root) / unit
        # Force at each a, times dδ/da.
        weighed = a * (a * a - root) * (2 * a - 2 / root) * np.exp(-z * z / 2)
        integral = scipy.integrate.simpson(weighed, dx=1 / parts) * (top - bottom)[..., 0]
        return np.asarray(integral / (unit * math.sqrt(2 * math.pi)))

    # Where it is about, 100 parts tell as well.
    return _largest_tension(load, lambda t: load(t, parts=100), -3.0, 6.0 + 1 / ratio) / 1.5


def dmt_asperities(ratio: float) -> float:
    """Pull-off force of N DMT asperities of Gaussian heights over N 2π w R.

    As Maugis, J. Adhes. Sci. Technol. 10, 161 (1996): each pulls with 2π w R while it touches.  The attraction of
    asperities that do not touch is neglected, as it depends on the range.  The ratio is h_rms/δ_c as in
    :func:`fuller_tabor`; the Hertzian force at an indentation of δ_c is (sqrt(3)/4) 2π w R.
    """
    hertz = math.sqrt(3) / 4 * ratio**1.5

    def load(t: Real | float) -> Real:
        # ∫ u^(3/2) exp(-(t + u)²/2) du over all u > 0 is a function of the parabolic cylinder.
        pushed = math.gamma(5 / 2) / math.sqrt(2 * math.pi) * np.exp(-np.square(t) / 4) * scipy.special.pbdv(-2.5, t)[0]
        return np.asarray(hertz * pushed - scipy.special.ndtr(-np.asarray(t)))

    # Smooth asperities all touch: the plane is far below their mean.
    return _largest_tension(load, load, -9.0, 9.0)


def _largest_tension(load: Callable[[float], Real], about: Callable[[Real], Real], low: float, high: float) -> float:
    """Largest tension over all positions of the plane; ``about`` is the load at many of them, less exactly."""
    steps = np.linspace(low, high, 121)
    best = int(np.argmin(about(steps)))
    bounds = float(steps[max(best - 1, 0)]), float(steps[min(best + 1, steps.size - 1)])
    found = scipy.optimize.minimize_scalar(
        lambda t: float(load(t)), bounds=bounds, method="bounded", options={"xatol": 1e-8}
    )
    return max(-float(found.fun), 0.0)  # apart they do not pull


def conformal_energy(wavenumber: Real, power: Real, contact_modulus: float = 1.0) -> float:
    """Elastic energy per area of full contact, U = (E*/4) Σ |q| |h_q|².

    Persson and Tosatti, J. Chem. Phys. 115, 5597 (2001).  For an isotropic spectrum (π E*/2) ∫ q² C(q) dq.

    Parameters
    ----------
    wavenumber : |q| of the modes, any shape.
    power : |h_q|² of each, summed over the modes of the same |q| (over a half spectrum: with its weights).
    contact_modulus : E*.
    """
    return float(contact_modulus / 4 * np.sum(wavenumber * power))


def bearing_area_limit(ratio: float) -> float:
    """Largest h_rms²/(l_a λ_L) that is sticky in the bearing-area model, 0.6256 for h_rms far above the range.

    Ciavarella, Meccanica 53, 1107 (2018), doi 10.1007/s11012-017-0701-6, derived again from its two parts.  Repulsion
    is Persson's at large separations u, with γ = 1/2 and q0 = 2π/λ_L::

        p/E* = (3/(8γ)) q0 h_rms exp(-u/(γ h_rms))

    and attraction a constant tension w/ε over the bearing area between u - ε and u of the undeformed Gaussian surface,
    which for spheres gives DMT's 2π w R::

        p_att = (w/ε) [Φ(-(u - ε)/h_rms) - Φ(-u/h_rms)]

    Sticky where p_att exceeds p at some u.  For ε much smaller than h_rms this first happens at u = 2 h_rms: the limit
    is e²/(3π/2 sqrt(2π)).  The smallest wavelength does not enter.  The ratio is h_rms/ε, with ε the range over which
    the tension is constant, w over the tension.
    """

    def loss(x: Real | float) -> Real:
        between = scipy.special.erfc((x - 1 / ratio) / np.sqrt(2)) - scipy.special.erfc(x / np.sqrt(2))
        return np.asarray(-np.exp(2 * x) * between / 2 * ratio)

    # The maximum lies at x = 2 for a short range, and moves out with it; beyond 300 all contacts are sticky.
    return _largest_tension(loss, loss, 0.0, min(6.0 + 4 / ratio, 300.0)) / (0.75 * 2 * np.pi)


def generalised_tabor(rms_curvature: float, adhesion_length: float, range: float) -> float:
    """R^(1/3) l_a^(2/3)/Δr, below about 1 the attraction of asperities is long-ranged.

    Müser, Tribol. Int. 100, 41 (2016).  1/R is the root mean square of the curvature along one direction, as in the 60
    nm of the contact-mechanics challenge: of an isotropic surface <(∂²h/∂x²)²> = 3/8 <(∇²h)²>, the mean of cos⁴; the
    curvature that is given is h'', of the Laplacian.
    """
    radius = np.sqrt(8 / 3) / rms_curvature
    return float(np.cbrt(radius * adhesion_length**2) / range)


def threshold_share(ratio: float) -> float:
    """F, the ratio of w to the energy of full contact at which the load at 1 % area changes its sign: docs/law.md.

    ½/(1 + (Δ/D)^m) with D = 0.764 and m = 1.187, for the paper's law, as stated before the surfaces that tested it
    were made.  These became sticky at 0.9 of it on average (1024² points), and at 0.6 - 0.75 of it under an attraction
    of infinite range.  That w over this energy is the parameter was found by Ciavarella and Papangelo, "A generalized
    Johnson parameter for pull-off decay in the adhesion of rough surfaces", Phys. Mesomech. (2018).  The ratio is the
    effective range Δ of the attraction over h_rms.
    """
    return float(0.5 / (1 + (ratio / 0.764) ** 1.187))


def pastewka_robbins_exponent(hurst: float, range_exponent: float = 0.0) -> float:
    """5H/3 - 1 for a fixed range: w ~ h' Δr^(1/3) (h'²/h'')^(2/3), the paper's Eq. (6), with H between 0 and 1.

    The range exponent y of Δr ~ w^y is 0 for a fixed range, and 1/2 for the paper's spline, which gives 6/5 of that.
    """
    slope, curvature = hurst - 1, hurst - 2
    return (slope + 2 / 3 * (2 * slope - curvature)) / (1 - range_exponent / 3)


def conformal_exponent(hurst: float) -> float:
    """0 for H of 1/2 and above, 2H - 1 below: w ~ ∫ q² C(q) dq, the energy of full contact.

    Persson and Tosatti 2001, and Müser's group, who take half of it.  At H = 1/2 the integral is logarithmic.
    """
    return min(2 * hurst - 1, 0.0)


def fuller_tabor_exponent(hurst: float) -> float:
    """H/2 - 1: a given h_rms/δ_c, with δ_c ~ w^(2/3) R^(1/3) and R ~ 1/h''; the same for DMT asperities."""
    return (hurst - 2) / 2


def long_wave_exponent(hurst: float) -> float:
    """0 for any H: only h_rms and λ_L matter.

    The bearing-area model (:func:`continuum.theory.rough.bearing_area_limit`); Joe, Thouless and Barber 2018, after
    whom the pull-off force does not depend on slope and curvature; Violano and others 2019, after whom the short-wave
    cut-off does not matter.  Of the last two papers only these statements were available.
    """
    return 0.0 * hurst
