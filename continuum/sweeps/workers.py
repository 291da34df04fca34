"""Worker processes.

Each is a new interpreter that gets its tasks through a pipe and never imports the main script, which needs no ``if
__name__ == "__main__"``.  It ends when the pipe is closed, even if its parent was killed.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from continuum.errors import StickinessError
from continuum.files.output import LockedError

_CODE = "import sys; sys.path[:] = sys.argv[2:]; from continuum.sweeps.workers import serve; serve(int(sys.argv[1]))"
_TERMINAL = (signal.SIGINT, signal.SIGHUP)
"""Signals that a terminal sends to all its processes: the parent handles them and ends the workers."""
_PATIENCE = 60.0
"""Seconds that a process has to store its points; queues give half of that."""


class Worker:
    """A process with these environment variables that runs one task after another.

    It starts with its first task, and again if it has died.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        self._process: subprocess.Popen[bytes] | None = None
        self.connection: Connection[Any, Any]
        """Readable when a task has ended, or the process has died."""

    def give(self, work: Job, task: Task) -> None:
        if self._process is None:
            self._start()
        with suppress(ConnectionError):  # it has died, which is found when the connection is read
            self.connection.send((work, task))

    def take(self) -> Message:
        """Wait for a message about the task, or the death of the process."""
        try:
            found: Message = self.connection.recv()
        except (EOFError, OSError):
            assert self._process is not None
            process = self._process
            self.end(now=True)
            killed = process.returncode < 0
            how = f"was killed by {signal.Signals(-process.returncode).name}" if killed else "ended without a message"
            return Message(death=f"process {process.pid} {how}")
        return found

    def stop(self) -> None:
        """Ask the process to store its finished points and end, without waiting for it."""
        if self._process is not None:
            self._process.terminate()

    def end(self, *, now: bool = False) -> None:
        """End the process after its task, or at once with ``now``."""
        if self._process is None:
            return
        if now:
            self.stop()
        else:
            with suppress(ConnectionError):
                self.connection.send(None)
        try:
            self._process.wait(timeout=_PATIENCE if now else None)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self.connection.close()
        self._process = None

    def _start(self) -> None:
        self.connection, theirs = Pipe()
        warnings = [f"-W{option}" for option in sys.warnoptions]
        # Without -P, modules of the folder that the user works in could take the place of those of the library.
        command = [sys.executable, "-P", *warnings, "-c", _CODE, str(theirs.fileno()), *sys.path]
        with theirs, _blocked(_TERMINAL):
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, env=self._environment, pass_fds=(theirs.fileno(),)
            )


@contextmanager
def _blocked(signals: tuple[signal.Signals, ...]) -> Iterator[None]:
    """Block these signals while processes start, until they are ready to ignore them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(descriptor: int) -> None:
    """Run the tasks that come through a pipe until it is closed; the main function of a worker process."""
    for each in _TERMINAL:
        signal.signal(each, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _stop)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _TERMINAL)
    os.set_inheritable(descriptor, False)  # otherwise a program started by a task would keep the pipe open
    connection: Connection[Any, Any] = Connection(descriptor)
    tasks = queue.SimpleQueue[bytes]()
    threading.Thread(target=_listen, args=(connection, tasks), daemon=True).start()
    with heard(connection.send):
        while (answer := _answer(tasks.get())) is not None:
            connection.send(answer)


def _listen(connection: Connection[Any, Any], tasks: queue.SimpleQueue[bytes]) -> None:
    """Receive messages also while a task runs, so that the end of the parent is noticed at once."""
    with suppress(EOFError, OSError):
        while True:
            tasks.put(connection.recv_bytes())
    os.kill(os.getpid(), signal.SIGTERM)  # the main thread stores what it has
    time.sleep(_PATIENCE)
    os._exit(1)


def _stop(number: int, frame: object) -> None:
    """End the process cleanly: it stores the finished points of a path, even after a second signal."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)


def _answer(message: bytes) -> Message | None:
    """Run a task and return its result; None if there are no more tasks."""
    try:
        task: tuple[Job, Task] | None = pickle.loads(message)  # its modules are imported now
    except Exception as error:
        return Message(error=StickinessError(f"{type(error).__name__}: {error}"))
    try:
        return None if task is None else Message(seconds=timed(*task))
    except Exception as error:
        return Message(error=error)


DIED = "its process died: killed, out of memory, or by a fault of a library"
"""Reason of failure of a task whose process died."""


@dataclass(frozen=True)
class Task:
    """A task and its file.

    Parameters
    ----------
    path : the file that it writes, completely or not at all.
    label : its description.
    cost : cost in any unit; the longest tasks start first.
    memory : memory in bytes.
    """

    path: Path
    label: str
    cost: float = 1.0
    memory: float = 0.0


@dataclass(frozen=True)
class TaskResult:
    """Result of a task: the time that it took, or the error."""

    task: Task
    seconds: float
    """0 where its file was there already."""
    reason: str = ""
    """Why it failed; empty if it did not."""
    error: Exception | None = None
    """What it raised, if it raised."""

    @property
    def ok(self) -> bool:
        """Whether its file is there."""
        return not self.reason

    @property
    def found(self) -> bool:
        """Whether its file was there already."""
        return self.ok and self.seconds == 0

    def __str__(self) -> str:
        if self.ok:
            return f"{self.task.label}: {'was there' if self.found else f'{self.seconds:.1f} s'}"
        held = isinstance(self.error, LockedError)
        return f"{self.task.label}: {'locked by another process' if held else self.reason.splitlines()[0]}"


Job = Callable[[Any], None]
"""Function that runs a task; it must be importable, or partial, to be sent to another process."""


@dataclass(frozen=True)
class Message:
    """A message about a task from its process; one of these is set."""

    share: float | None = None
    """Finished share, from 0 to 1, of a running task."""
    seconds: float = 0.0
    """Time that a finished task took."""
    error: Exception | None = None
    """What it raised."""
    death: str = ""
    """How its process ended before it reported the result, as "process 7 was killed by SIGKILL"."""


_listener: ContextVar[Callable[[Message], None] | None] = ContextVar("listener", default=None)


@contextmanager
def heard(listener: Callable[[Message], None]) -> Iterator[None]:
    """Send progress of the tasks in this process to a listener."""
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)


def say(done: float) -> None:
    """Report the finished share of the current task, from 0 to 1, to the listener."""
    if (listener := _listener.get()) is not None:
        listener(Message(share=done))


def timed(work: Job, task: Task) -> float:
    """Run a task; returns the seconds that it took."""
    began = time.perf_counter()
    try:
        work(task)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # an exception that cannot be sent to another process would break the pool
            raise StickinessError(f"{type(error).__name__}: {error}") from None
        raise
    return time.perf_counter() - began
