"""What an input of atoms is said to cost, beside what it took."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import atomistic as a
from atomistic.front.cli import main
from atomistic.inputs.crystal import Interatomic
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.motion import ProtocolTable
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import cost as costs
from atomistic.ladder.cost import _SEEN, cost_of_deck, cost_of_validation, reached
from continuum.inputs.reading import load
from continuum.model.walls import InversePowers, LennardJonesSpline, Wall

DECKS = sorted(Path("inputs/lammps").glob("*.toml"))
QUICK = ("rough", "cylinder", "staircase", "punch")


def test_there_is_a_cost_for_each_crystal_and_an_input_for_each_protocol() -> None:
    """By the registries: a new kind is estimated by `atomistic check`, and runs from an input that comes with it."""
    assert Interatomic.kinds.keys() <= _SEEN.keys()
    inputs = [load(path, DeckConfig) for path in DECKS]
    assert {config.interatomic.kind for config in inputs} == set(Interatomic.kinds)
    assert {config.protocol.kind for config in inputs if config.protocol} == set(ProtocolTable.kinds)


def told(path: Path) -> tuple[float, float, float]:
    """Core-seconds, evaluations and atoms in the head of an input, as they were measured."""
    found = re.search(r"# Cost +([\d.]+) core-seconds?, ([\d ]+) force evaluations of ([\d ]+) atoms", path.read_text())
    assert found is not None
    seconds, evaluations, atoms = (float(number.replace(" ", "")) for number in found.groups())
    return seconds, evaluations, atoms


def within(found: float, expected: float, factor: float = 2.0) -> bool:
    return expected / factor <= found <= expected * factor


# "To within a factor of about two" is what the estimate says of itself; what was measured once stands in the inputs.
@pytest.mark.parametrize("path", DECKS, ids=lambda path: path.stem)
def test_the_cost_of_a_deck_is_what_its_input_says_that_it_took(path: Path) -> None:
    seconds, evaluations, atoms = told(path)
    cost = cost_of_deck(load(path, DeckConfig))
    assert within(cost.atoms, atoms, 1.1)
    assert within(cost.evaluations, evaluations)
    assert within(cost.seconds, seconds)


LAYERS = {
    # The spline ends 0.35, 0.69 and 1.10 a0 beyond its gap without traction, layers are 0.71 a0 apart.
    "short spline": (LennardJonesSpline(adhesion_length=0.005), 1),
    "spline that just does not reach the second layer": (LennardJonesSpline(adhesion_length=0.02), 1),
    "spline that does": (LennardJonesSpline(adhesion_length=0.05), 2),
    "9-3, to 10 a0": (InversePowers((9, 3), 0.02), 15),
}


@pytest.mark.parametrize(("wall", "layers"), LAYERS.values(), ids=LAYERS)
def test_the_estimate_counts_the_layers_that_the_law_reaches(wall: Wall, layers: int) -> None:
    config = load(Path("inputs/lammps/cylinder.toml"), DeckConfig).model_copy(update={"wall": wall})
    surface, cost = config.grid.shape[0] * config.grid.shape[1], cost_of_deck(config)
    assert reached(config, cost.atoms) == layers * surface
    # Of a thin slab all atoms.
    assert reached(config, surface // 2) == surface // 2
    without = cost_of_deck(config.model_copy(update={"wall_force": "plugin"}))
    in_pieces = layers > 1
    each = _SEEN["formula"] * layers * surface + in_pieces * _SEEN["pieces"]
    assert cost.seconds - without.seconds == pytest.approx(cost.evaluations * each, rel=1e-9)


def test_a_large_deck_tells_its_cost_first_and_its_progress(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["deck", "inputs/lammps/copper-111.toml", "-o", str(tmp_path / "small")]
    assert main(words) == 0
    assert "cost" not in capsys.readouterr().out
    monkeypatch.setattr(costs, "LARGE", 200)
    assert main([*words[:-1], str(tmp_path / "large")]) == 0
    first, *lines = capsys.readouterr().out.splitlines()
    found = re.search(r"cost +about ([\d.e+]+) atoms: ([\d.e-]+) core-seconds and ([\d.]+) GB", first)
    assert found is not None
    # Without the base, which is not known before the crystal has been measured; printed to two digits.
    assert within(float(found[1]), 2**0.5 * 8 * 8.66 * 3, 1.05)
    told = [found[1] for line in lines if (found := re.search(r"tables of atoms (\d)/5", line))]
    assert list(dict.fromkeys(told)) == list("012345")


@pytest.mark.parametrize("path", sorted(Path("inputs/validate").glob("*.toml")), ids=lambda path: path.stem)
def test_the_atoms_and_equilibria_of_a_validation_are_those_of_its_input(path: Path) -> None:
    said = re.search(r"([\d ]+) atoms, (\d+) equilibria", path.read_text())
    assert said is not None
    atoms, states = said.groups()
    cost = cost_of_validation(load(path, ValidateConfig))
    assert within(cost.atoms, float(atoms.replace(" ", "")), 1.1)
    assert cost.equilibria == int(states)


def test_check_says_what_it_costs_and_what_it_is_for(capsys: pytest.CaptureFixture[str]) -> None:
    for path, words in (
        ("inputs/validate/quick.toml", "atomistic validate"),
        ("inputs/lammps/rough.toml", "atomistic deck"),
        ("inputs/crystals/copper.toml", "atomistic elastic"),
    ):
        assert main(["check", path]) == 0
        out = capsys.readouterr().out
        assert words in out
        assert "core-seconds" in out
        assert path != "inputs/validate/quick.toml" or re.search(
            r"work of adhesion, strong-adhesion +0\.005 E\* a0", out
        )
    assert main(["check", "nope.toml"]) == 2


@pytest.mark.long
@pytest.mark.parametrize("name", QUICK)
def test_a_deck_takes_as_many_evaluations_as_it_is_said_to_take(name: str, tmp_path: Path) -> None:
    path = Path(f"inputs/lammps/{name}.toml")
    cost = cost_of_deck(load(path, DeckConfig))
    run = a.run_deck(a.deck(path).write(tmp_path / name))
    assert within(sum(step.evaluations for step in run.steps), cost.evaluations)
