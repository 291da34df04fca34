"""What a search for an area costs beside a jump: ``python -m docs.benchmarks.jumps FILE.csv [--only 0 3 7]``.

Thirty systems on 512² whose area jumps over 1 or 3 % on the way from rest.  Counted are FFT pairs, weighted by points,
in all and in parts: by the side of the area on which a trial ends, and its grid.  Rows are written one by one, and
running again goes on; ``--beside OTHER.csv`` compares two files.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

import continuum as c
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.path import area as searches
from continuum.path.loading import solve
from continuum.path.state import PathState, Search
from continuum.solve.solution import Settings
from docs.benchmarks.rows import add_row, rows_of

__all__ = ["SYSTEMS", "System", "measure", "summary"]

N, SLOPE, TOLERANCE, RESOLUTION = 512, 0.1, 1e-6, 0.02
"""Points a side, h'rms, tolerance over it in E*, and width of the bracket in a0."""


class System(NamedTuple):
    hurst: float
    lambda_s: float
    seed: int
    adhesion_length: float
    area: float


SYSTEMS = tuple(
    System(*each)
    for each in (
        (0.3, 8, 1, 0.05, 0.01), (0.3, 32, 1, 0.05, 0.01), (0.5, 8, 1, 0.05, 0.01), (0.5, 16, 1, 0.05, 0.03),
        (0.5, 16, 1, 0.02, 0.01), (0.5, 32, 1, 0.05, 0.01), (0.8, 8, 1, 0.05, 0.03), (0.3, 8, 2, 0.05, 0.01),
        (0.3, 8, 2, 0.05, 0.03), (0.3, 16, 2, 0.05, 0.01), (0.3, 16, 2, 0.05, 0.03), (0.5, 8, 2, 0.05, 0.03),
        (0.3, 8, 3, 0.05, 0.01), (0.3, 8, 3, 0.02, 0.01), (0.3, 16, 3, 0.05, 0.01), (0.3, 32, 3, 0.05, 0.03),
        (0.5, 8, 3, 0.05, 0.01), (0.5, 8, 3, 0.02, 0.01), (0.5, 16, 3, 0.05, 0.01), (0.5, 16, 3, 0.05, 0.03),
        (0.8, 8, 3, 0.05, 0.01), (0.8, 8, 3, 0.05, 0.03), (0.8, 16, 3, 0.05, 0.01), (0.3, 8, 4, 0.05, 0.01),
        (0.3, 8, 4, 0.02, 0.01), (0.3, 16, 4, 0.05, 0.01), (0.3, 16, 4, 0.05, 0.03), (0.3, 32, 4, 0.05, 0.03),
        (0.5, 8, 4, 0.05, 0.01), (0.8, 8, 4, 0.02, 0.01),
    )
)  # fmt: skip


def problem_of(system: System) -> ContactProblem:
    surface = c.SelfAffine(system.hurst, SLOPE, system.lambda_s, N / 2)
    heights = surface.synthesise(Grid.square(N), np.random.default_rng(system.seed))
    wall = c.LennardJonesSpline(adhesion_length=system.adhesion_length)
    return ContactProblem(Grid.square(N), wall, heights, c.HalfSpace("clamped"))


def measure(system: System) -> dict[str, Any]:
    """Search, and count what each trial takes."""
    spent: dict[str, list[float]] = defaultdict(list)
    find = searches._AreaSearch._trial

    def trial(seek: searches._AreaSearch, *given: Any, **named: Any) -> PathState:
        state = find(seek, *given, **named)
        n = seek.problem.grid.shape[0]
        side = "short" if seek.short(state.area_rep) else "past"
        spent[f"{n} {side}"].append(state.solution.fft_pairs * (n / N) ** 2)
        return state

    with mock.patch.object(searches._AreaSearch, "_trial", trial):
        found = solve(problem_of(system), "repulsive-area", system.area, Settings(TOLERANCE * SLOPE),
                      search=Search(area_resolution=RESOLUTION))  # fmt: skip
    other = found.beyond
    return {
        "n": N, **system._asdict(), "status": (found.outcome or found.status).name, "solves": found.search_solves + 1,
        "pairs": round(found.search_pairs + found.solution.fft_pairs, 1), "last": round(found.solution.fft_pairs, 1),
        "mean_gap": found.mean_gap, "area_rep": found.area_rep, "load": found.load,
        "gap_beyond": other and other.mean_gap, "area_beyond": other and other.area_rep,
        "load_beyond": other and other.load,
        "parts": "; ".join(f"{name} {len(each)}: {sum(each):.0f}" for name, each in sorted(spent.items())),
    }  # fmt: skip


def _key(row: dict[str, Any]) -> System:
    return System(*(float(row[name]) for name in System._fields))


def summary(one: list[dict[str, str]], other: list[dict[str, str]]) -> str:
    """Pairs of the second file over those of the first, of the systems in both, and how the brackets differ."""
    of = {_key(row): row for row in one}
    both = [(of[_key(row)], row) for row in other if _key(row) in of]
    ratios = sorted(float(b["pairs"]) / float(a["pairs"]) for a, b in both)
    pairs = [median(float(pair[i]["pairs"]) for pair in both) for i in (0, 1)]
    lines = [
        f"{len(both)} systems: pairs {pairs[0]:.0f} and {pairs[1]:.0f} in the median; ratio {median(ratios):.2f} "
        f"({ratios[0]:.2f} to {ratios[-1]:.2f}); {sum(each <= 0.5 for each in ratios)} at most half"
    ]
    for a, b in both:
        said = [f"{row['status']} {row['mean_gap'][:8]} {row['gap_beyond'][:8]}" for row in (a, b)]
        # The ends of two brackets: of one jump if they overlap.
        ends = [[float(row[key] or "nan") for key in ("gap_beyond", "mean_gap")] for row in (a, b)]
        apart = max(ends[0][0], ends[1][0]) - min(ends[0][1], ends[1][1])
        if a["status"] != b["status"] or not apart <= 0:
            lines.append(f"{tuple(_key(b))}: {said[0]}; {said[1]}: apart {apart:.4f}")
    return "\n".join(lines)


def main() -> None:
    """Measure what is missing in a file, or compare two of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--only", type=int, nargs="*", default=range(len(SYSTEMS)))
    parser.add_argument("--beside", type=Path)
    given = parser.parse_args()
    known = {_key(row) for row in rows_of(given.file)}
    for system in [SYSTEMS[i] for i in given.only if SYSTEMS[i] not in known] if given.beside is None else ():
        add_row(given.file, measure(system))
    if given.beside is not None:
        sys.stdout.write(summary(rows_of(given.beside), rows_of(given.file)) + "\n")


if __name__ == "__main__":
    main()
