"""Every law of the continuum as LAMMPS evaluates it: formulas against the law, energy against force."""

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

import atomistic as a
from atomistic.cli import main
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck
from atomistic.lammps.directory import write_deck
from atomistic.lammps.engine import run_in_process
from atomistic.lammps.law import LAWS, PIECES, native_law, read_wall_table
from continuum.model.walls import Exponential, InversePowers, LennardJonesSpline, Wall
from continuum.model.walls.tabulated import TabulatedWall


def table(knots: int) -> TabulatedWall:
    """The paper's law with a dent, as somebody might have measured it."""
    gap = np.linspace(0.7, 1.4, knots)
    law = LennardJonesSpline(0.35).evaluate(gap).traction + 0.01 * np.sin(20 * gap) * (1.4 - gap) ** 2
    return TabulatedWall(gap, np.append(law[:-1], 0.0))


WALLS: dict[str, Wall] = {
    "spline": LennardJonesSpline(adhesion_length=0.005),
    "repulsive": LennardJonesSpline(0.0),
    "9-3": InversePowers((9, 3), adhesion_length=0.02),
    "12-6": InversePowers((12, 6), adhesion_length=0.02),
    "exponential": Exponential(0.01, 0.2, 3.0),
    "short table": table(24),
    "long table": table(1200),
}


def spread(wall: Wall) -> Deck:
    """A flat slab under heights that put every part of the law above some atom."""
    slab = Slab((8, 9), mobile=2)
    end = min(wall.reach, wall.zero_gap + 1.5)
    start = wall.core - 0.05 if np.isfinite(wall.core) else wall.zero_gap - 0.2
    gaps = np.linspace(start, end + 0.1, 72).reshape(slab.shape)
    return Deck(slab, Springs(), wall, gaps - 1.0, 1.0, tolerance=1e9)


@pytest.mark.parametrize("name", WALLS)
def test_the_formulas_are_the_law(tmp_path, name):
    deck = spread(WALLS[name])
    wall = deck.wall
    result = run_in_process(write_deck(tmp_path, deck))
    law = wall.evaluate(result.gap)
    stated = native_law(wall).error
    text = (tmp_path / "wall.table").read_text()
    assert f"differ from the law by at most {stated:.1e} E*" in text
    # Formulas: rounding of powers up to 13 of a gap known to 1e-16.  Tables: what they state, between the points where
    # it was measured, 20 to a piece, hardly more.
    allowed = 1.1 * stated + 1e-10 * np.abs(law.traction).max()
    assert np.abs(result.traction - law.traction).max() <= allowed
    assert (stated == 0) == (not isinstance(wall, TabulatedWall))
    assert result.force == pytest.approx(law.traction.sum(), abs=72 * allowed)
    assert result.wall_energy == pytest.approx(law.energy.sum(), abs=72 * allowed)


@pytest.mark.parametrize(("knots", "error"), [(24, 1e-12), (PIECES + 1, 1e-12), (1200, 1e-5)])
def test_a_table_is_exact_while_it_is_short_and_else_states_its_error(knots, error):
    wall = table(knots)
    native = native_law(wall)
    # 1e-5 of a traction of 3: the knots are put where the error is largest.
    assert native.error < error
    assert native.lines.count("ternary(v_gap<") < 2 * 2 * (PIECES + 1)


@pytest.mark.parametrize("name", ["12-6", "exponential", "long table"])
def test_the_energy_belongs_to_the_force(tmp_path, name):
    deck = spread(WALLS[name])
    force = run_in_process(write_deck(tmp_path, deck)).traction.sum()

    def energy(step: float) -> float:
        return run_in_process(write_deck(tmp_path, replace(deck, separation=1.0 + step), force=True)).wall_energy

    # Error h²/6 times the third derivative of the energy, about 1e3 per atom near the core; a kink of the table's
    # curvature costs h times its size.
    slope = (energy(1e-5) - energy(-1e-5)) / 2e-5
    assert slope == pytest.approx(-force, rel=1e-6)


@pytest.mark.parametrize("name", ["9-3", "exponential", "short table"])
def test_the_written_table_is_the_law(tmp_path, name):
    wall = WALLS[name]
    write_deck(tmp_path, spread(wall))
    gap, energy, traction = np.loadtxt(tmp_path / "wall.table", unpack=True)
    law = wall.evaluate(gap)
    assert np.allclose(traction, law.traction, rtol=0, atol=1e-15 * np.abs(traction).max())
    assert np.allclose(energy, law.energy, rtol=0, atol=1e-15 * np.abs(energy).max())
    if isinstance(wall, TabulatedWall):
        assert (read_wall_table(tmp_path / "wall.table").gap == wall.gap).all()


@dataclass(frozen=True)
class Newcomer(Exponential):
    """A law that is added to the table of formulas, and nowhere else."""


def test_a_new_law_is_written_and_read_by_its_line_in_one_table(tmp_path, monkeypatch):
    wall = Newcomer(0.01, 0.2, 3.0)
    with pytest.raises(TypeError, match="the wall law Newcomer cannot act in a deck"):
        native_law(wall)
    monkeypatch.setitem(LAWS, Newcomer, LAWS[Exponential])
    run_in_process(write_deck(tmp_path / "new", spread(wall)))
    assert a.read(tmp_path / "new").wall == wall


@pytest.mark.parametrize("name", WALLS)
def test_the_law_of_a_run_is_read_back(tmp_path, name):
    run_in_process(write_deck(tmp_path, spread(WALLS[name])))
    wall = a.read(tmp_path).wall
    gap = np.linspace(0.5, 2.5, 100)
    assert type(wall) is type(WALLS[name])
    for found, written in zip(wall.evaluate(gap), WALLS[name].evaluate(gap), strict=True):
        assert (found == written).all()


@pytest.mark.parametrize(
    ("wall", "message"),
    [
        ({"law": "Morse", "depth": 1.0}, "'Morse' is not one that this version reads"),
        ({"law": "LennardJonesSpline", "depth": 1.0}, "depth"),
        ({"law": "LennardJonesSpline", "range": -1.0}, "range = -1.0"),
        ({}, "law"),
    ],
)
def test_a_law_that_cannot_be_read_is_one_message(tmp_path, capsys, wall, message):
    run_in_process(write_deck(tmp_path, spread(WALLS["spline"])))
    description = json.loads((tmp_path / "deck.json").read_text())
    (tmp_path / "deck.json").write_text(json.dumps(description | {"wall": wall}))
    assert main(["read", str(tmp_path), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error
    assert not (tmp_path / "out").exists()
