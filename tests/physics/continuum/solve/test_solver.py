"""Equilibria against analytic contacts and against one another; how a solve ends that does not converge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.inputs.arguments import ArgumentError
from continuum.measure.contact import ATTRACTED, OUT_OF_RANGE, REPULSIVE, contact_map, totals_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.surface import SelfAffine
from continuum.model.surfaces import sine, sphere
from continuum.model.walls import LennardJonesSpline
from continuum.model.walls.tabulated import TabulatedWall
from continuum.path.loading import follow, solve
from continuum.path.state import Control, PathState
from continuum.solve.backend import SHORT_WAVES
from continuum.solve.solution import NotConvergedError, Settings, Status
from continuum.solve.solver import Solver
from continuum.theory.smooth import Hertz
from tests.classical import Westergaard
from tests.kinds import covering
from tests.problems import Rough, touching

TIGHT = Settings(tolerance=1e-9)


def residual(problem: ContactProblem, state: PathState) -> float:
    displacement = problem.displacement(state.gap, state.separation)
    return float(np.sqrt(np.mean(problem.gradient(displacement, state.separation) ** 2)))


# --- analytic contacts -------------------------------------------------------------------------------------

# A stiff wall stands for a hard one: it yields p/k, 0.5 % of the smallest indentation used below.
STIFF = LennardJonesSpline(0.0, minimum_stiffness=50.0)


@pytest.mark.parametrize("indentation", [1.0, pytest.param(2.0, marks=pytest.mark.long), 4.0])
def test_hertz(indentation: float) -> None:
    radius = 100.0
    grid = Grid.square(160)
    problem = ContactProblem(grid, STIFF, sphere(grid, radius), HalfSpace("free"))
    # With a free mean a given mean gap sets the load; find the one whose contact is this deep.
    flat_gap = problem.mean_height + STIFF.zero_gap
    state = solve(problem, "mean-gap", flat_gap - indentation / 2, Settings(1e-8))
    assert state.status.ok
    load = state.load * grid.area
    hertz = Hertz(radius, load)
    traction = STIFF.evaluate(state.gap).traction
    x, y = grid.positions
    r = np.hypot(x - 80, y - 80)
    # Images: the neighbouring contacts bend the surface by about (a/L)³ of the curvature, 0.3 % at a/L = 1/8,
    # and the finite cells blur the edge.  Both are far below 3 % of the peak pressure over the inner contact.
    inner = r < 0.8 * hertz.contact_radius
    np.testing.assert_allclose(traction[inner], hertz.pressure(r[inner]), atol=0.03 * hertz.pressure(np.zeros(1))[0])
    area = np.count_nonzero(traction > 1e-6)
    # A disc on a square grid: the boundary has about 2πa cells, of which half a cell is uncertain.
    assert np.sqrt(area / np.pi) == pytest.approx(hertz.contact_radius, abs=0.5)
    assert traction[r > hertz.contact_radius + 1.5].max() < 1e-6


@pytest.mark.parametrize("fraction", [0.1, 0.3, 0.6, 0.9])
def test_westergaard_wave(fraction: float) -> None:
    errors = []
    for n in (64, 256):
        grid = Grid((n, 4), (64.0, 4.0))
        # The amplitude keeps the wave's full pressure at 0.1 E*; the wall yields p/k = 0.002.
        problem = ContactProblem(grid, STIFF, sine(grid, 64 * 0.1 / np.pi, (1, 0)), HalfSpace("free"))
        wave = Westergaard(64 * 0.1 / np.pi, 64.0, fraction * 0.1)
        state = solve(problem, "mean-pressure", wave.mean_pressure, TIGHT).require()
        x = np.minimum(grid.positions[0], 64 - grid.positions[0])
        exact = wave.pressure(np.broadcast_to(x, grid.shape))
        errors.append(float(np.sqrt(np.mean((STIFF.evaluate(state.gap).traction - exact) ** 2))) / 0.1)
        if n == 256:
            width = np.count_nonzero(state.gap[:, 0] < STIFF.zero_gap) * grid.spacing[0] / 2
            assert width == pytest.approx(wave.half_width, abs=2 * grid.spacing[0])
    # The square-root edge of the pressure limits the order; what remains at last is the yield of the wall,
    # p*/k = 0.002 a0.
    assert errors[1] < 0.02
    assert errors[1] < max(errors[0], 0.002)


# --- one state, reached in different ways ------------------------------------------------------------------


@pytest.mark.parametrize("adhesion_length", [0.0, 0.0005, 0.005])
def test_the_state_does_not_depend_on_the_start(adhesion_length: float) -> None:
    problem = Rough(adhesion_length=adhesion_length).problem()
    target = 0.75 * touching(problem)
    reference = solve(problem, "separation", target, TIGHT)
    assert reference.status.ok
    assert residual(problem, reference) < 2e-9
    assert totals_of(problem.grid, problem.wall, reference.gap).area_rep > 0.01
    rng = np.random.default_rng(0)
    starts = [
        reference.gap + 1e-3 * rng.normal(size=problem.grid.shape),
        np.zeros(problem.grid.shape),  # every point overlaps the wall by a0
    ]
    for start in starts:
        state = solve(problem, "separation", target, TIGHT, start)
        assert state.status.ok
        # Softest modes have a stiffness of 2π/(2 n) E*/a0 = 0.05; the residual 1e-9 moves them by 2e-8.
        np.testing.assert_allclose(state.gap, reference.gap, atol=1e-7)


@given(st.integers(0, 10**6), st.sampled_from([(24, 24), (25, 31), (32, 20)]), st.floats(0.3, 0.9))
def test_whatever_the_system_a_converged_state_is_an_equilibrium(
    seed: int, shape: tuple[int, int], fraction: float
) -> None:
    grid = Grid(shape, (32.0, 32.0))
    rng = np.random.default_rng(seed)
    heights = SelfAffine(0.8, 0.1, 6.0, 16.0).synthesise(grid, rng)
    wall = LennardJonesSpline(adhesion_length=float(rng.choice([0, 0.0005, 0.005, 0.05])))
    response = Layer(20.0, float(rng.uniform(0, 0.5)), float(rng.choice([0.02, 0.2])))
    problem = ContactProblem(grid, wall, heights, response)
    start = rng.normal(size=shape) if seed % 2 else None
    state = solve(problem, "separation", fraction * touching(problem), TIGHT, start)
    assert state.status.ok
    assert residual(problem, state) < 2e-9
    # Newton's third law: the mean mode of the substrate carries the load.
    mean_displacement = grid.mean(problem.displacement(state.gap, state.separation))
    assert state.load == pytest.approx(-problem.mean_stiffness * mean_displacement, abs=2e-9)


def test_coarser_grids_save_work_and_change_nothing() -> None:
    problem = Rough(256).problem()
    target, tight = 0.7 * touching(problem), Settings(1e-10)  # a soft summit moves by a few hundred times the residual
    cascade = solve(problem, "mean-gap", target, tight)
    assert [work.shape for work in cascade.solution.work] == [(256, 256), (128, 128)]
    warm = solve(problem, "mean-gap", target, tight, problem.heights + target)
    np.testing.assert_allclose(cascade.gap, warm.gap, atol=1e-7)
    # The same surface on a grid that has no coarser one.
    grid = Grid((128, 128), (256.0, 256.0))
    heights = SelfAffine(0.8, 0.1, 8.0, 128.0).synthesise(grid, np.random.default_rng(1))
    alone = solve(ContactProblem(grid, problem.wall, heights, problem.substrate), "mean-gap", target, tight)
    assert cascade.solution.iterations < alone.solution.iterations / 2


@pytest.mark.parametrize(
    ("adhesion_length", "shape"), covering([0.0, 0.05], [(257, 254), (250, 251)])
)  # primes, and twice primes
def test_sides_of_any_number_of_points_have_coarser_grids(adhesion_length: float, shape: tuple[int, int]) -> None:
    """As many iterations as on 256², to a half, and the same contact but for where the points lie."""

    def found(shape: tuple[int, int]) -> PathState:
        grid = Grid(shape, (256.0, 256.0))
        heights = SelfAffine(0.8, 0.1, 16.0, 128.0).synthesise(grid, np.random.default_rng(1))
        wall = LennardJonesSpline(adhesion_length=adhesion_length)
        return solve(
            ContactProblem(grid, wall, heights, HalfSpace("clamped")), "mean-gap", 3.0, Settings(1e-8)
        ).require()

    even = found((256, 256))
    odd = found(shape)
    assert [work.shape for work in odd.solution.work][:2] == [shape, (128, 128)]
    assert odd.solution.iterations <= 1.5 * even.solution.iterations
    # The smallest wavelength is 16 points, of which an edge of a contact may miss one or two.
    assert odd.area_rep == pytest.approx(even.area_rep, rel=0.05)


@pytest.mark.parametrize(("adhesion_length", "part"), [(0.0, 0.85), pytest.param(0.005, 0.95, marks=pytest.mark.long)])
def test_short_waves_take_shorter_steps_beside_those_of_a_coarser_grid(
    adhesion_length: float, part: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against the shift of long waves, 0.01: at a fifth of the area 0.77 and 0.84 of the pairs, for the same state."""
    problem, found = Rough(512, adhesion_length).problem(), list[PathState]()
    for shift in (SHORT_WAVES, 0.01 / problem.stiffness_q[:, 1:].max()):
        monkeypatch.setattr("continuum.solve.backend.SHORT_WAVES", shift)
        found.append(solve(problem, "mean-gap", 2.0, Settings(1e-8)).require())
    np.testing.assert_allclose(*(state.gap for state in found), atol=1e-5)
    assert found[0].solution.fft_pairs < part * found[1].solution.fft_pairs


def test_a_start_relaxed_on_coarser_grids_saves_work_and_changes_nothing() -> None:
    problem = Rough(256).problem()
    near, far = 0.6 * touching(problem), 0.7 * touching(problem)
    start = solve(problem, "mean-gap", far, TIGHT).gap + (near - far)
    plain, warm = (solve(problem, "mean-gap", near, Settings(1e-9, warm_grids=k), start) for k in (0, 2))
    assert plain.status.ok
    assert warm.status.ok
    assert warm.load == pytest.approx(plain.load, rel=1e-6)
    np.testing.assert_allclose(warm.gap, plain.gap, atol=1e-6)
    # Seen: 20 and 32 iterations, 81 and 97 pairs; half the pairs at λs = 32, which coarse grids resolve better.
    assert warm.solution.iterations < plain.solution.iterations
    assert warm.solution.fft_pairs < plain.solution.fft_pairs


@pytest.mark.parametrize("warm_grids", [0, 2])
@pytest.mark.parametrize("control", ["mean-gap", "separation"])
def test_an_equilibrium_as_the_start_is_the_end(control: Control, warm_grids: int) -> None:
    problem = Rough(adhesion_length=0.05).problem()
    target = 0.6 * touching(problem)
    state = solve(problem, control, target, TIGHT)
    again = solve(problem, control, target, Settings(1e-8, warm_grids=warm_grids), state.gap)
    assert again.status.ok
    assert again.solution.iterations == 0
    np.testing.assert_allclose(again.gap, state.gap, atol=1e-12)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    grid = Grid.square(512)
    heights = SelfAffine(0.8, 0.1, 16.0, 256.0).synthesise(grid, np.random.default_rng(1))
    problem = ContactProblem(grid, LennardJonesSpline(0.3), heights, HalfSpace("clamped"))
    results = [
        solve(problem, "mean-gap", 0.7 * touching(problem), Settings(1e-5, threads=threads)).gap for threads in (1, 3)
    ]
    np.testing.assert_array_equal(results[0], results[1])


def test_mean_gap_and_separation_control_find_the_same_state() -> None:
    problem = Rough().problem(substrate=Layer(32.0, 0.3, Layer(32.0, 0.3, "free").compressive_stiffness))
    by_gap = solve(problem, "mean-gap", 0.8 * touching(problem), TIGHT)
    by_separation = solve(problem, "separation", by_gap.separation, TIGHT)
    assert by_separation.mean_gap == pytest.approx(by_gap.mean_gap, abs=1e-7)
    np.testing.assert_allclose(by_gap.gap, by_separation.gap, atol=1e-7)
    assert by_gap.separation < by_gap.mean_gap - 1e-3 or by_gap.load < 0  # the base is felt


def test_adhesion_makes_approach_and_retraction_differ() -> None:
    # A flat wall under a layer long enough snaps in: two branches at one separation (wavelength > 6π a0).
    grid = Grid.square(64)
    wall = LennardJonesSpline(1.09545)
    heights = 0.05 * np.cos(2 * np.pi * grid.positions[0] / 64) * np.ones(grid.shape)
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    down = np.linspace(2.2, 1.2, 21)
    states = list(follow(problem, "separation", [*down, *down[-2::-1]], Settings(1e-8)))
    assert all(state.status.ok for state in states)
    approach = {state.target: state for state in states[:21]}
    gaps = {
        round(s.target, 6): (s.gap.min(), approach[s.target].gap.min()) for s in states[21:] if s.target in approach
    }
    differ = [abs(a - b) > 0.05 for a, b in gaps.values()]
    assert any(differ)
    assert not all(differ)
    assert [s.branch for s in states] == ["start"] + 20 * ["approach"] + 20 * ["retract"]


# --- invariances -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class InUnits:
    """A half-space whose stiffness is given in another unit than E*."""

    modulus: float

    def stiffness(self, grid: Grid) -> Real:
        return self.modulus * HalfSpace("clamped").stiffness(grid)


def test_units_do_not_matter() -> None:
    """The same contact with lengths in units of s a0 and moduli in units of e E*."""
    problem = Rough().problem()
    target = 0.8 * touching(problem)
    gap = np.linspace(0.7, 1 + problem.wall.range, 401)
    base = TabulatedWall(gap, problem.wall.evaluate(gap).traction)
    results = []
    for s, e in ((1.0, 1.0), (0.37, 8.9)):
        grid = Grid(problem.grid.shape, (64 * s, 64 * s))
        wall = TabulatedWall(s * base.gap, e * base.traction)
        scaled = ContactProblem(grid, wall, s * problem.heights, InUnits(e))
        state = solve(scaled, "separation", s * target, Settings(1e-10 * e, shift=0.01 * e))
        contact = totals_of(grid, wall, state.gap)
        results.append((state.gap / s, contact.load / e, contact.area_rep, contact.area_att))
    np.testing.assert_allclose(results[0][0], results[1][0], atol=1e-7)
    assert results[0][1] == pytest.approx(results[1][1], rel=1e-6)
    assert results[0][2:] == results[1][2:]
    assert results[0][2] > 0.01


def test_translation_and_exchange_of_axes_do_not_matter() -> None:
    problem = Rough().problem()
    target = 0.8 * touching(problem)
    gap = solve(problem, "separation", target, TIGHT).gap

    def solved(heights: Real) -> Real:
        return solve(
            ContactProblem(problem.grid, problem.wall, heights, problem.substrate), "separation", target, TIGHT
        ).gap

    np.testing.assert_allclose(
        solved(np.roll(problem.heights, (5, 11), (0, 1))), np.roll(gap, (5, 11), (0, 1)), atol=1e-7
    )
    np.testing.assert_allclose(solved(problem.heights.T), gap.T, atol=1e-7)


def test_adhesion_needs_less_load_for_the_same_area() -> None:
    loads = []
    for adhesion_length in (0.0, 0.0005, 0.005):
        problem = Rough(128, adhesion_length).problem()
        state = solve(problem, "mean-gap", 0.7 * touching(problem), TIGHT)
        contact = totals_of(problem.grid, problem.wall, state.gap)
        loads.append(contact.load / contact.area_rep)
        assert contact.load == pytest.approx(state.load, rel=1e-12)
        assert contact.load == pytest.approx(contact.load_rep - contact.load_att, rel=1e-12)
        kinds = contact_map(problem.wall, state.gap)
        assert np.count_nonzero(kinds == REPULSIVE) / kinds.size == contact.area_rep
        assert (np.count_nonzero(kinds == ATTRACTED) > 0) == (adhesion_length > 0)
        assert np.count_nonzero(kinds == OUT_OF_RANGE) > 0
    assert loads[0] > loads[1] > loads[2]


# --- paths -------------------------------------------------------------------------------------------------


def test_a_resumed_path_is_the_undisturbed_one() -> None:
    problem = Rough().problem()
    targets = [f * touching(problem) for f in (1.1, 1.0, 0.9, 0.8, 0.9, 1.0)]
    whole = list(follow(problem, "separation", targets, TIGHT))
    for done in (1, 2, 4, 5):
        rest = list(follow(problem, "separation", targets[done:], TIGHT, previous=whole[max(0, done - 2) : done]))
        for a, b in zip(whole[done:], rest, strict=True):
            assert a.branch == b.branch
            np.testing.assert_array_equal(a.gap, b.gap)


def test_a_path_costs_less_than_its_points_from_scratch() -> None:
    problem = Rough(adhesion_length=0.0).problem()
    targets = [f * touching(problem) for f in (0.80, 0.79, 0.78, 0.77)]
    warm = [s.solution.fft_pairs for s in follow(problem, "separation", targets, Settings(1e-7))]
    cold = [solve(problem, "separation", t, Settings(1e-7)).solution.fft_pairs for t in targets]
    assert sum(warm[1:]) < sum(cold[1:])


def test_a_failed_step_is_never_a_start() -> None:
    problem = Rough().problem()
    good = solve(problem, "separation", touching(problem), TIGHT)
    failed = solve(problem, "separation", 0.9 * touching(problem), Settings(1e-9, max_iterations=2))
    assert failed.status is Status.ITERATION_LIMIT
    target = [0.8 * touching(problem)]
    after_both, after_good = (
        next(follow(problem, "separation", target, TIGHT, previous)) for previous in ([good, failed], [good])
    )
    np.testing.assert_array_equal(after_both.gap, after_good.gap)


# --- how a solve ends --------------------------------------------------------------------------------------


def test_running_out_of_iterations_is_said() -> None:
    problem = Rough().problem()
    state = solve(problem, "separation", 0.7 * touching(problem), Settings(1e-9, max_iterations=3))
    assert state.status is Status.ITERATION_LIMIT
    assert state.solution.residual > 1e-9
    with pytest.raises(NotConvergedError, match="allow more iterations"):
        state.solution.require()


def test_going_below_the_core_is_said() -> None:
    problem = Rough().problem()
    state = solve(problem, "separation", problem.heights.max() - 4.0, TIGHT)
    assert state.gap.min() < problem.wall.core
    assert state.status is Status.BELOW_CORE


def test_a_tolerance_below_rounding_is_said_not_reached() -> None:
    problem = Rough().problem()
    state = solve(problem, "separation", 0.7 * touching(problem), Settings(1e-30, max_iterations=400))
    assert state.status in (Status.LINE_SEARCH, Status.ITERATION_LIMIT)
    assert state.solution.residual < 1e-12


def test_a_start_that_is_not_finite_is_said() -> None:
    problem = Rough().problem()
    start, law = np.full(problem.grid.shape, np.nan), problem.wall.law
    assert law is not None
    found = Solver(problem.grid, problem.stiffness_q).minimise(law, problem.heights, start, TIGHT, lift=1.0)
    assert found.status is Status.NON_FINITE
    with pytest.raises(ArgumentError, match="4096 of 4096 are NaN"):
        solve(problem, "separation", 1.0, TIGHT, start)


def test_an_energy_that_does_not_belong_to_its_traction_is_said() -> None:
    grid = Grid.square(16)
    gap = np.linspace(0.7, 1.3, 61)
    law = TabulatedWall(gap, LennardJonesSpline(0.3).evaluate(gap).traction).law
    # The energies of the pieces, upside down: a step from one piece to the next that should lower it raises it.
    lying = law.parameters.copy()
    lying[62:122] = -20 * lying[62:122]
    heights = 0.3 * np.cos(2 * np.pi * grid.positions[0] / 16) * np.ones(grid.shape)
    solver = Solver(grid, HalfSpace("clamped").stiffness(grid))
    for parameters, expected in ((law.parameters, Status.CONVERGED), (lying, Status.ENERGY_ROSE)):
        found = solver.minimise(law._replace(parameters=parameters), 0.95 + heights, None, TIGHT)
        assert found.status is expected


def test_history_ends_at_the_residual_and_never_rises_in_energy() -> None:
    solution = solve(Rough().problem(), "separation", 1.0, TIGHT).solution
    energies = np.array([line.energy for line in solution.history])
    assert energies[0] == 0  # relative to the start
    assert (np.diff(energies) <= 1e-14).all()
    assert solution.history[-1].residual == pytest.approx(solution.residual, rel=0.1)
    assert solution.iterations == len(solution.history) - 1
    # On 64 points there is no coarser grid: one pair for an iteration, and a few to begin and to check.
    assert solution.iterations < solution.fft_pairs < solution.iterations + 4
    assert solution.require() is solution


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("max_iterations", 1, 0), ("shift", 1e-300, 0.0), ("warm_grids", 0, -1), ("threads", 1, 0),
        ("threads", 1024, 1025),
    ],
)  # fmt: skip
def test_settings_go_to_their_bounds(name: str, good: float, bad: float) -> None:
    assert getattr(Settings(1e-300, **{name: good}), name) == good
    with pytest.raises(ArgumentError, match=f"^{name} = "):
        Settings(1e-6, **{name: bad})
    with pytest.raises(ArgumentError, match=r"^tolerance = "):
        Settings(0.0)
    assert Settings(1e-6, shift=0.01).coarser() == Settings(1e-6, shift=0.02)
