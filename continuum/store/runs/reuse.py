"""Reuse of stored work: of a path by a run with other targets, and of the trials of a search that was stopped.

Points are reused as far as both paths agree.  The next point needs the full state of the last of them; a finer
tolerance needs the states of all points, and starts each from its own.

The next trial of a search follows from what was found at those before it.  So a search begins anew and is answered from
its file of trials as far as that goes.  The trials of an axis of a sweep are systems, which have files of their own:
their identities are kept.  Those of a threshold are states: their numbers are kept.
"""

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from continuum.measure.contact import Equilibrium, shared
from continuum.path.state import PathState
from continuum.solve.solution import Solution, Status
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.hdf5 import StoreError, understood
from continuum.store.identity import former_settings, identity, restored, with_values
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point, points_of

SMALL = 64**2
"""Points of a grid up to which the state of a path of one point is not stored: its solve takes less time."""
_FEW = ("contact_identity", "config_resolved", "identity")
_NUMBERS = ("step", *(column.name for column in fields(Point)))
SCHEMA = "stickiness/search"


@dataclass(frozen=True)
class Growth:
    """The part of a stored path that another run uses."""

    source: Path
    """File of the stored path."""
    identity: str
    """Identity of its run."""
    kept: int = 0
    """Number of points that are used unchanged."""
    refined: int = 0
    """Number of points that are solved to a finer tolerance, each from its stored state."""
    whole: bool = False
    """Whether the whole stored path is used, or the one point of a small grid found again."""


def contact_identity(config: RunConfig) -> str:
    """Hash of everything but the path and the tolerance, which two runs of one contact have in common."""
    content = config.plain(identity=True)
    content["loading"] = {config.loading.renamed["threshold"]: config.loading.threshold}
    content["solver"] = {key: value for key, value in content["solver"].items() if key != "tolerance"}
    text = json.dumps([config.result_schema, config.result_version, content], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def growth_of(config: RunConfig, source: Path) -> Growth | None:
    """The part of a stored run that another run can use; None if nothing, or if the contact differs."""
    try:
        held, found = store.read_few(source, ("step", "restart/target"), _FEW)
        if found.get("contact_identity") != contact_identity(config):
            return None
        with understood(source):
            earlier = restored(RunConfig, str(found["config_resolved"]))
            done, identity = len(held["step"]), str(found["identity"])
    except StoreError:
        return None  # damaged, or of another version
    asked = config.loading.points
    yields, searched = np.isfinite(config.wall.hardness), config.loading.threshold is not None
    both = zip(config.loading.aims, earlier.loading.aims, strict=False)
    alike = min(done, sum(1 for _ in takewhile(lambda two: two[0] == two[1], both)))
    if config.output.fields and not earlier.output.fields:
        return None  # gaps of its points were not stored: all would be solved again
    if config.solver.tolerance < earlier.solver.tolerance:
        # Each point starts from its own gap; an imprint is stored of the last point only.
        usable = alike and earlier.output.fields and not yields and not searched
        return Growth(source, identity, refined=alike) if usable else None
    # The next point starts from the last state, if that is stored; a search needs no state of the point before.
    goes_on = alike == done and ("restart/target" in held or searched)
    ends = alike == asked and not yields  # a shorter path, of which an imprint would be that of the longer one
    if alike == done == 1 and not (goes_on or ends) and config.grid.build().size <= SMALL:
        return Growth(source, identity, whole=True)
    if not alike or not (goes_on or ends):
        return None
    return Growth(source, identity, kept=alike, whole=alike == done)


def as_begun(config: RunConfig, source: Path) -> tuple[RunConfig, str]:
    """An input with the defaults that its stored result was begun with, and their last day; none if those of today.

    That result has the same identity then, or its path can be used.
    """
    try:
        stored = store.read_few(source, (), ("identity",))[1].get("identity")
    except StoreError:
        return config, ""
    if stored == identity(config) or growth_of(config, source) is not None:
        return config, ""
    for until, values in former_settings(config):
        former = with_values(config, values)
        if stored == identity(former) or growth_of(former, source) is not None:
            return former, until
    return config, ""


def growths(configs: Mapping[str, RunConfig], stored: Iterable[Path]) -> dict[str, Growth]:
    """For each run, by its key, the stored path of which it can use most, if any."""
    by_contact: dict[str, list[Path]] = {}
    for path in stored:
        try:
            contact = store.read_few(path, (), _FEW[:1])[1].get("contact_identity")
        except StoreError:
            continue
        by_contact.setdefault(str(contact), []).append(path)
    found: dict[str, Growth] = {}
    for key, config in configs.items() if by_contact else ():
        candidates = (growth_of(config, path) for path in by_contact.get(contact_identity(config), ()))
        usable = [one for one in candidates if one is not None]
        if usable:
            found[key] = max(usable, key=lambda one: (one.kept, one.refined))
    return found


def stored_state(source: Path, step: int) -> PathState | None:
    """The stored state of a point, from its gap in single precision; None if it did not converge."""
    file = store.read_datasets(source, RunConfig.result_schema, RunConfig.result_version, _NUMBERS)
    with understood(source):
        point = points_of(file)[step]
    gap = store.read_part(source, "gap", step)
    if not point.converged or gap is None or not np.isfinite(gap).all():
        return None
    solution = Solution(gap.astype(np.float64), Status.CONVERGED, point.residual, 0)
    return PathState(**shared(Equilibrium, point), solution=solution)


def save_trials(path: Path, trials: Iterable[tuple[Any, Any]], of: str = "") -> None:
    """Write the place of each trial with what was found there, as numbers and text; ``of`` names the search."""
    rows = [list(each) for each in trials]
    content = {"schema": SCHEMA, **({"of": of, "sha256": _checksum(rows)} if of else {}), "trials": rows}
    output.save(path, json.dumps(content) + "\n", own=True)


def read_trials(path: Path, of: str = "") -> list[tuple[Any, Any]]:
    """Read the file of :func:`save_trials`; empty if it is damaged or of another search: that will write it again."""
    try:
        content = json.loads(path.read_text())
        rows = content["trials"]
        sound = not of or (content["of"] == of and content["sha256"] == _checksum(rows))
        return [(place, found) for place, found in rows] if sound else []
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []


def _checksum(rows: list[Any]) -> str:
    return hashlib.sha256(json.dumps(rows).encode()).hexdigest()


class KeptTrials:
    """The trials of a search whose places are numbers and words, and what was found there likewise.

    Parameters
    ----------
    path : their file.
    of : identity of what is searched for.
    every : seconds between two writes, as a trial may take less time than they do.
    """

    def __init__(self, path: Path, of: str, every: float = 1.0) -> None:
        self.path, self.of, self.every = path, of, every
        self._found: dict[tuple[Any, ...], list[Any]] = {tuple(place): found for place, found in read_trials(path, of)}
        self._written, self._unwritten = time.perf_counter(), False

    def at(self, search: float, at: tuple[Any, ...], find: Callable[[], list[Any]]) -> list[Any]:
        """What a search of many found at a place; only where nothing is kept of it is it found now."""
        place = (search, *at)
        if place not in self._found:
            self._found[place], self._unwritten = find(), True
            if time.perf_counter() - self._written >= self.every:
                self.save()
        return self._found[place]

    def save(self) -> None:
        """Write those that are not written yet."""
        if self._unwritten:
            save_trials(self.path, self._found.items(), self.of)
            self._written, self._unwritten = time.perf_counter(), False

    def drop(self) -> None:
        """Delete all trials, once the search has ended."""
        self._found, self._unwritten = {}, False
        self.path.unlink(missing_ok=True)
