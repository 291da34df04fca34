"""The command ``atomistic``: parse, call, print."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import continuum

if TYPE_CHECKING:
    from atomistic.result import Result

__all__ = ["main"]


LMP_HELP = 'how your site starts LAMMPS, e.g. "srun lmp" (default: the installed library, in this process)'


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="atomistic",
        description="Explicit fcc(100) atoms under a rigid rough wall, in LAMMPS: the check on Green's functions.",
        epilog="Units: a0 = 1 (nearest-neighbour distance), E* = 1 (contact modulus).  "
        "Exit code: 0 all well, 1 a tolerance does not hold or something did not converge, "
        "2 bad input (nothing is written).",
    )
    parser.add_argument("--version", action="version", version=f"stickiness {continuum.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    validate = commands.add_parser(
        "validate", help="press one wall on Green's functions and on atoms, and print the error budget"
    )
    validate.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")
    validate.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("results"),
        help="folder of result and figures (default: results)",
    )
    validate.add_argument(
        "-j",
        "--workers",
        type=int,
        default=None,
        help="processes, one core each (default: all cores, at most 4)",
    )
    validate.add_argument("--keep-decks", type=Path, metavar="DIR", help="keep every LAMMPS deck in this folder")
    validate.add_argument("--lmp-command", metavar="CMD", help=LMP_HELP)
    validate.add_argument("--force", action="store_true", help="start anew, whatever is stored")

    deck = commands.add_parser("deck", help="write a LAMMPS deck that a stock lmp runs, serial or with MPI")
    deck.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")
    deck.add_argument("-o", "--output", type=Path, help="directory of the deck (default: decks/NAME)")
    deck.add_argument("--run", action="store_true", help="run it at once and print what it found")
    deck.add_argument("--lmp-command", metavar="CMD", help=LMP_HELP)

    read = commands.add_parser("read", help="print what a run of a deck found, and whether it is an equilibrium")
    read.add_argument("deck", type=Path, help="directory of the deck")

    commands.add_parser("doctor", help="is LAMMPS usable here, which one, and if not what to do")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parsed = _parser().parse_args(arguments)
    from atomistic.result import LammpsError
    from continuum.config import ConfigError
    from continuum.console import exit_code
    from continuum.minimise import NotConvergedError
    from continuum.store import StoreError

    command = {"validate": _validate, "deck": _deck, "read": _read, "doctor": _doctor}[parsed.command]
    return exit_code(
        lambda: command(parsed),
        (ConfigError, StoreError, FileExistsError),
        (LammpsError, NotConvergedError),
        "What is finished is stored; `atomistic doctor` looks at the LAMMPS of this machine.",
    )


def _validate(parsed: argparse.Namespace) -> int:
    from atomistic import archive, budget
    from atomistic.config import ValidateConfig
    from atomistic.plot import draw_all
    from atomistic.validate import STEPS, units, validate
    from continuum.config import Fault, load, refuse
    from continuum.console import NOT_CONVERGED, OK, progress, show_table

    config = load(parsed.file, ValidateConfig)
    stem = Path(parsed.file).stem
    path = parsed.output / f"{stem}.h5"
    workers = parsed.workers or min(4, os.cpu_count() or 1)
    if workers < 1:
        raise refuse(config, Fault((), "a positive number of --workers"))
    datasets = {} if parsed.force else archive.resume(path, config)
    todo = archive.remaining(config, {name: d.values for name, d in datasets.items()})
    parsed.output.mkdir(parents=True, exist_ok=True)
    total = len(units(config))
    done = total - len(todo)
    with progress(total, f"validate {stem}", done) as report:
        for result in validate(config, todo, min(workers, max(1, len(todo))), parsed.keep_decks, parsed.lmp_command):
            datasets = archive.join(config, datasets, archive.datasets_of([result]))
            archive.write(path, config, datasets)
            done += 1
            largest = max(state.largest_force for state in result.states) / result.unit.rms_slope
            report(done, f"{result.unit.label}: {len(result.states)} equilibria, max|f| {largest:.1e} h' E* a0²")
    stored = archive.read(path)[0]
    figures = draw_all(stored, parsed.output, stem)

    steps = tuple(STEPS)
    rows = [
        [
            cost.case,
            f"{cost.rms_slope:g}",
            *(f"{100 * cost.load[step]:.2f} %" for step in steps),
            *(f"{100 * cost.contact[step]:.2f} %" for step in ("nonlinearity", "total")),
            f"{cost.load_ratio[0]:.2f} - {cost.load_ratio[1]:.2f}",
        ]
        for cost in budget.costs(stored.columns, steps)
    ]
    show_table(
        "Error budget: largest load difference, relative to N_rep, and points whose contact differs",
        ["case", "h'rms", *(f"load: {step}" for step in steps), "contact: nonlinearity", "contact: total",
         "mean compliance*"],
        rows,
        "depth: half-space against layer.  anisotropy: layer against cubic layer.  discreteness: cubic layer against "
        "lattice Green's function.  "
        "nonlinearity: lattice Green's function against atoms.  total: half-space against atoms.\n"
        "*load of the half-space over that of the lattice at equal separation; all else at equal mean gap, "
        "lattice against atoms at equal separation",
    )  # fmt: skip
    fits = [fit for fit in budget.exponents(stored.columns) if fit.adhesion_length == 0]
    show_table(
        "Scaling of the nonlinearity with h'rms (expected without adhesion: load 1, displacement 2)",
        ["case", "quantity", "seed", "A_rep/A0", "h'rms", "fitted", "between neighbours"],
        [
            [fit.case, fit.quantity, str(fit.seed), f"{fit.area:g}", ", ".join(f"{h:g}" for h in fit.slopes),
             f"{fit.fitted:.3f}", ", ".join(f"{local:.3f}" for local in fit.local)]
            for fit in fits
        ],
    )  # fmt: skip
    verdicts = list(budget.verdicts(config, stored.columns))
    show_table(
        "Tolerances: lattice Green's function against atoms",
        ["case", "quantity", "bound", "worst / limit", "states", "verdict", "why this bound"],
        [
            [v.case, v.quantity, v.bound, f"{v.measured:.3g} / {v.limit:g}", str(v.states),
             "holds" if v.holds else "FAILS", v.reason]
            for v in verdicts
        ],
    )  # fmt: skip
    failed = sum(not verdict.holds for verdict in verdicts)
    print(f"result   {path}")
    for figure in figures:
        print(f"figure   {figure}")
    print(f"{len(verdicts) - failed} of {len(verdicts)} bounds hold" + (f", {failed} FAIL" if failed else ""))
    return NOT_CONVERGED if failed else OK


def _deck(parsed: argparse.Namespace) -> int:
    from atomistic.config import DeckConfig
    from atomistic.deck import write_deck
    from atomistic.engine import runner
    from atomistic.relax import deck_of
    from continuum.config import load
    from continuum.console import OK

    deck = deck_of(load(parsed.file, DeckConfig))
    directory = write_deck(parsed.output or Path("decks") / Path(parsed.file).stem, deck)
    print(f"deck     {directory}: {deck.slab.size} atoms, starting from the lattice solution")
    if parsed.run:
        return _show(runner(parsed.lmp_command)(directory))
    print("run it   lmp -in in.contact   or   mpiexec -n 4 lmp -in in.contact   in that directory")
    print(f"then     atomistic read {directory}")
    return OK


def _read(parsed: argparse.Namespace) -> int:
    from atomistic.result import read_result

    return _show(read_result(parsed.deck))


def _show(result: Result) -> int:
    from continuum.console import NOT_CONVERGED, OK, show_table

    area = result.slab.shape[0] * result.slab.shape[1]
    pushing, pulling = result.traction > 0, result.traction < 0
    rows = [
        ["separation", f"{result.separation:.10g}", "a0"],
        ["mean gap", f"{result.gap.mean():.10g}", "a0"],
        ["load N", f"{result.load:.10g}", "E* a0²"],
        ["repulsive load N_rep", f"{result.traction[pushing].sum():.10g}", "E* a0²"],
        ["A_rep/A0", f"{pushing.sum() / area:.6g}", ""],
        ["A_att/A0", f"{pulling.sum() / area:.6g}", ""],
        ["total energy", f"{result.total_energy:.10g}", "E* a0³"],
        ["largest force left", f"{result.largest_force:.3g}", "E* a0²"],
        ["force evaluations", str(result.evaluations), ""],
        ["LAMMPS", str(result.lammps_version), ""],
        ["status", result.status.value, ""],
    ]
    show_table("equilibrium of the deck", ["quantity", "value", "unit"], rows)
    return OK if result.status.ok else NOT_CONVERGED


def _doctor(parsed: argparse.Namespace) -> int:
    from atomistic.engine import doctor
    from continuum.console import NOT_CONVERGED, OK, show_table

    found = doctor()
    rows = [
        ["in this process", "works" if found.in_process else "does NOT work"],
        ["lmp", found.lmp or "does NOT work"],
        ["mpiexec -n 2 lmp", found.mpiexec or "does NOT work"],
        ["version", str(found.version) if found.version else "unknown"],
        ["MPI (mpich)", found.mpi or "none"],
        ["packages", ", ".join(found.packages)],
        *(["problem", problem] for problem in found.problems),
        *([["what to do", found.remedy]] if found.remedy else []),
    ]
    show_table("LAMMPS on this machine", ["what", "found"], rows)
    print("usable" if found.ok else "NOT usable")
    return OK if found.ok else NOT_CONVERGED
