"""The command ``continuum``: parse, call, print."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import continuum

if TYPE_CHECKING:
    from continuum.path.state import Event

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
    from continuum.runs.config import ConfigError
    from continuum.runs.run import OutputError
    from continuum.show.console import exit_code
    from continuum.sticky.materials import InterfaceError
    from continuum.sticky.topography import TopographyError

    command = {"check": _check, "run": _run, "plot": _plot, "analyse": _analyse, "predict": _predict,
               "examples": _examples}[parsed.command]  # fmt: skip
    bad_input = (ConfigError, OutputError, StoreError, TopographyError, InterfaceError)
    return exit_code(lambda: command(parsed), bad_input)


def _check(parsed: argparse.Namespace) -> int:
    from continuum.runs.build import build, estimate
    from continuum.runs.config import RunConfig, identity, load
    from continuum.show.console import OK, show_table, warn

    config = load(parsed.file, RunConfig)
    system, cost = build(config), estimate(config)
    grid, wall, real = system.grid, system.problem.wall, system.realised
    rows = [
        ["points", f"{grid.shape[0]} x {grid.shape[1]}", ""],
        ["period", f"{grid.lengths[0]:g} x {grid.lengths[1]:g}", "a0"],
        ["spacing", f"{grid.spacing[0]:g} x {grid.spacing[1]:g}", "a0"],
    ]
    for name, symbol, unit in (
        ("rms_height", "h_rms", "a0"),
        ("rms_slope", "h'_rms", ""),
        ("rms_curvature", "h''_rms = sqrt(<(laplacian h)²>)", "1/a0"),
    ):
        rows.append([symbol, f"{getattr(real, name):.6g}", unit])
        if system.expected is not None:
            rows.append([f"{symbol}, mean of the ensemble", f"{getattr(system.expected, name):.6g}", unit])
    rows += [
        [
            "d_rep = 4 h'_rms/h''_rms, expected contact diameter",
            f"{4 * real.rms_slope / real.rms_curvature:.4g}",
            "a0",
        ],
        ["work of adhesion w (in reduced units: l_a)", f"{wall.work_of_adhesion:.4g}", "E* a0"],
        ["range of attraction", f"{wall.range:.4g}", "a0"],
        ["residual tolerance, rms", f"{system.settings.tolerance:.3g}", "E*"],
        ["points of the path", f"{cost.points}", ""],
        ["memory, about", f"{cost.memory / 2**20:.4g}", "MiB"],
        ["cost, about", f"{cost.fft_pairs}", "FFT pairs"],
        ["identity", identity(config)[:16], ""],
    ]
    show_table(f"{parsed.file}: valid", ["quantity", "value", "unit"], rows)
    warn(system.warnings)
    return OK


def _run(parsed: argparse.Namespace) -> int:
    from continuum.runs.config import RunConfig, load
    from continuum.runs.run import Step, run
    from continuum.show.console import NOT_CONVERGED, OK, progress, show_table, warn

    config = load(parsed.file, RunConfig)
    path = parsed.output / f"{Path(parsed.file).stem}.h5"
    with progress(config.loading.points, Path(parsed.file).stem) as report:
        since = time.monotonic()

        def after(step: Step, done: int, total: int) -> None:
            nonlocal since
            seconds, since = time.monotonic() - since, time.monotonic()
            place = f"mean gap {step.mean_gap:.4g} a0, separation {step.separation:.4g} a0, A_rep {step.area_rep:.4g}"
            work = f"residual {step.residual:.1e}, {step.fft_pairs + step.search_pairs:.0f} pairs, {seconds:.1f} s"
            report(done, f"{place}, N {step.load:.4g} E*, {work}, {_words(step.status)}")

        summary = run(config, path, force=parsed.force, progress=after, warn=warn)
    rows = [
        [
            str(i),
            step.branch,
            f"{step.mean_gap:.5g}",
            f"{step.separation:.5g}",
            f"{step.area_rep:.4g}",
            f"{step.area_att:.4g}",
            f"{step.load:.4e}",
            f"{step.load_rep:.4e}",
            f"{step.residual:.1e}",
            f"{step.fft_pairs:.0f}",
            f"{step.search_pairs:.0f}",
            _words(step.status),
        ]
        for i, step in enumerate(summary.steps)
    ]
    head = ["step", "branch", "mean gap", "separation", "A_rep/A0", "A_att/A0", "N/(E* A0)", "N_rep/(E* A0)",
            "residual", "FFT pairs", "search", "status"]  # fmt: skip
    caption = f"{summary.path}" + (f"   ({summary.resumed} points were stored before)" if summary.resumed else "")
    show_table("lengths in a0, pressures in E*", head, rows, caption)
    if summary.events:
        head = ["before step", "jump", "of", "from", "to", "mean gap", "", "A_rep/A0", "", "N/(E* A0)", ""]
        show_table("jumps: both sides of each", head, [_jump(*passed) for passed in summary.events])
    failed = [(i, step) for i, step in enumerate(summary.steps) if not step.converged]
    for i, step in failed:
        print(f"step {i}, {step.control} {step.target:g}: {step.meaning}")
    return NOT_CONVERGED if failed else OK


def _words(status: str) -> str:
    return status.lower().replace("_", " ")


def _jump(step: int, event: Event) -> list[str]:
    """One jump as cells of a table."""
    before, after = event.before, event.after
    cells = [str(step), event.kind, event.control, f"{before.value:.6g}", f"{after.value:.6g}"]
    cells += [f"{value:.5g}" for value in (before.mean_gap, after.mean_gap, before.area_rep, after.area_rep)]
    return [*cells, f"{before.load:.4e}", f"{after.load:.4e}"]


def _plot(parsed: argparse.Namespace) -> int:
    from continuum.show.console import OK
    from continuum.show.plot import draw_all

    for path in draw_all(parsed.result, parsed.output):
        print(path)
    return OK


def _analyse(parsed: argparse.Namespace) -> int:
    from continuum.runs.analysis import analyse, summary, tables
    from continuum.show.console import OK, show_table
    from continuum.show.plot import draw_analysis

    for path in parsed.results:
        found = analyse(path)
        for title, head, rows in tables(found):
            show_table(f"{path}: {title}", head, rows)
        show_table("theory and adhesion", ["quantity", "value", "unit"], summary(found))
        for note in found.notes:
            print(f"note: {note}")
        for figure in draw_analysis(found, parsed.output):
            print(figure)
    return OK


def _predict(parsed: argparse.Namespace) -> int:
    from continuum.runs.run import OutputError
    from continuum.show import report
    from continuum.show.console import NOT_CONVERGED, OK, show_table
    from continuum.solve.smooth import NotConvergedError
    from continuum.sticky import materials
    from continuum.sticky.predict import predict
    from continuum.sticky.simulate import UnresolvedError, simulate
    from continuum.sticky.topography import detrend, opposed, read_all

    maps = read_all(
        parsed.files, size=parsed.size, unit=parsed.unit, dataset=parsed.dataset, part=parsed.part,
        periodic=parsed.periodic,
    )  # fmt: skip
    interface = materials.parse(
        material=parsed.material, modulus=parsed.modulus, poisson=parsed.poisson, contact_modulus=parsed.estar,
        work=parsed.work, range=parsed.range, spacing=parsed.spacing,
    )  # fmt: skip
    topographies = [detrend(topography, parsed.detrend) for topography in maps]
    prediction, simulation, code = predict(topographies, interface), None, OK
    if parsed.solve:
        whole = topographies[0] if len(topographies) == 1 else opposed(*topographies)
        try:
            simulation = simulate(whole, interface, parsed.threads)
        except (UnresolvedError, NotConvergedError) as error:
            prediction, code = prediction.doubted(f"not solved: {error}"), NOT_CONVERGED
    for sheet in report.sheets(prediction, simulation):
        show_table(sheet.title, sheet.head, sheet.rows)
    print(report.summary(prediction, simulation))
    for warning in (*prediction.warnings, *(simulation.warnings if simulation else ())):
        print(f"warning: {warning}")
    name = "-".join([*(path.stem for path in parsed.files), "predict"])
    try:
        parsed.output.mkdir(parents=True, exist_ok=True)
        written = report.write(prediction, parsed.output, name, simulation)
    except OSError as error:
        msg = f"{parsed.output}: the report cannot be written there: {error}"
        raise OutputError(msg) from error
    for path in written:
        print(path)
    return code


def _examples(parsed: argparse.Namespace) -> int:
    from continuum.show.console import OK
    from continuum.sticky.examples import as_markdown

    print(as_markdown(), end="")
    return OK
