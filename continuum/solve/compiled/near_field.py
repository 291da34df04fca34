"""Compiled sweeps of a response on tiles: a compact near field, summed directly, and splines to and from a coarse grid.

Tiles of 32 x 32 points lie one below the other in the rows of a field of 32 columns.  The far field goes by way of the
grid of every fourth point, along each direction with cubic B-splines on its points: eleven of them reach a tile.
Everything is in single precision, as only changes pass.  Each is a function of the tiles ``start:stop`` of a block.
"""

import numpy as np

from continuum.model.fourier import Real
from continuum.solve.compiled.compiling import TILE, Field, Index, Marks, Mask, Single, compiled

SIDE = 32
"""Points along the side of a tile."""
RATIO = 4
"""Spacing of the coarse grid, in points."""
REACHED = SIDE // RATIO + 3
"""Points of the coarse grid along a side that reach a tile."""


def cubic_spline(x: Real) -> Real:
    """The cubic B-spline, whose sum over all whole numbers is one."""
    x = np.abs(x)
    return np.where(x < 1, (4 - 6 * x**2 + 3 * x**3) / 6, np.where(x < 2, (2 - x) ** 3 / 6, 0.0))


def weights() -> Single:
    """Weights of the four points of the coarse grid around each point along a tile, shape (4, SIDE)."""
    behind = np.arange(SIDE) % RATIO / RATIO
    return cubic_spline(behind - np.arange(-1, 3)[:, None]).astype(np.float32)


def width(reach: int) -> int:
    """Columns that four neighbouring points reach: of both near fields eight numbers each, which are added at once."""
    return 2 * reach + 2


@compiled
def mark_tiles(
    start: int, stop: int, sums: Real, p: Real, z: Real, below: float, touched: Marks, lowest: Real, out: Mask
) -> None:
    """Mark the tiles in which p presses or z lies below a level; ``start:stop`` are rows of points."""
    side = p.shape[0] // out.shape[0]
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0 and lowest[i, tile] >= below:
                continue
            for part in range(TILE // side):
                a = tile * TILE + part * side
                pi, zi = p[i, a : a + side], z[i, a : a + side]
                here = False
                for j in range(side):
                    here |= (pi[j] > 0.0) | (zi[j] < below)
                if here:
                    out[i // side, a // side] = True


@compiled
def near_field(
    start: int, stop: int, sums: Real, values: Real, kernel: Single, reach: int, columns: int, own: Single, some: Mask
) -> None:
    """What the values of each tile do on it and around it, in ``own``; ``some``: whether there are any.

    Row d of the kernel is what a value does d rows away on either side, with four zeros before it and behind it.
    """
    side = values.shape[1]
    beside = np.empty(columns, np.float32)
    for s in range(start, stop):
        field = own[s]
        some[s] = False
        for i in range(side):
            row = values[s * side + i]
            for j in range(0, side, 4):
                a, b, c, d = np.float32(row[j]), np.float32(row[j + 1]), np.float32(row[j + 2]), np.float32(row[j + 3])
                if a == 0.0 and b == 0.0 and c == 0.0 and d == 0.0:
                    continue
                if not some[s]:
                    field[:] = 0.0
                    some[s] = True
                k = kernel[0]
                along = field[i + reach - 1, j : j + columns]
                for x in range(columns):
                    along[x] += a * k[x + 4] + b * k[x + 3] + c * k[x + 2] + d * k[x + 1]
                for far in range(1, reach):
                    k = kernel[far]
                    after = field[i + reach - 1 + far, j : j + columns]
                    before = field[i + reach - 1 - far, j : j + columns]
                    for x in range(columns):
                        beside[x] = a * k[x + 4] + b * k[x + 3] + c * k[x + 2] + d * k[x + 1]
                    for x in range(columns):
                        after[x] += beside[x]
                    for x in range(columns):
                        before[x] += beside[x]


@compiled
def gather_near(
    start: int, stop: int, sums: Real, own: Single, some: Mask, reach: int, tiles: Index, slots: Index, out: Single
) -> None:
    """Set out <- the sum of what each tile and its eight neighbours do there."""
    side = out.shape[1]
    more = reach - 1
    for s in range(start, stop):
        out[s * side : (s + 1) * side] = 0.0
        for da in range(-1, 2):
            for db in range(-1, 2):
                near = slots[(tiles[s, 0] - da) % slots.shape[0], (tiles[s, 1] - db) % slots.shape[1]]
                if near < 0 or not some[near]:
                    continue
                shift = side * db + more
                first, last = max(0, -shift), min(side, side + 2 * more - shift)
                for i in range(max(0, -side * da - more), min(side, side + more - side * da)):
                    there = own[near, i + side * da + more, first + shift : last + shift]
                    here = out[s * side + i, first:last]
                    for j in range(here.size):
                        here[j] += there[j]


@compiled
def to_coarse(start: int, stop: int, sums: Real, values: Real, spline: Single, own: Single) -> None:
    """What the points of the coarse grid around each tile get of its values, in ``own``."""
    side, reached = values.shape[1], own.shape[1]
    ratio = side // (reached - 3)
    rows = np.empty((reached, side), np.float32)
    line = np.empty(ratio * reached, np.float32)
    for s in range(start, stop):
        rows[:] = 0.0
        for i in range(side):
            row = values[s * side + i]
            size = 0.0
            for j in range(side):
                size += abs(row[j])
            if size == 0.0:
                continue
            for q in range(4):
                w, onto = spline[q, i], rows[i // ratio + q]
                for j in range(side):
                    onto[j] += w * np.float32(row[j])
        for a in range(reached):
            line[:] = 0.0
            for q in range(4):
                w, onto = spline[q], line[ratio * q : ratio * q + side]
                for j in range(side):
                    onto[j] += w[j] * rows[a, j]
            for b in range(reached):
                total = np.float32(0.0)
                for j in range(ratio):
                    total += line[ratio * b + j]
                own[s, a, b] = total / np.float32(ratio * ratio)


@compiled
def add_coarse(start: int, stop: int, sums: Real, own: Single, tiles: Index, slots: Index, out: Single) -> None:
    """Set out <- the sum of what its points get of the tiles."""
    reached = own.shape[1]
    apart = reached - 3
    rows, columns = slots.shape[0] * apart, slots.shape[1] * apart
    out[:] = 0.0
    for s in range(start, stop):
        for a in range(reached):
            onto = out[(tiles[s, 0] * apart - 1 + a) % rows]
            for b in range(reached):
                onto[(tiles[s, 1] * apart - 1 + b) % columns] += own[s, a, b]


@compiled
def from_coarse(
    start: int, stop: int, sums: Real, values: Single, tiles: Index, slots: Index, spline: Single, out: Single
) -> None:
    """Set out <- out + values, interpolated to the points of each tile."""
    side, ratio = out.shape[1], RATIO
    apart = side // ratio
    reached, rows, columns = apart + 3, slots.shape[0] * apart, slots.shape[1] * apart
    around = np.empty((reached, ratio * reached), np.float32)
    line = np.empty(ratio * reached, np.float32)
    for s in range(start, stop):
        for a in range(reached):
            row = values[(tiles[s, 0] * apart - 1 + a) % rows]
            for b in range(reached):
                here = row[(tiles[s, 1] * apart - 1 + b) % columns]
                for j in range(ratio):
                    around[a, ratio * b + j] = here
        for i in range(side):
            k = i // ratio
            w, x, y, z = spline[0, i], spline[1, i], spline[2, i], spline[3, i]
            for j in range(ratio * reached):
                line[j] = w * around[k, j] + x * around[k + 1, j] + y * around[k + 2, j] + z * around[k + 3, j]
            onto = out[s * side + i]
            for j in range(side):
                onto[j] += (
                    spline[0, j] * line[j]
                    + spline[1, j] * line[j + ratio]
                    + spline[2, j] * line[j + 2 * ratio]
                    + spline[3, j] * line[j + 3 * ratio]
                )


@compiled
def on_contact(start: int, stop: int, sums: Real, mask: Mask, z: Field | None, shift: float, out: Real) -> None:
    """Set out <- z + shift, or shift without z, on the contact, 0 off it; ``start:stop`` are rows here and below."""
    side = out.shape[1]
    for i in range(start, stop):
        for j in range(side):
            out[i, j] = (shift if z is None else z[i, j] + shift) if mask[i, j] else 0.0


@compiled
def subtract_on_contact(start: int, stop: int, sums: Real, mask: Mask, beside: Single, out: Real) -> None:
    """Set out <- out - beside on the contact, 0 off it."""
    side = out.shape[1]
    for i in range(start, stop):
        for j in range(side):
            out[i, j] = out[i, j] - beside[i, j] if mask[i, j] else 0.0


@compiled
def onto_contact(start: int, stop: int, sums: Real, mask: Mask, field: Single, more: Single, out: Real) -> None:
    """Set out <- field + more on the contact, 0 off it; sums: of out."""
    side = out.shape[1]
    total = 0.0
    for i in range(start, stop):
        for j in range(side):
            out[i, j] = field[i, j] + more[i, j] if mask[i, j] else 0.0
            total += out[i, j]
    sums[0] = total


@compiled
def dot(start: int, stop: int, sums: Real, values: Real, field: Single) -> None:
    """sums: of values times a field."""
    side = values.shape[1]
    total = 0.0
    for i in range(start, stop):
        for j in range(side):
            total += values[i, j] * field[i, j]
    sums[0] = total


@compiled
def cut_below(start: int, stop: int, sums: Real, p: Real, t: Real, step: float, out: Real) -> None:
    """Set out <- what p - step t is below zero."""
    side = out.shape[1]
    for i in range(start, stop):
        for j in range(side):
            out[i, j] = max(step * t[i, j] - p[i, j], 0.0)


@compiled
def change(
    start: int,
    stop: int,
    sums: Real,
    p: Real,
    z: Real,
    offset: Real,
    new: Real,
    along: Single,
    cut: Single,
    step: float,
    factor: float,
    out: Real,
) -> None:
    """Gap under the pressure new, factor times p - step t cut at zero: out <- z and what that changes.

    ``along`` is G t, ``cut`` is G of what was cut, and G p is z - offset.  sums: of (new - p) (z + out)/2, by which the
    energy rises.
    """
    side = out.shape[1]
    total = 0.0
    for i in range(start, stop):
        for j in range(side):
            change = (factor - 1.0) * (z[i, j] - offset[i, j]) + factor * (cut[i, j] - step * along[i, j])
            total += (new[i, j] - p[i, j]) * (z[i, j] + 0.5 * change)
            out[i, j] = z[i, j] + change
    sums[0] = total
