"""What thirty systems cost that are about to snap: ``python -m docs.benchmarks.about_to_snap FILE.csv [--count N]``.

Rims are held by the grid where an attraction is strong for its range, and snap on from one row of points to the next:
there a solve stalls.  Ten thresholds at short ranges, ten paths there and back, and ten areas from rest.  Pairs of
transforms are counts, weighted by points; compiled code is loaded before the CPU time is taken.  Rows are written one
by one, and running again goes on; two files, of two versions of the solver, are compared by ``--beside OTHER.csv``.
"""

from __future__ import annotations

import argparse
import sys
import time
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, Literal, NamedTuple

import numpy as np

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.path.loading import follow, solve
from continuum.path.state import PathState, Search
from continuum.path.threshold_search import bracket_threshold
from continuum.solve.solution import Settings
from docs.benchmarks.rows import add_row, rows_of

__all__ = ["SYSTEMS", "System", "measure", "summary"]

CORE = 5.0
"""Stiffness of the core, in E*/a0."""
GAPS = (2.6, 1.1, 4)
"""A path goes through so many mean gaps between these, in h_rms, and back through as many."""


class System(NamedTuple):
    """Points a side, Hurst exponent, λ_s in a0 and seed; the shape of the attraction, its range in h_rms, and its work
    over the square of the range in a0² (half the tension of a spline that is as strong as the substrate is 0.2)."""

    kind: str
    """"threshold", of which the work is found; "back", a path by mean gaps; or "area", a repulsive area from rest."""
    n: int
    hurst: float
    lambda_s: float
    seed: int
    shape: Literal["spline", "exponential"]
    reach: float
    strength: float = 0.2
    area: float = 0.01

    def heights(self) -> Real:
        """With h'rms = 0.1; for a threshold h_rms = λ_L/512, as in the sweeps."""
        surface = c.SelfAffine(self.hurst, 0.1, self.lambda_s, self.n / 2)
        heights = surface.synthesise(Grid.square(self.n), np.random.default_rng(self.seed))
        return heights * (self.n / 2 / 512 / heights.std()) if self.kind == "threshold" else heights

    def problem(self) -> ContactProblem:
        heights = self.heights()
        reach = self.reach * float(heights.std())
        wall = c.attraction_on_core(self.shape, self.strength * reach**2, reach, CORE)
        return ContactProblem(Grid.square(self.n), wall, heights, c.HalfSpace("clamped"))


SYSTEMS = tuple(
    System(*each)
    for each in (
        ("threshold", 256, 0.2, 4, 1, "spline", 0.2), ("threshold", 256, 0.8, 4, 1, "spline", 0.12),
        ("threshold", 256, 0.2, 4, 2, "spline", 0.16), ("threshold", 256, 0.8, 4, 2, "spline", 0.16),
        ("threshold", 256, 0.5, 8, 3, "spline", 0.25), ("threshold", 256, 0.5, 4, 3, "exponential", 0.1),
        ("threshold", 256, 0.8, 4, 4, "exponential", 0.16), ("threshold", 256, 0.3, 8, 5, "exponential", 0.25),
        ("threshold", 512, 0.8, 4, 1, "spline", 0.16), ("threshold", 512, 0.3, 4, 2, "exponential", 0.16),
        ("back", 256, 0.8, 8, 1, "spline", 0.16), ("back", 256, 0.8, 16, 2, "spline", 0.16),
        ("back", 256, 0.5, 4, 3, "spline", 0.3), ("back", 256, 0.3, 8, 4, "spline", 0.3),
        ("back", 256, 0.8, 8, 5, "spline", 0.6, 0.4), ("back", 256, 0.8, 4, 6, "exponential", 0.16),
        ("back", 256, 0.5, 8, 7, "exponential", 0.3, 0.4), ("back", 256, 0.3, 16, 8, "exponential", 0.6, 0.4),
        ("back", 512, 0.8, 8, 1, "spline", 0.3), ("back", 512, 0.5, 16, 2, "exponential", 0.3),
        ("area", 256, 0.8, 8, 1, "spline", 0.16), ("area", 256, 0.8, 8, 2, "spline", 0.16),
        ("area", 256, 0.5, 4, 3, "spline", 0.1, 0.4, 0.05), ("area", 512, 0.8, 8, 1, "spline", 0.16),
        ("area", 512, 0.5, 4, 1, "spline", 0.3, 0.4), ("area", 512, 0.3, 8, 2, "spline", 0.16, 0.2, 0.003),
        ("area", 512, 0.8, 16, 3, "spline", 0.1, 0.3, 0.05), ("area", 512, 0.5, 4, 4, "exponential", 0.16),
        ("area", 512, 0.8, 8, 5, "exponential", 0.1, 0.4, 0.03), ("area", 1024, 0.8, 8, 1, "spline", 0.16),
    )
)  # fmt: skip


def _states(system: System, problem: ContactProblem) -> tuple[ContactProblem, list[PathState]]:
    """All that is asked of a system."""
    settings, search = Settings(1e-5 * problem.moments.rms_slope), Search(0.05, 0.02)
    if system.kind == "area":
        return problem, [solve(problem, "repulsive-area", system.area, settings, search=search)]
    if system.kind == "threshold":
        wall = partial(
            c.attraction_on_core, system.shape, effective_range=problem.wall.effective_range, core_stiffness=CORE
        )
        there, state = bracket_threshold(problem, wall, system.area, settings, search, 0.02)
        return there, [state]
    gaps = float(problem.heights.std()) * np.linspace(*GAPS)
    return problem, list(follow(problem, "mean-gap", [*gaps, *gaps[-2::-1]], settings))


def measure(system: System) -> dict[str, Any]:
    """Pairs and CPU seconds, with what the states are: the last one's area, the least load, the work of adhesion."""

    began = time.process_time()
    problem, states = _states(system, system.problem())
    seconds = time.process_time() - began
    statuses = sorted({state.status.name for state in states})
    return {
        **system._asdict(), "status": " ".join(statuses), "solves": sum(1 + state.search_solves for state in states),
        "pairs": sum(state.search_pairs + state.solution.fft_pairs for state in states),
        "cpu": seconds, "work": problem.wall.work_of_adhesion,
        "most_area": max(state.area_rep for state in states), "last_area": states[-1].area_rep,
        "least_load": min(state.load for state in states), "mean_load": float(np.mean([one.load for one in states])),
        "mean_area": float(np.mean([state.area_rep for state in states])),
    }  # fmt: skip


def summary(one: list[dict[str, str]], other: list[dict[str, str]]) -> str:
    """Pairs and CPU time of the second file over those of the first, of the systems in both, and how states differ."""
    of = [{tuple(row[key] for key in System._fields): row for row in rows} for rows in (one, other)]
    lines, both = [], [(row, of[1][system]) for system, row in of[0].items() if system in of[1]]
    for kind in ("threshold", "back", "area", "all"):
        part = [pair for pair in both if kind in (pair[0]["kind"], "all")]
        for key in ("pairs", "cpu") if part else ():
            ratios = sorted(float(b[key]) / float(a[key]) for a, b in part)
            whole = sum(float(b[key]) for _, b in part) / sum(float(a[key]) for a, _ in part)
            lines.append(
                f"{kind}, {len(part)} systems, {key}: {whole:.2f} times in all, {median(ratios):.2f} in the median "
                f"({ratios[0]:.2f} to {ratios[-1]:.2f})"
            )
    for a, b in both:
        apart = {
            key: f"{float(b[key]) / float(a[key]) - 1:.1e}"
            for key in ("work", "mean_area", "mean_load", "least_load")
            if abs(float(b[key]) - float(a[key])) > 1e-3 * abs(float(a[key]))
        }
        if apart or a["status"] != b["status"]:
            lines.append(f"{a['kind']}, {a['n']}², seed {a['seed']}: {a['status']}, {b['status']}; {apart}")
    return "\n".join(lines)


def main() -> None:
    """Measure what is missing in a file, or compare two of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--count", type=int, default=len(SYSTEMS))
    parser.add_argument("--beside", type=Path)
    given = parser.parse_args()
    missing = SYSTEMS[len(rows_of(given.file)) : given.count] if given.beside is None else ()
    for system in (SYSTEMS[0], SYSTEMS[5]) if missing else ():  # compile and load both laws
        measure(system._replace(kind="area", lambda_s=16))
    for system in missing:
        row = {key: f"{value:.6g}" if isinstance(value, float) else value for key, value in measure(system).items()}
        add_row(given.file, row)
    if given.beside is not None:
        sys.stdout.write(summary(rows_of(given.beside), rows_of(given.file)) + "\n")


if __name__ == "__main__":
    main()
