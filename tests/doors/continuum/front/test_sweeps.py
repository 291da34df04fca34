"""Sweeps at the front door: what the command does, the functions do, and arguments are refused before all is begun."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.front.cli import main
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from continuum.solve.backend import SMOOTH_FIELDS, back_end
from tests.problems import SMALL


@pytest.fixture
def many(tmp_path: Path) -> Path:
    path = tmp_path / "many.toml"
    reduced = '[sweep.reduced]\n"surface.seed" = [1]\n'
    path.write_text(f'{SMALL}[sweep.axes]\n"surface.seed" = [1, 2]\n{reduced}')
    return path


def test_every_action_of_the_command_is_a_function(
    many: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = c.sweep(many, tmp_path, reduced=True)
    assert (done.ok, done.done) == (True, 1)
    root = tmp_path / "many-reduced"
    status = c.sweep_status(root)
    assert (status.total, status.done, status.failed) == (1, 1, ())
    found = c.sweep_collect(root)
    assert found.files == (root / "table.csv", root / "table.h5")
    assert all(path.is_file() for path in found.files)
    np.testing.assert_array_equal(found["load"], done.collect()["load"])
    assert c.sweep_verify(root).ok
    (point,) = (root / "points").iterdir()
    point.write_bytes(point.read_bytes()[:5000])
    checked = c.sweep_verify(str(root), aside=True)
    assert (checked.files, len(checked.faults), checked.ok) == (1, 1, False)
    assert c.sweep_status(root).done == 0
    capsys.readouterr()
    assert main(["sweep", "slurm", str(many), "--nodes", "2", "--set", "surface.seed=[3, 4]"]) == 0
    assert c.sweep_slurm(many, nodes=2, settings={"surface.seed": np.array([3, 4])}) == capsys.readouterr().out


def test_check_takes_a_sweep_as_well_as_a_run(many: Path, tmp_path: Path) -> None:
    rows = {row[0]: row[1] for row in c.check(many).sheet.rows}
    assert rows["systems"] == "2"
    assert {row[0]: row[1] for row in c.check(many, reduced=True).sheet.rows}["systems"] == "1"
    assert c.check(many, {"surface.seed": range(5)}).sheet.rows[0][1] == "5"
    (tmp_path / "one.toml").write_text(SMALL)
    report = c.check(tmp_path / "one.toml", {"surface.seed": np.int64(5)})
    assert report.system is not None
    assert report.system.config.surface.seed == 5
    with pytest.raises(c.ConfigError, match=r"a table \[sweep\]"):
        c.check(tmp_path / "one.toml", reduced=True)


def test_a_run_takes_settings_as_the_command_does(tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(SMALL)
    given = {"surface.seed": np.int64(5), "loading.targets": np.array([1.6, 1.4]), "loading.retract": False}
    result = c.run(tmp_path / "one.toml", tmp_path, settings=given)
    assert result.attributes["seed"] == 5
    assert len(result.points) == 2
    words = ["surface.seed=5", "loading.targets=[1.6, 1.4]", "loading.retract=false"]
    options = [word for text in words for word in ("--set", text)]
    before = result.path.read_bytes()
    assert main(["run", str(tmp_path / "one.toml"), "-o", str(tmp_path), *options]) == 0
    assert result.path.read_bytes() == before, "the command finds the same run done"
    loaded = c.check(tmp_path / "one.toml").system
    assert loaded is not None
    with pytest.raises(ValueError, match="this input was read already"):
        c.run(loaded.config, tmp_path, settings=given)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("memory", -1), ("memory", 0), ("memory", float("nan")), ("memory", "1"),
        ("workers", -1), ("workers", 1.5), ("workers", 10**6), ("threads", 0),
        ("shard", (0, 2)), ("shard", (3, 2)), ("shard", 1), ("shard", (1.0, 2)), ("shard", (1, 0)),
        ("settings", 3), ("settings", {1: 2}), ("settings", ["surface.seed=1"]),
        ("reduced", 1), ("retry", "no"), ("scheduler_file", 3), ("scheduler_file", "none.json"), ("output", 3),
    ],
)  # fmt: skip
def test_an_argument_without_meaning_is_refused_before_anything_is_written(
    name: str, value: Any, many: Path, tmp_path: Path
) -> None:
    given: dict[str, Any] = {"output": tmp_path / "out", name: value}
    with pytest.raises((InputError, ValueError), match=str(value) if value == "none.json" else name):
        c.sweep(many, **given)
    assert sorted(tmp_path.iterdir()) == [many]


@pytest.mark.parametrize(
    ("function", "given", "names"),
    [
        (c.sweep_slurm, {"time": "1\nrm -rf ~"}, "time"),
        (c.sweep_slurm, {"time": 12}, "time"),
        (c.sweep_slurm, {"nodes": 0}, "nodes"),
        (c.sweep_slurm, {"workers": -1}, "workers"),
        (c.sweep_slurm, {"shards": 0}, "shards"),
        (c.sweep_slurm, {"threads": 0}, "threads"),
        (c.sweep_slurm, {"memory": -1.0}, "memory"),
        (c.sweep_slurm, {"device": "abacus"}, "device"),
        (c.sweep_slurm, {"device": "cuda"}, "shards"),
        (c.sweep_slurm, {"partition": "a; rm -rf ~"}, "partition"),
        (c.sweep_slurm, {"account": "a\n#SBATCH --exclusive"}, "account"),
        (c.sweep_slurm, {"modules": ["gcc; rm -rf ~"]}, "modules"),
        (c.sweep_slurm, {"modules": "gcc"}, "modules"),
        (c.sweep_slurm, {"lines": ["a\nb"]}, "lines"),
        (c.check, {"settings": "surface.seed=1"}, "settings"),
        (c.check, {"settings": {"surface.seed": object()}}, "surface.seed = <object"),
        (c.run, {"settings": {"surface.seed": {1, 2}}}, r"surface.seed = \{1, 2\}"),
        (c.run, {"force": "no"}, "force"),
    ],
)
def test_arguments_of_the_other_functions_are_refused_by_name(
    function: Any, given: dict[str, Any], names: str, many: Path, tmp_path: Path
) -> None:
    (tmp_path / "one.toml").write_text(SMALL)
    with pytest.raises(ValueError, match=names):
        function(tmp_path / "one.toml" if function is c.run else many, **given)


@pytest.mark.parametrize("function", [c.sweep_status, c.sweep_collect, c.sweep_verify])
def test_a_folder_that_is_none_of_a_sweep_is_refused(function: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not the folder of a sweep"):
        function(tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_name_of_a_file_cannot_add_to_the_script_of_a_job(many: Path) -> None:
    odd = many.rename(many.with_name("two words\nrm -rf ~.toml"))
    script = c.sweep_slurm(odd)
    assert "#SBATCH --job-name=two-words-rm--rf--\n" in script
    assert script.count("rm -rf ~") == 1, "in the quoted name of the file only"


def test_a_job_asks_for_what_it_is_told_to_ask_for(many: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "--array", "4", "--workers", "2", "--threads", "3", "--memory", "2", "--partition", "short", "--account", "p_7",
        "--module", "gcc/13.2", "--module", "python", "--line", "source ~/venv/bin/activate",
    ]  # fmt: skip
    many.write_text(many.read_text().replace("[1, 2]", "[1, 2, 3, 4, 5, 6, 7, 8]"))
    assert main(["sweep", "slurm", str(many), *words]) == 0
    script = capsys.readouterr().out.splitlines()
    for line in ("cpus-per-task=6", "partition=short", "account=p_7", "array=1-4", "nodes=1", "open-mode=append"):
        assert f"#SBATCH --{line}" in script
    memory = next(int(line[14:-1]) for line in script if line.startswith("#SBATCH --mem="))
    assert 2 * 2e9 < memory * 2**20 < 2 * 2e9 + 2 * 1e9 + 2 * 2**30  # and what Python and a shell need
    at = script.index("module load gcc/13.2")
    assert script[at : at + 3] == ["module load gcc/13.2", "module load python", "source ~/venv/bin/activate"]
    assert script[-1].endswith("--threads 3 --workers 2 --shard $SLURM_ARRAY_TASK_ID/4")
    on_gpus = c.sweep_slurm(many, device="cuda", shards=2, workers=4)
    assert "#SBATCH --gres=gpu:4\n" in on_gpus
    assert "solver.device=" in on_gpus


@pytest.mark.parametrize(
    ("systems", "asked", "given"),
    [
        # Systems; then nodes or jobs, and processes that are asked for, and that a script has.
        (6, {"shards": 3, "workers": 16}, (3, 2)),
        (7, {"shards": 3, "workers": 16}, (3, 3)),
        (7, {"shards": 3, "workers": 2}, (3, 2)),
        (2, {"shards": 4, "workers": 16}, (2, 1)),
        (5, {"nodes": 2, "workers": 16}, (2, 3)),
        (40, {"nodes": 2, "workers": 16}, (2, 16)),
    ],
)
def test_a_job_asks_for_no_more_processes_than_it_has_systems(
    systems: int, asked: dict[str, int], given: tuple[int, int], many: Path
) -> None:
    script = c.sweep_slurm(many, settings={"surface.seed": range(systems)}, **asked)
    over = "array=1-" if "shards" in asked else "nodes="
    for line in (f"{over}{given[0]}", f"cpus-per-task={given[1]}"):
        assert f"#SBATCH --{line}\n" in script
    assert f"workers {given[1]} " in script


def test_a_folder_says_what_was_run_in_it_and_what_is_other_than_before(
    many: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["-o", str(tmp_path / "out")]
    assert main(["sweep", "run", "-q", str(many), *out]) == 0
    root = next((tmp_path / "out").iterdir())
    assert (root / "sweep.toml").read_text() == many.read_text()
    assert "the sweep has changed" not in capsys.readouterr().err
    seeds = c.sweep_status(root).listing.axes[0].values
    given = f"surface.seed=[{seeds[0][0]}, 17]"
    asked = ["sweep", "status", str(root), "--why", str(many)]
    assert main([*asked, "--set", given]) == 0
    assert "would change: new systems: 1, the same: 1, no longer listed: 1" in capsys.readouterr().out
    assert main([*asked, "--set", "surface.hurst=0.3"]) == 0
    assert "none is the same" in capsys.readouterr().out
    assert main(asked) == 0
    assert "would change: nothing" in capsys.readouterr().out
    assert main(["sweep", "run", "-q", str(many), *out, "--set", given]) == 0
    said = capsys.readouterr().err
    assert "new systems: 1, the same: 1" in said
    assert "surface.seed: " in said
    assert "17]" in said
    # What stands there is an input of just these systems.
    again = (root / "sweep.toml").rename(many)
    listed = (root / "systems.json").read_text()
    assert main(["sweep", "run", str(again), *out]) == 0
    assert "0 systems done, 2 were done before" in capsys.readouterr().out
    assert (root / "systems.json").read_text() == listed


def test_a_sweep_begins_from_a_template_of_which_every_line_is_valid(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["init", "sweep"]) == 0
    text = capsys.readouterr().out
    plain, whole = tmp_path / "plain.toml", tmp_path / "whole.toml"
    plain.write_text(text)
    assert {row[0]: row[1] for row in c.check(plain).sheet.rows}["systems"] == "3"
    run, marked, axes = text.partition("\n# --- a sweep")
    keys = "\n".join(line.removeprefix("# ") if "=" in line or "[" in line else line for line in axes.splitlines()[1:])
    whole.write_text(run + keys.replace("A list, or a range", "# a range"))
    (tmp_path / "mine.py").write_text("def largest_patch(result):\n    return 0.0\n")
    # Three seeds, three adhesion lengths on the larger grid, as the smaller is not kept; of the reduced one seed.
    assert {row[0]: row[1] for row in c.check(whole).sheet.rows}["searches"] == "9"
    assert {row[0]: row[1] for row in c.check(whole, reduced=True).sheet.rows}["searches"] == "3"
    assert {row[0]: row[1] for row in c.check(whole).sheet.rows}["systems"] == str(9 * (2 + 4))
    assert marked


def test_as_many_workers_as_the_memory_of_the_gpus_holds(
    many: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two cards, each with the memory of two processes and a half, of the larger of two systems."""

    class BegunError(Exception):
        pass

    def begun(tasks: list[Any]) -> None:
        raise BegunError

    many.write_text(SMALL + '[sweep.axes]\n"grid.n" = [[24, 30], [48, 60]]\n')
    larger = 1e9 + 8 * SMOOTH_FIELDS * 48 * 60
    cards = back_end("cpu")
    monkeypatch.setattr(cards, "devices", lambda: ("0", "1"))
    monkeypatch.setattr(cards, "memory", lambda: 2.5 * larger)
    with pytest.raises(ArgumentError, match="workers = 5: allowed: at most 4: 2 for each of 2 GPUs"):
        c.sweep(many, tmp_path / "results", workers=5, begun=begun)
    assert not (tmp_path / "results").exists()
    with pytest.raises(BegunError):
        c.sweep(many, tmp_path / "results", workers=4, begun=begun)
