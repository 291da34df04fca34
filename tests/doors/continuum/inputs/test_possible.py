"""What no body has is refused at every door, with its bounds: it has been given in another unit."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.inputs import possible, units
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from continuum.inputs.reading import load
from continuum.maps.verdict.materials import materials
from continuum.maps.verdict.tables import PredictionInput

KINDS = sorted(possible.POSSIBLE)
MAP = 200 * np.random.default_rng(1).normal(size=(32, 32))
CONTACT = {"contact_modulus": "1GPa", "work": "20mJ/m2", "range": "0.5nm", "solve": False}


@pytest.mark.parametrize("kind", KINDS)
@given(share=st.floats(-0.5, 1.5).filter(lambda share: min(abs(share), abs(share - 1)) > 1e-3))
def test_what_is_possible_passes_and_all_else_is_refused(kind: possible.Kind, share: float) -> None:
    """By the logarithm of a number between the bounds."""
    bounds = possible.POSSIBLE[kind]
    value = float(bounds.least * (bounds.most / bounds.least) ** share)
    si = {"pressure": "Pa", "energy_per_area": "J/m2", "length": "m", "force": "N"}[bounds.quantity]
    assert possible.from_text(bounds.example, kind) > 0
    if 0 < share < 1:
        assert possible.from_text(f"{value!r}{si}", kind) == possible.given("x", value, kind, si) == value
        return
    with pytest.raises(ValueError, match=f"no {bounds.of} has this; possible are "):
        possible.from_text(f"{value!r}{si}", kind)
    with pytest.raises(ArgumentError, match=f"^x = .*no {bounds.of} has this"):
        possible.given("x", value, kind, si)


@given(st.floats(1e-3, 1e3))
def test_a_number_in_the_unit_of_the_door_and_a_text_with_its_own_are_the_same(gigapascals: float) -> None:
    text = possible.given("contact_modulus", f"{gigapascals!r}GPa", "modulus", "eV/A3")
    assert text == pytest.approx(gigapascals / units.GPA_PER_EV_PER_A3)
    assert possible.given("contact_modulus", text, "modulus", "eV/A3") == text


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (136.0, "136 eV/Å³ is 21.8 TPa, and no solid has this"),  # GPa where eV/Å³ are asked for
        ("136eV/A3", "no solid has this"),
        ("2nm", "'nm' is not a unit of pressure"),
        (-1, "greater than 0"),
        (np.nan, "a number in eV/Å³"),
        (None, 'or a text with its unit, as "2MPa"'),
    ],
)
def test_a_modulus_in_another_unit_is_refused_with_what_it_would_be(value: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        possible.given("contact_modulus", value, "modulus", "eV/A3")


def test_masses_fit_their_elements_and_isotopes_do() -> None:
    assert possible.mass("mass", 2.014, "H", 1.008) == 2.014
    assert possible.mass("mass", 15.035, "C", 12.011) == 15.035  # a united atom
    assert possible.mass("mass", 107.0) == 107.0
    for value in (6.3546, 635.46, 26.98, np.inf):
        with pytest.raises(ArgumentError, match=r"as Cu has 63\.55 u"):
            possible.mass("mass", value, "Cu", 63.546)
    with pytest.raises(ArgumentError, match="greater than or equal to 1"):
        possible.mass("mass", 1.05e-25)  # in kg


def test_elements_of_two_parts_of_an_input_are_the_same() -> None:
    possible.elements("coefficients", ("Ni", "NULL"), ("Ni", "Al"))
    for said, wanted, message in (
        (("Al",), ("Cu",), "Al in place of Cu"),
        (("Al", "Cu"), ("Cu", "Al"), "Al in place of Cu"),
        (("Cu",), ("Cu", "Al"), "1 elements for 2"),
    ):
        with pytest.raises(ArgumentError, match=message):
            possible.elements("coefficients", said, wanted)


def test_every_material_of_the_table_is_possible() -> None:
    for one in materials().values():
        for value, kind in ((one.modulus, "modulus"), (one.plane_strain_modulus, "modulus"), (one.range, "range"),
                            (one.work_of_adhesion or 1.0, "work"), (one.spacing or 1e-10, "spacing")):  # fmt: skip
            assert not possible.fault(value, kind), (one.name, kind)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"contact_modulus": "136eV/A3"}, "`contact_modulus` '136eV/A3': no solid has this"),
        ({"contact_modulus": None, "modulus": "3TPa", "poisson": 0.2}, "`modulus` '3TPa'"),
        ({"work": "20MJ/m2"}, "not a unit"),
        ({"work": "1e4J/m2"}, "no interface has this"),
        ({"range": "2mm"}, "no attraction has this"),
        ({"spacing": "2.5pm"}, "no solid has this"),
        ({"tip": "1m"}, "no tip has this"),
        ({"contact_modulus": None, "material": "silicon", "coating": "1m:1GPa:.3"}, "no coating has this"),
        ({"size": "32nm", "unit": "m"}, "rms height of .* no map has this.*`unit` is probably smaller"),
        ({"size": "1e4m", "unit": "nm"}, "pixels of 3.1e.02 m"),
        ({"size": "5pm", "unit": "pm"}, "pixels of 1.6e-13 m.*`size` is probably larger, or is that of one pixel"),
    ],
)
def test_predict_refuses_what_no_body_has(options: dict[str, str | float | None], message: str) -> None:
    with pytest.raises(InputError, match=message):
        c.predict(MAP, **{"size": "320nm", "unit": "nm"} | CONTACT | options)


def test_an_input_names_the_line_of_what_is_impossible(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "map.txt", MAP)
    (tmp_path / "in.toml").write_text(
        '[topography]\nmaps = "map.txt"\n[interface]\ncontact_modulus = "22TPa"\nwork = "20mJ/m2"\nrange = "0.5nm"\n'
    )
    with pytest.raises(InputError, match=r"(?s)in.toml:4: .*contact_modulus.*22TPa.*1 Pa to 2 TPa"):
        load(tmp_path / "in.toml", PredictionInput)


def test_a_refusal_crosses_to_a_process() -> None:
    with pytest.raises(ArgumentError) as caught:
        possible.given("a0", 0.255, "spacing", "A")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
