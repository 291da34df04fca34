"""The pages of the site say what is there: inputs, commands, options, names; and the site builds without a warning."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import atomistic.cli
import continuum.options

ROOT = Path(__file__).parent.parent
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text() for path in (ROOT / "docs").rglob("*.md")
         if "reference" not in path.parts}  # fmt: skip
PAGES["README.md"] = (ROOT / "README.md").read_text()


@pytest.mark.parametrize("page", PAGES)
def test_every_input_and_picture_named_exists(page: str) -> None:
    text, folder = PAGES[page], (ROOT / page).parent
    for path in re.findall(r"\binputs/[\w-]+/[\w.-]+\.toml", text):
        assert (ROOT / path).is_file(), path
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert target.startswith("reference/") or (folder / target).exists(), target


@pytest.mark.parametrize("page", PAGES)
def test_every_command_and_option_named_exists(page: str) -> None:
    parsers = {"continuum": continuum.options.parser(), "atomistic": atomistic.cli.parser()}
    known = {}
    for program, parser in parsers.items():
        (commands,) = [action for action in parser._actions if action.choices and action.dest == "command"]
        known |= {(program, name): set(sub._option_string_actions) for name, sub in commands.choices.items()}  # type: ignore[union-attr]
    for line in re.findall(r"(?:^|`)((?:continuum|atomistic) [a-z][^`\n]*)", PAGES[page], re.MULTILINE):
        program, command, *words = line.split("#")[0].split()
        if f"{program} {command}" in ("continuum of", "continuum is", "continuum on") or "." in command:
            continue
        assert (program, command) in known, line
        if command == "sweep":
            continue  # it has sub-commands, each with options of its own
        options = {word.split("=")[0] for word in words if word.startswith("--")}
        assert options <= known[program, command], line


@pytest.mark.parametrize("page", ["docs/start.md"])
def test_the_code_of_a_page_runs_as_printed(page: str, tmp_path: Path) -> None:
    for code in re.findall(r"```python\n(.*?)```", PAGES[page], re.DOTALL):
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr


@pytest.mark.long
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "docs", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "reference" / "run.html").is_file()
