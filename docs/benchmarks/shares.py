"""Largest memory of each process that shares a contact: ``python -m docs.benchmarks.shares --points 256 1024 2048``.

Each run is one state, of one process on one device of JAX, and of two and four processes with one each.  The smallest
grid tells what Python, JAX and the compiled programs take.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from continuum.store.sheet import Column, Sheet
from docs.studies.tables import FOLDER, keep

WALLS = {"hard": '[wall]\nlaw = "hard"\n', "law": '[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = 0.005\n'}
TARGETS = {"hard": 'control = "mean-pressure"\ntargets = [0.004]', "law": 'control = "mean-gap"\ntargets = [{}]'}
INPUT = """
[grid]
n = {points}
[surface]
kind = "self-affine"
hurst = 0.8
rms_slope = 0.1
lambda_s = 32
lambda_L = {roll_off}
seed = 1
{wall}
[substrate]
response = "half-space"
mean = "clamped"
[loading]
{loading}
[solver]
device = "jax"
tolerance = 1e-4
shards = {processes}
"""


def run(folder: str) -> dict[str, Any]:
    """Run the input of a folder, in a process that the others of it join."""
    from continuum.front.runs import run as run_input

    found = run_input(Path(folder) / "shared.toml", folder)
    return {"points": [(point.load, point.area_rep, point.status) for point in found.points]}


def shared(points: int, wall: str, processes: int) -> list[dict[str, Any]]:
    """What each process found, and its largest memory."""
    loading = TARGETS[wall].format(2.0 * (points / 1024) ** 0.8 + 0.5)
    with tempfile.TemporaryDirectory() as folder:
        given = {"points": points, "roll_off": points // 4, "wall": WALLS[wall], "loading": loading}
        (Path(folder) / "shared.toml").write_text(INPUT.format(processes=processes, **given), encoding="utf-8")
        command = [sys.executable, "-m", "docs.benchmarks.job", "shares.run", json.dumps({"folder": folder})]
        running = []
        for rank in range(processes):
            own = {"PMI_RANK": str(rank), "PMI_SIZE": str(processes), "MPI_LOCALNRANKS": str(processes)}
            environment = os.environ | own | {"JAX_PLATFORMS": "cpu"}
            running.append(subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True))
        said = [each.communicate()[0] for each in running]
        if any(each.returncode for each in running):
            raise RuntimeError("\n".join(said))
        return [json.loads(each.splitlines()[-1]) for each in said]


def sheet_of(found: Mapping[tuple[int, str, int], int]) -> Sheet:
    """Largest memory of a process, and how much more that is than on the smallest grid; both over those of one process.

    Parameters
    ----------
    found : in MB, by the points along a side, the wall, and the number of processes.
    """
    head = (
        "grid", "wall", "processes", "largest memory of each, MB", "of one process, %", "above the smallest grid, MB",
        "of one process, %",
    )  # fmt: skip
    smallest = min(points for points, *_ in found)
    rows = []
    for (points, wall, processes), most in sorted(found.items()):
        one, base = found.get((points, wall, 1)), found.get((smallest, wall, processes))
        alone = found.get((smallest, wall, 1))
        above = None if base is None or points == smallest else most - base
        share = None if above is None or one is None or alone is None else 100 * above / (one - alone)
        shares = ("" if each is None else f"{each:.0f}" for each in (one and 100 * most / one, above, share))
        rows.append((f"{points}²", wall, f"{processes}", f"{most}", *shares))
    return Sheet.of("shards-memory", [Column(name) for name in head], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=[256, 1024])
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--walls", nargs="+", choices=WALLS, default=list(WALLS))
    parser.add_argument(
        "--keep", action="store_true", help="in the table of the page, in place of what it has of these"
    )
    given = parser.parse_args()
    kept = FOLDER / "shards-memory.csv"
    most = dict[tuple[int, str, int], int]()
    if given.keep and kept.exists():
        with kept.open(newline="", encoding="utf-8") as file:
            most = {(int(row[0][:-1]), row[1], int(row[2])): int(row[3]) for row in list(csv.reader(file))[1:]}
    for key in itertools.product(given.points, given.walls, given.processes):
        found = shared(*key)
        most[key] = round(max(each["peak_mib"] for each in found) * 2**20 / 1e6)
        sys.stderr.write(f"{key} {most[key]} MB {found[0]['points']}\n")
        if given.keep:
            keep("shards-memory", sheet_of(most))
    if not given.keep:
        sys.stdout.write(sheet_of(most).markdown() + "\n")


if __name__ == "__main__":
    main()
