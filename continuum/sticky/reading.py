"""Reading topographies: from plain arrays, whose units must be given, and from the files of instruments.

Plain arrays (npy, text, HDF5) carry no units: size and unit of the heights must be given.  The formats of instruments,
and the containers of contact.engineering, are read by SurfaceTopography (``pip install 'stickiness[topography]'``),
which knows their units.
"""

from __future__ import annotations

import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from importlib import util
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from continuum import units
from continuum.files.arrays import HDF5_SUFFIXES, read_numbers
from continuum.model.grid import Real
from continuum.sticky.joined import joined
from continuum.sticky.linescan import isotropic_surface
from continuum.sticky.mending import crop, harmonic
from continuum.sticky.topography import Topography, TopographyError

__all__ = ["ALL", "measurements", "read", "read_all", "share"]

ALL = "all"
"""Instead of the name of a part: all measurements of a container, joined."""
_PLAIN = frozenset({".npy", ".txt", ".csv", ".dat", *HDF5_SUFFIXES})


def read(
    path: Path,
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
    fill : largest share of missing heights that is filled (:func:`continuum.sticky.mending.harmonic`).
    override : whether a given size or unit overrules what the file says.

    Raises
    ------
    TopographyError
        If there is no map to be had, or its units are missing or given twice.
    """
    if not path.is_file():
        msg = f"{path}: there is no such file"
        raise TopographyError(msg)
    if part == ALL and _is_container(path):
        one = partial(
            read, path, size=size, unit=unit, periodic=periodic, corners=corners, fill=fill, override=override
        )
        parts = [one(part=name) for name in measurements(path)]
        return joined(parts, f"{path.name}: all measurements")
    suffix, told = path.suffix.lower(), dataset or size is not None or unit is not None
    # Other than npy, plain files may name their units in a header, which only SurfaceTopography reads.
    if suffix == ".npy" or (suffix in _PLAIN and (told or util.find_spec("SurfaceTopography") is None)):
        try:
            heights = read_numbers(path, dataset)
        except (ValueError, OSError) as error:
            raise TopographyError(str(error)) from error
        single = heights.ndim == 2 and min(heights.shape) == 1
        found = _Map(heights.ravel() if single else heights, path.name)
    else:
        found = _from_instrument(path, part)
    return _whole(_with_units(found, size, unit, periodic, override), corners, fill)


def measurements(path: Path) -> tuple[str, ...]:
    """Names of the measurements of a container; none of any other file.

    Raises
    ------
    TopographyError
        If it is a container that cannot be read.
    """
    if not (path.is_file() and _is_container(path)):
        return ()
    _need_reader(path)
    with warnings.catch_warnings(), ExitStack() as stack:
        warnings.simplefilter("ignore")
        try:
            return tuple(_maps(path, stack))
        except Exception as error:
            msg = f"{path}: SurfaceTopography cannot read it: {error or type(error).__name__}"
            raise TopographyError(msg) from error


def read_all(
    paths: Sequence[Path],
    *,
    size: Sequence[str] | None = None,
    unit: Sequence[str] | None = None,
    dataset: Sequence[str] | None = None,
    part: Sequence[str] | None = None,
    periodic: bool = False,
    crop: str | None = None,
    fill: str | None = None,
    override_size: bool = False,
) -> list[Topography]:
    """Topographies of one or two files, with sizes and units as text: one for all files, or one for each.

    Parameters
    ----------
    size : like ``"10um"`` or ``"10um,12um"``; ``"-"``: as the file says.
    unit : of the heights, like ``"nm"``; ``"-"``: as the file says.
    dataset, part : see :func:`read`.
    periodic : whether all are; else as the files say.
    crop : part of each map that counts, like ``"1um,9um,1um,9um"``: from x0 to x1 and from y0 to y1.
    fill : largest share of heights that is filled where they are missing, like ``"5%"``.
    override_size : whether a given size or unit overrules what a file says.

    Raises
    ------
    TopographyError
        If an option has no meaning; or see :func:`read`.  All files are looked at before.
    """
    if len(paths) > 2:
        msg = f"a contact has one or two rough surfaces, got {len(paths)} files"
        raise TopographyError(msg)

    def of(values: Sequence[str] | None, i: int) -> str | None:
        if not values:
            return None
        if len(values) not in (1, len(paths)):
            msg = f"{len(values)} values for {len(paths)} files: give one for all, or one for each"
            raise TopographyError(msg)
        value = values[i if len(values) > 1 else 0]
        return None if value == "-" else value

    corners, limit = _corners(crop), 0.0 if fill is None else share(fill)
    found, faults = [], []
    for i, path in enumerate(paths):
        try:
            sizes, scale = _given(path, of(size, i), of(unit, i))
            found.append(
                read(
                    path, size=sizes, unit=scale, periodic=True if periodic else None, dataset=of(dataset, i),
                    part=of(part, i), corners=corners, fill=limit, override=override_size,
                )
            )  # fmt: skip
        except TopographyError as error:
            faults.append(str(error))
    if faults:
        raise TopographyError("\n".join(dict.fromkeys(faults)))
    return found


def _given(path: Path, lengths: str | None, name: str | None) -> tuple[list[float] | None, float | None]:
    """Size and unit as numbers."""
    try:
        sizes = None if lengths is None else [units.parse(text, "length") for text in lengths.split(",")]
        scale = None if name is None else units.unit_size(name, "length")
    except ValueError as error:
        msg = f"{path.name}: {error}"
        raise TopographyError(msg) from error
    if sizes is not None and len(sizes) > 2:
        msg = f"{path.name}: a map has one or two lengths, got {lengths!r}"
        raise TopographyError(msg)
    return sizes, scale


def share(text: str) -> float:
    """A share of the points, as "5%" or 0.05.

    Raises
    ------
    TopographyError
        If it is none between 0 and 1/2.
    """
    try:
        value = float(text.strip().removesuffix("%")) / (100 if text.strip().endswith("%") else 1)
    except ValueError:
        value = -1.0
    if not 0 < value <= 0.5:
        msg = f"--fill {text!r}: the largest share of points that may be filled, like 5%, at most 50%"
        raise TopographyError(msg)
    return value


def _corners(text: str | None) -> tuple[float, float, float, float] | None:
    if text is None:
        return None
    parts = text.split(",")
    try:
        # An edge of the map is at zero, which has no unit.
        a, b, c, d = (0.0 if _is_zero(one) else units.parse(one, "length") for one in parts)
    except ValueError as error:
        why = error if len(parts) == 4 else f"{len(parts)} lengths"
        msg = f"--crop {text!r}: four lengths, x0,x1,y0,y1, as 1um,9um,1um,9um ({why})"
        raise TopographyError(msg) from error
    return a, b, c, d


def _is_zero(text: str) -> bool:
    digits = re.fullmatch(r"\s*([\d.]+)\s*\D*", text)
    return digits is not None and digits[1].strip("0.") == ""


class _Map(NamedTuple):
    """Heights as a file has them, and what it says of them."""

    heights: Real
    source: str
    size: tuple[float, ...] | None = None
    """In m."""
    unit: float | None = None
    """Of the heights, in m."""
    periodic: bool = False
    steps: tuple[str, ...] = ()
    """What was chosen for it, in words."""


def _with_units(
    found: _Map, size: Sequence[float] | None, unit: float | None, periodic: bool | None, override: bool = False
) -> _Map:
    """Heights in m: what the file says, or what was given; neither both, unless it overrules, nor none."""
    faults, steps = [], []
    for what, its, given in (("size", found.size, size), ("unit", found.unit, unit)):
        if its is None and given is None:
            faults.append(f"the file does not say the {what} of the map: give --{what}; nothing is assumed")
        if its is not None and given is not None:
            said = " x ".join(units.readable(one, "length") for one in (its if isinstance(its, tuple) else (its,)))
            steps.append(f"the {what} that the file says, {said}, overruled")
            if not override:
                faults.append(
                    f"the file itself says the {what} of the map ({said}): leave out --{what}, or overrule it "
                    "knowingly with --override-size"
                )
    if faults:
        raise TopographyError("\n".join(f"{found.source}: {fault}" for fault in faults))
    lengths = tuple(size or found.size or ())
    if len(lengths) == 2 and found.heights.ndim == 1:
        msg = f"{found.source}: a line scan has one length: --size LX"
        raise TopographyError(msg)
    if len(lengths) == 1 and found.heights.ndim == 2:
        nx, ny = found.heights.shape
        lengths = (lengths[0], lengths[0] * ny / nx)
    heights = found.heights * (unit or found.unit or np.nan)
    its_periodic = found.periodic if periodic is None else periodic
    return _Map(heights, found.source, (lengths[0], lengths[-1]), 1.0, its_periodic, (*found.steps, *steps))


def _whole(found: _Map, corners: tuple[float, float, float, float] | None, fill: float) -> Topography:
    """The part that counts, without holes."""
    heights, (lx, ly), steps = found.heights, _two(found.size), list(found.steps)
    if heights.ndim == 1:
        if corners is not None or fill:
            msg = f"{found.source}: a line scan can be neither cut nor filled"
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
            msg = f"{found.source}: {error}"
            raise TopographyError(msg) from error
        lx, ly = heights.shape[0] * pixel[0], heights.shape[1] * pixel[1]
        x0, x1, y0, y1 = (units.readable(edge, "length", 3) for edge in corners)
        steps.append(f"cut to {x0} <= x < {x1}, {y0} <= y < {y1}")
        periodic = False
    holes = ~np.isfinite(heights)
    missing = float(holes.mean()) if holes.size else 0.0
    if missing > fill > 0:
        msg = f"{found.source}: {100 * missing:.2g} % of the heights are missing, --fill allows {100 * fill:.2g} %"
        raise TopographyError(msg)
    if missing and fill:
        heights = harmonic(heights, holes)
        steps.append(f"{100 * missing:.2g} % of the points, missing, filled harmonically")
    return Topography(heights, (lx, ly), periodic, found.source, tuple(steps))


def _two(size: tuple[float, ...] | None) -> tuple[float, float]:
    return (np.nan, np.nan) if size is None else (size[0], size[-1])


def _from_instrument(path: Path, part: str | None) -> _Map:
    """A map by SurfaceTopography: heights as they are in the file, size and unit in m if it says them."""
    _need_reader(path)
    with warnings.catch_warnings(), ExitStack() as stack:
        warnings.simplefilter("ignore")  # of imports, and of formats that are guessed
        try:
            maps = _maps(path, stack)
            chosen = [name for name in maps if part is None or name == part]
            if len(chosen) == 1:
                return maps[chosen[0]]()
            if chosen and part is None and not _is_container(path):
                # The first height channel is what an instrument shows; the others are other directions of the scan.
                others = ", ".join(map(repr, chosen[1:]))
                return maps[chosen[0]]()._replace(steps=(f"channel {chosen[0]!r} taken, not {others} (--part)",))
        except Exception as error:  # vendors' formats fail in all ways
            unknown = type(error).__name__ == "CannotDetectFileFormat"
            reason = "none of its formats" if unknown else str(error) or type(error).__name__
            msg = f"{path}: SurfaceTopography cannot read it: {reason}"
            raise TopographyError(msg) from error
    names = ", ".join(map(repr, maps)) or "none"
    none = f"holds no map named {part!r}" if part else "holds no map"
    several = f"holds {len(chosen)} maps, choose one with --part, or --part all"
    msg = f"{path}: {several if chosen else none}; maps: {names}"
    raise TopographyError(msg)


def _need_reader(path: Path) -> None:
    if util.find_spec("SurfaceTopography") is None:
        msg = (
            f"{path}: to read this format install SurfaceTopography (pip install 'stickiness[topography]'), "
            "or save the map as .npy or text"
        )
        raise TopographyError(msg)


def _is_container(path: Path) -> bool:
    return zipfile.is_zipfile(path) and "meta.yml" in zipfile.ZipFile(path).namelist()


def _maps(path: Path, stack: ExitStack) -> dict[str, Callable[[], _Map]]:
    """The maps of heights in a file, by name."""
    if _is_container(path):
        from SurfaceTopography.Container.IO import read_container

        members = [member for surface in read_container(str(path)) for member in surface]
        names = [str(member.info.get("name", i)) for i, member in enumerate(members)]
        return {name: partial(_values, path, name, member) for name, member in zip(names, members, strict=True)}
    from SurfaceTopography import open_topography

    reader = open_topography(str(path))
    stack.callback(reader.close)
    return {c.channel_id: partial(_load, path, reader, c) for c in reader.height_channels}


def _load(path: Path, reader: Any, channel: Any) -> _Map:
    """A channel of a file; a size or unit that it does not say is put in as 1 and left out afterwards."""
    size, unit = channel.physical_sizes, channel.unit
    given: dict[str, Any] = {} if size is not None else {"physical_sizes": (1.0,) * channel.dim}
    given |= {} if unit is not None else {"unit": "m"}
    found = _values(path, None, reader.topography(channel_index=channel.index, **given))
    scale = None if unit is None else found.unit
    return found._replace(size=None if size is None or scale is None else found.size, unit=scale)


def _values(path: Path, name: str | None, measured: Any) -> _Map:
    """What SurfaceTopography holds, holes as NaN."""
    scale = units.unit_size(str(measured.unit), "length")
    lengths = tuple(float(length) * scale for length in measured.physical_sizes)
    source = path.name if name is None else f"{path.name}: {name}"
    if not measured.is_uniform:
        where, heights = (np.asarray(values, dtype=np.float64) for values in measured.positions_and_heights())
        even = np.linspace(where[0], where[-1], where.size)
        steps = ("resampled to points an equal distance apart",)
        return _Map(np.interp(even, where, heights), source, lengths, scale, bool(measured.is_periodic), steps)
    heights = np.ma.filled(np.ma.asarray(measured.heights(), dtype=np.float64), np.nan)
    return _Map(heights, source, lengths, scale, bool(measured.is_periodic))
