"""The listing of a sweep: its systems with their values on the axes, as its folder has it.

``systems.json`` has one line for each system, so that a long list remains readable.  Whoever wrote it, reading it gives
systems with names of files in the folder, or SweepError.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from continuum.store.runs.reuse import read_trials
from continuum.store.sweeps.axes import Axis, System
from continuum.store.sweeps.bisection import Bisection, bisection_faults
from continuum.store.sweeps.columns import OwnColumn
from continuum.store.sweeps.folder import Folder, SweepError

_HASH = re.compile("[0-9a-f]{64}")


@dataclass(frozen=True)
class SweepSearch:
    """A search of a sweep, in one combination of its axes."""

    name: str
    """Name of its files, made from the search and the systems at its ends."""
    systems: tuple[System, ...]
    """Its ends and the trials between them, in the order of the key."""


@dataclass(frozen=True)
class SweepListing:
    """The systems of a sweep."""

    name: str
    axes: tuple[Axis, ...]
    """The axes; the key of a search is the last, with the values tried."""
    common: Mapping[str, Any]
    """Values of all other keys of the input, defaults included."""
    systems: tuple[System, ...]
    """All systems; trials of searches are added as they are run."""
    bisection: Bisection | None = None
    """What is searched for, if anything is."""
    searches: tuple[SweepSearch, ...] = ()
    columns: tuple[OwnColumn, ...] = ()
    """Columns of one's own."""
    made_of: str = ""
    """Hash of the input and the version that it was made of; empty where other files belong to the input."""

    @property
    def keys(self) -> set[str]:
        return {system.key for system in self.systems}


def systems_of(root: str | Path) -> SweepListing:
    """The systems of the sweep in a folder; raises SweepError if there is none."""
    folder = Folder(Path(root))
    try:
        return with_trials(folder, _listing(json.loads(folder.listing.read_text(encoding="utf-8"))))
    except FileNotFoundError:
        raise SweepError(f"{root}: is not the folder of a sweep; `continuum sweep run FILE.toml` makes one") from None
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        msg = f"{folder.listing}: cannot be read ({error}); the same `continuum sweep run` writes it again"
        raise SweepError(msg) from error


def _listing(data: dict[str, Any]) -> SweepListing:
    """The listing of its stored form; raises ValueError, KeyError or TypeError if it is none."""
    axes = tuple(
        Axis(tuple(map(_text, axis["keys"])), tuple(tuple(place) for place in axis["values"])) for axis in data["axes"]
    )
    if any(len(place) != len(axis.keys) for axis in axes for place in axis.values):
        raise ValueError("an axis has not a value for each of its keys")
    keys = [key for axis in axes for key in axis.keys]
    systems, rows = list[System](), list(reversed(data.pop("systems")))
    while rows:  # a row is dropped when it is read: those of a million systems take 400 MB
        key, values, cost, memory = rows.pop()
        systems.append(System(_identity(key), dict(zip(keys, values, strict=True)), _number(cost), _number(memory)))
    columns = tuple(
        OwnColumn(_text(one["name"]), _text(one["origin"]), _identity(one["digest"])) for one in data.get("columns", ())
    )
    if not all(column.name.isidentifier() for column in columns):
        raise ValueError("the name of a column is none")
    search = _bisection(data["bisection"], columns) if data.get("bisection") else None
    if search is not None and keys[-1:] != [search.key]:
        raise ValueError("the key that is searched for is not the last")
    for axis in axes if search is None else axes[:-1]:  # values that a search has tried are not listed
        known = set(map(repr, axis.values))
        if any(repr(tuple(system.settings[key] for key in axis.keys)) not in known for system in systems):
            raise ValueError(f"a value of {axis.keys[0]} is not on its axis")
    if not isinstance(data["common"], dict):
        raise TypeError("common is no table")
    made_of = _text(data.get("made_of", ""))
    return SweepListing(
        _text(data["name"]), axes, data["common"], tuple(systems), search, columns=columns, made_of=made_of
    )


def _bisection(data: dict[str, Any], columns: tuple[OwnColumn, ...]) -> Bisection:
    at = "" if data["target"] is None else f" at {_number(data['target'])!r}"
    ends = {"from": data["first"], "to": data["last"], "tolerance": data["tolerance"], "crosses": data["crosses"]}
    table = {"bisect": f"{_text(data['column'])}{at}", "scale": data["scale"], **ends}
    for fault in bisection_faults(table, [column.name for column in columns]):
        raise ValueError(f"the search for {data['key']}: {fault.allowed}")
    return Bisection.of(_text(data["key"]), table)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.40} is no text")
    return value


def _number(value: Any) -> float:
    if type(value) not in (int, float) or not math.isfinite(value):
        raise ValueError(f"{value!r:.40} is no number")
    return float(value)


def _identity(value: Any) -> str:
    """A hash: nothing else becomes the name of a file."""
    if not _HASH.fullmatch(_text(value)):
        raise ValueError(f"{value!r:.40} is no identity")
    return str(value)


def listing_text(listing: SweepListing) -> str:
    """The stored form of a listing."""
    axes, systems, added = listing.axes, listing.systems, dict[str, Any]()
    if listing.bisection is not None:  # without keys that searches change
        systems = tuple(end for each in listing.searches for end in (each.systems[0], each.systems[-1]))
        ends = tuple((system.settings[listing.bisection.key],) for system in systems[:2])
        axes, added = (*axes[:-1], replace(axes[-1], values=ends)), {"bisection": vars(listing.bisection)}
    if listing.made_of:
        added["made_of"] = listing.made_of
    if listing.columns:
        added["columns"] = [
            {name: getattr(one, name) for name in ("name", "origin", "digest")} for one in listing.columns
        ]
    named = [{"keys": axis.keys, "values": axis.values} for axis in axes]
    head = {"schema": "stickiness/sweep", "schema_version": 1, "name": listing.name, "axes": named, **added}
    # One line for each system, so that a long list remains readable.
    rows = [json.dumps([s.key, list(s.settings.values()), s.cost, s.memory]) for s in systems]
    start = json.dumps({**head, "common": listing.common})
    return start[:-1] + ', "systems": [\n' + ",\n".join(rows) + "\n]}\n"


def tried(path: Path) -> dict[float, str]:
    """The trials of a search between its ends, by the value of its key; empty if its file cannot be read."""
    try:
        return {_number(value): _identity(key) for value, key in read_trials(path)}
    except (ValueError, TypeError):
        return {}


def with_trials(folder: Folder, listing: SweepListing) -> SweepListing:
    """A listing of the ends of searches, with the trials between them."""
    if (search := listing.bisection) is None:
        return listing
    searches = []
    for lower, upper in zip(listing.systems[::2], listing.systems[1::2], strict=True):
        # With another tolerance it is continued under the same name.
        content = json.dumps([lower.key, upper.key, search.column, search.target, search.crosses, search.scale])
        name = hashlib.sha256(content.encode()).hexdigest()[:24]
        cost, memory = max(lower.cost, upper.cost), max(lower.memory, upper.memory)
        between = (
            System(key, {**lower.settings, search.key: value}, cost, memory)
            for value, key in sorted(tried(folder.search(name)).items())
        )
        searches.append(SweepSearch(name, (lower, *between, upper)))
    systems = tuple(system for each in searches for system in each.systems)
    values = sorted({system.settings[search.key] for system in systems})
    axes = (*listing.axes[:-1], Axis((search.key,), tuple((value,) for value in values)))
    return replace(listing, axes=axes, systems=systems, searches=tuple(searches))
