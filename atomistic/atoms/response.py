"""Linear response of any slab, measured with its own calculator: the Hessian by waves along the surface.

A slab is n1 x n2 primitive cells side by side, each a column of p atoms.  The forces on all atoms when one atom of the
column moves give the force constants T(R) between the cells 0 and R; for the wave q the column has the Hessian::

    K(q) = Σ_R T(R) exp(-iq.R)

a band matrix if atoms are sorted by height, as forces reach some layers only, of which a Cholesky factor is kept.
Forces are measured on a small slab a few neighbours wide: as a preconditioner the response need not be exact, and
forces that reach further are folded back.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
import scipy
from ase import Atoms
from numpy.typing import NDArray

from continuum.inputs.arguments import ArgumentError, instance
from continuum.model.fourier import Complex, Real

_WIDTH = 5
"""Width of the small slab, in nearest-neighbour distances: half of it is beyond the second neighbours."""
_ALIKE = 0.02
"""Distance from each other's place at which atoms of two cells are still alike, in nearest-neighbour distances."""
_ABOUT = 0.2
"""The same of a slab of several elements at random, whose cells are taken for their mean."""
_STEPS = 2e-3, 1e-2
"""Displacements of an atom, in nearest-neighbour distances.

The second is for forces in single precision, and where the first finds no stiffness: a learned potential may
have a cusp at the sites of a crystal.  A surface atom of fcc(111) copper under CHGNet 0.3, which takes angles between
collinear bonds, has the stiffness -0.3 eV/Å² for 0.002 Å, 1.1 for 0.005 Å, 2.6 for 0.025 Å and 2.9 for 0.05 Å.
"""
_NEGLIGIBLE = 1e-4
"""Force constants that are smaller than this part of the largest are left out of the band."""
_DEAREST = 100.0
"""Largest cost of a measurement, in evaluations of the whole slab."""


@dataclass(frozen=True, eq=False)
class SlabResponse:
    """Displacements of the atoms of a slab under given forces, to linear order.

    Parameters
    ----------
    index : number of each atom that moves, shape (n1, n2, p): cells along either cell vector, and atoms of a column.
    factors : Cholesky factors of the waves, shape (n1, n2//2 + 1, band, 3p), as of ``scipy.linalg.cholesky_banded``.
    evaluations : number of evaluations of the forces of the small slab that it took.
    cost : of these, relative to one evaluation of the whole slab.
    """

    index: NDArray[np.int64]
    factors: Complex = field(repr=False)
    evaluations: int
    cost: float

    @classmethod
    def measure(cls, slab: Atoms, calculator: Any, dearest: float = _DEAREST) -> Self:
        """Measure the response of a slab.

        Parameters
        ----------
        slab : the atoms at rest; those that a constraint holds are its base.
        calculator : of the crystal alone, without a wall.
        dearest : largest cost, in evaluations of the whole slab.

        Raises ArgumentError if this is no slab: it does not repeat along the surface, or is not held or not stable.
        """
        if len(instance("slab", slab, Atoms, "the atoms at rest, an ase.Atoms")) < 2:
            raise ArgumentError("slab", slab, "a slab of several atoms")
        if not callable(getattr(calculator, "get_forces", None)) or isinstance(calculator, type):
            raise ArgumentError("calculator", calculator, "a calculator of ASE, as EMT()")
        at, spacing = slab.positions, _nearest(slab)
        held = np.zeros(len(slab), dtype=bool)
        for constraint in slab.constraints:
            held[getattr(constraint, "index", [])] = True
        most = np.full(len(slab), np.bincount(slab.numbers).argmax())
        for numbers, alike in ((slab.numbers, _ALIKE), (most, _ABOUT)):
            index = _columns(slab, numbers, held, spacing, alike)
            n, column = np.array(index.shape[:2]), index[0, 0]
            cell = np.array(slab.cell) / [[n[0]], [n[1]], [1]]
            wanted = np.ceil(_WIDTH * spacing / np.linalg.norm(cell[:2], axis=1)).astype(int)
            m = np.where(n <= wanted, n, wanted + 1 - wanted % 2)
            free = ~held[column]
            evaluations = 3 * int(free.sum()) + 1
            cost = evaluations * float(np.prod(m / n))
            if cost <= dearest:
                break
        else:
            cells = f"{n[0]} x {n[1]} cells are too few, as its response costs {cost:.0f} evaluations of the whole"
            raise ArgumentError("slab", slab, f"a slab that repeats along its surface: {cells}")
        small = Atoms(numbers[column], _mean_cell(slab, at[index], cell), pbc=slab.pbc)
        small.cell[:] = cell
        mean = small.positions.copy()
        small = small.repeat((*m, 1))
        small.wrap(pbc=(True, True, False))  # some calculators lose atoms outside of the cell
        small.calc = calculator
        steps = _STEPS[in_single_precision(small.get_forces()) :]
        for tried, step in enumerate(steps, 1):
            constants = _force_constants(small, mean, cell[:2], m, free, step * spacing)
            try:
                return cls(index[:, :, free], _factors(constants, n), tried * evaluations, tried * cost)
            except ArgumentError:
                if tried == len(steps):
                    raise
        raise AssertionError

    def displacements(self, forces: Real) -> Real:
        """Displacements K^-1 f, in Å, under forces on the atoms that move, in eV/Å; both of shape (atoms, 3)."""
        waves: Complex = np.fft.rfft2(forces[self.index], axes=(0, 1))
        amplitudes = waves.reshape(*waves.shape[:2], -1)
        for q in np.ndindex(*waves.shape[:2]):
            amplitudes[q] = scipy.linalg.cho_solve_banded((self.factors[q], True), amplitudes[q], check_finite=False)
        moved = np.zeros(forces.shape)
        moved[self.index] = np.fft.irfft2(amplitudes.reshape(waves.shape), s=self.index.shape[:2], axes=(0, 1))
        return moved

    def surface_root(self, surface: NDArray[np.int64]) -> SurfaceRoot:
        """Root of the compliance of the surface, whose atoms are given in order.

        Raises ArgumentError if the same atoms of each cell are not given.
        """
        given = np.isin(self.index, surface)
        chosen = given[0, 0]
        if (given != chosen).any() or np.count_nonzero(given) != len(surface):
            raise ArgumentError("surface", surface, "the same atoms of each cell, which move")
        rows = np.flatnonzero(np.repeat(chosen, 3))
        unit = np.zeros((self.factors.shape[-1], len(rows)))
        unit[rows, np.arange(len(rows))] = 1.0
        compliance = np.array(
            [
                [scipy.linalg.cho_solve_banded((factor, True), unit, check_finite=False)[rows] for factor in line]
                for line in self.factors
            ]
        )
        values, vectors = np.linalg.eigh(compliance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :] @ vectors.conj().swapaxes(-1, -2)
        return SurfaceRoot(np.searchsorted(surface, self.index[:, :, chosen]), root)


@dataclass(frozen=True, eq=False)
class SurfaceRoot:
    """G^1/2 of the compliance G of a surface, a symmetric operator on vectors of the surface atoms.

    Parameters
    ----------
    places : place of each atom in the list of surface atoms, shape (n1, n2, s).
    root : of each wave, shape (n1, n2//2 + 1, 3s, 3s).
    """

    places: NDArray[np.int64]
    root: Complex = field(repr=False)

    def __call__(self, vectors: Real) -> Real:
        """Product with vectors of shape (surface atoms, 3)."""
        waves = np.fft.rfft2(vectors[self.places], axes=(0, 1))
        shape, product = waves.shape, np.empty_like(vectors)
        waves = (self.root @ waves.reshape(*shape[:2], -1, 1)).reshape(shape)
        product[self.places] = np.fft.irfft2(waves, s=self.places.shape[:2], axes=(0, 1))
        return product


def in_single_precision(values: Any) -> bool:
    """True if numbers are such that single precision holds them all, as those of most learned potentials."""
    return bool((np.asarray(values, dtype=np.float32) == np.asarray(values)).all())


def _nearest(slab: Atoms) -> float:
    """Distance of nearest neighbours, in Å: of the atoms around the one that is nearest to the middle."""
    middle = int(np.argmin(np.linalg.norm(slab.positions - slab.positions.mean(axis=0), axis=1)))
    apart = slab.get_distances(middle, [i for i in range(len(slab)) if i != middle], mic=True)
    return float(apart.min())


def _mean_cell(slab: Atoms, at: Real, cell: Real) -> Real:
    """Positions of the atoms of a column, shape (p, 3), as the mean over all cells, whose positions are given."""
    shifts = np.stack(np.meshgrid(*map(np.arange, at.shape[:2]), indexing="ij"), axis=-1) @ cell[:2]
    apart = at - shifts[:, :, None] - at[0, 0]
    periods = np.array(slab.cell)[:2]
    turns = np.rint(apart[..., :2] @ np.linalg.inv(periods[:, :2]))
    return np.asarray(at[0, 0] + (apart - turns @ periods).mean(axis=(0, 1)))


def _columns(
    slab: Atoms, numbers: NDArray[np.int64], held: NDArray[np.bool_], spacing: float, alike: float
) -> NDArray[np.int64]:
    """Number of each atom by cell and place in its column, from the top: shape (n1, n2, p), of the most cells."""
    cell = np.array(slab.cell)
    if not slab.pbc[:2].all() or cell[:2, 2].any():
        raise ArgumentError("slab", slab, "a slab that is periodic along its first two cell vectors, in the plane")
    lengths = np.linalg.norm(cell[:2], axis=1)
    plane = np.linalg.inv(cell[:2, :2]) * lengths
    # Atoms of another kind lie far away along z, so that they are nobody's image.
    kind = np.unique(np.stack([numbers, held], axis=1), axis=0, return_inverse=True)[1].ravel()
    height = slab.positions[:, 2] - slab.positions[:, 2].min()
    points = np.column_stack([slab.positions[:, :2] @ plane, height + 3 * (np.ptp(height) + 1) * kind])
    box = np.array([*lengths, 2 * points[:, 2].max() + 1])
    points[:, :2] %= lengths
    tree = scipy.spatial.KDTree(np.minimum(points, np.nextafter(box, 0)), boxsize=box)

    def images(of: Real) -> tuple[Any, Any]:
        of = of.copy()
        of[..., :2] %= lengths
        apart, found = tree.query(np.minimum(of, np.nextafter(box, 0)))
        return apart, found

    n = []
    for axis in range(2):
        # No two atoms are nearer to each other than neighbours.
        most = int(lengths[axis] / spacing * (1 + alike))
        for count in (k for k in range(max(most, 1), 0, -1) if len(slab) % k == 0):
            shift = np.eye(3)[axis] * lengths[axis] / count
            if all((images(some + shift)[0] <= alike * spacing).all() for some in (points[:9], points)):
                n.append(count)
                break
    cells = np.stack(np.meshgrid(*map(np.arange, n), [0], indexing="ij"), axis=-1).reshape(-1, 3)
    shifts = cells * [lengths[0] / n[0], lengths[1] / n[1], 0]
    left, columns = np.ones(len(slab), dtype=bool), []
    order = np.argsort(-height, kind="stable")
    for atom in order:
        if left[atom]:
            # From the cell in which it is nearest to the first atom of the column.
            away = np.rint((points[atom] - points[order[0]])[:2] / lengths * n).astype(int)
            columns.append(np.roll(images(points[atom] + shifts)[1].reshape(n), away, axis=(0, 1)))
            left[columns[-1]] = False
    index = np.stack(columns, axis=-1)
    if index.size != len(slab) or len(np.unique(index)) != index.size:
        raise ArgumentError("slab", slab, "a slab whose cells are alike")
    return index


def _force_constants(
    small: Atoms, column: Real, cell: Real, m: NDArray[np.int64], free: NDArray[np.bool_], step: float
) -> dict[tuple[int, int], Real]:
    """T(R) by cell, shape (3p, 3p), of the atoms that move: minus the force in R per displacement in 0, symmetrised."""
    p, rest = len(column), small.get_forces()
    measured = np.empty((*m, p, 3, p, 3))
    for atom, axis in np.ndindex(p, 3):
        if free[atom]:
            small.positions[atom, axis] += step
            measured[..., atom, axis] = -(small.get_forces() - rest).reshape(*m, p, 3) / step
            small.positions[atom, axis] -= step
    found: dict[tuple[int, int], Real] = defaultdict(lambda: np.zeros((3 * free.sum(),) * 2))
    images = np.stack(np.meshgrid(*[np.arange(-2, 3)] * 2, indexing="ij"), axis=-1).reshape(-1, 2) * m
    between = (column[:, None] - column[None, :])[free][:, free]
    for place in np.ndindex(*m):
        # Each pair counts at the image that is nearest, or in equal parts at those that are.
        where = np.concatenate([(images + place) @ cell[:, :2], np.zeros((len(images), 1))], axis=1)
        apart = np.linalg.norm(between + where[:, None, None], axis=-1)
        share = (apart <= apart.min(axis=0) * (1 + 1e-6)).astype(float)
        share /= share.sum(axis=0)
        block = measured[place][free][:, :, free]
        for image, part in zip(images, share, strict=True):
            if part.any():
                at = tuple(int(k) for k in image + place)
                found[at[0], at[1]] += (part[:, None, :, None] * block).reshape(3 * free.sum(), -1)
    there = {*found, *((-i, -j) for i, j in found)}
    return {(i, j): (found[i, j] + found[-i, -j].T) / 2 for i, j in there}


def _factors(constants: dict[tuple[int, int], Real], n: NDArray[np.int64]) -> Complex:
    """Cholesky factors of K(q) of all waves of n cells, in band storage."""
    places, matrices = np.array(list(constants)), np.array(list(constants.values()))
    size = matrices.shape[-1]
    rows, columns = np.nonzero((np.abs(matrices) > _NEGLIGIBLE * np.abs(matrices).max()).any(axis=0))
    width = int(np.abs(rows - columns).max()) + 1
    band = np.zeros((len(places), width, size))
    for below in range(width):
        band[:, below, : size - below] = np.diagonal(matrices, -below, axis1=1, axis2=2)
    factors = np.empty((n[0], n[1] // 2 + 1, width, size), dtype=np.complex128)
    for q in np.ndindex(*factors.shape[:2]):
        phases = np.exp(-2j * np.pi * (places @ (np.array(q) / n)))
        try:
            factors[q] = scipy.linalg.cholesky_banded(
                np.tensordot(phases, band, 1), lower=True, overwrite_ab=True, check_finite=False
            )
        except np.linalg.LinAlgError:
            allowed = "one that is stable and held by a constraint, as FixAtoms of its lowest layers"
            raise ArgumentError("slab", f"a slab whose wave {q} has no stiffness", allowed) from None
    return factors
