"""A loading path as a curve of load against distance: stiffness, pull-off, work of separation.

Loads are per A0, in E*, compression positive; distances in a0.  Nothing is known between the points of a path: a jump
appears as a steep piece, and an extreme is that of the points, so that its error is the change to the next point.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from continuum.measure.contact import Equilibrium
from continuum.model.fourier import Real


@dataclass(frozen=True, eq=False)
class Curve:
    """The equilibria of a path in the order in which they were reached."""

    mean_gap: Real
    separation: Real
    """Separation, in a0; NaN if the mean displacement of the substrate is free."""
    load: Real
    retracting: NDArray[np.bool_]
    """True on retraction, False on approach."""

    @classmethod
    def of(cls, points: Sequence[Equilibrium]) -> Self:
        """Build the curve of the equilibria among some points, in their order."""
        columns = [(point.mean_gap, point.separation, point.load) for point in points]
        mean_gap, separation, load = np.array(columns, dtype=np.float64).reshape(-1, 3).T
        return cls(mean_gap, separation, load, np.array([point.branch == "retract" for point in points], dtype=bool))

    def branches(self) -> list[NDArray[np.intp]]:
        """Indices of the points of each stretch in one direction; the point of reversal belongs to both."""
        reversals = np.flatnonzero(np.diff(self.retracting.astype(np.int8))) + 1
        starts = [0, *(reversals - 1)]
        return [np.arange(s, e) for s, e in zip(starts, [*reversals, self.load.size], strict=True) if e > s]


def normal_stiffness(curve: Curve) -> Real:
    """k_N = -dN/d(mean gap) per A0 at each point, in E*/a0; NaN where a stretch has one point.

    Differences of second order along each stretch of approach or retraction; the point of reversal takes that of the
    approach.  In the paper it is proportional to the load, and lowered by adhesion by the factor κ_rep/κ.
    """
    stiffness = np.full(curve.load.size, np.nan)
    for points in reversed(curve.branches()):
        gap, load = curve.mean_gap[points], curve.load[points]
        if points.size > 1 and (np.diff(gap) != 0).all():
            stiffness[points] = -np.gradient(load, gap, edge_order=2 if points.size > 2 else 1)
    return stiffness


@dataclass(frozen=True)
class Adhesion:
    """Pull-off and work of adhesion of a path, per A0."""

    peak_load: float
    """Largest load of the path, in E*, on which pull-off depends."""
    largest_tension: float
    """Largest tension on approach, in E*, not negative: the paper's N_max (Suppl. S-III)."""
    pull_off: float
    """Largest tension on retraction, in E*, not negative; NaN without retraction."""
    work_of_separation: float
    """Work against tension on retraction, in E* a0: from where the load becomes tensile to the end."""
    loss: float
    """Work lost in the cycle, in E* a0: work done on approach less work regained over the same distances."""
    separated: bool
    """True if the tension at the end of the retraction is below 1 % of the pull-off, so that the work is complete."""


def adhesion(curve: Curve) -> Adhesion:
    """Pull-off and work of a path of one approach and one retraction, without which only the tension on approach is
    known.

    Work is the integral of the load over the separation, or over the mean gap if the mean displacement is free, by the
    trapezoidal rule over the points of the path.

    Raises ValueError if there is no point.
    """
    if curve.load.size == 0:
        raise ValueError("the path has no equilibrium, so that nothing can be measured")
    distance = curve.separation if np.isfinite(curve.separation).all() else curve.mean_gap
    away = curve.retracting
    tension = np.maximum(-curve.load, 0.0)
    peak = float(curve.load.max())
    approach = float(tension[~away].max(initial=0.0))
    if not away.any():
        return Adhesion(peak, approach, np.nan, np.nan, np.nan, separated=False)
    last = int(np.argmax(away)) - 1  # the last point of the approach
    back = np.arange(max(last, 0), curve.load.size)
    pull_off = float(tension[back].max())
    work = _tensile_work(distance[back], curve.load[back])
    loss = np.nan
    if last >= 0:
        to, fro = np.arange(last + 1), back
        loss = _overlap_work(distance[to][::-1], curve.load[to][::-1], distance[fro], curve.load[fro])
    return Adhesion(peak, approach, pull_off, work, loss, separated=bool(tension[-1] <= 0.01 * pull_off))


def _tensile_work(distance: Real, load: Real) -> float:
    largest = int(np.argmin(load))
    if load[largest] >= 0:
        return 0.0
    pushing = np.flatnonzero(load[:largest] >= 0)
    first = int(pushing[-1]) if pushing.size else 0
    distance, load = distance[first:], load[first:]
    if pushing.size:  # from where the load crosses zero
        share = load[0] / (load[0] - load[1])
        distance = np.concatenate([[distance[0] + share * (distance[1] - distance[0])], distance[1:]])
        load = np.concatenate([[0.0], load[1:]])
    return float(np.trapezoid(-load, distance))


def _overlap_work(d1: Real, load1: Real, d2: Real, load2: Real) -> float:
    """Integral of load1 - load2 over the distances that both curves cover; both begin where the path reverses."""
    distance = np.unique(np.concatenate([d1, d2]))
    distance = distance[distance <= min(d1[-1], d2[-1])]
    if distance.size < 2 or (np.diff(d1) <= 0).any() or (np.diff(d2) <= 0).any():
        return float("nan")
    difference = np.interp(distance, d1, load1) - np.interp(distance, d2, load2)
    return float(np.trapezoid(difference, distance))
