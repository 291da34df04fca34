"""The crystal of a potential, against lattice sums in numpy and against what the potentials' authors print."""

import dataclasses
from functools import cache
from itertools import product

import numpy as np
import pytest
import scipy
from scipy.optimize import brentq

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.model import ContactModulus, Crystal, CrystalModel
from atomistic.crystal.potentials import EmbeddedAtom, PairStyle, PotentialError, find_potential
from atomistic.response.material import measure_crystal, model_of
from continuum.inputs.units import GPA_PER_EV_PER_A3
from continuum.model.substrates.crystal import CubicConstants


def eam(name: str, element: str | None = None) -> EmbeddedAtom:
    return EmbeddedAtom.read(find_potential(name), element)


def test_a_crystal_is_measured_once_by_all_that_determines_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Crystal(1.6, -6.0, CubicConstants(80.0, 40.0, 40.0), {})
    seen: list[object] = []
    monkeypatch.setattr("atomistic.response.material._MEASURED", {})
    monkeypatch.setattr("atomistic.response.material.measure_crystal", lambda one: seen.append(one) or found)
    start = PairStyle("morse/smooth/linear", "Cu", 63.5, 9.0, 3.6, ("9.0",), (("*", "*", "0.34", "1.36", "2.87"),))
    others = [
        LennardJones(3.0), LennardJones(3.0, "mdf", 2.0), start, dataclasses.replace(start, lattice_constant=3.7),
        dataclasses.replace(start, coefficients=(("*", "*", "0.35", "1.36", "2.87"),)),
    ]  # fmt: skip
    for potential in [*others, *map(dataclasses.replace, others)]:
        model = model_of(potential)
        assert model.potential is potential
        assert model.crystal is found
    assert seen == others


def lattice_sums(cutoff: float) -> tuple[float, float, tuple[float, float, float]]:
    """Lattice constant, energy and elastic constants of lj/smooth/linear, from its pair sums (Born and Huang)."""

    def law(r: np.ndarray, derivative: int) -> np.ndarray:
        def plain(r, derivative):
            if derivative == 0:
                return 4 * (r**-12 - r**-6)
            if derivative == 1:
                return 4 * (-12 * r**-13 + 6 * r**-7)
            return 4 * (156 * r**-14 - 42 * r**-8)

        end = np.array(cutoff)
        if derivative == 0:
            return plain(r, 0) - plain(end, 0) - (r - cutoff) * plain(end, 1)
        return plain(r, derivative) - (plain(end, 1) if derivative == 1 else 0)

    half = np.array([n for n in product(range(-6, 7), repeat=3) if sum(n) % 2 == 0 and any(n)]) / 2

    def shells(a: float) -> tuple[np.ndarray, np.ndarray]:
        r = a * half
        distance = np.linalg.norm(r, axis=1)
        return r[distance < cutoff], distance[distance < cutoff]

    def pressure(a: float) -> float:
        r = shells(a)[1]
        return float(np.sum(law(r, 1) * r))

    a = brentq(pressure, 1.45, 1.7, xtol=1e-14)
    r, distance = shells(a)
    n = r / distance[:, None]
    volume = a**3 / 4
    weight = (law(distance, 2) * distance**2 - law(distance, 1) * distance) / (2 * volume)
    c11, c12 = (float(np.sum(weight * n[:, 0] ** 2 * n[:, i] ** 2)) for i in (0, 1))
    return a, float(np.sum(law(distance, 0))) / 2, (c11, c12, c12)


@pytest.mark.parametrize("cutoff", [2.5, 3.3])
def test_lennard_jones_is_its_lattice_sum(cutoff):
    crystal = measure_crystal(LennardJones(cutoff))
    a, energy, constants = lattice_sums(cutoff)
    assert crystal.lattice_constant == pytest.approx(a, rel=1e-12)
    assert crystal.energy == pytest.approx(energy, rel=1e-12)
    # STEP² times a ratio of stiffnesses of some hundred.
    assert np.allclose(crystal.constants, constants, rtol=1e-7)
    # From where a further search of the volume of an atom begins.
    assert CrystalModel(LennardJones(cutoff), crystal).guess == pytest.approx(a**3 / 4, rel=1e-12)


HCP = np.array([[1, 0, 0], [0.5, 0.75**0.5, 0], [0, 0, (8 / 3) ** 0.5]])
FCC = np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0]]) / 2
STRUCTURES = {
    "bcc": (np.array([[-1, 1, 1], [1, -1, 1], [1, 1, -1]]) / 2, [(0, 0, 0)]),
    "simple cubic": (np.eye(3), [(0, 0, 0)]),
    "hcp": (HCP, [(0, 0, 0), (1 / 3, 1 / 3, 1 / 2)]),
    "diamond": (FCC, [(0, 0, 0), (1 / 4, 1 / 4, 1 / 4)]),
}
"""Primitive cells, a row for each edge, and fractions of their atoms: other cells than those that are measured."""


@pytest.mark.parametrize("name", STRUCTURES)
def test_other_structures_have_the_energies_of_their_lattice_sums(name):
    crystal, cutoff = measured_lennard_jones(), 2.5
    cell, fractions = STRUCTURES[name]
    atoms = np.array(fractions) @ cell
    far = np.stack(np.meshgrid(*3 * [np.arange(-5, 6)], indexing="ij"), axis=-1).reshape(-1, 3) @ cell
    apart = np.linalg.norm(far[:, None, None] + atoms - atoms[:, None], axis=-1).ravel()
    apart = apart[apart > 1e-9]
    slope = 4 * (-12 * cutoff**-13 + 6 * cutoff**-7)

    def energy(volume):
        r = apart * np.cbrt(volume * len(atoms) / abs(np.linalg.det(cell)))
        r = r[r < cutoff]
        pairs = 4 * (r**-12 - r**-6) - 4 * (cutoff**-12 - cutoff**-6) - (r - cutoff) * slope
        return pairs.sum() / 2 / len(atoms)

    volume = crystal.lattice_constant**3 / 4
    ends = 0.7 * volume, 1.6 * volume
    best = scipy.optimize.minimize_scalar(energy, bounds=ends, method="bounded", options={"xatol": 1e-6 * volume}).x
    # Either search ends within 5e-4 of the best volume, which is the smallest one of diamond: it would shrink on.
    assert crystal.others[name] == pytest.approx(energy(best), abs=abs(energy(best * (1 + 5e-4)) - energy(best)))


@cache
def measured_lennard_jones() -> Crystal:
    return measure_crystal(LennardJones(2.5))


def test_lennard_jones_of_long_range_has_the_known_constants():
    # Full sums: a = 1.5417 σ, energy -8.6102 ε (Kihara and Koba, J. Phys. Soc. Japan 7, 348 (1952)).
    # Cut at 9 σ, the attraction that is missing beyond, 16πρ/(3 r_c³) = 0.025 ε, and the tangent taken off within,
    # πρ r_c⁴ V'(r_c)/6 = 0.019 ε, act as a pressure: with the bulk modulus 8 x 8.61 ε ρ, a grows by 3.3e-4 σ.
    crystal = measure_crystal(LennardJones(9.0))
    assert crystal.lattice_constant == pytest.approx(1.5417 + 3.3e-4, abs=1e-4)
    assert crystal.energy == pytest.approx(-8.6102, abs=0.05)
    assert crystal.constants.c11 / crystal.constants.c12 == pytest.approx(np.sqrt(3), rel=0.02)
    assert crystal.others["hcp"] < crystal.energy  # by 1e-4 of it, as is known: a stacking, not another crystal


@pytest.mark.parametrize(
    ("name", "a", "energy", "constants", "digits"),
    [
        # Mishin et al., Phys. Rev. B 63, 224106 (2001), Table III.
        ("Cu_mishin1.eam.alloy", 3.615, -3.54, (169.9, 122.6, 76.2), 0.06),
        # Foiles, Baskes and Daw, Phys. Rev. B 33, 7983 (1986), Table IV: calculated values.
        ("Cu_u3.eam", 3.615, -3.54, (167, 124, 76), 0.5),
        ("Ni_u3.eam", 3.52, -4.45, (233, 154, 128), 0.5),
        ("Ag_u3.eam", 4.09, -2.85, (129, 91, 57), 0.5),
        ("Pt_u3.eam", 3.92, -5.77, (303, 273, 68), 0.5),
    ],
)
def test_metals_have_the_constants_that_their_authors_print(name, a, energy, constants, digits):
    material = model_of(eam(name))
    assert isinstance(material, CrystalModel)
    crystal = material.crystal
    assert crystal.lattice_constant == pytest.approx(a, abs=2e-4)
    assert crystal.energy == pytest.approx(energy, abs=5e-4)
    found = [c * GPA_PER_EV_PER_A3 for c in crystal.constants]
    assert found == pytest.approx(constants, abs=digits)
    assert crystal.energy < min(crystal.others.values())


def test_aluminium_of_the_notes():
    # The potential's own values of this project's notes, measured by another program.
    material = model_of(eam("Al_zhou.eam.alloy"))
    modulus = ContactModulus.of(material.crystal.constants)
    found = [GPA_PER_EV_PER_A3 * value for value in (modulus.mean, modulus.along_110, modulus.along_100)]
    assert found == pytest.approx([91.6, 93.3, 90.0], abs=0.06)


def test_a_material_is_a_model_in_reduced_units():
    material = model_of(eam("Cu_mishin1.eam.alloy"))
    assert material.lattice_constant == pytest.approx(np.sqrt(2))
    assert ContactModulus.of(material.elastic_constants).mean == pytest.approx(1, rel=1e-12)
    units = material.real_units
    assert units.si("length") == pytest.approx(material.length * scipy.constants.angstrom, rel=1e-14)
    assert units.si("energy") == pytest.approx(material.energy * scipy.constants.eV, rel=1e-12)
    assert material.coupled_layers == 6  # twice 5.507 Å over layers of 1.807 Å
    assert model_of(LennardJones()).real_units is None
    springs = Springs()
    assert model_of(springs) is springs


@pytest.mark.parametrize(("name", "structure"), [("Fe_mm.eam.fs", "bcc"), ("Mg_mm.eam.fs", "hcp")])
def test_metals_that_are_not_fcc_are_refused(name, structure):
    with pytest.raises(PotentialError, match=f"not fcc at its minimum: {structure}"):
        measure_crystal(eam(name))


def test_lennard_jones_that_prefers_another_stacking_is_refused():
    with pytest.raises(PotentialError, match="not fcc at its minimum: hcp"):
        measure_crystal(LennardJones(2.5, "mdf", 2.0))


def test_a_file_that_names_another_lattice_constant_finds_no_crystal():
    far = dataclasses.replace(eam("Ni_u3.eam"), guess=4 * 3.52**3 / 4)
    with pytest.raises(PotentialError, match="no fcc crystal at zero pressure"):
        measure_crystal(far)


def test_silicon_is_refused_by_the_name_of_its_structure():
    contents = PairStyle.read_files([find_potential("Si.sw")])
    silicon = PairStyle("sw", "Si", 28.0855, 3.77, 5.43, (), (("*", "*", "Si.sw", "Si"),), contents)
    # Stillinger and Weber's crystal has -4.3366 eV per atom (Phys. Rev. B 31, 5262, 1985).
    with pytest.raises(PotentialError, match=r"diamond is bound with -4\.336\d* per atom.*fcc") as refused:
        measure_crystal(silicon)
    assert "Si.sw" in str(refused.value)


def test_springs_are_not_measured_on_two_atoms():
    with pytest.raises(ValueError, match="fixed bonds"):
        measure_crystal(Springs(1.0))


@pytest.mark.parametrize(
    "arguments",
    [(0.5,), (2.5, "mdf"), (2.5, "smooth", 2.6), (2.5, "cut"), (float("nan"),), (2.5, "smooth/linear", 2.0)],
)
def test_lennard_jones_without_meaning_is_refused(arguments):
    with pytest.raises(ValueError, match=r"(cutoff|inner|truncation) = "):
        LennardJones(*arguments)


@pytest.mark.parametrize("law", [LennardJones(), LennardJones(2.5, "smooth", 2.0), LennardJones(3.0, "mdf", 2.5)])
def test_forces_end_continuously(law):
    from atomistic.lammps.session import Cell

    pair = np.array([[1.0, 1, 1], [2.0, 1, 1]])
    with Cell(law, pair, np.array([20.0, 20, 20])) as cell:

        def force(r: float) -> float:
            return float(cell.evaluate(np.array([[1.0, 1, 1], [1 + r, 1, 1]]))[1][0, 0])

        assert force(law.cutoff + 1e-9) == 0
        assert abs(force(law.cutoff - 1e-6)) < 1e-5
        assert abs(force(2.0)) > 0.01


@pytest.mark.parametrize("layers", range(2, 8))
def test_a_layer_exactly_at_the_range_is_not_coupled(layers: int) -> None:
    """There forces are zero, on whichever side of it rounding puts the layer."""
    for cutoff in (2.5, 3.0, 3.7):
        a0 = cutoff / (layers * LAYER_SPACING)
        crystal = Crystal(a0 * 2**0.5, -1.0, CubicConstants(3.0, 1.5, 1.5), {})
        assert CrystalModel(LennardJones(cutoff), crystal).coupled_layers == layers - 1
        smaller = dataclasses.replace(crystal, lattice_constant=crystal.lattice_constant * (1 - 1e-6))
        assert CrystalModel(LennardJones(cutoff), smaller).coupled_layers == layers
