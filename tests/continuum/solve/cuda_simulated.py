"""The back end for GPUs without a GPU: collected by `test_cuda.py` only, in a process with NUMBA_ENABLE_CUDASIM=1.

Each kernel beside its twin for processor cores or a line of NumPy, and whole solves beside the CPU's.  The simulator's
threads wait by polling, which takes minutes: by default the same functions run one thread after the other, some of them
in the simulator, with STICKINESS_IN_SIMULATOR=1 (a long test) all.
"""

from __future__ import annotations

import os
import re
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import cuda as numba_cuda

from continuum.cli import main
from continuum.model.fourier import prolong, restrict
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import Exponential, InversePowers, LennardJonesSpline
from continuum.model.walls.tabulated import TabulatedWall
from continuum.runs.result import Result
from continuum.solve import backend, cpu, cuda
from continuum.solve.bound_grid import BoundGrid
from continuum.solve.cpu.engine import KERNELS as SWEEPS
from continuum.solve.cuda import device, extending, points, pressing, spectra, transforms, walls
from continuum.solve.cuda.device import Kernel, Reduction, to_device
from continuum.solve.cuda.engine import KERNELS
from continuum.solve.smooth_grid import SmoothGrid
from continuum.solve.solution import Settings, Solution
from continuum.solve.solver import Solver
from tests.continuum.solve.plain import hats

IN_SIMULATOR = bool(os.environ.get("STICKINESS_IN_SIMULATOR"))
"""Run all of it in numba's simulator, with its threads."""
SHAPES = ((8, 12), (7, 9))
EXACT = {"rtol": 1e-13, "atol": 1e-13}
"""Both sides compute the same few terms in double precision; sums in another order, and with other contractions."""
LAWS = {
    "spline": LennardJonesSpline(0.4).law,
    "powers": InversePowers((9, 3), adhesion_length=0.05).law,
    "exponential": Exponential(0.05, 0.3, 2.0).law,
    "table": TabulatedWall(z := np.linspace(0.7, 2, 40), (2 - z) ** 2 * (1.2 - z)).law,
}


@pytest.fixture
def simulator() -> None:
    """Asked for by what runs in the simulator always."""


@pytest.fixture(autouse=True)
def serial(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """The functions of the kernels themselves, one thread after the other, on the simulator's arrays."""
    for end in (cpu.BACK_END, cuda.BACK_END):
        monkeypatch.setattr(end, "SMALLEST", 8)
    if IN_SIMULATOR or "simulator" in request.fixturenames:
        return
    place = types.SimpleNamespace(x=0)
    blocks, threads = types.SimpleNamespace(x=2), types.SimpleNamespace(x=1)
    stand_in = types.SimpleNamespace(
        blockIdx=place, threadIdx=types.SimpleNamespace(x=0), gridDim=blocks, blockDim=threads, grid=lambda _: place.x
    )
    for module in (points, spectra, walls, pressing, extending):
        monkeypatch.setattr(module, "cuda", stand_in)
        for name, value in vars(module).items():
            if hasattr(value, "fn"):  # a function of the device
                monkeypatch.setattr(module, name, value.fn)

    def run(kernel: Kernel, rows: int, *arguments: Any, threads: int = 1) -> None:
        there = [getattr(argument, "_ary", argument) for argument in arguments]
        if kernel is device.sum_parts:
            parts, count, largest, totals = there
            totals[:, 0] = parts[:, :count].sum(axis=1)
            if largest >= 0:
                totals[largest, 0] = parts[largest, :count].max()
            return
        for place.x in range(blocks.x):
            kernel.function(*there)

    monkeypatch.setattr(Kernel, "__call__", run)
    monkeypatch.setattr(device, "BLOCKS", blocks.x)
    monkeypatch.setattr(device, "THREADS", 1)


def start(kernel: Kernel, rows: int, *arguments: Any, summed: bool = False, largest: int = -1) -> tuple[list[Any], Any]:
    """Run a kernel; returns its arrays afterwards, and its sums."""
    there = [to_device(a) if isinstance(a, np.ndarray) else a for a in arguments]
    sums = Reduction()(kernel, rows, *there, largest=largest) if summed else kernel(rows, *there)
    return [a.copy_to_host() for a, was in zip(there, arguments, strict=True) if isinstance(was, np.ndarray)], sums


class Case:
    """Random fields and spectra of one shape."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.grid = Grid(shape, (float(shape[0]), float(shape[1])))
        self.rng = np.random.default_rng(3)
        self.rows, self.columns = shape
        self.K = HalfSpace("free").stiffness(self.grid) + 0.1
        self.single = -1 if shape[1] % 2 else shape[1] // 2
        self.weights = self.grid.mode_weights[0]
        self.mask = (self.rng.random(shape) < 0.5).astype(np.uint8)
        self.tiles = shape[1], np.full((shape[0], 1), 2, dtype=np.uint8)
        """Length of a row, and tiles of which nothing is known, as the sweeps of processor cores want them."""
        self.lowest = np.zeros((shape[0], 1))

    def field(self) -> Any:
        return self.rng.normal(size=self.grid.shape)

    def spectrum(self) -> Any:
        return self.rng.normal(size=(self.rows, 2 * self.grid.shape_q[1]))


@pytest.fixture(params=SHAPES, ids=str)
def case(request: pytest.FixtureRequest) -> Case:
    return Case(request.param)


def check(found: Any, expected: Any) -> None:
    np.testing.assert_allclose(found, expected, **EXACT)


def test_there_is_no_kernel_without_a_twin() -> None:
    """Each is named in one of the tests below."""
    source = Path(__file__).read_text()
    assert len(KERNELS) > 30
    assert not [name for name in KERNELS if not re.search(rf"\b{name}\b", source)]


# --- over the points ---------------------------------------------------------------------------------------


def test_points(case: Case) -> None:
    z, offset, work, rows = case.field(), case.field(), case.spectrum(), case.rows
    n = case.columns
    check(start(KERNELS["put"], 1, z, 7.0)[0][0][0, :2], (7.0, z[0, 1]))
    check(start(KERNELS["fill"], rows, z, 7.0)[0][0], 7.0)
    check(start(KERNELS["shift"], rows, z, 7.0)[0][0], z + 7)
    check(start(KERNELS["total"], rows, z, summed=True)[1][:2], (z.sum(), 0))
    lost = np.where(case.mask, np.nan, z)
    lost[0, 0] = np.inf
    assert start(KERNELS["total"], rows, lost, summed=True)[1][1] == np.count_nonzero(~np.isfinite(lost))
    check(start(KERNELS["copy"], rows, work, z, 0.5, summed=True)[0][0][:, :n], 0.5 * z)
    check(start(KERNELS["copy"], rows, work, z, 0.5, summed=True)[1][0], z.sum())
    check(start(KERNELS["keep"], rows, z, work)[0][0], work[:, :n])
    (out, *_), sums = start(KERNELS["displace"], rows, work, z, offset, 2.0, 0.5, summed=True)
    u = offset + 2 - z
    check(out[:, :n], 0.5 * u)
    check(sums[0], u.sum())
    check(start(KERNELS["lay"], rows, z, work, offset, 2.0)[0][0], offset + 2 - work[:, :n])
    check(start(KERNELS["above"], rows, z, offset, 2.0)[0][0], u)
    fine = case.rng.normal(size=(2 * rows, 2 * n))
    check(start(KERNELS["every_second"], rows, z, fine)[0][0], fine[::2, ::2])
    check(start(KERNELS["moved"], rows, work, fine, z, 0.5)[0][0][:, :n], 0.5 * (fine[::2, ::2] - z))


@pytest.mark.parametrize("name", LAWS)
def test_walls(case: Case, name: str) -> None:
    law: Law = LAWS[name]
    kind, p, reach, rows, n = law.kind, law.parameters, law.reach, case.rows, case.columns
    z, d, work = 1.2 + 0.5 * case.field(), case.field(), case.spectrum()
    z[0, 0] = 0.5  # below the core
    _, traction, stiffness = evaluate(law, z)
    check(start(KERNELS["press"], rows, work, z, kind, p, reach, 0.5)[0][0][:, :n], 0.5 * traction)
    (turned, *_), sums = start(KERNELS["turn"], rows, d, work, z, 0.3, kind, p, reach, summed=True)
    new = 0.3 * d - work[:, :n]
    check(turned, new)
    check(sums[0], (stiffness * new**2).sum())
    sums = start(KERNELS["line"], rows, z, d, 0.2, kind, p, reach, summed=True)[1]
    there = evaluate(law, z - 0.2 * d)
    check(sums[:2], (((there[1] - traction) * d).sum(), (there[2] * d**2).sum()))
    (out, moved, _, _), sums = start(KERNELS["move"], rows, work, z, d, 0.1, 0.3, kind, p, reach, 0.5, summed=True)
    now = z - 0.1 * d
    new, old = evaluate(law, now), evaluate(law, now + 0.3 * d)
    check(moved, now)
    check(out[:, :n], 0.5 * (new[1] - old[1]))
    second = new[0] - old[0] - 0.3 * old[1] * d
    check(sums[:3], (((new[1] - old[1]) * d).sum(), second.sum(), np.abs(new[0]).sum()))


@pytest.mark.usefixtures("simulator")
def test_points_that_are_no_numbers_are_not_lost() -> None:
    law, z = LAWS["spline"], np.full((4, 4), 9.0)
    z[1, 2] = np.nan
    work = np.zeros((4, 6))
    (out, *_), _ = start(KERNELS["press"], 4, work, z, law.kind, law.parameters, law.reach, 1.0)
    assert np.isnan(out[1, 2])
    assert np.isfinite(np.delete(out.ravel(), 8)).all()


# --- over the modes ----------------------------------------------------------------------------------------


def low(case: Case) -> tuple[int, int]:
    below = case.grid.coarser
    return (below.shape_q[0] // 2, below.shape_q[1] - 1) if below else (0, 0)


@pytest.mark.parametrize("coarse", [False, True])
def test_gradient(case: Case, coarse: bool) -> None:
    low_rows, low_columns = low(case) if coarse else (0, 0)
    g, d, work = case.spectrum(), case.spectrum(), case.spectrum()
    mine = g.copy(), d.copy(), work.copy()
    expected, last = np.zeros(6), case.K.shape[1]
    for a, b in ((0, low_columns), (low_columns, last)):
        if b > a:
            SWEEPS["gradient"][0](a, b, expected, *mine, case.K, 0.01, 0.7, 0.3, low_rows, low_columns, case.weights)
    (g, d, work, _), sums = start(
        KERNELS["gradient"], case.rows, g, d, work, case.K, 0.01, 0.7, 0.3, low_rows, low_columns, case.single, 0,
        summed=True,
    )  # fmt: skip
    for found, wanted in zip((g, d, work), mine, strict=True):
        check(found, wanted)
    check(sums, expected)


@pytest.mark.parametrize("shape", [(8, 12), (12, 8), (16, 16)])
def test_modes_of_the_coarser_grid(shape: tuple[int, int]) -> None:
    case = Case(shape)
    low_rows, low_columns = low(case)
    below = case.grid.coarser
    assert below is not None
    g, d, work = case.spectrum(), case.spectrum(), case.spectrum()
    e = case.rng.normal(size=(below.shape[0], 2 * below.shape_q[1]))
    ordered, count = (case.K, 0.01, low_rows), 2 * low_rows - 1
    mine, expected = work.copy(), np.zeros(6)
    SWEEPS["low_modes"][0](0, low_columns, expected, g, d, mine, *ordered, case.weights, e)
    (_, _, out, _, _), sums = start(
        KERNELS["low_modes"], count, g, d, work, case.K, e, 0.01, low_rows, low_columns, case.single, summed=True
    )
    check(out, mine)
    check(sums, expected)
    mine, expected = work.copy(), np.zeros(6)
    SWEEPS["low_gradient"][0](0, low_columns, expected, g, mine, *ordered, case.weights)
    (_, out, _), sums = start(
        KERNELS["low_gradient"], count, g, work, case.K, 0.01, low_rows, low_columns, case.single, summed=True
    )
    check(out, mine)
    check(sums, expected)
    mine = d.copy()
    SWEEPS["low_direction"][0](0, low_columns, expected, mine, work, low_rows, 0.3)
    check(start(KERNELS["low_direction"], count, d, work, low_rows, low_columns, 0.3)[0][0], mine)
    fine_q, coarse_q = work.view(complex), e.view(complex)
    mine_q = coarse_q.copy()
    restrict(fine_q, mine_q)
    check(start(KERNELS["restrict"], below.shape[0], e, work)[0][0].view(complex), mine_q)
    mine_q = fine_q.copy()
    prolong(coarse_q, mine_q)
    check(start(KERNELS["prolong"], case.rows, work, e)[0][0].view(complex), mine_q)


def test_a_mean_that_is_held_has_no_gradient(case: Case) -> None:
    g, d, work = case.spectrum(), case.spectrum(), case.spectrum()
    g[0, :2] = d[0, :2] = 0
    (g, d, out, _), _ = start(
        KERNELS["gradient"], case.rows, g, d, work, case.K, 0.01, 0.7, 0.3, 0, 0, case.single, 1, summed=True
    )
    check((g[0, :2], d[0, :2], out[0, :2]), 0.0)


def test_other_sums_over_modes(case: Case) -> None:
    g, work = case.spectrum(), case.spectrum()
    w = work.view(complex)
    expected = case.K * w
    expected[0, 0] -= 0.5
    check(start(KERNELS["elastic"], case.rows, g, work, case.K, 0.5)[0][0].view(complex), expected)
    (found, _), sums = start(KERNELS["add_square"], case.rows, g, work, case.single, summed=True)
    check(found, g + work)
    check(sums[0], (np.abs((g + work).view(complex)) ** 2 * case.weights).sum())
    power = np.abs(w) ** 2 * case.weights * case.K
    power[0, 0] = 0
    check(start(KERNELS["energy"], case.rows, work, case.K, case.single, summed=True)[1][0], power.sum())


MOST = 0.5
"""Largest pressure, which some points of a random field have."""


# --- under a bound -----------------------------------------------------------------------------------------


def test_pressing_starts(case: Case) -> None:
    rows, n, z, work, p = case.rows, case.columns, case.field(), case.spectrum(), case.field()
    check(start(KERNELS["mark"], rows, case.mask, 1)[0][0], 1)
    check(start(KERNELS["scale"], rows, z, 3.0)[0][0], 3 * z)
    field = work[:, :n]
    wide = z >= z.mean()
    check(start(KERNELS["wide"], rows, work, z, z.mean(), summed=True)[1][:2], (field[wide].sum(), wide.sum()))
    here = field + 0.1
    expected = np.where(here > 0.2 * (z + 1.5), np.clip(here, 0, MOST), 0)
    check(start(KERNELS["guess"], rows, p, work, z, 0.1, 0.2, -1.5, MOST)[0][0], expected)
    coarse, fine, mine, sums = case.field(), np.zeros((2 * rows, 2 * n)), np.zeros((2 * rows, 2 * n)), np.zeros(6)
    SWEEPS["spread"][0](0, 2 * rows, sums, coarse, mine, 2 * n)
    (found, _), total = start(KERNELS["spread"], 2 * rows, fine, coarse, summed=True)
    check(found, mine)
    check(total[0], sums[0])


def test_pressing_preconditions(case: Case) -> None:
    rows, z, m, work = case.rows, case.field(), case.field(), case.spectrum()
    mask, p = case.mask, case.field()
    check(start(KERNELS["multiply"], rows, work, case.K, -1.0)[0][0].view(complex), -case.K * work.view(complex))
    check(start(KERNELS["ones"], rows, m, mask)[0][0], mask)
    sums = np.zeros(6)
    SWEEPS["level"][0](0, rows, sums, p, z, m, MOST, *case.tiles)
    check(start(KERNELS["level"], rows, p, z, m, MOST, summed=True)[1][:2], sums[:2])
    mine = mask.astype(bool), m.copy()
    SWEEPS["select"][0](0, rows, sums, p, z, 0.3, *mine, MOST, *case.tiles, case.lowest)
    (_, _, marks, masked), found = start(KERNELS["select"], rows, p, z, 0.3, mask, m, MOST, summed=True)
    check(marks, mine[0])
    check(masked, mine[1])
    check(found[:5], sums[:5])


@pytest.mark.parametrize("ones", [False, True])
def test_extending(case: Case, ones: bool) -> None:
    rows, n, mask, z, work = case.rows, case.columns, case.mask, case.field(), case.spectrum()
    mask *= np.random.default_rng(2).random(mask.shape) < 0.2
    P, Q = hats(rows), hats(n)
    scale = P.shape[1] * Q.shape[1] / z.size
    f = mask * (1.0 if ones else z + 0.2)
    nodes, near = np.zeros((P.shape[1], Q.shape[1])), scale * P.T @ mask @ Q
    found = start(KERNELS["gather"], rows, nodes, nodes, mask, z, 0.2, int(ones))[0]
    check(found[0], scale * P.T @ f @ Q)
    check(found[1], near)
    density = P @ near @ Q.T + 0.1
    out = start(KERNELS["extend"], rows, work, mask, z, 0.2, int(ones), found[0], near, 0.1, 3.0)[0][0]
    check(out[:, :n], 3 * np.where(mask, f, P @ found[0] @ Q.T / density))
    beside = scale * P.T @ ((1 - mask) * work[:, :n] / density) @ Q
    check(start(KERNELS["withdraw"], rows, nodes, work, mask, near, 0.1)[0][0], beside)
    (out, *_), sums = start(KERNELS["give_back"], rows, z, mask, work, beside, summed=True)
    check(out, mask * (work[:, :n] + P @ beside @ Q.T))
    check(sums[0], out.sum())


def test_pressing_steps(case: Case) -> None:
    rows, n, mask, work = case.rows, case.columns, case.mask, case.spectrum()
    z, change, t, s, m, p = (case.field() for _ in range(6))
    contact, sums = mask.astype(bool), np.zeros(6)
    mine_s, mine_t = s.copy(), t.copy()
    SWEEPS["correct"][0](0, rows, sums, contact, z, change, mine_t, mine_s, m, 0.3, *case.tiles)
    found, totals = start(KERNELS["correct"], rows, mask, z, change, t, s, m, 0.3, summed=True)
    check(found[3:5], (mine_t, mine_s))
    check(totals, sums)
    mine_t, out = t.copy(), np.zeros_like(t)
    SWEEPS["turn_on_contact"][0](0, rows, sums, contact, mine_t, s, m, 0.4, 0.3, out, *case.tiles)
    found, _ = start(KERNELS["turn_on_contact"], rows, work, mask, t, s, m, 0.4, 0.3, 0.5)
    check(found[0][:, :n], 0.5 * out)
    check(found[2], mine_t)
    K = np.where(np.arange(case.K.size).reshape(case.K.shape) % 5 == 0, 0.0, case.K)
    G = np.divide(1.0, K, out=np.zeros_like(K), where=K > 0)
    mine, sums = work.copy(), np.zeros(6)
    SWEEPS["compliance"][0](0, G.shape[1], sums, mine, G, case.weights)
    (found_q, _), totals = start(KERNELS["compliance"], rows, work, K, case.single, summed=True)
    check(found_q, mine)
    check(totals[0], sums[0])
    power = np.abs(case.K * work.view(complex)) ** 2 * case.weights
    check(start(KERNELS["square"], rows, work, case.K, case.single, summed=True)[1][0], power.sum())
    sums = np.zeros(6)
    SWEEPS["trial"][0](0, rows, sums, p, t, 0.3, out, MOST, *case.tiles)
    (_, _, tried), totals = start(KERNELS["trial"], rows, p, t, 0.3, s, MOST, summed=True)
    check(tried, out)
    check(totals[:3], sums[:3])
    SWEEPS["stretch"][0](0, rows, sums, p, 1.3, out, MOST, *case.tiles)
    (_, stretched), totals = start(KERNELS["stretch"], rows, p, 1.3, s, MOST, summed=True)
    check(stretched, out)
    check(totals[0], sums[0])


def test_pressing_arrives(case: Case) -> None:
    rows, n, work = case.rows, case.columns, case.spectrum()
    z, change, p, offset = (case.field() for _ in range(4))
    field = work[:, :n]
    found, _ = start(KERNELS["advance"], rows, z, change, work, 0.3)
    check(found[:2], (z - 0.3 * field, -0.3 * field))
    sums, mine = np.zeros(6), field.copy()
    SWEEPS["arrive"][0](0, rows, sums, p, offset, mine, *case.tiles, case.lowest)
    (out, *_), totals = start(KERNELS["arrive"], rows, change, p, offset, work, summed=True)
    check(out, mine)
    check(totals[:2], sums[:2])
    check(start(KERNELS["accept"], rows, z, change)[0], (change, change - z))
    error = np.zeros_like(z)
    SWEEPS["misses"][0](0, rows, sums, p, z, 0.2, error, MOST, n, np.zeros(rows))
    (out, *_), totals = start(KERNELS["misses"], rows, work, p, z, 0.2, 0.5, MOST, summed=True, largest=0)
    check(out[:, :n], 0.5 * error)
    check(totals[0], np.abs(error).max())
    totals = start(KERNELS["certificate"], rows, p, z, summed=True, largest=2)[1]
    check(totals[:3], np.array([(p * z).sum(), p.sum(), -z.min()]))
    mine = z.copy()
    SWEEPS["finish"][0](0, rows, sums, p, mine, 0.2, 1e-9, MOST, n)
    assert (mine[p >= MOST] < 0).any()
    check(start(KERNELS["finish"], rows, p, z, 0.2, 1e-9, MOST)[0][1], mine)


def test_transforms_have_the_convention_of_the_grid(case: Case) -> None:
    values = case.field()
    memory = np.zeros((case.rows, 2 * case.grid.shape_q[1]))
    memory[:, : case.columns] = values / values.size
    there, both = to_device(memory), transforms.Transforms(case.grid.shape)
    both.forward(there)
    check(there.copy_to_host().view(complex), case.grid.forward(values))
    both.inverse(there)
    check(there.copy_to_host()[:, : case.columns], values)


@pytest.mark.usefixtures("simulator")
def test_parts_are_collected_whatever_their_number() -> None:
    parts = np.random.default_rng(1).normal(size=(device.SUMS, 12))
    for count in (1, 5, 12):
        totals = to_device(np.zeros((device.SUMS, 1)))
        device.sum_parts(device.SUMS, to_device(parts), count, 2, totals, threads=device.COLLECTORS)
        expected = parts[:, :count].sum(axis=1)
        expected[2] = parts[2, :count].max()
        check(totals.copy_to_host()[:, 0], expected)


# --- whole solves ------------------------------------------------------------------------------------------


def found_by_both(shape: tuple[int, int], **posed: Any) -> list[Solution]:
    """The same problem on both devices."""
    grid = Grid(shape, (float(shape[0]), float(shape[1])))
    h = SelfAffine(0.8, 0.2, 4.0, min(shape) / 2).synthesise(grid, np.random.default_rng(1))
    K = HalfSpace("clamped").stiffness(grid)
    law, start = posed.pop("law", None), posed.pop("start", None)
    start = None if start is None else np.maximum(h + start, 0.0)
    found, energies = [], []
    for name in ("cpu", "cuda"):
        solver = Solver(grid, K, 1, name)
        if law is None:
            found.append(solver.constrain(h, start, Settings(1e-8), **posed))
        else:
            found.append(solver.minimise(law, h, start, Settings(1e-8), **posed))
        energies.append(solver.elastic_energy(h, found[-1]))
    assert energies[0] == pytest.approx(energies[1], rel=1e-11)
    assert found[0].status.ok
    assert np.count_nonzero(found[0].gap < 1) > 3
    return found


def same(found: list[Solution]) -> None:
    """The same steps, but for rounding."""
    one, other = found
    assert one.status is other.status
    assert one.iterations == other.iterations > 3
    assert [w[:3] for w in one.work] == [w[:3] for w in other.work]
    assert other.residual == pytest.approx(one.residual, rel=1e-4)
    # Rounding of each iteration is added up: some of the others take twice as many as the square grids.
    nx, ny = one.gap.shape
    np.testing.assert_allclose(other.gap, one.gap, rtol=0, atol=1e-13 if nx == ny else 1e-12)
    np.testing.assert_allclose(other.traction, one.traction, rtol=0, atol=1e-12)


HELD = {"lift": 1.5, "mean_stiffness": np.inf}


@pytest.mark.parametrize(
    ("shape", "posed"),
    [
        ((16, 16), {"law": LAWS["spline"], **HELD}),
        ((32, 32), {"law": LAWS["spline"], **HELD}),
        pytest.param((32, 32), {"law": LAWS["spline"], "start": 1.6, **HELD}, marks=pytest.mark.long),
        ((12, 16), {"law": LAWS["spline"], "lift": 2.0, "pressure": 0.02, "mean_stiffness": 0.0}),
        ((15, 17), {"law": LAWS["exponential"], "lift": 0.7, "mean_stiffness": 0.1}),
    ],
    ids=lambda x: "x".join(map(str, x)) if isinstance(x, tuple) else "-".join(x),
)
def test_whole_solves_under_a_law(shape: tuple[int, int], posed: dict[str, Any]) -> None:
    same(found_by_both(shape, **posed))


@pytest.mark.parametrize(
    ("shape", "posed"),
    [
        ((16, 16), {"lift": 0.5, "mean_stiffness": np.inf}),
        ((32, 32), {"lift": 1.0, "pressure": 0.02, "mean_stiffness": 0.0}),
        ((16, 24), {"lift": 0.5, "start": 0.4, "mean_stiffness": np.inf}),
        ((15, 17), {"lift": 1.0, "pressure": 0.1, "mean_stiffness": 0.05}),
        ((16, 16), {"lift": 1.0, "pressure": 0.05, "mean_stiffness": 0.0, "most": 0.1}),
    ],
    ids=lambda x: "x".join(map(str, x)) if isinstance(x, tuple) else "-".join(x),
)
def test_whole_solves_under_a_bound(shape: tuple[int, int], posed: dict[str, Any]) -> None:
    found = found_by_both(shape, **posed)
    same(found)
    np.testing.assert_array_equal(found[0].gap == 0, found[1].gap == 0)


def test_one_set_of_arrays_serves_any_number_of_problems() -> None:
    grid = Grid.square(16)
    h = SelfAffine(0.8, 0.2, 4.0, 8.0).synthesise(grid, np.random.default_rng(1))
    K, law = HalfSpace("clamped").stiffness(grid), LAWS["spline"]
    once, again = (Solver(grid, K, 1, "cuda") for _ in range(2))
    assert not once.minimise(law, np.full(h.shape, np.nan), None, Settings(1e-6), **HELD).status.ok
    assert not once.minimise(law, h, np.full(h.shape, np.inf), Settings(1e-6), **HELD).status.ok
    frozen = h.copy()
    frozen.flags.writeable = False
    first = once.minimise(law, frozen, None, Settings(1e-6), **HELD)
    second = once.minimise(law, frozen, None, Settings(1e-6), **HELD)
    np.testing.assert_array_equal(first.gap, second.gap)
    np.testing.assert_array_equal(first.gap, again.minimise(law, h, None, Settings(1e-6), **HELD).gap)
    h += 1.0  # may be changed: it is copied anew
    higher = again.minimise(law, h, None, Settings(1e-6), lift=0.5, mean_stiffness=np.inf)
    np.testing.assert_allclose(higher.gap, first.gap, atol=1e-6)


def held(thing: Any, seen: set[int]) -> int:
    """Bytes of the arrays on the device that an object of ours holds."""
    if id(thing) in seen:
        return 0
    seen.add(id(thing))
    if type(thing).__module__.startswith("numba"):
        return int(getattr(thing, "nbytes", 0))
    if type(thing).__module__.startswith("continuum") and hasattr(thing, "__dict__"):
        return sum(held(value, seen) for value in vars(thing).values())
    if isinstance(thing, (list, tuple)):
        return sum(held(value, seen) for value in thing)
    if isinstance(thing, dict):
        return sum(held(value, seen) for value in thing.values())
    return 0


def test_memory_is_what_is_said_before_a_grid_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = Grid.square(1024)
    stiffness = HalfSpace("clamped").stiffness(grid)
    field = grid.shape[0] * grid.shape[1] * 8
    made = SmoothGrid(cuda.BACK_END, grid, stiffness, 1, 2), BoundGrid(cuda.BACK_END, grid, stiffness, 1)
    for each in made:
        assert held(each, set()) / field == pytest.approx(each.FIELDS, abs=0.2)
    solver = Solver(grid, stiffness, 1, "cuda")
    monkeypatch.setattr(device, "SIMULATED", False)
    monkeypatch.setattr(
        device,
        "cuda",
        types.SimpleNamespace(
            current_context=lambda: types.SimpleNamespace(get_memory_info=lambda: (9.5 * field, 80 * field))
        ),
    )
    with pytest.raises(MemoryError, match=r"has 0\.0742 of 0\.625 GiB left, this grid needs 0\.0766"):
        solver.constrain(np.zeros(grid.shape), None, Settings(1e-6))


def test_processes_that_share_a_machine_have_a_gpu_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    assert cuda.BACK_END.devices() == ("0",)
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "2, GPU-3e7a")
    assert cuda.BACK_END.devices() == ("2", "GPU-3e7a")


def test_the_device_is_known_and_names_itself() -> None:
    assert backend.back_end("cuda") is cuda.BACK_END
    assert cuda.BACK_END.machine() == "simulator"
    assert "experimental" in cuda.BACK_END.CAUTION
    assert numba_cuda.is_available()


def test_a_run_names_its_device_and_is_kept_apart_from_those_of_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = tmp_path / "small.toml"
    small.write_text(
        '[grid]\nn = 16\n[surface]\nkind = "sine"\namplitude = 0.2\nwaves = [1, 1]\n[wall]\nlaw = "hard"\n'
        '[substrate]\nresponse = "half-space"\nmean = "free"\n[loading]\ncontrol = "mean-pressure"\n'
        "targets = [0.01, 0.02]\n"
    )
    command = ["run", str(small), "-o", str(tmp_path)]
    assert main([*command, "--device", "cuda"]) == 0
    said = capsys.readouterr()
    assert "on no GPU yet" in " ".join((said.out + said.err).split())
    result = Result.read(tmp_path / "small.h5")
    assert result.attributes["device"] == "cuda"
    assert result.config.solver.device == "cuda"
    assert main([*command, "--device", "cuda"]) == 0
    assert "2 points were stored before" in capsys.readouterr().out
    assert main(command) == 2
    assert main([*command, "--force"]) == 0
    again = Result.read(tmp_path / "small.h5")
    assert "device" not in again.attributes
    for one, other in zip(result.points, again.points, strict=True):
        assert one.load == pytest.approx(other.load, rel=1e-6)
