"""One piece of work of many, what does it, and how it ended: on this machine or on a cluster."""

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
