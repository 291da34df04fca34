"""The commands of ``continuum``: each calls the function of its name, shows what it returns, and says how it went.

Those of maps are in :mod:`continuum.front.map_commands`, the others beside what they call: a run does not import that.
"""

import time
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from continuum.front import certify as certificates
from continuum.front import doctor as examination
from continuum.front import runs as front
from continuum.front.options import FIGURES, like
from continuum.inputs.errors import NOT_CONVERGED, OK
from continuum.inputs.reading import load
from continuum.inputs.reference import schema as schema_of
from continuum.inputs.reference import template
from continuum.show.console import progress, progress_of_known, report, warn
from continuum.solve.processes import sharing
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point
from continuum.store.runs.result import Result
from continuum.store.sheet import Sheet


@like(front.check)
def check(**given: Any) -> int:
    found = front.check(**given)
    return report(found.sheet, warnings=found.warnings)


def _timed(report: Callable[[int, str], None]) -> Callable[[Point, int, int], None]:
    """Report each point with the time that it took."""
    since = time.monotonic()

    def after(point: Point, done: int, total: int) -> None:
        nonlocal since
        seconds, since = time.monotonic() - since, time.monotonic()
        report(done, point.line(seconds))

    return after


@like(front.run)
def run(file: str, **given: Any) -> int:
    config = load(file, RunConfig, given.pop("settings", None))
    if not sharing(config.solver.shards).first:  # the first process speaks
        return OK if all(point.converged for point in front.run(config, **given).points) else NOT_CONVERGED
    with progress(config.loading.points, Path(file).stem) as tell:
        found = front.run(config, progress=_timed(tell), warn=warn, **given)
    return _followed(found, *found.sheets())


@like(
    front.threshold, help={"area": "repulsive area, as a fraction of A0; may be repeated, increasing (default: 0.01)"}
)
def threshold(file: str, *, area: Sequence[float] = (0.01,), **given: Any) -> int:
    with progress(len(area), Path(file).stem) as tell:
        found = front.threshold(file, area=area, progress=_timed(tell), warn=warn, **given)
    return _followed(found, found.threshold_sheet())


def _followed(result: Result, *sheets: Sheet) -> int:
    failed = [(i, point) for i, point in enumerate(result.points) if not point.converged]
    lines = [f"step {i}, {point.control} {point.target:g}: {point.meaning}" for i, point in failed]
    return report(*sheets, lines=[*lines, f"result   {result.path}"], ok=not failed)


@like(certificates.certify)
def certify(path: Path, **given: Any) -> int:
    with progress_of_known(path.stem, "files") as tell:
        found = certificates.certify(path, progress=tell, **given)
    return report(*found.sheets(), warnings=found.faults, ok=found.ok)


@like(front.analyse, draws=FIGURES)
def analyse(
    result: Annotated[Path, Parameter(help="file written by `continuum run`")],
    *results: Annotated[Path, Parameter(help="further files")],
    output: Annotated[Path | None, Parameter(help="folder of the figures (default: that of each result)")] = None,
) -> int:
    for path in (result, *results):
        found = front.analyse(path)
        report(*found.sheets(), lines=[f"note: {note}" for note in found.notes])
        report(lines=front.plot(found, output))
    return OK


@like(examination.doctor)
def doctor() -> int:
    return examination.diagnosed(examination.doctor())


@like(template)
def init(kind: Annotated[Literal["run", "sweep"], Parameter(help="input that is printed")]) -> int:
    """Print a template of an input, with every key explained."""
    print(template(RunConfig, "inputs/smoke/path.toml"), end="")
    if kind == "sweep":
        print(resources.files("continuum.store.sweeps").joinpath("template.toml").read_text(), end="")
    return OK


@like(schema_of)
def schema(kind: Annotated[Literal["run"], Parameter(help="input whose schema is printed")]) -> int:
    """Print the JSON schema of an input, for editors that complete TOML."""
    print(schema_of(RunConfig), end="")
    return OK
