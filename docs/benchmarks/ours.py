"""What is measured of `continuum`.  Each function runs in a process of its own and returns numbers only.

Fields go through files, so that one function, `judge`, evaluates the states of all codes by one definition.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from statistics import median
from typing import Any

import ducc0.fft
import numpy as np
from numba import njit

from continuum.measure.contact import contact_map, totals_of
from continuum.model.fourier import Real, padded
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import HardWall, LennardJonesSpline, Wall, attraction_on_core
from continuum.path.loading import solve
from continuum.path.state import PathState, Search
from continuum.path.threshold_search import WallOfWork, bracket_threshold
from continuum.solve import smooth
from continuum.solve.backend import back_end
from continuum.solve.compiled import tiles
from continuum.solve.compiled.compiling import TILE
from continuum.solve.compiled.passes import Passes
from continuum.solve.compiled.tractions import NEAR
from continuum.solve.solution import Settings, Solution
from continuum.solve.solver import Solver
from docs.benchmarks.cases import ADHESION_LENGTHS, AREA, TOLERANCE, coarse, rough
from tests.problems import Rough

__all__ = [
    "ARRAYS_MOVED",
    "beside",
    "gap_of",
    "hard_wall",
    "iteration",
    "judge",
    "judge_hard",
    "mean_gap_at",
    "search",
    "threshold",
]

ARRAYS_MOVED = {"columns": 4.5, "new_direction": 2.0, "move": 3.0}
"""Arrays that an iteration on one grid reads or writes beside the transforms, counted by hand from the sweeps.

The unit is one field of float64; a half spectrum is one array, K is half of one.

* columns, the sweep `gradient`: reads g, d, K, writes g, d; its work is in the cache, where it is transformed
* `new_direction`: reads d, writes d; the step is in the cache
* `move`: reads z, d, writes z; the change of traction stays in the cache

Tiles near the wall come on top: `new_direction` reads the stiffness there, half an array in single precision, `move`
reads and writes it and the traction, each `line` reads z, d and the traction.  Arrays that are written are read before,
so that nothing is allocated by writing; the same holds of the stream that they are compared with.
"""


def _timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """Result and CPU seconds of this process."""
    began = time.process_time()
    result = work()
    return result, time.process_time() - began


def warm_up() -> None:
    """Compile and load everything on small grids, with tiles near the wall, too: that is no part of any time."""
    for length in ADHESION_LENGTHS:
        for n, gap in ((256, 4.0), (512, 8.0)):
            solve(rough(n, 1, length).problem(), "mean-gap", gap, Settings(TOLERANCE))


def search(n: int, seed: int, adhesion_length: float) -> dict[str, Any]:
    """Mean gap near `AREA`: nine bisections on the grid of n/4, where every fourth point stands for the surface."""
    warm_up()

    def bisect() -> tuple[float, float]:
        few = coarse(rough(n, seed, adhesion_length))
        deepest = -float(few.heights.min())
        low, high, pairs = 1 + 0.2 * deepest, 1 + deepest, 0.0
        for _ in range(9):
            gap = (low + high) / 2
            state = solve(few, "mean-gap", gap, Settings(1e-5))
            pairs += state.solution.fft_pairs / 16
            if totals_of(few.grid, few.wall, state.gap).area_rep < AREA:
                high = gap
            else:
                low = gap
        return gap, pairs

    (gap, pairs), seconds = _timed(bisect)
    return {"mean_gap": gap, "fft_pairs": pairs, "cpu": seconds}


def threshold(n: int, seed: int, hurst: float, reach: float) -> dict[str, Any]:
    """Work at which the load at `AREA` changes its sign, and the search for that area at this work.

    As in inputs/sweep/law.toml: period 8 λ_L, four points to λ_s, h_rms = λ_L/512, a spline on a core of 5 E*/a0 with a
    range in units of h_rms.  With a range of 0 it is the paper's law, whose range follows from its work.
    """
    warm_up()
    grid = Grid.square(n)
    heights = SelfAffine(hurst, 0.1, 4.0, n / 8).synthesise(grid, np.random.default_rng(seed))
    heights *= n / 8 / 512 / heights.std()
    core = partial(attraction_on_core, "spline", effective_range=reach * n / 8 / 512, core_stiffness=5.0)
    wall: WallOfWork = core if reach else lambda work: LennardJonesSpline(adhesion_length=work)
    problem = ContactProblem(grid, wall(1e-4), heights, HalfSpace())
    settings, how = Settings(1e-4 * problem.traction_scale), Search(0.05, 0.02)
    (there, state), seconds = _timed(lambda: bracket_threshold(problem, wall, AREA, settings, how, 0.02))
    one, alone = _timed(lambda: solve(there, "repulsive-area", AREA, settings, search=how))
    return {
        "status": state.status.name, "fft_pairs": state.search_pairs + state.solution.fft_pairs, "cpu": seconds,
        "solves": state.search_solves + 1, "search_pairs": one.search_pairs + one.solution.fft_pairs,
        "search_cpu": alone, "over_energy": there.wall.work_of_adhesion / there.elastic_energy(np.zeros(grid.shape)),
    }  # fmt: skip


def gap_of(n: int, seed: int, area: float, **surface: float) -> dict[str, Any]:
    """Mean gap, in a0, and mean pressure, in E*, where the repulsive area is within a twentieth of a part of A0."""
    warm_up()
    problem = rough(n, seed, **surface).problem()
    state = solve(problem, "repulsive-area", area, Settings(TOLERANCE), search=Search(0.05, 0.02))
    state.require()
    return {"mean_gap": state.mean_gap, "pressure": state.load}


def mean_gap_at(n: int, seed: int, mean_gap: float, tolerance: float = TOLERANCE, **shape: float) -> dict[str, Any]:
    """One load point at a given mean gap from a cold start; the time runs from the heights to the state."""
    warm_up()
    return _cold(rough(n, seed, **shape), mean_gap, tolerance)[0]


def _cold(surface: Rough, mean_gap: float, tolerance: float) -> tuple[dict[str, Any], Real]:
    """What a cold solve took, and its gap."""
    heights = surface.heights()

    def cold() -> tuple[PathState, Wall]:
        problem = surface.problem(heights=heights)
        return solve(problem, "mean-gap", mean_gap, Settings(tolerance)), problem.wall

    (state, wall), seconds = _timed(cold)
    solution = state.solution.require()
    contact = totals_of(surface.grid, wall, state.gap)
    return {
        "cpu": seconds,
        "fft_pairs": solution.fft_pairs,
        "iterations": solution.iterations,
        "pairs_by_grid": {part.shape[0]: part.fft_pairs for part in solution.work},
        "residual": solution.residual,
        "area": contact.area_rep,
        "pressure": contact.load,
    }, state.gap


def beside(n: int, seed: int, file: str, turns: int, **shape: float) -> dict[str, Any]:
    """Ours at the mean gap and the residual of a peer's state in a file, both as we evaluate them: the median of
    thresholds.

    Where the two states differ: how many pixels the peer's loses as ours goes on from it, to a tenth of its residual.
    """
    warm_up()
    surface, peer = rough(n, seed, **shape), np.load(file)
    problem = surface.problem()
    theirs = judge(problem, peer)
    at = theirs["mean_gap"], theirs["rms_residual"]
    done = [_cold(surface, *at) for _ in range(turns)]
    row, gap = done[-1]
    found = {"ours": row | {"cpu": median(one["cpu"] for one, _ in done)}, "states": [theirs, judge(problem, gap)]}
    found["pixels_different"] = _different(problem, peer, gap)
    if found["pixels_different"]:  # two codes may end in two states: is the peer's one of ours?
        kept = solve(problem, "mean-gap", at[0], Settings(at[1] / 10, warm_grids=0), peer)
        found["lost"] = _different(problem, peer, kept.gap)
    return found


def _different(problem: ContactProblem, *gaps: Real) -> int:
    one, other = (contact_map(problem.wall, gap) for gap in gaps)
    return int(np.count_nonzero(one != other))


def judge(problem: ContactProblem, gap: Real) -> dict[str, Any]:
    """The state of any code from its gap: areas, load, energy, and the residual K u + p without its mean."""
    mean_gap = problem.grid.mean(gap)
    contact = totals_of(problem.grid, problem.wall, gap)
    separation = mean_gap - problem.mean_height
    displacement = problem.displacement(gap, separation)
    displacement -= problem.grid.mean(displacement)
    residual = problem.gradient(displacement, separation)
    return {
        "mean_gap": mean_gap,
        "pixels_rep": round(contact.area_rep * gap.size),
        "pixels_att": round(contact.area_att * gap.size),
        "pressure": contact.load,
        "energy": problem.energy(displacement, separation) / problem.grid.area,
        "rms_residual": float(np.sqrt(np.mean(residual**2))),
        "max_residual": float(np.abs(residual).max()),
    }


def hard_wall(n: int, seed: int, lambda_s: float, pressure: float, tolerance: float, save: str) -> dict[str, Any]:
    """The hard wall at a mean pressure from a cold start; the time runs from the heights to the state."""

    def cold(surface: Rough, heights: Real) -> Solution:
        problem = surface.problem(HardWall(), HalfSpace("free"), heights)
        solver = Solver(problem.grid, problem.stiffness_q)
        return solver.constrain(problem.heights, None, Settings(tolerance), pressure=pressure)

    surface = rough(n, seed, lambda_s=lambda_s)
    for small in (rough(128, 1, lambda_s=lambda_s), rough(512, 1, lambda_s=lambda_s)):  # whole, and on tiles
        cold(small, small.heights())
    heights = surface.heights()
    solution, seconds = _timed(lambda: cold(surface, heights))
    solution.require()
    np.save(save, solution.traction)
    return {"cpu": seconds, "fft_pairs": solution.fft_pairs, "iterations": solution.iterations}


def judge_hard(n: int, seed: int, lambda_s: float, files: list[str], **_: Any) -> dict[str, Any]:
    """States of several codes, from their pressures alone.

    With v = h + FFT⁻¹(p_q/K), q != 0, the gap is v + D, where D makes its mean over the pixels under pressure zero.
    An exact state has no gap at any of these and no overlap elsewhere.
    """
    problem = rough(n, seed, lambda_s=lambda_s).problem()
    grid, heights, K = problem.grid, problem.heights, problem.stiffness_q
    found, maps = [], []
    for file in files:
        pressure = np.load(file)
        touching = pressure > 0
        gap = heights + grid.inverse(grid.forward(pressure) / K)
        gap -= gap[touching].mean()
        error = max(float(np.abs(gap[touching]).max()), -float(gap.min()))
        found.append(
            {
                "pixels": int(np.count_nonzero(touching)),
                "pressure": grid.mean(pressure),
                "mean_gap": grid.mean(gap),
                "max_error": error,
            }
        )
        maps.append(touching)
    return {"states": found, "pixels_different": int(np.count_nonzero(maps[0] != maps[-1]))}


@njit
def _add(a: Real, b: Real) -> None:
    for i in range(a.size):
        a[i] += 3.0 * b[i]


def _best(work: Callable[[], Any], repeats: int = 7) -> float:
    """Smallest CPU seconds of several runs: the one least disturbed."""
    work()
    return min(_timed(work)[1] for _ in range(repeats))


def _stream(size: int) -> float:
    """Bandwidth of a <- a + 3 b over arrays of float64, in B/s: three arrays, and no more since a is read."""
    a, b = np.zeros(size), np.ones(size)
    return 3 * 8 * size / _best(lambda: _add(a, b))


def _pair(grid: Grid) -> tuple[float, float]:
    """CPU seconds of an FFT pair on padded arrays: ducc0's own, and the package's over fixed blocks."""
    passes, field = Passes(grid, np.ones(grid.shape_q), 1), padded(grid.shape)
    spectrum = passes.work_q
    field[...] = np.random.default_rng(1).standard_normal(grid.shape)

    def plain() -> None:
        ducc0.fft.r2c(field, axes=(0, 1), inorm=2, out=spectrum, nthreads=1)
        ducc0.fft.c2r(
            spectrum,
            axes=(0, 1),
            lastsize=grid.shape[1],
            forward=False,
            out=field,
            nthreads=1,
            allow_overwriting_input=True,
        )

    def blocks() -> None:
        passes.forward(field)
        passes.inverse(field)

    return _best(plain), _best(blocks)


def _near(gap: Real, reach: float) -> float:
    """Part of the tiles of a field that are near the wall."""
    close = gap < reach + NEAR
    return float(np.mean([close[:, i : i + TILE].any(axis=1) for i in range(0, gap.shape[1], TILE)]))


def iteration(n: int, seed: int, adhesion_length: float, mean_gap: float) -> dict[str, Any]:
    """CPU time of an iteration and of an FFT pair, and the stream, in one process.

    With all grids: a whole solve, over its pairs by weight.  With one: iterations 10 to 40 of the conjugate gradients
    alone, on the way from that solution to one that is 0.1 a0 closer.
    """
    stream = _stream(n * n)
    pair, block_pair = _pair(Grid.square(n))
    warm_up()
    problem = rough(n, seed, adhesion_length).problem()
    tiles.SMALLEST = 1 << 30  # no tiles, whose direct sums are no pairs
    state, whole = _timed(lambda: solve(problem, "mean-gap", mean_gap, Settings(TOLERANCE)))
    all_pairs = state.solution.require().fft_pairs

    back_end("cpu").LEVELS, smooth.PATIENCE = 1, 1 << 30  # iterations alone, no boxes

    def run(iterations: int) -> Solution:
        settings = Settings(1e-30, max_iterations=iterations, warm_grids=0)
        return solve(problem, "mean-gap", mean_gap - 0.1, settings, state.gap).solution

    (few, short), (many, long) = _timed(lambda: run(10)), _timed(lambda: run(40))
    count = many.iterations - few.iterations
    done, before = many.work[0], few.work[0]
    transforms = (done.fft_seconds - before.fft_seconds) / count
    outside = (many.seconds - few.seconds) / count - transforms
    near, lines = _near(many.gap, problem.wall.law.reach), (done.sweeps - before.sweeps) / count
    arrays = sum(ARRAYS_MOVED.values()) + near * (3.5 + 3 * lines)
    return {
        "pair_ms": 1e3 * pair,
        "block_pair_ms": 1e3 * block_pair,
        "one_ms": 1e3 * (long - short) / count,
        "one_pairs": (done.fft_pairs - before.fft_pairs) / count,
        "one_ratio": (long - short) / count / pair,
        "transforms_ms": 1e3 * transforms,
        "all_pairs": all_pairs,
        "all_ratio": whole / all_pairs / pair,
        "arrays": arrays,
        "near": near,
        "stream_gb": stream / 1e9,
        "reached_gb": arrays * 8 * n * n / outside / 1e9,
    }
