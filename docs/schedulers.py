"""A sweep on any scheduler that runs Python functions; `continuum sweep collect` does the rest.

A job can be killed and run again, twice or on another machine with the same folder.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import continuum as c


def jobs(file: Any, output: Path) -> list[c.SweepTask]:
    """What is missing of a sweep, the longest first; nothing is run."""
    return list(c.sweep(file, output, workers=0).jobs())


def on_this_machine(todo: list[c.SweepTask], workers: int = 2) -> None:
    """Run jobs in processes by joblib."""
    from joblib import Parallel, delayed

    Parallel(workers)(delayed(job.run)() for job in todo)


def on_dask(todo: list[c.SweepTask], address: str) -> None:
    """Run jobs on the workers of a Dask cluster, wherever they are."""
    from distributed import Client, wait

    with Client(address) as client:
        wait(client.map(c.SweepTask.run, todo, pure=False, retries=2))


def on_slurm(todo: list[c.SweepTask], logs: Path, cluster: str | None = None) -> None:
    """Submit an array of jobs by submitit, which asks for memory and time; ``cluster="local"`` tries it here."""
    import submitit

    executor = submitit.AutoExecutor(logs, cluster=cluster)
    executor.update_parameters(timeout_min=720, mem_gb=1 + max(job.memory for job in todo) / 1e9)
    for submitted in executor.map_array(c.SweepTask.run, todo):
        submitted.result()


SNAKEFILE = """\
import continuum as c

JOBS = {str(job.path): job for job in c.sweep("sweep.toml", "results", workers=0).jobs()}


rule all:
    input: list(JOBS)


rule system:
    output: "results/sweep/points/{key}.h5"
    run: JOBS[output[0]].run()
"""
"""A Snakefile beside the input ``sweep.toml``: `snakemake --cores 4`, or with a profile of the cluster."""
