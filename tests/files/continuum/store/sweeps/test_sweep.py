"""Sweeps: what a description amounts to; kills, two drivers and broken files lose nothing and stop nothing else."""

from __future__ import annotations

import json
import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import psutil
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st

import continuum
from continuum.front.cli import main
from continuum.inputs.errors import InputError, OutputError
from continuum.inputs.toml import ConfigError
from continuum.model.surfaces import SelfAffineSurface
from continuum.paper.points import sweep_points
from continuum.solve.backend import back_end
from continuum.store import datasets as store
from continuum.store.hdf5 import UnreadError
from continuum.store.runs.config import RunConfig, expand_range
from continuum.store.sweeps import axes
from continuum.store.sweeps import sweep as sweeping
from continuum.store.sweeps.axes import Sweep, label_of
from continuum.store.sweeps.collect import LeftOutWarning, Verification, collect, sweep_verify
from continuum.store.sweeps.conditions import condition, holds, values_of
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.measured import numbers_of
from continuum.store.sweeps.status import sweep_status
from continuum.store.sweeps.sweep import begin, solve_system
from tests.problems import SMALL
from tests.stored import content, same

PLAIN = SMALL.replace("1.4,\n           1.2", "1.4").replace("retract = true", "").replace("fields = true", "")


def described(folder: Path, sweep: str, text: str = PLAIN) -> Path:
    path = folder / "many.toml"
    path.write_text(text + sweep)
    return path


def settings(path: Path, **options: Any) -> list[dict[str, object]]:
    return [dict(plan.settings) for plan, _ in Sweep.read(path, **options).systems()]


SEEDS = '[sweep.axes]\n"surface.seed" = [1, 2, 3]\n'


def test_a_key_that_follows_from_an_axis_is_not_taken_from_the_first_system(tmp_path: Path) -> None:
    """The period is that of the points where it is not given: each system has its own."""
    path = described(tmp_path, '[[sweep.zipped]]\n"grid.n" = [[24, 30], [48, 60]]\n"surface.lambda_L" = [12.0, 24.0]\n')
    path.write_text(re.sub(r"^period = .*$", "", path.read_text(), flags=re.MULTILINE))
    begin(Sweep.read(path), tmp_path / "many")
    listed = systems_of(tmp_path / "many")
    assert "grid.period" not in listed.common
    assert listed.common["surface.hurst"] == 0.8
    table = continuum.sweep(path, tmp_path).collect()
    assert sorted(set(sweep_points(table).area)) == [24 * 30, 48 * 60]


def test_a_sweep_of_no_system_is_one_message_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = described(tmp_path, '[sweep]\nkeep = ["seed > 5"]\n' + SEEDS)
    for action in (["run"], ["slurm"]):
        assert main(["sweep", *action, str(path), "-o", str(tmp_path / "out")]) == 2
        assert "at least one system meets" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


UNSUITED = [
    ('"wall" = [{law = "hard"}]', "wall.law=hard", "values for the axis wall as it is, not for wall.law"),
    (
        '"surface.seed" = [1, 2]',
        'surface={kind="sphere",radius=9.0}',
        "the axis surface.seed as it is, not for surface",
    ),
    ('"surface.seed" = [1, 2]', "surface.seed={from=1,to=2}", "one of step, factor and count"),
    (
        '"surface.seed" = [1, 2]',
        "surface.seed={from=" + "1" * 400 + ",to=2,step=1}",
        "one of step, factor and count",
    ),
    ('"surface.seed" = [1, 2]', "surface.seed=[]", "at least one value of surface.seed"),
    ('"surface.lambda_s" = [6.0, 7.0]', "surface.lambda_s=[6, 6.0]", "different values of surface.lambda_s"),
    ('"surface.seed" = [1, 2]', "surface.seed=3 # more", 'surface.seed = "3 # more"'),
    ('"surface.seed" = [1, 2]', "surface.seed=3\n[solver]\nthreads = 2", "surface.seed = "),
    ('"surface.seed" = [1, 2]', "surface.hurst=0.5\nsurface.seed = 7", "surface.hurst = "),
    (
        '"surface.seed" = [1, 2]\n"surface.hurst" = {from = 0.1, to = 0.9, count = 2000}',
        "surface.seed={from=1,to=1000,step=1}",
        "at most 1000000 systems, not 2000000",
    ),
]


def test_a_setting_that_does_not_suit_an_axis_is_one_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for sweep, setting, says in UNSUITED:
        path = described(tmp_path, f"[sweep.axes]\n{sweep}\n")
        assert main(["check", str(path), "--set", setting]) == 2
        assert says in capsys.readouterr().err


BESIDE = [
    ("surface.seed=[4, 5]", [4, 5], []),
    ("sweep.axes.surface.seed=[4, 5]", [4, 5], []),
    ('sweep.axes."surface.seed"={from = 4, to = 6, step = 1}', [4, 5, 6], []),
    ("sweep.axes.surface.hurst=[0.3, 0.5]", [1, 2, 3], [0.3, 0.5]),
    ('sweep.axes={"surface.hurst" = [0.3, 0.5]}', [], [0.3, 0.5]),
    ('sweep.keep=["seed > 1"]', [2, 3], []),
]


def test_axes_and_conditions_can_be_given_beside_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for setting, seeds, hursts in BESIDE:
        path = described(tmp_path, "[sweep.axes]\nsurface.seed = [1, 2, 3]\n")
        assert main(["check", str(path), "--set", setting]) == 0
        name, _, value = setting.partition("=")
        found = settings(path, settings={name: tomllib.loads(f"x = {value}")["x"]})
        assert list(dict.fromkeys(one["surface.hurst"] for one in found if "surface.hurst" in one)) == hursts
        assert list(dict.fromkeys(one["surface.seed"] for one in found if "surface.seed" in one)) == seeds
        assert f" systems {len(found)} " in " ".join(capsys.readouterr().out.split())


def test_a_table_of_a_sweep_that_is_none_is_one_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for text in ("[sweep]\naxes = 3\n", "[sweep]\nzipped = 3\n", "[sweep]\nreduced = 3\n"):
        path = described(tmp_path, text)
        assert main(["check", str(path), "--reduced", "--set", "surface.seed=[4, 5]"]) == 2
        assert "allowed: " in capsys.readouterr().err


def test_keys_that_change_together_are_set_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = described(tmp_path, '[[sweep.zipped]]\n"surface.seed" = [1, 2, 3]\n"surface.hurst" = [0.3, 0.5, 0.8]\n')
    assert main(["check", str(path), "--set", "surface.seed=[1, 2]"]) == 2
    assert "of one length where keys change together" in capsys.readouterr().err
    assert main(["check", str(path), "--set", "surface.seed=[1, 2]", "--set", "surface.hurst=[0.3, 0.5]"]) == 0


def test_a_table_can_be_an_axis_and_is_set_as_a_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = described(
        tmp_path, '[sweep.axes]\n"wall" = [{law = "hard"}, {law = "lennard-jones-9-3", adhesion_length = 0.005}]\n'
    )
    (one, _), (other, _) = Sweep.read(path).systems()
    assert (label_of(one.settings), label_of(other.settings)) == (
        'wall {law = "hard"}', 'wall {law = "lennard-jones-9-3", adhesion_length = 0.005}'
    )  # fmt: skip
    assert settings(path, settings={"wall": {"law": "hard"}}) == [{"wall": {"law": "hard"}}]
    given = ["--set", 'wall={law = "hard"}', "--set", "loading.targets={from = 1.6, to = 1.4, count = 2}"]
    assert main(["sweep", "slurm", str(path), *given]) == 0
    # What the script sets is what was set.
    line = next(line for line in capsys.readouterr().out.splitlines() if "--set" in line)
    assert [word for word in shlex.split(line) if "=" in word and word.startswith(("wall", "load"))] == given[1::2]
    path.write_text(PLAIN + '[sweep.axes]\n"wall" = [{law = "hard"}]\n"wall.law" = ["hard"]\n')
    assert main(["check", str(path)]) == 2
    assert "axes that are apart: wall holds wall.law" in capsys.readouterr().err


def test_check_counts_the_states_of_all_systems_before_any_is_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = described(tmp_path, SEEDS + '[sweep.reduced]\n"surface.seed" = [1, 2]\n')
    one = next(Sweep.read(path).systems())[1].loading.points
    for options, systems in ((), 3), (("--reduced",), 2), (("--set", "surface.seed=[4]"), 1):
        assert main(["check", str(path), *options]) == 0
        shown = {line[:36].strip(): line[36:].split() for line in capsys.readouterr().out.splitlines() if line[36:]}
        assert shown["systems"] == [str(systems)]
        assert shown["states of their paths"] == [str(systems * one)]
    assert sorted(tmp_path.iterdir()) == [path]
    assert main(["check", str(path), "--set", "surface.seed=[-4]"]) == 2
    assert "surface.seed = -4" in capsys.readouterr().err


def test_a_sweep_on_a_gpu_that_is_not_there_is_one_message_and_begins_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def missing() -> None:
        raise InputError("there is no GPU here that can be used")

    monkeypatch.setattr(back_end("cpu"), "require", missing)
    assert main(["sweep", "run", str(described(tmp_path, SEEDS)), "--device", "cpu"]) == 2
    assert "there is no GPU here" in capsys.readouterr().err
    assert not (tmp_path / "results").exists()
    with pytest.raises(ConfigError, match="device"):
        continuum.sweep(described(tmp_path, SEEDS), device="abacus")


# --- descriptions --------------------------------------------------------------------------------------------


def test_axes_combine_zipped_keys_change_together_and_conditions_choose(tmp_path: Path) -> None:
    found = settings(described(tmp_path, """[sweep]
keep = ["lambda_s * 2 <= surface.lambda_L", "not (seed == 2 and lambda_s > 5)"]
[sweep.axes]
surface.seed = {from = 1, to = 3, step = 1}
[[sweep.zipped]]
"surface.lambda_s" = [4.0, 6.0, 7.0]
"surface.rms_slope" = [0.1, 0.2, 0.3]
"""))  # fmt: skip
    pairs = [(s["surface.seed"], s["surface.lambda_s"], s["surface.rms_slope"]) for s in found]
    assert pairs == [(1, 4.0, 0.1), (1, 6.0, 0.2), (2, 4.0, 0.1), (3, 4.0, 0.1), (3, 6.0, 0.2)]


NUMBERS = st.integers(-(10**20), 10**20).map(str) | st.floats(-1e300, 1e300).map(repr)
TERMS = NUMBERS | st.sampled_from(["seed", "n", "kind", "surface.hurst", "None", "True", "'text'", "1j", "nothing"])
BINARY = st.sampled_from(["+", "-", "*", "/", "**", "<", "<=", "==", "!=", "and", "or"])
CONDITIONS = st.recursive(
    TERMS,
    lambda inner: (
        st.tuples(inner, BINARY, inner).map(lambda three: f"({' '.join(three)})")
        | st.tuples(st.sampled_from(["-", "not "]), inner).map(lambda two: f"({''.join(two)})")
    ),
    max_leaves=30,
)


@given(CONDITIONS)
def test_any_condition_holds_or_not_or_is_refused_at_once(text: str) -> None:
    """Powers of powers of 1e300 must not take forever: nothing here takes longer than arithmetic of floats."""
    data = {"grid": {"n": (24, 30)}, "surface": {"kind": "self-affine", "seed": 3, "hurst": 0.8}}
    try:
        found = holds(condition(text), values_of(data))
    except ValueError:
        return
    assert isinstance(found, bool)


def test_a_sweep_of_one_system_without_axes_is_collected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = described(tmp_path, '[sweep]\nkeep = ["seed > 0"]\n')
    assert main(["sweep", "run", str(path), "-o", str(tmp_path), "-q"]) == 0
    assert main(["sweep", "collect", str(tmp_path / "many")]) == 0
    with xarray.open_dataset(tmp_path / "many" / "table.h5", engine="h5netcdf") as table:
        assert table["load_net"].dims == ("step",)
        assert not np.isnan(table["load_net"]).any()
    (system,) = systems_of(tmp_path / "many").systems
    assert system.label == "the one system"


@given(st.integers(-50, 50), st.integers(1, 7), st.integers(0, 30))
def test_a_range_of_steps_ends_where_it_says(first: int, step: int, count: int) -> None:
    assert expand_range({"from": first, "to": first + step * count, "step": step} if count else (first,)) == tuple(
        range(first, first + step * count + 1, step)
    )
    decimal = expand_range({"from": first / 10, "to": (first + step * (count + 1)) / 10, "step": step / 10})
    assert len(decimal) == count + 2
    powers = expand_range({"from": 0.5, "to": 0.5 * 2.0**count, "factor": 2.0})
    np.testing.assert_allclose(powers, 0.5 * 2.0 ** np.arange(count + 1), rtol=1e-12)


FAULTY = [
    ("", "add a table [sweep] with axes"),
    ('[sweep.axes]\n"surface.seed" = 3\n', "a list of values, or a range"),
    ('[sweep.axes]\n"surface.seed" = []\n', "at least one value"),
    ('[sweep.axes]\n"surface.seed" = [1, 1]\n', "the same one twice"),
    ('[sweep.axes]\n"surface.lambda_s" = [6, 6.0]\n', "the same one twice"),
    ('[sweep.axes]\n"wall" = [{law = "hard"}, {"law" = "hard"}]\n', "the same one twice"),
    (
        '[sweep.axes]\n"grid.n" = [24, [24, 24]]\n"grid.period" = [24.0]\n',
        "n 24, period 24.0 and n [24, 24], period 24.0 are one and the same",
    ),
    ('[sweep.axes]\n"solver.threads" = [1, 2]\n', "threads 1 and threads 2 are one and the same"),
    ('[[sweep.zipped]]\n"surface.seed" = [1, 1]\n"grid.n" = [8, 8]\n', "different values of surface.seed"),
    ('[sweep.axes]\n"surface.seed" = {from = 1, to = 9}\n', "one of step, factor and count"),
    ('[sweep.axes]\n"surface.seed" = {from = 1, to = 9, step = -1}\n', "leads from the first to the last value"),
    ('[sweep.axes]\n"surface.seed" = {from = 1, to = 9, count = 10000000000000}\n', "at most 1000000 values"),
    ('[sweep.axes]\n"surface.seed" = {from = 1, to = 9, factor = 1.0000000001}\n', "at most 1000000 values"),
    ('[sweep.axes]\n"surface.sed" = [1, 2]\n', "did you mean seed?"),
    ('[sweep.axes]\n"surface.seed" = [1, -2]\n', "surface.seed = -2"),
    ('[[sweep.zipped]]\n"surface.seed" = [1, 2]\n"grid.n" = [8]\n', "lists of one length"),
    (f'{SEEDS}[[sweep.zipped]]\n"surface.seed" = [1, 2]\n', "each key on one axis only"),
    (f"[sweep]\nkeep = [\"__import__('os')\"]\n{SEEDS}", "no Call"),
    (f'[sweep]\nkeep = ["seed <"]\n{SEEDS}', "it cannot be read"),
    (f'[sweep]\nkeep = ["sed < 3"]\n{SEEDS}', "sed is not a key"),
    (f'[sweep]\nkeep = ["seed / 0 < 3"]\n{SEEDS}', "a condition that holds or not"),
    (f'[sweep]\nkeep = ["9**9**9 > seed"]\n{SEEDS}', "a number is larger than 1e308"),
    (f'[sweep]\nkeep = ["(10**300)**(10**300) > seed"]\n{SEEDS}', "a condition that holds or not"),
    (f'[sweep]\nkeep = ["9.0**9**9 > seed"]\n{SEEDS}', "a number is larger than 1e308"),
    (f"[sweep]\nkeep = [\"'a'*10**9*99 == kind\"]\n{SEEDS}", "numbers only can be added and multiplied, not 'a'"),
    (f'[sweep]\nkeep = ["kind * 10**9 == kind"]\n{SEEDS}', "numbers only can be added and multiplied"),
    (f'[sweep]\nkeep = ["{"-" * 990}1 < seed"]\n{SEEDS}', "a condition"),
    (f'[sweep]\nkeep = ["{"+".join("1" * 9000)} < seed"]\n{SEEDS}', "more than 1000"),
    (f'[sweep]\nkeep = ["1"]\n{SEEDS}', "it names no key"),
    (f'[sweep]\nkeep = ["seed"]\n{SEEDS}', "seed is 1, not a comparison"),
    (f'[sweep]\nkeep = ["seed > 0 and lambda_s"]\n{SEEDS}', "lambda_s is 6.0, not a comparison"),
    (f"[sweep]\nkep = []\n{SEEDS}", "did you mean keep?"),
    ('[sweep.axes]\n"surface.seed" = {from = 1, to = 9999999, step = 1}\n', "at most 1000000 values"),
    (
        '[sweep.axes]\n"surface.seed" = {from = 1, to = 2000, step = 1}\n'
        '"surface.lambda_s" = {from = 4.0, to = 5.0, count = 1000}\n',
        "at most 1000000 systems",
    ),
]


def test_a_faulty_description_is_one_message_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for sweep, says in FAULTY:
        path = described(tmp_path, sweep)
        assert main(["sweep", "run", str(path), "-o", str(tmp_path / "out")]) == 2
        assert says in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_values_may_be_given_elsewhere(tmp_path: Path) -> None:
    path = described(tmp_path, f'{SEEDS}[sweep.reduced]\n"surface.seed" = [7]\n"surface.hurst" = 0.5\n')
    assert settings(path) == [{"surface.seed": seed} for seed in (1, 2, 3)]
    assert settings(path, reduced=True) == [{"surface.seed": 7}]
    assert settings(path, settings={"surface.seed": (4, 5)}) == [{"surface.seed": 4}, {"surface.seed": 5}]
    ((_, config),) = Sweep.read(path, reduced=True).systems()
    assert isinstance(config.surface, SelfAffineSurface)
    assert config.surface.hurst == 0.5


@pytest.mark.parametrize("command", ["run", "threshold"])
def test_the_input_of_a_sweep_is_told_from_that_of_a_run(
    tmp_path: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, str(described(tmp_path, SEEDS)), "-o", str(tmp_path)]) == 2
    assert "this is the input of a sweep: use `continuum sweep run`" in capsys.readouterr().err
    (tmp_path / "one.toml").write_text(PLAIN)
    assert main(["sweep", "run", str(tmp_path / "one.toml"), "-o", str(tmp_path)]) == 2
    assert "this is the input of a single run: use `continuum run`" in capsys.readouterr().err


def test_a_run_takes_values_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "one.toml"
    path.write_text(PLAIN)
    assert main(["run", str(path), "-o", str(tmp_path), "--set", "surface.seed=5", "--set", "wall.range=0.2"]) == 2
    assert "exactly one of adhesion_length and range" in capsys.readouterr().err
    assert main(["run", str(path), "-o", str(tmp_path), "--set", "surface.seed=5"]) == 0
    assert continuum.Result.read(tmp_path / "one.h5").attributes["seed"] == 5
    with pytest.raises(SystemExit):
        main(["run", str(path), "--set", "surface.seed"])


# --- runs ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of three seeds with and without adhesion, done in this process."""
    folder = tmp_path_factory.mktemp("sweep")
    path = described(folder, f'{SEEDS}"wall.adhesion_length" = [0.0, 0.005]\n')
    root = folder / "out" / "many"
    for task in begin(Sweep.read(path), root):
        solve_system(root, task)
    return folder


def copied(undisturbed: Path, tmp_path: Path) -> tuple[Path, Path]:
    shutil.copytree(undisturbed, tmp_path / "copy")
    return tmp_path / "copy" / "many.toml", tmp_path / "copy" / "out" / "many"


def test_a_table_has_every_point_and_xarray_sees_the_axes(undisturbed: Path, tmp_path: Path) -> None:
    path, root = copied(undisturbed, tmp_path)
    found = continuum.sweep(path, root.parent)
    assert (found.total, found.found, found.done) == (6, 6, 0)
    table = found.collect()
    assert table.values.shape[0] == 6 * 2
    assert set(table["surface.seed"]) == {1, 2, 3}
    assert set(table["surface.lambda_s"]) == {6.0}
    assert main(["sweep", "collect", str(root)]) == 0
    rows = (root / "table.csv").read_text().splitlines()
    assert rows[0].startswith("system,surface.seed,wall.adhesion_length,step,")
    assert len(rows) == 13
    with xarray.open_dataset(root / "table.h5", engine="h5netcdf") as cube:
        assert cube["kappa_rep"].dims == ("surface.seed", "wall.adhesion_length", "step")
        run = continuum.Result.read(root / "points" / f"{table.keys[1][:24]}.h5")
        assert cube["load_net"].sel({"surface.seed": 1, "wall.adhesion_length": 0.005, "step": 1}) == run.points[1].load
        assert cube["load_net"].attrs["units"] == "E*"
        # A point of the table is what an analysis of the run measures.
        number = continuum.analyse(run.path).points[1].numbers
        assert float(cube["diameter"].values[0, 1, 1]) == number.diameter


def test_an_axis_that_grows_keeps_what_is_there(undisturbed: Path, tmp_path: Path) -> None:
    path, root = copied(undisturbed, tmp_path)
    before = {point.name: point.stat().st_mtime_ns for point in (root / "points").iterdir()}
    path.write_text(path.read_text().replace("[1, 2, 3]", "[0, 1, 2]"))
    tasks = begin(Sweep.read(path), root)
    assert sum(not task.path.exists() for task in tasks) == 2
    assert {p.name: p.stat().st_mtime_ns for p in (root / "points").iterdir()} == before
    found = sweep_status(root)
    assert (found.total, found.done, found.others) == (6, 4, 2)


def test_shards_share_the_work_and_the_longest_come_first(undisturbed: Path, tmp_path: Path) -> None:
    path, root = copied(undisturbed, tmp_path)
    parts = [begin(Sweep.read(path), root, shard=(i, 4)) for i in (1, 2, 3, 4)]
    assert sorted(len(part) for part in parts) == [1, 1, 2, 2]
    assert len({task.path for part in parts for task in part}) == 6
    costs = [task.cost for task in begin(Sweep.read(path), root)]
    assert costs == sorted(costs, reverse=True)


def test_broken_files_are_one_message_each_and_verify_finds_all(
    undisturbed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, root = copied(undisturbed, tmp_path)
    points = sorted((root / "points").iterdir())
    whole = {point: point.read_bytes() for point in points}
    points[0].write_bytes(whole[points[0]][:5000])  # truncated
    flipped = bytearray(whole[points[1]])
    flipped[flipped.index(np.float64(numbers_of(points[1]).table[0][3]).tobytes())] ^= 1  # one bit of a number
    points[1].write_bytes(flipped)
    shutil.copy(points[5], points[2])  # another system
    points[3].write_text("{}")
    with h5py.File(points[4], "r+") as file:
        file.attrs["schema_version"] = 2  # of an older program
    capsys.readouterr()
    assert main(["sweep", "collect", str(root)]) == 1
    said = capsys.readouterr()
    assert said.err.count("warning: ") >= 4
    assert "version 2, expected" in said.err
    assert "Traceback" not in said.err
    assert main(["sweep", "verify", str(root)]) == 1
    assert "6 files, 5 of them damaged" in capsys.readouterr().out
    assert main(["sweep", "verify", str(root), "--aside"]) == 1
    assert f"5 of them damaged; 5 moved to {root / 'damaged'}; `continuum sweep run`" in capsys.readouterr().out
    assert {path.name for path in (root / "damaged").iterdir()} == {path.name for path in points[:5]}
    assert sum(not task.path.exists() for task in begin(Sweep.read(path), root)) == 5  # which are done again
    assert sweep_verify(root) == Verification(1, ())


def test_status_names_a_system_that_was_stopped(undisturbed: Path, tmp_path: Path) -> None:
    _, root = copied(undisturbed, tmp_path)
    assert sweep_status(root).stopped == ()
    point = next((root / "points").iterdir())
    point.rename(root / "work" / point.name)
    found = sweep_status(root)
    assert (found.done, found.left, len(found.stopped)) == (5, 1, 1)
    assert " stored" in found.stopped[0]
    assert any("stopped, to be continued" in map(str, row) for row in found.sheets()[0].rows)


def test_a_file_that_is_held_is_no_damage(
    undisturbed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another process writes one file and this one reads another: one is left out, with a warning, and none moved."""
    _, root = copied(undisturbed, tmp_path)
    points = sorted((root / "points").iterdir())
    opened = store.opened

    def held(path: Path) -> Any:
        if path == points[0]:
            raise UnreadError(f"{path}: held")
        return opened(path)

    with h5py.File(points[1], locking=False):
        assert len(collect(root).keys) == 6
        monkeypatch.setattr(store, "opened", held)
        with pytest.warns(LeftOutWarning, match=f"1 of 6 files.*{points[0].name}: held"):
            found = collect(root)
        assert len(found.keys) == 5
        assert "1 files LEFT OUT" in repr(found)
        with pytest.warns(LeftOutWarning):
            found.means()
        checked = sweep_verify(root, aside=True)
    assert (checked.faults, len(checked.unread), checked.ok) == ((), 1, False)
    assert sorted((root / "points").iterdir()) == points
    assert main(["sweep", "verify", str(root)]) == 1
    assert "0 of them damaged, 1 could not be read now" in capsys.readouterr().out


def test_what_fails_is_recorded_stops_nothing_and_is_tried_again_on_request(tmp_path: Path) -> None:
    """A wall that is too stiff for its table: known only when the table is read."""
    (tmp_path / "bad.txt").write_text("1 2\n")
    (tmp_path / "good.txt").write_text("0.8 0.1\n1.0 0.0\n1.3 -0.01\n2.0 0.0\n")
    law = SMALL.index('law = "lennard'), SMALL.index("[substrate]")
    text = PLAIN.replace(SMALL[slice(*law)], 'law = "table"\npath = "good.txt"\n\n')
    path = described(tmp_path, '[sweep.axes]\n"wall.path" = ["good.txt", "bad.txt"]\n', text)
    root = tmp_path / "out" / "many"
    done = continuum.sweep(path, root.parent)
    assert (done.done, len(done.failed)) == (1, 1)
    ((label, reason),) = sweep_status(root).failed
    assert "bad.txt" in label
    assert "bad.txt" in reason + done.failed[0].reason
    again = continuum.sweep(path, root.parent)
    assert (again.total, again.found) == (1, 1)
    assert len(continuum.sweep(path, root.parent, retry=True).failed) == 1
    table = collect(root)
    assert (len(table.keys), table.missing) == (1, 1)


def test_a_folder_that_cannot_be_written_to_is_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = described(tmp_path, SEEDS)
    (tmp_path / "file").write_text("in the way")
    assert main(["sweep", "run", str(path), "-o", str(tmp_path / "file")]) == 2
    assert "cannot make a folder for results there" in capsys.readouterr().err
    root = tmp_path / "out" / "many"
    tasks = begin(Sweep.read(path), root)

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    for task in tasks:
        with pytest.raises(OutputError, match="No space left"):
            solve_system(root, task)
    monkeypatch.undo()
    assert not list((root / "points").iterdir())
    assert all(entry.name.endswith((".lock", ".h5")) for entry in (root / "work").iterdir())
    assert main(["sweep", "status", str(tmp_path)]) == 2
    assert "is not the folder of a sweep" in capsys.readouterr().err


# --- kills ---------------------------------------------------------------------------------------------------


DRIVER = """
import signal, sys
# A test runner that was itself started in the background ignores these, and so do all that it starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from continuum.front.cli import main
sys.exit(main())
"""


def driver(path: Path, root: Path, *options: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-c", DRIVER, "sweep", "run", str(path), "-o", str(root.parent), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)


def workers_of(process: subprocess.Popen[bytes]) -> list[int]:
    """Its processes that solve systems."""
    children = psutil.Process(process.pid).children()
    return [
        child.pid for child in children if any("continuum.store.sweeps.workers" in word for word in child.cmdline())
    ]


def until_some_are_done(root: Path, process: subprocess.Popen[bytes], count: int) -> None:
    while process.poll() is None and sum(1 for _ in (root / "points").glob("*.h5")) < count:
        time.sleep(0.02)


@pytest.mark.long  # signals that can be heard: test_stopping.py; processes that are gone: test_engine.py
@pytest.mark.parametrize("victim", ["a worker", "the driver"])
def test_a_kill_loses_nothing(victim: str, undisturbed: Path, tmp_path: Path) -> None:
    path, root = copied(undisturbed, tmp_path)
    shutil.rmtree(root)
    root.mkdir()
    (root / "points").mkdir()
    process = driver(path, root, "--workers", "2")
    until_some_are_done(root, process, 2)
    workers = [psutil.Process(worker) for worker in workers_of(process)]
    os.kill(workers[0].pid if victim == "a worker" else process.pid, signal.SIGKILL)
    process.communicate()
    assert not psutil.wait_procs(workers, timeout=30)[1], "they end with their driver"
    kept = {point.name: point.stat().st_mtime_ns for point in (root / "points").iterdir()}
    done = continuum.sweep(path, root.parent)
    assert done.ok
    assert (done.found, done.done) == (len(kept), 6 - len(kept))
    assert {name: (root / "points" / name).stat().st_mtime_ns for name in kept} == kept
    for point in (root / "points").iterdir():
        same(point, undisturbed / point.relative_to(path.parent))


@pytest.mark.long  # of these, what a queue sends is in test_stopping.py as well
@pytest.mark.parametrize("how", ["kill", "Ctrl-C", "the terminal is closed"])
def test_what_stops_a_sweep_stops_its_workers(how: str, tmp_path: Path) -> None:
    path = described(tmp_path, SEEDS.replace("[1, 2, 3]", "{from = 1, to = 400, step = 1}"))
    root = tmp_path / "out" / "many"
    process = driver(path, root, "--workers", "2")
    until_some_are_done(root, process, 2)
    workers = workers_of(process)
    if how == "kill":  # as a queue does
        process.terminate()
    else:
        # A terminal tells all that it runs.
        os.killpg(process.pid, signal.SIGINT if how == "Ctrl-C" else signal.SIGHUP)
    said = process.communicate(timeout=120)[0].decode()
    number = {"kill": signal.SIGTERM, "Ctrl-C": signal.SIGINT, "the terminal is closed": signal.SIGHUP}[how]
    assert process.returncode == 128 + number
    assert "the same command continues from there" in said
    assert "Traceback" not in said
    assert "Warning" not in said
    assert not any(psutil.pid_exists(worker) for worker in workers)
    assert sweep_verify(root).ok


@pytest.mark.long
def test_two_drivers_share_a_folder(undisturbed: Path, tmp_path: Path) -> None:
    path, root = copied(undisturbed, tmp_path)
    shutil.rmtree(root)
    both = [driver(path, root) for _ in range(2)]
    said = [process.communicate()[0].decode() for process in both]
    assert "Traceback" not in "".join(said)
    # A driver that ends first may have met what the other had in hand, and says so.
    assert all(p.returncode == 0 or "locked by another process" in text for p, text in zip(both, said, strict=True))
    counts = [int(found) for text in said for found in re.findall(r"(\d+) systems done", text)]
    assert len(counts) == 2
    assert sum(counts) >= 6, said  # one that the other has just done counts for both
    for point in (root / "points").iterdir():
        same(point, undisturbed / point.relative_to(path.parent))
    assert sweep_verify(root) == Verification(6, ())


@pytest.mark.long
@pytest.mark.parametrize("victim", ["a worker", "all workers", "the driver"])
def test_kills_at_random_moments_of_forty_systems(victim: str, tmp_path: Path) -> None:
    path = described(tmp_path, SEEDS.replace("[1, 2, 3]", "{from = 1, to = 40, step = 1}"))
    reference = tmp_path / "one" / "many"
    assert continuum.sweep(path, reference.parent, workers=2).ok
    chance = random.Random(victim)
    for attempt in range(5):
        root = tmp_path / f"{attempt}" / "many"
        process = driver(path, root, "--workers", "2")
        until_some_are_done(root, process, chance.randrange(1, 36))
        time.sleep(chance.random())
        victims = [process.pid] if victim == "the driver" else workers_of(process)[: 1 if victim == "a worker" else 9]
        for one in victims:
            os.kill(one, signal.SIGKILL)
        process.communicate()
        assert sweep_verify(root).ok
        kept = {point.name for point in (root / "points").iterdir()}
        done = continuum.sweep(path, root.parent, workers=2)
        assert done.ok
        assert (done.found, done.done) == (len(kept), 40 - len(kept))
        for point in (root / "points").iterdir():
            same(point, reference / "points" / point.name)


@pytest.mark.long
def test_ten_thousand_systems_are_listed_resumed_and_collected_in_seconds(undisturbed: Path, tmp_path: Path) -> None:
    """Their files are made of one that was solved: what is measured is the engine."""
    path = described(tmp_path, SEEDS.replace("[1, 2, 3]", "{from = 1, to = 10000, step = 1}"))
    root = tmp_path / "out" / "many"
    began = time.perf_counter()
    tasks = begin(Sweep.read(path), root)
    listed = time.perf_counter() - began
    from continuum.store import datasets as store
    from continuum.store.runs.config import RunConfig

    solve_system(root, tasks[0])
    file = store.read_datasets(tasks[0].path, RunConfig.result_schema, RunConfig.result_version)
    few = {name: file.datasets[name] for name in ("measured", "quantity")}
    for task in tasks[1:]:
        store.write(task.path, few, {**file.attributes, "identity": task.plan.key})
    began = time.perf_counter()
    assert continuum.sweep(path, tmp_path / "out").found == 10000
    resumed = time.perf_counter() - began
    began = time.perf_counter()
    table = collect(root)
    collected = time.perf_counter() - began
    assert len(table.keys) == 10000
    sys.stdout.write(json.dumps({"listed": listed, "resumed": resumed, "collected": collected}))
    # "Seconds": a minute allows for a machine that is ten times slower.
    assert max(listed, resumed, collected) < 60


def test_content_is_compared(undisturbed: Path) -> None:
    """The comparison of these tests sees the numbers, not only the maps."""
    point = next((undisturbed / "out" / "many" / "points").iterdir())
    assert "measured" in content(point)
    with pytest.raises(ConfigError):
        Sweep.read(undisturbed / "absent.toml")


def test_a_sweep_that_was_listed_by_this_version_is_not_listed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor is a listing believed that has a system under another identity."""
    monkeypatch.setattr(sweeping, "provenance", lambda: {"provenance/stickiness": "1.0"})
    path, parsed = described(tmp_path, '[sweep.axes]\n"surface.seed" = [1, 2, 3]\n'), list[object]()
    first = begin(Sweep.read(path), tmp_path / "many")
    real = axes.parsed
    monkeypatch.setattr(axes, "parsed", lambda source, model: (parsed.append(model), real(source, model))[1])
    again = begin(Sweep.read(path), tmp_path / "many")
    assert [*map(vars, again)] == [*map(vars, first)]
    assert RunConfig not in parsed
    solve_system(tmp_path / "many", again[0])
    listing = tmp_path / "many" / "systems.json"
    listing.write_text(listing.read_text().replace(again[1].plan.key, "0" * 64))
    (task,) = (one for one in begin(Sweep.read(path), tmp_path / "many") if one.plan.key == "0" * 64)
    with pytest.raises(OutputError, match="another system"):
        solve_system(tmp_path / "many", task)
    # Another version, or other values, are listed anew.
    monkeypatch.setattr(sweeping, "provenance", lambda: {"provenance/stickiness": "1.1"})
    begin(Sweep.read(path), tmp_path / "many")
    assert RunConfig in parsed
