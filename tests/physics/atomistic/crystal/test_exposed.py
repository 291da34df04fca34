"""The surface and the spacing of given atoms: those of ASE's builders, with noise, and with adsorbates."""

import ase.build
import numpy as np
import pytest
from ase import Atoms

from atomistic.crystal.crystal import exposed
from atomistic.crystal.faces import cell_of, spacing_of
from continuum.inputs.arguments import ArgumentError


def of(slab: Atoms) -> np.ndarray:
    return exposed(slab.positions, np.array(slab.cell)[:2, :2], spacing_of(slab))


@pytest.mark.parametrize("face", ["fcc100", "fcc111", "fcc110", "bcc100", "bcc110", "hcp0001"])
@pytest.mark.parametrize("size", [(4, 5, 6), (1, 1, 5)])
def test_the_exposed_atoms_of_a_plane_are_those_that_ase_tags(face, size):
    metal = {"f": "Cu", "b": "Fe", "h": "Ti"}[face[0]]
    slab = getattr(ase.build, face)(metal, size, vacuum=8, periodic=True)
    assert np.array_equal(of(slab), slab.get_tags() == 1)
    order = np.random.default_rng(1).permutation(len(slab))
    assert np.array_equal(of(slab[order]), of(slab)[order])
    slab.cell[1] += 2 * slab.cell[0]  # the same plane
    assert np.array_equal(of(slab), slab.get_tags() == 1)


@pytest.mark.parametrize(
    ("lattice", "face", "rows"), [("fcc", "211", 2), ("fcc", "331", 2), ("fcc", "311", 2), ("bcc", "111", 2)]
)
def test_rows_of_a_step_are_exposed_but_for_that_at_its_foot(lattice, face, rows):
    slab = cell_of(lattice, face).slab((8.0, 8.0), depth=4.0, reach=2.0)
    heights = np.unique(np.round(slab.positions[: slab.surface_atoms, 2], 6))
    assert len(heights) == rows


def test_neither_noise_nor_a_group_changes_the_spacing_and_an_adatom_covers_what_is_below():
    slab = ase.build.fcc100("Ni", (8, 8, 6), vacuum=8, periodic=True)
    plain, a0 = of(slab), spacing_of(slab)
    assert a0 == pytest.approx(3.52 / 2**0.5, rel=1e-12)
    noisy = slab.copy()
    noisy.positions += np.random.default_rng(1).normal(0, 0.03, (len(slab), 3))
    # Some 2000 distances, each .042 Å off: their median is known to .0012 Å, and of squares in the plane .0004 more.
    assert spacing_of(noisy) == pytest.approx(a0, abs=0.004)
    assert np.array_equal(of(noisy), plain)
    top = slab.positions[:, 2].max()
    oxidised = slab + Atoms("OH", [[4.0, 4.0, top + 1.1], [4.0, 4.0, top + 2.07]])
    assert spacing_of(oxidised) == pytest.approx(a0, rel=1e-9)
    adatom = slab + Atoms("Al", [[*slab.positions[plain][0, :2] + a0 / 2, top + 2.0]])
    found = of(adatom)
    assert found[-1]
    assert np.count_nonzero(found[:-1]) == np.count_nonzero(plain) - 4
    with pytest.raises(ArgumentError, match="atoms with neighbours"):
        spacing_of(Atoms("Ar", cell=[50, 50, 50]))
