"""The ladder and its budget: what is compared, and what the verdicts are worth."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import ase.build
import numpy as np
import pytest
from matplotlib.figure import Figure

import atomistic as a
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.front.cli import main
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import archive, budget, comparison
from atomistic.ladder.budget import checks_of
from atomistic.ladder.comparison import GEOMETRY, STEPS, PathResult, compare_on_path, paths_of
from atomistic.ladder.rungs import (
    CONTINUUM_RUNGS,
    RUNGS,
    approach_and_retract,
    beside_jump,
    compare,
    kinds_of,
    response_of,
    rung_of,
    state_at_area,
)
from atomistic.lammps import session
from atomistic.lammps.engine import run_command, runner
from atomistic.relax import relax
from atomistic.relax.specimen import specimen_of
from atomistic.response.lattice import LatticeResponse
from atomistic.show.validation import validation_sheets, validation_statements
from continuum.inputs.reading import load
from continuum.measure.contact import totals_of
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.path.state import PathState
from continuum.show import plot
from continuum.solve.solution import Settings
from continuum.store.datasets import Dataset
from continuum.store.sheet import Sheet
from tests.printed import faults_in_print
from tests.problems import Rough, lattice, validation_input

ROOT = Path(__file__).parents[4]

SMALL = validation_input(
    16,
    8.0,
    [2],
    """
[[case]]
name = "plain"
adhesion_length = 0.0
rms_slopes = [0.02, 0.01]
areas = [0.06]

[[case.tolerance]]
quantity = "load"
coefficient = 0.5
power = 1
reason = "of first order in the slope; the coefficient belongs to the surface"

[[case.exponent]]
quantity = "displacement"
expected = 2.0
tolerance = 0.2
slopes = [0.02, 0.01]
reason = "of second order in the slope, with corrections of third order at 0.02"

[[case]]
name = "sticky"
adhesion_length = 0.0005
rms_slopes = [0.05]
areas = [0.06]
branches = ["approach", "retract"]

[[case.tolerance]]
quantity = "gross_load"
coefficient = 0.5
power = 1
reason = "of first order in the slope, on all that pushes and pulls"
""",
)


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> ValidateConfig:
    path = tmp_path_factory.mktemp("input") / "small.toml"
    path.write_text(SMALL)
    return load(path, ValidateConfig)


COUNTED = {
    "LAMMPS opened": (session, "open_library"),
    "decks written for a LAMMPS": (session, "write_deck"),
    "decks written for a state": (relax, "write_deck"),
    "evaluations": (session.LammpsHandle, "evaluate"),
    "lattices laid": (ase.build, "fcc100"),
    "slabs": (Slab, "__post_init__"),
}
"""Work that is counted, by its function."""


@contextmanager
def counting() -> Iterator[Counter[str]]:
    """How often each of these functions is called, from an empty worker on."""
    calls = Counter[str]()

    def counted(what: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            calls[what] += 1
            return function(*arguments, **named)

        return call

    comparison._specimens_of_worker.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        for what, (owner, name) in COUNTED.items():
            patch.setattr(owner, name, counted(what, getattr(owner, name)))
        yield calls


@pytest.fixture(scope="module")
def compared(config: ValidateConfig) -> tuple[list[PathResult], Counter[str]]:
    with counting() as calls:
        return [compare_on_path(config, path) for path in paths_of(config)], calls


@pytest.fixture
def results(compared: tuple[list[PathResult], Counter[str]]) -> list[PathResult]:
    return compared[0]


@pytest.fixture(scope="module")
def checks(config: ValidateConfig) -> dict[str, Dataset]:
    """Of the ladder, which need no run of it."""
    laws = {case.name: LennardJonesSpline(adhesion_length=case.adhesion_length) for case in config.case}
    return archive.datasets_of_checks(checks_of(specimen_of(config), laws, runner(None)))


@pytest.fixture
def columns(results: list[PathResult], checks: dict[str, Dataset]) -> dict[str, np.ndarray]:
    return {name: dataset.values for name, dataset in (archive.datasets_of(results) | checks).items()}


SETTINGS = Settings(1e-9)


def contact(adhesion_length: float = 0.0, slope: float = 0.1, depth: float = 12.0) -> ContactProblem:
    rough = Rough(16, adhesion_length, seed=2, slope=slope, lambda_L=16.0)
    return rough.problem(substrate=lattice(16, "springs", depth))


@cache
def followed(adhesion_length: float, slope: float, depth: float, area: float) -> tuple[ContactProblem, list[PathState]]:
    """A contact, and its path to an area and back."""
    problem = contact(adhesion_length, slope, depth)
    return problem, list(approach_and_retract(problem, area, SETTINGS))


# --- the ladder --------------------------------------------------------------------------------------------


def test_rungs_are_compared_at_equal_mean_gap_and_atoms_at_equal_separation(results: list[PathResult]) -> None:
    for result in results:
        for state in result.states:
            rungs = state.rungs
            for name in CONTINUUM_RUNGS[:-1]:
                assert rungs[name].mean_gap == pytest.approx(rungs["lattice"].mean_gap, abs=1e-12)
            assert rungs["atoms"].separation == rungs["lattice"].separation
            # Equal separation and equal compliance: mean gaps differ by the nonlinearity only, but they do.
            assert rungs["atoms"].mean_gap == pytest.approx(rungs["lattice"].mean_gap, abs=1e-3)
            assert rungs["atoms"].mean_gap != rungs["lattice"].mean_gap


def test_all_states_of_a_worker_share_one_lammps(compared: tuple[list[PathResult], Counter[str]]) -> None:
    results, calls = compared
    states = [state for result in results for state in result.states]
    assert len(states) == 4
    assert calls == {
        "LAMMPS opened": 1,
        "decks written for a LAMMPS": 1,
        "evaluations": sum(state.evaluations for state in states),
        "lattices laid": 2,  # of the slab, and as LAMMPS reads it
        "slabs": 2,
    }


def test_a_kept_deck_is_written_once_and_says_the_same(
    config: ValidateConfig, results: list[PathResult], tmp_path: Path
) -> None:
    with counting() as calls:
        kept = compare_on_path(config, paths_of(config)[1], tmp_path).states
    assert calls["decks written for a state"] == len(kept) == len(list(tmp_path.iterdir())) == 1
    assert calls["LAMMPS opened"] == 1
    for one, other in zip(kept, results[1].states, strict=True):
        # The same start to the last digit, and so the same gaps.
        assert np.array_equal(one.rungs["atoms"].gap, other.rungs["atoms"].gap)
        assert np.array_equal(one.rungs["atoms"].traction, other.rungs["atoms"].traction)


def test_only_the_lattice_gives_way_as_a_whole(results: list[PathResult]) -> None:
    for result in results:
        for state in result.states:
            lattice, rigid = state.rungs["lattice"], state.rungs["half-space"]
            given_way = result.mean_stiffness * (lattice.mean_gap - lattice.separation)
            # Heights have no mean, so the mean displacement is separation minus mean gap.
            assert given_way == pytest.approx(lattice.load, abs=1e-9)
            assert rigid.separation == pytest.approx(rigid.mean_gap, abs=1e-12)
            if result.path.adhesion_length == 0:
                assert state.load_ratio > 1.05


def test_atoms_are_in_equilibrium_with_what_they_carry(results: list[PathResult]) -> None:
    for result in results:
        for state in result.states:
            assert state.largest_force <= 1e-8 * result.path.rms_slope
            atoms = state.rungs["atoms"]
            wall = LennardJonesSpline(adhesion_length=result.path.adhesion_length)
            # Tractions as LAMMPS computed them are the law at the gaps as LAMMPS found them.
            np.testing.assert_allclose(atoms.traction, wall.evaluate(atoms.gap).traction, atol=1e-13)


def test_a_path_approaches_touches_and_lets_go() -> None:
    problem, path = followed(*JUMPING)
    area = [totals_of(problem.grid, problem.wall, s.gap).area_rep for s in path]
    assert area[0] == 0
    assert max(area) >= 0.1
    assert path[-1].gap.min() >= problem.wall.zero_gap + problem.wall.range
    assert np.all(np.diff([s.separation for s in path[: int(np.argmax(area)) + 1]]) < 0)
    # Adhesion holds on: on the way back contact lasts to larger separations.
    last = max(s.separation for s, a in zip(path, area, strict=True) if a > 0 and s.branch == "retract")
    first = max(s.separation for s, a in zip(path, area, strict=True) if a > 0 and s.branch == "approach")
    assert last > first


@pytest.mark.parametrize("area", [0.05, 0.1, 0.2])
def test_an_area_is_met_to_the_point_without_adhesion(area: float) -> None:
    problem, path = followed(0.0, 0.1, 12.0, 0.25)
    state = state_at_area(problem, path, area, "approach", SETTINGS)
    found = totals_of(problem.grid, problem.wall, state.gap).area_rep
    assert area <= found <= area + 2 / problem.grid.size  # two points may touch at once


JUMPING = 0.05, 0.1, 48.0, 0.1
"""A thin slab is too stiff to jump as a whole."""


def test_the_states_beside_a_jump_are_those_of_both_branches() -> None:
    problem, path = followed(*JUMPING)
    before, after, past = beside_jump(problem, path).values()
    area = [totals_of(problem.grid, problem.wall, s.gap).area_rep for s in (before, after, past)]
    assert area[0] < 0.01 < 0.1 < min(area[1:])
    assert (after.branch, past.branch) == ("approach", "retract")
    assert after.separation < before.separation == pytest.approx(past.separation, abs=1e-12)


def test_without_a_jump_there_is_nothing_beside_it() -> None:
    with pytest.raises(ValueError, match="no jump-in"):
        beside_jump(*followed(0.0, 0.1, 12.0, 0.25))


def test_an_area_that_the_path_does_not_reach_is_refused() -> None:
    problem, path = followed(0.0, 0.1, 12.0, 0.25)
    with pytest.raises(ValueError, match="does not reach"):
        state_at_area(problem, path, 0.5, "approach", SETTINGS)


def test_a_rung_does_not_differ_from_itself_and_differs_as_it_was_changed() -> None:
    problem = contact(0.005)
    state = solve(problem, "mean-gap", 1.3, Settings(1e-9))
    rung = rung_of(problem, "lattice", state)
    same = compare(rung, rung, problem.wall)
    assert not any(same)
    moved = rung.gap.copy()
    # The repulsive point closest to the edge of its contact, lifted over it.
    at = np.unravel_index(np.argmax(np.where(moved < 1, moved, -np.inf)), moved.shape)
    lift = 2 * (1 - moved[at])
    moved[at] += lift
    traction = problem.wall.evaluate(moved).traction
    totals = vars(totals_of(problem.grid, problem.wall, moved))
    other = replace(rung, name="layer", gap=moved, traction=traction, **totals)
    difference = compare(other, rung, problem.wall)
    assert difference.pixels == 1
    assert difference.displacement == pytest.approx(lift, rel=1e-9)
    assert difference.area_rep == pytest.approx(-1 / problem.grid.size, rel=1e-12)
    assert difference.load == pytest.approx((other.load - rung.load) / rung.load_rep, rel=1e-12)


def test_atoms_are_told_by_the_sign_of_their_force() -> None:
    problem = contact(0.005)
    rung = rung_of(problem, "lattice", solve(problem, "mean-gap", 1.3, SETTINGS))
    atoms = replace(rung, name="atoms", traction=np.zeros_like(rung.traction))
    assert set(np.unique(kinds_of(rung, problem.wall))) == {0, 1, 2}
    assert not kinds_of(atoms, problem.wall).any()


def test_a_reference_out_of_contact_is_infinitely_far() -> None:
    problem = contact(0.005)
    rung = rung_of(problem, "lattice", solve(problem, "mean-gap", 1.3, SETTINGS))
    apart = rung_of(problem, "lattice", solve(problem, "mean-gap", 9.0, SETTINGS))
    assert compare(rung, apart, problem.wall).load == np.inf
    assert compare(rung, apart, problem.wall).gross_load == np.inf


def test_two_states_that_only_attract_are_compared_by_all_that_acts() -> None:
    problem, path = followed(*JUMPING)
    before = beside_jump(problem, path)["before jump-in"]
    rung = rung_of(problem, "lattice", before)
    other = replace(rung, load=1.5 * rung.load)
    difference = compare(other, rung, problem.wall)
    assert rung.load_rep == 0
    assert np.isnan(difference.load)
    assert difference.gross_load == pytest.approx(-0.5, rel=1e-9)


def test_each_step_of_the_budget_changes_one_response() -> None:
    lattice = LatticeResponse.of_springs(Slab.of_depth(Grid.square(16), 8.0), Springs())
    constants = Springs().elastic_constants
    k = {name: response_of(name, lattice, constants).stiffness(Grid.square(16)) for name in CONTINUUM_RUNGS}
    long_wave = {name: values[0, 1] for name, values in k.items()}
    assert long_wave["half-space"] == pytest.approx(np.pi / 16, rel=1e-12)
    assert long_wave["half-space"] < long_wave["layer"]  # a base at half a wavelength is felt
    assert np.isinf(k["layer"][0, 0])
    # The crystal has the mean compliance of the lattice, C11/depth.
    assert k["crystal"][0, 0] == pytest.approx(k["lattice"][0, 0], rel=1e-12)
    # Along <110>, below the reach of the base, it is stiffer than the mean by 1.4063/1.3721.
    assert k["crystal"][0, 4] / k["layer"][0, 4] == pytest.approx(1.4063 / 1.3721, rel=1e-3)
    # The lattice follows it at long waves, here 16 a0, to the 2.3 % of the worst direction.
    assert long_wave["lattice"] == pytest.approx(long_wave["crystal"], rel=0.023)
    assert long_wave["lattice"] != pytest.approx(long_wave["crystal"], rel=1e-3)
    assert [STEPS[step] for step in STEPS] == [
        ("half-space", "layer"),
        ("layer", "crystal"),
        ("crystal", "lattice"),
        ("lattice", "atoms"),
        ("half-space", "atoms"),
    ]


# --- the budget --------------------------------------------------------------------------------------------


def test_bounds_that_hold_and_bounds_that_fail(config: ValidateConfig, columns: dict[str, np.ndarray]) -> None:
    verdicts = list(budget.bound_verdicts(config, columns))
    assert all(verdict.holds for verdict in verdicts)
    assert all(verdict.measured > 0 for verdict in verdicts)
    worse = dict(columns)
    worse["nonlinearity_load"] = columns["nonlinearity_load"] * 10
    failed = [verdict for verdict in budget.bound_verdicts(config, worse) if not verdict.holds]
    assert [(v.case, v.quantity) for v in failed] == [("plain", "load")]
    assert failed[0].state in (
        "h' = 0.02, seed 2, A_rep/A0 = 0.06, approach",
        "h' = 0.01, seed 2, A_rep/A0 = 0.06, approach",
    )
    scaled = np.abs(worse["nonlinearity_load"] / worse["rms_slope"])[columns["case"] == "plain"]
    assert f"h' = {(0.02, 0.01)[int(np.argmax(scaled))]}," in failed[0].state
    worse = dict(columns)
    worse["largest_force"] = columns["largest_force"] * 1e3
    assert {v.quantity for v in budget.bound_verdicts(config, worse) if not v.holds} == {"largest force"}
    of_cases = [verdict for verdict in budget.bound_verdicts(config, worse) if verdict.case]
    assert all(v.state.endswith(("approach", "retract")) for v in of_cases if v.states > 1)
    for bad in (np.nan, np.inf):
        worse["nonlinearity_gross_load"] = np.where(columns["case"] == "sticky", bad, 0.0)
        assert "gross load" in {v.quantity for v in budget.bound_verdicts(config, worse) if not v.holds}


def test_a_bound_that_applies_to_nothing_does_not_hold(config: ValidateConfig, columns: dict[str, np.ndarray]) -> None:
    only_plain = {
        name: values[..., columns["case"] == "plain"] if values.shape[-1:] == columns["case"].shape else values
        for name, values in columns.items()
    }
    failed = {v.case for v in budget.bound_verdicts(config, only_plain) if not v.holds}
    assert failed == {"sticky"}


def test_exponents_of_exact_power_laws_are_found(columns: dict[str, np.ndarray]) -> None:
    made = dict(columns)
    made["nonlinearity_load"] = 0.3 * columns["rms_slope"]
    made["nonlinearity_displacement"] = -0.7 * columns["rms_slope"] ** 2
    fits = {fit.quantity: fit for fit in budget.exponents(made)}
    assert fits["load"].fitted == pytest.approx(1, abs=1e-12)
    assert fits["displacement"].fitted == pytest.approx(2, abs=1e-12)
    assert fits["load"].slopes == (0.02, 0.01)


def test_an_exponent_of_what_is_no_number_does_not_hold(config: ValidateConfig, columns: dict[str, np.ndarray]) -> None:
    (quantity,) = {exponent.quantity for case in config.case for exponent in case.exponent}
    for bad in (np.nan, 0.0):
        worse = dict(columns)
        worse[f"nonlinearity_{quantity}"] = columns[f"nonlinearity_{quantity}"].copy()
        worse[f"nonlinearity_{quantity}"][0] = bad
        failed = [verdict.quantity for verdict in budget.bound_verdicts(config, worse) if not verdict.holds]
        assert any(name.startswith(f"exponent of {quantity}") for name in failed)


def test_the_table_of_costs_takes_the_worst_state(columns: dict[str, np.ndarray]) -> None:
    rows = {(row.case, row.rms_slope): row for row in budget.costs(columns, tuple(STEPS))}
    assert list(rows) == [("plain", 0.02), ("plain", 0.01), ("sticky", 0.05)]
    sticky = columns["case"] == "sticky"
    # Over all that acts, as where a deck is compared with the continuum: N_rep alone may be a small part of that.
    worst = np.abs(columns["total_gross_load"][sticky]).max()
    assert rows["sticky", 0.05].load["total"] == worst > 0


def test_the_answer_names_the_worst_states_in_at_most_ten_lines(
    config: ValidateConfig, columns: dict[str, np.ndarray]
) -> None:
    verdicts = list(budget.bound_verdicts(config, columns))
    stored = archive.Archive(columns, {})
    good = validation_statements(config, stored, verdicts)
    assert good[0].endswith(f"{len(verdicts)} of {len(verdicts)} bounds hold")
    # The first line names what was judged, with the worst load and what is allowed, and what was not.
    (load,) = (verdict for verdict in verdicts if (verdict.case, verdict.quantity) == ("sticky", "gross load"))
    other = [verdict for verdict in verdicts if (verdict.case, verdict.quantity) == ("plain", "load")]
    worst = max(load, *other, key=lambda one: one.measured * one.scale)
    allowed = f"{100 * worst.measured * worst.scale:.2g} % of {100 * 0.5 * worst.scale:.2g} %"
    assert f"nonlinearity {allowed};" in good[0]
    assert "not judged: half-space against atoms, depth, anisotropy, discreteness" in good[0]
    assert "law in LAMMPS" in good[0]
    differ = [verdict for verdict in verdicts if verdict.step == "nonlinearity"]
    nearest = max(differ, key=lambda one: one.measured / one.limit)
    assert nearest.state in good[1]
    assert f"{100 * np.abs(columns['total_gross_load']).max():.1f} % of N_rep + N_att" in good[2]
    assert good[3].startswith("Bounds: ")
    assert not any(one.startswith("Bounds: ") for one in validation_statements(config, stored, []))
    assert f"{columns['evaluations'].size} equilibria" in good[4]
    # A file of an earlier version has no checks.
    older = {name: values for name, values in columns.items() if not name.startswith("check_")}
    first = validation_statements(config, stored, list(budget.bound_verdicts(config, older)))[0]
    assert "; long waves; law in LAMMPS; " in first.partition("not judged")[2]
    bad = validation_statements(config, stored, [replace(verdict, measured=np.nan) for verdict in verdicts])
    assert bad[0].endswith(f"0 of {len(verdicts)} bounds hold, {len(verdicts)} FAIL")
    assert all(one.startswith("FAILS: ") and "where" in one for one in bad[1:3])
    assert len(good) <= len(bad) <= 9  # and two with the files


def test_a_case_without_a_bound_is_named_beside_those_that_have_one(
    config: ValidateConfig, columns: dict[str, np.ndarray]
) -> None:
    """No case passes in silence, because a step of another case holds."""
    verdicts = list(budget.bound_verdicts(config, columns))
    total = budget.BoundVerdict("plain", "total", "gross load", "0.09", 0.02, 0.09, 4, "of other surfaces")
    first = validation_statements(config, archive.Archive(columns, {}), [*verdicts, total])[0]
    assert "half-space against atoms: 2 % of 9 % allowed" in first
    missing = first.partition("not judged: ")[2]
    assert missing.startswith("depth, anisotropy, discreteness in plain (outside the ensemble: ")
    assert "half-space against atoms, depth, anisotropy, discreteness in sticky (outside the ensemble: " in missing
    assert missing.count("depth/λ_s is 2 or 4, here 1") == 2


def test_a_depth_that_no_wave_feels_is_no_column_of_the_budget(
    config: ValidateConfig, columns: dict[str, np.ndarray]
) -> None:
    def told(depth: float) -> list[Sheet]:
        slab = config.slab.model_copy(update={"depth": depth})
        return validation_sheets(config.model_copy(update={"slab": slab}), archive.Archive(columns, {}), [])

    n = config.slab.n
    # exp(-2 q depth) (1 + 2 (q depth)²) of the longest wave, q = 2 pi/n: 2 at n/10, 3e-4 at n.
    for depth, felt in ((n / 10, True), (float(n), False)):
        budget_of, _, signed = told(depth)[:3]
        assert ("depth" in budget_of.head) is ("depth" in signed.head) is felt
        assert ("depth has no column" in budget_of.note) is not felt


# --- on disk, and as a command -----------------------------------------------------------------------------


def test_what_is_stored_is_read_back_whatever_the_order_of_finishing(
    config: ValidateConfig,
    results: list[PathResult],
    checks: dict[str, Dataset],
    columns: dict[str, np.ndarray],
    tmp_path: Path,
) -> None:
    for result in results[::-1]:
        archive.write_part(tmp_path / result.path.file_name, config, result)
    parts = [archive.read_archive_part(tmp_path / path.file_name, config) for path in paths_of(config)]
    archive.write_archive(tmp_path / "stored.h5", config, archive.join(parts) | checks, {})
    stored = archive.read_archive(tmp_path / "stored.h5").columns
    assert list(stored["case"]) == ["plain", "plain", "sticky", "sticky"]
    for name, values in columns.items():
        np.testing.assert_array_equal(stored[name], values, err_msg=name)
    assert stored["gap"].shape == (5, 4, 16, 16)


def noted(figures: dict[str, Figure]) -> Callable[[Figure, Path], Path]:
    """Instead of saving figures, which takes as long as all else, and has examples elsewhere."""

    def save_figure(figure: Figure, stem: Path) -> Path:
        figures[stem.name] = figure
        stem.with_suffix(".png").write_bytes(b"\x89PNG")
        return stem.with_suffix(".png")

    return save_figure


def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages and figures take longer than all else that a stored validation needs."""
    monkeypatch.setattr("atomistic.show.validation.write_validation", lambda *_: [Path("page.html")])


def test_a_validation_goes_on_where_it_stopped(
    config: ValidateConfig,
    results: list[PathResult],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert config.source is not None
    path, drawn = tmp_path / "small.h5", dict[str, Figure]()
    monkeypatch.setattr(plot, "save_figure", noted(drawn))
    (tmp_path / "small.parts").mkdir()
    for result in (results[0], results[2]):  # the second has one state, and no curves
        archive.write_part(tmp_path / "small.parts" / result.path.file_name, config, result)
    assert main(["validate", str(config.source.path), "-o", str(tmp_path), "-j", "1"]) == 0
    out = capsys.readouterr().out
    assert "validate small 3/3" in out  # one part was left
    assert "validate small 1/3" not in out
    answer = out[out.rindex("/3  ") :].splitlines()[1:]
    assert "bounds hold" in answer[0]
    assert "small.html" in answer[-2]
    assert len(answer) <= 10  # the tables come with -v
    assert archive.is_complete(path, config, force=False)
    assert not (tmp_path / "small.parts").exists()
    for figure in ("contact", "curves", "scaling"):
        assert any(axis.has_data() for axis in drawn[f"small-{figure}"].axes)
        assert faults_in_print(drawn[f"small-{figure}"]) == []
    # A finished one is only shown again.
    undrawn(monkeypatch)
    before = path.read_bytes()
    assert main(["validate", str(config.source.path), "-o", str(tmp_path)]) == 0
    assert path.read_bytes() == before


def test_another_validation_in_the_way_is_left_alone(
    config: ValidateConfig,
    results: list[PathResult],
    checks: dict[str, Dataset],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    changed = tmp_path / "small.toml"
    changed.write_text(SMALL.replace("depth = 8.0", "depth = 9.0"))
    archive.write_archive(tmp_path / "small.h5", config, archive.datasets_of(results) | checks, {})
    before = (tmp_path / "small.h5").read_bytes()
    assert main(["validate", str(changed), "-o", str(tmp_path)]) == 2
    assert "holds another result" in capsys.readouterr().err
    assert (tmp_path / "small.h5").read_bytes() == before


def test_a_failing_bound_is_the_exit_code(
    config: ValidateConfig,
    results: list[PathResult],
    checks: dict[str, Dataset],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    undrawn(monkeypatch)
    strict = tmp_path / "small.toml"
    strict.write_text(SMALL.replace("coefficient = 0.5", "coefficient = 0.0005", 1))
    archive.write_archive(
        tmp_path / "small.h5", load(strict, ValidateConfig), archive.datasets_of(results) | checks, {}
    )
    assert main(["validate", str(strict), "-o", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert re.search(r"1 FAIL\nFAILS: plain, nonlinearity, load: 0\.\d+ where 0\.0005 is allowed .* at h' = 0\.0", out)
    assert "seed 2, A_rep/A0 = 0.06, approach" in out


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("n = 16", "n = 16.5", "slab.n = 16.5"),
        ("lambda_s = 8.0", "lambda_s = 1.0", "surface.lambda_s = 1.0"),
        ("adhesion_length = 0.0\n", "adhesion_length = 0.0\nlambda_s = 20.0\n", "case[0].lambda_s = 20.0"),
        ("adhesion_length = 0.0\n", "adhesion_length = 0.0\nlambda_L = 20.0\n", "case[0].lambda_L = 20.0"),
        ("lambda_L = 16.0", "lambda_L = 17.0", "surface.lambda_L = 17.0"),
        ("adhesion_length = 0.0005", "adhesion_length = 0.5", "case[1].adhesion_length = 0.5"),
        ("rms_slopes = [0.05]", "rms_slopes = [nan]", "case[1].rms_slopes[0] = nan"),
        ('name = "sticky"', 'name = "plain"', "case[1].name"),
        ('name = "sticky"', 'name = "a/../b"', "case[1].name"),
        ("slopes = [0.02, 0.01]\nreason", "slopes = [0.02, 0.5]\nreason", "case[0].exponent[0].slopes"),
        ('quantity = "gross_load"', 'quantity = "groß"', "case[1].tolerance[0].quantity"),
        ("seeds = [2]", "sedes = [2]", "did you mean seeds"),
    ],
)
def test_bad_input_is_one_message_and_leaves_nothing(
    old: str, new: str, fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert old in SMALL
    path = tmp_path / "bad.toml"
    path.write_text(SMALL.replace(old, new))
    assert main(["validate", str(path), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert fault in error
    assert f"{path}:" in error
    assert "allowed:" in error
    assert sorted(tmp_path.iterdir()) == [path]


CRYSTAL = (
    SMALL.replace('kind = "springs"', 'kind = "lennard-jones"').split("[[case]]")[0]
    + """
[[case]]
name = "plain"
adhesion_length = 0.0
lambda_s = 6.0
lambda_L = 12.0
rms_slopes = [0.02]
areas = [0.06]
"""
)


@pytest.fixture(scope="module")
def crystal(tmp_path_factory: pytest.TempPathFactory) -> tuple[ValidateConfig, Path]:
    """A validation of Lennard-Jones atoms, by the command."""
    folder = tmp_path_factory.mktemp("crystal")
    (folder / "crystal.toml").write_text(CRYSTAL)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STICKINESS_CACHE", str(folder / "cache"))
        patch.setattr(plot, "save_figure", noted({}))
        assert main(["validate", str(folder / "crystal.toml"), "-o", str(folder), "-j", "1"]) == 0
    return load(folder / "crystal.toml", ValidateConfig), folder


def test_a_crystal_is_on_every_rung_and_springs_tell_its_geometry(crystal: tuple[ValidateConfig, Path]) -> None:
    stored = archive.read_archive(crystal[1] / "crystal.h5")
    columns = stored.columns
    assert tuple(columns["rung"]) == RUNGS
    assert (columns["lambda_s"][0], columns["lambda_L"][0]) == (6.0, 12.0)
    # All rungs but the atoms, which are held at equal separation, stand at one mean gap.
    gaps = dict(zip(columns["rung"], columns["mean_gap"][:, 0], strict=True))
    for rung in ("half-space", "layer", "crystal", "spring-lattice"):
        assert gaps[rung] == pytest.approx(gaps["lattice"], abs=1e-12)
    (cost,) = budget.costs(columns, (*STEPS, *GEOMETRY))
    # Springs turn, and so yield more under pressure; Lennard-Jones bonds harden: of opposite sign.
    signed = columns["nonlinearity_load"][0], columns["geometry_load"][0]
    assert signed[0] < 0 < signed[1]
    assert cost.load["anharmonicity"] == pytest.approx(signed[1] - signed[0], rel=1e-12)
    # Of first order in the slope, 0.02.
    assert 0.001 < cost.load["anharmonicity"] < 0.04
    assert stored.attributes["model/surface_relaxation"] == pytest.approx(0.0116, abs=1e-4)
    assert columns["evaluations"].max() <= 10


def test_the_page_of_a_run_stands_alone(crystal: tuple[ValidateConfig, Path]) -> None:
    page = (crystal[1] / "crystal.html").read_text()
    assert "lj/smooth/linear" in page
    assert "anharmonicity" in page
    figures = list(crystal[1].glob("crystal-*.png"))
    assert page.count("data:image/png;base64,") == len(figures) > 0
    assert "http" not in page.replace("http-equiv", "")
    # The equilibrium, and the checks: the ensemble knows no Lennard-Jones.
    assert "5 of 5 bounds hold" in page
    assert "not judged: half-space against atoms, depth, anisotropy, discreteness, nonlinearity" in page


@pytest.mark.parametrize(
    ("command", "kind", "message"),
    [
        ("validate", '"eam"\nfile = "Al_zhou.eam.alloy"', "at least 15 surface atoms"),
        ("deck", '"eam"\nfile = "Fe_mm.eam.fs"', "not fcc at its minimum: bcc"),
        ("validate", '"eam"\nfile = "no-such.eam"', "there is no potential file 'no-such.eam'"),
        ("deck", '"eam"\nfile = "CuNi.eam.alloy"\nelement = "Al"', "'Al' is not among them"),
        ("validate", '"lennard-jones"\ncutoff = 6.0', "forces reach"),
    ],
)
def test_a_crystal_that_cannot_be_is_one_message(
    command: str, kind: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CRYSTAL if command == "validate" else (ROOT / "inputs/lammps/rough.toml").read_text()
    text = text.replace("n = 16", "n = 8").replace("n = 32", "n = 8").replace("depth = 32.0", "depth = 8.0")
    text = (
        text.replace("lambda_L = 16.0", "lambda_L = 8.0")
        .replace("lambda_s = 8.0", "lambda_s = 4.0")
        .replace("lambda_s = 6.0\nlambda_L = 12.0\n", "")
    )
    (tmp_path / "bad.toml").write_text(re.sub('(?<=kind = )"[a-z-]+"', lambda _: kind, text, count=1))
    assert main([command, str(tmp_path / "bad.toml"), "-o", str(tmp_path / "out")]) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert message in " ".join(error.split())
    assert "Traceback" not in error
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


def test_a_jump_that_is_not_there_is_one_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.toml").write_text(SMALL.replace("areas = [0.06]\n", "areas = [0.06]\njump = true\n"))
    assert main(["validate", str(tmp_path / "bad.toml"), "-o", str(tmp_path / "out"), "-j", "1"]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert "no jump-in: leave out jump" in error
    assert "Traceback" not in error


def test_a_deck_is_written_run_by_lmp_and_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atomistic.show.decks.save_figure", noted({}))
    source = tmp_path / "rough.toml"
    # Two spacings deep is too shallow for physics and deep enough to see that files and commands fit.
    source.write_text(
        "separation = 1.1\n[interatomic]\nkind = 'springs'\n[slab]\nn = 12\ndepth = 4.0\n"
        "[wall]\nlaw = 'lennard-jones-spline'\nadhesion_length = 0.005\n"
        "[surface]\nkind = 'self-affine'\nhurst = 0.8\nrms_slope = 0.05\nlambda_s = 6.0\nlambda_L = 12.0\nseed = 2\n"
    )
    deck = tmp_path / "deck"
    assert main(["deck", str(source), "-o", str(deck)]) == 0
    assert main(["read", str(deck)]) == 2  # nobody has run it
    assert "has not been run" in capsys.readouterr().err
    by_lmp = run_command(deck)
    assert by_lmp.require().largest_force <= 5e-10
    assert main(["read", str(deck)]) == 0
    assert f"{by_lmp.force:.10g}" in capsys.readouterr().out
    assert main(["deck", str(source), "-o", str(deck), "--run"]) == 0
    assert f"{by_lmp.force:.7g}"[:8] in capsys.readouterr().out
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    assert main(["deck", str(source), "-o", str(tmp_path / "mine")]) == 2
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["thesis.tex"]
    capsys.readouterr()
    # A site may start its own LAMMPS.
    assert main(["deck", str(source), "-o", str(deck), "--run", "--lmp-command", "no-such-lmp"]) == 1
    error = capsys.readouterr().err
    assert "no-such-lmp" in error
    assert "doctor" in error


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["springs", "lennard-jones", "copper", "aluminium", "nickel", "wavelength", "jump", "jump-copper"]
)
def test_every_validation_holds(name: str, tmp_path: Path) -> None:
    assert main(["validate", f"inputs/validate/{name}.toml", "-o", str(tmp_path), "-j", "2"]) == 0


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2"])
def test_a_number_of_workers_that_is_none_is_refused_before_anything_is_written(
    workers: object, config: ValidateConfig, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match="workers"):
        a.validate(config, tmp_path / "out", workers=workers, decks=tmp_path / "decks")
    assert not list(tmp_path.iterdir())


class Told(Exception):
    """What the comparison is replaced by; it holds the number of processes."""


def test_it_takes_as_many_processors_as_it_is_granted_and_at_most_four(
    config: ValidateConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a node of 64, by SLURM: `os.cpu_count` knows nothing of it."""

    def told(*_: object, workers: int) -> None:
        raise Told(workers)

    paths = len(paths_of(config))
    monkeypatch.setattr("atomistic.front.validation.run_tasks", told)
    monkeypatch.setattr("os.cpu_count", lambda: 64)
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(64)))
    monkeypatch.setattr("continuum.store.granted.cgroup_processors", lambda _: float("inf"))
    for granted in (1, 2, 64):
        monkeypatch.setenv("SLURM_CPUS_PER_TASK", str(granted))
        with pytest.raises(Told) as caught:
            a.validate(config, tmp_path / "out")
        assert caught.value.args == (min(granted, 4, paths),)
