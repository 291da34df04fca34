"""Equilibrium under a hard wall: a quadratic energy, diagonal in Fourier space, with a bound at each point.

Primal and dual of one another, with z = offset - u and G = 1/K::

    min over u   ½ <u, K u> - F <u>        z >= 0
    min over p   ½ <p, G p> + <p, offset>  p >= 0         u = (F - p)/K

At the minimum p >= 0, z >= 0 and p z = 0 at each point.  The dual is solved: its unknowns are the pressures of the
contact alone.  Conjugate gradients on the points that press or overlap, after Polonsky and Keer, Wear 231, 206 (1999);
a step that would pull is cut at p = 0 and taken only if the energy falls, shortened if need be (two-metric projection:
Bertsekas, SIAM J. Control Optim. 20, 221 (1982)).

What makes it fast is the preconditioner: K between the points of the contact, its kernel in real space cut off by a
triangular window along x and y.  The window keeps it positive (its spectrum is Fejer's kernel) and takes the images
out, so that nothing needs to be known of K but its spectrum.  The mean mode enters by the rank-one formula of Sherman
and Morrison, whose limit of no mean stiffness is a given mean pressure.  An iteration costs two pairs of transforms,
two and a half if its step was cut.

No contact mechanics here beyond the bound: K and the offset are all that it knows.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from continuum.model.grid import Grid, Real, block_edges
from continuum.solve.cpu import pressing
from continuum.solve.cpu.levels import SMALLEST, memory, sum_over
from continuum.solve.solution import Iteration, Settings, Solution, Status, Work

__all__ = ["constrain"]

COARSE_TOLERANCES = (3e1, 1e2, 1e3, 1e4)
"""Of the start on the grids of n/2, n/4, ... points, in units of the tolerance asked for."""
WINDOW = 0.25
"""Reach of the window of the preconditioner's kernel, in parts of the period."""
STALE = 0.1
"""Change of the contact, in parts of its points, after which M 1 is computed anew."""
COARSE_ITERATIONS = 400
"""Of one coarse grid at most."""
SAFETY = 0.7
"""Part of the tolerance aimed at when the residual computed afresh exceeded it."""
HALVINGS = 30
"""Shortest step that is tried: this power of ½ of the first."""
VERIFICATIONS = 5
"""How often the iteration goes on with a lower tolerance because the residual computed afresh is too large."""
ROUNDING = 1e-13
"""A rise of the energy by this part of its size is none."""


def constrain(
    grid: Grid,
    stiffness_q: Real,
    offset: Real,
    start: Real | None,
    settings: Settings,
    *,
    pressure: float = 0.0,
    lift: float = 0.0,
    mean_stiffness: float | None = None,
) -> Solution:
    """Minimise ½ <u, K u> - F <u> over u with z = offset + lift - u >= 0 at each point.

    Parameters
    ----------
    grid : gives transforms, means and threads.
    stiffness_q : K > 0 over the half spectrum, in E*/a0.
    offset, lift : z at u = 0, an array of shape ``grid.shape`` and a number, in a0.
    start : z at the start, same shape, from which contact and pressure are guessed; None starts on coarser grids.
    settings : when to stop; of it tolerance and iterations are used.
    pressure : F, a uniform pressure along u, in E*; of no effect where the mean of u is held.
    mean_stiffness : K at q = 0 instead of that of ``stiffness_q``.  Infinite holds the mean of u at zero; with none,
        the mean pressure is F.

    Returns
    -------
    Solution
        Its gap is exactly zero where its traction is positive, and positive elsewhere.  Its residual is the
        root-mean-square of K e, e being what closing the contact and lifting the overlaps exactly adds to u: the
        traction by which a surface that fulfils the bound, with this traction, misses its equilibrium.

    Raises
    ------
    ValueError
        If no state exists: F < 0 without mean stiffness (a hard wall cannot pull), or a held mean that overlaps.
    """
    began = time.perf_counter()
    if not np.isfinite(offset).all() or (start is not None and not np.isfinite(start).all()):
        gap = offset if start is None else start
        return Solution(gap, Status.NON_FINITE, np.inf, 0, by=np.zeros(grid.shape))
    if mean_stiffness is None:
        mean_stiffness = float(stiffness_q[0, 0])
    stiffness_q = stiffness_q.copy()
    stiffness_q[0, 0] = mean_stiffness
    offset = offset + lift
    if mean_stiffness == 0 and not pressure >= 0:
        msg = f"a hard wall only pushes: give a mean pressure of zero or more, not {pressure:g}"
        raise ValueError(msg)
    if mean_stiffness == 0 and pressure == 0:
        # First touch of the undeformed surface.
        gap = np.maximum(offset - offset.min(), np.finfo(np.float64).tiny)
        return Solution(gap, Status.CONVERGED, 0.0, 0, by=np.broadcast_to(0.0, grid.shape))
    if np.isinf(mean_stiffness) and not grid.mean(offset) > 0:
        msg = f"a hard wall leaves no surface at a mean gap of {grid.mean(offset):g} a0: it has to be positive"
        raise ValueError(msg)
    if np.isfinite(mean_stiffness) and mean_stiffness > 0:
        offset -= pressure / mean_stiffness
    face = _Face(grid, stiffness_q, offset, pressure)
    coarse: tuple[Work, ...] = ()
    if start is not None:
        face.guess(start)
    else:
        coarse = face.cascade(settings, COARSE_TOLERANCES)
    status, residual, error = face.solve(settings)
    gap, traction = face.settled()
    return Solution(
        gap,
        status,
        residual,
        max(len(face.history) - 1, 0),
        (face.work_done, *coarse),
        time.perf_counter() - began,
        tuple(face.history),
        by=traction,
        gap_error=error,
    )


class _Face:
    """The dual problem on one grid: pressure p, gap z without its level, and what the iteration needs."""

    def __init__(self, grid: Grid, stiffness_q: Real, offset: Real, pressure: float) -> None:
        self.grid, self.stiffness_q, self.offset, self.pressure = grid, stiffness_q, offset, pressure
        self.G = np.divide(1.0, stiffness_q, out=np.zeros_like(stiffness_q), where=stiffness_q > 0)
        self.mean_stiffness = float(stiffness_q[0, 0])
        self.bordered = bool(np.isfinite(self.mean_stiffness))
        self.loaded = self.mean_stiffness == 0
        self.p, self.z, self.t = grid.empty(), grid.empty(), grid.empty()
        self.s, self.m, self.work = grid.empty(), grid.empty(), grid.empty()
        self.mask = np.zeros(grid.shape, dtype=np.bool_)
        self.work_q = grid.empty_q()
        self.single = -1 if grid.shape[1] % 2 else grid.shape_q[1] - 1
        self.shift = self.energy = self.in_m = 0.0
        self.changed = np.inf
        self.history: list[Iteration] = []
        self.transforms, self.trials, self.fft_seconds = 0, 0, 0.0

    @property
    def K(self) -> Real:
        """Stiffness; zero for a mean that is held, which any pressure does."""
        return np.where(np.isfinite(self.stiffness_q), self.stiffness_q, 0.0)

    # --- where it starts -----------------------------------------------------------------------------------

    def guess(self, start: Real) -> None:
        """Pressure from a gap near the solution: the traction that holds it, where that and the gap make a contact."""
        self.work[...] = self.offset - start
        self._forward(self.work)
        self.work_q *= -self.K
        self._inverse(self.work)
        traction = self.work
        if not self.bordered:
            # The mean is held by an unknown pressure: there is none where the gap is wide.
            traction -= traction[start >= self.grid.mean(start)].mean()
        elif self.loaded:
            traction += self.pressure
        beyond = start - max(float(start.min()), 0.0)
        self.p[...] = np.where(traction > self.K.max() * beyond, np.maximum(traction, 0.0), 0.0)
        self._carry_the_load(float(self.p.sum()))

    def cascade(self, settings: Settings, factors: tuple[float, ...]) -> tuple[Work, ...]:
        """Pressure from coarser grids, each started by the next; returns their work."""
        coarser = self.grid.coarser
        if coarser is None or min(self.grid.shape) <= SMALLEST or not factors:
            self._carry_the_load(0.0)
            return ()
        rows, columns = coarser.shape_q
        cut = np.r_[: rows // 2, self.grid.shape[0] - rows // 2 : self.grid.shape[0]]
        offset = self.offset[::2, ::2]
        offset = offset + (self.grid.mean(self.offset) - coarser.mean(offset))
        below = _Face(coarser, self.stiffness_q[cut, :columns], offset, self.pressure)
        work = below.cascade(settings, factors[1:])
        below.descend(settings.tolerance * factors[0], COARSE_ITERATIONS)
        self._carry_the_load(float(self._sweep(pressing.spread, below.p, self.p)[0]))
        return below.work_done, *work

    def _carry_the_load(self, total: float) -> None:
        """Scale p to the mean pressure, if that is given; where there is no p, that of flat surfaces."""
        if not np.isfinite(total) or (self.bordered and total <= 0):
            self.p[...] = self.pressure if self.loaded else max(0.0, -self.mean_stiffness * self.grid.mean(self.offset))
        elif self.loaded:
            self.p *= self.pressure * self.grid.size / total

    # --- the iteration -------------------------------------------------------------------------------------

    def solve(self, settings: Settings) -> tuple[Status, float, float]:
        """Iterate until the residual computed afresh is small; returns it and the largest error of the gap."""
        bound, status, residual, error = settings.tolerance, Status.LINE_SEARCH, np.inf, np.inf
        for _ in range(VERIFICATIONS):
            status = self.descend(bound, settings.max_iterations)
            residual, error = self._residual()
            if not status.ok or residual <= settings.tolerance:
                return status, residual, error
            bound *= SAFETY * settings.tolerance / residual
        return Status.LINE_SEARCH, residual, error

    def descend(self, bound: float, limit: int) -> Status:
        """Conjugate gradients on the contact, which is found anew in each iteration."""
        size = self.grid.size
        if not self.history:
            self._open()
        self._refresh()
        self.work[...] = 0.0
        self.t[...] = 0.0
        beta = zs_before = step = 0.0
        while True:
            sums = self._precondition()
            residual = float(np.sqrt(sums[0] / size))
            zs, ys, in_t, zt, zm = sums[1:6]
            self.history.append(Iteration(residual, self.energy, step))
            if not np.isfinite(residual):
                return Status.NON_FINITE
            if residual <= bound:
                return Status.CONVERGED
            if len(self.history) > limit:
                return Status.ITERATION_LIMIT
            # Polak and Ribiere's beta; what it keeps of the last direction has to keep the mean pressure too.
            beta = max(0.0, ys / zs_before) if zs_before > 0 else 0.0
            weight = self._share(in_t)
            slope = zs + beta * (zt - weight * zm)
            if not slope > 0:
                beta, slope = 0.0, zs
            zs_before = zs
            self._sweep(pressing.turn, self.mask, self.t, self.s, self.m, beta, weight, self.work)
            step = self._step(slope / size)
            if not np.isfinite(step):
                if beta == 0:
                    return Status.LINE_SEARCH
                # Steepest descent from the same state.
                self.t[...] = self.work[...] = 0.0
                zs_before = step = 0.0

    def _precondition(self) -> Real:
        """The contact, s = M z on it, and the sums of `pressing.correct`.

        With m about M 1 on the contact, N points, D = N K_0 + sum(m) and Q = 1 - m 1^T/D it is
        s = Q M Q^T z + m (m^T z) N K_0/D²: symmetric and positive whatever m, and Sherman and Morrison's for m = M 1.
        """
        find = pressing.select, self.p, self.z, self._level(), self.mask, self.m
        count, changed, mz, self.in_m = self._sweep(*find)[:4]
        self.changed += changed
        if self.bordered and self.changed > STALE * count:
            self.changed = 0.0
            self.m[...] = self.mask
            if not self._stiffen(self.m) > 0:
                self.m[...] = self.mask
            mz, self.in_m = self._sweep(*find)[2:4]
        off = self._share(mz)
        self._sweep(pressing.contact, self.mask, self.z, -off, self.s)
        weight = self._share(self._stiffen(self.s))
        if self.bordered:
            weight -= self._share(off) * self.mean_stiffness * self.grid.size
        return self._sweep(pressing.correct, self.mask, self.z, self.work, self.t, self.s, self.m, weight)

    def _level(self) -> float:
        """What the mean mode will add to the gap: it makes the contact close on average, weighted by m.

        Under a given load the gap has no level but this one.
        """
        mz, m = self._sweep(pressing.level, self.p, self.z, self.m)[:2] if self.bordered else (0.0, 0.0)
        whole = self.mean_stiffness * self.grid.size + m
        return float(-mz / whole) if self.bordered and whole > 0 else 0.0

    def _share(self, total: float) -> float:
        """What a field of this sum loses to the mean mode, in parts of m."""
        whole = self.mean_stiffness * self.grid.size + self.in_m
        return total / whole if self.bordered and whole > 0 else 0.0

    def _stiffen(self, values: Real) -> float:
        """Windowed K between the points of the contact, of values that vanish off it; returns the sum."""
        self._forward(values)
        self.work_q *= self.windowed_q
        self._inverse(values)
        return float(self._sweep(pressing.narrow, self.mask, values)[0])

    def _open(self) -> None:
        """Make the preconditioner, the spectrum of K with its kernel in real space cut off by a triangular window."""
        self.work_q[...] = self.K
        self.work_q[0, 0] = 0.0  # the mean mode has its own way, and a stiff one would smear over the longest waves
        kernel = self.work
        self._inverse(kernel)
        for axis, n in enumerate(self.grid.shape):
            distance = np.minimum(np.arange(n), n - np.arange(n))
            window = np.maximum(0.0, 1 - distance / (WINDOW * n))
            kernel *= window[:, None] if axis == 0 else window[None, :]
        self._forward(kernel)
        self.windowed_q = np.maximum(self.work_q.real, 0.0)
        self.m[...] = 1.0

    def _step(self, slope: float) -> float:
        """Go along -t to the minimum, or as far as the bound lets the energy fall; returns the length, NaN for none."""
        self._forward(self.work)
        curvature = self._comply()
        step = slope / curvature if curvature > 0 else np.nan
        for halving in range(HALVINGS):
            cut, before, after = self._sweep(pressing.trial, self.p, self.t, step, self.s)[:3]
            if not np.isfinite(after):
                break
            self.trials += 1
            if cut == 0 and halving == 0:
                self._inverse(self.work)
                self._sweep(pressing.advance, self.z, step, self.work)
                self.p, self.s = self.s, self.p
                self.energy -= 0.5 * step * slope
                return step
            # The cut adds pressure; the mean stays what it was, since a soft mean mode would not forgive it.
            if self.bordered and 0 < before < after:
                self.s *= before / after
            energy, scale = self._gap(self.s, self.work)
            if energy <= self.energy + ROUNDING * scale:
                self._sweep(pressing.accept, self.z, self.work)
                self.p, self.s = self.s, self.p
                self.energy = energy
                return step
            step /= 2
        return np.nan

    def _gap(self, pressure: Real, out: Real) -> tuple[float, float]:
        """Gap under a pressure, without its level; energy of the dual, and the size of what it is the sum of."""
        self._forward(pressure)
        self._comply()
        self._inverse(out)
        energy, scale = self._sweep(pressing.arrive, pressure, self.offset, out)[:2] / self.grid.size
        return float(energy), float(scale)

    def _refresh(self) -> None:
        self.energy, _ = self._gap(self.p, self.z)

    def _residual(self) -> tuple[float, float]:
        """Residual and largest error of the gap, with z computed afresh."""
        if self.loaded:
            self._carry_the_load(float(self.p.sum()))
        self._refresh()
        self.shift = self._level() if self.loaded else 0.0
        self._sweep(pressing.misses, self.p, self.z, self.shift, self.work)
        self._forward(self.work)
        self.work_q *= self.K
        return float(np.sqrt(self.grid.inner_q(self.work_q, self.work_q))), float(np.abs(self.work).max())

    def settled(self) -> tuple[Real, Real]:
        """The gap, with contact closed and overlaps lifted, positive if only just off the contact; and the pressure."""
        del self.t, self.s, self.m, self.work, self.work_q
        self.z += self.shift
        np.maximum(self.z, np.finfo(np.float64).tiny, out=self.z)
        self.z[self.p > 0] = 0.0
        return np.ascontiguousarray(self.z), np.ascontiguousarray(self.p)

    # --- transforms and sweeps -----------------------------------------------------------------------------

    @property
    def work_done(self) -> Work:
        """What was done on this grid."""
        return Work(self.grid.shape, self.transforms / 2, self.trials, self.fft_seconds)

    def _forward(self, values: Real) -> None:
        began = time.perf_counter()
        self.grid.forward(values, out=self.work_q)
        self.fft_seconds += time.perf_counter() - began
        self.transforms += 1

    def _inverse(self, out: Real) -> None:
        began = time.perf_counter()
        self.grid.inverse(self.work_q, out=out, overwrite=True)
        self.fft_seconds += time.perf_counter() - began
        self.transforms += 1

    def _comply(self) -> float:
        """Spectrum of G f from that of f; returns <f, G f>."""
        spectrum = memory(self.work_q)[:, : 2 * self.G.shape[1]]
        return float(self._sweep(pressing.compliance, spectrum, self.G, self.single)[0])

    def _sweep(self, kernel: Callable[..., None], *arguments: object) -> Real:
        rows, size = self.grid.shape[0], self.grid.size
        threads = self.grid.threads if size >= 2**17 else 1
        return sum_over(lambda a, b, sums: kernel(a, b, sums, *arguments), block_edges(rows, size), threads)[0]
