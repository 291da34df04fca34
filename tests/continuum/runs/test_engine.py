"""The engine: what is there is not done again; what fails, raises or dies does not stop the rest."""

from __future__ import annotations

import os
import signal
from collections import Counter
from functools import partial
from pathlib import Path

import pytest

from continuum.runs.engine import DIED, Task, run_tasks


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


@pytest.mark.parametrize("workers", [1, 3])
def test_whatever_happens_to_one_task_the_others_are_done(tmp_path: Path, workers: int) -> None:
    names = ["good 1", "dies", "good 2", "raises", "good 3", "dies too", "good 4"]
    tasks = [Task(tmp_path / f"{name}.txt", name) for name in names]
    tasks[0].path.write_text("there already")
    before = os.environ.get("OMP_NUM_THREADS")
    found = {e.task.label: e for e in run_tasks(tasks, partial(work, tmp_path / "log"), exists, workers=workers)}
    assert os.environ.get("OMP_NUM_THREADS") == before
    assert set(found) == set(names)
    assert {name for name, ended in found.items() if ended.ok} == {"good 1", "good 2", "good 3", "good 4"}
    assert found["dies"].reason == found["dies too"].reason == DIED
    assert found["raises"].reason == "ValueError: raises"
    assert isinstance(found["raises"].error, ValueError)
    assert tasks[0].path.read_text() == "there already"
    assert tasks[2].path.read_text() == "1"
    runs = Counter((tmp_path / "log").read_text().splitlines())
    assert "good 1" not in runs
    # Who ran beside one that died, finished or not yet begun, begins again: alone, so once.
    assert all(1 <= runs[name] <= 2 for name in names[1:])


def test_the_longest_is_begun_first(tmp_path: Path) -> None:
    tasks = [Task(tmp_path / f"{cost}.txt", f"good {cost}", float(cost)) for cost in (1, 3, 2)]
    assert [e.task.cost for e in run_tasks(tasks, partial(work, tmp_path / "log"), exists)] == [3, 2, 1]
    assert [e.seconds for e in run_tasks(tasks, partial(work, tmp_path / "log"), exists)] == [0, 0, 0]
