"""One grid on the device: its stiffness, a spectrum to work in, transforms of it, sums, and what was done."""

from __future__ import annotations

from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.cuda import points, spectra
from continuum.solve.cuda.device import Array, Kernel, Reduction, empty, to_device
from continuum.solve.cuda.transforms import Transforms
from continuum.solve.solution import Work


class Fields:
    """The arrays that both solvers need; all fields are of shape ``grid.shape``, without padding.

    Parameters
    ----------
    grid : gives the shape.
    K : over the half spectrum, shape ``grid.shape_q``, finite.
    larger : those of a finer grid, whose memory for transforms and sums is used.
    """

    def __init__(self, grid: Grid, K: Real, larger: Fields | None = None) -> None:
        self.grid, self.size, self.per_point = grid, grid.size, 1.0 / grid.size
        self.rows = grid.shape[0]
        self.single = -1 if grid.shape[1] % 2 else grid.shape_q[1] - 1
        self.w = self.spectrum()
        self.transform: Transforms = Transforms(grid.shape, larger.transform if larger else None)
        self.K = to_device(K)
        self.sums: Reduction = larger.sums if larger else Reduction()
        self.transforms = self.trials = 0

    def spectrum(self) -> Array:
        """Memory of a half spectrum, not set."""
        return empty(self.rows, 2 * self.grid.shape_q[1])

    def field(self, kind: Any = np.float64) -> Array:
        """Memory of a field, not set."""
        return empty(*self.grid.shape, kind)

    @property
    def work(self) -> Work:
        """What was done on this grid for the problem at hand; transforms are started and not waited for: no times."""
        return Work(self.grid.shape, self.transforms / 2, self.trials, 0.0)

    def forget_work(self) -> None:
        """Count from zero."""
        self.transforms = self.trials = 0

    def forward(self) -> None:
        """Transform the field in ``w``, scaled by who wrote it."""
        self.transforms += 1
        self.transform.forward(self.w)

    def inverse(self) -> None:
        """Transform the spectrum in ``w``."""
        self.transforms += 1
        self.transform.inverse(self.w)

    def run(self, kernel: Kernel, *arguments: Any) -> None:
        """Start a kernel over the rows."""
        kernel(self.rows, *arguments)

    def sum(self, kernel: Kernel, *arguments: Any, largest: int = -1) -> Real:
        """Start a kernel over the rows and wait for its sums."""
        return self.sums(kernel, self.rows, *arguments, largest=largest)

    def upload(self, field: Array, values: Real) -> bool:
        """Copy a field to the device; returns whether it is finite."""
        field.copy_to_device(np.ascontiguousarray(values, dtype=np.float64))
        return bool(self.sum(points.total, field)[1] == 0)

    def set_mean_stiffness(self, K0: float) -> None:
        """Stiffness at q = 0 of the problem at hand."""
        points.put(1, self.K, K0)

    def fluctuation_energy(self, offset: Array, gap: Array) -> float:
        """½ Σ K |u_q|² of u = offset - gap without its mean."""
        self.sum(points.displace, self.w, gap, offset, 0.0, self.per_point)
        self.transform.forward(self.w)
        return 0.5 * float(self.sum(spectra.energy, self.w, self.K, self.single)[0])
