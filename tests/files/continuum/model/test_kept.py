"""Compiled code is kept where it can be, and whatever is wrong with the disk, a function gives its value."""

from __future__ import annotations

import os
import pickle
import resource
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from continuum.model import caches, kept


def double(x: float) -> float:
    return 2.0 * x


def compiled() -> tuple[float, int]:
    """Value of the function, and how often a new process would have read it from the disk: 0 or 1."""
    function: Any = kept.kept_on_disk()(double)
    return function(1.5), sum(function.stats.cache_hits.values())


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of $NUMBA_CACHE_DIR."""
    monkeypatch.setattr(kept.config, "CACHE_DIR", str(tmp_path / "given"))
    kept.folder_of_compiled.cache_clear()
    yield tmp_path / "given"
    kept.folder_of_compiled.cache_clear()


def one_file(folder: Path) -> Path:
    (file,) = (path for path in folder.rglob("*") if path.is_file())
    return file


def test_what_was_compiled_is_read_by_the_next_process(folder: Path) -> None:
    assert compiled() == (3.0, 0)
    assert compiled() == (3.0, 1)
    assert one_file(folder).suffix == ".nbc"


def test_a_damaged_file_is_compiled_and_written_again(folder: Path) -> None:
    compiled()
    path = one_file(folder)
    whole = path.read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    # Without a seal the last is executed as it is read, and `flipped` is code that computes something else.
    others = pickle.dumps(double), b"\x80\x05cbuiltins\nexit\n)R."
    for damaged in (b"", whole[:20], whole[:middle], whole[:-1], flipped, whole + b"\0", *others):
        path.write_bytes(damaged)
        assert compiled() == (3.0, 0)
        assert compiled() == (3.0, 1)
    path.unlink()
    path.mkdir()
    assert compiled() == (3.0, 0)


@pytest.mark.parametrize("other", ["source", "version"])
def test_code_of_another_source_or_numba_is_not_read(other: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled()
    if other == "source":
        monkeypatch.setattr(kept.caching._SourceFileBackedLocatorMixin, "get_source_stamp", lambda _: "other")
    else:
        monkeypatch.setattr(kept.numba, "__version__", "other")
    assert compiled() == (3.0, 0)


@contextmanager
def full_disk() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_stops_nothing_and_nothing_is_left_there(folder: Path) -> None:
    with full_disk():
        assert compiled() == (3.0, 0)
    assert not [path for path in folder.rglob("*") if path.is_file()]
    assert compiled() == (3.0, 0)
    assert compiled() == (3.0, 1)


def test_without_a_folder_it_is_compiled_by_each_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(caches, "writable", lambda folder: False)
    assert kept.folder_of_compiled(Path(__file__).parent) is None
    assert compiled() == compiled() == (3.0, 0)


def test_the_places_come_in_order(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sources, home, temporary = (tmp_path / name for name in ("sources", "home", "tmp"))
    for path in (sources, home, temporary):
        path.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    for place in (folder, sources / "__pycache__", home / ".cache", temporary / f"stickiness-{os.getuid()}"):
        kept.folder_of_compiled.cache_clear()
        found = kept.folder_of_compiled(sources)
        assert found is not None
        assert found.is_relative_to(place)
        shutil.rmtree(place)
        place.touch()  # where a folder would be: root cannot write into it, either
    kept.folder_of_compiled.cache_clear()
    assert kept.folder_of_compiled(sources) is None


def test_a_temporary_folder_of_somebody_else_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Who can write into it can have us run what he wrote."""
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    mine = tmp_path / f"stickiness-{os.getuid()}"
    assert caches.folder_for("a") == mine / "a"
    assert not caches.at_home()
    mine.chmod(0o770)
    assert caches.folder_for("a") is None
    (mine / "a").rmdir()
    mine.rmdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    mine.symlink_to(tmp_path / "elsewhere")
    assert caches.folder_for("a") is None
    mine.unlink()
    mine.mkdir(mode=0o700)
    if os.getuid() == 0:
        os.chown(mine, 65534, 65534)
        assert caches.folder_for("a") is None


def test_without_a_home_nothing_is_written_into_the_folder_where_one_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A user without an entry, as in a container, has "~" as his home."""
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("os.path.expanduser", lambda path: path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    monkeypatch.chdir(tmp_path)
    assert caches.folder_for("a") == tmp_path / "tmp" / f"stickiness-{os.getuid()}" / "a"
    assert {path.name for path in tmp_path.iterdir()} == {"tmp"}
