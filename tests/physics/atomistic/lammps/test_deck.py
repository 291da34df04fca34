import hashlib
import json
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import INPUTS, Deck, render, write_deck
from atomistic.lammps.directory import read_heights, read_slab
from atomistic.lammps.engine import run_in_process, script
from atomistic.lammps.law import read_wall_table
from atomistic.lammps.result import LammpsError, tail
from continuum.inputs.errors import OutputError
from continuum.model.walls import HardWall, LennardJonesSpline

SLAB = Slab((4, 5), mobile=3)
ADHESIVE = LennardJonesSpline(adhesion_length=0.005)


def make_deck(**changes) -> Deck:
    rng = np.random.default_rng(3)
    start = 0.01 * rng.standard_normal((4, 4, 5, 3))
    start[SLAB.mobile :] = 0
    deck = Deck(SLAB, Springs(), ADHESIVE, rng.standard_normal((4, 5)), 1.1 / 3, start)
    return replace(deck, **changes)


def section(text: str, name: str) -> np.ndarray:
    """Numbers of a section of a data file."""
    lines = text.split(f"\n{name}\n\n", 1)[1].split("\n\n", 1)[0].splitlines()
    return np.array([[float(word) for word in line.split()] for line in lines])


def values_of_atoms(path: Path) -> list[np.ndarray]:
    """Atoms and values of each set of an atomfile."""
    lines, found = [line for line in path.read_text().splitlines() if not line.startswith("#")], []
    while lines:
        count, lines = int(lines[0]), lines[1:]
        found.append(np.array([[float(word) for word in line.split()] for line in lines[:count]]))
        lines = lines[count:]
    return found


def test_the_files_of_the_atoms_hold_every_number_to_its_last_digit(tmp_path):
    deck = make_deck()
    write_deck(tmp_path, deck)
    atoms = section((tmp_path / "slab.data").read_text(), "Atoms # bond")
    assert (atoms[:, 0] == SLAB.ids.ravel()).all()
    assert (atoms[:, 3:] == SLAB.positions.reshape(-1, 3)).all()
    (heights,), start = values_of_atoms(tmp_path / "wall.heights"), values_of_atoms(tmp_path / "slab.start")
    assert (heights[: SLAB.ids[0].size, 1] == deck.heights.ravel()).all()
    assert (heights == np.column_stack([SLAB.ids[:3].ravel(), deck.above])).all()  # of all that move
    assert (np.array(start)[..., 0] == SLAB.ids[:3].ravel()).all()
    assert (np.array(start)[..., 1] == deck.start[:3].reshape(-1, 3).T).all()
    assert np.ptp(deck.start) > 0


def test_the_script_is_complete_and_holds_the_numbers_of_the_deck():
    deck = make_deck(tolerance=3e-12, evaluations=77)
    texts = render(deck)
    others = {
        "slab.data",
        "slab.start",
        "wall.heights",
        "deck.json",
        "in.motion",
        "stiffness.npy",
        "input.toml",
        "wall.npy",
    }
    of_other_walls = {"heightmap.cpp", "heightmap.so", "wall.map", "wall.data", "in.place"}
    assert {*texts, *others, *of_other_walls} == set(INPUTS)
    assert not [name for name, text in texts.items() if "@{" in text or "np.float64" in text]
    assert f"variable        separation index {deck.separation:.17g} " in texts["in.contact"]
    assert float(texts["in.slab"].split("variable        tolerance index ")[1].split()[0]) == 3e-12
    assert "evaluations index 77 " in texts["in.slab"]
    assert f"bond_coeff      1 {Springs().stiffness / 2:.17g} 1\n" in texts["in.slab"]
    assert "surface id <= 20\n" in texts["in.slab"]
    assert "mobile id <= 60\n" in texts["in.slab"]
    assert texts == render(make_deck(tolerance=3e-12, evaluations=77))


@pytest.mark.parametrize("wall", [ADHESIVE, LennardJonesSpline(0.0), LennardJonesSpline(1.1, 0.3, core=0.8)])
def test_the_table_is_the_law_within_the_error_that_it_states(tmp_path, wall):
    directory = write_deck(tmp_path / "deck", make_deck(wall=wall))
    table = read_wall_table(directory / "wall.table")
    stated = float((directory / "wall.table").read_text().split("errs by at most ")[1].split()[0])
    assert 0 < stated < 1e-6
    gap = np.random.default_rng(4).uniform(wall.core, 1.2 + wall.range, 5000)
    error = np.abs(table.evaluate(gap).traction - wall.evaluate(gap).traction)
    # The statement is of the middles between knots: elsewhere the error is hardly larger.
    assert error.max() < 1.5 * stated
    column = np.loadtxt(directory / "wall.table")[:, 1]
    assert np.allclose(column, wall.evaluate(table.gap).energy, rtol=0, atol=1e-15)
    # The energy of the table is the integral of its traction.
    error = np.abs(table.evaluate(gap).energy - wall.evaluate(gap).energy)
    assert error.max() < 1.5 * stated * np.ptp(table.gap)


def test_the_slab_is_read_back(tmp_path):
    directory = write_deck(tmp_path / "deck", make_deck())
    assert read_slab(directory / "slab.data") == SLAB
    (directory / "slab.data").write_text("LAMMPS data file\n")
    with pytest.raises(ValueError, match=r"not the slab\.data of a deck"):
        read_slab(directory / "slab.data")


@pytest.mark.parametrize(
    "title",
    [
        "fcc(100) slab of 4 x 5 atoms x (3 mobile + 1 frozen) layers",
        "bcc(100) slab of 4 x 5 atoms x (3 mobile + 1 frozen) layers, at rest",
        "fcc(110) slab of 4 x 5 atoms x (3 mobile + 1 frozen) layers, at rest",
        "fcc(100) slab of 4 x 5 atoms x (3 mobile + 1 frozen) layers, at rest at 300",
        "fcc(100) slab of 4 x 5 atoms x (3 mobile) layers, at rest",
    ],
)
def test_a_slab_of_any_other_title_is_not_read(tmp_path, title):
    directory = write_deck(tmp_path / "deck", make_deck())
    text = (directory / "slab.data").read_text()
    (directory / "slab.data").write_text("\n".join([title, *text.splitlines()[1:]]))
    with pytest.raises(ValueError, match=r"not the slab\.data of a deck"):
        read_slab(directory / "slab.data")


def test_the_heights_of_a_slab_longer_than_wide_are_read_back(tmp_path):
    heights = np.random.default_rng(3).normal(size=SLAB.shape)
    directory = write_deck(tmp_path / "deck", make_deck(heights=heights))
    assert (read_heights(directory / "slab.data") == heights).all()


def test_the_log_that_is_shown_is_the_one_written_last(tmp_path):
    for age, name in enumerate(("log.3.lammps", "log.1.lammps", "log.2.lammps")):
        (tmp_path / name).write_text("\n".join(f"{name} {line}" for line in range(20)))
        os.utime(tmp_path / name, (1e9 - age, 1e9 - age))
    said = tail(tmp_path).splitlines()
    assert said[:2] == ["", "Last lines of log.3.lammps:"]
    assert said[2:] == [f"log.3.lammps {line}" for line in range(8, 20)]
    assert tail(tmp_path / "nothing") == ""


def test_a_deck_replaces_a_deck_and_its_outputs_but_nothing_else(tmp_path):
    directory = write_deck(tmp_path / "new" / "deck", make_deck())
    (directory / "result.json").write_text("{}")
    write_deck(directory, make_deck(separation=2.0), force=True)
    assert not (directory / "result.json").exists()
    assert "separation index 2 " in (directory / "in.contact").read_text()

    (directory / "thesis.tex").write_text("precious")
    before = {path.name: path.read_bytes() for path in directory.iterdir()}
    with pytest.raises(OutputError, match=r"thesis\.tex.*--force"):
        write_deck(directory, make_deck())
    assert before == {path.name: path.read_bytes() for path in directory.iterdir()}
    write_deck(directory, make_deck(), force=True)
    assert (directory / "thesis.tex").read_text() == "precious"
    assert f"separation index {1.1 / 3:.17g} " in (directory / "in.contact").read_text()


def test_force_does_not_make_a_deck_of_any_other_folder(tmp_path):
    """Not of one whose files happen to have names of ours."""
    for name in ("README.txt", "deck.json", "notes.txt"):
        (tmp_path / name).write_text("mine")
    for force in (False, True):
        with pytest.raises(OutputError, match=r"notes\.txt.*choose another directory$"):
            write_deck(tmp_path, make_deck(), force=force)
    assert {path.read_text() for path in tmp_path.iterdir()} == {"mine"}


def test_a_deck_of_an_earlier_version_is_read_and_replaced(tmp_path):
    """Heights and start were sections of slab.data."""
    heights = np.random.default_rng(3).normal(size=SLAB.shape)
    directory = write_deck(tmp_path / "deck", make_deck(heights=heights))
    (of_atoms,) = values_of_atoms(directory / "wall.heights")
    (directory / "wall.heights").unlink()
    with (directory / "slab.data").open("a") as file:
        file.write("\nWallHeight\n\n" + "".join(f"{i:.0f} {h!r}\n" for i, h in of_atoms.tolist()) + "21 0\n")
    assert (read_heights(directory / "slab.data") == heights).all()
    write_deck(directory, make_deck())
    assert "WallHeight" not in (directory / "slab.data").read_text()


NOT_FINITE = np.full((4, 5), np.nan)
MOVED_BASE = np.ones((4, 4, 5, 3))


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"heights": np.zeros((5, 4))}, ValueError, r"heights = .* \(4, 5\); its shape is \(5, 4\)"),
        ({"heights": NOT_FINITE}, ValueError, "heights = .* 20 of 20 are NaN"),
        ({"displacements": np.zeros((4, 5, 3))}, ValueError, "displacements"),
        ({"displacements": MOVED_BASE}, ValueError, "frozen base"),
        ({"separation": float("inf")}, ValueError, "separation = inf"),
        ({"tolerance": 0.0}, ValueError, "tolerance = 0.0"),
        ({"tolerance": float("nan")}, ValueError, "tolerance"),
        ({"evaluations": 0}, ValueError, "evaluations"),
        ({"evaluations": 1.5}, ValueError, "evaluations = 1.5"),
        ({"wall": HardWall()}, TypeError, "not a function of the gap"),
        ({"wall_tolerance": 0.0}, ValueError, "wall_tolerance = 0.0"),
        ({"wall_force": "atoms"}, ValueError, "a function of the lattice site"),
        ({"wall_force": "springs"}, ValueError, "wall_force"),
        ({"notes": ["text"]}, ValueError, "notes"),
        ({"notes": (1,)}, ValueError, "notes"),
        ({"stiffness": np.ones((4, 4))}, ValueError, "stiffness"),
        ({"rise": np.ones(4)}, ValueError, "frozen base"),
        ({"rise": np.zeros(3)}, ValueError, "rise"),
    ],
)
def test_a_deck_that_makes_no_sense_is_refused(changes, error, message):
    with pytest.raises(error, match=message):
        make_deck(**changes)


def test_a_base_thinner_than_the_forces_reach_is_refused():
    class Far(Springs):
        coupled_layers = 3

    with pytest.raises(ValueError, match="3 frozen layers, which forces reach"):
        make_deck(model=Far(1.0))


def test_a_deck_keeps_its_own_arrays():
    heights = np.zeros((4, 5))
    deck = make_deck(heights=heights)
    heights[:] = 1
    assert (deck.heights == 0).all()
    with pytest.raises(ValueError, match="read-only"):
        deck.heights[0, 0] = 1


def test_a_lammps_that_is_too_old_is_told_which_one_is_needed(tmp_path, monkeypatch):
    monkeypatch.setattr("atomistic.lammps.deck.LEAST_VERSION", (99990101, "the year 9999"))
    directory = write_deck(tmp_path / "deck", make_deck())
    done = subprocess.run(
        [script("lmp"), "-in", "in.contact"], cwd=directory, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "this_deck_needs_LAMMPS_of_the_year_9999_or_later" in done.stdout
    assert not list(directory.glob("result*"))
    with pytest.raises(LammpsError, match="needs_LAMMPS_of"):
        run_in_process(directory)


def test_a_readme_is_as_wide_as_a_terminal_of_120_columns(tmp_path):
    directory = write_deck(tmp_path / "deck", replace(make_deck(), notes=(200 * "n ",)))
    lines = (directory / "README.txt").read_text().splitlines()
    assert "n " * 10 in "".join(lines)
    assert max(map(len, lines)) <= 118


def test_a_deck_of_an_input_says_what_it_is(tmp_path):
    text = (
        'separation = 1.3\n[interatomic]\nkind = "eam"\nfile = "Cu_mishin1.eam.alloy"\n[slab]\nn = 10\ndepth = 4.0\n'
        '[surface]\nkind = "sphere"\nradius = 50.0\n[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = 0.005\n'
    )
    (tmp_path / "own.toml").write_text(text)
    directory = a.deck(tmp_path / "own.toml").write(tmp_path / "deck")
    assert (directory / "input.toml").read_text() == text
    readme = " ".join((directory / "README.txt").read_text().split())
    assert "Surface: kind = sphere, radius = 50.0" in readme
    real = a.run_deck(directory).description.real_units
    assert f"({real.to_si(0.005, 'energy_per_area') * 1e3:.4g} mJ/m²)" in readme
    assert "E* = 135.2 GPa" in readme
    heights = read_heights(directory / "slab.data")
    digest = hashlib.sha256(heights.tobytes()).hexdigest()
    assert f"SHA-256 {digest[:16]}" in readme
    assert json.loads((directory / "deck.json").read_text())["heights"] == digest
