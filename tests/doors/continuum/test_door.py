"""Whatever is given to a public name of `continuum`: it is used, or refused by the name of the argument."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.inputs.keys import LARGEST, SMALLEST
from continuum.inputs.tables import Description
from continuum.model.substrates import Response
from continuum.model.walls import Wall
from tests.kinds import KINDS, made
from tests.problems import SMALL, Rough
from tests.wrong import ANYTHING, refused_by_name

GRID = c.Grid.square(16)
HEIGHTS = Rough(16, lambda_s=8.0, lambda_L=16.0).heights()
CONTACT = c.Contact(HEIGHTS, c.LennardJonesSpline(adhesion_length=0.005))
GAP = np.linspace(0.7, 1.3, 9)
STIFFNESS = c.HalfSpace().stiffness(GRID)
Calls = dict[str, tuple[Callable[..., object], Mapping[str, Any]]]
CALLS: Calls = {
    "Contact": (
        c.Contact,
        {
            "heights": HEIGHTS, "wall": c.HardWall(), "substrate": c.HalfSpace(), "period": None, "tolerance": 1e-6,
            "max_iterations": 100, "area_tolerance": 0.01, "threads": 1, "device": "cpu",
        },
    ),
    "Contact.press": (
        CONTACT.press, {"area": None, "mean_gap": 2.0, "separation": None, "pressure": None, "start": None}
    ),
    "Contact.press, area": (CONTACT.press, {"area": 0.1}),
    "Contact.press, separation": (CONTACT.press, {"separation": 2.0}),
    "Contact.press, pressure": (CONTACT.press, {"pressure": 0.01}),
    "Contact.press, gradient": (
        CONTACT.press(mean_gap=1.2).gradient, {"number": "load", "at": "area", "wall": None}
    ),
    "Contact.path": (
        CONTACT.path,
        {
            "area": None, "mean_gap": [2.0], "separation": None, "pressure": None, "event_resolution": None,
            "progress": None,
        },
    ),
    "Contact.path, area": (CONTACT.path, {"area": [0.1]}),
    "Contact.against": (CONTACT.against, {"other": HEIGHTS[::-1], "shift": (1.0, 2.5), "angle": 90.0}),
    "Contact.threshold": (
        CONTACT.threshold, {"wall": lambda work: c.attraction_on_core("spline", work, 0.4, 5.0), "area": 0.1}
    ),
    "Contact.find_threshold": (
        CONTACT.find_threshold,
        {"wall": lambda work: c.attraction_on_core("spline", work, 0.4, 5.0), "area": 0.1, "width": 0.1},
    ),
    "CubicLayer": (c.CubicLayer, {"depth": 4.0, "constants": (1.03, 0.515, 0.515), "mean": "clamped", "axis": 0.0}),
    "Exponential": (c.Exponential, {"surface_energy": 0.01, "decay_length": 0.3, "core_stiffness": 2.0}),
    "Grid": (c.Grid, {"shape": (4, 5), "lengths": (4.0, 5.0)}),
    "Grid.square": (c.Grid.square, {"n": 4, "spacing": 1.0}),
    "HardWall": (c.HardWall, {"hardness": 0.1}),
    "HalfSpace": (c.HalfSpace, {"mean": "clamped"}),
    "HalfSpace.stiffness": (c.HalfSpace().stiffness, {"grid": GRID}),
    "InversePowers": (c.InversePowers, {"powers": (9, 3), "minimum_stiffness": 0.5, "core": 0.7}),
    "InversePowers, length": (partial(c.InversePowers, (9, 3)), {"adhesion_length": 0.01}),
    "Layer": (c.Layer, {"depth": 4.0, "poisson": 0.3, "mean": "free"}),
    "Layer.stiffness": (c.Layer(4.0, 0.3, "free").stiffness, {"grid": GRID}),
    "LayeredHalfSpace": (
        c.LayeredHalfSpace, {"layers": [(1.0, 1.0, 0.3), (2.0, 0.5, 0.5)], "base": (0.1, 0.4), "mean": "free"}
    ),
    "LayeredHalfSpace.stiffness": (c.LayeredHalfSpace([(1.0, 1.0, 0.3)], (0.1, 0.4)).stiffness, {"grid": GRID}),
    "LennardJonesSpline": (c.LennardJonesSpline, {"range": 0.3, "minimum_stiffness": 0.5, "core": 0.7}),
    "LennardJonesSpline, length": (c.LennardJonesSpline, {"adhesion_length": 0.01}),
    "LennardJonesSpline.evaluate": (c.LennardJonesSpline(0.3).evaluate, {"gap": GAP}),
    "NonPeriodicHalfSpace": (c.NonPeriodicHalfSpace, {}),
    "NonPeriodicHalfSpace.stiffness": (c.NonPeriodicHalfSpace().stiffness, {"grid": GRID}),
    "NonPeriodicHalfSpace.open_boundary": (c.NonPeriodicHalfSpace().open_boundary, {"grid": GRID}),
    "SelfAffine": (
        c.SelfAffine, {"hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 8.0, "rescale": True}
    ),
    "SelfAffine.synthesise": (
        c.SelfAffine(0.8, 0.1, 4.0, 8.0).synthesise, {"grid": GRID, "rng": np.random.default_rng(1)}
    ),
    "TabulatedSubstrate": (
        c.TabulatedSubstrate, {"table": STIFFNESS, "lengths": (16.0, 16.0), "source": "a half-space"}
    ),
    "TabulatedSubstrate.stiffness": (c.TabulatedSubstrate(STIFFNESS, (16.0, 16.0), "here").stiffness, {"grid": GRID}),
    "TabulatedWall": (c.TabulatedWall, {"gap": GAP, "traction": np.append(np.linspace(0.5, -0.01, 8), 0.0)}),
    "attraction_on_core": (
        c.attraction_on_core,
        {"shape": "spline", "adhesion_length": 0.01, "effective_range": 0.4, "core_stiffness": 5.0, "core_depth": 2.0},
    ),
    "moments": (c.moments, {"grid": GRID, "heights": HEIGHTS}),
    "noise_error": (
        c.noise_error, {"grid": GRID, "gradient": HEIGHTS, "rms": 0.1, "correlation_length": 2.0}
    ),
    "sine": (c.sine, {"grid": GRID, "amplitude": 0.1, "waves": (1, 0)}),
    "sphere": (c.sphere, {"grid": GRID, "radius": 20.0}),
}  # fmt: skip
FILES: Calls = {
    "analyse": (c.analyse, {"result": "nothing.h5"}),
    "examples": (c.examples, {"about": None}),
    "certify": (c.certify, {"path": "nothing.h5", "sample": 1, "seed": 0, "progress": None}),
    "plot": (c.plot, {"result": "nothing.h5", "folder": None}),
    "check": (c.check, {"file": "small.toml", "settings": None}),
    "run": (
        c.run,
        {
            "file": "small.toml", "output": "out", "force": False, "device": None, "settings": None, "progress": None,
            "warn": None,
        },
    ),
    "threshold": (
        c.threshold,
        {
            "file": "small.toml", "output": "out", "area": [0.1], "width": 0.1, "force": False, "settings": None,
            "progress": None, "warn": None,
        },
    ),
    "sweep": (
        c.sweep,
        {
            "file": "sweep.toml", "output": "out", "settings": None, "reduced": False, "workers": 1, "threads": 1,
            "device": None, "memory": None, "retry": False, "shard": (1, 1), "scheduler_file": None, "name": "mine",
        },
    ),
    "figure": (c.figure, {"name": "figure4", "sweep": "nowhere"}),
    "sweep_status": (c.sweep_status, {"sweep": "nowhere", "why": "sweep.toml", "settings": None, "reduced": False}),
    "sweep_collect": (c.sweep_collect, {"sweep": "nowhere", "output": None}),
    "sweep_maps": (c.sweep_maps, {"sweep": "nowhere", "where": None}),
    "sweep_verify": (c.sweep_verify, {"sweep": "nowhere", "aside": False}),
    "sweep_slurm": (
        c.sweep_slurm,
        {
            "file": "sweep.toml", "output": "out", "settings": None, "reduced": False, "nodes": 1, "time": "1:00:00",
            "workers": 2, "shards": None, "threads": 1, "memory": None, "device": None, "partition": "a",
            "account": "b", "modules": ["gcc"], "lines": ["true"],
        },
    ),
}  # fmt: skip
# Made by the functions, and by nobody else.  What `predict` and `study` are given has tests of its own.
RESULTS = {
    "Analysis",
    "Certificate",
    "FoundThreshold",
    "LoadingPath",
    "Prediction",
    "Result",
    "State",
    "Study",
    "SweepTask",
}
APART = {"predict", "study", "doctor"}
ARGUMENTS = [(call, name) for call, (_, good) in CALLS.items() for name in good]
OF_FILES = [(call, name) for call, (_, good) in FILES.items() for name in good]


def test_every_public_name_is_called() -> None:
    errors = {
        name for name in c.__all__ if isinstance(getattr(c, name), type) and issubclass(getattr(c, name), Exception)
    }
    assert set(c.__all__) - errors - RESULTS - APART == {call.split(".")[0].split(",")[0] for call in CALLS | FILES}


def test_the_examples_are_good() -> None:
    for function, good in CALLS.values():
        for name in islice(good, 1):
            assert not refused_by_name(function, good, name, good[name])


def test_what_is_nothing_at_all_is_refused() -> None:
    for call, name in ARGUMENTS:
        for value in (object(), float("nan"), {1, 2}, 1j, c, "\0"):
            if (name, value) != ("source", "\0") and not (name == "gap" and isinstance(value, float)):
                assert refused_by_name(*CALLS[call], name, value), value


@pytest.mark.parametrize("call", [call for call, (_, good) in CALLS.items() if good])
@given(data=st.data())
def test_whatever_is_given_is_used_or_refused_by_its_name(call: str, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(CALLS[call][1])))
    anything = ANYTHING.filter(lambda value: not callable(value)) if name == "progress" else ANYTHING
    refused_by_name(*CALLS[call], name, data.draw(anything))


@pytest.mark.parametrize("kind", [kind for kind in KINDS.values() if issubclass(kind, Wall | Response)])
def test_numbers_that_no_contact_has_are_refused_or_solved_to_a_status(kind: type[Description]) -> None:
    """At the bounds of each argument, and far beyond: powers of them are numbers."""
    heights = Rough(8, lambda_s=4.0, lambda_L=8.0).heights()
    names = [name for name, value in made(kind).keywords().items() if isinstance(value, float)]
    for name, value in itertools.product(names, (1e-300, SMALLEST, LARGEST, 1e300, 2**70)):
        with warnings.catch_warnings(), suppress(ValueError):  # where it is refused
            warnings.simplefilter("ignore")
            one = kind.model_validate({**kind.example, name: value}, context={})
            parts = {"wall": one} if issubclass(kind, Wall) else {"wall": c.HardWall(), "substrate": one}
            assert c.Contact(heights, max_iterations=20, **parts).press(area=0.1).status


def test_what_is_no_name_of_a_file_or_no_setting_is_refused(folder: Path) -> None:
    for call, name in OF_FILES:
        for value in (object(), float("nan"), 1j, c, "\0"):
            if not (name in ("file", "result", "sweep") and value == "\0"):
                assert refused_by_name(*FILES[call], name, value), value
        assert {path.name for path in folder.iterdir()} == {"small.toml", "sweep.toml"}, "nothing was written"


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "sweep.toml").write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1, 2]\n')
    monkeypatch.chdir(tmp_path)
    return tmp_path
