"""Force constants measured in LAMMPS, against exact ones, sum rules, elasticity and LAMMPS' own dynamical matrix."""

from functools import cache

import numpy as np
import pytest

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.model import Model
from atomistic.crystal.potentials import EmbeddedAtom, PotentialError, find_potential
from atomistic.lammps.session import Cell
from atomistic.response.force_constants import (
    ForceConstants,
    SymmetryErrors,
    _rows,
    measure_force_constants,
    places,
    relaxation,
    spring_force_constants,
)
from atomistic.response.lattice import LatticeResponse
from atomistic.response.material import model_of

SPRINGS = Springs()


@cache
def model(name: str) -> Model:
    if name == "springs":
        return SPRINGS
    return model_of(LennardJones() if name == "lj" else EmbeddedAtom.read(find_potential(name)))


def sites(slab: Slab, of: Model) -> np.ndarray:
    """Where the atoms of a relaxed slab are, in a0."""
    at = slab.positions.copy()
    at[: slab.mobile, ..., 2] += relaxation(of, slab.mobile)[:, None, None]
    return at


def opened(slab: Slab, of: Model) -> Cell:
    at = sites(slab, of).reshape(-1, 3)
    return Cell(of, at * of.length, np.array([*slab.shape, 1.0]) * of.length, surface=True)


def of_long_waves(constants: ForceConstants) -> tuple[float, float, float]:
    """C11, C12, C44 of the bulk in E*, from the long waves (Born and Huang, 1954, section 26).

    With C_[ab,cd] = -(1/2V) Σ Φ_ab r_c r_d, at zero stress: C_acbd + C_adbc = 2 [ab,cd].
    """
    brackets = np.zeros((3, 3, 3, 3))
    for down in range(constants.coupled_layers + 1):
        x = places(constants.bulk.shape[1], down)
        r = np.stack(np.broadcast_arrays(x[:, None], x[None, :], -down * LAYER_SPACING), axis=-1)
        # Each pair of layers counts from both sides.
        twice = 1 if down == 0 else 2
        brackets -= twice * np.sqrt(2) / 2 * np.einsum("ijab,ijc,ijd->abcd", constants.bulk[down], r, r)
    rotation = np.array([[1, 1, 0], [-1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
    b = np.einsum("ai,bj,ck,dl,abcd->ijkl", rotation, rotation, rotation, rotation, brackets)
    return float(b[0, 0, 0, 0]), float(2 * b[0, 1, 0, 1] - b[0, 0, 1, 1]), float(b[0, 0, 1, 1])


def test_springs_measured_are_the_exact_ones():
    exact, measured = spring_force_constants(SPRINGS), measure_force_constants(SPRINGS, 6)
    assert measured.surface.shape == exact.surface.shape
    # Rounding of forces over STEP.
    assert np.allclose(measured.bulk, exact.bulk, rtol=0, atol=1e-9)
    assert np.allclose(measured.surface, exact.surface, rtol=0, atol=1e-9)
    assert (measured.relaxation == 0).all()
    assert max(vars(measured.checks).values()) < 1e-10


@pytest.mark.parametrize("n", [8, 32])
def test_the_response_from_measured_springs_is_exact(n):
    slab = Slab((n, n), round(np.sqrt(2) * n))
    exact = LatticeResponse.of_springs(slab, SPRINGS).stiffness_q
    measured = LatticeResponse(slab, measure_force_constants(SPRINGS, slab.mobile)).stiffness_q
    assert np.allclose(measured, exact, rtol=1e-8, atol=0)


@pytest.mark.parametrize(
    ("name", "sound", "elastic"), [("springs", 1e-10, 1e-9), ("lj", 1e-9, 1e-8), ("Ni_u3.eam", 1e-9, 1e-7)]
)
def test_sum_rules_and_elasticity(name, sound, elastic):
    found = measure_force_constants(model(name), 20)
    assert max(vars(found.checks).values()) < sound
    # Long waves of the force constants against stress of the strained crystal: two measurements.
    assert np.allclose(of_long_waves(found), model(name).elastic_constants, rtol=elastic)


def test_layers_that_rise_are_as_far_apart_as_they_are():
    """Raised as a whole nothing changes; stretched or compressed no force reaches beyond the range of forces."""
    of = model("lj")
    layers = 2 * of.coupled_layers + 2
    flat, *raised = (_rows(of, layers, [1], rise) for rise in (0.0 * np.arange(layers), np.full(layers, 0.3)))
    for one, other in zip(flat[0], raised[0][0], strict=True):
        np.testing.assert_allclose(other, one, atol=1e-8)
    assert max(flat[1], raised[0][1]) < 1e-8
    for strain in (0.02, -0.02):
        rows, far = _rows(of, layers, [1], strain * np.arange(layers))
        assert far < 1e-8 < 1 < np.abs(rows[0]).max()


def test_what_is_no_harmonic_crystal_is_refused():
    with pytest.raises(PotentialError, match="violate symmetry"):
        SymmetryErrors(0.0, 0.0, 1e-3, 0.0)
    assert SymmetryErrors(0.0, 0.0, 0.99e-4, 0.0).symmetry == 0.99e-4
    with pytest.raises(PotentialError, match="violate beyond_reach"):
        SymmetryErrors(1.01e-4, 0.0, 0.0, 0.0)
    with pytest.raises(PotentialError, match="violate rotation"):
        SymmetryErrors(0.0, 0.0, 0.0, float("nan"))


@pytest.mark.parametrize(
    ("name", "first", "digits"),
    [("lj", 0.0116, 1e-4), ("Cu_mishin1.eam.alloy", -0.016, 2e-4), ("Ni_u3.eam", -0.0029, 1e-4)],
)
def test_surfaces_relax_and_are_then_at_rest(name, first, digits):
    # Lennard-Jones outward, metals inward; values of this project's notes where they have them.
    of = model(name)
    rise = relaxation(of, 24)
    assert rise[0] == pytest.approx(first, abs=digits)
    assert np.abs(rise[15:]).max() < 1e-9
    slab = Slab((3, 3), 24, of.coupled_layers)
    with opened(slab, of) as cell:
        _, forces = cell.evaluate(sites(slab, of).reshape(-1, 3) * of.length)
    left = forces.reshape(slab.positions.shape)[:24] * of.length / of.energy
    assert np.abs(left).max() < 1e-10


@pytest.mark.parametrize("height", [-7.0, 7.0])
def test_a_slab_has_its_energy_at_any_height(height):
    of = model("lj")
    slab, energies = Slab((3, 3), 3, 2).positions.reshape(-1, 3), []
    for rise in (0.0, height):
        at = (slab + np.array([0, 0, rise])) * of.length
        with Cell(of, at, np.array([3.0, 3, 1]) * of.length, surface=True) as cell:
            energies.append(cell.evaluate(at)[0])
    assert energies[1] == pytest.approx(energies[0], rel=1e-12)


def test_nearest_planes_are_measured_by_their_own_distance():
    rise = relaxation(model("Cu_mishin1.eam.alloy"), 24)
    # -1.67 % of the first distance, -0.58 % of the second: inward, as in Mishin et al. for their (100) surfaces.
    change = -np.diff(rise)[:2] / LAYER_SPACING
    assert change == pytest.approx([-0.0167, -0.0058], abs=1e-4)


@pytest.mark.parametrize(
    ("name", "shape", "mobile", "tolerance"),
    [
        # Rounding of forces over LAMMPS' step, 1e-10, times displacements of some a0, over the neighbours.
        ("springs", (4, 5), 4, 1e-7),
        ("lj", (5, 6), 4, 1e-7),
        # Second derivatives of LAMMPS' splines jump at the knots of the table, by such parts.
        pytest.param("Ni_u3.eam", (8, 8), 5, 1e-5, marks=pytest.mark.long),
    ],
)
def test_the_response_inverts_the_dynamical_matrix_of_lammps(name, shape, mobile, tolerance):
    of = model(name)
    slab = Slab(shape, mobile, of.coupled_layers)
    response = LatticeResponse.of_model(slab, of)
    count = mobile * shape[0] * shape[1]
    with opened(slab, of) as cell:
        cell.command(
            f"group mobile id <= {count}", f"dynamical_matrix mobile regular {1e-5 * of.length:.17g} file d.dat"
        )
        rows = np.loadtxt(cell.directory / "d.dat")
    # LAMMPS divides by the mass, in units that do not matter: E* a0 from its energies and lengths.
    matrix = rows.reshape(3 * count, 3 * count) * of.mass * of.length**2 / of.energy
    forces = np.random.default_rng(3).standard_normal((mobile, *shape, 3))
    found = matrix @ response.displacements(forces)[:mobile].ravel()
    assert np.allclose(found, forces.ravel(), rtol=0, atol=tolerance * np.abs(forces).max())


def equilibrium(cell: Cell, of: Model, response: LatticeResponse, force: np.ndarray) -> np.ndarray:
    """Displacements in LAMMPS under vertical forces on the surface, to rounding, whatever the response says."""
    slab, at = response.slab, sites(response.slab, of)
    u = response.displacements_of_surface_force(force)
    for _ in range(12):
        _, forces = cell.evaluate((at + u).reshape(-1, 3) * of.length)
        left = forces.reshape(at.shape)[: slab.mobile] * of.length / of.energy
        left[0, ..., 2] += force
        if np.abs(left).max() < 3e-14:
            return u
        u = u + response.displacements(left)
    assert np.abs(left).max() < 1e-13
    return u


@pytest.mark.parametrize(
    ("name", "n", "mobile"),
    [
        ("Ni_u3.eam", 8, 8),
        pytest.param("Cu_mishin1.eam.alloy", 12, 20, marks=pytest.mark.long),
        pytest.param("Al_zhou.eam.alloy", 16, 20, marks=pytest.mark.long),
    ],
)
def test_single_waves_of_force_move_lammps_as_the_response_says(name, n, mobile):
    of = model(name)
    slab = Slab((n, n), mobile, of.coupled_layers)
    response = LatticeResponse.of_model(slab, of)
    x, y = slab.grid.positions
    with opened(slab, of) as cell:
        for mode in ((1, 0), (1, 1), (3, 2), (n // 2, n // 2)):
            force = 1e-4 * np.cos(2 * np.pi * (mode[0] * x + mode[1] * y) / n)
            up, down = (equilibrium(cell, of, response, sign * force) for sign in (1, -1))
            linear = response.displacements_of_surface_force(force)
            # Of the odd part the third order is left: (1e-4)² times a ratio of stiffnesses of ten to a hundred.
            assert np.allclose((up - down) / 2, linear, rtol=0, atol=1e-6 * np.abs(linear).max())
            assert np.abs((up + down) / 2).max() > 1e-6 * np.abs(linear).max()
