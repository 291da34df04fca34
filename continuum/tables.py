"""Tables of input files: strict typed models, and families of them of which an input names one.

A table of a TOML file is a frozen :class:`Table`.  A key that is unknown, of the wrong type or out of range is a
fault, and so is whatever a method marked :func:`constraint` finds where keys contradict one another.  Where a table
comes in several kinds, it is a :class:`TableFamily`: each subclass is one kind, and an input knows it as soon as it is
defined.  What Python makes as well, a wall or a substrate, is :class:`Description`: one class, whose fields are the
arguments in Python and the keys of an input, with bounds that are said once, in their annotations.

Validation has one mechanism and two doors: :mod:`continuum.files.inputs` tells of all faults of a file with their
lines, and Python of the first fault of its arguments, as :class:`~continuum.arguments.ArgumentError`.
"""

import ast
import hashlib
import inspect
import math
import os
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, reduce
from inspect import Parameter, Signature, isfunction, signature
from itertools import chain, pairwise
from numbers import Real
from operator import or_
from pathlib import Path
from textwrap import dedent
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    Self,
    TypeVar,
    cast,
    dataclass_transform,
    get_args,
    get_origin,
)

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    Tag,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, PydanticCustomError

from continuum.arguments import ArgumentError

Key = tuple[str | int, ...]
"""Where a value stands: names of tables and keys, and indices of arrays."""
LARGEST_N = 65536
"""Points or atoms along a side, at most."""
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

    The docstring of a key is shown in messages about it (:func:`explained`).
    """

    model_config = ConfigDict(**STRICT, extra="forbid", frozen=True, arbitrary_types_allowed=True)
    not_identity: ClassVar[frozenset[str]] = frozenset()
    """Keys that do not change results: threads, output options."""
    newer: ClassVar[frozenset[str]] = frozenset()
    """Keys added after results were stored: they count for the identity only if they differ from their default."""
    renamed: ClassVar[Mapping[str, str]] = {}
    """Keys that had another name when results were stored, with that name: inputs may use it, the identity does."""
    kind_key: ClassVar[str] = ""
    """The key that names the kind of a table that has several."""
    kind_name: ClassVar[str] = ""
    """The name of this kind, the class's argument ``kind``; empty if ``kind_key`` is a field with fixed names."""
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

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        found = handler(schema)
        properties = handler.resolve_ref_schema(found)["properties"]
        for name, field in cls.model_fields.items():
            properties[name] |= {"description": field.description} if explained(cls)[name].description else {}
        if cls.kind_name:
            named = {cls.kind_key: {"const": cls.kind_name, "type": "string"}}
            of_model = handler.resolve_ref_schema(found)
            of_model["properties"] = named | properties
            of_model["required"] = [cls.kind_key, *of_model.get("required", [])]
        return found

    @property
    def origin(self) -> str:
        """The key that says where the values come from: the file that is read, else the kind of table."""
        return "path" if "path" in type(self).model_fields else self.kind_key

    @model_validator(mode="before")
    @classmethod
    def _as_of_today(cls, data: Any) -> Any:
        """The keys by their names of today, without the one that names the kind, where that is no field."""
        if not isinstance(data, Mapping):
            return data
        names = {before: name for name, before in cls.renamed.items() if name not in data}
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


class TableFamily(Table):
    """A table of several kinds.

    A subclass that sets ``kind_key`` is a family.  Its kinds are the subclasses that are defined with a name, as
    ``class Layer(Response, kind="layer")``, and those whose key ``kind_key`` takes fixed names.  A family derived from
    another has the kinds of both.
    """

    kinds: ClassVar[MutableMapping[str, type[Any]]]
    """The kinds by their names, in the order in which they were defined."""

    def keywords(self) -> dict[str, Any]:
        """All keys but the kind, with their values; raises AttributeError, as any key does, if one is faulty."""
        return {name: getattr(self, name) for name in type(self).model_fields if name != self.kind_key}

    @classmethod
    def is_family(cls) -> bool:
        """Whether this class stands for all its kinds."""
        return "kind_key" in vars(cls)

    @classmethod
    def __pydantic_init_subclass__(cls, *, kind: str = "", **options: Any) -> None:
        super().__pydantic_init_subclass__(kind=kind, **options)
        if cls.is_family():
            cls.kinds = ChainMap({}, getattr(cls, "kinds", {}))
        elif kind:
            cls.kinds[kind] = cls
        elif field := cls.model_fields.get(cls.kind_key):
            cls.kinds.update(dict.fromkeys(get_args(field.annotation), cls))

    @classmethod
    def kind_of(cls, data: Mapping[str, Any]) -> type[Table] | None:
        """The kind that these keys and values name; None if there is none."""
        name = data.get(cls.kind_key)
        return cls.kinds.get(name) if isinstance(name, str) else None

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        if not cls.is_family():
            return super().__get_pydantic_json_schema__(schema, handler)
        kinds = tuple(Annotated[kind, Tag(name)] for name, kind in cls.kinds.items())
        family: Any = Annotated[reduce(or_, kinds), Discriminator(cls.kind_of)]
        return handler(TypeAdapter(family).core_schema)

    @model_validator(mode="wrap")
    @classmethod
    def _of_its_kind(cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Any:
        if not cls.is_family():
            return handler(data)
        if type(data) in cls.kinds.values():
            return data
        if not isinstance(data, dict):
            raise PydanticCustomError("model_type", "a table")
        kind = cls.kind_of(data)
        if kind is None:
            names = {"key": cls.kind_key, "names": list(cls.kinds)}
            raise PydanticCustomError("kind", "a table whose {key} is one of its kinds", names)
        return kind.model_validate(data, context=info.context)


class _Fields(dict[str, Any]):
    """Values of the fields of an object that is there already."""


@dataclass_transform(kw_only_default=False, field_specifiers=(Field,))
class Description(TableFamily):
    """What an input describes and Python makes, with the same fields: a wall, a substrate, a surface.

    The fields are the arguments in Python, by position or by name, and the keys of a table.  Objects are immutable;
    they compare, hash and pickle by their fields.  In an input a bound may be narrower: :class:`InInputs`.
    """

    example: ClassVar[Mapping[str, Any]]
    """Keys of one object of this kind, of which what holds for every kind is tested."""

    def __init__(self, *values: Any, **named: Any) -> None:
        self._take(*values, **named)

    @classmethod
    def __pydantic_init_subclass__(cls, *, kind: str = "", **options: Any) -> None:
        super().__pydantic_init_subclass__(kind=kind, **options)
        if "__init__" not in vars(cls):  # one whose signature names the fields

            def __init__(self: Description, *values: Any, **named: Any) -> None:
                self._take(*values, **named)

            one, fields = Parameter.POSITIONAL_OR_KEYWORD, cls.model_fields.items()
            defaults = {name: Parameter.empty if field.is_required() else field.default for name, field in fields}
            given = [Parameter(name, one, default=value) for name, value in defaults.items()]
            vars(__init__)["__signature__"] = Signature([Parameter("self", Parameter.POSITIONAL_ONLY), *given])
            cls.__init__ = __init__  # type: ignore[method-assign]
        # A class that is not yet compiled would show that of its base.
        cls.__signature__ = Signature([*signature(cls.__init__).parameters.values()][1:])

    def _take(self, *values: Any, **named: Any) -> None:
        """Take the values of the fields; raises ArgumentError for the first that is not allowed."""
        fields = type(self).model_fields
        given = dict(zip(fields, values, strict=False))
        if len(values) > len(fields) or not given.keys().isdisjoint(named):
            raise TypeError(f"{type(self).__name__} has the arguments {', '.join(fields)}, each once")
        for name, value in (given | named).items():
            given[name] = value if isinstance(value, np.ndarray) and value.ndim else frozen(value)
        try:
            self.__pydantic_validator__.validate_python(_Fields(given), self_instance=self)
        except ValidationError as error:
            raise _argument_error(type(self), error.errors(include_url=False)[0]) from None

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


def frozen(value: Any) -> Any:
    """Lists and arrays as tuples, which strict models ask for; numbers of NumPy and fractions as those of Python."""
    if type(value) in (float, int, str):
        return value
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return tuple(map(frozen, value))
    return float(value) if isinstance(value, Real) and not isinstance(value, int) else value


class InInputs(AfterValidator):
    """Bounds gt, ge, lt, le of a number, in an input only, beside those of Python: a mistaken unit is likely there."""

    def __init__(self, **bounds: float) -> None:
        bounded = TypeAdapter(Annotated[float, Field(**bounds)])

        def narrowed(value: Any, info: ValidationInfo) -> Any:
            return value if info.context is None else bounded.validate_python(value)

        super().__init__(narrowed)
        vars(self).update(bounds)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return handler(schema) | TypeAdapter(Annotated[float, Field(**vars(self))]).json_schema()


_LIMITS = {"gt": "greater than", "ge": "greater than or equal to", "lt": "less than", "le": "less than or equal to"}


def limits_of(field: FieldInfo, *, in_inputs: bool = True) -> dict[str, float]:
    """Bounds of a number by their names gt, ge, lt and le; those of inputs instead of wider ones."""
    found: dict[str, float] = {}
    parts = [field.metadata, *(getattr(part, "__metadata__", ()) for part in get_args(field.annotation))]
    for limit in chain.from_iterable(parts):
        for one in getattr(limit, "metadata", (limit,)):
            if in_inputs or not isinstance(one, InInputs):
                found |= {name: bound for name in _LIMITS if (bound := getattr(one, name, None)) is not None}
    return {name: found[name] for name in _LIMITS if name in found}


def _argument_error(table: type[Table], fault: ErrorDetails) -> Exception:
    """The error of a function for one of pydantic's errors."""
    key, kind, context = [*fault["loc"]], fault["type"], fault.get("ctx", {})
    if len(key) == 1 and kind in ("missing", "extra_forbidden"):
        has = "lacks the argument" if kind == "missing" else "has no argument"
        return TypeError(f"{table.__name__} {has} {key[0]}; it has {', '.join(table.model_fields)}")
    if kind == "inconsistent":
        return ArgumentError(*context["first"])
    if kind == "missing":
        key = key[:-1]
    name, field = "", None
    for part in key:
        if isinstance(part, int):
            name += f"[{part}]"
        else:
            table = table_in(field.annotation) or table if field else table
            field = table.model_fields.get(part)
            name = f"{part} of {name}" if name else part
    arguments = table_in(field.annotation) if field and kind == "missing" else None
    allowed = f"({', '.join(arguments.model_fields)})" if arguments else _allowed(fault, field)
    given = fault["input"]
    return ArgumentError(name, tuple(given.values()) if arguments and isinstance(given, dict) else given, allowed)


_OF_NUMBERS = ("float_type", "finite_number", "greater_than", "greater_than_equal", "less_than", "less_than_equal")
_PLAINLY = {"bool_type": "True or False", "too_long": "a list of at most {max_length} entries", "tuple_type": "a list"}


def _allowed(fault: ErrorDetails, field: FieldInfo | None) -> str:
    """What an argument may be, in the words of :mod:`continuum.arguments`."""
    kind, annotation, limits = fault["type"], None, {}
    if field:
        annotation, limits = field.annotation, limits_of(field, in_inputs=False)
    if kind == "literal_error":
        return "one of " + ", ".join(f'"{choice}"' for choice in get_args(annotation))
    if kind == "missing":
        return f"{len(get_args(annotation))} entries"
    if kind in _OF_NUMBERS and annotation is not int:
        words = " and ".join(f"{_LIMITS[name]} {bound:g}" for name, bound in limits.items())
        return f"a finite number {words}".rstrip()
    if kind in (*_OF_NUMBERS, "int_type"):
        return f"a whole number from {limits.get('ge', 0):g} " + (f"to {limits['le']:.15g}" if "le" in limits else "on")
    return _PLAINLY[kind].format(**fault.get("ctx", {})) if kind in _PLAINLY else fault["msg"]


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
    if isinstance(annotation, type) and get_origin(annotation) is None:
        return annotation if issubclass(annotation, Table) else None
    return next(filter(None, map(table_in, get_args(annotation))), None)


def tables_in(annotation: Any) -> tuple[type[Table], ...]:
    """The tables that a key of a type may hold, each kind of a family."""
    table = table_in(annotation)
    if table is None:
        return ()
    return (
        tuple(dict.fromkeys(table.kinds.values())) if issubclass(table, TableFamily) and table.is_family() else (table,)
    )


def _plain(value: Any, identity: bool) -> Any:
    if isinstance(value, Table):
        return value.plain(identity=identity)
    if isinstance(value, Path):
        content = {"sha256": hashlib.sha256(value.read_bytes()).hexdigest()}
        return content if identity else {"name": value.name, **content}
    if isinstance(value, tuple):
        return [_plain(item, identity) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _existing(value: object, info: ValidationInfo) -> Path:
    if isinstance(value, dict) and (info.context or {}).get("restored"):
        return Path(str(value.get("name")))
    if isinstance(value, str):
        path = Path(str((info.context or {}).get("folder", "."))) / value
    elif isinstance(value, Path):
        path = value
    else:
        raise PydanticCustomError("file_name", "the name of a file, in quotes")
    if not os.path.isfile(path):  # noqa: PTH113 - Path.is_file raises for names with a NUL, or far too long
        raise PydanticCustomError("missing_file", "an existing file, relative to the folder of this input")
    return path


def both_directions(
    kind: type[int] | type[float], low: float, high: float, allowed: str, *, one_for_both: bool = False
) -> BeforeValidator:
    """Validator: two numbers, along x and y, or where one serves for both directions that one."""

    def both(value: Any) -> Any:
        values = (value, value) if one_for_both and not isinstance(value, (tuple, list)) else value
        kinds = (int,) if kind is int else (int, float)
        sound = isinstance(values, (tuple, list)) and len(values) == 2
        sound = sound and all(type(v) in kinds and low <= v <= high for v in values)
        if not sound:
            raise PydanticCustomError("pair", "{allowed}", {"allowed": allowed})
        return tuple(kind(v) for v in values)

    return BeforeValidator(both)


InputFile = Annotated[Path, BeforeValidator(_existing)]
"""A file that must exist, relative to the input file; the identity contains its content."""
Positive = Annotated[float, Field(gt=0)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]
"""Seed of random numbers."""


def _or_infinite(value: Any, finite: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
    in_python = info.context is None and isinstance(value, float) and value == math.inf
    return math.inf if value is None or in_python else finite(value)


OrInfinite = Annotated[float, Field(gt=0), WrapValidator(_or_infinite)]
"""A positive number; infinite in Python, and not given in an input, where there is no bound."""
Fraction = Annotated[float, Field(gt=0, lt=1)]
"""A number between 0 and 1."""
