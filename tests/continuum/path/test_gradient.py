"""Derivatives by all heights against finite differences, under every law, on every substrate and under every control.

Central differences of fourth order in a random direction of the heights: at a step of 2e-5 their error is below 1e-8,
and that of loads and areas, solved to 1e-13 E*, about 1e-13/2e-5 of a derivative of order one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

import continuum as c
from continuum.arguments import ArgumentError
from continuum.measure.contact import area_by_lines
from continuum.model.cubic import CubicConstants
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import (
    CubicLayer,
    HalfSpace,
    Layer,
    LayeredHalfSpace,
    NonPeriodicHalfSpace,
    Substrate,
    TabulatedSubstrate,
)
from continuum.model.surface import SelfAffine
from continuum.model.walls import (
    HardWall,
    InversePowers,
    LennardJonesSpline,
    TabulatedWall,
    Wall,
    attraction_on_core,
)
from continuum.path.gradient import Given, Tangent, dmt_gradient, largest_tension, threshold_gradient
from continuum.path.loading import solve
from continuum.path.state import PathState, nearness
from continuum.path.turn import WallOfWork
from continuum.solve.solution import NotConvergedError, Settings
from continuum.solve.tangent import tangent_stiffness

TIGHT = Settings(1e-13)
TOLERANCE = 1e-6
"""What the issue asks for."""
STEP = 2e-5
GRID, LINE = Grid((15, 16), (15.0, 16.0)), Grid((1, 33), (1.0, 33.0))
WORK = 0.005


def _table(work: float) -> Wall:
    gap = np.linspace(0.7, 1.4, 41)
    return TabulatedWall(gap, LennardJonesSpline(0.4, minimum_stiffness=12 * work / 0.4**2).evaluate(gap).traction)


LAWS: dict[str, WallOfWork] = {
    "the paper's": lambda work: LennardJonesSpline(adhesion_length=work),
    "9-3": lambda work: InversePowers((9, 3), adhesion_length=work, core=0.5),
    "table": _table,
    "exponential on a core": partial(attraction_on_core, "exponential", effective_range=0.3, core_stiffness=5.0),
    "spline on a core": partial(attraction_on_core, "spline", effective_range=0.3, core_stiffness=5.0),
}
SUBSTRATES: dict[str, Callable[[Grid], Substrate]] = {
    "half-space": lambda grid: HalfSpace("clamped"),
    "half-space, free": lambda grid: HalfSpace("free"),
    "layer": lambda grid: Layer(5.0, 0.3, 0.4),
    "layered": lambda grid: LayeredHalfSpace([(1.0, 3.0, 0.3)], (1.0, 0.4), 0.2),
    "crystal": lambda grid: CubicLayer(4.0, CubicConstants(1.2, 0.6, 0.5), 0.3),
    "table": lambda grid: TabulatedSubstrate(0.3 + 0.5 * grid.wavenumber, grid.lengths, "test"),
    "no images": lambda grid: NonPeriodicHalfSpace(),
}


class Place:
    """An equilibrium, and those next to it along a direction of the heights."""

    def __init__(self, wall_of: WallOfWork, substrate: Substrate, grid: Grid = GRID, near: float = 0.1) -> None:
        rng = np.random.default_rng(4)
        heights = SelfAffine(0.8, 0.1, 5.0, grid.lengths[1]).synthesise(grid, rng)
        self.wall_of, self.substrate, self.heights = wall_of, substrate, heights
        self.along = rng.standard_normal(grid.shape)
        self.problem = ContactProblem(grid, wall_of(WORK), heights, substrate)
        self.near = self.problem.wall.zero_gap + near
        self.state = solve(self.problem, nearness(self.problem), self.near, TIGHT)
        self.state.require()

    def at(self, by_heights: float, by_nearness: float, by_work: float) -> Real:
        """Load, area, and separation of a neighbour."""
        heights = self.heights + by_heights * self.along
        problem = replace(self.problem, heights=heights, wall=self.wall_of(WORK * (1 + by_work)))
        state = solve(problem, nearness(problem), self.near + by_nearness, TIGHT, self.state.gap)
        state.require()
        area, _ = area_by_lines(state.gap - problem.wall.zero_gap, periodic=problem.open_boundary is None)
        return np.array([state.load, area, state.separation])

    def changes(self, by_heights: float, by_nearness: float, by_work: float) -> Real:
        """Derivatives of load, area and separation along a direction, by central differences of fourth order."""
        near, far = (
            self.at(step * by_heights, step * by_nearness, step * by_work)
            - self.at(-step * by_heights, -step * by_nearness, -step * by_work)
            for step in (STEP, 2 * STEP)
        )
        found: Real = (8 * near - far) / (12 * STEP)
        return found


@cache
def place(law: str, substrate: str) -> Place:
    return Place(LAWS[law], SUBSTRATES[substrate](GRID))


@pytest.mark.parametrize("substrate", SUBSTRATES)
@pytest.mark.parametrize("law", LAWS)
def test_load_and_area_change_as_their_derivatives_say(law: str, substrate: str) -> None:
    here = place(law, substrate)
    tangent = Tangent(here.problem, here.state.gap, here.wall_of)
    directions = {"heights": (1.0, 0.0, 0.0), "nearness": (0.0, 1.0, 0.0), "work": (0.0, 0.0, 1.0)}
    seen = {name: here.changes(*direction) for name, direction in directions.items()}
    for number, one in enumerate((tangent.load, tangent.area)):
        said = {"heights": (one.heights * here.along).sum(), "nearness": one.nearness, "work": one.work * WORK}
        for name, expected in said.items():
            assert seen[name][number] == pytest.approx(expected, rel=TOLERANCE), (number, name)
