"""The numbers of a finished system, one row for each point of its path, for tables and figures."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from continuum.measure.contact import MEASURED, Curve, measure, normal_stiffness
from continuum.measure.outline import Mask, patches
from continuum.model.fourier import Real
from continuum.solve.tangent import tangent_stiffness
from continuum.store import datasets as store
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import StoreError, understood
from continuum.store.provenance import made_by
from continuum.store.runs.build import RunSetup, build
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point, Record
from continuum.store.runs.result import Result, profile_outside
from continuum.store.runs.run import Made

_SYSTEM = {
    "rms_height": ("a0", "h_rms of the realised surface"),
    "rms_slope": ("1", "h'_rms of the realised surface"),
    "rms_curvature": ("1/a0", "h''_rms of the realised surface"),
    "range": ("a0", "range of the attraction, Δr"),
    "effective_range": ("a0", "effective range of the attraction, Eq. (S-5)"),
}
_POINT = {
    c.name: (c.metadata["units"], c.metadata["long_name"]) for c in dataclasses.fields(Point) if c.type is not str
}
_ADDED = {
    "step": ("1", "point of the path"),
    "converged": ("1", "1 if the point is an equilibrium at its target"),
    "retracting": ("1", "1 on retraction, 0 on approach"),
    "stiffness": ("E*/a0", "normal stiffness k_N = -dN/d(mean gap) per A0, between points of the path"),
    "tangent_stiffness": ("E*/a0", "tangent stiffness of the equilibrium; with stored fields, not under a hard wall"),
    "patches": ("1", "connected patches of A_rep"),
    "width": ("a0", "d_att, width of the attracted rim, where the gap reaches the range; with stored fields"),
}
COLUMNS: Mapping[str, tuple[str, str]] = {**_ADDED, **_POINT, **MEASURED, **_SYSTEM}
"""Columns of the table of a system: unit and description."""
MEASURED_TABLE = "measured"
"""Dataset of the table of a system."""


@dataclass(frozen=True, eq=False, slots=True)
class SystemTable:
    """The table of a system, with its time and version."""

    table: Real
    """One row for each point, one column for each of :data:`COLUMNS`."""
    seconds: float
    """Wall time of the system."""
    made: str
    """Version and commit of the program."""
    own: Mapping[str, Real] = field(default_factory=dict)
    """Columns of one's own, a value for each point."""

    def __getitem__(self, name: str) -> Real:
        """A column, a value for each point."""
        return self.own[name] if name in self.own else self.table[:, list(COLUMNS).index(name)]


def numbers_of(path: Path, key: str | None = None) -> SystemTable:
    """The numbers of a finished system, of the identity ``key`` if one is given; little else of its file is read.

    Raises StoreError if the file is missing, damaged, or not that of this system.
    """
    names = ("schema", "schema_version", "identity", "finished", "journal/total_seconds",
             "provenance/stickiness", "provenance/git_commit", "provenance/git_dirty")  # fmt: skip
    datasets, found = store.read_few(path, (MEASURED_TABLE, "quantity"), names)
    schema = found.get("schema"), found.get("schema_version")
    if schema != (RunConfig.result_schema, RunConfig.result_version):
        msg = f"{path}: holds {schema[0]} version {schema[1]}, expected {RunConfig.result_schema}"
        raise StoreError(f"{msg} version {RunConfig.result_version}")
    if key is not None and found.get("identity") != key:
        raise StoreError(f"{path}: holds another system than its name says")
    if found.get("finished") is not True:
        raise StoreError(f"{path}: is not finished")
    if MEASURED_TABLE not in datasets:  # of `continuum run`
        return SystemTable(_of_a_run(path), float(found.get("journal/total_seconds", np.nan)), made_by(found))
    stored = datasets[MEASURED_TABLE]
    with understood(path):
        table = np.full((len(stored), len(COLUMNS)), np.nan)
        places = {name: i for i, name in enumerate(datasets["quantity"].tolist())}
        for i, name in enumerate(COLUMNS):
            if name in places:
                table[:, i] = stored[:, places[name]]
        seconds = float(found.get("journal/total_seconds", np.nan))
    return SystemTable(table, seconds, made_by(found))


def _of_a_run(path: Path) -> Real:
    """The table of a run that was stored without it."""
    result = Result.read(path)
    try:
        system = build(result.config)
    except (OSError, ValueError) as error:
        raise StoreError(f"{path}: its surface or wall cannot be built again: {error}") from error
    return np.column_stack(list(measured_columns(system, result.points, result.repulsive, result.gap).values()))


def _quantities(system: RunSetup, record: Record) -> Dataset:
    return Dataset(np.array(list(COLUMNS)), ("quantity",), "", "columns of the table of numbers")


def _table(system: RunSetup, record: Record) -> Dataset:
    """One row for each point, one column for each of :data:`COLUMNS`."""
    ny = system.problem.grid.shape[1]
    found = measured_columns(
        system,
        record.points,
        lambda step: store.unpack(record.repulsive[step], ny),
        lambda step: record.gaps[step].astype(np.float64) if record.fields else None,
    )
    table = np.column_stack(list(found.values()))
    return Dataset(table, ("step", "quantity"), "", "numbers of each point: tables are made of them")


def measured_columns(
    system: RunSetup, points: Sequence[Point], repulsive: Callable[[int], Mask], gap_of: Callable[[int], Real | None]
) -> dict[str, Real]:
    """Each of :data:`COLUMNS` of a path, a value for each point.

    Parameters
    ----------
    repulsive : the cells of A_rep of a point.
    gap_of : the gap of a point, as it is stored; None where it is not.
    """
    config, grid, moments = system.config, system.problem.grid, system.problem.moments
    good = [step for step, point in enumerate(points) if point.converged]
    curve = Curve.of([points[step] for step in good])
    stiffness = dict(zip(good, normal_stiffness(curve).tolist(), strict=True))
    response = config.substrate.build().stiffness(grid) if config.substrate.repeats else None
    table = np.full((len(points), len(COLUMNS)), np.nan)
    for step, point in enumerate(points):
        wall = system.at_work(point.work_of_adhesion).wall
        row = {
            **moments._asdict(),
            "range": wall.range,
            "effective_range": wall.effective_range if wall.work_of_adhesion > 0 else 0.0,
            **{name: getattr(point, name) for name in _POINT},
            "step": step,
            "converged": point.converged,
            "retracting": point.branch == "retract",
        }
        if point.converged:
            inside = repulsive(step)
            numbers = measure(grid, point, inside, moments.rms_slope)
            row |= {**numbers.numbers(), "stiffness": stiffness[step], "patches": patches(grid, inside).areas.size}
            gap = gap_of(step)
            if gap is not None and wall.range > 0 and inside.any():
                row["width"] = profile_outside(grid, wall, gap, inside, numbers.diameter).width(wall.range)
            if gap is not None and response is not None and wall.law is not None:
                row["tangent_stiffness"] = tangent_stiffness(grid, response, wall.law, gap, config.solver.shift)
        table[step] = [row.get(name, np.nan) for name in COLUMNS]
    return dict(zip(COLUMNS, table.T, strict=True))


ADDED: Mapping[str, Made] = {"quantity": _quantities, MEASURED_TABLE: _table}
"""The table of numbers, dataset ``measured``, which a sweep stores with each run."""
