"""Several measurements of one surface against the surface that they were cut from."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from continuum.front.cli import main
from continuum.maps.instruments import measurements
from continuum.maps.map import Topography, TopographyError
from continuum.maps.reading import read_topography
from continuum.maps.spectra import isotropic_surface, joined, joined_spectrum
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine, moments
from tests.kinds import covering
from tests.measured import MEASURED, needs_files, needs_reader

NM = 1e-9
GRID = Grid.square(1024)


def measured(hurst: float, seed: int) -> tuple[Real, Topography, Topography]:
    """A surface in nm; a window of it with all its pixels, and all of it at an eighth of the resolution."""
    heights = SelfAffine(hurst, 0.1, 8.0, 512.0).synthesise(GRID, np.random.default_rng(seed))
    fine = Topography(heights[:256, :256] * NM, (256 * NM, 256 * NM), source="fine")
    smooth = GRID.inverse(GRID.forward(heights) * (GRID.wavenumber < np.pi / 8))[::8, ::8]
    return heights, fine, Topography(smooth * NM, (1024 * NM, 1024 * NM), source="coarse")


@pytest.mark.parametrize(("seed", "hurst"), covering([1, 2, 3], [0.3, 0.8]))
def test_a_window_and_an_overview_give_the_whole_surface(hurst: float, seed: int) -> None:
    heights, fine, coarse = measured(hurst, seed)
    found = joined([fine, coarse])
    mine, true = moments(found.grid, found.heights), moments(GRID, heights * NM)
    # The window holds a sixteenth of the area: slope and curvature of such windows scatter by 2 - 3 %, and bands of a
    # twelfth of a decade round off the cut-off, by up to 8 % of the curvature (all six: 0.944 - 0.992, 0.91 - 0.98).
    assert mine.rms_slope == pytest.approx(true.rms_slope / NM, rel=0.08)
    assert mine.rms_curvature == pytest.approx(true.rms_curvature / NM**2, rel=0.12)
    # Heights hang on the longest waves, of which the overview has a few under its window (0.72 - 0.96).
    assert 0.6 < mine.rms_height / true.rms_height < 1.2
    assert found.lengths == (1024 * NM, 1024 * NM)
    assert found.measurements == 2
    assert "differ by a factor of 1." in found.steps[-1]


def test_neither_alone_does() -> None:
    """What the join is for: the overview lacks the curvature, the window the long waves."""
    heights, fine, coarse = measured(0.3, 3)
    true = moments(GRID, heights * NM)
    assert moments(coarse.grid, coarse.heights).rms_curvature < 0.7 * true.rms_curvature / NM**2
    found = joined([fine, coarse])
    q = joined_spectrum([fine, coarse])[0]
    # Middles of the bands, of which the first begins at the longest wave.
    assert q[0] < 2 * np.pi / (700 * NM)
    assert q[-1] > np.pi / (1.2 * NM)
    assert found.grid.shape == (1024, 1024)


def test_measurements_that_contradict_each_other_are_told() -> None:
    _, fine, coarse = measured(0.8, 1)
    wrong = Topography(3 * coarse.heights, coarse.lengths, source="in other units")
    assert joined_spectrum([fine, wrong])[2] > 2 * joined_spectrum([fine, coarse])[2]


def test_a_line_scan_joins_a_map() -> None:
    heights, fine, _ = measured(0.8, 2)
    line = isotropic_surface(heights[::32] * NM, 1024 * NM, periodic=True)
    found = joined([fine, line])
    true = moments(GRID, heights * NM)
    # 32 lines: 3 % in slope (docs/studies/index.md), and bands twice as wide.
    assert moments(found.grid, found.heights).rms_slope == pytest.approx(true.rms_slope / NM, rel=0.12)


def test_nothing_to_join_is_said() -> None:
    with pytest.raises(TopographyError, match="no measurement"):
        joined([])
    assert measurements(Path("no such file")) == ()


@needs_reader
@needs_files
def test_a_container_as_a_whole_and_each_of_its_measurements(tmp_path: Path) -> None:
    path = MEASURED / "container-2.zip"
    names = measurements(path)
    assert len(names) == 3
    whole = read_topography(path, part="all")
    assert whole.measurements == 3
    command = ["predict", str(path), "--material", "diamond", "--material", "diamond", "--no-solve"]
    assert main([*command, "--csv", str(tmp_path / "all.csv")]) == 0
    rows = list(csv.DictReader((tmp_path / "all.csv").read_text().splitlines()))
    assert tuple(row["part"] for row in rows) == names
    assert main([*command, "--part", "all", "-o", str(tmp_path)]) == 0
    assert (tmp_path / "container-2-predict.html").is_file()
