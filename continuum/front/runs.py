"""The sub-commands of ``continuum`` on runs, as functions; and what a run or a sweep costs before it is run.

Memory and the number of states follow from an input, the time from systems that have ended.
"""

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from continuum.front.contact import LoadingPath, State
from continuum.inputs.arguments import ArgumentError, file_name, flag, function, hinted, number, several
from continuum.inputs.reading import InputFile, load, settings_of, source_of
from continuum.store.identity import identity
from continuum.store.runs.build import RunSetup, build
from continuum.store.runs.config import Cost, RunConfig, Share, cost_of
from continuum.store.runs.record import Point
from continuum.store.runs.result import Analysis, Result
from continuum.store.runs.run import Progress, follow_run
from continuum.store.sheet import Column, Sheet
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.cluster import Allocation
from continuum.store.sweeps.folder import Folder, names
from continuum.store.sweeps.status import Span, SystemTime, effort_of, expected, timed_systems

NOT_MEASURED = "not measured"
_SHORT = 20.0
"""Seconds up to which a measurement is made again: the first one loads the solver."""

_TELLING = 256**2
"""Points of a grid from which on the time of a state grows as its points, within the range that is given; on smaller
ones it is that of everything else."""
_OF_A_SEARCH = "loading.area_tolerance", "loading.area_resolution"


@dataclass(frozen=True)
class SystemCost:
    """A system of a sweep, or what a search tries between its ends, with its cost."""

    key: str
    """Identity; empty between the ends of a search."""
    kind: str
    """Grid of the system, in words."""
    config: RunConfig
    """Input of the system, perhaps with another seed."""
    cost: Cost


def costs_of(described: Sweep) -> list[SystemCost]:
    """Cost of each system, and of what is tried between the two ends of each search, as if all cross."""
    found = [SystemCost(plan.key, plan.kind, config, cost_of(config)) for plan, config, _ in described.plans()]
    if described.bisection is not None:
        ends = zip(found[::2], found[1::2], strict=True)
        between = described.bisection.halvings
        found += [replace(max(two, key=lambda end: end.cost.effort), key="") for two in ends for _ in range(between)]
    return found


def tasks_of(described: Sweep, systems: Sequence[SystemCost]) -> int:
    """Number of systems, or of searches."""
    return len(systems) if described.bisection is None else len(systems) // (2 + described.bisection.halvings)


class _Enough(Exception):
    """The first state is there."""


def seconds_of(config: RunConfig, *, first_state: bool = False) -> float:
    """Wall time of a run, or of its first state alone, without the time that loading the solver takes."""

    def stop(point: Point, done: int, total: int) -> None:
        if first_state:
            raise _Enough

    def once() -> float:
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            with suppress(_Enough):
                follow_run(config, Path(folder) / "measured.h5", progress=stop)
            return time.perf_counter() - began

    seconds = once()
    # A short run is mostly the loading of the solver, which a second one does not repeat.
    return once() if seconds < _SHORT else seconds


def check_sweep(file: InputFile, settings: Mapping[str, Any], *, reduced: bool, measure: bool) -> Sheet:
    """Check the input of a sweep and each of its systems: memory and states, and the time if it is to be measured."""
    described = Sweep.read(file, settings, reduced=reduced)
    systems, searches = costs_of(described), list[tuple[str, str, str]]()
    if described.bisection is not None:
        searches = [
            ("searches", f"{tasks_of(described, systems)}", ""), ("their systems are counted as if all cross", "", "")
        ]  # fmt: skip
    grids = {one.config.grid.n for one in systems}
    rows = [
        *searches,
        ("systems", f"{len(systems)}", ""),
        ("states of their paths", f"{sum(one.cost.states for one in systems)}", ""),
        ("grids", ", ".join(f"{nx} x {ny}" for nx, ny in sorted(grids)), ""),
        ("memory of the largest system, about", f"{max(one.cost.memory for one in systems) / 2**20:.4g}", "MiB"),
        *_times(systems, measure=measure),
        *((f"column {one.name}, run by `sweep run` only", one.made, "") for one in described.columns),
    ]
    return Sheet.of(f"{described.source.path}: valid", ("quantity", "value", "unit"), rows)


def _times(systems: Sequence[SystemCost], *, measure: bool) -> list[tuple[str, str, str]]:
    """Rows of the time of a sweep, by its cheapest system."""
    if not measure:
        return [("time", NOT_MEASURED, "--measure solves the cheapest system")]
    one = _measured(systems)
    span = expected([one], effort_of((each.kind, each.cost.effort) for each in systems), scaled=True)
    return [
        ("the cheapest system took", f"{one.seconds:.2g}", "s"),
        ("all of them, on one core", f"{span}", "by that one"),
    ]


def _measured(systems: Sequence[SystemCost]) -> SystemTime:
    # A small grid would tell the time of everything but the transforms.
    largest = max(one.cost.size for one in systems)
    cheapest = min((one for one in systems if one.cost.size >= min(_TELLING, largest)), key=lambda one: one.cost.effort)
    return SystemTime(cheapest.kind, cheapest.cost.effort, seconds_of(cheapest.config))


def core_hours(systems: Sequence[SystemCost], root: Path, allocation: Allocation, *, measure: bool) -> tuple[str, str]:
    """Core hours that a sweep still needs, in words, and that a job asks for less, if it does.

    They follow from the systems that are done in its folder; else the cheapest one is solved, if it is to be measured.
    """
    span, done = _by_the_folder(systems, root), "the systems that are done"
    if span is None and measure:
        effort = effort_of((one.kind, one.cost.effort) for one in systems)
        span, done = expected([_measured(systems)], effort, scaled=True), "the cheapest system"
    if span is None:
        # Without the name of the folder: whoever named it could add to the script.
        return (
            "Core hours: not known before a system of each grid is done; `sweep slurm --measure` solves the cheapest.",
            "",
        )
    asked = allocation.core_seconds
    hours = f"{_hours(span.seconds)} ({_hours(span.low)} to {_hours(span.high)})"
    known = f"Core hours: about {hours} by {done}; this asks for {_hours(asked)}."
    if asked >= span.seconds:
        return known, ""
    again = "submit the job again until nothing is left, or ask for more"
    return known, f"The time asked for is {100 * asked / span.seconds:.2g} % of what is needed: {again}."


def _by_the_folder(systems: Sequence[SystemCost], root: Path) -> Span | None:
    """Time of what is left, by the finished systems of the folder of the sweep; None if there are none."""
    folder = Folder(root)
    there = names(folder.points)
    named = {folder.stem(one.key): one for one in systems if one.key}
    ended = {name: (folder.points / f"{name}.h5").stat().st_mtime for name in there & named.keys()}
    done = {name: (named[name].kind, named[name].cost.effort) for name in ended}
    left = ((one.kind, one.cost.effort) for one in systems if not one.key or folder.stem(one.key) not in there)
    return expected(timed_systems(folder, done, ended), effort_of(left))


def _hours(seconds: float) -> str:
    return f"{seconds / 3600:.2g}"


@dataclass(frozen=True, eq=False)
class CheckReport:
    """Plan and cost of a run or a sweep."""

    sheet: Sheet
    """A run: grid, roughness, law, memory and states; a sweep: what its systems need together."""
    system: RunSetup | None = None
    """The contact of a run, with its input; None of a sweep."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Lengths that the grid of a run does not resolve."""
        return self.system.warnings if self.system is not None else ()

    def _repr_html_(self) -> str:
        return self.sheet._repr_html_()


@hinted
def check(
    file: InputFile, settings: Mapping[str, Any] | None = None, *, reduced: bool = False, measure: bool = False
) -> CheckReport:
    """Check an input file of a run or of a sweep: its grid, roughness, memory and number of states.

    Parameters
    ----------
    file : input (TOML); ``inputs/...`` finds those that come with the package; in Python also a dictionary of its
        tables, which is then named "input".
    settings : values for keys of the input, as ``{"surface.seed": 3}``.
    reduced : use the values of [sweep.reduced] (sweeps only).
    measure : solve the first state of a run, or the cheapest system of a sweep, and estimate the total time from it.

    Raises
    ------
    ConfigError
        With all faults of the file, or of the first faulty system of a sweep.
    ArgumentError
        If an argument is not allowed.

    Examples
    --------
    >>> import continuum as c
    >>> c.check("inputs/sweep/figure4.toml", reduced=True).sheet.rows[0]
    ('systems', '240', '')
    """
    given, source = settings_of(settings), source_of(file)
    flag("measure", measure)
    if flag("reduced", reduced) or "sweep" in source.data:
        return CheckReport(check_sweep(file, given, reduced=reduced, measure=measure))
    config = load(file, RunConfig, given)
    system, cost = build(config), cost_of(config)
    grid, wall, real, expected = system.problem.grid, system.problem.wall, system.problem.moments, system.expected
    rows: list[tuple[str, str, str]] = [
        ("points", f"{grid.shape[0]} x {grid.shape[1]}", ""),
        ("period", f"{grid.lengths[0]:g} x {grid.lengths[1]:g}", "a0"),
        ("spacing", f"{grid.spacing[0]:g} x {grid.spacing[1]:g}", "a0"),
    ]
    symbols = (("h_rms", "a0"), ("h'_rms", ""), ("h''_rms = sqrt(<(laplacian h)²>)", "1/a0"))
    for i, (symbol, unit) in enumerate(symbols):
        rows.append((symbol, f"{real[i]:.6g}", unit))
        if expected is not None:
            rows.append((f"{symbol}, mean of the ensemble", f"{expected[i]:.6g}", unit))
    rows += [
        ("d_rep = 4 h'_rms/h''_rms, expected contact diameter", f"{4 * real.rms_slope / real.rms_curvature:.4g}", "a0"),
        ("work of adhesion w (in reduced units: l_a)", f"{wall.work_of_adhesion:.4g}", "E* a0"),
        ("range of attraction", f"{wall.range:.4g}", "a0"),
        ("residual tolerance, rms", f"{system.settings.tolerance:.3g}", "E*"),
        ("states of the path", f"{cost.states}", ""),
        ("memory, about", f"{cost.memory / 2**20:.4g}", "MiB"),
        _time_of(config, measure=measure),
        *_shared(config),
        ("identity", identity(config)[:16], ""),
    ]
    columns = (Column("quantity"), Column("value"), Column("unit"))
    return CheckReport(Sheet.of(f"{source.path}: valid", columns, rows), system)


def _time_of(config: RunConfig, *, measure: bool) -> tuple[str, str, str]:
    if not measure:
        return "time", NOT_MEASURED, "--measure solves the first state"
    return "time of the first state", f"{seconds_of(config, first_state=True):.2g}", "s"


def _shared(config: RunConfig) -> list[tuple[str, str, str]]:
    """Memory and traffic of each device of several."""
    if config.solver.shards == 1:
        return []
    share = Share.of(config)
    return [
        (f"memory on each of {share.shards} devices, about", f"{share.memory / 2**20:.4g}", "MiB"),
        ("sent by each of them, about", f"{share.sent / 2**20:.4g}", "MiB in an FFT pair"),
    ]


@hinted
def run(
    file: InputFile | RunConfig,
    output: str | Path = "results",
    *,
    settings: Mapping[str, Any] | None = None,
    force: bool = False,
    device: str | None = None,
    progress: Progress | None = None,
    warn: Callable[[Sequence[str]], None] | None = None,
) -> Result:
    """Follow the loading path of an input, store it, and return the result.

    Parameters
    ----------
    file : input (TOML); ``inputs/...`` finds those that come with the package; in Python also one that was loaded, or
        a dictionary of its tables, which is then named "input".
    output : folder for the result, which is named after the input; or its file, ``NAME.h5``.  Points stored there are
        kept.
    settings : values for keys of the input, as ``{"surface.seed": 3}``.
    force : replace a stored result and start anew.
    device : device of the solver, instead of ``[solver] device`` of the input: cpu, cuda (a GPU) or a library.
    progress : called after each point with it, how many are done and how many there are.
    warn : called with warnings about resolution and device.

    Raises
    ------
    ConfigError, InputError, OutputError
        If the input cannot be run, this machine has not the device, or the result cannot be stored.
    ArgumentError
        If an argument is not allowed.

    Examples
    --------
    >>> import continuum as c
    >>> result = c.run("inputs/smoke/sphere.toml")  # comes with the package
    >>> result
    Result('results/sphere.h5', 13 points, 13 converged, 0 jumps)
    >>> c.run("inputs/smoke/sphere.toml").resumed  # nothing is solved twice
    13
    """
    given = settings_of(settings)
    function("progress", progress)
    function("warn", warn)
    config = load(file, RunConfig, given)
    config = config if device is None else config.on(device)
    path = file_name("output", output)
    if path.suffix != ".h5":
        name = config.source.path.stem if config.source else "run"
        path = path / f"{name}.h5"
    return follow_run(config, path, force=flag("force", force), progress=progress, warn=warn)


@hinted
def threshold(
    file: InputFile,
    output: str | Path = "results",
    *,
    area: Sequence[float] = (0.01,),
    width: float = 0.02,
    settings: Mapping[str, Any] | None = None,
    force: bool = False,
    progress: Progress | None = None,
    warn: Callable[[Sequence[str]], None] | None = None,
) -> Result:
    """Find the work of adhesion above which the surface of an input is sticky, store it, and return the result.

    At this work of adhesion the load at each area changes its sign on approach.  The range of the wall is that of the
    input, except for the paper's law, whose range follows from its work.

    Parameters
    ----------
    file : input of a run (TOML); its [loading] is not used; in Python also a dictionary of its tables, which is then
        named "input".
    output : folder for the result, which is named after the input; or its file, ``NAME.h5``.
    area : repulsive areas, as fractions of A0, increasing; the paper takes 1 %.
    width : width of the bracket of works, relative to the threshold.
    settings : values for keys of the input, as ``{"surface.seed": 3}``.
    force : replace a stored result and start anew.
    progress : called after each area with it, how many are done and how many there are.
    warn : called with warnings about resolution.

    Raises
    ------
    ConfigError, InputError, OutputError
        If the input cannot be run, its wall has no work of adhesion, or the result cannot be stored.
    ArgumentError
        If an argument is not allowed.

    Examples
    --------
    >>> import continuum as c
    >>> smoother = {"grid.n": 64, "surface.lambda_s": 16.0}
    >>> result = c.threshold("inputs/smoke/threshold.toml", settings=smoother, area=[0.05])
    >>> round(result.points[0].work_of_adhesion, 4)  # w_c, in E* a0
    0.0034
    """
    areas = [number("area", each, above=0, below=1) for each in several("area", area)]
    if any(after <= before for before, after in pairwise(areas)):
        raise ArgumentError("area", areas, "increasing areas")
    number("width", width, above=0, below=1)
    into, given = file_name("output", output), settings_of(settings)
    for key in given:
        if key.split(".")[0] == "loading" and key not in _OF_A_SEARCH:
            allowed = f"of [loading] only {' and '.join(_OF_A_SEARCH)}: areas and width are given otherwise"
            raise ArgumentError("settings", {key: given[key]}, allowed)
    loading = {"control": "repulsive-area", "targets": areas, "threshold": width, "area_tolerance": 0.05}
    config = load(file, RunConfig, {"loading": loading, **given})
    name = config.source.path.stem if config.source else "input"
    if into.suffix != ".h5":
        into /= f"{name}-threshold.h5"
    return run(config, into, force=force, progress=progress, warn=warn)


def analyse(result: str | Path) -> Analysis:
    """Measure every point of a stored run, and compare with the paper.

    Parameters
    ----------
    result : file of the run.

    Raises StoreError if the file is not a run, ArgumentError if it is not the name of a file.
    """
    return Result.read(file_name("result", result)).analyse()


def plot(result: str | Path | Result | Analysis | State | LoadingPath, folder: str | Path | None = None) -> list[Path]:
    """Draw the figures of a stored run or of its analysis, or a state or a path; returns the PNG files.

    Parameters
    ----------
    result : file of the run, or what was read from it; or a state or a path of a contact.
    folder : folder of the figures; by default that of the run, or the current folder for a state or a path.

    Raises StoreError if the file is not a run, ArgumentError if one of them is not the name of a file or folder.

    Examples
    --------
    >>> import continuum as c
    >>> contact = c.Contact(c.sine(c.Grid.square(32), 0.5, (1, 1)), c.HardWall())
    >>> state = contact.press(pressure=0.01)
    >>> [path.name for path in c.plot(state)]
    ['state.png']
    """
    from continuum.show.run_figures import draw  # matplotlib takes a while to import

    return draw(result, None if folder is None else file_name("folder", folder))
