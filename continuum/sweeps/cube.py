"""The points of a sweep with one dimension for each axis of its input, as in ``table.h5``, which xarray opens."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from continuum.files.store import Dataset
from continuum.sweeps.folder import TABLE_SCHEMA
from continuum.sweeps.measured import COLUMNS

if TYPE_CHECKING:
    from continuum.sweeps.collect import PointTable


def cube_of(found: PointTable) -> tuple[dict[str, Dataset], dict[str, Any]]:
    """The datasets with one dimension for each axis of the input, and ``step``; and the attributes of the whole.

    Keys that change together are one dimension, named after the first.  Missing points are NaN.  A key that is
    searched for has the dimension ``trial``, in the order of its values, which are a variable.
    """
    searches = found.listing.searches
    axes = [axis for axis in found.listing.axes[: -1 if searches else None] if axis.values]
    dims = {axis.keys[0]: len(axis.values) for axis in axes}
    places = [{json.dumps(values): i for i, values in enumerate(axis.values)} for axis in axes]
    of_system = {}
    for key in found.keys:
        values = found._settings[key]
        of_system[key] = tuple(
            place[json.dumps([values[k] for k in axis.keys])] for axis, place in zip(axes, places, strict=True)
        )
    datasets = {}
    for axis in axes:
        for i, key in enumerate(axis.keys):
            column = np.array([as_cell(values[i]) for values in axis.values])
            datasets[key] = Dataset(column, (axis.keys[0],), "", "value of this key of the input")
    if searches:
        dims, of_system = _with_searches(found, datasets, dims, of_system)
    steps = found["step"].astype(int)
    dims = {**dims, "step": int(steps.max(initial=-1)) + 1}
    where = np.array([(*of_system[found.keys[i]], step) for i, step in zip(found.system, steps, strict=True)])
    for name, (unit, what) in found.columns.items():
        datasets[name] = _spread(dims, where, found[name], unit, what)
    datasets["step"] = Dataset(np.arange(dims["step"]), ("step",), "1", COLUMNS["step"][1])
    said = {
        "schema": TABLE_SCHEMA, "schema_version": 1, "name": found.listing.name,
        "common": json.dumps(found.listing.common), "systems": len(found.keys), "systems_missing": found.missing,
        "points": len(found.system), "points_unconverged": found.unconverged, "files_unreadable": len(found.faults),
        "made_with": json.dumps(dict(found.provenance)),
    }  # fmt: skip
    return datasets, said


def _with_searches(
    found: PointTable, datasets: dict[str, Dataset], dims: dict[str, int], of_system: Mapping[str, tuple[int, ...]]
) -> tuple[dict[str, int], dict[str, tuple[int, ...]]]:
    """Add what searches tried and found to the datasets; returns dimensions and places with those of the trials."""
    search, searches = found.listing.bisection, found.listing.searches
    assert search is not None
    dims = dims or {"search": 1}  # a dataset has a dimension
    trials = {system.key: i for each in searches for i, system in enumerate(each.systems)}
    combination = {key: place or (0,) for key, place in of_system.items()}
    brackets = {each.systems[0].key: one.bracket for one, each in zip(found.crossings, searches, strict=True)}
    known = [(bracket, combination[key]) for key, bracket in brackets.items() if key in combination]
    where, unit = [place for _, place in known], found.columns[search.column][0]
    for name, attribute, units, what in (
        ("", "value", "", f"{search.key} where {search.column} crosses {search.crosses:g}; NaN where it does not"),
        ("_lower", "lower", "", "lower end of its bracket, as far as the search is"),
        ("_upper", "upper", "", "upper end of its bracket"),
        ("_at_lower", "at_lower", unit, f"{search.column} at the lower end"),
        ("_at_upper", "at_upper", unit, f"{search.column} at the upper end"),
        ("_trials", "trials", "1", "systems that the search took"),
    ):
        values = [getattr(bracket, attribute) for bracket, _ in known]
        datasets[f"crossing{name}"] = _spread(dims, where, values, units, what)
    dims = {**dims, "trial": max(len(each.systems) for each in searches)}
    places = {key: (*place, trials[key]) for key, place in combination.items()}
    tried = [found.setting(key, search.key) for key in places]
    what = "value of this key of the input, which is searched for"
    datasets[search.key] = _spread(dims, list(places.values()), tried, "", what)
    datasets["trial"] = Dataset(np.arange(dims["trial"]), ("trial",), "1", "systems of a search, by that value")
    return dims, places


def _spread(
    dims: Mapping[str, int], places: NDArray[Any] | Sequence[Any], values: ArrayLike, units: str, what: str
) -> Dataset:
    """Values at their places on the axes, NaN elsewhere."""
    cube = np.full(tuple(dims.values()), np.nan)
    cube[tuple(np.asarray(places, dtype=int).reshape(len(places), len(dims)).T)] = values
    return Dataset(cube, tuple(dims), units, what)


def as_cell(value: Any) -> Any:
    """The value of a key as a cell of a table: lists and tables as text."""
    return json.dumps(value) if isinstance(value, (list, tuple, dict)) else value
