"""The command ``continuum``: parse, call, print."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import continuum

__all__ = ["main"]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="continuum",
        description="Adhesive contact of a rigid rough wall with an elastic substrate, by FFT Green's functions.",
        epilog="Units: a0 = 1 (atomic spacing), E* = 1 (contact modulus).  "
        "Exit code: 0 all converged, 1 some point did not converge or has no state (a tension too large, an area that "
        "is jumped over), 2 bad input (nothing is written).",
    )
    parser.add_argument("--version", action="version", version=f"stickiness {continuum.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    check = commands.add_parser("check", help="validate an input file and print what it amounts to")
    check.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")

    run = commands.add_parser(
        "run",
        help="follow a loading path and store areas, loads, contact maps and jumps",
        description="Follow a loading path.  [loading] of the input says how: control (separation, mean-gap, "
        "mean-pressure, repulsive-area) and targets; retract = true or [loading.retraction] for the way back; "
        "event_resolution to bracket jumps.  Stopped with Ctrl-C or otherwise, the same command goes on.",
    )
    run.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")
    run.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("results"),
        help="folder of the result, NAME.h5 after the input's name (default: results)",
    )
    run.add_argument("--force", action="store_true", help="start anew, whatever is stored")

    plot = commands.add_parser("plot", help="draw the figures of a stored run")
    plot.add_argument("result", type=Path, help="file written by `continuum run`")
    plot.add_argument("-o", "--output", type=Path, help="folder of the figures (default: that of the result)")

    analyse = commands.add_parser(
        "analyse",
        help="measure the stored points of runs: patches, perimeter, κ, gap profile, pull-off",
        description="Measure every point of stored runs, compare with the paper, and draw the figures.  The "
        "gap profile, d_att and the distributions need a run with fields = true in [output].",
    )
    analyse.add_argument("results", type=Path, nargs="+", metavar="RESULT", help="files written by `continuum run`")
    analyse.add_argument("-o", "--output", type=Path, help="folder of the figures (default: that of each result)")

    _add_predict(commands.add_parser(
        "predict",
        help="is my surface sticky? every criterion on a measured topography",
        description="Roughness of a measured topography, or of two that face each other, the verdict of every "
        "criterion of stickiness with its margin, and warnings.  Writes figures and a one-page HTML report.",
        epilog="Every quantity has a unit: 70GPa, 50mJ/m2, 0.5nm.  Example: continuum predict map.npy --size 10um "
        "--unit nm --modulus 2MPa --poisson 0.5 --work 50mJ/m2 --range 0.5nm",
    ))  # fmt: skip
    commands.add_parser("examples", help="print the paper's worked examples beside ours, as Markdown")
    return parser


def _add_predict(predict: argparse.ArgumentParser) -> None:
    predict.add_argument("files", nargs="+", type=Path, metavar="FILE", help="topography; two for two rough bodies")
    maps = predict.add_argument_group("topography (given twice: one for each file)")
    maps.add_argument("--size", action="append", metavar="LX[,LY]",
                      help="physical size, from the first row of the array to the last, and from the first column to "
                      "the last; one number: square pixels; only if the file does not say")  # fmt: skip
    maps.add_argument("--unit", action="append", help="unit of the heights; only if the file does not say")
    maps.add_argument("--dataset", action="append", help="dataset of an HDF5 file")
    maps.add_argument("--part", action="append", help="map of a container, or channel of a file, if it has several")
    maps.add_argument(
        "--periodic", action="store_true", help="the map continues at its edges (default: as the file says)"
    )
    maps.add_argument("--detrend", choices=("plane", "none"),
                      help="what is taken off: the mean plane (default), or the mean (if periodic)")  # fmt: skip
    contact = predict.add_argument_group("contact")
    contact.add_argument("--material", action="append", default=[], metavar="NAME",
                         help="diamond, silicon, mica, pdms, rubber, with cited values; given once the other body is "
                         "rigid, twice for two elastic bodies")  # fmt: skip
    contact.add_argument("--modulus", action="append", default=[], help="Young's modulus of a body; twice for two")
    contact.add_argument("--poisson", action="append", default=[], help="its Poisson's ratio; twice for two")
    contact.add_argument("--estar", help="contact modulus E* = E/(1 - nu^2), instead of modulus and Poisson's ratio")
    contact.add_argument("--work", help="work of adhesion w")
    contact.add_argument("--range", help="range of the attraction (for a law without cut-off, its effective range)")
    contact.add_argument("--spacing", help="spacing of the atoms a0, for the necessary condition on crystals")
    predict.add_argument("--solve", action="store_true", help="also solve the contact of the map and compare")
    predict.add_argument("--threads", type=int, default=1, help="threads of the solver (default: 1)")
    predict.add_argument("-o", "--output", type=Path, default=Path("results"),
                         help="folder of report and figures (default: results)")  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parsed = _parser().parse_args(arguments)
    from continuum.files.store import StoreError
    from continuum.files.tables import ConfigError
    from continuum.runs.run import OutputError
    from continuum.show.console import exit_code
    from continuum.sticky.materials import InterfaceError
    from continuum.sticky.topography import TopographyError

    command = {"check": _check, "run": _run, "plot": _plot, "analyse": _analyse, "predict": _predict,
               "examples": _examples}[parsed.command]  # fmt: skip
    bad_input = (ConfigError, OutputError, StoreError, TopographyError, InterfaceError)
    return exit_code(lambda: command(parsed), bad_input)


def _check(parsed: argparse.Namespace) -> int:
    from continuum.front.commands import check
    from continuum.show.console import OK, show, warn

    found = check(parsed.file)
    show(found.sheet)
    warn(found.warnings)
    return OK


def _run(parsed: argparse.Namespace) -> int:
    from continuum.files.tables import load
    from continuum.front.commands import run
    from continuum.runs.config import RunConfig
    from continuum.runs.record import Point
    from continuum.show.console import NOT_CONVERGED, OK, progress, show, warn
    from continuum.show.runs import progress_line

    config = load(parsed.file, RunConfig)
    with progress(config.loading.points, Path(parsed.file).stem) as report:
        since = time.monotonic()

        def after(point: Point, done: int, total: int) -> None:
            nonlocal since
            seconds, since = time.monotonic() - since, time.monotonic()
            report(done, progress_line(point, seconds))

        result = run(config, parsed.output, force=parsed.force, progress=after, warn=warn)
    for sheet in result.sheets():
        show(sheet)
    failed = [(i, point) for i, point in enumerate(result.points) if not point.converged]
    for i, point in failed:
        print(f"step {i}, {point.control} {point.target:g}: {point.meaning}")
    return NOT_CONVERGED if failed else OK


def _plot(parsed: argparse.Namespace) -> int:
    from continuum.front.commands import plot
    from continuum.show.console import OK

    for path in plot(parsed.result, parsed.output):
        print(path)
    return OK


def _analyse(parsed: argparse.Namespace) -> int:
    from continuum.front.commands import analyse
    from continuum.show.console import OK, show

    for path in parsed.results:
        found = analyse(path)
        for sheet in found.sheets():
            show(sheet)
        for note in found.notes:
            print(f"note: {note}")
        for figure in found.plot(parsed.output):
            print(figure)
    return OK


def _predict(parsed: argparse.Namespace) -> int:
    from continuum.front.commands import predict
    from continuum.show.console import NOT_CONVERGED, OK, show

    found = predict(
        *parsed.files, size=parsed.size, unit=parsed.unit, dataset=parsed.dataset, part=parsed.part,
        periodic=parsed.periodic, detrend=parsed.detrend, material=parsed.material, modulus=parsed.modulus,
        poisson=parsed.poisson, contact_modulus=parsed.estar, work=parsed.work, range=parsed.range,
        spacing=parsed.spacing, solve=parsed.solve, threads=parsed.threads,
    )  # fmt: skip
    for sheet in found.sheets():
        show(sheet)
    print(found.sentence)
    for doubt in found.doubts:
        print(f"warning: {doubt}")
    for path in found.write(parsed.output, "-".join([*(path.stem for path in parsed.files), "predict"])):
        print(path)
    return NOT_CONVERGED if found.unsolved else OK


def _examples(parsed: argparse.Namespace) -> int:
    from continuum.front.commands import examples
    from continuum.show.console import OK

    print(examples(), end="")
    return OK
