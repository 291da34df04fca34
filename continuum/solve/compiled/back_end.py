"""The back end of processor cores: arrays with padded rows, blocks that stay in a cache, threads that sleep."""

from functools import cache

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import BackEnd
from continuum.solve.compiled.bound_grid import CompiledBoundGrid
from continuum.solve.compiled.corrections import TiledSmoothGrid


class CompiledBackEnd(BackEnd):
    """Processor cores: there are always some, which processes share."""

    PRECISION: type = np.float32
    """Precision of linear problems: a step of a coarser grid is a direction only."""

    def smooth_grid(self, grid: Grid, K: Real, threads: int, coarser: int, *, sampled: bool) -> TiledSmoothGrid:
        return TiledSmoothGrid(grid, K, threads, self.SMALLEST, self.PRECISION, coarser, sampled=sampled)

    def bound_grid(self, grid: Grid, K: Real, threads: int) -> CompiledBoundGrid:
        return CompiledBoundGrid(grid, K, threads, self.SMALLEST)


BACK_END = cache(CompiledBackEnd)
"""The back end of the device, one for all who ask."""
