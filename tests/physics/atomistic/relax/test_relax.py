"""Atoms against their own linear response, and the ways to equilibrium against one another."""

import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_in_process
from atomistic.lammps.engine import script as find
from atomistic.lammps.law import read_wall_table
from atomistic.lammps.result import DeckResult, LammpsError
from atomistic.lammps.session import Session
from atomistic.relax.relax import iterate, lattice_on_every_layer, lattice_start, relax, relax_in
from atomistic.response.lattice import LatticeResponse
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.walls import InversePowers, LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from tests.problems import crystal, lattice, on_atoms
from tests.python_walls import WallSession

SPRINGS = Springs()


def test_the_response_of_the_atoms_is_that_of_the_lattice(tmp_path):
    slab = Slab.of_depth(Grid.square(10), 8.0)
    lattice = LatticeResponse.of_springs(slab, SPRINGS)
    deck = Deck(slab, SPRINGS, LennardJonesSpline(0.0), np.zeros(slab.shape), 0.0)
    write_deck(tmp_path, deck)
    point = np.zeros(slab.shape)
    point[5, 9] = SPRINGS.stiffness  # amplitudes are in k_s a0

    def answer(amplitude: float) -> np.ndarray:
        force = amplitude * point
        with WallSession(tmp_path) as session:
            session.command("variable tolerance delete")
            session.command("variable tolerance index 1e-12")
            session.command("variable evaluations index 5000")
            session.apply(lambda z: (force, -float(np.sum(force * z))))
            session.run("in.relax")
            assert session.variable("largest_force") <= 1e-12
            return session.displacements()[0, ..., 2] / amplitude

    errors = []
    for amplitude in (4e-3, 1e-3):
        symmetric = (answer(amplitude) + answer(-amplitude)) / 2
        compliance = slab.grid.forward(symmetric) / slab.grid.forward(point)
        error = compliance / lattice.compliance_q[..., 2, 2].real - 1
        errors.append(np.abs(error).max())
    # The first correction to the symmetrised response is cubic: relative to the linear one, its square.  A
    # residual force of 1e-12 in a response to 1e-3 adds 1e-9 times the softness of long waves, 1e-8 at most.
    assert 1e-8 < errors[1] < 1e-5
    assert np.log(errors[0] / errors[1]) / np.log(4) == pytest.approx(2, abs=0.1)


def test_the_lattice_start_is_the_lattice_equilibrium():
    problem, state, deck = on_atoms()
    assert np.abs(deck.start).max() > 1e-3
    expected = problem.displacement(state.gap, state.separation)
    assert np.allclose(deck.start[0, ..., 2], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("adhesion_length", [0.0, 0.005])
@pytest.mark.parametrize(("n", "slope"), [(12, 0.1), pytest.param(16, 0.001, marks=pytest.mark.long)])
def test_all_roads_lead_to_one_equilibrium(tmp_path, n, slope, adhesion_length):
    problem, _, deck = on_atoms(n, slope=slope, adhesion_length=adhesion_length)
    lattice = problem.substrate
    assert isinstance(lattice, LatticeResponse)
    # Ten times below what is asked of every equilibrium: forces of 1e-8 h' on all atoms can add up to
    # more than 1e-8 N_rep.
    deck = replace(deck, tolerance=1e-9 * slope)
    fast = relax(deck, tmp_path, lattice).require()
    plain = relax(deck, tmp_path).require()
    assert fast.evaluations < 20 < plain.evaluations
    pushing = np.maximum(fast.traction, 0).sum()
    assert plain.force == pytest.approx(fast.force, abs=1e-8 * pushing)
    # A force of this size on each atom of a column against the softest mode, K_0 = 0.06.
    atol = deck.tolerance * deck.slab.mobile / 0.06
    assert np.allclose(plain.displacements, fast.displacements, rtol=0, atol=atol)
    # It is not the lattice solution: the springs turn with the bonds.
    assert np.abs(fast.displacements - deck.start).max() > 0.01 * slope**2
    # Balance: what the wall pushes, the base takes up; no net lateral force is left.
    assert np.abs(fast.forces.sum(axis=(0, 1, 2))).max() < 1e-8 * pushing


@pytest.mark.parametrize("name", ["springs", "lj"])
def test_a_session_finds_what_the_run_of_the_deck_finds(tmp_path, name):
    problem, _, deck = on_atoms(8, slope=0.05, adhesion_length=0.005, name=name)
    with Session.on_atoms_of(deck) as session:
        first = relax_in(session, deck, problem.substrate).require()
        # What was done before leaves no trace: another wall, and atoms that LAMMPS loses.
        other = replace(deck, wall=LennardJonesSpline(0.0005), heights=-deck.heights, separation=deck.separation + 0.1)
        assert relax_in(session, other, problem.substrate).require().area_rep != first.area_rep
        with pytest.raises(LammpsError):
            session.evaluate(100 * np.random.default_rng(1).normal(size=deck.start.shape))
        again = relax_in(session, deck, problem.substrate)
    folder = Path(session.directory)
    del session
    assert not folder.exists()
    run = run_in_process(write_deck(tmp_path, replace(deck, displacements=first.displacements)))
    for field in fields(DeckResult):
        one, same, ran = (getattr(result, field.name) for result in (first, again, run))
        if isinstance(one, np.ndarray):
            assert np.array_equal(one, same)
            # Of forces, sums over neighbours in another order.
            assert np.allclose(ran, one, rtol=0, atol=1e-14)
        elif field.name == "largest_force":
            assert one == same == pytest.approx(ran, abs=1e-14)
        elif field.name not in ("slab", "evaluations", "structure", "tractions", "start_force", "moved"):
            # LAMMPS prints 15 digits of most; sums over 144 surface atoms.
            assert one == same
            assert ran == pytest.approx(one, rel=1e-12, abs=1e-13)


def test_the_difference_to_the_lattice_is_geometric(tmp_path):
    loads, displacements, slopes = [], [], (0.01, 0.0025)
    for slope in slopes:
        problem, state, deck = on_atoms(slope=slope)
        lattice = problem.substrate
        assert isinstance(lattice, LatticeResponse)
        atoms = relax(deck, tmp_path, lattice).require()
        linear = problem.wall.evaluate(state.gap).traction.sum()
        loads.append(abs(atoms.force / linear - 1))
        displacements.append(np.abs(atoms.displacements - deck.start).max())
    ratio = np.log(slopes[0] / slopes[1])
    # Leading orders h' and h'²; the next order at h' = 0.01 changes the exponent by some h'.  The area is
    # that of a few points of 144, and not the same to the last, hence 0.1.
    assert loads[0] > 1e-5
    assert np.log(loads[0] / loads[1]) / ratio == pytest.approx(1, abs=0.1)
    assert np.log(displacements[0] / displacements[1]) / ratio == pytest.approx(2, abs=0.1)


def test_a_wall_given_as_a_table_relaxes_in_process(tmp_path):
    _, _, deck = on_atoms(8, slope=0.05, adhesion_length=0.005)
    native = relax(deck, tmp_path).require()
    table = read_wall_table(tmp_path / "wall.table")
    with WallSession(tmp_path) as session:
        session.apply_wall(table, deck.heights, deck.separation)
        session.command("variable tolerance delete")
        session.command("variable tolerance index 1e-11")
        session.command("variable evaluations index 5000")
        session.run("in.relax")
        assert session.variable("largest_force") <= 1e-11
        displacements = session.displacements()
    # A traction wrong by 4e-8 everywhere would move the surface by 4e-8 / K_0 = 4e-7.
    difference = np.abs(displacements - native.displacements).max()
    assert 0 < difference < 4e-7


def test_an_iteration_that_does_not_converge_leaves_the_work_to_the_deck(tmp_path):
    problem, _, deck = on_atoms(8, slope=0.1)
    # Each correction overshoots forty times.
    wrong = LatticeResponse.of_springs(deck.slab, Springs(SPRINGS.stiffness / 40))
    write_deck(tmp_path, deck)
    with Session(tmp_path) as session:
        stopped = iterate(deck, session, wrong)
    assert not stopped.converged
    # The best state is kept, not the last.
    assert min(stopped.largest_forces) <= stopped.largest_forces[0]
    result = relax(deck, tmp_path, wrong).require()
    assert isinstance(problem.substrate, LatticeResponse)
    expected = relax(deck, tmp_path, problem.substrate).require()
    assert result.force == pytest.approx(expected.force, rel=1e-8)


@pytest.mark.parametrize(
    ("name", "adhesion_length"), [("lj", 0.005), pytest.param("Ni_u3.eam", 0.0, marks=pytest.mark.long)]
)
def test_crystals_come_to_the_equilibrium_that_lammps_finds(tmp_path, name, adhesion_length):
    problem, state, deck = on_atoms(8, slope=0.05, adhesion_length=adhesion_length, name=name)
    lattice = problem.substrate
    assert isinstance(lattice, LatticeResponse)
    deck = replace(deck, tolerance=1e-9 * 0.05)
    fast = relax(deck, tmp_path, lattice).require()
    plain = relax(deck, tmp_path).require()
    assert fast.evaluations <= 15 < plain.evaluations / 5
    pushing = np.maximum(fast.traction, 0).sum()
    assert plain.force == pytest.approx(fast.force, abs=1e-7 * pushing)
    # A force of this size on each atom of a column against the softest mode, K_0 = C11/16, some 0.08.
    atol = deck.tolerance * deck.slab.mobile / 0.06
    assert np.allclose(plain.displacements, fast.displacements, rtol=0, atol=atol)
    # Anharmonic: of the order of h' of all that pushes and pulls.
    linear = problem.wall.evaluate(state.gap).traction
    assert 1e-3 < abs(fast.force - linear.sum()) / np.abs(linear).sum() < 0.05


@pytest.mark.parametrize("name", ["lj", pytest.param("Cu_mishin1.eam.alloy", marks=pytest.mark.long)])
def test_the_zero_of_gap_is_the_surface_at_rest(tmp_path, name):
    # Lennard-Jones rises, copper sinks: either by several times what the wall is rough.
    problem, state, deck = on_atoms(8, slope=0.001, name=name)
    rise = deck.rise[0]
    assert np.sign(rise) == (1 if name == "lj" else -1)
    assert abs(rise) > 4 * np.std(deck.heights)
    lattice = problem.substrate
    assert isinstance(lattice, LatticeResponse)
    atoms = relax(deck, tmp_path, lattice).require()
    linear = problem.wall.evaluate(state.gap).traction.sum()
    # What is left is anharmonic, of the order of h'.
    assert atoms.force == pytest.approx(linear, rel=0.01)
    # Counted from lattice sites, the same wall stands higher by the rise.
    sites = replace(deck, rise=None, displacements=None)
    risen = relax(replace(sites, separation=deck.separation + rise), tmp_path, lattice).require()
    assert risen.force == pytest.approx(atoms.force, rel=1e-5)
    # At the same separation it presses a surface that has risen far more, and hardly touches one that has sunk.
    unshifted = relax(sites, tmp_path, lattice).require().force
    assert unshifted > 10 * linear if rise > 0 else unshifted < 0.1 * linear


def test_atoms_in_metal_units_feel_what_they_feel_alone(tmp_path):
    from atomistic.lammps.session import Cell

    model = crystal("Ni_u3.eam")
    slab = Slab((8, 8), 6, model.coupled_layers)
    u = np.zeros((slab.layers, 8, 8, 3))
    u[:6] = np.random.default_rng(2).uniform(-0.02, 0.02, (6, 8, 8, 3))
    deck = Deck(slab, model, LennardJonesSpline(0.0), np.zeros(slab.shape), 3.0, u, rise=np.zeros(slab.layers))
    with WallSession(write_deck(tmp_path, deck)) as session:
        energy, forces = session.evaluate(u)
        assert np.allclose(session.displacements(), u, rtol=0, atol=1e-13)
    at = (deck.rest + u).reshape(-1, 3) * model.length
    with Cell(model, at, np.array([8.0, 8, 1]) * model.length, surface=True) as cell:
        alone, expected = cell.evaluate(at)
    expected = expected.reshape(forces.shape) * model.length / model.energy
    expected[6:] = 0  # the base is held
    # Either is a running sum over the atoms, in an order of its own.
    assert energy == pytest.approx(alone / model.energy, rel=slab.size * np.finfo(float).eps)
    assert np.abs(expected).max() > 0.02
    assert np.allclose(forces, expected, rtol=0, atol=1e-12)


@pytest.mark.long
def test_ranks_share_the_atoms_of_the_iteration(tmp_path):
    _, _, deck = on_atoms(slope=0.05, adhesion_length=0.005)
    with Session(write_deck(tmp_path / "deck", deck)) as session:
        alone = iterate(deck, session, lattice(12, "springs"))
    # Each rank writes a file of its own: what two processes print may arrive in any order, even letter by letter.
    script = (
        "import os, sys; from pathlib import Path; from tests.problems import lattice, on_atoms\n"
        "from atomistic.lammps.session import Session; from atomistic.relax.relax import iterate\n"
        "_, _, deck = on_atoms(slope=0.05, adhesion_length=0.005)\n"
        "with Session(Path(sys.argv[1])) as session:\n"
        "    found = iterate(deck, session, lattice(12, 'springs'))\n"
        "text = f'{found.evaluations} {found.converged} {found.displacements[0, ..., 2].sum().hex()}'\n"
        "Path(sys.argv[2], f'rank-{os.getpid()}').write_text(text)\n"
    )
    mpiexec = find("mpiexec")
    assert mpiexec
    said = tmp_path / "said"
    said.mkdir()
    command = [mpiexec, "-n", "2", sys.executable, "-c", script, str(tmp_path / "deck"), str(said)]
    root = str(Path(__file__).parents[4])
    subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=600, check=True)
    first, second = (file.read_text() for file in said.iterdir())
    assert first == second
    evaluations, converged, total = first.split()
    assert (int(evaluations), converged) == (alone.evaluations, "True")
    # Sums over two parts round otherwise: 1e-16 of forces of order one, over the softest mode of 144 atoms.
    assert float.fromhex(total) == pytest.approx(alone.displacements[0, ..., 2].sum(), abs=1e-9)


def test_heights_of_another_surface_are_refused(tmp_path):
    _, _, deck = on_atoms()
    with WallSession(write_deck(tmp_path, deck)) as session, pytest.raises(ValueError, match="do not fit"):
        session.apply_wall(deck.wall, np.zeros((4, 4)), 1.0)


@pytest.mark.long
@pytest.mark.parametrize("slope", [0.1, 0.03, 0.01, 0.003, 0.001])
@pytest.mark.parametrize("adhesion_length", [0.0, 0.0005, 0.005, 0.05])
def test_the_written_deck_converges_alone(tmp_path, slope, adhesion_length):
    _, _, deck = on_atoms(n=32, slope=slope, adhesion_length=adhesion_length, area=0.1)
    assert deck.start.any()
    for start in (deck, replace(deck, displacements=None)):
        relax(start, tmp_path).require()


@pytest.mark.parametrize(
    ("law", "nearer"),
    [(InversePowers((9, 3), 0.05), 10.0), (LennardJonesSpline(adhesion_length=0.05), 3.0)],
    ids=["9-3", "spline"],
)
def test_the_lattice_under_the_wall_on_every_layer_is_that_of_the_atoms(law: Wall, nearer: float) -> None:
    """Atoms under a slight wave, on the second layer of which the law acts: what is left is of second order.

    Stated after a first run on 12 x 12 atoms, in which the ratio was 26 and 6.
    """
    n, separation = 8, 1.1
    slab = Slab.of_depth(Grid.square(n), 5.0)
    response = LatticeResponse.of_springs(slab, SPRINGS)
    heights = np.repeat(0.01 * np.cos(2 * np.pi * np.arange(n) / n)[:, None], n, axis=1)
    problem = ContactProblem(slab.grid, law, heights, response)
    gap = solve(problem, "separation", separation, Settings(1e-12)).gap
    deck = Deck(slab, SPRINGS, law, heights, separation, lattice_start(response, law, gap), 1e-10, rise=response.rise)
    u = lattice_on_every_layer(deck, response, gap)
    # It is at rest: K^-1 of all forces of the wall, each at the gap of its own atom, are these displacements.
    forces = np.zeros((slab.mobile, *slab.shape, 3))
    level = deck.rest[: slab.mobile, ..., 2] - deck.surface
    above = deck.above.reshape(level.shape)
    forces[..., 2] = -deck.law.evaluate(separation + above - level - u[: slab.mobile, ..., 2]).traction
    assert np.abs(forces[1:]).max() > 1e-4
    np.testing.assert_allclose(response.displacements(forces), u, atol=1e-8)
    atoms = relax_in(Session.on_atoms_of(deck), deck, response).require().gap
    layered = separation + heights - u[0, ..., 2]
    assert np.abs(gap - atoms).max() > nearer * np.abs(layered - atoms).max() > 0


def test_a_law_that_ends_above_the_second_layer_leaves_the_lattice_as_it_is() -> None:
    _, state, deck = on_atoms(adhesion_length=0.005)
    assert np.array_equal(lattice_on_every_layer(deck, lattice(12, "springs"), state.gap), deck.start)
