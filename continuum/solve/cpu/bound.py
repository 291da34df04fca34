"""The engine of processor cores for the bound-constrained solver: whole fields, and what it asks of them at once."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from continuum.model.fourier import Real, padded, rows_forward, rows_inverse
from continuum.model.grid import Grid
from continuum.solve.backend import most_work, reused
from continuum.solve.cpu.compiled import Mask
from continuum.solve.cpu.engine import KERNELS, CpuEngine, memory, whole_rows


class CpuBoundEngine(CpuEngine):
    """What :class:`continuum.solve.backend.BoundEngine` asks for.

    A field that is transformed lies in the array ``out`` of its kernel.

    Parameters
    ----------
    grid, K, threads : as for the engine of the smooth solver; what is not finite counts as zero.
    """

    def __init__(self, grid: Grid, K: Real, threads: int) -> None:
        super().__init__(grid, K, threads)
        K[~np.isfinite(K)] = 0.0
        self.G = np.divide(1.0, K, out=np.zeros_like(K), where=K > 0)
        self.single = -1 if grid.shape[1] % 2 else grid.shape_q[1] - 1
        self._own["values_q"] = self.windowed_q = np.empty(grid.shape_q)
        self.set_largest_pressure(np.inf)

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        super().set_mean_stiffness(stiffness, held=held)
        self.G[0, 0] = 1.0 / stiffness if stiffness > 0 else 0.0

    def set_largest_pressure(self, most: float) -> None:
        self.most = most
        self._own["most"] = most

    # --- arrays --------------------------------------------------------------------------------------------

    def field(self) -> Real:
        return padded(self.grid.shape)

    def mask(self) -> Mask:
        return np.zeros(self.grid.shape, dtype=np.bool_)

    def clear_mask(self, mask: Mask) -> None:
        mask[...] = False

    def download(self, field: Real) -> Real:
        # The rows are moved together in their own memory.
        flat = whole_rows(field).ravel()
        rows, n = self.grid.shape
        for i in range(rows):
            flat[i * n : (i + 1) * n] = field[i]
        return flat[: rows * n].reshape(rows, n)

    def scale(self, field: Real, factor: float) -> None:
        field *= factor

    def total(self, field: Real) -> float:
        return float(field.sum())

    def mean(self, field: Real) -> float:
        return self.grid.mean(field)

    def coarsen(self, fine: Real, below: CpuBoundEngine, coarse: Real) -> None:
        every = fine[::2, ::2]
        coarse[...] = every + (self.mean(fine) - below.mean(every))

    # --- transforms of whole fields ------------------------------------------------------------------------

    def load(self, field: Real) -> None:
        self.transforms += 1
        self._transform(lambda a, b: rows_forward(field[a:b], self.work_q[a:b]), self.row_edges)

    def into(self, name: str, **given: Any) -> Real:
        sums = self.sweep(name, **given)
        self.load(given["out"])
        return sums

    def out_of(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        out = given["out"]
        self._transform(lambda a, b: rows_inverse(self.work_q[a:b], out[a:b]), self.row_edges)
        return self.sweep(name, **given)

    def comply(self) -> float:
        spectrum = self.w[:, : 2 * self.G.shape[1]]
        return float(self.rows_of(KERNELS["compliance"][0], spectrum, self.G, self.single)[0])

    # --- what is asked at once -----------------------------------------------------------------------------

    def guess(
        self, p: Real, start: Real, offset: Real, traction: Real, pressure: float | None, wide: float, least: float
    ) -> None:
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

    def cut_kernel(self, window: float, kernel: Real) -> None:
        self.work_q[...] = self.K
        self.work_q[0, 0] = 0.0  # the mean mode has its own way, and a stiff one would smear over the longest waves
        self.inverse(kernel)
        for axis, n in enumerate(self.grid.shape):
            distance = np.minimum(np.arange(n), n - np.arange(n))
            weights = np.maximum(0.0, 1 - distance / (window * n))
            kernel *= weights[:, None] if axis == 0 else weights[None, :]
        self.forward(kernel)
        self.transforms += 2
        np.maximum(self.work_q.real, 0.0, out=self.windowed_q)

    def misses(self, p: Real, z: Real, level: float, error: Real, spare: tuple[Real, Real]) -> tuple[float, float]:
        self.into("misses", p=p, z=z, shift=level, out=error)
        self.spectral(forward=True)
        self.work_q *= self.K
        square = float(self.power(*(reused(memory(each), *self.grid.shape_q) for each in spare)).sum())
        return float(np.sqrt(square)), abs(float(np.maximum(error.max(), -error.min())))

    def duality_gap(self, p: Real, z: Real, spare: tuple[Real, Real]) -> tuple[float, float]:
        product, softness = spare[0], reused(memory(spare[1]), *self.grid.shape_q)
        np.subtract(z, z.min(), out=product)
        product *= p
        if np.isfinite(self.most):
            product -= most_work(z - z.min(), self.mean(p), self.most)
        np.multiply(self.G, self.G, out=softness)
        softness *= self.grid.mode_weights
        softness[0, 0] = 0.0
        return self.mean(product), 2 * self.mean(p) * float(np.sqrt(softness.sum()))
