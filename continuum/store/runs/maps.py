"""Stored runs as datasets of xarray: the numbers of each point, and maps and fields, which are read when used."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from continuum.store import datasets as store
from continuum.store.hdf5 import member, opened, understood
from continuum.store.labelled import lazily, variable
from continuum.store.runs.record import FLAGS, MAPS, XARRAY_NAMES, Point


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
