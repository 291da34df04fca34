"""What a run will take, from its input alone: memory, transforms, and core-seconds of this machine.

The counts of transforms were fitted to the runs of ``inputs/``, which they meet to a factor of two; the time is that of
one transform here, now, measured.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from continuum.model.fourier import columns_forward, columns_inverse, padded, rows_forward, rows_inverse
from continuum.model.grid import Grid
from continuum.runs.config import RunConfig

# Peak memory of a run in bytes: the libraries, and per grid point; seen: 83 with a law (4096²), 110 with a hard wall.
_BYTES, _BYTES_PER_POINT = 2.5e8, 115
# FFT pairs of a point at a given gap, separation or pressure, and of one at a given area, its search included, without
# attraction, to a residual of 1e-6 h'rms E*; how they grow with the range r, in a0, that the paper's law of the same
# work of adhesion has: by 1 + r, and by 1 + 4 r²; and with the grid beyond 512²: as n^0.24 (docs/benchmarks.md).
_PAIRS, _PAIRS_OF_AREA = 25, 65
_GROWTH, _FLAT = 0.24, 512
# Of a point at a given area of a self-affine surface, fitted to 400 systems of inputs/sweep/ on 512² to 2048² points,
# of which all but one in twenty lie within a factor of two: 51 pairs at λ_s = 64 and h'rms = 0.1, and how they grow
# with 1/λ_s, with h', by 1 + 1.6 (r/(h' λ_s))^1.5, and with the grid.
_ROUGH, _FINENESS, _STEEPNESS, _REACH, _ROUGH_GROWTH = 51, 0.17, 0.81, (1.63, 1.5), 0.47
# Where work, range and core are given apart, fitted to 454 such systems: 4.5 times that, whatever h', and more where
# the attraction is so stiff, w/range², that single points snap; four of five lie within a factor of two.
_APART, _SNAP = 4.5, (0.245, 3)
# As far as they were seen; beyond, they are taken to stay.
_STIFFEST, _GENTLEST, _FARTHEST = 3.0, 0.03, 3.0
_BISECTIONS = 5  # solves for each halving of an interval in which jumps are bracketed: of both sides, for several jumps
_DECADES = 6.0  # of tolerance, for which these hold; pairs grow linearly with them
# An iteration takes this many times its transforms, and more on small grids, where coarser ones cost as much.
_BESIDE, _SMALL = 1.7, 0.8
_POINT_SECONDS, _START_SECONDS = 0.03, 0.1  # to measure and store a point of a small grid; to begin and end


@dataclass(frozen=True)
class Cost:
    """What a run will take, to within a factor of about two; three beside instabilities."""

    memory: int
    """Peak memory, in bytes."""
    points: int
    """Number of points of the path."""
    fft_pairs: int
    """Forward and inverse transforms of all points and searches, halved, weighted by the points of their grids."""
    size: int
    """Number of points of the grid."""

    def seconds(self, pair: float) -> float:
        """Core-seconds, where a pair of transforms of this grid takes ``pair`` (:func:`pair_seconds`)."""
        beside = _BESIDE * (1 + _SMALL * np.sqrt(_FLAT / np.sqrt(self.size)))
        # Outlines, areas and the file of a point are as dear as four iterations.
        return float((self.fft_pairs + 4 * self.points) * pair * beside + self.points * _POINT_SECONDS) + _START_SECONDS


def cost_of(config: RunConfig) -> Cost:
    """Memory and transforms of a run, from its configuration alone."""
    nx, ny = config.grid.n
    size, points = nx * ny, config.loading.points
    # Contact maps take two bits per point, fields four bytes, and a rewrite holds them twice.
    kept = points * size * 2 * (0.25 + (4 if config.output.fields else 0))
    decades = max(-float(np.log10(config.solver.tolerance)), 1.0) / _DECADES
    larger = max(1.0, np.sqrt(size) / _FLAT)
    grown, reach = larger**_GROWTH * decades, config.wall.equivalent_range
    pairs = 0.0
    for control, targets in config.loading.legs:
        area = control == "repulsive-area"
        each = _pairs_of_area(config, larger) * decades if area else _PAIRS * (1 + reach) * grown
        pairs += len(targets) * min(each, _most(config, area))
        resolution = config.loading.event_resolution
        if resolution is not None and not area and reach > 0:
            # Where the retraction begins is known when the approach has ended: its first interval is as the second.
            intervals = [abs(b - a) for a, b in pairwise(targets)]
            halvings = sum(np.log2(max(width / resolution, 2.0)) for width in [*intervals[:1], *intervals])
            pairs += _BISECTIONS * halvings * _PAIRS * (1 + reach) * grown
    return Cost(int(_BYTES + size * _BYTES_PER_POINT + kept), points, round(pairs), size)


def _pairs_of_area(config: RunConfig, larger: float) -> float:
    """Pairs of a point at a given area; ``larger`` is the size of the grid over that from which on they grow."""
    surface, wall = config.surface, config.wall
    shortest, slope = surface.shortest, surface.expected_slope
    if shortest is None or slope is None:
        return float(_PAIRS_OF_AREA * (1 + 4 * wall.equivalent_range**2) * larger**_GROWTH)
    rough = _ROUGH * (64 / shortest) ** _FINENESS * larger**_ROUGH_GROWTH
    if wall.pull is not None:
        pull = min(wall.pull, _STIFFEST)
        return float(rough * _APART * (1 + _SNAP[0] * pull ** _SNAP[1]))
    near = min(wall.equivalent_range / (slope * shortest), _FARTHEST)
    return float(rough * (max(slope, _GENTLEST) / 0.1) ** _STEEPNESS * (1 + _REACH[0] * near ** _REACH[1]))


def _most(config: RunConfig, area: bool) -> float:
    """What the limit of iterations allows a point."""
    return (config.solver.max_iterations + 3) * (20 if area else 1)


def pair_seconds(grid: Grid, most: int = 1024) -> float:
    """Time of a transform and its inverse on a grid, in s, measured here and now on one thread.

    A larger grid than ``most`` points a side is not made: its time is that of a smaller one by the n² log n of points.
    """
    n = min(max(round(np.sqrt(grid.size)), 16), most)
    small, seconds = Grid.square(n), np.inf
    field, spectrum = np.random.default_rng(1).normal(size=small.shape), padded(small.shape_q, np.complex128)
    # The arrays are there, as they are for a solver; the best of a few is that of a machine that others leave alone.
    for _ in range(5):
        began = time.process_time()
        repeats = max(1, 2**18 // small.size)
        for _ in range(repeats):
            rows_forward(field, spectrum)
            columns_forward(spectrum)
            columns_inverse(spectrum)
            rows_inverse(spectrum, field)
            field /= small.size
        seconds = min(seconds, (time.process_time() - began) / repeats)
    work = grid.size * np.log(grid.size) / (small.size * np.log(small.size))
    return float(seconds * work)
