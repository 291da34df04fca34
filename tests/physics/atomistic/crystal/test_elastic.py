import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atomistic.crystal.interatomic import Springs
from continuum.model.substrates.crystal import CubicConstants, contact_modulus, directional_contact_modulus

UNIT_SPRINGS = Springs(1.0).elastic_constants


def barnett_lothe(constants: CubicConstants, angle: float) -> float:
    """E*(θ) from the Barnett-Lothe integral (Ting, Anisotropic Elasticity, 1996, 7.1 - 7.4): an independent way.

    L = (1/π) ∫ [(mm) - (mn)(nn)^-1(nm)] dω over half a turn of m and n, 1/E* = ½ (L^-1)_nn.
    """
    c = constants.stiffness_tensor()
    along, up = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])
    total = np.zeros((3, 3))
    for w in np.arange(256) * np.pi / 256:
        m, n = np.cos(w) * along + np.sin(w) * up, np.cos(w) * up - np.sin(w) * along
        mm, mn, nn = (np.einsum("i,ijkl,l->jk", a, c, b) for a, b in ((m, m), (m, n), (n, n)))
        total += mm - mn @ np.linalg.solve(nn, mn.T)
    return float(2 / np.linalg.inv(total / 256)[2, 2])


@pytest.mark.parametrize("angle", [0.0, 0.2, 0.5, np.pi / 4, 2.0])
@pytest.mark.parametrize(
    "constants", [UNIT_SPRINGS, CubicConstants(169.9, 122.6, 76.2), CubicConstants(127, 81.4, 36.4)]
)
def test_the_modulus_is_that_of_barnett_and_lothe(constants, angle):
    assert directional_contact_modulus(constants, angle) == pytest.approx(barnett_lothe(constants, angle), rel=1e-12)


@given(st.floats(-0.9, 0.499), st.floats(0, np.pi))
def test_an_isotropic_crystal_has_the_plane_strain_modulus(poisson, angle):
    shear = 1 / (2 * (1 + poisson))
    lame = poisson / ((1 + poisson) * (1 - 2 * poisson))
    constants = CubicConstants(lame + 2 * shear, lame, shear)
    # Near ν = 1/2 the bulk modulus diverges, and digits are lost in proportion to it.
    tolerance = 1e-13 / (1 - 2 * poisson)
    expected = pytest.approx(1 / (1 - poisson**2), rel=tolerance)
    assert directional_contact_modulus(constants, angle) == expected
    assert contact_modulus(constants) == expected


@pytest.mark.parametrize(
    ("constants", "mean", "along_110", "along_100", "digits"),
    [
        # Independent values (Stroh's eigenvalue problem; notes of this project), to the digits printed there.
        (UNIT_SPRINGS, 1.3721, 1.4063, 1.3416, 1e-4),
        (CubicConstants(169.9, 122.6, 76.2), 135.2, 145.1, 127.7, 0.1),
        (CubicConstants(97.71, 55.63, 55.63), 95.76, 99.90, 92.28, 0.01),
    ],
)
def test_known_crystals(constants, mean, along_110, along_100, digits):
    assert contact_modulus(constants) == pytest.approx(mean, abs=digits)
    assert directional_contact_modulus(constants, np.pi / 4) == pytest.approx(along_110, abs=digits)
    assert directional_contact_modulus(constants, 0.0) == pytest.approx(along_100, abs=digits)


@given(st.floats(0, np.pi))
def test_the_surface_has_fourfold_symmetry(angle):
    here = directional_contact_modulus(UNIT_SPRINGS, angle)
    assert directional_contact_modulus(UNIT_SPRINGS, angle + np.pi / 2) == pytest.approx(here, rel=1e-13)
    assert directional_contact_modulus(UNIT_SPRINGS, -angle) == pytest.approx(here, rel=1e-13)


def test_the_modulus_has_the_unit_of_the_constants():
    tenfold = CubicConstants(*(10 * c for c in UNIT_SPRINGS))
    assert contact_modulus(tenfold) == pytest.approx(10 * contact_modulus(UNIT_SPRINGS), rel=1e-14)


@pytest.mark.parametrize("constants", [(1, 1, 1), (1, -0.6, 1), (1, 0.5, 0), (1, 0.5, float("nan"))])
def test_unstable_crystals_are_refused(constants):
    with pytest.raises(ValueError, match="stable"):
        directional_contact_modulus(CubicConstants(*constants), 0.0)
