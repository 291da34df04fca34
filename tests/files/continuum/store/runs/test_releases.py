"""What earlier versions stored is read, checked and continued: one small sweep of each, as that version left it.

A release adds its own, the sweep of this version, by ``python -m tests.files.continuum.store.runs.test_releases 1.0``.
"""

from __future__ import annotations

import shutil
import sys
import tarfile
import tempfile
from pathlib import Path

import numpy as np
import pytest

import continuum as c
from continuum.front.cli import main
from continuum.inputs.errors import OutputError
from continuum.store.datasets import read_few
from continuum.store.provenance import made_by
from continuum.store.runs.result import Result
from continuum.store.sweeps.listing import systems_of

RELEASES = Path(__file__).with_name("releases")
ROUGH = """
[grid]
n = 16
[surface]
kind = "self-affine"
hurst = 0.8
rms_slope = 0.1
lambda_s = 8.0
lambda_L = 16.0
seed = 3
[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005
[substrate]
response = "half-space"
mean = "clamped"
[loading]
control = "repulsive-area"
targets = [0.05, 0.2]
"""
SWEEP = f'{ROUGH}[sweep.axes]\n"surface.seed" = [3]\n'


@pytest.fixture(params=sorted(RELEASES.iterdir()), ids=lambda path: path.name.removesuffix(".tar.xz"))
def old(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """The folder of the sweep of a version, beside its input."""
    with tarfile.open(request.param) as stored:
        stored.extractall(tmp_path / "release", filter="data")
    (tmp_path / "release.toml").write_text(SWEEP)
    (tmp_path / "run.toml").write_text(ROUGH)
    return tmp_path / "release"


def written(point: Path) -> tuple[str, str]:
    """The version that stored a file; version and commit in the words of a message."""
    names = ("provenance/stickiness", "provenance/git_commit", "provenance/git_dirty")
    stored = read_few(point, (), names)[1]
    return str(stored["provenance/stickiness"]), made_by(stored)


def test_a_sweep_of_an_earlier_version_goes_on(old: Path, tmp_path: Path) -> None:
    (point,) = (old / "points").iterdir()
    before = point.read_bytes()
    said = list[str]()
    done = c.sweep(old.with_suffix(".toml"), tmp_path, settings={"surface.seed": [3, 4]}, warn=said.extend)
    assert (done.done, done.found) == (1, 1)
    assert point.read_bytes() == before
    # Defaults have changed since the first development version only.
    assert any("other defaults, which held until" in each for each in said) is (written(point)[0] == "0.1.0")
    assert c.sweep_verify(old).ok
    assert c.certify(old, sample=2).ok
    assert {system.key[:24] for system in systems_of(old).systems} == {path.stem for path in (old / "points").iterdir()}
    table = done.collect()
    assert len(table["load"]) == 4
    # Those of this version: either meets the area to 1 %, and repulsion is nearly proportional to it.
    now = c.sweep(old.with_suffix(".toml"), tmp_path, settings={"surface.seed": [3, 4]}, name="now").collect()
    np.testing.assert_allclose(table["area_rep"], now["area_rep"], rtol=0.02)
    np.testing.assert_allclose(table["load_rep"], now["load_rep"], rtol=0.03)


def test_a_run_of_an_earlier_version_is_this_one_and_grows(old: Path, tmp_path: Path) -> None:
    (point,) = (old / "points").iterdir()
    path = Path(shutil.copy(point, tmp_path / "run.h5"))
    said = list[str]()
    assert c.run(tmp_path / "run.toml", path, warn=said.extend).resumed == 2
    assert path.read_bytes() == point.read_bytes()
    assert any("held until" in each for each in said) is (written(point)[0] == "0.1.0")
    assert Result.read(path).to_xarray()["load_net"].size == 2
    longer = {"loading.targets": [0.05, 0.2, 0.3]}
    grown = c.run(tmp_path / "run.toml", path, settings=longer)
    assert grown.resumed == 2
    alone = c.run(tmp_path / "run.toml", tmp_path / "alone.h5", settings=longer)
    # Both meet the area to 1 %, from two states that did.
    assert grown.points[-1].load_rep == pytest.approx(alone.points[-1].load_rep, rel=0.03)


def test_a_refusal_names_what_differs_and_both_versions(
    old: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (point,) = (old / "points").iterdir()
    path = Path(shutil.copy(point, tmp_path / "run.h5"))
    changes = {"surface.hurst": 0.7, "loading.targets": [0.1], "wall.core": 0.8}
    with pytest.raises(OutputError) as caught:
        c.run(tmp_path / "run.toml", path, settings=changes)
    lines = str(caught.value).splitlines()
    assert set(lines[1:4]) == {
        "    surface.hurst = 0.7, stored 0.8",
        "    loading.targets = [0.1], stored [0.05, 0.2]",
        "    wall.core = 0.8, stored 0.7",
    }
    made = written(point)[1]
    assert f"stored by {made}; this is version" in lines[4]
    law = {"law": "exponential", "surface_energy": 0.01, "decay_length": 0.3, "core_stiffness": 1.0}
    with pytest.raises(OutputError) as caught:
        c.run(tmp_path / "run.toml", path, settings={"wall": law})
    assert '    wall.law = "exponential", stored "lennard-jones-spline"' in str(caught.value)
    words = ["sweep", "run", str(old.with_suffix(".toml")), "-o", str(tmp_path), "--set", "surface.hurst=0.7"]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert "surface.hurst: 0.8, now 0.7" in error
    assert f"{made}; this is version" in error
    assert {each.name for each in old.iterdir()} == {"points", "sweep.toml", "systems.json"}


def store_release(name: str) -> Path:
    """The sweep of this version, as a file for :data:`RELEASES`."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "release.toml").write_text(SWEEP)
        root = c.sweep(Path(folder) / "release.toml", folder).folder
        path = RELEASES / f"{name}.tar.xz"
        with tarfile.open(path, "w:xz", preset=9) as file:
            for each in ("points", "sweep.toml", "systems.json"):
                file.add(root / each, each)
    return path


if __name__ == "__main__":
    sys.stdout.write(f"{store_release(sys.argv[1])}\n")
