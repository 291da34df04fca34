"""A GPU beside the CPU: ``python -m docs.benchmarks.gpu [--sizes 1024 2048] [--cpu 2048] [--threads 1 8] [--figure2]``.

For each grid: times of an FFT pair, of the copy of a field and of an iteration on one grid and with coarser ones; a
cold point near 1 % area and two closer ones, of which the solve alone, with loads, areas, iterations and pairs; the
largest memory in fields.  Up to the grid of ``--cpu`` the same on one thread of the CPU and on all, and from one start
on both, as a rough contact has several equilibria.  ``--figure2`` asks for states of the paper's Figure 2 that the CPU
has found.

Each line is printed as soon as it is known.  Without a GPU it ends with one message.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from continuum.inputs.errors import InputError
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import solver_of
from continuum.path.loading import solve
from continuum.path.state import PathState
from continuum.solve.backend import back_end
from continuum.solve.solution import Settings
from docs.benchmarks.cases import PEER_ADHESION_LENGTH, TOLERANCE, rough
from docs.benchmarks.ours import search
from tests.problems import Rough

__all__ = ["main"]

REPEATS = 10
STEP, STEPS = 0.1, 3
"""Of the points: mean gaps a0 apart, and their number."""
FIGURE2 = Path(__file__).parents[1] / "measured/figure2-4096-cycles.csv"
FIGURE2_TOLERANCE = 1e-6
"""Residual to which these states were found, in E*."""


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def best(work: Callable[[], Any], wait: Callable[[], None]) -> float:
    """Smallest wall time of several runs in ms, waited for."""
    work()
    wait()
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        wait()
        times.append(time.perf_counter() - began)
    return 1e3 * min(times)


def rates(n: int, device: str) -> tuple[float, float]:
    """Milliseconds of an FFT pair and of the copy of a field, which reads and writes one."""
    library = back_end(device).library
    xp, field = library.xp, library.put(np.ones((n, n)))

    def pair() -> Any:
        return xp.fft.irfftn(xp.fft.rfftn(field, axes=(0, 1)), s=(n, n), axes=(0, 1))

    def wait() -> None:
        library.get(field[:1, :1] + 1)

    return best(pair, wait), best(lambda: xp.asarray(field, copy=True), wait)


def points(
    problem: ContactProblem, mean_gap: float, device: str, threads: int, start: Real | None = None
) -> list[PathState]:
    """A point, cold or from a start, and closer ones, each from the one before; printed."""
    settings, found = Settings(TOLERANCE, threads=threads, device=device), list[PathState]()
    began = time.perf_counter()
    solver = solver_of(problem, settings)
    for i in range(STEPS):
        state = solve(problem, "mean-gap", mean_gap - STEP * i, settings, start, solver=solver)
        s, seconds, start = state.solution.require(), time.perf_counter() - began, state.gap
        say(
            f"  {device if device != 'cpu' else f'cpu, {threads} threads':15} {'closer' if i else 'first ':6} "
            f"{seconds:8.3f} s, solve {s.seconds:8.3f} s  {s.iterations:3d} iterations  {s.fft_pairs:6.1f} pairs  "
            f"area {state.area_rep:.8f}  load {state.load:.10e}"
        )
        began = time.perf_counter()
        found.append(state)
    return found


def iteration(problem: ContactProblem, mean_gap: float, start: Real, device: str, grids: int) -> float:
    """Milliseconds of an iteration with so many grids: iterations 10 to 40 on the way to a state 0.1 a0 closer."""
    back = back_end(device)

    def seconds(iterations: int) -> float:
        settings = Settings(1e-30, max_iterations=iterations, warm_grids=0, device=device)
        return solve(problem, "mean-gap", mean_gap - STEP, settings, start, solver=solver).solution.seconds

    usual, back.LEVELS = back.LEVELS, grids
    try:
        solver = solver_of(problem, Settings(TOLERANCE, device=device))
        seconds(10)
        return 1e3 * (min(seconds(40) for _ in range(3)) - min(seconds(10) for _ in range(3))) / 30
    finally:
        back.LEVELS = usual


def measure(n: int, device: str, threads: list[int], mean_gap: float) -> None:
    """All of one grid."""
    problem, library = rough(n, 1, PEER_ADHESION_LENGTH).problem(), back_end(device).library
    free, began = library.free_memory(), time.perf_counter()
    solve(problem, "mean-gap", mean_gap, Settings(TOLERANCE, device=device), None)
    say(f"{n} x {n}, mean gap {mean_gap:.4f} a0, compiled and solved in {time.perf_counter() - began:.1f} s")
    cold, *_ = points(problem, mean_gap, device, 1)
    memory = (free - library.free_memory()) / (8 * n * n)
    pair, copy = rates(n, device)
    one, several = (iteration(problem, mean_gap, cold.gap, device, grids) for grids in (1, 3))
    say(
        f"  FFT pair {pair:.3f} ms, copy of a field {copy:.3f} ms, iteration on one grid {one:.3f} ms, "
        f"{one / pair:.2f} pairs, with coarser ones {several:.3f} ms; memory {memory:.1f} fields"
    )
    for count in threads:
        beside = points(problem, mean_gap, "cpu", count)
        say(f"  {device} is {beside[0].solution.seconds / cold.solution.seconds:.1f} times as fast from rest")
        for here, there in zip(points(problem, mean_gap, device, 1, beside[0].gap), beside, strict=True):
            touching = [problem.wall.touches(state.gap) for state in (here, there)]
            apart = abs(here.load - there.load) / max(abs(there.load), 1e-30)
            say(
                f"  from one start: loads differ by {apart:.1e}, gaps by "
                f"{np.abs(here.gap - there.gap).max():.1e} a0, points in contact {(touching[0] != touching[1]).sum()}"
            )


def figure2(device: str) -> None:
    """States of the paper's Figure 2 on the approach, each from the one before, beside those that the CPU found."""
    table = pd.read_csv(FIGURE2).query("approach and length <= 0.005")
    settings = Settings(FIGURE2_TOLERANCE, device=device)
    for (length, seed), rows in table.groupby(["length", "seed"]):
        start = None
        problem = Rough(4096, length, 32.0, int(seed), lambda_L=2048.0).problem()
        solver = solver_of(problem, settings)
        for row in rows.sort_values("mean_gap", ascending=False).itertuples():
            began = time.perf_counter()
            state = solve(problem, "mean-gap", row.mean_gap, settings, start, solver=solver)
            start = state.gap
            say(
                f"  l_a {length:5} seed {seed} mean gap {row.mean_gap:9.5f} {time.perf_counter() - began:6.2f} s "
                f"{state.status} load {state.load:.8e} over the CPU's {state.load / row.load - 1:+.1e} "
                f"A_rep {state.area_rep:.8f} {state.area_rep / row.area_rep - 1:+.1e}"
            )


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="docs.benchmarks.gpu", description=__doc__)
    parser.add_argument("--sizes", nargs="*", type=int, default=[1024, 2048, 4096, 8192, 16384], help="grids")
    parser.add_argument("--cpu", type=int, default=4096, help="largest grid that the CPU solves, too (default: 4096)")
    parser.add_argument("--threads", nargs="*", type=int, default=sorted({1, os.cpu_count() or 1}), help="of the CPU")
    parser.add_argument(
        "--gap", type=float, help="mean gap on the smallest grid, in a0 (default: searched for 1 %% area)"
    )
    parser.add_argument("--device", default="cuda", help="as in inputs (default: cuda)")
    parser.add_argument("--figure2", action="store_true", help="states of Figure 2 at 4096 x 4096 points, too")
    options = parser.parse_args(arguments)
    try:
        say(back_end(options.device).machine())
    except InputError as missing:
        sys.stderr.write(f"{missing}\n")
        return missing.exit_code
    # Near 1 % area on each grid: the mean gap of such states grows like the height of the wall.
    small = min(options.sizes, default=1024)
    gap = (options.gap or search(small, 1, PEER_ADHESION_LENGTH)["mean_gap"]) - 1
    height = rough(small, 1, PEER_ADHESION_LENGTH).heights().std()
    for n in options.sizes:
        taller = rough(n, 1, PEER_ADHESION_LENGTH).heights().std() / height
        try:
            measure(n, options.device, options.threads if n <= options.cpu else [], float(1 + gap * taller))
        except MemoryError as full:
            say(f"  does not fit: {full}")
            break
    if options.figure2:
        figure2(options.device)
    return 0


if __name__ == "__main__":
    sys.exit(main())
