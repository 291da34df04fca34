"""What each camp predicts for the experiment that decides: λ_s is shortened, h_rms, λ_L and the wall law are held.

Each function gives the exponent x in w ~ λ_s^x, w the work of adhesion at which a surface of Hurst exponent H turns
sticky, for λ_s much shorter than λ_L.  Slopes and curvatures are those of a self-affine surface,
h' ~ λ_s^(H-1) and h'' ~ λ_s^(H-2).
"""


def pastewka_robbins_exponent(hurst: float, range_exponent: float = 0.0) -> float:
    """5H/3 - 1 for a fixed range: w ~ h' Δr^(1/3) (h'²/h'')^(2/3), the paper's Eq. (6).

    Parameters
    ----------
    hurst : H, between 0 and 1.
    range_exponent : y of Δr ~ w^y: 0 for a fixed range, 1/2 for the paper's spline, which gives 6/5 of that.
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
    """0 whatever H: only h_rms and λ_L count.

    The bearing-area model (:func:`continuum.theory.rough.bearing_area_limit`); Joe, Thouless and Barber 2018, after
    whom the pull-off force does not depend on slope and curvature; Violano and others 2019, after whom the short-wave
    cut-off does not matter.  Of the last two only these statements were at hand.
    """
    return 0.0 * hurst
