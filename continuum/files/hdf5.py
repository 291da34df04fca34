"""Write HDF5 files completely or not at all, and read them safely whoever wrote them.

Soft and external links, external storage and virtual datasets, which lead to other files, are refused where one is
read; what else a file contains does not matter.  These, and whatever is missing, damaged or of another kind, raise
StoreError.  A file that cannot be written raises OutputError and leaves an older file of that name unchanged.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from continuum.errors import InputError
from continuum.files.output import whole

_FORMAT = ("v110", "v110")  # the oldest with sums on its headers; HDF5 1.10 (2016) and later read it
_DEEPEST = 8  # groups in groups; a group may hold itself


class StoreError(InputError, OSError):
    """A file cannot be read: missing, damaged, of another kind, or refused.  The message says which."""


@contextmanager
def created(path: str | Path) -> Iterator[h5py.File]:
    """Open a new file, which gets its name only when it is complete and on the disk, and is removed otherwise."""
    with whole(path) as raw:
        disk = _Disk(raw)
        try:
            with h5py.File(disk, "w", libver=_FORMAT) as file:
                yield file
        except Exception:
            if disk.failure is None:
                raise
        if disk.failure is not None:
            raise disk.failure


class _Disk:
    """The file that HDF5 writes to.

    HDF5 crashes at exit if a write has failed, as on a full disk: errors are therefore kept in ``failure``, and HDF5
    gets none.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.failure: OSError | None = None

    def write(self, data: memoryview) -> int:
        self._do(self._file.write, data)
        return len(data)

    def read(self, size: int) -> bytes:
        return self._do(self._file.read, size) or bytes(size)

    def seek(self, offset: int, whence: int = 0) -> int:
        self._do(self._file.seek, offset, whence)  # writes what is waiting
        return offset

    def tell(self) -> int:
        return self._file.tell()

    def truncate(self, size: int) -> None:
        self._do(self._file.truncate, size)

    def flush(self) -> None:
        self._do(self._file.flush)

    def _do(self, call: Callable[..., Any], *arguments: object) -> Any:
        if self.failure is None:
            try:
                return call(*arguments)
            except OSError as error:
                self.failure = error
        return None


@contextmanager
def opened(path: str | Path) -> Iterator[h5py.File]:
    """Open a file for reading; whatever h5py raises on a damaged file becomes a StoreError."""
    if not Path(path).is_file():
        raise StoreError(f"{path}: {'a folder, not a file' if Path(path).is_dir() else 'there is no such file'}")
    try:
        # Files are replaced, never changed, so locks protect nothing and read-only folders need none.
        file = h5py.File(path, "r", locking=False)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise StoreError(f"{path}: not an HDF5 file, or damaged or truncated ({error})") from error
    with file:
        try:
            yield file
        except StoreError:
            raise
        except (OSError, RuntimeError, ValueError, LookupError, TypeError, AttributeError, MemoryError) as error:
            raise StoreError(f"{path}: cannot be read, probably damaged ({error})") from error


def datasets_in(path: str | Path, group: h5py.Group, prefix: str = "") -> Iterator[tuple[str, h5py.Dataset]]:
    """Every dataset of a file; external, virtual and undecodable ones are refused."""
    for name in group:
        item = _item(path, group, name, prefix + name)
        if isinstance(item, h5py.Group):
            if prefix.count("/") > _DEEPEST:
                raise StoreError(f"{path}: groups are nested too deep at {prefix + name}")
            yield from datasets_in(path, item, f"{prefix}{name}/")
        elif isinstance(item, h5py.Dataset):
            yield prefix + name, item


def _item(path: str | Path, group: h5py.Group, name: str, full: str) -> Any:
    """The member of a group of this name; refused if it lies in another file."""
    link = group.get(name, getlink=True)
    if not isinstance(link, h5py.HardLink):
        raise StoreError(f"{path}: {full} is a link to elsewhere ({type(link).__name__}), which is refused")
    item = group[name]
    if isinstance(item, h5py.Dataset) and (item.is_virtual or item.external):
        raise StoreError(f"{path}: the data of {full} lie in other files, which is refused")
    return item


def member(path: str | Path, file: h5py.File, name: str) -> Any:
    """The dataset or group of a name like ``entry/data/height``; None if there is none."""
    item, passed = file, ""
    for part in filter(None, name.split("/")):
        passed += f"/{part}"
        item = _item(path, item, part, passed[1:]) if isinstance(item, h5py.Group) and part in item else None
    return item


def _names_in(file: h5py.File) -> list[str]:
    """Names of all datasets of a file, including those whose data lie in other files."""
    stored = list[str]()
    file.visit(stored.append)
    return [name for name in stored if file.get(name, getclass=True) is h5py.Dataset]


def only_array(path: str | Path) -> str:
    """Name of the only two-dimensional dataset of numbers in a user's HDF5 file, or else of the only one-dimensional.

    Raises StoreError if there is none, or several: the message names them.
    """
    with opened(path) as file:
        shapes = {name: file[name].shape for name in _names_in(file) if file[name].dtype.kind in "iuf"}
    maps = [name for name, shape in shapes.items() if len(shape) == 2]
    maps = maps or [name for name, shape in shapes.items() if len(shape) == 1]
    if len(maps) == 1:
        return maps[0]
    names = ", ".join(islice(maps or shapes, 10)) or "none"
    why = (
        f"{len(maps)} datasets could be the map: choose one by `dataset`" if maps else "no dataset is a map of numbers"
    )
    raise StoreError(f"{path}: {why}; datasets: {names}")


def read_array(path: str | Path, dataset: str, shape: tuple[int, ...] | None = None) -> NDArray[np.float64]:
    """A dataset of real numbers, as ``entry/data/height``, from a user's own HDF5 file, whatever else is in it.

    A dataset of another shape is refused before anything is loaded.
    """
    with opened(path) as file:
        item = member(path, file, dataset)
        if not isinstance(item, h5py.Dataset):
            names = ", ".join(islice(_names_in(file), 10)) or "none"
            raise StoreError(f"{path}: there is no dataset {dataset!r}; datasets: {names}")
        if item.dtype.kind not in "iuf":
            raise StoreError(f"{path}: dataset {dataset!r} holds {item.dtype}, not real numbers")
        if shape is not None and item.shape != shape:
            raise StoreError(f"{path}: dataset {dataset!r} has shape {item.shape}, expected {shape}")
        values: NDArray[np.float64] = item[()].astype(np.float64)
        return values
