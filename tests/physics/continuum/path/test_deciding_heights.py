"""The derivative of w_DMT by every height, from the state that w_DMT is from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy

from continuum.measure.contact import area_by_lines
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates.isotropic import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.threshold import press_without_adhesion
from continuum.solve.solution import Settings


def test_w_dmt_changes_as_its_derivative_says_and_a_shift_of_all_heights_does_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Against differences of states next to it, with as much area along the lines of the grid."""
    monkeypatch.setattr("continuum.path.threshold.ACCURACY", 1e-9)
    grid, stiffness = Grid.square(64), 5.0
    heights = -SelfAffine(0.8, 0.1, 16.0, 32.0).synthesise(grid, np.random.default_rng(1))
    wall = attraction_on_core("spline", 1e-6, 0.6, stiffness)
    problem = ContactProblem(grid, wall, heights, HalfSpace(mean="clamped"))
    state = press_without_adhesion(problem, 0.05, Settings(1e-6), stiffness)
    # A little farther: the next point to touch is at a distance of zero, where the area has a kink.
    state = replace(state, distance=state.distance + 1e-3 * state.opening)
    found = state.deciding_heights(wall)
    assert abs(found.sum()) < 1e-7 * np.abs(found).sum()
    area = area_by_lines(state.distance)[0]
    x, y = grid.positions
    acting = 0.7 * state.dmt(lambda _: wall)
    by_load = state.load_by_heights(wall, acting)
    assert abs(by_load.sum()) < 1e-7 * np.abs(by_load).sum()

    def numbers(change: np.ndarray) -> np.ndarray:
        """w_DMT, and the load under a part of it."""
        moved = state.distance + state.core.response(change)

        def excess(lift: float) -> float:
            return area_by_lines(moved + lift * state.opening)[0] - area

        lift = scipy.optimize.brentq(excess, -0.05, 0.05, xtol=1e-14)
        distance = moved + lift * state.opening
        load = -stiffness * grid.mean(np.where(state.contact, distance, 0.0))
        apart = np.where(state.contact, wall.range * 10, np.maximum(distance, 0.0))
        pull = -wall.evaluate(wall.zero_gap + apart).traction / wall.work_of_adhesion
        return np.array([load / grid.mean(pull), load - acting * grid.mean(pull)])

    for along_x, along_y in ((1, 0), (2, 1), (0, 3)):
        wave = np.cos(2 * np.pi * (along_x * x + along_y * y) / 64 + 1)
        step = 1e-6
        by_work, by_area = (numbers(step * wave) - numbers(-step * wave)) / (2 * step)
        assert (found * wave).sum() == pytest.approx(by_work, rel=1e-3), (along_x, along_y)
        assert (by_load * wave).sum() == pytest.approx(by_area, rel=1e-3), (along_x, along_y)
