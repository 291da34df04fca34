"""Large areas of periodic surfaces: a root in the mean pressure.

There the mean gap says little, since hardly any is left.  The mean pressure does: of random surfaces the area is about
erf(P/P0), with P0 near the rms traction that flattens the surface (Persson, J. Chem. Phys. 115, 3840 (2001), has the
form), and attraction adds to P.  So the secant of the inverse error function of the area meets it in a few steps.

Under a hard wall, where the area never falls with it, no other control is needed.  The pressure at which the last
point closes is known there: it is the largest tension by which the flattened surface pulls, max(K h).  What is left of
the surface falls with what is left of that pressure about as a power, so that close to full contact the secant of both
logarithms is taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.aim import Aim, lowest_height
from continuum.path.state import Control, Outcome, PathState, nearness, numbers

FIRST = 0.5
"""Mean pressure of the first trial, in that of full contact."""
MOST_TRIALS = 40
"""After so many the bracket has shrunk to rounding: the area has a jump."""
PRESSURE: Control = "mean-pressure"
LARGE = 0.5
"""Areas beyond this are searched for by mean pressure first."""
LAST_POINTS = 0.995
"""Beyond this the pressure of full contact of a hard wall tells more than random surfaces do: a third of the pairs at
0.999 of 128 x 128 points, but twice as many at 0.99."""
STEEP = 2.0
"""Slopes of the secant, over that of random surfaces, that are believed, and its inverse."""
FEW_TRIALS = 8
"""Mean pressures that are tried: under adhesion the area may jump, or fall, with the pressure."""


def _flattening(problem: ContactProblem) -> Real:
    """Traction of a surface without its mean that is held flat, in E*."""
    flat_q = problem.elastic_traction_q(problem.grid.forward(problem.heights))
    flat_q[0, 0] = 0.0
    return problem.grid.inverse(flat_q, overwrite=True)


def pressure_of_full_contact(problem: ContactProblem) -> float:
    """Mean pressure from which on a periodic surface touches everywhere, in E*."""
    return float(_flattening(problem).max())


def press_towards(aim: Aim, known: list[PathState]) -> PathState | None:
    """Go towards a large area by mean pressure, as far as that leads.

    Parameters
    ----------
    known : the last state before the target, to begin from, or none to begin at rest; it is kept up to date.

    Returns
    -------
    PathState or None
        The numbers of a state beyond the target, if one was met.
    """
    problem, size, after = aim.problem, aim.problem.grid.size, None
    usual = float(np.std(_flattening(problem)))
    wanted, slope = _argument(aim.target, size), usual
    now, last = _Seen(0.0, 0.0, np.nan), None
    if known:
        now = _Seen.of(known[0], size)
    for attempt in range(FEW_TRIALS):
        at, control = now.pressure + slope * (wanted - now.argument), PRESSURE
        if not 0 < at < problem.wall.hardness:
            break
        if last is not None and abs(wanted - now.argument) < abs(now.argument - last.argument):
            # Close to both the mean gap does as well, whose solves are cheaper; a hard wall may leave none.
            secant = (now.mean_gap - last.mean_gap) / (now.argument - last.argument)
            gap = now.mean_gap + secant * (wanted - now.argument)
            at, control = (gap, nearness(problem)) if gap > lowest_height(problem) else (at, control)
        near, start = aim.adhesive and attempt > 2, known[0].gap if known else None
        state = aim.trial(at, aim.loose, start, near=near, control=control)
        if not state.status.ok:
            break
        found = _Seen.of(state, size)
        if (attempt > 0 or known) and found.argument != now.argument:
            slope = (found.pressure - now.pressure) / (found.argument - now.argument)
            slope = float(np.clip(slope, usual / STEEP, usual * STEEP))
            last = now
        now = found
        if aim.met(state) or (aim.short(state, known[0]) if known and aim.adhesive else aim.serves(state)):
            known[:] = [state]
        else:
            after = numbers(state)
        if aim.met(state):
            break
    return after


class _Seen(NamedTuple):
    """What a trial has shown."""

    argument: float
    """Argument of the error function that is its area; full contact, and none, count as half a point less."""
    pressure: float
    mean_gap: float

    @classmethod
    def of(cls, state: PathState, size: int) -> _Seen:
        return cls(_argument(state.area_rep, size), state.load, state.mean_gap)


def _argument(area: float, size: int) -> float:
    return float(scipy.special.erfinv(np.clip(area, 0.5 / size, 1 - 0.5 / size)))


def find_nearly_full(aim: Aim) -> PathState:
    """State of an area close to one, under a hard wall on a periodic surface; none is needed to begin from."""
    full, half = pressure_of_full_contact(aim.problem), 0.5 / aim.problem.grid.size
    if 1 - aim.target <= aim.allowed:
        return aim.done(_full(aim, full))
    wanted = np.log(1 - aim.target + half)
    low: PathState | None = None
    high: PathState | None = None
    # Logarithms of what is left of the pressure and of the surface, where too little touches and where too much does.
    sides: dict[bool, tuple[float, float]] = {}
    left = np.log1p(-FIRST)
    for _ in range(MOST_TRIALS):
        state = _pressed(aim, full * -np.expm1(left), None if low is None else low.gap)
        if not state.status.ok or aim.met(state):
            return aim.done(state)
        short = state.area_rep < aim.target
        low, high = (state, high) if short else (low, numbers(state))
        sides[short] = left, np.log(1 - state.area_rep + half)
        left = _next(sides, wanted)
    assert low is not None
    return aim.done(low, Outcome.JUMPED_OVER, high)


def _pressed(aim: Aim, pressure: float, start: Real | None) -> PathState:
    return aim.trial(pressure, aim.settings, start, control=PRESSURE)


def _full(aim: Aim, full: float) -> PathState:
    """Full contact, under so much more than its pressure that the tolerance leaves no point open."""
    excess = aim.settings.tolerance
    while True:
        state = _pressed(aim, full + excess, None)
        if not state.status.ok or state.area_rep >= aim.target - aim.allowed or excess > full:
            return state
        excess *= 4


def _next(sides: dict[bool, tuple[float, float]], wanted: float) -> float:
    """Next logarithm of what is left of the pressure: by the secant inside a bracket, else farther by two."""
    if len(sides) < 2:
        ((short, (left, _)),) = sides.items()
        return float(left - 2 if short else np.log((1 + 2 * np.exp(left)) / 3))
    (low, above), (high, below) = sides[True], sides[False]
    fraction = (wanted - above) / (below - above) if below != above else 0.5
    return float(low + np.clip(fraction, 0.1, 0.9) * (high - low))
