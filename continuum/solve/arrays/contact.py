"""The equations of a contact on the arrays of a library, in the words of :class:`continuum.solve.grids.StiffContact`.

A vector over the contact has room for a power of two of points, so that a library compiles few shapes; a field is made
of it by the number that each point has in it.
"""

from __future__ import annotations

import math
from typing import Any

from continuum.model.fourier import Real
from continuum.solve.arrays.library import Array, fused
from continuum.solve.arrays.modes import Modes, mean, square, sum_of, without_mean
from continuum.solve.backend import kernel_points


class PressedModes(Modes):
    """A grid on which a wall presses: what its contact needs to know."""

    g: Array
    d_q: Array
    d: Array = None
    stiffness: Array = None
    change: Array = None
    """Change of the traction by the last step; all of it where that is not in the gradient yet."""
    held = False


class ArrayContact:
    """The equations of the contact of a grid."""

    a: Array
    """G g, of which what y takes is gone."""
    at: Array
    """Place of each point of the contact in a field; zero beyond the last."""
    number: Array
    """Number of each point of a field in the contact, and of a zero behind that for all others."""
    compliance: Array
    """1/D on the contact, zero beyond."""
    r: Array
    t: Array
    p: Array
    s: Array
    s_q: Array
    Gp: tuple[Array, Array]
    """G p over the points, and (1/D + G) p on the contact."""

    def __init__(self, grid: PressedModes, stiffest: float) -> None:
        self.grid, self.library, self.xp = grid, grid.library, grid.xp
        self.stiffest = stiffest
        _, self._near = kernel_points(grid.grid)
        self._kernels: dict[float, list[float]] = {}
        self._found: tuple[Array, float] = math.nan, math.nan

    def find(self, stiff: float, felt: float) -> tuple[float, float]:
        if not self.grid.held:
            return 0.0, 0.0
        least, felt_from = (self.library.number(part * self.stiffest) for part in (stiff, felt))
        share, stiffness, around = self.library.numbers(*_share(self.library, self.grid.stiffness, least, felt_from))
        if not share:
            return 0.0, 0.0
        self._found = least, stiffness / share
        return around, self._found[1] / self.stiffest

    def forget(self) -> None:
        """Give the memory of fields and vectors back."""
        self.a = self.at = self.number = self.compliance = self.r = self.t = self.p = self.s = self.s_q = None
        self.Gp = None, None

    def gradient(self, alpha: float, *, complete: bool) -> float:
        grid = self.grid
        if not complete:
            work, step = grid.forward(grid.change), self.library.number(alpha)
            grid.g = _finished(self.library, grid.g, grid.d_q, work, grid.K, step, grid.marks, held=grid.held)
        return math.sqrt(square(self.library, grid.g, grid.marks.weights))

    def set_up(self) -> None:
        grid = self.grid
        least, stiffness = self._found
        self._kernel = self._kernel_of(stiffness)
        self._mark(least)
        self.a = grid.inverse(self._comply(grid.g))
        self.r = self._on(self.a)
        self.p = self.library.zeros(self.compliance.shape)

    def _mark(self, least: Array) -> None:
        """Set which points belong to the contact, and the compliance of the wall there."""
        grid, xp = self.grid, self.xp
        stiff = xp.reshape(grid.stiffness, (-1,))
        inside = stiff > least
        (at,) = xp.nonzero(inside)
        points = at.shape[0]
        room = 1 << max(points - 1, 1).bit_length()
        self.at = xp.concat([at, xp.zeros((room - points,), dtype=at.dtype, device=self.library.device)])
        numbers = xp.cumulative_sum(xp.astype(inside, xp.int64)) - 1
        self.number = xp.reshape(xp.where(inside, numbers, room), grid.grid.shape)
        valid = xp.arange(room, device=self.library.device) < points
        self.compliance = xp.where(valid, 1 / xp.where(valid, xp.astype(xp.take(stiff, self.at), xp.float64), 1.0), 0.0)
        self._valid = xp.astype(valid, xp.float64)

    def precondition(self) -> float:
        self.t = self._smoothed()
        return float(self.xp.sum(self.r * self.t))

    def _smoothed(self) -> Array:
        """M r."""
        rows, columns = self.at // self.grid.grid.shape[1], self.at % self.grid.grid.shape[1]
        field = _flat(self.xp, self._spread(self.r))
        total: Any = 0.0
        for (i, j), weight in zip(self._near, self._kernel, strict=True):
            nx, ny = self.grid.grid.shape
            total = total + weight * self.xp.take(field, (rows + i) % nx * ny + (columns + j) % ny)
        return total * self._valid

    def curvature(self, beta: float) -> float:
        grid = self.grid
        self.p = self.t + beta * self.p
        field = grid.inverse(self._comply(grid.forward(self._spread(self.p))))
        self.Gp = field, self.compliance * self.p + self._on(field)
        return float(self.xp.sum(self.p * self.Gp[1]))

    def advance(self, alpha: float) -> None:
        field, vector = self.Gp
        self.a, self.r = self.a - alpha * field, self.r - alpha * vector

    def step(self) -> Real:
        grid = self.grid
        s = self.a - self._spread(self.r)
        self.s = s - mean(self.xp, s)
        self.s_q = grid.forward(self.s)
        waves = grid.g, grid.d_q, self.s_q, grid.K, grid.marks
        d = grid.zeros() if grid.d is None else grid.d
        sums = _step_sums(self.library, *waves, self.s, d, grid.stiffness)
        return self.library.get(sums)

    def new_direction(self, beta: float) -> float:
        grid, b = self.grid, self.library.number(beta)
        grid.d_q = b * grid.d_q - self.s_q
        grid.d = -self.s if grid.d is None else b * grid.d - self.s
        return float(mean(self.xp, grid.stiffness * grid.d * grid.d))

    def _comply(self, spectrum: Array) -> Array:
        """G times a spectrum, whose mean becomes zero."""
        grid = self.grid
        return without_mean(self.xp, spectrum / grid.K, grid.marks)

    def _on(self, field: Array) -> Array:
        """A field on the contact."""
        return self.xp.take(_flat(self.xp, field), self.at) * self._valid

    def _spread(self, vector: Array) -> Array:
        """The field of a vector, zero off the contact."""
        zero = self.library.zeros((1,))
        values = self.xp.take(self.xp.concat([vector, zero]), _flat(self.xp, self.number))
        return self.xp.reshape(values, self.grid.grid.shape)

    def _kernel_of(self, stiffness: float) -> list[float]:
        """K/(1 + K/k) over points, which the surface and a contact of stiffness k have in series."""
        k = 2.0 ** round(math.log2(stiffness))
        if k not in self._kernels:
            grid = self.grid
            M = grid.K / (1 + grid.K / k) * self.library.put([1.0, 0.0])
            field = grid.inverse(M) / grid.size
            self._kernels[k] = self.library.numbers(*(field[i, j] for i, j in self._near))
        return self._kernels[k]


class SlabContact(ArrayContact):
    """The same where fields lie in slabs on several devices: vectors are fields, zero off the contact."""

    def _mark(self, least: Array) -> None:
        self.compliance, self._valid = _inside(self.library, self.grid.stiffness, least)

    def _smoothed(self) -> Array:
        return _around(self.library, self.r, self._valid, self.library.number(self._kernel), near=tuple(self._near))

    def _on(self, field: Array) -> Array:
        return field * self._valid

    def _spread(self, vector: Array) -> Array:
        return vector


@fused
def _inside(xp: Any, stiffness: Array, least: Array) -> tuple[Array, Array]:
    """The compliance where the wall is stiffer, zero elsewhere; and one there."""
    inside = stiffness > least
    compliance = xp.where(inside, 1 / xp.where(inside, xp.astype(stiffness, xp.float64), 1.0), 0.0)
    return compliance, xp.astype(inside, xp.float64)


@fused
def _around(xp: Any, r: Array, valid: Array, kernel: Array, *, near: tuple[tuple[int, int], ...]) -> Array:
    """A kernel of points near by on a field, where that is valid."""
    return valid * sum(kernel[k] * xp.roll(r, (-i, -j), axis=(0, 1)) for k, (i, j) in enumerate(near))


def _flat(xp: Any, field: Array) -> Array:
    return xp.reshape(field, (-1,))


@fused
def _share(xp: Any, stiffness: Array, least: Array, felt: Array) -> tuple[Array, Array, Array]:
    """Share of the points where the wall is stiffer, mean of its stiffness there; share of those where it is felt."""
    inside = stiffness > least
    around = xp.astype(stiffness > felt, xp.float64)
    return mean(xp, xp.astype(inside, xp.float64)), mean(xp, xp.where(inside, stiffness, 0.0)), mean(xp, around)


@fused
def _finished(xp: Any, g: Array, d: Array, work: Array, K: Array, alpha: Array, marks: Any, *, held: bool) -> Array:
    g = g + alpha * K * d + work
    return without_mean(xp, g, marks) if held else g


@fused
def _step_sums(
    xp: Any, g: Array, d_q: Array, s_q: Array, K: Array, marks: Any, s: Array, d: Array, stiffness: Array
) -> Array:
    w = marks.weights
    waves = [sum_of(xp, w * each) for each in (g * s_q, s_q * K * s_q, s_q * K * d_q)]
    return xp.stack([*waves, mean(xp, stiffness * s * d), mean(xp, stiffness * d * d)])
