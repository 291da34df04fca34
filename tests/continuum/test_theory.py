"""The oracles themselves: closed forms against their own integrals and limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from continuum.theory import Hertz, Westergaard, effective_range

positive = st.floats(0.1, 100)


@given(positive, positive, positive)
def test_hertz_pressure_carries_the_load(radius: float, load: float, modulus: float) -> None:
    hertz = Hertz(radius, load, modulus)
    a = hertz.contact_radius
    # r = a sin t makes the integrand smooth at the edge.
    carried = quad(
        lambda t: 2 * np.pi * a**2 * np.sin(t) * np.cos(t) * float(hertz.pressure(np.array(a * np.sin(t)))),
        0,
        np.pi / 2,
    )[0]
    assert carried == pytest.approx(load, rel=1e-7)
    assert hertz.indentation == pytest.approx(a**2 / radius, rel=1e-14)
    # Energy balance: N = dU/dδ with U = (8/15) E* sqrt(R) δ^(5/2).
    assert load == pytest.approx(4 / 3 * modulus * np.sqrt(radius) * hertz.indentation**1.5, rel=1e-12)


@given(st.floats(0.01, 1), positive, st.floats(0.01, 0.99), positive)
def test_westergaard_pressure_has_its_mean(
    amplitude: float, wavelength: float, fraction: float, modulus: float
) -> None:
    full = np.pi * modulus * amplitude / wavelength
    wave = Westergaard(amplitude, wavelength, fraction * full, modulus)
    assert wave.full_pressure == pytest.approx(full, rel=1e-14)
    x = (np.arange(20000) + 0.5) / 20000 * wavelength
    # Midpoint rule on a square-root edge: (1/20000)^1.5 relative to contacts of a few per cent of the period.
    assert np.mean(wave.pressure(x)) == pytest.approx(fraction * full, rel=1e-4)
    assert wave.pressure(np.array([1.01 * wave.half_width])) == 0


def test_a_flat_attraction_has_its_own_range() -> None:
    # Dugdale: constant p up to r.  (2/3) ∫ Δ^(-1/3) dΔ = r^(2/3), so Eq. (deltar) gives r itself.
    assert effective_range(lambda x: 1.0, cutoff=0.7) == pytest.approx(0.7, rel=1e-10)


@given(st.floats(0.01, 100))
def test_effective_range_scales_as_a_length(scale: float) -> None:
    found = effective_range(lambda x: float(np.exp(-x / scale)), cutoff=60 * scale)
    assert found / scale == pytest.approx(effective_range(lambda x: float(np.exp(-x)), cutoff=60.0), rel=1e-8)
