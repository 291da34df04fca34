"""Tasks on a Dask cluster that a scheduler file names, and the script that starts one inside a SLURM allocation."""

from __future__ import annotations

import math
import re
from collections.abc import Generator
from importlib.util import find_spec
from pathlib import Path

from continuum.arguments import ArgumentError, count
from continuum.errors import InputError
from continuum.sweeps.tasks import DIED, Job, Task, TaskResult, timed

_PROCESS = 2.5e8
"""Bytes of a worker before it does anything."""
_TIME = re.compile(r"\d+(:\d\d?){0,2}|\d+-\d\d?(:\d\d?){0,2}")
"""Minutes, minutes:seconds, hours:minutes:seconds, days-hours and so on: what SLURM takes for a time."""
_WAIT = 60
"""Seconds in which a scheduler has to answer."""


class ClusterError(InputError, OSError):
    """There is no cluster where there should be one."""


def on_cluster(todo: list[Task], work: Job, scheduler_file: Path) -> Generator[TaskResult, None, None]:
    """Run tasks on the workers of a cluster; the longest first, as they come.

    What a worker returns is the time it took: results are on disk, so that nothing is lost with a worker.

    Raises ClusterError if Dask is not installed, or no scheduler answers.
    """
    require_scheduler(scheduler_file)
    from distributed import Client, as_completed

    try:
        cluster = Client(scheduler_file=str(scheduler_file), timeout=_WAIT)
    except (OSError, TimeoutError, ValueError) as error:
        raise ClusterError(f"{scheduler_file}: no scheduler answers there ({error})") from error
    with cluster as client:
        futures = {
            client.submit(timed, work, task, pure=False, key=f"{task.path.name}-{i}", priority=-i, retries=0): task
            for i, task in enumerate(todo)
        }
        for future in as_completed(list(futures)):
            task = futures.pop(future)
            failure = future.exception()
            if failure is None:
                yield TaskResult(task, future.result())
            elif type(failure).__name__ == "KilledWorker":
                yield TaskResult(task, 0.0, DIED)
            elif isinstance(failure, Exception):
                yield TaskResult(task, 0.0, f"{type(failure).__name__}: {failure}", failure)
            else:
                raise failure
            future.release()


def require_scheduler(scheduler_file: Path) -> None:
    """Refuse a cluster that cannot be asked: without Dask, or without the file that says where its scheduler is.

    Raises ClusterError that says what to do.
    """
    if find_spec("distributed") is None:
        raise ClusterError("a cluster needs Dask: pip install 'stickiness[cluster]'")
    if not scheduler_file.is_file():
        msg = f"{scheduler_file}: there is no such file; `dask scheduler --scheduler-file {scheduler_file}` writes it"
        raise ClusterError(msg)


def slurm_script(
    command: str, *, nodes: int, time: str, workers: int, memory: float, name: str, shards: int | None = None
) -> str:
    """A job for ``sbatch``: a cluster inside one allocation, or one job of an array for each shard.

    Parameters
    ----------
    command : ``continuum sweep run FILE ...``, quoted; told here where its cluster, or what its shard is.
    nodes, time : of the allocation, as SLURM has them.
    workers : processes a node, one thread each.
    memory : that a process needs, in bytes.
    name : of the job.
    shards : jobs of an array instead, each on one node.

    Raises ArgumentError if a number is none of processes, nodes or jobs, or SLURM would not take the time.
    """
    count("nodes", nodes)
    count("workers", workers)
    if shards is not None:
        count("shards", shards)
    if not isinstance(time, str) or not _TIME.fullmatch(time):
        raise ArgumentError("time", time, 'a text such as "12:00:00", "90" (minutes) or "2-12" (days and hours)')
    name = re.sub(r"[^\w.+-]", "-", name, flags=re.ASCII)  # it is not quoted in the script
    head = [
        "#!/bin/bash",
        f"#SBATCH --job-name={name}",
        f"#SBATCH --nodes={1 if shards else nodes}",
        "#SBATCH --ntasks-per-node=1",
        f"#SBATCH --cpus-per-task={workers}",
        f"#SBATCH --mem={math.ceil(workers * (memory + _PROCESS) / 2**20) + 1024}M",
        f"#SBATCH --time={time}",
        f"#SBATCH --output={name}-%{'A-%a' if shards else 'j'}.log",
        *([f"#SBATCH --array=1-{shards}"] if shards else []),
        "# The same job, submitted again, goes on where this one was stopped.",
        "set -eu",
        "export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 NUMBA_NUM_THREADS=1",
    ]
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
