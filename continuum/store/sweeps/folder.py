"""The folder of a sweep: its files, and checks that no file of the user is overwritten.

It holds ``sweep.toml`` (the input), ``systems.json`` (what it amounts to), ``points/KEY.h5`` (the systems that are
done, never changed again), ``work/`` (those that are running), ``failed/KEY.json`` (why one could not be done),
``earlier/`` (inputs that listed systems which the present one does not), the tables ``table.csv`` and ``table.h5``, and
of searches ``searches/NAME.json`` (which systems one has tried) and ``crossings.csv`` (what they have found); of
columns of one's own ``columns/KEY.json`` (their numbers in a system) and the functions themselves.
"""

import json
from contextlib import suppress
from pathlib import Path

from continuum.inputs.errors import InputError, OutputError
from continuum.store import datasets as store
from continuum.store import output

_DIGITS = 24
"""Digits of an identity in the name of a file."""
TABLE_SCHEMA = "stickiness/sweep-table"
"""Schema of the table of all points."""


class SweepError(InputError, OSError):
    """A folder is not a sweep, or is damaged."""


class Folder:
    """Paths of the files of a sweep."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.description = root / "sweep.toml"
        self.listing = root / "systems.json"
        self.points = root / "points"
        self.running = root / "work"
        self.failed = root / "failed"
        self.folders = self.points, self.running, self.failed
        self.tables = root / "table.csv", root / "table.h5"  # of all points, as text and for xarray
        self.kept = root / ".kept.h5"  # what the tables were made of
        self.searches = root / "searches"
        self.crossings = root / "crossings.csv"
        self.columns = root / "columns"

    @staticmethod
    def stem(key: str) -> str:
        """Stem of the names of the files of a system."""
        return key[:_DIGITS]

    def point(self, key: str) -> Path:
        return self.points / f"{key[:_DIGITS]}.h5"

    def own(self, key: str) -> Path:
        """File of the columns of one's own of a system."""
        return self.columns / f"{key[:_DIGITS]}.json"

    def failure(self, key: str) -> Path:
        return self.failed / f"{key[:_DIGITS]}.json"

    def death(self, key: str) -> Path:
        """File that records the death of a process at an unfinished system."""
        return self.running / f"{key[:_DIGITS]}.died"

    def search(self, name: str) -> Path:
        return self.searches / f"{name[:_DIGITS]}.json"

    def failure_reason(self, key: str) -> str:
        """The first line of the reason why a system or a search failed; empty if there is no record."""
        try:
            reason = str(json.loads(self.failure(key).read_text(encoding="utf-8"))["reason"]).splitlines()[0]
        except FileNotFoundError:
            return ""
        except (OSError, ValueError, KeyError, IndexError, TypeError, RecursionError):
            return "its record cannot be read"
        return "".join(letter if letter.isprintable() else "?" for letter in reason)

    def make(self) -> None:
        """Make its folders; raises OutputError if they cannot be made or written to."""
        for path in (self.root, *self.folders):
            output.folder(path)

    @property
    def begun(self) -> bool:
        """Whether there are results, or processes may be running."""
        return bool(names(self.points) or names(self.running))

    def require_free_of_others(self) -> None:
        """Check that the folder has no files with names of a sweep that no sweep has written.

        Raises OutputError that names the first of them.
        """
        self.require_tables_of_ours()
        # The folders are known by their names where the listing was damaged.
        ours = _begins_with(self.listing, b'{"schema": "stickiness/sweep"') or all(map(Path.is_dir, self.folders))
        there = [path for path in (self.description, self.listing) if path.exists()]
        there += [path for path in self.folders if names(path)]
        if there and not ours:
            raise _of_another(there[0])

    def require_tables_of_ours(self) -> None:
        """Check that existing ``table.csv``, ``table.h5`` and ``crossings.csv`` are tables of a sweep.

        Raises OutputError that names it.
        """
        text, cube = self.tables
        if text.exists() and not _begins_with(text, b"system,"):  # its first column
            raise _of_another(text)
        if cube.exists() and store.schema_of(cube) != TABLE_SCHEMA:
            raise _of_another(cube)
        if self.crossings.exists() and not _begins_with(self.crossings, b"search,"):
            raise _of_another(self.crossings)


def names(path: Path) -> frozenset[str]:
    """Stems of the files of a folder, without hidden ones; empty if there is no such folder."""
    return frozenset(entry.stem for entry in path.glob("[!.]*"))


def save_once(path: Path, text: str) -> None:
    """Write a file unless it exists with the same content, as several processes may start together."""
    with suppress(OSError, ValueError):
        if path.read_text() == text:
            return
    output.save(path, text, own=True)


def _begins_with(path: Path, start: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(start)) == start
    except OSError:
        return False


def _of_another(path: Path) -> OutputError:
    msg = f"{path}: was not written by a sweep, and is left alone; move it, or choose another output folder"
    return OutputError(msg)
