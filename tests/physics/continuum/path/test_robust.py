"""Whatever the system and the start: an equilibrium, or a status that says why not; never a NaN or a false success."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import event, given
from hypothesis import strategies as st

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.surface import SelfAffine
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.solve.solution import Settings, Status
from tests import kinds

SHAPES = [(97, 64), (128, 128), (132, 160), (192, 132), (256, 192)]
"""The last three have coarser grids."""
LAWS: dict[str, Callable[[float], Wall]] = {
    **{name: lambda work, wall=wall: wall for name, wall in kinds.WALLS.items()},
    **kinds.OF_WORK,
    "9-3": lambda work: InversePowers((9, 3), adhesion_length=work),
    "12-6": lambda work: InversePowers((12, 6), adhesion_length=work),
    "exponential": lambda work: Exponential(work, 0.3, 5.0),
    "table": lambda work: kinds.table(1.0, 1.0, LennardJonesSpline(adhesion_length=work)),
    "repulsive": lambda work: LennardJonesSpline(0.0),
    "hard": lambda work: HardWall(),
}
"""Walls of each kind, where they can with a given work of adhesion."""


def solve_any(seed: int, law: str) -> Status:
    """One system drawn over the whole range that is promised, from a start that may be far off."""
    rng = np.random.default_rng(seed)
    shape = SHAPES[rng.integers(len(SHAPES))]
    grid = Grid(shape, (128.0, 128.0))
    # Waves shorter than two points are not on the grid.
    slope, cut = 10 ** rng.uniform(-2, np.log10(0.3)), max(2 ** rng.uniform(2, 6), 2.01 * max(grid.spacing))
    heights = SelfAffine(rng.uniform(0.3, 0.8), slope, cut, 128.0).synthesise(grid, rng)
    wall = LAWS[law](float(rng.choice([0.0005, 0.005, 0.05])))
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


@given(st.integers(0, 10**6), st.sampled_from(sorted(LAWS)))
def test_equilibrium_or_an_honest_status(seed: int, law: str) -> None:
    status = solve_any(seed, law)
    event(status.name)
    # Soft laws give way below their core: said.  Nothing else stands between any start and an equilibrium.
    assert status in (Status.CONVERGED, Status.BELOW_CORE)
