"""The table of a sweep with one dimension for each axis of its input, as xarray has it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray

from continuum.path.crossing import Bracket
from continuum.store.runs.record import XARRAY_NAMES
from continuum.store.sweeps.axes import as_cell, places_on
from continuum.store.sweeps.bisection import Bisection
from continuum.store.sweeps.crossings import Crossing
from continuum.store.sweeps.listing import SweepListing


def cube_of(
    listing: SweepListing,
    crossings: Sequence[Crossing],
    keys: Sequence[str],
    system: NDArray[np.int64],
    columns: Mapping[str, NDArray[Any]],
    about: Mapping[str, tuple[str, str]],
) -> xarray.Dataset:
    """All points of a sweep, with one dimension for each axis of the input, and ``step``.

    Keys that change together are one dimension, named after the first.  Missing points are NaN.  A key that is
    searched for has the dimension ``trial``, in the order of its values, which are a variable.

    Parameters
    ----------
    crossings : what the searches of the listing found.
    keys : systems that were read.
    system : index of the system of each point.
    columns : a value for each point.
    about : unit and description of each column.
    """
    searches, search, there = listing.searches, listing.bisection, {*keys}
    axes = [axis for axis in listing.axes[: -1 if searches else None] if axis.values]
    lengths, read = {axis.keys[0]: len(axis.values) for axis in axes}, [s for s in listing.systems if s.key in there]
    places = places_on(axes, read)
    parts, coordinates = list[xarray.Dataset](), dict[str, Any]()
    for axis in axes:
        for i, key in enumerate(axis.keys):
            along = np.array([as_cell(values[i]) for values in axis.values])
            coordinates[key] = axis.keys[0], along, _said("", "value of this key of the input")
    if searches and search is not None:
        lengths = lengths or {"search": 1}  # a dataset has a dimension
        places = {key: place or (0,) for key, place in places.items()}
        both = zip(crossings, searches, strict=True)
        known = [(one.bracket, places[each.systems[0].key]) for one, each in both if each.systems[0].key in places]
        parts.append(_crossings(search, about[search.column][0], known, lengths))
        lengths["trial"] = max(len(each.systems) for each in searches)
        trials = {system.key: i for each in searches for i, system in enumerate(each.systems)}
        places = {key: (*place, trials[key]) for key, place in places.items()}
        tried = {search.key: [system.settings[search.key] for system in read]}
        what = "value of this key of the input, which is searched for"
        parts.append(_spread(lengths, [places[system.key] for system in read], tried, {search.key: ("", what)}))
        what = "systems of a search, by that value"
        coordinates["trial"] = "trial", np.arange(lengths["trial"]), _said("1", what)
    steps = columns["step"].astype(int)
    lengths["step"] = int(steps.max(initial=-1)) + 1
    where = [(*places[keys[i]], step) for i, step in zip(system, steps, strict=True)]
    parts.append(_spread(lengths, where, {name: held for name, held in columns.items() if name != "step"}, about))
    coordinates["step"] = "step", np.arange(lengths["step"]), _said("1", about["step"][1])
    return xarray.merge(parts, join="outer").assign_coords(coordinates).rename(XARRAY_NAMES)


def _crossings(
    search: Bisection, unit: str, known: Sequence[tuple[Bracket, tuple[int, ...]]], lengths: Mapping[str, int]
) -> xarray.Dataset:
    """Results of searches, at their places on the other axes."""
    attributes = {
        "crossing": (
            "value",
            "",
            f"{search.key} where {search.column} crosses {search.crosses:g}; NaN where it does not",
        ),
        "crossing_lower": ("lower", "", "lower end of its bracket, as far as the search is"),
        "crossing_upper": ("upper", "", "upper end of its bracket"),
        "crossing_at_lower": ("at_lower", unit, f"{search.column} at the lower end"),
        "crossing_at_upper": ("at_upper", unit, f"{search.column} at the upper end"),
        "crossing_trials": ("trials", "1", "systems that the search took"),
    }
    columns = {name: [getattr(one, key) for one, _ in known] for name, (key, *_) in attributes.items()}
    about = {name: (units, what) for name, (_, units, what) in attributes.items()}
    return _spread(lengths, [place for _, place in known], columns, about)


def _spread(
    lengths: Mapping[str, int],
    places: Sequence[tuple[int, ...]],
    columns: Mapping[str, Any],
    about: Mapping[str, tuple[str, str]],
) -> xarray.Dataset:
    """Columns of a table at their places on the axes, NaN elsewhere."""
    along = np.array(places, dtype=int).reshape(len(places), len(lengths)).T
    index = pandas.MultiIndex.from_arrays(list(along), names=list(lengths))
    data: xarray.Dataset = pandas.DataFrame(columns, index, dtype=float).to_xarray()
    data = data.reindex({name: np.arange(length) for name, length in lengths.items()}).drop_vars(list(lengths))
    return data.assign({name: data[name].assign_attrs(_said(*about[name])) for name in columns})


def _said(units: str, what: str) -> dict[str, str]:
    return {"units": units, "long_name": what}
