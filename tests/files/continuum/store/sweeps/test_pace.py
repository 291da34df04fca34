"""Time of a sweep, from the systems that have ended."""

import re
from pathlib import Path

import pytest

import continuum as c
from continuum.front.commands import SweepProgress
from continuum.inputs.toml import document
from continuum.store.sheet import duration
from continuum.store.sweeps.cluster import Allocation
from continuum.store.sweeps.status import FACTOR, Span, SystemTime, _rounded, expected
from continuum.store.sweeps.workers import Task, TaskResult, _in_order


def test_the_time_of_what_is_left_goes_with_its_work_on_each_grid() -> None:
    ended = [SystemTime("small", 1.0, 2.0), SystemTime("small", 3.0, 2.0), SystemTime("large", 10.0, 100.0)]
    span = expected(ended, {"small": 8.0, "large": 20.0})
    assert span is not None
    assert span.seconds == pytest.approx(8 * 4 / 4 + 20 * 10)
    # Two standard errors of the logarithms of two rates that differ by three are a factor of three.
    assert span.high == pytest.approx(8 * 3 + 200 * FACTOR)
    assert span.over(4).low == pytest.approx((8 / 3 + 200 / FACTOR) / 4)
    # Nothing is said of a grid on which nothing has ended, unless it may be scaled; then the range is wider.
    assert expected(ended[:2], {"small": 8.0, "large": 20.0}) is None
    scaled = expected(ended[:2], {"large": 20.0}, scaled=True)
    assert scaled is not None
    assert scaled == pytest.approx((20, 20 / FACTOR**2, 20 * FACTOR**2))
    assert expected([], {"small": 1.0}, scaled=True) is None
    assert expected([], {}) == (0, 0, 0)
    # Times that scatter more than that widen the range: two standard errors.
    wide = expected([SystemTime("", 1.0, 1.0), SystemTime("", 1.0, 100.0)], {"": 1.0})
    assert wide is not None
    assert wide.high / wide.seconds == pytest.approx(100)


def test_the_first_of_a_process_does_not_count_unless_loading_is_nothing_beside_it() -> None:
    assert expected([SystemTime("", 1.0, 30.0, first=True)], {"": 1.0}) is None
    counted = expected([SystemTime("", 1.0, 30.0, first=True), SystemTime("", 1.0, 1.0)], {"": 5.0})
    assert counted is not None
    assert counted.seconds == 5
    assert expected([SystemTime("", 1.0, 3000.0, first=True)], {"": 1.0}) is not None


@pytest.mark.parametrize(
    ("ended", "said"),
    [(1, "40 s to 6 min"), (2, "55 s to 4 min"), (100, "about 2 min")],
)
def test_a_range_is_said_until_it_is_narrow(ended: int, said: str) -> None:
    span = expected([SystemTime("", 1.0, 1.0)] * ended, {"": 120.0})
    assert str(span) == said
    assert duration(7200) == "2 h"


def test_some_systems_of_each_grid_come_first_and_then_the_longest(tmp_path: Path) -> None:
    tasks = [Task(tmp_path / f"{kind}{i}", f"{kind}{i}", cost, kind=kind) for kind, cost in (("a", 1.0), ("b", 9.0))
             for i in range(9)]  # fmt: skip
    order = [task.label for task in _in_order(tasks, workers=2)]
    # Two processes begin with one each of each kind; the next ones are of processes that have begun.
    assert order[:4] == ["b0", "a0", "b1", "a1"]
    assert order[4:] == [f"b{i}" for i in range(2, 9)] + [f"a{i}" for i in range(2, 9)]


def test_progress_tells_the_time_only_when_each_grid_has_told_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tasks = [Task(tmp_path / f"{kind}{i}", f"{kind}{i}", cost, kind=kind) for kind, cost in (("a", 1.0), ("b", 4.0))
             for i in range(4)]  # fmt: skip
    with SweepProgress("mine") as told:
        told.begin(tasks)
        told.end(TaskResult(tasks[4], 100.0, first=True, at_once=2))
        told.end(TaskResult(tasks[0], 90.0, first=True, at_once=2))
        told.end(TaskResult(tasks[5], 44.0, at_once=2))
        assert "left" not in capsys.readouterr().out
        told.end(TaskResult(tasks[1], 10.0, at_once=2))
        shown = capsys.readouterr()
        # 2 x 10 s and 2 x 44 s are left, for two processes.
        assert "18 s to 3 min left" in shown.out
        assert "mine: the other 4 take 36 s to 5 min of one core" in shown.err
        told.advance(tasks[6], 1.0)
        told.end(TaskResult(tasks[6], 40.0, at_once=2))
        assert "the other" not in capsys.readouterr().err  # once


def test_the_last_system_and_short_times_are_said_in_words_that_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with SweepProgress("mine") as told:
        told.begin([Task(tmp_path / f"{i}", f"{i}", 1.0, kind="a") for i in range(2)])
        told.end(TaskResult(Task(tmp_path / "0", "0", 1.0, kind="a"), 1.4))
    assert "mine: the last one takes up to 4 s of one core" in capsys.readouterr().err
    assert [str(Span(*each)) for each in ((0.2, 0.1, 0.4), (3, 0.6, 9), (20, 15, 21), (20, 10, 40))] == [
        "less than 1 s", "up to 9 s", "about 20 s", "10 to 40 s"
    ]  # fmt: skip
    assert [_rounded(rate) for rate in (17321.5, 658.0, 12.4, 0.123)] == ["17 000", "660", "12", "0.12"]


@pytest.mark.parametrize(
    ("time", "hours"),
    [("12:00:00", 12), ("90", 1.5), ("30:30", 30.5 / 60), ("2-12", 60), ("1-0:30", 24.5), ("1-1:0:36", 25.01)],
)
def test_the_time_of_an_allocation_is_read_as_slurm_reads_it(time: str, hours: float) -> None:
    asked = Allocation(nodes=2, time=time, workers=3, memory=1e9, threads=2)
    assert asked.core_seconds == pytest.approx(12 * 3600 * hours)
    assert Allocation(nodes=2, time=time, workers=3, memory=1e9, shards=5).core_seconds == pytest.approx(
        15 * 3600 * hours
    )


ONE = {
    "grid": {"n": 16},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 16.0, "seed": 1},
    "wall": {"law": "hard"},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "mean-pressure", "targets": [0.002, 0.004, 0.006]},
}


def test_slurm_says_core_hours_by_what_is_done_and_when_a_job_asks_for_a_fraction(tmp_path: Path) -> None:
    path, said = tmp_path / "mine.toml", list[str]()
    path.write_text(document({**ONE, "sweep": {"axes": {"surface.seed": list(range(6))}}}))
    ask = {"output": tmp_path / "results", "workers": 1, "warn": said.extend}
    assert "# Core hours: not known" in c.sweep_slurm(path, **ask)
    assert not said
    done = c.sweep(path, tmp_path / "results", settings={"surface.seed": [0, 1, 2]})
    assert done.ok
    script = c.sweep_slurm(path, **ask, time="1")
    assert "# Core hours: about " in script
    assert "by the systems that are done; this asks for 0.017." in script
    assert not said
    short = c.sweep_slurm(path, **ask, time="0:1", settings={"surface.seed": list(range(400))})
    (words,) = said
    assert f"# {words}" in short
    assert "% of what is needed" in words


def test_check_measures_only_if_asked_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rows = {row[0]: row[1] for row in c.check(ONE).sheet.rows}
    assert rows["states of the path"] == "3"
    assert rows["time"] == "not measured"
    rows = {row[0]: row[1] for row in c.check(ONE, measure=True).sheet.rows}
    assert 0 < float(rows["time of the first state"]) < 60
    swept = {**ONE, "sweep": {"axes": {"surface.seed": [1, 2], "grid.n": [16, 24]}}}
    rows = {row[0]: row[1] for row in c.check(swept, measure=True).sheet.rows}
    assert 0 < float(rows["the cheapest system took"]) < 60
    # Which form the range takes depends on how fast and how busy the machine is.
    assert re.fullmatch(r"less than 1 s|(up to|about) \d.*|\d.* to \d.*", rows["all of them, on one core"])
    assert not list(tmp_path.iterdir())
