"""The threshold: sign of the load on both sides, limits, invariances, and what it costs."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast, get_args

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import continuum as c
from continuum.front.contact import FoundThreshold
from continuum.inputs.reading import load
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.model.walls.attraction import Shape
from continuum.path import threshold_search
from continuum.path.equilibrium import equilibrium
from continuum.path.state import Control, Outcome, PathState, Search
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import Settings
from continuum.store.identity import identity, resolved, restored
from continuum.store.runs.config import RunConfig
from continuum.store.runs.reuse import contact_identity
from continuum.store.runs.run import follow_run
from continuum.theory.paper import snap_in_wavelength
from tests.kinds import covering
from tests.problems import SMALL
from tests.stored import same

AREA = {"control": "repulsive-area", "targets": [0.05], "threshold": 0.02, "area_tolerance": 0.05}
GRID = c.Grid((60, 72), (60.0, 72.0))


def heights(seed: int = 1, height: float = 0.5) -> np.ndarray:
    found = c.SelfAffine(0.8, 0.1, 6.0, 30.0).synthesise(GRID, np.random.default_rng(seed))
    return found * (height / found.std())


def law(range: float, shape: str = "spline", core: float = 5.0) -> WallOfWork:
    def of(work: float) -> Wall:
        return c.attraction_on_core(shape, work, range, core)

    return of


@cache
def found(seed: int = 1, reach: float = 0.5, shape: str = "spline", area: float = 0.04) -> FoundThreshold:
    wall = law(reach, shape)
    contact = c.Contact(heights(seed), wall(0.001), period=GRID.lengths)
    return contact.find_threshold(wall, area=area).require()


@pytest.mark.parametrize(("shape", "seed"), covering(get_args(Shape), [1, 2]))
def test_the_load_at_the_area_changes_its_sign_there(seed: int, shape: str) -> None:
    searched, wall = found(seed, shape=shape), law(0.5, shape)
    assert searched.bracket is not None
    low, high = searched.bracket.before, searched.bracket.after
    assert low.load > 0 > high.load
    assert low.value < searched.work < high.value <= 1.02 * low.value * (1 + 1e-9)
    # Searched for apart, beyond the bracket by the tolerance of the area, 1 %, by which the threshold moves less.
    for factor, sign in ((0.97, 1), (1.03, -1)):
        state = c.Contact(heights(seed), wall(factor * searched.work), period=GRID.lengths).press(area=0.04)
        assert np.sign(state.require().load) == sign


@given(st.floats(0.1, 2.0))
@settings(max_examples=2)
def test_heights_and_range_s_times_as_long_have_it_at_the_square_of_s(s: float) -> None:
    wall = law(0.5 * s)
    contact = c.Contact(s * heights(), wall(0.001 * s**2), period=GRID.lengths)
    assert contact.find_threshold(wall, area=0.04).work == pytest.approx(
        s**2 * found().work, rel=1e-3
    )  # tolerance of states


def test_searches_of_the_area_at_each_work_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    together = found().work
    monkeypatch.setattr(threshold_search, "MOST_TOGETHER", 0)
    # Brackets of 2 %, and areas within 1 %.
    assert found.__wrapped__().work == pytest.approx(together, rel=0.03)


def test_a_threshold_costs_a_few_points_at_its_area() -> None:
    at = found().state
    one = at.contact.press(area=0.04).require()
    own = one.solution.fft_pairs + one.search_pairs
    assert at.search_pairs + at.solution.fft_pairs <= 6 * own  # the goal; 2 to 3 were seen


def test_a_surface_that_no_work_holds_at_this_area_has_no_threshold(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threshold_search, "MOST_TOGETHER", 1)
    monkeypatch.setattr(threshold_search, "MOST_SEARCHES", 1)
    wall = law(0.5)
    searched = c.Contact(heights(), wall(0.001), period=GRID.lengths).find_threshold(wall, area=0.04)
    assert not searched.converged
    assert np.isnan(searched.work)
    assert "no work of adhesion" in searched.status
    with pytest.raises(c.NotConvergedError):
        searched.require()


def test_what_is_no_law_of_a_work_is_refused() -> None:
    contact = c.Contact(heights(), c.LennardJonesSpline(adhesion_length=0.005), period=GRID.lengths)
    with pytest.raises(ValueError, match="wall"):
        contact.find_threshold(lambda work: c.HardWall(), area=0.04)


def assert_goes_on_as_of_before(folder: Path, result: c.Result) -> None:
    """A file of the version before, which says turn, is read as it was, and the command finds it done."""
    from continuum.front.cli import main

    old = folder / "small-threshold.h5"
    with h5py.File(old, "r+") as file:
        assert set(file["events/kind"].asstr()[()]) == {"threshold"}
        file["events/kind"][...] = "turn"
        del file["events/kind"].attrs["crc32"]
        file.attrs["config_resolved"] = file.attrs["config_resolved"].replace(b'"threshold":', b'"turn":')
    written = old.read_bytes()
    assert c.Result.read(old).events == result.events
    assert main(["threshold", "small.toml", "--area", "0.05", "--area", "0.1"]) == 0
    assert old.read_bytes() == written
    with h5py.File(old, "r+") as file:
        file["status"][...] = "NO_TURN"
        del file["status"].attrs["crc32"]
    assert {point.status for point in c.Result.read(old).points} == {Outcome.NO_THRESHOLD.name}


def test_results_of_before_are_the_same_run_and_inputs_have_the_name_of_today() -> None:
    tables = {**tomllib.loads(SMALL), "loading": {"control": "repulsive-area", "targets": [0.1]}}
    new = load(tables, RunConfig, {"loading.threshold": 0.02})
    old = restored(RunConfig, resolved(new).replace('"threshold":', '"turn":'))
    assert old.loading == new.loading
    assert (identity(old), contact_identity(old)) == (identity(new), contact_identity(new))
    # What is hashed is what was hashed when results were first stored.
    assert old.plain(identity=True)["loading"]["turn"] == 0.02
    assert "threshold" not in old.plain(identity=True)["loading"]
    with pytest.raises(c.ConfigError, match="turn"):
        load(tables, RunConfig, {"loading.turn": 0.02})


def test_the_command_stores_the_bracket_and_goes_on(tmp_path, monkeypatch, capsys) -> None:
    from continuum.front.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    assert main(["threshold", "small.toml", "--area", "0.05", "--area", "0.1"]) == 0
    out = capsys.readouterr().out
    assert "Work of adhesion above which the surface is sticky" in out
    result = c.Result.read("results/small-threshold.h5")
    for (step, event), point in zip(result.events, result.points, strict=True):
        assert event.control == "work-of-adhesion"
        assert event.before.load > 0 > event.after.load
        assert point.work_of_adhesion in (event.before.value, event.after.value)
        assert point.target == (0.05, 0.1)[step]
    assert main(["threshold", "small.toml", "--area", "0.05", "--area", "0.1"]) == 0
    assert "stored before" not in capsys.readouterr().out
    assert_goes_on_as_of_before(Path("results"), result)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (["--set", 'wall={law="hard"}'], 'wall.law = "hard"'),
        (["--set", 'substrate={response="non-periodic-half-space"}'], "substrate.response"),
        (["--area", "0.1", "--area", "0.05"], "area = [0.1, 0.05]: allowed: increasing"),
        (["--set", "loading.retract=true"], "settings = {'loading.retract': True}: allowed: of [loading] only"),
        (["--set", 'loading={control="mean-gap",targets=[1.0]}'], "settings = {'loading': {"),
    ],
)
def test_the_command_names_what_was_given_and_no_key_of_its_own(given, named, tmp_path, monkeypatch, capsys) -> None:
    from continuum.front.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    assert main(["threshold", "small.toml", *given]) == 2
    said = capsys.readouterr().err
    assert named in said
    assert "loading.threshold" not in said
    assert "loading.targets" not in said
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("stopped", [1, 4, 6])
def test_a_search_that_is_stopped_goes_on_from_its_trials_to_the_same_bits(
    stopped: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before its first area is found, too: what was solved is not solved again, but for the state that is stored."""
    config = load({**tomllib.loads(SMALL), "loading": AREA}, RunConfig)
    tried = list[tuple[float, float]]()

    def watched(problem: ContactProblem, control: Control, target: float, *given: Any) -> PathState:
        if len(tried) == most:
            raise KeyboardInterrupt
        tried.append((target, problem.wall.work_of_adhesion))
        return equilibrium(problem, control, target, *given)

    monkeypatch.setattr(threshold_search, "equilibrium", watched)
    most = 100
    follow_run(config, tmp_path / "alone.h5")
    alone, most = list(tried), stopped
    assert len(alone) > stopped
    tried.clear()
    with pytest.raises(KeyboardInterrupt):
        follow_run(config, tmp_path / "run.h5")
    assert tried == alone[:stopped]
    tried.clear()
    most = 100
    follow_run(config, tmp_path / "run.h5")
    assert tried[: len(alone) - stopped] == alone[stopped:]
    assert len(tried) <= len(alone) - stopped + 1
    same(tmp_path / "run.h5", tmp_path / "alone.h5")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["alone.h5", "run.h5"]


# --- ranges that a grid hardly resolves ----------------------------------------------------------------------


def works_tried(n: int, reach: float, monkeypatch: pytest.MonkeyPatch) -> tuple[PathState, dict[int, list[float]]]:
    """A threshold at 1 % of n² points, and the works of adhesion that were tried on each grid."""
    grid, tried = c.Grid.square(n), dict[int, list[float]]()

    def watched(problem: ContactProblem, *given: Any) -> PathState:
        tried.setdefault(problem.grid.shape[0], []).append(problem.wall.work_of_adhesion)
        return equilibrium(problem, *given)

    monkeypatch.setattr(threshold_search, "equilibrium", watched)
    rough = c.SelfAffine(0.8, 0.1, 8.0, n / 2).synthesise(grid, np.random.default_rng(1))
    wall = law(reach)
    problem = ContactProblem(grid, wall(0.001), rough * (0.5 / rough.std()), c.HalfSpace())
    _, state = threshold_search.bracket_threshold(
        problem, wall, 0.01, Settings(3e-6), Search(area_tolerance=0.05), 0.02
    )
    return state, tried


def test_a_coarser_grid_is_asked_only_for_works_that_it_resolves(monkeypatch: pytest.MonkeyPatch) -> None:
    state, tried = works_tried(256, 0.08, monkeypatch)
    bracket = state.require().threshold
    assert bracket is not None
    # Two points of it to a wave that snaps, π E* over the softening.
    assert snap_in_wavelength(law(0.08)(max(tried[128])).largest_softening) >= 2 * 2.0 * (1 - 1e-9)
    assert max(tried[256]) >= bracket.after.value
    # No step goes farther than a factor of e.
    assert np.abs(np.diff(np.log(tried[256]))).max() <= 1.0 + 1e-9


def test_there_is_no_threshold_where_the_load_hardly_depends_on_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    state, tried = works_tried(128, 0.02, monkeypatch)
    assert state.status is Outcome.NO_THRESHOLD
    every = [work for works in tried.values() for work in works]
    assert snap_in_wavelength(law(0.02)(max(every)).largest_softening) >= 0.5 * (1 - 1e-9)
    assert len(every) <= 3 * threshold_search.MOST_TOGETHER


@pytest.mark.parametrize("below", [-0.03, -0.012, -0.004])
@pytest.mark.parametrize("above", [0.004, 0.012, 0.03])
def test_two_trials_close_a_bracket_of_both_ends(below: float, above: float) -> None:
    trials = threshold_search._Trials(float(np.log1p(0.02)), 100)
    for at in (below, above):
        trials.bracket = trials.bracket.add(at, 0.8 * at)
    for _ in range(2):
        between = trials.between()
        assert between is not None
        if not trials.closed:
            trials.bracket = trials.bracket.add(between, 0.8 * between)
    assert trials.closed


def test_a_bracket_of_one_end_aims_farther_each_time_that_the_other_is_not_reached() -> None:
    trials = threshold_search._Trials(0.02, 100)
    aims = []
    for place in (0.0, 0.1, 0.2):
        trials.bracket = trials.bracket.add(place, -0.05)
        aims.append(trials.aim(-0.05))
    assert aims[0] < 0 < aims[1] < aims[2]
    trials.bracket = trials.bracket.add(0.3, 0.01)
    assert trials.aim(0.01) == -0.02 / 3


def test_the_ends_are_the_last_trials_on_both_sides_though_the_work_be_the_same() -> None:
    """A work that is held while the mean gap is looked for is tried more than once."""
    trials = threshold_search._Trials(0.02, 100)
    one, again, above = (
        cast(threshold_search._Trial, SimpleNamespace(place=place, ratio=ratio))
        for place, ratio in ((0.1, -0.2), (0.1, -0.1), (0.1, 0.1))
    )
    for each, ends in ((one, (one,)), (again, (again,)), (above, (again, above))):
        trials.add(each)
        assert trials.ends == ends
    assert trials.closed
