"""Processes that a launcher has started together: ``srun``, or the ``mpiexec`` of an MPI."""

import atexit
import os
import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from continuum.inputs.errors import NOT_CONVERGED, InputError, StickinessError

_LAUNCHERS = (
    # Rank, number of processes, and how many of them run on this machine, where that is said.
    ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE"),
    ("PMI_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"),
    ("SLURM_PROCID", "SLURM_STEP_NUM_TASKS", ""),  # of a step: in a batch script alone there is one process
)
ADDRESS = "JAX_COORDINATOR_ADDRESS"
"""Variable with host and port of the first process, where no launcher says it."""


class World(NamedTuple):
    """The processes that were started together."""

    rank: int = 0
    size: int = 1
    here: int = 1
    """How many of them run on this machine; 0 where nobody says it."""

    @property
    def first(self) -> bool:
        """Whether this process is the one that writes and speaks."""
        return self.rank == 0

    def address(self, environment: Mapping[str, str] = os.environ) -> str:
        """Where the first process listens, as HOST:PORT; raises InputError where that cannot be known."""
        if given := environment.get(ADDRESS):
            return given
        if self.here == self.size:
            return f"127.0.0.1:{61440 + os.getppid() % 4096}"  # the launcher is the parent of all of them
        msg = (
            f"{self.size} processes on several machines do not find one another: set {ADDRESS} to HOST:PORT, "
            "the machine of the first process and a free port there; or start them by srun"
        )
        raise InputError(msg)


def launched(environment: Mapping[str, str] = os.environ) -> World:
    """The processes that a launcher has started together with this one; one alone without a launcher."""
    for rank, size, here in _LAUNCHERS:
        if environment.get(rank, "").isdecimal() and environment.get(size, "").isdecimal():
            local = environment.get(here, "")
            return World(int(environment[rank]), int(environment[size]), int(local) if local.isdecimal() else 0)
    return World()


@contextmanager
def in_company(world: World) -> Iterator[None]:
    """Say in one message that processes which work together have lost one another, and end without the others."""
    try:
        yield
    except BaseException as error:
        if world.size == 1:
            raise
        # What is called at the end of the process in JAX waits for the others, who may be gone, and ends in a dump.
        stopped = isinstance(error, KeyboardInterrupt)
        code = 128 + (error.args[0] if error.args else signal.SIGINT) if stopped else NOT_CONVERGED
        atexit.register(_end, code)
        if stopped and not world.first:  # which says it for all
            raise SystemExit(code) from None
        if isinstance(error, (StickinessError, MemoryError, OSError)) or not isinstance(error, Exception):
            raise
        said = f"process {world.rank} of {world.size} has lost the others: {str(error).strip().splitlines()[0]}"
        raise StickinessError(f"{said}; the same command continues after the last stored point") from error


def _end(code: int) -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def sharing(shards: int) -> World:
    """The processes that share a contact of so many parts, one at least for each; one alone where it has one part."""
    return launched() if shards > 1 else World()
