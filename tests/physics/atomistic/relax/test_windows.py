"""Means over windows, on series whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from atomistic.lammps.protocol import BLOCKS
from atomistic.lammps.trace import RARE, WindowMean, correlated_error, errors_of_one_state
from tests.problems import autoregressive

SERIES, FEWER = 1500, 400
SAMPLES = 100
"""Of a window."""


def in_windows(
    rng: np.random.Generator, count: int, correlation: float, drift: float = 0.0, many: int = FEWER
) -> tuple[np.ndarray, np.ndarray]:
    """Means of windows and their own errors, shape (many, count), of series that drift by so many deviations."""
    series = autoregressive(rng, many, count * SAMPLES, correlation)
    series += drift * np.linspace(-0.5, 0.5, series.shape[1])
    blocks = series.reshape(many, count, BLOCKS, -1).mean(axis=3)
    # As the scripts say: of ten blocks about their straight line.
    t = np.arange(BLOCKS) - (BLOCKS - 1) / 2
    rest = blocks - blocks.mean(axis=2, keepdims=True)
    rest -= (rest @ t / (t @ t))[..., None] * t
    return blocks.mean(axis=2), np.sqrt((rest**2).mean(axis=2) / (BLOCKS - 2))


def windows(rng: np.random.Generator, count: int, correlation: float, **given: float) -> list[WindowMean]:
    return [WindowMean.of(*each) for each in zip(*in_windows(rng, count, correlation, **given), strict=True)]


def exact_error(length: int, correlation: float) -> float:
    """Standard error of the mean of such a series: (1 + 2 Σ (1 - k/n) c^k)/n is its square."""
    k = np.arange(1, length)
    return float(np.sqrt((1 + 2 * np.sum((1 - k / length) * correlation**k)) / length))


@pytest.mark.parametrize(("length", "correlation"), [(40, 0.0), (40, 0.6), (40, 0.8), (200, 0.9), (200, 0.97)])
def test_the_error_of_correlated_values_is_the_exact_one(
    length: int, correlation: float, rng: np.random.Generator
) -> None:
    found = [correlated_error(each) for each in autoregressive(rng, 400, length, correlation)]
    # Seen in 500 series of each: 0.96 to 1.05 of the exact one, where that of independent values gives 0.12 to 1.
    # The mean of 400 variances scatters by (2 g/n)^(1/2)/20, 4 % where 66 of 200 values are correlated.
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(exact_error(length, correlation), rel=0.12)


def test_errors_of_a_slow_quantity_are_those_of_its_windows(rng: np.random.Generator) -> None:
    correlation = 0.98  # lasts for 100 samples, a window
    values, own = in_windows(rng, 12, correlation)
    truth = exact_error(SAMPLES, correlation)
    assert np.sqrt(np.mean(own**2)) < 0.3 * truth
    found = np.array([errors_of_one_state(*each) for each in zip(values, own, strict=True)])
    # The scatter about the mean of twelve lacks the variance of that mean, a tenth.
    assert np.sqrt(np.mean(found**2)) == pytest.approx(truth, rel=0.1)
    few = np.array([1.0])
    assert errors_of_one_state(few, few) is few


# The share of SERIES that is rare scatters by sqrt(0.01/1500) = 0.0026; four times that.
SHARE = 4 * np.sqrt(RARE / SERIES)


@pytest.mark.parametrize("count", [3, 12])
def test_windows_of_independent_samples_are_of_one_state(count: int, rng: np.random.Generator) -> None:
    found = windows(rng, count, 0.0, many=SERIES)
    assert np.mean([each.drifts for each in found]) == pytest.approx(RARE, abs=SHARE)
    assert np.mean([each.scatters for each in found]) == pytest.approx(RARE, abs=SHARE)
    # The mean of the square of the largest of three estimates is above the truth, and by less than half.
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
    truth = exact_error(count * SAMPLES, correlation)
    # Of twelve windows that are correlated by a quarter, the sum of correlations is cut short: by 5 % seen.
    assert np.sqrt(np.mean([each.error**2 for each in found])) == pytest.approx(truth, rel=0.1)


def test_one_window_and_equal_ones_have_nothing_to_differ_by() -> None:
    assert WindowMean.of(np.array([2.0]), np.array([0.5])) == WindowMean(2.0, 0.5, 1, 0.0, False, 1.0, False)
    still = WindowMean.of(np.zeros(4), np.zeros(4))
    assert still.error == 0
    assert still.doubts == ""
