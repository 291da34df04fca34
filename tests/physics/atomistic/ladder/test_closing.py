"""The budget at equal area: loads that stand at one comparand, and parts that add up to the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import archive, budget
from atomistic.ladder.comparison import STEPS, PathResult, compare_on_path, paths_of
from atomistic.ladder.rungs import CLOSE, Rung, RungName, loads_at_area, rung_of
from continuum.inputs.reading import load
from continuum.measure.contact import totals_of
from continuum.model.grid import Grid
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from tests.problems import Rough, lattice, validation_input

POINTS = 16 * 16
INPUT = validation_input(
    16,
    8.0,
    [2, 3],
    f"""
[[case]]
name = "plain"
adhesion_length = 0.0
rms_slopes = [0.1]
areas = [{23 / POINTS}, {25 / POINTS}, {27 / POINTS}]
[[case]]
name = "sticky"
adhesion_length = 0.0005
rms_slopes = [0.1]
areas = [0.15]
branches = ["approach", "retract"]
""",
)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> list[PathResult]:
    path = tmp_path_factory.mktemp("input") / "closing.toml"
    path.write_text(INPUT)
    config = load(path, ValidateConfig)
    return [compare_on_path(config, replace(each, curves=False)) for each in paths_of(config)]


@pytest.fixture
def columns(results: list[PathResult]) -> dict[str, np.ndarray]:
    return {name: dataset.values for name, dataset in archive.datasets_of(results).items()}


def edge(gap: np.ndarray, count: int) -> float:
    """Gap of the k-th lowest point, counted from where repulsion begins."""
    return float(np.sort(gap, axis=None)[count - 1]) - LennardJonesSpline(0.0).zero_gap


def test_atoms_are_carried_to_the_area_as_their_own_equilibria_say(results: list[PathResult]) -> None:
    count = 25
    for result in results[:2]:
        below, state, above = (each.rungs["atoms"] for each in result.states)
        at = edge(state.gap, count)
        other = above if at > 0 else below
        # Between two equilibria of the atoms, of which no lattice is told, the load is nearly linear in that gap.
        share = at / (at - edge(other.gap, count))
        assert 0 < share < 1
        own = state.load + share * (other.load - state.load)
        carried = result.states[1].loads_at_area["atoms"]
        step = result.states[1].loads_at_area["lattice"] - carried
        assert abs(step) > 0.01 * own
        # The nonlinearity is 2.5 % of the load, and what is left out about that much of it.
        assert carried == pytest.approx(own, abs=0.025 * abs(step))
        assert abs(state.load - own) > 0.05 * abs(step)  # where they were relaxed the area is another


def test_rungs_stand_where_the_same_number_of_points_is_repulsive() -> None:
    problem = Rough(24, 0.0, seed=2, slope=0.1, lambda_L=24.0).problem(substrate=lattice(24, "springs", 12.0))
    settings, wall = Settings(1e-10), problem.wall
    state = rung_of(problem, "lattice", solve(problem, "mean-gap", 1.1, settings))
    count = int(np.count_nonzero(state.gap < wall.zero_gap))
    found: list[Rung] = []

    def at(mean_gap: float) -> Rung:
        found.append(rung_of(problem, "lattice", solve(problem, "mean-gap", mean_gap, settings, state.gap)))
        return found[-1]

    height = float(problem.heights.std())
    loads = loads_at_area({"lattice": at}, {"lattice": state, "atoms": state}, wall, 0.1, height)
    nearest = min(found, key=lambda rung: abs(edge(rung.gap, count)))
    assert abs(edge(nearest.gap, count)) <= CLOSE * 0.1
    assert loads["lattice"] == nearest.load
    # Atoms that differ in nothing from the lattice carry the same there, x + t - t: each sum is rounded once.
    rounding = np.finfo(float).eps * (abs(nearest.load) + abs(state.load))
    assert loads["atoms"] == pytest.approx(nearest.load, rel=0, abs=rounding)
    # By a mean gap that is a hair smaller and larger, the area is that of k points and of one less.
    areas = [np.count_nonzero(at(nearest.mean_gap + d).gap < wall.zero_gap) for d in (-1e-4, 1e-4)]
    assert areas == [count, count - 1]


def test_a_rung_that_jumps_over_the_area_has_no_load_there() -> None:
    grid, wall = Grid.square(4), LennardJonesSpline(0.0)
    pattern = np.linspace(-0.75, 0.75, 16).reshape(4, 4)

    def load_of(mean_gap: float, above: float) -> float:
        """Of a surface with six points in contact at 1.2 a0, whose roughness changes to another at 1.22 a0."""

        def state(mean_gap: float) -> Rung:
            gap = mean_gap + pattern * (above if mean_gap > 1.22 else 1.0)
            totals, at = vars(totals_of(grid, wall, gap)), {"separation": mean_gap, "gap": gap}
            return Rung(**totals, **at, name="lattice", traction=np.zeros_like(gap))

        rungs: dict[RungName, Rung] = {"lattice": state(mean_gap), "atoms": state(mean_gap)}
        return loads_at_area({"lattice": state}, rungs, wall, 0.1, 1.0)["lattice"]

    # The sixth point, 0.25 a0 below the mean, touches at 1.25 a0; with half of the roughness at none above 1.22 a0.
    gap = 1.25 + pattern
    assert load_of(1.2, 1.0) == pytest.approx(totals_of(grid, wall, gap).load, rel=1e-4)
    assert np.isnan(load_of(1.2, 0.5))
    assert np.isnan(load_of(5.0, 1.0))  # nothing is repulsive: there is no area to compare at


def test_the_parts_of_the_budget_add_up_to_the_whole_in_every_state(columns: dict[str, np.ndarray]) -> None:
    lines = list(budget.closed(columns, STEPS))
    assert [(line.case, line.branch, line.surfaces) for line in lines] == [
        *[("plain", "approach", 2)] * 3,
        ("sticky", "approach", 2),
        ("sticky", "retract", 2),
    ]
    rungs, acts = columns["rung"].tolist(), (columns["load_rep"] + columns["load_att"])[-1]
    for line in lines:
        *parts, total = (mean for mean, _ in line.parts.values())
        assert sum(parts) == pytest.approx(total, abs=1e-12)
        mine = (columns["case"] == line.case) & (columns["area"] == line.area) & (columns["branch"] == line.branch)
        loads = dict(zip(rungs, columns["load_at_area"][:, mine], strict=True))
        whole = (loads["half-space"] - loads["atoms"]) / acts[mine]
        assert total == pytest.approx(whole.mean(), rel=1e-12)
        assert line.parts["total"][1] == pytest.approx(abs(whole[1] - whole[0]) / 2, rel=1e-9)
        # Springs turn under pressure, and so carry less than their lattice.
        assert line.parts["nonlinearity"][0] > 0.005
        # A base at the depth of a wavelength moves the mean of the surface: at one area that costs less.
        assert abs(line.parts["depth"][0]) < np.abs(columns["depth_load"][mine]).min()
    # At equal mean gap and separation, as in the other table, the same parts do not add up.
    rest = columns["total_load"] - sum(columns[f"{step}_load"] for step in list(STEPS)[:-1])
    assert np.abs(rest).min() > 1e-5


def test_a_surface_without_the_area_on_one_rung_is_left_out_and_said_to_be(columns: dict[str, np.ndarray]) -> None:
    one = dict(columns)
    one["load_at_area"] = columns["load_at_area"].copy()
    one["load_at_area"][1, 0] = np.nan
    line = next(budget.closed(one, STEPS))
    assert (line.surfaces, line.of) == (1, 2)
    assert np.isnan(line.parts["total"][1])
    assert np.isfinite(line.parts["total"][0])
    # States beside a jump are of no area that was asked for.
    one["place"] = np.where(columns["case"] == "sticky", "after jump-in", columns["place"])
    assert {line.case for line in budget.closed(one, STEPS)} == {"plain"}
