"""Check a state from its gap alone, independently of the solver.

The solver's transforms, compiled laws and sums are not used.  Instead heights and gap are evaluated with SciPy's
complex transforms over the whole spectrum, the traction as a finite difference of the law's energy, and NumPy's sums.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import fft

from continuum.model.fourier import Complex, Real
from continuum.model.open_boundary import OpenBoundary
from continuum.model.problem import ContactProblem
from continuum.model.substrates import TabulatedSubstrate

STEP = 1e-5
"""Step of the differences, in a0: rounding leaves 1e-12 of the traction, a kink of the law about as much as that of its
area on the map."""
DIRECTIONS = 6
"""Number of random displacements along which the energy is tested for a minimum."""
NO_TRACTION = "under a hard wall no traction follows from the gap of a part of a half-space alone"
"""Why a state without periodic images is not certified under a hard wall."""
OUT_OF_REACH = 1e4
"""Height of the wall above the points without wall, in a0: far enough for any law, and no digits are lost."""
SINGLE = 2.0**-24
"""Largest rounding of a number that was stored in single precision, relative to it."""


@dataclass(frozen=True)
class StateCheck:
    """Numbers of a state from its heights and gap; lengths in a0, tractions in E*, areas as fractions of A0."""

    area_rep: float
    uncertain_area: float
    """Number of points whose gap is within rounding of the edge of repulsion."""
    load: float
    """Mean traction of the wall; under a hard wall that of the surface, NaN in full contact."""
    residual: float
    """Root-mean-square residual traction; under a hard wall the violation of its three conditions."""
    rounding: float
    """Residual due to the rounding of the gap."""
    curvature: float
    """Smallest second derivative of the energy along random displacements, in E*/a0; NaN under a hard wall."""


def check_state(problem: ContactProblem, gap: Real, *, rounded: bool, seed: int = 0) -> StateCheck:
    """Evaluate a state from its heights and gap.

    Parameters
    ----------
    problem : its contact.
    gap : shape ``grid.shape``, in a0.
    rounded : whether the gap was stored in single precision.
    seed : seed of the random displacements.

    Raises ValueError for a hard wall without periodic images, where the gap does not determine the traction.
    """
    coarse = SINGLE * float(np.abs(gap).max()) if rounded else 0.0
    if problem.open_boundary is not None:
        return _check_part(problem, problem.open_boundary, gap, coarse, seed)
    return _check(problem, gap, coarse, seed)


def _check(problem: ContactProblem, gap: Real, coarse: float, seed: int) -> StateCheck:
    """Evaluate a state whose gap was rounded by at most ``coarse``."""
    wall, stiffness = problem.wall, _whole(problem)
    # Rounding is uniform within ± coarse, and the response is that of each wave.
    noise = coarse / np.sqrt(3) * float(np.sqrt(np.mean(stiffness**2)))
    elastic = fft.ifft2(stiffness * fft.fft2(problem.heights - gap)).real
    inside = gap < wall.zero_gap
    unsure = float(np.mean(np.abs(gap - wall.zero_gap) <= coarse))
    if wall.law is None:
        load, residual = _hard(gap, -elastic, coarse, wall.hardness)
        return StateCheck(float(np.mean(gap <= coarse)), unsure, load, residual, noise, np.nan)
    traction = _traction(problem, gap)
    off = elastic + traction
    off -= off.mean()  # the base, or a given pressure, holds the mean
    curvature = min(_curvatures(problem, stiffness, gap, seed))
    return StateCheck(
        float(np.mean(inside)), unsure, float(traction.mean()), float(np.sqrt(np.mean(off**2))), noise, curvature
    )


def _check_part(problem: ContactProblem, boundary: OpenBoundary, gap: Real, coarse: float, seed: int) -> StateCheck:
    """Evaluate a state without periodic images: tractions in the window move the surface outside, too."""
    if problem.wall.law is None:
        raise ValueError(NO_TRACTION)
    # Counted from the height at which the gap is the one given, as the heights are.
    displacement = boundary.displacement(_traction(problem, gap))
    inside = boundary.inside(displacement)
    displacement += np.mean(problem.heights - gap - inside)
    inside[...] = problem.heights - gap
    heights = boundary.around(problem.heights, OUT_OF_REACH + float(problem.heights.max()))
    # The periodic surface of twice the size by which an open boundary is computed.
    response = TabulatedSubstrate(boundary.stiffness_q, boundary.grid.lengths, "open boundary")
    doubled = ContactProblem(boundary.grid, problem.wall, heights, response)
    found = _check(doubled, heights - displacement, coarse, seed)
    return replace(
        found,
        area_rep=4 * found.area_rep,
        uncertain_area=4 * found.uncertain_area,
        load=4 * found.load,
        residual=2 * found.residual,
    )


def _whole(problem: ContactProblem) -> Real:
    """K over the whole spectrum, without its mean, from the half that a real field needs."""
    ny, half = problem.grid.shape[1], np.array(problem.stiffness_q)
    half[0, 0] = 0.0
    opposite = np.roll(half[::-1], 1, axis=0)  # K(-qx, qy) = K(qx, -qy)
    return np.concatenate([half, opposite[:, ny - half.shape[1] : 0 : -1]], axis=1)


def _traction(problem: ContactProblem, gap: Real) -> Real:
    """-d energy/d gap, by central differences of fourth order."""
    energy = problem.wall.energy
    near = (energy(gap + STEP) - energy(gap - STEP)) / (2 * STEP)
    far = (energy(gap + 2 * STEP) - energy(gap - 2 * STEP)) / (4 * STEP)
    return -(4 * near - far) / 3


def _curvatures(problem: ContactProblem, stiffness: Real, gap: Real, seed: int) -> list[float]:
    """Second derivatives of the energy along random displacements of unit root-mean-square, from rough to smooth."""
    rng, found = np.random.default_rng(seed), []
    softness = np.where(stiffness > 0, 1 / np.where(stiffness > 0, stiffness, 1.0), 0.0)
    for power in np.linspace(0.0, 4.0, DIRECTIONS):
        along_q: Complex = fft.fft2(rng.normal(size=gap.shape)) * softness**power
        along = fft.ifft2(along_q).real
        along /= np.sqrt(np.mean(along**2))
        elastic = fft.ifft2(stiffness * fft.fft2(along)).real
        change = STEP * along
        law = (_traction(problem, gap - change) - _traction(problem, gap + change)) / (2 * STEP)
        found.append(float(np.mean(along * (elastic + law))))
    return found


def _hard(gap: Real, pressure: Real, coarse: float, hardness: float) -> tuple[float, float]:
    """Load, and violation of the conditions of a hard wall: no overlap except where it yields, no tension, no pressure
    above the hardness, and none at a distance.  The elastic pressure is known up to its mean, which makes it vanish
    beside the contact, or equal the hardness where the wall yields.
    """
    touching, yields = gap <= coarse, (gap < -coarse) & np.isfinite(hardness)
    if not touching.any():
        return 0.0, float(np.sqrt(np.mean(pressure**2)))
    known = yields | ~touching
    # In full contact, where nothing yields, any mean is one, from the least that holds no tension on.
    level = np.mean(pressure[known] - np.where(yields[known], hardness, 0.0)) if known.any() else pressure.min()
    pressure = pressure - level
    broken = np.where(touching, pressure - np.clip(pressure, 0.0, hardness), pressure)
    broken = np.where(yields, pressure - hardness, broken)
    overlap = np.where(yields, 0.0, np.minimum(gap + coarse, 0.0))
    load = float(pressure.mean()) if known.any() else np.nan
    return load, float(np.sqrt(np.mean(broken**2) + np.mean(overlap**2)))
