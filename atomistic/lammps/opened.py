"""LAMMPS open in this process, with a folder in which its commands run."""

from __future__ import annotations

import contextlib
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

from atomistic.lammps.engine import guard, open_library


class LammpsHandle:
    """A LAMMPS; close it, or use it with ``with``.

    Parameters
    ----------
    directory : where its commands run.

    Raises
    ------
    LammpsError
        If LAMMPS cannot be loaded.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory.absolute()
        self._lammps = open_library()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close this instance of LAMMPS."""
        self._lammps.close()

    def command(self, *lines: str) -> None:
        """Run commands in LAMMPS' language."""
        with contextlib.chdir(self.directory):
            for line in lines:
                guard(partial(self._lammps.command, line), self.directory)
