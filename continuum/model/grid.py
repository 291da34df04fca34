"""The periodic grid: positions, wavevectors, Fourier transforms, integrals.  Geometry only; no physics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from continuum.inputs.arguments import array, count, number, pair
from continuum.inputs.keys import LARGEST, LARGEST_N, SMALLEST, ForBoth, Points
from continuum.inputs.tables import Fault, Table, constraint
from continuum.model import fourier
from continuum.model.fourier import Complex, Real, block_edges, padded

SHORTEST, LONGEST = SMALLEST, LARGEST
"""Bounds of periods, in any unit, within which fourth powers of wavevectors do not overflow."""


@dataclass(frozen=True)
class Grid:
    """A periodic rectangle of ``lengths`` (in a0) covered by ``shape`` points.

    Parameters
    ----------
    shape : (nx, ny), at least 2 points each; odd and non-square grids are allowed.  One point along x makes it a line
        contact.
    lengths : (Lx, Ly), the periods, in a0.

    Examples
    --------
    >>> import continuum as c
    >>> grid = c.Grid((64, 32), (64.0, 32.0))  # points, and periods in a0
    >>> grid == c.Grid((64, 32), (64, 32)), c.Grid.square(64).lengths
    (True, (64.0, 64.0))
    """

    shape: tuple[int, int]
    lengths: tuple[float, float]

    def __post_init__(self) -> None:
        shape = tuple(count("shape", n, least) for n, least in zip(pair("shape", self.shape), (1, 2), strict=True))
        lengths = tuple(number("lengths", each, least=SHORTEST, most=LONGEST) for each in pair("lengths", self.lengths))
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "lengths", lengths)

    @classmethod
    def square(cls, n: int, spacing: float = 1.0) -> Grid:
        """An n x n grid of the given spacing: one point for each surface atom when the spacing is a0."""
        length = count("n", n, 2) * number("spacing", spacing, least=SHORTEST, most=LONGEST)
        return cls((n, n), (length, length))

    @property
    def size(self) -> int:
        return self.shape[0] * self.shape[1]

    @property
    def is_line(self) -> bool:
        """True if the grid is one point wide: a line contact in two dimensions."""
        return self.shape[0] == 1

    @property
    def narrowest(self) -> int:
        """Points along the shorter side; for a line, along the line."""
        return self.shape[1] if self.is_line else min(self.shape)

    @property
    def shape_q(self) -> tuple[int, int]:
        """Shape of a half spectrum."""
        return self.shape[0], self.shape[1] // 2 + 1

    @property
    def shared(self) -> bool:
        """Whether processes share it."""
        return False

    @property
    def shape_here(self) -> tuple[int, int]:
        """Shape of a field in this process: all of it, unless processes share the grid (:mod:`.shared_grid`)."""
        return self.shape

    @property
    def rows(self) -> slice:
        """Rows of a field in this process."""
        return slice(0, self.shape[0])

    @property
    def shape_q_here(self) -> tuple[int, ...]:
        """Shape of a half spectrum in this process."""
        return self.shape_q

    @property
    def slabs(self) -> tuple[slice, ...]:
        """Rows of a field in this process over which sums are made first, one slice for each slab."""
        return (self.rows,)

    @property
    def equal_slabs(self) -> bool:
        """Whether its rows make equal slabs for all processes."""
        return True

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of neighbouring points along x and y, in a0."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]

    @property
    def widest_step(self) -> float:
        """Larger of the spacings along x and y, in a0; for a line, the spacing along it."""
        return self.spacing[1] if self.is_line else max(self.spacing)

    @property
    def shortest_period(self) -> float:
        """Shorter of the two periods, in a0; for a line, the period along it."""
        return self.lengths[1] if self.is_line else min(self.lengths)

    @property
    def area(self) -> float:
        """Area of the period, A0, in a0²."""
        return self.lengths[0] * self.lengths[1]

    @property
    def cell_area(self) -> float:
        """Area of one point, in a0²."""
        return self.area / self.size

    @property
    def positions(self) -> tuple[Real, Real]:
        """Coordinates x, shape (nx, 1), and y, shape (1, ny), in a0."""
        x = np.arange(self.shape[0], dtype=np.float64)[:, None] * self.spacing[0]
        y = np.arange(self.shape[1], dtype=np.float64)[None, :] * self.spacing[1]
        return x, y

    @property
    def mode_numbers(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Integers m, shape (nx, 1), and n, shape (1, ny//2+1), of q = 2 pi (m/Lx, n/Ly)."""
        nx, ny = self.shape
        m = (np.arange(nx) + nx // 2) % nx - nx // 2
        return m[:, None], np.arange(ny // 2 + 1)[None, :]

    @property
    def wavevectors(self) -> tuple[Real, Real]:
        """Components qx, shape (nx, 1), and qy, shape (1, ny//2+1), in 1/a0."""
        m, n = self.mode_numbers
        per_mode = [2 * np.pi / length for length in self.lengths]
        return m.astype(np.float64) * per_mode[0], n.astype(np.float64) * per_mode[1]

    @property
    def wavenumber(self) -> Real:
        """``|q|`` over the half spectrum, in 1/a0."""
        qx, qy = self.wavevectors
        return np.hypot(qx, qy)

    @cached_property
    def mode_weights(self) -> Real:
        """Weight of each stored mode in a sum over all q: 1 or 2; shape (1, ny//2+1)."""
        ny = self.shape[1]
        # A mode stands for its conjugate too, except in the columns n = 0 and, of an even ny, ny/2, which have both.
        weights = np.full((1, ny // 2 + 1), 2.0)
        weights[0, 0] = 1.0
        if ny % 2 == 0:
            weights[0, -1] = 1.0
        return weights

    def forward(self, values: Real) -> Complex:
        """Half spectrum of a field: values_q = mean(values exp(-i q x))."""
        values = np.asarray(array("values", values, self.shape), dtype=np.float64)
        spectrum: Complex = padded(self.shape_q, np.complex128)
        for a, b in pairwise(block_edges(self.shape[0], self.size)):
            fourier.rows_forward(values[a:b], spectrum[a:b])
        for a, b in pairwise(block_edges(self.shape_q[1], self.size)):
            fourier.columns_forward(spectrum[:, a:b])
        return spectrum

    def inverse(self, values_q: Complex, *, overwrite: bool = False) -> Real:
        """Field of a half spectrum: values(x) = sum over q of values_q exp(i q x).

        With ``overwrite`` the spectrum is destroyed, which saves memory.
        """
        values = np.empty(self.shape)
        spectrum = np.asarray(array("values_q", values_q, self.shape_q, "c"), dtype=np.complex128)
        if not overwrite:
            spectrum = padded(self.shape_q, np.complex128)
            spectrum[...] = values_q
        for a, b in pairwise(block_edges(self.shape_q[1], self.size)):
            fourier.columns_inverse(spectrum[:, a:b])
        for a, b in pairwise(block_edges(self.shape[0], self.size)):
            fourier.rows_inverse(spectrum[a:b], values[a:b])
        return values

    @property
    def coarser(self) -> Self | None:
        """Grid with half as many points a side, or nearly half for sides that are no multiple of 4; None if too small.

        Its half spectrum is part of that of this grid.
        """
        nx, ny = self.shape
        coarse = 1 if self.is_line else _half(nx), _half(ny)
        return self.of_points(coarse) if min(coarse) > 0 else None

    def of_points(self, shape: tuple[int, int]) -> Self:
        """A grid of other points over the same period, shared by the same processes."""
        return replace(self, shape=shape)

    def sampled(self, coarse: Grid) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of the points at or just before those of a coarser grid of the same period."""
        rows, columns = (np.arange(c) * n // c for n, c in zip(self.shape, coarse.shape, strict=True))
        return rows, columns

    def low_q(self, values_q: NDArray[Any], coarse: Grid) -> NDArray[Any]:
        """The part of a half spectrum on the modes of a coarser grid of the same period, in a copy."""
        return values_q[..., : coarse.shape_q_here[-1]][coarse.mode_numbers[0].ravel()]

    def restricted(self, values_q: Complex, coarse: Grid) -> Complex:
        """The part on the modes of a coarser grid, without its Nyquist modes."""
        found: Complex = padded(coarse.shape_q, np.complex128)
        fourier.restrict(values_q, found)
        return found

    def prolonged(self, values_q: Complex, fine: Grid) -> Complex:
        """Half spectrum on a finer grid: zero beyond the modes of this one, and on its Nyquist modes."""
        found: Complex = padded(fine.shape_q, np.complex128)
        fourier.prolong(values_q, found)
        return found

    def places_q(self, m: NDArray[np.int64], n: NDArray[np.int64]) -> tuple[Any, tuple[Any, ...]]:
        """Which of some modes this process has, and the places of these in its half spectrum."""
        return slice(None), (m % self.shape[0], n)

    def modes_of(self, values_q: NDArray[Any]) -> NDArray[Any]:
        """Copy of the modes of this process from a whole half spectrum."""
        return np.array(values_q)

    def waves_of(self, values_q: NDArray[Any], period: tuple[int, int]) -> NDArray[Any]:
        """The modes of a half spectrum whose waves have the given periods in points, divisors of the sides."""
        return values_q[:: self.shape[0] // period[0], :: self.shape[1] // period[1]].copy()

    def least_wave(self, values_q: Real) -> float:
        """Smallest value of a half spectrum, except at q = 0."""
        return float(values_q.ravel()[1:].min())

    def greatest_wave(self, values_q: Real, *, along_y: bool = False) -> float:
        """Largest value of a half spectrum, except at q = 0; or only over waves that vary along y."""
        return float((values_q[:, 1:] if along_y else values_q.ravel()[1:]).max())

    def mean_mode(self, values_q: NDArray[Any]) -> NDArray[Any]:
        """View of the mode q = 0 of a half spectrum: one value, or none in a process that does not have this mode."""
        return values_q[:1, :1]

    def first(self, values_q: Real) -> float:
        """Value of the mode q = 0."""
        return float(values_q[0, 0])

    def together(self, sums: Real) -> Real:
        """Sums over all points, from those of the slabs in this process, shape (slabs, numbers)."""
        found: Real = sums[0]
        return found

    def total(self, values: NDArray[Any]) -> float:
        """Sum of a field over all points."""
        return float(np.sum(values))

    def total_q(self, values_q: Real) -> float:
        """Sum of a real half spectrum over its modes, each counted once: multiply by ``mode_weights`` before."""
        return float(np.sum(values_q))

    def least(self, values: Real) -> float:
        """Smallest value of a field."""
        return float(values.min())

    def greatest(self, values: Real) -> float:
        """Largest value of a field."""
        return float(values.max())

    def deviation(self, values: Real) -> float:
        """Standard deviation of a field over its points."""
        return float(np.std(values))

    def sample(self, values: Real, every: int) -> Real:
        """Every n-th row and column of a field."""
        return values[::every, ::every]

    def integrate(self, values: Real) -> float:
        """Integral of a field over the period: a traction becomes a load, an energy per area an energy."""
        return self.total(array("values", values, self.shape_here, "fiub")) * self.cell_area

    def mean(self, values: Real) -> float:
        """Mean of a field over the period."""
        return self.total(array("values", values, self.shape_here, "fiub")) / self.size

    def inner_q(self, a_q: Complex, b_q: Complex) -> float:
        """Mean over the grid of a(x) b(x), from the half spectra (Parseval)."""
        a_q, b_q = array("a_q", a_q, self.shape_q_here, "c"), array("b_q", b_q, self.shape_q_here, "c")
        product = a_q.real * b_q.real + a_q.imag * b_q.imag
        return self.total_q(product * self.mode_weights)


def _half(n: int) -> int:
    """Points of the next coarser grid along a side of n: half, or the multiple of 8 next to it, which halves again."""
    return n // 2 if n % 4 == 0 else 8 * round(n / 16)


_POINTS = f"a whole number from 2 to {LARGEST_N}, or two in a list [nx, ny]"
_Period = Annotated[float, Field(ge=1, le=LARGEST_N)]


class GridTable(Table):
    """[grid]: the points of the surface, one or k x k for each surface atom."""

    n: Annotated[tuple[Points, Points], ForBoth]
    """points along x and y; [1, ny] is a line"""
    period: Annotated[tuple[_Period, _Period], ForBoth] | None = None
    """period along x and y, in a0; n if not given"""

    @property
    def lengths(self) -> tuple[float, float]:
        """Periods, in a0."""
        return self.period or (float(self.n[0]), float(self.n[1]))

    @constraint
    def _enough_points(self) -> Iterator[Fault]:
        if self.n[1] < 2:
            cause = "a line lies along y: [1, ny]" if self.n[0] > 1 else ""
            yield Fault(("n",), _POINTS, cause)

    @constraint
    def _whole_atoms(self) -> Iterator[Fault]:
        if any(length != round(length) for length in self.lengths):
            cause = "the surface is a crystal, so that a period has whole atoms"
            yield Fault(("period",), "a whole number of a0", cause)
        elif any(n % length for n, length in zip(self.n, self.lengths, strict=True)):
            cause = "n is meant to be the period, or k times the period for k x k points per atom"
            period = " and ".join(f"{length:g}" for length in dict.fromkeys(self.lengths))
            yield Fault(("n",), f"a multiple of the period, {period}: spacing a0, a0/2, ...", cause)

    def plain(self, *, identity: bool = False) -> dict[str, Any]:
        """Keys and values for JSON, with the period that is used."""
        return {**super().plain(identity=identity), "period": list(self.lengths)}

    def build(self) -> Grid:
        return Grid(self.n, self.lengths)
