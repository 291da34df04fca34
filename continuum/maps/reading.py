"""Read topographies from plain arrays, whose units must be given, and from files of instruments.

Arrays in memory or in files (npy, text, HDF5) need size and unit of the heights, where no header and no attribute says
them (:mod:`continuum.store.heights`); files of instruments say them (:mod:`continuum.maps.instruments`).
Arguments with units are parsed by :mod:`continuum.maps.map`.  Files that cannot be read raise
TopographyError, arguments of another type ArgumentError.
"""

import os
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from continuum.inputs import possible, units
from continuum.inputs.arguments import ArgumentError, file_name, flag, number, pair
from continuum.maps.instruments import ALL, from_instrument, is_container, is_known, measurements
from continuum.maps.map import (
    FEWEST,
    Topography,
    TopographyError,
    as_fault,
    corners_of,
    heights_of,
    share,
    sizes_of,
    text_for,
    texts_of,
    units_of,
    voids_of,
)
from continuum.maps.mending import crop, detrend, harmonic
from continuum.maps.spectra import isotropic_surface, joined
from continuum.model.fourier import Real
from continuum.store.heights import (
    HDF5_SUFFIXES,
    NO_HEIGHT,
    RawMap,
    data_of,
    of_data,
    read_map,
    stands_for_nothing,
    without_voids,
)
from continuum.store.text import NoTableError

_TEXT = frozenset({".txt", ".csv", ".dat", ".xyz", ".asc"})
_NETCDF = ".nc"
FEW_HOLES = 0.01
"""Largest share of missing heights that is filled by default."""
_SAME = 1e-3
"""Sizes that differ by less than this part are the same: some are given to three digits."""


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
    void: Sequence[float] = (),
    override: bool = False,
    source: str = "array",
) -> Topography:
    """A topography from a file, or from an array in memory.

    Parameters
    ----------
    heights : name of a file, npy, text or HDF5, or any format of SurfaceTopography, if that is installed.  Or an
        array, positive out of the body, shape (nx, ny), or one profile; masked points are missing.  Two columns are
        positions and heights of a profile, three those of a map.
    size : (Lx, Ly) in m, or (Lx,) for square pixels; only if the file does not say.  x is along a line of text, and
        along the first index of an array.
    unit : unit of the heights, in m; only if the file does not say.
    position_unit : unit of the positions, in m, if a file has columns of positions and heights; instead of a size.
    periodic : whether the map continues at its edges; None takes what the file says, and else no.
    dataset : dataset of an HDF5 file, if it has several.
    part : name of a map in a container, or of a channel, if there are several; :data:`ALL` joins all of a container.
    corners : (x0, x1, y0, y1) of the part to use, in m; None for all.
    fill : largest share of missing heights that is filled (:func:`continuum.maps.mending.harmonic`); 0 for
        :data:`FEW_HOLES`.
    void : numbers, as they stand in the file, that stand for missing heights; NaN if all others are heights.
    override : whether a given size or unit overrules what the file says.
    source : name of an array in messages and on the page.
    """
    void = voids_of(void)
    if periodic is not None:
        flag("periodic", periodic)
    if not isinstance(heights, str | os.PathLike):
        _whole_array(source, dataset=dataset, part=part)
        with as_fault():
            found = of_data(data_of(heights_of("heights", heights), heights), source, of="the array")
    else:
        path = file_name("heights", heights)
        if not path.is_file():
            raise TopographyError(f"{path}: {'a folder, not a file' if path.is_dir() else 'there is no such file'}")
        if path.stat().st_size == 0:
            raise TopographyError(f"{path}: the file is empty")
        if part == ALL and is_container(path):
            one = partial(
                read_topography, path, size=size, unit=unit, periodic=periodic, corners=corners, fill=fill, void=void,
                override=override,
            )  # fmt: skip
            parts = [one(part=name) for name in measurements(path)]
            return joined(parts, f"{path.name}: all measurements")
        found = _raw(path, dataset, part)
    known = _with_units(_measured(found, void), size, unit, position_unit, periodic, override)
    return _possible(_whole(known, corners, fill))


def _raw(path: Path, dataset: str | None, part: str | None) -> RawMap:
    """Read a file by the reader for its format.

    Text whose header has keys and values that are not understood is shown to SurfaceTopography, which knows more.
    """
    suffix = path.suffix.lower()
    plain = suffix in HDF5_SUFFIXES | {".npy"}
    others = not plain and suffix not in _TEXT
    if (others or (suffix == _NETCDF and dataset is None)) and is_known(path):
        return from_instrument(path, part)
    try:
        found = read_map(path, dataset)
    except NoTableError as error:  # perhaps of another format
        if suffix in _TEXT and not is_known(path):  # of text in general SurfaceTopography drops what it cannot read
            raise TopographyError(str(error)) from error
        return from_instrument(path, part)
    except (ValueError, OSError) as error:
        raise TopographyError(str(error)) from error
    if found.unread:
        # Another reader is believed only if it finds as many heights, and a size or unit that ours did not.
        with suppress(TopographyError):
            theirs = from_instrument(path, part)
            if theirs.heights.shape == found.heights.shape and (theirs.size or theirs.unit):
                return theirs
    _whole_array(path.name, part=part, dataset=None if suffix in HDF5_SUFFIXES else dataset)
    return found


def _measured(found: RawMap, void: Sequence[float]) -> RawMap:
    """A map without the values that stand for missing heights; raises TopographyError if one is to be asked for."""
    heights, steps = without_voids(found.heights, void), found.steps
    gone = np.count_nonzero(np.isnan(heights)) - np.count_nonzero(np.isnan(found.heights))
    if gone:
        steps += (f"{gone} points of the value {' or '.join(f'{one:.10g}' for one in void)} taken as missing",)
    largest = np.abs(heights) > NO_HEIGHT  # False of NaN
    if largest.any() and not largest.all():
        heights, steps = (
            np.where(largest, np.nan, heights),
            (*steps, f"{largest.sum()} numbers beyond 1e25 taken as missing"),
        )
    asked = None if np.isnan(void).any() else stands_for_nothing(heights)
    if asked:
        value, count = asked
        raise TopographyError(
            f"{found.source}: {count} of {heights.size} points have the value {value:.10g}, far from all others: "
            f"missing? then `void` {value:.10g}; if they are heights, `void` nan"
        )
    return found._replace(heights=heights, steps=steps)


def _possible(topography: Topography) -> Topography:
    """The topography, unless its pixels or heights are in another unit."""
    looked_at: tuple[tuple[str, float, possible.Kind, str, str], ...] = (
        ("pixels", min(topography.grid.spacing), "pixel", "`size`", ", or is that of one pixel"),
        (
            "an rms height",
            float(detrend(topography).heights.std()),
            "height",
            "`unit`",
            " (m, if the heights are in m)",
        ),
    )
    for what, value, kind, given, usual in looked_at:
        if why := possible.fault(value, kind):
            other = f"larger{usual}" if value < possible.POSSIBLE[kind].least else "smaller"
            raise TopographyError(f"{topography.source}: {what} of {value:.2g} m: {why}: {given} is probably {other}")
    return topography


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
    void: str | float | Sequence[str | float] = (),
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
    corners, limit, voids = corners_of(crop), share(fill), voids_of(void)
    always, override = flag("periodic", periodic), flag("override_size", override_size)
    found, faults = [], []
    for i, one in enumerate(maps):
        path = file_name("maps", one) if isinstance(one, str | os.PathLike) else None
        source = path.name if path is not None else "array" if len(maps) == 1 else f"array {i + 1}"
        text = {name: text_for(values, i) for name, values in given.items()}
        try:
            heights_unit, position_unit = units_of(source, text["unit"])
            size_of = sizes_of(source, text["size"])
            if path is None and not heights_of("maps", one).ndim:
                raise ArgumentError("maps", one, "names of files, or arrays of heights")
            found.append(read_topography(
                one if path is None else path, size=size_of, unit=heights_unit, position_unit=position_unit,
                periodic=always or None, dataset=text["dataset"], part=text["part"], corners=corners, fill=limit,
                void=voids, override=override, source=source,
            ))  # fmt: skip
        except TopographyError as error:
            faults.append(str(error))
    if faults:
        raise TopographyError("\n".join(dict.fromkeys(faults)))  # the same fault of two maps once
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
            # Where the file says another unit, the fault below tells to leave `unit` out, which mends both.
            if override or unit is None or found.unit is None or _agree(found.unit, unit):
                faults.append(f"`unit` has two units, the first that of positions, but {why}: give one, of the heights")
        else:
            # Positions without a unit: with it their extent is the size.
            size = [scale * length for length in found.extent]
    for what, its, given in (("size", found.size, size), ("unit", found.unit, unit)):
        if its is None and given is None:
            faults.append(_missing(found, what))
        if its is not None and given is not None and not _agree(its, given):
            said = " x ".join(units.readable(one, "length") for one in (its if isinstance(its, tuple) else (its,)))
            steps.append(f"the {what} that {found.of} says, {said}, overruled")
            if not override:
                faults.append(
                    f"{found.of} itself says the {what} of the map ({said}): leave out `{what}`, or overrule it "
                    "knowingly with `override_size`"
                )
    if faults:
        raise TopographyError("\n".join(f"{found.source}: {fault}" for fault in faults))
    if not override:  # of two that agree, to rounding, that of the file is taken
        size, unit = found.size or size, found.unit or unit
    lengths = tuple(size or found.size or ())
    if len(lengths) == 2 and found.heights.ndim == 1:
        raise TopographyError(f"{found.source}: a line scan has one length: one number in `size`")
    if len(lengths) == 1 and found.heights.ndim == 2:
        nx, ny = found.heights.shape  # one length: the pixels are square
        lengths = (lengths[0], lengths[0] * ny / nx)
    # Lengths that the file gives are in its order; only typed ones may have been exchanged.
    steps += _other_order(found.heights.shape, lengths) if found.size is None and position_unit is None else ()
    heights = found.heights * (unit or found.unit or np.nan)
    its_periodic = found.periodic if periodic is None else periodic
    return found._replace(
        heights=heights, size=(lengths[0], lengths[-1]), unit=1.0, periodic=its_periodic, steps=(*found.steps, *steps)
    )


def _agree(its: float | Sequence[float], given: float | Sequence[float]) -> bool:
    """True if a size or unit agrees with the file, to the digits that are usually given."""
    one, other = np.atleast_1d(its), np.atleast_1d(given)
    return bool(np.allclose(one[: other.size], other, rtol=_SAME, atol=0))


def _other_order(points: tuple[int, ...], lengths: tuple[float, ...]) -> tuple[str, ...]:
    """Message if pixels would be square after exchanging the two lengths."""
    if len(points) != 2:
        return ()
    given, exchanged = (np.divide(one, points) for one in (lengths, lengths[::-1]))
    if _agree(*given) or not _agree(*exchanged):
        return ()
    pixel = " x ".join(units.readable(float(one), "length", 3) for one in given)
    said = ",".join(units.readable(one, "length", 6).replace(" ", "") for one in lengths[::-1])
    return (f"pixels of {pixel}; they would be square with the size {said}: x is along a line of text",)


def _missing(found: RawMap, what: str) -> str:
    """Message about a size or unit that the file lacks and that must be given."""
    if what == "size" and found.extent is not None:
        return (
            f"{found.of} does not say the unit of its positions: give the units of both, positions and heights, as "
            "`unit` um,nm, or `size`"
        )
    if found.unread:
        return f"the {what} of the map is not found in the header of {found.of}, which is not understood: give `{what}`"
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
        with as_fault(f"{found.source}: "):
            heights = crop(heights, (lx, ly), corners)
        if min(heights.shape) < FEWEST:
            points = " x ".join(map(str, heights.shape))
            msg = f"{found.source}: `crop` leaves {points} points: a map has at least {FEWEST} points along each side"
            raise TopographyError(msg)
        lx, ly = heights.shape[0] * pixel[0], heights.shape[1] * pixel[1]
        x0, x1, y0, y1 = (units.readable(edge, "length", 3) for edge in corners)
        steps.append(f"cut to {x0} <= x < {x1}, {y0} <= y < {y1}")
        periodic = False  # a part of a periodic map has other heights beyond its edges than its images
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
        enough = min(np.ceil(100 * missing), 50)  # the most that `fill` takes
        part = "" if heights.ndim == 1 else ", or `crop` cuts out a part that has all"
        raise TopographyError(f"{found}: `fill` {enough:.0f}% fills them{part}")
    if heights.ndim == 1:
        points = np.arange(heights.size)
        whole = np.interp(points, points[~holes], heights[~holes])
        return whole, [f"{100 * missing:.2g} % of the points, missing, filled by straight lines"]
    return harmonic(heights, holes), [f"{100 * missing:.2g} % of the points, missing, filled harmonically"]
