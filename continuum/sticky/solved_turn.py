"""The turn of a measured map, solved: the work of adhesion from which on its contact is sticky.

The state at the given work of adhesion need not be known for that: it costs many times more where the surface is far
from the turn, as there it snaps.  The wall is that of :mod:`continuum.sticky.simulate`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from continuum.arguments import instance
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import Substrate
from continuum.model.surface import moments
from continuum.model.walls import Wall
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.state import PathState, Search
from continuum.path.turn import find_turn, first_work
from continuum.solve.solution import NotConvergedError, Settings
from continuum.sticky.criteria import AREA
from continuum.sticky.materials import Interface
from continuum.sticky.simulate import (
    CORE_DEPTH,
    CORE_STIFFNESS,
    check_resolved,
    in_place_of,
    shortest_range,
    solver_doubts,
    wall_of_map,
)
from continuum.theory.rough import turning_share
from continuum.topography.map import Topography

WIDTH = 0.1
"""Width of the bracket of the turn, relative to it.  The load is interpolated within it: on maps whose pixels snap the
works found with a bracket of 0.02 differed by 3 to 12 %, by the pixels that snapped, and took two to four times as
long."""
AREA_TOLERANCE = 0.03
"""Largest difference of the area from 1 %, relative to it: w at the turn moves by a few tenths of that."""
RESIDUAL = 1e-4
"""Residual, relative to h' E*: ten times that of a state, as no areas are read off."""


@dataclass(frozen=True, eq=False)
class SolvedTurn:
    """Where the load at 1 % repulsive area vanishes.  Works per area and lengths in the units of the interface."""

    work: float
    """w at the turn: at more the surface is sticky."""
    low: float
    """Largest w that was found not sticky."""
    high: float
    """Smallest w that was found sticky."""
    jumps: bool
    """Whether the load jumps over zero there, as the surface snaps."""
    range: float
    """Effective range with which it was solved."""
    most: float
    """w at which it turns with the range of the interface, by the law of the turn; ``work`` where that was solved."""
    area_rep: float
    """Repulsive area of the state nearest to the turn, as a fraction of A0."""
    area_att: float
    """Attracted area of that state."""
    gap: Real = field(repr=False)
    """Gap of that state, over ``grid``, in its unit."""
    wall: Wall = field(repr=False)
    grid: Grid = field(repr=False)
    shape: tuple[int, int]
    """Points of the map itself, the first of the grid's in each direction."""
    lengths: tuple[float, float]
    """Size of the map itself."""
    warnings: tuple[str, ...]

    @property
    def coarse(self) -> bool:
        """Whether the pixels do not resolve the range of the interface."""
        return self.most > self.work * (1 + 1e-9)

    def sticky(self, work: float) -> bool | None:
        """Whether a work of adhesion is sticky; None where the range that was solved leaves it open."""
        return None if self.work < work <= self.most else work > self.work


def solve_turn(topography: Topography, interface: Interface, threads: int = 1) -> SolvedTurn:
    """The work of adhesion at which the load on a map at 1 % repulsive area changes its sign.

    The range of attraction is that of the interface, or the shortest that the pixels resolve at that work if it is
    longer.  A longer range turns at less work: by how much, the law of the turn estimates
    (:func:`continuum.theory.rough.turning_share`, docs/law.md).  The pixels move the turn, too: those four times finer
    by up to 1.8, of eight surfaces.

    Parameters
    ----------
    topography, threads : as for :func:`continuum.sticky.simulate.simulate`.
    interface : E* and Δr; its w has no part in this.

    Raises
    ------
    continuum.sticky.simulate.UnresolvedError
        If the shortest range that the pixels resolve exceeds the rms height.
    continuum.solve.solution.NotConvergedError
        If no turn is found.
    """
    instance("interface", interface, Interface)
    given, modulus = interface.range, interface.contact_modulus
    unit = max(instance("topography", topography, Topography).grid.spacing)
    grid, heights = wall_of_map(topography, unit)
    pixel, slope = max(grid.spacing), moments(grid, heights).rms_slope

    def range_at(length: float) -> float:
        """In m, at l_a in units of the grid."""
        return max(given, shortest_range(topography, length * unit))

    def wall_at(length: float) -> Wall:
        stiffness, depth = CORE_STIFFNESS / pixel, CORE_DEPTH * pixel
        return attraction_on_core("spline", length, range_at(length) / unit, stiffness, depth)

    substrate = interface.substrate(unit)
    problem = ContactProblem(grid, wall_at(_half_of_full_contact(grid, heights, substrate)), heights, substrate)
    settings = Settings(RESIDUAL * slope, threads=threads)
    found, state = find_turn(problem, wall_at, AREA, settings, Search(AREA_TOLERANCE), WIDTH)
    length, low, high, jumps = _bracket(state)
    reach = range_at(length)
    doubts = []
    if reach > given:
        check_resolved(topography, reach)
        doubts = [f"the turn is that of {in_place_of(reach, given)}"]
    height = float(topography.heights.std())
    share = turning_share(given / height) / turning_share(reach / height)
    return SolvedTurn(
        length * unit * modulus, low * unit * modulus, high * unit * modulus, jumps, reach,
        share * length * unit * modulus, state.totals.area_rep, state.totals.area_att, state.gap, found.wall, grid,
        topography.grid.shape, topography.lengths, (*doubts, *solver_doubts(found, slope, topography, "the pixel")),
    )  # fmt: skip


def _half_of_full_contact(grid: Grid, heights: Real, substrate: Substrate) -> float:
    """l_a from which the search begins, half of the energy of full contact."""
    hard = attraction_on_core("spline", 1.0, 1.0, 1.0)
    return first_work(ContactProblem(grid, hard, heights, substrate))


def _bracket(state: PathState) -> tuple[float, float, float, bool]:
    """l_a at the turn, below and above it, and whether the load jumps there; NotConvergedError where none was found."""
    turns = [event for event in state.events if event.control == "work-of-adhesion"]
    if not turns:
        raise NotConvergedError(state.status.value)
    before, after = turns[0].before, turns[0].after
    share = before.load / (before.load - after.load) if before.load > 0 > after.load else 0.5
    work = before.value * (after.value / before.value) ** float(np.clip(share, 0.0, 1.0))
    return work, before.value, after.value, turns[0].kind == "jump-in"
