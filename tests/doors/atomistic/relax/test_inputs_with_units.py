"""Inputs of decks whose numbers have units: the same as in reduced ones, and told in both."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.front.cli import main
from atomistic.inputs.deck import QUANTITIES, in_both, in_reduced, with_units
from atomistic.lammps.protocol import Motion, time_unit
from atomistic.relax.decks import deck_input
from continuum.inputs.toml import ConfigError
from continuum.inputs.units import Units, readable

SILVER = Units(2.892e-10, 81e9, 1.791e-25)
TEXT = """
[interatomic]
kind = "eam"
file = "Ag_u3.eam"
[slab]
n = 12
depth = {depth}
[surface]
kind = "sphere"
radius = {radius}
[wall]
law = "lennard-jones-spline"
range = {range}
[protocol]
kind = "velocity"
temperature = {temperature}
separations = {separations}
velocity = {velocity}
window = {window}
"""
REDUCED = {
    "depth": 6.0, "radius": 40.0, "range": 0.35, "temperature": 0.002, "separations": [1.6, 1.1, 1.6],
    "velocity": 0.01, "window": 20.0,
}  # fmt: skip


def written(path: Path, **values: object) -> Path:
    said = {name: repr(value).replace("'", '"') for name, value in (REDUCED | values).items()}
    path.write_text(TEXT.format(**said), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def silver() -> Units:
    return a.elastic(a.EmbeddedAtom.read(a.find_potential("Ag_u3.eam"))).model.real_units


@settings(max_examples=30)
@given(st.sampled_from(sorted(QUANTITIES)), st.floats(1e-3, 1e3), st.booleans())
def test_a_quantity_with_its_unit_is_the_one_without(name: str, value: float, several: bool) -> None:
    text = readable(SILVER.to_si(value, QUANTITIES[name]), QUANTITIES[name], 12)
    data = {"protocol": {name: [text, value] if several else text}}
    found, faults = in_reduced(data, SILVER)
    assert not faults
    if name == "temperature":  # which is taken as it is
        assert not with_units(data)
    else:
        assert np.ravel(found["protocol"][name]) == pytest.approx([value] * (1 + several), rel=1e-9)
        assert not with_units(found)


def test_what_is_told_in_both_units_is_the_same(silver: Units) -> None:
    told = dict(in_both({"protocol": {"velocity": 0.01, "window": 20, "temperature": "300K"}}, silver))
    # a0 = 2.892 Å, E* = 103.8 GPa and 107.9 u of this silver: (103.8e9 (2.892e-10)³/1.791e-25)^(1/2) = 3744 m/s.
    assert told["protocol.velocity"] == "0.01 (E* a0³/m)^(1/2) = 37.44 m/s"
    assert told["protocol.window"] == "20 a0 (m/(E* a0³))^(1/2) = 1.545 ps"
    assert told["protocol.temperature"].endswith("E* a0³ = 300 K")
    # w = l_a E*: 0.005 x 2.892e-10 m x 103.8e9 Pa.
    told = dict(in_both({"wall": {"adhesion_length": 0.005}}, silver))
    assert told["wall.adhesion_length"] == "0.005 a0 = 1.446 pm; w = 150.1 mJ/m²"


def test_an_input_with_units_is_the_one_without(tmp_path: Path, silver: Units, expanded: float) -> None:
    warm = Units(silver.a0 * expanded, silver.contact_modulus, silver.mass)
    given = {
        name: [
            readable((silver if name == "temperature" else warm).to_si(v, QUANTITIES[name]), QUANTITIES[name], 12)
            for v in np.ravel(value)
        ]
        for name, value in REDUCED.items()
    }
    text = {name: value if name == "separations" else value[0] for name, value in given.items()}
    config = deck_input(written(tmp_path / "units.toml", **text))
    plain = deck_input(written(tmp_path / "plain.toml"))
    assert config.slab.depth == pytest.approx(plain.slab.depth, rel=1e-9)
    found, expected = config.steps().motion, plain.steps().motion
    for numbers, others in zip(found.windows, expected.windows, strict=True):
        assert numbers == pytest.approx(others, rel=1e-9)
    assert found.velocity == pytest.approx(expected.velocity, rel=1e-9)
    assert config.source.text == (tmp_path / "units.toml").read_text(encoding="utf-8")  # travels with the deck


def test_check_says_numbers_in_both_units(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], silver: Units, expanded: float
) -> None:
    assert main(["check", str(written(tmp_path / "deck.toml", velocity="37m/s"))]) == 0
    out, warm = capsys.readouterr().out, Units(silver.a0 * expanded, silver.contact_modulus, silver.mass)
    assert f"{37 / warm.si('velocity'):.4g} (E* a0³/m)^(1/2) = 37 m/s" in out
    assert f"20 a0 (m/(E* a0³))^(1/2) = {20 * warm.si('time') / 1e-12:.4g} ps" in out
    # Of every law, whether or not the input names its work.
    assert re.search(r"work of adhesion +[\d.e-]+ E\* a0 = [\d.]+ m?J/m²", out)
    # k_B T as a number counts in E* a0³ of the crystal at rest.
    assert f"0.002 E* a0³ = {0.002 * silver.si('temperature'):.4g} K" in out


def test_lengths_of_a_warm_deck_are_those_of_its_crystal_at_the_temperature(tmp_path: Path, expanded: float) -> None:
    contact = c.Contact(c.sine(c.Grid.square(12), 0.05, (1, 0)), wall=c.LennardJonesSpline(adhesion_length=0.005))
    copper = a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))
    motion = {"kind": "velocity", "separations": ["3.3177Å", "3.0Å"], "velocity": "10m/s", "window": "1ps"}
    found = a.deck(contact, copper, protocol=motion | {"temperature": "300K"}, depth=6)
    rest = a.elastic(copper).model.length
    # In LAMMPS' units metal, Å and ps: what the script says times the a0 with which the crystal is built.
    assert found.model.length == pytest.approx(expanded * rest, rel=1e-12)
    assert isinstance(found.protocol, Motion)
    assert found.protocol.separations[0] * found.model.length == pytest.approx(3.3177, rel=1e-12)
    assert found.protocol.separations[-1] * found.model.length == pytest.approx(3.0, rel=1e-12)
    way = sum(found.protocol.durations[found.protocol.hold :]) * time_unit(found.model)
    assert way == pytest.approx(3.177, rel=1e-5)  # 0.3177 Å at 0.1 Å/ps; LAMMPS' unit of mass has eight digits
    # At rest as before.
    still = a.deck(contact, copper, separations=["3.3177Å", 1.2], depth=6)
    assert still.protocol is not None
    assert still.protocol.separations[0] * rest == pytest.approx(3.3177, rel=1e-12)


def test_all_lengths_of_a_warm_input_and_its_notes_are_of_one_a0(tmp_path: Path, expanded: float) -> None:
    path = written(tmp_path / "deck.toml", depth="17Å", radius="100Å", range="1Å", temperature="300K")
    found = a.deck(path)
    assert found.slab.mobile == round(17 / found.model.length * np.sqrt(2))
    assert found.wall.range * found.model.length == pytest.approx(1.0, rel=1e-12)
    assert any(f"a0 = {found.model.length:.5g} Å" in note for note in found.notes)
    assert any("attraction over" in note and "(0.1 nm)" in note for note in found.notes)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"velocity": "10ps"}, ['velocity = "10ps"', "not a unit of velocity", "which 1 is"]),
        ({"velocity": "10"}, ['velocity = "10"', "unit of velocity is missing"]),
        ({"velocity": "fast"}, ['velocity = "fast"', "not a number with a unit"]),
        ({"separations": ["4Å", "x"], "depth": -1.0}, ['separations = ["4Å", "x"]', "depth = -1.0", "2 faults"]),
        ({"velocity": "2000m/s"}, ['velocity = "2000m/s"', "at most 0.3"]),
        ({"window": "-5ps"}, ['window = "-5ps"', "greater than or equal to 1"]),
    ],
)
def test_text_that_is_no_quantity_is_told_with_its_key(
    tmp_path: Path, values: dict, words: list[str], expanded: float
) -> None:
    with pytest.raises(ConfigError) as error:
        a.deck(written(tmp_path / "deck.toml", **values))
    for word in words:
        assert word in str(error.value)


def test_a_crystal_of_no_size_has_no_units() -> None:
    contact = c.Contact(c.sine(c.Grid.square(8), 0.05, (1, 0)), wall=c.LennardJonesSpline(adhesion_length=0.005))
    with pytest.raises(ConfigError, match="no length scale, and so no units"):
        a.deck(contact, separation="3Å", depth=4)


def test_a_call_takes_units_too() -> None:
    contact = c.Contact(c.sine(c.Grid.square(12), 0.05, (1, 0)), wall=c.LennardJonesSpline(adhesion_length=0.005))
    copper = a.elastic(a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))).model
    assert copper.real_units is not None
    found = a.deck(contact, copper, separations=["3.0 Å", 1.1], depth=6).protocol
    assert found.separations == pytest.approx((3e-10 / copper.real_units.a0, 1.1), rel=1e-12)
