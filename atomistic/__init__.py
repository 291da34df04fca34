"""Explicit fcc(100) atoms under a rigid rough wall, in LAMMPS: the check on the Green's-function model.

Units, signs and names are those of :mod:`continuum`, with one addition: a surface atom stands for one point
of the grid, of area a0², so that the force of the wall on it is traction x a0² and its wall energy is energy
per area x a0². Forces and displacements of atoms are vectors, positive towards the wall (+z); tractions are
positive in compression.

Arrays over the atoms of a slab have the shape (layers, nx, ny) or (layers, nx, ny, 3): layer 0 is the
surface, and atom [0, i, j] is the point [i, j] of the grid.
"""

import re
from importlib import import_module
from pathlib import Path

_NAMES = re.compile(r"^from (\S+) import (\w+)", re.MULTILINE)
# Imported when they are asked for: `atomistic --help` needs none of them.
_MODULES = {name: module for module, name in _NAMES.findall(Path(__file__).with_suffix(".pyi").read_text())}
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'atomistic' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
