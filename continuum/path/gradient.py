"""Which heights decide: the gradients that a state is asked for, from the derivatives of its numbers.

The threshold is an implicit function: with N and A functions of mean gap, work of adhesion w and heights,
dw/dh = -(dN/dh)/(dN/dw), both at a given area.  At its least along a path the load is stationary, and by the envelope
theorem its derivative is that at a given gap.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from typing import Literal, NamedTuple, get_args

import numpy as np
import scipy

from continuum.arguments import ArgumentError, choice, function
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.derivative import Derivative, Tangent
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import PathState, height, nearness
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import NotConvergedError, Settings

Number = Literal["load", "area", "threshold", "pull_off"]
_RENAMED: Mapping[str, Number] = {"turn": "threshold"}
Given = Literal["mean_gap", "separation", "pressure", "area"]

SMALLEST_JUMP = 1e-3
"""Change of the load from one side of its minimum to the other, relative, from which on it is a jump."""
STEPS, LARGEST_STEP, FIRST_STEP, SMALLEST_STEP = 40, 0.1, 0.02, 1e-6
"""Steps to the least load: their number, and lengths in ranges of the wall; the last is the width of its bracket."""
SAME_LAW = 1e-6
"""Largest difference of two laws that are the same, of the largest traction: works may be rounded numbers."""
LAW_NEEDED = "a law with attraction: under a hard wall the load has a gradient, but nothing that pulls"


def _load(tangent: Tangent) -> Derivative:
    return tangent.load


def _area(tangent: Tangent) -> Derivative:
    return tangent.area


_NUMBERS: Mapping[Given, Callable[[Tangent], Derivative]] = {
    "mean_gap": lambda tangent: tangent.mean_gap,
    "separation": lambda tangent: tangent.separation,
    "pressure": _load,
    "area": _area,
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
    known: Number = choice("number", _RENAMED.get(str(number), number), get_args(Number))
    return _GRADIENTS[known](_Question(problem, state, settings, at, wall_of))


_GRADIENTS: Mapping[Number, Callable[[_Question], Real]] = {
    "load": partial(_of_number, _load),
    "area": partial(_of_number, _area),
    "threshold": _of_the_threshold,
    "pull_off": _of_the_pull_off,
}
