"""Stored results that are open in the browser: their states as numbers, and maps of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.files import store
from continuum.files.hdf5 import StoreError
from continuum.runs.config import RunConfig
from continuum.runs.result import Result
from continuum.show.plot import contact_colours, map_colours
from continuum.sweeps.axes import label_of
from continuum.sweeps.folder import Folder
from continuum.sweeps.sweep import systems_of

DECK_RUN, DECK_VERSION = "stickiness/deck-run", 2
"""What `atomistic read` stores."""
MAPS = ("contact", "gap")
NUMBERS = ("separation", "mean_gap", "load", "area_rep", "area_att")
"""What is known of each state, in a0 and E*."""


@dataclass(frozen=True)
class OpenedResults:
    """A stored run of the continuum or of a deck, or the runs of a sweep.

    Parameters
    ----------
    shown : its name, which is no path on this machine.
    runs : files of the runs, by what they are called.
    """

    shown: str
    runs: Mapping[str, Path]

    @classmethod
    def of(cls, path: Path) -> OpenedResults:
        """The results of a file or of a sweep's folder; raises InputError if it holds none."""
        if not path.is_dir():
            if not is_stored(path):
                raise StoreError(f"{path}: no stored run of `continuum run` or `atomistic read`")
            return cls(path.name, {path.name: path})
        folder = Folder(path)
        found = {label_of(system.settings): folder.point(system.key) for system in systems_of(path).systems}
        done = {label: file for label, file in found.items() if file.is_file()}
        if not done:
            raise StoreError(f"{path}: no system of this sweep is done")
        return cls(path.resolve().name, done)

    def states(self, index: int) -> dict[str, Any]:
        """Numbers of every state of a run, its size, and which maps it has."""
        path = self._file(index)
        return _READERS[store.schema_of(path) or ""](path)

    def map(self, index: int, step: int, kind: str) -> NDArray[Any]:
        """A map of one state, shape (nx, ny): kinds of contact as whole numbers, gaps in single precision."""
        path = self._file(index)
        known = self.states(index)
        if kind not in known["maps"] or not 0 <= step < len(known["states"]):
            raise StoreError(f"{self.shown}: no such map")
        if store.schema_of(path) == RunConfig.result_schema and kind == "contact":
            return Result.read(path).contact_map(step)
        found = store.read_part(path, kind, step)
        if found is None or found.shape != tuple(known["shape"]):
            raise StoreError(f"{self.shown}: no such map")
        return found.astype(np.uint8 if kind == "contact" else np.float32)

    def _file(self, index: int) -> Path:
        files = list(self.runs.values())
        if not 0 <= index < len(files):
            raise StoreError(f"{self.shown}: no such run")
        return files[index]


def is_stored(path: Path) -> bool:
    """Whether a file is a stored run of the continuum or of a deck."""
    return store.schema_of(path) in _READERS


def colours() -> dict[str, list[str]]:
    """Colours of the values of each kind of map, from the lowest on."""
    return {"contact": contact_colours(), "gap": map_colours()}


def _of_run(path: Path) -> dict[str, Any]:
    found = Result.read(path)
    states = [{"branch": point.branch, "status": point.meaning} | _numbers(vars(point)) for point in found.points]
    maps = [kind for kind, part in (("contact", "repulsive"), ("gap", "gap")) if _has(path, part)]
    return {"shape": found.grid.shape, "lengths": found.grid.lengths, "states": states, "maps": maps, "units": {}}


def _of_deck(path: Path) -> dict[str, Any]:
    file = store.read_datasets(path, DECK_RUN, DECK_VERSION, {*NUMBERS, "status", "height"})
    count, shape = len(file["load"]), file["height"].shape
    columns = {name: file[name].tolist() for name in (*NUMBERS, "status")}
    states = [
        {"branch": "", "status": columns["status"][i].lower()} | _numbers({name: columns[name][i] for name in NUMBERS})
        for i in range(count)
    ]
    units = {name: file.attributes.get(f"real_units/{name}") for name in ("a0", "contact_modulus")}
    maps = [kind for kind in MAPS if _has(path, kind)]
    return {
        "shape": shape, "lengths": [float(n) for n in shape], "states": states, "maps": maps,
        "units": {name: value for name, value in units.items() if isinstance(value, float)},
    }  # fmt: skip


_READERS: dict[str, Callable[[Path], dict[str, Any]]] = {RunConfig.result_schema: _of_run, DECK_RUN: _of_deck}


def _has(path: Path, dataset: str) -> bool:
    return store.read_part(path, dataset, 0) is not None


def _numbers(values: Mapping[str, Any]) -> dict[str, float | None]:
    """Finite numbers as they are; what is no number is not known."""
    return {name: float(values[name]) if np.isfinite(values[name]) else None for name in NUMBERS}
