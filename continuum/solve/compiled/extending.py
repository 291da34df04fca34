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

from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import nodes
from continuum.solve.compiled.compiling import TILE, Index, Mask, compiled, inlined
from continuum.solve.compiled.points import untouched
from continuum.solve.compiled.pressing import ContactPoints


class Nodes(NamedTuple):
    """The nodes of a grid of points, and what is summed onto them."""

    node_x: Index
    part_x: Real
    node: Index
    part: Real
    edges: Index
    lines: Real
    """Sum of a field over each row of points; in ``counts`` that of ones, or their density at its nodes."""
    counts: Real
    field: Real
    """The sum of a field over the nodes, and in ``density`` that of ones."""
    density: Real
    scale: float

    @classmethod
    def of(cls, grid: Grid) -> Nodes:
        """Nodes onto which nothing was summed."""
        nx, ny = nodes(grid)
        lines, counts = np.zeros((2, grid.shape[0], ny + 1))
        field, density = np.zeros((2, nx + 1, ny + 1))
        (node_x, part_x, _), along_y = _along(grid.shape[0], nx), _along(grid.shape[1], ny)
        return cls(node_x, part_x, *along_y, lines, counts, field, density, nx * ny / grid.size)

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
    z: Real | None,
    shift: float,
    out: Real,
    contact: ContactPoints,
    nodes: Nodes,
) -> None:
    """Set out <- z + shift, or shift without z, on the contact, 0 off it; lines <- this, summed along the row, and
    counts <- 1.
    """
    mask, _, n, touched = contact
    node, part, lines, counts = nodes.node, nodes.part, nodes.lines, nodes.counts
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
                here = shift if z is None else z[i, j] + shift
                out[i, j] = here
                b, w = node[j], part[j]
                line[b] += (1.0 - w) * here
                line[b + 1] += w * here
                count[b] += 1.0 - w
                count[b + 1] += w


@compiled
def sum_lines(used: Mask, nodes: Nodes, lines: Real, out: Real) -> None:
    """Set out <- the lines of the rows in use, summed along x onto the nodes and scaled."""
    node_x, part_x, scale = nodes.node_x, nodes.part_x, nodes.scale
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
def extend(start: int, stop: int, sums: Real, buffer: Real, mask: Mask, out: Real, nodes: Nodes, spread: float) -> None:
    """Set buffer <- out on the contact, its extension elsewhere; over nodes, field is its sum, density that of 1.

    Of each row, counts <- the density at its nodes.
    """
    edges, part = nodes.edges, nodes.part
    for i in range(start, stop):
        line, count = nodes.lines[i], nodes.counts[i]
        _across(nodes.field, nodes.node_x[i], nodes.part_x[i], line)
        _across(nodes.density, nodes.node_x[i], nodes.part_x[i], count)
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
    start: int, stop: int, sums: Real, buffer: Real, mask: Mask, out: Real, nodes: Nodes, spread: float
) -> None:
    """The adjoint, first half: out <- buffer on the contact, lines <- what the points beside it hold."""
    edges, part = nodes.edges, nodes.part
    for i in range(start, stop):
        line, count = nodes.lines[i], nodes.counts[i]
        line[:] = 0.0
        for b in range(edges.size - 1):
            d = count[b]
            more = count[b + 1] - d
            if d == 0.0 and more == 0.0:
                continue
            first, last = edges[b], edges[b + 1]
            row, parts = buffer[i - start, first:last], part[first:last]
            marks, own = mask[i, first:last], out[i, first:last]
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
def give_back(start: int, stop: int, sums: Real, out: Real, contact: ContactPoints, nodes: Nodes) -> None:
    """The second half: out <- out + what the nodes give to the contact; sums: of out."""
    mask, _, n, touched = contact
    node, part = nodes.node, nodes.part
    total = 0.0
    for i in range(start, stop):
        if untouched(touched[i]):
            continue
        line = nodes.lines[i]
        _across(nodes.field, nodes.node_x[i], nodes.part_x[i], line)
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            for j in range(tile * TILE, min(tile * TILE + TILE, n)):
                if mask[i, j]:
                    b = node[j]
                    out[i, j] += line[b] + part[j] * (line[b + 1] - line[b])
                    total += out[i, j]
    sums[0] = total
