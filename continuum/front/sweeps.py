"""The functions behind ``continuum sweep``, one for each of its actions.

They take the folder of a sweep, or its input, and never an object of an earlier call, as progress is asked for days
later, from another process or machine.
"""

import io
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import continuum.store.sweeps.collect
from continuum.front.runs import core_hours, costs_of, tasks_of
from continuum.inputs.arguments import ArgumentError, count, file_name, flag, function, hinted, instance, number, pair
from continuum.inputs.errors import InputError
from continuum.inputs.reading import InputFile, settings_of
from continuum.inputs.toml import text_of
from continuum.solve.backend import back_end
from continuum.solve.processes import sharing
from continuum.store import datasets as store
from continuum.store.datasets import Dataset
from continuum.store.granted import granted_memory
from continuum.store.output import LockedError, folder, remove_stale, save, whole
from continuum.store.provenance import provenance
from continuum.store.runs.config import memory_on_device
from continuum.store.sheet import write_csv
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.cluster import Allocation, SweepTask, slurm_script
from continuum.store.sweeps.collect import PointTable
from continuum.store.sweeps.collect import SweepRun as SweepRun
from continuum.store.sweeps.columns import ColumnFunction, functions_by_name
from continuum.store.sweeps.crossings import Crossing, crossings_of, crossings_sheet, done_before, solve_task
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.sweep import SystemTask, begin, record, record_death
from continuum.store.sweeps.workers import Message, Task, TaskResult, check_workers, require_scheduler, run_tasks

_NAME = r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}"
After = Callable[[TaskResult, int, int], None]
"""Called after each system with its result, the number of finished systems, and the number of all."""


@hinted
def sweep(
    file: InputFile,
    output: str | Path = "results",
    *,
    name: str | None = None,
    settings: Mapping[str, Any] | None = None,
    reduced: bool = False,
    workers: int | None = None,
    threads: int = 1,
    device: str | None = None,
    memory: float | None = None,
    columns: Mapping[str, ColumnFunction] | None = None,
    retry: bool = False,
    shard: tuple[int, int] = (1, 1),
    scheduler_file: str | Path | None = None,
    begun: Callable[[list[SystemTask]], None] | None = None,
    progress: After | None = None,
    meanwhile: Callable[[Task, float], None] | None = None,
    warn: Callable[[Sequence[str]], None] | None = None,
) -> SweepRun:
    """Run the missing systems of a sweep: one path each, stored in a file of its own.

    A sweep is an input with a table [sweep]: axes over any of its keys, along one of which a crossing may be searched
    for.  After an interruption the same call runs what is missing.

    Parameters
    ----------
    file : input of a run with a table [sweep]; ``inputs/sweep/...`` finds those that come with the package; in Python
        also a dictionary of its tables, which is named "sweep" unless it gets a name.
    output : folder in which the folder of the sweep is made, named after the input.
    name : name of the folder of the sweep, instead of that of the input.
    settings : values for keys of the input; a list for a key on an axis.
    reduced : use the smaller sizes of [sweep.reduced]: minutes instead of days.
    workers : number of processes; one by default, or one for each GPU; fewer if memory does not suffice.  Several may
        share a GPU if its memory holds the largest system of each.  With 0 the folder is made and nothing is run:
        another scheduler can run the ``jobs`` of the result.
    threads : threads of the solver of each system.
    device : device of the solver, instead of ``[solver] device`` of the input: cpu, cuda (a GPU) or a library.
    memory : memory to use, in bytes; all of this machine if None.
    columns : functions by the names of columns of your own, beside those of ``[sweep.columns]``: each takes the
        stored :class:`continuum.Result` of a system, in the worker, and returns a number for each point of its path, or
        one for all; they are in the table, its means, and the searches.
    retry : run failed systems again.
    shard : (i, n) runs the i-th of n parts, for jobs of an array.
    scheduler_file : scheduler file of a Dask cluster that runs the systems, instead of processes on this machine.
    begun : called with the systems of this call before the first starts.
    progress : see :data:`After`.
    meanwhile : called after each point of a system with the finished share of its path, from 0 to 1.
    warn : called with differences from the sweep stored in the folder before the first system, and when a process has
        died.

    Raises
    ------
    ConfigError, OutputError, ClusterError
        If the input cannot be run, results cannot be stored (the folder may hold another sweep, or files of your own),
        or there is no such cluster.
    ArgumentError, InputError
        If an argument is not allowed; or this machine has not the device, or its GPUs not the memory for the workers.

    Examples
    --------
    >>> import continuum as c
    >>> file = {
    ...     "grid": {"n": 64},
    ...     "surface": {"kind": "sine", "amplitude": 0.5, "waves": [1, 1]},
    ...     "wall": {"law": "hard"},
    ...     "substrate": {"response": "half-space", "mean": "clamped"},
    ...     "loading": {"control": "mean-pressure", "targets": [0.002, 0.004]},
    ...     "sweep": {"axes": {"surface.amplitude": [0.4, 0.5]}},
    ... }
    >>> done = c.sweep(file, name="waves", workers=1)
    >>> done.total, done.ok
    (2, True)
    >>> done.collect().to_pandas()[["surface.amplitude", "step", "area_rep"]].round(3)
       surface.amplitude  step  area_rep
    0                0.4   0.0     0.172
    1                0.4   1.0     0.266
    2                0.5   0.0     0.172
    3                0.5   1.0     0.234
    """
    for argument, called in (("progress", progress), ("begun", begun), ("warn", warn), ("meanwhile", meanwhile)):
        function(argument, called)
    given = settings_of(settings) | ({} if device is None else {"solver.device": device})
    if name is not None and not re.fullmatch(_NAME, instance("name", name, str)):
        raise ArgumentError("name", name, "a name of letters, digits, dots, - and _, for a folder")
    described = Sweep.read(file, given, reduced=flag("reduced", reduced), name=name, columns=functions_by_name(columns))
    # All that can be wrong is found before anything is written.
    cluster = None if scheduler_file is None else file_name("scheduler_file", scheduler_file)
    devices: tuple[str, ...] = ()
    if cluster is not None:
        require_scheduler(cluster)
    else:  # all systems run on what the first one does
        _, config = next(described.systems())
        if sharing(config.solver.shards).size > 1:
            msg = (
                "a sweep starts its own processes: start it without mpiexec or srun; shards are devices of each of them"
            )
            raise InputError(msg)
        # Systems that are divided have all devices, one system after the other.
        devices = () if config.solver.shards > 1 else back_end(config.solver.device).devices()
    at_once = max(1, len(devices)) if workers is None else workers
    check_workers(at_once or 1, threads)
    if devices and at_once > len(devices):
        _check_cards(described, len(devices), at_once)
    limit = granted_memory() if memory is None else number("memory", memory, above=0)
    root = file_name("output", output) / described.name
    part, parts = pair("shard", shard)
    count("shard[0]", part, most=count("shard[1]", parts))
    tasks = begin(described, root, retry=flag("retry", retry), shard=(part, parts), threads=threads, warn=warn)
    if begun is not None:
        begun(tasks)
    is_done = done_before(root)
    if not at_once:
        left = tuple(SweepTask(root, task) for task in tasks if not is_done(task))
        return SweepRun(root, len(tasks), len(tasks) - len(left), 0, (), (), left=left)
    died = list[str]()
    running = run_tasks(
        tasks, partial(solve_task, root), is_done,
        workers=at_once, memory=limit, scheduler_file=cluster, devices=devices,
        meanwhile=partial(_hear, root, died, meanwhile, warn),
    )  # fmt: skip
    ended = list[TaskResult]()
    with closing(running):  # whatever stops this, the processes are stopped
        for one in running:
            record(root, one)
            ended.append(one)
            if progress is not None:
                progress(one, len(ended), len(tasks))
    return replace(_ended(root, ended, searched=described.bisection is not None), died=tuple(died))


def _check_cards(described: Sweep, cards: int, workers: int) -> None:
    """Check that each GPU holds the largest system of as many processes as use it."""
    systems = [config for _, config in described.systems()]
    needed = max(memory_on_device(config) for config in systems)
    fits = max(1, int(back_end(systems[0].solver.device).memory() // needed))
    if workers > cards * fits:
        allowed = (
            f"at most {cards * fits}: {fits} for each of {cards} GPUs, of whose memory each needs {needed / 1e9:.3g} GB"
        )
        raise ArgumentError("workers", workers, allowed)


def _hear(
    root: Path,
    died: list[str],
    meanwhile: Callable[[Task, float], None] | None,
    warn: Callable[[Sequence[str]], None] | None,
    task: Task,
    said: Message,
) -> None:
    """Pass on messages of a running system; the death of its process is also reported and stored."""
    if said.share is not None and meanwhile is not None:
        meanwhile(task, said.share)
    if not said.death:
        return
    died.append(f"{task.label}: {said.death}; its stored points are kept, and it is run again after the others")
    record_death(root, task, said.death)
    if warn is not None:
        warn(died[-1:])


def _ended(root: Path, ended: Sequence[TaskResult], *, searched: bool) -> SweepRun:
    is_done = done_before(root)
    held = tuple(one for one in ended if isinstance(one.error, LockedError) and not is_done(one.task))
    failed = tuple(one for one in ended if not one.ok and not isinstance(one.error, LockedError))
    done = sum(one.ok and not one.found for one in ended)
    crossings: tuple[Crossing, ...] = ()
    if searched:
        listing, paths = systems_of(root), {one.task.path for one in ended}
        mine = tuple(one for one in listing.searches if Folder(root).search(one.name) in paths)
        crossings = crossings_of(root, replace(listing, searches=mine))
    return SweepRun(root, len(ended), len(ended) - done - len(held) - len(failed), done, failed, held, crossings)


def sweep_collect(sweep: str | Path, output: str | Path | None = None) -> PointTable:
    """Write all points of a sweep as one table: ``table.csv``, a row for each, and ``table.h5``, for xarray.

    If a key is searched for, ``crossings.csv`` has a row for each search, and ``table.h5`` its numbers.

    Parameters
    ----------
    sweep : folder of the sweep.
    output : folder for the tables (default: that of the sweep).

    Returns
    -------
    PointTable
        The table; ``found["load"]`` is a column, ``found.crossings`` has the results of searches, and ``found.files``
        the files written.

    Raises
    ------
    SweepError, OutputError
        If there is no sweep, or the tables cannot be written: there may be a table of your own.

    Examples
    --------
    >>> import continuum as c
    >>> c.sweep_collect("results/waves").to_pandas()["area_rep"].size  # two states of two systems
    4
    """
    root = file_name("sweep", sweep)
    place = Folder(root if output is None else file_name("output", output))
    place.require_tables_of_ours()
    if place.root.is_dir():  # whether it can be written to is found before all files are read, which may take an hour
        folder(place.root)
    found = continuum.store.sweeps.collect.collect(root, keep=True)
    folder(place.root)
    for path in (*place.tables, place.crossings):
        remove_stale(path)
    text, cube = place.tables
    held = found.to_xarray()
    datasets = {
        str(name): Dataset(one.values, tuple(map(str, one.dims)), one.attrs["units"], one.attrs["long_name"])
        for name, one in held.variables.items()
    }
    store.write(cube, datasets, {**held.attrs, **provenance()})
    head, rows = found.rows()
    with whole(text) as file:  # row by row: as one text it would take more memory than all else
        lines = io.TextIOWrapper(file, encoding="utf-8", newline="")
        write_csv(lines, [f"{name} ({unit})" if unit not in ("", "1") else name for name, unit in head], rows)
        lines.detach()  # written, and left open
    files = [text, cube]
    if found.crossings:
        files.append(save(place.crossings, crossings_sheet(found.listing, found.crossings).csv()))
    return replace(found, files=tuple(files))


@hinted
def sweep_slurm(
    file: str | Path,
    output: str | Path = "results",
    *,
    settings: Mapping[str, Any] | None = None,
    reduced: bool = False,
    nodes: int = 1,
    time: str = "12:00:00",
    workers: int = 16,
    threads: int = 1,
    memory: float | None = None,
    device: str | None = None,
    shards: int | None = None,
    partition: str | None = None,
    account: str | None = None,
    modules: Sequence[str] = (),
    lines: Sequence[str] = (),
    measure: bool = False,
    warn: Callable[[Sequence[str]], None] | None = None,
) -> str:
    """Job script for ``sbatch`` that runs a sweep: a cluster in one allocation, or an array of jobs.

    Parameters
    ----------
    file : input of a run with a table [sweep]; ``inputs/sweep/...`` finds those that come with the package.
    output : folder in which the folder of the sweep is made, named after the input.
    settings : values for keys of the input; a list for a key on an axis.
    reduced : use the smaller sizes of [sweep.reduced].
    nodes : nodes of the allocation.
    time : time of the allocation, as SLURM writes it.
    workers : processes on each node; fewer if there are fewer systems.
    threads : threads of the solver of each system.
    memory : memory that each process may use, in bytes; what the largest system needs if None.
    device : device of the solver, instead of ``[solver] device`` of the input; with cuda each process uses one GPU.
    shards : number of jobs of a job array, instead of one cluster; fewer if there are fewer systems.
    partition : SLURM partition.
    account : SLURM account.
    modules : modules to load first, as gcc/13.2.
    lines : further lines of the script, as "source ~/venv/bin/activate".
    measure : solve the cheapest system to estimate the core hours, if the folder has no finished system.
    warn : called if the job asks for less time than the sweep needs.

    Raises
    ------
    ConfigError
        If a system is not a valid input of a run.
    ArgumentError
        If an argument is not allowed.
    """
    given = settings_of(settings) | ({} if device is None else {"solver.device": device})
    path = file_name("file", file)
    described = Sweep.read(path, given, reduced=flag("reduced", reduced))
    function("warn", warn)
    systems = costs_of(described)
    needed = max(one.cost.memory for one in systems)
    allocation = Allocation(
        nodes, time, workers, needed if memory is None else number("memory", memory, above=0), threads, shards,
        any(one.config.solver.device != "cpu" for one in systems), partition, account, modules, lines,
    )  # fmt: skip
    allocation = allocation.for_tasks(tasks_of(described, systems))
    root = file_name("output", output)
    known, short = core_hours(systems, root / described.name, allocation, measure=flag("measure", measure))
    if short and warn is not None:
        warn([short])
    words = ["continuum", "sweep", "run", str(path), "--output", str(root), *(["--reduced"] if reduced else [])]
    words += [word for name, value in given.items() for word in ("--set", f"{name}={text_of(value)}")]
    said = [line for line in (known, short) if line]
    said += [f"column {one.name}: {one.made}, which the job executes" for one in described.columns]
    return slurm_script(shlex.join(words), allocation, described.name, said)
