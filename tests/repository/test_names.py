"""Names: one word for one thing, in both packages."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

pytestmark = pytest.mark.style

ROOT = Path(__file__).parents[2]
MODULES = sorted(path for package in ("continuum", "atomistic") for path in (ROOT / package).rglob("*.py"))
NOT_SAID = {
    "load: force of the wall per A0, in E*": "weight",
    "force: total force of the wall on the atoms of a deck, in E* a0²": "thrust",
    "state, path: one solution of a contact; states in the order in which they were reached": "drawn",
    "point: a state that is stored, or drawn, as numbers": "passed",
    "system, sweep: one path of a sweep; all of them": "swept job",
    "listing: the systems of a sweep by their identity": "listed",
    "step, window: one equilibrium of a deck's protocol; the time over which a motion is averaged": "stage",
    "result: what is stored of a run, a task or an iteration": "ended iterated collected",
    "status: how a solve ended, with the cause and what helps": "outcome_of",
    "lock: the mark of the process that writes a file": "held",
    "coupled layers: layers of a crystal that a layer exerts forces on": "reaching",
    "threshold: work of adhesion at which a surface becomes sticky": "turn turns turning",
    "grid: the points of a solver, of either kind": "face",
    "check: whether an input or an argument can be used": "checked judged",
    "progress: how far long work is": "counted restless",
}
"""Words for things, each with those that are not used for it."""
# The two programs, and the two doors, which have a `check` each; a command has the name of the function that it calls.
TWICE = {"main", "check", "doctor"}
COMMANDS = {
    "continuum/front/commands.py",
    "continuum/front/map_commands.py",
    "continuum/view/commands.py",
    "continuum/paper/commands.py",
    "atomistic/front/commands.py",
}


class Names(NamedTuple):
    """The names of a module: its trees themselves would be a million objects, which every test after would carry."""

    defined: tuple[tuple[str, bool, bool], ...]
    """Classes and functions, each with whether it is a class, and whether it stands at the top."""
    given: frozenset[str]
    """Fields and arguments."""


@cache
def names_of(path: Path) -> Names:
    tree = ast.parse(path.read_text())
    top, defined, given = set(tree.body), [], set[str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            defined.append((node.name, isinstance(node, ast.ClassDef), node in top))
        elif isinstance(node, ast.arg):
            given.add(node.arg)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            given.add(node.target.id)
    return Names(tuple(defined), frozenset(given))


def public(*, functions: bool = True, methods: bool = False) -> dict[str, list[str]]:
    """Public names of classes, and of functions, with the modules that define them."""
    found = defaultdict(list)
    for path in MODULES:
        where = path.relative_to(ROOT).as_posix()
        for name, of_class, at_top in names_of(path).defined:
            wanted = (of_class or functions) and (methods or at_top) and not name.startswith("_")
            if wanted and where not in COMMANDS:
                found[name].append(where)
    return found


def test_no_public_name_is_defined_twice() -> None:
    names = public()
    twice = {name: places for name, places in names.items() if len(places) > 1 and name not in TWICE}
    assert not twice


def test_classes_are_nouns() -> None:
    participles = {name for name in public(functions=False) if re.search(r"[a-z]ed$", name)}
    assert not participles


def test_a_threshold_is_no_turn() -> None:
    """Of modules, columns, keys and arguments too: the word had four meanings.  Old names in stored files are read."""
    for path in MODULES:
        names = names_of(path).given | {path.stem}
        assert not {name for name in names if {"turn", "turns"} & set(name.split("_"))}, path


def test_words_that_are_ruled_out_are_not_in_names() -> None:
    ruled_out = {word: said for said, words in NOT_SAID.items() for word in words.split()}
    names = public(methods=True)
    for name, places in names.items():
        words = {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)}
        for word in words & set(ruled_out):
            raise AssertionError(f"{name} in {places}: {ruled_out[word]}, not {word}")
