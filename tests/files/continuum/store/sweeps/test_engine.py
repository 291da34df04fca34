"""The engine: what is there is not done again; what fails, raises or dies does not stop the rest."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections import Counter
from functools import partial
from pathlib import Path

import pytest

from continuum.store.sweeps.workers import DIED, Task, run_tasks
from tests.tasks import exists, see, work

ROOT = Path(__file__).parents[5]
SCRIPT = """
from functools import partial
from pathlib import Path
from continuum.store.sweeps.workers import run_tasks
from continuum.store.sweeps.workers import Task
from tests.tasks import exists, work
print("read", flush=True)
tasks = [Task(Path(f"{i}.txt"), f"good {i}", float(i)) for i in (1, 2)]
for ended in run_tasks(tasks, partial(work, Path("log")), exists):
    print(ended.task.label, ended.ok)
"""


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
    # What ran beside a process that died is left alone.
    assert runs == {name: 2 if "dies" in name else 1 for name in names[1:]}


def test_a_script_that_starts_processes_is_not_run_by_them(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    # As a notebook does, the script works in a folder of its own: a module there is none of the library's.
    (tmp_path / "numpy.py").write_text("raise ImportError('the one of the user')")
    command = [sys.executable, "-P", "script.py"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == ["read", "good 2 True", "good 1 True"]


def test_a_task_that_a_process_cannot_read_has_failed_with_the_reason(tmp_path: Path) -> None:
    class Local(Task):
        """Another process cannot import it."""

    with pytest.raises((AttributeError, TypeError, pickle.PicklingError), match="Local"):
        list(run_tasks([Local(tmp_path / "a", "good")], partial(work, tmp_path / "log"), exists))
    (tmp_path / "gone.py").write_text("def work(task): raise RuntimeError('never')")
    sys.path.insert(0, str(tmp_path))
    try:
        from gone import work as gone
    finally:
        sys.path.remove(str(tmp_path))
    (ended,) = run_tasks([Task(tmp_path / "a", "good")], gone, exists)
    assert "No module named 'gone'" in ended.reason


def test_the_longest_is_begun_first(tmp_path: Path) -> None:
    tasks = [Task(tmp_path / f"{cost}.txt", f"good {cost}", float(cost)) for cost in (1, 3, 2)]
    assert [e.task.cost for e in run_tasks(tasks, partial(work, tmp_path / "log"), exists)] == [3, 2, 1]
    assert [e.seconds for e in run_tasks(tasks, partial(work, tmp_path / "log"), exists)] == [0, 0, 0]


def test_each_process_sees_one_gpu_and_they_share_them_equally(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "3,5")
    tasks = [Task(tmp_path / f"{i}.txt", str(i), 4.0 - i) for i in range(4)]
    assert all(ended.ok for ended in run_tasks(tasks, see, exists, workers=4, devices=("3", "5")))
    assert sorted(task.path.read_text() for task in tasks) == ["3", "3", "5", "5"]
    assert os.environ["CUDA_VISIBLE_DEVICES"] == "3,5"
