"""Checks of the arguments of functions; messages have name, value and what is allowed, as those of input files.

Numbers are finite, and neither text nor booleans; a field is real, has no missing points, and fits its grid.  Anything
else raises :class:`ArgumentError`.
"""

import difflib
import inspect
import math
import numbers
import operator
import os
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.errors import InputError

_Choice = TypeVar("_Choice", bound=str)
_Kind = TypeVar("_Kind")
_Called = TypeVar("_Called", bound=Callable[..., Any])
_Class = TypeVar("_Class", bound=type)
_KINDS = {"c": "complex numbers", "b": "booleans", "U": "text", "S": "text"}


class ArgumentError(InputError, ValueError):
    """An argument that is not allowed: the message has its name, its value and what is allowed."""

    def __init__(self, name: str, value: object, allowed: str) -> None:
        self.name, self.allowed = name, allowed
        super().__init__(f"{name} = {_short(value)}: allowed: {allowed}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Only the message is sent to another process, as the value may be a whole map."""
        return Exception.__new__, (type(self), str(self)), vars(self)


def hint(unknown: str, names: Iterable[str]) -> str:
    """The name that an unknown one probably means, as the end of a message; empty if there is none."""
    meant = difflib.get_close_matches(unknown, list(names), 1)
    return f"; did you mean {meant[0]}?" if meant else ""


def hinted(called: _Called) -> _Called:
    """A function whose TypeError for an argument of an unknown name says which one is probably meant."""
    known = inspect.signature(called).parameters

    @wraps(called)
    def with_hint(*values: Any, **named: Any) -> Any:
        for unknown in named.keys() - known.keys():
            said = f"{called.__qualname__}() got an unexpected keyword argument {unknown!r}{hint(unknown, known)}"
            raise TypeError(said.replace(".__init__", ""))
        return called(*values, **named)

    return cast("_Called", with_hint)


def hinted_class(described: _Class) -> _Class:
    """A class of which that holds."""
    setattr(described, "__init__", hinted(getattr(described, "__init__")))  # noqa: B009, B010
    return described


def number(
    name: str,
    value: Any,
    *,
    above: float | None = None,
    least: float | None = None,
    below: float | None = None,
    most: float | None = None,
) -> float:
    """A finite number within bounds: greater than ``above``, at least ``least``, and so on."""
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


def count(name: str, value: Any, least: int = 1, most: int = 2**31 - 1, *, why: str = "") -> int:
    """A whole number within bounds; the message adds ``why`` they are so."""
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool | np.bool_)
    if not (whole and least <= value <= most):
        limits = f"a whole number from {least} to {most}" if most < 2**31 - 1 else f"a whole number from {least} on"
        raise ArgumentError(name, value, f"{limits}: {why}" if why else limits)
    return int(value)


def choice(name: str, value: Any, choices: Iterable[_Choice]) -> _Choice:
    """Check that a value is one of some names."""
    known = tuple(choices)
    for each in known:
        if isinstance(value, str) and value == each:
            return each
    raise ArgumentError(name, value, ("one of " if len(known) > 1 else "") + ", ".join(f'"{each}"' for each in known))


def pair(name: str, value: Any) -> tuple[Any, Any]:
    """Two values, along x and y."""
    values = value.tolist() if isinstance(value, np.ndarray) else value
    if isinstance(values, str | bytes) or not isinstance(values, Sequence) or len(values) != 2:
        raise ArgumentError(name, value, "two values, along x and y")
    return values[0], values[1]


def flag(name: str, value: Any) -> bool:
    """A boolean: a text such as "no" would count as true."""
    if not isinstance(value, bool | np.bool_):
        raise ArgumentError(name, value, "True or False")
    return bool(value)


def instance(name: str, value: Any, kind: type[_Kind], allowed: str = "") -> _Kind:
    """An object of a class, which ``allowed`` describes in words."""
    if not isinstance(value, kind):
        raise ArgumentError(name, value, allowed or f"a {kind.__name__}")
    return value


def function(name: str, value: Any) -> None:
    """A function, or None."""
    if value is not None and not callable(value):
        raise ArgumentError(name, value, "a function, or None")


def texts(name: str, value: Any, example: str) -> tuple[str, ...]:
    """One text or several; none for None.

    A number without its unit is refused; the message has the ``example``.
    """
    several = () if value is None else (value,) if isinstance(value, str) else value
    if not (isinstance(several, Sequence) and all(isinstance(each, str) for each in several)):
        raise ArgumentError(name, value, f"a text such as {example}, or several in a list")
    return tuple(several)


def file_name(name: str, value: Any) -> Path:
    """The name of a file or folder, which need not exist, but must be a possible name."""
    if not isinstance(value, str | os.PathLike):
        raise ArgumentError(name, value, "the name of a file")
    try:
        path = Path(value)
        path.stat()
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        pass
    except (OSError, ValueError, TypeError) as error:  # far too long; with a NUL; of bytes
        why = getattr(error, "strerror", None) or error
        raise ArgumentError(name, os.fspath(value), f"the name of a file ({why})") from None
    return path


def array(name: str, value: Any, shape: tuple[int, ...] | None = None, kinds: str = "fiu") -> NDArray[Any]:
    """An array of numbers, possibly missing ones, of a given shape; ``kinds`` are the kinds of NumPy types allowed.

    By default complex numbers, text and booleans are refused.
    """
    try:
        found: NDArray[Any] = np.asarray(value)
    except ValueError as error:  # rows of different lengths
        raise ArgumentError(name, value, "a map of numbers, with rows of one length") from error
    if found.dtype.kind not in kinds:
        wanted = "complex" if kinds == "c" else "real"
        was = _KINDS.get(found.dtype.kind, "objects" if found.dtype.kind not in "fiu" else "real numbers")
        raise ArgumentError(name, value, f"a map of {wanted} numbers, not of {was}")
    if shape is not None and found.shape != shape:
        of = "the half spectrum of the grid" if kinds == "c" else "the grid"
        raise ArgumentError(name, value, f"the shape of {of}, {shape}; its shape is {found.shape}")
    return found


def several(name: str, value: Any, *, longest: int = 10_000, **bounds: float | None) -> tuple[float, ...]:
    """Finite numbers in a list, 1 to ``longest``, each within the bounds of :func:`number`."""
    values = value.tolist() if isinstance(value, np.ndarray) else value
    if isinstance(values, str | bytes) or not isinstance(values, Sequence) or not 1 <= len(values) <= longest:
        raise ArgumentError(name, value, f"a list of 1 to {longest} finite numbers")
    return tuple(number(f"{name}[{i}]", each, **bounds) for i, each in enumerate(values))


def field_of(name: str, value: Any, shape: tuple[int, ...] | None = None) -> NDArray[np.float64]:
    """A map of finite real numbers as float64, copied only if needed; two-dimensional if no shape is given.

    Missing points (masked, NaN, infinite), complex numbers, text and booleans are refused.
    """
    if np.ma.is_masked(value):
        missing = int(np.sum(np.ma.getmaskarray(value)))
        raise ArgumentError(name, value, f"a map without missing points; here {missing} are masked: fill them first")
    found = array(name, value, shape)
    if shape is None and found.ndim != 2:
        raise ArgumentError(name, value, f"a two-dimensional map; its shape is {found.shape}")
    finite = np.isfinite(found)
    if not finite.all():
        missing = int(found.size - np.count_nonzero(finite))
        raise ArgumentError(name, value, f"finite numbers; {missing} of {found.size} are NaN or infinite")
    return np.asarray(found, dtype=np.float64)


def _short(value: object) -> str:
    """A value in a message: an array by its shape and kind."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}, shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
