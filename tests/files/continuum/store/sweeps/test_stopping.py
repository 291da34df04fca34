"""What stops a path stores what it has; a process that dies is said; how far the paths in hand are is seen."""

from __future__ import annotations

import importlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

import continuum as c
import continuum.front.sweeps
import continuum.path.equilibrium
import continuum.path.loading
from continuum.front.cli import main
from continuum.inputs.errors import StickinessError
from continuum.inputs.reading import load
from continuum.store import datasets as store
from continuum.store.runs.config import RunConfig
from continuum.store.runs.run import follow_run
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.status import sweep_status
from continuum.store.sweeps.sweep import begin, record_death, solve_system
from continuum.store.sweeps.workers import Message, Task
from docs import schedulers
from tests.problems import SMALL
from tests.stored import content, same
from tests.tasks import tasks_here

LONG = SMALL.replace("[1.6, 1.4,\n           1.2]", "{from = 2.0, to = 1.0, count = 2000}").replace(
    "retract = true\n", ""
)
LONG = LONG.replace("fields = true", "fields = false") + '[sweep.axes]\n"surface.seed" = [3]\n'
"""A path of seconds: less than between two writings of a sweep."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The path of SMALL that nothing has stopped."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "small.toml").write_text(SMALL)
    follow_run(load(folder / "small.toml", RunConfig), folder / "whole.h5")
    return folder / "whole.h5"


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_a_path_that_is_stopped_between_two_writings_stores_its_points(
    error: type[BaseException], small: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, path = load(small, RunConfig), small.with_name("stopped.h5")
    solved, calls = continuum.path.equilibrium.equilibrium, iter(range(100))

    def stopped(*given: object, **more: object) -> object:
        if next(calls) == 3:  # while the fourth point is solved
            raise error
        return solved(*given, **more)

    with monkeypatch.context() as patch:
        patch.setattr(continuum.path.loading, "equilibrium", stopped)
        with pytest.raises(error):
            follow_run(config, path, every=1e9)
    assert store.read_few(path, ("step",), ())[0]["step"].size == 3
    assert follow_run(config, path).resumed == 3
    same(path, whole)


@pytest.mark.parametrize("whom", ["the driver", pytest.param("its worker", marks=pytest.mark.long)])
def test_a_signal_stores_the_path_in_hand(whom: str, tmp_path: Path) -> None:
    (tmp_path / "many.toml").write_text(LONG)
    work, patience = tmp_path / "many" / "work", 0.5
    command = [sys.executable, "-m", "continuum", "sweep", "run", "many.toml", "-o", ".", "-q"]
    while not list(work.glob("*.h5")):  # on a busy machine a path may take a while to begin
        process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        while process.poll() is None and not list(work.glob("*.h5.lock")) + list(work.glob(".*.h5.lock")):
            time.sleep(0.02)
        time.sleep(patience)
        assert process.poll() is None, "done before it was stopped: the path is too short"
        (worker,) = [c for c in psutil.Process(process.pid).children() if "workers" in " ".join(c.cmdline())]
        if whom == "the driver":
            process.terminate()
        else:
            worker.terminate()
            psutil.wait_procs([worker], timeout=60)
            process.terminate()
        assert process.communicate(timeout=60)[1].count(b"Traceback") == 0
        assert not psutil.pid_exists(worker.pid)
        patience *= 2
    (path,) = work.glob("*.h5")
    assert store.read_few(path, ("step",), ())[0]["step"].size > 0


def test_a_death_is_said_until_the_system_is_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "many.toml").write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1, 2]\n')
    root = tmp_path / "many"
    one, _ = begin(Sweep.read(tmp_path / "many.toml"), root)
    record_death(root, one, "process 4711 was killed by SIGKILL")
    (said,) = sweep_status(root).died
    assert said.startswith(f"{one.label}: process 4711 was killed by SIGKILL, ")
    assert main(["sweep", "status", str(root)]) == 0
    assert "process 4711 was killed by SIGKILL" in capsys.readouterr().out
    solve_system(root, one)
    assert sweep_status(root).died == ()
    assert not list(Folder(root).running.iterdir())


def test_a_process_that_died_is_named_until_its_system_is_run_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the engine says it of a process, the tests of which kill some."""
    (tmp_path / "many.toml").write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1, 2]\n')
    root, seen = tmp_path / "many", list[tuple[str, ...]]()

    def dying(tasks: list[Task], *given: Any, meanwhile: Callable[[Task, Message], None], **more: Any) -> Any:
        meanwhile(tasks[0], Message(death="process 4711 was killed by SIGKILL"))
        seen.append(sweep_status(root).died)
        return tasks_here(tasks, *given, meanwhile=meanwhile, **more)

    monkeypatch.setattr(continuum.front.sweeps, "run_tasks", dying)
    heard = list[str]()
    done = continuum.sweep(tmp_path / "many.toml", tmp_path, warn=heard.extend)
    assert (done.ok, done.done) == (True, 2)
    (said,) = done.died
    assert "process 4711 was killed by SIGKILL; its stored points are kept" in said
    assert heard == [said]
    ((stored,),) = seen
    assert "process 4711 was killed by SIGKILL" in stored
    assert sweep_status(root).died == ()


@pytest.mark.long
def test_a_killed_process_is_named_and_the_path_of_the_other_goes_on(tmp_path: Path) -> None:
    (tmp_path / "many.toml").write_text(LONG.replace("[3]", "[3, 4]").replace("2000", "20"))
    killed = list[int]()

    def kill(task: object, share: float) -> None:
        del task
        if not killed:
            workers = [
                c for c in psutil.Process().children() if "continuum.store.sweeps.workers" in " ".join(c.cmdline())
            ]
            killed.append(workers[0].pid)
            os.kill(workers[0].pid, signal.SIGKILL)

    heard = list[str]()
    done = continuum.sweep(tmp_path / "many.toml", tmp_path, workers=2, meanwhile=kill, warn=heard.extend)
    assert done.ok
    assert done.done == 2
    (said,) = done.died
    assert f"process {killed[0]} was killed by SIGKILL" in said
    assert heard == [said]
    assert sweep_status(done.folder).died == ()


def test_status_is_watched_until_the_sweep_is_whole(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "many.toml").write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1, 2]\n')
    root = tmp_path / "many"
    left = begin(Sweep.read(tmp_path / "many.toml"), root)
    monkeypatch.setattr(time, "sleep", lambda seconds: solve_system(root, left.pop()))
    assert main(["sweep", "status", str(root), "--watch", "10"]) == 0
    assert capsys.readouterr().out.count("running") == 3
    assert not left
    assert main(["sweep", "status", str(root), "--watch", "-1"]) == 2


ENGINES: dict[str, Callable[[list[c.SweepTask], Path], None]] = {
    "joblib": lambda todo, folder: schedulers.on_this_machine(todo),
    "submitit": lambda todo, folder: schedulers.on_slurm(todo, folder / "logs", cluster="local"),
    "distributed": lambda todo, folder: _on_dask(todo),
}


def _on_dask(todo: list[c.SweepTask]) -> None:
    with importlib.import_module("distributed").LocalCluster(1, threads_per_worker=1, dashboard_address=None) as here:
        schedulers.on_dask(todo, here.scheduler_address)


@pytest.mark.parametrize("engine", ["joblib", *(pytest.param(e, marks=pytest.mark.long) for e in [*ENGINES][1:])])
def test_a_sweep_runs_on_other_schedulers(engine: str, tmp_path: Path) -> None:
    """The code of docs/schedulers.py; what it makes is what our own processes make."""
    pytest.importorskip(engine)
    path = tmp_path / "many.toml"
    path.write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1, 2, 3]\n')
    todo = schedulers.jobs(path, tmp_path)
    assert [job.path.parent.name for job in todo] == ["points"] * 3
    todo[0].run()
    assert len(schedulers.jobs(path, tmp_path)) == 2
    ENGINES[engine](todo, tmp_path)  # one of them is done
    assert c.sweep(path, tmp_path).found == 3
    assert len(c.sweep_collect(tmp_path / "many").keys) == 3
    alone = c.run(todo[1].config, tmp_path / "alone.h5")
    other = content(todo[1].path)
    np.testing.assert_equal({name: other[name] for name in content(alone.path)}, content(alone.path))
    # What `continuum run` made is collected, too.
    table = c.sweep_collect(tmp_path / "many")
    todo[1].path.write_bytes(alone.path.read_bytes())
    np.testing.assert_allclose(c.sweep_collect(tmp_path / "many").values, table.values, rtol=1e-12, equal_nan=True)


def test_a_job_that_fails_says_so_in_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "many.toml"
    path.write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1]\n')

    def broken(result: c.Result) -> float:
        raise ValueError("no such patch")

    (job,) = c.sweep(path, tmp_path, columns={"mine": broken}, workers=0).jobs()
    with pytest.raises(StickinessError, match="no such patch"):
        job.run()
    assert "no such patch" in c.sweep_status(tmp_path / "many").failed[0][1]
