"""The substrate: an fcc slab with a (100) surface, whose surface atoms are the points of a grid; its neighbours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.arguments import ArgumentError, array, count, field, instance, number, pair
from continuum.model.fourier import Real
from continuum.model.grid import Grid

if TYPE_CHECKING:
    import ase


LAYER_SPACING = float(np.sqrt(0.5))
"""Distance of neighbouring (100) planes, in a0."""
LOST = (1 + 2**0.5) / 2
"""Distance at which atoms are no longer neighbours, half way between the first and the second shell, in a0."""
_MOST_ATOMS = 2**31 - 1
"""LAMMPS numbers atoms with 32 bits."""


@dataclass(frozen=True)
class Slab:
    """An fcc(100) slab, periodic in the plane, on a frozen base.

    x and y lie along <110>, where the surface atoms form a square grid of spacing a0; the surface plane is
    z = 0 and the layers follow below it at -a0/√2, every other one shifted by (a0/2, a0/2).

    Parameters
    ----------
    shape : (nx, ny), surface atoms along x and y, at least 3 each (of 2, each would be the other's
        neighbour twice).
    mobile : M, number of layers that move, the surface among them.
    frozen : number of layers held at their lattice sites, as many as forces reach.

    Raises
    ------
    ArgumentError
        If a number is too small, or there are more atoms than LAMMPS can number.
    """

    shape: tuple[int, int]
    mobile: int
    frozen: int = 1

    def __post_init__(self) -> None:
        shape = tuple(count("shape", n, 3) for n in pair("shape", self.shape))
        mobile, frozen = count("mobile", self.mobile), count("frozen", self.frozen)
        if shape[0] * shape[1] * (mobile + frozen) > _MOST_ATOMS:
            layers = f"{mobile} mobile layers, as its depth asks for, and {frozen} frozen"
            raise ArgumentError("shape", shape, f"a slab of at most {_MOST_ATOMS} atoms; this one has {layers}")
        for name, value in (("shape", shape), ("mobile", mobile), ("frozen", frozen)):
            object.__setattr__(self, name, value)

    @classmethod
    def of_depth(cls, grid: Grid, depth: float, frozen: int = 1) -> Slab:
        """The slab under a grid, with M = round(√2 depth/a0) mobile layers.

        Raises
        ------
        ArgumentError
            If the spacing of the grid is not a0, or the depth holds no layer.
        """
        if not np.allclose(instance("grid", grid, Grid).spacing, 1.0, rtol=1e-12, atol=0):
            raise ArgumentError("grid", grid, f"a grid of spacing a0 = 1, one point for each atom, not {grid.spacing}")
        depth = number("depth", depth, above=LAYER_SPACING / 2, most=_MOST_ATOMS)
        return cls(grid.shape, round(depth / LAYER_SPACING), frozen)

    @property
    def layers(self) -> int:
        """Number of layers, mobile and frozen."""
        return self.mobile + self.frozen

    @property
    def depth(self) -> float:
        """Depth from the surface plane to the first frozen plane, M a0/√2."""
        return self.mobile * LAYER_SPACING

    @property
    def size(self) -> int:
        """Number of all atoms, the frozen ones included."""
        return self.layers * self.shape[0] * self.shape[1]

    @property
    def grid(self) -> Grid:
        """The grid of the surface atoms."""
        return Grid(self.shape, (float(self.shape[0]), float(self.shape[1])))

    @cached_property
    def ids(self) -> NDArray[np.int64]:
        """Number of each atom in LAMMPS, shape (layers, nx, ny), from 1; the last index runs fastest."""
        ids = np.arange(1, self.size + 1).reshape(self.layers, *self.shape)
        ids.flags.writeable = False
        return ids

    def site(self, ids: NDArray[np.int64]) -> tuple[NDArray[np.int64], ...]:
        """(layer, i, j) of atoms given by their number in LAMMPS.

        Raises
        ------
        ArgumentError
            If there is no such atom.
        """
        given = array("ids", ids, kinds="iu")
        if given.size and not (given.min() >= 1 and given.max() <= self.size):
            raise ArgumentError("ids", ids, f"numbers of atoms of this slab, 1 to {self.size}")
        return np.unravel_index(given - 1, (self.layers, *self.shape))

    @cached_property
    def positions(self) -> Real:
        """Lattice sites, shape (layers, nx, ny, 3), in a0."""
        import ase.build

        fcc100: Any = ase.build.fcc100  # not annotated
        nx, ny = self.shape
        built = fcc100("X", (nx, ny, self.layers), a=np.sqrt(2), periodic=True)
        # ASE lays the planes from the bottom up, x fastest.
        sites: Real = built.positions.reshape(self.layers, ny, nx, 3)[::-1].transpose(0, 2, 1, 3).copy()
        # Sites are multiples of a0/2 in the plane and of a0/√2 across: written so, to the last digit.
        sites[..., :2] = np.rint(2 * sites[..., :2]) / 2
        sites[..., 2] = np.rint((sites[..., 2] - sites[0, 0, 0, 2]) / LAYER_SPACING) * LAYER_SPACING
        sites.flags.writeable = False
        return sites

    def to_atoms(self, displacements: Real | None = None, symbol: str = "X", spacing: float = 1.0) -> ase.Atoms:
        """ASE atoms, in the order of :attr:`ids`, tagged by layer (1 is the surface), the base constrained.

        Parameters
        ----------
        displacements : from the lattice sites, shape (layers, nx, ny, 3), in a0.
        symbol : chemical symbol; "X" is ASE's for none.
        spacing : a0 in the unit wanted, e.g. 2.556 for copper in Å.

        Raises
        ------
        ArgumentError
            If the displacements are not those of these atoms, or there is no such element or spacing.
        """
        import ase.constraints
        import ase.data

        fix_atoms: Any = ase.constraints.FixAtoms  # not annotated
        at = self.positions
        if displacements is not None:
            at = at + field("displacements", displacements, (self.layers, *self.shape, 3))
        if not isinstance(symbol, str) or symbol not in ase.data.chemical_symbols:
            raise ArgumentError("symbol", symbol, 'a chemical symbol, or "X" for none')
        number("spacing", spacing, above=0, most=1e12)
        layer = np.repeat(np.arange(self.layers), self.shape[0] * self.shape[1])
        return ase.Atoms(
            [symbol] * self.size,
            positions=spacing * at.reshape(-1, 3),
            cell=spacing * np.array([*self.shape, self.layers * LAYER_SPACING]),
            pbc=(True, True, False),
            tags=layer + 1,
            constraint=fix_atoms(mask=layer >= self.mobile),
        )


def chemical_symbol(number: int) -> str:
    """Symbol of the element of an atomic number.

    Raises ValueError if there is none.
    """
    import ase.data

    symbols: list[str] = list(ase.data.chemical_symbols)
    if not 1 <= number < len(symbols):
        raise ValueError(f"there is no element of the atomic number {number}")
    return symbols[number]


def distortion(slab: Slab, displacements: Real) -> float:
    """Largest displacement of an atom relative to a nearest neighbour, of displacements (layers, nx, ny, 3), in a0.

    It bounds the strain of the springs, and detects a crystal that is turned inside out: springs do not depend on
    direction, so that a layer pushed through the next is at rest again.
    """
    apart = (
        np.roll(displacements[other], shift, axis=(0, 1)) - displacements[layer]
        for layer, other, shift, _ in _pairs(slab)
    )
    return max(float(np.linalg.norm(each, axis=-1).max()) for each in apart)


def slipped(slab: Slab, displacements: Real) -> NDArray[np.bool_]:
    """Atoms whose nearest neighbours have changed, by one lost and one gained, shape (layers, nx, ny).

    Where an fcc crystal slips by a partial dislocation, each atom on either side of its plane loses one of three, and
    gains another: this, and not the stretch of bonds, distinguishes plastic from elastic deformation.

    Parameters
    ----------
    displacements : displacements of all atoms, shape (layers, nx, ny, 3), in a0.
    """
    lost = np.zeros((slab.layers, *slab.shape), np.bool_)
    for layer, other, shift, site in _pairs(slab):
        apart = site + np.roll(displacements[other], shift, axis=(0, 1)) - displacements[layer]
        far = np.sum(apart**2, axis=-1) > LOST**2
        lost[layer] |= far
        lost[other] |= np.roll(far, (-shift[0], -shift[1]), axis=(0, 1))
    sites = slab.positions[lost]
    if not len(sites):
        return lost
    period = np.array([*slab.shape, 0.0])  # none across
    at = sites + displacements[lost]
    at[:, :2] %= period[:2]
    pairs = scipy.spatial.KDTree(at, boxsize=period).query_pairs(LOST, output_type="ndarray")
    before = sites[pairs[:, 0]] - sites[pairs[:, 1]]
    before[:, :2] -= period[:2] * np.rint(before[:, :2] / period[:2])
    gained = np.zeros(len(sites), np.bool_)
    gained[pairs[np.sum(before**2, axis=-1) > LOST**2].ravel()] = True
    lost[lost] = gained
    return lost


def _pairs(slab: Slab) -> Iterator[tuple[int, int, tuple[int, int], Real]]:
    """Each pair of neighbours once: two layers, the shift that brings the one above the other, and the site there."""
    for layer in range(slab.mobile):
        yield layer, layer, (1, 0), np.array([-1.0, 0.0, 0.0])
        yield layer, layer, (0, 1), np.array([0.0, -1.0, 0.0])
        # The four atoms below stand at half spacings: of an even layer at -1/2 and +1/2, and so on.
        side = 1 if layer % 2 == 0 else -1
        for i, j in np.ndindex(2, 2):
            yield layer, layer + 1, (side * i, side * j), np.array([side * (0.5 - i), side * (0.5 - j), -LAYER_SPACING])
