"""A coated body: its threshold lies between those of base and coating, and the theories say nothing."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import continuum as c
from continuum.front.predict import Prediction
from continuum.maps.map import Topography
from continuum.maps.verdict.materials import Interface, InterfaceError, read_interface
from continuum.maps.verdict.prediction import prediction_of
from continuum.maps.verdict.threshold import AREA_TOLERANCE, press_map
from tests.physics.continuum.maps.verdict.test_predict import surface

BODY: dict[str, Any] = {"modulus": "1GPa", "poisson": 0.3, "work": "50mJ/m2", "range": "0.35nm"}


def rough() -> Topography:
    """λ_s of 8 nm and more, on pixels of 1 nm."""
    small = surface(64)
    return Topography(1e-9 * small.heights, (64e-9, 64e-9), periodic=True)


def threshold(coating: str | None = None, thickness: float = 1.0, **body: Any) -> float:
    """The threshold on a coating of a thickness in nm, which is possibly thinner than an atom."""
    interface = read_interface(**BODY | body, coating=coating)
    if interface.coating is not None:
        interface = replace(interface, coating=replace(interface.coating, thickness=thickness * 1e-9))
    return press_map(rough(), interface).threshold().work


def test_a_coating_of_the_same_material_changes_nothing() -> None:
    # K_q to 1e-13; linear solves that end at 1e-3.
    assert threshold("1nm:1GPa:0.3", 5) == pytest.approx(threshold(), rel=1e-6)


def test_the_threshold_lies_between_those_of_base_and_coating_and_tends_to_them() -> None:
    soft, stiff = threshold(), threshold(modulus="4GPa")
    works = [threshold("1nm:4GPa:0.3", thickness) for thickness in (0.01, 3, 1000)]
    # The area, and a core that is as stiff as the coating asks for, four times that of the base: as much once more.
    assert works[0] == pytest.approx(soft, rel=2 * AREA_TOLERANCE)
    assert works[2] == pytest.approx(stiff, rel=AREA_TOLERANCE)
    assert soft * (1 + AREA_TOLERANCE) < works[1] < stiff * (1 - AREA_TOLERANCE)


def test_full_contact_costs_between_both() -> None:
    """The energy of a wave is that of half of K_q, from base to coating with its wavelength over the thickness."""
    plain, coated = (read_interface(**BODY, coating=layer) for layer in (None, "3nm:4GPa:0.3"))
    grids = [c.Grid((4, 4), (wavelength, wavelength)) for wavelength in (6e4, 20.0, 0.5)]  # in nm
    plain_q, coated_q = (
        np.array([contact.contact_modulus * contact.substrate(1e-9).stiffness(grid)[0, 1] for grid in grids])
        for contact in (plain, coated)
    )
    ratio = coated_q / plain_q
    assert ratio[0] == pytest.approx(1, abs=2e-3)  # of the order of q h
    assert ratio[2] == pytest.approx(4, rel=1e-9)
    assert 1.1 < ratio[1] < 3.9


def test_theories_are_silent_and_the_state_decides() -> None:
    contact = read_interface(**BODY | {"work": "5J/m2"}, coating="3nm:4GPa:0.3")
    found = prediction_of([rough()], contact, kind=Prediction)
    assert all("coated" in " ".join(estimate.why) for estimate in found.estimates)
    assert found.solved().verdict.answer == "sticky"
    assert "coating of 3 nm" in contact.origin[0]
    assert json.loads(found.json())["interface"]["coating"]["thickness"] == pytest.approx(3e-9)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"coating": "3nm"}, "write thickness"),
        ({"coating": "3GPa:3nm:0.3"}, "not a unit of length"),
        ({"coating": "3nm:4GPa:0.7"}, "at most 0.5"),
        ({"coating": "3nm:4GPa:x"}, "not a number"),
        ({"coating": "0nm:4GPa:0.3"}, "positive"),
        (
            {"coating": "3nm:4GPa:0.3", "probe": "1um"},
            "cannot be combined with `contact_modulus`, a second body or `probe`",
        ),
        ({"coating": "3nm:4GPa:0.3", "modulus": ["1GPa", "1GPa"], "poisson": [0.3, 0.3]}, "needs one elastic body"),
    ],
)
def test_a_coating_that_cannot_be_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InterfaceError, match=said):
        read_interface(**BODY | given)


def test_a_coating_on_an_unknown_body_is_refused() -> None:
    with pytest.raises(InterfaceError, match="second body or `probe`"):
        read_interface(contact_modulus="1GPa", work="50mJ/m2", range="0.35nm", coating="3nm:4GPa:0.3")
    assert isinstance(read_interface(material="silicon", work="50mJ/m2", coating="3nm:4GPa:0.3"), Interface)
