"""The command ``atomistic``: parse, call, print."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import continuum

if TYPE_CHECKING:
    from atomistic.crystal.interatomic import Model
    from atomistic.lammps.result import Result

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

    commands.add_parser("doctor", help="is LAMMPS usable here, which one, and if not what to do")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parsed = _parser().parse_args(arguments)
    from atomistic.crystal.potentials import PotentialError
    from atomistic.lammps.result import LammpsError
    from continuum.files.store import StoreError
    from continuum.runs.config import ConfigError
    from continuum.show.console import exit_code
    from continuum.solve.smooth import NotConvergedError

    command = {"validate": _validate, "deck": _deck, "read": _read, "elastic": _elastic, "doctor": _doctor}[
        parsed.command
    ]
    return exit_code(
        lambda: command(parsed),
        (ConfigError, PotentialError, StoreError, FileExistsError),
        (LammpsError, NotConvergedError),
        "What is finished is stored; `atomistic doctor` looks at the LAMMPS of this machine.",
    )


def _validate(parsed: argparse.Namespace) -> int:
    from atomistic.config import ValidateConfig
    from atomistic.relax.specimen import specimen_of
    from atomistic.show import report
    from atomistic.show.plot import draw_all
    from atomistic.validate import archive, budget
    from atomistic.validate.validate import units, validate
    from continuum.runs.config import Fault, load, refuse
    from continuum.show.console import NOT_CONVERGED, OK, progress, show_table

    config = load(parsed.file, ValidateConfig)
    stem = Path(parsed.file).stem
    path = parsed.output / f"{stem}.h5"
    workers = parsed.workers or min(4, os.cpu_count() or 1)
    if workers < 1:
        raise refuse(config, Fault((), "a positive number of --workers"))
    datasets = {} if parsed.force else archive.resume(path, config)
    todo = archive.remaining(config, {name: d.values for name, d in datasets.items()})
    about = specimen_of(config).about() if todo else {}
    parsed.output.mkdir(parents=True, exist_ok=True)
    total = len(units(config))
    done = total - len(todo)
    with progress(total, f"validate {stem}", done) as tell:
        for result in validate(config, todo, min(workers, max(1, len(todo))), parsed.keep_decks, parsed.lmp_command):
            datasets = archive.join(config, datasets, archive.datasets_of([result]))
            archive.write(path, config, datasets, about)
            done += 1
            largest = max(state.largest_force for state in result.states) / result.unit.rms_slope
            tell(done, f"{result.unit.label}: {len(result.states)} equilibria, max|f| {largest:.1e} h' E* a0²")
    stored = archive.read(path)[0]
    figures = draw_all(stored, parsed.output, stem)
    verdicts = list(budget.verdicts(config, stored.columns))
    for listing in report.listings(stored, verdicts):
        show_table(*listing)
    page = report.write_html(parsed.output / f"{stem}.html", stem, config, stored, verdicts, figures)
    print(f"result   {path}")
    for figure in figures:
        print(f"figure   {figure}")
    print(f"report   {page}")
    print(report.summary(verdicts))
    return OK if all(verdict.holds for verdict in verdicts) else NOT_CONVERGED


def _deck(parsed: argparse.Namespace) -> int:
    from atomistic.config import DeckConfig
    from atomistic.lammps.deck import write_deck
    from atomistic.lammps.engine import runner
    from atomistic.relax.relax import deck_of
    from continuum.runs.config import load
    from continuum.show.console import OK

    deck = deck_of(load(parsed.file, DeckConfig))
    directory = write_deck(parsed.output or Path("decks") / Path(parsed.file).stem, deck)
    print(f"deck     {directory}: {deck.slab.size} atoms, starting from the lattice solution")
    if parsed.run:
        return _show(runner(parsed.lmp_command)(directory))
    print("run it   lmp -in in.contact   or   mpiexec -n 4 lmp -in in.contact   in that directory")
    print(f"then     atomistic read {directory}")
    return OK


def _read(parsed: argparse.Namespace) -> int:
    from atomistic.lammps.result import read_result

    return _show(read_result(parsed.deck))


def _show(result: Result) -> int:
    from continuum.show.console import NOT_CONVERGED, OK, show_table

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


def _elastic(parsed: argparse.Namespace) -> int:
    import numpy as np

    from atomistic.config import ElasticConfig
    from atomistic.crystal.crystal import LAYER_SPACING
    from atomistic.crystal.elastic import ContactModulus
    from atomistic.response.force_constants import relaxation
    from atomistic.response.material import Material, model_of
    from atomistic.show.plot import draw_contact_modulus
    from continuum.runs.config import Fault, load, refuse
    from continuum.show.console import OK, show_table
    from continuum.units import GPA_PER_EV_PER_A3

    config = load(parsed.file, ElasticConfig)
    if parsed.lattice is not None and not 48 <= parsed.lattice <= 256:
        raise refuse(config, Fault((), f"--lattice of 48 to 256, got {parsed.lattice}"))
    model = model_of(config.interatomic.potential())
    reduced = ContactModulus.of(model.elastic_constants)
    length, pressure, unit = "a0", "E*", 1.0
    rows = [["model", model.reference, "", ""]]
    if isinstance(model, Material):
        metal = model.units == "metal"
        length, pressure = ("Å", "GPa") if metal else ("σ", "ε/σ³")
        energy = "eV" if metal else "ε"
        unit = model.contact_modulus * (GPA_PER_EV_PER_A3 if metal else 1)
        others = ", ".join(f"{name} {e - model.crystal.energy:+.4g}" for name, e in model.crystal.others.items())
        rows += [
            ["energy per atom", f"{model.crystal.energy:.8g}", energy, ""],
            ["of other structures, less that", others, energy, ""],
        ]
    rows += [
        ["lattice constant", f"{model.lattice_constant * model.length:.8g}", length, f"{model.lattice_constant:.6f}"],
        ["nearest neighbours, a0", f"{model.length:.8g}", length, "1"],
        ["forces reach", f"{model.force_range:.6g}", length, f"{model.force_range / model.length:.4f}"],
        ["layers that they reach", f"{model.reach}", "", ""],
    ]
    moduli = [*zip(("C11", "C12", "C44"), model.elastic_constants, strict=True)]
    moduli += [
        ("E*(100), smallest", reduced.smallest),
        ("E*(100), mean 1/<1/E*>", reduced.mean),
        ("E*(100), largest", reduced.largest),
        ("E*(100) along <100>", reduced.along_100),
        ("E*(100) along <110>", reduced.along_110),
    ]
    rows += [[name, f"{unit * value:.7g}", pressure, f"{value:.6f}"] for name, value in moduli]
    rise = relaxation(model, 40)
    planes = ", ".join(f"{100 * s:+.3f} %" for s in -np.diff(rise)[:3] / LAYER_SPACING + 0.0)
    rows += [
        ["surface plane rises by", f"{rise[0] * model.length:+.6g}", length, f"{rise[0]:+.6f}"],
        ["planes 1-2, 2-3, 3-4 apart by more", planes, "", ""],
    ]
    source = "measured in LAMMPS" if isinstance(model, Material) else "exact lattice sums"
    show_table(f"fcc crystal at zero pressure, {source}", ["quantity", "value", "unit", "in a0, E*"], rows)
    stem = Path(parsed.file).stem
    figure = draw_contact_modulus(reduced, parsed.output / f"{stem}-contact-modulus", stem)
    print(f"figure   {figure}")
    if parsed.lattice is not None:
        _show_lattice(model, parsed.lattice, parsed.output / f"{stem}-discreteness", stem)
    return OK


def _show_lattice(model: Model, n: int, figure: Path, title: str) -> None:
    from atomistic.crystal.crystal import Slab
    from atomistic.response.cache import default_folder, response_path, stored_response
    from atomistic.response.discreteness import discreteness
    from atomistic.show.plot import draw_discreteness
    from continuum.model.grid import Grid
    from continuum.show.console import show_table

    slab = Slab.of_depth(Grid.square(n), float(n), model.reach)
    response = stored_response(slab, model, default_folder())
    found = discreteness(response, model.elastic_constants)
    constants = response.force_constants
    rows = [["forces reach", f"{constants.reach} layers"], ["layers not as in the bulk", str(constants.depth)]]
    if constants.checks is not None:
        rows += [[f"violation of {name}", f"{value:.1e}"] for name, value in vars(constants.checks).items()]
    lengths = sorted({2.0, 3.0, 4.0, 6.0, 8.0, n / 8, n / 4, n / 2, float(n)})
    rows += [[f"difference at {length:g} a0", f"{100 * found.worst(length):+.3f} %"] for length in lengths]
    rows += [
        ["limit of difference/q along <110>", f"{found.along_110:+.4f} a0"],
        ["limit of difference/q along <100>", f"{found.along_100:+.4f} a0"],
    ]
    show_table(
        f"surface stiffness of the lattice, {n} x {n} x {slab.mobile} layers, against the cubic layer of its constants",
        ["quantity", "value"],
        rows,
        "difference: K_lattice/K_continuum - 1 in the worst direction, by wavelength",
    )
    print(f"table    {response_path(slab, model, default_folder())}")
    print(f"figure   {draw_discreteness(found, figure, title)}")


def _doctor(parsed: argparse.Namespace) -> int:
    from atomistic.lammps.engine import doctor
    from continuum.show.console import NOT_CONVERGED, OK, show_table

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
