"""Cost of a run or a sweep before it is run: memory and states by its input, time by systems that have ended."""

import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from continuum.inputs.reading import InputFile
from continuum.store.runs.config import RunConfig
from continuum.store.runs.cost import Cost, cost_of
from continuum.store.runs.record import Point
from continuum.store.runs.run import follow_run
from continuum.store.sheet import Sheet
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.cluster import Allocation
from continuum.store.sweeps.folder import Folder, names
from continuum.store.sweeps.status import Span, SystemTime, expected, timed_systems, work_of

NOT_MEASURED = "not measured"
_SHORT = 20.0
"""Seconds up to which a measurement is made again: the first one loads the solver."""

_TELLING = 256**2
"""Points of a grid from which on the time of a state grows as its points, within the range that is given; on smaller
ones it is that of everything else."""


@dataclass(frozen=True)
class SystemCost:
    """A system of a sweep, or what a search tries between its ends, with its cost."""

    key: str
    """Identity; empty between the ends of a search."""
    kind: str
    """Grid of the system, in words."""
    config: RunConfig
    """Input of the system, perhaps with another seed."""
    cost: Cost


def costs_of(described: Sweep) -> list[SystemCost]:
    """Cost of each system, and of what is tried between the two ends of each search, as if all cross."""
    found = [SystemCost(plan.key, plan.kind, config, cost_of(config)) for plan, config, _ in described.plans()]
    if described.bisection is not None:
        ends = zip(found[::2], found[1::2], strict=True)
        between = described.bisection.halvings
        found += [replace(max(two, key=lambda end: end.cost.work), key="") for two in ends for _ in range(between)]
    return found


def tasks_of(described: Sweep, systems: Sequence[SystemCost]) -> int:
    """Number of systems, or of searches."""
    return len(systems) if described.bisection is None else len(systems) // (2 + described.bisection.halvings)


class _Enough(Exception):
    """The first state is there."""


def seconds_of(config: RunConfig, *, first_state: bool = False) -> float:
    """Wall time of a run, or of its first state alone, without the time that loading the solver takes."""

    def stop(point: Point, done: int, total: int) -> None:
        if first_state:
            raise _Enough

    def once() -> float:
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            with suppress(_Enough):
                follow_run(config, Path(folder) / "measured.h5", progress=stop)
            return time.perf_counter() - began

    seconds = once()
    # A short run is mostly the loading of the solver, which a second one does not repeat.
    return once() if seconds < _SHORT else seconds


def check_sweep(file: InputFile, settings: Mapping[str, Any], *, reduced: bool, measure: bool) -> Sheet:
    """Check the input of a sweep and each of its systems: memory and states, and the time if it is to be measured."""
    described = Sweep.read(file, settings, reduced=reduced)
    systems, searches = costs_of(described), list[tuple[str, str, str]]()
    if described.bisection is not None:
        searches = [
            ("searches", f"{tasks_of(described, systems)}", ""), ("their systems are counted as if all cross", "", "")
        ]  # fmt: skip
    grids = {one.config.grid.n for one in systems}
    rows = [
        *searches,
        ("systems", f"{len(systems)}", ""),
        ("states of their paths", f"{sum(one.cost.states for one in systems)}", ""),
        ("grids", ", ".join(f"{nx} x {ny}" for nx, ny in sorted(grids)), ""),
        ("memory of the largest system, about", f"{max(one.cost.memory for one in systems) / 2**20:.4g}", "MiB"),
        *_times(systems, measure=measure),
        *((f"column {one.name}, run by `sweep run` only", one.made, "") for one in described.columns),
    ]
    return Sheet.of(f"{described.source.path}: valid", ("quantity", "value", "unit"), rows)


def _times(systems: Sequence[SystemCost], *, measure: bool) -> list[tuple[str, str, str]]:
    """Rows of the time of a sweep, by its cheapest system."""
    if not measure:
        return [("time", NOT_MEASURED, "--measure solves the cheapest system")]
    one = _measured(systems)
    span = expected([one], work_of((each.kind, each.cost.work) for each in systems), scaled=True)
    return [
        ("the cheapest system took", f"{one.seconds:.2g}", "s"),
        ("all of them, on one core", f"{span}", "by that one"),
    ]


def _measured(systems: Sequence[SystemCost]) -> SystemTime:
    # A small grid would tell the time of everything but the transforms.
    largest = max(one.cost.size for one in systems)
    cheapest = min((one for one in systems if one.cost.size >= min(_TELLING, largest)), key=lambda one: one.cost.work)
    return SystemTime(cheapest.kind, cheapest.cost.work, seconds_of(cheapest.config))


def core_hours(systems: Sequence[SystemCost], root: Path, allocation: Allocation, *, measure: bool) -> tuple[str, str]:
    """Core hours that a sweep still needs, in words, and that a job asks for less, if it does.

    They follow from the systems that are done in its folder; else the cheapest one is solved, if it is to be measured.
    """
    span, done = _by_the_folder(systems, root), "the systems that are done"
    if span is None and measure:
        work = work_of((one.kind, one.cost.work) for one in systems)
        span, done = expected([_measured(systems)], work, scaled=True), "the cheapest system"
    if span is None:
        # Without the name of the folder: whoever named it could add to the script.
        return "Core hours: not known, as no system of each grid is done; --measure solves the cheapest one.", ""
    asked = allocation.core_seconds
    hours = f"{_hours(span.seconds)} ({_hours(span.low)} to {_hours(span.high)})"
    known = f"Core hours: about {hours} by {done}; this asks for {_hours(asked)}."
    if asked >= span.seconds:
        return known, ""
    again = "submit the job again until nothing is left, or ask for more"
    return known, f"The time asked for is {100 * asked / span.seconds:.2g} % of what is needed: {again}."


def _by_the_folder(systems: Sequence[SystemCost], root: Path) -> Span | None:
    """Time of what is left, by the finished systems of the folder of the sweep; None if there are none."""
    folder = Folder(root)
    there = names(folder.points)
    named = {folder.stem(one.key): one for one in systems if one.key}
    ended = {name: (folder.points / f"{name}.h5").stat().st_mtime for name in there & named.keys()}
    done = {name: (named[name].kind, named[name].cost.work) for name in ended}
    left = ((one.kind, one.cost.work) for one in systems if not one.key or folder.stem(one.key) not in there)
    return expected(timed_systems(folder, done, ended), work_of(left))


def _hours(seconds: float) -> str:
    return f"{seconds / 3600:.2g}"
