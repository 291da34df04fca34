"""Stored results that are open in the browser: numbers and maps of their states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.store import datasets as store
from continuum.store.hdf5 import StoreError, understood
from continuum.store.runs.config import RunConfig
from continuum.store.runs.result import Result
from continuum.store.sweeps.axes import label_of
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of

DECK_RUN, DECK_VERSION = "stickiness/deck-run", 2
"""Kind and version of the results that `atomistic read` stores."""
MAPS = ("contact", "gap")
NUMBERS = ("separation", "mean_gap", "load", "area_rep", "area_att")
"""Numbers of each state, in a0 and E*."""


@dataclass(frozen=True)
class OpenedResults:
    """A stored run of the continuum or of a deck, or the runs of a sweep.

    Parameters
    ----------
    shown : name that is shown, never a path on this machine.
    runs : files of the runs by name.
    """

    shown: str
    runs: Mapping[str, Path]

    @classmethod
    def of(cls, path: Path) -> OpenedResults:
        """The results of a file or of a sweep's folder; raises InputError if it holds none."""
        if not path.is_dir():
            if not is_stored(path):
                raise StoreError(f"{path}: not a stored result of `continuum run` or `atomistic read`")
            return cls(path.name, {path.name: path})
        folder = Folder(path)
        found = {label_of(system.settings): folder.point(system.key) for system in systems_of(path).systems}
        done = {label: file for label, file in found.items() if file.is_file()}
        if not done:
            raise StoreError(f"{path}: no system of this sweep is done")
        return cls(path.resolve().name, done)

    def states(self, index: int) -> dict[str, Any]:
        """Numbers of every state of a run, its size, and the names of its maps."""
        with understood(self._file(index)):
            return self._run(index).states()

    def map(self, index: int, step: int, kind: str) -> NDArray[Any]:
        """A map of one state, shape (nx, ny): kinds of contact as whole numbers, gaps in single precision."""
        if kind not in MAPS:
            raise StoreError(f"{self.shown}: no such map")
        with understood(self._file(index)):
            found = self._run(index).map(step, kind)
            return found.astype(np.uint8 if kind == "contact" else np.float32)

    def _file(self, index: int) -> Path:
        files = list(self.runs.values())
        if not 0 <= index < len(files):
            raise StoreError(f"{self.shown}: no such run")
        return files[index]

    def _run(self, index: int) -> _StoredRun | _StoredDeck:
        file = self._file(index)
        return _READERS[store.schema_of(file) or ""](file)


def is_stored(path: Path) -> bool:
    """True if a file is a stored run of the continuum or of a deck."""
    return store.schema_of(path) in _READERS


class _StoredRun:
    """A run, as `continuum run` stored it."""

    def __init__(self, path: Path) -> None:
        self._found = Result.read(path)

    def states(self) -> dict[str, Any]:
        found = self._found
        states = [{"branch": point.branch, "status": point.meaning} | _numbers(vars(point)) for point in found.points]
        maps = [kind for kind, part in (("contact", "repulsive"), ("gap", "gap")) if _has(found.path, part)]
        return {"shape": found.grid.shape, "lengths": found.grid.lengths, "states": states, "maps": maps, "units": {}}

    def map(self, step: int, kind: str) -> NDArray[Any]:
        found = self._found
        return found.contact_map(step) if kind == "contact" else _part(found.path, kind, step, found.grid.shape)


class _StoredDeck:
    """The run of a deck, as `atomistic read` stored it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = store.read_datasets(path, DECK_RUN, DECK_VERSION, {*NUMBERS, "status", "height"})

    def states(self) -> dict[str, Any]:
        file, shape = self._file, self._file["height"].shape
        states = [
            {"branch": "", "status": str(status).lower()} | _numbers({name: file[name][i] for name in NUMBERS})
            for i, status in enumerate(file["status"])
        ]
        units = {name: file.attributes.get(f"real_units/{name}") for name in ("a0", "contact_modulus")}
        return {
            "shape": shape, "lengths": [float(n) for n in shape], "states": states,
            "maps": [kind for kind in MAPS if _has(self._path, kind)],
            "units": {name: value for name, value in units.items() if isinstance(value, float)},
        }  # fmt: skip

    def map(self, step: int, kind: str) -> NDArray[Any]:
        return _part(self._path, kind, step, self._file["height"].shape)


_READERS: dict[str, Callable[[Path], _StoredRun | _StoredDeck]] = {
    RunConfig.result_schema: _StoredRun,
    DECK_RUN: _StoredDeck,
}


def _part(path: Path, dataset: str, step: int, shape: tuple[int, ...]) -> NDArray[Any]:
    """A map of one state; raises StoreError if it is missing or has another shape."""
    found = store.read_part(path, dataset, step)
    if found is None or found.shape != shape:
        raise StoreError(f"{path}: no such map")
    return found


def _has(path: Path, dataset: str) -> bool:
    return store.read_part(path, dataset, 0) is not None


def _numbers(values: Mapping[str, Any]) -> dict[str, float | None]:
    """Finite numbers; None for others."""
    return {name: float(values[name]) if np.isfinite(values[name]) else None for name in NUMBERS}
