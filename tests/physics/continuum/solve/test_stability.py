"""Minimum or saddle: against the exact spectrum of flat surfaces, and dense eigenvalues of rough ones."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
import scipy.linalg

import continuum as c
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.substrates.non_periodic import OpenBoundary
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.solve.non_periodic import NonPeriodicSolver
from continuum.solve.solution import Settings, Status
from continuum.solve.stability import stability
from tests.kinds import covering
from tests.problems import Rough, hessian_product

WALL = LennardJonesSpline(0.3)


def flat(grid: Grid, wall: Wall = WALL) -> ContactProblem:
    return ContactProblem(grid, wall, np.zeros(grid.shape), HalfSpace())


def test_flat_surfaces_have_the_spectrum_of_the_substrate() -> None:
    """K_q + φ'' for each wave, and K_0 + φ'' where the mean may move."""
    for mean in [np.inf, 0.0, 0.02]:
        for gap in [1.02, 1.2, 3.0]:
            for shape in [(64, 64), (33, 20)]:
                problem = flat(Grid(shape, (float(shape[0]), float(shape[1]))))
                softening = float(WALL.evaluate(np.array(gap)).stiffness)
                lowest = min(np.pi / max(shape), mean) + softening
                found = stability(problem.grid, problem.stiffness_q, np.full(shape, softening), mean)
                assert found.eigenvalue == pytest.approx(lowest, abs=1e-6)
                assert abs(found.eigenvalue - lowest) <= found.error + 1e-12
                assert found.is_saddle == (lowest < 0)
                assert np.mean(found.mode**2) == pytest.approx(1)


@pytest.mark.parametrize("adhesion_length", [0.005, 0.05])
def test_rough_surfaces_against_dense_eigenvalues(adhesion_length: float) -> None:
    problem = Rough(24, adhesion_length, lambda_s=6.0).problem()
    gap = solve(problem, "mean-gap", 1.3, Settings(1e-8)).gap
    size, displacement = problem.grid.size, problem.displacement(gap, 0.0)
    products = [hessian_product(problem, displacement, 0.0, v.reshape(gap.shape)).ravel() for v in np.eye(size)]
    dense = np.stack(products, axis=1)
    mean = np.full((size, size), 1 / size)
    dense = dense - dense @ mean + 10 * mean  # the mean is held: neither does it move, nor is there a force on it
    exact = scipy.linalg.eigvalsh((dense + dense.T) / 2, subset_by_index=[0, 0])[0]
    found = stability(problem.grid, problem.stiffness_q, problem.wall.evaluate(gap).stiffness)
    assert exact - 1e-12 <= found.eigenvalue <= exact + found.error
    # The error is what the mode lacks of an eigenvector, and no more: the mean is no part of it.
    image = dense @ found.mode.ravel() - found.eigenvalue * found.mode.ravel()
    assert np.sqrt(np.mean((image - image.mean()) ** 2)) == pytest.approx(found.error, rel=1e-6)


@pytest.mark.parametrize(("shape", "mean"), covering([(6, 6), (7, 5), (2, 9)], [None, 0.0]))
def test_a_part_of_a_half_space_against_dense_eigenvalues(shape: tuple[int, int], mean: float | None) -> None:
    """Its stiffness is the inverse of its influence; under a given load a rigid shift costs nothing."""
    boundary = OpenBoundary(Grid(shape, (1.5 * shape[0], float(shape[1]))))
    unit = np.eye(boundary.window.size)
    influence = -np.stack([boundary.inside(boundary.displacement(e.reshape(shape))).ravel() for e in unit])
    stiffness = np.linalg.inv(influence)
    if mean == 0:
        row = stiffness.sum(axis=0)
        stiffness -= np.outer(row, row) / row.sum()
    for gap in (np.full(shape, 1.2), np.full(shape, 3.0), np.random.default_rng(0).uniform(0.95, 1.4, shape)):
        hessian = stiffness + np.diag(WALL.evaluate(gap).stiffness.ravel())
        exact = scipy.linalg.eigvalsh((hessian + hessian.T) / 2, subset_by_index=[0, 0])[0]
        found = NonPeriodicSolver(boundary).stability(WALL.law, gap, mean)
        assert exact - 1e-10 <= found.eigenvalue <= exact + found.error + 1e-10
        assert found.error <= 2e-3 * found.scale
        image = hessian @ found.mode.ravel() - found.eigenvalue * found.mode.ravel()
        assert np.sqrt(np.mean(image**2)) == pytest.approx(found.error, rel=1e-3, abs=1e-10)


@pytest.mark.parametrize("control", ["mean-gap", "separation"])
def test_a_saddle_that_symmetry_keeps_is_no_solution_where_it_is_asked_for(
    control: Literal["mean-gap", "separation"],
) -> None:
    """A flat surface at a gap where waves longer than π E*/s snap in: nothing perturbs it."""
    problem = flat(Grid.square(64))
    assert solve(problem, control, 1.2, Settings(1e-8)).status is Status.CONVERGED
    state = solve(problem, control, 1.2, Settings(1e-8, stability=True))
    assert state.status is Status.SADDLE
    softening = float(WALL.evaluate(np.array(1.2)).stiffness)
    assert state.solution.lowest_eigenvalue == pytest.approx(np.pi / 64 + softening, abs=1e-6)
    far = solve(problem, control, 2.0, Settings(1e-8, stability=True))
    assert far.status is Status.CONVERGED
    assert far.solution.lowest_eigenvalue == pytest.approx(np.pi / 64, abs=1e-6)


def test_a_contact_can_be_asked() -> None:
    heights = Rough(24, lambda_s=6.0).heights()
    state = c.Contact(heights, WALL).press(mean_gap=1.3)
    assert not state.stability().is_saddle
    with pytest.raises(TypeError, match="convex"):
        c.Contact(heights, c.HardWall()).press(mean_gap=1.3).stability()
