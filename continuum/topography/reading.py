"""Read topographies from plain arrays, whose units must be given, and from files of instruments.

Arrays in memory or in files (npy, text, HDF5) have no units, so that size and unit of the heights must be given;
columns of positions and heights (:mod:`continuum.topography.columns`) may have units in a header, and files of
instruments have them (:mod:`continuum.topography.instruments`).  Arguments with units are parsed by
:mod:`continuum.topography.quantities`.  Files that cannot be read raise TopographyError, arguments of another type
ArgumentError.
"""

import os
from collections.abc import Sequence
from functools import partial
from importlib import util
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from continuum import units
from continuum.arguments import ArgumentError, file_name, flag, number, pair
from continuum.files.arrays import HDF5_SUFFIXES, read_numbers
from continuum.files.hdf5 import only_array
from continuum.model.fourier import Real
from continuum.topography.columns import Columns, from_table, read_table
from continuum.topography.instruments import ALL, RawMap, from_instrument, is_container, measurements
from continuum.topography.map import FEWEST, Topography, TopographyError, heights_of
from continuum.topography.mending import crop, harmonic
from continuum.topography.quantities import corners_of, share, sizes_of, text_for, texts_of, units_of
from continuum.topography.spectra import isotropic_surface, joined

_TEXT = frozenset({".txt", ".csv", ".dat", ".xyz", ".asc"})
_NETCDF = ".nc"
FEW_HOLES = 0.01
"""Largest share of missing heights that is filled by default."""


def read_topography(
    heights: str | Path | ArrayLike,
    *,
    size: Sequence[float] | None = None,
    unit: float | None = None,
    position_unit: float | None = None,
    periodic: bool | None = None,
    dataset: str | None = None,
    part: str | None = None,
    corners: tuple[float, float, float, float] | None = None,
    fill: float = 0.0,
    override: bool = False,
    source: str = "array",
) -> Topography:
    """A topography from a file, or from an array in memory.

    Parameters
    ----------
    heights : name of a file, npy, text or HDF5, or any format of SurfaceTopography, if that is installed.  Or an
        array, positive out of the body, shape (nx, ny), or one profile; masked points are missing.  Two columns are
        positions and heights of a profile, three those of a map.
    size : (Lx, Ly) in m, along the first index and the second, or (Lx,) for square pixels; only if the file does not
        say.
    unit : unit of the heights, in m; only if the file does not say.
    position_unit : unit of the positions, in m, if a file has columns of positions and heights; instead of a size.
    periodic : whether the map continues at its edges; None takes what the file says, and else no.
    dataset : dataset of an HDF5 file, if it has several.
    part : name of a map in a container, or of a channel, if there are several; :data:`ALL` joins all of a container.
    corners : (x0, x1, y0, y1) of the part to use, in m; None for all.
    fill : largest share of missing heights that is filled (:func:`continuum.topography.mending.harmonic`); 0 for
        :data:`FEW_HOLES`.
    override : whether a given size or unit overrules what the file says.
    source : name of an array in messages and on the page.
    """
    if periodic is not None:
        flag("periodic", periodic)
    if not isinstance(heights, str | os.PathLike):
        _whole_array(source, dataset=dataset, part=part)
        found = _plain(heights_of("heights", heights), source, of="an array")
        return _whole(_with_units(found, size, unit, position_unit, periodic, override), corners, fill)
    path = file_name("heights", heights)
    if not path.is_file():
        raise TopographyError(f"{path}: {'a folder, not a file' if path.is_dir() else 'there is no such file'}")
    if path.stat().st_size == 0:
        raise TopographyError(f"{path}: the file is empty")
    if part == ALL and is_container(path):
        one = partial(
            read_topography, path, size=size, unit=unit, periodic=periodic, corners=corners, fill=fill,
            override=override,
        )  # fmt: skip
        parts = [one(part=name) for name in measurements(path)]
        return joined(parts, f"{path.name}: all measurements")
    found = _raw(path, dataset, part, told=size is not None or unit is not None)
    return _whole(_with_units(found, size, unit, position_unit, periodic, override), corners, fill)


def _raw(path: Path, dataset: str | None, part: str | None, told: bool) -> RawMap:
    """Read a file by the reader for its format.

    Plain files other than npy may have units in a header that only SurfaceTopography reads, so that it reads those for
    which neither size nor unit is given.
    """
    suffix, others = path.suffix.lower(), util.find_spec("SurfaceTopography") is not None
    if suffix in _TEXT:
        try:
            table = read_table(path)
        except TopographyError:
            if told or not others:
                raise
            return from_instrument(path, part)
        found = from_table(table, path.name)
        if found.extent is None and others and not told:
            return from_instrument(path, part)
        _whole_array(path.name, part=part, dataset=dataset)
        return found
    hdf5 = suffix in HDF5_SUFFIXES and (suffix != _NETCDF or dataset is not None or not others)
    if not (suffix == ".npy" or (hdf5 and (told or dataset or not others))):
        return from_instrument(path, part)
    _whole_array(path.name, part=part, dataset=None if hdf5 else dataset)
    try:
        name, steps = dataset, tuple[str, ...]()
        if hdf5 and dataset is None:
            name = only_array(path)
            steps = (f"dataset {name!r} taken, the only one",)
        return _plain(read_numbers(path, name), path.name, steps=steps)
    except (ValueError, OSError) as error:
        raise TopographyError(str(error)) from error


def _plain(heights: Real, source: str, steps: tuple[str, ...] = (), of: str = "the file") -> RawMap:
    """An array without units: heights, or columns of positions and heights."""
    found = from_table(Columns(heights, ()), source, of)
    return found._replace(steps=(*steps, *found.steps))


def read_all(
    maps: Sequence[str | Path | ArrayLike],
    *,
    size: str | Sequence[str] | None = None,
    unit: str | Sequence[str] | None = None,
    dataset: str | Sequence[str] | None = None,
    part: str | Sequence[str] | None = None,
    join: bool = False,
    periodic: bool = False,
    crop: str | None = None,
    fill: str | float | None = None,
    override_size: bool = False,
) -> list[Topography]:
    """Read one or two topographies from files or arrays, with sizes and units as text: one for all, or one for each.

    Faults of all maps are reported together.  The arguments are those of :func:`continuum.predict`.
    """
    if flag("join", join) and len(maps) < 2:
        raise TopographyError(f"`join`: several measurements of one surface are joined, got {len(maps)}")
    if not join and not 1 <= len(maps) <= 2:
        msg = f"maps: a contact has one or two rough surfaces, got {len(maps)}; `join` measurements of one surface"
        raise TopographyError(msg if maps else "maps: give a height map, or two for two rough bodies")
    given = texts_of(len(maps), size=size, unit=unit, dataset=dataset, part=part)
    corners, limit = corners_of(crop), share(fill)
    always, override = flag("periodic", periodic), flag("override_size", override_size)
    found, faults = [], []
    for i, one in enumerate(maps):
        path = file_name("maps", one) if isinstance(one, str | os.PathLike) else None
        source = path.name if path is not None else "array" if len(maps) == 1 else f"array {i + 1}"
        text = {name: text_for(values, i) for name, values in given.items()}
        try:
            heights_unit, position_unit = units_of(source, text["unit"])
            size_of = sizes_of(source, text["size"])
            heights = heights_of("maps", one) if path is None else path
            if isinstance(heights, np.ndarray) and not heights.ndim:
                raise ArgumentError("maps", one, "names of files, or arrays of heights")
            found.append(
                read_topography(
                    heights, size=size_of, unit=heights_unit, position_unit=position_unit, periodic=always or None,
                    dataset=text["dataset"], part=text["part"], corners=corners, fill=limit, override=override,
                    source=source,
                )
            )  # fmt: skip
        except TopographyError as error:
            faults.append(str(error))
    if faults:
        raise TopographyError("\n".join(dict.fromkeys(faults)))
    return [joined(found, " + ".join(one.source for one in found))] if join else found


def _whole_array(source: str, **names: str | None) -> None:
    """Check that no dataset or part is given for a single array."""
    for name, value in names.items():
        if value is not None:
            raise TopographyError(f"{source}: `{name}` {value!r}: there is only one array; leave it out")


def _with_units(
    found: RawMap,
    size: Sequence[float] | None,
    unit: float | None,
    position_unit: float | None,
    periodic: bool | None,
    override: bool = False,
) -> RawMap:
    """Heights in m, with size and unit from the file or the arguments, from both only with ``override``."""
    if not found.heights.size:
        shape = " x ".join(map(str, found.heights.shape))
        raise TopographyError(
            f"{found.source}: holds no heights, an array of {shape}: an empty file, or the wrong part of one?"
        )
    if size is not None:
        if not isinstance(size, Sequence) or not size:
            raise ArgumentError("size", size, "one length or two, in m")
        size = [number("size", length, above=0) for length in (size if len(size) == 1 else pair("size", size))]
    if unit is not None:
        number("unit", unit, above=0)
    faults, steps = list[str](), list[str]()
    if position_unit is not None:
        scale = number("position_unit", position_unit, above=0)
        if found.extent is None or found.size is not None or size is not None:
            why = "it has no positions" if found.extent is None else "its size is known without"
            faults.append(f"`unit` has two units, the first that of positions, but {why}: give one, of the heights")
        else:
            size = [scale * length for length in found.extent]
    for what, its, given in (("size", found.size, size), ("unit", found.unit, unit)):
        if its is None and given is None:
            faults.append(_missing(found, what))
        if its is not None and given is not None:
            said = " x ".join(units.readable(one, "length") for one in (its if isinstance(its, tuple) else (its,)))
            steps.append(f"the {what} that the file says, {said}, overruled")
            if not override:
                faults.append(
                    f"the file itself says the {what} of the map ({said}): leave out `{what}`, or overrule it "
                    "knowingly with `override_size`"
                )
    if faults:
        raise TopographyError("\n".join(f"{found.source}: {fault}" for fault in faults))
    lengths = tuple(size or found.size or ())
    if len(lengths) == 2 and found.heights.ndim == 1:
        raise TopographyError(f"{found.source}: a line scan has one length: one number in `size`")
    if len(lengths) == 1 and found.heights.ndim == 2:
        nx, ny = found.heights.shape
        lengths = (lengths[0], lengths[0] * ny / nx)
    heights = found.heights * (unit or found.unit or np.nan)
    its_periodic = found.periodic if periodic is None else periodic
    return found._replace(
        heights=heights, size=(lengths[0], lengths[-1]), unit=1.0, periodic=its_periodic, steps=(*found.steps, *steps)
    )


def _missing(found: RawMap, what: str) -> str:
    """Message about a size or unit that the file lacks and that must be given."""
    if what == "size" and found.extent is not None:
        return (
            f"{found.of} does not say the unit of its positions: give the units of both, positions and heights, as "
            "`unit` um,nm, or `size`"
        )
    return f"{found.of} does not say the {what} of the map: give `{what}`; nothing is assumed"


def _whole(found: RawMap, corners: tuple[float, float, float, float] | None, fill: float) -> Topography:
    """The part of the map to use, with its holes filled."""
    number("fill", fill, least=0, most=0.5)
    (lx, ly), steps = found.size or (np.nan, np.nan), list(found.steps)
    if found.heights.ndim == 1:
        if corners is not None:
            raise TopographyError(f"{found.source}: a line scan cannot be cut: leave out `crop`")
        heights, filled = _without_holes(found.heights, fill, found.source)
        of_line = tuple(steps + filled)
        return isotropic_surface(heights, lx, periodic=found.periodic, source=found.source, steps=of_line)
    if found.heights.ndim != 2:
        return Topography(found.heights, (lx, ly), found.periodic, found.source)
    heights, periodic = found.heights, found.periodic
    if corners is not None:
        pixel = lx / heights.shape[0], ly / heights.shape[1]
        try:
            heights = crop(heights, (lx, ly), corners)
        except ValueError as error:
            raise TopographyError(f"{found.source}: {error}") from error
        if min(heights.shape) < FEWEST:
            points = " x ".join(map(str, heights.shape))
            msg = f"{found.source}: `crop` leaves {points} points: a map has at least {FEWEST} points along each side"
            raise TopographyError(msg)
        lx, ly = heights.shape[0] * pixel[0], heights.shape[1] * pixel[1]
        x0, x1, y0, y1 = (units.readable(edge, "length", 3) for edge in corners)
        steps.append(f"cut to {x0} <= x < {x1}, {y0} <= y < {y1}")
        periodic = False
    heights, filled = _without_holes(heights, fill, found.source)
    return Topography(heights, (lx, ly), periodic, found.source, (*steps, *filled))


def _without_holes(heights: Real, fill: float, source: str) -> tuple[Real, list[str]]:
    """Heights with missing ones filled, up to 1 % or the share given, and the step taken."""
    holes = ~np.isfinite(heights)
    missing = float(holes.mean())
    if not missing or holes.all():
        return heights, []
    if missing > (fill or FEW_HOLES):
        found = f"{source}: {np.count_nonzero(holes)} of {holes.size} heights are missing, {100 * missing:.3g} %"
        if fill:
            raise TopographyError(f"{found}: `fill` allows {100 * fill:.3g} %")
        enough = min(np.ceil(100 * missing), 50)
        part = "" if heights.ndim == 1 else ", or `crop` cuts a part without"
        raise TopographyError(f"{found}: `fill` {enough:.0f}% fills them{part}")
    if heights.ndim == 1:
        points = np.arange(heights.size)
        whole = np.interp(points, points[~holes], heights[~holes])
        return whole, [f"{100 * missing:.2g} % of the points, missing, filled by straight lines"]
    return harmonic(heights, holes), [f"{100 * missing:.2g} % of the points, missing, filled harmonically"]
