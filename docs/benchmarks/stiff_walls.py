"""What the contact's own step saves, on forty-two states: ``python -m docs.benchmarks.stiff_walls FILE SEED``.

Each state is solved with the step and without it, in turn and three times; pairs of transforms are counts, and the CPU
time is the least.  A file that has rows already is gone on with.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np

import continuum as c
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import Substrate
from continuum.model.walls import Wall
from continuum.path.loading import solve
from continuum.path.state import PathState, Search
from continuum.solve import contact
from continuum.solve.solution import Settings
from docs.benchmarks.rows import add_row, rows_of

__all__ = ["STATES", "State", "measure", "summary"]

TOLERANCE = 1e-5
"""Of the residual, in units of h'rms E*: that of the sweeps."""
STEP = 0.1
"""Step in mean gap from which a state of a path comes, in h_rms."""
TURNS = 3
SUBSTRATES: dict[str, Substrate] = {
    "half-space": c.HalfSpace("clamped"),
    "layer": c.Layer(48.0, 0.3, "clamped"),
    "crystal": c.CubicLayer(np.inf, (1.2, 0.6, 0.5), "clamped"),
}


class State(NamedTuple):
    """One state: points a side, Hurst exponent, λ_s in a0; wall; repulsive area; substrate, and from where."""

    n: int
    hurst: float
    lambda_s: float
    law: str
    """"paper", "9-3", or the shape of an attraction on a core."""
    adhesion_length: float
    reach: float
    """Effective range of that attraction, in a0."""
    core: float
    """Stiffness of its core, in E*/a0."""
    area: float
    substrate: str = "half-space"
    start: str = "rest"
    seed: int = 1

    @property
    def stiff(self) -> bool:
        """Whether the step is made for it: a core that is stiffer than any wave, and little contact."""
        return self.core >= 5 and self.area < 0.1

    def wall(self) -> Wall:
        if self.law == "paper":
            return c.LennardJonesSpline(adhesion_length=self.adhesion_length)
        if self.law == "9-3":
            return c.InversePowers((9, 3), adhesion_length=self.adhesion_length)
        shape: Any = "spline" if self.law == "tabulated" else self.law
        smooth = c.attraction_on_core(shape, self.adhesion_length, self.reach, self.core)
        if self.law != "tabulated":
            return smooth
        gap = np.concatenate([np.linspace(-0.4, 0.0, 81), np.geomspace(1e-3, 2 * self.reach, 120)])
        return c.TabulatedWall(gap, smooth.evaluate(gap).traction)

    def problem(self) -> ContactProblem:
        """With the rms height of the sweeps, an eighth of a0, where the attraction is weak; else h'rms = 0.1."""
        grid, surface = Grid.square(self.n), c.SelfAffine(self.hurst, 0.1, self.lambda_s, self.n / 2)
        heights = surface.synthesise(grid, np.random.default_rng(self.seed))
        if self.core >= 5 and self.adhesion_length < 0.002:
            heights *= 0.125 / heights.std()
        return ContactProblem(grid, self.wall(), heights, SUBSTRATES[self.substrate])


STATES = tuple(
    State(*each)
    for each in (
        # What the sweeps press: little contact on a core of 5.
        (512, 0.3, 4, "spline", 0.0004, 0.25, 5, 0.01), (512, 0.3, 8, "spline", 0.0004, 0.25, 5, 0.01),
        (512, 0.3, 16, "spline", 0.0004, 0.8, 5, 0.01), (512, 0.5, 8, "spline", 0.0008, 0.8, 5, 0.003),
        (512, 0.6, 16, "spline", 0.0004, 0.25, 5, 0.03), (512, 0.8, 8, "spline", 0.0004, 0.25, 5, 0.01),
        (512, 0.8, 32, "spline", 0.002, 0.25, 5, 0.05), (512, 0.8, 16, "spline", 0.0016, 0.5, 5, 0.08),
        (512, 0.3, 8, "exponential", 0.0004, 0.25, 5, 0.01), (512, 0.3, 16, "exponential", 0.0008, 0.25, 5, 0.03),
        (512, 0.5, 4, "exponential", 0.0004, 0.8, 5, 0.01), (512, 0.6, 16, "exponential", 0.0004, 0.8, 5, 0.01),
        (512, 0.8, 4, "exponential", 0.0008, 0.25, 5, 0.01), (512, 0.8, 8, "exponential", 0.0008, 0.8, 5, 0.003),
        (512, 0.8, 16, "exponential", 0.002, 0.8, 5, 0.05), (512, 0.8, 32, "exponential", 0.0005, 0.25, 5, 0.01),
        (512, 0.5, 8, "exponential", 0.0004, 0.8, 20, 0.01), (512, 0.8, 16, "spline", 0.0008, 0.25, 20, 0.01),
        (512, 0.3, 8, "spline", 0.0004, 0.25, 20, 0.03), (512, 0.8, 16, "tabulated", 0.0008, 0.5, 5, 0.01),
        (512, 0.5, 8, "tabulated", 0.0004, 0.25, 5, 0.03),
        (512, 0.6, 8, "exponential", 0.0004, 0.8, 5, 0.01, "layer"),
        (512, 0.6, 8, "spline", 0.0004, 0.25, 5, 0.02, "crystal"),
        (512, 0.6, 8, "exponential", 0.0004, 0.8, 5, 0.01, "half-space", "path"),
        (512, 0.8, 16, "spline", 0.0008, 0.25, 5, 0.03, "half-space", "path"),
        (1024, 0.3, 8, "exponential", 0.0004, 0.8, 5, 0.01), (1024, 0.8, 16, "exponential", 0.0008, 0.25, 5, 0.01),
        (1024, 0.6, 16, "spline", 0.0004, 0.25, 5, 0.03), (1024, 0.5, 32, "exponential", 0.0008, 0.8, 5, 0.05),
        (2048, 0.6, 16, "exponential", 0.0004, 0.8, 5, 0.01),
        # Where it should cost nothing: soft walls, much contact, walls that pull the surface in.
        (512, 0.8, 16, "paper", 0.0005, 0, 0.5, 0.01), (512, 0.8, 32, "paper", 0.005, 0, 0.5, 0.05),
        (512, 0.8, 8, "paper", 0.05, 0, 0.5, 0.03), (1024, 0.8, 32, "paper", 0.005, 0, 0.5, 0.01),
        (512, 0.8, 16, "exponential", 0.005, 0.5, 1, 0.01), (512, 0.5, 8, "spline", 0.005, 0.25, 1, 0.1),
        (512, 0.8, 16, "9-3", 0.005, 0, 0.5, 0.01), (512, 0.5, 8, "9-3", 0.0005, 0, 0.5, 0.1),
        (512, 0.5, 8, "exponential", 0.005, 0.5, 5, 0.1), (512, 0.8, 8, "spline", 0.005, 0.25, 5, 0.3),
        (512, 0.8, 16, "exponential", 0.0008, 0.8, 5, 0.5), (512, 0.8, 16, "spline", 0.02, 0.4, 5, 0.03),
    )
)  # fmt: skip


def _solves(state: State) -> Iterator[tuple[bool, PathState, float]]:
    """The state with and without the step, in turn: which, what was found, CPU seconds."""
    problem = state.problem()
    stiffest, settings = contact.STIFFEST, Settings(TOLERANCE * problem.moments.rms_slope)
    try:
        contact.STIFFEST = np.inf
        search = Search(area_tolerance=0.1, area_resolution=0.02)
        gap = solve(problem, "repulsive-area", state.area, settings, search=search).mean_gap
        before = gap + STEP * float(problem.heights.std())
        start = solve(problem, "mean-gap", before, settings).gap if state.start == "path" else None
        for turn in range(2 * TURNS + 2):  # the first two compile and fill caches
            contact.STIFFEST = stiffest if turn % 2 else np.inf
            began = time.process_time()
            found = solve(problem, "mean-gap", gap, settings, start=start)
            seconds = time.process_time() - began
            if turn > 1:
                yield bool(turn % 2), found, seconds
    finally:
        contact.STIFFEST = stiffest


def measure(state: State) -> dict[str, Any]:
    """Pairs, outer iterations and least CPU seconds with and without the step, and how the two states differ."""
    wall, turns = state.wall(), list(_solves(state))
    (_, one, _), (_, other, _) = turns[0], turns[1]
    loads = [each.load for each in (one, other)]
    seconds = [min(t for own, _, t in turns if own is which) for which in (False, True)]
    pairs = [each.solution.fft_pairs for each in (one, other)]
    return {
        **state._asdict(), "stiff": int(state.stiff), "found": float((one.gap < wall.zero_gap).mean()),
        "status": f"{one.status.name} {other.status.name}",
        "pairs_without": pairs[0], "pairs": pairs[1], "fewer": pairs[0] / pairs[1],
        "iterations_without": one.solution.iterations, "iterations": other.solution.iterations,
        "cpu_without": seconds[0], "cpu": seconds[1], "faster": seconds[0] / seconds[1],
        "points_different": int(((one.gap < wall.zero_gap) != (other.gap < wall.zero_gap)).sum()),
        "gap_different": float(np.abs(one.gap - other.gap).max()),
        "load_different": abs(loads[1] - loads[0]) / abs(loads[0]),
    }  # fmt: skip


def summary(rows: list[dict[str, Any]]) -> str:
    """Medians and extremes of the ratios, on stiff walls with little contact and on all others."""
    lines = []
    for name, of in (("stiff walls below 10 %", 1), ("all others", 0)):
        for key in ("fewer", "faster"):
            ratios = sorted(float(row[key]) for row in rows if int(row["stiff"]) == of)
            if ratios:
                lines.append(
                    f"{name}, {key}: {median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f}), {len(ratios)} states"
                )
    return "\n".join(lines)


def main(file: Path, seed: int = 1) -> None:
    for state in STATES[len(rows_of(file)) :]:
        row = measure(state._replace(seed=seed))
        add_row(file, {key: f"{value:.5g}" if isinstance(value, float) else str(value) for key, value in row.items()})
    sys.stdout.write(summary(rows_of(file)) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(int, sys.argv[2:]))
