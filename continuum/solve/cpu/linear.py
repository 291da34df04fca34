"""The engine of linear problems on processor cores: single precision, and small grids in one compiled call.

On grids of at most 256 x 256 points a call costs as much as its work.  There the conjugate directions of
:mod:`continuum.solve.smooth`, over all coarser grids and with their transforms, are one call.
"""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np
from rocket_fft import c2c, c2r, r2c

from continuum.model.fourier import Complex, Real
from continuum.solve.backend import Array
from continuum.solve.conjugate import Line, conjugate_line
from continuum.solve.cpu import points, sweeps
from continuum.solve.cpu.compiled import SUMS, compiled, scalar
from continuum.solve.cpu.engine import CpuEngine

SMALL = 2**16
"""Points of a grid that is swept in one call, at most."""
LEVELS = 2
"""Grids of such a call, mostly."""
_line = scalar(conjugate_line)
_restrict, _linear_gradient, _linear_last = sweeps._restrict, sweeps._linear_gradient, sweeps._linear_last
_low_modes, _low_gradient, _low_direction = sweeps._low_modes, sweeps._low_gradient, sweeps._low_direction
_sampled, _linear_turn = points._sampled, points._linear_turn


class Level(NamedTuple):
    """The arrays of one grid."""

    K: Real
    weights: Real
    g: Real
    d: Real
    x: Real
    work: Real
    work_q: Complex
    """The same as complex numbers, without padding."""
    stiffness: Real
    direction: Real
    buffer: Real
    """A field."""
    low_rows: int
    low_columns: int
    c0: float
    """For the modes of no coarser grid, beside a step of that."""


@compiled
def _gradient(grid: Level, c0: float, alpha: float, beta: float, held: bool, first: bool, low: tuple[int, int]) -> Real:
    """Finish a step, as :meth:`continuum.solve.smooth_grid.LinearGrid.gradient`; returns the sums."""
    sums = np.zeros(SUMS)
    work_q, K = grid.work_q, grid.K
    if not first:
        c2c(work_q, work_q, np.array([0]), True, 1.0 / K.shape[0], 1)
        if held:
            work_q[0, 0] = 0.0
    rows, columns = low
    for a, b in ((0, columns), (columns, K.shape[1])):
        _linear_gradient(a, b, sums, grid.g, grid.d, grid.x, grid.work, K, c0, alpha, beta, rows, columns, grid.weights)
    return sums


@compiled
def _turn(grid: Level, beta: float) -> float:
    """Set the direction, as :meth:`continuum.solve.smooth_grid.LinearGrid.turn`; returns <stiffness d d>."""
    sums, across = np.zeros(SUMS), np.array([1])
    rows, n = grid.buffer.shape
    c2c(grid.work_q, grid.work_q, np.array([0]), False, 1.0, 1)
    c2r(grid.work_q, grid.buffer, across, False, 1.0, 1)
    _linear_turn(0, rows, sums, grid.buffer, grid.direction, n, beta, grid.stiffness)
    r2c(grid.buffer, grid.work_q, across, True, 1.0 / n, 1)
    return float(sums[0] / (rows * n))


@compiled
def _relax(
    levels: tuple[Level, ...],
    at: int,
    depth: int,
    c0: float,
    held: bool,
    iterations: int,
    reduction: float,
    pairs: Real,
) -> bool:
    """Approach the minimum, as :func:`continuum.solve.smooth.minimise_linear`; counts the pairs of transforms."""
    grid = levels[at]
    low, c1 = ((grid.low_rows, grid.low_columns), grid.c0) if depth > 1 else ((0, 0), c0)
    grid.d[:] = 0.0
    grid.x[:] = 0.0
    grid.work[:] = 0.0
    grid.direction[:] = 0.0
    line, alpha, bound = Line(0.0, 0.0, 0.0), 0.0, 0.0
    for iteration in range(iterations):
        sums = _gradient(grid, c1, alpha, line.beta, held, iteration == 0, low)
        if iteration == 0:
            bound = reduction * reduction * sums[0]
        elif not sums[0] > bound:
            return True
        conjugate = True
        if depth > 1:
            below, size, part = levels[at + 1], np.sqrt(sums[0]), np.zeros(SUMS)
            _sampled(0, below.buffer.shape[0], part, grid.stiffness, below.stiffness, below.buffer.shape[1])
            _restrict(0, low[1], part, grid.g, below.g, low[0], low[1], size)
            conjugate = _relax(levels, at + 1, depth - 1, c0, held, iterations, reduction, pairs)
            if conjugate:
                _low_modes(0, low[1], part, grid.g, grid.d, grid.work, grid.K, c0, low[0], grid.weights, below.x, size)
                conjugate = np.isfinite((sums + part).sum()) and sums[1] + part[1] > 0
            if not conjugate:
                part[:] = 0.0
                _low_gradient(0, low[1], part, grid.g, grid.work, grid.K, c0, low[0], grid.weights)
            sums += part
        line = _line(sums, line, 0.0, conjugate)
        if depth > 1:
            _low_direction(0, low[1], sums, grid.d, grid.work, low[0], line.beta)
        pairs[at] += 1.0
        curvature = line.curvature + _turn(grid, line.beta)
        if not curvature > 0:
            return iteration > 0
        alpha = -line.slope / curvature
    for a, b in ((0, low[1]), (low[1], grid.K.shape[1])):
        _linear_last(a, b, pairs, grid.g, grid.d, grid.x, grid.K, c1, alpha, line.beta, low[0], low[1])
    return True


class CpuLinearEngine(CpuEngine):
    """What :class:`continuum.solve.backend.LinearEngine` asks for."""

    def fields(self, spectra: tuple[Array, Array, Array]) -> tuple[Array, Array, Array, Array, Array]:
        if self._kind == np.float64:
            return self.spectrum(), self.spectrum(), self.spectrum(), self.single_rows(), self.rows()
        # Six arrays in single precision are as large as three in double precision, with half of their padding.
        rows = self.grid.shape[0]
        halves: list[Any] = [
            half.reshape(rows, -1) for each in spectra for half in np.split(each.reshape(-1).view(np.float32), 2)
        ]
        g, d, x, self.w, stiffness, direction = halves
        self.work_q = cast("Any", self.w.view(np.complex64)[:, : self.grid.shape_q[1]])
        self._own["work"] = self.w
        return g, d, x, stiffness, direction

    def level(self, g: Real, d: Real, x: Real, stiffness: Real, direction: Real) -> Level | None:
        if self.size > SMALL:
            return None
        weights = self._own["weights"]
        assert isinstance(weights, np.ndarray)
        buffer = self._buffer(self.grid.shape[0])[:, : self.n]
        return Level(self.K, weights, g, d, x, self.w, self.work_q, stiffness, direction, buffer, **self.low_part)

    def relax(
        self, levels: tuple[Level, ...], depth: int, shift: float, iterations: int, reduction: float
    ) -> tuple[bool, list[int]]:
        pairs = np.zeros(len(levels))
        # Tuples of one length are one type, for which the loops are compiled once; at the last grid nobody looks twice.
        levels += levels[-1:] * (LEVELS - len(levels))
        moved = _relax(levels, 0, depth, shift, self._held, iterations, reduction, pairs)
        return bool(moved), [2 * int(count) for count in pairs]
