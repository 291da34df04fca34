"""The engine of processor cores: arrays with padded rows, sweeps in blocks, and what was done.

A sweep goes over fixed blocks of rows or columns, of which each has one thread; their sums are added in the order of
the blocks.  So the number of threads changes no bit of a result.  The half of a Fourier transform that runs along the
rows or columns of a block is done while the block is in the cache, together with the sweep that makes or uses the
values.
"""

from __future__ import annotations

import inspect
import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from continuum.model import fourier
from continuum.model.fourier import (
    Complex,
    Real,
    block_edges,
    columns_forward,
    columns_inverse,
    padded,
    rows_forward,
    rows_inverse,
)
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.backend import low_part, reused
from continuum.solve.cpu import extending, near_field, points, pressing, sweeps, tractions
from continuum.solve.cpu.compiled import SUMS, TILE
from continuum.solve.solution import Work

NEAR = 0.5
"""Points within this distance of the range of the law are near the wall, in a0: the line search asks these alone."""
KERNELS: dict[str, tuple[Callable[..., None], tuple[str, ...]]] = {
    name.removeprefix("_"): (kernel, names)
    for module in (sweeps, points, tractions, pressing, extending, near_field)
    for name, kernel in vars(module).items()
    if hasattr(kernel, "py_func") and "sums" in (names := tuple(inspect.signature(kernel.py_func).parameters))
}
"""Each compiled sweep and the names of its parameters: the block, its sums, and what the sweep asks for."""
Task = Callable[[int, int, Real], float | None]
"""A function of the block ``first:last``: writes its sums, returns the seconds it took in transforms."""
_WORTH_THREADS = 2**17  # points; smaller grids are not worth the start of threads


class CpuEngine:
    """What :class:`continuum.solve.backend.Engine` asks for, with threads that sleep between the sweeps.

    Parameters
    ----------
    grid : gives the shape.
    K : over the half spectrum, shape ``grid.shape_q``; owned from now on, since K at q = 0 is that of each problem.
        All arrays have its precision.
    threads : of a sweep.
    below : the next coarser grid, whose modes are swept apart.
    """

    KEEPS_FIELDS = False

    def __init__(self, grid: Grid, K: Real, threads: int, below: Grid | None = None) -> None:
        self.grid, self.size, self.n = grid, grid.size, grid.shape[1]
        self.K, self._kind = K, K.dtype
        self.work_q: Complex = padded(grid.shape_q, np.result_type(K.dtype, np.complex64))
        self.w = memory(self.work_q)
        self.threads = threads if grid.size >= _WORTH_THREADS else 1
        self.row_edges = block_edges(grid.shape[0], grid.size)
        self.column_edges = block_edges(grid.shape_q[1], grid.size)
        self.low_part = low_part(K, below)
        low_columns = self.low_part["low_columns"]
        high = block_edges(grid.shape_q[1] - low_columns, grid.size)
        self.low_edges, self.high_edges = block_edges(low_columns, grid.size), [low_columns + e for e in high]
        self.near = np.zeros((grid.shape[0], -(-self.n // TILE)), dtype=np.bool_)
        self._own: dict[str, object] = {
            "n": self.n,
            "K": K,
            "work": self.w,
            "weights": np.ascontiguousarray(grid.mode_weights[0], dtype=K.dtype),
            "near": self.near,
            **self.low_part,
        }
        self._held = False
        self._thread = threading.local()
        self._pool: tuple[int, ThreadPoolExecutor] | None = None
        self.transforms, self.trials, self.fft_seconds = 0, 0, 0.0

    def forget_work(self) -> None:
        """Count the work from zero again."""
        self.transforms, self.trials, self.fft_seconds = 0, 0, 0.0

    @property
    def work(self) -> Work:
        """What was done on this grid for the problem at hand."""
        return Work(self.grid.shape, self.transforms / 2, self.trials, self.fft_seconds)

    # --- the problem ---------------------------------------------------------------------------------------

    def set_law(self, law: Law) -> None:
        self._own |= {"kind": law.kind, "parameters": law.parameters, "reach": law.reach, "near_gap": law.reach + NEAR}

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        self.K[0, 0], self._held = stiffness, held

    # --- arrays --------------------------------------------------------------------------------------------

    def rows(self) -> Real:
        return memory(padded(self.grid.shape, self._kind))

    def single_rows(self) -> Real:
        return memory(padded(self.grid.shape, np.float32))

    def spectrum(self) -> Real:
        return memory(padded(self.grid.shape_q, self.work_q.dtype))

    def hold(self, values: Real, kept: Real | None) -> Real | None:
        # A sum is finite only if all its terms are, and needs no memory.
        return np.ascontiguousarray(values) if np.isfinite(values.sum()) else None

    def upload(self, field: Real, values: Real) -> bool:
        field[:, : self.n] = values
        return bool(np.isfinite(values.sum()))

    def download(self, field: Real) -> Real:
        return field[:, : self.n]

    def fill(self, values: Real, number: float) -> None:
        values[...] = number

    def shift(self, field: Real, by: float) -> None:
        field[:, : self.n] += by

    def reflect(self, field: Real, offset: Real, lift: float) -> None:
        points = field[:, : self.n]
        np.subtract(offset, points, out=points)
        points += lift

    def set_mean(self, mean: float) -> None:
        self.work_q[0, 0] = mean

    def sample(self, fine: Real, coarse: Real) -> None:
        self.sweep("sampled", fine=fine, out=coarse)

    def restrict(self, spectrum: Real, below: CpuEngine, coarse: Real, size: float = 1.0) -> None:
        self.low("restrict", g=spectrum, coarse=coarse, size=size)

    def prolong(self, below: CpuEngine) -> None:
        fourier.prolong(below.work_q, self.work_q)

    # --- sweeps --------------------------------------------------------------------------------------------

    def sweep(self, name: str, **given: Any) -> Real:
        kernel, arguments = self._bound(name, 3, given)
        return self.rows_of(kernel, *arguments)

    def into(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        kernel, arguments = self._bound(name, 4, given)

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            kernel(first, last, sums, buffer, *arguments)
            began = time.perf_counter()
            rows_forward(buffer[:, : self.n], self.work_q[first:last])
            return time.perf_counter() - began

        return self.over(task, self.row_edges)

    def out_of(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        kernel, arguments = self._bound(name, 4, given)

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            began = time.perf_counter()
            rows_inverse(self.work_q[first:last], buffer[:, : self.n])
            seconds = time.perf_counter() - began
            kernel(first, last, sums, buffer, *arguments)
            return seconds

        return self.over(task, self.row_edges)

    def through(self, name: str, **given: Any) -> Real:
        self.transforms += 2
        kernel, arguments = self._bound(name, 4, given)

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            began = time.perf_counter()
            rows_inverse(self.work_q[first:last], buffer[:, : self.n])
            middle = time.perf_counter()
            kernel(first, last, sums, buffer, *arguments)
            swept = time.perf_counter()
            rows_forward(buffer[:, : self.n], self.work_q[first:last])
            return time.perf_counter() - swept + middle - began

        return self.over(task, self.row_edges)

    def spectral(
        self, name: str = "", *, forward: bool = False, inverse: bool = False, keep_low: bool = False, **given: Any
    ) -> Real:
        if not keep_low:
            return self._columns(self.column_edges, name, forward, inverse, given)
        sums = self._columns(self.low_edges, name, forward, False, given)
        sums += self._columns(self.high_edges, name, forward, inverse, given)
        return sums

    def low(self, name: str, *, inverse: bool = False, **given: Any) -> Real:
        return self._columns(self.low_edges, name, False, inverse, given)

    def _columns(self, edges: Sequence[int], name: str, forward: bool, inverse: bool, given: dict[str, Any]) -> Real:
        """Sweep over the columns between the edges, after and before a transform of ``work_q`` along them."""
        kernel, arguments = self._bound(name, 3, given) if name else (None, [])

        def task(first: int, last: int, sums: Real) -> float:
            block = self.work_q[:, first:last]
            began = time.perf_counter()
            if forward:
                columns_forward(block)
                if self._held and first == 0:
                    block[0, 0] = 0.0
            middle = time.perf_counter()
            if kernel is not None:
                kernel(first, last, sums, *arguments)
            swept = time.perf_counter()
            if inverse:
                columns_inverse(block)
            return time.perf_counter() - swept + middle - began

        return self.over(task, edges)

    def _bound(self, name: str, first: int, given: dict[str, Any]) -> tuple[Callable[..., None], list[object]]:
        """A sweep and its arguments after the first ones: those given, else what the engine has of that name."""
        kernel, names = KERNELS[name]
        own = self._own
        return kernel, [given[key] if key in given else own[key] for key in names[first:]]

    def _buffer(self, rows: int) -> Real:
        """Rows of a field, padded, for the thread that asks."""
        if not hasattr(self._thread, "buffer"):
            most = max(b - a for a, b in zip(self.row_edges, self.row_edges[1:], strict=False))
            self._thread.buffer = memory(padded((most, self.n), self._kind))
        buffer: Real = self._thread.buffer[:rows]
        return buffer

    def over(self, task: Task, edges: Sequence[int]) -> Real:
        """Run a task over all blocks; returns the sums, shape (SUMS,)."""
        blocks = len(edges) - 1
        sums, seconds = np.zeros((blocks, SUMS)), [0.0] * blocks

        def run(b: int) -> None:
            seconds[b] = task(edges[b], edges[b + 1], sums[b]) or 0.0

        self._each(run, blocks)
        self.fft_seconds += sum(seconds) / min(self.threads, blocks)
        total: Real = sums.sum(axis=0)
        return total

    def _each(self, task: Callable[[int], None], blocks: int) -> None:
        """Run ``task(b)`` for each block b, several at once.

        The threads are Python's own (compiled code releases the lock): they sleep when they have nothing to do, unlike
        OpenMP's, which spin and were seen to slow a shared machine tenfold.
        """

        def run(mine: range) -> None:
            for b in mine:
                task(b)

        if self.threads == 1 or blocks == 1:
            run(range(blocks))
        else:
            pool = self._workers()
            for share in [pool.submit(run, range(t, blocks, self.threads)) for t in range(self.threads)]:
                share.result()

    def _workers(self) -> ThreadPoolExecutor:
        """The threads of this engine; a forked process, in which they do not live on, starts its own."""
        if self._pool is None or self._pool[0] != os.getpid():
            self._pool = os.getpid(), ThreadPoolExecutor(self.threads)
        return self._pool[1]

    def rows_of(self, kernel: Callable[..., None], *arguments: object) -> Real:
        """Sweep over the rows."""
        return self.over(lambda a, b, sums: kernel(a, b, sums, *arguments), self.row_edges)

    # --- whole fields --------------------------------------------------------------------------------------

    def forward(self, values: Real) -> None:
        points = values[:, : self.n]
        self._transform(lambda a, b: rows_forward(points[a:b], self.work_q[a:b]), self.row_edges)
        self._transform(lambda a, b: columns_forward(self.work_q[:, a:b]), self.column_edges)

    def inverse(self, out: Real) -> None:
        points = out[:, : self.n]
        self._transform(lambda a, b: columns_inverse(self.work_q[:, a:b]), self.column_edges)
        self._transform(lambda a, b: rows_inverse(self.work_q[a:b], points[a:b]), self.row_edges)

    def _transform(self, half: Callable[[int, int], None], edges: Sequence[int]) -> None:
        def task(first: int, last: int, sums: Real) -> float:
            began = time.perf_counter()
            half(first, last)
            return time.perf_counter() - began

        self.over(task, edges)

    def elastic_energy(self, offset: Real, gap: Real, one: Real, other: Real) -> float:
        field = reused(whole_rows(one), *self.grid.shape)
        np.subtract(offset, gap, out=field)
        self.forward(field)
        power = self.power(*(reused(whole_rows(each), *self.grid.shape_q) for each in (other, one)))
        power *= self.K
        power[0, 0] = 0.0
        return 0.5 * float(power.sum())

    def power(self, power: Real, other: Real) -> Real:
        """|f_q|² of the spectrum f in ``work_q``, each mode as often as it counts, in the first of two real arrays."""
        np.multiply(self.work_q.real, self.work_q.real, out=power)
        np.multiply(self.work_q.imag, self.work_q.imag, out=other)
        power += other
        power *= self.grid.mode_weights
        return power


def memory(values: Real | Complex) -> Real:
    """The whole memory of a field or spectrum with padded rows, as real numbers."""
    assert values.base is not None  # it is a part of that memory
    return values.base.view(values.real.dtype)


def whole_rows(values: Real) -> Real:
    """The same of an array that may have padded rows or not."""
    return values if values.flags.c_contiguous else memory(values)
