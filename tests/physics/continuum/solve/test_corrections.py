"""States under a smooth law that are found on tiles, beside those of the whole grid."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from continuum.measure.contact import totals_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer, Substrate
from continuum.model.surface import SelfAffine
from continuum.model.walls import InversePowers, LennardJonesSpline, Wall
from continuum.solve.compiled import corrections, tractions
from continuum.solve.compiled import tiles as tiles_of_cpu
from continuum.solve.solution import FinerTolerance, Settings, Solution
from continuum.solve.solver import Solver
from tests import kinds

SETTINGS, BASIN = Settings(1e-7), Settings(1e-7, warm_grids=0)
NEVER = 2**20


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tiles on grids on which they would not pay."""
    monkeypatch.setattr(tiles_of_cpu, "SMALLEST", 2**15)
    monkeypatch.setattr(tiles_of_cpu, "MOST_SMOOTH", 0.5)


def problem_of(
    shape: tuple[int, int] = (512, 512), length: float = 0.005, substrate: Substrate | None = None
) -> ContactProblem:
    """A rough wall of which some hundredths of the area are in contact at a mean gap of 5 a0."""
    grid = Grid(shape, (float(shape[0]), float(shape[1])))
    heights = SelfAffine(0.8, 0.1, 16.0, min(shape) / 2).synthesise(grid, np.random.default_rng(2))
    return ContactProblem(grid, LennardJonesSpline(adhesion_length=length), heights, substrate or HalfSpace())


def law_of(wall: Wall) -> Law:
    assert wall.law is not None
    return wall.law


def solved(
    problem: ContactProblem,
    wall: Wall | None = None,
    start: Real | None = None,
    *,
    mean_gap: float = 5.0,
    pressure: float = 0.0,
    mean_stiffness: float = np.inf,
    settings: Settings = SETTINGS,
) -> Solution:
    """At a mean gap, or with a displacement of the mean from there."""
    posed = {"lift": mean_gap - problem.mean_height, "pressure": pressure, "mean_stiffness": mean_stiffness}
    solver = Solver(problem.grid, problem.stiffness_q)
    return solver.minimise(law_of(wall or problem.wall), problem.heights, start, settings, finer=None, **posed)


def both(monkeypatch: pytest.MonkeyPatch, solve: Callable[[], Solution]) -> tuple[Solution, Solution]:
    """A state with tiles and without."""
    tiled = solve()
    monkeypatch.setattr(tiles_of_cpu, "SMALLEST", NEVER)
    whole = solve()
    assert tiled.status.ok
    assert whole.status.ok
    return tiled, whole


def assert_same(tiled: Solution, whole: Solution, wall: Wall) -> None:
    """Gaps to what the residuals leave, and the same contact where these are clear; by way of the tiles."""
    apart = np.abs(tiled.gap - whole.gap)
    assert apart.max() < 1e-4
    assert apart.mean() < 1e-6
    differs = (tiled.gap < wall.zero_gap) != (whole.gap < wall.zero_gap)
    assert np.all(np.abs(whole.gap[differs] - wall.zero_gap) <= apart[differs])
    assert differs.sum() <= 2
    assert tiled.residual <= SETTINGS.tolerance
    assert tiled.iterations < 0.6 * whole.iterations
    assert tiled.fft_pairs < 0.7 * whole.fft_pairs


WALLS: dict[str, Wall] = {
    # Those that reach beyond the mean gap act on most points, for which tiles do not pay.
    **{name: wall for name, wall in kinds.WALLS.items() if wall.reach - wall.zero_gap < 4.0},
    "0": LennardJonesSpline(adhesion_length=0.0),
    "0.05": LennardJonesSpline(adhesion_length=0.05),
}


@pytest.mark.parametrize("name", WALLS)
def test_a_given_mean_gap_has_the_same_state(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At mean gaps at which less than half of the tiles are attracted."""
    problem, wall = problem_of((256, 256)), WALLS[name]
    apart = 2.8 if name == "0.05" else 2.3
    tiled, whole = both(monkeypatch, lambda: solved(problem, wall, mean_gap=apart + wall.zero_gap))
    assert_same(tiled, whole, wall)
    one, other = (totals_of(problem.grid, wall, each.gap) for each in (tiled, whole))
    assert one.load_rep == pytest.approx(other.load_rep, rel=1e-4)


@pytest.mark.parametrize("shape", [(256, 512), (512, 256)])
def test_an_oblong_layer_has_the_same_state(shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(shape, substrate=Layer(40.0, 0.3, "clamped"))
    assert_same(*both(monkeypatch, lambda: solved(problem, mean_gap=3.0, mean_stiffness=1e-2)), problem.wall)


def test_the_residual_is_that_of_the_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of()
    solution = solved(problem)
    monkeypatch.setattr(tiles_of_cpu, "SMALLEST", NEVER)
    u = problem.displacement(solution.gap, separation := 5.0 - problem.mean_height)
    g = problem.gradient(u, separation)
    assert np.sqrt(np.mean((g - g.mean()) ** 2)) == pytest.approx(solution.residual, rel=1e-3)


def test_the_energy_falls_to_that_of_the_state(monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[float] = []
    energy = corrections._Tiles.energy

    def noted(tiles: corrections._Tiles, mean: float) -> float:
        found.append(energy(tiles, mean))
        return found[-1]

    monkeypatch.setattr(corrections._Tiles, "energy", noted)
    problem = problem_of()
    solution = solved(problem, pressure=1e-3, mean_stiffness=1e-2)
    assert solution.status.ok
    assert np.all(np.diff(found[-1 - solution.iterations :]) < 0)
    assert {line.step for line in solution.history} == {1.0}
    assert [line.energy for line in solution.history] == pytest.approx(
        np.array(found[-1 - solution.iterations :]) - found[-1 - solution.iterations]
    )
    u = problem.heights + 5.0 - problem.mean_height - solution.gap
    K = problem.stiffness_q.copy()
    K[0, 0] = 1e-2
    u_q = problem.grid.forward(u)
    plain = 0.5 * problem.grid.inner_q(u_q, K * u_q) - 1e-3 * u.mean() + problem.wall.energy(solution.gap).mean()
    assert found[-1] == pytest.approx(plain, rel=1e-9)


def test_directions_solve_the_linear_problem_and_steps_go_to_the_minimum_along_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """(1 + φ'' G) t = p(z) - f to a part of it, w = G t, and along these the energy falls to where it is about flat."""
    find, descend, advance = (getattr(corrections._Tiles, name) for name in ("_find_direction", "_descend", "_advance"))
    left, slopes, trials = list[float](), list[float](), list[int]()

    def finding(tiles: corrections._Tiles, part: float) -> None:
        find(tiles, part)
        assert not tiles.snapped
        rest = tiles.missing + tiles.t + tiles.stiffness * tiles.w
        left.append(float(np.linalg.norm(rest) / np.linalg.norm(tiles.missing)) / part)
        answer = tiles.tiles.comply_with(tiles.t, np.empty(tiles.tiles.shape, np.float32))
        np.testing.assert_allclose(tiles.w, answer, atol=1e-5 * np.abs(answer).max())

    def descending(tiles: corrections._Tiles) -> bool:
        first = np.sum(tiles.missing * tiles.w)
        trials.append(0)
        assert descend(tiles)
        slopes.append(float(np.sum(tiles.missing * tiles.w) / first))
        return True

    def advancing(tiles: corrections._Tiles, step: float) -> tuple[float, float]:
        if trials:
            trials[-1] += 1
        return advance(tiles, step)

    for name, function in (("_find_direction", finding), ("_descend", descending), ("_advance", advancing)):
        monkeypatch.setattr(corrections._Tiles, name, function)
    problem = problem_of((256, 256))
    assert solved(problem, mean_gap=3.0).status.ok
    assert len(slopes) >= 4
    assert max(left) < 1.01
    assert np.abs(slopes).max() <= corrections.SLOPE_ACCEPTED
    assert np.mean(trials) <= 2


def test_threads_change_no_bit() -> None:
    problem = problem_of()
    one, two = (
        Solver(problem.grid, problem.stiffness_q, threads).minimise(
            law_of(problem.wall), problem.heights, None, SETTINGS, lift=5.0, mean_stiffness=np.inf
        )
        for threads in (1, 2)
    )
    assert one.status.ok
    assert np.array_equal(one.gap, two.gap)


def test_what_was_solved_before_changes_no_bit() -> None:
    problem = problem_of((256, 256))
    law, lift = law_of(problem.wall), 3.0 - problem.mean_height
    other = law_of(LennardJonesSpline(adhesion_length=0.0005, minimum_stiffness=1.0))

    def solve(solver: Solver, law: Law, lift: float, mean_stiffness: float) -> Solution:
        return solver.minimise(law, problem.heights, None, SETTINGS, lift=lift, mean_stiffness=mean_stiffness)

    fresh, used = (Solver(problem.grid, problem.stiffness_q) for _ in range(2))
    for before in (law, other):
        assert solve(used, before, lift - 0.3, 1e-3).status.ok
    assert np.array_equal(solve(used, law, lift, np.inf).gap, solve(fresh, law, lift, np.inf).gap)


def test_a_start_has_the_same_state(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of((256, 256))
    start = solved(problem, mean_gap=3.4).gap - 0.4
    assert_same(*both(monkeypatch, lambda: solved(problem, start=start, mean_gap=3.0)), problem.wall)


def test_a_start_that_is_far_is_left_to_the_whole_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of()
    lift, keep = 5.0 - problem.mean_height, Settings(1e-7, warm_grids=0)
    flat, solver = problem.heights + lift, Solver(problem.grid, problem.stiffness_q)
    tiled, whole = both(
        monkeypatch,
        lambda: solver.minimise(law_of(problem.wall), problem.heights, flat, keep, lift=lift, mean_stiffness=np.inf),
    )
    # Where it stalls the grid of n/2 carries it over, which has tiles in one of the two.
    assert tiled.history[1:9] == whole.history[1:9]
    assert np.abs(tiled.gap - whole.gap).max() < 2e-5  # both residuals are below 1e-7, as elsewhere here


def test_a_finer_tolerance_is_met_where_the_gap_is_worth_it() -> None:
    problem = problem_of()
    looked: list[float] = []

    def solve(answer: bool) -> Solution:
        def worth(gap: Real) -> bool:
            looked.append(gap.mean())
            return answer

        finer = FinerTolerance(1e-8, worth)
        lift = 5.0 - problem.mean_height
        return Solver(problem.grid, problem.stiffness_q).minimise(
            law_of(problem.wall), problem.heights, None, Settings(1e-6), lift=lift, mean_stiffness=np.inf, finer=finer
        )

    assert 1e-8 < solve(False).residual <= 1e-6
    assert solve(True).residual <= 1e-8
    assert looked == pytest.approx([5.0, 5.0])


LEFT: dict[str, dict[str, Any]] = {
    "most tiles": {"mean_gap": 1.0},
    "a given pressure": {"mean_stiffness": 0.0, "pressure": 1e-4},
    "a wall without end": {"wall": InversePowers((9, 3), adhesion_length=0.005)},
}


@pytest.mark.parametrize("posed", LEFT.values(), ids=LEFT)
def test_what_tiles_do_not_serve_is_left_to_the_whole_grid(
    posed: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = problem_of((256, 256))
    tiled, whole = both(monkeypatch, lambda: solved(problem, **posed))
    assert np.array_equal(tiled.gap, whole.gap)
    assert tiled.work == whole.work or tiled.fft_pairs == whole.fft_pairs


@cache
def contact_of_the_whole_grid() -> Any:
    return solved(problem_of((256, 256)), mean_gap=3.0, settings=Settings(1e-9)).require().gap < 1.0


@pytest.mark.parametrize("fault", ["SLOW", "NEWTON_STEPS", "DIRECTIONS", "TRIALS", "energy"])
def test_the_whole_grid_goes_on_where_tiles_come_to_no_end(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of((256, 256))
    if fault == "energy":
        rising = iter(range(9))
        monkeypatch.setattr(corrections._Tiles, "energy", lambda *_: float(next(rising)))
    else:
        monkeypatch.setattr(corrections, fault, 1e-9 if fault == "SLOW" else 0)
    # At the default tolerance gaps differ by some 1e-5 a0, and by that a point on the edge of a contact.
    tiled = solved(problem, mean_gap=3.0, settings=Settings(1e-9))
    assert tiled.status.ok
    monkeypatch.setattr(tiles_of_cpu, "SMALLEST", NEVER)
    assert np.array_equal(tiled.gap < 1.0, contact_of_the_whole_grid())
    assert tiled.iterations > 4
    assert len(tiled.history) == tiled.iterations + 1


def stepped(problem: ContactProblem, gaps: list[float]) -> Solution:
    """The state at the last of these mean gaps, each solved in the basin of the one before, moved."""
    found = solved(problem, mean_gap=gaps[0])
    for last, gap in pairwise(gaps):
        found = solved(problem, start=found.gap + (gap - last), mean_gap=gap, settings=BASIN)
        assert found.status.ok
    return found


def test_what_snaps_is_carried_over_on_the_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    # Between these mean gaps an asperity snaps; the approach in steps of a fiftieth shows where it comes to.
    problem = problem_of((256, 256), 0.05)
    with monkeypatch.context() as whole_grid:
        whole_grid.setattr(tiles_of_cpu, "SMALLEST", NEVER)
        approach = stepped(problem, np.linspace(4.2, 4.0, 11).tolist())
        before = stepped(problem, [4.2, 4.15, 4.1, 4.05]).gap - 0.05
        slow = solved(problem, start=before, mean_gap=4.0, settings=BASIN)
    tiles: list[corrections._Tiles] = []
    onto = corrections._Tiles.onto

    def noted(one: corrections._Tiles, f: Any) -> None:
        tiles.append(one)
        onto(one, f)

    monkeypatch.setattr(corrections._Tiles, "onto", noted)
    found = solved(problem, start=before, mean_gap=4.0, settings=BASIN)
    assert found.status.ok
    assert any(one.snapped for one in tiles)
    assert found.iterations <= 5 < slow.iterations
    assert np.abs(found.gap - approach.gap).max() < 1e-4  # what the residuals leave, as above
    assert np.abs(before - approach.gap).max() > 0.5


def test_a_step_of_tractions_says_what_is_missing_and_how_the_energy_goes_on() -> None:
    """Of some rows: f - p(z) there, and the first two derivatives of the energy, <w (f - p)> and <w (t + φ'' w)>."""
    law, rng, rows = LennardJonesSpline(0.3).law, np.random.default_rng(1), slice(5, 60)
    assert law is not None
    f, t, w, missing = rng.normal(size=(4, 64, 32))
    z, stiffness = 1.2 + 0.3 * rng.normal(size=(64, 32)), np.zeros((64, 32), np.float32)
    before, sums, kept = (f.copy(), z.copy()), np.zeros(6), missing.copy()
    tractions.advance_traction(rows.start, rows.stop, sums, f, z, t, w, 0.3, law, missing, stiffness)
    moved = np.zeros((64, 1))
    moved[rows] = 0.3
    np.testing.assert_allclose(f, before[0] + moved * t, atol=1e-15)
    np.testing.assert_allclose(z, before[1] + moved * w, atol=1e-15)
    energy, traction, curvature = evaluate(law, z[rows])
    expected = f[rows] - traction
    np.testing.assert_allclose(missing[rows], expected, atol=1e-12)
    np.testing.assert_array_equal(missing[60:], kept[60:])
    np.testing.assert_allclose(stiffness[rows], curvature, rtol=1e-6)
    w, t = w[rows], t[rows]
    both = (expected**2).sum(), energy.sum(), (w * expected).sum(), (w * (t + curvature * w)).sum()
    np.testing.assert_allclose(sums[:4], both, rtol=1e-11)
