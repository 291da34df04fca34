"""Searches on disk: every trial is a system like any other, and what is missing is done, whatever is there."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import continuum as c
from continuum.front.cli import main
from continuum.inputs.errors import InputError, OutputError
from continuum.inputs.reading import InputFile
from continuum.inputs.toml import ConfigError
from continuum.store.runs.result import Result
from continuum.store.sweeps import crossings
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.collect import LeftOutWarning, collect
from continuum.store.sweeps.crossings import TrialError, crossings_of, done_before, solve_task
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.sweep import SystemTask, begin, record
from continuum.store.sweeps.workers import TaskResult
from tests.problems import SMALL
from tests.stored import same

PLAIN = SMALL.replace("1.6, 1.4,\n           1.2", "1.4").replace("retract = true", "").replace("fields = true", "")
SEARCH = '{ bisect = "load at 1.4", crosses = -0.005, from = 0.002, to = 0.02, tolerance = 0.5 }'
SEARCHES = f"""[sweep.axes]
"wall.adhesion_length" = {SEARCH}
"surface.seed" = [3, 4]
[[sweep.zipped]]
"surface.hurst" = [0.8]
"surface.rms_slope" = [0.1]
"""
KEY = "wall.adhesion_length"


def described(folder: Path, sweep: str = SEARCHES, text: str = PLAIN) -> Path:
    path = folder / "many.toml"
    path.write_text(text + sweep)
    return path


def solved(path: InputFile, root: Path, **options: Any) -> None:
    """As the command does it, in this process."""
    for task in begin(Sweep.read(path, **options), root):
        solve_task(root, task)


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The searches of two surfaces, done in this process."""
    folder = tmp_path_factory.mktemp("searches")
    solved(described(folder), folder / "out" / "many")
    return folder


def copied(searched: Path, tmp_path: Path) -> tuple[Path, Path]:
    shutil.copytree(searched, tmp_path / "copy")
    return tmp_path / "copy" / "many.toml", tmp_path / "copy" / "out" / "many"


def files(root: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in (root / "points").iterdir()}


def test_a_search_finds_the_threshold_that_one_solve_finds(tmp_path: Path) -> None:
    """Two ways to the work of adhesion at which the load at an area vanishes: many systems, and Broyden's method."""
    text = PLAIN.replace("n = [24, 30]\nperiod = [24, 30]", "n = 32").replace("lambda_L = 12.0", "lambda_L = 16.0")
    law = 'law = "attraction-on-core"\nshape = "spline"\neffective_range = 0.4\ncore_stiffness = 5.0'
    text = text.replace('law = "lennard-jones-spline"', law).replace("lambda_s = 6.0", "lambda_s = 8.0")
    text = text.replace('control = "mean-gap"\ntargets = [1.4]', 'control = "repulsive-area"\ntargets = [0.05]')
    search = '{ bisect = "load at 5 %", from = 0.0005, to = 0.0008, tolerance = 0.2 }'
    path = described(tmp_path, f'[sweep.axes]\n"{KEY}" = {search}\n', text)
    root = tmp_path / "many"
    begin(Sweep.read(path), root)
    nothing = c.sweep_collect(root)  # before anything is done
    assert (len(nothing.system), nothing.crossings[0].status) == (0, "not done")
    solved(path, root)
    table = c.sweep_collect(root)
    (found,) = table.crossings
    assert (found.found, found.label) == (True, "the one system")
    with xarray.open_dataset(table.files[1], engine="h5netcdf") as cube:  # without another axis
        assert cube["crossing"].values.tolist() == [found.value]
        assert cube["load_net"].dims == ("search", "trial", "step")
    assert found.bracket.at_lower > 0 > found.bracket.at_upper
    (tmp_path / "one.toml").write_text(text)
    found_at_once = c.threshold(tmp_path / "one.toml", tmp_path, area=[0.05], width=0.05).points[0]
    assert found_at_once.converged
    # The threshold is known to 5 %, the search to less than its bracket of 20 %; areas are met within half a point.
    assert found_at_once.work_of_adhesion == pytest.approx(found.value, rel=0.1)


def test_a_search_goes_on_past_a_jump_whose_sides_are_on_one_side_of_the_value(tmp_path: Path) -> None:
    """Strong adhesion on small heights jumps over the area, from one negative load to another."""
    search = {"bisect": "load at 5 %", "from": 0.02, "to": 1.0, "tolerance": 0.5}
    surface = {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 8.0, "lambda_L": 16.0, "seed": 1}
    system = {
        "grid": {"n": 32},
        "surface": surface,
        "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.05},
        "substrate": {"response": "half-space", "mean": "clamped"},
        "loading": {"control": "repulsive-area", "targets": [0.05], "area_tolerance": 0.05, "area_resolution": 0.02},
    }
    root = tmp_path / "many"
    solved(system | {"sweep": {"axes": {"surface.rms_slope": search}}}, root)
    (found,) = c.sweep_status(root).crossings
    assert found.found
    assert found.bracket.at_lower < 0 < found.bracket.at_upper
    result = Result.read(root / "points" / f"{systems_of(root).systems[0].key[:24]}.h5")
    assert result.points[0].status == "JUMPED_OVER"
    loads = sorted((result.events[0].event.before.load, result.events[0].event.after.load))
    asked = systems_of(root).bisection
    assert asked is not None
    assert loads[0] < crossings.between_sides(asked, result) < loads[1] < 0
    # On which side the area itself would be, a jump across the value does not say; nor does it say all columns.
    assert np.isnan(crossings.between_sides(replace(asked, crosses=sum(loads) / 2), result))
    assert np.isnan(crossings.between_sides(replace(asked, column="kappa"), result))
    assert np.isnan(crossings.between_sides(replace(asked, target=0.06), result))
    # Such a search ends at its first end, which is stored; the other one, which it never runs, is not waited for.
    across = system | {"sweep": {"axes": {"surface.rms_slope": search | {"crosses": sum(loads) / 2}}}}
    begin(Sweep.read(across), root := tmp_path / "across")
    shutil.copy(result.path, root / "points")
    solved(across, root)
    status, table = c.sweep_status(root), collect(root)
    assert "a jump across the value" in status.crossings[0].status
    assert (status.total, status.done, status.left, status.seconds_left) == (1, 1, 0, 0.0)
    assert (table.missing, len(table.keys)) == (0, 1)
    assert main(["sweep", "status", str(root), "--watch", "60"]) == 0


def test_what_was_found_stands_in_tables_that_xarray_and_people_read(
    searched: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, root = copied(searched, tmp_path)
    done = c.sweep(path, root.parent)
    assert (done.ok, done.total, done.found, done.done) == (True, 2, 2, 0)
    table = c.sweep_collect(root)
    assert table.files == (root / "table.csv", root / "table.h5", root / "crossings.csv")
    assert done.crossings == table.crossings == c.sweep_status(root).crossings
    assert [one.settings["surface.seed"] for one in table.crossings] == [3, 4]
    most = 2 + 3  # a factor of 10 to within 1.5
    for number, one in enumerate(table.crossings):
        assert one.found
        assert one.bracket.trials == most
        assert 0.002 < one.bracket.lower < one.value < one.bracket.upper < 1.5 * one.bracket.lower
        assert one.bracket.at_lower > -0.005 > one.bracket.at_upper
        # What a search has tried stands in the table of points as what a run of it finds.
        column, tried = table["load"][table.system // most == number], table[KEY][table.system // most == number]
        assert list(tried) == sorted(tried)
        crossing = np.interp(0.005, -column, np.log(tried))
        assert np.exp(crossing) == pytest.approx(one.value, rel=1e-12)
    with xarray.open_dataset(root / "table.h5", engine="h5netcdf") as cube:
        assert cube["load_net"].dims == ("surface.seed", "surface.hurst", "trial", "step")
        assert cube[KEY].dims == ("surface.seed", "surface.hurst", "trial")
        assert cube["crossing"].sel({"surface.seed": 4}).item() == table.crossings[1].value
        assert not np.isnan(cube["load_net"]).any()
        lower = cube[KEY].where(cube["load_net"].isel(step=0) > -0.005).max("trial")
        np.testing.assert_array_equal(lower, cube["crossing_lower"])
    rows = (root / "crossings.csv").read_text().splitlines()
    assert rows[0].startswith(f"search,surface.seed,surface.hurst,surface.rms_slope,{KEY},lower,upper,load at lower")
    assert float(rows[2].split(",")[4]) == table.crossings[1].value
    assert len((root / "table.csv").read_text().splitlines()) == 1 + 2 * most
    assert main(["sweep", "status", str(root)]) == 0
    shown = capsys.readouterr().out
    assert "crossings found    2" in shown
    assert f"{KEY} where load at 1.4 crosses -0.005" in shown
    # A table of the user's own is left alone.
    (root / "crossings.csv").write_text("mine")
    assert main(["sweep", "collect", str(root)]) == 2
    assert (root / "crossings.csv").read_text() == "mine"


def test_check_counts_what_searches_take_at_most(tmp_path: Path) -> None:
    path = described(tmp_path)
    rows = {row[0]: row[1] for row in c.check(path).sheet.rows}
    assert (rows["searches"], rows["systems"]) == ("2", "10")
    assert rows["states of their paths"] == "10"
    assert sorted(tmp_path.iterdir()) == [path]


def test_whatever_is_lost_is_done_again_and_nothing_else(searched: Path, tmp_path: Path) -> None:
    path, root = copied(searched, tmp_path)
    one, other = systems_of(root).searches
    # A search; an end of the other one, which is known without it, and what was tried between.
    keys = one.systems[2].key, other.systems[0].key
    for each in (root / "searches" / f"{other.name}.json", *(root / "points" / f"{key[:24]}.h5" for key in keys)):
        each.unlink()
    kept = files(root)
    tasks = begin(Sweep.read(path), root)
    assert not any(found.complete for found in c.sweep_status(root).crossings)
    assert not any(map(done_before(root), tasks))
    solved(path, root)
    assert all(map(done_before(root), tasks))
    assert kept.items() <= files(root).items()
    assert files(root).keys() == files(searched / "out" / "many").keys()
    for name in files(root).keys() - kept.keys():
        same(root / "points" / name, searched / "out" / "many" / "points" / name)
    assert c.sweep_status(root).crossings == c.sweep_status(searched / "out" / "many").crossings


def test_a_search_belongs_to_one_shard_and_goes_on_where_it_was_stopped(
    searched: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = described(tmp_path)
    root = tmp_path / "out" / "many"
    parts = [begin(Sweep.read(path), root, shard=(i, 3)) for i in (1, 2, 3)]
    assert [len(part) for part in parts] == [1, 1, 0]
    solve, count = crossings.solve_system, iter(range(100))

    def stopped(folder: Path, task: SystemTask) -> None:
        if next(count) == 4:
            raise KeyboardInterrupt
        solve(folder, task)

    monkeypatch.setattr(crossings, "solve_system", stopped)
    with pytest.raises(KeyboardInterrupt):
        solve_task(root, parts[0][0])
    monkeypatch.undo()
    one, other = c.sweep_status(root).crossings
    assert {one.bracket.trials, other.bracket.trials} == {0, 4}
    assert one.status == other.status == "not done"
    assert len(systems_of(root).systems) == 4 + 3  # ends, and what was tried or begun
    kept = files(root)
    (mine,) = begin(Sweep.read(path), root, threads=2, shard=(1, 3))
    solve_task(root, mine)
    assert kept.items() <= files(root).items()
    expected = {one.name: one for one in c.sweep_status(searched / "out" / "many").crossings}[mine.path.stem]
    assert expected in c.sweep_status(root).crossings
    assert files(root).keys() < files(searched / "out" / "many").keys()


def test_what_does_not_cross_is_said_and_the_others_go_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At l_a = 0.01 the load is -0.01307 on one surface, and -0.01304 on the other: its ends are enough."""
    search = SEARCH.replace("-0.005", "-0.01305").replace("0.002, to = 0.02,", "0.0075, to = 0.01,")
    path = described(tmp_path, SEARCHES.replace(SEARCH, search))
    for again in (False, True):
        assert main(["sweep", "run", str(path), "-o", str(tmp_path)]) == 1
        said = capsys.readouterr()
        assert f"{0 if again else 2} searches done, {2 if again else 0} were done before, 0 failed" in said.out
        assert "seed 4, hurst 0.8, rms_slope 0.1: no crossing between 0.0075 and 0.01: load is -0.0" in said.err
        assert "seed 3" not in said.err
    three, four = c.sweep_status(tmp_path / "many").crossings
    assert (three.found, four.found, four.complete, four.bracket.trials) == (True, False, True, 2)
    assert np.isnan(four.value)
    with xarray.open_dataset(c.sweep_collect(tmp_path / "many").files[1], engine="h5netcdf") as cube:
        assert list(np.isnan(cube["crossing"]).values.ravel()) == [False, True]
        assert cube["crossing_trials"].values.ravel().tolist() == [three.bracket.trials, 2]


def test_a_failed_trial_ends_its_search_with_the_reason_and_is_tried_again_on_request(
    searched: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, root = copied(searched, tmp_path)
    (root / "points" / f"{collect(root).listing.searches[0].systems[3].key[:24]}.h5").unlink()

    def failing(folder: Path, task: SystemTask) -> None:
        raise InputError("no such luck")

    monkeypatch.setattr(crossings, "solve_system", failing)
    first, second = begin(Sweep.read(path), root)
    failed = second if done_before(root)(first) else first
    with pytest.raises(TrialError, match=r"at adhesion_length 0\.00\d+: InputError: no such luck") as caught:
        solve_task(root, failed)
    record(root, TaskResult(failed, 0.0, f"{type(caught.value).__name__}: {caught.value}", caught.value))
    monkeypatch.undo()
    found = c.sweep_status(root)
    assert [one.found for one in found.crossings] == [False, True]
    assert found.left == 0, "a further run would do nothing"
    assert "failed: TrialError: at adhesion_length" in found.crossings[0].status
    assert [label for label, _ in found.failed] == ["seed 3, hurst 0.8, rms_slope 0.1"]
    again = c.sweep(path, root.parent)
    assert (again.total, again.found, len(again.crossings)) == (1, 1, 1)
    (task,) = (each for each in begin(Sweep.read(path), root, retry=True) if not done_before(root)(each))
    solve_task(root, task)
    assert all(one.found for one in c.sweep_status(root).crossings)
    assert not list((root / "failed").iterdir())


def test_a_damaged_trial_is_named_and_done_again_once_it_is_moved_away(searched: Path, tmp_path: Path) -> None:
    path, root = copied(searched, tmp_path)
    point = root / "points" / f"{systems_of(root).searches[1].systems[0].key[:24]}.h5"
    whole = point.read_bytes()
    point.write_bytes(whole[:5000])
    with pytest.warns(LeftOutWarning):
        found = c.sweep_collect(root)
    assert len(found.faults) == 1
    assert [one.found for one in found.crossings] == [True, False]
    assert point.name in c.sweep_status(root).crossings[1].status
    (task,) = (each for each in begin(Sweep.read(path), root) if not done_before(root)(each))
    with pytest.raises(OutputError, match="sweep verify --aside") as caught:
        solve_task(root, task)
    record(root, TaskResult(task, 0.0, str(caught.value), caught.value))
    assert not list((root / "failed").iterdir()), "it says nothing about the search"
    assert c.sweep_verify(root, aside=True).files == 10
    solved(path, root)
    same(point, searched / point.relative_to(path.parent))


def test_a_finer_search_and_another_value_keep_what_is_there(
    searched: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, root = copied(searched, tmp_path)
    kept, before = files(root), c.sweep_status(root).crossings
    finer = path.read_text().replace("tolerance = 0.5", "tolerance = 0.25")
    path.write_text(finer)
    assert main(["sweep", "status", str(root), "--why", str(path)]) == 0
    said = capsys.readouterr().out
    assert "new systems: 0, the same: 10" in said
    assert "'tolerance': 0.25" in said
    solved(path, root)
    found = c.sweep_status(root)
    assert (found.total, found.done, found.others) == (12, 12, 0)
    assert kept.items() <= files(root).items()
    for one, earlier in zip(found.crossings, before, strict=True):
        assert earlier.bracket.lower <= one.bracket.lower < one.bracket.upper <= earlier.bracket.upper
    path.write_text(finer.replace("crosses = -0.005", "crosses = -0.0051"))
    warned = list[str]()
    for task in begin(Sweep.read(path), root, warn=warned.extend):
        solve_task(root, task)
    assert "no longer listed: 8" in warned[0]
    assert kept.items() <= files(root).items()
    assert [one.found for one in c.sweep_status(root).crossings] == [True, True]


def test_a_search_is_replaced_by_values_and_by_another_and_stands_in_the_folder_as_it_was_run(tmp_path: Path) -> None:
    other = {"bisect": "load_att at 140 %", "from": 0, "to": 0.01, "tolerance": 0.5, "scale": "linear", "crosses": 1e-4}
    reduced = f'[sweep.reduced]\n"{KEY}" = {SEARCH.replace("0.5 }", "0.4 }")}\n"surface.seed" = 3\n'
    path = described(tmp_path, SEARCHES + reduced)
    listed = Sweep.read(path, {KEY: [0.001, 0.002]})
    assert listed.bisection is None
    assert sum(1 for _ in listed.systems()) == 4
    assert [plan.settings[KEY] for plan, _ in Sweep.read(path, {KEY: 0.003}).systems()] == [0.003, 0.003]
    assert {row[0]: row[1] for row in c.check(path, reduced=True).sheet.rows}["systems"] == "5"
    for given in ({KEY: other}, {"surface.seed": 5, KEY: other}):
        changed = Sweep.read(path, given)
        assert changed.bisection is not None
        assert (changed.bisection.target, changed.bisection.first, changed.bisection.scale) == (1.4, 0.0, "linear")
        (tmp_path / "again.toml").write_text(changed.text)
        again = Sweep.read(tmp_path / "again.toml")
        assert again.bisection == changed.bisection
        assert [plan.key for plan, _ in again.systems()] == [plan.key for plan, _ in changed.systems()]
    # A list makes room for a search.
    instead = Sweep.read(path, {KEY: 0.003, "surface.rms_slope": 0.1, "surface.hurst": 0.8})
    assert instead.bisection is None
    script = c.sweep_slurm(path, settings={KEY: other})
    assert 'bisect = "load_att at 140 %"' in script
    with pytest.raises(ConfigError, match="one of step, factor and count"):
        Sweep.read(path, {"surface.hurst": other})


def test_the_list_of_systems_does_not_depend_on_how_far_a_search_is(searched: Path, tmp_path: Path) -> None:
    path, root = copied(searched, tmp_path)
    begin(Sweep.read(path), root)
    assert (root / "systems.json").read_text() == (searched / "out" / "many" / "systems.json").read_text()
    data = json.loads((root / "systems.json").read_text())
    assert len(data["systems"]) == 4
    (root / "searches" / f"{systems_of(root).searches[0].name}.json").write_text("[damaged")
    assert len(systems_of(root).systems) == 2 + 5
    assert crossings_of(root, systems_of(root))[0].status == "not done"
    solved(path, root)
    assert len(systems_of(root).systems) == 10


@pytest.mark.long
def test_kills_at_random_moments_lose_nothing(searched: Path, tmp_path: Path) -> None:
    path = described(tmp_path)
    chance = random.Random(1)
    for attempt in range(4):
        root = tmp_path / f"{attempt}" / "many"
        words = ["sweep", "run", str(path), "-o", str(root.parent), "--workers", "2"]
        command = [sys.executable, "-m", "continuum", *words]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        most = chance.randrange(1, 9)
        while process.poll() is None and len(list((root / "points").glob("*.h5"))) < most:
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        time.sleep(1)
        assert c.sweep_verify(root).ok
        kept = files(root)
        assert c.sweep(path, root.parent, workers=2).ok
        assert kept.items() <= files(root).items()
        for point in (root / "points").iterdir():
            same(point, searched / "out" / "many" / "points" / point.name)
        assert files(root).keys() == files(searched / "out" / "many").keys()
