"""Normal stiffness by one linear solve: against flat surfaces, dense algebra, and how the load changes."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from continuum.solve.tangent import solve_hessian, tangent_stiffness
from tests.problems import Rough, hessian_product

SETTINGS = Settings(1e-10)


def test_a_flat_surface_is_as_stiff_as_the_wall() -> None:
    for mean in ["clamped", "free", 0.02]:
        for gap in [0.9, 1.02, 1.1, 3.0]:
            grid, wall = Grid((15, 20), (15.0, 20.0)), LennardJonesSpline(0.3)
            assert wall.law is not None
            found = tangent_stiffness(grid, HalfSpace(mean=mean).stiffness(grid), wall.law, np.full(grid.shape, gap))
            assert found == pytest.approx(float(wall.evaluate(np.array(gap)).stiffness), abs=1e-12)


@pytest.mark.parametrize("adhesion_length", [0.0, 0.005, 0.05])
def test_rough_surfaces_against_dense_algebra_and_against_loads_beside(adhesion_length: float) -> None:
    problem = Rough(24, adhesion_length, lambda_s=6.0).problem()
    at, beside = 1.3, 1e-4
    gap = solve(problem, "mean-gap", at, SETTINGS).gap
    assert problem.wall.law is not None
    found = tangent_stiffness(problem.grid, problem.stiffness_q, problem.wall.law, gap)
    # K v + φ'' v is the same everywhere for a v of mean one.
    displacement = problem.displacement(gap, 0.0)
    products = [hessian_product(problem, displacement, 0.0, v.reshape(gap.shape)).ravel() for v in np.eye(gap.size)]
    hessian = np.stack(products, axis=1)
    softening = problem.wall.evaluate(gap).stiffness.ravel()
    hessian[:] = hessian - np.diag(softening)  # without the mean, whatever that of the substrate is
    hessian -= hessian.mean(axis=0, keepdims=True)
    bordered = np.block(
        [
            [hessian + np.diag(softening), -np.ones((gap.size, 1))],
            [np.full((1, gap.size), 1 / gap.size), np.zeros((1, 1))],
        ]
    )
    exact = np.linalg.solve(bordered, np.append(np.zeros(gap.size), 1.0))[-1]
    assert found == pytest.approx(exact, rel=1e-5, abs=1e-9)
    low, high = (solve(problem, "mean-gap", at + step, SETTINGS, start=gap).load for step in (-beside, beside))
    assert found == pytest.approx((low - high) / (2 * beside), rel=2e-3)


@pytest.mark.parametrize("shape", [(15, 16), (1, 21)])
def test_a_solve_gives_back_the_field_from_which_the_right_side_was_made(shape: tuple[int, int]) -> None:
    grid, rng = Grid(shape, (15.0, 20.0)), np.random.default_rng(3)
    stiffness = np.where(rng.random(shape) < 0.2, 3.0, -0.01 * rng.random(shape))
    field = rng.standard_normal(shape)
    field -= field.mean()
    K = HalfSpace(mean=0.02).stiffness(grid)
    right = grid.inverse(K * grid.forward(field)) + stiffness * field
    found = solve_hessian(grid, K, stiffness, right + 7.0, accuracy=1e-12)
    np.testing.assert_allclose(found, field, atol=1e-9)  # the residual over the softest mode, K = 0.16
    assert np.isnan(solve_hessian(grid, K, stiffness, np.full(shape, np.nan))).all()
