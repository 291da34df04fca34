"""Rough contacts at given repulsive areas, measured: what the studies of geometry share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from continuum.geometry import REPULSIVE, contact_map, measure
from continuum.greens import HalfSpace
from continuum.grid import Grid, Real
from continuum.kappa import Measurement, characterise
from continuum.loading import State, solve, traction
from continuum.minimise import Settings
from continuum.outline import Mask
from continuum.problem import ContactProblem
from continuum.surface import Moments, SelfAffine, moments
from continuum.theory import contact_diameter
from continuum.wall import HardWall, LennardJonesSpline, Wall


@dataclass(frozen=True)
class Rough:
    """One realisation of a surface under one wall; a range below zero means a hard wall."""

    n: int
    lambda_s: float
    adhesion_length: float = 0.0
    hurst: float = 0.8
    slope: float = 0.1
    seed: int = 1
    hard: bool = False
    lambda_L: float | None = None

    @property
    def wall(self) -> Wall:
        return HardWall() if self.hard else LennardJonesSpline.from_adhesion_length(self.adhesion_length)


@dataclass(frozen=True, eq=False)
class RoughContact:
    """A contact of such a surface."""

    rough: Rough
    grid: Grid
    moments: Moments
    gap: Real
    repulsive: Mask
    numbers: Measurement

    @property
    def expected_diameter(self) -> float:
        return contact_diameter(self.moments.rms_slope, self.moments.rms_curvature)


def contacts(rough: Rough, areas: Sequence[float], within: float = 0.05) -> Iterator[RoughContact]:
    """Contacts of one surface at given repulsive areas, increasing, on approach: the first mean gap that reaches it.

    Each starts from the one before, at a mean gap found by secants on the logarithm of the area; a relative error of
    ``within`` is left.  Where the contact jumps over an area, the state after the jump is taken.
    """
    grid = Grid.square(rough.n)
    spectrum = SelfAffine(rough.hurst, rough.slope, rough.lambda_s, rough.lambda_L or rough.n / 2)
    heights = spectrum.synthesise(grid, np.random.default_rng(rough.seed))
    m, wall = moments(grid, heights), rough.wall
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    settings = Settings(1e-6 * m.rms_slope)

    def area(state: State) -> float:
        return float(np.count_nonzero(wall.touches(state.gap)) / grid.size)

    state, mean_gap = None, wall.zero_gap + 3.0 * m.rms_height
    for target in areas:
        high, low = None, None  # mean gaps with too little and with too much contact
        for _ in range(25):
            start = None if state is None or rough.hard else state.gap + (mean_gap - state.target)
            if start is not None and start.min() <= wall.core:
                start = None
            state = solve(problem, "mean-gap", mean_gap, settings, start)
            state.solution.require()
            found = max(area(state), 0.1 / grid.size)
            if abs(found / target - 1) <= within:
                break
            if found < target:
                high = (mean_gap, found)
            else:
                low = (mean_gap, found)
            if high and low:
                if high[0] - low[0] < 1e-4 * m.rms_height:
                    break
                share = np.log(target / high[1]) / np.log(low[1] / high[1])
                mean_gap = high[0] + float(np.clip(share, 0.1, 0.9)) * (low[0] - high[0])
            else:
                # Persson: area ~ exp(-gap/u0) with u0 about 0.4 h_rms.
                mean_gap += 0.4 * m.rms_height * float(np.clip(np.log(found / target), -1.0, 1.0))
        assert state is not None
        repulsive = contact_map(wall, state.gap) == REPULSIVE
        loads = measure(grid, wall, state.gap, traction(wall, state.solution))
        yield RoughContact(rough, grid, m, state.gap, repulsive, characterise(grid, loads, repulsive, m.rms_slope))
