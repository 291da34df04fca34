"""LAMMPS in this process on the atoms of a deck: forces at any displacements."""

import contextlib
import ctypes
from functools import partial
from pathlib import Path
from typing import Self

import numpy as np

from atomistic.lammps.directory import read_slab
from atomistic.lammps.engine import guard, open_library
from continuum.model.fourier import Real


class LammpsHandle:
    """LAMMPS in this process, with commands run in a directory; close it, or use it with ``with``.

    Errors of LAMMPS are raised as LammpsError.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory.absolute()
        self._lammps = open_library()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        self._lammps.close()

    def command(self, *lines: str) -> None:
        """Run commands in LAMMPS' language."""
        with contextlib.chdir(self.directory):
            for line in lines:
                guard(partial(self._lammps.command, line), self.directory)

    def _forces_at(self, positions: Real) -> tuple[float, Real]:
        """Energy and forces of the atoms at positions of shape (..., 3), in the units of LAMMPS."""
        at = np.ascontiguousarray(positions, dtype=np.float64)
        self._lammps.scatter_atoms("x", 1, 3, at.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
        self.command("run 0 post no")
        return float(self._lammps.get_thermo("pe")), self._gathered("f").reshape(at.shape)

    def _gathered(self, name: str) -> Real:
        return np.array(self._lammps.gather_atoms(name, 1, 3), dtype=np.float64)


class Session(LammpsHandle):
    """LAMMPS in this process on the atoms of the deck of a directory, without its wall."""

    def __init__(self, directory: Path) -> None:
        self.slab = read_slab(Path(directory) / "slab.data")
        super().__init__(Path(directory))
        try:
            self.run("in.slab")
            self.length, self.energy = self.variable("length_unit"), self.variable("energy_unit")
            self._rest = self._where_at_rest()
        except BaseException:
            self.close()
            raise

    def run(self, script: str) -> None:
        with contextlib.chdir(self.directory):
            guard(partial(self._lammps.file, script), self.directory)

    def variable(self, name: str) -> float:
        """Value of an equal-style variable."""
        return float(self._lammps.extract_variable(name))

    def evaluate(self, displacements: Real) -> tuple[float, Real]:
        """Energy, in E* a0³, and forces, in E* a0², at displacements from the slab at rest, in a0.

        Displacements and forces have the shape (layers, nx, ny, 3).
        """
        energy, forces = self._forces_at((self._rest + displacements) * self.length)
        if self._lammps.extract_setting("thermo_norm"):
            energy *= self.slab.size
        return energy / self.energy, forces / (self.energy / self.length)

    def _where_at_rest(self) -> Real:
        """Positions without the displacements of the start, shape (layers, nx, ny, 3), in a0."""
        start = [np.array(self._lammps.gather(f"d_u{axis}", 1, 1), dtype=np.float64) for axis in "xyz"]
        # Those of slab.data, except for rounding and for atoms that crossed the border of the box.
        rest = self._positions() - np.stack(start, axis=-1).reshape(*self.slab.ids.shape, 3)
        rest[..., :2] = self.slab.positions[..., :2]
        return rest

    def _positions(self) -> Real:
        return self._gathered("x").reshape(*self.slab.ids.shape, 3) / self.length
