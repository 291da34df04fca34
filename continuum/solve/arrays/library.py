"""Libraries of arrays, and the devices on which their arrays lie.

All that the grids ask for is in the array API standard, which array-api-compat gives the libraries that do not have it
themselves, but for three things: views of complex numbers as pairs of real ones, copies to the host, and functions
that pass over memory once.  Pairs are what a compiler of a library can fuse.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial, wraps
from importlib import import_module
from inspect import signature
from typing import Any, ClassVar, Concatenate, ParamSpec, TypeVar

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.shared_grid import Company

Array = Any
"""An array of a library: their types have nothing in common."""
Given = ParamSpec("Given")
Result = TypeVar("Result")


def fused(function: Callable[Concatenate[Any, Given], Result]) -> Callable[Concatenate[Library, Given], Result]:
    """Make a function of arrays one pass over memory, where their library can.

    Its first argument is the namespace of the library; the function that is made takes the library instead.  What
    changes from call to call is an array; arguments by name are numbers for which it is compiled anew.
    """

    @wraps(function)
    def run(library: Library, /, *given: Given.args, **named: Given.kwargs) -> Result:
        return library.compiled(function)(*given, **named)

    return run


@dataclass(eq=False)
class Library:
    """A library of arrays on one device, by the array API alone: NumPy's, or any that follows the standard."""

    xp: Any
    """Its namespace."""
    device: Any = None
    """As its functions take it; None for the default."""
    parts: ClassVar[int] = 1
    """Number of slabs of rows in which fields lie on as many devices."""
    _compiled: dict[Any, Callable[..., Any]] = field(default_factory=dict)

    def compiled(self, function: Callable[..., Result]) -> Callable[..., Result]:
        """A function with this namespace for its first argument, compiled once."""
        if function not in self._compiled:
            self._compiled[function] = self.compile(partial(function, self.xp))
        return self._compiled[function]

    def compile(self, function: Callable[..., Result]) -> Callable[..., Result]:
        # NumPy need not warn of what is not finite: it ends in the status of a solve.
        return np.errstate(all="ignore")(function)

    def recorded(self, function: Callable[..., Result]) -> Callable[..., Result]:
        """A function of arrays in which the host decides nothing, as one launch where the library can.

        What it returns is overwritten by its next call.
        """
        return function

    def put(self, values: Any, kind: Any = None) -> Array:
        """An array of the host, or a number, on the device."""
        return self.xp.asarray(np.ascontiguousarray(values), dtype=kind or self.xp.float64, device=self.device)

    def number(self, value: Any) -> Array:
        """A number on the device, where it may be already."""
        return self.xp.asarray(value, dtype=self.xp.float64, device=self.device)

    def put_field(self, grid: Grid, values: Real) -> Array:
        """A field of the host, as much of it as this process has, on the device."""
        return self.put(values)

    def get_field(self, grid: Grid, values: Array) -> Real:
        """A field of the device on the host, as much of it as this process has."""
        return self.get(values)

    def zeros(self, shape: tuple[int, ...], kind: Any = None) -> Array:
        return self.xp.zeros(shape, dtype=kind or self.xp.float64, device=self.device)

    def put_q(self, values: Any, kind: Any = None, *, beyond: float = 0.0) -> Array:
        """Values over modes, shape ``grid.shape_q`` or one that goes with it, on the device, as a spectrum has them.

        Where a spectrum has more columns than modes the last ones are ``beyond``.
        """
        return self.put(values[..., None], kind)

    def zeros_q(self, shape_q: tuple[int, int], kind: Any) -> Array:
        """A spectrum."""
        return self.zeros((*shape_q, 2), kind)

    def fits(self, fine: Grid, coarse: Grid) -> bool:
        """Whether the next coarser grid of one lies on the device as that does."""
        return True

    def forward(self, values: Array) -> Array:
        """Spectrum of a field, as pairs."""
        return self.pairs(self.xp.fft.rfftn(values, axes=(0, 1), norm="forward"))

    def inverse(self, spectrum: Array, shape: tuple[int, int]) -> Array:
        """Field of a spectrum."""
        return self.xp.fft.irfftn(self.complex(spectrum), s=shape, axes=(0, 1), norm="forward")

    def every_second(self, values: Array) -> Array:
        """Every second row and column of a field."""
        return values[::2, ::2]

    def hats(self, along_x: Real, along_y: Real) -> tuple[Array, Array]:
        """Functions around nodes along x and y, one in a column, on the device."""
        return self.put(along_x), self.put(along_y)

    def onto_nodes(self, values: Array, hats: tuple[Array, Array]) -> Array:
        """A field, summed onto the nodes by these functions."""
        along_x, along_y = hats
        return along_x.T @ values @ along_y

    def from_nodes(self, values: Array, hats: tuple[Array, Array]) -> Array:
        """The field that these functions make of values at the nodes."""
        along_x, along_y = hats
        return along_x @ values @ along_y.T

    def get(self, values: Array) -> Real:
        """An array of the device on the host: the only place that waits for the device."""
        return np.array(values, dtype=np.float64)

    def numbers(self, *values: Array) -> list[float]:
        """Some numbers of the device, in one copy."""
        found: list[float] = self.get(
            self.xp.stack([self.xp.astype(each, self.xp.float64) for each in values])
        ).tolist()
        return found

    def pairs(self, spectrum: Array) -> Array:
        """Real and imaginary parts, along one more dimension."""
        return self.xp.stack([self.xp.real(spectrum), self.xp.imag(spectrum)], axis=-1)

    def complex(self, pairs: Array) -> Array:
        """The complex numbers of pairs."""
        kind = self.xp.complex64 if pairs.dtype == self.xp.float32 else self.xp.complex128
        return self.xp.astype(pairs[..., 0], kind) + self.xp.astype(pairs[..., 1], kind) * 1j

    def company(self) -> Company | None:
        """The processes that share fields, each with slabs of them; None where these have no parts."""
        return None

    def name(self) -> str:
        """The name of a GPU; empty on processor cores."""
        return ""

    def free_memory(self) -> float:
        """Bytes that are free on the device; infinite where nobody knows."""
        return np.inf

    def devices(self) -> Sequence[Any]:
        """Devices of this kind that processes should not share."""
        return ()


class NumPy(Library):
    """Arrays of NumPy: the reference."""

    def __init__(self) -> None:
        super().__init__(import_module("array_api_compat.numpy"))

    def pairs(self, spectrum: Array) -> Array:
        return spectrum.view(spectrum.real.dtype).reshape(*spectrum.shape, 2)

    def complex(self, pairs: Array) -> Array:
        return pairs.view(self.xp.result_type(pairs.dtype, self.xp.complex64))[..., 0]


class CuPy(Library):
    """Arrays of CuPy on the current GPU."""

    def __init__(self) -> None:
        super().__init__(import_module("array_api_compat.cupy"))
        self._cuda = import_module("cupy").cuda
        self._cuda.runtime.getDevice()  # fails where there is none

    pairs, complex = NumPy.pairs, NumPy.complex

    def get(self, values: Array) -> Real:
        return np.asarray(values.get(), dtype=np.float64)

    def name(self) -> str:
        return str(self._cuda.runtime.getDeviceProperties(self._cuda.runtime.getDevice())["name"].decode())

    def free_memory(self) -> float:
        return float(self._cuda.runtime.memGetInfo()[0])

    def devices(self) -> Sequence[Any]:
        return range(self._cuda.runtime.getDeviceCount())


class Torch(Library):
    """Tensors of PyTorch on processor cores or, fused, on a GPU."""

    def __init__(self, device: str) -> None:
        super().__init__(import_module("array_api_compat.torch"), device)
        self._torch: Any = import_module("torch")
        self._torch.zeros(1, dtype=self._torch.float64, device=device)  # fails where there is none

    def compile(self, function: Callable[..., Result]) -> Callable[..., Result]:
        if self.device == "cpu":
            return function
        # For grids of any size: with a compilation for each, 4096² and its coarser grids pass the limit.
        import_module("torch._dynamo").config.recompile_limit = 64
        made: Callable[..., Result] = self._torch.compile(function, fullgraph=True, dynamic=True)
        return made

    def recorded(self, function: Callable[..., Result]) -> Callable[..., Result]:
        return _Graph(self._torch.cuda, function) if self.device == "cuda" else function

    def get(self, values: Array) -> Real:
        return np.asarray(values.to("cpu", copy=True).numpy(), dtype=np.float64)

    def pairs(self, spectrum: Array) -> Array:
        return self._torch.view_as_real(spectrum)

    def complex(self, pairs: Array) -> Array:
        return self._torch.view_as_complex(pairs)

    def name(self) -> str:
        return "" if self.device == "cpu" else str(self._torch.cuda.get_device_name())

    def free_memory(self) -> float:
        return np.inf if self.device == "cpu" else float(self._torch.cuda.mem_get_info()[0])

    def devices(self) -> Sequence[Any]:
        return () if self.device == "cpu" else range(self._torch.cuda.device_count())


class _Graph:
    """A function of arrays as a CUDA graph: called as it is, which compiles its parts; then recorded; then replayed."""

    def __init__(self, cuda: Any, function: Callable[..., Any]) -> None:
        self._cuda, self._function = cuda, function
        self._graph: Any = None
        self._given: list[Array] = []
        self._found: Any = None

    def __call__(self, *given: Array) -> Any:
        if not self._given:
            self._given = [each.clone() for each in given]
            return self._function(*self._given)
        for mine, each in zip(self._given, given, strict=True):
            mine.copy_(each)
        if self._graph is None:
            beside, here, graph = self._cuda.Stream(), self._cuda.current_stream(), self._cuda.CUDAGraph()
            beside.wait_stream(here)
            with self._cuda.stream(beside):
                graph.capture_begin()
                self._found = self._function(*self._given)
                graph.capture_end()
            here.wait_stream(beside)
            self._graph = graph
        self._graph.replay()
        return self._found


class Jax(Library):
    """Arrays of JAX on its default device: a GPU or TPU where there is one."""

    def __init__(self, platform: str | None = None) -> None:
        self._jax: Any = import_module("jax")
        self._jax.config.update("jax_enable_x64", True)
        super().__init__(import_module("jax.numpy"), self._jax.devices(platform)[0])

    def compile(self, function: Callable[..., Result]) -> Callable[..., Result]:
        named = [each.name for each in signature(function).parameters.values() if each.kind is each.KEYWORD_ONLY]
        made: Callable[..., Result] = self._jax.jit(function, static_argnames=named)
        return made

    def name(self) -> str:
        return "" if self.device.platform == "cpu" else str(self.device.device_kind)

    def free_memory(self) -> float:
        told = self.device.memory_stats() or {}
        return float(told["bytes_limit"] - told["bytes_in_use"]) if "bytes_limit" in told else np.inf

    def devices(self) -> Sequence[Any]:
        return () if self.device.platform == "cpu" else self._jax.devices()


LIBRARIES: dict[str, tuple[Callable[[], Library], str]] = {
    "numpy": (NumPy, ""),
    "torch": (partial(Torch, "cpu"), "torch"),
    "torch:cuda": (partial(Torch, "cuda"), "torch"),
    "cupy": (CuPy, "cupy"),
    "jax": (Jax, "jax"),
}
"""How the library of a device is made, and the extra that brings it."""
CUDA: tuple[Callable[[], Library], ...] = (partial(Torch, "cuda"), CuPy, partial(Jax, "gpu"))
"""What the device "cuda" is: the first of these that is there."""


def visible(devices: Sequence[Any]) -> tuple[str, ...]:
    """Names of the GPUs of this process, as CUDA_VISIBLE_DEVICES has them: a batch system's choice, if it made one."""
    chosen = os.environ.get("CUDA_VISIBLE_DEVICES", "")
    if devices and chosen:
        return tuple(name.strip() for name in chosen.split(","))
    return tuple(str(i) for i in range(len(devices)))
