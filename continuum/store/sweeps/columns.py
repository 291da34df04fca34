"""Columns of one's own: functions of a stored run that the worker calls when a system is done.

Their numbers are stored beside the systems, in ``columns/KEY.json``, with a hash of what computed them: files of
systems stay as they are, and after a change of a function, or of a module beside it that it imports, its column is
computed anew.  Reading an input executes none of them: definitions and imports of a Python file are found by parsing.
"""

import ast
import hashlib
import inspect
import json
import os
import pickle
import re
import reprlib
import signal
import sys
import sysconfig
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import cloudpickle
import numpy as np

from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import OutputError, StickinessError
from continuum.inputs.tables import Fault
from continuum.inputs.toml import ConfigError, Source, slip
from continuum.model.fourier import Real
from continuum.store import output
from continuum.store.hdf5 import StoreError
from continuum.store.runs.record import XARRAY_NAMES
from continuum.store.runs.result import Result
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.measured import COLUMNS
from continuum.store.sweeps.workers import StopSignal

ColumnFunction = Callable[[Result], Any]
"""A function of a stored run that returns a number for each point of its path, or one for all of them."""
OF_PYTHON = "a function of Python"
"""What an input says of a column whose function was given in Python."""
_ALLOWED = 'a Python file, beside the input, as "mine.py" with a function of that name, or "mine.py:function"'
_FILE = re.compile(r"(.+\.py)(?::\s*(\w+))?")
_TAKEN = {*COLUMNS, *XARRAY_NAMES.values(), "system", "count", "search", "trial"}
"""Columns of the tables, and what else has a name there."""


def defined_names(body: Sequence[ast.stmt]) -> Iterator[tuple[str, bool]]:
    """Names that the statements of a module define, and whether each may be a function; "*" for all of another one."""
    for statement in body:
        match statement:
            case ast.FunctionDef(name) | ast.ClassDef(name):
                yield name, True
            case ast.Import(names) | ast.ImportFrom(names=names):
                yield from ((one.asname or one.name.partition(".")[0], True) for one in names)
            case ast.Assign(value=value) | ast.AnnAssign(value=value):
                targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
                function = not isinstance(value, ast.Constant | ast.List | ast.Tuple | ast.Dict | ast.Set | None)
                yield from ((one.id, function) for one in targets if isinstance(one, ast.Name))
            case ast.If() | ast.Try() | ast.With():
                yield from defined_names(statement.body)
                yield from defined_names(getattr(statement, "orelse", []))
                for handler in getattr(statement, "handlers", []):
                    yield from defined_names(handler.body)


def with_text_of(helpers: Iterable[Path]) -> str:
    """The text of files, each below its name."""
    found = ""
    for path in sorted({*helpers}):
        with suppress(OSError, ValueError):
            found += f"\n# --- {path.name}\n{path.read_text(encoding='utf-8')}"
    return found


def helpers_of(path: Path) -> Iterator[Path]:
    """Files beside a Python file that it imports, and that these import."""
    seen, left = {path.resolve()}, [path.resolve()]
    while left:
        with suppress(OSError, SyntaxError, ValueError, RecursionError, MemoryError):
            here = left.pop()
            for node in ast.walk(ast.parse(here.read_bytes())):
                for name in _imported(node):
                    module = here.parent.joinpath(*name.split("."))
                    for file in (module.with_name(f"{module.name}.py"), module / "__init__.py"):
                        if file.is_file() and file.resolve() not in seen:
                            seen.add(file.resolve())
                            left.append(file.resolve())
                            yield file.resolve()


def _imported(node: ast.AST) -> Iterator[str]:
    """Names of modules that a statement may import."""
    match node:
        case ast.Import(names):
            yield from (one.name for one in names)
        case ast.ImportFrom(module, names):
            yield from ([module] if module else [])
            yield from (f"{module}.{one.name}" if module else one.name for one in names)


def modules_used_by(function: Any) -> Iterator[Path]:
    """Files of modules, not of libraries, that a function uses by its global names, and those that these import."""
    code, known = getattr(function, "__code__", None), getattr(function, "__globals__", {})
    libraries = [Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib", "platlib")]
    for name in getattr(code, "co_names", ()):
        used = known.get(name)
        module = used if isinstance(used, ModuleType) else sys.modules.get(getattr(used, "__module__", None) or "")
        file = Path(getattr(module, "__file__", None) or "")
        # A function of the script itself is sent with what it uses.
        ours = file.suffix == ".py" and getattr(module, "__name__", "") not in (
            "__main__",
            code and function.__module__,
        )
        if ours and not any(file.is_relative_to(library) for library in libraries):
            yield file.resolve()
            yield from helpers_of(file)


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
    beside: str = field(default="", repr=False, compare=False)
    """Text of the modules that it uses, but for libraries."""
    code: bytes = field(default=b"", repr=False, compare=False)
    """A function of Python as it is sent to other processes; empty of a file, and of a stored listing."""
    path: str = field(default="", repr=False, compare=False)
    """The file; empty of a function of Python, and of a stored listing."""

    @property
    def made(self) -> str:
        """Place of its function, and the beginning of its hash."""
        return f"{self.origin} ({self.digest[:12]})"

    @property
    def file_name(self) -> str:
        """Name under which its text is kept in the folder of the sweep."""
        return f"{self.name}-{self.digest[:12]}.py"

    @property
    def kept_text(self) -> str:
        """The text that is kept in the folder of the sweep."""
        return self.text + self.beside

    def function(self) -> ColumnFunction:
        """The function, by executing its file: for the worker of a run only.

        Raises ColumnError for whatever that raises.
        """
        if self.code:
            found = _guarded(pickle.loads, self.code)
        else:
            found = getattr(_guarded(_module, self.path, self.text), self.origin.rpartition(":")[2], None)
        if not callable(found):
            raise ColumnError(f"is no function, but {reprlib.repr(found)}")
        function: ColumnFunction = found
        return function

    def of(self, result: Result) -> Real:
        """The column of a run, a number for each point; NaN where it has none.

        Raises ColumnError for whatever the function raises, and if it does not return numbers.
        """
        returned, points = _guarded(self.function(), result), len(result.points)
        try:
            found = np.asarray(returned)
        except Exception:  # lists of several lengths, or an object that is no array
            found = np.asarray(None)
        if found.dtype.kind not in "biuf" or found.shape not in ((), (points,)) or np.isinf(found).any():
            raise ColumnError(
                f"it returned {reprlib.repr(returned)}; allowed: a number for each of the {points} points of the path, "
                "or one for all; nan where there is none"
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
    """Faults of the name of a column."""
    from xarray import Dataset  # takes a while to import

    taken = name in _TAKEN or name in on_axes or name.startswith(("inverse_", "crossing")) or name.endswith("_error")
    if taken or hasattr(Dataset, name) or not name.isidentifier():
        cause = "the table has a column of this name, or makes one" if taken else ""
        cause = f"{name} is a method of xarray's datasets" if hasattr(Dataset, name) else cause
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
    """The column of a file, which is parsed and not executed: that is left to the worker of a run."""
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
    try:
        names = dict(defined_names(ast.parse(text, str(path)).body))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ValueError(f"{path} is no Python: {type(error).__name__}: {error}") from None
    if not names.get(wanted, "*" in names):
        hint = slip(wanted, [one for one, is_function in names.items() if is_function], "; did you mean {}?")
        raise ValueError(f"{path} has no function {wanted}{hint}")
    helpers = with_text_of(helpers_of(path))
    digest = _digest_of_file(wanted, text + helpers)
    return OwnColumn(name, f"{path.name}:{wanted}", digest, text, helpers, path=str(path.resolve()))


def _digest_of_file(function: str, text: str) -> str:
    return hashlib.sha256(f"{function}\n{text}".encode()).hexdigest()


def _of_python(name: str, function: ColumnFunction) -> OwnColumn:
    code, text = _sent(function), ""
    with suppress(OSError, TypeError):  # typed at a prompt, or of a library
        text = inspect.getsource(function)
    beside = with_text_of(modules_used_by(function))
    digest = hashlib.sha256(code + text.encode() + beside.encode()).hexdigest()
    return OwnColumn(name, f"{OF_PYTHON}, {getattr(function, '__name__', name)}", digest, text, beside, code)


def _sent(function: Any) -> bytes:
    """A function as bytes, with what it uses of its script."""
    try:
        code: bytes = cloudpickle.dumps(function)
    except Exception as error:
        msg = f"it cannot be sent to other processes, with what it uses: {type(error).__name__}: {error}"
        raise ValueError(msg) from None
    return code


@cache
def _module(path: str, text: str) -> ModuleType:
    """Execute a file of columns, once in a process; modules beside it can be imported."""
    module = ModuleType(f"columns of {Path(path).name}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # where dataclasses look for the names in their annotations
    if (folder := str(Path(path).parent)) not in sys.path:
        sys.path.append(folder)  # last: nothing beside the input takes the place of a library
    exec(compile(text, path, "exec"), vars(module))
    return module


def _guarded(call: Callable[..., Any], *given: Any) -> Any:
    """Call what a user wrote: wherever it goes and however it ends, the process stays as it was.

    Raises ColumnError for whatever it raises, except for a signal that stops the process.
    """
    here = os.open(".", os.O_RDONLY)
    try:
        return call(*given)
    except (StopSignal, ColumnError):
        raise
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt) and signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
            raise  # of the terminal
        raise ColumnError(f"{type(error).__name__}: {error}") from error
    finally:
        os.fchdir(here)
        os.close(here)


def require_functions(columns: Sequence[OwnColumn]) -> None:
    """Check that each column has a function; raises ColumnError that names those which have none."""
    said = []
    for column in columns:
        try:
            column.function()
        except ColumnError as error:
            said.append(f"column {column.name} ({column.origin}): {error}")
    if said:
        raise ColumnError(f"{'; '.join(said)}; nothing was solved: mend it and run again with --retry")


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
            said.append(f"column {column.name} ({column.origin}): {error}")
    stored = dict[str, Any]()
    for name, (digest, values) in known.items():
        numbers = [None if np.isnan(value) else value for value in values.tolist()]
        stored[name] = digest, numbers, _sum(key, name, digest, numbers)
    content = {"schema": "stickiness/columns", "system": key, "columns": stored}
    output.save(output.folder(folder.columns) / folder.own(key).name, json.dumps(content) + "\n", own=True)
    if said:
        raise ColumnError(f"{'; '.join(said)}; its points are stored: mend it and run again with --retry")


def columns_of(folder: Folder, key: str, columns: Sequence[OwnColumn]) -> dict[str, Real]:
    """Stored columns of a system, a value for each of its points; NaN where there is none."""
    known = _stored(folder, key) if columns else {}
    return {one.name: known[one.name][1] for one in columns if one.name in known and known[one.name][0] == one.digest}


def _stored(folder: Folder, key: str) -> dict[str, tuple[str, Real]]:
    """Digest and values of each stored column; empty if there are none, or they cannot be read."""
    try:
        return dict(_read(folder, key))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def _read(folder: Folder, key: str) -> Iterator[tuple[str, tuple[str, Real]]]:
    """The stored columns of a system; raises ValueError if a sum is not that of its numbers."""
    data = json.loads(folder.own(key).read_text(encoding="utf-8"))
    if data["system"] != key:
        raise ValueError("it is of another system")
    for name, (digest, numbers, stored) in data["columns"].items():
        if stored != _sum(key, name, digest, numbers):
            raise ValueError(f"the numbers of {name} are not those that their sum was made of")
        yield name, (digest, np.array(numbers, dtype=np.float64))


def _sum(key: str, name: str, digest: str, numbers: Sequence[float | None]) -> int:
    return zlib.crc32(json.dumps([key, name, digest, numbers]).encode())


def column_faults(folder: Folder, columns: Sequence[OwnColumn], keys: Iterable[str]) -> Iterator[tuple[Path, str]]:
    """Files of own columns that are damaged: of the numbers of each system, and of the texts that computed them."""
    for key in keys:
        path = folder.own(key)
        try:
            dict(_read(folder, key))
        except FileNotFoundError:
            continue
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            yield path, f"{path}: cannot be read, probably damaged ({error})"
    for column in columns:
        path = folder.columns / column.file_name
        with suppress(FileNotFoundError):
            text, function = path.read_bytes().decode(errors="replace"), column.origin.rpartition(":")[2]
            if not column.origin.startswith(OF_PYTHON) and _digest_of_file(function, text) != column.digest:
                yield path, f"{path}: is not the text that its numbers were computed with"
