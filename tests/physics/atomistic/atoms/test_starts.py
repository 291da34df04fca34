"""Decks whose states the package has relaxed: LAMMPS finds them at rest, and says where it does not."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.atoms.starts import with_starts
from atomistic.front.cli import main
from atomistic.inputs.deck import DeckConfig
from atomistic.lammps.deck import Deck
from atomistic.lammps.engine import run_command
from atomistic.lammps.protocol import MeanPressures
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.reading import parsed, source_of
from tests.problems import two_ranks

CONFIRMED = 2
"""Evaluations of a step that is at rest: that of its start, and that of its output."""
SOFTNESS = 100.0
"""Displacement of an atom over the force that is left on each of the slab, in a0/E*: they add up over seven layers, and
move a slab 4 a0 deep by some 4 a0/E*."""


def contact() -> c.Contact:
    heights = c.SelfAffine(0.8, 0.05, 4, 8).synthesise(c.Grid.square(8), np.random.default_rng(1))
    return c.Contact(heights, c.LennardJonesSpline(adhesion_length=0.005))


def deck(**given: Any) -> Deck:
    return a.deck(contact(), **{"depth": 4, "separations": [1.2, 1.05]} | given)


def other_face(**tables: Any) -> Deck:
    """A (111) face under a sphere, by a formula that follows the atoms."""
    given = {
        "interatomic": {"kind": "springs"}, "crystal": {"face": "111"}, "slab": {"n": 8, "depth": 2.0},
        "surface": {"kind": "sphere", "radius": 40.0}, "separation": 1.0, "follows": "atom",
        "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    }  # fmt: skip
    return a.deck(parsed(source_of(given | tables, "deck"), DeckConfig))


DECKS: Mapping[str, Any] = {
    "sites": deck,
    "one": lambda: deck(separations=None, separation=1.05),
    "pressures": lambda: deck(separations=None, pressures=[0.01]),
    "atoms": lambda: deck(follows="atom", wall_force="atoms", wall_crystal={"form": "bent"}),
    "face": other_face,
    "alloy": lambda: a.deck("inputs/lammps/own.toml"),
}


@pytest.mark.parametrize("kind", DECKS)
def test_the_states_are_those_without_starts_and_lammps_only_confirms_them(kind: str, tmp_path: Path) -> None:
    plain = DECKS[kind]()
    told: list[tuple[int, int]] = []
    ready = with_starts(plain, lambda done, steps: told.append((done, steps)))
    steps = 1 if plain.protocol is None else plain.protocol.steps
    assert told == [(i + 1, steps) for i in range(steps)]
    alone, confirmed = (a.run_deck(d.write(tmp_path / str(i))) for i, d in enumerate((plain, ready)))
    assert alone.converged
    assert confirmed.converged
    assert confirmed.gaps == pytest.approx(alone.gaps, abs=SOFTNESS * plain.tolerance)
    for step in confirmed.steps:
        assert step.evaluations == CONFIRMED
        assert step.start_force <= confirmed.last.tolerance
        assert step.moved == 0
    assert np.isnan(alone.last.moved)
    # LAMMPS takes 90 evaluations or more of a state; here is also what the response of so small a slab costs.
    mine = int(ready.notes[-1].split()[-5])
    assert 3 * (mine + CONFIRMED * steps) < sum(step.evaluations for step in alone.steps)
    assert f"{steps} of {steps} starts that were relaxed before are at rest" in confirmed.sheets()[-1].text()
    assert "starts" not in alone.sheets()[-1].text()


def test_a_wrong_start_is_seen(tmp_path: Path) -> None:
    directory = deck(start=True).write(tmp_path / "deck")
    start = directory / "start.2.dump"
    lines = start.read_text().splitlines()
    assert lines[:2] == ["ITEM: TIMESTEP", "2"]
    first = lines.index("ITEM: ATOMS id xu yu zu") + 1
    number, x, y, z = lines[first].split()
    lines[first] = f"{number} {x} {y} {float(z) + 0.1!r}"
    start.write_text("\n".join(lines) + "\n")
    run = a.run_deck(directory)
    assert run.converged  # LAMMPS goes on from it, and the state is the same
    assert [step.evaluations > CONFIRMED for step in run.steps] == [False, True]
    assert run.steps[1].moved == pytest.approx(0.1, rel=0.1)
    assert run.steps[1].start_force > 0.1 * 0.1  # the atom is on springs of 0.73 E* a0
    told = " ".join(run.sheets()[-1].text().split())
    assert "1 of 2 starts that were relaxed before are at rest" in told
    assert "Farthest from it is that of step 2" in told


def test_a_deck_goes_on_where_it_was_stopped_also_on_two_ranks_and_with_fewer_starts(tmp_path: Path) -> None:
    ready = deck(start=True)
    whole = ready.write(tmp_path / "whole")
    a.run_deck(whole)
    stopped = shutil.copytree(whole, tmp_path / "stopped")
    for name in ("result.2.json", "state.2.dump", "surface.2.dump"):
        (stopped / name).unlink()
    a.run_deck(stopped)
    assert (stopped / "state.2.dump").read_bytes() == (whole / "state.2.dump").read_bytes()
    # On two ranks every atom is where it was written, and the sum over both has another order.
    fewer = replace(ready, starts=ready.starts[:1], tolerance=1e-6)
    ranks = run_command(fewer.write(tmp_path / "ranks"), two_ranks())
    run = a.read(tmp_path / "ranks")
    assert run.steps[0].moved == 0
    assert run.steps[0].evaluations == CONFIRMED
    # The second has none, and starts from the first.
    assert ranks.evaluations > CONFIRMED
    assert run.steps[1].moved > 0.01
    assert ranks.gap == pytest.approx(a.read(whole).gaps[-1], abs=SOFTNESS * fewer.tolerance)
    # A longer staircase keeps what is finished.
    deck(separations=[1.2, 1.05, 1.2], start=True).write(whole)
    assert len(a.read(whole).steps) == 2


def test_states_are_relaxed_up_to_the_first_that_is_none() -> None:
    ready = deck(separations=None, pressures=[0.01])
    beyond = MeanPressures((0.01, -5.0), (ready.separation, 1.1), 0.1)
    found = with_starts(replace(ready, protocol=beyond))
    assert len(found.starts) == 1
    assert found.notes[-1].startswith("Starts: 1 of 2 states")
    assert found.protocol is not None
    assert found.protocol.separations[1] == 1.1


def test_a_wall_in_motion_has_no_states_at_rest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ArgumentError, match="starts"):
        replace(deck(), starts=3 * (np.zeros((7, 8, 8, 3)),))
    assert main(["deck", "inputs/lammps/sliding.toml", "--output", str(tmp_path), "--start"]) == 2
    assert "a wall in motion has no states at rest" in capsys.readouterr().err


@pytest.mark.long
def test_a_learned_potential_runs_from_end_to_end(tmp_path: Path) -> None:
    """SNAP of copper (Zuo et al., J. Phys. Chem. A 124, 731 (2020)), whose files come with LAMMPS."""
    names = [f"Cu_Zuo_JPCA2020.{kind}" for kind in ("snapcoeff", "snapparam")]
    contents = a.PairStyle.read_files([a.find_potential(name) for name in names])
    words = (("*", "*", *names, "Cu"),)
    snap = a.PairStyle("snap", "Cu", 63.546, 4.2, 3.62, coefficients=words, contents=contents)
    made = deck(model=snap, depth=3, separations=None, separation=1.05, start=True)
    run = a.run_deck(made.write(tmp_path / "deck"))
    assert {f"potential.{i}" for i in (1, 2)} <= {path.name for path in (tmp_path / "deck").iterdir()}
    assert run.converged
    assert (run.last.evaluations, run.last.moved) == (CONFIRMED, 0)
