"""One grid of the solver under a bound on the device: what :class:`continuum.solve.backend.Face` asks for."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real, cut
from continuum.model.grid import Grid
from continuum.solve.cuda import points, pressing
from continuum.solve.cuda.device import Array, empty
from continuum.solve.cuda.fields import Fields


class Face(Fields):
    """The arrays of one grid: offset, pressure p, gap z without its level, direction t, and what M needs.

    Parameters
    ----------
    grid, K : as for all fields; K at q = 0 is that of each problem.
    smallest : grids of no more points along a side have no coarser one.
    larger : the next finer grid, if there is one.
    """

    below: Face | None = None
    mean_stiffness = 0.0

    def __init__(self, grid: Grid, K: Real, smallest: int, larger: Face | None = None) -> None:
        finite = np.where(np.isfinite(K), K, 0.0)
        super().__init__(grid, finite, larger)
        self.smallest = smallest
        self._stiffness_q = finite
        self.windowed = empty(*grid.shape_q)
        self.offset, self.p, self.z, self.t, self.s, self.m, self.change = (self.field() for _ in range(7))
        self.mask = self.field(np.uint8)

    # --- the problem ---------------------------------------------------------------------------------------

    def pose(self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float) -> bool:
        """Take a problem; the start lies in z."""
        if not self.upload(self.offset, offset) or (start is not None and not self.upload(self.z, start)):
            return False
        self.run(points.shift, self.offset, lift)
        self.run(points.shift, self.offset, -sink)
        self._hold(mean_stiffness)
        self.forget_work()
        return True

    def _hold(self, mean_stiffness: float) -> None:
        """Stiffness of the mean; none where it is held, which any pressure does.  Nothing presses yet."""
        self.mean_stiffness = mean_stiffness
        self.set_mean_stiffness(self._mean)
        self.run(pressing.mark, self.mask, 0)
        self.fill(0.0)

    @property
    def _mean(self) -> float:
        return self.mean_stiffness if np.isfinite(self.mean_stiffness) else 0.0

    def pose_coarser(self) -> Face | None:
        """The problem on every second point."""
        grid = self.grid.coarser
        if grid is None or min(self.grid.shape) <= self.smallest:
            return None
        self.below = Face(grid, cut(self._stiffness_q, grid.shape_q), self.smallest, self)
        self.below.run(points.every_second, self.below.offset, self.offset)
        self.below.run(points.shift, self.below.offset, self.mean_offset() - self.below.mean_offset())
        self.below._hold(self.mean_stiffness)
        return self.below

    def mean_offset(self) -> float:
        """Mean gap at rest."""
        return float(self.sum(points.total, self.offset)[0]) / self.size

    def touch(self) -> Real:
        """First touch."""
        offset = self.offset.copy_to_host()
        gap: Real = np.maximum(offset - offset.min(), np.finfo(np.float64).tiny)
        return gap

    # --- where it starts -----------------------------------------------------------------------------------

    def guess(self, pressure: float | None) -> None:
        """Pressure of the start."""
        mean = float(self.sum(points.total, self.z)[0]) / self.size
        least = max(-float(self.sum(pressing.lowest, self.z, largest=0)[0]), 0.0)
        self.sum(points.displace, self.w, self.z, self.offset, 0.0, self.per_point)
        self.forward()
        self.run(pressing.multiply, self.w, self.K, -1.0)
        self.inverse()
        if pressure is None:
            total, count = self.sum(pressing.wide, self.w, self.z, mean)[:2]
            pressure = -float(total / count)
        modes = self._stiffness_q.ravel()[1:]
        stiffest = max(float(modes.max()), self._mean)
        self.run(pressing.guess, self.p, self.w, self.z, pressure, stiffest, least)

    def spread(self) -> float:
        """Pressure of the coarser grid."""
        below, self.below = self.below, None
        assert below is not None
        return float(self.sum(pressing.spread, self.p, below.p)[0])

    def fill(self, pressure: float) -> None:
        """The same pressure everywhere."""
        self.run(points.fill, self.p, pressure)

    def scale(self, factor: float) -> None:
        """All pressures times a number."""
        self.run(pressing.scale, self.p, factor)

    def total(self) -> float:
        """Sum of the pressure."""
        return float(self.sum(points.total, self.p)[0])

    # --- the preconditioner --------------------------------------------------------------------------------

    def open(self, window: float) -> None:
        """Make M."""
        self.run(pressing.kernel_q, self.w, self.K)
        self.inverse()
        self.run(pressing.window, self.w, self.grid.shape[1], window, self.per_point)
        self.forward()
        self.run(pressing.positive, self.windowed, self.w)
        self.run(points.fill, self.m, 1.0)

    def level(self) -> tuple[float, float]:
        """Sums over the points that press."""
        mz, m = self.sum(pressing.level, self.p, self.z, self.m)[:2]
        return float(mz), float(m)

    def select(self, level: float) -> tuple[float, float, float, float]:
        """Find the contact."""
        count, changed, mz, m = self.sum(pressing.select, self.p, self.z, level, self.mask, self.m)[:4]
        return float(count), float(changed), float(mz), float(m)

    def renew(self) -> None:
        """M 1."""
        self.run(pressing.marked, self.w, self.mask, self.per_point)
        if not self._stiffen(self.m) > 0:
            self.run(pressing.ones, self.m, self.mask)

    def precondition(self, level: float) -> float:
        """M z."""
        self.run(pressing.contact, self.w, self.mask, self.z, level, self.per_point)
        return self._stiffen(self.s)

    def _stiffen(self, out: Array) -> float:
        """Windowed K between the points of the contact, of the field in ``w``; returns the sum."""
        self.forward()
        self.run(pressing.multiply, self.w, self.windowed, 1.0)
        self.inverse()
        return float(self.sum(pressing.narrow, out, self.w, self.mask)[0])

    def correct(self, weight: float) -> Real:
        """Take the mean mode into account."""
        return self.sum(pressing.correct, self.mask, self.z, self.change, self.t, self.s, self.m, weight)

    # --- a step --------------------------------------------------------------------------------------------

    def clear(self) -> None:
        """Forget the direction."""
        self.run(points.fill, self.t, 0.0)
        self.run(points.fill, self.change, 0.0)

    def turn(self, beta: float, weight: float) -> None:
        """Turn the direction; it lies in ``w``, too."""
        self.run(pressing.turn, self.w, self.mask, self.t, self.s, self.m, beta, weight, self.per_point)

    def curvature(self) -> float:
        """Along the direction."""
        self.forward()
        return self._comply()

    def trial(self, step: float) -> tuple[float, float, float]:
        """Pressure after a step."""
        cut_off, before, after = self.sum(pressing.trial, self.p, self.t, step, self.s)[:3]
        self.trials += bool(np.isfinite(after))
        return float(cut_off), float(before), float(after)

    def advance(self, step: float) -> None:
        """Take a step that was not cut."""
        self.inverse()
        self.run(pressing.advance, self.z, self.change, self.w, step)
        self.p, self.s = self.s, self.p

    def arrive(self, factor: float) -> tuple[float, float]:
        """Gap after a step that was cut."""
        if factor != 1:
            self.run(pressing.scale, self.s, factor)
        return self._gap(self.s, self.change)

    def accept(self) -> None:
        """Take it."""
        self.run(pressing.accept, self.z, self.change)
        self.p, self.s = self.s, self.p

    # --- the outcome ---------------------------------------------------------------------------------------

    def displace(self) -> tuple[float, float]:
        """Gap of the pressure."""
        return self._gap(self.p, self.z)

    def misses(self, level: float) -> tuple[float, float]:
        """Residual and largest error of the gap."""
        largest = float(self.sum(pressing.misses, self.w, self.p, self.z, level, self.per_point, largest=0)[0])
        self.forward()
        return float(np.sqrt(self.sum(pressing.square, self.w, self.K, self.single)[0])), largest

    def duality_gap(self) -> tuple[float, float]:
        """Certificate of p among all pressures of its mean, and its scale."""
        pz, p, depth = self.sum(pressing.certificate, self.p, self.z, largest=2)[:3]
        K = self._stiffness_q.copy()
        K[0, 0] = np.inf
        softness = float(np.sqrt(np.sum(self.grid.mode_weights / K**2)))
        return float(pz + p * depth) / self.size, 2 * float(p) / self.size * softness

    def take(self, level: float) -> tuple[Real, Real]:
        """Hand gap and pressure out."""
        self.run(pressing.finish, self.p, self.z, level, float(np.finfo(np.float64).tiny))
        return self.z.copy_to_host(), self.p.copy_to_host()

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u, K u> of u = offset - gap without its mean."""
        self.upload(self.s, offset)
        self.upload(self.t, gap)
        return self.fluctuation_energy(self.s, self.t)

    # --- its parts -----------------------------------------------------------------------------------------

    def _gap(self, pressure: Array, out: Array) -> tuple[float, float]:
        """Gap under a pressure, without its level; energy of the dual, and the size of what it is the sum of."""
        self.run(points.into, self.w, pressure, self.per_point)
        self.forward()
        self._comply()
        self.inverse()
        energy, size = self.sum(pressing.arrive, out, pressure, self.offset, self.w)[:2] / self.size
        return float(energy), float(size)

    def _comply(self) -> float:
        """Spectrum of G f from that of f; returns <f, G f>."""
        return float(self.sum(pressing.compliance, self.w, self.K, self.single)[0])
