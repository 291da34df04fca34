"""Passes over the arrays of one grid on processor cores: in padded rows, by blocks, with transforms and threads.

A pass goes over fixed blocks of rows or columns, of which each has one thread; their sums are added in the order of
the blocks.  So the number of threads changes no bit of a result.  The half of a Fourier transform that runs along the
rows or columns of a block is done while the block is in the cache, together with the sweep that makes or uses the
values.
"""

import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import prod
from typing import Any, Concatenate, ParamSpec

import numpy as np
from numpy.typing import NDArray

from continuum.model import fourier
from continuum.model.fourier import Complex, Real, block_edges, padded
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve import backend
from continuum.solve.compiled import points, spectra
from continuum.solve.compiled.compiling import SUMS, TILE, Field, Mask, Single
from continuum.solve.solution import Work

Sweep = Callable[[int, int, Real], None]
"""A function of the block ``first:last``, which writes its sums: six numbers."""
Buffered = Callable[[int, int, Real, Real], None]
"""The same, which makes or uses rows that are transformed: the last argument."""
Given = ParamSpec("Given")
Task = Callable[Concatenate[int, int, Real, Given], float | None]
"""A sweep that is given more than its block and sums; it may return the seconds that it took in transforms."""
_WORTH_THREADS = 2**17  # points; smaller grids are not worth the start of threads


class Passes:
    """The arrays of one grid, and sweeps over them, with threads that sleep between.

    A transform goes by way of one spectrum, ``w``: a field is made, or used, by :meth:`through`, and :meth:`spectral`
    goes over the modes.  Each pass returns six sums.

    Parameters
    ----------
    grid : gives the shape.
    K : over the half spectrum, shape ``grid.shape_q``; owned from now on, since K at q = 0 is that of each problem.
        All arrays have its precision.
    threads : of a pass.
    below : the next coarser grid, whose modes are swept apart.
    """

    law: Law

    def __init__(self, grid: Grid, K: Real, threads: int, below: Grid | None = None) -> None:
        self.grid, self.size, self.n = grid, grid.size, grid.shape[1]
        self.K, self._kind = K, K.dtype
        self.work_q: Complex = padded(grid.shape_q, np.result_type(K.dtype, np.complex64))
        self.w = memory(self.work_q)
        """The spectrum that is transformed, real and imaginary parts in turn."""
        self.weights = np.ascontiguousarray(grid.mode_weights[0], dtype=K.dtype)
        self.threads = threads if grid.size >= _WORTH_THREADS else 1
        self.row_edges = block_edges(grid.shape[0], grid.size)
        self.column_edges = block_edges(grid.shape_q[1], grid.size)
        rows, columns = (fourier.low_rows(below.shape_q[0]), below.shape_q[1] - 1) if below else (0, 0)
        self.low_part = rows, columns, backend.SHORT_WAVES * float(K[:, 1:].max()) if below else 0.0
        """Rows and columns of the modes of the coarser grid; and c0 for the others, beside a step of that grid."""
        self.low_edges = block_edges(columns, grid.size)
        self.high_edges = [columns + e for e in block_edges(grid.shape_q[1] - columns, grid.size)]
        self.near: Mask = np.zeros((grid.shape[0], -(-self.n // TILE)), dtype=np.bool_)
        self.held = False
        """Whether the mean is: then its mode vanishes after each forward transform in a sweep."""
        self._thread = threading.local()
        self._pool: tuple[int, ThreadPoolExecutor] | None = None
        self.forget_work()

    def forget_work(self) -> None:
        """Count the work from zero again."""
        self.transforms, self.trials, self.fft_seconds = 0.0, 0, 0.0

    @property
    def own_work(self) -> Work:
        """What was done on this grid for the problem at hand."""
        return Work(self.grid.shape, self.transforms / 2, self.trials, self.fft_seconds)

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        """Set K at q = 0."""
        self.K[0, 0], self.held = stiffness, held

    # --- arrays ------------------------------------------------------------------------------------------------

    def rows(self) -> Real:
        """Memory of a field, with padded rows."""
        return memory(padded(self.grid.shape, self._kind))

    def single_rows(self) -> Single:
        """The same in single precision."""
        values: Single = padded(self.grid.shape, np.float32)
        assert values.base is not None
        return values.base

    def spectrum(self) -> Real:
        """Memory of a half spectrum."""
        return memory(padded(self.grid.shape_q, self.work_q.dtype))

    def sample(self, fine: Any, of: int, coarse: Any) -> None:
        """Set a field of this grid to points of the finer one's, of rows of ``of`` points: every second, about."""
        self.sweep(points.sampled, fine, of, coarse, self.n)

    def restrict_q(self, spectrum: Real, coarse: Real, size: float = 1.0) -> None:
        """Set a spectrum of the coarser grid to the modes of this one's over ``size``, without Nyquist modes."""
        self.low(spectra.restrict_modes, spectrum, coarse, *self.low_part[:2], size)

    # --- passes ------------------------------------------------------------------------------------------------

    def sweep(self, sweep: Task[Given], *given: Given.args, **named: Given.kwargs) -> Real:
        """Over the rows, without a transform; what is given follows the block and its sums."""
        return self.over(sweep, self.row_edges, *given, **named)

    def through(self, sweep: Buffered, *, inverse: bool = False, forward: bool = False) -> Real:
        """A field that was transformed back is used, or one is made that is going to be transformed; or both."""
        self.transforms += inverse + forward

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            began = time.perf_counter()
            if inverse:
                fourier.rows_inverse(self.work_q[first:last], buffer[:, : self.n])
            middle = time.perf_counter()
            sweep(first, last, sums, buffer)
            swept = time.perf_counter()
            if forward:
                fourier.rows_forward(buffer[:, : self.n], self.work_q[first:last])
            return time.perf_counter() - swept + middle - began

        return self.over(task, self.row_edges)

    def spectral(
        self, sweep: Sweep | None = None, *, forward: bool = False, inverse: bool = False, keep_low: bool = False
    ) -> Real:
        """Over the modes, after the other half of a forward transform and before half an inverse one.

        With ``keep_low`` the modes of the coarser grid are not transformed back yet: :meth:`low_inverse` does so.
        """
        if not keep_low:
            return self._columns(self.column_edges, sweep, forward, inverse)
        sums = self._columns(self.low_edges, sweep, forward, False)
        sums += self._columns(self.high_edges, sweep, forward, inverse)
        return sums

    def low(self, sweep: Task[Given], *given: Given.args, **named: Given.kwargs) -> Real:
        """Over the modes of the coarser grid, without a transform."""
        return self.over(sweep, self.low_edges, *given, **named)

    def low_inverse(self, sweep: Sweep) -> None:
        """Over the same modes, which are then transformed back as :meth:`spectral` does it."""
        self._columns(self.low_edges, sweep, False, True)

    def _columns(self, edges: Sequence[int], sweep: Sweep | None, forward: bool, inverse: bool) -> Real:
        """Over the columns between the edges, after and before a transform of ``work_q`` along them."""

        def task(first: int, last: int, sums: Real) -> float:
            block = self.work_q[:, first:last]
            began = time.perf_counter()
            if forward:
                fourier.columns_forward(block)
                if self.held and first == 0:
                    block[0, 0] = 0.0
            middle = time.perf_counter()
            if sweep is not None:
                sweep(first, last, sums)
            swept = time.perf_counter()
            if inverse:
                fourier.columns_inverse(block)
            return time.perf_counter() - swept + middle - began

        return self.over(task, edges)

    def _buffer(self, rows: int) -> Real:
        """Rows of a field, padded, for the thread that asks."""
        if not hasattr(self._thread, "buffer"):
            most = max(b - a for a, b in zip(self.row_edges, self.row_edges[1:], strict=False))
            self._thread.buffer = memory(padded((most, self.n), self._kind))
        buffer: Real = self._thread.buffer[:rows]
        return buffer

    def over(self, task: Task[Given], edges: Sequence[int], *given: Given.args, **named: Given.kwargs) -> Real:
        """Run a task over all blocks; returns the sums, shape (SUMS,)."""
        blocks = len(edges) - 1
        sums, seconds = np.zeros((blocks, SUMS)), [0.0] * blocks

        def run(b: int) -> None:
            seconds[b] = task(edges[b], edges[b + 1], sums[b], *given, **named) or 0.0

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
        """The threads of this grid; a forked process, in which they do not live on, starts its own."""
        if self._pool is None or self._pool[0] != os.getpid():
            self._pool = os.getpid(), ThreadPoolExecutor(self.threads)
        return self._pool[1]

    # --- whole fields --------------------------------------------------------------------------------------

    def forward(self, values: Field) -> None:
        """Transform a field into ``w``; not counted."""
        points = values[:, : self.n]
        self._transform(lambda a, b: fourier.rows_forward(points[a:b], self.work_q[a:b]), self.row_edges)
        self._transform(lambda a, b: fourier.columns_forward(self.work_q[:, a:b]), self.column_edges)

    def inverse(self, out: Field) -> None:
        """Transform ``w`` back into a field; not counted."""
        points = out[:, : self.n]
        self._transform(lambda a, b: fourier.columns_inverse(self.work_q[:, a:b]), self.column_edges)
        self._transform(lambda a, b: fourier.rows_inverse(self.work_q[a:b], points[a:b]), self.row_edges)

    def _transform(self, half: Callable[[int, int], None], edges: Sequence[int]) -> None:
        def task(first: int, last: int, sums: Real) -> float:
            began = time.perf_counter()
            half(first, last)
            return time.perf_counter() - began

        self.over(task, edges)

    def elastic_energy_in(self, one: Real, other: Real, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in the memory of two arrays that are not in use."""
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


def reused(whole: NDArray[Any], *shape: int) -> NDArray[Any]:
    """Memory that is not in use, as an array of this shape."""
    return whole.ravel()[: prod(shape)].reshape(shape)
