"""A sphere on a rough surface: both limits of its pull-off force, the interval in between, and what is said of it."""

from __future__ import annotations

from itertools import takewhile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.maps.map import Topography
from continuum.maps.verdict.adhesion import probe_doubts, probe_pull_off
from continuum.maps.verdict.criteria import RoughContact
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.on_grid import CORE_STIFFNESS, wall_of_map
from continuum.maps.verdict.prediction import prediction_of
from continuum.maps.verdict.search import search_threshold
from continuum.maps.verdict.threshold import press_map
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.loading import follow
from continuum.path.state import Search
from continuum.show.answer import statements
from continuum.solve.solution import Settings
from continuum.theory.smooth import MaugisDugdale
from tests.physics.continuum.maps.verdict.test_predict import surface


def contact(work: float, energy: float | None = 0.02, reach: float = 0.35) -> RoughContact:
    return RoughContact(1.0, 0.1, 0.1, work, reach, conformal_energy=energy)


def test_a_compliant_sphere_is_johnsons_a_stiff_one_derjaguins() -> None:
    """(3/2)π w R and 2π w R, to the size of the first correction in λ at these λ of 50 and 0.005."""
    w, radius = 0.05, 1e-5
    soft = MaugisDugdale(radius, w, 0.5e-9, 30e6).pull_off_force
    stiff = MaugisDugdale(radius, w, 0.5e-9, 30e12).pull_off_force
    assert soft == pytest.approx(1.5 * np.pi * w * radius, rel=1e-3)
    assert stiff == pytest.approx(2 * np.pi * w * radius, rel=1e-3)


@given(st.floats(-12, 12), st.floats(-12, 12))
def test_the_force_lies_between_both_limits_and_falls_from_stiff_to_soft(low: float, high: float) -> None:
    spheres = [MaugisDugdale(2.0, 3.0, 1.0, 10.0**power) for power in sorted((low, high))]
    forces = [sphere.pull_off_force / (6 * np.pi) for sphere in spheres]
    # One part in a thousand where the limits take over.
    assert 1.5 * (1 - 1e-6) <= forces[0] <= forces[1] + 2e-3
    assert forces[1] <= 2 * (1 + 1e-6)


def test_the_interval_is_that_of_the_energy_of_full_contact_and_of_all_of_w() -> None:
    found = probe_pull_off(contact(0.05), 1e6)  # λ = 480: JKR's
    assert found.apparent == pytest.approx(0.03)
    assert found.least == pytest.approx(1.5 * np.pi * 0.03 * 1e6, rel=1e-3)
    assert found.most == pytest.approx(1.5 * np.pi * 0.05 * 1e6, rel=1e-3)
    assert found.rim is None
    # Of a flat surface there is one force.
    flat = probe_pull_off(RoughContact(1e-9, 0.1, 0.1, 0.05, 0.35, conformal_energy=1e-12), 1e6)
    assert flat.least == pytest.approx(flat.smooth, rel=1e-6)
    assert flat.most == pytest.approx(flat.smooth, rel=1e-6)


def test_where_full_contact_costs_more_than_w_there_is_no_apparent_work() -> None:
    for energy in (0.05, 0.2, None):
        found = probe_pull_off(contact(0.05, energy), 100.0)
        assert found.apparent is None
        assert found.least is None
        assert found.most <= 2 * np.pi * 0.05 * 100


def test_a_rim_pulls_with_its_share_of_the_area() -> None:
    found = probe_pull_off(contact(0.001), 100.0, touched=0.05)
    assert found.rim == pytest.approx(2 * np.pi * 0.001 * 100 * 0.05)


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_the_solver_gains_less_than_the_rim_where_the_surface_is_not_sticky(share: float) -> None:
    """Energy per area of the states of less than 1 % in contact, each from the one before, beside that of the bound.

    On 18 Gaussian surfaces at ranges of 0.2 to 2 h_rms and 0.2, 0.5 and 0.9 of the threshold the bound was 1.8 to 50
    times what the solver gained.
    """
    topography = surface(64, seed=2, lambda_s=16.0)
    pressed = press_map(topography, Interface(1.0, 1.0, 0.1, None))
    found = pressed.threshold()
    searched = search_threshold(pressed, found)
    grid, heights = wall_of_map(topography, 1.0)
    wall = attraction_on_core("spline", share * searched.work, searched.range, CORE_STIFFNESS)
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    top = wall.zero_gap - heights.min()
    separations = np.linspace(top + searched.range, top - 2 * heights.std(), 20)
    states = follow(problem, "separation", list(separations), Settings(1e-7), search=Search(0.01))
    energies = [
        problem.elastic_energy(state.gap) + grid.mean(wall.energy(state.gap))
        for state in takewhile(lambda state: state.area_rep < 0.01, states)
    ]
    assert len(energies) > 5
    for touched in (searched.area_rep + searched.area_att, found.area_rep + found.area_att):
        assert 0 < -min(energies) < wall.work_of_adhesion * touched


def test_a_contact_that_is_too_small_or_too_wide_is_doubted() -> None:
    rough = RoughContact(1.0, 0.1, 0.1, 0.05, 0.35, conformal_energy=0.02, roll_off=64.0)
    said = {radius: " ".join(probe_doubts(rough, probe_pull_off(rough, radius))) for radius in (0.1, 1e2, 1e4)}
    assert "not a parabola" in said[0.1]
    assert "smaller than the longest waves" in said[1e2]
    assert said[1e4] == ""


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf])
def test_a_radius_that_is_none_is_refused(radius: float) -> None:
    with pytest.raises(ValueError, match="radius"):
        probe_pull_off(contact(0.05), radius)


def test_the_curve_gives_a_force_where_enough_touches_without_load() -> None:
    curve = press_map(surface(256, seed=3, lambda_s=4.0), Interface(1.0, 1.0, 0.3, None)).threshold().adhesion
    assert curve is not None
    known = {}
    for work in np.geomspace(1.6e-3, 4e-3, 24):
        unloaded = curve.at_work(work).unloaded
        if unloaded is not None and not unloaded.doubt:
            known[unloaded.area] = curve.force_on_sphere(work, 1e4, 1.0, 1.0)
    few, many = ([force for area, force in known.items() if (area < 0.005) is less] for less in (True, False))
    assert few
    assert many
    assert set(few) == {None}
    # The more of the surface touches, the more holds the sphere.
    assert all(force is not None for force in many)
    assert np.all(np.diff([force or 0.0 for force in many]) > 0)


@pytest.mark.parametrize(
    ("work", "solve", "expected"),
    [
        # U is 0.0055 J/m².
        (0.05, False, " to "),
        (1.5e-3, False, "at most"),
        (1e-4, True, "below"),
        (1e-4, False, "at most"),
    ],
)
def test_what_is_said_of_the_probe_is_what_was_shown(work: float, solve: bool, expected: str) -> None:
    small = surface(64)
    topography = Topography(1e-9 * small.heights, (64e-9, 64e-9), periodic=True)
    found = prediction_of([topography], Interface(1e9, work, 0.35e-9, None, probe=1e-6), smallest=2e-9)
    said = [line for line in statements(found.solved() if solve else found) if line.startswith("Pull-off force")]
    assert len(said) == 1
    assert expected in said[0]
