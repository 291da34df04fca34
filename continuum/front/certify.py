"""Check whether stored states satisfy the equations, independently of the solver, and what a run says beside them.

Beside its states a run has moments, its wall, its input and the numbers of tables.  Readers show these, too, so that a
certificate makes them anew from the input, and from the stored points and maps, which are checked by themselves.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from continuum.inputs.arguments import count, file_name, function
from continuum.inputs.errors import StickinessError
from continuum.measure.certificate import (
    NO_TRACTION,
    SINGLE,
    Check,
    Examination,
    Found,
    StateCheck,
    check_state,
    minimum,
    moments_of,
    same_text,
)
from continuum.measure.contact import ATTRACTED
from continuum.measure.outline import Mask
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import Control, Search, height, nearness
from continuum.store import datasets as store
from continuum.store.datasets import Attribute
from continuum.store.hdf5 import StoreError, understood
from continuum.store.identity import identity
from continuum.store.runs.build import RunSetup, build
from continuum.store.runs.record import Point, Record
from continuum.store.runs.result import Result
from continuum.store.runs.run import attributes_of, positions_of, states_of
from continuum.store.sheet import Column, Sheet, Shown, quantities
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.measured import COLUMNS, MEASURED_TABLE, measured_columns, numbers_of

EXACT = 1e-12
"""Relative difference of numbers that are the same but for their last digits."""
NEARLY = 1e-9
"""Tolerance of numbers found by other sums or in another version: closed forms replaced integrals to ten digits."""
ITERATED = 1e-5
"""Tolerance of the tangent stiffness, whose solve ends at a residual of 1e-6."""
_READ = frozenset({"schema", "schema_version", "finished", "config_resolved", "quantity"})
"""Attributes without which a file is not read at all, the input, whose hash is the identity, and names of columns."""


@dataclass(frozen=True)
class FileCertificate(Examination):
    """Checks of a file beside its states: of attributes, and of datasets that are not of one point.

    Left out are attributes and datasets, by group.
    """

    path: Path

    @property
    def looked_at(self) -> set[str]:
        """Groups of the attributes and datasets that were looked at."""
        return {check.quantity.partition(":")[0].partition("/")[0] for check in self.checks} | _READ


def certify_file(result: Result, system: RunSetup) -> FileCertificate:
    """Compare what a finished run stores beside its states with its input, its points and its maps."""
    with understood(result.path):
        names = store.read_few(result.path, ("quantity",), ())[0].get("quantity", np.array([])).tolist()
        checks = [*_attributes(result, system), *_datasets(result, system)]
        if names:
            checks += _measured(result, system, names)
    found = FileCertificate(result.path, checks=tuple(checks))
    left_out = {name.partition("/")[0] for name in result.attributes} - found.looked_at
    left_out |= {f"{MEASURED_TABLE}: {name}" for name in COLUMNS if names and name not in names}
    return replace(found, left_out=tuple(sorted(left_out)))


def _attributes(result: Result, system: RunSetup) -> Iterator[Check]:
    """Every attribute that follows from the input; the moments by other sums."""
    record = Record(fields=False, points=list(result.points), events=list(result.events))
    expected: dict[str, Attribute] = {
        **attributes_of(system, identity(result.config)),
        **record.attributes(),
        **{f"realised_{name}": value for name, value in moments_of(system.problem)._asdict().items()},
    }
    for name, value in expected.items():
        # An earlier version may not have stored it, or have had another scale of the tolerance.
        if name in result.attributes and name != "tolerance":
            stored = result.attributes[name]
            if isinstance(value, str) or isinstance(stored, str):
                yield same_text(name, stored, value)
            else:
                yield _of_numbers(name, stored, value, NEARLY)


def _datasets(result: Result, system: RunSetup) -> Iterator[Check]:
    """Positions, heights and knots of the wall, as far as they are stored."""
    axes, problem = positions_of(system), system.problem
    stored = store.read_few(result.path, ("step", "x", "y", "heights", "wall/gap", "wall/traction"), ())[0]
    yield _of_numbers("step", stored["step"], np.arange(len(result.points)), 0.0)
    for name, values in axes.items():
        yield _of_numbers(name, stored[name], values, EXACT)
    if "heights" in stored:
        yield _of_numbers("heights", stored["heights"], problem.heights, 2 * SINGLE)
    for name, values in problem.wall.knots.items():
        yield _of_numbers(f"wall/{name}", stored[f"wall/{name}"], values, EXACT)


def _measured(result: Result, system: RunSetup, names: Sequence[str]) -> Iterator[Check]:
    """The columns of the table of numbers, from the points, their maps and their gaps."""
    twice = sorted({name for name in names if names.count(name) > 1})
    yield same_text("quantity", ", ".join(twice), "")
    found, table = measured_columns(system, result.points, result.repulsive, result.gap), numbers_of(result.path)
    for name in [name for name in found if name in names]:
        allowed = ITERATED if name == "tangent_stiffness" else NEARLY
        yield _of_numbers(f"{MEASURED_TABLE}: {name}", table[name], found[name], allowed)


def _of_numbers(quantity: str, stored: Any, expected: ArrayLike, allowed: float) -> Check:
    """The number that is farthest from what it should be, relative to that or, of an array, to its largest."""
    here, there = np.atleast_1d(np.asarray(stored, dtype=float)), np.atleast_1d(np.asarray(expected, dtype=float))
    if here.shape != there.shape:
        said = f"its shape is {here.shape}, and should be {there.shape}"
        return Check(quantity, np.nan, np.nan, np.inf, 0.0, said)
    if not here.size:
        return Check(quantity, np.nan, np.nan, 0.0, 0.0)
    same = (here == there) | (np.isnan(here) & np.isnan(there))
    with np.errstate(invalid="ignore"):
        off = np.where(same, 0.0, np.abs(here - there))
    off[np.isnan(off)] = np.inf
    worst = int(np.argmax(off))
    scale = float(np.max(np.abs(there), initial=0.0, where=np.isfinite(there)))
    return Check(quantity, float(here.flat[worst]), float(there.flat[worst]), float(off.flat[worst]), allowed * scale)


ENOUGH = 1.5
"""Factor by which residuals may exceed tolerance and rounding, as finite differences smooth a kink of the law: 1.3 was
observed."""


@dataclass(frozen=True)
class PointCertificate(Examination):
    """One point of a stored run, with what was looked at: nothing of a point that is no equilibrium by what is stored.

    Left out are datasets of the file, by group, and "curvature" where the eigenvalue is within its error of zero.
    """

    path: Path
    step: int
    point: Point
    again: bool = False
    """True if the state was computed again, as it was not stored."""


@dataclass(frozen=True)
class Certificate(Shown):
    """Result of checking a run, or a sample of a sweep.

    NaN, and a number that differs by more than its tolerance, is a fault.  Each converged point is compared in these
    numbers, with these tolerances:

    * contact maps, against those of the gap: points whose gap is within rounding of an edge may differ; under a hard
      wall, points that touch with a pressure within rounding of zero;
    * ``area_rep`` and ``area_att``, against points of the stored maps: last digits;
    * ``load``, ``load_rep``, ``load_att``, against differences of the law's energy: softness of the law times the
      rounding of each gap; under a hard wall the residual beside the contact;
    * ``mean_gap``, ``smallest_gap``, ``separation``, against the gap, and load and stiffness of the base: rounding, and
      what the residual does to the mean;
    * ``wall_energy``, ``elastic_energy``, against sums over points: traction times the rounding of each gap;
    * the residual of the gap, against zero: 1.5 times tolerance and rounding;
    * the lowest eigenvalue of the Hessian by LOBPCG (``curvature``; ``lowest_eigenvalue`` where it was asked for): not
      negative; twice its error;
    * ``target`` and the controlled quantity, against the input: last digits; the tolerance of the area, the residual;
    * ``control``, against the input;
    * ``work_of_adhesion``, against the law: last digits, except for stored states of a threshold, whose law is made of
      it.

    Of each file, what follows from its input, its points and their maps:

    * the moments of the heights, by other sums; identity, settings of the path, and the wall;
    * the smallest load of the path, against its points and jumps;
    * positions, heights and knots of the wall, against those made anew;
    * the table of numbers that a sweep collects, column by column.

    It does not look at how a state was reached (``branch``, ``events``, ``lowest_load``, searches), at work and times,
    at stored residual, duality gap and status, at the state for a restart, at the text of the input, or at points that
    did not converge.  It does not tell whether another state should have been reached.  Without periodic images under a
    hard wall, and for load and pressure in full contact under a hard wall, there is nothing to compare with.
    """

    points: tuple[PointCertificate, ...]
    """The points that were looked at."""
    read: int
    """Number of files that were read."""
    unconverged: tuple[str, ...] = ()
    """Points that are no equilibria by what is stored, and were not looked at."""
    refused: tuple[str, ...] = ()
    """Files of a sweep that cannot be certified, and why."""
    files: tuple[FileCertificate, ...] = ()
    """Checks of each file beside its states."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Disagreements, with file and point, and files that cannot be certified; empty if all points agree."""
        found = [f"{one.path}, step {one.step}: {fault}" for one in self.points for fault in one.faults]
        found += [f"{one.path}: {fault}" for one in self.files for fault in one.faults]
        if not self.points:
            found.append(f"nothing was looked at: {self.read} files hold no equilibrium that can be checked")
        return (*found, *self.refused)

    @property
    def ok(self) -> bool:
        """True if something was looked at, and all of it is sound."""
        return not self.faults

    def sheets(self) -> list[Sheet]:
        """One row for each point, and one for each quantity."""
        return [self.sheet(), quantities([*self.points, *self.files])]

    def sheet(self) -> Sheet:
        """One row for each point."""
        columns = (
            Column("file"), Column("step"), Column("A_rep/A0"), Column("N/A0", "E*", ".4e"),
            Column("residual", "E*", ".2e"), Column("lowest eigenvalue", "E*/a0", ".3g"), Column("checks"), Column(""),
        )  # fmt: skip
        rows = [
            (one.path.stem, one.step, one.point.area_rep, one.point.load, one.found_of("recomputed residual"),
             one.found_of("curvature"), len(one.checks), "; ".join(one.faults) or "sound")
            for one in self.points
        ]  # fmt: skip
        again = "; states were computed again, as the files hold no gaps" if any(p.again for p in self.points) else ""
        states = len(self.points) + len(self.unconverged)
        title = (
            f"{len(self.points)} of {states} states of {self.read} files, checked independently of the solver{again}"
        )
        notes = [f"not looked at: {one}" for one in self.unconverged]
        return Sheet.of(title, columns, rows, "\n".join(notes))


def certify(
    path: str | Path,
    *,
    sample: int = 3,
    seed: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Certificate:
    """Recompute stored states with other transforms, sums and derivatives than the solver's, and compare.

    All numbers follow from heights and gap alone; the lowest eigenvalue of the Hessian tells a minimum from a saddle.
    Runs that store fields are checked from these; other runs are computed again and compared.  A system of a sweep that
    cannot be certified is named, and the others are checked.

    Parameters
    ----------
    path : a stored run, or the folder of a sweep.
    sample : number of systems of a sweep to check, drawn at random.
    seed : seed of the random draw.
    progress : called after each file with how many are done and how many there are.

    Raises
    ------
    StoreError
        If a file is not a finished run, or a file that its input names is missing.
    SweepError
        If the folder is no sweep.
    ArgumentError
        If an argument is not allowed.

    Examples
    --------
    >>> import continuum as c
    >>> path = c.run("inputs/smoke/hard.toml", settings={"grid.n": 64}).path
    >>> c.certify(path).ok  # recomputed by independent code
    True
    """
    given = file_name("path", path)
    count("sample", sample)
    count("seed", seed, least=0)
    function("progress", progress)
    files = _sample(given, sample, seed) if given.is_dir() else [given]
    points, unconverged, refused, whole = list[PointCertificate](), list[str](), list[str](), list[FileCertificate]()
    for done, file in enumerate(files, 1):
        try:
            result, system = _finished(file)
            whole.append(certify_file(result, system))
            for found in certify_run(result, system, whole[-1].looked_at):
                if found.checks:
                    points.append(found)
                else:
                    unconverged.append(f"{file}, step {found.step}: {found.point.meaning}")
        except StickinessError as error:
            if not given.is_dir():
                raise
            refused.append(str(error))
        if progress is not None:
            progress(done, len(files))
    return Certificate(tuple(points), len(files), tuple(unconverged), tuple(refused), tuple(whole))


def _sample(root: Path, sample: int, seed: int) -> list[Path]:
    folder, listing = Folder(root), systems_of(root)
    done = [path for system in listing.systems if (path := folder.point(system.key)).is_file()]
    if not done:
        raise StoreError(f"{root}: no system of this sweep is done")
    chosen = np.random.default_rng(seed).choice(len(done), min(sample, len(done)), replace=False)
    return [done[i] for i in sorted(chosen)]


def _finished(path: Path) -> tuple[Result, RunSetup]:
    """A finished run and its contact; StoreError if it is none, or the files that its input names are gone."""
    result = Result.read(path)
    if not (result.finished and len(result.points) == result.config.loading.points):
        raise StoreError(f"{path}: is not finished: run it again, then certify it")
    try:
        system = build(result.config)
    except (OSError, ValueError) as error:
        raise StoreError(f"{path}: its surface or wall cannot be built again: {error}") from error
    if system.problem.open_boundary is not None and system.problem.wall.law is None:
        raise StoreError(f"{path}: cannot be certified: {NO_TRACTION}")
    return result, system


def certify_run(result: Result, system: RunSetup, beside: Set[str]) -> Iterator[PointCertificate]:
    """Check each converged point of a finished run; other points have no checks.

    Gaps come from the file if it has them (in single precision); otherwise the path is computed again, and its gaps
    are compared with the stored numbers.  ``beside`` are the datasets that were looked at in the file as a whole.
    """
    path, loading = result.path, result.config.loading
    # The heights of an intermediate imprint are not stored.
    stored = result.gap(0) is not None and np.isinf(system.problem.wall.hardness)
    names = {name.partition("/")[0] for name in store.dataset_names(path)} - beside
    if system.problem.wall.law is not None:  # else the energy is convex
        names.add("curvature")
    states = _stored(result, system) if stored else _again(result, system)
    for step, (point, aim, (problem, gap, missed)) in enumerate(zip(result.points, loading.aims, states, strict=True)):
        if not point.converged:
            yield PointCertificate(path, step, point)
            continue
        held = {"mean-gap": np.inf, "mean-pressure": 0.0}
        mean = held.get(nearness(problem) if aim[0] == "repulsive-area" else aim[0])
        found = check_state(problem, gap, rounded=stored, mean_stiffness=mean, missed=missed)
        if not stored or loading.threshold is None:  # else the law is made of it, and a wrong one leaves a residual
            found.numbers["work_of_adhesion"] = Found(problem.wall.work_of_adhesion, EXACT)
        maps = {"repulsive": result.repulsive(step), "attracted": result.contact_map(step) % 2 == ATTRACTED}
        allowed = ENOUGH * (system.settings.tolerance + found.rounding)
        checks = tuple(_checks(problem, point, aim, maps, found, allowed))
        looked_at = {check.quantity for check in checks} | ({"gap"} if stored else set())
        left_out = tuple(sorted(names - looked_at))
        yield PointCertificate(path, step, point, not stored, checks=checks, left_out=left_out)


_Aim = tuple[Control, float, Search]
"""Target of a point as the input has it: control, value, and search."""


def _checks(
    problem: ContactProblem, point: Point, aim: _Aim, maps: Mapping[str, Mask], found: StateCheck, allowed: float
) -> Iterator[Check]:
    """Every quantity that follows from the gap, or from the input; ``allowed`` is the largest residual, in E*."""
    numbers, boundary = dict(found.numbers), problem.open_boundary
    k = problem.mean_stiffness if boundary is None else boundary.mean_stiffness
    if "separation" in numbers:  # where the mean displacement carries what is left of the mean traction
        value, error = numbers["separation"]
        numbers["separation"] = Found(value, error + allowed / k)
    areas = {"area_rep": "repulsive", "area_att": "attracted"}
    numbers |= {name: Found(float(maps[kind].mean()), EXACT) for name, kind in areas.items()}
    for name, (value, error) in numbers.items():
        stored = getattr(point, name)
        if name != "lowest_eigenvalue" or not np.isnan(stored):  # which is not always asked for
            yield Check(name, stored, value, abs(value - stored), error)
    for name, (where, unsure) in found.maps.items():
        differ = float(np.mean((where ^ maps[name]) & ~unsure))
        yield Check(name, float(maps[name].mean()), float(where.mean()), differ, 0.0)
    yield Check("recomputed residual", np.nan, found.residual, found.residual, allowed, "too large for an equilibrium")
    if found.lowest is not None and not abs(found.lowest.value) <= found.lowest.error:
        yield minimum(found.lowest.value)
    yield same_text("control", point.control, aim[0])
    target = aim[1]
    yield Check("target", point.target, target, abs(point.target - target), EXACT * abs(target))
    yield from _at_its_target(aim, numbers, problem.grid.size, allowed)


def _at_its_target(aim: _Aim, numbers: Mapping[str, Found], size: int, allowed: float) -> Iterator[Check]:
    """True if a state is where the input asks for it, if that follows from its gap."""
    control, target, search = aim
    name = {"mean-gap": "mean_gap", "mean-pressure": "load", "repulsive-area": "area_rep"}.get(control, control)
    if name in numbers:
        value, error = numbers[name]
        beyond = {
            "mean-pressure": allowed,
            "repulsive-area": max(search.area_tolerance * min(target, 1 - target), 0.5 / size),
        }
        yield Check(f"{control} asked for", target, value, abs(value - target), error + beyond.get(control, 0.0))


def _stored(result: Result, system: RunSetup) -> Iterator[tuple[ContactProblem, Real, float]]:
    for step, point in enumerate(result.points):
        gap = result.gap(step)
        assert gap is not None
        yield system.at_work(point.work_of_adhesion), gap, 0.0


def _again(result: Result, system: RunSetup) -> Iterator[tuple[ContactProblem, Real, float]]:
    """The states of the path, computed again, and by how much each gap may differ from that of the stored state.

    An area is met within a tolerance, and a search of another version may stop at another state within it.  That is
    solved anew at the stored mean gap, and so differs by what two residuals leave of the longest wave.
    """
    settings, problem = system.settings, system.problem
    solver, searched = solver_of(problem, settings), result.config.loading.threshold is None
    softest = float(problem.stiffness_q[problem.stiffness_q > 0].min(initial=np.inf))
    for (problem, state), point in zip(states_of(system, Record(fields=False), solver), result.points, strict=True):
        at, missed = point.mean_gap if problem.open_boundary is None else point.separation, 0.0
        of_area = searched and point.control == "repulsive-area" and point.converged and state.converged
        if of_area and height(problem, state) != at:
            near = replace(settings, warm_grids=0)
            state = equilibrium(problem, nearness(problem), at, near, state.gap, state.branch, solver)
            missed = 2 * settings.tolerance / softest
        yield problem, state.gap, missed
