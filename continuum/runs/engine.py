"""Many points: tasks with an identity and a file each, run by processes that may die.

The disk is the only truth: a task is done when its file says so, and a second call does what is missing.  What a task
computes, and what is in its file, this module does not know.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

__all__ = ["Ended", "Job", "Task", "run_tasks"]

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
DIED = "its process died: killed, or out of memory"


@dataclass(frozen=True)
class Task:
    """One piece of work.

    Parameters
    ----------
    path : the file that it writes, whole or not at all.
    label : of it, for people.
    cost : in any unit; the longest are begun first.
    """

    path: Path
    label: str
    cost: float = 1.0


@dataclass(frozen=True)
class Ended:
    """How a task ended."""

    task: Task
    seconds: float
    """0 where its file was there already."""
    reason: str = ""
    """Why it failed; empty where it did not."""
    error: Exception | None = None
    """What it raised, if it raised."""

    @property
    def ok(self) -> bool:
        """Whether its file is there."""
        return not self.reason


Job = Callable[[Task], None]
"""What a task does: a function of a module, or a partial one, since it travels to another process."""


def run_tasks(
    tasks: Iterable[Task], work: Job, is_done: Callable[[Task], bool], *, workers: int = 1, threads: int = 1
) -> Generator[Ended, None, None]:
    """Do what is missing, several tasks at once; a task that fails does not stop the others.

    Parameters
    ----------
    tasks : in any order.
    work : writes the file of a task.
    is_done : looks at the file of a task; asked once, before anything is begun.
    workers : processes.
    threads : that the libraries of each process may use.

    Yields
    ------
    Ended
        Of each task: those found done first, the others as they end.
    """
    todo = []
    for task in tasks:
        if is_done(task):
            yield Ended(task, 0.0)
        else:
            todo.append(task)
    todo.sort(key=lambda task: -task.cost)
    with _threads(threads):
        suspects = yield from _in_parallel(todo, work, workers)
        # Whose process died is not known where several ran: one by one it shows.
        for task in suspects:
            if (yield from _in_parallel([task], work, 1)):
                yield Ended(task, 0.0, DIED)


def _in_parallel(todo: list[Task], work: Job, workers: int) -> Generator[Ended, None, list[Task]]:
    """Run tasks until all have ended; returns those whose process died."""
    waiting, suspects = list(reversed(todo)), list[Task]()
    while waiting:
        # "spawn": a forked copy of a process that has threads, or MPI, is undefined.
        with ProcessPoolExecutor(min(workers, len(waiting)), mp_context=get_context("spawn")) as pool:
            running: dict[Future[float], Task] = {}
            alive = True
            try:
                while alive and (running or waiting):
                    while alive and waiting and len(running) < workers:
                        try:
                            future = pool.submit(_timed, work, waiting[-1])
                        except BrokenProcessPool:
                            alive = False
                        else:
                            running[future] = waiting.pop()
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
                raise
    return suspects


def _timed(work: Job, task: Task) -> float:
    began = time.perf_counter()
    work(task)
    return time.perf_counter() - began


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
