"""The ladder of models: the same wall on substrates that differ by one thing at a time.

=====  ==========================================  =============================================
rung   elastic response                            difference to the next rung
=====  ==========================================  =============================================
1      isotropic half-space, ν = 1/2               finite depth
2      isotropic layer on a rigid base, ν = 1/2    anisotropy
3      anisotropic cubic layer                     lattice discreteness
4      lattice Green's function of the same slab   geometric nonlinearity
5      explicit atoms, LAMMPS
=====  ==========================================  =============================================

All are of one crystal: of springs, Lennard-Jones or a metal.  For the latter two, the difference of 4 and 5 is
geometry and anharmonicity.  A lattice and atoms of springs under the same wall, 4' and 5', give the geometric part.

Rungs 1 to 4 are compared at equal mean gap: rungs 1 and 2 have no mean compliance, so that at equal separation their
loads differ severalfold and cannot be compared.  Rungs 4 and 5, and 4' and 5', share the mean compliance and are
compared at equal separation.

Parts that are taken so do not add up to the whole; loads at one repulsive area do (:func:`loads_at_area`).  The area of
a grid is a number k of points, so that a state of given area is one at which the k-th lowest point just touches: its
gap, which moves smoothly with the mean gap, is that where repulsion begins.

Atoms are not relaxed again for that.  From their state to that at which their k-th point touches, they are assumed to
move as the lattice does: the differences of gap and load from those of the lattice are taken from equal separation.
The error is of second order in that difference.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from atomistic.response.lattice import LatticeResponse
from continuum.measure.contact import Totals, contact_map, quantity, shared
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.substrates import CubicLayer, HalfSpace, Layer, Substrate
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.walls import Wall
from continuum.path.loading import follow, solve
from continuum.path.state import Branch, PathState
from continuum.solve.solution import NotConvergedError, Settings

RungName = Literal["half-space", "layer", "crystal", "lattice", "atoms", "spring-lattice", "spring-atoms"]
WORDS: dict[RungName, str] = {
    "half-space": "half-space",
    "layer": "layer",
    "crystal": "cubic layer",
    "lattice": "lattice Green's function",
    "atoms": "atoms",
}
"""Names of the rungs in tables and figures."""
CONTINUUM_RUNGS: tuple[RungName, ...] = ("half-space", "layer", "crystal", "lattice")
RUNGS: tuple[RungName, ...] = (*CONTINUUM_RUNGS, "atoms", "spring-lattice", "spring-atoms")


CLOSE = 1e-5
"""Tolerance of the gap of the k-th point, relative to h'rms a0: the load is then right to some 1e-5, a tenth of the
smallest printed part of a budget, 0.01 %."""
MOST = 20
"""Largest number of states: a secant takes 3 to 6, more only if the k-th point changes."""
REACH = 0.5
"""Largest change of the mean gap, over the rms height of the wall: the load of a rough contact changes e-fold over
that, and of rungs that differ by so much no step of the budget is a small part."""


def response_of(name: RungName, lattice: LatticeResponse, constants: CubicConstants) -> Substrate:
    """Elastic response of a rung but atoms over the slab of the lattice, whose crystal has these constants."""
    return lattice if name == "lattice" else continuum_response(name, lattice.slab.depth, constants)


def continuum_response(name: RungName, depth: float, constants: CubicConstants) -> Substrate:
    """Elastic response of a rung without atoms, as deep as given, in a0.

    Raises KeyError for the name of another rung.
    """
    if name == "half-space":
        return HalfSpace("clamped")
    if name == "layer":
        return Layer(depth, 0.5, "clamped")
    if name == "crystal":
        return CubicLayer(depth, constants, constants.c11 / depth)
    raise KeyError(name)


@dataclass(frozen=True, eq=False, kw_only=True)
class Rung(Totals):
    """State of one model under the wall."""

    name: RungName
    separation: float = quantity("a0", "height of the wall's zero above the undeformed surface")
    gap: Real
    """Shape (nx, ny), in a0."""
    traction: Real
    """Shape (nx, ny), in E*; for atoms, the force of the wall on each as LAMMPS computes it, over a0²."""

    @property
    def mean_gap(self) -> float:
        return float(self.gap.mean())


Solve = Callable[[float], Rung]
"""State of a rung at a mean gap."""


def rung_of(problem: ContactProblem, name: RungName, state: PathState) -> Rung:
    """A continuum state as a rung; raises NotConvergedError if it is not an equilibrium."""
    gap = state.solution.require().gap
    traction = problem.wall.evaluate(gap).traction
    return Rung(**shared(Totals, state), name=name, separation=state.separation, gap=gap, traction=traction)


def approach_and_retract(problem: ContactProblem, largest_area: float, settings: Settings) -> Iterator[PathState]:
    """Quasi-static loading from out of range to a repulsive area, and back, at given separations.

    The step, a twentieth of the rms height, resolves the snapping of single asperities.
    """
    step = float(problem.heights.std()) / 20
    touching = problem.wall.zero_gap + problem.wall.range - float(problem.heights.min())
    path: list[PathState] = []

    def extend(separation: float) -> PathState:
        state = next(follow(problem, "separation", [separation], settings, path[-2:]))
        state.solution.require()
        path.append(state)
        return state

    count = 0
    while True:
        state = extend(touching - count * step)
        yield state
        if state.area_rep >= largest_area:
            break
        count += 1
    while state.smallest_gap < problem.wall.zero_gap + problem.wall.range:
        count -= 1
        state = extend(touching - count * step)
        yield state


def state_at_area(
    problem: ContactProblem, path: list[PathState], area: float, branch: Branch, settings: Settings
) -> PathState:
    """State of at least the given repulsive area, as close as the path allows, on one of its branches.

    Without adhesion the area is met by bisection in the separation.  With adhesion states are taken from the path
    itself: bisection would end at the edge of a snap, which two models reach at slightly different separations.

    Raises ValueError if the path does not reach the area.
    """
    reversal = min(range(len(path)), key=lambda i: path[i].separation)
    # Both branches in the order of growing contact; the point of reversal belongs to both.
    states = path[: reversal + 1] if branch == "approach" else path[reversal:][::-1]
    beyond = [state.area_rep >= area for state in states]
    if True not in beyond:
        raise ValueError(f"the {branch} branch does not reach a repulsive area of {area}")
    index = beyond.index(True)
    if problem.wall.range > 0 or index == 0:
        return states[index]
    outer, inner = states[index - 1 : index + 1]
    for _ in range(20):
        middle = 0.5 * (outer.separation + inner.separation)
        state = solve(problem, "separation", middle, settings, outer.gap + middle - outer.separation, branch)
        state.solution.require()
        outer, inner = (outer, state) if state.area_rep >= area else (state, inner)
    return inner


class NoJumpError(ValueError):
    """The approach has no jump."""


def beside_jump(problem: ContactProblem, path: list[PathState]) -> dict[str, PathState]:
    """States of a path on both sides of its jump-in, by name.

    The jump is the largest growth of the repulsive area in one step of the approach.  ``before jump-in`` and ``after
    jump-in`` are the ends of this step; ``retraction past it`` is at the separation of the former, on the other branch.

    Raises NoJumpError if both branches have the same contact there.
    """
    area = [state.area_rep for state in path]
    reversal = min(range(len(path)), key=lambda i: path[i].separation)
    after = max(range(1, reversal + 1), key=lambda i: area[i] - area[i - 1])
    before, past = after - 1, 2 * reversal - after + 1  # the way back takes the same steps
    if past >= len(path) or area[past] <= area[before]:
        raise NoJumpError("the approach has no jump-in: leave out jump, or make adhesion_length larger")
    names = ("before jump-in", "after jump-in", "retraction past it")
    return {name: path[i] for name, i in zip(names, (before, after, past), strict=True)}


class Difference(NamedTuple):
    """Differences of one rung from another, the second being the reference."""

    load: float
    """(N - N')/N'_rep: relative to the repulsive load, since the total may cross zero.  Infinite if only the
    reference is out of contact: the two are on different branches; NaN if both are."""
    gross_load: float
    """(N - N')/(N'_rep + N'_att): relative to the sum of repulsion and attraction; infinite if that is zero."""
    area_rep: float
    """(A_rep - A_rep')/A0."""
    area_att: float
    """(A_att - A_att')/A0."""
    displacement: float
    """Largest difference of the displacement of a point, max |u - u'|, in a0."""
    pressure: float
    """rms(p - p')/rms(p')."""
    pixels: int
    """Points whose contact differs: repulsive, attracted or out of range."""


def compare(rung: Rung, reference: Rung, wall: Wall) -> Difference:
    """Difference of two states under the same wall, at equal separation or equal mean gap."""
    a, b = rung, reference
    acts = b.load_rep + b.load_att > 0
    out_of_contact = np.inf if a.load_rep > 0 or not acts else np.nan
    pressure = np.mean((rung.traction - reference.traction) ** 2)
    return Difference(
        load=(a.load - b.load) / b.load_rep if b.load_rep > 0 else out_of_contact,
        gross_load=(a.load - b.load) / (b.load_rep + b.load_att) if acts else np.inf,
        area_rep=a.area_rep - b.area_rep,
        area_att=a.area_att - b.area_att,
        # Equal separation or equal mean gap: in either case the heights cancel, and the difference is -(u - u').
        displacement=float(np.abs(rung.gap - reference.gap).max()),
        pressure=float(np.sqrt(pressure / np.mean(reference.traction**2))) if acts else np.inf,
        pixels=int(np.count_nonzero(kinds_of(rung, wall) != kinds_of(reference, wall))),
    )


def kinds_of(rung: Rung, wall: Wall) -> NDArray[np.uint8]:
    """Contact map of a rung; for atoms by the sign of the wall's force on them, as LAMMPS computed it."""
    if rung.name not in ("atoms", "spring-atoms"):
        return contact_map(wall, rung.gap)
    return np.where(rung.traction > 0, 2, np.where(rung.traction < 0, 1, 0)).astype(np.uint8)


def loads_at_area(
    states: Mapping[RungName, Solve], rungs: dict[RungName, Rung], wall: Wall, rms_slope: float, rms_height: float
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
        return np.nan if found is None else found.load

    loads = {name: load(name, 0.0) for name in states}
    loads["atoms"] = load("lattice", atoms.gap - lattice.gap) + atoms.load - lattice.load
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
