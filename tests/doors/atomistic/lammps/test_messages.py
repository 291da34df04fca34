"""What the commands say where a deck cannot be written, run or read: one message, exit code 2, nothing half written."""

import json
from pathlib import Path

import numpy as np
import pytest

from atomistic.front.cli import main
from atomistic.lammps.result import tail

DECK = """
separation = 1.2
[interatomic]
kind = "springs"
[slab]
n = 8
depth = 4.0
[surface]
kind = "sine"
amplitude = 0.05
waves = [1, 1]
[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005
"""


@pytest.fixture
def deck(tmp_path: Path, capsys) -> Path:
    (tmp_path / "small.toml").write_text(DECK)
    assert main(["deck", str(tmp_path / "small.toml"), "-o", str(tmp_path / "deck")]) == 0
    capsys.readouterr()
    return tmp_path / "deck"


def said(capsys) -> str:
    output = capsys.readouterr()
    assert "Traceback" not in output.err
    assert output.err.strip()
    return output.err


def test_reading_what_is_no_run_is_one_message(deck, tmp_path, capsys):
    (tmp_path / "file").write_text("x")
    (tmp_path / "empty").mkdir()
    for path, message in (
        (tmp_path / "nothing", "is not there"),
        (tmp_path / "file", "also the folder of a deck"),
        (tmp_path / "empty", "has no deck"),
        (deck, "has not been run"),
    ):
        assert main(["read", str(path)]) == 2
        assert message in said(capsys)


def test_a_damaged_run_is_one_message(deck, capsys, monkeypatch):
    monkeypatch.setattr("atomistic.show.decks.save_figure", lambda _, stem: stem)
    assert main(["deck", str(deck.parent / "small.toml"), "-o", str(deck), "--run"]) == 0
    for name, content in (
        ("slab.data", "LAMMPS data file\n"),
        ("result.json", '{"load": 1'),
        ("result.json", "{}"),
        ("result.json", "[]"),
        ("surface.dump", "ITEM: TIMESTEP\n"),
        ("deck.json", "{}"),
    ):
        kept = (deck / name).read_text()
        (deck / name).write_text(content)
        capsys.readouterr()
        assert main(["read", str(deck)]) == 2
        assert said(capsys)
        (deck / name).write_text(kept)
    assert main(["read", str(deck)]) == 0
    (deck / "result.json").unlink()
    assert main(["read", str(deck)]) == 2
    assert "stopped" in said(capsys)


def test_the_log_of_a_deck_is_quoted_with_the_names_of_the_user(deck):
    description = json.loads((deck / "deck.json").read_text())
    (deck / "deck.json").write_text(json.dumps(description | {"files": {"potential.1": "library.meam"}}))
    (deck / "log.lammps").write_text("pair_coeff * * potential.1 Ni; no potential.10 or potential.eam\n")
    assert tail(deck).endswith("pair_coeff * * library.meam Ni; no potential.10 or potential.eam")


@pytest.mark.parametrize("command", ['srun "lmp', "", "  "])
def test_a_command_that_is_none_is_refused_before_anything_is_written(tmp_path, capsys, command):
    (tmp_path / "small.toml").write_text(DECK)
    words = ["deck", str(tmp_path / "small.toml"), "-o", str(tmp_path / "deck"), "--run", "--lmp-command", command]
    assert main(words) == 2
    assert "--lmp-command" in said(capsys)
    assert not (tmp_path / "deck").exists()


def test_validate_refuses_a_file_for_its_decks_and_a_broken_command(tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    for words in (["--keep-decks", str(tmp_path / "file")], ["--lmp-command", "'"]):
        assert main(["validate", "inputs/validate/quick.toml", "-o", str(tmp_path / "out"), *words]) == 2
        assert said(capsys)
    assert (tmp_path / "file").read_text() == "mine"
    assert not (tmp_path / "out").exists()


def test_a_folder_with_other_files_is_left_alone(tmp_path, capsys):
    (tmp_path / "small.toml").write_text(DECK)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.tex").write_text("precious")
    (tmp_path / "file").write_text("x")
    for name, message in (("mine", "thesis.tex"), ("file", "not a folder")):
        assert main(["deck", str(tmp_path / "small.toml"), "-o", str(tmp_path / name)]) == 2
        assert message in said(capsys)
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["thesis.tex"]


def test_heights_that_are_none_are_one_message(tmp_path, capsys):
    heights = np.zeros((8, 8))
    heights[3, 4] = np.nan
    np.save(tmp_path / "nan.npy", heights)
    np.save(tmp_path / "small.npy", np.zeros((4, 8)))
    for name, message in (("nan.npy", "not finite"), ("small.npy", "shape")):
        surface = f'kind = "file"\npath = "{name}"'
        text = DECK.replace('kind = "sine"\namplitude = 0.05\nwaves = [1, 1]', surface)
        (tmp_path / "file.toml").write_text(text)
        assert main(["deck", str(tmp_path / "file.toml"), "-o", str(tmp_path / "deck")]) == 2
        assert message in said(capsys)
        assert not (tmp_path / "deck").exists()


def test_all_faults_of_an_input_are_said_at_once(tmp_path, capsys):
    text = DECK.replace(
        'kind = "springs"',
        """kind = "pair-style"
style = "adp\\nshell rm x"
element = "Cu"
mass = 63.5
cutoff = 6.0
lattice_constant = 3.6""",
    )
    text += '\n[protocol]\nkind = "mean-pressures"\npressures = [0.0]\n'
    (tmp_path / "bad.toml").write_text(text)
    assert main(["deck", str(tmp_path / "bad.toml"), "-o", str(tmp_path / "deck")]) == 2
    message = said(capsys)
    for part in ("exactly one of separation", "interatomic.style", "other than zero"):
        assert part in message
    assert not (tmp_path / "deck").exists()


@pytest.mark.parametrize(
    "what",
    [
        "separation = -3.0",
        'separation = -3.0\nfollows = "atom"',
        '[protocol]\nkind = "separations"\nseparations = [-3.0, 1.2]',
        '[protocol]\nkind = "mean-pressures"\npressures = [0.9]',
        '[protocol]\nkind = "velocity"\nseparations = [-3.0, 1.2]\nvelocity = 0.1\ntemperature = 0.0\nwindow = 5.0',
    ],
)
def test_a_start_below_the_core_is_one_message_and_nothing_is_written(tmp_path, capsys, what):
    table = what.startswith("[")
    (tmp_path / "low.toml").write_text(DECK.replace("separation = 1.2", "" if table else what) + what * table)
    assert main(["deck", str(tmp_path / "low.toml"), "-o", str(tmp_path / "deck"), "--run"]) != 0
    message = said(capsys)
    assert "core" in message or "past one another" in message
    assert not (tmp_path / "deck").exists()


def test_files_from_outside_the_folder_of_an_input_are_listed_as_its_deck_is_written(tmp_path, capsys):
    """An input that somebody sent names any file, also by a link; who passes on the deck should know."""
    for folder in ("sent", "mine"):
        (tmp_path / folder).mkdir()
    for name in ("mine/secret", "mine/linked", "sent/beside"):
        (tmp_path / name).write_text("# a text")
    (tmp_path / "sent/link").symlink_to(tmp_path / "mine/linked")
    potential = """kind = "pair-style"
style = "eam"
element = "Ni"
mass = 58.7
cutoff = 4.8
lattice_constant = 3.52
coefficients = [["1", "1", "Ni_u3.eam"]]
files = ["../mine/secret", "link", "beside"]"""
    (tmp_path / "sent/in.toml").write_text(DECK.replace('kind = "springs"', potential))
    assert main(["deck", str(tmp_path / "sent/in.toml"), "-o", str(tmp_path / "deck")]) == 0
    lines = [line.split()[1] for line in capsys.readouterr().out.splitlines() if line.startswith("copied")]
    assert lines == [f"{tmp_path}/mine/secret,", f"{tmp_path}/mine/linked,"]
