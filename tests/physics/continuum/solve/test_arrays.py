"""The grids of whole arrays: what compiled ones find, on every library, and what an iteration would cost a GPU."""

from __future__ import annotations

import importlib
import tracemalloc
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from continuum.inputs.errors import InputError
from continuum.model import laws
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.substrates.non_periodic import OpenBoundary
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.solve.arrays import back_end as arrays
from continuum.solve.arrays import passes
from continuum.solve.arrays.bound_grid import ArrayBoundGrid
from continuum.solve.arrays.library import LIBRARIES, CuPy, Jax, Library, NumPy, Torch
from continuum.solve.arrays.smooth_grid import ArraySmoothGrid
from continuum.solve.backend import BACK_ENDS, back_end
from continuum.solve.non_periodic import NonPeriodicSolver
from continuum.solve.solution import Settings, Solution, Status
from continuum.solve.solver import Solver
from tests.physics.continuum.model.test_consistency import RESPONSES, WALLS

CHOSEN = {
    "numpy": NumPy,
    "array_api_strict": lambda: Library(importlib.import_module("array_api_strict")),
    "torch": partial(Torch, "cpu"),
    "jax": partial(Jax, "cpu"),
    "torch:cuda": partial(Torch, "cuda"),
    "cupy": CuPy,
    "jax:gpu": partial(Jax, "gpu"),
}
LONG = ("jax", "torch:cuda", "cupy", "jax:gpu")
"""A minute of compilation, or a GPU that few machines have."""
pytestmark = pytest.mark.filterwarnings("ignore:`torch.jit:DeprecationWarning")  # of PyTorch's own compiler
HELD = {"lift": 2.0, "mean_stiffness": np.inf}


@pytest.fixture(params=[pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in CHOSEN])
def library(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Library:
    """Each library that is installed, with a GPU where it needs one, as the device "numpy"."""
    pytest.importorskip(request.param.partition(":")[0])
    try:
        made: Library = CHOSEN[request.param]()
    except Exception as error:  # each library has its own
        pytest.skip(f"{request.param}: {error}")
    monkeypatch.setitem(vars(back_end("numpy")), "library", made)
    return made


@pytest.fixture
def alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """Linear problems in double precision, which round alike, and coarser grids down to 16 points."""
    for device, kind in (("cpu", np.float64), ("numpy", "float64")):
        monkeypatch.setattr(back_end(device), "PRECISION", kind)
        monkeypatch.setattr(back_end(device), "SMALLEST", 16)


def heights(grid: Grid) -> Real:
    longest = min(n for n in grid.lengths if n > 1) / 4
    return SelfAffine(0.8, 0.1, 8.0, longest).synthesise(grid, np.random.default_rng(1))


def both(find: Callable[[str], Solution]) -> None:
    """The same state in the same number of iterations, gaps to 1e-10 a0: rounding grows from 1e-15 in a solve."""
    compiled, plain = find("cpu"), find("numpy")
    assert compiled.status is plain.status is Status.CONVERGED
    assert compiled.iterations == plain.iterations > 1
    np.testing.assert_allclose(plain.gap, compiled.gap, atol=1e-10)
    np.testing.assert_allclose(plain.traction, compiled.traction, atol=1e-10)
    np.testing.assert_array_equal(plain.gap == 0, compiled.gap == 0)


# --- laws ------------------------------------------------------------------------------------------------------


def test_a_law_is_that_of_compiled_code(library: Library) -> None:
    for wall in WALLS.values():
        law = wall.law
        gap = np.concatenate([np.linspace(-1.0, 3.0, 2000), law.parameters[1:-1], [1.0, 0.0, 50.0]]).reshape(1, -1)
        there = passes.DeviceLaw.on(library, law)
        formula = library.compile(partial(there.formula, library.xp))
        found = formula(library.put(gap), there.parameters)
        for one, other in zip(found, laws.evaluate(law, gap), strict=True):
            # A few roundings of the largest of the terms that cancel.
            np.testing.assert_allclose(library.get(one), other, rtol=1e-12, atol=1e-14 * np.abs(other).max())


def test_every_kind_of_law_was_looked_at() -> None:
    kinds = {wall.law.kind for wall in WALLS.values()}
    assert kinds == {*laws.ON_ARRAYS, laws.INVERSE_POWERS}
    assert len(kinds) == 1 + max(kinds) == 4


# --- states ----------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("alike")
@pytest.mark.parametrize("name", WALLS)
def test_the_state_under_every_law_is_that_of_compiled_sweeps(name: str) -> None:
    wall, grid = WALLS[name], Grid((64, 32), (64.0, 40.0))
    K, h = HalfSpace("clamped").stiffness(grid), heights(grid)
    # The stiffest snaps in at each summit, in hundreds of iterations which rounding decides: not so pressed flat.
    lift = wall.zero_gap + (-0.3 if name == "stiff" else 0.2)
    posed = {"lift": lift, "mean_stiffness": np.inf}
    both(lambda device: Solver(grid, K, 1, device).minimise(wall.law, h, None, Settings(1e-8), **posed))


ODD = (33, 35)
"""The smallest of the grids on which states are compared."""


@pytest.mark.usefixtures("alike")
@pytest.mark.parametrize(
    ("name", "shape"),
    [*((name, ODD) for name in RESPONSES), ("half-space", (1, 128)), ("half-space, free", (64, 64))],
)
def test_so_it_is_on_every_substrate(name: str, shape: tuple[int, int]) -> None:
    """A substrate is its stiffnesses, those of the means apart: of a finite and an infinite one on other grids too."""
    grid = Grid(shape, (float(shape[0]), float(shape[1])))
    K, law, h = RESPONSES[name](grid).stiffness(grid), LennardJonesSpline(0.3).law, heights(grid)
    mean = {"mean_stiffness": max(float(K[0, 0]), 0.05)}
    soft, hard = {"lift": 1.2, "pressure": 0.02, **mean}, {"lift": 0.3, "pressure": 0.05, **mean}
    both(lambda device: Solver(grid, K, 1, device).minimise(law, h, None, Settings(1e-8), **soft))
    both(lambda device: Solver(grid, K, 1, device).constrain(h, h + 0.5, Settings(1e-8), **hard))
    if name.startswith("half-space"):
        both(lambda device: Solver(grid, K, 1, device).constrain(h, None, Settings(1e-8), **hard, most=0.1))


@pytest.mark.usefixtures("alike")
def test_so_it_is_without_periodic_images() -> None:
    window = Grid.square(32)
    boundary, law, h = OpenBoundary(window), LennardJonesSpline(0.3).law, heights(window)

    def solver(device: str) -> NonPeriodicSolver:
        return NonPeriodicSolver(boundary, 1, device)

    both(lambda device: solver(device).minimise(law, h, None, Settings(1e-8), lift=1.2))
    both(lambda device: solver(device).minimise(law, h, h + 1.0, Settings(1e-8), lift=1.2))
    both(lambda device: solver(device).constrain(h, None, Settings(1e-8), pressure=0.01, mean_stiffness=0.0))


@pytest.mark.usefixtures("alike")
def test_a_library_finds_what_numpy_does(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    grid = Grid((64, 32), (64.0, 32.0))
    K, h, law = HalfSpace("clamped").stiffness(grid), heights(Grid((64, 32), (64.0, 32.0))), LennardJonesSpline(0.3).law

    def found() -> list[Solution]:
        solver = Solver(grid, K, 1, "numpy")
        # One set of arrays, and a problem that fails in between.
        first = solver.minimise(law, h, None, Settings(1e-8), **HELD)
        assert not solver.minimise(law, 1e200 * h, None, Settings(1e-8), **HELD).status.ok
        again = solver.minimise(law, h, first.gap, Settings(1e-8), **HELD | {"lift": 1.9})
        pressed = solver.constrain(h, None, Settings(1e-8), pressure=0.01, mean_stiffness=0.0, most=0.05)
        energy = solver.elastic_energy(h, pressed)
        assert energy == pytest.approx(Solver(grid, K).elastic_energy(h, pressed), rel=1e-12)
        return [first, again, pressed]

    here = found()
    monkeypatch.setitem(vars(back_end("numpy")), "library", NumPy())
    for one, other in zip(here, found(), strict=True):
        assert one.status is other.status is Status.CONVERGED
        assert one.iterations == other.iterations
        np.testing.assert_allclose(one.gap, other.gap, atol=1e-12)


def test_linear_problems_in_single_precision_lead_to_the_same_state(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step of a coarser grid is a direction only: rounding it costs an iteration at most, and no accuracy."""
    grid, law, found = Grid.square(128), LennardJonesSpline(0.3).law, []
    K, h = HalfSpace("clamped").stiffness(grid), heights(grid)
    monkeypatch.setattr(back_end("numpy"), "SMALLEST", 32)
    for kind in ("float32", "float64"):
        monkeypatch.setattr(back_end("numpy"), "PRECISION", kind)
        solver = Solver(grid, K, 1, "numpy")
        found.append(solver.minimise(law, h, None, Settings(1e-9), **HELD).require())
        assert solver._smooth.linear.x.dtype == kind
    assert abs(found[0].iterations - found[1].iterations) <= 1
    # Residuals of 1e-9 E* over the softest wave, K = 0.02 E*/a0, leave so much.
    np.testing.assert_allclose(found[0].gap, found[1].gap, atol=1e-7)


def test_a_coarse_step_that_is_replayed_counts_as_one_that_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    grid, law = Grid.square(64), LennardJonesSpline(0.3).law
    K, h = HalfSpace("clamped").stiffness(grid), heights(grid)
    monkeypatch.setattr(back_end("numpy"), "SMALLEST", 16)

    def replayed(library: Library, function: Any) -> Callable[..., Any]:
        calls = []

        def run(*given: Any) -> Any:
            found = function(*given)
            calls.append(given)
            if len(calls) > 1:
                for each in function.func.__self__.chain:
                    each.transforms = 0
            return found

        return run

    made = Solver(grid, K, 1, "numpy").minimise(law, h, None, Settings(1e-8), **HELD)
    monkeypatch.setattr(NumPy, "recorded", replayed)
    solver = Solver(grid, K, 1, "numpy")
    assert solver.minimise(law, h, None, Settings(1e-8), **HELD).work == made.work
    # Another K is another recording.
    free = {"lift": 2.0, "mean_stiffness": 0.1}
    again = solver.minimise(law, h, made.gap, Settings(1e-8), **free)
    np.testing.assert_array_equal(
        again.gap, Solver(grid, K, 1, "numpy").minimise(law, h, made.gap, Settings(1e-8), **free).gap
    )


# --- cost ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bound", [False, True])
def test_a_solve_needs_no_more_memory_than_is_reserved(bound: bool) -> None:
    grid, law = Grid.square(256), LennardJonesSpline(0.3).law
    h, solver = heights(grid), Solver(grid, HalfSpace("free").stiffness(grid), 1, "numpy")
    tracemalloc.start()
    try:
        if bound:
            fields, found = ArrayBoundGrid.FIELDS, solver.constrain(h, None, Settings(1e-3), pressure=0.01)
        else:
            fields, found = ArraySmoothGrid.FIELDS, solver.minimise(law, h, None, Settings(1e-3), lift=2.0)
        peak = tracemalloc.get_traced_memory()[1] / (8 * grid.size)
    finally:
        tracemalloc.stop()
    assert found.status.ok
    # NumPy keeps every intermediate of a pass, which a library that fuses does not.
    assert 0.6 * fields < peak < 1.5 * fields


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """PyTorch with a count of what passes over memory, is launched and is read by the host."""
    pytest.importorskip("torch")
    counting = importlib.import_module("tests.physics.continuum.solve.counting")
    library = counting.Counted()
    monkeypatch.setitem(vars(back_end("torch")), "library", library)
    monkeypatch.setattr(back_end("torch"), "SMALLEST", 64)
    return library


@pytest.mark.parametrize(("kind", "most"), [("float64", 100), ("float32", 72)])
def test_an_iteration_with_three_grids_makes_few_passes_over_memory(
    counted: Any, kind: str, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In units of n² numbers in double precision, at 256² with 128² and 64²; the same at any n.

    A function that the library fuses reads what it is given and writes what it returns once; each of two halves of a
    transform does.  Bounds are what was counted, and a line search more than usual; 120 were allowed, and ten reads.
    """
    monkeypatch.setattr(back_end("torch"), "PRECISION", kind)
    grid, law = Grid.square(256), LennardJonesSpline(adhesion_length=0.005).law
    h, solver = heights(grid), Solver(grid, HalfSpace("clamped").stiffness(grid), 1, "torch")
    found = []
    for iterations in (2, 6):
        with counted.counting(grid.size) as count:
            settings = Settings(1e-30, iterations, warm_grids=0)
            done = solver.minimise(law, h, h + 2.5, settings, lift=2.3, mean_stiffness=np.inf)
        pairs = sum(each.fft_pairs * np.prod(each.shape) for each in done.work) / grid.size
        found.append(np.array([count.passes, count.launches, count.reads, pairs]))
    passes, launches, reads, pairs = (found[1] - found[0]) / 4
    assert pairs == pytest.approx(3.0)
    assert 40 < passes < most
    assert 50 < launches < 250
    assert 3 < reads <= 10


# --- devices ---------------------------------------------------------------------------------------------------


def test_a_device_is_a_name_and_what_it_lacks_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert {*LIBRARIES, "cuda", "cpu"} == set(BACK_ENDS)
    with pytest.raises(InputError, match=r"stickiness\[cupy\]|cannot be used here"):
        arrays.found("cupy")
    with pytest.raises(InputError, match=r"\"torch:cuda\" (needs torch, which|cannot be used)"):
        arrays.found("torch:cuda")
    monkeypatch.setattr(arrays, "CUDA", ())
    with pytest.raises(InputError, match=r"needs a GPU with its driver.*stickiness\[torch\]"):
        arrays.found("cuda")


def test_cuda_is_the_first_library_that_sees_a_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    def blind() -> Library:
        raise RuntimeError("no device")

    monkeypatch.setattr(arrays, "CUDA", (blind, NumPy, blind))
    assert isinstance(arrays.found("cuda"), NumPy)


def test_a_grid_that_does_not_fit_is_said_before_it_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(NumPy, "free_memory", lambda library: 1e6)
    grid = Grid.square(256)
    solver = Solver(grid, HalfSpace("clamped").stiffness(grid), 1, "numpy")
    with pytest.raises(MemoryError, match=r"of which 0\.0 GiB are free"):
        solver.minimise(LennardJonesSpline(0.3).law, np.zeros(grid.shape), None, Settings(1e-6))
    with pytest.raises(MemoryError, match=r"needs 0\.0 GiB"):
        solver.constrain(np.zeros(grid.shape), None, Settings(1e-6))


def test_a_process_may_be_given_one_gpu_of_several(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(NumPy, "devices", lambda library: range(2))
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    assert back_end("numpy").devices() == ("0", "1")
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "3, 5")
    assert back_end("numpy").devices() == ("3", "5")
