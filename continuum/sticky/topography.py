"""Measured topographies: maps of heights with real units, checked, detrended, and said to be so.

Heights are in m and point out of the body, so that the summits that touch first are the highest points.  A map is a
:class:`Topography`; each step that changes one is written into its ``steps``.

Plain arrays (npy, text, HDF5) carry no units: size and unit of the heights must be given.  The formats of instruments,
and the containers of contact.engineering, are read by SurfaceTopography (``pip install 'stickiness[topography]'``),
which knows their units.
"""

from __future__ import annotations

import hashlib
import warnings
import zipfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from importlib import util
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from continuum import units
from continuum.files.arrays import HDF5_SUFFIXES, read_numbers
from continuum.model.grid import Grid, Real

__all__ = ["Detrending", "Topography", "TopographyError", "detrend", "mirror", "opposed", "read", "read_all"]

Detrending = Literal["plane", "none"]

FEWEST = 16
"""Points in each direction below which a map has no statistics."""
_PLAIN = frozenset({".npy", ".txt", ".csv", ".dat", *HDF5_SUFFIXES})
_FLAT = 1e-12
"""Heights this much smaller than the largest number of the file are rounding errors."""
_NOTHING = 1e-100
"""Heights whose squares, divided by pixels to the fourth power, would not be numbers."""


class TopographyError(ValueError):
    """A file holds no topography that can be used: the message says why, and what helps."""


@dataclass(frozen=True, eq=False)
class Topography:
    """A map of heights.

    Parameters
    ----------
    heights : in m, out of the body, shape (nx, ny).
    lengths : (Lx, Ly), physical size, in m; pixels need not be square.
    periodic : whether the map continues at its edges.
    source : where it comes from, in words.
    steps : what has been done to it, in words.

    Raises
    ------
    TopographyError
        If heights are missing, not finite, constant, or no map.
    """

    heights: Real = field(repr=False)
    lengths: tuple[float, float]
    periodic: bool = False
    source: str = "array"
    steps: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no map of heights."""
        heights = np.array(self.heights, dtype=np.float64)
        if heights.ndim != 2 or min(heights.shape) < FEWEST:
            shape = " x ".join(map(str, heights.shape))
            self._refuse(f"an array of {shape or 'one number'}: a map has two directions of at least {FEWEST} points")
        missing = np.count_nonzero(~np.isfinite(heights))
        if missing:
            self._refuse(
                f"{missing} of {heights.size} heights are missing or not finite: fill the holes, or cut a part "
                "without, where you know what was measured (Gwyddion does both)"
            )
        if not all(np.isfinite(length) and length > 0 for length in self.lengths):
            self._refuse(f"the size of a map is positive and finite, got {self.lengths} m")
        if np.ptp(heights) <= max(_FLAT * np.abs(heights).max(), _NOTHING):
            self._refuse("all heights are the same: not a measured surface, or the wrong channel of the file")
        heights.flags.writeable = False
        object.__setattr__(self, "heights", heights)

    def _refuse(self, why: str) -> None:
        msg = f"{self.source}: {why}"
        raise TopographyError(msg)

    @cached_property
    def grid(self) -> Grid:
        """The points of the map; lengths in m."""
        return Grid((self.heights.shape[0], self.heights.shape[1]), self.lengths)

    @property
    def digest(self) -> str:
        """SHA-256 of heights and size: what was analysed, whatever the file is called."""
        return hashlib.sha256(self.heights.tobytes() + np.array(self.lengths).tobytes()).hexdigest()

    def after(self, heights: Real, step: str, **changes: Any) -> Topography:
        """The map with other heights, and what was done."""
        return replace(self, heights=heights, steps=(*self.steps, step), **changes)


def detrend(topography: Topography, how: Detrending | None = None) -> Topography:
    """Take off the mean, or the plane of least squares: how a sample lies under the instrument is no roughness.

    Parameters
    ----------
    topography : as read.
    how : None takes off the plane, but of a periodic map, which no plane leaves periodic, the mean only.

    Raises
    ------
    TopographyError
        If nothing is left.
    """
    heights = topography.heights - topography.heights.mean()
    step = "mean height taken off"
    if how == "plane" or (how is None and not topography.periodic):
        tilt = []
        for axis, (n, length) in enumerate(zip(heights.shape, topography.lengths, strict=True)):
            # On a full rectangle the two slopes and the mean are independent.
            x = np.linspace(-0.5, 0.5, n) * (1 - 1 / n) * length
            along = heights.mean(axis=1 - axis)
            tilt.append(float(x @ along / (x @ x)))
            heights = heights - np.expand_dims(tilt[-1] * x, 1 - axis)
        step = f"mean plane taken off, of slopes {tilt[0]:.3g} and {tilt[1]:.3g}"
    if np.abs(heights).max() <= _FLAT * max(np.abs(topography.heights).max(), np.ptp(topography.heights)) * 1e2:
        msg = f"{topography.source}: the map is a plane: nothing is left when its plane is taken off"
        raise TopographyError(msg)
    return topography.after(heights, step)


def mirror(topography: Topography) -> Topography:
    """A periodic map of four times the area: the map, and its mirror images beside it.

    Continuous, unlike the map's own repetition, and without the loss of a window; slopes jump at the mirrors.
    """
    heights = topography.heights
    for axis in (0, 1):
        heights = np.concatenate([heights, np.flip(heights, axis)], axis)
    lengths = (2 * topography.lengths[0], 2 * topography.lengths[1])
    return topography.after(heights, "continued by its mirror images", lengths=lengths, periodic=True)


def opposed(first: Topography, second: Topography) -> Topography:
    """Two rough bodies face to face as one: the sum of the heights, the second one's turned over about the y axis.

    Maps of the same pixel are cut to their common part.

    Raises
    ------
    TopographyError
        If their pixels differ by more than one part in a million.
    """
    if not np.allclose(first.grid.spacing, second.grid.spacing, rtol=1e-6, atol=0):
        pixels = [" x ".join(units.readable(d, "length") for d in t.grid.spacing) for t in (first, second)]
        msg = (
            f"{first.source} and {second.source} have pixels of {pixels[0]} and {pixels[1]}: "
            "heights can be added only on the same points; resample one (statistics need no such thing)"
        )
        raise TopographyError(msg)
    nx, ny = np.minimum(first.heights.shape, second.heights.shape)
    same = first.heights.shape == second.heights.shape
    heights = first.heights[:nx, :ny] + second.heights[::-1][:nx, :ny]
    lengths = (float(nx * first.grid.spacing[0]), float(ny * first.grid.spacing[1]))
    return Topography(
        heights,
        lengths,
        first.periodic and second.periodic and same,
        f"{first.source} on {second.source}",
        (*first.steps, *second.steps, "heights added" if same else f"cut to {nx} x {ny} points, heights added"),
    )


def read(
    path: Path,
    *,
    size: Sequence[float] | None = None,
    unit: float | None = None,
    periodic: bool | None = None,
    dataset: str | None = None,
    part: str | None = None,
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
    part : name of a map in a container, or of a channel, if there are several.

    Raises
    ------
    TopographyError
        If there is no map to be had, or its units are missing or given twice.
    """
    if not path.is_file():
        msg = f"{path}: there is no such file"
        raise TopographyError(msg)
    suffix, told = path.suffix.lower(), dataset or size is not None or unit is not None
    # Other than npy, plain files may name their units in a header, which only SurfaceTopography reads.
    if suffix == ".npy" or (suffix in _PLAIN and (told or util.find_spec("SurfaceTopography") is None)):
        try:
            heights = read_numbers(path, dataset)
        except (ValueError, OSError) as error:
            raise TopographyError(str(error)) from error
        return _with_units(_Map(heights, path.name), size, unit, periodic)
    return _with_units(_from_instrument(path, part), size, unit, periodic)


def read_all(
    paths: Sequence[Path],
    *,
    size: Sequence[str] | None = None,
    unit: Sequence[str] | None = None,
    dataset: Sequence[str] | None = None,
    part: Sequence[str] | None = None,
    periodic: bool = False,
) -> list[Topography]:
    """Topographies of one or two files, with sizes and units as text: one for all files, or one for each.

    Parameters
    ----------
    size : like ``"10um"`` or ``"10um,12um"``.
    unit : of the heights, like ``"nm"``.
    dataset, part : see :func:`read`.
    periodic : whether all are; else as the files say.

    Raises
    ------
    TopographyError
        If an option has no meaning; or see :func:`read`.
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
        return values[i if len(values) > 1 else 0]

    found = []
    for i, path in enumerate(paths):
        lengths, name = of(size, i), of(unit, i)
        try:
            sizes = None if lengths is None else [units.parse(text, "length") for text in lengths.split(",")]
            scale = None if name is None else units.unit_size(name, "length")
        except ValueError as error:
            msg = f"{path.name}: {error}"
            raise TopographyError(msg) from error
        if sizes is not None and len(sizes) > 2:
            msg = f"{path.name}: a map has one or two lengths, got {lengths!r}"
            raise TopographyError(msg)
        its_periodic = True if periodic else None
        found.append(
            read(path, size=sizes, unit=scale, periodic=its_periodic, dataset=of(dataset, i), part=of(part, i))
        )
    return found


class _Map(NamedTuple):
    """Heights as a file has them, and what it says of them."""

    heights: Real
    source: str
    size: tuple[float, ...] | None = None
    """In m."""
    unit: float | None = None
    """Of the heights, in m."""
    periodic: bool = False


def _with_units(found: _Map, size: Sequence[float] | None, unit: float | None, periodic: bool | None) -> Topography:
    """Heights in m: what the file says, or what was given; neither both nor none."""
    for what, its, given in (("size", found.size, size), ("unit", found.unit, unit)):
        if its is None and given is None:
            msg = f"{found.source}: the file does not say the {what} of the map: give --{what}; nothing is assumed"
            raise TopographyError(msg)
        if its is not None and given is not None:
            msg = f"{found.source}: the file itself says the {what} of the map ({its} m): leave out --{what}"
            raise TopographyError(msg)
    lengths = tuple(found.size or size or ())
    if len(lengths) == 1 and found.heights.ndim == 2:
        nx, ny = found.heights.shape
        lengths = (lengths[0], lengths[0] * ny / nx)
    heights = found.heights * (found.unit or unit or np.nan)
    its_periodic = found.periodic if periodic is None else periodic
    return Topography(heights, (lengths[0], lengths[-1]), its_periodic, found.source)


def _from_instrument(path: Path, part: str | None) -> _Map:
    """A map by SurfaceTopography: heights as they are in the file, size and unit in m if it says them."""
    if util.find_spec("SurfaceTopography") is None:
        msg = (
            f"{path}: to read this format install SurfaceTopography (pip install 'stickiness[topography]'), "
            "or save the map as .npy or text"
        )
        raise TopographyError(msg)
    with warnings.catch_warnings(), ExitStack() as stack:
        warnings.simplefilter("ignore")  # of imports, and of formats that are guessed
        try:
            maps = _maps(path, stack)
            chosen = [name for name in maps if part is None or name == part]
            if len(chosen) == 1:
                return maps[chosen[0]]()
        except Exception as error:  # vendors' formats fail in all ways
            unknown = type(error).__name__ == "CannotDetectFileFormat"
            reason = "none of its formats" if unknown else str(error) or type(error).__name__
            msg = f"{path}: SurfaceTopography cannot read it: {reason}"
            raise TopographyError(msg) from error
    names = ", ".join(map(repr, maps)) or "none (a line scan is no map)"
    msg = f"{path}: holds {len(chosen)} maps {f'named {part!r}' if part else ''}, choose one with --part; maps: {names}"
    raise TopographyError(msg)


def _maps(path: Path, stack: ExitStack) -> dict[str, Callable[[], _Map]]:
    """The maps of heights in a file, by name."""
    if zipfile.is_zipfile(path) and "meta.yml" in zipfile.ZipFile(path).namelist():
        from SurfaceTopography.Container.IO import read_container

        members = [member for surface in read_container(str(path)) for member in surface if member.dim == 2]
        names = [str(member.info.get("name", i)) for i, member in enumerate(members)]
        return {name: partial(_values, path, name, member) for name, member in zip(names, members, strict=True)}
    from SurfaceTopography import open_topography

    reader = open_topography(str(path))
    stack.callback(reader.close)
    return {c.channel_id: partial(_load, path, reader, c) for c in reader.height_channels if c.dim == 2}


def _load(path: Path, reader: Any, channel: Any) -> _Map:
    """A channel of a file; a size or unit that it does not say is put in as 1 and left out afterwards."""
    size, unit = channel.physical_sizes, channel.unit
    given: dict[str, Any] = {} if size is not None else {"physical_sizes": (1.0, 1.0)}
    given |= {} if unit is not None else {"unit": "m"}
    found = _values(path, None, reader.topography(channel_index=channel.index, **given))
    scale = None if unit is None else found.unit
    return found._replace(size=None if size is None or scale is None else found.size, unit=scale)


def _values(path: Path, name: str | None, measured: Any) -> _Map:
    """What SurfaceTopography holds, holes as NaN."""
    scale = units.unit_size(str(measured.unit), "length")
    lengths = tuple(float(length) * scale for length in measured.physical_sizes)
    heights = np.ma.filled(np.ma.asarray(measured.heights(), dtype=np.float64), np.nan)
    source = path.name if name is None else f"{path.name}: {name}"
    return _Map(heights, source, lengths, scale, bool(measured.is_periodic))
