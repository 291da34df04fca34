"""Fourier transforms of periodic fields, in blocks of rows and columns (convention: see `continuum`).

values(x) = sum over q of values_q exp(i q x); of the spectrum of a real field one half is kept.  A transform goes along
the rows, then along the columns, or back.  Blocks are fixed by the shape of the field, and one thread transforms a
block (ducc0's own threads change the last bits), so that results do not depend on the number of threads.
"""

from typing import Any

import ducc0.fft
import numpy as np
from numpy.typing import DTypeLike, NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
_PADDING = 128  # bytes


def block_edges(length: int, points: int) -> list[int]:
    """Edges of the blocks of rows or columns of a field, each about a megabyte, which fits into a cache.

    They are at least 32 wide, which sweeps over columns need, and depend on the field only, never on the threads.
    """
    blocks = max(1, min(length // 32, points // 2**17))
    return [length * b // blocks for b in range(blocks + 1)]


def padded(shape: tuple[int, int], kind: DTypeLike = np.float64) -> NDArray[Any]:
    """Zeros of a shape with padded rows: rows a power of two apart would compete for the same cache lines."""
    rows, columns = shape
    return np.zeros((rows, columns + _PADDING // np.dtype(kind).itemsize), dtype=kind)[:, :columns]


def rows_forward(values: Real, spectrum: Complex) -> None:
    """First half of the forward transform of a block, or of a stack of fields: along y, the last axis."""
    ducc0.fft.r2c(values, axes=(values.ndim - 1,), inorm=2, out=spectrum)


def columns_forward(spectrum: Complex) -> None:
    """Second half, along x, in place."""
    ducc0.fft.c2c(spectrum, axes=(spectrum.ndim - 2,), inorm=2, out=spectrum)


def columns_inverse(spectrum: Complex) -> None:
    """First half of the inverse transform of a block, or of a stack of fields: along x, in place."""
    ducc0.fft.c2c(spectrum, axes=(spectrum.ndim - 2,), forward=False, out=spectrum)


def rows_inverse(spectrum: Complex, values: Real) -> None:
    """Second half, along y; destroys the spectrum."""
    y, n = values.ndim - 1, values.shape[-1]
    ducc0.fft.c2r(spectrum, axes=(y,), lastsize=n, forward=False, out=values, allow_overwriting_input=True)


def cut(values_q: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    """The part of a half spectrum that lies on the modes of a coarser grid of the same period, in a copy."""
    rows, columns = shape
    n = values_q.shape[0]
    return values_q[np.r_[: low_rows(rows), n - rows // 2 : n], :columns]


def low_rows(rows: int) -> int:
    """Rows of a half spectrum from that without a wave along x up to the shortest wave; a line has one."""
    return max(rows // 2, 1)


def restrict(fine: Complex, coarse: Complex) -> None:
    """Half spectrum on a coarser grid of the same period: the modes that it carries, without its Nyquist modes."""
    m, n = low_rows(coarse.shape[0]), coarse.shape[1] - 1
    coarse[m : m + 1] = 0
    coarse[:, n] = 0
    coarse[:m, :n] = fine[:m, :n]
    coarse[m + 1 :, :n] = fine[fine.shape[0] - m + 1 :, :n]


def prolong(coarse: Complex, fine: Complex) -> None:
    """Half spectrum on a finer grid of the same period: zero beyond the modes of the coarse one."""
    m, n = low_rows(coarse.shape[0]), coarse.shape[1] - 1
    fine[...] = 0
    fine[:m, :n] = coarse[:m, :n]
    fine[fine.shape[0] - m + 1 :, :n] = coarse[m + 1 :, :n]
