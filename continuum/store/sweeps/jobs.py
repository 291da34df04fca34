"""The systems of a sweep as jobs of any scheduler: each is run anywhere that has the folder, and can be run again.

What a job guarantees is that of the processes of a sweep: its file gets its name only when it is complete, a lock keeps
a second process out, and what is stopped or killed is resumed to the same bits.
"""

from dataclasses import dataclass, field
from pathlib import Path

from continuum.store.runs.config import RunConfig
from continuum.store.sweeps.crossings import done_before, solve_task
from continuum.store.sweeps.sweep import SystemTask, record
from continuum.store.sweeps.workers import TaskResult


@dataclass(frozen=True)
class SweepTask:
    """A system of a sweep, or a whole search, to be run in any process; it pickles."""

    folder: Path
    """Folder of the sweep."""
    task: SystemTask = field(repr=False)

    @property
    def label(self) -> str:
        """Values on the axes, in words."""
        return self.task.label

    @property
    def path(self) -> Path:
        """The file that it makes: ``points/KEY.h5``, or ``searches/NAME.json`` of a search."""
        return self.task.path

    @property
    def memory(self) -> float:
        """Memory that it needs, about, in bytes."""
        return self.task.memory

    @property
    def config(self) -> RunConfig:
        """The input of its run; of a search, that of its lower end."""
        return self.task.plan.config

    def run(self) -> Path:
        """Run it, unless it is done, and return its path; why it fails is stored in the folder, and raised.

        Raises LockedError if another process runs it now.
        """
        if not done_before(self.folder)(self.task):
            try:
                solve_task(self.folder, self.task)
            except Exception as error:
                record(self.folder, TaskResult(self.task, 0.0, f"{type(error).__name__}: {error}", error))
                raise
        return self.path
