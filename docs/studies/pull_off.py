"""Pull-off from full contact: largest tension on the way back, against work of adhesion and shortest wave.

``python -m docs.studies.pull_off --run 12 13 14`` computes cycles of these surfaces and appends each to
``docs/measured/law-pull-off.csv``; cycles that are there are not made again.  Without ``--run`` the tables of
docs/studies/pull_off.md are made from that file, with ``--figure`` the figure too.  What is judged, and by which
bounds, stood there before the first run.

A cycle begins where the surface is flat against the wall, under the pressure of full contact and a tenth more, and goes
back by mean gap, each state from the one before and strictly in its basin.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from itertools import pairwise
from pathlib import Path

import numpy as np
from pandas import read_csv

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surfaces import SelfAffineSurface
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.estimates import pressure_of_full_contact
from continuum.path.state import PathState
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver
from docs.studies.judgement import MEASURED
from docs.studies.pull_off_judged import FILE, PART, exponent_lines, figure, reduced, tables

HURST = (0.8, 0.3)
SIZES = {4.0: 192, 8.0: 192, 16.0: 384}
"""Points along a side at each λ_L/λ_s: the period is four λ_L, and λ_s has 12, 6 and 6 points."""
PERIOD = 4.0
WORKS = (0.275, 0.55 / 2**0.5, 0.55, 0.55 * 2**0.5, 1.1)
"""In U of the surface of λ_L/λ_s = 8: the same works at each λ_s."""
RANGE = 0.5
"""Of the attraction, in h_rms."""
HEIGHT = 1 / 512
"""h_rms over λ_L; only ratios count."""
CORE = 5.0
LIMIT = 0.35
"""Single points snap where w exceeds so many Δr² E*/a0."""
TOLERANCE = 1e-4
STEP = 0.1
"""Of the mean gap, in h_rms; around the largest tension it is halved twice."""
FARTHEST = 6.0
"""Mean gap at which a way back ends, in h_rms."""


@dataclass(frozen=True)
class Cycle:
    """One way back; lengths in a0, stresses in E*, areas as fractions of A0."""

    n: int
    hurst: float
    seed: int
    lambda_s: float
    lambda_L: float
    height: float
    slope: float
    curvature: float
    energy: float
    """U, per area."""
    range: float
    work: float
    stress: float
    """Largest tension."""
    gap: float
    """Mean gap there."""
    area_rep: float
    area_att: float
    area_zero: float
    """Repulsive area where the load vanishes."""
    change: float
    """Part of the largest tension by which the last halving of the step changed it."""
    snaps: int
    """Steps from zero load to the largest tension on which a point moved by more than Δr, five steps of the wall."""
    states: int
    failed: int
    pairs: float
    seconds: float


@dataclass(frozen=True)
class Way:
    """States of a way back, in order, and the solver that they share."""

    problem: ContactProblem
    settings: Settings
    solver: Solver

    def on(self, state: PathState, mean_gap: float) -> PathState:
        return equilibrium(self.problem, "mean-gap", mean_gap, self.settings, state.gap, "retract", self.solver)

    def pressed(self, pressure: float) -> PathState:
        """Full contact: the surface is flat but for what the core gives."""
        flat = np.zeros(self.problem.grid.shape)
        core = float(self.problem.wall.evaluate(np.array([-1e-6])).stiffness[0])
        return equilibrium(self.problem, "mean-gap", -pressure / core, self.settings, flat, "start", self.solver)

    def back(self, first: PathState, step: float, farthest: float) -> list[PathState]:
        """Until attraction alone pulls less than the largest tension so far: no later state can pull as hard."""
        states, largest = [first], 0.0
        while states[-1].mean_gap < farthest:
            states.append(self.on(states[-1], step * np.floor(states[-1].mean_gap / step + 1.001)))
            largest = max(largest, -states[-1].load)
            if states[-1].load_att < largest:
                break
        return states

    def around(self, states: list[PathState], step: float) -> list[PathState]:
        """The states about the largest tension in steps that are shorter, from the state before it on."""
        top = hardest(states)
        first, end = states[max(top - 1, 0)], states[min(top + 1, len(states) - 1)].mean_gap
        found = [first]
        while found[-1].mean_gap < end - step / 2 or hardest(found) == len(found) - 1:
            found.append(self.on(found[-1], found[-1].mean_gap + step))
        return found


def hardest(states: Sequence[PathState]) -> int:
    """Place of the largest tension."""
    return int(np.argmin([state.load for state in states]))


def at_zero_load(states: Sequence[PathState]) -> float:
    """Repulsive area where the load first vanishes, linear between two states; NaN if it does not."""
    for one, other in pairwise(states):
        if one.load > 0 >= other.load:
            share = one.load / (one.load - other.load)
            return one.area_rep + share * (other.area_rep - one.area_rep)
    return float("nan")


def snapped(states: Sequence[PathState], reach: float) -> int:
    """Steps under tension on which a point moved by more than the range."""
    return sum(float(np.abs(b.gap - a.gap).max()) > reach for a, b in pairwise(states) if b.load < 0)


def surface_of(hurst: float, width: float, seed: int) -> tuple[SelfAffineSurface, Grid]:
    n = SIZES[width]
    made = {"kind": "self-affine", "hurst": hurst, "lambda_s": n / PERIOD / width, "lambda_L": n / PERIOD, "seed": seed}
    return SelfAffineSurface.model_validate({**made, "rms_height": HEIGHT * n / PERIOD}), Grid.square(n)


def problem_of(surface: SelfAffineSurface, grid: Grid, work: float) -> ContactProblem:
    assert surface.rms_height is not None
    wall = attraction_on_core("spline", work, RANGE * surface.rms_height, CORE)
    return ContactProblem(grid, wall, surface.build(grid), HalfSpace(mean="clamped"))


def energy_of(problem: ContactProblem) -> float:
    """U: all of the surface is displaced by the heights."""
    return problem.elastic_energy(np.zeros(problem.grid.shape))


def cycle(surface: SelfAffineSurface, grid: Grid, work: float) -> Cycle:
    """From full contact back until the tension cannot rise again."""
    began, problem = time.process_time(), problem_of(surface, grid, work)
    assert surface.rms_height is not None
    height, reach = surface.rms_height, RANGE * surface.rms_height
    settings = Settings(TOLERANCE * problem.traction_scale, warm_grids=0)
    way = Way(problem, settings, solver_of(problem, settings))
    states = way.back(way.pressed(1.1 * pressure_of_full_contact(problem)), STEP * height, FARTHEST * height)
    if states[0].area_rep < 1:
        raise RuntimeError("the cycle does not begin in full contact")
    finer = way.around(states, STEP / 2 * height)
    finest = way.around(finer, STEP / 4 * height)
    best = min((found[hardest(found)] for found in (states, finer, finest)), key=lambda state: state.load)
    every, before = [*states, *finer[1:], *finest[1:]], min(one[hardest(one)].load for one in (states, finer))
    m = problem.moments
    return Cycle(
        grid.shape[0], surface.hurst, surface.seed, surface.lambda_s, surface.lambda_L, m.rms_height, m.rms_slope,
        m.rms_curvature, energy_of(problem), reach, work, -best.load, best.mean_gap, best.area_rep,
        best.area_att, at_zero_load(states), 1 - before / best.load,
        snapped(states[: hardest(states) + 1], reach), len(every), sum(not state.status.ok for state in every),
        sum(state.solution.fft_pairs for state in every), time.process_time() - began,
    )  # fmt: skip


def planned(seed: int) -> list[tuple[SelfAffineSurface, Grid, float]]:
    """The cycles of a surface; those whose work single points would snap at are left out."""
    plan = []
    for hurst in HURST:
        middle, grid = surface_of(hurst, 8.0, seed)
        unit = energy_of(problem_of(middle, grid, 1e-4)) / middle.lambda_L
        for width in SIZES:
            surface, grid = surface_of(hurst, width, seed)
            assert surface.rms_height is not None
            for share in WORKS:
                work = share * unit * surface.lambda_L
                if work <= LIMIT * (RANGE * surface.rms_height) ** 2:
                    plan.append((surface, grid, work))
    return plan


def compute(seeds: Sequence[int], path: Path) -> None:
    """Cycles of these surfaces, each added to the file as it is found."""
    if not path.exists():
        path.write_text(",".join(field.name for field in fields(Cycle)) + "\n")
    done = read_csv(path)[["hurst", "seed", "lambda_s", "work"]].to_numpy()
    for seed in seeds:
        for surface, grid, work in planned(seed):
            key = (surface.hurst, seed, surface.lambda_s, work)
            if np.isclose(done, key, rtol=1e-4, atol=0).all(axis=1).any():
                continue
            found = cycle(surface, grid, work)
            with path.open("a") as file:
                file.write(",".join(f"{value:.6g}" for value in astuple(found)) + "\n")
            sys.stdout.write(f"{found}\n")
            sys.stdout.flush()


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", nargs="+", type=int, metavar="SEED", help="surfaces that are computed")
    parser.add_argument("--into", type=Path, default=MEASURED, help=f"folder of {FILE}")
    parser.add_argument("--figure", action="store_true", help="draw the figure as well")
    parser.add_argument("--part", type=float, default=PART, help="the exponents of λ_s in the work at another s")
    options = parser.parse_args(arguments)
    if options.run:
        compute(options.run, options.into / FILE)
        return
    rows = read_csv(options.into / FILE)
    text = tables(rows) if options.part == PART else "\n".join(exponent_lines(reduced(rows), options.part))
    sys.stdout.write(text + "\n")
    if options.figure:
        figure(rows, options.into / "law-pull-off")


if __name__ == "__main__":
    main()
