"""Warm crystals against the quasi-harmonic theory of their pair potential, and a free surface that stays at rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones
from atomistic.crystal.model import CrystalModel
from atomistic.lammps.protocol import time_unit, vibration_timestep
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


@pytest.mark.parametrize(("noise", "softer"), [(1e-9, 0.8), (1.0, 0.8), (1e-9, 1.0)])
def test_the_lattice_constant_is_where_the_pressure_vanishes(
    noise: float, softer: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a crystal as stiff as at rest, or softer, by a secant; where differences are noise, by the stiffness at rest.

    Two steps, each of which leaves a part 1 - softer, or of second order, and the correction for what is left.
    """
    dilation, warm, runs, told = 3.0, np.log(1.004), list[int](), list[tuple[int, int]]()

    def pressure(model: object, temperature: float, stretch: float, blocks: int) -> tuple[float, float]:
        runs.append(blocks)
        return softer * dilation * (warm - np.log(stretch)), noise

    monkeypatch.setattr(thermal, "stretch_pressure", pressure)
    found = thermal.measure_bulk(SimpleNamespace(dilation=dilation), 1e-3, lambda *done: told.append(done))
    assert (runs, told) == ([5, 5, 10], [(1, 4), (2, 4), (3, 4)])
    left = 0.2**3 if noise == 1.0 else 0.004
    assert np.log(found.stretch) == pytest.approx(warm, rel=1.5 * left)
    assert found.stretch_error == pytest.approx(noise / (dilation * (1.0 if noise == 1.0 else softer)), rel=0.01)
    assert abs(found.pressure) < dilation * warm * (0.05 if noise == 1.0 else 0.01)
    assert (found.temperature, found.rise, found.rise_error) == (1e-3, (), 0.0)


def test_pressures_and_rises_are_means_of_blocks_with_their_standard_errors(
    model: CrystalModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The pressure with that of an ideal gas, of as many atoms in as much room; commands in LAMMPS' units."""
    rng, said, made = np.random.default_rng(1), list[str](), list[tuple]()
    parts, heights, unit = rng.normal(size=(4, 3)), rng.normal(size=(10, 4 * 64)), 7.0

    class Fake:
        pressure_unit, fix = unit, lambda self, name, i: next(values)
        command = lambda self, *lines: said.extend(lines)  # noqa: E731

        def __init__(self, *given: object, **named: object) -> None:
            made.append(given)

        def __enter__(self) -> Fake:
            return self

        def __exit__(self, *error: object) -> None:
            pass

        def per_atom(self, name: str) -> np.ndarray:
            return model.length * (sites_of_slab[:256, 2] + next(rises))

    values, rises = iter(parts.ravel()), iter(heights)
    sites_of_slab = Slab((8, 8), 2, model.coupled_layers).positions.reshape(-1, 3)
    monkeypatch.setattr(thermal, "Cell", Fake)
    found, error = thermal.stretch_pressure(model, 1e-3, 1.01, 4)
    virial = parts.mean(axis=1) / unit * model.length**3 / model.energy
    sites, periods = made[0][1:3]
    gas = 1e-3 * len(sites) / np.prod(np.array(periods) / model.length)
    assert found == pytest.approx(virial.mean() + gas, rel=1e-12)
    assert error == pytest.approx(virial.std(ddof=1) / 2, rel=1e-12)
    apart = np.linalg.norm(sites[1:] - sites[0], axis=1).min()
    assert apart == pytest.approx(1.01 * model.length, rel=1e-12)
    kelvin, step = 1e-3 * model.energy, vibration_timestep(model) * time_unit(model)
    settings = dict(line.split(maxsplit=1) for line in said if line.split()[0] in ("timestep", "velocity"))
    assert float(settings["timestep"]) == pytest.approx(step, rel=1e-12)
    assert float(settings["velocity"].split()[2]) == pytest.approx(2 * kelvin, rel=1e-12)
    (thermostat,) = (line.split() for line in said if line.startswith("fix thermostat"))
    assert [float(word) for word in thermostat[4:7]] == pytest.approx([kelvin, kelvin, 40 * step], rel=1e-12)
    assert f"fix mean all ave/time 10 150 1500 {' '.join(f'c_pressure[{i}]' for i in (1, 2, 3))}" in said
    assert said.count("run 1500 post no") == 4

    rise, error = thermal.surface_rise(model, 1e-3, 2)
    layers = heights[:, :128].reshape(10, 2, 64).mean(axis=2)
    np.testing.assert_allclose(rise, layers.mean(axis=0), atol=1e-12)
    assert error == pytest.approx(layers[:, 0].std(ddof=1) / np.sqrt(10), rel=1e-9)
    assert {"group mobile id <= 128", "fix place mobile ave/atom 10 200 2000 z", "unfix place"} < set(said)


def test_a_deeper_slab_is_in_the_middle_as_the_measured_one() -> None:
    warm = WarmCrystal(1e-3, 1.01, 1e-4, 0.0, (0.4, 0.3, 0.2, 0.1), 1e-3)
    np.testing.assert_allclose(warm.rise_of(Slab((4, 4), 4, 2)), [0.4, 0.3, 0.2, 0.1, 0, 0])
    np.testing.assert_allclose(warm.rise_of(Slab((4, 4), 6, 1)), [0.4, 0.3, 0.25, 0.25, 0.2, 0.1, 0])
