"""Results on disk: what is written is read back, or the reader says why not."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st

from continuum.inputs.errors import OutputError
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import StoreError, UnreadError, read_dataset
from continuum.store.heights import read_map
from tests.stored import ENGINES, opens_in_xarray

HEAD = {"schema": "test", "schema_version": 1}


def some() -> dict[str, Dataset]:
    rng = np.random.default_rng(0)
    return {
        "x": Dataset(np.arange(5.0), ("x",), "a0", "position"),
        "gap": Dataset(rng.normal(size=(3, 5, 7)), ("step", "x", "y"), "a0", "gap"),
        "mask": Dataset(rng.random((3, 5)) < 0.5, ("step", "x"), "1", "mask"),
        "status": Dataset(np.array(["CONVERGED", "É", ""]), ("step",), "", "status"),
        "group/count": Dataset(np.arange(3), ("step",), "1", "count"),
        "empty": Dataset(np.zeros((0, 5)), ("none", "x"), "1", "nothing"),
    }


def read(path: Path) -> store.File:
    return store.read_datasets(path, "test", 1, labels=True)


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    attributes = HEAD | {"a": 1.5, "n": 7, "flag": True, "text": "Größe\nzwei", "group/deep": "x"}
    store.write(tmp_path / "a.h5", some(), attributes)
    found = read(tmp_path / "a.h5")
    assert found.attributes == attributes
    assert set(found.datasets) == set(some())
    for name, dataset in some().items():
        back = found.datasets[name]
        np.testing.assert_array_equal(back.values, dataset.values)
        assert back.values.dtype.kind == dataset.values.dtype.kind
        assert (back.dims, back.units, back.long_name) == (dataset.dims, dataset.units, dataset.long_name)
    named = store.read_datasets(tmp_path / "a.h5", "test", 1, {"group/count", "not there"})
    assert named.attributes == attributes
    assert {name: each.values.tolist() for name, each in named.datasets.items()} == {"group/count": [0, 1, 2]}


def test_the_same_content_is_the_same_file(tmp_path: Path) -> None:
    for name in "ab":
        store.write(tmp_path / f"{name}.h5", some(), HEAD)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


@pytest.mark.parametrize("engine", ENGINES)
def test_xarray_opens_it_with_named_axes(tmp_path: Path, engine: str) -> None:
    store.write(tmp_path / "a.h5", some(), HEAD)
    opens_in_xarray(tmp_path / "a.h5", engine, "test", 1)
    with xarray.open_dataset(tmp_path / "a.h5", engine=engine) as data:
        assert data.attrs["schema"] == "test"


def test_text_of_fixed_length_as_earlier_versions_stored_it_is_read(tmp_path: Path) -> None:
    store.write(tmp_path / "a.h5", some(), HEAD)
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        del file["status"]
        encoded = np.strings.encode(some()["status"].values, "utf-8")
        file.create_dataset("status", data=encoded.astype(h5py.string_dtype("utf-8", 9)), fletcher32=True)
        file["status"].attrs["_Encoding"] = "utf-8"
    assert list(read(tmp_path / "a.h5")["status"]) == ["CONVERGED", "É", ""]


def test_a_write_that_fails_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.h5"
    store.write(path, some(), HEAD)
    before = path.read_bytes()
    for error, caught in ((OSError("disk full"), OutputError), (KeyboardInterrupt(), KeyboardInterrupt)):

        def fail(*_: object, error: BaseException = error) -> None:
            raise error

        monkeypatch.setattr(output.os, "fsync", fail)
        with pytest.raises(caught):
            store.write(path, {"x": some()["x"]}, HEAD)
        assert path.read_bytes() == before
        assert list(tmp_path.iterdir()) == [path]


def test_what_a_killed_writer_left_is_removed_and_nothing_else(tmp_path: Path) -> None:
    import os
    import socket

    stem = f".a.h5.{socket.gethostname()}."
    dead = tmp_path / f"{stem}999999999.tmp"
    alive = tmp_path / f"{stem}{os.getpid()}.tmp"
    other = tmp_path / f".b.h5.{socket.gethostname()}.999999999.tmp"
    for path in (dead, alive, other):
        path.touch()
    output.remove_stale(tmp_path / "a.h5")
    assert set(tmp_path.iterdir()) == {alive, other}


@pytest.mark.parametrize("name", ["gap", "x", "text", "place of text"])
def test_a_flipped_bit_is_noticed(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.h5"
    store.write(path, some(), HEAD)
    content = bytearray(path.read_bytes())
    with h5py.File(path, "r") as file:
        if name == "text":
            offset = content.index(b"CONVERGED")
        elif name == "place of text":
            offset = file["status"].id.get_offset()
        else:
            offset = file[name].id.get_chunk_info(0).byte_offset
    content[offset + 3] ^= 0x10
    path.write_bytes(content)
    with pytest.raises(StoreError, match="damaged"):
        read(path)


@pytest.mark.parametrize("kept", [0.0, 0.3, 0.7, 0.99])
def test_a_truncated_file_is_noticed(tmp_path: Path, kept: float) -> None:
    path = tmp_path / "a.h5"
    store.write(path, some(), HEAD)
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content))])
    with pytest.raises(StoreError, match=r"damaged|not an HDF5"):
        read(path)


@pytest.mark.parametrize("mode", ["r", "r+"])
@pytest.mark.parametrize("locking", [None, True, False, "best-effort"])
def test_a_file_that_this_process_has_open_is_read(tmp_path: Path, mode: str, locking: Any) -> None:
    """HDF5 opens a file twice in one process in one way of locking only; sums and xarray's lazy data are the same."""
    path = tmp_path / "a.h5"
    store.write(path, some(), HEAD)
    with h5py.File(path, mode, locking=locking):
        np.testing.assert_array_equal(read(path)["gap"], some()["gap"].values)
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        np.testing.assert_array_equal(read(path)["gap"], data["gap"].values)


@pytest.mark.parametrize(
    "error",
    [BlockingIOError(errno.EAGAIN, "locked"), PermissionError(errno.EACCES, "no"), OSError(errno.EIO, "disk"),
     MemoryError("1 TB")],
    ids=["held", "permission", "disk", "memory"],
)  # fmt: skip
@pytest.mark.parametrize("when", ["open", "read"])
def test_a_failure_of_the_system_is_not_damage_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, when: str
) -> None:
    path = tmp_path / "a.h5"
    store.write(path, some(), HEAD)

    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(*{"open": ("h5py.File", fail), "read": (store, "_values", fail)}[when])
    with pytest.raises(UnreadError) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert "damaged" not in str(caught.value)
    if when == "open":
        with pytest.raises(OutputError, match=r"a\.h5"):  # and no file of another program
            store.earlier(path, "test", 1, "", force=True)


def test_what_is_missing_or_of_another_kind_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with pytest.raises(StoreError, match="no such file"):
        read(path)
    path.write_text("not HDF5 at all")
    with pytest.raises(StoreError, match="not an HDF5"):
        read(path)
    store.write(path, some(), HEAD)
    with pytest.raises(StoreError, match="holds test version 1, expected run version 1"):
        store.read_datasets(path, "run", 1)
    with pytest.raises(StoreError, match="expected test version 2"):
        store.read_datasets(path, "test", 2)
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(StoreError, match="data of another program"):
        read(tmp_path / "b.h5")


@pytest.mark.parametrize("kind", ["external link", "soft link", "external storage", "virtual"])
def test_data_that_lie_elsewhere_are_refused(tmp_path: Path, kind: str) -> None:
    secret, path = tmp_path / "secret", tmp_path / "a.h5"
    secret.write_bytes(b"password" * 4)
    store.write(path, {"x": some()["x"]}, HEAD)
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["y"] = np.arange(4.0)
    with h5py.File(path, "a") as file:
        if kind == "external link":
            file["y"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/y")
        elif kind == "soft link":
            file["y"] = h5py.SoftLink("/x")
        elif kind == "external storage":
            file.create_dataset("y", (4,), "f8", external=[(str(secret), 0, 32)])
        else:
            layout = h5py.VirtualLayout((4,), "f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "y", (4,))
            file.create_virtual_dataset("y", layout)
    for reading in (lambda: read(path), lambda: read_dataset(path, "y")):
        with pytest.raises(StoreError, match="refused"):
            reading()


def test_an_array_of_a_user_is_read_if_it_is_one(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "mine.h5", "w") as file:
        file["map/heights"] = np.arange(12, dtype=np.int16).reshape(3, 4)
        file["name"] = np.array([b"text"])
    found = read_dataset(tmp_path / "mine.h5", "/map/heights").values
    np.testing.assert_array_equal(found, np.arange(12.0).reshape(3, 4))
    assert found.dtype == np.float64
    for dataset, words in (("map/h", "map/heights"), ("name", "not real")):
        with pytest.raises(StoreError, match=words):
            read_dataset(tmp_path / "mine.h5", dataset)
    with pytest.raises(StoreError, match="shape"):
        read_map(tmp_path / "mine.h5", "map/heights", (4, 4))


@given(st.integers(1, 40), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_packed_masks_unpack(ny: int, nx: int, seed: int) -> None:
    masks = np.random.default_rng(seed).random((2, nx, ny)) < 0.5
    packed = store.pack(masks)
    assert packed.shape == (2, nx, (ny + 7) // 8)
    np.testing.assert_array_equal(store.unpack(packed, ny), masks)


@pytest.mark.parametrize("values", [np.array([object()]), np.array([1j]), np.float64(1.0)])
def test_what_cannot_be_given_back_is_refused(values: np.ndarray) -> None:
    with pytest.raises((TypeError, ValueError), match=r"holds numbers|dimensions"):
        Dataset(values, ("x",))


def test_datasets_must_agree_and_files_must_name_their_kind(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="dimension x"):
        store.write(tmp_path / "a.h5", {"a": Dataset(np.ones(2), ("x",)), "b": Dataset(np.ones(3), ("x",))}, HEAD)
    with pytest.raises(ValueError, match="schema"):
        store.write(tmp_path / "a.h5", some(), {})
    assert not list(tmp_path.iterdir())
