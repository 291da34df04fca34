"""Solve the contact of a measured map: load and areas at 1 % repulsive area.

Reduced units with a0 = Δr.  The wall has the attraction of the paper's law, with the given work of adhesion and
effective range, on a core that is stiff compared with the elastic response of one pixel.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from continuum import units
from continuum.arguments import instance
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.resolution import unresolved
from continuum.model.surface import moments
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.loading import solve
from continuum.path.state import Outcome
from continuum.solve.solution import NotConvergedError, Settings
from continuum.sticky.criteria import AREA
from continuum.sticky.materials import Interface
from continuum.topography.map import Topography, mirror

SNAPPING, SAFE = 1.0, 2.0
"""Shortest wavelength that may snap, in pixels, for a contact to be solved directly, and in the limit solved
instead."""
CORE_STIFFNESS = 5.0
"""Stiffness of the wall's core, in E* per pixel."""
TOLERANCE = 1e-5
"""Residual, relative to h' E*."""


class UnresolvedError(ValueError):
    """The map is too coarse for a solution: the message has the reason."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SolvedMap:
    """A state that was solved on a map, with its grids."""

    gap: Real = field(repr=False)
    """Gap over ``grid``, in its unit."""
    wall: Wall = field(repr=False)
    grid: Grid = field(repr=False)
    """Grid of the map and its mirror images, in the unit of the solver."""
    map: Grid = field(repr=False)
    """Grid of the map itself, whose points are the first of ``grid`` in each direction; in units of the interface."""
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Simulation(SolvedMap):
    """Solution on approach.  Loads per area, in the units of the interface."""

    area_rep: float
    """Repulsive area: 1 % within tolerance, or where the surface jumped to."""
    area_ratio: float
    """A_rep/A_att."""
    load: float
    """Load per area at that area; negative: sticky."""
    kappa: float
    """h' E* A_rep/N."""
    jumped: bool
    """Whether the area jumped past 1 %."""

    @property
    def sticky(self) -> bool:
        """Negative load at 1 % repulsive area on approach."""
        return self.load < 0


def resolvable(topography: Topography, interface: Interface) -> tuple[Interface, str]:
    """The interface that can be solved on a map, and a description of how it differs; "" if it does not.

    On soft solids adhesion may act within less than a pixel.  Contacts are then in the limit of Johnson, Kendall and
    Roberts, which depends on w but not on the range, so that the shortest range is taken that the grid resolves.

    Raises UnresolvedError if that exceeds the rms height of the map, so that attraction would act far beyond the
    contacts.
    """
    instance("interface", interface, Interface)
    shortest = shortest_range(instance("topography", topography, Topography), interface.adhesion_length)
    if interface.range >= shortest * np.sqrt(SNAPPING / SAFE):
        return interface, ""
    check_resolved(topography, shortest)
    return replace(interface, range=shortest), (f"solved instead: {in_place_of(shortest, interface.range)}")


def shortest_range(topography: Topography, adhesion_length: float) -> float:
    """The shortest effective range that the pixels resolve at a given l_a = w/E*; both in the unit of the map.

    Flats under the paper's law of reach r snap above π E*/softening = (π/4) r²/l_a, which is two pixels here.
    """
    pixel = max(topography.grid.spacing)
    return LennardJonesSpline(1.0).effective_range * float(np.sqrt(4 / np.pi * SAFE * pixel * adhesion_length))


def check_resolved(topography: Topography, shortest: float) -> None:
    """Raise UnresolvedError where the shortest range that the pixels resolve exceeds the rms height of the map."""
    if shortest > (height := float(topography.heights.std())):
        pixel, needed, rms = (
            units.readable(value, "length", 3) for value in (max(topography.grid.spacing), shortest, height)
        )
        raise UnresolvedError(
            f"the map is too coarse for adhesion so strong and so short-ranged: pixels of {pixel} resolve ranges above "
            f"{needed}, more than its rms height of {rms}"
        )


def in_place_of(shortest: float, given: float) -> str:
    """Description of what is solved if a range in m is too short for the pixels."""
    needed, short = (units.readable(value, "length", 3) for value in (shortest, given))
    return (
        f"the limit of Johnson, Kendall and Roberts: the same w with a range of {needed}, the shortest "
        f"that the pixels resolve, in place of {short}"
    )


def wall_of_map(topography: Topography, unit: float) -> tuple[Grid, Real]:
    """Grid and wall heights of a map, which is continued by its mirror images unless it is periodic.

    Both are in a unit of length in m; the mean height is zero.
    """
    closed = topography if topography.periodic else mirror(topography)
    grid = Grid(closed.grid.shape, (closed.lengths[0] / unit, closed.lengths[1] / unit))
    return grid, -(closed.heights - closed.heights.mean()) / unit


def wall_on(grid: Grid, adhesion_length: float, reach: float) -> Wall:
    """The wall of a given l_a = w/E* and effective range, with a core for these pixels; in the unit of the grid."""
    return attraction_on_core("spline", adhesion_length, reach, CORE_STIFFNESS / max(grid.spacing))


def solver_doubts(problem: ContactProblem, slope: float, topography: Topography, unit: str) -> list[str]:
    """Warnings about a solution on a map: what its pixels do not resolve, and how the map was continued.

    The text ``unit`` describes a0.
    """
    doubts = [f"solver, a0 being {unit} and the grid that of the map: {text}" for text in unresolved(problem, slope)]
    return doubts + ([] if topography.periodic else ["solved on the map and its mirror images"])


def simulate(topography: Topography, interface: Interface, threads: int = 1) -> Simulation:
    """Approach a rigid wall of the topography to an elastic half-space, up to 1 % repulsive area.

    Parameters
    ----------
    topography : detrended; two bodies are first put :func:`continuum.topography.map.opposed`.  It is continued by its
        mirror images if it is not periodic.
    interface : E*, w and Δr.
    threads : threads of the solver.

    Raises UnresolvedError if the adhesion acts within less than a pixel; continuum.solve.solution.NotConvergedError if
    no equilibrium is found.
    """
    interface, instead = resolvable(topography, interface)
    unit, modulus = interface.range, interface.contact_modulus
    grid, heights = wall_of_map(topography, unit)
    slope = moments(grid, heights).rms_slope
    wall = wall_on(grid, interface.adhesion_length / unit, 1.0)
    problem = ContactProblem(grid, wall, heights, interface.substrate(unit))
    settings = Settings(TOLERANCE * slope, threads=threads)
    state = solve(problem, "repulsive-area", AREA, settings, branch="approach")
    jumped = state.outcome is Outcome.JUMPED_OVER and state.beyond is not None
    if state.beyond is not None and jumped:
        state = state.beyond
    if not state.status.ok:
        raise NotConvergedError(state.status.value)
    contact = state.totals
    doubts = [*([instead] if instead else []), *solver_doubts(problem, slope, topography, "Δr")]
    return Simulation(
        area_rep=contact.area_rep,
        area_ratio=contact.area_rep / contact.area_att if contact.area_att else np.inf,
        load=contact.load * modulus,
        kappa=slope * contact.area_rep / contact.load if contact.load else np.inf,
        jumped=jumped,
        gap=state.gap,
        wall=wall,
        grid=grid,
        map=topography.grid,
        warnings=tuple(doubts),
    )
