"""The trials of a search in a file of their own, from which a search that was stopped or killed goes on.

The next trial of a search follows from what was found at those before it.  So a search begins anew and is answered from
its file as far as that goes.  The trials of an axis of a sweep are systems, which have files of their own: their
identities are kept.  Those of a threshold are states: their numbers are kept.
"""

import hashlib
import json
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from continuum.store import output

SCHEMA = "stickiness/search"


def save_trials(path: Path, trials: Iterable[tuple[Any, Any]], of: str = "") -> None:
    """Write the place of each trial with what was found there, as numbers and text; ``of`` names the search."""
    rows = [list(each) for each in trials]
    content = {"schema": SCHEMA, **({"of": of, "sha256": _checksum(rows)} if of else {}), "trials": rows}
    output.save(path, json.dumps(content) + "\n", own=True)


def read_trials(path: Path, of: str = "") -> list[tuple[Any, Any]]:
    """Read the file of :func:`save_trials`; empty if it is damaged or of another search: that will write it again."""
    try:
        content = json.loads(path.read_text())
        rows = content["trials"]
        sound = not of or (content["of"] == of and content["sha256"] == _checksum(rows))
        return [(place, found) for place, found in rows] if sound else []
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []


def _checksum(rows: list[Any]) -> str:
    return hashlib.sha256(json.dumps(rows).encode()).hexdigest()


class KeptTrials:
    """The trials of a search whose places are numbers and words, and what was found there likewise.

    Parameters
    ----------
    path : their file.
    of : identity of what is searched for.
    every : seconds between two writes, as a trial may take less time than they do.
    """

    def __init__(self, path: Path, of: str, every: float = 1.0) -> None:
        self.path, self.of, self.every = path, of, every
        self._found: dict[tuple[Any, ...], list[Any]] = {tuple(place): found for place, found in read_trials(path, of)}
        self._written, self._unwritten = time.perf_counter(), False

    def at(self, search: float, at: tuple[Any, ...], find: Callable[[], list[Any]]) -> list[Any]:
        """What a search of many found at a place; only where nothing is kept of it is it found now."""
        place = (search, *at)
        if place not in self._found:
            self._found[place], self._unwritten = find(), True
            if time.perf_counter() - self._written >= self.every:
                self.save()
        return self._found[place]

    def save(self) -> None:
        """Write those that are not written yet."""
        if self._unwritten:
            save_trials(self.path, self._found.items(), self.of)
            self._written, self._unwritten = time.perf_counter(), False

    def drop(self) -> None:
        """Delete all trials, once the search has ended."""
        self._found, self._unwritten = {}, False
        self.path.unlink(missing_ok=True)
