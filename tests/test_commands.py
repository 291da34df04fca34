"""What both programs have in common: versions, how much they say, formats of figures, completion, exit codes."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import atomistic.cli
import continuum.cli
import continuum.options
from continuum.errors import EXIT_CODES
from tests.problems import SMALL

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    Main = Callable[[Sequence[str]], int]

PROGRAMS = [(continuum.cli.main, continuum.options.parser), (atomistic.cli.main, atomistic.cli.parser)]


@pytest.mark.parametrize(("main", "parser"), PROGRAMS)
def test_the_version_is_that_of_all_that_the_numbers_depend_on(
    main: Main, parser: Callable[[], argparse.ArgumentParser], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("stickiness ")
    assert f"NumPy {np.__version__}" in said
    assert [line.split()[0] for line in said[1:4]] == ["Python", "NumPy", "LAMMPS"]
    assert [line.split(":")[0] for line in said[4:]] == ["back end cpu", "back end cuda"]
    said = " ".join(parser().format_help().split())
    for code, meaning in EXIT_CODES.items():
        assert f"{code}: {meaning}" in said


def test_quiet_says_what_came_of_it_and_verbose_where_it_failed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    command = ["run", str(tmp_path / "small.toml"), "-o", str(tmp_path)]
    assert continuum.cli.main([*command, "-q"]) == 0
    assert capsys.readouterr().out == f"result   {tmp_path / 'small.h5'}\n"
    for words in (["-v", *command], [*command, "--force"]):
        assert continuum.cli.main(words) == 0
        out = capsys.readouterr().out
        assert "Points of the path\nstep  branch" in out
        # A pipe gets plain text: no rules, no colours.
        assert not set("━│┃╭┌\x1b") & set(out)
    assert continuum.cli.main(["check", "nope.toml", "-v"]) == 2
    error = capsys.readouterr().err
    assert "Traceback" in error
    assert continuum.cli.main(["check", "nope.toml"]) == 2
    short = capsys.readouterr().err
    assert "Traceback" not in short
    assert error.endswith(short)


def test_figures_come_in_the_formats_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    assert continuum.cli.main(["run", str(tmp_path / "small.toml"), "-o", str(tmp_path), "-q"]) == 0
    capsys.readouterr()
    stored = str(tmp_path / "small.h5")
    assert continuum.cli.main(["plot", stored, "--format", "svg"]) == 0
    assert [Path(line).suffix for line in capsys.readouterr().out.split()] == [".svg", ".svg"]
    assert not [*tmp_path.glob("*.png"), *tmp_path.glob("*.pdf")]
    drawn = (tmp_path / "small-contact.svg").read_bytes()
    assert drawn.startswith(b"<?xml")
    assert continuum.cli.main(["plot", stored, "--format", "svg", "--format", "pdf"]) == 0
    assert (tmp_path / "small-contact.svg").read_bytes() == drawn
    assert (tmp_path / "small-contact.pdf").read_bytes().startswith(b"%PDF")
    assert not [*tmp_path.glob("*.png")]


@pytest.mark.parametrize(("main", "parser"), PROGRAMS)
def test_a_shell_completes_every_command_or_is_told_what_to_install(
    main: Main, parser: Callable[[], argparse.ArgumentParser], capsys: pytest.CaptureFixture[str]
) -> None:
    code = main(["completion", "bash"])
    said = capsys.readouterr()
    if importlib.util.find_spec("shtab") is None:
        assert code == 2
        assert "pip install 'stickiness[completion]'" in said.err
        return
    assert code == 0
    (commands,) = [action for action in parser()._actions if isinstance(action, argparse._SubParsersAction)]
    words = set(said.out.replace("(", " ").replace(")", " ").split())
    assert {*commands.choices, "--quiet", "--version"} <= words
