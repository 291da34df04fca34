"""Contact moduli of crystal faces against the integral of Barnett and Lothe, which knows no symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.model.cubic import CubicConstants, contact_modulus
from continuum.model.hexagonal import HexagonalConstants


def tensor(stiffness: np.ndarray) -> np.ndarray:
    """C_ijkl from Voigt's 6 x 6 matrix."""
    at = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    return stiffness[at[:, :, None, None], at[None, None]]


def voigt(c11: float, c12: float, c13: float, c33: float, c44: float, c66: float) -> np.ndarray:
    found = np.zeros((6, 6))
    found[:3, :3] = [[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]]
    found[[3, 4, 5], [3, 4, 5]] = c44, c44, c66
    return found


def by_integral(stiffness: np.ndarray, directions: int) -> float:
    """E* = 2/<L^-1_zz>, L = (1/π) ∫ [(mm) - (mn) (nn)^-1 (nm)] dφ, m and n turning in the plane of wave and normal.

    Equal weights converge exponentially, as the integrand has the period π.
    """
    c, compliances = tensor(stiffness), []
    for angle in np.arange(directions) * np.pi / directions:
        along, up = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])
        phi = np.arange(400)[:, None] * np.pi / 400
        m, n = np.cos(phi) * along + np.sin(phi) * up, np.cos(phi) * up - np.sin(phi) * along
        mm, mn, nn = (np.einsum("pi,ijkl,pl->pjk", a, c, b) for a, b in ((m, m), (m, n), (n, n)))
        whole = np.mean(mm - mn @ np.linalg.inv(nn) @ mn.transpose(0, 2, 1), axis=0)
        compliances.append(np.linalg.inv(whole)[2, 2])
    return float(2 / np.mean(compliances))


@pytest.mark.parametrize(
    "constants",
    [
        HexagonalConstants(1109, 139, 0, 38.7, 4.95),  # graphite
        HexagonalConstants(179.7, 48.8, 23.4, 58.6, 18.0),  # mica
        HexagonalConstants(13.929, 7.082, 5.765, 15.010, 3.014),  # ice
    ],
)
def test_the_basal_face_is_that_of_the_integral(constants: HexagonalConstants) -> None:
    c11, c12, c13, c33, c44 = constants
    whole = by_integral(voigt(c11, c12, c13, c33, c44, (c11 - c12) / 2), directions=1)
    # Of 400 angles: the layers of graphite shear so easily that its integrand is sharp.
    assert constants.contact_modulus() == pytest.approx(whole, rel=1e-6)
    assert constants.contact_modulus() < c33


@pytest.mark.parametrize("constants", [(165.7, 63.9, 79.6), (118.77, 53.72, 59.44)])
def test_the_cubic_face_is_that_of_the_integral(constants: tuple[float, float, float]) -> None:
    c11, c12, c44 = constants
    expected = by_integral(voigt(c11, c12, c12, c11, c44, c44), directions=16)
    assert contact_modulus(CubicConstants(*constants)) == pytest.approx(expected, rel=1e-9)


@given(st.floats(-0.9, 0.499), st.floats(1e-3, 1e3))
def test_an_isotropic_solid_has_its_plane_strain_modulus(poisson: float, modulus: float) -> None:
    shear = modulus / (2 * (1 + poisson))
    lame = 2 * shear * poisson / (1 - 2 * poisson)
    c11 = lame + 2 * shear
    found = HexagonalConstants(c11, lame, lame, c11, shear).contact_modulus()
    assert found == pytest.approx(modulus / (1 - poisson**2), rel=1e-9)


@pytest.mark.parametrize("wrong", [{"c44": 0.0}, {"c12": 200.0}, {"c13": 100.0}, {"c44": float("nan")}])
def test_an_unstable_crystal_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="stable hexagonal crystal"):
        HexagonalConstants(179.7, 48.8, 23.4, 58.6, 18.0)._replace(**wrong).contact_modulus()
