"""Check whether stored states satisfy the equations, independently of the solver."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from continuum.arguments import count, file_name, function
from continuum.files.hdf5 import StoreError
from continuum.measure.certificate import NO_TRACTION, StateCheck, check_state
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import solver_of
from continuum.runs.build import RunSetup, build
from continuum.runs.record import Point, Record
from continuum.runs.result import Result
from continuum.runs.run import states_of
from continuum.show.sheet import Column, Sheet
from continuum.sweeps.folder import Folder
from continuum.sweeps.sweep import systems_of

ENOUGH = 1.5
"""Factor by which residuals may exceed tolerance and rounding, as finite differences smooth a kink of the law: 1.3 was
observed."""


@dataclass(frozen=True)
class PointCertificate:
    """One point of a stored run, with the independent evaluation of its state."""

    path: Path
    step: int
    point: Point
    found: StateCheck
    tolerance: float
    """Tolerance of the run, in E*."""
    again: bool
    """Whether the state was computed again, as it was not stored."""

    @property
    def allowed(self) -> float:
        """Largest residual, and difference of loads, in E*."""
        return ENOUGH * (self.tolerance + self.found.rounding)

    @property
    def faults(self) -> tuple[str, ...]:
        """Disagreements, in words; empty if all numbers agree."""
        here, found, allowed = self.point, self.found, self.allowed
        faults = []
        if not found.residual <= allowed:
            faults.append(f"the residual is {found.residual:.2e} E*, above {allowed:.2e} E*")
        if abs(found.area_rep - here.area_rep) > found.uncertain_area + 1e-12:
            faults.append(f"A_rep/A0 is {found.area_rep:.6g}, and {here.area_rep:.6g} is stored")
        if abs(found.load - here.load) > allowed:
            faults.append(f"N/A0 is {found.load:.6e} E*, and {here.load:.6e} E* is stored")
        if found.curvature <= 0:
            faults.append("the energy decreases along a displacement, so that this is a saddle point")
        return tuple(faults)


@dataclass(frozen=True)
class Certificate:
    """Result of checking a run, or a sample of a sweep."""

    points: tuple[PointCertificate, ...]
    read: int
    """Number of files that were read."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Disagreements, with file and point; empty if all points agree."""
        return tuple(f"{one.path}, step {one.step}: {fault}" for one in self.points for fault in one.faults)

    @property
    def ok(self) -> bool:
        """Whether all points are sound."""
        return not self.faults

    def _repr_html_(self) -> str:
        return self.sheet()._repr_html_()

    def sheet(self) -> Sheet:
        """One row for each point."""
        columns = (
            Column("file"), Column("step"), Column("A_rep/A0"), Column("off", "", ".1e"), Column("N/A0", "E*", ".4e"),
            Column("off", "E*", ".1e"), Column("residual", "E*", ".2e"), Column("allowed", "E*", ".1e"),
            Column("curvature", "E*/a0", ".3g"), Column(""),
        )  # fmt: skip
        rows = []
        for one in self.points:
            at, found = one.point, one.found
            rows.append(
                (one.path.stem, one.step, at.area_rep, found.area_rep - at.area_rep, at.load, found.load - at.load,
                 found.residual, one.allowed, found.curvature, "sound" if not one.faults else "; ".join(one.faults))
            )  # fmt: skip
        again = "; states were computed again, as the files hold no gaps" if any(p.again for p in self.points) else ""
        title = f"{len(self.points)} states of {self.read} files, checked independently of the solver{again}"
        return Sheet.of(title, columns, rows)


def certify(
    path: str | Path,
    *,
    sample: int = 3,
    seed: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Certificate:
    """Evaluate stored states by other transforms, sums and derivatives than the solver's, and compare.

    Residual, area and load follow from heights and gap alone; the second derivative of the energy is taken along
    random displacements.  Runs that store fields are checked from these; other runs are computed again and compared.

    Parameters
    ----------
    path : a stored run, or the folder of a sweep.
    sample : number of systems of a sweep to check, drawn at random.
    seed : seed of the random draw.
    progress : called after each file with how many are done and how many there are.

    Raises
    ------
    StoreError
        If a file is no finished run, or what its input names is gone.
    SweepError
        If the folder is no sweep.
    ArgumentError
        If an argument is not allowed.
    """
    given = file_name("path", path)
    count("sample", sample)
    count("seed", seed, least=0)
    function("progress", progress)
    files = _sample(given, sample, seed) if given.is_dir() else [given]
    points: list[PointCertificate] = []
    for done, file in enumerate(files, 1):
        points += certify_run(file)
        if progress is not None:
            progress(done, len(files))
    return Certificate(tuple(points), len(files))


def _sample(root: Path, sample: int, seed: int) -> list[Path]:
    folder, listing = Folder(root), systems_of(root)
    done = [path for system in listing.systems if (path := folder.point(system.key)).is_file()]
    if not done:
        raise StoreError(f"{root}: no system of this sweep is done")
    chosen = np.random.default_rng(seed).choice(len(done), min(sample, len(done)), replace=False)
    return [done[i] for i in sorted(chosen)]


def certify_run(path: Path) -> Iterator[PointCertificate]:
    """Check each converged point of a stored run.

    Gaps come from the file if it has them (in single precision); otherwise the path is computed again, and its gaps
    are compared with the stored numbers.

    Raises StoreError if the file is no finished run, or the files that its input names are gone.
    """
    result = Result.read(path)
    if not result.finished:
        raise StoreError(f"{path}: is not finished: run it again, then certify it")
    config = result.config
    try:
        system = build(config)
    except (OSError, ValueError) as error:
        raise StoreError(f"{path}: its surface or wall cannot be built again: {error}") from error
    if system.problem.open_boundary is not None and system.problem.wall.law is None:
        raise StoreError(f"{path}: cannot be certified: {NO_TRACTION}")
    # The heights of an intermediate imprint are not stored.
    stored = result.gap(0) is not None and np.isinf(system.problem.wall.hardness)
    states = _stored(result, system) if stored else _again(system)
    for step, (problem, gap) in enumerate(states):
        point = result.points[step]
        if point.converged:
            found = check_state(problem, gap, rounded=stored, seed=step)
            yield PointCertificate(path, step, point, found, system.settings.tolerance, not stored)


def _stored(result: Result, system: RunSetup) -> Iterator[tuple[ContactProblem, Real]]:
    for step, point in enumerate(result.points):
        gap = result.gap(step)
        assert gap is not None
        yield system.at_work(point.work_of_adhesion), gap


def _again(system: RunSetup) -> Iterator[tuple[ContactProblem, Real]]:
    solver = solver_of(system.problem, system.settings)
    for problem, state in states_of(system, Record(fields=False), solver):
        yield problem, state.gap
