"""A deck on disk: a self-contained directory that a stock ``lmp -in in.contact`` runs, serial or with MPI.

A :class:`Deck` is checked completely, then rendered from ``templates/`` by strict substitution.  Only numbers
formatted here and commands of the interatomic model enter a script, and never text from a user.
"""

import hashlib
import itertools
import json
import re
import string
import textwrap
from collections.abc import Mapping
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from typing import BinaryIO

import numpy as np
import scipy
from numpy.typing import NDArray

import continuum
from atomistic.crystal.crystal import LAYER_SPACING, LOST, Slab
from atomistic.crystal.potentials import POTENTIAL
from atomistic.lammps.acting import wall_files, wall_words
from atomistic.lammps.crystal_wall import DATA
from atomistic.lammps.deck import Deck
from atomistic.lammps.earlier import OUTPUTS, PARTS, remove_outputs, step_keys, steps_to_keep
from atomistic.lammps.language import formatted, listing
from atomistic.lammps.law import name_of, native_law, read_law, wall_table
from atomistic.lammps.lock import LOCK, hold
from atomistic.lammps.plugin import LIBRARY, MAP, SOURCE, plugin_library
from atomistic.lammps.protocol import time_unit
from atomistic.lammps.shape import force_lines
from continuum.errors import OutputError
from continuum.files.output import MARK, folder, save, whole
from continuum.measure.contact import ATTRACTED, REPULSIVE
from continuum.model.fourier import Real
from continuum.model.walls import TabulatedWall, Wall

FORMAT = "stickiness deck 4"
"""Format name in ``deck.json``."""
HEIGHTS = "wall.heights"
"""File of the heights of the wall in a deck."""
SCRIPTS = ("in.contact", "in.slab", "in.wall", "in.output", "README.txt")
INPUTS = (
    *SCRIPTS, "in.relax", "in.motion", "slab.data", "slab.start", HEIGHTS, "wall.table", "wall.vtk", "deck.json",
    "stiffness.npy", "input.toml", SOURCE, LIBRARY, MAP, "in.place", DATA,
)  # fmt: skip
"""Files of a deck, of equilibria or of a motion, in addition to those of its interatomic model."""
_EARLIER = ("crystal.cpp", "crystal.so", "wall.crystal")
"""Files of decks of earlier versions."""
_POTENTIALS = re.compile(rf"{re.escape(POTENTIAL)}|potential\.\d+")

LEAST_VERSION = 20240207, "7 February 2024"
"""Oldest LAMMPS that runs a deck, as variables need ternary(x,y,z)."""
_TOO_OLD = f"this_deck_needs_LAMMPS_of_{LEAST_VERSION[1].replace(' ', '_')}_or_later"
"""An unknown command, with which LAMMPS ends; `quit` would end a Python that it runs in, too."""

_TITLE = "fcc(100) slab of {} x {} atoms x ({} mobile + {} frozen) layers, at rest"
"""First line of ``slab.data``."""


class _Template(string.Template):
    """Placeholders are @{name}: $ belongs to LAMMPS."""

    delimiter = "@"


def render(deck: Deck) -> dict[str, str]:
    """Names and texts of the files of a deck, without its atoms."""
    model, wall = deck.model, deck.wall
    bonds = model.atom_style == "bond"
    surface_atoms = deck.slab.ids[0].size
    values = {
        "units": model.units,
        "length": formatted(model.length),
        "force": formatted(model.energy / model.length),
        "energy": formatted(model.energy),
        "element": model.element,
        "separation": formatted(deck.separation),
        "tolerance": formatted(deck.tolerance),
        "evaluations": f"{deck.evaluations:d}",
        "surface": formatted(deck.rest[0, 0, 0, 2]),
        "law": native_law(wall, deck.wall_tolerance).lines,
        "zero_gap": formatted(wall.zero_gap),
        "reach": formatted(wall.zero_gap + wall.range),
        "repulsive": f"{REPULSIVE:d}",
        "attracted": f"{ATTRACTED:d}",
        "settings": model.settings(),
        "room": " &\n                extra/bond/per/atom 12 extra/special/per/atom 24" if bonds else "",
        "surface_atoms": f"{surface_atoms:d}",
        "mobile_atoms": f"{deck.slab.mobile * surface_atoms:d}",
        "timestep": formatted(model.timestep * time_unit(model)),
        "real_units": _real_units(deck),
        "atoms": f"{deck.slab.size:d}",
        "input": "input.toml    the input that this deck is of\n" if deck.source else "",
        "version": continuum.__version__,
        "least": LEAST_VERSION[1],
        "least_version": f'if "$(version) < {LEAST_VERSION[0]}" then "{_TOO_OLD}"',
        "model": textwrap.fill(model.reference, 118),
        "notes": "".join(f"{textwrap.fill(''.join(filter(str.isprintable, note)), 118)}\n" for note in deck.notes),
        "potential": "".join(f"{name:13} the potential, as its authors wrote it\n" for name in model.files),
        "package": "MOLECULE" if bonds else "that of the pair_style" if model.files else "EXTRA-PAIR",
        **dict.fromkeys(_STRUCTURE, ""),
        **({} if bonds else _STRUCTURE),
        **force_lines(deck.shape),
        **_steps(deck),
        **wall_words(deck),
    }
    protocol = deck.protocol
    script, included = ("single", "in.relax") if protocol is None else (protocol.script, protocol.included)
    crystal = () if deck.crystal is None else ("in.place",)
    names = {name: name for name in (*SCRIPTS, included, *crystal)} | {"in.contact": f"contact.{script}"}
    templates = files("atomistic.lammps") / "templates"
    acts = (templates / f"wall.{deck.wall_force}").read_text(encoding="utf-8")
    values["acts"] = _Template(acts).substitute(values)
    texts = {
        name: _Template((templates / template).read_text(encoding="utf-8")).substitute(values)
        for name, template in names.items()
    }
    mesh = wall_mesh(deck.heights, deck.separation + float(deck.rest[0, 0, 0, 2]), model.length)
    return texts | wall_files(deck) | {"wall.table": wall_table(wall, deck.wall_tolerance), "wall.vtk": mesh}


_STRUCTURE = {
    "structure": (
        "# Common neighbours of each atom: 1 fcc, 2 hcp as in a stacking fault, 5 others, as at the surface;\n"
        "# neighbours are nearer than half way between the first and the second shell.\n"
        f"compute         structure all cna/atom $({LOST:.17g}*v_length_unit)\n"
    ),
    "structure_column": " c_structure",
    "structure_name": " &\n                colname c_structure structure",
}
"""Placeholders of the common neighbour analysis, which crystals of fixed bonds do without."""
_INCLUDED = {
    "in.relax": {
        "how": "in.relax      how an equilibrium is found",
        "found": "load, areas, energies, largest force left: converged if largest_force <= tolerance",
        "averages": "",
        "velocities": "",
    },
    "in.motion": {
        "how": "in.motion     how the atoms move, and what is averaged",
        "found": "means over the window with their standard errors, and load and areas at its end",
    },
}
"""Placeholders for the script that each step of a deck includes."""


def _steps(deck: Deck) -> dict[str, str]:
    """Placeholders of the scripts of the protocol."""
    protocol = deck.protocol
    if protocol is None:
        return _INCLUDED["in.relax"] | {"results": "", "steps": "1"}
    return {
        **_INCLUDED[protocol.included],
        "results": ".N",
        "steps": f"{protocol.steps:d}",
        "separations": listing(protocol.separations),
        **protocol.placeholders(deck.model, deck.slab.mobile, deck.slab.ids[0].size),
    }


def _real_units(deck: Deck) -> str:
    """Load and pressure in SI, if the crystal has a length scale."""
    real = deck.model.real_units
    if real is None:
        return ""
    newtons, pascals = real.si("force") / scipy.constants.nano, real.si("pressure") / scipy.constants.giga
    area = deck.slab.ids[0].size
    return (
        f'  "load_nN": $(v_load*{formatted(newtons)}:%.17g),\n'
        f'  "mean_pressure_GPa": $(v_load*{formatted(pascals / area)}:%.17g),\n'
    )


def write_deck(directory: Path, deck: Deck, *, force: bool = False) -> Path:
    """Write a deck into a directory, which is made if needed; returns the directory.

    An earlier deck is replaced.  Its finished steps are kept if the new deck reaches them by the same steps, so that
    an extended protocol continues; others are removed if ``force``. ``in.contact`` is written last: without it a
    directory is no deck.

    Raises OutputError or PluginError, and changes nothing, if the directory has other files (which are left alone
    beside a deck that ``force`` replaces), or finished steps of another deck without ``force``, or a run is under way
    there, or it cannot be written to; or if the plugin cannot be built.
    """
    directory = Path(directory)
    texts = render(deck)
    keys = step_keys(deck, texts)
    texts["deck.json"] = _description(deck, texts, keys)
    keep = 0
    if directory.exists():
        if not directory.is_dir():
            raise OutputError(f"{directory}: is not a folder; choose another one for the deck")
        known = {*INPUTS, *_EARLIER, *PARTS, LOCK}
        foreign = sorted(
            entry.name
            for entry in directory.iterdir()
            if entry.name not in known and not OUTPUTS.fullmatch(entry.name) and not _POTENTIALS.fullmatch(entry.name)
        )
        is_deck = (directory / "deck.json").is_file() and (directory / "in.slab").is_file()
        if foreign and not (force and is_deck):
            names = ", ".join(foreign[:5])
            leave = ", or leave them beside the new deck with --force" if is_deck else ""
            raise OutputError(
                f"{directory} has files that do not belong to a deck ({names}): choose another directory{leave}"
            )
        if _same(directory, texts["deck.json"]):
            return directory
        keep = steps_to_keep(directory, keys, force=force)
    library = plugin_library() if SOURCE in texts else None  # before anything there is touched
    folder(directory)
    with hold(directory):
        remove_outputs(directory, keep)
        (directory / "in.contact").unlink(missing_ok=True)
        for entry in list(directory.iterdir()):
            if _POTENTIALS.fullmatch(entry.name) or (entry.name in {*INPUTS, *_EARLIER} and entry.name not in texts):
                entry.unlink()
        for name, content in deck.model.files.items():
            save(directory / name, content, own=True)
        with whole(directory / "slab.data") as file:
            _write_data(file, deck)
        with whole(directory / HEIGHTS) as file:
            _write_atoms(file, deck.slab.ids[0], deck.heights)
        with whole(directory / "slab.start") as file:
            for axis in range(3):
                mobile = slice(0, deck.slab.mobile)
                _write_atoms(file, deck.slab.ids[mobile], deck.start[mobile, ..., axis])
        if deck.stiffness is not None:
            with whole(directory / "stiffness.npy") as file:
                np.save(file, deck.stiffness)
        if deck.source:
            save(directory / "input.toml", deck.source, own=True)
        if library is not None:
            save(directory / LIBRARY, library, own=True)
        for name in reversed(texts):  # in.contact last
            save(directory / name, texts[name], own=True)
    return directory


def _same(directory: Path, description: str) -> bool:
    try:
        there = (directory / "deck.json").read_text(encoding="utf-8") == description
    except (OSError, ValueError):
        return False
    return there and (directory / "in.contact").is_file()


def _description(deck: Deck, texts: Mapping[str, str], keys: list[str]) -> str:
    """``deck.json``: description of the deck for programs; its identity is a hash of all that LAMMPS reads."""
    digest = hashlib.sha256("".join(texts[name] for name in sorted(texts)).encode())
    for content in deck.model.files.values():
        digest.update(content)
    for array in (deck.heights, deck.start, deck.rest):
        digest.update(array.tobytes())
    wall, real, protocol = deck.wall, deck.model.real_units, deck.protocol
    heights = deck.heights
    law = name_of(wall)
    numbers = {} if law == TabulatedWall.__name__ else wall.numbers
    description = {
        "format": FORMAT,
        "identity": digest.hexdigest(),
        "steps": 0 if protocol is None else protocol.steps,
        "step_keys": keys,
        **({} if protocol is None else protocol.about()),
        "wall": {"law": law, **numbers},
        "element": deck.model.element,
        "model": deck.model.reference,
        "bonded": deck.model.atom_style == "bond",
        "surface": float(deck.rest[0, 0, 0, 2]),
        "heights": hashlib.sha256(heights.tobytes()).hexdigest(),
        "notes": list(deck.notes),
        "length": deck.model.length,
        "real_units": None if real is None else asdict(real),
    }
    return json.dumps(description, indent=2) + "\n"


def read_slab(path: Path) -> Slab:
    """The slab of a ``slab.data``; raises ValueError if the file does not belong to a deck."""
    with Path(path).open(encoding="utf-8") as file:
        title = file.readline().strip()
    numbers = [int(formatted) for formatted in re.findall(r"\d+", title)]
    if len(numbers) != 5 or title != _TITLE.format(*numbers[1:5]):
        raise ValueError(f"{path} is not the slab.data of a deck: it begins with {title[:80]!r}")
    nx, ny, mobile, frozen = numbers[1:5]
    return Slab((nx, ny), mobile, frozen)


def read_heights(path: Path) -> Real:
    """Heights of the wall above the lattice sites of the surface atoms, shape (nx, ny), in a0, of a ``slab.data``.

    They stand beside it in ``wall.heights``; in decks of earlier versions, in a section of it.

    Raises ValueError if the file does not belong to a deck.
    """
    path = Path(path)
    shape = read_slab(path).shape
    beside = path.with_name(HEIGHTS)
    with (beside if beside.is_file() else path).open(encoding="utf-8") as file:
        rows = iter(file) if beside.is_file() else itertools.dropwhile(lambda line: line != "WallHeight\n", file)
        heights = np.loadtxt(itertools.islice(rows, 2, 2 + shape[0] * shape[1]), usecols=1, ndmin=1)
    return np.asarray(heights, dtype=np.float64).reshape(shape)


def read_wall(directory: Path) -> Wall:
    """The wall law of a deck.

    Raises ValueError, TypeError, KeyError or OSError if its ``deck.json`` or ``wall.table`` is invalid.
    """
    directory = Path(directory)
    numbers = json.loads((directory / "deck.json").read_text(encoding="utf-8"))["wall"]
    return read_law(numbers.pop("law"), numbers, directory / "wall.table")


def _write_data(file: BinaryIO, deck: Deck) -> None:
    """``slab.data``: the slab at rest."""
    slab, model = deck.slab, deck.model
    bonds = model.atom_style == "bond"
    nx, ny = slab.shape
    ids = slab.ids.ravel()
    # Two spacings of room on both sides, and up to the highest point of the wall, to which adhesion may lift an atom:
    # nothing leaves the box.
    low = -slab.layers * LAYER_SPACING - 2
    highest = max(deck.protocol.separations) if deck.protocol else deck.separation
    high = 2 + max(0.0, highest + float(deck.heights.max()))
    ends = [formatted(model.length * value) for value in (nx, ny, low, high)]
    file.write(
        f"{_TITLE.format(nx, ny, slab.mobile, slab.frozen)}\n\n"
        f"{slab.size} atoms\n1 atom types\n{'1 bond types' if bonds else ''}\n\n"
        f"0 {ends[0]} xlo xhi\n0 {ends[1]} ylo yhi\n{ends[2]} {ends[3]} zlo zhi\n\n"
        f"Masses\n\n1 {formatted(model.mass)} # {model.element}\n\nAtoms # {model.atom_style}\n\n".encode()
    )
    kind = "%d 1 1" if bonds else "%d 1"  # molecule and type, or type
    _write_rows(file, f"{kind} %.17g %.17g %.17g\n", ids, model.length * deck.rest.reshape(-1, 3))


def _write_atoms(file: BinaryIO, ids: NDArray[np.int64], values: Real) -> None:
    """One number for each of some atoms, as LAMMPS reads them into an atomfile variable."""
    file.write(f"# Atom and value\n{ids.size}\n".encode())
    _write_rows(file, "%d %.17g\n", ids.ravel(), values.reshape(-1, 1))


def _write_rows(file: BinaryIO, form: str, ids: NDArray[np.int64], values: Real) -> None:
    """A line for each atom.  Three times as fast as :func:`numpy.savetxt`, and in little memory."""
    at_once = 10_000
    for first in range(0, len(ids), at_once):
        part = slice(first, first + at_once)
        rows = np.column_stack([ids[part], values[part]])
        file.write((form * len(rows) % tuple(rows.ravel().tolist())).encode())


def wall_mesh(heights: Real, level: float, length: float, offset: tuple[float, float] = (0.0, 0.0)) -> str:
    """The wall as triangles, in legacy VTK, which OVITO and ParaView show above the atoms: text of a file.

    The mesh includes both ends of the period.

    Parameters
    ----------
    heights : heights of the wall above each surface atom, shape (nx, ny), in a0.
    level : height of its zero above the lattice plane of the surface, in a0: separation plus rise of the surface.
    length : a0 in LAMMPS' unit of length, in which the mesh is written.
    offset : offset of the wall along x and y, in a0.
    """
    z = length * (level + np.pad(heights, ((0, 1), (0, 1)), mode="wrap"))
    nx, ny = z.shape
    axes = (np.arange(n) + shift for n, shift in zip(z.shape, offset, strict=True))
    x, y = (length * axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    points = np.column_stack([x, y, z.ravel()])
    corner = (np.arange(nx - 1)[:, None] * ny + np.arange(ny - 1)).ravel()
    # Two triangles for each square, turned to the atoms below.
    triangles = np.concatenate([
        np.column_stack([corner, corner + 1, corner + ny]),
        np.column_stack([corner + 1, corner + ny + 1, corner + ny]),
    ])  # fmt: skip
    lines = [
        "# vtk DataFile Version 3.0",
        f"rigid wall, in LAMMPS' unit of length; {MARK.decode()}",
        "ASCII",
        "DATASET POLYDATA",
        f"POINTS {len(points)} double",
        *(" ".join(f"{value:.10g}" for value in point) for point in points),
        f"POLYGONS {len(triangles)} {4 * len(triangles)}",
        *(f"3 {a} {b} {c}" for a, b, c in triangles.tolist()),
    ]
    return "\n".join(lines) + "\n"
