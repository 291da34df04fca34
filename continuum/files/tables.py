"""Strict typed models of input files: their base classes, the identity of a run.

A table of the TOML file is a frozen :class:`Table`, the whole file a :class:`Document`.  A key that is
unknown, of the wrong type or out of range is a fault, and so is whatever a method marked :func:`constraint` finds
where keys or tables contradict one another.  :func:`continuum.files.inputs.load` reports all faults of a file at once.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, get_origin

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from continuum.files.toml import ConfigError, Fault, Source

STRICT = ConfigDict(strict=True, allow_inf_nan=False)
"""Numbers are no texts and no booleans, and all of them are finite."""
_Method = TypeVar("_Method", bound=Callable[..., Iterator[Fault]])
_Document = TypeVar("_Document", bound="Document")


def constraint(method: _Method) -> _Method:
    """Mark a method of a table that yields the faults in how its keys fit together.

    It may use any key: where one is faulty itself, the check is skipped.
    """
    method._is_check = True  # type: ignore[attr-defined]
    return method


class Table(BaseModel):
    """A table of an input file: unknown keys, loose types, infinities and NaN are faults.

    The docstring under a key is shown to the user when that key is faulty.
    """

    model_config = ConfigDict(**STRICT, extra="forbid", frozen=True, use_attribute_docstrings=True)
    not_identity: ClassVar[frozenset[str]] = frozenset()
    """Keys that do not change results: threads, output options."""
    newer: ClassVar[frozenset[str]] = frozenset()
    """Keys that came after results were stored: they belong to the identity only where they are given."""

    @classmethod
    @cache  # of every system of a sweep this was half the time
    def _checks(cls) -> tuple[Callable[[Any], Iterator[Fault]], ...]:
        members = (method for base in reversed(cls.__mro__) for method in vars(base).values())
        return tuple(method for method in members if getattr(method, "_is_check", False))

    @property
    def origin(self) -> str:
        """The key that says where the values come from: the file that is read, else the kind of table."""
        fields = type(self).model_fields
        return "path" if "path" in fields else next((name for name in fields if is_kind(fields[name])), "")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        faults = [fault for method in self._checks() for fault in method(self)]
        if faults:
            text = "; ".join(f"{'.'.join(map(str, f.key))}: allowed: {f.allowed}" for f in faults)
            raise PydanticCustomError("inconsistent", "{text}", {"text": text})
        return self

    def plain(self, *, identity: bool = False) -> dict[str, Any]:
        """Keys and values as JSON has them, defaults included; files by the hash of their content.

        With ``identity``, without what does not change results.
        """
        absent = {name for name in self.newer if getattr(self, name) is None}
        left_out = self.not_identity | absent if identity else set()
        names = [name for name in type(self).model_fields if name not in left_out]
        return {name: _plain(getattr(self, name), identity) for name in names}


class Document(Table):
    """A whole input file."""

    result_schema: ClassVar[str]
    """Name of the kind of result that it describes."""
    result_version: ClassVar[int]
    """Raised whenever the meaning or layout of that result changes; part of the identity."""

    _source: Source | None = PrivateAttr(None)

    @property
    def source(self) -> Source | None:
        """The file it was read from; None if it was made in Python."""
        return self._source

    @property
    def files(self) -> tuple[Path, ...]:
        """All files that it was read from, this one and those that it names: no result may be written over them."""
        return (*([self._source.path] if self._source else []), *_files(self))


def _files(value: Any) -> Iterator[Path]:
    if isinstance(value, Path):
        yield value
    elif isinstance(value, tuple | Table):  # of a table: pairs of name and value
        for item in value:
            yield from _files(item)


def _plain(value: Any, identity: bool) -> Any:
    if isinstance(value, Table):
        return value.plain(identity=identity)
    if isinstance(value, Path):
        content = {"sha256": hashlib.sha256(value.read_bytes()).hexdigest()}
        return content if identity else {"name": value.name, **content}
    if isinstance(value, tuple):
        return [_plain(item, identity) for item in value]
    return value


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def resolved(config: Document) -> str:
    """The whole configuration, defaults included, as canonical JSON: for storage beside the results."""
    return _canonical(config.plain())


def identity(config: Document) -> str:
    """Hash of all that determines the results: physics, solver, content of files, schema of the result.

    Paths, threads, hosts and output options do not count.
    """
    content = {
        "schema": config.result_schema,
        "version": config.result_version,
        "config": config.plain(identity=True),
    }
    return hashlib.sha256(_canonical(content).encode()).hexdigest()


def restored(model: type[_Document], text: str) -> _Document:
    """A configuration from what :func:`resolved` made of it; of a file only the name is known."""
    return model.model_validate(frozen(json.loads(text)), context={"restored": True})


def _existing(value: object, info: ValidationInfo) -> Path:
    if isinstance(value, dict) and (info.context or {}).get("restored"):
        return Path(str(value.get("name")))
    if isinstance(value, str):
        path = Path(str((info.context or {}).get("folder", "."))) / value
    elif isinstance(value, Path):
        path = value
    else:
        raise PydanticCustomError("file_name", "the name of a file, in quotes")
    try:
        is_file = path.is_file()
    except (OSError, ValueError):  # a name with a NUL, or far too long
        is_file = False
    if not is_file:
        raise PydanticCustomError("missing_file", "an existing file, relative to the folder of this input")
    return path


InputFile = Annotated[Path, BeforeValidator(_existing)]
"""A file that must exist, named relative to the input file; it counts by its content in the identity."""

Positive = Annotated[float, Field(gt=0)]


def refuse(config: Document, *faults: Fault) -> ConfigError:
    """The error for faults that only the content of a file or the arithmetic of a run shows."""
    return ConfigError(config.source or Path("(configuration made in Python)"), faults)


def frozen(value: Any) -> Any:
    """TOML's arrays as tuples, which strict models ask for."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(map(frozen, value)) if isinstance(value, list) else value


def is_kind(field: FieldInfo) -> bool:
    """Whether a key takes fixed names: the first such is by convention the kind of its table."""
    return get_origin(field.annotation) is Literal
