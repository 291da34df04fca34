"""The command ``continuum``: parse, call, print."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from continuum.options import as_options, completion, parser, until_stopped

if TYPE_CHECKING:
    from continuum.front.commands import Prediction


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return until_stopped(partial(_main, arguments))


def _main(arguments: Sequence[str] | None) -> int:
    parsed = parser().parse_args(arguments)
    from continuum.show.console import exit_code

    command = {
        "check": _check, "run": _run, "sweep": _sweep, "plot": _plot, "analyse": _analyse, "predict": _predict,
        "examples": _examples, "init": _init, "schema": _schema, "completion": _completion,
    }[parsed.command]  # fmt: skip
    return exit_code(lambda: command(parsed), voice=parsed.voice)


def _completion(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK

    print(completion(parser(), parsed.shell), end="")
    return OK


def _init(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.files.reference import template
    from continuum.runs.config import RunConfig

    print(template(RunConfig, "inputs/smoke/path.toml"), end="")
    return OK


def _schema(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.files.reference import schema
    from continuum.runs.config import RunConfig

    print(schema(RunConfig), end="")
    return OK


def _check(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.front.commands import check
    from continuum.show.console import show, warn

    found = check(parsed.file, dict(parsed.set), reduced=parsed.reduced)
    show(found.sheet)
    warn(found.warnings)
    return OK


def _run(parsed: argparse.Namespace) -> int:
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.files.inputs import load
    from continuum.front.commands import run
    from continuum.runs.config import RunConfig
    from continuum.runs.record import Point
    from continuum.show.console import progress, show, warn
    from continuum.show.runs import progress_line

    config = load(parsed.file, RunConfig, dict(parsed.set))
    with progress(config.loading.points, Path(parsed.file).stem) as report:
        since = time.monotonic()

        def after(point: Point, done: int, total: int) -> None:
            nonlocal since
            seconds, since = time.monotonic() - since, time.monotonic()
            report(done, progress_line(point, seconds))

        result = run(config, parsed.output, force=parsed.force, device=parsed.device, progress=after, warn=warn)
    for sheet in result.sheets():
        show(sheet)
    failed = [(i, point) for i, point in enumerate(result.points) if not point.converged]
    for i, point in failed:
        print(f"step {i}, {point.control} {point.target:g}: {point.meaning}")
    print(f"result   {result.path}")
    return NOT_CONVERGED if failed else OK


def _sweep(parsed: argparse.Namespace) -> int:
    action = {"run": _sweep_run, "slurm": _sweep_slurm, "status": _sweep_status, "collect": _sweep_collect,
              "verify": _sweep_verify}[parsed.action]  # fmt: skip
    return action(parsed)


def _sweep_run(parsed: argparse.Namespace) -> int:
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.front.sweeps import sweep
    from continuum.show.console import EstimatedProgress, warn
    from continuum.show.sweeps import ended_line

    with EstimatedProgress(Path(parsed.file).stem) as report:
        done = sweep(
            parsed.file, parsed.output, settings=dict(parsed.set), reduced=parsed.reduced, workers=parsed.workers,
            threads=parsed.threads, device=parsed.device, memory=parsed.memory,
            retry=parsed.retry, shard=parsed.shard, scheduler_file=parsed.scheduler_file,
            begun=lambda tasks: report.begin({task.path: task.cost for task in tasks}),
            progress=lambda ended, n, total: report.ended(ended.task.path, ended_line(ended), new=not ended.found),
        )  # fmt: skip
    print(f"{done.folder}: {done.done} systems done, {done.found} were there, {len(done.failed)} failed")
    if done.held:
        print(f"{len(done.held)} are locked by another process: {done.held[0].reason}")
    warn([f"{ended.task.label}: {ended.reason}" for ended in done.failed[:20]])
    return OK if done.ok else NOT_CONVERGED


def _sweep_slurm(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.front.sweeps import sweep_slurm

    print(sweep_slurm(parsed.file, parsed.output, settings=dict(parsed.set), reduced=parsed.reduced, nodes=parsed.nodes,
                      time=parsed.time, workers=parsed.workers, shards=parsed.array), end="")  # fmt: skip
    return OK


def _sweep_status(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.front.sweeps import sweep_status
    from continuum.show.console import show
    from continuum.show.sweeps import failed_sheet, status_sheet

    found = sweep_status(parsed.folder)
    show(status_sheet(found))
    if found.failed:
        show(failed_sheet(found))
    return OK


def _sweep_collect(parsed: argparse.Namespace) -> int:
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.front.sweeps import sweep_collect
    from continuum.show.console import show, warn
    from continuum.show.sweeps import collected_sheet

    found = sweep_collect(parsed.folder, parsed.output)
    show(collected_sheet(found))
    warn(found.faults)
    for path in found.files:
        print(path)
    return NOT_CONVERGED if found.faults else OK


def _sweep_verify(parsed: argparse.Namespace) -> int:
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.front.sweeps import sweep_verify
    from continuum.show.console import warn

    found = sweep_verify(parsed.folder, aside=parsed.aside)
    warn(found.faults)
    print(f"{parsed.folder}: {found.files} files, {len(found.faults)} of them damaged")
    return OK if found.ok else NOT_CONVERGED


def _plot(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.front.commands import plot
    from continuum.paper.page import plot_figure
    from continuum.show.plot import written_as

    # A page shows its figures as PNG.
    formats = ["png", *parsed.format] if parsed.format and parsed.result == "page" else parsed.format
    with written_as(formats):
        if parsed.folders:
            paths = plot_figure(parsed.result, *parsed.folders, into=parsed.output)
        else:
            paths = plot(parsed.result, parsed.output)
    for path in paths:
        print(path)
    return OK


def _analyse(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.front.commands import analyse
    from continuum.show.console import show
    from continuum.show.plot import written_as

    for path in parsed.results:
        found = analyse(path)
        for sheet in found.sheets():
            show(sheet)
        for note in found.notes:
            print(f"note: {note}")
        with written_as(parsed.format):
            for figure in found.plot(parsed.output):
                print(figure)
    return OK


def _predict(parsed: argparse.Namespace) -> int:
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.files import output
    from continuum.show.console import show

    if parsed.csv is not None:
        return _predict_each(parsed)
    found = _predicted(parsed, parsed.files)
    # Before hours of work, and after all that can be wrong with the input.
    output.folder(parsed.output)
    for path in filter(None, [parsed.json]):
        output.distinct(path, parsed.files)
        output.folder(path.parent)
    if parsed.solve:
        print(_planned(found), flush=True)
        found = found.solved(parsed.threads)
    for sheet in found.sheets():
        show(sheet)
    print(found.sentence)
    for doubt in found.doubts:
        print(f"warning: {doubt}")
    for path in found.write(parsed.output, "-".join([*(path.stem for path in parsed.files), "predict"])):
        print(path)
    if parsed.json is not None:
        print(output.save(parsed.json, found.json()))
    return NOT_CONVERGED if found.unsolved else OK


def _predicted(parsed: argparse.Namespace, files: Sequence[Path], part: Sequence[str] | None = None) -> Prediction:
    from continuum.front.commands import predict
    from continuum.sticky.materials import InterfaceError
    from continuum.sticky.topography import TopographyError

    try:
        return predict(
            *files, size=parsed.size, unit=parsed.unit, dataset=parsed.dataset, part=part or parsed.part,
            periodic=parsed.periodic, override_size=parsed.override_size,
            detrend=parsed.detrend, fill=parsed.fill, crop=parsed.crop, cutoff=parsed.cutoff,
            material=parsed.material, modulus=parsed.modulus,
            poisson=parsed.poisson, contact_modulus=parsed.estar, work=parsed.work, range=parsed.range,
            spacing=parsed.spacing,
        )  # fmt: skip
    except (TopographyError, InterfaceError) as error:
        raise type(error)(as_options(str(error), vars(parsed))) from error


def _planned(found: Prediction) -> str:
    """What will be solved, or why nothing can be."""
    from continuum.sticky.predict import facing
    from continuum.sticky.simulate import UnresolvedError, resolvable

    try:
        instead = resolvable(facing(found), found.interface)[1]
    except UnresolvedError as error:
        return f"nothing will be solved: {error}"
    return instead or "the contact of the map will be solved as it is"


def _predict_each(parsed: argparse.Namespace) -> int:
    """A table: each file is a contact by itself, and one that cannot be used has its reason in its row."""
    from continuum.errors import BAD_INPUT, OK, InputError
    from continuum.files import output
    from continuum.show.prediction_data import as_csv
    from continuum.sticky.materials import InterfaceError

    output.distinct(parsed.csv, parsed.files)
    rows: list[dict[str, str | float | None]] = []
    for path, part in _contacts(parsed):
        named = {"map": str(path)} if part is None else {"map": str(path), "part": part}
        try:
            found = _predicted(parsed, [path], None if part is None else [part])
            found = found.solved(parsed.threads) if parsed.solve else found
        except InterfaceError:
            raise  # the same for all
        except InputError as error:
            rows.append({**named, "error": str(error)})
        else:
            rows.append({**found.row(), **named})
        print(f"{': '.join(named.values())}: {rows[-1].get('verdict') or rows[-1]['error']}", flush=True)
    output.folder(parsed.csv.parent)
    print(output.save(parsed.csv, as_csv(rows)))
    return BAD_INPUT if any("error" in row for row in rows) else OK


def _contacts(parsed: argparse.Namespace) -> Iterator[tuple[Path, str | None]]:
    """Each file, and of a container each measurement, unless one is chosen."""
    from continuum.errors import InputError
    from continuum.sticky.instruments import measurements

    for path in parsed.files:
        try:
            names = () if parsed.part else measurements(path)
        except InputError:
            names = ()  # said again, and written down, when it is read
        yield from ((path, name) for name in names or [None])


def _examples(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.paper.examples import examples

    print(examples(), end="")
    return OK
