"""Slabs of atoms under a wall: fcc(100), whose surface atoms are the points of a grid, and any other; neighbours.

The atoms that are exposed at a surface, and the distance of layers, are found from positions alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.inputs.arguments import ArgumentError, array, count, field_of, instance, number, pair
from continuum.model.fourier import Real
from continuum.model.grid import Grid

if TYPE_CHECKING:
    import ase


_FREE = 0.05
"""Part of the spacing by which a probe must be held higher by an atom than by its neighbours.  In the hollows of
fcc(110) both hold it: the rows above are the surface, as in a plane."""
LAYER_SPACING = float(np.sqrt(0.5))
"""Distance of neighbouring (100) planes, in a0."""
LOST = (1 + 2**0.5) / 2
"""Distance at which atoms are no longer neighbours, half way between the first and the second shell, in a0."""
_ALIKE = 1e-6
"""Heights that differ by less, in a0, are one plane."""
_MOST_ATOMS = 2**31 - 1
"""LAMMPS numbers atoms with 32 bits."""


def exposed(positions: Real, cell: Real, spacing: float) -> NDArray[np.bool_]:
    """Atoms that a probe of their own size touches as it comes down on them along -z.

    Of close-packed planes they are the first; of stepped ones, as fcc(211), all rows; below an adatom they are those
    of the plane that it leaves free.

    Parameters
    ----------
    positions : shape (n, 3).
    cell : periods in the plane as rows, shape (2, 2).
    spacing : distance of neighbours, of a probe that touches an atom, too.
    """
    fractions = positions[:, :2] @ np.linalg.inv(cell)
    at, z = (fractions - np.floor(fractions)) @ cell, positions[:, 2]
    # Patches half a spacing wide, in each of which the highest atom covers all that are a spacing deeper.
    size = np.ceil(2 * np.linalg.norm(cell, axis=1) / spacing).astype(np.int64)
    inside = np.minimum(((fractions - np.floor(fractions)) * size).astype(np.int64), size - 1)
    patch = inside[:, 0] * size[1] + inside[:, 1]
    highest = np.full(int(np.prod(size)), -np.inf)
    np.maximum.at(highest, patch, z)
    tried = np.flatnonzero(z > highest[patch] - spacing)
    above = np.flatnonzero(z >= z[tried].min())  # an atom is covered by higher ones only
    # Images in the plane, as far as a probe reaches.
    heights = abs(np.linalg.det(cell)) / np.linalg.norm(cell, axis=1)[::-1]
    most = np.ceil(spacing / heights).astype(np.int64)
    shifts = np.array([*np.ndindex(*(2 * most + 1))]) - most
    images = (at[above][None] + (shifts @ cell)[:, None]).reshape(-1, 2)
    levels = np.tile(z[above], len(shifts))
    low, high = at[tried].min(axis=0) - spacing, at[tried].max(axis=0) + spacing
    kept = ((images >= low) & (images <= high)).all(axis=1)
    near = scipy.spatial.KDTree(images[kept])
    pairs = scipy.spatial.KDTree(at[tried]).sparse_distance_matrix(near, spacing, output_type="ndarray")
    held = levels[kept][pairs["j"]] + np.sqrt(spacing**2 - np.minimum(pairs["v"], spacing) ** 2)
    own = z[tried][pairs["i"]] + spacing
    higher = levels[kept][pairs["j"]] > z[tried][pairs["i"]]
    covered = np.zeros(len(tried), np.bool_)
    covered[pairs["i"][higher & (held > own - _FREE * spacing)]] = True
    found = np.zeros(len(z), np.bool_)
    found[tried[~covered]] = True
    return found


def layer_depth(heights: Real, surface: int) -> float:
    """Mean distance of layers of as many atoms as the surface has, the volume of an atom over its area there.

    Parameters
    ----------
    heights : of all atoms, shape (n,).
    surface : number of exposed atoms.
    """
    layers = len(heights) // surface
    if layers < 2:
        return np.inf
    down = np.sort(heights)[::-1][: layers * surface].reshape(layers, surface).mean(axis=1)
    return float(down[0] - down[-1]) / (layers - 1)


class AnySlab:
    """Atoms of a slab, periodic in the plane, on a frozen base: numbered from the surface down, in a0.

    Arrays over its atoms have the shape of ``ids``, those over the atoms of the surface at rest ``shape``.
    """

    name: str
    """Structure and face, "fcc(100)", or "given"."""
    shape: tuple[int, ...]
    axes: tuple[str, ...]
    """Names of the axes of arrays over the surface atoms."""
    ids: NDArray[np.int64]
    """Number of each atom in LAMMPS, from 1."""
    positions: Real
    """Sites, shape ``(*ids.shape, 3)``, in a0."""
    types: NDArray[np.int64]
    """Index of the element of each atom, from 0, shape (size,)."""
    grid: Grid
    """The grid of the map of the wall and of the continuum beside it."""
    mobile: int
    """Number of layers of as many atoms as the surface has that move."""
    moving: int
    """Number of entries along the first axis of ``ids`` that move."""
    lost: float
    """Distance at which atoms are no longer neighbours, between two shells, in a0."""
    depth: float
    """Distance from the surface to the first frozen atom, in a0."""
    bottom: float
    """Height below which there is no atom, in a0."""
    about: str
    """Description of the slab."""
    layer: float
    """Mean distance of layers of as many atoms as the surface has, in a0."""

    @property
    def one_to_one(self) -> bool:
        """True if each surface atom is a point of the grid."""
        return self.shape == self.grid.shape

    @property
    def size(self) -> int:
        """Number of all atoms, the frozen ones included."""
        return self.types.size

    @property
    def surface_atoms(self) -> int:
        """Number of atoms of the surface at rest, the first ones, which share its area."""
        return int(np.prod(self.shape))

    @property
    def mobile_atoms(self) -> int:
        """Number of atoms that move, the surface among them, on all of which the wall acts."""
        return self.ids[: self.moving].size

    @property
    def area(self) -> float:
        """Area that an atom stands for, that of the surface over its atoms, in a0²; 1 on a grid of spacing a0."""
        return self.grid.lengths[0] * self.grid.lengths[1] / self.surface_atoms

    @cached_property
    def _near(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The surface atom above each atom, and above each point of the grid: the nearest in the plane, from 0."""
        sites, period = self.positions.reshape(-1, 3)[:, :2], np.array(self.grid.lengths)
        tree = scipy.spatial.KDTree(within(sites[: self.surface_atoms], period), boxsize=period)
        points = np.stack(np.broadcast_arrays(*self.grid.positions), axis=-1).reshape(-1, 2)
        atoms, places = (np.asarray(tree.query(within(at, period))[1]) for at in (sites, points))
        return atoms, places

    def below(self, chosen: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Number of chosen atoms below each surface atom, itself included, shape ``shape``."""
        if self.one_to_one:
            return np.asarray(np.count_nonzero(chosen, axis=0))
        return np.bincount(self._near[0][chosen.ravel()], minlength=self.surface_atoms)

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the surface atoms at the points of the grid, those of the nearest atom."""
        return values if self.one_to_one else values.ravel()[self._near[1]].reshape(self.grid.shape)

    def neighbours(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Real]]:
        """Each pair of neighbours of which one moves, once: places of both atoms, and the second from the first."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class AtomSlab(AnySlab):
    """Any atoms on a frozen base, first those of the surface, each part in the order of their heights downwards.

    Parameters
    ----------
    name : structure and face, "fcc(111)", or "given".
    lengths : periods along x and y, in a0.
    positions : sites, or positions at rest, shape (size, 3), in a0; the surface is at z = 0.
    types : which element each atom is, from 0, shape (size,).
    surface, moving : number of atoms of the surface, which share its area, and of those that move.
    lost : distance at which atoms are no longer neighbours; between the two most distant shells if zero.
    """

    name: str
    lengths: tuple[float, float]
    positions: Real = field(repr=False)
    types: NDArray[np.int64] = field(repr=False)
    surface: int
    moving: int
    lost: float = 0.0

    def __post_init__(self) -> None:
        count, surface, (x, y) = len(self.positions), self.surface, self.lengths
        nx, ny = (max(2, round(length)) for length in self.lengths)  # points about a0 apart
        z = self.positions[:, 2]
        vars(self).update(
            axes=("atom",), ids=np.arange(1, count + 1), shape=(surface,), grid=Grid((nx, ny), self.lengths),
            depth=float(np.median(z[:surface]) - z[self.moving :].max(initial=z.min())), bottom=float(z.min()),
            mobile=round(self.moving / surface), layer=layer_depth(z, surface),
            about=f"{count} atoms, {surface} of them at the surface, {self.name}, {x:.5g} x {y:.5g} a0",
        )  # fmt: skip
        if not self.lost:
            # The widest gap between distances up to the third shell of fcc.
            shells = np.sort(np.linalg.norm(self._apart(*self._pairs(1.75)), axis=-1))
            vars(self)["lost"] = float(shells[(i := int(np.argmax(np.diff(shells)))) : i + 2].mean())

    @classmethod
    def of_sites(
        cls,
        name: str,
        sites: Real,
        types: NDArray[np.int64],
        lengths: Any,
        depth: float,
        skin: float | None = None,
        lost: float = 0.0,
    ) -> AtomSlab:
        """The slab of sites, of which those above a depth below the surface move.

        The surface are the exposed atoms, or those in a skin below the highest.

        Raises
        ------
        ArgumentError
            If there are more atoms than LAMMPS can number.
        """
        if len(sites) > _MOST_ATOMS:
            raise ArgumentError("n", len(sites), f"a slab of at most {_MOST_ATOMS} atoms")
        down = sites[:, 2].max() - sites[:, 2]
        period = np.array(lengths)
        at = np.column_stack([within(sites[:, :2], period), -down])
        top = exposed(at, np.diag(period), 1.0) if skin is None else down < skin
        moves = down < float(np.median(down[top])) + depth - _ALIKE
        np.round(down, 6, out=down)
        order = np.lexsort((*np.round(at[:, 1::-1].T, 6), down, ~top))
        return cls(name, (float(period[0]), float(period[1])), at[order], types[order], int(np.count_nonzero(top)),
                   int(np.count_nonzero(top | moves)), lost)  # fmt: skip

    def _pairs(self, distance: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        period = np.array([*self.lengths, 0.0])
        at = np.column_stack([within(self.positions[:, :2], period[:2]), self.positions[:, 2]])
        found = scipy.spatial.KDTree(at, boxsize=period).query_pairs(distance, output_type="ndarray")
        found.sort(axis=1)
        found = found[found[:, 0] < self.moving]
        return found[:, 0], found[:, 1]

    def _apart(self, i: NDArray[np.int64], j: NDArray[np.int64]) -> Real:
        r = self.positions[j] - self.positions[i]
        r[:, :2] -= np.array(self.lengths) * np.rint(r[:, :2] / self.lengths)
        return np.asarray(r, dtype=np.float64)

    def neighbours(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Real]]:
        i, j = self._pairs(self.lost)
        yield i, j, self._apart(i, j)


def within(at: Real, period: Real) -> Real:
    """Positions in the plane in the first period, the upper end excluded also where rounding leads there."""
    inside = at % period
    return np.where(inside < period, inside, 0.0)


@dataclass(frozen=True)
class Slab(AnySlab):
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

    Examples
    --------
    >>> import atomistic as a
    >>> slab = a.Slab((4, 5), mobile=3)
    >>> len(slab.to_atoms())  # of ASE: three layers that move, one that does not
    80
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
        deep, lengths = mobile + frozen, (float(shape[0]), float(shape[1]))
        vars(self).update(
            shape=shape, mobile=mobile, frozen=frozen, moving=mobile, grid=Grid((shape[0], shape[1]), lengths),
            name="fcc(100)", axes=("x", "y"), lost=LOST, depth=mobile * LAYER_SPACING, bottom=-deep * LAYER_SPACING,
            layer=LAYER_SPACING, about=f"{shape[0]} x {shape[1]} atoms",
            types=np.broadcast_to(np.int64(0), shape[0] * shape[1] * deep),
        )  # fmt: skip

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

    @cached_property
    def ids(self) -> NDArray[np.int64]:  # type: ignore[override]
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
    def positions(self) -> Real:  # type: ignore[override]
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

    def neighbours(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Real]]:
        at = self.ids - 1
        for layer in range(self.mobile):
            pairs = [(layer, (1, 0), [-1.0, 0.0, 0.0]), (layer, (0, 1), [0.0, -1.0, 0.0])]
            # The four atoms below stand at half spacings: of an even layer at -1/2 and +1/2, and so on.
            side = 1 if layer % 2 == 0 else -1
            for i, j in np.ndindex(2, 2):
                pairs.append((layer + 1, (side * i, side * j), [side * (0.5 - i), side * (0.5 - j), -LAYER_SPACING]))
            for other, shift, site in pairs:
                yield at[layer].ravel(), np.roll(at[other], shift, axis=(0, 1)).ravel(), np.array(site)

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
            at = at + field_of("displacements", displacements, (self.layers, *self.shape, 3))
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
        raise ValueError(f"no element has the atomic number {number}")
    return symbols[number]


def standard_mass(symbol: str) -> float | None:
    """Standard atomic weight of an element, in u; None for what is no symbol of one."""
    import ase.data

    number = ase.data.atomic_numbers.get(symbol, 0)  # "X" stands for none
    return float(ase.data.atomic_masses[number]) if number else None


def distortion(slab: AnySlab, displacements: Real) -> float:
    """Largest displacement of an atom relative to a nearest neighbour, of displacements ``(*ids.shape, 3)``, in a0.

    It bounds the strain of the springs, and detects a crystal that is turned inside out: springs do not depend on
    direction, so that a layer pushed through the next is at rest again.
    """
    u = displacements.reshape(-1, 3)
    if not u.any():
        return 0.0
    return max(float(np.linalg.norm(u[j] - u[i], axis=-1).max()) for i, j, _ in slab.neighbours())


def slipped(slab: AnySlab, displacements: Real) -> NDArray[np.bool_]:
    """Atoms whose nearest neighbours have changed, by one lost and one gained, of the shape of ``slab.ids``.

    Where an fcc crystal slips by a partial dislocation, each atom on either side of its plane loses one of three, and
    gains another: this, and not the stretch of bonds, distinguishes plastic from elastic deformation.

    Parameters
    ----------
    displacements : displacements of all atoms, shape ``(*ids.shape, 3)``, in a0.
    """
    u, lost = displacements.reshape(-1, 3), np.zeros(slab.size, np.bool_)
    for i, j, site in slab.neighbours():
        far = np.sum((site + u[j] - u[i]) ** 2, axis=-1) > slab.lost**2
        lost[i[far]] = lost[j[far]] = True
    sites = slab.positions.reshape(-1, 3)[lost]
    if not len(sites):
        return lost.reshape(slab.ids.shape)
    period = np.array([*slab.grid.lengths, 0.0])  # none across
    at = sites + u[lost]
    at[:, :2] = within(at[:, :2], period[:2])
    pairs = scipy.spatial.KDTree(at, boxsize=period).query_pairs(slab.lost, output_type="ndarray")
    before = sites[pairs[:, 0]] - sites[pairs[:, 1]]
    before[:, :2] -= period[:2] * np.rint(before[:, :2] / period[:2])
    gained = np.zeros(len(sites), np.bool_)
    gained[pairs[np.sum(before**2, axis=-1) > slab.lost**2].ravel()] = True
    lost[lost] = gained
    return lost.reshape(slab.ids.shape)
