"""The optimizer: its measured response is the lattice's own, its equilibrium that of others, and what it leaves."""

from __future__ import annotations

import warnings
from collections import Counter
from typing import Any, ClassVar

import numpy as np
import pytest
from ase import Atoms
from ase.build import add_adsorbate, bulk, fcc111
from ase.calculators.calculator import Calculator, all_changes
from ase.calculators.emt import EMT
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms
from ase.io import Trajectory
from ase.neighborlist import neighbor_list
from ase.optimize import LBFGS
from ase.optimize.precon import PreconLBFGS

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.response.lattice import LatticeResponse

LAW = c.LennardJonesSpline(adhesion_length=0.005)


class LinearSprings(Calculator):
    """Springs between nearest neighbours, to first order in displacements from where their atoms are seen first."""

    implemented_properties: ClassVar[list[str]] = ["energy", "free_energy", "forces"]

    def __init__(self) -> None:
        super().__init__()
        self.known: dict[int, Any] = {}
        self.evaluations = 0

    def calculate(self, atoms=None, properties=(), system_changes=all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        self.evaluations += 1
        if len(atoms) not in self.known:
            self.known[len(atoms)] = atoms.positions.copy(), *neighbor_list("ijD", atoms, 1.2)
        rest, i, j, bond = self.known[len(atoms)]
        u = atoms.positions - rest
        pull = Springs().stiffness * np.einsum("bk,bk->b", u[j] - u[i], bond)[:, None] * bond
        forces = np.zeros_like(u)
        np.add.at(forces, i, pull)
        energy = -0.5 * float(np.vdot(forces, u))
        self.results = {"energy": energy, "free_energy": energy, "forces": forces}


def test_the_measured_response_is_that_of_the_lattice():
    slab = Slab((7, 6), mobile=4)
    exact = LatticeResponse.of_springs(slab, Springs())
    forces = np.random.default_rng(1).standard_normal((slab.layers, 7, 6, 3))
    atoms = slab.to_atoms()
    found = a.SlabResponse.measure(atoms, LinearSprings())
    assert found.index.shape == (7, 6, 4)
    moved = found.displacements(forces.reshape(-1, 3))
    # Differences of forces of 1e-3 are known to 1e-13 of them.
    assert np.allclose(moved.reshape(forces.shape), exact.displacements(forces), rtol=0, atol=1e-10)
    # Another order of the atoms, other cell vectors of the same plane: the same displacements.
    order = np.random.default_rng(2).permutation(len(atoms))
    other = atoms[order]
    other.cell[1] += other.cell[0]  # of which one row repeats only
    again = a.SlabResponse.measure(other, LinearSprings())
    assert again.index.size == found.index.size
    assert np.allclose(again.displacements(forces.reshape(-1, 3)[order]), moved[order], rtol=0, atol=1e-10)
    # The root of its surface, applied twice, is the compliance.
    surface = np.flatnonzero(other.get_tags() == 1)
    push = np.zeros((len(atoms), 3))
    push[surface] = forces.reshape(-1, 3)[order][surface]
    root = again.surface_root(surface)
    assert np.allclose(root(root(push[surface])), again.displacements(push)[surface], rtol=0, atol=1e-10)


def test_a_linear_crystal_needs_one_step_to_the_contact_of_the_continuum_code():
    slab = Slab((16, 16), mobile=4)
    heights = c.SelfAffine(0.8, 0.1, 8, 16).synthesise(slab.grid, np.random.default_rng(1))
    contact = c.Contact(heights, LAW, LatticeResponse.of_springs(slab, Springs()), tolerance=1e-9)
    state = contact.press(separation=1.05)
    atoms = slab.to_atoms()
    springs, wall = LinearSprings(), a.RoughWall(contact, atoms, 1.05, follows="sites")
    atoms.calc = SumCalculator([springs, wall])
    relaxation = a.GreensRelaxation(atoms, logfile=None)
    assert relaxation.run(fmax=1e-8)
    assert relaxation.fallback is None
    # Those of the small slab; two, and one for what is left of the contact.
    assert springs.evaluations <= relaxation.response.evaluations + 3
    assert wall.results["gap"][:256].reshape(16, 16) == pytest.approx(state.gap, abs=1e-6)
    assert -wall.results["forces"][:, 2].sum() / 256 == pytest.approx(state.load, rel=1e-6)


def copper() -> tuple[Atoms, a.RoughWall]:
    slab = fcc111("Cu", (5, 4, 4), vacuum=8, periodic=True)
    slab.set_constraint(FixAtoms(mask=slab.get_tags() > 2))
    heights = 0.1 * np.random.default_rng(4).standard_normal((5, 4))
    return slab, a.RoughWall(heights, slab, 1.0, LAW, a0=2.55, contact_modulus=0.85)


def test_copper_comes_to_the_equilibrium_of_other_optimizers_in_few_evaluations(tmp_path):
    slab, wall = copper()
    slab.calc = SumCalculator([EMT(), wall])
    relaxation = a.GreensRelaxation(slab, logfile=str(tmp_path / "log"), trajectory=tmp_path / "relax.traj")
    assert relaxation.run(fmax=1e-4, steps=12)
    assert relaxation.fallback is None
    assert "5 x 4 cells of 2 atoms was measured by 7 evaluations of a small slab" in (tmp_path / "log").read_text()
    with Trajectory(tmp_path / "relax.traj") as images:
        assert len(images) == relaxation.nsteps + 1
        begun = images[2]
    # From an image of the trajectory it goes on, with the response that is known.
    other = begun.copy()
    other.calc = SumCalculator([EMT(), wall])
    again = a.GreensRelaxation(other, logfile=None, response=relaxation.response)
    assert again.run(fmax=1e-4, steps=12)
    assert other.get_potential_energy() == pytest.approx(slab.get_potential_energy(), abs=1e-6)
    third = begun.copy()
    third.calc = slab.calc
    assert LBFGS(third, logfile=None).run(fmax=1e-4, steps=100)
    # Energies differ by force²/stiffness, 1e-8 eV/Å² over some 1 eV/Å², of 40 atoms.
    assert third.get_potential_energy() == pytest.approx(slab.get_potential_energy(), abs=1e-6)


class SinglePrecision(EMT):
    """EMT whose results are those of single precision, as of most learned potentials, and how often it was asked."""

    evaluations: Counter[int]

    def __init__(self) -> None:
        super().__init__()
        self.evaluations = Counter()

    def calculate(self, atoms=None, properties=("energy",), system_changes=all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        self.evaluations[len(atoms)] += 1
        self.results = {name: np.float64(np.float32(value)) for name, value in self.results.items()}


def test_single_precision_takes_no_more_evaluations():
    slab, wall = copper()
    found = {}
    for name, optimizer in (("ours", a.GreensRelaxation), ("PreconLBFGS", PreconLBFGS)):
        atoms, crystal = slab.copy(), SinglePrecision()
        atoms.calc = SumCalculator([crystal, wall])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # PreconLBFGS says that it goes without a preconditioner
            # Where its line search ends on rounded energies.
            assert optimizer(atoms, logfile=None).run(fmax=2e-3, steps=100)
        found[name] = crystal.evaluations[len(atoms)]
    # As in double precision: half, and with the 7 of a small slab, which is this one, no more.
    assert found["ours"] <= found["PreconLBFGS"]


def test_a_fallback_is_preconditioned_and_goes_by_forces_where_energies_have_no_digits(tmp_path):
    slab, _ = copper()
    add_adsorbate(slab, "Cu", 2.0, "fcc")  # 81 atoms
    found = {}
    for crystal in (SinglePrecision(), EMT()):
        atoms = slab.copy()
        atoms.calc = crystal
        relaxation = a.GreensRelaxation(atoms, logfile=str(tmp_path / "log"))
        with pytest.warns(UserWarning, match=r"goes on by PreconLBFGS: .*costs \d+ evaluations"):
            assert relaxation.run(fmax=1e-4, steps=30)
        found[type(crystal)] = atoms, (tmp_path / "log").read_text()
        (tmp_path / "log").unlink()
    (single, log), (double, other) = found.values()
    assert "accepted by their forces" in log
    assert "accepted by their forces" not in other
    # PreconLBFGS as it comes takes 32 in double precision, and 553 in 30 steps, without an end, in single precision.
    assert single.calc.evaluations[len(slab)] <= 16
    # 1e-4 eV/Å over some eV/Å².
    assert np.allclose(single.positions, double.positions, rtol=0, atol=2e-4)


class Cusp(EMT):
    """EMT with a cusp at the sites of the crystal: atoms that move little are pushed on."""

    def calculate(self, atoms=None, properties=("energy",), system_changes=all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        away = atoms.positions - self.sites
        self.results["forces"] = self.results["forces"] + 30.0 * away * np.exp(-((away / 5e-3) ** 2))


def test_a_cusp_at_the_sites_is_no_lack_of_stiffness():
    slab, _ = copper()
    crystal = Cusp()
    crystal.sites = slab.positions.copy()
    found = a.SlabResponse.measure(slab, crystal)
    assert found.evaluations == 2 * a.SlabResponse.measure(slab, EMT()).evaluations
    forces = np.random.default_rng(1).standard_normal((len(slab), 3))
    smooth = a.SlabResponse.measure(slab, EMT()).displacements(forces)
    # At 0.0255 Å nothing is left of the cusp, but the crystal is 5 % anharmonic.
    assert np.abs(found.displacements(forces) - smooth).max() < 0.1 * np.abs(smooth).max()


def test_what_is_no_slab_is_left_to_another_optimizer_which_is_said():
    atoms = bulk("Cu", cubic=True) * (2, 2, 1)
    atoms.center(vacuum=6, axis=2)
    atoms.calc = EMT()
    relaxation = a.GreensRelaxation(atoms, logfile=None)
    with pytest.warns(UserWarning, match=r"goes on by PreconLBFGS: .*stable and held by a constraint"):
        assert relaxation.run(fmax=0.01, steps=60)
    slab, _ = copper()
    add_adsorbate(slab, "Cu", 2.0, "fcc")
    slab.calc = EMT()
    relaxation = a.GreensRelaxation(slab, logfile=None)
    with pytest.warns(UserWarning, match=r"goes on by PreconLBFGS: .*repeats along its surface"):
        relaxation.run(fmax=0.05, steps=3)
    alone, alone_wall = copper()
    alone.calc = alone_wall
    with pytest.warns(UserWarning, match="a calculator, beside that of the wall"):
        a.GreensRelaxation(alone, logfile=None).run(steps=1)
