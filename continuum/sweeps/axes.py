"""The description of a sweep: an input file with axes over any of its keys, and the systems that it amounts to.

A sweep is the input of a run with a table ``[sweep]``.  Every key of ``[sweep.axes]`` is an axis; the keys of one table
``[[sweep.zipped]]`` change together.  All combinations that pass every condition of ``sweep.keep`` are the systems.
"""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from pydantic import Field

from continuum.files.inputs import InputFile, parsed, source_of
from continuum.files.tables import Document, identity
from continuum.files.toml import ConfigError, Source, document, text_of
from continuum.runs.config import RunConfig
from continuum.runs.ranges import MOST, expand_range
from continuum.sweeps.conditions import condition, dotted, holds
from continuum.tables import Fault, Table, constraint

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
        single = [Axis((name,), tuple((v,) for v in expand_range(given))) for name, given in _flat(self.axes)]
        columns = [dict(_flat(table)) for table in self.zipped]
        together = [Axis(tuple(t), tuple(zip(*map(expand_range, t.values()), strict=True))) for t in columns]
        return (*single, *together)

    @constraint
    def _sound(self) -> Iterator[Fault]:
        # Each asks what only holds if the one before found nothing.
        yield from next(filter(None, (list(find()) for find in (self._lists, self._together, self._conditions))), ())

    def _lists(self) -> Iterator[Fault]:
        places = [(("axes",), self.axes), *((("zipped", i), table) for i, table in enumerate(self.zipped))]
        for place, table in places:
            for name, given in _flat(table):
                try:
                    values = expand_range(given)
                except ValueError as error:
                    yield Fault((*place, name), f"a list of values, or a range {{from, to, step}}: {error}")
                else:
                    if not values:
                        yield Fault((*place, name), "at least one value")
                    if place == ("axes",) and _repeated(values):
                        yield Fault((*place, name), "different values", "the same one twice")

    def _together(self) -> Iterator[Fault]:
        for i, table in enumerate(self.zipped):
            lengths = {name: len(expand_range(given)) for name, given in _flat(table)}
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
        yield from _too_many(self.all_axes)

    def _conditions(self) -> Iterator[Fault]:
        for i, text in enumerate(self.keep):
            try:
                condition(text)
            except ValueError as error:
                yield Fault(("keep", i), f'a condition such as "lambda_s * 8 <= lambda_L": {error}')


_flat = partial(dotted, ranges=True)


def _changed(axis: Axis, changes: Mapping[str, Any]) -> Axis:
    """An axis with other values; of keys that change together, all must be given, or one for a single place."""
    if not changes.keys() & set(axis.keys):
        return axis
    columns = []
    for i, key in enumerate(axis.keys):
        given = changes.get(key, tuple(values[i] for values in axis.values))
        several = isinstance(given, (tuple, list)) or (isinstance(given, Mapping) and "from" in given)
        columns.append(expand_range(given) if several else (given,))
    return Axis(axis.keys, tuple(zip(*columns, strict=True)))


def _too_many(axes: Iterable[Axis]) -> Iterator[Fault]:
    count = math.prod(len(axis.values) for axis in axes)
    if count > MOST:
        yield Fault((), f"at most {MOST} systems, not {count}")


def _repeated(values: Sequence[Any]) -> bool:
    """Whether two values are equal, as 8 and 8.0 are."""
    return len({_hashable(value) for value in values}) < len(values)


def _hashable(value: Any) -> Hashable:
    if isinstance(value, Mapping):
        return frozenset((name, _hashable(item)) for name, item in value.items())
    if isinstance(value, (tuple, list)):
        return tuple(map(_hashable, value))
    return value if isinstance(value, Hashable) else repr(value)


def _overlap(one: str, other: str) -> bool:
    """Whether one of two keys is a table that holds the other."""
    return one != other and (f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}."))


@dataclass(frozen=True)
class SystemPlan:
    """One system of a sweep."""

    source: Source = field(repr=False)
    """The input that all systems share."""
    settings: Mapping[str, Any]
    """Key and value on each axis."""
    key: str
    """Identity: hash of physics, solver settings and schema."""

    @property
    def config(self) -> RunConfig:
        return parsed(self.source.changed(self.settings), RunConfig)


def label_of(settings: Mapping[str, Any]) -> str:
    """Values of the axes of a system, in words."""
    named = (
        f"{name.rpartition('.')[2]} {value if isinstance(value, str) else text_of(value)}"
        for name, value in settings.items()
    )
    return ", ".join(named) or "the one system"


class _Sweeps(Document):
    """The [sweep] table of an input."""

    sweep: SweepTable


@dataclass(frozen=True)
class Sweep:
    """A sweep, as its file says."""

    name: str
    source: Source = field(repr=False)
    """The input file."""
    base: Source = field(repr=False)
    """Without the table [sweep]: the input of a run, but for what the axes give."""
    axes: tuple[Axis, ...]
    keep: tuple[str, ...]
    changed: bool = False
    """Whether values are not those of the file."""

    @property
    def text(self) -> str:
        """The input of this sweep: the file, or where values were given elsewhere one that has them."""
        if not self.changed:
            return self.source.text
        zipped = [dict(zip(axis.keys, zip(*axis.values, strict=True), strict=True)) for axis in self.axes]
        said = (
            f"# {self.source.path.name}, with the values that were given beside it, of [sweep.reduced] or by --set.\n"
        )
        axes = {key: values for each in zipped if len(each) == 1 for key, values in each.items()}
        together = [each for each in zipped if len(each) > 1]
        sweep = {"keep": self.keep, "axes": axes, "zipped": together}
        return said + document({**self.base.data, "sweep": {name: value for name, value in sweep.items() if value}})

    @classmethod
    def read(
        cls,
        file: InputFile,
        settings: Mapping[str, Any] | None = None,
        *,
        reduced: bool = False,
        name: str | None = None,
    ) -> Sweep:
        """Read a sweep; its systems are not looked at yet.

        Parameters
        ----------
        file : the input, or its tables.
        name : of the sweep; that of the file if None, and "sweep" of tables.
        settings : values of keys instead of those of the file; of a key on an axis, a value, a list or a range.
        reduced : whether those of ``[sweep.reduced]`` hold, before the settings.

        Raises
        ------
        ConfigError
            With all faults of the table [sweep].
        """
        source = source_of(file, name or "sweep")
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
        faults = [
            *_too_many(axes),
            *(Fault((), f"at least one value of {axis.keys[0]}") for axis in axes if not axis.values),
            *(Fault((), f"different values of {axis.keys[0]}") for axis in axes if _repeated(axis.values)),
        ]
        if faults:
            raise ConfigError(source, [replace(fault, key=("sweep",)) for fault in faults])
        on_axes = {key for axis in axes for key in axis.keys}
        plain = {key: value for key, value in changes.items() if key not in on_axes}
        for key, axis in itertools.product(plain, on_axes):
            if _overlap(key, axis):  # it would be set, and then replaced
                raise ConfigError(source, [Fault(("sweep",), f"values for the axis {axis} as it is, not for {key}")])
        base = replace(source, data=data)
        own = name or source.path.stem
        return cls(
            f"{own}-reduced" if reduced else own,
            source,
            base.changed(plain) if plain else base,
            axes,
            found.keep,
            bool(changes),
        )

    def systems(self) -> Iterator[tuple[SystemPlan, RunConfig]]:
        """Its systems, each once, with the input of its run; the last axis changing fastest.

        Raises ConfigError if one of them is no input of a run, or there is none.
        """
        conditions, seen = [condition(text) for text in self.keep], dict[str, SystemPlan]()
        for places in itertools.product(*(axis.values for axis in self.axes)):
            each = zip(self.axes, places, strict=True)
            settings = {key: value for axis, values in each for key, value in zip(axis.keys, values, strict=True)}
            source = self.base.changed(settings)
            if not self._kept(source, conditions):
                continue
            config = parsed(source, RunConfig)
            plan = SystemPlan(self.base, settings, identity(config))
            if plan.key in seen:
                cause = "values that are equal, files of the same content, or a key such as solver.threads on an axis"
                same = f"{label_of(seen[plan.key].settings)} and {label_of(settings)} are one and the same"
                raise ConfigError(self.source, [Fault(("sweep",), f"systems that differ: {same}", cause)])
            seen[plan.key] = plan
            yield plan, config
        if not seen:
            raise ConfigError(self.source, [Fault(("sweep", "keep"), "conditions that at least one system meets")])

    def _kept(self, source: Source, conditions: Sequence[ast.expr]) -> bool:
        for i, each in enumerate(conditions):
            try:
                if not holds(each, source.data):
                    return False
            except ValueError as error:
                fault = Fault(("sweep", "keep", i), f"a condition that holds or not: {error}")
                raise ConfigError(self.source, [fault]) from None
        return True
