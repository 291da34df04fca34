"""The folder of a sweep: files of the user's own stay what they are, and one sweep never takes the place of another."""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import continuum as c
from continuum.front.cli import main
from continuum.inputs.errors import OutputError, StickinessError
from continuum.store import datasets as store
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.collect import LeftOutWarning
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.sweep import begin
from tests.problems import SMALL


def described(folder: Path, seeds: str, text: str = SMALL) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "many.toml"
    path.write_text(f'{text}[sweep.axes]\n"surface.seed" = {seeds}\n')
    return path


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of two systems, begun, with files in the place of results: nothing here looks into them."""
    folder = tmp_path_factory.mktemp("sweep")
    for task in begin(Sweep.read(described(folder / "a", "[1, 2]")), folder / "many"):
        task.path.write_text("a result")
    return folder


@pytest.fixture
def root(done: Path, tmp_path: Path) -> Path:
    shutil.copytree(done / "many", tmp_path / "many")
    return tmp_path / "many"


@pytest.mark.parametrize("name", ["sweep.toml", "systems.json", "table.csv", "table.h5", "points/mine.h5", "work/a/b"])
def test_files_of_the_user_are_not_taken_for_those_of_a_sweep(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = described(tmp_path / "a", "[1, 2]")
    mine = tmp_path / "results" / "many" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("years of work")
    before = content(tmp_path)
    assert main(["sweep", "run", str(path), "-o", str(tmp_path / "results")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "was not written by a sweep, and is left alone" in said
    assert content(tmp_path) == before


@pytest.mark.parametrize("name", ["table.csv", "table.h5"])
@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_table_of_the_user_is_not_written_over(
    name: str, elsewhere: bool, root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "tables" if elsewhere else root
    place.mkdir(exist_ok=True)
    if name == "table.csv":
        (place / name).write_text("name,age\nme,7\n")
    else:
        values = {"load": store.Dataset(np.zeros(3), ("step",))}
        store.write(place / name, values, {"schema": "mine", "schema_version": 1})
    before = content(tmp_path)
    assert main(["sweep", "collect", str(root), "-o", str(place)]) == 2
    assert f"{name}: was not written by a sweep, and is left alone" in capsys.readouterr().err
    assert content(tmp_path) == before


def test_a_table_of_ours_is_written_anew(tmp_path: Path) -> None:
    path = described(tmp_path / "a", "[1]")
    root = c.sweep(path, tmp_path).folder
    place = tmp_path / "tables"
    for seeds, points in (("[1]", 5), ("[1, 2]", 10)):
        c.sweep(described(tmp_path / "a", seeds), tmp_path)
        assert len(c.sweep_collect(root, place).system) == points
        assert len((place / "table.csv").read_text().splitlines()) == 1 + points


@pytest.mark.parametrize(
    ("seeds", "text"),
    [("[7, 8]", SMALL), ("[1, 2]", SMALL.replace("hurst = 0.8", "hurst = 0.5"))],
)
def test_another_sweep_of_the_same_name_is_refused(
    seeds: str, text: str, root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, before = described(tmp_path / "b", seeds, text), content(root)
    assert main(["sweep", "run", str(path), "-o", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert f"{root}: holds another sweep, and none of its 2 systems is one of this sweep" in said
    assert content(root) == before
    # Also while its first systems are in hand, and none is done.
    for point in (root / "points").iterdir():
        point.rename(root / "work" / point.name)
    with pytest.raises(OutputError, match="holds another sweep"):
        c.sweep(path, tmp_path)
    assert (root / "sweep.toml").read_bytes() == before["sweep.toml"]


def test_an_input_that_was_mended_before_anything_was_done_takes_its_place(root: Path, tmp_path: Path) -> None:
    for point in (root / "points").iterdir():
        point.unlink()
    begin(Sweep.read(described(tmp_path / "b", "[7, 8]")), root)
    assert [system.settings["surface.seed"] for system in systems_of(root).systems] == [7, 8]


def test_an_input_that_lists_fewer_systems_keeps_the_earlier_one(root: Path, tmp_path: Path) -> None:
    before = content(root)
    begin(Sweep.read(described(tmp_path / "a", "[1, 2, 3]")), root)
    assert not (root / "earlier").exists(), "nothing is lost where an axis grows"
    grown = content(root)
    for _ in range(2):  # as two jobs of an array do
        begin(Sweep.read(described(tmp_path / "a", "[2, 3]")), root)
    kept = content(root / "earlier")
    assert sorted(kept.values()) == sorted([grown["sweep.toml"], grown["systems.json"]])
    assert {name: text for name, text in content(root).items() if name.startswith("points/")} == {
        name: text for name, text in before.items() if name.startswith("points/")
    }
    assert c.sweep_status(root).others == 1


@pytest.mark.parametrize(
    "damage",
    [
        lambda root: (root / "systems.json").write_text("{"),
        lambda root: (root / "systems.json").unlink(),
        lambda root: [(root / name).rmdir() for name in ("work", "failed")],  # as an archive without empty folders
    ],
)
def test_a_sweep_that_was_damaged_or_copied_goes_on(
    damage: Callable[[Path], object], root: Path, tmp_path: Path
) -> None:
    damage(root)
    begin(Sweep.read(described(tmp_path / "a", "[1, 2]")), root)
    assert len(systems_of(root).systems) == 2
    assert Folder(root).begun


def test_the_input_of_a_sweep_may_lie_where_its_description_goes_but_is_not_written_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = described(tmp_path / "sweep", "[1, 2]").rename(tmp_path / "sweep" / "sweep.toml")
    before = content(tmp_path)
    assert main(["sweep", "run", str(path), "-o", str(tmp_path)]) == 2
    assert "is an input" in capsys.readouterr().err
    assert content(tmp_path) == before
    assert sorted(entry.name for entry in (tmp_path / "sweep").iterdir()) == ["sweep.toml"]


ANY_JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.sampled_from(["", "a.b", "\x1b[2J", "../../x", "9" * 64]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from("ab"), inner, max_size=2),
    max_leaves=5,
)
BROKEN = [b"", b"{", b"[" * 100_000, b"\xff\xfe{}", b"null", b"[]", b"{}", b"NaN", b'"' + b"9" * 6000, b"9" * 6000]
SEARCH = 'wall.adhesion_length = { bisect = "load", from = 0.006, to = 0.018, tolerance = 0.5 }\n'


def places_in(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where values stand in JSON."""
    yield path
    for key in data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ():
        yield from places_in(data[key], (*path, key))


def replaced(data: Any, path: tuple[Any, ...], value: Any) -> Any:
    if not path:
        return value
    copy = data.copy()
    copy[path[0]] = replaced(data[path[0]], path[1:], value)
    return copy


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, bytes]:
    """Every file of JSON and text in the folder of a search, by its name."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "mine.py").write_text("def half(result):\n    return 0.5\n")
    text = SMALL.replace("1.6, 1.4,\n           1.2", "1.4").replace("retract = true", "")
    path = described(folder, "[1]", text)
    path.write_text(f'{path.read_text()}{SEARCH}[sweep.columns]\nhalf = "mine.py"\n')
    root = c.sweep(path, folder).folder
    (key, *_) = (system.key for system in systems_of(root).systems)
    Folder(root).failure(key).write_text('{"system": "a", "reason": "b"}')
    Folder(root).death(key).write_text("process 7")
    (root / "work" / f".{key[:24]}.lock").write_text("process 7 on nowhere since yesterday")
    return {each: each.read_bytes() for each in root.rglob("*") if each.suffix in (".json", ".died", ".lock")}


def looked_at(root: Path) -> None:
    for look in (c.sweep_status, c.sweep_verify, collected):
        with suppress(StickinessError), warnings.catch_warnings():
            warnings.simplefilter("ignore", LeftOutWarning)
            look(root)


def collected(root: Path) -> None:
    found = c.sweep_collect(root)
    found.to_pandas()
    found.to_xarray()
    assert found.sheets()


@given(st.data())
@settings(max_examples=15)
def test_whatever_a_file_of_the_folder_says_is_read_or_refused(
    recorded: dict[Path, bytes], data: st.DataObject
) -> None:
    """JSON of any form in the place of any value, and files that are none: a message, and no file from elsewhere."""
    path = data.draw(st.sampled_from(sorted(recorded)))
    whole = recorded[path]
    if path.suffix == ".json" and data.draw(st.integers(0, 3)):
        given = json.loads(whole)
        place = data.draw(st.sampled_from(list(places_in(given))))
        changed = json.dumps(replaced(given, place, data.draw(ANY_JSON))).encode()
    else:
        changed = data.draw(st.sampled_from(BROKEN))
    path.write_bytes(changed)
    try:
        looked_at(path.parent if path.name == "systems.json" else path.parent.parent)
    finally:
        path.write_bytes(whole)
