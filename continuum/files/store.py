"""Results on disk: one HDF5 file each, written whole or not at all.  The only module that knows h5py.

A file is a mapping of names to :class:`Dataset` (arrays with named dimensions) and of names to attributes
(numbers and text).  A name ``group/name`` lies in a group; ``journal`` holds times, hosts and dates, so that
everything outside it is reproducible bit for bit.  A dataset that is named as a dimension holds its
coordinates.  xarray opens a file with the same names: ``xarray.open_dataset(path, engine="h5netcdf")``.

Damage is noticed: datasets carry a Fletcher-32 sum, and the file format is one whose headers carry sums of
their own, which is also why text has a fixed length.  What could lead a reader to other files (external
links, external storage, virtual datasets) is refused.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Attribute",
    "Dataset",
    "File",
    "StoreError",
    "pack",
    "read",
    "read_array",
    "read_part",
    "remove_stale",
    "unpack",
    "write",
]

Attribute = bool | int | float | str

_FORMAT = ("v110", "v110")  # the oldest with sums on its headers; HDF5 1.10 (2016) and later read it
_CHUNK = 4 * 1024 * 1024  # bytes
_NO_COORDINATES = "This is a netCDF dimension but not a netCDF variable. %10d"


class StoreError(OSError):
    """A result cannot be read or written: damaged, of another kind, or refused.  The message says which."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """An array with named dimensions.

    Parameters
    ----------
    values : numbers, booleans or text (an array of str).
    dims : name of each dimension, at least one.
    units : "a0", "E*", "1" for a pure number, "" where units have no meaning (text).
    long_name : what it is, in words.
    """

    values: NDArray[Any] = field(repr=False)
    dims: tuple[str, ...]
    units: str = ""
    long_name: str = ""

    def __post_init__(self) -> None:
        """Refuse arrays that the file format would not give back as they are."""
        values = np.asarray(self.values)
        if values.dtype.kind not in "biufUT":
            msg = f"a dataset holds numbers, booleans or text, not {values.dtype}"
            raise TypeError(msg)
        if values.ndim != len(self.dims) or values.ndim == 0:
            msg = f"an array of shape {values.shape} does not have the dimensions {self.dims}"
            raise ValueError(msg)
        object.__setattr__(self, "values", values)


@dataclass(frozen=True, eq=False)
class File:
    """What a file holds."""

    datasets: Mapping[str, Dataset]
    attributes: Mapping[str, Attribute]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Values of a dataset."""
        return self.datasets[name].values


def write(path: str | Path, datasets: Mapping[str, Dataset], attributes: Mapping[str, Attribute]) -> None:
    """Write a file: complete under its name, or not at all, whatever interrupts.

    Parameters
    ----------
    path : its folder must exist.
    datasets, attributes : see the module.  Attributes ``schema`` and ``schema_version`` are required.

    Raises
    ------
    ValueError
        If the schema is not named, or datasets disagree on the length of a dimension.
    StoreError
        If the file cannot be written; an older one under that name stays as it was.
    """
    path = Path(path)
    if not isinstance(attributes.get("schema"), str) or not isinstance(attributes.get("schema_version"), int):
        msg = 'a file names its "schema" (text) and "schema_version" (a whole number)'
        raise ValueError(msg)
    lengths = _dimensions(datasets)
    # Same folder, so that the replacement is a rename; host and process, so that two writers never share it.
    temporary = path.with_name(f"{_stem(path)}{socket.gethostname()}.{os.getpid()}.tmp")
    try:
        with h5py.File(temporary, "w", libver=_FORMAT) as file:
            _fill(file, datasets, attributes, lengths)
        _sync(temporary)
        os.replace(temporary, path)  # noqa: PTH105 - the name says what happens
        _sync(path.parent)
    except OSError as error:
        msg = f"{path}: cannot be written: {error}"
        raise StoreError(msg) from error
    finally:
        temporary.unlink(missing_ok=True)


def _stem(path: Path) -> str:
    return f".{path.name}."


def remove_stale(path: str | Path) -> None:
    """Remove what writers of this file left behind when they were killed on this machine."""
    path = Path(path)
    stem = _stem(path) + socket.gethostname() + "."
    if not path.parent.is_dir():
        return
    for entry in path.parent.iterdir():
        process = entry.name.removeprefix(stem).removesuffix(".tmp")
        if entry.name == f"{stem}{process}.tmp" and process.isdecimal() and not _alive(int(process)):
            entry.unlink(missing_ok=True)


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _dimensions(datasets: Mapping[str, Dataset]) -> dict[str, int]:
    lengths: dict[str, int] = {}
    for name, dataset in datasets.items():
        for dim, length in zip(dataset.dims, dataset.values.shape, strict=True):
            if lengths.setdefault(dim, length) != length:
                msg = f"dimension {dim} of {name} has {length} entries, elsewhere it has {lengths[dim]}"
                raise ValueError(msg)
    return lengths


def _fill(
    file: h5py.File,
    datasets: Mapping[str, Dataset],
    attributes: Mapping[str, Attribute],
    lengths: Mapping[str, int],
) -> None:
    for name, dataset in datasets.items():
        stored = _create(file, name, dataset.values)
        stored.attrs["units"] = _text(dataset.units)
        stored.attrs["long_name"] = _text(dataset.long_name)
        if dataset.values.dtype.kind in "UT":
            stored.attrs["_Encoding"] = _text("utf-8")  # xarray then gives str, not bytes
        if dataset.values.dtype.kind == "b":
            stored.attrs["dtype"] = _text("bool")  # likewise
    for dim, length in lengths.items():
        if dim in datasets:
            file[dim].make_scale(dim)
        else:
            _create(file, dim, np.zeros(length, dtype=np.uint8)).make_scale(_NO_COORDINATES % length)
    for name, dataset in datasets.items():
        if dataset.dims != (name,):
            for i, dim in enumerate(dataset.dims):
                file[name].dims[i].attach_scale(file[dim])
    for name, value in attributes.items():
        group, _, key = name.rpartition("/")
        owner = file.require_group(group) if group else file
        owner.attrs[key] = _text(value) if isinstance(value, str) else _number(value)


def _create(file: h5py.File, name: str, values: NDArray[Any]) -> h5py.Dataset:
    if values.dtype.kind in "UT":
        encoded = np.strings.encode(values.astype(np.str_), "utf-8")
        values = encoded.astype(h5py.string_dtype("utf-8", max(encoded.dtype.itemsize, 1)))
    elif values.dtype.kind == "b":
        values = values.view(np.uint8)
    if values.size == 0:
        return file.create_dataset(name, data=values)  # nothing to sum
    return file.create_dataset(name, data=values, chunks=_chunks(values), fletcher32=True)


def _chunks(values: NDArray[Any]) -> tuple[int, ...]:
    """One step of a map, or a part of it: leading dimensions are cut until a chunk is small."""
    chunks = list(values.shape)
    for i in range(len(chunks)):
        others = values.dtype.itemsize * int(np.prod(chunks[i + 1 :]))
        chunks[i] = max(1, min(chunks[i], _CHUNK // others))
    return tuple(chunks)


def _text(text: str) -> NDArray[Any]:
    encoded = text.encode()
    return np.array(encoded, dtype=h5py.string_dtype("utf-8", max(len(encoded), 1)))


def _number(value: bool | float) -> Any:
    if isinstance(value, bool):
        return np.uint8(value)  # HDF5's booleans are unknown to netCDF; whole numbers are stored as int64
    return np.int64(value) if isinstance(value, int) else np.float64(value)


def read(path: str | Path, schema: str, version: int, names: Collection[str] | None = None) -> File:
    """Read a file of a known kind.

    Parameters
    ----------
    path : the file.
    schema, version : what it must be.
    names : the datasets wanted; all if None.  Of those absent from the file nothing is said.

    Raises
    ------
    StoreError
        If the file is missing, damaged, of another kind, or holds what is refused.
    """
    path = Path(path)
    with _opened(path) as file:
        attributes = dict(_attributes(file))
        found = attributes.get("schema"), attributes.get("schema_version")
        if found != (schema, version):
            what = f"{found[0]} version {found[1]}" if found[0] else "no result of this program"
            msg = f"{path}: holds {what}, expected {schema} version {version}"
            raise StoreError(msg)
        datasets = {
            name: _load(item)
            for name, item in _walk(path, file)
            if (names is None or name in names) and not _only_dimension(item)
        }
    return File(datasets, attributes)


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """A file open for reading; one kind of error for all that h5py raises on damaged files."""
    if not path.is_file():
        msg = f"{path}: there is no such file"
        raise StoreError(msg)
    try:
        # Files are replaced, never changed, so locks protect nothing and read-only folders need none.
        file = h5py.File(path, "r", locking=False)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        msg = f"{path}: not an HDF5 file, or damaged or truncated ({error})"
        raise StoreError(msg) from error
    with file:
        try:
            yield file
        except StoreError:
            raise
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError, MemoryError) as error:
            msg = f"{path}: cannot be read, probably damaged ({error})"
            raise StoreError(msg) from error


def _walk(path: Path, group: h5py.Group, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, h5py.Dataset]]:
    """All datasets of a file, refusing whatever is not stored in it."""
    for name in group:
        link = group.get(name, getlink=True)
        full = prefix + name
        if not isinstance(link, h5py.HardLink):
            msg = f"{path}: {full} is a link to elsewhere ({type(link).__name__}), which is refused"
            raise StoreError(msg)
        item = group[name]
        if isinstance(item, h5py.Group):
            if depth > 8:
                msg = f"{path}: groups are nested too deep at {full}"
                raise StoreError(msg)
            yield from _walk(path, item, full + "/", depth + 1)
        elif isinstance(item, h5py.Dataset):
            if item.is_virtual or item.external:
                msg = f"{path}: the data of {full} lie in other files, which is refused"
                raise StoreError(msg)
            yield full, item


def _only_dimension(item: h5py.Dataset) -> bool:
    name = item.attrs.get("NAME", b"")
    return bytes(name).startswith(_NO_COORDINATES[:40].encode()) if isinstance(name, bytes) else False


def _load(item: h5py.Dataset) -> Dataset:
    values = item[()]
    string = h5py.check_string_dtype(item.dtype)
    if string is not None:
        values = np.strings.decode(np.asarray(values, dtype=np.bytes_), "utf-8")
    elif _as_text(item.attrs.get("dtype")) == "bool":
        values = values.view(np.bool_)
    scales = [item.dims[i].keys() for i in range(item.ndim)]
    own = item.name.lstrip("/")
    dims = tuple(item.dims[i][0].name.lstrip("/") if keys else own for i, keys in enumerate(scales))
    return Dataset(values, dims, _as_text(item.attrs.get("units")), _as_text(item.attrs.get("long_name")))


def _as_text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else value if isinstance(value, str) else ""


def _attributes(group: h5py.Group, prefix: str = "") -> Iterator[tuple[str, Attribute]]:
    for name, value in group.attrs.items():
        if isinstance(value, (bytes, str)):
            yield prefix + name, _as_text(value)
        elif isinstance(value, np.uint8):
            yield prefix + name, bool(value)
        elif isinstance(value, np.generic):
            yield prefix + name, value.item()
    for name in group:
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.HardLink) and group.get(name, getclass=True) is h5py.Group:
            yield from _attributes(group[name], f"{prefix}{name}/")


def read_array(path: str | Path, dataset: str, shape: tuple[int, ...] | None = None) -> NDArray[np.float64]:
    """A dataset of real numbers from a user's own HDF5 file.

    Parameters
    ----------
    path, dataset : where.
    shape : refused if it has another; looked at before anything is loaded.

    Raises
    ------
    StoreError
        If it is not there, damaged, no array of real numbers, of another shape, or stored elsewhere.
    """
    path = Path(path)
    with _opened(path) as file:
        found = dict(_walk(path, file))
        item = found.get(dataset.strip("/"))
        if item is None:
            names = ", ".join(list(found)[:10]) or "none"
            msg = f"{path}: there is no dataset {dataset!r}; datasets: {names}"
            raise StoreError(msg)
        if item.dtype.kind not in "iuf":
            msg = f"{path}: dataset {dataset!r} holds {item.dtype}, not real numbers"
            raise StoreError(msg)
        if shape is not None and item.shape != shape:
            msg = f"{path}: dataset {dataset!r} has shape {item.shape}, expected {shape}"
            raise StoreError(msg)
        values: NDArray[np.float64] = item[()].astype(np.float64)
        return values


def read_part(path: str | Path, dataset: str, index: int) -> NDArray[Any] | None:
    """One entry along the first dimension of a dataset of numbers, such as a field of one step; None without it.

    Raises
    ------
    StoreError
        If the file is missing or damaged.
    """
    path = Path(path)
    with _opened(path) as file:
        item = dict(_walk(path, file)).get(dataset)
        return None if item is None else np.asarray(item[index])


def pack(masks: ArrayLike) -> NDArray[np.uint8]:
    """Eight points of the last dimension in a byte: (..., ny) booleans become (..., (ny + 7) // 8) bytes."""
    return np.packbits(np.asarray(masks, dtype=np.bool_), axis=-1)


def unpack(packed: NDArray[np.uint8], ny: int) -> NDArray[np.bool_]:
    """The masks that :func:`pack` was given, with ``ny`` points along the last dimension."""
    return np.unpackbits(packed, axis=-1, count=ny).view(np.bool_)
