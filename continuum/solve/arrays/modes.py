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
    stiffness_q : K over the half spectrum, shape ``grid.shape_q``, in E*/a0.
    kind : type of the real numbers of its spectra; that of double precision by default.
    """

    def __init__(self, library: Library, grid: Grid, stiffness_q: Real, kind: Any = None) -> None:
        self.library, self.xp, self.grid, self.size = library, library.xp, grid, grid.size
        self.kind = kind or library.xp.float64
        self.K = library.put(stiffness_q[..., None], self.kind)
        coarse, (m, n) = grid.coarser, grid.mode_numbers
        (nx, ny) = coarse.shape if coarse is not None else (0, 0)
        rows, columns = np.abs(m)[..., None], n[..., None]
        self.marks = ModeMarks(
            library.put(grid.mode_weights[..., None], self.kind),
            (library.put(rows == 0, self.xp.bool), library.put(columns == 0, self.xp.bool)),
            (library.put(rows < nx / 2, self.xp.bool), library.put(columns < ny / 2, self.xp.bool)),
        )
        self.transforms, self.trials = 0.0, 0
        self._mean_stiffness = np.nan
        if coarse is not None:
            m, n = coarse.mode_numbers
            low = (np.abs(m) < max(m.size / 2, 1)) & (n < n.size - 1)
            self._low = library.put(low[..., None], self.xp.bool)

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
        return self.library.pairs(self.xp.fft.rfftn(values, axes=(0, 1), norm="forward"))

    def inverse(self, spectrum: Array) -> Array:
        """Field of a spectrum."""
        self.transforms += 1
        return self.xp.fft.irfftn(self.library.complex(spectrum), s=self.grid.shape, axes=(0, 1), norm="forward")

    def zeros(self) -> Array:
        """A field."""
        return self.library.zeros(self.grid.shape)

    def zeros_q(self) -> Array:
        """A spectrum."""
        return self.library.zeros((*self.grid.shape_q, 2), self.kind)

    def below(self, spectrum: Array, size: Array | float = 1.0, kind: Any = None) -> Array:
        """A spectrum over a size on the coarser grid, without its Nyquist modes."""
        given = self.low_part(spectrum), self._low, self.library.number(size)
        return _below(self.library, *given, kind=kind or self.kind)

    def low_part(self, spectrum: Array) -> tuple[Array, Array]:
        """The first and the last rows that hold the modes of the coarser grid, beside its Nyquist modes."""
        rows, columns = self._low.shape[:2]
        part, n = spectrum[:, :columns, :], self.grid.shape[0]
        return part[: low_rows(rows), ...], part[n - rows // 2 :, ...]

    def above(self, spectrum: Array) -> Array:
        """A spectrum of the coarser grid on this one, zero beyond its modes and on its Nyquist modes."""
        return _above(self.library, spectrum, self._low, shape=self.grid.shape_q)

    def sampled(self, values: Array, coarse: Grid) -> Array:
        """Values of a field at the points at or just before those of a coarser grid: every second in a view."""
        if all(n in (1, 2 * c) for n, c in zip(self.grid.shape, coarse.shape, strict=True)):
            return values[::2, ::2]
        rows, columns = (self.library.put(each, self.xp.int64) for each in self.grid.sampled(coarse))
        return self.xp.take(self.xp.take(values, rows, axis=0), columns, axis=1)

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""
        u_q = without_mean(self.xp, self.forward(self.library.put(offset - gap)), self.marks)
        return 0.5 * float(square(self.library, u_q, self.K * self.marks.weights))


@fused
def _below(xp: Any, part: tuple[Array, Array], low: Array, size: Array, *, kind: Any) -> Array:
    """The low modes of these rows, over a size."""
    return xp.astype(xp.where(low, xp.concat(part), 0.0) / xp.astype(size, part[0].dtype), kind)


def widened(xp: Any, spectrum: Array, low: Array, shape: tuple[int, ...]) -> Array:
    """The low modes in a spectrum of a shape, zero beyond."""
    (rows, columns), half = spectrum.shape[:2], low_rows(spectrum.shape[0])
    kept = xp.where(low, spectrum, 0.0)
    beside = xp.broadcast_to(xp.zeros_like(kept[:, :1, :]), (rows, shape[1] - columns, 2))
    wide = xp.concat([kept, beside], axis=1)
    between = xp.broadcast_to(xp.zeros_like(wide[:1, ...]), (shape[0] - rows, shape[1], 2))
    return xp.concat([wide[:half, ...], between, wide[half:, ...]])


@fused
def _above(xp: Any, spectrum: Array, low: Array, *, shape: tuple[int, int]) -> Array:
    return widened(xp, spectrum, low, shape)


def sum_of(xp: Any, values: Array) -> Array:
    """Sum in double precision, over rows first."""
    return xp.sum(xp.sum(values, axis=tuple(range(1, values.ndim)), dtype=xp.float64))


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
