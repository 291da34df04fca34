"""The preconditioner under a bound: what it is, and that it is symmetric and positive."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.substrates.substrate import Substrate
from continuum.solve.arrays.bound_grid import ArrayBoundGrid
from continuum.solve.arrays.library import NumPy
from continuum.solve.compiled.bound_grid import CompiledBoundGrid as BoundGrid
from continuum.solve.hard import _Dual

SHAPES = [(64, 64), (33, 47), (200, 72), (1, 130), (2, 9), (256, 300)]


def stiffened(
    grid: Grid, stiffness_q: Real, contact: Real, values: Real | None, threads: int = 1
) -> tuple[Real, float]:
    """M of values on the contact, or of ones, and its sum; over arrays that held something else before."""
    bound = BoundGrid(grid, stiffness_q, threads, 128)
    bound.set_problem(np.zeros(grid.shape), None, lift=0.0, sink=0.0, mean_stiffness=0.0, most=np.inf)
    bound.s[...], bound.m[...] = 7.0, 7.0
    n = grid.shape[1]
    bound.z[:, :n] = 1.0 if values is None else values
    bound.p[:, :n] = contact
    bound.select(0.0)
    total = bound._stiffen(bound.s, *((None, 1.0) if values is None else (bound.z, 0.25)))
    return bound.s[:, :n].copy(), total


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("ones", [False, True])
def test_it_is_what_numpy_finds(shape: tuple[int, int], ones: bool) -> None:
    grid, rng = Grid(shape, (float(shape[0]), 1.5 * shape[1])), np.random.default_rng(1)
    K = HalfSpace("free").stiffness(grid)
    contact = np.zeros(shape)
    contact[: shape[0] // 2 + 1] = rng.random((shape[0] // 2 + 1, shape[1])) < 0.1
    contact[0, -1] = 1.0
    values = rng.normal(size=shape) ** 2  # a positive gap is in contact only where it is pressed
    found, total = stiffened(grid, K, contact, None if ones else values)
    plain = ArrayBoundGrid(NumPy(), grid, K, 128)
    plain.mask = contact > 0
    expected = plain._stiffened(contact * (1.0 if ones else values + 0.25))
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert total == pytest.approx(expected.sum(), rel=1e-9, abs=1e-9)
    np.testing.assert_array_equal(found, stiffened(grid, K, contact, None if ones else values, threads=2)[0])


@pytest.mark.parametrize("substrate", [HalfSpace("free"), Layer(3.0, 0.3, "free")])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.98, 1.0])
def test_it_is_symmetric_and_positive_between_the_points_of_any_contact(substrate: Substrate, share: float) -> None:
    grid, rng = Grid((18, 20), (18.0, 20.0)), np.random.default_rng(2)
    plain = ArrayBoundGrid(NumPy(), grid, substrate.stiffness(grid), 128)
    plain.mask = rng.random(grid.shape) < share
    plain.mask[3, 4] = True
    points = np.flatnonzero(plain.mask)
    matrix = np.array(
        [plain._stiffened(each.reshape(grid.shape)).ravel()[points] for each in np.eye(grid.size)[points]]
    )
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12)
    assert np.linalg.eigvalsh(matrix).min() > 0.5 * plain.K.ravel()[1:].min() * (points.size / grid.size)


def test_it_is_nearly_the_inverse_of_the_compliance_between_these_points() -> None:
    """A disc of 9 points' radius: measured 1.59 between the eigenvalues, and 1.96 where K is cut off at its edge."""
    grid = Grid.square(64)
    plain = ArrayBoundGrid(NumPy(), grid, HalfSpace("free").stiffness(grid), 128)
    x = np.arange(64) - 31.5
    plain.mask = np.hypot(x[:, None], x[None, :]) < 9
    points = np.flatnonzero(plain.mask)
    units = np.eye(grid.size)[points].reshape(-1, *grid.shape)
    plain.K[0, 0] = plain.K.ravel()[1:].min()

    def condition(of) -> float:
        matrix = np.array([of(each).ravel()[points] for each in units])
        compliance = np.array([plain.inverse(plain.forward(each) / plain.K).ravel()[points] for each in units])
        found = np.sort(np.linalg.eigvals(matrix @ compliance).real)
        return float(found[-1] / found[0])

    found = condition(plain._stiffened)
    cut = condition(lambda each: plain.inverse(plain.K * plain.forward(each)))
    assert found < 1.65 < 1.9 < cut


@pytest.mark.parametrize("mean", [0.0, 0.05, 3.0, np.inf])
def test_the_mean_mode_enters_as_sherman_and_morrison_say(mean: float) -> None:
    """The inverse of M^-1 + 1 1ᵀ/(N K_0), on the contact; under a given load without the mean, and M where it is held.

    The level is that at which the contact closes on average, but for what the mean mode gives way.
    """
    grid, rng = Grid((7, 10), (7.0, 15.0)), np.random.default_rng(3)
    plain = ArrayBoundGrid(NumPy(), grid, HalfSpace("free").stiffness(grid), 128)
    plain.set_problem(np.zeros(grid.shape), None, lift=0.0, sink=0.0, mean_stiffness=mean, most=np.inf)
    plain.p = 1.0 * (rng.random(grid.shape) < 0.4)
    plain.z = np.where(plain.p > 0, rng.normal(size=grid.shape), 9.0)
    plain.clear()
    dual = _Dual(plain, 0.0, mean)
    mz = dual._find_contact()
    dual._precondition(mz)
    on = plain.p > 0
    np.testing.assert_array_equal(plain.mask, on)
    units = np.eye(grid.size)[on.ravel()].reshape(-1, *grid.shape)
    M = np.array([plain._stiffened(each)[on] for each in units])
    z, m = plain.z[on], M.sum(axis=1)
    if np.isinf(mean):
        np.testing.assert_allclose(plain.s[on], M @ z, atol=1e-12)
        assert dual._level() == 0.0
        return
    whole = mean * grid.size + m.sum()
    np.testing.assert_allclose(plain.s[on], M @ z - m * (m @ z) / whole, atol=1e-12)
    if mean > 0:
        exact = np.linalg.solve(np.linalg.inv(M) + 1 / (mean * grid.size), z)
        np.testing.assert_allclose(plain.s[on], exact, atol=1e-11)
    level = dual._level()
    assert m @ (z + level) == pytest.approx(-mean * grid.size * level, abs=1e-12)
