"""Arrays of JAX in slabs on several devices, of one process or of several.

A field lies in slabs of rows, shape ``grid.shape``.  A spectrum lies in slabs of columns, shape (nx, parts, k, 2): its
column n is column n // parts of part n % parts, so that each part has the same share of the modes of every coarser grid
and going to that grid moves nothing.  A transform is one exchange of all parts with all; passes over spectra and over
fields exchange sums only, shifts of a field its rows at the edges of the slabs.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.errors import InputError
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.shared_grid import columns_of_part
from continuum.solve.arrays.library import Array, Jax
from continuum.solve.processes import World, launched

_AXIS = "part"
Axes = tuple[str | None, ...]
_ROWS: Axes = (_AXIS,)
_COLUMNS: Axes = (None, _AXIS)


WAITING, SILENT = 60, 30
"""Seconds for which a process waits for the others at the start, and without a sign of life from them."""


def _wait_for_the_first(world: World) -> None:
    """Wait until the first process listens: JAX itself ends in a dump where it does not."""
    host, _, port = world.address().rpartition(":")
    end = time.monotonic() + WAITING
    while not world.first:
        with suppress(OSError), socket.create_connection((host, int(port)), timeout=1):
            return
        if time.monotonic() > end:
            raise InputError(f"process {world.rank} of {world.size} finds no first process at {host}:{port}")
        time.sleep(0.1)


def _join(jax: Any, world: World) -> None:
    """Let JAX of all processes know one another; raises InputError where they do not meet."""
    if world.size == 1 or jax.distributed.is_initialized():
        return
    given = dict[str, Any]()
    if "SLURM_JOB_ID" not in os.environ:  # by which JAX finds the others itself
        given = {"coordinator_address": world.address(), "num_processes": world.size, "process_id": world.rank}
        _wait_for_the_first(world)
    waits = {"initialization_timeout": WAITING, "heartbeat_timeout_seconds": SILENT, "shutdown_timeout_seconds": SILENT}
    try:
        jax.distributed.initialize(**given, **waits)
    except RuntimeError as error:
        first = str(error).strip().splitlines()[0]
        raise InputError(f"process {world.rank} of {world.size} does not find the others: {first}") from error


class Processes:
    """The processes of JAX that share fields; what they send goes through one device of each."""

    def __init__(self, jax: Any, rank: int, size: int, parts: int, devices: NDArray[Any]) -> None:
        self.rank, self.size, self.parts = rank, size, parts
        self._jax = jax
        self._mesh: Any = jax.sharding.Mesh(devices[:: parts // size], (_AXIS,))

    def gather(self, values: NDArray[Any]) -> NDArray[Any]:
        if self.size == 1:
            return values[None]
        found: NDArray[Any] = import_module("jax.experimental.multihost_utils").process_allgather(values)
        return found

    def exchange(self, blocks: NDArray[Any]) -> NDArray[Any]:
        if self.size == 1:
            return blocks
        spec = self._jax.sharding.PartitionSpec
        rows, columns = spec(_AXIS), spec(None, _AXIS)
        shape = self.size, *blocks.shape
        sharding = self._jax.sharding.NamedSharding(self._mesh, rows)
        given = self._jax.make_array_from_callback(shape, sharding, lambda part: blocks[None])
        exchanged = self._jax.shard_map(
            lambda block: self._jax.lax.all_to_all(block, _AXIS, split_axis=1, concat_axis=0, tiled=True),
            mesh=self._mesh, in_specs=rows, out_specs=columns,
        )  # fmt: skip
        (shard,) = self._jax.jit(exchanged)(given).addressable_shards
        found: NDArray[Any] = np.asarray(shard.data)[:, 0]
        return found


class Slabs(Jax):
    """Arrays of JAX in slabs, one on each of so many devices.

    Raises InputError if JAX sees fewer devices.
    """

    def __init__(self, parts: int) -> None:
        jax, world = import_module("jax"), launched()
        if parts % world.size:
            raise InputError(f"shards = {parts} make no equal share for each of {world.size} processes")
        with suppress(RuntimeError):  # JAX runs already, with as many as it has
            jax.config.update("jax_num_cpu_devices", parts // world.size)
        _join(jax, world)
        super().__init__()
        self.processes, self.rank = world.size, world.rank
        devices = sorted(jax.devices(), key=lambda each: (each.process_index, each.id))
        if len(devices) < parts:
            found = f"{len(devices)} ({devices[0].platform})"
            raise InputError(f"shards = {parts} needs as many devices, of which JAX sees {found}")
        self.parts = parts  # type: ignore[misc]
        self._mesh: Any = jax.sharding.Mesh(np.array(devices[:parts]), (_AXIS,))
        self.device = None
        self._platform = devices[0]
        self._made: dict[Any, Any] = {}

    def _sharding(self, *axes: str | None) -> Any:
        return self._jax.sharding.NamedSharding(self._mesh, self._jax.sharding.PartitionSpec(*axes))

    # --- arrays ------------------------------------------------------------------------------------------------

    def _place(self, values: NDArray[Any], *axes: str | None) -> Array:
        """An array that each process has, of which its devices take their parts."""
        return self._jax.make_array_from_callback(values.shape, self._sharding(*axes), lambda part: values[part])

    def put(self, values: Any, kind: Any = None) -> Array:
        """An array of the host on the devices: a field in slabs of rows, anything else on each of them."""
        values = np.asarray(values, dtype=kind or np.float64)
        return self._place(values, *self._rows(values.shape))

    def _own(self, values: NDArray[Any], axis: int) -> Array:
        """An array of which each process has its parts along an axis."""
        have, first = values.shape[axis], self.rank * values.shape[axis]
        shape = *values.shape[:axis], have * self.processes, *values.shape[axis + 1 :]

        def part(index: tuple[slice, ...]) -> NDArray[Any]:
            start, stop, _ = index[axis].indices(shape[axis])
            return values[(*index[:axis], slice(start - first, stop - first))]

        return self._jax.make_array_from_callback(shape, self._sharding(*(None,) * axis, _AXIS), part)

    def put_field(self, grid: Grid, values: Real) -> Array:
        if grid.shared:
            return self._own(np.asarray(values, dtype=np.float64), 0)
        return self.put(values)

    def get_field(self, grid: Grid, values: Array) -> Real:
        if not grid.shared:
            return self.get(values)
        own: Real = np.empty(grid.shape_here)
        for shard in values.addressable_shards:
            start, stop, _ = shard.index[0].indices(grid.shape[0])
            own[start - grid.rows.start : stop - grid.rows.start] = shard.data
        return own

    def _rows(self, shape: tuple[int, ...]) -> Axes:
        """The axes of an array over the points, or over its rows, in slabs."""
        return _ROWS if len(shape) == 2 and shape[0] % self.parts == 0 else ()

    def number(self, value: Any) -> Array:
        if isinstance(value, self._jax.Array):
            return self.xp.astype(value, self.xp.float64)
        return self._place(np.asarray(value, dtype=np.float64))

    def zeros(self, shape: tuple[int, ...], kind: Any = None) -> Array:
        return self.xp.zeros(shape, dtype=kind or self.xp.float64, device=self._sharding(*self._rows(shape)))

    def _columns(self, columns: int) -> int:
        """Columns of a part of a spectrum."""
        return columns_of_part(columns, self.parts)

    def put_q(self, values: Any, kind: Any = None, *, beyond: float = 0.0) -> Array:
        values = np.asarray(values, dtype=kind or np.float64)
        if values.ndim == 3:  # the modes of this process
            return self._place(values[..., None]) if values.shape[2] == 1 else self._own(values[..., None], 1)
        rows, columns = values.shape
        if columns == 1:
            return self._place(values[:, :, None, None])
        k = self._columns(columns)
        wide = np.full((rows, k * self.parts), beyond, dtype=values.dtype)
        wide[:, :columns] = values
        dealt = wide.reshape(rows, k, self.parts).swapaxes(1, 2)[..., None]
        return self._place(dealt, *_COLUMNS)

    def zeros_q(self, shape_q: tuple[int, int], kind: Any) -> Array:
        shape = shape_q[0], self.parts, self._columns(shape_q[1]), 2
        return self.xp.zeros(shape, dtype=kind, device=self._sharding(*_COLUMNS))

    def fits(self, fine: Grid, coarse: Grid) -> bool:
        halved = all(n == 2 * c for n, c in zip(fine.shape, coarse.shape, strict=True))
        return halved and coarse.shape[0] % self.parts == 0

    # --- transforms --------------------------------------------------------------------------------------------

    def forward(self, values: Array) -> Array:
        return self._over_slabs("forward", self._forward, _ROWS, _COLUMNS)(values)

    def inverse(self, spectrum: Array, shape: tuple[int, int]) -> Array:
        points = shape[1]
        return self._over_slabs(points, lambda slab: self._inverse(slab, points), _COLUMNS, _ROWS)(spectrum)

    def every_second(self, values: Array) -> Array:
        return self._over_slabs("every second", lambda slab: slab[::2, ::2], _ROWS, _ROWS)(values)

    def hats(self, along_x: Real, along_y: Real) -> tuple[Array, Array]:
        return self.number(along_x), self.number(along_y)

    def onto_nodes(self, values: Array, hats: tuple[Array, Array]) -> Array:
        return self._over_slabs("onto nodes", self._onto_nodes, _ROWS, _ROWS, (), ())(values, *hats)

    def from_nodes(self, values: Array, hats: tuple[Array, Array]) -> Array:
        return self._over_slabs("from nodes", self._from_nodes, _ROWS, _ROWS, (), ())(values, *hats)

    def _onto_nodes(self, values: Array, along_x: Array, along_y: Array) -> Array:
        following = [(part, (part + 1) % self.parts) for part in range(self.parts)]
        sums = along_x.T @ (values @ along_y)
        return self.xp.concat([sums[:1] + self._jax.lax.ppermute(sums[-1:], _AXIS, following), sums[1:-1]])

    def _from_nodes(self, values: Array, along_x: Array, along_y: Array) -> Array:
        before = [((part + 1) % self.parts, part) for part in range(self.parts)]
        beyond = self._jax.lax.ppermute(values[:1], _AXIS, before)
        return along_x @ self.xp.concat([values, beyond]) @ along_y.T

    def _over_slabs(self, key: Any, function: Callable[..., Array], given: Axes, found: Axes, *beside: Axes) -> Any:
        """A function of a slab, and of what is ``beside``, on whole arrays; compiled once for a key."""
        if key not in self._made:
            spec = self._jax.sharding.PartitionSpec
            slabs = {"in_specs": tuple(spec(*each) for each in (given, *beside)), "out_specs": spec(*found)}
            self._made[key] = self._jax.jit(self._jax.shard_map(function, mesh=self._mesh, **slabs))
        return self._made[key]

    def _forward(self, values: Array) -> Array:
        """Rows of this part, exchanged for its columns, and these."""
        xp, rows = self.xp, values.shape[0]
        half = xp.fft.rfft(values, axis=1, norm="forward")
        k = self._columns(half.shape[1])
        half = xp.pad(half, ((0, 0), (0, k * self.parts - half.shape[1])))
        dealt = xp.reshape(half, (rows, k, self.parts))
        mine = self._jax.lax.all_to_all(dealt, _AXIS, split_axis=2, concat_axis=0, tiled=True)
        return self.pairs(xp.fft.fft(xp.swapaxes(mine, 1, 2), axis=0, norm="forward"))

    def _inverse(self, spectrum: Array, columns: int) -> Array:
        xp, k = self.xp, spectrum.shape[2]
        mine = xp.swapaxes(xp.fft.ifft(self.complex(spectrum), axis=0, norm="forward"), 1, 2)
        dealt = self._jax.lax.all_to_all(mine, _AXIS, split_axis=0, concat_axis=2, tiled=True)
        half = xp.reshape(dealt, (dealt.shape[0], k * self.parts))[:, : columns // 2 + 1]
        return xp.fft.irfft(half, n=columns, axis=1, norm="forward")

    # --- the devices -------------------------------------------------------------------------------------------

    def get(self, values: Array) -> Real:
        if not values.is_fully_addressable and not values.is_fully_replicated:
            values = import_module("jax.experimental.multihost_utils").process_allgather(values, tiled=True)
        return np.array(values, dtype=np.float64)

    def company(self) -> Processes:
        return Processes(self._jax, self.rank, self.processes, self.parts, self._mesh.devices)

    def name(self) -> str:
        if self._platform.platform == "cpu":
            return ""
        return f"{self.parts} x {self._platform.device_kind}"

    def free_memory(self) -> float:
        """Bytes that are free on all devices, of which each has the same part."""
        told = [each.memory_stats() or {} for each in self._mesh.local_mesh.devices]
        free = [float(each["bytes_limit"] - each["bytes_in_use"]) for each in told if "bytes_limit" in each]
        return min(free) * self.parts if free else np.inf

    def devices(self) -> tuple[Any, ...]:
        """None: a process has all of them."""
        return ()
