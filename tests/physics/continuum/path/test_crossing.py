"""The bracket of a crossing, whatever crosses along whatever key: it holds what it is said to hold."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from continuum.path.crossing import Bracket

ROOTS = st.floats(-3.0, 3.0)
PLACES = st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=12)
RISING = st.booleans()


@given(ROOTS, PLACES, RISING, st.floats(-5.0, 5.0))
def test_it_holds_the_crossing_of_what_rises_or_falls_between_the_last_trials_on_both_sides(
    root: float, places: list[float], rising: bool, crosses: float
) -> None:
    bracket, sides = Bracket(crosses=crosses, rising=rising), list[bool]()
    for number, place in enumerate(places, 1):
        shift = math.atan(place - root)
        bracket = bracket.add(place, crosses + (shift if rising else -shift))
        sides.append(place in (bracket.upper,) and place != bracket.lower)
        assert bracket.trials == number
        assert place in (bracket.lower, bracket.upper)
        # Trials after the first while all lie on one side.
        assert bracket.again == (number - 1 if len(set(sides)) == 1 else 0)
    assert not bracket.lower > root + 1e-12
    assert not bracket.upper < root - 1e-12
    assert bracket.known == (len(set(sides)) == 2)
    if bracket.known:
        assert bracket.crossed
        assert bracket.lower <= bracket.root <= bracket.upper
        assert bracket.lower <= bracket.middle <= bracket.upper


@given(ROOTS, st.floats(0.3, 3.0), st.floats(0.01, 4.0), st.floats(0.01, 4.0), st.floats(1e-3, 0.3))
def test_trials_beside_the_root_close_the_bracket_and_halving_does_in_as_many_steps_as_bits(
    root: float, slope: float, below: float, above: float, width: float
) -> None:
    def at(place: float) -> float:
        return slope * (place - root) + 0.05 * math.sin(3 * (place - root))

    first = Bracket().add(root - below, at(root - below)).add(root + above, at(root + above))
    halved, closed = first, first
    for _ in range(math.ceil(math.log2(first.width / width)) if first.width > width else 0):
        halved = halved.add(halved.middle, at(halved.middle))
    assert halved.width <= width * (1 + 1e-9)
    for _ in range(60):
        if closed.width <= width:
            break
        place = closed.closing(width)
        assert closed.lower < place < closed.upper
        closed = closed.add(place, at(place))
    assert closed.width <= width
    assert closed.lower <= root <= closed.upper


@given(st.floats(1e-3, 1e3), st.floats(1.01, 1e3), st.floats(0.0, 1.0), st.floats(1e-3, 1e3))
def test_in_the_logarithm_it_does_not_depend_on_the_unit_of_the_key(
    lower: float, factor: float, share: float, unit: float
) -> None:
    one = Bracket(lower, lower * factor, -share, 1 - share, log=True)
    other = Bracket(unit * lower, unit * lower * factor, -share, 1 - share, log=True)
    assert math.isclose(other.root, unit * one.root, rel_tol=1e-12)
    assert math.isclose(other.middle, unit * one.middle, rel_tol=1e-12)
    assert math.isclose(one.root, lower * factor**share, rel_tol=1e-12)


def test_of_trials_in_the_wrong_order_the_older_one_is_no_end_and_nothing_is_known_without_both() -> None:
    bracket = Bracket().add(1.0, -0.1).add(2.0, 0.1)
    assert (bracket.lower, bracket.upper) == (1.0, 2.0)
    low = bracket.add(0.5, 0.05)
    assert math.isnan(low.lower)
    assert low.upper == 0.5
    high = bracket.add(2.5, -0.05)
    assert math.isnan(high.upper)
    assert high.lower == 2.5
    for one in (low, high, Bracket()):
        assert not one.known
        assert not one.width <= math.inf
        assert not one.crossed
    # On the value itself, too, nothing crosses before the other end is known.
    assert not Bracket(1.0, 2.0, at_lower=0.0).crossed


@given(ROOTS, st.floats(0.3, 1.0), st.floats(0.01, 3.0), st.floats(0.01, 3.0))
def test_closing_in_takes_fewer_trials_than_halving_on_a_root_and_hardly_more_on_a_jump(
    root: float, slope: float, below: float, above: float
) -> None:
    """Twenty halvings reach a millionth of the bracket; 14 and 24 trials were the most of 20 000 brackets."""
    for shape, most in ((lambda x: math.expm1(slope * x), 16), (lambda x: math.copysign(1 + abs(x), x), 28)):
        bracket = Bracket().add(root - below, shape(-below)).add(root + above, shape(above))
        wide, trials, found = bracket.width, 0, 1.0
        while bracket.width > 1e-6 * wide and abs(found) > 1e-6:
            place = bracket.inside()
            assert bracket.lower < place < bracket.upper
            found, trials = shape(place - root), trials + 1
            bracket = bracket.add(place, found)
        assert trials <= most
