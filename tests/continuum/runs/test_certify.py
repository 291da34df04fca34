"""Certificates: sound states are sound, whatever the law and the control, and what was forged is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import continuum as c
from continuum.cli import main
from continuum.files import store
from continuum.files.store import File
from continuum.measure.certificate import check_state
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from tests.problems import SMALL

LAWS = (
    {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    {"law": "lennard-jones-spline", "range": 0.0},
    {"law": "exponential", "surface_energy": 0.005, "decay_length": 0.3, "core_stiffness": 5.0},
    {"law": "attraction-on-core", "shape": "spline", "adhesion_length": 0.005, "effective_range": 0.3,
     "core_stiffness": 5.0},
    {"law": "hard"},
)  # fmt: skip
LOADING = {"control": "repulsive-area", "targets": [0.05, 0.15]}


def stored(folder: Path, fields: bool = True, **settings: object) -> Path:
    (folder / "small.toml").write_text(SMALL)
    given = {"loading": LOADING, "output.fields": fields, **settings}
    return c.run(folder / "small.toml", folder / "small.h5", settings=given, force=True).path


@pytest.mark.parametrize("fields", [True, False])
@pytest.mark.parametrize("wall", LAWS, ids=lambda wall: f"{wall['law']}")
def test_states_of_every_law_are_sound_stored_or_found_again(
    wall: dict[str, object], fields: bool, tmp_path: Path
) -> None:
    found = c.certify(stored(tmp_path, fields, wall=wall))
    assert found.ok, found.faults
    assert len(found.points) == 2
    assert all(point.again is not fields for point in found.points)
    if not fields and wall["law"] == "lennard-jones-spline":
        for point in found.points:  # in double precision: rounding of transforms and differences
            assert point.found.residual == pytest.approx(point.point.residual, rel=1e-2)
            assert point.found.load == pytest.approx(point.point.load, abs=1e-12)


def forged(path: Path, name: str, change: Callable[[Real], Real]) -> Path:
    """The file with one dataset changed, and sound sums."""
    file: File = store.read_datasets(path, "stickiness/continuum-run", 3)
    datasets = {**file.datasets, name: replace(file.datasets[name], values=change(file[name].copy()))}
    new = path.with_name("forged.h5")
    store.write(new, datasets, file.attributes)
    return new


@pytest.mark.parametrize(
    ("name", "change", "word"),
    [
        ("area_rep", lambda values: values * 1.001, "A_rep/A0"),
        ("load", lambda values: values + 1e-5, "N/A0"),
        ("gap", lambda gap: gap + np.float32(1e-4) * np.sin(np.arange(gap.shape[1]))[:, None], "residual"),
        ("gap", lambda gap: gap[:, ::-1], "residual"),
    ],
)
def test_what_was_forged_is_told(name: str, change: Callable[[Real], Real], word: str, tmp_path: Path) -> None:
    found = c.certify(forged(stored(tmp_path), name, change))
    assert not found.ok
    assert all(any(word in fault for fault in point.faults) for point in found.points)


def test_a_solver_that_solves_another_problem_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The response is half a per cent too stiff when the path is followed, and right when it is certified."""
    stiff = ContactProblem.stiffness_q
    monkeypatch.setattr(
        ContactProblem, "stiffness_q", property(lambda self: 1.005 * self.substrate.stiffness(self.grid))
    )
    path = stored(tmp_path)
    monkeypatch.setattr(ContactProblem, "stiffness_q", stiff)
    assert any("residual" in fault for fault in c.certify(path).faults)


def test_a_saddle_has_a_displacement_along_which_the_energy_falls() -> None:
    """A flat surface in the middle of its attraction, which waves longer than π E*/s tear apart."""
    grid = c.Grid((40, 36), (40.0, 36.0))
    wall = c.LennardJonesSpline(adhesion_length=0.05)
    gap = np.full(grid.shape, 1.0 + 0.7 * wall.range)
    problem = ContactProblem(grid, wall, 1e-3 * np.cos(np.arange(40.0))[:, None] * np.ones(36), c.HalfSpace())
    assert check_state(problem, gap, rounded=False).curvature < 0
    far = check_state(problem, gap + 10.0, rounded=False)
    assert far.curvature > 0


def test_the_command_certifies_a_sample_of_a_sweep(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = SMALL + '\n[sweep.axes]\n"surface.seed" = [1, 2, 3]\n'
    (tmp_path / "sweep.toml").write_text(text)
    c.sweep(tmp_path / "sweep.toml", tmp_path / "out", workers=1)
    root = next((tmp_path / "out").rglob("sweep.toml")).parent
    assert main(["certify", str(root), "--sample", "2"]) == 0
    out = capsys.readouterr().out
    assert "states of 2 files" in out
    assert "2/2  files" in out
    assert "sound" in out
    path = forged(stored(tmp_path), "load", lambda values: 2 * values)
    assert main(["certify", str(path)]) == 1
    assert "is stored" in capsys.readouterr().err
    assert main(["certify", str(tmp_path / "nothing.h5")]) == 2
