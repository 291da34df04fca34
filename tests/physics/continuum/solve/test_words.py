"""Each word of the compiled grids, from a state that no solve comes to, beside the formulas of whole arrays.

A solve forgives: a direction that is off costs an iteration, an energy that is off costs nothing until it decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from scipy.special import expit

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.walls import LennardJonesSpline
from continuum.solve.arrays.bound_grid import ArrayBoundGrid
from continuum.solve.arrays.library import NumPy
from continuum.solve.arrays.smooth_grid import ArraySmoothGrid
from continuum.solve.compiled import passes, tractions
from continuum.solve.compiled.bound_grid import CompiledBoundGrid
from continuum.solve.compiled.smooth_grid import CompiledSmoothGrid
from continuum.solve.compiled.tractions import Pull
from continuum.solve.conjugate import COARSE_ITERATIONS, COARSE_REDUCTION, Line, conjugate_line
from continuum.solve.line_search import SLOPE_ACCEPTED, SLOPE_REDUCTION, take_step

GRID = Grid((40, 70), (40.0, 105.0))
"""Rows of more than one mark of contact; coarser grids of (20, 32) and (10, 16) points."""
LAW = LennardJonesSpline(0.3).law


@pytest.fixture(autouse=True)
def blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows and columns in two blocks, the first of which is not the whole of anything."""
    monkeypatch.setattr(passes, "block_edges", lambda length, points: [0, length // 3, length])


class Both:
    """A compiled grid and one of whole arrays, which are told the same."""

    def __init__(self, compiled: Any, plain: Any) -> None:
        self.compiled, self.plain = compiled, plain

    def field(self, name: str) -> tuple[Real, Real]:
        return getattr(self.compiled, name)[:, : self.plain.grid.shape[1]], getattr(self.plain, name)

    def put(self, **fields: Real) -> None:
        for name, values in fields.items():
            getattr(self.compiled, name)[:, : GRID.shape[1]] = values
            setattr(self.plain, name, values.copy())

    def say(
        self, word: str, *given: Any, look: Sequence[str] = (), asked: Sequence[int] | None = None, **named: Any
    ) -> Any:
        """The same answer, to rounding in sums of some thousand terms, and the same fields."""
        answer, other = (getattr(each, word)(*given, **named) for each in (self.compiled, self.plain))
        if answer is not None:
            one, other = (np.atleast_1d(each)[list(asked) if asked else ...] for each in (answer, other))
            scale = np.abs(np.asarray(other, dtype=float)).max(initial=1e-3)
            np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-12 * scale, err_msg=word)
        for name in look:
            here, there = self.field(name)
            np.testing.assert_allclose(here, there, rtol=1e-10, atol=1e-12, err_msg=f"{name} after {word}")
        return answer


@pytest.mark.parametrize(("most", "mean"), [(np.inf, 0.2), (0.8, 0.0), (np.inf, np.inf)])
def test_words_under_a_bound(most: float, mean: float) -> None:
    rng, K = np.random.default_rng(1), HalfSpace("free").stiffness(GRID)
    both = Both(CompiledBoundGrid(GRID, K, 1, 16), ArrayBoundGrid(NumPy(), GRID, K, 16))
    random, near = (rng.normal(size=(3, *GRID.shape)), np.zeros(GRID.shape, dtype=bool))
    near[3:20, 5:40] = rng.random((17, 35)) < 0.4  # columns beside them have nothing near by
    near[30, 66] = True
    both.say("set_problem", random[0], None, lift=0.3, sink=0.1, mean_stiffness=mean, most=most)
    assert {each.work[1:] for each in (both.compiled, both.plain)} == {(0.0, 0, 0.0)}
    pressure, gap = np.minimum(near * rng.random(GRID.shape), most), np.where(near, random[1], np.abs(random[1]) + 0.1)
    gap[10:12, 20:40] = -0.2
    both.put(p=pressure, z=gap, t=np.where(pressure > 0, random[2], 0.0), change=random[0] ** 2, m=random[1] ** 2)
    for level, step in ((0.05, 0.3), (-0.1, 0.02)):
        both.say("level")
        both.say("select", level, look=["mask", "m"])
        both.say("precondition", level, look=["s"])
        both.say("correct", 0.3, look=["s", "t"])
        both.say("new_direction", 0.7, 0.2, look=["t"])
        both.say("curvature")
        cut, before, after = both.say("trial", step)
        assert cut < 0 < after
        both.say("arrive", before, after) if before > 0 else both.say("arrive", 1.0, 1.0)
        both.say("accept", look=["p", "z", "change"])
        both.say("renew", look=["m"])
    # A step that is cut nowhere, also of what is not above zero: the gap follows the direction, not the pressure.
    both.say("select", -0.1, look=["mask"])
    both.say("precondition", -0.1)
    both.say("correct", 0.2)
    both.say("new_direction", 0.5, 0.1, look=["t"])
    both.say("curvature")
    both.say("trial", 1e-9)
    both.say("advance", 1e-3, look=["p", "z", "change"])
    both.say("level")
    both.say("scale", 0.9 * both.say("total"), look=["p"])
    both.say("displace", look=["z"])
    both.say("duality_gap")
    both.say("misses", 0.07)
    both.say("mean_offset")
    below = Both(*(each.set_coarser_problem() for each in (both.compiled, both.plain)))
    np.testing.assert_allclose(below.compiled.offset, below.plain.offset, atol=1e-14)
    coarse = rng.random(below.plain.p.shape)
    below.compiled.p[:, : coarse.shape[1]] = below.plain.p = coarse
    both.say("spread", look=["p"])
    for one, other in zip(*(each.hand_out(0.04) for each in (both.compiled, both.plain)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-14)


@pytest.mark.parametrize("pressure", [None, 0.05])
@pytest.mark.parametrize("most", [np.inf, 0.2])
def test_a_guess_is_the_traction_under_which_a_start_is_where_it_is(pressure: float | None, most: float) -> None:
    """Where it presses more than closing the gap there would take; of a start that lies off zero, too."""
    rng, K = np.random.default_rng(6), HalfSpace("free").stiffness(GRID)
    both = Both(CompiledBoundGrid(GRID, K, 1, 16), ArrayBoundGrid(NumPy(), GRID, K, 16))
    for level in (-0.3, 0.4):
        heights, start = rng.normal(size=(2, *GRID.shape)) * [[[0.1]], [[0.02]]]
        posed = {"lift": 0.3, "sink": 0.1, "mean_stiffness": np.inf if pressure is None else 0.0, "most": most}
        both.say("set_problem", heights, np.abs(start) + level, **posed)
        both.say("guess", pressure, look=["p"])
        assert 0.05 < np.count_nonzero(both.plain.p) / GRID.size < 0.95
        assert both.compiled.work.fft_pairs == both.plain.work.fft_pairs == 1.0


def test_where_the_preconditioner_gives_nothing_all_of_the_contact_counts_alike() -> None:
    rng, K = np.random.default_rng(5), np.zeros(GRID.shape_q)
    both = Both(CompiledBoundGrid(GRID, K, 1, 16), ArrayBoundGrid(NumPy(), GRID, K, 16))
    both.say("set_problem", np.ones(GRID.shape), None, lift=0.0, sink=0.0, mean_stiffness=np.inf, most=np.inf)
    both.put(p=1.0 * (rng.random(GRID.shape) < 0.1), z=np.ones(GRID.shape))
    both.say("select", 0.0, look=["mask"])
    both.say("renew", look=["m"])
    np.testing.assert_array_equal(both.plain.m, both.plain.p)


def spectra(both: Both, *names: str) -> None:
    """The same modes, which either grid holds as pairs of real numbers."""
    rows, columns = both.plain.grid.shape_q
    for name in names:
        here, there = getattr(both.compiled, name), getattr(both.plain, {"d": "d_q"}.get(name, name))
        np.testing.assert_allclose(
            here[:, : 2 * columns].reshape(rows, columns, 2), there, rtol=1e-9, atol=1e-12, err_msg=name
        )


@pytest.mark.parametrize(("mean", "levels"), [(0.2, 0), (np.inf, 1), (0.2, 2)])
def test_words_of_a_smooth_energy(mean: float, levels: int) -> None:
    """With so many coarser grids, whose step the gradient's own replaces in every second iteration."""
    rng, K, coarse = np.random.default_rng(2), HalfSpace("free").stiffness(GRID), levels > 0
    both = Both(
        CompiledSmoothGrid(GRID, K, 1, 16, np.float64, 2),
        ArraySmoothGrid(NumPy(), GRID, K, 16, "float64", 2, sampled=False),
    )
    linear = Both(both.compiled.linear, both.plain.linear)
    offset, start = 0.3 * rng.normal(size=(2, *GRID.shape)) + [[[0.0]], [[1.2]]]
    # A corner, which the second mark of its rows covers, lies out of reach.
    offset[25:, 64:] += 30.0
    start[25:, 64:] += 30.0
    pressure = 0.03 if np.isfinite(mean) else 0.0
    both.say("set_problem", LAW, offset, start, lift=1.1, pressure=pressure, mean_stiffness=mean)
    assert {each[1:] for grid in (both.compiled, both.plain) for each in grid.work} == {(0.0, 0, 0.0)}
    both.say("go_to_start", look=["z", "traction"])
    spectra(both, "g")
    alpha, beta = 0.0, 0.0
    for iteration, after in enumerate((0.0, 0.4, 0.3, 0.6)):
        # Of a first step there is no direction before: the last of its sums is not asked for.
        sums = both.say(
            "gradient", 0.05, alpha, beta, coarse=coarse, complete=False, asked=range(6 if iteration else 5)
        )
        spectra(both, "g")
        if coarse:
            size = float(np.sqrt(sums[0]))
            both.say("restrict", size)
            spectra(linear, "g")
            assert linear.say("relax", levels, 0.05, COARSE_ITERATIONS, COARSE_REDUCTION)
            spectra(linear, "x")
            both.say("low_modes", 0.05, size, asked=range(6 if iteration else 5))
            if iteration % 2:
                both.say("low_gradient", 0.05, asked=(1, 4))
        both.say("new_direction", after, coarse=coarse)
        here, there = both.compiled.direction[:, : GRID.shape[1]], both.plain.d
        np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-12)
        both.say("line", 0.03)
        both.say("move", 0.02, 0.02, look=["z", "traction"])
        both.say("line", 0.01)
        both.say("move", 0.015, 0.035, look=["z", "traction"])
        alpha, beta = 0.035, after
    assert both.compiled.trials == both.plain.trials == 8
    (finest, *coarser), (other, *others) = both.compiled.work, both.plain.work
    # Sweeps transform the traction as each of two moves makes it, and at the start; whole arrays the last one only.
    assert (finest.fft_pairs, other.fft_pairs) == (7.0, 4.5)
    assert [each[:3] for each in coarser] == [each[:3] for each in others]
    assert not any(each.fft_seconds for each in both.plain.work)
    assert both.compiled.near[:, 0].all()
    np.testing.assert_array_equal(both.compiled.near[:, 1], np.arange(40) < 25)
    assert both.say("residual") > 0
    both.say("elastic_energy", offset, start)
    # To the coarser grid with the state at hand, and back with its displacement.
    both.plain.start = both.plain.z
    both.say("go_to_start", look=["z"])
    both.say("set_coarser_problem", started=True)
    below = Both(both.compiled.coarser, both.plain.coarser)
    np.testing.assert_allclose(below.compiled.offset + 1.1, below.plain.offset, atol=1e-12)
    below.say("go_to_start", look=["z", "traction"])
    spectra(below, "g")
    both.say("go_to_coarser", look=["z", "traction"])
    spectra(both, "g")
    both.say("go_to_zero", look=["z", "traction"])
    spectra(both, "g")


def test_what_comes_near_the_wall_and_goes_back_feels_nothing() -> None:
    """Of two steps that add up to none: where it begins and ends it is out of reach."""
    n, z, d = 70, np.full((4, 78), 1.5), np.ones((4, 78))
    out, traction, sums = np.full((4, 78), 7.0), np.zeros((4, 78)), np.ones(6)
    wall = Pull(np.zeros((4, 2), dtype=bool), traction, np.zeros((4, 78), np.float32))
    tractions.move_gap(0, 4, sums, out, z, d, n, 0.4, 0.4, LAW, wall)
    assert (traction[:, :n] < 0).all()
    assert wall.stiffness[:, :n].all()
    tractions.move_gap(0, 4, sums, out, z, d, n, -0.4, 0.0, LAW, wall)
    for each in (traction, wall.stiffness, out[:, :n], sums[:4]):
        assert not each.any()


# --- what the mathematics makes of the answers --------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_the_next_direction_is_that_of_hager_and_zhang(seed: int) -> None:
    """Their β of vectors, SIAM J. Optim. 16, 170 (2005), preconditioned, from six sums; and slope and curvature."""
    rng = np.random.default_rng(seed)
    K, M = rng.uniform(0.1, 2.0, (2, 9))
    g, d, y = rng.normal(size=(3, 9))
    y = y if d @ y > 0 else -y
    g -= rng.uniform(0.0, 0.3) * d * (g @ d) / (d @ d)
    last = Line(0.3, float(d @ (g - y)), float(d @ (K * d)))
    s = M * g
    sums = np.array([g @ g, g @ s, y @ s, y @ (M * y), s @ (K * s), s @ (K * d)])
    beta = float((y @ s - 2 * (y @ (M * y)) * (d @ g) / (d @ y)) / (d @ y))
    beta = beta if beta > 0 and beta * (d @ g) < g @ s else 0.0
    found = conjugate_line(sums, last, float(d @ g), True)
    new = beta * d - s
    np.testing.assert_allclose(found, (beta, g @ new, new @ (K * new)), rtol=1e-12, atol=1e-14)
    assert found.slope < 0
    steepest = conjugate_line(sums, last, float(d @ g), False)
    np.testing.assert_allclose(steepest, (0.0, -g @ s, s @ (K * s)), rtol=1e-12)


class Along:
    """A wall along one direction: its energy, first and second derivative, and where a solve stands."""

    def __init__(self, *wall: Callable[[float], float]) -> None:
        self.wall, self.here, self.asked = wall, 0.0, 0

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        energy, force, _ = self.wall
        self.here += step
        assert self.here == pytest.approx(alpha, rel=1e-12)
        return force(alpha) - force(0.0), energy(alpha) - energy(0.0) - alpha * force(0.0), abs(energy(alpha))

    def line(self, alpha: float) -> tuple[float, float]:
        _, force, stiffness = self.wall
        self.asked += 1
        return force(self.here + alpha) - force(self.here), stiffness(self.here + alpha)


@pytest.mark.parametrize("at", [-3.0, 0.5, 2.0])
@pytest.mark.parametrize("newton", [True, False])
@pytest.mark.parametrize("strength", [0.0, 0.3, 50.0, -0.9])
def test_a_step_ends_where_the_slope_has_fallen_and_says_what_it_gained(
    strength: float, newton: bool, at: float
) -> None:
    """Of a parabola with a wall that stiffens beyond a point, is none, or softens from there on."""
    wall = Along(
        lambda x: strength * (np.logaddexp(0.0, 4 * (x - at)) / 4),
        lambda x: strength * float(expit(4 * (x - at))),
        lambda x: strength * 4 * float(expit(4 * (x - at)) * expit(-4 * (x - at))),
    )
    energy, force, stiffness = wall.wall
    line = Line(0.0, -1.0, 0.4)
    found = take_step(wall, line, stiffness(0.0), newton=newton)

    def slope(x: float) -> float:
        return line.slope + x * line.curvature + force(x) - force(0.0)

    x = found.length
    assert wall.here == pytest.approx(x)
    assert x > 0
    assert found.slope == pytest.approx(slope(x), abs=1e-12)
    assert abs(found.slope) <= SLOPE_ACCEPTED
    gained = x * line.slope + x * x * line.curvature / 2 + energy(x) - energy(0.0) - x * force(0.0)
    assert found.rise == pytest.approx(gained, abs=1e-12) or (found.rise < 0 and gained < 0)
    assert found.size_of_energy == pytest.approx(abs(energy(x)))
    first = -line.slope / (line.curvature + max(stiffness(0.0), 0.0))
    assert found.newton == (x == pytest.approx(first))
    # A step that is not Newton's own goes to a tenth of the slope, in a few looks at the points near the wall.
    assert abs(found.slope) <= SLOPE_REDUCTION + 1e-12
    assert wall.asked <= 12
