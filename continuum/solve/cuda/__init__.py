"""The back end of NVIDIA GPUs, experimental: short kernels compiled by numba, transforms by cuFFT, fields that stay.

Its results were checked in numba's simulator, its speed on no GPU yet.
"""

from typing import Any

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import BackEnd
from continuum.solve.cuda.bound import CudaBoundEngine
from continuum.solve.cuda.device import device_name, refuse_without_gpu, refuse_without_memory, visible_devices
from continuum.solve.cuda.engine import CudaEngine
from continuum.solve.cuda.linear import CudaLinearEngine


class CudaBackEnd(BackEnd):
    """NVIDIA GPUs; threads of the CPU have no part in it."""

    CAUTION = (
        'device = "cuda" is experimental: its results were checked in a simulator, its speed on no GPU yet; compare a '
        "point with the CPU's before you rely on it"
    )
    SMALLEST = 512
    """On smaller grids a launch costs as much as a sweep."""

    def require(self) -> None:
        refuse_without_gpu()

    def machine(self) -> str:
        return device_name()

    def devices(self) -> tuple[str, ...]:
        return visible_devices()

    def reserve(self, points: int, fields: float) -> None:
        refuse_without_memory(points, fields + 1)  # the work area of cuFFT is a field

    def engine(self, grid: Grid, K: Real, threads: int, below: Grid | None, finer: Any) -> CudaEngine:
        return CudaEngine(grid, K, below, finer)

    def linear_engine(self, grid: Grid, K: Real, threads: int, below: Grid | None, finer: Any) -> Any:
        # On any grid all of a step is one call: none of its parts is asked for.
        return CudaLinearEngine(grid, K, below, finer)

    def bound_engine(self, grid: Grid, K: Real, threads: int, finer: Any) -> CudaBoundEngine:
        return CudaBoundEngine(grid, K, finer)


BACK_END = CudaBackEnd()
