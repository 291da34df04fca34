"""Columns are what their names and their row of units say, also more of them than positions and heights; and an array
in memory is what it says of itself."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from continuum.maps.map import Topography, TopographyError
from continuum.maps.reading import read_all, read_topography

SHAPE, PIXEL = (20, 16), 10.0
HEIGHTS = np.random.default_rng(4).normal(size=SHAPE)
"""In nm, on pixels of 10 nm."""
X, Y = (PIXEL * each.T.ravel() for each in np.indices(SHAPE))
UNITS = {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "Å": 1e-10, "mm": 1e-3, "pm": 1e-12, "angstrom": 1e-10}
MATRIX = {"size": "200nm,160nm", "unit": "nm"}
LINE = np.arange(400.0)


def table(path: Path, head: str, *columns: Any, between: str = ",") -> Path:
    rows = "\n".join(between.join(f"{one:.8g}" for one in line) for line in np.column_stack(columns))
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")
    return path


def is_the_map(found: Topography) -> None:
    assert found.lengths == pytest.approx((200e-9, 160e-9), rel=1e-6)
    np.testing.assert_allclose(found.heights, 1e-9 * HEIGHTS, rtol=1e-6, atol=1e-15)


@pytest.mark.parametrize("names", ["X,Y,Z", "Lateral,Across,Total Profile", "a,b,c", "", "Index x,y pos,value"])
@settings(max_examples=10)  # of each of five heads
@given(
    lateral=st.sampled_from(sorted(UNITS)),
    height=st.sampled_from(sorted(UNITS)),
    brackets=st.sampled_from(["{}", "[{}]", "({})"]),
)
def test_a_row_of_units_is_one_whatever_the_columns_are_called(
    names: str, lateral: str, height: str, brackets: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    units = ",".join(brackets.format(one) for one in (lateral, lateral, height))
    place = tmp_path_factory.mktemp("rows")
    scaled = (X * 1e-9 / UNITS[lateral], Y * 1e-9 / UNITS[lateral], HEIGHTS.T.ravel() * 1e-9 / UNITS[height])
    is_the_map(read_topography(table(place / "map.csv", f"Sample,A1\n{names}\n{units}", *scaled)))


@pytest.mark.parametrize("between", [",", "\t", ";", " "])
def test_a_profile_under_odd_names_has_the_units_of_its_row(between: str, tmp_path: Path) -> None:
    path = table(tmp_path / "stylus.csv", f"Sample A1\nRadius: 2 um\nLateral{between}Profile\nµm{between}Å", LINE,
                 np.sin(LINE), between=between)  # fmt: skip
    found = read_topography(path)
    assert found.lengths[0] == pytest.approx(400e-6)
    with pytest.raises(TopographyError, match=r"itself says the unit of the map \(100 pm\)"):
        read_all([path], unit="um,nm")
    assert "overruled" in " ".join(read_all([path], unit="nm", override_size=True)[0].steps)


def test_a_row_of_units_that_are_no_length_is_refused(tmp_path: Path) -> None:
    for last in ("V", "a.u.", "nN"):
        path = table(tmp_path / "volts.csv", f"x,y,z\num,um,{last}", X, Y, HEIGHTS.T.ravel())
        with pytest.raises(TopographyError, match=f"column 3 is in '{last}', which is not a unit of length"):
            read_topography(path)


HEADS = {
    "X (nm)\tY (nm)\tZ (nm)\tIntensity": (0, 1, 2, 3),
    "x\ty\theight\tamplitude\nnm\tnm\tnm\tV": (0, 1, 2, 3),
    "y [nm]\tx [nm]\tphase\tz [nm]\nnm\tnm\tdeg\tnm": (1, 0, 3, 2),
    "Intensity\tX\tY\tZ\na.u.\tnm\tnm\tnm": (3, 0, 1, 2),
    "x_nm\ty_nm\tz_nm\tquality\nnm\tnm\tnm\t%": (0, 1, 2, 3),
}
"""Heads of tables, and which of x, y, z and a fourth number stands in each column."""


@pytest.mark.parametrize("head", HEADS)
def test_a_fourth_column_is_left_out_and_said(head: str, tmp_path: Path) -> None:
    values = X, Y, HEIGHTS.T.ravel(), 100 + np.arange(X.size) % 7
    path = table(tmp_path / "map.txt", head, *(values[i] for i in HEADS[head]), between="\t")
    found = read_topography(path)
    is_the_map(found)
    assert any("of 4 used, positions and heights" in step for step in found.steps)


def test_without_names_a_grid_of_positions_is_seen_and_anything_else_is_refused(tmp_path: Path) -> None:
    more = (X, Y, HEIGHTS.T.ravel(), np.arange(X.size) % 7.0, np.arange(X.size) % 5.0)
    is_the_map(read_all([table(tmp_path / "plain.txt", "", *more, between=" ")], unit="nm,nm")[0])
    random = np.random.default_rng(1).normal(size=(300, 5))
    with pytest.raises(TopographyError):
        read_all([table(tmp_path / "odd.txt", "", *random.T, between=" ")], size="1um", unit="nm")


def test_a_profile_with_a_second_channel_takes_the_first_height(tmp_path: Path) -> None:
    head = "Distance,Profile,Raw,Marker\nmm,um,um,"
    found = read_topography(table(tmp_path / "two.csv", head, LINE, np.sin(LINE), 99 + LINE**2, LINE % 2))
    assert found.lines == 1
    assert found.heights.std() < 1e-5
    assert any("columns 1 2 of 4 used" in step for step in found.steps)


# --- arrays in memory


def of_xarray(unit: str = "um", **axes: Any) -> Any:
    xr = pytest.importorskip("xarray")
    return xr.DataArray(1e-3 * HEIGHTS.T, dims=("y", "x"), attrs={"units": unit}, coords=axes)


def test_the_unit_of_an_array_of_xarray_is_only_overruled_knowingly() -> None:
    """Factor 1000 if it were not looked at; its axes are y and x, as those of a file."""
    is_the_map(read_all([of_xarray()], size="200nm,160nm")[0])
    with pytest.raises(TopographyError, match=r"the array itself says the unit of the map \(1 µm\)"):
        read_all([of_xarray()], **MATRIX)
    overruled = read_all([of_xarray()], override_size=True, **MATRIX | {"unit": "mm"})[0]
    assert overruled.heights.std() == pytest.approx(1e-6 * HEIGHTS.std(), rel=1e-6)
    with pytest.raises(TopographyError, match="'V' is not a unit of length"):
        read_all([of_xarray("V")], **MATRIX)


def test_coordinates_of_an_array_say_its_size_and_their_order() -> None:
    xr = pytest.importorskip("xarray")
    x, y = (xr.Variable((name,), PIXEL * np.arange(n), {"units": "nm"}) for name, n in zip("xy", SHAPE, strict=True))
    is_the_map(read_topography(of_xarray(x=x, y=y)))
    is_the_map(read_topography(of_xarray(x=x, y=y)[::-1]))
    with pytest.raises(TopographyError, match="the array itself says the size"):
        read_all([of_xarray(x=x, y=y)], size="1um")
    bare = of_xarray(x=PIXEL * np.arange(20), y=PIXEL * np.arange(16))
    with pytest.raises(TopographyError, match="the array does not say the unit of its positions"):
        read_topography(bare)


class Quantity(np.ndarray):
    """An array with a unit, as pint (``units``) and Astropy (``unit``) have it."""


@pytest.mark.parametrize("name", ["units", "unit"])
@pytest.mark.parametrize("unit", ["nm", "nanometer", "um", SimpleNamespace(__str__=lambda self: "nm")])
def test_a_quantity_keeps_its_unit(name: str, unit: Any) -> None:
    text = unit if isinstance(unit, str) else "nm"
    array = (HEIGHTS * (1e-3 if text == "um" else 1.0)).view(Quantity)
    setattr(array, name, text)
    is_the_map(read_all([array], size="200nm,160nm")[0])
    with pytest.raises(TopographyError, match="the array itself says the unit"):
        read_all([array], size="200nm,160nm", unit="mm")


def test_a_table_of_pandas_and_a_dataset_say_their_unit(tmp_path: Path) -> None:
    pandas, h5py = pytest.importorskip("pandas"), pytest.importorskip("h5py")
    frame = pandas.DataFrame(1e-3 * HEIGHTS)
    frame.attrs["units"] = "um"
    is_the_map(read_all([frame], size="200nm,160nm")[0])
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["h"] = (1000 * HEIGHTS).round().astype(np.int16)
        file["h"].attrs.update({"units": "nm", "scale_factor": 1e-3})
        found = read_all([file["h"]], size="200nm,160nm")[0]
    np.testing.assert_allclose(found.heights, 1e-9 * HEIGHTS, atol=1e-12)
