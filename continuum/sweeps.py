"""Fused sweeps of the minimiser over its spectra, compiled, and the threads that run all sweeps.

A sweep is a compiled function of the rows ``start:stop`` of a block that returns nothing and writes that block's
sums.  Blocks do not depend on the number of threads and their sums are added in order, so neither do results.
The threads are Python's own (compiled code releases the lock): they sleep when they have nothing to do, unlike
OpenMP's, which spin and were seen to slow a shared machine tenfold.

Spectra are passed as real arrays, real and imaginary parts in turn: the compiler vectorises these.  Sums over a half
spectrum count the columns 0 and, on even grids, ny/2 once, all others twice.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

import numpy as np

from continuum.grid import Real
from continuum.laws import compiled

__all__ = ["SUMS", "gradient", "low_direction", "low_gradient", "low_modes", "over_rows"]

SUMS = 10
_BLOCKS = 64


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads)


def over_rows(kernel: Callable[..., None], rows: int, threads: int, *arguments: object) -> Real:
    """Run ``kernel(start, stop, sums, *arguments)`` over all rows and return its sums, shape (SUMS,)."""
    blocks = max(1, min(_BLOCKS, rows // 16))
    edges = [rows * b // blocks for b in range(blocks + 1)]
    sums = np.zeros((blocks, SUMS))

    def run(first: int, last: int) -> None:
        for b in range(first, last):
            kernel(edges[b], edges[b + 1], sums[b], *arguments)

    if threads == 1:
        run(0, blocks)
    else:
        shares = [blocks * t // threads for t in range(threads + 1)]
        for task in [_pool(threads).submit(run, a, b) for a, b in pairwise(shares)]:
            task.result()
    total: Real = sums.sum(axis=0)
    return total


@compiled
def gradient(
    start: int,
    stop: int,
    sums: Real,
    g: Real,
    d: Real,
    work: Real,
    K: Real,
    c0: float,
    alpha: float,
    beta: float,
    low_rows: int,
    low_columns: int,
    single: int,
) -> None:
    """Finish the last step in Fourier space and precondition the new gradient.

    On entry ``work`` holds the change of traction of that step, alpha its length, beta the weight of the direction
    before it::

        d <- beta d - M g        (the direction of the step, M = 1/(K + c0))
        y  = alpha K d + work
        g <- g + y
        work <- s = M g          modes of the coarse grid: y, and d is left as it is

    ``single`` is the index of the last column if it counts once, else -1.
    sums: |g|², and without the coarse modes <g,s>, <y,s>, <y,My>, <d,g>, <d,y>, <s,Ks>, <s,Kd>, <d,Kd>.
    """
    rows, columns = K.shape
    for i in range(start, stop):
        first = low_columns if (i < low_rows or i > rows - low_rows) else 0
        for j in range(first):
            for c in range(2 * j, 2 * j + 2):
                y = alpha * K[i, j] * d[i, c] + work[i, c]
                g[i, c] += y
                work[i, c] = y
                sums[0] += (1 if j == 0 else 2) * g[i, c] * g[i, c]
        gg = gs = ys = ym = dg = dy = ss = sd = dd = 0.0
        for j in range(first, columns):
            k = K[i, j]
            m = 1.0 / (k + c0)
            g0 = g[i, 2 * j]
            g1 = g[i, 2 * j + 1]
            d0 = beta * d[i, 2 * j] - m * g0
            d1 = beta * d[i, 2 * j + 1] - m * g1
            y0 = alpha * k * d0 + work[i, 2 * j]
            y1 = alpha * k * d1 + work[i, 2 * j + 1]
            g0 += y0
            g1 += y1
            s0 = m * g0
            s1 = m * g1
            d[i, 2 * j] = d0
            d[i, 2 * j + 1] = d1
            g[i, 2 * j] = g0
            g[i, 2 * j + 1] = g1
            work[i, 2 * j] = s0
            work[i, 2 * j + 1] = s1
            w = 1.0 if j == 0 or j == single else 2.0
            gg += w * (g0 * g0 + g1 * g1)
            gs += w * (g0 * s0 + g1 * s1)
            ys += w * (y0 * s0 + y1 * s1)
            ym += w * m * (y0 * y0 + y1 * y1)
            dg += w * (d0 * g0 + d1 * g1)
            dy += w * (d0 * y0 + d1 * y1)
            ss += w * k * (s0 * s0 + s1 * s1)
            sd += w * k * (s0 * d0 + s1 * d1)
            dd += w * k * (d0 * d0 + d1 * d1)
        sums[0] += gg
        sums[1] += gs
        sums[2] += ys
        sums[3] += ym
        sums[4] += dg
        sums[5] += dy
        sums[6] += ss
        sums[7] += sd
        sums[8] += dd


@compiled
def low_modes(
    start: int,
    stop: int,
    sums: Real,
    g: Real,
    d: Real,
    work: Real,
    K: Real,
    c0: float,
    low_rows: int,
    low_columns: int,
    e: Real,
) -> None:
    """The modes that the coarse grid has seen: work <- s = -e, and their share of the sums of `gradient`."""
    rows = K.shape[0]
    for i in range(start, stop):
        if low_rows <= i <= rows - low_rows:
            continue
        ic = i if i < low_rows else i - rows + e.shape[0]
        for j in range(low_columns):
            w = 1.0 if j == 0 else 2.0
            k = K[i, j]
            for c in range(2 * j, 2 * j + 2):
                y = work[i, c]
                s = -e[ic, c]
                work[i, c] = s
                sums[1] += w * g[i, c] * s
                sums[2] += w * y * s
                sums[3] += w * y * y / (k + c0)
                sums[4] += w * d[i, c] * g[i, c]
                sums[5] += w * d[i, c] * y
                sums[6] += w * k * s * s
                sums[7] += w * k * s * d[i, c]
                sums[8] += w * k * d[i, c] * d[i, c]


@compiled
def low_gradient(
    start: int,
    stop: int,
    sums: Real,
    g: Real,
    work: Real,
    K: Real,
    c0: float,
    low_rows: int,
    low_columns: int,
) -> None:
    """The same modes where the coarse step does not descend: work <- s = M g; sums: <g,s> at 1, <s,Ks> at 6."""
    rows = K.shape[0]
    for i in range(start, stop):
        if low_rows <= i <= rows - low_rows:
            continue
        for j in range(low_columns):
            w = 1.0 if j == 0 else 2.0
            k = K[i, j]
            for c in range(2 * j, 2 * j + 2):
                s = g[i, c] / (k + c0)
                work[i, c] = s
                sums[1] += w * g[i, c] * s
                sums[6] += w * k * s * s


@compiled
def low_direction(
    start: int,
    stop: int,
    sums: Real,
    d: Real,
    work: Real,
    low_rows: int,
    low_columns: int,
    beta: float,
) -> None:
    """Direction d <- beta d - s for those modes; the others follow in `gradient`."""
    rows = d.shape[0]
    for i in range(start, stop):
        if low_rows <= i <= rows - low_rows:
            continue
        for c in range(2 * low_columns):
            d[i, c] = beta * d[i, c] - work[i, c]
