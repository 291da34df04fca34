"""Certificates: sound states are sound, whatever the law and the control, and what was forged is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

import continuum as c
from continuum.front import certify
from continuum.front.cli import main
from continuum.inputs.errors import StickinessError
from continuum.inputs.reading import load
from continuum.measure.certificate import StateCheck, check_state
from continuum.measure.contact import Totals
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.store import datasets as store
from continuum.store.datasets import File
from continuum.store.runs.config import RunConfig
from continuum.store.runs.run import follow_run
from continuum.store.sweeps.measured import ADDED
from tests import kinds
from tests.kinds import covering
from tests.problems import SMALL

WALLS: dict[str, dict[str, Any]] = {
    **kinds.tables(Wall),
    "repulsive": {"law": "lennard-jones-spline", "range": 0.0},
}
LOADING = {"control": "repulsive-area", "targets": [0.05, 0.15]}
ONE = {**LOADING, "targets": [0.05]}


def stored(folder: Path, with_fields: bool = True, **settings: object) -> Path:
    (folder / "small.toml").write_text(SMALL)
    given = {"loading": LOADING, "output.fields": with_fields, **settings}
    return c.run(folder / "small.toml", folder / "small.h5", settings=given, force=True).path


@pytest.mark.parametrize(("fields", "name"), covering([True, False], WALLS))
def test_states_of_every_law_are_sound_stored_or_found_again(name: str, fields: bool, tmp_path: Path) -> None:
    wall = WALLS[name]
    found = c.certify(stored(tmp_path, fields, wall=wall, loading=ONE))
    assert found.ok, found.faults
    assert len(found.points) == 1
    assert all(point.again is not fields for point in found.points)
    if not fields and wall["law"] == "lennard-jones-spline":
        for point in found.points:  # in double precision: rounding of transforms and differences
            assert point.found_of("recomputed residual") == pytest.approx(point.point.residual, rel=1e-2)
            assert point.found_of("load") == pytest.approx(point.point.load, abs=1e-12)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of one state."""
    return stored(tmp_path_factory.mktemp("sound"), loading=ONE)


def forged(path: Path, name: str, change: Callable[[Real], Real]) -> Path:
    """The file with one dataset changed, and sound sums."""
    file: File = store.read_datasets(path, "stickiness/continuum-run", 3, labels=True)
    datasets = {**file.datasets, name: replace(file.datasets[name], values=change(file[name].copy()))}
    new = path.with_name("forged.h5")
    store.write(new, datasets, file.attributes)
    return new


@pytest.mark.parametrize("change", [
    lambda gap: gap + np.float32(1e-4) * np.sin(np.arange(gap.shape[1]))[:, None],
    lambda gap: gap[:, ::-1],
    lambda gap: np.float32(np.nan) * gap,
])  # fmt: skip
def test_a_gap_that_was_forged_is_told(change: Callable[[Real], Real], sound: Path) -> None:
    found = c.certify(forged(sound, "gap", change))
    assert not found.ok
    assert all(any("residual" in fault for fault in point.faults) for point in found.points)


def with_one_point_elsewhere(maps: NDArray[Any]) -> NDArray[Any]:
    """Packed maps of the same area, if it is not empty."""
    points = np.unpackbits(maps, axis=-1, count=30)
    points.reshape(-1)[[*{int(np.argmax(points == value)) for value in (0, 1)}]] ^= 1
    return np.packbits(points, axis=-1)


CASES: dict[str, dict[str, Any]] = {
    "hard": {"wall": {"law": "hard"}},
    "law": {"solver.stability": True, "wall": {"law": "table", "path": "table.txt"}},
    "threshold": {"loading": {**ONE, "threshold": 0.02}},
    "layer": {"substrate": {"response": "layer", "poisson": 0.3, "depth": 9.0, "mean": 0.05},
              "loading": {"control": "separation", "targets": [1.2]}},
    "pressure": {"loading": {"control": "mean-pressure", "targets": [0.002]}},
    "jump": {"wall.adhesion_length": 0.05, "loading": {**ONE, "targets": [0.02]}},
}  # fmt: skip


SAMPLE = 6
"""Changes of each case that the short suite makes: together they reach every third number, the long one all."""


@pytest.mark.parametrize(
    ("case", "every"),
    [(case, False) for case in CASES] + [pytest.param(case, True, marks=pytest.mark.long) for case in CASES],
)
def test_whatever_is_changed_is_told_or_listed_as_not_looked_at(
    case: str, every: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every dataset and every attribute of a system of a sweep; near the threshold the load is small, and one per cent
    of it is told, too."""
    monkeypatch.chdir(tmp_path)  # where the names of files in an input begin
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "table.txt").write_text("0.7 1.0\n1.0 0.0\n1.2 -0.1\n1.5 -0.05\n2.0 0.0\n")
    given = {"loading": ONE, "output.fields": True, **CASES[case]}
    path = follow_run(load(tmp_path / "small.toml", RunConfig, given), tmp_path / "a.h5", added=ADDED).path
    monkeypatch.setattr(certify, "check_state", remembered(check_state))
    sound = c.certify(path)
    assert sound.ok, sound.faults
    left_out = {name for one in (*sound.points, *sound.files) for name in one.left_out}
    totals = {one.name for one in fields(Totals)} | {"mean_gap", "elastic_energy", "target"}
    assert not left_out & (totals | {"repulsive", "attracted", "gap", "measured", "heights", "realised_rms_slope"})

    with h5py.File(path) as file:
        named = [("", name) for name in file.attrs] + [(name, "") for name in datasets_of(file)]
    named = [each for each in named if max(each).partition("/")[0] not in left_out]
    changes = [(*each, value) for each in named for value in (0.0, 0.99, 2.0, np.nan)]
    if not every:
        changes = [changes[i] for i in np.random.default_rng([*CASES].index(case)).permutation(len(changes))[:SAMPLE]]
    whole = path.read_bytes()
    for name, attribute, value in changes:
        path.write_bytes(whole)
        with h5py.File(path, "r+") as file:
            differs = changed(file[name or "/"], attribute, value)
        assert not differs or is_told(path), (name, attribute, value)
    path.write_bytes(whole)
    for name in ("repulsive", "attracted"):
        assert not c.certify(forged(path, name, with_one_point_elsewhere)).ok, name


def datasets_of(file: h5py.File) -> list[str]:
    names = list[str]()
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return [name for name in names if not file[name].attrs.get("NAME", b"").startswith(b"This is a netCDF dimension")]


def changed(item: Any, attribute: str, value: float) -> bool:
    """Change a dataset or an attribute in the open file, its sums with it; whether that made a difference."""
    if attribute:
        before = item.attrs[attribute]
        kind = getattr(before, "dtype", np.dtype("U")).kind
        other = {"f": lambda: before * value, "u": lambda: 1 - before, "i": lambda: before + 1}
        item.attrs.modify(attribute, other.get(kind, lambda: f"{before}x")())
        return bool(kind != "f" or before != other["f"]())
    before = item[()]
    if before.dtype.kind == "O":  # words: another one of those that there are
        other = np.array([b"CONVERGED" if word != b"CONVERGED" else b"STALLED" for word in before], dtype=object)
        item[...] = other
        item.attrs["crc32"] = store._sum_of(np.array([word.decode() for word in other]))
        return True
    with np.errstate(invalid="ignore"):  # infinity times zero
        other = before * value if before.dtype.kind == "f" else before ^ 1 if value else before
    item[...] = other.astype(before.dtype)
    return bool((item[()] != before).any() and not np.isnan(before).all())


def is_told(path: Path) -> bool:
    try:
        found = c.certify(path)
    except StickinessError:
        return True
    return not found.ok or bool(found.unconverged)


def remembered(check: Callable[..., StateCheck]) -> Callable[..., StateCheck]:
    """The same check, made once for each contact and gap."""
    known = dict[Any, StateCheck]()

    def found(problem: ContactProblem, gap: Real, **given: Any) -> StateCheck:
        key = gap.tobytes(), problem.wall.work_of_adhesion
        if key not in known:
            known[key] = check(problem, gap, **given)
        return known[key]

    return found


def test_where_nothing_was_looked_at_nothing_is_sound(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = stored(tmp_path, **{"solver.max_iterations": 1})
    found = c.certify(path)
    assert not found.ok
    assert len(found.unconverged) == 2
    assert main(["certify", str(path)]) == 1
    said = capsys.readouterr()
    assert "nothing was looked at: 1 files hold no equilibrium" in said.err
    assert "0 of 2 states of 1 files" in said.out
    assert "step 1: " in said.out


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
    lowest = check_state(problem, gap, rounded=False).lowest
    assert lowest is not None
    # The heights do not act on it: K of the longest wave, and the softening of the law there.
    softening = float(wall.evaluate(gap[:1]).stiffness[0, 0])
    assert lowest.value == pytest.approx(np.pi / 40 + softening, abs=1e-6)
    far = check_state(problem, gap + 10.0, rounded=False).lowest
    assert far is not None
    assert far.value == pytest.approx(np.pi / 40, abs=1e-6)


def test_the_command_certifies_a_sample_of_a_sweep(
    sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = SMALL.replace("1.6, 1.4,\n           1.2", "1.4").replace("retract = true\n", "")
    text += '\n[sweep.axes]\n"surface.seed" = [1, 2, 3]\n'
    (tmp_path / "sweep.toml").write_text(text)
    c.sweep(tmp_path / "sweep.toml", tmp_path / "out", workers=1)
    root = next((tmp_path / "out").rglob("sweep.toml")).parent
    assert main(["certify", str(root), "--sample", "2"]) == 0
    out = capsys.readouterr().out
    assert "states of 2 files" in out
    assert "2/2  files" in out
    assert "sound" in out
    path = forged(sound, "load", lambda values: 2 * values)
    assert main(["certify", str(path)]) == 1
    assert "is stored" in capsys.readouterr().err

    first = min(root.rglob("*.h5"))
    file = store.read_datasets(first, "stickiness/continuum-run", 3, labels=True)
    store.write(first, file.datasets, {**file.attributes, "finished": False})
    found = c.certify(root, sample=3)
    assert not found.ok
    (refused,) = found.refused
    assert str(first) in refused
    assert len({point.path for point in found.points}) == 2
    assert main(["certify", str(tmp_path / "nothing.h5")]) == 2
