"""Identity of an input beside that of a stored result: its hash, its stored form, and the keys in which both differ."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import reduce
from operator import getitem
from types import MappingProxyType
from typing import Any, TypeVar

from continuum.inputs.keys import frozen
from continuum.inputs.tables import Table
from continuum.inputs.toml import Document, text_of
from continuum.store.provenance import made_by, provenance

_Document = TypeVar("_Document", bound=Document)


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def resolved(config: Document) -> str:
    """The whole configuration with defaults as canonical JSON, which is stored with the results."""
    return _canonical(config.plain())


def identity(config: Document) -> str:
    """Hash of all that determines the results: physics, solver, content of files, schema of the result.

    Paths, threads, hosts and output options do not count.
    """
    return identified(identity_text(config))


def identity_text(config: Document, values: Mapping[str, Any] = MappingProxyType({})) -> str:
    """The text of which the identity is the hash, with other values of some dotted keys.

    Raises KeyError if it has not one of the keys.
    """
    content = config.plain(identity=True)
    for key, value in values.items():
        *outer, name = key.split(".")
        table = reduce(getitem, outer, content)
        _ = table[name]
        table[name] = value
    return _canonical({"schema": config.result_schema, "version": config.result_version, "config": content})


def identified(text: str) -> str:
    """The identity of an input, from its text."""
    return hashlib.sha256(text.encode()).hexdigest()


def former_settings(config: Document) -> Iterator[tuple[str, dict[str, Any]]]:
    """For each version with other defaults its last day, and its values of the keys that an input does not give.

    The newest version comes first; the values of newer ones hold in older ones, too, unless these had others.
    """
    values = dict[str, Any]()
    for until, changed in config.former_defaults:
        values |= {key: value for key, value in changed.items() if not _given(config, key.split("."))}
        if values:
            yield until, dict(values)


def _given(table: Any, key: list[str]) -> bool:
    """Whether an input gives a key; also where it lacks the table that has it."""
    if not isinstance(table, Table):
        return True
    name, *inner = key
    return name in table.model_fields_set and (not inner or _given(table.value(name), inner))


def with_values(config: _Document, values: Mapping[str, Any]) -> _Document:
    """The same input with other values of some dotted keys."""
    for key, value in values.items():
        table, _, name = key.rpartition(".")
        config = config.model_copy(update={table: config.value(table).model_copy(update={name: value})})
    return config


def differences(config: Document, attributes: Mapping[str, Any]) -> str:
    """The keys in which an input differs from that of a stored result, and the versions of both, in words."""
    try:
        stored = json.loads(str(attributes.get("config_resolved")))
        before = (with_values(config, values) for _, values in former_settings(config))
        found = min((list(_differing(each, stored)) for each in (config, *before)), key=len)
    except (ValueError, RecursionError, AttributeError, TypeError, OSError):
        return "\n    its input cannot be read"
    said = [*found[:_MOST], *(["and further keys"] if found[_MOST:] else [])] or ["it was stored in another form"]
    versions = f"stored by {made_by(attributes)}; this is {made_by(provenance())}"
    return "".join(f"\n    {line}" for line in [*said, versions])


_MOST = 8
"""Keys that a message names."""


def _differing(table: Table, stored: Mapping[str, Any], place: str = "") -> Iterator[str]:
    now, defaults = table.plain(), type(table).model_fields
    for name in now.keys() - table.not_identity:
        key, value = f"{place}{name}", table.value(name)
        before = stored.get(name, stored.get(table.renamed.get(name, name), _ABSENT))
        if isinstance(value, Table) and isinstance(before, dict):
            yield from _differing(value, before, f"{key}.")
        elif before is _ABSENT:
            if value != defaults[name].get_default():
                yield f"{key} = {_shown(now[name])}, which the stored one lacks"
        elif _content(before) != _content(now[name]):
            yield f"{key} = {_shown(now[name])}, stored {_shown(before)}"


_ABSENT = object()


def _content(value: Any) -> Any:
    """A value without the name of a file."""
    return value.get("sha256", value) if isinstance(value, dict) else value


def _shown(value: Any) -> str:
    text = "not given" if value is None else text_of(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def restored(model: type[_Document], text: str) -> _Document:
    """Inverse of :func:`resolved`; of files only the names are known."""
    return model.model_validate(frozen(json.loads(text)), context={"restored": True})
