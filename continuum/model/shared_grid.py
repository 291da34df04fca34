"""A grid whose points several processes share: each has rows of a field, and columns of a half spectrum.

Process r of R has rows r nx/R to (r + 1) nx/R of a field, and of its sums over P slabs those of P/R.  Of a half
spectrum it has columns n with n mod P among its P/R numbers, shape (nx, P/R, k): column n is entry n // P of part n
mod P, as on the devices of :mod:`continuum.solve.arrays.slabs`, so that each has the same share of the modes of every
coarser grid.  Columns beyond the last one make parts equal and have no weight.

Sums are made over slabs first and then in their order, so that they do not depend on the number of processes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.arguments import array
from continuum.model import fourier
from continuum.model.fourier import Complex, Real, block_edges
from continuum.model.grid import Grid


class Company(Protocol):
    """Processes that work together, each with the same number of slabs."""

    rank: int
    size: int
    """Number of processes."""
    parts: int
    """Number of slabs of all of them."""

    def gather(self, values: NDArray[Any]) -> NDArray[Any]:
        """Arrays of one shape of all processes, in their order along a new first axis; in each process."""

    def exchange(self, blocks: NDArray[Any]) -> NDArray[Any]:
        """Block j of what process i gives, shape (size, ...), becomes block i of what process j gets."""


def columns_of_part(columns: int, parts: int) -> int:
    """Columns of each part of a half spectrum: at least two, so that one alone stands for all."""
    return max(2, -(-columns // parts))


def own_rows(rows: int, rank: int, size: int) -> slice:
    """Rows of a field that a process has."""
    return slice(rows * rank // size, rows * (rank + 1) // size)


@dataclass(frozen=True)
class SharedGrid(Grid):
    """A grid in one of the processes that share it; ``shape`` and ``lengths`` are those of all points."""

    company: Company = field(compare=False, kw_only=True)

    # --- what this process has ---------------------------------------------------------------------------------

    @property
    def shared(self) -> bool:
        return True

    @property
    def rows(self) -> slice:
        """Rows of a field in this process."""
        return own_rows(self.shape[0], self.company.rank, self.company.size)

    @property
    def shape_here(self) -> tuple[int, int]:
        return self.shape[0] // self.company.size, self.shape[1]

    @property
    def shape_q_here(self) -> tuple[int, ...]:
        parts = self.company.parts
        return self.shape[0], parts // self.company.size, columns_of_part(self.shape_q[1], parts)

    @property
    def slabs(self) -> tuple[slice, ...]:
        own = self.company.parts // self.company.size
        return tuple(own_rows(self.shape_here[0], part, own) for part in range(own))

    @property
    def equal_slabs(self) -> bool:
        """Whether its rows make equal slabs."""
        return self.shape[0] % self.company.parts == 0

    @property
    def positions(self) -> tuple[Real, Real]:
        x, y = super().positions
        return x[self.rows], y

    @property
    def mode_numbers(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        m, _ = super().mode_numbers
        _, own, k = self.shape_q_here
        part = np.arange(own) + self.company.rank * own
        n = part[:, None] + self.company.parts * np.arange(k)
        return m[:, :, None], n[None]

    @cached_property
    def mode_weights(self) -> Real:
        n, (_, columns) = self.mode_numbers[1], self.shape_q
        found: Real = super().mode_weights[0, np.minimum(n, columns - 1)] * (n < columns)
        return found

    def places_q(self, m: NDArray[np.int64], n: NDArray[np.int64]) -> tuple[NDArray[np.bool_], tuple[Any, ...]]:
        """Which of some modes this process has, and the places of these in its half spectrum."""
        parts, own = self.company.parts, self.shape_q_here[1]
        mine = n % parts // own == self.company.rank
        m, n = m[mine], n[mine]
        return mine, (m % self.shape[0], n % parts % own, n // parts)

    def modes_of(self, values_q: NDArray[Any]) -> NDArray[Any]:
        """The modes of this process, of a whole half spectrum."""
        return values_q[:, np.minimum(self.mode_numbers[1][0], self.shape_q[1] - 1)]

    # --- transforms --------------------------------------------------------------------------------------------

    def forward(self, values: Real) -> Complex:
        values = np.asarray(array("values", values, self.shape_here), dtype=np.float64)
        (nx, own, k), (rows, _), size = self.shape_q_here, self.shape_here, self.company.size
        half: Complex = np.zeros((rows, k * self.company.parts), dtype=np.complex128)
        for block in self._row_blocks():
            fourier.rows_forward(values[block], half[block, : self.shape_q[1]])
        dealt = half.reshape(rows, k, size, own).transpose(2, 0, 3, 1)
        del half
        spectrum: Complex = np.array(self.company.exchange(np.ascontiguousarray(dealt))).reshape(nx, own * k)
        for block in self._column_blocks():
            fourier.columns_forward(spectrum[:, block])
        return spectrum.reshape(nx, own, k)

    def inverse(self, values_q: Complex, *, overwrite: bool = False) -> Real:
        (nx, own, k), (rows, _), size = self.shape_q_here, self.shape_here, self.company.size
        given = array("values_q", values_q, self.shape_q_here, "c")
        spectrum: Complex = np.array(given, dtype=np.complex128, copy=None if overwrite else True).reshape(nx, own * k)
        for block in self._column_blocks():
            fourier.columns_inverse(spectrum[:, block])
        dealt = self.company.exchange(spectrum.reshape(size, rows, own, k))
        del spectrum
        half = np.ascontiguousarray(dealt.transpose(1, 3, 0, 2)).reshape(rows, k * self.company.parts)
        values: Real = np.empty(self.shape_here)
        for block in self._row_blocks():
            fourier.rows_inverse(half[block, : self.shape_q[1]], values[block])
        return values

    def _row_blocks(self) -> Iterator[slice]:
        """Blocks of rows to transform: those of each slab, as the last bits of some rows depend on their block."""
        for slab in self.slabs:
            for a, b in pairwise(block_edges(slab.stop - slab.start, (slab.stop - slab.start) * self.shape[1])):
                yield slice(slab.start + a, slab.start + b)

    def _column_blocks(self) -> Iterator[slice]:
        """The same of columns, those of each part."""
        rows, own, k = self.shape_q_here
        for part in range(own):
            for a, b in pairwise(block_edges(k, k * rows)):
                yield slice(part * k + a, part * k + b)

    def restricted(self, values_q: Complex, coarse: Grid) -> Complex:
        found: Complex = self.low_q(values_q, coarse)
        found[fourier.low_rows(coarse.shape[0])] = 0
        found[:, coarse.mode_numbers[1][0] >= coarse.shape_q[1] - 1] = 0
        return found

    def prolonged(self, values_q: Complex, fine: Grid) -> Complex:
        found: Complex = np.zeros(fine.shape_q_here, dtype=np.complex128)
        half, k = fourier.low_rows(self.shape[0]), self.shape_q_here[2]
        carried = np.where(self.mode_numbers[1] < self.shape_q[1] - 1, values_q, 0)
        found[:half, :, :k] = carried[:half]
        found[fine.shape[0] - half + 1 :, :, :k] = carried[half + 1 :]
        return found

    def waves_of(self, values_q: NDArray[Any], period: tuple[int, int]) -> NDArray[Any]:
        step = self.shape[1] // period[1]
        found = np.zeros((period[0], period[1] // 2 + 1))
        n = self.mode_numbers[1][0]
        mine = (n % step == 0) & (n < self.shape_q[1])
        found[:, n[mine] // step] = values_q[:: self.shape[0] // period[0]][:, mine]
        every: NDArray[Any] = self.company.gather(found).sum(axis=0)
        return every

    def _waves(self, *, along_y: bool) -> NDArray[np.bool_]:
        """Modes of the half spectrum but for q = 0, or for all waves along x."""
        m, n = self.mode_numbers
        return (n < self.shape_q[1]) & ((n > 0) if along_y else (n > 0) | (m != 0))

    def least_wave(self, values_q: Real) -> float:
        return self.least(np.where(self._waves(along_y=False), values_q, np.inf))

    def greatest_wave(self, values_q: Real, *, along_y: bool = False) -> float:
        return self.greatest(np.where(self._waves(along_y=along_y), values_q, -np.inf))

    def mean_mode(self, values_q: NDArray[Any]) -> NDArray[Any]:
        return values_q[: 0 if self.company.rank else 1, :1, :1]

    def first(self, values_q: Real) -> float:
        return float(self.company.gather(np.asarray(values_q[0, 0, 0]))[0])

    # --- numbers of all processes ------------------------------------------------------------------------------

    def together(self, sums: Real) -> Real:
        found: Real = sum(self.company.gather(np.asarray(sums)).reshape(self.company.parts, -1))  # in their order
        return found

    def total(self, values: NDArray[Any]) -> float:
        return float(self.together(np.array([[np.sum(values[slab], dtype=np.float64)] for slab in self.slabs]))[0])

    def total_q(self, values_q: Real) -> float:
        values_q = np.broadcast_to(values_q, self.shape_q_here)
        parts = range(self.shape_q_here[1])
        sums = np.array([[np.sum(np.ascontiguousarray(values_q[:, part]))] for part in parts])
        return float(self.together(sums)[0])

    def least(self, values: Real) -> float:
        return float(self.company.gather(np.asarray(values.min())).min())

    def greatest(self, values: Real) -> float:
        return float(self.company.gather(np.asarray(values.max())).max())

    def deviation(self, values: Real) -> float:
        mean = self.mean(values)
        return float(np.sqrt(self.mean((values - mean) ** 2)))

    def sample(self, values: Real, every: int) -> Real:
        found = np.full((-(-self.shape[0] // every), -(-self.shape[1] // every)), -np.inf)
        at = np.arange(0, self.shape[0], every)
        mine = (at >= self.rows.start) & (at < self.rows.stop)
        found[mine] = values[at[mine] - self.rows.start, ::every]
        whole: Real = self.company.gather(found).max(axis=0)
        return whole
