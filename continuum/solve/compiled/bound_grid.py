"""The grid of the bound-constrained solver on processor cores, in the words of :mod:`continuum.solve.grids`."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from continuum.model.fourier import Real, cut
from continuum.model.grid import Grid
from continuum.solve.backend import SMALLEST_GAP, factor_of, most_work
from continuum.solve.compiled import near_field, pressing
from continuum.solve.compiled.compiling import TILE, Mask
from continuum.solve.compiled.contact_fields import ContactPasses
from continuum.solve.compiled.near_field import SIDE
from continuum.solve.compiled.passes import Given, Sweep, Task, reused
from continuum.solve.compiled.tiles import MOST, Tiles
from continuum.solve.solution import Work


class CompiledBoundGrid(ContactPasses):
    """Pressure p, gap z, direction t over the points of one grid, and the preconditioner M.

    A trial lies in s.  The gap and p are made anew for each problem, since what is handed out is their memory.

    Parameters
    ----------
    grid : points and periods.
    stiffness_q : K over the half spectrum, shape ``grid.shape_q``, in E*/a0; at q = 0 that of each problem counts, and
        what is not finite counts as zero.
    threads : of this process that the passes may use.
    smallest : grids of no more points along a side have no coarser one.
    """

    mean_stiffness = most = np.nan
    _wide = _least = np.nan
    """Mean of the start, and its smallest gap, at least zero."""
    p: Real
    z: Real
    below: CompiledBoundGrid | None = None

    def __init__(self, grid: Grid, stiffness_q: Real, threads: int, smallest: int) -> None:
        super().__init__(grid, np.array(stiffness_q, order="C"), threads)
        self._as_given = stiffness_q, threads, smallest
        self.offset = reused(self.rows(), *grid.shape)
        self.t, self.s, self.m, self.change = (self.rows() for _ in range(4))
        waves = self.K.ravel()[1:]
        self.stiffest, self.softest = float(max(waves.max(), SMALLEST_GAP)), float(waves.min())

    @property
    def work(self) -> Work:
        return self.own_work

    # --- the problem -------------------------------------------------------------------------------------------

    def set_problem(
        self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float, most: float
    ) -> bool:
        self._hold(mean_stiffness, most)
        self.offset[:, : self.n] = offset
        if not np.isfinite(offset.sum()):
            return False
        if start is not None:
            self.z[:, : self.n] = start
            if not np.isfinite(start.sum()):
                return False
            self._wide, self._least = self.grid.mean(start), max(float(start.min()), 0.0)
        self.offset += lift
        self.offset += -sink
        self.forget_work()
        return True

    def _hold(self, mean_stiffness: float, most: float) -> None:
        """Stiffness of the mean; none where it is held, which any pressure does.  Nothing presses yet."""
        self.mean_stiffness, self.most = mean_stiffness, most
        self.p, self.z = self.rows(), self.rows()
        stiffness = mean_stiffness if np.isfinite(mean_stiffness) else 0.0
        self.set_mean_stiffness(stiffness, held=False)
        self.mask[...] = False
        self.m[...] = 1.0
        self._touch_all()

    def set_coarser_problem(self) -> CompiledBoundGrid | None:
        grid, (K, threads, smallest) = self.grid.coarser, self._as_given
        if grid is None or self.grid.narrowest <= smallest:
            return None
        below = CompiledBoundGrid(grid, cut(K, grid.shape_q), threads, smallest)
        every = self.offset[np.ix_(*self.grid.sampled(grid))]
        below.offset[...] = every + (self.grid.mean(self.offset) - grid.mean(every))
        below._hold(self.mean_stiffness, self.most)
        self.below = below
        return below

    def mean_offset(self) -> float:
        return self.grid.mean(self.offset)

    def touch(self) -> Real:
        offset = self._together(self.offset)
        gap: Real = np.maximum(offset - offset.min(), SMALLEST_GAP)
        return gap

    # --- where it starts ---------------------------------------------------------------------------------------

    def guess(self, pressure: float | None) -> None:
        start, traction = self.z[:, : self.n], self.change[:, : self.n]
        np.subtract(self.offset, start, out=traction)
        self.forward(traction)
        self.work_q *= -self.K
        self.inverse(traction)
        self.transforms += 2
        if pressure is None:
            traction -= traction[start >= self._wide].mean()
        else:
            traction += pressure
        stiffest = self.K.max()
        for a, b in pairwise(self.row_edges):
            here = traction[a:b]
            near = here > stiffest * (start[a:b] - self._least)
            self.p[a:b, : self.n] = np.where(near, np.clip(here, 0.0, self.most), 0.0)
        self._touch_all()

    def spread(self) -> float:
        below, self.below = self.below, None
        assert below is not None
        return float(self.sweep(pressing.spread, below.p, below.n, self.p, self.n)[0])

    def fill(self, pressure: float) -> None:
        self.p[...] = pressure
        self._touch_all()

    def scale(self, total: float) -> bool:
        return self._scale(self.p, total, self.total(), self.s)

    def total(self) -> float:
        return float(self.sweep(pressing.total_pressure, self.p, self.n, self.touched)[0])

    def _stretch(self, pressure: Real, factor: float, out: Real, most: float) -> float:
        """Multiply a pressure below the largest; returns its sum."""
        return float(self.sweep(pressing.stretch, pressure, factor, out, most, self.n, self.touched)[0])

    def _scale(self, pressure: Real, wanted: float, total: float, spare: Real) -> bool:
        """Scale a pressure from one sum to another, but where it is the largest; False if no factor does."""
        if np.isinf(self.most):
            self._stretch(pressure, wanted / total, pressure, np.inf)
            return True

        def excess(factor: float, out: Real = spare) -> float:
            return self._stretch(pressure, factor, out, self.most) - wanted

        factor = factor_of(excess)
        if factor is None:
            return False
        excess(factor, pressure)
        return True

    # --- the preconditioner ------------------------------------------------------------------------------------

    def level(self) -> tuple[float, float]:
        mz, m = self.sweep(pressing.level, self.p, self.z, self.most, self.contact)[:2]
        return float(mz), float(m)

    def select(self, level: float) -> tuple[float, float, float, float, float]:
        sums = self.sweep(pressing.select, self.p, self.z, level, self.most, self.lowest, self.contact)
        count, changed, mz, m, eighth = (float(each) for each in sums[:5])
        return count, changed, mz, m, eighth**0.125

    def renew(self) -> None:
        if not self._stiffen(self.m, None, 1.0) > 0:
            self.m[:, : self.n] = self.mask

    def precondition(self, level: float) -> float:
        return self._stiffen(self.s, self.z, level)

    def correct(self, weight: float) -> Real:
        return self.sweep(pressing.correct, self.z, self.change, self.t, self.s, weight, self.contact)

    # --- a step ------------------------------------------------------------------------------------------------

    def clear(self) -> None:
        self.t[...] = self.change[...] = 0.0
        self._touch_all()

    def new_direction(self, beta: float, weight: float) -> None:
        self._loaded(self.change, self._new_direction(beta, weight))

    def _new_direction(self, beta: float, weight: float) -> Sweep:
        """The new direction, copied into the rows of the change that have contact."""
        given = self.t, self.s, beta, weight, self.change, self.contact
        return lambda a, b, sums: pressing.direction_on_contact(a, b, sums, *given)

    def curvature(self) -> float:
        return self._comply()

    def trial(self, step: float) -> tuple[float, float, float]:
        given = self.p, self.t, step, self.s, self.most, self.n, self.touched
        cut_off, before, after = self.sweep(pressing.trial, *given)[:3]
        self.trials += bool(np.isfinite(after))
        return float(cut_off), float(before), float(after)

    def advance(self, step: float) -> None:
        self.spectral(inverse=True)
        self._unloaded(self.change, self._advanced(step))
        self.p, self.s = self.s, self.p

    def _advanced(self, step: float) -> Sweep:
        """The gap after a free step, where the change holds G t."""
        given = self.z, step, self.change, self.n, self.lowest
        return lambda a, b, sums: pressing.advance(a, b, sums, *given)

    def arrive(self, before: float, after: float) -> tuple[float, float]:
        if before != after and not self._scale(self.s, before, after, self.change):
            return np.nan, np.nan
        return self._gap(self.s, self.change)

    def accept(self) -> None:
        self.sweep(pressing.accept, self.z, self.change, self.n)
        self.p, self.s = self.s, self.p

    # --- tiles -------------------------------------------------------------------------------------------------

    def tiles(self, level: float, energy: float, size: float) -> TileGrid | None:
        split = self.split() if np.isinf(self.most) else None
        if split is None or not split.even:
            return None
        nx, ny = self.grid.shape
        marked: Mask = np.zeros((nx // SIDE, ny // SIDE), dtype=np.bool_)
        self.sweep(near_field.mark_tiles, self.p, self.z, -level, self.touched, self.lowest, marked)
        if not self.pays(marked, MOST):
            return None
        split.G_far[0, 0] = self.G[0, 0]
        return TileGrid(self, Tiles(self, split, marked), energy, size)

    def take(self, tiles: TileGrid) -> None:
        for values, field in ((tiles.p, self.p), (tiles.m, self.m)):
            tiles.model.scatter(values, field)
        self.touched[...] = 0
        for a, b in tiles.model.places * SIDE:
            self.touched[a : a + SIDE, b // TILE] = 2

    # --- the outcome -------------------------------------------------------------------------------------------

    def displace(self) -> tuple[float, float]:
        return self._gap(self.p, self.z)

    def _gap(self, pressure: Real, out: Real) -> tuple[float, float]:
        """Gap under a pressure, without its level, and what :meth:`displace` returns."""
        self._loaded(pressure)
        self._comply(inverse=True)
        given = pressure, self.offset, out, self.n, self.touched, self.lowest
        energy, size = self._unloaded(out, lambda a, b, sums: pressing.arrive(a, b, sums, *given))[:2] / self.size
        return float(energy), float(size)

    def misses(self, level: float) -> tuple[float, float]:
        given = self.p, self.z, level, self.change, self.most, self.n, self.worst
        self._loaded(self.change, lambda a, b, sums: pressing.misses(a, b, sums, *given), sparse=False)
        K, weights = self.K, self.weights
        sums = self.spectral(lambda a, b, sums: pressing.missed(a, b, sums, self.w, K, weights), forward=True)
        return float(np.sqrt(sums[0])), float(self.worst.max())

    def duality_gap(self) -> tuple[float, float]:
        least = float(self.lowest.min())  # of the z that was found last, this one
        work, total = self.sweep(pressing.work_above, self.p, self.z, least, self.n, self.touched)[:2] / self.size
        if np.isfinite(self.most):
            work -= most_work(self.z[:, : self.n] - least, total, self.most)
        return float(work), 2 * float(total) * self.softness

    def hand_out(self, level: float) -> tuple[Real, Real]:
        self.sweep(pressing.finish, self.p, self.z, level, SMALLEST_GAP, self.most, self.n)
        gap, traction = self._together(self.z), self._together(self.p)
        del self.z, self.p
        return gap, traction

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        return self.elastic_energy_in(self.s, self.t, offset, gap)


class TileGrid(CompiledBoundGrid):
    """The points of some tiles of a grid, in which all its contact lies, with a model of its response.

    z is that of the grid where it was made; from there on the model says how it changes.
    """

    def __init__(self, whole: CompiledBoundGrid, model: Tiles, energy: float, size: float) -> None:
        # Nothing of a grid: no K, no spectrum.
        self.grid, self.size, self.n, self.model = whole.grid, whole.size, SIDE, model
        self.row_edges, self.softest = model.row_edges, whole.softest
        self.mean_stiffness, self.most, self.trials = whole.mean_stiffness, whole.most, 0
        self._energy, self._terms = energy, size
        self._step = self._curvature = self._found = np.nan
        self.p, self.z, self.offset, self.m = (model.gather(each) for each in (whole.p, whole.z, whole.offset, whole.m))
        self.t, self.s, self.change = (model.field() for _ in range(3))
        self.mask = self.p > 0
        self.touched = np.full((len(self.p), 1), 2, dtype=np.uint8)
        self.lowest = np.full((len(self.p), 1), -np.inf)

    def sweep(self, sweep: Task[Given], *given: Given.args, **named: Given.kwargs) -> Real:
        return self.model.sweep(sweep, *given, **named)

    def _stiffen(self, out: Real, z: Real | None, shift: float) -> float:
        return self.model.stiffen(self.mask, out, self.softest, z, shift)

    def new_direction(self, beta: float, weight: float) -> None:
        self.sweep(self._new_direction(beta, weight))

    def curvature(self) -> float:
        answer = self.model.comply_with(self.t, self.model.answer)
        self._curvature = float(self.sweep(near_field.dot, self.t, answer)[0] / self.size)
        return self._curvature

    def trial(self, step: float) -> tuple[float, float, float]:
        self._step = step
        return super().trial(step)

    def advance(self, step: float) -> None:
        self.change[...] = self.model.answer
        self.sweep(self._advanced(step))
        self.p, self.s = self.s, self.p
        self._energy -= 0.5 * step**2 * self._curvature

    def arrive(self, before: float, after: float) -> tuple[float, float]:
        factor, step, model = before / after, self._step, self.model
        self._stretch(self.s, factor, self.s, np.inf)
        self.sweep(near_field.cut_below, self.p, self.t, step, model.spare)
        cut = model.comply_with(model.spare, model.beside)
        given = self.p, self.z, self.offset, self.s, model.answer, cut, step, factor, self.change
        rise = float(self.sweep(near_field.change, *given)[0])
        self.lowest[...] = -np.inf
        self._found = self._energy + rise / self.size
        return self._found, self._terms

    def accept(self) -> None:
        super().accept()
        self._energy = self._found
