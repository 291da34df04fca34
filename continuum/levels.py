"""The grids of the minimiser: the arrays of each, what was done on it, and the way from one to the next."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from continuum import laws, sweeps
from continuum.grid import Complex, Grid, Real

__all__ = ["LEVELS", "SMALLEST", "Level", "Work", "parts", "prolong", "restrict"]

SMALLEST, LEVELS = 64, 3
"""Grids of no more points along a side have no coarser one; a step uses at most so many grids."""


class Work(NamedTuple):
    """What was done on one grid."""

    shape: tuple[int, int]
    fft_pairs: float
    """Forward and inverse transforms, halved, of this grid."""
    sweeps: int
    """Evaluations of the line search."""
    fft_seconds: float


class Level:
    """The arrays of one grid and its work so far: z, the direction d and a work field, their spectra, and K."""

    def __init__(self, grid: Grid, stiffness_q: Real, levels: int) -> None:
        self.grid = grid
        self.held = bool(np.isinf(stiffness_q[0, 0]))
        self.K = np.where(np.isfinite(stiffness_q), stiffness_q, 1.0)
        self.z, self.direction, self.work = grid.empty(), grid.empty(), grid.empty()
        self.g_q, self.d_q, self.work_q = grid.empty_q(), grid.empty_q(), grid.empty_q()
        self.near = np.zeros((grid.shape[0], -(-grid.shape[1] // laws.TILE)), dtype=np.bool_)
        self.single = -1 if grid.shape[1] % 2 else self.K.shape[1] - 1
        self.transforms, self.sweeps, self.fft_seconds = 0, 0, 0.0
        self.coarser: Level | None = None
        self.low = (0, 0)
        coarser = grid.coarser
        if levels > 1 and coarser is not None and min(grid.shape) > SMALLEST:
            rows, columns = coarser.shape_q
            cut = np.r_[: rows // 2, grid.shape[0] - rows // 2 : grid.shape[0]]
            self.coarser = Level(coarser, stiffness_q[cut, :columns], levels - 1)
            self.low = rows // 2, columns - 1

    @property
    def chain(self) -> list[Level]:
        """Itself and all coarser ones."""
        return [self, *(self.coarser.chain if self.coarser else [])]

    def forward(self) -> None:
        """Spectrum of the work field; a mean that is held has no gradient."""
        began = time.perf_counter()
        self.grid.forward(self.work, out=self.work_q)
        self.fft_seconds += time.perf_counter() - began
        self.transforms += 1
        if self.held:
            self.work_q[0, 0] = 0.0

    def inverse(self) -> None:
        """Work field of its spectrum, which is destroyed."""
        began = time.perf_counter()
        self.grid.inverse(self.work_q, out=self.work, overwrite=True)
        self.fft_seconds += time.perf_counter() - began
        self.transforms += 1

    def sweep(self, kernel: Callable[..., None], *arguments: object) -> Real:
        """Run a sweep over all rows; small grids are not worth the start of threads."""
        rows = self.grid.shape[0]
        return sweeps.over_rows(kernel, rows, self.grid.threads if rows >= 512 else 1, *arguments)


def parts(spectrum: Complex) -> Real:
    """A padded spectrum as real and imaginary parts in turn, without a copy."""
    padded: Real = spectrum.base.view(np.float64)  # type: ignore[union-attr]
    return padded[:, : 2 * spectrum.shape[1]]


def restrict(fine: Complex, coarse: Complex) -> None:
    """The modes that a coarser grid carries, its Nyquist modes left out."""
    m, n = coarse.shape[0] // 2, coarse.shape[1] - 1
    coarse[...] = 0
    coarse[:m, :n] = fine[:m, :n]
    coarse[m + 1 :, :n] = fine[fine.shape[0] - m + 1 :, :n]


def prolong(coarse: Complex, fine: Complex) -> None:
    """A half spectrum on a finer grid: zero beyond the modes of the coarse one."""
    m, n = coarse.shape[0] // 2, coarse.shape[1] - 1
    fine[...] = 0
    fine[:m, :n] = coarse[:m, :n]
    fine[fine.shape[0] - m + 1 :, :n] = coarse[m + 1 :, :n]
