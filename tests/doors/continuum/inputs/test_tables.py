"""Families of tables: an input knows a kind as soon as it is defined, and no earlier."""

from __future__ import annotations

import copy
import inspect
import json
import pickle
from typing import Any, ClassVar, Literal

import hypothesis
import pytest
from hypothesis import strategies as st
from pydantic import ValidationError

from atomistic.inputs.deck import DeckConfig, DeckSurface
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.keys import Positive, frozen, limits_of
from continuum.inputs.reading import load
from continuum.inputs.reference import markdown, schema
from continuum.inputs.tables import Table, tables_in
from continuum.inputs.toml import ConfigError
from continuum.model.surface import Surface
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.store.runs.config import RunConfig
from tests.doors.continuum.inputs.test_arguments import ANYTHING
from tests.kinds import KINDS, made

INPUT = "inputs/smoke/nonadhesive.toml"


@pytest.fixture
def newcomer():
    class Newcomer(Wall, kind="newcomer"):
        """[wall] of law "newcomer"."""

        strength: Positive
        """tells how strong it is"""

        def build(self) -> Wall:
            return LennardJonesSpline(self.strength)

    yield Newcomer
    del Wall.kinds["newcomer"]


def test_a_kind_is_known_once_it_is_defined(newcomer: type[Wall]) -> None:
    config = load(INPUT, RunConfig, {"wall": {"law": "newcomer", "strength": 0.25}})
    assert type(config.wall) is newcomer
    assert config.wall.build() == LennardJonesSpline(0.25)
    assert config.wall.plain() == {"law": "newcomer", "strength": 0.25}
    assert config.wall == newcomer(0.25)
    assert RunConfig(**dict(config)).wall is config.wall  # a table that is there is taken as it is
    # Its source is read when that is shown, not when a program begins.
    assert newcomer.model_fields["strength"].description is None
    assert 'with `law = "newcomer"`' in markdown(RunConfig, "Keys")
    assert "tells how strong" in schema(RunConfig)


def test_a_key_with_fixed_names_names_several_kinds() -> None:
    class Family(Table):
        kind_key: ClassVar[str] = "kind"

    class Both(Family):
        kind: Literal["one", "other"]

    assert Family.kinds == {"one": Both, "other": Both}
    assert Both.model_validate({"kind": "other"}).plain() == {"kind": "other"}


def test_its_faults_are_told_in_its_words(newcomer: type[Wall]) -> None:
    for given, words in (
        (
            {"law": "newcomer", "strength": -1.0},
            "greater than 0 and less than or equal to 1e+30 (tells how strong it is)",
        ),
        ({"law": "newcomer", "strength": 1.0, "range": 1.0}, "it belongs to another kind of [wall]"),
        ({"law": "newcomar", "strength": -1.0}, 'did you mean "newcomer"?'),
        ({"strength": 1.0}, "the kind of the table"),
        ({"law": 3}, "one of"),
        (3, "a table, [wall]"),
    ):
        with pytest.raises(ConfigError) as refused:
            load(INPUT, RunConfig, {"wall": given})
        assert words in str(refused.value)
    # A slip in the kind does not hide what else is wrong.
    with pytest.raises(ConfigError, match="how strong"):
        load(INPUT, RunConfig, {"wall": {"law": "newcomar", "strength": -1.0}})


def test_a_kind_that_is_not_defined_is_refused() -> None:
    with pytest.raises(ConfigError, match="one of"):
        load(INPUT, RunConfig, {"wall": {"law": "newcomer", "strength": 1.0}})


def test_a_family_below_another_has_the_kinds_of_both() -> None:
    assert set(DeckSurface.kinds) == {*Surface.kinds, "topography"}
    assert "topography" not in Surface.kinds
    assert len(tables_in(DeckConfig.model_fields["surface"].annotation)) == len(DeckSurface.kinds)


def test_a_kind_is_one_thing_for_python_and_for_inputs() -> None:
    for name in KINDS:
        kind, one = KINDS[name], made(KINDS[name])
        read = kind.model_validate({kind.kind_key: name, **kind.example}, context={})
        assert one == read == one.model_copy() == pickle.loads(pickle.dumps(one)) == copy.deepcopy(one)
        assert hash(one) == hash(read)
        stored = frozen(json.loads(json.dumps(one.plain(), allow_nan=False)))
        assert kind.model_validate(stored, context={"restored": True}) == one
        assert stored[kind.kind_key] == name
        assert [*inspect.signature(kind).parameters] == [*kind.model_fields] or "__init__" in vars(kind)
        for key in kind.model_fields:
            with pytest.raises(AttributeError, match="immutable"):
                setattr(one, key, 1)


@pytest.mark.parametrize(("name", "key"), [(name, key) for name, kind in KINDS.items() for key in kind.model_fields])
@hypothesis.given(value=st.one_of(ANYTHING, st.floats(0.01, 10), st.integers(-3, 20)))
def test_what_an_input_takes_python_takes_and_both_refuse_the_same(name: str, key: str, value: Any) -> None:
    """But for bounds that only inputs have, and for infinity, which an input says by leaving a key out."""
    kind = KINDS[name]
    try:
        one = made(kind).model_copy(update={key: value})
    except ArgumentError:
        one = None
    try:
        read = kind.model_validate({**kind.example, key: frozen(value)}, context={})
    except ValidationError:
        read = None
    field = kind.model_fields[key]
    narrower = value == float("inf") or limits_of(field) != limits_of(field, in_inputs=False)
    assert one == read or (read is None and narrower)
