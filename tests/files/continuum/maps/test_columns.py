"""Text with columns of positions and heights, datasets of an HDF5 file, and several files of one surface."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.front.cli import main
from continuum.maps.faults import find_faults
from continuum.maps.map import TopographyError
from continuum.maps.mending import prepare
from continuum.maps.reading import read_all, read_topography
from continuum.maps.roughness import roughness_of
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import prediction_of
from tests.measured import needs_reader
from tests.problems import Rough

pytestmark = pytest.mark.usefixtures("unpressed")

HEIGHTS = np.random.default_rng(3).normal(size=(20, 24)).cumsum(0).cumsum(1)
X, Y = (one.ravel() for one in np.meshgrid(np.arange(20) * 0.05 + 3, np.arange(24) * 0.05 - 1, indexing="ij"))
XYZ = np.stack([X, Y, HEIGHTS.ravel()], axis=1)
LINE = np.stack([np.arange(128) * 0.05, np.random.default_rng(3).normal(size=128).cumsum()], axis=1)


def written(folder: Path, rows: np.ndarray, header: str = "", delimiter: str = ",", name: str = "map.csv") -> Path:
    lines = [delimiter.join(f"{value:.9g}" for value in row) for row in rows]
    (folder / name).write_text("\n".join([*([header] if header else []), *lines]) + "\n", encoding="utf-8")
    return folder / name


@pytest.mark.parametrize("order", ["rows", "columns", "shuffled"])
def test_columns_of_positions_are_the_map_in_any_order(order: str, tmp_path: Path) -> None:
    """Size and heights are those of the array: the middles of 20 x 24 pixels of 50 nm."""
    rows = {
        "rows": XYZ,
        "columns": XYZ[np.lexsort((X, Y))],
        "shuffled": np.random.default_rng(1).permutation(XYZ),
    }[order]
    found = read_all([written(tmp_path, rows)], unit="um,nm")[0]
    np.testing.assert_allclose(found.heights, 1e-9 * HEIGHTS, rtol=1e-8, atol=1e-16)
    assert found.lengths == pytest.approx((1e-6, 1.2e-6))
    assert any("grid of 20 x 24" in step for step in found.steps)
    same = read_all([rows], unit="um,nm")[0]
    np.testing.assert_allclose(same.heights, found.heights, rtol=1e-8, atol=1e-16)


@pytest.mark.parametrize(
    ("header", "delimiter"),
    [
        ("x [um],y [um],z [nm]", ","),
        ("X (µm);Y (µm);Height (nm)", ";"),
        ("x/um\ty/um\tz/nm", "\t"),
        ("# x [um] y [um] z [nm]", " "),
        ("exported from a microscope\nx [um],y [um],z [nm]", ","),
        ("x in µm,y in µm,z in nm", ","),
    ],
)
def test_a_header_names_the_units_of_its_columns(header: str, delimiter: str, tmp_path: Path) -> None:
    found = read_topography(written(tmp_path, XYZ, header, delimiter))
    assert found.lengths == pytest.approx((1e-6, 1.2e-6))
    assert found.heights.std() == pytest.approx(1e-9 * HEIGHTS.std())
    assert "header left out" in found.steps[0]
    with pytest.raises(TopographyError, match="the file itself says the unit"):
        read_topography(tmp_path / "map.csv", unit=1e-6)
    assert read_topography(tmp_path / "map.csv", unit=1e-9).heights.std() == found.heights.std()  # no conflict


def test_text_of_two_bytes_a_character_and_a_column_that_counts(tmp_path: Path) -> None:
    """As some instruments export tables: UTF-16, the first column an index."""
    path = written(tmp_path, np.column_stack((np.arange(len(LINE)), LINE)), "index,x in µm,z in nm")
    path.write_text(path.read_text(encoding="utf-8"), encoding="utf-16")
    same = read_topography(written(tmp_path, LINE, "x [um],z [nm]", name="line.csv"))
    np.testing.assert_array_equal(read_topography(path).heights, same.heights)


def test_a_decimal_comma_and_a_header_of_an_array(tmp_path: Path) -> None:
    path = written(tmp_path, XYZ, delimiter=";")
    path.write_text(path.read_text().replace(".", ","))
    assert read_all([path], unit="um,nm")[0].lengths == pytest.approx((1e-6, 1.2e-6))
    array = written(tmp_path, HEIGHTS, "heights", ",", "array.csv")
    np.testing.assert_allclose(read_topography(array, size=[1.0], unit=1.0).heights, HEIGHTS.T, rtol=1e-8)


def test_positions_and_heights_of_a_line(tmp_path: Path) -> None:
    """The same as its heights with the length of the scan; points at odd distances are interpolated."""
    path = written(tmp_path, LINE[::-1], "x [um],z [nm]")
    found, same = read_topography(path), read_all([LINE[:, 1]], size="6.4um", unit="nm")[0]
    assert found.lines == 1
    np.testing.assert_allclose(found.heights, same.heights, rtol=1e-6, atol=1e-6 * np.ptp(same.heights))
    kept = np.delete(LINE, np.arange(5, 128, 7), axis=0)
    uneven = read_topography(written(tmp_path, kept, "x [um],z [nm]"))
    assert any("straight lines over up to 2 spacings" in step for step in uneven.steps)


def test_a_place_without_a_point_is_a_hole(tmp_path: Path) -> None:
    path = written(tmp_path, np.delete(XYZ, [77, 200, 301], axis=0), "x [um],y [um],z [nm]")
    found = read_topography(path)
    assert found.heights.shape == (20, 24)
    assert any("0.62 % of the points, missing, filled harmonically" in step for step in found.steps)


BAD: dict[str, tuple[np.ndarray, str, list[str], str]] = {
    "no unit": (XYZ, "", [], "give the units of both, positions and heights, as --unit um,nm, or --size"),
    "one unit": (XYZ, "", ["--unit", "nm"], "does not say the unit of its positions"),
    "three units": (XYZ, "", ["--unit", "um,um,nm"], "one unit, of the heights, or two"),
    "no length": (XYZ, "", ["--unit", "um,Pa"], "not a unit of length"),
    "two units of an array": (HEIGHTS, "", ["--unit", "um,nm", "--size", "1um"], "it has no positions"),
    "two sizes": (XYZ, "", ["--unit", "um,nm", "--size", "1um"], "its size is known without"),
    "twice": (np.concatenate([XYZ, XYZ[:1]]), "", ["--unit", "um,nm"], "two heights have the same position"),
    "twice on a line": (LINE[[0, *range(128)]], "", ["--unit", "um,nm"], "two heights have the same position"),
    "no grid": (np.random.default_rng(1).uniform(size=(400, 3)), "", ["--unit", "um,nm"], "not equidistant"),
    "uneven grid": (XYZ * [1, 1, 1] + np.outer(X > 3.5, [0.02, 0, 0]), "", ["--unit", "um,nm"], "not equidistant"),
    "no position": (np.where(X[5] == XYZ, np.nan, XYZ), "", ["--unit", "um,nm"], "a position is missing"),
    "x and y in two units": (XYZ, "x [um],y [nm],z [nm]", [], "x and y in two units"),
    "units that the file has": (LINE, "x [um],z [nm]", ["--unit", "um,pm"], "itself says the unit"),
    "a word in a row": (HEIGHTS, "1,2,three", ["--size", "1um", "--unit", "nm"], "not a table of numbers"),
}


@pytest.mark.parametrize("fault", BAD)
def test_columns_that_are_no_map_are_refused_in_one_message(
    fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows, header, options, expected = BAD[fault]
    path = written(tmp_path, rows, header)
    assert main(["predict", str(path), *options, "--material", "mica", "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert "map.csv" in said
    lines = [line for line in said.splitlines() if not line.startswith("reading ")]
    assert len(lines) == (2 if fault == "no unit" else 1)  # neither positions nor heights have one
    assert not (tmp_path / "out").exists()


def test_the_only_dataset_is_taken_and_several_are_named(tmp_path: Path) -> None:
    import h5py

    path = tmp_path / "map.h5"
    with h5py.File(path, "w") as file:
        file["deep/heights"] = HEIGHTS
        file["deep/date"] = "today"
        file["x"] = np.arange(20.0)
    found = read_topography(path, size=[1.0], unit=1.0)
    np.testing.assert_array_equal(found.heights, HEIGHTS)
    assert found.steps[0] == "dataset 'deep/heights' taken, the only one"
    with h5py.File(path, "a") as file:
        file["phase"] = HEIGHTS
    with pytest.raises(
        TopographyError, match="2 datasets could be the map: choose one by `dataset`; datasets: deep/he"
    ):
        read_topography(path, size=[1.0], unit=1.0)
    with h5py.File(path, "w") as file:
        file["date"] = "today"
    with pytest.raises(TopographyError, match="no dataset is a map of numbers; datasets: none"):
        read_topography(path, size=[1.0], unit=1.0)


@needs_reader
def test_a_netcdf_file_is_read_by_its_reader_whatever_is_told(tmp_path: Path) -> None:
    """With a unit beside it, it went to the reader of HDF5, which knows no netCDF 3."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that there is no MPI
        from SurfaceTopography import Topography as Theirs

        Theirs(HEIGHTS, (2.0, 2.4), unit="um", periodic=False).to_netcdf(str(tmp_path / "map.nc"))
    with pytest.raises(TopographyError, match="the file itself says the unit"):
        read_topography(tmp_path / "map.nc", unit=1e-9)
    assert read_topography(tmp_path / "map.nc", unit=1e-9, override=True).heights.std() == pytest.approx(
        1e-9 * HEIGHTS.std()
    )


def test_files_of_one_surface_are_joined(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An overview, a close-up and a line, each with its size: one surface, of all their waves."""
    rng = np.random.default_rng(1)
    np.save(tmp_path / "wide.npy", Rough(64).heights())
    np.save(tmp_path / "close.npy", Rough(64, seed=2).heights() / 4)
    np.savetxt(tmp_path / "line.txt", rng.normal(size=256).cumsum() / 20)
    files = [str(tmp_path / name) for name in ("wide.npy", "close.npy", "line.txt")]
    sizes: dict[str, Any] = {"size": ["640nm", "80nm", "500nm"], "unit": "nm"}
    found = read_all(files, **sizes, join=True)
    assert len(found) == 1
    assert found[0].measurements == 3
    assert found[0].source == "wide.npy + close.npy + line.txt"
    alone = [read_all([file], size=size, unit="nm")[0] for file, size in zip(files, sizes["size"], strict=True)]
    slopes = [roughness_of(one).moments.rms_slope for one in alone]
    assert roughness_of(found[0]).moments.rms_slope > slopes[0]
    with pytest.raises(TopographyError, match="`join` measurements of one surface"):
        read_all(files, **sizes)
    with pytest.raises(TopographyError, match="`join`: several measurements"):
        read_all(files[:1], size="640nm", unit="nm", join=True)
    command = ["predict", *files, "--unit", "nm", "--join", "--material", "mica", "-o", str(tmp_path / "out")]
    for size in sizes["size"]:
        command += ["--size", size]
    assert main(command) == 0
    assert capsys.readouterr().out.count("as bounds only, from the spectrum") == 1
    assert "from 3 measurements" in (tmp_path / "out" / "wide-close-line-predict.html").read_text()


def test_a_dash_stands_for_what_the_file_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command took it for an option without a value."""
    np.save(tmp_path / "bare.npy", HEIGHTS)
    files = [str(tmp_path / "bare.npy"), str(written(tmp_path, XYZ, "x [um],y [um],z [nm]"))]
    options = ["--size", "1um", "--size", "-", "--unit", "nm", "--unit", "-", "--material", "mica", "--no-solve"]
    assert main(["predict", *files, *options, "-o", str(tmp_path / "out")]) == 0
    assert any("1 µm x 1.2 µm" in page.read_text() for page in (tmp_path / "out").glob("*.html"))
    with pytest.raises(SystemExit):
        main(["predict", *files, "--size", "-", "-", "--material", "mica"])


def test_joined_measurements_keep_the_waves_that_no_drawn_surface_has() -> None:
    """Three decades and a half of an overview and a close-up: h_rms is that of the overview."""
    wide, close = Rough(64).heights(), Rough(64, seed=2).heights() / 100
    overview, detail = read_topography(wide, size=[1e-3], unit=1e-9), read_topography(close, size=[1e-6], unit=1e-9)
    found = read_all([wide, close], size=["1mm", "1um"], unit="nm", join=True)[0]
    height = roughness_of(found).moments.rms_height
    assert height == pytest.approx(roughness_of(overview).moments.rms_height, rel=0.3)
    assert height > 10 * roughness_of(detail).moments.rms_height
    assert found.heights.std() < height / 5


@pytest.mark.long
def test_joined_measurements_are_judged_by_all_their_waves() -> None:
    wide, close = Rough(64).heights(), Rough(64, seed=2).heights() / 100
    found = read_all([wide, close], size=["1mm", "1um"], unit="nm", join=True)[0]
    judged = prediction_of([found], Interface(1e9, 0.05, 0.35e-9, None)).contact
    assert judged.rms_height == pytest.approx(roughness_of(found).moments.rms_height)


def test_what_was_filled_is_not_advised_again() -> None:
    heights = Rough(64).heights().copy()
    heights[10, 20:50] += 5 * heights.std()
    heights[40, 5:30] -= 5 * heights.std()
    topography = read_topography(heights, size=[1e-6], unit=1e-9)
    assert {"scars", "spikes"} & {fault.kind for fault in find_faults(prepare(topography)).faults}
    after = find_faults(prepare(topography, fill=0.1)).faults
    assert not any("fill" in fault.remedy for fault in after)


def test_few_holes_of_an_array_are_filled_and_said() -> None:
    holes = np.ma.masked_greater(HEIGHTS, np.quantile(HEIGHTS, 0.995))
    found = c.predict(holes, size="1um", unit="nm", material="mica", solve=False)
    assert "0.62 % of the points, missing, filled harmonically" in found.sheets()[0].text()
