"""Whole input files: their source, their identity, and their stored form."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from pydantic import PrivateAttr

from continuum.files.toml import ConfigError, Source
from continuum.tables import Fault, Table, frozen

_Document = TypeVar("_Document", bound="Document")


class Document(Table):
    """A whole input file."""

    result_schema: ClassVar[str]
    """Name of the kind of result that it describes, if such a result is stored."""
    result_version: ClassVar[int]
    """Increased whenever the meaning or layout of that result changes; part of the identity."""
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


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def resolved(config: Document) -> str:
    """The whole configuration with defaults as canonical JSON, which is stored with the results."""
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
    """Inverse of :func:`resolved`; of files only the names are known."""
    return model.model_validate(frozen(json.loads(text)), context={"restored": True})


def refuse(config: Document, *faults: Fault) -> ConfigError:
    """The error for faults that are found only when files are read or a run is set up."""
    return ConfigError(config.source or Path("(configuration made in Python)"), faults)
