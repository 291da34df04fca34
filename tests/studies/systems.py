"""Self-affine systems followed on approach to given repulsive areas: a file each, by the engine."""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from continuum.measure.contact import REPULSIVE, contact_map, measure
from continuum.model.surface import moments
from continuum.path.loading import follow
from continuum.path.state import Search
from continuum.runs.engine import Task, run_tasks
from continuum.solve.solution import Settings
from tests.problems import Rough

__all__ = ["System", "each", "followed"]

log = logging.getLogger("studies")


@dataclass(frozen=True)
class System:
    """A self-affine wall of the paper on an incompressible half-space, one point for each atom of the surface."""

    n: int
    hurst: float
    rms_slope: float
    lambda_s: float
    adhesion_length: float
    seed: int
    areas: tuple[float, ...]
    """Fractions of A0, increasing."""
    threads: int = 1

    @property
    def rough(self) -> Rough:
        """The wall."""
        return Rough(self.n, self.adhesion_length, self.lambda_s, self.seed, self.rms_slope, self.hurst)

    @property
    def key(self) -> str:
        """Physics of the system; the number of threads is not."""
        return json.dumps({k: v for k, v in asdict(self).items() if k != "threads"})

    def task(self, folder: Path) -> Task:
        """What the engine is given."""
        name = hashlib.sha256(self.key.encode()).hexdigest()[:16]
        label = f"H = {self.hurst}, h' = {self.rms_slope}, lambda_s = {self.lambda_s:g}, l_a = {self.adhesion_length:g}"
        return Task(folder / f"{name}.json", f"{label}, seed {self.seed}", self.n**2 * (1 + 20 * self.adhesion_length))


def followed(system: System) -> dict[str, Any]:
    """Approach to each area; the states as numbers, with status and work."""
    began = time.perf_counter()
    problem = system.rough.problem()
    grid, wall, found = problem.grid, problem.wall, moments(problem.grid, problem.heights)
    states = []
    settings = Settings(1e-6 * system.rms_slope, threads=system.threads)
    for state in follow(problem, "repulsive-area", system.areas, settings, search=Search(area_tolerance=0.01)):
        row: dict[str, Any] = {"target": state.target, "status": state.status.name, "branch": state.branch}
        if state.status.ok:
            inside = contact_map(wall, state.gap) == REPULSIVE
            row |= asdict(state.totals) | measure(grid, state.totals, inside, found.rms_slope).numbers()
            row |= {"mean_gap": state.mean_gap, "residual": state.solution.residual}
        row |= {
            "pairs": state.solution.fft_pairs,
            "search_pairs": state.search_pairs,
            "solves": state.search_solves + 1,
        }
        states.append(row)
    return {
        "system": system.key,
        **{k: v for k, v in asdict(system).items() if k not in ("areas", "threads")},
        "rms_slope_found": found.rms_slope,
        "rms_curvature": found.rms_curvature,
        "rms_height": found.rms_height,
        "range": wall.range,
        "states": states,
        "seconds": time.perf_counter() - began,
    }


def each(systems: Iterable[System], folder: Path, workers: int) -> list[dict[str, Any]]:
    """Results of all systems, in order; those whose file is there already are not run again."""
    folder.mkdir(parents=True, exist_ok=True)
    tasks = {system.task(folder).path: system for system in systems}
    work = partial(_write, {path.name: system for path, system in tasks.items()})
    todo = [system.task(folder) for system in tasks.values()]
    for count, ended in enumerate(run_tasks(todo, work, lambda task: task.path.exists(), workers=workers), 1):
        log.info("%d/%d  %s  %.0f s  %s", count, len(todo), ended.task.label, ended.seconds, ended.reason)
    return [json.loads(path.read_text()) for path in tasks]


def _write(systems: dict[str, System], task: Task) -> None:
    """One system, in a process of its own."""
    temporary = task.path.with_suffix(".tmp")
    temporary.write_text(json.dumps(followed(systems[task.path.name])))
    temporary.replace(task.path)
