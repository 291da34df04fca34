"""Equilibrium under a hard wall: a quadratic energy, diagonal in Fourier space, with a bound at each point.

Primal and dual of one another, with z = offset - u and G = 1/K::

    min over u   ½ <u, K u> - F <u>        z >= 0
    min over p   ½ <p, G p> + <p, offset>  p >= 0         u = (F - p)/K

At the minimum p >= 0, z >= 0 and p z = 0 at each point.  The dual is solved: its unknowns are the pressures of the
contact alone.  Conjugate gradients on the points that press or overlap, after Polonsky and Keer, Wear 231, 206 (1999);
a step that would pull is cut at p = 0 and taken only if the energy falls, shortened if need be (two-metric projection:
Bertsekas, SIAM J. Control Optim. 20, 221 (1982)).

What makes it fast is the preconditioner, which needs no transform of the grid: K between neighbours of the contact, for
what deviates from the means near by, and K on nodes of some eight points' spacing for these means
(:mod:`continuum.solve.compiled.two_levels`).  It is symmetric and positive whatever the contact is.  The mean mode
enters by the rank-one formula of Sherman and Morrison, whose limit of no mean stiffness is a given mean pressure.  An
iteration costs one pair of transforms, one and a half if its step was cut.

On large grids all of this happens on tiles of the contact first, which have a model of the response, and the whole grid
only says what the model missed (:mod:`continuum.solve.compiled.tiles`): four or five pairs of it.

It stops by the largest error of the gap: what closes the contact, or lifts an overlap.  That bounds the residual.

No contact mechanics here beyond the bound: K and the offset are all that it knows.  No field either: those belong to
the grids, whose operations (:class:`continuum.solve.grids.BoundGrid`) return scalars.
"""

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.solve.grids import BoundGrid
from continuum.solve.solution import Iteration, Settings, Solution, Status, Work

COARSE_TOLERANCES = (1e4, 3e4, 1e5, 1e6)
"""Tolerances of the start on the grids of n/2, n/4, ... points, in units of the tolerance asked for."""
STALE = 0.3
"""Change of the contact, in parts of its points, after which M 1 is computed anew."""
COARSE_ITERATIONS = 400
"""Largest number of iterations on a coarser grid."""
GAP_ERROR = 0.2
"""Largest error of the gap, in units of the displacement by which the tolerance moves the stiffest mode.

The residual is a mean over all points, of which few are in contact: alone it would leave gaps of 50 to 100 times
that displacement there.  With a fifth, the tolerance of 1e-6 h'rms at h'rms = 0.1 leaves 1e-8 a0 on a square grid.
"""
SAFETY = 0.7
"""Part of what is allowed that is aimed at when what was computed afresh exceeded it."""
SLOW = 0.5
"""Part of the error of the gap that a correction on tiles may leave, at most."""
MISSED, BEYOND = 0.01, 0.3
"""Part of it to which tiles are solved, about what their response misses; and that of what is asked for, at least."""
HALVINGS = 30
"""Shortest step that is tried: this power of ½ of the first."""
VERIFICATIONS = 5
"""How often the iteration goes on to a smaller error because what was computed afresh is too large."""
ROUNDING, LARGER_ROUNDING = 1e-13, 1e-12
"""A rise of the energy by this part of its size is none; the larger one where pressures are scaled point by point."""


def constrain(
    grid: BoundGrid,
    offset: Real,
    start: Real | None,
    settings: Settings,
    *,
    pressure: float,
    lift: float,
    mean_stiffness: float,
    most: float,
) -> Solution:
    """Minimise ½ <u, K u> - F <u> over u with z = offset + lift - u >= 0 at each point, on a grid that knows K.

    The rest, and what is raised, as for :meth:`continuum.solve.solver.Solver.constrain`.
    """
    began = time.perf_counter()
    sink = pressure / mean_stiffness if 0 < mean_stiffness < np.inf else 0.0
    if not grid.set_problem(offset, start, lift=lift, sink=sink, mean_stiffness=mean_stiffness, most=most):
        points = offset if start is None else start
        return Solution(points, Status.NON_FINITE, np.inf, 0, pressure=np.broadcast_to(0.0, points.shape))
    if mean_stiffness == 0 and not pressure >= 0:
        msg = f"a hard wall only pushes: give a mean pressure of zero or more, not {pressure:g}"
        raise ValueError(msg)
    if mean_stiffness == 0 and not pressure < most:
        msg = f"a wall that gives way at a pressure of {most:g} carries no mean pressure of {pressure:g}"
        raise ValueError(msg)
    if mean_stiffness == 0 and pressure == 0:
        return Solution(grid.touch(), Status.CONVERGED, 0.0, 0, pressure=np.broadcast_to(0.0, offset.shape))
    if np.isinf(mean_stiffness) and np.isinf(most) and not grid.mean_offset() > 0:
        msg = f"a hard wall leaves no surface at a mean gap of {grid.mean_offset():g} a0: it has to be positive"
        raise ValueError(msg)
    dual = _Dual(grid, pressure, mean_stiffness)
    coarse = dual.cascade(settings, COARSE_TOLERANCES) if start is None else dual.guess()
    status, outcome = dual.solve(settings)
    gap, traction = grid.hand_out(dual.level)
    history, work, seconds = tuple(dual.history), (grid.work, *coarse), time.perf_counter() - began
    found = gap, status, outcome.residual, max(len(history) - 1, 0), work, seconds, history
    error, energy, processes = outcome.gap_error, outcome.duality_gap, grid.size // offset.size
    return Solution(*found, pressure=traction, gap_error=error, duality_gap=energy, processes=processes)


class _Outcome(NamedTuple):
    """What the state found misses, from fresh transforms."""

    residual: float
    gap_error: float
    duality_gap: float
    scale: float
    """Largest duality gap that a residual of one leaves."""

    def excess(self, tolerance: float, gap: float) -> float:
        """By which factor the worst of residual, error of the gap and duality gap is too large."""
        allowed = tolerance * self.scale
        energy = self.duality_gap / allowed if self.duality_gap > 0 else 0.0
        return max(self.residual / tolerance, self.gap_error / gap, energy)


class _Dual:
    """The dual problem on one grid: its scalars, and how it is iterated.

    The mean mode is bordered: it enters by the rank-one formula, unless the mean is held.
    """

    def __init__(self, grid: BoundGrid, pressure: float, mean_stiffness: float) -> None:
        self.grid, self.pressure, self.mean_stiffness = grid, pressure, mean_stiffness
        self.bordered = bool(np.isfinite(mean_stiffness))
        self.loaded = mean_stiffness == 0
        self.level = self.energy = self.in_m = self.gap_error = np.nan
        self.changed = np.inf
        self.fresh = False
        """Whether z is that of p by the whole grid's own transforms."""
        self.history: list[Iteration] = []

    # --- where it starts -----------------------------------------------------------------------------------

    def guess(self) -> tuple[Work, ...]:
        """Pressure from a gap near the solution; no work on coarser grids."""
        # A mean that is held is so by an unknown pressure.
        self.grid.guess((self.pressure if self.loaded else 0.0) if self.bordered else None)
        self._carry_the_load(self.grid.total())
        return ()

    def cascade(self, settings: Settings, factors: tuple[float, ...]) -> tuple[Work, ...]:
        """Pressure from coarser grids, each started by the next; returns their work."""
        coarse = self.grid.set_coarser_problem() if factors else None
        if coarse is None:
            self._carry_the_load(0.0)
            return ()
        below = _Dual(coarse, self.pressure, self.mean_stiffness)
        work = below.cascade(settings, factors[1:])
        below.descend(below._allowed(settings.tolerance * factors[0]), COARSE_ITERATIONS)
        self._carry_the_load(self.grid.spread())
        return coarse.work, *work

    def _carry_the_load(self, total: float) -> None:
        """Scale p to the mean pressure, if that is given; where there is no p, that of flat surfaces."""
        if not np.isfinite(total) or (self.bordered and total <= 0):
            mean = self.pressure if self.loaded else max(0.0, -self.mean_stiffness * self.grid.mean_offset())
            self.grid.fill(min(mean, self.grid.most))
        elif self.loaded and not self.grid.scale(self.pressure * self.grid.size):
            self.grid.fill(self.pressure)

    def _allowed(self, tolerance: float) -> float:
        """Largest error of the gap for a tolerance."""
        return GAP_ERROR * tolerance / self.grid.stiffest

    # --- the iteration -------------------------------------------------------------------------------------

    def solve(self, settings: Settings) -> tuple[Status, _Outcome]:
        """Iterate until what is computed afresh is small: error of the gap, residual, bound on that of the energy."""
        gap = allowed = self._allowed(settings.tolerance)
        for _ in range(VERIFICATIONS):
            status = self.descend(gap, settings.max_iterations)
            outcome = self._outcome()
            if not status.ok:
                return status, outcome
            self.history.append(Iteration(outcome.residual, self.energy, 0.0))
            excess = outcome.excess(settings.tolerance, allowed)
            if excess <= 1:
                return status, outcome
            gap *= SAFETY / excess
        return Status.LINE_SEARCH, outcome

    def descend(self, gap: float, limit: int) -> Status:
        """To this error of the gap: on tiles of the contact where that serves, and then on the whole grid."""
        self.fresh = False
        self.energy, size = self.grid.displace()
        return self._correct(gap, limit, size) or self._iterate(gap, limit)

    def _correct(self, gap: float, limit: int, size: float) -> Status | None:
        """Solve on tiles, find what that missed, and again; None where it does not come to an end.

        The tiles have a model of the response.  What it misses, a part of the change of z, is found by one pair of
        transforms of the whole grid: defect correction.
        """
        grid, error, self.changed = self.grid, np.inf, np.inf
        while len(self.history) < limit:
            tiles = grid.tiles(self._level(), self.energy, size)
            if tiles is None:
                return None
            near = _Dual(tiles, self.pressure, self.mean_stiffness)
            near.energy, near.changed = self.energy, self.changed
            near._find_contact()
            self.gap_error = near.gap_error
            if self.gap_error <= gap:
                self.fresh = True
                return Status.CONVERGED
            if not self.gap_error < SLOW * error:
                return None
            error = self.gap_error
            if not near._iterate(max(BEYOND * gap, MISSED * error), limit).ok:
                return None
            self.history.append(Iteration(near.history[0].residual if near.history else 0.0, self.energy, 1.0))
            grid.take(tiles)
            self.changed = 0.0
            self.energy, size = grid.displace()
        return None

    def _iterate(self, gap: float, limit: int) -> Status:
        """Conjugate gradients on the contact, which is found anew in each iteration."""
        grid = self.grid
        grid.clear()
        zs_before = step = 0.0
        while True:
            mz = self._find_contact()
            if self.gap_error <= gap:
                return Status.CONVERGED
            sums = self._precondition(mz)
            residual = float(np.sqrt(sums[0] / grid.size))
            zs, ys, in_t, zt, zm = sums[1:6]
            self.history.append(Iteration(residual, self.energy, step))
            if not np.isfinite(residual):
                return Status.NON_FINITE
            if len(self.history) > limit:
                return Status.ITERATION_LIMIT
            # Polak and Ribiere's beta; what it keeps of the last direction has to keep the mean pressure too.
            beta = max(0.0, ys / zs_before) if zs_before > 0 else 0.0
            weight = self._share(in_t)
            slope = zs + beta * (zt - weight * zm)
            if not slope > 0:
                beta, slope = 0.0, zs
            zs_before = zs
            grid.new_direction(beta, weight)
            step = self._step(slope / grid.size)
            if not np.isfinite(step):
                if beta == 0:
                    return Status.LINE_SEARCH
                # Steepest descent from the same state.
                grid.clear()
                zs_before = step = 0.0

    def _find_contact(self) -> float:
        """Find the contact, and how far its gaps are from closed; returns the sum of m z over it."""
        grid, level = self.grid, self._level()
        count, changed, mz, self.in_m, self.gap_error = grid.select(level)
        self.changed += changed
        if self.bordered and self.changed > STALE * count:
            self.changed = 0.0
            grid.renew()
            _, _, mz, self.in_m, _ = grid.select(level)
        return mz

    def _precondition(self, mz: float) -> Real | Sequence[float]:
        """Set s = M z on the contact; returns the sums of :meth:`continuum.solve.grids.BoundGrid.correct`.

        With m about M 1 on the contact, N points, D = N K_0 + sum(m) and Q = 1 - m 1^T/D it is
        s = Q M Q^T z + m (m^T z) N K_0/D²: symmetric and positive whatever m, and Sherman and Morrison's for m = M 1.
        """
        off = self._share(mz)
        weight = self._share(self.grid.precondition(-off))
        if self.bordered:
            weight -= self._share(off) * self.mean_stiffness * self.grid.size
        return self.grid.correct(weight)

    def _level(self) -> float:
        """What the mean mode will add to the gap: it makes the contact close on average, weighted by m.

        Under a given load the gap has no level but this one.
        """
        mz, m = self.grid.level() if self.bordered else (0.0, 0.0)
        whole = self.mean_stiffness * self.grid.size + m
        return float(-mz / whole) if self.bordered and whole > 0 else 0.0

    def _share(self, total: float) -> float:
        """What a field of this sum loses to the mean mode, in parts of m."""
        whole = self.mean_stiffness * self.grid.size + self.in_m
        return total / whole if self.bordered and whole > 0 else 0.0

    def _step(self, slope: float) -> float:
        """Step along -t to the minimum, or as far as the bound allows; returns the length, NaN for no step down."""
        grid = self.grid
        curvature = grid.curvature()
        step = slope / curvature if curvature > 0 else np.nan
        for halving in range(HALVINGS):
            cut, before, after = grid.trial(step)
            if not np.isfinite(after):
                break
            if cut == 0 and halving == 0:
                grid.advance(step)
                self.energy -= 0.5 * step * slope
                return step
            # The cut adds pressure; the mean stays what it was, since a soft mean mode would not forgive it.
            scaled = self.bordered and before > 0 and (before < after or np.isfinite(grid.most))
            energy, size = grid.arrive(before, after) if scaled else grid.arrive(1.0, 1.0)
            if energy <= self.energy + (ROUNDING if np.isinf(grid.most) else LARGER_ROUNDING) * size:
                grid.accept()
                self.energy = energy
                return step
            step /= 2
        return np.nan

    def _outcome(self) -> _Outcome:
        """Residual, largest error of the gap and duality gap, with z computed afresh.

        The energy is convex: among all pressures p' >= 0 of the same mean, none has an energy lower by more than
        max over p' of <(p - p') z> = <p (z - min z)>, per area: the gap between primal and dual.
        """
        if self.loaded:
            self._carry_the_load(self.grid.total())
        if not self.fresh:
            self.energy, _ = self.grid.displace()
        self.level = self._level() if self.loaded else 0.0
        residual, error = self.grid.misses(self.level)
        return _Outcome(residual, error, *self.grid.duality_gap())
