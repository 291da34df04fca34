"""LAMMPS in this process: on a few atoms, for the constants of a crystal, or on those of a deck; forces anywhere."""

import contextlib
import ctypes
import shutil
import tempfile
import weakref
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.model import AnyCrystalModel, Potential
from atomistic.crystal.potentials import PotentialError
from atomistic.lammps.deck import Deck, render, write_deck
from atomistic.lammps.directory import read_slab
from atomistic.lammps.engine import guard, open_library
from atomistic.lammps.language import formatted
from atomistic.lammps.result import DeckResult, LammpsError, named
from continuum.model.fourier import Real

_BEYOND = {
    "atom attribute q": "atoms have no charges here, which comb, ReaxFF and their like need: use another potential",
    "metal units are in use": "`pair-style` is in LAMMPS' units `metal`: use a potential in these",
}
"""Parts of LAMMPS' messages about a potential that cannot be used here, with the reason."""


class LammpsHandle:
    """LAMMPS in this process, with commands run in a directory; close it, or use it with ``with``.

    Errors of LAMMPS are raised as LammpsError.
    """

    names: Mapping[str, str] | None = None
    """Names of the files of the potential as they were given, for messages; those of the deck if None."""

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
                guard(partial(self._lammps.command, line), self.directory, self.names)

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
        self._free, self.names, self._potential, self._tried = surface, potential.names, potential, False
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
            )
            with self._refusing():
                self.command(*potential.interactions().splitlines())
            self.command(
                "compute pressure all pressure NULL virial",
                "thermo_style custom pe c_pressure[*]",
                "thermo_modify norm no",
            )
        except BaseException:
            self.close()
            raise

    def evaluate(self, positions: Real) -> tuple[float, Real]:
        # Some styles refuse a potential as it is first evaluated; later errors are those of the positions.
        with nullcontext() if self._tried else self._refusing():
            found = super().evaluate(positions)
        self._tried = True
        return found

    @contextlib.contextmanager
    def _refusing(self) -> Iterator[None]:
        """Errors of LAMMPS as errors of the potential, which it refuses as it is defined or first evaluated."""
        try:
            yield
        except LammpsError as error:
            said = named(str(error.__cause__ or error), self._potential.names)
            beyond = "".join(f"\n    {why}" for part, why in _BEYOND.items() if part in said)
            msg = f"LAMMPS refuses this potential: {said}\n    {self._potential.reference}{beyond}"
            raise PotentialError(msg) from error

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
        """Averages of a fix for each atom, in the order of the atoms."""
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
            self._begin()
        except BaseException:
            self.close()
            raise

    @classmethod
    def on_atoms_of(cls, deck: Deck) -> Self:
        """LAMMPS on the atoms of a deck at rest, for all decks of these atoms; its files go when it does."""
        folder = tempfile.mkdtemp()
        try:
            session = cls(write_deck(Path(folder), replace(deck, displacements=None)))
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        weakref.finalize(session, shutil.rmtree, folder, ignore_errors=True)
        return session

    def _begin(self) -> None:
        self.command("clear")
        self.run("in.slab")
        # Sorted as it goes, the order of the atoms, and so the last digits of sums, would depend on what was before.
        self.command("atom_modify sort 0 0")
        self.length, self.energy = self.variable("length_unit"), self.variable("energy_unit")
        self._rest = self._where_at_rest()

    def run(self, script: str) -> None:
        with contextlib.chdir(self.directory):
            guard(partial(self._lammps.file, script), self.directory)

    @property
    def rest(self) -> Real:
        """Positions of the slab at rest, shape (layers, nx, ny, 3), in a0."""
        return self._rest

    def variable(self, name: str) -> float:
        """Value of an equal-style variable."""
        return float(self._lammps.extract_variable(name))

    def evaluate(self, displacements: Real) -> tuple[float, Real]:
        """Energy, in E* a0³, and forces, in E* a0², at displacements from the slab at rest, in a0.

        Displacements and forces have the shape (layers, nx, ny, 3).  After an error, as of lost atoms, LAMMPS has them
        at rest again.
        """
        try:
            energy, forces = super().evaluate((self._rest + displacements) * self.length)
        except LammpsError:
            self._begin()
            raise
        if self._lammps.extract_setting("thermo_norm"):
            energy *= self.slab.size
        return energy / self.energy, forces / (self.energy / self.length)

    def under(self, deck: Deck) -> DeckResult:
        """The start of a deck of these atoms under its wall, as LAMMPS finds it by one evaluation of the forces.

        The wall is one of formulas that is a function of the lattice site, at one separation.
        """
        slab = self.slab
        heights = np.zeros(slab.size)
        heights[: slab.mobile_atoms] = deck.above
        self._lammps.scatter("d_height", 1, 1, heights.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
        before = self._defined()
        with contextlib.chdir(self.directory):
            self.command("variable separation delete", f"variable separation index {formatted(deck.separation)}")
            guard(partial(self._lammps.commands_string, render(deck)["in.wall"]), self.directory)
        energy, forces = self.evaluate(deck.start)
        surface = np.argsort(self._lammps.numpy.extract_atom("id")[: slab.size])[: slab.surface_atoms]
        gap, traction = (
            np.array(self._lammps.extract_variable(name, "mobile"))[surface].reshape(slab.shape)
            for name in ("gap", "traction")
        )

        def total(name: str) -> float:
            return float(self._lammps.extract_compute(name, 0, 0))

        found = DeckResult(
            slab=slab, heights=deck.heights, gap=gap, traction=traction, displacements=self.displacements(),
            forces=forces, step=0, separation=deck.separation, offset_x=0.0, offset_y=0.0, target_force=0.0,
            force=total("load"), lateral_x=total("lateral_x"), lateral_y=total("lateral_y"),
            area_rep=self.variable("area_rep"), area_att=self.variable("area_att"), wall_energy=total("wall_energy"),
            total_energy=energy, largest_force=total("largest_force") / (self.energy / self.length),
            tolerance=deck.tolerance, smallest_gap=total("smallest_gap"), core=self.variable("core"), evaluations=1,
            lammps_version=self._lammps.version(), bonded=deck.model.atom_style == "bond",
        )  # fmt: skip
        self.command("thermo_style one", *(f"un{kind} {name}" for kind, name in self._defined() - before))
        return found

    def _defined(self) -> set[tuple[str, str]]:
        """Kinds and names of the fixes and computes in LAMMPS."""
        return {(kind, name) for kind in ("fix", "compute") for name in self._lammps.available_ids(kind)}

    def displacements(self) -> Real:
        """Displacements of the atoms from where the slab is at rest, shape (layers, nx, ny, 3), in a0."""
        moved = self._gathered("x").reshape(self._rest.shape) / self.length - self._rest
        # Atoms that crossed the border of the box have come back on the other side.
        period = np.array(self.slab.grid.lengths)
        moved[..., :2] -= period * np.rint(moved[..., :2] / period)
        return moved

    def _where_at_rest(self) -> Real:
        """Positions without the displacements of the start, shape (layers, nx, ny, 3), in a0."""
        moved = np.array(self._lammps.gather("c_u", 1, 4), dtype=np.float64).reshape(-1, 4)[:, :3]
        # Those of slab.data, except for rounding and for atoms that crossed the border of the box.
        at = self._gathered("x").reshape(moved.shape)
        rest = ((at - moved) / self.length).reshape(*self.slab.ids.shape, 3)
        rest[..., :2] = self.slab.positions[..., :2]
        return rest
