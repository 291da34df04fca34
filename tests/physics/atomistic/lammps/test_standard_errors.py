"""Standard errors of the averages of a warm deck, on series whose answer is known, and on the trace of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import toeplitz

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps import protocol as scripts
from atomistic.lammps import trace
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_in_process
from atomistic.lammps.protocol import BLOCKS, SAMPLED, Motion
from continuum.model.walls import LennardJonesSpline
from tests.problems import autoregressive

SERIES = 4000
MOTION = Motion((1.0, 1.0), (0.0, 0.0), (30.0,), 0.0, 1, 2.0, 1, 0.03)


def mean_and_error(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means and errors of series of samples, shape (series, samples)."""
    mean, error = np.array([trace.mean_and_error(series) for series in samples]).T
    return mean, error


def block_covariance(correlation: float, length: int) -> np.ndarray:
    """Covariance of the means of the blocks of such a series, exactly."""
    samples = toeplitz(correlation ** np.arange(length))
    return samples.reshape(BLOCKS, length // BLOCKS, BLOCKS, length // BLOCKS).mean(axis=(1, 3))


# The mean of the squares of SERIES errors, each with BLOCKS - 2 degrees of freedom, scatters by sqrt(2/8/4000) = 0.8 %
# of itself; four times that is 3.2 %.  A <t²> of half its size takes 12 % off white noise, and all of it off a drift.
SCATTER = 4 * np.sqrt(2 / (BLOCKS - 2) / SERIES)


@pytest.mark.parametrize("drift", [0.0, 3.0, -1e3])
@pytest.mark.parametrize("length", [10, 100, 1000])
def test_of_white_noise_the_error_is_that_of_independent_samples_whatever_the_drift(length, drift, rng):
    noise = rng.standard_normal((SERIES, length))
    mean, error = mean_and_error(5.0 + noise + drift * np.linspace(-1, 1, length))
    assert np.allclose(mean, 5.0 + noise.mean(axis=1), rtol=0, atol=1e-9 * max(1, abs(drift)))
    assert np.mean(error**2) == pytest.approx(1 / length, rel=SCATTER)
    assert np.var(mean) == pytest.approx(np.mean(error**2), rel=2 * SCATTER)


@pytest.mark.parametrize("drift", [0.0, 0.02, -30.0])
def test_a_line_alone_has_no_error(drift):
    error = mean_and_error(np.array([1.0 + drift * np.arange(200)]))[1]
    # Squares are subtracted from squares: what is left is the root of rounding.
    assert error < 1e-7 * (1 + 200 * abs(drift))


@pytest.mark.parametrize(("correlation", "length"), [(0.5, 100), (0.9, 1000), (0.99, 2000)])
def test_of_correlated_samples_the_error_is_right_where_a_block_is_longer_than_the_correlation(
    correlation, length, rng
):
    error = mean_and_error(autoregressive(rng, SERIES, length, correlation))[1]
    covariance = block_covariance(correlation, length)
    # What is left of the blocks about their line, projected exactly.
    t = np.arange(BLOCKS) - (BLOCKS - 1) / 2
    line = np.ones((BLOCKS, BLOCKS)) / BLOCKS + np.outer(t, t) / (t @ t)
    expected = np.trace((np.eye(BLOCKS) - line) @ covariance) / BLOCKS / (BLOCKS - 2)
    # Blocks that are correlated scatter a little more than independent ones.
    assert np.mean(error**2) == pytest.approx(expected, rel=2 * SCATTER)
    truth = float(covariance.mean())
    lasting = (1 + correlation) / (1 - correlation) / (length / BLOCKS)  # of a block, the part that is correlated
    # As documented, it is too small where what is correlated lasts: by about as large a part of the variance.
    assert 1 - 1.5 * lasting < expected / truth <= 1


def test_the_trace_of_a_run_has_what_lammps_sampled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    signal = "0.003*step+sin(0.37*step)"
    monkeypatch.setattr(scripts, "AVERAGES", {**scripts.AVERAGES, "signal": "v_signal"})
    deck = Deck(Slab((3, 3), 2), Springs(), LennardJonesSpline(0.0), np.zeros((3, 3)), 1.0, protocol=MOTION)
    directory = write_deck(tmp_path, deck)
    wall = directory / "in.wall"
    wall.write_text(f"variable signal equal {signal}\n{wall.read_text()}")
    found = run_in_process(directory)
    step = np.arange(SAMPLED, BLOCKS * MOTION.block[0] + 1, SAMPLED)
    assert np.array_equal(found.trace["step"], step)
    assert found.trace["signal"] == pytest.approx(0.003 * step + np.sin(0.37 * step), rel=1e-12)
    expected = mean_and_error(np.array([0.003 * step + np.sin(0.37 * step)]))
    assert found.averages["signal"] == pytest.approx([float(value[0]) for value in expected], rel=1e-9)
