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
        self.processes = world.size
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
        return -(-columns // self.parts)

    def put_q(self, values: Any, kind: Any = None, *, beyond: float = 0.0) -> Array:
        rows, columns = values.shape
        values = np.asarray(values, dtype=kind or np.float64)
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
        # A slab begins at a node.  The functions of its rows are those of every slab: of its nodes and of the next one.
        rows, nodes = (n // self.parts for n in along_x.shape)
        return self.number(along_x[:rows, : nodes + 1]), self.number(along_y)

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
