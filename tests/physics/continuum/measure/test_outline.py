"""Perimeter, chords, patches and areas of maps whose exact values are known, and of contacts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from continuum.measure.contact import REPULSIVE, contact_map, measure, totals_of
from continuum.measure.outline import Mask, outline, patches, size_distribution
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine, moments
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from continuum.theory.paper import PERIMETER_FACTOR, PERIMETER_FACTOR_PAPER
from tests.problems import distance


def disc(grid: Grid, radius: float, centre: tuple[float, float]) -> Mask:
    return distance(grid, centre) < radius


masks = st.integers(0, 2**32).flatmap(
    lambda seed: st.tuples(st.integers(2, 9), st.integers(2, 9), st.floats(0, 1)).map(
        lambda shape: np.random.default_rng(seed).random(shape[:2]) < shape[2]
    )
)


def grid_of(mask: Mask) -> Grid:
    return Grid(mask.shape, (float(mask.shape[0]), float(mask.shape[1])))


# --- exact values ------------------------------------------------------------------------------------------


def test_discs_converge_to_their_perimeter_and_chord() -> None:
    rng = np.random.default_rng(1)
    errors = []
    for radius in (8.0, 32.0, 128.0):
        grid = Grid.square(int(2 * radius) + 9)
        rims = [outline(grid, disc(grid, radius, tuple(rng.random(2) * grid.lengths[0]))) for _ in range(12)]
        exact = np.mean([rim.perimeter("exact") for rim in rims]) / (2 * np.pi * radius)
        edges = np.mean([rim.perimeter("edges") for rim in rims]) / (2 * np.pi * radius)
        chord = np.mean([rim.chord for rim in rims]) / (np.pi * radius / 2)  # πR²/(2πR/π)
        errors.append((abs(exact - 1), abs(edges - 1), abs(chord - 1)))
        paper = np.mean([rim.perimeter() for rim in rims])
        assert paper / np.mean([rim.perimeter("exact") for rim in rims]) == pytest.approx(1.1222 / 1.1107, rel=1e-4)
    # The outermost row of a disc lies up to one cell inside it: an error of the order of a0/R.
    for radius, error in zip((8.0, 32.0, 128.0), errors, strict=True):
        assert max(error) < 0.5 / radius


@pytest.mark.parametrize("steps", [(0, 1), (1, 0), (1, 1), (1, 2), (1, 3), (2, 3)])
def test_a_stripe_has_the_cells_of_a_line_at_its_angle(steps: tuple[int, int]) -> None:
    n, (a, b) = 240, steps
    grid = Grid.square(n)
    x, y = grid.positions
    # A band along (b, -a) that closes on itself; its two sides have the length n hypot(a, b) each.
    rim = outline(grid, ((a * x + b * y) / n + 0.01) % 1 < 0.5)
    length = 2 * n * np.hypot(a, b)
    cosine = max(a, b) / np.hypot(a, b)
    assert rim.perimeter_cells == pytest.approx(length * cosine, rel=1e-12)
    assert rim.edges == (2 * n * a, 2 * n * b)
    assert rim.cells == n * n / 2
    assert rim.chords == (n / 2 / a if a else np.inf, n / 2 / b if b else np.inf)


def test_the_factors_are_the_means_over_angles() -> None:
    theta = (np.arange(100_000) + 0.5) / 100_000 * np.pi / 4
    assert pytest.approx(np.mean(1 / np.cos(theta)), rel=1e-9) == PERIMETER_FACTOR_PAPER
    assert pytest.approx(1 / np.mean(np.cos(theta)), rel=1e-9) == PERIMETER_FACTOR


def test_annuli() -> None:
    grid = Grid.square(300)
    r = distance(grid, (3.3, 141.7))  # wraps over the seam
    rim = outline(grid, (r >= 60) & (r < 120))
    assert rim.perimeter("exact") == pytest.approx(2 * np.pi * 180, rel=5e-3)
    assert rim.perimeter("edges") == pytest.approx(2 * np.pi * 180, rel=5e-3)
    assert rim.chord == pytest.approx(np.pi * (120**2 - 60**2) / 360, rel=5e-3)


@pytest.mark.parametrize("shape", [(6, 8), (2, 2), (10, 4)])
def test_checkerboards(shape: tuple[int, int]) -> None:
    grid = Grid(shape, (2.0 * shape[0], 3.0 * shape[1]))
    rim = outline(grid, np.indices(shape).sum(0) % 2 == 0)
    assert rim.perimeter_cells == rim.cells == grid.size // 2
    assert rim.edges == (grid.size, grid.size)
    assert rim.chords == (2.0, 3.0)


def test_all_and_nothing() -> None:
    grid = Grid.square(7)
    full = outline(grid, np.ones((7, 7), dtype=bool))
    assert (full.area, full.perimeter(), full.chords) == (49, 0, (np.inf, np.inf))
    assert full.diameter() == full.chord == np.inf
    empty = outline(grid, np.zeros((7, 7), dtype=bool))
    assert (empty.area, empty.perimeter()) == (0, 0)
    assert np.isnan([empty.diameter(), empty.chord, *empty.chords]).all()


def test_cells_that_are_not_square() -> None:
    grid = Grid((400, 300), (200.0, 300.0))
    rim = outline(grid, disc(grid, 70.0, (11.0, 20.0)))
    assert rim.area == pytest.approx(np.pi * 70**2, rel=2e-3)
    assert rim.perimeter("exact") == pytest.approx(2 * np.pi * 70, rel=1e-2)
    assert rim.perimeter("edges") == pytest.approx(2 * np.pi * 70, rel=1e-2)
    np.testing.assert_allclose(rim.chords, np.pi * 70 / 2, rtol=1e-2)


def test_the_outline_of_a_rectangle_has_its_edges_in_the_units_of_the_cell() -> None:
    """Of cells with sides of 0.5 and 2: seven by four of them are 3.5 by 8."""
    mask = np.zeros((16, 12), dtype=bool)
    mask[3:10, 2:6] = True
    found = outline(Grid((16, 12), (8.0, 24.0)), mask)
    assert found.perimeter("edges") == pytest.approx(np.pi / 4 * 2 * (3.5 + 8.0), rel=1e-14)


def test_a_map_must_fit() -> None:
    with pytest.raises(ValueError, match=r"\(3, 4\) does not fit a grid of shape \(4, 4\)"):
        outline(Grid.square(4), np.zeros((3, 4), dtype=bool))


# --- invariances -------------------------------------------------------------------------------------------


@given(masks, st.integers(0, 8), st.integers(0, 8))
def test_shifts_and_turns_change_no_count(mask: Mask, i: int, j: int) -> None:
    rim = outline(grid_of(mask), mask)
    assert outline(grid_of(mask), np.roll(mask, (i, j), (0, 1))) == rim
    turned = outline(grid_of(mask.T), mask.T)
    assert (turned.perimeter_cells, turned.edges[::-1]) == (rim.perimeter_cells, rim.edges)


@given(masks)
def test_counts_bound_one_another(mask: Mask) -> None:
    grid = grid_of(mask)
    rim, outside = outline(grid, mask), outline(grid, ~mask)
    assert rim.edges == outside.edges
    assert rim.cells + outside.cells == grid.size
    # Each perimeter cell has one to four edges; each edge belongs to one perimeter cell.
    assert rim.perimeter_cells <= sum(rim.edges) <= 4 * rim.perimeter_cells
    assert rim.perimeter_cells <= rim.cells
    assert rim.perimeter("edges") * rim.chord == pytest.approx(np.pi * rim.area) or not sum(rim.edges)


# --- patches -----------------------------------------------------------------------------------------------


def test_patches_are_joined_over_the_seam() -> None:
    grid = Grid.square(60)
    mask = disc(grid, 10, (0, 0)) | disc(grid, 7, (30, 59)) | disc(grid, 4, (30, 30))
    found = patches(grid, mask)
    whole = [np.count_nonzero(disc(grid, *at)) for at in ((10, (0, 0)), (7, (30, 59)), (4, (30, 30)))]
    assert sorted(found.cells) == sorted(whole)
    for label, cells in enumerate(found.cells, start=1):
        assert np.count_nonzero(found.labels == label) == cells
    assert not found.labels[~mask].any()


def test_a_spiral_that_closes_over_the_seam_is_one_patch() -> None:
    # A line of slope 1/5 winds five times around the period before it meets itself.
    grid = Grid.square(50)
    x, y = grid.positions
    mask = (5 * x - y) % 50 < 6
    found = patches(grid, mask)
    assert found.cells.tolist() == [300]


def test_diagonal_neighbours_are_not_connected() -> None:
    found = patches(Grid.square(8), np.indices((8, 8)).sum(0) % 2 == 0)
    assert found.cells.tolist() == found.perimeter_cells.tolist() == [1] * 32
    assert patches(Grid.square(8), np.zeros((8, 8), dtype=bool)).cells.size == 0
    assert patches(Grid.square(8), np.ones((8, 8), dtype=bool)).perimeter_cells.tolist() == [0]


@given(masks, st.integers(0, 8), st.integers(0, 8))
def test_patches_add_up_and_do_not_depend_on_the_origin(mask: Mask, i: int, j: int) -> None:
    grid = grid_of(mask)
    found, rim = patches(grid, mask), outline(grid, mask)
    assert found.cells.sum() == rim.cells
    assert found.perimeter_cells.sum() == rim.perimeter_cells
    moved = patches(grid, np.roll(mask, (i, j), (0, 1)))
    turned = patches(grid_of(mask.T), mask.T)
    for other in (moved, turned):
        assert sorted(zip(other.cells, other.perimeter_cells, strict=True)) == sorted(
            zip(found.cells, found.perimeter_cells, strict=True)
        )
    # Neighbours belong to one patch, on both sides of every edge.
    for axis in (0, 1):
        both = mask & np.roll(mask, 1, axis)
        assert (found.labels == np.roll(found.labels, 1, axis))[both].all()


@given(st.lists(st.floats(1e-4, 1e4), max_size=50), st.integers(1, 10))
def test_a_size_distribution_counts_every_patch(areas: list[float], per_decade: int) -> None:
    size, density = size_distribution(np.array(areas), per_decade)
    step = 10 ** (0.5 / per_decade)
    assert (size * step > min(areas, default=0)).all()
    # The lowest edge is moved by one part in 1e9, so that the smallest patch lies inside.
    assert np.sum(density * size * (step - 1 / step)) == pytest.approx(len(areas), rel=1e-6)


# --- contacts ----------------------------------------------------------------------------------------------


@settings(max_examples=4)
@given(st.integers(0, 100))
def test_the_numbers_of_a_contact_belong_together(seed: int) -> None:
    grid = Grid.square(48)
    heights = SelfAffine(0.8, 0.1, 8.0, 24.0).synthesise(grid, np.random.default_rng(seed))
    wall = LennardJonesSpline(adhesion_length=0.005)
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    state = solve(problem, "mean-gap", 1 + 1.5 * heights.std(), Settings(1e-7))
    contact, repulsive = totals_of(grid, wall, state.gap), contact_map(wall, state.gap) == REPULSIVE
    slope = moments(grid, heights).rms_slope
    m = measure(grid, contact, repulsive, slope)
    assert m.area_rep > 0
    assert 1 / m.kappa == pytest.approx(1 / m.kappa_rep - 1 / m.kappa_att)
    assert m.load == pytest.approx(slope * m.area_rep / m.kappa)
    assert m.load == pytest.approx(m.pressure_rep * m.area_rep - m.pressure_att * m.area_att)
    assert m.diameter == pytest.approx(np.pi * m.area_rep * grid.area / m.perimeter)
    assert m.perimeter == pytest.approx(1.12220 * m.perimeter_cells, rel=1e-5)
    assert m.pressure_att < wall.largest_tension
    inside, outside = repulsive.sum(), (~repulsive).sum()
    with pytest.raises(ValueError, match=f"has {outside} cells, but A_rep/A0 = .* is {inside}$"):
        measure(grid, contact, ~repulsive, slope)


def test_without_contact_there_is_no_kappa() -> None:
    grid = Grid.square(8)
    wall = LennardJonesSpline(adhesion_length=0.005)
    m = measure(grid, totals_of(grid, wall, np.full((8, 8), 9.0)), np.zeros((8, 8), dtype=bool), 0.1)
    assert np.isnan([m.kappa, m.kappa_rep, m.kappa_att, m.diameter, m.chord, m.pressure_rep]).all()
    assert m.load == m.perimeter == 0
