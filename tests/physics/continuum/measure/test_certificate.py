"""What a gap says of its state: the sums of the problem, dense algebra, and states under a bound that are made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from continuum.measure.certificate import NO_TRACTION, Check, Examination, check_state, minimum
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, NonPeriodicHalfSpace, Substrate
from continuum.model.walls import Exponential, HardWall

LAW = Exponential(surface_energy=0.01, decay_length=0.4, core_stiffness=2.0)
SUBSTRATES = [HalfSpace("clamped"), HalfSpace("free"), HalfSpace(0.07), NonPeriodicHalfSpace()]


def at(substrate: Substrate, seed: int, shape: tuple[int, int] = (8, 6)) -> tuple[ContactProblem, Real]:
    """A problem of any heights at any gap: no equilibrium."""
    random = np.random.default_rng(seed)
    grid = Grid(shape, (1.3 * shape[0], 0.9 * shape[1]))
    heights, gap = random.normal(scale=0.1, size=shape), random.uniform(-0.2, 1.5, shape)
    return ContactProblem(grid, LAW, heights, substrate), gap


@pytest.mark.parametrize("substrate", SUBSTRATES, ids=["clamped", "free", "spring", "open"])
@given(st.integers(0, 2**32))
@settings(max_examples=5)
def test_numbers_of_any_gap_are_those_of_the_problem(substrate: Substrate, seed: int) -> None:
    problem, gap = at(substrate, seed)
    found, grid = check_state(problem, gap, rounded=False), problem.grid
    response = problem.wall.evaluate(gap)
    t, boundary = response.traction, problem.open_boundary
    separation = problem.separation(grid.mean(gap), grid.mean(t), lambda: t)
    energy = problem.elastic_energy(gap) if boundary is None else boundary.elastic_energy(t)
    expected = {
        "load": t.mean(), "load_rep": t[t > 0].sum() / t.size, "load_att": -t[t < 0].sum() / t.size,
        "wall_energy": response.energy.mean(), "mean_gap": gap.mean(), "smallest_gap": gap.min(),
        "elastic_energy": energy, "separation": separation,
    }  # fmt: skip
    if np.isnan(separation):
        del expected["separation"]
    values = {name: value.value for name, value in found.numbers.items() if name != "lowest_eigenvalue"}
    assert values == pytest.approx(expected, rel=1e-9, abs=1e-11)
    # Of gaps in single precision, and a spring of 0.07.
    assert max(value.error for name, value in found.numbers.items() if name != "lowest_eigenvalue") < 1e-5
    assert found.rounding == 0.0
    repulsive = gap < LAW.zero_gap
    np.testing.assert_array_equal(found.maps["repulsive"][0], repulsive)
    np.testing.assert_array_equal(found.maps["attracted"][0], ~repulsive & (gap < LAW.zero_gap + LAW.range))
    # The force on the displacement; in a window that of the half-space below it, which its tractions do not balance.
    if boundary is None:
        left = problem.gradient(problem.displacement(gap, 0.0), 0.0)
        left = left - left.mean()
    else:
        wide, off = boundary.grid, problem.heights - gap - boundary.inside(boundary.displacement(t))
        stiff = boundary.stiffness_q * wide.forward(boundary.around(off - off.mean(), 0.0))
        stiff[0, 0] = 0.0
        left = 2 * wide.inverse(stiff)
    assert found.residual == pytest.approx(np.sqrt(np.mean(left**2)), rel=1e-9)


@given(st.integers(0, 2**32))
@settings(max_examples=5)
def test_rounding_to_single_precision_is_bounded_and_not_by_far(seed: int) -> None:
    problem, gap = at(HalfSpace(0.07), seed, (32, 24))
    single = np.float64(np.float32(gap))
    before, after = (check_state(problem, one, rounded=one is single) for one in (gap, single))
    for name, (value, error) in after.numbers.items():
        if name != "lowest_eigenvalue":
            assert abs(value - before.numbers[name].value) <= error, name
    # Half of a unit in the last of 24 digits.
    assert after.numbers["mean_gap"].error == pytest.approx(2**-24 * np.abs(gap).mean(), rel=1e-4)
    steep = np.abs(problem.wall.evaluate(gap).stiffness * gap).mean()
    assert after.numbers["load"].error == pytest.approx(2**-24 * steep, rel=0.05)
    assert after.numbers["smallest_gap"].error == pytest.approx(
        2**-24 * np.abs(gap).max(where=gap == gap.min(), initial=0)
    )
    stiffness_q = problem.stiffness_q.copy()
    stiffness_q[0, 0] = 0.0
    traction = problem.grid.inverse(stiffness_q * problem.grid.forward(single - gap))
    # Gaps from 1 to 2 are rounded alike: the bound is right for the largest of them.
    assert 0.9 < after.rounding / np.sqrt(np.mean(traction**2)) < 1.8


@pytest.mark.parametrize("substrate", SUBSTRATES[:3], ids=["clamped", "free", "spring"])
@pytest.mark.parametrize("mean", [np.inf, 0.0, 0.02])
def test_the_lowest_eigenvalue_is_that_of_dense_algebra(substrate: Substrate, mean: float) -> None:
    problem, gap = at(substrate, 7)
    found = check_state(problem, gap, rounded=False, mean_stiffness=mean).lowest
    assert found is not None
    grid, stiffness_q = problem.grid, problem.stiffness_q.copy()
    stiffness_q[0, 0] = 1e3 if np.isinf(mean) else mean
    waves = [grid.inverse(stiffness_q * grid.forward(v.reshape(grid.shape))).ravel() for v in np.eye(grid.size)]
    hessian = np.array(waves) + np.diag(problem.wall.evaluate(gap).stiffness.ravel())
    if np.isinf(mean):
        flat = np.full(hessian.shape, 1 / grid.size)
        rest = np.eye(grid.size) - flat
        hessian = rest @ hessian @ rest + 1e3 * flat
    exact = scipy.linalg.eigvalsh((hessian + hessian.T) / 2)[0]
    assert abs(found.value - exact) <= found.error < 1e-2


def test_beside_a_window_no_wall_softens() -> None:
    """Where the core pushes everywhere, no displacement within or around the window lowers the energy."""
    problem, gap = at(NonPeriodicHalfSpace(), 7)
    found = check_state(problem, -np.abs(gap), rounded=False, mean_stiffness=None).lowest
    assert found is not None
    assert found.value > 0


@pytest.mark.parametrize(("lowest", "sound"), [(-1e-3, False), (0.0, True), (1e-3, True), (np.nan, False)])
def test_a_minimum_has_no_negative_eigenvalue(lowest: float, sound: bool) -> None:
    assert minimum(lowest).ok == sound


def under_a_bound(
    substrate: Substrate, hardness: float, seed: int, share: float
) -> tuple[ContactProblem, Real, Real, tuple[Real, Real]]:
    """An equilibrium that is made: pressures and gaps of which one vanishes, and the heights that belong to them."""
    random, grid = np.random.default_rng(seed), Grid((8, 6), (10.4, 5.4))
    touching = random.random(grid.shape) < share
    touching.flat[:2] = True
    touching.flat[-1] = False
    pressure = np.where(touching, random.uniform(0.01, 0.1, grid.shape), 0.0)
    gap = np.where(touching, 0.0, random.uniform(0.01, 1.0, grid.shape))
    if np.isfinite(hardness):
        pressure.flat[0], gap.flat[0] = hardness, -0.3
    response = substrate.stiffness(grid)
    u_q = -grid.forward(pressure) / np.where(response > 0, response, np.inf)
    u = grid.inverse(u_q)
    return ContactProblem(grid, HardWall(hardness), gap + u, substrate), gap, pressure, (u, touching)


@pytest.mark.parametrize("hardness", [np.inf, 0.2])
@pytest.mark.parametrize("substrate", SUBSTRATES[:3], ids=["clamped", "free", "spring"])
@given(st.integers(0, 2**32), st.floats(0.1, 0.9))
@settings(max_examples=5)
def test_a_state_under_a_bound_is_sound_and_what_breaks_it_is_its_residual(
    substrate: Substrate, hardness: float, seed: int, share: float
) -> None:
    problem, gap, pressure, (u, touching) = under_a_bound(substrate, hardness, seed, share)
    found = check_state(problem, gap, rounded=False)
    assert found.residual < 1e-14
    assert found.lowest is None
    load = pressure.mean()
    elastic = -np.mean(u * (pressure - load)) / 2
    expected = {"load": load, "load_rep": load, "load_att": 0.0, "mean_gap": gap.mean(), "smallest_gap": gap.min(),
                "elastic_energy": elastic, "wall_energy": problem.wall.energy(gap).mean()}  # fmt: skip
    k = problem.mean_stiffness
    if k > 0:
        expected["separation"] = -u.mean() - (0.0 if np.isinf(k) else load / k)
    assert {name: value.value for name, value in found.numbers.items()} == pytest.approx(expected, abs=1e-12)
    assert found.numbers["load"].error < 1e-11
    # A wall that knows no energy has none that is rounded.
    assert found.numbers["wall_energy"].error <= 1e-12 * abs(found.numbers["wall_energy"].value)
    assert all(value.error >= 0 for value in found.numbers.values())
    np.testing.assert_array_equal(found.maps["repulsive"][0], touching)
    assert not found.maps["attracted"][0].any()
    if np.isinf(hardness):
        # An overlap of one point, and what it adds to the pressures there and around it.
        deeper = gap.copy()
        deeper.flat[1] = -0.01
        assert check_state(problem, deeper, rounded=False).residual > 0.01 / np.sqrt(gap.size)
        # A tension of one point, on a wall that is lower there by what that pulls.
        pulled = pressure.copy()
        pulled.flat[1] = -0.05
        stiff = substrate.stiffness(problem.grid)
        down = problem.grid.inverse(-problem.grid.forward(pulled) / np.where(stiff > 0, stiff, np.inf))
        broken = check_state(replace(problem, heights=gap + down), gap, rounded=False)
        assert broken.residual == pytest.approx(0.05 / np.sqrt(gap.size), rel=1e-9)
        # Off the contact, where the pressure is known to vanish, it may be off by what is missing everywhere.
        error = broken.residual * np.sqrt(gap.size / np.count_nonzero(~touching))
        assert broken.numbers["load"].error == pytest.approx(error, rel=1e-9)
    else:
        # A pressure above the hardness, by as much.
        softer = replace(problem, wall=HardWall(0.05))
        assert check_state(softer, gap, rounded=False).residual > 0.01


def test_full_contact_holds_no_tension_and_knows_no_load() -> None:
    grid = Grid((8, 6), (8.0, 6.0))
    problem = ContactProblem(grid, HardWall(), np.random.default_rng(1).normal(size=grid.shape), HalfSpace())
    found = check_state(problem, np.zeros(grid.shape), rounded=False)
    assert found.residual < 1e-14
    assert "load" not in found.numbers
    assert found.numbers["separation"].value == pytest.approx(-problem.mean_height)


def test_a_window_under_a_hard_wall_is_refused() -> None:
    problem, gap = at(NonPeriodicHalfSpace(), 1)
    with pytest.raises(ValueError, match=NO_TRACTION):
        check_state(replace(problem, wall=HardWall()), gap, rounded=False)


def test_what_is_off_by_more_than_allowed_is_a_fault_and_nan_is() -> None:
    checks = [Check("load", 1.0, 1.5, off, 0.5) for off in (0.5, np.nextafter(0.5, 1), np.nan)]
    assert [check.ok for check in checks] == [True, False, False]
    examined = Examination(checks=tuple(checks))
    assert len(examined.faults) == 2
    assert examined.found_of("load") == 1.5
    assert examined.found_of("mean_gap") is None
