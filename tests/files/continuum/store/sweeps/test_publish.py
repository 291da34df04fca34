"""A published sweep: the page leads nowhere else, an archive reads its metadata, and no file of others is lost."""

from __future__ import annotations

import csv
import json
import re
import shutil
import socket
import subprocess
import sys
from datetime import date
from html.parser import HTMLParser
from itertools import islice
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
import xarray

import continuum as c
from continuum.front.cli import main
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from continuum.paper import publication
from continuum.paper.page import drawings_of
from continuum.paper.publication import Creator, sweep_publish
from continuum.store.provenance import Citation
from tests.problems import SMALL

ROOT = Path(__file__).parents[5]
DEEP = SMALL.replace("lambda_s = 6.0", "lambda_s = 4.0").replace("1.2]", "1.05]")
"""Pressed until there are enough asperities for verdicts."""


class Links(HTMLParser):
    """What a page leads to, and its tables by their titles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.targets, self.opened, self.text = list[str](), list[str](), list[str]()
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "img", "br", "link"):
            self.opened.append(tag)
        self.targets += [value or "" for name, value in attrs if name in ("href", "src")]

    def handle_endtag(self, tag: str) -> None:
        assert self.opened.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep")
    axes = '[sweep.axes]\n"surface.seed" = [1, 2]\n"wall.adhesion_length" = [0.0, 0.005]\n'
    (folder / "many.toml").write_text(DEEP + axes)
    return c.sweep(folder / "many.toml", folder).folder


@pytest.fixture(scope="module")
def place(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """As the command leaves it, on a machine whose name can be told from all else; with one figure, as tests of
    ``paper`` draw them all.
    """
    folder = tmp_path_factory.mktemp("published") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket, "gethostname", lambda: "machine-of-the-author")
        patch.setattr(publication, "drawings_of", lambda data: islice(drawings_of(data), 1))
        assert main(["sweep", "publish", str(root), "-o", str(folder), "--creator", "Doe, Jane", "-q"]) == 0
    return folder


@pytest.fixture
def copy(place: Path, tmp_path: Path) -> Path:
    shutil.copytree(place, tmp_path / "out")
    return tmp_path / "out"


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a sweep that has points for none; drawing takes most of the time."""
    monkeypatch.setattr(publication, "drawings_of", lambda data: iter(()))


@pytest.fixture
def no_netcdf(monkeypatch: pytest.MonkeyPatch) -> None:
    """The table of HDF5 is renamed: to write another of a hundred columns takes as long as all else."""
    monkeypatch.setattr(publication, "_as_netcdf", lambda found, cube: cube.rename(cube.with_suffix(".nc")))


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_all_that_the_page_leads_to_lies_in_the_folder(place: Path) -> None:
    page = Links((place / "index.html").read_text())
    assert not page.opened
    links = [target for target in page.targets if not target.startswith("data:image/png;base64,")]
    assert {"table.csv", "table.nc", "sweep.toml", ".zenodo.json"} <= set(links)
    assert all((place / unquote(link)).is_file() and "/" not in link for link in links), links
    assert set(links) | {"index.html", "SHA256SUMS"} == {path.name for path in place.iterdir()}
    assert len(page.targets) > len(links), "it has figures"


def test_the_page_has_verdicts_columns_versions_and_how_to_cite(place: Path) -> None:
    text = " ".join(Links((place / "index.html").read_text()).text)
    for said in (
        "Claims of the paper",
        "kappa_rep is close to 2 without adhesion",
        "4 of 4 systems done, 20 converged points",
        "A_rep/A0",
        f"stickiness {c.__version__}, python {sys.version.split()[0]}, numpy {np.__version__}",
        "continuum sweep run sweep.toml",
        "Doe, Jane: Sweep many",
        Citation.read().paper,
        Citation.read().program,
    ):
        assert said in text, said
    assert "Warnings" not in text


def test_nothing_tells_the_machine(root: Path, place: Path) -> None:
    for name, data in content(place).items():
        assert b"machine-of-the-author" not in data, name
        assert str(root.parent).encode() not in data, name


def test_the_metadata_is_what_zenodo_asks_for(place: Path) -> None:
    said = json.loads((place / ".zenodo.json").read_text())
    assert said["upload_type"] == "dataset"
    assert said["creators"] == [{"name": "Doe, Jane"}]
    assert said["license"] == "cc-by-4.0"
    assert all(isinstance(said[key], str) and said[key] for key in ("title", "description"))
    assert "adhesion" in said["keywords"]
    paper, *program = said["related_identifiers"]
    assert paper["identifier"] == "10.1073/pnas.1320846111"
    for one in program:  # none where the commit is not known
        assert re.fullmatch("swh:1:rev:[0-9a-f]{40}", one["identifier"])
        assert one["resource_type"] == "software"


def test_the_folder_is_an_ro_crate(place: Path) -> None:
    """Its root and descriptor are as RO-Crate 1.1 asks for, each link leads to an entity, and each file is listed."""
    crate = json.loads((place / "ro-crate-metadata.json").read_text())
    assert crate["@context"] == ["https://w3id.org/ro/crate/1.1/context", {"sha256": "http://schema.org/sha256"}]
    graph = {one["@id"]: one for one in crate["@graph"]}
    assert graph["ro-crate-metadata.json"]["about"] == {"@id": "./"}
    root = graph["./"]
    assert {"name", "description", "datePublished", "license"} <= root.keys()
    date.fromisoformat(root["datePublished"])
    terms = graph[root["license"]["@id"]]
    assert terms["@id"] == "http://spdx.org/licenses/CC-BY-4.0"
    assert terms["name"]
    assert terms["description"]
    for entity in graph.values():
        for value in entity.values():
            for link in value if isinstance(value, list) else [value]:
                if isinstance(link, dict) and link["@id"] != "https://w3id.org/ro/crate/1.1":
                    assert link["@id"] in graph
    beside = {path.name for path in place.iterdir()} - {"ro-crate-metadata.json", "SHA256SUMS"}
    assert {part["@id"] for part in root["hasPart"]} == beside
    assert all(graph[name]["contentSize"] == str((place / name).stat().st_size) for name in beside)
    assert all(graph[name]["description"] for name in beside if not name.endswith(".py"))
    assert graph["sweep.toml"]["encodingFormat"] == "application/toml"
    assert root["mentions"] == {"@id": "#sweep"}
    (made,) = (one for one in graph.values() if one["@type"] == "CreateAction")
    assert graph[made["instrument"]["@id"]]["@type"] == "SoftwareApplication"


def test_an_orcid_is_checked_by_its_last_digit() -> None:
    for text in ("Carberry, Josiah; 0000-0002-1825-0097", "Carberry, Josiah (https://orcid.org/0000-0002-1825-0097)"):
        found = Creator.of(text)
        assert found.zenodo == {"name": "Carberry, Josiah", "orcid": "0000-0002-1825-0097"}
    assert Creator.of("Doe, Jane").zenodo == {"name": "Doe, Jane"}
    with pytest.raises(ArgumentError, match="a digit of the ORCID is wrong"):
        Creator.of("Carberry, Josiah; 0000-0002-1825-0098")


def test_both_tables_have_all_points(root: Path, place: Path) -> None:
    found = c.sweep_collect(root)
    with (place / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["area_rep"]) for row in rows] == found["area_rep"].tolist()
    assert len(rows) == 20
    with (
        xarray.open_dataset(place / "table.nc") as table,
        xarray.open_dataset(root / "table.h5", engine="h5netcdf") as stored,
    ):
        xarray.testing.assert_equal(table, stored)
        assert dict(table.sizes) == {"surface.seed": 2, "wall.adhesion_length": 2, "step": 5}
        np.testing.assert_array_equal(np.sort(table["load_net"].values.ravel()), np.sort(found["load"]))
        assert table["load_net"].attrs["units"] == "E*"
        assert table.attrs["written_with_stickiness"] == c.__version__
    assert (place / "sweep.toml").read_bytes() == (root / "sweep.toml").read_bytes()


@pytest.mark.usefixtures("no_figures", "no_netcdf")
def test_a_folder_of_others_is_refused_in_one_message(
    root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    (tmp_path / "table.csv").write_text("mine")
    before = content(tmp_path)
    assert main(["sweep", "publish", str(root), "-o", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "has not written, and is left alone" in said
    assert content(tmp_path) == before
    assert main(["sweep", "publish", str(root), "-o", str(tmp_path), "--force", "-q"]) == 0
    assert (tmp_path / "thesis.tex").read_text() == "years of work"
    assert (tmp_path / "table.csv").read_text().startswith("system,")


@pytest.mark.usefixtures("no_figures", "no_netcdf")
def test_what_was_published_before_is_written_anew_but_not_over_a_change(
    root: Path, copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (copy / "notes.md").write_text("mine, beside it")
    text, name = (copy / "SHA256SUMS").read_text(), "figure-of-old.png"
    (copy / name).write_bytes(b"")
    empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    (copy / "SHA256SUMS").write_text(f"{text}{empty}  {name}\n")
    done = sweep_publish(root, copy, title="A second time")
    assert done.warnings == ("the creators are those of the program; name yours with --creator 'Family, Given'",)
    assert json.loads((copy / ".zenodo.json").read_text())["title"] == "A second time"
    assert not (copy / name).exists()
    assert (copy / "notes.md").is_file()
    (copy / ".zenodo.json").write_text("with a description by hand")
    before = content(copy)
    assert main(["sweep", "publish", str(root), "-o", str(copy)]) == 2
    assert ".zenodo.json: is not as `continuum sweep publish` has written it" in capsys.readouterr().err
    assert content(copy) == before


def test_the_folder_of_the_sweep_is_never_the_place(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (root / "sweep.toml").read_bytes(), {path.name for path in root.iterdir()}
    for force in ([], ["--force"]):
        assert main(["sweep", "publish", str(root), "-o", str(root), *force]) == 2
        assert "is left alone" in capsys.readouterr().err
    assert ((root / "sweep.toml").read_bytes(), {path.name for path in root.iterdir()}) == before


@pytest.mark.usefixtures("no_figures", "no_netcdf")
def test_what_is_missing_is_said(root: Path, tmp_path: Path) -> None:
    shutil.copytree(root, tmp_path / "part")
    first, *_, last = sorted((tmp_path / "part" / "points").iterdir())
    first.unlink()
    last.write_bytes(b"damaged")
    done = sweep_publish(tmp_path / "part", tmp_path / "out", creators=["Doe, Jane"])
    assert len(done.warnings) == 2
    assert "1 of 4 systems are not done" in (tmp_path / "out" / "index.html").read_text()
    for point in (tmp_path / "part" / "points").iterdir():
        point.unlink()
    with pytest.raises(InputError, match="no system of this sweep is done"):
        sweep_publish(tmp_path / "part", tmp_path / "none")
    assert not (tmp_path / "none").exists()


@pytest.mark.long
def test_a_sweep_into_full_contact_is_published(tmp_path: Path) -> None:
    """Where all is contact it has no edge: no perimeter, no mean diameter, no rim of attraction."""
    (tmp_path / "full.toml").write_text(SMALL.replace("1.2]", "0.9]") + '[sweep.axes]\n"surface.seed" = [1]\n')
    root = c.sweep(tmp_path / "full.toml", tmp_path).folder
    done = sweep_publish(root, tmp_path / "out", creators=["Doe, Jane"])
    assert done.table["area_rep"].max() == 1
    assert not (tmp_path / "out" / "figure3.png").exists(), "its only points with enough asperities have no edge"


@pytest.mark.parametrize(
    "axis",
    [pytest.param('"wall.adhesion_length" = [0.0, 0.005]', marks=pytest.mark.long), '"surface.path" = ["map.npy"]'],
)
@pytest.mark.usefixtures("no_netcdf")
def test_files_that_the_input_reads_are_named(axis: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def named(drawing: object, stem: Path) -> tuple[Path, Path]:
        """A figure takes seconds; which there are is asked here."""
        files = stem.with_name(f"{stem.name}.png"), stem.with_name(f"{stem.name}.csv")
        for path in files:
            path.write_bytes(b"")
        return files

    monkeypatch.setattr(publication, "save_drawing", named)
    heights = np.random.default_rng(1).normal(size=(24, 30)).cumsum(0).cumsum(1)
    np.save(tmp_path / "map.npy", heights / 500)
    surface = re.compile(r"\[surface\].*?\n\n", re.DOTALL)
    text = surface.sub('[surface]\nkind = "file"\npath = "map.npy"\n\n', SMALL)
    (tmp_path / "mine.toml").write_text(f"{text}[sweep.axes]\n{axis}\n")
    done = sweep_publish(c.sweep(tmp_path / "mine.toml", tmp_path).folder, tmp_path / "out", creators=["Doe, Jane"])
    assert (tmp_path / "out" / "figure-s1.png").exists()
    assert not (tmp_path / "out" / "figure-s3.png").exists(), "no symbol of the paper has the size of an unknown λ_s"
    assert done.warnings == ("the input reads files that are not part of this folder: map.npy",)


@pytest.mark.parametrize(
    ("name", "value"), [("title", ""), ("title", "two\nlines"), ("creators", "Doe"), ("creators", [1]), ("license", 3)]
)
def test_what_is_no_line_of_text_is_refused_by_its_name(root: Path, tmp_path: Path, name: str, value: object) -> None:
    with pytest.raises(InputError, match=name):
        sweep_publish(root, tmp_path / "out", **{name: value})
    assert not (tmp_path / "out").exists()


def test_the_citation_is_that_of_the_page_of_the_site() -> None:
    said = " ".join((ROOT / "docs" / "cite.md").read_text().replace(">", " ").split())
    plain = re.sub(r"\[(.*?)\]\(.*?\)|\*+", lambda found: found[1] or "", said)
    assert Citation.read().paper in plain
    assert Citation.read().version == c.__version__


def test_a_browser_opens_the_page(place: Path, tmp_path: Path) -> None:
    browser = shutil.which("chromium")
    if browser is None:
        pytest.skip("needs chromium")
    picture = tmp_path / "page.png"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1100,1600", f"--screenshot={picture}"]
    options += [f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom"]
    url = (place / "index.html").resolve().as_uri()
    done = subprocess.run([browser, *options, url], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert picture.stat().st_size > 20_000
    # What the browser has made of it has a table of verdicts and every figure of the folder.
    assert "Claims of the paper" in done.stdout
    assert done.stdout.count("<img") == len(list(place.glob("*.png")))
