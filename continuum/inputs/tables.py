"""Tables of input files: strict typed models, and families of them of which an input names one.

A table of a TOML file is a frozen :class:`Table`.  A key that is unknown, of the wrong type or out of range is a
fault, and so is whatever a method marked :func:`constraint` finds where keys contradict one another.  Where a table
comes in several kinds, it is a :class:`Table`: each subclass is one kind, and an input knows it as soon as it is
defined.  What Python makes as well, a wall or a substrate, is :class:`Description`: one class, whose fields are the
arguments in Python and the keys of an input, with bounds that are said once, in their annotations.

Validation has one mechanism and two doors: :mod:`continuum.inputs.reading` tells of all faults of a file with their
lines, and Python of the first fault of its arguments, as :class:`~continuum.inputs.arguments.ArgumentError`.
"""

import ast
import hashlib
import inspect
import math
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, reduce
from inspect import Parameter, Signature, isfunction, signature
from itertools import pairwise
from operator import or_
from pathlib import Path
from textwrap import dedent
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Self,
    TypeVar,
    cast,
    dataclass_transform,
    get_args,
)

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    Tag,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic.functional_validators import ModelWrapValidatorHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, PydanticCustomError

from continuum.inputs.arguments import ArgumentError, hint
from continuum.inputs.keys import frozen, parts, what_is_allowed

Key = tuple[str | int, ...]
"""Place of a value in a file: names of tables and keys, and indices of arrays."""
STRICT = ConfigDict(strict=True, allow_inf_nan=False, defer_build=True)
"""Numbers are no texts and no booleans, and all of them are finite.  A table is compiled when it is first read."""
_Method = TypeVar("_Method", bound=Callable[..., Iterator["Fault"]])


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with an input.

    Parameters
    ----------
    key : where, relative to the table that finds it; the value given is looked up there.
    allowed : what is allowed, the text after "allowed: ".
    cause : the usual cause or what helps; empty if the above says it.
    """

    key: Key
    allowed: str
    cause: str = ""


def constraint(method: _Method) -> _Method:
    """Mark a method of a table that yields faults between its keys.

    It may use any key: if one of them is faulty, the check is skipped.
    """
    vars(method)["_is_check"] = True
    return method


class Table(BaseModel):
    """A table of an input file: unknown keys, loose types, infinities and NaN are faults.

    A subclass that sets ``kind_key`` is a family of tables of several kinds.  Its kinds are the subclasses that are
    defined with a name, as ``class Layer(Response, kind="layer")``, and those whose key ``kind_key`` takes fixed names.
    A family derived from another has the kinds of both.

    The docstring of a key is shown in messages about it (:func:`explained`).
    """

    model_config = ConfigDict(**STRICT, extra="forbid", frozen=True, arbitrary_types_allowed=True)
    not_identity: ClassVar[frozenset[str]] = frozenset()
    """Keys that do not change results: threads, output options."""
    newer: ClassVar[frozenset[str]] = frozenset()
    """Keys added after results were stored: they count for the identity only if they differ from their default."""
    alone: ClassVar[frozenset[str]] = frozenset()
    """Keys of whose value nothing else in an input depends, nor whether it is valid."""
    renamed: ClassVar[Mapping[str, str]] = {}
    """Keys that had another name when results were first stored, with that name; files and identities have it."""
    kind_key: ClassVar[str] = ""
    """The key that names the kind of a table that has several."""
    kind_name: ClassVar[str] = ""
    """The name of this kind, the class's argument ``kind``; empty if ``kind_key`` is a field with fixed names."""
    kinds: ClassVar[MutableMapping[str, type[Any]]] = {}
    """The kinds of a family by their names, in the order in which they were defined."""
    constraints: ClassVar[tuple[Callable[[Any], Iterator[Fault]], ...]] = ()
    """The methods that are marked as :func:`constraint`."""

    def __init_subclass__(cls, *, kind: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)

    @classmethod
    def __pydantic_init_subclass__(cls, *, kind: str = "", **options: Any) -> None:
        super().__pydantic_init_subclass__(**options)
        cls.kind_name = kind or cls.kind_name
        members = filter(isfunction, (member for base in reversed(cls.__mro__) for member in list(vars(base).values())))
        cls.constraints = tuple(method for method in members if getattr(method, "_is_check", False))
        if cls.is_family():
            cls.kinds = ChainMap({}, cls.kinds)
        elif kind:
            cls.kinds[kind] = cls
        elif field := cls.model_fields.get(cls.kind_key):
            cls.kinds.update(dict.fromkeys(get_args(field.annotation), cls))

    @classmethod
    def is_family(cls) -> bool:
        """True if this class stands for all its kinds."""
        return bool(vars(cls).get("kind_key"))

    @classmethod
    def kind_of(cls, data: Any) -> type[Any] | None:
        """The table itself; of a family the kind that its keys and values name, None if there is none."""
        if not cls.is_family():
            return cls
        name = data.get(cls.kind_key) if isinstance(data, Mapping) else None
        return cls.kinds.get(name) if isinstance(name, str) else None

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        if cls.is_family():
            kinds = (Annotated[kind, Tag(name)] for name, kind in cls.kinds.items())
            family: Any = Annotated[reduce(or_, kinds), Discriminator(lambda data: data.get(cls.kind_key))]
            return handler(TypeAdapter(family).core_schema)
        found = handler(schema)
        own = handler.resolve_ref_schema(found)
        for name, field in explained(cls).items():
            if name not in cls.model_fields:  # the name of its kind
                own["properties"] = {name: {"const": cls.kind_name, "type": "string"}, **own["properties"]}
                own["required"] = [name, *own.get("required", [])]
            elif field.description:
                own["properties"][name]["description"] = field.description
        return found

    @model_validator(mode="before")
    @classmethod
    def _as_of_today(cls, data: Any, info: ValidationInfo) -> Any:
        """The keys by their names of today, without the one that names the kind, where that is no field."""
        if not isinstance(data, Mapping):
            return data
        # Only what was stored may have them: an input with one is of nobody's.
        stored = info.context is not None and info.context.get("restored")
        names = {before: name for name, before in cls.renamed.items() if name not in data} if stored else {}
        without = cls.kind_key if cls.kind_name and data.get(cls.kind_key) == cls.kind_name else None
        return {names.get(key, key): value for key, value in data.items() if key != without}

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        faults = [fault for method in self.constraints for fault in method(self)]
        if faults:
            places = [".".join(map(str, fault.key)) for fault in faults]
            text = "; ".join(f"{place}: allowed: {f.allowed}" for place, f in zip(places, faults, strict=True))
            allowed = f"{faults[0].allowed}: {faults[0].cause}".removesuffix(": ")
            first = places[0], getattr(self, places[0], None), allowed
            raise PydanticCustomError("inconsistent", "{text}", {"text": text, "first": first})
        return self

    def plain(self, *, identity: bool = False) -> dict[str, Any]:
        """Keys and values as JSON has them, defaults included; files by the hash of their content.

        With ``identity``, without keys that do not change results.
        """
        fields = type(self).model_fields
        absent = {name for name in self.newer if self.value(name) == fields[name].get_default()}
        names = [name for name in fields if not (identity and name in self.not_identity | absent)]
        named = {self.kind_key: self.kind_name} if self.kind_name else {}
        stored = self.renamed if identity else {}
        return named | {stored.get(name, name): _plain(self.value(name), identity) for name in names}

    def value(self, name: str) -> Any:
        """The value of a key as it was given, or its default."""
        return self.kind_name if self.kind_name and name == self.kind_key else getattr(self, name)

    @model_validator(mode="wrap")  # the last, so that a family checks nothing itself
    @classmethod
    def _of_its_kind(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Any:
        if not cls.is_family():
            return handler(data)
        if type(data) in cls.kinds.values():
            return data
        if not isinstance(data, dict):
            raise PydanticCustomError("model_type", "a table")
        if kind := cls.kind_of(data):
            return kind.model_validate(data, context=info.context)
        names = {"key": cls.kind_key, "names": list(cls.kinds)}
        raise PydanticCustomError("kind", "a table whose {key} is one of its kinds", names)

    @property
    def origin(self) -> str:
        """The key that says where the values come from: the file that is read, else the kind of table."""
        return "path" if "path" in type(self).model_fields else self.kind_key

    def keywords(self) -> dict[str, Any]:
        """All keys but the kind, with their values; raises AttributeError, as any key does, if one is faulty."""
        return {name: getattr(self, name) for name in type(self).model_fields if name != self.kind_key}


class _Fields(dict[str, Any]):
    """Values of the fields of an object that is there already."""


def _init_of(fields: Mapping[str, FieldInfo]) -> Any:
    """An ``__init__`` whose arguments are the fields, by position or by name."""
    required = [field.is_required() for field in fields.values()]
    kind = Parameter.POSITIONAL_OR_KEYWORD if required == sorted(required, reverse=True) else Parameter.KEYWORD_ONLY
    defaults = [Parameter.empty if field.is_required() else field.default for field in fields.values()]
    arguments = [Parameter(name, kind, default=value) for name, value in zip(fields, defaults, strict=True)]

    def __init__(self: Description, *values: Any, **named: Any) -> None:
        try:
            named = {name: value for name, value in named.items() if (name, value) != (self.kind_key, self.kind_name)}
            given = Signature(arguments).bind(*values, **named).arguments
        except TypeError as error:
            unknown = next((name for name in named if name not in fields), "")
            raise TypeError(f"{type(self).__name__}({', '.join(fields)}): {error}{hint(unknown, fields)}") from None
        self._take(**given)

    vars(__init__)["__signature__"] = Signature([Parameter("self", Parameter.POSITIONAL_ONLY), *arguments])
    return __init__


@dataclass_transform(kw_only_default=False, field_specifiers=(Field,))
class Description(Table):
    """Table of an input that is also a class of Python: a wall, a substrate, a surface.

    The fields are the arguments in Python, by position or by name, and the keys of a table.  Objects are immutable;
    they compare, hash and pickle by their fields.  In an input a bound may be narrower: :class:`InInputs`.
    """

    example: ClassVar[Mapping[str, Any]]
    """Keys of one object of this kind, of which what holds for every kind is tested."""

    @classmethod
    def __pydantic_init_subclass__(cls, *, kind: str = "", **options: Any) -> None:
        super().__pydantic_init_subclass__(kind=kind, **options)
        if cls.__init__ is Table.__init__ or hasattr(cls.__init__, "__signature__"):  # none of its own
            cls.__init__ = _init_of(cls.model_fields)  # type: ignore[method-assign]
        # Before a class is compiled, which is when it is first used, it would show the signature of its base.
        cls.__signature__ = Signature([*signature(cls.__init__).parameters.values()][1:])

    def _take(self, **given: Any) -> None:
        """Take the values of the fields; raises ArgumentError for the first that is not allowed."""
        kept = {name: value for name, value in given.items() if isinstance(value, np.ndarray) and value.ndim}
        given |= {name: frozen(value) for name, value in given.items() if name not in kept}
        try:
            self.__pydantic_validator__.validate_python(_Fields(given), self_instance=self)
        except ValidationError as error:
            raise _argument_error(type(self), given, error.errors(include_url=False)[0]) from None

    @model_validator(mode="wrap")
    @classmethod
    def _without_init(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Any:
        """An object of an input is made of its fields: ``__init__`` is the door of Python alone.

        In Python a tuple stands for an object, too: its arguments, by position.
        """
        if isinstance(data, tuple) and info.context is None:
            if len(data) > len(cls.model_fields):
                raise PydanticCustomError("arguments", "({names})", {"names": ", ".join(cls.model_fields)})
            data = dict(zip(cls.model_fields, data, strict=False))
        if isinstance(data, _Fields) or not isinstance(data, dict) or cls.is_family():
            return handler(data)
        made = cls.__new__(cls)
        made.__pydantic_validator__.validate_python(_Fields(data), self_instance=made, context=info.context)
        return made

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(
            f"a {type(self).__name__} is immutable: model_copy(update={{{name!r}: ...}}) makes another"
        )

    def __str__(self) -> str:
        return repr(self)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """The same with other values of some fields, which are checked; what was derived is derived anew."""
        given = {name: self.value(name) for name in self.model_fields_set}
        copy = type(self).__new__(type(self))
        copy._take(**given | dict(update or {}))
        return copy


def _argument_error(table: type[Table], values: Mapping[str, Any], error: ErrorDetails) -> ArgumentError:
    """The error of a function for one of pydantic's errors."""
    if error["type"] == "inconsistent":
        return ArgumentError(*error["ctx"]["first"])
    key, holder, field, _ = located(error["loc"], values, table)
    given, words = error["input"], what_is_allowed(error, field, in_inputs=False)
    if error["type"] == "missing":  # of a list of so many entries, or of the arguments of an object inside
        key, field = key[:-1], None
    if error["type"] == "model_type" and field:
        holder = table_in(field.annotation)
    if error["type"] in ("missing", "model_type", "extra_forbidden") and holder and not isinstance(given, tuple):
        words = f"a {holder.__name__}" if holder.is_family() else f"({', '.join(holder.model_fields)})"
        given = tuple(given.values()) if isinstance(given, dict) else given
    name = ""
    for part in key:
        name = f"{name}[{part}]" if isinstance(part, int) else f"{part} of {name}".removesuffix(" of ")
    return ArgumentError(name, given, words)


@cache
def explained(table: type[Table]) -> dict[str, FieldInfo]:
    """The keys of a table, each described by the text below it in the source, which is read when it is shown.

    First the key that names its kind, also where that is no field.
    """
    meanings: dict[str, str] = {}
    for base in reversed(table.__mro__[: table.__mro__.index(Table)]):
        with suppress(OSError):  # without a source there is nothing to say
            for key, text in pairwise(cast(ast.ClassDef, ast.parse(dedent(inspect.getsource(base))).body[0]).body):
                match key, text:
                    case ast.AnnAssign(target=ast.Name(name)), ast.Expr(ast.Constant(str(said))):
                        meanings[name] = inspect.cleandoc(said)
    named = {table.kind_key: FieldInfo(annotation=cast(Any, Literal)[table.kind_name])} if table.kind_name else {}
    for name, field in table.model_fields.items():
        field.description = meanings.get(name)
    return named | table.model_fields


def table_in(annotation: Any) -> type[Table] | None:
    """The table, or the family of tables, that a key of a type may hold, itself or in a list."""
    return next((part for part in parts(annotation) if isinstance(part, type) and issubclass(part, Table)), None)


def tables_in(annotation: Any) -> tuple[type[Table], ...]:
    """The tables that a key of a type may hold, each kind of a family."""
    table = table_in(annotation)
    return () if table is None else tuple(dict.fromkeys(table.kinds.values())) if table.is_family() else (table,)


class Place(NamedTuple):
    """Place in a table of one of pydantic's errors."""

    key: Key
    holder: type[Table] | None
    """The table that holds the key."""
    field: FieldInfo | None
    among: Key | None
    """The key that may have several types, of which the error is that of one."""


def located(location: tuple[int | str, ...], data: Any, table: type[Table]) -> Place:
    """Place of an error of a table."""
    key, among = Key(), None
    inner: type[Table] | None = table
    holder, field = inner, None
    for part in location:
        if isinstance(part, int) and not isinstance(data, tuple):  # one value in place of a list
            continue
        if isinstance(part, int):
            data = data[part] if part < len(data) else None
        elif inner is not None:
            holder, field = inner, explained(inner).get(part)
            data = data.get(part) if isinstance(data, Mapping) else None
        elif isinstance(data, Mapping) and part in data:
            holder, field, data = None, None, data[part]
        else:
            among = key if among is None else among
            continue
        inner = table_of(field, data)
        key = (*key, part)
    return Place(key, holder, field, among)


def table_of(field: FieldInfo | None, data: Any) -> type[Table] | None:
    """The table that a field holds: of several, the one whose kind is that of the data."""
    table = table_in(field.annotation) if field else None
    return table.kind_of(data) if table else None


def _plain(value: Any, identity: bool) -> Any:
    if isinstance(value, Table):
        return value.plain(identity=identity)
    if isinstance(value, Path):
        content = {"sha256": hashlib.sha256(value.read_bytes()).hexdigest()}
        return content if identity else {"name": value.name, **content}
    if isinstance(value, tuple):
        return [_plain(item, identity) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
