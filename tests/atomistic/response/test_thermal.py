"""Warm crystals against the quasi-harmonic theory of their pair potential, and a free surface that stays at rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones
from atomistic.crystal.model import CrystalModel
from atomistic.response import thermal
from atomistic.response.force_constants import force_constants
from atomistic.response.material import model_of
from atomistic.response.thermal import WarmCrystal

CUTOFF = 2.5


@pytest.fixture(scope="module")
def model() -> CrystalModel:
    found = model_of(LennardJones(CUTOFF))
    assert isinstance(found, CrystalModel)
    return found


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fifth of the time steps: errors are twice as large."""
    for name, steps in (("_BULK_STEPS", 200), ("_SURFACE_STEPS", 150), ("_SETTLING", 500)):
        monkeypatch.setattr(thermal, name, steps)


def free_energy(edge_of_cell: float, temperature: float) -> float:
    """Quasi-harmonic free energy of 256 atoms, in ε, of the pair potential at a lattice constant in σ.

    Classical: k_B T ln ω of each vibration of the cell, and that of an ideal particle for the centre of mass.
    """
    edge = 4
    shifts = np.stack(np.meshgrid(*3 * [np.arange(-6, 7)], indexing="ij"), -1).reshape(-1, 3) / 2
    bonds = edge_of_cell * shifts[np.isclose(shifts.sum(axis=1) % 1, 0)]
    r = np.linalg.norm(bonds, axis=1)
    near = (r > 0) & (r < CUTOFF)
    bonds, r = bonds[near], r[near]

    def slope(x: np.ndarray | float) -> np.ndarray | float:
        return 4 * (-12 / x**13 + 6 / x**7)

    end = 4 * (CUTOFF**-12 - CUTOFF**-6)
    value = 4 * (r**-12 - r**-6) - end - (r - CUTOFF) * slope(CUTOFF)
    first, second = slope(r) - slope(CUTOFF), 4 * (156 / r**14 - 42 / r**8)
    n = bonds / r[:, None]
    along = n[:, :, None] * n[:, None, :]
    constants = along * second[:, None, None] + (np.eye(3) - along) * (first / r)[:, None, None]
    # Waves of the periodic cell of 4 x 4 x 4 cubes: those of the grid that are not the same modulo the bcc reciprocal.
    whole = np.stack(np.meshgrid(*3 * [np.arange(2 * edge)], indexing="ij"), -1).reshape(-1, 3)
    waves = whole[whole[:, 2] < edge][1:]
    phase = 1 - np.cos(2 * np.pi / (edge * edge_of_cell) * waves @ bonds.T)
    squares = np.linalg.eigvalsh(np.tensordot(phase, constants, axes=(1, 0)))
    vibrations = 0.5 * temperature * np.log(squares).sum() - temperature * 3 * np.log(edge_of_cell)
    return float(256 * value.sum() / 2 + vibrations)


def test_lattice_constant_and_surface_are_those_of_quasi_harmonic_theory(model: CrystalModel, quick: None) -> None:
    temperature, rest = 1e-4, model.crystal.lattice_constant
    warm = thermal.measure_warm_crystal(model, temperature, layers=3)
    found = minimize_scalar(
        free_energy, bounds=(rest, 1.01 * rest), args=(temperature * model.energy,), method="bounded",
        options={"xatol": 1e-9},
    ).x / rest - 1  # fmt: skip
    assert warm.stretch_error < 0.01 * found
    # What is not quasi-harmonic takes off 22 T of it, seen from T = 2e-4 to 1e-3; the pressure of the gas is a ninth.
    assert warm.stretch - 1 == pytest.approx(found, abs=4 * warm.stretch_error + 40 * temperature * found)
    # As T tends to 0 the surface is where it is at rest; what is added is of the order of the expansion of a layer.
    relaxed = force_constants(model, 3).relaxation
    np.testing.assert_allclose(warm.rise, relaxed[:3], rtol=0, atol=4 * warm.rise_error + 2 * found)


@pytest.mark.long
def test_a_free_warm_surface_stays_where_separations_count_from(
    model: CrystalModel, quick: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STICKINESS_CACHE", str(tmp_path / "cache"))
    flat = c.Contact(c.sine(c.Grid.square(6), 1e-3, (1, 0)), c.LennardJonesSpline(0.0))
    motion = {"kind": "velocity", "separations": [4.0], "temperature": 0.002, "window": 20.0, "hold": 2, "dwell": 3,
              "thermostat_layers": 1}  # fmt: skip
    told: list[tuple[int, int]] = []
    made = a.deck(flat, LennardJones(CUTOFF), protocol=motion, depth=4, progress=lambda *done: told.append(done))
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert any("Lattice constant at this temperature" in note for note in made.notes)
    directory = made.write(tmp_path / "deck")
    a.run_deck(directory)
    run = a.read(directory)
    assert [run.description.hold, run.description.dwell, len(run.averaged)] == [2, 3, 3]
    # A deck of an earlier version does not say what is averaged.
    assert replace(run, description=replace(run.description, averaged=())).averaged == run.averaged == run.steps[2:]
    found = run.mean("mean_gap")
    # The place of the surface was itself measured, to an error that its notes say.
    error = np.hypot(found.error, 0.003)
    assert found.mean == pytest.approx(4.0, abs=3 * error)
    # Built as at rest, it would rise by 2 depth (a(T)/a - 1), as its sides cannot move.
    assert error < 0.1 * 2 * 4 * (made.model.length / model.length - 1)
    # Told from the file, not measured, the second time.
    again = a.deck(flat, LennardJones(CUTOFF), protocol=motion, depth=4, progress=lambda *done: told.append(done))
    assert len(told) == 4
    assert again.model.length == made.model.length


def test_a_damaged_file_is_measured_anew_and_a_folder_that_cannot_be_written_does_without(
    model: CrystalModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    warm = WarmCrystal(1e-3, 1.01, 1e-4, 0.0, (0.1, 0.0), 1e-3)
    calls = []
    monkeypatch.setattr(thermal, "measure_warm_crystal", lambda *given: calls.append(given[2]) or warm)
    assert thermal.warm_crystal(model, 1e-3, 2, tmp_path) == warm
    assert thermal.warm_crystal(model, 1e-3, 2, tmp_path) == warm
    assert calls == [0, 2]  # the lattice constant, which has a file of its own, and the layers
    assert thermal.warm_crystal(model, 1e-3, 3, tmp_path) == warm
    assert calls == [0, 2, 3]
    assert thermal.warm_crystal(model, 2e-3, 2, tmp_path) == warm
    assert calls == [0, 2, 3, 0, 2]
    for file in tmp_path.iterdir():
        file.write_text("{")
    assert thermal.warm_crystal(model, 1e-3, 2, tmp_path) == warm
    assert calls == [0, 2, 3, 0, 2, 0, 2]
    (tmp_path / "file").write_text("")
    assert thermal.warm_crystal(model, 1e-3, 2, tmp_path / "file" / "folder") == warm


def test_a_deeper_slab_is_in_the_middle_as_the_measured_one() -> None:
    warm = WarmCrystal(1e-3, 1.01, 1e-4, 0.0, (0.4, 0.3, 0.2, 0.1), 1e-3)
    np.testing.assert_allclose(warm.rise_of(Slab((4, 4), 4, 2)), [0.4, 0.3, 0.2, 0.1, 0, 0])
    np.testing.assert_allclose(warm.rise_of(Slab((4, 4), 6, 1)), [0.4, 0.3, 0.25, 0.25, 0.2, 0.1, 0])
