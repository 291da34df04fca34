"""Heights in files of a user's own: text, npy, HDF5 and netCDF, with what the file says of their size and unit.

The first index of heights is that of x.  A matrix of text is written line by line with x along a line, as Gwyddion
and SurfaceTopography write it; binary arrays have the order of their indices, unless their axes have names.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.store.hdf5 import RawAxis, RawDataset, StoreError, only_array, read_dataset
from continuum.store.text import Text, column_kinds, decoded, read_text, said_by, unit_in, units_in

HDF5_SUFFIXES = frozenset({".h5", ".hdf5", ".hdf", ".nc"})
FEWEST = 16
"""Smallest number of points of a map in each direction: two or three columns are never a map of heights."""
NO_HEIGHT = 1e25
"""Larger numbers are no heights in any unit: instruments write the largest single or double for a missing one."""
_FAR = 10.0
"""A repeated value this many times as far from the others as these lie apart is asked for: heights have no such gap."""
_STANDS_FOR_NOTHING = frozenset(
    {sign * (10**n - 1) for n in range(4, 11) for sign in (-1, 1)}
    | {-(2**15), 2**15 - 1, 2**16 - 1, -(2**31), 2**31 - 1, 2**32 - 1}
)
"""Values that programs write for a missing one: nines, and the ends of integers."""

_EVEN = 1e-3
"""Largest deviation of points of a line scan from equal distances, as a part of the spacing."""
_SAME = 1e-4
"""Positions that differ by less than this part of the extent are taken as equal."""
_OFF_GRID = 0.2
"""Largest distance of a position from its place on the grid, as a part of the spacing."""
_SPARSE = 10
"""Largest ratio of places on the grid to points; with more, the points are not on a grid."""


Placed = tuple[Real, tuple[float, ...], tuple[str, ...]]
"""Heights, their size in the unit of their positions, and the steps taken."""


class RawMap(NamedTuple):
    """Heights in a file, with its size and units."""

    heights: Real
    source: str
    size: tuple[float, ...] | None = None
    """Size of the map, in m."""
    unit: float | None = None
    """Unit of the heights, in m."""
    periodic: bool = False
    steps: tuple[str, ...] = ()
    """Description of choices made for it."""
    of: str = "the file"
    """Its name in messages: a file or an array in memory."""
    extent: tuple[float, ...] | None = None
    """Size of the map in the unit of its positions, which may be unknown; None if it has no positions."""
    unread: bool = False
    """Whether it has keys and values in a header that were not understood."""


def read_map(path: Path, dataset: str | None = None, shape: tuple[int, int] | None = None) -> RawMap:
    """Heights of a file, as it holds them.

    Parameters
    ----------
    path : ``.npy``; HDF5 and netCDF (``.h5``, ``.hdf5``, ``.hdf``, ``.nc``); anything else is text.
    dataset : name of the dataset in an HDF5 file; None takes the only one.
    shape : shape that the heights should have; binary files are checked before anything is loaded.

    Raises ValueError or OSError if the file is missing, damaged, of another kind, or does not hold real numbers of
    that shape.
    """
    suffix = path.suffix.lower()
    if suffix in HDF5_SUFFIXES:
        found = _of_dataset(path, dataset, shape)
    elif suffix == ".npy":
        # Mapped, so that a header that claims terabytes costs nothing; never pickled.
        try:
            values: NDArray[Any] = np.lib.format.open_memmap(path, mode="r")
        except (ValueError, EOFError) as error:
            raise ValueError(f"{path} is not a plain .npy file, or is truncated ({error})") from error
        _may_be(path, values.shape, shape)
        if values.dtype.kind not in "iuf":
            raise ValueError(f"{path} holds {values.dtype}, not real numbers")
        found = of_array(np.array(values, dtype=np.float64), path.name, shape)
    else:
        found = _of_text(read_text(path), path.name, shape)
    if shape is not None:
        turned = found.heights.shape[::-1] == shape and suffix not in HDF5_SUFFIXES | {".npy"}
        _checked(path, found.heights.shape, shape, ": x is along a line of text, y from line to line" if turned else "")
    return found


def _checked(path: Path, found: tuple[int, ...], shape: tuple[int, int], hint: str = "") -> None:
    if found != shape:
        raise StoreError(f"{path} holds an array of shape {found}, the grid has {shape}{hint}")


def _may_be(path: Path, found: tuple[int, ...], shape: tuple[int, int] | None) -> None:
    """Raise StoreError if an array of this shape, not yet loaded, cannot be a map of another one."""
    # As many numbers as points, or three times: columns of x, y and height.
    if shape is not None and np.prod(found) not in (np.prod(shape), 3 * np.prod(shape)):
        _checked(path, found, shape)


def of_array(values: Real, source: str, shape: tuple[int, ...] | None = None, of: str = "the file") -> RawMap:
    """The map of an array without units: heights, or columns of positions and heights."""
    # A map of two or three pixels a line is unusual: unless it is asked for, these are positions and heights.
    columns = values.ndim == 2 and values.shape[1] in (2, 3) and values.shape[0] >= FEWEST and values.shape != shape
    if columns:
        return _placed(values, source, of=of)
    # One row or one column is a line scan, unless a map of that shape is asked for.
    single = values.ndim == 2 and min(values.shape) == 1 and values.shape != shape
    return RawMap(values.ravel() if single else values, source, of=of)


def _placed(values: Real, source: str, named: Sequence[float] = (), of: str = "the file") -> RawMap:
    """The map of columns of positions and heights, with their units in m if these are known."""
    if len(set(named[:-1])) > 1:
        raise ValueError(f"{source}: x and y in two units")
    try:
        heights, extent, steps = line_of(*values.T) if values.shape[1] == 2 else grid_of(*values.T)
    except ValueError as error:
        raise ValueError(f"{source}: {values.shape[1]} columns, of positions and heights: {error}") from error
    size = tuple(named[0] * length for length in extent) if named else None
    return RawMap(heights, source, size, named[-1] if named else None, steps=steps, of=of, extent=extent)


def _of_text(text: Text, source: str, shape: tuple[int, int] | None) -> RawMap:
    """The map of a text: columns of positions and heights, or lines along x."""
    rows = text.rows
    steps = (*text.steps, *(f"header left out: {line!r}" for line in text.header[-1:]))
    said = said_by(text.header)
    used = _columns(rows, column_kinds(text.fields, rows.shape[1])) if rows.T.shape != shape else ()
    if used:
        try:
            named = units_in(text.header, text.fields, used)
        except ValueError as error:
            raise ValueError(f"{source}: {error}") from error
        if len(used) < rows.shape[1]:
            steps += (f"columns {' '.join(str(i + 1) for i in used)} of {rows.shape[1]} used, positions and heights",)
        rows = np.column_stack([rows[:, used[:-1]], without_voids(rows[:, used[-1]], said.voids)])
        found = _placed(rows, source, named)
        return found._replace(steps=(*steps, *found.steps))
    try:
        heights, extent = _of_axes(without_voids(rows.T, said.voids), (text.columns, text.lines))
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from error
    size = said.size or (tuple(n * said.pixel for n in heights.shape) if said.pixel else None)
    if min(heights.shape) == 1 and heights.shape != shape:
        heights, size, extent = heights.ravel(), size[:1] if size else None, None
    # Keys and values that say neither size nor unit: another reader may know them.
    unread = (size is None or said.unit is None) and any(mark in line for line in text.header for mark in ":=")
    return RawMap(heights, source, size, said.unit, steps=steps if rows.size else (), extent=extent, unread=unread)


def _columns(rows: Real, kinds: Sequence[str]) -> tuple[int, ...]:
    """The columns of positions and of heights in a table, by their names or their number; none of a matrix of heights.

    A table of more columns than two or three is one of positions where their names say so, or the first two lie on a
    grid; the heights are then the third, or the first that is called so.
    """
    lines, count = rows.shape
    # Fewer rows than the smallest map has points, or as many columns as that has: a matrix of heights.
    if lines < FEWEST or not 2 <= count < FEWEST:
        return ()
    along = tuple(kinds.index(name) for name in "xy" if name in kinds)
    if len(along) < 2 and count > 2 and _on_grid(rows[:, 0], rows[:, 1]):
        along = (0, 1)
    if along and (len(along) == 2 or "z" in kinds):
        rest = [i for i in range(count) if i not in along]
        named = [i for i in rest if kinds and kinds[i] == "z"]
        return (*along, *(named or rest)[:1])
    return tuple(range(count)) if count <= 3 else ()


def _on_grid(x: Real, y: Real) -> bool:
    """Whether positions fill most of a grid of two directions."""
    try:
        (i, _), (j, _) = places_of(x, "x"), places_of(y, "y")
    except ValueError:
        return False
    rows, columns = int(i.max()) + 1, int(j.max()) + 1
    # At least half of the places are taken: two columns of a matrix of heights would be spread over far more.
    return min(rows, columns) > 1 and rows * columns <= 2 * x.size and np.unique(i * columns + j).size == x.size


def without_voids(heights: Real, voids: Sequence[float]) -> Real:
    """Heights without these values, which become NaN."""
    return np.where(np.isin(heights, voids), np.nan, heights) if voids else heights


def _of_axes(heights: Real, axes: Sequence[Real | None]) -> tuple[Real, tuple[float, ...] | None]:
    """Heights in the order of ascending positions, and the size in their unit; None for a count."""
    steps = list[float]()
    for axis, positions in enumerate(axes):
        if positions is None or positions.size < 2:
            continue
        index, step = places_of(positions, "xy"[axis])
        if not np.array_equal(np.sort(index), np.arange(index.size)):
            raise ValueError(f"the positions along {'xy'[axis]} are not equidistant")
        heights = np.take(heights, np.argsort(index), axis=axis)
        if step != 1 or positions.min() not in (0, 1):  # 0, 1, 2 ... and 1, 2, 3 ... count points
            steps.append(step)
    return heights, tuple(n * step for n, step in zip(heights.shape, steps, strict=True)) if len(steps) == 2 else None


def _of_dataset(path: Path, name: str | None, shape: tuple[int, int] | None) -> RawMap:
    """The map of a dataset of an HDF5 or netCDF file, with what its attributes and axes say."""
    taken = name or only_array(path)
    steps: tuple[str, ...] = () if name else (f"dataset {taken!r} taken, the only one",)
    data = read_dataset(path, taken, lambda found: _may_be(path, found, shape))
    try:
        found = of_data(data, path.name, shape)
    except ValueError as error:
        raise ValueError(f"{path}: dataset {taken!r}: {error}") from error
    return found._replace(steps=(*steps, *found.steps))


def data_of(values: Real, value: Any) -> RawDataset:
    """An array in memory with what it says of itself, as xarray, pandas, h5py, netCDF4, pint and Astropy do.

    Parameters
    ----------
    values : its numbers.
    value : the array: its ``attrs``, or ``units`` or ``unit``, and ``dims`` with ``coords``, are looked at.
    """
    said = getattr(value, "attrs", None)
    attributes = dict(said) if isinstance(said, Mapping) else {}
    unit = getattr(value, "units", None) or getattr(value, "unit", None)
    if unit is not None and not any(key.lower() in ("units", "unit") for key in map(str, attributes)):
        attributes["units"] = str(unit)
    dims, coordinates = getattr(value, "dims", ()), getattr(value, "coords", {})
    if not (isinstance(dims, tuple) and all(isinstance(name, str) for name in dims)):
        return RawDataset(values, attributes, ())
    axes = []
    for name in dims:
        one = coordinates.get(name)
        known = one is not None and one.ndim == 1 and np.asarray(one).dtype.kind in "iuf"
        positions = np.asarray(one, dtype=np.float64) if known else None
        axes.append(RawAxis(name, positions, dict(one.attrs) if one is not None else {}))
    return RawDataset(values, attributes, tuple(axes))


def of_data(data: RawDataset, source: str, shape: tuple[int, int] | None = None, of: str = "the file") -> RawMap:
    """The map of an array with attributes and axes; raises ValueError for a unit that is no length."""
    found = of_array(decoded(data.values, data.attributes), source, shape, of)
    steps: tuple[str, ...] = ()
    unit = unit_in(data.attributes)
    axis_units = [unit_in(axis.attributes) for axis in data.axes]
    names = [axis.name.lower() for axis in data.axes]
    positions, heights = [axis.values for axis in data.axes], found.heights
    if names == ["y", "x"] and heights.ndim == 2:
        heights, positions, axis_units = heights.T, positions[::-1], axis_units[::-1]
        steps += ("turned, as its axes are y and x",)
    extent = found.extent
    if heights.ndim == 2 and positions and all(one is not None for one in positions):
        heights, extent = _of_axes(heights, positions)
    known = [one for one in axis_units if one is not None]
    size = (
        tuple(n * one for n, one in zip(extent, known, strict=True)) if extent and len(known) == len(extent) else None
    )
    return found._replace(heights=heights, size=size, unit=unit, extent=extent, steps=(*steps, *found.steps))


def stands_for_nothing(heights: Real) -> tuple[float, int] | None:
    """The lowest or highest value and how often it occurs, if it probably stands for missing heights; None if not.

    It is repeated exactly, and farther from all others than these lie apart.
    """
    whole = heights[np.isfinite(heights)]
    for value in (whole.max(initial=-np.inf), whole.min(initial=np.inf)):
        if np.count_nonzero(whole == value) < 2 and value not in _STANDS_FOR_NOTHING:
            continue
        rest = whole[whole != value]
        count, apart = whole.size - rest.size, np.ptp(rest) if rest.size else 0.0
        far = np.abs(rest - value).min(initial=np.inf)
        if apart > 0 and ((count > 1 and far > _FAR * apart) or (value in _STANDS_FOR_NOTHING and far > apart)):
            return float(value), count
    return None


def evenly_spaced(where: Real, heights: Real) -> tuple[Real, tuple[str, ...]]:
    """A line scan at equidistant points, interpolated if necessary, and the steps taken.

    The positions ascend.
    """
    even = np.linspace(where[0], where[-1], where.size)
    steps = np.diff(where)
    if np.abs(where - even).max() <= _EVEN * (even[1] - even[0]):
        return heights, ()
    widest = steps.max() / np.median(steps)
    return np.interp(even, where, heights), (
        f"resampled to points an equal distance apart, by straight lines over up to {widest:.3g} spacings",
    )


def line_of(x: Real, z: Real) -> Placed:
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


def grid_of(x: Real, y: Real, z: Real) -> Placed:
    """Put points in any order on a grid; places without a point are holes."""
    (i, dx), (j, dy) = places_of(x, "x"), places_of(y, "y")
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


def places_of(x: Real, name: str) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], float]:
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
