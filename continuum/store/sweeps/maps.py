"""The maps and fields of all systems of a sweep as one dataset, which reads of each file what is looked at."""

from __future__ import annotations

import json
from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.arguments import ArgumentError, choice, file_name, instance
from continuum.store import datasets as store
from continuum.store.runs.record import MAPS
from continuum.store.sweeps.axes import System, as_cell, of_systems, places_on
from continuum.store.sweeps.folder import Folder, SweepError, names
from continuum.store.sweeps.listing import SweepListing, systems_of

if TYPE_CHECKING:
    import xarray

TAKEN = {*MAPS, "step", "x", "y", "system"}
"""Variables and dimensions of a dataset of maps, beside the axes."""


def sweep_maps(sweep: str | Path, where: Mapping[str, Any] | None = None) -> xarray.Dataset:
    """Maps of contact, gaps and heights of all systems of a sweep, read from their files when they are used.

    The dimensions are the axes of the sweep, by the last part of their names where that is unique, and ``step``, ``x``
    and ``y``; of a sweep that searches they are ``system``, ``step``, ``x`` and ``y``.  Maps of contact are booleans;
    as long as systems are missing, or paths have not equally many points, they are numbers with NaN.

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


_Coordinates = dict[str, tuple[str, NDArray[Any]]]


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
