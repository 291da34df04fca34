"""Solve for the turn of a measured map: the work of adhesion above which its contact is sticky.

This does not need the state at the given work of adhesion, which costs many times more far from the turn, where the
surface snaps.  The wall is that of :mod:`continuum.sticky.simulate`.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from continuum.arguments import instance
from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.model.problem import ContactProblem
from continuum.model.surface import moments
from continuum.model.walls import Wall
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.state import Search
from continuum.path.turn import find_turn, first_work
from continuum.solve.solution import NotConvergedError, Settings, Solution
from continuum.solve.solver import Solver
from continuum.sticky.criteria import AREA
from continuum.sticky.materials import Interface
from continuum.sticky.simulate import (
    SolvedMap,
    check_resolved,
    in_place_of,
    shortest_range,
    solver_doubts,
    wall_of_map,
    wall_on,
)
from continuum.theory.rough import turning_share
from continuum.topography.map import Topography

WIDTH = 0.1
"""Width of the bracket of the turn, relative to it.  The load is interpolated within it: on maps whose pixels snap,
works found with a bracket of 0.02 differed by 3 to 12 % and took two to four times as long."""
AREA_TOLERANCE = 0.03
"""Largest difference of the area from 1 %, relative to it: w at the turn moves by a few tenths of that."""
RESIDUAL = 1e-4
"""Residual, relative to h' E*: ten times that of a state, as no areas are evaluated."""
PAIRS, PAIRS_PER_SIDE = 300.0, 8.0
"""FFT pairs for a turn if the pixels resolve the range, and per point along a side if they do not: 120 to 400, and 7
to 17, on synthetic maps of 64² to 256² points and their mirror images."""
PATIENCE = 10.0
"""Factor to these pairs after which a turn that is solved by default is given up: worn maps took up to 40 times as
many."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SolvedTurn(SolvedMap):
    """The work at which the load at 1 % repulsive area vanishes, in the units of the interface."""

    work: float
    """w at the turn, above which the surface is sticky."""
    low: float
    """Largest w that was found not sticky."""
    high: float
    """Smallest w that was found sticky."""
    jumps: bool
    """Whether the load jumps over zero at the turn, as the surface snaps."""
    range: float
    """Effective range with which it was solved."""
    most: float
    """w at the turn with the range of the interface, by the law of the turn; equal to ``work`` if that range was
    solved."""
    area_rep: float
    """Repulsive area of the state nearest to the turn, as a fraction of A0."""
    area_att: float
    """Attracted area of that state."""

    @property
    def coarse(self) -> bool:
        """Whether the pixels do not resolve the range of the interface."""
        return self.most > self.work * (1 + 1e-9)

    def sticky(self, work: float) -> bool | None:
        """Whether a work of adhesion is sticky; None if the range that was solved leaves it open."""
        return None if self.work < work <= self.most else work > self.work


def expected_pairs(size: int, *, resolved: bool) -> float:
    """Expected FFT pairs for the turn of a map on a grid of this many points, to a factor of three.

    The range is ``resolved`` if the pixels resolve that of the interface at the turn.
    """
    return PAIRS if resolved else max(PAIRS, PAIRS_PER_SIDE * size**0.5)


class _Patient(Solver):
    """A solver that gives up after a number of FFT pairs, which is the same on every machine."""

    def __init__(self, problem: ContactProblem, threads: int, pairs: float) -> None:
        super().__init__(problem.grid, problem.stiffness_q, threads)
        self._most = self._left = pairs

    def minimise(self, law: Law, offset: Real, start: Real | None, settings: Settings, **posed: Any) -> Solution:
        """Minimise with the iterations that are left."""
        if self._left < 1:
            raise NotConvergedError(
                f"it was not found within {self._most:.0f} pairs of transforms, {PATIENCE:g} times what most maps of "
                "this size take; where solving is asked for there is no such limit"
            )
        most = int(min(settings.max_iterations, self._left))
        found = super().minimise(law, offset, start, replace(settings, max_iterations=most), **posed)
        self._left -= found.fft_pairs
        return found


def solve_turn(topography: Topography, interface: Interface, threads: int = 1, *, limited: bool = False) -> SolvedTurn:
    """The work of adhesion at which the load on a map at 1 % repulsive area changes its sign.

    The range of attraction is that of the interface, or the shortest that the pixels resolve at that work if it is
    longer.  A longer range turns at less work, by a factor that the law of the turn estimates
    (:func:`continuum.theory.rough.turning_share`, docs/law.md).  The turn also depends on the pixels: with pixels four
    times finer it changed by a factor of up to 1.8 on eight surfaces.

    Parameters
    ----------
    topography, threads : as for :func:`continuum.sticky.simulate.simulate`.
    interface : E* and Δr; its w is not used.
    limited : whether it is given up after :data:`PATIENCE` times the expected FFT pairs.

    Raises continuum.sticky.simulate.UnresolvedError if the shortest range that the pixels resolve exceeds the rms
    height; continuum.solve.solution.NotConvergedError if no turn is found, or not within the limit.
    """
    instance("interface", interface, Interface)
    given, modulus = interface.range, interface.contact_modulus
    unit = max(instance("topography", topography, Topography).grid.spacing)
    grid, heights = wall_of_map(topography, unit)
    slope = moments(grid, heights).rms_slope

    def range_at(length: float) -> float:
        """Range in m at a given l_a in units of the grid."""
        return max(given, shortest_range(topography, length * unit))

    def wall_at(length: float) -> Wall:
        return wall_on(grid, length, range_at(length) / unit)

    substrate = interface.substrate(unit)
    hard = attraction_on_core("spline", 1.0, 1.0, 1.0)
    first = first_work(ContactProblem(grid, hard, heights, substrate))  # half of the energy of full contact
    problem = ContactProblem(grid, wall_at(first), heights, substrate)
    settings = Settings(RESIDUAL * slope, threads=threads)
    pairs = PATIENCE * expected_pairs(grid.size, resolved=range_at(first) == given) if limited else np.inf
    solver = _Patient(problem, threads, pairs)
    found, state = find_turn(problem, wall_at, AREA, settings, Search(AREA_TOLERANCE), WIDTH, solver)
    turn = state.turn
    if turn is None:
        raise NotConvergedError(state.status.value)
    length = turn.root
    reach = range_at(length)
    doubts = []
    if reach > given:
        check_resolved(topography, reach)
        doubts = [f"the turn is that of {in_place_of(reach, given)}"]
    height = float(topography.heights.std())
    share = turning_share(given / height) / turning_share(reach / height)
    return SolvedTurn(
        work=length * unit * modulus,
        low=turn.before.value * unit * modulus,
        high=turn.after.value * unit * modulus,
        jumps=turn.kind == "jump-in",
        range=reach,
        most=share * length * unit * modulus,
        area_rep=state.totals.area_rep,
        area_att=state.totals.area_att,
        gap=state.gap,
        wall=found.wall,
        grid=grid,
        map=topography.grid,
        warnings=(*doubts, *solver_doubts(found, slope, topography, "the pixel")),
    )
