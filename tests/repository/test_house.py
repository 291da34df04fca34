"""The page of the structure: its drawing has the present imports, and each function of a call chain calls the next."""

from __future__ import annotations

import ast
import re
import sys
from itertools import pairwise
from pathlib import Path
from traceback import walk_stack
from types import FrameType
from xml.etree import ElementTree

import numpy as np
import pytest

from continuum.front.cli import main
from docs.house import APART, DRAWING, ROOT, below, edges, levels, on_page, places, reduced, rooms, tables

pytestmark = pytest.mark.style

PAGE = (ROOT / "docs/house.md").read_text(encoding="utf-8")
WALK = PAGE.partition("## Where to look")[2]
STEP = r"`([\w.]+)` in\s`((?:atomistic|continuum)/[\w/]+\.py)`"


def test_the_drawing_is_of_the_imports_of_now() -> None:
    graph = rooms()
    root = ElementTree.parse(DRAWING).getroot()
    (stored,) = (each.text for each in root.iter("{http://purl.org/dc/elements/1.1/}description"))
    assert stored == edges(graph), "python -m docs.house draws it anew"
    shown = {text for each in root.iter("{http://www.w3.org/2000/svg}text") if (text := each.text)}
    assert {room.partition(".")[2] for room in graph} <= shown


def test_an_arrow_that_is_left_out_follows_from_those_that_are_drawn() -> None:
    graph = rooms()
    drawn, height = reduced(graph), levels(graph)
    for room, asked in graph.items():
        assert drawn[room] <= asked
        assert below(drawn, room) == below(graph, room)
        assert all(height[one] < height[room] for one in asked)


def test_the_tables_have_the_first_line_of_each_room() -> None:
    assert on_page() == tables(), "python -m docs.house makes them anew"
    assert tables().count("\n| `") == len(rooms()) + 1  # the head of the second table, too
    assert not re.search(r"\|  \|$", tables(), re.MULTILINE)


def text_of(name: str, path: str) -> str:
    """The text of a function, a class or a member of it, which a page names after its module or class."""
    text = (ROOT / path).read_text(encoding="utf-8")
    within, _, last = name.rpartition(".")
    body: list[ast.stmt] = ast.parse(text).body
    if within and within != path.rpartition("/")[2].removesuffix(".py"):
        (body,) = (each.body for each in body if isinstance(each, ast.ClassDef) and each.name == within)
    kinds = (ast.FunctionDef, ast.ClassDef)
    (found,) = (ast.get_source_segment(text, each) for each in body if isinstance(each, kinds) and each.name == last)
    assert found
    return found


def test_what_the_walk_names_is_there_and_each_function_of_a_list_calls_the_next() -> None:
    places = re.findall(STEP, WALK)
    assert len(places) > 15
    texts = {place: text_of(*place) for place in places}
    for path in re.findall(r"`((?:atomistic|continuum)/[\w/]+\.\w+)`", WALK):
        assert (ROOT / path).is_file(), path
    lists = re.findall(r"(?:^\d+\. .*\n(?:   .*\n)*)+", WALK, re.MULTILINE)
    assert len(lists) == WALK.count("\n### ") == 2
    for each in lists:
        steps = re.findall(rf"^\d+\. {STEP}", each, re.MULTILINE)
        assert len(steps) == len(re.findall(r"^\d+\. ", each, re.MULTILINE)) > 3
        for before, (after, _) in pairwise(steps):
            assert re.search(rf"\b{after.rpartition('.')[2]}\b", texts[before].partition("\n")[2]), (before, after)


def test_each_name_in_the_walk_that_has_a_module_says_where_it_is() -> None:
    """So that every step can be jumped to: a dotted name stands with its file."""
    named = set(re.findall(r"`(\w+\.\w+)`", WALK))
    assert named <= {name for name, _ in re.findall(STEP, WALK)}


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "last"),
    [
        (["run", "inputs/smoke/nonadhesive.toml"], ("smooth_grid.py", "_step_along")),
        (["predict", "map.npy", "--size", "10um", "--unit", "nm", "--modulus", "2MPa", "--poisson", "0.5",
          "--work", "50mJ/m2", "--range", "5nm"], ("bound_grid.py", "curvature")),
    ],
)  # fmt: skip
def test_a_command_reaches_compiled_code_through_twelve_files(
    command: list[str], last: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those of the calls that are open when the compiled grids first sweep over the points of a contact."""
    np.save(tmp_path / "map.npy", 2 * np.random.default_rng(1).standard_normal((32, 32)))
    named = [str(tmp_path / word) if word == "map.npy" else word for word in command]
    walked: list[str] = []

    def record(frame: FrameType, event: str, argument: object) -> None:
        code = frame.f_code
        if event == "call" and not walked and (Path(code.co_filename).name, code.co_name) == last:
            open_calls = (call.f_code.co_filename for call, _ in walk_stack(frame))
            walked.extend(file for file in open_calls if file.startswith(str(ROOT / "continuum")))

    sys.setprofile(record)
    try:
        main([*named, "-o", str(tmp_path)])
    finally:
        sys.setprofile(None)
    capsys.readouterr()
    assert 8 < len(set(walked)) <= 12


def test_no_room_is_drawn_on_another() -> None:
    shown = reduced(rooms())
    place = places(shown)
    assert min(abs(place[one][0] - place[other][0]) for one in shown for other in shown
               if one < other and place[one][1] == place[other][1]) > APART - 1e-9  # fmt: skip
