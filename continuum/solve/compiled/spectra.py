"""Fused sweeps of the minimiser over its spectra, compiled.

A sweep over a spectrum is a function of the columns ``first:last`` of a block, which writes that block's sums.
Spectra are passed as real arrays with padded rows, real and imaginary parts in turn: the compiler vectorises these.
``weights`` says how often a column counts in a sum over all modes: 0 and, on even grids, ny/2 once, all others twice.
Numbers are made of the type of the arrays before a loop, so that those in single precision are computed in it.

The next coarser grid carries the columns below ``low_columns`` of the rows within ``low_rows`` of row 0.
"""

from typing import NamedTuple

from continuum.model.fourier import Real
from continuum.solve.compiled.compiling import Field, compiled, inlined

Low = tuple[int, int]
"""``low_rows`` and ``low_columns``; zeros where no coarser grid takes part."""


class Spectra(NamedTuple):
    """The arrays of a grid over the modes, all of one precision."""

    g: Field
    """Gradient."""
    d: Field
    """Direction of the steps."""
    work: Field
    """What is transformed, or was."""
    K: Field
    weights: Field
    """Weights of the columns."""


@compiled
def finish_gradient(
    first: int, last: int, sums: Real, spectra: Spectra, x: Field | None, c0: float, alpha: float, beta: float, low: Low
) -> None:
    """Finish the last step in Fourier space and precondition the new gradient.

    On entry ``work`` holds the change of traction of that step, alpha its length, beta the weight of the direction
    before it::

        d <- beta d - M g        (the direction of the step, M = 1/(K + c0))
        y  = alpha K d + work
        g <- g + y
        work <- s = M g          modes of the coarse grid: y, and d is left as it is

    Where the wall is linear there is an x, x <- x + alpha d, and ``work`` holds the traction of a step of length one.
    sums: |g|², and without the coarse modes <g,s>, <y,s>, <y,My>, <s,Ks>, <s,Kd>.
    """
    g, d, work, K, weights = spectra
    rows, (low_rows, low_columns) = K.shape[0], low
    part, weight = slice(2 * first, 2 * last), weights[first:last]
    for i in range(rows):
        gi, di, wi, ki = g[i, part], d[i, part], work[i, part], K[i, first:last]
        if first < low_columns and (i < low_rows or i > rows - low_rows):
            if x is not None:
                _scale(wi, alpha)
            sums[0] += _finish_low(gi, di, wi, ki, weight, alpha)
        else:
            # A row stays in the cache for three short loops, which vectorise where one long one does not.
            _follow(gi, di, wi, ki, c0, alpha, beta, 1.0 if x is None else alpha)
            gg, gs, ys, ym = _finish(gi, wi, ki, weight, c0)
            ss, sd = _precondition(gi, di, wi, ki, weight, c0)
            sums[0] += gg
            _add(sums, gs, ys, ym, ss, sd)
        if x is not None:
            _advance(x[i, part], di, alpha)


@compiled
def linear_last(
    first: int, last: int, sums: Real, spectra: Spectra, x: Field, c0: float, alpha: float, beta: float, low: Low
) -> None:
    """The last step alone, after which no gradient is needed: x <- x + alpha d."""
    g, d, _, K, _ = spectra
    real = K.dtype.type
    c, b = real(c0), real(beta)
    rows, (low_rows, low_columns) = K.shape[0], low
    part = slice(2 * first, 2 * last)
    for i in range(rows):
        gi, di, ki = g[i, part], d[i, part], K[i, first:last]
        if not (first < low_columns and (i < low_rows or i > rows - low_rows)):
            for j in range(ki.size):
                m = real(1.0) / (ki[j] + c)
                di[2 * j] = b * di[2 * j] - m * gi[2 * j]
                di[2 * j + 1] = b * di[2 * j + 1] - m * gi[2 * j + 1]
        _advance(x[i, part], di, alpha)


@inlined
def _add(sums: Real, gs: float, ys: float, ym: float, ss: float, sd: float) -> None:
    """The sums of a row, but for <g g>, to those of the block."""
    sums[1] += gs
    sums[2] += ys
    sums[3] += ym
    sums[4] += ss
    sums[5] += sd


@inlined
def _scale(values: Field, factor: float) -> None:
    """Multiply a row by a number."""
    a = values.dtype.type(factor)
    for c in range(values.size):
        values[c] *= a


@inlined
def _advance(xi: Field, di: Field, alpha: float) -> None:
    """A row: x <- x + alpha d."""
    a = xi.dtype.type(alpha)
    for c in range(xi.size):
        xi[c] += a * di[c]


@inlined
def _finish_low(gi: Field, di: Field, wi: Field, ki: Field, weight: Field, alpha: float) -> float:
    """A row of the coarse grid's modes: work <- y, g <- g + y; |g|²."""
    a = ki.dtype.type(alpha)
    gg: float = ki.dtype.type(0.0)
    for j in range(ki.size):
        y0 = a * ki[j] * di[2 * j] + wi[2 * j]
        y1 = a * ki[j] * di[2 * j + 1] + wi[2 * j + 1]
        g0, g1 = gi[2 * j] + y0, gi[2 * j + 1] + y1
        wi[2 * j] = y0
        wi[2 * j + 1] = y1
        gi[2 * j] = g0
        gi[2 * j + 1] = g1
        gg += weight[j] * (g0 * g0 + g1 * g1)
    return gg


@inlined
def _follow(gi: Field, di: Field, wi: Field, ki: Field, c0: float, alpha: float, beta: float, scale: float) -> None:
    """A row of the others: d <- beta d - M g, work <- y, the work of the wall times ``scale``."""
    real = ki.dtype.type
    c, a, b, f, one = real(c0), real(alpha), real(beta), real(scale), real(1.0)
    for j in range(ki.size):
        k = ki[j]
        m = one / (k + c)
        d0 = b * di[2 * j] - m * gi[2 * j]
        d1 = b * di[2 * j + 1] - m * gi[2 * j + 1]
        di[2 * j] = d0
        di[2 * j + 1] = d1
        wi[2 * j] = f * wi[2 * j] + a * k * d0
        wi[2 * j + 1] = f * wi[2 * j + 1] + a * k * d1


@inlined
def _finish(gi: Field, wi: Field, ki: Field, weight: Field, c0: float) -> tuple[float, float, float, float]:
    """The same row: g <- g + y; |g|², <g,s>, <y,s>, <y,My>."""
    c = ki.dtype.type(c0)
    gg = gs = ys = ym = ki.dtype.type(0.0)
    for j in range(ki.size):
        w = weight[j]
        m = w / (ki[j] + c)
        y0, y1 = wi[2 * j], wi[2 * j + 1]
        g0, g1 = gi[2 * j] + y0, gi[2 * j + 1] + y1
        gi[2 * j] = g0
        gi[2 * j + 1] = g1
        square = g0 * g0 + g1 * g1
        gg += w * square
        gs += m * square
        ys += m * (y0 * g0 + y1 * g1)
        ym += m * (y0 * y0 + y1 * y1)
    return gg, gs, ys, ym


@inlined
def _precondition(gi: Field, di: Field, wi: Field, ki: Field, weight: Field, c0: float) -> tuple[float, float]:
    """The same row: work <- s = M g; <s,Ks>, <s,Kd>."""
    c, one = ki.dtype.type(c0), ki.dtype.type(1.0)
    ss = sd = ki.dtype.type(0.0)
    for j in range(ki.size):
        k = ki[j]
        m = one / (k + c)
        s0, s1 = m * gi[2 * j], m * gi[2 * j + 1]
        wi[2 * j] = s0
        wi[2 * j + 1] = s1
        k *= weight[j]
        ss += k * (s0 * s0 + s1 * s1)
        sd += k * (s0 * di[2 * j] + s1 * di[2 * j + 1])
    return ss, sd


@compiled
def finish_low_modes(
    first: int, last: int, sums: Real, spectra: Spectra, c0: float, low_rows: int, e: Field, size: float
) -> None:
    """The modes that the coarse grid has seen: work <- s = -size e, and their share of the sums of `gradient`."""
    g, d, work, K, weights = spectra
    real = K.dtype.type
    c, factor = real(c0), -real(size)
    rows, part, weight = K.shape[0], slice(2 * first, 2 * last), weights[first:last]
    for i in range(rows):
        if low_rows <= i <= rows - low_rows:
            continue
        coarse = i if i < low_rows else i - rows + e.shape[0]
        gi, di, wi, ei, ki = g[i, part], d[i, part], work[i, part], e[coarse, part], K[i, first:last]
        gs = ys = ym = ss = sd = real(0.0)
        for j in range(ki.size):
            w = weight[j]
            y0, y1 = wi[2 * j], wi[2 * j + 1]
            s0, s1 = factor * ei[2 * j], factor * ei[2 * j + 1]
            wi[2 * j] = s0
            wi[2 * j + 1] = s1
            ym += w / (ki[j] + c) * (y0 * y0 + y1 * y1)
            ys += w * (y0 * s0 + y1 * s1)
        for j in range(ki.size):
            w = weight[j]
            k = w * ki[j]
            s0, s1 = wi[2 * j], wi[2 * j + 1]
            gs += w * (gi[2 * j] * s0 + gi[2 * j + 1] * s1)
            ss += k * (s0 * s0 + s1 * s1)
            sd += k * (s0 * di[2 * j] + s1 * di[2 * j + 1])
        _add(sums, gs, ys, ym, ss, sd)


@compiled
def low_gradient(first: int, last: int, sums: Real, spectra: Spectra, c0: float, low_rows: int) -> None:
    """The same modes where the coarse step does not descend: work <- s = M g; sums: <g,s> at 1, <s,Ks> at 4."""
    g, _, work, K, weights = spectra
    c = K.dtype.type(c0)
    rows = K.shape[0]
    for i in range(rows):
        if low_rows <= i <= rows - low_rows:
            continue
        for j in range(first, last):
            w, k = weights[j], K[i, j]
            for part in range(2 * j, 2 * j + 2):
                s = g[i, part] / (k + c)
                work[i, part] = s
                sums[1] += w * g[i, part] * s
                sums[4] += w * k * s * s


@compiled
def low_direction(first: int, last: int, sums: Real, spectra: Spectra, low_rows: int, beta: float) -> None:
    """Direction d <- beta d - s for those modes; the others follow in `gradient`."""
    _, d, work, _, _ = spectra
    b = d.dtype.type(beta)
    rows, part = d.shape[0], slice(2 * first, 2 * last)
    for i in range(rows):
        if low_rows <= i <= rows - low_rows:
            continue
        di, wi = d[i, part], work[i, part]
        for c in range(di.size):
            di[c] = b * di[c] - wi[c]


@compiled
def restrict_modes(
    first: int, last: int, sums: Real, g: Field, coarse: Field, low_rows: int, low_columns: int, size: float
) -> None:
    """The modes of the coarse grid over ``size``, without its Nyquist modes, into its array."""
    factor = 1.0 / size
    for i in range(coarse.shape[0]):
        ci = coarse[i, 2 * first : 2 * last]
        if i == low_rows:
            ci[:] = 0.0
        else:
            gi = g[i if i < low_rows else i - coarse.shape[0] + g.shape[0], 2 * first : 2 * last]
            for c in range(ci.size):
                ci[c] = factor * gi[c]
        if last == low_columns:
            coarse[i, 2 * last] = coarse[i, 2 * last + 1] = 0.0


@compiled
def elastic_gradient(first: int, last: int, sums: Real, g: Field, work: Field, K: Field, force: float) -> None:
    """Gradient without the traction of the wall: g <- K u - F, the spectrum of u in work."""
    for i in range(K.shape[0]):
        for j in range(first, last):
            g[i, 2 * j] = K[i, j] * work[i, 2 * j]
            g[i, 2 * j + 1] = K[i, j] * work[i, 2 * j + 1]
    if first == 0:
        g[0, 0] -= force


@compiled
def yielding(first: int, last: int, sums: Real, work: Field, K: Field, force: float) -> None:
    """Displacement under a traction, whose spectrum is in work, and a force: work <- (F - work)/K.  sums: its mean."""
    if first == 0:
        work[0, 0] -= force
    for i in range(K.shape[0]):
        for j in range(first, last):
            work[i, 2 * j] /= -K[i, j]
            work[i, 2 * j + 1] /= -K[i, j]
    if first == 0:
        sums[0] = work[0, 0]
