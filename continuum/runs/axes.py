"""The description of a sweep: an input file with axes over any of its keys, and the systems that it amounts to.

A sweep is the input of a run with a table ``[sweep]``.  Every key of ``[sweep.axes]`` is an axis; the keys of one table
``[[sweep.zipped]]`` change together.  All combinations that pass every condition of ``sweep.keep`` are the systems.
"""

from __future__ import annotations

import ast
import itertools
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from continuum.files.inputs import parsed
from continuum.files.tables import Document, Table, check, identity
from continuum.files.toml import ConfigError, Fault, Source, find, text_of
from continuum.runs.config import RunConfig
from continuum.runs.ranges import MOST, listed

__all__ = ["MOST", "Axis", "Sweep", "SweepTable", "SystemPlan"]

_Values = dict[str, Any]


@dataclass(frozen=True)
class Axis:
    """Keys of the input that change together, and the values that they take."""

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    """One for each place on the axis, as many as there are keys."""


class SweepTable(Table):
    """[sweep]: what changes from system to system."""

    axes: _Values = Field(default_factory=dict)
    """dotted keys of this input, each with a list of values or a range: {from, to, step | factor | count}"""
    zipped: tuple[_Values, ...] = ()
    """tables of keys that change together, lists of one length each"""
    keep: tuple[str, ...] = ()
    """conditions on keys of this input, such as "lambda_s * 8 <= lambda_L"; only systems that meet all are run"""
    reduced: _Values = Field(default_factory=dict)
    """values of keys instead of those above, for a sweep of minutes; a list or a range for a key on an axis"""

    @property
    def all_axes(self) -> tuple[Axis, ...]:
        """The axes in their order, the zipped ones last."""
        single = [Axis((name,), tuple((v,) for v in listed(given))) for name, given in _flat(self.axes)]
        columns = [dict(_flat(table)) for table in self.zipped]
        together = [Axis(tuple(t), tuple(zip(*map(listed, t.values()), strict=True))) for t in columns]
        return (*single, *together)

    @check
    def _sound(self) -> Iterator[Fault]:
        # Each asks what only holds if the one before found nothing.
        yield from next(filter(None, (list(find()) for find in (self._lists, self._together, self._conditions))), ())

    def _lists(self) -> Iterator[Fault]:
        places = [(("axes",), self.axes), *((("zipped", i), table) for i, table in enumerate(self.zipped))]
        for place, table in places:
            for name, given in _flat(table):
                try:
                    values = listed(given)
                except ValueError as error:
                    yield Fault((*place, name), f"a list of values, or a range {{from, to, step}}: {error}")
                else:
                    if not values:
                        yield Fault((*place, name), "at least one value")
                    if len({repr(value) for value in values}) < len(values) and place == ("axes",):
                        yield Fault((*place, name), "different values", "the same one twice")

    def _together(self) -> Iterator[Fault]:
        for i, table in enumerate(self.zipped):
            lengths = {name: len(listed(given)) for name, given in _flat(table)}
            if len(set(lengths.values())) > 1:
                counts = ", ".join(f"{name} has {count}" for name, count in lengths.items())
                yield Fault(("zipped", i), "lists of one length", f"these change together, but {counts}")
                return
        names = [name for table in (self.axes, *self.zipped) for name, _ in _flat(table)]
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield Fault((), f"each key on one axis only: {name} is on several")
        for one, other in itertools.combinations(sorted(set(names)), 2):
            if _overlap(one, other):
                yield Fault((), f"axes that are apart: {one} holds {other}")
        count = math.prod(len(axis.values) for axis in self.all_axes)
        if count > MOST:
            yield Fault((), f"at most {MOST} systems, not {count}")

    def _conditions(self) -> Iterator[Fault]:
        for i, text in enumerate(self.keep):
            try:
                _condition(text)
            except ValueError as error:
                yield Fault(("keep", i), f'a condition such as "lambda_s * 8 <= lambda_L": {error}')


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and what is given for them, whether the keys are quoted or not."""
    for name, value in table.items():
        if isinstance(value, Mapping) and "from" not in value:
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _changed(axis: Axis, changes: Mapping[str, Any]) -> Axis:
    """An axis with other values; of keys that change together, all must be given, or one for a single place."""
    if not changes.keys() & set(axis.keys):
        return axis
    columns = []
    for i, key in enumerate(axis.keys):
        given = changes.get(key, tuple(values[i] for values in axis.values))
        several = isinstance(given, (tuple, list)) or (isinstance(given, Mapping) and "from" in given)
        columns.append(listed(given) if several else (given,))
    return Axis(axis.keys, tuple(zip(*columns, strict=True)))


def _overlap(one: str, other: str) -> bool:
    """Whether one of two keys is a table that holds the other."""
    return one != other and (f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}."))


# --- conditions ----------------------------------------------------------------------------------------------

_BINARY: Mapping[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip


def _condition(text: str) -> ast.expr:
    """A condition of numbers, keys, + - * / **, comparisons, and, or, not."""
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError):
        msg = "it cannot be read"
        raise ValueError(msg) from None
    allowed = (ast.Compare, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Name, ast.Attribute, ast.Constant, ast.Load,
               ast.And, ast.Or, ast.Not, ast.USub, *_BINARY)  # fmt: skip
    for node in ast.walk(tree):
        if not isinstance(node, allowed):
            msg = f"no {type(node).__name__}"
            raise ValueError(msg)
    return tree


def _value(node: ast.expr, known: Callable[[str], Any]) -> Any:
    match node:
        case ast.Constant():
            return node.value
        case ast.Name() | ast.Attribute():
            return known(ast.unparse(node))
        case ast.BinOp():
            return _BINARY[type(node.op)](_value(node.left, known), _value(node.right, known))
        case ast.UnaryOp():
            value = _value(node.operand, known)
            return not value if isinstance(node.op, ast.Not) else -value
        case ast.BoolOp():
            every = all if isinstance(node.op, ast.And) else any
            return every(_value(part, known) for part in node.values)
        case ast.Compare():
            sides = [_value(part, known) for part in (node.left, *node.comparators)]
            pairs = zip(node.ops, itertools.pairwise(sides), strict=True)
            return all(_BINARY[type(op)](*pair) for op, pair in pairs)
    raise ValueError(ast.unparse(node))


def _known(data: Mapping[str, Any]) -> Callable[[str], Any]:
    """Values of an input by dotted key, or by its last part where that is the only one of that name."""
    flat: dict[str, Any] = {}

    def visit(table: Mapping[str, Any], prefix: str) -> None:
        for name, value in table.items():
            if isinstance(value, Mapping):
                visit(value, f"{prefix}{name}.")
            else:
                flat[prefix + name] = value

    visit({name: value for name, value in data.items() if name != "sweep"}, "")

    def value(name: str) -> Any:
        found = [key for key in flat if key == name or key.endswith(f".{name}")]
        if name in flat or len(found) == 1:
            return flat[name if name in flat else found[0]]
        msg = f"{name} is {'the name of several keys' if found else 'no key'} of this input"
        raise ValueError(msg)

    return value


# --- systems -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SystemPlan:
    """One system of a sweep."""

    source: Source = field(repr=False)
    """The input that all systems share."""
    settings: tuple[tuple[str, Any], ...]
    """Key and value on each axis."""
    key: str
    """Identity: hash of physics, solver settings and schema."""

    @property
    def label(self) -> str:
        """The system in words."""
        named = (
            f"{name.rpartition('.')[2]} {value if isinstance(value, str) else text_of(value)}"
            for name, value in self.settings
        )
        return ", ".join(named) or "the one system"

    @property
    def config(self) -> RunConfig:
        """The input of its run."""
        return parsed(self.source.changed(dict(self.settings)), RunConfig)


class _Sweeps(Document):
    """Of an input, the table that makes it a sweep."""

    result_schema: ClassVar[str] = "stickiness/sweep"
    result_version: ClassVar[int] = 1
    sweep: SweepTable


@dataclass(frozen=True)
class Sweep:
    """A sweep, as its file says."""

    name: str
    source: Source = field(repr=False)
    """The whole file."""
    base: Source = field(repr=False)
    """Without the table [sweep]: the input of a run, but for what the axes give."""
    axes: tuple[Axis, ...]
    keep: tuple[str, ...]

    @classmethod
    def read(cls, path: str | Path, settings: Mapping[str, Any] | None = None, *, reduced: bool = False) -> Sweep:
        """Read a sweep; its systems are not looked at yet.

        Parameters
        ----------
        settings : values of keys instead of those of the file; of a key on an axis, a value, a list or a range.
        reduced : whether those of ``[sweep.reduced]`` hold, before the settings.

        Raises
        ------
        ConfigError
            With all faults of the table [sweep].
        """
        source = Source.read(find(path))
        data = dict(source.data)
        table = data.pop("sweep", None)
        if not isinstance(table, Mapping):
            cause = "the input of a single run, which is for `continuum run`"
            raise ConfigError(source, [Fault(("sweep",), "a table [sweep] with the axes", cause)])
        found = parsed(replace(source, data={"sweep": table}), _Sweeps).sweep
        changes = {**(dict(_flat(found.reduced)) if reduced else {}), **(settings or {})}
        try:
            axes = tuple(_changed(axis, changes) for axis in found.all_axes)
        except ValueError as error:
            fault = Fault(("sweep",), f"lists or ranges on its axes, of one length where keys change together: {error}")
            raise ConfigError(source, [fault]) from None
        on_axes = {key for axis in axes for key in axis.keys}
        plain = {key: value for key, value in changes.items() if key not in on_axes}
        for key, axis in itertools.product(plain, on_axes):
            if _overlap(key, axis):  # it would be set, and then replaced
                raise ConfigError(source, [Fault(("sweep",), f"values for the axis {axis} as it is, not for {key}")])
        base = replace(source, data=data)
        name = f"{source.path.stem}-reduced" if reduced else source.path.stem
        return cls(name, source, base.changed(plain) if plain else base, axes, found.keep)

    def systems(self) -> Iterator[tuple[SystemPlan, RunConfig]]:
        """Its systems, each once, with the input of its run; the last axis changing fastest.

        Raises
        ------
        ConfigError
            If one of them is no input of a run, or there is none.
        """
        conditions, seen = [_condition(text) for text in self.keep], set[str]()
        for places in itertools.product(*(axis.values for axis in self.axes)):
            each = zip(self.axes, places, strict=True)
            settings = {key: value for axis, values in each for key, value in zip(axis.keys, values, strict=True)}
            source = self.base.changed(settings)
            if not self._kept(source, conditions):
                continue
            config = parsed(source, RunConfig)
            key = identity(config)
            if key not in seen:
                seen.add(key)
                yield SystemPlan(self.base, tuple(settings.items()), key), config
        if not seen:
            raise ConfigError(self.source, [Fault(("sweep", "keep"), "conditions that at least one system meets")])

    def _kept(self, source: Source, conditions: Sequence[ast.expr]) -> bool:
        known = _known(source.data)
        for i, condition in enumerate(conditions):
            try:
                if not _value(condition, known):
                    return False
            except (ValueError, TypeError, ArithmeticError) as error:
                fault = Fault(("sweep", "keep", i), f"a condition that holds or not: {error}")
                raise ConfigError(self.source, [fault]) from None
        return True
