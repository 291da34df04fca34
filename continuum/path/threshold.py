"""w at the threshold of stickiness, from one state without adhesion: where the load at its area would vanish.

A surface is pressed without attraction to a repulsive area A: it carries the load N0, and leaves the gaps g(x).  With
an attraction of work w the load at the same area is, per A0, in powers of w::

    N(w) = N0 + c1 w + c2 w² + ...        τ(g): attraction per area and work at a gap g beyond zero_gap, <> the mean

    H a = τ(g),  H b = φ''                H = K + φ'' of that state, on fields without mean; φ'' of its core
    a                                     the surface rises by it toward the wall, per work, at the same mean gap
    1 - b                                 its gap opens by it, per mean gap
    k_N = <φ''(1 - b)>,  D_l = <φ''a>/k_N, D_A = <e a>/<e (1 - b)>
    c1 = -<τ> - (D_A - D_l) k_N           exact: first order in w at given area
    c2 = -<τ'(g) z1>,  z1 = D_A (1 - b) - a

D_l withdraws the wall by what keeps the repulsive load, D_A by what keeps the area: points leave the contact where
their pressure vanishes, so that e weighs the edge of the contact by one over its pressure.  Where adhesion deforms
nothing, c1 = -<τ> and the threshold is w_DMT = N0/<τ>, as of Derjaguin, Muller and Toporov with computed gaps.

With w1 = -N0/c1 and χ = c2 w1/(-c1), two forms are right to second order: w1 (1 + χ), and the root of the quadratic,
which exists up to χ = 1/4.  The threshold lies between them; how far they are apart is what the third order may
change.  No number is fitted.  It is stated, with what it was tested on, in docs/law.md.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.inputs.keys import LARGEST, SMALLEST
from continuum.measure.contact import area_by_lines
from continuum.measure.outline import patches, perimeter_map
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.walls import HardWall, Wall
from continuum.path.area import find_area
from continuum.path.state import PathState, Search
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver

ACCURACY, ITERATIONS = 1e-3, 1000
"""Relative residual of the linear solves, which moves the threshold by .3 % at most on three surfaces, and steps after
which they give up."""
SHAPES, SAME = 12, 1e-4
"""Works at which the shape of a law is looked at before the threshold counts as not found, and how far two shapes may
be apart, relative to the largest attraction: a thousandth of what the third order leaves open."""
NOTHING = -10.0
"""Logarithm of the attraction over the load that stands for none at all: a work e^10 times as large is tried next."""
EDGE = 0.03
"""Smallest pressure by which the edge is weighed, in units of the mean pressure of the contact: with a smaller one a
single point that is about to part stands for the whole edge."""


class Threshold(NamedTuple):
    """Work of adhesion at which the load at a repulsive area vanishes, in E* a0, NaN where none was found."""

    low: float
    """w1 (1 + χ)."""
    high: float
    """The root of the quadratic; infinite where it has none."""
    dmt: float
    """w_DMT = N0/<τ>, where adhesion deforms nothing."""
    chi: float
    """χ, the second order over the first."""
    area_rep: float
    """Repulsive area of the state, as a fraction of A0."""
    patches: int
    """Connected patches of that area."""
    withdrawal: float = np.nan
    """D_A, the change of the mean gap per work of adhesion at this area."""

    @property
    def work(self) -> float:
        """The estimate: the geometric mean of both forms; NaN where there is only one."""
        return float(np.sqrt(self.low * self.high)) if self.low > 0 and np.isfinite(self.high) else np.nan


class StateResponse(NamedTuple):
    """What an attraction does to the state, per work of adhesion."""

    first: float
    """c1."""
    second: float
    """c2."""
    withdrawal: float
    """D_A."""
    moved: float
    """<|τ'(g) z1|>/<τ>, by how much the attraction changes as the gaps do, whichever way."""

    def threshold(self, load: float) -> tuple[float, float, float]:
        """Both forms of the threshold, and χ."""
        if not self.first < 0:
            return np.nan, np.nan, np.nan
        first = -load / self.first
        chi = -self.second * first / self.first
        high = 2 * first / (1 + np.sqrt(1 - 4 * chi)) if chi <= 0.25 else np.inf
        low, high = sorted((first * (1 + chi), float(high)))
        return low, high, chi


def _dot(a: Real, b: Real) -> float:
    """Scalar product, by one thread: that of BLAS starts threads of its own, which doubled the CPU time of a curve."""
    return float(np.einsum("i,i", a, b))


def _conjugate_gradients(product: Callable[[Real], Real], right: Real) -> Real:
    """The solution of a symmetric positive definite system, to :data:`ACCURACY`; NaN if it is not found."""
    found, rest = np.zeros(right.size), right.copy()
    direction, left = rest.copy(), _dot(rest, rest)
    most = ACCURACY**2 * left
    for _ in range(ITERATIONS):
        if not left > most:
            return found
        image = product(direction)
        step = left / _dot(direction, image)
        found += step * direction
        rest -= step * image
        last, left = left, _dot(rest, rest)
        direction = rest + left / last * direction
    return np.full(right.size, np.nan)


@dataclass(frozen=True, eq=False)
class _Core:
    """A contact of given points on a core of given stiffness, K x + φ'' x = K x0 but for the mean.

    Solved for f = φ'' x on the contact, f/k + G f = x0, by conjugate gradients: G = 1/K without mean.  A pair of
    transforms a step, of which 15 to 25 do; on displacements, with a core so stiff, it takes three times as many.
    """

    grid: Grid
    stiffness_q: Real
    stiffness: float
    contact: NDArray[np.bool_]

    @cached_property
    def compliance_q(self) -> Real:
        """G, in a0/E*."""
        K = np.array(self.stiffness_q)
        K[0, 0] = np.inf
        return 1.0 / K

    def compliance(self, traction: Real) -> Real:
        """G of a traction: the displacement that it makes, without its mean."""
        return self.grid.inverse(self.compliance_q * self.grid.forward(traction), overwrite=True)

    def response(self, alone: Real, start: Real | None = None) -> Real:
        """x, from x0: what it would be ``alone``, without the core; ``start`` is an x on the contact."""
        inside, field = self.contact, np.zeros(self.grid.shape)

        def product(force: Real) -> Real:
            field[inside] = force
            made: Real = self.compliance(field)[inside]
            return made + force / self.stiffness

        first = np.zeros(int(inside.sum())) if start is None else self.stiffness * start[inside]
        force = first + _conjugate_gradients(product, alone[inside] - product(first))
        field[inside] = force
        found = alone - self.compliance(field)
        found[inside] = force / self.stiffness  # no difference of two large numbers
        return found


@dataclass(frozen=True, eq=False)
class PressedState:
    """A surface that is pressed on a core without adhesion, as thresholds ask for it; lengths in a0, pressures in E*.

    Parameters
    ----------
    core : its points in contact, and the response of the surface.
    distance : of the wall beyond that of zero traction, shape ``grid.shape``: negative in contact.
    opening : 1 - b, by which the distance grows per mean gap.
    """

    core: _Core = field(repr=False)
    distance: Real = field(repr=False)
    opening: Real = field(repr=False)

    @property
    def grid(self) -> Grid:
        """The points of the surface."""
        return self.core.grid

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Where the surface touches, shape ``grid.shape``."""
        return self.core.contact

    @property
    def area_rep(self) -> float:
        """Repulsive area, as a fraction of A0."""
        return float(self.contact.mean())

    @cached_property
    def load(self) -> float:
        """N0, per A0."""
        return -self.core.stiffness * self.grid.mean(np.minimum(self.distance, 0.0))

    @cached_property
    def patches(self) -> int:
        """Connected patches of the contact."""
        return len(patches(self.grid, self.contact).cells)

    @cached_property
    def _edge(self) -> Real:
        """Weights e of the edge of the contact."""
        overlap = -self.distance
        least = EDGE * float(overlap[self.contact].mean())
        return np.where(perimeter_map(self.contact) & (overlap > 0), 1.0 / np.maximum(overlap, least), 0.0)

    def attraction(self, wall: Wall) -> tuple[Real, Real]:
        """τ and τ' of a law at the gaps, shape ``grid.shape``: per work of adhesion, in 1/a0 and 1/a0²."""
        law = wall.evaluate(wall.zero_gap + np.maximum(self.distance, 0.0))
        # At a distance of zero, as the next point to touch has, the core has another slope than the attraction.
        apart, work = ~self.contact & (self.distance > 0), wall.work_of_adhesion
        return np.where(apart, -law.traction / work, 0.0), np.where(apart, law.stiffness / work, 0.0)

    def response(self, pull: Real, slope: Real) -> StateResponse:
        """What an attraction τ(g) of a slope τ'(g), shape ``grid.shape``, does to the state."""
        mean, force, opens = self.grid.mean, self.core.stiffness * self.contact, self.opening
        rise = self.core.response(self.core.compliance(pull))
        stiffness = mean(force * opens)
        same_load = mean(force * rise) / stiffness
        same_area = mean(self._edge * rise) / mean(self._edge * opens)
        first = -mean(pull) - (same_area - same_load) * stiffness
        opened = slope * (same_area * opens - rise)
        pulled = mean(pull)
        moved = mean(np.abs(opened)) / pulled if pulled > 0 else 0.0
        return StateResponse(first, -mean(opened), same_area, moved)

    def dmt(self, law_of: WallOfWork) -> float:
        """w_DMT, in E* a0: the root of N0 = w <τ>, as a law may change its range with its work; NaN without one."""

        @cache
        def excess(logarithm: float) -> float:
            work = float(np.exp(logarithm))
            if not SMALLEST <= work <= LARGEST:  # no law has it
                return NOTHING
            pull = self.grid.mean(self.attraction(law_of(work))[0])
            return float(np.log(pull * work / self.load)) if pull > 0 else NOTHING

        start = float(np.log(self.load * float(self.distance.max())))
        other = start - excess(start)
        if excess(other) == excess(start) == NOTHING:
            return np.nan
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # two trials without attraction: it has not converged
            found = scipy.optimize.root_scalar(excess, x0=start, x1=other, xtol=1e-6, maxiter=40)
        return float(np.exp(found.root)) if found.converged else np.nan

    def deciding_heights(self, wall: Wall) -> Real:
        """The derivative of w_DMT = N0/<τ> by every height at this area, shape ``grid.shape``, in E*.

        It is positive where a greater height of the wall above the surface raises w_DMT, and its sum vanishes.
        """
        by_load, by_tension = self._by_heights(wall)
        pull = self.grid.mean(self.attraction(wall)[0])
        return np.asarray((by_load - self.load / pull * by_tension) / pull)

    def load_by_heights(self, wall: Wall, work: float) -> Real:
        """The derivative of the load N0 - w <τ> by every height at this area, shape ``grid.shape``, per A0 in E*/a0.

        Of an attraction that opens the gaps, w is the part of the work that still acts.
        """
        by_load, by_tension = self._by_heights(wall)
        return np.asarray(by_load - work * by_tension)

    def _by_heights(self, wall: Wall) -> tuple[Real, Real]:
        """The derivatives of N0 and <τ> by every height at this area.

        Of a number whose change is <f dz> the derivative by the heights is (1 + φ'' G)^-1 f, one linear solve: of a
        core so stiff it is found as a force on the contact, as f and what cancels it are large there.
        """
        inside, stiffness, opens, mean = self.contact, self.core.stiffness, self.opening, self.grid.mean

        def by_heights(f: Real) -> Real:
            apart = np.where(inside, 0.0, f)
            x = self.core.response(np.where(inside, f / stiffness, 0.0) - self.core.compliance(apart))
            return np.where(inside, stiffness * x, apart)

        edge = area_by_lines(self.distance)[1] * self.grid.size
        area = by_heights(edge) / mean(edge * opens)
        _, slope = self.attraction(wall)
        by_load, by_tension = (one - mean(one) * area for one in (-stiffness * inside * opens, by_heights(slope)))
        return by_load / self.grid.size, by_tension / self.grid.size

    def threshold(self, law_of: WallOfWork) -> Threshold:
        """Where the load at this area vanishes under a law, whose shape is that of the work found.

        Two linear solves with the Hessian, one of which serves all laws; more where the shape changes with the work.
        """
        work = dmt = self.dmt(law_of) if self.load > 0 else np.nan
        low, high, chi, withdrawal = np.nan, np.nan, np.nan, np.nan
        last: Real | None = None
        before: tuple[float, float] | None = None
        for _ in range(SHAPES if np.isfinite(dmt) else 0):
            pull, slope = self.attraction(law_of(work))
            if last is not None and np.allclose(pull, last, rtol=0.0, atol=SAME * float(pull.max())):
                break
            response = self.response(pull, slope)
            last = pull
            low, high, chi = response.threshold(self.load)
            withdrawal = response.withdrawal
            found = low if np.isinf(high) else float(np.sqrt(max(low * high, 0.0)))
            if not found > 0:
                break
            # The work whose law asks for itself, by the secant: each law's work as the next one goes back and forth
            # where the range grows with the work, and may not come to an end.
            here, off = float(np.log(work)), float(np.log(found / work))
            rise = (off - before[1]) / (here - before[0]) if before is not None and here != before[0] else -1.0
            before = here, off
            work *= float(np.exp(-off / min(rise, -0.5)))
        else:
            low, high, chi = np.nan, np.nan, np.nan
        return Threshold(low, high, dmt, chi, self.area_rep, self.patches, withdrawal)


def core_stiffness(wall: Wall) -> float:
    """Stiffness of a law that repels a little, in E*/a0: by a hundredth of its range, beyond the kink of a core."""
    return float(wall.evaluate(np.array(wall.zero_gap - 0.01 * wall.effective_range)).stiffness)


def press_without_adhesion(
    problem: ContactProblem,
    area: float,
    settings: Settings,
    core_stiffness: float,
    search: Search | None = None,
) -> PressedState:
    """The surface of a contact at a repulsive area, pressed on a core without attraction.

    A hard wall is pressed, which takes a tenth of the transforms, and one step of Newton's method leads from its
    contact to the core, at the same area.

    Parameters
    ----------
    problem : grid, heights and response; its wall is not used.
    area : repulsive area, as a fraction of A0.
    settings, search : as for :func:`continuum.path.loading.solve`.
    core_stiffness : of the law where it repels, in E*/a0.

    Raises
    ------
    NotConvergedError
        If there is no such state, as between two sizes of a contact of few points.
    """
    hard = replace(problem, wall=HardWall())
    solver = Solver(problem.grid, problem.stiffness_q, settings.threads, settings.device, shards=settings.shards)
    return on_core(hard, find_area(hard, area, settings, search or Search(), (), "start", solver), core_stiffness)


def on_core(problem: ContactProblem, hard: PathState, core_stiffness: float) -> PressedState:
    """The state on a core at the area of one under a hard wall, by one step of Newton's method."""
    found, grid = hard.require(), problem.grid
    core = _Core(grid, problem.stiffness_q, core_stiffness, problem.wall.touches(found.gap))
    level = core.response(problem.heights, -found.traction / core_stiffness)
    opens = core.response(np.ones(grid.shape))
    # As many points touch as under the hard wall.
    last = -int(core.contact.sum()) - 1
    distance = level + float(np.partition((-level / opens).ravel(), last)[last]) * opens
    return PressedState(core, distance, opens)
