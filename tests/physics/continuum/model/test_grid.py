"""Transforms, weights and integrals on odd, even and non-square grids."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from continuum.inputs.arguments import ArgumentError
from continuum.model import fourier
from continuum.model.grid import Grid, GridTable

grids = st.builds(
    Grid,
    st.tuples(st.integers(2, 17), st.integers(2, 17)),
    st.tuples(st.floats(0.5, 50), st.floats(0.5, 50)),
)
# Sums of a few hundred products of order one: rounding stays below 1e-12.
ROUNDING = 1e-12


@given(grids, st.integers(0, 2**32 - 1))
def test_transforms_return_the_field_and_obey_parseval(grid: Grid, seed: int) -> None:
    a, b = np.random.default_rng(seed).normal(size=(2, *grid.shape))
    a_q, b_q = grid.forward(a), grid.forward(b)
    assert a_q.shape == grid.shape_q
    np.testing.assert_allclose(grid.inverse(a_q), a, atol=ROUNDING)
    assert grid.inner_q(a_q, b_q) == pytest.approx(grid.mean(a * b), abs=ROUNDING)
    assert a_q[0, 0].real == pytest.approx(grid.mean(a), abs=ROUNDING)


@given(grids)
def test_mode_weights_count_every_mode_once(grid: Grid) -> None:
    assert np.broadcast_to(grid.mode_weights, grid.shape_q).sum() == grid.size


@given(grids)
def test_integral_is_mean_times_area(grid: Grid) -> None:
    x, _ = grid.positions
    ones = np.ones(grid.shape)
    assert grid.integrate(ones) == pytest.approx(grid.area, rel=1e-13)
    assert grid.area == pytest.approx(grid.spacing[0] * grid.spacing[1] * ones.size, rel=1e-13)
    assert grid.mean(ones + x) == pytest.approx(
        1 + grid.lengths[0] * (grid.shape[0] - 1) / (2 * grid.shape[0]), rel=1e-12
    )


@pytest.mark.parametrize("shape", [(8, 8), (7, 9), (9, 6), (12, 5)])
def test_a_plane_wave_lies_on_its_wavevector(shape: tuple[int, int]) -> None:
    grid = Grid(shape, (10.0, 13.0))
    x, y = grid.positions
    for m, n in [(1, 0), (0, 1), (2, 1), (-2, 1)]:
        q = 2 * np.pi * np.array([m / 10.0, n / 13.0])
        spectrum = grid.forward(np.cos(q[0] * x + q[1] * y + 0.3))
        # The square of cos over the period averages to 1/2: both halves of the spectrum are counted.
        assert grid.inner_q(spectrum, spectrum) == pytest.approx(0.5, abs=ROUNDING)
        assert grid.inner_q(spectrum, grid.wavenumber**2 * spectrum) == pytest.approx(q @ q / 2, rel=1e-12)


@pytest.mark.parametrize(
    ("shape", "lengths"),
    [((0, 8), (1, 1)), ((8, 1), (1, 1)), ((8, 8), (0, 1)), ((8, 8), (1, np.nan)), ((8, 8), (-1, 1))],
)
def test_a_grid_that_is_none_is_refused(shape: tuple[int, int], lengths: tuple[float, float]) -> None:
    with pytest.raises(ArgumentError, match="allowed"):
        Grid(shape, lengths)


@pytest.mark.parametrize("n", [[8, 1], [1, 1]])
def test_a_line_of_an_input_lies_along_y(n: list[int]) -> None:
    with pytest.raises(ValidationError, match="from 2 to"):
        GridTable.model_validate({"n": n}, context={})
    assert GridTable.model_validate({"n": [1, 8]}, context={}).build().shape == (1, 8)


@pytest.mark.parametrize("shape", [(64, 64), (500, 300), (301, 257), (1024, 512)])
def test_blocks_mix_no_rows_or_columns(shape: tuple[int, int]) -> None:
    """Against the definition of another library."""
    values, grid = np.random.default_rng(1).normal(size=shape), Grid(shape, (1.0, 1.0))
    spectrum = grid.forward(values)
    np.testing.assert_allclose(spectrum, np.fft.rfft2(values) / values.size, atol=1e-15)
    np.testing.assert_allclose(grid.inverse(spectrum), values, atol=1e-14)


def test_a_spectrum_is_kept_unless_it_may_be_destroyed() -> None:
    grid = Grid((96, 70), (1.0, 1.0))
    values = np.random.default_rng(1).normal(size=grid.shape)
    spectrum = grid.forward(values)
    before = spectrum.copy()
    grid.inverse(spectrum)
    np.testing.assert_array_equal(spectrum, before)
    np.testing.assert_allclose(grid.inverse(spectrum, overwrite=True), values, atol=1e-14)


def test_a_grid_knows_its_narrow_and_its_wide_side() -> None:
    """A line has no side across it."""
    plane, line = Grid((4, 6), (8.0, 6.0)), Grid((1, 6), (8.0, 3.0))
    assert (plane.is_line, plane.narrowest, plane.widest_step, plane.shortest_period) == (False, 4, 2.0, 6.0)
    assert (line.is_line, line.narrowest, line.widest_step, line.shortest_period) == (True, 6, 0.5, 3.0)
    assert (plane.size, plane.area, plane.cell_area, plane.shape_q) == (24, 48.0, 2.0, (4, 4))


@pytest.mark.parametrize("shape", [(36, 70), (33, 47), (64, 32), (1, 128)])
def test_modes_of_a_coarser_grid_are_those_of_the_finer_one_with_the_same_wave(shape: tuple[int, int]) -> None:
    """All but its Nyquist modes, which the other grid has with either sign; into memory that held something else."""
    grid = Grid(shape, (3.0, 5.0))
    below, rng = grid.coarser, np.random.default_rng(1)
    assert below is not None
    one, other = (rng.normal(size=(2, *each.shape_q)) for each in (grid, below))
    fine, coarse = one[0] + 1j * one[1], other[0] + 1j * other[1]
    found, taken = np.full(grid.shape_q, 7j), np.full(below.shape_q, 7j)
    fourier.prolong(coarse, found)
    fourier.restrict(fine, taken)
    expected, kept = np.zeros(grid.shape_q, complex), np.zeros(below.shape_q, complex)
    (rows, columns), (m, n) = below.shape, below.mode_numbers
    for i, j in np.ndindex(*below.shape_q):
        if (2 * abs(m[i, 0]) < rows or grid.is_line) and 2 * n[0, j] < columns:
            expected[m[i, 0], j], kept[i, j] = coarse[i, j], fine[m[i, 0], j]
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(taken, kept)
    np.testing.assert_array_equal(fourier.cut(fine, below.shape_q)[kept != 0], kept[kept != 0])


@given(st.integers(2, 5000))
def test_the_next_coarser_grid_has_about_half_the_points_and_halves_again(n: int) -> None:
    """Half of a multiple of four; else the nearest multiple of eight, from eight points on."""
    coarser = Grid((1, n), (1.0, 3.0)).coarser
    if n < 9 and n % 4:
        assert coarser is None or coarser.shape == (1, 8)
        return
    assert coarser is not None
    assert coarser.lengths == (1.0, 3.0)
    assert abs(2 * coarser.shape[1] - n) <= (0 if n % 4 == 0 else 8)
    assert coarser.shape[1] % (2 if n % 4 == 0 else 8) == 0
