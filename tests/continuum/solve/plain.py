"""The grids of both solvers in a few lines of NumPy, on whole fields: what their operations say, done word by word.

They know nothing of engines: no padding, no tiles, no spectra kept for later, other transforms.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from continuum.model.fourier import cut
from continuum.model.laws import evaluate
from continuum.solve.solution import Work

SMALLEST = 128


class Grid_:
    """Transforms and means."""

    def __init__(self, grid, stiffness_q) -> None:
        self.grid, self.size, self.K = grid, grid.size, np.array(stiffness_q)
        nx, ny = grid.shape
        m, n = grid.mode_numbers
        self.low = (np.abs(m) < nx / 4) & (n < ny / 4)
        self.short_waves = self.K[:, 1:].max() / 2

    def forward(self, values):
        return np.fft.rfft2(values) / self.size

    def inverse(self, spectrum):
        return np.fft.irfft2(spectrum * self.size, s=self.grid.shape)

    def mean(self, a_q, b_q, modes=True):
        return float(np.sum((a_q * b_q.conj()).real * self.grid.mode_weights * modes))

    def below(self, spectrum):
        """On the coarser grid, without its Nyquist modes."""
        return cut(spectrum * self.low, self.grid.coarser.shape_q)

    def above(self, spectrum):
        nx, ny = self.grid.shape
        whole = np.zeros(self.grid.shape_q, dtype=complex)
        whole[: nx // 4, : ny // 4 + 1] = spectrum[: nx // 4]
        whole[nx - nx // 4 :, : ny // 4 + 1] = spectrum[nx // 4 :]
        return whole * self.low


class Descending(Grid_):
    """What the two grids of the smooth solver share."""

    linear = None

    def _gradient(self, y, shift, coarse):
        if self.held:
            y[0, 0] = self.g[0, 0] = 0.0
        self.g = self.g + y
        self.M = 1 / (self.K + np.where(self.low, shift, self.short_waves) if coarse else self.K + shift)
        self.s, self.y, self.d_q = self.M * self.g, y, self.forward(self.d)
        if self.held:
            self.s[0, 0] = 0.0
        sums = self._sums(~self.low if coarse else True)
        sums[0] = self.mean(self.g, self.g)
        return sums

    def _sums(self, modes):
        s, Ks = self.s, self.K * self.s
        pairs = (self.g, s), (self.y, s), (self.y, self.M * self.y), (s, Ks), (Ks, self.d_q)
        return np.array([0.0, *(self.mean(a, b, modes) for a, b in pairs)])

    def restrict(self, size):
        self.linear.stiffness, self.linear.g = self.stiffness[::2, ::2], self.below(self.g) / size
        self.linear.held = self.held

    def low_modes(self, shift, size):
        self.s = np.where(self.low, -size * self.above(self.linear.x), self.s)
        if self.held:
            self.s[0, 0] = 0.0
        return self._sums(self.low)

    def low_gradient(self, shift):
        self.s = np.where(self.low, self.M * self.g, self.s)
        return self._sums(self.low)

    def _turn(self, beta):
        self.d = beta * self.d - self.inverse(self.s)
        return float(np.mean(self.stiffness * self.d**2))


class PlainLinearGrid(Descending):
    def __init__(self, grid, stiffness_q, coarser) -> None:
        super().__init__(grid, stiffness_q)
        self.linear = coarser

    def relax(self, levels, shift, iterations, reduction):
        return None

    def begin(self):
        self.d, self.x = np.zeros(self.grid.shape), np.zeros(self.grid.shape_q, dtype=complex)

    def gradient(self, shift, alpha, beta, *, coarse, first):
        d = self.forward(self.d)
        self.x = self.x + alpha * d
        y = np.zeros_like(d) if first else alpha * (self.K * d + self.forward(self.stiffness * self.d))
        return self._gradient(y, shift, coarse)

    def turn(self, beta, *, coarse):
        return self._turn(beta)

    def finish(self, shift, alpha, beta, *, coarse):
        self.x = self.x + alpha * self.forward(self.d)


class PlainSmoothGrid(Descending):
    boxes = None

    def __init__(self, grid, stiffness_q, coarser) -> None:
        super().__init__(grid, stiffness_q)
        wanted = coarser and grid.coarser is not None and min(grid.shape) > SMALLEST
        self.coarser = PlainSmoothGrid(grid.coarser, cut(self.K, grid.coarser.shape_q), coarser - 1) if wanted else None
        self.linear = PlainLinearGrid(grid.coarser, self.coarser.K, self.coarser.linear) if wanted else None

    @property
    def work(self):
        return [Work(self.grid.shape, 1.0, 0, 0.0)]

    @property
    def chain(self):
        return [self, *(self.coarser.chain if self.coarser else [])]

    def has_tiles(self, **_):
        return False

    def look(self):
        return self.z

    def set_problem(self, law, offset, start, *, lift, pressure, mean_stiffness):
        self.law, self.offset, self.start, self.pressure = law, offset + lift, start, pressure
        self.held = np.isinf(mean_stiffness)
        self.K[0, 0] = 0.0 if self.held else mean_stiffness
        self.d = np.zeros(self.grid.shape)
        if self.coarser is not None:
            self.linear.K[0, 0] = self.K[0, 0]
            part = np.zeros(self.coarser.grid.shape)
            self.coarser.set_problem(law, part, None, lift=0.0, pressure=pressure, mean_stiffness=mean_stiffness)
        return bool(np.isfinite(self.offset).all() and (start is None or np.isfinite(start).all()))

    def set_coarser_problem(self, *, started):
        self.coarser.offset = self.coarser.inverse(self.below(self.forward(self.offset)))
        if started:
            u = self.coarser.inverse(self.below(self.forward(self.offset - self.z)))
            self.coarser.start = self.coarser.offset - u

    def go_to_start(self):
        u = self.offset - self.start
        self._go_to(u - u.mean() if self.held else u)

    def go_to_zero(self):
        self._go_to(np.zeros(self.grid.shape))

    def go_to_coarser(self):
        self._go_to(self.inverse(self.above(self.coarser.forward(self.coarser.offset - self.coarser.z))))

    def _go_to(self, u):
        self.z = self.offset - u
        self.g = self.K * self.forward(u)
        self.g[0, 0] -= self.pressure
        _, self.change, stiffness = evaluate(self.law, self.z)
        self.stiffness = stiffness.astype(np.float32)  # as kept by a grid of a device

    def gradient(self, shift, alpha, beta, *, coarse, complete):
        d = self.forward(self.d)
        y = np.zeros_like(d) if complete else alpha * self.K * d + self.forward(self.change)
        return self._gradient(y, shift, coarse)

    def turn(self, beta, *, coarse):
        return self._turn(beta)

    def line(self, alpha):
        there = evaluate(self.law, self.z - alpha * self.d)
        change = there[1] - evaluate(self.law, self.z)[1]
        return float(np.mean(change * self.d)), float(np.mean(there[2] * self.d**2))

    def move(self, step, alpha):
        self.z = self.z - step * self.d
        energy, traction, stiffness = evaluate(self.law, self.z)
        self.stiffness = stiffness.astype(np.float32)
        before = evaluate(self.law, self.z + alpha * self.d)
        self.change = traction - before[1]
        second = np.mean(energy - before[0] - alpha * before[1] * self.d)
        return float(np.mean(self.change * self.d)), float(second), float(np.mean(np.abs(energy)))

    def clear(self):
        self.d = np.zeros(self.grid.shape)

    def residual(self):
        self._go_to(self.offset - self.z)
        self.g += self.forward(self.change)
        if self.held:
            self.g[0, 0] = 0.0
        return float(np.sqrt(self.mean(self.g, self.g)))

    def hand_out(self):
        return self.z


def hats(points):
    """Value at each point of the hat functions around the nodes along one direction."""
    nodes = max(round(points / 8), 1)
    distance = np.arange(points)[:, None] * nodes / points - np.arange(nodes)
    return sum(np.maximum(1 - np.abs(distance + period), 0.0) for period in (-nodes, 0, nodes))


class PlainBoundGrid(Grid_):
    @property
    def work(self):
        return Work(self.grid.shape, 1.0, 0, 0.0)

    @property
    def stiffest(self):
        return self.K.ravel()[1:].max()

    def set_problem(self, offset, start, *, lift, sink, mean_stiffness, most):
        self.offset, self.start, self.mean_stiffness, self.most = offset + lift - sink, start, mean_stiffness, most
        self.K[0, 0] = mean_stiffness if np.isfinite(mean_stiffness) else 0.0
        self.G = np.divide(1.0, self.K, out=np.zeros_like(self.K), where=self.K > 0)
        self.mask, self.p = np.zeros(self.grid.shape, dtype=bool), np.zeros(self.grid.shape)
        self.m = np.ones(self.grid.shape)
        return bool(np.isfinite(self.offset).all() and (start is None or np.isfinite(start).all()))

    def set_coarser_problem(self):
        if self.grid.coarser is None or min(self.grid.shape) <= SMALLEST:
            return None
        coarser = self.grid.coarser
        self.coarse = PlainBoundGrid(coarser, cut(self.K, coarser.shape_q))
        every = self.offset[::2, ::2]
        sink = every.mean() - self.offset.mean()
        posed = {"mean_stiffness": self.mean_stiffness, "most": self.most}
        self.coarse.set_problem(every, None, lift=0.0, sink=sink, **posed)
        return self.coarse

    def mean_offset(self):
        return float(self.offset.mean())

    def guess(self, pressure):
        traction = -self.inverse(self.K * self.forward(self.offset - self.start))
        traction -= traction[self.start >= self.start.mean()].mean() if pressure is None else -pressure
        beyond = self.start - max(self.start.min(), 0.0)
        self.p = np.where(traction > self.K.max() * beyond, np.clip(traction, 0.0, self.most), 0.0)

    def spread(self):
        p = self.coarse.p
        self.p = np.zeros(self.grid.shape)
        right = np.roll(p, -1, 1)
        self.p[::2, ::2], self.p[::2, 1::2] = p, (p + right) / 2
        self.p[1::2, ::2] = (p + np.roll(p, -1, 0)) / 2
        self.p[1::2, 1::2] = (p + right + np.roll(p + right, -1, 0)) / 4
        return self.total()

    def fill(self, pressure):
        self.p = np.full(self.grid.shape, pressure)

    def scale(self, total):
        scaled = self._scaled(self.p, total, self.total())
        self.p = self.p if scaled is None else scaled
        return scaled is not None

    def _scaled(self, p, wanted, total):
        if np.isinf(self.most):
            return p * (wanted / total)

        def stretched(factor):
            return np.where(p >= self.most, p, np.minimum(factor * p, self.most))

        if not stretched(0.0).sum() <= wanted <= stretched(1e3).sum():
            return None
        return stretched(brentq(lambda factor: stretched(factor).sum() - wanted, 0.0, 1e3, xtol=1e-300, rtol=1e-15))

    def total(self):
        return float(self.p.sum())

    def displace(self):
        self.z, energy, size = self._gap(self.p)
        return energy, size

    def _gap(self, p):
        z = self.inverse(self.G * self.forward(p)) + self.offset
        size = np.abs(p) * (np.abs(z) + np.abs(self.offset))
        return z, float(np.mean(p * (z + self.offset)) / 2), float(size.mean())

    def clear(self):
        self.t, self.change = np.zeros(self.grid.shape), np.zeros(self.grid.shape)

    def tiles(self, *_):
        return None

    def level(self):
        m = self.m * (self.p > 0) * (self.p < self.most)
        return float((m * self.z).sum()), float(m.sum())

    def select(self, level):
        gap = self.z + level
        mask = ((self.p > 0) | (gap < 0)) & ((self.p < self.most) | (gap > 0))
        changed = np.count_nonzero(mask ^ self.mask)
        self.mask, self.m = mask, self.m * mask
        largest = float((gap[mask] ** 8).sum()) ** 0.125
        return float(mask.sum()), float(changed), float((self.m * self.z).sum()), float(self.m.sum()), largest

    def renew(self):
        ones = self.mask.astype(float)
        self.m = self._stiffened(ones)
        if not self.m.sum() > 0:
            self.m = ones

    def _stiffened(self, values):
        """Eᵀ K E: beside the contact stands its mean within hat functions on every eighth point, or nearly."""
        P, Q = (hats(points) for points in self.grid.shape)

        def near(field):
            return P @ (P.T @ field @ Q) @ Q.T * (P.shape[1] * Q.shape[1] / self.size)

        beside = ~self.mask / (near(self.mask) + 0.1)
        K = np.where(np.arange(self.K.size).reshape(self.K.shape) == 0, self.K.ravel()[1:].min(), self.K)
        held = self.inverse(K * self.forward(values + beside * near(values)))
        return (held + near(beside * held)) * self.mask

    def precondition(self, level):
        self.s = self._stiffened((self.z + level) * self.mask)
        return float(self.s.sum())

    def correct(self, weight):
        self.s, self.t = self.s - weight * self.m, self.t * self.mask
        pairs = (
            (self.s, self.s),
            (self.z, self.s),
            (self.change, self.s),
            (1.0, self.t),
            (self.z, self.t),
            (self.z, self.m),
        )
        return np.array([np.sum(a * b) for a, b in pairs])

    def turn(self, beta, weight):
        self.t = np.where(self.mask, self.s + beta * (self.t - weight * self.m), self.t)

    def curvature(self):
        self.Gt = self.inverse(self.G * self.forward(self.t))
        return float(np.mean(self.t * self.Gt))

    def trial(self, step):
        wanted = self.p - step * self.t
        self.tried = np.clip(wanted, 0.0, self.most)
        return -float(np.abs(wanted - self.tried).sum()), float(wanted.sum()), float(self.tried.sum())

    def advance(self, step):
        self.p, self.change = self.tried, -step * self.Gt
        self.z = self.z + self.change

    def arrive(self, before, after):
        if before != after:
            scaled = self._scaled(self.tried, before, after)
            if scaled is None:
                return np.inf, 0.0
            self.tried = scaled
        self.found, energy, size = self._gap(self.tried)
        return energy, size

    def accept(self):
        self.p, self.change, self.z = self.tried, self.found - self.z, self.found

    def misses(self, level):
        gap = self.z + level
        error = np.where(((self.p > 0) | (gap < 0)) & ((self.p < self.most) | (gap > 0)), gap, 0.0)
        missed = self.K * self.forward(error)
        return float(np.sqrt(self.mean(missed, missed))), float(np.abs(error).max())

    def duality_gap(self):
        modes = np.isfinite(self.K) & (self.K > 0)
        modes[0, 0] = False
        weights = np.broadcast_to(self.grid.mode_weights, self.K.shape)
        scale = 2 * self.p.mean() * np.sqrt((weights[modes] / self.K[modes] ** 2).sum())
        above = self.z - self.z.min()
        least = 0.0
        if np.isfinite(self.most):
            filled = np.clip(self.p.sum() / self.most - np.arange(self.size), 0.0, 1.0)
            least = self.most * float(np.mean(np.sort(above.ravel()) * filled))
        return float((self.p * above).mean()) - least, float(scale)

    def hand_out(self, level):
        gap = self.z + level
        closed = np.where(self.p >= self.most, np.minimum(gap, 0.0), 0.0)
        return np.where(self.p > 0, closed, np.maximum(gap, np.finfo(float).tiny)), self.p
