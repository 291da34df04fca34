"""What a solve costs: pairs of transforms and evaluations of the line search, which no change of a number may raise.

A wrong number in a preconditioner, a line search or the work on coarse grids leaves the equilibrium as it is, but is
paid for in iterations.
"""

from __future__ import annotations

from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import HardWall, LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.solve.compiled import contact_fields, passes
from continuum.solve.compiled.bound_grid import CompiledBoundGrid
from continuum.solve.smooth import _stalls
from continuum.solve.solution import FinerTolerance, Goal, Iteration, Settings, Work

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


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_time_in_transforms_is_that_of_each_half_in_each_block_over_the_threads(
    threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock that goes on by a second at each look, in two blocks."""
    clock = count()
    for module in (passes, contact_fields):
        monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: float(next(clock))))
    monkeypatch.setattr(passes, "block_edges", lambda length, points: [0, length // 3, length])
    monkeypatch.setattr(passes.Passes, "_each", lambda grid, task, blocks: [task(b) for b in range(blocks)])
    grid = Grid((24, 40), (24.0, 40.0))
    bound = CompiledBoundGrid(grid, HalfSpace("free").stiffness(grid), threads, 16)
    bound.threads = threads
    bound.set_problem(np.zeros(grid.shape), None, lift=0.0, sink=0.0, mean_stiffness=0.0, most=np.inf)
    bound.p[:, :40] = 1.0
    bound.select(0.0)
    # A pass over rows takes two looks in each block, one over columns four, also where it has one transform only.
    for word, pairs, seconds in (
        (bound.displace, 1.0, 8.0),
        (lambda: bound.misses(0.0), 0.5, 6.0),
        (lambda: bound.precondition(0.0), bound.far.size / grid.size, 0.0),  # on the nodes alone
        (bound.displace, 1.0, 8.0),
    ):
        bound.forget_work()
        word()
        assert bound.work == Work(grid.shape, pairs, 0, seconds / min(threads, 2))
    # Of tiles what their coarse grid takes is added, a transform of it by its size.
    bound._split = SimpleNamespace(far=SimpleNamespace(transforms=6, size=grid.size / 16, fft_seconds=3.0))
    assert bound.work == Work(grid.shape, 1 + 3 / 16, 0, 8 / min(threads, 2) + 3.0)
    assert Work((2, 3), 0.5, 2, 1.5).plus(Work((2, 3), 0.25, 3, 1.0)) == Work((2, 3), 0.75, 5, 2.5)


def test_a_goal_becomes_finer_where_a_gap_is_worth_it_and_looser_where_that_is_left() -> None:
    seen = list[float]()

    def look() -> np.ndarray:
        seen.append(1.0)
        return np.ones(1)

    plain = Goal(1e-3)
    assert [plain.reached(residual, look) for residual in (2e-3, 1e-3, np.nan)] == [False, True, False]
    assert (plain.last, plain.hopeless(look), seen) == (1e-3, False, [])
    goal = Goal(1e-3, FinerTolerance(1e-6, lambda gap: len(seen) > 1, lambda gap: len(seen) > 3))
    assert goal.reached(1e-3, look)  # not worth it
    assert (goal.last, goal.bound) == (1e-6, 1e-3)
    assert not goal.reached(1e-3, look)
    assert (goal.bound, len(seen)) == (1e-6, 2)
    assert not goal.reached(1e-5, look)
    assert not goal.hopeless(look)  # once it was worth it
    assert goal.reached(1e-6, look)
    assert not goal.reached(2e-3, look)  # another state
    assert (goal.bound, len(seen)) == (1e-3, 2)
    assert not goal.hopeless(look)
    assert goal.hopeless(look)
    assert goal.reached(1e-7, look)  # fine enough without a look
    assert len(seen) == 4


@pytest.mark.parametrize(("falls", "stalls"), [(0.9, True), (0.82, True), (0.81, False), (0.5, False), (np.nan, False)])
def test_a_solve_stalls_where_its_residual_falls_by_less_than_a_fifth_in_eight_iterations(
    falls: float, stalls: bool
) -> None:
    """Of the last ones alone: what it did before does not count, and so many are needed."""
    history = [Iteration(1e9, 0.0, 1.0), *(Iteration(falls**i, 0.0, 1.0) for i in range(9))]
    assert _stalls(history, 8) is stalls
    assert not _stalls(history, 7)
