"""Tasks done in the process of the tests: a process of their own takes seconds to start, and says nothing more."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

from continuum.sweeps.engine import run_tasks
from continuum.sweeps.workers import Job, Task, TaskResult, heard, timed


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
                seconds = timed(work, task)
        except Exception as caught:
            error = pickle.loads(pickle.dumps(caught))  # as it would come from a process
            yield TaskResult(task, 0.0, f"{type(error).__name__}: {error}", error)
        else:
            yield TaskResult(task, seconds)
