"""The numbers of a motion in LAMMPS' units: one physics whatever the sizes of a0, E* and mass, and its bounds."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy import constants as si
from scipy.optimize import brentq

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones
from atomistic.crystal.model import Crystal, CrystalModel
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.inputs.deck import steps_of
from atomistic.inputs.motion import thermal_energy
from atomistic.lammps.protocol import BLOCKS, SAMPLED, Motion, impedance, largest_timestep, vibration_timestep
from continuum.inputs.toml import ConfigError
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.walls import LennardJonesSpline

GPA = si.giga / (si.electron_volt / si.angstrom**3)  # in eV/Å³
LATTICE, C11, C12, C44 = 3.615, 169.9, 122.6, 76.2
COPPER = CrystalModel(
    EmbeddedAtom.read(find_potential("Cu_mishin1.eam.alloy")),
    Crystal(LATTICE, -3.54, CubicConstants(C11 * GPA, C12 * GPA, C44 * GPA), {}),
)
MOTION = Motion((1.2, 1.1, 1.0), (0.0, 0.0, 0.5), (30.0, 50.0), 0.01, 2, 0.5, 7, 0.03, hold=1, hold_damping=0.25)
MASS, A0 = 63.546 * si.atomic_mass, LATTICE / np.sqrt(2) * si.angstrom
SLAB = Slab((5, 6), mobile=4)
ATOMS = 30


def numbers(text: str) -> list[float]:
    """The numbers of an index variable."""
    return [float(word) for word in text.replace("&", " ").split()]


def test_a_deck_in_units_metal_moves_copper_by_kelvin_and_picoseconds() -> None:
    modulus = COPPER.contact_modulus / GPA * si.giga
    unit = np.sqrt(MASS / (modulus * A0)) / si.pico  # a0 (m/(E* a0³))^(1/2), in ps
    motion = replace(MOTION, temperature=thermal_energy("300K", COPPER.real_units))
    found = motion.placeholders(COPPER, SLAB)
    # LAMMPS' constants of Boltzmann and of the mass have six digits, as has the mass of the file.
    assert float(found["temperature"]) == pytest.approx(300, rel=5e-6)
    assert float(found["twice_temperature"]) == pytest.approx(600, rel=5e-6)
    assert float(found["boltzmann"]) == pytest.approx(si.k / si.electron_volt, rel=5e-6)
    steps = numbers(found["timesteps"])
    blocks = numbers(found["blocks"])
    assert [BLOCKS * n * dt for n, dt in zip(blocks, steps, strict=True)] == pytest.approx(
        [unit * time for time in motion.durations], rel=1e-4
    )
    assert numbers(found["dampings"]) == pytest.approx([0.25 * unit, 0.5 * unit], rel=1e-4)
    assert found["thermostatted"].replace("&", " ").split() == ["mobile", "warm"]
    assert float(found["first_warm"]) == 2 * ATOMS + 1  # the lower two layers of four


def test_a_wall_under_load_gives_way_by_the_impedance_of_copper() -> None:
    lines = replace(MOTION, pressure=0.02).placeholders(COPPER, SLAB)
    found = lines["height_of_wall"]
    (rate,) = map(float, re.findall(r"\+(\S+?)\*\$\{dt\}\*f_follow\[3\]", found))
    (load,) = map(float, re.findall(r"wanted equal (\S+)", found))
    assert load == pytest.approx(0.02 * ATOMS)
    # A load of E* a0² more than asked for, over all atoms, is a pressure E*/30: the velocity p/(ρ c), in a0/ps.
    density, speed = 4 * MASS / (LATTICE * si.angstrom) ** 3, 0.0
    speed = np.sqrt(C11 * si.giga / density)
    pressure = COPPER.contact_modulus / GPA * si.giga / ATOMS
    assert rate == pytest.approx(pressure / (density * speed) / A0 * si.pico, rel=1e-4)
    assert impedance(COPPER) == pytest.approx(np.sqrt(np.sqrt(2) * COPPER.elastic_constants.c11), rel=1e-14)
    # Fluctuation and dissipation: n atoms of the base, of the damping n x, have the drag n m/(n x) of the wall, 1/rate.
    (damping,) = map(float, re.findall(r"count\(base\)\*(\S+?)\)", lines["follow"]))
    force = COPPER.contact_modulus / GPA * si.giga * A0**2  # E* a0², in N
    assert MASS / (damping * si.pico) == pytest.approx(force / (rate * A0 / si.pico), rel=1e-4)
    assert f"langevin {lines['temperature']} {lines['temperature']} " in lines["follow"]


@pytest.mark.parametrize("constants", [(169.9, 122.6, 76.2), (170.0, 60.0, 40.0)])
def test_the_step_follows_the_stiffest_wave_of_any_crystal(constants: tuple[float, float, float]) -> None:
    crystal = Crystal(1.6, -8.0, CubicConstants(*constants), {})
    model = CrystalModel(LennardJones(), crystal)
    c11, _, c44 = (c / model.contact_modulus for c in constants)
    # ω² = 8 k: springs with C44 = k/√2, or with C11 = √2 k, whichever is the stiffer.
    fastest = np.sqrt(8 * max(np.sqrt(2) * c44, c11 / np.sqrt(2)))
    assert vibration_timestep(model) * 30 * fastest == pytest.approx(2 * np.pi, rel=1e-12)


@pytest.mark.parametrize(
    "model", [COPPER, CrystalModel(LennardJones(), Crystal(1.6, -8.0, CubicConstants(9, 5, 5), {}))]
)
def test_ratios_of_times_and_energies_do_not_depend_on_units(model: CrystalModel) -> None:
    found = MOTION.placeholders(model, SLAB)
    steps, dampings = numbers(found["timesteps"]), numbers(found["dampings"])
    assert np.divide(dampings, steps) == pytest.approx(np.divide((0.25, 0.5), MOTION.timesteps), rel=1e-12)
    kinetic = float(found["temperature"]) * float(found["boltzmann"]) / model.energy
    assert kinetic == pytest.approx(MOTION.temperature, rel=1e-12)
    assert float(found["reduced_temperature"]) == MOTION.temperature
    assert numbers(found["from"]) == [1.2, 1.1]
    assert numbers(found["to"]) == [1.1, 1.0]
    assert numbers(found["slide_to"]) == [0.0, 0.5]


@pytest.mark.parametrize(("along", "ways"), [("x", (1, 0)), ("y", (0, 1)), (30.0, (0.75**0.5, 0.5)), (90.0, (0, 1))])
def test_a_wall_slides_along_its_direction_and_not_across(along: Any, ways: tuple[float, float]) -> None:
    found = replace(MOTION, along=along).placeholders(COPPER, SLAB)
    # LAMMPS' formulas, of a window from 1 to 3 at its end.
    formulas = dict(line.split()[1::2] for line in found["offsets"].splitlines())
    slid = {"v_done": "1.0", "${slide_from}": "1.0", "${slide_to}": "3.0"}
    for name, way in zip("xy", ways, strict=True):
        text = formulas[f"offset_{name}"]
        for word, value in slid.items():
            text = text.replace(word, value)
        assert eval(text) == pytest.approx(3 * way, abs=1e-14)
    assert [float(eval(found[f"way_{name}"])) for name in "xy"] == pytest.approx(ways, abs=1e-14)


@pytest.mark.parametrize("time", [0.01, 3.0, 3.0001, 29.9999, 30.0, 1000.0])
def test_windows_are_whole_blocks_of_whole_samples_of_the_longest_step_allowed(time: float) -> None:
    motion = replace(MOTION, durations=(time, 2 * time))
    for length, block, step in zip(motion.durations, motion.block, motion.timesteps, strict=True):
        assert block % SAMPLED == 0
        assert block >= SAMPLED
        assert BLOCKS * block * step == pytest.approx(length, rel=1e-14)
        assert step <= motion.timestep * (1 + 1e-14)
        # One sample fewer to a block, and the step would be longer than allowed.
        if block > SAMPLED:
            assert length / (BLOCKS * (block - SAMPLED)) > motion.timestep


@pytest.mark.parametrize(
    ("separations", "offsets", "hold", "dwell"),
    [
        ((1.0, 1.0, 1.0, 0.9), (0.0,) * 4, 0, 2),
        ((1.0, 1.0, 1.0, 0.9), (0.0,) * 4, 1, 1),
        ((1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.1, 0.2), 0, 1),
        ((1.0, 0.9, 0.9, 0.9), (0.0,) * 4, 0, 0),
        ((1.0,) * 4, (0.0,) * 4, 1, 2),
    ],
)
def test_a_wall_dwells_until_it_first_moves(
    separations: tuple[float, ...], offsets: tuple[float, ...], hold: int, dwell: int
) -> None:
    motion = replace(MOTION, separations=separations, offsets=offsets, durations=(1.0,) * 3, hold=hold)
    assert motion.dwell == dwell
    assert motion.about()["dwell"] == dwell
    assert motion.about()["hold"] == hold
    moved = [a != b for a, b in pairwise(zip(separations, offsets, strict=True))][hold:]
    assert motion.dwell == (moved.index(True) if any(moved) else len(moved))
    assert motion.slides == any(offsets)


@pytest.mark.parametrize(
    ("separations", "offsets", "hold", "averaged"),
    [
        ((1.0, 1.0, 0.9, 0.9, 0.9), (0.0,) * 5, 1, (2, 4)),  # it comes down, and rests
        ((1.0, 0.9, 0.9, 0.8, 0.8), (0.0,) * 5, 0, (1, 2)),  # at two places: two states, of which one is averaged
        ((1.0, 1.0, 1.0, 0.9, 0.8), (0.0,) * 5, 1, (1, 2)),
        ((1.0,) * 5, (0.0, 0.0, 0.1, 0.2, 0.2), 0, (1, 3)),  # it slides, and stops
        ((1.0, 0.9, 0.9, 0.9, 0.9), (0.0, 0.0, 0.0, 0.1, 0.2), 0, (2, 4)),  # it comes down, rests and slides
    ],
)
def test_means_are_of_the_first_windows_in_a_row_in_which_the_wall_slides_or_else_rests(
    separations: tuple[float, ...], offsets: tuple[float, ...], hold: int, averaged: tuple[int, int]
) -> None:
    motion = replace(MOTION, separations=separations, offsets=offsets, durations=(1.0,) * 4, hold=hold)
    assert motion.about()["averaged"] == averaged


def test_a_wall_that_never_rests_has_no_windows_for_a_mean() -> None:
    first, last = replace(MOTION, separations=(1.2, 1.1, 1.0), offsets=(0.0,) * 3).averaged
    assert first == last


TABLE = {"kind": "velocity", "separations": [1.2, 1.1], "temperature": 0.01, "window": 30.0}
BOUNDS: dict[str, tuple[float, float]] = {
    "temperature": (0.0, -1e-300),
    "damping": (0.1, 0.0999),
    "velocity": (1e-3, 0.0),
    "window": (1.0, 0.9999),
    "hold": (1, 0),
    "dwell": (0, -1),
    "thermostat_layers": (1, 0),
    "seed": (1_000_000, 1_000_001),  # which LAMMPS takes
}


@pytest.mark.parametrize("name", BOUNDS)
def test_numbers_of_a_motion_go_to_their_bounds_and_no_further(name: str) -> None:
    allowed, beyond = BOUNDS[name]
    assert getattr(steps_of(TABLE | {name: allowed}).motion, name) == allowed
    for value in (beyond, float("nan"), float("inf")):
        with pytest.raises(ConfigError, match=name):
            steps_of(TABLE | {name: value})


def test_layers_of_the_thermostat_are_fewer_than_move() -> None:
    assert MOTION.misfit(3, stays=False) is None
    for mobile, stays, name in ((2, False, "layers"), (3, True, "shape")):
        found = MOTION.misfit(mobile, stays=stays)
        assert found is not None
        assert found[0] == name
    assert replace(MOTION, offsets=(0.0,) * 3).misfit(3, stays=True) is None


@pytest.mark.parametrize("k", [0.01, 0.5])
def test_the_largest_step_follows_the_wall_where_it_pushes_with_its_modulus_or_as_much_as_it_can(k: float) -> None:
    """Down to the core, from where on the wall is no stiffer; to a step of two thousand of the gaps looked at."""
    wall = LennardJonesSpline(0.3, k)

    def missing(gap: float) -> float:
        return float(wall.evaluate(np.array(gap)).traction) - 1.0

    gap = brentq(missing, wall.core, 1.0) if missing(wall.core) > 0 else wall.core
    stiffness = float(wall.evaluate(np.array(gap)).stiffness)
    assert stiffness > k
    assert largest_timestep(COPPER, wall) == pytest.approx(vibration_timestep(COPPER, stiffness), rel=2e-3)
