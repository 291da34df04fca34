"""Many points: tasks with an identity and a file each, run by processes that may die.

The disk is the only truth: a task is done when its file says so, and a second call does what is missing.  What a task
computes, and what is in its file, this module does not know.
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
"""Processes, and threads of each."""
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
    """Do what is missing, several tasks at once; a task that fails does not stop the others.

    Yields the result of each task: those found done first, the others as they end.

    Parameters
    ----------
    tasks : in any order.
    work : writes the file of a task.
    is_done : looks at the file of a task; asked once, before anything is begun.
    workers : processes of this machine, the libraries of each with one thread.
    scheduler_file : of a Dask cluster that does the work instead; its workers bring their own number and threads.
    memory : in bytes; of the tasks that run at once, all but the first fit into it together.
    devices : GPUs as CUDA_VISIBLE_DEVICES names them: each process of this machine sees one, and none sees another's.
    meanwhile : called with all that is heard of a task of this machine: that more of it is done, how it ended, and that
        its process has died; then it is done again when all others have ended, alone.
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
    # Beside others the memory may not have sufficed: alone it may.
    for task in died:
        if (yield from _in_parallel([task], work, environments[:1], memory, meanwhile)):
            yield TaskResult(task, 0.0, DIED)


def check_workers(workers: int, threads: int, devices: Sequence[str] = ()) -> None:
    """Refuse numbers of processes and threads that are none, and more processes than there are GPUs.

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
                if said.death is not None:
                    died.append(task)
                elif said.error is not None:
                    yield TaskResult(task, 0.0, f"{type(said.error).__name__}: {said.error}", said.error)
                else:
                    yield TaskResult(task, said.seconds)
    except BaseException:
        for worker in workers:  # all at once: each stores what it has of its path
            worker.stop()
        for worker in workers:
            worker.end(now=True)
        raise
    for worker in workers:
        worker.end()
    return died
