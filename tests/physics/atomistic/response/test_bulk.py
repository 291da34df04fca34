"""What is below a face: springs of a contact modulus of one, and the solid that stands for atoms of a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ase.build
import ase.io
import numpy as np
import pytest

from atomistic.crystal.crystal import AtomSlab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.model import AnyCrystalModel
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.inputs.crystal import CrystalTable
from atomistic.lammps.session import Cell
from atomistic.response import bulk
from atomistic.response.bulk import at_rest, model_below, slab_of_table
from continuum.model.fourier import Real
from continuum.model.substrates.crystal import anisotropic_contact_modulus

ANGLES = np.linspace(0, np.pi, 91)[:-1]


@pytest.mark.parametrize("face", ["110", "111"])
def test_springs_below_a_face_have_a_mean_contact_modulus_of_one(face: Any) -> None:
    below = model_below(Springs(), CrystalTable(face=face))
    assert isinstance(below, AnyCrystalModel)
    # 1/E* is smooth in the angle: the mean over any equal steps.
    assert np.mean(1 / anisotropic_contact_modulus(below.tensor, ANGLES)) == pytest.approx(1, rel=1e-6)
    springs = below.potential
    assert isinstance(springs, Springs)
    # All neighbours of an atom that move against it: four times the springs along each axis, by its motion and theirs.
    assert below.stiffest == pytest.approx(8 * springs.stiffness)
    # Cauchy's relation of central forces, along any axes: C_ijkl is symmetric in all indices.
    np.testing.assert_allclose(below.tensor, below.tensor.transpose(0, 2, 1, 3), atol=1e-12)
    # The bulk modulus of the crystal of springs is sqrt(2)/3 x 2 k_s/a0.
    assert np.einsum("iijj", below.tensor) / 9 == pytest.approx(2 * np.sqrt(2) / 3 * springs.stiffness)
    assert (below.length, below.contact_modulus, below.density, below.mass) == (1, 1, pytest.approx(np.sqrt(2)), 1)


def test_atoms_of_a_file_have_an_isotropic_solid_of_the_given_modulus_below_them(tmp_path: Path) -> None:
    slab = ase.build.fcc111("Ni", (6, 6, 6), a=3.52, orthogonal=True, vacuum=5)
    slab.info.clear()
    ase.io.write(tmp_path / "slab.xyz", slab)
    potential = EmbeddedAtom.read(find_potential("NiAlH_jea.eam.alloy"), ("Al", "Ni"))
    below = model_below(potential, CrystalTable(atoms=tmp_path / "slab.xyz", modulus="200GPa"))
    assert isinstance(below, AnyCrystalModel)
    assert below.length == pytest.approx(3.52 / np.sqrt(2))
    assert below.contact_modulus == pytest.approx(200 / 160.2176634)
    np.testing.assert_allclose(anisotropic_contact_modulus(below.tensor, ANGLES), 1, rtol=1e-9)
    c11, c12 = below.tensor[0, 0, 0, 0], below.tensor[0, 0, 1, 1]
    assert c12 / (c11 + c12) == pytest.approx(1 / 4)
    # A layer is thought to be 0.8 a0 thick, and of fcc(111) it is sqrt(2/3).
    assert below.density == pytest.approx(np.sqrt(2), rel=0.01)
    assert below.mass == pytest.approx(potential.masses[1])
    # Of twelve planes, eleven distances high, forces reach through the lowest 4.5 a0.
    tall = ase.build.fcc111("Ni", (6, 6, 12), a=3.52, orthogonal=True, vacuum=5)
    tall.info.clear()
    ase.io.write(tmp_path / "high.xyz", tall)
    high = CrystalTable(atoms=tmp_path / "high.xyz", modulus="200GPa")
    most = 11 * np.sqrt(2 / 3) - below.reach
    with pytest.warns(UserWarning, match=f"with a depth below {most:.4g} a0 they would not"):
        slab_of_table(high, below, (6.0, 6.0), 6.0)
    assert slab_of_table(high, below, (6.0, 6.0), most - 0.5).size == 12 * 36


def test_a_surface_comes_to_rest_and_its_stiffest_vibration_is_that_of_the_hessian() -> None:
    """Of Lennard-Jones' (111) face: no forces on the atoms that move, and the largest ω² of all of them, from above."""
    crystal = CrystalTable(face="111")
    model = model_below(LennardJones(2.5), crystal)
    assert isinstance(model, AnyCrystalModel)
    slab = slab_of_table(crystal, model, (2.0, 2.0), 1.0)
    rest, found = at_rest(slab, model)
    moved = rest.positions - slab.positions
    assert 0.001 < np.abs(moved[: slab.moving, 2]).max() < 0.05
    assert not moved[slab.moving :].any()
    sites, lengths, step = rest.positions * model.length, np.array(slab.lengths) * model.length, 1e-4 * model.length
    unit = model.energy / model.length
    with Cell(model, sites, lengths, surface=True, types=slab.types) as cell:
        assert np.abs(cell.evaluate(sites)[1][: slab.moving]).max() < 1e-6 * unit
        pushed = step * np.eye(3 * slab.moving, sites.size).reshape(-1, *sites.shape)
        rows = [(cell.evaluate(sites - each)[1] - cell.evaluate(sites + each)[1]) / (2 * step) for each in pushed]
    hessian = np.array(rows).reshape(len(rows), -1)[:, : len(rows)]
    exact = np.linalg.eigvalsh((hessian + hessian.T) / 2)[-1] * model.length / unit
    # Its powers come to it from below, and a tenth is added.
    assert exact < found.stiffest < 1.1 * exact
    assert found.stiffest > 1.03 * exact


def test_a_large_crystal_rests_as_a_piece_of_it_unless_its_cells_part(monkeypatch: pytest.MonkeyPatch) -> None:
    crystal = CrystalTable(face="211")
    model = model_below(LennardJones(2.5), crystal)
    assert isinstance(model, AnyCrystalModel)
    slab = slab_of_table(crystal, model, (18.0, 20.0), 1.0)
    whole, by_whole = at_rest(slab, model)
    sizes, relaxed = [], bulk._relaxed

    def noted(part: AtomSlab, model: AnyCrystalModel) -> tuple[Real, float]:
        sizes.append(part.size)
        return relaxed(part, model)

    monkeypatch.setattr(bulk, "LARGE", 100)
    monkeypatch.setattr(bulk, "_relaxed", noted)
    rest, by_piece = at_rest(slab, model)
    assert len(sizes) == 1
    assert sizes[0] < slab.size / 2
    # Forces of 1e-8 E* a0² are left on stiffnesses of the order of E* a0, less by layers that move together.
    assert np.abs(rest.positions - whole.positions).max() < 1e-6
    assert np.abs(rest.positions - slab.positions).max() > 0.01
    assert rest.lost == whole.lost
    # Both are powers from below, from other random displacements, and a tenth more.
    assert by_piece.stiffest == pytest.approx(by_whole.stiffest, rel=0.05)

    def parted(part: AtomSlab, model: AnyCrystalModel) -> tuple[Real, float]:
        moved, stiffest = noted(part, model)
        return moved + 1e-3 * (np.arange(part.size)[:, None] == 0), stiffest

    sizes.clear()
    monkeypatch.setattr(bulk, "_relaxed", parted)
    at_rest(slab, model)
    assert sizes[1:] == [slab.size]
