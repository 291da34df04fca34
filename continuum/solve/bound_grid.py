"""One grid of the bound-constrained solver, in the words of :mod:`continuum.solve.hard`."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import brentq

from continuum.model.fourier import Real, cut
from continuum.model.grid import Grid
from continuum.solve.backend import SMALLEST_GAP, STEEPEST, Array, BoundEngine, TileEngine, reused
from continuum.solve.solution import Work


class BoundGrid:
    """Pressure p, gap z, direction t over the points of one grid, and the preconditioner M.

    z is held without its level, a number.  s = M z and m, about M 1, vanish off the contact, which the mask marks; a
    trial is a pressure that may become p, and lies in s.  Sums are over the points.

    M = Eᵀ K E: a displacement given on the contact is extended by E to the points around it, and what K makes of that
    is taken back by Eᵀ.  On the contact E changes nothing; beside it stands the mean of the contact near by.

    Parameters
    ----------
    back_end : whose engine holds the arrays.
    grid : points and periods.
    stiffness_q : K over the half spectrum, shape ``grid.shape_q``, in E*/a0; at q = 0 that of each problem counts.
    threads : of this process that the engine may use.
    finer : the next finer grid, if there is one.
    """

    below: BoundGrid | None = None
    mean_stiffness, most = 0.0, np.inf
    _wide = _least = 0.0
    """Mean of the start, and its smallest gap, at least zero."""
    p: Array = None
    z: Array = None

    def __init__(
        self, back_end: Any, grid: Grid, stiffness_q: Real, threads: int, finer: BoundGrid | None = None
    ) -> None:
        self.grid, self.size, self._surface = grid, grid.size, (back_end, stiffness_q, threads)
        self.engine: BoundEngine = back_end.bound_engine(grid, stiffness_q, threads, finer.engine if finer else None)
        engine = self.engine
        self.offset = reused(engine.rows(), *grid.shape)
        self.t, self.s, self.m, self.change = (engine.field() for _ in range(4))
        self.mask = engine.mask()
        if engine.KEEPS_FIELDS:
            self._allocate()

    @property
    def work(self) -> Work:
        """What was done for the problem at hand."""
        return self.engine.work

    @cached_property
    def stiffest(self) -> float:
        """K of the stiffest wave."""
        return float(max(self._waves.max(), SMALLEST_GAP))

    @cached_property
    def softest(self) -> float:
        """K of the softest wave."""
        return float(self._waves.min())

    @property
    def _waves(self) -> Real:
        """K of all modes but the mean; what is not finite counts as zero."""
        waves: Real = self._surface[1].ravel()[1:]
        return np.where(np.isfinite(waves), waves, 0.0)

    # --- the problem ---------------------------------------------------------------------------------------

    def set_problem(
        self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float, most: float
    ) -> bool:
        """Set the problem, with p = 0; False if it is not finite.

        The offset is ``offset + lift - sink``, the arrays of shape ``grid.shape``; ``mean_stiffness`` is K at q = 0,
        infinite where the mean of u is held at zero; ``most`` is the largest p.  The start lies in z.
        """
        self._hold(mean_stiffness, most)
        if not self.engine.upload(self.offset, offset):
            return False
        if start is not None:
            if not self.engine.upload(self.z, start):
                return False
            self._wide, self._least = self.grid.mean(start), max(float(start.min()), 0.0)
        self.engine.shift(self.offset, lift)
        self.engine.shift(self.offset, -sink)
        self.engine.forget_work()
        return True

    def _allocate(self) -> None:
        self.p, self.z = self.engine.field(), self.engine.field()

    def _hold(self, mean_stiffness: float, most: float) -> None:
        """Stiffness of the mean; none where it is held, which any pressure does.  Nothing presses yet."""
        self.mean_stiffness, self.most = mean_stiffness, most
        self.engine.set_largest_pressure(most)
        if not self.engine.KEEPS_FIELDS:
            self._allocate()
        self.engine.set_mean_stiffness(mean_stiffness if np.isfinite(mean_stiffness) else 0.0, held=False)
        self.engine.clear_mask(self.mask)
        self.engine.fill(self.p, 0.0)
        self.engine.fill(self.m, 1.0)

    def set_coarser_problem(self) -> BoundGrid | None:
        """The grid of every second point, with its part of the problem; None if there is none.

        It is made for each cold start and not kept: these are rare on a path.
        """
        back_end, stiffness_q, threads = self._surface
        grid = self.grid.coarser
        if grid is None or self.grid.narrowest <= back_end.SMALLEST:
            return None
        below = BoundGrid(back_end, grid, cut(stiffness_q, grid.shape_q), threads, self)
        self.engine.coarsen(self.offset, below.engine, below.offset)
        below._hold(self.mean_stiffness, self.most)
        self.below = below
        return below

    def mean_offset(self) -> float:
        """Mean of the offset."""
        return self.engine.mean(self.offset)

    def touch(self) -> Real:
        """Gap of the undeformed surface at first touch, positive, as an array of the host."""
        offset = self.engine.download(self.offset)
        gap: Real = np.maximum(offset - offset.min(), SMALLEST_GAP)
        return gap

    # --- where it starts -----------------------------------------------------------------------------------

    def guess(self, pressure: float | None) -> None:
        """Set p from the start: where the traction that holds it pushes, and it nearly touches.

        Of that traction the mean is ``pressure``, or, with None, such that there is none where the gap is wide.
        """
        self.engine.guess(self.p, self.z, self.offset, self.change, pressure, self._wide, self._least)

    def spread(self) -> float:
        """Set p from that of the coarser grid, bilinearly; returns its sum.  That grid is not asked again."""
        below, self.below = self.below, None
        assert below is not None
        return float(self.engine.sweep("spread", coarse=below.p, fine=self.p)[0])

    def fill(self, pressure: float) -> None:
        """Set p to a number."""
        self.engine.fill(self.p, pressure)

    def scale(self, total: float) -> bool:
        """Scale p, which is positive somewhere, to a sum; False if its points cannot carry that."""
        return self._scale(self.p, total, self.total(), self.s)

    def total(self) -> float:
        """Sum of p."""
        return self.engine.total(self.p)

    # --- the preconditioner --------------------------------------------------------------------------------

    def level(self) -> tuple[float, float]:
        """Where p presses: sums of m z and of m."""
        mz, m = self.engine.sweep("level", p=self.p, z=self.z, m=self.m)[:2]
        return float(mz), float(m)

    def select(self, level: float) -> tuple[float, float, float, float, float]:
        """Find the contact: the points that press or overlap, but for those that yield.

        Returns how many there are, how many are new or gone, their sums of m z and of m, and about the largest gap or
        overlap of them: never less than that, and more by the eighth root of their number at most.
        """
        sums = self.engine.sweep("select", p=self.p, z=self.z, shift=level, mask=self.mask, m=self.m)
        count, changed, mz, m, eighth = sums[:5]
        return float(count), float(changed), float(mz), float(m), float(eighth) ** 0.125

    def renew(self) -> None:
        """Set m <- M 1 on the contact, or 1 if the sum of that is not positive."""
        if not self.engine.stiffen(self.mask, self.m, self.softest) > 0:
            self.engine.sweep("ones", mask=self.mask, m=self.m)

    def precondition(self, level: float) -> float:
        """Set s <- M (z + level) on the contact; returns its sum."""
        return self.engine.stiffen(self.mask, self.s, self.softest, self.z, level)

    def correct(self, weight: float) -> Real:
        """Set s <- s - weight m, t <- 0 off the contact; sums of s s, z s, (last change of z) s, t, z t, z m."""
        fields = {"z": self.z, "change": self.change, "t": self.t, "s": self.s, "m": self.m}
        return self.engine.sweep("correct", mask=self.mask, weight=weight, **fields)

    # --- a step --------------------------------------------------------------------------------------------

    def clear(self) -> None:
        """Forget t, and the last change of z."""
        self.engine.fill(self.t, 0.0)
        self.engine.fill(self.change, 0.0)

    def turn(self, beta: float, weight: float) -> None:
        """Set t <- s + beta (t - weight m)."""
        fields = {"mask": self.mask, "t": self.t, "s": self.s, "m": self.m}
        self.engine.into("turn_on_contact", beta=beta, weight=weight, out=self.change, **fields)

    def curvature(self) -> float:
        """<t G t>, after :meth:`turn`."""
        return self.engine.comply()

    def trial(self, step: float) -> tuple[float, float, float]:
        """Try p - step t, cut at zero; sums of what was cut, negative, of p - step t, and of the trial."""
        cut_off, before, after = self.engine.sweep("trial", p=self.p, t=self.t, step=step, out=self.s)[:3]
        self.engine.trials += bool(np.isfinite(after))
        return float(cut_off), float(before), float(after)

    def advance(self, step: float) -> None:
        """Accept a trial that was not cut, the first after :meth:`curvature`: p, and z with it."""
        self.engine.spectral(inverse=True)
        self.engine.out_of("advance", z=self.z, step=step, out=self.change)
        self.p, self.s = self.s, self.p

    def arrive(self, before: float, after: float) -> tuple[float, float]:
        """Scale the trial from one sum to another, and find its gap; returns what :meth:`displace` does.

        The energy is infinite if its points cannot carry that sum.
        """
        if before != after and not self._scale(self.s, before, after, self.change):
            return np.inf, 0.0
        return self._gap(self.s, self.change)

    def _scale(self, pressure: Array, wanted: float, total: float, spare: Array) -> bool:
        """Scale a pressure from one sum to another, but where it is the largest; False if no factor does."""
        if np.isinf(self.most):
            self.engine.scale(pressure, wanted / total)
            return True

        def excess(factor: float, out: Array = spare) -> float:
            return float(self.engine.sweep("stretch", p=pressure, factor=factor, out=out)[0]) - wanted

        low, high = 0.0, 1.0
        while excess(high) < 0:
            if high > STEEPEST:
                return False
            low, high = high, 4 * high
        if excess(low) > 0:
            return False
        factor = brentq(excess, low, high, xtol=1e-300, rtol=1e-15)
        excess(float(factor), pressure)
        return True

    def accept(self) -> None:
        """Accept the trial whose gap :meth:`arrive` has found: p and z."""
        self.engine.sweep("accept", z=self.z, new=self.change)
        self.p, self.s = self.s, self.p

    # --- tiles ---------------------------------------------------------------------------------------------

    def tiles(self, level: float, energy: float, size: float) -> TileGrid | None:
        """The tiles that press or overlap, as a grid whose response is nearly this one's; None where that does not pay.

        The energy is that of the state, and the size of what it is the sum of.
        """
        engine = self.engine.tiles(self.p, self.z, -level)
        return None if engine is None else TileGrid(self, engine, energy, size)

    def take(self, tiles: TileGrid) -> None:
        """Set p and m to those of the tiles, beyond which nothing presses."""
        self.engine.take(tiles.engine, tiles.p, self.p)
        self.engine.take(tiles.engine, tiles.m, self.m)

    # --- the outcome ---------------------------------------------------------------------------------------

    def displace(self) -> tuple[float, float]:
        """Set z <- G p + offset; returns the energy of the dual, per point, and the size of what it is the sum of."""
        return self._gap(self.p, self.z)

    def _gap(self, pressure: Array, out: Array) -> tuple[float, float]:
        """Gap under a pressure, without its level, and what :meth:`displace` returns."""
        self.engine.load(pressure)
        self.engine.comply(inverse=True)
        energy, size = self.engine.out_of("arrive", p=pressure, offset=self.offset, out=out)[:2] / self.size
        return float(energy), float(size)

    def misses(self, level: float) -> tuple[float, float]:
        """Root mean square of K e, and largest e: what closing the contact and lifting the overlaps adds to u.

        s, t and the last change of z are lost.
        """
        return self.engine.misses(self.p, self.z, level, self.change, (self.s, self.t))

    def duality_gap(self) -> tuple[float, float]:
        """<p (z - min z)>, and 2 <p> sqrt(Σ 1/K²) over q ≠ 0: what it is at most, for a residual of one."""
        return self.engine.duality_gap(self.p, self.z, (self.change, self.s))

    def hand_out(self, level: float) -> tuple[Real, Real]:
        """The gap, zero where p presses and positive elsewhere, and p: arrays of the host, in a0 and E*."""
        self.engine.sweep("finish", p=self.p, z=self.z, by=level, smallest=SMALLEST_GAP)
        gap, traction = self.engine.download(self.z), self.engine.download(self.p)
        if not self.engine.KEEPS_FIELDS:
            self.z = self.p = None
        return gap, traction

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""
        return self.engine.elastic_energy(offset, gap, self.s, self.t)


class TileGrid(BoundGrid):
    """The points of some tiles of a grid, in which all its contact lies, with a model of its response.

    z is that of the grid where it was made; from there on the model says how it changes.
    """

    def __init__(self, whole: BoundGrid, engine: TileEngine, energy: float, size: float) -> None:
        self.grid, self.size, self._surface = whole.grid, whole.size, whole._surface
        self.engine = self._tiles = engine
        self.mean_stiffness, self.most = whole.mean_stiffness, whole.most
        self._energy, self._terms = energy, size
        self._step = self._curvature = self._found = 0.0
        self.p, self.z, self.offset = (engine.gather(each) for each in (whole.p, whole.z, whole.offset))
        self.m = engine.gather(whole.m)
        self.t, self.s, self.change = (engine.field() for _ in range(3))
        self.mask = self.p > 0

    def curvature(self) -> float:
        """<t G t>, after :meth:`turn`."""
        self._curvature = super().curvature()
        return self._curvature

    def trial(self, step: float) -> tuple[float, float, float]:
        """Try p - step t, cut at zero, as on any grid."""
        self._step = step
        return super().trial(step)

    def advance(self, step: float) -> None:
        """Accept a trial that was not cut and leads to the minimum along t."""
        super().advance(step)
        self._energy -= 0.5 * step**2 * self._curvature

    def arrive(self, before: float, after: float) -> tuple[float, float]:
        """Scale the trial from one sum to another, and find its gap; returns energy and size."""
        factor = before / after
        self.engine.scale(self.s, factor)
        fields = {"p": self.p, "z": self.z, "t": self.t, "offset": self.offset, "new": self.s, "out": self.change}
        self._found = self._energy + self._tiles.alter(self._step, factor, **fields) / self.size
        return self._found, self._terms

    def accept(self) -> None:
        """Accept the trial whose gap was found last."""
        super().accept()
        self._energy = self._found
