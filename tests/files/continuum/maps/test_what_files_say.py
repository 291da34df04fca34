"""What a file says of its map comes first; sizes that no map has, and numbers for missing heights, are asked about."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from continuum.front.cli import main
from continuum.maps.map import TopographyError
from continuum.maps.reading import read_all, read_topography
from continuum.model.grid import Grid
from continuum.store.runs.config import FileSurface
from tests.measured import needs_reader

HEIGHTS = np.random.default_rng(3).normal(size=(32, 20)).cumsum(0)
GWYDDION = "Channel: Topo\nWidth: 0.32 µm\nHeight: 0.2 µm\nValue units: m"


def written(folder: Path, heights: np.ndarray = HEIGHTS, header: str = "", name: str = "map.txt") -> Path:
    np.savetxt(folder / name, heights.T, header=header, encoding="utf-8", fmt="%.6g")
    return folder / name


@pytest.mark.parametrize(
    "given",
    [{"unit": "nm"}, {"size": "1um"}, {"size": "0.2um,0.32um"}, {"size": "0.32um,0.2um", "unit": "nm"}],
)
def test_a_header_is_not_thrown_away_when_something_is_given(given: dict[str, str], tmp_path: Path) -> None:
    path = written(tmp_path, 1e-9 * HEIGHTS, GWYDDION)
    as_it_is = read_all([path])[0]
    assert as_it_is.lengths == pytest.approx((0.32e-6, 0.2e-6))
    np.testing.assert_allclose(as_it_is.heights, 1e-9 * HEIGHTS, rtol=1e-5)  # six digits
    with pytest.raises(TopographyError, match="the file itself says the"):
        read_all([path], **given)
    # What agrees is no conflict, and what overrules is said.
    assert read_all([path], size="320nm,200nm", unit="m")[0].lengths == as_it_is.lengths
    larger = read_all([path], unit="mm", size="1um", override_size=True)
    assert larger[0].lengths[0] == 1e-6
    assert sum("overruled" in step for step in larger[0].steps) == 2


def test_attributes_of_a_dataset_are_not_overruled_unknowingly(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["height"] = np.round(1000 * HEIGHTS).astype(np.int16)
        file["height"].attrs.update({"units": "nm", "scale_factor": 0.001})
    found = read_all([tmp_path / "map.h5"], size="320nm,200nm")[0]
    np.testing.assert_allclose(found.heights, 1e-9 * np.round(1000 * HEIGHTS) / 1000, rtol=1e-12)
    with pytest.raises(TopographyError, match="the file itself says the unit"):
        read_all([tmp_path / "map.h5"], size="320nm,200nm", unit="um")


def test_x_is_along_a_line_of_any_text(tmp_path: Path) -> None:
    """A matrix, the same under a header, and the same points in columns are one map."""
    x, y = np.meshgrid(10.0 * np.arange(32), 10.0 * np.arange(20), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), HEIGHTS.ravel()]).T
    maps = [
        read_all([written(tmp_path)], size="320nm,200nm", unit="nm")[0],
        read_all([written(tmp_path, 1e-9 * HEIGHTS, GWYDDION, "header.txt")])[0],
        read_all([written(tmp_path, points, "x [nm] y [nm] z [nm]", "points.txt")])[0],
    ]
    for found in maps:
        np.testing.assert_allclose(found.heights, 1e-9 * HEIGHTS, rtol=1e-5)
        assert found.lengths == pytest.approx((0.32e-6, 0.2e-6))
    exchanged = read_all([written(tmp_path)], size="200nm,320nm", unit="nm")[0]
    assert any("square with the size 320nm,200nm" in step for step in exchanged.steps)
    assert not any("square" in step for found in maps for step in found.steps)


@pytest.mark.parametrize("factor", [1e-9, 1e-6, 1e-3])
def test_what_is_far_below_an_atom_is_in_another_unit(factor: float, tmp_path: Path) -> None:
    """Of a tilted map, too: a plane is no roughness."""
    tilted = factor * (HEIGHTS / HEIGHTS.std() + 0.0) + factor * 3 * np.arange(32.0)[:, None]
    with pytest.raises(TopographyError, match=r"an rms height of .* `unit` is probably larger"):
        read_all([0.5 * tilted], size="320nm,200nm", unit="nm")
    with pytest.raises(TopographyError, match=r"pixels of .* `size` is probably larger"):
        read_all([HEIGHTS], size=f"{320 * factor:g}nm", unit="nm")


def test_a_smooth_map_of_atoms_is_read() -> None:
    """An ångström of height, 0.05 nm a pixel."""
    assert read_all([HEIGHTS / HEIGHTS.std()], size="1.6nm,1nm", unit="A")[0].heights.std() < 1.1e-10


def test_a_number_for_missing_heights_is_asked_for_by_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    heights = HEIGHTS.copy()
    heights[3:7, 5] = 99999
    path = written(tmp_path, heights)
    options = ["predict", str(path), "--size", "320nm,200nm", "--unit", "nm", "--estar", "1GPa", "--work", "20mJ/m2"]
    options += ["--range", "0.5nm", "--no-solve", "-o", str(tmp_path / "out")]
    assert main(options) == 2
    said = capsys.readouterr().err
    assert "4 of 640 points have the value 99999" in said
    assert "--void 99999" in said
    (filled,) = read_all([path], size="320nm,200nm", unit="nm", void="99999")
    assert "4 points of the value 99999 taken as missing" in filled.steps
    assert "0.62 % of the points, missing, filled harmonically" in filled.steps
    # Six digits of heights of some 10 nm.
    assert np.abs(filled.heights[heights < 99999] - 1e-9 * HEIGHTS[heights < 99999]).max() < 1e-13
    kept = read_all([path], size="320nm,200nm", unit="nm", void="nan")[0]
    assert kept.heights.max() == pytest.approx(99999e-9)
    with pytest.raises(TopographyError, match="`void` 'many'"):
        read_all([path], size="320nm,200nm", unit="nm", void="many")


@needs_reader
def test_a_surface_data_file_of_npl_is_read_and_an_unknown_one_is_named(tmp_path: Path) -> None:
    keys = {"ManufacID": "none", "CreateDate": "010120261200", "ModDate": "010120261200", "NumPoints": 32,
            "NumProfiles": 20, "Xscale": "1E-8", "Yscale": "1E-8", "Zscale": "1E-9", "Zresolution": -1,
            "Compression": 0, "DataType": 7, "CheckType": 0}  # fmt: skip
    rows = "\n".join(" ".join(f"{one:.6f}" for one in line) for line in HEIGHTS.T)
    text = "\n".join(["", *(f"{key} = {value}" for key, value in keys.items()), "*", rows, "*", "*", ""])
    (tmp_path / "npl.sdf").write_text("aNPL-V1.0" + text)
    found = read_topography(tmp_path / "npl.sdf")
    np.testing.assert_allclose(found.heights, 1e-9 * HEIGHTS, rtol=0, atol=1e-15)
    assert found.lengths == pytest.approx((0.32e-6, 0.2e-6))
    (tmp_path / "new.sdf").write_text("aISO-3.0" + text)
    with pytest.raises(TopographyError, match=r"unknown version aISO-3\.0"):
        read_topography(tmp_path / "new.sdf")


def test_a_run_reads_what_a_prediction_reads(tmp_path: Path) -> None:
    """In a0: decimal commas, UTF-16, header lines, tabs in .csv, labels of positions in a0, columns of points."""
    grid, plain = Grid((32, 20), (32.0, 20.0)), {"kind": "file"}
    rows = [[f"{one:.4f}" for one in line] for line in HEIGHTS.T]
    x, y = (one.ravel() for one in np.meshgrid(np.arange(32), np.arange(20), indexing="ij"))
    points = [f"{i} {j} {one:.4f}" for i, j, one in zip(x, y, HEIGHTS.ravel(), strict=True)]
    texts = {
        "commas.csv": "\n".join(";".join(row) for row in rows).replace(".", ",").encode(),
        "tabs.csv": "\n".join(["exported by a program", *("\t".join(row) for row in rows)]).encode("utf-16"),
        "points.txt": "\n".join(points).encode(),
    }
    for name, raw in texts.items():
        (tmp_path / name).write_bytes(raw)
        found = FileSurface.model_validate(plain | {"path": tmp_path / name}).build(grid)
        np.testing.assert_array_equal(found, HEIGHTS.round(4))
    for header, said in (("Width: 32 nm\nHeight: 20 nm", "says the size"), ("Heights in nm", "says the unit")):
        surface = FileSurface.model_validate(plain | {"path": written(tmp_path, HEIGHTS, header)})
        with pytest.raises(ValueError, match=f"the file itself {said}"):
            surface.build(grid)
    scaled = FileSurface.model_validate(plain | {"path": tmp_path / "points.txt"})
    with pytest.raises(ValueError, match="the positions in the file are those of 32 x 20"):
        scaled.build(Grid((32, 20), (64.0, 40.0)))
    np.savetxt(tmp_path / "turned.txt", HEIGHTS)
    with pytest.raises(OSError, match="x is along a line of text"):
        FileSurface.model_validate(plain | {"path": tmp_path / "turned.txt"}).build(grid)
