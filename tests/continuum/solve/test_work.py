"""What a solve costs: pairs of transforms and evaluations of the line search, which no change of a number may raise.

A wrong number in a preconditioner, a line search or the work on coarse grids leaves the equilibrium as it is, but is
paid for in iterations.
"""

from __future__ import annotations

import numpy as np
import pytest

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import HardWall, LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.solve.solution import Settings

GRID = Grid((256, 320), (256.0, 320.0))
HEIGHTS = SelfAffine(0.8, 0.1, 8, 64).synthesise(GRID, np.random.default_rng(5))
SOLVES: dict[str, tuple[Wall, str, float, float]] = {
    "adhesion at a separation": (LennardJonesSpline(adhesion_length=0.005), "separation", 1.3, 72.8),
    "adhesion at a mean gap": (LennardJonesSpline(adhesion_length=0.005), "mean-gap", 1.9, 79.4),
    "soft repulsion": (LennardJonesSpline(0.0), "separation", 1.0, 49.2),
    "a hard wall under a load": (HardWall(), "mean-pressure", 0.01, 39.2),
    "a hard wall at a separation": (HardWall(), "separation", 0.5, 44.0),
}
"""Wall, control, its value, and pairs of transforms that the solve takes, on two grids."""


@pytest.mark.parametrize("name", SOLVES)
def test_a_solve_takes_no_more_than_it_did(name: str) -> None:
    wall, control, target, pairs = SOLVES[name]
    substrate = HalfSpace("free" if control == "mean-pressure" else "clamped")
    found = solve(ContactProblem(GRID, wall, HEIGHTS, substrate), control, target, Settings(1e-8)).solution.require()
    # A tenth of room, as rounding decides when a line search ends.
    assert found.fft_pairs < 1.1 * pairs
    fine, coarse = found.work
    assert (fine.shape, coarse.shape) == (GRID.shape, (128, 160))
    assert found.fft_pairs == pytest.approx(fine.fft_pairs + coarse.fft_pairs / 4)
    assert min(fine.sweeps, coarse.sweeps, fine.fft_seconds, coarse.fft_seconds) >= 0
    assert fine.sweeps + coarse.sweeps > 0
