"""Whatever the system and the start: an equilibrium, or a status that says why not; never a NaN or a false success."""

from __future__ import annotations

import numpy as np
from hypothesis import event, given
from hypothesis import strategies as st

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.surface import SelfAffine
from continuum.model.tabulated_wall import TabulatedWall
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.solve.solution import Settings, Status

SHAPES = [(97, 64), (128, 128), (132, 160), (192, 132), (256, 192)]
"""The last three have coarser grids."""
LAWS = 7


def any_wall(kind: int, length: float) -> Wall:
    """A wall of each kind, with a work of adhesion near ``length``."""
    spline = LennardJonesSpline(adhesion_length=length)
    gap = np.linspace(0.7, 2.5, 200)
    return [
        LennardJonesSpline(0.0),
        spline,
        InversePowers((9, 3), adhesion_length=length),
        InversePowers((12, 6), adhesion_length=length),
        Exponential(length, 0.3, 5.0),
        TabulatedWall(tuple(gap), tuple(spline.evaluate(gap).traction)),
        HardWall(),
    ][kind]


def solve_any(seed: int, kind: int) -> Status:
    """One system drawn over the whole range that is promised, from a start that may be far off."""
    rng = np.random.default_rng(seed)
    shape = SHAPES[rng.integers(len(SHAPES))]
    grid = Grid(shape, (128.0, 128.0))
    # Waves shorter than two points are not on the grid.
    slope, cut = 10 ** rng.uniform(-2, np.log10(0.3)), max(2 ** rng.uniform(2, 6), 2.01 * max(grid.spacing))
    heights = SelfAffine(rng.uniform(0.3, 0.8), slope, cut, 128.0).synthesise(grid, rng)
    wall = any_wall(kind, float(rng.choice([0.0005, 0.005, 0.05])))
    response = [HalfSpace("clamped"), HalfSpace(0.01), Layer(30.0, 0.3, 0.05)][rng.integers(3)]
    problem = ContactProblem(grid, wall, heights, response)
    touch = wall.zero_gap - heights.min()
    separation = rng.uniform(0.3, 1.0) * touch
    overlapping = np.full(shape, wall.zero_gap - 1)
    noise = separation + heights + 0.3 * rng.normal(size=shape)
    start = [None, overlapping, noise][rng.integers(3)]
    tolerance = 1e-6 * slope
    state = solve(problem, "separation", separation, Settings(tolerance), start)
    assert np.isfinite(state.gap).all()
    assert np.isfinite([state.load, state.mean_gap, state.solution.residual]).all()
    if state.status.ok:
        # Computed here, not by the solver; twice the tolerance is for the rounding of g on the way (see `minimise`).
        displacement = problem.displacement(state.gap, separation)
        pressing = state.traction
        missing = grid.forward(pressing)
        held = np.isinf(problem.mean_stiffness)
        stiffness_q = problem.stiffness_q.copy()
        stiffness_q[0, 0] = 0.0 if held else problem.mean_stiffness
        missing += stiffness_q * grid.forward(displacement)
        missing[0, 0] = 0.0 if held else missing[0, 0]
        assert np.sqrt(grid.inner_q(missing, missing)) < 2.1 * tolerance
        assert state.gap.min() >= wall.core
    return state.status


@given(st.integers(0, 10**6), st.integers(0, LAWS - 1))
def test_equilibrium_or_an_honest_status(seed: int, kind: int) -> None:
    status = solve_any(seed, kind)
    event(status.name)
    # Soft laws give way below their core: said.  Nothing else stands between any start and an equilibrium.
    assert status in (Status.CONVERGED, Status.BELOW_CORE)
