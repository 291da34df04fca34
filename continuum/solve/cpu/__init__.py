"""The back end of processor cores: arrays with padded rows, blocks that stay in a cache, threads that sleep.

Each class here is one grid of a solve and owns its arrays; the sweeps over them are compiled.  What they do for the
solvers, operation by operation, is said in :mod:`continuum.solve.backend`.
"""

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.cpu.bound import CpuBoundEngine
from continuum.solve.cpu.engine import CpuEngine

SMALLEST = 128
"""Grids of no more points along a side have no coarser one: calls, not points, would take the time."""
LEVELS = 3
"""Grids that a step uses, at most."""
CAUTION = ""
"""Nothing to be told."""


def require() -> None:
    """There is always a processor."""


def machine() -> str:
    """All of them find the same."""
    return ""


def devices() -> tuple[str, ...]:
    """Processes share the cores."""
    return ()


def engine(grid: Grid, K: Real, threads: int, below: Grid | None, finer: CpuEngine | None) -> CpuEngine:
    """The arrays of a grid; each has its own."""
    return CpuEngine(grid, np.array(K, order="C"), threads, below)


def reserve(points: int, fields: float) -> None:
    """The system says when memory ends."""


def bound_engine(grid: Grid, K: Real, threads: int, finer: CpuBoundEngine | None) -> CpuBoundEngine:
    """The same for the bound-constrained solver."""
    return CpuBoundEngine(grid, np.array(K, order="C"), threads)
