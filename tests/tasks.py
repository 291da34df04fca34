"""Tasks done in the process of the tests: a process of their own takes seconds to start, and says nothing more.

And tasks that end in every way, for the tests of processes: these import this module, and no library of tests.
"""

from __future__ import annotations

import os
import pickle
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from continuum.store.sweeps.workers import Job, Task, TaskResult, heard, run_tasks, timed


def tasks_here(tasks: Iterable[Task], work: Job, is_done: Callable[[Task], bool], **given: Any) -> Iterator[TaskResult]:
    """:func:`run_tasks`, but one worker is this process; several workers, and clusters, have their processes."""
    if given["workers"] > 1 or given.get("scheduler_file") is not None or given.get("devices"):
        yield from run_tasks(tasks, work, is_done, **given)
        return
    listed = [(task, is_done(task)) for task in tasks]
    yield from (TaskResult(task, 0.0) for task, done in listed if done)
    for task in sorted((task for task, done in listed if not done), key=lambda task: -task.cost):
        try:
            with heard(partial(given.get("meanwhile", lambda task, said: None), task)):
                took = timed(work, task)
        except Exception as caught:
            error = pickle.loads(pickle.dumps(caught))  # as it would come from a process
            yield TaskResult(task, 0.0, f"{type(error).__name__}: {error}", error)
        else:
            yield TaskResult(task, took.seconds, first=took.first)


def work(log: Path, task: Task) -> None:
    """Leaves a line in a log, and ends as the name of the task says."""
    with log.open("a") as file:
        file.write(f"{task.label}\n")
    if "dies" in task.label:
        os.kill(os.getpid(), signal.SIGKILL)
    if "raises" in task.label:
        raise ValueError(task.label)
    task.path.write_text(os.environ["OMP_NUM_THREADS"])


def exists(task: Task) -> bool:
    return task.path.exists()


def see(task: Task) -> None:
    """Leaves the GPU that its process sees; the first two tasks wait for each other, so that each has a process."""
    task.path.write_text(os.environ["CUDA_VISIBLE_DEVICES"])
    other = task.path.with_name({"0.txt": "1.txt", "1.txt": "0.txt"}.get(task.path.name, task.path.name))
    while not other.exists():
        time.sleep(0.01)
