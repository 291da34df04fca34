"""Contact moduli of crystal faces, and the integral of Barnett and Lothe, which knows no symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from continuum.model.substrates.crystal import (
    LEAST_COMPRESSIBLE,
    CubicConstants,
    HexagonalConstants,
    anisotropic_contact_modulus,
    contact_modulus,
    directional_contact_modulus,
    rotated,
    tensor_of,
)


def voigt(c11: float, c12: float, c13: float, c33: float, c44: float, c66: float) -> np.ndarray:
    found = np.zeros((6, 6))
    found[:3, :3] = [[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]]
    found[[3, 4, 5], [3, 4, 5]] = c44, c44, c66
    return found


def by_integral(stiffness: np.ndarray, directions: int) -> float:
    """The mean E* = 1/<1/E*(θ)> of a face."""
    angles = np.arange(directions) * np.pi / directions
    return float(1 / np.mean(1 / anisotropic_contact_modulus(tensor_of(stiffness), angles)))


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


@pytest.mark.parametrize(
    ("face", "across", "expected"),
    [([0, 0, 1], [1, 0, 0], 1.37205), ([1, 1, 0], [0, 0, 1], 1.46906), ([1, 1, 1], [1, -1, 0], 1.49866)],
)
def test_faces_of_fcc_springs_have_their_known_moduli(face: list[int], across: list[int], expected: float) -> None:
    """To the digits known, in k_s/a0; and a wave has the modulus of its direction, wherever the axes are."""
    springs = CubicConstants(2**0.5, 0.5**0.5, 0.5**0.5).stiffness_tensor()
    axes = np.array([across, np.cross(face, across), face])
    angles = np.arange(32) * np.pi / 32
    found = anisotropic_contact_modulus(rotated(springs, axes), angles)
    assert 1 / np.mean(1 / found) == pytest.approx(expected, abs=6e-6)
    turned = np.array(
        [np.cos(0.7) * axes[0] / np.linalg.norm(axes[0]) + np.sin(0.7) * axes[1] / np.linalg.norm(axes[1])]
    )
    turned = np.concatenate([turned, np.cross(face, turned), axes[2:]])
    assert anisotropic_contact_modulus(rotated(springs, turned), angles - 0.7) == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
def test_waves_on_a_cubic_face_are_those_of_a_thick_layer(angle: float) -> None:
    constants = CubicConstants(165.7, 63.9, 79.6)
    expected = directional_contact_modulus(constants, np.array([angle]))
    assert anisotropic_contact_modulus(constants.stiffness_tensor(), np.array([angle])) == pytest.approx(
        expected, rel=1e-9
    )


@given(st.floats(-0.9, 0.499), st.floats(1e-3, 1e3))
def test_an_isotropic_solid_has_its_plane_strain_modulus(poisson: float, modulus: float) -> None:
    shear = modulus / (2 * (1 + poisson))
    lame = 2 * shear * poisson / (1 - 2 * poisson)
    c11 = lame + 2 * shear
    found = HexagonalConstants(c11, lame, lame, c11, shear).contact_modulus()
    assert found == pytest.approx(modulus / (1 - poisson**2), rel=1e-9)


COMPONENT = st.floats(-1, 1)


@given(COMPONENT, COMPONENT, COMPONENT, COMPONENT, COMPONENT)
@example(1.0, 0.2, 0.2, 1.0, float("nan"))
@settings(max_examples=100)
def test_a_crystal_is_stable_where_every_strain_costs_energy(
    c11: float, c12: float, c13: float, c33: float, c44: float
) -> None:
    """The lowest eigenvalue of the elastic constants; those near zero are left to rounding."""
    hexagonal, cubic = HexagonalConstants(c11, c12, c13, c33, c44), CubicConstants(c11, c12, c44)
    for constants, matrix in (
        (hexagonal, voigt(*hexagonal, (c11 - c12) / 2)),
        (cubic, voigt(c11, c12, c12, c11, c44, c44)),
    ):
        lowest = np.linalg.eigvalsh(matrix)[0] if np.isfinite(matrix).all() else -np.inf
        assume(abs(lowest) > 1e-9)
        if lowest > 0 and (constants is hexagonal or c11 <= LEAST_COMPRESSIBLE * c44):
            constants.require_stable()
        else:
            with pytest.raises(ValueError, match=r"stable|at most"):
                constants.require_stable()


@given(st.floats(0.1, 2), COMPONENT, COMPONENT)
def test_the_tensor_of_a_cubic_crystal_has_its_constants_in_their_places(c11: float, c12: float, c44: float) -> None:
    expected = tensor_of(voigt(c11, c12, c12, c11, c44, c44))
    np.testing.assert_allclose(CubicConstants(c11, c12, c44).stiffness_tensor(), expected, atol=1e-15)
