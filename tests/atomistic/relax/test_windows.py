"""Means over windows, on series whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from atomistic.lammps.protocol import BLOCKS
from atomistic.relax.windows import RARE, WindowMean

SERIES = 1500
SAMPLES = 100
"""Of a window."""


def windows(rng: np.random.Generator, count: int, correlation: float, drift: float = 0.0) -> list[WindowMean]:
    """Means of series, each sample correlated with the next, that drift by as many standard deviations in all."""
    noise = rng.standard_normal((SERIES, count * SAMPLES))
    start = noise[:, :1]
    noise[:, 1:] *= np.sqrt(1 - correlation**2)
    series = np.hstack([start, lfilter([1], [1, -correlation], noise[:, 1:], zi=correlation * start)[0]])
    series += drift * np.linspace(-0.5, 0.5, series.shape[1])
    blocks = series.reshape(SERIES, count, BLOCKS, -1).mean(axis=3)
    # As the scripts say: of ten blocks about their straight line.
    t = np.arange(BLOCKS) - (BLOCKS - 1) / 2
    rest = blocks - blocks.mean(axis=2, keepdims=True)
    rest -= (rest @ t / (t @ t))[..., None] * t
    errors = np.sqrt((rest**2).mean(axis=2) / (BLOCKS - 2))
    return [WindowMean.of(value, error) for value, error in zip(blocks.mean(axis=2), errors, strict=True)]


# The share of SERIES that is rare scatters by sqrt(0.01/1500) = 0.0026; four times that.
SHARE = 4 * np.sqrt(RARE / SERIES)


@pytest.mark.parametrize("count", [3, 12])
def test_windows_of_independent_samples_are_of_one_state(count: int, rng: np.random.Generator) -> None:
    found = windows(rng, count, 0.0)
    assert np.mean([each.drifts for each in found]) == pytest.approx(RARE, abs=SHARE)
    assert np.mean([each.scatters for each in found]) == pytest.approx(RARE, abs=SHARE)
    # The mean of the square of the larger of two estimates is above the truth, and by less than half.
    truth = 1 / (count * SAMPLES)
    assert truth < np.mean([each.error**2 for each in found]) < 1.5 * truth
    assert np.var([each.mean for each in found]) == pytest.approx(truth, rel=4 * np.sqrt(2 / SERIES))


def test_a_drift_is_found_and_its_size_said(rng: np.random.Generator) -> None:
    found = windows(rng, 6, 0.0, drift=1.0)
    assert np.mean([each.drifts for each in found]) > 0.9
    # From the middle of the first window to that of the last: five sixths of it.
    assert np.mean([each.drift for each in found]) == pytest.approx(5 / 6, rel=0.02)
    assert "drifts by" in next(each for each in found if each.drifts).doubts


def test_what_is_correlated_for_longer_than_a_block_is_seen_and_the_error_is_that_of_the_windows(
    rng: np.random.Generator,
) -> None:
    correlation, count = 0.97, 12  # lasts for 65 samples, of 10 in a block
    found = windows(rng, count, correlation)
    assert np.mean([each.scatters for each in found]) > 0.9
    assert "longer windows" in next(each for each in found if each.scatters).doubts
    truth = np.std([each.mean for each in found])
    assert np.sqrt(np.mean([each.error**2 for each in found])) == pytest.approx(truth, rel=0.35)


def test_one_window_and_equal_ones_have_nothing_to_differ_by() -> None:
    assert WindowMean.of(np.array([2.0]), np.array([0.5])) == WindowMean(2.0, 0.5, 1, 0.0, False, 1.0, False)
    still = WindowMean.of(np.zeros(4), np.zeros(4))
    assert still.error == 0
    assert still.doubts == ""
