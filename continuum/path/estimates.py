"""What a surface tells of its contact before it is solved, and one state of the next: where searches begin, and steps.

Areas are compared as the mean pressure that random surfaces without adhesion have there, A = erf(P/P0) with P0 near the
rms traction that flattens the surface (Persson, J. Chem. Phys. 115, 3840 (2001), has the form): its logarithm is nearly
linear in the mean gap, and in the logarithm of the pressure, from first touch up to full contact.
"""

import numpy as np
import scipy

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.path.state import PathState

DECAY, FIRST = 2.2, 4.0
"""The area of rough surfaces decays with the mean gap as exp(-2.2 u/h_rms) (Persson, Phys. Rev. Lett. 99, 125502
(2007), has 2 - 2.5); a first step by that, to e times the area, is at most so many times the rigid one.  Beside a
contact the gap rises as the 3/2 power of the distance, so that shorter steps give way the more, as 1/sqrt(ln A)."""
WEAK = 0.3
"""Range, in h_rms, up to which the attraction adds little to the area where a search begins."""


def sample(grid: Grid, field: Real) -> Real:
    """Every k-th row and column, about a million points."""
    return grid.sample(field, max(1, round((grid.size / 1e6) ** 0.5)))


# --- pressures ---------------------------------------------------------------------------------------------


def area_logarithm(area: float, size: int) -> float:
    """Logarithm of P/P0 of random surfaces at this area; no area, and full contact, count as half a point less."""
    return float(np.log(area_argument(area, size)))


def area_argument(area: float, size: int) -> float:
    """P/P0 of random surfaces at this area, of a grid of so many points."""
    return float(scipy.special.erfinv(np.clip(area, 0.5 / size, 1 - 0.5 / size)))


def _flattening(problem: ContactProblem) -> Real:
    """Traction of a periodic surface without its mean that is held flat, in E*."""
    flat_q = problem.elastic_traction_q(problem.grid.forward(problem.heights))
    problem.grid.mean_mode(flat_q)[...] = 0.0
    return problem.grid.inverse(flat_q, overwrite=True)


def pressure_of_full_contact(problem: ContactProblem) -> float:
    """Mean pressure from which on a periodic surface touches everywhere under a hard wall, in E*."""
    return problem.grid.greatest(_flattening(problem))


def usual_pressure(problem: ContactProblem) -> float:
    """P0, the mean pressure at which random surfaces touch on erf(1) of their area, in E*."""
    if problem.open_boundary is not None:
        return problem.traction_scale / 2
    return problem.grid.deviation(_flattening(problem))


# --- mean gaps ---------------------------------------------------------------------------------------------


def searched_range(problem: ContactProblem) -> float:
    """Range of the attraction as a search takes it into account, in a0: a cut-off may lie beyond all that is felt."""
    return min(problem.wall.range, problem.wall.effective_range)


def attracts_little(problem: ContactProblem) -> bool:
    """Whether a search may count on the area of rough surfaces without adhesion, or nearly so."""
    return problem.wall.range < WEAK * float(sample(problem.grid, problem.heights).std())


def rough_slope(problem: ContactProblem) -> float:
    """Slope d ln(area)/d(mean gap) of a rough surface without adhesion, roughly, in 1/a0; none of a flat one: -inf."""
    rms = float(sample(problem.grid, problem.heights).std())
    return -DECAY / rms if rms > 0 else -np.inf


def asperity_slope(problem: ContactProblem, area: float) -> float:
    """As :func:`rough_slope`, at a small area: by the summits of the surface at hand, of which there may be few.

    That of the area that would overlap, undeformed, about a contact of 1.5 times the area.
    """
    rough, part = rough_slope(problem), np.clip(1.5 * area, 0.0, 1 / 1.3) * np.array([1 / 1.3, 1.3])
    low, high = np.quantile(sample(problem.grid, problem.heights), part)
    return min(0.8 * rough, -2 * np.log(1.3) / float(high - low)) if high > low else rough


def lowest_height(problem: ContactProblem) -> float:
    """Mean gap down to which there are states: in full contact a soft wall gives way below zero_gap, up to its core.

    No separation is too low: a half-space gives way.
    """
    return -np.inf if problem.open_boundary is not None else max(problem.wall.core, problem.wall.bound)


def first_height(problem: ContactProblem, area: float) -> float:
    """Mean gap, or separation, at which about an area touches: where a little more than twice overlaps, undeformed.

    Strong attraction adds what it reaches.
    """
    heights, level = (
        sample(problem.grid, problem.heights),
        problem.mean_height if problem.open_boundary is None else 0.0,
    )
    excess = max(searched_range(problem) - WEAK * float(heights.std()), 0.0)
    for part in (1.2 if attracts_little(problem) else 0.8, 0.5, 0.1, 0.0):
        overlap = float(np.quantile(heights, min(part * area, 1.0)))
        if (at := problem.wall.zero_gap + level - overlap + excess) > lowest_height(problem):
            return at
    return problem.wall.zero_gap + level + searched_range(problem) - float(heights.min())


def step_to(problem: ContactProblem, before: PathState, target: float) -> float:
    """Step of the mean gap towards a larger or smaller area where no slope is known, its length.

    The area changes less than if the surface were moved rigidly, which gives the scale.
    """
    rigid, size = (
        abs(float(np.quantile(sample(problem.grid, before.gap), target)) - problem.wall.zero_gap),
        problem.grid.size,
    )
    left = abs(area_logarithm(target, size) - area_logarithm(before.area_rep, size))
    rough = left / -asperity_slope(problem, target)
    if not attracts_little(problem):
        # Under strong attraction the rigid step ends at the rim of the contact and tells little.
        return max(rigid, rough if before.area_rep else rough / 4)
    if before.area_rep == 0 or not left:
        return rigid
    return float(np.clip(rough, rigid, FIRST * rigid / min(left, 1.0) ** 0.5))
