"""Largest memory of each process that shares a contact: ``python -m docs.benchmarks.shares --points 1024 2048``.

Each run is two states of a path, of one process on one device of JAX, and of two and four processes with one each.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from continuum.store.sheet import Column, Sheet
from docs.studies.tables import keep

WALLS = {"hard": '[wall]\nlaw = "hard"\n', "law": '[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = 0.005\n'}
TARGETS = {"hard": 'control = "mean-pressure"\ntargets = [0.004, 0.005]', "law": 'control = "mean-gap"\ntargets = {}'}
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
    loading = TARGETS[wall].format([2.0 * (points / 1024) ** 0.8 + k for k in (0.5, 0.4)])
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=[1024])
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--walls", nargs="+", choices=WALLS, default=list(WALLS))
    parser.add_argument("--keep", action="store_true", help="as the table of the page")
    given = parser.parse_args()
    head = [Column(name) for name in ("grid", "wall", "processes", "largest memory of each, MB", "of one process, %")]
    rows = []
    for points in given.points:
        for wall in given.walls:
            first = 0.0
            for processes in given.processes:
                found = shared(points, wall, processes)
                most = max(each["peak_mib"] for each in found) * 2**20 / 1e6
                first = first or most
                rows.append((f"{points}²", wall, f"{processes}", f"{most:.0f}", f"{100 * most / first:.0f}"))
                sys.stderr.write(f"{rows[-1]} {found[0]['points']}\n")
    sheet = Sheet.of("shards-memory", head, rows)
    if given.keep:
        keep("shards-memory", sheet)
    else:
        sys.stdout.write(sheet.markdown() + "\n")


if __name__ == "__main__":
    main()
