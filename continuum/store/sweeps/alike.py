"""Systems that differ in seeds alone: the first is checked, and the others are identified by its text.

Nothing else in an input depends on a seed (``Table.alone``), so that a million of them need not be checked each.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Annotated, Any, Self

from pydantic import TypeAdapter, ValidationError

from continuum.inputs.tables import Table
from continuum.store.identity import identified, identity, identity_text
from continuum.store.runs.config import RunConfig

_MARK = "\ue000{}\ue000"


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
        same = sorted(found) == sorted(keys) and alike.key(own_values) == identity(config)
        return alike if same else unknown

    def key(self, settings: Mapping[str, Any]) -> str | None:
        """The identity of one of them; None if its values have to be checked with the whole input."""
        values = [settings[key] for key in self.keys]
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
