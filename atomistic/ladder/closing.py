"""The load of every rung at one repulsive area, at which the parts of the error budget add up.

The area of a grid is a number k of points, so that a state of given area is one at which the k-th lowest point just
touches: its gap, which moves smoothly with the mean gap, is that where repulsion begins.  Parts that are taken at equal
mean gap and, of the atoms, at equal separation do not add up to the whole; loads at one k do, whatever they are.

The atoms are not relaxed again.  From their state to that at which their k-th point touches, they are assumed to move
as the lattice does: the differences of gap and load from those of the lattice are taken from equal separation.  The
error is of second order in that difference.
"""

from collections.abc import Callable

import numpy as np

from atomistic.ladder.rungs import Rung, RungName
from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.solve.solution import NotConvergedError

Solve = Callable[[float], Rung]
"""State of a rung at a mean gap."""
CLOSE = 1e-5
"""Tolerance of the gap of the k-th point, relative to h'rms a0: the load is then right to some 1e-5, a tenth of the
smallest printed part of a budget, 0.01 %."""
MOST = 20
"""Largest number of states: a secant takes 3 to 6, more only if the k-th point changes."""
REACH = 0.5
"""Largest change of the mean gap, over the rms height of the wall: the load of a rough contact changes e-fold over
that, and of rungs that differ by so much no step of the budget is a small part."""


def loads_at_area(
    states: dict[RungName, Solve], rungs: dict[RungName, Rung], wall: Wall, rms_slope: float, rms_height: float
) -> dict[RungName, float]:
    """N/A0 of each rung with as many repulsive points as the lattice; NaN if the rung jumps over that area.

    Parameters
    ----------
    states : function that solves a continuum rung, including the lattice, at a mean gap.
    rungs : the state of each, the atoms at the separation of the lattice.
    rms_slope, rms_height : of the wall.
    """
    lattice, atoms = rungs["lattice"], rungs["atoms"]
    count = int(np.count_nonzero(lattice.gap < wall.zero_gap))

    def load(name: RungName, moved: Real | float) -> float:
        found = _touching(states[name], rungs[name], count, wall, CLOSE * rms_slope, REACH * rms_height, moved)
        return np.nan if found is None else found.totals.load

    loads = {name: load(name, 0.0) for name in states}
    loads["atoms"] = load("lattice", atoms.gap - lattice.gap) + atoms.totals.load - lattice.totals.load
    return loads


def _touching(
    solve: Solve, start: Rung, count: int, wall: Wall, tolerance: float, reach: float, moved: Real | float
) -> Rung | None:
    """State near that of a rung whose k-th lowest gap, plus the shift of the points, is the edge of repulsion."""
    if not count:
        return None

    def above(rung: Rung) -> float:
        return float(np.partition((rung.gap + moved).ravel(), count - 1)[count - 1]) - wall.zero_gap

    here, rung = start.mean_gap, start
    edge = above(rung)
    # The lowest and the highest mean gap where the k-th point is known to be below and above the edge.
    low, high = here - reach, here + reach
    last: tuple[float, float] | None = None
    for _ in range(MOST):
        if abs(edge) <= tolerance:
            return rung
        low, high = (low, min(high, here)) if edge > 0 else (max(low, here), high)
        rise = 1.0 if last is None or last[1] == edge else (edge - last[1]) / (here - last[0])
        following = here - edge / rise if rise > 0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        last, here = (here, edge), following
        try:
            rung = solve(here)
        except NotConvergedError:
            return None
        edge = above(rung)
    return None
