"""Stiffness, pull-off and work of curves whose slopes and areas are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.measure.contact import Curve, adhesion, normal_stiffness


def curve(gap: list[float] | np.ndarray, load: list[float] | np.ndarray, reversal: int) -> Curve:
    gap, load = np.array(gap, dtype=float), np.array(load, dtype=float)
    return Curve(gap, gap - 1.0, load, np.arange(gap.size) > reversal)


@given(st.integers(0, 2**32), st.integers(3, 6), st.integers(2, 6))
def test_a_parabola_has_its_slope_at_each_point_of_both_branches(seed: int, to: int, fro: int) -> None:
    """Differences of second order are exact, wherever the points lie."""
    random = np.random.default_rng(seed)
    turn = random.uniform(1, 2)
    gap = turn + np.concatenate(
        [np.cumsum(random.uniform(0.1, 1, to))[::-1], [0], np.cumsum(random.uniform(0.1, 1, fro))]
    )
    a, b = random.uniform(-1, 1, 2)
    found = normal_stiffness(curve(gap, a * gap**2 + b * gap, to))
    np.testing.assert_allclose(found, -(2 * a * gap + b), atol=1e-10)


def test_the_stiffness_needs_two_points() -> None:
    assert np.isnan(normal_stiffness(curve([1.0], [0.1], 0))).all()
    np.testing.assert_allclose(normal_stiffness(curve([2, 1], [0, 0.5], 1)), 0.5)


def test_a_cycle_with_a_known_work() -> None:
    # In: no load until 1, then 2 (1 - u).  Out: the same line goes on down to -1 at u = 1.5, then snaps off.
    gap = [2.0, 1.0, 0.5, 1.0, 1.5, 1.5 + 1e-9, 2.0]
    found = adhesion(curve(gap, [0, 0, 1, 0, -1, 0, 0], 2))
    assert found.peak_load == 1
    assert found.largest_tension == 0
    assert found.pull_off == 1
    assert found.work_of_separation == pytest.approx(0.25, rel=1e-6)
    assert found.loss == pytest.approx(0.25, rel=1e-6)
    assert found.separated


def test_a_path_without_return_and_one_that_ends_early() -> None:
    there = adhesion(curve([2, 1.5, 1], [0, -0.2, 1], 2))
    assert there.largest_tension == 0.2
    assert np.isnan([there.pull_off, there.work_of_separation, there.loss]).all()
    early = adhesion(curve([2, 1.5, 1, 1.5], [0, 0, 1, -0.5], 2))
    assert not early.separated
    assert early.pull_off == 0.5
    with pytest.raises(ValueError, match="no equilibrium"):
        adhesion(curve([], [], 0))


@given(st.floats(0.1, 5), st.floats(0.1, 5), st.floats(-2, 2), st.floats(0, 3))
def test_the_loss_is_the_area_between_both_ways_as_far_as_they_go(
    to: float, fro: float, slope: float, opening: float
) -> None:
    """Two lines from one point: half of the opening times the square of the shorter way."""
    near = np.array([1.0, 0.6, 0.0])
    gap = 1.5 + np.concatenate([to * near, fro * near[1::-1]])
    found = adhesion(curve(gap, np.concatenate([-slope * to * near, -(slope + opening) * fro * near[1::-1]]), 2))
    assert found.loss == pytest.approx(0.5 * opening * min(to, fro) ** 2, abs=1e-12)


@pytest.mark.parametrize(("left", "separated"), [(0.0099, True), (0.0101, False)])
def test_a_hundredth_of_the_pull_off_is_nothing(left: float, separated: bool) -> None:
    found = adhesion(curve([2, 1, 1.5, 2], [0, 1, -3.0, -3.0 * left], 1))
    assert found.pull_off == 3
    assert found.separated == separated


@given(st.lists(st.floats(-1, 1), min_size=2, max_size=12), st.floats(0.1, 10), st.floats(0.1, 10))
def test_curves_scale_with_their_units(loads: list[float], length: float, pressure: float) -> None:
    gap = np.concatenate([np.arange(len(loads), 0, -1), np.arange(2, len(loads) + 1)]).astype(float)
    load = np.concatenate([loads, loads[-2::-1]]) + np.linspace(0, 1, gap.size)
    reversal = len(loads) - 1
    plain, scaled = curve(gap, load, reversal), curve(gap * length, load * pressure, reversal)
    # Loads and gaps of order one: differences that cancel are rounding.
    unit = pressure / length
    np.testing.assert_allclose(normal_stiffness(scaled) / unit, normal_stiffness(plain), rtol=1e-9, atol=1e-12)
    a, b = adhesion(plain), adhesion(scaled)
    assert b.pull_off == pytest.approx(a.pull_off * pressure)
    # Crossings of zero by interpolation: rounding of the sum, not of each term.
    assert b.work_of_separation == pytest.approx(a.work_of_separation * pressure * length, abs=1e-9)
    assert b.loss == pytest.approx(a.loss * pressure * length, abs=1e-9)


def test_the_work_of_a_tension_counts_from_where_the_load_crosses_zero() -> None:
    """Load from 2 to -2 along a line, then to 0: the triangle below zero, beginning in the middle of a step."""
    distance, load = np.array([0.0, 1.0, 0.0, 1.0, 3.0]), np.array([1.0, 2.0, 2.0, -2.0, 0.0])
    away = np.array([False, False, True, True, True])
    found = adhesion(Curve(mean_gap=distance, separation=distance, load=load, retracting=away))
    assert found.pull_off == 2.0
    assert found.work_of_separation == pytest.approx(0.5 * 0.5 * 2.0 + 0.5 * 2.0 * 2.0)


def test_the_work_of_a_path_that_turns_in_tension_counts_from_there() -> None:
    """From -1 to -3 along a line, then to 0: a trapeze and a triangle; of no tension at all there is none."""
    load = [0.0, -1.0, -3.0, 0.0]
    assert adhesion(curve([2.0, 1.0, 2.0, 5.0], load, 1)).work_of_separation == pytest.approx(2.0 + 4.5)
    assert adhesion(curve([2.0, 1.0, 2.0, 5.0], [0.0, 4.0, 2.0, 1.0], 1)).work_of_separation == 0.0
