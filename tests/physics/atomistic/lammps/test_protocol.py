"""Staircases and given pressures: what a deck does step by step, and that it goes on where it was stopped."""

import os
import shutil
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.lammps import engine
from atomistic.lammps.deck import Deck, render, step_keys, write_deck
from atomistic.lammps.directory import finished_steps
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.protocol import MeanPressures
from atomistic.lammps.result import DeckResult, DeckStatus, read_result
from atomistic.relax.specimen import Specimen
from continuum.inputs.errors import InputError, OutputError
from continuum.model.problem import ContactProblem
from continuum.path import loading
from continuum.solve.solution import Settings
from tests.problems import lmp, two_ranks

GRID = c.Grid.square(8)


def rough() -> c.Contact:
    heights = c.SelfAffine(0.8, 0.05, 4, 8).synthesise(GRID, np.random.default_rng(1))
    return c.Contact(heights, c.LennardJonesSpline(adhesion_length=0.005))


def results(directory: Path) -> list[DeckResult]:
    return [read_result(directory, step).require() for step in finished_steps(directory)]


def test_a_sticky_surface_jumps_in_and_out_where_the_lattice_does(tmp_path):
    # A slab 12 a0 deep gives way as a whole by 12/C11, softer than the law's 1/6: it jumps.
    step, depth, wall = 0.05, 12.0, c.LennardJonesSpline(adhesion_length=0.05)
    in_, out = np.arange(2.15, 1.9, -step), np.arange(1.95, 2.41, step)
    separations = [*in_, *out]
    grid = c.Grid.square(5)
    heights = c.sphere(grid, 200.0)
    with pytest.warns(UserWarning, match="fewer than 4 points"):  # the edge of the period, on so small a grid
        contact = c.Contact(heights, wall)
    deck = replace(a.deck(contact, separations=separations, depth=depth), tolerance=1e-7)
    atoms = [result.force / grid.area for result in results_of(deck, tmp_path / "deck")]

    lattice = ContactProblem(grid, wall, heights, Specimen.of_model(a.Springs(), grid, depth).response)
    states = loading.follow(lattice, "separation", separations, Settings(1e-10))
    linear = [state.require().load for state in states]
    for loads in (atoms, linear):
        assert max(loads) < 1e-10  # nothing but attraction
        assert loads[len(in_) - 1] == pytest.approx(loads[len(in_) + 1], rel=0.1)
    # The largest change of the load between neighbouring steps is the jump; strains of 3 % move it by a step at most.
    for part in (slice(0, len(in_)), slice(len(in_), None)):
        jumps = [int(np.argmax(np.abs(np.diff(loads[part])))) for loads in (atoms, linear)]
        assert abs(jumps[0] - jumps[1]) <= 1
        assert min(np.abs(np.diff(loads[part])).max() for loads in (atoms, linear)) > 4 / 64
    # Hysteresis: it holds on the way out where it did not yet on the way in.
    assert atoms[0] == pytest.approx(0, abs=1e-10)
    assert atoms[len(in_) + int(np.argmin(np.abs(out - separations[0])))] < -4 / 64
    assert atoms[-1] == pytest.approx(0, abs=1e-10)


def results_of(deck: Deck, directory: Path) -> list[DeckResult]:
    run_in_process(write_deck(directory, deck))
    return results(directory)


def test_a_mean_pressure_is_met_on_one_core_and_on_two(tmp_path):
    pressures = (0.01, -0.002)
    deck = a.deck(rough(), pressures=pressures, depth=2.2)
    here = results_of(deck, tmp_path / "deck")
    for one, pressure in zip(here, pressures, strict=True):
        assert one.force / 64 == pytest.approx(pressure, rel=1e-6)
    # Two ranks meet the target by the same moves.
    two = run_command(write_deck(tmp_path / "two", deck), f"{two_ranks()} -var last 1")
    assert two.force == pytest.approx(here[0].force, rel=1e-8)
    assert two.separation == pytest.approx(here[0].separation, abs=1e-8)
    assert ((two.gap < 1) == (here[0].gap < 1)).all()


def test_a_pressure_that_no_separation_has_is_reported(tmp_path):
    deck = a.deck(rough(), separation=1.1, depth=6)
    beyond = MeanPressures((-5.0,), (1.1,), 0.1)
    result = run_in_process(write_deck(tmp_path, replace(deck, protocol=beyond)))
    assert result.status is DeckStatus.TARGET_MISSED


def test_a_killed_run_goes_on_from_its_last_step_to_the_same_numbers(tmp_path):
    deck = a.deck(rough(), separations=[1.3, 1.1, 1.0, 1.1, 1.2, 1.3], depth=6)
    whole, killed = write_deck(tmp_path / "whole", deck), write_deck(tmp_path / "killed", deck)
    undisturbed = run_command(whole, lmp()).require()
    assert undisturbed.step == 6
    process = subprocess.Popen(
        [engine.script("lmp"), "-in", "in.contact", "-screen", "none"], cwd=killed, start_new_session=True
    )
    while not (killed / "result.2.json").exists():
        assert process.poll() is None
        time.sleep(0.002)
    # The whole group: the wheel's lmp is a script that waits for another process, which would live on.
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    done = finished_steps(killed)
    times = {step: (killed / f"result.{step}.json").stat().st_mtime_ns for step in done}
    # Where it died does not matter: what is half written has another name, or is written anew.
    (killed / "state.part").write_text("half")
    calls: list[tuple[int, int]] = []
    run_in_process(killed, progress=lambda done, steps: calls.append((done, steps)))
    assert calls == [(step, 6) for step in range(len(done) + 1, 7)]
    assert finished_steps(killed) == (1, 2, 3, 4, 5, 6)
    assert all((killed / f"result.{step}.json").stat().st_mtime_ns == times[step] for step in done)
    for name in [f"{kind}.{step}.dump" for kind in ("state", "surface") for step in range(1, 7)]:
        assert (killed / name).read_bytes() == (whole / name).read_bytes()


def test_the_same_deck_keeps_its_steps_and_another_one_removes_none_unasked(tmp_path):
    deck = a.deck(rough(), separations=[1.3, 1.2], depth=4)
    directory = write_deck(tmp_path / "deck", deck)
    run_in_process(directory)
    before = {path.name: path.read_bytes() for path in directory.iterdir()}
    write_deck(directory, deck)
    other = replace(deck, heights=deck.heights + 1e-15)
    with pytest.raises(OutputError, match="2 finished steps of another deck"):
        write_deck(directory, other)
    with pytest.raises(OutputError, match="--force"):
        a.deck(rough(), separation=1.3, depth=4).write(directory)
    assert {path.name: path.read_bytes() for path in directory.iterdir()} == before
    (directory / "in.contact").unlink()  # a writer that was killed
    write_deck(directory, deck)
    assert finished_steps(directory) == (1, 2)
    other.write(directory, force=True)
    assert finished_steps(directory) == ()
    assert not list(directory.glob("*.dump"))


def test_a_staircase_that_is_made_longer_goes_on(tmp_path):
    short, long, turned = (
        a.deck(rough(), separations=s, depth=4) for s in ([1.3, 1.2], [1.3, 1.2, 1.1, 1.5], [1.3, 1.25])
    )
    directory = write_deck(tmp_path / "deck", short)
    run_in_process(directory)
    times = [(directory / f"result.{step}.json").stat().st_mtime_ns for step in (1, 2)]
    write_deck(directory, long)
    assert finished_steps(directory) == (1, 2)
    run_in_process(directory)
    assert [(directory / f"result.{step}.json").stat().st_mtime_ns for step in (1, 2)] == times
    whole = write_deck(tmp_path / "whole", long)
    run_in_process(whole)
    # The box ends above the wall at its highest, and so atoms are sorted in other bins: sums differ by rounding.
    assert [each.force for each in results(directory)] == pytest.approx(
        [each.force for each in results(whole)], rel=1e-6
    )
    # A shorter one would leave results that it does not know of.
    with pytest.raises(OutputError, match="2 finished steps"):
        write_deck(directory, short)
    # One that reverses elsewhere keeps what comes before.
    with pytest.raises(OutputError, match="3 finished steps"):
        write_deck(directory, turned)
    write_deck(directory, turned, force=True)
    assert finished_steps(directory) == (1,)
    run_in_process(directory)
    assert [result.separation for result in results(directory)] == [1.3, 1.25]


def test_a_motion_that_differs_in_any_number_shares_no_step():
    table = {"kind": "velocity", "separations": [1.3, 1.2], "temperature": 1e-4, "velocity": 0.01, "window": 10.0}

    def keys(**changes: object) -> list[str]:
        deck = a.deck(rough(), protocol=table | changes, depth=4)
        return step_keys(deck, render(deck))

    own = keys()
    for changes in ({"seed": 2}, {"temperature": 2e-4}, {"damping": 3.0}, {"hold": 2}, {"velocity": 0.02}):
        assert not set(own[1:]) & set(keys(**changes)[1:])
    assert keys(separations=[1.3, 1.2, 1.3])[: len(own)] == own


def test_an_approach_and_its_way_back_are_one_branch_where_nothing_jumps(tmp_path):
    found = results_of(a.deck(rough(), separations=[1.3, 1.1, 1.3], depth=6), tmp_path / "deck")
    # Forces are left up to 1e-8 h'rms = 5e-10, on 64 atoms.
    assert found[0].force == pytest.approx(found[2].force, abs=64 * 5e-10)
    assert [result.step for result in found] == [1, 2, 3]
    # Each step alone, from the lattice solution, is the same equilibrium.
    alone = run_in_process(write_deck(tmp_path / "alone", a.deck(rough(), separation=1.1, depth=6))).require()
    assert alone.step == 0
    assert alone.force == pytest.approx(found[1].force, abs=64 * 5e-10)
    assert (alone.gap < 1).sum() == round(alone.area_rep * 64)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: a.deck(rough(), separations=[], depth=4), "a list of 1 to"),
        (lambda: a.deck(rough(), separations=[1.0, float("nan")], depth=4), "finite"),
        (lambda: a.deck(rough(), pressures=[0.1, 0.0], depth=4), "other than zero"),
        (lambda: a.deck(rough(), depth=4), "one of"),
        (lambda: a.deck(rough(), separation=1.2, pressures=[0.1], depth=4), "one of"),
    ],
)
def test_a_protocol_that_makes_no_sense_is_refused(make, message):
    with pytest.raises((ValueError, InputError), match=message):
        make()


def test_a_deck_is_whole_before_it_has_its_script(tmp_path, monkeypatch):
    deck = a.deck(rough(), separation=1.2, depth=4)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("atomistic.lammps.deck._write_data", full)
    with pytest.raises(InputError, match="No space left"):
        write_deck(tmp_path / "deck", deck)
    assert not (tmp_path / "deck" / "in.contact").exists()
    shutil.rmtree(tmp_path / "deck")
    (tmp_path / "deck").write_text("mine")
    with pytest.raises(InputError, match="not a folder"):
        write_deck(tmp_path / "deck", deck)
    assert (tmp_path / "deck").read_text() == "mine"


def test_a_deck_of_another_size_takes_the_place_of_an_unfinished_one(tmp_path):
    """A folder of decks is the program's own: what its files begin with, such as a number of atoms, may change."""
    directory = write_deck(tmp_path / "deck", a.deck(rough(), separation=1.2, depth=4))
    other = a.deck(rough(), separation=1.2, depth=6)
    assert write_deck(directory, other) == directory
    assert f"{other.slab.size} atoms" in (directory / "README.txt").read_text()
