"""Self-affine surfaces: moments, spectrum, the same surface on a finer grid."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad

from continuum.inputs.arguments import ArgumentError
from continuum.inputs.keys import LARGEST
from continuum.model.grid import Grid
from continuum.model.surface import LARGEST_SLOPE, SMALLEST_SLOPE, SelfAffine, moments, power_spectrum
from continuum.model.surfaces import CylinderSurface, PunchSurface, SelfAffineSurface, sine, sphere
from tests.wrong import ANYTHING, refused_by_name

PAPER = SelfAffine(hurst=0.8, rms_slope=0.1, lambda_s=16.0, lambda_L=128.0)


def unscaled(surface: SelfAffine = PAPER) -> SelfAffine:
    return SelfAffine(surface.hurst, surface.rms_slope, surface.lambda_s, surface.lambda_L, rescale=False)


def test_moments_of_a_wave_are_analytic() -> None:
    grid = Grid((24, 15), (12.0, 10.0))
    found = moments(grid, 5.0 + sine(grid, 0.3, (2, 1)))
    q2 = (2 * np.pi) ** 2 * ((2 / 12) ** 2 + (1 / 10) ** 2)
    # <cos²> = 1/2; the laplacian is -q² h.  The curvature is the paper's, not its half.
    assert found == pytest.approx(np.array([1, np.sqrt(q2), q2]) * 0.3 / np.sqrt(2), rel=1e-12)


@given(st.sampled_from([(64, 64), (63, 81), (81, 50)]), st.floats(0.1, 0.95), st.integers(0, 1000))
def test_a_realisation_has_the_slope_that_was_asked_for(shape: tuple[int, int], hurst: float, seed: int) -> None:
    grid = Grid(shape, (64.0, 64.0))
    surface = SelfAffine(hurst, 0.07, 4.0, 32.0)
    heights = surface.synthesise(grid, np.random.default_rng(seed))
    assert moments(grid, heights).rms_slope == pytest.approx(0.07, rel=1e-12)
    assert grid.mean(heights) == pytest.approx(0, abs=1e-14)


def test_the_ensemble_has_the_analytic_moments_and_scatter() -> None:
    grid = Grid.square(64)
    surface = SelfAffine(0.8, 0.1, 8.0, 32.0, rescale=False)
    count = 400
    found = np.array([moments(grid, surface.synthesise(grid, np.random.default_rng(i))) for i in range(count)])
    expected = np.array(surface.expected_moments(grid))
    assert expected[1] == pytest.approx(0.1, rel=1e-12)
    # Relative error of a mean square over `count` draws: twice the scatter of the rms over sqrt(count).
    scatter = surface.slope_scatter(grid)
    mean_square = np.mean(found**2, axis=0) / expected**2
    assert mean_square[1] == pytest.approx(1, abs=4 * 2 * scatter / np.sqrt(count))
    assert mean_square[0] == pytest.approx(1, abs=0.15)  # few long modes dominate: scatter 60 %/sqrt(400) x 4
    assert found[:, 1].std() / 0.1 == pytest.approx(scatter, rel=4 / np.sqrt(2 * count))


@pytest.mark.parametrize(("n", "lambda_s", "percent", "digit"), [(4096, 32, 2, 0.5), (256, 16, 6, 0.5), (32, 8, 15, 1)])
def test_slope_scatter_of_known_systems(n: int, lambda_s: float, percent: float, digit: float) -> None:
    # The modes are those of any grid that carries them.
    points = min(n, 512)
    found = SelfAffine(0.8, 0.1, lambda_s, n / 2).slope_scatter(Grid((points, points), (float(n), float(n))))
    assert 100 * found == pytest.approx(percent, abs=digit)  # printed to a whole percent


def test_spectrum_is_self_affine_between_the_cutoffs() -> None:
    grid = Grid.square(256)
    power = np.mean(
        [np.abs(grid.forward(unscaled().synthesise(grid, np.random.default_rng(i)))) ** 2 for i in range(60)],
        axis=0,
    )
    q, expected = grid.wavenumber, PAPER.power_q(grid)
    assert (power[q > 2 * np.pi / 16 * 1.0001] < 1e-30).all()
    assert power[0, 0] < 1e-30
    inside = expected > 0
    # A Gaussian squared has variance 2: 60 surfaces give each mode to 18 %, their mean over 600 modes to 1 %.
    assert np.mean(power[inside] / expected[inside]) == pytest.approx(1, abs=0.03)
    rolled = inside & (q < 2 * np.pi / 128)
    assert np.ptp(expected[rolled]) == 0
    band = inside & (q > 2 * np.pi / 64)
    exponent = np.polyfit(np.log(q[band]), np.log(expected[band]), 1)[0]
    assert exponent == pytest.approx(-2 - 2 * 0.8, rel=1e-12)


@pytest.mark.parametrize("rescale", [True, False])
@pytest.mark.parametrize("shape", [(64, 64), (128, 64), (33, 47), (96, 80)])
def test_one_seed_is_one_surface_on_every_grid(shape: tuple[int, int], rescale: bool) -> None:
    lengths = (64.0, 64.0)
    surface = SelfAffine(0.8, 0.1, 8.0, 32.0, rescale)
    coarse, fine = Grid((32, 32), lengths), Grid(shape, lengths)
    a, b = (grid.forward(surface.synthesise(grid, np.random.default_rng(3))) for grid in (coarse, fine))
    m = np.arange(-8, 9)  # every mode up to 2π/λ_s
    np.testing.assert_allclose(a[m, :9], b[m, :9], atol=1e-15)


def test_a_smaller_cutoff_adds_modes_and_keeps_the_others() -> None:
    grid = Grid.square(64)
    a, b = (
        grid.forward(SelfAffine(0.8, 1, cut, 32, rescale=False).synthesise(grid, np.random.default_rng(3)))
        for cut in (16.0, 4.0)
    )
    # Without the mean, which is zero up to rounding.
    common = (grid.wavenumber > 0) & (np.abs(a) > 0) & (grid.wavenumber < 2 * np.pi / 16)
    ratio = b[common] / a[common]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)  # one normalisation, the same draws


def test_power_spectrum_integrates_to_the_mean_square() -> None:
    grid = Grid((96, 80), (96.0, 80.0))
    heights = PAPER.synthesise(grid, np.random.default_rng(5))
    q, c = power_spectrum(grid, heights)
    assert (np.diff(q) > 0).all()
    # Rings are averages over modes: the integral is their sum, weighted by how many modes each holds.
    modes = np.bincount(
        np.rint(grid.wavenumber / (2 * np.pi / 96)).astype(int).ravel(),
        weights=np.broadcast_to(grid.mode_weights, grid.shape_q).ravel(),
    )[1:]
    cell = (2 * np.pi) ** 2 / grid.area
    assert np.sum(c * modes[: c.size]) * cell == pytest.approx(moments(grid, heights).rms_height ** 2, rel=1e-10)


def test_a_surface_finer_than_the_grid_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"lambda_s = 1.9: allowed: .*below two grid spacings"):
        SelfAffine(0.8, 0.1, 1.9, 16).synthesise(Grid.square(32), np.random.default_rng(0))


def test_a_surface_without_modes_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"lambda_s = 40.0: allowed: .*no wavevector"):
        SelfAffine(0.8, 0.1, 40, 80).synthesise(Grid.square(32), np.random.default_rng(0))


def test_sphere_is_a_paraboloid_lowest_at_the_centre() -> None:
    grid = Grid.square(16)
    heights = sphere(grid, 10.0)
    assert heights[8, 8] == 0
    assert heights[8, 12] == pytest.approx(16 / 20)


def test_a_cylinder_is_a_parabola_across_and_straight_along_its_axis() -> None:
    grid = Grid((32, 16), (32.0, 16.0))
    for axis in (0, 1):
        heights = CylinderSurface(20.0, "xy"[axis]).build(grid)
        assert heights.shape == grid.shape
        assert np.ptp(heights, axis=axis).max() == 0
        across = np.take(heights, 0, axis=axis)
        assert across[across.size // 2] == 0
        assert np.diff(across, 2) == pytest.approx(1 / 20)


def test_a_punch_is_flat_and_rises_at_its_edge() -> None:
    grid = Grid.square(32)
    heights = PunchSurface(8.0, 10.0).build(grid)
    r = np.hypot(*(position - 16 for position in grid.positions))
    assert (heights[r <= 8] == 0).all()
    assert heights[16 + 12, 16] == pytest.approx(4**2 / 20)


@given(st.tuples(st.integers(2, 17), st.integers(2, 17)), st.tuples(st.integers(-9, 9), st.integers(-9, 9)))
@example((16, 16), (99, 0))
@example((7, 8), (2, 3))
def test_a_wave_is_the_one_asked_for_or_is_refused(shape: tuple[int, int], waves: tuple[int, int]) -> None:
    """On 16 points 99 waves look like 3, and they were taken for these."""
    grid = Grid(shape, (3.0, 5.0))
    if not any(waves) or any(abs(m) > n // 2 for m, n in zip(waves, shape, strict=True)):
        with pytest.raises(ArgumentError, match=r"^waves = "):
            sine(grid, 0.1, waves)
        return
    spectrum = np.fft.fft2(sine(grid, 0.1, waves)) / grid.size
    wave = np.zeros(shape)
    # A half of -cos at each of q and -q, which are the same where both are at the end of the spectrum.
    for sign in (1, -1):
        wave[sign * waves[0] % shape[0], sign * waves[1] % shape[1]] -= 0.05
    wave[0, 0] = 0.1
    np.testing.assert_allclose(spectrum, wave, atol=1e-15)


@given(st.floats(-20, 20).filter(lambda x: x != round(x)))
def test_a_part_of_a_wave_has_a_step_at_the_edge_and_is_refused(wave: float) -> None:
    with pytest.raises(ArgumentError, match=r"^waves\[0\] = .*whole number"):
        sine(Grid.square(64), 0.1, (wave, 0))


SMALL = Grid.square(4)
WAVES = SelfAffine(0.8, 0.1, 2.0, 4.0)
FLAT = np.zeros(SMALL.shape)
CALLS: dict[str, tuple[Any, dict[str, Any]]] = {
    "power_q": (WAVES.power_q, {"grid": SMALL}),
    "expected_moments": (WAVES.expected_moments, {"grid": SMALL}),
    "slope_scatter": (WAVES.slope_scatter, {"grid": SMALL}),
    "power_spectrum": (power_spectrum, {"grid": SMALL, "heights": FLAT}),
    "cylinder": (CylinderSurface, {"radius": 5.0, "along": "y"}),
    "punch": (PunchSurface, {"flat_radius": 1.0, "edge_radius": 5.0}),
    "forward": (SMALL.forward, {"values": FLAT}),
    "inverse": (SMALL.inverse, {"values_q": SMALL.forward(FLAT)}),
    "integrate": (SMALL.integrate, {"values": FLAT}),
    "mean": (SMALL.mean, {"values": FLAT}),
    "inner_q": (SMALL.inner_q, {"a_q": SMALL.forward(FLAT), "b_q": SMALL.forward(FLAT)}),
}


@pytest.mark.parametrize("call", CALLS)
@given(data=st.data())
def test_what_is_no_argument_is_refused_by_its_name(call: str, data: st.DataObject) -> None:
    function, good = CALLS[call]
    assert not refused_by_name(function, good, *next(iter(good.items())))
    refused_by_name(function, good, data.draw(st.sampled_from(sorted(good))), data.draw(ANYTHING))


def test_no_size_of_a_surface_is_computed_with_that_is_no_number() -> None:
    rough = np.random.default_rng(1).normal(size=SMALL.shape)
    for made, name in (
        (lambda: moments(SMALL, 1e200 * rough), "heights"),
        (lambda: sphere(SMALL, 1e-320), "radius"),
        (lambda: CylinderSurface(0.0).build(SMALL), "radius"),
        (lambda: PunchSurface(1.0, 0.0).build(SMALL), "edge_radius"),
        (lambda: PunchSurface(9.0, 1.0).build(SMALL), "flat_radius"),  # flat all over the period
        (lambda: SelfAffine(0.8, 1e6, 2.0, 4.0), "rms_slope"),
        (lambda: Grid((4, 4), (1e-300, 1.0)), "lengths"),
    ):
        with pytest.raises(ArgumentError, match=f"^{name} = "):
            made()
    # A roll-off beyond all periods is none.
    long = SelfAffine(0.8, 0.1, 2.0, LARGEST)
    np.testing.assert_array_equal(long.power_q(SMALL), SelfAffine(0.8, 0.1, 2.0, 1e3).power_q(SMALL))


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_the_slope_that_belongs_to_a_height_is_that_of_all_waves_between_the_two(hurst: float) -> None:
    surface = SelfAffineSurface(kind="self-affine", hurst=hurst, rms_height=0.5, lambda_s=8.0, lambda_L=64.0, seed=1)
    low, high = 2 * np.pi / 64, 2 * np.pi / 8
    # C ~ q^(-2-2H): mean squares of heights and slopes are integrals of q C and q³ C.
    heights, slopes = (quad(lambda q, p=p: q ** (p - 2 - 2 * hurst), low, high)[0] for p in (1, 3))
    assert surface.expected_slope == pytest.approx(0.5 * np.sqrt(slopes / heights), rel=1e-9)


def test_a_surface_of_a_given_height_has_it_on_average_over_its_ensemble() -> None:
    grid = Grid((48, 32), (96.0, 64.0))
    surface = SelfAffineSurface(kind="self-affine", hurst=0.8, rms_height=0.5, lambda_s=8.0, lambda_L=64.0, seed=1)
    assert surface.expected(grid).rms_height == pytest.approx(0.5, rel=1e-12)
    assert surface.build(grid).std() == pytest.approx(0.5, rel=1e-12)
    loose = surface.model_copy(update={"rescale": False}).build(grid)
    assert loose.std() != pytest.approx(0.5, rel=1e-3)
    np.testing.assert_allclose(loose / loose.std(), surface.build(grid) / 0.5, atol=1e-12)


def test_the_heights_that_are_allowed_are_those_of_the_slopes_that_are() -> None:
    grid, keys = Grid((48, 32), (96.0, 64.0)), {"kind": "self-affine", "hurst": 0.8, "lambda_s": 8.0, "lambda_L": 64.0}
    with pytest.raises(ArgumentError, match=r"^rms_height = ") as error:
        SelfAffineSurface(**keys, rms_height=1e5, seed=1).build(grid)
    least, most = map(float, re.findall(r"from (\S+) to (\S+) a0", str(error.value))[0])
    for height, slope in ((least, SMALLEST_SLOPE), (most, LARGEST_SLOPE)):
        surface = SelfAffineSurface(**keys, rms_height=height * (1.01 if height == least else 0.99), seed=1)
        assert surface.expected(grid).rms_slope == pytest.approx(slope, rel=0.02)
