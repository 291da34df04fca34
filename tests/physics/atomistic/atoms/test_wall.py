"""The wall as a calculator of ASE: the wall of decks, the gradient of one energy, and what leaves it as it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from ase import Atoms
from ase.build import fcc100, fcc111
from ase.calculators.emt import EMT
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms
from ase.units import GPa
from hypothesis import given, settings
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_in_process
from atomistic.lammps.session import Session
from atomistic.lammps.shape import HeightSpline

LAW = c.LennardJonesSpline(adhesion_length=0.005)
PERIOD = (8.0, 7.0)
SITES = np.meshgrid(np.arange(8.0), np.arange(7.0), indexing="ij")
ROUGH = 0.1 * np.random.default_rng(3).standard_normal((8, 7))


@pytest.mark.parametrize(
    ("follows", "heights"),
    [("atoms", a.Round(PERIOD, 20.0)), ("atoms", ROUGH), ("sites", ROUGH)],
    ids=["sphere", "array", "sites"],
)
def test_forces_are_those_of_a_deck(tmp_path, follows, heights):
    """Those of its plugin: tests/physics/atomistic/lammps/test_plugin.py, which builds it."""
    shape = HeightSpline(heights) if isinstance(heights, np.ndarray) else heights
    slab = Slab((8, 7), mobile=2)
    start = np.zeros((slab.layers, *slab.shape, 3))
    start[0] = np.random.default_rng(5).uniform(-0.1, 0.1, (*slab.shape, 3))
    at_sites = shape.evaluate(*SITES).height
    deck = Deck(slab, Springs(), LAW, at_sites, 1.0, start, tolerance=1e9,
                shape=shape if follows == "atoms" else None)  # fmt: skip
    directory = write_deck(tmp_path, deck)
    with Session(directory) as session:
        _, without = session.evaluate(start)
    found = run_in_process(directory)
    acting = (found.forces - without).reshape(-1, 3)

    wall = a.RoughWall(heights, slab.to_atoms(), 1.0, LAW, follows=follows)
    atoms = slab.to_atoms(start)
    forces, scale = wall.get_forces(atoms), np.abs(acting).max()
    # Rounding of coordinates up to 8 times the stiffness of the law, 30, and of the crystal's forces, which are taken
    # off.
    assert np.allclose(forces, acting, rtol=0, atol=1e-12 * max(scale, 1))
    assert wall.results["energy"] == pytest.approx(found.wall_energy, abs=1e-11 * max(scale, 1))
    surface = slice(0, 56)  # atoms of a slab begin with the surface
    assert np.allclose(wall.results["gap"][surface], found.gap.ravel(), rtol=0, atol=1e-13)
    held = slice(2 * 56, None)
    assert np.isnan(wall.results["gap"][held]).all()
    assert np.isfinite(wall.results["gap"][: held.start]).all()


def slabs() -> st.SearchStrategy[Atoms]:
    """A layer of 4 x 3 atoms in cells of any angle, displaced, on one that is not of the surface."""

    def build(angle: float, ratio: float, seed: int) -> Atoms:
        cell = np.array([[10.0, 0, 0], [10 * ratio * np.cos(angle), 10 * ratio * np.sin(angle), 0], [0, 0, 20]])
        places = [[i / 4, j / 3, height] for height in (0.2, 0.1) for i in range(4) for j in range(3)]
        atoms = Atoms("Cu24", scaled_positions=places, cell=cell, pbc=(True, True, False), tags=[1] * 12 + [2] * 12)
        atoms.info["moved"] = np.random.default_rng(seed).uniform(-0.3, 0.3, (24, 3))
        return atoms

    return st.builds(build, st.floats(0.6, 2.5), st.floats(0.5, 1.5), st.integers(0, 99))


def wall_above(slab: Atoms, **given: Any) -> a.RoughWall:
    return a.RoughWall(ROUGH, slab, **{"separation": 0.4, "law": LAW, "a0": 2.5, "contact_modulus": 0.8} | given)


def at(slab: Atoms, moved: Any) -> Atoms:
    atoms = slab.copy()
    atoms.positions += moved
    return atoms


@given(slabs(), st.sampled_from(["atoms", "sites"]), st.tuples(st.floats(-9, 9), st.floats(-9, 9)))
@settings(max_examples=10)
def test_forces_are_the_gradient_of_the_energy_and_balance_the_wall(slab, follows, offset):
    def wall(up: float = 0.0, aside: float = 0.0) -> a.RoughWall:
        shifted = offset[0] + aside / 2.5, offset[1]
        return wall_above(slab, follows=follows, offset=shifted, separation=1.0 + up / 2.5)

    here, there = wall(), at(slab, slab.info["moved"])
    energy, forces = here.get_potential_energy(there), here.get_forces(there)
    h, along = 1e-4, np.random.default_rng(1).standard_normal((24, 3))

    def slope(changed: Callable[[float], float]) -> float:
        return (8 * (changed(h) - changed(-h)) - (changed(2 * h) - changed(-2 * h))) / (12 * h)

    # Fourth order: h⁴/30 of the fifth derivative, 1e5 of the forces or so; rounding of 1e-15 of the energy over h.
    bound = 1e-9 * (np.abs(forces).sum() + abs(energy) + 1)
    by_atoms = slope(lambda s: here.get_potential_energy(at(there, s * along)))
    assert by_atoms == pytest.approx(-np.vdot(forces, along), abs=bound)
    # The wall takes the opposite force, moved up by s, and along x where it follows the atoms.
    up = slope(lambda s: wall(up=s).get_potential_energy(there))
    assert up == pytest.approx(forces[:, 2].sum(), abs=bound)
    aside = slope(lambda s: wall(aside=s).get_potential_energy(there))
    if follows == "atoms":
        assert aside == pytest.approx(forces[:, 0].sum(), abs=bound)
    else:
        assert not forces[:, :2].any()
    assert not forces[12:].any()


@given(slabs(), st.tuples(*[st.floats(-20, 20)] * 3))
@settings(max_examples=10)
def test_neither_a_common_translation_nor_images_nor_repetition_change_the_wall(slab, shift):
    moved = slab.info["moved"]
    wall = wall_above(slab)
    energy, forces = wall.get_potential_energy(at(slab, moved)), wall.get_forces(at(slab, moved))
    close = {"rtol": 0, "atol": 1e-10 * (1 + np.abs(forces).max())}  # rounding of 20 Å times a stiffness of some 30
    elsewhere = wall_above(at(slab, shift), offset=(shift[0] / 2.5, shift[1] / 2.5))
    assert np.allclose(elsewhere.get_forces(at(slab, moved + shift)), forces, **close)
    assert elsewhere.results["energy"] == pytest.approx(energy, abs=1e-9 * (1 + abs(energy)))
    images = np.random.default_rng(2).integers(-2, 3, (24, 2)) @ slab.cell[:2]
    assert np.allclose(wall.get_forces(at(slab, moved + images)), forces, **close)
    # Twice the cell has twice the map.
    double = slab.repeat((2, 1, 1))
    above = a.RoughWall(np.tile(ROUGH, (2, 1)), double, 0.4, LAW, a0=2.5, contact_modulus=0.8)
    found = above.get_potential_energy(at(double, np.tile(moved, (2, 1))))
    assert found == pytest.approx(2 * energy, abs=1e-9 * (1 + abs(energy)))


def test_results_scale_with_the_units_and_a_map_that_repeats_is_one_of_the_cell():
    slab = fcc100("Cu", (8, 6, 2), a=2.5 * 2**0.5, vacuum=5, periodic=True)
    wall = a.RoughWall(ROUGH[:4, :3], slab, 1.0, LAW, pixel=1.0, a0=2.5, contact_modulus=0.8)
    forces, gap = wall.get_forces(slab), wall.results["gap"]
    unit = slab.copy()
    unit.set_cell(slab.cell / 2.5, scale_atoms=True)
    plain = a.RoughWall(np.tile(ROUGH[:4, :3], (2, 2)), unit, 1.0, LAW)
    assert np.allclose(plain.get_forces(unit), forces / (0.8 * 2.5**2), rtol=0, atol=1e-12 * np.abs(forces).max())
    assert np.allclose(plain.results["gap"], gap, rtol=0, atol=1e-12, equal_nan=True)
    assert plain.results["energy"] == pytest.approx(wall.results["energy"] / (0.8 * 2.5**3), rel=1e-12)


def test_a_wide_map_is_seen_as_far_as_the_slab_reaches_and_not_repeated():
    slab = fcc111("Cu", (5, 4, 2), a=3.6, vacuum=5, periodic=True)
    x, y = np.meshgrid(np.arange(64.0), np.arange(64.0), indexing="ij")
    bowl = 0.01 * ((x - 32) ** 2 + (y - 32) ** 2)  # a cubic spline has no error of it, but near the edges
    wall = a.RoughWall(bowl, slab, 1.0, LAW, pixel=0.5, offset=(-10.0, -9.0))
    wall.calculate(slab)
    sites = slab.positions[slab.get_tags() == 1]
    u, v = (2 * (sites[:, 0] + 10) - 32), (2 * (sites[:, 1] + 9) - 32)
    found = wall.results["gap"][slab.get_tags() == 1]
    # The jump at the edge, 10 a0 here, has decayed by 3e-5 or more.
    assert np.allclose(found, 1.0 + 0.01 * (u**2 + v**2), rtol=0, atol=3e-4)


def test_the_sum_with_a_crystal_has_both_and_says_what_touches():
    slab = fcc111("Cu", (4, 4, 2), vacuum=5, periodic=True)
    contact = a.Round((4.0, 4.0 * 3**0.5 / 2), 5.0)
    with pytest.raises(ValueError, match="repeats with the cell"):
        a.RoughWall(contact, slab, 0.95, LAW, a0=2.55)
    wall = a.RoughWall(ROUGH, slab, 0.95, LAW, a0=2.55, contact_modulus=0.85)
    slab.calc = SumCalculator([EMT(), wall])
    total = slab.get_forces()
    assert np.allclose(total, EMT().get_forces(slab) + wall.get_forces(slab), rtol=0, atol=1e-13)
    assert slab.get_potential_energy(force_consistent=True) == pytest.approx(slab.get_potential_energy())
    gap, contact = wall.results["gap"], wall.results["contact"]
    assert np.array_equal(contact == 2, gap < LAW.zero_gap)
    assert np.array_equal(contact == 1, (gap >= LAW.zero_gap) & (gap < LAW.zero_gap + LAW.range))
    assert 0 < np.count_nonzero(contact == 2) < 16


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pixel": 0.5}, r"a map of 4 x 3.5 a0.: allowed: a map that repeats with the cell.* leave out pixel"),
        ({"law": None}, "law = None: allowed: the law of the wall"),
        ({"law": c.HardWall()}, r"law = .* as LennardJonesSpline\(0\)"),
        ({"follows": "site"}, 'follows = .* "atoms", "sites"'),
        ({"surface": [32]}, r"surface = \[32\]: allowed: indices of the surface atoms of the slab, 0 to 31$"),
        ({"surface": [0.5]}, "surface = .* numbers"),
        ({"a0": 0}, "a0 = 0: allowed"),
        # In nanometres, and in GPa.
        ({"a0": 0.255}, r"a0 = 0.255: allowed: a number in Å, or a text.*0.255 Å is 25.5 pm, and no solid has this"),
        ({"contact_modulus": 136.0}, r"contact_modulus = 136.0: allowed: a number in eV/Å³.* 136 eV/Å³ is 21.8 TPa"),
        ({"contact_modulus": "136"}, r"contact_modulus = '136': allowed: a number in eV/Å³, or a text with its unit"),
        ({"slab": 5}, "slab = 5: allowed: the atoms at rest"),
        ({"slab": Atoms("Cu")}, "slab = .* periodic along its first two cell vectors"),
    ],
)
def test_what_cannot_be_a_wall_is_refused_in_one_sentence(changes, words):
    slab = fcc111("Cu", (4, 4, 2), vacuum=5, periodic=True)
    with pytest.raises(ValueError, match=words) as refused:
        a.RoughWall(ROUGH, **{"slab": slab, "separation": 1.0, "law": LAW} | changes)
    assert "\n" not in str(refused.value)


def test_a_contact_brings_its_law_and_atoms_must_be_those_of_the_slab():
    slab = Slab((16, 16), mobile=1).to_atoms()
    heights = c.SelfAffine(0.8, 0.1, 8, 16).synthesise(c.Grid.square(16), np.random.default_rng(1))
    contact = c.Contact(heights, LAW)
    wall = a.RoughWall(contact, slab, 1.0, follows="sites")
    wall.calculate(slab)
    assert np.allclose(wall.results["gap"][:256].reshape(16, 16), 1.0 + heights, rtol=0, atol=1e-12)
    with pytest.raises(ValueError, match=r"law = .* a contact has its own"):
        a.RoughWall(contact, slab, 1.0, LAW)
    with pytest.raises(ValueError, match=r"atoms = .* the 512 atoms of the slab"):
        wall.get_forces(slab[:3])


def copper(**given: Any) -> tuple[Atoms, a.RoughWall]:
    slab = fcc111("Cu", (6, 6, 4), vacuum=8, periodic=True)
    return slab, wall_above(slab, **{"separation": 0.9, "a0": "2.55Å", "contact_modulus": "136GPa"} | given)


def test_a_text_has_its_own_unit():
    slab, wall = copper()
    plain = wall_above(slab, separation=0.9, a0=2.55, contact_modulus=136 * GPa)
    assert wall.get_forces(slab) == pytest.approx(plain.get_forces(slab), rel=1e-7)  # of eV/Å³, to eight digits


def test_the_order_of_the_atoms_is_free_where_the_wall_follows_them():
    slab, wall = copper()
    order = np.argsort(-slab.positions[:, 2], kind="stable")
    assert np.array_equal(wall.get_forces(slab[order]), wall.get_forces(slab)[order])


@pytest.mark.parametrize(
    ("held", "follows", "change", "words"),
    [
        (False, "sites", lambda slab: slab[::-1], r"the order of the slab: atom \d+ is .* Å from its own; make"),
        (True, "atoms", lambda slab: slab[::-1], r"in the order of the slab: atom \d+ is .* Å from its own"),
        (True, "atoms", lambda slab: at(slab, [0, 0, 1.0]), r"at their sites.* atom 0 is 1.00 Å from its own"),
        (False, "atoms", lambda slab: at(slab, [0, 0, 5.0]), r"the slab where it was: it is \+5.00 Å higher"),
        (False, "atoms", lambda slab: at(slab, -2 * slab.positions * [0, 0, 1]), r"the slab where it was: it is -22"),
        (False, "atoms", lambda slab: stretched(slab, 1.001), r"the cell of the wall, .* make another wall"),
        (False, "atoms", lambda slab: at(slab, [[np.nan]] + [[0]] * 143), "positions that are numbers, of atom 0"),
        (False, "atoms", lambda slab: Atoms("CuNi143", slab.positions, cell=slab.cell), "elements of the slab, Cu144"),
    ],
    ids=["sorted", "sorted and held", "moved and held", "moved", "flipped", "stretched", "nan", "elements"],
)
def test_a_slab_that_changed_after_its_wall_was_made_is_refused(held, follows, change, words):
    slab, _ = copper()
    if held:
        slab.set_constraint(FixAtoms(mask=slab.get_tags() == 4))
    wall = wall_above(slab, separation=0.9, follows=follows)
    wall.get_forces(slab)
    with pytest.raises(ValueError, match=words):
        wall.get_forces(change(slab))


def stretched(slab: Atoms, factor: float) -> Atoms:
    other = slab.copy()
    other.set_cell(slab.cell * factor, scale_atoms=True)
    return other


def test_an_atom_that_comes_up_later_is_under_the_wall():
    slab, _ = copper()
    flat = a.RoughWall(np.zeros((4, 4)), slab, 1.0, LAW, a0=2.55)
    second, top = np.flatnonzero(slab.get_tags() == 2)[0], np.flatnonzero(slab.get_tags() == 1)[0]
    assert not flat.get_forces(slab).any()  # where the surface is at rest
    up = slab.copy()
    up.positions[second, 2] = slab.positions[top, 2] + 0.2
    forces = flat.get_forces(up)
    assert np.flatnonzero(forces.any(axis=1)).tolist() == [second]
    up.positions[second], up.positions[top] = up.positions[top], up.positions[second].copy()
    assert forces[second, 2] == flat.get_forces(up)[top, 2] < 0


@pytest.mark.parametrize(
    "law", [c.InversePowers(powers=(9, 3), adhesion_length=0.05), c.LennardJonesSpline(adhesion_length=0.05)]
)
@pytest.mark.parametrize("face", [fcc100, fcc111])
def test_a_law_that_reaches_the_layers_below_has_its_energy_above_the_whole_slab(law, face):
    """The layers of a slab at rest have w(gap) less that of the first layer that is not there."""
    slab = face("Cu", (3, 3, 12), vacuum=8, periodic=True)
    a0 = 3.61 / 2**0.5
    layer = np.diff(np.unique(np.round(slab.positions[:, 2], 9))).mean() / a0
    area = abs(np.linalg.det(slab.cell[:2, :2]))
    for gap in (0.85, 1.0, 1.3):
        wall = a.RoughWall(np.zeros((4, 4)), slab, gap, law, a0=a0, contact_modulus=0.85)
        wall.calculate(slab)
        here, beyond = gap, gap + 12 * layer
        law_at = law.evaluate(np.array([here, beyond]))
        # A law without an end is cut off 10 a0 beyond its minimum: each layer lacks what it has there.
        end = law.evaluate(np.array([11.0, 11.0 + layer])).traction
        cut = 12 * abs(end[0] - end[1]) + 1e-9  # and the cubic spline of the law
        assert -wall.results["forces"][:, 2].sum() / (0.85 * area) == pytest.approx(
            -np.diff(law_at.traction)[0], abs=cut
        )
        energy = wall.results["energy"] / (0.85 * area * a0)
        assert energy == pytest.approx(-np.diff(law_at.energy)[0], abs=12 * cut)  # over the range of 10 to 12 a0
