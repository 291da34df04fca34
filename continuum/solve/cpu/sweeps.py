"""Fused sweeps of the minimiser over its spectra, and those over the points that need no wall law, compiled.

A sweep over a spectrum is a function of the columns ``first:last`` of a block, which writes that block's sums.
Spectra are passed as real arrays with padded rows, real and imaginary parts in turn: the compiler vectorises these.
``weights`` says how often a column counts in a sum over all modes: 0 and, on even grids, ny/2 once, all others twice.

The next coarser grid carries the columns below ``low_columns`` of the rows within ``low_rows`` of row 0.
"""

from __future__ import annotations

from continuum.model.fourier import Real
from continuum.solve.cpu.compiled import TILE, Mask, compiled, inlined


@compiled
def _gradient(
    first: int,
    last: int,
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
    weights: Real,
) -> None:
    """Finish the last step in Fourier space and precondition the new gradient.

    On entry ``work`` holds the change of traction of that step, alpha its length, beta the weight of the direction
    before it::

        d <- beta d - M g        (the direction of the step, M = 1/(K + c0))
        y  = alpha K d + work
        g <- g + y
        work <- s = M g          modes of the coarse grid: y, and d is left as it is

    sums: |g|², and without the coarse modes <g,s>, <y,s>, <y,My>, <s,Ks>, <s,Kd>.
    """
    rows = K.shape[0]
    for i in range(rows):
        gi = g[i, 2 * first : 2 * last]
        di = d[i, 2 * first : 2 * last]
        wi = work[i, 2 * first : 2 * last]
        ki = K[i, first:last]
        weight = weights[first:last]
        if first < low_columns and (i < low_rows or i > rows - low_rows):
            sums[0] += _finish_low(gi, di, wi, ki, weight, alpha)
            continue
        # A row stays in the cache for three short loops, which vectorise where one long one does not.
        _follow(gi, di, wi, ki, c0, alpha, beta)
        gg, gs, ys, ym = _finish(gi, wi, ki, weight, c0)
        ss, sd = _precondition(gi, di, wi, ki, weight, c0)
        sums[0] += gg
        sums[1] += gs
        sums[2] += ys
        sums[3] += ym
        sums[4] += ss
        sums[5] += sd


@inlined
def _finish_low(gi: Real, di: Real, wi: Real, ki: Real, weight: Real, alpha: float) -> float:
    """A row of the coarse grid's modes: work <- y, g <- g + y; |g|²."""
    gg = 0.0
    for j in range(ki.size):
        y0 = alpha * ki[j] * di[2 * j] + wi[2 * j]
        y1 = alpha * ki[j] * di[2 * j + 1] + wi[2 * j + 1]
        g0 = gi[2 * j] + y0
        g1 = gi[2 * j + 1] + y1
        wi[2 * j] = y0
        wi[2 * j + 1] = y1
        gi[2 * j] = g0
        gi[2 * j + 1] = g1
        gg += weight[j] * (g0 * g0 + g1 * g1)
    return gg


@inlined
def _follow(gi: Real, di: Real, wi: Real, ki: Real, c0: float, alpha: float, beta: float) -> None:
    """A row of the others: d <- beta d - M g, work <- y."""
    for j in range(ki.size):
        k = ki[j]
        m = 1.0 / (k + c0)
        d0 = beta * di[2 * j] - m * gi[2 * j]
        d1 = beta * di[2 * j + 1] - m * gi[2 * j + 1]
        di[2 * j] = d0
        di[2 * j + 1] = d1
        wi[2 * j] += alpha * k * d0
        wi[2 * j + 1] += alpha * k * d1


@inlined
def _finish(gi: Real, wi: Real, ki: Real, weight: Real, c0: float) -> tuple[float, float, float, float]:
    """The same row: g <- g + y; |g|², <g,s>, <y,s>, <y,My>."""
    gg = gs = ys = ym = 0.0
    for j in range(ki.size):
        w = weight[j]
        m = w / (ki[j] + c0)
        y0 = wi[2 * j]
        y1 = wi[2 * j + 1]
        g0 = gi[2 * j] + y0
        g1 = gi[2 * j + 1] + y1
        gi[2 * j] = g0
        gi[2 * j + 1] = g1
        square = g0 * g0 + g1 * g1
        gg += w * square
        gs += m * square
        ys += m * (y0 * g0 + y1 * g1)
        ym += m * (y0 * y0 + y1 * y1)
    return gg, gs, ys, ym


@inlined
def _precondition(gi: Real, di: Real, wi: Real, ki: Real, weight: Real, c0: float) -> tuple[float, float]:
    """The same row: work <- s = M g; <s,Ks>, <s,Kd>."""
    ss = sd = 0.0
    for j in range(ki.size):
        k = ki[j]
        m = 1.0 / (k + c0)
        s0 = m * gi[2 * j]
        s1 = m * gi[2 * j + 1]
        wi[2 * j] = s0
        wi[2 * j + 1] = s1
        k *= weight[j]
        ss += k * (s0 * s0 + s1 * s1)
        sd += k * (s0 * di[2 * j] + s1 * di[2 * j + 1])
    return ss, sd


@compiled
def _low_modes(
    first: int,
    last: int,
    sums: Real,
    g: Real,
    d: Real,
    work: Real,
    K: Real,
    c0: float,
    low_rows: int,
    weights: Real,
    e: Real,
) -> None:
    """The modes that the coarse grid has seen: work <- s = -e, and their share of the sums of `gradient`."""
    rows = K.shape[0]
    for i in range(rows):
        if low_rows <= i <= rows - low_rows:
            continue
        coarse = i if i < low_rows else i - rows + e.shape[0]
        gi = g[i, 2 * first : 2 * last]
        di = d[i, 2 * first : 2 * last]
        wi = work[i, 2 * first : 2 * last]
        ei = e[coarse, 2 * first : 2 * last]
        ki = K[i, first:last]
        weight = weights[first:last]
        gs = ys = ym = ss = sd = 0.0
        for j in range(ki.size):
            w = weight[j]
            y0 = wi[2 * j]
            y1 = wi[2 * j + 1]
            ym += w / (ki[j] + c0) * (y0 * y0 + y1 * y1)
            ys -= w * (y0 * ei[2 * j] + y1 * ei[2 * j + 1])
        for j in range(ki.size):
            w = weight[j]
            k = w * ki[j]
            s0 = -ei[2 * j]
            s1 = -ei[2 * j + 1]
            wi[2 * j] = s0
            wi[2 * j + 1] = s1
            gs += w * (gi[2 * j] * s0 + gi[2 * j + 1] * s1)
            ss += k * (s0 * s0 + s1 * s1)
            sd += k * (s0 * di[2 * j] + s1 * di[2 * j + 1])
        sums[1] += gs
        sums[2] += ys
        sums[3] += ym
        sums[4] += ss
        sums[5] += sd


@compiled
def _low_gradient(
    first: int,
    last: int,
    sums: Real,
    g: Real,
    work: Real,
    K: Real,
    c0: float,
    low_rows: int,
    weights: Real,
) -> None:
    """The same modes where the coarse step does not descend: work <- s = M g; sums: <g,s> at 1, <s,Ks> at 4."""
    rows = K.shape[0]
    for i in range(rows):
        if low_rows <= i <= rows - low_rows:
            continue
        for j in range(first, last):
            w = weights[j]
            k = K[i, j]
            for c in range(2 * j, 2 * j + 2):
                s = g[i, c] / (k + c0)
                work[i, c] = s
                sums[1] += w * g[i, c] * s
                sums[4] += w * k * s * s


@compiled
def _low_direction(first: int, last: int, sums: Real, d: Real, work: Real, low_rows: int, beta: float) -> None:
    """Direction d <- beta d - s for those modes; the others follow in `gradient`."""
    rows = d.shape[0]
    for i in range(rows):
        if low_rows <= i <= rows - low_rows:
            continue
        di = d[i, 2 * first : 2 * last]
        wi = work[i, 2 * first : 2 * last]
        for c in range(di.size):
            di[c] = beta * di[c] - wi[c]


@compiled
def _elastic(first: int, last: int, sums: Real, g: Real, work: Real, K: Real, force: float) -> None:
    """Gradient without the traction of the wall: g <- K u - F, the spectrum of u in work."""
    for i in range(K.shape[0]):
        for j in range(first, last):
            g[i, 2 * j] = K[i, j] * work[i, 2 * j]
            g[i, 2 * j + 1] = K[i, j] * work[i, 2 * j + 1]
    if first == 0:
        g[0, 0] -= force


@compiled
def _add_square(first: int, last: int, sums: Real, g: Real, work: Real, weights: Real) -> None:
    """Set g <- g + work; sums: |g|²."""
    for i in range(g.shape[0]):
        for c in range(2 * first, 2 * last):
            g[i, c] += work[i, c]
    for i in range(g.shape[0]):
        for j in range(first, last):
            sums[0] += weights[j] * (g[i, 2 * j] * g[i, 2 * j] + g[i, 2 * j + 1] * g[i, 2 * j + 1])


# Over the points: functions of the rows ``first:last``, as those of :mod:`continuum.solve.cpu.tractions`.


@compiled
def _every_second(first: int, last: int, sums: Real, fine: Real, z: Real, n: int, near_gap: float, near: Mask) -> None:
    """Gap of a coarse grid: z <- every second of the fine one's.  Marks the tiles."""
    for i in range(first, last):
        for t in range(near.shape[1]):
            close = 0
            for j in range(t * TILE, min(n, (t + 1) * TILE)):
                z[i, j] = fine[2 * i, 2 * j]
                close += not z[i, j] >= near_gap
            near[i, t] = close > 0


@compiled
def _moved(first: int, last: int, sums: Real, out: Real, fine: Real, z: Real, n: int) -> None:
    """How far the coarse grid has displaced the surface: ``out`` <- (every second of the fine gap) - z."""
    for i in range(first, last):
        for j in range(n):
            out[i - first, j] = fine[2 * i, 2 * j] - z[i, j]


@compiled
def _displace(first: int, last: int, sums: Real, out: Real, z: Real, n: int, offset: Real, lift: float) -> None:
    """Displacement u = offset + lift - z into ``out``.  sums: of u."""
    for i in range(first, last):
        for j in range(n):
            u = offset[i, j] + lift - z[i, j]
            out[i - first, j] = u
            sums[0] += u


@compiled
def _lay(first: int, last: int, sums: Real, u: Real, z: Real, n: int, offset: Real, lift: float) -> None:
    """Gap z = offset + lift - u."""
    for i in range(first, last):
        for j in range(n):
            z[i, j] = offset[i, j] + lift - u[i - first, j]


@compiled
def _copy(first: int, last: int, sums: Real, out: Real, values: Real, n: int) -> None:
    """The values themselves into ``out``.  sums: of them."""
    for i in range(first, last):
        for j in range(n):
            out[i - first, j] = values[i, j]
            sums[0] += values[i, j]
