"""The turn of a map, solved: the same as that of the state at a work of adhesion, in all units; and what is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.cli import main
from continuum.front.predict import solved
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.model.surface import SelfAffine
from continuum.show.answer import per_area, statements
from continuum.solve.solution import NotConvergedError, Solution
from continuum.solve.solver import Solver
from continuum.sticky.materials import Interface
from continuum.sticky.prediction import SMALL, Prediction, prediction_of
from continuum.sticky.simulate import UnresolvedError, simulate
from continuum.sticky.solved_turn import WIDTH, SolvedTurn, solve_turn
from continuum.sticky.verdict import answer_of
from continuum.theory.rough import turning_share
from continuum.topography.map import Topography
from tests.continuum.sticky.test_predict import surface

RANGE = 0.35
NANO = 0.35e-9


def sine(n: int = 32, amplitude: float = 0.3) -> Topography:
    """An egg box of one period."""
    x, y = 2 * np.pi * np.indices((n, n)) / n
    return Topography(amplitude * (np.cos(x) + np.cos(y)), (float(n), float(n)), periodic=True)


def in_nanometres(n: int = 64) -> Topography:
    """The same in nm: with E* of 1 GPa works of adhesion are as many J/m² as they are E* a0 in reduced units."""
    small = surface(n)
    return Topography(1e-9 * small.heights, (1e-9 * n, 1e-9 * n), periodic=True)


@pytest.fixture(scope="module")
def gaussian() -> SolvedTurn:
    return solve_turn(in_nanometres(), Interface(1e9, 1.0, NANO, None))


@pytest.mark.parametrize("kind", ["sine", "gaussian"])
def test_on_both_sides_of_the_turn_the_load_has_the_sign_that_it_says(kind: str) -> None:
    topography = {"sine": sine(), "gaussian": surface()}[kind]
    turn = solve_turn(topography, Interface(1.0, 1.0, RANGE, None))
    assert turn.low <= turn.work <= turn.high <= turn.low * (1 + WIDTH) * (1 + 1e-9)
    assert turn.most == turn.work
    # Beyond the bracket, and what 3 % of the area move of it.
    for factor, sticky in ((1 / 1.2, False), (1.2, True)):
        work = factor * turn.work
        assert turn.sticky(work) is sticky
        assert simulate(topography, Interface(1.0, work, RANGE, None)).sticky is sticky


def test_the_turn_does_not_depend_on_units_nor_on_the_given_work(gaussian: SolvedTurn) -> None:
    other = solve_turn(surface(), Interface(1.0, 1e-3, RANGE, None))
    assert other.work == pytest.approx(gaussian.work, rel=1e-6)  # of rounding, by a search that ends at 1e-4
    assert other.range == RANGE


def test_a_range_below_the_pixels_leaves_an_interval() -> None:
    """The law of the turn says by how much more w a shorter range asks for."""
    topography = surface()
    turn = solve_turn(topography, Interface(1.0, 1.0, 0.01, None))
    height = topography.heights.std()
    assert turn.range > 0.01
    assert turn.most / turn.work == pytest.approx(turning_share(0.01 / height) / turning_share(turn.range / height))
    assert turn.sticky(0.5 * (turn.work + turn.most)) is None
    assert turn.sticky(0.99 * turn.work) is False
    assert turn.sticky(1.01 * turn.most) is True
    assert "in place of" in turn.warnings[0]


def test_a_map_of_single_pixels_is_warned_of() -> None:
    """Half of its pixels touch at once, so that the load at 1 % of the area is that of no state."""
    x, y = np.indices((32, 32))
    rough = Topography(1e-3 * ((x + y) % 2), (32.0, 32.0), periodic=True)
    turn = solve_turn(rough, Interface(1.0, 1.0, 1e-6, None))
    assert turn.jumps
    assert any("100% of the mean square slope lies in waves of fewer than 4 points" in text for text in turn.warnings)
    assert any("in place of" in text for text in turn.warnings)


# --- what is said -------------------------------------------------------------------------------------------


def told(turn: SolvedTurn, given: float, **found: float) -> list[str]:
    contact = prediction_of([in_nanometres()], Interface(1e9, given, NANO, None))
    return statements(replace(contact, turn=replace(turn, **found)))


def test_what_was_solved_comes_first_with_its_factors(gaussian: SolvedTurn) -> None:
    far = told(gaussian, 4 * gaussian.work)
    assert far[0].startswith("Sticky, solved on the map: w = ")
    assert "is 4 times the" in far[0]
    assert far[1].startswith("It would not be sticky with w below")
    assert "E* above 4 GPa, or with heights about 2 times as large" in far[1]
    assert far[2].startswith("Theories: ")
    below = told(gaussian, gaussian.work / 4)
    assert below[0].startswith("Not sticky, solved on the map: w = ")
    assert "is 0.25 times the" in below[0]
    assert "E* below 250 MPa, or with heights about 0.5 times as large" in below[1]
    assert told(gaussian, 1.1 * gaussian.work)[0].startswith("Sticky, but near the turn")
    assert all(len(lines) <= 9 for lines in (far, below))


def test_where_solver_and_theories_differ_that_is_said(gaussian: SolvedTurn) -> None:
    works = dict.fromkeys(("work", "low", "high", "most"), 100 * gaussian.work)
    lines = told(gaussian, 30 * gaussian.work, **works)
    assert lines[0].startswith("Not sticky, solved on the map")
    assert lines[2].startswith("But theories: sticky")
    assert "Solver and theories differ" in lines[2]


def test_a_range_that_was_not_solved_leaves_it_open(gaussian: SolvedTurn) -> None:
    lines = told(gaussian, 1.5 * gaussian.work, most=2 * gaussian.work)
    assert lines[0].startswith("Undecided, solved on the map")
    assert told(gaussian, 3.5 * gaussian.work, most=2 * gaussian.work)[0].startswith("Sticky, but near the turn")
    assert told(gaussian, 0.6 * gaussian.work, most=2 * gaussian.work)[0].startswith("Not sticky, but near the turn")
    assert told(gaussian, 0.6 * gaussian.work)[0].startswith("Not sticky, solved")


@pytest.mark.parametrize(
    ("share", "expected"), [(0.01, "costs little"), (0.5, "it pays"), (2.0, "only parts of the surface touch")]
)
def test_what_full_contact_costs_is_said_in_parts_of_w(share: float, expected: str) -> None:
    energy = prediction_of([in_nanometres()], Interface(1e9, 1.0, NANO, None)).contact.conformal_energy
    assert energy is not None
    lines = statements(prediction_of([in_nanometres()], Interface(1e9, energy / share, NANO, None)))
    said = next(line for line in lines if line.startswith("Full contact"))
    assert expected in said
    assert f"{share:g} times w" in said


def test_a_turn_that_nobody_asked_for_is_given_up_after_ten_times_what_is_expected(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    interface = Interface(1.0, 1.0, RANGE, None)
    whole, limited = (solve_turn(surface(), interface, limited=limited) for limited in (False, True))
    assert np.array_equal(whole.gap, limited.gap)  # where the limit is not met it changes no bit
    pairs = list[int]()
    minimise = Solver.minimise

    def counted(solver: Solver, law: Law, offset: Real, *given: Any, **posed: Any) -> Solution:
        found = minimise(solver, law, offset, *given, **posed)
        pairs.extend([found.fft_pairs] if offset.size == surface().grid.size else [])
        return found

    monkeypatch.setattr(Solver, "minimise", counted)
    monkeypatch.setattr("continuum.sticky.solved_turn.PATIENCE", 0.05)
    monkeypatch.setattr("continuum.show.answer.PATIENCE", 0.05)
    with pytest.raises(NotConvergedError, match=r"not found within 15 pairs of transforms, 0\.05 times"):
        solve_turn(surface(), interface, limited=True)
    assert 15 <= sum(pairs) <= 2 * 15  # the last solve is as long as its grids, at most
    found = prediction_of([in_nanometres()], Interface(1e9, 0.02, NANO, None))
    said = list[str]()
    assert "its turn: it was not found within 15 pairs" in solved(found, None, 1, said.append).unsolved
    assert said[0].endswith("given up after 0.05 times that unless --solve is given")
    assert said[1].startswith("not solved: its turn: ")
    assert not solved(found, True, 1).unsolved


def test_what_does_not_converge_is_said_and_theories_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("continuum.sticky.solved_turn.check_resolved", _refuse)
    found = prediction_of([in_nanometres()], Interface(1e9, 0.02, 0.01e-9, None)).solved(state=False)
    assert found.turn is None
    assert "its turn: no pixels" in found.unsolved
    assert "by the theories only, as it was not solved: its turn: no pixels" in statements(found)[0]
    assert found.doubts[-1].startswith("not solved: ")


def _refuse(topography: Topography, shortest: float) -> None:
    raise UnresolvedError("no pixels")


# --- faults -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def noisy() -> Prediction:
    """White noise beyond the cut-off of a film: 0.25 nm on 2 nm, with waves of 16 pixels and more."""
    grid = Grid.square(64)
    film = SelfAffine(0.8, 0.1, 16.0, 32.0).synthesise(grid, np.random.default_rng(1))
    heights = 2 * film / film.std() + 0.25 * np.random.default_rng(2).normal(size=grid.shape)
    found = c.predict(
        heights, size="256nm", unit="nm", periodic=True, contact_modulus="10GPa", work="0.1J/m2", range="1nm",
        smallest="64nm", solve=False,
    )  # fmt: skip
    return found.solved(state=False)


def at(solved: Prediction, work: float) -> Prediction:
    """The same at another work of adhesion."""
    return replace(
        solved,
        contact=replace(solved.contact, work_of_adhesion=work),
        mended=solved.mended and replace(solved.mended, contact=replace(solved.mended.contact, work_of_adhesion=work)),
    )


def test_a_faulty_map_is_solved_with_its_faults_corrected_and_as_measured(noisy: Prediction) -> None:
    assert [fault.kind for fault in noisy.faults] == ["noise"]
    turn, measured = noisy.turn, noisy.measured_turn
    assert turn is not None
    assert measured is not None
    grid = Grid.square(64)
    film = SelfAffine(0.8, 0.1, 16.0, 32.0).synthesise(grid, np.random.default_rng(1))
    clean = Topography(2e-9 * film / film.std(), (256e-9, 256e-9), periodic=True)
    # The bracket of either, and what noise in the waves of the film changes.
    assert turn.work == pytest.approx(solve_turn(clean, noisy.interface).work, rel=2 * WIDTH)
    assert measured.work > 1.5 * turn.work


def test_where_the_corrected_map_has_another_answer_it_is_undecided_and_that_is_the_answer(noisy: Prediction) -> None:
    turn, measured = noisy.turn, noisy.measured_turn
    assert turn is not None
    assert measured is not None
    between = at(noisy, float(np.sqrt(turn.work * measured.work)))
    assert between.solved_sticky is None
    assert answer_of(between) == "undecided"
    said = statements(between)
    assert said[0].startswith("Faulty map: below 62.7 nm the spectrum falls less")
    assert said[1].startswith(
        "Undecided, though solved on the map: the load at 1 % repulsive area changes its sign at "
    )
    assert f"{per_area(measured.work)} as measured and at {per_area(turn.work)} with the faults corrected" in said[1]
    for work, sticky in ((1.2 * measured.work, True), (turn.work / 1.2, False)):
        found = at(noisy, work)
        assert found.solved_sticky is sticky
        first = statements(found)[1]
        assert "icky, " in first
        assert "solved on the map with its faults corrected: w = " in first
        assert f"(as measured, at {per_area(measured.work)})" in first
    alone = replace(at(noisy, 10 * measured.work), measured_turn=None)
    assert alone.solved_sticky is None
    assert "its turn was not found as measured" in statements(alone)[1]


def test_a_fault_that_nothing_corrects_asks_the_solver_for_a_wide_margin(gaussian: SolvedTurn) -> None:
    plain = in_nanometres()
    level = np.ptp(plain.heights) / 10
    stepped = replace(plain, heights=level * np.round(plain.heights / level), read=np.empty(0))
    large = replace(plain, heights=100 * plain.heights, read=np.empty(0))

    def told_of(topography: Topography, factor: float) -> tuple[bool | None, str]:
        work = factor * gaussian.work
        found = prediction_of([topography], Interface(1e9, work, NANO, None))
        found = replace(found, turn=gaussian, measured_turn=found.mended and gaussian)
        return found.solved_sticky, next(line for line in statements(found) if "olved on the map" in line)

    assert told_of(plain, 2.0)[0] is True
    for factor, sticky in ((2.0, None), (0.5, None), (11.0, True), (1 / 11.0, False)):
        solved, said = told_of(stepped, factor)
        assert solved is sticky
        assert sticky is not None or ", without remedy: the answer would have to hold at 10 times" in said
    for factor in (1e-3, 1e3):
        solved, said = told_of(large, factor)
        assert solved is None
        assert said.startswith("Undecided, though solved on the map: slope: check size and unit")


# --- what is solved without being asked -----------------------------------------------------------------------


def test_small_maps_are_solved_unless_that_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = surface(32).heights
    known = {"size": "9.6nm", "unit": "A", "material": "silicon", "periodic": True}
    asked, not_asked = c.predict(heights, **known), c.predict(heights, **known, solve=False)
    assert asked.turn is not None
    assert asked.simulation is None
    assert not_asked.turn is None
    assert not_asked.unsolved == ""
    np.save(tmp_path / "map.npy", heights)
    command = ["predict", str(tmp_path / "map.npy"), "--size", "9.6nm", "--unit", "A", "--material", "silicon"]
    command += ["--periodic", "--probe", "1um", "-o", str(tmp_path)]
    assert main(command) == 0
    said = capsys.readouterr()
    first = said.out.splitlines()[:10]
    assert "solved on the map" in first[0]
    assert any(line.startswith("Pull-off force of a probe") for line in first)
    assert said.err.startswith("solving for the work of adhesion")
    assert "solved in " in said.err
    assert (tmp_path / "map-predict-contact.png").exists()
    assert main([*command, "--no-solve"]) == 0
    said = capsys.readouterr()
    assert "solved on the map" not in said.out
    assert said.err == ""


def large() -> Prediction:
    rough = np.tile(in_nanometres(32).heights, (17, 17))
    return prediction_of([Topography(rough, (544e-9, 544e-9), True)], Interface(1e9, 0.01, NANO, None))


def test_large_maps_and_lines_are_not_solved_without_being_asked() -> None:
    assert SMALL < 544**2
    assert "points are more than" in large().too_much
    lines = c.predict(np.random.default_rng(1).normal(size=128).cumsum(), size="1um", unit="nm", material="mica")
    assert lines.turn is None
    assert "not a map" in lines.unsolved


@pytest.mark.parametrize(("text", "expected"), [("0", "a unit of length is missing"), ("banana", "not a number")])
def test_a_probe_that_is_none_is_one_message(
    text: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "map.npy", surface(32).heights)
    command = ["predict", str(tmp_path / "map.npy"), "--size", "9.6nm", "--unit", "A", "--material", "silicon"]
    assert main([*command, "--probe", text, "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.startswith("--probe ")
    assert expected in said
    assert not (tmp_path / "out").exists()
