"""Physics does not depend on the unit of pressure or of length: the same contact in other units has the same areas."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.walls import Wall
from tests.kinds import IN_UNITS, covering
from tests.problems import Rough

ROUGH = Rough(48)
EQUAL_UNITS = 1e-5
"""Two solves to 1e-6 h'rms E* differ in load and gap by up to some 1e-6 of these."""


@dataclass(frozen=True)
class InUnits:
    """A half-space whose stiffness is given in another unit than E*/a0."""

    modulus: float

    def stiffness(self, grid: Grid) -> Real:
        return self.modulus * c.HalfSpace().stiffness(grid)


def spline(e: float, s: float) -> Wall:
    return c.LennardJonesSpline(range=0.35, minimum_stiffness=0.5 * e)


@contextmanager
def warned_of_another_unit(expected: bool) -> Iterator[None]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    assert any("the unit of pressure" in str(each.message) for each in caught) == expected


GIVEN = [("mean_gap", 0.3), ("mean_gap", 0.6), ("pressure", 0.01), ("area", 0.2)]
CONTROLS = st.sampled_from(GIVEN)
"""Mean gaps beyond that at which the traction of the wall vanishes."""


def press(contact: c.Contact, control: str, value: float, e: float = 1.0, s: float = 1.0) -> c.State:
    """The state at a control whose value is given in the units E* = 1, a0 = 1."""
    if control == "mean_gap":
        value = contact.wall.zero_gap + value * s
    return contact.press(**{control: value * e if control == "pressure" else value})


def same(state: c.State, base: c.State, control: str, e: float = 1.0, s: float = 1.0) -> None:
    """Both are one state in two units."""
    # Under a law a point counts by its gap, which is known to the residual only; an area is met to 1 % of it.
    allowed = 1 / base.contact.grid.size + (0.01 * base.area_rep if control == "area" else 0.0005)
    assert state.area_rep == pytest.approx(base.area_rep, abs=allowed)
    assert base.area_rep > 0.02
    if control != "area":
        assert state.load / e == pytest.approx(base.load, rel=EQUAL_UNITS, abs=EQUAL_UNITS * ROUGH.slope)
        assert state.mean_gap / s == pytest.approx(base.mean_gap, rel=EQUAL_UNITS)


@pytest.mark.parametrize("wall", [*IN_UNITS.values(), spline], ids=[*IN_UNITS, "spline"])
@given(exponent=st.floats(-8, 8), given=CONTROLS)
@example(exponent=-6.0, given=("pressure", 0.01))
@settings(max_examples=1)
def test_the_unit_of_pressure_does_not_matter(wall, exponent: float, given: tuple[str, float]) -> None:
    control, value = given
    e = 10.0**exponent
    base = press(c.Contact(ROUGH.heights(), wall=wall(1.0, 1.0)), control, value).require()
    # The median of 2 K/q is exactly e here; close to the bounds rounding decides.
    assume(abs(abs(exponent) - 1) > 1e-6)
    with warned_of_another_unit(abs(exponent) > 1):
        contact = c.Contact(ROUGH.heights(), wall=wall(e, 1.0), substrate=InUnits(e), max_iterations=500)
    state = press(contact, control, value, e)
    # What says "converged" is.  The preconditioner's shift is a stiffness at E* = 1: the iterations grow away from it,
    # at a given pressure from 110 to 600 at E* = 10.  Within a factor of two all must converge.
    if state.converged or abs(exponent) < 0.3:
        same(state.require(), base, control, e)


@cache
def in_a0(law: str, control: str, value: float) -> c.State:
    return press(c.Contact(ROUGH.heights(), wall=IN_UNITS[law](1.0, 1.0)), control, value).require()


@pytest.mark.parametrize(
    ("law", "of"),
    covering(sorted(IN_UNITS), [(-3.0, "area", 0.2), (-3.0, "pressure", 0.01), (3.0, "pressure", -0.001)]),
)
def test_the_unit_of_length_does_not_matter_to_any_law(law: str, of: tuple[float, str, float]) -> None:
    in_another_length(law, *of)


@given(
    law=st.sampled_from(sorted(IN_UNITS)),
    exponent=st.floats(-3, 3),
    given=st.sampled_from([*GIVEN, ("area", 0.03), ("pressure", -0.001)]),
)
@settings(max_examples=8)
def test_the_unit_of_length_does_not_matter(law: str, exponent: float, given: tuple[str, float]) -> None:
    in_another_length(law, exponent, *given)


def in_another_length(law: str, exponent: float, control: str, value: float) -> None:
    """Same areas and loads, at the same price: searches, preconditioner and pull-off know no length of their own."""
    if law == "hard" and value < 0:
        return  # it holds no tension
    s, base = 10.0**exponent, in_a0(law, control, value)
    contact = c.Contact(s * ROUGH.heights(), wall=IN_UNITS[law](1.0, s), period=(48 * s, 48 * s))
    state = press(contact, control, value, s=s).require()
    same(state, base, control, s=s)
    # Trials of a search begin and end a little otherwise by rounding.
    assert cost(state) <= 2 * cost(base)
    if control != "area":  # where the load is small, kappa is what a difference of the area of 1 % makes it
        assert state.measure().kappa == pytest.approx(base.measure().kappa, rel=0.02)


def test_nor_does_it_where_nothing_is_repeated() -> None:
    heights, found = Rough(32).heights(), []
    for s in (1.0, 1e-3, 1e3):
        contact = c.Contact(
            s * heights, IN_UNITS["attraction-on-core"](1.0, s), c.NonPeriodicHalfSpace(), period=(32 * s, 32 * s)
        )
        state = contact.press(area=0.2).require()
        found.append((state.area_rep, state.load, state.separation / s))
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=1e-4)  # residuals are 1e-6 of a few percent of E*


def cost(state: c.State) -> float:
    """FFT pairs of a state and of all that was solved on the way to it."""
    return state.search_pairs + state.solution.fft_pairs


def test_a_table_of_stiffness_in_another_unit_is_warned_of_and_solved_as_closely() -> None:
    """The case that was found: A = 1.0000, mean gap 0, "converged" below a modulus of 1e-6."""
    grid = Grid.square(48)
    stiffness_q = c.HalfSpace().stiffness(grid)
    base = c.Contact(ROUGH.heights(), wall=c.HardWall()).press(pressure=0.01).require()
    for e in (1e-7, 70.0):
        table = c.TabulatedSubstrate(e * stiffness_q, grid.lengths, "a half-space in another unit")
        with pytest.warns(UserWarning, match="divide the stiffness"):
            contact = c.Contact(ROUGH.heights(), wall=c.HardWall(), substrate=table)
        state = contact.press(pressure=0.01 * e).require()
        assert state.area_rep == pytest.approx(base.area_rep, abs=1 / 48**2)


def test_elastic_constants_in_another_unit_are_refused() -> None:
    with pytest.raises(ValueError, match=r"constants.* of these it is 135\.191: divide them"):
        c.CubicLayer(10.0, (169.9, 122.6, 76.2), "clamped")
    copper = c.CubicLayer(10.0, tuple(x / 135.191 for x in (169.9, 122.6, 76.2)), "clamped")
    assert copper.constants.c11 == pytest.approx(1.2567, abs=1e-3)
