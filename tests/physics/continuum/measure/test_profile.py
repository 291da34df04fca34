"""Areas, gap profiles and distributions: against exact contacts, and of rough ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.measure.contact import REPULSIVE, contact_map, totals_of
from continuum.measure.outline import (
    EDGE_DEPTH,
    EDGE_SHARE,
    GapProfile,
    areas,
    gap_distribution,
    gap_profile,
    outline,
    pressure_distribution,
)
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine, moments
from continuum.model.surfaces import sine, sphere
from continuum.model.walls import HardWall, LennardJonesSpline
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver
from continuum.theory.paper import attraction_width
from continuum.theory.paper import gap_outside_contact as predicted_gap
from continuum.theory.smooth import Hertz
from tests.classical import Westergaard
from tests.problems import distance

WALL = LennardJonesSpline(adhesion_length=0.005)


# --- areas -------------------------------------------------------------------------------------------------


def test_the_contour_of_a_bowl_has_the_area_of_a_disc() -> None:
    rng, radius = np.random.default_rng(2), 10.0
    errors = {"contour": [], "cells": []}
    grid = Grid.square(40)
    bounds = []
    for _ in range(200):
        # A bowl whose gap is zero_gap at the radius: exactly what linear interpolation gets wrong by a0²/R only.
        gap = WALL.zero_gap + 0.1 * (distance(grid, tuple(40 * rng.random(2))) - radius)
        found = areas(grid, WALL, gap)
        exact = np.pi * radius**2 / grid.area
        bounds.append(found.interior < exact < found.dilated)
        errors["contour"].append(found.contour / exact - 1)
        errors["cells"].append((found.repulsive - exact) / found.uncertainty)
        assert found.within_range == pytest.approx(found.repulsive + found.attracted)
    assert all(bounds)
    # Sides of a polygon with corners on a circle, about a0 long: below by (a0/R)²/12 to (a0/R)²/6.
    assert -(radius**-2) / 4 < np.mean(errors["contour"]) < 0
    assert abs(np.mean(errors["cells"])) < 0.2  # unbiased
    assert 0.3 < np.std(errors["cells"]) < 1.0  # and the uncertainty is an upper bound, not far off


def test_the_correction_removes_most_of_the_bias_of_a_hard_contact() -> None:
    rng, radius, bias, left = np.random.default_rng(3), 100.0, [], []
    for _ in range(12):
        grid = Grid.square(96)
        x, y = grid.positions
        a, centre = 8.0, 48 + rng.random(2)
        heights = ((x - centre[0]) ** 2 + (y - centre[1]) ** 2) / (2 * radius)
        pressure = 4 * a**3 / (3 * radius) / grid.area
        assert Hertz(radius, pressure * grid.area).contact_radius == pytest.approx(a)
        found = Solver(grid, HalfSpace("free").stiffness(grid)).constrain(
            heights, None, Settings(1e-7), pressure=pressure
        )
        measured = areas(grid, HardWall(), found.gap)
        assert np.isnan(measured.contour)
        exact = np.pi * a**2 / grid.area
        assert measured.interior < exact < measured.dilated
        bias.append(measured.repulsive / exact - 1)
        left.append(measured.corrected / exact - 1)
    # 0.09 cells per edge here (the images take the contact in a little), 0.118 for an edge far from any other.
    assert 0.02 < np.mean(bias) < 0.05
    assert abs(np.mean(left)) < 0.5 * np.mean(bias)
    assert pytest.approx(0.11811, abs=1e-5) == EDGE_SHARE


@given(st.integers(0, 2**32), st.integers(0, 9), st.integers(0, 9))
def test_areas_do_not_depend_on_the_origin_or_the_axes(seed: int, i: int, j: int) -> None:
    grid = Grid((9, 8), (9.0, 8.0))
    gap = np.random.default_rng(seed).uniform(0.8, 1.6, grid.shape)
    found = areas(grid, WALL, gap)
    for other, there in ((gap.T, Grid((8, 9), (8.0, 9.0))), (np.roll(gap, (i, j), (0, 1)), grid)):
        np.testing.assert_allclose(
            list(vars(areas(there, WALL, other)).values()), list(vars(found).values()), rtol=1e-12
        )
    assert found.interior <= found.contour <= found.dilated
    assert found.uncertainty == pytest.approx(np.sqrt((found.repulsive - found.interior) / 12 / grid.size))
    assert found.repulsive == totals_of(grid, WALL, gap).area_rep
    assert found.attracted == pytest.approx(totals_of(grid, WALL, gap).area_att)


@pytest.mark.parametrize("wall", [WALL, HardWall()], ids=["law", "hard"])
def test_totals_of_many_rows_are_the_means_over_all(wall: LennardJonesSpline | HardWall) -> None:
    """Sums go over blocks of rows: three of them here, the last one shorter."""
    grid, rng = Grid((600, 3), (300.0, 6.0)), np.random.default_rng(1)
    gap, traction = np.maximum(rng.uniform(-0.5, 1.6, grid.shape), 0.0), rng.normal(size=grid.shape)
    found = totals_of(grid, wall, gap, traction)
    assert found.load_rep == pytest.approx(np.maximum(traction, 0).mean(), rel=1e-12)
    assert found.load_att == pytest.approx(np.maximum(-traction, 0).mean(), rel=1e-12)
    assert found.load == pytest.approx(traction.mean(), rel=1e-12)
    assert found.area_rep == np.mean(gap < wall.zero_gap if wall is WALL else gap <= 0)
    assert found.wall_energy == pytest.approx(wall.energy(gap).mean(), rel=1e-12)
    assert found.smallest_gap == 0.0
    if wall is WALL:
        law = totals_of(grid, wall, gap)
        assert law.load == pytest.approx(wall.evaluate(gap).traction.mean(), rel=1e-12)
        assert law.wall_energy == found.wall_energy


# --- the gap profile ---------------------------------------------------------------------------------------


def test_distances_from_a_disc_wrap_over_the_seam() -> None:
    grid = Grid.square(120)
    r = distance(grid, (2.3, 118.8))
    profile = gap_profile(grid, 1.5 + (r - 20), r < 20, 30.0, 1.5)  # the gap is the true distance
    # The nearest cell has the more to choose from, the farther off it is: 0.5 cells deep at first, 0.25 at 30.
    assert (np.abs(profile.gap - profile.distance) < 0.2).all()
    np.testing.assert_allclose(profile.from_perimeter_cells, profile.distance + 3 / 8)
    assert profile.width(10.0) == pytest.approx(10, rel=0.05)
    assert np.isnan(profile.width(40.0))


def test_stripes_have_exact_distances() -> None:
    grid = Grid((40, 6), (20.0, 6.0))
    x, _ = grid.positions
    inside = np.broadcast_to((x < 5) | (x >= 18), grid.shape)
    profile = gap_profile(grid, np.broadcast_to(x, grid.shape), inside, 3.0, 0.0)
    # Cells are 0.5 x 1, on average 0.75; a depth of 3/8 of it.
    np.testing.assert_allclose(profile.distance, np.arange(6) * 0.5 + 0.5 - 0.28125)
    assert (profile.cells == 12).all()
    np.testing.assert_allclose(profile.gap, 0.5 * (5 + 17.5))  # one row on each side of the gap between stripes
    # x = 5, 5.5, ... on the one side and 17.5, 17, ... on the other: two values, half of their difference apart.
    np.testing.assert_allclose(profile.spread, 0.5 * (17.5 - 5) - 0.5 * np.arange(6))


@pytest.mark.parametrize("spacing", [2.28, 2.433, 2.685, 2.915, 0.288])
def test_every_cell_up_to_the_farthest_is_counted_once_however_distances_round(spacing: float) -> None:
    grid = Grid.square(12, spacing)
    inside = np.zeros(grid.shape, dtype=bool)
    inside[6, 6] = True
    (dx, dy), places = grid.spacing, np.arange(12) - 6
    r = np.hypot(places[:, None] * dx, places * dy)
    depth = EDGE_DEPTH * (dx + dy) / 2
    for cell in np.unique(r[(r > 0) & (r < 5 * dx)]):
        # As far as a cell is: rounding may set it on either side of the last edge.
        farthest = float(cell - depth)
        profile = gap_profile(grid, r, inside, farthest, 0.0)
        assert profile.cells.sum() == np.count_nonzero((r > 0) & (r < farthest + depth))
        assert (np.diff(profile.distance) > 0).all()


def test_no_contact_and_full_contact_have_no_profile() -> None:
    grid = Grid.square(8)
    for inside in (np.zeros((8, 8), dtype=bool), np.ones((8, 8), dtype=bool)):
        assert gap_profile(grid, np.ones((8, 8)), inside, 3.0, 1.0).cells.size == 0
    with pytest.raises(ValueError, match="positive finite number, got 0"):
        gap_profile(grid, np.ones((8, 8)), inside, 0.0, 1.0)


def test_the_gap_outside_a_cylinder_rises_with_exponent_three_halves() -> None:
    grid = Grid((8192, 2), (8192.0, 2.0))
    wave = Westergaard(20.0, 8192.0, 0.02 * np.pi * 20 / 8192)
    heights = sine(grid, wave.amplitude, (1, 0))
    stiffness_q = HalfSpace("free").stiffness(grid)
    found = Solver(grid, stiffness_q).constrain(heights, None, Settings(1e-9), pressure=wave.mean_pressure)
    a, radius = wave.half_width, (8192 / (2 * np.pi)) ** 2 / wave.amplitude
    assert 300 < a < 400
    profile = gap_profile(grid, found.gap, found.gap <= 0, 100.0, 0.0)
    window = (profile.distance > 10) & (profile.distance < 0.1 * a)
    x, gap = profile.distance[window], profile.gap[window]
    exponent = np.polyfit(np.log(x), np.log(gap), 1)[0]
    # Half a cell in 10 at the near end, and the next term of the cylinder, 1 + 0.15 x/a: 0.02 each.
    assert exponent == pytest.approx(1.5, abs=0.03)
    ratio = gap / predicted_gap(x, a / radius, 2 * a)
    assert (np.abs(ratio - 1) < 0.08).all()
    assert ratio[-1] == pytest.approx(1, abs=0.03)
    assert profile.width(predicted_gap(30.0, a / radius, 2 * a)) == pytest.approx(30, abs=1)
    assert attraction_width(a / radius, 2 * a, float(predicted_gap(30.0, a / radius, 2 * a))) == pytest.approx(30)


@given(st.integers(0, 2**32), st.integers(0, 11), st.integers(0, 11))
def test_a_profile_does_not_depend_on_the_origin_or_the_axes(seed: int, i: int, j: int) -> None:
    rng, grid = np.random.default_rng(seed), Grid((12, 10), (12.0, 10.0))
    gap, inside = rng.random(grid.shape), rng.random(grid.shape) < 0.1
    found = gap_profile(grid, gap, inside, 5.0, 0.0)
    turned = gap_profile(Grid((10, 12), (10.0, 12.0)), gap.T, inside.T, 5.0, 0.0)
    moved = gap_profile(grid, np.roll(gap, (i, j), (0, 1)), np.roll(inside, (i, j), (0, 1)), 5.0, 0.0)
    for other in (turned, moved):
        np.testing.assert_array_equal(other.cells, found.cells)
        np.testing.assert_allclose(other.distance, found.distance)
        np.testing.assert_allclose(other.gap, found.gap)


# --- distributions -----------------------------------------------------------------------------------------


@given(st.integers(0, 2**32), st.integers(1, 300))
def test_distributions_integrate_to_areas_and_loads(seed: int, rows: int) -> None:
    grid = Grid((rows + 1, 3), (rows + 1.0, 3.0))
    gap = np.random.default_rng(seed).uniform(0.9, 1.6, grid.shape)
    gaps = gap_distribution(grid, gap, bins=rows)
    assert gaps.density.shape == (rows,)
    assert np.sum(gaps.density * np.diff(gaps.edges)) == pytest.approx(1)
    pressures = pressure_distribution(grid, WALL, gap, bins=2000)
    contact = totals_of(grid, WALL, gap)
    share = pressures.density * np.diff(pressures.edges)
    assert share.shape == (2000,)
    assert np.sum(share) == pytest.approx(contact.area_rep + contact.area_att)
    middle = (pressures.edges[1:] + pressures.edges[:-1]) / 2
    width = np.diff(pressures.edges).max()
    assert np.sum(share * middle) == pytest.approx(contact.load, abs=width)


def test_hertz_pressures_are_uniform_in_their_square() -> None:
    # p = p0 sqrt(1 - r²/a²): the area with a pressure below p is π a² (p/p0)², a density linear in p.
    grid = Grid.square(160)
    a, radius = 40.0, 300.0
    pressure = 4 * a**3 / (3 * radius) / grid.area
    stiffness_q = HalfSpace("free").stiffness(grid)
    heights = sphere(grid, radius)
    found = Solver(grid, stiffness_q).constrain(heights, None, Settings(1e-7), pressure=pressure)
    p = pressure_distribution(grid, HardWall(), found.gap, found.traction, bins=10)
    share = p.density * np.diff(p.edges) / np.sum(p.density * np.diff(p.edges))
    # Images at four radii take a few per cent of the load; the lowest bin holds the cut cells of the edge.
    np.testing.assert_allclose(share[2:-1], (2 * np.arange(10) + 1)[2:-1] / 100, rtol=0.15)


def test_a_flat_surface_has_one_gap_in_the_middle_of_its_bins() -> None:
    found = gap_distribution(Grid.square(8), np.full((8, 8), 2.0), bins=5)
    np.testing.assert_allclose(found.edges, [1.5, 1.7, 1.9, 2.1, 2.3, 2.5])
    np.testing.assert_allclose(found.density, [0, 0, 5, 0, 0], atol=1e-12)
    assert gap_distribution(Grid.square(8), np.full((8, 8), 2.0)).density.size == 80


@pytest.mark.parametrize("pressure", [0.2, -0.2])
def test_a_uniform_pressure_lies_in_the_middle_of_its_bins(pressure: float) -> None:
    traction = np.where(np.arange(64) < 16, pressure, 0.0).reshape(8, 8)
    found = pressure_distribution(Grid.square(8), HardWall(), np.zeros((8, 8)), traction, bins=5)
    np.testing.assert_allclose(found.edges, pressure + np.linspace(-0.1, 0.1, 6), atol=1e-15)
    np.testing.assert_allclose(found.density, [0, 0, 0.25 / 0.04, 0, 0], atol=1e-12)


@pytest.mark.parametrize("range_", [0.03, 0.3, 1.0, 5.0])
def test_between_two_distances_the_width_is_that_of_an_edge(range_: float) -> None:
    """Of a gap that rises as x^(3/2); NaN where it does not rise so far."""
    x = np.array([0.2, 0.9, 1.5, 2.2])
    profile = GapProfile(x, 0.5 * x**1.5, 0 * x, np.ones(4, dtype=int), 0.375)
    width = (range_ / 0.5) ** (2 / 3)
    assert profile.width(range_) == pytest.approx(width if width < 2.2 else np.nan, rel=1e-12, nan_ok=True)


# --- rough contacts ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("wall", [LennardJonesSpline(0.0), HardWall()], ids=["soft", "hard"])
def test_the_gap_outside_a_rough_contact(wall: LennardJonesSpline | HardWall) -> None:
    grid = Grid.square(512)
    heights = SelfAffine(0.8, 0.1, 32.0, 128.0).synthesise(grid, np.random.default_rng(1))
    slope = moments(grid, heights).rms_slope
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    state = solve(problem, "mean-gap", wall.zero_gap + 1.7 * heights.std(), Settings(1e-6))
    assert state.status.ok
    inside = contact_map(wall, state.gap) == REPULSIVE
    diameter = outline(grid, inside).diameter()
    profile = gap_profile(grid, state.gap, inside, 30.0, wall.zero_gap)
    # The soft wall yields at the edge, where a hard one would push hardest: its gap opens about 0.4 a0 earlier, and the
    # law of a hard wall holds from the centres of the perimeter cells, the paper's perimeter.
    x = profile.distance if isinstance(wall, HardWall) else profile.from_perimeter_cells
    near = (x >= 2) & (x <= diameter / 4)
    assert near.sum() >= 2
    ratio = profile.gap[near] / predicted_gap(x[near], slope, diameter)
    assert ((ratio > 0.8) & (ratio < 1.3)).all()
    assert np.all(np.diff(profile.gap) > 0)
