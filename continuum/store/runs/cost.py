"""Estimate the cost of a run from its input: memory, FFT pairs, and core-seconds on this machine.

The counts of transforms in ``cost.toml`` were fitted to the runs of ``inputs/``, within a factor of two but for the
line and the layered substrate of ``inputs/smoke``, which take 5.7 and 3.4 times as many, and the sweep of 256² points
in ``bandwidth-256.toml``, which takes 0.4 times as many; the time of a transform is measured on this machine.
"""

import time
import tomllib
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise

import numpy as np

from continuum.model.fourier import columns_forward, columns_inverse, padded, rows_forward, rows_inverse
from continuum.model.grid import Grid
from continuum.store.runs.config import RunConfig

_SEEN = tomllib.loads(resources.files("continuum.store.runs").joinpath("cost.toml").read_text(encoding="utf-8"))
_MEMORY, _PAIRS, _ROUGH, _APART, _TIME = (
    _SEEN[name] for name in ("memory", "pairs", "self_affine", "attraction_on_core", "time")
)


@dataclass(frozen=True)
class Cost:
    """Cost of a run, within a factor of about two, or three near instabilities, of a surface on one material."""

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
        beside = _TIME["beside"] * (1 + _TIME["small"] * np.sqrt(_PAIRS["flat"] / np.sqrt(self.size)))
        iterations = (self.fft_pairs + _TIME["iterations"] * self.points) * pair * beside
        return float(iterations + self.points * _TIME["point"] + _TIME["start"])


def cost_of(config: RunConfig) -> Cost:
    """Memory and transforms of a run, from its configuration alone."""
    nx, ny = config.grid.n
    size, points = nx * ny, config.loading.points
    # Contact maps take two bits per point, fields four bytes, and both are held twice during a rewrite.
    kept = points * size * 2 * (0.25 + (4 if config.output.fields else 0))
    decades = max(-float(np.log10(config.solver.tolerance)), 1.0) / _PAIRS["decades"]
    larger = max(1.0, np.sqrt(size) / _PAIRS["flat"])
    reach = config.wall.equivalent_range
    point = _PAIRS["point"] * (1 + reach) * larger ** _PAIRS["growth"] * decades
    pairs = 0.0
    for control, targets in config.loading.legs:
        area = control == "repulsive-area"
        each = _pairs_of_area(config, larger) * decades if area else point
        if config.loading.threshold is not None:
            each *= _PAIRS["threshold"]
        allowed = (config.solver.max_iterations + 3) * (20 if area else 1)
        pairs += len(targets) * min(each, allowed)
        resolution = config.loading.event_resolution
        if resolution is not None and not area and reach > 0:
            # The start of the retraction is not known yet: its first interval is taken as the second.
            intervals = [abs(b - a) for a, b in pairwise(targets)]
            halvings = sum(np.log2(max(width / resolution, 2.0)) for width in [*intervals[:1], *intervals])
            pairs += _PAIRS["bisection"] * halvings * point
    beside, longer = (1, 1.0) if config.substrate.repeats else (4, _PAIRS["non_periodic"])
    memory = _MEMORY["libraries"] + beside * size * _MEMORY["law" if config.wall.has_law else "hard"] + kept
    return Cost(int(memory), points, round(longer * pairs), size)


def _pairs_of_area(config: RunConfig, larger: float) -> float:
    """Pairs of a point at a given area; ``larger`` is the size of the grid over that above which they grow."""
    wall, shortest, slope = config.wall, config.shortest, config.expected_slope
    if shortest is None or slope is None:
        reach = 1 + _PAIRS["area_range"] * wall.equivalent_range**2
        return float(_PAIRS["area"] * reach * larger ** _PAIRS["growth"])
    fitted = _ROUGH if wall.pull is None else _APART
    rough = fitted["pairs"] * (64 / shortest) ** fitted["fineness"] * larger ** fitted["growth"]
    if wall.pull is not None:
        pull = min(wall.pull, _APART["stiffest"])
        return float(rough * (1 + _APART["snap"] * pull ** _APART["snap_exponent"]))
    near = min(wall.equivalent_range / (slope * shortest), _ROUGH["farthest"])
    steep = (max(slope, _ROUGH["gentlest"]) / 0.1) ** _ROUGH["steepness"]
    return float(rough * steep * (1 + _ROUGH["range"] * near ** _ROUGH["range_exponent"]))


def pair_seconds(grid: Grid) -> float:
    """Time of a transform and its inverse on a grid, in s, measured on one thread of this machine.

    For a grid of more than 1024 points along a side the time is extrapolated from a smaller one, as n² log n.
    """
    n = min(max(round(np.sqrt(grid.size)), 16), 1024)
    small, seconds = Grid.square(n), np.inf
    field, spectrum = np.random.default_rng(1).normal(size=small.shape), padded(small.shape_q, np.complex128)
    # Arrays are allocated before, as in a solver; the best of a few times is that of an idle machine.
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
