"""What a search for an area costs on random systems: ``python -m docs.benchmarks.random_searches FILE.csv``.

The systems are drawn by their number from sizes, surfaces, walls and areas as users mix them, not from those on which
the searches were tuned.  Counted are FFT pairs, weighted by grid points: of the whole search, of its last solve, and of
a solve from rest at the mean gap that was found.  Rows are written one by one, and running again goes on.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, NonPeriodicHalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.path.equilibrium import equilibrium
from continuum.path.loading import solve
from continuum.path.state import PathState, height, nearness
from continuum.solve.solution import Settings
from docs.benchmarks.rows import add_row, rows_of

SHAPES = ((128, 128), (128, 128), (192, 192), (256, 256), (256, 256), (128, 256), (251, 251), (1, 4096))
OPEN = 1 / 6
"""Part of the contacts where nothing is repeated: of the square ones."""
AREAS = (0.003, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99)
COUNT = 60
HARD = ((128, 4.0), (128, 16.0), (256, 4.0), (256, 16.0), (512, 4.0), (512, 16.0))
"""Points a side and λ_s of hard walls, whose numbers follow: 99 % of the area, H = 0.8, h'rms = 0.1."""


DEARER = 1.1
"""Pairs of a search over those of before, beyond which a system is named."""


def system(number: int) -> tuple[dict[str, Any], ContactProblem]:
    """The system of a number: what it is, in words, and the contact."""
    rng = np.random.default_rng([61, number])
    if number >= COUNT:
        n, shortest = HARD[number - COUNT]
        said = {
            "number": number, "points": f"{n}x{n}", "H": 0.8, "lambda_s": shortest, "slope": 0.1, "wall": "hard",
            "work": 0.0, "area": 0.99, "open": 0,
        }  # fmt: skip
        heights = SelfAffine(0.8, 0.1, shortest, n / 2).synthesise(Grid.square(n), rng)
        return said, ContactProblem(Grid.square(n), HardWall(), heights, HalfSpace("clamped"))
    rows, columns = shape = SHAPES[rng.integers(len(SHAPES))]
    hurst, shortest = float(rng.choice([0.3, 0.5, 0.8])), float(rng.choice([2, 4, 8, 16]))
    slope, longest = float(rng.choice([0.03, 0.1, 0.3])), max(shape) / 2
    work = float(np.exp(rng.uniform(*np.log([0.0005, 0.1]))))
    walls: dict[str, Wall] = {
        "hard": HardWall(),
        "repulsive": LennardJonesSpline(0.0),
        "spline": LennardJonesSpline(adhesion_length=work),
        "9-3": InversePowers((9, 3), adhesion_length=work),
        "exponential": Exponential(work, 0.3, 5.0),
    }
    name = str(rng.choice(["hard", "repulsive", "spline", "spline", "spline", "9-3", "exponential"]))
    area = float(rng.choice(AREAS))
    grid = Grid(shape, (float(rows), float(columns)))
    heights = SelfAffine(hurst, slope, shortest, longest).synthesise(grid, rng)
    wall = walls[name]
    said = {
        "number": number, "points": "x".join(map(str, shape)), "H": hurst, "lambda_s": shortest, "slope": slope,
        "wall": name, "work": wall.work_of_adhesion, "area": area,
    }  # fmt: skip
    apart = rng.random() < OPEN and rows == columns < 200
    said["open"] = int(apart)
    return said, ContactProblem(grid, wall, heights, NonPeriodicHalfSpace() if apart else HalfSpace("clamped"))


def pairs_of(state: PathState) -> float:
    """FFT pairs of a search, with its last solve."""
    return state.search_pairs + state.solution.fft_pairs


def search(number: int) -> dict[str, Any]:
    """Find the area from rest, then solve at its mean gap from rest."""
    said, problem = system(number)
    settings = Settings(1e-6 * said["slope"])
    began = time.process_time()
    found = solve(problem, "repulsive-area", said["area"], settings)
    seconds = time.process_time() - began
    near = nearness(problem)
    at = height(problem, found)
    rest = equilibrium(problem, near, at, settings).solution.fft_pairs if at > problem.wall.bound else np.nan
    beyond = found.beyond
    return said | {
        "status": found.status.name, "pairs": round(pairs_of(found), 2), "last": round(found.solution.fft_pairs, 2),
        "rest": round(rest, 2), "solves": found.search_solves + 1, "area_rep": found.area_rep, "load": found.load,
        "load_rep": found.load_rep, "mean_gap": found.mean_gap,
        "area_beyond": "" if beyond is None else beyond.area_rep,
        "gap_beyond": "" if beyond is None else beyond.mean_gap, "seconds": round(seconds, 2),
    }  # fmt: skip


def summary(rows: Iterable[dict[str, Any]]) -> str:
    """Median, 90 % and most of the pairs, and their ratio to the last solve and to one from rest."""
    rows = list(rows)
    every, rows = rows, rows[:COUNT]
    lines = [f"{len(rows)} systems: " + ", ".join(f"{sum(row['status'] == each for row in rows)} {each}" for each in
             sorted({row["status"] for row in rows}))]  # fmt: skip
    for name, part in (
        ("all", rows),
        ("found", [row for row in rows if row["status"] == "CONVERGED"]),
        ("jumped over", [row for row in rows if row["status"] == "JUMPED_OVER"]),
    ):
        total = np.array([float(row["pairs"]) for row in part])
        if not total.size:
            continue
        said = [f"pairs {median(total):.0f}, {np.quantile(total, 0.9):.0f}, {total.max():.0f}"]
        for key in ("last", "rest"):
            ratio = total / np.array([max(float(row[key]), 0.5) for row in part])
            middle, most, worst = np.nanmedian(ratio), np.nanquantile(ratio, 0.9), np.nanmax(ratio)
            said.append(f"over {key} {middle:.1f}, {most:.1f}, {worst:.1f}")
        lines.append(f"{name} ({len(part)}), median, 90 %, most: " + "; ".join(said))
    for row in every[COUNT:]:
        lines.append("hard wall, 99 %, {points}, lambda_s {lambda_s}: pairs {pairs}, last {last}".format(**row))
    return "\n".join(lines)


def table(files: dict[str, Path]) -> str:
    """Pairs of the searches that converged, and over their last solve, one row for each file, as a table of a page."""
    lines = ["| search | pairs: median, 90 %, most | over the last solve | hard wall at 99 %: least to most |"]
    lines.append("| --- | --- | --- | --- |")
    for name, file in files.items():
        rows = rows_of(file)
        found = [row for row in rows[:COUNT] if row["status"] == "CONVERGED"]
        total, last = (np.array([float(row[key]) for row in found]) for key in ("pairs", "last"))
        of = [", ".join(f"{each:.{digits}f}" for each in (median(one), np.quantile(one, 0.9), one.max()))
              for one, digits in ((total, 0), (total / last, 1))]  # fmt: skip
        hard = [float(row["pairs"]) for row in rows[COUNT:]]
        lines.append(f"| {name} | {of[0]} | {of[1]} | {min(hard):.0f} to {max(hard):.0f} |")
    return "\n".join(lines)


def dearer(before: Path, after: Path) -> str:
    """The systems whose search takes more than :data:`DEARER` times the pairs of before, the worst ratio first."""
    both = zip(rows_of(before), rows_of(after), strict=True)
    ratios = [(float(one["pairs"]) / float(other["pairs"]), one, other) for other, one in both]
    dear = sorted((each for each in ratios if each[0] > DEARER), key=lambda each: -each[0])
    lines = ["| number | points | wall | area | pairs: three searches, one | ratio | one over its last solve |"]
    lines.append("| --- | --- | --- | --- | --- | --- | --- |")
    for ratio, row, old in dear:
        wall = row["wall"] + (f", l_a {float(row['work']):.2g}" if float(row["work"]) else "")
        wall += ", not periodic" if int(row["open"]) else ""
        area = f"{100 * float(row['area']):g} %" + (", jumped over" if row["status"] == "JUMPED_OVER" else "")
        pairs, last = float(row["pairs"]), float(row["last"])
        lines.append(
            f"| {row['number']} | {row['points']} | {wall} | {area} | {float(old['pairs']):.0f}, {pairs:.0f} "
            f"| {ratio:.2f} | {pairs / last:.1f} |"
        )
    return "\n".join([*lines, "", f"The other {len(ratios) - len(dear)} take at most {DEARER:g} times the pairs."])


def main() -> None:
    """Measure what is missing in a file, and print its summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--count", type=int, default=COUNT + len(HARD))
    given = parser.parse_args()
    for number in range(len(rows_of(given.file)), given.count):
        add_row(given.file, search(number))
    sys.stdout.write(summary(rows_of(given.file)) + "\n")


if __name__ == "__main__":
    main()
