"""What the command ``continuum`` does, as functions: one for each of its sub-commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from numpy.typing import ArrayLike

import continuum.runs.analysis
import continuum.runs.result
import continuum.sticky.predict
from continuum.arguments import ArgumentError, choice, count, file_name, flag, function
from continuum.files.inputs import load
from continuum.files.settings import settings_of
from continuum.files.tables import identity
from continuum.front.sweeps import check_sweep, is_sweep
from continuum.runs.build import RunSetup, build
from continuum.runs.config import RunConfig
from continuum.runs.cost import cost_of, pair_seconds
from continuum.runs.run import Progress
from continuum.runs.run import run as follow_run
from continuum.show.sheet import Column, Sheet
from continuum.solve.backend import BACK_ENDS
from continuum.solve.solution import MOST_THREADS

if TYPE_CHECKING:
    from continuum.sticky.materials import Interface
    from continuum.sticky.mending import Detrending
    from continuum.sticky.topography import Topography


class Result(continuum.runs.result.Result):
    """A stored run; see :class:`continuum.runs.result.Result`."""

    def analyse(self) -> Analysis:
        """Measure every stored equilibrium: patches, perimeter, κ, gap profile, pull-off."""
        return Analysis(**vars(continuum.runs.analysis.analyse(self)))

    def sheets(self) -> list[Sheet]:
        """Its points and its jumps."""
        from continuum.show.runs import run_sheets

        return run_sheets(self)

    def plot(self, folder: Path | None = None) -> list[Path]:
        """Draw its figures, beside it or into a folder; returns the PNG files."""
        from continuum.show.runs import draw_run

        return draw_run(self, folder)

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())


class Analysis(continuum.runs.analysis.Analysis):
    """What was measured on a run; see :class:`continuum.runs.analysis.Analysis`."""

    def sheets(self) -> list[Sheet]:
        """Each point, and the run as a whole."""
        from continuum.show.runs import analysis_sheets

        return analysis_sheets(self)

    def plot(self, folder: Path | None = None) -> list[Path]:
        """Draw its figures, beside the run or into a folder; returns the PNG files."""
        from continuum.show.runs import draw_analysis

        return draw_analysis(self, folder)

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())


class Prediction(continuum.sticky.predict.Prediction):
    """Is my surface sticky; see :class:`continuum.sticky.predict.Prediction`."""

    def sheets(self) -> list[Sheet]:
        """Surface, contact, verdicts, numbers."""
        from continuum.show.prediction import prediction_sheets

        return prediction_sheets(self)

    @property
    def sentence(self) -> str:
        """The answer in one sentence."""
        from continuum.show.prediction import prediction_sentence

        return prediction_sentence(self)

    def solved(self, threads: int = 1) -> Prediction:
        """The same with the contact of its map, solved; see :func:`continuum.sticky.predict.solved`."""
        from continuum.sticky.predict import solved

        return Prediction(**vars(solved(self, threads)))

    def json(self) -> str:
        """Everything, with the whole spectrum, in SI units."""
        from continuum.show.prediction_data import as_json

        return as_json(self)

    def row(self) -> dict[str, str | float | None]:
        """One row of a table, in SI units."""
        from continuum.show.prediction_data import row

        return row(self)

    def write(self, folder: str | Path, name: str) -> list[Path]:
        """Write ``NAME.html`` and its figures; returns HTML and PNG files.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        from continuum.show.prediction import write_prediction

        return write_prediction(self, Path(folder), name)

    def _repr_html_(self) -> str:
        return f"<p>{self.sentence}</p>{self.sheets()[3]._repr_html_()}"


@dataclass(frozen=True, eq=False)
class CheckReport:
    """What an input amounts to."""

    sheet: Sheet
    """Of a run grid, roughness, law, memory and cost; of a sweep what its systems cost together."""
    system: RunSetup | None = None
    """The contact of a run, with its input; None of a sweep."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the grid of a run does not resolve."""
        return self.system.warnings if self.system is not None else ()

    def _repr_html_(self) -> str:
        return self.sheet._repr_html_()


def check(file: str | Path, settings: Mapping[str, Any] | None = None, *, reduced: bool = False) -> CheckReport:
    """Validate an input file of a run or of a sweep, and say what it amounts to and what it will cost.

    Parameters
    ----------
    file : input (TOML); ``inputs/...`` finds those that come with the package.
    settings : values of keys instead of those of the file, as ``{"surface.seed": 3}``.
    reduced : of a sweep, the values of its [sweep.reduced] hold.

    Raises
    ------
    ConfigError
        With all faults of the file, or of the first faulty system of a sweep.
    ArgumentError
        If an argument has no meaning.
    """
    path = file_name("file", file)
    if flag("reduced", reduced) or is_sweep(path):
        return CheckReport(check_sweep(path, settings=settings, reduced=reduced))
    config = load(path, RunConfig, settings_of(settings))
    system, cost = build(config), cost_of(config)
    grid, wall, real, expected = system.grid, system.problem.wall, system.realised, system.expected
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
        ("points of the path", f"{cost.points}", ""),
        ("memory, about", f"{cost.memory / 2**20:.4g}", "MiB"),
        ("cost, about", f"{cost.fft_pairs}", "FFT pairs"),
        ("", f"{cost.seconds(pair_seconds(grid)):.2g}", "core-seconds of this machine, as it is now"),
        ("identity", identity(config)[:16], ""),
    ]
    columns = (Column("quantity"), Column("value"), Column("unit"))
    return CheckReport(Sheet.of(f"{file}: valid", columns, rows), system)


def run(
    file: str | Path | RunConfig,
    output: str | Path = "results",
    *,
    settings: Mapping[str, Any] | None = None,
    force: bool = False,
    device: str | None = None,
    progress: Progress | None = None,
    warn: Callable[[Sequence[str]], None] | None = None,
) -> Result:
    """Follow the loading path of an input, store it, and return what is stored.

    Parameters
    ----------
    file : input (TOML), or one that was loaded; ``inputs/...`` finds those that come with the package.
    output : folder of the result, which is named after the input; or the result itself, ``NAME.h5``.  Points that are
        there already are kept.
    settings : values of keys instead of those of the file, as ``{"surface.seed": 3}``.
    force : start anew.
    device : what the solver runs on, instead of the input's ``[solver] device``.
    progress : called after each point with it, how many are done and how many there are.
    warn : called with what the grid does not resolve, and what is to be known of the device.

    Raises
    ------
    ConfigError, InputError, OutputError
        If the input cannot be run, this machine has not the device, or the result cannot be stored.
    ArgumentError
        If an argument has no meaning.
    """
    given = settings_of(settings)
    function("progress", progress)
    function("warn", warn)
    if device is not None:
        choice("device", device, BACK_ENDS)
    if isinstance(file, RunConfig) and given:
        raise ArgumentError("settings", given, "values of keys of a file; this input was read already")
    config = file if isinstance(file, RunConfig) else load(file_name("file", file), RunConfig, given)
    config = config if device is None else config.on(device)
    path = file_name("output", output)
    if path.suffix != ".h5":
        name = config.source.path.stem if config.source else "run"
        path = path / f"{name}.h5"
    return Result(**vars(follow_run(config, path, force=flag("force", force), progress=progress, warn=warn)))


def analyse(result: str | Path) -> Analysis:
    """Measure every point of a stored run, and compare with the paper.

    Raises
    ------
    StoreError
        If the file is no run.
    ArgumentError
        If it is no name of a file.
    """
    return Result.read(file_name("result", result)).analyse()


def plot(result: str | Path, folder: str | Path | None = None) -> list[Path]:
    """Draw the figures of a stored run, beside it or into a folder; returns the PNG files.

    Raises
    ------
    StoreError
        If the file is no run.
    ArgumentError
        If one of them is no name of a file or folder.
    """
    path = file_name("result", result)
    into = None if folder is None else file_name("folder", folder)
    return Result.read(path).plot(into)


def predict(
    *maps: str | Path | ArrayLike,
    size: str | Sequence[str] | None = None,
    unit: str | Sequence[str] | None = None,
    dataset: str | Sequence[str] | None = None,
    part: str | Sequence[str] | None = None,
    periodic: bool = False,
    override_size: bool = False,
    detrend: Detrending | None = None,
    fill: str | float | None = None,
    crop: str | None = None,
    cutoff: str | None = None,
    material: str | Sequence[str] = (),
    modulus: str | Sequence[str] = (),
    poisson: str | float | Sequence[str | float] = (),
    contact_modulus: str | None = None,
    work: str | None = None,
    range: str | None = None,
    spacing: str | None = None,
    solve: bool = False,
    threads: int = 1,
) -> Prediction:
    """Is my surface sticky?  Every criterion on a measured topography, or on two that face each other.

    Every quantity is a text with its unit, as ``"50mJ/m2"``.

    Parameters
    ----------
    maps : one topography, or two for two rough bodies: names of files, or arrays of heights, shape (nx, ny), out of the
        body.  Masked points of an array are missing ones; an array of one row or column is a line scan.
    size : physical size, ``"10um"`` or ``"10um,12um"``, along the first index and the second; an array needs it, a file
        only if it does not say.  Of two maps one text for both, or one for each, ``"-"`` as the file says.
    unit : of the heights, like ``"nm"``; given as the size is.
    dataset, part, periodic, crop, override_size : see :func:`continuum.sticky.reading.read_all`.
    detrend, fill, cutoff : see :func:`continuum.sticky.mending.prepare`; fill as ``"5%"`` or 0.05.
    material, modulus, poisson : of one elastic body on a rigid one, or of two.
    contact_modulus : E*, instead.
    work, range : w and Δr, if not those of the material.
    spacing : of the atoms.
    solve, threads : whether to solve the contact of the map, too, and on how many threads.

    Raises
    ------
    TopographyError, InterfaceError
        If a map or the contact cannot be used.
    ArgumentError
        If an argument is of another type, such as a number where a text with its unit is asked for.
    """
    from continuum.sticky import materials, mending, quantities, reading

    _check_choices(detrend, solve, threads)
    maps_of = partial(reading.read_all, maps, size=size, unit=unit, dataset=dataset, part=part, periodic=periodic,
                      crop=crop, fill=fill, override_size=override_size)  # fmt: skip
    contact_of = partial(materials.read_interface, material=material, modulus=modulus, poisson=poisson, work=work,
                         contact_modulus=contact_modulus, range=range, spacing=spacing)  # fmt: skip
    read, contact = _both(maps_of, contact_of)
    share = quantities.share(fill)
    ready = [mending.prepare(one, detrend, fill=share, cutoff=cutoff) for one in read]
    found = Prediction(**vars(continuum.sticky.predict.predict(ready, contact)))
    return found.solved(threads) if solve else found


def _check_choices(detrend: Detrending | None, solve: bool, threads: int) -> None:
    """Check what is used only after the maps were read."""
    from continuum.sticky.mending import Detrending

    if detrend is not None:
        choice("detrend", detrend, get_args(Detrending))
    flag("solve", solve)
    count("threads", threads, 1, MOST_THREADS)


def _both(maps: Callable[[], list[Topography]], contact: Callable[[], Interface]) -> tuple[list[Topography], Interface]:
    """Maps and contact, or the faults of both at once."""
    from continuum.sticky.materials import InterfaceError
    from continuum.sticky.topography import TopographyError

    try:
        read = maps()
    except TopographyError as error:
        try:
            contact()
        except InterfaceError as other:
            msg = f"{error}\n{other}"
            raise TopographyError(msg) from error
        raise
    return read, contact()
