"""Check a state from its gap alone, independently of the solver.

The solver's transforms, compiled laws and sums are not used.  Instead heights and gap are evaluated with SciPy's
complex transforms over the whole spectrum, the traction as a finite difference of the law's energy, and NumPy's sums.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy

from continuum.measure.outline import Mask
from continuum.model.eigenvalue import lowest_eigenvalue
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.surface import Moments
from continuum.model.walls import Wall

STEP = 1e-5
"""Step of the differences, in a0: rounding leaves 1e-12 of the traction, a kink of the law about as much as that of its
area on the map."""
ACCURACY = 1e-3
"""Residual of the eigenvector at which to stop, relative to the largest softening, or to K of the longest wave."""
NO_TRACTION = "under a hard wall no traction follows from the gap of a part of a half-space alone"
"""Reason why a state without periodic images is not certified under a hard wall."""
SINGLE = float(np.finfo(np.float32).eps) / 2
"""Largest rounding of a number that was stored in single precision, relative to it."""
TINY = float(np.finfo(np.float32).smallest_subnormal)
"""Smallest number in single precision: below, a gap may become zero, or zero a gap."""


class Check(NamedTuple):
    """Comparison of one quantity: stored or expected value, value found, and their difference."""

    quantity: str
    stored: float
    found: float
    off: float
    """Difference between stored and found value; for a map, the fraction of points that differ."""
    allowed: float
    meaning: str = ""
    """Meaning of a disagreement, if the quantity does not make it clear."""

    @property
    def ok(self) -> bool:
        """True if the difference is allowed; False for NaN."""
        return bool(self.off <= self.allowed)

    @property
    def fault(self) -> str:
        """Description of the disagreement."""
        if np.isnan(self.stored) and np.isnan(self.found) and self.meaning:
            return f"{self.quantity}: {self.meaning}"
        if np.isnan(self.stored) and self.meaning:
            return f"{self.quantity} is {self.found:.7g}, where {self.allowed:.2e} is allowed: {self.meaning}"
        return (
            f"{self.quantity} is {self.found:.7g}, and {self.stored:.7g} is stored or asked for: "
            f"off by {self.off:.2e}, where {self.allowed:.2e} is allowed{self.meaning and ': '}{self.meaning}"
        )


def minimum(lowest: float) -> Check:
    """Check that the lowest eigenvalue of a Hessian is not negative."""
    saddle = "the energy falls along a displacement, so that this is a saddle point"
    return Check("curvature", np.nan, lowest, max(-lowest, 0.0), 0.0, saddle)


def same_text(quantity: str, stored: object, expected: object) -> Check:
    """Check that a text is the one that follows from the input."""
    said = "" if stored == expected else f"{str(stored)[:40]!r} is stored, and {str(expected)[:40]!r} follows"
    return Check(quantity, np.nan, np.nan, 0.0 if stored == expected else np.inf, 0.0, said)


@dataclass(frozen=True, kw_only=True)
class Examination:
    """Checks of one state, and quantities that were not checked."""

    checks: tuple[Check, ...] = ()
    left_out: tuple[str, ...] = ()

    @property
    def faults(self) -> tuple[str, ...]:
        """Descriptions of all disagreements; empty if all numbers agree."""
        return tuple(check.fault for check in self.checks if not check.ok)

    def found_of(self, quantity: str) -> float | None:
        """Value found for a quantity; None if it was not checked."""
        return next((check.found for check in self.checks if check.quantity == quantity), None)


class Found(NamedTuple):
    """A number of a state, and its largest error by the rounding of the gaps to single precision."""

    value: float
    error: float


@dataclass(frozen=True, eq=False)
class StateCheck:
    """Numbers of a state from its heights and gap; lengths in a0, tractions in E*."""

    numbers: dict[str, Found]
    """Numbers that follow from the gap, by the names of a stored point."""
    maps: Mapping[str, tuple[Mask, Mask]] = field(repr=False)
    """Points of the repulsive and of the attracted area, and those whose gap is within rounding of an edge of it."""
    residual: float
    """Root-mean-square residual traction; under a hard wall the violation of its three conditions."""
    rounding: float
    """Residual due to the rounding of the gap."""

    lowest: Found | None = None
    """Lowest eigenvalue of the Hessian, in E*/a0; None under a hard wall, where the energy is convex.  Without periodic
    images it is that of the whole surface, which has the same sign as that of the window."""


def check_state(
    problem: ContactProblem,
    gap: Real,
    *,
    rounded: bool,
    mean_stiffness: float | None = np.inf,
    missed: float = 0.0,
) -> StateCheck:
    """Evaluate a state from its heights and gap.

    Parameters
    ----------
    problem : its contact.
    gap : shape ``grid.shape``, in a0.
    rounded : whether the gap was stored in single precision.
    mean_stiffness : K at q = 0 for the eigenvalue, in E*/a0: 0 where the load is given, infinite where the mean gap is,
        None for that of the substrate.
    missed : difference of each gap from that of the state whose numbers are compared, beyond rounding, in a0.

    Raises ValueError for a hard wall without periodic images, where the gap does not determine the traction.
    """
    coarse = np.maximum(SINGLE * np.abs(gap), TINY) + missed
    with np.errstate(all="ignore"):  # what is not finite fails every comparison
        if problem.wall.law is None:
            return _under_a_bound(problem, gap, coarse, rounded=rounded)
        law = _law(problem.wall, gap, coarse)
        evaluate = _periodic if problem.open_boundary is None else _part
        numbers, residual, rounding = evaluate(problem, gap, law.traction, law.numbers["load"], coarse)
        numbers = {**law.numbers, **_of_gap(gap, coarse), **numbers}
        lowest = _lowest(problem, law.stiffness, mean_stiffness) if np.isfinite(law.stiffness).all() else None
        if lowest is not None and problem.open_boundary is None:
            # Of two eigenvectors that are as accurate, of which one is the solver's.
            numbers["lowest_eigenvalue"] = Found(lowest.value, 2 * lowest.error)
    return StateCheck(numbers, _maps(problem.wall, gap, coarse), residual, rounding if rounded else 0.0, lowest)


def moments_of(problem: ContactProblem) -> Moments:
    """Spectral moments of the heights of a problem, over the whole spectrum."""
    grid, heights = problem.period
    power = np.abs(scipy.fft.fft2(heights - heights.mean()) / heights.size) ** 2
    qx, qy = (
        2 * np.pi * np.fft.fftfreq(n, length / n) for n, length in zip(grid.shape, grid.lengths, strict=True)
    )  # fmt: skip
    q2 = qx[:, None] ** 2 + qy**2
    return Moments(*(float(np.sqrt(np.sum(power * q2**k))) for k in range(3)))


class _Law(NamedTuple):
    """Traction and stiffness of a law at each point, by differences of its energy, and their sums."""

    traction: Real
    stiffness: Real
    numbers: dict[str, Found]


def _law(wall: Wall, gap: Real, coarse: Real) -> _Law:
    """Traction and stiffness by differences of fourth order, with the difference to second order as bound of the error
    at kinks of the law.
    """
    energy, wide = wall.energy, 10 * STEP
    near = (energy(gap + STEP) - energy(gap - STEP)) / (2 * STEP)
    far = (energy(gap + 2 * STEP) - energy(gap - 2 * STEP)) / (4 * STEP)
    here, traction = energy(gap), -(4 * near - far) / 3
    stiffness = (energy(gap + wide) - 2 * here + energy(gap - wide)) / wide**2
    # First the rounding of stored gaps, then the error of the differences where the law has a kink.
    error = (
        float(np.mean(np.abs(stiffness) * coarse + np.abs(far - near))) + 1e-12
    )  # and what rounding leaves of a difference
    numbers = {
        "load": Found(float(traction.mean()), error),
        "load_rep": Found(float(np.maximum(traction, 0.0).mean()), error),
        "load_att": Found(float(np.maximum(-traction, 0.0).mean()), error),
        "wall_energy": _mean(here, np.abs(traction) * coarse),
    }
    return _Law(traction, stiffness, numbers)


def _mean(values: Real, errors: Real) -> Found:
    """Mean of a field with the largest errors of its points, and of the order in which they are summed."""
    return Found(float(values.mean()), float(errors.mean()) + 1e-13 * float(np.abs(values).mean()))


def _of_gap(gap: Real, coarse: Real) -> dict[str, Found]:
    least = np.argmin(gap)
    return {
        "mean_gap": _mean(gap, coarse),
        "smallest_gap": Found(float(gap.flat[least]), float(coarse.flat[least])),
    }


def _maps(wall: Wall, gap: Real, coarse: Real) -> dict[str, tuple[Mask, Mask]]:
    repulsive, end = gap < wall.zero_gap, wall.zero_gap + wall.range
    near = np.abs(gap - wall.zero_gap) <= coarse
    attracted = ~repulsive & (gap < end)
    return {"repulsive": (repulsive, near), "attracted": (attracted, near | (np.abs(gap - end) <= coarse))}


_Parts = tuple[dict[str, Found], float, float]
"""Numbers of the elastic surface, residual, and residual due to rounding."""


def _periodic(problem: ContactProblem, gap: Real, traction: Real, load: Found, coarse: Real) -> _Parts:
    """The parts of a periodic surface: heights and gap give the displacement, its elastic traction the residual."""
    stiffness, u = _whole(problem.stiffness_q, gap.shape[1], 0.0), problem.heights - gap
    elastic = _product(stiffness, u)
    off = elastic + traction
    off -= off.mean()  # the base, or a given pressure, holds the mean
    numbers = _of_displacement(problem, u, elastic, load, coarse)
    return numbers, float(np.sqrt(np.mean(off**2))), _noise(stiffness, coarse)


def _of_displacement(problem: ContactProblem, u: Real, elastic: Real, load: Found, coarse: Real) -> dict[str, Found]:
    """Elastic energy and separation of a periodic surface; no separation where the mean is free, or carries a load that
    is not known.
    """
    numbers = {"elastic_energy": _mean(u * elastic / 2, np.abs(elastic) * coarse)}
    k = problem.mean_stiffness
    if k > 0 and (np.isinf(k) or np.isfinite(load.value)):
        sunk = Found(0.0, 0.0) if np.isinf(k) else Found(load.value / k, load.error / k)
        numbers["separation"] = Found(-float(u.mean()) - sunk.value, float(coarse.mean()) + sunk.error)
    return numbers


def _part(problem: ContactProblem, gap: Real, traction: Real, load: Found, coarse: Real) -> _Parts:
    """The parts of a window of a half-space, on the periodic surface of twice its size.

    The residual is the elastic traction of the difference between its displacement and the response to the tractions of
    the window.
    """
    boundary = problem.open_boundary
    assert boundary is not None
    stiffness = _whole(boundary.stiffness_q, boundary.grid.shape[1])
    u = boundary.inside(_product(-1 / stiffness, boundary.around(traction, 0.0)))
    off = problem.heights - gap - u
    separation = -float(off.mean())
    off = _product(stiffness, boundary.around(off + separation, 0.0))
    off -= off.mean()
    numbers = {
        "elastic_energy": Found(-float(np.mean(u * traction)) / 2, float(np.abs(u).max()) * load.error),
        "separation": Found(separation, float(coarse.mean()) + load.error / boundary.mean_stiffness),
    }
    return numbers, 2 * float(np.sqrt(np.mean(off**2))), _noise(stiffness, coarse)


def _noise(stiffness: Real, coarse: Real) -> float:
    """Elastic traction of rounding errors: uniform within ± coarse, and each wave responds."""
    return float(np.sqrt(np.mean(coarse**2) / 3 * np.mean(stiffness**2)))


def _whole(stiffness_q: Real, ny: int, mean: float | None = None) -> Real:
    """K over the whole spectrum, from the half that a real field needs, with another K at q = 0 if one is given."""
    half = np.array(stiffness_q)
    half[0, 0] = half[0, 0] if mean is None else mean
    opposite = np.roll(half[::-1], 1, axis=0)  # K(-qx, qy) = K(qx, -qy)
    return np.concatenate([half, opposite[:, ny - half.shape[1] : 0 : -1]], axis=1)


def _product(spectrum: Real, values: Real) -> Real:
    product: Real = scipy.fft.ifft2(spectrum * scipy.fft.fft2(values)).real
    return product


def _lowest(problem: ContactProblem, law: Real, mean_stiffness: float | None) -> Found:
    """Lowest eigenvalue of K + φ'', without its mean mode where that is held."""
    boundary = problem.open_boundary
    stiffness_q, grid = problem.stiffness_q, problem.grid
    if boundary is not None:
        stiffness_q, grid, law = boundary.stiffness_q, boundary.grid, boundary.around(law, 0.0)
    mean = float(stiffness_q[0, 0]) if mean_stiffness is None else mean_stiffness
    held = bool(np.isinf(mean))
    K = _whole(stiffness_q, grid.shape[1], 0.0 if held else mean)
    softest = max(0.0, -float(law.min()))
    # The unit of the eigenvalue: the largest softening of the law, or the stiffness of the longest wave.
    scale = max(softest, float(K[K > 0].min()))

    def hessian(v: Real) -> Real:
        product: Real = _product(K, v) + law * v
        return product - product.mean() if held else product

    def smooth(v: Real) -> Real:
        return _product(1 / (K + scale), v - held * v.mean())

    # An unstable mode lives where the law softens most, so the search begins there.
    start = np.random.default_rng(1).normal(size=grid.shape) * (np.maximum(-law, 0.0) + 1e-3)
    found = lowest_eigenvalue(hessian, smooth(start)[None], ACCURACY * scale, smooth)
    return Found(found.eigenvalue, max(found.error, ACCURACY * scale))


def _under_a_bound(problem: ContactProblem, gap: Real, coarse: Real, *, rounded: bool) -> StateCheck:
    """The conditions of a hard wall: no overlap except where it yields, no tension, no pressure above the hardness, and
    none at a distance.  The elastic pressure is known up to its mean, which makes it vanish beside the contact, or
    equal the hardness where the wall yields.  A gap of zero is exact in single precision too.
    """
    if problem.open_boundary is not None:
        raise ValueError(NO_TRACTION)
    hardness, stiffness = problem.wall.hardness, _whole(problem.stiffness_q, gap.shape[1], 0.0)
    u, rounding = problem.heights - gap, _noise(stiffness, coarse) if rounded else 0.0
    elastic = _product(stiffness, u)
    touching, yields = gap <= 0.0, (gap < 0.0) & np.isfinite(hardness)
    known = yields | ~touching
    # In full contact, where nothing yields, any mean is one, from the least that holds no tension on.
    off = elastic + np.where(yields, hardness, 0.0)
    pressure = (off[known].mean() if known.any() else elastic.max()) - elastic
    broken = np.where(touching, pressure - np.clip(pressure, 0.0, hardness), pressure)
    broken = np.where(yields, pressure - hardness, broken)
    overlap = np.where(yields, 0.0, np.minimum(gap, 0.0))
    residual = float(np.sqrt(np.mean(broken**2) + np.mean(overlap**2)))
    load = Found(np.nan, np.nan)
    numbers = {"load_att": Found(0.0, 0.0), "wall_energy": _mean(problem.wall.energy(gap), 0 * coarse)}
    if known.any():
        # A mean over the points where the pressure is known has the error of their residual.
        load = Found(float(pressure.mean()), (residual + rounding) / float(np.sqrt(known.mean())) + 1e-12)
        numbers |= {"load": load, "load_rep": load}
    numbers |= {**_of_gap(gap, coarse), **_of_displacement(problem, u, elastic, load, coarse)}
    nowhere = np.zeros(gap.shape, np.bool_)
    open_ = touching & (np.abs(pressure) <= rounding)
    return StateCheck(numbers, {"repulsive": (touching, open_), "attracted": (nowhere, nowhere)}, residual, rounding)
