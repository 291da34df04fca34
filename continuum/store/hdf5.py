"""Write HDF5 files completely or not at all, and read them safely whoever wrote them.

Soft and external links, external storage and virtual datasets, which lead to other files, are refused where one is
read; what else a file contains does not matter.  These, and whatever is missing, damaged or of another kind, raise
StoreError.  A file that cannot be written raises OutputError and leaves an older file of that name unchanged.
"""

import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import h5py
import numpy as np
from h5py import h5ds, h5l
from numpy.typing import NDArray

from continuum.inputs.errors import InputError
from continuum.store.output import whole

_FORMAT = ("v110", "v110")  # the oldest with sums on its headers; HDF5 1.10 (2016) and later read it
NO_VALUES = "This is a netCDF dimension but not a netCDF variable."
"""With what netCDF begins the name of a dimension that has a length only."""
_DEEPEST = 8  # groups in groups; a group may hold itself


_LOCKING = ("best-effort", False, True)
"""Ways to lock a file: ours, which does without locks where a disk has none, and those of whoever holds it already, as
HDF5 opens a file twice in one process only in the same way."""


class StoreError(InputError, OSError):
    """A file cannot be read, because it is missing, damaged, of another kind, or refused."""


class UnreadError(StoreError):
    """A file cannot be read now: open elsewhere, no permission, no memory, a disk that fails.  It may be sound."""


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
    with _open(path) as file, understood(path):
        yield file


def _open(path: str | Path) -> h5py.File:
    for locking in _LOCKING:
        try:
            if not stat.S_ISREG(Path(path).stat().st_mode):
                break
            return h5py.File(path, "r", locking=locking)
        except (FileNotFoundError, NotADirectoryError) as error:
            raise StoreError(f"{path}: there is no such file") from error
        except (OSError, RuntimeError, ValueError, KeyError, MemoryError) as error:
            if locking == _LOCKING[-1] or "flag values don't match" not in str(error):
                raise _error(path, error, "not an HDF5 file, or damaged or truncated") from error
    raise StoreError(f"{path}: a folder or a device, not a file")


def _error(path: str | Path, error: Exception, of_content: str) -> StoreError:
    """The error for a failure to read, which is of the content of the file unless the system has failed."""
    if isinstance(error, BlockingIOError):
        return UnreadError(f"{path}: another program has it open to write; try again when that has ended")
    if isinstance(error, MemoryError):
        return UnreadError(f"{path}: not enough memory to read it ({error})")
    if isinstance(error, OSError) and error.errno is not None:
        return UnreadError(f"{path}: cannot be read now: {os.strerror(error.errno)}")
    return StoreError(f"{path}: {of_content} ({error})")


@contextmanager
def understood(path: str | Path) -> Iterator[None]:
    """Make sense of what was read from a file; whatever that raises becomes a StoreError, as the file is at fault."""
    try:
        yield
    except StoreError:
        raise
    except (
        OSError,
        RuntimeError,
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        MemoryError,
        ArithmeticError,
    ) as error:
        raise _error(path, error, "cannot be read, probably damaged") from error


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


def lies_here(group: h5py.Group, name: str) -> bool:
    """Whether a member lies in this file, by no link to elsewhere; asked in half the time of h5py's own question."""
    return bool(group.id.links.get_info(name.encode()).type == h5l.TYPE_HARD)


def _item(path: str | Path, group: h5py.Group, name: str, full: str) -> Any:
    """The member of a group of this name; refused if it lies in another file."""
    if not lies_here(group, name):
        raise StoreError(f"{path}: {full} is a link to elsewhere, which is refused")
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


class RawAxis(NamedTuple):
    """An axis of a dataset: its name, and positions along it with their attributes, if it has any."""

    name: str = ""
    values: NDArray[np.float64] | None = None
    attributes: Mapping[str, Any] = {}


class RawDataset(NamedTuple):
    """A dataset of real numbers of a user's file, with its attributes and axes."""

    values: NDArray[np.float64]
    attributes: Mapping[str, Any]
    axes: tuple[RawAxis, ...]


def only_array(path: str | Path) -> str:
    """Name of the only two-dimensional dataset of numbers in a user's HDF5 or netCDF file, or else of the only
    one-dimensional.

    Raises StoreError if there is none, or several: the message names them.
    """
    shapes: dict[str, tuple[int, ...]]
    if _is_classic(path):
        with _classic(path) as old:
            shapes = {name: one.shape for name, one in old.variables.items() if one.data.dtype.kind in "iuf"}
    else:
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


def read_dataset(
    path: str | Path, name: str, check: Callable[[tuple[int, ...]], None] = lambda shape: None
) -> RawDataset:
    """A dataset of real numbers, as ``entry/data/height``, from a user's own file, whatever else is in it.

    Parameters
    ----------
    path : an HDF5 file, thus also netCDF 4, or a classic netCDF file.
    check : called with the shape of the dataset before its values are loaded.
    """
    if _is_classic(path):
        with _classic(path) as old:
            if name not in old.variables:
                raise StoreError(f"{path}: there is no dataset {name!r}; datasets: {', '.join(old.variables)}")
            one = old.variables[name]
            check(one.shape)
            axes = tuple(_classic_axis(old, dimension) for dimension in one.dimensions)
            return RawDataset(one.data.astype(np.float64), dict(vars(one)["_attributes"]), axes)
    with opened(path) as file:
        item = member(path, file, name)
        if not isinstance(item, h5py.Dataset):
            names = ", ".join(islice(_names_in(file), 10)) or "none"
            raise StoreError(f"{path}: there is no dataset {name!r}; datasets: {names}")
        if item.dtype.kind not in "iuf":
            raise StoreError(f"{path}: dataset {name!r} holds {item.dtype}, not real numbers")
        check(item.shape)
        return RawDataset(item[()].astype(np.float64), dict(item.attrs), tuple(map(_axis, item.dims)))


def _axis(dimension: Any) -> RawAxis:
    """An axis of an HDF5 dataset, with the first of its scales."""
    name, scale = next(iter(dimension.items()), (dimension.label, None))
    name = dimension.label or name.rpartition("/")[2]
    if scale is None or scale.is_virtual or scale.external or has_no_values(scale):
        return RawAxis(name)
    if scale.ndim != 1 or scale.dtype.kind not in "iuf":
        return RawAxis(name)
    return RawAxis(name, scale[()].astype(np.float64), dict(scale.attrs))


def has_no_values(item: h5py.Dataset) -> bool:
    """Whether it is a dimension of netCDF without positions."""
    return h5ds.is_scale(item.id) and NO_VALUES in str(item.attrs.get("NAME", ""))


def _is_classic(path: str | Path) -> bool:
    """Whether it is a classic netCDF file, which is no HDF5."""
    if not Path(path).is_file():
        return False
    with Path(path).open("rb") as file:
        return file.read(3) == b"CDF"


@contextmanager
def _classic(path: str | Path) -> Iterator[Any]:
    """Open a classic netCDF file for reading."""
    from scipy.io import netcdf_file  # takes a while to import, and few need it

    try:
        with netcdf_file(path, mmap=False) as file:
            yield file
    except StoreError:
        raise
    except (OSError, ValueError, TypeError, LookupError, AssertionError, AttributeError) as error:
        raise StoreError(f"{path}: cannot be read, probably damaged ({error})") from error


def _classic_axis(file: Any, name: str) -> RawAxis:
    scale = file.variables.get(name)
    if scale is None or len(scale.shape) != 1 or scale.data.dtype.kind not in "iuf":
        return RawAxis(name)
    return RawAxis(name, scale.data.astype(np.float64), dict(vars(scale)["_attributes"]))
