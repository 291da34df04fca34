import numpy as np
import pytest

from atomistic.crystal import Slab
from atomistic.elastic import directional_contact_modulus
from atomistic.interatomic import Springs
from atomistic.lattice import ForceConstants, LatticeResponse
from continuum.grid import Grid

SPRINGS = Springs.reduced()


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
    with pytest.raises(ValueError, match="belongs to the grid"):
        response.stiffness(Grid.square(6))


def test_shapes_that_do_not_fit_are_refused():
    slab = Slab((6, 5), 3)
    response = LatticeResponse.of_springs(slab, SPRINGS)
    with pytest.raises(ValueError, match="shape"):
        response.displacements(np.zeros((1, 5, 6, 3)))
    with pytest.raises(ValueError, match="shape"):
        response.displacements(np.zeros((5, 6, 5, 3)))
    with pytest.raises(ValueError, match="force constants"):
        LatticeResponse(Slab((5, 6), 3), ForceConstants(*response.force_constants))
