"""Areas close to full contact under a hard wall: a root in the mean pressure.

There the mean gap says little, since hardly any is left, while the pressure at which the last point closes is known: it
is the largest tension by which the flattened surface pulls, max(K h).  What is left of the surface falls with what is
left of that pressure about as a power, so that the secant of both logarithms meets an area in a few steps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.state import PathState, numbers

NEARLY_FULL = 0.65
"""Areas beyond this are searched for by mean pressure, which is cheaper there."""
FIRST = 0.5
"""Mean pressure of the first trial, in that of full contact."""
MOST_TRIALS = 40
"""After so many the bracket has shrunk to rounding: the area has a jump."""


def pressure_of_full_contact(problem: ContactProblem) -> float:
    """Mean pressure from which on a periodic surface touches everywhere, in E*."""
    flat_q = problem.elastic_traction_q(problem.grid.forward(problem.heights))
    flat_q[0, 0] = 0.0
    return float(problem.grid.inverse(flat_q, overwrite=True).max())


def find_nearly_full(
    problem: ContactProblem,
    target: float,
    allowed: float,
    tolerance: float,
    trial: Callable[[float, Real | None], PathState],
) -> tuple[PathState, PathState | None]:
    """State of an area close to one, under a hard wall on a periodic surface.

    Parameters
    ----------
    target, allowed : the area, as a fraction of A0, and the largest difference from it.
    tolerance : of the solves, in E*.
    trial : equilibrium at a mean pressure in E*, from a gap to start from.

    Returns
    -------
    PathState, PathState or None
        The state; where no area is so close to the target that before the jump, and with it the one beyond.
    """
    full, half = pressure_of_full_contact(problem), 0.5 / problem.grid.size
    if 1 - target <= allowed:
        return _full(full, target - allowed, tolerance, trial), None
    wanted = np.log(1 - target + half)
    low: PathState | None = None
    high: PathState | None = None
    # Logarithms of what is left of the pressure and of the surface, where too little touches and where too much does.
    sides: dict[bool, tuple[float, float]] = {}
    left = np.log1p(-FIRST)
    for _ in range(MOST_TRIALS):
        state = trial(full * -np.expm1(left), None if low is None else low.gap)
        if not state.status.ok or abs(state.totals.area_rep - target) <= allowed:
            return state, None
        short = state.totals.area_rep < target
        low, high = (state, high) if short else (low, numbers(state))
        sides[short] = left, np.log(1 - state.totals.area_rep + half)
        left = _next(sides, wanted)
    assert low is not None
    assert high is not None
    return low, high


def _full(full: float, least: float, tolerance: float, trial: Callable[[float, Real | None], PathState]) -> PathState:
    """Full contact, under so much more than its pressure that the tolerance leaves no point open."""
    excess = tolerance
    while True:
        state = trial(full + excess, None)
        if not state.status.ok or state.totals.area_rep >= least or excess > full:
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
