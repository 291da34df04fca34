"""Both solvers on whole arrays of any library of the array API: NumPy, the reference, PyTorch, CuPy, JAX.

Less fast than compiled sweeps on processor cores, and made for devices on which memory is fast.
"""

from contextlib import suppress
from functools import cache, cached_property
from importlib import import_module

from continuum.inputs.errors import InputError
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.shared_grid import Company
from continuum.solve.arrays.bound_grid import ArrayBoundGrid
from continuum.solve.arrays.library import CUDA, LIBRARIES, Library, visible
from continuum.solve.arrays.smooth_grid import ArraySmoothGrid
from continuum.solve.backend import SPACING, BackEnd


class ArrayBackEnd(BackEnd):
    """A device, by its name; its library is imported when it is first asked for."""

    PRECISION = "float32"
    """Precision of linear problems: a step of a coarser grid is a direction only."""

    @cached_property
    def library(self) -> Library:
        """Where arrays lie."""
        return found(self.device, self.parts)

    @cached_property
    def SMALLEST(self) -> int:  # type: ignore[override]
        # On smaller grids of a GPU a launch costs as much as a pass.
        return 512 if self.library.name() else 128

    def require(self) -> None:
        self.library.zeros((1,))

    def memory(self) -> float:
        return self.library.free_memory()

    def company(self) -> Company | None:
        return self.library.company()

    def machine(self) -> str:
        return self.library.name()

    def devices(self) -> tuple[str, ...]:
        return visible(self.library.devices())

    def smooth_grid(self, grid: Grid, K: Real, threads: int, coarser: int, *, sampled: bool) -> ArraySmoothGrid:
        self._check(grid)
        self._reserve(grid, ArraySmoothGrid.FIELDS)
        return ArraySmoothGrid(self.library, grid, K, self.SMALLEST, self.PRECISION, coarser, sampled=sampled)

    def bound_grid(self, grid: Grid, K: Real, threads: int) -> ArrayBoundGrid:
        self._check(grid)
        if self.parts > 1 and grid.shape[0] % (SPACING * self.parts):
            msg = f"{SPACING} shards, {SPACING * self.parts}, have to divide the {grid.shape[0]} points along x"
            raise InputError(f"under a hard wall {msg}")
        self._reserve(grid, ArrayBoundGrid.FIELDS)
        return ArrayBoundGrid(self.library, grid, K, self.SMALLEST)

    def _check(self, grid: Grid) -> None:
        """Raise InputError where the rows of a grid make no equal slabs."""
        if grid.shape[0] % self.parts:
            msg = f"{grid.shape[0]} rows make no {self.parts} equal slabs: shards has to divide the points along x"
            raise InputError(msg)

    def _reserve(self, grid: Grid, fields: float) -> None:
        """Raise MemoryError if so many fields do not fit on the device."""
        needed, free = 8 * fields * grid.size, self.library.free_memory()
        if needed > free:
            msg = f"this grid needs {needed / 2**30:.1f} GiB on the device, of which {free / 2**30:.1f} GiB are free"
            raise MemoryError(msg)


def found(device: str, parts: int = 1) -> Library:
    """The library of a device, or for "cuda" the first that sees a GPU; raises InputError that says what is missing.

    Of several parts it is that of JAX, on as many devices.
    """
    if device == "cuda":
        for make in CUDA:
            with suppress(Exception):
                return make()
        raise InputError(
            'device = "cuda" needs a GPU with its driver, and a library that sees it: pip install '
            "'stickiness[torch]', or 'stickiness[cupy]', or 'stickiness[jax]'"
        )
    make, extra = LIBRARIES[device]
    try:
        return make() if parts == 1 else import_module("continuum.solve.arrays.slabs").Slabs(parts)
    except InputError:
        raise
    except ImportError as missing:
        msg = f"device = \"{device}\" needs {missing.name}, which is not installed: pip install 'stickiness[{extra}]'"
        raise InputError(msg) from missing
    except Exception as error:  # each library has its own
        msg = f'device = "{device}" cannot be used here: {str(error).strip().splitlines()[0]}'
        raise InputError(msg) from error


BACK_END = cache(ArrayBackEnd)
"""The back end of a device by its name, one for all who ask."""
