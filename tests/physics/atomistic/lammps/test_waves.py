"""Periods of vibrations and velocities of waves, against the dynamical matrix of an fcc crystal of springs."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy import constants

import atomistic as a
from atomistic.lammps.protocol import impedance, swing, time_unit, vibration_timestep
from continuum.model.fourier import Real

# The twelve neighbours at the distance a0, and the mass of an atom, 1; a0³/√2 is the volume of each.
BONDS = np.array([b for b in product((-1, 0, 1), repeat=3) if np.abs(b).sum() == 2]) / np.sqrt(2)
DENSITY = np.sqrt(2)
SPRINGS = a.Springs()


def squared_frequencies(q: Real) -> Real:
    """ω² of the three modes at a wavevector, in E* a0/m, ascending."""
    matrix = SPRINGS.stiffness * np.einsum("b,bi,bj->ij", 1 - np.cos(BONDS @ q), BONDS, BONDS)
    return np.linalg.eigvalsh(matrix)


def test_the_time_step_divides_the_period_of_the_stiffest_vibration() -> None:
    edge = np.sqrt(2)
    zone = (np.array(q) * np.pi / edge / 4 for q in product(range(9), repeat=3))
    stiffest = max(squared_frequencies(q)[-1] for q in zone)
    assert stiffest == pytest.approx(8 * SPRINGS.stiffness)
    step = vibration_timestep(SPRINGS)
    assert 2 * np.pi / np.sqrt(stiffest) / step == pytest.approx(30, rel=1e-4)
    # Under a wall that is as stiff as the crystal, √2 times as fast.
    assert vibration_timestep(SPRINGS, stiffest) == pytest.approx(step / np.sqrt(2), rel=1e-4)


def test_long_waves_have_the_velocity_that_swing_and_impedance_take() -> None:
    q = 1e-3
    velocity = np.sqrt(squared_frequencies(np.array([0.0, 0.0, q]))[-1]) / q
    assert impedance(SPRINGS) == pytest.approx(DENSITY * velocity, rel=1e-4)
    # A quarter of the wave is as long as the slab is deep.
    assert swing(SPRINGS, 7.0) == pytest.approx(2 * np.pi * velocity / (4 * 7.0), rel=1e-4)


def test_the_unit_of_time_is_that_of_newton() -> None:
    """a0 (m/(E* a0³))^(1/2) of copper in ps, from u, Å and eV; and in units without a size as it stands."""
    mass, length, energy = 63.546, 2.556, 14.1
    copper = cast(Any, SimpleNamespace(units="metal", mass=mass, length=length, energy=energy))
    seconds = length * constants.angstrom * np.sqrt(mass * constants.atomic_mass / (energy * constants.eV))
    assert time_unit(copper) == pytest.approx(seconds / constants.pico, rel=1e-6)
    plain = cast(Any, SimpleNamespace(units="lj", mass=2.0, length=1.5, energy=8.0))
    assert time_unit(plain) == pytest.approx(1.5 * np.sqrt(2.0 / 8.0))
