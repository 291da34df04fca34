"""Equilibria of decks, evaluated by other means than LAMMPS': sound ones are found sound, forged ones are told."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.cli import main
from atomistic.crystal.model import Potential
from atomistic.lammps.result import DeckError, read_result
from continuum.model.walls import Wall

GRID = c.Grid.square(8)
HEIGHTS = c.SelfAffine(0.8, 0.1, 4, 8).synthesise(GRID, np.random.default_rng(3))
LAW = c.LennardJonesSpline(adhesion_length=0.005)
GAPS = np.linspace(0.8, 1.5, 60)
CONTACT = c.Contact(HEIGHTS, LAW)


@pytest.fixture(scope="module")
def stairs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two equilibria on springs, of which the second touches."""
    deck = a.deck(CONTACT, separations=[1.3, 1.1], depth=5).write(tmp_path_factory.mktemp("decks") / "stairs")
    a.run_deck(deck)
    return deck


def test_equilibria_on_springs_are_sound(stairs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = a.read(stairs).certify()
    assert found.ok
    assert [one.stored.step for one in found.steps] == [1, 2]
    touching = found.steps[1]
    assert touching.area_rep > 0.05
    assert touching.load == pytest.approx(touching.stored_load, rel=1e-9)
    # Short waves of springs are stiff: of the order of k_s.
    assert 0.1 < touching.curvature < 10
    assert main(["read", str(stairs), "--certify", "-o", str(tmp_path)]) == 0
    assert "2 equilibria of atoms" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("model", "wall"),
    [
        (a.LennardJones(), LAW),
        (a.Springs(), c.InversePowers((9, 3), adhesion_length=0.005)),
        (a.Springs(), c.TabulatedWall(GAPS, np.where(LAW.reach > GAPS, LAW.evaluate(GAPS).traction, 0.0))),
    ],
    ids=["lennard-jones crystal", "9-3", "table"],
)
def test_other_crystals_and_laws_are_sound(model: Potential, wall: Wall, tmp_path: Path) -> None:
    deck = a.deck(c.Contact(HEIGHTS, wall), model, separation=1.1, depth=6).write(tmp_path / "deck")
    a.run_deck(deck)
    found = a.read(deck).certify()
    assert len(found.steps) == 1
    assert found.ok, found.faults


def _forged(stairs: Path, tmp_path: Path) -> Path:
    return shutil.copytree(stairs, tmp_path / "forged")


def test_an_atom_that_was_moved_is_told(stairs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    forged = _forged(stairs, tmp_path)
    state = forged / "state.2.dump"
    lines = state.read_text().splitlines()
    words = lines[9].split()
    place = lines[8].split()[2:].index("Displacement.X")
    words[place] = repr(float(words[place]) + 1e-4)
    lines[9] = " ".join(words)
    state.write_text("\n".join(lines) + "\n")
    (fault,) = a.read(forged).certify().faults
    assert "step 2: the largest force is" in fault
    assert main(["read", str(forged), "--certify", "-o", str(tmp_path / "results")]) == 1
    assert "largest force" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "said"), [("load", "N/A0 is"), ("area_rep", "area_rep/A0 is")])
def test_a_number_that_was_changed_is_told(name: str, said: str, stairs: Path, tmp_path: Path) -> None:
    forged = _forged(stairs, tmp_path)
    result = forged / "result.2.json"
    numbers = json.loads(result.read_text())
    numbers[name] *= 1.01
    result.write_text(json.dumps(numbers))
    (fault,) = a.read(forged).certify().faults
    assert said in fault


def test_steps_that_are_no_equilibria_are_left_out(stairs: Path, tmp_path: Path) -> None:
    forged = _forged(stairs, tmp_path)
    result = forged / "result.2.json"
    result.write_text(json.dumps({**json.loads(result.read_text()), "largest_force": 1.0}))
    assert not read_result(forged, 2).status.ok
    assert [one.stored.step for one in a.read(forged).certify().steps] == [1]


def test_what_cannot_be_certified_is_refused_with_the_reason(tmp_path: Path) -> None:
    flat = c.Contact(c.sine(c.Grid.square(4), 0.01, (1, 0)), LAW)
    follows = a.deck(flat, separation=1.2, depth=3, follows="atom").write(tmp_path / "atom")
    a.run_deck(follows)
    with pytest.raises(DeckError, match="follows the atoms"):
        a.read(follows).certify()
    moving = {"kind": "velocity", "separations": [1.3, 1.25], "velocity": 0.01, "temperature": 1e-5, "window": 5.0}
    motion = a.deck(flat, depth=3, protocol=moving).write(tmp_path / "motion")
    a.run_deck(motion)
    with pytest.raises(DeckError, match="windows of a motion"):
        a.read(motion).certify()
