"""One grid of the smooth solver, in the words of :mod:`continuum.solve.smooth`, on the engine of any device."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real, cut, low_rows
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.backend import Array, BackEnd, Engine, reused
from continuum.solve.solution import Work


class SmoothGrid:
    """Gap z and direction d over the points, spectra of the gradient and of d; and the coarser grids.

    <a b> is the mean of a product over the points, an equal sum over the modes; sums that are an array are six:
    <g g>, <g s>, <y s>, <y M y>, <s K s>, <s K d>, with y the change of the gradient g by the last step, s = M g and
    M = 1/(K + shift).

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

    FIELDS = 8.4
    """Memory held on a device that keeps its arrays, with that of the coarser grids, in fields of the finest."""
    lift = pressure = 0.0
    held = False
    offset: Array = None
    z: Array = None
    direction: Array = None

    def __init__(
        self,
        back_end: BackEnd,
        grid: Grid,
        stiffness_q: Real,
        threads: int,
        coarser: int,
        finer: SmoothGrid | None = None,
        *,
        sampled: bool = False,
    ) -> None:
        below = grid.coarser if coarser > 0 and grid.narrowest > back_end.SMALLEST else None
        self.grid, self.size, self._sampled = grid, grid.size, sampled
        self.engine: Engine = back_end.engine(grid, stiffness_q, threads, below, finer.engine if finer else None)
        engine = self.engine
        self.g, self.d = engine.spectrum(), engine.spectrum()
        if engine.KEEPS_FIELDS:
            self._allocate()
        self._kept = engine.rows() if engine.KEEPS_FIELDS and finer is None else None
        self.coarser: SmoothGrid | None = None
        self.low_rows = self.low_columns = 0
        if below is not None:
            stiffness_below = cut(stiffness_q, below.shape_q)
            self.coarser = SmoothGrid(back_end, below, stiffness_below, threads, coarser - 1, self, sampled=sampled)
            self.low_rows, self.low_columns = low_rows(below.shape_q[0]), below.shape_q[1] - 1

    @property
    def work(self) -> Work:
        """What was done for the problem at hand."""
        return self.engine.work

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
            grid.lift, grid.pressure, grid.held = lift, pressure, bool(np.isinf(mean_stiffness))
            if not engine.KEEPS_FIELDS:
                grid._allocate()
            engine.set_law(law)
            engine.set_mean_stiffness(1.0 if grid.held else mean_stiffness, held=grid.held)
            # May be of a solve that failed, and zero times what is not finite is not zero.
            engine.fill(grid.d, 0.0)
            engine.fill(grid.direction, 0.0)
            engine.forget_work()
        return start is None or self.engine.upload(self.z, start)

    def _allocate(self) -> None:
        self.z, self.direction = self.engine.rows(), self.engine.rows()

    @property
    def chain(self) -> list[SmoothGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.coarser.chain if self.coarser else [])]

    @property
    def _below(self) -> SmoothGrid:
        assert self.coarser is not None
        return self.coarser

    # --- where it starts -----------------------------------------------------------------------------------

    def set_coarser_problem(self, *, started: bool) -> None:
        """Give the coarser grid its part of the offset and, after :meth:`go_to_start`, of the displacement.

        The latter is its start; the offset lies in the memory of d, which is lost.
        """
        below = self._below
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

    def go_to_zero(self) -> None:
        """Begin at u = 0: z, and g without the wall."""
        self.engine.fill(self.z, 0.0)
        self.engine.reflect(self.z, self.offset, self.lift)
        self.engine.fill(self.engine.w, 0.0)
        self._elastic()
        self._press()

    def go_to_coarser(self) -> None:
        """Begin at the displacement of the coarser grid, without shorter waves; at u = 0 if that is not finite."""
        below = self._below
        # A coarse grid that failed is no start: this one begins from rest.
        if not np.isfinite(below._displace()):
            below.clear()
        self.engine.prolong(below.engine)
        self._elastic()
        self.engine.spectral(inverse=True)
        self.engine.out_of("lay", z=self.z, offset=self.offset, lift=self.lift)
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
        self.engine.into("press", z=self.z)

    # --- an iteration --------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        """Finish the last step, of length ``alpha`` along a direction that kept ``beta`` of the one before.

        g <- g + y, and s = M g is the new step; returns the sums.  With ``coarse`` the modes of the coarser grid take
        no part in any sum but <g g>.  g that is not ``complete`` lacks the traction of z, as after :meth:`go_to_start`,
        :meth:`go_to_zero` and :meth:`go_to_coarser`, or that of the last step; g that is stays what it is.
        """
        if complete:
            self.engine.fill(self.engine.w, 0.0)
        low_rows, low_columns = (self.low_rows, self.low_columns) if coarse else (0, 0)
        return self.engine.spectral(
            "gradient",
            forward=not complete,
            inverse=True,
            keep_low=coarse,
            g=self.g,
            d=self.d,
            c0=shift,
            alpha=alpha,
            beta=beta,
            low_rows=low_rows,
            low_columns=low_columns,
        )

    def restrict(self) -> None:
        """Let the coarser grid begin from here: at every second z, with its part of g."""
        below = self._below
        below.engine.sample(self.z, below.z)
        self.engine.restrict(self.g, below.engine, below.g)

    def low_modes(self, shift: float) -> Real:
        """The modes of the coarser grid: there s is minus how far that has displaced the surface.  Their sums."""
        below = self._below
        below.engine.into("moved", fine=self.z, z=below.z)
        below.engine.spectral(forward=True)
        return self.engine.low("low_modes", g=self.g, d=self.d, c0=shift, e=below.engine.w)

    def low_gradient(self, shift: float) -> Real:
        """The same modes with s = M g after all: of their sums <g s> and <s K s>."""
        return self.engine.low("low_gradient", g=self.g, c0=shift)

    def turn(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <φ'' d d> over the points near the wall."""
        if coarse:
            self.engine.low("low_direction", inverse=True, d=self.d, beta=beta)
        return float(self.engine.out_of("turn", d=self.direction, z=self.z, beta=beta)[0]) / self.size

    def line(self, alpha: float) -> tuple[float, float]:
        """At z - alpha d, over the points near the wall: <(change of p) d> and <φ'' d d>."""
        self.engine.trials += 1
        slope, curvature = self.engine.sweep("line", z=self.z, d=self.direction, alpha=alpha)[:2] / self.size
        return float(slope), float(curvature)

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        """Set z <- z - step d, the last of several that add up to alpha.

        Returns, of all of these, <(change of p) d>; what φ changes beyond first order, and its size, as means.
        """
        sums = self.engine.into("move", z=self.z, d=self.direction, step=step, alpha=alpha)
        slope, second, size = sums[:3] / self.size
        return float(slope), float(second), float(size)

    def clear(self) -> None:
        """Forget d, which may not be finite."""
        for values in (self.engine.w, self.d, self.direction):
            self.engine.fill(values, 0.0)

    # --- the outcome ---------------------------------------------------------------------------------------

    def residual(self) -> float:
        """Root-mean-square gradient at z, all of it computed afresh; g is this from then on."""
        self._displace()
        self._elastic()
        self._press()
        return float(np.sqrt(self.engine.spectral("add_square", forward=True, g=self.g)[0]))

    def look(self) -> Real:
        """The gap z so far, shape ``grid.shape``, in a0: neither to be changed nor to be kept."""
        return self.engine.download(self.z)

    def hand_out(self) -> Real:
        """Hand z out as an array of the host that nobody else uses, shape ``grid.shape``, in a0."""
        gap = self.engine.download(self.z)
        if not self.engine.KEEPS_FIELDS:
            # Who looks at the gap has the memory of all fields meanwhile; spectra are what is left.
            for grid in self.chain:
                grid.z = grid.direction = grid.offset = None
        return gap

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""
        return self.engine.elastic_energy(offset, gap, self.g, self.d)
