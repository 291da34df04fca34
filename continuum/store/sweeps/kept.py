"""Cache of what a collection of a sweep has read, in one file of its folder: the next one reads only what is new.

A system counts as read if its file has the size and the time of change that it had then: finished files never change.
"""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from continuum.inputs.errors import OutputError
from continuum.store import datasets as store
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import StoreError, understood
from continuum.store.output import remove_stale
from continuum.store.sweeps.measured import COLUMNS, SystemTable

_SCHEMA, _VERSION = "stickiness/sweep-kept", 1


class Stamp(NamedTuple):
    """Size of a file, in bytes, and time of its last change, in ns."""

    size: int
    changed: int

    @classmethod
    def of(cls, path: Path) -> "Stamp":
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
