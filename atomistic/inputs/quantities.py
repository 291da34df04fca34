"""Quantities of a deck with their units, as "10m/s", "5ps", "1GPa", "2.5Å", "20nN" or "300K", and in reduced ones.

A key with a unit accepts text if the crystal has a length scale, which is known once it has been measured.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from continuum.inputs.tables import Fault, Key
from continuum.inputs.units import Motion, Quantity, Units, parse, readable

QUANTITIES: dict[str, Quantity | Motion] = {
    **dict.fromkeys(
        ("separation", "separations", "distance", "depth", "radius", "flat_radius", "edge_radius", "amplitude",
         "rms_height", "lambda_s", "lambda_L", "range", "effective_range", "decay_length", "adhesion_length"), "length"
    ),
    "pressures": "pressure",
    "pressure": "pressure",
    "surface_energy": "energy_per_area",
    "velocity": "velocity",
    "window": "time",
    "damping": "time",
    "temperature": "temperature",
}  # fmt: skip
"""Keys of the input of a deck that accept a unit, with their quantity."""
_TABLES = ("slab", "surface", "wall", "protocol")
_REDUCED: dict[Quantity | Motion, str] = {
    "length": "a0",
    "pressure": "E*",
    "energy_per_area": "E* a0",
    "force": "E* a0²",
    "velocity": "(E* a0³/m)^(1/2)",
    "time": "a0 (m/(E* a0³))^(1/2)",
    "temperature": "E* a0³",
}


def with_units(data: Mapping[str, Any]) -> list[Key]:
    """Keys of an input whose value is or contains a text with a unit, except temperatures."""
    return [
        key
        for key, value in _quantities(data)
        if key[-1] != "temperature" and any(isinstance(item, str) for item in _items(value))
    ]


def in_reduced(data: Mapping[str, Any], units: Units | None) -> tuple[dict[str, Any], list[Fault]]:
    """The input with texts with units replaced by reduced numbers, and the faults of these texts.

    Parameters
    ----------
    data : tables and keys of an input, or of a part of it.
    units : units of the crystal; None if it has no length scale.
    """
    found: dict[str, Any] = {n: dict(value) if isinstance(value, Mapping) else value for n, value in data.items()}
    faults = []
    for key in with_units(data):
        table, name = found[str(key[0])] if len(key) == 2 else found, str(key[-1])
        quantity = QUANTITIES[name]
        try:
            if units is None:
                raise ValueError("this crystal has no length scale, and so no units")
            table[name] = _number(table[name], quantity, units)
        except ValueError as error:
            allowed = f"a number, in {_REDUCED[quantity]}"
            if units is not None:
                size = readable(units.si(quantity), quantity)
                allowed += f"; or one with its unit, as {size.replace(' ', '')!r}, which 1 is"
            faults.append(Fault(key, allowed, str(error)))
    return found, faults


def in_both(data: Mapping[str, Any], units: Units | None, rest: Units | None = None) -> Iterator[tuple[str, str]]:
    """Quantities of an input in reduced and real units, if its crystal has a length scale: dotted keys and texts.

    Temperatures are in units of the crystal at ``rest``, if that is another one.
    """
    if units is None:
        return
    for key, value in _quantities(in_reduced(data, units)[0]):
        quantity, name = QUANTITIES[str(key[-1])], ".".join(map(str, key))
        size = (rest or units if quantity == "temperature" else units).si(quantity)
        if isinstance(value, str):  # a temperature
            value = parse(value, quantity, signed=True) / size
        numbers = [number for number in _items(value) if isinstance(number, int | float)]
        shown = numbers if len(numbers) <= 4 else [numbers[0], numbers[-1]]
        join = ", " if len(numbers) <= 4 else " ... "
        if shown:
            real = join.join(readable(number * size, quantity) for number in shown)
            if key[-1] == "adhesion_length":  # l_a = w/E*
                real += "; w = " + join.join(
                    readable(units.to_si(n, "energy_per_area"), "energy_per_area") for n in shown
                )
            yield name, f"{join.join(f'{number:.4g}' for number in shown)} {_REDUCED[quantity]} = {real}"


def _quantities(data: Mapping[str, Any]) -> Iterator[tuple[Key, Any]]:
    """Keys that take a unit, with their values: of the top and of the tables of a deck."""
    for name, value in data.items():
        if isinstance(value, Mapping) and name in _TABLES:
            yield from (((name, inner), item) for inner, item in value.items() if inner in QUANTITIES)
        elif name in QUANTITIES:
            yield (name,), value


def _items(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else [value]


def _number(value: Any, quantity: Quantity | Motion, units: Units) -> Any:
    """A value, or each of a list, in reduced units."""
    if isinstance(value, list | tuple):
        return [_number(item, quantity, units) for item in value]
    return parse(value, quantity, signed=True) / units.si(quantity) if isinstance(value, str) else value
