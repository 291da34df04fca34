"""The grid of the bound-constrained solver on the arrays of a library, in the words of :mod:`continuum.solve.grids`."""

from __future__ import annotations

from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.arrays.library import Array, Library, fused
from continuum.solve.arrays.modes import Modes, mean, square, sum_of, without_mean
from continuum.solve.backend import (
    BESIDE,
    BOUND_FIELDS,
    SMALLEST_GAP,
    SPREAD,
    factor_of,
    most_work,
    near_kernel,
    node_stiffness,
    nodes,
)
from continuum.solve.solution import Work

NEIGHBOURS = [
    (i, j) for i in range(-BESIDE, BESIDE + 1) for j in range(-BESIDE, BESIDE + 1) if i * i + j * j <= BESIDE**2
]


class ArrayBoundGrid(Modes):
    """Pressure p, gap z without its level, direction t over the points of one grid, and the preconditioner.

    Parameters
    ----------
    library, grid, stiffness_q : as for :class:`continuum.solve.arrays.modes.Modes`; what is not finite counts as zero.
    smallest : grids of no more points along a side have no coarser one.
    """

    FIELDS = BOUND_FIELDS
    p: Array
    z: Array
    t: Array
    s: Array
    m: Array
    change: Array
    mask: Array
    mean_stiffness = most = np.nan

    def __init__(self, library: Library, grid: Grid, stiffness_q: Real, smallest: int) -> None:
        self._stiffness_q = np.where(np.isfinite(stiffness_q), stiffness_q, 0.0)
        super().__init__(library, grid, self._stiffness_q)
        self._smallest = smallest
        (nx, ny), (rows, columns) = grid.shape, nodes(grid)
        # A slab begins at a node: the functions of its rows, and of the next node, are those of every slab.
        self._hats = library.hats(hats(nx, rows, library.parts), hats(ny, columns))
        self._kernel = library.number(near_kernel(grid, self._stiffness_q))
        node_grid, stiffness = node_stiffness(grid, self._stiffness_q)
        self._nodes = Modes(library, node_grid, stiffness)
        self.stiffest = max(grid.greatest_wave(self._stiffness_q), SMALLEST_GAP)
        self.softest = grid.least_wave(self._stiffness_q)

    @property
    def work(self) -> Work:
        return Work(self.grid.shape, self.transforms / 2, self.trials, 0.0)

    # --- the problem -------------------------------------------------------------------------------------------

    def set_problem(
        self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float, most: float
    ) -> bool:
        fields = (offset,) if start is None else (offset, start)
        if not np.isfinite([self.grid.total(each) for each in fields]).all():
            return False
        put = self.library.put_field
        self._start = None if start is None else put(self.grid, start)
        self._pose(put(self.grid, offset) + (lift - sink), mean_stiffness, most)
        return True

    def _pose(self, offset: Array, mean_stiffness: float, most: float) -> None:
        """With p = 0: nothing presses yet."""
        self.offset, self.mean_stiffness, self.most = offset, mean_stiffness, most
        self.set_mean_stiffness(mean_stiffness if np.isfinite(mean_stiffness) else 0.0)
        positive = self.K > 0
        self._G = self.xp.where(positive, 1 / self.xp.where(positive, self.K, 1.0), 0.0)
        self.p, self.transforms, self.trials = self.zeros(), 0.0, 0
        self.mask, self.m = self.p > 0, self.p + 1

    def set_coarser_problem(self) -> ArrayBoundGrid | None:
        grid, xp = self.grid.coarser, self.xp
        if grid is None or self.grid.narrowest <= self._smallest:
            return None
        if nodes(grid)[0] % self.library.parts or not self.library.fits(self.grid, grid):
            return None
        self.below_grid = ArrayBoundGrid(self.library, grid, self.grid.low_q(self._stiffness_q, grid), self._smallest)
        every = self.sampled(self.offset, grid)
        self.below_grid._pose(every + (mean(xp, self.offset) - mean(xp, every)), self.mean_stiffness, self.most)
        return self.below_grid

    def mean_offset(self) -> float:
        return float(mean(self.xp, self.offset))

    def touch(self) -> Real:
        offset = self.library.get_field(self.grid, self.offset)
        gap: Real = np.maximum(offset - self.grid.least(offset), SMALLEST_GAP)
        return gap

    # --- where it starts ---------------------------------------------------------------------------------------

    def guess(self, pressure: float | None) -> None:
        xp, start = self.xp, self._start
        traction = -self.inverse(self.K * self.forward(self.offset - start))
        wide = xp.astype(start >= mean(xp, start), xp.float64)
        traction = traction + (-sum_of(xp, traction * wide) / sum_of(xp, wide) if pressure is None else pressure)
        least = xp.min(start)
        beyond = start - xp.where(least > 0, least, 0.0)
        self.p = xp.where(traction > self.stiffest * beyond, self._allowed(traction), 0.0)

    def _allowed(self, p: Array) -> Array:
        """A pressure, cut at zero and the largest."""
        p = self.xp.where(p > 0, p, 0.0)
        return p if np.isinf(self.most) else self.xp.where(p < self.most, p, self.most)

    def spread(self) -> float:
        xp, p = self.xp, self.below_grid.p
        for axis, (n, points) in enumerate(zip(self.grid.shape, p.shape, strict=True)):
            if n == 2 * points:  # without a gather, for which rows on several devices would be brought together
                p = xp.reshape(xp.stack([p, (p + xp.roll(p, -1, axis=axis)) / 2], axis=axis + 1), _twice(p.shape, axis))
                continue
            at = np.arange(n) * points
            before, after = (self.library.put((at // n + k) % points, xp.int64) for k in (0, 1))
            x = self.library.put((at / n - at // n)[:, None] if axis == 0 else (at / n - at // n)[None, :])
            p = (1 - x) * xp.take(p, before, axis=axis) + x * xp.take(p, after, axis=axis)
        self.p = p
        del self.below_grid
        return self.total()

    def fill(self, pressure: float) -> None:
        self.p = self.zeros() + pressure

    def scale(self, total: float) -> bool:
        scaled = self._scaled(self.p, total, self.total())
        self.p = self.p if scaled is None else scaled
        return scaled is not None

    def _scaled(self, p: Array, wanted: float, before: float) -> Array | None:
        """A pressure scaled from one sum to another, but where it is the largest; None if no factor does."""
        if np.isinf(self.most):
            return p * (wanted / before)

        def stretched(factor: float) -> Array:
            return self.xp.where(p >= self.most, p, self._allowed(p * factor))

        def excess(factor: float) -> float:
            return float(sum_of(self.xp, stretched(factor))) - wanted

        factor = factor_of(excess)
        return None if factor is None else stretched(factor)

    def total(self) -> float:
        return float(sum_of(self.xp, self.p))

    # --- the preconditioner ------------------------------------------------------------------------------------

    def level(self) -> tuple[float, float]:
        m = self.xp.where((self.p > 0) & (self.p < self.most), self.m, 0.0)
        mz, in_m = self.library.numbers(sum_of(self.xp, m * self.z), sum_of(self.xp, m))
        return mz, in_m

    def _in_contact(self, gap: Array) -> Array:
        """The points that press or overlap, but for those that yield."""
        return ((self.p > 0) | (gap < 0)) & ((self.p < self.most) | (gap > 0))

    def select(self, level: float) -> tuple[float, float, float, float, float]:
        xp, gap = self.xp, self.z + level
        mask = self._in_contact(gap)
        changed, self.mask, self.m = mask ^ self.mask, mask, xp.where(mask, self.m, 0.0)
        counts = (sum_of(xp, xp.astype(each, xp.float64)) for each in (mask, changed))
        fourth = xp.where(mask, gap, 0.0) ** 4
        sums = *counts, sum_of(xp, self.m * self.z), sum_of(xp, self.m), sum_of(xp, fourth * fourth)
        count, new, mz, m, eighth = self.library.numbers(*sums)
        return count, new, mz, m, eighth**0.125

    def renew(self) -> None:
        ones = self.xp.astype(self.mask, self.xp.float64)
        self.m = self._stiffened(ones)
        if not float(sum_of(self.xp, self.m)) > 0:
            self.m = ones

    def _onto_nodes(self, field: Array) -> Array:
        """A field, summed onto the nodes."""
        return self.library.onto_nodes(field, self._hats) * (self._nodes.size / self.size)

    def _from_nodes(self, values: Array) -> Array:
        """What the nodes spread over the contact."""
        return self.library.from_nodes(values, self._hats) * self.xp.astype(self.mask, self.xp.float64)

    def _stiffened(self, values: Array) -> Array:
        """M of values on the contact: :mod:`continuum.solve.compiled.two_levels`."""
        density = self._onto_nodes(self.xp.astype(self.mask, self.xp.float64)) + SPREAD
        means = self._onto_nodes(values) / density
        near = _neighbours(self.library, values - self._from_nodes(means), self.mask, self._kernel)
        far = self._nodes.inverse(self._nodes.K * self._nodes.forward(means))
        self.transforms += 2 * self._nodes.size / self.size
        return near + self._from_nodes((far - self._onto_nodes(near)) / density)

    def precondition(self, level: float) -> float:
        self.s = self._stiffened(self.xp.where(self.mask, self.z + level, 0.0))
        return float(sum_of(self.xp, self.s))

    def correct(self, weight: float) -> list[float]:
        xp, self.s = self.xp, self.s - self.m * weight
        self.t = xp.where(self.mask, self.t, 0.0)
        s, t, z = self.s, self.t, self.z
        return self.library.numbers(
            *(sum_of(xp, each) for each in (s * s, z * s, self.change * s, t, z * t, z * self.m))
        )

    # --- a step ------------------------------------------------------------------------------------------------

    def clear(self) -> None:
        self.t, self.change = self.zeros(), self.zeros()

    def new_direction(self, beta: float, weight: float) -> None:
        self.t = self.xp.where(self.mask, self.s + (self.t - self.m * weight) * beta, self.t)

    def curvature(self) -> float:
        t_q = self.forward(self.t)
        self._Gt_q = self._G * t_q
        return float(sum_of(self.xp, t_q * self._Gt_q * self.marks.weights))

    def trial(self, step: float) -> tuple[float, float, float]:
        xp, wanted = self.xp, self.p - self.t * step
        self._tried = self._allowed(wanted)
        sums = (sum_of(xp, each) for each in (wanted, self._tried, xp.abs(wanted - self._tried)))
        before, after, cut_off = self.library.numbers(*sums)
        self.trials += bool(np.isfinite(after))
        return -cut_off, before, after

    def advance(self, step: float) -> None:
        self.p, self.change = self._tried, self.inverse(self._Gt_q) * -step
        self.z = self.z + self.change

    def arrive(self, before: float, after: float) -> tuple[float, float]:
        if before != after:
            scaled = self._scaled(self._tried, before, after)
            if scaled is None:
                return np.nan, np.nan
            self._tried = scaled
        self._found, energy, size = self._gap(self._tried)
        return energy, size

    def accept(self) -> None:
        self.p, self.change, self.z = self._tried, self._found - self.z, self._found

    # --- the outcome -------------------------------------------------------------------------------------------

    def displace(self) -> tuple[float, float]:
        self.z, energy, size = self._gap(self.p)
        return energy, size

    def _gap(self, p: Array) -> tuple[Array, ...]:
        """Gap under a pressure, without its level; the energy of the dual, and the size of what it is the sum of."""
        xp, z = self.xp, self.inverse(self._G * self.forward(p)) + self.offset
        energy, size = p * (z + self.offset) / 2, p * (xp.abs(z) + xp.abs(self.offset))
        return z, *self.library.numbers(mean(xp, energy), mean(xp, size))

    def misses(self, level: float) -> tuple[float, float]:
        xp, gap = self.xp, self.z + level
        error = xp.where(self._in_contact(gap), gap, 0.0)
        missed = self.K * self.forward(error)
        both = square(self.library, missed, self.marks.weights), xp.max(xp.abs(error))
        squares, worst = self.library.numbers(*both)
        return squares**0.5, worst

    def duality_gap(self) -> tuple[float, float]:
        xp, above = self.xp, self.z - self.xp.min(self.z)
        work, pressure = self.library.numbers(mean(xp, self.p * above), mean(xp, self.p))
        if np.isfinite(self.most):
            work -= most_work(self.library.get_field(self.grid, above), pressure, self.most)
        G = without_mean(xp, self._G, self.marks)
        return work, 2 * pressure * float(square(self.library, G, self.marks.weights)) ** 0.5

    def hand_out(self, level: float) -> tuple[Real, Real]:
        gap, p = (self.library.get_field(self.grid, each) for each in (self.z, self.p))
        gap += level
        closed = np.where(p >= self.most, np.minimum(gap, 0.0), 0.0)
        return np.where(p > 0, closed, np.maximum(gap, SMALLEST_GAP)), p

    # --- what only processor cores have ------------------------------------------------------------------------

    def tiles(self, level: float, energy: float, size: float) -> None:
        return None

    def take(self, tiles: Any) -> None:
        raise NotImplementedError


@fused
def _neighbours(xp: Any, values: Array, mask: Array, kernel: Array) -> Array:
    """K of a field between neighbours, on the contact."""
    total = 0.0
    for i, j in NEIGHBOURS:
        total = total + kernel[BESIDE + i, BESIDE + j] * xp.roll(values, (-i, -j), axis=(0, 1))
    return xp.where(mask, total, 0.0)


def _twice(shape: tuple[int, ...], axis: int) -> tuple[int, ...]:
    """A shape with twice the points along one direction."""
    return tuple(2 * n if i == axis else n for i, n in enumerate(shape))


def hats(points: int, count: int, parts: int = 1) -> Real:
    """Value at each point of the hat functions around so many nodes along one direction.

    Of several parts, those at the points of the first one, of its nodes and of the next one.
    """
    around = np.arange(count if parts == 1 else count // parts + 1)
    distance = np.arange(points // parts)[:, None] * count / points - around
    whole: Real = sum(np.maximum(1 - np.abs(distance + period), 0.0) for period in (-count, 0, count))
    return whole
