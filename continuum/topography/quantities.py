"""Sizes, units, shares and parts of a map as a person writes them, read as numbers in m.

What a message names in backticks is an argument; the command writes it as its option.  A text that cannot be read
raises TopographyError, with the ``source`` of the map, and what is no text ArgumentError.
"""

from __future__ import annotations

import re
from numbers import Real as Number

from continuum import units
from continuum.arguments import instance, number
from continuum.topography.map import TopographyError


def sizes(source: str, text: str | None) -> tuple[float, ...] | None:
    """One length or two, in m, from a text such as "10um" or "10um,12um"; None for None."""
    if text is None:
        return None
    try:
        found = tuple(units.parse(one, "length") for one in text.split(","))
    except ValueError as error:
        raise TopographyError(f"{source}: `size` {error}") from error
    if len(found) > 2:
        raise TopographyError(f"{source}: `size` {text!r}: a map has one or two lengths")
    return found


def length_unit(source: str, name: str | None) -> float | None:
    """A unit of length, in m, from its name such as "nm"; None for None."""
    if name is None:
        return None
    try:
        return units.unit_size(name, "length")
    except ValueError as error:
        raise TopographyError(f"{source}: `unit`: {error}") from error


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


def corners(crop: str | None) -> tuple[float, float, float, float] | None:
    """The part of a map from x0 to x1 and from y0 to y1, in m, from "1um,9um,0,8um"; None for None."""
    if crop is None:
        return None
    parts = instance("crop", crop, str, 'a text such as "1um,9um,0,8um"').split(",")
    try:
        # An edge of the map is at zero, which has no unit.
        a, b, c, d = (0.0 if _is_zero(one) else units.parse(one, "length") for one in parts)
    except ValueError as error:
        why = error if len(parts) == 4 else f"{len(parts)} lengths"
        raise TopographyError(f"`crop` {crop!r}: four lengths, x0,x1,y0,y1, as 1um,9um,1um,9um ({why})") from error
    return a, b, c, d


def _is_zero(text: str) -> bool:
    digits = re.fullmatch(r"\s*([\d.]+)\s*\D*", text)
    return digits is not None and digits[1].strip("0.") == ""
