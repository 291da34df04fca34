"""Tables of input files: strict typed models, and families of them of which an input names one.

A table of a TOML file is a frozen :class:`Table`.  A key that is unknown, of the wrong type or out of range is a
fault, and so is whatever a method marked :func:`constraint` finds where keys contradict one another.  Where a table
comes in several kinds, it is a :class:`TableFamily`: each subclass is one kind, and an input knows it as soon as it is
defined.
"""

import ast
import hashlib
import inspect
import os
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from inspect import isfunction
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import Annotated, Any, ClassVar, Self, TypeVar, cast, get_args, get_origin

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

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

    model_config = ConfigDict(**STRICT, extra="forbid", frozen=True)
    not_identity: ClassVar[frozenset[str]] = frozenset()
    """Keys that do not change results: threads, output options."""
    newer: ClassVar[frozenset[str]] = frozenset()
    """Keys added after results were stored: they count for the identity only if they are given."""
    renamed: ClassVar[Mapping[str, str]] = {}
    """Keys that had another name when results were stored, with that name: inputs may use it, the identity does."""
    kind_key: ClassVar[str] = ""
    """The key that names the kind of a table that has several."""
    constraints: ClassVar[tuple[Callable[[Any], Iterator[Fault]], ...]] = ()
    """The methods that are marked as :func:`constraint`."""

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        super().__pydantic_init_subclass__(**options)
        members = filter(isfunction, (member for base in reversed(cls.__mro__) for member in list(vars(base).values())))
        cls.constraints = tuple(method for method in members if getattr(method, "_is_check", False))

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        found = handler(schema)
        properties = handler.resolve_ref_schema(found)["properties"]
        for name, field in explained(cls).items():
            properties[name] |= {"description": field.description} if field.description else {}
        return found

    @property
    def origin(self) -> str:
        """The key that says where the values come from: the file that is read, else the kind of table."""
        return "path" if "path" in type(self).model_fields else self.kind_key

    @model_validator(mode="before")
    @classmethod
    def _with_names_of_today(cls, data: Any) -> Any:
        if not cls.renamed or not isinstance(data, Mapping):
            return data
        names = {before: name for name, before in cls.renamed.items() if name not in data}
        return {names.get(key, key): value for key, value in data.items()}

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        faults = [fault for method in self.constraints for fault in method(self)]
        if faults:
            text = "; ".join(f"{'.'.join(map(str, f.key))}: allowed: {f.allowed}" for f in faults)
            raise PydanticCustomError("inconsistent", "{text}", {"text": text})
        return self

    def plain(self, *, identity: bool = False) -> dict[str, Any]:
        """Keys and values as JSON has them, defaults included; files by the hash of their content.

        With ``identity``, without keys that do not change results.
        """
        absent = {name for name in self.newer if getattr(self, name) is None}
        left_out = self.not_identity | absent if identity else set()
        names = [name for name in type(self).model_fields if name not in left_out]
        stored = self.renamed if identity else {}
        return {stored.get(name, name): _plain(getattr(self, name), identity) for name in names}


class TableFamily(Table):
    """A table of several kinds.

    A subclass that sets ``kind_key`` is a family, and each of its subclasses whose key of that name takes fixed names
    is one of its kinds.  A family derived from another has the kinds of both.
    """

    kinds: ClassVar[MutableMapping[str, type[Table]]]
    """The kinds by their names, in the order in which they were defined."""

    def keywords(self) -> dict[str, Any]:
        """All keys but the kind, with their values."""
        return {name: value for name, value in self if name != self.kind_key}

    @classmethod
    def is_family(cls) -> bool:
        """Whether this class stands for all its kinds."""
        return "kind_key" in vars(cls)

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        super().__pydantic_init_subclass__(**options)
        if cls.is_family():
            cls.kinds = ChainMap({}, getattr(cls, "kinds", {}))
        elif field := cls.model_fields.get(cls.kind_key):
            cls.kinds.update(dict.fromkeys(get_args(field.annotation), cls))

    @classmethod
    def kind_of(cls, data: Mapping[str, Any]) -> type[Table] | None:
        """The kind that these keys and values name; None if there is none."""
        name = data.get(cls.kind_key)
        return cls.kinds.get(name) if isinstance(name, str) else None

    @classmethod
    def __get_pydantic_core_schema__(cls, source: type[BaseModel], handler: GetCoreSchemaHandler) -> CoreSchema:
        if not cls.is_family():
            return handler(source)
        return core_schema.with_info_plain_validator_function(cls._of_its_kind)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        if not cls.is_family():
            return super().__get_pydantic_json_schema__(schema, handler)
        for kind in cls.kinds.values():
            kind.model_rebuild()
        kinds = {name: kind.__pydantic_core_schema__ for name, kind in cls.kinds.items()}
        return handler(core_schema.tagged_union_schema(dict(kinds), discriminator=cls.kind_key))

    @classmethod
    def _of_its_kind(cls, data: Any, info: ValidationInfo) -> Table:
        if type(data) in cls.kinds.values():
            return cast(Table, data)
        if not isinstance(data, dict):
            raise PydanticCustomError("model_type", "a table")
        kind = cls.kind_of(data)
        if kind is None:
            names = {"key": cls.kind_key, "names": list(cls.kinds)}
            raise PydanticCustomError("kind", "a table whose {key} is one of its kinds", names)
        return kind.model_validate(data, context=info.context)


@cache
def explained(table: type[Table]) -> dict[str, FieldInfo]:
    """The keys of a table, each described by the text below it in the source, which is read when it is shown."""
    meanings: dict[str, str] = {}
    for base in reversed(table.__mro__[: table.__mro__.index(Table)]):
        with suppress(OSError):  # without a source there is nothing to say
            for key, text in pairwise(cast(ast.ClassDef, ast.parse(dedent(inspect.getsource(base))).body[0]).body):
                match key, text:
                    case ast.AnnAssign(target=ast.Name(name)), ast.Expr(ast.Constant(str(said))):
                        meanings[name] = inspect.cleandoc(said)
    for name, field in table.model_fields.items():
        field.description = meanings.get(name)
    return table.model_fields


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
    return value


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
Fraction = Annotated[float, Field(gt=0, lt=1)]
"""A number between 0 and 1."""
