"""Hard walls that yield at a largest pressure: the conditions of the minimum, limits, and the imprint that is left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.reading import load
from continuum.measure.certificate import check_state
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.loading import solve
from continuum.solve.backend import most_work
from continuum.solve.solution import Settings
from continuum.store.runs.config import RunConfig
from continuum.store.runs.run import follow_run
from continuum.theory.smooth import Hertz


def rough(n: int = 64, seed: int = 1) -> Real:
    return c.SelfAffine(0.8, 0.1, 8, n / 2).synthesise(c.Grid.square(n), np.random.default_rng(seed))


def elastic(heights: Real, gap: Real) -> Real:
    """Traction that holds a gap, without its mean, by numpy's transforms."""
    q = [2 * np.pi * np.fft.fftfreq(n) for n in heights.shape]
    K = np.hypot(q[0][:, None], q[1][None, :]) / 2
    return np.asarray(-np.fft.ifft2(K * np.fft.fft2(heights - gap)).real)


def assert_minimum(heights: Real, gap: Real, p: Real, hardness: float, tolerance: float) -> None:
    """No pressure, and a gap; or pressure below the hardness, and none; or the hardness, and an overlap."""
    free, yields = p == 0, p >= hardness
    assert p.min() >= 0
    assert p.max() <= hardness
    assert (gap[free] > 0).all()
    assert (gap[~free & ~yields] == 0).all()
    assert (gap[yields] <= 0).all()
    missed = p - p.mean() - elastic(heights, gap)
    assert np.sqrt(np.mean(missed**2)) <= 1.01 * tolerance  # and rounding


# --- one state ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [0.02, 0.3, 0.8, 0.98, 0.999])
@pytest.mark.parametrize("hardness", [0.1, 0.02])
def test_conditions_of_the_minimum_up_to_full_contact(part: float, hardness: float) -> None:
    heights = rough()
    contact = c.Contact(heights, c.HardWall(hardness))
    state = contact.press(pressure=part * hardness).require()
    assert state.load == pytest.approx(part * hardness, rel=1e-9)
    assert_minimum(heights, state.gap, state.traction, hardness, contact.settings.tolerance)
    check = check_state(contact.problem, state.gap, rounded=False)
    assert check.residual <= 1.5 * contact.settings.tolerance
    assert np.mean(check.maps["repulsive"][0]) == state.area_rep


@given(
    seed=st.integers(0, 2**32 - 1), shape=st.tuples(st.integers(3, 14), st.integers(3, 14)),
    part=st.floats(0.01, 0.99), hardness=st.floats(1e-3, 10),
)  # fmt: skip
def test_any_small_surface(seed: int, shape: tuple[int, int], part: float, hardness: float) -> None:
    heights = np.random.default_rng(seed).normal(size=shape)
    settings = Settings(1e-9 * min(hardness, 1.0))
    problem = ContactProblem(c.Grid(shape, shape), c.HardWall(hardness), heights, c.HalfSpace())
    found = solve(problem, "mean-pressure", part * hardness, settings).require()
    assert found.load == pytest.approx(part * hardness, rel=1e-9)
    assert_minimum(heights, found.gap, found.traction, hardness, settings.tolerance)


def test_dense_reference() -> None:
    """The quadratic program with bounds on both sides, as least squares of the root of the compliance."""
    shape, mean, hardness, separation = (9, 8), 0.05, 0.15, -0.2
    heights = np.random.default_rng(3).normal(size=shape)
    problem = ContactProblem(c.Grid(shape, shape), c.HardWall(hardness), heights, c.HalfSpace(mean))
    found = solve(problem, "separation", separation, Settings(1e-12)).require()
    G = np.array([
        problem.grid.inverse(problem.grid.forward(one.reshape(shape)) / problem.stiffness_q).ravel()
        for one in np.eye(heights.size)
    ])  # fmt: skip
    root = np.linalg.cholesky(G).T
    expected = lsq_linear(root, -np.linalg.solve(root.T, (separation + heights).ravel()), (0, hardness), tol=1e-14).x
    np.testing.assert_allclose(found.traction.ravel(), expected, atol=1e-7)  # the tolerance that lsq_linear reaches
    assert 3 < np.count_nonzero(found.traction == hardness) < 60


def test_a_great_hardness_is_none() -> None:
    heights = rough()
    hard, other = (c.Contact(heights, wall).press(pressure=0.01).require() for wall in (c.HardWall(), c.HardWall(10.0)))
    np.testing.assert_allclose(other.gap, hard.gap, rtol=0, atol=1e-13)  # pressures are scaled in another order
    assert other.area_rep == hard.area_rep
    assert not other.imprint.any()


def test_soft_bodies_touch_at_load_over_hardness() -> None:
    """Where all of the contact yields A = N/H (Bowden and Tabor 1950); the rim that does not adds to it."""
    heights, areas = rough(), []
    for hardness in (0.02, 0.005, 0.001):
        areas.append(c.Contact(heights, c.HardWall(hardness)).press(pressure=0.2 * hardness).require().area_rep / 0.2)
    assert areas[0] > areas[1] > areas[2] >= 1 - 1 / (0.2 * heights.size)
    assert areas[2] < 1.02  # points within the reach of an elastic rim of p/K, H/(E* q/2), over h'


def test_a_sphere_yields_when_hertz_says() -> None:
    """The largest pressure of Hertz is the hardness at N = π³ R² H³/(6 E*²)."""
    n, radius, hardness = 64, 150.0, 0.05
    load = np.pi**3 * radius**2 * hardness**3 / 6
    assert Hertz(radius, load).pressure(np.zeros(1))[0] == pytest.approx(hardness)
    x = np.arange(n) - (n - 1) / 2
    contact = c.Contact(
        (x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius), c.HardWall(hardness), c.NonPeriodicHalfSpace()
    )
    below, above = (contact.press(pressure=part * load / n**2).require() for part in (0.95, 1.05))
    assert not below.imprint.any()
    assert 0 < np.count_nonzero(above.imprint) < 0.5 * above.area_rep * n**2
    assert np.hypot(*np.argwhere(above.imprint > 0).T - (n - 1) / 2).max() < 0.5 * Hertz(radius, load).contact_radius


def test_the_work_is_least_where_the_gap_is() -> None:
    height = np.array([[0.0, 3.0], [1.0, 2.0]])
    assert most_work(height, 0.5, 1.0) == pytest.approx((0 + 1) / 4)
    assert most_work(height, 0.625, 1.0) == pytest.approx((0 + 1 + 0.5 * 2) / 4)
    assert most_work(height, 1.0, 1.0) == pytest.approx(6 / 4)


# --- paths -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("substrate", [c.HalfSpace(), c.HalfSpace(0.05), c.NonPeriodicHalfSpace()])
def test_unloading_is_elastic_and_the_imprint_stays(substrate: c.HalfSpace) -> None:
    contact = c.Contact(rough(48), c.HardWall(0.05), substrate)
    up, down = [0.005, 0.01, 0.02], [0.01, 0.002, 0.01, 0.02]
    states = [state.require() for state in contact.path(pressure=[*up, *down, 0.025])]
    depth = [state.imprint.mean() for state in states]
    assert 0 < depth[0] < depth[1] < depth[2] < depth[-1]
    for state in states[3:7]:
        np.testing.assert_allclose(
            state.imprint, states[2].imprint, atol=1e-5
        )  # residuals of 1e-6 over K of long waves
    # Back the same way: reversible, as far as states are solved.
    assert states[5].area_rep == pytest.approx(states[3].area_rep, abs=2 / 48**2)
    assert states[6].separation == pytest.approx(states[2].separation, abs=1e-4)
    # Loaded for the first time it touches less than after having been pressed harder.
    assert states[3].area_rep > 1.1 * states[1].area_rep
    again = contact.press(pressure=0.01, start=states[2]).require()
    np.testing.assert_array_equal(again.traction > 0, states[3].traction > 0)
    np.testing.assert_allclose(again.imprint, states[3].imprint, atol=1e-5)  # that of the state that it starts from


def test_areas_and_separations_lead_to_full_contact() -> None:
    contact = c.Contact(rough(48), c.HardWall(0.03))
    for state in contact.path(area=[0.1, 0.6, 0.95, 0.5]):
        state.require()
    path = contact.path(separation=[1.0, 0.0, -1.0, -3.0, -1.0])
    assert all(state.converged for state in path)
    assert path[3].area_rep == 1.0
    assert path[3].load == pytest.approx(0.03, rel=1e-9)
    assert path[4].load == 0.0  # flattened by three a0, it has left a wall that went back by two


def test_a_killed_run_keeps_its_imprint(tmp_path: Path) -> None:
    config = load("inputs/smoke/plastic.toml", RunConfig)
    whole = follow_run(config, tmp_path / "whole.h5")
    assert whole.converged
    seen = 0

    def stop(*_: object) -> None:
        nonlocal seen
        seen += 1
        if seen == 6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        follow_run(config, tmp_path / "part.h5", progress=stop)
    rest = follow_run(config, tmp_path / "part.h5")
    assert rest.resumed > 3
    assert [point.area_rep for point in rest.points] == [point.area_rep for point in whole.points]
    assert [point.separation for point in rest.points] == pytest.approx([point.separation for point in whole.points])
    assert c.certify(tmp_path / "part.h5").ok


def test_what_no_state_has_is_refused() -> None:
    contact = c.Contact(rough(16), c.HardWall(0.03))
    with pytest.raises(ArgumentError, match=r"mean-pressure = 0.03: .*below the hardness"):
        contact.press(pressure=0.03)
    with pytest.raises(ArgumentError, match=r"mean-gap = 1.0: .*where the wall yields"):
        contact.path(mean_gap=[1.0])
    with pytest.raises(ArgumentError, match="hardness = 0"):
        c.HardWall(0.0)
