"""Equilibria under a hard wall: analytic contacts, a dense reference, the conditions of the minimum, honest endings."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from continuum.measure.contact import OUT_OF_RANGE, REPULSIVE, contact_map, totals_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.surface import SelfAffine
from continuum.model.surfaces import sine, sphere
from continuum.model.walls import HardWall, LennardJonesSpline
from continuum.path.loading import follow, solve
from continuum.path.state import Control, PathState, state_of
from continuum.solve.compiled.bound_grid import CompiledBoundGrid
from continuum.solve.hard import _Dual, _Outcome
from continuum.solve.solution import Settings, Solution, Status
from continuum.solve.solver import Solver
from continuum.theory.smooth import Hertz
from tests.classical import Westergaard
from tests.problems import Rough

TIGHT = Settings(tolerance=1e-10)


def at_pressure(grid: Grid, heights: Real, pressure: float, tolerance: float = 1e-10) -> Solution:
    """State of a given mean pressure, whose mean displacement is whatever it has to be."""
    found = Solver(grid, HalfSpace("free").stiffness(grid)).constrain(
        heights, None, Settings(tolerance), pressure=pressure
    )
    assert found.status.ok
    assert grid.mean(found.traction) == pytest.approx(pressure, rel=1e-12)
    return found


def stiffness(grid: Grid, values: Real) -> Real:
    """K times a field, without its mean, by numpy's transforms: nothing of the solver's."""
    q = [2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.spacing, strict=True)]
    K = np.hypot(q[0][:, None], q[1][None, :]) / 2
    return np.asarray(np.fft.ifft2(K * np.fft.fft2(values)).real)


def assert_minimum(grid: Grid, heights: Real, found: Solution, tolerance: float) -> None:
    """The conditions of Karush, Kuhn and Tucker, exactly; and the traction is what holds the surface."""
    p, z = found.traction, found.gap
    assert p.min() >= 0
    assert z.min() >= 0
    assert not ((p > 0) & (z > 0)).any()
    assert not ((p == 0) & (z == 0)).any()
    held = -stiffness(grid, heights - z)
    missed = p - p.mean() - held
    assert np.sqrt(np.mean(missed**2)) <= 1.01 * tolerance  # without the mean mode, and rounding


# --- against analytic contacts -----------------------------------------------------------------------------


def test_westergaard_wave_to_first_order() -> None:
    grids = [64, 128, 256, 512, 1024]
    errors = []
    for fraction in (0.05, 0.3, 0.6, 0.9):
        wave = Westergaard(64 * 0.1 / np.pi, 64.0, fraction * 0.1)
        for n in grids:
            grid = Grid((n, 4), (64.0, 4.0))
            found = at_pressure(grid, sine(grid, wave.amplitude, (1, 0)), wave.mean_pressure)
            x = np.minimum(grid.positions[0], 64 - grid.positions[0])
            exact = wave.pressure(np.broadcast_to(x, grid.shape))
            errors.append(float(np.sqrt(np.mean((found.traction - exact) ** 2))))
            width = np.count_nonzero(found.gap[:, 0] == 0) * grid.spacing[0] / 2
            assert width == pytest.approx(wave.half_width, abs=grid.spacing[0])
    # The pressure ends as a square root: an error dx^½ at a point or two, an rms of dx.  Where in its cell
    # the edge lies scatters the single errors by a factor of a few, which four loads average.
    mean = np.log(np.reshape(errors, (4, len(grids)))).mean(axis=0)
    assert -np.polyfit(np.log(grids), mean, 1)[0] == pytest.approx(1.0, abs=0.2)
    assert max(errors) < 0.5 * 0.1 / 64


@pytest.mark.parametrize("load", [0.01, 0.03])
def test_two_dimensional_wave_is_hertzian_at_light_load(load: float) -> None:
    # Johnson, Greenwood and Higginson, Int. J. Mech. Sci. 27, 383 (1985): z = Δ cos(2πx/λ) cos(2πy/λ).
    wavelength, amplitude = 256.0, 1.0
    found, grid, full = double_wave(256, wavelength, amplitude, load)
    radius = (wavelength / (2 * np.pi)) ** 2 / amplitude
    hertz = Hertz(radius, load * full * wavelength**2 / 2)  # two crests in a cell
    peak = float(hertz.pressure(np.zeros(1))[0])
    # Next order: the crest is less curved away from its top, (a/λ)² ~ load^(2/3), and a cell of half a diagonal.
    assert found.traction.max() == pytest.approx(peak, rel=0.02 + 0.5 * load ** (2 / 3))
    area = np.count_nonzero(found.gap == 0) / grid.size
    limit = np.pi * (3 * load / (8 * np.pi)) ** (2 / 3)
    assert area == pytest.approx(limit, rel=0.1)


def double_wave(n: int, wavelength: float, amplitude: float, load: float) -> tuple[Solution, Grid, float]:
    """A wave along x times one along y, at a mean pressure in parts of that of full contact."""
    grid = Grid((n, n), (wavelength, wavelength))
    x, y = grid.positions
    heights = amplitude * np.cos(2 * np.pi * x / wavelength) * np.cos(2 * np.pi * y / wavelength)
    full = np.sqrt(2) * np.pi * amplitude / wavelength
    return at_pressure(grid, heights, load * full, 1e-10 * full), grid, full


def test_two_dimensional_wave_is_penny_shaped_near_full_contact() -> None:
    for load in (0.9, 0.95):
        found, grid, _ = double_wave(256, 256.0, 1.0, load)
        gap = 1 - np.count_nonzero(found.gap == 0) / grid.size
        # JGH: A/λ² = 1 - 3/(2π) (1 - p/p*); next order in the size of the pennies, (1 - p/p*)^2, and their rims.
        assert gap == pytest.approx(3 / (2 * np.pi) * (1 - load), rel=0.08)


@pytest.mark.parametrize("load", [1.0001, 2.0])
def test_full_contact(load: float) -> None:
    found, grid, full = double_wave(64, 64.0, 1.0, load)
    x, y = grid.positions
    exact = full * (load - np.cos(2 * np.pi * x / 64) * np.cos(2 * np.pi * y / 64))
    np.testing.assert_allclose(found.traction, exact, atol=1e-8 * full)
    assert (found.gap == 0).all()
    assert (double_wave(64, 64.0, 1.0, 0.999)[0].gap > 0).any()


def test_hertz_up_to_its_images() -> None:
    # Contact radius of 16 cells throughout; the images flatten the sphere by (a/L)³ of its curvature.
    radius, contact = 400.0, 16.0
    load = 4 * contact**3 / (3 * radius)
    hertz = Hertz(radius, load)
    peaks = []
    for n in (64, 128, 256):
        grid = Grid.square(n)
        found = at_pressure(grid, sphere(grid, radius), load / grid.area)
        x, y = grid.positions
        r = np.hypot(x - n / 2, y - n / 2)
        peaks.append(float(found.traction[r == 0][0]))
        cells = np.count_nonzero(found.gap == 0)
        assert np.sqrt(cells / np.pi) == pytest.approx(hertz.contact_radius, abs=0.5)
    assert np.log2((peaks[0] - peaks[1]) / (peaks[1] - peaks[2])) == pytest.approx(3, abs=0.3)
    limit = peaks[2] + (peaks[2] - peaks[1]) / 7
    # One cell of 16: half the integral's error of the square root at the rim.
    assert limit == pytest.approx(float(hertz.pressure(np.zeros(1))[0]), rel=2e-3)


# --- against other solvers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("shape", "mean"), [((8, 6), 0.3), ((5, 7), 1e-4), ((2, 9), 20.0), ((3, 3), 1.0)])
def test_dense_reference(shape: tuple[int, int], mean: float) -> None:
    grid = Grid(shape, (shape[0] * 1.5, shape[1] * 1.0))
    heights = np.random.default_rng(3).normal(size=shape)
    K = HalfSpace(mean).stiffness(grid)
    columns = [grid.inverse(grid.forward(e.reshape(shape)) / K).ravel() for e in np.eye(grid.size)]
    lower = np.linalg.cholesky(np.array(columns).T)
    # min ½ p G p + offset p  =  min |L^T p + L^-1 offset|²
    exact = nnls(lower.T, -np.linalg.solve(lower, heights.ravel()))[0].reshape(shape)
    found = Solver(grid, K).constrain(heights, None, Settings(1e-13))
    scale = exact.max()
    assert scale > 1e-3
    # The stiffest mode against the softest, 1e5, times rounding of the reference.
    np.testing.assert_allclose(found.traction, exact, atol=1e-9 * scale)
    np.testing.assert_array_equal(found.traction > 0, exact > 1e-9 * scale)


def test_limit_of_a_stiff_law() -> None:
    problem = Rough(hard=True).problem()
    target = 1.0
    hard = solve(problem, "mean-gap", target, TIGHT)
    errors = []
    for k in (10.0, 100.0, 1000.0):
        wall = LennardJonesSpline(0.0, minimum_stiffness=k)
        soft = ContactProblem(problem.grid, wall, problem.heights, problem.substrate)
        state = solve(soft, "mean-gap", target + wall.zero_gap, TIGHT)
        errors.append(state.load / hard.load - 1)
    # The wall yields p/k where it presses: first order in 1/k.
    assert abs(errors[2]) < 2e-3
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.3)


# --- the same state in different ways ----------------------------------------------------------------------


def test_three_controls_agree() -> None:
    problem = Rough(hard=True).problem()
    grid = problem.grid
    held = solve(problem, "mean-gap", 0.8, TIGHT)
    pushed = at_pressure(grid, problem.heights, held.load)
    expected = held.traction
    assert np.count_nonzero(expected) > 0.01 * grid.size
    assert grid.mean(pushed.gap) == pytest.approx(0.8, abs=1e-8)
    # The residual, 1e-10, over the smallest stiffness of the grid, π/64.
    np.testing.assert_allclose(pushed.traction, expected, atol=1e-8)
    for mean in (1e-6, 0.05, 5.0):
        springy = ContactProblem(grid, HardWall(), problem.heights, HalfSpace(mean))
        separation = 0.8 - held.load / mean
        state = solve(springy, "separation", separation, TIGHT)
        assert state.status.ok
        np.testing.assert_allclose(state.traction, expected, atol=1e-8)
        forced = Solver(grid, springy.stiffness_q).constrain(
            0.3 + problem.heights, None, TIGHT, pressure=mean * (0.3 - separation)
        )
        np.testing.assert_allclose(forced.traction, expected, atol=1e-8)


def test_translation_and_transposition() -> None:
    problem = Rough(hard=True).problem()
    expected = solve(problem, "mean-gap", 0.8, TIGHT)

    def of(heights: Real) -> PathState:
        return solve(ContactProblem(problem.grid, HardWall(), heights, problem.substrate), "mean-gap", 0.8, TIGHT)

    for changed, back in [
        (np.roll(problem.heights, (5, -11), (0, 1)), lambda f: np.roll(f, (-5, 11), (0, 1))),
        (problem.heights.T, np.transpose),
        (problem.heights[::-1], lambda f: f[::-1]),
    ]:
        state = of(changed)
        np.testing.assert_array_equal(back(state.gap) == 0, expected.gap == 0)
        np.testing.assert_allclose(back(state.gap), expected.gap, atol=1e-8)


def test_threads_change_no_bit() -> None:
    problem = Rough(512, hard=True).problem(substrate=HalfSpace("free"))
    one, two = (
        Solver(problem.grid, problem.stiffness_q, threads).constrain(
            problem.heights, None, Settings(1e-5), pressure=4e-4
        )
        for threads in (1, 2)
    )
    np.testing.assert_array_equal(one.gap, two.gap)
    np.testing.assert_array_equal(one.traction, two.traction)


def test_a_path_is_reversible_and_resumes() -> None:
    problem = Rough(96, hard=True).problem()
    targets = [1.6, 1.3, 1.0, 0.7, 1.0, 1.3, 1.6]
    states = list(follow(problem, "mean-gap", targets, Settings(1e-9)))
    assert all(state.status.ok for state in states)
    for down, up in zip(states[:3], states[:3:-1], strict=True):
        np.testing.assert_allclose(up.gap, down.gap, atol=1e-7)
    # A state goes on from its gap alone.
    bare = [Solution(s.gap.copy(), Status.CONVERGED, 0.0, 0) for s in states[1:3]]
    known = [state_of(problem, "mean-gap", s.target, s.branch, one) for s, one in zip(states[1:3], bare, strict=True)]
    resumed = next(follow(problem, "mean-gap", targets[3:], Settings(1e-9), known))
    np.testing.assert_array_equal(resumed.gap, states[3].gap)


# --- how a solve ends --------------------------------------------------------------------------------------


@given(
    shape=st.tuples(st.integers(2, 40), st.integers(2, 40)),
    stretch=st.floats(0.5, 2.0),
    seed=st.integers(0, 1000),
    height=st.floats(-2.0, 1.0),
    pressure=st.floats(-5.0, 1.0),
    smooth=st.booleans(),
    warm=st.booleans(),
)
def test_any_small_surface(
    shape: tuple[int, int], stretch: float, seed: int, height: float, pressure: float, smooth: bool, warm: bool
) -> None:
    rng = np.random.default_rng(seed)
    grid = Grid(shape, (float(shape[0]), stretch * shape[1]))
    heights = rng.normal(size=shape)
    if smooth:
        heights = grid.inverse(grid.forward(heights) / (0.1 + grid.wavenumber**2))
    heights *= 10**height
    start = rng.normal(size=shape) if warm else None
    found = Solver(grid, HalfSpace("free").stiffness(grid)).constrain(
        heights, start, Settings(1e-7), pressure=10**pressure
    )
    assert found.status.ok
    assert found.residual <= 1e-7
    assert_minimum(grid, heights, found, 1e-7)


def test_the_minimum_of_a_rough_contact() -> None:
    problem = Rough(128, hard=True).problem()
    state = solve(problem, "mean-gap", 1.0, Settings(1e-8))
    assert_minimum(problem.grid, problem.heights, state.solution, 1e-8)
    p = state.traction
    contact = totals_of(problem.grid, problem.wall, state.gap, p)
    assert contact.area_rep == np.count_nonzero(p > 0) / p.size > 0.01
    assert contact.load == contact.load_rep == state.load
    assert contact.area_att == contact.load_att == contact.smallest_gap == 0
    assert set(np.unique(contact_map(problem.wall, state.gap))) == {OUT_OF_RANGE, REPULSIVE}


def test_a_layer_works_as_well() -> None:
    grid = Grid((48, 81), (48.0, 54.0))
    problem = ContactProblem(grid, HardWall(), sine(grid, 0.4, (1, 2)), Layer(12.0, 0.3, "free"))
    state = solve(problem, "mean-gap", 0.2, Settings(1e-9))
    p = state.traction
    held = -grid.inverse(problem.stiffness_q * grid.forward(problem.heights - state.gap))
    assert state.status.ok
    np.testing.assert_allclose(p - p.mean(), held, atol=1e-8)


def test_work_stays_what_was_measured() -> None:
    # Measured: 9 iterations on the finest grid, 30 pairs on all.
    grid = Grid.square(512)
    heights = SelfAffine(0.8, 0.1, 32.0, 256.0).synthesise(grid, np.random.default_rng(1))
    found = at_pressure(grid, heights, 4e-4, 1e-7)
    assert found.iterations <= 10
    assert found.fft_pairs <= 35
    assert found.gap_error < 1e-8


@pytest.mark.parametrize("most", [np.inf, 0.3])
@pytest.mark.parametrize("mean", [0.0, 0.05, np.inf])
def test_the_energy_that_is_followed_is_that_of_the_state(mean: float, most: float) -> None:
    """Step by step, cut by the bound or not; it falls to that of the dual, and by what each step says."""
    grid = Grid((30, 44), (30.0, 66.0))
    heights, K = np.random.default_rng(3).normal(size=grid.shape), HalfSpace("free").stiffness(grid)
    bound = CompiledBoundGrid(grid, K, 1, 128)
    bound.set_problem(heights, None, lift=0.5, sink=0.0, mean_stiffness=mean, most=most)
    dual = _Dual(bound, 0.05, mean)
    dual.cascade(Settings(1e-8), ())
    dual.energy, size = bound.displace()
    followed = [dual.energy]
    for _ in range(6):
        dual.history.clear()
        dual._iterate(0.0, 1)  # one step from steepest descent, and the next one's start
        fresh, size = bound.displace()
        assert dual.energy == pytest.approx(fresh, abs=1e-12 * size)
        followed.append(fresh)
    assert np.all(np.diff(followed) < 0)
    p, z, offset = (each[:, : grid.shape[1]] for each in (bound.p, bound.z, bound.offset))
    assert followed[-1] == pytest.approx(np.mean(p * (z + offset)) / 2, rel=1e-12)


@pytest.mark.parametrize(
    ("mean_stiffness", "total", "offset", "done"),
    [
        (0.0, np.nan, -0.5, ["fill 0.1"]), (0.0, 0.0, -0.5, ["fill 0.1"]), (0.0, 0.5, -0.5, ["scale 1"]),
        (0.0, 9.0, -0.5, ["scale 1", "fill 0.1"]), (2.0, 0.0, -0.5, ["fill 0.3"]), (2.0, 0.0, -0.1, ["fill 0.2"]),
        (2.0, 0.0, 0.5, ["fill 0"]), (2.0, 0.5, -0.5, []), (np.inf, 0.0, -0.5, []),
        (np.inf, np.nan, -0.5, ["fill 0.3"]),
    ],
)  # fmt: skip
def test_a_start_carries_the_load_that_is_given_or_that_of_flat_surfaces(
    mean_stiffness: float, total: float, offset: float, done: list[str]
) -> None:
    """Of ten points under 0.1, at most 0.3; the load of a spring of the mean is what flat surfaces overlap by."""
    said = list[str]()

    def scale(wanted: float) -> bool:
        said.append(f"scale {wanted:g}")
        return total < 9

    grid = SimpleNamespace(
        size=10, most=0.3, mean_offset=lambda: offset, fill=lambda p: said.append(f"fill {p:g}"), scale=scale
    )
    _Dual(grid, 0.1, mean_stiffness)._carry_the_load(total)
    assert said == done


def test_along_a_direction_without_curvature_there_is_no_step() -> None:
    grid = SimpleNamespace(curvature=lambda: 0.0, trial=lambda step: (0.0, step, step))
    assert np.isnan(_Dual(grid, 0.05, 0.0)._step(1.0))


def test_a_state_is_as_good_as_the_worst_of_what_it_misses() -> None:
    """Residual, error of the gap, and duality gap over that which a residual of the tolerance leaves."""
    tolerance, gap, scale = 1e-3, 1e-2, 0.5
    for missed, excess in (
        ((3e-3, 2e-2, 1e-3), 3.0), ((1e-3, 4e-2, 1e-3), 4.0), ((1e-3, 1e-2, 2.5e-3), 5.0), ((5e-4, 1e-3, -1.0), 0.5),
    ):  # fmt: skip
        assert _Outcome(*missed, scale).excess(tolerance, gap) == pytest.approx(excess)


def test_no_contact_is_an_equilibrium_without_load() -> None:
    problem = Rough(hard=True).problem()
    away = -problem.heights.min() + 0.1
    for start in (None, np.full(problem.grid.shape, away)):
        state = solve(problem, "separation", away, TIGHT, start)
        assert state.status.ok
        assert state.load == 0
        np.testing.assert_allclose(state.gap, away + problem.heights, atol=1e-12)


def test_what_a_hard_wall_cannot_do_is_refused() -> None:
    problem = Rough(16, hard=True).problem()
    free = HalfSpace("free").stiffness(problem.grid)
    with pytest.raises(ValueError, match="only pushes"):
        Solver(problem.grid, free).constrain(problem.heights, None, TIGHT, pressure=-1e-3)
    # Without load the undeformed surface just touches.
    rest = Solver(problem.grid, free).constrain(problem.heights, None, TIGHT, pressure=0.0)
    np.testing.assert_allclose(rest.gap, problem.heights - problem.heights.min(), atol=1e-300)
    assert not rest.traction.any()
    for target in (0.0, -0.1):
        with pytest.raises(ValueError, match="positive"):
            solve(problem, "mean-gap", target, TIGHT)
    with pytest.raises(TypeError, match="traction"):
        problem.wall.evaluate(problem.heights)


def test_unfinished_is_said() -> None:
    problem = Rough(hard=True).problem()
    limited = solve(problem, "mean-gap", 0.8, Settings(1e-10, max_iterations=2))
    assert limited.status is Status.ITERATION_LIMIT
    assert np.isfinite(limited.gap).all()
    impossible = solve(problem, "mean-gap", 0.8, Settings(1e-20, max_iterations=300))
    assert not impossible.status.ok
    solver = Solver(problem.grid, problem.stiffness_q)
    for bad in (np.full(problem.grid.shape, np.nan), np.full(problem.grid.shape, np.inf)):
        assert solver.constrain(problem.heights, bad, TIGHT, lift=1.0).status is Status.NON_FINITE


@pytest.mark.parametrize(("control", "target"), [("mean-pressure", 3e-3), ("mean-gap", 0.5)])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_the_duality_gap_bounds_the_error_of_the_energy(control: Control, target: float, tolerance: float) -> None:
    """Energy of the dual, ½ <p, G p> + <p, h>, against that of the exact state of the same load; and it is required."""
    problem = Rough(48, lambda_s=8.0, hard=True).problem()
    found = solve(problem, control, target, Settings(tolerance)).solution
    load = problem.grid.mean(found.traction)
    exact = solve(problem, "mean-pressure", load, Settings(1e-12)).solution

    def energy(pressure: Real) -> float:
        p_q, K = problem.grid.forward(pressure), problem.stiffness_q.copy()
        K[0, 0] = np.inf  # a given load: its mean mode is the same in both
        elastic = 0.5 * problem.grid.inner_q(p_q, p_q / K)
        return elastic + problem.grid.mean(pressure * problem.heights)

    error = energy(found.traction) - energy(exact.traction)
    assert -1e-15 <= error <= found.duality_gap
    assert exact.duality_gap < 1e-5 * found.duality_gap
    softness = np.divide(
        1.0, problem.stiffness_q, out=np.zeros_like(problem.stiffness_q), where=problem.stiffness_q > 0
    )
    softness[0, 0] = 0.0
    allowed = 2 * load * tolerance * np.sqrt((softness**2 * problem.grid.mode_weights).sum())
    assert 0 < found.duality_gap <= allowed
