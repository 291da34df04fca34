"""Rough contacts at given repulsive areas, measured: what the studies of geometry share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from continuum.measure.contact import REPULSIVE, Measurement, contact_map, measure
from continuum.measure.outline import Mask
from continuum.model.grid import Grid, Real
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import Moments, SelfAffine, moments
from continuum.model.walls import HardWall, LennardJonesSpline, Wall
from continuum.path.loading import Search, follow
from continuum.solve.smooth import Settings
from continuum.theory.paper import contact_diameter


@dataclass(frozen=True)
class Rough:
    """One realisation of a surface under one wall."""

    n: int
    lambda_s: float
    adhesion_length: float = 0.0
    hurst: float = 0.8
    slope: float = 0.1
    seed: int = 1
    hard: bool = False
    lambda_L: float | None = None

    @property
    def wall(self) -> Wall:
        return HardWall() if self.hard else LennardJonesSpline(adhesion_length=self.adhesion_length)


@dataclass(frozen=True, eq=False)
class RoughContact:
    """A contact of such a surface."""

    rough: Rough
    grid: Grid
    moments: Moments
    gap: Real
    repulsive: Mask
    numbers: Measurement

    @property
    def expected_diameter(self) -> float:
        return contact_diameter(self.moments.rms_slope, self.moments.rms_curvature)


def contacts(rough: Rough, areas: Sequence[float], within: float = 0.05) -> Iterator[RoughContact]:
    """Contacts of one surface at given repulsive areas, increasing, on approach, within a relative tolerance.

    Where the contact jumps over an area, the state after the jump is taken.
    """
    grid = Grid.square(rough.n)
    spectrum = SelfAffine(rough.hurst, rough.slope, rough.lambda_s, rough.lambda_L or rough.n / 2)
    heights = spectrum.synthesise(grid, np.random.default_rng(rough.seed))
    m, wall = moments(grid, heights), rough.wall
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    settings = Settings(1e-6 * m.rms_slope)
    for state in follow(problem, "repulsive-area", areas, settings, search=Search(area_tolerance=within)):
        found = state
        if state.beyond is not None:
            found = state.beyond
        else:
            state.solution.require()
        repulsive = contact_map(wall, found.gap) == REPULSIVE
        numbers = measure(grid, found.totals, repulsive, m.rms_slope)
        yield RoughContact(rough, grid, m, found.gap, repulsive, numbers)
