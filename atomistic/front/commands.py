"""The commands of ``atomistic``: each calls the function of its name, shows what it returns, and says how it went."""

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from atomistic.front import functions as front
from atomistic.front import validation
from atomistic.inputs.crystal import ElasticConfig
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder.comparison import paths_of
from atomistic.ladder.cost import told_of_writing
from atomistic.lammps import engine
from atomistic.lammps.include import SCRIPT
from atomistic.relax.decks import deck_input
from continuum.front.doctor import diagnosed
from continuum.front.options import FIGURES, like
from continuum.inputs.errors import OK
from continuum.inputs.reading import load
from continuum.inputs.reference import schema as schema_of
from continuum.inputs.reference import template
from continuum.inputs.tables import Fault
from continuum.inputs.toml import Document, refuse
from continuum.show.console import progress, progress_of_known, report, verbose

INPUTS: dict[str, tuple[type[Document], str]] = {
    "validate": (ValidateConfig, "inputs/validate/quick.toml"),
    "deck": (DeckConfig, "inputs/lammps/rough.toml"),
}
"""Inputs of which there is a template, and the example that it is made of."""
Kind = Literal["validate", "deck"]


@like(validation.validate, resumes=True)
def validate(file: str, *, lmp_command: str | None = None, **given: Any) -> int:
    engine.command_words(lmp_command, "--lmp-command")
    config = load(file, ValidateConfig)
    with progress(len(paths_of(config)), f"validate {Path(file).stem}") as tell:
        found = validation.validate(
            config, lmp_command=lmp_command, progress=lambda text, done, _: tell(done, text), **given
        )
    page, *figures = found.write()
    report(lines=found.statements())
    lines = [f"Tables and {len(figures)} figures: {page}", f"Numbers: {found.path}"]
    return report(*(found.sheets() if verbose() else ()), lines=lines, ok=found.holds)


@like(front.check)
def check(**given: Any) -> int:
    return report(front.check(**given))


@like(front.run_deck, resumes=True)
def deck(
    file: Annotated[str, Parameter(help="input file (TOML); inputs/... finds those that come with the package")],
    *,
    output: Annotated[Path | None, Parameter(help="directory of the deck (default: decks/NAME)")] = None,
    start: Annotated[
        bool,
        Parameter(help="relax each state with this package first, so that LAMMPS only confirms it"),
    ] = False,
    run: Annotated[bool, Parameter(help="run the deck at once and print its states")] = False,
    force: Annotated[
        bool, Parameter(help="replace another deck in that directory and its finished steps; other files are kept")
    ] = False,
    lmp_command: str | None = None,
) -> int:
    """Write a LAMMPS deck that a stock lmp runs, serial or with MPI."""
    engine.command_words(lmp_command, "--lmp-command")
    title = "relaxing the states" if start else "measuring the crystal at its temperature, once"
    with progress_of_known(title) as tell_parts:
        config = deck_input(file, tell_parts)
        large = told_of_writing(config)
        report(lines=[f"cost     {large}"] if large else [])
        made = front.deck(config, start=start, progress=tell_parts)
    with progress_of_known("tables of atoms") as tell_tables:
        place = output or Path("decks") / Path(file).stem
        directory = made.write(place, force=force, progress=tell_tables if large else None)
    report(lines=[f"deck     {directory}: {made.slab.size} atoms, starting from the lattice solution"])
    report(lines=[f"copied   {path}, which is not in the folder of the input" for path in made.copied])
    report(lines=[f"start    {made.notes[-1].removeprefix('Starts: ')}"] if start else [])
    report(lines=[f"wall     {made.crystal.about}"] if made.crystal is not None else [])
    if run:
        steps = 1 if made.protocol is None else made.protocol.steps
        with progress(steps, f"deck {directory.name}") as tell:
            found = front.run_deck(directory, lmp_command, lambda done, _: tell(done, ""))
        return report(*found.sheets(), ok=found.converged and found.finished)
    return report(lines=[
        "run it   lmp -in in.contact   or   mpiexec -n 4 lmp -in in.contact   in that directory",
        f"then     atomistic read {directory}",
    ])  # fmt: skip


@like(front.write_wall)
def wall(
    surface: Annotated[str, Parameter(help="measured map of heights, of which a part of the size of the box is taken")],
    *,
    directory: Annotated[
        Path, Parameter(name=("--output", "-o"), help="folder of the wall, from where lmp runs")
    ] = Path("wall"),
    **given: Any,
) -> int:
    made = front.write_wall(surface, directory, **given)
    return report(lines=[f"wall     {directory / SCRIPT}: {made.about}", *made.steps(directory)])


@like(front.read, draws=FIGURES)
def read(
    directory: Path,
    *,
    output: Annotated[Path, Parameter(help="folder for the HDF5 file, the figure and the walls")] = Path("results"),
    compare: Annotated[bool, Parameter(help="compare with the continuum solution of the same wall")] = False,
    certify: Annotated[bool, Parameter(help="check its equilibria independently of the run")] = False,
) -> int:
    if directory.is_file():  # of a wall in a script
        trace = front.read_trace(directory)
        return report(*trace.sheets(), lines=[f"figure   {path}" for path in trace.write(output, directory.stem)])
    run = front.read(directory)
    report(*run.sheets(compare=compare))
    ok = run.converged and run.finished
    if certify:
        found = run.certify()
        report(*found.sheets(), warnings=found.faults)
        ok = ok and found.ok
    stored, figure, *others = run.write(output, compare=compare)
    walls = [path for path in others if path.suffix == ".vtk"]
    more = f" and {len(walls) - 1} more" if len(walls) > 1 else ""
    lines = [f"result   {stored}", f"figure   {figure}", f"wall     {walls[0]}{more}, for OVITO and ParaView"]
    return report(lines=[*lines, *(f"file     {path}" for path in others if path not in walls)], ok=ok)


@like(front.elastic, draws=FIGURES)
def elastic(
    file: str,
    *,
    output: Annotated[Path, Parameter(help="folder for the figure")] = Path("results"),
    lattice: int | None = None,
) -> int:
    fewest, most = front.LATTICES
    if lattice is not None and not fewest <= lattice <= most:
        raise refuse(load(file, ElasticConfig), Fault((), f"--lattice of {fewest} to {most}, got {lattice}"))
    found = front.elastic(file, lattice=lattice)
    report(*found.sheets())
    return report(lines=[f"figure   {figure}" for figure in found.plot(output, Path(file).stem)])


@like(front.doctor)
def doctor() -> int:
    return diagnosed(front.doctor())


@like(template)
def init(kind: Annotated[Kind, Parameter(help="input that is printed")]) -> int:
    """Print a template of an input, with every key explained."""
    print(template(*INPUTS[kind]), end="")
    return OK


@like(schema_of)
def schema(kind: Annotated[Kind, Parameter(help="input whose schema is printed")]) -> int:
    """Print the JSON schema of an input, for editors that complete TOML."""
    print(schema_of(INPUTS[kind][0]), end="")
    return OK
