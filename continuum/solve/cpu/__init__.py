"""The back end of processor cores: arrays with padded rows, blocks that stay in a cache, threads that sleep.

Each class here is one grid of a solve and owns its arrays; the sweeps over them are compiled.  What they do for the
solvers, operation by operation, is said in :mod:`continuum.solve.backend`.
"""

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.cpu.faces import Face
from continuum.solve.cpu.levels import Level

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


def level(grid: Grid, stiffness_q: Real, threads: int, coarser: int) -> Level:
    """The arrays of a smooth solve."""
    return Level(grid, np.array(stiffness_q, order="C"), threads, coarser, SMALLEST)


def face(grid: Grid, stiffness_q: Real, threads: int) -> Face:
    """The arrays of a solve under a bound."""
    return Face(grid, np.array(stiffness_q, order="C"), threads, SMALLEST)
