"""Whole runs: stored, resumed as if nothing had happened, honest about what failed; the command."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import continuum as c
from continuum.front.cli import main
from continuum.inputs.errors import OutputError
from continuum.inputs.reading import load
from continuum.model.walls import LennardJonesSpline
from continuum.show.plot import written_as
from continuum.store import datasets as store
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import StoreError
from continuum.store.runs import run
from continuum.store.runs.build import build
from continuum.store.runs.config import RunConfig
from continuum.store.runs.result import Result
from continuum.store.runs.run import follow_run
from tests.kinds import covering
from tests.problems import SMALL
from tests.stored import ENGINES, content, opens_in_xarray, same, stop_after


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The path of ``small``, solved once."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "small.toml").write_text(SMALL)
    assert follow_run(load(folder / "small.toml", RunConfig), folder / "whole.h5").converged
    return folder / "whole.h5"


@pytest.fixture
def whole(small: Path, solved: Path) -> Path:
    return Path(shutil.copy(solved, small.with_name("whole.h5")))


def test_a_result_holds_what_is_needed(small: Path, whole: Path) -> None:
    file = store.read_datasets(whole, RunConfig.result_schema, RunConfig.result_version)
    assert file.attributes["config"] == SMALL
    assert file.attributes["seed"] == 3
    assert file.attributes["realised_rms_slope"] == pytest.approx(0.1, rel=1e-12)
    assert {"provenance/numpy", "provenance/stickiness", "journal/written"} <= set(file.attributes)
    assert list(file["branch"]) == ["start", "approach", "approach", "retract", "retract"]
    assert file["restart/gap"].dtype == np.float64  # a longer path goes on from here
    # Maps, areas and loads belong to the stored gaps.
    wall = 1 + float(file.attributes["wall_range"])
    for i, gap in enumerate(file["gap"]):
        masks = [store.unpack(file[name][i], 30) for name in ("repulsive", "attracted")]
        clear = np.abs(gap - 1) > 1e-5  # gaps are stored in single precision
        np.testing.assert_array_equal(masks[0][clear], (gap < 1)[clear])
        assert file["area_rep"][i] == masks[0].mean()
        assert file["area_att"][i] == masks[1].mean()
        assert not (masks[1] & (gap > wall + 1e-5)).any()
    np.testing.assert_allclose(file["load"], file["load_rep"] - file["load_att"], atol=1e-15)


ONE = {
    "grid": {"n": 32},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 32.0, "seed": 3},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "repulsive-area", "targets": [0.05]},
}
"""One point of a small grid."""


def test_the_file_of_one_point_holds_nothing_twice_and_nothing_empty(tmp_path: Path) -> None:
    path = tmp_path / "one.h5"
    returned, read = c.run(ONE, path), Result.read(path)
    assert path.stat().st_size <= 26_000  # of the 49 532 before
    np.testing.assert_equal([*map(vars, returned.points)], [*map(vars, read.points)])
    assert (returned.events, returned.config) == ((), read.config)
    assert dict(read.attributes) == dict(returned.attributes)
    assert {name.partition("/")[0] for name in store.dataset_names(path) if "/" in name} == {"journal"}
    opens_in_xarray(path, None)
    # A file that has lost its jumps says how many they were.
    with h5py.File(path, "r+") as file:
        file.attrs["jumps"] = 1
    with pytest.raises(StoreError, match="lacks events/step"):
        Result.read(path)


def test_the_one_point_of_a_small_grid_is_found_again_when_its_path_grows(tmp_path: Path) -> None:
    longer = {"loading.targets": [0.05, 0.1]}
    c.run(ONE, tmp_path / "grown.h5")
    assert c.run(ONE, tmp_path / "grown.h5", settings=longer).resumed == 0
    c.run(ONE, tmp_path / "alone.h5", settings=longer)
    same(tmp_path / "grown.h5", tmp_path / "alone.h5")
    with pytest.raises(OutputError, match="holds another result"):
        c.run(ONE, tmp_path / "grown.h5")


def test_the_work_of_several_grids_is_stored_of_each(tmp_path: Path) -> None:
    path = c.run(ONE | {"loading": {"control": "mean-gap", "targets": [1.5]}}, tmp_path, settings={"grid.n": 256}).path
    file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version)
    assert file["work/nx"].tolist() == [[256, 128, 64]]
    weighted = (file["work/nx"] * file["work/ny"] * file["work/fft_pairs"]).sum(axis=1) / 256**2
    np.testing.assert_allclose(weighted, file["fft_pairs"])
    assert (file["journal/fft_seconds"].sum(axis=1) <= file["journal/solve_seconds"]).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_xarray_opens_every_group_of_it(whole: Path, engine: str) -> None:
    opens_in_xarray(whole, engine)


@pytest.mark.parametrize(("points", "error"), covering([1, 4], [RuntimeError, KeyboardInterrupt]))
def test_a_run_that_was_stopped_goes_on_as_if_it_had_not(
    small: Path, whole: Path, points: int, error: type[BaseException]
) -> None:
    path = small.with_name("stopped.h5")
    config = load(small, RunConfig)
    with pytest.raises(error):
        follow_run(config, path, progress=stop_after(points, error))
    file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version)
    assert not file.attributes["finished"]
    assert file["step"].size == points
    summary = follow_run(config, path)
    assert summary.resumed == points
    same(path, whole)


def test_a_run_is_written_once_a_second_not_after_each_of_its_points(
    small: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock on which each look takes a tenth of a second: five points take about one, and the last is written."""
    written, store_write, looks = [], store.write, count()
    monkeypatch.setattr(run, "time", SimpleNamespace(perf_counter=lambda: 0.1 * next(looks)))
    monkeypatch.setattr(store, "write", lambda *what: (written.append(what[1]["step"].values.size), store_write(*what)))
    assert len(follow_run(load(small, RunConfig), small.with_name("fast.h5")).points) == 5
    assert written[-1] == 5
    assert len(written) <= 2


def test_a_run_that_was_killed_goes_on(small: Path, whole: Path) -> None:
    path = small.with_name("killed.h5")
    # It waits after each point to be killed, longer than the time between two writes.
    code = (
        "import sys, time; from pathlib import Path\n"
        "from continuum.store.runs.config import RunConfig; from continuum.inputs.reading import load\n"
        "from continuum.store.runs.run import follow_run\n"
        "follow_run(load(sys.argv[1], RunConfig), Path(sys.argv[2]), progress=lambda *_: time.sleep(1.1))"
    )
    process = subprocess.Popen([sys.executable, "-c", code, str(small), str(path)])
    for _ in range(300):
        if path.exists():
            break
        time.sleep(0.1)
    os.kill(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert not store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version).attributes["finished"]
    assert follow_run(load(small, RunConfig), path).resumed >= 1
    same(path, whole)
    assert not list(small.parent.glob(".*.tmp"))


def test_what_is_stored_beside_a_finished_path_is_made_of_its_file(
    small: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    beside = {"more": lambda system, record: Dataset(np.arange(len(record.points)), ("step",), "1", "more")}
    config, before = load(small, RunConfig), content(whole)
    monkeypatch.setattr(run, "follow", lambda *given: pytest.fail("a stored path is solved again"))
    assert follow_run(config, whole, added=beside).resumed == 5
    after = content(whole)
    assert after.pop("more").tolist() == [0, 1, 2, 3, 4]
    assert after.keys() == before.keys()
    monkeypatch.setattr(store, "write", lambda *given: pytest.fail("it is there"))
    assert follow_run(config, whole, added=beside).resumed == 5


def test_threads_do_not_change_results(small: Path, whole: Path) -> None:
    small.write_text(SMALL.replace("[output]", "[solver]\nthreads = 2\n[output]"))
    path = small.with_name("threads.h5")
    follow_run(load(small, RunConfig), path)
    same(path, whole)


def test_another_run_in_the_way_is_left_alone(small: Path, whole: Path) -> None:
    before = whole.read_bytes()
    small.write_text(SMALL.replace("seed = 3", "seed = 4"))
    with pytest.raises(OutputError, match="holds another result"):
        follow_run(load(small, RunConfig), whole)
    assert whole.read_bytes() == before
    assert follow_run(load(small, RunConfig), whole, force=True).resumed == 0


def test_points_that_did_not_converge_are_stored_and_told(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small.write_text(SMALL.replace("[output]", "[solver]\nmax_iterations = 4\n[output]"))
    assert main(["run", str(small), "-o", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert out.count("iteration limit") >= 1
    file = store.read_datasets(tmp_path / "small.h5", RunConfig.result_schema, RunConfig.result_version)
    failed = file["status"] == "ITERATION_LIMIT"
    assert failed.any()
    assert (file["residual"][failed] > file.attributes["tolerance"]).all()
    assert main(["plot", str(tmp_path / "small.h5")]) == 0
    assert (tmp_path / "small-area-and-load.png").is_file()


def test_the_command_runs_checks_and_draws(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check", "small.toml"]) == 0
    out = capsys.readouterr().out
    for words in ("24 x 30", "0.3464", "states of the path", "MiB"):
        assert words in out
    assert list(tmp_path.iterdir()) == [small]
    assert main(["run", "small.toml"]) == 0
    out = capsys.readouterr().out
    for point in range(1, 6):  # no terminal: a line with the time for each point
        assert f"small {point}/5  mean gap" in out
    assert out.count("20") >= 5
    with written_as(["png", "pdf"]):
        assert main(["plot", "results/small.h5"]) == 0
    for path in capsys.readouterr().out.split():
        assert Path(path).read_bytes().startswith(b"\x89PNG")
        assert Path(path).with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    assert main(["plot", "small.toml"]) == 2


@pytest.mark.parametrize(
    "surface",
    [
        'kind = "sine"\namplitude = 0.3\nwaves = [1, 2]',
        'kind = "sphere"\nradius = 40.0',
        'kind = "file"\npath = "heights.npy"',
        'kind = "file"\npath = "heights.txt"',
        'kind = "file"\npath = "heights.h5"\ndataset = "h"',
    ],
)
def test_every_kind_of_surface_runs(small: Path, surface: str) -> None:
    import h5py

    heights = 0.3 * np.random.default_rng(2).normal(size=(24, 30))
    np.save(small.with_name("heights.npy"), heights)
    np.savetxt(small.with_name("heights.txt"), heights.T)  # x along a line
    with h5py.File(small.with_name("heights.h5"), "w") as file:
        file["h"] = heights
    start = SMALL.index("kind =")
    small.write_text(SMALL[:start] + surface + "\n" + SMALL[SMALL.index("\n[wall]") :])
    summary = follow_run(load(small, RunConfig), small.with_name("result.h5"))
    assert summary.converged
    assert any(step.load != 0 for step in summary.points)


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ("wall", 'law = "table"\npath = "wall.txt"'),
        ("substrate", 'response = "layer"\ndepth = 10.0\npoisson = 0.5\nmean = "clamped"'),
        ("substrate", 'response = "crystal"\nc11 = 1.03\nc12 = 0.515\nc44 = 0.515\ndepth = 8.0\nmean = 0.13'),
    ],
)
def test_other_walls_and_substrates_run(small: Path, table: str, text: str) -> None:
    law = LennardJonesSpline(0.3)
    gap = np.linspace(0.7, 1.3, 200)
    np.savetxt(small.with_name("wall.txt"), np.column_stack([gap, law.evaluate(gap).traction.round(15)]))
    pieces = re.split(r"(?m)^(?=\[)", SMALL)
    small.write_text("".join(f"[{table}]\n{text}\n\n" if p.startswith(f"[{table}]") else p for p in pieces))
    summary = follow_run(load(small, RunConfig), small.with_name("result.h5"))
    assert summary.converged
    assert any(step.load_att > 0 for step in summary.points)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: np.save(p, np.ones((24, 29))), "shape"),
        (lambda p: np.save(p, np.full((24, 30), np.nan)), "not finite"),
        (lambda p: np.save(p, np.ones((24, 30))), "a slope greater than 0"),
        (lambda p: np.save(p, np.ones((24, 30), dtype=complex)), "real numbers"),
        (lambda p: np.save(p, np.array([[object()]]), allow_pickle=True), "npy"),
        (lambda p: p.write_bytes(b"\x93NUMPY"), "npy"),
    ],
)
def test_heights_that_are_none_are_told(small: Path, make, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    make(small.with_name("heights.npy"))
    start = SMALL.index("kind =")
    surface = 'kind = "file"\npath = "heights.npy"\n'
    small.write_text(SMALL[:start] + surface + SMALL[SMALL.index("\n[wall]") :])
    before = sorted(small.parent.iterdir())
    assert main(["run", str(small), "-o", str(small.parent / "out")]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert f"{small}:" in error
    assert sorted(small.parent.iterdir()) == before


def test_a_run_that_no_memory_holds_is_refused_before_it_starts(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small.write_text(SMALL.replace("n = [24, 30]\nperiod = [24, 30]", "n = 65536"))
    assert main(["run", str(small), "-o", str(small.parent / "out")]) == 2
    assert "GB" in capsys.readouterr().err
    assert list(small.parent.iterdir()) == [small]


@pytest.mark.parametrize(
    ("change", "warned"),
    [
        (("", ""), True),
        (("retract = true", "retract = true\nevent_resolution = 0.1"), False),
        (("retract = true", ""), False),
        (("targets = [1.6, 1.4,\n           1.2]", "targets = { from = 1.4, to = 1.2, step = -0.03 }"), False),
        (('law = "lennard-jones-spline"\nadhesion_length = 0.005', 'law = "hard"'), False),
        (
            (
                'control = "mean-gap"\ntargets = [1.6, 1.4,\n           1.2]',
                'control = "repulsive-area"\ntargets = [0.1, 0.2]',
            ),
            False,
        ),
    ],
)
def test_long_steps_of_a_way_back_are_warned_of(tmp_path: Path, change: tuple[str, str], warned: bool) -> None:
    """A tenth of the range, 0.35 a0, where jumps are not bracketed."""
    assert change[0] in SMALL
    (tmp_path / "run.toml").write_text(SMALL.replace(*change))
    found = build(load(tmp_path / "run.toml", RunConfig)).warnings
    assert any("way back" in each for each in found) == warned
