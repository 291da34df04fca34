"""Columns of one's own: functions of a stored run that the worker calls when a system is done.

Their numbers are stored beside the systems, in ``columns/KEY.json``, with a hash of what computed them: files of
systems stay as they are, and after a change of a function its column is computed anew.
"""

import hashlib
import inspect
import json
import pickle
import re
import reprlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import cloudpickle
import numpy as np

from continuum.arguments import ArgumentError
from continuum.errors import OutputError, StickinessError
from continuum.files import output
from continuum.files.hdf5 import StoreError
from continuum.files.toml import ConfigError, Source, slip
from continuum.model.fourier import Real
from continuum.runs.result import Result
from continuum.sweeps.folder import Folder
from continuum.sweeps.measured import COLUMNS
from continuum.tables import Fault

ColumnFunction = Callable[[Result], Any]
"""A function of a stored run that returns a number for each point of its path, or one for all of them."""
OF_PYTHON = "a function of Python"
"""What an input says of a column whose function was given in Python."""
_ALLOWED = 'a Python file, beside the input, as "mine.py" with a function of that name, or "mine.py:function"'
_FILE = re.compile(r"(.+\.py)(?::\s*(\w+))?")
_TAKEN = {*COLUMNS, "system", "count", "search", "trial"}
"""Columns of the tables, and what else has a name there."""


class ColumnError(StickinessError):
    """A function of the user's failed, or returned no numbers; the system itself is stored."""


@dataclass(frozen=True)
class OwnColumn:
    """A column of one's own."""

    name: str
    origin: str
    """Where its function is, as "mine.py:largest"."""
    digest: str
    """Hash of the text of the file, or of the function as it is sent to other processes."""
    text: str = field(default="", repr=False, compare=False)
    """Text of the file, or of the function; empty where it is not known."""
    code: bytes = field(default=b"", repr=False, compare=False)
    """The function as it is sent to other processes; empty of a stored listing."""

    @property
    def made(self) -> str:
        """Where its function is, and the beginning of its hash."""
        return f"{self.origin} ({self.digest[:12]})"

    @property
    def file_name(self) -> str:
        """Name under which its text is kept in the folder of the sweep."""
        return f"{self.name}-{self.digest[:12]}.py"

    def of(self, result: Result) -> Real:
        """The column of a run, a number for each point; NaN where it has none.

        Raises whatever the function raises; ColumnError if it does not return numbers.
        """
        returned, points = pickle.loads(self.code)(result), len(result.points)
        try:
            found = np.asarray(returned)
        except ValueError:  # lists of several lengths
            found = np.asarray(None)
        if found.dtype.kind not in "biuf" or found.shape not in ((), (points,)) or np.isinf(found).any():
            raise ColumnError(
                f"returned {reprlib.repr(returned)}; allowed: a number for each of the {points} points of the path, or "
                "one for all; nan where there is none"
            )
        return np.broadcast_to(found.astype(np.float64), points)


def functions_by_name(columns: Any) -> dict[str, ColumnFunction]:
    """The functions of columns that were given in Python; ArgumentError if they are none."""
    if columns is not None and not (
        isinstance(columns, Mapping)
        and all(isinstance(name, str) for name in columns)
        and all(map(callable, columns.values()))
    ):
        raise ArgumentError("columns", columns, 'functions by the names of columns, as {"patches": count_patches}')
    return dict(columns or {})


def name_faults(name: str, on_axes: Sequence[str]) -> Iterator[Fault]:
    """What is wrong with the name of a column."""
    taken = name in _TAKEN or name in on_axes or name.startswith(("inverse_", "crossing")) or name.endswith("_error")
    if taken or not name.isidentifier():
        cause = "the table has a column of this name, or makes one" if taken else ""
        yield Fault(("columns", name), "a name of letters, digits and _ that the table does not have yet", cause)


def own_columns(
    source: Source, given: Mapping[str, str], functions: Mapping[str, ColumnFunction]
) -> tuple[OwnColumn, ...]:
    """The columns of a table [sweep.columns], and those whose functions were given in Python.

    Raises ConfigError with all files and functions that cannot be used.
    """
    found, faults = list[OwnColumn](), list[Fault]()
    for name, said in given.items():
        try:
            found.append(_of_python(name, functions[name]) if name in functions else _of_file(name, said, source.path))
        except ValueError as error:
            faults.append(Fault(("sweep", "columns", name), _ALLOWED, str(error)))
    if faults:
        raise ConfigError(source, faults)
    return tuple(found)


def _of_file(name: str, said: str, beside: Path) -> OwnColumn:
    if said == OF_PYTHON:
        raise ValueError("its function was given in Python; columns/ of that sweep keeps its text")
    matched = _FILE.fullmatch(said)
    if matched is None:
        raise ValueError("")
    path, wanted = beside.parent / matched[1], matched[2] or name
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise ValueError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    module = ModuleType(f"columns of {path.name}")  # no name to import: its functions are sent with what they use
    module.__file__ = str(path)
    try:
        exec(compile(text, str(path), "exec"), vars(module))
    except (Exception, SystemExit) as error:
        raise ValueError(f"{path} cannot be executed: {type(error).__name__}: {error}") from None
    function = vars(module).get(wanted)
    if not callable(function):
        functions = [one for one, value in vars(module).items() if callable(value)]
        hint = slip(wanted, functions, "; did you mean {}?")
        raise ValueError(f"{path} has no function {wanted}{hint}")
    digest = hashlib.sha256(f"{wanted}\n{text}".encode()).hexdigest()
    return OwnColumn(name, f"{path.name}:{wanted}", digest, text, _sent(function))


def _of_python(name: str, function: ColumnFunction) -> OwnColumn:
    code, text = _sent(function), ""
    with suppress(OSError, TypeError):  # typed at a prompt, or of a library
        text = inspect.getsource(function)
    digest = hashlib.sha256(code + text.encode()).hexdigest()
    return OwnColumn(name, f"{OF_PYTHON}, {getattr(function, '__name__', name)}", digest, text, code)


def _sent(function: Any) -> bytes:
    """A function as bytes, with what it uses of its script."""
    try:
        code: bytes = cloudpickle.dumps(function)
    except Exception as error:
        msg = f"it cannot be sent to other processes, with what it uses: {type(error).__name__}: {error}"
        raise ValueError(msg) from None
    return code


def add_columns(folder: Folder, key: str, columns: Sequence[OwnColumn]) -> None:
    """Compute and store what is missing of the columns of a finished system.

    Raises ColumnError with all that failed, after the others are stored; OutputError if the system cannot be read.
    """
    known = _stored(folder, key)
    missing = [one for one in columns if known.get(one.name, ("",))[0] != one.digest]
    if not missing:
        return
    try:
        result = Result.read(folder.point(key))
    except StoreError as error:  # not a fault of a column
        raise OutputError(f"{error}; `continuum sweep verify --aside` moves it away") from error
    said = []
    for column in missing:
        known.pop(column.name, None)
        try:
            known[column.name] = column.digest, column.of(result)
        except ColumnError as error:
            said.append(f"column {column.name} ({column.origin}) {error}")
        except Exception as error:
            said.append(f"column {column.name} ({column.origin}): {type(error).__name__}: {error}")
    numbers = {
        name: (digest, [None if np.isnan(value) else value for value in values.tolist()])
        for name, (digest, values) in known.items()
    }
    content = {"schema": "stickiness/columns", "system": key, "columns": numbers}
    output.save(output.folder(folder.columns) / folder.own(key).name, json.dumps(content) + "\n", own=True)
    if said:
        raise ColumnError(f"{'; '.join(said)}; its points are stored: mend it and run again with --retry")


def columns_of(folder: Folder, key: str, columns: Sequence[OwnColumn]) -> dict[str, Real]:
    """Those of these columns that are stored of a system, a value for each of its points; NaN where there is none."""
    known = _stored(folder, key) if columns else {}
    return {one.name: known[one.name][1] for one in columns if one.name in known and known[one.name][0] == one.digest}


def _stored(folder: Folder, key: str) -> dict[str, tuple[str, Real]]:
    """Digest and values of each stored column; empty if there are none, or they cannot be read."""
    try:
        data = json.loads(folder.own(key).read_text(encoding="utf-8"))
        return {name: (digest, np.array(each, dtype=np.float64)) for name, (digest, each) in data["columns"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
