"""The back end of NVIDIA GPUs, experimental: short kernels compiled by numba, transforms by cuFFT, fields that stay.

Its results were checked in numba's simulator, its speed on no GPU yet.  What the operations do for the solvers is said
in :mod:`continuum.solve.backend`.
"""

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.cuda.bound import CudaBoundEngine
from continuum.solve.cuda.device import device_name, refuse_without_gpu, refuse_without_memory, visible_devices
from continuum.solve.cuda.engine import CudaEngine

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
devices = visible_devices


def engine(grid: Grid, K: Real, threads: int, below: Grid | None, finer: CudaEngine | None) -> CudaEngine:
    """The arrays of a grid; threads of the CPU have no part in it."""
    return CudaEngine(grid, K, below, finer)


def bound_engine(grid: Grid, K: Real, threads: int, finer: CudaBoundEngine | None) -> CudaBoundEngine:
    """The same for the bound-constrained solver."""
    return CudaBoundEngine(grid, K, finer)


def reserve(points: int, fields: float) -> None:
    """Refuse a grid that does not fit, with the work area of cuFFT, a field."""
    refuse_without_memory(points, fields + 1)
