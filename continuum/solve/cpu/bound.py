"""The engine of processor cores for the bound-constrained solver: whole fields, and what it asks of them at once."""

from __future__ import annotations

import time
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from continuum.model.fourier import Real, rows_forward, rows_inverse
from continuum.model.grid import Grid
from continuum.solve.backend import SPREAD, most_work
from continuum.solve.cpu.compiled import TILE, Marks, Mask
from continuum.solve.cpu.extending import Nodes
from continuum.solve.cpu.near_field import SIDE
from continuum.solve.cpu.tiles import MOST, CpuTileEngine, TiledEngine


class CpuBoundEngine(TiledEngine):
    """What :class:`continuum.solve.backend.BoundEngine` asks for.

    A field that is transformed lies in the array ``out`` of its kernel.  Pressures, and all that vanishes off the
    contact, are looked at in tiles that :mod:`continuum.solve.cpu.pressing` has marked, and transformed in rows that
    have such a tile.

    Parameters
    ----------
    grid, K, threads : as for the engine of the smooth solver; what is not finite counts as zero.
    """

    def __init__(self, grid: Grid, K: Real, threads: int) -> None:
        super().__init__(grid, K, threads)
        K[~np.isfinite(K)] = 0.0
        self.G = np.divide(1.0, K, out=np.zeros_like(K), where=K > 0)
        self.touched: Marks = np.full(self.near.shape, 2, dtype=np.uint8)
        self.lowest, self.worst = np.zeros(self.near.shape), np.zeros(grid.shape[0])
        self._own |= {"G": self.G, "touched": self.touched, "lowest": self.lowest, "worst": self.worst}
        self.nodes = Nodes(grid)
        self._own |= vars(self.nodes) | {"spread": SPREAD}
        self.set_largest_pressure(np.inf)

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        super().set_mean_stiffness(stiffness, held=held)
        self.G[0, 0] = 1.0 / stiffness if stiffness > 0 else 0.0

    def set_largest_pressure(self, most: float) -> None:
        self.most = most
        self._own["most"] = most

    # --- arrays --------------------------------------------------------------------------------------------

    def field(self) -> Real:
        return self.rows()

    def mask(self) -> Mask:
        return np.zeros(self.grid.shape, dtype=np.bool_)

    def clear_mask(self, mask: Mask) -> None:
        mask[...] = False
        self._touch_all()

    def fill(self, values: Real, number: float) -> None:
        values[...] = number
        self._touch_all()

    def _touch_all(self) -> None:
        """Take every tile as one that may have been touched."""
        self.touched[...] = 2

    def download(self, field: Real) -> Real:
        # The rows are moved together in their own memory.
        flat = field.ravel()
        rows, n = self.grid.shape
        for i in range(rows):
            flat[i * n : (i + 1) * n] = field[i, :n]
        return flat[: rows * n].reshape(rows, n)

    def scale(self, field: Real, factor: float) -> None:
        self.sweep("stretch", p=field, factor=factor, out=field, most=np.inf)

    def total(self, field: Real) -> float:
        return float(self.sweep("total", values=field)[0])

    def mean(self, field: Real) -> float:
        return self.grid.mean(field)

    def coarsen(self, fine: Real, below: CpuBoundEngine, coarse: Real) -> None:
        every = fine[::2, ::2]
        coarse[...] = every + (self.mean(fine) - below.mean(every))

    # --- transforms of whole fields ------------------------------------------------------------------------

    def load(self, field: Real) -> None:
        self.transforms += 1
        self.over(lambda a, b, _: self._forward(field, a, b, sparse=True), self.row_edges)

    def into(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        kernel, arguments = self._bound(name, 3, given)

        def task(first: int, last: int, sums: Real) -> float:
            kernel(first, last, sums, *arguments)
            return self._forward(given["out"], first, last, sparse=name == "turn_on_contact")

        return self.over(task, self.row_edges)

    def out_of(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        kernel, arguments = self._bound(name, 3, given)
        out = given["out"][:, : self.n]

        def task(first: int, last: int, sums: Real) -> float:
            began = time.perf_counter()
            rows_inverse(self.work_q[first:last], out[first:last])
            seconds = time.perf_counter() - began
            kernel(first, last, sums, *arguments)
            return seconds

        return self.over(task, self.row_edges)

    def _forward(self, field: Real, first: int, last: int, *, sparse: bool) -> float:
        """Transform a block of rows; those without a touched tile are zero.  Returns the seconds it took."""
        began = time.perf_counter()
        end = first
        for a, b in runs(np.any(self.touched[first:last], axis=1), first) if sparse else [(first, last)]:
            self.work_q[end:a] = 0.0
            rows_forward(field[a:b, : self.n], self.work_q[a:b])
            end = b
        self.work_q[end:last] = 0.0
        return time.perf_counter() - began

    def stiffen(self, mask: Mask, out: Real, least: float, z: Real | None = None, shift: float = 0.0) -> float:
        self.transforms += 2
        nodes, points = self.nodes, {"mask": mask, "out": out}
        self.sweep("collect", z=out if z is None else z, shift=shift, ones=z is None, **points)
        used: Mask = np.any(self.touched, axis=1)
        nodes.sum_lines(used, nodes.lines, nodes.field)
        nodes.sum_lines(used, nodes.counts, nodes.density)
        reached = nodes.reached()
        extend, withdraw = (self._bound(name, 4, points) for name in ("extend", "withdraw"))

        def forward(first: int, last: int, sums: Real) -> float:
            buffer, end, seconds = self._buffer(last - first), first, 0.0
            for a, b in runs(reached[first:last], first):
                self.work_q[end:a] = 0.0
                extend[0](a, b, sums, buffer, *extend[1])
                began = time.perf_counter()
                rows_forward(buffer[: b - a, : self.n], self.work_q[a:b])
                end, seconds = b, seconds + time.perf_counter() - began
            self.work_q[end:last] = 0.0
            return seconds

        def inverse(first: int, last: int, sums: Real) -> float:
            buffer, seconds = self._buffer(last - first), 0.0
            for a, b in runs(reached[first:last], first):
                began = time.perf_counter()
                rows_inverse(self.work_q[a:b], buffer[: b - a, : self.n])
                seconds += time.perf_counter() - began
                withdraw[0](a, b, sums, buffer, *withdraw[1])
            return seconds

        self.over(forward, self.row_edges)
        self.spectral("stiffness", forward=True, inverse=True, least=least)
        self.over(inverse, self.row_edges)
        nodes.sum_lines(reached, nodes.lines, nodes.field)
        return float(self.sweep("give_back", **points)[0])

    def comply(self, *, inverse: bool = False) -> float:
        return float(self.spectral("compliance", forward=True, inverse=inverse)[0])

    # --- tiles ---------------------------------------------------------------------------------------------

    def tiles(self, p: Real, z: Real, below: float) -> CpuTileEngine | None:
        split = self.split() if np.isinf(self.most) else None
        if split is None or not split.even:
            return None
        nx, ny = self.grid.shape
        marked: Mask = np.zeros((nx // SIDE, ny // SIDE), dtype=np.bool_)
        self.sweep("mark_tiles", p=p, z=z, below=below, out=marked)
        if not self.pays(marked, MOST):
            return None
        split.G_far[0, 0] = self.G[0, 0]
        return CpuTileEngine(self, split, marked)

    def take(self, tiles: CpuTileEngine, values: Real, field: Real) -> None:
        tiles.scatter(values, field)
        self.touched[...] = 0
        for a, b in tiles.places * SIDE:
            self.touched[a : a + SIDE, b // TILE] = 2

    # --- what is asked at once -----------------------------------------------------------------------------

    def guess(
        self, p: Real, start: Real, offset: Real, traction: Real, pressure: float | None, wide: float, least: float
    ) -> None:
        p, start, traction = (each[:, : self.n] for each in (p, start, traction))
        np.subtract(offset, start, out=traction)
        self.forward(traction)
        self.work_q *= -self.K
        self.inverse(traction)
        self.transforms += 2
        if pressure is None:
            traction -= traction[start >= wide].mean()
        else:
            traction += pressure
        stiffest = self.K.max()
        for a, b in pairwise(self.row_edges):
            here = traction[a:b]
            p[a:b] = np.where(here > stiffest * (start[a:b] - least), np.clip(here, 0.0, self.most), 0.0)
        self._touch_all()

    def misses(self, p: Real, z: Real, level: float, error: Real, spare: tuple[Real, Real]) -> tuple[float, float]:
        self.into("misses", p=p, z=z, shift=level, out=error)
        return float(np.sqrt(self.spectral("missed", forward=True)[0])), float(self.worst.max())

    def duality_gap(self, p: Real, z: Real, spare: tuple[Real, Real]) -> tuple[float, float]:
        least = float(self.lowest.min())  # of the z that was found last, this one
        work, total = self.sweep("above", p=p, z=z, least=least)[:2] / self.size
        if np.isfinite(self.most):
            work -= most_work(z[:, : self.n] - least, total, self.most)
        return float(work), 2 * float(total) * self.softness

    @cached_property
    def softness(self) -> float:
        """Root of the sum of 1/K² over all modes but the mean."""
        weights = self.grid.mode_weights[0]
        rest = float(np.sum(self.G[1:, 0] ** 2) * weights[0])
        return float(np.sqrt(rest + np.einsum("ij,ij,j->", self.G[:, 1:], self.G[:, 1:], weights[1:])))


def runs(used: Mask, first: int) -> list[tuple[int, int]]:
    """Where runs of rows in use begin and end, the first row being of this number."""
    marks = np.zeros(used.size + 2, dtype=np.bool_)
    marks[1:-1] = used
    edges = (first + np.flatnonzero(marks[1:] != marks[:-1])).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
