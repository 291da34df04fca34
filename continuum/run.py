"""A whole run: from a configuration, along its path, to a stored result.

After each point the result is rewritten with all that the next point starts from, so that a run that was
stopped, however, goes on where it was and ends as if nothing had happened, bit for bit.
"""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from continuum import store
from continuum.config import RunConfig, SelfAffineSurface, identity, resolved
from continuum.geometry import ATTRACTED, REPULSIVE, contact_map, measure
from continuum.grid import Real
from continuum.loading import Branch, State, follow, traction
from continuum.minimise import Solution, Status
from continuum.provenance import journal, provenance
from continuum.store import Attribute, Dataset
from continuum.system import System, build

__all__ = ["OutputError", "Progress", "Step", "Summary", "run"]


class OutputError(ValueError):
    """The result cannot be stored where it should be: the message says why and what helps."""


def _column(units: str, long_name: str) -> Any:
    return field(metadata={"units": units, "long_name": long_name})


@dataclass(frozen=True)
class Step:
    """One point of the path, as numbers.  Each is stored as a dataset over ``step``."""

    target: float = _column("a0", "given separation or mean gap")
    branch: str = _column("", "direction from which the point was reached")
    separation: float = _column("a0", "height of the wall's zero above the undeformed surface")
    mean_gap: float = _column("a0", "mean gap")
    area_rep: float = _column("1", "repulsive area A_rep/A0")
    area_att: float = _column("1", "attracted area A_att/A0")
    load: float = _column("E*", "load N/A0, compression positive")
    load_rep: float = _column("E*", "repulsive load N_rep/A0")
    load_att: float = _column("E*", "attractive load N_att/A0")
    elastic_energy: float = _column("E* a0", "elastic energy per area, without the mean mode")
    wall_energy: float = _column("E* a0", "interaction energy per area")
    smallest_gap: float = _column("a0", "smallest gap")
    residual: float = _column("E*", "root-mean-square residual traction")
    iterations: int = _column("1", "iterations of the solver")
    fft_pairs: float = _column("1", "forward and inverse Fourier transforms, halved")
    status: str = _column("", "how the solve ended")

    @property
    def converged(self) -> bool:
        """Whether the point is an equilibrium."""
        return Status[self.status].ok


@dataclass(frozen=True)
class Summary:
    """What a run came to."""

    path: Path
    identity: str
    steps: tuple[Step, ...]
    resumed: int
    """Points that were found finished."""
    seconds: float
    """Wall time of this call."""

    @property
    def converged(self) -> bool:
        """Whether every point is an equilibrium."""
        return all(step.converged for step in self.steps)


Progress = Callable[[Step, int, int], None]
"""Called after each point with what it is, how many are done, and how many there are."""


@dataclass
class _Result:
    """What is known so far.  The one mutable thing, private to :func:`run`."""

    steps: list[Step] = field(default_factory=list)
    repulsive: list[NDArray[np.uint8]] = field(default_factory=list)
    attracted: list[NDArray[np.uint8]] = field(default_factory=list)
    gaps: list[NDArray[np.float32]] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    good: list[State] = field(default_factory=list)
    """The last two converged states, which the next point starts from."""


def run(config: RunConfig, path: Path, *, force: bool = False, progress: Progress | None = None) -> Summary:
    """Follow the path of a configuration and store the result.

    Parameters
    ----------
    config : what to do.
    path : the result.  If it holds the same run finished, nothing is done; unfinished, it is continued.
    force : start anew, whatever the file holds.
    progress : see :data:`Progress`.

    Raises
    ------
    ConfigError
        If the configuration cannot be run.
    OutputError
        If the file holds another run, or cannot be written.
    """
    start = time.perf_counter()
    key = identity(config)
    system = build(config)
    targets = config.loading.path
    result, finished = (_Result(), False) if force else _stored(system, path, key)
    resumed = len(result.steps)
    if not finished:
        _prepare(path)
        since = time.perf_counter()
        states = follow(system.problem, config.loading.control, targets[resumed:], system.settings, result.good)
        for state in states:
            _append(result, system, state)
            result.seconds.append(time.perf_counter() - since)
            done = len(result.steps)
            _write(result, system, path, key, resumed)
            if progress is not None:
                progress(result.steps[-1], done, len(targets))
            since = time.perf_counter()
    return Summary(path, key, tuple(result.steps), resumed, time.perf_counter() - start)


def _prepare(path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        store.remove_stale(path)
    except OSError as error:
        msg = f"{path.parent}: no folder for results can be made there ({error})"
        raise OutputError(msg) from error
    if not os.access(path.parent, os.W_OK) or path.is_dir():
        msg = f"{path}: cannot be written there; choose another folder with --output"
        raise OutputError(msg)


def _append(result: _Result, system: System, state: State) -> None:
    problem, gap = system.problem, state.gap
    contact = measure(problem.grid, problem.wall, gap, traction(problem.wall, state.solution))
    fluctuation_q = problem.grid.forward(problem.heights - gap)
    fluctuation_q[0, 0] = 0.0
    elastic = 0.5 * problem.grid.inner_q(fluctuation_q, problem.elastic_traction_q(fluctuation_q))
    kind = contact_map(problem.wall, gap)
    solution = state.solution
    result.steps.append(
        Step(
            target=state.target,
            branch=state.branch,
            separation=state.separation,
            mean_gap=state.mean_gap,
            area_rep=contact.area_rep,
            area_att=contact.area_att,
            load=contact.load,
            load_rep=contact.load_rep,
            load_att=contact.load_att,
            elastic_energy=elastic,
            wall_energy=problem.grid.mean(problem.wall.energy(gap)),
            smallest_gap=contact.smallest_gap,
            residual=solution.residual,
            iterations=solution.iterations,
            fft_pairs=solution.fft_pairs,
            status=solution.status.name,
        )
    )
    result.repulsive.append(store.pack(kind == REPULSIVE))
    result.attracted.append(store.pack(kind == ATTRACTED))
    if system.config.output.fields:
        result.gaps.append(gap.astype(np.float32))
    if state.status.ok:
        result.good = [*result.good[-1:], state]


def _write(result: _Result, system: System, path: Path, key: str, resumed: int) -> None:
    config, grid = system.config, system.grid
    finished = len(result.steps) == len(config.loading.path)
    x, y = grid.positions
    datasets = {
        "step": Dataset(np.arange(len(result.steps)), ("step",), "1", "point of the path"),
        "x": Dataset(x[:, 0], ("x",), "a0", "position"),
        "y": Dataset(y[0], ("y",), "a0", "position"),
        "repulsive": _masks(result.repulsive, "repulsive contact"),
        "attracted": _masks(result.attracted, "attracted area"),
        "journal/seconds": Dataset(np.array(result.seconds), ("step",), "s", "wall time"),
    }
    for column in dataclasses.fields(Step):
        values = np.array([getattr(step, column.name) for step in result.steps])
        datasets[column.name] = Dataset(values, ("step",), **column.metadata)
    if config.output.fields:
        heights = system.problem.heights.astype(np.float32)
        datasets["heights"] = Dataset(heights, ("x", "y"), "a0", "height of the rigid wall")
        datasets["gap"] = Dataset(np.array(result.gaps), ("step", "x", "y"), "a0", "gap")
    if not finished and result.good:
        good = result.good
        datasets["restart/gap"] = Dataset(
            np.array([s.gap for s in good]), ("restart_point", "x", "y"), "a0", "gap of the last converged points"
        )
        datasets["restart/target"] = Dataset(np.array([s.target for s in good]), ("restart_point",), "a0", "target")
        datasets["restart/branch"] = Dataset(np.array([s.branch for s in good]), ("restart_point",), "", "branch")
    try:
        store.write(path, datasets, {**_attributes(system, key, finished), "journal/resumed_at": resumed})
    except store.StoreError as error:
        raise OutputError(str(error)) from error


def _masks(masks: list[NDArray[np.uint8]], name: str) -> Dataset:
    what = f"{name}, eight points along y in a byte, first in its highest bit"
    return Dataset(np.array(masks), ("step", "x", "y_byte"), "1", what)


def _attributes(system: System, key: str, finished: bool) -> dict[str, Attribute]:
    config, wall = system.config, system.problem.wall
    attributes: dict[str, Attribute] = {
        "schema": config.result_schema,
        "schema_version": config.result_version,
        "identity": key,
        "finished": finished,
        "config": config.source.text if config.source else "",
        "config_resolved": resolved(config),
        "control": config.loading.control,
        "tolerance": system.settings.tolerance,
        "wall_zero_gap": wall.zero_gap,
        "wall_range": wall.range,
        "work_of_adhesion": wall.work_of_adhesion,
        **{f"realised_{name}": value for name, value in system.realised._asdict().items()},
        **provenance(),
        **journal(),
    }
    if system.expected is not None:
        attributes |= {f"expected_{name}": value for name, value in system.expected._asdict().items()}
    if isinstance(config.surface, SelfAffineSurface):
        attributes["seed"] = config.surface.seed
    return attributes


def _stored(system: System, path: Path, key: str) -> tuple[_Result, bool]:
    """What a file holds of this run, and whether that is all of it."""
    config = system.config
    if not path.exists():
        return _Result(), False
    try:
        file = store.read(path, config.result_schema, config.result_version)
    except store.StoreError as error:
        msg = f"{error}\n    It is in the way of the result: move it, or start anew with --force"
        raise OutputError(msg) from error
    if file.attributes.get("identity") != key:
        msg = (
            f"{path}: holds another run (other physics, solver settings or input data)\n"
            "    Choose another folder with --output, or start anew with --force"
        )
        raise OutputError(msg)
    if config.output.fields and "gap" not in file.datasets:
        return _Result(), False  # the same numbers again, this time with fields
    finished = bool(file.attributes.get("finished"))
    names = [column.name for column in dataclasses.fields(Step)]
    rows = zip(*(file[name].tolist() for name in names), strict=True)
    result = _Result(
        steps=[Step(**dict(zip(names, row, strict=True))) for row in rows],
        repulsive=list(file["repulsive"]),
        attracted=list(file["attracted"]),
        gaps=list(file["gap"]) if config.output.fields else [],
        seconds=file["journal/seconds"].tolist(),
    )
    if "restart/gap" in file.datasets:
        result.good = [
            _restored(system, gap, target, cast("Branch", str(branch)))
            for gap, target, branch in zip(
                file["restart/gap"], file["restart/target"], file["restart/branch"], strict=True
            )
        ]
    return result, finished


def _restored(system: System, gap: Real, target: float, branch: Branch) -> State:
    """A converged state as far as the next point needs it: target, branch, gap and status."""
    solution = Solution(gap, Status.CONVERGED, 0.0, 0)
    return State(float(target), branch, np.nan, system.grid.mean(gap), np.nan, solution)
