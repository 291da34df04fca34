"""Linear problems of coarser grids on processor cores, in single precision: a step of theirs is a direction only."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.compiled import spectra
from continuum.solve.compiled.compiling import Field, Single
from continuum.solve.compiled.passes import Passes
from continuum.solve.compiled.points import linear_direction
from continuum.solve.compiled.spectra import Low, Spectra
from continuum.solve.conjugate import Line, coarse_step, conjugate_line


class SteppedPasses(Passes):
    """What the two kinds of grids share: spectra of a gradient g and a direction d, and steps of a coarser grid."""

    stiffness: Single
    """The stiffness of the wall."""
    direction: Field
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
        assert self.linear is not None
        return self.low(spectra.finish_low_modes, self.spectra, shift, self.low_part[0], self.linear.x, size)

    def low_gradient(self, shift: float) -> Real:
        return self.low(spectra.low_gradient, self.spectra, shift, self.low_part[0])

    def low_direction(self, beta: float) -> None:
        """Set d <- beta d - s for the modes of the coarser grid."""
        given = self.spectra, self.low_part[0], beta
        self.low_inverse(lambda a, b, sums: spectra.low_direction(a, b, sums, *given))

    def modes(self, shift: float, *, coarse: bool) -> tuple[Low, float]:
        """Rows and columns that a sweep leaves to the coarser grid, and c0 for the others."""
        return (self.low_part[:2], self.low_part[2]) if coarse else ((0, 0), shift)

    @property
    def spectra(self) -> Spectra:
        """The arrays over the modes, for a sweep."""
        return Spectra(self.g, self.d, self.w, self.K, self.weights)


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

    @property
    def chain(self) -> list[CompiledLinearGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.linear.chain if self.linear else [])]

    def relax(self, levels: int, shift: float, iterations: int, reduction: float) -> bool:
        coarse = self.linear is not None and levels > 1
        line, alpha = Line(), 0.0
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
            curvature = line.curvature + self._new_direction(line.beta, coarse=coarse)
            if not curvature > 0:
                # The wall is softer than the substrate along this direction: there is no minimum to go to.
                return iteration > 0
            alpha = -line.slope / curvature
        self._finish(shift, alpha, line.beta, coarse=coarse)
        return True

    def _gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, first: bool) -> Real:
        """Take the last step, of length ``alpha``: x and g; s = M g."""
        low, c0 = self.modes(shift, coarse=coarse)
        given = self.spectra, self.x, c0, alpha, beta, low

        def sweep(a: int, b: int, sums: Real) -> None:
            spectra.finish_gradient(a, b, sums, *given)

        return self.spectral(sweep, forward=not first, inverse=True, keep_low=coarse)

    def _new_direction(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <stiffness d d>."""
        if coarse:
            self.low_direction(beta)

        def sweep(a: int, b: int, sums: Real, s: Real) -> None:
            linear_direction(a, b, sums, s, self.direction, self.n, beta, self.stiffness)

        return float(self.through(sweep, inverse=True, forward=True)[0]) / self.size

    def _finish(self, shift: float, alpha: float, beta: float, *, coarse: bool) -> None:
        """Take the last step, after which nothing follows: x alone."""
        low, c0 = self.modes(shift, coarse=coarse)
        given = self.spectra, self.x, c0, alpha, beta, low
        self.spectral(lambda a, b, sums: spectra.linear_last(a, b, sums, *given), keep_low=coarse)
