"""The atoms that are exposed at the surface of a slab, and the distance of its layers, from positions alone."""

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.model.fourier import Real

_FREE = 0.05
"""Part of the spacing by which a probe must be held higher by an atom than by its neighbours.  In the hollows of
fcc(110) both hold it: the rows above are the surface, as in a plane."""


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
