import numpy as np
import pytest
from ase.build import fcc100
from hypothesis import given
from hypothesis import strategies as st

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from continuum.model.grid import Grid


def neighbours(slab: Slab) -> np.ndarray:
    """Number of atoms at the distance a0 of each atom, by brute force over the periodic images."""
    at = slab.positions.reshape(-1, 3)
    count = np.zeros(len(at), dtype=int)
    for image in np.ndindex(3, 3):
        shift = np.array([*(np.array(image) - 1) * slab.shape, 0.0])
        distance = np.linalg.norm(at[:, None] + shift - at[None, :], axis=-1)
        count += np.sum(np.abs(distance - 1) < 1e-9, axis=1)
        assert not ((distance > 1e-9) & (distance < 1 - 1e-9)).any()
    return count.reshape(slab.ids.shape)


@pytest.mark.parametrize("shape", [(4, 4), (3, 5), (6, 3)])
def test_every_atom_has_the_neighbours_of_an_fcc_surface(shape):
    slab = Slab(shape, mobile=4)
    count = neighbours(slab)
    assert (count[0] == 8).all()
    assert (count[1:-1] == 12).all()


@pytest.mark.parametrize("shape", [(4, 4), (3, 5), (7, 4)])
def test_surface_atoms_are_the_points_of_the_grid(shape):
    slab = Slab(shape, mobile=3)
    x, y = slab.grid.positions
    assert (slab.positions[0, ..., 0] == x).all()
    assert (slab.positions[0, ..., 1] == y).all()
    assert (slab.positions[0, ..., 2] == 0).all()
    assert (np.diff(slab.positions[:, 0, 0, 2]) < 0).all()


def test_the_sites_are_those_that_ase_builds():
    slab = Slab((3, 5), mobile=3, frozen=2)
    built = fcc100("X", (3, 5, 5), a=np.sqrt(2)).positions
    built[:, 2] -= built[:, 2].max()

    def key(sites):
        return sorted(map(tuple, np.round(sites, 9) + 0.0))

    assert key(slab.positions.reshape(-1, 3)) == key(built)


def test_depth_is_rounded_to_whole_layers():
    slab = Slab.of_depth(Grid.square(32), 32.0)
    assert (slab.mobile, slab.frozen, slab.layers) == (45, 1, 46)
    assert slab.depth == pytest.approx(45 / np.sqrt(2))
    assert slab.positions[slab.mobile, 0, 0, 2] == pytest.approx(-slab.depth)
    assert slab.grid == Grid.square(32)


@given(st.integers(3, 9), st.integers(3, 9), st.integers(1, 4), st.data())
def test_numbers_and_sites_are_one_to_one(nx, ny, mobile, data):
    slab = Slab((nx, ny), mobile)
    site = tuple(data.draw(st.integers(0, n - 1)) for n in slab.ids.shape)
    assert tuple(int(i) for i in slab.site(slab.ids[site])) == site
    assert set(slab.ids.ravel()) == set(range(1, slab.size + 1))
    assert slab.ids[0].max() < slab.ids[1:].min()


def test_ase_atoms_carry_layers_and_the_frozen_base():
    slab = Slab((3, 4), mobile=2)
    moved = np.zeros((3, 3, 4, 3))
    moved[0, 1, 2] = 0.1, 0.2, 0.3
    atoms = slab.to_atoms(moved, symbol="Cu", spacing=2.5)
    site = slab.ids[0, 1, 2] - 1
    assert np.allclose(atoms.positions[site], 2.5 * np.array([1.1, 2.2, 0.3]))
    assert atoms.get_tags()[site] == 1
    assert np.allclose(atoms.cell.lengths(), 2.5 * np.array([3, 4, 3 * LAYER_SPACING]))
    assert list(atoms.constraints[0].index) == list(slab.ids[2].ravel() - 1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Slab((2, 4), 3), "shape = 2: allowed: a whole number from 3"),
        (lambda: Slab((4, 4), 0), "mobile = 0"),
        (lambda: Slab((4, 4), 3, 0), "frozen = 0"),
        (lambda: Slab.of_depth(Grid.square(8, spacing=0.5), 8.0), "spacing"),
        (lambda: Slab((65536, 65536), 3), "at most 2147483647 atoms"),
        (lambda: Slab.of_depth(Grid.square(8), 0.2), "depth = 0.2"),
        (lambda: Slab.of_depth(Grid.square(8), float("nan")), "depth = nan"),
        (lambda: Slab((4, 4), 3).site(np.array([0])), "ids = "),
        (lambda: Slab((4, 4), 3).site(np.array([65])), "ids = "),
    ],
)
def test_what_has_no_meaning_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
