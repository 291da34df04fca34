"""Whatever is given to a public name of `atomistic`: it is used, or refused by the name of the argument."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ase.calculators.emt import EMT
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.response.force_constants import spring_force_constants
from tests.wrong import ANYTHING, refused_by_name

GRID = c.Grid.square(8)
CONTACT = c.Contact(c.sine(GRID, 0.05, (1, 0)), c.LennardJonesSpline(adhesion_length=0.005))
SLAB = a.Slab((4, 5), mobile=3)
COPPER = SLAB.to_atoms(symbol="Cu", spacing=2.55)
COPPER.calc = EMT()
SPRINGS = a.Springs()
CONSTANTS = spring_force_constants(SPRINGS)
LATTICE = a.LatticeResponse(SLAB, CONSTANTS)
WAVES = ((0.1, 1, 0, 0.0),)
Calls = dict[str, tuple[Callable[..., object], Mapping[str, Any]]]
DECK = {
    "slab": SLAB, "model": SPRINGS, "wall": CONTACT.wall, "heights": np.zeros((4, 5)), "separation": 1.2,
    "displacements": None, "tolerance": 1e-9, "evaluations": 100, "rise": None, "protocol": None, "shape": None,
    "notes": (), "stiffness": None, "source": "",
}  # fmt: skip
MOTION = {"temperature": 1e-4, "window": 10.0, "hold": 1, "dwell": 0, "thermostat_layers": 2, "damping": 2.0, "seed": 1}
VELOCITY = {"kind": "velocity", "separations": [1.2, 1.0], "velocity": 0.01, **MOTION}
SLIDING = {"kind": "sliding", "separation": 1.2, "distance": 2.0, "velocity": 0.01, "along": "x", **MOTION}
LOADED = {"kind": "sliding", "pressure": 0.01, "distance": 2.0, "velocity": 0.01, "along": "x", **MOTION}
QUICK = "inputs/validate/quick.toml"


class Accepted(Exception):
    """What expensive work is replaced by: the arguments have been found good."""


def accept(*_: object, **__: object) -> None:
    raise Accepted


@pytest.fixture(autouse=True)
def nothing_expensive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atomistic.relax.specimen.Specimen.of_slab", accept)
    monkeypatch.setattr("atomistic.front.functions.model_of", accept)
    monkeypatch.setattr("atomistic.front.validation.distinct", accept)
    monkeypatch.setattr("atomistic.lammps.engine.run_in_process", accept)
    monkeypatch.setattr("atomistic.lammps.engine.run_command", accept)
    monkeypatch.setattr("atomistic.lammps.deck.write_deck", accept)
    monkeypatch.setattr("atomistic.lammps.include.WallInclude.write", accept)


def protocol(**table: Any) -> None:
    a.deck(CONTACT, protocol=table, depth=4, follows="atom")


def embedded(**changes: Any) -> dict[str, Any]:
    return {
        "style": "eam/alloy", "element": "Cu", "mass": 63.5, "cutoff": 5.5, "guess": 11.8, "comment": "", "name": "Cu",
        "content": b"", **changes,
    }  # fmt: skip


PAIR_STYLE = {
    "style": "adp", "element": "Cu", "mass": 63.5, "cutoff": 5.0, "lattice_constant": 3.6, "arguments": (),
    "coefficients": (("*", "*"),), "contents": {}, "many_body": True,
}  # fmt: skip
CALLS: Calls = {
    "deck": (a.deck, {"contact": CONTACT, "model": None, "separation": 1.2, "depth": 4, "follows": "site"}),
    "deck, steps": (partial(a.deck, CONTACT, depth=4), {"separations": [1.2, 1.1], "crystal": None, "start": False}),
    "deck, pressures": (partial(a.deck, CONTACT, depth=4), {"pressures": [0.01, 0.02]}),
    "deck, protocol": (partial(a.deck, CONTACT, depth=4), {"protocol": VELOCITY}),
    "deck, velocity": (protocol, VELOCITY),
    "deck, sliding": (protocol, SLIDING),
    "deck, sliding under a load": (protocol, LOADED),
    "deck, staircase": (protocol, {"kind": "separations", "separations": [1.2, 1.0], "retract": False}),
    "deck, loads": (protocol, {"kind": "mean-pressures", "pressures": [0.01]}),
    "read": (a.read, {"directory": "nowhere"}),
    "run_deck": (a.run_deck, {"directory": "nowhere", "lmp_command": None, "progress": None}),
    "validate": (
        a.validate,
        {
            "file": QUICK, "output": "out", "workers": None, "decks": None, "lmp_command": None, "force": False,
            "progress": None,
        },
    ),
    "check": (a.check, {"file": QUICK}),
    "elastic": (a.elastic, {"file": SPRINGS, "lattice": None}),
    "find_potential": (a.find_potential, {"name": "Cu_mishin1.eam.alloy", "folder": None}),
    "Slab": (a.Slab, {"shape": (4, 5), "mobile": 3, "frozen": 1}),
    "Slab.of_depth": (a.Slab.of_depth, {"grid": GRID, "depth": 4.0, "frozen": 1}),
    "Slab.site": (SLAB.site, {"ids": np.array([1, 2])}),
    "Slab.to_atoms": (SLAB.to_atoms, {"displacements": None, "symbol": "X", "spacing": 1.0}),
    "Springs": (a.Springs, {"stiffness": 1.0}),
    "LennardJones": (a.LennardJones, {"cutoff": 2.5, "truncation": "mdf", "inner": 2.0}),
    "EmbeddedAtom": (a.EmbeddedAtom, embedded()),
    "EmbeddedAtom.read": (a.EmbeddedAtom.read, {"path": a.find_potential("Ni_u3.eam"), "element": None}),
    "PairStyle": (a.PairStyle, PAIR_STYLE),
    "PairStyle.read_files": (a.PairStyle.read_files, {"paths": ()}),
    "Round": (a.Round, {"period": (4.0, 5.0), "radius": 3.0, "flat_radius": 0.0, "across": (True, True)}),
    "Waves": (a.Waves, {"period": (4.0, 5.0), "mean": 0.0, "waves": WAVES}),
    "LatticeResponse": (a.LatticeResponse, {"slab": SLAB, "force_constants": CONSTANTS, "table": None}),
    "LatticeResponse.of_springs": (a.LatticeResponse.of_springs, {"slab": SLAB, "springs": SPRINGS}),
    "LatticeResponse.of_model": (a.LatticeResponse.of_model, {"slab": SLAB, "model": SPRINGS}),
    "LatticeResponse.stiffness": (LATTICE.stiffness, {"grid": SLAB.grid}),
    "LatticeResponse.tabulated": (LATTICE.tabulated, {"source": "here"}),
    "LatticeResponse.displacements": (LATTICE.displacements, {"forces": np.zeros((1, 4, 5, 3))}),
    "LatticeResponse.displacements_of_surface_force": (
        LATTICE.displacements_of_surface_force, {"force_z": np.zeros((4, 5))}
    ),
    "RoughWall": (
        a.RoughWall,
        {
            "contact": np.zeros((4, 5)), "slab": COPPER, "separation": 1.2, "law": CONTACT.wall, "pixel": None,
            "a0": 2.5, "contact_modulus": 0.8, "follows": "sites", "surface": [0, 1], "offset": (0.5, 0.0),
        },
    ),
    "write_wall": (
        a.write_wall,
        {
            "surface": a.Round((40.0, 40.0), 20.0), "directory": "somewhere", "a0": 2.5, "contact_modulus": 0.8,
            "law": CONTACT.wall, "work": None, "slab": None, "period": None, "surface_atoms": None, "layer": None,
            "units": "metal", "wall_force": "formulas", "size": None, "unit": None, "edges": "mirror", "fill": None,
            "force": False,
        },
    ),
    "read_trace": (a.read_trace, {"path": "nowhere"}),
    "GreensRelaxation": (
        partial(a.GreensRelaxation, logfile=None), {"atoms": COPPER, "response": None, "at_rest": COPPER}
    ),
    "SlabResponse.measure": (a.SlabResponse.measure, {"slab": COPPER, "calculator": EMT()}),
    "Deck": (a.Deck, DECK),
    "Deck.write": (a.Deck(**DECK).write, {"directory": "somewhere"}),
}  # fmt: skip
# Made by the functions, and by nobody else; their own methods are below.
RESULTS = {"DeckCertificate", "DeckRun", "Elastic", "Trace", "Validation", "WallInclude"}
PATHS = {"directory", "file", "output", "decks", "name", "folder", "path", "paths", "surface", "slab"}


def test_every_public_name_is_called() -> None:
    errors = {
        name for name in a.__all__ if isinstance(getattr(a, name), type) and issubclass(getattr(a, name), Exception)
    }
    assert set(a.__all__) - errors - RESULTS - {"doctor"} == {call.split(".")[0].split(",")[0] for call in CALLS}


def refused(call: str, name: str, value: Any) -> bool:
    """Whether a value is refused, by the name of its argument."""
    function, good = CALLS[call]
    try:
        return refused_by_name(function, good, name, value)
    except (Accepted, a.LammpsError):  # a directory that is not there
        return False


@pytest.mark.parametrize("call", CALLS)
def test_the_example_is_good(call: str) -> None:
    name, value = next(iter(CALLS[call][1].items()))
    assert name in PATHS or not refused(call, name, value)


@pytest.mark.parametrize("call", CALLS)
def test_what_is_nothing_at_all_is_refused(call: str) -> None:
    for name in CALLS[call][1]:
        for value in (object(), float("nan"), {1, 2}, 1j, a, "\0"):
            if not (name in ("comment", "source", "notes") and value == "\0"):
                assert refused(call, name, value), (name, value)


def given_to(name: str) -> st.SearchStrategy[Any]:
    """Anything, but no name of a file that might be there."""
    return ANYTHING.filter(lambda value: not isinstance(value, str | list)) if name in PATHS else ANYTHING


@pytest.mark.parametrize("call", CALLS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_whatever_is_given_is_used_or_refused_by_its_name(call: str, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(list(CALLS[call][1])))
    refused(call, name, data.draw(given_to(name)))


@pytest.fixture
def results(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Calls:
    monkeypatch.undo()
    run = a.run_deck(a.Deck(**DECK).write(tmp_path / "deck"))
    found = a.elastic(SPRINGS)
    return {
        "sheets": (run.sheets, {"compare": False}),
        "write": (run.write, {"folder": tmp_path / "out", "compare": False}),
        "plot": (found.plot, {"folder": tmp_path / "out", "name": "springs"}),
    }


def test_the_methods_of_results_refuse_by_name_too(
    results: Calls,
) -> None:
    for function, good in results.values():
        for name in good:
            for value in (object(), float("nan"), 3, None, "\0", np.zeros(3)):
                assert refused_by_name(function, good, name, value), (function, name, value)
