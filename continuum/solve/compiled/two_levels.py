"""Compiled sweeps of the preconditioner under a bound: neighbours on the contact, and means on nodes.

A field f on the contact is split into its local means and what deviates from them.  A hat function stands on each node
of a grid of some eight points' spacing; f is summed onto the nodes (R), c = R f/(R 1 + spread) are its means, and
d = f - P c, on the contact, the deviations (P = Rᵀ spreads).  K acts on d by its nearest neighbours alone, since what
has no mean near by does not reach far, and on c as on a grid of these nodes::

    M = (1 - P W)ᵀ K_near (1 - P W) + Wᵀ K_nodes W,    W f = c

Rows of points are summed onto the nodes along y first, in ``lines``, each row by itself, so that threads do not meet.
Arrays over nodes repeat the first row and column behind the last: the period.  ``node`` and ``part`` say, for each
column of points, behind which node it lies and how far, in parts of the spacing; ``node_x`` and ``part_x`` the same of
rows.
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
    lines: Real
    """Sum of a field over each row of points; in ``counts`` that of ones."""
    counts: Real
    field: Real
    """The sum of a field over the nodes, or what they spread; in ``density`` the sum of ones."""
    density: Real
    scale: float

    @classmethod
    def of(cls, grid: Grid) -> Nodes:
        """Nodes onto which nothing was summed."""
        nx, ny = nodes(grid)
        lines, counts = np.zeros((2, grid.shape[0], ny + 1))
        field, density = np.zeros((2, nx + 1, ny + 1))
        along = *_along(grid.shape[0], nx), *_along(grid.shape[1], ny)
        return cls(*along, lines, counts, field, density, nx * ny / grid.size)


def _along(points: int, count: int) -> tuple[Index, Real]:
    """Along one direction: the node before each point, and its distance in spacings."""
    behind = np.arange(points) * count
    return behind // points, (behind % points) / points


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
def subtract_means(start: int, stop: int, sums: Real, out: Real, contact: ContactPoints, nodes: Nodes) -> None:
    """Set out <- out - what the nodes spread, on the contact."""
    mask, _, n, touched = contact
    node, part = nodes.node, nodes.part
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
                    out[i, j] -= line[b] + part[j] * (line[b + 1] - line[b])


@compiled
def sum_neighbours(
    start: int, stop: int, sums: Real, values: Real, kernel: Real, out: Real, contact: ContactPoints, nodes: Nodes
) -> None:
    """Set out <- the kernel's sum of values, zero off the contact, on the contact; lines <- out, summed."""
    mask, _, n, touched = contact
    node, part, lines, rows = nodes.node, nodes.part, nodes.lines, values.shape[0]
    k02, k42 = kernel[0, 2], kernel[4, 2]
    k11, k12, k13, k31, k32, k33 = kernel[1, 1], kernel[1, 2], kernel[1, 3], kernel[3, 1], kernel[3, 2], kernel[3, 3]
    k20, k21, k22, k23, k24 = kernel[2, 0], kernel[2, 1], kernel[2, 2], kernel[2, 3], kernel[2, 4]
    for i in range(start, stop):
        if untouched(touched[i]):
            continue
        line, result, marks = lines[i], out[i], mask[i]
        line[:] = 0.0
        p, q, r = values[(i - 2) % rows], values[(i - 1) % rows], values[i]
        s, t = values[(i + 1) % rows], values[(i + 2) % rows]
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            for c in range(tile * TILE, min(tile * TILE + TILE, n)):
                if not marks[c]:
                    continue
                a, b, d, e = c - 2, c - 1, c + 1, c + 2
                if a < 0 or e >= n:  # over the edge of the period
                    a, b, d, e = a % n, b % n, d % n, e % n
                here = (
                    k02 * p[c]
                    + k11 * q[b] + k12 * q[c] + k13 * q[d]
                    + k20 * r[a] + k21 * r[b] + k22 * r[c] + k23 * r[d] + k24 * r[e]
                    + k31 * s[b] + k32 * s[c] + k33 * s[d]
                    + k42 * t[c]
                )  # fmt: skip
                result[c] = here
                f, w = node[c], part[c]
                line[f] += (1.0 - w) * here
                line[f + 1] += w * here


@compiled
def add_nodes(start: int, stop: int, sums: Real, near: Real, out: Real, contact: ContactPoints, nodes: Nodes) -> None:
    """Set out <- near + what the nodes spread, on the contact; sums: of out."""
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
                    out[i, j] = near[i, j] + line[b] + part[j] * (line[b + 1] - line[b])
                    total += out[i, j]
    sums[0] = total
