"""What tiles near the wall save: ``python -m docs.benchmarks.tiles FILE.csv``.

Each state is solved from rest, or from a neighbour on a path, with tiles and on the whole grid, in turn; the CPU time
is the least of the turns.  A file that has rows already is gone on with, and its summary printed.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import continuum as c
from continuum.model.problem import ContactProblem
from continuum.path.loading import solve
from continuum.path.state import Control, PathState, Search
from continuum.solve.compiled import tiles
from continuum.solve.solution import Settings
from docs.benchmarks.cases import TOLERANCE, rough
from docs.benchmarks.rows import add_row, rows_of

TURNS = {1024: 3, 2048: 2}
STEP = 0.05
"""Step in mean gap, or in the logarithm of the pressure, from which a state of a path comes, in h_rms."""


class State(NamedTuple):
    """Points a side, λ_s in a0, the wall, repulsive area, and from where."""

    n: int
    lambda_s: float
    wall: str
    """"hard"; "law" of the paper at l_a in a0; or "core", 5 E*/a0 stiff under an exponential attraction."""
    adhesion_length: float = 0.0
    area: float = 0.01
    start: str = "rest"

    def problem(self) -> ContactProblem:
        surface = rough(self.n, 1, self.adhesion_length, self.lambda_s)
        if self.wall == "law":
            return surface.problem()
        if self.wall == "hard":
            return surface.problem(c.HardWall())
        return surface.problem(c.attraction_on_core("exponential", self.adhesion_length, 0.8, 5.0))


STATES = tuple(
    State(*each)
    for each in (
        (1024, 8, "hard"), (1024, 8, "law", 0.005), (2048, 8, "hard"), (2048, 8, "law", 0.005), (2048, 32, "hard"),
        (2048, 32, "law", 0.005), (1024, 32, "law", 0.05), (1024, 32, "law", 0.0005, 0.003),
        (1024, 16, "core", 0.0004), (2048, 16, "core", 0.0004), (1024, 32, "law", 0.005, 0.01, "path"),
        (1024, 16, "hard", 0.0, 0.05, "path"),
    )
)  # fmt: skip


def measure(state: State) -> dict[str, Any]:
    """CPU seconds and pairs with tiles and without, and how many points in contact differ."""
    problem, smallest = state.problem(), tiles.SMALLEST
    settings = Settings(TOLERANCE)
    near = solve(problem, "repulsive-area", state.area, settings, search=Search(0.1, 0.02))
    control: Control = "mean-pressure" if state.wall == "hard" else "mean-gap"
    at = near.load if state.wall == "hard" else near.mean_gap
    rms = float(problem.heights.std())
    before = at * (1 - STEP) if state.wall == "hard" else at + STEP * rms
    start = solve(problem, control, before, settings).gap if state.start == "path" else None
    took: dict[bool, list[float]] = {True: [], False: []}
    found: dict[bool, PathState] = {}
    try:
        for turn in range(2 * TURNS[state.n] + 2):  # the first two compile and fill caches
            tiled = turn % 2 == 0
            tiles.SMALLEST = smallest if tiled else 1 << 30
            began = time.process_time()
            found[tiled] = solve(problem, control, at, settings, start=start)
            took[tiled].append(time.process_time() - began)
    finally:
        tiles.SMALLEST = smallest
    touching = [problem.wall.touches(one.gap) for one in found.values()]
    seconds = [min(took[tiled][1:]) for tiled in (True, False)]
    return {
        **state._asdict(), "found": found[True].area_rep, "cpu": seconds[0], "cpu_without": seconds[1],
        "slower": seconds[1] / seconds[0], "pairs": found[True].solution.fft_pairs,
        "pairs_without": found[False].solution.fft_pairs,
        "status": f"{found[True].status.name} {found[False].status.name}",
        "points_different": int(np.count_nonzero(touching[0] != touching[1])),
    }  # fmt: skip


def main(file: Path) -> None:
    for state in STATES[len(rows_of(file)) :]:
        add_row(file, {key: f"{v:.4g}" if isinstance(v, float) else str(v) for key, v in measure(state).items()})
    rows = rows_of(file)
    slower = [float(row["slower"]) for row in rows]
    sys.stdout.write(f"without tiles {min(slower):.2f} to {max(slower):.2f} times the CPU time, {len(rows)} states\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
