"""The contact's own step: Newton's step for a stiff contact, on both back ends, and when it is made."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline, Wall, attraction_on_core
from continuum.path.loading import solve
from continuum.path.state import PathState
from continuum.solve import contact
from continuum.solve.arrays.contact import ArrayContact as NumPyContact
from continuum.solve.backend import back_end
from continuum.solve.conjugate import Line
from continuum.solve.grids import SmoothGrid
from continuum.solve.solution import Settings, Status

CORE = attraction_on_core("exponential", 0.0004, 0.8, 5.0)
"""Stiffer than the stiffest wave of a grid of spacing a0, 2.2 E*/a0."""
LAW = CORE.law
GAP = 0.27


def problem(n: int, wall: Wall) -> ContactProblem:
    grid = Grid((n, n + 32), (n, n + 32.0))
    heights = SelfAffine(0.6, 0.1, 8.0, 64.0).synthesise(grid, np.random.default_rng(2))
    return ContactProblem(grid, wall, heights * (0.125 / heights.std()), HalfSpace("clamped"))


def pressed(n: int, wall: Wall, device: str = "cpu", gap: float = GAP) -> PathState:
    return solve(problem(n, wall), "mean-gap", gap, Settings(1e-7, device=device))


@pytest.fixture(params=["cpu", "numpy"])
def grid(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> SmoothGrid:
    """A small grid of either back end on which a wall presses a flat surface's summits."""
    monkeypatch.setattr(back_end(request.param), "PRECISION", np.float64 if request.param == "cpu" else "float64")
    monkeypatch.setattr(back_end(request.param), "SMALLEST", 8)
    of = Grid((20, 24), (20.0, 24.0))
    K = ContactProblem(of, CORE, HEIGHTS, HalfSpace("clamped")).stiffness_q
    made = back_end(request.param).smooth_grid(of, K, 1, 1, sampled=False)
    assert LAW is not None
    made.set_problem(LAW, HEIGHTS, None, lift=0.4, pressure=0.0, mean_stiffness=np.inf)
    made.go_to_zero()
    return made


HEIGHTS: Real = np.random.default_rng(3).standard_normal((20, 24))


def test_it_is_newtons_step_for_the_stiff_points(grid: SmoothGrid, monkeypatch: pytest.MonkeyPatch) -> None:
    """(K + D) s = g, solved densely with D on the contact alone: what is missing there is left by no other term."""
    monkeypatch.setattr(contact, "REDUCTION", 1e-12)
    monkeypatch.setattr(contact, "DIRECTIONS", 200)
    of = Grid((20, 24), (20.0, 24.0))
    K_q = ContactProblem(of, CORE, HEIGHTS, HalfSpace("clamped")).stiffness_q.copy()
    K_q[0, 0] = 0.0
    points = np.eye(of.size).reshape(-1, *of.shape)
    K = np.array([of.inverse(K_q * of.forward(each)).ravel() for each in points])
    offset = HEIGHTS + 0.4
    stiffness = CORE.evaluate(offset).stiffness
    stiff = np.where(stiffness > contact.STIFF * K_q.max(), stiffness, 0.0)
    g = CORE.evaluate(offset).traction
    g = (g - g.mean()).ravel()
    mean = np.ones((1, of.size))
    s = np.linalg.solve(np.block([[K + np.diag(stiff.ravel()), mean.T], [mean, np.zeros((1, 1))]]), np.append(g, 0.0))

    own = grid.contact
    assert own is not None
    share, mean_stiffness = own.find(contact.STIFF, contact.FELT)
    assert share == np.count_nonzero(stiffness > contact.FELT * K_q.max()) / of.size
    assert mean_stiffness == pytest.approx(stiff[stiff > 0].mean() / K_q.max(), rel=1e-6)
    residual = own.gradient(0.0, complete=False)
    assert residual == pytest.approx(float(np.sqrt(np.mean(g**2))), rel=1e-12)
    line = contact._direction(own, Line(), 0.0)
    curvature = own.new_direction(line.beta)
    # Rounding, magnified by K of the softest wave over that of the stiffest; the stiffness is in single precision.
    assert line.slope == pytest.approx(-float(np.mean(g * s[:-1])), rel=1e-6)
    assert line.curvature == pytest.approx(float(s[:-1] @ K @ s[:-1]) / of.size, rel=1e-6)
    assert curvature == pytest.approx(float(np.mean(stiffness.ravel() * s[:-1] ** 2)), rel=1e-6)


def test_both_back_ends_take_the_same_steps_to_the_same_state(monkeypatch: pytest.MonkeyPatch) -> None:
    for device, kind in (("cpu", np.float64), ("numpy", "float64")):
        monkeypatch.setattr(back_end(device), "PRECISION", kind)
        monkeypatch.setattr(back_end(device), "SMALLEST", 32)
    compiled, plain = pressed(64, CORE), pressed(64, CORE, "numpy")
    assert compiled.status is plain.status is Status.CONVERGED
    assert compiled.solution.iterations == plain.solution.iterations
    np.testing.assert_allclose(plain.gap, compiled.gap, atol=1e-10)  # rounding grows from 1e-15 in a solve
    assert compiled.mean_gap == pytest.approx(GAP, abs=1e-13)


def test_a_stiff_wall_takes_fewer_pairs_to_the_same_state(monkeypatch: pytest.MonkeyPatch) -> None:
    own = pressed(256, CORE)
    monkeypatch.setattr(contact, "STIFFEST", np.inf)
    other = pressed(256, CORE)
    assert own.solution.fft_pairs < 0.6 * other.solution.fft_pairs
    np.testing.assert_array_equal(own.gap < 0, other.gap < 0)
    # Two states of this residual: a long wave of it, K = 0.01, is 1e-5 a0; the load is that of the stiff contact.
    assert np.abs(own.gap - other.gap).max() < 1e-5
    assert own.load == pytest.approx(other.load, rel=1e-5)


def test_a_soft_wall_and_a_mean_that_is_free_are_left_to_coarser_grids(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*given: object, **named: object) -> None:
        raise AssertionError

    monkeypatch.setattr(contact, "_direction", never)
    assert pressed(160, LennardJonesSpline(adhesion_length=0.0005), gap=1.2).status is Status.CONVERGED
    free = ContactProblem(problem(160, CORE).grid, CORE, problem(160, CORE).heights, HalfSpace("free"))
    assert solve(free, "mean-pressure", 1e-3, Settings(1e-6)).status is Status.CONVERGED


@pytest.mark.parametrize(
    ("share", "stiffness", "depth", "made"),
    [
        (0.05, 2.0, 0, True), (0.0, 0.0, 0, False), (0.2, 2.0, 0, False), (0.05, 1.0, 0, False),
        (0.05, 4.0, 1, True), (0.05, 2.0, 1, False),
    ],
)  # fmt: skip
def test_it_is_made_for_little_contact_with_a_wall_that_is_stiff_for_the_finest_grid(
    share: float, stiffness: float, depth: int, made: bool
) -> None:
    class Found(NumPyContact):
        def __init__(self) -> None:
            pass

        def find(self, stiff: float, felt: float) -> tuple[float, float]:
            return share, stiffness

    assert contact.pays(Found(), depth) is made


def test_steps_that_stall_end() -> None:
    fast, slow = ([part**i for i in range(contact.PATIENCE + 1)] for part in (0.8, 0.95))
    assert not contact._slow(fast)
    assert not contact._slow(slow[1:])
    assert contact._slow(slow)
    assert contact._slow([*slow[1:], np.nan])
