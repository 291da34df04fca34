"""Run a configuration along its path to a stored result.

After a point, at most once a second, the result is rewritten with all that the next point starts from, so that an
interrupted run continues to a bitwise identical result.
"""

import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from continuum.inputs.errors import InputError, OutputError
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.shared_grid import own_rows
from continuum.path.equilibrium import solver_of
from continuum.path.loading import follow
from continuum.path.state import Branch, Outcome, PathState, gone
from continuum.path.threshold_search import afresh, bracket_threshold
from continuum.solve.backend import back_end
from continuum.solve.processes import in_company, sharing
from continuum.solve.solver import Solver
from continuum.store import datasets as store
from continuum.store.datasets import Attribute, Dataset
from continuum.store.hdf5 import StoreError, understood
from continuum.store.identity import differences, identity, resolved
from continuum.store.output import distinct, reserved
from continuum.store.provenance import journal, provenance
from continuum.store.runs.build import RunSetup, build
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point, Record, maps_in
from continuum.store.runs.result import Result
from continuum.store.runs.reuse import SMALL, Growth, KeptTrials, as_begun, contact_identity, growth_of, stored_state

_RUNS = itertools.count()
"""Number of runs that this process has begun: the first one loads or compiles the solver."""
_OF_KNOTS = {"gap": ("a0", "gap at the knots of the wall law"), "traction": ("E*", "traction at the knots")}
Progress = Callable[[Point, int, int], None]
"""Called after each point with the point, the number of finished points, and the number of all."""
Made = Callable[[RunSetup, Record], Dataset]
"""Function that makes a dataset of a finished path."""


class _Begun(NamedTuple):
    """How a process began a run."""

    resumed: int
    """Points that were stored before."""
    at: float
    first: bool
    """Whether it is the first run of its process."""


def follow_run(
    config: RunConfig,
    path: Path,
    *,
    force: bool = False,
    progress: Progress | None = None,
    warn: Callable[[Sequence[str]], None] | None = None,
    every: float = 1.0,
    growth: Growth | None = None,
    added: Mapping[str, Made] = {},
) -> Result:
    """Follow the path of a configuration and store the result.

    Parameters
    ----------
    config : what to do.
    path : file of the result.  A finished run of the same input is returned, an unfinished one is continued.
    force : replace a result of another run.
    progress : see :data:`Progress`.
    warn : called with warnings about resolution before the first point; they are also stored.
    every : seconds between two writes: a killed process loses the points since the last one, an interrupted one none.
    growth : a stored path of the same contact, whose points are reused if the file has none yet.
    added : what is stored beside the finished path, by the names of the datasets.

    Raises ConfigError if the configuration cannot be run; InputError if this machine lacks the device of the solver;
    OutputError if the file is something else, an input, locked by another process, or cannot be written.
    """
    start = time.perf_counter()
    config, until = (config, "") if force else as_begun(config, path)
    key = identity(config)
    distinct(path, config.files)
    world = sharing(config.solver.shards)
    if world.size > 1 and config.loading.threshold is not None:
        raise InputError("a search for thresholds divides its points over the devices of one process only")
    divided = not added and _may_be_divided(config)
    parts = maps_in(own_rows(config.grid.n[0], world.rank, world.size)) if divided else {}
    stored = partial(_stored, config, path, key, growth, added, parts, force=force)
    record, finished = stored()
    with in_company(world):
        solver = config.solver
        company = back_end(solver.device, solver.shards).company() if divided and not finished else None
        system = build(config, company)
    said = list(system.warnings)
    if record.grown_from and not finished:
        said.append(f"{path}: continues with {len(record.points)} stored points of another path")
    if until:
        said.append(f"{path}: was begun with other defaults, which held until {until}, and goes on with them")
    if warn is not None:
        warn(said)
    if finished:
        return replace(Result.read(path), resumed=len(record.points), seconds=time.perf_counter() - start)
    with reserved(path) if world.first else nullcontext():
        # Read again, now that no other process writes it.
        record = replace(stored()[0], company=company)
        resumed = len(record.points)
        trials = KeptTrials(path.with_suffix(".trials.json"), key, every)
        if force:
            trials.drop()
        try:
            begun = _Begun(resumed, start, next(_RUNS) == 0)
            write = partial(_write, system, path, key, begun, added, world.first)
            with in_company(world):
                # Several processes have to write at the same time, and none can once another is gone.
                often = every if world.size == 1 else 0.0
                said_of_it = _follow(system, record, growth, write, often, progress, trials)
        except BaseException:
            trials.save()
            raise
        trials.drop()
    took = time.perf_counter() - start
    return Result.of(path, said_of_it, record.points, record.events, system.problem.wall.knots, resumed, took)


def _follow(
    system: RunSetup,
    record: Record,
    growth: Growth | None,
    write: Callable[[Record], dict[str, Attribute]],
    every: float,
    progress: Progress | None,
    trials: KeptTrials,
) -> dict[str, Attribute]:
    """Compute the remaining points and write all; returns the attributes of the finished file.

    An interruption loses no point that can be written.
    """
    total, since = system.config.loading.points, time.perf_counter()
    written, unwritten = since, None
    solver = solver_of(system.problem, system.settings)
    try:
        for problem, state in states_of(system, record, solver, growth, trials):
            record.append(problem, state, solver)
            record.seconds.append((state.solution.seconds, time.perf_counter() - since))
            done = len(record.points)
            del state  # its fields are those of the record, or no longer needed
            if done < total and time.perf_counter() - written >= every:
                write(record)
                written, unwritten = time.perf_counter(), None
            else:  # at an interruption the record may already belong to the next point
                unwritten = done, list(record.good)
            if progress is not None:
                progress(record.points[-1], done, total)
            since = time.perf_counter()
        del solver  # what is added needs memory, too
        return write(record)
    except (Exception, KeyboardInterrupt, SystemExit) as error:
        # Processes that share the points write together: one, interrupted by itself, would wait for the others.
        # After an OutputError, a second attempt to write would fail as the first.
        alone = record.company is None or record.company.size == 1
        if unwritten is not None and alone and not isinstance(error, OutputError):
            write(record.beginning(*unwritten))
        raise


def states_of(
    system: RunSetup,
    record: Record,
    solver: Solver,
    growth: Growth | None = None,
    trials: KeptTrials | None = None,
) -> Iterator[tuple[ContactProblem, PathState]]:
    """The remaining points of the path, each with its contact; a search for a threshold goes on from its trials."""
    loading, done = system.config.loading, len(record.points)
    if loading.threshold is not None:
        for _, targets, search in loading.stretches:
            for area in targets[done:]:
                yield bracket_threshold(
                    system.problem, system.config.wall.at_work, area, system.settings, search, loading.threshold,
                    solver, kept=afresh if trials is None else partial(trials.at, area),
                )  # fmt: skip
            done = max(0, done - len(targets))
        return
    for control, targets, search in loading.stretches:
        if done < len(targets):
            if done > 0 and (last := record.points[-1]).status == Outcome.PULLED_OFF.name:
                # The next point starts from its separation.
                record.good.append(gone(system.problem, last.target, cast("Branch", last.branch)))
            left = targets[done:]
            for some in [(target,) for target in left] if growth is not None and growth.refined else [left]:
                step = len(record.points)
                if growth is not None and step < growth.refined and (known := stored_state(growth.source, step)):
                    record.good[:] = [known]  # solved to a finer tolerance, from its stored state
                for state in follow(system.problem, control, some, system.settings, record.good, search, solver):
                    yield system.problem.dented(state.imprint_before), state
        done = max(0, done - len(targets))


def _write(
    system: RunSetup, path: Path, key: str, begun: _Begun, added: Mapping[str, Made], writes: bool, record: Record
) -> dict[str, Attribute]:
    """Write what there is, unless another process ``writes`` it; returns the attributes of the file."""
    config, grid = system.config, system.problem.grid
    finished = len(record.points) == config.loading.points
    kept = config.output.last_state
    if kept is None:  # the only state of a small grid takes longer to store than to find again
        kept = grid.size <= 1024**2 and (len(record.points) > 1 or grid.size > SMALL)
    datasets = {
        **{name: Dataset(at, (name,), "a0", f"position along {name}") for name, at in positions_of(system).items()},
        # An unfinished path goes on from its last state, a finished one only if it gets further targets.
        **record.datasets(restart=not finished or kept),
    }
    for name, values in system.problem.wall.knots.items():
        datasets[f"wall/{name}"] = Dataset(values, ("wall_knot",), *_OF_KNOTS[name])
    if config.output.fields:
        heights = system.problem.heights.astype(np.float32)
        datasets["heights"] = Dataset(record.rows(heights), ("x", "y"), "a0", "height of the rigid wall")
    if finished:
        datasets |= {name: make(system, record) for name, make in added.items()}
    before = sum(whole for _, whole in record.seconds[: begun.resumed])
    journalled: dict[str, Attribute] = {
        "journal/resumed_at": begun.resumed,
        "journal/total_seconds": before + time.perf_counter() - begun.at,
        "journal/first_of_process": begun.first,
    }
    said: dict[str, Attribute] = {
        "schema": config.result_schema,
        "schema_version": config.result_version,
        "finished": finished,
        "config": config.source.text if config.source else "",
        "config_resolved": resolved(config),
        "warnings": "\n".join(system.warnings),
        **provenance(),
        **journal(),
        **({"journal/grown_from": record.grown_from} if record.grown_from else {}),
    }
    if (device := system.settings.device) != "cpu":  # whose kinds all find the same
        shards = system.settings.shards
        said |= {"device": device, "journal/machine": back_end(device, shards).machine(), "journal/shards": shards}
    said |= {**attributes_of(system, key), **record.attributes(), **journalled}
    if writes:
        store.write(path, datasets, said)
    else:
        store.hand_over(datasets)
    return said


def positions_of(system: RunSetup) -> dict[str, Real]:
    """Positions of the points along each axis, in a0, by the name of the axis."""
    grid = system.problem.grid
    x, y = Grid(grid.shape, grid.lengths).positions
    return {"x": x[:, 0], "y": y[0]}


def attributes_of(system: RunSetup, key: str) -> dict[str, Attribute]:
    """Attributes of a stored run that follow from its input; ``key`` is its identity."""
    config, wall = system.config, system.problem.wall
    attributes: dict[str, Attribute] = {
        "identity": key,
        "contact_identity": contact_identity(config),
        "control": config.loading.control,
        "event_resolution": config.loading.event_resolution or 0.0,
        "event_threshold": config.loading.event_threshold,
        "tolerance": system.settings.tolerance,
        "wall_zero_gap": wall.zero_gap,
        "wall_range": wall.range,
        "work_of_adhesion": wall.work_of_adhesion,
        **{f"realised_{name}": value for name, value in system.problem.moments._asdict().items()},
    }
    if system.expected is not None:
        attributes |= {f"expected_{name}": value for name, value in system.expected._asdict().items()}
    return {**attributes, **config.surface.attributes}


def _may_be_divided(config: RunConfig) -> bool:
    """Whether each process may hold its slabs only: of imprints, of a stability and of a counterface it has no part."""
    wall, solver = config.wall, config.solver
    whole = config.counterface is not None or solver.stability or config.loading.threshold is not None
    return solver.shards > 1 and config.substrate.repeats and bool(np.isinf(wall.hardness)) and not whole


def _stored(
    config: RunConfig,
    path: Path,
    key: str,
    growth: Growth | None,
    added: Mapping[str, Made],
    parts: Mapping[str, Any],
    *,
    force: bool,
) -> tuple[Record, bool]:
    """The stored part of this run, or of another path that it continues, and whether it is complete."""
    here = None if force else growth_of(config, path)
    if here is not None and here.identity != key and here.whole:
        if not here.kept:  # the one state of a small grid, which is sooner found again than read
            return Record(config.output.fields), False
        growth = here
    elif path.exists():
        growth = None
    if growth is not None and growth.kept:
        stored = store.read_datasets(growth.source, config.result_schema, config.result_version, parts=parts)
        with understood(growth.source):
            whole = Record.restored(stored, fields=config.output.fields)
        # What the next point starts from is stored of the last point only.
        good = whole.good if growth.kept == len(whole.points) else []
        return replace(whole.beginning(growth.kept, good), grown_from=growth.identity), False
    other = partial(differences, config)
    file = store.earlier(
        path, config.result_schema, config.result_version, key, force=force, differences=other, parts=parts
    )
    if file is None:
        return Record(config.output.fields, grown_from=growth.identity if growth is not None else ""), False
    if config.output.fields and "gap" not in file.datasets:
        return Record(config.output.fields), False  # computed again, to store the fields
    try:
        with understood(path):
            record = Record.restored(file, fields=config.output.fields)
    except StoreError as error:
        raise store.refused(error) from error
    return record, bool(file.attributes.get("finished")) and added.keys() <= file.datasets.keys()
