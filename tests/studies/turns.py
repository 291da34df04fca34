"""The work of adhesion at which a surface turns sticky, by both observables: what ``docs/dispute.md`` is made of.

The rms height, the roll-off and the law of the wall are held while the shortest wavelength λ_s and the range of
attraction change.  Elasticity is linear and slopes small: a wall stretched by s in height, with a range s times as long
and s² times the work of adhesion, has the same contact.  So the ratios below are all that counts.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import logging
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from continuum.model.attraction import attraction_on_core
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine, moments
from continuum.path.loading import follow, solve
from continuum.path.state import Outcome, Search, State
from continuum.runs.engine import Task, run_tasks
from continuum.solve.solution import Settings
from continuum.sticky.simulate import CORE_DEPTH, CORE_STIFFNESS, TOLERANCE
from continuum.theory import paper, rough

log = logging.getLogger("studies")

HURST = (0.3, 0.6, 0.8)
CUTS = (4.0, 8.0, 16.0, 32.0)
RANGES = (0.15, 0.35, 0.8, 2.0)
"""Effective range of the attraction, in h_rms."""
WORKS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Of the pull-off, in units of the work at which the paper's criterion turns for the middle λ_s of each row."""
AREA = 0.01
CLOSE = 1.06
"""Ratio of the works between which the turn lies, and of attraction to repulsion, that counts as found."""
RESOLVED = 2.0
"""Wavelength in pixels above which two flats snap: shorter, and the grid holds fronts of contact by itself."""
PEAK = 0.1
"""Pressure from which the contact is pulled off, in E* h_rms/λ_L."""


@dataclass(frozen=True)
class Turn:
    """A surface of n x n points one unit apart, λ_L = n/2, and the range of its attraction over its rms height."""

    n: int
    hurst: float
    lambda_s: float
    range: float
    seed: int
    observable: str
    """"load" at 1 % area, or "pull-off"."""

    @property
    def rms_height(self) -> float:
        """The same part of λ_L on all grids."""
        return self.n / 256

    @property
    def key(self) -> str:
        """All that the result depends on."""
        return json.dumps(asdict(self))

    def task(self, folder: Path) -> Task:
        """What the engine is given."""
        name = hashlib.sha256(self.key.encode()).hexdigest()[:16]
        return Task(folder / f"{name}.json", self.key, self.n**2)

    def heights(self) -> tuple[Grid, Any]:
        """The wall; waves longer than λ_s are those of the same seed at all λ_s."""
        grid = Grid.square(self.n)
        spectrum = SelfAffine(self.hurst, 0.1, self.lambda_s, self.n / 2, rescale=False)
        heights = spectrum.synthesise(grid, np.random.default_rng(self.seed))
        return grid, heights * (self.rms_height / heights.std())

    def problem(self, work: float) -> tuple[ContactProblem, float]:
        """Of a work of adhesion, lengths in units of the range; and the residual allowed."""
        grid, heights = self.heights()
        unit = self.range * self.rms_height
        scaled = Grid(grid.shape, (grid.lengths[0] / unit, grid.lengths[1] / unit))
        pixel = max(scaled.spacing)
        wall = attraction_on_core("spline", work / unit, 1.0, CORE_STIFFNESS / pixel, CORE_DEPTH * pixel)
        slope = moments(grid, heights).rms_slope
        return ContactProblem(scaled, wall, -heights / unit, HalfSpace("clamped")), TOLERANCE * slope


def guess(turn: Turn) -> float:
    """Work at which the paper's criterion turns, E* = 1."""
    grid, heights = turn.heights()
    _, slope, curvature = moments(grid, heights)
    return paper.onset(slope, paper.height_change(slope, curvature), 1.0, turn.range * turn.rms_height)


def resolved(problem: ContactProblem) -> float:
    """Wavelength above which flats snap, in pixels."""
    return paper.snap_in_wavelength(problem.wall.largest_softening) / max(problem.grid.spacing)


def at_one_percent(turn: Turn, work: float) -> dict[str, Any]:
    """Attraction over repulsion at 1 % repulsive area on approach, or beyond the jump over it."""
    problem, tolerance = turn.problem(work)
    row: dict[str, Any] = {"work": work, "snap": resolved(problem)}
    state = solve(problem, "repulsive-area", AREA, Settings(tolerance), branch="approach")
    jumped = state.outcome is Outcome.JUMPED_OVER and state.beyond is not None
    if jumped and state.beyond is not None:
        state = state.beyond
    row |= {"jumped": jumped, "status": state.status.name}
    return row | asdict(state.totals) if state.status.ok else row


def load_turn(turn: Turn) -> list[dict[str, Any]]:
    """Trials around the work at which attraction and repulsion cancel at 1 % area."""
    low, high, work, trials = 0.0, np.inf, 0.5 * guess(turn), []
    for _ in range(9):
        row = at_one_percent(turn, work)
        trials.append(row)
        if "load" not in row or not row["load_rep"] or row["snap"] < RESOLVED:
            break
        ratio = row["load_att"] / row["load_rep"]
        low, high = (work, high) if ratio < 1 else (low, work)
        if high / max(low, 1e-300) < CLOSE or (not row["jumped"] and 1 / CLOSE < ratio < CLOSE):
            break
        # Attraction is nearly proportional to w, as the gap hardly changes.
        work = float(np.clip(work / ratio, work / 3, work * 3))
        if not low * 1.01 < work < high / 1.01:
            work = float(np.sqrt(low * high))
    return trials


def retraction(turn: Turn, work: float) -> dict[str, Any]:
    """Largest tension on the way back from a pressure that is the same for all surfaces, and the loop's areas."""
    problem, tolerance = turn.problem(work)
    unit = turn.range * turn.rms_height
    peak = PEAK * turn.rms_height / (turn.n / 2)
    row: dict[str, Any] = {"work": work, "snap": resolved(problem), "peak": peak, "curve": []}
    if row["snap"] < RESOLVED:
        return row
    previous: list[State] = []
    for state in follow(problem, "mean-pressure", [peak], Settings(tolerance), previous):
        row["status"] = state.status.name
        if not state.status.ok:
            return row
    step, lowest = 0.06 * turn.rms_height / unit, np.inf
    gaps: Iterator[float] = (previous[-1].mean_gap + i * step for i in itertools.count(1))
    for state in follow(problem, "mean-gap", itertools.islice(gaps, 200), Settings(tolerance), previous, Search()):
        row["status"] = state.status.name
        if not state.status.ok:
            break
        row["curve"].append((state.mean_gap * unit, state.load, state.totals.area_rep))
        lowest = min(lowest, state.load)
        if state.totals.area_rep == 0 or (lowest < 0 and state.load > 0.5 * lowest):
            break
    return row | {"tension": -lowest}


def measured(turn: Turn) -> dict[str, Any]:
    """A surface, its moments, and the trials on it."""
    grid, heights = turn.heights()
    height, slope, curvature = moments(grid, heights)
    power = np.abs(grid.forward(heights)) ** 2 * grid.mode_weights
    found = {
        **asdict(turn),
        "rms_height": height,
        "rms_slope": slope,
        "rms_curvature": curvature,
        "lambda_L": turn.n / 2,
        "length": turn.range * turn.rms_height,
        "conformal_energy": rough.conformal_energy(grid.wavenumber, power),
        "guess": guess(turn),
    }
    if turn.observable == "load":
        return found | {"trials": load_turn(turn)}
    middle = guess(Turn(turn.n, turn.hurst, CUTS[1], turn.range, turn.seed, "load"))
    return found | {"trials": [retraction(turn, factor * middle) for factor in WORKS]}


def _write(turns: dict[str, Turn], task: Task) -> None:
    temporary = task.path.with_suffix(".tmp")
    temporary.write_text(json.dumps(measured(turns[task.path.name])))
    temporary.replace(task.path)


def each(turns: list[Turn], folder: Path, workers: int) -> list[dict[str, Any]]:
    """Results of all, in order; those whose file is there already are not run again."""
    folder.mkdir(parents=True, exist_ok=True)
    tasks = {turn.task(folder).path: turn for turn in turns}
    work = partial(_write, {path.name: turn for path, turn in tasks.items()})
    todo = [turn.task(folder) for turn in turns]
    for count, ended in enumerate(run_tasks(todo, work, lambda task: task.path.exists(), workers=workers), 1):
        if ended.seconds or ended.reason:
            log.info("%d/%d  %s  %.0f s  %s", count, len(todo), ended.task.label, ended.seconds, ended.reason)
    return [json.loads(path.read_text()) for path in tasks if path.exists()]


def plan(n: int, seeds: int, ranges: tuple[float, ...], observable: str) -> list[Turn]:
    """All surfaces of one grid."""
    return [
        Turn(n, hurst, cut, reach, seed, observable)
        for seed in range(1, seeds + 1)
        for reach in ranges
        for hurst in HURST
        for cut in CUTS
    ]


def main() -> None:
    """Compute what is missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=256)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--ranges", type=float, nargs="+", default=RANGES, help="in h_rms")
    parser.add_argument("--observable", choices=("load", "pull-off"), default="load")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--kept", type=Path, default=Path("results/turns"), help="folder of what is done so far")
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    each(plan(given.n, given.seeds, tuple(given.ranges), given.observable), given.kept, given.workers)


if __name__ == "__main__":
    main()
