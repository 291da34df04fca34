"""Equilibria of decks, evaluated by other means than LAMMPS': sound ones are found sound, forged ones are told."""

from __future__ import annotations

import json
import shutil
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.crystal.model import Potential
from atomistic.front.cli import main
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.result import DeckError, DeckResult, read_result
from atomistic.lammps.session import Session
from atomistic.relax.certify import wall_checks
from atomistic.relax.relax import lattice_start
from continuum.model.walls import Wall
from tests.problems import lattice

GRID = c.Grid.square(8)
HEIGHTS = c.SelfAffine(0.8, 0.1, 4, 8).synthesise(GRID, np.random.default_rng(3))
LAW = c.LennardJonesSpline(adhesion_length=0.005)
GAPS = np.linspace(0.8, 1.5, 60)
CONTACT = c.Contact(HEIGHTS, LAW)


@pytest.fixture(autouse=True)
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atomistic.show.decks.save_figure", lambda _, stem: stem)


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
    assert touching.stored.area_rep > 0.05
    assert touching.found_of("force") == pytest.approx(touching.stored.force, rel=1e-9)
    # The softest waves shear the slab: about C44 π²/(4 M²).
    assert 0.1 * 7**-2 < touching.found_of("curvature") < 10 * 7**-2
    assert {"evaluations", "lammps_version", "total_energy"} <= set(touching.left_out)
    assert main(["read", str(stairs), "--certify", "-o", str(tmp_path)]) == 0
    assert "2 of 2 equilibria of atoms" in capsys.readouterr().out


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
    assert any("step 2: recomputed largest force is" in fault for fault in a.read(forged).certify().faults)
    assert main(["read", str(forged), "--certify", "-o", str(tmp_path / "results")]) == 1
    assert "largest force" in capsys.readouterr().err


def test_a_number_that_was_changed_is_told_or_listed(stairs: Path, tmp_path: Path) -> None:
    forged = _forged(stairs, tmp_path)
    result, names = forged / "result.2.json", {"load": "force"}
    numbers, sound = json.loads(result.read_text()), a.read(stairs).certify().steps[1]
    judged = {check.quantity for check in sound.checks}
    looked_at = [name for name in numbers if names.get(name, name) in judged]
    assert {"load", "area_rep", "area_att", "wall_energy", "smallest_gap"} <= set(looked_at)
    columns = {one.name for one in fields(DeckResult) if one.metadata}
    assert columns <= judged | set(sound.left_out)
    for name in looked_at:
        result.write_text(json.dumps({**numbers, name: 1.01 * numbers[name] or 1e-3}))
        found = read_result(forged, 2)
        below = found.separation + HEIGHTS - found.displacements[0, ..., 2]
        checks = wall_checks(LAW, LAW, found, below[None], 0.0)
        assert [check.quantity for check in checks if not check.ok] == [names.get(name, name)]


def test_the_saddle_of_a_flat_wall_is_told(tmp_path: Path) -> None:
    """The uniform state in the middle of an attraction that is softer than the slab is stiff: it keeps its symmetry."""
    law, response = c.LennardJonesSpline(adhesion_length=0.02), lattice(4, "springs", 16.0)
    gap = np.full((4, 4), 1.465)
    stiffness = law.evaluate(gap[0, 0]).stiffness
    assert response.stiffness_q[0, 0] < 0.7 * -stiffness
    flat = np.zeros((4, 4))
    start = lattice_start(response, law, gap)
    write_deck(tmp_path, Deck(response.slab, a.Springs(), law, flat, 2.0, start, rise=response.rise))
    with Session(tmp_path) as crystal:  # under the traction of this gap, which holds the state
        for _ in range(20):
            forces = crystal.evaluate(start)[1]
            forces[0, ..., 2] -= law.evaluate(gap).traction
            start = start + response.displacements(forces)
    separation = float(1.465 + start[0, ..., 2].mean())
    deck = Deck(response.slab, a.Springs(), law, flat, separation, start, rise=response.rise)
    write_deck(tmp_path, deck, force=True)
    a.run_deck(tmp_path)
    found = a.read(tmp_path).certify()
    (fault,) = found.faults
    assert "curvature is -0.0" in fault
    assert "saddle point" in fault
    assert found.steps[0].stored.mean_gap == pytest.approx(1.465, abs=1e-6)


def test_steps_that_are_no_equilibria_are_left_out(stairs: Path, tmp_path: Path) -> None:
    forged = _forged(stairs, tmp_path)
    result = forged / "result.2.json"
    result.write_text(json.dumps({**json.loads(result.read_text()), "largest_force": 1.0}))
    assert not read_result(forged, 2).status.ok
    found = a.read(forged).certify()
    assert [one.stored.step for one in found.steps] == [1]
    assert "step 2" in found.unconverged[0]
    assert found.ok
    first = forged / "result.1.json"
    first.write_text(json.dumps({**json.loads(first.read_text()), "largest_force": 1.0}))
    found = a.read(forged).certify()
    assert not found.ok
    assert "nothing was looked at" in found.faults[0]


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
