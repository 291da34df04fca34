"""A sweep as xarray has it, one dimension for each axis of its input: the table of points, and maps and fields.

Of maps only those that are looked at are read.
"""

from __future__ import annotations

import json
from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray

from continuum.inputs.arguments import ArgumentError, choice, file_name, instance
from continuum.path.crossing import Bracket
from continuum.store import datasets as store
from continuum.store.runs.record import MAPS, XARRAY_NAMES
from continuum.store.sweeps.axes import System, as_cell, of_systems, places_on
from continuum.store.sweeps.bisection import Bisection
from continuum.store.sweeps.crossings import Crossing
from continuum.store.sweeps.folder import Folder, SweepError, names
from continuum.store.sweeps.listing import SweepListing, systems_of

if TYPE_CHECKING:
    import xarray
TAKEN = {*MAPS, "step", "x", "y", "system"}
"""Variables and dimensions of a dataset of maps, beside the axes."""
_Coordinates = dict[str, tuple[str, NDArray[Any]]]


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


def sweep_maps(sweep: str | Path, where: Mapping[str, Any] | None = None) -> xarray.Dataset:
    """Maps of contact, gaps and heights of all systems of a sweep, read from the files on demand.

    The dimensions are the axes of the sweep, named by the last part of their keys where that is unique, and ``step``,
    ``x`` and ``y``; for a sweep with a search they are ``system``, ``step``, ``x`` and ``y``.  Maps of contact are
    booleans; if systems are missing, or paths have different numbers of points, they are numbers with NaN.

    Parameters
    ----------
    sweep : folder of the sweep.
    where : values of keys on the axes, as ``{"grid.n": 512}``: only these systems, which must be of one grid.

    Raises
    ------
    SweepError
        If there is no sweep, or none of these systems is done.
    ArgumentError
        If a key is on no axis, or systems are of several grids.
    StoreError
        While it is used, if a file is damaged.

    Examples
    --------
    >>> import continuum as c
    >>> dict(c.sweep_maps("results/waves").sizes)
    {'x': 64, 'y': 64, 'amplitude': 2, 'step': 2}
    """
    import xarray

    from continuum.store.runs.maps import maps_of

    root, wanted = (
        file_name("sweep", sweep),
        instance("where", {} if where is None else where, dict, "values by keys on the axes"),
    )
    folder, listing = Folder(root), systems_of(root)
    keys = [key for axis in listing.axes for key in axis.keys]
    chosen = _chosen(listing, wanted, keys)
    there = names(folder.points)
    done = {each.key: folder.point(each.key) for each in chosen if folder.stem(each.key) in there}
    if not done:
        raise SweepError(f"{folder.root}: no such system is done")
    short = _short(keys, TAKEN | set(dir(xarray.Dataset)))
    dims, lengths, places, coordinates = _axes(listing, chosen, short)
    paths = np.full(lengths, None, dtype=object)
    for key, path in done.items():
        paths[places[key]] = path
    same_path = not any(key.startswith("loading") for key in keys)
    points = {_points(path) for path in (list(done.values())[:1] if same_path else done.values())}
    found = maps_of(paths, dims, max(points), complete=len(done) == paths.size and len(points) == 1)
    said = {"name": listing.name, "systems": len(done), "systems_missing": len(chosen) - len(done)}
    return xarray.Dataset(found, coordinates, said)


def _chosen(listing: SweepListing, where: dict[str, Any], keys: Sequence[str]) -> list[System]:
    """The systems with these values, of one grid."""
    for key in where:
        choice("where", key, keys)
    wanted = {key: json.dumps(value) for key, value in where.items()}
    found = [
        each
        for each in listing.systems
        if all(json.dumps(each.settings[key]) == value for key, value in wanted.items())
    ]
    of_grid = [key for key in keys if key.partition(".")[0] == "grid"]
    if len({json.dumps([each.settings[key] for key in of_grid]) for each in found}) > 1:
        raise ArgumentError("where", where, f"values of {' and '.join(of_grid)}, as all systems need one grid")
    return found


def _short(keys: Sequence[str], taken: Container[str]) -> dict[str, str]:
    """The last part of each key, or the whole one where another, a variable, or a method of a dataset has the same."""
    last = [key.rpartition(".")[2] for key in keys]
    return {key: one if last.count(one) == 1 and one not in taken else key for key, one in zip(keys, last, strict=True)}


def _axes(
    listing: SweepListing, chosen: Sequence[System], short: Mapping[str, str]
) -> tuple[tuple[str, ...], tuple[int, ...], Mapping[str, tuple[int, ...]], _Coordinates]:
    """Names and lengths of the dimensions, the place of each system, and the values along them."""
    if listing.bisection is not None:  # the trials of each search are others
        columns = {short[key]: [as_cell(each.settings[key]) for each in chosen] for key in short}
        along = {name: ("system", np.array(values)) for name, values in columns.items()}
        return ("system",), (len(chosen),), {each.key: (i,) for i, each in enumerate(chosen)}, along
    axes = tuple(of_systems(axis, chosen) for axis in listing.axes)
    dims = tuple(short[axis.keys[0]] for axis in axes)
    along = {
        short[key]: (dim, np.array([as_cell(values[i]) for values in axis.values]))
        for axis, dim in zip(axes, dims, strict=True)
        for i, key in enumerate(axis.keys)
    }
    return dims, tuple(len(axis.values) for axis in axes), places_on(axes, chosen), along


def _points(path: Path) -> int:
    return int(store.read_few(path, ("step",), ())[0]["step"].size)
