"""The command ``atomistic``: parse, call, print."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from continuum.options import add_common, add_format, add_init, at_least_one, completion, exit_codes, until_stopped

if TYPE_CHECKING:
    from atomistic.front.decks import DeckRun
    from continuum.files.tables import Document


EXAMPLES = {"validate": "inputs/validate/quick.toml", "deck": "inputs/lammps/rough.toml"}
"""Inputs of which there is a template, and the example that it is made of."""
LMP_HELP = 'how your site starts LAMMPS, e.g. "srun lmp" (default: the installed library, in this process)'


def parser() -> argparse.ArgumentParser:
    """Of the command ``atomistic``."""
    parser = argparse.ArgumentParser(
        prog="atomistic",
        description="Explicit fcc(100) atoms under a rigid rough wall, in LAMMPS: the check on Green's functions.",
        epilog=f"Units: a0 = 1 (nearest-neighbour distance), E* = 1 (contact modulus).  {exit_codes()}",
    )
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
        type=at_least_one,
        default=None,
        help="processes, one core each (default: all cores, at most 4)",
    )
    validate.add_argument("--keep-decks", type=Path, metavar="DIR", help="keep every LAMMPS deck in this folder")
    validate.add_argument("--lmp-command", metavar="CMD", help=LMP_HELP)
    validate.add_argument("--force", action="store_true", help="start anew, whatever is stored")

    _deck_parsers(commands)
    elastic = commands.add_parser(
        "elastic", help="lattice constant, elastic constants, E*(100) by direction and surface relaxation of a crystal"
    )
    elastic.add_argument("file", help="input file (TOML) with a table [interatomic]; its other tables do not matter")
    elastic.add_argument(
        "-o", "--output", type=Path, default=Path("results"), help="folder of the figure (default: results)"
    )
    elastic.add_argument(
        "--lattice",
        type=int,
        metavar="N",
        help="also measure the lattice Green's function of N x N surface atoms, N a0 deep (N of 48 to 256), "
        "and compare it with the continuum",
    )
    add_format(elastic)

    check = commands.add_parser("check", help="validate an input file and print what it will cost")
    check.add_argument("file", help="input of validate, deck or elastic (TOML)")
    commands.add_parser("doctor", help="is LAMMPS usable here, which one, and if not what to do")
    add_init(commands, tuple(EXAMPLES))
    add_common(parser, commands)
    return parser


def _deck_parsers(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    deck = commands.add_parser("deck", help="write a LAMMPS deck that a stock lmp runs, serial or with MPI")
    deck.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")
    deck.add_argument("-o", "--output", type=Path, help="directory of the deck (default: decks/NAME)")
    deck.add_argument("--run", action="store_true", help="run it at once and print what it found")
    deck.add_argument("--lmp-command", metavar="CMD", help=LMP_HELP)

    read = commands.add_parser(
        "read", help="print, store and draw what a run of a deck found, and whether these are equilibria"
    )
    read.add_argument("deck", type=Path, help="directory of the deck")
    read.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("results"),
        help="folder of the HDF5 file, the figure and the walls (default: results)",
    )
    read.add_argument("--compare", action="store_true", help="put the continuum of the same wall beside it")
    add_format(read)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return until_stopped(partial(_main, arguments))


def _main(arguments: Sequence[str] | None) -> int:
    parsed = parser().parse_args(arguments)
    from continuum.show.console import exit_code

    command = {
        "check": _check,
        "validate": _validate,
        "deck": _deck,
        "read": _read,
        "elastic": _elastic,
        "doctor": _doctor,
        "init": _init,
        "schema": _schema,
        "completion": _completion,
    }[parsed.command]
    return exit_code(
        lambda: command(parsed),
        "What is finished is stored; `atomistic doctor` looks at the LAMMPS of this machine.",
        parsed.voice,
    )


def _completion(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK

    print(completion(parser(), parsed.shell), end="")
    return OK


def _model(kind: str) -> type[Document]:
    """What an input of a command holds."""
    from atomistic.config.deck import DeckConfig
    from atomistic.config.validate import ValidateConfig

    models: dict[str, type[Document]] = {"validate": ValidateConfig, "deck": DeckConfig}
    return models[kind]


def _init(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.files.reference import template

    print(template(_model(parsed.kind), EXAMPLES[parsed.kind]), end="")
    return OK


def _schema(parsed: argparse.Namespace) -> int:
    from continuum.errors import OK
    from continuum.files.reference import schema

    print(schema(_model(parsed.kind)), end="")
    return OK


def _validate(parsed: argparse.Namespace) -> int:
    from atomistic.config.validate import ValidateConfig
    from atomistic.front.commands import validate
    from atomistic.ladder.comparison import paths_of
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.files.inputs import load
    from continuum.show.console import progress, show

    _check_lmp_command(parsed)
    config = load(parsed.file, ValidateConfig)
    with progress(len(paths_of(config)), f"validate {Path(parsed.file).stem}") as tell:
        found = validate(
            config,
            parsed.output,
            workers=parsed.workers,
            decks=parsed.keep_decks,
            lmp_command=parsed.lmp_command,
            force=parsed.force,
            progress=lambda text, done, total: tell(done, text),
        )
    for sheet in found.sheets():
        show(sheet)
    page, *figures = found.write()
    print(f"result   {found.path}")
    for figure in figures:
        print(f"figure   {figure}")
    print(f"report   {page}")
    print(found.sentence)
    return OK if found.holds else NOT_CONVERGED


def _check_lmp_command(parsed: argparse.Namespace) -> None:
    """Refuse a command of a site that is none, by the name of its option."""
    from atomistic.lammps.engine import command_words
    from continuum.arguments import ArgumentError

    if parsed.lmp_command is None:
        return
    try:
        command_words(parsed.lmp_command)
    except ArgumentError as error:
        raise ArgumentError("--lmp-command", parsed.lmp_command, error.allowed) from None


def _check(parsed: argparse.Namespace) -> int:
    from atomistic.front.commands import check
    from continuum.errors import OK
    from continuum.show.console import show

    show(check(parsed.file))
    return OK


def _deck(parsed: argparse.Namespace) -> int:
    from atomistic.front.decks import deck, run_deck
    from continuum.errors import OK, InputError
    from continuum.show.console import progress

    _check_lmp_command(parsed)
    made = deck(parsed.file)
    if not made.stock and (not parsed.run or parsed.lmp_command is not None):
        msg = (
            f"{parsed.file}: LAMMPS has no formula for the heights of this wall above where the atoms are "
            '(follows = "atom"): no stock LAMMPS can run the deck; run it in this process (--run, without '
            '--lmp-command), or let the wall follow the sites (follows = "site")'
        )
        raise InputError(msg)
    directory = made.write(parsed.output or Path("decks") / Path(parsed.file).stem)
    print(f"deck     {directory}: {made.slab.size} atoms, starting from the lattice solution")
    if parsed.run:
        steps = 1 if made.protocol is None else made.protocol.steps
        with progress(steps, f"deck {directory.name}") as tell:
            found = run_deck(directory, parsed.lmp_command, lambda done, _: tell(done, ""))
        return _show(found)
    print("run it   lmp -in in.contact   or   mpiexec -n 4 lmp -in in.contact   in that directory")
    print(f"then     atomistic read {directory}")
    return OK


def _read(parsed: argparse.Namespace) -> int:
    from atomistic.front.decks import read
    from continuum.show.plot import written_as

    run = read(parsed.deck)
    code = _show(run, compare=parsed.compare)
    with written_as(parsed.format):
        stored, figure, *walls = run.write(parsed.output, compare=parsed.compare)
    print(f"result   {stored}")
    print(f"figure   {figure}")
    print(f"wall     {walls[0]}{f' and {len(walls) - 1} more' if len(walls) > 1 else ''}, for OVITO and ParaView")
    return code


def _show(run: DeckRun, *, compare: bool = False) -> int:
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.show.console import show

    for sheet in run.sheets(compare=compare):
        show(sheet)
    return OK if run.converged and run.finished else NOT_CONVERGED


def _elastic(parsed: argparse.Namespace) -> int:
    from atomistic.config.crystal import ElasticConfig
    from atomistic.front.commands import elastic
    from continuum.errors import OK
    from continuum.files.inputs import load
    from continuum.files.tables import refuse
    from continuum.show.console import show
    from continuum.show.plot import written_as
    from continuum.tables import Fault

    if parsed.lattice is not None and not 48 <= parsed.lattice <= 256:
        raise refuse(load(parsed.file, ElasticConfig), Fault((), f"--lattice of 48 to 256, got {parsed.lattice}"))
    found = elastic(parsed.file, lattice=parsed.lattice)
    for sheet in found.sheets():
        show(sheet)
    with written_as(parsed.format):
        for figure in found.plot(parsed.output, Path(parsed.file).stem):
            print(f"figure   {figure}")
    return OK


def _doctor(parsed: argparse.Namespace) -> int:
    from atomistic.front.commands import doctor
    from continuum.errors import NOT_CONVERGED, OK
    from continuum.show.console import show
    from continuum.show.sheet import pairs

    found = doctor()
    rows = [
        ("in this process", "works" if found.in_process else "does NOT work"),
        ("lmp", found.lmp or "does NOT work"),
        ("mpiexec -n 2 lmp", found.mpiexec or "does NOT work"),
        ("version", str(found.version) if found.version else "unknown"),
        ("MPI (mpich)", found.mpi or "none"),
        ("packages", ", ".join(found.packages)),
        *(("problem", problem) for problem in found.problems),
        *([("what to do", found.remedy)] if found.remedy else []),
    ]
    show(pairs("LAMMPS on this machine", rows))
    print("usable" if found.ok else "NOT usable")
    return OK if found.ok else NOT_CONVERGED
