"""Progress of a sweep, from its files alone."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from continuum.inputs.arguments import file_name, flag
from continuum.inputs.reading import settings_of
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.hdf5 import StoreError
from continuum.store.sheet import MOST, Sheet, pairs
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.crossings import NOT_DONE, Crossing, asked_for, crossings_of, crossings_sheet
from continuum.store.sweeps.folder import Folder, names
from continuum.store.sweeps.listing import SweepListing, systems_of
from continuum.store.sweeps.pace import Span, expected, timed_systems, work_of
from continuum.store.sweeps.sweep import changes_of

_RECENT = 50
"""Number of last finished systems from which the rate is computed."""


@dataclass(frozen=True)
class SweepStatus:
    """Progress of a sweep, from its files alone."""

    listing: SweepListing = field(repr=False)
    done: int
    running: tuple[str, ...]
    """Processes that run a system, with their start."""
    failed: tuple[tuple[str, str], ...]
    """Each failed system with the reason."""
    rate: float
    """Systems per hour, lately; NaN if that is not known."""
    time_left: Span | None
    """Time for the systems that are left in one process, by the last ones on each grid; None where one has none."""
    left: int
    """Systems, or searches, that a further run would do: neither done nor failed."""
    others: int
    """Number of kept files of an earlier input, whose systems are not listed now."""
    changes: tuple[str, ...] = ()
    """Changes that running a given input would make."""
    crossings: tuple[Crossing, ...] = ()
    """Progress of each search."""
    died: tuple[str, ...] = ()
    """Unfinished systems whose process died."""

    @property
    def seconds_left(self) -> float:
        """Time left with as many processes as run now, or one, in s; NaN if that is not known."""
        return np.nan if self.time_left is None else self.time_left.over(max(1, len(self.running))).seconds

    @property
    def total(self) -> int:
        return len(self.listing.systems)

    def sheets(self) -> list[Sheet]:
        """Progress of the sweep, its failures, and the progress of its searches."""
        rows: list[tuple[str, str | int]] = [
            ("systems", self.total),
            ("done", self.done),
            ("running", len(self.running)),
            *(("", text) for text in self.running[:MOST]),
            *(("a process died", text) for text in self.died[:MOST]),
            ("failed", len(self.failed)),
            ("left", self.left),
        ]
        if self.crossings:  # the trials of a search are not known in advance
            ended = [one for one in self.crossings if one.complete]
            rows[0], rows[-1] = ("systems so far", self.total), ("searches", len(self.crossings))
            rows += [
                ("crossings found", sum(one.found for one in ended)),
                ("ended without one", sum(not one.found for one in ended)),
                ("not ended", len(self.crossings) - len(ended)),
            ]
        if not np.isnan(self.rate):
            rows.append(("lately", f"{self.rate:.3g} systems an hour"))
        if self.left and self.time_left is not None:
            at_once = max(1, len(self.running))
            rows.append(("time left", f"{self.time_left.over(at_once)} with {at_once} at once"))
        if self.others:
            rows.append(("of an earlier input, kept", self.others))
        sheets = [pairs(self.listing.name, rows)]
        if self.failed:
            sheets.append(Sheet.of("failed; --retry tries them again", ("system", "reason"), self.failed).beginning())
        if self.crossings:
            sheets.append(crossings_sheet(self.listing, self.crossings).beginning())
        return sheets


def sweep_status(
    sweep: str | Path,
    why: str | Path | None = None,
    *,
    settings: Mapping[str, Any] | None = None,
    reduced: bool = False,
) -> SweepStatus:
    """Progress of a sweep from its files alone: systems done, running, failed with the reasons, and the time left.

    Parameters
    ----------
    sweep : folder of the sweep.
    why : an input to be run in this folder: report which systems it would keep and which it would compute.
    settings : values for keys of that input.
    reduced : use the smaller sizes of its [sweep.reduced].

    Raises
    ------
    SweepError
        If the folder is not a sweep.
    ConfigError
        If the input is not that of a sweep.
    """
    root = file_name("sweep", sweep)
    changes: list[str] = []
    if why is not None:
        asked = Sweep.read(file_name("why", why), settings_of(settings), reduced=flag("reduced", reduced))
        changes = changes_of(root, asked) or ["nothing: these are the same systems"]
    folder, listing = Folder(root), systems_of(root)
    ended = {path.stem: path.stat().st_mtime for path in folder.points.glob("*.h5")}
    crossings = crossings_of(root, listing)
    there = {system.key for system in listing.systems if folder.stem(system.key) in ended}
    listing = asked_for(listing, crossings, there)
    costs = {folder.stem(system.key): system for system in listing.systems}
    done = {name: when for name, when in ended.items() if name in costs}
    # Of a system that is done a column of one's own may have failed.
    tried = names(folder.failed)
    labels = {name: system.label for name, system in costs.items() if name in tried}
    labels |= {one.name: one.label for one in crossings if one.name in tried}
    reasons = {name: reason for name in labels if (reason := folder.failure_reason(name))}
    failed = [(labels[name], reason) for name, reason in reasons.items()]
    running = []
    for mark in sorted(folder.work.glob(".*.lock")):
        name = mark.name.removeprefix(".").removesuffix(".lock")
        if not name.endswith(".h5") and output.is_locked(mark):
            stored = _points_in(folder.work / f"{name}.h5")
            running.append(f"{costs[name].label if name in costs else name}: {output.holder(mark)}{stored}")
    died = [
        f"{costs[mark.stem].label}: {mark.read_text(encoding='utf-8', errors='replace').strip()}"
        for mark in sorted(folder.work.glob("*.died"))
        if mark.stem in costs and mark.stem not in done
    ]
    waiting = [(s.kind, s.cost) for name, s in costs.items() if name not in done and name not in reasons]
    left = len(costs.keys() - done.keys() - reasons.keys())
    if listing.bisection is not None:  # searches may try more systems than are listed yet
        each, most = zip(listing.searches, crossings, strict=True), listing.bisection.most
        going_on = [one.systems for one, found in each if not found.complete]
        waiting += [(systems[0].kind, (most - len(systems)) * systems[0].cost) for systems in going_on]
        left = sum(found.status == NOT_DONE for found in crossings)
    timed = timed_systems(folder, {name: (costs[name].kind, costs[name].cost) for name in done}, done)
    return SweepStatus(
        listing,
        len(done),
        tuple(running),
        tuple(failed),
        _rate(done.values(), idle=not running),
        expected(timed, work_of(waiting)),
        left,
        len(ended) - len(done),
        tuple(changes),
        crossings,
        tuple(died),
    )


def _points_in(path: Path) -> str:
    """Number of stored points of a running path, as text; empty if there is none."""
    try:
        found = store.read_few(path, ("step",), ())[0]
    except StoreError:
        return ""
    return f", {found['step'].size} points stored" if "step" in found else ""


def _rate(ended: Iterable[float], *, idle: bool) -> float:
    """Systems per hour of the last finished systems, from their times; until now, unless nothing runs now."""
    last = sorted(ended)[-_RECENT:]
    seconds = (last[-1] if idle else time.time()) - last[0] if len(last) > 1 else 0.0
    return 3600 * (len(last) - 1) / seconds if seconds > 0 else np.nan
