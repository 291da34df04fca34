"""The shape of the project: which way imports point, what may be imported where, what each module shows."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from atomistic.inputs.crystal import ElasticConfig
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.validate import ValidateConfig
from continuum.front.runs import SystemCost, costs_of
from continuum.inputs.reading import load
from continuum.store.runs.config import RunConfig
from continuum.store.runs.run import follow_run
from continuum.store.sweeps.axes import Sweep
from docs.house import MODULES, ROOT, imports, rooms

IN_ROOMS = [path for path in MODULES if not path.stem.startswith("__")]
INPUTS = sorted((ROOT / "inputs").rglob("*.toml"))
LARGEST = ROOT / "inputs/sweep/who-is-right.toml"
"""A sweep of thousands of systems, as others of its name, each of which takes a millisecond to check."""


def name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


def top(module: str) -> str:
    return module.split(".", 1)[0]


# A room, and the rooms that it may ask; what these may ask is allowed with them.
CONTINUUM = {
    "theory": "",
    "inputs": "",
    "model": "theory inputs",
    "solve": "model",
    "measure": "model",
    "path": "solve measure",
    "store": "path",
    "maps": "store",
    "show": "maps",
    "front": "show",
    "paper": "front",
    "view": "front",
}
ATOMISTIC = {
    "crystal": "",
    "lammps": "crystal",
    "inputs": "lammps",
    "response": "inputs",
    "relax": "response",
    "atoms": "relax",
    "ladder": "relax",
    "show": "ladder",
    "front": "show atoms",
}


def allowed(rooms: dict[str, str], room: str) -> set[str]:
    """The rooms that a room may ask, and itself."""
    return {room}.union(*(allowed(rooms, other) for other in rooms[room].split()))


def test_a_module_asks_only_the_rooms_that_it_may() -> None:
    asked = set()
    for path in IN_ROOMS:
        package, room = name(path).split(".")[:2]
        table = CONTINUUM if package == "continuum" else ATOMISTIC
        may = allowed(table, room) | {"__version__"}
        ours = {module for module in imports(path) if module.startswith(f"{package}.")}
        assert not {module for module in ours if module.split(".")[1] not in may}, name(path)
        asked |= ours
    assert len(asked) > len(IN_ROOMS) > 200


def test_the_arrow_points_from_atomistic_to_continuum() -> None:
    found = {name(p): set(map(top, imports(p))) for p in MODULES}
    for module, tops in found.items():
        if module.startswith("continuum."):
            assert not tops & {"atomistic", "ase", "lammps"}, module
    assert any("continuum" in tops for module, tops in found.items() if module.startswith("atomistic."))
    assert not {module for module, tops in found.items() if tops & {"docs", "tests"}}


@pytest.mark.style
@pytest.mark.parametrize(("package", "table"), [("continuum", CONTINUUM), ("atomistic", ATOMISTIC)])
def test_every_module_is_in_a_room_which_says_what_lives_there(package: str, table: dict[str, str]) -> None:
    inside = {path.relative_to(ROOT / package).parts[0] for path in MODULES if path.is_relative_to(ROOT / package)}
    assert inside == {*table, "__init__.py", "__main__.py"}
    for path in (ROOT / package).rglob("*.py"):
        assert ast.get_docstring(ast.parse((path.parent / "__init__.py").read_text())), path.parent


@pytest.mark.style
def test_the_arrows_between_rooms_can_be_drawn() -> None:
    """Of 66 that rooms without a circle could have, and those that follow from others are not drawn."""
    arrows = {room: {one for one in asked if one.startswith("continuum")} for room, asked in rooms().items()}
    assert sum(len(asked) for room, asked in arrows.items() if room.startswith("continuum")) <= 60


# The clients begin at the front.  What they import beside it has no public name, as no user needs it.
CLIENTS = {
    "paper": {
        "front": "sweeps and their tables; commands and their options",
        "theory": "the equations beside which numbers are shown",
        "maps": "the criteria that are compared; materials of the examples",
        "measure": "adhesion and jumps of a curve of stored points; the outline and the gaps that are drawn",
        "model": "laws and crystals of the examples; a spectrum, whose elastic energy is compared",
        "store": "points, maps and files of a sweep; tables with units",
        "show": "the style of figures, and pages",
        "inputs": "checks of arguments, and the errors that they raise",
    },
    "view": {
        "front": "predictions, from the same options as in a program",
        "maps": "layers and faults of a map before it is predicted; the table of an input, which the form shows",
        "store": "states of stored runs and sweeps; a worker that may be stopped",
        "show": "the answer in words, and the colours of maps",
        "inputs": "units, files that come with the package, and errors",
    },
}


@pytest.mark.style
def test_the_clients_import_no_further_room() -> None:
    arrows = rooms()
    for client, reasons in CLIENTS.items():
        asked = {room.removeprefix("continuum.") for room in arrows[f"continuum.{client}"]}
        assert asked == {*reasons}, client


@pytest.mark.parametrize(
    ("library", "allowed"),
    [
        ("h5py", {"continuum.store.hdf5", "continuum.store.datasets"}),
        ("lammps", {"atomistic.lammps.engine"}),
        # The front door names the type of a figure.
        ("matplotlib", {"continuum.show", "continuum.paper", "atomistic.show", "continuum.front.contact"}),
        ("SurfaceTopography", {"continuum.maps.instruments"}),
        ("tornado", {"continuum.view.server"}),
        (
            "cyclopts",
            {f"continuum.front.{name}" for name in ("cli", "options", "commands", "map_commands")}
            | {"continuum.paper.commands", "atomistic.front.commands"},
        ),
        (
            "pydantic",
            {
                "continuum.inputs.keys",
                "continuum.inputs.tables",
                "continuum.model",
                "continuum.inputs.toml",
                "continuum.inputs.reading",
                "continuum.inputs.reference",
                "continuum.store.runs",
                "continuum.store.sweeps",
                "continuum.maps.verdict.tables",
                "atomistic.inputs",
            },
        ),
        (
            "pandas",
            {
                "continuum.paper",
                "continuum.store.sweeps.collect",
                "continuum.store.sweeps.cube",
                "continuum.store.runs",
                "continuum.front.contact",
            },
        ),
        ("rich", {"continuum.show.console"}),
        ("ducc0", {"continuum.model.fourier"}),
        ("numba", {"continuum.model.kept", "continuum.model.laws", "continuum.solve.compiled.compiling"}),
        ("threading", {"continuum.solve.compiled.passes", "continuum.store.sweeps.workers"}),
        ("ase", {"atomistic.crystal.crystal", "atomistic.crystal.faces", "atomistic.atoms"}),
        (
            "subprocess",
            {
                "atomistic.lammps.engine",
                "atomistic.lammps.plugin",
                "continuum.store.provenance",
                "continuum.store.sweeps.workers",
            },
        ),
    ],
)
def test_a_library_is_imported_where_it_belongs_only(library: str, allowed: set[str]) -> None:
    places = {name(p) for p in MODULES if library in map(top, imports(p))}
    assert all(any(place == one or place.startswith(one + ".") for one in allowed) for place in places), places
    assert all(any(place == one or place.startswith(one + ".") for place in places) for one in allowed), allowed


@pytest.mark.style
def test_a_module_says_what_it_offers_and_stays_short() -> None:
    for path in IN_ROOMS:
        assert importlib.import_module(name(path)).__doc__, path
        assert len(path.read_text().splitlines()) <= 600, f"more than one subject: {path}"


# Which tables an input has, and which kinds each of them: these modules ask what a class is.
REGISTRY = {
    "continuum.inputs.tables",
    "continuum.inputs.toml",
    "continuum.store.identity",
    "continuum.inputs.reading",
    "continuum.inputs.reference",
}
DOORS = {
    ("atomistic.atoms.relaxation", "RoughWall"),  # the calculators of a sum, of which one may be the wall
    ("atomistic.atoms.wall", "Contact"),  # a wall of a contact, of heights or of a shape
    ("atomistic.front.functions", "Contact"),  # a wall of a contact, of a file or of a shape
    ("atomistic.front.functions", "DeckConfig"),  # a deck of a contact, of a file, or of an input that was read
    ("continuum.paper.page", "SweepRun"),  # a figure of a folder, or of what a sweep returned
}
"""Modules that take one thing or another, and the class of ours by which they tell."""


def asked_for(path: Path) -> Iterator[str]:
    """Classes of ours, but for errors, that a module takes from another one and asks objects for."""
    text = path.read_text()
    if not re.search(r"\b(?:isinstance|issubclass|type)\(|\bcase\b", text):
        return
    tree = ast.parse(text)
    ours = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and top(node.module or "") in ("continuum", "atomistic")
        for alias in node.names
    }
    for node in ast.walk(tree):
        asked: list[ast.expr] = []
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in ("isinstance", "issubclass")
        ):
            asked = node.args[1:]
        elif isinstance(node, ast.MatchClass):
            asked = [node.cls]
        elif (
            isinstance(node, ast.Compare) and isinstance(node.left, ast.Call) and ast.unparse(node.left.func) == "type"
        ):
            asked = node.comparators
        names = {part.id for one in asked for part in ast.walk(one) if isinstance(part, ast.Name)}
        yield from sorted(one for one in names & ours if not one.endswith("Error"))


@pytest.mark.style
def test_no_module_asks_what_class_of_another_one_an_object_is() -> None:
    found = {(name(path), asked) for path in MODULES if name(path) not in REGISTRY for asked in asked_for(path)}
    assert found == DOORS


@pytest.mark.parametrize("package", ["continuum", "atomistic"])
def test_modules_import_in_no_circle(package: str) -> None:
    """Not for their types, either: a reader begins with a module that needs none but those already read."""
    modules = {name(path): path for path in MODULES if name(path).startswith(f"{package}.")}
    assert len(modules) > 10
    TopologicalSorter({module: modules.keys() & set(imports(path)) for module, path in modules.items()}).prepare()


def test_the_solvers_know_no_machine() -> None:
    """Mathematics on one side of the seam, arrays and threads on the other; who asks for a device imports it."""
    for path in MODULES:
        for room in ("continuum.solve.compiled", "continuum.solve.arrays"):
            if not name(path).startswith(room) and name(path) != "continuum.solve.backend":
                assert not any(module.startswith(room) for module in imports(path)), name(path)


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=pytest.mark.long if path.stem.startswith("who-is-right") else ()) for path in INPUTS],
    ids=lambda p: f"{p.parent.name}/{p.name}",
)
def test_every_input_loads_and_says_what_it_is_for(path: Path) -> None:
    head = path.read_text().partition("\n[")[0]
    for word in ("Purpose", "Reproduces", "Cost"):
        assert f"\n# {word} " in f"\n{head}", word
    if path.parent.name == "sweep":
        both = (False, True) if "with --reduced" in head else (False,)
        systems = [costs_of(Sweep.read(path, reduced=reduced)) for reduced in both]
        compare_with_head(head, systems[0])
    elif path.parent.name == "smoke":
        load(path, RunConfig)
    else:
        kinds = {"validate": ValidateConfig, "lammps": DeckConfig, "crystals": ElasticConfig}
        load(path, kinds[path.parent.name])


@pytest.mark.parametrize("reduced", [False, True])
def test_the_first_system_of_the_largest_sweep_loads(reduced: bool) -> None:
    assert next(Sweep.read(LARGEST, reduced=reduced).systems())


def compare_with_head(head: str, systems: list[SystemCost]) -> None:
    """Memory in the head of a sweep, as its input has it."""
    for number in re.findall(r"([\d.]+) GB", head):
        assert max(one.cost.memory for one in systems) == pytest.approx(1e9 * float(number), rel=0.12)


# path.toml is run as docs/start.md says: tests/repository/test_docs.py.
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.long if path.name == "path.toml" else ())
        for path in INPUTS
        if path.parent.name == "smoke"
    ],
    ids=lambda path: path.name,
)
def test_every_smoke_input_runs_and_converges(path: Path, tmp_path: Path) -> None:
    config = load(path, RunConfig)
    summary = follow_run(config, tmp_path / "result.h5")
    assert summary.converged
    assert max(step.area_rep for step in summary.points) > 0.01


@pytest.mark.parametrize("package", ["continuum", "atomistic"])
def test_help_is_fast_and_works_as_a_module(package: str) -> None:
    code = (
        "import sys, runpy; sys.argv = ['x', '--help']\n"
        f"try: runpy.run_module('{package}', run_name='__main__')\n"
        "except SystemExit as end: assert not end.code\n"
        "heavy = {'numpy', 'scipy', 'h5py', 'matplotlib', 'ase', 'lammps', 'pydantic'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr
    assert f"Usage: {package}" in done.stdout


@pytest.mark.parametrize(
    ("commands", "with_it", "without"),
    [
        ("atomistic.front.commands", "atomistic.front.functions",
         {"ase", "lammps", "matplotlib", "pandas", "scipy.interpolate", "scipy.optimize"}),
        ("continuum.front.map_commands", "continuum.front.predict", {"matplotlib", "tornado", "scipy.optimize"}),
    ],
)  # fmt: skip
def test_a_program_imports_what_only_some_commands_need_when_they_need_it(
    commands: str, with_it: str, without: set[str]
) -> None:
    """Of a process that begins these would be a third of its time; much of ``continuum`` is among them."""
    code = f"import sys, {commands}; print(sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    imported = set(ast.literal_eval(done.stdout))
    assert with_it in imported
    assert not imported & without
