"""The grids of the minimiser: the arrays of each, the passes over them, and what was done on it.

A pass goes over blocks of rows or of columns.  The half of a Fourier transform that runs along them is done while
the block is in the cache, together with the sweep that makes or uses the values: real space exists in blocks only,
but for the gap and the direction.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from continuum.model import laws
from continuum.model.grid import (
    Complex,
    Grid,
    Real,
    block_edges,
    columns_forward,
    columns_inverse,
    over_blocks,
    rows_forward,
    rows_inverse,
)
from continuum.solve.cpu import sweeps

__all__ = ["SMALLEST", "Level", "Work", "memory", "prolong", "restrict", "sum_over"]

SMALLEST = 128
"""Grids of no more points along a side have no coarser one: calls, not points, would take the time."""

Kernel = Callable[..., None]


class Work(NamedTuple):
    """What was done on one grid."""

    shape: tuple[int, int]
    fft_pairs: float
    """Forward and inverse transforms, halved, of this grid."""
    sweeps: int
    """Evaluations of the line search."""
    fft_seconds: float
    """Time in transforms, of all threads divided by their number."""


class Level:
    """The arrays of one grid: gap z and direction d, spectra of gradient, direction and work, and K.

    Parameters
    ----------
    grid : gives shape, transforms and threads.
    stiffness_q : K over the half spectrum.
    mean_stiffness : K at q = 0; infinite holds the mean of the displacement.
    coarser : number of coarser grids wanted; fewer if the grid cannot be halved so often.
    """

    def __init__(self, grid: Grid, stiffness_q: Real, mean_stiffness: float, coarser: int) -> None:
        self.grid = grid
        self.n = grid.shape[1]
        self.held = bool(np.isinf(mean_stiffness))
        self.K = np.array(stiffness_q, order="C")
        self.K[0, 0] = 1.0 if self.held else mean_stiffness
        self.g_q, self.d_q, self.work_q = (grid.empty_q() for _ in range(3))
        self.g, self.d, self.work = map(memory, (self.g_q, self.d_q, self.work_q))
        self.z, self.direction = memory(grid.empty()), memory(grid.empty())
        self.weights = np.ascontiguousarray(grid.mode_weights[0])
        self.near = np.zeros((grid.shape[0], -(-self.n // laws.TILE)), dtype=np.bool_)
        # Small grids are not worth the start of threads.
        self.threads = grid.threads if grid.size >= 2**17 else 1
        self.row_edges = block_edges(grid.shape[0], grid.size)
        self._thread = threading.local()
        self.transforms, self.sweeps, self.fft_seconds = 0, 0, 0.0
        self.coarser: Level | None = None
        low = (0, 0)
        below = grid.coarser
        if coarser > 0 and below is not None and min(grid.shape) > SMALLEST:
            rows, columns = below.shape_q
            cut = np.r_[: rows // 2, grid.shape[0] - rows // 2 : grid.shape[0]]
            self.coarser = Level(below, stiffness_q[cut, :columns], mean_stiffness, coarser - 1)
            low = rows // 2, columns - 1
        self.low = low
        columns = self.K.shape[1]
        edges = block_edges(columns, grid.size)
        self.column_edges = edges
        parts = [block_edges(low[1], grid.size), block_edges(columns - low[1], grid.size)]
        self.low_edges, self.high_edges = parts[0], [low[1] + edge for edge in parts[1]]

    @property
    def gap(self) -> Real:
        """The field z without the padding of its rows."""
        return self.z[:, : self.n]

    @property
    def chain(self) -> list[Level]:
        """Itself and all coarser ones."""
        return [self, *(self.coarser.chain if self.coarser else [])]

    @property
    def done(self) -> Work:
        """What was done so far."""
        return Work(self.grid.shape, self.transforms / 2, self.sweeps, self.fft_seconds)

    def clear(self) -> None:
        """Forget directions that are not finite: zero times these is not zero."""
        for memory in (self.work_q, self.d_q, self.direction):
            memory[...] = 0.0

    def real(self, kernel: Kernel, *arguments: object) -> Real:
        """Sweep over the rows."""
        return self._sweep(lambda a, b, sums: kernel(a, b, sums, *arguments), self.row_edges)

    def into_rows(self, kernel: Kernel, *arguments: object) -> Real:
        """Sweep that makes a field, its first argument, a buffer; along its rows it is transformed into ``work_q``."""
        self.transforms += 1

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            kernel(first, last, sums, buffer, *arguments)
            began = time.perf_counter()
            rows_forward(buffer[:, : self.n], self.work_q[first:last])
            return time.perf_counter() - began

        return self._sweep(task, self.row_edges)

    def from_rows(self, kernel: Kernel, *arguments: object) -> Real:
        """Transform ``work_q`` along its rows and sweep over the field, the kernel's first argument, a buffer."""
        self.transforms += 1

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            began = time.perf_counter()
            rows_inverse(self.work_q[first:last], buffer[:, : self.n])
            seconds = time.perf_counter() - began
            kernel(first, last, sums, buffer, *arguments)
            return seconds

        return self._sweep(task, self.row_edges)

    def spectral(
        self,
        edges: Sequence[int],
        kernel: Kernel | None,
        *arguments: object,
        forward: bool = False,
        inverse: bool = False,
    ) -> Real:
        """Sweep over the columns between the edges, after and before a transform of ``work_q`` along them.

        A mean that is held has no gradient.
        """

        def task(first: int, last: int, sums: Real) -> float:
            block = self.work_q[:, first:last]
            began = time.perf_counter()
            if forward:
                columns_forward(block)
                if self.held and first == 0:
                    block[0, 0] = 0.0
            middle = time.perf_counter()
            if kernel is not None:
                kernel(first, last, sums, *arguments)
            swept = time.perf_counter()
            if inverse:
                columns_inverse(block)
            return time.perf_counter() - swept + middle - began

        return self._sweep(task, edges)

    def _sweep(self, task: Callable[[int, int, Real], float | None], edges: Sequence[int]) -> Real:
        sums, seconds = sum_over(task, edges, self.threads)
        self.fft_seconds += seconds / min(self.threads, len(edges) - 1)
        return sums

    def _buffer(self, rows: int) -> Real:
        """Rows of a field, padded, for the thread that asks."""
        if not hasattr(self._thread, "buffer"):
            most = max(b - a for a, b in zip(self.row_edges, self.row_edges[1:], strict=False))
            self._thread.buffer = np.empty((most, self.z.shape[1]))
        buffer: Real = self._thread.buffer[:rows]
        return buffer


def sum_over(task: Callable[[int, int, Real], float | None], edges: Sequence[int], threads: int) -> tuple[Real, float]:
    """Run ``task(first, last, sums)`` over fixed blocks; returns the sums, shape (SUMS,), and the total of its answers.

    Added up in the order of the blocks: the same for any number of threads.
    """
    blocks = len(edges) - 1
    sums, answers = np.zeros((blocks, sweeps.SUMS)), [0.0] * blocks

    def run(b: int) -> None:
        answers[b] = task(edges[b], edges[b + 1], sums[b]) or 0.0

    over_blocks(run, blocks, threads)
    total: Real = sums.sum(axis=0)
    return total, sum(answers)


def memory(values: Real | Complex) -> Real:
    """The whole memory of a field or spectrum with padded rows, as real numbers."""
    whole: Real = values.base.view(np.float64)  # type: ignore[union-attr]
    return whole


def restrict(fine: Complex, coarse: Complex) -> None:
    """The modes that a coarser grid carries, its Nyquist modes left out."""
    m, n = coarse.shape[0] // 2, coarse.shape[1] - 1
    coarse[m] = 0
    coarse[:, n] = 0
    coarse[:m, :n] = fine[:m, :n]
    coarse[m + 1 :, :n] = fine[fine.shape[0] - m + 1 :, :n]


def prolong(coarse: Complex, fine: Complex) -> None:
    """A half spectrum on a finer grid: zero beyond the modes of the coarse one."""
    m, n = coarse.shape[0] // 2, coarse.shape[1] - 1
    fine[...] = 0
    fine[:m, :n] = coarse[:m, :n]
    fine[fine.shape[0] - m + 1 :, :n] = coarse[m + 1 :, :n]
