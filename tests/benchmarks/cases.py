"""The problems of the benchmarks and what is asked of them: one place for every number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from continuum.model.grid import Grid, Real
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.solve.cpu.levels import restrict

__all__ = [
    "ADHESION_LENGTHS",
    "AREA",
    "MEMORY_ALLOWED",
    "MOST_POINTS",
    "PAIRS_ALLOWED",
    "PEER_ADHESION_LENGTH",
    "PRESSURE",
    "SEEDS",
    "SIZES",
    "TOLERANCE",
    "Rough",
]

SIZES = (512, 1024, 2048, 4096)
"""Points a side, if nothing else is asked for."""
MOST_POINTS = {"work": 4096, "iteration": 4096, "adhesive": 2048, "hard_wall": 2048, "seeds": 1024, "slow": 512}
"""Largest grids of each table; beyond, only work and memory of one load point.

``seeds``: of several seeds under the adhesive peer and of repeated iterations; ``slow``: of its slower optimiser.
"""

ADHESION_LENGTHS = (0.0, 0.005, 0.05)
PEER_ADHESION_LENGTH = 0.005
"""At which the peers are compared."""
SEEDS = (1, 2, 3)
AREA = 0.01
"""Repulsive area fraction near which the work per load point is counted."""
TOLERANCE = 1e-7
"""Residual, root mean square, in E*: 1e-6 h'rms."""
PRESSURE = 4e-4
"""Mean pressure on the hard wall, in E*."""
PAIRS_ALLOWED = {512: (35, 60, 70), 4096: (65, 110, 110)}
"""Bounds of the median number of FFT pairs at each adhesion length."""
MEMORY_ALLOWED = {4096: 1536, 8192: 6144}
"""Bounds of the peak memory of a process, in MiB."""


@dataclass(frozen=True)
class Rough:
    """A self-affine wall on n x n points one a0 apart: H = 0.8, h'rms = 0.1 exactly, λ_L = L/2."""

    n: int
    seed: int
    lambda_s: float = 32.0

    @property
    def grid(self) -> Grid:
        """One thread."""
        return Grid.square(self.n)

    def heights(self) -> Real:
        """In a0; not to be changed, so that a problem needs no copy."""
        spectrum = SelfAffine(0.8, 0.1, self.lambda_s, self.n / 2)
        heights = spectrum.synthesise(self.grid, np.random.default_rng(self.seed))
        heights.flags.writeable = False
        return heights

    def problem(self, adhesion_length: float, heights: Real | None = None) -> ContactProblem:
        """Under the paper's law, on an incompressible half-space; heights that are at hand need not be made again."""
        wall = LennardJonesSpline(adhesion_length=adhesion_length)
        return ContactProblem(self.grid, wall, self.heights() if heights is None else heights, HalfSpace("clamped"))

    def coarse(self, adhesion_length: float, factor: int = 4) -> ContactProblem:
        """The problem on every fourth point, its surface cut off in Fourier space: for the search of an area."""
        fine = self.problem(adhesion_length)
        m = self.n // factor
        grid = Grid((m, m), fine.grid.lengths)
        heights_q = grid.empty_q()
        restrict(fine.grid.forward(fine.heights), heights_q)
        return ContactProblem(grid, fine.wall, grid.inverse(heights_q), fine.substrate)
