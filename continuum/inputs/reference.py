"""Reference, schema and commented template of an input file, made from the models that check it.

Type, bounds, default and meaning of a key are those with which it is read.
"""

import json
import math
import re
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic.fields import FieldInfo

from continuum.inputs.keys import LARGEST, ForBoth, limits_of
from continuum.inputs.reading import load
from continuum.inputs.tables import Table, explained, tables_in
from continuum.inputs.toml import Document, find, text_of

_WIDTH = 100
_BOUNDS: Mapping[str, str] = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
_NAMES = {float: "number", int: "whole number", str: "text", bool: "true or false", Path: "file", dict: "table"}
_PLURAL = re.compile(r"(^| or )(list|number|whole number|text|file|table)\b")
_UNIT = re.compile(
    r"\bin (the unit of [a-z ]*[a-z]|a0 \(m/\(E\* a0³\)\)\^\(1/2\)|\(E\* a0³/m\)\^\(1/2\)"
    r"|E\*/a0|E\* over the spacing|E\* a0[²³]?|E\*|a0"
    r"|Å|u\b|sigma|σ|radians|degrees|kelvin|seconds|GB|bytes|their units)"
)
_WITH_UNIT = re.compile(r"\bas \"?\d[\d.]*[a-zA-Zµ]")
_PURE = re.compile(r"\b(relative to|fractions?|share|exponent|ratio|slopes?)\b")


class Entry(NamedTuple):
    """A key of a table."""

    name: str
    type: str
    unit: str
    """Unit as its description says it, "1" of a pure number; empty where the description says neither."""
    default: str
    """Default, as written in a file; empty if the key is required."""
    meaning: str


class TableEntry(NamedTuple):
    """A table of an input file, of one of its kinds."""

    place: str
    """Name of the table with its brackets, as in the file."""
    kind: str
    """``kind = "..."``, which says which one it is; empty if there is only one."""
    meaning: str
    keys: tuple[Entry, ...]


def entries(model: type[Table], place: str = "") -> Iterator[TableEntry]:
    """All tables that a document may have, each kind of each, in order; first the keys that are in no table."""
    fields = explained(model)
    alone = [name for name, field in fields.items() if not tables_in(field.annotation)]
    if alone and not place:
        keys = tuple(_entry(name, fields[name]) for name in alone)
        yield TableEntry("", "", "Keys before all tables.", keys)
    for name, field in fields.items():
        inner = f"{place}.{name}" if place else name
        is_array = any(get_origin(part) is tuple for part in (field.annotation, *get_args(field.annotation)))
        brackets = f"[[{inner}]]" if is_array else f"[{inner}]"
        for table in tables_in(field.annotation):
            keys = tuple(_entry(*key) for key in explained(table).items() if not tables_in(key[1].annotation))
            kind = next((f"{e.name} = {e.type}" for e in keys if e.name == table.kind_key), "")
            yield TableEntry(brackets, kind, _about(table), keys)
            yield from entries(table, inner)


def _about(table: type[Table]) -> str:
    """The first paragraph of what is said of a table."""
    return " ".join((table.__doc__ or "").partition("\n\n")[0].split())


def _entry(name: str, field: FieldInfo) -> Entry:
    default = "" if field.is_required() else _toml(field.get_default(call_default_factory=True))
    # A bound that only keeps powers from overflow is not shown.
    limits = {name: bound for name, bound in limits_of(field).items() if bound != LARGEST}
    bounds = [f"{_BOUNDS[name]} {bound:g}" for name, bound in limits.items()]
    kind = ", ".join([_words(field.rebuild_annotation()), *bounds])
    meaning = " ".join((field.description or "").split())
    is_quantity = re.search(r"(?<!whole )number|text", kind) is not None
    return Entry(name, kind, unit_said(meaning) if is_quantity else "", default, meaning)


def unit_said(meaning: str) -> str:
    """The unit that a description says, as "in a0"; "1" of what it calls relative, a fraction, a ratio or a slope.

    All are named where there are several; "given with it" is that of an example, "as 10nm"; empty where it says none.
    """
    found = [unit.replace("the unit of", "that of") for unit in _UNIT.findall(meaning)]
    found += ["given with it"] if _WITH_UNIT.search(meaning) else []
    found += ["1"] if _PURE.search(meaning) else []
    return " or ".join(dict.fromkeys(found))


def _words(annotation: Any) -> str:
    origin, arguments = get_origin(annotation), get_args(annotation)
    if (name := _NAMES.get(origin or annotation)) is not None:
        return name
    if origin is Literal:
        return " or ".join(f'"{choice}"' if isinstance(choice, str) else str(choice) for choice in arguments)
    if origin is tuple:
        several = _PLURAL.sub(r"\1\2s", _words(arguments[0]))
        return f"list of {several}" if arguments[-1] is Ellipsis else f"list of {len(arguments)} {several}"
    if hasattr(annotation, "__metadata__"):
        words = _words(annotation.__origin__)
        one = f"{_words(get_args(annotation.__origin__)[0])}, or " if ForBoth in annotation.__metadata__ else ""
        return one + words
    parts = [_words(part) for part in arguments if part is not type(None)]
    return " or ".join(dict.fromkeys(parts)) if parts else getattr(annotation, "__name__", str(annotation))


def _toml(value: Any) -> str:
    return "not given" if value in (None, math.inf) else text_of(value)


def markdown(model: type[Document], title: str) -> str:
    """Every key of every table, as a page in Markdown."""
    lines = [f"# {title}", "", _about(model), ""]
    for table in entries(model):
        head = f"## `{table.place}`" + (f" with `{table.kind}`" if table.kind else "") if table.place else "## No table"
        lines += [head, "", table.meaning, "", "| key | meaning | unit | default | type |", "|---|---|---|---|---|"]
        for key in table.keys:
            default = f"`{key.default}`" if key.default else "*required*"
            cells = (f"`{key.name}`", key.meaning or "which kind it is", key.unit or "–", default, key.type)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def schema(model: type[Document]) -> str:
    """The JSON schema of an input, for editors that complete and check TOML."""
    return json.dumps(model.model_json_schema(), indent=1, ensure_ascii=False) + "\n"


def template(model: type[Document], example: str) -> str:
    """Template of an input: the values of an example that comes with the package, each key with its meaning.

    Keys that keep their default are commented out, with that default.
    """
    config = load(find(example), model)
    about = f"{_about(model)}  Lengths are in a0, pressures in E*, the contact modulus."
    return "\n".join([*_commented(about), *_of_table("", "", config)]).rstrip() + "\n"


def _commented(text: str) -> list[str]:
    return textwrap.wrap(text.replace("``", "`"), _WIDTH, initial_indent="# ", subsequent_indent="# ")


def _described(place: str, value: Any, field: FieldInfo) -> list[str]:
    """A table as text, with those inside it; only name and meaning if it is not given."""
    if isinstance(value, tuple) and value and isinstance(value[0], Table):
        return [line for item in value for line in _of_table(f"[[{place}]]", place, item)]
    if isinstance(value, Table):
        return _of_table(f"[{place}]", place, value)
    tables = tables_in(field.annotation)
    return [line for table in tables for line in _not_given(place, table)] + [""] if tables else []


def _not_given(place: str, table: type[Table]) -> Iterator[str]:
    """A table that an example lacks: its meaning and, where there are several kinds of it, its keys."""
    meaning, name = _about(table), f"[{place}]"
    yield from _commented(meaning if meaning.startswith(name) else f"{name}: {meaning}")
    if not table.kind_key:
        return
    for own, field in explained(table).items():
        key = _entry(own, field)
        said = f"{own} = {key.default or key.type}" + (f"  # {key.meaning}" if key.meaning else "")
        yield from textwrap.wrap(said, _WIDTH, initial_indent="#   ", subsequent_indent="#       ")


def _of_table(head: str, place: str, table: Table) -> list[str]:
    """A table, each key with its meaning, commented out where it has its default; then those inside it."""
    lines, inner = [head], list[str]()
    for name, field in explained(type(table)).items():
        value = table.value(name)
        if tables_in(field.annotation):
            inner += _described(f"{place}.{name}" if place else name, value, field)
            continue
        kept = not field.is_required() and value == field.get_default(call_default_factory=True)
        lines += _commented(" ".join((field.description or "").split()))
        lines.append(f"# {name} = {_toml(value)}" if kept else f"{name} = {_toml(value)}")
    return [*lines, "", *inner]
