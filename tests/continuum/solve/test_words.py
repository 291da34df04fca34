"""Each word of the compiled grids, from a state that no solve comes to, beside the formulas of whole arrays.

A solve forgives: a direction that is off costs an iteration, an energy that is off costs nothing until it decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.walls import LennardJonesSpline
from continuum.solve.arrays.bound_grid import ArrayBoundGrid
from continuum.solve.arrays.library import NumPy
from continuum.solve.arrays.smooth_grid import ArraySmoothGrid
from continuum.solve.compiled.bound_grid import CompiledBoundGrid
from continuum.solve.compiled.smooth_grid import CompiledSmoothGrid
from continuum.solve.conjugate import COARSE_ITERATIONS, COARSE_REDUCTION

GRID = Grid((36, 70), (36.0, 105.0))
"""Rows of more than one mark of contact; coarser grids of (18, 32) and (8, 16) points."""
LAW = LennardJonesSpline(0.3).law


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
    near[3:20, 5:50] = rng.random((17, 45)) < 0.4
    near[30, 66] = True
    both.say("set_problem", random[0], None, lift=0.3, sink=0.1, mean_stiffness=mean, most=most)
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
    pressure = 0.03 if np.isfinite(mean) else 0.0
    both.say("set_problem", LAW, offset, start, lift=1.1, pressure=pressure, mean_stiffness=mean)
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
