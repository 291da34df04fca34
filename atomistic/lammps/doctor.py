"""Check the LAMMPS of this machine, and find remedies."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

from atomistic.lammps import engine
from atomistic.lammps.result import LammpsError
from continuum.files.provenance import version_of

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
        with contextlib.closing(engine.open_library()) as lammps:
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
            words = [engine.script(name), *before]
            if name == "mpiexec":
                words.append(engine.script("lmp"))
            engine.try_to_start(words)
            found[name] = words[0]
        except LammpsError as error:
            problems.append(f"{name}: {error}")
    mpi, remedy = version_of("mpich") or None, engine.REMEDY if problems else None
    return Doctor(in_process, found["lmp"], found["mpiexec"], version, packages, mpi, tuple(problems), remedy)
