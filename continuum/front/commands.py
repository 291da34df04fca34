"""The commands of ``continuum``: each calls the function of its name, shows what it returns, and says how it went.

Those of ``continuum sweep`` begin with ``sweep_``.  Those of maps are in :mod:`continuum.front.map_commands`, others
beside what they call: a run does not import that.
"""

import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from continuum.front import certify as certificates
from continuum.front import doctor as examination
from continuum.front import runs as front
from continuum.front import sweeps
from continuum.front.options import FIGURES, like
from continuum.inputs.errors import NOT_CONVERGED, OK, InputError
from continuum.inputs.reading import load
from continuum.inputs.reference import schema as schema_of
from continuum.inputs.reference import template
from continuum.show.console import clear, on_a_bar, progress, progress_of_known, report, tell, until_ctrl_c, warn
from continuum.solve.processes import sharing
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point
from continuum.store.runs.result import Result
from continuum.store.sheet import Sheet
from continuum.store.sweeps import collect as collecting
from continuum.store.sweeps import status
from continuum.store.sweeps.status import Span, SystemTime, effort_of, expected
from continuum.store.sweeps.workers import Task, TaskResult

_OFTEN = 30.0
"""Seconds between two lines about an unfinished system."""
Watch = Annotated[
    float | None,
    Parameter(
        help="interval in seconds of reports, until all systems are done or Ctrl-C is pressed (default: one report)"
    ),
]


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


@like(front.run, resumes=True)
def run(file: str, **given: Any) -> int:
    config = load(file, RunConfig, given.pop("settings", None))
    if not sharing(config.solver.shards).first:  # the first process speaks
        return OK if all(point.converged for point in front.run(config, **given).points) else NOT_CONVERGED
    with progress(config.loading.points, Path(file).stem) as tell:
        found = front.run(config, progress=_timed(tell), warn=warn, **given)
    return _followed(found, *found.sheets())


@like(
    front.threshold,
    help={"area": "repulsive area, as a fraction of A0; may be repeated, increasing (default: 0.01)"},
    resumes=True,
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


class SweepProgress(ExitStack):
    """Progress of a sweep; nothing is shown before :meth:`begin`.

    Once a system on each grid has ended, a line says what all take together.
    """

    def __init__(self, title: str) -> None:
        super().__init__()
        self._title = title
        self._left: dict[Path, Task] = {}
        self._shares: dict[Path, float] = {}
        self._ended: list[SystemTime] = []
        self._at_once = 1
        self._told = False

    def begin(self, tasks: Sequence[Task]) -> None:
        """Set the systems, done or not."""
        self._left = {task.path: task for task in tasks}
        self._total, self._said = len(tasks), time.monotonic()
        self._report = self.enter_context(progress(self._total, self._title, self._time_left))
        if not on_a_bar():  # which shows the number at once; the first report may take minutes
            tell(f"{self._title}: {self._total} systems")

    def end(self, ended: TaskResult) -> None:
        """Report a system that has ended, except one that was done before."""
        task = self._left.pop(ended.task.path)
        self._shares.pop(task.path, None)
        if ended.found:
            return
        if ended.ok:
            self._ended.append(SystemTime(task.kind, task.cost, ended.seconds, ended.first))
            self._at_once = ended.at_once
        self._report(self._total - len(self._left), str(ended))
        self._tell()

    def advance(self, task: Task, share: float) -> None:
        """Report the finished share of a system, from 0 to 1; every half minute where each report is a line."""
        self._shares[task.path] = share
        if on_a_bar() or time.monotonic() - self._said > _OFTEN:
            self._report(self._total - len(self._left), f"{task.label}: {share:.0%} of its points")
            self._said = time.monotonic()

    def _tell(self) -> None:
        """Say once what the others take, as soon as a system on each of their grids has ended."""
        kinds = {task.kind for task in self._left.values()}
        if self._told or not kinds or not kinds <= {one.kind for one in self._ended if one.counts}:
            return
        self._told = True
        others = "the last one takes" if len(self._left) == 1 else f"the other {len(self._left)} take"
        tell(f"{self._title}: {others} {self._span()} of one core, by the first on each grid")

    def _span(self) -> Span | None:
        """Time for what is left in one process; None if it is not known yet."""
        left = ((task.kind, task.cost * (1 - self._shares.get(path, 0.0))) for path, task in self._left.items())
        return expected(self._ended, effort_of(left))

    def _time_left(self) -> str:
        span = self._span()
        return "" if span is None else str(span.over(max(1, min(self._at_once, len(self._left)))))


@like(sweeps.sweep, help={"memory": "memory to use, in GB (default: all of this machine)"}, resumes=True)
def sweep_run(file: str, **given: Any) -> int:
    with SweepProgress(Path(file).stem) as told:
        done = sweeps.sweep(
            file, **given, warn=warn, begun=told.begin, progress=lambda ended, n, total: told.end(ended),
            meanwhile=told.advance,
        )  # fmt: skip
    what = "searches" if done.crossings else "systems"
    lines = [f"{done.folder}: {done.done} {what} done, {done.found} were done before, {len(done.failed)} failed"]
    lines += [f"a process died: {death}" for death in done.died]
    if done.held:
        lines.append(f"{len(done.held)} are locked by another process: {done.held[0].reason}")
    report(lines=lines)
    without = [f"{one.label}: {one.status}" for one in done.crossings if one.complete and not one.found]
    failed = [f"{ended.task.label}: {ended.reason}" for ended in done.failed]
    return report(warnings=failed[:20] + without[:20], ok=done.ok and not without)


@like(sweeps.sweep_slurm, help={
    "memory": "memory of each process, in GB (default: that of the largest system)",
    "modules": "module to load first, as gcc/13.2; may be repeated",
    "lines": "further line of the script, as 'source ~/venv/bin/activate'; may be repeated",
})  # fmt: skip
def sweep_slurm(**given: Any) -> int:
    print(sweeps.sweep_slurm(**given, warn=warn), end="")
    return OK


@like(status.sweep_status)
def sweep_status(*, watch: Watch = None, **given: Any) -> int:
    if watch is not None and not 0 < watch <= 86400:
        raise InputError(f"--watch {watch:g}: give seconds, more than 0 and at most a day")
    with until_ctrl_c():
        while True:
            found = status.sweep_status(**given)
            if watch is not None:
                clear()
            report(*found.sheets(), lines=[f"would change: {change}" for change in found.changes])
            if watch is None or not found.left:
                break
            time.sleep(watch)
    return OK


@like(sweeps.sweep_collect, resumes=True)
def sweep_collect(**given: Any) -> int:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", collecting.LeftOutWarning)  # each fault is reported below
        found = sweeps.sweep_collect(**given)
    faults = [*found.faults, *found.lacking]
    return report(*found.sheets(), warnings=faults, lines=found.files, ok=not faults)


@like(collecting.sweep_verify)
def sweep_verify(sweep: Path, **given: Any) -> int:
    found = collecting.sweep_verify(sweep, **given)
    said = f"{sweep}: {found.files} files, {len(found.faults)} of them damaged"
    said += f", {len(found.unread)} could not be read now" if found.unread else ""
    if found.moved:
        said += f"; {found.moved} moved to {sweep / collecting.DAMAGED}; `continuum sweep run` makes them anew"
    return report(warnings=[*found.faults, *found.unread], lines=[said], ok=found.ok)
