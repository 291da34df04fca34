"""Tasks, and their messages and results, on this machine or on a cluster."""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from continuum.errors import StickinessError

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


Job = Callable[[Any], None]
"""Function that runs a task; it must be importable, or partial, to be sent to another process."""


@dataclass(frozen=True)
class Death:
    """The death of a process before it reported the result of its task."""

    process: int
    signal: str
    """Signal that killed it, as ``SIGKILL``; empty if it ended by itself."""

    def __str__(self) -> str:
        return f"process {self.process} {f'was killed by {self.signal}' if self.signal else 'ended without a message'}"


@dataclass(frozen=True)
class Message:
    """A message about a task from its process; one of these is set."""

    share: float | None = None
    """Finished share, from 0 to 1, of a running task."""
    seconds: float = 0.0
    """Time that a finished task took."""
    error: Exception | None = None
    """What it raised."""
    death: Death | None = None
    """The end of its process."""


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
