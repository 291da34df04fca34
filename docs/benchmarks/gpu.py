"""The GPU beside the CPU, in one process: ``python -m docs.benchmarks.gpu [--sizes 1024 2048] [--threads 8]``.

For each grid: time of an FFT pair, of the copy of a field and of an iteration on the GPU; the rate of its kernels in
parts of that of the copy; a cold point near 1 % area and a short path on the GPU, on one thread of the CPU and on all,
with loads, areas, iterations and pairs of each; the largest memory of the GPU, in fields.  Ratios are what is asked for
(docs/solver.md); nothing is written but to the terminal.

Without a GPU it ends with one message.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from continuum.errors import InputError
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import solver_of
from continuum.path.loading import follow, solve
from continuum.path.state import PathState
from continuum.solve.backend import back_end
from continuum.solve.solution import Settings
from docs.benchmarks.cases import PEER_ADHESION_LENGTH, TOLERANCE, rough
from docs.benchmarks.ours import search

__all__ = ["main"]

REPEATS = 10
STEP, STEPS = 0.1, 4
"""Of the path: mean gaps a0 apart, and their number."""
PASSES = 20
"""Fields that an iteration on one grid reads or writes: gradient 5.5, direction 3.5 + 1.5, move 6.5, a search 3."""
ON_CPU = 8192
"""Largest grid that the CPU solves, too; beyond, it takes hours on one thread."""


def best(work: Callable[[], Any], wait: Callable[[], None]) -> float:
    """Smallest wall time of several runs, waited for."""
    work()
    wait()
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        wait()
        times.append(time.perf_counter() - began)
    return min(times)


def rates(n: int) -> dict[str, float]:
    """Milliseconds of an FFT pair and of the copy of a field, which reads and writes one."""
    library = back_end("cuda").library
    xp, field = library.xp, library.put(np.ones((n, n)))

    def pair() -> Any:
        return xp.fft.irfftn(xp.fft.rfftn(field, axes=(0, 1)), s=(n, n), axes=(0, 1))

    def wait() -> None:
        library.get(field[:1, :1] + 1)

    return {"pair_ms": 1e3 * best(pair, wait), "copy_ms": 1e3 * best(lambda: xp.asarray(field, copy=True), wait)}


def used() -> float:
    """Memory of the GPU in use, in bytes, by whoever; libraries keep what they have had."""
    return -back_end("cuda").library.free_memory()


def points(problem: ContactProblem, mean_gap: float, device: str, threads: int) -> Iterator[tuple[PathState, float]]:
    """A cold point and the points of a path after it, with the wall time of each."""
    settings = Settings(TOLERANCE, threads=threads, device=device)
    solver = solver_of(problem, settings)
    targets = [mean_gap - STEP * i for i in range(STEPS)]
    began = time.perf_counter()
    for state in follow(problem, "mean-gap", targets, settings, (), solver=solver):
        yield state, time.perf_counter() - began
        began = time.perf_counter()


def iteration(problem: ContactProblem, mean_gap: float, start: Real) -> float:
    """Milliseconds of an iteration on one grid: iterations 10 to 40 on the way to a state 0.1 a0 closer."""
    device = back_end("cuda")

    def seconds(iterations: int) -> float:
        settings = Settings(1e-30, max_iterations=iterations, warm_grids=0, device="cuda")
        return solve(problem, "mean-gap", mean_gap - 0.1, settings, start).solution.seconds

    grids, device.LEVELS = device.LEVELS, 1
    try:
        return 1e3 * (seconds(40) - seconds(10)) / 30
    finally:
        device.LEVELS = grids


def told(device: str, threads: int, found: list[tuple[PathState, float]]) -> str:
    """One line for each point."""
    who = device if device == "cuda" else f"{device}, {threads} threads"
    lines = []
    for i, (state, seconds) in enumerate(found):
        s = state.solution.require()
        lines.append(
            f"  {who:16} {'path' if i else 'cold'}  {seconds:9.3f} s  {s.iterations:4d} iterations  "
            f"{s.fft_pairs:7.1f} pairs  area {state.area_rep:.8f}  load {state.load:.12e}\n"
        )
    return "".join(lines)


def measure(n: int, threads: int, mean_gap: float) -> None:
    """All of one grid."""
    say = sys.stdout.write
    ms = rates(n)
    problem = rough(n, 1, PEER_ADHESION_LENGTH).problem()
    before, most, found = used(), 0, []
    for state, seconds in points(problem, mean_gap, "cuda", 1):
        found.append((state, seconds))
        most = max(most, used() - before)
    cold, seconds = found[0]
    one = iteration(problem, mean_gap, cold.gap)
    share = PASSES / 2 * ms["copy_ms"] / (one - ms["pair_ms"])
    say(f"{n}²: FFT pair {ms['pair_ms']:.3f} ms, copy of a field {ms['copy_ms']:.3f} ms, iteration {one:.3f} ms\n")
    say(f"  iteration over FFT pair {one / ms['pair_ms']:.2f}, kernels at {100 * share:.0f} % of the copy rate, ")
    say(f"memory {most / (8 * n * n):.2f} fields\n{told('cuda', 1, found)}")
    for count in dict.fromkeys((1, threads)) if n <= ON_CPU else ():
        beside = list(points(problem, mean_gap, "cpu", count))
        differ = abs(cold.load - beside[0][0].load) / abs(beside[0][0].load)
        say(told("cpu", count, beside))
        say(f"  cuda is {beside[0][1] / seconds:.1f} times as fast; loads differ by {differ:.1e}\n")


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="docs.benchmarks.gpu", description=__doc__)
    parser.add_argument("--sizes", nargs="+", type=int, default=[1024, 2048, 4096, 8192, 16384, 32768])
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="of the CPU, beside one")
    options = parser.parse_args(arguments)
    try:
        sys.stdout.write(f"{back_end('cuda').machine()}\n")
    except InputError as missing:
        sys.stderr.write(f"{missing}\n")
        return missing.exit_code
    # Near 1 % area on each grid: the mean gap of such states grows like the height of the wall.
    small = rough(1024, 1, PEER_ADHESION_LENGTH).problem()
    gap = search(1024, 1, PEER_ADHESION_LENGTH)["mean_gap"] - 1
    list(points(small, 1 + gap, "cuda", 1))  # compiles
    for n in options.sizes:
        height = rough(n, 1, PEER_ADHESION_LENGTH).heights().std() / small.heights.std()
        try:
            measure(n, options.threads, 1 + float(gap * height))
        except MemoryError as full:
            sys.stdout.write(f"{n}²: does not fit: {full}\n")
            break
    return 0


if __name__ == "__main__":
    sys.exit(main())
