"""The back end of NVIDIA GPUs, experimental: short kernels compiled by numba, transforms by cuFFT, fields that stay.

Its results were checked in numba's simulator, its speed on no GPU yet.  What the operations do for the solvers is said
in :mod:`continuum.solve.backend`.
"""

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.cuda.device import device_name, refuse_without_gpu
from continuum.solve.cuda.faces import Face
from continuum.solve.cuda.levels import Level

__all__ = ["CAUTION", "LEVELS", "SMALLEST", "face", "level", "machine", "require"]

CAUTION = (
    'device = "cuda" is experimental: its results were checked in a simulator, its speed on no GPU yet; compare a '
    "point with the CPU's before you rely on it"
)
"""What its user has to know."""
SMALLEST = 512
"""Grids of no more points along a side have no coarser one: a launch costs as much as a sweep over them."""
LEVELS = 3
"""Grids that a step uses, at most."""

require = refuse_without_gpu
machine = device_name


def level(grid: Grid, stiffness_q: Real, threads: int, coarser: int) -> Level:
    """The arrays of a smooth solve; threads of the CPU have no part in it."""
    return Level(grid, np.asarray(stiffness_q), coarser, SMALLEST)


def face(grid: Grid, stiffness_q: Real, threads: int) -> Face:
    """The arrays of a solve under a bound."""
    return Face(grid, np.asarray(stiffness_q), SMALLEST)
