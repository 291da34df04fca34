"""Passes over the arrays of one grid: blocks of rows or columns, some threads, and what was done.

A pass goes over fixed blocks, of which each has one thread; their sums are added in the order of the blocks.  So the
number of threads changes no bit of a result.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np

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
from continuum.solve.cpu.compiled import SUMS
from continuum.solve.solution import Work

Kernel = Callable[..., None]
Task = Callable[[int, int, Real], float | None]
"""Of a block, ``first:last``: writes its sums, returns the seconds it took in transforms."""
_WORTH_THREADS = 2**17  # points; smaller grids are not worth the start of threads


class Passes:
    """One grid: its stiffness, a spectrum to work in, and passes over them.

    Parameters
    ----------
    grid : gives the shape.
    K : over the half spectrum, shape ``grid.shape_q``; owned from now on, since K at q = 0 is that of each problem.
    threads : of a pass.
    """

    def __init__(self, grid: Grid, K: Real, threads: int) -> None:
        self.grid, self.size = grid, grid.size
        self.K = K
        self.work_q: Complex = padded(grid.shape_q, np.complex128)
        self.threads = threads if grid.size >= _WORTH_THREADS else 1
        self.row_edges = block_edges(grid.shape[0], grid.size)
        self.column_edges = block_edges(grid.shape_q[1], grid.size)
        self.transforms, self.trials, self.fft_seconds = 0, 0, 0.0

    def forget_work(self) -> None:
        """Count from zero."""
        self.transforms, self.trials, self.fft_seconds = 0, 0, 0.0

    @property
    def work(self) -> Work:
        """What was done on this grid for the problem at hand."""
        return Work(self.grid.shape, self.transforms / 2, self.trials, self.fft_seconds)

    def over(self, task: Task, edges: Sequence[int]) -> Real:
        """Run a task over all blocks; returns the sums, shape (SUMS,)."""
        blocks = len(edges) - 1
        sums, seconds = np.zeros((blocks, SUMS)), [0.0] * blocks

        def run(b: int) -> None:
            seconds[b] = task(edges[b], edges[b + 1], sums[b]) or 0.0

        _each(run, blocks, self.threads)
        self.fft_seconds += sum(seconds) / min(self.threads, blocks)
        total: Real = sums.sum(axis=0)
        return total

    def real(self, kernel: Kernel, *arguments: object) -> Real:
        """Sweep over the rows."""
        return self.over(lambda a, b, sums: kernel(a, b, sums, *arguments), self.row_edges)

    def forward(self, values: Real) -> None:
        """Spectrum of a field into ``work_q``, not counted."""
        self._transform(lambda a, b: rows_forward(values[a:b], self.work_q[a:b]), self.row_edges)
        self._transform(lambda a, b: columns_forward(self.work_q[:, a:b]), self.column_edges)

    def inverse(self, out: Real) -> None:
        """Field of the spectrum in ``work_q``, which is destroyed; not counted."""
        self._transform(lambda a, b: columns_inverse(self.work_q[:, a:b]), self.column_edges)
        self._transform(lambda a, b: rows_inverse(self.work_q[a:b], out[a:b]), self.row_edges)

    def _transform(self, half: Callable[[int, int], None], edges: Sequence[int]) -> None:
        def task(first: int, last: int, sums: Real) -> float:
            began = time.perf_counter()
            half(first, last)
            return time.perf_counter() - began

        self.over(task, edges)

    def fluctuation_energy(self, offset: Real, gap: Real, field: Real, power: Real, other: Real) -> float:
        """½ Σ K |u_q|² of u = offset - gap without its mean; in memory for a field and two real half spectra."""
        np.subtract(offset, gap, out=field)
        self.forward(field)
        self.power(power, other)
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


def _each(task: Callable[[int], None], blocks: int, threads: int) -> None:
    """Run ``task(b)`` for each block b, several at once.

    The threads are Python's own (compiled code releases the lock): they sleep when they have nothing to do, unlike
    OpenMP's, which spin and were seen to slow a shared machine tenfold.
    """

    def run(mine: range) -> None:
        for b in mine:
            task(b)

    if threads == 1 or blocks == 1:
        run(range(blocks))
    else:
        for share in [_pool(threads).submit(run, range(t, blocks, threads)) for t in range(threads)]:
            share.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads)


# The threads of a pool do not live on in a forked process, which would wait for them for ever: it makes its own.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)


def memory(values: Real | Complex) -> Real:
    """The whole memory of a field or spectrum with padded rows, as real numbers."""
    assert values.base is not None  # it is a part of that memory
    return values.base.view(np.float64)


def lent(whole: Real, *shape: int) -> Real:
    """Memory that is not in use, as an array of this shape."""
    return whole.ravel()[: math.prod(shape)].reshape(shape)
