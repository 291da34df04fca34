"""How kernels are compiled and started, and where arrays lie: the one place that knows the device's libraries.

A kernel is a Python function of one thread.  Its threads share the rows among the blocks and the columns among the
threads of a block, whatever the numbers of these.  As many blocks are started as the device runs at once, each with
the same number of rows: that number is fixed by kernel, device and rows, and with it the bits of all sums
(:mod:`continuum.solve.cuda.sums`).  Compiled kernels are kept on disk.

Without a GPU everything runs in numba's simulator, if NUMBA_ENABLE_CUDASIM=1 is set before numba is imported: slowly,
on arrays of NumPy, for tests.
"""

from __future__ import annotations

import hashlib
import inspect
import os
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, cast

import numba.cuda
import numpy as np
from numba import config, float32, float64, int64, types, uint8, void
from numpy.typing import NDArray

from continuum.errors import InputError, StickinessError
from continuum.model import laws
from continuum.model.fourier import Real

cuda: Any = numba.cuda
"""The module that kernels use, of the device or of the simulator; no types are known."""
SIMULATED = bool(vars(config)["ENABLE_CUDASIM"])
"""Whether kernels run in numba's simulator."""
THREADS = 2 if SIMULATED else 128
"""Threads of a block; a power of two."""
BLOCKS = 3
"""Blocks that the simulator takes for as many as it runs at once."""
SOURCES = (Path(laws.__file__), *sorted(Path(__file__).parent.glob("*.py")))
"""Files whose functions and constants a kernel is compiled with."""

Array = Any
"""An array on the device; its shape is that of a field, or of a half spectrum with real and imaginary parts in turn."""
Mask = NDArray[np.uint8]
"""Which points are in contact: 0 or 1."""
Single = NDArray[np.float32]
"""A field in single precision."""
Parameters = Real
"""Parameters of a law, or a state; one-dimensional."""
Sums = Real
"""Parts of some sums, a row each, of every block."""
_Function = TypeVar("_Function", bound=Callable[..., Any])

_TYPES: dict[str, types.Type] = {
    "Real": float64[:, ::1],
    "Sums": float64[:, ::1],
    "Single": float32[:, ::1],
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
    advice = (
        "device = \"cuda\" needs an NVIDIA GPU with its driver, and: pip install 'stickiness[gpu]', or "
        "'stickiness[gpu12]' where the driver is of CUDA 12"
    )
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
    driver, libraries = (int(kind.get_version()[0]) for kind in (cuda.cudadrv.driver.driver, cuda.runtime))
    if driver < libraries:
        msg = f"the driver of the GPU is of CUDA {driver}, the installed libraries of CUDA {libraries}: {advice}"
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


def source_digest(sources: tuple[Path, ...] = SOURCES) -> str:
    """Short hash of the content of some files.

    numba's cache on disk does not look at the files of the functions that a kernel calls.  Its name for a kernel holds
    the qualified name of the function: so that is given this hash, as on processor cores.
    """
    return hashlib.sha256(b"\0".join(source.read_bytes() for source in sources)).hexdigest()[:12]


_DIGEST = source_digest()


class Kernel:
    """A function of one thread, compiled for the device when it is first started, or read from disk.

    Its signature is read from its annotations, so that it can be compiled without a device, too.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        self.function, self.__doc__, self.__name__ = function, function.__doc__, function.__name__
        function.__qualname__ = f"{function.__qualname__}-{_DIGEST}"

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
    def compiled(self) -> Any:
        """What is started."""
        return cuda.jit(self.signature, cache=True)(self.function)

    @cached_property
    def at_once(self) -> int:
        """Blocks that the device runs at the same time: as its registers and its shared memory allow."""
        if SIMULATED:
            return BLOCKS
        (variant,) = self.compiled.overloads.values()
        return int(variant.max_cooperative_grid_blocks(THREADS))

    def blocks(self, rows: int) -> int:
        """Blocks that share so many rows: all run at once, and none has fewer rows than it could without delay."""
        most_rows = -(-rows // self.at_once)
        return -(-rows // most_rows)

    def __call__(self, rows: int, *arguments: Any) -> None:
        """Start it over so many rows; it runs while this process goes on."""
        self.compiled[self.blocks(rows), THREADS](*arguments)


def device_function(function: _Function) -> _Function:
    """A function that kernels call; of a function compiled for the CPU the same source is taken."""
    compiled: _Function = cuda.jit(device=True)(getattr(function, "py_func", function))
    return compiled


@device_function
def larger(a: float, b: float) -> float:
    """The larger of two numbers, NaN if one of them is: the device's own ``max`` drops NaN."""
    return a if a >= b or a != a else b  # only NaN differs from itself


@device_function
def smaller(a: float, b: float) -> float:
    """The smaller of two numbers, NaN if one of them is."""
    return a if a <= b or a != a else b  # only NaN differs from itself


def _whole_pairs() -> tuple[Any, Any]:
    """Functions of kernels that read and write two neighbouring numbers at once, as 16 bytes, which a thread can."""
    from llvmlite import ir
    from numba.cuda.extending import intrinsic

    def place(context: Any, builder: Any, kind: Any, arguments: Any) -> Any:
        array = context.make_array(kind)(context, builder, arguments[0])
        row = builder.mul(arguments[1], builder.extract_value(array.shape, 1))
        first = builder.add(row, builder.shl(arguments[2], ir.Constant(ir.IntType(64), 1)))
        return builder.bitcast(builder.gep(array.data, [first]), ir.VectorType(ir.DoubleType(), 2).as_pointer())

    two = cast("Any", types).UniTuple(float64, 2)

    def nth(number: int) -> Any:
        return ir.Constant(ir.IntType(32), number)

    @intrinsic
    def read(_: Any, array: Any, i: Any, j: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            both = builder.load(place(context, builder, array, arguments))
            both.align = 16
            parts = [builder.extract_element(both, nth(k)) for k in (0, 1)]
            return context.make_tuple(builder, signature.return_type, parts)

        return two(array, int64, int64), code

    @intrinsic
    def write(_: Any, array: Any, i: Any, j: Any, real: Any, imaginary: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            both = ir.Constant(ir.VectorType(ir.DoubleType(), 2), ir.Undefined)
            for k in (0, 1):
                both = builder.insert_element(both, arguments[3 + k], nth(k))
            builder.store(both, place(context, builder, array, arguments)).align = 16
            return context.get_dummy_value()

        return void(array, int64, int64, float64, float64), code

    return read, write


def _simulated_pairs() -> tuple[Any, Any]:
    """The same in words."""

    def read(array: Real, i: int, j: int) -> tuple[float, float]:
        return array[i, 2 * j], array[i, 2 * j + 1]

    def write(array: Real, i: int, j: int, real: float, imaginary: float) -> None:
        array[i, 2 * j], array[i, 2 * j + 1] = real, imaginary

    return read, write


complex_at, set_complex = _simulated_pairs() if SIMULATED else _whole_pairs()
"""Element (i, j) of a half spectrum, real and imaginary part, read or written as one."""


class DeviceError(StickinessError):
    """The GPU or its driver failed."""


def driver_error() -> type[Exception]:
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
    except driver_error() as error:
        gib = rows * columns * np.dtype(kind).itemsize / 2**30
        msg = f"on the GPU, for one more array of {gib:.3g} GiB: {error}"
        raise MemoryError(msg) from error
    if SIMULATED and kind is np.float64:
        made[...] = np.nan  # who reads what was never written shall see it
    return made


def pinned(rows: int, columns: int) -> Real:
    """An array of the host that the device copies to without an intermediate one."""
    values: Real = cuda.pinned_array((rows, columns), np.float64)
    return values


def to_device(values: NDArray[Any]) -> Array:
    """A copy on the device."""
    return cuda.to_device(np.ascontiguousarray(values))
