"""The files of a deck on disk: their names, those that are read back, and which LAMMPS is writing there.

A step keeps its result where a new deck reaches it by the same steps: the same atoms, wall and scripts, and the same
numbers of this step and of all before it.  An extended staircase thus continues from its finished steps.
"""

import itertools
import json
import re
from contextlib import AbstractContextManager
from math import prod
from pathlib import Path
from typing import BinaryIO, TextIO

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.crystal import AnySlab, AtomSlab, Slab
from atomistic.lammps.law import read_law
from continuum.inputs.errors import OutputError
from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.store.output import MARK, locked

FORMAT = "stickiness deck 4"
"""Format name in ``deck.json``."""
HEIGHTS = "wall.heights"
"""File of the heights of the wall in a deck."""
TITLE = "fcc(100) slab of {} x {} atoms x ({} mobile + {} frozen) layers, at rest"
"""First line of ``slab.data`` of fcc(100), whose sites follow from these numbers."""
OTHER_TITLE = "{} slab of {} surface + {} mobile + {} frozen atoms, at rest: a0 = {!r}, neighbours within {!r} a0"
"""First line of any other slab, whose sites are the positions in the file."""
_OTHER = re.compile(re.sub(r"\\{(!r)?\\}", r"(\\S+)", re.escape(OTHER_TITLE)))
MAP = "wall.npy"
"""Heights of the wall at the points of a grid, where these are not the surface atoms."""
OUTPUTS = re.compile(
    r"(?:result(\.\d+)?\.json)|(?:(?:surface|state)(\.\d+)?\.dump)|(?:log(\.\d+)?\.lammps)|(?:(?:height|trace)(\.\d+)?\.txt)"
)
"""Files that a run of the deck writes: of one equilibrium, or of each step with its number."""
PARTS = ("state.part", "result.part")
"""Files that a run leaves when it is killed as it writes them."""
LOCK = "run.lock"
"""Name of the lock file."""
PATIENCE = 2.0
"""Seconds to wait for the end of a killed process."""


def hold(directory: Path) -> AbstractContextManager[int]:
    """Hold the lock of a directory; gives its descriptor, which is passed to the processes that write there.

    The lock (:func:`continuum.store.output.locked`) belongs to the open file: children that inherit the descriptor hold
    it, too, even if this process is killed, and it ends with the last of them.

    Raises LockedError if another run holds it, naming the process that started it; OutputError if the directory cannot
    be written to.
    """

    def refusal(holder: str) -> str:
        return (
            f"{directory}: a run is under way there, begun by {holder}; wait for it, or end it with its children, "
            f"which may outlive it (`fuser -k {LOCK}` there, on that machine)"
        )

    return locked(Path(directory) / LOCK, refusal, inherited=True, patience=PATIENCE)


def finished_steps(directory: Path) -> tuple[int, ...]:
    """Numbers of the finished steps, in order; (0,) for a single equilibrium."""
    found = (re.fullmatch(r"result(?:\.(\d+))?\.json", entry.name) for entry in Path(directory).iterdir())
    return tuple(sorted(int(name[1] or 0) for name in found if name))


def steps_to_keep(directory: Path, keys: list[str], *, force: bool) -> int:
    """Number of first steps whose results a deck with these keys may keep.

    Raises OutputError if finished steps would be removed, and not ``force``.
    """
    try:
        there = json.loads((directory / "deck.json").read_text(encoding="utf-8"))["step_keys"]
        same = next(
            (i for i, (a, b) in enumerate(zip(keys, there, strict=False)) if a != b), min(len(keys), len(there))
        )
    except (OSError, ValueError, KeyError, TypeError):
        same = 0  # none, damaged, or of an earlier version
    lost = [step for step in finished_steps(directory) if max(step, 1) > same]
    if lost and not force:
        count = f"{len(lost)} finished steps" if len(lost) > 1 else "a finished step"
        raise OutputError(
            f"{directory} has {count} of another deck, which this one would remove\n"
            "    Choose another directory with --output, or remove them with --force"
        )
    return same


def remove_outputs(directory: Path, keep: int = 0) -> None:
    """Remove the outputs of runs of a deck except its first steps; with none to keep, also of a single equilibrium."""
    for entry in Path(directory).iterdir():
        found = OUTPUTS.fullmatch(entry.name)
        step = int(next(filter(None, found.groups()), ".1")[1:]) if found else 0
        if (found and step > keep) or entry.name in PARTS:
            entry.unlink(missing_ok=True)


def title_of(slab: AnySlab, length: float) -> str:
    """First line of ``slab.data``, for a0 in LAMMPS' unit of length."""
    if slab.one_to_one:
        return TITLE.format(*slab.shape, slab.mobile, slab.size // slab.surface_atoms - slab.mobile)
    surface, mobile = slab.surface_atoms, slab.mobile_atoms
    return OTHER_TITLE.format(slab.name, surface, mobile - surface, slab.size - mobile, length, slab.lost)


def read_slab(path: Path) -> AnySlab:
    """The slab of a ``slab.data``; raises ValueError if the file does not belong to a deck."""
    with Path(path).open(encoding="utf-8") as file:
        title = file.readline().strip()
        if found := _OTHER.fullmatch(title):
            return _read_atoms(file, *found.groups())
    numbers = [int(formatted) for formatted in re.findall(r"\d+", title)]
    if len(numbers) != 5 or title != TITLE.format(*numbers[1:5]):
        raise ValueError(f"{path} is not the slab.data of a deck: it begins with {title[:80]!r}")
    nx, ny, mobile, frozen = numbers[1:5]
    return Slab((nx, ny), mobile, frozen)


def _read_atoms(file: TextIO, name: str, surface: str, mobile: str, frozen: str, length: str, lost: str) -> AtomSlab:
    """The slab of the lines below its title."""
    a0, size, ends = float(length), int(surface) + int(mobile) + int(frozen), list[float]()
    for line in file:
        if line.rstrip().endswith("hi"):
            ends.append(float(line.split()[1]))
        if line.startswith("Atoms"):
            rows = np.loadtxt(file, skiprows=1, max_rows=size, ndmin=2)
            types, period, moving = rows[:, -4].astype(np.int64) - 1, (ends[0] / a0, ends[1] / a0), size - int(frozen)
            return AtomSlab(name, period, rows[:, -3:] / a0, types, int(surface), moving, float(lost))
    raise ValueError(f"{file.name} ends before its atoms")


def read_heights(path: Path) -> Real:
    """Heights of the wall at the points of the grid of a ``slab.data``, its surface atoms, shape (nx, ny), in a0.

    They stand beside it in ``wall.heights``, or of other slabs than fcc(100) in ``wall.npy``; in decks of earlier
    versions, in a section of it.

    Raises ValueError if the file does not belong to a deck.
    """
    path = Path(path)
    if path.with_name(MAP).is_file():
        return np.asarray(np.load(path.with_name(MAP)), dtype=np.float64)
    shape = read_slab(path).shape
    beside = path.with_name(HEIGHTS)
    with (beside if beside.is_file() else path).open(encoding="utf-8") as file:
        rows = iter(file) if beside.is_file() else itertools.dropwhile(lambda line: line != "WallHeight\n", file)
        heights = np.loadtxt(rows, skiprows=2, usecols=1, max_rows=prod(shape))
    return np.asarray(heights, dtype=np.float64).reshape(shape)


def read_wall(directory: Path) -> Wall:
    """The wall law of a deck.

    Raises ValueError, TypeError, KeyError or OSError if its ``deck.json`` or ``wall.table`` is invalid.
    """
    directory = Path(directory)
    numbers = json.loads((directory / "deck.json").read_text(encoding="utf-8"))["wall"]
    return read_law(numbers.pop("law"), numbers, directory / "wall.table")


def write_atoms(file: BinaryIO, ids: NDArray[np.int64], values: Real) -> None:
    """One number for each of some atoms, as LAMMPS reads them into an atomfile variable."""
    file.write(f"# Atom and value\n{ids.size}\n".encode())
    write_rows(file, "%d %.17g\n", ids.ravel(), values.reshape(-1, 1))


def write_rows(file: BinaryIO, form: str, ids: NDArray[np.int64], values: Real) -> None:
    """A line for each atom.  Three times as fast as :func:`numpy.savetxt`, and in little memory."""
    at_once = 10_000
    for first in range(0, len(ids), at_once):
        part = slice(first, first + at_once)
        rows = np.column_stack([ids[part], values[part]])
        file.write((form * len(rows) % tuple(rows.ravel().tolist())).encode())


def wall_mesh(
    heights: Real,
    level: float,
    length: float,
    offset: tuple[float, float] = (0.0, 0.0),
    spacing: tuple[float, float] = (1.0, 1.0),
) -> str:
    """The wall as triangles, in legacy VTK, which OVITO and ParaView show above the atoms: text of a file.

    The mesh includes both ends of the period.

    Parameters
    ----------
    heights : heights of the wall at the points of the grid, in a0.
    level : height of its zero above the lattice plane of the surface, in a0: separation plus rise of the surface.
    length : a0 in LAMMPS' unit of length, in which the mesh is written.
    offset : offset of the wall along x and y, in a0.
    spacing : distances of the points of the grid along x and y, in a0.
    """
    z = length * (level + np.pad(heights, ((0, 1), (0, 1)), mode="wrap"))
    nx, ny = z.shape
    axes = (np.arange(n) * step + shift for n, step, shift in zip(z.shape, spacing, offset, strict=True))
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
