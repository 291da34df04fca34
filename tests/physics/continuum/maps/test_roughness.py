"""Moments, spectra and fits of maps whose roughness is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.maps.map import Topography
from continuum.maps.mending import detrend
from continuum.maps.roughness import Roughness, fit_self_affine, hann, roughness_of, spectrum, stencil_moments, together
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine, moments
from tests.kinds import covering


def sine(grid: Grid, m: int, n: int, phase: float = 0.3) -> Real:
    x, y = grid.positions
    return np.asarray(np.cos(2 * np.pi * (m * x / grid.lengths[0] + n * y / grid.lengths[1]) + phase))


def self_affine(hurst: float, seed: int = 0, n: int = 256, lambda_s: float = 8.0, lambda_l: float = 64.0) -> Topography:
    grid = Grid.square(n)
    heights = SelfAffine(hurst, 0.1, lambda_s, lambda_l).synthesise(grid, np.random.default_rng(seed))
    return Topography(heights, grid.lengths, periodic=True)


@pytest.mark.parametrize("shape", [(32, 40), (33, 41)])
def test_a_wave_has_its_moments_whatever_the_pixels(shape: tuple[int, int]) -> None:
    grid = Grid(shape, (3.0, 11.0))
    q = 2 * np.pi * np.hypot(3 / 3.0, 5 / 11.0)
    found = roughness_of(Topography(sine(grid, 3, 5), grid.lengths, periodic=True))
    assert found.moments == pytest.approx(np.sqrt(0.5) * np.array([1, q, q**2]), rel=1e-10)
    assert found.conformal_energy == pytest.approx(q / 8, rel=1e-10)  # E*/4 q <h²>


def test_a_periodic_map_has_the_moments_of_the_solver_s_surfaces() -> None:
    topography = self_affine(0.8)
    found = roughness_of(topography)
    assert found.moments == pytest.approx(moments(topography.grid, topography.heights), rel=1e-10)
    assert found.whole.moments == pytest.approx(found.moments, rel=1e-10)


@pytest.mark.parametrize("periodic", [True, False])
def test_differences_converge_to_the_derivatives_with_the_second_power_of_the_pixel(periodic: bool) -> None:
    q = 2 * np.pi * np.hypot(2, 3)
    errors = []
    for n in (64, 128, 256):
        grid = Grid((n, n), (1.0, 1.0))
        found = stencil_moments(grid, sine(grid, 2, 3), periodic)
        errors.append([found.rms_slope * np.sqrt(2) / q - 1, found.rms_curvature * np.sqrt(2) / q**2 - 1])
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    # Without periodicity half a wave more or less at the edges counts as 1/n.
    assert order == pytest.approx(np.full((2, 2), 2.0), abs=0.02) if periodic else np.abs(errors[-1]).max() < 0.02


@given(st.integers(16, 60), st.integers(16, 60))
def test_the_window_keeps_the_mean_square(nx: int, ny: int) -> None:
    assert np.mean(hann((nx, ny)) ** 2) == pytest.approx(1.0, rel=1e-12)


def test_a_cut_off_is_a_filter() -> None:
    topography = self_affine(0.5, n=128)
    grid, found = topography.grid, roughness_of(topography)
    for wavelength in (8.0, 13.0, 30.0):
        spectrum_q = grid.forward(topography.heights)
        spectrum_q[grid.wavenumber > 2 * np.pi / wavelength * (1 + 1e-12)] = 0
        assert found.cut(wavelength).moments == pytest.approx(moments(grid, grid.inverse(spectrum_q)), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_cut_out_part_has_the_roughness_of_the_whole(seed: int) -> None:
    whole = self_affine(0.8, seed, n=512)
    part = roughness_of(detrend(Topography(whole.heights[:250, :260], (250.0, 260.0))))
    expected = moments(whole.grid, whole.heights)
    # A quarter of a surface with 64 patches of λ_L²: 6 % of scatter in the slope, three times that is allowed.
    assert part.moments.rms_slope == pytest.approx(expected.rms_slope, rel=0.18)
    assert part.moments.rms_curvature == pytest.approx(expected.rms_curvature, rel=0.12)
    # The window sees another part of the same surface.
    assert part.spectral.rms_slope == pytest.approx(part.moments.rms_slope, rel=0.15)


def test_an_edge_is_no_roughness(rng: np.random.Generator) -> None:
    # A parabola repeats with a kink, a cubic with a step: the window, and differences, do not see it.
    x = np.linspace(-1, 1, 256)[:, None] + np.zeros((1, 256))
    found = roughness_of(detrend(Topography(x**3, (256.0, 256.0))))
    exact = float(np.sqrt(np.mean((3 * x**2 - np.mean(3 * x**2) + 0.4) ** 2))) * 2 / 255
    assert found.moments.rms_slope == pytest.approx(exact, rel=0.02)
    closed = roughness_of(detrend(Topography(x**3, (256.0, 256.0), periodic=True)))
    assert closed.moments.rms_slope > 5 * exact


def test_two_bodies_together_are_rougher_by_their_squares() -> None:
    first, second = self_affine(0.8, 1), self_affine(0.3, 2, n=128)
    a, b = roughness_of(first), roughness_of(second)
    both = together(a, b)
    assert both.moments == pytest.approx(np.hypot(a.moments, b.moments))
    assert both.conformal_energy == pytest.approx(a.conformal_energy + b.conformal_energy)
    assert both.cut(16.0).moments == pytest.approx(np.hypot(a.cut(16.0).moments, b.cut(16.0).moments))
    # Disjoint waves on one grid: the sum of the maps has exactly these moments.
    grid = Grid.square(64)
    maps = [sine(grid, 3, 1), 0.3 * sine(grid, 1, 7)]
    parts: list[Roughness] = [roughness_of(Topography(h, grid.lengths, periodic=True)) for h in maps]
    summed = roughness_of(Topography(maps[0] + maps[1], grid.lengths, periodic=True))
    assert together(*parts).moments == pytest.approx(summed.moments, rel=1e-9)


@pytest.mark.parametrize(("hurst", "periodic"), covering([0.3, 0.5, 0.8], [True, False]))
def test_the_fit_finds_exponent_and_cut_offs(hurst: float, periodic: bool) -> None:
    for seed in range(3):
        grid = Grid.square(512)
        heights = SelfAffine(hurst, 0.1, 8.0, 128.0).synthesise(grid, np.random.default_rng(seed))
        fit = fit_self_affine(*spectrum(Topography(heights, grid.lengths, periodic)))
        assert fit is not None
        # The largest waves of one realisation scatter: 0.09 was the largest deviation of 24.
        assert fit.hurst == pytest.approx(hurst, abs=0.12)
        # The corners are bands of 21 %; four waves of λ_L in the map do not fix λ_L better than to a factor of 1.5.
        # Rings of waves of a map of 64 λ_s are 1.6 % apart; 1.2 % was seen.
        assert fit.cut_off == pytest.approx(8.0, rel=0.03)
        assert fit.roll_off is not None
        assert 128 / 1.5 < fit.roll_off < 128 * 1.5
        assert fit.floor is None


def test_noise_is_told_from_roughness(rng: np.random.Generator) -> None:
    grid = Grid.square(512)
    heights = SelfAffine(0.8, 0.1, 4.0, 128.0).synthesise(grid, np.random.default_rng(3))
    noisy = Topography(heights + rng.normal(scale=0.05, size=grid.shape), grid.lengths, periodic=True)
    q, c = spectrum(noisy)
    fit = fit_self_affine(q, c)
    assert fit is not None
    assert fit.floor is not None
    # White noise has C = σ² dx²/(2π)²; the corner is where the surface falls below it.
    clean = spectrum(Topography(heights, grid.lengths, periodic=True))[1]
    crossing = 2 * np.pi / q[np.flatnonzero(clean > 0.05**2 / (2 * np.pi) ** 2)[-1]]
    assert crossing / 1.6 < fit.floor < crossing * 1.6
    assert fit.cut_off is None


def test_what_cannot_be_fitted_is_not() -> None:
    q = np.linspace(1, 10, 200)
    assert fit_self_affine(q, np.ones(200)) is None
    assert fit_self_affine(q[:3], q[:3] ** -3.0) is None
