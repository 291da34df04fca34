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

from tests.problems import Rough
from tests.studies.contacts import contacts
from tests.studies.geometry import AREAS, perimeter_ratio, profile_of, ratio

pytestmark = pytest.mark.long


# --- perimeter, chord and diameter ---------------------------------------------------------------------------


@pytest.mark.parametrize("adhesion_length", [0.0005, 0.05])
@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_perimeter_and_chord_belong_together_above_ten_cells_and_fall_apart_below(
    hurst: float, adhesion_length: float
) -> None:
    found = []
    for lambda_s in (4, 8, 16, 32):
        (contact,) = contacts(Rough(512 if lambda_s < 16 else 1024, adhesion_length, lambda_s, hurst=hurst), [0.01])
        found.append((contact.numbers.chord, perimeter_ratio(contact)))
        if contact.numbers.chord > 10:
            assert found[-1][1] == pytest.approx(1, abs=0.1)  # Fig. S-2
    chord, values = np.array(found).T
    assert (np.diff(chord) > 0).all()
    assert values[0] < values[-1] - 0.05  # the drop: a cell with several edges counts once
    assert values[0] < 0.95


def test_the_diameter_hardly_depends_on_the_area() -> None:
    measured = list(contacts(Rough(2048, 0.0, 16), AREAS))
    d = np.array([c.numbers.diameter for c in measured])
    area = np.array([c.numbers.area_rep for c in measured])
    assert area[-1] > 80 * area[0]
    assert ((d > 0.5 * measured[0].expected_diameter) & (d < 2 * measured[0].expected_diameter)).all()
    assert d[area > 0.005].max() < 1.25 * d[area > 0.005].min()
    # The exception: below 0.5 % area only the highest asperities touch, and their patches still grow: 75 % over two
    # decades here, where the paper says 25 %.
    assert d.max() < 2 * d.min()


# --- the gap -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lambda_s", [32, 64])
def test_the_gap_outside_a_hard_contact_follows_the_paper(lambda_s: int) -> None:
    (contact,) = contacts(Rough(2048, 0.0, lambda_s, hard=True), [0.01])
    low, high = ratio(contact, profile_of(contact), centres=False)
    assert low > 0.8
    assert high < 1.3


@pytest.mark.parametrize(("adhesion_length", "centres"), [(0.0, True), (0.0005, True), (0.005, False)])
def test_and_that_outside_a_soft_one(adhesion_length: float, centres: bool) -> None:
    # A soft wall opens the gap earlier, as if the edge were that of the perimeter cells; adhesion closes it again.
    (contact,) = contacts(Rough(2048, adhesion_length, 32), [0.01])
    low, high = ratio(contact, profile_of(contact), centres=centres)
    assert low > 0.8
    assert high < 1.3


# --- cost ----------------------------------------------------------------------------------------------------

_COST = """
import json, sys, time
import numpy as np
from continuum.model.grid import Grid
from continuum.measure.outline import areas, outline, patches
from continuum.measure.profile import gap_distribution, gap_profile, pressure_distribution
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
