"""The adhesion curve from states without adhesion: limits, the threshold, the solver's loads, a sphere by Derjaguin."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import continuum as c
from continuum.maps.verdict.adhesion import MapCurve
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.model.walls import HardWall, Wall, attraction_on_core
from continuum.path.adhesion_curve import AREAS, AdhesionCurve, PressedSeries, press_series
from continuum.path.area import find_area
from continuum.path.equilibrium import solver_of
from continuum.path.state import Search

N, CORE, RANGE = 128, 5.0, 0.1


def wall(work: float) -> Wall:
    return attraction_on_core("spline", work, RANGE, CORE)


@cache
def series() -> tuple[c.Contact, PressedSeries]:
    """A Gaussian surface with an rms height of 1/8."""
    heights = SelfAffine(0.7, 0.1, 6.0, 32.0).synthesise(Grid.square(N), np.random.default_rng(3))
    contact = c.Contact(heights / heights.std() / 8, HardWall(), tolerance=1e-5)
    problem, settings = contact.problem, contact.settings
    first = find_area(problem, 0.01, settings, Search(0.03), (), "start", solver_of(problem, settings)).require()
    return contact, press_series(problem, first, settings, CORE)


@cache
def curve() -> AdhesionCurve:
    return series()[1].curve(wall(1e-6))


def test_the_states_lie_at_about_the_areas_that_were_asked_for() -> None:
    areas = curve().areas
    assert 12 <= areas.size <= 16
    assert np.all(np.diff(areas) > 0)
    # The pressure of the next area is extrapolated; at the first ones a few points touch.
    assert areas[-1] == pytest.approx(AREAS[-1], rel=0.1)
    assert areas[0] < 2 * AREAS[0]


def test_without_adhesion_it_is_the_curve_of_the_states_and_at_the_threshold_the_load_vanishes() -> None:
    found = curve()
    assert np.array_equal(found.loads(0.0), found.load)
    assert np.array_equal(found.gaps(0.0), found.mean_gap)
    works = found.thresholds()
    for i in range(found.areas.size):
        assert found.loads(float(works[i]))[i] == pytest.approx(0.0, abs=1e-9 * found.load[i])
    # The same work as the two forms of one state have between them, to their difference at this χ.
    state = min(series()[1].states, key=lambda one: abs(one.area_rep - 0.01))
    one = state.threshold(wall)
    at = int(np.argmin(np.abs(found.areas - state.area_rep)))
    assert 0 < one.chi < 0.2
    assert 0.99 * one.low < works[at] < 1.01 * one.high


@pytest.mark.parametrize("factor", [0.7, 1.5])
def test_the_solver_with_adhesion_has_its_loads(factor: float) -> None:
    """At 1 and 5 % of the area: the attraction is right to 8 %, the bound of docs/studies/adhesion_curve.md."""
    contact, _ = series()
    work = factor * float(curve().at([0.01]).thresholds()[0])
    for area in (0.01, 0.05):
        solved = c.Contact(contact.heights, wall(work), tolerance=1e-5).press(area=area)
        there = curve().at([solved.area_rep])
        assert there.load[0] - there.loads(work)[0] == pytest.approx(there.load[0] - solved.load, rel=0.08)


def test_before_first_touch_it_is_the_attraction_over_undeformed_gaps() -> None:
    found = curve()
    gaps, loads, areas = found.whole(1e-4)
    assert np.all(np.diff(gaps[areas == 0]) < 0)
    assert loads[0] == pytest.approx(0.0, abs=1e-12)
    assert loads[areas == 0][-1] < 0


def test_a_sphere_feels_the_energy_that_the_load_gains() -> None:
    """Derjaguin's integral to its largest is the work gained up to zero load, per area."""
    work = 2 * float(curve().at([0.01]).thresholds()[0])
    found, inside = curve().tension_on_sphere(work)
    gaps, loads, _ = curve().whole(work)
    pulls = loads[: int(np.argmin(curve().forces(work)[1])) + 1]
    assert inside
    assert found == pytest.approx(-np.trapezoid(pulls, -gaps[: pulls.size]))
    assert 0 < found < work


def test_a_curve_in_other_units_is_the_same_curve() -> None:
    work = 2 * float(curve().at([0.01]).thresholds()[0])
    plain, other = MapCurve(curve(), 1.0, 1.0, 1.0), MapCurve(curve(), 2e9, 3.0, 1e-9)
    one, same = plain.at_work(work, 1e-4), other.at_work(3.0 * work, 2e5)
    assert one is not None
    assert same is not None
    assert same.pull_off.pressure == pytest.approx(2e9 * one.pull_off.pressure)
    assert one.loaded is not None
    assert same.loaded is not None
    assert one.alone is not None
    assert same.loaded.area == pytest.approx(one.loaded.area)
    assert one.loaded.area > one.alone.area
    assert same.loaded.gap == pytest.approx(1e-9 * one.loaded.gap)
    assert one.loaded.gap < one.alone.gap


def test_nothing_is_said_where_the_series_leaves_the_reach_of_the_attraction() -> None:
    """Slow approach touches nothing at a mean gap that the attraction does not bridge, as on solids as soft as PDMS."""
    work = 2 * float(curve().at([0.01]).thresholds()[0])
    known = {}
    for more in (1.0, 1e4):  # times the displacement by the attraction, as of a softer body
        found = MapCurve(replace(curve(), withdrawal=more * np.abs(curve().withdrawal)), 1.0, 1.0, 1.0)
        known[more] = found.at_work(work)
        assert (known[more] is None) is bool(found.pull_off(work).gap > curve().gaps_apart.max())
        unloaded = found.at_pressure(work, 0.0)
        assert unloaded is None or unloaded.gap <= curve().gaps_apart.max()
    assert known[1.0] is not None
    assert known[1e4] is None


def test_pull_off_and_area_change_with_the_heights_as_their_derivatives_say() -> None:
    """Of a surface 2 % rougher, of which all states are made anew."""
    contact, states = series()
    work, step = 2 * float(curve().at([0.01]).thresholds()[0]), 0.02
    found = MapCurve(curve(), 1.0, 1.0, 1.0, 1, states, wall(1e-6))
    pressure = float(curve().at([0.05]).loads(work)[0])

    def numbers(scale: float) -> np.ndarray:
        rougher = c.Contact(scale * contact.heights, HardWall(), tolerance=1e-5)
        problem, settings = rougher.problem, rougher.settings
        first = find_area(problem, 0.01, settings, Search(0.03), (), "start", solver_of(problem, settings)).require()
        there = MapCurve(press_series(problem, first, settings, CORE).curve(wall(1e-6)), 1.0, 1.0, 1.0)
        loaded = there.at_pressure(work, pressure)
        assert loaded is not None
        return np.array([-there.pull_off(work).pressure, loaded.area])

    heights = contact.problem.heights - contact.problem.heights.mean()
    derivatives = [found.pull_off_by_heights(work), found.area_by_heights(work, pressure)]
    said = [float((one * heights).sum()) for one in derivatives]
    solved = (numbers(1 + step) - numbers(1 - step)) / (2 * step)
    # The acting part of the work is kept, which the heights change by x of some 0.1; areas are counts of points.
    assert said == pytest.approx(solved, rel=0.15)
    assert all(abs(one.sum()) < 1e-3 * np.abs(one).sum() for one in derivatives)


def test_outside_of_its_range_a_pull_off_stress_is_a_lower_bound() -> None:
    """Far above the threshold the gaps move by much of the range; a few patches, and the end of the curve."""
    found = MapCurve(curve(), 1.0, 1.0, 1.0)
    work = float(curve().at([0.01]).thresholds()[0])
    assert found.pull_off(1.5 * work).doubt == ""
    assert found.pull_off(50 * work).doubt != ""
    assert "patches touch" in MapCurve(curve(), 1.0, 1.0, 1.0, own=100).pull_off(1.5 * work).doubt
    assert found.at_pressure(work, 10.0) is None
