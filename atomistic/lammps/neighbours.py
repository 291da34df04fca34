"""Nearest neighbours of the atoms of a slab: their relative displacements, and their changes."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from continuum.model.fourier import Real

LOST = (1 + 2**0.5) / 2
"""Distance at which atoms are no longer neighbours, half way between the first and the second shell, in a0."""

_Shift = tuple[int, int]


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
    pairs = KDTree(at, boxsize=period).query_pairs(LOST, output_type="ndarray")
    before = sites[pairs[:, 0]] - sites[pairs[:, 1]]
    before[:, :2] -= period[:2] * np.rint(before[:, :2] / period[:2])
    gained = np.zeros(len(sites), np.bool_)
    gained[pairs[np.sum(before**2, axis=-1) > LOST**2].ravel()] = True
    lost[lost] = gained
    return lost


def _pairs(slab: Slab) -> Iterator[tuple[int, int, _Shift, Real]]:
    """Each pair of neighbours once: two layers, the shift that brings the one above the other, and the site there."""
    for layer in range(slab.mobile):
        yield layer, layer, (1, 0), np.array([-1.0, 0.0, 0.0])
        yield layer, layer, (0, 1), np.array([0.0, -1.0, 0.0])
        # The four atoms below stand at half spacings: of an even layer at -1/2 and +1/2, and so on.
        side = 1 if layer % 2 == 0 else -1
        for i, j in np.ndindex(2, 2):
            yield layer, layer + 1, (side * i, side * j), np.array([side * (0.5 - i), side * (0.5 - j), -LAYER_SPACING])
