"""Compiled sweeps that extend a field from the contact to what lies around it, and the adjoint of this.

A hat function stands on each node of a grid of some eight points' spacing.  f on the contact is summed onto the nodes
(R) and spread from them (P = Rᵀ); beside the contact the extension is the mean of f near by, P R f/(P R 1 + spread),
which fades out where there is little contact within reach.  Its adjoint adds to the contact what the free points hold.

Rows of points are summed onto the nodes along y first, in ``lines``, each row by itself, so that threads do not meet.
Arrays over nodes repeat the first row and column behind the last: the period.  ``node`` and ``part`` say, for each
column of points, behind which node it lies and how far, in parts of the spacing; ``edges`` where the columns of each
node begin; ``node_x`` and ``part_x`` the same of rows.
"""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import nodes
from continuum.solve.compiled.compiling import TILE, Index, Marks, Mask, compiled, inlined
from continuum.solve.compiled.points import untouched


class Nodes:
    """The nodes of a grid of points, and what is summed onto them."""

    def __init__(self, grid: Grid) -> None:
        nx, ny = nodes(grid)
        self.node_x, self.part_x, _ = _along(grid.shape[0], nx)
        self.node, self.part, self.edges = _along(grid.shape[1], ny)
        self.lines, self.counts = np.zeros((2, grid.shape[0], ny + 1))
        self.field, self.density = np.zeros((2, nx + 1, ny + 1))
        self.scale = nx * ny / grid.size

    def sum_lines(self, used: Mask, lines: Real, out: Real) -> None:
        """Sum the lines of the rows in use onto the nodes."""
        sum_lines(used, self.node_x, self.part_x, lines, self.scale, out)

    def reached(self) -> Mask:
        """The rows of points that have contact near by."""
        rows: Mask = np.any(self.density, axis=1)
        reached: Mask = rows[self.node_x] | (rows[self.node_x + 1] & (self.part_x > 0))
        return reached


def _along(points: int, count: int) -> tuple[Index, Real, Index]:
    """Along one direction: the node before each point, its distance in spacings, and where each node's points begin."""
    behind = np.arange(points) * count
    edges = -(-(np.arange(count + 1) * points) // count)
    return behind // points, (behind % points) / points, edges


@compiled
def collect_contact(
    start: int,
    stop: int,
    sums: Real,
    mask: Mask,
    z: Real,
    shift: float,
    ones: bool,
    out: Real,
    n: int,
    touched: Marks,
    node: Index,
    part: Real,
    lines: Real,
    counts: Real,
) -> None:
    """Set out <- z + shift, or 1, on the contact, 0 off it; lines and counts <- this, and 1, summed along the row."""
    for i in range(start, stop):
        if untouched(touched[i]):
            continue
        line, count = lines[i], counts[i]
        line[:] = 0.0
        count[:] = 0.0
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            for j in range(tile * TILE, min(tile * TILE + TILE, n)):
                if not mask[i, j]:
                    out[i, j] = 0.0
                    continue
                here = 1.0 if ones else z[i, j] + shift
                out[i, j] = here
                b, w = node[j], part[j]
                line[b] += (1.0 - w) * here
                line[b + 1] += w * here
                count[b] += 1.0 - w
                count[b + 1] += w


@compiled
def sum_lines(used: Mask, node_x: Index, part_x: Real, lines: Real, scale: float, out: Real) -> None:
    """Set out <- the lines of the rows in use, summed along x onto the nodes and scaled."""
    out[...] = 0.0
    for i in range(lines.shape[0]):
        if used[i]:
            a, w, line = node_x[i], part_x[i], lines[i]
            here, there = out[a], out[a + 1]
            for b in range(line.size):
                here[b] += (1.0 - w) * line[b]
                there[b] += w * line[b]
    nx, ny = out.shape[0] - 1, out.shape[1] - 1
    for b in range(ny + 1):
        out[0, b] += out[nx, b]
    for a in range(nx):
        out[a, 0] += out[a, ny]
        for b in range(ny):
            out[a, b] *= scale
        out[a, ny] = out[a, 0]
    for b in range(ny + 1):
        out[nx, b] = out[0, b]


@inlined
def _across(values: Real, a: int, w: float, line: Real) -> None:
    """Set line <- values over the nodes, between their rows a and a + 1."""
    here, there = values[a], values[a + 1]
    for b in range(line.size):
        line[b] = (1.0 - w) * here[b] + w * there[b]


@compiled
def extend(
    start: int,
    stop: int,
    sums: Real,
    buffer: Real,
    mask: Mask,
    out: Real,
    node_x: Index,
    part_x: Real,
    edges: Index,
    part: Real,
    field: Real,
    density: Real,
    lines: Real,
    counts: Real,
    spread: float,
) -> None:
    """Set buffer <- out on the contact, its extension elsewhere; over nodes, field is its sum, density that of 1.

    Of each row, counts <- the density at its nodes.
    """
    for i in range(start, stop):
        line, count = lines[i], counts[i]
        _across(field, node_x[i], part_x[i], line)
        _across(density, node_x[i], part_x[i], count)
        for b in range(edges.size - 1):
            first, last = edges[b], edges[b + 1]
            row = buffer[i - start, first:last]
            d, f = count[b], line[b]
            more, further = count[b + 1] - d, line[b + 1] - f
            if d == 0.0 and more == 0.0:
                row[:] = 0.0
                continue
            marks, own, parts = mask[i, first:last], out[i, first:last], part[first:last]
            for j in range(row.size):
                beside = (f + parts[j] * further) / (d + spread + parts[j] * more)
                row[j] = own[j] if marks[j] else beside


@compiled
def withdraw(
    start: int,
    stop: int,
    sums: Real,
    buffer: Real,
    mask: Mask,
    out: Real,
    edges: Index,
    part: Real,
    lines: Real,
    counts: Real,
    spread: float,
) -> None:
    """The adjoint, first half: out <- buffer on the contact, lines <- what the points beside it hold."""
    for i in range(start, stop):
        line, count = lines[i], counts[i]
        line[:] = 0.0
        for b in range(edges.size - 1):
            d = count[b]
            more = count[b + 1] - d
            if d == 0.0 and more == 0.0:
                continue
            first, last = edges[b], edges[b + 1]
            row, marks, own, parts = (
                buffer[i - start, first:last],
                mask[i, first:last],
                out[i, first:last],
                part[first:last],
            )
            whole = further = 0.0
            for j in range(row.size):
                here = row[j] / (d + spread + parts[j] * more)
                here = 0.0 if marks[j] else here
                whole += here
                further += parts[j] * here
                own[j] = row[j] if marks[j] else own[j]
            line[b] += whole - further
            line[b + 1] += further


@compiled
def give_back(
    start: int,
    stop: int,
    sums: Real,
    mask: Mask,
    out: Real,
    n: int,
    touched: Marks,
    node_x: Index,
    part_x: Real,
    node: Index,
    part: Real,
    field: Real,
    lines: Real,
) -> None:
    """The second half: out <- out + what the nodes give to the contact; sums: of out."""
    total = 0.0
    for i in range(start, stop):
        if untouched(touched[i]):
            continue
        line = lines[i]
        _across(field, node_x[i], part_x[i], line)
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            for j in range(tile * TILE, min(tile * TILE + TILE, n)):
                if mask[i, j]:
                    b = node[j]
                    out[i, j] += line[b] + part[j] * (line[b + 1] - line[b])
                    total += out[i, j]
    sums[0] = total
