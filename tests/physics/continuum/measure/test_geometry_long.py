"""What the paper says of the geometry of rough contacts, at its sizes; and what measuring it costs at 4096²."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

import continuum
from continuum.paper.figures import FIGURES
from continuum.paper.points import SweepData

pytestmark = pytest.mark.long


INPUTS = Path(__file__).parents[4] / "inputs" / "sweep"


def data_of_sweep(name: str, into: Path, **settings: object) -> SweepData:
    """A sweep of this repository, with other values of some keys."""
    swept = continuum.sweep(
        INPUTS / f"{name}.toml", into, settings={k.replace("__", "."): v for k, v in settings.items()}
    )
    assert swept.ok
    return SweepData(swept.collect(), swept.folder)


# --- perimeter, chord and diameter ---------------------------------------------------------------------------


def test_perimeter_and_chord_belong_together_above_ten_cells_and_fall_apart_below(tmp_path: Path) -> None:
    # Half the size is as many asperities where they are small.
    for n, waves in ((512, [4.0, 8.0]), (1024, [16.0, 32.0])):
        points = data_of_sweep(
            "figure-s2", tmp_path / str(n), grid__n=n, surface__lambda_L=n / 2, surface__hurst=[0.3, 0.8],
            surface__rms_slope=[0.1], surface__lambda_s=waves, wall__adhesion_length=[0.0005, 0.05],
            # Strong adhesion jumps over 1 % where λ_s is small: 4 % is there for it.
            loading__targets=[0.01, 0.04], loading__area_tolerance=0.3,
        ).points  # fmt: skip
        assert len(np.unique(points.system)) == 8
        chord = points["chord"]
        ratio = points["perimeter"] * chord / (np.pi * points["area_rep"] * points.area)
        assert (np.abs(ratio[chord > 10] - 1) < 0.1).all()  # Fig. S-2
        # The drop: a cell with several edges counts once, which is about half a cell of each chord.
        assert (ratio[chord < 6] < 0.95).all()
        assert (ratio[chord < 4] < 0.9).all()
        if n == 512:
            assert set(points.length[chord < 6]) == {0.0005, 0.05}


def test_the_diameter_hardly_depends_on_the_area(tmp_path: Path) -> None:
    points = data_of_sweep(
        "figure3", tmp_path, grid__n=2048, surface__lambda_L=1024.0, surface__hurst=[0.8], surface__rms_slope=[0.1],
        surface__lambda_s=[16.0], wall__adhesion_length=[0.0], loading__targets=[0.001, 0.003, 0.01, 0.03, 0.1],
        loading__area_tolerance=0.05,
    ).points  # fmt: skip
    d, area, expected = points["diameter"], points["area_rep"], points.expected_diameter
    assert area.max() > 80 * area.min()
    assert ((d > 0.5 * expected) & (d < 2 * expected)).all()
    assert d[area > 0.005].max() < 1.25 * d[area > 0.005].min()
    # The exception: below 0.5 % area only the highest asperities touch, and their patches still grow: 75 % over two
    # decades here, where the paper says 25 %.
    assert d.max() < 2 * d.min()


# --- the gap -------------------------------------------------------------------------------------------------


def test_the_gap_outside_the_contact_follows_the_paper(tmp_path: Path) -> None:
    walls = [{"law": "hard"}, *({"law": "lennard-jones-spline", "adhesion_length": w} for w in (0.0, 0.0005, 0.005))]
    sheet = FIGURES["gap-profile"].make(data_of_sweep("gap-profile", tmp_path, wall=walls, surface__seed=[1])).sheet
    heads = [column.name for column in sheet.columns]
    edge, cells = (
        heads.index("gap over S-1, least, from the edge"),
        heads.index("gap over S-1, least, from perimeter cells"),
    )
    assert len(sheet.rows) == 2 * len(walls)
    for row in sheet.rows:
        # A soft wall opens the gap earlier, as if the edge were that of the perimeter cells; adhesion closes it again.
        near = edge if row[1] == "hard" or row[2] == 0.005 else cells
        if row[0] == 32.0 or row[1] == "hard":
            assert row[near] > 0.8
            assert row[near + 1] < 1.3


# --- cost ----------------------------------------------------------------------------------------------------

_COST = """
import json, sys, time
import numpy as np
from continuum.model.grid import Grid
from continuum.measure.outline import areas, outline, patches
from continuum.measure.outline import gap_distribution, gap_profile, pressure_distribution
from continuum.model.walls import LennardJonesSpline

gap = np.load(sys.argv[1])
grid, wall = Grid.square(gap.shape[0]), LennardJonesSpline(adhesion_length=0.005)
inside = gap < wall.zero_gap
wall.evaluate(gap[:1])  # compiled or read from the cache once
counting = []
for _ in range(3):
    start = time.process_time()
    outline(grid, inside), patches(grid, inside), areas(grid, wall, gap)
    counting.append(time.process_time() - start)
middle = time.process_time()
gap_profile(grid, gap, inside, 80.0, wall.zero_gap)
end = time.process_time()
gap_distribution(grid, gap), pressure_distribution(grid, wall, gap)
# Not getrusage's: that counts what the process that started this one held.
peak = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM")) * 1024
print(json.dumps([min(counting), end - middle, peak]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads the peak memory from /proc")
@pytest.mark.parametrize("fraction", [0.01, 0.3])
def test_a_large_map_is_measured_in_seconds_within_a_gibibyte(tmp_path: Path, fraction: float) -> None:
    n = 4096
    gap = ndimage.gaussian_filter(np.random.default_rng(1).standard_normal((n, n)), 6.0, mode="wrap")
    gap += 1.0 - np.quantile(gap[::8, ::8], fraction)
    np.save(tmp_path / "gap.npy", gap)
    inside = gap < 1.0
    labels = []
    for _ in range(3):  # the shortest of three, there as here: others may use the machine
        start = time.process_time()
        ndimage.label(inside)
        labels.append(time.process_time() - start)
    start, label = time.process_time(), min(labels)
    ndimage.distance_transform_edt(~inside)
    transform = time.process_time() - start
    done = subprocess.run(
        [sys.executable, "-c", _COST, str(tmp_path / "gap.npy")], capture_output=True, text=True, check=True
    )
    counting, profile, peak = json.loads(done.stdout)
    assert counting < 20 * label
    assert profile < 2 * transform
    assert peak < 2**30
