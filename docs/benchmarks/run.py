"""The benchmarks: ``python -m docs.benchmarks.run [--sizes 512 1024] [--tables work adhesive] [--minutes 20]``.

Every measurement is a process of its own with one thread, one after the other; ours and a peer's take turns, so that a
machine that others use disturbs both alike.  Small grids come first.  What is expected to pass the time allowed is
left out and named; the results file is written after each row, and running again goes on from there.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from itertools import product
from pathlib import Path
from statistics import median
from typing import Any

from continuum.store.provenance import now, provenance
from docs.benchmarks import report
from docs.benchmarks.atoms import CRYSTALS, WALLS
from docs.benchmarks.cases import (
    ADHESION_LENGTHS,
    MOST_POINTS,
    PEER_ADHESION_LENGTH,
    PEER_AREAS,
    PEER_PRESSURES,
    PEER_SURFACES,
    PRESSURE,
    SEEDS,
    SIZES,
    TOLERANCE,
)
from docs.benchmarks.kinds import KINDS
from docs.benchmarks.optimizers import SLABS
from docs.benchmarks.paths import AREAS

__all__ = ["TABLES", "Missing", "Results", "main"]

Row = dict[str, Any]
ROOT = Path(__file__).resolve().parents[2]
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
PEER_GTOL = 2e-7
"""Largest gradient that the adhesive peer is asked for, in E*: about 1e-8 rms, loads to better than 1e-6."""
PENTOL, TAMAAS_TOLERANCE, ASPHER_TOLERANCE, HARD_TOLERANCE = 1e-7, 1e-8, 1e-9, TOLERANCE
"""Each in its code's own terms: gaps to 1e-7, 3e-8, 3e-8 and 5e-9 a0 at 1024², which the table shows; ours the best."""
REPEATS, LONG = 3, 5.0
"""Turns of ours and a peer; one only of a peer that takes longer, in seconds."""
ALONE = {"springs": 64, "Lennard-Jones": 32, "copper": 32}
"""Largest surfaces, in atoms a side, on which LAMMPS' minimisers go the same way: minutes beyond."""
MOST_ATOMS = {"springs": 128, "Lennard-Jones": 64, "copper": 64}
GROWTH = 6.0
"""Time on a grid over that on half as many points a side, at most: 4 by points, the rest by iterations and caches."""


class Missing(Exception):
    """A measurement that could not be made, and why."""


class Results:
    """Rows that are there, those still to be measured, and the time left."""

    def __init__(self, file: Path, minutes: float) -> None:
        self.file, self.end = file, time.monotonic() + 60 * minutes
        self.minutes = minutes
        head: Row = {"machine": machine(), "sources": _sources()}
        self.content: Row = head | {"provenance": provenance(()), "seconds": 0.0, "rows": {}}
        if file.exists():
            found = json.loads(file.read_text())
            if {key: found.get(key) for key in head} == head:
                self.content = found
            else:
                sys.stderr.write(f"{file} is of other sources or another machine: starting afresh\n")
        self.content["date"] = now()

    @property
    def left(self) -> float:
        """Seconds."""
        return max(0.0, self.end - time.monotonic())

    def find(self, table: str, point: Row) -> Row | None:
        """The row of a point, if it was measured."""
        return next((row for row in self.content["rows"].get(table, []) if row.items() >= point.items()), None)

    def measure(self, table: str, point: Row, work: Callable[[], Row], where: str = "") -> Row:
        """The row of a point: found, measured now, or why it is missing."""
        found = self.find(table, point)
        if found is not None and "skipped" not in found:
            return found
        sys.stderr.write(f"{where:>8} {table}: {report.line(point)} ... ")
        sys.stderr.flush()
        began = time.monotonic()
        smaller = self.find(table, point | {"n": point.get("n", 0) // 2}) or {}
        try:
            if GROWTH * smaller.get("seconds", 0.0) >= self.left:
                raise Missing(f"left out of a run of {self.minutes:g} min; running again goes on")
            row = point | work()
        except Missing as reason:
            row = point | {"skipped": str(reason)}
        seconds = time.monotonic() - began
        self.content["seconds"] += seconds
        rows = self.content["rows"].setdefault(table, [])
        rows[:] = [other for other in rows if other is not found]
        rows.append(row | {"seconds": seconds})
        self.file.write_text(json.dumps(self.content, indent=1) + "\n")
        sys.stderr.write(f"{row.get('skipped', '')}{report.short(row)} ({seconds:.0f} s)\n")
        return row

    def job(self, name: str, **arguments: Any) -> Row:
        """Run one measurement in a process of its own and return what it printed."""
        command = [sys.executable, "-m", "docs.benchmarks.job", name, json.dumps(arguments)]
        environment = os.environ | ONE_THREAD | {"PYTHONPATH": str(ROOT)}
        try:
            done = subprocess.run(
                command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=max(60.0, self.left)
            )
        except subprocess.TimeoutExpired as late:
            raise Missing(f"stopped after {late.timeout:.0f} s, the end of this run") from None
        if done.returncode:
            raise Missing("failed: " + (done.stderr.strip().splitlines() or ["?"])[-1])
        result: Row = json.loads(done.stdout.splitlines()[-1])
        if "skipped" in result:
            raise Missing(result["skipped"])
        return result

    def search(self, n: int, seed: int, adhesion_length: float, **_: Any) -> Row:
        """Mean gap near 1 % area, searched once."""
        point = {"n": n, "seed": seed, "adhesion_length": adhesion_length}
        row = self.measure("search", point, lambda: self.job("ours.search", **point))
        if "skipped" in row:
            raise Missing(row["skipped"])
        return row


Plan = Iterator[tuple[Row, Callable[[Results], Row]]]


def work(n: int) -> Plan:
    """FFT pairs and memory of a load point near 1 % area; of the largest grids one point only."""
    few = n > MOST_POINTS["work"]
    for length in (PEER_ADHESION_LENGTH,) if few else ADHESION_LENGTHS:
        for seed in SEEDS[:1] if few else SEEDS:
            point = {"n": n, "seed": seed, "adhesion_length": length}

            def measured(results: Results, point: Row = point) -> Row:
                found = results.search(**point)
                row = results.job("ours.mean_gap_at", **point, mean_gap=found["mean_gap"])
                return row | {"search_pairs": found["fft_pairs"], "search_cpu": found["cpu"]}

            yield point, measured


def iteration(n: int) -> Plan:
    """Time of an iteration over that of an FFT pair, and bandwidth outside the transforms; medians on small grids."""
    for length in ADHESION_LENGTHS[:2] if n <= MOST_POINTS["iteration"] else ():
        point = {"n": n, "seed": 1, "adhesion_length": length}

        def measured(results: Results, point: Row = point) -> Row:
            gap = results.search(**point)["mean_gap"]
            repeats = REPEATS if point["n"] <= MOST_POINTS["seeds"] else 1
            rows = [results.job("ours.iteration", **point, mean_gap=gap) for _ in range(repeats)]
            return {key: median(row[key] for row in rows) for key in rows[0]}

        yield point, measured


def _turns(peer: Callable[[], Row], ours: Callable[[], Row], first: Row) -> Row:
    """Medians of the CPU times of two jobs that take turns, the peer's first done, with all that the last runs said."""
    sides: tuple[list[Row], list[Row]] = ([first], [ours()])
    for _ in range(REPEATS - 1):
        if first["cpu"] < LONG:
            sides[0].append(peer())
        sides[1].append(ours())
    theirs, mine = (
        side[-1] | {"cpu": median(one["cpu"] for one in side), "cpus": [one["cpu"] for one in side]} for side in sides
    )
    return {"theirs": theirs, "ours": mine}


def adhesive(n: int) -> Plan:
    """Against Adhesion, from few contacts to many.

    The peer goes first; ours is then asked for the peer's mean gap and the peer's residual, as we evaluate them.
    """
    shown = [surface for surface in PEER_SURFACES if n <= min(surface[-1], MOST_POINTS["adhesive"])]
    for (lambda_s, hurst, length, _), area, seed in product(shown, PEER_AREAS, SEEDS[:2]):
        point = {"n": n, "seed": seed, "adhesion_length": length, "lambda_s": lambda_s, "hurst": hurst}

        def measured(results: Results, point: Row = point, area: float = area) -> Row:
            found = results.job("ours.gap_of", **point, area=area)
            return _beside_adhesion(results, point, found["mean_gap"], found["pressure"])

        yield point | {"asked": area, "peer": "Adhesion"}, measured


def _beside_adhesion(results: Results, point: Row, target: float, pressure: float) -> Row:
    """Times and states of the two codes at one mean gap; where these differ, what the peer's becomes in ours."""
    with tempfile.TemporaryDirectory() as folder:
        file = f"{folder}/theirs.npy"
        asked = {"mean_gap": target, "pressure": pressure, "gtol": PEER_GTOL}
        theirs = results.job("peers.adhesion", **point, **asked, save=file)
        return {"theirs": theirs, **results.job("ours.beside", **point, file=file, turns=REPEATS)}


def hard_wall(n: int) -> Plan:
    """Hard wall at given mean pressures, against its peers; on the largest grids at one only."""
    peers: tuple[tuple[str, str, Row], ...] = (
        ("ContactMechanics", "peers.contact_mechanics", {"pentol": PENTOL}),
        ("Tamaas", "peers.tamaas", {"tolerance": TAMAAS_TOLERANCE}),
        ("ASPHER", "peers.aspher", {"tolerance": ASPHER_TOLERANCE}),
    )
    states = product(PEER_PRESSURES, SEEDS[:2]) if n <= MOST_POINTS["seeds"] else ((PRESSURE, 1),)
    for (pressure, seed), (name, function, settings) in product(states, peers if n <= MOST_POINTS["hard_wall"] else ()):
        point = {"n": n, "seed": seed, "lambda_s": 16.0, "pressure": pressure}

        def measured(results: Results, point: Row = point, function: str = function, settings: Row = settings) -> Row:
            with tempfile.TemporaryDirectory() as folder:
                mine, theirs = f"{folder}/mine.npy", f"{folder}/theirs.npy"

                def peer() -> Row:
                    return results.job(function, **point, **settings, save=theirs)

                def ours() -> Row:
                    return results.job("ours.hard_wall", **point, tolerance=HARD_TOLERANCE, save=mine)

                times = _turns(peer, ours, peer())
                return times | results.job("ours.judge_hard", **point, files=[theirs, mine])

        yield point | {"peer": name}, measured


def atoms(n: int) -> Plan:
    """Atoms under a rough wall: our iteration against LAMMPS' minimisers; these on small cells only."""
    for crystal, length in product(CRYSTALS, (0.0, PEER_ADHESION_LENGTH)):
        point = {"n": n, "crystal": crystal, "adhesion_length": length}
        alone = n <= ALONE[crystal]

        def measured(results: Results, point: Row = point, alone: bool = alone) -> Row:
            return results.job("atoms.equilibrium", **point, alone=alone)

        if n <= MOST_ATOMS[crystal]:
            yield point | {"sources": _sources("atomistic", "atoms")}, measured


def walls(n: int) -> Plan:
    """Evaluations of the forces on atoms with walls of each kind, and without one."""
    for kind in WALLS:
        point = {"n": n, "kind": kind}

        def measured(results: Results, point: Row = point) -> Row:
            return results.job("atoms.wall", **point)

        yield point | {"sources": _sources("atomistic", "atoms")}, measured


def optimizers() -> Plan:
    """Evaluations of the forces that optimizers of ASE and LAMMPS need under one wall."""
    for slab in SLABS:
        point = {"slab": slab}

        def measured(results: Results, point: Row = point) -> Row:
            return results.job("optimizers.counts", **point)

        yield point | {"sources": _sources("atomistic", "optimizers")}, measured


def threshold(n: int) -> Plan:
    """The threshold beside the search for its area at one work of adhesion."""
    for hurst, reach, seed in product((0.2, 0.8), (0.0, 0.5, 1.6), SEEDS if n <= MOST_POINTS["threshold"] else ()):
        point = {"n": n, "hurst": hurst, "reach": reach, "seed": seed}
        yield point, lambda results, point=point: results.job("ours.threshold", **point)


def kinds(n: int) -> Plan:
    """One contact of each further kind."""
    for kind, seed in product(KINDS, SEEDS if n <= MOST_POINTS["kinds"] else ()):
        point = {"n": n, "kind": kind, "seed": seed}
        yield point, lambda results, point=point: results.job("kinds.contact", **point)


def searches(n: int) -> Plan:
    """An area from rest, and a path of mean gaps, beside solves from rest at the same mean gaps."""
    for length, seed in product(ADHESION_LENGTHS, SEEDS[:2] if n <= MOST_POINTS["searches"] else ()):
        point = {"n": n, "adhesion_length": length, "seed": seed}
        for area in AREAS:
            given = point | {"area": area}
            yield given, lambda results, given=given: results.job("paths.search", **given)
        yield point | {"area": "path"}, lambda results, point=point: results.job("paths.path", **point)


TABLES = {table.__name__: table for table in (work, iteration, adhesive, hard_wall, threshold, kinds, searches)}
"""Each plans its rows on one grid; `report` has a function of the same name that writes them as text."""


def machine() -> Row:
    """Where it ran, without names."""
    found: Row = {"python": platform.python_version(), "processor": platform.machine(), "cores": os.cpu_count()}
    information = Path("/proc/cpuinfo")
    names = information.read_text().splitlines() if information.exists() else []
    found["processor"] += "".join(
        {f", {name.split(':')[1].strip()}" for name in names if name.startswith("model name")}
    )
    for name in ("numpy", "scipy", "numba", "ducc0", *report.PEERS):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def _sources(package: str = "continuum", *own: str) -> str:
    """Digest of what is measured: rows of one results file belong together."""
    files = [
        ROOT / "docs" / "benchmarks" / f"{name}.py"
        for name in own or ("cases", "job", "kinds", "ours", "paths", "peers")
    ]
    digest = hashlib.sha256()
    for file in [*sorted((ROOT / package).rglob("*.py")), ROOT / "tests" / "problems.py", *files]:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="docs.benchmarks.run", description=__doc__)
    parser.add_argument("--sizes", nargs="*", type=int, default=list(SIZES), help="points a side (default %(default)s)")
    parser.add_argument("--tables", nargs="+", choices=list(TABLES), default=list(TABLES))
    parser.add_argument("--atoms", nargs="*", type=int, default=[32, 64], help="surface atoms a side (default 32 64)")
    parser.add_argument("--minutes", type=float, default=20.0, help="of this run, at most (default 20)")
    parser.add_argument("--results", type=Path, default=Path("results/benchmarks.json"), help="kept, and gone on from")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of studies/ and of the figure")
    options = parser.parse_args(arguments)
    options.results.parent.mkdir(parents=True, exist_ok=True)
    results = Results(options.results, options.minutes)
    plan = [(name, *step) for n in sorted(options.sizes) for name in options.tables for step in TABLES[name](n)]
    plan += [("walls", *step) for n in sorted(options.atoms) for step in walls(n)]
    plan += [("atoms", *step) for n in sorted(options.atoms) for step in atoms(n)]
    plan += [("optimizers", *step) for step in (optimizers() if options.atoms else ())]
    # Of earlier sources; the other tables start afresh by themselves.
    for name, own in (("atoms", "atoms"), ("walls", "atoms"), ("optimizers", "optimizers")):
        known = results.content["rows"].get(name, [])
        known[:] = [row for row in known if row["sources"] == _sources("atomistic", own)]
    for i, (name, point, measured) in enumerate(plan, 1):
        if name in ("work", "iteration"):
            with suppress(Missing):
                results.search(**point)
        results.measure(name, point, partial(measured, results), f"{i}/{len(plan)}")
    options.results.write_text(json.dumps(results.content, indent=1) + "\n")
    sys.stdout.write(report.write(results.content, options.docs))


if __name__ == "__main__":
    main()
