"""Small boxes in which a solve goes down where it stalls: their energy, their places, and what they save."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import PathState
from continuum.solve import contact
from continuum.solve.boxes import LEAST, Boxes
from continuum.solve.compiled.corrections import TiledSmoothGrid as SmoothGrid
from continuum.solve.solution import FinerTolerance, Settings, Solution, Status, Work
from tests.problems import Rough

RANGE, WORK = 0.08, 0.2 * 0.08**2
"""Of an attraction so short and strong that rims snap from point to point."""


@pytest.fixture(autouse=True)
def without_the_contacts_own_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which such a wall is solved by, and which stalls less: boxes are for what it leaves."""
    monkeypatch.setattr(contact, "STIFFEST", np.inf)


def pinned(seed: int) -> ContactProblem:
    """A rough contact whose rims are held by the grid, nearly."""
    grid = Grid.square(256)
    heights = c.SelfAffine(0.8, 0.1, 8.0, 128.0).synthesise(grid, np.random.default_rng(seed))
    wall = c.attraction_on_core("spline", WORK, RANGE, 5.0)
    return ContactProblem(grid, wall, heights * (0.5 / heights.std()), HalfSpace())


def solved(problem: ContactProblem, boxes: bool) -> PathState:
    settings = Settings(3e-6)
    solver = solver_of(problem, settings)
    if not boxes:
        solver._smooth.boxes = None
    at = problem.mean_height + problem.wall.zero_gap - float(np.quantile(problem.heights, 0.0125))
    return equilibrium(problem, "mean-gap", at, settings, solver=solver)


def law(problem: ContactProblem) -> Law:
    """That of its wall."""
    assert problem.wall.law is not None
    return problem.wall.law


def made(grid: Grid) -> Boxes:
    boxes = Boxes.on(grid, grid.wavenumber / 2)
    assert boxes is not None
    return boxes


def bump(boxes: Boxes) -> Real:
    """A displacement within the window, a0 high."""
    x, y = boxes.grid.positions
    middle = [length / 2 for length in boxes.grid.lengths]
    found: Real = np.exp(-((x - middle[0]) ** 2 + (y - middle[1] + 3.0) ** 2) / 2 / 4.0**2) * boxes.window
    return found


@pytest.mark.parametrize("seed", [1, *(pytest.param(one, marks=pytest.mark.long) for one in (2, 3))])
def test_a_solve_that_stalls_takes_half_the_iterations_to_the_same_contact(seed: int) -> None:
    problem = pinned(seed)
    found = {boxes: solved(problem, boxes) for boxes in (True, False)}
    for state in found.values():
        assert state.status.ok
        displacement = problem.displacement(state.gap, state.separation)
        gradient = problem.gradient(displacement, state.separation)
        assert np.sqrt(np.mean((gradient - gradient.mean()) ** 2)) < 2 * 3e-6
    # Rims may rest a point farther on: 1 % of the area.
    assert found[True].area_rep == pytest.approx(found[False].area_rep, rel=0.01)
    assert found[True].load == pytest.approx(found[False].load, abs=0.02 * found[False].load_rep)
    # Seen: 22 and 47, 31 and 55, 35 and 72.
    assert found[True].solution.iterations < 0.6 * found[False].solution.iterations


def test_a_solve_that_does_not_stall_asks_no_box() -> None:
    state = solved(Rough(256, lambda_s=16.0).problem(), boxes=True)
    assert state.status.ok
    assert [work.shape for work in state.solution.work] == [(256, 256), (128, 128)]


@pytest.mark.parametrize("seed", [1, *(pytest.param(one, marks=pytest.mark.long) for one in (2, 3))])
def test_what_snaps_far_from_equilibrium_is_carried_over_by_coarser_grids(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond a jump from less than 0.2 to about 1 % of the area, in the basin of the start: the same contact.

    At 50 to 61 iterations without, 19 to 28 with the coarser grid.
    """
    surface = SelfAffine(0.5, 0.1, 4, 128).synthesise(Grid.square(256), np.random.default_rng(seed))
    problem = replace(Rough(256).problem(LennardJonesSpline(adhesion_length=0.05)), heights=surface)
    settings, jump = Settings(1e-6), {1: 3.49, 2: 3.30, 3: 3.16}[seed]
    before = equilibrium(problem, "mean-gap", jump + 0.03, settings)
    assert before.area_rep < 0.002

    def beyond() -> PathState:
        state = equilibrium(problem, "mean-gap", jump - 0.1, replace(settings, warm_grids=0), before.gap)
        assert state.solution.require().residual <= 2e-6
        return state

    carried = beyond()
    assert carried.area_rep > 0.009
    monkeypatch.setattr(SmoothGrid, "hand_down", lambda grid: False)
    alone = beyond()
    assert carried.solution.iterations < 0.6 * alone.solution.iterations
    assert carried.solution.fft_pairs < 0.7 * alone.solution.fft_pairs
    assert np.count_nonzero((carried.gap < 1) != (alone.gap < 1)) <= 1
    np.testing.assert_allclose(carried.gap, alone.gap, atol=2e-3)


@pytest.mark.parametrize(("softening", "carried"), [(0.39, True), (0.40, False)])
def test_a_coarser_grid_carries_what_has_four_points_there(softening: float, carried: bool) -> None:
    """Of a wave of eight points K is π/8 E*/a0."""
    assert made(Grid.square(256)).carried(np.array([[1.0, -softening]])) is carried


def test_a_solve_stops_where_it_stalls_if_it_is_hopeless() -> None:
    problem, seen = pinned(1), list[float]()

    def hopeless(gap: Real) -> bool:
        seen.append(float(np.mean(problem.wall.touches(gap))))
        return len(seen) > 1

    finer = FinerTolerance(1e-6, lambda gap: False, hopeless)
    at = problem.mean_height + problem.wall.zero_gap - float(np.quantile(problem.heights, 0.0125))
    state = equilibrium(problem, "mean-gap", at, Settings(3e-6), finer=finer)
    assert state.status is Status.STOPPED
    assert not state.status.ok
    assert len(seen) == 2
    assert 0.005 < seen[0] < 0.02


def test_the_energy_of_a_box_changes_as_that_of_the_surface() -> None:
    problem = pinned(1)
    state, boxes = solved(problem, boxes=True), made(problem.grid)
    g = np.zeros(problem.grid.shape)
    g[100, 40] = 1.0
    (place,) = boxes.places(g)
    at = np.ix_(*place)
    traction = state.traction
    force = -(traction - traction.mean())  # in equilibrium the substrate holds the wall
    moved = np.zeros(problem.grid.shape)
    moved[at] = 0.01 * bump(boxes)
    moved_q = problem.grid.forward(moved)
    bent_q = moved_q * problem.grid.wavenumber / 2
    elastic = problem.grid.mean(force * moved) + 0.5 * problem.grid.inner_q(moved_q, bent_q)
    evaluate = problem.wall.evaluate
    whole = elastic + problem.grid.mean(evaluate(state.gap - moved).energy - evaluate(state.gap).energy)
    box = boxes.rise(law(problem), state.gap[at], force[at], moved[at]) * boxes.grid.size / problem.grid.size
    assert whole > 0  # away from a minimum
    assert box == pytest.approx(whole, rel=0.02)  # the images of a box, and its mean


@pytest.mark.parametrize("sign", [1, -1])
def test_the_energy_of_a_box_falls_along_minus_the_gradient(sign: int) -> None:
    boxes, problem = made(Grid.square(256)), pinned(1)
    rng = np.random.default_rng(1)
    z, f = RANGE * rng.random(boxes.grid.shape), 0.01 * rng.standard_normal(boxes.grid.shape)
    v = sign * 1e-7 * bump(boxes)
    slope = boxes.grid.mean((f + problem.wall.evaluate(z).traction) * v)
    assert boxes.rise(law(problem), z, f, v) == pytest.approx(slope, rel=1e-3)


def test_without_a_wall_a_box_rests_where_its_force_vanishes() -> None:
    boxes = made(Grid((256, 320), (256.0, 320.0)))
    rng = np.random.default_rng(1)
    z, f = rng.random(boxes.grid.shape), rng.standard_normal(boxes.grid.shape)
    u_q = boxes.grid.forward(boxes.offset(z, f) - z)
    np.testing.assert_allclose(boxes.grid.inverse(boxes.stiffness_q * u_q), f, atol=1e-12)


def test_waves_of_a_box_are_as_stiff_as_those_of_the_surface() -> None:
    grid = Grid((512, 256), (512.0, 128.0))
    boxes = made(grid)
    assert boxes.grid.spacing == grid.spacing
    expected = boxes.grid.wavenumber / 2
    np.testing.assert_allclose(boxes.stiffness_q.ravel()[1:], expected.ravel()[1:], rtol=1e-12)
    assert boxes.stiffness_q[0, 0] == expected.ravel()[1:].min()


def test_boxes_lie_around_the_residual_and_do_not_overlap() -> None:
    grid = Grid((512, 288), (512.0, 288.0))  # of boxes of 64 by 72 points
    boxes = made(grid)
    g = np.random.default_rng(1).standard_normal(grid.shape) * 1e-3
    peaks = [(5, 280), (100, 100), (130, 110), (300, 20)]
    for k, peak in enumerate(peaks):
        g[peak] = 4.0 - k
    places = list(boxes.places(g))
    covered = np.zeros(g.shape, dtype=int)
    for place in places:
        covered[np.ix_(*place)] += 1
    assert covered.max() == 1
    for peak in (peaks[0], peaks[1], peaks[3]):  # the third lies too near the second
        holding = next(p for p in places if peak[0] in p[0] and peak[1] in p[1])
        assert boxes.window[holding[0].tolist().index(peak[0]), holding[1].tolist().index(peak[1])] == 1.0
    # Another origin: the same boxes.
    rolled = list(boxes.places(np.roll(g, (32, 54), (0, 1))))
    for one, other in zip(places, rolled, strict=True):
        np.testing.assert_array_equal((one[0] + 32) % 512, other[0])
        np.testing.assert_array_equal((one[1] + 54) % 288, other[1])


def test_a_residual_that_is_everywhere_has_few_boxes() -> None:
    g = np.random.default_rng(1).standard_normal((1024, 1024))
    assert LEAST > 2 * 4 / (1024 / 16) ** 2  # the share of the middle of each
    assert list(made(Grid.square(1024)).places(g)) == []


@pytest.mark.parametrize("shape", [(128, 128), (60, 72), (257, 512), (1, 4096)])
def test_a_surface_without_room_has_no_boxes(shape: tuple[int, int]) -> None:
    grid = Grid(shape, (float(shape[0]), float(shape[1])))
    assert Boxes.on(grid, grid.wavenumber / 2) is None


def test_a_wall_that_pulls_too_weakly_is_left_to_the_surface() -> None:
    """A box in which nothing is wrong moves nothing, and what is no descent is not taken."""
    problem = replace(pinned(1), wall=c.attraction_on_core("spline", 1e-5, RANGE, 5.0))
    state, boxes = solved(problem, boxes=True), made(problem.grid)
    z, traction = np.array(state.gap), np.array(state.traction)
    before = z.copy()
    still = replace(state.solution, gap=np.zeros(boxes.grid.shape))
    rise, _ = boxes.relax(
        law(problem), z, traction, np.pad([[1.0]], ((40, 215), (40, 215))), lambda offset, start: still
    )
    assert rise == 0.0
    np.testing.assert_array_equal(z, before)


def test_what_boxes_gain_is_that_of_the_surface_and_what_they_cost_is_counted() -> None:
    """Two boxes, of which the second would rise and is left as it is; where it falls the gap follows, in the window."""
    problem, rng = pinned(1), np.random.default_rng(2)
    boxes, g, offsets = made(problem.grid), np.zeros(problem.grid.shape), list[Real]()
    z, traction = RANGE * rng.random(g.shape), 0.1 * rng.standard_normal(g.shape)
    g[40, 40], g[200, 200] = 2.0, 1.0
    before, moved, places = z.copy(), 1e-3 * bump(boxes), [np.ix_(*place) for place in boxes.places(g)]
    gains = [boxes.rise(law(problem), z[at], (g - traction)[at], boxes.window * moved) for at in places]
    signs = -np.sign(gains) * [1, -1]

    def descend(offset: Real, start: Real) -> Solution:
        gap, work = start - signs[len(offsets)] * moved, (Work(boxes.grid.shape, 5.0, 0, 0.0),)
        offsets.append(offset)
        return Solution(gap, Status.CONVERGED, 0.0, 1, work)

    rise, pairs = boxes.relax(law(problem), z, traction, g, descend)
    (first, second), shift = places, signs[0] * boxes.window * moved
    assert pairs == 2 * (5.0 + 2)
    np.testing.assert_array_equal(offsets[1], boxes.offset(before[second], (g - traction)[second]))
    np.testing.assert_allclose(z[first], before[first] - shift, atol=1e-15)
    np.testing.assert_array_equal(z[second], before[second])
    gain = boxes.rise(law(problem), before[first], (g - traction)[first], shift)
    assert rise == pytest.approx(gain * boxes.grid.size / problem.grid.size, rel=1e-12)
    assert rise < 0
