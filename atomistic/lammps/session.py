"""LAMMPS open in this process on the atoms of a deck: forces at any displacements, walls evaluated in Python."""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from atomistic.lammps.directory import read_slab
from atomistic.lammps.engine import guard, open_library
from continuum.model.fourier import Real


class LammpsHandle:
    """LAMMPS open in this process, its commands run in a directory; close it, or use it with ``with``.

    Whatever goes wrong in LAMMPS is a LammpsError.
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
    """LAMMPS open in this process on the atoms of the deck of a directory, without its wall."""

    def __init__(self, directory: Path) -> None:
        self.slab = read_slab(Path(directory) / "slab.data")
        self._failure: BaseException | None = None
        super().__init__(Path(directory))
        try:
            self.run("in.slab")
            self.length, self.energy = self.variable("length_unit"), self.variable("energy_unit")
            self._rest = self._where_at_rest()
        except BaseException:
            self.close()
            raise

    def run(self, script: str) -> None:
        """Run a script of the deck."""
        with contextlib.chdir(self.directory):
            guard(partial(self._lammps.file, script), self.directory)
        self._raise_failure()

    def command(self, *lines: str) -> None:
        for line in lines:
            super().command(line)
            self._raise_failure()

    def variable(self, name: str) -> float:
        """Value of an equal-style variable."""
        return float(self._lammps.extract_variable(name))

    def apply(self, forces: Callable[[Real], tuple[Real, float]]) -> None:
        """Let vertical forces act on the surface atoms, in every evaluation from now on.

        Parameters
        ----------
        forces : given the height of each surface atom above the surface at rest, shape (nx, ny), in a0, the force on
            it, positive upwards, same shape, in E* a0², and the energy of all, in E* a0³.
        """
        shape = self.slab.shape
        count = shape[0] * shape[1]

        def callback(_: Any, step: int, local: int, tag: NDArray[np.int64], x: Real, f: Real) -> None:
            try:
                mine = np.flatnonzero(tag <= count)
                site = tag[mine] - 1
                z = np.empty(count)
                z[site] = x[mine, 2] / self.length
                force, energy = forces(z.reshape(shape) - self._rest[0, ..., 2])
                f[...] = 0.0
                f[mine, 2] = force.reshape(-1)[site] * (self.energy / self.length)
                self._lammps.fix_external_set_energy_global("applied", energy * self.energy)
            except BaseException as error:
                self._failure = error

        self.command("fix applied surface external pf/callback 1 1")
        self.command("fix_modify applied energy yes")
        self._lammps.set_fix_external_callback("applied", callback, None)

    def evaluate(self, displacements: Real) -> tuple[float, Real]:
        """Energy, in E* a0³, and forces, in E* a0², of atoms displaced from where the slab is at rest, in a0.

        Displacements and forces have the shape (layers, nx, ny, 3).
        """
        energy, forces = self._forces_at((self._rest + displacements) * self.length)
        if self._lammps.extract_setting("thermo_norm"):
            energy *= self.slab.size
        return energy / self.energy, forces / (self.energy / self.length)

    def displacements(self) -> Real:
        """Displacements of the atoms from where the slab is at rest, shape (layers, nx, ny, 3), in a0."""
        moved = self._positions() - self._rest
        # Atoms that crossed the border of the box have come back on the other side.
        period = np.array(self.slab.shape, dtype=np.float64)
        moved[..., :2] -= period * np.rint(moved[..., :2] / period)
        return moved

    def _where_at_rest(self) -> Real:
        """Positions without the displacements of the start, shape (layers, nx, ny, 3), in a0."""
        start = [np.array(self._lammps.gather(f"d_u{axis}", 1, 1), dtype=np.float64) for axis in "xyz"]
        # As they are in slab.data but for rounding, and for atoms that crossed the border of the box.
        rest = self._positions() - np.stack(start, axis=-1).reshape(*self.slab.ids.shape, 3)
        rest[..., :2] = self.slab.positions[..., :2]
        return rest

    def _positions(self) -> Real:
        return self._gathered("x").reshape(*self.slab.ids.shape, 3) / self.length

    def _raise_failure(self) -> None:
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
