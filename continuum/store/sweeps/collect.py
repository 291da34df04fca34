"""Results of a sweep: a table of all points, a cache of what was read for it, and the check of its files.

A system counts as read if its file has the size and the time of change that it had then: finished files never change.
So the next collection reads only what is new.
"""

from __future__ import annotations

import json
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.arguments import choice, file_name, flag
from continuum.inputs.keys import frozen
from continuum.inputs.toml import ConfigError
from continuum.model.fourier import Real
from continuum.model.grid import Grid, GridTable
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.hdf5 import StoreError, UnreadError
from continuum.store.identity import identity, restored
from continuum.store.runs.config import RunConfig
from continuum.store.sheet import Sheet, Shown, pairs
from continuum.store.sweeps.axes import System, as_cell
from continuum.store.sweeps.cluster import SweepTask
from continuum.store.sweeps.columns import column_faults
from continuum.store.sweeps.conditions import dotted
from continuum.store.sweeps.crossings import Crossing, asked_for, crossings_of, crossings_sheet, with_columns
from continuum.store.sweeps.folder import TABLE_SCHEMA, Folder, names
from continuum.store.sweeps.listing import SweepListing, systems_of
from continuum.store.sweeps.measured import COLUMNS, SystemTable, numbers_of
from continuum.store.sweeps.workers import TaskResult

if TYPE_CHECKING:
    import pandas
    import xarray
from contextlib import suppress
from typing import NamedTuple

from continuum.inputs.errors import OutputError
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import understood
from continuum.store.output import remove_stale

_SCHEMA, _VERSION = "stickiness/sweep-kept", 1
DAMAGED = "damaged"
"""Folder inside a sweep that damaged files are moved into."""
_EVERY = 20_000
"""Files that a collection reads again, at most, if it was killed: a minute of reading."""
_KAPPAS = ("kappa", "kappa_rep", "kappa_att")


class Stamp(NamedTuple):
    """Size of a file, in bytes, and time of its last change, in ns."""

    size: int
    changed: int

    @classmethod
    def of(cls, path: Path) -> Stamp:
        found = path.stat()
        return cls(found.st_size, found.st_mtime_ns)


KeptTables = dict[str, tuple[Stamp, SystemTable]]
"""Tables by the identity of their systems, each with the stamp of its file."""


def kept_tables(path: Path) -> KeptTables:
    """Tables that were read before; empty if there is no such file, or it is damaged or of other columns."""
    with suppress(StoreError):
        file = store.read_datasets(path, _SCHEMA, _VERSION)
        with understood(path):
            if file["quantity"].tolist() != list(COLUMNS):
                return {}
            tables = np.split(file["measured"], np.cumsum(file["points"])[:-1])
            stamps = map(Stamp, file["size"].tolist(), file["changed"].tolist())
            words = (file[name].tolist() for name in ("key", "seconds", "made"))
            each = zip(stamps, tables, *words, strict=True)
            return {key: (stamp, SystemTable(table, seconds, made)) for stamp, table, key, seconds, made in each}
    return {}


def keep_tables(path: Path, found: Mapping[str, tuple[Stamp, SystemTable]]) -> None:
    """Write what was read; a folder that cannot be written to keeps what it has."""
    if not found:
        return
    stamps, tables = zip(*found.values(), strict=True)
    system = ("system",)
    with suppress(OutputError, OSError):
        remove_stale(path)
        store.write(
            path,
            {
                "quantity": Dataset(np.array(list(COLUMNS)), ("quantity",), "", "columns of the table of numbers"),
                "key": Dataset(np.array(list(found)), system, "", "identity"),
                "size": Dataset(np.array([each.size for each in stamps]), system, "byte", "size of the file"),
                "changed": Dataset(np.array([each.changed for each in stamps]), system, "ns", "time of its change"),
                "points": Dataset(np.array([len(each.table) for each in tables]), system, "1", "points of the path"),
                "seconds": Dataset(np.array([each.seconds for each in tables]), system, "s", "wall time"),
                "made": Dataset(np.array([each.made for each in tables]), system, "", "version of the program"),
                "measured": Dataset(
                    np.concatenate([each.table for each in tables]), ("row", "quantity"), "", "numbers of each point"
                ),
            },
            {"schema": _SCHEMA, "schema_version": _VERSION},
        )


class LeftOutWarning(UserWarning):
    """Files of a sweep that could not be read are missing in a table or in means."""


@dataclass(frozen=True, eq=False, repr=False)
class PointTable(Shown):
    """Table of all converged points of a sweep, one per row."""

    listing: SweepListing = field(repr=False)
    keys: tuple[str, ...]
    """Systems that were read, in the order of the listing."""
    system: NDArray[np.int64]
    """Index of each point's system in ``keys``."""
    values: Real
    """One row for each point, one column for each of :data:`continuum.store.sweeps.measured.COLUMNS`."""
    seconds: Real
    """Wall time of each system."""
    unconverged: int
    """Number of points that did not converge and are left out."""
    missing: int
    """Systems that are not done."""
    faults: tuple[str, ...]
    """Files that could not be read."""
    provenance: Mapping[str, int]
    """Versions and commits that the points were computed with, and the number of systems of each."""
    files: tuple[Path, ...] = ()
    """Files that the table was written into."""
    crossings: tuple[Crossing, ...] = ()
    """Results of searches in each combination of the axes."""
    own: Mapping[str, Real] = field(default_factory=dict)
    """Columns of one's own, a value for each point; NaN where there is none."""
    lacking: tuple[str, ...] = ()
    """Columns of one's own that some systems lack, with the reason."""

    @property
    def columns(self) -> dict[str, tuple[str, str]]:
        """All columns of the table: unit and description."""
        return {**COLUMNS, **{one.name: ("", f"column of this sweep: {one.made}") for one in self.listing.columns}}

    def __getitem__(self, name: str) -> Real:
        """A column of the table, or the value of a key of the input such as ``surface.lambda_s``, for each point."""
        if name in self.own:
            return self.own[name]
        if name in COLUMNS:
            return self.values[:, list(COLUMNS).index(name)]
        per_system = np.array([self.setting(key, name) for key in self.keys])
        return per_system[self.system]

    def setting(self, key: str, name: str) -> Any:
        """The value of a key of the input in a system; NaN if it has none."""
        found = self._settings[key].get(name, self.listing.common.get(name))
        return np.nan if found is None else found

    def given(self, key: str, table: str) -> dict[str, Any]:
        """The given keys of a table of the input in a system."""
        values = {**self.listing.common, **self._settings[key]}
        inside = {name.partition(".")[2]: value for name, value in values.items() if name.startswith(f"{table}.")}
        return {name: frozen(value) for name, value in inside.items() if value is not None}

    def grid(self, key: str) -> Grid:
        return GridTable.model_validate(self.given(key, "grid")).build()

    @cached_property
    def _settings(self) -> dict[str, Mapping[str, Any]]:
        return {system.key: self._with_tables(system.settings) for system in self.listing.systems}

    def _with_tables(self, settings: Mapping[str, Any]) -> Mapping[str, Any]:
        """Settings; the keys of whole tables on an axis replace the common ones."""
        if not any(isinstance(values, Mapping) for values in settings.values()):
            return settings
        found = dict(settings)
        for table, values in settings.items():
            if isinstance(values, Mapping):
                found |= {name: None for name in self.listing.common if name.startswith(f"{table}.")}
                found |= {f"{table}.{name}": value for name, value in values.items()}
        return found

    @property
    def made(self) -> str:
        """Versions that the points were computed with, as text."""
        return "; ".join(f"{text} ({count} systems)" for text, count in self.provenance.items())

    def __repr__(self) -> str:
        there = f"{len(self.system)} points of {len(self.keys)} systems"
        left_out = f", {len(self.faults)} files LEFT OUT, see faults" if self.faults else ""
        return f"PointTable({self.listing.name!r}, {there}, {self.missing} systems missing{left_out})"

    def sheets(self) -> list[Sheet]:
        """The collected points, and the results of searches."""
        rows: list[tuple[str, str | int]] = [
            ("systems", len(self.keys)),
            ("points", len(self.system)),
            ("points that did not converge, left out", self.unconverged),
            ("systems that are not done", self.missing),
            ("files that cannot be read", len(self.faults)),
            *(("computed with", f"{made}: {count} systems") for made, count in self.provenance.items()),
        ]
        searched = [crossings_sheet(self.listing, self.crossings).beginning()] if self.crossings else []
        return [pairs(self.listing.name, rows), *searched]

    def to_pandas(self) -> pandas.DataFrame:
        """All points, one per row, with the keys on the axes, the columns of ``table.csv``, and the inverses of κ.

        ``attrs["units"]`` has the unit of each column.
        """
        import pandas  # imported late: takes half a second

        head, rows = self.rows()
        frame = pandas.DataFrame(rows, columns=[name for name, _ in head])
        for name in _KAPPAS:
            frame[f"inverse_{name}"] = 1 / frame[name]
        frame.attrs["units"] = {**dict(head), **{f"inverse_{name}": "1" for name in _KAPPAS}}
        return frame

    def means(self, over: str = "surface.seed") -> pandas.DataFrame:
        """Means over systems that differ in one key only, such as the seed, one row for each point of their paths.

        The columns are those of :meth:`to_pandas` without that key; NAME_error is the standard error of each mean, and
        ``count`` the number of systems.  Of κ the mean of the inverse is what the paper averages: ``inverse_kappa``.

        Raises ArgumentError if the key is on no axis, or changes together with others.
        """
        single = [axis.keys[0] for axis in self.listing.axes if len(axis.keys) == 1]
        choice("over", over, single)
        self._say_what_is_left_out()
        frame = self.to_pandas().drop(columns="system")
        others = [key for axis in self.listing.axes for key in axis.keys if key != over]
        groups = frame.drop(columns=over).groupby([*others, "step"], sort=False, dropna=False)
        columns = [name for name in frame if name not in (*others, "step", over)]
        means, errors = groups[columns].mean(), groups[columns].sem().add_suffix("_error")
        means.insert(0, "count", groups.size())
        return means.join(errors).reset_index()

    def to_xarray(self) -> xarray.Dataset:
        """All points with one dimension for each axis of the input, and ``step``, as in ``table.h5``.

        ``load`` is called ``load_net``, as each dataset has a method ``load``.
        """
        from continuum.store.sweeps.cube import cube_of  # xarray takes a while to import

        columns = {name: self[name] for name in self.columns}
        cube = cube_of(self.listing, self.crossings, self.keys, self.system, columns, self.columns)
        return cube.assign_attrs(
            schema=TABLE_SCHEMA, schema_version=1, name=self.listing.name, common=json.dumps(self.listing.common),
            systems=len(self.keys), systems_missing=self.missing, points=len(self.system),
            points_unconverged=self.unconverged, files_unreadable=len(self.faults),
            made_with=json.dumps(dict(self.provenance)),
        )  # fmt: skip

    def _say_what_is_left_out(self) -> None:
        if self.faults:
            systems = len(self.keys) + len(self.faults)
            said = f"{len(self.faults)} of {systems} files could not be read and are left out; the first: "
            warnings.warn(said + self.faults[0], LeftOutWarning, stacklevel=3)

    def rows(self) -> tuple[list[tuple[str, str]], Iterator[list[Any]]]:
        """Name and unit of each column, and the rows of the tidy table."""
        axes = [key for axis in self.listing.axes for key in axis.keys]
        head = [("system", ""), *((name, "") for name in axes), *((n, unit) for n, (unit, _) in self.columns.items())]
        values = np.column_stack([self.values, *self.own.values()])
        each = zip((self.keys[index] for index in self.system), values, strict=True)
        return head, ([key, *(as_cell(self.setting(key, name)) for name in axes), *row.tolist()] for key, row in each)


def collect(root: str | Path, *, keep: bool = False) -> PointTable:
    """Read all finished systems that were not read before; a file that cannot be read is a fault of the table.

    Parameters
    ----------
    keep : whether what is read is kept in the folder for the next time, also while others are still to be read.

    Raises SweepError if there is no sweep; warns with a LeftOutWarning of faults.
    """
    folder, listing = Folder(Path(root)), systems_of(root)
    found, faults, before = dict[str, SystemTable](), list[str](), kept_tables(folder.kept)
    done = names(folder.points)
    there = [each.key for each in listing.systems if folder.stem(each.key) in done]
    read: KeptTables = {}
    fresh = 0
    for key in there:
        try:
            stamp = Stamp.of(folder.point(key))
            known = before[key][1] if key in before and before[key][0] == stamp else None
            found[key] = with_columns(folder, key, listing.columns, known)
            read[key] = stamp, known or (replace(found[key], own={}) if found[key].own else found[key])
            if known is None and (fresh := fresh + 1) % _EVERY == 0 and keep:
                keep_tables(folder.kept, {**before, **read})
        except (StoreError, OSError) as error:
            faults.append(str(error))
    if keep and read != before:
        keep_tables(folder.kept, read)
    own_names = [column.name for column in listing.columns]
    complete = {key: one for key, one in found.items() if len(one.own) == len(own_names)}
    crossings = crossings_of(folder.root, listing, complete.get)
    asked = asked_for(listing, crossings, set(there))
    kept = [one["converged"] == 1 for one in found.values()]
    good = [one.table[points] for one, points in zip(found.values(), kept, strict=True)]
    own = {name: [one.own.get(name, np.full(len(one.table), np.nan)) for one in found.values()] for name in own_names}
    table = PointTable(
        listing,
        tuple(found),
        np.repeat(np.arange(len(good)), np.array([len(table) for table in good], dtype=int)),
        np.concatenate(good) if good else np.empty((0, len(COLUMNS))),
        np.array([one.seconds for one in found.values()]),
        sum(len(one.table) for one in found.values()) - sum(map(len, good)),
        len(asked.systems) - len(there),
        tuple(faults),
        dict(Counter(one.made for one in found.values())),
        crossings=crossings,
        own={name: np.concatenate([np.empty(0), *map(np.compress, kept, own[name])]) for name in own_names},
        lacking=tuple(_lacking(folder, found, own_names)),
    )
    table._say_what_is_left_out()
    return table


def _lacking(folder: Folder, found: Mapping[str, SystemTable], names: Sequence[str]) -> Iterator[str]:
    """Messages on own columns that systems lack: how many, and why."""
    for name in names:
        without = [key for key, one in found.items() if name not in one.own]
        if without:
            reasons = filter(None, map(folder.failure_reason, without))
            why = next(reasons, "not computed yet; the same `continuum sweep run` does it")
            yield f"{name} is missing in {len(without)} of {len(found)} systems: {why}"


@dataclass(frozen=True)
class SweepRun(Shown):
    """Result of one call of :func:`continuum.sweep`, with its points in the forms of :class:`PointTable`."""

    folder: Path
    total: int
    """Number of systems (or of searches, if a key is searched for) that this call had to do."""
    found: int
    """Number that was done before, or meanwhile by another process."""
    done: int
    failed: tuple[TaskResult, ...]
    """Systems that failed, with the reasons."""
    held: tuple[TaskResult, ...]
    """Systems that are locked by another process."""
    crossings: tuple[Crossing, ...] = ()
    """Results of the searches of this call."""
    died: tuple[str, ...] = ()
    """Processes that died, each with its system, which was then done again."""
    left: tuple[SweepTask, ...] = field(default=(), repr=False)
    """What is missing, where this call was to run nothing."""

    @property
    def ok(self) -> bool:
        """Whether all systems are done."""
        return not self.failed and not self.held

    def jobs(self) -> tuple[SweepTask, ...]:
        """Missing systems of a call with ``workers=0``, the longest first, for any scheduler."""
        return self.left

    def sheets(self) -> list[Sheet]:
        """Table of the numbers of systems done, and of those that failed."""
        rows = [("done", self.done), ("done before", self.found), ("failed", len(self.failed))]
        rows += [("locked by another process", len(self.held))] * bool(self.held)
        sheets = [pairs(str(self.folder), [("systems", self.total), *rows])]
        if self.failed:
            failed = [(ended.task.label, ended.reason) for ended in self.failed]
            sheets.append(Sheet.of("failed", ("system", "reason"), failed).beginning())
        return sheets

    def collect(self) -> PointTable:
        """All points that are done."""
        return collect(self.folder)

    def to_pandas(self) -> pandas.DataFrame:
        return self.collect().to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        return self.collect().to_xarray()

    def means(self, over: str = "surface.seed") -> pandas.DataFrame:
        return self.collect().means(over)


@dataclass(frozen=True)
class Verification:
    """Result of checking the files of a sweep."""

    files: int
    """Number of files of the sweep."""
    faults: tuple[str, ...]
    """Faults of damaged files, with their names."""
    unread: tuple[str, ...] = ()
    """Files that could not be read now, and why; they may be sound, and stay where they are."""
    moved: int = 0
    """Damaged files that were moved into the folder ``damaged``."""

    @property
    def ok(self) -> bool:
        """Whether every file was read, and none is damaged."""
        return not self.faults and not self.unread


def sweep_verify(sweep: str | Path, *, aside: bool = False) -> Verification:
    """Check every file of a sweep: checksums, schema, identity, and agreement with the listing and your columns.

    It does not look at the text of functions that were given in Python, nor at tables, which ``collect`` writes anew.

    Parameters
    ----------
    sweep : folder of the sweep.
    aside : move damaged files into the folder ``damaged``, so that the next run computes them again.

    Raises
    ------
    SweepError
        If there is no sweep.

    Examples
    --------
    >>> import continuum as c
    >>> c.sweep_verify("results/waves").ok  # all files are complete and as they were written
    True
    """
    root = file_name("sweep", sweep)
    flag("aside", aside)
    folder, listing = Folder(root), systems_of(root)
    paths = sorted(path for path in folder.points.iterdir() if not path.name.startswith("."))
    listed = {folder.point(system.key): system for system in listing.systems}
    faults, damaged, unread = list[str](), list[Path](), list[str]()
    for path in paths:
        try:
            config = _require_sound(path)
        except UnreadError as error:
            unread.append(str(error))
        except StoreError as error:
            faults.append(str(error))
            damaged.append(path)
        else:
            if path in listed and (said := _mislabelled(listing, listed[path], config)):
                faults.append(f"{folder.listing}: {said} in {path}; the same `continuum sweep run` writes it again")
    for path, said in column_faults(folder, listing.columns, listing.keys):
        faults.append(said)
        damaged.append(path)
    for path in damaged if aside else ():
        output.placed(path, output.folder(root / DAMAGED) / path.name)
    own = sum(1 for path in folder.columns.glob("[!.]*"))
    return Verification(len(paths) + own, tuple(faults), tuple(unread), len(damaged) if aside else 0)


def _mislabelled(listing: SweepListing, system: System, config: RunConfig) -> str:
    """The first number or word of a system that its listing has otherwise; empty if there is none."""
    stored = dict(dotted(config.plain())) if not config.files else {}
    for key, value in {**listing.common, **system.settings}.items():
        here = stored.get(key)
        if isinstance(value, str | int | float) and isinstance(here, str | int | float) and value != here:
            return f"lists {key} = {value}, which is {here}"
    return ""


def _require_sound(path: Path) -> RunConfig:
    """Check the file of a finished system; returns its input.

    Raises StoreError with its fault, UnreadError if it cannot be read now.
    """
    file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version, labels=True)
    numbers_of(path)
    key = str(file.attributes.get("identity"))
    if not (key and key.startswith(path.stem)):
        raise StoreError(f"{path}: holds another system ({key[:24]}...)")
    if not file.attributes.get("finished"):
        raise StoreError(f"{path}: is not finished")
    try:
        config = restored(RunConfig, str(file.attributes["config_resolved"]))
        sound = bool(config.files) or identity(config) == key
    except (ValueError, RecursionError, StoreError, ConfigError) as error:
        raise StoreError(f"{path}: its input cannot be read ({error})") from error
    if not sound:
        raise StoreError(f"{path}: its input is not the one that its identity was made of")
    return config
