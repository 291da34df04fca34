"""What a file says about its numbers: size and units in lines of a header, and in attributes of a dataset.

Keys and values are those of the exports of Gwyddion, SPIP, Attocube, Nova and others, and of ESRI's grids; the
attributes those of the CF conventions of netCDF, which HDF5 shares.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from continuum.inputs import units
from continuum.model.fourier import Real

_REAL = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][+-]?\d+)?"
_UNIT = re.compile(r"(?:[\[(/]|\bin\b)\s*([A-Za-zµμÅ]+)\s*[\])]?")
"""A unit beside a name: x [um], Height (nm), z/nm, x in µm."""
_OF_HEIGHTS = re.compile(r"\b(?:heights?|values?|z)\s*(?:[\[(/]|\bin\b)\s*([A-Za-zµμÅ]+)", re.IGNORECASE)
_AXIS = r"(?:scan)?(?:{0}(?:scan)?(?:length|size|range|extent)|(?:length|size|range|extent){0}|{1})"
_KEYS = {
    # Gwyddion writes in the language of its user.
    "x": re.compile(_AXIS.format("x", "width|breite|largeur|šířka|larghezza|ширина|anchura|ancho|largura|폭|幅")),
    "y": re.compile(_AXIS.format("y", "height|höhe|hauteur|výška|altezza|высота|altura|높이|高さ")),
    "both": re.compile(r"scansize|imagesize|scanrange|fieldofview|size"),
    "pixel": re.compile(r"pixelsize|cellsize|spacing"),
    "x unit": re.compile(r"(?:xy|x|lateral)units?|unitx"),
    "unit": re.compile(
        r"(?:values?|z|heights?|data)units?|unit(?:z|data)|(?:wert(?:e|en)?|z|höhen)einheit(?:en)?|einheit(?:en)?(?:derwerte)?"
        r"|unités(?:de(?:s)?valeurs?)?|jednotkyhodnot|unitàvalor[ei]|unitàdimisura|единицыизмерения|единицызначений"
        r"|unidades(?:delvalor|devalor)?|값단위|値の単位"
    ),
    "void": re.compile(r"nodata(?:value)?|fillvalue|missingvalue"),
}
"""What keys mean, written small and without blanks, dashes and units."""
_NAMED = {
    "x": re.compile(
        r"x(?:pos(?:ition)?|coord(?:inate)?|axis)?|lateral(?:position)?|(?:scan)?(?:distance|position|length)"
    ),
    "y": re.compile(r"y(?:pos(?:ition)?|coord(?:inate)?|axis)?"),
    "z": re.compile(r"z(?:pos(?:ition)?|coord(?:inate)?|axis)?|h|heights?|topography|(?:total|raw)?profile|elevation"),
}
"""Names of columns, written small and without blanks, dashes and units."""
_SPELLED = {"micron": "um", "micrometer": "um", "micrometre": "um", "mum": "um", "nanometer": "nm", "nanometre": "nm",
            "angstrom": "A", "ang": "A", "meter": "m", "metre": "m", "millimeter": "mm", "millimetre": "mm",
            "picometer": "pm", "picometre": "pm"}  # fmt: skip
_NO_LENGTH = frozenset({
    "v", "mv", "uv", "µv", "na", "pa", "s", "ms", "us", "µs", "hz", "khz", "n", "nn", "un", "µn", "pn", "deg", "rad",
    "°", "%", "counts", "cts", "arb", "arb.u.", "a.u.", "kpa", "mpa", "gpa", "k", "°c", "db", "grey", "gray",
})  # fmt: skip
"""Other units in a row of units, in lower case."""
_NO_UNIT = frozenset({"", "1", "a0", "px", "pixel", "pixels", "points", "pts", "samples", "dimensionless"})
"""The unit of numbers that come without one, and of results of this program, in a0."""


class Said(NamedTuple):
    """What a file says: lengths along x and y and unit of the heights, in m, pixel in m, numbers that are missing."""

    size: tuple[float, ...] | None = None
    unit: float | None = None
    pixel: float | None = None
    voids: tuple[float, ...] = ()


def unit_of(name: str) -> float | None:
    """Size in m of a unit of length in a file; None where it stands for none.

    Raises ValueError if it is a unit of something else, or unknown.
    """
    plain = name.strip().strip("[]()")
    if plain.lower() in _NO_UNIT:
        return None
    return units.unit_size(_SPELLED.get(plain.lower().removesuffix("s"), plain), "length")


def _known(name: str) -> float | None:
    try:
        return unit_of(name)
    except ValueError:
        return None


def units_in(header: Sequence[str], fields: Sequence[Sequence[str]], used: Sequence[int]) -> tuple[float, ...]:
    """Units of length of columns of positions and heights, in m, from the last line that has one for each.

    Parameters
    ----------
    header, fields : the lines before the numbers, whole and as the fields of each.
    used : the columns.

    Raises ValueError if a row of units has another one than of length for a column that is used.
    """
    for line, row in zip(reversed(header), reversed(fields), strict=True):
        if units_of_row := _row_of_units(row, used):
            return units_of_row
        found = [unit for name in _UNIT.findall(line) if (unit := _known(name)) is not None]
        if len(found) > max(used) or len(found) == len(used):
            return tuple(found[i] for i in used) if len(found) > max(used) else tuple(found)
    return ()


def _row_of_units(row: Sequence[str], used: Sequence[int]) -> tuple[float, ...]:
    """Units of the columns that are used, in m, if each field of a row is a unit; whatever the columns are called."""
    plain = [field.strip(" []()\"'") for field in row]
    if len(plain) <= max(used) or not all(
        _known(name) is not None or name.lower() in _NO_LENGTH or (name == "" and i not in used)
        for i, name in enumerate(plain)
    ):
        return ()
    for i in used:
        if _known(plain[i]) is None:
            raise ValueError(f"column {i + 1} is in {plain[i]!r}, which is no unit of length")
    return tuple(unit_of(plain[i]) or np.nan for i in used)


def column_kinds(fields: Sequence[Sequence[str]], columns: int) -> tuple[str, ...]:
    """Content of each column by its name, "x", "y", "z" or nothing; empty where no line names all columns."""
    for row in reversed(fields):
        plain = [re.sub(r"[\[(/].*|\bin\b.*|_?(?:nm|um|µm|mm)$|[\s_\"'-]", "", field.lower()) for field in row]
        kinds = [next((kind for kind, names in _NAMED.items() if names.fullmatch(name)), "") for name in plain]
        if len(row) == columns and any(kinds):
            return tuple(kinds)
    return ()


def said_by(header: Sequence[str]) -> Said:
    """Size, unit and missing numbers that a header gives for a matrix of heights.

    Raises ValueError if it has a unit that is no length.
    """
    found, rest = dict[str, str](), list[str]()
    for line in header:
        key, mark, value = re.match(r"([^:=]*)([:=]?)(.*)", line).groups()  # type: ignore[union-attr]
        if not mark and (pair := re.fullmatch(rf"([A-Za-z_]+)\s+({_REAL})", line)):
            key, value = pair.groups()
        name, beside = re.sub(r"[\[(].*|[\s_-]", "", key).lower(), re.search(r"[\[(](.*?)[\])]", key)
        meaning = next((one for one, known in _KEYS.items() if known.fullmatch(name) and value.strip()), None)
        if meaning is None:
            rest.append(line)
        else:
            found.setdefault(meaning, f"{value.strip()} {beside[1] if beside else ''}".strip())
    lateral = found.get("x unit", "")
    x, y = (_lengths(found.get(name, ""), lateral, unit_of) for name in "xy")
    both, pixel = (_lengths(found.get(name, ""), lateral, _known) for name in ("both", "pixel"))
    size = (x[0], y[0]) if x and y else both or x
    unit = unit_of(found["unit"]) if "unit" in found else None
    if unit is None:
        unit = next((one for name in _OF_HEIGHTS.findall("\n".join(rest)) if (one := _known(name))), None)
    voids = tuple(float(found["void"]) for _ in range(1) if re.fullmatch(_REAL, found.get("void", "")))
    return Said(size[:2] or None, unit, pixel[0] if pixel else None, voids)


def _lengths(text: str, lateral: str, read: Callable[[str], float | None]) -> tuple[float, ...]:
    """Lengths in m in the value of a key, as 1 µm, or 1 µm x 2 µm; empty if they have no unit."""
    parts = re.findall(rf"({_REAL})\s*((?!x\s*[\d.])[A-Za-zµμÅ]*)", text)
    names = [name for _, name in parts if name] or [lateral]
    sizes = [read(name or names[-1]) for _, name in parts]
    lengths = [
        float(re.sub("[dD]", "e", number.replace(",", "."))) * size
        for (number, _), size in zip(parts, sizes, strict=True)
        if size
    ]
    return tuple(lengths) if len(lengths) == len(parts) and all(length > 0 for length in lengths) else ()


def decoded(values: Real, attributes: Mapping[str, Any]) -> Real:
    """Numbers of a dataset after its attributes: missing ones are NaN, then scaled and shifted.

    Attributes are those of the CF conventions, section 2.5.1 and 8.1: ``_FillValue``, ``missing_value``,
    ``valid_min``, ``valid_max``, ``valid_range``, of numbers as they are stored, ``scale_factor`` and ``add_offset``.
    """
    plain = {name: np.ravel(value).astype(np.float64) for name, value in attributes.items()
             if np.asarray(value).dtype.kind in "iuf" and np.size(value)}  # fmt: skip
    missing = np.zeros(values.shape, dtype=bool)
    for name in ("_FillValue", "missing_value"):
        missing |= np.isin(values, plain.get(name, ()))
    least, most = plain.get("valid_range", (-np.inf, np.inf))[:2]
    missing |= (values < plain.get("valid_min", (least,))[0]) | (values > plain.get("valid_max", (most,))[0])
    scale, offset = (plain.get(name, (default,))[0] for name, default in (("scale_factor", 1.0), ("add_offset", 0.0)))
    return np.where(missing, np.nan, values * scale + offset) if plain else values


def unit_in(attributes: Mapping[str, Any]) -> float | None:
    """The unit of a dataset in m, from its attribute ``units``; None if it has none.

    Raises ValueError if it is no unit of length.
    """
    name = next((attributes[key] for key in attributes if key.lower() in ("units", "unit")), "")
    if isinstance(name, np.ndarray):
        name = name.ravel()[0] if name.size else ""
    return unit_of(name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name))
