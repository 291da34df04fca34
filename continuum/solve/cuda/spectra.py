"""Kernels of the minimiser over its spectra; what they do is said in :mod:`continuum.solve.cpu.sweeps`.

A half spectrum is a real array, real and imaginary parts in turn.  In a sum over all modes column 0 counts once, and so
does ``single``, the last column of an even grid (-1 if there is none); all others count twice.  ``held`` is 1 where the
mean of u is held at zero: then it has no gradient.

The next coarser grid carries the columns below ``low_columns`` of the rows within ``low_rows`` of row 0: 2 low_rows - 1
rows in all.
"""

from __future__ import annotations

from continuum.model.fourier import Real
from continuum.solve.cuda.device import Kernel, Sums, complex_at, cuda, device_function, set_complex
from continuum.solve.cuda.sums import leave


@device_function
def multiplicity(j: int, single: int) -> float:
    """How often a column counts."""
    return 1.0 if j in (0, single) else 2.0


@device_function
def low_row(r: int, low_rows: int, rows: int) -> int:
    """Row of a spectrum that is the r-th of those of the coarser grid."""
    return r if r < low_rows else rows - 2 * low_rows + 1 + r


@Kernel
def _gradient(
    g: Real, d: Real, work: Real, K: Real, c0: float, alpha: float, beta: float, low_rows: int, low_columns: int,
    single: int, held: int, sums: Sums,
) -> None:  # fmt: skip
    rows = K.shape[0]
    gg = gs = ys = ym = ss = sd = 0.0
    for i in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
        low_row = i < low_rows or i > rows - low_rows
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            k = K[i, j]
            weight = multiplicity(j, single)
            g0, g1 = complex_at(g, i, j)
            d0, d1 = complex_at(d, i, j)
            y0 = y1 = 0.0
            if not (held and i == 0 and j == 0):
                y0, y1 = complex_at(work, i, j)
            low = low_row and j < low_columns
            m = 1.0 / (k + c0)
            if not low:
                d0 = beta * d0 - m * g0
                d1 = beta * d1 - m * g1
                set_complex(d, i, j, d0, d1)
            y0 += alpha * k * d0
            y1 += alpha * k * d1
            g0 += y0
            g1 += y1
            set_complex(g, i, j, g0, g1)
            square = weight * (g0 * g0 + g1 * g1)
            gg += square
            if low:
                set_complex(work, i, j, y0, y1)
            else:
                s0, s1 = m * g0, m * g1
                set_complex(work, i, j, s0, s1)
                gs += m * square
                ys += weight * (y0 * s0 + y1 * s1)
                ym += weight * m * (y0 * y0 + y1 * y1)
                ss += weight * k * (s0 * s0 + s1 * s1)
                sd += weight * k * (s0 * d0 + s1 * d1)
    leave(sums, (gg, gs, ys, ym, ss, sd))


@device_function
def low_modes_of(
    g: Real, d: Real, work: Real, K: Real, e: Real, size: float, c0: float, low_rows: int, low_columns: int,
    single: int, sums: Sums,
) -> None:  # fmt: skip
    """What `low_modes` does."""
    rows = K.shape[0]
    gs = ys = ym = ss = sd = 0.0
    for r in range(cuda.blockIdx.x, 2 * low_rows - 1, cuda.gridDim.x):
        i, coarse = low_row(r, low_rows, rows), low_row(r, low_rows, 2 * low_rows)
        for j in range(cuda.threadIdx.x, low_columns, cuda.blockDim.x):
            k = K[i, j]
            weight = multiplicity(j, single)
            y0, y1 = complex_at(work, i, j)
            e0, e1 = complex_at(e, coarse, j)
            s0, s1 = -size * e0, -size * e1
            set_complex(work, i, j, s0, s1)
            g0, g1 = complex_at(g, i, j)
            d0, d1 = complex_at(d, i, j)
            gs += weight * (g0 * s0 + g1 * s1)
            ys += weight * (y0 * s0 + y1 * s1)
            ym += weight / (k + c0) * (y0 * y0 + y1 * y1)
            ss += weight * k * (s0 * s0 + s1 * s1)
            sd += weight * k * (s0 * d0 + s1 * d1)
    leave(sums, (0.0, gs, ys, ym, ss, sd))


@Kernel
def _low_modes(
    g: Real, d: Real, work: Real, K: Real, e: Real, size: float, c0: float, low_rows: int, low_columns: int,
    single: int, sums: Sums,
) -> None:  # fmt: skip
    low_modes_of(g, d, work, K, e, size, c0, low_rows, low_columns, single, sums)


@device_function
def low_gradient_of(
    g: Real, work: Real, K: Real, c0: float, low_rows: int, low_columns: int, single: int, sums: Sums
) -> None:
    """What `low_gradient` does."""
    rows = K.shape[0]
    gs = ss = 0.0
    for r in range(cuda.blockIdx.x, 2 * low_rows - 1, cuda.gridDim.x):
        i = low_row(r, low_rows, rows)
        for j in range(cuda.threadIdx.x, low_columns, cuda.blockDim.x):
            k = K[i, j]
            weight = multiplicity(j, single)
            g0, g1 = complex_at(g, i, j)
            s0, s1 = g0 / (k + c0), g1 / (k + c0)
            set_complex(work, i, j, s0, s1)
            gs += weight * (g0 * s0 + g1 * s1)
            ss += weight * k * (s0 * s0 + s1 * s1)
    leave(sums, (0.0, gs, 0.0, 0.0, ss, 0.0))


@Kernel
def _low_gradient(
    g: Real, work: Real, K: Real, c0: float, low_rows: int, low_columns: int, single: int, sums: Sums
) -> None:
    low_gradient_of(g, work, K, c0, low_rows, low_columns, single, sums)


@Kernel
def _low_direction(d: Real, work: Real, low_rows: int, low_columns: int, beta: float) -> None:
    for r in range(cuda.blockIdx.x, 2 * low_rows - 1, cuda.gridDim.x):
        i = low_row(r, low_rows, d.shape[0])
        for j in range(cuda.threadIdx.x, low_columns, cuda.blockDim.x):
            d0, d1 = complex_at(d, i, j)
            s0, s1 = complex_at(work, i, j)
            set_complex(d, i, j, beta * d0 - s0, beta * d1 - s1)


@Kernel
def _elastic(g: Real, work: Real, K: Real, force: float) -> None:
    for i in range(cuda.blockIdx.x, K.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            here = force if i == 0 and j == 0 else 0.0
            u0, u1 = complex_at(work, i, j)
            set_complex(g, i, j, K[i, j] * u0 - here, K[i, j] * u1)


@Kernel
def _add_square(g: Real, work: Real, single: int, sums: Sums) -> None:
    gg = 0.0
    for i in range(cuda.blockIdx.x, g.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, g.shape[1] // 2, cuda.blockDim.x):
            g0, g1 = complex_at(g, i, j)
            y0, y1 = complex_at(work, i, j)
            g0 += y0
            g1 += y1
            set_complex(g, i, j, g0, g1)
            gg += multiplicity(j, single) * (g0 * g0 + g1 * g1)
    leave(sums, (gg,))


@Kernel
def _energy(work: Real, K: Real, single: int, sums: Sums) -> None:
    """sums: <u,Ku> without the mean; the spectrum of u in work."""
    total = 0.0
    for i in range(cuda.blockIdx.x, K.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            if i > 0 or j > 0:
                u0, u1 = complex_at(work, i, j)
                total += multiplicity(j, single) * K[i, j] * (u0 * u0 + u1 * u1)
    leave(sums, (total,))


@device_function
def restrict_of(coarse: Real, fine: Real, factor: float) -> None:
    """Half spectrum on a coarser grid of the same period: the modes that it carries, without its Nyquist modes."""
    low_rows, low_columns = max(coarse.shape[0] // 2, 1), coarse.shape[1] // 2 - 1
    for i in range(cuda.blockIdx.x, coarse.shape[0], cuda.gridDim.x):
        source = i if i < low_rows else i + fine.shape[0] - coarse.shape[0]
        for j in range(cuda.threadIdx.x, coarse.shape[1] // 2, cuda.blockDim.x):
            a = b = 0.0
            if i != low_rows and j < low_columns:
                a, b = complex_at(fine, source, j)
            set_complex(coarse, i, j, factor * a, factor * b)


@Kernel
def _restrict(coarse: Real, fine: Real, factor: float) -> None:
    """The same, times a number."""
    restrict_of(coarse, fine, factor)


@Kernel
def _prolong(fine: Real, coarse: Real) -> None:
    """Half spectrum on a finer grid of the same period: zero beyond the modes of the coarse one."""
    low_rows, low_columns = max(coarse.shape[0] // 2, 1), coarse.shape[1] // 2 - 1
    rows = fine.shape[0]
    for i in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
        low = i < low_rows or i > rows - low_rows
        source = i if i < low_rows else i - rows + coarse.shape[0]
        for j in range(cuda.threadIdx.x, fine.shape[1] // 2, cuda.blockDim.x):
            a = b = 0.0
            if low and j < low_columns:
                a, b = complex_at(coarse, source, j)
            set_complex(fine, i, j, a, b)
