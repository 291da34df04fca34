"""What ``continuum sweep`` does, as functions."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import continuum.runs.collect
from continuum.files import output
from continuum.files.toml import ConfigError, Fault, Source, find, text_of
from continuum.runs.axes import Sweep
from continuum.runs.cluster import slurm_script
from continuum.runs.collect import Collected, Progress, progress_of, write_cube
from continuum.runs.cost import cost_of, pair_seconds
from continuum.runs.sweep import SystemTask, begin, run_sweep
from continuum.runs.tasks import Ended
from continuum.show.sheet import Column, Sheet
from continuum.solve.backend import back_end

__all__ = ["Swept", "check_sweep", "collected", "is_sweep", "plot_figure", "slurm", "status", "sweep", "verified"]

After = Callable[[Ended, int, int], None]
"""Called after each system with how it ended, how many have, and how many there are."""


@dataclass(frozen=True)
class Swept:
    """What one call did of a sweep."""

    folder: Path
    total: int
    """Systems of this call."""
    found: int
    """That were done before, or meanwhile by another process."""
    done: int
    failed: tuple[Ended, ...]
    """That could not be done, with the reasons."""
    held: tuple[Ended, ...]
    """That another process has in hand."""

    @property
    def ok(self) -> bool:
        """Whether all systems are done."""
        return not self.failed and not self.held

    def collect(self) -> Collected:
        """All points that are done, as one table."""
        return continuum.runs.collect.collect(self.folder)


def sweep(
    file: str | Path,
    output: str | Path = "results",
    *,
    settings: Mapping[str, Any] | None = None,
    reduced: bool = False,
    workers: int | None = None,
    threads: int = 1,
    device: str | None = None,
    memory: float | None = None,
    retry: bool = False,
    shard: tuple[int, int] = (1, 1),
    scheduler_file: str | Path | None = None,
    begun: Callable[[list[SystemTask]], None] | None = None,
    progress: After | None = None,
) -> Swept:
    """Do what is missing of a sweep: one path for each system, each stored in a file of its own.

    Parameters
    ----------
    file : an input of a run with a table [sweep]; ``inputs/sweep/...`` finds those that come with the package.
    output : the folder of the sweep is made in this one, named after the file.
    settings : values of keys instead of those of the file; a list for a key on an axis.
    reduced : the values of [sweep.reduced] hold: minutes instead of days.
    workers : processes of this machine, one if None, or one for each GPU; fewer run at once where their memory would
        not suffice.
    threads : of the solver of each system.
    device : what the solver runs on, instead of the input's ``[solver] device``.
    memory : in bytes, of this machine; all of it if None.
    retry : try again what failed.
    shard : this part of so many, for jobs of an array.
    scheduler_file : of a Dask cluster that does the work instead of processes of this machine.
    begun : called with the systems of this call, before the first.
    progress : see :data:`After`.

    Raises
    ------
    ConfigError, OutputError, ClusterError
        If the input cannot be run, results cannot be stored, or there is no such cluster.
    InputError
        If this machine has not the device, or fewer GPUs than workers.
    """
    if device is not None:
        settings = {**(settings or {}), "solver.device": device}
    described = Sweep.read(file, settings, reduced=reduced)
    devices = _devices(described) if scheduler_file is None else ()
    folder = Path(output) / described.name
    _check_shard(described, *shard)
    tasks = begin(described, folder, retry=retry, shard=shard, threads=threads)
    if begun is not None:
        begun(tasks)
    cluster = None if scheduler_file is None else Path(scheduler_file)
    ended = []
    at_once = workers or max(1, len(devices))
    for one in run_sweep(tasks, folder, workers=at_once, memory=memory, scheduler_file=cluster, devices=devices):
        ended.append(one)
        if progress is not None:
            progress(one, len(ended), len(tasks))
    return _swept(folder, ended)


def is_sweep(file: str | Path) -> bool:
    """Whether an input is that of a sweep.

    Raises
    ------
    ConfigError
        If it cannot be read.
    """
    return "sweep" in Source.read(find(file)).data


def check_sweep(file: str | Path, *, settings: Mapping[str, Any] | None = None, reduced: bool = False) -> Sheet:
    """Validate the input of a sweep, each of its systems, and say what they cost together.

    Raises
    ------
    ConfigError
        With all faults of the file, or of its first faulty system.
    """
    described = Sweep.read(file, settings, reduced=reduced)
    costs = [(cost_of(config), config.grid.build()) for _, config in described.systems()]
    pairs = {grid: pair_seconds(grid) for grid in {grid for _, grid in costs}}
    seconds = [cost.seconds(pairs[grid]) for cost, grid in costs]
    rows = [
        ("systems", f"{len(costs)}", ""),
        ("points of their paths", f"{sum(cost.points for cost, _ in costs)}", ""),
        ("grids", ", ".join(sorted({f"{nx} x {ny}" for nx, ny in (grid.shape for grid in pairs)})), ""),
        ("memory of the largest system, about", f"{max(cost.memory for cost, _ in costs) / 2**20:.4g}", "MiB"),
        ("cost, about", f"{sum(cost.fft_pairs for cost, _ in costs)}", "FFT pairs"),
        ("", f"{sum(seconds):.2g}", "core-seconds of this machine, as it is now"),
        ("of them the longest path", f"{max(seconds):.2g}", "core-seconds"),
    ]  # fmt: skip
    return Sheet.of(f"{file}: valid", ("quantity", Column("value"), "unit"), rows)


def _check_shard(described: Sweep, part: int, parts: int) -> None:
    if not 1 <= part <= parts:
        fault = Fault(("sweep",), f"a shard from 1/{parts} to {parts}/{parts}, not {part}/{parts}")
        raise ConfigError(described.source, [fault])


def _devices(described: Sweep) -> tuple[str, ...]:
    """GPUs of this machine that the systems of a sweep run on, as the first one does; none where that is the CPU."""
    _, config = next(iter(described.systems()))
    return back_end(config.solver.device).devices()


def _swept(folder: Path, ended: list[Ended]) -> Swept:
    held = tuple(one for one in ended if isinstance(one.error, output.Held) and not one.task.path.is_file())
    failed = tuple(one for one in ended if not one.ok and not isinstance(one.error, output.Held))
    done = sum(one.ok and not one.found for one in ended)
    return Swept(folder, len(ended), len(ended) - done - len(held) - len(failed), done, failed, held)


def status(folder: str | Path) -> Progress:
    """How far a sweep is, from its files alone.

    Raises
    ------
    SweepError
        If there is none.
    """
    return progress_of(folder)


def collected(folder: str | Path, into: str | Path | None = None) -> tuple[Collected, list[Path]]:
    """Write all points of a sweep as one table: ``table.csv`` (a row for each) and ``table.h5`` (xarray opens it).

    Raises
    ------
    SweepError, OutputError
        If there is no sweep, or the tables cannot be written.
    """
    found = continuum.runs.collect.collect(folder)
    place = output.folder(folder if into is None else into)
    write_cube(found, place / "table.h5")
    head, rows = found.rows()
    sheet = Sheet.of(
        found.listed.name, [f"{name} ({unit})" if unit not in ("", "1") else name for name, unit in head], rows
    )
    return found, [output.save(place / "table.csv", sheet.csv()), place / "table.h5"]


def verified(
    folder: str | Path, *, aside: bool = False, after: Callable[[int], None] | None = None
) -> tuple[int, list[str]]:
    """Read every file of a sweep whole; returns how many there are, and what is wrong with some.

    Raises
    ------
    SweepError
        If there is no sweep.
    """
    count, faults = continuum.runs.collect.verify(folder, aside=aside, after=after)
    return count, [fault.what for fault in faults]


def slurm(
    file: str | Path,
    output: str | Path = "results",
    *,
    settings: Mapping[str, Any] | None = None,
    reduced: bool = False,
    nodes: int = 1,
    time: str = "12:00:00",
    workers: int = 16,
    shards: int | None = None,
) -> str:
    """A job script for ``sbatch`` that does a sweep: a cluster in one allocation, or an array of jobs.

    Raises
    ------
    ConfigError
        If a system is no input of a run.
    """
    described = Sweep.read(file, settings, reduced=reduced)
    memory = max(cost_of(config).memory for _, config in described.systems())
    words = ["continuum", "sweep", "run", str(file), "--output", str(output), *(["--reduced"] if reduced else [])]
    words += [word for name, value in (settings or {}).items() for word in ("--set", f"{name}={text_of(value)}")]
    return slurm_script(
        shlex.join(words), nodes=nodes, time=time, workers=workers, memory=memory, name=described.name, shards=shards
    )


def plot_figure(name: str, *folders: str | Path, into: str | Path | None = None) -> list[Path]:
    """Draw a figure of the paper, or a page with verdicts, from the files of sweeps alone; returns the files written.

    Parameters
    ----------
    name : of the figure; "verdicts"; or "page", which may be of several sweeps.
    folders : of the sweeps.
    into : where to write; the folder of the first sweep if None.

    Raises
    ------
    SweepError, FigureError, OutputError
        If there is no sweep, no such figure, no point for it, or it cannot be written.
    """
    from continuum.show.paper_page import draw_figure

    return draw_figure(name, [Path(folder) for folder in folders], None if into is None else Path(into))
