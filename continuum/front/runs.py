"""The sub-commands of ``continuum`` on runs, as functions."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from continuum.front.contact import LoadingPath, State
from continuum.front.costs import NOT_MEASURED, check_sweep, seconds_of
from continuum.inputs.arguments import ArgumentError, file_name, flag, function, hinted, number, several
from continuum.inputs.reading import InputFile, load, settings_of, source_of
from continuum.store.identity import identity
from continuum.store.runs.build import RunSetup, build
from continuum.store.runs.config import RunConfig
from continuum.store.runs.cost import Share, cost_of
from continuum.store.runs.result import Analysis, Result
from continuum.store.runs.run import Progress, follow_run
from continuum.store.sheet import Column, Sheet


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
    measure : solve the first state of a run, or the cheapest system of a sweep, and report the time of all by it.

    Raises
    ------
    ConfigError
        With all faults of the file, or of the first faulty system of a sweep.
    ArgumentError
        If an argument is not allowed.
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


_OF_A_SEARCH = "loading.area_tolerance", "loading.area_resolution"


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

    The load at each area changes its sign on approach at that work.  The range of the wall is that of the input,
    except for the paper's law, whose range follows from its work.

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
    folder : folder of the figures; that of the run if None, and the present one of a state or a path.

    Raises StoreError if the file is not a run, ArgumentError if one of them is not the name of a file or folder.
    """
    from continuum.show.run_figures import draw  # matplotlib takes a while to import

    return draw(result, None if folder is None else file_name("folder", folder))
