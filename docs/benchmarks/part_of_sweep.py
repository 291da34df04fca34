"""Every twentieth system of a reduced sweep on two versions of the code, in turn.

``python -m docs.benchmarks.part_of_sweep FILE.csv --before PYTHON [--sweep INPUT]`` measures what is missing in a file,
and prints a summary; PYTHON is the interpreter of a checkout of the older version.  Each version has one process, in
which a first system loads or compiles the solver.  Both run one system after the other, so that other work on the
machine counts for both.  FFT pairs and states are those of the stored files; CPU seconds are those of a whole run, with
its surface and its file.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from statistics import median
from typing import Any

from continuum.store.sweeps.axes import Sweep
from docs.benchmarks.rows import add_row, rows_of

EVERY = 20
APART = 0.02
"""Mean gaps that differ by less, in a0, lie within the resolution of a jump."""
RESULTS = "pairs", "cpu", "status", "area_rep", "load", "mean_gap"
WORKER = """
import json, sys, tempfile, time
import continuum as c
for line in sys.stdin:
    tables, settings = json.loads(line)
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        [point] = c.run(tables, folder, settings=settings).points
    cpu, pairs = time.process_time() - began, point.fft_pairs + point.search_pairs
    print(json.dumps([pairs, cpu, str(point.status), point.area_rep, point.load, point.mean_gap]), flush=True)
"""
"""What each version runs, in words that both know."""


class _Version:
    """A process of one version of the code."""

    def __init__(self, python: str) -> None:
        self.process = subprocess.Popen(
            [python, "-P", "-c", WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, tables: dict[str, Any], settings: dict[str, Any]) -> list[Any]:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(json.dumps([tables, settings]), file=self.process.stdin, flush=True)
        found: list[Any] = json.loads(self.process.stdout.readline())
        return found


def measure(file: Path, sweep: Sweep, before: str) -> None:
    """Run the systems that are missing in a file."""
    done = len(rows_of(file))
    systems = [dict(plan.settings) for plan, *_ in sweep.plans()][::EVERY]
    versions, tables = {"before": _Version(before), "now": _Version(sys.executable)}, dict(sweep.base.data)
    for version in versions.values() if done < len(systems) else ():
        for shape in ("spline", "exponential"):
            version.run(tables, {**systems[0], "wall.shape": shape})
    for number, settings in list(enumerate(systems))[done:]:
        row: dict[str, Any] = {"number": number * EVERY, **settings}
        order = list(versions)[:: -1 if number % 2 else 1]
        found = {name: versions[name].run(tables, settings) for name in order}
        row |= {f"{key}_{name}": value for name in versions for key, value in zip(RESULTS, found[name], strict=True)}
        row = {key: f"{value:.7g}" if isinstance(value, float) else value for key, value in row.items()}
        add_row(file, row)


def summary(rows: list[dict[str, str]]) -> str:
    """Pairs and CPU seconds of before over those of now, in all and system by system, and which states differ."""
    lines = []
    for key in ("pairs", "cpu"):
        before, now = ([float(row[f"{key}_{name}"]) for row in rows] for name in ("before", "now"))
        ratios = sorted(one / other for one, other in zip(before, now, strict=True))
        lines.append(
            f"{len(rows)} systems, {key}: {sum(before):.1f} and {sum(now):.1f}, {sum(before) / sum(now):.2f} times in "
            f"all, {median(ratios):.2f} in the median ({ratios[0]:.2f} to {ratios[-1]:.2f})"
        )
    for row in rows:
        status, area, gap = (
            [row[f"{key}_{name}"] for name in ("before", "now")] for key in ("status", "area_rep", "mean_gap")
        )
        if status[0] != status[1] or abs(float(gap[0]) - float(gap[1])) > APART:
            lines.append(
                f"number {row['number']}: {', '.join(status)}; areas {', '.join(area)}; mean gaps {', '.join(gap)}"
            )
    return "\n".join(lines)


def main() -> None:
    """Measure what is missing in a file, and print its summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--before", required=True)
    parser.add_argument("--sweep", default="inputs/sweep/who-is-right.toml")
    given = parser.parse_args()
    measure(given.file, Sweep.read(given.sweep, reduced=True), given.before)
    sys.stdout.write(summary(rows_of(given.file)) + "\n")


if __name__ == "__main__":
    main()
