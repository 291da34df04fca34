"""A wall that moves above warm atoms: averages against equilibria, equipartition, seeds, restarts, friction."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.front.cli import main
from atomistic.inputs.deck import steps_of
from atomistic.inputs.motion import kelvin, thermal_energy
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.directory import finished_steps
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.protocol import Motion, largest_timestep
from atomistic.lammps.result import DeckStatus, LammpsError, read_result
from atomistic.lammps.session import Session
from atomistic.lammps.shape import HeightSpline, Waves
from atomistic.show.decks import draw_trace
from continuum.inputs.errors import InputError
from continuum.inputs.units import Units
from tests.problems import lmp

WALL = c.InversePowers((9, 3), adhesion_length=0.02)
SHAPE = (4, 5)
WAVY = Waves((4.0, 5.0), 0.0, ((0.05, 1, 0, 0.3), (0.03, 0, 1, 0.0)))
STEP = largest_timestep(Springs(), WALL)


def resting(temperature: float, windows: int = 2, duration: float = 50.0, **changes) -> Motion:
    """A wall at rest at one separation."""
    motion = Motion((1.0,) * (windows + 1), (0.0,) * (windows + 1), (duration,) * windows, temperature, 2, 0.5, 1, STEP)
    return replace(motion, **changes)


def deck(motion: Motion | None, mobile: int = 3, height: float = 0.0) -> Deck:
    x, y = np.moveaxis(Slab(SHAPE, mobile).positions[0, ..., :2], -1, 0)
    heights, at = WAVY.evaluate(x, y).height + height, 1.0 if motion is None else motion.separations[0]
    return Deck(Slab(SHAPE, mobile), Springs(), WALL, heights, at, tolerance=1e-11, protocol=motion)


def averages(directory: Path) -> dict[str, tuple[float, float]]:
    """Means of all windows but the first, and their standard errors."""
    windows = [read_result(directory, step).averages for step in finished_steps(directory)[1:]]
    return {
        name: (
            float(np.mean([window[name][0] for window in windows])),
            float(np.sqrt(np.sum([window[name][1] ** 2 for window in windows]))) / len(windows),
        )
        for name in windows[0]
    }


def equipartition(tmp_path: Path, windows: int, duration: float) -> None:
    """Of a slab that the wall does not reach, by the thermostat of its lowest two layers alone."""
    temperature = 1e-5
    motion = resting(temperature, windows, duration)
    found = replace(deck(motion, height=2.0), wall=c.LennardJonesSpline(0.0))
    run_in_process(write_deck(tmp_path, found))
    means = averages(tmp_path)
    atoms = found.slab.mobile * found.slab.ids[0].size
    kinetic, error = means["temperature"]
    assert error < 0.03 * temperature
    # Velocity Verlet: (ω Δt)²/4 = 0.3 % of the kinetic energy of the fastest modes, ω² = 8 k/m; less of the others.
    assert kinetic == pytest.approx(temperature, abs=3 * error + 0.003 * temperature)
    # Half of the energy is potential, 3/2 k_B T of each atom; beyond it, terms of the order of T².
    potential, error = means["total_energy"]
    assert error < 0.03 * 1.5 * atoms * temperature
    assert potential == pytest.approx(1.5 * atoms * temperature, abs=3 * error + 0.003 * 1.5 * atoms * temperature)
    assert means["load"] == (0.0, 0.0)


def test_each_degree_of_freedom_has_its_share(tmp_path):
    equipartition(tmp_path, 2, 200.0)


@pytest.mark.long
def test_each_degree_of_freedom_has_its_share_to_the_third_digit(tmp_path):
    equipartition(tmp_path, 40, 400.0)


def test_as_it_gets_cold_the_averages_are_those_of_the_equilibrium(tmp_path):
    static = run_in_process(write_deck(tmp_path / "static", deck(None))).require()
    differences = []
    for temperature in (1e-5, 1e-7):
        warm = replace(deck(resting(temperature)), displacements=static.displacements)
        directory = write_deck(tmp_path / f"{temperature}", warm)
        run_in_process(directory)
        means = averages(directory)
        load, error = means["load"]
        # The mean differs by T and third derivatives of the energy, some hundred for each atom, and its own error.
        assert load == pytest.approx(static.force, abs=4 * error + 100 * 20 * temperature)
        differences.append(abs(load - static.force))
        # Atoms within four amplitudes of where the traction changes sign touch now and then.
        close = np.abs(static.gap - WALL.zero_gap) < 4 * (temperature / Springs().stiffness) ** 0.5
        assert means["area_rep"][0] == pytest.approx(static.area_rep, abs=float(close.mean()))
        assert read_result(directory).status is DeckStatus.AVERAGED
    assert differences[1] < 0.2 * differences[0]


@pytest.mark.long
def test_two_seeds_agree_within_small_errors(tmp_path):
    found = []
    for seed in (1, 2):
        directory = write_deck(tmp_path / f"{seed}", deck(resting(1e-4, 30, 300.0, seed=seed)))
        run_in_process(directory)
        found.append(averages(directory))
    one, two = found
    for name in ("load", "area_rep", "area_att", "mean_gap", "temperature"):
        assert one[name][0] != two[name][0]
        assert one[name][0] == pytest.approx(two[name][0], abs=3 * np.hypot(one[name][1], two[name][1]))
        assert one[name][1] == pytest.approx(two[name][1], rel=0.8)


def test_a_stopped_motion_goes_on_with_the_same_numbers(tmp_path):
    motion = replace(resting(1e-4, 3, 10.0), separations=(1.1, 1.1, 1.0, 1.1))
    whole, stopped = write_deck(tmp_path / "whole", deck(motion)), write_deck(tmp_path / "stopped", deck(motion))
    run_in_process(whole)
    run_command(stopped, command=f"{lmp()} -var last 2")
    assert finished_steps(stopped) == (1, 2)
    (stopped / "state.part").write_text("half")
    run_in_process(stopped)
    for name in [f"{kind}.{step}.dump" for kind in ("state", "surface") for step in (1, 2, 3)]:
        assert (whole / name).read_bytes() == (stopped / name).read_bytes()
    results = [read_result(whole, step) for step in (1, 2, 3)]
    assert [result.separation for result in results] == pytest.approx([1.1, 1.0, 1.1], abs=1e-14)
    # Samples are taken at the end of each of 30 stretches.
    assert [result.averages["separation"][0] for result in results] == pytest.approx([1.1, 1.05, 1.05], abs=0.1 / 30)
    # The straight line of a wall that moves is no scatter, but for the root of rounding.
    assert results[1].averages["separation"][1] < 1e-7
    assert results[1].averages["load"][0] < results[1].force
    assert results[0].evaluations == 10 * motion.block[0] + 1


def test_a_window_that_is_not_whole_leaves_no_averages(tmp_path):
    directory = write_deck(tmp_path, deck(resting(1e-5, 3, 1e4)))
    with pytest.raises(LammpsError, match="no complete result"):
        run_command(directory, f"{lmp()} -var timeout 1")
    assert finished_steps(directory) == ()


def test_nothing_that_slides_without_a_jump_has_friction(tmp_path):
    # Every atom sees the same wall: a barrier from site to site, too low for the slab's stiffness to jump.
    period, size = (4.0, 3.0), 12
    wall = Waves(period, 0.0, ((0.02, 4, 0, 0.0),))
    count, way = 6, 1.0
    motion = Motion(
        (0.9,) * (count + 2),
        (0.0, *np.linspace(0, way, count + 1)),
        (20.0,) + (way / count / 0.01,) * count,
        0.0, 2, 2.0, 1, STEP,
    )  # fmt: skip
    slab = Slab((4, 3), 3)
    start = Deck(slab, Springs(), WALL, np.full((4, 3), 0.02), 0.9, tolerance=1e-12, shape=wall)
    at_rest = run_in_process(write_deck(tmp_path / "rest", start)).require()
    run_in_process(write_deck(tmp_path / "slide", replace(start, protocol=motion, displacements=at_rest.displacements)))
    windows = [read_result(tmp_path / "slide", step) for step in range(2, count + 2)]
    forces = np.array([window.averages["lateral_x"][0] for window in windows])
    largest = np.abs(forces).max()
    assert largest > 1e-3 * size
    # What is left is drag, proportional to the velocity.
    assert abs(forces.mean()) < 0.01 * largest

    def energy(offset: float) -> float:
        moved = Waves(period, 0.0, ((0.02, 4, 0, -2 * np.pi * offset),))
        heights = moved.evaluate(*np.moveaxis(slab.positions[0, ..., :2], -1, 0)).height
        found = replace(start, shape=moved, heights=heights, displacements=at_rest.displacements)
        return run_in_process(write_deck(tmp_path / "static", found, force=True)).require().total_energy

    # The mean force over a stretch is the work done there: the difference of the energies of its ends.
    for i in (0, 2):
        ends = [energy(way * j / count) for j in (i, i + 1)]
        assert forces[i] == pytest.approx((ends[1] - ends[0]) / (way / count), abs=0.02 * largest)


def test_the_command_slides_a_wall_and_prints_its_friction(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("atomistic.show.decks.save_figure", lambda _, stem: stem)
    text = """
follows = "atom"
[interatomic]
kind = "springs"
[slab]
n = 8
depth = 2.2
[surface]
kind = "sine"
amplitude = 0.05
waves = [2, 0]
[wall]
law = "lennard-jones-9-3"
adhesion_length = 0.005
[protocol]
kind = "sliding"
separation = 1.0
velocity = 0.1
distance = 0.5
temperature = 1e-5
window = 2.0
thermostat_layers = 1
"""
    (tmp_path / "slide.toml").write_text(text)
    assert main(["deck", str(tmp_path / "slide.toml"), "-o", str(tmp_path / "slide"), "--run"]) == 0
    capsys.readouterr()
    assert main(["read", str(tmp_path / "slide"), "-o", str(tmp_path / "out"), "--compare"]) == 0
    # What slides has no continuum beside it: in a table and in a file that is a remark.
    assert "The wall slides" in capsys.readouterr().out
    assert (tmp_path / "out/slide.h5").is_file()
    run = a.read(tmp_path / "slide")
    assert "friction/A0" in run.sheets()[0].text()
    assert "± N/A0" in run.sheets()[0].text()
    assert "Means over the 2 windows in which the wall slides" in run.sheets()[0].text()
    assert run.mean("lateral_x").mean == pytest.approx(np.mean([step.lateral_x for step in run.steps[1:]]), rel=1e-12)
    assert [step.offset_x for step in run.steps] == pytest.approx([0, 0.125, 0.375], abs=0.02)
    assert run.converged
    # The trace has what the means are of, in the units of the steps.
    assert np.array_equal(np.unique(run.trace["window"]), [1, 2, 3])
    for i, step in enumerate(run.steps, 1):
        here = run.trace["window"] == i
        for name in ("lateral_x", "load", "offset_x", "temperature"):
            assert run.trace[name][here].mean() == pytest.approx(getattr(step, name), rel=1e-9, abs=1e-15)
    assert np.array_equal(run.trace["lateral_s"], run.trace["lateral_x"])
    assert np.all(np.diff(run.trace["offset_x"][run.trace["window"] > 1]) > 0)
    assert len(draw_trace(run).axes) == 3
    # The wall of each window is a mesh where it then was.
    mesh = (tmp_path / "out/slide-wall.3.vtk").read_text().splitlines()[5].split()
    assert float(mesh[0]) == pytest.approx(run.steps[2].offset_x, abs=1e-9)
    assert np.ptp(run.heights) == pytest.approx(0.1)
    with pytest.raises(InputError, match="The wall slides"):
        run.compare()
    assert "The wall slides" in run.sheets(compare=True)[-1].text()
    assert "slides" not in run.sheets()[-1].text()


def test_an_array_slides(tmp_path):
    with pytest.warns(UserWarning, match="fewer than 4 points"):
        contact = c.Contact(0.02 * np.random.default_rng(1).standard_normal((5, 4)), WALL)
    table = {"kind": "sliding", "separation": 1.0, "distance": 1.0, "velocity": 0.25, "window": 2.0, "temperature": 0.0}
    made = a.deck(contact, protocol=table | {"thermostat_layers": 1}, depth=2.2, follows="atom")
    run = a.run_deck(made.write(tmp_path / "deck"))
    assert run.finished
    # One a0 on, the wall is that of the start, shifted by an atom.
    above = HeightSpline(contact.heights).evaluate(*np.moveaxis(
        made.slab.positions[0, ..., :2] + run.last.displacements[0, ..., :2] - [1, 0], -1, 0
    ))  # fmt: skip
    assert np.allclose(run.last.heights, above.height, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"temperature": "300C"}, "not a unit of temperature"),
        ({"temperature": "300K"}, "this crystal has no length scale"),
        ({"temperature": -1.0}, "zero or more"),
        ({"separations": [1.0, 1.0]}, "another one each time"),
        ({"window": 1e-7}, "greater than or equal to 1"),
        ({"separations": [100.0, 0.0], "velocity": 1e-4}, "at most 10000 windows"),
        ({"thermostat_layers": 40}, "fewer than the layers that move"),
        ({"kind": "sliding", "separation": 1.0, "distance": 1.0}, "cannot slide"),
    ],
)
def test_a_motion_that_makes_no_sense_is_refused(changes, message):
    table = {"kind": "velocity", "separations": [1.2, 1.1], "velocity": 0.01, "temperature": 1e-5, "window": 10.0}
    table |= changes
    if table["kind"] == "sliding":
        del table["separations"]
    heights = c.sine(c.Grid.square(8), 0.05, (1, 0))
    with pytest.raises((ValueError, InputError), match=message):
        a.deck(c.Contact(heights, WALL), protocol=table, depth=4)


def test_kelvin_are_energies_of_a_crystal_with_a_size():
    # k_B 300 K = 25.85 meV; E* a0³ of copper, 135 GPa (2.556 Å)³, is 14.1 eV.
    assert thermal_energy("300K", Units(2.556e-10, 135.2e9)) == pytest.approx(0.02585 / 14.09, rel=1e-3)


def drift(tmp_path: Path, factor: float) -> tuple[float, float]:
    """Atoms swing into the wall and out of it by Newton's law: change of energy by that of motion, and load."""
    slab = Slab(SHAPE, 3)
    start = np.zeros((slab.layers, *SHAPE, 3))
    # Stretched as a whole: it swings in the slowest mode of the slab, into the wall's attraction and into its core.
    start[: slab.mobile, ..., 2] = -0.12 * (1 - np.arange(slab.mobile) / slab.mobile)[:, None, None]
    directory = write_deck(tmp_path / f"{factor}", Deck(slab, Springs(), WALL, deck(None).heights, 1.08, start))
    with Session(directory) as session:
        session.command("variable separation equal 1.08")
        session.run("in.wall")
        session.command("thermo_style custom etotal ke c_load")
        session.command("thermo_modify norm no")
        for name, value in (("total", "etotal"), ("motion", "ke"), ("push", "c_load")):
            session.command(f"variable {name} equal {value}")
        session.command("fix motion mobile nve")
        session.command(f"timestep {factor * STEP:.17g}")
        session.command("run 0 post no")
        seen = []
        for _ in range(40):
            seen.append([session.variable(name) for name in ("total", "motion", "push")])
            session.command(f"run {round(10 / factor)} post no")
    total, motion, push = np.transpose(seen)
    return float(np.ptp(total) / motion.max()), float(push.max())


def test_energy_is_conserved_through_contact_as_the_square_of_the_time_step(tmp_path):
    drifts, pushes = zip(*(drift(tmp_path, factor) for factor in (2.0, 1.0, 0.5)), strict=True)
    assert pushes[1] > 0.1
    # At the time step of a deck the energy changes by 1e-3 of what is turned over, and by a quarter at half of it.
    assert drifts[1] < 1e-3
    for coarse, fine in pairwise(drifts):
        assert coarse / fine == pytest.approx(4, rel=0.1)


@given(st.text(), st.text(), st.floats())
def test_no_text_of_a_user_reaches_a_motion(temperature, along, velocity):
    table = {"kind": "sliding", "separation": 1.0, "distance": 1.0, "window": 10.0}
    try:
        motion = steps_of(table | {"temperature": temperature, "along": along, "velocity": velocity}).motion
    except InputError:
        return
    assert motion.along in ("x", "y")
    assert kelvin(motion.temperature) >= 0
