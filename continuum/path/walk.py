"""The way to a target by steps, so that jumps on it are bracketed, and the largest tension is seen."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from continuum.measure.contact import Totals, totals_of
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.aim import loosened
from continuum.path.equilibrium import equilibrium, moved_rigidly
from continuum.path.state import Branch, Control, Event, Outcome, PathState, Search, coordinate, event
from continuum.solve.solution import Closer, Settings
from continuum.solve.solver import Solver

GROWTH = 2.0
"""Step over the last one, at most, and how much farther than over its length the last change is believed to go on."""
SAFETY = 0.8
"""Next step in units of that on which the contact would depart by the threshold, as its square."""
STEADY = 0.75
"""The largest change of the gap shrinks with the step if it is below this part of that over a wider one."""


class _Way:
    """The steps of a way: where it stands, how far it goes at once, and beyond what it expects something to happen.

    Expected is that the contact changes on as it did on the last step, or not at all; only what departs from both by
    more than the threshold may be a jump.  So it is a bent path that needs short steps, not a steep one.
    """

    def __init__(self, here: float, target: float, search: Search) -> None:
        self.here, self.target, self.search = here, target, search
        self.resolution = search.event_resolution or 0.0
        self.stride, self.last, self.width = target - here, np.zeros(3), np.inf
        self.wider, self.bound, self.reach = np.inf, self.resolution, 0.0
        self.far: tuple[float, Real] | None = None

    def next(self) -> float:
        """Value at which to look next."""
        if self.far is None:
            return self.target if abs(self.stride) >= abs(self.target - self.here) else self.here + self.stride
        at, change = self.far
        steady = self.departs(change, at) <= self.search.event_threshold
        return at if steady or abs(at - self.here) <= self.bound else (self.here + at) / 2

    def departs(self, change: Real, at: float) -> float:
        """How far the change of a contact from here departs from what is expected, as a fraction of A0."""
        expected = self.last * min(abs(at - self.here) / self.width, GROWTH)
        return float(np.minimum(np.abs(change), np.abs(change - expected)).max())

    def refuse(self, at: float, change: Real, moved: float, *, reverses: bool) -> bool:
        """Whether what happens before ``at`` has to be looked at nearer: then it is remembered."""
        jumps = self.departs(change, at) > self.search.event_threshold
        self.bound = self.resolution / 16 if jumps and moved < STEADY * self.wider else self.resolution
        if not (jumps or reverses) or abs(at - self.here) <= self.bound:
            return False
        self.far, self.wider = (at, change if jumps else np.full(3, np.inf)), moved
        return True

    def go(self, at: float, change: Real, moved: float) -> bool:
        """Go on from there; whether that was a jump."""
        departs, threshold = self.departs(change, at), self.search.event_threshold
        jumped, step = departs > threshold and not moved < STEADY * self.wider, at - self.here
        if self.far is not None and at != self.far[0]:
            self.far, self.reach = (self.far[0], self.far[1] - change), max(self.reach, abs(step))
        else:
            if self.far is None and not jumped:
                growth = min(SAFETY * (threshold / departs) ** 0.5, GROWTH) if departs > 0 else GROWTH
                self.stride = growth * step
            else:
                # Beyond what has been bracketed steps are as long as before it.
                longest = min(abs(self.stride), GROWTH * max(self.reach, abs(step)))
                self.stride = float(np.copysign(longest, step))
            self.far, self.wider, self.reach = None, np.inf, 0.0
        if not jumped:
            self.last, self.width = change, abs(step)
        self.here = at
        return jumped


def walk(
    problem: ContactProblem,
    control: Control,
    target: float,
    settings: Settings,
    good: list[PathState],
    branch: Branch,
    search: Search,
    solver: Solver,
) -> PathState:
    """State at a target, with the jumps on the way to it; the last state before it is kept in ``good``.

    The first step is the whole way.  Where a step meets more than is expected of it by the threshold, or pulls off,
    the place is bracketed by halving, each time from the last state before it and strictly in the basin of that, until
    it is as narrow as the resolution.  It is an event if the largest change of the gap does not shrink with the step.
    Where it still does the path is steep, or flats pass through the gap at which repulsion begins: that is looked at
    down to 1/16 of the resolution.

    On the way back, a step on which a load that fell begins to rise is halved in the same way where the load may have
    been the lowest one, so that the largest tension is seen although nothing jumps.
    """
    way = _Way(coordinate(control, good[-1]), target, search)
    events: list[Event] = []
    pairs, solves = 0.0, 0
    lowest = good[-1].load, good[-1].mean_gap
    fell = good[0].load - good[1].load if len(good) == 2 else 0.0
    while True:
        at, before = way.next(), good[-1]
        worth = partial(_worth, problem, before.totals, way, at)
        closer = Closer(settings.tolerance, worth)
        start = moved_rigidly(problem, control, before, at)
        trial = equilibrium(problem, control, at, loosened(settings), start, branch, solver, closer)
        del start
        settings = replace(settings, warm_grids=0)
        left = trial.outcome is Outcome.PULLED_OFF
        if not (left or trial.status.ok):
            break
        change = np.full(3, np.inf) if left else _change(problem, before.totals, trial.totals)
        moved = np.inf if left else _largest_change(before.gap, trial.gap)
        # What lies between is hardly lower than before by more than it fell on the last step.
        rises = 0 > trial.load > before.load and fell > max(before.load - lowest[0], 0.0)
        if not way.refuse(at, change, moved, reverses=branch == "retract" and rises and not left):
            if left or way.go(at, change, moved):
                events.append(event(control, branch, before, trial))
            fell = before.load - trial.load
            lowest = min(lowest, (trial.load, trial.mean_gap))
            if left or at == target:
                break
            good[:] = [trial]
        pairs, solves = pairs + trial.solution.fft_pairs, solves + 1
        del before, trial  # while the next one is looked for, one field is held
    return replace(trial, target=target, events=tuple(events), search_pairs=pairs, search_solves=solves, lowest=lowest)


def _worth(problem: ContactProblem, before: Totals, way: _Way, at: float, gap: Real) -> bool:
    """Whether a trial is more than the end of a step that will be halved, for which a loose one does."""
    if abs(at - way.here) <= way.resolution:
        return True
    change = _change(problem, before, totals_of(problem.grid, problem.wall, gap))
    return way.departs(change, at) <= way.search.event_threshold


def _change(problem: ContactProblem, one: Totals, other: Totals) -> Real:
    """By how much two contacts differ: in repulsive area, in all area, and in attractive load, as fractions of A0."""
    repulsive = other.area_rep - one.area_rep
    load = (other.load_att - one.load_att) / problem.wall.largest_tension
    return np.array([repulsive, repulsive + other.area_att - one.area_att, load])


def _largest_change(before: Real, after: Real) -> float:
    """Largest difference of two gaps, row by row: a field of differences need not be held."""
    return max(float(np.abs(a - b).max()) for a, b in zip(before, after, strict=True))
