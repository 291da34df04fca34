"""What searches cost, in solves and transforms, for the states that slower ones find."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, NonPeriodicHalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.surfaces import sine
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.path.equilibrium import equilibrium
from continuum.path.loading import follow, solve
from continuum.path.state import (
    FEW_POINTS,
    NEAREST,
    NOT_LOOKED,
    Control,
    Outcome,
    PathState,
    Search,
    gone,
    not_looked_at,
)
from continuum.solve.solution import Settings
from tests.kinds import covering
from tests.problems import Rough

SETTINGS = Settings(1e-7)


def pairs(state: PathState) -> float:
    return state.search_pairs + state.solution.fft_pairs


@pytest.mark.parametrize(
    ("wall", "target"),
    covering(
        [
            LennardJonesSpline(0.0),
            LennardJonesSpline(adhesion_length=0.005),
            LennardJonesSpline(adhesion_length=0.05),
            InversePowers((9, 3), adhesion_length=0.005),
            Exponential(0.005, 0.3, 2.0),
            HardWall(),
        ],
        [0.8, 0.95, 0.99],
    ),
)
def test_a_large_area_is_found_at_the_price_of_a_few_solves(wall: Wall, target: float) -> None:
    """From rest, with the last solve, in solves from rest at its mean gap, whose state it is.

    Here, with one coarser grid, up to 4.2; by mean gap it would be 6 to 11.  On 256 x 256 points it is at most 3.8.
    """
    grid = Grid.square(128)
    heights = SelfAffine(0.8, 0.1, 8, 64).synthesise(grid, np.random.default_rng(2))
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    found = solve(problem, "repulsive-area", target, SETTINGS).require()
    alone = solve(problem, "mean-gap", found.mean_gap, SETTINGS).require()
    assert pairs(found) <= 4.5 * alone.solution.fft_pairs
    assert abs(found.area_rep - target) <= 0.01 * (1 - target) * (1 + 1e-9)
    assert alone.area_rep == pytest.approx(found.area_rep, abs=1.5 / grid.size)
    if target == 0.99 and wall.law is not None:
        assert found.mean_gap < wall.zero_gap


def test_a_large_area_of_a_wall_that_yields_lies_below_its_hardness() -> None:
    """Pressures beyond it, where all of the surface yields, are not tried."""
    problem = Rough(32, hard=True).problem(HardWall(hardness=0.08))
    for target in (0.6, 0.9):
        found = solve(problem, "repulsive-area", target, SETTINGS, search=Search(0.05)).require()
        assert found.load < 0.08
        assert abs(found.area_rep - target) <= 0.05 * (1 - target) * (1 + 1e-9)


def test_a_trial_where_nothing_is_repeated_is_one_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    """In stretches it would begin anew from the gap of a window that is no equilibrium, and not end: here with 5."""
    monkeypatch.setattr("continuum.path.equilibrium.STRETCH", 5)
    grid = Grid.square(64)
    heights = SelfAffine(0.5, 0.3, 4, 32).synthesise(grid, np.random.default_rng(1))
    problem = ContactProblem(grid, Exponential(0.006, 0.3, 5.0), heights, NonPeriodicHalfSpace())
    found = solve(problem, "repulsive-area", 0.8, SETTINGS).require()
    alone = equilibrium(problem, "separation", found.separation, SETTINGS).require()
    assert found.area_rep == pytest.approx(alone.area_rep, abs=1.5 / grid.size)
    assert found.solution.iterations > 5
    # Seen: 2.7.
    assert pairs(found) <= 3.5 * alone.solution.fft_pairs


def test_a_tension_where_nothing_is_repeated_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """However short the first stretch, after which it is looked whether the surface has left: one comes to an end."""
    grid = Grid.square(64)
    heights = SelfAffine(0.8, 0.1, 8, 32).synthesise(grid, np.random.default_rng(1))
    problem = ContactProblem(grid, Exponential(0.05, 0.5, 5.0), heights, NonPeriodicHalfSpace())
    whole = equilibrium(problem, "mean-pressure", -0.002, SETTINGS).require()
    monkeypatch.setattr("continuum.path.equilibrium.STRETCH", 5)
    short = equilibrium(problem, "mean-pressure", -0.002, SETTINGS).require()
    assert short.load == pytest.approx(-0.002, abs=2 * SETTINGS.tolerance)
    assert short.area_rep == pytest.approx(whole.area_rep, abs=1.5 / grid.size)


def test_a_jump_on_a_line_costs_some_times_its_far_end() -> None:
    """A line has no boxes, and its solves over a jump are long: they are stopped once they have gone over.

    Found are both sides: the one before holds, and what is next to it goes over.
    """
    grid = Grid((1, 1024), (1.0, 1024.0))
    heights = SelfAffine(0.35, 0.03, 4, 512).synthesise(grid, np.random.default_rng(1))
    problem = ContactProblem(grid, LennardJonesSpline(adhesion_length=0.025), heights, HalfSpace("clamped"))
    settings = Settings(3e-8)
    found = solve(problem, "repulsive-area", 0.05, settings)
    assert found.outcome is Outcome.JUMPED_OVER
    beyond = found.beyond
    assert beyond is not None
    assert found.area_rep < 0.05 < beyond.area_rep
    assert 0 < found.mean_gap - beyond.mean_gap <= 1e-3 * heights.std()
    assert max(found.solution.residual, beyond.solution.residual) <= 2 * settings.tolerance
    assert pairs(found) < 9 * beyond.solution.fft_pairs
    strictly = Settings(3e-8, warm_grids=0)
    held = solve(problem, "mean-gap", found.mean_gap, strictly, found.gap).require()
    assert held.area_rep == found.area_rep
    over = solve(problem, "mean-gap", beyond.mean_gap, strictly, found.gap).require()
    assert over.area_rep == pytest.approx(beyond.area_rep, abs=1.5 / grid.size)


def test_a_way_of_jumps_finds_those_of_short_steps_in_fewer_solves(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wave that snaps in and lets go: a steep path takes no short steps, and a jump is halved from both sides."""
    tried = list[float]()

    def watched(problem: ContactProblem, control: Control, target: float, *given: Any) -> PathState:
        tried.append(round(target, 9))
        return equilibrium(problem, control, target, *given)

    monkeypatch.setattr("continuum.path.loading.equilibrium", watched)
    grid = Grid((64, 8), (64.0, 8.0))
    problem = ContactProblem(
        grid, LennardJonesSpline(adhesion_length=0.05), sine(grid, 1.0, (1, 0)), HalfSpace("clamped")
    )
    resolution, most = 0.01, 110
    search = Search(event_resolution=resolution, event_threshold=0.02)
    states = list(follow(problem, "mean-gap", [3.2, 2.9, 3.3], Settings(1e-8), (), search))
    events = [event for state in states for event in state.events]
    assert [event.kind for event in events] == ["jump-in", "pull-off"]
    # Hysteresis: the wave lets go farther out than it caught on.
    assert events[1].after.value > events[0].before.value
    assert len(tried) == sum(state.search_solves + 1 for state in states)
    assert len(tried) < most
    for event, at in zip(events, (2.9, 3.3), strict=True):
        # Short steps from before the bracket through it: one jump, inside, by as much.
        low, high = event.before.value, event.after.value
        assert abs(high - low) <= resolution
        steps = np.linspace(3.2 if at == 2.9 else 2.9, high, 61)
        fine = list(follow(problem, "mean-gap", steps, Settings(1e-8), states[:1] if at == 2.9 else states[1:2]))
        change = np.abs(np.diff([state.load for state in fine]))
        i = int(change.argmax())
        assert min(low, high) - 0.006 <= min(steps[i : i + 2])
        assert max(steps[i : i + 2]) <= max(low, high) + 0.006
        assert change[i] == pytest.approx(abs(event.after.load - event.before.load), rel=0.2)


@pytest.mark.parametrize(("adhesion", "resolution", "said"), [(0.05, None, 1), (0.05, 0.1, 0), (0.0, None, 0)])
def test_a_way_back_in_long_steps_says_what_was_not_looked_at(
    adhesion: float, resolution: float | None, said: int
) -> None:
    problem = Rough(32, lambda_s=8.0).problem()
    contact = c.Contact(problem.heights, c.LennardJonesSpline(adhesion_length=adhesion))
    there = float(problem.heights.std()) * 1.5 + 1
    path = contact.path(mean_gap=[there, there + 0.4], event_resolution=resolution)
    text = str(path.sheet())
    assert text.count(NOT_LOOKED) == said
    assert text.count("event_resolution") == said


def test_only_long_steps_back_that_were_not_looked_at_are_said() -> None:
    apart = gone(Rough(32, lambda_s=8.0).problem(), 0.0, "retract")
    touching = replace(apart, area_rep=0.1, area_att=0.2)
    points = [(touching, False), (touching, False), (apart, True), (replace(touching, branch="approach"), False),
              (apart, False)]  # fmt: skip
    assert not_looked_at(points, 0.01) == [False, False, False, False, True]
    assert not_looked_at([], 0.01) == []


@pytest.mark.parametrize(("count", "said"), [(0.4, True), (1.5, True), (2.5, True), (3.0, False), (80.2, False)])
def test_an_area_of_few_points_is_said_to_be_met_to_half_a_point_only(count: float, said: bool, tmp_path: Path) -> None:
    """The state is an equilibrium of another area: 0, 1 and 3 points were found for the first three, without a word."""
    problem = Rough(32, 0.0005, lambda_s=8.0).problem()
    contact = c.Contact(problem.heights, problem.wall)
    state = contact.press(area=count / 1024).require()
    assert abs(1024 * state.area_rep - count) <= 0.5
    path = contact.path(area=[count / 1024])
    given = {
        "grid": {"n": 32}, "surface": {"kind": "file", "path": str(tmp_path / "heights.npy")},
        "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.0005},
        "substrate": {"response": "half-space", "mean": "clamped"},
        "loading": {"control": "repulsive-area", "targets": [count / 1024]},
    }  # fmt: skip
    np.save(tmp_path / "heights.npy", problem.heights)
    result = c.run(given, tmp_path)
    for text in (repr(state), str(state.sheet()), str(path.sheet())):
        assert (NEAREST in text) == said
    for sheet in (path.sheet(), result.sheets()[0]):
        assert (FEW_POINTS in " ".join(str(sheet).split())) == said
