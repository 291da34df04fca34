"""The pages of the site say what is there: inputs, commands, options, names; and the site builds without a warning."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import textwrap
import tomllib
from collections import defaultdict
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from functools import cache
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest

import atomistic.front.cli
import continuum.front.cli
from continuum.inputs.keys import LARGEST_N
from continuum.measure.outline import outline
from continuum.model.grid import Grid
from continuum.model.problem import POINTS, SMALL_SLOPE
from continuum.model.surface import LARGEST_SLOPE
from continuum.paper.figures import FIGURES
from continuum.store.provenance import Citation
from continuum.store.runs.config import UNDER_A_HARD_WALL, UNDER_A_LAW
from docs import certificate
from docs.studies.map_of_the_tutorial import HEAD, MAP, heights

ROOT = Path(__file__).parents[2]
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text() for path in (ROOT / "docs").rglob("*.md")
         if (ROOT / "docs" / "reference") not in path.parents}  # fmt: skip
PAGES["README.md"] = (ROOT / "README.md").read_text()


def anchors(text: str) -> set[str]:
    """Of the headings of a page, as the site and hosts of code make them."""
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_every_input_and_picture_named_exists() -> None:
    for page in PAGES:
        text, folder = PAGES[page], (ROOT / page).parent
        for path in re.findall(r"\binputs/[\w-]+/[\w.-]+\.toml", text):
            assert (ROOT / path).is_file() or f"```toml\n# {path}\n" in text, path  # or the page itself has it
        for target, anchor in re.findall(r"\]\(([^)#:]*)(?:#([^):]*))?\)", text):
            if "reference/" in target:  # made with the site
                continue
            assert (folder / target).exists(), target
            if anchor:
                there = (folder / target).resolve().relative_to(ROOT).as_posix() if target else page
                assert anchor in anchors(PAGES[there]), f"{target}#{anchor}"


def test_every_script_and_table_named_exists() -> None:
    """In pages, docstrings and the Makefile: of docs and tests, by path or as a module."""
    sources = [path for room in ("atomistic", "continuum", "docs", "tests") for path in (ROOT / room).rglob("*.py")]
    named = set[str]()
    for text in (*PAGES.values(), *(path.read_text() for path in (*sources, ROOT / "Makefile"))):
        named |= set(re.findall(r"\b(?:docs|tests)/[\w/-]+\.(?:py|csv(?:\.gz)?)\b", text))
        for module in re.findall(r"(?:-m |`)((?:docs|tests)(?:\.[a-z]\w*)+)", text):
            path = module.replace(".", "/")
            named.add(f"{path}/__init__.py" if (ROOT / path).is_dir() else f"{path}.py")
    assert len(named) > 40
    assert not {name for name in named if not (ROOT / name).is_file()}


def test_every_script_of_the_studies_has_a_page_or_stands_on_one() -> None:
    folder, text = ROOT / "docs" / "studies", "".join(PAGES.values())
    scripts = {path.stem for path in folder.glob("*.py")} | {path.parent.name for path in folder.glob("*/__init__.py")}
    for name in scripts - {"__init__", "pages", "tables"}:
        paged = (folder / f"{name.removesuffix('_judged')}.md").is_file()
        assert paged or re.search(rf"docs\.studies\.{name}\b|`{name}`", text), name


@cache
def code() -> dict[str, dict[str, str]]:
    """Modules, functions, classes and what these have, of the rooms that solve: each name's text by its module."""
    found: dict[str, dict[str, str]] = defaultdict(dict)
    for path in (
        path for room in ("front", "path", "solve", "model") for path in (ROOT / "continuum" / room).rglob("*.py")
    ):
        module, text = path.relative_to(ROOT / "continuum").as_posix(), path.read_text()
        found[path.stem][module], lines = text, text.splitlines()
        tops = ast.parse(text).body
        members = [(top.name, each) for top in tops if isinstance(top, ast.ClassDef) for each in top.body]
        for within, node in [*((path.stem, top) for top in tops), *members]:
            targets = [node.target] if isinstance(node, ast.AnnAssign) else getattr(node, "targets", [node])
            named = [each for target in targets for each in getattr(target, "elts", [target])]  # of a pair, both
            for name in filter(None, (getattr(each, "id", getattr(each, "name", None)) for each in named)):
                for known in (f"{within}.{name}", name):
                    found[known][module] = "\n".join(lines[node.lineno - 1 : node.end_lineno])
    return found


def calls(caller: str, called: str) -> bool:
    """Whether the text of a function has the name of another."""
    name = rf"\b{called.rpartition('.')[2]}\b"
    return any(re.search(name, text) for text in code()[caller].values())


def test_the_solver_has_the_functions_of_its_page_and_they_call_one_another() -> None:
    page = PAGES["docs/solver.md"]
    drawings = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    prose = re.sub(r"```.*?```", "", page, flags=re.DOTALL)
    named = re.findall(r"`([A-Za-z_]\w*(?:\.\w+)*)`", prose)
    assert len(named) > 5
    assert set(named) <= set(code())
    for path in re.findall(r"`(\w+(?:/\w+)+(?:\.py)?)`", page):
        assert any((base / path).exists() for base in (ROOT, ROOT / "continuum")), path

    # Each function is called by the one above it that is less indented.
    assert [drawing.count("\n") > 15 for drawing in drawings] == [True, True]
    for drawing in drawings:
        above: list[str] = []
        for indent, name in re.findall(r"^((?:  )*)([\w.]+)", drawing, re.MULTILINE):
            del above[len(indent) // 2 :]
            assert name in code(), name
            assert not above or calls(above[-1], name), (above[-1], name)
            above.append(name)


@pytest.mark.style
def test_links_to_elsewhere_have_the_form_of_one() -> None:
    """Whether they answer is asked of a browser, not of a test: `sphinx -b linkcheck docs build/links`."""
    for page in PAGES:
        for target in re.findall(r"\]\((\w+:[^)]+)\)", PAGES[page]):
            assert re.fullmatch(r"https://[\w.-]+\.\w+(/[\w./()~%-]*)?", target), target
            if "doi.org" in target:
                assert re.fullmatch(r"https://doi\.org/10\.\d{4,}/\S+", target), target


def test_the_paper_is_cited_by_its_title_and_its_preprint_by_its_own() -> None:
    assert Citation.read().paper == (
        "L. Pastewka and M. O. Robbins, Contact between rough surfaces and a criterion for macroscopic adhesion, "
        "Proceedings of the National Academy of Sciences 111, 3298-3303 (2014), doi:10.1073/pnas.1320846111"
    )
    title = "Contact between rough surfaces and a criterion for macroscopic adhesion"
    for page in (PAGES["README.md"], PAGES["docs/cite.md"], continuum.__doc__ or ""):
        assert title in " ".join(page.replace("> ", "").split())
    for page in PAGES.values():
        assert not re.search(r"sticky\?\W{1,3}\s*(PNAS|Proceedings)", page)


def test_the_bibtex_of_the_software_has_the_fields_of_its_citation_file() -> None:
    cited, (software, article) = Citation.read(), (ROOT / "docs" / "cite.bib").read_text().split("\n\n")
    told = dict(re.findall(r"(\w+) += \{(.*)\},$", software.replace("{Green's}", "Green's"), re.MULTILINE))
    assert told["author"] == "{" + " and ".join(cited.authors) + "}"
    assert (told["title"], told["version"]) == (cited.title, cited.version)
    assert cited.doi in article
    assert f"version {cited.version} ({told['year']})" in PAGES["docs/cite.md"]


def test_every_command_and_option_named_exists() -> None:
    known = {
        f"{program} {command}"
        for program, app in {"continuum": continuum.front.cli.app, "atomistic": atomistic.front.cli.app}.items()
        for command in app.resolved_commands()
    }
    for page in PAGES:
        for line in re.findall(r"(?:^|`)((?:continuum|atomistic) [a-z][^`\n]*)", PAGES[page], re.MULTILINE):
            program, command, *words = line.split("#")[0].split()
            if f"{program} {command}" in ("continuum of", "continuum is", "continuum on") or "." in command:
                continue
            assert f"{program} {command}" in known, line
            app = {"continuum": continuum.front.cli.app, "atomistic": atomistic.front.cli.app}[program][command]
            if command == "sweep":
                app = app[words.pop(0)] if words else app
            options = {word.split("=")[0] for word in words if word.startswith("--")} - {"--help", "--version"}
            if options:
                names = {option for argument in app.assemble_argument_collection() for option in argument.names}
                assert options <= names, line


def test_the_glossary_has_the_mean_diameter_of_the_paper() -> None:
    """A_rep = P d_rep/π, above Eq. (4): of a disc the mean chord, π/4 of its diameter, where 4 A/P is the diameter."""
    entry = re.search(r"\| d_rep \| .*?(\w+) A/P", PAGES["docs/model.md"])
    assert entry is not None
    factor = {"π": np.pi}.get(entry[1]) or float(entry[1])
    grid, radius = Grid.square(256), 100.0
    x, y = (position - 128 for position in grid.positions)
    disc = outline(grid, x**2 + y**2 < radius**2)
    # The outline is known to one cell in the diameter, on each side.
    assert factor * disc.area / disc.perimeter("edges") == pytest.approx(disc.diameter("edges"), rel=1e-12)
    assert factor * disc.area / disc.perimeter("edges") == pytest.approx(np.pi / 2 * radius, rel=1 / radius)


def test_the_numbers_of_the_limits_are_those_of_the_code() -> None:
    for said in (
        f"slopes above {SMALL_SLOPE:g} (a warning), above {LARGEST_SLOPE:g} (refused)",
        f"waves of fewer than {POINTS} points",
        f"{LARGEST_N} points along a side",
        f"estimates assume {UNDER_A_LAW} and {UNDER_A_HARD_WALL}",
    ):
        assert said in PAGES["docs/limits.md"], said


def test_the_table_of_what_a_certificate_looks_at_is_made_from_the_code() -> None:
    assert certificate.on_page() == certificate.table(), "python -m docs.certificate makes it anew"


@pytest.mark.parametrize("package", [continuum, atomistic], ids=lambda package: package.__name__)
def test_the_reference_has_each_public_name_once(package: ModuleType) -> None:
    groups = tomllib.loads((ROOT / "docs" / "reference.toml").read_text())[package.__name__]
    assert sorted(name for group in groups for name in group["names"]) == sorted(package.__all__)


class Told(NamedTuple):
    """What a page takes for granted, and what a test does smaller than the page."""

    instead: Mapping[str, str] = {}
    """Text for text; each must stand in the page."""
    leaves: tuple[str, ...] = ()
    """Files that are there afterwards."""
    first: int | None = None
    """Blocks from the beginning that are followed; all if None."""


TOLD = {
    "docs/start.md": Told({}, ("results/path.h5", "mine.toml")),
    "docs/tutorials/atoms.md": Told(),
    "docs/tutorials/python.md": Told(),
}
TOLD_AT_LENGTH = {
    "README.md": Told({"make ": f"make -n -C {ROOT} "}, ("results/quick.h5", "results/wafer-predict.html")),
    "docs/predict.md": Told({}, ("results/wafer-predict.html",), first=2),
    "docs/tutorials/validate.md": Told({}, ("results/copper-contact-modulus.png", "results/quick.html")),
    "docs/tutorials/sweep.md": Told({}, ("results/many/table.csv", "results/many/figure3.png", "load.png")),
    "docs/tutorials/script.md": Told(
        {"run             20000": "run 40", "include         wall": "variable wall_every index 1\ninclude wall"},
        ("results/wall.trace.png", "wall/in.wall"),
    ),
    "docs/tutorials/copper.md": Told(
        {"run             800": "run 20", "include         wall": "variable wall_every index 1\ninclude wall"},
        ("results/wall.trace.png", "wall/wall.map"),
    ),
    "docs/tutorials/film.md": Told(
        {
            "run             12000": "run 300",
            "run             2500": "run 100",
            "run             15000": "run 20",
            "include         wall": "variable wall_every index 1\ninclude wall",
        },
        ("results/wall.trace.png", "film.data"),
    ),
    "docs/tutorials/indent.md": Told({}, ("results/indent-slip.png", "indent/state.10.dump")),
    "docs/tutorials/deck.md": Told({}, ("results/deck.h5", "deck/in.contact")),
    "docs/tutorials/map.md": Told(
        {}, tuple(f"results/wafer-predict{name}" for name in (".html", ".png", "-faults.png"))
    ),
}


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and text of the code of a page, in order; long lines of printed text are continued after two spaces."""
    found = re.finditer(r"^( *)```(\w*)\n(.*?)^\1```", PAGES[page], re.MULTILINE | re.DOTALL)
    texts = [(block[2], textwrap.dedent(block[3])) for block in found]
    return [(language, continued(text) if language == "text" else text) for language, text in texts]


def continued(text: str) -> str:
    """Printed text with each long line in one piece."""
    return re.sub(r"\n  (?=\S)", " ", text)


@pytest.mark.style
def test_code_and_printed_text_fit_a_column_of_the_site() -> None:
    """At most 88 characters a line, so that a window of 1280 px shows it beside the menu."""
    wide = [(page, line)
            for page in PAGES
            for block in re.findall(r"^ *```.*?^ *```", PAGES[page], re.MULTILINE | re.DOTALL)
            for line in block.splitlines() if len(line) > 88]  # fmt: skip
    assert not wide


def follow(page: str, told: Told, folder: Path, ran: Callable[[str, str], str]) -> None:
    """Do what a page says, block by block, each of which `ran` returns the print of; the folder is where it runs.

    The block before a block of text prints each of its lines.
    """
    done, printed, unused = 0, "", set(told.instead)
    for language, code in blocks(page)[: told.first]:
        for old, new in told.instead.items():
            unused -= {old} if old in code else set()
            code = code.replace(old, new)
        if language == "toml":
            tomllib.loads(code)
        elif language == "lammps":
            named = re.match(r"# (in\.\w+)\n", code)
            (folder / (named[1] if named else "in.mine")).write_text(code, encoding="utf-8")
        elif language == "text":
            assert set(code.splitlines()) <= set(printed.splitlines()), f"{code}\nis not in what is printed:\n{printed}"
        elif language in ("", "sh", "python"):
            done, printed = done + 1, ran(language, code)
    assert done
    assert not unused, "the page says something else by now"
    for name in told.leaves:
        assert (folder / name).stat().st_size > 500, name


def here(language: str, code: str) -> str:
    """What a block prints in this process: a script, or lines each of which is a command of ours or nothing."""
    printed = StringIO()
    with redirect_stdout(printed):
        if language == "python":
            exec(code, {"__name__": "__main__"})
            return printed.getvalue()
        for line in code.splitlines():
            command, _, file = line.partition("#")[0].partition(">")
            program, *words = command.split() or [":"]
            into = StringIO()
            with redirect_stdout(into if file else printed):
                assert (
                    program == ":"
                    or {"continuum": continuum, "atomistic": atomistic}[program].front.cli.main(words) == 0
                )
            if file:
                Path(file.strip()).write_text(into.getvalue(), encoding="utf-8")
    return printed.getvalue()


def in_processes(folder: Path) -> Callable[[str, str], str]:
    """As :func:`here`, in a shell; the commands are those of this checkout."""
    programs = folder / ".bin"
    programs.mkdir()
    for name in ("continuum", "atomistic"):
        (programs / name).write_text(f'#!/bin/sh\nexec {sys.executable} -m {name} "$@"\n')
        (programs / name).chmod(0o755)
    path = f"{programs}:{Path(sys.executable).parent}:{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": str(ROOT), "MPLBACKEND": "agg"}

    def ran(language: str, code: str) -> str:
        program = (sys.executable, "-W", "error") if language == "python" else ("bash", "-euo", "pipefail")
        ended = subprocess.run(
            [*program, "-c", code],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=1200,
            check=False,
        )
        assert ended.returncode == 0, f"{code}\n{ended.stdout[-2000:]}{ended.stderr[-2000:]}"
        return ended.stdout

    return ran


@pytest.mark.style
def test_the_page_of_predictions_is_a_manual_not_a_logbook() -> None:
    """The answer that it shows is that of the README and of the tutorial."""
    (answer,) = (code for language, code in blocks("docs/predict.md") if language == "text")
    assert len(answer.splitlines()) <= 10
    for page in ("README.md", "docs/tutorials/map.md"):
        shown = [code.splitlines() for language, code in blocks(page) if language == "text" and "Sticky: " in code]
        assert shown, page
        assert set(shown[0]) <= set(answer.splitlines()), page


def test_the_code_of_every_page_that_shows_some_to_follow_is_run() -> None:
    shown = {page for page in PAGES if page.startswith("docs/tutorials/")} | {
        "README.md",
        "docs/start.md",
        "docs/predict.md",
    }
    assert shown == set(TOLD) | set(TOLD_AT_LENGTH)


@pytest.mark.parametrize("page", TOLD)
def test_a_page_can_be_followed_as_printed(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    follow(page, TOLD[page], tmp_path, here)


@pytest.mark.long
@pytest.mark.parametrize("page", TOLD | TOLD_AT_LENGTH)
def test_a_page_can_be_followed_in_a_shell(page: str, tmp_path: Path) -> None:
    follow(page, (TOLD | TOLD_AT_LENGTH)[page], tmp_path, in_processes(tmp_path))


def test_the_map_of_the_tutorial_is_what_its_script_makes() -> None:
    lines = MAP.read_text(encoding="utf-8").splitlines()
    assert [line[2:] for line in lines if line.startswith("#")] == HEAD.splitlines()
    # Written to 0.01 nm.
    np.testing.assert_allclose(np.loadtxt(MAP).T, heights(), rtol=0, atol=0.00501)


def test_the_same_job_here_and_in_other_codes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Our side of each job always, the other side where its code is installed, as in the extra `bench`."""
    monkeypatch.chdir(tmp_path)
    ours = 0
    for code in (code for language, code in blocks("docs/peers.md") if language == "python"):
        peers = set(re.findall(r"^(?:import|from) (tamaas|ContactMechanics|matscipy)\b", code, re.MULTILINE))
        if not peers:
            exec(code, {})
            ours += 1
        elif all(map(find_spec, peers)):
            assert "continuum" not in code, "a code of others has a block of its own, so that ours always runs"
            subprocess.run([sys.executable, "-c", code], check=True, timeout=600)
    assert ours == 4
    assert (tmp_path / "deck" / "in.contact").is_file()
    headings = re.findall(r"^## (.*)$", PAGES["docs/peers.md"], re.MULTILINE)
    assert {"USER-GFMD", "matscipy", "contact.engineering"} < set(headings)


@pytest.mark.style
def test_the_gallery_is_ten_examples_of_one_screen_each() -> None:
    gallery = sorted((ROOT / "docs" / "gallery").glob("*.py"))
    assert [path.stem[:7] for path in gallery] == [f"plot_{i:02}" for i in range(1, 11)]
    assert {path.stem: n for path in gallery if (n := len(path.read_text().splitlines())) > 48} == {}


@pytest.mark.style
def test_every_picture_stands_on_a_page() -> None:
    shown = {
        ((ROOT / page).parent / target).resolve()
        for page, text in PAGES.items()
        for target in re.findall(r"\]\(([^)#:]*\.(?:png|svg))\)", text)
    }
    assert set((ROOT / "docs").rglob("*.png")) - shown - set((ROOT / "docs" / "reference").rglob("*.png")) == set()


@pytest.mark.style
def test_pages_figures_and_data_are_small() -> None:
    """``python -m docs.smaller`` makes figures smaller; large tables are compressed."""
    made = {"reference", "__pycache__"}
    files = [path for path in (ROOT / "docs").rglob("*") if path.is_file() and not made & set(path.parts)]
    assert sum(path.stat().st_size for path in files) < 6_000_000


@pytest.mark.style
def test_the_page_of_all_sweeps_shows_no_quantity_more_than_twice() -> None:
    stems = re.findall(r"\]\(paper-([\w-]+)\.png\)", PAGES["docs/measured/paper.md"])
    names = [max((name for name in FIGURES if stem.endswith(f"-{name}")), key=len) for stem in stems]
    assert len(set(names)) > 8
    assert max(map(names.count, names)) <= 2


def clicks(start: str) -> dict[str, int]:
    """How many links in the text of pages lead from one to each other, at least; those in the margin do not count."""
    found, reached = {start: 0}, [start]
    for page in reached:
        for target in re.findall(r"\]\(([\w./-]+\.md)", PAGES[page]):
            there = os.path.relpath((ROOT / page).parent / target, ROOT)
            if there in PAGES and there not in found:
                found[there] = found[page] + 1
                reached.append(there)
    return found


@pytest.mark.style
def test_what_a_physicist_asks_first_is_few_clicks_from_the_first_page() -> None:
    """How to press his own map, what the program cannot do, and how well the paper is reproduced."""
    found = clicks("docs/index.md")
    for page in ("tutorials/map", "tutorials/validate", "tutorials/sweep", "limits", "trust", "paper"):
        assert found[f"docs/{page}.md"] == 1, page
    readme = clicks("README.md")
    for page in ("tutorials/map", "limits", "paper", "trust", "cite"):
        assert readme[f"docs/{page}.md"] <= 2, page
