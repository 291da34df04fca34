"""The oracles themselves: closed forms against their own integrals, energies and limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.stats import norm

from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.theory import paper, rough, smooth
from continuum.theory.smooth import DMT, JKR, Hertz, MaugisDugdale
from docs.studies.persson import persson_area
from tests.classical import AdhesiveWave, Westergaard

positive = st.floats(0.1, 100)


def derivative(function, x: float) -> float:
    """Central difference; good to 1e-8 for functions of order one."""
    h = 1e-5 * x
    return (function(x + h) - function(x - h)) / (2 * h)


def carried(pressure, radius: float) -> float:
    """Load of an axisymmetric pressure; r = a sin t makes the integrand smooth at the edge."""
    return quad(
        lambda t: 2 * np.pi * radius**2 * np.sin(t) * np.cos(t) * float(pressure(np.array(radius * np.sin(t)))),
        0,
        np.pi / 2,
    )[0]


# --- spheres -----------------------------------------------------------------------------------------------


@given(positive, positive, positive)
def test_hertz_pressure_carries_the_load(radius: float, load: float, modulus: float) -> None:
    hertz = Hertz(radius, load, modulus)
    a = hertz.contact_radius
    assert carried(hertz.pressure, a) == pytest.approx(load, rel=1e-7)
    assert hertz.indentation == pytest.approx(a**2 / radius, rel=1e-14)
    # Energy balance: N = dU/dδ with U = (8/15) E* sqrt(R) δ^(5/2).
    assert load == pytest.approx(4 / 3 * modulus * np.sqrt(radius) * hertz.indentation**1.5, rel=1e-12)


@given(positive, positive, positive, st.floats(0.65, 3))
def test_jkr_is_where_its_energy_is_stationary(radius: float, work: float, modulus: float, factor: float) -> None:
    jkr = JKR(radius, work, modulus)
    a = factor * jkr.zero_load_radius
    depth = jkr.indentation(a)

    # Elastic energy of a parabola pressed by δ on a disc of radius a, and of its load.
    def elastic(a: float, depth: float) -> float:
        return modulus * (depth**2 * a - 2 * depth * a**3 / (3 * radius) + a**5 / (5 * radius**2))

    scale = modulus * a**5 / radius**2
    assert derivative(lambda x: elastic(x, depth) - np.pi * work * x**2, a) * a == pytest.approx(0, abs=1e-8 * scale)
    # In steps of the length a²/R, since δ itself may vanish.
    step = 1e-5 * a**2 / radius
    load = (elastic(a, depth + step) - elastic(a, depth - step)) / (2 * step)
    assert jkr.load(a) == pytest.approx(load, abs=1e-8 * modulus * a**3 / radius)
    assert jkr.contact_radius(jkr.load(a)) == pytest.approx(a, rel=1e-7)
    assert carried(lambda r: jkr.pressure(r, a), a) == pytest.approx(jkr.load(a), abs=1e-6 * modulus * a**3 / radius)


@given(positive, positive, positive)
def test_jkr_pulls_off_at_the_extremes_of_its_curve(radius: float, work: float, modulus: float) -> None:
    jkr = JKR(radius, work, modulus)
    a0 = jkr.zero_load_radius
    assert jkr.load(a0) == pytest.approx(0, abs=1e-12 * jkr.pull_off_force)
    a = np.linspace(0.2, 1.2, 100001) * a0
    loads = np.array([jkr.load(x) for x in a[::100]])
    # The grid is 1e-3 a0: the minima are met to the square of that.
    assert -loads.min() == pytest.approx(jkr.pull_off_force, rel=1e-5)
    # a at pull-off is (1/4)^(1/3) of that without load.
    assert jkr.contact_radius(-jkr.pull_off_force) == pytest.approx(a0 / np.cbrt(4), rel=1e-7)
    depths = np.array([jkr.indentation(x) for x in a[::100]])
    last = int(np.argmin(depths))
    assert -depths[last] == pytest.approx(jkr.separation_distance, rel=1e-5)
    # The load is not stationary there: 1e-3 of the radius is 5e-3 of the load.
    assert -loads[last] == pytest.approx(jkr.separation_force, rel=5e-3)


@given(positive, positive, positive, st.floats(0, 10))
def test_adhesive_spheres_lie_between_dmt_and_jkr(radius: float, work: float, modulus: float, push: float) -> None:
    jkr, dmt = JKR(radius, work, modulus), DMT(radius, work, modulus)
    load = push * jkr.pull_off_force
    mu = [20.0, 3.0, 1.0, 0.3, 0.005]
    spheres = [MaugisDugdale(radius, work, smooth.tabor_parameter(radius, work, m, modulus), modulus) for m in mu]
    tensions = [jkr.pull_off_force, *(sphere.pull_off_force for sphere in spheres), dmt.pull_off_force]
    radii = [jkr.contact_radius(load), *(sphere.contact_radius(load) for sphere in spheres), dmt.contact_radius(load)]
    assert (np.diff(tensions) > 0).all()
    assert (np.diff(radii) < 0).all()
    # Corrections of the order of 1/λ² and, of the radius without load, 0.8 λ.
    assert tensions[1] == pytest.approx(tensions[0], rel=1e-3)
    assert tensions[-2] == pytest.approx(tensions[-1], rel=5e-3)
    assert radii[1] == pytest.approx(radii[0], rel=1e-2)
    assert radii[-2] == pytest.approx(radii[-1], rel=1e-2)


@pytest.mark.parametrize("parameter", [0.05, 0.2, 0.5, 1.0, 2.0, 5.0])
def test_maugis_pull_off_is_the_known_function_of_his_parameter(parameter: float) -> None:
    sphere = MaugisDugdale(1.0, 1.0, 1.0, np.sqrt(9 / (2 * np.pi * parameter**3)))
    assert sphere.parameter == pytest.approx(parameter, rel=1e-12)
    assert sphere.parameter == pytest.approx(paper.maugis_parameter(1.0, 1 / sphere.contact_modulus, 1.0), rel=1e-12)
    # The fit of Carpick, Ogletree and Salmeron, J. Colloid Interface Sci. 211, 395 (1999), good to some 2 %.
    x = 4.04 * parameter**1.4
    assert sphere.pull_off_force / np.pi == pytest.approx(7 / 4 - (x - 1) / (4 * (x + 1)), rel=0.02)


def test_a_maugis_contact_is_consistent() -> None:
    sphere = MaugisDugdale(100.0, 0.02, 0.5)
    for a in (1.0, 5.0, 20.0):
        state = sphere.state(a)
        assert state.rim_radius > a
        # Hertz with a depth of its own, less the pull of the rim, which is at most the tension over the disc c.
        hertz = 4 * a**3 / (3 * 100.0)
        assert hertz - np.pi * state.rim_radius**2 * 0.02 / 0.5 < state.load < hertz
    # The load is the derivative of the energy, so that dN/dδ along the curve joins the curve of JKR for a short range.
    short, jkr = MaugisDugdale(100.0, 0.02, 0.01), JKR(100.0, 0.02)
    for a in (5.0, 20.0):
        assert short.state(a).load == pytest.approx(jkr.load(a), abs=0.02 * jkr.pull_off_force)
        assert short.state(a).indentation == pytest.approx(jkr.indentation(a), abs=0.02 * jkr.separation_distance)


def test_tabor_and_maugis_differ_by_a_number() -> None:
    sphere = MaugisDugdale(50.0, 0.01, 0.3, 2.0)
    assert sphere.parameter / smooth.tabor_parameter(50.0, 0.01, 0.3, 2.0) == pytest.approx(1.127, abs=5e-4)


# --- waves -------------------------------------------------------------------------------------------------


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


@given(st.floats(0.1, 10), positive, positive, st.floats(0.05, 1.0), st.floats(0.02, 0.45))
def test_the_adhesive_wave_carries_its_load(
    amplitude: float, wavelength: float, modulus: float, alpha: float, fraction: float
) -> None:
    work = (alpha * np.pi * amplitude) ** 2 * modulus / (2 * wavelength)
    wave = AdhesiveWave(amplitude, wavelength, work, modulus)
    assert wave.alpha == pytest.approx(alpha, rel=1e-12)
    a = fraction * wavelength
    # sin ψ_x = sin ψ sin t takes the square roots away.
    edge = np.sin(np.pi * fraction)

    def integrand(t: float) -> float:
        psi = np.arcsin(edge * np.sin(t))
        x = psi * wavelength / np.pi
        return float(wave.pressure(x, a)) * edge * np.cos(t) / np.cos(psi) * 2 / np.pi

    load = quad(integrand, 0, np.pi / 2 * (1 - 1e-9), limit=200)[0]
    assert wave.mean_pressure(a) == pytest.approx(load, abs=1e-6 * wave.full_pressure)
    # The edge releases w: stress intensity from the pressure just inside, K²/(2E*) = w.
    near = a * (1 - 1e-8)
    intensity = -float(wave.pressure(near, a)) * np.sqrt(2 * np.pi * (a - near))
    assert intensity**2 / (2 * modulus) == pytest.approx(work, rel=1e-3)


def test_limits_of_the_adhesive_wave() -> None:
    bare = AdhesiveWave(1.0, 100.0, 1e-30)
    for fraction in (0.2, 0.7):
        half = Westergaard(1.0, 100.0, fraction * bare.full_pressure).half_width
        assert bare.mean_pressure(half) == pytest.approx(fraction * bare.full_pressure, rel=1e-9)
    # A narrow contact is that of a cylinder, of 1/R = Δ (2π/λ)²: N/L = π E* a²/(4R) - sqrt(2π w E* a).
    wave = AdhesiveWave(1.0, 100.0, 1e-4)
    a = 1e-3 * 100
    cylinder = np.pi * a**2 / 4 * (2 * np.pi / 100) ** 2 - np.sqrt(2 * np.pi * 1e-4 * a)
    assert wave.mean_pressure(a) * 100 == pytest.approx(cylinder, rel=1e-4)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.569, 0.571, 1.0])
def test_an_adhesive_wave_pulls_off_and_snaps_in_where_its_load_is_stationary(alpha: float) -> None:
    wave = AdhesiveWave(1.0, 10.0, (alpha * np.pi) ** 2 / 20)
    a = np.linspace(1e-4, 4.9999, 20001)
    loads = np.array([wave.mean_pressure(x) for x in a])
    places = np.flatnonzero(np.diff(np.sign(np.diff(loads)))) + 1
    np.testing.assert_allclose([wave.pull_off_width, wave.snap_in_width], a[places], atol=2.5e-4)  # a step
    assert wave.pull_off_pressure == pytest.approx(-loads[places[0]], rel=1e-6)
    # Johnson: the wave jumps to full contact under no load above α = 0.57.
    assert (wave.mean_pressure(wave.snap_in_width) < 0) == (alpha > 0.57)


def test_a_wave_of_strong_adhesion_has_no_partial_contact() -> None:
    with pytest.raises(ValueError, match=r"above 1\.065"):
        _ = AdhesiveWave(1.0, 10.0, (1.066 * np.pi) ** 2 / 20).pull_off_width
    assert AdhesiveWave(1.0, 10.0, (1.064 * np.pi) ** 2 / 20).pull_off_width < 5


# --- rough surfaces ----------------------------------------------------------------------------------------


def test_kappas_of_theories() -> None:
    assert pytest.approx(2.507, abs=5e-4) == rough.KAPPA_BGT
    assert pytest.approx(1.596, abs=5e-4) == rough.KAPPA_PERSSON
    assert paper.KAPPA_REP == 2
    small = 1e-4
    assert persson_area(0.1 * small, 0.1) == pytest.approx(rough.KAPPA_PERSSON * small, rel=1e-6)
    assert persson_area(1.0, 0.1) == pytest.approx(1, rel=1e-12)


@dataclass(frozen=True)
class GreenwoodWilliamson:
    """Independent spherical asperities of one radius with Gaussian heights (Proc. R. Soc. A 295, 300 (1966)).

    Without elastic interaction: for contacts far from one another.

    Parameters
    ----------
    density : number of summits per area.
    radius : R of each summit.
    rms_height : rms height of the summits.
    contact_modulus : E*.
    """

    density: float
    radius: float
    rms_height: float
    contact_modulus: float = 1.0

    def _moment(self, power: float, separation: float) -> float:
        """Mean of (z - d)^power over the summits above d."""
        start = separation / self.rms_height
        # u = t² takes the half-integer powers away; the exponent of the start is put back afterwards.
        value = quad(lambda t: t ** (2 * power + 1) * np.exp(-(t**4) / 2 - start * t * t), 0, np.inf, epsabs=0)[0]
        return float(self.rms_height**power * 2 * value * np.exp(-(start**2) / 2) / np.sqrt(2 * np.pi))

    def area(self, separation: float) -> float:
        """A/A0 = n π R <z - d>, d above the mean height of the summits."""
        return np.pi * self.density * self.radius * self._moment(1.0, separation)

    def pressure(self, separation: float) -> float:
        """N/A0 = (4/3) E* n sqrt(R) <(z - d)^(3/2)>."""
        return float(4 / 3 * self.contact_modulus * self.density * np.sqrt(self.radius) * self._moment(1.5, separation))


def test_greenwood_williamson_with_the_summits_of_a_gaussian_surface_has_bgts_kappa() -> None:
    # Nayak: at a height of ξ h_rms the summits of a Gaussian surface of slope moment m2 = h'²/2 have the density
    # (2π)^(-3/2) (m2/h_rms²) ξ exp(-ξ²/2) per unit of ξ, times ξ, and the radius h_rms/(ξ m2).
    sigma, slope = 2.0, 0.1
    m2, errors = slope**2 / 2, []
    for xi in (18.0, 24.0, 36.0):
        surface = GreenwoodWilliamson(xi**2 * m2 / sigma**2 / (2 * np.pi), sigma / (xi * m2), sigma)
        kappa = slope * surface.area(xi * sigma) / surface.pressure(xi * sigma)
        errors.append(abs(kappa / rough.KAPPA_BGT - 1))
        # And half of the area that lies above ξ: asperities are cut at half their section.
        assert surface.area(xi * sigma) == pytest.approx(norm.sf(xi) / 2, rel=3 / xi**2)
    # The tail of a Gaussian is an exponential up to 1/ξ², 1/324 and less here.
    np.testing.assert_allclose(errors, 0, atol=2 / 324)
    assert errors[0] / errors[2] == pytest.approx(4, rel=0.1)


def test_greenwood_williamson_against_its_integral() -> None:
    surface = GreenwoodWilliamson(0.2, 5.0, 0.7, 3.0)
    for d in (-1.0, 0.0, 2.0):
        area = quad(lambda z, d=d: (z - d) * norm.pdf(z, scale=0.7), d, d + 15)[0]
        load = quad(lambda z, d=d: (z - d) ** 1.5 * norm.pdf(z, scale=0.7), d, d + 15)[0]
        assert surface.area(d) == pytest.approx(np.pi * 0.2 * 5 * area, rel=1e-6)
        assert surface.pressure(d) == pytest.approx(4 / 3 * 3 * 0.2 * np.sqrt(5) * load, rel=1e-6)


@pytest.mark.parametrize("ratio", [0.05, 1.0, *(pytest.param(r, marks=pytest.mark.long) for r in (0.5, 2.0, 3.0))])
def test_asperity_theories_against_sums_over_asperities(ratio: float) -> None:
    jkr = JKR(2.0, 0.3, 5.0)
    sigma = ratio * jkr.separation_distance
    heights = norm.ppf((np.arange(50000) + 0.5) / 50000) * sigma
    # The stable part of the JKR curve, from its separation on.
    a = np.linspace(0.3, 3, 10001) * jkr.zero_load_radius
    depth = a**2 / 2 - np.sqrt(2 * np.pi * 0.3 * a / 5)
    a, depth = a[np.argmin(depth) :], depth[np.argmin(depth) :]
    loads = 20 * a**3 / 6 - np.sqrt(8 * np.pi * 0.3 * 5 * a**3)

    def short(d: float) -> float:
        return float(np.mean(np.interp(heights - d, depth, loads, left=0.0))) / jkr.pull_off_force

    def long(d: float) -> float:
        touch = np.maximum(heights - d, 0)
        return float(np.mean(np.where(touch > 0, 20 / 3 * np.sqrt(2.0) * touch**1.5 / (2 * np.pi * 0.6) - 1, 0)))

    for summed, found in ((short, rough.fuller_tabor(ratio)), (long, rough.dmt_asperities(ratio))):
        step, d = max(sigma, jkr.separation_distance) / 6, 0.0
        for width in (step, step / 20):  # the second time around the largest of the first
            d = max(d + width * np.arange(-20, 21), key=lambda at: -summed(float(at)))
        tension = -summed(float(d))
        # Heights and positions of a finite number: 0.2 %, and one asperity in 50 000 in the tail.
        assert found == pytest.approx(tension, rel=2e-3, abs=1e-5)


def test_pull_off_of_asperities_falls_from_one_to_nothing() -> None:
    ratios = [0.01, 0.1, 0.5, 1, 2, 3, 5]
    for pull_off in (rough.fuller_tabor, rough.dmt_asperities):
        found = [pull_off(ratio) for ratio in ratios]
        assert found[0] == pytest.approx(1, rel=5e-3)
        assert (np.diff(found) < 0).all()
        # "Drops rapidly above 1 and is extremely small above 3."
        assert found[5] < 0.05


@pytest.mark.parametrize("ratio", [1e-9, 1e-6, 1e-4, 1e-3])
def test_smooth_asperities_pull_together(ratio: float) -> None:
    """Fuller and Tabor's was 32 times too large at 1e-6, as the heights were narrower than the step of the sum."""
    assert rough.fuller_tabor(ratio) == pytest.approx(1, abs=ratio + 1e-8)  # xatol of the position
    # In DMT's limit the first to be pressed cost a force that falls as the root of the cube.
    assert rough.dmt_asperities(ratio) == pytest.approx(1, abs=10 * ratio**1.5 + 1e-8)


@pytest.mark.parametrize("ratio", [1e2, 1e5, 1e8])
def test_the_roughest_asperities_do_not_pull_and_do_not_push(ratio: float) -> None:
    """Fuller and Tabor's was -47 at 1e8: the load of the summits that are still touched at the last position."""
    assert rough.fuller_tabor(ratio) == rough.dmt_asperities(ratio) == 0.0


def test_energy_of_full_contact() -> None:
    # One wave of amplitude Δ: the traction E* q/2 Δ cos does the work E* q Δ²/8 per area.
    q, amplitude = 0.3, 0.7
    assert rough.conformal_energy(np.array([q]), np.array([amplitude**2 / 2]), 2.0) == pytest.approx(
        2.0 * q * amplitude**2 / 8
    )
    # Johnson's wave gains energy in full contact, w = U, where α² = 2λw/(π²Δ²E*) is 1/(2π).
    wave = AdhesiveWave(amplitude, 2 * np.pi / q, q * amplitude**2 / 8)
    assert wave.alpha**2 == pytest.approx(1 / (2 * np.pi), rel=1e-12)


def test_the_pull_off_search_finds_the_minimum_of_the_load() -> None:
    sphere = MaugisDugdale(3.0, 0.2, 0.4)
    found = minimize_scalar(lambda a: sphere.state(a).load, bounds=(0.01, 3), method="bounded")
    assert sphere.pull_off_force == pytest.approx(-found.fun, rel=1e-9)


def test_the_bearing_area_model_has_the_limit_of_its_energy_balance() -> None:
    # Short ranges: the tension is w times the density of heights, and the two curves touch at u = 2 h_rms.
    assert rough.bearing_area_limit(1e5) == pytest.approx(np.exp(2) / (1.5 * np.pi * np.sqrt(2 * np.pi)), rel=1e-4)
    # Longer ranges help: worked out by hand from the same two pressures.
    assert [rough.bearing_area_limit(ratio) for ratio in (10, 5, 2, 1)] == pytest.approx(
        [0.69, 0.77, 1.06, 1.93], abs=6e-3
    )


def test_the_gap_beside_a_patch_is_that_of_the_paper_s_profile() -> None:
    slope, curvature = 0.13, 0.7
    diameter = paper.contact_diameter(slope, curvature)
    assert paper.gap_scale(slope, curvature) == pytest.approx(
        float(paper.gap_outside_contact(diameter, slope, diameter))
    )


def test_the_generalised_tabor_number_is_tabor_s_of_a_summit() -> None:
    # Of a summit whose curvature along every direction is 1/R.
    grid = Grid.square(128)
    power = SelfAffine(0.8, 0.1, 8, 64).power_q(grid)
    along_x = np.sqrt(np.sum(grid.wavevectors[0] ** 4 * power * grid.mode_weights))
    laplacian = np.sqrt(np.sum(grid.wavenumber**4 * power * grid.mode_weights))
    tabor = smooth.tabor_parameter(1 / along_x, 0.003, 0.2)
    # Square grids are as isotropic as their waves: 0.4 % of the fourth power of cos.
    assert rough.generalised_tabor(laplacian, 0.003, 0.2) == pytest.approx(tabor, rel=2e-3)
    # The published radius of the contact-mechanics challenge, 60 nm, whose 1/h'' is 36.8 nm (Müser and others, 2017).
    assert np.sqrt(8 / 3) * 36.8 == pytest.approx(60, rel=2e-3)


@pytest.mark.parametrize("ratio", [0.5, 2.0, 10.0])
def test_at_its_own_onset_eq_6_has_a_tabor_number_that_its_thin_rim_fixes(ratio: float) -> None:
    """Δr = δh/ratio: a rim that is thin makes contacts that adhesion deforms, whatever slope and curvature."""
    for slope, curvature in ((0.1, 0.05), (0.03, 0.4)):
        height = paper.height_change(slope, curvature)
        range_ = height / ratio
        work = 0.01 * paper.onset(slope, height, 0.01, range_)
        assert paper.onset(slope, height, work, range_) == pytest.approx(1)
        constant = np.cbrt(np.sqrt(8 / 3) / (2 * np.pi * np.cbrt(3 / 16) ** 2) ** 2)
        assert rough.generalised_tabor(curvature, work, range_) == pytest.approx(constant * ratio ** (7 / 9))
        assert constant == pytest.approx(0.728, abs=1e-3)
