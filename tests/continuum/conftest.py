"""A small run, as an input file; sweeps without processes of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import continuum.front.sweeps
from continuum.sweeps.engine import run_tasks
from continuum.sweeps.workers import Job, Task, TaskResult, heard, timed
from tests.problems import SMALL


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The input file of a run of five points that takes a fraction of a second."""
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture(autouse=True, scope="session")
def in_this_process() -> Iterator[None]:
    """Sweeps of one worker are done here: a process of their own takes two seconds to start, and says nothing more.

    Sweeps of several workers, clusters, and the tests of the engine have their processes.
    """

    def here(tasks: Iterable[Task], work: Job, is_done: Callable[[Task], bool], **given: Any) -> Iterator[TaskResult]:
        if given["workers"] > 1 or given["scheduler_file"] is not None or given["devices"]:
            yield from run_tasks(tasks, work, is_done, **given)
            return
        listed = [(task, is_done(task)) for task in tasks]
        yield from (TaskResult(task, 0.0) for task, done in listed if done)
        for task in sorted((task for task, done in listed if not done), key=lambda task: -task.cost):
            try:
                with heard(partial(given["meanwhile"], task)):
                    seconds = timed(work, task)
            except Exception as error:
                yield TaskResult(task, 0.0, f"{type(error).__name__}: {error}", error)
            else:
                yield TaskResult(task, seconds)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(continuum.front.sweeps, "run_tasks", here)
        yield
