"""Line scans against the surfaces that they were taken from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.front.cli import main
from continuum.maps.map import Topography, TopographyError
from continuum.maps.reading import read_topography
from continuum.maps.roughness import roughness_of
from continuum.maps.spectra import isotropic_surface, profile_spectrum, surface_bands
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import prediction_of
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine, moments

GRID = Grid.square(512)


def scanned(hurst: float = 0.8, lambda_s: float = 8.0, seed: int = 1) -> np.ndarray:
    return SelfAffine(hurst, 0.1, lambda_s, 128.0).synthesise(GRID, np.random.default_rng(seed))


@pytest.mark.parametrize("power", [3.2, 4.0])
def test_abels_transform_of_a_power_law_is_inverted(power: float) -> None:
    """C = q^-p has the profile q^(1-p) √π Γ((p-1)/2)/Γ(p/2), if it goes on for ever."""
    q = np.arange(1, 2000) * 1e-3
    k = np.geomspace(1e-6, 1e4, 4001)  # in steps of 0.6 %
    # The profile of a spectrum that ends at the last q, by integration.
    inside = np.sqrt(np.maximum(q[-1] ** 2 - q**2, 0))
    profile = np.array([2 * np.trapezoid((a * a + (u := k[k <= b]) ** 2) ** (-power / 2), u) if b > 1e-6 else 0.0
                        for a, b in zip(q, inside, strict=True)])  # fmt: skip
    profile = np.maximum(profile, 1e-12 * profile.max())
    edges, density = surface_bands(q, profile)
    middle = np.sqrt(edges[1:] * edges[:-1])
    # Bands of 1/12 decade in which C falls by a factor of 1.8 - 2.2: their mean is within a tenth of the middle.
    some = slice(12, -6)
    np.testing.assert_allclose(density[some], middle[some] ** -power, rtol=0.1)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("lambda_s", [4.0, 16.0])
@pytest.mark.parametrize("periodic", [True, False])
def test_thirty_lines_have_the_slope_and_curvature_of_their_surface(
    hurst: float, lambda_s: float, periodic: bool
) -> None:
    heights = scanned(hurst, lambda_s)
    _, slope, curvature = moments(GRID, heights)
    made = isotropic_surface(heights[::17], 512.0, periodic=periodic)
    _, its_slope, its_curvature = moments(made.grid, made.heights)
    # Lines a wavelength apart are independent: 30 of them, each to 10 %.
    assert its_slope == pytest.approx(slope, rel=0.05)
    assert its_curvature == pytest.approx(curvature, rel=0.05)
    assert made.periodic
    assert made.lines == 31
    assert "31 lines of 512 points" in made.steps[-1]


def test_one_line_has_them_to_a_tenth_on_average() -> None:
    found = []
    for seed in range(6):
        heights = scanned(seed=seed)
        made = isotropic_surface(heights[:, 7], 512.0)
        found.append(moments(made.grid, made.heights)[1] / moments(GRID, heights)[1])
    # The mean of six, each to a tenth, is known to 4 %; and none of six lies beyond two and a half of its tenths.
    assert np.mean(found) == pytest.approx(1, abs=0.1)
    assert np.abs(np.array(found) - 1).max() < 0.25


def test_the_mean_square_of_a_profile_is_the_integral_of_its_spectrum() -> None:
    lines = np.random.default_rng(1).normal(size=(3, 256))
    q, c = profile_spectrum(lines, 0.5, periodic=True)
    exact = np.mean((lines - lines.mean(axis=1, keepdims=True)) ** 2)
    # Both signs of q; the last mode, Nyquist's, is its own opposite and counted once by welch.
    assert 2 * np.sum(c) * (q[1] - q[0]) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("points", [1024, 8192])
def test_a_long_scan_keeps_its_long_waves(points: int) -> None:
    """A random surface of 1024 points stood for longer scans, and had a seventh of the height of this one."""
    q = 2 * np.pi * np.fft.rfftfreq(points)
    phases = np.exp(2j * np.pi * np.random.default_rng(4).uniform(size=q.size))
    line = np.fft.irfft(np.where(q > 0, np.maximum(q, 1e-9) ** -1.3, 0) * phases)  # H = 0.8: C1 goes as q^-2.6
    found = roughness_of(isotropic_surface(line, float(points), periodic=True)).moments
    assert found.rms_height == pytest.approx(line.std(), rel=0.15)
    assert isotropic_surface(line, float(points), periodic=True).extent == pytest.approx(points)
    # The slope of an isotropic surface is that along a line times the root of two.
    slope = np.sqrt(2 * 2 * np.sum(np.abs(np.fft.rfft(line) * q) ** 2)) / points
    assert found.rms_slope == pytest.approx(slope, rel=0.15)


def test_missing_points_of_a_line_are_filled_and_said(tmp_path: Path) -> None:
    line = scanned()[3].copy()
    whole = read_topography(_saved(tmp_path, line), size=[512e-9], unit=1e-9)
    line[40:44] = np.nan
    found = read_topography(_saved(tmp_path, line), size=[512e-9], unit=1e-9)
    assert roughness_of(found).moments.rms_slope == pytest.approx(roughness_of(whole).moments.rms_slope, rel=0.05)
    assert any("0.78 % of the points, missing, filled by straight lines" in step for step in found.steps)
    line[80:90] = np.nan
    with pytest.raises(TopographyError, match=r"14 of 512 heights are missing, 2\.73 %: `fill` 3% fills them$"):
        read_topography(_saved(tmp_path, line), size=[512e-9], unit=1e-9)
    assert read_topography(_saved(tmp_path, line), size=[512e-9], unit=1e-9, fill=0.05).lines == 1


def _saved(folder: Path, line: np.ndarray) -> Path:
    np.save(folder / "line.npy", line)
    return folder / "line.npy"


@given(st.floats(1e-12, 1e6), st.floats(1e-9, 1e3))
def test_units_change_nothing(height: float, length: float) -> None:
    line = np.cumsum(np.random.default_rng(2).normal(size=128))
    one, other = isotropic_surface(line, 1.0), isotropic_surface(height * line, length)
    np.testing.assert_allclose(other.heights / height, one.heights, rtol=1e-6, atol=1e-6 * np.ptp(one.heights))
    assert other.lengths == pytest.approx((length, length))


@pytest.mark.parametrize(
    "bad", [np.zeros(100), np.arange(20.0), np.where(np.arange(100) == 3, np.nan, np.arange(100.0))]
)
def test_what_is_no_line_scan_is_one_message(bad: np.ndarray) -> None:
    with pytest.raises(TopographyError, match="at least 64 heights"):
        isotropic_surface(bad, 1.0)


def test_the_verdict_of_a_line_is_that_of_its_map_and_says_what_is_assumed() -> None:
    heights = scanned(seed=3)
    contact = Interface(1.0, 0.005, 0.35, None)
    whole = prediction_of([Topography(heights, (512.0, 512.0), True)], contact)
    line = prediction_of([isotropic_surface(heights[5], 512.0)], contact)
    # The margin goes as the slope to 7/3 over the curvature to 2/3: 10 % in each are 20 %.
    ratio = line.paper.margin / whole.paper.margin
    assert ratio == pytest.approx(1, abs=0.4)
    assert any("isotropy and Gaussian" in warning for warning in line.warnings)


def test_a_file_with_one_column_is_a_line_scan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "stylus.txt"
    np.savetxt(path, scanned()[3])
    found = read_topography(path, size=[512e-9], unit=1e-9)
    assert found.lines == 1
    assert found.lengths == pytest.approx((512e-9, 512e-9))
    with pytest.raises(TopographyError, match="one length"):
        read_topography(path, size=[1.0, 2.0], unit=1.0)
    with pytest.raises(TopographyError, match="cannot be cut"):
        read_topography(path, size=[512e-9], unit=1e-9, corners=(0, 1e-7, 0, 1e-7))
    command = ["predict", str(path), "--size", "512nm", "--unit", "nm", "--estar", "10GPa", "--work", "50mJ/m2",
               "--no-solve", "--range", "0.35nm", "-o", str(tmp_path / "out")]  # fmt: skip
    assert main(command) == 0
    assert "not a map" in capsys.readouterr().out
    assert "from 1 line" in (tmp_path / "out" / "stylus-predict.html").read_text()
