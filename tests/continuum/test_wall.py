"""Wall laws: the paper's numbers, continuity, tables."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum import theory
from continuum.wall import LennardJonesSpline, Tabulated

RANGES = [0.10954, 0.34641, 1.09545]


def table_of(wall: LennardJonesSpline, knots: int) -> Tabulated:
    gap = np.linspace(wall.core, 1 + wall.range, knots)
    return Tabulated(gap, wall.evaluate(gap).traction)


@pytest.mark.parametrize(("adhesion_length", "range_"), list(zip([0.0005, 0.005, 0.05], RANGES, strict=True)))
def test_adhesion_lengths_of_the_paper(adhesion_length: float, range_: float) -> None:
    wall = LennardJonesSpline.from_adhesion_length(adhesion_length)
    assert wall.range == pytest.approx(range_, abs=5e-6)  # the digits printed in DESIGN.md
    assert wall.work_of_adhesion == pytest.approx(adhesion_length, rel=1e-14)
    assert theory.spline_adhesion_length(wall.range) == pytest.approx(adhesion_length, rel=1e-14)
    # The energy at the minimum is minus the work of adhesion, and vanishes at the cut-off.
    energy = wall.evaluate(np.array([1.0, 1 + wall.range, 5.0])).energy
    np.testing.assert_allclose(energy, [-adhesion_length, 0, 0], atol=1e-16)


@pytest.mark.parametrize("range_", RANGES)
def test_largest_tension_and_softening(range_: float) -> None:
    wall = LennardJonesSpline(range_)
    fine = wall.evaluate(np.linspace(1, 1 + range_, 300001))
    # Second order in the spacing of the sample, 3e-6 of the range.
    assert -fine.traction.min() == pytest.approx(2 / 27 * range_, rel=1e-9)
    assert wall.largest_tension == pytest.approx(2 / 27 * range_, rel=1e-14)
    assert -fine.stiffness.min() == pytest.approx(1 / 6, rel=1e-9)
    assert theory.snap_in_wavelength(-fine.stiffness.min()) == pytest.approx(6 * np.pi, rel=1e-8)


@pytest.mark.parametrize("range_", RANGES)
def test_effective_range_is_1_05659_of_the_range(range_: float) -> None:
    wall = LennardJonesSpline(range_)
    found = theory.effective_range(lambda x: -float(wall.evaluate(np.array(1 + x)).traction), cutoff=range_)
    assert found / range_ == pytest.approx(1.05659, abs=5e-6)


def test_effective_ranges_of_the_untruncated_laws() -> None:
    # Eq. (deltar): 1.15 a0 for 9-3 and 0.62 a0 for 12-6, the latter as a surface law, pressure z^-7 - z^-13.
    assert theory.effective_range(lambda x: (1 + x) ** -4 - (1 + x) ** -10) == pytest.approx(1.15294, abs=5e-6)
    assert theory.effective_range(lambda x: (1 + x) ** -7 - (1 + x) ** -13) == pytest.approx(0.62043, abs=5e-6)


@given(st.floats(0.01, 3), st.floats(0.05, 50), st.floats(0.5, 0.9))
def test_the_law_is_smooth_at_its_joints(range_: float, stiffness: float, core: float) -> None:
    wall = LennardJonesSpline(range_, stiffness, core)
    for joint in (core, 1.0, 1 + range_):
        left, right = wall.evaluate(np.array([np.nextafter(joint, 0), np.nextafter(joint, 9)]))[1:]
        assert left[0] == pytest.approx(left[1], abs=1e-9 * stiffness)
        assert right[0] == pytest.approx(right[1], rel=1e-9, abs=1e-9 * stiffness)
    assert wall.evaluate(np.array([1.0])).stiffness[0] == pytest.approx(stiffness, rel=1e-12)


@given(st.floats(-1e6, 1e6), st.sampled_from([0.0, *RANGES]))
def test_a_law_is_finite_at_any_gap(gap: float, range_: float) -> None:
    for wall in (LennardJonesSpline(range_), table_of(LennardJonesSpline(range_), 50)):
        response = wall.evaluate(np.array([gap]))
        assert np.isfinite(response).all()
        assert (response.traction[0] > 0) == (gap < wall.zero_gap) or abs(gap - wall.zero_gap) < 1e-3


def test_the_nonadhesive_law_never_pulls() -> None:
    wall = LennardJonesSpline(0)
    response = wall.evaluate(np.linspace(0.5, 3, 1001))
    assert response.traction.min() == 0.0
    assert wall.work_of_adhesion == 0.0
    assert response.energy[-1] == 0.0
    # It is the paper's law without its attraction: the same pressure where it pushes.
    adhesive = LennardJonesSpline(0.3).evaluate(np.linspace(0.5, 1, 101))
    np.testing.assert_array_equal(wall.evaluate(np.linspace(0.5, 1, 101)).traction, adhesive.traction)


def test_a_table_converges_to_the_law_it_samples() -> None:
    wall = LennardJonesSpline(0.34641)
    gap = np.linspace(0.71, 1.4, 4001)
    exact = wall.evaluate(gap)
    # The second derivative of the pressure jumps at a0, by J; within the interval that holds the jump the
    # spline deviates by at most J h²/8, the bound of linear interpolation.
    jump = abs(0.5 / 6 * (110 - 20) - 4 * 0.5 / wall.range)
    for knots in (101, 401):
        spacing = (1 + wall.range - wall.core) / (knots - 1)
        error = np.abs(table_of(wall, knots).evaluate(gap).traction - exact.traction).max()
        assert 0 < error < jump * spacing**2 / 8
    table = table_of(wall, 401)
    assert table.work_of_adhesion == pytest.approx(wall.work_of_adhesion, rel=1e-5)
    assert table.zero_gap == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("gap", "traction", "fault"),
    [
        ([0.7, 0.8, 0.9], [1, 0.5, 0], "at least 4 rows"),
        ([0.7, 0.8, 0.8, 1], [1, 0.5, 0.2, 0], "increase"),
        ([0.7, 0.8, 0.9, 1], [1, np.nan, 0.2, 0], "finite"),
        ([0.7, 0.8, 0.9, 1], [1, 0.5, 0.2, 0.1], "vanished"),
        ([0.7, 0.8, 0.9, 1], [-1, 0.5, 0.2, 0], "repulsive"),
    ],
)
def test_a_table_that_is_no_wall_is_refused(gap: list[float], traction: list[float], fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        Tabulated(np.array(gap), np.array(traction))


@pytest.mark.parametrize("bad", [{"range": -0.1}, {"range": np.nan}, {"range": 0.1, "core": 1.2}])
def test_a_law_that_is_none_is_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="wall"):
        LennardJonesSpline(**bad)
