"""Many points: tasks with an identity and a file each, run by processes that may die.

The disk is the only truth: a task is done when its file says so, and a second call does what is missing.  What a task
computes, and what is in its file, this module does not know.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from continuum.arguments import ArgumentError, count
from continuum.runs.tasks import DIED, Ended, Job, Task, timed

if TYPE_CHECKING:
    from multiprocessing.queues import SimpleQueue

__all__ = ["run_tasks"]

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def run_tasks(
    tasks: Iterable[Task],
    work: Job,
    is_done: Callable[[Task], bool],
    *,
    workers: int = 1,
    threads: int = 1,
    scheduler_file: Path | None = None,
    memory: float = np.inf,
    devices: Sequence[str] = (),
) -> Generator[Ended, None, None]:
    """Do what is missing, several tasks at once; a task that fails does not stop the others.

    Parameters
    ----------
    tasks : in any order.
    work : writes the file of a task.
    is_done : looks at the file of a task; asked once, before anything is begun.
    workers : processes of this machine.
    threads : that the libraries of each process may use.
    scheduler_file : of a Dask cluster that does the work instead; its workers bring their own number and threads.
    memory : in bytes; of the tasks that run at once, all but the first fit into it together.
    devices : GPUs as CUDA_VISIBLE_DEVICES names them: each process of this machine sees one, and none sees another's.

    Yields
    ------
    Ended
        Of each task: those found done first, the others as they end.
    """
    count("workers", workers)
    count("threads", threads)
    if devices and workers > len(devices):
        raise ArgumentError("workers", workers, f"at most one for each GPU: {len(devices)}")
    todo = []
    for task in tasks:
        if is_done(task):
            yield Ended(task, 0.0)
        else:
            todo.append(task)
    todo.sort(key=lambda task: -task.cost)
    if scheduler_file is not None:
        from continuum.runs.cluster import on_cluster

        yield from on_cluster(todo, work, scheduler_file)
        return
    with _threads(threads):
        suspects = yield from _in_parallel(todo, work, workers, memory, devices)
        # Whose process died is not known where several ran: one by one it shows.
        for task in suspects:
            if (yield from _in_parallel([task], work, 1, memory, devices)):
                yield Ended(task, 0.0, DIED)


def _in_parallel(
    todo: list[Task], work: Job, workers: int, memory: float, devices: Sequence[str]
) -> Generator[Ended, None, list[Task]]:
    """Run tasks until all have ended; returns those whose process died."""
    waiting, suspects = list(reversed(todo)), list[Task]()

    def next_fitting(running: Iterable[Task]) -> int | None:
        """Index of the longest task that fits beside those that run."""
        held = [task.memory for task in running]
        fits = (i for i in reversed(range(len(waiting))) if not held or sum(held) + waiting[i].memory <= memory)
        return next(fits, None)

    while waiting:
        # "spawn": a forked copy of a process that has threads, or MPI, is undefined.
        context = get_context("spawn")
        free: SimpleQueue[str] = context.SimpleQueue()
        for device in devices:
            free.put(device)
        pool_of = partial(
            ProcessPoolExecutor, mp_context=context, initializer=_begin, initargs=(free if devices else None,)
        )
        others = set(active_children())
        with pool_of(min(workers, len(waiting))) as pool:
            running: dict[Future[float], Task] = {}
            alive = True
            try:
                while alive and (running or waiting):
                    while alive and len(running) < workers and (i := next_fitting(running.values())) is not None:
                        try:
                            future = pool.submit(timed, work, waiting[i])
                        except BrokenProcessPool:
                            alive = False
                        else:
                            running[future] = waiting.pop(i)
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        task, error = running.pop(future), future.exception()
                        if isinstance(error, BrokenProcessPool):
                            suspects.append(task)
                            alive = False
                        elif error is None:
                            yield Ended(task, future.result())
                        elif isinstance(error, Exception):
                            yield Ended(task, 0.0, f"{type(error).__name__}: {error}", error)
                        else:
                            raise error
                suspects += running.values()
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                for child in set(active_children()) - others:
                    child.terminate()  # a pool waits for its processes at exit, and these for their solve
                raise
    return suspects


def _begin(free: SimpleQueue[str] | None) -> None:
    """Take a GPU, and end this process when the one that started it has died: it would wait for work for ever."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all; the one that started this one ends it
    if free is not None:
        os.environ["CUDA_VISIBLE_DEVICES"] = free.get()
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=lambda: (wait_for([parent.sentinel]), os._exit(1)), daemon=True).start()


@contextmanager
def _threads(count: int) -> Iterator[None]:
    """What processes that are started meanwhile find in their environment."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, str(count)))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
