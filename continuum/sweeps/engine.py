"""Run tasks, each with an identity and a file, in processes that may die.

A task is done when its file exists, and a second call runs what is missing.  This module does not depend on what a
task computes.
"""

import os
from collections.abc import Callable, Generator, Iterable, Sequence
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import numpy as np

from continuum.arguments import ArgumentError, count
from continuum.sweeps.workers import DIED, Job, Message, Task, TaskResult, Worker

_MOST = 1024
"""Largest numbers of processes, and of threads of each."""
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def run_tasks(
    tasks: Iterable[Task],
    work: Job,
    is_done: Callable[[Any], bool],
    *,
    workers: int = 1,
    scheduler_file: Path | None = None,
    memory: float = np.inf,
    devices: Sequence[str] = (),
    meanwhile: Callable[[Task, Message], None] = lambda task, said: None,
) -> Generator[TaskResult, None, None]:
    """Run the missing tasks in parallel; a task that fails does not stop the others.

    Yields the result of each task: first those that were done before, then the others as they end.

    Parameters
    ----------
    tasks : in any order.
    work : writes the file of a task.
    is_done : checks the file of a task; called once, before anything starts.
    workers : processes of this machine, the libraries of each with one thread.
    scheduler_file : of a Dask cluster that does the work instead; its workers bring their own number and threads.
    memory : memory in bytes; tasks run in parallel as long as they fit into it together.
    devices : GPUs as in CUDA_VISIBLE_DEVICES: each process uses one of its own.
    meanwhile : called with each message of a task on this machine: progress, result, or death of its process, after
        which the task is run again, alone, when all others have ended.
    """
    check_workers(workers, 1, devices)
    todo = []
    for task in tasks:
        if is_done(task):
            yield TaskResult(task, 0.0)
        else:
            todo.append(task)
    todo.sort(key=lambda task: -task.cost)
    if scheduler_file is not None:
        from continuum.sweeps.cluster import on_cluster

        yield from on_cluster(todo, work, scheduler_file)
        return
    shared = {**os.environ, **dict.fromkeys(_THREADS, "1")}
    own = [{"CUDA_VISIBLE_DEVICES": device} for device in devices] or [{}] * workers
    environments = [{**shared, **each} for each in own[:workers]]
    died = yield from _in_parallel(todo, work, environments, memory, meanwhile)
    # Memory may not have sufficed in parallel, but may suffice alone.
    for task in died:
        if (yield from _in_parallel([task], work, environments[:1], memory, meanwhile)):
            yield TaskResult(task, 0.0, DIED)


def check_workers(workers: int, threads: int, devices: Sequence[str] = ()) -> None:
    """Check the numbers of processes and threads, and that there are not more processes than GPUs.

    Raises ArgumentError that names the one that is at fault.
    """
    count("workers", workers, most=_MOST)
    count("threads", threads, most=_MOST)
    if devices and workers > len(devices):
        raise ArgumentError("workers", workers, f"at most one for each GPU: {len(devices)}")


def _in_parallel(
    todo: list[Task],
    work: Job,
    environments: Iterable[dict[str, str]],
    memory: float,
    meanwhile: Callable[[Task, Message], None],
) -> Generator[TaskResult, None, list[Task]]:
    """Run tasks until all have ended, in one process for each environment; returns those whose process died."""
    waiting, died = list(reversed(todo)), list[Task]()
    workers = [Worker(environment) for environment in environments]
    free, busy = workers[:], dict[object, tuple[Worker, Task]]()

    def next_fitting() -> int | None:
        """Index of the longest task that fits beside those that run."""
        held = [task.memory for _, task in busy.values()]
        fits = (i for i in reversed(range(len(waiting))) if not held or sum(held) + waiting[i].memory <= memory)
        return next(fits, None)

    try:
        while waiting or busy:
            while free and (i := next_fitting()) is not None:
                worker, task = free.pop(), waiting.pop(i)
                worker.give(work, task)
                busy[worker.connection] = worker, task
            for ready in wait([worker.connection for worker, _ in busy.values()]):
                worker, task = busy[ready]
                said = worker.take()
                meanwhile(task, said)
                if said.share is not None:
                    continue
                del busy[ready]
                free.append(worker)
                if said.death:
                    died.append(task)
                elif said.error is not None:
                    yield TaskResult(task, 0.0, f"{type(said.error).__name__}: {said.error}", said.error)
                else:
                    yield TaskResult(task, said.seconds)
    except BaseException:
        for worker in workers:  # all in parallel: each stores the finished points of its path
            worker.stop()
        for worker in workers:
            worker.end(now=True)
        raise
    for worker in workers:
        worker.end()
    return died
