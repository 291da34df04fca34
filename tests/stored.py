"""Stored runs, compared; and runs that are stopped."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import xarray

from continuum.store import datasets as store
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point

ENGINES = [
    "h5netcdf",
    pytest.param("netcdf4", marks=pytest.mark.skipif(find_spec("netCDF4") is None, reason="netCDF4 is not installed")),
]
"""Readers of netCDF that xarray has; netCDF4 is the default where it is installed."""


def opens_in_xarray(
    path: Path, engine: str | None, schema: str = RunConfig.result_schema, version: int = RunConfig.result_version
) -> None:
    """Every dataset of a file, in its group, has the values, dimensions and units that were stored."""
    file = store.read_datasets(path, schema, version, labels=True)
    for group in {name.rpartition("/")[0] for name in file.datasets}:
        with xarray.open_dataset(path, engine=engine, group=group or None) as data:
            for name, dataset in file.datasets.items():
                if name.rpartition("/")[0] == group:
                    found = data[name.rpartition("/")[2]]
                    assert found.dims == dataset.dims, name
                    np.testing.assert_array_equal(found.values, dataset.values, err_msg=name)
                    assert found.attrs.get("units", "") == dataset.units, name
    describe_themselves(file)


def describe_themselves(file: store.File) -> None:
    """Every dataset says what it is, and every number its unit: "1", or in words where it is that of another one."""
    assert file.datasets
    for name, dataset in file.datasets.items():
        assert dataset.long_name, name
        assert dataset.units or dataset.values.dtype.kind == "U" or " in " in dataset.long_name, name


def content(path: Path) -> dict[str, np.ndarray]:
    """Everything that must be reproducible: all but the journal."""
    file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version)
    assert file.attributes["finished"]
    return {n: d.values for n, d in file.datasets.items() if not n.startswith("journal/")}


def same(a: Path, b: Path) -> None:
    one, other = content(a), content(b)
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def stop_after(points: int, error: type[BaseException]) -> Callable[[Point, int, int], None]:
    """A progress that raises after so many points."""

    def progress(point: Point, done: int, total: int) -> None:
        if done == points:
            raise error

    return progress
