"""What a contact knows of a given gap: elastic energy, separation, displacement."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Layer
from continuum.model.substrates.tabulated import TabulatedSubstrate
from continuum.model.surfaces import sine
from continuum.model.walls import LennardJonesSpline

GRID, AMPLITUDE = Grid.square(32), 0.3
HEIGHTS = sine(GRID, AMPLITUDE, (2, 0))


def test_a_wave_that_is_flattened_holds_its_elastic_energy() -> None:
    """Full contact, u = h: ½ K_q <u²> with K_q = E* q/2 and <u²> = a²/2, whatever the mean of the gap."""
    problem = ContactProblem(GRID, LennardJonesSpline(0.3), HEIGHTS, HalfSpace("clamped"))
    q = 2 * np.pi * 2 / 32
    for mean_gap in (0.0, 1.7):
        energy = problem.elastic_energy(np.full(GRID.shape, mean_gap))
        assert energy == pytest.approx(q * AMPLITUDE**2 / 8, rel=1e-12)
    # All of it is of the elasticity where the wall is too far to act.
    displacement = HEIGHTS - HEIGHTS.mean()
    assert problem.energy(displacement, 50.0) == pytest.approx(q * AMPLITUDE**2 / 8 * 32**2, rel=1e-12)


def test_the_separation_is_that_of_the_mean_gap_less_what_the_load_compresses() -> None:
    stiffness = 0.1
    problem = ContactProblem(GRID, LennardJonesSpline(0.3), HEIGHTS, Layer(8.0, 0.3, stiffness))
    separation = problem.separation(1.5, 0.02, lambda: np.full(GRID.shape, 0.02))
    gap = np.full(GRID.shape, 1.5)
    # A pressure pushes the surface down, away from the wall.
    assert problem.displacement(gap, separation).mean() == pytest.approx(-0.02 / stiffness, rel=1e-9)


def test_a_clamped_mean_carries_any_traction_and_needs_none() -> None:
    problem = ContactProblem(GRID, LennardJonesSpline(0.3), HEIGHTS, HalfSpace("clamped"))
    wave = sine(GRID, AMPLITUDE, (2, 0))
    found = problem.elastic_traction_q(GRID.forward(wave + 1.3))
    np.testing.assert_allclose(found, problem.elastic_traction_q(GRID.forward(wave)), atol=1e-15)
    assert found[0, 0] == 0


@pytest.mark.parametrize("share", [0.25, 1.0, 4.0])
def test_tolerances_are_relative_to_the_tractions_that_flatten_the_surface(share: float) -> None:
    """Of a wave, K_q a/sqrt(2) is the root mean square: twice that, where the substrate is softer than E* = 1."""
    stiffness = share * HalfSpace("free").stiffness(GRID)
    substrate = TabulatedSubstrate(stiffness, GRID.lengths, "a share of the half-space")
    problem = ContactProblem(GRID, LennardJonesSpline(0.3), HEIGHTS, substrate)
    slope = 2 * np.pi * 2 / 32 * AMPLITUDE / np.sqrt(2)
    assert problem.traction_scale == pytest.approx(min(share, 1.0) * slope, rel=1e-12)
