"""Processes that do tasks for this one.

Each is a fresh interpreter that gets its tasks through a pipe, and never reads the script that started the work: a
script needs no ``if __name__ == "__main__"``.  It ends when the pipe is closed, whatever became of its parent.
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

_CODE = "import sys; sys.path[:] = sys.argv[2:]; from continuum.sweeps.workers import serve; serve(int(sys.argv[1]))"
_TERMINAL = (signal.SIGINT, signal.SIGHUP)
"""What a terminal sends to all that it runs: the process that started the work hears it, and ends the others."""
_PATIENCE = 60.0
"""Seconds that a process has for storing what it has; a queue gives it half of that."""


class Worker:
    """A process in an environment of these variables that does one task after another.

    It is started with its first task, and again if it has died.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        self._process: subprocess.Popen[bytes] | None = None
        self.connection: Connection[Any, Any]
        """Can be read when a task has ended, or the process has died."""

    def give(self, work: Job, task: Task) -> None:
        if self._process is None:
            self._start()
        with suppress(ConnectionError):  # it has died: the connection says so when it is read
            self.connection.send((work, task))

    def take(self) -> Message:
        """Wait for what its process says of the task, or that it has died."""
        try:
            found: Message = self.connection.recv()
        except (EOFError, OSError):
            assert self._process is not None
            process = self._process
            self.end(now=True)
            by = signal.Signals(-process.returncode).name if process.returncode < 0 else ""
            return Message(death=Death(process.pid, by))
        return found

    def stop(self) -> None:
        """Tell the process to end, without waiting for it: it stores what it has of its path."""
        if self._process is not None:
            self._process.terminate()

    def end(self, *, now: bool = False) -> None:
        """End the process when it has no task; or ``now``, whatever it does."""
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
    """Processes that are started meanwhile hear these signals only when they are ready to ignore them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(descriptor: int) -> None:
    """Do the tasks that come through a pipe, until it is closed: the work of a process that a worker starts."""
    for each in _TERMINAL:
        signal.signal(each, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _stop)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _TERMINAL)
    os.set_inheritable(descriptor, False)  # a program that a task starts would keep the pipe open
    connection: Connection[Any, Any] = Connection(descriptor)
    tasks = queue.SimpleQueue[bytes]()
    threading.Thread(target=_listen, args=(connection, tasks), daemon=True).start()
    with heard(connection.send):
        while (answer := _answer(tasks.get())) is not None:
            connection.send(answer)


def _listen(connection: Connection[Any, Any], tasks: queue.SimpleQueue[bytes]) -> None:
    """Pass on what comes, also while a task is done: only so the end of the parent is seen at once."""
    with suppress(EOFError, OSError):
        while True:
            tasks.put(connection.recv_bytes())
    os.kill(os.getpid(), signal.SIGTERM)  # the main thread stores what it has
    time.sleep(_PATIENCE)
    os._exit(1)


def _stop(number: int, frame: object) -> None:
    """End the process in order: what is done of a path is stored first, which a second signal does not stop."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)


def _answer(message: bytes) -> Message | None:
    """Do a task: how it ended; None where there is no more."""
    try:
        task: tuple[Job, Task] | None = pickle.loads(message)  # its modules are imported now
    except Exception as error:
        return Message(error=StickinessError(f"{type(error).__name__}: {error}"))
    try:
        return None if task is None else Message(seconds=timed(*task))
    except Exception as error:
        return Message(error=error)


DIED = "its process died: killed, out of memory, or by a fault of a library"
"""Why a task failed whose process did not live to say it."""


@dataclass(frozen=True)
class Task:
    """One piece of work, and the file that it writes.

    Parameters
    ----------
    path : the file that it writes, whole or not at all.
    label : of it, for people.
    cost : in any unit; the longest are begun first.
    memory : that it needs, in bytes.
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
    """Why it failed; empty where it did not."""
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


Job = Callable[[Any], None]
"""What a task does: a function of a module, or a partial one, since it travels to another process."""


@dataclass(frozen=True)
class Death:
    """The end of a process that did not live to say how its task ended."""

    process: int
    signal: str
    """Signal that killed it, as ``SIGKILL``; empty if it ended by itself."""

    def __str__(self) -> str:
        return f"process {self.process} {f'was killed by {self.signal}' if self.signal else 'ended without a word'}"


@dataclass(frozen=True)
class Message:
    """What is heard of a task from its process: one of these."""

    share: float | None = None
    """How much of it is done, from 0 to 1; it goes on."""
    seconds: float = 0.0
    """Time that it took, where it is done."""
    error: Exception | None = None
    """What it raised."""
    death: Death | None = None
    """The end of its process."""


_listener: ContextVar[Callable[[Message], None] | None] = ContextVar("listener", default=None)


@contextmanager
def heard(listener: Callable[[Message], None]) -> Iterator[None]:
    """What the tasks of this process say of their progress goes to a listener."""
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)


def say(done: float) -> None:
    """Say how much of the task at hand is done, from 0 to 1, to whoever listens."""
    if (listener := _listener.get()) is not None:
        listener(Message(share=done))


def timed(work: Job, task: Task) -> float:
    """Do a task; returns the seconds that it took."""
    began = time.perf_counter()
    try:
        work(task)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # one that another process cannot read would break the pool
            raise StickinessError(f"{type(error).__name__}: {error}") from None
        raise
    return time.perf_counter() - began
