"""The seam: another back end finds the same states, and one set of arrays serves any number of problems."""

from __future__ import annotations

import ast
import inspect
import os
import subprocess
import sys
from itertools import pairwise
from types import ModuleType

import numpy as np
import pytest

from continuum.model.fourier import Real, padded
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.solve import conjugate, hard, smooth
from continuum.solve.arrays.smooth_grid import ArrayLinearGrid
from continuum.solve.backend import back_end, factor_of
from continuum.solve.compiled.bound_grid import CompiledBoundGrid as BoundGrid
from continuum.solve.compiled.contact_fields import runs
from continuum.solve.compiled.corrections import TiledSmoothGrid as SmoothGrid
from continuum.solve.compiled.linear import CompiledLinearGrid
from continuum.solve.compiled.passes import Passes
from continuum.solve.solution import Settings, Solution, Status
from continuum.solve.solver import Solver
from tests.kinds import covering


def heights(n: int) -> Real:
    return SelfAffine(0.8, 0.1, 8.0, n / 4).synthesise(Grid.square(n), np.random.default_rng(1))


def solver(n: int, device: str = "cpu", threads: int = 1) -> Solver:
    grid = Grid.square(n)
    return Solver(grid, HalfSpace("clamped").stiffness(grid), threads, device)


def same(one: Solution, other: Solution) -> None:
    """Bit for bit."""
    np.testing.assert_array_equal(one.gap, other.gap)
    np.testing.assert_array_equal(one.traction, other.traction)
    assert [w[:3] for w in one.work] == [w[:3] for w in other.work]
    assert one.history == other.history
    assert (one.status, one.residual) == (other.status, other.residual)


# --- whole arrays -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("adhesion_length", "start"), covering([0.0, 0.005], [False, True]))
def test_a_grid_in_plain_numpy_finds_the_same_state(
    adhesion_length: float, start: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Coarse steps in single precision would round differently.
    monkeypatch.setattr(back_end("cpu"), "PRECISION", np.float64)
    monkeypatch.setattr(back_end("numpy"), "PRECISION", "float64")
    law, h = LennardJonesSpline(adhesion_length=adhesion_length).law, heights(256)
    first = h + 2.5 if start else None
    found = [
        each.minimise(law, h, first, Settings(1e-8), lift=2.3, mean_stiffness=np.inf)
        for each in (solver(256), solver(256, "numpy"))
    ]
    assert all(each.status.ok for each in found)
    assert np.count_nonzero(found[0].gap < 1) > 100
    # The same iteration, step by step, but for rounding, which grows from 1e-14 to 1e-10 in 18 steps.
    assert found[0].iterations == found[1].iterations
    np.testing.assert_allclose(*([line.step for line in each.history] for each in found), rtol=1e-8)
    assert found[0].sweeps == found[1].sweeps
    np.testing.assert_allclose(found[0].gap, found[1].gap, atol=1e-13)


def test_so_it_does_where_no_step_of_a_coarser_grid_descends(monkeypatch: pytest.MonkeyPatch) -> None:
    for kind in (CompiledLinearGrid, ArrayLinearGrid):
        monkeypatch.setattr(kind, "relax", lambda *given, relax=kind.relax: relax(*given) and False)
    law, h = LennardJonesSpline(adhesion_length=0.0).law, heights(256)
    one, other = (
        solver(256, device).minimise(law, h, h + 2.5, Settings(1e-8, 4), lift=2.3, mean_stiffness=np.inf)
        for device in ("cpu", "numpy")
    )
    # Steps along the preconditioned gradient, to rounding.
    assert one.iterations == other.iterations == 4
    np.testing.assert_allclose(one.history, other.history, rtol=1e-8)


@pytest.mark.parametrize(("kind", "levels", "held"), covering([np.float32, np.float64], [1, 2], [False, True]))
def test_a_step_of_a_coarser_grid_leaves_less_of_the_residual(
    held: bool, levels: int, kind: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a linear problem of 256 x 128 points, a twentieth of them in contact, with and without a coarser grid."""
    monkeypatch.setattr(conjugate, "COARSE_REDUCTION", 1e-9)
    grid = Grid((512, 256), (512.0, 256.0))
    K = HalfSpace("clamped").stiffness(grid)
    random = np.random.default_rng(3)
    residual_q = np.fft.rfft2(random.normal(size=(256, 128))) / 2**15
    contact = random.random((256, 128)) < 0.05
    made = SmoothGrid(grid, K, 1, 64, kind, 2).linear
    assert made is not None
    assert made.linear is not None
    for each in made.chain:
        each.set_mean_stiffness(1.0 if held else 0.2, held=held)
    made.g.view(np.result_type(kind, np.complex64))[:, :65] = residual_q
    made.g[0, :2] = 0.0
    made.stiffness[:, :128] = 0.5 * contact
    assert made.relax(levels, 0.01, conjugate.COARSE_ITERATIONS, conjugate.COARSE_REDUCTION)
    found = made.x.view(np.result_type(kind, np.complex64))[:, :65].copy()
    assert made.transforms == 2 * conjugate.COARSE_ITERATIONS
    # It is a step down: of the residual there is less than before.
    u = np.fft.irfft2(found * 2**15, s=(256, 128))
    stiffness_q = HalfSpace("clamped").stiffness(Grid((256, 128), (512.0, 256.0)))
    stiffness_q[0, 0] = 0.0 if held else 0.2
    left_q = residual_q + stiffness_q * found + np.fft.rfft2(0.5 * contact * u) / 2**15
    left_q[0, 0] = residual_q[0, 0] = 0.0
    assert np.linalg.norm(left_q) < 0.5 * np.linalg.norm(residual_q)


@pytest.mark.parametrize(
    ("posed", "start"),
    covering(
        [(np.inf, 0.0, np.inf), (0.05, 0.1, np.inf), (0.0, 0.01, 0.05)],
        [False, True],
    ),
)
def test_the_same_holds_under_a_bound(posed: tuple[float, float, float], start: bool) -> None:
    mean, pressure, most = posed
    h = heights(256)
    first = np.maximum(h + 1.2, 0.0) if start else None
    given = {"lift": 1.0, "pressure": pressure, "mean_stiffness": mean, "most": most}
    found = [each.constrain(h, first, Settings(1e-8), **given) for each in (solver(256), solver(256, "numpy"))]
    assert all(each.status.ok for each in found)
    assert found[0].iterations == found[1].iterations
    np.testing.assert_allclose(found[0].traction, found[1].traction, atol=1e-12)
    np.testing.assert_array_equal(found[0].gap == 0, found[1].gap == 0)
    assert np.count_nonzero(found[0].gap == 0) > 100


def test_a_residual_leaves_no_larger_duality_gap_than_its_scale_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """2 <p> sqrt(Σ 1/K²) over q ≠ 0.  A smaller scale costs iterations only, so that states do not show it."""
    gaps, evaluate = list[tuple[float, float]](), BoundGrid.duality_gap

    def noted(grid: BoundGrid) -> tuple[float, float]:
        gaps.append(evaluate(grid))
        return gaps[-1]

    monkeypatch.setattr(BoundGrid, "duality_gap", noted)
    given = {"pressure": 0.01, "mean_stiffness": 0.0}
    pressure = solver(64).constrain(heights(64), None, Settings(1e-8), **given).traction
    assert pressure.mean() == pytest.approx(0.01)
    grid = Grid.square(64)
    K, weights = HalfSpace("clamped").stiffness(grid), np.broadcast_to(grid.mode_weights, grid.shape_q)
    softness = weights.ravel()[1:] / K.ravel()[1:] ** 2
    assert gaps[-1][1] == pytest.approx(2 * pressure.mean() * np.sqrt(softness.sum()), rel=1e-9)


def test_only_rows_that_press_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """All are at the beginning.  A row that is marked for nothing costs time only, so that states do not show it."""
    looked, hand_out = list[Real](), BoundGrid.hand_out

    def noted(grid: BoundGrid, level: float) -> tuple[Real, Real]:
        looked.append(grid.touched.any(axis=1))
        return hand_out(grid, level)

    monkeypatch.setattr(BoundGrid, "hand_out", noted)
    found = solver(64).constrain(heights(64), heights(64) + 2.0, Settings(1e-8), pressure=1e-3, mean_stiffness=0.0)
    presses = (found.traction > 0).any(axis=1)
    np.testing.assert_array_equal(looked[-1], presses)
    assert 0 < presses.sum() < 48


def test_a_device_that_there_is_not_is_said_and_none_is_imported_early() -> None:
    with pytest.raises(ValueError, match=r"'abacus'.*cpu"):
        solver(8, "abacus")
    # Nor is what takes a third of the time that an input needs to be read, and only a table of a wall uses.
    late = "{'continuum.solve.compiled.back_end', 'scipy.interpolate'}"
    code = f"import sys, continuum.solve.solver, continuum.store.runs.config; assert not {late} & sys.modules.keys()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("module", [smooth, conjugate, hard])
def test_the_mathematics_sees_scalars_only(module: ModuleType) -> None:
    """Of NumPy it uses what a scalar needs, a field without memory, and the test of six sums."""
    source = inspect.getsource(module)
    used = {
        node.attr
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np"
    }
    assert used <= {"inf", "nan", "sqrt", "isfinite", "isinf", "broadcast_to"}


# --- arrays that live as long as a path --------------------------------------------------------------------


def test_a_solver_does_not_remember_its_last_problem() -> None:
    n, tight = 256, Settings(1e-8)
    h, law, other = heights(n), LennardJonesSpline(0.3).law, LennardJonesSpline(0.0).law
    once = solver(n)
    held = {"lift": 2.0, "mean_stiffness": np.inf}
    cold = once.minimise(law, h, None, tight, **held)
    again = {"lift": 1.8, "mean_stiffness": np.inf}
    warm = once.minimise(law, h, cold.gap, tight, **again)
    same(warm, solver(n).minimise(law, h, cold.gap, tight, **again))
    # Failures of all kinds, another law, another mean mode; then the first problem.
    lost = once.minimise(law, h, np.full(h.shape, np.nan), tight)
    assert lost.status is Status.NON_FINITE
    kept = cold.gap.copy()
    far = once.minimise(law, h, 1e200 * np.random.default_rng(1).normal(size=h.shape), tight, **held)
    assert not far.status.ok
    pressed = once.minimise(other, h, None, tight, lift=2.0, pressure=1e-3, mean_stiffness=0.0)
    assert pressed.status.ok
    assert once.minimise(law, h, None, Settings(1e-30, 3), **held).status is Status.ITERATION_LIMIT
    same(once.minimise(law, h, None, tight, **held), cold)
    # What was handed out is not written to.
    np.testing.assert_array_equal(cold.gap, kept)


def test_nor_does_it_under_a_bound() -> None:
    n, tight = 256, Settings(1e-9)
    h, once = heights(n), solver(256)
    held = {"lift": 1.0, "mean_stiffness": np.inf}
    cold = once.constrain(h, None, tight, **held)
    kept = cold.gap.copy(), cold.traction.copy()
    pressed = once.constrain(h, cold.gap, tight, pressure=2e-3, mean_stiffness=0.0)
    same(pressed, solver(n).constrain(h, cold.gap, tight, pressure=2e-3, mean_stiffness=0.0))
    assert once.constrain(h, np.full(h.shape, np.nan), tight).status is Status.NON_FINITE
    with pytest.raises(ValueError, match="mean gap"):
        once.constrain(h, None, tight, lift=-9.0, mean_stiffness=np.inf)
    assert once.constrain(h, None, Settings(1e-30, 2), **held).status is Status.ITERATION_LIMIT
    same(once.constrain(h, None, tight, **held), cold)
    np.testing.assert_array_equal(cold.gap, kept[0])
    np.testing.assert_array_equal(cold.traction, kept[1])


@pytest.mark.parametrize("bound", [False, True])
@pytest.mark.parametrize("solved", [False, True])
def test_the_elastic_energy_is_found_between_two_problems(bound: bool, solved: bool) -> None:
    grid, once, h = Grid.square(64), solver(64), heights(64)
    gap = h + np.random.default_rng(2).normal(size=h.shape)
    if solved:
        found = (
            once.constrain(h, None, Settings(1e-6), lift=3.0)
            if bound
            else once.minimise(LennardJonesSpline(0.3).law, h, None, Settings(1e-6), lift=3.0)
        )
        gap = found.gap
    u_q = grid.forward(h - gap)
    power = u_q.real**2 + u_q.imag**2
    K = HalfSpace("free").stiffness(grid)
    found = Solution(gap, Status.CONVERGED, 0.0, 0)
    assert once.elastic_energy(h, found) == pytest.approx(0.5 * np.sum(power * K * grid.mode_weights), rel=1e-13)


# --- the passes of processor cores -------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(64, 64), (256, 256), (500, 300), (301, 257), (1024, 512)])
def test_threads_change_no_bit_of_a_transform(shape: tuple[int, int]) -> None:
    grid = Grid(shape, (1.0, 1.0))
    values = np.random.default_rng(1).normal(size=shape)
    spectrum, field = grid.forward(values), padded(shape)
    back = grid.inverse(spectrum)
    for threads in (1, 2, 3, 4):
        passes = Passes(grid, np.ones(grid.shape_q), threads)
        passes.forward(values)
        np.testing.assert_array_equal(passes.work_q, spectrum)
        passes.inverse(field)
        np.testing.assert_array_equal(field, back)


def test_nor_where_libraries_may_use_threads_of_their_own() -> None:
    """In an environment without OMP_NUM_THREADS, which `make test` sets: ducc0's own threads obey it, and then
    a test of threads tests one."""
    code = (
        "import numpy as np; from continuum.model.grid import Grid\n"
        "from continuum.solve.compiled.passes import Passes\n"
        "values = np.random.default_rng(1).normal(size=(512, 300)); grid = Grid((512, 300), (1.0, 1.0))\n"
        "found = [grid.forward(values)]\n"
        "for threads in (1, 2, 4):\n"
        "    passes = Passes(grid, np.ones(grid.shape_q), threads); passes.forward(values)\n"
        "    found.append(passes.work_q)\n"
        "assert all(np.array_equal(one, found[0]) for one in found)"
    )
    free = {name: value for name, value in os.environ.items() if not name.endswith("NUM_THREADS")}
    done = subprocess.run([sys.executable, "-c", code], env=free, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("at", [1e-6, 0.3, 1.0, 7.0, 1e20, 0.9e30])
def test_a_factor_is_where_what_grows_with_it_vanishes(at: float) -> None:
    assert factor_of(lambda factor: factor / at - 1) == pytest.approx(at, rel=1e-12)
    assert factor_of(lambda factor: min(factor / at, 0.5) - 1) is None  # it saturates below
    assert factor_of(lambda factor: factor / at + 1) is None  # too much without any
    assert factor_of(lambda factor: factor / at) == 0.0


def test_runs_of_rows_begin_and_end_where_use_changes() -> None:
    rng = np.random.default_rng(1)
    for share in (0.0, 0.3, 0.7, 1.0):
        used = rng.random(20) < share
        found = runs(used, 100)
        marked = np.zeros(20, dtype=bool)
        for first, last in found:
            assert first < last
            marked[first - 100 : last - 100] = True
        np.testing.assert_array_equal(marked, used)
        assert all(one[1] < other[0] for one, other in pairwise(found))
