"""Read input files and report all their faults at once, each with its line, what is allowed and a probable cause.

Pydantic's errors are translated into messages with file, line, key and allowed values.  Checks between keys, which
pydantic leaves out if one key is faulty, are made as far as the valid keys allow.
"""

import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from continuum.inputs.arguments import ArgumentError, file_name
from continuum.inputs.keys import frozen, what_is_allowed
from continuum.inputs.tables import STRICT, Fault, Key, Place, Table, explained, located, table_of, tables_in
from continuum.inputs.toml import ConfigError, Document, Source, find, nearest, slip

_Document = TypeVar("_Document", bound=Document)


InputFile = str | Path | Mapping[str, Any]
"""An input: the name of a file, or its tables as a dictionary of Python."""


def source_of(given: InputFile | Document, name: str = "input") -> Source:
    """The source of an input, which is a file or a dictionary of tables.

    Parameters
    ----------
    given : the file, ``inputs/...`` for one that comes with the package; or its tables, also with NumPy's numbers.
    name : of tables, which have no file; relative paths in them start from the present folder.

    Raises ArgumentError if it is neither; ConfigError if it cannot be read.
    """
    if isinstance(given, Mapping):
        if not all(isinstance(key, str) for key in given):
            raise ArgumentError("file", given, 'tables by their names, such as {"grid": {"n": 64}}')
        return Source.of({key: _plain(value) for key, value in given.items()}, name)
    return Source.read(find(file_name("file", given)))


def load(path: InputFile | _Document, model: type[_Document], settings: Mapping[str, Any] | None = None) -> _Document:
    """Read an input; an input that was read before is returned unchanged.

    Parameters
    ----------
    path : as :func:`source_of` takes it.
    model : what it should hold.
    settings : values instead of those of the file, by dotted keys such as ``surface.seed``.

    Raises ConfigError with all faults of the file; ArgumentError if there are settings of what was read already.
    """
    if isinstance(path, model):
        if settings:
            raise ArgumentError("settings", settings, "values of keys of a file; this input was read already")
        return path
    source = source_of(path)
    return parsed(source.changed(settings) if settings else source, model)


_KIND_KEYS = {"kind", "law", "response", "control"}
"""Keys of which each names the kind of its table."""


def settings_of(given: Any) -> dict[str, Any]:
    """Dotted keys with their values; NumPy's numbers and arrays become plain numbers and lists.

    Raises ArgumentError if it is no mapping of names to values.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise ArgumentError("settings", given, 'a mapping of keys to values, such as {"surface.seed": 3}')
    return dict(_merged({key: _plain(value) for key, value in given.items()}))


def _merged(given: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The keys of a table change those keys of it; a table that says its kind takes the place of what was there."""
    for name, value in given.items():
        if "." not in name and isinstance(value, Mapping) and not _KIND_KEYS & value.keys():
            yield from ((f"{name}.{key}", inner) for key, inner in value.items())
        else:
            yield name, value


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return list(map(_plain, value)) if isinstance(value, list | tuple | range) else value


def parsed(source: Source, model: type[_Document], values: Mapping[str, Any] | None = None) -> _Document:
    """Build the configuration of an input file; raises ConfigError with all faults of the file.

    Parameters
    ----------
    values : what it holds, where that is not what stands there, as numbers in other units.
    """
    data = frozen(source.data if values is None else values)
    context = {"folder": source.path.parent}
    if issubclass(model, Document):
        for name, said in model.of_others.items():
            if name in data:
                raise ConfigError(source.path, [Fault((), "", said)])
    try:
        config = model.model_validate(data, context=context)
    except ValidationError as error:
        faults, data = _complete(error.errors(include_url=False), data, model, context)
        bad = {fault.key for fault in faults}
        faults += _contradictions(model, data, (), bad, context)
        raise ConfigError(source, [*dict.fromkeys(faults)]) from None
    config._source = source
    return config


_SIGN = "a sign, or a value in other units than a0 and E*"
_CAUSES: Mapping[str, str] = {
    "bool_type": "quotes, or a capital letter",
    "finite_number": "NaN or infinity, from a failed calculation",
    "float_type": "a number in quotes, or true/false",
    "greater_than": _SIGN,
    "greater_than_equal": _SIGN,
    "int_type": "a decimal point or quotes where a count belongs",
    "missing": "a line left out, or a misspelt key",
    "missing_file": "a misspelt name, or a path relative to another folder",
    "string_type": "quotes left out",
    "tuple_type": "one value without [brackets]",
}
"""The usual cause of each kind of pydantic's errors."""
_WORDS: Mapping[str, str] = {
    "bool_type": "true or false",
    "missing": "this key is required",
    "model_type": "a table, [{place}]",
    "string_pattern_mismatch": "text of this form",
    "string_type": "text in quotes",
}
"""Allowed values in the words of files, by kind of fault."""


def _complete(
    errors: list[ErrorDetails], data: Any, model: type[Table], context: Mapping[str, Any]
) -> tuple[list[Fault], Any]:
    """Faults of single keys; a table whose kind is misspelt is checked as the kind that was probably meant."""
    faults, mended = list[Fault](), data
    for place, found in _at_each_key(errors, data, model):
        faults.append(_translate(place, found, model))
        if found[0]["type"] == "kind" and (meant := _meant(found[0])):
            mended = _replaced(mended, faults[-1].key, meant)
    if mended is not data:
        try:
            model.model_validate(mended, context=context)
        except ValidationError as error:
            more, mended = _complete(error.errors(include_url=False), mended, model, context)
            known = {fault.key for fault in faults}
            faults += [fault for fault in more if fault.key not in known]
    return faults, mended


def _replaced(data: Any, key: Key, value: Any) -> Any:
    if not key:
        return value
    if isinstance(data, tuple):
        return tuple(_replaced(x, key[1:], value) if i == key[0] else x for i, x in enumerate(data))
    return {**data, key[0]: _replaced(data[key[0]], key[1:], value)}


def _meant(error: ErrorDetails) -> str | None:
    """The kind of a table that a misspelt name is nearest to."""
    return nearest(str(error["input"].get(error["ctx"]["key"], "")), error["ctx"]["names"])


def _at_each_key(
    errors: list[ErrorDetails], data: Any, model: type[Table]
) -> Collection[tuple[Place, list[ErrorDetails]]]:
    """Errors by the key that they are of: several where a key may have several types, and the value fits none.

    A list with a faulty entry fits the type of a list better than that of a number, whose error is left out.
    """
    placed = [(located(error["loc"], data, model), error) for error in errors if error["type"] != "inconsistent"]
    deepest: dict[Key | None, int] = {}
    for place, _ in placed:
        deepest[place.among] = max(deepest.get(place.among, 0), len(place.key))
    found: dict[Key, tuple[Place, list[ErrorDetails]]] = {}
    for place, error in placed:
        if place.among is None or len(place.key) == deepest[place.among]:
            found.setdefault(place.key, (place, []))[1].append(error)
    return found.values()


def _translate(place: Place, errors: list[ErrorDetails], model: type[Table]) -> Fault:
    """Translate pydantic's errors at a key into a fault of the input file."""
    (key, table, field, _), error, kind = place, errors[0], errors[0]["type"]
    about = f" ({' '.join(field.description.split())})" if field and field.description else ""
    if kind == "missing" and isinstance(key[-1], int):  # of a list of so many entries
        return Fault(key[:-1], what_is_allowed(error, field, in_inputs=True) + about)
    if kind == "extra_forbidden" and table is not None:
        keys = explained(table)
        hint = slip(key[-1], keys, "misspelt; did you mean {}?", _where_it_belongs(key, model))
        return Fault(key, "one of the keys " + ", ".join(keys), hint)
    if kind == "kind":
        key = (*key, error["ctx"]["key"])
        if key[-1] not in error["input"]:
            return Fault(key, f"this key is required: the kind of the table{about}")
        allowed = "one of " + ", ".join(f'"{name}"' for name in error["ctx"]["names"])
        meant = _meant(error)
        return Fault(key, allowed, f'misspelt; did you mean "{meant}"?' if meant else "")
    cause = _CAUSES.get(kind, "")
    if kind == "literal_error" and field:
        cause = slip(error["input"], map(str, get_args(field.annotation)), 'misspelt; did you mean "{}"?')
    words = (_WORDS.get(each["type"]) or what_is_allowed(each, field, in_inputs=True) for each in errors)
    allowed = ", or ".join(dict.fromkeys(words)).replace("{place}", ".".join(map(str, key)))
    return Fault(key, allowed + about, cause)


def _where_it_belongs(key: Key, model: type[Table]) -> str:
    """The tables that have a key of the name of an unknown one."""
    here = tuple(part for part in key[:-1] if isinstance(part, str))
    homes = dict.fromkeys(_homes(str(key[-1]), model, ()))
    if not homes:
        return "a key of another table, or of another version"
    return "it belongs " + " or ".join(
        f"{'to another kind of' if home == here else 'into'} [{'.'.join(home)}]" for home in homes
    )


def _homes(name: str, model: type[Table], place: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Places, outermost first, of the tables that have a key of that name."""
    for key, field in model.model_fields.items():
        for table in tables_in(field.annotation):
            if name in table.model_fields:
                yield (*place, key)
            yield from _homes(name, table, (*place, key))


def _contradictions(
    model: type[Table], data: Any, key: Key, bad: set[Key], context: Mapping[str, Any]
) -> Iterator[Fault]:
    """Faults that the checks of a table and of those inside it find, as far as its keys are sound."""
    sound = _sound(model, data, key, bad, context)
    for name, field in model.model_fields.items():
        for inner, value, here in _inner_tables(field, data.get(name), (*key, name), bad):
            yield from _contradictions(inner, value, here, bad, context)
    for method in model.constraints:
        try:
            yield from [replace(fault, key=(*key, *fault.key)) for fault in method(sound)]
        except AttributeError:
            # A key that the check needs is faulty itself.  Without such, this is an error of ours.
            if not bad:
                raise


def _inner_tables(
    field: FieldInfo, value: Any, key: Key, bad: set[Key]
) -> Iterator[tuple[type[Table], Mapping[str, Any], Key]]:
    """The table or the array of tables that a key holds, with its place; nothing for plain values."""
    items = [((*key, i), item) for i, item in enumerate(value)] if isinstance(value, tuple) else [(key, value)]
    for here, item in items:
        table = table_of(field, item) if isinstance(item, Mapping) else None
        if table is not None and not {key, here} & bad:
            yield table, item, here


def _sound(model: type[Table], data: Mapping[str, Any], key: Key, bad: set[Key], context: Mapping[str, Any]) -> Table:
    """A table made of its sound keys only; asking it for another raises AttributeError."""
    values: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        here = (*key, name)
        inner = [_sound(*item, bad, context) for item in _inner_tables(field, data.get(name), here, bad)]
        if inner:
            values[name] = tuple(inner) if isinstance(data[name], tuple) else inner[0]
        elif name in data and not any(other[: len(here)] == here for other in bad):
            adapter = TypeAdapter[Any](field.rebuild_annotation(), config=STRICT)
            values[name] = adapter.validate_python(data[name], context=context)
        elif name not in data and not field.is_required():
            values[name] = field.get_default(call_default_factory=True)
    table = model.model_construct(**values)
    for name in set(model.model_fields) - set(values):
        table.__dict__.pop(name, None)  # the default that model_construct put in place of a faulty value
    return table
