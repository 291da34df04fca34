"""Words and options of the command ``continuum``; what it imports is light, so that ``--help`` comes at once."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Container, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

from continuum.errors import EXIT_CODES, InputError

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

FORMATS = ("png", "pdf", "svg")
"""Of figures."""
SHELLS = ("bash", "zsh", "tcsh")
"""Whose words can be completed."""

KINDS = ("run",)
"""Inputs of which there is a template."""


def until_stopped(command: Callable[[], int]) -> int:
    """Exit code of a command; stopped before its work began, which has its own message, it says so."""
    try:
        return command()
    except KeyboardInterrupt:
        sys.stderr.write("stopped; nothing was done\n")
        return 1


def as_options(message: str, known: Container[str]) -> str:
    """A message in which arguments stand in backticks, with the options of the command in their place."""

    def option(found: re.Match[str]) -> str:
        name = "estar" if found[1] == "contact_modulus" else found[1]
        return f"--{name.replace('_', '-')}" if found[1] in known else found[0]

    return re.sub(r"`(\w+)`", option, message)


def add_init(commands: argparse._SubParsersAction[Any], kinds: Sequence[str]) -> None:
    """The sub-commands `init` and `schema` of both programs."""
    init = commands.add_parser("init", help="print an input to begin with, every key with its meaning")
    init.add_argument("kind", choices=kinds, help="the command that it is for")
    schema = commands.add_parser("schema", help="print the JSON schema of an input, for editors that complete TOML")
    schema.add_argument("kind", choices=kinds, help="the command that the input is for")


def add_common(parser: argparse.ArgumentParser, commands: argparse._SubParsersAction[Any]) -> None:
    """What both programs have: versions, how much is said, and completion in a shell."""
    completion = commands.add_parser(
        "completion",
        help="print what completes commands and options in your shell",
        description=f"For bash: `{parser.prog} completion bash > ~/.local/share/bash-completion/completions/"
        f"{parser.prog}`, then a new shell.  Needs the extra: pip install 'stickiness[completion]'.",
    )
    completion.add_argument("shell", choices=SHELLS)
    parser.add_argument("--version", action=_Versions, nargs=0,
                        help="print the versions of program, Python, NumPy, LAMMPS and back ends")  # fmt: skip
    parser.set_defaults(voice="normal")
    for one in _parsers(parser):  # so that it may stand anywhere
        _add_voice(one)


def completion(parser: argparse.ArgumentParser, shell: str) -> str:
    """A script that completes the words of a program in a shell.

    Raises
    ------
    InputError
        If the library that writes it is not installed.
    """
    try:
        import shtab
    except ImportError:
        msg = "completion in a shell is an extra: pip install 'stickiness[completion]'"
        raise InputError(msg) from None
    for one in _parsers(parser):
        if isinstance(one, _Parser):
            one.complete()
        for action in one._actions:
            if action.type is Path or action.dest in ("file", "result"):
                vars(action).update(complete=shtab.FILE)
    return str(shtab.complete(parser, shell=shell))


def _parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """A parser and those of all its commands."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in action.choices.values():
                yield from _parsers(one)


def _add_voice(parser: argparse.ArgumentParser) -> None:
    voice = parser.add_mutually_exclusive_group()
    voice.add_argument("-q", "--quiet", dest="voice", action="store_const", const="quiet", default=argparse.SUPPRESS,
                       help="neither progress nor tables; results, warnings and errors stay")  # fmt: skip
    voice.add_argument("-v", "--verbose", dest="voice", action="store_const", const="verbose",
                       default=argparse.SUPPRESS,
                       help="a line for each part of the work, also on a terminal, and where in the program an error "
                       "arose")  # fmt: skip


class _Versions(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from continuum.files.provenance import versions

        parser._print_message(versions() + "\n", sys.stdout)
        parser.exit()


def add_format(parser: argparse.ArgumentParser) -> None:
    """Formats of the figures that a command draws."""
    parser.add_argument("--format", action="append", choices=FORMATS,
                        help="of the figures; may be repeated (default: png and pdf)")  # fmt: skip


def exit_codes() -> str:
    """With which codes a command ends, in a line."""
    return "Exit codes: " + ".  ".join(f"{code}: {meaning}" for code, meaning in EXIT_CODES.items()) + "."


def at_least_one(text: str) -> int:
    """An option that counts processes or threads."""
    if not (text.isdecimal() and 1 <= int(text) <= 1024):
        msg = f"{text!r}: allowed: a whole number from 1 to 1024"
        raise argparse.ArgumentTypeError(msg)
    return int(text)


class _Parser(argparse.ArgumentParser):
    """The parser of a command, some of whose options stand in tables that are slow to read."""

    later: Callable[[argparse.ArgumentParser], None] | None = None

    def complete(self) -> None:
        """Add the options of tables, once."""
        add, self.later = self.later, None
        if add is not None:
            add(self)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        self.complete()
        return super().parse_known_args(args, namespace)


def parser() -> argparse.ArgumentParser:
    """Of the command ``continuum``."""
    parser = argparse.ArgumentParser(
        prog="continuum",
        description="Adhesive contact of a rigid rough wall with an elastic substrate, by FFT Green's functions.",
        epilog=f"Units: a0 = 1 (atomic spacing), E* = 1 (contact modulus).  {exit_codes()}",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)

    _add_check(commands.add_parser(
        "check",
        help="validate an input file of a run or a sweep, and print what it amounts to and what it will cost",
        description="Validate an input file: all faults at once, what it amounts to, memory, FFT pairs, core-seconds.  "
        "Of a sweep, those of all its systems together.",
    ))  # fmt: skip
    _add_run(commands.add_parser(
        "run",
        help="follow a loading path and store areas, loads, contact maps and jumps",
        description="Follow a loading path.  [loading] of the input says how: control (separation, mean-gap, "
        "mean-pressure, repulsive-area) and targets; retract = true or [loading.retraction] for the way back; "
        "event_resolution to bracket jumps.  Stopped with Ctrl-C or otherwise, the same command goes on.",
    ))  # fmt: skip
    _add_sweep(commands.add_parser(
        "sweep",
        help="many systems: run, SLURM script, status, tables, verification",
        description="A sweep is an input with a table [sweep]: axes over any of its keys.  Each system is one path, "
        "stored in one file; whatever stops the work, the same command does what is missing.",
    ))  # fmt: skip
    _add_plot(commands.add_parser(
        "plot",
        help="draw the figures of a stored run, or a figure of the paper from a sweep",
        description="`plot RESULT` draws a run.  `plot FIGURE DIR` draws, from the files of a sweep alone, figure1 - "
        "figure4, figure-s1 - figure-s3, a further figure, `verdicts`, `page` (all) or `dispute` (theories beside).",
    ))  # fmt: skip
    analyse = commands.add_parser(
        "analyse",
        help="measure the stored points of runs: patches, perimeter, κ, gap profile, pull-off",
        description="Measure every point of stored runs, compare with the paper, and draw the figures.  The "
        "gap profile, d_att and the distributions need a run with fields = true in [output].",
    )
    analyse.add_argument("results", type=Path, nargs="+", metavar="RESULT", help="files written by `continuum run`")
    analyse.add_argument("-o", "--output", type=Path, help="folder of the figures (default: that of each result)")
    add_format(analyse)

    _add_predict(commands.add_parser(
        "predict",
        help="is my surface sticky? every criterion on a measured topography",
        description="Roughness of a measured topography, or of two that face each other, the verdict of every "
        "criterion of stickiness with its margin, and warnings.  Writes figures and a one-page HTML report.",
        epilog="Every quantity has a unit: 70GPa, 50mJ/m2, 0.5nm.  Example: continuum predict map.npy --size 10um "
        "--unit nm --modulus 2MPa --poisson 0.5 --work 50mJ/m2 --range 0.5nm",
    ))  # fmt: skip
    add_init(commands, KINDS)
    commands.add_parser("examples", help="print the paper's worked examples beside ours, as Markdown")
    add_common(parser, commands)
    return parser


def _add_run(run: argparse.ArgumentParser) -> None:
    run.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")
    run.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("results"),
        help="folder of the result, NAME.h5 after the input's name (default: results)",
    )
    run.add_argument("--force", action="store_true", help="start anew, whatever is stored")
    run.add_argument(
        "--device", help="what the solver runs on, instead of [solver] device: cpu, or cuda (experimental)"
    )
    _add_settings(run)


def _add_check(check: argparse.ArgumentParser) -> None:
    check.add_argument("file", help="input file (TOML); inputs/... finds those that come with the package")
    check.add_argument("--reduced", action="store_true", help="the smaller sizes of the [sweep.reduced] of a sweep")
    _add_settings(check)


def _add_plot(plot: argparse.ArgumentParser) -> None:
    plot.add_argument("result", help="file written by `continuum run`, or the name of a figure")
    plot.add_argument(
        "folders", nargs="*", type=Path, help="folder of a sweep, for a figure; several for `page` and `dispute`"
    )
    plot.add_argument("-o", "--output", type=Path, help="folder of the figures (default: that of the result)")
    add_format(plot)


def _add_settings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", type=_setting,
                        help="a value instead of that of the file, as surface.seed=3; may be repeated")  # fmt: skip


def _setting(text: str) -> tuple[str, object]:
    from continuum.files.toml import value_of

    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise argparse.ArgumentTypeError(f"{text!r}: write KEY=VALUE, such as surface.seed=3")
    return key.strip(), value_of(value.strip())


def _gigabytes(text: str) -> float:
    try:
        found = 1e9 * float(text)
    except ValueError:
        found = math.nan
    if not 0 < found < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}: allowed: a number of GB, greater than 0")
    return found


def _shard(text: str) -> tuple[int, int]:
    part, slash, parts = text.partition("/")
    if not (slash and part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise argparse.ArgumentTypeError(f"{text!r}: write I/N with I from 1 to N, such as 2/8")
    return int(part), int(parts)


def _add_sweep(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    run = actions.add_parser("run", help="do the systems that are not done yet")
    slurm = actions.add_parser("slurm", help="print a job script for sbatch")
    for one in (run, slurm):
        one.add_argument("file", help="input with a table [sweep]; inputs/sweep/... finds those of the package")
        one.add_argument("-o", "--output", type=Path, default=Path("results"),
                         help="folder in which that of the sweep is made (default: results)")  # fmt: skip
        one.add_argument("--reduced", action="store_true", help="the smaller sizes of [sweep.reduced]")
        _add_settings(one)
    run.add_argument("--workers", type=at_least_one, help="processes at once (default: 1, or one for each GPU)")
    run.add_argument("--device", help="what the solvers run on: cpu, or cuda (experimental), a GPU for each process")
    run.add_argument("--threads", type=at_least_one, default=1, help="threads of each (default: 1)")
    run.add_argument("--memory", type=_gigabytes, metavar="GB", help="of this machine that may be used (default: all)")
    run.add_argument("--retry", action="store_true", help="try again what failed")
    run.add_argument("--shard", type=_shard, default=(1, 1), metavar="I/N", help="part I of N of the systems")
    run.add_argument("--scheduler-file", type=Path, help="of a Dask cluster that does the work")
    slurm.add_argument("--nodes", type=at_least_one, default=1, help="of the allocation (default: 1)")
    slurm.add_argument("--time", default="12:00:00", help="of the allocation (default: 12:00:00)")
    slurm.add_argument("--workers", type=at_least_one, default=16, help="processes a node (default: 16)")
    slurm.add_argument("--array", type=at_least_one, metavar="N", help="an array of N jobs instead of one cluster")
    status = actions.add_parser("status", help="how far a sweep is, from its files alone")
    collect = actions.add_parser("collect", help="one table of all points: table.csv, and table.h5 for xarray")
    verify = actions.add_parser("verify", help="read every file whole: sums, schema, identity")
    for one in (status, collect, verify):
        one.add_argument("folder", type=Path, help="folder of the sweep")
    collect.add_argument("-o", "--output", type=Path, help="folder of the tables (default: that of the sweep)")
    verify.add_argument("--aside", action="store_true",
                        help="move what is damaged into DIR/damaged, so that the next run does it again")  # fmt: skip


def _add_predict(predict: _Parser) -> None:
    predict.later = _add_keys
    predict.add_argument("files", nargs="+", type=Path, metavar="FILE",
                         help="topography; two for two rough bodies; or one input (TOML) that names them")  # fmt: skip
    predict.add_argument("--solve", action="store_true", help="also solve the contact of the map and compare")
    predict.add_argument("--threads", type=at_least_one, default=1, help="threads of the solver (default: 1)")
    predict.add_argument("-o", "--output", type=Path, default=Path("results"),
                         help="folder of report and figures (default: results)")  # fmt: skip
    predict.add_argument("--json", type=Path, metavar="FILE", help="write everything, with the spectrum, in SI units")
    predict.add_argument("--csv", type=Path, metavar="FILE",
                         help="write one row for each of many files, and for each measurement of a container, "
                         "each a contact by itself; no pages")  # fmt: skip


def _add_keys(predict: argparse.ArgumentParser) -> None:
    """Options for the keys of the tables [topography] and [interface]."""
    from continuum.sticky.tables import InterfaceTable, TopographyTable

    for title, table in (("topography", TopographyTable), ("interface", InterfaceTable)):
        group = predict.add_argument_group(f"keys of [{title}]", table.__doc__)
        for name, field in table.model_fields.items():
            if name != "maps":
                _add_key(group, name, field)


def _add_key(group: argparse._ArgumentGroup, name: str, field: FieldInfo) -> None:
    """The option of one key."""
    option = "--estar" if name == "contact_modulus" else f"--{name.replace('_', '-')}"
    text = " ".join((field.description or "").split()).replace("%", "%%")
    choices = next((get_args(one) for one in get_args(field.annotation) if get_origin(one) is Literal), None)
    if field.annotation is bool:
        group.add_argument(option, dest=name, action="store_true", help=text)
    elif get_origin(field.annotation) is tuple:
        group.add_argument(option, dest=name, action="append", help=text)
    else:
        group.add_argument(option, dest=name, choices=choices, help=text)
