"""The sampling error of a threshold: none between equal blocks, the scatter of spots, and what is said of a surface."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from continuum.maps.map import Topography
from continuum.maps.verdict.extrapolation import FLOOR, Blocks
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import PredictionNumbers, prediction_of
from continuum.maps.verdict.threshold import MapThreshold, PressedMap, press_map
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.show.answer import statements

N, ROLL_OFF = 96, 16.0


def rough(n: int, roll_off: float, seed: int = 1) -> np.ndarray:
    heights = SelfAffine(0.7, 0.1, 4.0, roll_off).synthesise(Grid.square(n), np.random.default_rng(seed))
    return heights / heights.std() / 6


def pressed(heights: np.ndarray, unit: float = 1.0) -> PressedMap:
    side = unit * heights.shape[0]
    return press_map(Topography(unit * heights, (side, side), True), Interface(1.0, 1.0, unit / 12, None))


@cache
def predicted() -> PredictionNumbers:
    """Of a map of six roll-off lengths."""
    topography = Topography(1e-9 * rough(N, ROLL_OFF), (N * 1e-9, N * 1e-9), True)
    return prediction_of([topography], Interface(1e9, 1.0, 0.08e-9, None), smallest=4e-9).solved(search=False)


def test_blocks_cover_a_map_and_keep_its_mean() -> None:
    values = np.random.default_rng(1).normal(size=(40, 63))
    blocks = Blocks.of((40.0, 63.0), 10.0)
    assert blocks == (4, 6)
    sizes = Blocks(4, 7).means(values)
    assert sizes.shape == (4, 7)
    assert sizes.mean() == pytest.approx(values.mean())  # blocks of one size
    assert Blocks(2, 1).means(values)[1, 0] == pytest.approx(values[20:].mean())
    assert not Blocks.of((40.0, 63.0), 40.0).enough
    assert Blocks.of((39.0, 1.0), 10.0) == (4, 1)  # a roll-off is known to a band


def test_equal_blocks_have_no_scatter() -> None:
    """A surface that repeats itself sixteen times is known as well as its one period."""
    tiled = np.tile(rough(32, 16.0), (4, 4))
    # The residual of the states, relative to h' E*, and its edges, move the thresholds of blocks by a thousandth.
    assert pressed(tiled).sampling_error(32.0) == pytest.approx(FLOOR, rel=0.01)


def test_the_error_of_a_map_is_about_the_scatter_of_spots_and_has_no_unit() -> None:
    """Spots of 64² points, of one surface, whose roll-off is a quarter of a spot."""
    whole = rough(4 * 64, 16.0, seed=5)
    spots = [pressed(whole[i : i + 64, j : j + 64]) for i in (0, 64, 128) for j in (0, 64, 128)]
    scatter = np.std([np.log(one.threshold().work) for one in spots], ddof=1)
    errors = [one.sampling_error(16.0) for one in spots[:4]]
    # The standard error of a scatter of nine is a quarter of it, and the error was up to 1.5 times the scatter.
    assert 0.6 * scatter < np.median(errors) < 2 * scatter
    other = pressed(1e-9 * whole[:64, :64] / 1e-9, unit=1e-9)
    assert other.sampling_error(16e-9) == pytest.approx(errors[0], rel=0.02)


def test_a_map_without_roll_off_says_that_it_is_one_spot() -> None:
    assert np.isnan(pressed(rough(N, ROLL_OFF)).sampling_error(N / 2))
    found = predicted()
    assert found.threshold is not None
    assert np.isfinite(found.threshold.sampling)
    alone = replace(found, threshold=replace(found.threshold, sampling=np.nan))
    assert any("this spot only" in line for line in statements(alone))
    assert not any("this spot only" in line for line in statements(found))


def test_the_interval_of_the_surface_holds_that_of_the_map() -> None:
    found = predicted().threshold
    assert isinstance(found, MapThreshold)
    low, high = found.of_surface
    assert low < found.low < found.work < found.high < high
    assert np.log(high / found.work) == pytest.approx(np.hypot(np.log(found.high / found.work), 2 * found.sampling))
    between = (found.high * high) ** 0.5
    assert found.sticky(between) is True
    assert found.surface_sticky(between) is None
    assert found.surface_sticky(1.01 * high) is True
    assert found.surface_sticky(0.99 * low) is False
