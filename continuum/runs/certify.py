"""A stored run certified: its numbers beside those of its states, evaluated by other means."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from continuum.files.hdf5 import StoreError
from continuum.measure.certificate import NO_TRACTION, StateCheck, check_state
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import solver_of
from continuum.runs.build import RunSetup, build
from continuum.runs.record import Point, Record
from continuum.runs.result import Result
from continuum.runs.run import states_of

ENOUGH = 1.5
"""Residuals may exceed tolerance and rounding by so much, as differences see a kink of the law not as the law does:
1.3 was seen."""


@dataclass(frozen=True)
class PointCertificate:
    """One point of a stored run, and what its state says."""

    path: Path
    step: int
    point: Point
    found: StateCheck
    tolerance: float
    """Tolerance of the run, in E*."""
    again: bool
    """Whether the state was not stored, and was computed again."""

    @property
    def allowed(self) -> float:
        """Largest residual, and difference of loads, in E*."""
        return ENOUGH * (self.tolerance + self.found.rounding)

    @property
    def faults(self) -> tuple[str, ...]:
        """What does not agree, in words; none for a sound point."""
        here, found, allowed = self.point, self.found, self.allowed
        faults = []
        if not found.residual <= allowed:
            faults.append(f"the residual is {found.residual:.2e} E*, above {allowed:.2e} E*")
        if abs(found.area_rep - here.area_rep) > found.uncertain_area + 1e-12:
            faults.append(f"A_rep/A0 is {found.area_rep:.6g}, and {here.area_rep:.6g} is stored")
        if abs(found.load - here.load) > allowed:
            faults.append(f"N/A0 is {found.load:.6e} E*, and {here.load:.6e} E* is stored")
        if found.curvature <= 0:
            faults.append("the energy falls along a displacement: a saddle")
        return tuple(faults)


def certify_run(path: Path) -> Iterator[PointCertificate]:
    """Certify each converged point of a stored run, one after the other.

    Gaps are those of the file where it holds them, in single precision; otherwise the path is followed again, and its
    gaps are those of the solver, while what is compared with is stored.

    Raises StoreError if the file is no finished run, or the files that its input names are gone.
    """
    result = Result.read(path)
    if not result.finished:
        raise StoreError(f"{path}: is not finished: run it again, then certify it")
    config = result.config
    try:
        system = build(config)
    except (OSError, ValueError) as error:
        raise StoreError(f"{path}: its surface or wall cannot be made again: {error}") from error
    if system.problem.open_boundary is not None and system.problem.wall.law is None:
        raise StoreError(f"{path}: cannot be certified: {NO_TRACTION}")
    # Of gaps on the way to an imprint the heights are not stored.
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
