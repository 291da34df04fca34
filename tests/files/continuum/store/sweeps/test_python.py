"""A sweep from Python alone: an input that is a dictionary, and its points as pandas and xarray have them."""

from __future__ import annotations

import copy
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.reading import source_of
from continuum.store.runs import maps as stored_maps
from continuum.store.runs.record import XARRAY_NAMES
from continuum.store.sweeps import crossings
from continuum.store.sweeps.collect import PointTable
from continuum.store.sweeps.cube import TAKEN, _short

RUN: dict[str, Any] = {
    "grid": {"n": [32, 40]},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 16.0, "seed": 1},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "repulsive-area", "targets": [0.15, 0.3]},
}
AXES = {"surface.seed": [1, 2, 3], "wall.adhesion_length": [0.0, 0.005]}
AXES_SHORT = ["seed", "adhesion_length"]
SWEEP = {**RUN, "sweep": {"axes": AXES}}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return c.sweep(SWEEP, tmp_path_factory.mktemp("out"), name="mine", columns=COLUMNS)


def widest(result: c.Result) -> list[int]:
    """The largest number of touching points of a row, at each point of the path."""
    return [result.repulsive(step).sum(axis=1).max() for step in range(len(result.points))]


factor = 2.0
COLUMNS = {"widest": widest, "doubled": lambda result: [factor * point.load for point in result.points]}


@pytest.fixture(scope="module")
def table(done: Any) -> PointTable:
    found: PointTable = done.collect()
    return found


def test_a_dictionary_is_the_same_sweep_as_its_file(done: Any, tmp_path: Path) -> None:
    before = copy.deepcopy(SWEEP)
    path = tmp_path / "mine.toml"
    path.write_text(source_of(SWEEP).text)
    assert c.sweep(path, done.folder.parent).found == 6
    # NumPy's numbers and arrays are numbers and lists.
    axes = {"surface.seed": np.arange(1, 4), "wall.adhesion_length": np.array([0.0, 0.005])}
    assert c.sweep({**RUN, "sweep": {"axes": axes}}, done.folder.parent, name="mine").found == 6
    assert before == SWEEP
    assert done.folder.name == "mine"
    assert (
        c.sweep(SWEEP, tmp_path, settings={"surface.seed": [1], "wall.adhesion_length": 0.005}).folder.name == "sweep"
    )
    assert c.check(SWEEP).sheet.rows[0][1] == "6"


def test_a_run_takes_a_dictionary(tmp_path: Path, table: PointTable) -> None:
    found = c.run(RUN, tmp_path)
    assert found.path.name == "input.h5"
    mine = table.to_pandas().query("`surface.seed` == 1 and `wall.adhesion_length` == 0.005")
    assert list(mine.load) == [point.point.load for point in found.analyse().points]


@pytest.mark.parametrize("name", ["", "../x", "a/b", ".hidden", "x" * 200, 3])
def test_a_name_that_is_no_folder_is_refused(name: Any, tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="name"):
        c.sweep(SWEEP, tmp_path / "out", name=name)
    assert not (tmp_path / "out").exists()


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.binary(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@given(st.sampled_from(["grid", "surface", "sweep", "new"]), ANYTHING)
def test_whatever_a_table_holds_ends_in_a_message_of_its_input(name: str, value: Any) -> None:
    with suppress(c.ConfigError):
        c.check({**SWEEP, name: value})
    with pytest.raises(c.ConfigError, match=r"^(input|sweep)\.toml"):
        c.check({**SWEEP, name: value, "wall": {}})


def test_pandas_and_xarray_have_what_the_files_have(table: PointTable, done: Any, tmp_path: Path) -> None:
    frame, cube = table.to_pandas(), table.to_xarray()
    assert repr(table) == "PointTable('mine', 12 points of 6 systems, 0 systems missing)"
    # In a notebook both are tables.
    assert "<td>12</td>" in table._repr_html_()
    assert "done" in done._repr_html_()
    assert len(frame) == 12
    assert frame.attrs["units"]["load"] == "E*"
    for row in frame.itertuples(index=False):
        values = dict(zip(frame.columns, row, strict=True))
        place = {name: values[name] for name in (*AXES, "step")}
        for name in ("load", "area_rep", "kappa_rep"):
            np.testing.assert_equal(cube[XARRAY_NAMES.get(name, name)].sel(place).item(), values[name])
        assert values["inverse_kappa"] * values["kappa"] == pytest.approx(1)
    # What a sweep returns has them, too.
    assert done.to_pandas().equals(frame)
    xarray.testing.assert_identical(done.to_xarray(), cube)
    c.sweep_collect(done.folder, tmp_path)
    with xarray.open_dataset(tmp_path / "table.h5", engine="h5netcdf") as stored:
        xarray.testing.assert_equal(cube, stored)
        assert cube.attrs.items() <= stored.attrs.items()
    # Each column is an attribute of either, as both packages document it.
    assert {XARRAY_NAMES.get(name, name) for name in table.columns} <= set(map(str, cube.variables))
    for name in map(str, cube.data_vars):
        assert getattr(cube, name).identical(cube[name])
        assert not hasattr(xarray.Dataset, name)
    for name in table.columns:
        assert getattr(frame, name).equals(frame[name])
        assert not hasattr(pandas.DataFrame, name)


@pytest.mark.parametrize(
    ("keys", "short"),
    [
        (["surface.seed", "substrate.mean"], ["seed", "substrate.mean"]),
        (["surface.path", "wall.path", "grid.n"], ["surface.path", "wall.path", "n"]),
        (["wall.gap", "wall", "a.step", "b.x"], ["wall.gap", "wall", "a.step", "b.x"]),
    ],
)
def test_an_axis_of_maps_has_its_short_name_where_nothing_else_has_it(keys: list[str], short: list[str]) -> None:
    """No other axis, no map, and no method of a dataset."""
    assert list(_short(keys, TAKEN | set(dir(xarray.Dataset))).values()) == short


def test_maps_of_all_systems_are_read_where_they_are_used(
    done: Any, table: PointTable, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each kind of index gives what the same index gives of the whole, which is what each file has."""
    maps, opened = c.sweep_maps(done.folder), list[Path]()
    assert maps["repulsive"].dims == ("seed", "adhesion_length", "step", "x", "y")
    assert maps["repulsive"].dtype == bool
    whole = maps["repulsive"].values
    for system in table.listing.systems:
        result, seed = c.Result.read(done.folder / "points" / f"{system.key[:24]}.h5"), system.settings["surface.seed"]
        one = maps.sel(seed=seed, adhesion_length=system.settings["wall.adhesion_length"])
        for step in range(2):
            np.testing.assert_array_equal(one["repulsive"].isel(step=step), result.repulsive(step))
            np.testing.assert_array_equal(one["attracted"].isel(step=step), result.contact_map(step) == 1)
        xarray.testing.assert_identical(
            one["repulsive"].drop_vars(AXES_SHORT), result.to_xarray()["repulsive"].drop_vars("step")
        )
    real = stored_maps.opened
    monkeypatch.setattr(stored_maps, "opened", lambda path: (opened.append(path), real(path))[1])
    for key in (
        (1, 0, slice(None), 3, slice(5, 29, 3)),
        ([2, 0], slice(1, None), -1, slice(30, 2, -4), [1, 39, 8]),
        (0, [1], [1, 0], slice(4, 4), 7),
    ):
        there = maps["repulsive"][key].values
        np.testing.assert_array_equal(there, stored_maps.along_each(whole, key))
    assert [*map(len, (opened, {*opened}))] == [1 + 2 + 1, 3]  # one of them twice
    assert list(c.sweep_maps(done.folder, where={"wall.adhesion_length": 0.005})["adhesion_length"]) == [0.005]


def test_maps_of_systems_that_are_not_there_are_missing(done: Any, tmp_path: Path) -> None:
    shutil.copytree(done.folder, tmp_path / "copy")
    lost, damaged = sorted((tmp_path / "copy" / "points").iterdir())[:2]
    lost.unlink()
    maps = c.sweep_maps(tmp_path / "copy")
    assert maps.attrs["systems_missing"] == 1
    assert int(np.isnan(maps["repulsive"]).all(("step", "x", "y")).sum()) == 1
    shutil.copy(c.run({**RUN, "grid": {"n": 40}}, tmp_path).path, damaged)
    with pytest.raises(c.StoreError, match="of this grid"):
        c.sweep_maps(tmp_path / "copy")["repulsive"].load()
    with pytest.raises(ArgumentError, match="surface"):
        c.sweep_maps(done.folder, where={"surface.hurst": 0.8})


def test_means_are_over_surfaces_and_have_no_seed(table: PointTable, done: Any) -> None:
    frame, means = table.to_pandas(), table.means()
    assert done.means().equals(means)
    assert "surface.seed" not in means
    assert list(means["count"]) == [3, 3, 3, 3]
    for row in means.itertuples():
        # Positional: names with dots are no attributes.
        here = frame[
            (frame["wall.adhesion_length"] == means["wall.adhesion_length"][row.Index]) & (frame.step == row.step)
        ]
        kappas = here.kappa.to_numpy()
        assert row.inverse_kappa == pytest.approx(np.mean(1 / kappas), rel=1e-12)
        assert row.inverse_kappa_error == pytest.approx(np.std(1 / kappas, ddof=1) / np.sqrt(3), rel=1e-9)
    with pytest.raises(ArgumentError, match="over"):
        table.means("surface.hurst")


def test_a_figure_is_drawn_to_be_looked_at(done: Any) -> None:
    assert isinstance(c.figure("figure4", done), Figure)
    with pytest.raises(ArgumentError, match="name"):
        c.figure("figure9", done)


def test_a_second_collection_reads_only_what_is_new(done: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root, read = shutil.copytree(done.folder, tmp_path / "mine"), list[Path]()
    real = crossings.numbers_of
    monkeypatch.setattr(crossings, "numbers_of", lambda path, key: (read.append(path), real(path, key))[1])
    (root / ".kept.h5").unlink(missing_ok=True)
    lost = sorted((root / "points").iterdir())[2]
    aside = lost.rename(tmp_path / "aside.h5")
    assert len(c.sweep_collect(root).keys) == len(read) == 5
    aside.rename(lost)
    again = c.sweep_collect(root)
    assert [*read[5:]] == [lost]
    np.testing.assert_array_equal(again.values, done.collect().values)
    np.testing.assert_array_equal(again["widest"], done.collect()["widest"])
    assert again.provenance == done.collect().provenance
    # A file that was changed is read again; what was kept of other columns, or is damaged, is not used.
    lost.touch()
    c.sweep_collect(root)
    assert read[6:][-1] == lost
    (root / ".kept.h5").write_bytes(b"damaged")
    del read[:]
    np.testing.assert_array_equal(c.sweep_collect(root).values, again.values)
    assert len(read) == 6
