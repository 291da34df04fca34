"""One record of a point, from the solver to what is stored and shown."""

import importlib
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import continuum as c
from continuum.measure.contact import Equilibrium, Totals
from continuum.path.equilibrium import solver_of
from continuum.path.state import JumpSide
from continuum.store.runs.record import Point
from tests.problems import Rough

ROOT = Path(__file__).resolve().parents[4]


def records(kind: type[Totals] = Totals) -> Iterator[type[Totals]]:
    """A class of records, and those derived from it."""
    yield kind
    for other in kind.__subclasses__():
        yield from records(other)


def test_a_column_is_described_once() -> None:
    for folder in ("measure", "path", "store/runs", "front"):
        for path in (ROOT / "continuum" / folder).glob("[a-z]*.py"):
            importlib.import_module(f"continuum.{folder.replace('/', '.')}.{path.stem}")
    found = [kind for kind in records() if kind.__module__.startswith("continuum")]
    assert {Totals, Equilibrium, c.State, Point} < set(found)
    own = [name for kind in found for name in kind.__annotations__ if kind.__dataclass_fields__[name].metadata]
    assert len(own) == len(set(own))
    assert set(JumpSide._fields) < {"value", *(one.name for one in fields(Equilibrium))}


def test_what_is_stored_of_a_state_are_its_own_numbers() -> None:
    contact = c.Contact(Rough(32, lambda_s=8.0).problem().heights, c.LennardJonesSpline(adhesion_length=0.005))
    state = contact.press(mean_gap=1.5)
    stored = Point.of(contact.problem, state, solver_of(contact.problem, contact.settings))
    for one in fields(Equilibrium):
        np.testing.assert_equal(getattr(stored, one.name), getattr(state, one.name))
    assert (stored.status, str(state.status)) == ("CONVERGED", "converged")
    assert stored.meaning == state.status
    with pytest.raises(TypeError):
        Equilibrium()
