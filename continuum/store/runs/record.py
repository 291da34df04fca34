"""The record of a run: numbers and fields of each point, and their form in the result file."""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Self, get_args

import numpy as np
from numpy.typing import NDArray

from continuum.measure.contact import ATTRACTED, REPULSIVE, Equilibrium, Totals, contact_map, quantity, shared
from continuum.model.problem import ContactProblem
from continuum.model.shared_grid import Company
from continuum.path.state import CONTROLS, Branch, Event, JumpSide, Outcome, PathState, numbers
from continuum.solve.solution import Solution, Status, Work
from continuum.solve.solver import Solver
from continuum.store import datasets as store
from continuum.store.datasets import Attribute, Dataset
from continuum.store.sheet import words

if TYPE_CHECKING:
    import pandas

_OF_SOLUTION = ("residual", "duality_gap", "lowest_eigenvalue", "iterations", "fft_pairs", "sweeps")
_TOTALS = tuple(one.name for one in dataclasses.fields(Totals))
_OF_STATE = ("control", "target", "branch", "separation", "mean_gap")
_OF_WORK: Mapping[str, tuple[type, str, str]] = {
    "work/nx": (int, "1", "points along x"),
    "work/ny": (int, "1", "points along y"),
    "work/fft_pairs": (float, "1", "Fourier transforms of this grid, halved"),
    "work/sweeps": (int, "1", "evaluations of the line search"),
    "journal/fft_seconds": (float, "s", "wall time in Fourier transforms"),
}
"""Datasets of the work on each grid: type, unit and description."""
_NUMBERS = {one.name: (one.metadata["units"], one.metadata["long_name"]) for one in dataclasses.fields(Equilibrium)}
_SIDES = {name: _NUMBERS.get(name, ("", "value of the control, in its unit")) for name in JumpSide._fields}
_OF_EVENT: Mapping[str, tuple[type, str, str]] = {
    "events/step": (int, "1", "point on the way to which it was met"),
    **{f"events/{name}": (str, "", f"{name} of the jump") for name in ("kind", "control", "branch")},
    **{
        f"events/{name}_{when}": (float, units, f"{what}; {when} the jump")
        for when in ("before", "after")
        for name, (units, what) in _SIDES.items()
    },
}
"""Datasets of the jumps, in the order of the fields of an event and of its sides."""
EVENT_DATASETS = frozenset(_OF_EVENT)
"""Names of the datasets that hold the jumps."""
JUMPS = "jumps"
"""Attribute with their number, without which a path without jumps could not be told from a damaged file."""
_ENDS: Mapping[str, Status | Outcome] = {**Status.__members__, **Outcome.__members__}
FLAGS = {
    "control": CONTROLS,
    "branch": get_args(Branch),
    "status": tuple(_ENDS),
}
"""Words in datasets of points, in the order of their CF flags; new words are appended."""
XARRAY_NAMES = {"load": "load_net"}
"""Columns whose names are methods of a dataset of xarray, with the names of its variables."""


class StoredMap(NamedTuple):
    """A dataset of the points of the grid."""

    dims: tuple[str, ...]
    units: str
    long_name: str
    packed: bool = False
    """Whether a byte holds eight points along y."""


MAPS = {
    "repulsive": StoredMap(("step", "x", "y"), "1", "repulsive contact", packed=True),
    "attracted": StoredMap(("step", "x", "y"), "1", "attracted area", packed=True),
    "gap": StoredMap(("step", "x", "y"), "a0", "gap"),
    "heights": StoredMap(("x", "y"), "a0", "height of the rigid wall"),
    "imprint": StoredMap(("x", "y"), "a0", "depth of the imprint that the wall keeps"),
}
"""Datasets of the points of the grid in the file of a run; a file need not have each."""


def maps_in(rows: slice) -> dict[str, Any]:
    """For each dataset of the points that a path goes on from, the part that holds some rows."""
    of_points = dict.fromkeys(("repulsive", "attracted", "gap"), (slice(None), rows))
    return {**of_points, "restart/gap": rows, "heights": slice(0)}


_OF_EARLIER_VERSIONS = {"turn": "threshold", "NO_TURN": "NO_THRESHOLD"}
"""Words in files of version 0.1.0, with those of today."""


@dataclass(frozen=True, kw_only=True)
class Point(Equilibrium):
    """Numbers of one point of a path.  Each field is stored as a dataset over ``step``."""

    lowest_load: float = quantity("E*", "smallest load between the previous point and this one")
    lowest_load_mean_gap: float = quantity("a0", "mean gap at the smallest load")
    elastic_energy: float = quantity("E* a0", "elastic energy per area; on a periodic surface without the mean mode")
    residual: float = quantity("E*", "root-mean-square residual traction")
    duality_gap: float = quantity("E* a0", "bound on the error of the energy per area; NaN without a hard wall")
    lowest_eigenvalue: float = quantity("E*/a0", "lowest eigenvalue of the Hessian; NaN if not requested")
    iterations: int = quantity("1", "iterations of the solver")
    fft_pairs: float = quantity("1", "pairs of Fourier transforms on all grids, weighted by their points")
    sweeps: int = quantity("1", "evaluations of the line search on the finest grid")
    search_pairs: float = quantity("1", "pairs of Fourier transforms of the search for the point and for jumps")
    search_solves: int = quantity("1", "equilibria of the search for the point and for jumps")
    status: str = quantity("", "how the solve ended")

    @classmethod
    def of(cls, problem: ContactProblem, state: PathState, solver: Solver) -> Self:
        solution, lowest = state.solution, state.lowest or (state.load, state.mean_gap)
        pulled_off = state.outcome is Outcome.PULLED_OFF
        return cls(
            **shared(Equilibrium, state),
            **{name: getattr(solution, name) for name in _OF_SOLUTION},
            lowest_load=lowest[0],
            lowest_load_mean_gap=lowest[1],
            elastic_energy=0.0 if pulled_off else solver.elastic_energy(problem.heights, state.solution),
            search_pairs=state.search_pairs,
            search_solves=state.search_solves,
            status=state.status.name,
        )

    @property
    def converged(self) -> bool:
        """Whether the point is an equilibrium."""
        return self.status == Status.CONVERGED.name

    def line(self, seconds: float) -> str:
        """The line of its progress, with the seconds that it took."""
        place = f"mean gap {self.mean_gap:.4g} a0, separation {self.separation:.4g} a0, A_rep {self.area_rep:.4g}"
        search = f" and {self.search_pairs:.0f} in the search" if self.search_pairs else ""
        work = f"residual {self.residual:.1e}, FFT pairs {self.fft_pairs:.0f}{search}, {seconds:.1f} s"
        return f"{place}, N {self.load:.4g} E*, {work}, {words(self.status)}"

    @property
    def meaning(self) -> str:
        """How the solve or the search ended, in words."""
        return _ENDS[self.status].value


class PathEvent(NamedTuple):
    """A jump, and the point of the path that it precedes."""

    step: int
    event: Event


@dataclass
class Record:
    """The points so far; the only mutable object of a run."""

    fields: bool
    """Whether gaps are stored."""
    points: list[Point] = field(default_factory=list)
    events: list[PathEvent] = field(default_factory=list)
    repulsive: list[NDArray[np.uint8]] = field(default_factory=list)
    attracted: list[NDArray[np.uint8]] = field(default_factory=list)
    gaps: list[NDArray[np.float32]] = field(default_factory=list)
    work: list[tuple[Work, ...]] = field(default_factory=list)
    seconds: list[tuple[float, float]] = field(default_factory=list)
    """Seconds of the solve of each point, and of the whole point with its search and the writing."""
    grown_from: str = ""
    """Identity of the stored run whose points this one begins with; empty if there is none."""
    company: Company | None = None
    """The processes that have the points of the grid together, each some rows of all fields; None where one has all."""
    good: list[PathState] = field(default_factory=list)
    """The states that the next point starts from, updated by :func:`continuum.path.loading.follow`."""

    def append(self, problem: ContactProblem, state: PathState, solver: Solver) -> None:
        """Add a point of the path; the elastic energy is computed with the arrays of the solver."""
        self.points.append(Point.of(problem, state, solver))
        self.events += [PathEvent(len(self.points) - 1, event) for event in state.events]
        repulsive, attracted = _contact(problem, state)
        self.repulsive.append(repulsive)
        self.attracted.append(attracted)
        if self.fields:
            self.gaps.append(state.gap.astype(np.float32))
        self.work.append(state.solution.work)

    def beginning(self, points: int, good: list[PathState]) -> Self:
        """The record after the first points, with the states that the next one starts from."""
        events = [passed for passed in self.events if passed.step < points]
        of_points = ("points", "repulsive", "attracted", "gaps", "work", "seconds")
        first = {name: getattr(self, name)[:points] for name in of_points}
        return replace(self, events=events, good=good, **first)

    def datasets(self, *, restart: bool) -> dict[str, Dataset]:
        """Datasets of the record; with ``restart`` also the state that the next point starts from."""
        datasets = {
            "step": Dataset(np.arange(len(self.points)), ("step",), "1", "point of the path"),
            "repulsive": self._masks(self.repulsive, "repulsive contact"),
            "attracted": self._masks(self.attracted, "attracted area"),
            "journal/seconds": _times(self.seconds, 1, "wall time of the point, with its search"),
            "journal/solve_seconds": _times(self.seconds, 0, "wall time of the solve of the point itself"),
            **store.columns(self.points, "step"),
        }
        # Of solves on one grid alone, columns of the points have all that these datasets would.
        if not all(map(_said_by, self.points, self.work)):
            datasets |= self._work()
        if self.events:
            datasets |= self._events()
        if self.fields:
            datasets["gap"] = Dataset(self.rows(np.array(self.gaps)), ("step", "x", "y"), "a0", "gap")
        if self.good and self.good[-1].imprint is not None:
            what = "depth of the imprint that the wall keeps, to which later heights are raised"
            kind = np.float64 if restart else np.float32  # in full where a path goes on from it
            datasets["imprint"] = Dataset(self.good[-1].imprint.astype(kind), ("x", "y"), "a0", what)
        if restart and self.good:
            for name in _OF_STATE:
                values = np.array([getattr(state, name) for state in self.good])
                units, what = _NUMBERS[name]
                datasets[f"restart/{name}"] = Dataset(values, ("restart_point",), units, f"of the states: {what}")
            values = np.array([state.solution.residual for state in self.good])
            datasets["restart/residual"] = Dataset(values, ("restart_point",), "E*", "residual of the states")
            values = np.array([[*shared(Totals, state).values()] for state in self.good])
            what = f"of the states, in their units: {', '.join(_TOTALS)}"
            datasets["restart/contact"] = Dataset(values, ("restart_point", "restart_number"), "", what)
            gap = np.maximum(self.good[-1].gap, 0.0) if "imprint" in datasets else self.good[-1].gap
            what = "gap of the last of these, the start of the next"
            datasets["restart/gap"] = Dataset(self.rows(gap), ("x", "y"), "a0", what)
        return datasets

    def rows(self, values: NDArray[Any]) -> NDArray[Any] | store.DividedArray:
        """Values of a dataset of the points of the grid, from those of this process."""
        return values if self.company is None else store.DividedArray(values, self.company)

    def _masks(self, masks: list[NDArray[np.uint8]], name: str) -> Dataset:
        what = f"{name}, eight points along y in a byte, first in its highest bit"
        return Dataset(self.rows(np.array(masks)), ("step", "x", "y_byte"), "1", what)

    def _work(self) -> dict[str, Dataset]:
        """Work on each grid, the finest first; zeros where a solve used fewer grids."""
        depth = max((len(work) for work in self.work), default=0)
        empty = Work((0, 0), 0.0, 0, 0.0)
        rows = [[(*shape, *rest) for shape, *rest in [*work, *[empty] * (depth - len(work))]] for work in self.work]
        table = np.array(rows, dtype=float).reshape(len(rows), depth, len(_OF_WORK))
        return {
            name: Dataset(table[..., i].astype(kind), ("step", "level"), units, what)
            for i, (name, (kind, units, what)) in enumerate(_OF_WORK.items())
        }

    def _events(self) -> dict[str, Dataset]:
        rows = [(step, e.kind, e.control, e.branch, *e.before, *e.after) for step, e in self.events]
        columns = list(zip(*rows, strict=True)) or [()] * len(_OF_EVENT)
        return {
            name: Dataset(np.array(values, dtype=kind), ("event",), units, what)
            for (name, (kind, units, what)), values in zip(_OF_EVENT.items(), columns, strict=True)
        }

    def attributes(self) -> dict[str, Attribute]:
        """The number of jumps, and the largest tension among the equilibria of the path and those beside its jumps."""
        jumps: dict[str, Attribute] = {JUMPS: len(self.events)}
        loads = [(p.lowest_load, p.lowest_load_mean_gap, p.branch) for p in self.points if p.converged]
        for _, event in self.events:
            loads += [(side.load, side.mean_gap, event.branch) for side in (event.before, event.after)]
        if not loads:
            return jumps
        load, mean_gap, branch = min(loads)
        return {**jumps, "smallest_load": load, "smallest_load_mean_gap": mean_gap, "smallest_load_branch": branch}

    @classmethod
    def restored(cls, file: store.File, *, fields: bool) -> Self:
        points = points_of(file)
        record = cls(
            fields,
            points=list(points),
            events=list(events_of(file)),
            repulsive=list(file["repulsive"]),
            attracted=list(file["attracted"]),
            gaps=list(file["gap"]) if fields else [],
            work=list(_work_in(file, points)),
            seconds=list(zip(file["journal/solve_seconds"].tolist(), file["journal/seconds"].tolist(), strict=True)),
            grown_from=str(file.attributes.get("journal/grown_from", "")),
        )
        if "restart/gap" in file.datasets:
            rows = zip(*(file[f"restart/{name}"].tolist() for name in (*_OF_STATE, "residual", "contact")), strict=True)
            for *of_state, residual, contact in rows:
                solution = Solution(file["restart/gap"], Status.CONVERGED, residual, 0)
                named = zip((*_OF_STATE, *_TOTALS), (*of_state, *contact), strict=True)
                state = PathState(**dict(named), solution=solution)
                record.good = [*map(numbers, record.good), state]
            if record.good and "imprint" in file.datasets:
                # The state after the last one, whose gap is restored as it was.
                record.good[-1] = replace(record.good[-1], imprint_before=file["imprint"])
        return record


_ROWS = 256


def points_of(file: store.File) -> tuple[Point, ...]:
    """The points in a file; raises ValueError if it does not hold what a run stores."""
    known = dataclasses.fields(Point)
    # Files of earlier versions have one work of adhesion, that of their wall, and lack columns that came later.
    lacking = {one.name: one.default for one in known if one.default is not dataclasses.MISSING}
    lacking |= {"work_of_adhesion": file.attributes.get("work_of_adhesion", np.nan)}
    columns = {
        one.name: [lacking[one.name]] * len(file["step"])
        if one.name in lacking and one.name not in file.datasets
        else _column(file, one.name, one.type)
        for one in known
    }
    rows = zip(*columns.values(), strict=True)
    return tuple(Point(**dict(zip(columns, row, strict=True))) for row in rows)


def _said_by(point: Point, work: tuple[Work, ...]) -> bool:
    """Whether the numbers of a point say its work, as where it was solved on one grid only."""
    return [one[1:3] for one in work] == ([(point.fft_pairs, point.sweeps)] if point.fft_pairs else [])


def _work_in(file: store.File, points: Sequence[Point]) -> Iterator[tuple[Work, ...]]:
    """The work on each grid, of each point."""
    if not any(name.startswith("work/") for name in file.datasets):
        shape = file["x"].size, file["y"].size
        yield from ((Work(shape, p.fft_pairs, p.sweeps, np.nan),) if p.fft_pairs else () for p in points)
        return
    for step in zip(*(file[name].tolist() for name in _OF_WORK), strict=True):
        yield tuple(Work((nx, ny), *rest) for nx, ny, *rest in zip(*step, strict=True) if nx)


def events_of(file: store.File) -> tuple[PathEvent, ...]:
    """The jumps in a file; raises ValueError if it does not hold what a run stores."""
    if file.attributes.get(JUMPS) == 0:
        return ()
    rows = zip(*(_column(file, name, kind) for name, (kind, _, _) in _OF_EVENT.items()), strict=True)
    n = len(_SIDES)
    return tuple(
        PathEvent(step, Event(kind, control, branch, JumpSide(*sides[:n]), JumpSide(*sides[n:])))
        for step, kind, control, branch, *sides in rows
    )


def _column(file: store.File, name: str, kind: object) -> list[Any]:
    values = file[name]
    if values.ndim != 1 or (values.dtype.kind == "U") != (kind is str):
        raise ValueError(f"{name} is no column of {'words' if kind is str else 'numbers'}")
    found: list[Any] = [_OF_EARLIER_VERSIONS.get(value, value) for value in values.tolist()]
    if unknown := set(found).difference(FLAGS.get(name, found)):
        raise ValueError(f"{name} is {unknown.pop()!r}")
    return found


def _contact(problem: ContactProblem, state: PathState) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Packed masks of the repulsive and of the attracted area, computed row by row, since a grid may be large."""
    rows = range(0, state.gap.shape[0], _ROWS)
    kinds = (contact_map(problem.wall, state.gap[row : row + _ROWS]) for row in rows)
    masks = [(store.pack(kind == REPULSIVE), store.pack(kind == ATTRACTED)) for kind in kinds]
    repulsive, attracted = (np.concatenate(parts) for parts in zip(*masks, strict=True))
    return repulsive, attracted


def _times(seconds: list[tuple[float, float]], column: int, what: str) -> Dataset:
    return Dataset(np.array([times[column] for times in seconds], dtype=float), ("step",), "s", what)


def frame_of(points: Sequence[Any], kind: type) -> "pandas.DataFrame":
    """One row for each point, with the stored fields of a class that all have, and ``status``.

    ``attrs["units"]`` has the unit of each column.
    """
    import pandas  # takes half a second

    columns = [one for one in dataclasses.fields(kind) if one.metadata and one.name != "status"]
    rows = [[*(getattr(point, one.name) for one in columns), _status(point)] for point in points]
    frame = pandas.DataFrame(rows, columns=[*(one.name for one in columns), "status"])
    frame.index.name = "step"
    frame.attrs["units"] = {one.name: one.metadata["units"] for one in columns}
    return frame


def _status(point: Any) -> str:
    """The word of the status, of a point of a file and of a state alike."""
    return str(getattr(point.status, "name", point.status))
