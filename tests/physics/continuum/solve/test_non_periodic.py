"""Surfaces without periodic images: influence coefficients, contacts with known answers, and no trace of the grid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.measure.certificate import check_state
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.substrates.non_periodic import FAR, OpenBoundary, cell_influence
from continuum.model.walls import Wall
from continuum.path.loading import solve
from continuum.solve.non_periodic import FARTHER, UNFELT, NonPeriodicSolver, _reach
from continuum.solve.solution import Settings, Solution, Status
from continuum.theory.smooth import DMT, Hertz, MaugisDugdale

OPEN = c.NonPeriodicHalfSpace()


def sphere(n: int, radius: float) -> np.ndarray:
    x = np.arange(n) - (n - 1) / 2
    return np.asarray((x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius))


def influence(x: float, y: float, spacing: tuple[float, float]) -> float:
    return float(cell_influence(np.array([x]), np.array([y]), spacing)[0])


# --- what a cell does ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.0), (0.0, -3.0), (2.0, 6.0)])
def test_the_influence_is_boussinesqs_integrated_over_the_cell(x: float, y: float) -> None:
    """A point load of one displaces by 1/(π E* r): Johnson 1985, Eq. (3.22a)."""
    a, b = 0.5, 0.75
    found, error = dblquad(lambda t, s: 1 / (np.pi * np.hypot(x - s, y - t)), -a, a, -b, b)
    # The error that the quadrature says of itself.
    assert influence(x, y, (2 * a, 2 * b)) == pytest.approx(found, abs=10 * error)


def test_the_middle_of_a_square_sinks_by_the_known_number() -> None:
    """4 ln(1 + √2)/π times half the side: Johnson 1985, section 3.3."""
    assert influence(0.0, 0.0, (1.0, 1.0)) == pytest.approx(2 * np.log(1 + np.sqrt(2)) * 2 / np.pi, rel=1e-14)


def test_near_and_far_formulas_meet() -> None:
    """Beyond FAR the influence is that of moments: neither formula has lost more than 1e-11 there."""
    r, angle = FAR * np.array([1 - 1e-9, 1 + 1e-9]), np.linspace(0.01, 1.5, 20)
    inner, outer = (cell_influence(each * np.cos(angle), each * np.sin(angle), (1.0, 0.7)) for each in r)
    np.testing.assert_allclose(outer, inner, rtol=3e-9)  # they lie 2e-9 apart
    np.testing.assert_allclose(outer * r[1], inner * r[0], rtol=1e-11)


@pytest.mark.parametrize(("shape", "lengths"), [((5, 7), (5.0, 10.5)), ((2, 9), (2.0, 9.0)), ((8, 8), (8.0, 8.0))])
def test_displacements_are_the_sum_over_all_cells(shape: tuple[int, int], lengths: tuple[float, float]) -> None:
    grid = c.Grid(shape, lengths)
    boundary, traction = OpenBoundary(grid), np.random.default_rng(1).random(shape)
    x, y = np.broadcast_arrays(*grid.positions)
    summed = np.zeros(shape)
    for i, j in np.ndindex(shape):
        summed -= traction[i, j] * cell_influence(x - x[i, j], y - y[i, j], grid.spacing)
    # Rounding of some ten terms of order one.
    np.testing.assert_allclose(boundary.inside(boundary.displacement(traction)), summed, atol=1e-13)
    assert boundary.mean_displacement(traction) == pytest.approx(summed.mean(), rel=1e-13)
    assert boundary.elastic_energy(traction) == pytest.approx(-0.5 * np.mean(traction * summed), rel=1e-13)
    assert boundary.stiffness_q.min() > 0


# --- contacts with known answers -----------------------------------------------------------------------------


def test_hertz() -> None:
    """Load, depth and energy of a sphere under a hard wall, whichever of load and depth is given."""
    n, radius, load = 64, 150.0, 12.0
    contact = c.Contact(sphere(n, radius), c.HardWall(), OPEN)
    state = contact.press(pressure=load / n**2).require()
    a = Hertz(radius, load).contact_radius
    # The contact has 12 points across: errors of the cells at its edge, which shrink as (spacing/a)^(3/2) or faster.
    assert state.separation == pytest.approx(-(a**2) / radius, rel=2e-3)
    assert state.load * n**2 == pytest.approx(load, rel=1e-12)
    assert np.sqrt(state.area_rep * n**2 / np.pi) == pytest.approx(a, abs=0.5)
    boundary = contact.problem.open_boundary
    assert boundary is not None
    energy = boundary.elastic_energy(state.traction) * n**2
    assert energy == pytest.approx(8 / 15 * np.sqrt(radius) * (a**2 / radius) ** 2.5, rel=5e-3)
    back = contact.press(separation=state.separation).require()
    assert back.load == pytest.approx(state.load, rel=1e-5)  # both solved to 1e-6
    met = contact.press(area=state.area_rep).require()
    assert met.area_rep == pytest.approx(state.area_rep, rel=0.01)
    assert met.load == pytest.approx(state.load, rel=0.03)  # N ~ A^(3/2), the area to 1 %


def test_flat_punch() -> None:
    """N = 2 a E* δ, and a mean traction of half the central one, 2 p0: Johnson 1985, section 3.8."""
    n, a, depth = 64, 18.0, 0.5
    x = np.arange(n) - (n - 1) / 2
    heights = np.where(np.hypot(x[:, None], x[None, :]) < a, 0.0, 2.0)
    with pytest.warns(UserWarning, match="slope"):
        contact = c.Contact(heights, c.HardWall(), OPEN)
    state = contact.press(separation=-depth).require()
    assert state.load * n**2 == pytest.approx(2 * a * depth, rel=0.5 / a)  # the radius is known to half a point
    middle = state.traction[n // 2, n // 2]
    assert middle == pytest.approx(depth / (np.pi * a), rel=0.02)


@pytest.mark.parametrize("distance", [2.0, 1.0])
def test_a_sphere_pulls_off_as_maugis_says(distance: float) -> None:
    """A constant tension up to a distance, with ramps of a tenth of it: from DMT's 2 π R w towards JKR's 3/2."""
    n, radius, work = 64, 150.0, 0.04
    tension, ends = work / distance, (0.9 * distance, 1.1 * distance)
    # Far steeper than the tension over its distance: hard.
    parts = (-0.5, 0, 9), (0, 0.1 * distance, 9), (0.1 * distance, ends[0], 17), (*ends, 17), (ends[1], 2 * ends[1], 17)
    gap = np.unique(np.concatenate([np.linspace(*part) for part in parts]).round(12))
    near, far = np.clip(gap / (0.02 * distance), 0, 1), np.clip((ends[1] - gap) / (ends[1] - ends[0]), 0, 1)
    wall = c.TabulatedWall(gap, np.where(gap < 0, -5 * gap, 0) - tension * near * far)
    expected = MaugisDugdale(radius, wall.work_of_adhesion, wall.work_of_adhesion / tension)
    contact = c.Contact(sphere(n, radius), wall, OPEN)
    path = contact.path(separation=np.linspace(-0.2, 1.6, 19).tolist())
    assert all(state.converged for state in path)
    pulled = -min(state.load for state in path) * n**2
    # What the ramps change of the law, and the contact has some 14 points across.
    assert pulled == pytest.approx(expected.pull_off_force, rel=0.02)
    assert pulled < DMT(radius, wall.work_of_adhesion).pull_off_force


# --- nothing is repeated -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "wall",
    [c.HardWall(), c.LennardJonesSpline(adhesion_length=0.01), c.InversePowers((9, 3), adhesion_length=0.01)],
    ids=["hard", "spline", "powers"],
)
def test_the_window_leaves_no_trace(wall: Wall) -> None:
    """The same rough wall in a larger window, far away beside it and not in the middle: the same contact."""
    n, settings = 24, Settings(1e-9)
    small = sphere(n, 40.0) + c.SelfAffine(0.8, 0.1, 6, 24).synthesise(c.Grid.square(n), np.random.default_rng(1))
    large = np.full((40, 43), 1e4)
    large[3 : 3 + n, 11 : 11 + n] = small
    depth = wall.zero_gap - float(small.min()) - 0.4
    one, other = (
        solve(ContactProblem(c.Grid(h.shape, h.shape), wall, h, OPEN), "separation", depth, settings).require()
        for h in (small, large)
    )
    assert one.area_rep > 0.01
    # Single points miss their traction by more than the root-mean-square over all, sqrt(1720) times at most.
    np.testing.assert_allclose(other.traction[3 : 3 + n, 11 : 11 + n], one.traction, atol=42 * settings.tolerance)
    problem = ContactProblem(c.Grid.square(n), wall, small, OPEN)
    start = None if wall.law is None else one.gap
    loaded = solve(problem, "mean-pressure", one.load, settings, start).require()
    assert loaded.separation == pytest.approx(
        depth, abs=1e-6
    )  # 1e-9 E* over the stiffness of a contact, E* times its radius
    np.testing.assert_allclose(loaded.traction, one.traction, atol=42 * settings.tolerance)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_slope_has_no_step_at_the_edge(axis: int) -> None:
    """Moments are those of the surface with its mirror images: of a roof, whose ridge and valley alone are sharp."""
    ramp = 0.1 * np.arange(64.0)
    heights = np.repeat(ramp[:, None], 48, axis=1) if axis == 0 else np.repeat(ramp[None, :], 48, axis=0)
    problem = ContactProblem(c.Grid(heights.shape, heights.shape), c.HardWall(), heights, OPEN)
    assert problem.moments.rms_slope == pytest.approx(0.1, rel=0.02)


def test_states_are_minima_and_certified() -> None:
    contact = c.Contact(sphere(32, 80.0), c.LennardJonesSpline(adhesion_length=0.02), OPEN)
    path = contact.path(separation=[2.0, 1.2, 0.8])
    state = path[-1].require()
    found = state.stability()
    assert found.eigenvalue > 0
    assert found.mode.shape == (32, 32)
    check = check_state(contact.problem, state.gap, rounded=False, mean_stiffness=None)
    assert check.residual <= 1.5 * contact.settings.tolerance  # as for runs: differences see kinks of the law
    assert np.mean(check.maps["repulsive"][0]) == state.area_rep
    for name in ("load", "mean_gap"):
        value, error = check.numbers[name]
        assert value == pytest.approx(getattr(state, name), abs=error)
    # What is left of the tractions sinks the surface by so much of its mean.
    boundary = contact.problem.open_boundary
    assert boundary is not None
    sunk = 1.5 * contact.settings.tolerance / boundary.mean_stiffness
    assert check.numbers["separation"].value == pytest.approx(state.separation, abs=sunk)
    assert check.lowest is not None
    assert check.lowest.value > check.lowest.error
    forged = state.gap + 1e-3 * np.random.default_rng(1).normal(size=state.gap.shape)
    assert check_state(contact.problem, forged, rounded=False).residual > 100 * contact.settings.tolerance


def test_the_wall_beside_a_window_is_taken_away_until_it_does_not_act() -> None:
    """Beside a surface that stands 100 a0 high: four times farther each time, and no farther than it takes."""
    boundary, distances = OpenBoundary(c.Grid.square(4)), list[float]()
    solver, reach, height = NonPeriodicSolver(boundary), 2.5, 100.0

    def solved(around: Real) -> Solution:
        distances.append(float(around[-1, -1]))
        np.testing.assert_array_equal(boundary.inside(around), 0.5)
        return Solution(around - height, Status.CONVERGED, 1e-7, 3)

    found = solver._unfelt(np.full((4, 4), 0.5), 0.2, reach, solved)
    np.testing.assert_allclose(distances, distances[0] * FARTHER ** np.arange(len(distances)))
    assert 0.5 + reach < distances[0] < distances[-2] < height + reach < distances[-1]
    np.testing.assert_array_equal(found.gap, 0.5 - height)
    assert found.residual == 2e-7  # as if all of it were in the window


# --- what there is not ---------------------------------------------------------------------------------------


def test_no_mean_gap_and_no_threshold() -> None:
    contact = c.Contact(sphere(16, 40.0), c.LennardJonesSpline(adhesion_length=0.01), OPEN)
    with pytest.raises(ArgumentError, match=r"mean-gap = 2.0: .*another control"):
        contact.press(mean_gap=2.0)
    with pytest.raises(ArgumentError, match=r"substrate = .*a periodic one"):
        contact.find_threshold(lambda work: c.attraction_on_core("spline", work, 0.4, 5.0))


def test_a_run_of_the_input(tmp_path: Path) -> None:
    """The input of the manual, to be restarted and certified."""
    result = c.run("inputs/smoke/sphere.toml", tmp_path / "sphere.h5")
    assert all(point.converged for point in result.points)
    assert c.certify(tmp_path / "sphere.h5").ok


@pytest.mark.parametrize("wall", [c.InversePowers((9, 3), adhesion_length=0.005), c.Exponential(0.005, 0.3, 2.0)])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_a_law_that_never_ends_is_felt_up_to_its_reach(wall: Wall, tolerance: float) -> None:
    """Known to a step of 11 per cent; a weaker one nowhere, and one that ends up to its end."""
    reach = _reach(wall.law, tolerance)
    gap = reach * np.array([1 / 1.12, 1.0, 1.5, 1e3])
    felt = np.abs(wall.evaluate(gap).traction) > UNFELT * tolerance
    np.testing.assert_array_equal(felt, [True, False, False, False])
    assert _reach(c.LennardJonesSpline(0.3).law, tolerance) == 1.3
    assert _reach(c.Exponential(1e-30, 0.3, 2.0).law, tolerance) == 1e-6
