"""What was not measured: spectra continued below the pixel, against the surfaces that the maps were taken from."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.front.cli import main
from continuum.maps.map import Topography, TopographyError
from continuum.maps.mending import cut_off
from continuum.maps.roughness import roughness_of
from continuum.maps.verdict.extrapolation import continuation_of, sharpest_wave
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import PredictionNumbers, prediction_of, unmeasured_shift
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine, moments
from continuum.theory.rough import conformal_energy
from tests.kinds import covering

GRID = Grid.square(1024)
COARSE = 8
NM = 1e-9


@cache
def made(hurst: float, seed: int, slope: float, lambda_s: float) -> tuple[np.ndarray, Topography]:
    """A surface with waves up to 512 points, and what an instrument with pixels of 8 points sees: those above 16."""
    heights = SelfAffine(hurst, slope, lambda_s, 512.0).synthesise(GRID, np.random.default_rng(seed))
    seen = GRID.inverse(GRID.forward(heights) * (GRID.wavenumber <= 2 * np.pi / (2 * COARSE)))
    return heights, Topography(seen[::COARSE, ::COARSE], (1024.0, 1024.0), True, "overview")


def whole(hurst: float, seed: int = 1, slope: float = 0.1) -> np.ndarray:
    """Self-affine to the last point."""
    return made(hurst, seed, slope, 2.0)[0]


def overview(hurst: float, seed: int = 1, slope: float = 0.1, lambda_s: float = 2.0) -> Topography:
    return made(hurst, seed, slope, lambda_s)[1]


@pytest.mark.parametrize(("seed", "hurst"), covering([1, 2, 3], [0.3, 0.5, 0.8]))
def test_an_overview_continued_has_the_moments_of_the_surface(hurst: float, seed: int) -> None:
    """The overview alone has a third to two thirds of the slope, and an eighth of the curvature."""
    seen = overview(hurst, seed)
    roughness = roughness_of(seen)
    found = continuation_of([seen], [roughness], 2.0)
    assert found is not None
    contact = found.contact(prediction_of([seen], Interface(1.0, 0.01, 0.35, None), smallest=2.0).contact)
    true = moments(GRID, whole(hurst, seed))
    assert found.hursts[0] == pytest.approx(hurst, abs=0.1)
    assert roughness.moments.rms_curvature < 0.35 * true.rms_curvature
    assert contact.rms_height == pytest.approx(true.rms_height, rel=0.05)
    # The exponent scatters by some hundredths, and three octaves are 8 times: 8^0.1 is 1.23.
    assert contact.rms_slope == pytest.approx(true.rms_slope, rel=0.2)
    assert contact.rms_curvature == pytest.approx(true.rms_curvature, rel=0.3)


def test_to_the_last_measured_wave_nothing_is_added() -> None:
    seen = overview(0.8)
    found = continuation_of([seen], [roughness_of(seen)], 2.0)
    assert found is not None
    assert found.measured == pytest.approx(16.0)
    known = prediction_of([seen], Interface(1.0, 0.01, 0.35, None)).contact
    for wavelength in (16.0, 40.0):
        cut = roughness_of(seen).cut(wavelength)
        contact = found.contact(known, wavelength)
        assert contact.rms_slope == pytest.approx(cut.moments.rms_slope, rel=1e-9)
        assert contact.conformal_energy == pytest.approx(cut.conformal_energy * known.contact_modulus, rel=1e-9)
    slopes = [found.contact(known, wavelength).rms_slope for wavelength in (16.0, 15.9, 8.0, 4.0, 2.0)]
    assert slopes == sorted(slopes)
    assert slopes[1] == pytest.approx(slopes[0], rel=0.01)


def test_a_surface_with_its_own_cut_off_misses_nothing() -> None:
    seen = overview(0.8, lambda_s=64.0)
    assert continuation_of([seen], [roughness_of(seen)], 0.01) is None
    # A cut-off that was asked for is none of the surface.
    rough = cut_off(overview(0.8), 64.0)
    found = continuation_of([rough], [roughness_of(rough)], 2.0)
    assert found is not None
    assert found.measured == pytest.approx(64.0)


def test_a_blunt_tip_measures_waves_that_are_half_as_sharp() -> None:
    seen = overview(0.8)
    roughness = roughness_of(seen)
    whole_curvature = roughness.moments.rms_curvature
    assert sharpest_wave(roughness, 0.5 / whole_curvature) == 0.0
    waves = [sharpest_wave(roughness, factor / whole_curvature) for factor in (1.5, 3.0, 6.0)]
    assert 16.0 < waves[0] < waves[1] < waves[2]
    assert roughness.cut(waves[1]).moments.rms_curvature < whole_curvature / 3
    blunt = continuation_of([seen], [roughness], 2.0, tip=3 / whole_curvature)
    assert blunt is not None
    assert blunt.measured == pytest.approx(waves[1])
    sharp = continuation_of([seen], [roughness], 2.0)
    assert sharp is not None
    contact = prediction_of([seen], Interface(1.0, 0.01, 0.35, None)).contact
    assert blunt.contact(contact).rms_slope == pytest.approx(sharp.contact(contact).rms_slope, rel=0.2)


def sticky_overview(work: float = 1e-3, **more: Any) -> PredictionNumbers:
    """An overview in nm that is sticky alone, and of which that is not known with its short waves."""
    return prediction_of([small_overview()], Interface(1e9, work, 0.6 * NM, None), **more)


@cache
def small_overview() -> Topography:
    return Topography(NM * overview(0.3, slope=0.2).heights, (1024 * NM, 1024 * NM), True, "overview")


def test_the_threshold_grows_with_the_waves_that_were_not_measured_and_what_that_changes_is_undecided() -> None:
    """The energy of full contact of the surface is that of the overview times this, to a tenth."""
    found = sticky_overview(smallest=2 * NM)
    shift = unmeasured_shift(found)
    assert shift is not None
    heights = whole(0.3, slope=0.2)
    power_q = np.abs(GRID.forward(heights)) ** 2 * GRID.mode_weights
    true = conformal_energy(GRID.wavenumber, power_q) / roughness_of(found.topographies[0]).conformal_energy * NM
    assert shift == pytest.approx(true, rel=0.1)  # h_rms, and with it F, hardly changes
    assert unmeasured_shift(sticky_overview(smallest=16 * NM)) is None
    pressed = found.solved(search=False)
    assert pressed.threshold is not None
    for factor, answer in ((1.01, "undecided"), (1.01 * shift, "sticky")):
        work = factor * pressed.threshold.high
        again = replace(sticky_overview(work, smallest=2 * NM), threshold=pressed.threshold)
        assert again.verdict.answer == answer
        assert ("waves below 16 nm were not measured" in again.verdict.why) is (answer == "undecided")


def test_units_change_nothing() -> None:
    seen, scale = overview(0.5), NM
    small = Topography(scale * seen.heights, (1024 * scale, 1024 * scale), True)
    contact = Interface(1.0, 0.01, 0.35, None), Interface(1.0, 0.01 * scale, 0.35 * scale, None)
    one, other = prediction_of([seen], contact[0], 2.0), prediction_of([small], contact[1], 2.0 * scale)
    assert one.continuation is not None
    assert other.continuation is not None
    first, second = one.continuation.contact(one.contact), other.continuation.contact(other.contact)
    assert second.rms_slope == pytest.approx(first.rms_slope, rel=1e-6)
    assert second.rms_curvature * scale == pytest.approx(first.rms_curvature, rel=1e-6)


def test_two_bodies_are_continued_each() -> None:
    maps = [overview(0.3, 1), overview(0.8, 2)]
    found = prediction_of(maps, Interface(1.0, 0.01, 0.35, None), smallest=2.0)
    assert found.continuation is not None
    assert len(found.continuation.hursts) == 2
    alone = [prediction_of([one], Interface(1.0, 0.01, 0.35, None), smallest=2.0) for one in maps]
    squares = [one.continuation.contact(one.contact).rms_slope ** 2 for one in alone if one.continuation is not None]
    assert found.continuation.contact(found.contact).rms_slope == pytest.approx(np.sqrt(sum(squares)), rel=1e-6)


def test_the_command_takes_a_tip_and_a_smallest_wave(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "map.npy", overview(0.3, slope=0.2).heights)
    known = ["--size", "1024nm", "--unit", "nm", "--estar", "1GPa", "--work", "1mJ/m2", "--range", "0.6nm",
             "--periodic", "--no-solve", "-o", str(tmp_path / "out")]  # fmt: skip
    for option, value, expected in (
        ("--tip", "10", "--tip '10': a unit of length is missing"),
        ("--smallest", "2GPa", "not a unit of length"),
        ("--smallest", "0nm", "positive"),
    ):
        assert main(["predict", str(tmp_path / "map.npy"), *known[:-2], option, value]) == 2
        assert expected in capsys.readouterr().err


def test_arguments_are_named() -> None:
    heights = overview(0.8).heights
    known: dict[str, Any] = {"size": "1um", "unit": "nm", "material": "mica", "solve": False}
    with pytest.raises(TopographyError, match="`tip` '3': a unit of length"):
        c.predict(heights, **known, tip="3")
    with pytest.raises(ValueError, match="smallest = 3: "):
        c.predict(heights, **known, smallest=3)
    with pytest.raises(ValueError, match="tip = -1"):
        prediction_of([overview(0.8)], Interface(1.0, 0.01, 0.35, None), tip=-1.0)
