"""What both programs have in common: versions, how much they say, formats of figures, completion, exit codes."""

from __future__ import annotations

import re
import signal
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import atomistic.front.cli
import continuum
import continuum.front.cli
from continuum.inputs.errors import EXIT_CODES
from continuum.show import console
from continuum.show.plot import new_figure, save_figure, written_as
from tests.kinds import covering
from tests.problems import SMALL

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from cyclopts import App

    Main = Callable[[Sequence[str]], int]

ROOT = Path(__file__).parents[2]
PROGRAMS = [(continuum.front.cli.main, continuum.front.cli.app), (atomistic.front.cli.main, atomistic.front.cli.app)]


@pytest.mark.parametrize(("main", "app"), PROGRAMS)
def test_the_version_is_that_of_all_that_the_numbers_depend_on(
    main: Main, app: App, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--version"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("stickiness ")
    assert f"NumPy {np.__version__}" in said
    assert [line.split()[0] for line in said[1:4]] == ["Python", "NumPy", "LAMMPS"]
    assert [line.split(":")[0] for line in said[4:]] == ["device cpu", "device torch", "device cupy", "device jax"]
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    assert len(out.splitlines()) <= 36, "it fits on a screen, each command on a line"
    text = " ".join(out.split())
    for code, meaning in EXIT_CODES.items():
        assert f"{code} {meaning}" in text


def test_quiet_says_what_came_of_it_and_verbose_where_it_failed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    command = ["run", str(tmp_path / "small.toml"), "-o", str(tmp_path)]
    assert continuum.front.cli.main([*command, "-q"]) == 0
    assert capsys.readouterr().out == f"result   {tmp_path / 'small.h5'}\n"
    for words in (["-v", *command], [*command, "--force"]):
        assert continuum.front.cli.main(words) == 0
        out = capsys.readouterr().out
        assert "Points of the path\nstep  branch" in out
        # A pipe gets plain text: no rules, no colours.
        assert not set("━│┃╭┌\x1b") & set(out)
    assert continuum.front.cli.main(["check", "nope.toml", "-v"]) == 2
    error = capsys.readouterr().err
    assert "Traceback" in error
    assert continuum.front.cli.main(["check", "nope.toml"]) == 2
    short = capsys.readouterr().err
    assert "Traceback" not in short
    assert error.endswith(short)


def test_figures_come_in_the_formats_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    assert continuum.front.cli.main(["run", str(tmp_path / "small.toml"), "-o", str(tmp_path), "-q"]) == 0
    capsys.readouterr()
    stored = str(tmp_path / "small.h5")
    assert continuum.front.cli.main(["plot", stored, "--format", "svg", "--format", "pdf"]) == 0
    assert [Path(line).suffix for line in capsys.readouterr().out.split()] == [".svg", ".svg"]
    assert (tmp_path / "small-contact.svg").read_bytes().startswith(b"<?xml")
    assert (tmp_path / "small-contact.pdf").read_bytes().startswith(b"%PDF")
    assert {path.suffix for path in tmp_path.glob("small-*")} == {".svg", ".pdf"}


@pytest.mark.usefixtures("really_drawn")
def test_a_figure_that_is_drawn_again_has_the_same_bytes(tmp_path: Path) -> None:
    with written_as(["svg", "pdf"]):
        for name in "ab":
            figure = new_figure(3, 2)
            figure.add_subplot().plot([0, 1], [0, 1])
            save_figure(figure, tmp_path / name)
    for suffix in ("svg", "pdf"):
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


@pytest.mark.parametrize(("program", "shell"), covering(PROGRAMS, ["bash", "zsh", "fish"]))
def test_a_shell_completes_every_command(
    program: tuple[Main, App], shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    main, app = program
    assert main(["completion", shell]) == 0
    said = capsys.readouterr().out
    assert {name for name in app.resolved_commands() if name[0] != "-"} <= set(re.findall(r"[\w-]+", said))
    assert "quiet" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "Usage"),
        (["nope"], "nope"),
        (["run"], "FILE"),
        (["run", "a.toml", "b.toml"], "b.toml"),
        (["run", "a.toml", "--nope"], "--nope"),
        (["run", "a.toml", "--set", "seed"], "KEY=VALUE"),
        (["sweep"], "Usage"),
        (["sweep", "run", "a.toml", "--shard", "3/2"], "I/N"),
        (["sweep", "run", "a.toml", "--workers", "two"], "two"),
        (["sweep", "run", "a.toml", "--workers", "1.7"], "'1.7': write a whole number"),
        (["sweep", "slurm", "a.toml", "--array", "3.0"], "'3.0': write a whole number"),
        (["predict", "a.txt", "--threads", "1.9"], "'1.9': write a whole number"),
        (["view", "--port", "34567.9"], "'34567.9': write a whole number"),
        (["certify", "a.h5", "--sample", "2.5"], "'2.5': write a whole number"),
        (["plot", "a.h5", "--format", "gif"], "gif"),
    ],
)
def test_a_wrong_command_line_is_one_message(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        continuum.front.cli.main(words)
    assert end.value.code == 2
    assert said in "".join(capsys.readouterr())


def test_options_that_are_no_arguments_as_they_stand_mean_what_the_function_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Several keys, several lines, memory in GB: the last of two values of one key counts."""
    path = tmp_path / "many.toml"
    path.write_text(f'{SMALL}[sweep.axes]\n"surface.hurst" = [0.8]\n')
    words = "--set surface.seed=4 --set surface.rms_slope=0.2 --set surface.seed=3 --memory 4 --array 3 -j 2"
    words += " --module gcc/13.2 --module mpi --line ulimit --line date"
    assert continuum.front.cli.main(["sweep", "slurm", str(path), *words.split()]) == 0
    script = continuum.sweep_slurm(
        path, settings={"surface.seed": 3, "surface.rms_slope": 0.2}, memory=4e9, shards=3, workers=2,
        modules=["gcc/13.2", "mpi"], lines=["ulimit", "date"],
    )  # fmt: skip
    assert capsys.readouterr().out == script


@pytest.mark.parametrize(
    ("program", "number"),
    covering(
        [(continuum.front.cli.main, "run"), (atomistic.front.cli.main, "deck")],
        [signal.SIGINT, signal.SIGTERM, signal.SIGHUP],
    ),
)
def test_what_is_stopped_does_not_end_as_what_did_not_converge(
    program: tuple[Main, str],
    number: signal.Signals,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    main, kind = program
    # A test runner that was started by nohup, or in the background, ignores them.
    before = {each: signal.signal(each, signal.default_int_handler) for each in (signal.SIGINT, signal.SIGHUP)}
    module = "continuum.front.commands" if main is continuum.front.cli.main else "atomistic.front.commands"
    monkeypatch.setattr(f"{module}.schema_of", lambda _: signal.raise_signal(number))
    try:
        assert main(["schema", kind]) == 128 + number
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
    assert capsys.readouterr().err.startswith("stopped; ")


@pytest.mark.parametrize(("code", "drawn"), [(0, True), (1, True), (143, False)])
def test_make_draws_figures_of_what_ended_by_itself(code: int, drawn: bool, tmp_path: Path) -> None:
    program = tmp_path / "continuum"
    program.write_text(f'#!/bin/sh\n[ "$1" = plot ] && touch {tmp_path}/drawn && exit\nexit {code}\n')
    program.chmod(0o755)
    make = ["make", "-C", str(ROOT), "--old-file", ".venv/installed", "figures", f"BIN={tmp_path}"]
    done = subprocess.run(make, capture_output=True, check=False)
    assert (done.returncode == 0) == (tmp_path / "drawn").exists() == drawn


def test_a_quiet_command_leaves_the_next_one_of_the_process_its_voice(capsys: pytest.CaptureFixture[str]) -> None:
    assert console.exit_code(lambda: 0, voice="quiet") == 0
    console.tell("still here")
    assert capsys.readouterr().err == "still here\n"


@pytest.mark.parametrize(
    ("resumes", "said"),
    [(True, "stopped; finished work is stored, and the same command continues from there"),
     (False, "stopped; the same command starts anew")],
)  # fmt: skip
def test_a_stopped_command_says_whether_it_continues(
    resumes: bool, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped() -> int:
        raise KeyboardInterrupt

    assert console.exit_code(stopped, resumes=resumes) == 130
    assert capsys.readouterr().err.strip() == said
