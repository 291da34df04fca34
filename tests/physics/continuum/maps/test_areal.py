"""Areal parameters of maps for which the standard's definitions can be worked out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.maps.faults import directions
from continuum.maps.map import Topography
from continuum.maps.roughness import areal_parameters, stencil_moments


@given(st.floats(0.01, 3.0), st.floats(0.01, 3.0), st.floats(1e-9, 1e3))
def test_an_inclined_plane(along_x: float, along_y: float, unit: float) -> None:
    """Heights spread evenly along x alone have Sa = √3/2 Sq and Sku = 9/5; a plane has one slope."""
    x, y = np.meshgrid(np.arange(200.0), np.arange(40.0), indexing="ij")
    found = areal_parameters(Topography(unit * (along_x * x + along_y * y), (unit * 200, unit * 40)))
    assert found.Sdq == pytest.approx(np.hypot(along_x, along_y))
    assert found.Sdr == pytest.approx(np.sqrt(1 + along_x**2 + along_y**2) - 1)
    assert found.Sz == pytest.approx(unit * (199 * along_x + 39 * along_y))
    assert found.Ssk == pytest.approx(0, abs=1e-9)
    only = areal_parameters(Topography(unit * along_x * x, (unit * 200, unit * 40)))
    assert (only.Sa / only.Sq, only.Sku) == pytest.approx((np.sqrt(3) / 2, 1.8), rel=1e-3)


def test_a_wave() -> None:
    """A wave has Sa = √8/π Sq, Sku = 3/2, and for small slopes Sdr = Sdq²/2."""
    x = 2 * np.pi * np.arange(256) / 256
    found = areal_parameters(Topography(0.01 * np.cos(4 * x)[:, None] * np.ones(32), (2 * np.pi, np.pi / 4)))
    assert (found.Sa / found.Sq, found.Sku, found.Sdr / found.Sdq**2) == pytest.approx(
        (np.sqrt(8) / np.pi, 1.5, 0.5), rel=1e-3
    )
    assert found.Sdq == pytest.approx(0.04 / np.sqrt(2), rel=5e-3)  # differences of neighbours lose a part


def test_a_map_is_looked_at_a_few_rows_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many: one part, parts of the fewest rows, and a last one that is shorter tell the same."""
    heights = np.random.default_rng(0).normal(size=(67, 16)).cumsum(0)
    found = []
    for part in (1, 16 * 5, 16 * 66, 10**6):
        monkeypatch.setattr("continuum.maps.map._PART", part)
        one = Topography(heights, (67.0, 32.0))
        by = directions(one)
        moments = stencil_moments(one.grid, heights, periodic=True)
        found.append([*areal_parameters(one), *by.slopes, *by.curvatures, by.anisotropy, by.angle, *moments])
    assert np.diff(heights, axis=0).std() == pytest.approx(by.slopes[0], rel=0.1)
    for other in found[:-1]:
        assert other == pytest.approx(found[-1], rel=1e-9, abs=1e-12)
