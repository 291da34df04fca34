"""The engine of NVIDIA GPUs for the bound-constrained solver: what it asks of whole fields at once."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import SPREAD, most_work, nodes
from continuum.solve.cuda.device import Array, empty
from continuum.solve.cuda.engine import KERNELS, CudaEngine


class CudaBoundEngine(CudaEngine):
    """What :class:`continuum.solve.backend.BoundEngine` asks for.

    Parameters
    ----------
    grid, K, finer : as for the engine of the smooth solver.
    """

    def __init__(self, grid: Grid, K: Real, finer: CudaBoundEngine | None = None) -> None:
        super().__init__(grid, K, None, finer)
        self._stiffness_q = np.where(np.isfinite(K), K, 0.0)
        self.field_on_nodes, self.density = (empty(*nodes(grid)) for _ in range(2))
        self._own |= {"values_q": self.K, "factor": 1.0, "most": np.inf, "spread": SPREAD, "density": self.density}
        self._mean_stiffness = 0.0

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        super().set_mean_stiffness(stiffness, held=held)
        self._mean_stiffness = stiffness

    def set_largest_pressure(self, most: float) -> None:
        self._own["most"] = most

    def tiles(self, p: Array, z: Array, below: float) -> None:
        """None: a device keeps to the whole grid."""

    def take(self, tiles: object, values: Array, field: Array) -> None:
        """Nothing: there are no tiles."""

    # --- arrays --------------------------------------------------------------------------------------------

    def field(self) -> Array:
        return self.rows()

    def mask(self) -> Array:
        return self.rows(np.uint8)

    def clear_mask(self, mask: Array) -> None:
        self.sweep("mark", mask=mask, number=0)

    def scale(self, field: Array, factor: float) -> None:
        self.sweep("scale", values=field, factor=factor)

    def total(self, field: Array) -> float:
        return float(self.sweep("total", values=field)[0])

    def mean(self, field: Array) -> float:
        return self.total(field) / self.size

    def coarsen(self, fine: Array, below: CudaBoundEngine, coarse: Array) -> None:
        below.sweep("every_second", fine=fine, z=coarse)
        below.shift(coarse, self.mean(fine) - below.mean(coarse))

    def load(self, field: Array) -> None:
        self.into("copy", values=field)

    def stiffen(self, mask: Array, out: Array, least: float, z: Array | None = None, shift: float = 0.0) -> float:
        field = {"mask": mask, "field": self.field_on_nodes}
        given = field | {"z": out if z is None else z, "shift": shift, "ones": int(z is None)}
        self.sweep("gather", **given)
        self.into("extend", **given)
        KERNELS["put"](1, self.K, least)
        self.spectral("multiply", forward=True)
        KERNELS["put"](1, self.K, self._mean_stiffness)
        self.transforms += 1
        self.transform.inverse(self.w)
        self.sweep("withdraw", **field)
        return float(self.sweep("give_back", out=out, **field)[0])

    def comply(self, *, inverse: bool = False) -> float:
        del inverse  # is made where the field is used
        self.spectral(forward=True)
        return float(self.sweep("compliance")[0])

    # --- what is asked at once -----------------------------------------------------------------------------

    def guess(
        self, p: Array, start: Array, offset: Array, traction: Array, pressure: float | None, wide: float, least: float
    ) -> None:
        self.into("displace", z=start, offset=offset, lift=0.0)
        self.transform.forward(self.w)
        self.sweep("multiply", values_q=self.K, factor=-1.0)
        self.transforms += 1
        self.transform.inverse(self.w)
        if pressure is None:
            total, count = self.sweep("wide", z=start, mean=wide)[:2]
            pressure = -float(total / count)
        stiffest = max(float(self._stiffness_q.ravel()[1:].max()), self._mean_stiffness)
        self.sweep("guess", p=p, z=start, more=pressure, stiffest=stiffest, least=least)

    def misses(self, p: Array, z: Array, level: float, error: Array, spare: tuple[Array, Array]) -> tuple[float, float]:
        largest = float(self.into("misses", largest=0, p=p, z=z, shift=level)[0])
        self.transform.forward(self.w)
        return float(np.sqrt(self.sweep("square")[0])), largest

    def duality_gap(self, p: Array, z: Array, spare: tuple[Array, Array]) -> tuple[float, float]:
        pz, total, depth = self.sweep("certificate", largest=2, p=p, z=z)[:3]
        K = self._stiffness_q.copy()
        K[0, 0] = np.inf
        softness = float(np.sqrt(np.sum(self.grid.mode_weights / K**2)))
        most, saved = self._own["most"], float(pz + total * depth) / self.size
        if np.isfinite(most):
            gap = self.download(z)
            saved -= most_work(gap - gap.min(), float(total) / self.size, most)
        return saved, 2 * float(total) / self.size * softness
