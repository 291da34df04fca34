"""The back end for GPUs without a GPU: collected by `test_cuda.py` only, in a process with NUMBA_ENABLE_CUDASIM=1.

Each kernel beside its twin for processor cores or a line of NumPy, and whole solves beside the CPU's.  The simulator's
threads wait by polling, which takes minutes: by default the same functions run one thread after the other, some of them
in the simulator, with STICKINESS_IN_SIMULATOR=1 (a long test) all.
"""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys
import types
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import cuda as numba_cuda

from continuum.cli import main
from continuum.errors import InputError
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
from continuum.solve.cuda import device, extending, points, pressing, relax, spectra, sums, transforms, walls
from continuum.solve.cuda.device import Kernel, to_device
from continuum.solve.cuda.engine import KERNELS
from continuum.solve.cuda.linear import CudaLinearEngine
from continuum.solve.cuda.sums import Reduction
from continuum.solve.smooth_grid import LinearGrid, SmoothGrid
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
    # A direction in single precision would be another one, and so would the last bits of a state.
    monkeypatch.setattr(cpu.BACK_END, "PRECISION", np.float64)
    if IN_SIMULATOR or "simulator" in request.fixturenames:
        return
    place = types.SimpleNamespace(x=0)
    stand_in = types.SimpleNamespace(
        blockIdx=place,
        threadIdx=types.SimpleNamespace(x=0),
        gridDim=types.SimpleNamespace(x=device.BLOCKS),
        blockDim=types.SimpleNamespace(x=1),
        shared=types.SimpleNamespace(array=np.empty),
        syncthreads=lambda: None,
        grid=lambda _: place.x,
    )
    for module in (points, spectra, walls, relax, pressing, extending, sums):
        monkeypatch.setattr(module, "cuda", stand_in)
        for name, value in vars(module).items():
            if hasattr(value, "fn"):  # a function of the device
                monkeypatch.setattr(module, name, value.fn)

    def run(kernel: Kernel, rows: int, *arguments: Any) -> None:
        there = [getattr(argument, "_ary", argument) for argument in arguments]
        stand_in.gridDim.x = kernel.blocks(rows)
        for place.x in range(stand_in.gridDim.x):
            kernel.function(*there)

    monkeypatch.setattr(Kernel, "__call__", run)
    monkeypatch.setattr(sums, "THREADS", 1)


def start(kernel: Kernel, rows: int, *arguments: Any, summed: bool = False, largest: int = -1) -> tuple[list[Any], Any]:
    """Run a kernel; returns its arrays afterwards, and its sums."""
    there = [to_device(a) if isinstance(a, np.ndarray) else a for a in arguments]
    sums = Reduction(rows)(kernel, rows, *there, largest=largest) if summed else kernel(rows, *there)
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
    one, single = np.zeros((rows, n), np.float32), fine.astype(np.float32)
    check(start(KERNELS["sampled"], rows, one, single)[0][0], single[::2, ::2])


@pytest.mark.parametrize("name", LAWS)
def test_walls(case: Case, name: str) -> None:
    law: Law = LAWS[name]
    kind, p, reach, rows, n = law.kind, law.parameters, law.reach, case.rows, case.columns
    z, d, work = 1.2 + 0.5 * case.field(), case.field(), case.spectrum()
    z[0, 0] = 0.5  # below the core
    energy, traction, stiffness = evaluate(law, z)
    asked = kind, p, reach
    push, stiff = np.full(z.shape, np.nan), np.full(z.shape, np.nan, np.float32)
    (out, _, push, stiff, _), sums = start(KERNELS["press"], rows, work, z, push, stiff, *asked, 0.5, summed=True)
    check(out[:, :n], 0.5 * traction)
    check(push, traction)
    check(stiff, stiffness.astype(np.float32))
    check(sums[0], energy.sum())
    (turned, *_), sums = start(KERNELS["turn"], rows, d, work, stiff, 0.3, summed=True)
    new = 0.3 * d - work[:, :n]
    check(turned, new)
    check(sums[0], (stiff * new**2).sum())
    sums = start(KERNELS["line"], rows, z, d, push, 0.2, *asked, summed=True)[1]
    there = evaluate(law, z - 0.2 * d)
    check(sums[:2], (((there[1] - traction) * d).sum(), (there[2] * d**2).sum()))
    # At once, and the last of several that add up to 0.3.
    for step in (0.3, 0.1):
        old = z + (0.3 - step) * d
        (out, moved, _, left, soft, _), sums = start(
            KERNELS["move"], rows, work, z, d, push, stiff, step, 0.3, *asked, 0.5, summed=True
        )
        now = z - step * d
        new, old = evaluate(law, now), evaluate(law, old)
        check(moved, now)
        check(out[:, :n], 0.5 * (new[1] - old[1]))
        check(left, new[1])
        check(soft, new[2].astype(np.float32))
        check(sums[:4], (((new[1] - old[1]) * d).sum(), (old[1] * d).sum(), new[0].sum(), np.abs(new[0]).sum()))


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("name", LAWS)
def test_points_that_are_no_numbers_are_not_lost(name: str) -> None:
    law, z = LAWS[name], np.full((4, 4), 9.0)
    z[1, 2] = np.nan
    work, d, asked = np.zeros((4, 6)), np.ones((4, 4)), (law.kind, law.parameters, law.reach)
    push, stiff = np.zeros((4, 4)), np.zeros((4, 4), np.float32)
    (out, _, push, stiff, _), sums = start(KERNELS["press"], 4, work, z, push, stiff, *asked, 1.0, summed=True)
    for field in (out[:, :4], push, stiff):
        assert np.isnan(field[1, 2])
        assert np.isfinite(np.delete(field.ravel(), 6)).all()
    assert np.isnan(sums[0])
    assert np.isnan(start(KERNELS["turn"], 4, d, work, stiff, 0.3, summed=True)[1][0])
    assert np.isnan(start(KERNELS["line"], 4, z, d, push, 0.2, *asked, summed=True)[1][:2]).all()
    moved = start(KERNELS["move"], 4, work, z, d, push, stiff, 0.1, 0.3, *asked, 1.0, summed=True)
    assert np.isnan(moved[1][:4]).all()


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
    SWEEPS["low_modes"][0](0, low_columns, expected, g, d, mine, *ordered, case.weights, e, 0.6)
    (_, _, out, _, _), sums = start(
        KERNELS["low_modes"], count, g, d, work, case.K, e, 0.6, 0.01, low_rows, low_columns, case.single, summed=True
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
    check(start(KERNELS["restrict"], below.shape[0], e, work, 0.6)[0][0].view(complex), 0.6 * mine_q)
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
    parts = np.random.default_rng(1).normal(size=(sums.SUMS, 12))
    for count in (1, 5, 12):
        totals = to_device(np.zeros((sums.SUMS, 1)))
        sums.sum_parts(sums.SUMS, to_device(parts), count, 2, totals)
        expected = parts[:, :count].sum(axis=1)
        expected[2] = parts[2, :count].max()
        check(totals.copy_to_host()[:, 0], expected)


# --- a coarse step on the device -------------------------------------------------------------------------------


ALONE = {"begin", "linear_gradient", "decide_gradient", "linear_turn", "decide_turn", "linear_last"}
WITH_COARSER = {
    "sampled", "linear_restrict", "linear_low_modes", "decide_low_modes", "linear_low_gradient", "decide_low_gradient",
    "linear_low_direction",
}  # fmt: skip
"""What a coarse step starts on its coarsest grid, and in addition on finer ones."""


WALLS = {
    "stiff": (2.0, 2.0), "none": (0.0, 0.0), "soft": (-0.3, -0.3), "too soft": (-30.0, -30.0), "weak": (0.01, 0.01),
    "soft where the coarser grid sees it": (40.0, -30.0), "lost": (np.nan, np.nan),
}  # fmt: skip
"""Stiffness where a wall touches: at points of the finest grid only, and at those of coarser ones."""


def linear_problem(end: backend.BackEnd, wall: str, held: bool) -> LinearGrid:
    """A linear problem on three grids, of a wall that touches here and there; the same for each back end."""
    grid, rng = Grid.square(64), np.random.default_rng(5)
    smooth = SmoothGrid(end, grid, HalfSpace("clamped" if held else "free").stiffness(grid), 1, 3)
    linear = smooth.linear
    assert linear is not None
    for each in linear.chain:
        each.engine.set_mean_stiffness(1.0 if held else 0.2, held=held)
    assert len(linear.chain) == 3
    g = np.fft.rfft2(rng.normal(size=(32, 32))) / 32**2
    g[0, 0] *= not held
    touching = np.full((32, 32), WALLS[wall][0], np.float32)
    touching[::2, ::2] = WALLS[wall][1]
    touching *= rng.random((32, 32)) < 0.3
    for array, values in ((linear.stiffness, touching), (linear.g, g.view(np.float64))):
        if end is cuda.BACK_END:
            array.copy_to_device(values)
        else:
            array[:, : values.shape[1]] = values
    return linear


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("depth", [1, 2, 3])
@pytest.mark.parametrize(("wall", "iterations"), [*((wall, 4) for wall in WALLS), ("stiff", 1), ("weak", 12)])
def test_a_coarse_step_on_the_device_is_that_of_the_cpu_and_waits_for_nothing(
    monkeypatch: pytest.MonkeyPatch, wall: str, iterations: int, depth: int, held: bool
) -> None:
    """What is started does not depend on what is found, and one state is read in the end."""
    started: list[str] = []
    copies = [0]
    launch, copy = CudaLinearEngine.launch, type(to_device(np.zeros(1))).copy_to_host
    monkeypatch.setattr(
        CudaLinearEngine, "launch", lambda self, name, *a, **b: started.append(name) or launch(self, name, *a, **b)
    )
    x, moved, made = {}, {}, {}
    for name, end in (("cpu", cpu.BACK_END), ("cuda", cuda.BACK_END)):
        grid = linear_problem(end, wall, held)
        with monkeypatch.context() as patch:
            patch.setattr(type(to_device(np.zeros(1))), "copy_to_host", lambda *a: copies.append(1) or copy(*a))
            moved[name] = grid.relax(depth, 0.01, iterations, 0.3)
        made[name] = [each.engine.transforms for each in grid.chain]
        there = grid.x.copy_to_host() if end is cuda.BACK_END else grid.x
        x[name] = np.array(there)[:, : 2 * grid.grid.shape_q[1]]
    assert moved["cuda"] is moved["cpu"] is (wall not in ("too soft", "lost"))
    assert made["cuda"] == made["cpu"]
    if moved["cpu"]:
        np.testing.assert_allclose(x["cuda"], x["cpu"], rtol=0, atol=1e-12 * abs(x["cpu"]).max())
    assert copies == [0, 1]
    assert set(started) == (ALONE | WITH_COARSER if depth > 1 else ALONE)
    launches = 2 + 4 * iterations
    for _ in range(depth - 1):
        launches = 3 + iterations * (10 + launches)
    assert len(started) == launches


# --- how kernels are started and what they leave -------------------------------------------------------------


@pytest.mark.usefixtures("simulator")
def test_each_block_leaves_one_part_in_a_fixed_order() -> None:
    rng = np.random.default_rng(2)
    z = rng.normal(size=(7, 5)) * 10.0 ** rng.integers(-8, 8, size=(7, 5))  # another order, other bits
    reduction = Reduction(7)
    for _ in range(3):
        total = reduction(KERNELS["total"], 7, to_device(z))[0]
        parts = reduction.parts.copy_to_host()[0]
        assert device.BLOCKS == 3
        assert device.THREADS == 2
        for block in range(3):
            # In the order of the rows: the sum of Python 3.12 corrects its rounding.
            first, second = (reduce(add, (float(x) for row in z[block::3] for x in row[t::2])) for t in (0, 1))
            assert parts[block] == first + second
        assert np.isnan(parts[3:]).all()
        assert total == (parts[0] + parts[2]) + parts[1]
        assert total == pytest.approx(z.sum())


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("lost", range(6))
def test_the_largest_of_numbers_one_of_which_is_none_is_none(lost: int) -> None:
    """On the device max drops NaN, in Python it depends on the order."""
    z, p = np.full((3, 2), 1.0), np.zeros((3, 2))
    z.ravel()[lost] = np.nan
    assert np.isnan(start(KERNELS["misses"], 3, np.zeros((3, 4)), p, z, 0.2, 0.5, MOST, summed=True, largest=0)[1][0])
    assert np.isnan(start(KERNELS["certificate"], 3, p, z, summed=True, largest=2)[1][2])


def test_no_kernel_drops_what_is_no_number(case: Case) -> None:
    rows, z, p, work = case.rows, case.field(), np.zeros(case.grid.shape), case.spectrum()
    z[0, 0] = work[0, 0] = np.nan
    assert np.isnan(start(KERNELS["finish"], rows, p, z, 0.2, 1e-9, MOST)[0][1][0, 0])
    assert np.isnan(start(KERNELS["stretch"], rows, z, 1.3, p, MOST, summed=True)[0][1][0, 0])
    for one, other in ((np.nan, 1.0), (1.0, np.nan)):
        assert np.isnan(device.larger(one, other))
        assert np.isnan(device.smaller(one, other))
    assert (device.larger(1.0, 2.0), device.larger(2.0, 1.0)) == (2.0, 2.0)
    assert (device.smaller(1.0, 2.0), device.smaller(2.0, 1.0)) == (1.0, 1.0)


@pytest.mark.parametrize("at_once", [1, 3, 660, 2112])
def test_all_blocks_run_at_once_and_share_the_rows_evenly(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    """Their number depends on nothing but kernel, device and rows."""
    asked, started = [], []

    class Compiled:
        def __init__(self) -> None:
            variant = types.SimpleNamespace(max_cooperative_grid_blocks=lambda n: asked.append(n) or at_once)
            self.overloads = {"one": variant}

        def __getitem__(self, launch: tuple[int, int]) -> Any:
            started.append(launch)
            return lambda *arguments: None

    monkeypatch.undo()
    monkeypatch.setattr(device, "SIMULATED", False)
    kernel = Kernel(lambda: None)
    kernel.__dict__["compiled"] = Compiled()
    for rows in (1, 6, 512, 513, 4096, 32768):
        kernel(rows)
        blocks, threads = started.pop()
        assert threads == device.THREADS
        assert blocks <= at_once
        most = -(-rows // blocks)
        assert most == -(-rows // at_once)  # no block would have fewer rows if there were more of them
        assert blocks == 1 or -(-rows // (blocks - 1)) > most  # and with fewer some would have more
        assert kernel.blocks(rows) == blocks
    assert asked == [device.THREADS]


def test_compiled_kernels_are_kept_under_the_name_of_all_that_they_are_made_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: dict[str, Any] = {}
    monkeypatch.setattr(device, "cuda", types.SimpleNamespace(jit=lambda *_, **how: kept.update(how) or (lambda f: f)))
    name = device.source_digest()
    for kernel in KERNELS.values():
        assert kernel.function.__qualname__.endswith(f"-{name}")
        assert Path(inspect.getfile(kernel.function)) in device.SOURCES
        for used in kernel.function.__code__.co_names:
            value = kernel.function.__globals__.get(used)
            called = getattr(value, "fn", value)
            if inspect.isfunction(called):
                assert Path(inspect.getfile(called)) in device.SOURCES, used
    kernel = Kernel(lambda: None)
    monkeypatch.setattr(Kernel, "signature", None)
    assert kernel.compiled is kernel.function
    assert kept == {"cache": True}
    for source in device.SOURCES:
        (changed := tmp_path / source.name).write_text(source.read_text() + "\n")
        assert device.source_digest(tuple(changed if one == source else one for one in device.SOURCES)) != name


class Whole(np.ndarray[Any, Any]):
    """A spectrum of which no kernel may read or write one part of a number alone."""

    def __getitem__(self, key: Any) -> Any:
        pytest.fail(f"one part is read: {key}")

    __setitem__ = __getitem__


@pytest.mark.skipif(IN_SIMULATOR, reason="the simulator wraps arrays")
@pytest.mark.parametrize(
    "name",
    [name for name, kernel in KERNELS.items() if kernel.function.__module__ == spectra.__name__]
    + ["multiply", "compliance", "square"],
)
def test_complex_numbers_are_read_and_written_as_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the device an access of 16 bytes: the compiled kernels are looked at where there are compilers."""
    here = spectra if KERNELS[name].function.__module__ == spectra.__name__ else pressing
    count, plain = [0], (device.complex_at, device.set_complex)

    def at(array: Any, *arguments: Any) -> Any:
        count[0] += 1
        return plain[len(arguments) == 4](array.view(np.ndarray), *arguments)

    monkeypatch.setattr(here, "complex_at", at)
    monkeypatch.setattr(here, "set_complex", at)
    case = Case((8, 12))
    spectrum = {"g", "d", "work", "e", "coarse", "fine"}
    given: dict[str, Any] = {"K": case.K, "values_q": case.K, "low_rows": 2, "low_columns": 3, "single": 6, "held": 0}
    given |= {array: case.spectrum().view(Whole) for array in spectrum}
    given["e"] = given["coarse"] = case.rng.normal(size=(4, 8)).view(Whole)
    sums = [np.zeros((6, 8))] if KERNELS[name].summed else []
    KERNELS[name](8, *(given.get(argument, 0.5) for argument in KERNELS[name].needs), *sums)
    assert count[0] > 0


GONE = """
import atexit, sys, types
from continuum.solve.cuda import transforms

said = []
cufft = types.ModuleType("nvmath.bindings.cufft")
cufft.Type = types.SimpleNamespace(D2Z=1, Z2D=2)
plans = iter(range(1, 9))
cufft.create = lambda: next(plans)
cufft.destroy = lambda plan: print("plan", plan, "released")
cufft.set_auto_allocation = cufft.set_work_area = lambda *_: None
cufft.make_plan_many64 = lambda *_: 8
for name, module in (("nvmath", types.ModuleType("nvmath")), ("nvmath.bindings", types.ModuleType("nvmath.bindings"))):
    sys.modules[name] = module
sys.modules["nvmath.bindings"].cufft = sys.modules["nvmath.bindings.cufft"] = cufft
atexit.register(lambda: print("context gone"))
transforms.SIMULATED = False
transforms._address = lambda array: 0
kept = transforms.Transforms((8, 8))
transforms.Transforms((8, 8))
print("end")
"""


def test_plans_are_released_with_their_owner_or_before_the_context_goes() -> None:
    done = subprocess.run([sys.executable, "-c", GONE], capture_output=True, text=True, check=True, env=os.environ)
    lines = done.stdout.splitlines()
    assert set(lines[:2]) == {"plan 3 released", "plan 4 released"}
    assert lines[2] == "end"
    assert set(lines[3:5]) == {"plan 1 released", "plan 2 released"}
    assert lines[5:] == ["context gone"]


def test_a_driver_that_is_older_than_the_libraries_is_one_message(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(major: int) -> Any:
        return types.SimpleNamespace(get_version=lambda: (major, 4))

    for name in ("numba_cuda", "nvmath", "nvmath.bindings", "nvmath.bindings.cufft"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setattr(device, "SIMULATED", False)
    monkeypatch.setitem(vars(device.config), "CUDA_LOW_OCCUPANCY_WARNINGS", 1)
    for driver, libraries, fits in ((13, 13, True), (13, 12, True), (12, 12, True), (12, 13, False)):
        cudadrv = types.SimpleNamespace(driver=types.SimpleNamespace(driver=version(driver)))
        here = types.SimpleNamespace(is_available=lambda: True, cudadrv=cudadrv, runtime=version(libraries))
        monkeypatch.setattr(device, "cuda", here)
        if fits:
            device.refuse_without_gpu()
        else:
            with pytest.raises(InputError, match=r"of CUDA 12, .* of CUDA 13.*'stickiness\[gpu12\]'"):
                device.refuse_without_gpu()


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
