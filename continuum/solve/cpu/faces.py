"""One grid of the solver under a bound on processor cores: what :class:`continuum.solve.backend.Face` asks for."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from continuum.model.fourier import Real, cut, padded
from continuum.model.grid import Grid
from continuum.solve.cpu import pressing
from continuum.solve.cpu.passes import Passes, lent, memory


class Face(Passes):
    """The arrays of one grid: offset, pressure p, gap z without its level, direction t, and what M needs.

    Parameters
    ----------
    grid, K, threads : as for all passes.
    smallest : grids of no more points along a side have no coarser one.
    """

    start: Real | None = None
    below: Face | None = None
    mean_stiffness = 0.0

    def __init__(self, grid: Grid, K: Real, threads: int, smallest: int) -> None:
        super().__init__(grid, K, threads)
        self.K[~np.isfinite(self.K)] = 0.0
        self.G = np.divide(1.0, self.K, out=np.zeros_like(self.K), where=self.K > 0)
        self.smallest = smallest
        self.offset, self.windowed_q = np.empty(grid.shape), np.empty(grid.shape_q)
        self.p, self.z, self.t, self.s, self.m, self.field = (padded(grid.shape) for _ in range(6))
        self.mask = np.zeros(grid.shape, dtype=np.bool_)
        self.single = -1 if grid.shape[1] % 2 else grid.shape_q[1] - 1

    # --- the problem ---------------------------------------------------------------------------------------

    def pose(self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float) -> bool:
        """Take a problem."""
        if not np.isfinite(offset).all() or (start is not None and not np.isfinite(start).all()):
            return False
        np.add(offset, lift, out=self.offset)
        self.offset -= sink
        self.start = start
        self.z, self.p = padded(self.grid.shape), padded(self.grid.shape)
        self._hold(mean_stiffness)
        self.forget_work()
        return True

    def _hold(self, mean_stiffness: float) -> None:
        """Stiffness of the mean; none where it is held, which any pressure does."""
        self.mean_stiffness = mean_stiffness
        self.K[0, 0] = mean_stiffness if np.isfinite(mean_stiffness) else 0.0
        self.G[0, 0] = 1.0 / mean_stiffness if mean_stiffness > 0 else 0.0
        self.mask[...] = False

    def pose_coarser(self) -> Face | None:
        """The problem on every second point."""
        # Made for each cold start and not kept: these are rare on a path.
        grid = self.grid.coarser
        if grid is None or min(self.grid.shape) <= self.smallest:
            return None
        self.below = Face(grid, cut(self.K, grid.shape_q), self.threads, self.smallest)
        offset = self.offset[::2, ::2]
        self.below.offset = offset + (self.mean_offset() - grid.mean(offset))
        self.below._hold(self.mean_stiffness)
        return self.below

    def mean_offset(self) -> float:
        """Mean gap at rest."""
        return self.grid.mean(self.offset)

    def touch(self) -> Real:
        """First touch."""
        gap: Real = np.maximum(self.offset - self.offset.min(), np.finfo(np.float64).tiny)
        return gap

    # --- where it starts -----------------------------------------------------------------------------------

    def guess(self, pressure: float | None) -> None:
        """Pressure of the start."""
        start, self.start = self.start, None
        assert start is not None
        traction = self.field
        np.subtract(self.offset, start, out=traction)
        self._forward(traction)
        self.work_q *= -self.K
        self._inverse(traction)
        if pressure is None:
            traction -= traction[start >= self.grid.mean(start)].mean()
        else:
            traction += pressure
        lowest, stiffest = max(float(start.min()), 0.0), self.K.max()
        for a, b in pairwise(self.row_edges):
            here = traction[a:b]
            self.p[a:b] = np.where(here > stiffest * (start[a:b] - lowest), np.maximum(here, 0.0), 0.0)

    def spread(self) -> float:
        """Pressure of the coarser grid."""
        below, self.below = self.below, None
        assert below is not None
        return float(self.real(pressing.spread, below.p, self.p)[0])

    def fill(self, pressure: float) -> None:
        """The same pressure everywhere."""
        self.p[...] = pressure

    def scale(self, factor: float) -> None:
        """All pressures times a number."""
        self.p *= factor

    def total(self) -> float:
        """Sum of the pressure."""
        return float(self.p.sum())

    # --- the preconditioner --------------------------------------------------------------------------------

    def open(self, window: float) -> None:
        """Make M."""
        self.work_q[...] = self.K
        self.work_q[0, 0] = 0.0  # the mean mode has its own way, and a stiff one would smear over the longest waves
        kernel = self.field
        self._inverse(kernel)
        for axis, n in enumerate(self.grid.shape):
            distance = np.minimum(np.arange(n), n - np.arange(n))
            weights = np.maximum(0.0, 1 - distance / (window * n))
            kernel *= weights[:, None] if axis == 0 else weights[None, :]
        self._forward(kernel)
        np.maximum(self.work_q.real, 0.0, out=self.windowed_q)
        self.m[...] = 1.0

    def level(self) -> tuple[float, float]:
        """Sums over the points that press."""
        mz, m = self.real(pressing.level, self.p, self.z, self.m)[:2]
        return float(mz), float(m)

    def select(self, level: float) -> tuple[float, float, float, float]:
        """Find the contact."""
        count, changed, mz, m = self.real(pressing.select, self.p, self.z, level, self.mask, self.m)[:4]
        return float(count), float(changed), float(mz), float(m)

    def renew(self) -> None:
        """M 1."""
        self.m[...] = self.mask
        if not self._stiffen(self.m) > 0:
            self.m[...] = self.mask

    def precondition(self, level: float) -> float:
        """M z."""
        self.real(pressing.contact, self.mask, self.z, level, self.s)
        return self._stiffen(self.s)

    def _stiffen(self, values: Real) -> float:
        """Windowed K between the points of the contact, of values that vanish off it; returns the sum."""
        self._forward(values)
        self.work_q *= self.windowed_q
        self._inverse(values)
        return float(self.real(pressing.narrow, self.mask, values)[0])

    def correct(self, weight: float) -> Real:
        """Take the mean mode into account."""
        return self.real(pressing.correct, self.mask, self.z, self.field, self.t, self.s, self.m, weight)

    # --- a step --------------------------------------------------------------------------------------------

    def clear(self) -> None:
        """Forget the direction."""
        self.t[...] = 0.0
        self.field[...] = 0.0

    def turn(self, beta: float, weight: float) -> None:
        """Turn the direction."""
        self.real(pressing.turn, self.mask, self.t, self.s, self.m, beta, weight, self.field)

    def curvature(self) -> float:
        """Along the direction."""
        self._forward(self.field)
        return self._comply()

    def trial(self, step: float) -> tuple[float, float, float]:
        """Pressure after a step."""
        cut_off, before, after = self.real(pressing.trial, self.p, self.t, step, self.s)[:3]
        self.trials += bool(np.isfinite(after))
        return float(cut_off), float(before), float(after)

    def advance(self, step: float) -> None:
        """Take a step that was not cut."""
        self._inverse(self.field)
        self.real(pressing.advance, self.z, step, self.field)
        self.p, self.s = self.s, self.p

    def arrive(self, factor: float) -> tuple[float, float]:
        """Gap after a step that was cut."""
        if factor != 1:
            self.s *= factor
        return self._gap(self.s, self.field)

    def accept(self) -> None:
        """Take it."""
        self.real(pressing.accept, self.z, self.field)
        self.p, self.s = self.s, self.p

    # --- the outcome ---------------------------------------------------------------------------------------

    def displace(self) -> tuple[float, float]:
        """Gap of the pressure."""
        return self._gap(self.p, self.z)

    def misses(self, level: float) -> tuple[float, float]:
        """Residual and largest error of the gap."""
        self.real(pressing.misses, self.p, self.z, level, self.field)
        self._forward(self.field)
        self.work_q *= self.K
        square = float(self.power(*self._spare()).sum())
        return float(np.sqrt(square)), abs(float(np.maximum(self.field.max(), -self.field.min())))

    def duality_gap(self) -> tuple[float, float]:
        """Certificate of p among all pressures of its mean, and its scale."""
        np.subtract(self.z, self.z.min(), out=self.field)
        self.field *= self.p
        softness, _ = self._spare()
        np.multiply(self.G, self.G, out=softness)
        softness *= self.grid.mode_weights
        softness[0, 0] = 0.0
        return self.grid.mean(self.field), 2 * self.grid.mean(self.p) * float(np.sqrt(softness.sum()))

    def take(self, level: float) -> tuple[Real, Real]:
        """Hand gap and pressure out; the next problem has new ones."""
        self.z += level
        np.maximum(self.z, np.finfo(np.float64).tiny, out=self.z)
        self.z[self.p > 0] = 0.0
        gap, traction = _without_padding(self.z), _without_padding(self.p)
        self.z = self.p = np.empty((0, 0))
        return gap, traction

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u, K u> of u = offset - gap without its mean."""
        return self.fluctuation_energy(offset, gap, self.field, *self._spare())

    # --- its parts -----------------------------------------------------------------------------------------

    def _spare(self) -> tuple[Real, Real]:
        """Memory for two real half spectra, where s and t are not in use."""
        return lent(memory(self.s), *self.grid.shape_q), lent(memory(self.t), *self.grid.shape_q)

    def _gap(self, pressure: Real, out: Real) -> tuple[float, float]:
        """Gap under a pressure, without its level; energy of the dual, and the size of what it is the sum of."""
        self._forward(pressure)
        self._comply()
        self._inverse(out)
        energy, size = self.real(pressing.arrive, pressure, self.offset, out)[:2] / self.size
        return float(energy), float(size)

    def _comply(self) -> float:
        """Spectrum of G f from that of f; returns <f, G f>."""
        spectrum = memory(self.work_q)[:, : 2 * self.G.shape[1]]
        return float(self.real(pressing.compliance, spectrum, self.G, self.single)[0])

    def _forward(self, values: Real) -> None:
        self.transforms += 1
        self.forward(values)

    def _inverse(self, out: Real) -> None:
        self.transforms += 1
        self.inverse(out)


def _without_padding(values: Real) -> Real:
    """A field with padded rows, moved together in its own memory."""
    rows, n = values.shape
    flat = memory(values).ravel()
    for i in range(rows):
        flat[i * n : (i + 1) * n] = values[i]
    return flat[: rows * n].reshape(rows, n)
