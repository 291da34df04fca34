"""A measured map as a wall over atoms: where it is cut, how it is sampled, and that it is periodic."""

import numpy as np
import pytest

from continuum.maps.map import Topography, TopographyError
from continuum.maps.mending import wall_from_map

NM = 1e-9


def waves(n: int = 100, size: float = 50 * NM) -> Topography:
    """Two long waves, on pixels of 0.5 nm."""
    x, y = np.meshgrid(*[np.arange(n) * size / n] * 2, indexing="ij")
    return Topography(NM * (np.sin(2 * np.pi * x / (20 * NM)) + np.cos(2 * np.pi * y / (25 * NM))), (size, size))


@pytest.mark.parametrize("edges", ["mirror", "window"])
def test_a_wall_is_the_map_turned_over_and_made_periodic(edges):
    n, a0 = 32, 0.3 * NM
    wall = wall_from_map(waves(), n, a0, edges, (0.5, 0.4))
    assert wall.heights.shape == (n, n)
    assert wall.lengths == pytest.approx((n * a0, n * a0))
    assert wall.periodic
    assert len(wall.steps) >= 5
    assert wall.steps[-1].startswith("turned over")
    # Continuous across the period: no step larger than those inside.
    steps = np.abs(np.diff(np.concatenate([wall.heights, wall.heights[:1]]), axis=0)).max(axis=1)
    assert steps[-1] <= steps[:-1].max() * (1 + 1e-9)
    assert abs(wall.heights.mean()) < 1e-12 * np.abs(wall.heights).max()


def test_the_sampled_heights_are_those_of_the_map():
    n, a0, centre = 32, 0.3 * NM, (0.5, 0.4)
    wall = wall_from_map(waves(), n, a0, "mirror", centre)
    x, y = (c * 50 * NM + (np.arange(16) + 0.5 - 8) * a0 for c in centre)
    exact = NM * (np.sin(2 * np.pi * x / (20 * NM))[:, None] + np.cos(2 * np.pi * y / (25 * NM)))
    found = -wall.heights[:16, :16]
    # Cubic splines through 40 points a wave err by (2 pi/40)^4/384 = 2e-6; the plane is taken off both.
    for axis in (0, 1):
        k = np.arange(16) - 7.5
        slope = (np.expand_dims(k, 1 - axis) * exact).sum() / (16 * (k**2).sum())
        exact = exact - slope * np.expand_dims(k, 1 - axis)
    assert found == pytest.approx(exact - exact.mean(), abs=1e-5 * NM)


@pytest.mark.parametrize(
    ("n", "spacing", "edges", "centre", "message"),
    [
        (32, 3 * NM, "window", (0.5, 0.5), "does not lie within the map"),
        (32, 0.3 * NM, "window", (0.02, 0.5), "does not lie within the map"),
        (32, 0.05 * NM, "window", (0.5, 0.5), "fewer than 4 pixels of 500 pm"),
        (31, 0.3 * NM, "mirror", (0.5, 0.5), "even number"),
    ],
)
def test_a_part_that_is_not_there_is_refused(n, spacing, edges, centre, message):
    with pytest.raises(TopographyError, match=message):
        wall_from_map(waves(), n, spacing, edges, centre)
