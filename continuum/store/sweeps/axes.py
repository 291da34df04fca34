"""The description of a sweep: an input file with axes over any of its keys, and its systems.

A sweep is the input of a run with a table ``[sweep]``.  Every key of ``[sweep.axes]`` is an axis; the keys of one table
``[[sweep.zipped]]`` change together.  All combinations that pass every condition of ``sweep.keep`` are the systems.
One key of ``[sweep.axes]`` may be searched for instead: then each combination of the others is a search.

Of systems that differ in seeds alone the first is checked, and the others are identified by its text: nothing else in
an input depends on a seed (``Table.alone``), so that a million of them need not be checked each.
"""

import ast
import itertools
import json
import math
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Annotated, Any, Self

from pydantic import Field, TypeAdapter, ValidationError

from continuum.inputs.reading import InputFile, parsed, source_of
from continuum.inputs.tables import Fault, Key, Table, constraint
from continuum.inputs.toml import ConfigError, Document, Source, document, text_of
from continuum.store.identity import identified, identity, identity_text
from continuum.store.runs.config import MOST, RunConfig, expand_range
from continuum.store.sweeps.bisection import Bisection, bisection_faults, is_bisection
from continuum.store.sweeps.columns import OF_PYTHON, ColumnFunction, OwnColumn, name_faults, own_columns
from continuum.store.sweeps.conditions import condition, dotted, holds, is_range, values_of

_MARK = "\ue000{}\ue000"
_Values = dict[str, Any]


@dataclass(frozen=True)
class Alike:
    """The systems that differ from one in some keys alone."""

    config: RunConfig
    """The input of the first of them."""
    keys: tuple[str, ...]
    """The keys in which they differ, in the order of the text."""
    parts: tuple[str, ...]
    """The text that is identified, cut where the values of these keys stand; empty where they cannot be told apart."""
    checks: tuple[TypeAdapter[Any], ...]

    @classmethod
    def of(cls, config: RunConfig, keys: Iterable[str]) -> Self:
        """Those that differ from an input in these keys."""
        keys = tuple(keys)
        own = [_field(config, key) for key in keys]
        unknown = cls(config, (), (), ())
        if None in own:
            return unknown
        marks = {key: _MARK.format(key) for key in keys}
        try:
            text = identity_text(config, marks)
        except KeyError:
            return unknown
        found = re.findall("\ue000(.*?)\ue000", text)
        parts = tuple(re.split('"\ue000.*?\ue000"', text))
        checks = tuple(TypeAdapter(_field(config, key)) for key in found)
        alike = cls(config, tuple(found), parts, checks)
        own_values = {key: _table(config, key)[0].value(key.rpartition(".")[2]) for key in keys}
        # Tried on the one system whose identity is known; where it differs, each is checked.
        same = sorted(found) == sorted(keys) and alike.key(own_values) == identity(config)
        return alike if same else unknown

    def key(self, settings: Mapping[str, Any]) -> str | None:
        """The identity of one of them; None if its values have to be checked with the whole input."""
        values = [settings[key] for key in self.keys]
        # Of a number that is no plain int, as True or 3.0, the text in an identity is decided by the input's types.
        if not self.parts or any(type(value) is not int for value in values):
            return None
        try:
            for check, value in zip(self.checks, values, strict=True):
                check.validate_python(value)
        except ValidationError:
            return None
        text = self.parts[0] + "".join(f"{v}{part}" for v, part in zip(values, self.parts[1:], strict=True))
        return identified(text)


def _table(config: Table, key: str) -> tuple[Any, str]:
    """The table of a dotted key, if there is one, and its name in it."""
    *outer, name = key.split(".")
    try:
        return reduce(lambda table, part: table.value(part), outer, config), name
    except AttributeError:
        return None, name


def _field(config: Table, key: str) -> Any:
    """The type of a key on whose value nothing else depends; None if it is none."""
    table, name = _table(config, key)
    if name not in getattr(table, "alone", ()):
        return None
    field = type(table).model_fields[name]
    return Annotated[(field.annotation, *field.metadata)]


@dataclass(frozen=True)
class Axis:
    """Keys of the input that change together, and their values."""

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    """Values at each place on the axis, one for each key."""


class SweepTable(Table):
    """[sweep]: the keys that change from system to system."""

    axes: _Values = Field(default_factory=dict)
    """dotted keys of this input, each with a list of values or a range: {from, to, step | factor | count}; one may be
    searched for: {bisect, from, to, tolerance}"""
    zipped: tuple[_Values, ...] = ()
    """tables of keys that change together, lists of one length each"""
    keep: tuple[str, ...] = ()
    """conditions on keys of this input, such as "lambda_s * 8 <= lambda_L"; only systems that meet all are run"""
    columns: dict[str, str] = Field(default_factory=dict)
    """columns of one's own: a Python file beside this input with a function of that name, as "mine.py", or
    "mine.py:function"; it takes a stored run and returns a number for each point of its path, or one for all"""
    reduced: _Values = Field(default_factory=dict)
    """values of keys instead of those above, for a sweep of minutes; a list or a range for a key on an axis"""

    @property
    def all_axes(self) -> tuple[Axis, ...]:
        """The axes in their order, the zipped ones last; without the key that is searched for."""
        listed = ((name, given) for name, given in self.axes.items() if not is_bisection(given))
        single = [Axis((name,), tuple((v,) for v in expand_range(given))) for name, given in listed]
        together = [Axis(tuple(t), tuple(zip(*map(expand_range, t.values()), strict=True))) for t in self.zipped]
        return (*single, *together)

    @property
    def bisection(self) -> Bisection | None:
        """The search along one key, if there is one."""
        return next((Bisection.of(name, given) for name, given in self.axes.items() if is_bisection(given)), None)

    @constraint
    def _sound(self) -> Iterator[Fault]:
        # Checks in order; the first that fails is reported.
        yield from next(
            filter(None, (list(find()) for find in (self._lists, self._together, self._conditions, self._named))), ()
        )

    def _lists(self) -> Iterator[Fault]:
        places = [(("axes",), self.axes), *((("zipped", i), table) for i, table in enumerate(self.zipped))]
        searched = [name for name, given in self.axes.items() if is_bisection(given)]
        if len(searched) > 1:
            yield Fault(("axes",), f"one search: {' and '.join(searched)} are searched for")
        for place, table in places:
            for name, given in table.items():
                here = (*place, name)
                if place == ("axes",) and is_bisection(given):
                    wrong = bisection_faults(given, self.columns)
                    yield from (replace(fault, key=(*here, *fault.key)) for fault in wrong)
                    continue
                try:
                    values = expand_range(given)
                except ValueError as error:
                    why = "a search, which belongs in [sweep.axes], not among keys that change together"
                    allowed = f"a list of values, or a range {{from, to, step}}: {error}"
                    yield Fault(here, allowed, why if is_bisection(given) else "")
                else:
                    if not values:
                        yield Fault(here, f"at least one value of {name}")

    def _together(self) -> Iterator[Fault]:
        for i, table in enumerate(self.zipped):
            lengths = {name: len(expand_range(given)) for name, given in table.items()}
            if len(set(lengths.values())) > 1:
                counts = ", ".join(f"{name} has {count}" for name, count in lengths.items())
                yield Fault(("zipped", i), "lists of one length where keys change together", counts)
                return
        names = [name for table in (self.axes, *self.zipped) for name in table]
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield Fault((), f"each key on one axis only: {name} is on several")
        for one, other in itertools.combinations(sorted(set(names)), 2):
            if _overlap(one, other):
                yield Fault((), f"axes that are apart: {one} holds {other}")
        for axis in self.all_axes:
            if len(set(map(_hashable, axis.values))) < len(axis.values):  # 8 and 8.0 are equal
                yield Fault((), f"different values of {' and '.join(axis.keys)}", "the same one twice")
        count = math.prod(len(axis.values) for axis in self.all_axes)
        if count > MOST:
            yield Fault((), f"at most {MOST} systems, not {count}")

    def _conditions(self) -> Iterator[Fault]:
        for i, text in enumerate(self.keep):
            try:
                condition(text)
            except ValueError as error:
                yield Fault(("keep", i), f'a condition such as "lambda_s * 8 <= lambda_L": {error}')

    def _named(self) -> Iterator[Fault]:
        on_axes = [key for table in (self.axes, *self.zipped) for key in table]
        for name in self.columns:
            yield from name_faults(name, on_axes)


def _flat(table: Any) -> Any:
    """A table by dotted keys, quoted or not; unchanged if it is none, or has a key in both spellings."""
    pairs = list(dotted(table, ranges=True)) if isinstance(table, Mapping) else []
    return dict(pairs) if len(dict(pairs)) == len(pairs) > 0 else table


def _flattened(table: Mapping[str, Any]) -> _Values:
    """The table [sweep], its axes by dotted keys."""
    axes, zipped = table.get("axes", {}), table.get("zipped", [])
    return {**table, "axes": _flat(axes), "zipped": list(map(_flat, zipped)) if isinstance(zipped, list) else zipped}


def _changed(table: Mapping[str, Any], changes: Mapping[str, Any]) -> tuple[_Values, _Values]:
    """The table [sweep] with other values on its axes, and the changes of keys that are on none.

    Parameters
    ----------
    changes : values of keys of the input, which for a key on an axis become its values; also of keys of the table
        itself, such as ``sweep.keep``, or ``sweep.axes.surface.seed``, which adds an axis.
    """
    found, plain = _flattened(table), _Values()
    for key, value in changes.items():
        if key.startswith("sweep.") and not key.startswith("sweep.axes."):
            found = _flattened({**found, key.removeprefix("sweep."): value})
            continue
        name = key.replace('"', "").removeprefix("sweep.axes.")
        axes, zipped = found["axes"], found["zipped"]
        tables = [one for one in (axes, *(zipped if isinstance(zipped, list) else ())) if isinstance(one, dict)]
        holder = next((one for one in tables if name in one), axes if name != key else None)
        if isinstance(holder, dict):
            several = isinstance(value, (tuple, list)) or (isinstance(value, Mapping) and is_range(value))
            holder[name] = value if several else [value]
        else:
            plain[key] = value
    return found, plain


def _hashable(value: Any) -> Hashable:
    if isinstance(value, Mapping):
        return frozenset((name, _hashable(item)) for name, item in value.items())
    if isinstance(value, (tuple, list)):
        return tuple(map(_hashable, value))
    return value if isinstance(value, Hashable) else repr(value)


def _overlap(one: str, other: str) -> bool:
    """Whether one of two keys is a table that contains the other."""
    return one != other and (f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}."))


@dataclass(frozen=True, slots=True)
class System:
    """One system of a sweep."""

    key: str
    """Identity: hash of physics, solver settings and schema."""
    settings: Mapping[str, Any]
    """Key and value on each axis."""
    cost: float = math.nan
    """States times points of the grid, or whatever an earlier version took for the work."""
    memory: float = math.nan
    source: Source | None = field(default=None, repr=False, compare=False)
    """The common input of all systems; None of a system of a stored listing."""

    @property
    def label(self) -> str:
        return label_of(self.settings)

    @property
    def kind(self) -> str:
        """Its grid, in words."""
        return label_of({key: value for key, value in self.settings.items() if key.partition(".")[0] == "grid"})

    @property
    def config(self) -> RunConfig:
        assert self.source is not None
        return parsed(self.source.changed(self.settings), RunConfig)


def as_cell(value: Any) -> Any:
    """The value of a key as a cell of a table: lists and tables as text."""
    return json.dumps(value) if isinstance(value, (list, tuple, dict)) else value


def of_systems(axis: Axis, systems: Iterable[System]) -> Axis:
    """An axis with those of its values only that one of the systems has."""
    there = {json.dumps([system.settings[key] for key in axis.keys]) for system in systems}
    return replace(axis, values=tuple(values for values in axis.values if json.dumps(values) in there))


def places_on(axes: Sequence[Axis], systems: Iterable[System]) -> dict[str, tuple[int, ...]]:
    """The place of each system on each axis, by its identity."""
    known = [(axis.keys, {json.dumps(values): i for i, values in enumerate(axis.values)}) for axis in axes]
    return {
        system.key: tuple(places[json.dumps([system.settings[key] for key in keys])] for keys, places in known)
        for system in systems
    }


def label_of(settings: Mapping[str, Any]) -> str:
    """Values of the axes of a system, in words."""
    named = (
        f"{name.rpartition('.')[2]} {value if isinstance(value, str) else text_of(value)}"
        for name, value in settings.items()
    )
    return ", ".join(named) or "the one system"


class SweepInput(Document):
    """Beside the tables of a run, an input of a sweep has a table [sweep]."""

    sweep: SweepTable


@dataclass(frozen=True)
class Sweep:
    """A sweep, as its file says."""

    name: str
    source: Source = field(repr=False)
    """The input file."""
    base: Source = field(repr=False)
    """Input of a run, without the table [sweep] and the keys of the axes."""
    axes: tuple[Axis, ...]
    keep: tuple[str, ...]
    changed: bool = False
    """Whether values were changed from those of the file."""
    bisection: Bisection | None = None
    """The search in each combination of the axes, if there is one."""
    columns: tuple[OwnColumn, ...] = ()
    """Columns of one's own."""

    @property
    def text(self) -> str:
        """The input of this sweep as text, including values that were given elsewhere."""
        if not self.changed:
            return self.source.text
        head = (
            f"# {self.source.path.name}, with the values that were given beside it, of [sweep.reduced] or by --set.\n"
        )
        table = self.source.data["sweep"]
        sweep = {name: table[name] for name in ("keep", "columns", "axes", "zipped") if table.get(name)}
        return head + document({**self.base.data, "sweep": sweep})

    def _refused(self, key: Key, allowed: str, cause: str = "") -> ConfigError:
        return ConfigError(self.source, [Fault(("sweep", *key), allowed, cause)])

    @classmethod
    def read(
        cls,
        file: InputFile,
        settings: Mapping[str, Any] | None = None,
        *,
        reduced: bool = False,
        name: str | None = None,
        columns: Mapping[str, ColumnFunction] | None = None,
    ) -> Self:
        """Read a sweep without checking its systems.

        Parameters
        ----------
        file : the input, or its tables.
        name : of the sweep; that of the file if None, and "sweep" of tables.
        settings : values of keys instead of those of the file; of a key on an axis, a value, a list or a range.
        reduced : whether to use the values of ``[sweep.reduced]``, before the settings.
        columns : functions of columns of one's own by their names, beside those of ``[sweep.columns]``.

        Raises ConfigError with all faults of the table [sweep], or of the files of its columns.
        """
        source = source_of(file, name or "sweep")
        data = dict(source.data)
        table = data.pop("sweep", None)
        if not isinstance(table, Mapping):
            cause = "this is the input of a single run: use `continuum run`, or add a table [sweep] with axes"
            raise ConfigError(source.path, [Fault((), "", cause)])
        reducing = table.get("reduced", {}) if reduced else {}
        changes = {**(_flat(reducing) if isinstance(reducing, Mapping) else {}), **(settings or {})}
        table, plain = _changed(table, changes)
        if columns and isinstance(listed := table.get("columns", {}), Mapping):
            table = {**table, "columns": {**listed, **dict.fromkeys(columns, OF_PYTHON)}}
        source = replace(source, data={**data, "sweep": table})
        found = parsed(replace(source, data={"sweep": table}), SweepInput).sweep
        axes, bisection = found.all_axes, found.bisection
        on_axes = [*(key for axis in axes for key in axis.keys), *([bisection.key] if bisection else [])]
        for key, axis in itertools.product(plain, on_axes):
            if _overlap(key, axis):  # it would be set, and then replaced
                raise ConfigError(source, [Fault(("sweep",), f"values for the axis {axis} as it is, not for {key}")])
        base = replace(source, data=data)
        own = name or source.path.stem
        base = base.changed(plain) if plain else base
        own = f"{own}-reduced" if reduced else own
        made = own_columns(source, found.columns, columns or {})
        return cls(own, source, base, axes, found.keep, bool(changes or columns), bisection, made)

    def systems(self) -> Iterator[tuple[System, RunConfig]]:
        """Systems of the sweep, each once, with the input of its run; the last axis changes fastest.

        A search has its lower and then its upper end.  Raises ConfigError if a system is not a valid input, the column
        of a search does not exist, or there is no system.
        """
        for plan, config, alike in self.plans():
            yield plan, plan.config if alike else config

    def _free_axes(self) -> list[int]:
        """Axes of seeds alone, if no condition names one."""
        if any("seed" in text for text in self.keep):
            return []
        return [i for i, axis in enumerate(self.axes) if all(key.endswith(".seed") for key in axis.keys)]

    def plans(self) -> Iterator[tuple[System, RunConfig, bool]]:
        """Its systems as :meth:`systems` gives them, but of those that differ in seeds the input of the first only.

        The last of the three says whether it is that of another one.
        """
        conditions, seen = [condition(text) for text in self.keep], dict[str, System]()
        search = self.bisection
        ends = [{}] if search is None else [{search.key: value} for value in (search.first, search.last)]
        free = [] if search is not None else self._free_axes()
        keys = [key for i in free for key in self.axes[i].keys]
        groups = dict[tuple[int, ...], Alike | None]()  # None: its systems are not kept

        def planned(key: str, settings: _Values) -> System:
            plan = System(key, settings, source=self.base)
            if (other := seen.setdefault(key, plan)) is not plan:
                cause = "equal values, files of the same content, or a key such as solver.threads on an axis"
                same = f"{other.label} and {plan.label} are one and the same"
                raise self._refused((), f"systems that differ: {same}", cause)
            return plan

        for places in itertools.product(*(range(len(axis.values)) for axis in self.axes)):
            combination = {
                key: value
                for axis, i in zip(self.axes, places, strict=True)
                for key, value in zip(axis.keys, axis.values[i], strict=True)
            }
            # The systems of a group differ in seeds alone: what holds for the first holds for all.
            group = tuple(place for i, place in enumerate(places) if i not in free)
            if keys and group in groups:
                if (alike := groups[group]) is None:
                    continue
                if key := alike.key(combination):
                    yield planned(key, combination), alike.config, True
                    continue
            config = None
            for settings, source in self._kept([combination | end for end in ends], conditions):
                config = parsed(source, RunConfig)
                yield planned(identity(config), settings), config, False
            if keys and group not in groups:
                groups[group] = None if config is None else Alike.of(config, keys)
            if config is not None and search is not None:
                self._require_column(config, search, combination)
        if not seen:
            raise self._refused(("keep",), "conditions that at least one system meets")

    def _require_column(self, config: RunConfig, search: Bisection, combination: _Values) -> None:
        """Check that the column of a search is on the path, and that values between its ends are valid inputs."""
        targets = [target for _, leg in config.loading.legs for target in leg]
        if search.target is not None and not any(map(search.is_target, targets)):
            named = ", ".join(f"{target:g}" for target in targets[:8]) + (", ..." if len(targets) > 8 else "")
            cause = f"{search.column} is read at a point of the path, and {search.target:g} is none of its targets"
            raise self._refused(("axes", search.key, "bisect"), f"a column at a target of the path: {named}", cause)
        parsed(self.base.changed({**combination, search.key: search.middle(search.whole)}), RunConfig)

    def _kept(self, settings: list[_Values], conditions: Sequence[ast.expr]) -> list[tuple[_Values, Source]]:
        """The systems that meet all conditions, with their inputs; of a search both ends or none."""
        sources = [(one, self.base.changed(one)) for one in settings]
        found = [each for each in sources if self._holds(each[1], conditions)]
        if 0 < len(found) < len(settings):
            cause = f"{label_of(found[0][0])} is kept, and the other end of the search is not"
            raise self._refused(("keep",), "conditions on both ends of a search alike", cause)
        return found

    def _holds(self, source: Source, conditions: Sequence[ast.expr]) -> bool:
        known = values_of(source.data)
        for i, each in enumerate(conditions):
            try:
                if not holds(each, known):
                    return False
            except ValueError as error:
                raise self._refused(("keep", i), f"a condition that holds or not: {error}") from None
        return True
