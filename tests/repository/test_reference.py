"""The reference is complete: every key, option, argument and column says what it is, in which unit, and its default."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import fields
from types import ModuleType

import pytest
from cyclopts import App
from cyclopts.argument import Argument

import atomistic
import atomistic.front.cli
import continuum
import continuum.front.cli
from atomistic.ladder.comparison import PathPlan, ValidatedState
from atomistic.ladder.rungs import Rung
from atomistic.lammps.result import DeckResult
from atomistic.relax.deckrun import ContinuumStep, DeckStep
from continuum.front.options import arguments_of
from continuum.inputs.errors import EXIT_CODES
from continuum.inputs.reference import entries, unit_said
from continuum.inputs.tables import Description, explained
from continuum.maps.verdict.tables import OPTIONS
from continuum.store.runs.record import Point
from continuum.store.sweeps.measured import COLUMNS
from docs import from_source

NUMBER = re.compile(r"(?<!whole )number")
APPS = {"continuum": continuum.front.cli.app, "atomistic": atomistic.front.cli.app}


@pytest.mark.parametrize("name", from_source.INPUTS)
def test_every_key_of_an_input_says_what_it_is_and_every_number_its_unit(name: str) -> None:
    model, title = from_source.INPUTS[name]
    page = from_source.inputs()[name]
    assert page.startswith(f"# {title}\n")
    keys = [(table.place, key) for table in entries(model) for key in table.keys]
    assert len(keys) > 4
    for place, key in keys:
        said = f"| `{key.name}` | {key.meaning or 'which kind it is'} | {key.unit or '–'} | "
        assert said in page.replace("\\|", "|")
        assert key.meaning or key.type.startswith('"'), (place, key.name)
        assert key.unit or not NUMBER.search(key.type), f"{place} {key.name}: no unit in {key.meaning!r}"


def test_every_quantity_of_a_map_has_an_example_with_its_unit() -> None:
    quantities = [name for name, field in OPTIONS.items() if "_quantity" in repr(field.annotation)]
    assert len(quantities) > 6
    keys = {key.name: key for table in entries(from_source.INPUTS["predict"][0]) for key in table.keys}
    assert {name: keys[name].meaning for name in quantities if "given with it" not in keys[name].unit} == {}


@pytest.mark.parametrize(
    ("said", "unit"),
    [
        ("shortest wavelength, in a0", "a0"),
        ("stiffness per area at the minimum, in E*/a0; the paper's is 1/2", "E*/a0"),
        ("γ, in E* a0", "E* a0"),
        ("time over which load and areas are averaged, in a0 (m/(E* a0³))^(1/2)", "a0 (m/(E* a0³))^(1/2)"),
        ("time constant of the thermostat, in the unit of window", "that of window"),
        ("Use only waves longer than this length, as 100nm.", "given with it"),
        ("width of the bracket of works, relative to the threshold.", "1"),
        ("in a0 where it is a length, else as a fraction of A0", "a0 or 1"),
        ("how far it goes", ""),
        ("the spacing in unusual places", ""),
    ],
)
def test_a_unit_is_what_the_description_says(said: str, unit: str) -> None:
    assert unit_said(said) == unit


def commands(app: App, *before: str) -> Iterator[tuple[str, App]]:
    """Commands that do something, each with its words."""
    for name in (name for name in app.resolved_commands() if not name.startswith("-")):
        within = list(commands(app[name], *before, name))
        yield from within or [(" ".join((*before, name)), app[name])]


def options(app: App) -> list[Argument]:
    return list(app.assemble_argument_collection(default_parameter=continuum.front.cli.app.default_parameter))


@pytest.mark.parametrize("program", APPS)
def test_every_option_of_every_command_says_what_it_is_and_every_number_its_unit(program: str) -> None:
    page = from_source.commands(program)
    found = dict(commands(APPS[program]))
    assert len(found) > 6
    for name, app in found.items():
        heading = f"{'#' * (2 + name.count(' '))} {program} {name}\n"
        assert heading in page
        section = re.split(r"^#", page.partition(heading)[2], maxsplit=1, flags=re.MULTILINE)[0]
        for option in options(app):
            assert f"`{option.names[0]}" in section or f"`{', '.join(option.names)}" in section, (name, option.names)
            said, kind, default = option.parameter.help or "", str(option.hint), option.field_info.default
            assert said, (name, option.names)
            assert "float" not in kind or unit_said(said), f"{name} {option.names}: no unit in {said!r}"
            # What the page cannot show as a default, the description says.
            shown = option.required or default in (None, False, ()) or option.parameter.show_default is None
            assert shown or "default" in said, f"{name} {option.names}: {default}"


def descriptions(of: object) -> dict[str, str]:
    """What is said of each argument of a function or a class."""
    if isinstance(of, type) and issubclass(of, Description):
        return {name: field.description or "" for name, field in explained(of).items()}
    return arguments_of(of)


@pytest.mark.parametrize("package", [continuum, atomistic], ids=lambda package: package.__name__)
def test_every_argument_of_a_public_function_is_described_and_every_number_has_its_unit(package: ModuleType) -> None:
    """Of classes those that are called: a result is made by a function, and its attributes have docstrings."""
    public = [(name, getattr(package, name)) for name in package.__all__]
    methods = inspect.getmembers(continuum.Contact, inspect.isfunction) if package is continuum else []
    public += [(f"Contact.{name}", method) for name, method in methods if name[0] != "_"]
    checked = 0
    for name, of in public:
        said, doc = descriptions(of), inspect.getdoc(of) or ""
        assert doc, name
        if not callable(of) or (isinstance(of, type) and not said):
            continue
        for argument, parameter in inspect.signature(of).parameters.items():
            checked += argument != "self"
            assert argument == "self" or argument in said or re.search(rf"\b{argument}\b", doc), (name, argument)
            kind = str(parameter.annotation)
            # An array in place of a file has the unit that another argument says.
            number = re.search(r"\bfloat\b|Real|ArrayLike", kind) and "Path" not in kind
            assert not number or unit_said(said.get(argument, doc)), f"{name}, {argument}: no unit"
    assert checked > 30


def test_every_column_of_a_table_and_every_exit_code_is_on_its_page() -> None:
    """Of stored files each dataset describes itself: ``describe_themselves`` in tests/stored.py."""
    rows = from_source.table_of_a_sweep()
    for name, (unit, what) in COLUMNS.items():
        assert what
        assert f"| `{name}` | {what} | {unit or '–'} |" in rows
        assert unit or " in " in what, name
    page = from_source.exit_codes()
    assert all(f"| {code} | {meaning} |" in page for code, meaning in EXIT_CODES.items())


@pytest.mark.parametrize("record", [Point, DeckStep, ContinuumStep, DeckResult, Rung, PathPlan, ValidatedState])
def test_every_number_of_a_record_says_what_it_is_and_its_unit(record: type) -> None:
    """Of these the files of runs, decks and validations are made, and the page of what is stored."""
    stored = [one for one in fields(record) if one.metadata]
    assert stored
    for one in stored:
        units, said = one.metadata["units"], one.metadata["long_name"]
        assert said, one.name
        assert not said.startswith("of "), f"{one.name}: {said!r} does not say what"
        assert units or one.type in (str, "str") or " in " in said or "date" in said, f"{one.name}: no unit"
        assert not set("²³") & set(units), f"{one.name}: units of files are written as a0^2"
