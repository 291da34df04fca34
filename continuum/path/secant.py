"""How the area changes with the mean gap: the steps of a search for an area."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.state import PathState, height

RIGID = (0.2, 100.0)
"""Step of a search at least and at most, in units of the one that would do if the surface moved rigidly: it gives way,
the less there is left to go the more."""
DECAY, FIRST = 2.2, 4.0
"""The area of rough surfaces decays with the mean gap as exp(-2.2 u/h_rms) (Persson, Phys. Rev. Lett. 99, 125502
(2007), has 2 - 2.5); a first step by that, to e times the area, is at most so many times the rigid one.  Beside a
contact the gap rises as the 3/2 power of the distance, so that shorter steps give way the more, as 1/sqrt(ln A)."""
WEAK = 0.3
"""Range, in h_rms, up to which the attraction adds little to the area where a search begins."""


def searched_range(problem: ContactProblem) -> float:
    """Range of the attraction as a search takes it into account, in a0: a cut-off may lie beyond all that is felt."""
    return min(problem.wall.range, problem.wall.effective_range)


def excess_range(problem: ContactProblem) -> float:
    """Range of the attraction beyond that which adds little to the area, in a0."""
    return max(searched_range(problem) - WEAK * float(sample(problem.heights).std()), 0.0)


def attracts_little(problem: ContactProblem) -> bool:
    """Whether a search may count on the area of rough surfaces without adhesion, or nearly so."""
    return problem.wall.range < WEAK * float(sample(problem.heights).std())


def rough_slope(problem: ContactProblem) -> float:
    """Slope d ln(area)/d(mean gap) of a rough surface without adhesion, roughly, in 1/a0; none of a flat one: -inf."""
    rms = float(sample(problem.heights).std())
    return -DECAY / rms if rms > 0 else -np.inf


def asperity_slope(problem: ContactProblem, area: float) -> float:
    """As :func:`rough_slope`, at a small area: by the summits of the surface at hand, of which there may be few.

    That of the area that would overlap, undeformed, about a contact of 1.5 times the area.
    """
    rough, part = rough_slope(problem), np.clip(1.5 * area, 0.0, 1 / 1.3) * np.array([1 / 1.3, 1.3])
    low, high = np.quantile(sample(problem.heights), part)
    return min(0.8 * rough, -2 * np.log(1.3) / float(high - low)) if high > low else rough


def lowest_height(problem: ContactProblem) -> float:
    """Mean gap down to which there are states: in full contact a soft wall gives way below zero_gap, up to its core.

    No separation is too low: a half-space gives way.
    """
    return -np.inf if problem.open_boundary is not None else max(problem.wall.core, problem.wall.bound)


def area_logarithm(area: float, size: int) -> float:
    """The area on a scale on which it is nearly linear in the mean gap: ln A, but -ln(1 - A) beyond half contact.

    Both are joined with one value and slope.  No area, and full contact, count as half a point less.
    """
    half = 0.5 / size
    area = min(max(area, half), 1 - half)
    return float(np.log(area) if area <= 0.5 else 2 * np.log(0.5) - np.log(1 - area))


def area_slope(problem: ContactProblem, one: PathState, other: PathState) -> float:
    """Change of the logarithm of the area from one state to another over that of the mean gap, in 1/a0."""
    size, change = problem.grid.size, height(problem, other) - height(problem, one)
    rise = area_logarithm(other.totals.area_rep, size) - area_logarithm(one.totals.area_rep, size)
    return rise / change if change else np.nan


def secant_fraction(before: PathState, after: PathState, target: float, size: int) -> float:
    """Part of the way from ``before`` to ``after`` at which the secant meets the target."""
    low, high = (area_logarithm(state.totals.area_rep, size) for state in (before, after))
    return float(np.clip((area_logarithm(target, size) - low) / (high - low), 0.02, 0.98))


def step_to(problem: ContactProblem, before: PathState, target: float, slope: float) -> float:
    """Step of the mean gap towards the target, its length.

    The area changes less than if the surface were moved rigidly, which gives the scale.
    """
    wall, gap = problem.wall, sample(before.gap)
    rigid = abs(float(np.quantile(gap, target)) - wall.zero_gap)
    if before.totals.area_rep == 0:
        return rigid
    size = problem.grid.size
    left = abs(area_logarithm(target, size) - area_logarithm(before.totals.area_rep, size))
    (fewest, most), rough = RIGID, left / -asperity_slope(problem, target)
    if slope < 0:
        # Under strong attraction the rigid step ends at the rim of the contact and tells nothing.
        return float(np.clip(left / -slope, fewest * rigid, max(most * rigid, FIRST * rough)))
    if not attracts_little(problem):
        return max(rigid, rough)
    return float(np.clip(rough, rigid, FIRST * rigid / min(left, 1.0) ** 0.5)) if left else rigid


def sample(field: Real) -> Real:
    """Every k-th row and column, about a million points."""
    k = max(1, round((field.size / 1e6) ** 0.5))
    return field[::k, ::k]
