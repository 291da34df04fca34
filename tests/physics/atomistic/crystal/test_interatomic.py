import numpy as np
import pytest

from atomistic.crystal.interatomic import Springs
from continuum.model.substrates.crystal import contact_modulus


def test_elastic_constants_of_springs():
    c11, c12, c44 = Springs(2.0).elastic_constants
    assert c11 == pytest.approx(2 * np.sqrt(2), rel=1e-14)
    assert c12 == pytest.approx(np.sqrt(2), rel=1e-14)
    assert c44 == pytest.approx(np.sqrt(2), rel=1e-14)


def test_reduced_springs_have_the_contact_modulus_1():
    springs = Springs()
    assert contact_modulus(springs.elastic_constants) == pytest.approx(1, rel=1e-14)
    assert springs.stiffness == pytest.approx(1 / 1.37205, rel=1e-5)


def test_springs_join_twelve_neighbours_at_the_distance_a0():
    bonds = Springs(1.0).bonds
    assert len(np.unique(bonds, axis=0)) == 12
    assert np.allclose(np.linalg.norm(bonds, axis=1), 1, rtol=1e-15)
    assert np.allclose(bonds.sum(axis=0), 0)


def test_the_reference_names_the_paper_and_the_stiffness():
    assert "PNAS" in Springs(0.5).reference
    assert "0.5 E* a0" in Springs(0.5).reference


@pytest.mark.parametrize("stiffness", [0.0, -1.0, float("nan"), float("inf")])
def test_springs_without_stiffness_are_refused(stiffness):
    with pytest.raises(ValueError, match=r"stiffness = .* greater than 0"):
        Springs(stiffness)
