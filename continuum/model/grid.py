"""The periodic grid: positions, wavevectors, Fourier transforms, integrals.

The only module that knows an FFT convention (see :mod:`continuum`).  No physics.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache, cached_property

import ducc0.fft
import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Complex",
    "Grid",
    "Real",
    "block_edges",
    "columns_forward",
    "columns_inverse",
    "over_blocks",
    "rows_forward",
    "rows_inverse",
]

Real = NDArray[np.float64]
_PADDING = 8
Complex = NDArray[np.complex128]


def block_edges(length: int, points: int) -> list[int]:
    """Where the blocks of rows or columns of a field begin and end: a megabyte, which stays in a cache.

    They are at least 32 wide, which sweeps over columns need, and depend on the field only, never on the threads.
    """
    blocks = max(1, min(length // 32, points // 2**17))
    return [length * b // blocks for b in range(blocks + 1)]


def over_blocks(task: Callable[[int], None], blocks: int, threads: int) -> None:
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


# Transforms of a block of rows or columns, one thread each: ducc0's own threads change the last bits.


def rows_forward(values: Real, spectrum: Complex) -> None:
    """First half of the forward transform: along y."""
    ducc0.fft.r2c(values, axes=(1,), inorm=2, out=spectrum)


def columns_forward(spectrum: Complex) -> None:
    """Second half, along x, in place."""
    ducc0.fft.c2c(spectrum, axes=(0,), inorm=2, out=spectrum)


def columns_inverse(spectrum: Complex) -> None:
    """First half of the inverse transform: along x, in place."""
    ducc0.fft.c2c(spectrum, axes=(0,), forward=False, out=spectrum)


def rows_inverse(spectrum: Complex, values: Real) -> None:
    """Second half, along y; destroys the spectrum."""
    n = values.shape[1]
    ducc0.fft.c2r(spectrum, axes=(1,), lastsize=n, forward=False, out=values, allow_overwriting_input=True)


@dataclass(frozen=True)
class Grid:
    """A periodic rectangle of ``lengths`` (in a0) covered by ``shape`` points.

    Parameters
    ----------
    shape : (nx, ny), at least 2 points each; odd and non-square grids are as good as any.
    lengths : (Lx, Ly), the periods, in a0.
    threads : threads of one Fourier transform.  Results do not depend on it.

    Raises
    ------
    ValueError
        If a number of points is below 2 or a period is not a positive finite number.
    """

    shape: tuple[int, int]
    lengths: tuple[float, float]
    threads: int = field(default=1, compare=False)

    def __post_init__(self) -> None:
        """Refuse what has no meaning."""
        if min(self.shape) < 2:
            msg = f"a grid needs at least 2 points in each direction, got {self.shape}"
            raise ValueError(msg)
        if not all(np.isfinite(length) and length > 0 for length in self.lengths):
            msg = f"the periods of a grid are positive finite numbers, got {self.lengths}"
            raise ValueError(msg)

    @classmethod
    def square(cls, n: int, spacing: float = 1.0, threads: int = 1) -> Grid:
        """An n x n grid of the given spacing: one point for each surface atom when the spacing is a0."""
        return cls((n, n), (n * spacing, n * spacing), threads)

    @property
    def size(self) -> int:
        """Number of points."""
        return self.shape[0] * self.shape[1]

    @property
    def shape_q(self) -> tuple[int, int]:
        """Shape of a half spectrum."""
        return self.shape[0], self.shape[1] // 2 + 1

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of neighbouring points along x and y, in a0."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]

    @property
    def area(self) -> float:
        """Area of the period, A0, in a0²."""
        return self.lengths[0] * self.lengths[1]

    @property
    def cell_area(self) -> float:
        """Area of one point, in a0²."""
        return self.area / self.size

    @property
    def positions(self) -> tuple[Real, Real]:
        """Coordinates x, shape (nx, 1), and y, shape (1, ny), in a0."""
        x = np.arange(self.shape[0], dtype=np.float64)[:, None] * self.spacing[0]
        y = np.arange(self.shape[1], dtype=np.float64)[None, :] * self.spacing[1]
        return x, y

    @property
    def mode_numbers(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Integers m, shape (nx, 1), and n, shape (1, ny//2+1), of q = 2 pi (m/Lx, n/Ly)."""
        nx, ny = self.shape
        m = (np.arange(nx) + nx // 2) % nx - nx // 2
        return m[:, None], np.arange(ny // 2 + 1)[None, :]

    @property
    def wavevectors(self) -> tuple[Real, Real]:
        """Components qx, shape (nx, 1), and qy, shape (1, ny//2+1), in 1/a0."""
        m, n = self.mode_numbers
        per_mode = [2 * np.pi / length for length in self.lengths]
        return m.astype(np.float64) * per_mode[0], n.astype(np.float64) * per_mode[1]

    @property
    def wavenumber(self) -> Real:
        """|q| over the half spectrum, in 1/a0."""
        qx, qy = self.wavevectors
        return np.hypot(qx, qy)

    @cached_property
    def mode_weights(self) -> Real:
        """How often each stored mode counts in a sum over all q: 1 or 2; shape (1, ny//2+1)."""
        ny = self.shape[1]
        weights = np.full((1, ny // 2 + 1), 2.0)
        weights[0, 0] = 1.0
        if ny % 2 == 0:
            weights[0, -1] = 1.0
        return weights

    def forward(self, values: Real, out: Complex | None = None) -> Complex:
        """Half spectrum of a field: values_q = mean(values exp(-i q x)), into ``out`` if given."""
        values = np.asarray(values, dtype=np.float64)
        spectrum = self.empty_q() if out is None else out
        self._over(self.shape[0], lambda block: rows_forward(values[block], spectrum[block]))
        self._over(self.shape_q[1], lambda block: columns_forward(spectrum[:, block]))
        return spectrum

    def inverse(self, values_q: Complex, out: Real | None = None, *, overwrite: bool = False) -> Real:
        """Field of a half spectrum: values(x) = sum over q of values_q exp(i q x), into ``out`` if given.

        With ``overwrite`` the spectrum is destroyed, which saves memory.
        """
        values = np.empty(self.shape) if out is None else out
        if not overwrite:
            spectrum = self.empty_q()
            spectrum[...] = values_q
            values_q = spectrum
        self._over(self.shape_q[1], lambda block: columns_inverse(values_q[:, block]))
        self._over(self.shape[0], lambda block: rows_inverse(values_q[block], values[block]))
        return values

    def _over(self, length: int, transform: Callable[[slice], None]) -> None:
        edges = block_edges(length, self.size)
        over_blocks(lambda b: transform(slice(edges[b], edges[b + 1])), len(edges) - 1, self.threads)

    def empty(self) -> Real:
        """A field to be filled, with padded rows: rows a power of two apart would share the sets of the caches."""
        return np.zeros((self.shape[0], self.shape[1] + 2 * _PADDING))[:, : self.shape[1]]

    def empty_q(self) -> Complex:
        """A half spectrum to be filled, with padded rows."""
        rows, columns = self.shape_q
        return np.zeros((rows, columns + _PADDING), dtype=np.complex128)[:, :columns]

    @property
    def coarser(self) -> Grid | None:
        """The grid of every second point, if its own half spectrum is cut out of this one's; else None."""
        if self.shape[0] % 4 or self.shape[1] % 4:
            return None
        return Grid((self.shape[0] // 2, self.shape[1] // 2), self.lengths, self.threads)

    def integrate(self, values: Real) -> float:
        """Integral of a field over the period: a traction becomes a load, an energy per area an energy."""
        return float(np.sum(values)) * self.cell_area

    def mean(self, values: Real) -> float:
        """Mean of a field over the period."""
        return float(np.sum(values)) / self.size

    def inner_q(self, a_q: Complex, b_q: Complex) -> float:
        """Mean over the grid of a(x) b(x), from the half spectra (Parseval)."""
        product = a_q.real * b_q.real + a_q.imag * b_q.imag
        return float(np.sum(product * self.mode_weights))
