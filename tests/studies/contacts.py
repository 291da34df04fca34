"""Rough contacts at given repulsive areas, measured: what the studies of geometry share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from continuum.measure.contact import REPULSIVE, Measurement, contact_map, measure
from continuum.measure.outline import Mask
from continuum.model.grid import Grid, Real
from continuum.model.surface import Moments, moments
from continuum.path.loading import Search, follow
from continuum.solve.solution import Settings
from continuum.theory.paper import contact_diameter
from tests.problems import Rough


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
    problem = rough.problem()
    grid, wall, m = problem.grid, problem.wall, moments(problem.grid, problem.heights)
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
