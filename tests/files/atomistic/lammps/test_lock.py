"""Two LAMMPS never write into one directory: the lock lives as long as the last process of a run."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps import directory as disk
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.directory import LOCK, hold
from atomistic.lammps.engine import run_command, run_in_process
from continuum.inputs.errors import OutputError
from continuum.model.walls import LennardJonesSpline


def small(separation: float = 1.1) -> Deck:
    return Deck(Slab((4, 4), mobile=2), Springs(), LennardJonesSpline(0.0), np.zeros((4, 4)), separation)


@pytest.mark.parametrize("act", [run_in_process, run_command, lambda path: write_deck(path, small(1.2))])
def test_a_second_run_is_one_message_that_says_who_holds_the_directory(tmp_path, act, monkeypatch):
    monkeypatch.setattr(disk, "PATIENCE", 0.0)
    directory = write_deck(tmp_path / "deck", small())
    before = {path.name: path.read_bytes() for path in directory.iterdir() if path.name != LOCK}
    with hold(directory), pytest.raises(OutputError, match=f"under way there, begun by process {os.getpid()} on"):
        act(directory)
    assert before == {path.name: path.read_bytes() for path in directory.iterdir() if path.name != LOCK}
    act(directory)


def test_the_lock_outlives_a_killed_parent_while_a_child_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(disk, "PATIENCE", 0.0)
    # What the wheel's lmp is: a script that waits for the process that computes.
    directory = write_deck(tmp_path / "deck", small())
    site = f"'{sys.executable}' -c 'import subprocess as s; s.run([\"sleep\", \"60\"], close_fds=False)'"
    code = f"from atomistic.lammps.engine import run_command as run; run({str(directory)!r}, {site!r})"
    parent = subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
    try:
        group = _until(lambda: _session_of(directory))
        os.kill(parent.pid, signal.SIGKILL)
        parent.wait()
        with pytest.raises(OutputError, match=f"begun by process {parent.pid} on"):
            run_in_process(directory)
    finally:
        for pid in group:
            os.kill(pid, signal.SIGKILL)
    _until(lambda: _free(directory))  # the script between the two ends by itself
    run_in_process(directory).require()


def _free(directory: Path) -> bool:
    try:
        with hold(directory):
            return True
    except OutputError:
        return False


def _session_of(directory: Path) -> list[int]:
    """Processes that sleep with the lock of a directory open."""
    found = []
    for process in Path("/proc").iterdir():
        try:
            words = (process / "cmdline").read_bytes()
            files = {str(file.readlink()) for file in (process / "fd").iterdir()} if process.name.isdigit() else set()
        except OSError:
            continue
        if words.startswith(b"sleep") and str(directory / LOCK) in files:
            found.append(int(process.name))
    return found


def _until(look, seconds: float = 60.0):
    """What a look finds, as soon as it finds something."""
    end = time.monotonic() + seconds
    while not (found := look()):
        assert time.monotonic() < end
        time.sleep(0.1)
    return found
