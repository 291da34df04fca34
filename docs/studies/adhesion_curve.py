"""The adhesion curve from states without adhesion, beside full loops of the solver on surfaces that made nothing of it.

``nice -n 19 python -m docs.studies.adhesion_curve`` adds the loops that are missing to its table, seed 61 before seed
62, and their points to another one; some 90 minutes on one core.  The bounds are in docs/studies/adhesion_curve.md.

Lengths are in pixels, pressures in E*, areas fractions of A0.
"""

from __future__ import annotations

import csv
import gzip
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import scipy

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.walls import HardWall, LennardJonesSpline, Wall
from continuum.path.adhesion_curve import AdhesionCurve, PressedSeries, press_series
from continuum.path.area import find_area
from continuum.path.equilibrium import solver_of
from continuum.path.loading import follow
from continuum.path.state import Search
from continuum.path.threshold import PressedState
from continuum.path.threshold_search import WallOfWork
from docs.studies.one_state import (
    CORE,
    HEIGHT,
    RESOLVED,
    STEEP,
    SUBSTRATES,
    TEXTURES,
    Rng,
    fine,
    law,
    places,
    spectral,
    unit,
)

MEASURED = Path(__file__).parents[1] / "measured"
FILE, POINTS = MEASURED / "adhesion-curve.csv", MEASURED / "adhesion-curve-points.csv.gz"
N, SEEDS, FACTORS = 256, (61, 62), (0.7, 1.5, 3.0)
SHAPES = "spline", "exponential", "paper"
DELTAS = 0.5, 1.5
"""Short and long range, in rms heights of the fine roughness."""
KEY = "kind", "seed", "shape", "delta", "factor"
"""Columns that name a loop."""
DOWN, UP = 30, 26
"""States of a loop, on approach and on retraction."""


def wrinkled(rng: Rng, n: int) -> Real:
    """Waves of one length in all directions, under a fine roughness."""
    q0, width = 2 * np.pi / rng.uniform(20, 40), rng.uniform(0.05, 0.2)

    def density(qx: Real, qy: Real) -> Real:
        return np.exp(-(((np.hypot(qx, qy) / q0 - 1) / width) ** 2))

    return float(rng.uniform(1, 3)) * spectral(rng, n, density) + fine(rng, n)


def scratched(rng: Rng, n: int) -> Real:
    """A smooth surface with straight scratches in all directions, each with a burr at one side."""
    x, y = np.mgrid[:n, :n]
    found = float(rng.uniform(0.5, 1)) * fine(rng, n)
    for _ in range(rng.integers(8, 20)):
        p, q = rng.integers(-3, 4, 2)
        if p == q == 0:
            continue
        across = ((x * p + y * q + rng.integers(0, n)) % n - n / 2) / rng.uniform(2, 5)
        found = found + rng.uniform(1, 4) * (0.5 * np.exp(-((across - 2) ** 2)) - np.exp(-(across**2)))
    return found


def billows(rng: Rng, n: int) -> Real:
    """Rounded hills that meet in creases."""
    slow = c.SelfAffine(0.8, 0.1, 12.0, 64.0).synthesise(Grid.square(n), rng)
    return float(rng.uniform(2, 5)) * -np.sqrt(np.abs(unit(slow))) + 0.5 * fine(rng, n)


def cells(rng: Rng, n: int) -> Real:
    """Polygons of one height each, a little tilted, as of polished grains."""
    nearest, height = np.full((n, n), np.inf), np.zeros((n, n))
    for squared in places(rng, n, int(rng.integers(40, 120))):
        height = np.where(squared < nearest, rng.normal(0, 1), height)
        nearest = np.minimum(squared, nearest)
    smooth = np.exp(-2 * (np.pi * 1.5 * np.hypot(*np.meshgrid(*2 * (np.fft.fftfreq(n),), indexing="ij"))) ** 2)
    return float(rng.uniform(1, 3)) * np.fft.ifft2(np.fft.fft2(height) * smooth).real + fine(rng, n)


def self_affine_of(hurst: float, lambda_s: float) -> Callable[[Rng, int], Real]:
    """A self-affine surface of four roll-off lengths."""

    def made(rng: Rng, n: int) -> Real:
        return unit(c.SelfAffine(hurst, 0.1, lambda_s, n / 4).synthesise(Grid.square(n), rng))

    return made


KINDS: Mapping[str, Callable[[Rng, int], Real]] = {
    **TEXTURES, "wrinkled": wrinkled, "scratched": scratched, "billows": billows, "cells": cells,
    "self-affine, H = 0.3": self_affine_of(0.3, 4.0), "self-affine, H = 0.7": self_affine_of(0.7, 6.0),
    "layer": self_affine_of(0.6, 5.0), "crystal": self_affine_of(0.5, 5.0),
}  # fmt: skip
"""Kinds of surfaces; the last two on another response than that of a half-space."""


@dataclass(frozen=True)
class Case:
    """A surface and a law of attraction."""

    kind: str
    seed: int
    shape: str
    delta: float


def cases() -> Iterator[Case]:
    """Each kind and seed with one law and range, those of the seeds being different; then with another one."""
    for turn in (0, 1):
        for seed in SEEDS:
            for i, kind in enumerate(KINDS):
                slot = (i + seed + turn) % len(DELTAS)
                yield Case(kind, seed, SHAPES[(i + seed + slot) % len(SHAPES)], DELTAS[slot])


@lru_cache(1)
def pressed(kind: str, seed: int, core: float) -> tuple[c.Contact, PressedSeries]:
    """A surface, pressed without adhesion to all areas."""
    rng = np.random.default_rng([list(KINDS).index(kind), seed, 7])
    grid = Grid.square(N)
    heights = -HEIGHT * KINDS[kind](rng, N)
    heights = heights * min(1.0, STEEP / c.moments(grid, heights).rms_slope)
    contact = c.Contact(heights, HardWall(), SUBSTRATES.get(kind, HalfSpace("clamped")), tolerance=1e-4)
    solver = solver_of(contact.problem, contact.settings)
    first = find_area(contact.problem, 0.01, contact.settings, Search(area_tolerance=0.03), (), "start", solver)
    return contact, press_series(contact.problem, first.require(), contact.settings, core, solver=solver)


def snapping(state: PressedState, wall: Wall) -> float:
    """1/w_snap: the largest eigenvalue of -τ' G beside the contact, in E* a pixel."""
    slope = np.sqrt(np.maximum(-state.attraction(wall)[1], 0.0))
    inside, field = slope > 0, np.zeros(state.grid.shape)

    def product(v: Real) -> Real:
        field[inside] = v * slope[inside]
        found: Real = state.core.compliance(field)[inside] * slope[inside]
        return found

    linalg, size = scipy.sparse.linalg, int(inside.sum())
    operator = linalg.LinearOperator((size, size), matvec=product, dtype=np.float64)
    start = np.random.default_rng(0).normal(size=size)
    return float(linalg.eigsh(operator, 1, which="LA", tol=1e-2, ncv=8, v0=start, return_eigenvectors=False)[0])


def law_of(series: PressedSeries, case: Case) -> tuple[WallOfWork, float]:
    """The law of each work, with a range that the pixels resolve at three times the threshold, which is the other."""
    scale = min(1.0, float(series.heights.std()) / HEIGHT)
    reach = case.delta * HEIGHT * max(scale, 0.2)
    while True:
        wall_of = law(case.shape, reach)
        state = min(series.states, key=lambda one: abs(one.area_rep - 0.01))
        found = state.threshold(wall_of)
        work = found.work if np.isfinite(found.work) else found.low
        if case.shape == "paper" or 3 * work <= RESOLVED * reach**2 or reach > 4 * HEIGHT:
            break
        reach *= 1.3
    at_one = float(series.curve(wall_of(work)).at([0.01]).thresholds()[0])
    return wall_of, at_one if np.isfinite(at_one) else work


def core_of(case: Case) -> float:
    """Stiffness of the law where it repels."""
    return LennardJonesSpline(0.1).minimum_stiffness if case.shape == "paper" else CORE


def predicted(series: PressedSeries, curve: AdhesionCurve, wall: Wall, threshold: float) -> dict[str, float]:
    """The numbers of one work, from states without adhesion."""
    work = wall.work_of_adhesion
    least = curve.least(work)
    near = min(series.states, key=lambda one: abs(np.log(one.area_rep / max(least.area, curve.areas[0]))))
    at_least = curve.at([max(least.area, curve.areas[0])])
    zero, (sphere, whole) = curve.at_load(work, 0.0), curve.tension_on_sphere(work)
    said = {
        "range": wall.effective_range, "threshold": threshold, "work": work,
        "least": least.load, "least_area": least.area, "least_x": least.x, "least_patches": least.patches,
        "least_inside": float(least.inside), "zero_area": np.nan if zero is None else zero.area,
        "sphere": sphere if whole else np.nan, "end_load": float(curve.loads(work)[-1]),
        "moved": float((at_least.moved * at_least.remaining(work))[0]), "snap": work * snapping(near, wall),
        "snap_most": work * max(snapping(one, wall) for one in series.states), "most_x": float(curve.x(work).max()),
    }  # fmt: skip
    for percent in (1, 5):
        there = curve.at([percent / 100])
        said |= {
            f"N0_{percent}": float(there.load[0]), f"N_{percent}": float(there.loads(work)[0]),
            f"quadratic_{percent}": float((there.load + there.first * work + there.second * work**2)[0]),
            f"x_{percent}": float(there.x(work)[0]), f"patches_{percent}": float(there.patches[0]),
        }  # fmt: skip
    return said


def row(case: Case, factor: float) -> tuple[dict[str, float], list[tuple[float, float, float]]]:
    """The numbers of one loop, predicted and solved, and its points."""
    contact, series = pressed(case.kind, case.seed, core_of(case))
    wall_of, threshold = law_of(series, case)
    wall = wall_of(factor * threshold)
    curve = series.curve(wall)
    said = predicted(series, curve, wall, threshold)
    began = time.process_time()
    end = float(curve.dense.gaps(wall.work_of_adhesion)[-1])
    points, converged = loop(contact, wall, float(curve.gaps_apart[0]), end)
    return said | solved(points, curve) | {"converged": converged, "seconds": time.process_time() - began}, points


def again(one: Mapping[str, str], points: list[tuple[float, float, float]]) -> dict[str, float]:
    """The numbers of a stored loop, predicted anew, at its work and range."""
    case = Case(one["kind"], int(one["seed"]), one["shape"], float(one["delta"]))
    _, series = pressed(case.kind, case.seed, core_of(case))
    wall = law(case.shape, float(one["range"]))(float(one["work"]))
    curve = series.curve(wall)
    said = predicted(series, curve, wall, float(one["threshold"])) | solved(points, curve)
    return said | {name: float(one[name]) for name in ("converged", "seconds")}


def loop(contact: c.Contact, wall: Wall, touch: float, end: float) -> tuple[list[tuple[float, float, float]], float]:
    """Mean gap beyond zero traction, load and area of each state of a loop, and how many of them converged."""
    problem, settings = replace(contact.problem, wall=wall), contact.settings
    reach = min(wall.reach - wall.zero_gap, 4 * wall.effective_range)
    down = np.linspace(touch + 0.8 * reach, end, DOWN)
    up = np.linspace(end, touch + 1.6 * reach, UP)[1:]
    found, good = list[tuple[float, float, float]](), 0
    for i, state in enumerate(follow(problem, "mean-gap", [*(down + wall.zero_gap), *(up + wall.zero_gap)], settings)):
        good += state.converged
        found.append((state.mean_gap - wall.zero_gap, state.load, state.area_rep))
        if i >= DOWN and state.area_rep == 0:
            break
    return found, good / len(found)


def solved(points: list[tuple[float, float, float]], curve: AdhesionCurve) -> dict[str, float]:
    """What the points of a loop say.

    Between its points the attraction, the load without adhesion less the load, is interpolated: the load itself bends.
    """
    gap, load, area = np.array(points).T
    down, up = slice(0, DOWN), slice(DOWN - 1, None)
    lowest = int(np.argmin(load[down]))
    forces = np.concatenate([[0.0], np.cumsum((load[down][1:] + load[down][:-1]) / 2 * -np.diff(gap[down]))])
    says = {
        "solved_least": float(load[down][lowest]), "solved_least_area": float(area[down][lowest]),
        "solved_least_inside": float(lowest < DOWN - 1), "solved_pull_off": float(load.min()),
        "solved_sphere": -float(forces.min()) if 0 < np.argmin(forces) < DOWN - 1 else np.nan,
        "solved_end_area": float(area[DOWN - 1]), "solved_end_load": float(load[DOWN - 1]),
    }  # fmt: skip
    # Both branches over the gaps of the way back, the approach interpolated; beyond it they are one.
    between = np.interp(gap[up], gap[down][::-1], load[down][::-1], right=0.0)
    says["solved_lost"] = float(np.trapezoid(between - load[up], gap[up]))
    touching = np.flatnonzero((area[down] >= curve.areas[0]) & (area[down] <= curve.areas[-1]))
    touching = touching[np.diff(area[down][touching], prepend=0.0) > 0]
    attraction = curve.at(area[down][touching]).load - load[down][touching] if touching.size else np.empty(0)
    for percent in (1, 5):
        there = np.log(percent / 100)
        known = np.log(area[down][touching])
        says[f"solved_N_{percent}"] = np.nan
        if known.size > 1 and known[0] <= there <= known[-1]:
            free = float(curve.at([percent / 100]).load[0])
            says[f"solved_N_{percent}"] = free - float(np.interp(there, known, attraction))
    crossing = np.flatnonzero((load[down][:-1] < 0) & (load[down][1:] >= 0) & (area[down][1:] > 0))
    says["solved_zero_area"] = np.nan
    if crossing.size:
        i = int(crossing[-1])
        share = load[i] / (load[i] - load[i + 1])
        says["solved_zero_area"] = float(area[i] + share * (area[i + 1] - area[i]))
    return says


def remade() -> None:
    """Predict all stored loops anew."""
    with FILE.open(newline="") as file:
        stored = list(csv.DictReader(file))
    with gzip.open(POINTS, "rt", newline="") as file:
        loops: dict[tuple[str, ...], list[tuple[float, float, float]]] = {}
        for one in csv.DictReader(file):
            values = float(one["mean_gap"]), float(one["load"]), float(one["area_rep"])
            loops.setdefault(tuple(one[name] for name in KEY), []).append(values)
    FILE.unlink()
    for one in stored:
        key = {name: one[name] for name in KEY}
        said = again(one, loops[tuple(key.values())])
        add(FILE, [{**key, **{name: f"{value:.6g}" for name, value in said.items()}}])


def main() -> None:
    """Add the loops that are missing; with ``--again`` predict the stored ones anew."""
    if sys.argv[1:] == ["--again"]:
        remade()
        return
    known = set()
    if FILE.exists():
        with FILE.open(newline="") as file:
            known = {(one["kind"], int(one["seed"]), one["shape"], float(one["delta"]), float(one["factor"]))
                     for one in csv.DictReader(file)}  # fmt: skip
    for case in cases():
        for factor in FACTORS:
            key = (case.kind, case.seed, case.shape, case.delta, factor)
            if key in known:
                continue
            said, points = row(case, factor)
            whole = {**vars(case), "factor": factor, **{name: f"{value:.6g}" for name, value in said.items()}}
            add(POINTS, [{**vars(case), "factor": factor, "mean_gap": f"{gap:.5g}", "load": f"{load:.5g}",
                          "area_rep": f"{area:.5g}"} for gap, load, area in points])  # fmt: skip
            add(FILE, [whole])
            print(key, f"{said['seconds']:.1f} s", flush=True)  # noqa: T201


def add(path: Path, rows: list[dict[str, object]]) -> None:
    """Append rows to a table, with its head if it is new."""
    new = not path.exists()
    with gzip.open(path, "at", newline="") if path.suffix == ".gz" else path.open("a", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    sys.exit(main())
