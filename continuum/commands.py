"""The commands of ``continuum``: each calls the function of its name, shows what it returns, and says how it went.

Those of maps are in :mod:`continuum.map_commands`: a run does not import what they need.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from continuum.errors import NOT_CONVERGED, OK
from continuum.files.inputs import load
from continuum.files.reference import schema as schema_of
from continuum.files.reference import template
from continuum.files.toml import value_of
from continuum.front import certify as certificates
from continuum.front import commands as front
from continuum.options import Formats, like
from continuum.paper.examples import examples as paper_examples
from continuum.runs.config import RunConfig
from continuum.runs.record import Point
from continuum.runs.result import Result
from continuum.show.console import progress, show, warn


def _setting(_: type, tokens: Sequence[Any]) -> list[tuple[str, object]]:
    found = []
    for token in tokens:
        key, equals, value = token.value.partition("=")
        if not equals or not key.strip():
            raise ValueError(f"{token.value!r}: write KEY=VALUE, such as surface.seed=3")
        found.append((key.strip(), value_of(value.strip())))
    return found


Settings = Annotated[
    list[tuple[str, object]] | None,
    Parameter(name="--set", converter=_setting, n_tokens=1, accepts_keys=False, help="value for a key of the input, "
              "as surface.seed=3; may be repeated"),
]  # fmt: skip
Kind = Literal["run"]
Begun = Literal["run", "sweep"]


@like(front.check)
def check(*, settings: Settings = None, **given: Any) -> int:
    found = front.check(settings=dict(settings or ()), **given)
    show(found.sheet)
    warn(found.warnings)
    return OK


def _timed(report: Callable[[int, str], None]) -> Callable[[Point, int, int], None]:
    """Report each point with the time that it took."""
    since = time.monotonic()

    def after(point: Point, done: int, total: int) -> None:
        nonlocal since
        seconds, since = time.monotonic() - since, time.monotonic()
        report(done, point.line(seconds))

    return after


@like(front.run)
def run(file: str, *, settings: Settings = None, **given: Any) -> int:
    config = load(file, RunConfig, dict(settings or ()))
    with progress(config.loading.points, Path(file).stem) as report:
        result = front.run(config, progress=_timed(report), warn=warn, **given)
    for sheet in result.sheets():
        show(sheet)
    return _ended(result)


@like(front.threshold)
def threshold(file: str, *, area: Annotated[list[float] | None, Parameter(help="repulsive area, as a fraction of A0; "
              "may be repeated, increasing (default: 0.01)")] = None, width: float = 0.02, settings: Settings = None,
              **given: Any) -> int:  # fmt: skip
    areas = area or [0.01]
    with progress(len(areas), Path(file).stem) as report:
        found = front.threshold(file, area=areas, width=width, settings=dict(settings or ()), warn=warn,
                                progress=_timed(report), **given)  # fmt: skip
    show(found.threshold_sheet())
    return _ended(found)


def _ended(result: Result) -> int:
    """Print which points did not converge, and the file of the result."""
    failed = [(i, point) for i, point in enumerate(result.points) if not point.converged]
    for i, point in failed:
        print(f"step {i}, {point.control} {point.target:g}: {point.meaning}")
    print(f"result   {result.path}")
    return NOT_CONVERGED if failed else OK


@like(certificates.certify)
def certify(path: Path, **given: Any) -> int:
    with ExitStack() as bars:
        # How many files there are is known once the first is done.
        bar = cache(lambda total: bars.enter_context(progress(total, path.stem)))
        found = certificates.certify(path, progress=lambda done, total: bar(total)(done, "files"), **given)
    for sheet in found.sheets():
        show(sheet)
    warn(found.faults)
    return OK if found.ok else NOT_CONVERGED


@like(front.plot)
def plot(
    result: Annotated[str, Parameter(help="file written by `continuum run`, or the name of a figure")],
    *folders: Annotated[Path, Parameter(help="folder of a sweep, for a figure; several for `page` and `dispute`")],
    output: Annotated[Path | None, Parameter(help="folder of the figures (default: that of the result)")] = None,
    format: Formats = None,
) -> int:
    from continuum.paper.page import plot_figure
    from continuum.show.plot import written_as

    # A page shows its figures as PNG.
    with written_as(["png", *format] if format and result == "page" else format):
        paths = plot_figure(result, *folders, into=output) if folders else front.plot(result, output)
    for path in paths:
        print(path)
    return OK


@like(front.analyse)
def analyse(
    result: Annotated[Path, Parameter(help="file written by `continuum run`")],
    *results: Annotated[Path, Parameter(help="further files")],
    output: Annotated[Path | None, Parameter(help="folder of the figures (default: that of each result)")] = None,
    format: Formats = None,
) -> int:
    from continuum.show.plot import written_as

    for path in (result, *results):
        found = front.analyse(path)
        for sheet in found.sheets():
            show(sheet)
        for note in found.notes:
            print(f"note: {note}")
        with written_as(format):
            for figure in front.plot(found, output):
                print(figure)
    return OK


@like(paper_examples)
def examples() -> int:
    print(paper_examples(), end="")
    return OK


@like(template)
def init(kind: Begun) -> int:
    """Print a template of an input, with every key explained."""
    print(template(RunConfig, "inputs/smoke/path.toml"), end="")
    if kind == "sweep":
        print(resources.files("continuum.sweeps").joinpath("template.toml").read_text(), end="")
    return OK


@like(schema_of)
def schema(kind: Kind) -> int:
    """Print the JSON schema of an input, for editors that complete TOML."""
    print(schema_of(RunConfig), end="")
    return OK
