"""Linear problems of coarser grids on processor cores: single precision, and small grids in one compiled call.

On grids of at most 256 x 256 points a call costs as much as its work.  There the conjugate directions, over all coarser
grids and with their transforms, are one call.
"""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np
from rocket_fft import c2c, c2r, r2c

from continuum.model.fourier import Complex, Real
from continuum.model.grid import Grid
from continuum.solve.coarse import coarse_step
from continuum.solve.compiled.compiling import SUMS, Field, Single, compiled, scalar
from continuum.solve.compiled.passes import Passes
from continuum.solve.compiled.points import linear_turn, sampled
from continuum.solve.compiled.sweeps import (
    finish_low_modes,
    linear_gradient,
    linear_last,
    low_direction,
    low_gradient,
    restrict_modes,
)
from continuum.solve.conjugate import Line, conjugate_line

SMALL = 2**16
"""Points of a grid that is swept in one call, at most."""
LEVELS = 2
"""Grids of such a call, mostly."""
_line = scalar(conjugate_line)


class Level(NamedTuple):
    """The arrays of one grid."""

    K: Field
    weights: Field
    g: Field
    d: Field
    x: Field
    work: Field
    work_q: Complex
    """The same as complex numbers, without padding."""
    stiffness: Single
    direction: Field
    buffer: Field
    """A field."""
    low_rows: int
    low_columns: int
    c0: float
    """For the modes of no coarser grid, beside a step of that."""


@compiled
def _gradient(grid: Level, c0: float, alpha: float, beta: float, held: bool, first: bool, low: tuple[int, int]) -> Real:
    """Finish a step, as :meth:`CompiledLinearGrid._gradient`; returns the sums."""
    sums = np.zeros(SUMS)
    work_q, K = grid.work_q, grid.K
    if not first:
        c2c(work_q, work_q, np.array([0]), True, 1.0 / K.shape[0], 1)
        if held:
            work_q[0, 0] = 0.0
    rows, columns = low
    for a, b in ((0, columns), (columns, K.shape[1])):
        linear_gradient(a, b, sums, grid.g, grid.d, grid.x, grid.work, K, c0, alpha, beta, rows, columns, grid.weights)
    return sums


@compiled
def _turn(grid: Level, beta: float) -> float:
    """Set the direction, as :meth:`CompiledLinearGrid._turn`; returns <stiffness d d>."""
    sums, across = np.zeros(SUMS), np.array([1])
    rows, n = grid.buffer.shape
    c2c(grid.work_q, grid.work_q, np.array([0]), False, 1.0, 1)
    c2r(grid.work_q, grid.buffer, across, False, 1.0, 1)
    linear_turn(0, rows, sums, grid.buffer, grid.direction, n, beta, grid.stiffness)
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
    """Approach the minimum, as :meth:`CompiledLinearGrid._descend`; counts the pairs of transforms."""
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
            of, n = grid.buffer.shape[1], below.buffer.shape[1]
            sampled(0, below.buffer.shape[0], part, grid.stiffness, of, below.stiffness, n)
            restrict_modes(0, low[1], part, grid.g, below.g, low[0], low[1], size)
            conjugate = _relax(levels, at + 1, depth - 1, c0, held, iterations, reduction, pairs)
            if conjugate:
                finish_low_modes(
                    0, low[1], part, grid.g, grid.d, grid.work, grid.K, c0, low[0], grid.weights, below.x, size
                )
                conjugate = np.isfinite((sums + part).sum()) and sums[1] + part[1] > 0
            if not conjugate:
                part[:] = 0.0
                low_gradient(0, low[1], part, grid.g, grid.work, grid.K, c0, low[0], grid.weights)
            sums += part
        line = _line(sums, line, 0.0, conjugate)
        if depth > 1:
            low_direction(0, low[1], sums, grid.d, grid.work, low[0], line.beta)
        pairs[at] += 1.0
        curvature = line.curvature + _turn(grid, line.beta)
        if not curvature > 0:
            return iteration > 0
        alpha = -line.slope / curvature
    for a, b in ((0, low[1]), (low[1], grid.K.shape[1])):
        linear_last(a, b, pairs, grid.g, grid.d, grid.x, grid.K, c1, alpha, line.beta, low[0], low[1])
    return True


class SteppedPasses(Passes):
    """What the two kinds of grids share: spectra of a gradient g and a direction d, and steps of a coarser grid."""

    stiffness: Single
    """Of the wall."""
    g: Field
    d: Field
    linear: CompiledLinearGrid | None = None
    """The linear problem of the next coarser grid."""

    def restrict(self, size: float) -> None:
        below = self.linear
        assert below is not None
        below.sample(self.stiffness, self.n, below.stiffness)
        self.restrict_q(self.g, below.g, size)

    def low_modes(self, shift: float, size: float) -> Real:
        below = self.linear
        assert below is not None

        def sweep(a: int, b: int, sums: Real) -> None:
            rows = self.low_part[0]
            finish_low_modes(a, b, sums, self.g, self.d, self.w, self.K, shift, rows, self.weights, below.x, size)

        return self.low(sweep)

    def low_gradient(self, shift: float) -> Real:
        rows, K, weights = self.low_part[0], self.K, self.weights
        return self.low(lambda a, b, sums: low_gradient(a, b, sums, self.g, self.w, K, shift, rows, weights))

    def low_direction(self, beta: float) -> None:
        """Set d <- beta d - s for the modes of the coarser grid."""
        rows = self.low_part[0]
        self.low(lambda a, b, sums: low_direction(a, b, sums, self.d, self.w, rows, beta), inverse=True)

    def modes(self, shift: float, *, coarse: bool) -> tuple[int, int, float]:
        """Rows and columns that a sweep leaves to the coarser grid, and c0 for the others."""
        return self.low_part if coarse else (0, 0, shift)


class CompiledLinearGrid(SteppedPasses):
    """The linear problem (K + stiffness) x = -g of a grid, for a step of the next finer one.

    Parameters
    ----------
    grid, stiffness_q, threads : as for :class:`continuum.solve.compiled.smooth_grid.CompiledSmoothGrid`.
    precision : of its arrays.
    coarser : the same of the next coarser grid.
    spectra : memory of three spectra of the grid in double precision, in which the arrays of single precision lie: the
        finer grid asks for a step only where the nonlinear problem of the grid is no more at work.
    """

    def __init__(
        self,
        grid: Grid,
        stiffness_q: Real,
        threads: int,
        precision: type,
        coarser: CompiledLinearGrid | None,
        spectra: tuple[Real, Real, Real],
    ) -> None:
        K: Field = np.array(stiffness_q, dtype=precision, order="C")
        super().__init__(grid, K, threads, coarser.grid if coarser else None)
        self.linear = coarser
        if precision is np.float64:
            self.g, self.d, self.x = (self.spectrum() for _ in range(3))
            self.stiffness, self.direction = self.single_rows(), self.rows()
        else:
            # Six arrays in single precision are as large as three in double precision, with half of their padding.
            halves: list[Any] = [
                half.reshape(grid.shape[0], -1)
                for each in spectra
                for half in np.split(each.reshape(-1).view(np.float32), 2)
            ]
            self.g, self.d, self.x, self.w, self.stiffness, self.direction = halves
            self.work_q = cast("Any", self.w.view(np.complex64)[:, : grid.shape_q[1]])
        below = coarser.levels if coarser else ()
        self.levels: tuple[Level, ...] = (self._level(), *below) if self.size <= SMALL else ()
        """The arrays of this grid and of coarser ones, where all of a step is one call."""

    def _level(self) -> Level:
        buffer = self._buffer(self.grid.shape[0])[:, : self.n]
        spectra = self.g, self.d, self.x, self.w, self.work_q
        return Level(self.K, self.weights, *spectra, self.stiffness, self.direction, buffer, *self.low_part)

    @property
    def chain(self) -> list[CompiledLinearGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.linear.chain if self.linear else [])]

    def relax(self, levels: int, shift: float, iterations: int, reduction: float) -> bool:
        if not self.levels:
            return self._descend(levels, shift, iterations, reduction)
        pairs, depth = np.zeros(len(self.levels)), min(levels, len(self.levels))
        # Tuples of one length are one type, for which the loops are compiled once; the one added is not used.
        given = self.levels + self.levels[-1:] * (LEVELS - len(self.levels))
        moved = _relax(given, 0, depth, shift, self.held, iterations, reduction, pairs)
        for grid, count in zip(self.chain, pairs, strict=True):
            grid.transforms += 2 * int(count)
        return bool(moved)

    def _descend(self, levels: int, shift: float, iterations: int, reduction: float) -> bool:
        """The same by passes over large grids."""
        coarse = self.linear is not None and levels > 1
        line, alpha, bound = Line(0.0, 0.0, 0.0), 0.0, 0.0
        for values in (self.x, self.d, self.direction, self.w):
            values[...] = 0.0
        for iteration in range(iterations):
            sums = self._gradient(shift, alpha, line.beta, coarse=coarse, first=iteration == 0)
            if iteration == 0:
                bound = reduction**2 * sums[0]
            elif not sums[0] > bound:
                return True
            conjugate = True
            if coarse:
                sums, conjugate = coarse_step(self, levels, shift, sums)
            line = conjugate_line(sums, line, 0.0, conjugate)
            curvature = line.curvature + self._turn(line.beta, coarse=coarse)
            if not curvature > 0:
                # The wall is softer than the substrate along this direction: there is no minimum to go to.
                return iteration > 0
            alpha = -line.slope / curvature
        self._finish(shift, alpha, line.beta, coarse=coarse)
        return True

    def _gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, first: bool) -> Real:
        """Take the last step, of length ``alpha``: x and g; s = M g."""
        rows, columns, c0 = self.modes(shift, coarse=coarse)

        def sweep(a: int, b: int, sums: Real) -> None:
            spectra = self.g, self.d, self.x, self.w, self.K
            linear_gradient(a, b, sums, *spectra, c0, alpha, beta, rows, columns, self.weights)

        return self.spectral(sweep, forward=not first, inverse=True, keep_low=coarse)

    def _turn(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <stiffness d d>."""
        if coarse:
            self.low_direction(beta)

        def sweep(a: int, b: int, sums: Real, s: Real) -> None:
            linear_turn(a, b, sums, s, self.direction, self.n, beta, self.stiffness)

        return float(self.through(sweep)[0]) / self.size

    def _finish(self, shift: float, alpha: float, beta: float, *, coarse: bool) -> None:
        """Take the last step, after which nothing follows: x alone."""
        rows, columns, c0 = self.modes(shift, coarse=coarse)

        def sweep(a: int, b: int, sums: Real) -> None:
            linear_last(a, b, sums, self.g, self.d, self.x, self.K, c0, alpha, beta, rows, columns)

        self.spectral(sweep, keep_low=coarse)
