"""The equations of a contact on processor cores, in the words of :class:`continuum.solve.grids.StiffContact`.

Transforms are in the precision of the linear problems, as a step is a direction only, and lie in the memory of the
spectrum that is transformed.  Points of the contact are kept row by row; what is known on them alone is a vector.
"""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import kernel_points
from continuum.solve.compiled import spectra
from continuum.solve.compiled.compiling import Field, Index, Single, compiled
from continuum.solve.compiled.linear import SteppedPasses
from continuum.solve.compiled.passes import Passes


class _Response(Passes):
    """G = 1/K on a grid, and one field, in the memory of a spectrum of double precision that is not in use."""

    def __init__(self, grid: Grid, stiffness_q: Real, threads: int, precision: type, spectrum: Real) -> None:
        super().__init__(grid, np.array(stiffness_q, dtype=precision, order="C"), threads)
        self.field: Field
        if precision is np.float64:
            self.field = self.rows()
        else:
            halves: list[Any] = np.split(spectrum.reshape(-1).view(precision), 2)
            self.w, self.field = (half.reshape(grid.shape[0], -1) for half in halves)
            self.work_q = cast("Any", self.w.view(np.complex64)[:, : grid.shape_q[1]])

    def comply(self) -> None:
        """Set the field to that of G times the spectrum, whose rows are transformed already."""
        self.spectral(lambda a, b, sums: divide_modes(a, b, sums, self.w, self.K), forward=True, inverse=True)


class CompiledContact:
    """The equations of the contact of a grid; memory is made when they are first asked for.

    Parameters
    ----------
    grid : whose gap and gradient it steps from.
    stiffness_q : K over the half spectrum, in E*/a0.
    threads, precision : of its transforms.
    """

    a: Field
    """G g, of which what y takes is gone; in the end s, without its mean."""

    def __init__(self, grid: SteppedPasses, stiffness_q: Real, threads: int, precision: type) -> None:
        self.grid, self._made = grid, (threads, precision)
        self.stiffest = float(stiffness_q[:, 1:].max())
        self._response: _Response | None = None
        self._kernels: dict[float, Field] = {}
        self._found, self._mean = (np.nan, np.nan), 0.0

    @property
    def response(self) -> _Response:
        """G, in the memory of the spectrum that the grid transforms."""
        if self._response is None:
            self._response = _Response(self.grid.grid, self.grid.K, *self._made, self.grid.w)
            self.a = self._response.rows()
        return self._response

    def forget(self) -> None:
        """Give the memory back."""
        if self._response is not None:
            self._response = None
            del self.a

    def find(self, stiff: float, felt: float) -> tuple[float, float]:
        grid, least = self.grid, stiff * self.stiffest
        if not grid.held:
            return 0.0, 0.0
        points, total, around = grid.sweep(stiff_points, grid.stiffness, grid.n, least, felt * self.stiffest)[:3]
        if not points:
            return 0.0, 0.0
        stiffness = float(total / points)
        self._found = least, stiffness
        return float(around) / grid.size, stiffness / self.stiffest

    def gradient(self, alpha: float, *, complete: bool) -> float:
        grid = self.grid
        if complete:
            grid.w[...], alpha = 0.0, 0.0
        low = grid.K.shape[0] + 1, grid.K.shape[1]  # so no mode is preconditioned, and d is left as it is
        given = grid.spectra, None, 0.0, alpha, 0.0, low
        sums = grid.spectral(lambda a, b, sums: spectra.finish_gradient(a, b, sums, *given), forward=not complete)
        return float(np.sqrt(sums[0]))

    def set_up(self) -> None:
        grid, response = self.grid, self.response
        least, stiffness = self._found
        self._kernel = self._kernel_of(stiffness)
        self.begin = np.zeros(grid.grid.shape[0] + 1, np.int64)
        count_stiff(grid.stiffness, grid.n, least, self.begin)
        self.columns = np.empty(self.begin[-1], np.int64)
        self.compliance, self.r, self.t, self.p = np.zeros((4, self.begin[-1]))
        take_stiff(grid.stiffness, grid.n, least, self.begin, self.columns, self.compliance)
        # g of double precision is no longer needed in the spectrum that is transformed.
        response.spectral(lambda a, b, sums: load_modes(a, b, sums, response.w, grid.g), inverse=False)
        K = response.K
        response.spectral(lambda a, b, sums: divide_modes(a, b, sums, response.w, K), inverse=True)
        a, n, field = self.a, grid.n, response.field
        response.through(lambda i, j, sums, u: keep_rows(i, j, sums, u, a, n), inverse=True)
        response.sweep(gather_contact, self.a, field, n, self.begin, self.columns, self.r)
        self._count()

    def precondition(self) -> float:
        given = self.response.field, self.grid.n, self._kernel, self.begin, self.columns, self.r, self.t
        return float(self.response.sweep(precondition_contact, *given)[0])

    def curvature(self, beta: float) -> float:
        response, n = self.response, self.grid.n
        given = n, self.begin, self.columns, self.t, self.p, beta
        response.through(lambda i, j, sums, u: next_direction_on(i, j, sums, u, *given), forward=True)
        response.comply()
        field, rest = response.field, (n, self.begin, self.columns, self.p, self.compliance)
        sums = response.through(lambda i, j, sums, u: contact_curvature(i, j, sums, u, field, *rest), inverse=True)
        self._count()
        return float(sums[0])

    def advance(self, alpha: float) -> None:
        given = self.a, self.response.field, self.grid.n, self.begin, self.columns, self.p, self.compliance, self.r
        self.response.sweep(advance_contact, *given, alpha)

    def step(self) -> Real:
        grid = self.grid
        given = self.a, grid.n, self.begin, self.columns, self.r, grid.direction, grid.stiffness
        total, pull, dd, mean = grid.through(
            lambda i, j, sums, u: step_off_contact(i, j, sums, u, *given), forward=True
        )[:4]
        self._mean = float(total) / grid.size
        fields = grid.spectra
        gs, ss, sd = grid.spectral(lambda a, b, sums: step_sums(a, b, sums, fields), forward=True)[:3]
        return np.array([gs, ss, sd, (pull - self._mean * mean) / grid.size, dd / grid.size])

    def new_direction(self, beta: float) -> float:
        grid = self.grid
        grid.over(follow_step, grid.column_edges, grid.d, grid.w, beta)
        given = grid.direction, self.a, grid.n, beta, self._mean, grid.stiffness
        return float(grid.sweep(contact_direction, *given)[0]) / grid.size

    def _kernel_of(self, stiffness: float) -> Field:
        """K/(1 + K/k) over points, which the surface and a contact of stiffness k have in series."""
        k = 2.0 ** round(math.log2(stiffness))
        if k not in self._kernels:
            response, (rows, columns), near = self.response, *kernel_points(self.grid.grid)
            K = response.K
            response.spectral(lambda a, b, sums: modes_in_series(a, b, sums, response.w, K, k), inverse=True)
            field, n = response.field, response.n
            response.through(lambda i, j, sums, u: keep_rows(i, j, sums, u, field, n), inverse=True)
            kernel = np.zeros((2 * rows + 1, 2 * columns + 1), response.K.dtype)
            for i, j in near:
                kernel[rows + i, columns + j] = field[i, j if j >= 0 else j + n] / response.size
            self._kernels[k] = kernel
            self._count()
        return self._kernels[k]

    def _count(self) -> None:
        """Count the transforms as the grid's."""
        response = self.response
        self.grid.transforms += response.transforms
        self.grid.fft_seconds += response.fft_seconds
        response.forget_work()


# --- sweeps over the rows, and over the points of the contact in them ---------------------------------------------


@compiled
def stiff_points(first: int, last: int, sums: Real, stiffness: Single, n: int, least: float, felt: float) -> None:
    """Sums: points where the wall is stiffer than ``least``, its stiffness there; points where it is than ``felt``."""
    points, around, total = 0, 0, 0.0
    for i in range(first, last):
        for j in range(n):
            around += stiffness[i, j] > felt
            if stiffness[i, j] > least:
                points += 1
                total += stiffness[i, j]
    sums[0], sums[1], sums[2] = points, total, around


@compiled
def count_stiff(stiffness: Single, n: int, least: float, begin: Index) -> None:
    """Set ``begin`` to the number of the first point of each row, and of all behind the last."""
    for i in range(stiffness.shape[0]):
        points = 0
        for j in range(n):
            points += stiffness[i, j] > least
        begin[i + 1] = begin[i] + points


@compiled
def take_stiff(stiffness: Single, n: int, least: float, begin: Index, columns: Index, compliance: Real) -> None:
    """Columns of the points of each row, and 1/D there."""
    for i in range(stiffness.shape[0]):
        at = begin[i]
        for j in range(n):
            if stiffness[i, j] > least:
                columns[at] = j
                compliance[at] = 1.0 / stiffness[i, j]
                at += 1


@compiled
def keep_rows(first: int, last: int, sums: Real, out: Field, field: Field, n: int) -> None:
    """Keep rows that were transformed back in a field."""
    for i in range(first, last):
        for j in range(n):
            field[i, j] = out[i - first, j]


@compiled
def gather_contact(
    first: int, last: int, sums: Real, a: Field, field: Field, n: int, begin: Index, columns: Index, r: Real
) -> None:
    """Set r to a field on the contact; another field holds it, zero off the contact."""
    for i in range(first, last):
        field[i, :n] = 0.0
        for c in range(begin[i], begin[i + 1]):
            r[c] = a[i, columns[c]]
            field[i, columns[c]] = r[c]


@compiled
def precondition_contact(
    first: int,
    last: int,
    sums: Real,
    field: Field,
    n: int,
    kernel: Field,
    begin: Index,
    columns: Index,
    r: Real,
    t: Real,
) -> None:
    """Set t <- M r by the kernel of M, from the field of r.  sums: of r t."""
    rows, half = field.shape[0], kernel.shape[1] // 2
    up, total = kernel.shape[0] // 2, 0.0
    for i in range(first, last):
        for c in range(begin[i], begin[i + 1]):
            left, value = columns[c] - half, field.dtype.type(0.0)
            inside = left >= 0 and columns[c] + half < n
            for a in range(kernel.shape[0]):
                row = i + a - up
                row += rows if row < 0 else (-rows if row >= rows else 0)
                weights = kernel[a]
                if inside:
                    values = field[row, left : left + weights.size]
                    for b in range(weights.size):
                        value += weights[b] * values[b]
                else:
                    for b in range(weights.size):
                        value += weights[b] * field[row, (left + b) % n]
            t[c] = value
            total += r[c] * value
    sums[0] = total


@compiled
def next_direction_on(
    first: int, last: int, sums: Real, out: Field, n: int, begin: Index, columns: Index, t: Real, p: Real, beta: float
) -> None:
    """Set p <- t + beta p, and rows to it, zero off the contact."""
    for i in range(first, last):
        out[i - first, :n] = 0.0
        for c in range(begin[i], begin[i + 1]):
            p[c] = t[c] + beta * p[c]
            out[i - first, columns[c]] = p[c]


@compiled
def contact_curvature(
    first: int,
    last: int,
    sums: Real,
    out: Field,
    field: Field,
    n: int,
    begin: Index,
    columns: Index,
    p: Real,
    compliance: Real,
) -> None:
    """Keep G p, transformed back, in a field.  sums: of p (1/D + G) p over the contact."""
    total = 0.0
    for i in range(first, last):
        for j in range(n):
            field[i, j] = out[i - first, j]
        for c in range(begin[i], begin[i + 1]):
            total += p[c] * (compliance[c] * p[c] + out[i - first, columns[c]])
    sums[0] = total


@compiled
def advance_contact(
    first: int,
    last: int,
    sums: Real,
    a: Field,
    field: Field,
    n: int,
    begin: Index,
    columns: Index,
    p: Real,
    compliance: Real,
    r: Real,
    alpha: float,
) -> None:
    """Set a <- a - alpha G p and r <- r - alpha (1/D + G) p; the field of G p then holds r, zero off the contact."""
    part = field.dtype.type(alpha)
    for i in range(first, last):
        for c in range(begin[i], begin[i + 1]):
            r[c] -= alpha * (compliance[c] * p[c] + field[i, columns[c]])
        for j in range(n):
            a[i, j] -= part * field[i, j]
            field[i, j] = 0.0
        for c in range(begin[i], begin[i + 1]):
            field[i, columns[c]] = r[c]


@compiled
def step_off_contact(
    first: int,
    last: int,
    sums: Real,
    out: Real,
    a: Field,
    n: int,
    begin: Index,
    columns: Index,
    r: Real,
    d: Real,
    stiffness: Single,
) -> None:
    """Set a to the step s, and rows to it.  sums: of s, D s d, D d d and D d, D being the stiffness of the wall."""
    total = pull = square = mean = 0.0
    for i in range(first, last):
        for c in range(begin[i], begin[i + 1]):
            a[i, columns[c]] -= r[c]
        for j in range(n):
            s = float(a[i, j])
            out[i - first, j] = s
            total += s
            stiff = stiffness[i, j] * d[i, j]
            pull += stiff * s
            square += stiff * d[i, j]
            mean += stiff
    sums[0], sums[1], sums[2], sums[3] = total, pull, square, mean


@compiled
def contact_direction(
    first: int, last: int, sums: Real, d: Real, s: Field, n: int, beta: float, mean: float, stiffness: Single
) -> None:
    """New direction, d <- beta d - (s - mean).  sums: of stiffness d²."""
    curvature = 0.0
    for i in range(first, last):
        for j in range(n):
            d[i, j] = beta * d[i, j] - (s[i, j] - mean)
            curvature += stiffness[i, j] * d[i, j] * d[i, j]
    sums[0] = curvature


# --- sweeps over the modes ----------------------------------------------------------------------------------------


@compiled
def load_modes(first: int, last: int, sums: Real, work: Field, g: Field) -> None:
    """Set the spectrum that is transformed to another."""
    for i in range(work.shape[0]):
        for c in range(2 * first, 2 * last):
            work[i, c] = g[i, c]


@compiled
def divide_modes(first: int, last: int, sums: Real, work: Field, K: Field) -> None:
    """Divide a spectrum by K, but for its mean, which becomes zero."""
    one = K.dtype.type(1.0)
    for i in range(K.shape[0]):
        for j in range(first, last):
            compliance = one / K[i, j]
            work[i, 2 * j] *= compliance
            work[i, 2 * j + 1] *= compliance
    if first == 0:
        work[0, 0] = work[0, 1] = 0.0


@compiled
def modes_in_series(first: int, last: int, sums: Real, work: Field, K: Field, k: float) -> None:
    """The spectrum of K/(1 + K/k)."""
    for i in range(K.shape[0]):
        for j in range(first, last):
            work[i, 2 * j] = K[i, j] / (1.0 + K[i, j] / k)
            work[i, 2 * j + 1] = 0.0


@compiled
def step_sums(first: int, last: int, sums: Real, given: spectra.Spectra) -> None:
    """Sums <g s>, <s K s> and <s K d> of the step s that was transformed."""
    g, d, s, K, weights = given
    gs = ss = sd = 0.0
    for i in range(K.shape[0]):
        for j in range(first, last):
            w, s0, s1 = weights[j], s[i, 2 * j], s[i, 2 * j + 1]
            k = w * K[i, j]
            gs += w * (g[i, 2 * j] * s0 + g[i, 2 * j + 1] * s1)
            ss += k * (s0 * s0 + s1 * s1)
            sd += k * (d[i, 2 * j] * s0 + d[i, 2 * j + 1] * s1)
    sums[0], sums[1], sums[2] = gs, ss, sd


@compiled
def follow_step(first: int, last: int, sums: Real, d: Real, s: Real, beta: float) -> None:
    """Spectrum of the new direction, d <- beta d - s."""
    for i in range(d.shape[0]):
        for c in range(2 * first, 2 * last):
            d[i, c] = beta * d[i, c] - s[i, c]
