"""Run tasks, each with an identity and a file, in processes that may die.

A task is done when its file exists, and a second call runs what is missing.  Nothing here depends on what a task
computes.  A worker is a new interpreter that gets its tasks through a pipe and never imports the main script, which
needs no ``if __name__ == "__main__"``.  It ends when the pipe is closed, even if its parent was killed.
"""

from __future__ import annotations

import itertools
import math
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from importlib.util import find_spec
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, NamedTuple

from continuum.inputs.arguments import count
from continuum.inputs.errors import InputError, StickinessError
from continuum.store.output import LockedError

_CODE = (
    "import sys; sys.path[:] = sys.argv[2:]; from continuum.store.sweeps.workers import serve; serve(int(sys.argv[1]))"
)
_TERMINAL = (signal.SIGINT, signal.SIGHUP)
"""Signals that a terminal sends to all its processes: the parent handles them and ends the workers."""
_MOST = 1024
"""Largest numbers of processes, and of threads of each."""
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_WAIT = 60
"""Time limit for the answer of a scheduler, in s."""
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

    def give(self, job: Job, task: Task) -> None:
        if self._process is None:
            self._start()
        with suppress(ConnectionError):  # it has died, which is found when the connection is read
            self.connection.send((job, task))

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
        # Told to stop, a process stores its points first; without an answer in time it is killed.
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
    raise StopSignal(128 + number)


class StopSignal(SystemExit):
    """A signal has asked this process to end."""


def _answer(message: bytes) -> Message | None:
    """Run a task and return its result; None if there are no more tasks."""
    try:
        task: tuple[Job, Task] | None = pickle.loads(message)  # its modules are imported now
    except Exception as error:
        return Message(error=StickinessError(f"{type(error).__name__}: {error}"))
    try:
        return None if task is None else Message(took=timed(*task))
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
    kind : of tasks of one kind the cost is comparable; the first ones of each kind start before the others.
    """

    path: Path
    label: str
    cost: float = 1.0
    memory: float = 0.0
    kind: str = ""


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
    first: bool = False
    """Whether it was the first of its process, which loaded what it needs in that time."""
    at_once: int = 1
    """Number of tasks that ran when it ended, itself included."""

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
    """A message about a task from its process: of a running task, or one of the others."""

    share: float | None = None
    """Finished share, from 0 to 1, of a running task."""
    text: str = ""
    """What the running task does."""
    took: Took | None = None
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


def say(done: float, text: str = "") -> None:
    """Report the finished share of the current task, from 0 to 1, to the listener, and what it does."""
    if (listener := _listener.get()) is not None:
        listener(Message(done, text))


class Took(NamedTuple):
    """Time of a task."""

    seconds: float
    first: bool
    """Whether it was the first of its process."""


_begun = itertools.count()
"""Number of tasks that this process has begun."""


def timed(job: Job, task: Task) -> Took:
    """Run a task; returns the time that it took."""
    first, began = next(_begun) == 0, time.perf_counter()
    try:
        job(task)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # an exception that cannot be sent to another process would break the pool
            raise StickinessError(f"{type(error).__name__}: {error}") from None
        raise
    return Took(time.perf_counter() - began, first)


def run_tasks(
    tasks: Iterable[Task],
    job: Job,
    is_done: Callable[[Any], bool],
    *,
    workers: int = 1,
    scheduler_file: Path | None = None,
    memory: float = math.inf,
    devices: Sequence[str] = (),
    meanwhile: Callable[[Task, Message], None] = lambda task, said: None,
) -> Generator[TaskResult, None, None]:
    """Run the missing tasks in parallel; a task that fails does not stop the others.

    Yields the result of each task: first those that were done before, then the others as they end.

    Parameters
    ----------
    tasks : in any order.
    job : writes the file of a task.
    is_done : checks the file of a task; called once, before anything starts.
    workers : processes of this machine, the libraries of each with one thread.
    scheduler_file : of a Dask cluster that does the work instead; its workers bring their own number and threads.
    memory : memory in bytes; tasks run in parallel as long as they fit into it together.
    devices : GPUs as in CUDA_VISIBLE_DEVICES: each process uses one, in turn.
    meanwhile : called with each message of a task on this machine: progress, result, or death of its process, after
        which the task is run again, alone, when all others have ended.
    """
    check_workers(workers, 1)
    todo = []
    for task in tasks:
        if is_done(task):
            yield TaskResult(task, 0.0)
        else:
            todo.append(task)
    todo = _in_order(todo, workers)
    if scheduler_file is not None:
        yield from _on_cluster(todo, job, scheduler_file)
        return
    shared = {**os.environ, **dict.fromkeys(_THREADS, "1")}
    # JAX alone would take most of a card, which others use too.
    turns = [{"CUDA_VISIBLE_DEVICES": device, "XLA_PYTHON_CLIENT_PREALLOCATE": "false"} for device in devices] or [{}]
    environments = [{**shared, **turns[i % len(turns)]} for i in range(workers)]
    died = yield from _in_parallel(todo, job, environments, memory, meanwhile)
    # Memory may not have sufficed in parallel, but may suffice alone.
    for task in died:
        if (yield from _in_parallel([task], job, environments[:1], memory, meanwhile)):
            yield TaskResult(task, 0.0, DIED)


def _in_order(tasks: Iterable[Task], workers: int) -> list[Task]:
    """The longest first, after a few of each kind, one by one: more than those with which the processes begin."""
    longest = sorted(tasks, key=lambda task: -task.cost)
    kinds = Counter(task.kind for task in longest)
    most = workers // max(len(kinds), 1) + 2
    seen = Counter[str]()

    def place(task: Task) -> int:
        seen[task.kind] += 1
        return min(seen[task.kind], most)

    return sorted(longest, key=place)


def check_workers(workers: int, threads: int) -> None:
    """Check the numbers of processes and threads.

    Raises ArgumentError that names the one that is at fault.
    """
    count("workers", workers, most=_MOST)
    count("threads", threads, most=_MOST)


def _in_parallel(
    todo: list[Task],
    job: Job,
    environments: Iterable[dict[str, str]],
    memory: float,
    meanwhile: Callable[[Task, Message], None],
) -> Generator[TaskResult, None, list[Task]]:
    """Run tasks until all have ended, in one process for each environment; returns those whose process died."""
    waiting, died = list(reversed(todo)), list[Task]()
    workers = [Worker(environment) for environment in environments]
    free, busy = workers[:], dict[object, tuple[Worker, Task]]()

    def next_fitting() -> int | None:
        """Index of the longest task that fits beside those that run."""
        held = [task.memory for _, task in busy.values()]
        fits = (i for i in reversed(range(len(waiting))) if not held or sum(held) + waiting[i].memory <= memory)
        return next(fits, None)

    try:
        while waiting or busy:
            while free and (i := next_fitting()) is not None:
                worker, task = free.pop(), waiting.pop(i)
                worker.give(job, task)
                busy[worker.connection] = worker, task
            for ready in wait([worker.connection for worker, _ in busy.values()]):
                worker, task = busy[ready]
                said = worker.take()
                meanwhile(task, said)
                if said.share is not None:
                    continue
                del busy[ready]
                free.append(worker)
                if said.death:
                    died.append(task)
                elif said.took is None:
                    yield TaskResult(task, 0.0, f"{type(said.error).__name__}: {said.error}", said.error)
                else:
                    yield TaskResult(task, said.took.seconds, first=said.took.first, at_once=len(busy) + 1)
    except BaseException:
        for worker in workers:  # all in parallel: each stores the finished points of its path
            worker.stop()
        for worker in workers:
            worker.end(now=True)
        raise
    for worker in workers:
        worker.end()
    return died


class ClusterError(InputError, OSError):
    """The cluster cannot be reached."""


def _on_cluster(todo: list[Task], job: Job, scheduler_file: Path) -> Generator[TaskResult, None, None]:
    """Run tasks on the workers of a cluster, the longest first.

    A worker returns its time only: results are on disk, so that nothing is lost with a worker.

    Raises ClusterError if Dask is not installed, or no scheduler answers.
    """
    require_scheduler(scheduler_file)
    from distributed import Client, as_completed

    try:
        cluster = Client(scheduler_file=str(scheduler_file), timeout=_WAIT)
    except (OSError, TimeoutError, ValueError) as error:
        raise ClusterError(f"{scheduler_file}: no scheduler answers there ({error})") from error
    with cluster as client:
        at_once = max(1, sum(client.nthreads().values()))
        futures = {
            client.submit(timed, job, task, pure=False, key=f"{task.path.name}-{i}", priority=-i, retries=0): task
            for i, task in enumerate(todo)
        }
        for future in as_completed(list(futures)):
            task = futures.pop(future)
            failure = future.exception()
            if failure is None:
                took = future.result()
                yield TaskResult(task, took.seconds, first=took.first, at_once=at_once)
            elif type(failure).__name__ == "KilledWorker":
                yield TaskResult(task, 0.0, DIED)
            elif isinstance(failure, Exception):
                yield TaskResult(task, 0.0, f"{type(failure).__name__}: {failure}", failure)
            else:
                raise failure
            future.release()


def require_scheduler(scheduler_file: Path) -> None:
    """Check that Dask is installed and that the scheduler file exists.

    Raises ClusterError that says what to do.
    """
    if find_spec("distributed") is None:
        raise ClusterError("a cluster needs Dask: pip install 'stickiness[cluster]'")
    if not scheduler_file.is_file():
        msg = f"{scheduler_file}: there is no such file; `dask scheduler --scheduler-file {scheduler_file}` writes it"
        raise ClusterError(msg)
