"""Text with columns of positions and heights: x and z of a line scan, or x, y and z of a map.

A map has at least 16 points in each direction, so that two or three columns are never a map of heights.  Lines of
words before the numbers are a header, which may have the units of the columns in brackets.
"""

import codecs
import re
from collections.abc import Callable, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from continuum import units
from continuum.model.fourier import Real
from continuum.topography.instruments import RawMap, evenly_spaced
from continuum.topography.map import FEWEST, TopographyError

_UNIT = re.compile(r"(?:[\[(/]|\bin\b)\s*([A-Za-zµμÅ]+)\s*[\])]?")
"""A unit in a header: x [um], Height (nm), z/nm, x in µm."""
_SAME = 1e-4
"""Positions that differ by less than this part of the extent are taken as equal."""
_OFF_GRID = 0.2
"""Largest distance of a position from its place on the grid, as a part of the spacing."""
_SPARSE = 10
"""Largest ratio of places on the grid to points; with more, the points are not on a grid."""


class Columns(NamedTuple):
    """Numbers of a text, and the lines of words before them."""

    values: Real
    header: tuple[str, ...]


def read_table(path: Path) -> Columns:
    """A table of numbers: columns apart by semicolons, tabs, commas or spaces; ``#`` begins a comment.

    Between semicolons or tabs a comma is a decimal mark.  A first column with the header "index" is left out.

    Raises TopographyError if it is not a table of numbers, or cannot be read.
    """
    try:
        with path.open(encoding=_encoding(path)) as file:
            header, first, words = list[str](), "", False
            for line in file:
                text = line.strip()
                only_words = not any(_is(float, field) for field in re.split(r"[;,\s]+", text) if field)
                if text.lstrip("#").strip() and (text.startswith("#") or only_words):
                    header.append(text.lstrip("#").strip())
                    words |= not text.startswith("#")
                elif text and not text.startswith("#"):
                    first = line
                    break
            mark = next((one for one in (";", "\t") if one in first.strip()), "," if "," in first else None)
            decimal = "." if mark in (",", None) else ","
            if words and not first:
                raise ValueError("words only")
            rows = (row.replace(decimal, ".") for row in chain([first], file))
            values = np.loadtxt(rows, dtype=np.float64, delimiter=mark, ndmin=2) if first else np.empty((0, 0))
    except (ValueError, OSError) as error:
        why = str(error).partition("; use `usecols`")[0]
        raise TopographyError(f"{path} is not a table of numbers with decimal points ({why})") from error
    if header and values.shape[1] > 1 and re.match(r"index\b", header[-1], re.IGNORECASE):
        values = values[:, 1:]
    return Columns(values, tuple(header))


def _encoding(path: Path) -> str:
    """The encoding of a text: UTF-16 if it begins with a byte order mark of that, else UTF-8."""
    with path.open("rb") as file:
        return "utf-16" if file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else "utf-8-sig"


def _is(read: Callable[[str], float], text: str) -> bool:
    """Whether a text can be read as a number, or as a unit."""
    try:
        read(text)
    except ValueError:
        return False
    return True


_unit_of_length = partial(units.unit_size, quantity="length")


def units_in(header: Sequence[str], columns: int) -> tuple[float, ...]:
    """Units of length of the columns, in m, from the last header line that has one for each; else empty."""
    for line in reversed(header):
        found = [_unit_of_length(name) for name in _UNIT.findall(line) if _is(_unit_of_length, name)]
        if len(found) == columns:
            return tuple(found)
    return ()


def from_table(table: Columns, source: str, of: str = "the file") -> RawMap:
    """The map of a table of heights, or of columns of positions and heights."""
    values = table.values
    steps = tuple(f"header left out: {line!r}" for line in table.header[-1:])
    if values.ndim != 2 or values.shape[1] not in (2, 3) or values.shape[0] < FEWEST:
        single = values.ndim == 2 and min(values.shape) == 1
        return RawMap(values.ravel() if single else values, source, steps=steps if values.size else (), of=of)
    named = units_in(table.header, values.shape[1])
    unit = named[-1] if named else None
    if len(set(named[:-1])) > 1:
        raise TopographyError(f"{source}: x and y in two units: {table.header[-1]!r}")
    try:
        found = _profile(*values.T) if values.shape[1] == 2 else _grid(*values.T)
    except ValueError as error:
        raise TopographyError(f"{source}: {values.shape[1]} columns, of positions and heights: {error}") from error
    heights, extent, how = found
    size = tuple(named[0] * length for length in extent) if named else None
    return RawMap(heights, source, size, unit, steps=(*steps, *how), of=of, extent=extent)


Placed = tuple[Real, tuple[float, ...], tuple[str, ...]]
"""Heights, their size in the unit of their positions, and the steps taken."""


def _profile(x: Real, z: Real) -> Placed:
    """A line scan of points in any order."""
    if not np.isfinite(x).all():
        raise ValueError("a position is missing")
    order = np.argsort(x, kind="stable")
    x, z = x[order], z[order]
    steps = np.diff(x)
    if not np.all(steps > 0):
        raise ValueError("two heights have the same position")
    length = float((x[-1] - x[0]) * x.size / (x.size - 1))
    z, how = evenly_spaced(x, z)
    return z, (length,), ("columns of position and height", *how)


def _grid(x: Real, y: Real, z: Real) -> Placed:
    """Put points in any order on a grid; places without a point are holes."""
    (i, dx), (j, dy) = _places(x, "x"), _places(y, "y")
    nx, ny = int(i.max()) + 1, int(j.max()) + 1
    if nx * ny > _SPARSE * z.size:
        raise ValueError(f"{z.size} points are not on a grid: most of {nx} x {ny} places are empty")
    if np.unique(i * ny + j).size < z.size:
        raise ValueError("two heights have the same position")
    heights = np.full((nx, ny), np.nan)
    heights[i, j] = z
    how = (f"columns of positions and heights put on a grid of {nx} x {ny} points",)
    if min(nx, ny) == 1:
        return heights.ravel(), (max(nx * dx, ny * dy),), how
    return heights, (nx * dx, ny * dy), how


def _places(x: Real, name: str) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], float]:
    """The place of each position on an even grid, and the spacing of the grid; 0 if there is one position only."""
    if not np.isfinite(x).all():
        raise ValueError("a position is missing")
    span = float(np.ptp(x))
    if span == 0:
        return np.zeros(x.size, dtype=np.int64), 0.0
    ordered = np.sort(x)
    distinct = ordered[np.append(True, np.diff(ordered) > _SAME * span)]
    step = float(np.median(np.diff(distinct)))
    # The mean over all differences is more accurate than one, as numbers are rounded.
    count = round(span / step)
    step = span / count if count else step
    place = (x - ordered[0]) / step
    index = np.rint(place).astype(np.int64)
    if np.abs(place - index).max() > _OFF_GRID:
        raise ValueError(f"the positions along {name} are not equidistant")
    return index, step
