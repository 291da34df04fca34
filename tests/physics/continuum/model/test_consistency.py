"""Energy, gradient and Hessian product belong to one another, for every wall law and every response."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer, TabulatedSubstrate
from continuum.model.walls import LennardJonesSpline
from tests import kinds
from tests.problems import hessian_product

GRIDS = [Grid((8, 8), (8.0, 8.0)), Grid((7, 9), (7.0, 11.0)), Grid((10, 5), (5.0, 5.0))]


WALLS = {
    **kinds.WALLS,
    "nonadhesive": LennardJonesSpline(0.0),
    "stiff": LennardJonesSpline(0.3, minimum_stiffness=20.0),
    "table": kinds.table(1.0, 1.0, LennardJonesSpline(0.4)),
}
RESPONSES = {
    **{name: lambda grid, one=one: one for name, one in kinds.SUBSTRATES.items() if not hasattr(one, "open_boundary")},
    "half-space, free": lambda grid: HalfSpace("free"),
    "compressible layer": lambda grid: Layer(5.0, 0.3, Layer(5.0, 0.3, "free").compressive_stiffness),
    "incompressible layer": lambda grid: Layer(5.0, 0.5, "clamped"),
    "table": lambda grid: TabulatedSubstrate(1.0 + grid.wavenumber**2, grid.lengths, "test"),
}
# Elastic energy and that of the wall are a sum: each law on one substrate and each substrate under one law are enough.
CASES = [*((wall, "half-space") for wall in WALLS), *(("lennard-jones-spline", name) for name in RESPONSES)]


@pytest.fixture(params=dict.fromkeys(CASES), ids=", ".join)
def problems(request: pytest.FixtureRequest, rng: np.random.Generator) -> list[ContactProblem]:
    """One on each grid."""
    wall, response = request.param
    return [
        ContactProblem(grid, WALLS[wall], 0.2 * rng.normal(size=grid.shape), RESPONSES[response](grid))
        for grid in GRIDS
    ]


def _random_states(problem: ContactProblem, rng: np.random.Generator) -> tuple[Real, Real]:
    """A displacement that puts points on every piece of the law, and a direction."""
    u, v = rng.normal(size=(2, *problem.grid.shape))
    if np.isinf(problem.mean_stiffness):
        u, v = u - u.mean(), v - v.mean()
    return 0.1 * u, v


def test_the_gradient_is_the_slope_of_the_energy(problems: list[ContactProblem], rng: np.random.Generator) -> None:
    for problem in problems:
        u, v = _random_states(problem, rng)
        expected = problem.grid.integrate(problem.gradient(u, 1.0) * v)
        assert abs(expected) > 1e-3  # a guard: the test is not 0 = 0
        e = 1e-5
        slope = (problem.energy(u + e * v, 1.0) - problem.energy(u - e * v, 1.0)) / (2 * e)
        # Central difference: e² times the third derivative (up to 1e4 in the stiff core), and 1e-16/e rounding.
        assert slope == pytest.approx(expected, rel=1e-5)


def test_the_hessian_is_the_slope_of_the_gradient(problems: list[ContactProblem], rng: np.random.Generator) -> None:
    for problem in problems:
        u, v = _random_states(problem, rng)
        expected = hessian_product(problem, u, 1.0, v)
        assert np.abs(expected).max() > 1e-2
        e = 1e-6
        slope = (problem.gradient(u + e * v, 1.0) - problem.gradient(u - e * v, 1.0)) / (2 * e)
        # The stiffness of the nonadhesive law jumps at a0: a point within e of it would differ, none is.
        np.testing.assert_allclose(slope, expected, atol=2e-5 * np.abs(expected).max())


def test_the_operator_is_its_dense_matrix(problems: list[ContactProblem], rng: np.random.Generator) -> None:
    """K from its definition: a sum of plane waves over all q, point by point."""
    for problem in problems:
        grid = problem.grid
        u, _ = _random_states(problem, rng)
        nx, ny = grid.shape
        x, y = (np.broadcast_to(a, grid.shape).ravel() for a in grid.positions)
        dense = np.zeros((grid.size, grid.size))
        for i in range(nx):
            for j in range(ny):
                # The half spectrum holds (m, n) for n >= 0; the rest follows from K(-q) = K(q).
                m, n = (i + nx // 2) % nx - nx // 2, (j + ny // 2) % ny - ny // 2
                k = problem.stiffness_q[(m if n >= 0 else -m) % nx, abs(n)]
                if not np.isfinite(k):
                    continue
                q = 2 * np.pi * np.array([m / grid.lengths[0], n / grid.lengths[1]])
                phase = q[0] * (x[:, None] - x) + q[1] * (y[:, None] - y)
                dense += k * np.cos(phase) / grid.size
        np.testing.assert_allclose(dense, dense.T, atol=1e-13)
        assert np.linalg.eigvalsh(dense).min() > -1e-12
        traction = problem.wall.evaluate(problem.gap(u, 1.0)).traction
        expected = dense @ u.ravel() + traction.ravel()
        if np.isinf(problem.mean_stiffness):
            expected -= traction.mean()
        np.testing.assert_allclose(problem.gradient(u, 1.0).ravel(), expected, atol=1e-11)
        elastic = 0.5 * u.ravel() @ dense @ u.ravel() * grid.cell_area
        energy = elastic + grid.integrate(problem.wall.evaluate(problem.gap(u, 1.0)).energy)
        assert problem.energy(u, 1.0) == pytest.approx(energy, rel=1e-11)


def test_a_clamped_mean_does_not_move() -> None:
    grid = Grid.square(8)
    problem = ContactProblem(grid, LennardJonesSpline(0.3), np.zeros(grid.shape), HalfSpace("clamped"))
    assert problem.energy(np.full(grid.shape, 0.1), 1.0) == np.inf


@pytest.mark.parametrize(
    ("heights", "fault"),
    [
        (np.zeros((8, 7)), "the shape of the grid"),
        (np.full((8, 8), np.nan), "64 of 64 are NaN"),
        (np.ma.masked_less(np.arange(64.0).reshape(8, 8), 3), "3 are masked"),
        (np.zeros((8, 8)) + 1j, "complex numbers"),
        (np.zeros((8, 8), dtype=bool), "booleans"),
        (np.full((8, 8), "1.0"), "text"),
        ([[1.0, 2.0], [3.0]], "rows of one length"),
    ],
)
def test_heights_that_are_none_are_refused(heights: Real, fault: str) -> None:
    with pytest.raises(ArgumentError, match=fault):
        ContactProblem(Grid.square(8), LennardJonesSpline(0.3), heights, HalfSpace("clamped"))
