"""One grid of the smooth solver on the device: what :class:`continuum.solve.backend.Level` asks for.

Held for a path, of the size of a field: gap, direction, spectra of gradient, direction and work, half a one for K, the
same for each coarser grid, and the offset of the finest.  The offset of a coarser grid lies in the direction of the
next finer one, which is not in use while it is needed.
"""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real, cut
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.cuda import points, spectra, walls
from continuum.solve.cuda.device import Array, to_device
from continuum.solve.cuda.fields import Fields


class Level(Fields):
    """The arrays of one grid.

    Parameters
    ----------
    grid, K : as for all fields; K at q = 0 is that of each problem.
    coarser : number of coarser grids wanted; fewer if the grid cannot be halved so often.
    smallest : grids of no more points along a side have no coarser one.
    larger : the next finer grid, if there is one.
    """

    law: int
    parameters: Array
    reach = lift = pressure = 0.0
    held = False

    def __init__(self, grid: Grid, K: Real, coarser: int, smallest: int, larger: Level | None = None) -> None:
        super().__init__(grid, np.where(np.isfinite(K), K, 0.0), larger)
        self.g, self.d = self.spectrum(), self.spectrum()
        self.z, self.direction = self.field(), self.field()
        self.offset: Array = self._lent(larger.direction) if larger else self.field()
        self._known: Real | None = None
        self.coarser: Level | None = None
        self.low_rows = self.low_columns = 0
        below = grid.coarser
        if coarser > 0 and below is not None and min(grid.shape) > smallest:
            self.coarser = Level(below, cut(K, below.shape_q), coarser - 1, smallest, self)
            self.low_rows, self.low_columns = below.shape_q[0] // 2, below.shape_q[1] - 1

    # --- the problem ---------------------------------------------------------------------------------------

    def pose(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        """Take a problem."""
        if not (self._take(offset) and np.isfinite(lift)):
            return False
        if start is not None and not self.upload(self.z, start):
            return False
        parameters = to_device(law.parameters)
        for level in self._chain:
            level.law, level.reach, level.parameters = law.kind, law.reach, parameters
            level.lift, level.pressure, level.held = lift, pressure, bool(np.isinf(mean_stiffness))
            level.set_mean_stiffness(1.0 if level.held else mean_stiffness)
            # May be of a solve that failed, and zero times what is not finite is not zero.
            level.run(points.fill, level.d, 0.0)
            level.run(points.fill, level.direction, 0.0)
            level.forget_work()
        return True

    def _take(self, offset: Real) -> bool:
        """Copy the offset, unless it is the one of the last problem and nobody can have changed it."""
        if offset is self._known:
            return True
        self._known = None
        finite = self.upload(self.offset, offset)
        if finite and not offset.flags.writeable and offset.base is None:
            self._known = offset
        return finite

    def pose_coarser(self, *, started: bool) -> None:
        """Give the coarser grid its part of offset and start."""
        below = self._below
        if started:
            below.transform.inverse(below.w)
            below.run(points.keep, below.z, below.w)
        self.run(points.into, self.w, self.offset, self.per_point)
        self.forward()
        below.run(spectra.restrict, below.w, self.w)
        below.transform.inverse(below.w)
        below.run(points.keep, below.offset, below.w)
        if started:
            below.run(points.above, below.z, below.offset, self.lift)

    def place(self) -> None:
        """Go to the start, which lies in z."""
        mean = self._displace()
        if self.held:
            self.run(points.shift, self.z, mean)
        if self.coarser is not None:
            self.coarser.run(spectra.restrict, self.coarser.w, self.w)
        self._elastic()
        self._press()

    def rest(self) -> None:
        """Go to where nothing is displaced."""
        self.run(points.fill, self.w, 0.0)
        self.run(points.lay, self.z, self.w, self.offset, self.lift)
        self._elastic()
        self._press()

    def prolong(self) -> None:
        """Go to the state of the coarser grid."""
        below = self._below
        # A coarse grid that failed is no start: this one begins from rest.
        if not np.isfinite(below._displace()):
            below.clear()
        self.run(spectra.prolong, self.w, below.w)
        self._elastic()
        self.inverse()
        self.run(points.lay, self.z, self.w, self.offset, self.lift)
        self._press()

    # --- an iteration --------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        """Finish a step, and precondition."""
        if not complete:
            self.transform.forward(self.w)  # counted where the field was made
        low = (self.low_rows, self.low_columns) if coarse else (0, 0)
        flags = self.single, int(self.held), int(complete)
        return self.sum(spectra.gradient, self.g, self.d, self.w, self.K, shift, alpha, beta, *low, *flags)

    def restrict(self) -> None:
        """Let the coarser grid begin from here: at every second gap, with its part of the gradient."""
        below = self._below
        below.run(points.every_second, below.z, self.z)
        below.run(spectra.restrict, below.g, self.g)

    def low_modes(self, shift: float) -> Real:
        """The step of the coarser grid."""
        below = self._below
        below.run(points.moved, below.w, self.z, below.z, below.per_point)
        below.forward()
        fields = self.g, self.d, self.w, self.K, below.w
        low = self.low_rows, self.low_columns, self.single, int(self.held)
        return self.sums(spectra.low_modes, 2 * self.low_rows - 1, *fields, shift, *low)

    def low_gradient(self, shift: float) -> Real:
        """The gradient's own step, where that of the coarser grid does not serve."""
        arguments = self.g, self.w, self.K, shift, self.low_rows, self.low_columns, self.single
        return self.sums(spectra.low_gradient, 2 * self.low_rows - 1, *arguments)

    def turn(self, beta: float, *, coarse: bool) -> float:
        """Turn the direction."""
        if coarse:
            arguments = self.d, self.w, self.low_rows, self.low_columns, beta
            spectra.low_direction(2 * self.low_rows - 1, *arguments)
        self.inverse()
        wall = self.law, self.parameters, self.reach
        return float(self.sum(walls.turn, self.direction, self.w, self.z, beta, *wall)[0]) / self.size

    def line(self, alpha: float) -> tuple[float, float]:
        """Look ahead."""
        self.trials += 1
        wall = self.law, self.parameters, self.reach
        slope, curvature = self.sum(walls.line, self.z, self.direction, alpha, *wall)[:2] / self.size
        return float(slope), float(curvature)

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        """Go."""
        self.transforms += 1
        arguments = self.w, self.z, self.direction, step, alpha, self.law, self.parameters, self.reach, self.per_point
        slope, second, size = self.sum(walls.move, *arguments)[:3] / self.size
        return float(slope), float(second), float(size)

    def clear(self) -> None:
        """Forget the direction."""
        for values in (self.w, self.d, self.direction):
            self.run(points.fill, values, 0.0)

    # --- the outcome ---------------------------------------------------------------------------------------

    def residual(self) -> float:
        """Gradient afresh."""
        self._displace()
        self._elastic()
        self._press()
        self._without_mean()
        return float(np.sqrt(self.sum(spectra.add_square, self.g, self.w, self.single)[0]))

    def take_gap(self) -> Real:
        """Hand the gap out."""
        gap: Real = self.z.copy_to_host()
        return gap

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u, K u> of u = offset - gap without its mean."""
        self._take(offset)
        self.upload(self.z, gap)
        return self.fluctuation_energy(self.offset, self.z)

    # --- its parts -----------------------------------------------------------------------------------------

    @property
    def _below(self) -> Level:
        assert self.coarser is not None
        return self.coarser

    @property
    def _chain(self) -> list[Level]:
        """Itself and all coarser ones."""
        return [self, *(self.coarser._chain if self.coarser else [])]

    def _lent(self, memory: Array) -> Array:
        """The beginning of a larger field, as one of this grid."""
        rows, columns = self.grid.shape
        return memory.ravel()[: rows * columns].reshape(rows, columns)

    def _displace(self) -> float:
        """Spectrum of the displacement into ``w``; returns its mean."""
        self.transforms += 1
        displaced = self.sum(points.displace, self.w, self.z, self.offset, self.lift, self.per_point)[0]
        self._without_mean()
        return float(displaced) / self.size

    def _without_mean(self) -> None:
        """Transform the field in ``w``, counted where it was made; a mean that is held takes no part."""
        self.transform.forward(self.w)
        if self.held:
            points.put(1, self.w, 0.0)

    def _elastic(self) -> None:
        """Gradient without the traction of the wall, from the spectrum of the displacement: K u - F."""
        self.run(spectra.elastic, self.g, self.w, self.K, 0.0 if self.held else self.pressure)

    def _press(self) -> None:
        self.transforms += 1
        self.run(walls.press, self.w, self.z, self.law, self.parameters, self.reach, self.per_point)
