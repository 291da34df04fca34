"""Progress of a sweep, from its files alone, and how long its systems take, by those that have ended.

Systems on one grid are compared by their effort, states times points of the grid.  They are run in the random order of
their identities, so that the first ones are a sample of all.
"""

import heapq
import math
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import stdev
from typing import Any, NamedTuple, Self

import numpy as np

from continuum.inputs.arguments import file_name, flag
from continuum.inputs.reading import settings_of
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.hdf5 import StoreError
from continuum.store.sheet import MOST, Sheet, duration, pairs
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.crossings import NOT_DONE, Crossing, asked_for, crossings_of, crossings_sheet
from continuum.store.sweeps.folder import Folder, names
from continuum.store.sweeps.listing import SweepListing, systems_of
from continuum.store.sweeps.sweep import changes_of

FACTOR = 3.0
"""Factor by which the mean time of the systems on a grid may differ from that of the first one."""
_LONG = 300.0
"""Seconds of a system in which loading or compiling the solver, up to half a minute, can be neglected."""
_SECONDS, _FIRST = "journal/total_seconds", "journal/first_of_process"
_LAST = 20
"""Systems on a grid that are asked, the last ones."""
_RECENT = 50
"""Number of last finished systems from which the rate is computed."""


class SystemTime(NamedTuple):
    """A system that has ended."""

    kind: str
    """Its grid."""
    effort: float
    """States times points of the grid."""
    seconds: float
    """Wall time."""
    first: bool = False
    """Whether it was the first of its process, which has loaded or compiled the solver in that time."""

    @property
    def counts(self) -> bool:
        """Whether its time is that of its states."""
        return self.effort > 0 and self.seconds > 0 and (not self.first or self.seconds > _LONG)


class Span(NamedTuple):
    """An estimate with its range."""

    seconds: float
    low: float
    high: float

    def over(self, processes: int) -> Self:
        """The same work done by several processes at once."""
        return self._replace(seconds=self.seconds / processes, low=self.low / processes, high=self.high / processes)

    def __str__(self) -> str:
        if self.high < 1:
            return "less than 1 s"
        if self.low < 1:
            return f"up to {duration(self.high)}"
        if self.high < 1.5 * self.low:
            return f"about {duration(self.seconds)}"
        low, high = duration(self.low), duration(self.high)
        value, _, unit = low.partition(" ")
        return f"{value if high.endswith(f' {unit}') else low} to {high}"


def effort_of(each: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Effort on each grid, of systems with their grids and efforts."""
    found = defaultdict[str, float](float)
    for kind, effort in each:
        found[kind] += effort
    return found


def range_factor(rates: Sequence[float]) -> float:
    """Factor by which the mean time per effort of all systems on a grid may differ from that of some of them.

    Two standard errors of its logarithm, by the scatter that was seen, but at least by that of :data:`FACTOR` for one
    (docs/studies/sweeps.md).
    """
    logarithms = [math.log(rate) for rate in rates]
    scatter = 2 * stdev(logarithms) if len(rates) > 1 else 0.0
    return math.exp(max(math.log(FACTOR), scatter) / math.sqrt(len(rates)))


def expected(ended: Iterable[SystemTime], left: Mapping[str, float], *, scaled: bool = False) -> Span | None:
    """Time in one process for the effort that is left on each grid; None if on one of them no system has ended.

    Parameters
    ----------
    ended : systems that have ended.
    left : effort on each grid.
    scaled : whether a grid on which no system has ended is taken to need the time per effort of the others, with the
        square of the factor.
    """
    seen = defaultdict[str, list[SystemTime]](list)
    for one in ended:
        if one.counts:
            seen[one.kind].append(one)
    if not (left.keys() <= seen.keys() or (scaled and seen)):
        return None
    rates = {kind: sum(one.seconds for one in each) / sum(one.effort for one in each) for kind, each in seen.items()}
    parts = [Span(0.0, 0.0, 0.0)]
    for kind, effort in left.items():
        if kind in seen:
            seconds, factor = rates[kind] * effort, range_factor([one.seconds / one.effort for one in seen[kind]])
        else:
            seconds, factor = max(rates.values()) * effort, FACTOR**2
        parts.append(Span(seconds, seconds / factor, seconds * factor))
    return Span(*map(sum, zip(*parts, strict=True)))


def timed_systems(
    folder: Folder, systems: Mapping[str, tuple[str, float]], ended: Mapping[str, float]
) -> Iterator[SystemTime]:
    """The last finished systems on each grid with their times, as their files have them.

    Parameters
    ----------
    systems : grid and effort of each finished system, by the name of its file.
    ended : when each of them ended, by its name.
    """
    by_kind = defaultdict[str, list[str]](list)
    for name, (kind, _) in systems.items():
        by_kind[kind].append(name)
    for kind, ended_ones in by_kind.items():
        for name in heapq.nlargest(_LAST, ended_ones, key=ended.__getitem__):
            try:
                found = store.read_few(folder.points / f"{name}.h5", (), (_SECONDS, _FIRST))[1]
            except StoreError:
                continue
            if _SECONDS in found:
                yield SystemTime(kind, systems[name][1], float(found[_SECONDS]), bool(found.get(_FIRST)))


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
    stopped: tuple[str, ...] = ()
    """Unfinished systems that were stopped, which a further run continues."""

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
            *(("stopped, to be continued", text) for text in self.stopped[:MOST]),
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
            rows.append(("lately", f"{_rounded(self.rate)} systems an hour"))
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

    Examples
    --------
    >>> import continuum as c
    >>> status = c.sweep_status("results/waves")
    >>> status.done, status.left
    (2, 0)
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
    marks = {mark.name.removeprefix(".").removesuffix(".lock"): mark
             for mark in sorted(folder.running.glob(".*.lock")) if output.is_locked(mark)}  # fmt: skip
    running = [
        f"{costs[name].label if name in costs else name}: {output.holder(mark)}{_points_in(folder, name)}"
        for name, mark in marks.items()
        if not name.endswith(".h5")
    ]
    dead = {mark.stem for mark in folder.running.glob("*.died")}
    stopped = [
        f"{costs[path.stem].label}{_points_in(folder, path.stem)}"
        for path in sorted(folder.running.glob("[!.]*.h5"))
        if path.stem in costs.keys() - done.keys() - reasons.keys() - marks.keys() - dead
    ]
    died = [
        f"{costs[mark.stem].label}: {mark.read_text(encoding='utf-8', errors='replace').strip()}"
        for mark in sorted(folder.running.glob("*.died"))
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
        expected(timed, effort_of(waiting)),
        left,
        len(ended) - len(done),
        tuple(changes),
        crossings,
        tuple(died),
        tuple(stopped),
    )


def _rounded(rate: float) -> str:
    """A rate with two digits, its thousands apart."""
    digits = float(f"{rate:.2g}")
    return f"{digits:,.0f}".replace(",", " ") if digits >= 10 else f"{digits:g}"


def _points_in(folder: Folder, name: str) -> str:
    """Number of stored points of an unfinished path, as text; empty if there is none."""
    try:
        found = store.read_few(folder.running / f"{name}.h5", ("step",), ())[0]
    except StoreError:
        return ""
    count = found["step"].size if "step" in found else 0
    return f", {count} point{'s' if count > 1 else ''} stored" if count else ""


def _rate(ended: Iterable[float], *, idle: bool) -> float:
    """Systems per hour of the last finished systems, from their times; until now, unless nothing runs now."""
    last = sorted(ended)[-_RECENT:]
    seconds = (last[-1] if idle else time.time()) - last[0] if len(last) > 1 else 0.0
    return 3600 * (len(last) - 1) / seconds if seconds > 0 else np.nan
