"""The second of two rough bodies, shifted and turned; both together are one wall."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from continuum.inputs.arguments import ArgumentError, field_of, number, pair
from continuum.inputs.keys import Seed
from continuum.inputs.tables import Description, Fault, constraint
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Moments, Surface, shifted

_Shift = Annotated[float, Field(ge=-1e6, le=1e6)]
BEYOND = "no shift, or one of zero, where nothing is repeated"
BEYOND_WHY = "what lies beyond the map is not known: cut the map of the second body where it is to lie"
_TURNS = "a multiple of 90 degrees: any other turn breaks the period"


def turned(grid: Grid, heights: Real, angle: float) -> Real:
    """Heights turned by an angle in degrees, a multiple of 90, or of 180 where the period is no square."""
    turns = number("angle", angle) / 90
    if not turns.is_integer():
        raise ArgumentError("angle", angle, _TURNS)
    if turns % 2 and not (grid.shape[0] == grid.shape[1] and grid.lengths[0] == grid.lengths[1]):
        raise ArgumentError("angle", angle, "a multiple of 180 degrees where the period is no square")
    return np.rot90(heights, int(turns) % 4)


def against(grid: Grid, heights: Real, other: Real, shift: tuple[float, float], angle: float) -> Real:
    """Heights of the one rigid wall that is equivalent to two bodies: with small slopes only their difference counts.

    Parameters
    ----------
    heights : heights of the upper body, shape ``grid.shape``, in a0, positive away from the other.
    other : heights of the lower body, positive towards the upper one.
    shift : shift of the lower body, in a0, periodic: of zero where nothing is repeated.
    angle : angle by which it is turned before the shift, in degrees.
    """
    along_x, along_y = (number("shift", length) for length in pair("shift", shift))
    return heights - shifted(grid, turned(grid, field_of("other", other, grid.shape), angle), (along_x, along_y))


class Counterface(Description):
    """[counterface]: a second rough body, below the surface; E* is that of both."""

    newer: ClassVar[frozenset[str]] = frozenset({"shift_seed"})

    surface: Surface
    """its heights, positive towards the surface; the keys of [surface]"""
    shift: tuple[_Shift, _Shift] = (0.0, 0.0)
    """shift along x and y, periodic, in a0; none where nothing is repeated"""
    shift_seed: Seed | None = None
    """seed of a uniformly random shift over the period; instead of shift"""
    angle: float = 0.0
    """angle by which it is turned before the shift, in degrees: a multiple of 90"""

    @constraint
    def _one_shift(self) -> Iterator[Fault]:
        if self.shift_seed is not None and any(self.shift):
            yield Fault(("shift",), "nothing where shift_seed draws it", "both are given")

    @constraint
    def _quarter_turns(self) -> Iterator[Fault]:
        if self.angle % 90:
            yield Fault(("angle",), _TURNS)

    def unfit(self, n: tuple[int, int], lengths: tuple[float, float], *, repeats: bool) -> Iterator[Fault]:
        """Faults: what the grid cannot resolve, or the period cannot hold; a shift where there is no period."""
        if not repeats and (self.shift_seed is not None or any(self.shift)):
            yield Fault(("counterface", "shift" if any(self.shift) else "shift_seed"), BEYOND, BEYOND_WHY)
        if self.angle % 180 and (n[0] != n[1] or lengths[0] != lengths[1]):
            yield Fault(("counterface", "angle"), "a multiple of 180 degrees where the period is no square")
        for found in (self.surface.too_short(n, lengths), self.surface.too_long(n, lengths)):
            yield from (replace(fault, key=("counterface", *fault.key)) for fault in found)

    def moved_by(self, grid: Grid) -> tuple[float, float]:
        """The shift, in a0."""
        if self.shift_seed is None:
            return self.shift
        along_x, along_y = np.random.default_rng(self.shift_seed).random(2) * grid.lengths
        return float(along_x), float(along_y)

    def under(self, grid: Grid, heights: Real, own: Real) -> Real:
        """Heights of the wall that is equivalent to a surface and this counterface."""
        return against(grid, heights, own, self.moved_by(grid), self.angle)

    def expected(self, grid: Grid, surface: Moments | None) -> Moments | None:
        """Moments of the sum of both independent random surfaces, whose squares add up."""
        own = self.surface.expected(grid)
        return Moments(*np.hypot(surface, own).tolist()) if surface is not None and own is not None else None
