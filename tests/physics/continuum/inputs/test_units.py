"""Real units against reduced ones."""

from __future__ import annotations

from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.inputs.units import ANGSTROM, GPA_PER_EV_PER_A3, Motion, Quantity, Units, parse, readable

sizes = st.floats(1e-12, 1e3)


def test_the_pressure_of_an_electronvolt_per_cubic_angstrom() -> None:
    assert pytest.approx(160.2177, abs=5e-5) == GPA_PER_EV_PER_A3  # as many digits as DESIGN.md prints


@given(sizes, sizes, st.sampled_from(get_args(Quantity)), st.floats(-1e6, 1e6))
def test_there_and_back(a0: float, modulus: float, quantity: Quantity, value: float) -> None:
    units = Units(a0, modulus)
    same = Units.metal(a0 / ANGSTROM, modulus / GPA_PER_EV_PER_A3 / 1e9)
    assert same.to_si(value, quantity) == pytest.approx(units.to_si(value, quantity), rel=1e-12)


@given(sizes, sizes)
def test_dimensions_multiply(a0: float, modulus: float) -> None:
    units = Units(a0, modulus)
    assert units.si("force") == pytest.approx(units.si("pressure") * units.si("area"), rel=1e-12)
    assert units.si("energy") == pytest.approx(units.si("force") * units.si("length"), rel=1e-12)
    assert units.si("energy_per_area") == pytest.approx(units.si("energy") / units.si("area"), rel=1e-12)
    assert units.si("stiffness") == pytest.approx(units.si("force") / units.si("length"), rel=1e-12)


def test_copper() -> None:
    # a0 = 2.556 Å and E* = 135.2 GPa: a work of adhesion of 0.05 E* a0 is 1.73 J/m².
    units = Units(2.556e-10, 135.2e9)
    assert units.to_si(0.05, "energy_per_area") == pytest.approx(1.7279, rel=1e-4)
    assert Units.metal(2.556, 135.2 / GPA_PER_EV_PER_A3).to_si(1, "pressure") == pytest.approx(135.2e9, rel=1e-12)


@pytest.mark.parametrize(("a0", "modulus"), [(0, 1), (-1, 1), (1, float("nan")), (1, float("inf"))])
def test_sizes_that_are_none_are_refused(a0: float, modulus: float) -> None:
    with pytest.raises(ValueError, match="positive finite"):
        Units(a0, modulus)


QUANTITIES: dict[Quantity | Motion, dict[str, float]] = {
    "length": {
        "m": 1,
        "mm": 1e-3,
        "µm": 1e-6,
        "μm": 1e-6,
        "um": 1e-6,
        "nm": 1e-9,
        "\u212b": 1e-10,
        "Å": 1e-10,
        "pm": 1e-12,
    },
    "pressure": {"Pa": 1, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "eV/Å³": 160.21766e9, "eV/Å^3": 160.21766e9},
    "energy_per_area": {"J/m²": 1, "J/m2": 1, "mJ/m^2": 1e-3, "mN/m": 1e-3, "erg/cm²": 1e-3, "eV/Å²": 16.021766},
    "force": {"N": 1, "nN": 1e-9, "µN": 1e-6, "pN": 1e-12, "eV/Å": 1.6021766e-9},
    "time": {"s": 1, "ps": 1e-12, "fs": 1e-15, "µs": 1e-6, "ns": 1e-9},
    "velocity": {"m/s": 1, "km/s": 1e3, "mm/s": 1e-3, "Å/ps": 100, "nm/ns": 1},
    "temperature": {"K": 1, "mK": 1e-3},
}


@given(st.floats(1e-6, 1e6), st.sampled_from(sorted(QUANTITIES)), st.data(), st.sampled_from(["", " ", "  "]))
def test_a_number_with_its_unit_is_read(
    value: float, quantity: Quantity | Motion, data: st.DataObject, space: str
) -> None:
    unit = data.draw(st.sampled_from(sorted(QUANTITIES[quantity])))
    assert parse(f"{value!r}{space}{unit}", quantity) == pytest.approx(value * QUANTITIES[quantity][unit], rel=1e-6)
    for other in QUANTITIES.keys() - {quantity}:
        with pytest.raises(ValueError, match="not a unit of"):
            parse(f"{value!r}{unit}", other)


@given(st.floats(1e-15, 1e15), st.sampled_from(sorted(QUANTITIES)))
def test_what_is_shown_can_be_read(value: float, quantity: Quantity | Motion) -> None:
    assert parse(readable(value, quantity, 6), quantity) == pytest.approx(value, rel=1e-5)


def test_the_units_of_atoms_that_move_are_those_of_one_mechanics() -> None:
    # Copper: of 63.5 u, the velocity of 1 is 4.6 km/s, the time of 1 55 fs (docs/decks.md).
    units = Units.metal(2.556, 135.2 / GPA_PER_EV_PER_A3, 63.546)
    assert units.si("velocity") == pytest.approx(4630, rel=0.01)
    assert units.si("time") == pytest.approx(55e-15, rel=0.01)
    assert units.mass is not None
    assert units.mass * units.si("velocity") ** 2 == pytest.approx(units.si("energy"), rel=1e-12)
    assert units.si("velocity") * units.si("time") == pytest.approx(units.a0, rel=1e-12)
    assert units.si("temperature") * 1.380649e-23 == pytest.approx(units.si("energy"), rel=1e-12)
    with pytest.raises(ValueError, match="a velocity has a unit where atoms have a mass"):
        Units(3e-10, 1e11).si("velocity")


@pytest.mark.parametrize("text", ["-0.1 GPa", "0 GPa"])
def test_a_quantity_that_may_have_a_sign_is_read_with_it(text: str) -> None:
    assert parse(text, "pressure", signed=True) == pytest.approx(float(text.split()[0]) * 1e9)
    with pytest.raises(ValueError, match="positive"):
        parse(text, "pressure")


NO_LENGTHS = ["", "nm", "5", "5 5nm", "nan nm", "inf nm", "-5nm", "0nm", "1e400nm", "0x5nm", "5,5nm"]


def test_what_is_no_length_is_refused() -> None:
    for text in NO_LENGTHS:
        with pytest.raises(ValueError, match=r"unit|positive|not a number"):
            parse(text, "length")
