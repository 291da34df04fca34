"""A sweep on a cluster: its job script under SLURM, and its systems as jobs of any scheduler.

What a job guarantees is that of the processes of a sweep: its file gets its name only when it is complete, a lock keeps
a second process out, and what is stopped or killed is resumed to the same bits.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from continuum.inputs.arguments import ArgumentError, count
from continuum.store.runs.config import RunConfig
from continuum.store.sweeps.crossings import done_before, solve_task
from continuum.store.sweeps.sweep import SystemTask, record
from continuum.store.sweeps.workers import TaskResult

_PROCESS = 2.5e8
"""Memory of an idle worker, in bytes."""
_TIME = re.compile(r"\d+(:\d\d?){0,2}|\d+-\d\d?(:\d\d?){0,2}")
"""Formats of a time in SLURM: minutes, minutes:seconds, hours:minutes:seconds, days-hours and so on."""
_NAME, _MODULE, _LINE = (
    re.compile(r"[\w.,+-]+", re.ASCII),
    re.compile(r"[\w./+-]+", re.ASCII),
    re.compile(r"[^\n\r\0]*"),
)


@dataclass(frozen=True)
class Allocation:
    """Resources of a SLURM job, as :func:`continuum.sweep_slurm` describes them; ``gpus``: each process takes a GPU.

    Raises ArgumentError if a number is not allowed, or SLURM would refuse a time or a name.
    """

    nodes: int
    time: str
    workers: int
    memory: float
    threads: int = 1
    shards: int | None = None
    gpus: bool = False
    partition: str | None = None
    account: str | None = None
    modules: Sequence[str] = ()
    lines: Sequence[str] = ()

    def __post_init__(self) -> None:
        for name in ("nodes", "workers", "threads"):
            count(name, getattr(self, name))
        if self.shards is not None:
            count("shards", self.shards)
        if not isinstance(self.time, str) or not _TIME.fullmatch(self.time):
            allowed = 'a text such as "12:00:00", "90" (minutes) or "2-12" (days and hours)'
            raise ArgumentError("time", self.time, allowed)
        if self.gpus and self.shards is None:
            raise ArgumentError("shards", None, "a number of jobs: processes of one cluster do not share out its GPUs")
        # Names are not quoted in the script, and cannot carry a command.
        for name in ("partition", "account"):
            value = getattr(self, name)
            if value is not None and not (isinstance(value, str) and _NAME.fullmatch(value)):
                raise ArgumentError(name, value, "a name of letters, digits and any of . , _ + -")
        for name, pattern, allowed in (
            ("modules", _MODULE, "names of modules, as gcc/13.2"),
            ("lines", _LINE, "lines of text"),
        ):
            values = getattr(self, name)
            if isinstance(values, str) or not isinstance(values, Sequence):
                raise ArgumentError(name, values, f"a list: {allowed}")
            for value in values:
                if not (isinstance(value, str) and pattern.fullmatch(value)):
                    raise ArgumentError(name, value, allowed)

    def for_tasks(self, tasks: int) -> Self:
        """Resources that so many systems, or searches, use: no job without one, no more processes than a job has."""
        shards = self.shards and min(self.shards, tasks)
        return replace(self, shards=shards, workers=min(self.workers, math.ceil(tasks / (shards or self.nodes))))

    @property
    def core_seconds(self) -> float:
        """Time that it asks for, of all cores that its processes use."""
        days, _, clock = self.time.rpartition("-")
        parts = [int(part) for part in clock.split(":")]
        if days:  # days-hours:minutes:seconds
            seconds = 86400 * int(days) + sum(part * unit for part, unit in zip(parts, (3600, 60, 1), strict=False))
        elif len(parts) == 3:
            seconds = 3600 * parts[0] + 60 * parts[1] + parts[2]
        else:  # minutes, or minutes:seconds
            seconds = sum(part * unit for part, unit in zip(parts, (60, 1), strict=False))
        return float(seconds) * (self.shards or self.nodes) * self.workers * self.threads

    @property
    def of_process(self) -> float:
        """Memory of a process with its system, in bytes."""
        return self.memory + _PROCESS

    @property
    def head(self) -> list[str]:
        """SLURM options, except names of the job."""
        megabytes = math.ceil(self.workers * self.of_process / 2**20) + 1024
        return [
            f"#SBATCH --nodes={1 if self.shards else self.nodes}",
            "#SBATCH --ntasks-per-node=1",
            f"#SBATCH --cpus-per-task={self.workers * self.threads}",
            f"#SBATCH --mem={megabytes}M",
            f"#SBATCH --time={self.time}",
            *([f"#SBATCH --gres=gpu:{self.workers}"] if self.gpus else []),
            *([f"#SBATCH --partition={self.partition}"] if self.partition else []),
            *([f"#SBATCH --account={self.account}"] if self.account else []),
            *([f"#SBATCH --array=1-{self.shards}"] if self.shards else []),
        ]


def slurm_script(command: str, allocation: Allocation, name: str, said: Sequence[str] = ()) -> str:
    """A job for ``sbatch``: a cluster inside one allocation, or one job of an array for each shard.

    Parameters
    ----------
    command : ``continuum sweep run FILE ...``, quoted; told here where its cluster, or what its shard is.
    allocation : what the job asks for.
    name : of the job.
    said : comments.
    """
    shards, workers, threads = allocation.shards, allocation.workers, allocation.threads
    name = re.sub(r"[^\w.+-]", "-", name, flags=re.ASCII)  # it is not quoted in the script
    head = [
        "#!/bin/bash",
        f"#SBATCH --job-name={name}",
        *allocation.head,
        f"#SBATCH --output={name}-%{'A-%a' if shards else 'j'}.log",
        "#SBATCH --open-mode=append",  # a job that is requeued keeps its log
        "# The same job, submitted again, goes on where this one was stopped.",
        f"# Memory: {workers} x {allocation.of_process / 2**20:.0f} MiB, {_PROCESS / 2**20:.0f} of them for Python, "
        "and 1 GiB for the rest.",
        *(f"# {line}" for line in said),
        "set -eu",
        f"export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 NUMBA_NUM_THREADS={threads}",
        *(f"module load {module}" for module in allocation.modules),
        *(
            allocation.lines
            or ["# Activate the environment here, if a job has none: --line 'source .../bin/activate'."]
        ),
    ]
    command += f" --threads {threads}" if threads > 1 else ""
    if shards:
        return "\n".join([*head, f"exec {command} --workers {workers} --shard $SLURM_ARRAY_TASK_ID/{shards}", ""])
    body = [
        "export DASK_LOGGING__DISTRIBUTED=warning",
        "scheduler=$PWD/scheduler-$SLURM_JOB_ID.json",
        "# Whoever reaches the scheduler can run programs: its page is for this node only.",
        'dask scheduler --scheduler-file "$scheduler" --port 0 --dashboard-address 127.0.0.1:0 &',
        "trap 'kill $(jobs -p) 2>/dev/null; rm -f \"$scheduler\"' EXIT",
        'until [ -s "$scheduler" ]; do sleep 1; done',
        'srun dask worker --scheduler-file "$scheduler" --nthreads 1 --death-timeout 120 \\',
        f"  --nworkers {workers} --memory-limit 0 --dashboard-address 127.0.0.1:0 \\",
        '  --local-directory "${TMPDIR:-/tmp}" &',
        f'{command} --scheduler-file "$scheduler"',
        'echo "Done; stopping the workers, which srun reports as an error."',
        "",
    ]
    return "\n".join([*head, *body])


@dataclass(frozen=True)
class SweepTask:
    """A system of a sweep, or a whole search, to be run in any process; it pickles."""

    folder: Path
    """Folder of the sweep."""
    task: SystemTask = field(repr=False)

    @property
    def label(self) -> str:
        """Values on the axes, in words."""
        return self.task.label

    @property
    def path(self) -> Path:
        """The file that it writes: ``points/KEY.h5``, or ``searches/NAME.json`` for a search."""
        return self.task.path

    @property
    def memory(self) -> float:
        """Estimated memory, in bytes."""
        return self.task.memory

    @property
    def config(self) -> RunConfig:
        """The input of its run; for a search, the input of its lower end."""
        return self.task.plan.config

    def run(self) -> Path:
        """Run it, unless it is done, and return its path; a failure is stored in the folder and raised.

        Raises LockedError if another process runs it now.
        """
        if not done_before(self.folder)(self.task):
            try:
                solve_task(self.folder, self.task)
            except Exception as error:
                record(self.folder, TaskResult(self.task, 0.0, f"{type(error).__name__}: {error}", error))
                raise
        return self.path
