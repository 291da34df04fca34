"""How long the systems of a sweep take, measured on those that have ended.

Systems on one grid are compared by their work, states times points of the grid.  They are run in the random order of
their identities, so that the first ones are a sample of all.
"""

import heapq
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from statistics import stdev
from typing import NamedTuple, Self

from continuum.store import datasets as store
from continuum.store.hdf5 import StoreError
from continuum.store.sheet import duration
from continuum.store.sweeps.folder import Folder

FACTOR = 3.0
"""Factor by which the mean time of the systems on a grid may differ from that of the first one."""
_LONG = 300.0
"""Seconds of a system in which loading or compiling the solver, up to half a minute, can be neglected."""
_SECONDS, _FIRST = "journal/total_seconds", "journal/first_of_process"
_LAST = 20
"""Systems on a grid that are asked, the last ones."""


class SystemTime(NamedTuple):
    """A system that has ended."""

    kind: str
    """Its grid."""
    work: float
    """States times points of the grid."""
    seconds: float
    """Wall time."""
    first: bool = False
    """Whether it was the first of its process, which has loaded or compiled the solver in that time."""

    @property
    def counts(self) -> bool:
        """Whether its time is that of its states."""
        return self.work > 0 and self.seconds > 0 and (not self.first or self.seconds > _LONG)


class Span(NamedTuple):
    """An estimate with its range."""

    seconds: float
    low: float
    high: float

    def over(self, processes: int) -> Self:
        """The same work done by several processes at once."""
        return self._replace(seconds=self.seconds / processes, low=self.low / processes, high=self.high / processes)

    def __str__(self) -> str:
        if self.high < 1.5 * self.low:
            return f"about {duration(self.seconds)}"
        low, high = duration(self.low), duration(self.high)
        value, _, unit = low.partition(" ")
        return f"{value if high.endswith(f' {unit}') else low} to {high}"


def work_of(each: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Work on each grid, of systems with their grids and work."""
    found = defaultdict[str, float](float)
    for kind, work in each:
        found[kind] += work
    return found


def range_factor(rates: Sequence[float]) -> float:
    """Factor by which the mean time per work of all systems on a grid may differ from that of some of them.

    Two standard errors of its logarithm, by the scatter that was seen, but at least by that of :data:`FACTOR` for one
    (docs/studies/sweeps.md).
    """
    logarithms = [math.log(rate) for rate in rates]
    scatter = 2 * stdev(logarithms) if len(rates) > 1 else 0.0
    return math.exp(max(math.log(FACTOR), scatter) / math.sqrt(len(rates)))


def expected(ended: Iterable[SystemTime], left: Mapping[str, float], *, scaled: bool = False) -> Span | None:
    """Time in one process for the work that is left on each grid; None if on one of them no system has ended.

    Parameters
    ----------
    ended : systems that have ended.
    left : work on each grid.
    scaled : whether a grid on which no system has ended is taken to need the time per work of the others, with the
        square of the factor.
    """
    seen = defaultdict[str, list[SystemTime]](list)
    for one in ended:
        if one.counts:
            seen[one.kind].append(one)
    if not (left.keys() <= seen.keys() or (scaled and seen)):
        return None
    rates = {kind: sum(one.seconds for one in each) / sum(one.work for one in each) for kind, each in seen.items()}
    parts = [Span(0.0, 0.0, 0.0)]
    for kind, work in left.items():
        if kind in seen:
            seconds, factor = rates[kind] * work, range_factor([one.seconds / one.work for one in seen[kind]])
        else:
            seconds, factor = max(rates.values()) * work, FACTOR**2
        parts.append(Span(seconds, seconds / factor, seconds * factor))
    return Span(*map(sum, zip(*parts, strict=True)))


def timed_systems(
    folder: Folder, systems: Mapping[str, tuple[str, float]], ended: Mapping[str, float]
) -> Iterator[SystemTime]:
    """The last finished systems on each grid with their times, as their files have them.

    Parameters
    ----------
    systems : grid and work of each finished system, by the name of its file.
    ended : when each of them ended, by its name.
    """
    by_kind = defaultdict[str, list[str]](list)
    for name, (kind, _) in systems.items():
        by_kind[kind].append(name)
    for kind, names in by_kind.items():
        for name in heapq.nlargest(_LAST, names, key=ended.__getitem__):
            try:
                found = store.read_few(folder.points / f"{name}.h5", (), (_SECONDS, _FIRST))[1]
            except StoreError:
                continue
            if _SECONDS in found:
                yield SystemTime(kind, systems[name][1], float(found[_SECONDS]), bool(found.get(_FIRST)))
