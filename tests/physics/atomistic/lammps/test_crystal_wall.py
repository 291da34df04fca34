"""A wall of atoms, a crystal along a map: its sums beside NumPy's, its work of adhesion, its roughness, refusals."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.model import Model
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.front.cli import main
from atomistic.lammps.crystal_wall import (
    CUTOFF,
    OWN,
    SIGMA,
    CrystalWall,
    WallCrystal,
    crystal_wall,
    energy_of_flat_halves,
    first_touch,
    flat_halves,
    pair_law,
)
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.session import Session
from atomistic.lammps.shape import HeightSpline, shape_of
from atomistic.response.material import model_of
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from tests.problems import two_ranks

SHAPE = (5, 5)
WALL = c.LennardJonesSpline(adhesion_length=0.05)
FLAT = HeightSpline(np.zeros(SHAPE))
ROUGH = HeightSpline(
    0.7 * np.sin(2 * np.pi * np.arange(5) / 5)[:, None] + 0.2 * np.random.default_rng(4).standard_normal(SHAPE)
)
TURNED = WallCrystal(form="bent", rows=(4, 3))
"""The lattice of the substrate, turned by 37 degrees: of 25 sites a side of 5 a0, one in 25 coincides."""


def deck(
    shape: HeightSpline, separation: float, scatter: float = 0.0, crystal: WallCrystal = OWN, model: Model | None = None
) -> Deck:
    """Atoms that stay where they are put, on five layers that move: as many as the pair law reaches."""
    model = model or Springs()
    slab = Slab(SHAPE, mobile=5, frozen=model.coupled_layers)
    start = np.zeros((slab.layers, *SHAPE, 3))
    start[:5] = scatter * np.random.default_rng(3).standard_normal((5, *SHAPE, 3))
    heights = shape.evaluate(*np.meshgrid(*(np.arange(float(n)) for n in SHAPE), indexing="ij")).height
    return Deck(
        slab, model, WALL, heights, separation, start, tolerance=1e9, shape=shape, wall_force="atoms",
        wall_crystal=crystal,
    )  # fmt: skip


def summed(atoms: np.ndarray, found: CrystalWall, separation: float) -> float:
    """Energy of atoms, shape (n, 3), below the crystal and its images, pair by pair."""
    energy = 0.0
    for i, j in product(range(-1, 2), repeat=2):
        sites = found.sites + np.array([i * SHAPE[0], j * SHAPE[1], separation])
        energy += float(pair_law(np.linalg.norm(atoms[:, None] - sites, axis=2)).sum())
    return found.strength * energy


def test_the_pair_law_ends_without_a_jump_and_is_at_rest_near_a0() -> None:
    step = 1e-6
    assert float(pair_law(np.array(CUTOFF - step))) == pytest.approx(0, abs=10 * step**2)
    r = np.linspace(0.95, 1.1, 15001)
    # The tangent at the cut-off, 0.039 ε/σ, moves the rest by its slope over the stiffness, 57 ε/a0².
    assert r[np.argmin(pair_law(r))] == pytest.approx(1.0, abs=0.039 / SIGMA / 57 * 1.1)


def test_flat_halves_have_the_work_of_adhesion_of_the_law() -> None:
    rest, unit = flat_halves()
    found = crystal_wall(WALL, FLAT, SHAPE)
    slab = Slab(SHAPE, mobile=5)
    atoms = slab.positions[:5].reshape(-1, 3)
    area = SHAPE[0] * SHAPE[1]
    # At the gap where the law of the smooth wall has no traction.
    assert summed(atoms, found, WALL.zero_gap) / area == pytest.approx(-WALL.work_of_adhesion, rel=1e-12)
    for away in (-0.01, 0.01):
        assert summed(atoms, found, WALL.zero_gap + away) / area > -WALL.work_of_adhesion
    assert energy_of_flat_halves(rest) == pytest.approx(-unit, rel=1e-12)
    # Atoms of one crystal are at rest a little closer than springs, as second neighbours attract.
    assert 0.95 < rest / LAYER_SPACING < 1


def test_a_turned_crystal_has_the_work_of_adhesion_and_hardly_feels_its_registry() -> None:
    atoms, area = Slab(SHAPE, mobile=5).positions[:5].reshape(-1, 3), SHAPE[0] * SHAPE[1]
    energies = {}
    for crystal in (OWN, TURNED):
        found = crystal_wall(WALL, FLAT, SHAPE, crystal)
        moved = (
            found._replace(sites=found.sites + np.array([x, y, 0])) for x, y in product(np.arange(4) / 4, repeat=2)
        )
        energies[crystal] = np.array([summed(atoms, wall, WALL.zero_gap) / area for wall in moved])
    # Means over some registries err by 1e-5, as the force has a kink at the cut-off.
    assert energies[TURNED].mean() == pytest.approx(-WALL.work_of_adhesion, rel=2e-5)
    # So small a period leaves one of √5 per a0: a hundredth.
    assert np.ptp(energies[TURNED]) < 0.02 * WALL.work_of_adhesion
    assert np.ptp(energies[OWN]) > 0.5 * WALL.work_of_adhesion


@pytest.mark.parametrize("crystal", [OWN, TURNED, WallCrystal(form="bent", rows=(6, 0)), WallCrystal(rows=(3, 4))])
def test_a_crystal_is_whole_over_the_border_of_its_period(crystal: WallCrystal) -> None:
    found = crystal_wall(WALL, FLAT, SHAPE, crystal)
    spacing = 5 / np.hypot(*(crystal.rows or (5, 0)))
    assert found.sites[:, :2].min() >= 0
    assert found.sites[:, :2].max() <= 5
    apart = found.sites[:, None] - found.sites
    apart[..., :2] -= 5 * np.round(apart[..., :2] / 5)
    apart = np.linalg.norm(apart, axis=2)
    # Four neighbours in the plane and four above, at one distance.
    lowest = found.sites[:, 2] == found.sites[:, 2].min()
    assert (np.count_nonzero(np.isclose(apart[lowest], spacing, rtol=1e-9), axis=1) == 8).all()
    assert apart[apart > 0].min() == pytest.approx(spacing, rel=1e-12)


def test_a_cut_is_no_farther_from_the_heights_than_half_a_plane() -> None:
    found = crystal_wall(WALL, ROUGH, SHAPE)
    shift = flat_halves()[0] - WALL.zero_gap
    x, y, z = np.transpose(found.sites)
    above = z - shift - ROUGH.evaluate(x, y).height
    assert above.min() >= -LAYER_SPACING / 2
    # The lowest atom of each column of sites, which stand two planes apart.
    for i, j in set(zip(x.tolist(), y.tolist(), strict=True)):
        assert above[(x == i) & (y == j)].min() < 1.5 * LAYER_SPACING
    nearest = np.linalg.norm(found.sites[:, None] - found.sites, axis=2)
    assert nearest[nearest > 0].min() == pytest.approx(1.0, rel=1e-12)
    assert found.rms_lost < LAYER_SPACING / 2


@pytest.mark.parametrize("crystal", [WallCrystal(form="bent"), TURNED])
def test_a_bent_crystal_has_the_heights_of_the_map_in_each_plane(crystal: WallCrystal) -> None:
    found, flat = (crystal_wall(WALL, shape, SHAPE, crystal).sites for shape in (ROUGH, FLAT))
    assert (found[:, :2] == flat[:, :2]).all()
    assert np.allclose(found[:, 2] - flat[:, 2], ROUGH.evaluate(*found.T[:2]).height, rtol=0, atol=1e-12)


def test_a_cut_that_would_lose_half_of_the_roughness_is_refused_with_what_it_would_keep() -> None:
    """All 144 atoms of the first plane of this one stand in one plane."""
    heights = c.SelfAffine(0.8, 0.1, 4, 12).synthesise(c.Grid.square(12), np.random.default_rng(5))
    contact = c.Contact(heights, WALL)
    with pytest.raises(ArgumentError, match=r'form = .*"bent".*keep an rms height of 0 a0 of the 0\.118 a0'):
        a.deck(contact, separation=1.5, depth=4, follows="atom", wall_force="atoms")
    made = a.deck(
        contact, separation=1.5, depth=4, follows="atom", wall_force="atoms", wall_crystal={"form": "bent"}
    )  # fmt: skip
    assert made.crystal is not None
    first = made.crystal.sites[:144, 2]
    assert first.std() == pytest.approx(heights.std(), rel=0.02)  # of other points of the same map
    assert made.crystal.rms_kept == pytest.approx(first.std(), rel=1e-12)
    assert "keep an rms height of 0.118 a0 of the 0.118 a0 of the map" in made.notes[-1]
    # Of planes that are fine beside the map a cut keeps most, but never all.
    coarse = crystal_wall(WALL, shape_of(5 * heights), (12, 12))
    assert 0.8 * coarse.rms_height < coarse.rms_kept < coarse.rms_height


def test_the_force_between_flat_halves_is_the_derivative_of_their_energy(tmp_path: Path) -> None:
    rest, unit = flat_halves()
    area, strength, step = SHAPE[0] * SHAPE[1], WALL.work_of_adhesion / unit, 1e-5
    for separation in (0.97, 1.05, 1.3, 1.8):
        result = run_in_process(write_deck(tmp_path / f"{separation}", deck(FLAT, separation)))
        distance = rest + separation - WALL.zero_gap
        energies = [strength * energy_of_flat_halves(distance + d) for d in (-step, step)]
        # Central differences miss step² times the third derivative: a thousand of ε, of 0.01 E* a0³, for each pair.
        assert result.force / area == pytest.approx((energies[0] - energies[1]) / (2 * step), abs=1e-7)
        assert result.wall_energy / area == pytest.approx(strength * energy_of_flat_halves(distance), rel=1e-10)
        assert abs(result.lateral_x) < 1e-12 * area  # rounding, of forces of some 0.1 E* a0²
        assert np.allclose(result.gap, separation)


@pytest.mark.parametrize("crystal", [OWN, TURNED])
def test_below_a_rough_crystal_forces_and_energy_are_the_sums_over_pairs(tmp_path: Path, crystal: WallCrystal) -> None:
    found = crystal_wall(WALL, ROUGH, SHAPE, crystal)
    result = run_in_process(write_deck(tmp_path / "rough", deck(ROUGH, 2.3, scatter=0.1, crystal=crystal)))
    atoms = (result.slab.positions + result.displacements)[:5].reshape(-1, 3)
    assert result.wall_energy == pytest.approx(summed(atoms, found, 2.3), rel=1e-10)
    step = 1e-5
    for axis, force in enumerate((result.lateral_x, result.lateral_y, -result.force)):
        ends = [summed(atoms + sign * step * np.eye(3)[axis], found, 2.3) for sign in (-1, 1)]
        # Central differences miss step² times the third derivative: (13/r)² step² of the steepest power.
        assert force == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6, abs=1e-9)
    # The traction is that on each surface atom.
    at = atoms[7:8]
    ends = [summed(at + np.array([0, 0, sign * step]), found, 2.3) for sign in (-1, 1)]
    assert result.traction.ravel()[7] == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("potential", [LennardJones(), EmbeddedAtom.read(find_potential("Cu_mishin1.eam.alloy"))])
def test_beside_the_forces_of_any_crystal_those_of_the_wall_are_the_sums_over_pairs(tmp_path: Path, potential) -> None:
    made = deck(ROUGH, 2.3, 0.05, model=model_of(potential))
    assert made.crystal is not None
    result = run_in_process(write_deck(tmp_path / "deck", made))
    atoms = (result.slab.positions + result.displacements)[:6].reshape(-1, 3)
    assert result.wall_energy == pytest.approx(summed(atoms, made.crystal, 2.3), rel=1e-10)
    with Session(tmp_path / "deck") as alone:  # its script has no wall
        energy, forces = alone.evaluate(result.displacements)
    # Digits lost in the sum over the slab, whose atoms have some 0.1 E* a0³ each.
    assert result.total_energy - energy == pytest.approx(result.wall_energy, abs=1e-12 * result.slab.size)
    pushed = (result.forces - forces)[: made.slab.mobile].sum(axis=(0, 1, 2))
    assert pushed == pytest.approx([result.lateral_x, result.lateral_y, -result.force], abs=1e-10)


def test_a_wall_of_atoms_keeps_a_load_above_warm_atoms(tmp_path: Path) -> None:
    """Its atoms stand where the balance of the load says: each window begins at the height at which the last ended."""
    contact = c.Contact(c.sine(c.Grid.square(4), 0.05, (1, 0)), WALL)
    table = {
        "kind": "sliding", "pressure": 0.02, "distance": 0.2, "velocity": 0.2, "window": 1.0, "temperature": 0.001,
        "thermostat_layers": 1,
    }  # fmt: skip
    made = a.deck(contact, protocol=table, depth=2.2, follows="atom", wall_force="atoms", wall_crystal={"form": "bent"})
    run = a.run_deck(made.write(tmp_path))
    assert run.finished
    assert len({step.separation for step in run.steps}) == len(run.steps) > 1


@pytest.mark.long
def test_a_wall_of_atoms_slides_under_a_load_on_two_ranks_too(tmp_path: Path) -> None:
    contact = c.Contact(c.SelfAffine(0.8, 0.2, 4, 8).synthesise(c.Grid.square(8), np.random.default_rng(1)), WALL)
    table = {
        "kind": "sliding", "pressure": 0.02, "distance": 1.0, "velocity": 0.2, "window": 5.0, "temperature": 0.0,
        "thermostat_layers": 1,
    }  # fmt: skip
    made = a.deck(contact, protocol=table, depth=4, follows="atom", wall_force="atoms", wall_crystal={"form": "bent"})
    one = a.run_deck(made.write(tmp_path / "one"))
    two = run_command(made.write(tmp_path / "two"), two_ranks())
    assert one.finished
    # Some hundred steps of Newton's law magnify rounding, but not by a million.
    assert np.allclose(one.last.displacements, two.displacements, rtol=0, atol=1e-8)
    assert one.last.separation == pytest.approx(two.separation, abs=1e-8)


@pytest.mark.parametrize("crystal", [OWN, TURNED, WallCrystal(rows=(3, 4))])
def test_at_first_touch_the_nearest_atoms_are_a_diameter_apart(crystal: WallCrystal) -> None:
    found = crystal_wall(WALL, ROUGH if crystal.form == "bent" else FLAT, SHAPE, crystal)
    surface = np.array([(i, j, 0.0) for i, j in product(range(-1, 7), repeat=2)])
    sites = found.sites + np.array([0, 0, first_touch(found)])
    assert np.linalg.norm(sites[:, None] - surface, axis=2).min() == pytest.approx(SIGMA, rel=1e-12)


def test_a_wall_begins_where_its_atoms_do_not_overlap_the_surface() -> None:
    contact = c.Contact(c.sine(c.Grid.square(8), 0.5, (1, 0)), WALL)
    with pytest.raises(c.NotConvergedError, match="begin at") as error:
        a.deck(contact, separation=0.2, depth=4, follows="atom", wall_force="atoms")
    touch = float(str(error.value).split("begin at ")[1].split()[0])
    made = a.deck(contact, pressures=[0.01], depth=4, follows="atom", wall_force="atoms")
    assert made.separation == pytest.approx(touch, abs=1e-3)
    assert made.shape is not None
    sites = crystal_wall(WALL, made.shape, (8, 8)).sites + np.array([0, 0, made.separation])
    surface = made.slab.positions[0].reshape(-1, 3)
    assert np.linalg.norm(sites[:, None] - surface, axis=2).min() == pytest.approx(SIGMA, rel=1e-9)


@pytest.mark.parametrize(
    ("wall", "follows", "words"),
    [
        (WALL, "site", "wall_force = 'atoms'.*follows.*act at the positions of the atoms"),
        (c.LennardJonesSpline(0.0), "atom", "a law with a work of adhesion"),
    ],
)
def test_what_atoms_cannot_be_is_refused(wall: c.Wall, follows: str, words: str) -> None:
    contact = c.Contact(c.sine(c.Grid.square(8), 0.05, (1, 0)), wall)
    with pytest.raises((ArgumentError, InputError), match=words):
        a.deck(contact, separation=1.2, depth=4, follows=follows, wall_force="atoms")


TIP = (
    'follows = "atom"\nwall_force = "atoms"\nseparation = {separation}\n[interatomic]\nkind = "springs"\n[slab]\n'
    'n = 8\ndepth = 4.0\n[surface]\nkind = "sphere"\nradius = 8.0\n'
    '[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = {adhesion_length}\n'
)


def test_check_finds_a_wall_of_atoms_that_overlaps_the_surface(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tip.toml"
    path.write_text(TIP.format(separation=0.2, adhesion_length=0.005))
    assert main(["check", str(path)]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "separation = 0.2" in said
    touch = said.split("allowed: ")[1].split(" or above at first")[0]
    path.write_text(TIP.format(separation=touch, adhesion_length=0.005))
    assert main(["check", str(path)]) == 0
    path.write_text(TIP.format(separation=1.2, adhesion_length=0.0))
    assert main(["check", str(path)]) == 2
    assert "a law with a work of adhesion" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[interatomic]", "[wall_crystal]\nrows = [5, 0]\n[interatomic]", "rows = [5, 0] allowed: (p, q) of 0 or more"),
        ("[interatomic]", "[wall_crystal]\nrows = [6, -4]\n[interatomic]", "rows = [6, -4] allowed"),
        ("radius = 8.0", "radius = 20.0", '"bent" where planes 0.71 a0 apart are too coarse'),
        ('"atoms"', '"plugin"\n[wall_crystal]\nform = "bent"', "a table of a wall with wall_force"),
    ],
)
def test_check_says_what_crystal_a_wall_cannot_be(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, words: str
) -> None:
    lines = TIP.format(separation=1.2, adhesion_length=0.005).replace("separation = 1.2\n", "")
    path = tmp_path / "tip.toml"
    path.write_text("separation = 1.2\n" + lines.replace(old, new))
    assert main(["check", str(path)]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "wall_crystal" in said
    assert words in said
