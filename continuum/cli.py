"""The command ``continuum``: parse, call, print."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import continuum

__all__ = ["main"]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="continuum",
        description="Adhesive contact of a rigid rough wall with an elastic substrate, by FFT Green's functions.",
        epilog="Units: a0 = 1 (atomic spacing), E* = 1 (contact modulus).  "
        "Exit code: 0 all converged, 1 some point did not converge, 2 bad input (nothing is written).",
    )
    parser.add_argument("--version", action="version", version=f"stickiness {continuum.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    check = commands.add_parser("check", help="validate an input file and print what it amounts to")
    check.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")

    run = commands.add_parser("run", help="follow a loading path and store areas, loads and contact maps")
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
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parsed = _parser().parse_args(arguments)
    from continuum.config import ConfigError
    from continuum.console import exit_code
    from continuum.run import OutputError
    from continuum.store import StoreError

    command = {"check": _check, "run": _run, "plot": _plot, "analyse": _analyse}[parsed.command]
    return exit_code(lambda: command(parsed), (ConfigError, OutputError, StoreError))


def _check(parsed: argparse.Namespace) -> int:
    from continuum.config import RunConfig, identity, load
    from continuum.console import OK, show_table
    from continuum.system import build, estimate

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
    return OK


def _run(parsed: argparse.Namespace) -> int:
    from continuum.config import RunConfig, load
    from continuum.console import NOT_CONVERGED, OK, progress, show_table
    from continuum.run import Step, run

    config = load(parsed.file, RunConfig)
    path = parsed.output / f"{Path(parsed.file).stem}.h5"
    with progress(len(config.loading.path), Path(parsed.file).stem) as report:

        def after(step: Step, done: int, total: int) -> None:
            text = (
                f"mean gap {step.mean_gap:.4g} a0, A_rep {step.area_rep:.4g}, N {step.load:.4g}, {step.status.lower()}"
            )
            report(done, text)

        summary = run(config, path, force=parsed.force, progress=after)
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
            f"{step.fft_pairs:g}",
            step.status.lower().replace("_", " "),
        ]
        for i, step in enumerate(summary.steps)
    ]
    head = ["step", "branch", "mean gap", "separation", "A_rep/A0", "A_att/A0", "N/(E* A0)", "N_rep/(E* A0)",
            "residual", "FFT pairs", "status"]  # fmt: skip
    failed = [step for step in summary.steps if not step.converged]
    caption = f"{summary.path}" + (f"   ({summary.resumed} points were stored before)" if summary.resumed else "")
    show_table("lengths in a0, pressures in E*", head, rows, caption)
    return NOT_CONVERGED if failed else OK


def _plot(parsed: argparse.Namespace) -> int:
    from continuum.console import OK
    from continuum.plot import draw_all

    for path in draw_all(parsed.result, parsed.output):
        print(path)
    return OK


def _analyse(parsed: argparse.Namespace) -> int:
    from continuum.analysis import analyse, summary, tables
    from continuum.console import OK, show_table
    from continuum.plot import draw_analysis

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
