"""What docs/contribute.md and additions.md add is put into a copy of the source; tests of all kinds run it."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/contribute.md").read_text(encoding="utf-8")
FURTHER = Path(__file__).with_name("additions.md").read_text(encoding="utf-8")
"""Examples for which the page has no room."""
TESTS = "test_page.py"
FILE = re.compile(r"(?:#|\+\+\+) ((?:atomistic|continuum|docs|inputs)/[\w/.-]+)\n")


class Section(NamedTuple):
    """What a section of the page adds, and how it is used."""

    blocks: tuple[tuple[str, str], ...]
    """Language and text of each block that is put into files."""
    use: str
    """The last block."""

    @property
    def files(self) -> list[str]:
        return [named[1] for _, text in self.blocks if (named := FILE.match(text))]


def _section(text: str) -> Section:
    *blocks, (language, use) = re.findall(r"^```(\w+)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert language == "python"
    assert "\nassert " in use
    return Section(tuple(blocks), use)


SECTIONS = {
    title.removeprefix("A ").removeprefix("An ").replace("Green's ", ""): _section(text)
    for title, text in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", f"{PAGE}\n{FURTHER}", re.MULTILINE | re.DOTALL)
}
NEW = {
    "wall law": ("morse", "doors/continuum/inputs/test_tables physics/continuum/model/test_consistency"
                          " physics/continuum/model/test_wall physics/atomistic/lammps/test_law"),
    "function": ("surface-tension", "doors/continuum/inputs/test_tables physics/continuum/model/test_consistency"),
    "criterion": ("margin_is_the_factor", "physics/continuum/theory/test_theory"),
    "material": ("page_has_the_table", "physics/continuum/maps/verdict/test_predict"),
    "deck protocol": ("an_input_for_each_protocol or took[press]", "physics/atomistic/ladder/test_cost"),
    "column": ("result_holds_what", "files/continuum/store/runs/test_run"),
}  # fmt: skip
"""Words in the names of tests of all kinds, and their files."""


def changed(block: str, text: str) -> str:
    """A text with the hunks of a diff, each of which fits one place."""
    for hunk in FILE.sub("", block, count=1).split("@@\n"):
        lines = [(line[:1], line[1:] + "\n") for line in hunk.splitlines()]
        before, after = ("".join(line for mark, line in lines if mark != other) for other in "+-")
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    return text


def added(block: str, text: str, module: str) -> str:
    """A file with a block at its end, without what the block imports from this file itself or a script has from it."""
    lines = FILE.sub("", block, count=1)
    for node in ast.parse(lines).body if text and module.endswith(".py") else ():
        if isinstance(node, ast.ImportFrom) and node.module == module.removesuffix(".py").replace("/", "."):
            lines = lines.replace(f"{ast.get_source_segment(lines, node)}\n", "")
    return f"{text}\n\n{lines}".lstrip()


def copied(place: Path, files: dict[str, str]) -> None:
    """The source with other texts of some files: all others are links, with what is compiled of them."""
    folders = {folder for name in files for folder in Path(name).parents}
    for folder in sorted(folders, key=lambda folder: len(folder.parts)):
        (place / folder).mkdir(exist_ok=True)
        for found in (ROOT / folder).iterdir():
            name = found.relative_to(ROOT)
            if name not in folders and name.as_posix() not in files:
                (place / name).symlink_to(found)
    for name, text in files.items():
        (place / name).write_text(text, encoding="utf-8")


def with_all_sections() -> dict[str, str]:
    """Every file that the page touches, with what it adds."""
    files: dict[str, str] = {}
    for section in SECTIONS.values():
        for (language, block), name in zip(section.blocks, section.files, strict=True):
            path = ROOT / name
            text = files.get(name, path.read_text(encoding="utf-8") if path.exists() else "")
            files[name] = changed(block, text) if language == "diff" else added(block, text, name)
    return files


def used(section: Section) -> str:
    """A test that does what a section does with the new thing."""
    lines = "".join(f"    {line}\n" if line else "\n" for line in section.use.splitlines())
    name = next(name for name, one in SECTIONS.items() if one is section).replace(" ", "_")
    return f"def test_{name}(tmp_path, monkeypatch):\n    monkeypatch.chdir(tmp_path)\n{lines}\n\n"


OF_A_LAW = """
def test_a_table_has_the_tension_of_its_law_and_lammps_its_traction(tmp_path):
    import atomistic as a
    import continuum as c

    morse = {"law": "morse", "depth": 0.005, "inverse_width": 3.0}
    wall = c.run("inputs/smoke/nonadhesive.toml", tmp_path, settings={"wall": morse}).wall
    assert abs(wall.largest_tension - 0.005 * 3.0 / 2) < 1e-6  # at z0 + ln(2)/a

    contact = c.Contact(c.sine(c.Grid.square(4), 0.1, (1, 0)), wall=wall)
    run = a.run_deck(a.deck(contact, separation=1.2, depth=3).write(tmp_path / "morse"))
    gap = run.last.gap
    below = gap + 0.5**0.5  # the second layer feels the law at its own distance
    layer = run.wall.evaluate(gap).traction - run.wall.evaluate(below).traction
    assert abs(run.last.traction - layer).max() < 1e-6  # as LAMMPS computed it
"""
OF_A_COLUMN = """
def test_a_file_of_before_the_column_is_read(tmp_path):
    import h5py
    import math
    import continuum as c

    path = c.run("inputs/smoke/nonadhesive.toml", tmp_path).path
    with h5py.File(path, "a") as file:
        del file["rms_gap"]
    assert all(math.isnan(point.rms_gap) for point in c.Result.read(path).points)
    assert c.run("inputs/smoke/nonadhesive.toml", tmp_path).resumed


def test_the_reference_has_the_column():
    import pytest

    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    from docs.from_source import columns

    assert "| `rms_gap` | root mean square of the gap | a0 |" in columns()
"""


def test_each_is_at_most_two_files_and_the_table_names_them() -> None:
    for name, section in SECTIONS.items():
        assert 1 <= len(set(section.files)) <= 2, name
        assert len(section.blocks) == len(section.files), name
        for file in section.files:
            (row,) = re.findall(rf"^\| (?:a|an) [^|]*{name}[^|]* \| (.*) \|$", PAGE, re.MULTILINE)
            within = [part.rstrip("/") for part in re.findall(r"`([\w/.]+)`", row)]
            assert any(f"{part}/" in f"/{file}/" for part in within), (name, file)


def test_the_table_names_what_is_there() -> None:
    (table,) = re.findall(r"^\| to add .*?\n\n", PAGE, re.MULTILINE | re.DOTALL)
    named = re.findall(r"`([\w/]+/(?:[\w.]+)?)`", table)
    assert len(named) > 15
    for name in named:
        assert any((ROOT / room / name).exists() for room in (".", "continuum", "atomistic")), name


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What pytest says in a copy with all that the page adds: of the page itself, and of the tests of all kinds."""
    copy = tmp_path_factory.mktemp("copy")
    finds = "continuum/inputs/toml.py"  # which looks for inputs beside itself, not beside what it is a link to
    page = {f"tests/{TESTS}": "".join(map(used, SECTIONS.values())) + OF_A_LAW + OF_A_COLUMN}
    copied(copy, {finds: (ROOT / finds).read_text(encoding="utf-8")} | with_all_sections() | page)
    words, files = zip(*NEW.values(), strict=True)
    tests = sorted({f"tests/{name}.py" for each in files for name in each.split()})
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [
        sys.executable, "-m", "pytest", "-v", "-p", "no:cacheprovider", "--basetemp", str(copy / "pytest"),
        "--hypothesis-profile", "few", "-k", " or ".join(("test_page", *words)),
    ]  # fmt: skip
    done = subprocess.run(
        [*command, *page, *tests], cwd=copy, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("name", SECTIONS)
def test_what_the_page_adds_works(ran: str, name: str) -> None:
    further = {"column": "a_file_of_before", "wall law": "a_table_has_the_tension"}
    for test in (name.replace(" ", "_"), *([further[name]] if name in further else [])):
        assert re.search(rf"test_page.py::test_{test}\w* PASSED", ran)
    words, files = NEW.get(name, ("", ""))
    passed = {
        line.partition("::")[0]
        for line in ran.splitlines()
        if "PASSED" in line and any(word in line for word in words.split(" or "))
    }
    assert {f"tests/{file}.py" for file in files.split()} <= passed


IN_A_SCRIPT = ("wall law", "function", "criterion", "artefact", "deck protocol")


@pytest.mark.long
@pytest.mark.parametrize("name", IN_A_SCRIPT)
def test_the_same_block_defines_it_in_a_script(tmp_path: Path, name: str) -> None:
    section = SECTIONS[name]
    script = [block for language, block in section.blocks if language == "python"]
    for (language, block), file in zip(section.blocks, section.files, strict=True):
        if language == "toml":
            (tmp_path / file).parent.mkdir(parents=True)
            (tmp_path / file).write_text(FILE.sub("", block, count=1), encoding="utf-8")
    (tmp_path / "script.py").write_text("\n".join((*script, section.use)), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-W", "error", "script.py"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
