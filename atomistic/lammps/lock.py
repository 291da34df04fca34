"""A lock for one LAMMPS at a time in a directory, which exists as long as the last process that may write there."""

import contextlib
import fcntl
import os
import socket
import time
from collections.abc import Iterator
from pathlib import Path

from continuum.errors import OutputError

LOCK = "run.lock"
"""Name of the lock file, which is never removed, so that no process locks a removed file."""
PATIENCE = 2.0
"""Seconds to wait for the end of a killed process."""


@contextlib.contextmanager
def hold(directory: Path) -> Iterator[int]:
    """Hold the lock of a directory; yields its descriptor, which is passed to the processes that write there.

    The lock (flock(2)) belongs to the open file: children that inherit the descriptor hold it, too, even if this
    process is killed, and it ends with the last of them.  On file systems without locks the run continues without one.

    Raises OutputError if another run holds it, naming the process that started it, or if the directory cannot be
    written to.
    """
    path = Path(directory) / LOCK
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise OutputError(f"{directory} cannot be written to: {error}") from error
    try:
        try:
            _lock(descriptor)
        except BlockingIOError:
            holder = os.read(descriptor, 200).decode(errors="replace").strip() or "another process"
            raise OutputError(
                f"{directory}: a run is under way there, begun by {holder}; wait for it, or end it with its children, "
                f"which may outlive it (`fuser -k {path.name}` there, on that machine)"
            ) from None
        except OSError:
            pass  # no locks here
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        yield descriptor
    finally:
        os.close(descriptor)


def _lock(descriptor: int) -> None:
    end = time.monotonic() + PATIENCE
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > end:
                raise
            time.sleep(0.02)
        else:
            return
