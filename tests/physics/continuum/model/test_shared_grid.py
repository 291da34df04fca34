"""A grid shared by processes: surfaces, spectra and sums are those of the whole grid."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from continuum.measure.contact import totals_of
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.shared_grid import SharedGrid
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.path.coarser import coarser_problem
from continuum.path.estimates import pressure_of_full_contact, usual_pressure
from continuum.solve.backend import near_kernel, node_stiffness

POINTS, LENGTHS, PARTS = (48, 40), (24.0, 40.0), 4


class Piped:
    """A process whose parent hands arrays over when all processes have sent theirs."""

    def __init__(self, rank: int, size: int, hub: Any) -> None:
        self.rank, self.size, self.parts, self._hub = rank, size, PARTS, hub

    def gather(self, values: NDArray[Any]) -> NDArray[Any]:
        self._hub.send((False, values))
        found: NDArray[Any] = self._hub.recv()
        return found

    def exchange(self, blocks: NDArray[Any]) -> NDArray[Any]:
        return self.gather(blocks)[:, self.rank]


def _called(function: Callable[[SharedGrid], Any], rank: int, size: int, hub: Any) -> None:
    hub.send((True, function(SharedGrid(POINTS, LENGTHS, company=Piped(rank, size, hub)))))


def in_each(size: int, function: Callable[[SharedGrid], Any]) -> list[Any]:
    """What a function of the grid gives in each of the processes that share it."""
    context = multiprocessing.get_context("fork")
    pipes = [context.Pipe() for _ in range(size)]
    for rank, (_, hub) in enumerate(pipes):
        context.Process(target=_called, args=(function, rank, size, hub), daemon=True).start()
        hub.close()
    while True:
        done, sent = zip(*(mine.recv() for mine, _ in pipes), strict=True)
        if all(done):
            return list(sent)
        assert not any(done), "one has ended where others wait for it"
        for mine, _ in pipes:
            mine.send(np.stack(sent))


def heights_of(grid: Grid) -> Any:
    return SelfAffine(0.8, 0.1, 5.0, 12.0).synthesise(grid, np.random.default_rng(3))


@pytest.mark.parametrize("size", [1, 2, 4])
def test_surfaces_and_spectra_are_those_of_one_process(size: int) -> None:
    whole = Grid(POINTS, LENGTHS)
    heights, spectrum = heights_of(whole), whole.forward(heights_of(whole))

    def both(grid: SharedGrid) -> Any:
        own = heights_of(grid)
        return own, grid.forward(own), grid.modes_of(spectrum), grid.inverse(grid.forward(own))

    found = in_each(size, both)
    np.testing.assert_allclose(np.concatenate([own for own, *_ in found]), heights, rtol=0, atol=4e-16)
    for own, own_q, wanted, back in found:
        # The last column is repeated where parts have more.
        np.testing.assert_allclose(own_q[..., :-1], wanted[..., :-1], rtol=0, atol=1e-16)
        np.testing.assert_allclose(back, own, rtol=0, atol=1e-15)


def test_moments_totals_and_what_searches_look_at_are_those_of_one_process() -> None:
    wall = LennardJonesSpline(adhesion_length=0.05)

    def seen(grid: Grid) -> list[Any]:
        problem = ContactProblem(grid, wall, heights_of(grid), Layer(5.0, 0.3, "clamped"))
        gap = 1.0 + problem.heights
        totals, coarse = totals_of(grid, wall, gap), coarser_problem(problem, 4, roughly=True)
        assert coarse is not None
        kernel, (nodes, K) = near_kernel(grid, problem.stiffness_q), node_stiffness(grid, problem.stiffness_q)
        back = coarse.grid.prolonged(coarse.grid.forward(coarse.heights), grid)
        mean = problem.mean_stiffness
        return [
            totals.area_rep, totals.area_att, *vars(totals).values(), *problem.moments, problem.traction_scale, mean,
            coarse.moments.rms_slope, grid.deviation(grid.inverse(back)), pressure_of_full_contact(problem),
            usual_pressure(problem), *kernel.ravel(), nodes.total_q(nodes.mode_weights * K), grid.mean(gap),
            grid.least(gap), *grid.sample(gap, 7).ravel(), grid.greatest_wave(problem.stiffness_q, along_y=True),
        ]  # fmt: skip

    one, *others = seen(Grid(POINTS, LENGTHS)), *in_each(2, seen), *in_each(4, seen), *in_each(1, seen)
    for other in others:
        assert other[:2] == one[:2], "counts"
        assert other == others[0], "sums over slabs do not depend on the number of processes"
        np.testing.assert_allclose(other, one, rtol=1e-12)
    assert one[0] > 0
    assert one[1] > 0


def test_the_mean_mode_is_in_one_process() -> None:
    assert in_each(2, lambda grid: grid.mean_mode(HalfSpace("free").stiffness(grid)).size) == [1, 0]
