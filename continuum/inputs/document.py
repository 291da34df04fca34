"""A whole input file: the base class of all inputs, and the error for faults found later."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from pydantic import PrivateAttr

from continuum.inputs.tables import Fault, Table
from continuum.inputs.toml import ConfigError, Source

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
