"""How kernels are compiled and started, and where arrays lie: the one place that knows the device's libraries.

A kernel is a Python function of one thread.  Its threads share the rows among the blocks and the columns among the
threads of a block, whatever the numbers of these; the launch grid is fixed by the number of rows, and no kernel adds
to what another thread has written.  A kernel that sums leaves one part for each thread, and :func:`sum_parts` adds the
parts in a fixed order: the same bits from run to run on one device.

Without a GPU everything runs in numba's simulator, if NUMBA_ENABLE_CUDASIM=1 is set before numba is imported: slowly,
on arrays of NumPy, for tests.
"""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar, cast

import numba.cuda
import numpy as np
from numba import config, float64, int64, types, uint8, void
from numpy.typing import NDArray

from continuum.errors import InputError, StickinessError
from continuum.model.fourier import Real

cuda: Any = numba.cuda
"""The module that kernels use, of the device or of the simulator; no types are known."""
SIMULATED = bool(vars(config)["ENABLE_CUDASIM"])
"""Whether kernels run in numba's simulator."""
BLOCKS, THREADS = (3, 2) if SIMULATED else (1024, 128)
"""Blocks of a launch, at most, and threads of each."""
COLLECTORS = 2 if SIMULATED else 512
"""Threads that add the parts of one sum; a power of two."""
SUMS = 6
"""Sums of a kernel, at most."""

Array = Any
"""An array on the device; its shape is that of a field, or of a half spectrum with real and imaginary parts in turn."""
Mask = NDArray[np.uint8]
"""Which points are in contact: 0 or 1."""
Parameters = Real
"""Parameters of a law; one-dimensional."""
Sums = Real
"""Parts of up to ``SUMS`` sums, a row each, of every thread."""
_Function = TypeVar("_Function", bound=Callable[..., Any])

_TYPES: dict[str, types.Type] = {
    "Real": float64[:, ::1],
    "Sums": float64[:, ::1],
    "Mask": uint8[:, ::1],
    "Parameters": float64[::1],
    "float": float64,
    "int": int64,
}
"""What an annotation of a kernel's parameter means to the compiler."""


def refuse_without_gpu() -> None:
    """Say what is missing; where nothing is, numba no longer warns of launches over few rows.

    Raises
    ------
    InputError
        If there is no GPU that can be used, or a library is missing.
    """
    advice = "device = \"cuda\" needs an NVIDIA GPU with its driver, and: pip install 'stickiness[gpu]'"
    if SIMULATED:
        return
    try:
        # Both are only asked for.
        import numba_cuda  # noqa: F401
        import nvmath.bindings.cufft  # noqa: F401
    except ImportError as missing:
        msg = f"the library {missing.name} is not installed: {advice}"
        raise InputError(msg) from missing
    if not cuda.is_available():
        msg = f"there is no GPU here that can be used: {advice}"
        raise InputError(msg)
    vars(config)["CUDA_LOW_OCCUPANCY_WARNINGS"] = 0  # launches over few rows are meant


def device_name() -> str:
    """Name of the GPU in use."""
    if SIMULATED:
        return "simulator"
    name = cuda.get_current_device().name
    return name.decode() if isinstance(name, bytes) else str(name)


def visible_devices() -> tuple[str, ...]:
    """The GPUs of this process, as CUDA_VISIBLE_DEVICES names them: by the batch system's choice, if it made one."""
    chosen = os.environ.get("CUDA_VISIBLE_DEVICES", "")
    if chosen:
        return tuple(name.strip() for name in chosen.split(","))
    return ("0",) if SIMULATED else tuple(str(i) for i in range(len(cuda.gpus)))


class Kernel:
    """A function of one thread, compiled for the device when it is first started.

    Its signature is read from its annotations, so that it can be compiled without a device, too.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        self.function, self.__doc__, self.__name__ = function, function.__doc__, function.__name__

    @cached_property
    def needs(self) -> tuple[str, ...]:
        """Names of its arguments, without the sums."""
        return tuple(name for name in inspect.signature(self.function).parameters if name != "sums")

    @cached_property
    def summed(self) -> bool:
        """Whether it leaves parts of sums."""
        return "sums" in inspect.signature(self.function).parameters

    @property
    def signature(self) -> Any:
        """Types of its arguments, as numba has them."""
        return void(*(_TYPES[p.annotation] for p in inspect.signature(self.function).parameters.values()))

    @cached_property
    def _compiled(self) -> Any:
        return cuda.jit(self.signature)(self.function)

    def __call__(self, rows: int, *arguments: Any, threads: int | None = None) -> None:
        """Start it over so many rows; it runs while this process goes on."""
        self._compiled[min(rows, BLOCKS), threads or THREADS](*arguments)


def device_function(function: _Function) -> _Function:
    """A function that kernels call; of a function compiled for the CPU the same source is taken."""
    compiled: _Function = cuda.jit(device=True)(getattr(function, "py_func", function))
    return compiled


@device_function
def leave(sums: Sums, slot: int, parts: tuple[float, ...]) -> None:
    """Leave the parts of a thread, the number ``slot`` of all."""
    for k in range(len(parts)):
        sums[k, slot] = parts[k]


@Kernel
def sum_parts(parts: Sums, count: int, largest: int, totals: Sums) -> None:
    """Add the first ``count`` parts of every sum; of the sum of that number take the largest part instead.

    A block adds one sum at a time, by halves in the end.
    """
    shared = cuda.shared.array(COLLECTORS, float64)
    t = cuda.threadIdx.x
    for slot in range(cuda.blockIdx.x, parts.shape[0], cuda.gridDim.x):
        total = -math.inf if slot == largest else 0.0
        for k in range(t, count, COLLECTORS):
            total = max(total, parts[slot, k]) if slot == largest else total + parts[slot, k]
        shared[t] = total
        cuda.syncthreads()
        half = COLLECTORS // 2
        while half > 0:
            if t < half:
                other = shared[t + half]
                shared[t] = max(shared[t], other) if slot == largest else shared[t] + other
            cuda.syncthreads()
            half //= 2
        if t == 0:
            totals[slot, 0] = shared[0]


class Reduction:
    """Memory for the sums of kernels, one after the other."""

    def __init__(self) -> None:
        self.parts, self.totals = empty(SUMS, BLOCKS * THREADS), empty(SUMS, 1)

    def __call__(self, kernel: Kernel, rows: int, *arguments: Any, largest: int = -1) -> Real:
        """Start a kernel over so many rows and wait for its sums, shape (SUMS,); those that it does not make are void.

        ``largest`` is the number of one of which the largest part is wanted.
        """
        try:
            kernel(rows, *arguments, self.parts)
            count = min(rows, BLOCKS) * THREADS
            sum_parts(SUMS, self.parts, count, largest, self.totals, threads=COLLECTORS)
            totals: Real = self.totals.copy_to_host()[:, 0]
        except _driver_error() as error:
            # What a launch did wrong shows where its sums are waited for.
            msg = f'the GPU failed: {error}; run again, which goes on from what is stored, or take device = "cpu"'
            raise DeviceError(msg) from error
        return totals


class DeviceError(StickinessError):
    """The GPU or its driver failed."""


def _driver_error() -> type[Exception]:
    """What the driver raises; there is none in the simulator."""
    return _Never if SIMULATED else cast("type[Exception]", cuda.cudadrv.driver.CudaAPIError)


class _Never(Exception):
    pass


def refuse_without_memory(points: int, fields: float) -> None:
    """Say before anything is begun that a grid does not fit.

    Raises
    ------
    MemoryError
        If so many fields of so many points are more than the device has left.
    """
    if SIMULATED:
        return
    left, whole = cuda.current_context().get_memory_info()
    needed = points * fields * 8
    if needed > left:
        gib = 2**30
        msg = f"on the GPU: it has {left / gib:.3g} of {whole / gib:.3g} GiB left, this grid needs {needed / gib:.3g}"
        raise MemoryError(msg)


def empty(rows: int, columns: int, kind: Any = np.float64) -> Array:
    """Memory on the device, not set.

    Raises
    ------
    MemoryError
        If there is none left.
    """
    try:
        made = cuda.device_array((rows, columns), kind)
    except _driver_error() as error:
        gib = rows * columns * np.dtype(kind).itemsize / 2**30
        msg = f"on the GPU, for one more array of {gib:.3g} GiB: {error}"
        raise MemoryError(msg) from error
    if SIMULATED and kind is np.float64:
        made[...] = np.nan  # who reads what was never written shall see it
    return made


def to_device(values: NDArray[Any]) -> Array:
    """A copy on the device."""
    return cuda.to_device(np.ascontiguousarray(values))
