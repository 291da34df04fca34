"""LAMMPS in this process: on a few atoms, for the constants of a crystal, or on those of a deck; forces anywhere."""

import contextlib
import ctypes
import tempfile
from functools import partial
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.model import AnyCrystalModel, Potential
from atomistic.lammps.directory import read_slab
from atomistic.lammps.engine import guard, open_library
from atomistic.lammps.result import LammpsError
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

    def evaluate(self, positions: Real) -> tuple[float, Real]:
        """Energy of all atoms, and forces, at positions of shape (..., 3), in the units of LAMMPS."""
        at = np.ascontiguousarray(positions, dtype=np.float64)
        self._lammps.scatter_atoms("x", 1, 3, at.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
        self.command("run 0 post no")
        return float(self._lammps.get_thermo("pe")), self._gathered("f").reshape(at.shape)

    def positions(self) -> Real:
        """Positions of all atoms, shape (n, 3)."""
        return self._gathered("x").reshape(-1, 3)

    def _gathered(self, name: str) -> Real:
        return np.array(self._lammps.gather_atoms(name, 1, 3), dtype=np.float64)


class Cell(LammpsHandle):
    """LAMMPS open in this process on a few atoms in an orthogonal box, in the units of their potential.

    Parameters
    ----------
    potential : interatomic potential.
    positions : shape (n, 3).
    periods : periods of the box along x, y and z; with ``surface`` it is not periodic along z.
    surface : whether the surfaces along z are free.
    types : which element each atom is, from 0, shape (n,); the first if None.
    """

    def __init__(
        self,
        potential: Potential | AnyCrystalModel,
        positions: Real,
        periods: Real,
        surface: bool = False,
        types: NDArray[np.int64] | None = None,
    ) -> None:
        self._scratch = tempfile.TemporaryDirectory()
        super().__init__(Path(self._scratch.name))  # gone when closed
        self._free = surface
        # Room for displacements beyond the outermost atoms.
        bottom, top = float(positions[:, 2].min()), float(positions[:, 2].max())
        self._low = bottom - potential.cutoff if surface else 0.0
        high = top + potential.cutoff if surface else float(periods[2])
        bonds = potential.atom_style == "bond"
        try:
            for name, content in potential.files.items():
                (self.directory / name).write_bytes(content)
            room = " bond/types 1 extra/bond/per/atom 12 extra/special/per/atom 24" if bonds else ""
            self.command(
                f"units {potential.units}",
                f"boundary p p {'f' if surface else 'p'}",
                "atom_modify map yes",
                *potential.settings().splitlines(),
                f"region box block 0 {periods[0]:.17g} 0 {periods[1]:.17g} {self._low:.17g} {high:.17g} units box",
                f"create_box {len(potential.masses)} box{room}",
                *(f"mass {i} {mass:.17g}" for i, mass in enumerate(potential.masses, 1)),
            )
            count = len(positions)
            inside = np.array(positions, dtype=np.float64)
            periodic = slice(0, 2 if surface else 3)
            inside[:, periodic] %= np.asarray(periods)[periodic]
            kinds = [1] * count if types is None else (types + 1).tolist()
            made = self._lammps.create_atoms(count, list(range(1, count + 1)), kinds, inside.ravel())
            if made != count:
                raise LammpsError(f"LAMMPS took {made} of {count} atoms into its box")
            self.command(
                f"neighbor {0.02 * potential.cutoff:.17g} bin",
                "neigh_modify one 20000 page 200000",  # a cut-off may hold thousands of neighbours
                *potential.interactions().splitlines(),
                "compute pressure all pressure NULL virial",
                "thermo_style custom pe c_pressure[*]",
                "thermo_modify norm no",
            )
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        super().close()
        self._scratch.cleanup()

    def deform(self, periods: Real, tilts: str = "") -> None:
        """Change the periods of the box, and tilts as LAMMPS has them; the atoms keep their positions."""
        z = "" if self._free else f" z final 0 {periods[2]:.17g}"
        self.command(f"change_box all x final 0 {periods[0]:.17g} y final 0 {periods[1]:.17g}{z}{tilts} units box")

    @property
    def pressure_unit(self) -> float:
        """LAMMPS' unit of energy per volume, in its unit of pressure."""
        return float(self._lammps.extract_global("nktv2p"))

    def fix(self, name: str, element: int) -> float:
        """Element of the vector that a fix has averaged."""
        return float(self._lammps.extract_fix(name, 0, 1, element))

    def per_atom(self, name: str) -> Real:
        """What a fix has averaged of each atom, in the order of the atoms."""
        return np.array(self._lammps.gather(f"f_{name}", 1, 1), dtype=np.float64)

    def stress(self, count: int = 3) -> Real:
        """Stress xx, yy, zz, xy, xz, yz of the last evaluation, tension positive, in units of energy per volume."""
        pressure = self._lammps.extract_compute("pressure", 0, 1)
        return -np.array(pressure[:count], dtype=np.float64) / self.pressure_unit


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
        energy, forces = super().evaluate((self._rest + displacements) * self.length)
        if self._lammps.extract_setting("thermo_norm"):
            energy *= self.slab.size
        return energy / self.energy, forces / (self.energy / self.length)

    def _where_at_rest(self) -> Real:
        """Positions without the displacements of the start, shape (layers, nx, ny, 3), in a0."""
        moved = np.array(self._lammps.gather("c_u", 1, 4), dtype=np.float64).reshape(-1, 4)[:, :3]
        # Those of slab.data, except for rounding and for atoms that crossed the border of the box.
        at = self._gathered("x").reshape(moved.shape)
        rest = ((at - moved) / self.length).reshape(*self.slab.ids.shape, 3)
        rest[..., :2] = self.slab.positions[..., :2]
        return rest
