"""The contact of a measured map, solved: load and areas at 1 % repulsive area, to set beside the predictions.

Reduced units with a0 = Δr.  The wall attracts as the paper's does, with the work of adhesion and the effective range
that are asked for, on a core that is stiff against the elastic response of one pixel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from continuum.geometry import measure
from continuum.greens import HalfSpace
from continuum.grid import Grid, Real
from continuum.loading import State, follow, solve
from continuum.materials import Interface
from continuum.minimise import Settings
from continuum.predict import AREA
from continuum.problem import ContactProblem
from continuum.surface import moments
from continuum.theory import snap_in_wavelength
from continuum.topography import Topography, mirror
from continuum.wall import LennardJonesSpline, Tabulated

__all__ = ["Simulation", "UnresolvedError", "simulate", "spline_wall"]

CORE_STIFFNESS = 5.0
"""Of the wall's core, in E* per pixel."""
CORE_DEPTH = 2.0
"""Of the tabulated core, in pixels: at its end the wall pushes with 10 E*."""
KNOTS = 101
"""Of the table on each side of the minimum."""
TOLERANCE = 1e-5
"""Residual, relative to h' E*."""
OVERLAPS = tuple(float(f) for f in np.geomspace(1e-4, 0.5, 16))
"""Mean gaps to try, as the share of the undeformed surface that would overlap: the true area is about half of it."""
CLOSE = 0.1
"""Relative distance from 1 % area that is interpolated."""
BISECTIONS = 12
PROCESS_ZONE = 4.0
"""Pixels in the wavelength that snaps in, below which single points do and the map's own pixel decides."""


class UnresolvedError(ValueError):
    """The map cannot carry the solution: the message says why."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """What the solver found on approach.  Loads per area, in the units of the interface."""

    area_rep: float
    """Repulsive area: 1 %, or where the surface jumped to."""
    area_ratio: float
    """A_rep/A_att."""
    load: float
    """Load per area at that area; negative: sticky."""
    kappa: float
    """h' E* A_rep/N."""
    largest_tension: float
    """Most negative load on the way, as a positive number."""
    jumped: bool
    """Whether the area jumped past 1 %."""
    gap: Real = field(repr=False)
    """In units of Δr, over ``grid``."""
    wall: Tabulated = field(repr=False)
    grid: Grid
    """In units of Δr."""
    shape: tuple[int, int]
    """Points of the map itself, the first of the grid's in each direction."""
    lengths: tuple[float, float]
    """Size of the map itself, in the units of the interface."""
    warnings: tuple[str, ...]

    @property
    def sticky(self) -> bool:
        """Negative load at 1 % repulsive area on approach."""
        return self.load < 0


def spline_wall(adhesion_length: float, core_stiffness: float, depth: float) -> Tabulated:
    """The paper's attraction of a given l_a and an effective range of 1, on a linear core of a stiffness of its own.

    In the paper's law repulsion and attraction are equally stiff at the minimum, which ties w to the range and E*.
    Here w and Δr are given, and the core is stiff whatever they are; never softer than the attraction.

    Parameters
    ----------
    adhesion_length : w/E*, in units of the range.
    core_stiffness : of the core, in E* per range.
    depth : to which the core is tabulated.
    """
    reach = 1 / LennardJonesSpline(1.0).effective_range
    law = LennardJonesSpline(reach, 12 * adhesion_length / reach**2)
    # Dense on both sides of the kink, so that the cubic through the knots follows it.
    dense = np.linspace(0.0, 1.0, KNOTS) ** 4
    outside, inside = reach * dense, -depth * dense[:0:-1]
    attraction = law.evaluate(law.zero_gap + outside).traction
    attraction[0] = attraction[-1] = 0.0
    repulsion = -max(core_stiffness, law.minimum_stiffness) * inside
    return Tabulated(np.concatenate([inside, outside]), np.concatenate([repulsion, attraction]))


def simulate(
    topography: Topography,
    interface: Interface,
    progress: Callable[[int, str], None] | None = None,
    threads: int = 1,
) -> Simulation:
    """Approach a rigid wall of the topography to an elastic half-space, up to 1 % repulsive area.

    Parameters
    ----------
    topography : detrended; two bodies are first put :func:`continuum.topography.opposed`.  Continued by its mirror
        images if it is not periodic.
    interface : E*, w and Δr.
    progress : called after each state with how many there are and what it was.
    threads : of the solver.

    Raises
    ------
    UnresolvedError
        If the adhesion acts within less than a pixel: nothing that a solver finds would be of the surface.
    continuum.minimise.NotConvergedError
        If a state does not converge.
    """
    closed = topography if topography.periodic else mirror(topography)
    unit = interface.range
    lengths = (closed.lengths[0] / unit, closed.lengths[1] / unit)
    grid = Grid(closed.grid.shape, lengths, threads)
    # Summits point down from the wall to the surface.
    heights = -(closed.heights - closed.heights.mean()) / unit
    pixel = max(grid.spacing)
    adhesion_length = interface.work_of_adhesion / (interface.contact_modulus * unit)
    wall = spline_wall(adhesion_length, CORE_STIFFNESS / pixel, CORE_DEPTH * pixel)
    slope = moments(grid, heights).rms_slope
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    settings = Settings(TOLERANCE * slope)

    pixels = snap_in_wavelength(wall.largest_softening) / pixel
    if pixels < 1:
        msg = (
            f"waves longer than {pixels:.2g} pixels snap into contact: the map is too coarse for adhesion so "
            "strong and so short-ranged"
        )
        raise UnresolvedError(msg)

    count, tension = 0, 0.0

    def area(state: State) -> float:
        nonlocal count, tension
        state.solution.require()
        contact = measure(grid, wall, state.gap)
        count, tension = count + 1, max(tension, -contact.load)
        if progress is not None:
            progress(count, f"A_rep/A0 {contact.area_rep:.4g}, N/(E* A0) {contact.load:.3g}")
        return contact.area_rep

    quantiles = [-float(q) + wall.zero_gap for q in np.quantile(heights, OVERLAPS)]
    targets = [float(-heights.min()) + wall.zero_gap + 1.0, *quantiles]
    low: tuple[float, State] | None = None
    high: tuple[float, State] | None = None
    for state in follow(problem, "mean-gap", targets, settings):
        if (found := area(state)) >= AREA:
            high = (found, state)
            break
        low = (found, state)
    for _ in range(BISECTIONS):
        if low is None or high is None or high[0] < AREA * (1 + CLOSE):
            break
        # Always from the side of the larger gap, as on approach; the area is nearer to proportional to exp(-gap).
        part = np.log(AREA * (1 + CLOSE / 2) / low[0]) / np.log(high[0] / low[0]) if low[0] > 0.2 * AREA else 0.5
        target = low[1].target + float(np.clip(part, 0.1, 0.9)) * (high[1].target - low[1].target)
        state = solve(problem, "mean-gap", target, settings, low[1].gap + (target - low[1].target), "approach")
        if (found := area(state)) >= AREA:
            high = (found, state)
        else:
            low = (found, state)
    return _result(topography, interface, problem, low, high, tension)


def _result(
    topography: Topography,
    interface: Interface,
    problem: ContactProblem,
    low: tuple[float, State] | None,
    high: tuple[float, State] | None,
    tension: float,
) -> Simulation:
    """Interpolated to 1 % area between two close states; where the surface jumped to if it did."""
    grid, wall = problem.grid, problem.wall
    if not isinstance(wall, Tabulated) or high is None:
        msg = "half of the surface overlaps, and less than 1 % of it is in contact: the map is no rough surface"
        raise ValueError(msg)
    contact = measure(grid, wall, high[1].gap)
    area, load = contact.area_rep, contact.load
    jumped = low is None or area > AREA * (1 + CLOSE)
    if low is not None and not jumped:
        other = measure(grid, wall, low[1].gap)
        load += (other.load - load) * (area - AREA) / (area - other.area_rep)
        area = AREA
    found = []
    pixels = snap_in_wavelength(wall.largest_softening) / max(grid.spacing)
    if pixels < PROCESS_ZONE:
        found.append(
            f"the solver resolves the edge of the contact with {pixels:.2g} pixels: single points snap in; a "
            "finer map or a longer range would be needed to trust its load"
        )
    if not topography.periodic:
        found.append("solved on the map and its mirror images")
    slope = moments(grid, problem.heights).rms_slope
    return Simulation(
        area_rep=float(area),
        area_ratio=float(contact.area_rep / contact.area_att) if contact.area_att else np.inf,
        load=float(load * interface.contact_modulus),
        kappa=float(slope * area / load) if load else np.inf,
        largest_tension=float(max(tension, -load) * interface.contact_modulus),
        jumped=bool(jumped),
        gap=high[1].gap,
        wall=wall,
        grid=grid,
        shape=topography.grid.shape,
        lengths=topography.lengths,
        warnings=tuple(found),
    )
