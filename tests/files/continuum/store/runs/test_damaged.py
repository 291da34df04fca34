"""A damaged result is read, or its reader says that it is damaged: whatever is missing, cut off, or of another kind."""

from __future__ import annotations

import json
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from continuum.inputs.errors import OutputError
from continuum.inputs.reading import load
from continuum.store.hdf5 import StoreError
from continuum.store.runs.config import RunConfig
from continuum.store.runs.result import Result
from continuum.store.runs.run import follow_run
from continuum.store.sweeps.measured import ADDED, numbers_of
from continuum.view.states import OpenedResults

RUN: dict[str, Any] = {
    "grid": {"n": 32},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.02, "lambda_s": 8.0, "lambda_L": 16.0, "seed": 1},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.05},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "repulsive-area", "targets": [0.05, 0.2], "area_tolerance": 0.05, "area_resolution": 0.02},
    "output": {"fields": True},
}
OF_DATASETS = ("missing", "cut", "empty", "words", "numbers", "nan", "deeper", "scalar", "a group")
OF_ATTRIBUTES = ("missing", "word", "number", "array", "brackets")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with a jump, and the numbers that a sweep adds."""
    path = tmp_path_factory.mktemp("damaged") / "run.h5"
    assert follow_run(load(RUN, RunConfig), path, added=ADDED).events
    return path


def damage_dataset(file: h5py.File, name: str, how: str) -> None:
    old = file[name]
    values, said = old[()], {key: old.attrs[key] for key in ("units", "long_name", "dtype") if key in old.attrs}
    del file[name]
    if how == "a group":
        file.create_group(name)
    elif how != "missing":
        other = {
            "cut": values[:-1],
            "empty": values[:0],
            "words": np.full(values.shape, b"word"),
            "numbers": np.full(values.shape, 7.5),
            "nan": np.full(values.shape, np.nan),
            "deeper": np.full((*values.shape, 2), 1.0),
            "scalar": np.float64(3),
        }[how]
        file[name] = other
        file[name].attrs.update(said)


def damage_attribute(owner: h5py.Group, name: str, how: str) -> None:
    del owner.attrs[name]
    if how != "missing":
        other = {"word": "word", "number": -7.5, "array": np.arange(3), "brackets": "[" * 5000}
        owner.attrs[name] = other[how]


@cache
def damages(path: Path) -> list[tuple[str, str, str]]:
    """All damages: of a dataset, or of an attribute of a group, by its name."""
    found: list[tuple[str, str, str]] = []

    def look(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if isinstance(item, h5py.Dataset):
            found.extend((name, "", how) for how in OF_DATASETS)
        else:
            found.extend((name, key, how) for key in item.attrs for how in OF_ATTRIBUTES)

    with h5py.File(path) as file:
        file.visititems(look)
        look("/", file)
    return found


def damaged(whole: Path, name: str, key: str, how: str) -> Path:
    path = whole.with_name("damaged.h5")
    path.write_bytes(whole.read_bytes())
    with h5py.File(path, "r+") as file:
        if key:
            damage_attribute(file[name], key, how)
        else:
            damage_dataset(file, name, how)
    return path


def read_all(path: Path) -> None:
    """What people and the page of `continuum view` read of a result, and what a sweep does."""
    with suppress(StoreError):
        numbers_of(path)
    with suppress(StoreError):
        result = Result.read(path)
        result.sheets()
        result.contact_map(len(result.points) - 1)
        result.gap(0)
        result.analyse().sheets()
    with suppress(StoreError):
        assert json.dumps(OpenedResults.of(path).states(0), allow_nan=False)


@settings(max_examples=16)
@given(st.data())
def test_a_damaged_result_is_read_or_said_to_be_damaged(whole: Path, data: st.DataObject) -> None:
    read_all(damaged(whole, *data.draw(st.sampled_from(damages(whole)))))


@pytest.mark.parametrize("name", ["load", "events/step", "restart/control"])
def test_a_run_does_not_go_on_with_what_is_damaged(whole: Path, name: str) -> None:
    path = damaged(whole, name, "", "missing")
    before = path.read_bytes()
    with pytest.raises(OutputError, match=r"damaged[^\n]*\n    Choose another folder with --output, or start anew"):
        follow_run(load(RUN, RunConfig), path)
    assert path.read_bytes() == before
