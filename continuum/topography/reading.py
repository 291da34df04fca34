"""Reading topographies: from plain arrays, whose units must be given, and from the files of instruments.

Arrays in memory or in files (npy, text, HDF5) carry no units: size and unit of the heights must be given.  What an
instrument wrote names them (:mod:`continuum.topography.instruments`).  Sizes, units, shares and parts of a map that a
person writes as text are read as numbers in m; what a message names in backticks is an argument, which the command
writes as its option.  What cannot be read raises TopographyError, and what is of another type ArgumentError.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from functools import partial
from importlib import util
from numbers import Real as Number
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from continuum import units
from continuum.arguments import ArgumentError, file_name, flag, instance, number, pair, texts
from continuum.files.arrays import HDF5_SUFFIXES, read_numbers
from continuum.model.fourier import Real
from continuum.topography.instruments import ALL, RawMap, from_instrument, is_container, measurements
from continuum.topography.map import FEWEST, Topography, TopographyError, heights_of
from continuum.topography.mending import crop, harmonic
from continuum.topography.spectra import isotropic_surface, joined

_ZERO = re.compile(r"\s*[0.]+\s*\D*")
"""An edge of a map at zero, which needs no unit."""
_PLAIN = frozenset({".npy", ".txt", ".csv", ".dat", *HDF5_SUFFIXES})


def read_topography(
    path: str | Path,
    *,
    size: Sequence[float] | None = None,
    unit: float | None = None,
    periodic: bool | None = None,
    dataset: str | None = None,
    part: str | None = None,
    corners: tuple[float, float, float, float] | None = None,
    fill: float = 0.0,
    override: bool = False,
) -> Topography:
    """A topography from a file.

    Parameters
    ----------
    path : npy, text or HDF5; or any format of SurfaceTopography, if that is installed.
    size : (Lx, Ly) in m, along the first index and the second, or (Lx,) for square pixels; only if the file does not
        say.
    unit : of the heights, in m; only if the file does not say.
    periodic : whether the map continues at its edges; None believes the file, else no.
    dataset : in an HDF5 file.
    part : name of a map in a container, or of a channel, if there are several; :data:`ALL` joins those of a container.
    corners : (x0, x1, y0, y1) of the part that counts, in m; None for all.
    fill : largest share of missing heights that is filled (:func:`continuum.topography.mending.harmonic`).
    override : whether a given size or unit overrules what the file says.
    """
    path = file_name("path", path)
    if not path.is_file():
        raise TopographyError(f"{path}: {'a folder, and no file' if path.is_dir() else 'there is no such file'}")
    if path.stat().st_size == 0:
        raise TopographyError(f"{path}: the file is empty")
    if part == ALL and is_container(path):
        one = partial(
            read_topography, path, size=size, unit=unit, periodic=periodic, corners=corners, fill=fill,
            override=override,
        )  # fmt: skip
        parts = [one(part=name) for name in measurements(path)]
        return joined(parts, f"{path.name}: all measurements")
    suffix, told = path.suffix.lower(), dataset or size is not None or unit is not None
    # Other than npy, plain files may name their units in a header, which only SurfaceTopography reads.
    if suffix == ".npy" or (suffix in _PLAIN and (told or util.find_spec("SurfaceTopography") is None)):
        _whole_array(path.name, part=part, dataset=None if suffix in HDF5_SUFFIXES else dataset)
        try:
            found = _plain(read_numbers(path, dataset), path.name)
        except (ValueError, OSError) as error:
            raise TopographyError(str(error)) from error
    else:
        found = from_instrument(path, part)
    return _whole(_with_units(found, size, unit, periodic, override), corners, fill)


def from_array(
    heights: ArrayLike,
    *,
    size: Sequence[float] | None = None,
    unit: float | None = None,
    periodic: bool = False,
    corners: tuple[float, float, float, float] | None = None,
    fill: float = 0.0,
    source: str = "array",
) -> Topography:
    """A topography from an array in memory, as :func:`read_topography` makes it from a file.

    Parameters
    ----------
    heights : out of the body, shape (nx, ny), or one profile; a masked point is a missing one.
    size, unit : as in :func:`read_topography`; both are needed.
    periodic, corners, fill : as in :func:`read_topography`.
    source : what it is called in messages and on the page.
    """
    found = _plain(heights_of("heights", heights), source)._replace(of="an array")
    return _whole(_with_units(found, size, unit, flag("periodic", periodic)), corners, fill)


def _plain(heights: Real, source: str) -> RawMap:
    """An array without units; one row or one column is a line scan."""
    single = heights.ndim == 2 and min(heights.shape) == 1
    return RawMap(heights.ravel() if single else heights, source)


def read_all(
    maps: Sequence[str | Path | ArrayLike],
    *,
    size: str | Sequence[str] | None = None,
    unit: str | Sequence[str] | None = None,
    dataset: str | Sequence[str] | None = None,
    part: str | Sequence[str] | None = None,
    periodic: bool = False,
    crop: str | None = None,
    fill: str | float | None = None,
    override_size: bool = False,
) -> list[Topography]:
    """One or two topographies, from files or arrays, with sizes and units as text: one for all, or one for each.

    All maps are looked at before one is refused.

    Parameters
    ----------
    maps : names of files, or arrays of heights whose masked points are missing.
    size : like ``"10um"`` or ``"10um,12um"``; ``"-"``: as the file says.
    unit : of the heights, like ``"nm"``; ``"-"``: as the file says.
    dataset, part : see :func:`read_topography`.
    periodic : whether all are; else as the files say.
    crop : part of each map that counts, like ``"1um,9um,1um,9um"``: from x0 to x1 and from y0 to y1.
    fill : largest share of heights that is filled where they are missing, like ``"5%"`` or 0.05.
    override_size : whether a given size or unit overrules what a file says.
    """
    if not 1 <= len(maps) <= 2:
        raise TopographyError(f"maps: a contact has one or two rough surfaces, got {len(maps)}")
    given = _given(len(maps), size=size, unit=unit, dataset=dataset, part=part)
    part_of_all: dict[str, Any] = {"corners": _corners(crop), "fill": share(fill)}
    always, override = flag("periodic", periodic), flag("override_size", override_size)
    found, faults = [], []
    for i, one in enumerate(maps):
        path = file_name("maps", one) if isinstance(one, str | os.PathLike) else None
        source = path.name if path is not None else "array" if len(maps) == 1 else f"array {i + 1}"
        text = {name: _each(values, i) for name, values in given.items()}
        try:
            of: dict[str, Any] = {"size": _sizes(source, text["size"]), "unit": _length_unit(source, text["unit"])}
            of |= part_of_all
            if path is not None:
                of |= {"dataset": text["dataset"], "part": text["part"], "override": override}
                found.append(read_topography(path, periodic=always or None, **of))
                continue
            heights = heights_of("maps", one)
            if not heights.ndim:
                raise ArgumentError("maps", one, "names of files, or arrays of heights")
            _whole_array(source, dataset=text["dataset"], part=text["part"])
            found.append(from_array(heights, periodic=always, source=source, **of))
        except TopographyError as error:
            faults.append(str(error))
    if faults:
        raise TopographyError("\n".join(dict.fromkeys(faults)))
    return found


def _given(count: int, **values: str | Sequence[str] | None) -> dict[str, tuple[str, ...]]:
    """What is given for the maps: nothing, one text for all, or one for each."""
    examples = {"size": '"10um" or "10um,12um"', "unit": '"nm"', "dataset": '"heights"', "part": '"Height"'}
    found = {name: texts(name, value, examples[name]) for name, value in values.items()}
    for name, several in found.items():
        if len(several) not in (0, 1, count):
            of = "one map" if count == 1 else f"{count} maps"
            msg = f"`{name}`: {len(several)} values for {of}: give one for all, or one for each"
            msg += '; the two lengths of a map are one text, "10um,12um"' if name == "size" else ""
            raise TopographyError(msg)
    return found


def _whole_array(source: str, **names: str | None) -> None:
    """Refuse to look for a dataset or a part in what is one array."""
    for name, value in names.items():
        if value is not None:
            raise TopographyError(f"{source}: `{name}` {value!r}: there is one array; leave it out")


def _each(values: Sequence[str], i: int) -> str | None:
    """What is given for a map, by one value for all or one for each; None as the file says."""
    value = values[i if len(values) > 1 else 0] if values else "-"
    return None if value == "-" else value


def _with_units(
    found: RawMap, size: Sequence[float] | None, unit: float | None, periodic: bool | None, override: bool = False
) -> RawMap:
    """Heights in m: what the file says, or what was given; neither both, unless it overrules, nor none."""
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
    faults, steps = [], []
    for what, its, given in (("size", found.size, size), ("unit", found.unit, unit)):
        if its is None and given is None:
            faults.append(f"{found.of} does not say the {what} of the map: give `{what}`; nothing is assumed")
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


def _whole(found: RawMap, corners: tuple[float, float, float, float] | None, fill: float) -> Topography:
    """The part that counts, without holes."""
    number("fill", fill, least=0, most=0.5)
    heights, (lx, ly), steps = found.heights, found.size or (np.nan, np.nan), list(found.steps)
    if heights.ndim == 1:
        if corners is not None or fill:
            msg = f"{found.source}: a line scan can be neither cut nor filled: leave out `crop` and `fill`"
            raise TopographyError(msg)
        return isotropic_surface(heights, lx, periodic=found.periodic, source=found.source, steps=found.steps)
    if heights.ndim != 2:
        return Topography(heights, (lx, ly), found.periodic, found.source)
    periodic = found.periodic
    if corners is not None:
        pixel = lx / heights.shape[0], ly / heights.shape[1]
        try:
            heights = crop(heights, (lx, ly), corners)
        except ValueError as error:
            raise TopographyError(f"{found.source}: {error}") from error
        if min(heights.shape) < FEWEST:
            points = " x ".join(map(str, heights.shape))
            msg = f"{found.source}: `crop` leaves {points} points: a map has two directions of at least {FEWEST} points"
            raise TopographyError(msg)
        lx, ly = heights.shape[0] * pixel[0], heights.shape[1] * pixel[1]
        x0, x1, y0, y1 = (units.readable(edge, "length", 3) for edge in corners)
        steps.append(f"cut to {x0} <= x < {x1}, {y0} <= y < {y1}")
        periodic = False
    holes = ~np.isfinite(heights)
    missing = float(holes.mean())
    if missing > fill > 0:
        msg = f"{found.source}: {100 * missing:.3g} % of the heights are missing, `fill` allows {100 * fill:.3g} %"
        raise TopographyError(msg)
    if missing and fill:
        heights = harmonic(heights, holes)
        steps.append(f"{100 * missing:.2g} % of the points, missing, filled harmonically")
    return Topography(heights, (lx, ly), periodic, found.source, tuple(steps))


def _sizes(source: str, text: str | None) -> tuple[float, ...] | None:
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


def _length_unit(source: str, name: str | None) -> float | None:
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


def _corners(crop: str | None) -> tuple[float, float, float, float] | None:
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
