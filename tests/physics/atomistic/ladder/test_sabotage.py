"""Ten faults in one rung each: the verdict that is made for it finds it, and holds without it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from atomistic.crystal.interatomic import Springs
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import archive, budget, comparison, rungs
from atomistic.ladder.budget import checks_of
from atomistic.ladder.comparison import compare_on_path, paths_of
from atomistic.lammps import law
from atomistic.lammps.deck import Deck
from atomistic.lammps.engine import runner
from atomistic.relax.specimen import specimen_of
from atomistic.response import lattice
from atomistic.response.force_constants import ForceConstants, spring_force_constants
from continuum.inputs.reading import load
from continuum.model.substrates import CubicLayer, HalfSpace, Layer
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.walls import LennardJonesSpline
from tests.problems import validation_input

INPUT = validation_input(
    32,
    16.0,
    [2],
    """
[[case]]
name = "plain"
adhesion_length = 0.0
rms_slopes = [0.1]
areas = [0.25]
""",
)
"""A case of the ensemble, on a surface that is not in it."""
LAWS = {f"{length}": LennardJonesSpline(adhesion_length=length) for length in (0.0, 0.005, 0.05)}
Patch = Callable[[pytest.MonkeyPatch], None]


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> ValidateConfig:
    path = tmp_path_factory.mktemp("input") / "input.toml"
    path.write_text(INPUT)
    return load(path, ValidateConfig)


@pytest.fixture(scope="module", autouse=True)
def another_worker() -> Iterator[None]:
    comparison._specimens_of_worker.cache_clear()
    yield
    comparison._specimens_of_worker.cache_clear()


def checked(config: ValidateConfig) -> dict[str, np.ndarray]:
    found = archive.datasets_of_checks(checks_of(specimen_of(config), LAWS, runner(None)))
    return {name: dataset.values for name, dataset in found.items()}


def compared(config: ValidateConfig) -> dict[str, np.ndarray]:
    with pytest.MonkeyPatch.context() as patch:
        # Signed parts have no verdict, and take as long as all else.
        patch.setattr(rungs, "loads_at_area", lambda *_: {})
        result = compare_on_path(config, replace(paths_of(config)[0], curves=False))
    return {name: dataset.values for name, dataset in archive.datasets_of([result]).items()}


@pytest.fixture(scope="module")
def columns(config: ValidateConfig) -> dict[str, np.ndarray]:
    """The run without a fault."""
    return compared(config) | checked(config)


def test_without_a_fault_every_step_is_judged_and_holds(config: ValidateConfig, columns: dict[str, np.ndarray]) -> None:
    verdicts = list(budget.bound_verdicts(config, columns))
    assert all(verdict.holds for verdict in verdicts), [verdict.told for verdict in verdicts if not verdict.holds]
    steps = {"depth", "anisotropy", "discreteness", "nonlinearity", "total"}
    assert {v.step for v in verdicts} == steps | {"equilibrium", "crystal", "half-space", "law"}
    # Each compares what differs, and none allows that a load is wrong by a tenth.
    loads = [verdict for verdict in verdicts if verdict.step in steps and verdict.quantity != "displacement"]
    assert all(verdict.measured > 0 and verdict.limit * verdict.scale < 0.1 for verdict in loads)


def half_space_stiffer_by(part: float) -> Patch:
    def patch(monkeypatch: pytest.MonkeyPatch) -> None:
        sound = HalfSpace.stiffness
        monkeypatch.setattr(HalfSpace, "stiffness", lambda self, grid: (1 + part) * sound(self, grid))

    return patch


def stiffer_crystal(monkeypatch: pytest.MonkeyPatch) -> None:
    def layer(depth: float, constants: CubicConstants, mean: float) -> CubicLayer:
        return CubicLayer(depth, CubicConstants(*(1.2 * each for each in constants)), mean)

    monkeypatch.setattr(rungs, "CubicLayer", layer)


def with_force_constants(of_surface: float, of_bulk: float) -> Patch:
    """Force constants of the lattice times a number, in its uppermost layer and everywhere."""

    def patch(monkeypatch: pytest.MonkeyPatch) -> None:
        def changed(springs: Springs, mobile: int) -> ForceConstants:
            sound = spring_force_constants(springs)
            return replace(sound, surface=of_surface * sound.surface, bulk=of_bulk * sound.bulk)

        monkeypatch.setattr(lattice, "spring_force_constants", lambda springs: changed(springs, 0))
        monkeypatch.setattr(lattice, "force_constants", changed)
        comparison._specimens_of_worker.cache_clear()

    return patch


def softer_atoms(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = Springs.interactions
    number = f"{Springs().stiffness / 2:.17g}"
    assert number in sound(Springs())
    monkeypatch.setattr(
        Springs, "interactions", lambda self: sound(self).replace(number, f"{0.45 * Springs().stiffness:.17g}")
    )
    comparison._specimens_of_worker.cache_clear()


def stickier_law(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = law.LAWS[LennardJonesSpline]
    monkeypatch.setitem(
        law.LAWS,
        LennardJonesSpline,
        lambda wall, tolerance: sound(LennardJonesSpline(adhesion_length=1.05 * wall.work_of_adhesion), tolerance),
    )
    law._native_law.cache_clear()


FAULTS: dict[str, tuple[str, Patch]] = {
    "the half-space is 2 % too stiff": ("half-space", half_space_stiffer_by(0.02)),
    "the crystal is turned by 45 degrees": (
        "crystal",
        lambda monkeypatch: monkeypatch.setattr(rungs, "CubicLayer", partial(CubicLayer, axis=0.0)),
    ),
    "the lattice is 2 % too soft": ("crystal", with_force_constants(0.98, 0.98)),
    "the law of the atoms is 5 % stickier": ("law", stickier_law),
    "the half-space is 20 % too stiff": ("total", half_space_stiffer_by(0.2)),
    "the layer has half its depth": (
        "depth",
        lambda monkeypatch: monkeypatch.setattr(rungs, "Layer", lambda depth, *others: Layer(depth / 2, *others)),
    ),
    "the crystal is 20 % too stiff": ("anisotropy", stiffer_crystal),
    "the uppermost layer of the lattice is half as stiff": ("discreteness", with_force_constants(0.5, 1.0)),
    "the springs of the atoms are 10 % too soft": ("nonlinearity", softer_atoms),
    "the atoms are not relaxed": (
        "equilibrium",
        lambda monkeypatch: monkeypatch.setattr(
            comparison, "Deck", lambda *given, tolerance, **named: Deck(*given, tolerance=1e5 * tolerance, **named)
        ),
    ),
}
"""Each fault, with the step or check whose verdict is made for it."""


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found_by_the_verdict_that_is_made_for_it(
    fault: str, config: ValidateConfig, columns: dict[str, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    made_for, patch = FAULTS[fault]
    patch(monkeypatch)
    # A check needs no run, and what it does not look at is that of the sound ladder.
    anew = checked(config) if made_for in ("half-space", "crystal", "law") else compared(config)
    verdicts = budget.bound_verdicts(config, columns | anew)
    assert made_for in {verdict.step for verdict in verdicts if not verdict.holds}
    law._native_law.cache_clear()
    comparison._specimens_of_worker.cache_clear()
