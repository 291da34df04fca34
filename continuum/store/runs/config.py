"""The input of a continuum run: the loading path, walls and surfaces read from files, the whole file, and its cost.

Of the cost an input says the memory, the number of its states, and the points of its grid.  How long it takes depends
on the contact; that is measured (:mod:`continuum.store.sweeps.status`).
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import itemgetter
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic_core import PydanticCustomError

from continuum.inputs.arguments import choice
from continuum.inputs.keys import Fraction, InputFile
from continuum.inputs.tables import Description, Fault, Table, constraint
from continuum.inputs.toml import Document
from continuum.model import surfaces as surfaces
from continuum.model.fourier import Real
from continuum.model.grid import Grid, GridTable
from continuum.model.substrates import Response
from continuum.model.substrates.non_periodic import NO_LINE
from continuum.model.surface import Counterface, Surface
from continuum.model.walls import TabulatedWall, Wall
from continuum.path.state import YIELDS, Control, Search
from continuum.solve.backend import BACK_ENDS, BOUND_FIELDS, SHARDED, SMOOTH_FIELDS
from continuum.solve.solution import LOOSEST, MOST_SHARDS, MOST_THREADS, Settings
from continuum.store.heights import HDF5_SUFFIXES, read_map, stands_for_nothing
from continuum.store.text import read_text

MOST = 1_000_000
"""Largest number of values of a range, and of systems of a sweep."""
_HUGE = 1e150  # numbers whose differences and ratios are numbers, too
_List = Annotated[tuple[float, ...], Field(min_length=1, max_length=100_000)]
_Range = dict[Literal["from", "to", "step", "factor", "count"], float]
# Upper bounds of one solve in a fresh process, in bytes; the largest resident size was measured.
LIBRARIES = 2.5e8
"""Imports take 186 MiB, compiled code and small grids 25 to 35 MiB."""
UNDER_A_LAW = 90
"""Of a point of the grid: 73 at 0.7 % of the area and 88 at 8 % (4096²), 88 at 20 % (2048²)."""
UNDER_A_HARD_WALL = 115
"""Of a point of the grid: 82 at 0.9 % of the area (4096²), 114 at 20 % (2048²)."""
ON_A_DEVICE = 1e9
"""Of a process on a GPU beside its fields, for context and kernels: four grids took less (docs/studies/gpu.md)."""


class TableWall(Wall, kind="table"):
    """[wall] of law "table"."""

    path: InputFile
    """text, two columns: gap in a0 (increasing) and traction in E* (compression positive, zero at the end)"""

    def build(self) -> Wall:
        """The law; raises ValueError or OSError if the file is not a table of a wall."""
        columns = read_text(self.path).rows
        if columns.shape[1] != 2:
            raise ValueError(f"{self.path} has {columns.shape[1]} columns, a wall has 2: gap and traction")
        return TabulatedWall(columns[:, 0], columns[:, 1])

    def restored(self, stored: Mapping[str, Any]) -> Wall:
        return TabulatedWall(stored["gap"], stored["traction"])


class FileSurface(Surface, kind="file"):
    """[surface] of kind "file": heights from a file."""

    path: InputFile
    """heights in a0, one number per point of the grid: .npy, .h5/.hdf5 (first index x), or text (x along a line)"""
    dataset: str | None = None
    """name of the dataset in an HDF5 file"""

    @constraint
    def _dataset(self) -> Iterator[Fault]:
        hdf5 = self.path.suffix.lower() in HDF5_SUFFIXES
        if hdf5 and self.dataset is None:
            yield Fault(("dataset",), "the name of a dataset, which an HDF5 file needs")
        if not hdf5 and self.dataset is not None:
            yield Fault(("dataset",), f"only with an HDF5 file ({', '.join(sorted(HDF5_SUFFIXES))})")

    def build(self, grid: Grid) -> Real:
        """The heights; raises ValueError or OSError unless the file has finite numbers of the grid's shape."""
        found = read_map(self.path, self.dataset, grid.shape)
        for what, its in (("size", found.size), ("unit", found.unit)):
            if its is not None:
                raise ValueError(
                    f"{self.path}: the file itself says the {what} of the map in real units, and heights of a run are "
                    "in a0: divide by a0, and leave it out of the file"
                )
        if found.extent is not None and not np.allclose(found.extent, grid.lengths, rtol=1e-3, atol=0):
            extent = " x ".join(f"{length:.6g}" for length in found.extent)
            raise ValueError(f"{self.path}: the positions in the file are those of {extent}, not of the period, in a0")
        heights = found.heights
        missing = np.count_nonzero(~np.isfinite(heights))
        if missing:
            raise ValueError(f"{missing} of the {heights.size} heights in {self.path} are not finite numbers")
        if asked := stands_for_nothing(heights):
            raise ValueError(f"{self.path}: {asked[1]} heights are {asked[0]:.10g}, far from all others: missing?")
        return heights if heights.shape == grid.shape_here else heights[grid.rows]


def _device(value: str) -> str:
    if value not in BACK_ENDS:
        allowed = "one of " + ", ".join(f'"{name}"' for name in BACK_ENDS)
        raise PydanticCustomError("device", "{allowed}", {"allowed": allowed})
    return value


class ToleranceTable(Description):
    """The tolerance of a solution."""

    tolerance: Annotated[float, Field(gt=0, le=LOOSEST)] = 1e-6
    """largest root-mean-square residual traction, relative to h'rms E*; 0.01 leaves errors of a few percent"""

    def build(self, scale: float) -> Settings:
        """Settings of the solver, with tolerances relative to ``ContactProblem.traction_scale``."""
        keys = {name: value for name, value in self if name in Settings.__dataclass_fields__}
        return Settings(**keys | {"tolerance": self.tolerance * scale})


class SolverTable(ToleranceTable):
    """[solver]: tolerance, iterations, threads and device."""

    not_identity: ClassVar[frozenset[str]] = frozenset({"threads", "shards"})

    max_iterations: Annotated[int, Field(ge=1, le=10**9)] = 5000
    """number of iterations after which a point counts as not converged"""
    shift: Annotated[float, Field(gt=0, le=100)] = 0.01
    """c0 of the preconditioner 1/(K + c0) of long waves, in E* over the spacing of the grid; 0.001 - 0.03 are equally
    good"""
    threads: Annotated[int, Field(ge=1, le=MOST_THREADS)] = 1
    """threads of the solver; they do not change results"""
    stability: bool = False
    """whether to compute the lowest eigenvalue of the Hessian of each point, except under a hard wall, in one or two
    hundred FFT pairs; a saddle point then counts as not converged"""
    device: Annotated[str, AfterValidator(_device)] = "cpu"
    """device of the solver: "cpu", compiled loops on processor cores; a library of arrays, "numpy", "torch",
    "torch:cuda", "cupy", "jax"; or "cuda", the first of PyTorch, CuPy and JAX that sees a GPU. Two devices give the
    same results up to rounding, but may find different equilibria if there are several; results are stored apart"""
    shards: Annotated[int, Field(ge=1, le=MOST_SHARDS)] = 1
    """number of devices among which "jax" divides the points: GPUs, or parts of a processor. It must divide the number
    of points along x. Results agree up to rounding"""

    @constraint
    def _device_of_shards(self) -> Iterator[Fault]:
        if self.shards > 1 and self.device != SHARDED:
            yield Fault(("device",), f'"{SHARDED}" where shards is above 1', "only JAX divides the points")


def expand_range(given: Any) -> tuple[Any, ...]:
    """The values of a list, or of a range ``{from, to, step | factor | count}``, its end included.

    Raises ValueError if it is neither a list nor a range.
    """
    if isinstance(given, (tuple, list)):
        return tuple(given)
    if not isinstance(given, Mapping):
        raise ValueError(f"not {given!r}")
    steps = [name for name in ("step", "factor", "count") if name in given]
    numbers: list[Any] = [given.get(name) for name in ("from", "to", *steps)]
    if len(steps) != 1 or len(given) != 3 or not all(type(n) in (int, float) and abs(n) < _HUGE for n in numbers):
        raise ValueError("from and to, and one of step, factor and count, all of them numbers")
    first, last, by = numbers
    if steps == ["count"]:
        if type(by) is not int or by < 2:
            raise ValueError("count is a whole number from 2 on")
        return tuple(first + (last - first) * i / (by - 1) for i in range(_enough(by - 1)))
    # Rounded up a little: a decimal step may miss its end by the last digit.
    if steps == ["step"] and by * (last - first) > 0:
        return tuple(first + i * by for i in range(_enough((last - first) / by)))
    if steps == ["factor"] and by > 0 and first * last > 0 and by != 1 and math.log(last / first) / math.log(by) >= 0:
        return tuple(first * by**i for i in range(_enough(math.log(last / first) / math.log(by))))
    raise ValueError("a step or factor that leads from the first to the last value")


def _enough(steps: float) -> int:
    """Number of values for a number of steps, checked against the limit."""
    if steps >= MOST:
        raise ValueError(f"at most {MOST} values, not {steps + 1:.3g}")
    return int(steps + 1e-9) + 1


def _spread(given: Any) -> Any:
    if not isinstance(given, Mapping):
        return given
    try:
        return tuple(map(float, expand_range(given)))
    except ValueError as error:
        raise PydanticCustomError("range", "a list, or a range: {cause}", {"cause": str(error)}) from None


_Targets = Annotated[_List, BeforeValidator(_spread, json_schema_input_type=_List | _Range)]


def _unordered(control: Control, targets: tuple[float, ...], *, nearer: bool) -> Iterator[Fault]:
    """Faults of targets that are not monotonic, or that no state can have."""
    falling = nearer == (control in ("separation", "mean-gap"))
    if any(b >= a if falling else b <= a for a, b in itertools.pairwise(targets)):
        cause = "a retraction in the same list: write the approach, and retract = true for the way back"
        if not nearer:
            cause = "separation and mean gap grow on the way back, mean pressure and repulsive area fall"
        yield Fault(("targets",), "decreasing values" if falling else "increasing values", cause)
    if control == "repulsive-area" and not all(0 < target < 1 for target in targets):
        yield Fault(("targets",), "fractions of the whole area, between 0 and 1", "percent instead of fractions")


class RetractionTable(Table):
    """[loading.retraction]: the way back, if it has other targets than the approach."""

    control: Control
    """controlled quantity on the way back"""
    targets: _Targets
    """its values, in the unit of the control, a list or a range: separation and mean gap increasing, mean pressure and
    repulsive area decreasing"""

    @constraint
    def _retracting(self) -> Iterator[Fault]:
        yield from _unordered(self.control, self.targets, nearer=False)


class _WaysTable(Table):
    """Way of a path."""

    control: Control
    """controlled quantity"""
    targets: _Targets
    """its values on approach, a list or a range {from, to, step | factor | count}: separation and mean gap in a0,
    decreasing; mean pressure in E* and repulsive area as a fraction of A0, increasing"""
    retract: bool = False
    """whether to go back through the same values"""
    retraction: RetractionTable | None = None
    """another way back, instead of retract"""


class LoadingTable(Search, _WaysTable):
    """[loading]: the path."""

    newer: ClassVar[frozenset[str]] = frozenset({"threshold", "area_resolution"})
    renamed: ClassVar[Mapping[str, str]] = {"threshold": "turn"}
    area_tolerance: Fraction | Annotated[tuple[Fraction, ...], Field(min_length=1)] = 0.01  # type: ignore[assignment]
    """largest difference from a given repulsive area, relative to it or, beyond half contact, to what is left of A0; or
    one for each target; half a grid point is always accepted"""
    threshold: Fraction | None = None
    """find at each area the work of adhesion at which the load changes its sign, the threshold, instead of the state at
    the given work; the value is the width of the bracket of works, relative to the threshold, as 0.02"""

    @property
    def legs(self) -> tuple[tuple[Control, tuple[float, ...]], ...]:
        """Control and targets of the approach and of the retraction, in the order in which they are visited."""
        if self.retraction is not None:
            return (self.control, self.targets), (self.retraction.control, self.retraction.targets)
        return ((self.control, self.targets + (self.targets[-2::-1] if self.retract else ())),)

    @property
    def stretches(self) -> Iterator[tuple[Control, tuple[float, ...], Search]]:
        """The legs, cut where the tolerance of the area changes."""
        given, looks = self.area_tolerance, (self.area_resolution, self.event_resolution, self.event_threshold)
        for control, targets in self.legs:
            each = given + given[-2::-1] if isinstance(given, tuple) else itertools.repeat(given)
            for tolerance, group in itertools.groupby(zip(targets, each, strict=False), key=itemgetter(1)):
                yield control, tuple(target for target, _ in group), Search(tolerance, *looks)

    @property
    def aims(self) -> Iterator[tuple[Control, float, Search]]:
        """Control at each point, its value, and its tolerance."""
        return ((control, target, search) for control, targets, search in self.stretches for target in targets)

    @property
    def points(self) -> int:
        """Number of points of the path."""
        return sum(len(targets) for _, targets in self.legs)

    @constraint
    def _approaching(self) -> Iterator[Fault]:
        yield from _unordered(self.control, self.targets, nearer=True)

    @constraint
    def _a_tolerance_for_each(self) -> Iterator[Fault]:
        if isinstance(self.area_tolerance, tuple) and len(self.area_tolerance) != len(self.targets):
            expected = f"one number, or one for each target: {len(self.targets)}"
            yield Fault(("area_tolerance",), expected)
        if isinstance(self.area_tolerance, tuple) and self.retraction is not None:
            yield Fault(("area_tolerance",), "one number, where [loading.retraction] has targets of its own")

    @constraint
    def _a_threshold_of_areas(self) -> Iterator[Fault]:
        if self.threshold is not None and (
            self.control != "repulsive-area" or self.retract or self.retraction is not None
        ):
            cause = "a threshold is the work at which the load at an area vanishes, on approach"
            yield Fault(("threshold",), 'only with control = "repulsive-area" and without a way back', cause)

    @constraint
    def _one_way_back(self) -> Iterator[Fault]:
        if self.retract and self.retraction is not None:
            yield Fault(("retract",), "false where [loading.retraction] says how to go back", "both are given")

    @constraint
    def _events_on_the_way(self) -> Iterator[Fault]:
        if self.event_resolution is not None and all(control == "repulsive-area" for control, _ in self.legs):
            cause = "a search for an area brackets jumps over it by itself: see area_resolution"
            yield Fault(("event_resolution",), "only where another control than repulsive-area is used", cause)


class OutputTable(Table):
    """[output]: what is stored in addition to areas, loads and contact maps."""

    fields: bool = False
    """whether to store heights and gaps in full, in single precision"""
    last_state: bool | None = None
    """whether to store the gap of the last point in double precision, so that a longer path can continue from it; by
    default on grids of at most 1024 x 1024 points, except for a single point on a grid of at most 64 x 64"""


class RunConfig(Document):
    """The input of ``continuum run``."""

    result_schema: ClassVar[str] = "stickiness/continuum-run"
    result_version: ClassVar[int] = 3
    not_identity: ClassVar[frozenset[str]] = frozenset({"output"})
    former_defaults: ClassVar[tuple[tuple[str, Mapping[str, Any]], ...]] = (
        ("25 November 2026", {"loading.area_resolution": 1e-3}),
    )
    newer: ClassVar[frozenset[str]] = frozenset({"counterface"})
    of_others: ClassVar[Mapping[str, str]] = {"sweep": "this is the input of a sweep: use `continuum sweep run`"}

    grid: GridTable
    """points and period"""
    surface: Surface
    """heights of the rigid wall"""
    wall: Wall
    """law between wall and surface"""
    substrate: Response
    """elastic response"""
    loading: LoadingTable
    """path of loading"""
    solver: SolverTable = SolverTable()
    """tolerance and iterations"""
    output: OutputTable = OutputTable()
    """what is stored"""
    counterface: Counterface | None = None
    """a second rough body, if both are rough"""

    @property
    def shortest(self) -> float | None:
        """Shortest wavelength of the combined surface, in a0; None if unknown."""
        if self.counterface is None:
            return self.surface.shortest
        both = self.surface.shortest, self.counterface.surface.shortest
        return None if both[0] is None or both[1] is None else min(both[0], both[1])

    @property
    def expected_slope(self) -> float | None:
        """Expected slope h'rms of the combined surface, independent of the grid; None if it is not random."""
        slope = self.surface.expected_slope
        if self.counterface is None or slope is None:
            return slope
        other = self.counterface.surface.expected_slope
        return None if other is None else float(np.hypot(slope, other))

    def on(self, device: str) -> Self:
        """The same run on another device; raises ArgumentError if there is none of that name."""
        solver = self.solver.model_copy(update={"device": choice("device", device, BACK_ENDS)})
        return self.model_copy(update={"solver": solver})

    @constraint
    def _equal_slabs(self) -> Iterator[Fault]:
        points, shards = self.grid.n[0], self.solver.shards
        if points % shards:
            yield Fault(("solver", "shards"), f"a divisor of the {points} points along x", "slabs of rows are equal")

    @constraint
    def _shows_the_surface(self) -> Iterator[Fault]:
        yield from self.surface.too_short(self.grid.n, self.grid.lengths)
        yield from self.surface.too_long(self.grid.n, self.grid.lengths)

    @constraint
    def _fits_the_counterface(self) -> Iterator[Fault]:
        if self.counterface is not None:
            yield from self.counterface.unfit(self.grid.n, self.grid.lengths, repeats=self.substrate.repeats)

    @constraint
    def _work_to_change(self) -> Iterator[Fault]:
        if self.loading.threshold is not None and not self.wall.work_key:
            cause = f"the work of adhesion is not a key of law {self.wall.kind_name!r}"
            laws = ", ".join(f'"{name}"' for name, kind in Wall.kinds.items() if kind.work_key)
            yield Fault(("wall", "law"), f"where a threshold is sought, a law whose work is given: {laws}", cause)

    @constraint
    def _load_to_carry(self) -> Iterator[Fault]:
        for key, part in ((("loading",), self.loading), (("loading", "retraction"), self.loading.retraction)):
            if part is not None and (cause := self.substrate.without(part.control)):
                yield Fault((*key, "control"), f'another control than "{part.control}" on this substrate', cause)

    @constraint
    def _below_the_hardness(self) -> Iterator[Fault]:
        if np.isinf(self.wall.hardness):
            return
        for (control, targets), key in zip(self.loading.legs, (("loading",), ("loading", "retraction")), strict=False):
            if control == "mean-gap":
                yield Fault((*key, "control"), f'another control than "{control}" where the wall yields', YIELDS)
            elif control == "mean-pressure" and max(targets) >= self.wall.hardness:
                most = f"values below the hardness, {self.wall.hardness:g} E*"
                yield Fault(
                    (*key, "targets"), most, "the whole surface yields at a mean pressure equal to the hardness"
                )

    @constraint
    def _no_line_alone(self) -> Iterator[Fault]:
        if not self.substrate.repeats and self.grid.n[0] == 1:
            yield Fault(("grid", "n"), NO_LINE)

    @constraint
    def _a_threshold_that_repeats(self) -> Iterator[Fault]:
        if self.loading.threshold is not None and not self.substrate.repeats:
            allowed = "where a threshold is sought, the response of a surface that repeats"
            yield Fault(("substrate", "response"), allowed, "a threshold is looked for by its mean gap")


@dataclass(frozen=True)
class Cost:
    """What follows from the input of a run alone."""

    memory: int
    """Peak memory, in bytes."""
    states: int
    """Number of states of the path, without those that searches try."""
    size: int
    """Number of points of the grid."""

    @property
    def effort(self) -> float:
        """States times points of the grid: the unit in which systems of one sweep are compared."""
        return float(self.states) * self.size


@dataclass(frozen=True)
class Share:
    """What each of the devices has of a contact that is divided over several."""

    shards: int
    size: int
    """Number of points of the grid."""
    modes: int
    """Numbers of a half spectrum, with the columns that make the parts equal."""
    fields: float
    """Fields of the whole grid that a solve needs."""

    @classmethod
    def of(cls, config: RunConfig) -> Self:
        (nx, ny), shards = config.grid.n, config.solver.shards
        repeats = 1 if config.substrate.repeats else 2
        columns = shards * -(-(repeats * ny // 2 + 1) // shards)
        fields = SMOOTH_FIELDS if config.wall.has_law else BOUND_FIELDS
        return cls(shards, repeats**2 * nx * ny, columns * repeats * nx, fields)

    @property
    def memory(self) -> float:
        """Memory of the solver on a device, in bytes."""
        return 8 * self.fields * self.size / self.shards

    @property
    def sent(self) -> float:
        """Bytes that a device sends to all others in a pair of transforms: of its part of a spectrum all but its own.

        Beside it are sums, and rows at the edges of slabs.
        """
        return 2 * 16 * self.modes * (self.shards - 1) / self.shards**2


def memory_on_device(config: RunConfig) -> float:
    """Memory that a run needs on one GPU, in bytes."""
    return ON_A_DEVICE + Share.of(config).memory


def cost_of(config: RunConfig) -> Cost:
    """Memory, states and points of the grid of a run."""
    nx, ny = config.grid.n
    size, states = nx * ny, config.loading.points
    # Contact maps take two bits per point, fields four bytes, and both are held twice during a rewrite.
    kept = states * size * 2 * (0.25 + (4 if config.output.fields else 0))
    beside = 1 if config.substrate.repeats else 4
    point = UNDER_A_LAW if config.wall.has_law else UNDER_A_HARD_WALL
    return Cost(int(LIBRARIES + beside * size * point + kept), states, size)
