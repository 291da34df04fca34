"""The continuum limit of the lattice."""

import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.response.lattice import LatticeResponse, discreteness
from atomistic.response.material import model_of

SPRINGS = Springs()


def test_springs_tend_to_the_cubic_continuum_linearly_in_q():
    response = LatticeResponse.of_springs(Slab((128, 128), 181), SPRINGS)
    found = discreteness(response, SPRINGS.elastic_constants)
    # The table of the notes, in the worst direction of waves within 3 % of a length.
    expected = {3: -0.055, 4: 0.016, 6: 0.034, 8: 0.035, 16: 0.023, 32: 0.013, 64: 0.0065, 128: 0.0033}
    for wavelength, worst in expected.items():
        assert found.worst(wavelength) == pytest.approx(worst, abs=0.0035 if wavelength < 6 else 6e-4)
    beyond = np.abs(found.difference[found.wavelength > 50])
    assert beyond.max() < 0.01
    # Linear: halving with each doubling of the wavelength, towards one coefficient in each direction.
    assert found.worst(64) / found.worst(128) == pytest.approx(2, abs=0.03)
    assert found.along_110 == pytest.approx(0.0675, abs=0.001)
    assert found.along_100 == pytest.approx(0.038, abs=0.001)
    slopes = found.difference * found.wavelength / (2 * np.pi)
    far = found.wavelength > 30
    assert slopes[far].min() > found.along_100 - 0.005
    assert slopes[far].max() < found.along_110 + 0.001


@pytest.mark.parametrize(
    ("potential", "at_8", "limit"),
    [
        (LennardJones(), 0.0255, 0.043),
        # Metals are far stiffer than their continuum at short waves: their surface is under tension.
        pytest.param(EmbeddedAtom.read(find_potential("Cu_mishin1.eam.alloy")), 0.119, 0.146, marks=pytest.mark.long),
    ],
)
def test_crystals_of_longer_range(potential, at_8, limit):
    model = model_of(potential)
    slab = Slab((64, 64), 91, model.coupled_layers)
    found = discreteness(LatticeResponse.of_model(slab, model), model.elastic_constants)
    assert found.worst(8) == pytest.approx(at_8, abs=5e-4)
    assert found.along_110 == pytest.approx(limit, abs=2e-3)


def test_what_cannot_be_read_is_refused():
    response = LatticeResponse.of_springs(Slab((8, 8), 12), SPRINGS)
    with pytest.raises(ValueError, match="too few long waves"):
        discreteness(response, SPRINGS.elastic_constants)
