"""A file system without flock, as NFS without a lock daemon: both programs fall back alike, and say so."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from continuum.store.output import LockedError, locked

ROOT = Path(__file__).parents[2]
COMPILER = shutil.which("cc") or shutil.which("gcc")
SHIM = """
#include <errno.h>
#include <stdlib.h>
int flock(int descriptor, int operation) { errno = atoi(getenv("FLOCK_ERRNO")); return -1; }
"""
PROGRAM = """
import json, os, sys
from pathlib import Path
from atomistic.lammps.directory import hold
from continuum.inputs.errors import OutputError
from continuum.store.output import reserved

def refused(again):
    try:
        with again():
            return "not refused"
    except OutputError as error:
        return str(error)

said = {}
for error in sys.argv[1:]:
    os.environ["FLOCK_ERRNO"] = error
    doors = {"file": lambda: reserved(Path(error, "a.h5")), "deck": lambda: hold(Path(error).resolve())}
    for name, again in doors.items():
        with again():
            said[f"{name} {error}"] = refused(again)
    said[f"left {error}"] = os.listdir(error)
print(json.dumps(said))
"""


def no_locks(*_: int) -> None:
    raise OSError(errno.ENOLCK, "No locks available")


@pytest.mark.skipif(COMPILER is None, reason="there is no C compiler")
def test_both_programs_fall_back_where_a_file_system_has_no_locks(tmp_path: Path) -> None:
    (tmp_path / "shim.c").write_text(SHIM)
    subprocess.run([str(COMPILER), "-shared", "-fPIC", "-o", "shim.so", "shim.c"], cwd=tmp_path, check=True)
    errors = [str(number) for number in (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS)]
    for name in errors:
        (tmp_path / name).mkdir()
    environment = {"PYTHONPATH": str(ROOT), "LD_PRELOAD": str(tmp_path / "shim.so")}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *errors],
        cwd=tmp_path, env=os.environ | environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    said: dict[str, Any] = json.loads(done.stdout)
    for name in errors:
        for kind in ("file", "deck"):
            assert re.search(rf"by process \d+ on {socket.gethostname()} since", said[f"{kind} {name}"])
            assert "if that process has ended, remove" in said[f"{kind} {name}"]
        assert said[f"left {name}"] == []
    told = [line for line in done.stderr.splitlines() if line]
    assert [line.partition(":")[0] for line in told] == errors, "once of each folder"
    assert all("this file system has no locks" in line for line in told)


def test_a_killed_process_locks_nothing_and_one_of_another_machine_is_told_how_to_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fcntl.flock", no_locks)
    mark = tmp_path / "lock"
    mark.write_text(f"process 999999999 on {socket.gethostname()} since then")
    with locked(mark, "held by {}".format):
        assert f"process {os.getpid()} " in mark.read_text()
    assert not mark.exists()
    mark.write_text("process 7 on elsewhere since then")
    with pytest.raises(LockedError, match=f"held by process 7 on elsewhere .*; if .* has ended, remove {mark}"):
        locked(mark, "held by {}".format).__enter__()
    assert mark.read_text() == "process 7 on elsewhere since then"


@pytest.mark.parametrize("flock", [True, False])
def test_there_is_never_more_than_one_holder(flock: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not flock:
        monkeypatch.setattr("fcntl.flock", no_locks)
    inside, most, rounds = [0], [0], [0]

    def contend() -> None:
        for _ in range(30):
            with suppress(LockedError), locked(tmp_path / "lock", str):
                inside[0] += 1
                most[0] = max(most[0], inside[0])
                rounds[0] += 1
                inside[0] -= 1

    threads = [threading.Thread(target=contend) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most[0] == 1
    assert rounds[0] > 0
    assert not list(tmp_path.iterdir())
