"""What has no meaning is refused with its name, its value and what is allowed: never converted, never computed with."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.inputs.arguments import ArgumentError, choice, count, field_of, file_name, flag, number, pair, texts
from continuum.path.loading import follow, solve
from continuum.solve.solution import Settings
from continuum.store.sweeps.workers import run_tasks
from tests.problems import Rough

ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.text(max_size=5),
    st.complex_numbers(),
    st.floats(),
    st.integers(),
    st.integers(min_value=10**400, max_value=10**401),
    st.lists(st.integers(), max_size=3),
    st.just(np.float32(0.5)),
    st.just(np.int8(3)),
    st.just(np.array(0.25)),
    st.just(np.True_),
)


@given(ANYTHING)
def test_a_number_is_one_or_is_refused(value: Any) -> None:
    number_like = isinstance(value, int | float | np.floating | np.integer | np.ndarray) and not isinstance(value, bool)
    if number_like and 0 < value <= 1:
        found = number("x", value, above=0, most=1)
        assert type(found) is float
        assert found == value
    else:
        with pytest.raises(
            ArgumentError, match=r"(?s)^x = .{,60}: allowed: a finite number greater than 0 and less than"
        ):
            number("x", value, above=0, most=1)


@given(ANYTHING)
def test_a_count_is_one_or_is_refused(value: Any) -> None:
    if isinstance(value, int | np.integer) and not isinstance(value, bool) and 1 <= value <= 5:
        assert count("n", value, 1, 5) == value
    else:
        with pytest.raises(ArgumentError, match=r"(?s)^n = .{,60}: allowed: a whole number from 1 to 5"):
            count("n", value, 1, 5)


@given(ANYTHING)
def test_a_choice_is_one_or_is_refused(value: Any) -> None:
    with pytest.raises(ArgumentError, match='allowed: one of "clamped", "free"'):
        choice("mean", value, ("clamped", "free"))
    assert choice("mean", "free", ("clamped", "free")) == "free"


def test_a_field_is_not_copied_without_need_and_never_converted() -> None:
    values = np.zeros((3, 4))
    assert field_of("z", values) is values
    assert field_of("z", np.ma.masked_array(values, mask=False)).shape == (3, 4)
    assert field_of("z", [[1, 2], [3, 4]]).dtype == np.float64
    for bad in (values + 0j, values > 0, np.full((3, 4), "1"), [[1.0], [1.0, 2.0]], np.zeros(3), None, object()):
        with pytest.raises(ArgumentError, match=r"z = .*allowed"):
            field_of("z", bad)


def test_a_flag_is_no_text_and_a_text_no_number() -> None:
    assert flag("x", np.True_) is True
    assert texts("x", "10um", '"10um"') == ("10um",)
    assert texts("x", ["a", "b"], '"10um"') == ("a", "b")
    assert texts("x", None, '"10um"') == ()
    for bad in ("no", 1, None):
        with pytest.raises(ArgumentError, match=r"x = .*: allowed: True or False"):
            flag("x", bad)
    for bad in (3, ["a", 3], b"10um", np.array("10um")):
        with pytest.raises(ArgumentError, match=r'x = .*: allowed: a text such as "10um"'):
            texts("x", bad, '"10um"')


@pytest.mark.parametrize("value", [3, None, b"name", "a\0b", "a" * 5000, object(), ["a"]])
def test_a_name_that_no_file_can_have_is_refused_and_not_echoed_whole(value: Any) -> None:
    with pytest.raises(ArgumentError, match=r"^result = .{,90}: allowed: the name of a file"):
        file_name("result", value)


def test_a_pair_is_of_two() -> None:
    assert pair("x", np.array([1, 2])) == pair("x", (1, 2)) == (1, 2)
    assert pair("x", ((1, 2), 3)) == ((1, 2), 3)
    for bad in ("ab", b"ab", np.array(0.25), (1,), 3, {1, 2}):
        with pytest.raises(ArgumentError, match=r"x = .*two values"):
            pair("x", bad)


def test_an_error_travels_between_processes() -> None:
    """It is unpickled from its arguments, which are not those of Exception: in a pool of workers it was lost."""
    with pytest.raises(ArgumentError) as caught:
        field_of("heights", np.zeros((2, 3)), (4, 4))
    back = pickle.loads(pickle.dumps(caught.value))
    assert type(back) is ArgumentError
    assert (str(back), back.name, back.allowed) == (str(caught.value), "heights", caught.value.allowed)


GRID = c.Grid.square(16)
PROBLEM = Rough(16, lambda_s=4.0).problem()
LOOSE = Settings(1e-4)
BAD: dict[str, Any] = {
    "points": lambda: c.Grid((4, 1), (1.0, 1.0)),
    "half points": lambda: c.Grid((2.5, 4), (1.0, 1.0)),
    "periods": lambda: c.Grid((4, 4), (np.nan, 1.0)),
    "three directions": lambda: c.Grid((4, 4, 4), (1.0, 1.0)),
    "spacing": lambda: c.Grid.square(4, -1.0),
    "range": lambda: c.LennardJonesSpline("0.3"),
    "two strengths": lambda: c.LennardJonesSpline(0.3, adhesion_length=0.1),
    "hurst": lambda: c.SelfAffine(1.5, 0.1, 4.0, 8.0),
    "cut-offs": lambda: c.SelfAffine(0.8, 0.1, 8.0, 4.0),
    "mean": lambda: c.HalfSpace("clampd"),
    "masked": lambda: c.Contact(np.ma.masked_less(PROBLEM.heights, 0), c.HardWall()),
    "complex": lambda: c.Contact(PROBLEM.heights + 0j, c.HardWall()),
    "text": lambda: c.Contact(PROBLEM.heights.astype(str), c.HardWall()),
    "tolerance": lambda: Settings(np.nan),
    "no tolerance": lambda: Settings(np.inf),
    "threads": lambda: Settings(1e-6, threads=0),
    "minus threads": lambda: Settings(1e-6, threads=-1),
    "iterations": lambda: Settings(1e-6, max_iterations=2.5),
    "control": lambda: solve(PROBLEM, "mean_gap", 1.0, LOOSE),
    "control of a path": lambda: list(follow(PROBLEM, "gap", [1.0], LOOSE)),
    "area": lambda: solve(PROBLEM, "repulsive-area", 2.0, LOOSE),
    "areas": lambda: c.Contact(PROBLEM.heights, c.HardWall()).path(area=[0.1, 1.0]),
    "gap": lambda: solve(PROBLEM, "mean-gap", float("nan"), LOOSE),
    "start": lambda: solve(PROBLEM, "mean-gap", 1.0, LOOSE, np.zeros((16, 15))),
    "workers": lambda: list(run_tasks([], print, lambda _: True, workers=0)),
}


def test_public_functions_refuse_in_one_wording() -> None:
    for made in BAD.values():
        with pytest.raises(ArgumentError, match=r"^[a-zA-Z_\- ]+ = .*: allowed: "):
            made()


def test_a_slope_beyond_small_slopes_is_said_and_an_enormous_one_refused() -> None:
    heights = Rough(16, lambda_s=4.0, slope=0.5).heights()
    with pytest.warns(UserWarning, match="above 0.3"):
        c.Contact(heights, c.HardWall())
    with pytest.raises(ArgumentError, match="slope"):
        c.Contact(heights * 30, c.HardWall())
