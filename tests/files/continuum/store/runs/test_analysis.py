"""The analysis of stored runs."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from continuum.front.cli import main
from continuum.inputs.reading import load
from continuum.store.runs.config import RunConfig
from continuum.store.runs.result import Result
from continuum.store.runs.run import follow_run
from continuum.theory import paper


def test_a_run_with_fields_is_measured_whole(small: Path, tmp_path: Path) -> None:
    result = tmp_path / "small.h5"
    summary = follow_run(load(small, RunConfig), result)
    found = Result.read(result).analyse()
    assert not found.notes
    assert len(found.points) == len(summary.points) == 5
    for point, step in zip(found.points, summary.points, strict=True):
        assert point.numbers.area_rep == step.area_rep
        assert point.patch_areas.sum() == pytest.approx(step.area_rep * found.result.grid.area)
        assert point.fields is not None
        assert point.fields.areas.repulsive == pytest.approx(step.area_rep, abs=1e-12)
        assert point.fields.areas.attracted == pytest.approx(step.area_att, abs=1e-12)
        assert point.fields.pressures is not None
        p = point.fields.pressures
        share, middle = p.density * np.diff(p.edges), (p.edges[1:] + p.edges[:-1]) / 2
        assert np.sum(share * middle) == pytest.approx(step.load, abs=np.diff(p.edges)[0])
    expected = found.expected
    assert expected.diameter == paper.contact_diameter(expected.rms_slope, expected.rms_curvature)
    assert found.adhesion is not None
    assert found.adhesion.peak_load == max(step.load for step in summary.points)
    *each, whole = found.sheets()
    assert [len(sheet.rows) for sheet in each] == [5] * 4
    assert len(whole.rows) == 11


@pytest.mark.long
def test_the_command_prints_and_draws(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    follow_run(load(small, RunConfig), tmp_path / "small.h5")
    assert main(["analyse", str(tmp_path / "small.h5"), "-o", str(tmp_path / "figures")]) == 0
    out = capsys.readouterr().out
    assert "d_rep" in out
    assert "pull-off" in out
    names = {path.name for path in (tmp_path / "figures").glob("*.png")}
    assert names == {f"small-{name}.png" for name in ("patches", "sizes", "gap-profile", "distributions")}


def test_a_run_without_fields_says_what_to_do(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small.write_text(small.read_text().replace("fields = true", "fields = false"))
    follow_run(load(small, RunConfig), tmp_path / "small.h5")
    assert main(["analyse", str(tmp_path / "small.h5")]) == 0
    assert "set fields = true in [output]" in capsys.readouterr().out
    assert all(point.fields is None for point in Result.read(tmp_path / "small.h5").analyse().points)


def test_a_stored_run_knows_its_wall_when_the_file_of_it_is_gone(small: Path, tmp_path: Path) -> None:
    """And under a hard wall, whose traction does not follow from the gap, there is no distribution of pressures."""
    text = small.read_text()
    law = 'law = "lennard-jones-spline"\nadhesion_length = 0.005'
    (tmp_path / "wall.txt").write_text("0.5 1.0\n1.0 0.0\n1.2 -0.01\n1.5 0.0\n")
    for name, other in (("table", 'law = "table"\npath = "wall.txt"'), ("hard", 'law = "hard"')):
        small.write_text(text.replace(law, other))
        follow_run(load(small, RunConfig), tmp_path / f"{name}.h5")
        if name == "table":
            (tmp_path / "wall.txt").unlink()
        found = Result.read(tmp_path / f"{name}.h5").analyse()
        assert any("no distribution of pressures" in note for note in found.notes) == (name == "hard")
        for point in found.points:
            assert point.fields is not None
            assert (point.fields.pressures is None) == (name == "hard")
            assert point.fields.areas.repulsive == pytest.approx(point.numbers.area_rep, abs=1e-12)


def test_a_point_whose_work_was_searched_for_is_measured_under_its_own_wall(small: Path, tmp_path: Path) -> None:
    loading = {"control": "repulsive-area", "targets": [0.04], "threshold": 0.1}
    found = follow_run(load(small, RunConfig, {"loading": loading}), tmp_path / "small.h5").analyse()
    (point,) = found.points
    assert point.point.work_of_adhesion != found.result.wall.work_of_adhesion
    assert point.fields is not None
    assert point.fields.areas.attracted == pytest.approx(point.point.area_att, abs=1e-12)


def test_points_that_failed_are_left_out(small: Path, tmp_path: Path) -> None:
    small.write_text(small.read_text() + "\n[solver]\nmax_iterations = 2\n")
    follow_run(load(small, RunConfig), tmp_path / "small.h5")
    found = Result.read(tmp_path / "small.h5").analyse()
    assert any("did not converge" in note for note in found.notes)
    assert len(found.points) < 5
    assert dataclasses.is_dataclass(found)


def test_what_is_no_run_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["analyse", str(tmp_path / "none.h5")]) == 2
    assert "no such file" in capsys.readouterr().err
