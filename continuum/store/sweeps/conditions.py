"""Conditions of a sweep: arithmetic and comparisons of keys of the input.

A condition is parsed by Python but not executed: only the operations listed here are allowed, and no result can exceed
a floating-point number, so that no condition takes long or much memory.
"""

import ast
import itertools
import operator
from collections.abc import Callable, Iterator, Mapping
from typing import Any

_LONGEST = 1000  # characters; one of ours has 70

_ARITHMETIC: Mapping[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}  # fmt: skip
_COMPARISONS: Mapping[type[ast.AST], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}  # fmt: skip
_ALLOWED = (
    ast.Compare, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Name, ast.Attribute, ast.Constant, ast.Load,
    ast.And, ast.Or, ast.Not, ast.USub, *_ARITHMETIC, *_COMPARISONS,
)  # fmt: skip


def condition(text: str) -> ast.expr:
    """A condition of numbers, keys, + - * / **, comparisons, and, or, not.

    Raises ValueError for anything else.
    """
    if len(text) > _LONGEST:
        raise ValueError(f"it has {len(text)} characters, more than {_LONGEST}")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError("it cannot be read") from None
    nodes = list(ast.walk(tree))
    for node in nodes:
        if not isinstance(node, _ALLOWED):
            raise ValueError(f"no {type(node).__name__}")
    if not any(isinstance(node, ast.Name) for node in nodes):
        raise ValueError("it names no key, so that it keeps all systems or none")
    return tree


def holds(tree: ast.expr, known: Callable[[str], Any]) -> bool:
    """Whether a condition holds for the :func:`values_of` an input.

    Raises ValueError if a key is unknown, or it cannot be evaluated, or compares nothing.
    """
    try:
        return _truth(tree, known)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    except (TypeError, ArithmeticError) as error:
        raise ValueError(str(error)) from None


def _truth(node: ast.expr, known: Callable[[str], Any]) -> bool:
    """The value of a comparison, or of a key that is true or false; a number is neither."""
    value = _value(node, known)
    if not isinstance(value, bool):
        raise ValueError(f"{ast.unparse(node)} is {value!r}, not a comparison")
    return value


def _value(node: ast.expr, known: Callable[[str], Any]) -> Any:
    match node:
        case ast.Constant():
            return node.value
        case ast.Name():
            return known(node.id)
        case ast.Attribute():
            return known(ast.unparse(node))
        case ast.BinOp():
            return _calculated(node.op, _value(node.left, known), _value(node.right, known))
        case ast.UnaryOp():
            return not _truth(node.operand, known) if isinstance(node.op, ast.Not) else -_value(node.operand, known)
        case ast.BoolOp():
            every = all if isinstance(node.op, ast.And) else any
            return every(_truth(part, known) for part in node.values)
        case ast.Compare():
            sides = [_value(part, known) for part in (node.left, *node.comparators)]
            pairs = zip(node.ops, itertools.pairwise(sides), strict=True)
            return all(_COMPARISONS[type(op)](*pair) for op, pair in pairs)
    raise ValueError(ast.unparse(node))


def _calculated(op: ast.operator, left: Any, right: Any) -> Any:
    for value in (left, right):
        if not isinstance(value, int | float):  # text times a number is a longer text
            raise ValueError(f"numbers only can be added and multiplied, not {str(value)[:60]!r}")
    try:
        return _ARITHMETIC[type(op)](float(left), float(right))  # a power of whole numbers could be endless
    except OverflowError:
        raise ValueError("a number is larger than 1e308") from None


def is_range(table: Mapping[str, Any]) -> bool:
    """Whether a table is a range or a search, which is one value of a key."""
    return "from" in table or "bisect" in table


def dotted(table: Mapping[str, Any], prefix: str = "", *, ranges: bool = False) -> Iterator[tuple[str, Any]]:
    """Dotted keys with their values, whether the keys are quoted or not; ``ranges`` and searches are values."""
    for name, value in table.items():
        if isinstance(value, Mapping) and not (ranges and is_range(value)):
            yield from dotted(value, f"{prefix}{name}.", ranges=ranges)
        else:
            yield prefix + name, value


def values_of(data: Mapping[str, Any]) -> Callable[[str], Any]:
    """Values of an input by dotted key, or by its last part if that is unique; of any other name a ValueError."""
    known = dict(dotted({name: value for name, value in data.items() if name != "sweep"}))

    def value(name: str) -> Any:
        if name in known:
            return known[name]
        found = [key for key in known if key.endswith(f".{name}")]
        if len(found) == 1:
            return known[found[0]]
        raise ValueError(f"{name} is {'the name of several keys' if found else 'not a key'} of this input")

    return value
