"""The grids of the smooth solver, in the words of :mod:`continuum.solve.smooth`, on the engine of any device."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from continuum.model.fourier import Real, cut
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.backend import Array, Engine, LinearEngine, SmoothEngine, all_modes, reused
from continuum.solve.boxes import Boxes
from continuum.solve.solution import Solution, Work


class _Descending:
    """What the two kinds of grids share: spectra of a gradient g and a direction d, and steps of a coarser grid.

    <a b> is the mean of a product over the points, an equal sum over the modes; sums that are an array are six:
    <g g>, <g s>, <y s>, <y M y>, <s K s>, <s K d>, with y the change of the gradient g by the last step, s = M g and
    M = 1/(K + c0): c0 is ``shift``, and larger for short waves beside a coarse step.
    """

    engine: Engine
    stiffness: Array = None
    g: Array
    d: Array
    linear: LinearGrid | None = None
    """The next coarser grid, with the wall linear about the gap of this one."""

    def _modes(self, shift: float, *, coarse: bool) -> dict[str, Any]:
        """Which modes a sweep leaves to the coarser grid, and c0 for the others."""
        return self.engine.low_part if coarse else all_modes(shift)

    @property
    def _linear(self) -> LinearGrid:
        assert self.linear is not None
        return self.linear

    def restrict(self, size: float) -> None:
        """Pose the linear problem of the coarser grid: stiffness of the wall, and gradient over ``size``."""
        below = self._linear
        below.engine.sample(self.stiffness, below.stiffness)
        self.engine.restrict(self.g, below.engine, below.g, size)

    def low_modes(self, shift: float, size: float) -> Real:
        """The modes of the coarser grid: there s is minus ``size`` times what that has found.  Their sums."""
        return self.engine.low("low_modes", g=self.g, d=self.d, c0=shift, e=self._linear.x, size=size)

    def low_gradient(self, shift: float) -> Real:
        """The same modes with s = M g after all: of their sums <g s> and <s K s>."""
        return self.engine.low("low_gradient", g=self.g, c0=shift)

    def _low_direction(self, beta: float) -> None:
        self.engine.low("low_direction", inverse=True, d=self.d, beta=beta)


class LinearGrid(_Descending):
    """The linear problem (K + stiffness) x = -g of a grid, for a step of the next finer one.

    In the precision in which the back end holds it: a step is a direction only.

    Parameters
    ----------
    back_end, stiffness_q, threads : as for :class:`SmoothGrid`.
    smooth : the nonlinear problem of the grid, in the memory of whose spectra those of this one lie: the finer grid
        asks for a step only where it is no more at work.
    """

    def __init__(self, back_end: Any, stiffness_q: Real, threads: int, smooth: SmoothGrid) -> None:
        self.grid, self.size, self.linear = smooth.grid, smooth.size, smooth.linear
        below = self.linear.grid if self.linear else None
        self.engine: LinearEngine = back_end.linear_engine(self.grid, stiffness_q, threads, below, smooth.engine)
        spectra = smooth.g, smooth.d, smooth.engine.w
        self.g, self.d, self.x, self.stiffness, self.direction = self.engine.fields(spectra)
        level = self.engine.level(self.g, self.d, self.x, self.stiffness, self.direction)
        self._levels: tuple[Any, ...] = () if level is None else (level, *(self.linear._levels if self.linear else ()))

    @property
    def chain(self) -> list[LinearGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.linear.chain if self.linear else [])]

    def relax(self, levels: int, shift: float, iterations: int, reduction: float) -> bool | None:
        """All of :func:`continuum.solve.smooth.minimise_linear`, where the device does it in one call; else None."""
        if not self._levels:
            return None
        depth = min(levels, len(self._levels))
        moved, transforms = self.engine.relax(self._levels, depth, shift, iterations, reduction)
        for grid, count in zip(self.chain, transforms, strict=True):
            grid.engine.transforms += count
        return moved

    def begin(self) -> None:
        """Begin at x = 0, with no direction."""
        for values in (self.x, self.d, self.direction, self.engine.w):
            self.engine.fill(values, 0.0)

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, first: bool) -> Real:
        """Take the last step, of length ``alpha``: x and g; s = M g.  As :meth:`SmoothGrid.gradient`."""
        given = {"g": self.g, "d": self.d, "x": self.x, "alpha": alpha, "beta": beta}
        given |= self._modes(shift, coarse=coarse)
        return self.engine.spectral("linear_gradient", forward=not first, inverse=True, keep_low=coarse, **given)

    def turn(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <stiffness d d>."""
        if coarse:
            self._low_direction(beta)
        sums = self.engine.through("linear_turn", d=self.direction, stiffness=self.stiffness, beta=beta)
        return float(sums[0]) / self.size

    def finish(self, shift: float, alpha: float, beta: float, *, coarse: bool) -> None:
        """Take the last step, after which nothing follows: x alone."""
        given = {"g": self.g, "d": self.d, "x": self.x, "alpha": alpha, "beta": beta}
        self.engine.spectral("linear_last", keep_low=coarse, **given, **self._modes(shift, coarse=coarse))


class SmoothGrid(_Descending):
    """Gap z and direction d over the points, spectra of the gradient and of d; and the coarser grids.

    Parameters
    ----------
    back_end : whose engine holds the arrays.
    grid : points and periods.
    stiffness_q : K over the half spectrum, shape ``grid.shape_q``, in E*/a0; at q = 0 that of each problem counts.
    threads : of this process that the engine may use.
    coarser : number of coarser grids wanted; fewer if the grid cannot be halved so often.
    finer : the next finer grid, if there is one.
    sampled : whether coarser grids take every second point of the offset, which may jump, instead of its waves.
    """

    lift = pressure = 0.0
    held = False
    _energy = _energy_before = 0.0
    """Mean of φ at z, and where the steps along d began."""
    law: Law
    offset: Array = None
    z: Array = None
    direction: Array = None
    traction: Array = None
    """Traction of the wall at z; its stiffness is kept beside it in single precision."""

    def __init__(
        self,
        back_end: Any,
        grid: Grid,
        stiffness_q: Real,
        threads: int,
        coarser: int,
        finer: SmoothGrid | None = None,
        *,
        sampled: bool = False,
    ) -> None:
        self.grid, self.size, self._sampled = grid, grid.size, sampled
        below = grid.coarser if coarser > 0 and grid.narrowest > back_end.SMALLEST else None
        self.engine: SmoothEngine = back_end.engine(grid, stiffness_q, threads, below, finer.engine if finer else None)
        engine = self.engine
        self.g, self.d = engine.spectrum(), engine.spectrum()
        if engine.KEEPS_FIELDS:
            self._allocate()
            self.traction, self.stiffness = engine.rows(), engine.single_rows()
        self._kept = engine.rows() if engine.KEEPS_FIELDS and finer is None else None
        self.coarser: SmoothGrid | None = None
        if below is not None:
            stiffness_below = cut(stiffness_q, below.shape_q)
            self.coarser = SmoothGrid(back_end, below, stiffness_below, threads, coarser - 1, self, sampled=sampled)
            self.linear = LinearGrid(back_end, stiffness_below, threads, self.coarser)
        # The fields of a device are not at hand.
        self.boxes = None if engine.KEEPS_FIELDS else Boxes.on(grid, stiffness_q)
        self.box_pairs, self._back_end = 0.0, back_end

    @cached_property
    def box(self) -> SmoothGrid:
        """The grid of one box, if there are :attr:`boxes`."""
        assert self.boxes is not None
        return SmoothGrid(self._back_end, self.boxes.grid, self.boxes.stiffness_q, 1, 0)

    @property
    def work(self) -> list[Work]:
        """What was done for the problem at hand on this grid, on coarser ones, linear problems too, and in boxes."""
        both = zip(self.chain[1:], self.linear.chain if self.linear else [], strict=True)
        grids = [self.engine.work, *(one.engine.work.plus(other.engine.work) for one, other in both)]
        return grids + [Work(g.boxes.grid.shape, g.box_pairs, 0, 0.0) for g in self.chain if g.boxes is not None]

    def set_problem(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        """Set the problem of the grid and of all coarser ones; False if it is not finite.

        ``offset`` and ``start``, shape ``grid.shape``, in a0, are not changed; ``mean_stiffness`` is K at q = 0,
        infinite where the mean of u is held at zero.
        """
        self.offset = self.engine.hold(offset, self._kept)
        if self.offset is None or not np.isfinite(lift):
            return False
        for grid in self.chain:
            engine = grid.engine
            grid.law, grid.box_pairs = law, 0.0
            grid.lift, grid.pressure, grid.held = lift, pressure, bool(np.isinf(mean_stiffness))
            engine.set_law(law)
            for each in (grid, grid.linear) if grid.linear else (grid,):
                each.engine.set_mean_stiffness(1.0 if grid.held else mean_stiffness, held=grid.held)
                each.engine.forget_work()
        self._begin()
        return start is None or self.engine.upload(self.z, start)

    def _begin(self) -> None:
        """Have fields, and no direction: that of a solve that failed may not be finite, nor is zero times it zero."""
        if not self.engine.KEEPS_FIELDS:
            self._allocate()
        self.engine.fill(self.d, 0.0)
        self.engine.fill(self.direction, 0.0)

    def release(self) -> None:
        """Give the memory of the fields back, where it is not kept."""
        if not self.engine.KEEPS_FIELDS:
            self.z = self.direction = self.traction = self.stiffness = self.offset = None

    def _allocate(self) -> None:
        self.z, self.direction = self.engine.rows(), self.engine.rows()

    @property
    def chain(self) -> list[SmoothGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.coarser.chain if self.coarser else [])]

    # --- where it starts -----------------------------------------------------------------------------------

    def set_coarser_problem(self, *, started: bool) -> None:
        """Give the coarser grid its part of the offset and, after :meth:`go_to_start`, of the displacement.

        The latter is its start; the offset lies in the memory of d, which is lost.
        """
        below = self.chain[1]
        below._begin()
        if started:
            below.engine.inverse(below.z)
        below.offset = reused(self.direction, *below.grid.shape)
        if self._sampled:
            below.engine.sample(self.offset, below.offset)
        else:
            mean = self.engine.into("copy", values=self.offset)[0] / self.size
            self.engine.spectral(forward=True)
            self.engine.set_mean(mean)
            self.engine.restrict(self.engine.w, below.engine, below.engine.w)
            below.engine.inverse(below.offset)
        if started:
            below.engine.reflect(below.z, below.offset, self.lift)

    def go_to_start(self) -> None:
        """Begin at the start, which lies in z: where the mean of u is held z is shifted to it; g without the wall."""
        mean = self._displace()
        if self.held:
            self.engine.shift(self.z, mean)
        if self.coarser is not None:
            self.engine.restrict(self.engine.w, self.coarser.engine, self.coarser.engine.w)
        self._elastic()
        self._press()

    def hand_down(self) -> bool:
        """After :meth:`gradient`: let the coarser grid begin at the state at hand, if it carries what snaps."""
        if not (self.coarser and self.boxes and self.pressure >= 0 and self.boxes.carried(self.stiffness)):
            return False
        self.go_to_start()
        self.traction = self.stiffness = None  # coarser grids have the memory meanwhile
        self.set_coarser_problem(started=True)
        return True

    def go_to_zero(self) -> None:
        """Begin at u = 0: z, and g without the wall."""
        self.engine.fill(self.z, 0.0)
        self.engine.reflect(self.z, self.offset, self.lift)
        self.engine.fill(self.engine.w, 0.0)
        self._elastic()
        self._press()

    def go_to_coarser(self) -> None:
        """Begin at the displacement of the coarser grid, without shorter waves; at u = 0 where that grid failed."""
        below = self.chain[1]
        if not np.isfinite(below._displace()):
            below.clear()
        self.engine.prolong(below.engine)
        self._elastic()
        self.engine.spectral(inverse=True)
        self.engine.out_of("lay", z=self.z, offset=self.offset, lift=self.lift)
        below.release()
        self._press()

    def _displace(self) -> float:
        """Spectrum of the displacement; returns its mean."""
        sums = self.engine.into("displace", z=self.z, offset=self.offset, lift=self.lift)
        self.engine.spectral(forward=True)
        return float(sums[0]) / self.size

    def _elastic(self) -> None:
        """Gradient without the traction of the wall, from the spectrum of the displacement: K u - F."""
        self.engine.spectral("elastic", g=self.g, force=0.0 if self.held else self.pressure)

    def _press(self) -> None:
        """Traction of the gap, to be transformed."""
        if self.traction is None:
            # No sooner, since coarser grids have given their memory back by now.
            self.traction, self.stiffness = self.engine.rows(), self.engine.single_rows()
        sums = self.engine.into("press", z=self.z, traction=self.traction, stiffness=self.stiffness)
        self._energy = sums[0] / self.size

    # --- an iteration --------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        """Finish the last step, of length ``alpha`` along a direction that kept ``beta`` of the one before.

        g <- g + y, and s = M g is the new step; returns the sums.  With ``coarse`` the modes of the coarser grid take
        no part in any sum but <g g>.  g that is not ``complete`` lacks the traction of z, as after :meth:`go_to_start`,
        :meth:`go_to_zero` and :meth:`go_to_coarser`, or that of the last step; g that is stays what it is.
        """
        if complete:
            self.engine.fill(self.engine.w, 0.0)
        given = {"g": self.g, "d": self.d, "alpha": alpha, "beta": beta, **self._modes(shift, coarse=coarse)}
        return self.engine.spectral("gradient", forward=not complete, inverse=True, keep_low=coarse, **given)

    def turn(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <φ'' d d> over the points near the wall."""
        if coarse:
            self._low_direction(beta)
        sums = self.engine.out_of("turn", d=self.direction, stiffness=self.stiffness, beta=beta)
        return float(sums[0]) / self.size

    def line(self, alpha: float) -> tuple[float, float]:
        """At z - alpha d, over the points near the wall: <(change of p) d> and <φ'' d d>."""
        self.engine.trials += 1
        fields = {"z": self.z, "d": self.direction, "traction": self.traction}
        slope, curvature = self.engine.sweep("line", alpha=alpha, **fields)[:2] / self.size
        return float(slope), float(curvature)

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        """Set z <- z - step d, the last of several that add up to alpha.

        Returns, of all of these, <(change of p) d>; what φ changes beyond first order, and its size, as means.
        """
        if step == alpha:
            self._energy_before = self._energy
        fields = {"z": self.z, "d": self.direction, "traction": self.traction, "stiffness": self.stiffness}
        sums = self.engine.into("move", step=step, alpha=alpha, **fields) / self.size
        slope, before, self._energy, size = (float(each) for each in sums[:4])
        return slope, self._energy - self._energy_before - alpha * before, size

    def clear(self) -> None:
        """Forget d, which may not be finite."""
        for values in (self.engine.w, self.d, self.direction):
            self.engine.fill(values, 0.0)

    def relax_boxes(self, descend: Callable[[SmoothGrid, Law, Real, Real], Solution]) -> float:
        """After :meth:`gradient`: go down in boxes, and begin anew from there; returns the change of the energy."""
        assert self.boxes is not None
        # The gradient goes where the direction was, which is forgotten.
        self.engine.w[...] = self.g
        self.engine.transforms += 1
        self.engine.inverse(self.direction)
        z, traction, g = (self.engine.download(each) for each in (self.z, self.traction, self.direction))
        rise, pairs = self.boxes.relax(self.law, z, traction, g, partial(descend, self.box, self.law))
        self.box_pairs += pairs
        self.go_to_start()
        return rise

    # --- the outcome ---------------------------------------------------------------------------------------

    def residual(self) -> float:
        """Root-mean-square gradient at z, all of it computed afresh; g is this from then on."""
        self._displace()
        self._elastic()
        self._press()
        return float(np.sqrt(self.engine.spectral("add_square", forward=True, g=self.g)[0]))

    def has_tiles(self, *, below: bool = False) -> bool:
        """Whether tiles near the wall pay, by the gap at hand or by that of the coarser grid."""
        known = self.chain[1 if below else 0]
        return self.engine.has_tiles(known.engine, known.z, self.law)

    def look(self) -> Real:
        """The gap z so far, shape ``grid.shape``, in a0: neither to be changed nor to be kept."""
        return self.engine.download(self.z)

    def hand_out(self) -> Real:
        """Hand z out as an array of the host that nobody else uses, shape ``grid.shape``, in a0."""
        gap = self.engine.download(self.z)
        # Who looks at the gap has the memory of the fields meanwhile; spectra are what is left.
        self.release()
        return gap

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""
        return self.engine.elastic_energy(offset, gap, self.g, self.d)
