"""A measured map on the grid of the solver: heights, law of attraction, and what its pixels resolve.

The wall has the attraction of the paper's law, with work of adhesion and effective range apart, on a core that is stiff
compared with the elastic response of one pixel.
"""

import numpy as np

from continuum.inputs import units
from continuum.maps.map import Topography, mirrored, mirrored_spectrum
from continuum.model.fourier import Real, padded, restrict
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem, Wording, unresolved
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.model.walls.attraction import attraction_on_core

SAFE = 2.0
"""Shortest wavelength that may snap, in pixels."""
CORE_STIFFNESS = 5.0
"""Stiffness of the wall's core, in E* per pixel."""


class UnresolvedError(ValueError):
    """The map is too coarse for a solution: the message has the reason."""


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
            f"the map is too coarse for this strong and short-ranged adhesion: pixels of {pixel} resolve only ranges "
            f"above {needed}, which exceeds the rms height, {rms}"
        )


def in_place_of(shortest: float, given: float) -> str:
    """Description of what is solved if a range in m is too short for the pixels."""
    needed, short = (units.readable(value, "length", 3) for value in (shortest, given))
    return (
        f"the limit of Johnson, Kendall and Roberts: the same w with a range of {needed}, the shortest "
        f"that the pixels resolve, in place of {short}"
    )


def wall_of_map(topography: Topography, unit: float, most: int | None = None) -> tuple[Grid, Real]:
    """Grid and wall heights of a map, which is continued by its mirror images unless it is periodic.

    Both are in a unit of length in m; the mean height is zero.  If the grid has more than so many points, the heights
    are the waves that a coarser one carries.
    """
    images, own = 1 if topography.periodic else 2, topography.grid
    grid = Grid((images * own.shape[0], images * own.shape[1]),
                (images * own.lengths[0] / unit, images * own.lengths[1] / unit))  # fmt: skip
    coarse = grid if most is None else at_most(grid, most)
    heights = -(topography.heights - topography.heights.mean()) / unit
    if images == 2 and coarse is not grid:
        return coarse, coarse.inverse(mirrored_spectrum(heights, coarse))
    return coarse, waves_on(coarse, grid, mirrored(heights) if images == 2 else heights)


def at_most(grid: Grid, most: int) -> Grid:
    """The grid, or a coarser one of at most so many points."""
    while grid.size > most and grid.coarser is not None:
        grid = grid.coarser
    return grid


def waves_on(coarse: Grid, grid: Grid, heights: Real) -> Real:
    """The waves of some heights that a coarser grid carries; the heights themselves if it is the same grid."""
    if coarse is grid:
        return heights
    heights_q = padded(coarse.shape_q, np.complex128)
    restrict(grid.forward(heights), heights_q)
    return coarse.inverse(heights_q)


def wall_on(grid: Grid, adhesion_length: float, reach: float) -> Wall:
    """The wall of a given l_a = w/E* and effective range, with a core for these pixels; in the unit of the grid."""
    return attraction_on_core("spline", adhesion_length, reach, CORE_STIFFNESS / max(grid.spacing))


def solver_doubts(problem: ContactProblem, slope: float, topography: Topography, unit: float) -> list[str]:
    """Warnings about a solution on a map: what its pixels do not resolve, and how the map was continued.

    The unit of the problem is in that of the map.
    """
    words = Wording(
        lambda value: units.readable(value * unit, "length", 3), "pixels", "measure with smaller pixels",
        "remove short waves with --cutoff",
    )  # fmt: skip
    doubts = list(unresolved(problem, slope, words=words))
    return doubts + ([] if topography.periodic else ["the map is not periodic: its mirror images continue it"])
