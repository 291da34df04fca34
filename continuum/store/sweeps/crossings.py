"""The searches of a sweep: each trial is an ordinary system, and results follow from their files."""

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from continuum.inputs.errors import OutputError, StickinessError
from continuum.inputs.toml import text_of
from continuum.path.crossing import Bracket
from continuum.path.state import JumpSide, Outcome
from continuum.store import output
from continuum.store.hdf5 import StoreError
from continuum.store.identity import identity
from continuum.store.runs.result import Result
from continuum.store.runs.reuse import save_trials
from continuum.store.sheet import Column, Sheet
from continuum.store.sweeps.axes import System, label_of
from continuum.store.sweeps.bisection import Bisection
from continuum.store.sweeps.columns import OwnColumn, columns_of
from continuum.store.sweeps.folder import Folder, names
from continuum.store.sweeps.listing import SweepListing, tried
from continuum.store.sweeps.measured import SystemTable, numbers_of
from continuum.store.sweeps.sweep import SystemTask, solve_system

Numbers = Callable[[str], SystemTable | None]
"""Function that returns the numbers of a system by its identity; None if there are none, or columns are missing."""

NOT_DONE = "not done"
"""Status of a search that a further run would go on with."""


class TrialError(StickinessError):
    """A trial of a search failed."""


@dataclass(frozen=True)
class Crossing:
    """Result of a search in one combination of the axes."""

    name: str
    """Name of the search."""
    settings: Mapping[str, Any]
    """Key and value on each other axis."""
    bracket: Bracket
    """Bracket of the key, and the column at its ends."""
    status: str
    """"found", "not done", or the reason why there is no crossing."""

    @property
    def found(self) -> bool:
        """Whether the column crosses the value, within the tolerance of the search."""
        return self.status == "found"

    @property
    def complete(self) -> bool:
        """Whether no trial is left."""
        return self.bracket.next is None

    @property
    def value(self) -> float:
        """The value of the key at the crossing, interpolated in the bracket; NaN if it was not found."""
        return self.bracket.value

    @property
    def label(self) -> str:
        return label_of(self.settings)


def solve_task(root: Path, task: SystemTask) -> None:
    """Run a system, or a search with all its remaining trials.

    Raises LockedError if another process works on it, TrialError if a system of a search fails.
    """
    if task.bisection is None:
        solve_system(root, task)
    else:
        _solve_search(root, task, task.bisection)


def _solve_search(root: Path, task: SystemTask, search: Bisection) -> None:
    folder = Folder(root)
    trials, known = dict[float, System](), dict[float, float | None]()

    def column_at(value: float) -> float | None:
        if value not in trials:
            plan = System("", {**task.plan.settings, search.key: value}, source=task.plan.source)
            trials[value] = replace(plan, key=identity(plan.config))
        if known.get(value) is None:
            try:
                known[value] = _column(search, folder, trials[value].key, _on_disk(folder, task.columns))
            except StoreError as error:  # not a fault of the search
                raise OutputError(f"{error}; `continuum sweep verify --aside` moves it away") from error
        return known[value]

    def next_value() -> float | None:
        value = search.follow(column_at).next
        save_trials(task.path, ((v, p.key) for v, p in trials.items() if v not in (search.first, search.last)))
        return value

    with output.reserved(output.folder(folder.searches) / task.path.stem):
        while (value := next_value()) is not None:
            plan = trials[value]
            try:
                solve_system(root, SystemTask(folder.point(plan.key), plan.label, plan=plan, columns=task.columns))
            except OutputError:
                raise
            except Exception as error:
                msg = f"at {search.key.rpartition('.')[2]} {text_of(value)}: {type(error).__name__}: {error}"
                raise TrialError(msg) from error
        folder.failure(task.path.stem).unlink(missing_ok=True)


def done_before(root: Path) -> Callable[[Any], bool]:
    """Whether a task is done, by the files in the folder."""
    folder = Folder(root)
    there = names(folder.points)

    def is_done(task: SystemTask) -> bool:
        if (search := task.bisection) is None:
            return task.path.stem in there and len(columns_of(folder, task.plan.key, task.columns)) == len(task.columns)
        keys = {search.first: task.plan.key, search.last: task.upper, **tried(task.path)}
        try:
            return _bracket(search, folder, keys, _on_disk(folder, task.columns)).next is None
        except StoreError:
            return False

    return is_done


def crossings_of(root: Path, listing: SweepListing, numbers: Numbers | None = None) -> tuple[Crossing, ...]:
    """Results of the searches of a sweep so far, in the order of its listing.

    Parameters
    ----------
    numbers : tables that were read before; by default they are read from the files.
    """
    folder, found = Folder(root), []
    numbers = numbers or _on_disk(folder, listing.columns)
    for each in listing.searches:
        assert listing.bisection is not None
        search, given = listing.bisection, each.systems[0].settings
        keys = {system.settings[search.key]: system.key for system in each.systems}
        damaged = ""
        try:
            bracket = _bracket(search, folder, keys, numbers)
        except StoreError as error:
            bracket, damaged = _bracket(search, folder, {}, numbers), str(error)
        status = damaged or bracket.reason or ("found" if bracket.next is None else NOT_DONE)
        if status == NOT_DONE and (reason := folder.failure_reason(each.name)):
            status = f"failed: {reason}"
        settings = {key: value for key, value in given.items() if key != search.key}
        found.append(Crossing(each.name, settings, bracket, status))
    return tuple(found)


def asked_for(listing: SweepListing, crossings: Sequence[Crossing], done: Container[str]) -> SweepListing:
    """A listing without the ends that a search has never needed, as it has ended before.

    Parameters
    ----------
    done : identities of the systems that are done.
    """
    both = zip(listing.searches, crossings, strict=True)
    ended = {system.key for each, found in both if found.complete for system in each.systems}
    systems = (system for system in listing.systems if system.key in done or system.key not in ended)
    return replace(listing, systems=tuple(systems))


def with_columns(
    folder: Folder, key: str, columns: Sequence[OwnColumn], read: SystemTable | None = None
) -> SystemTable:
    """The numbers of a finished system, if they were not read yet, with the columns of one's own that are stored.

    Raises StoreError if one of its files is damaged.
    """
    found, own = read or numbers_of(folder.point(key), key), columns_of(folder, key, columns)
    if any(values.shape != (len(found.table),) for values in own.values()):
        raise StoreError(f"{folder.own(key)}: is not of the points of its system; delete it, and run the sweep again")
    return replace(found, own=own) if own else found


def _on_disk(folder: Folder, columns: Sequence[OwnColumn]) -> Numbers:
    def numbers(key: str) -> SystemTable | None:
        if not folder.point(key).is_file():
            return None
        found = with_columns(folder, key, columns)
        return found if len(found.own) == len(columns) else None

    return numbers


def _bracket(search: Bisection, folder: Folder, keys: Mapping[float, str], numbers: Numbers) -> Bracket:
    return search.follow(lambda value: _column(search, folder, keys[value], numbers) if value in keys else None)


def _column(search: Bisection, folder: Folder, key: str, numbers: Numbers) -> float | None:
    found = numbers(key)
    if found is None:
        return None
    value = search.at(found)
    return between_sides(search, Result.read(folder.point(key))) if math.isnan(value) else value


def between_sides(search: Bisection, result: Result) -> float:
    """The column where its area is jumped over, if both sides of the jump are on one side of the value; else NaN.

    Between the sides it is taken as linear in the area.
    """
    steps = [step for step, point in enumerate(result.points) if search.is_target(point.target)]
    step = next(iter(steps), -1) if search.target is not None else len(result.points) - 1
    jumps = [passed.event for passed in result.events if passed.step == step]
    if not jumps or result.points[step].status != Outcome.JUMPED_OVER.name or search.column not in JumpSide._fields:
        return math.nan
    before, after = jumps[-1].before, jumps[-1].after
    ends = getattr(before, search.column), getattr(after, search.column)
    if min(ends) <= search.crosses <= max(ends):
        return math.nan
    share = (result.points[step].target - before.area_rep) / (after.area_rep - before.area_rep)
    return float(ends[0] + share * (ends[1] - ends[0]))


def crossings_sheet(listing: SweepListing, crossings: Sequence[Crossing]) -> Sheet:
    """Results of searches so far, one per row."""
    search = listing.bisection
    if search is None:
        return Sheet.of("crossings", ("search",), ())
    axes = [key for axis in listing.axes[:-1] for key in axis.keys]
    ends = (Column(f"{search.column} at {end}", form=".3g") for end in ("lower", "upper"))
    values = (Column(name, form=".6g") for name in (search.key, "lower", "upper"))
    columns: list[Column | str] = ["search", *axes, *values, *ends, "systems", "status"]
    rows = []
    for number, one in enumerate(crossings, 1):
        bracket = one.bracket
        given = [v if isinstance(v, str | int | float) else text_of(v) for v in (one.settings[key] for key in axes)]
        found = (bracket.value, bracket.lower, bracket.upper, bracket.at_lower, bracket.at_upper)
        rows.append((number, *given, *found, bracket.trials, one.status))
    at = "" if search.target is None else f" at {search.target:g}"
    return Sheet.of(f"{search.key} where {search.column}{at} crosses {search.crosses:g}", columns, rows)
