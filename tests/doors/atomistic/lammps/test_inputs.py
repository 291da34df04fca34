"""Decks from end to end, as a person runs them: every input that comes with the package, and measured topographies."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.front.cli import main
from continuum.inputs.errors import NOT_CONVERGED, OK
from tests.measured import AFM, MEASURED

ROOT = Path(__file__).parents[4]
CRYSTALS = {
    "springs": ('kind = "springs"', 'spacing = "0.3nm"'),
    "copper": ('kind = "eam"\nfile = "Cu_mishin1.eam.alloy"', ""),
    "lennard-jones": ('kind = "lennard-jones"', 'spacing = "0.3nm"'),
}


@pytest.mark.long
@pytest.mark.parametrize("path", sorted((ROOT / "inputs/lammps").glob("*.toml")), ids=lambda path: path.stem)
def test_every_input_runs_and_is_read(path: Path, tmp_path: Path) -> None:
    directory = tmp_path / path.stem
    expected = NOT_CONVERGED if path.stem == "yield" else OK
    assert main(["deck", str(path), "-o", str(directory), "--run"]) == expected
    assert main(["read", str(directory), "-o", str(tmp_path / "out"), "--compare"]) == expected
    run = a.read(directory)
    assert run.finished
    assert run.converged == (run.first_yield is None) == (path.stem != "yield")
    assert max(step.area_rep for step in run.steps) > 0.01


def topography(folder: Path) -> str:
    """Lines of the diamond film where it is at hand, else of a rough map of ours that is not periodic."""
    film = MEASURED / "container-2.zip"
    if film.is_file():
        return f'path = "{film}"\npart = "{AFM}"'
    rough = c.SelfAffine(0.8, 0.1, 8, 64).synthesise(c.Grid.square(128), np.random.default_rng(3))
    np.save(folder / "map.npy", 0.2 * rough[:100, :100])
    return 'path = "map.npy"\nsize = "20nm"\nunit = "nm"'


def end_to_end(tmp_path: Path, crystal: str, n: int, depth: float, separation: float) -> None:
    interatomic, spacing = CRYSTALS[crystal]
    (tmp_path / "map.toml").write_text(
        f"separation = {separation}\n[interatomic]\n{interatomic}\n[slab]\nn = {n}\ndepth = {depth}\n[surface]\n"
        f'kind = "topography"\n{topography(tmp_path)}\n{spacing}\n'
        '[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = 0.005\n'
    )
    assert main(["deck", str(tmp_path / "map.toml"), "-o", str(tmp_path / "deck"), "--run"]) == 0
    assert main(["read", str(tmp_path / "deck"), "-o", str(tmp_path / "out"), "--compare"]) == 0
    run = a.read(tmp_path / "deck")
    assert run.last.area_rep > 0.01
    notes = (tmp_path / "deck/README.txt").read_text()
    assert "cut out about the fractions" in notes
    assert "turned over" in notes


def test_a_piece_of_a_map_presses_on_atoms(tmp_path, monkeypatch):
    monkeypatch.setattr("atomistic.show.decks.save_figure", lambda _, stem: stem)
    end_to_end(tmp_path, "springs", 32, 2.0, 1.0)


@pytest.mark.long
@pytest.mark.parametrize("crystal", ["copper", "lennard-jones"])
def test_a_measured_film_presses_on_crystals(tmp_path, crystal):
    end_to_end(tmp_path, crystal, 64, 8.0, 1.2)


@pytest.mark.parametrize(("centre", "allowed"), [("0.5", "a list"), ("[0.5]", "2 entries"), ("[]", "2 entries")])
def test_one_number_where_two_are_needed_is_one_clear_message(
    tmp_path: Path, centre: str, allowed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "map.npy", np.zeros((8, 8)))
    (tmp_path / "map.toml").write_text(
        "separation = 1.0\n[interatomic]\nkind = 'springs'\n[slab]\nn = 8\ndepth = 3.0\n[surface]\n"
        f"kind = 'topography'\npath = 'map.npy'\nsize = '2nm'\nunit = 'nm'\ncentre = {centre}\n"
        "[wall]\nlaw = 'lennard-jones-spline'\nadhesion_length = 0.005\n"
    )
    assert main(["deck", str(tmp_path / "map.toml"), "-o", str(tmp_path / "deck")]) == 2
    said = capsys.readouterr().err
    assert allowed in said
    assert said.count("surface.centre = ") == 1


@pytest.mark.long
def test_a_deck_knows_surfaces_and_walls_of_files_whatever_was_imported_before() -> None:
    code = (
        "from atomistic.inputs.deck import DeckConfig, DeckSurface; from continuum.model.walls import Wall\n"
        "assert 'file' in DeckSurface.kinds and 'table' in Wall.kinds"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
