"""What a grid shows, and from where on it is said that it does not: bounds on both sides, shares of known spectra."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.inputs.arguments import ArgumentError
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem, check_slope, doubts, other_unit, short_waves, steep, unresolved
from continuum.model.substrates import HalfSpace, TabulatedSubstrate
from continuum.model.surfaces import sine
from continuum.model.walls import HardWall, LennardJonesSpline, Wall

GRID = Grid((64, 32), (64.0, 64.0))  # its widest step, along y, is 2 a0
LONG = LennardJonesSpline(1.0)


def problem(heights: np.ndarray, wall: Wall = LONG, stiffness: float = 1.0) -> ContactProblem:
    """A half-space of some modulus."""
    table = stiffness * HalfSpace("free").stiffness(GRID)
    return ContactProblem(GRID, wall, heights, TabulatedSubstrate(table, GRID.lengths, "a half-space"))


def test_a_slope_is_positive_and_at_most_ten_and_above_three_tenths_it_is_steep() -> None:
    for slope in (1e-300, 10.0, 10 * (1 + 1e-10)):
        check_slope(slope)
    for slope in (0.0, -1.0, 10 * (1 + 1e-8), np.nan):
        with pytest.raises(ArgumentError, match="rms slope"):
            check_slope(slope)
    assert not [*steep(0.3), *steep(0.3 * (1 + 1e-10))]
    assert "above 0.3" in "".join(steep(0.3 * (1 + 1e-8)))


def test_the_share_of_short_waves_is_that_of_their_slopes() -> None:
    # Four points of 2 a0 are a wave of 8 a0: eight of them in the period.
    for waves, short in (((8, 0), False), ((9, 0), True), ((0, 8), False), ((0, 9), True), ((6, 6), True)):
        assert short_waves(problem(sine(GRID, 0.1, waves))) == pytest.approx(float(short), abs=1e-12)
    both = sine(GRID, 0.2, (5, 0)) + sine(GRID, 0.1, (0, 10))
    assert short_waves(problem(both)) == pytest.approx((0.1 * 10) ** 2 / ((0.1 * 10) ** 2 + (0.2 * 5) ** 2), rel=1e-12)
    assert short_waves(problem(np.zeros(GRID.shape))) == 0


@pytest.mark.parametrize(("share", "said"), [(0.049, False), (0.051, True)])
def test_a_twentieth_of_the_slope_may_lie_in_short_waves(share: float, said: bool) -> None:
    heights = np.sqrt(share) / 10 * sine(GRID, 1.0, (0, 10)) + np.sqrt(1 - share) / 5 * sine(GRID, 1.0, (5, 0))
    found = "".join(unresolved(problem(1e-3 * heights), 1e-3))
    assert ("5% of the mean square slope" in found) == said


@pytest.mark.parametrize(("shortest", "said"), [(8.0, False), (8 * (1 - 1e-10), False), (8 * (1 - 1e-8), True)])
def test_a_wave_has_four_points_of_the_wider_step(shortest: float, said: bool) -> None:
    found = "".join(unresolved(problem(sine(GRID, 1e-3, (0, 12))), 1e-3, shortest))
    assert ("fewer than 4 points" in found) == said
    assert "mean square slope" not in found


@pytest.mark.parametrize(("modulus", "said"), [(0.101, False), (9.9, False), (0.099, True), (10.1, True)])
def test_a_stiffness_of_another_unit_is_ten_times_off(modulus: float, said: bool) -> None:
    found = "".join(other_unit(problem(sine(GRID, 0.1, (1, 0)), stiffness=modulus)))
    assert (f"{modulus:.3g} times as stiff" in found) == said
    assert bool(found) == said


def test_the_range_is_beside_the_change_of_the_gap_over_a_step() -> None:
    heights = sine(GRID, 1e-3, (1, 0))
    for range_, said in ((0.21, False), (0.19, True)):
        found = "".join(unresolved(problem(heights, LennardJonesSpline(range_)), 0.1, 100.0))
        assert ("h'rms times the spacing, 0.2 a0" in found) == said
    # Where nothing attracts there is no rim, and nothing snaps.
    for wall in (HardWall(), LennardJonesSpline(0.0)):
        assert not [*unresolved(problem(heights, wall), 1.0, 100.0)]


@pytest.mark.parametrize(("stiffness", "said"), [(0.999, False), (1.001, True)])
def test_waves_that_snap_together_are_longer_than_four_points(stiffness: float, said: bool) -> None:
    # The softening k/3 meets E* q/2 at the wavelength 3 π E*/k: 8 a0 for k = 3 π/8.
    wall = LennardJonesSpline(1.0, stiffness * 3 * np.pi / 8)
    found = doubts(problem(sine(GRID, 1e-3, (1, 0)), wall), 1e-3, 100.0)
    assert ("snap in" in "".join(found)) == said
    assert len(found) == said
