"""Stored results as xarray has them: named axes, maps of contact as booleans, words of a closed set as CF flags.

Nothing is read before it is used.  xarray is an extra, so that only functions that return a dataset import this
module.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

PACKED = "_byte"
"""End of the name of an axis along which a byte holds eight points, the first in its highest bit."""


def open_labelled(path: Path, flags: Mapping[str, Sequence[str]]) -> xarray.Dataset:
    """Open a stored result.

    Parameters
    ----------
    path : the HDF5 file.
    flags : for a variable of words its possible values; it becomes an integer with the attributes ``flag_values`` and
        ``flag_meanings`` of the CF conventions (section 3.5), -1 where a file holds another word.
    """
    data = xarray.open_dataset(path, engine="h5netcdf")
    changed = {
        str(name): _mask(variable.variable, data.sizes[str(variable.dims[-1]).removesuffix(PACKED)])
        for name, variable in data.data_vars.items()
        if variable.dims and str(variable.dims[-1]).endswith(PACKED)
    }
    changed |= {name: _flags(data[name].variable, meanings) for name, meanings in flags.items() if name in data}
    return data.assign(changed)


def _mask(packed: xarray.Variable, length: int) -> xarray.Variable:
    dims = (*packed.dims[:-1], str(packed.dims[-1]).removesuffix(PACKED))
    name = str(packed.attrs["long_name"]).partition(",")[0]  # the rest says how the points are packed
    attributes = packed.attrs | {"long_name": name}
    return xarray.Variable(dims, indexing.LazilyIndexedArray(_Unpacked(packed, length)), attributes)


class _Unpacked(BackendArray):
    """Bits of stored bytes, read and unpacked when they are indexed."""

    def __init__(self, packed: xarray.Variable, length: int) -> None:
        self._packed = packed
        self.shape = (*packed.shape[:-1], length)
        self.dtype = np.dtype(bool)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[int | slice, ...]) -> NDArray[np.bool_]:
        packed = np.asarray(self._packed[key[:-1]].values)
        points = np.unpackbits(packed, axis=-1, count=self.shape[-1]).astype(np.bool_)
        return points[..., key[-1]]


def _flags(words: xarray.Variable, meanings: Sequence[str]) -> xarray.Variable:
    codes = {meaning: i for i, meaning in enumerate(meanings)}
    values = np.array([codes.get(str(word), -1) for word in words.values], dtype=np.int8)
    attributes = {name: value for name, value in words.attrs.items() if name != "units"}
    named = {"flag_values": np.arange(len(meanings), dtype=np.int8), "flag_meanings": " ".join(meanings)}
    return xarray.Variable(words.dims, values, attributes | named)
