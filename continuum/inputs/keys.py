"""Types of keys and arguments: numbers in bounds, pairs, files; and what is allowed, in words."""

import math
import os
from collections.abc import Iterator
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails, PydanticCustomError

LARGEST_N = 65536
"""Points or atoms along a side, at most."""


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


def parts(annotation: Any) -> Iterator[Any]:
    """A type, those that it is made of, and what is said of them."""
    yield annotation
    for part in get_args(annotation):
        yield from parts(part)


_LIMITS = {"gt": "greater than", "ge": "greater than or equal to", "lt": "less than", "le": "less than or equal to"}


def limits_of(field: FieldInfo, *, in_inputs: bool = True) -> dict[str, float]:
    """Bounds of a number by their names gt, ge, lt and le; those of inputs instead of wider ones."""
    found: dict[str, float] = {}
    for part in (*field.metadata, *parts(field.annotation)):
        for limit in getattr(part, "metadata", (part,)):
            if in_inputs or not isinstance(limit, InInputs):
                found |= {name: bound for name in _LIMITS if (bound := getattr(limit, name, None)) is not None}
    if 0 < found.get("ge", 0) <= SMALLEST:  # a bound that only excludes zero
        found |= {"gt": 0.0}
        del found["ge"]
    elif found.get("ge", math.inf) <= found.get("gt", -math.inf):
        del found["ge"]
    return {name: found[name] for name in _LIMITS if name in found}


_OF_NUMBERS = (
    "float_type", "int_type", "finite_number", "greater_than", "greater_than_equal", "less_than", "less_than_equal",
)  # fmt: skip
_PLAINLY = {
    "bool_type": "True or False",
    "string_type": "text",
    "too_long": "a list of at most {max_length} entries",
    "too_short": "a list of at least {min_length} entries",
    "tuple_type": "a list",
}


def what_is_allowed(fault: ErrorDetails, field: FieldInfo | None, *, in_inputs: bool) -> str:
    """Allowed values of a key or an argument that pydantic refused, as :mod:`continuum.inputs.arguments` says."""
    kind, annotation = fault["type"], field.annotation if field else None
    if kind == "literal_error":
        choices = ", ".join(f'"{choice}"' for choice in get_args(annotation))
        return f"one of {choices}" if len(get_args(annotation)) > 1 else choices
    fixed = next((get_args(part) for part in parts(annotation) if get_origin(part) is tuple), (...,))
    if kind in ("missing", "too_long", "tuple_type") and Ellipsis not in fixed:
        return f"a list of {len(fixed)} entries"
    if kind not in _OF_NUMBERS:
        said = fault["msg"].removeprefix("Input should be ").removeprefix("a valid ")
        return _PLAINLY.get(kind, "").format(**fault.get("ctx", {})) or said
    limits = limits_of(field, in_inputs=in_inputs) if field else {}
    if kind == "int_type" or any(part is int for part in parts(annotation)):
        return f"a whole number from {limits.get('ge', 0):g} " + (f"to {limits['le']:.15g}" if "le" in limits else "on")
    return f"a finite number {' and '.join(f'{_LIMITS[name]} {limit:g}' for name, limit in limits.items())}".rstrip()


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


class _OneInPlace(BeforeValidator):
    """A list in whose place one of its entries may be given."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        found = handler(schema)
        return {"anyOf": [found.get("items") or found["prefixItems"][0], found]}


ForBoth = _OneInPlace(lambda value: tuple(value) if isinstance(value, tuple | list) else (value, value))
"""Marks a list of two, along x and y, in place of which one number serves for both directions."""
OneOrSeveral = _OneInPlace(lambda value: tuple(value) if isinstance(value, tuple | list) else (value,))
"""Marks a list in place of which one value may be given."""
InputFile = Annotated[Path, BeforeValidator(_existing)]
"""A file that must exist, relative to the input file; the identity contains its content."""
SMALLEST, LARGEST = 1e-30, 1e30
"""Bounds of positive numbers in reduced units, whose powers in laws and spectra neither overflow nor vanish."""
Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
Points = Annotated[int, Field(ge=1, le=LARGEST_N)]
"""Number of points or atoms along a side."""
Seed = Annotated[int, Field(ge=0, lt=2**63)]
"""Seed of random numbers."""


def _or_infinite(value: Any, finite: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
    in_python = info.context is None and isinstance(value, float) and value == math.inf
    return math.inf if value is None or in_python else finite(value)


OrInfinite = Annotated[float, Field(ge=SMALLEST, le=LARGEST), WrapValidator(_or_infinite)]
"""A positive number; infinite in Python, and not given in an input, where there is no bound."""
Fraction = Annotated[float, Field(gt=0, lt=1)]
"""A number between 0 and 1."""
