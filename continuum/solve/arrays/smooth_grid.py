"""The grids of the smooth solver on the arrays of a library, in the words of :mod:`continuum.solve.grids`.

An iteration is a few passes over memory, each a function of arrays, and a pair of transforms.  A step of the coarser
grids decides nothing on the host: what has come to an end goes on by steps of length zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.arrays import passes
from continuum.solve.arrays.contact import ArrayContact, PressedModes, SlabContact
from continuum.solve.arrays.library import Array, Library
from continuum.solve.arrays.modes import Modes, mean, square, without_mean
from continuum.solve.backend import SHORT_WAVES, SMOOTH_FIELDS
from continuum.solve.solution import Goal, Iteration, Work


class _Descending(Modes):
    """What the two kinds of grids share: spectra of a gradient g and a direction d_q, and steps of a coarser grid."""

    g: Array
    y: Array
    """Change of g by the last step."""
    d_q: Array
    stiffness: Array = None
    """The stiffness of the wall, in single precision."""
    linear: ArrayLinearGrid | None = None
    held = False

    def __init__(self, library: Library, grid: Grid, stiffness_q: Real, kind: Any = None) -> None:
        super().__init__(library, grid, stiffness_q, kind)
        self._short_waves = SHORT_WAVES * grid.greatest_wave(stiffness_q, along_y=True)
        self._shifts: dict[float, Array] = {}
        self._c0: Array = None

    @property
    def _waves(self) -> passes.ModeStiffness:
        return passes.ModeStiffness(self.K, self.marks, self._c0)

    def _gradient(self, work: Array, shift: float, alpha: Array, *, coarse: bool, linear: bool) -> Array:
        if shift not in self._shifts:  # none is given back: what is recorded reads it again
            self._shifts[shift] = self.library.put([shift, self._short_waves], self.kind)
        self._c0 = self._shifts[shift]
        given = self.g, self.d_q, work, self._waves, alpha
        self.g, self.y, sums = passes.finish_step(self.library, *given, coarse=coarse, held=self.held, linear=linear)
        return sums

    def _restricted(self, size: Array) -> tuple[Array, Array]:
        """The linear problem of the coarser grid: the gradient over a size, and the stiffness of the wall."""
        assert self.linear is not None
        return self.below(self.g, size, self.linear.kind), self.sampled(self.stiffness, self.linear.grid)

    def _low_modes(self, size: Array) -> Array:
        """Sums over the modes of the coarser grid, of its step and of the gradient's own."""
        assert self.linear is not None
        spectra = self.g, self.y, self.d_q, self.K
        return passes.low_sums(self.library, spectra, self.marks.weights, self._c0, self.linear.x, self._low, size)

    def _new_direction(self, beta: Array, size: Array, *, coarse: bool) -> Array:
        """The new direction, as a field."""
        found, low = (self.linear.x, self._low) if coarse and self.linear else (self.g, self.g)
        given = self.d_q, self.g, found, low, self._waves, beta, size
        self.d_q = passes.direction(self.library, *given, coarse=coarse)
        return self.inverse(self.d_q)


class ArrayLinearGrid(_Descending):
    """The linear problem (K + stiffness) x = -g of a grid, for a step of the next finer one."""

    x: Array = None

    def __init__(
        self, library: Library, grid: Grid, stiffness_q: Real, kind: str, coarser: ArrayLinearGrid | None
    ) -> None:
        super().__init__(library, grid, stiffness_q, getattr(library.xp, kind))
        self.linear = coarser
        self._recorded: dict[Any, Callable[..., tuple[Array, Array]]] = {}
        self._transforms: dict[Any, list[float]] = {}

    @property
    def chain(self) -> list[ArrayLinearGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.linear.chain if self.linear else [])]

    def set_mean_stiffness(self, stiffness: float) -> bool:
        changed = super().set_mean_stiffness(stiffness)
        if changed:  # what is recorded reads the K of before
            self._recorded.clear()
        return changed

    def relax(self, levels: int, shift: float, iterations: int, reduction: float) -> bool:
        """As the seam says, without a decision of the host."""
        given = levels, shift, iterations, reduction
        key, before = (*given, self.held), [each.transforms for each in self.chain]
        if key not in self._recorded:
            self._recorded[key] = self.library.recorded(partial(self._relax, *given))
        moved, self.x = self._recorded[key](self.g, self.stiffness)
        made = [each.transforms - begun for each, begun in zip(self.chain, before, strict=True)]
        # What is replayed does not count by itself.
        for each, begun, counted in zip(self.chain, before, self._transforms.setdefault(key, made), strict=True):
            each.transforms = begun + counted
        return bool(self.library.numbers(moved)[0])

    def _relax(
        self, levels: int, shift: float, iterations: int, reduction: float, g: Array, stiffness: Array
    ) -> tuple[Array, Array]:
        """The same: whether any step was taken, and x."""
        library, coarse = self.library, self.linear is not None and levels > 1
        self.g, self.stiffness = g, stiffness
        self.x = self.d_q = work = self.zeros_q()
        line, alpha = library.zeros((3,)), library.zeros(())
        going = moved = always = alpha == alpha
        bound = size = alpha
        for iteration in range(iterations):
            self.x = passes.forth(library, self.x, self.d_q, alpha)
            sums = self._gradient(work, shift, alpha, coarse=coarse, linear=True)
            bound, conjugate = bound if iteration else reduction**2 * sums[0], always
            if coarse:
                size = self.xp.sqrt(sums[0])
                assert self.linear is not None
                given = levels - 1, shift, iterations, reduction, *self._restricted(size)
                moved_there, self.linear.x = self.linear._relax(*given)
                sums, conjugate, size = passes.choose(library, sums, self._low_modes(size), size, moved_there)
            line, going = passes.next_line(library, sums, line, conjugate, going, bound, first=iteration == 0)
            pull, stiffness = passes.pull(library, self.stiffness, self._new_direction(line[0], size, coarse=coarse))
            alpha, going = passes.length(library, line, stiffness, going)
            work, moved = self.forward(pull), moved if iteration else going
        self.x = passes.forth(library, self.x, self.d_q, alpha)
        return moved, self.x


class ArraySmoothGrid(_Descending, PressedModes):
    """Gap z and direction d over the points, spectra of the gradient and of d; and the coarser grids.

    Parameters
    ----------
    library, grid, stiffness_q : as for :class:`continuum.solve.arrays.modes.Modes`.
    smallest : grids of no more points along a side have no coarser one.
    precision : of the linear problems, the name of a type.
    coarser : number of coarser grids wanted; fewer if the grid cannot be halved so often.
    sampled : whether coarser grids take every second point of the offset, which may jump, instead of its waves.
    """

    FIELDS = SMOOTH_FIELDS
    boxes, corrected = None, False
    contact: ArrayContact | None = None
    law: Law
    wall: passes.DeviceLaw
    pressure = np.nan
    offset: Array = None
    start: Array = None
    z: Array = None
    traction: Array = None
    _energy: Any = 0.0
    """Mean of φ at z."""
    _before: tuple[Array, Any] = None, 0.0
    """Traction and energy where the steps along d began."""
    _size = 0.0
    """Length of the gradient that the coarse step was made for; zero where that did not descend."""

    def __init__(
        self,
        library: Library,
        grid: Grid,
        stiffness_q: Real,
        smallest: int,
        precision: str,
        coarser: int,
        *,
        sampled: bool,
    ) -> None:
        super().__init__(library, grid, stiffness_q)
        self._sampled, below = sampled, grid.coarser
        self.coarser: ArraySmoothGrid | None = None
        if coarser > 0 and below is not None and grid.narrowest > smallest and library.fits(grid, below):
            K = grid.low_q(stiffness_q, below)
            self.coarser = ArraySmoothGrid(library, below, K, smallest, precision, coarser - 1, sampled=sampled)
            self.linear = ArrayLinearGrid(library, below, K, precision, self.coarser.linear)
            contact = SlabContact if library.parts > 1 else ArrayContact
            self.contact = contact(self, grid.greatest_wave(stiffness_q, along_y=True))

    @property
    def chain(self) -> list[ArraySmoothGrid]:
        """The grid itself and all coarser ones."""
        return [self, *(self.coarser.chain if self.coarser else [])]

    @property
    def work(self) -> list[Work]:
        finer = [None, *(grid.linear for grid in self.chain)]
        transforms = [g.transforms + (f.transforms if f else 0) for g, f in zip(self.chain, finer, strict=False)]
        return [Work(g.grid.shape, t / 2, g.trials, 0.0) for g, t in zip(self.chain, transforms, strict=True)]

    # --- where it starts ---------------------------------------------------------------------------------------

    def set_problem(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        fields = (offset,) if start is None else (offset, start)
        if not np.isfinite([lift, *map(self.grid.total, fields)]).all():
            return False
        self.offset = self.library.put_field(self.grid, offset) + lift
        self.start = None if start is None else self.library.put_field(self.grid, start)
        wall, held = passes.DeviceLaw.on(self.library, law), bool(np.isinf(mean_stiffness))
        for grid in self.chain:
            grid.law, grid.wall, grid.pressure = law, wall, pressure
            for each in (grid, grid.linear) if grid.linear else (grid,):
                each.held, each.transforms, each.trials = held, 0, 0
                each.set_mean_stiffness(1.0 if held else mean_stiffness)
            grid.clear()
        return True

    def set_coarser_problem(self, *, started: bool) -> None:
        below = self.chain[1]
        if self._sampled:
            below.offset = self.sampled(self.offset, below.grid)
        else:
            below.offset = below.inverse(self.below(self.forward(self.offset)))
        below.clear()
        if started:
            below.start = below.offset - below.inverse(self.below(self.forward(self.offset - self.z)))

    def go_to_start(self) -> None:
        u = self.offset - self.start
        self._go_to(u - mean(self.xp, u) if self.held else u)

    def go_to_zero(self) -> None:
        self._go_to(self.zeros())

    def go_to_coarser(self) -> None:
        below = self.chain[1]
        u = below.offset - below.z
        u = self.xp.where(self.xp.isfinite(mean(self.xp, u)), u, 0.0)
        self._go_to(self.inverse(self.above(below.forward(u))))
        below.release()

    def _go_to(self, u: Array) -> None:
        """Begin at a displacement: z, its traction, and g without that."""
        (row, column), xp, wall = self.marks.first, self.xp, self.wall
        pressed = passes.respond_at(self.library, self.offset, u, wall.parameters, law=wall.formula)
        self.z, self.traction, self.stiffness, self._energy = pressed
        force = self.library.put([self.pressure, 0.0])
        self.change, self.g = self.traction, self.K * self.forward(u) - xp.where(row & column, force, 0.0)

    # --- an iteration ------------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        work = self.zeros_q() if complete else self.forward(self.change)
        step = self.library.number(0.0 if complete else alpha)
        return self.library.get(self._gradient(work, shift, step, coarse=coarse, linear=False))

    def restrict(self, size: float) -> None:
        assert self.linear is not None
        self.linear.g, self.linear.stiffness = self._restricted(self.library.number(size))

    def low_modes(self, shift: float, size: float) -> Real:
        self._size = size
        sums: Real = self.library.get(self._low_modes(self.library.number(size)))[0]
        return sums

    def low_gradient(self, shift: float) -> Real:
        self._size = 0.0
        sums: Real = self.library.get(self._low_modes(self.library.number(1.0)))[1]
        return sums

    def new_direction(self, beta: float, *, coarse: bool) -> float:
        self.d = self._new_direction(self.library.number(beta), self.library.number(self._size), coarse=coarse)
        return float(passes.curvature(self.library, self.stiffness, self.d))

    def line(self, alpha: float) -> tuple[float, float]:
        self.trials += 1
        given = self.z, self.d, self.traction, self.wall.parameters, self.library.number(alpha)
        slope, curvature = self.library.get(passes.along(self.library, *given, law=self.wall.formula))
        return float(slope), float(curvature)

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        if step == alpha:
            self._before = self.traction, self._energy
        before, energy_before = self._before
        given = self.z, self.d, before, self.wall.parameters, self.library.number(step)
        self.z, self.traction, self.change, self.stiffness, means = passes.step_along(
            self.library, *given, law=self.wall.formula
        )
        slope, work, self._energy, size = (float(each) for each in self.library.get(means))
        return slope, self._energy - float(energy_before) - alpha * work, size

    def clear(self) -> None:
        self.d_q = self.zeros_q()

    # --- the outcome -------------------------------------------------------------------------------------------

    def residual(self) -> float:
        self._go_to(self.offset - self.z)
        self.g = self.g + self.forward(self.change)
        if self.held:
            self.g = without_mean(self.xp, self.g, self.marks)
        return math.sqrt(square(self.library, self.g, self.marks.weights))

    def look(self) -> Real:
        return self.library.get_field(self.grid, self.z)

    def hand_out(self) -> Real:
        gap = self.library.get_field(self.grid, self.z)
        self.release()
        return gap

    def release(self) -> None:
        """Give the memory of the fields back."""
        self.z = self.d = self.traction = self.stiffness = self.offset = self.start = None
        self.change = None
        self._before = None, 0.0
        if self.contact is not None:
            self.contact.forget()

    # --- what only processor cores have ------------------------------------------------------------------------

    def has_tiles(self, *, below: bool = False) -> bool:
        return False

    def correct(self, goal: Goal, history: list[Iteration], iterations: int, *, coarser: bool) -> None:
        return None

    def hand_down(self) -> bool:
        return False

    def relax_boxes(self, descend: Any) -> float:
        raise NotImplementedError
