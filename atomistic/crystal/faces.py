"""Crystals by structure and face, as orthogonal cells along the face, and slabs that are cut from them."""

from __future__ import annotations

from functools import cache
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.crystal import AtomSlab
from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real

if TYPE_CHECKING:
    import ase

STRUCTURES = {
    "fcc": ("cubic", "FaceCenteredCubic", 1), "bcc": ("cubic", "BodyCenteredCubic", 1),
    "diamond": ("cubic", "Diamond", 1), "hcp": ("hexagonal", "", 1), "L1_2": ("compounds", "L1_2", 2),
    "B2": ("compounds", "B2", 2), "zincblende": ("compounds", "Zincblende", 2),
}  # fmt: skip
"""Structures: the module of ``ase.lattice`` and the class there that builds them, and the number of their elements."""
_LONGEST = 2
_ALIKE = 1e-6
"""Relative difference of lengths that are the same, as they were printed with a few digits."""
LARGE, PIECE = 20_000, 8.0
"""Number of atoms above which a crystal is measured on a piece of it, and the least width of the piece, in a0."""
_PEAK = 0.1
"""Half width of the first peak of distances, relative to its centre: bcc has its second shell at 1.155."""


class CrystalCell(NamedTuple):
    """An orthogonal cell of a crystal, periodic along all axes, of which the third is the normal of a face."""

    name: str
    periods: Real
    """Shape (3,), in a0, the distance of nearest neighbours."""
    fractions: Real
    """Positions of the atoms, shape (n, 3), in periods."""
    types: NDArray[np.int64]
    """Index of the element of each atom, from 0."""
    axes: Real
    """The axes in those of the cube, shape (3, 3), of any length; of hcp, x is a close-packed row and z is c."""

    def nearest(self) -> float:
        """Smallest distance of two atoms, in the unit of the periods."""
        import ase

        return _nearest(ase.Atoms("H" * len(self.types), self.fractions * self.periods, cell=self.periods, pbc=True))

    @property
    def volume(self) -> float:
        """Volume per atom, in a0³."""
        return float(np.prod(self.periods)) / len(self.types)

    def repeated(self, counts: tuple[int, int, int]) -> tuple[Real, NDArray[np.int64]]:
        """Sites of a number of cells along each axis, shape (n, 3), in a0, and the index of the element at each."""
        corners = np.array([*np.ndindex(*counts)])
        sites = (corners[:, None] + self.fractions) * self.periods
        return sites.reshape(-1, 3), np.tile(self.types, len(corners))

    def slab(self, width: tuple[float, float], depth: float, reach: float, skin: float | None = None) -> AtomSlab:
        """The slab as wide as the nearest whole numbers of cells, on a base that forces of a reach do not cross, in a0.

        The crystal ends at its widest gap between planes.  Atoms above the depth move; the surface are the exposed
        ones, or those in a skin below the highest.
        """
        planes = np.unique(np.round(self.fractions[:, 2] % 1, 6))
        top = planes[int(np.argmax(np.round(np.diff(planes, append=planes[0] + 1), 6)))]
        x, y = (max(1, round(length / period)) for length, period in zip(width, self.periods[:2], strict=True))
        cells = int(np.ceil((depth + reach) / self.periods[2])) + 3
        sites, types = self.repeated((x, y, cells))
        down = (cells - 1 + top) * self.periods[2] - sites[:, 2]
        lowest = down[(down > -1e-6) & (down < depth - 1e-6)].max()
        base = np.unique(np.round(down[down > lowest + 1e-6], 6))
        deepest = max(base[0], base[base < lowest + reach - 1e-6].max(initial=0.0))
        kept = (down > -1e-6) & (down < deepest + 1e-6)
        sites, types = sites[kept], types[kept]
        del down, kept  # a third of the memory of a large slab
        lengths = np.array([x, y]) * self.periods[:2]
        # Neighbours are as far apart everywhere, and pairs of all atoms of a large slab take much memory.
        wide = len(sites) > LARGE and min(width) > 2 * PIECE
        lost = self.slab((PIECE, PIECE), depth, reach, skin).lost if wide else 0.0
        return AtomSlab.of_sites(self.name, sites, types, lengths, depth, skin, lost)


@cache  # an input asks for it each time that it is checked
def cell_of(structure: str, face: str) -> CrystalCell:
    """The cell of a structure along a face by its Miller indices, "111"; of hcp, the basal face "0001".

    Raises ArgumentError if there is no such face.
    """
    import ase.build
    import ase.lattice.compounds
    import ase.lattice.cubic

    module, builder, elements = STRUCTURES[structure]
    axes = np.eye(3)
    if module == "hexagonal":
        if face != "0001":
            raise ArgumentError("face", face, '"0001", the basal face, of hcp')
        hcp0001: Any = ase.build.hcp0001  # not annotated
        atoms = hcp0001("H", (1, 2, 2), a=1.0, orthogonal=True, periodic=True)
    else:
        if face == "0001" or not any(map(int, face)):
            raise ArgumentError("face", face, 'three Miller indices, as "111", of a cubic structure')
        normal = np.array([*map(int, face)])
        # The shortest vector in the plane, then the one across.
        flat = (np.array(v) for v in product(range(-_LONGEST, _LONGEST + 1), repeat=3) if any(v) and not v @ normal)
        x = min(flat, key=lambda v: (v @ v, *-v))
        axes = np.array([x, np.cross(normal, x), normal])
        axes = axes // np.gcd.reduce(axes, axis=1)[:, None]
        build = getattr(getattr(ase.lattice, module), builder)
        symbol = "H" if elements == 1 else ("H", "He")
        atoms = build(directions=axes.tolist(), symbol=symbol, latticeconstant=1.0, size=(1, 1, 1), pbc=True)
    return _scaled(f"{structure}({face})", atoms, atoms.numbers - 1, axes)


def read_atoms(path: Path, kind: str | None = None) -> ase.Atoms:
    """Atoms of a file, the last of several frames; raises what the reader of ASE raises."""
    import ase.io

    read: Any = ase.io.read  # not annotated
    return cast("ase.Atoms", read(path, format=kind))


def rectangular(atoms: ase.Atoms) -> ase.Atoms:
    """Atoms in a rectangular period along x and y: as they are, or those of a sheared cell, as often as that takes.

    ASE's hexagonal cells, as of ``fcc111``, are doubled where they have an odd number of rows or half a row is left.

    Raises ArgumentError if the cell does not lie along x and in the plane of x and y, or at most six of them make no
    rectangle.
    """
    (x, *out), (shear, y, up) = atoms.cell.array[:2].tolist()
    size = max(abs(x), abs(y), 1e-300)
    if x > 0 and y > 0 and max(map(abs, (*out, up))) <= _ALIKE * size:
        for times in range(1, 7):
            rest = times * shear / x
            if abs(rest - round(rest)) <= _ALIKE:
                if times == 1 and not round(rest):
                    return atoms
                made: ase.Atoms = atoms.repeat((1, times, 1))
                made.set_cell([[x, 0, 0], [0, times * y, 0], atoms.cell.array[2]])
                return made
    allowed = "atoms in a cell with x along its first vector, which is rectangular, or hexagonal, with its lengths"
    raise ArgumentError("atoms", atoms.cell.array[:2].tolist(), allowed)


def size_of_atoms(atoms: ase.Atoms, a0: float | None = None) -> tuple[float, tuple[float, float]]:
    """a0 of given atoms, in their unit of length, and their periods along x and y, in a0.

    Parameters
    ----------
    atoms : in a :func:`rectangular` period.
    a0 : by :func:`spacing_of` if None.

    Raises ArgumentError if they have no neighbours.
    """
    x, y = atoms.cell.lengths()[:2]
    if a0 is None:
        high = float(np.ptp(atoms.positions[:, 2])) + 1
        a0 = spacing_of(type(atoms)(numbers=atoms.numbers, positions=atoms.positions, cell=[x, y, high], pbc=(1, 1, 0)))
    return a0, (float(x) / a0, float(y) / a0)


def slab_of_atoms(
    atoms: ase.Atoms, elements: tuple[str, ...], depth: float, skin: float | None = None, a0: float | None = None
) -> AtomSlab:
    """The slab of given atoms, of which those below a depth, in a0, are held.

    Raises ArgumentError as :func:`size_of_atoms`, or if they have other elements.
    """
    a0, lengths = size_of_atoms(atoms, a0)
    symbols = [str(symbol) for symbol in atoms.symbols]
    if others := sorted({*symbols} - {*elements}):
        raise ArgumentError("atoms", others, f"atoms of the elements of the potential, {', '.join(elements)}")
    types = np.array([elements.index(symbol) for symbol in symbols])
    return AtomSlab.of_sites("given", atoms.positions / a0, types, lengths, depth, skin)


def _scaled(name: str, atoms: ase.Atoms, types: NDArray[np.int64], axes: Real) -> CrystalCell:
    a0, periods = _nearest(atoms), atoms.cell.lengths()
    return CrystalCell(name, periods / a0, atoms.positions / periods % 1, types, axes)


def spacing_of(atoms: ase.Atoms) -> float:
    """Distance of neighbours, the centre of the first peak of the pair distribution, in the unit of the positions.

    It begins at the median distance of an atom to its nearest neighbour, so that a few short bonds, as of a group of
    OH, do not count, and moves to the median of the distances around it, which thermal vibration does not shift.

    Raises ArgumentError if no atom has neighbours.
    """
    from ase.neighborlist import neighbor_list

    neighbours: Any = neighbor_list  # not annotated
    area = float(np.linalg.norm(np.cross(*atoms.cell.array[:2])))
    volume = area * (float(np.ptp(atoms.positions[:, 2])) + 1) / len(atoms)  # without the vacuum of a slab
    for reach in (1.3, 3.0):  # spheres of an atom each, which touch
        i, r = neighbours("id", atoms, reach * (0.75 * volume) ** (1 / 3))
        if not len(r):
            continue
        nearest = np.full(len(atoms), np.inf)
        np.minimum.at(nearest, i, r)
        centre = float(np.median(nearest[np.isfinite(nearest)]))
        for _ in range(20):
            before, centre = centre, float(np.median(r[np.abs(r - centre) < _PEAK * centre]))
            if centre == before:
                break
        return centre
    raise ArgumentError("atoms", len(atoms), "atoms with neighbours")


def _nearest(atoms: ase.Atoms) -> float:
    """Smallest distance of two atoms."""
    from ase.neighborlist import neighbor_list

    neighbours: Any = neighbor_list  # not annotated
    volume = float(np.prod(atoms.cell.lengths())) / len(atoms)
    for reach in (1.3, 3.0):  # spheres of an atom each, which touch
        found = neighbours("d", atoms, reach * (0.75 * volume) ** (1 / 3))
        if len(found):
            return float(found.min())
    raise ArgumentError("atoms", len(atoms), "atoms with neighbours")
