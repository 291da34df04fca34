"""Measured maps: what is read, what is refused, what is taken off."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.front.cli import main
from continuum.maps.map import Topography, TopographyError, mirror, opposed
from continuum.maps.mending import detrend
from continuum.maps.reading import read_all, read_topography
from tests.measured import AFM, MEASURED, needs_files, needs_reader

CONTACT = ["--material", "silicon"]
UNITS = ["--size", "100nm", "--unit", "nm"]


def rough(rng: np.random.Generator, nx: int = 20, ny: int = 24) -> np.ndarray:
    return rng.normal(size=(nx, ny)).cumsum(0).cumsum(1)


@pytest.mark.parametrize("suffix", [".npy", ".txt", ".csv", ".h5"])
def test_plain_arrays_are_read_with_the_units_given(suffix: str, tmp_path: Path, rng: np.random.Generator) -> None:
    import h5py

    heights, path = rough(rng), tmp_path / f"map{suffix}"
    if suffix == ".npy":
        np.save(path, heights)
    elif suffix == ".h5":
        with h5py.File(path, "w") as file:
            file["deep/heights"] = heights
    else:
        np.savetxt(path, heights.T, delimiter="," if suffix == ".csv" else " ")  # x along a line
    dataset = "deep/heights" if suffix == ".h5" else None
    found = read_topography(path, size=(1e-6,), unit=1e-9, dataset=dataset)
    np.testing.assert_allclose(found.heights, heights * 1e-9, rtol=1e-15)
    assert found.lengths == pytest.approx((1e-6, 1.2e-6))  # square pixels
    assert not found.periodic
    assert found.source == path.name
    assert read_topography(path, size=(1e-6, 3e-6), unit=1e-9, dataset=dataset).lengths == (1e-6, 3e-6)


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ("nan", "8 of 480 heights are missing, 1.67 %: --fill 2% fills them, or --crop cuts out a part that has all"),
        ("inf", "8 of 480 heights are missing, 1.67 %: --fill 2% fills them, or --crop cuts out a part that has all"),
        ("constant", "all heights are equal"),
        ("nothing", "all heights are equal"),
        ("plane", "the map is a plane"),
        ("one-dimensional", "at least 64 heights"),
        ("three-dimensional", "two-dimensional"),
        ("small", "at least 16 points"),
        ("complex", "not real numbers"),
        ("pickled", "not a plain .npy file"),
        ("truncated", "not a plain .npy file"),
        ("absent", "there is no such file"),
    ],
)
def test_what_is_no_map_is_refused_with_one_message_and_nothing_written(
    fault: str, expected: str, tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]
) -> None:
    heights, path = rough(rng), tmp_path / "map.npy"
    if fault in ("nan", "inf"):
        heights[3, 4:12] = float(fault)
    heights = {
        "constant": np.full((20, 24), 1e-7),
        "nothing": 1e-200 * heights,
        "plane": np.add.outer(np.arange(20.0), 3 * np.arange(24.0)),
        "one-dimensional": heights[0],
        "three-dimensional": np.stack([heights, heights]),
        "small": heights[:15],
        "complex": heights.astype(complex),
        "pickled": heights.astype(object),
    }.get(fault, heights)
    np.save(path, heights, allow_pickle=True)
    if fault == "truncated":
        path.write_bytes(path.read_bytes()[:50])
    if fault == "absent":
        path.unlink()
    out = tmp_path / "out"
    assert main(["predict", str(path), *UNITS, *CONTACT, "-o", str(out)]) == 2
    said = capsys.readouterr()
    assert expected in said.err
    assert "map.npy" in said.err
    assert not said.out
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], "does not say the size"),
        (["--size", "100nm"], "does not say the unit"),
        (["--unit", "nm"], "does not say the size"),
        (["--size", "100", "--unit", "nm"], "a unit of length is missing"),
        (["--size", "100GPa", "--unit", "nm"], "not a unit of length"),
        (["--size=-1nm", "--unit", "nm"], "positive"),
        (["--size", "nm", "--unit", "nm"], "not a number"),
        (["--size", "1um,1um,1um", "--unit", "nm"], "one or two lengths"),
        (["--size", "100nm", "--unit", "furlong"], "not a unit of length"),
        (["--size", "100nm", "--unit", "nm", "--unit", "nm"], "--unit: 2 values for one map"),
    ],
)
def test_units_of_a_map_are_never_guessed(
    options: list[str], expected: str, tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "map.npy", rough(rng))
    out = tmp_path / "out"
    assert main(["predict", str(tmp_path / "map.npy"), *options, *CONTACT, "-o", str(out)]) == 2
    assert expected in capsys.readouterr().err
    assert not out.exists()


def test_a_contact_has_no_three_surfaces(tmp_path: Path) -> None:
    with pytest.raises(TopographyError, match="one or two"):
        read_all([tmp_path / "a", tmp_path / "b", tmp_path / "c"])


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-10, 10), st.integers(16, 23), st.integers(16, 23))
def test_a_tilt_leaves_no_trace(a: float, b: float, c: float, nx: int, ny: int) -> None:
    heights = rough(np.random.default_rng(5), nx, ny)
    x, y = np.arange(nx)[:, None] * 0.7, np.arange(ny)[None, :] * 1.3
    lengths = (0.7 * nx, 1.3 * ny)
    flat = detrend(Topography(heights, lengths))
    tilted = detrend(Topography(heights + a * x + b * y + c, lengths))
    np.testing.assert_allclose(tilted.heights, flat.heights, atol=1e-11)
    # The plane of least squares: what is left is orthogonal to it.
    for direction in (np.ones((nx, ny)), x + 0 * y, y + 0 * x):
        assert abs(np.sum(direction * flat.heights)) < 1e-9 * np.abs(flat.heights).max() * heights.size * ny
    assert "mean plane" in tilted.steps[0]


def test_without_detrending_only_the_mean_goes(rng: np.random.Generator) -> None:
    heights = rough(rng)
    kept = detrend(Topography(heights, (1.0, 1.0)), "none")
    np.testing.assert_allclose(kept.heights, heights - heights.mean(), atol=1e-13)
    assert kept.steps == ("mean height taken off",)
    # A plane would leave a step at the edges of a periodic map.
    assert detrend(Topography(heights, (1.0, 1.0), periodic=True)).steps == kept.steps


def test_mirror_images_close_a_map_without_a_step(rng: np.random.Generator) -> None:
    heights = rough(rng)
    closed = mirror(Topography(heights, (2.0, 3.0)))
    assert closed.periodic
    assert closed.lengths == (4.0, 6.0)
    np.testing.assert_array_equal(closed.heights[:20, :24], heights)
    np.testing.assert_array_equal(closed.heights, closed.heights[::-1, ::-1])
    # No step between any two neighbours, across the edges as well, is larger than within the map.
    for axis in (0, 1):
        around = np.abs(closed.heights - np.roll(closed.heights, 1, axis)).max()
        assert around <= np.abs(np.diff(heights, axis=axis)).max()
    assert closed.heights.std() == pytest.approx(heights.std(), rel=1e-12)


def test_two_bodies_add_their_heights(rng: np.random.Generator) -> None:
    first = Topography(rough(rng), (20.0, 24.0), source="a")
    second = Topography(rough(rng, 30, 22), (30.0, 22.0), source="b")
    both = opposed(first, second)
    np.testing.assert_array_equal(both.heights, first.heights[:, :22] + second.heights[::-1][:20])
    assert both.lengths == (20.0, 22.0)
    assert "cut to 20 x 22" in both.steps[-1]
    with pytest.raises(TopographyError, match="pixels of"):
        opposed(first, Topography(second.heights, (30.0, 23.0), source="b"))


def test_equal_contents_have_equal_digests(rng: np.random.Generator) -> None:
    heights = rough(rng)
    one, other = Topography(heights, (1.0, 1.0), source="a"), Topography(heights.copy(), (1.0, 1.0), source="b")
    assert one.digest == other.digest != Topography(heights, (1.0, 2.0)).digest


@needs_reader
def test_the_header_of_an_instrument_names_its_units(tmp_path: Path, rng: np.random.Generator) -> None:
    heights, path = rough(rng), tmp_path / "export.txt"
    np.savetxt(path, heights, header="Channel: Main\nWidth: 10 µm\nHeight: 12 µm\nValue units: nm")
    found = read_topography(path)
    assert sorted(found.lengths) == pytest.approx([10e-6, 12e-6])
    assert found.heights.std() == pytest.approx(heights.std() * 1e-9)
    np.save(tmp_path / "bare.npy", heights)
    with pytest.raises(TopographyError, match="does not say the size"):
        read_topography(tmp_path / "bare.npy")
    path.with_suffix(".odd").write_bytes(b"nothing at all\n" * 5)
    with pytest.raises(TopographyError, match="none of its formats"):
        read_topography(path.with_suffix(".odd"))


@needs_reader
def test_holes_of_an_instrument_are_refused(tmp_path: Path, rng: np.random.Generator) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that there is no MPI
        from SurfaceTopography import Topography as Theirs

        heights = rough(rng)
        Theirs(heights, (2.0, 3.0), unit="um", periodic=True).to_netcdf(str(tmp_path / "whole.nc"))
        holes = np.ma.masked_array(heights, heights > np.quantile(heights, 0.99))
        Theirs(holes, (2.0, 3.0), unit="um", periodic=False).to_netcdf(str(tmp_path / "holes.nc"))
    found = read_topography(tmp_path / "whole.nc")
    assert found.lengths == pytest.approx((2e-6, 3e-6))
    assert found.periodic
    np.testing.assert_allclose(found.heights, 1e-6 * heights, rtol=1e-12)
    with pytest.raises(TopographyError, match="5 of 480 heights are missing"):
        read_topography(tmp_path / "holes.nc")


def test_all_faults_of_files_and_contact_come_at_once(
    tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "a.npy", rough(rng))
    files = [str(tmp_path / name) for name in ("a.npy", "b.npy")]
    assert main(["predict", *files, "--work", "0mJ/m2", "--material", "granite"]) == 2
    said = capsys.readouterr().err
    for fault in ("size of the map", "unit of the map", "b.npy: there is no such file", "--work", "granite"):
        assert fault in said


@needs_reader
def test_a_size_is_overruled_only_knowingly(tmp_path: Path, rng: np.random.Generator) -> None:
    heights, path = rough(rng), tmp_path / "export.txt"
    np.savetxt(path, heights, header="Channel: Main\nWidth: 10 µm\nHeight: 12 µm\nValue units: nm")
    np.save(tmp_path / "bare.npy", heights)
    # Told, plain text is read as an array; an array beside it takes the units that are given for it alone.
    both = read_all([tmp_path / "bare.npy", path], size=["1um", "-"], unit=["nm", "-"])
    assert sorted(both[1].lengths) == pytest.approx([10e-6, 12e-6])
    assert both[0].lengths == pytest.approx((1e-6, 1.2e-6))


@needs_reader
@needs_files
def test_units_of_an_instrument_cannot_be_overruled() -> None:
    with pytest.raises(TopographyError, match="the file itself says the size"):
        read_topography(MEASURED / "mi-1.mi", size=(1e-6,))
    knowingly = read_topography(MEASURED / "mi-1.mi", size=(1e-6,), override=True)
    assert knowingly.lengths == (1e-6, 1e-6)
    assert any("overruled" in step for step in knowingly.steps)


@needs_reader
@needs_files
@pytest.mark.parametrize(
    ("name", "part", "points", "size", "height"),
    [("mi-1.mi", None, 256, 20e-6, 3.43e-9), ("container-2.zip", AFM, 512, 100e-9, 0.525e-9)],
)
def test_the_measured_maps_are_what_their_makers_say(
    name: str, part: str | None, points: int, size: float, height: float
) -> None:
    found = detrend(read_topography(MEASURED / name, part=part))
    assert found.heights.shape == (points, points)
    assert found.lengths == pytest.approx((size, size))
    assert found.heights.std() == pytest.approx(height, rel=2e-3)  # three digits are given
    assert not found.periodic


@needs_reader
@needs_files
def test_a_map_of_a_container_is_chosen_by_name() -> None:
    path = MEASURED / "container-2.zip"
    with pytest.raises(TopographyError, match=re.escape(f", {AFM!r}, ")):
        read_topography(path, part="no such map")
