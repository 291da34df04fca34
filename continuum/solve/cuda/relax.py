"""Kernels of a coarse step that runs without being asked: its scalars stay on the device.

What they do together is said in :func:`continuum.solve.smooth.minimise_linear`, what those over spectra do in
:mod:`continuum.solve.cpu.sweeps`.  The ``state`` of a grid holds the numbers named below, and six sums.  Each kernel
that sums is followed by one that decides: of one block, which adds the parts of all blocks and sets the state.  A grid
that has come to its end does nothing any more, and so do the grids below it: the order of the launches does not depend
on what is found.
"""

from __future__ import annotations

import math

from continuum.model.fourier import Real
from continuum.solve.conjugate import Line, conjugate_line
from continuum.solve.cuda.device import Kernel, Parameters, Single, Sums, complex_at, cuda, device_function, set_complex
from continuum.solve.cuda.spectra import low_gradient_of, low_modes_of, low_row, multiplicity, restrict_of
from continuum.solve.cuda.sums import SUMS, leave

RUNS, MOVED, CONJUGATE = 0, 1, 2
"""Flags: the descent goes on; it has taken a step; the step of the coarser grid descends."""
BETA, SLOPE, CURVATURE, ALPHA = 3, 4, 5, 6
"""Numbers of the direction, and the step along it."""
SIZE, BOUND = 7, 8
"""Root-mean-square gradient, and the square at which a descent ends."""
PAIRS = 9
"""Transforms there and back since the arrays were made."""
TOTALS = 10
"""The first of the sums."""
STATE = TOTALS + SUMS
"""Numbers of a state."""

_line = device_function(conjugate_line)


# --- over the arrays of a grid ---------------------------------------------------------------------------------


@Kernel
def _begin(x: Real, d: Real, work: Real, direction: Real, state: Parameters, above: Parameters) -> None:
    """Begin at x = 0, with no direction, if the grid above goes on.

    Transforms are made in any case: of zeros then, since others would grow without bound.
    """
    if cuda.blockIdx.x == 0 and cuda.threadIdx.x == 0:
        state[RUNS] = above[RUNS]
        state[MOVED] = state[BETA] = state[SLOPE] = state[CURVATURE] = state[ALPHA] = 0.0
    for i in range(cuda.blockIdx.x, x.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, x.shape[1] // 2, cuda.blockDim.x):
            set_complex(work, i, j, 0.0, 0.0)
            if above[RUNS] > 0.0:
                set_complex(x, i, j, 0.0, 0.0)
                set_complex(d, i, j, 0.0, 0.0)
        for j in range(cuda.threadIdx.x, direction.shape[1] if above[RUNS] > 0.0 else 0, cuda.blockDim.x):
            direction[i, j] = 0.0


@Kernel
def _linear_gradient(
    g: Real, d: Real, x: Real, work: Real, K: Real, c0: float, low_rows: int, low_columns: int, single: int, held: int,
    state: Parameters, sums: Sums,
) -> None:  # fmt: skip
    if state[RUNS] == 0.0:
        return
    alpha, beta, rows = state[ALPHA], state[BETA], K.shape[0]
    gg = gs = ys = ym = ss = sd = 0.0
    for i in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
        within = i < low_rows or i > rows - low_rows
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            k, weight, low = K[i, j], multiplicity(j, single), within and j < low_columns
            m = 1.0 / (k + c0)
            g0, g1 = complex_at(g, i, j)
            d0, d1 = complex_at(d, i, j)
            x0, x1 = complex_at(x, i, j)
            y0 = y1 = 0.0
            if not (held and i == 0 and j == 0):
                y0, y1 = complex_at(work, i, j)
            if not low:
                d0 = beta * d0 - m * g0
                d1 = beta * d1 - m * g1
                set_complex(d, i, j, d0, d1)
            set_complex(x, i, j, x0 + alpha * d0, x1 + alpha * d1)
            y0 = alpha * (y0 + k * d0)
            y1 = alpha * (y1 + k * d1)
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


@Kernel
def _linear_turn(d: Real, work: Real, stiffness: Single, scale: float, state: Parameters, sums: Sums) -> None:
    if state[RUNS] == 0.0:
        return
    curvature = 0.0
    for i in range(cuda.blockIdx.x, d.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, d.shape[1], cuda.blockDim.x):
            e = state[BETA] * d[i, j] - work[i, j]
            d[i, j] = e
            traction = stiffness[i, j] * e
            work[i, j] = scale * traction
            curvature += traction * e
    leave(sums, (curvature,))


@Kernel
def _linear_last(
    g: Real, d: Real, x: Real, K: Real, c0: float, low_rows: int, low_columns: int, state: Parameters
) -> None:
    if state[RUNS] == 0.0:
        return
    alpha, beta, rows = state[ALPHA], state[BETA], K.shape[0]
    for i in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
        within = i < low_rows or i > rows - low_rows
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            g0, g1 = complex_at(g, i, j)
            d0, d1 = complex_at(d, i, j)
            x0, x1 = complex_at(x, i, j)
            if not (within and j < low_columns):
                m = 1.0 / (K[i, j] + c0)
                d0 = beta * d0 - m * g0
                d1 = beta * d1 - m * g1
                set_complex(d, i, j, d0, d1)
            set_complex(x, i, j, x0 + alpha * d0, x1 + alpha * d1)


# --- where a coarser grid has part in it -----------------------------------------------------------------------


@Kernel
def _linear_restrict(coarse: Real, fine: Real, above: Parameters) -> None:
    if above[RUNS] > 0.0:
        restrict_of(coarse, fine, 1.0 / above[SIZE])


@Kernel
def _linear_low_modes(
    g: Real, d: Real, work: Real, K: Real, e: Real, c0: float, low_rows: int, low_columns: int, single: int,
    state: Parameters, sums: Sums,
) -> None:  # fmt: skip
    if state[RUNS] > 0.0:
        low_modes_of(g, d, work, K, e, state[SIZE], c0, low_rows, low_columns, single, sums)


@Kernel
def _linear_low_gradient(
    g: Real, work: Real, K: Real, c0: float, low_rows: int, low_columns: int, single: int, state: Parameters, sums: Sums
) -> None:
    if state[RUNS] > 0.0 and state[CONJUGATE] == 0.0:
        low_gradient_of(g, work, K, c0, low_rows, low_columns, single, sums)


@Kernel
def _linear_low_direction(d: Real, work: Real, low_rows: int, low_columns: int, state: Parameters) -> None:
    if state[RUNS] == 0.0:
        return
    for r in range(cuda.blockIdx.x, 2 * low_rows - 1, cuda.gridDim.x):
        i = low_row(r, low_rows, d.shape[0])
        for j in range(cuda.threadIdx.x, low_columns, cuda.blockDim.x):
            d0, d1 = complex_at(d, i, j)
            s0, s1 = complex_at(work, i, j)
            set_complex(d, i, j, state[BETA] * d0 - s0, state[BETA] * d1 - s1)


# --- what is decided, by one block -----------------------------------------------------------------------------


@device_function
def _add(parts: Sums, count: int, totals: Sums) -> None:
    """The sums of all parts, for the first thread."""
    gg = gs = ys = ym = ss = sd = 0.0
    for k in range(cuda.threadIdx.x, count, cuda.blockDim.x):
        gg += parts[0, k]
        gs += parts[1, k]
        ys += parts[2, k]
        ym += parts[3, k]
        ss += parts[4, k]
        sd += parts[5, k]
    leave(totals, (gg, gs, ys, ym, ss, sd))


@device_function
def _set_line(state: Parameters, conjugate: bool) -> None:
    """The next direction, from the sums over all modes."""
    last = Line(state[BETA], state[SLOPE], state[CURVATURE])
    beta, slope, curvature = _line(state[TOTALS:], last, 0.0, conjugate)
    state[BETA], state[SLOPE], state[CURVATURE] = beta, slope, curvature


@Kernel
def _decide_gradient(
    parts: Sums, count: int, totals: Sums, state: Parameters, first: int, reduction: float, alone: int
) -> None:
    """Whether the gradient is small enough; if there is no coarser grid, the next direction."""
    if state[RUNS] == 0.0:
        return
    first_thread = cuda.threadIdx.x == 0
    _add(parts, count, totals)
    if first_thread:
        gg = totals[0, 0]
        for k in range(SUMS):
            state[TOTALS + k] = totals[k, 0]
        state[SIZE] = math.sqrt(gg)
        if first:
            state[BOUND] = reduction * reduction * gg
        elif not gg > state[BOUND]:
            state[RUNS] = 0.0
        if alone:
            _set_line(state, True)


@Kernel
def _decide_low_modes(parts: Sums, count: int, totals: Sums, state: Parameters, below: Parameters) -> None:
    """Whether the step of the coarser grid descends; if so, the next direction."""
    if state[RUNS] == 0.0:
        return
    first_thread = cuda.threadIdx.x == 0
    _add(parts, count, totals)
    if first_thread:
        descends = below[MOVED] > 0.0 and state[TOTALS + 1] + totals[1, 0] > 0.0
        for k in range(SUMS):
            descends = descends and math.isfinite(state[TOTALS + k] + totals[k, 0])
        state[CONJUGATE] = 1.0 if descends else 0.0
        if descends:
            for k in range(SUMS):
                state[TOTALS + k] += totals[k, 0]
            _set_line(state, True)


@Kernel
def _decide_low_gradient(parts: Sums, count: int, totals: Sums, state: Parameters) -> None:
    """If it does not, the next direction without it."""
    if state[RUNS] == 0.0 or state[CONJUGATE] > 0.0:
        return
    first_thread = cuda.threadIdx.x == 0
    _add(parts, count, totals)
    if first_thread:
        for k in range(SUMS):
            state[TOTALS + k] += totals[k, 0]
        _set_line(state, False)


@Kernel
def _decide_turn(parts: Sums, count: int, totals: Sums, state: Parameters, per_point: float) -> None:
    """The length of the step; none where the wall is softer than the substrate."""
    if state[RUNS] == 0.0:
        return
    first_thread = cuda.threadIdx.x == 0
    _add(parts, count, totals)
    if first_thread:
        state[PAIRS] += 1.0
        curvature = state[CURVATURE] + totals[0, 0] * per_point
        if curvature > 0.0:
            state[ALPHA] = -state[SLOPE] / curvature
            state[MOVED] = 1.0
        else:
            state[RUNS] = 0.0
