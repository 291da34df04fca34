"""TOML files with the line of every key, the message of their faults, and the base class of all inputs."""

from __future__ import annotations

import bisect
import difflib
import json
import re
import stat
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date, time
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from pydantic import PrivateAttr

from continuum.inputs.errors import InputError
from continuum.inputs.tables import Fault, Key, Table

_LARGEST = 8_000_000  # bytes: two paths of 100 000 targets with all their digits have 5 million; more is an error
_DEEPEST = 32  # levels of nesting; no table of ours has more than four
_MOST_FAULTS = 20  # that a message describes
_PLAIN = re.compile(r"[A-Za-z0-9_-]+")  # keys without quotes


class ConfigError(InputError, ValueError):
    """An input file cannot be used: the message lists every fault with file, line, key, value and remedy."""

    def __init__(self, source: Source | Path, faults: Sequence[Fault]) -> None:
        if isinstance(source, Path):
            source = Source(source, "", {})
        self.source = source
        self.faults = tuple(sorted(faults, key=lambda fault: source.line(fault.key)))
        if not source.text and not any(fault.key for fault in self.faults):  # there is nothing to point at
            super().__init__("\n".join(f"{source.path}: {f.cause or f'needed: {f.allowed}'}" for f in self.faults))
            return
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        said = [f"{source.path}: {count}", *map(source.describe, self.faults[:_MOST_FAULTS])]
        if len(self.faults) > _MOST_FAULTS:
            said.append(
                f"and {len(self.faults) - _MOST_FAULTS} more: correct these first, as many follow from one another"
            )
        super().__init__("\n".join(said))

    def __reduce__(self) -> tuple[type[ConfigError], tuple[Source, tuple[Fault, ...]]]:
        return type(self), (self.source, self.faults)


@dataclass(frozen=True)
class Source:
    """The text of an input file, what it holds, and where."""

    path: Path
    text: str = field(repr=False)
    data: Mapping[str, Any] = field(repr=False)
    at: int | None = field(default=None, repr=False)
    """Line of the fault of a text that is no TOML; None of others."""

    @cached_property
    def lines(self) -> Mapping[str, int]:
        """Line of each key, by its dotted name; they are looked for when a message needs them."""
        return _Positions(self.text).lines if self.at is None else {"": self.at}

    @classmethod
    def read(cls, path: Path) -> Source:
        """Read and parse a TOML file; raises ConfigError if that fails."""
        return cls._parsed(path, _text(path))

    @classmethod
    def of(cls, tables: Mapping[str, Any], name: str) -> Source:
        """The input file with these tables, under a name; raises ConfigError if TOML cannot hold them."""
        path = Path(f"{name}.toml")
        try:
            text = document(tables)
            data = tomllib.loads(text)
        except (TypeError, ValueError, RecursionError):
            cause = "a value that is None, or not a number, text, list or table"
            raise ConfigError(path, [Fault((), "tables of numbers, texts and lists", cause)]) from None
        return cls._shallow(path, text, data)

    @classmethod
    def _parsed(cls, path: Path, text: str) -> Source:
        try:
            data = tomllib.loads(text)
        except RecursionError:
            data = None
        except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
            cause = "text without quotes, or a capital letter in true or false"
            at = re.search(r"line (\d+)", str(error))
            line = int(at[1]) if at else text.count("\n") + 1
            raise ConfigError(cls(path, text, {}, line), [Fault((), f"valid TOML; found: {error}", cause)]) from None
        return cls._shallow(path, text, data)

    @classmethod
    def _shallow(cls, path: Path, text: str, data: Mapping[str, Any] | None) -> Source:
        """The source of what a text holds; raises ConfigError if that is None or nested too deep."""
        if data is None or _is_deep(data):
            raise ConfigError(path, [Fault((), f"TOML with at most {_DEEPEST} levels of nesting")])
        return cls(path, text, data)

    def changed(self, settings: Mapping[str, Any]) -> Source:
        """The same file with other values of some dotted keys, such as ``surface.seed``, which its text lists.

        Raises ConfigError if a part of such a key is not a table.
        """
        data = dict(self.data)
        for name, value in settings.items():
            table, parts = data, name.split(".")
            for i, part in enumerate(parts[:-1]):
                inner = table.get(part, {})
                if not isinstance(inner, Mapping):
                    raise ConfigError(self, [Fault(tuple(parts[: i + 1]), f"a table, since {name} is set in it")])
                table[part] = table = dict(inner)
            table[parts[-1]] = value
        said = "".join(f"# set: {name} = {_toml(value)}\n" for name, value in settings.items())
        return replace(self, data=data, text=f"{self.text.rstrip()}\n{said}")

    def line(self, key: Key) -> int:
        """Line of a key, or of the innermost table that should hold it; 1 if there is none."""
        names = (_name(key[:length]) for length in range(len(key), -1, -1))
        return next((self.lines[name] for name in names if name in self.lines), 1)

    def describe(self, fault: Fault) -> str:
        """Two or three lines: place and value, what is allowed, the usual cause."""
        name = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in fault.key)[1:] or "file"
        found, value = _lookup(self.data, fault.key)
        given = f" = {_toml(value)}" if found and fault.key else "" if not fault.key else " is not given"
        text = f"{self.path}:{self.line(fault.key)}: {name}{given}\n    allowed: {fault.allowed}"
        return f"{text}\n    usual cause: {fault.cause}" if fault.cause else text


def _name(key: Key) -> str:
    return ".".join(map(str, key))


def _text(path: Path) -> str:
    """The text of a file of moderate size; raises ConfigError for a folder, a device or a huge file."""
    allowed = "a TOML file"
    try:
        mode, size = path.stat().st_mode, path.stat().st_size
        if stat.S_ISREG(mode) and size <= _LARGEST:
            return path.read_text(encoding="utf-8-sig")  # drops the mark that some editors put in front
        what = "a folder" if stat.S_ISDIR(mode) else "a special file"
        cause = f"this is {what}, not a TOML file; check the path"
        if stat.S_ISREG(mode):
            allowed, cause = f"a TOML file of at most {_LARGEST} bytes", ""
    except FileNotFoundError:
        cause = "there is no such file; check its name"
    except UnicodeDecodeError:
        allowed, cause = "a TOML file in UTF-8", "this is not text in UTF-8, but a binary file or Latin-1"
    except (OSError, ValueError) as error:  # also a name that no file can have
        cause = f"it cannot be read: {getattr(error, 'strerror', None) or error}"
    raise ConfigError(path, [Fault((), allowed, cause)])


def _is_deep(data: Any) -> bool:
    """True if tables and arrays are nested too deep; found without recursion, which has a limit of its own."""
    level = [data]
    for _ in range(_DEEPEST):
        inner = [item.values() if isinstance(item, Mapping) else item for item in level]
        level = [x for items in inner for x in items if isinstance(x, Mapping | list)]
    return bool(level)


def _lookup(data: Any, key: Key) -> tuple[bool, Any]:
    for part in key:
        if isinstance(data, Mapping) and part in data:
            data = data[str(part)]
        elif isinstance(data, Sequence) and isinstance(part, int) and not isinstance(data, str):
            data = data[part]
        else:
            return False, None
    return True, data


def text_of(value: Any) -> str:
    """A value in TOML; a path by its name.

    Raises TypeError or ValueError if TOML has no such value, or it is a number of thousands of digits.
    """
    if type(value) is int:  # most values of long axes; the same text in a tenth of the time
        return str(value)
    if isinstance(value, Mapping):
        inner = (f"{name if _PLAIN.fullmatch(name) else json.dumps(name)} = {text_of(v)}" for name, v in value.items())
        return "{" + ", ".join(inner) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(text_of, value)) + "]"
    if isinstance(value, Path):
        value = value.name
    elif isinstance(value, date | time):
        return value.isoformat()
    text = json.dumps(value, ensure_ascii=False)
    return {"NaN": "nan", "Infinity": "inf", "-Infinity": "-inf"}.get(text, text)


def document(data: Mapping[str, Any]) -> str:
    """The text of an input file with these tables: a line for each key, inner tables in one line."""
    lines = [f"{name} = {text_of(value)}" for name, value in data.items() if not isinstance(value, Mapping)]
    for name, table in data.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{name}]", *(f"{key} = {text_of(value)}" for key, value in table.items())]
    return "\n".join([*lines, ""])


def _toml(value: Any) -> str:
    """A value as in the file, shortened."""
    try:
        text = text_of(value)
    except TypeError:  # given in Python, and nothing that a file can hold
        text = repr(value)
    except ValueError:
        text = "(too large to print)"
    return text if len(text) <= 60 else text[:57] + "..."


def value_of(text: str) -> Any:
    """Parse a value from a command line as TOML, where quotes around words may be left out.

    If anything follows the value, such as a comment or another line, the whole is text.
    """
    try:
        found = tomllib.loads(f"value = {text}")
        tomllib.loads(f"value = [{text}]")  # a comment would hide the bracket
    except (ValueError, RecursionError):
        return text
    return found["value"] if len(found) == 1 else text


def nearest(word: str, choices: Iterable[str]) -> str | None:
    """The choice that was probably meant: equal but for upper and lower case, else similar."""

    def plain(name: str) -> str:
        return name.casefold().replace("_", "-").replace(" ", "-")

    names = list(choices)
    same = [name for name in names if plain(name) == plain(word)]
    found = same or difflib.get_close_matches(word, names, n=1)
    return found[0] if found else None


def slip(word: object, choices: Iterable[str], form: str, otherwise: str = "") -> str:
    """Message about a word that is none of the choices: a form with the one probably meant, if any, in its place."""
    meant = nearest(str(word), choices)
    return form.format(meant) if meant else otherwise


def find(path: str | Path) -> Path:
    """The path of an input or map; if there is no such file and it starts with ``inputs/``, that of the package."""
    path = Path(path)
    return packaged(path) if not path.exists() and path.parts[:1] == ("inputs",) else path


def packaged(path: str | Path) -> Path:
    """Path of a file that comes with the package: inside it after installation, beside the packages in a checkout.

    Any other path is returned unchanged.
    """
    package = Path(__file__).resolve().parent.parent
    places = (folder / path for folder in (package / "data", package.parent))
    return next((place for place in places if place.is_file()), Path(path))


_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY = re.compile(r"""[ \t]*(?:([A-Za-z0-9_-]+)|("(?:[^"\\\n]|\\.)*")|'([^'\n]*)')[ \t]*""")
# Multi-line strings first: their closing marks may follow up to two quotes of their own.
_TEXT = re.compile(r'''"""(?:[^\\]|\\.)*?""""{0,2}|\'\'\'.*?\'\'\'\'{0,2}|"(?:[^"\\\n]|\\.)*"|'[^'\n]*\'''', re.DOTALL)
_BARE = re.compile(r"[^\n,\]}#]*")


class _Positions:
    """Line of every key of a text that :mod:`tomllib` has accepted."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self._ends = [match.start() for match in re.finditer("\n", text)]
        self.lines: dict[str, int] = {}
        tables: dict[Key, int] = {}  # arrays of tables, with the index of the current one
        table: Key = ()
        while self._skip() < len(text):
            if text[self.at] == "[":
                array = text.startswith("[[", self.at)
                start = self.at
                self.at += 2 if array else 1
                table = ()
                names = self._dotted()
                for i, name in enumerate(names):
                    table = (*table, name)
                    last = i == len(names) - 1
                    if array and last:
                        tables[table] = tables.get(table, -1) + 1
                    if table in tables:
                        table = (*table, tables[table])
                self._record(table, start)
                self.at += 2 if array else 1
            else:
                self._pair(table)

    def _skip(self) -> int:
        match = _SPACE.match(self.text, self.at)
        self.at = match.end() if match else self.at
        return self.at

    def _record(self, key: Key, at: int) -> None:
        line = bisect.bisect_left(self._ends, at) + 1
        for length in range(1, len(key) + 1):
            self.lines.setdefault(_name(key[:length]), line)

    def _dotted(self) -> list[str]:
        names = []
        while match := _KEY.match(self.text, self.at):
            bare, quoted, literal = match.groups()
            unquoted = str(*tomllib.loads(f"{quoted} = 0")) if quoted else ""
            names.append(bare or literal or unquoted)
            self.at = match.end()
            if not self.text.startswith(".", self.at):
                break
            self.at += 1
        return names

    def _pair(self, table: Key) -> None:
        start = self.at
        key = (*table, *self._dotted())
        self._record(key, start)
        self.at += 1  # the equals sign
        self._value(key)

    def _value(self, key: Key) -> None:
        opening = self.text[self._skip() : self.at + 1]
        if opening in ("[", "{"):
            self.at += 1
            index = 0
            while self.text[self._skip()] not in "]}":
                if opening == "{":
                    self._pair(key)
                else:
                    self._record((*key, index), self.at)
                    self._value((*key, index))
                index += 1
                if self.text[self._skip()] == ",":
                    self.at += 1
            self.at += 1
        else:
            match = (_TEXT if opening in ("'", '"') else _BARE).match(self.text, self.at)
            self.at = match.end() if match else self.at + 1


_Document = TypeVar("_Document", bound="Document")


class Document(Table):
    """A whole input file."""

    result_schema: ClassVar[str]
    """Name of the kind of result that it describes, if such a result is stored."""
    result_version: ClassVar[int]
    """Increased whenever the meaning or layout of that result changes; part of the identity."""
    former_defaults: ClassVar[tuple[tuple[str, Mapping[str, Any]], ...]] = ()
    """Defaults of earlier versions, the newest first: the last day that they held, and their values by dotted keys.

    A result that was begun with them keeps its identity and goes on with them (:mod:`continuum.store.identity`).
    """
    of_others: ClassVar[Mapping[str, str]] = {}
    """Tables that other inputs have, and what is said of a file that holds one."""

    _source: Source | None = PrivateAttr(None)

    @property
    def source(self) -> Source | None:
        """The file it was read from; None if it was made in Python."""
        return self._source

    @property
    def files(self) -> tuple[Path, ...]:
        """The input file and all files that it names: no result may be written over them."""
        return (*([self._source.path] if self._source else []), *_files(self))


def _files(value: Any) -> Iterator[Path]:
    if isinstance(value, Path):
        yield value
    elif isinstance(value, tuple | Table):  # of a table: pairs of name and value
        for item in value:
            yield from _files(item)


def refuse(config: Document, *faults: Fault) -> ConfigError:
    """The error for faults that are found only when files are read or a run is set up."""
    return ConfigError(config.source or Path("(configuration made in Python)"), faults)
