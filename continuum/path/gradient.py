"""Which heights decide: the gradients that a state is asked for, from the derivatives of its numbers.

Each number has a derivative by the height of every point, by how near the wall is, and by its work of adhesion.

At an equilibrium z = D + h - u, K u + p(z) = 0.  Of a number whose change is the mean of f(x) dz(x), one linear solve
with the Hessian, (K + φ''(z)) λ = f, has the derivative by all heights at once,

    dF/dh(x) = (f - φ'' λ)(x)/n        n: points of the grid

at given separation; its sum is that by the separation.  At given mean gap the same holds for fields without mean, and
the sum is the derivative by the mean gap.  For the load f = -φ''.  Under a hard wall φ'' is infinite on the contact:
with y the pressures there that displace the contact by one, which outside of it vanish, dN/dh(x) = -y(x)/n.

Derivatives at a given load or area follow from those at a given mean gap: it changes by as much as keeps the number.
By the work of adhesion w, which changes the tractions by ∂p/∂w at a given gap, dF/dw is the mean of λ ∂p/∂w.

The threshold is an implicit function: with N and A functions of mean gap, work of adhesion w and heights,
dw/dh = -(dN/dh)/(dN/dw), both at a given area.  At its least along a path the load is stationary, and by the envelope
theorem its derivative is that at a given gap.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from operator import itemgetter
from typing import Literal, NamedTuple, get_args

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.inputs.arguments import ArgumentError, choice, field_of, function, instance, number
from continuum.measure.contact import area_by_lines
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import NO_MEAN_GAP, equilibrium, solver_of
from continuum.path.state import PathState, height, nearness
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import NotConvergedError, Settings
from continuum.solve.tangent import SHIFT, solve_hessian

Number = Literal["load", "area", "threshold", "pull_off"]
Given = Literal["mean_gap", "separation", "pressure", "area"]

SMALLEST_JUMP = 1e-3
"""Change of the load from one side of its minimum to the other, relative, from which on it is a jump."""
STEPS, LARGEST_STEP, FIRST_STEP, SMALLEST_STEP = 40, 0.1, 0.02, 1e-6
"""Steps to the least load: their number, and lengths in ranges of the wall; the last is the width of its bracket."""
SAME_LAW = 1e-6
"""Largest difference of two laws that are the same, of the largest traction: works may be rounded numbers."""
LAW_NEEDED = "a law with attraction: under a hard wall the load has a gradient, but nothing that pulls"
ACCURACY = 1e-10
"""Residual of the linear solves, relative: derivatives are then as good as the equilibrium."""
CONTACT_ITERATIONS = 2000
WORK_STEP = 1e-4
"""Step of w by which ∂p/∂w is found, relative: the error is about its square."""
NO_EDGE = "a law: at the edge of a contact under a hard wall the gap has no slope, and the area no derivative"


class Derivative(NamedTuple):
    """The derivative of one number of an equilibrium."""

    heights: Real
    """By the height of each point where the wall is held as near as it is, shape ``grid.shape``, per a0."""
    nearness: float
    """By the mean gap, or without periodic images by the separation, per a0."""
    work: float = 0.0
    """By the work of adhesion, per E* a0."""

    def holding(self, other: Derivative) -> Derivative:
        """The same where another number is held in place of the nearness.

        Raises NotConvergedError where the other is stationary, as a load at pull-off, or an area without contact.
        """
        if other.nearness == 0:
            raise NotConvergedError("no derivative: what is held does not depend here on how near the wall is")
        share = self.nearness / other.nearness
        return Derivative(self.heights - share * other.heights, 0.0, self.work - share * other.work)


@dataclass(frozen=True, eq=False)
class Tangent:
    """An equilibrium and all that lie next to it.

    Parameters
    ----------
    problem, gap : the contact, and the gap of its equilibrium, shape ``grid.shape``, in a0.
    wall_of : law of each work of adhesion, for derivatives by it; None to leave them zero.
    """

    problem: ContactProblem
    gap: Real
    wall_of: WallOfWork | None = None

    def of(self, slope: Real, by_work: float = 0.0) -> Derivative:
        """The derivative of a number whose change is the mean of ``slope`` dz + ``by_work`` dw.

        Raises
        ------
        NotConvergedError
            If the linear solve does not converge: the state is at the edge of its stability.
        """
        problem, stiffness = self.problem, self._stiffness
        boundary = problem.open_boundary
        if boundary is None:
            beyond = solve_hessian(problem.grid, problem.stiffness_q, stiffness, slope, SHIFT, ACCURACY)
        else:
            around = boundary.around(stiffness, 0.0), boundary.around(slope, 0.0)
            beyond = solve_hessian(boundary.grid, boundary.stiffness_q, *around, SHIFT, ACCURACY, mean_free=False)
            beyond = boundary.inside(beyond)
        if not np.isfinite(beyond).all():
            raise NotConvergedError("no derivative: the linear solve with the Hessian did not converge, as the state "
                                    "is about to jump; take one a little before")  # fmt: skip
        work = by_work + (0.0 if self.wall_of is None else problem.grid.mean(beyond * self._by_work[0]))
        return self._derivative(slope - stiffness * beyond, work)

    @cached_property
    def load(self) -> Derivative:
        """The derivative of the load per A0, in E*."""
        if self.problem.wall.law is None:
            return self._derivative(-self._pressures_that_lift())
        work = 0.0 if self.wall_of is None else self.problem.grid.mean(self._by_work[0])
        return self.of(-self._stiffness, work)

    @cached_property
    def area(self) -> Derivative:
        """The derivative of the repulsive area of :func:`continuum.measure.contact.area_by_lines`, a fraction of A0."""
        wall, boundary = self.problem.wall, self.problem.open_boundary
        if wall.law is None:
            raise ArgumentError("wall", wall, NO_EDGE)
        _, slope = area_by_lines(self.gap - wall.zero_gap, periodic=boundary is None)
        work = 0.0 if self.wall_of is None else -float(slope.sum()) * self._by_work[1]
        return self.of(slope * slope.size, work)

    @property
    def mean_gap(self) -> Derivative:
        """The derivative of the mean gap."""
        if self.problem.open_boundary is not None:
            raise ArgumentError("at", "mean_gap", NO_MEAN_GAP)
        return self._itself

    @property
    def separation(self) -> Derivative:
        """The derivative of the separation."""
        if self.problem.open_boundary is not None:
            return self._itself
        k, load = self.problem.mean_stiffness, self.load
        if k == 0:
            raise ArgumentError("at", "separation", "mean_gap where the mean displacement of the substrate is free")
        # The separation is the mean gap less the mean height, less the load over k.
        return Derivative(-1 / self.gap.size - load.heights / k, 1.0 - load.nearness / k, -load.work / k)

    @property
    def _itself(self) -> Derivative:
        """The derivative of what says how near the wall is."""
        return Derivative(np.zeros(self.gap.shape), 1.0)

    @cached_property
    def _stiffness(self) -> Real:
        return self.problem.wall.evaluate(self.gap).stiffness

    @cached_property
    def _by_work(self) -> tuple[Real, float]:
        """Derivatives by w of the traction at each gap, per a0, and of the gap where it vanishes, per E*."""
        assert self.wall_of is not None
        work = self.problem.wall.work_of_adhesion
        less, more = (self.wall_of(work * (1 + sign * WORK_STEP)) for sign in (-1, 1))
        step = more.work_of_adhesion - less.work_of_adhesion
        tractions = more.evaluate(self.gap).traction - less.evaluate(self.gap).traction
        return tractions / step, (more.zero_gap - less.zero_gap) / step

    def _derivative(self, by_gap: Real, work: float = 0.0) -> Derivative:
        """From what a number changes by where the gap would at each point, were it not for the elastic response."""
        mean = self.problem.grid.mean(by_gap)
        heights = by_gap - mean if self.problem.open_boundary is None else by_gap
        return Derivative(heights / by_gap.size, mean, work)

    def _pressures_that_lift(self) -> Real:
        """Pressures on the contact of a hard wall that displace it by one, in E*/a0; zero elsewhere.

        By conjugate gradients for the compliance between the points of the contact, with the stiffness between them as
        preconditioner.  Where a wall yields its traction is given, and the gap negative.
        """
        problem, boundary, inside = self.problem, self.problem.open_boundary, self.gap == 0
        pressures = np.zeros(self.gap.shape)
        if not inside.any():
            return pressures
        grid = problem.grid if boundary is None else boundary.grid
        K = np.array(problem.stiffness_q if boundary is None else boundary.stiffness_q)
        if boundary is None:
            K[0, 0] = np.inf
        compliance = 1 / K
        K[0, 0] = K[0, 0] if np.isfinite(K[0, 0]) else 0.0
        filled = np.zeros(grid.shape)
        window = filled[: inside.shape[0], : inside.shape[1]]

        def between(v: NDArray[np.float64], response_q: Real) -> NDArray[np.float64]:
            window[inside] = v
            found = grid.inverse(response_q * grid.forward(filled), overwrite=True)
            image: Real = found[: inside.shape[0], : inside.shape[1]][inside]
            return image

        linalg, size = scipy.sparse.linalg, 2 * (int(np.count_nonzero(inside)),)
        compliant, stiff = (
            linalg.LinearOperator(size, matvec=partial(between, response_q=q), dtype=np.float64)
            for q in (compliance, K)
        )
        found, failed = linalg.cg(compliant, np.ones(size[0]), M=stiff, rtol=ACCURACY, maxiter=CONTACT_ITERATIONS)
        if failed or size[0] == grid.size:
            raise NotConvergedError("no derivative: at full contact under a hard wall the mean gap is no longer free")
        pressures[inside] = found
        return pressures


# --- the gradients of a state


_NUMBERS: Mapping[Given, Callable[[Tangent], Derivative]] = {
    "mean_gap": lambda tangent: tangent.mean_gap,
    "separation": lambda tangent: tangent.separation,
    "pressure": lambda tangent: tangent.load,
    "area": lambda tangent: tangent.area,
}


@dataclass(frozen=True, eq=False)
class _Question:
    """A derivative that is asked for."""

    problem: ContactProblem
    state: PathState
    settings: Settings
    at: Given | None
    wall_of: WallOfWork | None

    @property
    def tangent(self) -> Tangent:
        """At the state."""
        return Tangent(self.problem, self.state.gap)

    def at_given(self, tangent: Tangent, number: Callable[[Tangent], Derivative]) -> Real:
        """The derivative of a number where another is held; else where the wall is held as the state's control has it.

        That is the separation where it was given, or where nothing is repeated, and the mean gap for all others.
        """
        at: Given = "separation" if "separation" in (self.state.control, nearness(self.problem)) else "mean_gap"
        at = at if self.at is None else choice("at", self.at, get_args(Given))
        hold = _NUMBERS[at]
        if hold is number:
            raise ArgumentError("at", at, "another number: of the one that is held all derivatives are zero")
        return number(tangent).holding(hold(tangent)).heights

    def refuse_at(self, what: str) -> None:
        """Refuse a number to be held where the question says what is."""
        if self.at is not None:
            raise ArgumentError("at", self.at, f"None: {what}")


def threshold_gradient(problem: ContactProblem, state: PathState, wall_of: WallOfWork) -> Real:
    """The derivative by all heights of the work of adhesion at which the load at a given area has its value here.

    With N and A functions of mean gap, work and heights, dw/dh = -(dN/dh)/(dN/dw), both at given A.  At a state of zero
    load it is that of the threshold, positive where a greater height makes the surface less sticky.

    Parameters
    ----------
    problem, state : the contact, with the law of the work of adhesion of this state.
    wall_of : law of each work of adhesion.

    Returns
    -------
    Real
        Shape ``grid.shape``, in E* (a work, E* a0, per a0).
    """
    wall, allowed = problem.wall, "a function that returns for the work of adhesion of the state the law of the state"
    if wall.law is None or not (work := wall.work_of_adhesion) > 0:
        raise ArgumentError("wall", wall, LAW_NEEDED)
    here, there = (one.evaluate(state.gap).traction for one in (wall, wall_of(work)))
    if not np.abs(there - here).max() <= SAME_LAW * np.abs(here).max():
        raise ArgumentError("wall", wall_of, allowed)
    tangent = Tangent(problem, state.gap, wall_of)
    load = tangent.load.holding(tangent.area)
    if not load.work < 0:
        raise NotConvergedError("no derivative of the threshold: at this area the load does not fall as the work rises")
    return -load.heights / load.work


class LeastLoad(NamedTuple):
    """Where the load along a path is least, between two states: by them it is known also where the law has a kink."""

    below: PathState
    """The nearer one, from which on the load falls."""
    above: PathState
    share: float
    """Weight of the first with which the slopes of the load, weighted and added, vanish."""
    heights: Real
    """Derivative of the least load by all heights: that of the load at a given gap, weighted so."""


def least_load(problem: ContactProblem, state: PathState, settings: Settings) -> LeastLoad:
    """The place next to a state where the load is stationary along the path, by steps and then Brent's method.

    Each state starts from the last one that was nearer, so that its contacts are kept.

    Raises
    ------
    NotConvergedError
        If there is none on the way, as contact is lost in a jump, or nothing pulls.
    """
    wall, control, solver = problem.wall, nearness(problem), solver_of(problem, settings)
    if wall.law is None or not wall.work_of_adhesion > 0:
        raise ArgumentError("wall", wall, LAW_NEEDED)
    none = "no gradient of the pull-off: next to this state the load has no smooth minimum"
    slope = Tangent(problem, state.gap).load
    seen = [(height(problem, state), state, slope)]

    def slope_at(place: float) -> float:
        if known := [one for one in seen if one[0] == place]:
            return known[0][2].nearness
        start = max((one for one in seen if one[0] <= place), default=min(seen, key=itemgetter(0)), key=itemgetter(0))
        found = equilibrium(problem, control, place, settings, start[1].gap, state.branch, solver).require()
        seen.append((place, found, Tangent(problem, found.gap).load))
        return seen[-1][2].nearness

    if slope.nearness == 0:
        raise NotConvergedError(none)
    step = FIRST_STEP * wall.range * -np.sign(slope.nearness)
    for _ in range(STEPS):
        last = seen[-1][2].nearness
        if slope_at(seen[-1][0] + step) * last < 0:
            break
        step = float(np.clip(2 * step, -LARGEST_STEP * wall.range, LARGEST_STEP * wall.range))
    ends = sorted(seen[-2:], key=itemgetter(0))
    if not ends[0][2].nearness < 0 < ends[1][2].nearness:
        raise NotConvergedError(none)
    scipy.optimize.brentq(slope_at, ends[0][0], ends[1][0], xtol=SMALLEST_STEP * wall.range, rtol=1e-15)
    low = max((one for one in seen if one[2].nearness < 0), key=itemgetter(0))
    high = min((one for one in seen if one[2].nearness >= 0), key=itemgetter(0))
    width, fall, rise = high[0] - low[0], low[2].nearness, high[2].nearness
    if not (low[1].load < 0 and abs(high[1].load - low[1].load) <= (rise - fall) * width - SMALLEST_JUMP * low[1].load):
        raise NotConvergedError(none)
    share = rise / (rise - fall)
    return LeastLoad(low[1], high[1], share, share * low[2].heights + (1 - share) * high[2].heights)


def _of_number(number: Callable[[Tangent], Derivative], question: _Question) -> Real:
    return question.at_given(question.tangent, number)


def _of_the_threshold(question: _Question) -> Real:
    question.refuse_at("at the threshold area and load are held")
    allowed = "a function that returns the law of a work of adhesion, as LennardJonesSpline(adhesion_length=w)"
    if not callable(question.wall_of):
        raise ArgumentError("wall", question.wall_of, allowed)
    return threshold_gradient(question.problem, question.state, question.wall_of)


def _of_the_pull_off(question: _Question) -> Real:
    """The derivative of the largest tension: by the envelope theorem the mean gap need not be followed."""
    question.refuse_at("at pull-off the load is stationary")
    return -least_load(question.problem, question.state, question.settings).heights


def gradient(
    problem: ContactProblem,
    state: PathState,
    settings: Settings,
    number: Number,
    *,
    at: Given | None = None,
    wall_of: WallOfWork | None = None,
) -> Real:
    """The derivative of a number by all heights: as :meth:`continuum.front.contact.State.gradient` says."""
    function("wall", wall_of)
    state.require()
    known: Number = choice("number", number, get_args(Number))
    return _GRADIENTS[known](_Question(problem, state, settings, at, wall_of))


_GRADIENTS: Mapping[Number, Callable[[_Question], Real]] = {
    "load": partial(_of_number, _NUMBERS["pressure"]),
    "area": partial(_of_number, _NUMBERS["area"]),
    "threshold": _of_the_threshold,
    "pull_off": _of_the_pull_off,
}


def noise_error(grid: Grid, gradient: Real, rms: float, correlation_length: float = 0.0) -> float:
    """Standard deviation of a quantity if the heights have noise: sqrt(Σ g²) σ for independent points.

    To first order in the noise: it must be small compared with the range of the attraction and the gaps beside the
    contact.  A known change dh of the heights, such as a scar, changes the quantity by the sum of g dh.

    Parameters
    ----------
    grid : the points of the surface.
    gradient : g, the derivative of the quantity with respect to the height of every point, shape ``grid.shape``, in
        the unit of the quantity per a0.
    rms : σ, the root mean square of the noise, in a0.
    correlation_length : ξ of noise whose correlation over a distance r is exp(-r²/ξ²), in a0, at most half
        of the shorter period; 0 for independent points.

    Returns
    -------
    float
        In the unit of the quantity.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> c.noise_error(c.Grid.square(2), np.ones((2, 2)), 0.1)
    0.2
    """
    instance("grid", grid, Grid)
    g = field_of("gradient", gradient, grid.shape)
    sigma = number("rms", rms, least=0)
    length = number("correlation_length", correlation_length, least=0, most=grid.shortest_period / 2)
    if length == 0:
        return float(sigma * np.sqrt((g**2).sum()))
    offsets = (np.minimum(x, period - x) for x, period in zip(grid.positions, grid.lengths, strict=True))
    with np.errstate(over="ignore"):  # of a length far below the spacing
        correlation = np.exp(-sum((x / length) ** 2 for x in offsets))
    neighbours = grid.size * grid.inverse(grid.forward(correlation) * grid.forward(g), overwrite=True)
    return float(sigma * np.sqrt(max(0.0, (g * neighbours).sum())))
