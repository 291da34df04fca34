"""Strict typed models of input files: their base classes, their loader, the identity of a run.

A table of the TOML file is a frozen :class:`Table`, the whole file a :class:`Document`.  A key that is
unknown, of the wrong type or out of range is a fault, and so is whatever a method marked :func:`check` finds
where keys or tables contradict one another.  :func:`load` reports all faults of a file at once.
The only module, with the models themselves, that knows pydantic.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, get_args, get_origin

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, PydanticCustomError

from continuum.files.toml import ConfigError, Fault, Key, Source, find, nearest

__all__ = [
    "ConfigError",
    "Document",
    "Fault",
    "InputFile",
    "Positive",
    "Table",
    "check",
    "identity",
    "load",
    "refuse",
    "resolved",
    "restored",
]

_STRICT = ConfigDict(strict=True, allow_inf_nan=False)
_Method = TypeVar("_Method", bound=Callable[..., Iterator[Fault]])
_Document = TypeVar("_Document", bound="Document")


def check(method: _Method) -> _Method:
    """Mark a method of a table that yields the faults in how its keys fit together.

    It may use any key: where one is faulty itself, the check is skipped.
    """
    method._is_check = True  # type: ignore[attr-defined]
    return method


class Table(BaseModel):
    """A table of an input file: unknown keys, loose types, infinities and NaN are faults.

    The docstring under a key is shown to the user when that key is faulty.
    """

    model_config = ConfigDict(**_STRICT, extra="forbid", frozen=True, use_attribute_docstrings=True)
    not_identity: ClassVar[frozenset[str]] = frozenset()
    """Keys that do not change results: threads, output options."""

    @classmethod
    def _checks(cls) -> Iterator[Callable[[Self], Iterator[Fault]]]:
        for base in reversed(cls.__mro__):
            yield from (method for method in vars(base).values() if getattr(method, "_is_check", False))

    @property
    def origin(self) -> str:
        """The key that says where the values come from: the file that is read, else the kind of table."""
        fields = type(self).model_fields
        return "path" if "path" in fields else next((name for name in fields if _is_kind(fields[name])), "")

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
        names = [name for name in type(self).model_fields if not (identity and name in self.not_identity)]
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
    return model.model_validate(_frozen(json.loads(text)), context={"restored": True})


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


def load(path: str | Path, model: type[_Document]) -> _Document:
    """Read an input file.

    Parameters
    ----------
    path : the file as given, or ``inputs/...`` for one that comes with the package.
    model : what it should hold.

    Raises
    ------
    ConfigError
        With all faults of the file.
    """
    source = Source.read(find(path))
    data = _frozen(source.data)
    context = {"folder": source.path.parent}
    try:
        config = model.model_validate(data, context=context)
    except ValidationError as error:
        faults, data = _complete(error.errors(include_url=False), data, model, context)
        bad = {fault.key for fault in faults}
        faults += _contradictions(model, data, (), bad, context)
        raise ConfigError(source, faults) from None
    config._source = source
    return config


def refuse(config: Document, *faults: Fault) -> ConfigError:
    """The error for faults that only the content of a file or the arithmetic of a run shows."""
    return ConfigError(config.source or Path("(configuration made in Python)"), faults)


def _frozen(value: Any) -> Any:
    """TOML's arrays as tuples, which strict models ask for."""
    if isinstance(value, dict):
        return {key: _frozen(item) for key, item in value.items()}
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


_CAUSES = {
    "finite_number": "a number that another program could not compute",
    "float_type": "a number in quotes, or true/false",
    "greater_than": "a sign, or a value in other units than a0 and E*",
    "greater_than_equal": "a sign, or a value in other units than a0 and E*",
    "bool_type": "quotes, or a capital letter",
    "string_type": "quotes left out",
    "int_type": "a decimal point or quotes where a count belongs",
    "missing": "a line left out, or a misspelt key",
    "missing_file": "a slip in the name, or a path relative to another folder",
    "tuple_type": "one value without [brackets]",
}


def _complete(
    errors: list[ErrorDetails], data: Any, model: type[Table], context: Mapping[str, Any]
) -> tuple[list[Fault], Any]:
    """Faults of single keys.

    A table whose kind is misspelt hides its other faults: they are looked for with the kind probably meant.
    """
    faults = [_translate(error, data, model) for error in errors if error["type"] != "inconsistent"]
    mended = data
    for error, fault in zip([e for e in errors if e["type"] != "inconsistent"], faults, strict=True):
        if error["type"] == "union_tag_invalid":
            meant = nearest(error["ctx"]["tag"], _tags(error))
            mended = _replaced(mended, fault.key, meant) if meant else mended
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


def _tags(error: ErrorDetails) -> list[str]:
    return [tag.strip("' ") for tag in error["ctx"]["expected_tags"].split(",")]


def _translate(error: ErrorDetails, data: Any, model: type[Table]) -> Fault:
    """One of pydantic's errors in the words of the input file."""
    kind = error["type"]
    key, table, field = _locate(error["loc"], data, model)
    about = f" ({' '.join(field.description.split())})" if field and field.description else ""
    if kind == "extra_forbidden" and table is not None:
        meant = nearest(str(key[-1]), table.model_fields)
        hint = f"a slip; did you mean {meant}?" if meant else "a key of another table, or of another version"
        return Fault(key, "one of the keys " + ", ".join(table.model_fields), hint)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        tag = error["ctx"]["discriminator"].strip("'")
        if kind == "union_tag_not_found":
            return Fault((*key, tag), f"a name that says which kind of table this is{about}")
        meant = nearest(error["ctx"]["tag"], _tags(error))
        allowed = "one of " + ", ".join(f'"{name}"' for name in _tags(error))
        return Fault((*key, tag), allowed, f'a slip; did you mean "{meant}"?' if meant else "")
    if kind == "literal_error":
        choices = [str(choice) for choice in get_args(field.annotation)] if field else []
        meant = nearest(str(error["input"]), choices)
        allowed = ("one of " if len(choices) > 1 else "") + ", ".join(f'"{name}"' for name in choices)
        return Fault(key, allowed + about, f'a slip; did you mean "{meant}"?' if meant else "")
    allowed = {
        "missing": "this key is required",
        "model_type": "a table, [" + ".".join(map(str, key)) + "]",
        "model_attributes_type": "a table, [" + ".".join(map(str, key)) + "]",
        "tuple_type": "a list in [brackets]",
        "int_type": "a whole number",
        "bool_type": "true or false",
        "float_type": "a number",
        "string_type": "text in quotes",
    }.get(kind, error["msg"].removeprefix("Input should be ").removeprefix("a valid "))
    return Fault(key, allowed + about, _CAUSES.get(kind, ""))


def _locate(
    location: tuple[int | str, ...], data: Any, model: type[Table]
) -> tuple[Key, type[Table] | None, FieldInfo | None]:
    """Key in the file of pydantic's location; the table that holds it, and its field there."""
    key: Key = ()
    table: type[Table] | None = model
    holder, field, kind_follows = table, None, False
    for part in location:
        if isinstance(part, int):
            data = data[part] if isinstance(data, tuple) and part < len(data) else None
            table = _table_of(field, data) if field else None
        elif kind_follows:  # pydantic names the kind of a table after its key
            kind_follows = False
            continue
        else:
            holder, field = table, table.model_fields.get(part) if table else None
            data = data.get(part) if isinstance(data, Mapping) else None
            table = _table_of(field, data) if field else None
            kind_follows = field is not None and len(list(_tables_in(field.annotation))) > 1
        key = (*key, part)
    return key, holder, field


def _table_of(field: FieldInfo, data: Any) -> type[Table] | None:
    """The table that a field holds: of several, the one whose kind is that of the data."""
    candidates = list(_tables_in(field.annotation))
    if len(candidates) > 1 and isinstance(data, Mapping):
        candidates = [table for table in candidates if _fits(table, data)]
    return candidates[0] if len(candidates) == 1 else None


def _tables_in(annotation: Any) -> Iterator[type[Table]]:
    if isinstance(annotation, type) and get_origin(annotation) is None and issubclass(annotation, Table):
        yield annotation
    for argument in get_args(annotation):
        yield from _tables_in(argument)


def _fits(table: type[Table], data: Mapping[str, Any]) -> bool:
    """Whether the first key that takes fixed names, which by convention is the kind, has one of them."""
    for name, field in table.model_fields.items():
        if _is_kind(field):
            return data.get(name) in get_args(field.annotation)
    return False


def _is_kind(field: FieldInfo) -> bool:
    """Whether a key takes fixed names: the first such is by convention the kind of its table."""
    return get_origin(field.annotation) is Literal


def _contradictions(
    model: type[Table], data: Any, key: Key, bad: set[Key], context: Mapping[str, Any]
) -> Iterator[Fault]:
    """What the checks of a table and of those inside it find, as far as its keys are sound."""
    sound = _sound(model, data, key, bad, context)
    for name, field in model.model_fields.items():
        for inner, value, here in _inner_tables(field, data.get(name), (*key, name), bad):
            yield from _contradictions(inner, value, here, bad, context)
    for method in model._checks():
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
        table = _table_of(field, item) if isinstance(item, Mapping) else None
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
            adapter = TypeAdapter[Any](field.rebuild_annotation(), config=_STRICT)
            values[name] = adapter.validate_python(data[name], context=context)
        elif name not in data and not field.is_required():
            values[name] = field.get_default(call_default_factory=True)
    table = model.model_construct(**values)
    for name in set(model.model_fields) - set(values):
        table.__dict__.pop(name, None)  # the default that model_construct put in place of a faulty value
    return table
