"""Progress of the systems of a sweep, with the time left as those that have ended tell it."""

import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from continuum.show.console import on_a_bar, progress, tell
from continuum.store.sweeps.pace import Span, SystemTime, expected, work_of
from continuum.store.sweeps.workers import Task, TaskResult

_OFTEN = 30.0
"""Seconds between two lines about an unfinished system."""


class SweepProgress(ExitStack):
    """Progress of a sweep; nothing is shown before :meth:`begin`.

    Once a system on each grid has ended, a line says what all take together.
    """

    def __init__(self, title: str) -> None:
        super().__init__()
        self._title = title
        self._left: dict[Path, Task] = {}
        self._shares: dict[Path, float] = {}
        self._ended: list[SystemTime] = []
        self._at_once = 1
        self._told = False

    def begin(self, tasks: Sequence[Task]) -> None:
        """Set the systems, done or not."""
        self._left = {task.path: task for task in tasks}
        self._total, self._said = len(tasks), time.monotonic()
        self._report = self.enter_context(progress(self._total, self._title, self._time_left))

    def end(self, ended: TaskResult) -> None:
        """Report a system that has ended, except one that was done before."""
        task = self._left.pop(ended.task.path)
        self._shares.pop(task.path, None)
        if ended.found:
            return
        if ended.ok:
            self._ended.append(SystemTime(task.kind, task.cost, ended.seconds, ended.first))
            self._at_once = ended.at_once
        self._report(self._total - len(self._left), str(ended))
        self._tell()

    def advance(self, task: Task, share: float) -> None:
        """Report the finished share of a system, from 0 to 1; every half minute where each report is a line."""
        self._shares[task.path] = share
        if on_a_bar() or time.monotonic() - self._said > _OFTEN:
            self._report(self._total - len(self._left), f"{task.label}: {share:.0%} of its points")
            self._said = time.monotonic()

    def _tell(self) -> None:
        """Say once what the others take, as soon as a system on each of their grids has ended."""
        kinds = {task.kind for task in self._left.values()}
        if self._told or not kinds or not kinds <= {one.kind for one in self._ended if one.counts}:
            return
        self._told = True
        tell(f"{self._title}: the other {len(self._left)} take {self._span()} of one core, by the first on each grid")

    def _span(self) -> Span | None:
        """Time for what is left in one process; None if it is not known yet."""
        left = ((task.kind, task.cost * (1 - self._shares.get(path, 0.0))) for path, task in self._left.items())
        return expected(self._ended, work_of(left))

    def _time_left(self) -> str:
        span = self._span()
        return "" if span is None else str(span.over(max(1, min(self._at_once, len(self._left)))))
