"""Results on disk: one HDF5 file each, written whole or not at all.
A file is a mapping of names to :class:`Dataset` (arrays with named dimensions) and of names to attributes
(numbers and text).  A name ``group/name`` lies in a group; ``journal`` holds times, hosts and dates; everything
outside it is reproducible bit for bit.  A dataset that is named as a dimension holds its coordinates.  xarray opens a
file with the same names, by either of its engines: ``xarray.open_dataset(path)``.

Damage is detected: datasets of numbers have a Fletcher-32 checksum, those of text, which HDF5 keeps elsewhere in the
file, the attribute ``crc32``, and the file format has checksums of its headers, which is also why attributes of text
have a fixed length.  Errors are those of :mod:`continuum.store.hdf5`.
"""

import zlib
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5ds, h5o, h5s, h5t
from numpy.typing import ArrayLike, NDArray

from continuum.inputs.errors import OutputError
from continuum.model.shared_grid import Company
from continuum.store.hdf5 import (
    NO_VALUES,
    StoreError,
    UnreadError,
    created,
    datasets_in,
    has_no_values,
    lies_here,
    member,
    opened,
)

Attribute = bool | int | float | str

_CHUNK = 4 * 1024 * 1024  # bytes
_SUM = "crc32"


class DividedArray:
    """An array of which each process has rows, shape (..., rows, columns): its values in a dataset.

    Parameters
    ----------
    own : the rows of this process.
    company : the processes, which all write at the same time: the first one the file, the others by :func:`hand_over`.
    """

    def __init__(self, own: NDArray[Any], company: Company) -> None:
        *first, rows, columns = own.shape
        self.shape, self.dtype, self.ndim = (*first, rows * company.size, columns), own.dtype, own.ndim
        self.size = own.size * company.size
        self._own, self._company = own, company

    def blocks(self) -> Iterator[tuple[tuple[Any, ...], NDArray[Any]]]:
        """Place and values of some rows of each process in turn, in all processes."""
        *first, rows, columns = self._own.shape
        step = max(1, _CHUNK // max(1, self._own.itemsize * columns))
        for index in np.ndindex(*first):
            for a in range(0, rows, step):
                b = min(a + step, rows)
                for rank, block in enumerate(self._company.gather(np.ascontiguousarray(self._own[index][a:b]))):
                    yield (*index, slice(rank * rows + a, rank * rows + b)), block


@dataclass(frozen=True, eq=False)
class Dataset:
    """An array with named dimensions.

    Parameters
    ----------
    values : numbers, booleans or text (an array of str); or :class:`DividedArray` of numbers.
    dims : name of each dimension, at least one; none of what was read without labels.
    units : "a0", "E*", "1" for a pure number, "" where units have no meaning (text).
    long_name : what it is, in words.
    """

    values: Any = field(repr=False)
    dims: tuple[str, ...]
    units: str = ""
    long_name: str = ""

    def __post_init__(self) -> None:
        values = self.values if isinstance(self.values, DividedArray) else np.asarray(self.values)
        if values.dtype.kind not in "biufUT":
            raise TypeError(f"a dataset holds numbers, booleans or text, not {values.dtype}")
        if values.ndim != len(self.dims or values.shape) or values.ndim == 0:
            raise ValueError(f"an array of shape {values.shape} does not have the dimensions {self.dims}")
        object.__setattr__(self, "values", values)


class _Named(dict[str, Any]):
    """Content of a file by name; a name that it lacks is damage."""

    def __init__(self, path: str | Path, held: Mapping[str, Any]) -> None:
        super().__init__(held)
        self._path = path

    def __missing__(self, name: str) -> Any:
        raise StoreError(f"{self._path}: lacks {name}, so that it is probably damaged")


@dataclass(frozen=True, eq=False)
class File:
    """Datasets and attributes of a stored file; one that it lacks raises StoreError where it is asked for."""

    datasets: Mapping[str, Dataset]
    attributes: Mapping[str, Attribute]

    def __getitem__(self, name: str) -> NDArray[Any]:
        values: NDArray[Any] = self.datasets[name].values
        return values


def columns(records: Sequence[Any], dim: str) -> dict[str, Dataset]:
    """The numbers of records of one class, at least one, as datasets along a dimension.

    Its fields have units and description as metadata (:func:`continuum.measure.contact.quantity`); others are left out.
    """
    return {
        column.name: Dataset(np.array([getattr(one, column.name) for one in records]), (dim,), **column.metadata)
        for column in fields(records[0])
        if column.metadata
    }


def write(path: str | Path, datasets: Mapping[str, Dataset], attributes: Mapping[str, Attribute]) -> None:
    """Write a file into a folder that exists: complete under its name, or not at all, whatever interrupts.

    Raises ValueError if the attributes ``schema`` (text) and ``schema_version`` (a whole number) are not there, or two
    datasets differ in the length of a dimension.
    """
    if not isinstance(attributes.get("schema"), str) or not isinstance(attributes.get("schema_version"), int):
        raise ValueError('a file names its "schema" (text) and "schema_version" (a whole number)')
    lengths: dict[str, int] = {}
    for name, dataset in datasets.items():
        for dim, length in zip(dataset.dims, dataset.values.shape, strict=True):
            if lengths.setdefault(dim, length) != length:
                raise ValueError(f"dimension {dim} of {name} has {length} entries, elsewhere it has {lengths[dim]}")
    with created(path) as file:
        _fill(file, datasets, attributes, lengths)


def hand_over(datasets: Mapping[str, Dataset]) -> None:
    """Give the rows of this process to the first one, which writes these datasets at the same time."""
    for dataset in datasets.values():
        if isinstance(dataset.values, DividedArray):
            deque(dataset.values.blocks(), maxlen=0)


def _fill(
    file: h5py.File,
    datasets: Mapping[str, Dataset],
    attributes: Mapping[str, Attribute],
    lengths: Mapping[str, int],
) -> None:
    stored = dict[str, h5py.Dataset]()
    for name, dataset in datasets.items():
        stored[name] = _create(file, name, dataset.values)
        _attach(stored[name], "units", _text(dataset.units))
        _attach(stored[name], "long_name", _text(dataset.long_name))
        if dataset.values.dtype.kind in "UT":
            _attach(stored[name], _SUM, np.asarray(_number(_sum_of(dataset.values))))
        if dataset.values.dtype.kind == "b":
            _attach(stored[name], "dtype", _text("bool"))  # xarray then gives booleans
    for dim, length in lengths.items():
        if dim in datasets:
            stored[dim].make_scale(dim)
        else:
            stored[dim] = _create(file, dim, np.zeros(length, dtype=np.uint8))
            stored[dim].make_scale(f"{NO_VALUES} {length:10d}")
    for name, dataset in datasets.items():
        if dataset.dims != (name,):
            for i, dim in enumerate(dataset.dims):
                h5ds.attach_scale(stored[name].id, stored[dim].id, i)
    for name, value in attributes.items():
        group, _, key = name.rpartition("/")
        owner = file.require_group(group) if group else file
        _attach(owner, key, _text(value) if isinstance(value, str) else np.asarray(_number(value)))


def _attach(owner: h5py.Group | h5py.Dataset, name: str, value: NDArray[Any]) -> None:
    """Set an attribute of a new object, faster than ``owner.attrs[name] = value``.

    A small run has 200 of them, and is written after each of its points.
    """
    form = h5t.py_create(value.dtype, logical=True)
    h5a.create(owner.id, name.encode(), form, h5s.create_simple(())).write(value)


def _create(file: h5py.File, name: str, values: NDArray[Any] | DividedArray) -> h5py.Dataset:
    if isinstance(values, DividedArray):
        made = file.create_dataset(name, values.shape, values.dtype, chunks=_chunks(values), fletcher32=True)
        for place, block in values.blocks():
            made[place] = block
        return made
    if values.dtype.kind in "UT":  # of any length: only so do all readers of netCDF give str
        return file.create_dataset(name, data=values.astype(object), dtype=h5py.string_dtype())
    if values.dtype.kind == "b":
        values = values.view(np.uint8)
    if values.size == 0:
        return file.create_dataset(name, data=values)  # nothing to sum
    return file.create_dataset(name, data=values, chunks=_chunks(values), fletcher32=True)


def _chunks(values: NDArray[Any] | DividedArray) -> tuple[int, ...]:
    """One step of a map, or a part of it: leading dimensions are cut until a chunk is small."""
    chunks = list(values.shape)
    for i in range(len(chunks)):
        others = values.dtype.itemsize * int(np.prod(chunks[i + 1 :]))
        chunks[i] = max(1, min(chunks[i], _CHUNK // others))
    return tuple(chunks)


def _sum_of(text: NDArray[Any]) -> int:
    """CRC-32 of an array of text."""
    return zlib.crc32("\0".join(text.ravel().tolist()).encode())


def _text(text: str) -> NDArray[Any]:
    encoded = text.encode()
    return np.array(encoded, dtype=h5py.string_dtype("utf-8", max(len(encoded), 1)))


def _number(value: bool | float) -> Any:
    if isinstance(value, bool):
        return np.uint8(value)  # HDF5's booleans are unknown to netCDF; whole numbers are stored as int64
    return np.int64(value) if isinstance(value, int) else np.float64(value)


def read_datasets(
    path: str | Path,
    schema: str,
    version: int,
    names: Collection[str] | None = None,
    *,
    labels: bool = False,
    parts: Mapping[str, Any] = MappingProxyType({}),
) -> File:
    """Read a file of a schema and version: all its datasets, or those of these names that it has.

    Of the datasets that ``parts`` names it reads the part with that index only.
    Their dimensions, units and meanings are read with ``labels`` only, as that takes longer than all the rest.
    """
    with opened(path) as file:
        attributes = dict(_attributes(file))
        found = attributes.get("schema"), attributes.get("schema_version")
        if found != (schema, version):
            what = f"{found[0]} version {found[1]}" if found[0] else "data of another program"
            raise StoreError(f"{path}: holds {what}, expected {schema} version {version}")
        items = dict(datasets_in(path, file) if names is None else _members(path, file, names))
        places = {h5o.get_info(item.id).addr: name for name, item in items.items()} if labels else {}
        datasets = {
            name: _labelled(name, item, places) if labels else Dataset(_values(item, parts.get(name, ())), ())
            for name, item in items.items()
            if not has_no_values(item)
        }
    return File(_Named(path, datasets), _Named(path, attributes))


def schema_of(path: str | Path) -> str | None:
    """The schema of a file, in any version; None if there is no such file, or this program did not write it.

    Raises UnreadError if the file cannot be read now.
    """
    try:
        with opened(path) as file:
            return _as_text(file.attrs.get("schema")) or None
    except UnreadError:
        raise
    except StoreError:
        return None


def earlier(
    path: Path,
    schema: str,
    version: int,
    identity: str,
    *,
    force: bool,
    differences: Callable[[Mapping[str, Attribute]], str] = lambda attributes: "",
    parts: Mapping[str, Any] = MappingProxyType({}),
) -> File | None:
    """The stored result of an earlier call with this identity; None if there is no file.

    With ``force`` also None if the file is another result of that schema, which is then replaced.  Raises OutputError
    if the file is anything else; ``differences`` says how another result differs, by its attributes.  ``parts`` is as
    for :func:`read_datasets`.
    """
    if not path.exists():
        return None
    try:
        found = schema_of(path)
    except UnreadError as error:
        raise OutputError(str(error)) from error
    if found != schema:
        what = f"holds {found}" if found else "is not a result of this program, or is damaged"
        raise OutputError(f"{path}: {what}, and is left alone; move it, or choose another folder with --output")
    if force:
        return None
    try:
        file = read_datasets(path, schema, version, parts=parts)
        same = file.attributes.get("identity") == identity
        fault = "" if same else f"{path}: holds another result{differences(file.attributes)}"
    except UnreadError as error:
        raise OutputError(str(error)) from error
    except StoreError as error:
        fault = str(error)
    if fault:
        raise refused(fault)
    return file


def refused(fault: object) -> OutputError:
    """The error for a stored result that a run cannot continue."""
    return OutputError(f"{fault}\n    Choose another folder with --output, or start anew with --force")


def _values(item: h5py.Dataset, part: Any = ()) -> NDArray[Any]:
    values: NDArray[Any] = item[part]
    if h5py.check_string_dtype(item.dtype) is not None:
        text = np.strings.decode(np.asarray(values, dtype=np.bytes_), "utf-8")
        if item.attrs.get(_SUM, known := _sum_of(text)) != known:  # files of earlier versions have none
            raise ValueError(f"the text of {item.name} is not the one that its checksum was made of")
        return text
    boolean = values.dtype == np.uint8 and "dtype" in item.attrs  # h5py takes long to say that something is not there
    return values.view(np.bool_) if boolean and _as_text(item.attrs["dtype"]) == "bool" else values


def _labelled(name: str, item: h5py.Dataset, places: Mapping[int, str]) -> Dataset:
    dims = tuple(_dimension(item, i, places) or name for i in range(item.ndim))
    return Dataset(_values(item), dims, _as_text(item.attrs.get("units")), _as_text(item.attrs.get("long_name")))


def _dimension(item: h5py.Dataset, number: int, places: Mapping[int, str]) -> str:
    """Name of the dataset that is the scale of a dimension, found by its place in the file; empty if it has none.

    HDF5 itself would search the file for the name, which takes much longer.
    """
    scales: list[Any] = []
    if h5ds.get_num_scales(item.id, number) > 0:
        h5ds.iterate(item.id, number, scales.append, 0)
    return places[h5o.get_info(scales[0]).addr] if scales else ""


def _as_text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else value if isinstance(value, str) else ""


def _plain_values(attributes: Mapping[str, Any]) -> Iterator[tuple[str, Attribute]]:
    for name, value in attributes.items():
        if isinstance(value, (bytes, str)):
            yield name, _as_text(value)
        elif isinstance(value, np.uint8):
            yield name, bool(value)
        elif isinstance(value, np.generic):
            yield name, value.item()


def _attributes(group: h5py.Group, prefix: str = "") -> Iterator[tuple[str, Attribute]]:
    for name, value in _plain_values(group.attrs):
        yield prefix + name, value
    for name in group:
        if lies_here(group, name) and h5o.get_info(group.id, name.encode()).type == h5o.TYPE_GROUP:
            yield from _attributes(group[name], f"{prefix}{name}/")


def dataset_names(path: str | Path) -> tuple[str, ...]:
    """Names of the datasets of a file."""
    with opened(path) as file:
        return tuple(name for name, item in datasets_in(path, file) if not has_no_values(item))


def read_part(path: str | Path, dataset: str, index: int) -> NDArray[Any] | None:
    """One entry along the first dimension of a dataset of numbers, such as the field of one step; None if missing."""
    with opened(path) as file:
        for _, item in _members(path, file, (dataset,)):
            if item.dtype.kind not in "iuf":
                raise StoreError(f"{path}: {dataset} holds no numbers, so that it is probably damaged")
            return np.asarray(item[index])
    return None


def _members(path: str | Path, file: h5py.File, names: Collection[str]) -> Iterator[tuple[str, h5py.Dataset]]:
    """The datasets of these names that a file has; the others are not looked at, which takes most of the time."""
    for name in names:
        if isinstance(item := member(path, file, name), h5py.Dataset):
            yield name, item


def read_few(
    path: str | Path, datasets: Collection[str], attributes: Collection[str]
) -> tuple[dict[str, NDArray[Any]], dict[str, Attribute]]:
    """Values of a few datasets and attributes of a file of any schema; absent ones are left out.

    Dimensions and units are not read, as that would take most of the time.
    """
    with opened(path) as file:
        held = {name: _values(item) for name, item in _members(path, file, datasets)}
        found: dict[str, Attribute] = {}
        for prefix in dict.fromkeys(name.rpartition("/")[0] for name in attributes):
            owner = member(path, file, prefix)
            if isinstance(owner, h5py.Group):
                present = owner.attrs
                keys = [name.rpartition("/")[2] for name in attributes if name.rpartition("/")[0] == prefix]
                some = {key: present[key] for key in keys if key in present}
                found |= {f"{prefix}/{key}" if prefix else key: value for key, value in _plain_values(some)}
        return held, found


def pack(masks: ArrayLike) -> NDArray[np.uint8]:
    """Eight points of the last dimension in a byte: (..., ny) booleans become (..., (ny + 7) // 8) bytes."""
    return np.packbits(np.asarray(masks, dtype=np.bool_), axis=-1)


def unpack(packed: NDArray[np.uint8], ny: int) -> NDArray[np.bool_]:
    """The inverse of :func:`pack`, with ``ny`` points along the last dimension."""
    return np.unpackbits(packed, axis=-1, count=ny).view(np.bool_)
