"""Every kind of wall, substrate and surface, from the registries: what holds for one is tested of all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.inputs.reference import unit_said
from continuum.inputs.tables import Description, explained
from continuum.model.substrates import Response, Substrate
from continuum.model.surface import Surface
from continuum.model.walls import TabulatedWall, Wall
from continuum.model.walls.attraction import CORE_PRESSURE
from continuum.store.runs import config as config  # defines the kinds that read files

KINDS: dict[str, type[Description]] = {
    name: kind
    for family in (Wall, Response, Surface)
    for name, kind in family.kinds.items()
    if "path" not in kind.model_fields
}
"""All kinds that read no file, by the names of inputs."""


TABLES: dict[str, dict[str, Any]] = {name: {kind.kind_key: name, **kind.example} for name, kind in KINDS.items()}
"""The example of each, as a table of an input."""


def made(kind: type[Description]) -> Any:
    """The example of a kind, as an input makes it."""
    return kind.model_validate(kind.example, context={})


def tables(family: type[Any]) -> dict[str, dict[str, Any]]:
    """The table of each kind of a family."""
    return {name: TABLES[name] for name, kind in KINDS.items() if issubclass(kind, family)}


def of(family: type[Any]) -> dict[str, Any]:
    """The example of each kind of a family."""
    return {name: made(kind) for name, kind in KINDS.items() if issubclass(kind, family)}


WALLS: dict[str, Wall] = {name: wall.build() for name, wall in of(Wall).items() if wall.has_law}
"""A wall of every law."""
OF_WORK: dict[str, Callable[[float], Wall]] = {name: wall.at_work for name, wall in of(Wall).items() if wall.work_key}
"""Walls of a given work of adhesion, of every law that has a key for it."""
SUBSTRATES: dict[str, Substrate] = of(Response)


def covering(*axes: Iterable[Any]) -> list[Any]:
    """Parameters of a test: each value of each axis at least once, side by side; all combinations in `make long`."""
    values = [tuple(axis) for axis in axes]
    beside = {tuple(i % len(axis) for axis in values) for i in range(max(map(len, values)))}
    return [
        pytest.param(
            *(axis[i] for axis, i in zip(values, at, strict=True)), marks=() if at in beside else pytest.mark.long
        )
        for at in product(*(range(len(axis)) for axis in values))
    ]


def table(e: float, s: float, law: Wall) -> Wall:
    """A law as a table whose tractions are e and whose gaps are s times as large."""
    gap = law.zero_gap + np.linspace(-0.6, min(law.reach - law.zero_gap, 4.0), 601)
    traction = law.evaluate(gap).traction
    return TabulatedWall(s * gap, e * (traction - traction[-1]))


def by_parameters(e: float, s: float, kind: type[Wall]) -> Wall:
    """The example of a law, with its parameters in other units."""
    units = {"E* a0": e * s, "E*": e, "E*/a0": e / s, "a0": s}
    given = dict(kind.example)
    for name, value in kind.example.items():
        unit = "E* a0" if name == kind.work_key else unit_said(explained(kind)[name].description or "")
        given[name] = value * units[unit] if unit in units else value
    if "core_depth" in explained(kind):  # its default is the depth of a pressure of 10 E* where E* = 1
        given["core_depth"] = CORE_PRESSURE / kind.example["core_stiffness"] * s
    return kind.model_validate(given, context={}).build()


def in_units(kind: type[Wall], law: Wall) -> Callable[[float, float], Wall]:
    """A law in other units of pressure and length: by its parameters if it has no length of its own, else a table."""
    gap = law.zero_gap + np.linspace(-0.1, 0.5, 7)
    there = by_parameters(2.0, 3.0, kind).evaluate(3.0 * gap).traction
    # Laws through knots follow theirs to 1e-6 of the largest traction, at other knots.
    scales = np.allclose(there, 2.0 * law.evaluate(gap).traction, rtol=1e-5, atol=1e-5 * np.abs(there).max())
    return partial(by_parameters, kind=kind) if scales else partial(table, law=law)


IN_UNITS: dict[str, Callable[[float, float], Wall]] = {
    **{name: in_units(Wall.kinds[name], wall) for name, wall in WALLS.items()},
    "table": partial(table, law=c.InversePowers((8, 2), adhesion_length=0.005)),
    "hard": lambda e, s: c.HardWall(),
    "attraction-on-core, exponential": lambda e, s: c.attraction_on_core(
        "exponential", 0.005 * e * s, 0.3 * s, 2.0 * e / s
    ),
}
"""A law of every kind in other units of pressure and length."""
