"""Checks of what a function is given, in the words in which an input file is refused: name, value, what is allowed.

Numbers are no text and no booleans, and finite; a field is real, has no missing points, and fits its grid.
"""

from __future__ import annotations

import math
import numbers
import operator
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from continuum.errors import InputError

__all__ = ["ArgumentError", "choice", "count", "field", "instance", "number", "pair", "several"]

_Choice = TypeVar("_Choice", bound=str)
_Kind = TypeVar("_Kind")


class ArgumentError(InputError, ValueError):
    """An argument that has no meaning: the message names it, says what it was and what is allowed."""

    def __init__(self, name: str, value: object, allowed: str) -> None:
        super().__init__(f"{name} = {_short(value)}: allowed: {allowed}")


def number(
    name: str,
    value: Any,
    *,
    above: float | None = None,
    least: float | None = None,
    below: float | None = None,
    most: float | None = None,
) -> float:
    """A finite number within bounds: greater than ``above``, at least ``least``, and so on.

    Raises
    ------
    ArgumentError
        If it is something else.
    """
    bounds = (
        (above, "greater than", operator.gt),
        (least, "greater than or equal to", operator.ge),
        (below, "less than", operator.lt),
        (most, "less than or equal to", operator.le),
    )
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    real = isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)
    try:
        sound = real and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        sound = False
    if not (sound and all(bound is None or holds(value, bound) for bound, _, holds in bounds)):
        limits = " and ".join(f"{words} {bound:g}" for bound, words, _ in bounds if bound is not None)
        raise ArgumentError(name, value, f"a finite number {limits}".rstrip())
    return float(value)


def count(name: str, value: Any, least: int = 1, most: int = 2**31 - 1) -> int:
    """A whole number within bounds.

    Raises
    ------
    ArgumentError
        If it is something else.
    """
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool | np.bool_)
    if not (whole and least <= value <= most):
        limits = f"a whole number from {least} to {most}" if most < 2**31 - 1 else f"a whole number from {least} on"
        raise ArgumentError(name, value, limits)
    return int(value)


def choice(name: str, value: Any, choices: Iterable[_Choice]) -> _Choice:
    """One of some names.

    Raises
    ------
    ArgumentError
        If it is none of them.
    """
    known = tuple(choices)
    for each in known:
        if isinstance(value, str) and value == each:
            return each
    raise ArgumentError(name, value, ("one of " if len(known) > 1 else "") + ", ".join(f'"{each}"' for each in known))


def pair(name: str, value: Any) -> tuple[Any, Any]:
    """Two values, along x and y.

    Raises
    ------
    ArgumentError
        If they are not two.
    """
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray) or len(value) != 2:
        raise ArgumentError(name, value, "two values, along x and y")
    return value[0], value[1]


def several(name: str, values: Any) -> tuple[float, ...]:
    """Finite numbers, at least one, from a list, a tuple or a one-dimensional array.

    Raises
    ------
    ArgumentError
        If it is something else, or one of them is no finite number.
    """
    listed = isinstance(values, Iterable) and not isinstance(values, str | bytes | Mapping | Set)
    if not listed or (isinstance(values, np.ndarray) and values.ndim != 1):
        raise ArgumentError(name, values, "a list of finite numbers")
    found = tuple(number(name, value) for value in values)
    if not found:
        raise ArgumentError(name, values, "a list of at least one number")
    return found


def instance(name: str, value: Any, kind: type[_Kind] | tuple[type[_Kind], ...], allowed: str) -> _Kind:
    """An object of a class, or of one of several; ``allowed`` says in words which.

    Raises
    ------
    ArgumentError
        If it is none.
    """
    if not isinstance(value, kind):
        raise ArgumentError(name, value, allowed)
    return value


def field(name: str, value: Any, shape: tuple[int, ...] | None = None) -> NDArray[np.float64]:
    """A map of finite real numbers as float64, a copy only where it is needed; of two directions if no shape is given.

    Raises
    ------
    ArgumentError
        If points are missing (masked, NaN, infinite), if it holds something else than real numbers (complex numbers,
        text, booleans), or if its shape is another.
    """
    if np.ma.is_masked(value):
        missing = int(np.sum(np.ma.getmaskarray(value)))
        raise ArgumentError(name, value, f"a map without missing points; here {missing} are masked: fill them first")
    try:
        array = np.asarray(value)
    except ValueError as error:  # rows of different lengths
        raise ArgumentError(name, value, "a map of numbers, with rows of one length") from error
    if array.dtype.kind not in "fiu":
        kind = {"c": "complex numbers", "b": "booleans", "U": "text", "S": "text"}.get(array.dtype.kind, "objects")
        raise ArgumentError(name, value, f"a map of real numbers, not of {kind}")
    if array.ndim != 2 if shape is None else array.shape != shape:
        what = "a map of two directions" if shape is None else f"the shape of the grid, {shape}"
        raise ArgumentError(name, value, f"{what}; its shape is {array.shape}")
    finite = np.isfinite(array)
    if not finite.all():
        missing = int(array.size - np.count_nonzero(finite))
        raise ArgumentError(name, value, f"finite numbers; {missing} of {array.size} are NaN or infinite")
    return np.asarray(array, dtype=np.float64)


def _short(value: object) -> str:
    """A value in a message: an array by its shape and kind."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}, shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
