"""The camps' exponents, against their criteria on ideal self-affine spectra of ever shorter waves."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.maps.verdict.criteria import CRITERIA, Criterion, RoughContact
from continuum.theory import rough


def ideal(hurst: float, lambda_s: float, range: float = 1e-3) -> RoughContact:
    """Moments of C ~ q^(-2-2H) between 2π/λ_L and 2π/λ_s, λ_L = 1, by integration; h_rms = 1."""
    q = np.geomspace(2 * np.pi, 2 * np.pi / lambda_s, 20001)
    density = q ** (-2 - 2 * hurst) * 2 * np.pi * q * q  # over log q
    m0, m1, m2, m4 = (float(np.trapezoid(density * q**k, np.log(q))) for k in (0, 1, 2, 4))
    energy = m1 / m0 / 4
    return RoughContact(
        1.0, float(np.sqrt(m2 / m0)), float(np.sqrt(m4 / m0)), 1.0, range, conformal_energy=energy, roll_off=1.0
    )


def fitted(criterion: Criterion, hurst: float) -> float:
    """Exponent between two cut-offs four decades below λ_L."""
    thresholds = [1 / (criterion(ideal(hurst, cut)).margin or np.nan) for cut in (1e-5, 1e-4)]
    return float(np.log(thresholds[1] / thresholds[0]) / np.log(10))


@pytest.mark.parametrize("hurst", [0.3, 0.6, 0.8])
def test_the_exponents_are_those_of_the_criteria(hurst: float) -> None:
    # Sums of powers of which the smaller has died out but for some per cent, slowest where H is near 1/2 and 1.
    paper = rough.pastewka_robbins_exponent(hurst)
    assert fitted(CRITERIA["pastewka-robbins"], hurst) == pytest.approx(paper, abs=0.04)
    assert fitted(CRITERIA["fuller-tabor"], hurst) == pytest.approx(rough.fuller_tabor_exponent(hurst), abs=1e-3)
    assert fitted(CRITERIA["persson-tosatti"], hurst) == pytest.approx(rough.conformal_exponent(hurst), abs=0.06)
    assert fitted(CRITERIA["half-conformal-energy"], hurst) == fitted(CRITERIA["persson-tosatti"], hurst)
    assert fitted(CRITERIA["bearing-area"], hurst) == pytest.approx(rough.long_wave_exponent(hurst), abs=1e-9)


def test_the_paper_s_exponents_are_those_that_it_states() -> None:
    found = [rough.pastewka_robbins_exponent(hurst) for hurst in (0.8, 0.6, 0.3)]
    assert found == pytest.approx([1 / 3, 0.0, -1 / 2], abs=1e-12)
    spline = [rough.pastewka_robbins_exponent(hurst, 0.5) for hurst in (0.8, 0.3)]
    assert spline == pytest.approx([6 / 5 / 3, -6 / 5 / 2])
    assert [rough.conformal_exponent(hurst) for hurst in (0.3, 0.5, 0.8)] == pytest.approx([-0.4, 0.0, 0.0])
