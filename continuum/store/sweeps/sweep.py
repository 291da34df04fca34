"""A sweep on disk: one file for each system, named by its identity; finished systems are not run again.

All state is in the folder of the sweep: processes may die, and several may work on one folder.
"""

import gc
import hashlib
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from continuum.inputs.errors import OutputError
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.hdf5 import StoreError, UnreadError
from continuum.store.identity import former_settings, identity
from continuum.store.provenance import journal, made_by, provenance
from continuum.store.runs.config import Cost, RunConfig, cost_of
from continuum.store.runs.reuse import Growth, growths
from continuum.store.runs.run import follow_run
from continuum.store.sweeps.axes import Axis, Sweep, System, label_of
from continuum.store.sweeps.bisection import Bisection
from continuum.store.sweeps.columns import OwnColumn, add_columns, require_functions
from continuum.store.sweeps.conditions import dotted
from continuum.store.sweeps.folder import Folder, SweepError, names, save_once
from continuum.store.sweeps.listing import SweepListing, SweepSearch, listing_text, systems_of, with_trials
from continuum.store.sweeps.measured import ADDED
from continuum.store.sweeps.workers import Task, TaskResult, say

_MOST = 8
"""Keys that a message names."""
_EVERY = 20.0
"""Largest time of a path that a killed process loses; shorter pieces are not stored."""


@dataclass(frozen=True)
class SystemTask(Task):
    """A task of the engine: a system, or a whole search, whose file lists its trials."""

    plan: System = field(kw_only=True)
    """The plan of the system, or of that at the lower end of a search."""
    growth: Growth | None = field(default=None, kw_only=True)
    """A stored path of the same contact, from an earlier input of the sweep."""
    bisection: Bisection | None = field(default=None, kw_only=True)
    """What is searched for, if anything is."""
    upper: str = field(default="", kw_only=True)
    """Identity of the system at the upper end of a search."""
    columns: tuple[OwnColumn, ...] = field(default=(), kw_only=True)
    """Columns of one's own, with their functions."""


@contextmanager
def _uncollected() -> Iterator[None]:
    """Without the collector of cycles, which looks again and again at systems that stay: a quarter of the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@_uncollected()
def begin(
    sweep: Sweep,
    root: str | Path,
    *,
    retry: bool = False,
    shard: tuple[int, int] = (1, 1),
    threads: int = 1,
    warn: Callable[[Sequence[str]], None] | None = None,
) -> list[SystemTask]:
    """Make the folder of a sweep and list its systems; returns the tasks, done or not.

    Parameters
    ----------
    retry : also run failed systems again.
    shard : (i, n) takes the i-th of n parts, which take about equally long.
    threads : threads of the solver of each system.
    warn : called with differences from the sweep in the folder.

    Raises ConfigError if a system is not a valid input of a run; OutputError if the folder cannot be written to, or
    has another sweep or files of the user.
    """
    folder = Folder(Path(root))
    listing, tasks, said = _planned(sweep, folder)
    output.distinct(folder.description, [sweep.source.path])
    folder.require_free_of_others()
    changes = [*said, *_require_same_sweep(folder, listing, _growth_in_words(tasks))]
    folder.make()
    if changes and warn is not None:
        warn(changes)
    save_once(folder.description, sweep.text)
    save_once(folder.listing, listing_text(listing))
    for column in sweep.columns:
        save_once(output.folder(folder.columns) / column.file_name, column.kept_text)
    failed = names(folder.failed)
    if retry:
        for name in failed:
            folder.failure(name).unlink(missing_ok=True)
        failed = frozenset()
    part, parts = shard
    mine = sorted(tasks, key=lambda task: (-task.cost, task.path.name))[part - 1 :: parts]
    left = [task for task in mine if task.path.stem not in failed]
    if threads == 1:
        return left
    sources = (task.plan.source.changed({"solver.threads": threads}) for task in left if task.plan.source is not None)
    return [replace(t, plan=replace(t.plan, source=source)) for t, source in zip(left, sources, strict=True)]


def _planned(sweep: Sweep, folder: Folder) -> tuple[SweepListing, list[SystemTask], list[str]]:
    """The systems of a sweep and their tasks, with the defaults that its folder was begun with, and what to say of it.

    A folder that has none of the systems, nor a path that one continues, may have them by the defaults of an earlier
    version.
    """
    made_of = _made_of(sweep)
    try:
        stored = systems_of(folder.root)
    except SweepError:
        return (*_with_growth(sweep, folder, made_of), [])
    if made_of and stored.made_of == made_of:
        return stored, _grown(folder, stored, [_task(folder, sweep, system) for system in stored.systems]), []
    first, before = _with_growth(sweep, folder, made_of), stored.keys

    def known(listing: SweepListing, tasks: list[SystemTask]) -> bool:
        return not before.isdisjoint(listing.keys) or any(task.growth is not None for task in tasks)

    if not known(*first):
        for until, values in former_settings(first[1][0].plan.config):
            found = _with_growth(replace(sweep, base=sweep.base.changed(values)), folder)
            if known(*found):
                said = f"{folder.root}: was begun with other defaults, which held until {until}, and goes on with them"
                return (*found, [said])
    return (*first, [])


def _made_of(sweep: Sweep) -> str:
    """Hash of all that the systems of a sweep follow from, but for files that it names; empty if that is not known.

    Input and version, of a checkout without changes; a search has systems that are not listed yet.
    """
    made = provenance()
    if sweep.bisection is not None or made.get("provenance/git_dirty"):
        return ""
    content = [sweep.text, made_by(made), *(column.made for column in sweep.columns)]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def _task(folder: Folder, sweep: Sweep, system: System) -> SystemTask:
    """The task of a listed system, whose input is checked when it is run."""
    key, cost, memory = system.key, system.cost, system.memory
    # Not by ``replace``, which takes a tenth of the time in which many systems are listed.
    plan = system if system.source is sweep.base else System(key, system.settings, cost, memory, sweep.base)
    return SystemTask(folder.point(key), plan.label, cost, memory, plan.kind, plan=plan, columns=sweep.columns)


def _with_growth(sweep: Sweep, folder: Folder, made_of: str = "") -> tuple[SweepListing, list[SystemTask]]:
    listing, tasks = _listed(sweep, folder, made_of)
    return listing, _grown(folder, listing, tasks)


def _grown(folder: Folder, listing: SweepListing, tasks: Sequence[SystemTask]) -> list[SystemTask]:
    """Tasks with the stored paths that unfinished ones continue, and their remaining cost."""
    # Only files that are not a system of this sweep, so that an interrupted sweep is not searched.
    listed = {folder.stem(key) for key in listing.keys}
    others = [folder.points / f"{name}.h5" for name in names(folder.points) - listed]
    if not others or listing.bisection is not None:
        return list(tasks)
    left = {task.path.name: task.plan.config for task in tasks if not task.path.is_file()}
    found = growths(left, sorted(others))
    return [
        replace(task, growth=growth, cost=task.cost * (1 - growth.kept / task.plan.config.loading.points))
        if (growth := found.get(task.path.name)) is not None
        else task
        for task in tasks
    ]


def _growth_in_words(tasks: Sequence[SystemTask]) -> list[str]:
    found = [task for task in tasks if task.growth is not None]
    points = sum(task.plan.config.loading.points for task in found)
    kept, refined = (sum(getattr(task.growth, name) for task in found) for name in ("kept", "refined"))
    if not found:
        return []
    how = f"{kept} of their {points} points are kept"
    if refined:
        how += f", {refined} are solved more closely from their stored states"
    return [f"{len(found)} of the new systems continue stored paths: {how}"]


def solve_system(root: Path, task: SystemTask) -> None:
    """Run one system: compute its path and its numbers, move its file to the finished ones, and add its columns.

    Raises LockedError if another process works on it, ColumnError if a column of one's own fails.
    """
    folder = Folder(root)
    working = folder.running / task.path.name
    with output.reserved(folder.running / task.path.stem):
        config = task.plan.config
        if identity(config) != task.plan.key:
            raise OutputError(f"{folder.listing}: lists {task.label} as another system; delete it, and run again")
        require_functions(task.columns)  # before a path of hours
        if not task.path.is_file():  # else it was done before, or meanwhile by another process
            try:
                if working.exists() and store.schema_of(working) != RunConfig.result_schema:
                    working.unlink()  # remains of an interrupted machine
            except UnreadError as error:  # not a fault of the system
                raise OutputError(str(error)) from error
            follow_run(
                config,
                working,
                every=_EVERY,
                growth=task.growth,
                progress=lambda _, done, total: say(done / total),
                added=ADDED,
            )
            output.placed(working, task.path)
        add_columns(folder, task.plan.key, task.columns)
        folder.failure(task.path.stem).unlink(missing_ok=True)
        folder.death(task.path.stem).unlink(missing_ok=True)


def _listed(sweep: Sweep, folder: Folder, made_of: str) -> tuple[SweepListing, list[SystemTask]]:
    tasks = list[SystemTask]()
    common: dict[str, Any] = {}
    costs = dict[int, Cost]()
    for plan, config, alike in sweep.plans():
        if not alike:
            values = dict(dotted(config.plain()))
            # Keys that follow from one on an axis, as the period from the points, are not common.
            common = {key: value for key, value in common.items() if values.get(key) == value} if tasks else values
            if len(config.files) > 1:  # beside the input itself
                made_of = ""
            costs[id(config)] = cost_of(config)
        cost = costs[id(config)]
        plan = System(plan.key, plan.settings, cost.effort, float(cost.memory), plan.source)
        tasks.append(_task(folder, sweep, plan))
    axes, search = sweep.axes, sweep.bisection
    if search is not None:
        axes += (Axis((search.key,), ((search.first,), (search.last,))),)
    on_axes = {key for axis in axes for key in axis.keys}
    common = {key: value for key, value in common.items() if key not in on_axes}
    systems = tuple(task.plan for task in tasks)
    listing = with_trials(
        folder, SweepListing(sweep.name, axes, common, systems, search, columns=sweep.columns, made_of=made_of)
    )
    if search is not None:
        tasks = [_search_task(folder, search, each, sweep.columns) for each in listing.searches]
    return listing, tasks


def _search_task(folder: Folder, search: Bisection, of: SweepSearch, columns: tuple[OwnColumn, ...]) -> SystemTask:
    lower, *_, upper = of.systems
    label = label_of({**lower.settings, search.key: f"{search.first:g} to {search.last:g}"})
    cost, memory = search.most * max(lower.cost, upper.cost), max(lower.memory, upper.memory)
    path = folder.search(of.name)
    return SystemTask(
        path, label, cost, memory, lower.kind, plan=lower, bisection=search, upper=upper.key, columns=columns
    )


def _require_same_sweep(folder: Folder, listing: SweepListing, grown: Sequence[str]) -> list[str]:
    """Check that a folder has no results of another sweep; files of systems that are no longer listed are kept.

    Two sweeps count as versions of one if they have a system in common, or if systems continue stored paths
    (``grown``).  Returns the differences as text.
    """
    try:
        earlier = systems_of(folder.root)
    except SweepError:
        return []
    before, now = earlier.keys, listing.keys
    if folder.begun and not before & now and not grown:
        differ = [f"\n    {line}" for line in _differences(earlier, listing)[:_MOST]]
        raise OutputError(
            f"{folder.root}: holds another sweep, and none of its {len(before)} systems is one of this sweep; choose "
            f"another output folder, or give the input another name{''.join(differ)}{_versions(folder)}"
        )
    if before - now:  # input and listing are kept before they are replaced, under names made from their content
        for path in filter(Path.is_file, (folder.description, folder.listing)):
            content = path.read_bytes()
            kept = f"{path.stem}-{hashlib.sha256(content).hexdigest()[:12]}{path.suffix}"
            output.save(output.folder(folder.root / "earlier") / kept, content, own=True)
    changes = _changes(earlier, listing, grown)
    return [f"{folder.root}: the sweep has changed: {changes[0]}", *changes[1:]] if changes else []


def _versions(folder: Folder) -> str:
    """The versions of a stored system and of this program, in words; empty if no system can be read."""
    names = ("provenance/stickiness", "provenance/git_commit", "provenance/git_dirty")
    for path in folder.points.glob("[!.]*"):
        with suppress(StoreError):
            made = store.read_few(path, (), names)[1]
            return f"\n    stored by {made_by(made)}; this is {made_by(provenance())}"
    return ""


def changes_of(root: str | Path, sweep: Sweep) -> list[str]:
    """Changes that running an input would make in a folder, as text; empty if the sweep is the same.

    Raises SweepError if there is no sweep, ConfigError if a system is not a valid input of a run.
    """
    listing, tasks, said = _planned(sweep, Folder(Path(root)))
    return [*said, *_changes(systems_of(root), listing, _growth_in_words(tasks))]


def _changes(earlier: SweepListing, listing: SweepListing, grown: Sequence[str]) -> list[str]:
    before, now = earlier.keys, listing.keys
    if before == now and (earlier.bisection, earlier.columns) == (listing.bisection, listing.columns):
        return []
    counts = f"new systems: {len(now - before)}, the same: {len(before & now)}, no longer listed: {len(before - now)}"
    if not before & now and not grown:
        counts += "; as none is the same, it needs another output folder or name"
    elif before - now:
        counts += "; files of these stay, and their input is kept in earlier/"
    return [counts, *grown, *_differences(earlier, listing)]


def _differences(before: SweepListing, now: SweepListing) -> list[str]:
    values = [
        {
            **one.common,
            **{k: list(v) for axis in one.axes for k, v in zip(axis.keys, zip(*axis.values, strict=True), strict=True)},
            **({one.bisection.key: one.bisection.table} if one.bisection else {}),
            **{f"column {column.name}": column.made for column in one.columns},
        }
        for one in (before, now)
    ]
    old, new = ({key: json.loads(json.dumps(value)) for key, value in one.items()} for one in values)
    return [f"{key}: {old.get(key)}, now {new.get(key)}" for key in {**old, **new} if old.get(key) != new.get(key)]


def record_death(root: Path, task: Task, death: str) -> None:
    """Record the death of a process at a system until the system is done."""
    with suppress(OutputError):
        output.save(Folder(root).death(task.path.stem), f"{death}, {time.strftime('%Y-%m-%d %H:%M:%S')}\n", own=True)


def record(root: Path, ended: TaskResult) -> None:
    """Record why a system failed; errors of writing are ignored, as the caller also gets the reason."""
    # A full disk, or the lock of another process, is not a fault of the system.
    if ended.ok or isinstance(ended.error, OutputError):
        return
    journalled = {name.removeprefix("journal/"): value for name, value in journal().items()}
    content = {"system": ended.task.label, "reason": ended.reason, **journalled}
    with suppress(OutputError):
        output.save(Folder(root).failure(ended.task.path.stem), json.dumps(content, indent=1) + "\n", own=True)
