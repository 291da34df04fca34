"""One grid of the smooth solver on processor cores: what :class:`continuum.solve.backend.Level` asks for.

The half of a Fourier transform that runs along the rows or columns of a block is done while the block is in the cache,
together with the sweep that makes or uses the values: real space exists in blocks only, but for the gap and the
direction.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

import numpy as np

from continuum.model.fourier import (
    Complex,
    Real,
    block_edges,
    columns_forward,
    columns_inverse,
    cut,
    padded,
    prolong,
    restrict,
    rows_forward,
    rows_inverse,
)
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.cpu import sweeps, tractions
from continuum.solve.cpu.compiled import TILE
from continuum.solve.cpu.passes import Kernel, Passes, lent, memory

NEAR = 0.5
"""Points within this distance of the reach of the law are near the wall, in a0: the line search asks these alone."""


class Level(Passes):
    """The arrays of one grid: gap z and direction d, spectra of gradient, direction and work, and K.

    Parameters
    ----------
    grid, K, threads : as for all passes.
    coarser : number of coarser grids wanted; fewer if the grid cannot be halved so often.
    smallest : grids of no more points along a side have no coarser one.
    """

    law: Law
    offset: Real
    start: Real | None = None
    lift = pressure = 0.0
    held = False

    def __init__(self, grid: Grid, K: Real, threads: int, coarser: int, smallest: int) -> None:
        super().__init__(grid, K, threads)
        self.n = grid.shape[1]
        self.g_q: Complex = padded(grid.shape_q, np.complex128)
        self.d_q: Complex = padded(grid.shape_q, np.complex128)
        self.g, self.d, self.w = map(memory, (self.g_q, self.d_q, self.work_q))
        self.z = self.direction = np.empty((0, 0))
        self.weights = np.ascontiguousarray(grid.mode_weights[0])
        self.near = np.zeros((grid.shape[0], -(-self.n // TILE)), dtype=np.bool_)
        self._thread = threading.local()
        self.coarser: Level | None = None
        self.low_rows = self.low_columns = 0
        below = grid.coarser
        if coarser > 0 and below is not None and min(grid.shape) > smallest:
            self.coarser = Level(below, cut(K, below.shape_q), threads, coarser - 1, smallest)
            self.low_rows, self.low_columns = below.shape_q[0] // 2, below.shape_q[1] - 1
        high = block_edges(grid.shape_q[1] - self.low_columns, grid.size)
        self.low_edges, self.high_edges = block_edges(self.low_columns, grid.size), [self.low_columns + e for e in high]

    @property
    def gap(self) -> Real:
        """The field z without the padding of its rows."""
        return self.z[:, : self.n]

    # --- the problem ---------------------------------------------------------------------------------------

    def pose(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        """Take a problem."""
        points = offset if start is None else start
        # A sum is finite only if all its terms are, and needs no memory.
        if not np.isfinite(points.sum() + offset.sum() + lift):
            return False
        self.offset, self.start = np.ascontiguousarray(offset), start
        for level in self._chain:
            level.law, level.lift, level.pressure, level.held = law, lift, pressure, bool(np.isinf(mean_stiffness))
            level.K[0, 0] = 1.0 if level.held else mean_stiffness
            level.z, level.direction = memory(padded(level.grid.shape)), memory(padded(level.grid.shape))
            level.d_q[...] = 0.0  # may be of a solve that failed, and zero times what is not finite is not zero
            level.forget_work()
        return True

    def pose_coarser(self, *, started: bool) -> None:
        """Give the coarser grid its part of offset and start."""
        below = self._below
        # The direction is not in use yet: what the coarse grid needs meanwhile lies in its memory.
        offset, start = lent(self.direction, 2, *below.grid.shape)
        if started:
            below.inverse(start)
        mean = self._into_rows(sweeps.copy, self.offset, self.n)[0] / self.size
        self._spectral(self.column_edges, None, forward=True)
        self.work_q[0, 0] = mean
        restrict(self.work_q, below.work_q)
        below.inverse(offset)
        if started:
            np.subtract(offset, start, out=start)
            start += self.lift
        below.offset, below.start = offset, start if started else None

    def place(self) -> None:
        """Go to the start."""
        assert self.start is not None
        self.gap[...] = self.start
        self.start = None
        mean = self._displace()
        if self.held:
            self.gap[...] += mean
        if self.coarser is not None:
            restrict(self.work_q, self.coarser.work_q)
        self._elastic()
        self._press()

    def rest(self) -> None:
        """Go to where nothing is displaced."""
        np.add(self.offset, self.lift, out=self.gap)
        self.work_q[...] = 0.0
        self._elastic()
        self._press()

    def prolong(self) -> None:
        """Go to the state of the coarser grid."""
        below = self._below
        # A coarse grid that failed is no start: this one begins from rest.
        if not np.isfinite(below._displace()):
            below.clear()
        prolong(below.work_q, self.work_q)
        self._elastic()
        self._spectral(self.column_edges, None, inverse=True)
        self._from_rows(sweeps.lay, self.z, self.n, self.offset, self.lift)
        self._press()

    # --- an iteration --------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        """Finish a step, and precondition."""
        if complete:
            self.work_q[...] = 0.0
        low_rows, low_columns = (self.low_rows, self.low_columns) if coarse else (0, 0)
        sweep = sweeps.gradient, self.g, self.d, self.w, self.K, shift, alpha, beta, low_rows, low_columns, self.weights
        if not coarse:
            return self._spectral(self.column_edges, *sweep, forward=not complete, inverse=True)
        sums = self._spectral(self.low_edges, *sweep, forward=not complete)
        sums += self._spectral(self.high_edges, *sweep, forward=not complete, inverse=True)
        return sums

    def restrict(self) -> None:
        """Let the coarser grid begin from here: at every second gap, with its part of the gradient."""
        below = self._below
        below.real(sweeps.every_second, self.z, below.z, below.n, below.near_gap, below.near)
        restrict(self.g_q, below.g_q)

    def low_modes(self, shift: float) -> Real:
        """The step of the coarser grid."""
        below = self._below
        below._into_rows(sweeps.moved, self.z, below.z, below.n)
        below._spectral(below.column_edges, None, forward=True)
        arguments = self.g, self.d, self.w, self.K, shift, self.low_rows, self.weights, below.w
        return self._spectral(self.low_edges, sweeps.low_modes, *arguments)

    def low_gradient(self, shift: float) -> Real:
        """The gradient's own step, where that of the coarser grid does not serve."""
        arguments = self.g, self.w, self.K, shift, self.low_rows, self.weights
        return self._spectral(self.low_edges, sweeps.low_gradient, *arguments)

    def turn(self, beta: float, *, coarse: bool) -> float:
        """Turn the direction."""
        if coarse:
            self._spectral(self.low_edges, sweeps.low_direction, self.d, self.w, self.low_rows, beta, inverse=True)
        law = self.law
        wall = self.z, law.kind, law.parameters, self.near
        return float(self._from_rows(tractions.turn, self.direction, self.n, beta, *wall)[0]) / self.size

    def line(self, alpha: float) -> tuple[float, float]:
        """Look ahead."""
        self.trials += 1
        law = self.law
        arguments = self.z, self.direction, self.n, alpha, law.kind, law.parameters, self.near
        slope, curvature = self.real(tractions.line, *arguments)[:2] / self.size
        return float(slope), float(curvature)

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        """Go."""
        law = self.law
        wall = law.kind, law.parameters, law.reach, self.near_gap, self.near
        sums = self._into_rows(tractions.move, self.z, self.direction, self.n, step, alpha, *wall)
        slope, second, size = sums[:3] / self.size
        return float(slope), float(second), float(size)

    def clear(self) -> None:
        """Forget the direction."""
        for values in (self.work_q, self.d_q, self.direction):
            values[...] = 0.0

    # --- the outcome ---------------------------------------------------------------------------------------

    def residual(self) -> float:
        """Gradient afresh."""
        self._displace()
        self._elastic()
        self._press()
        self._spectral(self.column_edges, None, forward=True)
        self.g_q += self.work_q
        return float(np.sqrt(self._spectral(self.column_edges, sweeps.square, self.g, self.weights)[0]))

    def take_gap(self) -> Real:
        """Hand the gap out; the next problem has a new one."""
        gap = self.gap
        # All fields in real space go: who looks at the gap has their memory meanwhile, and spectra are what is left.
        for level in self._chain:
            level.z = level.direction = level.offset = np.empty((0, 0))
        return gap

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u, K u> of u = offset - gap without its mean."""
        power, other = lent(self.d, 2, *self.grid.shape_q)
        return self.fluctuation_energy(offset, gap, lent(self.g, *self.grid.shape), power, other)

    # --- its parts -----------------------------------------------------------------------------------------

    @property
    def near_gap(self) -> float:
        """Gap below which a point is near the wall."""
        return self.law.reach + NEAR

    @property
    def _below(self) -> Level:
        assert self.coarser is not None
        return self.coarser

    @property
    def _chain(self) -> list[Level]:
        """Itself and all coarser ones."""
        return [self, *(self.coarser._chain if self.coarser else [])]

    def _displace(self) -> float:
        """Spectrum of the displacement into ``work_q``; returns its mean."""
        sums = self._into_rows(sweeps.displace, self.z, self.n, self.offset, self.lift)
        self._spectral(self.column_edges, None, forward=True)
        return float(sums[0]) / self.size

    def _elastic(self) -> None:
        """Gradient without the traction of the wall, from the spectrum of the displacement: K u - F."""
        np.multiply(self.K, self.work_q, out=self.g_q)
        if not self.held:
            self.g_q[0, 0] -= self.pressure

    def _press(self) -> None:
        """Traction of the gap, transformed along the rows."""
        law = self.law
        self._into_rows(tractions.press, self.z, self.n, law.kind, law.parameters, law.reach, self.near_gap, self.near)

    def _into_rows(self, kernel: Kernel, *arguments: object) -> Real:
        """Sweep that makes a field, its first argument, a buffer; along its rows it is transformed into ``work_q``."""
        self.transforms += 1

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            kernel(first, last, sums, buffer, *arguments)
            began = time.perf_counter()
            rows_forward(buffer[:, : self.n], self.work_q[first:last])
            return time.perf_counter() - began

        return self.over(task, self.row_edges)

    def _from_rows(self, kernel: Kernel, *arguments: object) -> Real:
        """Transform ``work_q`` along its rows and sweep over the field, the kernel's first argument, a buffer."""
        self.transforms += 1

        def task(first: int, last: int, sums: Real) -> float:
            buffer = self._buffer(last - first)
            began = time.perf_counter()
            rows_inverse(self.work_q[first:last], buffer[:, : self.n])
            seconds = time.perf_counter() - began
            kernel(first, last, sums, buffer, *arguments)
            return seconds

        return self.over(task, self.row_edges)

    def _spectral(
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

        return self.over(task, edges)

    def _buffer(self, rows: int) -> Real:
        """Rows of a field, padded, for the thread that asks."""
        if not hasattr(self._thread, "buffer"):
            most = max(b - a for a, b in zip(self.row_edges, self.row_edges[1:], strict=False))
            self._thread.buffer = np.empty((most, self.z.shape[1]))
        buffer: Real = self._thread.buffer[:rows]
        return buffer
