"""Sweeps at the front door: what the command does, the functions do, and arguments are refused before all is begun."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.cli import main
from continuum.errors import InputError
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
        ("workers", 0), ("workers", -1), ("workers", 1.5), ("workers", 10**6), ("threads", 0),
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


@pytest.mark.parametrize("function", [c.check, c.run, c.sweep, c.sweep_slurm])
def test_a_file_that_is_none_is_refused_by_name(function: Any) -> None:
    with pytest.raises(ValueError, match="file = 3"):
        function(3)


@pytest.mark.parametrize("function", [c.sweep_status, c.sweep_collect, c.sweep_verify])
def test_a_folder_that_is_none_of_a_sweep_is_refused(function: Any, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="sweep = 3"):
        function(3)
    with pytest.raises(InputError, match="is no folder of a sweep"):
        function(tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_name_of_a_file_cannot_add_to_the_script_of_a_job(many: Path) -> None:
    odd = many.rename(many.with_name("two words\nrm -rf ~.toml"))
    script = c.sweep_slurm(odd)
    assert "#SBATCH --job-name=two-words-rm--rf--\n" in script
    assert script.count("rm -rf ~") == 1, "in the quoted name of the file only"
