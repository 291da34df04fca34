"""Parse sizes, units, shares and parts of a map from text into numbers in m.

Names in backticks in messages are arguments, which the command replaces by its options.
"""

import re
from collections.abc import Sequence
from numbers import Real as Number

from continuum.inputs import possible, units
from continuum.inputs.arguments import ArgumentError, instance, number, texts
from continuum.maps.map import TopographyError, as_fault

PER_MAP = {"size": '"10um" or "10um,12um"', "unit": '"nm"', "dataset": '"heights"', "part": '"Height"'}
"""Arguments that are one text for all maps or one for each, with examples."""
_ZERO = re.compile(r"\s*[0.]+\s*\D*")
"""Zero, which needs no unit."""


def texts_of(count: int, **values: str | Sequence[str] | None) -> dict[str, tuple[str, ...]]:
    """The texts given for the maps: none, one for all, or one for each."""
    found = {name: texts(name, value, PER_MAP[name]) for name, value in values.items()}
    for name, several in found.items():
        if len(several) not in (0, 1, count):
            of = "one map" if count == 1 else f"{count} maps"
            msg = f"`{name}`: {len(several)} values for {of}: give one for all, or one for each"
            msg += '; the two lengths of a map are one text, "10um,12um"' if name == "size" else ""
            raise TopographyError(msg)
    return found


def text_for(values: Sequence[str], i: int) -> str | None:
    """The text for one map; None leaves it to the file."""
    value = values[i if len(values) > 1 else 0] if values else "-"
    return None if value == "-" else value


def sizes_of(source: str, text: str | None) -> tuple[float, ...] | None:
    """One length or two, in m, from a text such as "10um" or "10um,12um"; None for None."""
    if text is None:
        return None
    with as_fault(f"{source}: `size` "):
        found = tuple(units.parse(one, "length") for one in text.split(","))
    if len(found) > 2:
        raise TopographyError(f"{source}: `size` {text!r}: a map has one or two lengths")
    return found


def units_of(source: str, names: str | None) -> tuple[float | None, float | None]:
    """Units of heights and of positions, in m, from "nm", or "um,nm" where the positions come first; None if not told.

    A single unit is that of the heights.
    """
    if names is None:
        return None, None
    with as_fault(f"{source}: `unit`: "):
        found = tuple(units.unit_size(name.strip(), "length") for name in names.split(","))
    if len(found) > 2:
        raise TopographyError(f"{source}: `unit` {names!r}: one unit, of the heights, or two, of positions and heights")
    return found[-1], found[0] if len(found) == 2 else None


def length_of(name: str, text: str | None) -> float | None:
    """A wavelength, or a radius of a tip, in m from a text such as "10nm"; None for None."""
    if text is None:
        return None
    instance(name, text, str, 'a text such as "10nm"')
    with as_fault(f"`{name}` "):
        return possible.from_text(text, "tip" if name == "tip" else "wavelength")


def share(fill: str | float | None) -> float:
    """The share of the points that may be filled, from "5%" or 0.05; 0 for None."""
    if fill is None:
        return 0.0
    if isinstance(fill, Number):
        return number("fill", fill, above=0, most=0.5)
    text = instance("fill", fill, str, 'a text such as "5%", or a number such as 0.05')
    try:
        value = float(text.strip().removesuffix("%")) / (100 if text.strip().endswith("%") else 1)
    except ValueError:
        value = -1.0
    if not 0 < value <= 0.5:
        raise TopographyError(f"`fill` {text!r}: the largest share of points that may be filled, like 5%, at most 50%")
    return value


def voids_of(void: str | float | Sequence[str | float]) -> tuple[float, ...]:
    """The numbers that stand for missing heights: none, one or several, as texts or numbers; NaN is allowed."""
    several = (void,) if isinstance(void, str) or not isinstance(void, Sequence) else tuple(void)
    if not all(isinstance(one, str | Number) and not isinstance(one, bool) for one in several):
        raise ArgumentError("void", void, "a number that stands for a missing height, or several")
    try:
        return tuple(float(one) for one in several)
    except (ValueError, OverflowError) as error:
        raise TopographyError(f"`void` {void!r}: a number that stands for a missing height, as 99999") from error


def corners_of(crop: str | None) -> tuple[float, float, float, float] | None:
    """The part of a map from x0 to x1 and from y0 to y1, in m, from "1um,9um,0,8um"; None for None."""
    if crop is None:
        return None
    parts = instance("crop", crop, str, 'a text such as "1um,9um,0,8um"').split(",")
    try:
        a, b, c, d = (0.0 if _ZERO.fullmatch(one) else units.parse(one, "length") for one in parts)
    except ValueError as error:
        why = error if len(parts) == 4 else f"{len(parts)} lengths"
        raise TopographyError(f"`crop` {crop!r}: four lengths, x0,x1,y0,y1, as 1um,9um,1um,9um ({why})") from error
    return a, b, c, d
