"""A search by itself: it ends where the column crosses the value, and goes on from whatever is known."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from continuum.front.cli import main
from continuum.inputs.toml import ConfigError
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.bisection import KEYS, Bisection, bisection_faults, is_bisection
from continuum.store.sweeps.measured import COLUMNS, SystemTable
from tests.problems import SMALL

ONE: dict[str, Any] = {"bisect": "load at 1.4", "from": 0.002, "to": 0.02, "tolerance": 0.02}


def search(**changes: Any) -> Bisection:
    return Bisection.of("wall.adhesion_length", {**ONE, **changes})


ENDS = st.tuples(st.floats(1e-6, 1e6), st.floats(1.001, 1e6)).map(lambda two: (two[0], two[0] * two[1]))
TOLERANCES = st.floats(1e-6, 0.5)


@given(ENDS, TOLERANCES, st.floats(0, 1), st.sampled_from(["log", "linear"]), st.sampled_from([1.0, -1.0]))
def test_it_ends_within_the_tolerance_after_as_many_systems_as_it_says(
    ends: tuple[float, float], tolerance: float, share: float, scale: str, slope: float
) -> None:
    first, last = ends
    root = first * (last / first) ** share if scale == "log" else first + share * (last - first)
    one = search(**{"from": first, "to": last, "tolerance": tolerance, "crosses": 3.0, "scale": scale})
    asked = []

    def column_at(value: float) -> float:
        asked.append(value)
        return 3.0 + slope * math.log(value / root)

    found = one.follow(column_at)
    assert (found.next, found.reason) == (None, "")
    assert found.trials == one.most == len(asked) == len(set(asked))
    assert found.lower <= root * (1 + 1e-12)
    assert found.upper >= root * (1 - 1e-12)
    # A value is tried with eight digits.
    width = found.upper / found.lower - 1 if scale == "log" else (found.upper - found.lower) / last
    assert width <= tolerance * (1 + 1e-6) + 1e-7
    assert found.lower <= found.value <= found.upper
    # The column is linear in the logarithm: so is what is read in between.
    if scale == "log":
        assert math.isclose(found.value, root, rel_tol=1e-6)


def test_what_is_read_in_between_is_linear_on_a_linear_scale_also_across_zero() -> None:
    one = search(**{"from": -1.0, "to": 3.0, "scale": "linear", "tolerance": 0.1})
    found = one.follow(lambda value: value - 0.123)
    assert math.isclose(found.value, 0.123, rel_tol=1e-12)
    assert found.upper - found.lower <= 0.1 * 3


@given(st.floats(0.0021, 0.0199), st.data())
def test_it_goes_on_from_whatever_is_known_as_if_it_had_never_stopped(root: float, data: st.DataObject) -> None:
    one, order = search(), list[float]()
    known = dict[float, float]()
    while (value := one.follow(known.get).next) is not None:
        order.append(value)
        known[value] = value - root
    assert order[:2] == [0.002, 0.02]
    assert len(order) == one.most
    # Any of them may be lost: the first that is not there is tried next, and nothing else changes.
    kept = data.draw(st.sets(st.sampled_from(order)))
    again = {value: known[value] for value in kept}
    tried = []
    while (value := one.follow(again.get).next) is not None:
        tried.append(value)
        again[value] = known[value]
    assert tried == [value for value in order if value not in kept]
    assert one.follow(again.get) == one.follow(known.get)
    # A finer search asks for what the coarser one has tried, and goes on.
    finer = search(tolerance=0.005)
    assert finer.follow(known.get).next not in known
    assert finer.follow(known.get).trials == len(order)


def test_where_nothing_crosses_or_nothing_is_known_it_says_so() -> None:
    one = search(crosses=-1.0)
    none = one.follow({0.002: 2.0, 0.02: 3.0}.get)
    assert (none.next, none.trials) == (None, 2)
    assert none.reason == "no crossing between 0.002 and 0.02: load is 2 and 3"
    assert math.isnan(none.value)
    assert "no load at adhesion_length 0.02" in one.follow({0.002: 2.0, 0.02: math.nan}.get).reason
    third = one.middle(one.whole)
    broken = one.follow({0.002: 2.0, 0.02: -3.0, third: math.nan}.get)
    assert (broken.next, broken.trials) == (None, 3)
    assert f"no load at adhesion_length {third:g}" in broken.reason
    # On the value itself it does cross, at either end; where it lies on it everywhere it does not.
    assert one.follow(lambda value: -1.0 if value == 0.002 else 5.0).value == 0.002
    assert one.follow(lambda value: -1.0 if value == 0.02 else 5.0).value == 0.02
    assert "no crossing" in one.follow(lambda value: -1.0).reason
    assert "no crossing" in search().follow(lambda value: 1e-200 * value).reason


def test_the_column_is_read_where_it_is_asked_for() -> None:
    table = np.zeros((4, len(COLUMNS)))
    at, numbers = list(COLUMNS).index, SystemTable(table, 0.0, "", {"mine": np.array([1.0, 5.0, 3.0, 4.0])})
    table[:, at("target")] = [1.6, 1.4, 1.2, 1.4]  # there, and a part of the way back
    table[:, at("load")] = [1.0, 2.0, 3.0, 4.0]
    table[:, at("converged")] = [1, 1, 0, 1]
    assert search().at(numbers) == 2.0
    assert search(bisect="load").at(numbers) == 4.0
    assert math.isnan(search(bisect="load at 1.2").at(numbers))
    assert search(bisect=" load  at 140 %").at(numbers) == 2.0
    assert math.isnan(search(bisect="load at 1.3").at(numbers))


NUMBERS = st.one_of(
    st.floats(), st.integers(), st.just(10**400), st.booleans(), st.text(max_size=3), st.none(), st.lists(st.floats())
)


@given(
    st.dictionaries(st.sampled_from(["from", "to", "tolerance", "crosses"]), NUMBERS),
    st.sampled_from(["log", "linear"]),
)
@example({"from": 5e-324, "to": 1e149}, "log")
@example({"from": 0.1, "to": math.nextafter(0.1, 1)}, "log")
@example({"from": -5e-324, "to": 0.0}, "linear")
def test_any_numbers_make_a_search_that_ends_or_are_refused(numbers: dict[str, Any], scale: str) -> None:
    described = {**ONE, "scale": scale, **numbers}
    assert is_bisection(described)
    faults = list(bisection_faults(described))
    assert {fault.key[0] for fault in faults} <= {"from", "to", "tolerance", "crosses"}
    if faults:
        return
    one = Bisection.of("wall.adhesion_length", described)
    step = max(1.0, abs(one.crosses))
    found = one.follow(lambda value: one.crosses + (step if value > one.first else -step))
    assert found.next is None
    assert one.first <= found.lower <= found.upper <= one.last
    assert found.trials == one.most < 600
    assert Bisection.of(one.key, one.table) == one


FAULTY = [
    ("bisect", '"lod"', "did you mean load?"),
    ("bisect", '"happiness at 1 %"', "the columns are step, converged"),
    ("bisect", '"load at one percent"', "a column of the table, as"),
    ("bisect", '"load at most"', "a number after at, which is a target of the path, not most"),
    ("bisect", '"load at nan"', "a number after at"),
    ("bisect", "3", "a column of the table, as"),
    ("bisect", '"load at 1.3"', "a column at a target of the path: 1.6, 1.4, 1.2"),
    ("bisect", None, "sweep.axes.wall.adhesion_length.bisect is not given"),
    ("from", None, "lower end of the values to search"),
    ("from", '"0.1"', "a number in quotes"),
    ("from", "0.0", 'a number above 0, or scale = "linear"'),
    ("from", "0.03", "the ends exchanged"),
    ("from", "true", "a number (lower end"),
    ("to", None, "upper end of the values to search"),
    ("to", "inf", "a number (upper end"),
    ("to", "1e200", "a number (upper end"),
    ("to", "0.002", "upper end of the values to search, above from"),
    ("tolerance", None, "this key is required"),
    ("tolerance", "0.0", "from 1e-6 to 0.5"),
    ("tolerance", "2", "from 1e-6 to 0.5"),
    ("crosses", "nan", "a number (value that the column crosses"),
    ("scale", '"Log"', 'did you mean "log"?'),
    ("scale", "[]", '"log" or "linear"'),
    ("tolerence", "0.1", "did you mean tolerance?"),
]


def test_a_faulty_key_of_a_search_is_named_with_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for quoted in [True, False]:
        for key, value, says in FAULTY:
            keys = {"bisect": '"load at 1.4"', "from": "0.002", "to": "0.02", "tolerance": "0.1", key: value}
            table = ", ".join(f"{name} = {text}" for name, text in keys.items() if text is not None)
            name = '"wall.adhesion_length"' if quoted else "wall.adhesion_length"
            path = tmp_path / "many.toml"
            path.write_text(f"{SMALL}[sweep.axes]\n{name} = {{ {table} }}\n")
            assert main(["sweep", "run", str(path), "-o", str(tmp_path / "out")]) == 2
            said = capsys.readouterr().err
            assert says in said
            assert f"{path}:{len(path.read_text().splitlines())}: sweep.axes.wall.adhesion_length" in said
            assert not (tmp_path / "out").exists()


def test_all_faults_of_a_search_are_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "many.toml"
    table = '{bisect = "lod", from = "-1", tolerance = 3, cross = 1, scale = "cubic"}'
    path.write_text(f'{SMALL}[sweep.axes]\n"wall.adhesion_length" = {table}\n"surface.seed" = []\n')
    with pytest.raises(ConfigError) as caught:
        Sweep.read(path)
    assert {fault.key[-1] for fault in caught.value.faults} == {
        "bisect", "from", "to", "tolerance", "cross", "scale", "surface.seed"
    }  # fmt: skip
    assert set(KEYS) >= {"bisect", "from", "to", "tolerance", "crosses", "scale"}


UNSUITED = [
    ('[sweep.axes]\n"wall.adhesion_length" = A\n"surface.rms_slope" = A\n', "", "one search: "),
    ('[[sweep.zipped]]\n"wall.adhesion_length" = A\n"surface.seed" = [1]\n', "",
     "which belongs in [sweep.axes], not among"),
    ('[sweep.axes]\n"wall.adhesion_length" = A\n[[sweep.zipped]]\n"wall.adhesion_length" = [1.0]\n', "",
     "wall.adhesion_length is on several"),
    ('[sweep.axes]\n"wall.adhesion_length" = A\n"wall" = [{law = "hard"}]\n', "",
     "wall holds wall.adhesion_length"),
    ('[sweep.axes]\n"surface.seed" = B\n', "", "surface.seed = 2.0"),
    ('[sweep.axes]\n"surface.kind" = A\n', "", "surface.kind = 0.002"),
    ('[sweep]\nkeep = ["adhesion_length < 0.01"]\n[sweep.axes]\n"wall.adhesion_length" = A\n', "",
     "conditions on both ends of a search alike"),
    ('[sweep.axes]\n"wall.adhesion_length" = A\n', "wall.adhesion_length={bisect='lod',from=1,to=2}",
     'sweep.axes.wall.adhesion_length.bisect = "lod"\n    allowed: a column'),
    ('[sweep.axes]\n"wall.adhesion_length" = A\n"surface.rms_slope" = [0.1]\n', "surface.rms_slope=A",
     "one search: wall.adhesion_length and surface.rms_slope"),
    ('[sweep.axes]\n"wall.adhesion_length" = A\n', "wall={law='hard'}", "values for the axis wall.adhesion_length"),
    ('[[sweep.zipped]]\n"surface.rms_slope" = [0.1]\n"surface.seed" = [1]\n', "surface.rms_slope=A",
     "one of step, factor and count"),
]  # fmt: skip


def test_a_search_that_does_not_suit_the_sweep_is_one_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for sweep, setting, says in UNSUITED:
        table = '{ bisect = "load at 1.4", from = 0.002, to = 0.02, tolerance = 0.1 }'
        path = tmp_path / "many.toml"
        path.write_text(
            SMALL
            + sweep.replace("= A", f"= {table}").replace("= B", f"= {table.replace('0.002', '2').replace('0.02', '9')}")
        )
        settings = ["--set", setting.replace("=A", f"={table}")] if setting else []
        assert main(["check", str(path), *settings]) == 2
        assert says in capsys.readouterr().err
