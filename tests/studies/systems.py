"""Self-affine systems followed on approach to given repulsive areas.

Results are kept line by line, one system each, so that a study that was killed goes on.
"""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from continuum.measure.contact import REPULSIVE, contact_map, measure
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine, moments
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import Search, follow
from continuum.solve.smooth import Settings

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
    def key(self) -> str:
        """Physics of the system; the number of threads is not."""
        return json.dumps({k: v for k, v in asdict(self).items() if k != "threads"})


def followed(system: System) -> dict[str, Any]:
    """Approach to each area; the states as numbers, with status and work."""
    began = time.perf_counter()
    grid = Grid.square(system.n, threads=system.threads)
    spectrum = SelfAffine(system.hurst, system.rms_slope, system.lambda_s, system.n / 2)
    heights = spectrum.synthesise(grid, np.random.default_rng(system.seed))
    heights.flags.writeable = False
    wall = LennardJonesSpline(adhesion_length=system.adhesion_length)
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    found = moments(grid, heights)
    states = []
    settings = Settings(1e-6 * system.rms_slope)
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


def each(systems: Iterable[System], kept: Path, workers: int) -> list[dict[str, Any]]:
    """Results of all systems, in order; those that are kept already come from the file."""
    wanted = {system.key: system for system in systems}
    kept.parent.mkdir(parents=True, exist_ok=True)
    done: dict[str, dict[str, Any]] = {}
    if kept.exists():
        for line in kept.read_text().splitlines():
            try:
                result = json.loads(line)
            except json.JSONDecodeError:
                continue  # the line that was being written when the study was killed
            done[result["system"]] = result
    missing = [system for key, system in wanted.items() if key not in done]
    with ProcessPoolExecutor(workers) as pool:
        tasks = [pool.submit(followed, system) for system in missing]
        for count, task in enumerate(as_completed(tasks), 1):
            result = task.result()
            done[result["system"]] = result
            with kept.open("a") as file:
                file.write(json.dumps(result) + "\n")
            ended = ", ".join(f"{s['status'].lower()} {s['pairs'] + s['search_pairs']:.0f}" for s in result["states"])
            log.info("%d/%d  %s  %.0f s  [%s pairs]", count, len(missing), result["system"], result["seconds"], ended)
    return [done[key] for key in wanted]
