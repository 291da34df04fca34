"""Stored runs as datasets of xarray: named axes, maps of contact as booleans, words of a closed set as CF flags.

Maps and fields are read where they are indexed, of one file or of many.  xarray takes a while to import, so that only
functions that return a dataset import this module.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from continuum.store import datasets as store
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import StoreError, member, opened, understood
from continuum.store.runs.record import FLAGS, MAPS, XARRAY_NAMES, Point

_BITS = 8
"""Points in a byte of a packed map, along its last axis, the first in the highest bit."""


class StoredMaps(BackendArray):
    """A dataset of each of several files, read where it is indexed.

    Parameters
    ----------
    paths : the files, an array of any shape; None where there is none, as of a system that is not done.
    name : of the dataset.
    shape : of it in each file, with its points where a byte holds eight; a file may have fewer along the first axis.
    dtype : bool of packed maps, or float32 of them where some are missing; that of the dataset of others.
    packed : whether a byte holds eight points of the last axis.
    """

    def __init__(
        self, paths: NDArray[Any], name: str, shape: tuple[int, ...], dtype: type[np.generic], *, packed: bool
    ) -> None:
        self._paths, self._name, self._packed = paths, name, packed
        self.shape = (*paths.shape, *shape)
        self.dtype = np.dtype(dtype)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[int | slice | NDArray[Any], ...]) -> NDArray[Any]:
        outer = self._paths.ndim
        chosen: Any = np.asarray(along_each(self._paths, key[:outer]), dtype=object)
        parts = [_bounds(each, length) for each, length in zip(key[outer:], self.shape[outer:], strict=True)]
        read, inside = [part[0] for part in parts], tuple(part[1] for part in parts)
        missing = np.nan if self.dtype.kind == "f" else 0
        empty = np.full([one.stop - one.start for one in read], missing, self.dtype)
        found = np.empty((*chosen.shape, *along_each(empty, inside).shape), self.dtype)
        for place in np.ndindex(chosen.shape):
            whole = empty
            path: Path | None = chosen[place]
            if path is not None:
                stored = self._of(path, read)
                whole = empty.copy()
                whole[tuple(map(slice, stored.shape))] = stored
            found[place] = along_each(whole, inside)
        return found

    def _of(self, path: Path, read: Sequence[slice]) -> NDArray[Any]:
        """The part of the dataset of a file that has all that is asked for."""
        last = read[-1]
        bits = slice(last.start // _BITS, -(-last.stop // _BITS))
        with opened(path) as file:
            item = member(path, file, self._name)
            inner = self.shape[self._paths.ndim :]
            bytes_of_last = -(-inner[-1] // _BITS) if self._packed else inner[-1]
            if item is None or item.shape[1:] != (*inner[1:-1], bytes_of_last)[: len(inner) - 1]:
                raise StoreError(f"{path}: holds no map {self._name!r} of the points of this grid")
            stored: NDArray[Any] = item[(*read[:-1], bits if self._packed else last)]
        if self._packed:
            first = bits.start * _BITS
            stored = np.unpackbits(stored, axis=-1)[..., last.start - first : last.stop - first]
        return stored


def along_each(values: NDArray[Any], key: Sequence[Any]) -> NDArray[Any]:
    """Index each axis by itself, the last first, as numbers remove theirs."""
    for axis in reversed(range(len(key))):
        values = values[(*[slice(None)] * axis, key[axis])]
    return values


def _bounds(key: Any, length: int) -> tuple[slice, Any]:
    """The smallest part of an axis that holds all that is asked for, and where it is in that part."""
    if isinstance(key, slice):
        key = np.arange(length)[key]
    places = np.asarray(key)
    first = int(places.min(initial=length)) if places.size else 0
    return slice(first, int(places.max(initial=-1)) + 1 if places.size else 0), key - first


def lazily(
    paths: NDArray[Any], name: str, dims: tuple[str, ...], shape: tuple[int, ...], dtype: type[np.generic], units: str,
    long_name: str, *, packed: bool = False,
) -> xarray.Variable:  # fmt: skip
    """A variable of :class:`StoredMaps`."""
    held = StoredMaps(paths, name, shape, dtype, packed=packed)
    return xarray.Variable(dims, indexing.LazilyIndexedArray(held), {"units": units, "long_name": long_name})


def variable(held: Dataset, flags: Mapping[str, Sequence[str]], name: str) -> xarray.Variable:
    """A dataset with its unit and meaning.

    Parameters
    ----------
    flags : for words of a closed set its possible values; it becomes an integer with the attributes ``flag_values`` and
        ``flag_meanings`` of the CF conventions (section 3.5), -1 where a file holds another word.
    """
    if name not in flags:
        return xarray.Variable(held.dims, held.values, {"units": held.units, "long_name": held.long_name})
    meanings = flags[name]
    named = {"flag_values": np.arange(len(meanings), dtype=np.int8), "flag_meanings": " ".join(meanings)}
    return xarray.Variable(held.dims, _codes(held.values, meanings), {"long_name": held.long_name, **named})


def _codes(words: ArrayLike, meanings: Sequence[str]) -> NDArray[np.int8]:
    codes = {meaning: i for i, meaning in enumerate(meanings)}
    return np.array([codes.get(str(word), -1) for word in np.asarray(words)], dtype=np.int8)


def dataset_of(path: Path, points: Sequence[Point], attributes: Mapping[str, Any]) -> xarray.Dataset:
    """The points, maps and fields of a run, with the axes step, x and y."""
    held = store.columns(points, "step") if points else {}
    found = {XARRAY_NAMES.get(name, name): variable(each, FLAGS, name) for name, each in held.items()}
    found |= maps_of(np.array(path, dtype=object), (), len(points), complete=True)
    found["step"] = xarray.Variable(("step",), np.arange(len(points)), {"long_name": "point of the path"})
    said = {name: value for name, value in attributes.items() if "/" not in name}
    # netCDF has no booleans as attributes.
    return xarray.Dataset(found, attrs={k: int(v) if isinstance(v, bool | np.bool_) else v for k, v in said.items()})


def maps_of(paths: NDArray[Any], dims: tuple[str, ...], steps: int, *, complete: bool) -> dict[str, xarray.Variable]:
    """The maps and fields of runs on one grid, with the positions along x and y, as variables.

    Parameters
    ----------
    paths : files of the runs, one at least, an array over ``dims``; None where there is none.
    steps : largest number of points of their paths.
    complete : whether each has a file with so many; else maps of contact are float32, and NaN is where one is missing.
    """
    first: Path = next(path for path in paths.flat if path is not None)
    found = dict[str, xarray.Variable]()
    with opened(first) as file, understood(first):
        for name in ("x", "y"):
            found[name] = xarray.Variable(
                (name,), file[name][()], {"units": "a0", "long_name": f"position along {name}"}
            )
        length = {"step": steps, "x": found["x"].size, "y": found["y"].size}
        for name, one in MAPS.items():
            if (item := member(first, file, name)) is not None:
                dtype = item.dtype.type if not one.packed else np.bool_ if complete else np.float32
                shape = tuple(length[dim] for dim in one.dims)
                words = one.units, one.long_name
                found[name] = lazily(paths, name, (*dims, *one.dims), shape, dtype, *words, packed=one.packed)
    return found
