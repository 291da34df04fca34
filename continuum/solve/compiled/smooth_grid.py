"""The grid of the smooth solver on processor cores, in the words of :mod:`continuum.solve.grids`."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import Self

import numpy as np

from continuum.model import fourier
from continuum.model.fourier import Real, cut
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.boxes import Boxes
from continuum.solve.compiled import points, spectra, tractions
from continuum.solve.compiled.compiling import Single
from continuum.solve.compiled.contact import CompiledContact
from continuum.solve.compiled.linear import CompiledLinearGrid, SteppedPasses
from continuum.solve.compiled.passes import Sweep, reused
from continuum.solve.compiled.tractions import Pull
from continuum.solve.solution import Solution, Work

NONE: Real = np.zeros((0, 0))
"""A field that has no memory at the moment."""
NO_STIFFNESS: Single = np.zeros((0, 0), np.float32)
"""The same in single precision."""


class CompiledSmoothGrid(SteppedPasses):
    """Gap z and direction d over the points, spectra of the gradient and of d; and the coarser grids.

    Fields are made anew for each problem, since what is handed out is their memory; spectra are kept.

    Parameters
    ----------
    grid : points and periods.
    stiffness_q : K over the half spectrum, shape ``grid.shape_q``, in E*/a0; at q = 0 that of each problem counts.
    threads : of this process that the passes may use.
    smallest : grids of no more points along a side have no coarser one.
    precision : of the linear problems.
    coarser : number of coarser grids wanted; fewer if the grid cannot be halved so often.
    sampled : whether coarser grids take every second point of the offset, which may jump, instead of its waves.
    """

    lift = pressure = np.nan
    _energy = _energy_before = np.nan
    """Mean of φ at z, and where the steps along d began."""
    law: Law
    offset = z = direction = NONE
    traction = NONE
    """Traction of the wall at z; its stiffness is kept beside it in single precision."""
    stiffness = NO_STIFFNESS
    corrected = False
    contact: CompiledContact | None = None

    def __init__(
        self: Self,
        grid: Grid,
        stiffness_q: Real,
        threads: int,
        smallest: int,
        precision: type,
        coarser: int,
        *,
        sampled: bool = False,
    ) -> None:
        below = grid.coarser if coarser > 0 and grid.narrowest > smallest else None
        super().__init__(grid, np.array(stiffness_q, order="C"), threads, below)
        self._sampled, self._of_grids = sampled, (smallest, precision)
        self.g, self.d = self.spectrum(), self.spectrum()
        self.coarser: Self | None = None
        if below is not None:
            K = cut(stiffness_q, below.shape_q)
            under = type(self)(below, K, threads, *self._of_grids, coarser - 1, sampled=sampled)
            self.coarser = under
            self.linear = CompiledLinearGrid(below, K, threads, precision, under.linear, (under.g, under.d, under.w))
            self.contact = CompiledContact(self, stiffness_q, threads, precision)
        self.boxes = Boxes.on(grid, stiffness_q)
        self.box_pairs = 0.0

    @cached_property
    def box(self) -> Self:
        """The grid of one box, if there are :attr:`boxes`."""
        assert self.boxes is not None
        return type(self)(self.boxes.grid, self.boxes.stiffness_q, 1, *self._of_grids, 0)

    @property
    def chain(self) -> list[Self]:
        """The grid itself and all coarser ones."""
        return [self, *(self.coarser.chain if self.coarser else [])]

    @property
    def work(self) -> list[Work]:
        both = zip(self.chain[1:], self.linear.chain if self.linear else [], strict=True)
        grids = [self.own_work, *(one.own_work.plus(other.own_work) for one, other in both)]
        return grids + [Work(g.boxes.grid.shape, g.box_pairs, 0, 0.0) for g in self.chain if g.boxes is not None]

    # --- where it starts ---------------------------------------------------------------------------------------

    def set_problem(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        # A sum is finite only if all its terms are, and needs no memory.
        if not (np.isfinite(offset.sum()) and np.isfinite(lift)):
            return False
        self.offset, held = np.ascontiguousarray(offset), bool(np.isinf(mean_stiffness))
        for grid in self.chain:
            grid.law, grid.box_pairs, grid.lift, grid.pressure = law, 0.0, lift, pressure
            for each in (grid, grid.linear) if grid.linear else (grid,):
                each.set_mean_stiffness(1.0 if held else mean_stiffness, held=held)
                each.forget_work()
        self._begin()
        if start is not None:
            self.z[:, : self.n] = start
        return start is None or bool(np.isfinite(start.sum()))

    def _begin(self) -> None:
        """Have fields, and no direction: that of a solve that failed may not be finite, nor is zero times it zero."""
        self.z, self.direction = self.rows(), self.rows()
        self.d[...] = 0.0

    def release(self) -> None:
        """Give the memory of the fields back."""
        self.z = self.direction = self.offset = NONE
        self.forget_wall()
        if self.contact is not None:
            self.contact.forget()

    def forget_wall(self) -> None:
        """Give that of traction and stiffness back."""
        self.traction, self.stiffness = NONE, NO_STIFFNESS

    def set_coarser_problem(self, *, started: bool) -> None:
        # The offset of the coarser grid lies in the memory of the direction, which is lost.
        below = self.chain[1]
        below._begin()
        if started:
            below.inverse(below.z)
        below.offset = reused(self.direction, *below.grid.shape)
        if self._sampled:
            below.sample(self.offset, self.n, below.offset)
        else:
            mean = self._load(self.offset) / self.size
            self.spectral(forward=True)
            self.work_q[0, 0] = mean
            self.restrict_q(self.w, below.w)
            below.inverse(below.offset)
        if started:
            below._reflect()

    def _load(self, values: Real) -> float:
        """Begin to transform a field; returns its sum."""
        return float(
            self.through(lambda a, b, sums, out: points.copy(a, b, sums, out, values, self.n), forward=True)[0]
        )

    def _reflect(self) -> None:
        """Set z <- offset - z + lift: the gap of a displacement."""
        z = self.z[:, : self.n]
        np.subtract(self.offset, z, out=z)
        z += self.lift

    def go_to_start(self) -> None:
        mean = self._displace()
        if self.held:
            self.z[:, : self.n] += mean
        if self.coarser is not None:
            self.restrict_q(self.w, self.coarser.w)
        self._elastic()
        self._press()

    def go_to_zero(self) -> None:
        self.z[...] = 0.0
        self._reflect()
        self.w[...] = 0.0
        self._elastic()
        self._press()

    def go_to_coarser(self) -> None:
        below = self.chain[1]
        if not np.isfinite(below._displace()):
            below.clear()
        fourier.prolong(below.work_q, self.work_q)
        self._elastic()
        self.spectral(inverse=True)
        self._lay()
        below.release()
        self._press()

    def _displace(self) -> float:
        """Spectrum of the displacement; returns its mean."""
        given = self.z, self.n, self.offset, self.lift
        sums = self.through(lambda a, b, sums, out: points.displace(a, b, sums, out, *given), forward=True)
        self.spectral(forward=True)
        return float(sums[0]) / self.size

    def _elastic(self) -> None:
        """Gradient without the traction of the wall, from the spectrum of the displacement: K u - F."""
        force = 0.0 if self.held else self.pressure
        self.spectral(lambda a, b, sums: spectra.elastic_gradient(a, b, sums, self.g, self.w, self.K, force))

    def _lay(self) -> None:
        """The gap of a displacement that was transformed back."""
        z, n, offset, lift = self.z, self.n, self.offset, self.lift

        def sweep(a: int, b: int, sums: Real, u: Real) -> None:
            points.displace(0, b - a, sums, z[a:b], u, n, offset[a:b], lift)

        self.through(sweep, inverse=True)

    def _press(self) -> None:
        """Traction of the gap, to be transformed."""
        if not self.traction.size:
            # No sooner, since coarser grids have given their memory back by now.
            self.traction, self.stiffness = self.rows(), self.single_rows()
        self.traction[...] = self.stiffness[...] = 0.0
        self.corrected = False
        # The direction may not be finite; of no length, any finite field is as good.
        self._energy = float(self._step_along(self.z, 0.0, 0.0)[2])

    # --- an iteration ------------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        if complete:
            self.w[...] = 0.0
        finished = self._finished(shift, alpha, beta, coarse=coarse)
        return self.spectral(finished, forward=not complete, inverse=True, keep_low=coarse)

    def _finished(self, shift: float, alpha: float, beta: float, *, coarse: bool) -> Sweep:
        """The gradient after a step, and M g."""
        low, c0 = self.modes(shift, coarse=coarse)
        given = self.spectra, None, c0, alpha, beta, low
        return lambda a, b, sums: spectra.finish_gradient(a, b, sums, *given)

    @property
    def wall(self) -> Pull:
        """What is kept of the wall, for a sweep."""
        return Pull(self.near, self.traction, self.stiffness)

    def new_direction(self, beta: float, *, coarse: bool) -> float:
        if coarse:
            self.low_direction(beta)
        given = self.direction, self.n, beta, self.wall
        sums = self.through(lambda a, b, sums, s: tractions.direction_near(a, b, sums, s, *given), inverse=True)
        return float(sums[0]) / self.size

    def line(self, alpha: float) -> tuple[float, float]:
        self.trials += 1
        given = self.z, self.direction, self.n, alpha, self.law, self.wall
        slope, curvature = self.sweep(tractions.search_line, *given)[:2] / self.size
        return float(slope), float(curvature)

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        if step == alpha:
            self._energy_before = self._energy
        slope, before, self._energy, size = (float(each) for each in self._step_along(self.direction, step, alpha))
        return slope, self._energy - self._energy_before - alpha * before, size

    def _step_along(self, d: Real, step: float, alpha: float) -> Real:
        """Move the gap, whose change of the traction is to be transformed; returns the sums as means."""
        given = self.z, d, self.n, step, alpha, self.law, self.wall
        sums = self.through(lambda a, b, sums, p: tractions.move_gap(a, b, sums, p, *given), forward=True)
        return sums[:4] / self.size

    def clear(self) -> None:
        for values in (self.w, self.d, self.direction):
            values[...] = 0.0

    # --- where it stalls --------------------------------------------------------------------------------------

    def force(self) -> None:
        """The gradient as a field, in the memory of the direction, which is forgotten."""
        self.w[...] = self.g
        self.transforms += 1
        self.inverse(self.direction)

    def hand_down(self) -> bool:
        if not (self.coarser and self.boxes and self.pressure >= 0 and self.boxes.carried(self.stiffness)):
            return False
        self.go_to_start()
        self.forget_wall()  # coarser grids have the memory meanwhile
        self.set_coarser_problem(started=True)
        return True

    def relax_boxes(self, descend: Callable[[Self, Law, Real, Real], Solution]) -> float:
        assert self.boxes is not None
        self.force()
        z, traction, g = (each[:, : self.n] for each in (self.z, self.traction, self.direction))
        rise, pairs = self.boxes.relax(self.law, z, traction, g, partial(descend, self.box, self.law))
        self.box_pairs += pairs
        self.go_to_start()
        return rise

    # --- the outcome -------------------------------------------------------------------------------------------

    def residual(self) -> float:
        self._displace()
        self._elastic()
        self._press()
        sums = self.spectral(self._finished(1.0, 0.0, 0.0, coarse=False), forward=True)
        return float(np.sqrt(sums[0]))

    def look(self) -> Real:
        return self.z[:, : self.n]

    def hand_out(self) -> Real:
        gap = self.look()
        # Who looks at the gap has the memory of the fields meanwhile; spectra are what is left.
        self.release()
        return gap

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        return self.elastic_energy_in(self.g, self.d, offset, gap)
