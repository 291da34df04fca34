"""One grid on the arrays of a library: transforms, K, sums over modes, and the modes of the next coarser grid.

A spectrum is held as pairs of real numbers, shape ``(*grid.shape_q, 2)``, which a library can fuse.  Sums are made over
rows first, so that a reduction is part of the pass that makes what it sums.
"""

from typing import Any, NamedTuple

import numpy as np

from continuum.model.fourier import Real, low_rows
from continuum.model.grid import Grid
from continuum.solve.arrays.library import Array, Library, fused


class ModeMarks(NamedTuple):
    """Rows and columns of a half spectrum, of shapes that go with it: what a pass asks of a mode."""

    weights: Array
    """How often each counts in a sum over all modes."""
    first: tuple[Array, Array]
    """Row and column of the mean."""
    low: tuple[Array, Array]
    """Rows and columns that the next coarser grid carries."""


class Modes:
    """Transforms and K of one grid.

    Parameters
    ----------
    library : of its arrays.
    grid : points and periods.
    stiffness_q : K over the half spectrum, shape ``grid.shape_q_here``, in E*/a0.
    kind : type of the real numbers of its spectra; that of double precision by default.
    """

    def __init__(self, library: Library, grid: Grid, stiffness_q: Real, kind: Any = None) -> None:
        self.library, self.xp, self.grid, self.size = library, library.xp, grid, grid.size
        self.kind = kind or library.xp.float64
        self.K = library.put_q(stiffness_q, self.kind, beyond=1.0)
        coarse, (m, n) = grid.coarser, grid.mode_numbers
        (nx, ny) = coarse.shape if coarse is not None else (0, 0)
        rows, flag = np.abs(m), self.xp.bool
        self.marks = ModeMarks(
            library.put_q(grid.mode_weights, self.kind),
            (library.put_q(rows == 0, flag), library.put_q(n == 0, flag)),
            (library.put_q(rows < nx / 2, flag), library.put_q(n < ny / 2, flag)),
        )
        self.transforms, self.trials = 0.0, 0
        self._mean_stiffness = np.nan
        if coarse is not None:
            m, n = coarse.mode_numbers
            low = (np.abs(m) < max(coarse.shape[0] / 2, 1)) & (n < coarse.shape[1] // 2)
            self._low = library.put_q(low, flag)

    def set_mean_stiffness(self, stiffness: float) -> bool:
        """Set K at q = 0; returns whether it was another."""
        if stiffness == self._mean_stiffness:
            return False
        row, column = self.marks.first
        self._mean_stiffness, self.K = stiffness, self.xp.where(row & column, stiffness, self.K)
        return True

    def forward(self, values: Array) -> Array:
        """Spectrum of a field."""
        self.transforms += 1
        return self.library.forward(values)

    def inverse(self, spectrum: Array) -> Array:
        """Field of a spectrum."""
        self.transforms += 1
        return self.library.inverse(spectrum, self.grid.shape)

    def zeros(self) -> Array:
        """A field."""
        return self.library.zeros(self.grid.shape)

    def zeros_q(self) -> Array:
        """A spectrum."""
        return self.library.zeros_q(self.grid.shape_q, self.kind)

    def below(self, spectrum: Array, size: Array | float = 1.0, kind: Any = None) -> Array:
        """A spectrum over a size on the coarser grid, without its Nyquist modes."""
        return _below(self.library, spectrum, self._low, self.library.number(size), kind=kind or self.kind)

    def above(self, spectrum: Array) -> Array:
        """A spectrum of the coarser grid on this one, zero beyond its modes and on its Nyquist modes."""
        return _above(self.library, spectrum, self._low, shape=(self.K.shape[0], self.K.shape[-2]))

    def sampled(self, values: Array, coarse: Grid) -> Array:
        """Values of a field at the points at or just before those of a coarser grid: every second in a view."""
        if all(n in (1, 2 * c) for n, c in zip(self.grid.shape, coarse.shape, strict=True)):
            return self.library.every_second(values)
        rows, columns = (self.library.put(each, self.xp.int64) for each in self.grid.sampled(coarse))
        return self.xp.take(self.xp.take(values, rows, axis=0), columns, axis=1)

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""
        u_q = without_mean(self.xp, self.forward(self.library.put_field(self.grid, offset - gap)), self.marks)
        return 0.5 * float(square(self.library, u_q, self.K * self.marks.weights))


def low_part(xp: Any, spectrum: Array, low: Array) -> Array:
    """The first and the last rows, which hold the modes of the coarser grid and its Nyquist modes."""
    rows, columns = low.shape[0], low.shape[-2]
    part = spectrum[..., :columns, :]
    return xp.concat([part[: low_rows(rows), ...], part[part.shape[0] - rows // 2 :, ...]])


@fused
def _below(xp: Any, spectrum: Array, low: Array, size: Array, *, kind: Any) -> Array:
    """The low modes of a spectrum, over a size."""
    return xp.astype(xp.where(low, low_part(xp, spectrum, low), 0.0) / xp.astype(size, spectrum.dtype), kind)


def widened(xp: Any, spectrum: Array, low: Array, shape: tuple[int, ...]) -> Array:
    """The low modes in a spectrum of a shape, zero beyond."""
    (rows, *parts, columns, _), half = spectrum.shape, low_rows(spectrum.shape[0])
    kept = xp.where(low, spectrum, 0.0)
    beside = xp.broadcast_to(xp.zeros_like(kept[..., :1, :]), (rows, *parts, shape[1] - columns, 2))
    wide = xp.concat([kept, beside], axis=-2)
    between = xp.broadcast_to(xp.zeros_like(wide[:1, ...]), (shape[0] - rows, *parts, shape[1], 2))
    return xp.concat([wide[:half, ...], between, wide[half:, ...]])


@fused
def _above(xp: Any, spectrum: Array, low: Array, *, shape: tuple[int, int]) -> Array:
    return widened(xp, spectrum, low, shape)


def sum_of(xp: Any, values: Array) -> Array:
    """Sum in double precision, over rows first; of a spectrum in slabs, over each slab first."""
    slabs = 1 if values.ndim == 4 else 0
    within = tuple(axis for axis in range(values.ndim) if axis != slabs)
    return xp.sum(xp.sum(values, axis=within, dtype=xp.float64))


def mean(xp: Any, values: Array) -> Array:
    """Mean over the points."""
    return sum_of(xp, values) / (values.shape[0] * values.shape[1])


@fused
def square(xp: Any, spectrum: Array, weights: Array) -> Array:
    """Sum of the squares of a spectrum's modes, weighted."""
    return sum_of(xp, spectrum * spectrum * weights)


def without_mean(xp: Any, spectrum: Array, marks: ModeMarks) -> Array:
    """A spectrum whose first mode is zero."""
    row, column = marks.first
    return xp.where(row & column, 0.0, spectrum)
