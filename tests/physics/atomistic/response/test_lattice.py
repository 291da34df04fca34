import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.response.force_constants import ForceConstants, spring_force_constants
from atomistic.response.lattice import LatticeResponse, require_room
from atomistic.response.material import model_of
from continuum.model.grid import Grid
from continuum.model.substrates import TabulatedSubstrate
from continuum.model.substrates.crystal import directional_contact_modulus

SPRINGS = Springs()


def dense_hessian(slab: Slab) -> np.ndarray:
    """Hessian of the mobile atoms from the positions of all pairs, without any Fourier transform."""
    at = slab.positions.reshape(-1, 3)
    hessian = np.zeros((len(at), 3, len(at), 3))
    for image in np.ndindex(3, 3):
        shift = np.array([*(np.array(image) - 1) * slab.shape, 0.0])
        bond = at[None, :] + shift - at[:, None]
        for a, b in np.argwhere(np.abs(np.linalg.norm(bond, axis=-1) - 1) < 1e-9):
            stiffness = SPRINGS.stiffness * np.outer(bond[a, b], bond[a, b])
            hessian[a, :, a] += stiffness
            hessian[a, :, b] -= stiffness
    n = slab.mobile * slab.shape[0] * slab.shape[1]
    return hessian[:n, :, :n].reshape(3 * n, 3 * n)


@pytest.mark.parametrize(("shape", "mobile"), [((4, 4), 3), ((4, 5), 4), ((5, 3), 2), ((3, 6), 1)])
def test_displacements_solve_the_dense_problem(shape, mobile):
    slab = Slab(shape, mobile)
    response = LatticeResponse.of_springs(slab, SPRINGS)
    hessian = dense_hessian(slab)
    forces = np.random.default_rng(1).standard_normal((mobile, *shape, 3))
    expected = np.linalg.solve(hessian, forces.ravel()).reshape(mobile, *shape, 3)
    found = response.displacements(forces)
    # Rounding, times the condition number of the Hessian of some layers.
    assert np.allclose(found[:mobile], expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    assert np.abs(expected).max() > 1
    assert (found[mobile:] == 0).all()

    surface = np.zeros_like(forces)
    surface[0, ..., 2] = forces[0, ..., 2]
    from_surface = response.displacements_of_surface_force(forces[0, ..., 2])
    assert np.allclose(from_surface, response.displacements(surface), rtol=0, atol=1e-14)
    balance = (hessian @ from_surface[:mobile].ravel()).reshape(surface.shape)
    assert np.allclose(balance, surface, rtol=0, atol=1e-13)


@pytest.mark.parametrize("shape", [(8, 8), (7, 6)])
def test_the_response_is_reciprocal(shape):
    response = LatticeResponse.of_springs(Slab(shape, 6), SPRINGS)
    g = response.compliance_q
    assert np.allclose(g, g.conj().swapaxes(-1, -2), rtol=0, atol=1e-13 * np.abs(g).max())
    assert np.abs(g.imag).max() > 0.01  # vertical and lateral couple, out of phase
    rng = np.random.default_rng(2)
    a, b = (rng.standard_normal((6, *shape, 3)) for _ in range(2))
    mutual = np.vdot(a, response.displacements(b)[:6])
    assert mutual == pytest.approx(np.vdot(b, response.displacements(a)[:6]), rel=1e-12)


def test_the_response_has_the_symmetry_of_the_square():
    stiffness = LatticeResponse.of_springs(Slab((8, 8), 6), SPRINGS).stiffness_q
    assert np.allclose(stiffness[:5, :5], stiffness[:5, :5].T, rtol=1e-13)
    assert np.allclose(stiffness[1:4], stiffness[:4:-1], rtol=1e-13)


def test_the_mean_compresses_the_slab_evenly():
    slab = Slab((5, 4), 9)
    stiffness = LatticeResponse.of_springs(slab, SPRINGS).stiffness_q
    # Layers joined by springs only: the crystal's C11 between the planes, without surface effect.
    assert stiffness[0, 0] == pytest.approx(SPRINGS.elastic_constants.c11 / slab.depth, rel=1e-13)


@pytest.mark.parametrize(("direction", "angle"), [((1, 0), np.pi / 4), ((1, 1), 0.0)])
def test_long_waves_tend_to_the_continuum(direction, angle):
    expected = directional_contact_modulus(SPRINGS.elastic_constants, angle)
    errors = []
    for n in (16, 32, 64):
        shape = (n, 3) if direction == (1, 0) else (n, n)
        # Twice as deep as the wave is long: what the base changes is below 1e-4.
        slab = Slab(shape, mobile=round(2 * np.sqrt(2) * n))
        wavenumber = slab.grid.wavenumber[direction]
        modulus = 2 * LatticeResponse.of_springs(slab, SPRINGS).stiffness_q[direction] / wavenumber
        errors.append(abs(modulus / expected - 1))
    # The table of the notes: 0.65 % at 64 a0 in the worst direction, halving with each doubling.
    assert errors[-1] < 0.0066
    assert 1.6 < errors[0] / errors[1] < 4.5
    assert 1.6 < errors[1] / errors[2] < 4.5


def test_it_is_a_response_of_its_own_grid_only():
    response = LatticeResponse.of_springs(Slab((6, 5), 3), SPRINGS)
    assert (response.stiffness(Grid((6, 5), (6.0, 5.0))) == response.stiffness_q).all()
    with pytest.raises(ValueError, match="the grid of the slab"):
        response.stiffness(Grid.square(6))


def test_shapes_that_do_not_fit_are_refused():
    slab = Slab((6, 5), 3)
    response = LatticeResponse.of_springs(slab, SPRINGS)
    with pytest.raises(ValueError, match="shape"):
        response.displacements(np.zeros((1, 5, 6, 3)))
    with pytest.raises(ValueError, match="shape"):
        response.displacements(np.zeros((5, 6, 5, 3)))
    constants = spring_force_constants(SPRINGS)
    with pytest.raises(ValueError, match="do not belong together"):
        ForceConstants(constants.surface[:, :1], constants.bulk, constants.relaxation)
    with pytest.raises(ValueError, match=r"table = .* shape"):
        LatticeResponse(slab, constants, np.ones((5, 4)))


def folded(layers: int) -> ForceConstants:
    """Springs, written as if forces reached and the surface changed more layers than they do."""
    exact = spring_force_constants(SPRINGS)
    bulk = np.zeros((layers + 1, 7, 7, 3, 3))
    surface = np.zeros((layers + 2, *bulk.shape))
    bulk[:2, 2:5, 2:5] = exact.bulk
    surface[:, :2, 2:5, 2:5] = exact.bulk
    surface[0, :2, 2:5, 2:5] = exact.surface[0]
    return ForceConstants(surface, bulk, np.zeros(layers + 2))


@pytest.mark.parametrize("reach", [1, 2, 3, 4])
@pytest.mark.parametrize(("shape", "mobile"), [((4, 5), 6), ((5, 4), 9), ((6, 6), 23)])
def test_blocks_of_layers_give_the_same_response(reach, shape, mobile):
    # Mobile layers that fill their blocks and that do not, blocks of the surface only, and a long chain of the bulk.
    slab = Slab(shape, mobile, reach)
    one = LatticeResponse.of_springs(slab, SPRINGS)
    many = LatticeResponse(slab, folded(reach))
    assert np.allclose(many.stiffness_q, one.stiffness_q, rtol=1e-12, atol=0)
    forces = np.random.default_rng(4).standard_normal((mobile, *shape, 3))
    for given in (forces, forces[:2]):
        expected = one.displacements(given)
        assert np.allclose(many.displacements(given), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_a_long_chain_keeps_few_matrices_and_no_digit_less():
    slab = Slab((24, 24), 120)
    response = LatticeResponse.of_springs(slab, SPRINGS)
    assert response.kept < 0.2
    forces = np.random.default_rng(5).standard_normal((3, 24, 24, 3))
    u = response.displacements(forces)
    # The balance of forces, layer by layer, by force constants in real space.
    balance = np.zeros_like(u)
    exact = spring_force_constants(SPRINGS)
    for layer in range(120):
        for down in (0, 1):
            for i, j in np.ndindex(3, 3):
                # From even layers down, atoms stand at -1/2 and 1/2; stored indices count from the cell of the origin.
                shift = tuple(-(k - 1 + (down if layer % 2 else 0)) for k in (i, j))
                phi = exact.between(layer, down)[i, j]
                if layer + down < 120:
                    balance[layer] += np.roll(u[layer + down], shift, (0, 1)) @ phi.T
                    if down:
                        balance[layer + 1] += np.roll(u[layer], tuple(-s for s in shift), (0, 1)) @ phi
    assert np.allclose(balance[:3], forces, rtol=0, atol=1e-12)
    assert np.allclose(balance[3:120], 0, rtol=0, atol=1e-12)


def test_a_table_for_the_continuum_is_the_stiffness():
    response = LatticeResponse.of_springs(Slab((8, 6), 5), SPRINGS)
    table = response.tabulated("springs")
    assert isinstance(table, TabulatedSubstrate)
    assert (table.stiffness(Grid((8, 6), (8.0, 6.0))) == response.stiffness_q).all()


def test_forces_that_reach_across_the_slab_are_refused():
    model = model_of(LennardJones())
    for slab, match in (
        (Slab((8, 8), 6, 2), "3 mobile|frozen"),
        (Slab((8, 8), 2, 3), "mobile"),
        (Slab((4, 8), 6, 3), "at least 5 surface atoms"),
    ):
        with pytest.raises(ValueError, match=match):
            require_room(slab, model)
        with pytest.raises(ValueError, match=match):
            LatticeResponse.of_model(slab, model)
    with pytest.raises(ValueError, match="freeze more"):
        LatticeResponse(Slab((8, 8), 6, 1), folded(2))


@pytest.mark.long
def test_a_response_of_128_squared_fits_into_little_memory():
    slab = Slab((128, 128), 181)
    response = LatticeResponse.of_springs(slab, SPRINGS)
    assert response.kept < 0.12
    # 8320 waves x 181 layers x 9 complex numbers would be 217 MB.
    held = sum(block.nbytes for block in (*response._chain.surface, *response._chain.bulk, response._chain.steady))
    assert held < 30e6
    assert response.stiffness_q[0, 0] == pytest.approx(SPRINGS.elastic_constants.c11 / slab.depth, rel=1e-10)
