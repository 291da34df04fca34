"""Every public object crosses to another process, and is copied: by the public names, of which none may be missing."""

from __future__ import annotations

import copy
import inspect
import pickle
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ase.calculators.emt import EMT

import atomistic as a
import continuum as c
from atomistic.response.force_constants import spring_force_constants
from tests.problems import SMALL, Rough
from tests.tasks import tasks_here

GRID = c.Grid.square(16)
HEIGHTS = Rough(16, lambda_s=8.0, lambda_L=16.0).heights()
CUBIC = (1.03, 0.515, 0.515)
KNOWN = {"size": "32nm", "unit": "nm", "contact_modulus": "1GPa", "work": "20mJ/m2", "range": "0.5nm", "solve": False}


@cache
def contact() -> c.Contact:
    return c.Contact(HEIGHTS, c.attraction_on_core("spline", 1e-4, 0.4, 5.0))


@cache
def result(folder: Path) -> c.Result:
    (folder / "small.toml").write_text(SMALL)
    return c.run(folder / "small.toml", folder / "small.h5")


@cache
def prediction() -> c.Prediction:
    return c.predict(np.random.default_rng(2).normal(size=(32, 32)), **KNOWN)


def study(folder: Path) -> c.Study:
    place = folder / "study"
    place.mkdir(exist_ok=True)
    for name in ("a_1", "a_2", "b_1"):
        np.savetxt(place / f"{name}.txt", np.random.default_rng(ord(name[-1])).normal(size=(32, 32)))
    return c.study(place, **KNOWN)


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process of its own is no part of what is asked."""
    monkeypatch.setattr("atomistic.front.validation.run_tasks", tasks_here)


@cache
def deck_run(folder: Path) -> a.DeckRun:
    return a.run_deck(a.Deck(SLAB, a.Springs(), FLAT, np.zeros((4, 5)), separation=1.2).write(folder / "deck"))


def _smallest(folder: Path) -> Path:
    (folder / "smallest.toml").write_text(
        '[interatomic]\nkind = "springs"\n[slab]\nn = 8\ndepth = 2.0\n'
        "[surface]\nhurst = 0.8\nlambda_s = 4.0\nlambda_L = 8.0\nseeds = [1]\n"
        '[[case]]\nname = "one"\nadhesion_length = 0.0\nrms_slopes = [0.1]\nareas = [0.3]\n'
    )
    return folder / "smallest.toml"


def copper() -> Any:
    found = SLAB.to_atoms(symbol="Cu", spacing=2.55)
    found.calc = EMT()
    return found


SLAB = a.Slab((4, 5), mobile=3)
FLAT = c.LennardJonesSpline(adhesion_length=0.005)
OBJECTS: Mapping[str, Callable[[Path], object]] = {
    "Contact": lambda folder: contact(),
    "State": lambda folder: contact().press(area=0.1),
    "LoadingPath": lambda folder: contact().path(mean_gap=[1.0, 0.5]),
    "FoundThreshold": lambda folder: contact().threshold(
        lambda work: c.attraction_on_core("spline", work, 0.4, 5.0), area=0.1
    ),
    "Prediction": lambda folder: prediction(),
    "Study": study,
    "Result": result,
    "Analysis": lambda folder: result(folder).analyse(),
    "Certificate": lambda folder: c.certify(folder / "small.h5") if result(folder) else None,
    "Grid": lambda folder: GRID,
    "SelfAffine": lambda folder: c.SelfAffine(0.8, 0.1, 4.0, 16.0),
    "HalfSpace": lambda folder: c.HalfSpace(),
    "Layer": lambda folder: c.Layer(4.0, 0.4, "clamped"),
    "CubicLayer": lambda folder: c.CubicLayer(4.0, CUBIC, "clamped"),
    "LayeredHalfSpace": lambda folder: c.LayeredHalfSpace([(6.0, 1.0, 0.3)], (0.3, 0.4)),
    "NonPeriodicHalfSpace": lambda folder: c.NonPeriodicHalfSpace(),
    "TabulatedSubstrate": lambda folder: c.TabulatedSubstrate(c.HalfSpace().stiffness(GRID), (16.0, 16.0), "here"),
    "HardWall": lambda folder: c.HardWall(),
    "LennardJonesSpline": lambda folder: FLAT,
    "Exponential": lambda folder: c.Exponential(0.01, 0.3, 2.0),
    "InversePowers": lambda folder: c.InversePowers((9, 3), adhesion_length=0.01),
    "TabulatedWall": lambda folder: c.attraction_on_core("spline", 1e-3, 0.4, 5.0),
    "NotConvergedWarning": lambda folder: c.NotConvergedWarning("why"),
    "SweepTask": lambda folder: next(
        iter(c.sweep("inputs/sweep/figure1.toml", folder, workers=0, reduced=True).jobs())
    ),
    "NotConvergedError": lambda folder: c.NotConvergedError("why"),
    "StoreError": lambda folder: c.StoreError("why"),
    "ConfigError": lambda folder: _raised(lambda: c.check(_bad(folder))),
    "Slab": lambda folder: SLAB,
    "Springs": lambda folder: a.Springs(),
    "LennardJones": lambda folder: a.LennardJones(),
    "PairStyle": lambda folder: a.PairStyle("lj/cut", "Ne", 20.18, 8.0, 4.4, ("8.0",), (("*", "*", "0.003", "2.8"),)),
    "EmbeddedAtom": lambda folder: a.EmbeddedAtom.read(a.find_potential("Cu_u3.eam")),
    "LatticeResponse": lambda folder: a.LatticeResponse(SLAB, spring_force_constants(a.Springs())),
    "SlabResponse": lambda folder: a.SlabResponse.measure(copper(), EMT()),
    "GreensRelaxation": lambda folder: a.GreensRelaxation(copper(), logfile=None),
    "Deck": lambda folder: a.Deck(SLAB, a.Springs(), FLAT, np.zeros((4, 5)), separation=1.2),
    "DeckRun": lambda folder: deck_run(folder),
    "DeckCertificate": lambda folder: deck_run(folder).certify(),
    "Elastic": lambda folder: a.elastic(a.Springs()),
    "Validation": lambda folder: a.validate(_smallest(folder), folder / "validated", workers=1),
    "PotentialError": lambda folder: a.PotentialError("why"),
    "LammpsError": lambda folder: a.LammpsError("why"),
    "Round": lambda folder: a.Round((40, 40), radius=20),
    "Waves": lambda folder: a.Waves((40, 40), 0.0, ((0.1, 1, 0, 0.0),)),
    "WallInclude": lambda folder: _include(folder),
    "Trace": lambda folder: a.read_trace(_traced(folder)),
    "RoughWall": lambda folder: a.RoughWall(np.zeros((4, 5)), copper(), 0.9, FLAT, a0=2.55, contact_modulus=0.85),
}


def _include(folder: Path) -> a.WallInclude:
    tip = a.Round((40, 40), radius=20)
    return a.write_wall(tip, folder / "wall", law=FLAT, a0=2.55, contact_modulus=0.85)


def _traced(folder: Path) -> Path:
    (folder / "trace.txt").write_text("# units\n# step load\n0 1.0\n10 2.0\n")
    return folder / "trace.txt"


def _bad(folder: Path) -> Path:
    (folder / "bad.toml").write_text("[grid]\nn = -1\n")
    return folder / "bad.toml"


def _raised(call: Callable[[], object]) -> Exception:
    with pytest.raises(c.ConfigError) as caught:
        call()
    return caught.value


def test_every_public_class_has_an_object_here() -> None:
    public = {name for package in (c, a) for name in package.__all__ if inspect.isclass(getattr(package, name))}
    assert public == set(OBJECTS)


@pytest.mark.parametrize("name", OBJECTS)
def test_an_object_is_the_same_after_pickle_and_copies(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    made = OBJECTS[name](tmp_path_factory.getbasetemp())
    for there_and_back in (lambda one: pickle.loads(pickle.dumps(one)), copy.copy, copy.deepcopy):
        found = there_and_back(made)
        assert type(found) is type(made)
        same(made, found, name)


def same(one: Any, other: Any, where: str, depth: int = 6) -> None:
    """Both have the same numbers, texts and arrays, however deep; what is neither is of the same class."""
    assert type(one) is type(other), where
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other, err_msg=where)
    elif isinstance(one, str | bytes | int | float | bool | complex | Path | None):
        assert one == other or one != one, where
    elif isinstance(one, Mapping):
        assert list(one) == list(other), where
        for key in one:
            same(one[key], other[key], f"{where}[{key}]", depth - 1)
    elif isinstance(one, list | tuple):
        assert len(one) == len(other), where
        for i, (left, right) in enumerate(zip(one, other, strict=True)):
            same(left, right, f"{where}[{i}]", depth - 1)
    elif depth and hasattr(one, "__dict__") and not callable(one):
        assert vars(one).keys() <= vars(other).keys() or vars(one).keys() >= vars(other).keys(), where
        for key in vars(one).keys() & vars(other).keys():
            same(vars(one)[key], vars(other)[key], f"{where}.{key}", depth - 1)
