"""ASE and OVITO read every file of a run: species, vectors, contact, wall.  `atomistic read` stores and draws it."""

import os
from importlib import util
from pathlib import Path

import ase.io
import ase.io.lammpsdata
import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

import atomistic as a
import continuum as c
from atomistic.front.functions import DeckRun
from atomistic.lammps.session import LammpsHandle
from atomistic.show import decks
from continuum.store import datasets as store
from continuum.view.states import OpenedResults
from tests.printed import faults_in_print
from tests.stored import opens_in_xarray

needs_ovito = pytest.mark.skipif(util.find_spec("ovito") is None, reason="ovito is not installed")
NAMES = ("springs", "copper")
GRID = c.Grid.square(9)


def _run(name: str, directory: Path) -> DeckRun:
    """A sphere on springs or copper: files are what is looked at."""
    with pytest.warns(UserWarning, match="fewer than 4 points"):  # the edge of the period, on so small a grid
        contact = c.Contact(c.sphere(GRID, 40.0), c.LennardJonesSpline(adhesion_length=0.02))
    if name == "springs":
        return a.run_deck(a.deck(contact, separations=[1.2, 1.1], depth=4).write(directory))
    from atomistic.crystal.potentials import EmbeddedAtom, find_potential

    copper = EmbeddedAtom.read(find_potential("Cu_mishin1.eam.alloy"))
    return a.run_deck(a.deck(contact, copper, separation=1.1, depth=6).write(directory))


@pytest.fixture(scope="module", params=NAMES)
def run(request, tmp_path_factory) -> DeckRun:
    # The response of a crystal is kept on disk where the user's is, unless told otherwise.
    return _run(request.param, tmp_path_factory.mktemp("runs") / request.param)


def files(run: DeckRun) -> tuple[Path, Path]:
    mark = f".{run.last.step}" if run.last.step else ""
    return run.directory / f"state{mark}.dump", run.directory / f"surface{mark}.dump"


def test_ase_reads_every_file_with_the_right_species(run):
    slab = run.last.slab
    state, surface = files(run)
    for path, size in ((state, slab.size), (surface, GRID.size)):
        atoms = ase.io.read(path, format="lammps-dump-text")
        assert set(atoms.get_chemical_symbols()) == {run.description.element}
        assert len(atoms) == size
        assert tuple(atoms.pbc) == (True, True, False)
        assert atoms.cell.lengths()[0] == pytest.approx(GRID.shape[0] * run.description.length)
    data = ase.io.lammpsdata.read_lammps_data(run.directory / "slab.data", atom_style=style(run), units="metal")
    assert len(data) == slab.size
    assert set(data.get_chemical_symbols()) == {run.description.element}


def style(run: DeckRun) -> str:
    return "bond" if "springs" in run.description.model else "atomic"


def test_a_plain_read_data_reads_the_slab(run):
    with LammpsHandle(run.directory) as lammps:
        lammps.command(f"atom_style {style(run)}", "boundary p p f", "read_data slab.data")
        at = lammps._gathered("x").reshape(-1, 3)
    assert len(at) == run.last.slab.size
    data = ase.io.lammpsdata.read_lammps_data(run.directory / "slab.data", atom_style=style(run), units="metal")
    assert np.allclose(at[:, 2], data.positions[:, 2], rtol=0, atol=1e-12)


def test_pymatgen_reads_the_slab(run):
    lammps = pytest.importorskip("pymatgen.io.lammps.data", reason="pymatgen is not installed")
    found = lammps.LammpsData.from_file(str(run.directory / "slab.data"), atom_style=style(run))
    assert len(found.atoms) == run.last.slab.size


def test_mdanalysis_reads_the_slab(run):
    mdanalysis = pytest.importorskip("MDAnalysis", reason="MDAnalysis is not installed")
    columns = "id resid type x y z" if style(run) == "bond" else "id type x y z"
    found = mdanalysis.Universe(str(run.directory / "slab.data"), format="DATA", atom_style=columns)
    assert len(found.atoms) == run.last.slab.size
    top = found.atoms.positions[: GRID.size, 2]
    assert np.allclose(top, run.description.length * run.description.surface, rtol=0, atol=1e-5)  # single precision


@needs_ovito
def test_ovito_reads_every_file_and_shows_the_wall(run):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from ovito.io import import_file

    last, length = run.last, run.description.length
    state, surface = files(run)
    seen = import_file(str(state)).compute()
    order = np.argsort(seen.particles["Particle Identifier"])
    assert {kind.name for kind in seen.particles.particle_types.types} == {run.description.element}
    moved = np.array(seen.particles["Displacement"])[order] / length
    assert np.allclose(moved.reshape(last.displacements.shape), last.displacements, rtol=0, atol=1e-12)
    assert seen.particles["Force"].shape == (last.slab.size, 3)
    top = slice(0, GRID.size)
    kinds = np.array(seen.particles["contact"])[order]
    assert set(kinds[GRID.size :]) == {0}
    assert (kinds[top].reshape(GRID.shape) == 2).mean() == pytest.approx(last.area_rep)
    height = np.array(seen.particles["wall_height"])[order][top].reshape(GRID.shape)
    assert np.allclose(height, last.heights, rtol=0, atol=1e-12)

    seen = import_file(str(surface)).compute()
    order = np.argsort(seen.particles["Particle Identifier"])
    gap = np.array(seen.particles["gap"])[order].reshape(GRID.shape)
    assert np.allclose(gap, last.gap, rtol=0, atol=1e-12)

    meshes = import_file(str(run.directory / "wall.vtk")).compute().triangle_meshes
    vertices = np.array(next(iter(meshes.values())).get_vertices())
    assert len(vertices) == (GRID.shape[0] + 1) ** 2
    first = run.steps[0].separation + run.description.surface
    assert vertices[:, 2].min() == pytest.approx(length * (first + last.heights.min()), abs=1e-4)


@needs_ovito
def test_ovito_reads_the_data_file(run):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from ovito.io import import_file

    seen = import_file(str(run.directory / "slab.data"), atom_style=style(run)).compute()
    assert seen.particles.count == run.last.slab.size
    assert {kind.name for kind in seen.particles.particle_types.types} == {run.description.element}


def test_a_run_is_stored_drawn_and_set_beside_the_continuum(run, tmp_path, monkeypatch):
    drawn = []

    def noted(figure: Figure, stem: Path) -> Path:
        drawn.append(figure)
        return stem

    monkeypatch.setattr(decks, "save_figure", noted)
    stored, _, *walls = run.write(tmp_path / "out", compare=True)
    file = store.read_datasets(stored, "stickiness/deck-run", 2)
    assert file.attributes["finished"] is True
    assert file.attributes["element"] == run.description.element
    assert np.array_equal(file["gap"][-1], run.last.gap)
    assert file["load"][-1] * GRID.size == pytest.approx(run.last.force, rel=1e-12)
    assert file["contact"][-1].mean() == pytest.approx(2 * run.last.area_rep + run.last.area_att, rel=1e-12)
    for engine in xarray.backends.list_engines().keys() & ({"netcdf4"} if run.last.step else {"h5netcdf"}):
        opens_in_xarray(stored, engine, "stickiness/deck-run", 2)
    # `continuum view` reads it.
    seen = OpenedResults.of(stored)
    assert seen.states(0)["maps"] == ["contact", "gap"]
    assert seen.states(0)["states"][-1]["load"] == file["load"][-1]
    assert np.array_equal(seen.map(0, len(run.steps) - 1, "contact"), file["contact"][-1])
    # Same wall, same mean gap, another elasticity: strains of some per cent.
    assert file["continuum/load"][-1] == pytest.approx(file["load"][-1], rel=0.3)
    assert file["continuum/same"].min() > 0.9
    assert any(axis.has_data() for axis in drawn[0].axes)
    assert len(walls) == len(run.steps)
    assert len(run.sheets(compare=True)) == (2 if run.last.step == 0 else 3)
    real = run.description.real_units
    text = run.sheets()[-1].text()
    assert ("nN" in text and "GPa" in text) == (real is not None)
    assert "work of adhesion of the law" in text
    assert ("J/m²" in text) == (real is not None)
    if real is not None:
        # E* a0² of copper: 135 GPa x (2.556 Å)² = 8.8 nN.
        assert real.si("force") == pytest.approx(8.8e-9, rel=0.02)
    assert faults_in_print(drawn[0]) == []
