"""Collections of many systems: what is killed, damaged, read before, or cannot be written."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
import xarray

import continuum as c
from continuum.front import sweeps
from continuum.front.cli import main
from continuum.inputs.errors import OutputError
from continuum.store import datasets
from continuum.store.runs.config import RunConfig
from continuum.store.sweeps import collect, crossings
from continuum.store.sweeps.collect import LeftOutWarning
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.measured import COLUMNS
from docs.benchmarks.files import stubs

MANY = 60


def content(root: Path) -> dict[str, bytes]:
    """The files of a folder, without those of its systems."""
    return {path.name: path.read_bytes() for path in root.iterdir() if path.is_file()}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """The folder of many systems, whose files hold what a collection reads."""
    return stubs(tmp_path, MANY)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the files that are read."""
    found, read = list[str](), crossings.numbers_of

    def counted(path: Path, key: str | None = None) -> Any:
        found.append(path.name)
        return read(path, key)

    monkeypatch.setattr(crossings, "numbers_of", counted)
    return found


def _die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _while_rows_are_written(root: Path) -> None:
    def write(out: Any, head: Any, rows: Any) -> None:
        out.write("system,")
        out.flush()
        _die()

    sweeps.write_csv = write
    c.sweep_collect(root)


def _while_numbers_are_written(root: Path) -> None:
    fill = datasets._fill

    def half(file: Any, *given: Any) -> None:
        fill(file, *given)
        file.flush()
        _die()

    datasets._fill = half
    c.sweep_collect(root)


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
@pytest.mark.parametrize("dies", [_while_rows_are_written, _while_numbers_are_written])
def test_a_collection_that_is_killed_leaves_whole_tables_and_the_next_one_nothing_else(
    dies: Callable[[Path], None], root: Path
) -> None:
    (first, *_) = sorted((root / "points").iterdir())
    aside = first.rename(root.parent / first.name)
    c.sweep_collect(root)
    before = content(root)
    aside.rename(first)
    killed = get_context("fork").Process(target=dies, args=(root,))
    killed.start()
    killed.join(60)
    assert killed.exitcode == -signal.SIGKILL
    there = content(root)
    assert there["table.csv"] == before["table.csv"]
    assert xarray.load_dataset(root / "table.h5", engine="h5netcdf").attrs["systems"] in (MANY - 1, MANY)
    assert any(name.endswith(".tmp") for name in there)
    assert len(c.sweep_collect(root).keys) == MANY
    assert len((root / "table.csv").read_text().splitlines()) == 1 + MANY
    assert not any(name.endswith(".tmp") for name in content(root))


def _while_files_are_read(root: Path) -> None:
    read, last = crossings.numbers_of, Folder(root).point(systems_of(root).systems[40].key)

    def some(path: Path, key: str | None = None) -> Any:
        if path == last:
            _die()
        return read(path, key)

    crossings.numbers_of = some
    collect._EVERY = 10
    c.sweep_collect(root)


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_what_a_killed_collection_has_read_is_not_read_again(root: Path, asked: list[str]) -> None:
    aside = root.parent / "aside"
    aside.mkdir()
    late = [Folder(root).point(one.key) for one in systems_of(root).systems[:50]]
    for path in late:
        path.rename(aside / path.name)
    c.sweep_collect(root)  # the last ten
    for path in late:
        (aside / path.name).rename(path)
    killed = get_context("fork").Process(target=_while_files_are_read, args=(root,))
    killed.start()
    killed.join(60)
    assert killed.exitcode == -signal.SIGKILL
    asked.clear()
    assert len(c.sweep_collect(root).keys) == MANY
    assert asked == [path.name for path in late[40:]]
    assert len((root / "table.csv").read_text().splitlines()) == 1 + MANY


def test_damaged_files_in_the_middle_are_faults_and_all_others_are_rows(
    root: Path, asked: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """A second collection reads what was damaged and what is new, and nothing else."""
    paths = sorted((root / "points").iterdir())
    whole = [path.read_bytes() for path in paths[30:35]]
    place = whole[3].index(np.ones(1).tobytes())
    for path, bytes_ in zip(
        paths[30:35],
        (b"", whole[1][:3000], whole[1], whole[3][:place] + b"\1" + whole[3][place + 1 :], b"no HDF5" * 99),
        strict=True,
    ):
        path.write_bytes(bytes_)
    assert main(["sweep", "collect", str(root)]) == 1
    said = capsys.readouterr()
    for path in paths[30:35]:
        assert said.err.count(path.name) == 1
    assert len(asked) == MANY
    rows = pandas.read_csv(root / "table.csv")
    assert len(rows) == MANY - 5
    assert (rows["load (E*)"] == 1).all()
    for path, bytes_ in zip(paths[30:35], whole, strict=True):
        path.write_bytes(bytes_)
    asked.clear()
    assert main(["sweep", "collect", str(root)]) == 0
    assert sorted(asked) == [path.name for path in paths[30:35]]
    assert len(pandas.read_csv(root / "table.csv")) == MANY
    # What is kept of them may be damaged itself: then all are read again.
    (root / ".kept.h5").write_bytes((root / ".kept.h5").read_bytes()[:5000])
    asked.clear()
    c.sweep_collect(root)
    assert len(asked) == MANY


def test_a_folder_that_cannot_be_written_to_is_said_before_all_is_read(
    root: Path, asked: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its tables can be written elsewhere, and looking at it works as ever."""
    allowed, temporary = os.access, datasets.created
    monkeypatch.setattr(os, "access", lambda path, mode: not Path(path).is_relative_to(root) and allowed(path, mode))

    def refused(path: str | Path) -> Any:
        if Path(path).is_relative_to(root):
            raise OutputError(f"{path}: cannot be written: Read-only file system")
        return temporary(path)

    monkeypatch.setattr(datasets, "created", refused)
    before = content(root)
    assert main(["sweep", "collect", str(root)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not asked
    assert main(["sweep", "collect", str(root), "-o", str(tmp_path / "tables")]) == 0
    assert len(pandas.read_csv(tmp_path / "tables" / "table.csv")) == MANY
    assert c.sweep_status(root).done == MANY
    assert content(root) == before


def test_no_column_has_the_name_of_a_table_of_the_input() -> None:
    """Whole tables can be axes, and an axis stands beside the columns."""
    assert not set(RunConfig.model_fields) & set(COLUMNS)


def test_what_is_left_out_is_warned_of_where_python_collects(root: Path) -> None:
    next((root / "points").iterdir()).write_bytes(b"")
    with pytest.warns(LeftOutWarning, match=f"1 of {MANY} files"):
        assert len(collect.collect(root).keys) == MANY - 1
