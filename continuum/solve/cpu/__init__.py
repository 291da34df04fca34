"""The back end of processor cores: arrays with padded rows, blocks that stay in a cache, threads that sleep."""

from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import BackEnd
from continuum.solve.bound_grid import BoundGrid
from continuum.solve.cpu.bound import CpuBoundEngine
from continuum.solve.cpu.linear import CpuLinearEngine
from continuum.solve.cpu.tiles import TiledEngine
from continuum.solve.smooth_grid import SmoothGrid


class CpuBackEnd(BackEnd):
    """Processor cores: there are always some, which processes share."""

    PRECISION: type = np.float32
    """Precision of linear problems: a step of a coarser grid is a direction only."""
    SMALLEST = 128
    """On smaller grids calls, not points, would take the time."""

    def smooth_grid(self, grid: Grid, K: Real, threads: int, coarser: int, *, sampled: bool) -> SmoothGrid:
        return SmoothGrid(self, grid, K, threads, coarser, sampled=sampled)

    def bound_grid(self, grid: Grid, K: Real, threads: int) -> BoundGrid:
        return BoundGrid(self, grid, K, threads)

    def engine(self, grid: Grid, K: Real, threads: int, below: Grid | None, finer: Any) -> TiledEngine:
        return TiledEngine(grid, np.array(K, order="C"), threads, below)

    def linear_engine(self, grid: Grid, K: Real, threads: int, below: Any, finer: Any) -> CpuLinearEngine:
        return CpuLinearEngine(grid, np.array(K, dtype=self.PRECISION, order="C"), threads, below)

    def bound_engine(self, grid: Grid, K: Real, threads: int, finer: Any) -> CpuBoundEngine:
        return CpuBoundEngine(grid, np.array(K, order="C"), threads)


BACK_END = CpuBackEnd()


def back_end(device: str) -> CpuBackEnd:
    """The back end of processor cores, one for all who ask."""
    return BACK_END
