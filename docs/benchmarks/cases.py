"""The problems of the benchmarks and what is asked of them: one place for every number."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import padded, restrict
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from tests.problems import Rough

__all__ = [
    "ADHESION_LENGTHS",
    "AREA",
    "MEMORY_ALLOWED",
    "MOST_POINTS",
    "PAIRS_ALLOWED",
    "PEER_ADHESION_LENGTH",
    "PEER_AREAS",
    "PEER_PRESSURES",
    "PEER_SURFACES",
    "PRESSURE",
    "SEEDS",
    "SIZES",
    "TOLERANCE",
    "coarse",
    "rough",
]

SIZES = (512, 1024, 2048, 4096)
"""Points a side, if nothing else is asked for."""
MOST_POINTS = {
    "work": 4096,
    "iteration": 4096,
    "adhesive": 1024,
    "hard_wall": 2048,
    "seeds": 1024,
    "threshold": 1024,
    "kinds": 512,
    "searches": 1024,
}
"""Largest grids of each table; beyond, only work and memory of one load point.

``seeds``: of several seeds under the hard wall and of repeated iterations.
"""

ADHESION_LENGTHS = (0.0, 0.005, 0.05)
PEER_ADHESION_LENGTH = 0.005
"""Of atoms, and of contacts of other kinds."""
PEER_SURFACES = ((32.0, 0.8, 0.0005, 1024), (32.0, 0.8, 0.005, 1024), (32.0, 0.8, 0.05, 512), (4.0, 0.3, 0.005, 512))
"""λ_s in a0, H, l_a in a0 and the largest grid of the comparison with the adhesive peer."""
PEER_AREAS = (0.003, 0.01, 0.05, 0.2, 0.5)
"""Repulsive areas of each, from few contacts to many."""
SEEDS = (1, 2, 3)
AREA = 0.01
"""Repulsive area fraction near which the work per load point is counted."""
TOLERANCE = 1e-7
"""Residual, root mean square, in E*: 1e-6 h'rms."""
PRESSURE = 4e-4
"""Mean pressure on the hard wall, in E*, at about 1 % of the area."""
PEER_PRESSURES = (1.6e-4, PRESSURE, 2e-3, 9e-3)
"""Mean pressures at which the peers of the hard wall are compared: some 0.4 to 19 % of the area."""
PAIRS_ALLOWED = {512: (35, 60, 70), 4096: (65, 110, 110)}
"""Bounds of the median number of FFT pairs at each adhesion length."""
MEMORY_ALLOWED = {4096: 1536, 8192: 6144}
"""Bounds of the peak memory of a process, in MiB."""


def rough(n: int, seed: int, adhesion_length: float = 0.0, lambda_s: float = 32.0, hurst: float = 0.8) -> Rough:
    """The wall of all benchmarks: h'rms = 0.1 exactly, λ_L = L/2."""
    return Rough(n, adhesion_length, lambda_s, seed, hurst=hurst)


def coarse(surface: Rough, factor: int = 4) -> ContactProblem:
    """The problem on every fourth point, its surface cut off in Fourier space: for the search of an area."""
    fine = surface.problem()
    m = surface.n // factor
    grid = Grid((m, m), fine.grid.lengths)
    heights_q = padded(grid.shape_q, np.complex128)
    restrict(fine.grid.forward(fine.heights), heights_q)
    return ContactProblem(grid, fine.wall, grid.inverse(heights_q), fine.substrate)
