"""A wall of atoms, cut from a crystal along a map: its sums beside NumPy's, its work of adhesion, what is refused."""

from __future__ import annotations

import shutil
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.cli import main
from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.crystal_wall import (
    CUTOFF,
    SIGMA,
    CrystalWall,
    crystal_wall,
    energy_of_flat_halves,
    flat_halves,
    pair_law,
)
from atomistic.lammps.deck import Deck
from atomistic.lammps.directory import write_deck
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.plugin import CRYSTAL, Plugin
from atomistic.lammps.shape import HeightSpline
from continuum.arguments import ArgumentError
from continuum.errors import InputError
from tests.problems import two_ranks

compiler = pytest.mark.skipif(not any(map(shutil.which, ("c++", "g++", "clang++"))), reason="there is no C++ compiler")
SHAPE = (4, 5)
WALL = c.LennardJonesSpline(adhesion_length=0.05)
FLAT = HeightSpline(np.zeros(SHAPE))
ROUGH = HeightSpline(0.5 * np.random.default_rng(4).standard_normal(SHAPE))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plugin, built once."""
    folder = tmp_path_factory.mktemp("plugin")
    (folder / CRYSTAL.source).write_text(CRYSTAL.text(), encoding="utf-8")
    return CRYSTAL.build(folder)


@pytest.fixture
def built(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Decks that take the plugin as it was built."""
    monkeypatch.setattr(Plugin, "build", lambda _, folder: shutil.copy(library, folder))


def deck(shape: HeightSpline, separation: float, scatter: float = 0.0) -> Deck:
    """Atoms that stay where they are put, on five layers that move: as many as the pair law reaches."""
    slab = Slab(SHAPE, mobile=5)
    start = np.zeros((slab.layers, *SHAPE, 3))
    start[:5] = scatter * np.random.default_rng(3).standard_normal((5, *SHAPE, 3))
    heights = shape.evaluate(*np.meshgrid(*(np.arange(float(n)) for n in SHAPE), indexing="ij")).height
    return Deck(
        slab, Springs(), WALL, heights, separation, start, tolerance=1e9, shape=shape, wall_force="atoms"
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


@compiler
@pytest.mark.usefixtures("built")
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


@compiler
@pytest.mark.usefixtures("built")
def test_below_a_rough_crystal_forces_and_energy_are_the_sums_over_pairs(tmp_path: Path) -> None:
    found = crystal_wall(WALL, ROUGH, SHAPE)
    result = run_in_process(write_deck(tmp_path / "rough", deck(ROUGH, 2.3, scatter=0.1)))
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


@compiler
@pytest.mark.long
def test_a_wall_of_atoms_slides_under_a_load_on_two_ranks_too(tmp_path: Path) -> None:
    contact = c.Contact(c.SelfAffine(0.8, 0.2, 4, 8).synthesise(c.Grid.square(8), np.random.default_rng(1)), WALL)
    table = {
        "kind": "sliding", "pressure": 0.02, "distance": 1.0, "velocity": 0.2, "window": 5.0, "temperature": 0.0,
        "thermostat_layers": 1,
    }  # fmt: skip
    made = a.deck(contact, protocol=table, depth=4, follows="atom", wall_force="atoms")
    one = a.run_deck(made.write(tmp_path / "one"))
    two = run_command(made.write(tmp_path / "two"), two_ranks())
    assert one.finished
    # Some hundred steps of Newton's law magnify rounding, but not by a million.
    assert np.allclose(one.last.displacements, two.displacements, rtol=0, atol=1e-8)
    assert one.last.separation == pytest.approx(two.separation, abs=1e-8)


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
    'n = 8\ndepth = 4.0\n[surface]\nkind = "sphere"\nradius = 20.0\n'
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
