"""The back end of NVIDIA GPUs, experimental: short kernels compiled by numba, transforms by cuFFT, fields that stay.

Its results were checked in numba's simulator, its speed on no GPU yet.  What the operations do for the solvers is said
in :mod:`continuum.solve.backend`.
"""

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.cuda.device import device_name, refuse_without_gpu, refuse_without_memory, visible_devices
from continuum.solve.cuda.faces import Face
from continuum.solve.cuda.levels import Level

CAUTION = (
    'device = "cuda" is experimental: its results were checked in a simulator, its speed on no GPU yet; compare a '
    "point with the CPU's before you rely on it"
)
"""What its user has to know."""
SMALLEST = 512
"""Grids of no more points along a side have no coarser one: a launch costs as much as a sweep over them."""
LEVELS = 3
"""Grids that a step uses, at most."""

LEVEL_FIELDS, FACE_FIELDS = 9.6, 10.2
"""Memory of a smooth solve and of one under a bound, in fields: 8.6 and 9.2 counted, and the work area of cuFFT."""

require = refuse_without_gpu
machine = device_name
devices = visible_devices


def level(grid: Grid, stiffness_q: Real, threads: int, coarser: int) -> Level:
    """The arrays of a smooth solve; threads of the CPU have no part in it."""
    refuse_without_memory(grid.shape[0] * grid.shape[1], LEVEL_FIELDS)
    return Level(grid, np.asarray(stiffness_q), coarser, SMALLEST)


def face(grid: Grid, stiffness_q: Real, threads: int) -> Face:
    """The arrays of a solve under a bound."""
    refuse_without_memory(grid.shape[0] * grid.shape[1], FACE_FIELDS)
    return Face(grid, np.asarray(stiffness_q), SMALLEST)
