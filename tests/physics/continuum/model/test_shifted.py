"""Heights that are moved, and bodies that face one another, shifted and turned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.model.surface import moments, shifted

GRID = c.Grid((30, 21), (30.0, 42.0))
WAVE = st.tuples(st.integers(-14, 14), st.integers(0, 10), st.floats(0, 6))
SHIFT = st.tuples(st.floats(-100, 100), st.floats(-100, 100))
WALL = c.LennardJonesSpline(adhesion_length=0.005)


def wave(m: int, n: int, phase: float, shift: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    x, y = GRID.positions
    return np.cos(2 * np.pi * (m * (x - shift[0]) / 30 + n * (y - shift[1]) / 42) + phase)


@given(WAVE, SHIFT)
def test_a_wave_is_moved_as_a_wave(given: tuple[int, int, float], shift: tuple[float, float]) -> None:
    # Rounding of phases of up to 100 waves.
    np.testing.assert_allclose(shifted(GRID, wave(*given), shift), wave(*given, shift), atol=1e-11)


@given(st.integers(-50, 50), st.integers(-50, 50), st.integers(0, 99))
def test_whole_points_and_periods_are_moved_exactly(i: int, j: int, seed: int) -> None:
    heights = np.random.default_rng(seed).normal(size=GRID.shape)
    np.testing.assert_array_equal(shifted(GRID, heights, (float(i), 2.0 * j)), np.roll(heights, (i, j), (0, 1)))


@given(SHIFT, st.integers(0, 99))
def test_a_shift_keeps_the_moments(shift: tuple[float, float], seed: int) -> None:
    heights = np.random.default_rng(seed).normal(size=GRID.shape)
    np.testing.assert_allclose(moments(GRID, shifted(GRID, heights, shift)), moments(GRID, heights), rtol=1e-9)


def rough(seed: int, n: int = 48) -> np.ndarray:
    return c.SelfAffine(0.8, 0.1, 6.0, 24.0).synthesise(c.Grid.square(n), np.random.default_rng(seed))


def test_two_bodies_press_as_one_wall_of_their_difference() -> None:
    one, other = rough(1), rough(2)
    pair = c.Contact(one, WALL).against(other, shift=(5.0, -3.0), angle=90)
    single = c.Contact(one - np.roll(np.rot90(other), (5, -3), (0, 1)), WALL)
    assert pair.press(mean_gap=1.3).load == single.press(mean_gap=1.3).load


def test_both_bodies_moved_and_turned_together_press_as_before() -> None:
    one, other = rough(1), rough(2)
    shift = (7.0, 11.0)
    still = c.Contact(one, WALL).against(other).press(mean_gap=1.3)
    moved = c.Contact(np.roll(np.rot90(one, 2), (7, 11), (0, 1)), WALL).against(other, shift=shift, angle=180)
    # To the tolerance of the states.
    assert moved.press(mean_gap=1.3).load == pytest.approx(still.load, rel=1e-5)


def test_a_flat_body_changes_nothing_and_a_mirrored_one_doubles_the_heights() -> None:
    one = rough(1)
    contact = c.Contact(one, WALL)
    np.testing.assert_array_equal(contact.against(np.zeros_like(one)).problem.heights, one)
    np.testing.assert_array_equal(contact.against(-one).problem.heights, 2 * one)


def test_turns_that_break_the_period_are_refused() -> None:
    grid = c.Grid((48, 40), (48.0, 40.0))
    heights = c.SelfAffine(0.8, 0.1, 6.0, 20.0).synthesise(grid, np.random.default_rng(1))
    contact = c.Contact(heights, WALL)
    with pytest.raises(ValueError, match="angle = 45"):
        contact.against(np.zeros((48, 40)), angle=45)
    with pytest.raises(ValueError, match="180 degrees"):
        contact.against(np.zeros((48, 40)), angle=90)
    assert contact.against(heights, angle=180).grid.shape == (48, 40)
    with pytest.raises(ValueError, match="other"):
        contact.against(np.zeros((40, 48)))


def test_a_body_is_not_shifted_out_of_a_map_that_is_not_repeated() -> None:
    """What left the map on one side once came back on the other."""
    alone = c.Contact(rough(1), WALL, c.NonPeriodicHalfSpace())
    for shift in ((10.0, 0.0), (0.0, -3.5)):
        with pytest.raises(ValueError, match=r"shift = .*: allowed: no shift.*what lies beyond the map is not known"):
            alone.against(rough(2), shift=shift)
    np.testing.assert_array_equal(alone.against(rough(2), angle=180).heights, rough(1) - np.rot90(rough(2), 2))
