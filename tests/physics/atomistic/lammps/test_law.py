"""Every law of the continuum as LAMMPS evaluates it: formulas against the law, energy against force."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atomistic as a
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.front.cli import main
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_in_process
from atomistic.lammps.law import LAWS, NativeLaw, felt, law_of_atoms, name_of, native_law, read_wall_table
from atomistic.lammps.session import Session
from continuum.model.walls import Exponential, LennardJonesSpline, Wall
from continuum.model.walls.inverse_powers import LennardJones93
from continuum.model.walls.tabulated import TabulatedWall
from tests import kinds


def table(knots: int) -> TabulatedWall:
    """The paper's law with a dent, as somebody might have measured it."""
    gap = np.linspace(0.7, 1.4, knots)
    law = LennardJonesSpline(0.35).evaluate(gap).traction + 0.01 * np.sin(20 * gap) * (1.4 - gap) ** 2
    return TabulatedWall(gap, np.append(law[:-1], 0.0))


WALLS: dict[str, Wall] = {
    **{name: wall for name, wall in kinds.WALLS.items() if name != "attraction-on-core"},  # a table, as those below
    "repulsive": LennardJonesSpline(0.0),
    "short table": table(24),
    "long table": table(1200),
}


def test_every_law_that_decks_know_is_tested_here() -> None:
    assert {type(wall) for wall in WALLS.values()} == set(LAWS)


def spread(wall: Wall) -> Deck:
    """A flat slab under heights that put every part of the law above some atom."""
    slab = Slab((8, 9), mobile=2)
    end = min(wall.reach, wall.zero_gap + 1.5)
    start = wall.core - 0.05 if np.isfinite(wall.core) else wall.zero_gap - 0.2
    gaps = np.linspace(start, end + 0.1, 72).reshape(slab.shape)
    return Deck(slab, Springs(), wall, gaps - 1.0, 1.0, tolerance=1e9)


def below(deck: Deck) -> np.ndarray:
    """Gaps of the second layer of such a deck, above which the heights are interpolated."""
    return deck.above[72:] + 1.0 + 0.5**0.5


@pytest.mark.parametrize("name", WALLS)
def test_the_formulas_are_the_law(tmp_path, name):
    deck = spread(WALLS[name])
    wall = deck.wall
    result = run_in_process(write_deck(tmp_path, deck))
    law = deck.law.evaluate(result.gap)
    second = deck.law.evaluate(below(deck))
    stated = native_law(deck.law).error
    text = (tmp_path / "wall.table").read_text()
    assert f"differ from the law by at most {stated:.1e} E*" in text
    # Formulas: rounding of powers up to 13 of a gap known to 1e-16.  Tables: what they state, between the points where
    # it was measured, 20 to a piece, hardly more.
    allowed = 1.1 * stated + 1e-10 * np.abs(law.traction).max()
    assert np.abs(result.traction - law.traction).max() <= allowed
    assert (stated == 0) == (name_of(deck.law) != TabulatedWall.__name__)
    assert ("an atom has its part" in text) == (deck.law is not wall)
    # Over ranges up to 12 a0.
    assert result.force == pytest.approx(law.traction.sum() + second.traction.sum(), abs=144 * allowed)
    assert result.wall_energy == pytest.approx(law.energy.sum() + second.energy.sum(), abs=12 * 144 * allowed)
    # The law of a run is read back.
    read, gap = a.read(tmp_path).wall, np.linspace(0.5, 2.5, 100)
    assert type(read).__name__ == name_of(wall)
    for found, written in zip(read.evaluate(gap), wall.evaluate(gap), strict=True):
        assert (found == written).all() or type(read) is not type(wall)
    # The written table is the law.
    gap, energy, traction = np.loadtxt(tmp_path / "wall.table", unpack=True)
    law = wall.evaluate(gap)
    assert np.allclose(traction, law.traction, rtol=0, atol=1e-15 * np.abs(traction).max())
    assert np.allclose(energy, law.energy, rtol=0, atol=1e-15 * np.abs(energy).max())
    if isinstance(wall, TabulatedWall):
        assert (read_wall_table(tmp_path / "wall.table").gap == wall.gap).all()


def test_the_layers_of_a_slab_at_rest_have_an_exponential_again():
    wall, layer = Exponential(0.02, 0.5, 3.0), 0.5**0.5
    part, depth = law_of_atoms(wall, layer), layer * np.arange(60)[:, None]
    outside, core = np.linspace(0.0, 2.0, 9), np.linspace(-0.1, 0.0, 9)
    for gap in (outside, core):
        found = [np.sum(each, axis=0) for each in part.evaluate(gap + depth)[:2]]
        # The remainder of the exponential below its third order, and one of rounding.
        rest = (
            0.02 / 6 * np.minimum(gap, 0.0) ** 2 / 0.5**2 * np.array([-np.minimum(gap, 0.0) / 0.5, 3 / 0.5 + 0 * gap])
        )
        for each, whole, left in zip(found, wall.evaluate(gap)[:2], rest, strict=True):
            assert (np.abs(each - whole) <= np.exp(-layer / 0.5) * 1.1 * left + 1e-15).all()
    assert np.isinf(felt(LennardJones93(adhesion_length=0.02)))
    assert np.abs(part.evaluate(np.array([felt(part)])).traction / part.largest_tension) == pytest.approx(2**-52)
    # Without a second layer it is whole.
    assert law_of_atoms(wall, np.inf) == wall


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_the_pieces_of_a_table_are_as_many_as_its_tolerance_asks_for(tolerance):
    gap = np.linspace(0.7, 5.0, 4001)
    decay = np.exp(-3.0 * (gap - 1.0))
    law = decay**2 - decay
    wall = TabulatedWall(gap, law - law[-1])
    native = native_law(wall, tolerance)
    pieces = vectors(native.lines)["beginning"].size
    gap = np.linspace(wall.gap[0], wall.gap[-1], 9973)[1:-1]
    law = wall.evaluate(gap).traction
    # Between the points where the error was measured, 20 to a piece, it is hardly larger.
    assert (np.abs(looked_up(native.lines, gap) - law) <= 1.1 * tolerance * np.maximum(law, wall.largest_tension)).all()
    assert native.error <= tolerance * wall.traction.max()
    assert native.lines.count("ternary") == 3  # nothing nests, whatever the tolerance
    # On pieces of the length l a Hermite spline errs by l^4/384 times the fourth derivative, of Morse's law
    # 81 (16 d² - d) with d = e^(-3x).  Relative to the traction d² - d, or to the largest tension of 1/4, that is most
    # where both are equal: d = (1 + √2)/2.  The number of pieces grows in steps of a quarter.
    d = (1 + 2**0.5) / 2
    fewest = 4.3 * (81 * (16 * d**2 - d) / 0.25 / 384 / tolerance) ** 0.25
    assert 0.95 * fewest < pieces < 1.3 * fewest


def test_a_short_table_of_equal_rows_is_exact():
    wall = table(24)
    native = native_law(wall, 1e-9)
    assert vectors(native.lines)["beginning"].size == 23
    assert native.error < 1e-13 * wall.traction.max()


@pytest.mark.parametrize("rows", [*range(8, 40), 201])
def test_a_table_of_equal_rows_is_its_own_pieces_however_many(rows):
    """A cubic between two rows is that of the table: no other number of pieces meets a tolerance of rounding."""
    gap = np.linspace(0.7, 1.4, rows + 1)
    law = LennardJonesSpline(0.35).evaluate(gap).traction + 0.01 * np.sin(20 * gap) * (1.4 - gap) ** 2
    wall = TabulatedWall(gap, np.append(law[:-1], 0.0))
    native = native_law(wall, 1e-13)
    assert vectors(native.lines)["beginning"].size == rows
    assert native.error < 1e-13 * wall.traction.max()


@pytest.mark.parametrize("knots", [24, 1200])
def test_the_error_of_a_table_is_that_at_twenty_places_in_each_piece_or_row(knots):
    wall = table(knots)
    native = native_law(wall, 1e-3)
    start, end = wall.gap[0], wall.gap[-1]
    pieces = vectors(native.lines)["beginning"].size
    count = 20 * max(pieces, knots - 1)
    gap = start + (np.arange(count) + 0.5) * (end - start) / count
    error = np.abs(looked_up(native.lines, gap) - wall.evaluate(gap).traction).max()
    assert native.error == pytest.approx(error, rel=1e-9, abs=1e-13)
    assert native.error > 1e-9 or pieces == knots - 1


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.floats(0.01, 0.4), min_size=4, max_size=40),
    st.lists(st.floats(-1.0, 3.0), min_size=4, max_size=4),
)
def test_tables_of_any_rows_are_met_or_state_what_is_left(steps, tractions):
    gap = 0.5 + np.cumsum(steps)
    traction = np.interp(gap, np.linspace(gap[0], gap[-1], 4), [4.0, *tractions[1:3], 0.0])
    wall = TabulatedWall(gap, traction)
    native = native_law(wall)
    at = np.linspace(gap[0], gap[-1], 3001)[1:-1]
    # 1.2: between the points where the error was measured.
    assert np.abs(looked_up(native.lines, at) - wall.evaluate(at).traction).max() <= 1.2 * native.error + 1e-13


def vectors(lines: str) -> dict[str, np.ndarray]:
    """The vectors of a law's lines."""
    joined = lines.replace("&\n", "")
    return {name: np.fromstring(text, sep=",") for name, text in re.findall(r'(\w+) vector "\[(.*)\]"', joined)}


def looked_up(lines: str, gap: np.ndarray) -> np.ndarray:
    """The traction by the vectors of a law's lines, as its formulas look it up."""
    found = vectors(lines)
    start, length = (float(v) for v in re.search(r"floor\(\(v_gap-\((.*?)\)\)/(.*?)\)", lines).groups())
    piece = np.floor((gap - start) / length).astype(int)
    s = gap - found["beginning"][piece]
    return sum(found[f"a{i}"][piece] * s**i for i in range(4))


@pytest.mark.parametrize("name", ["lennard-jones-12-6", "exponential", "long table"])
def test_the_energy_belongs_to_the_force(tmp_path, name):
    deck = spread(WALLS[name])
    force = run_in_process(write_deck(tmp_path, deck)).force
    with Session(tmp_path) as session:
        energy = {h: session.under(replace(deck, separation=1.0 + h)).wall_energy for h in (-1e-5, 1e-5)}
    # Error h²/6 times the third derivative of the energy, about 1e3 per atom near the core; a kink of the table's
    # curvature costs h times its size.
    slope = (energy[1e-5] - energy[-1e-5]) / 2e-5
    assert slope == pytest.approx(-force, rel=1e-6)


class Newcomer(Exponential):
    """A law that is added to the table of formulas, or has none."""


def test_a_new_law_is_written_and_read_by_its_line_in_one_table(tmp_path, monkeypatch):
    written: list[float] = []

    def lines(wall: Exponential, tolerance: float) -> NativeLaw:
        written.append(tolerance)
        return LAWS[Exponential](wall, tolerance)

    monkeypatch.setitem(LAWS, Newcomer, lines)
    run_in_process(write_deck(tmp_path / "new", spread(Newcomer(0.01, 0.2, 3.0))))
    assert a.read(tmp_path / "new").wall == Newcomer(0.01, 0.2, 3.0)
    assert len(written) == 1  # once for all, as the pieces of a law may take a fifth of a second


@pytest.mark.parametrize("wall", [Newcomer(0.02, 0.2, 3.0), LennardJones93(adhesion_length=0.02)])
def test_a_law_without_a_formula_is_written_in_pieces_and_read_as_a_table(tmp_path, wall):
    deck = spread(wall)
    result = run_in_process(write_deck(tmp_path, deck))
    law, stated = deck.law.evaluate(result.gap), native_law(deck.law).error
    within = result.gap > native_start(wall)
    # Where the stiffness of an exponential jumps, by 3 E*/a0, a piece of 10 a0/4096 errs by less than 3/4 of that.
    assert 0 < stated < 2e-3
    assert np.abs(result.traction - law.traction)[within].max() <= 1.1 * stated
    read = a.read(tmp_path).wall
    assert type(read) is TabulatedWall
    exact, stated = wall.evaluate(result.gap), native_law(wall).error
    assert np.abs(read.evaluate(result.gap).traction - exact.traction)[within].max() <= stated


def native_start(wall: Wall) -> float:
    """Gap below which a table goes on with constant stiffness."""
    return float(vectors(native_law(wall).lines)["beginning"][0])


def test_a_law_that_cannot_be_read_is_one_message(tmp_path, capsys):
    run_in_process(write_deck(tmp_path, spread(WALLS["lennard-jones-spline"])))
    description = json.loads((tmp_path / "deck.json").read_text())
    for wall, message in (
        ({"law": "Morse", "depth": 1.0}, "'Morse' is not known to this version"),
        ({"law": "LennardJonesSpline", "depth": 1.0}, "depth"),
        ({"law": "LennardJonesSpline", "range": -1.0}, "range = -1.0"),
        ({}, "law"),
    ):
        (tmp_path / "deck.json").write_text(json.dumps(description | {"wall": wall}))
        assert main(["read", str(tmp_path), "-o", str(tmp_path / "out")]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert "Traceback" not in error
        assert not (tmp_path / "out").exists()
