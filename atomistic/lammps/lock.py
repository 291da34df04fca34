"""A lock for one LAMMPS at a time in a directory, which exists as long as the last process that may write there."""

from contextlib import AbstractContextManager
from pathlib import Path

from continuum.files.output import locked

LOCK = "run.lock"
"""Name of the lock file."""
PATIENCE = 2.0
"""Seconds to wait for the end of a killed process."""


def hold(directory: Path) -> AbstractContextManager[int]:
    """Hold the lock of a directory; gives its descriptor, which is passed to the processes that write there.

    The lock (:func:`continuum.files.output.locked`) belongs to the open file: children that inherit the descriptor hold
    it, too, even if this process is killed, and it ends with the last of them.

    Raises LockedError if another run holds it, naming the process that started it; OutputError if the directory cannot
    be written to.
    """

    def refusal(holder: str) -> str:
        return (
            f"{directory}: a run is under way there, begun by {holder}; wait for it, or end it with its children, "
            f"which may outlive it (`fuser -k {LOCK}` there, on that machine)"
        )

    return locked(Path(directory) / LOCK, refusal, inherited=True, patience=PATIENCE)
