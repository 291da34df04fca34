"""Measured topographies: checked maps of heights with real units.

Heights are in m, positive out of the body, so that the summits that touch first are the highest points.  A map is a
:class:`Topography`; each change is recorded in its ``steps``.

Sizes, units, shares and parts of a map are parsed from text into numbers in m.  Names in backticks in messages are
arguments, which the command replaces by its options.
"""

import hashlib
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from numbers import Real as Number
from typing import Any, Self, TypeVar

import numpy as np
import scipy

from continuum.inputs import possible, units
from continuum.inputs.arguments import ArgumentError, array, count, flag, instance, number, pair, texts
from continuum.inputs.errors import InputError
from continuum.model.fourier import Complex, Real
from continuum.model.grid import Grid

FEWEST = 16
"""Smallest number of points in each direction."""
Bands = tuple[Real, Real]
"""Edges of bands of |q|, ascending, and the spectral density C in each."""
FLAT = 1e-12
"""Heights smaller than this part of the largest number in the file are rounding errors."""
_SMALLEST, _LARGEST = 1e-20, 1e20
"""Bounds of the size of a map, in m; heights have the same upper bound."""
_PART = 2**16
"""Points of a map that are processed together, so that their intermediate results stay in the processor's cache."""
_NOTHING = 1e-60
"""Bound of heights beyond which squares, divided by pixels to the fourth power, overflow."""
Measured = TypeVar("Measured")
PER_MAP = {"size": '"10um" or "10um,12um"', "unit": '"nm"', "dataset": '"heights"', "part": '"Height"'}
"""Arguments that are one text for all maps or one for each, with examples."""
_ZERO = re.compile(r"\s*[0.]+\s*\D*")
"""Zero, which needs no unit."""


class TopographyError(InputError, ValueError):
    """A topography cannot be used: the message has the reason and a remedy."""


@contextmanager
def as_fault(where: str = "") -> Iterator[None]:
    """Raise a ValueError as a fault of a map, after where it was found."""
    try:
        yield
    except ValueError as error:
        raise TopographyError(f"{where}{error}") from error


def heights_of(name: str, value: Any) -> Real:
    """A copy of an array of real numbers as heights; masked points, which are missing, become NaN."""
    heights = np.array(array(name, value), dtype=np.float64)
    if np.ma.is_masked(value):
        heights[np.ma.getmaskarray(value)] = np.nan
    return heights


def fault_of(heights: Real, lengths: Sequence[float]) -> str:
    """Reason why heights of this size cannot be a measurement; empty if they can."""
    low, high = heights.min(), heights.max()  # NaN where a height is
    if not np.isfinite(high - low):
        missing = np.count_nonzero(~np.isfinite(heights))
        of = f"{missing} of {heights.size} heights are missing or not finite"
        return of if missing == heights.size else f"{of}: `fill` the holes, or `crop` a part without holes"
    if max(high, -low) > _LARGEST:
        return f"heights of more than {_LARGEST:g} m: probably in another unit, or not heights"
    if high - low <= max(FLAT * max(high, -low), _NOTHING):
        return "all heights are equal: not a measured surface, or the wrong channel of the file"
    if not all(_SMALLEST <= length <= _LARGEST for length in lengths):
        size = " x ".join(f"{length:g}" for length in lengths)
        what = "a length" if len(lengths) == 1 else "lengths"
        return f"{what} of {size} m: the size of a measurement is positive, from {_SMALLEST:g} to {_LARGEST:g} m"
    return ""


@dataclass(frozen=True, eq=False)
class Topography:
    """A map of heights.

    Parameters
    ----------
    heights : heights in m, positive out of the body, shape (nx, ny); masked points are missing.
    lengths : (Lx, Ly), physical size, in m; pixels need not be square.
    periodic : whether the map continues at its edges.
    source : description of its origin.
    steps : descriptions of the changes made to it.
    cutoff : wavelength below which waves were removed on purpose, in m.
    filled : whether outliers were looked for and filled on purpose.
    read : heights as they were read, before all changes, by default the heights; equal ones among them are no longer
        equal once a plane is subtracted.
    bands : edges of bands of |q|, in 1/m, and C in each, in m⁴, of the spectrum that a random surface represents,
        which has its moments even if the heights lack the longest waves; None for a map.
    lines : number of scan lines that a random surface represents (:mod:`continuum.maps.spectra`); 0 for a map.
    measurements : number of measurements that a random surface represents; 0 for a map.

    Raises TopographyError if heights are missing, not finite, constant or not two-dimensional, or a size is not
    positive; ArgumentError if an argument is of another type.
    """

    heights: Real = field(repr=False)
    lengths: tuple[float, float]
    periodic: bool = False
    source: str = "array"
    steps: tuple[str, ...] = ()
    cutoff: float | None = None
    lines: int = 0
    measurements: int = 0
    filled: bool = False
    bands: Bands | None = field(default=None, repr=False)
    read: Real = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    _measured: dict[Any, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        instance("source", self.source, str, "a text")
        flag("periodic", self.periodic)
        flag("filled", self.filled)
        count("lines", self.lines, 0)
        count("measurements", self.measurements, 0)
        if self.cutoff is not None:
            number("cutoff", self.cutoff, above=0)
        heights = heights_of("heights", self.heights)
        lengths = tuple(number("lengths", length) for length in pair("lengths", self.lengths))
        if heights.ndim != 2 or min(heights.shape) < FEWEST:
            shape = " x ".join(map(str, heights.shape))
            what = f"an array of {shape} heights" if shape else "heights that are one number"
            fault = f"{what}: a map is two-dimensional, with at least {FEWEST} points along each side"
        else:
            fault = fault_of(heights, lengths)
        if fault:
            raise TopographyError(f"{self.source}: {fault}")
        heights.flags.writeable = False
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "read", self.read if self.read.size else heights)
        object.__setattr__(self, "lengths", lengths)

    @cached_property
    def grid(self) -> Grid:
        """The points of the map; lengths in m."""
        return Grid((self.heights.shape[0], self.heights.shape[1]), self.lengths)

    @property
    def extent(self) -> float:
        """The longest measured wavelength: the smaller side of a map, or that of its spectrum."""
        if self.bands is None:
            return float(min(self.lengths))
        edges = self.bands[0]
        return float(2 * np.pi / np.sqrt(edges[0] * edges[1]))

    @property
    def digest(self) -> str:
        """SHA-256 of heights and size, which identifies the map independently of its file name."""
        return hashlib.sha256(self.heights.tobytes() + np.array(self.lengths).tobytes()).hexdigest()

    def after(self, heights: Real, step: str, **changes: Any) -> Self:
        return replace(self, heights=heights, steps=(*self.steps, step), **changes)


def once(measure: Callable[[Topography], Measured]) -> Callable[[Topography], Measured]:
    """Keep what is measured on a map with the map, whose heights do not change; ArgumentError if it is none."""
    key = f"{measure.__module__}.{measure.__qualname__}"  # a text, which crosses to another process with the map

    @wraps(measure)
    def kept(topography: Topography) -> Measured:
        known = instance("topography", topography, Topography)._measured
        if key not in known:
            known[key] = measure(topography)
        found: Measured = known[key]
        return found

    return kept


def means(heights: Real, fields: Callable[[Real], Sequence[Real]], beside: int = 0) -> Real:
    """Means over a map of fields that are made from its points and so many rows beside each, a few rows at a time."""
    rows = max(_PART // heights.shape[1], 1)
    parts = [fields(heights[low : low + rows + beside]) for low in range(0, heights.shape[0] - beside, rows)]
    return np.array(
        [sum(float(one.sum()) for one in same) / sum(one.size for one in same) for same in zip(*parts, strict=True)]
    )


def mirror(topography: Topography) -> Topography:
    """A periodic map of four times the area: the map and its mirror images.

    It is continuous, unlike the repeated map, and loses nothing to a window; slopes jump at the mirrors.
    """
    heights = mirrored(instance("topography", topography, Topography).heights)
    lengths = (2 * topography.lengths[0], 2 * topography.lengths[1])
    return topography.after(heights, "continued by its mirror images", lengths=lengths, periodic=True)


def mirrored(heights: Real) -> Real:
    """Heights with their mirror images, of twice as many points in each direction."""
    return np.block([[heights, heights[:, ::-1]], [heights[::-1], heights[::-1, ::-1]]])


def mirrored_spectrum(heights: Real, coarse: Grid) -> Complex:
    """Half spectrum on a coarser grid of a map with its mirror images, without its Nyquist modes.

    By a cosine transform of the map itself, a quarter of the points; the grid has the period of the images.
    """
    amplitude = scipy.fft.dctn(heights)
    (m, n), (nx, ny) = coarse.mode_numbers, heights.shape
    kept: Complex = amplitude[np.abs(m), n] * np.exp(0.5j * np.pi * (m / nx + n / ny)) / (4 * heights.size)
    kept[coarse.shape[0] // 2] = kept[:, -1] = 0
    return kept


def opposed(first: Topography, second: Topography) -> Topography:
    """Two rough bodies face to face as one: the sum of the heights, with the second turned over about the y axis.

    The maps need the same pixel, and are cut to their common part.

    Raises TopographyError if their pixels differ by more than one part in a million.
    """
    instance("first", first, Topography)
    instance("second", second, Topography)
    if not np.allclose(first.grid.spacing, second.grid.spacing, rtol=1e-6, atol=0):
        pixels = [" x ".join(units.readable(d, "length") for d in t.grid.spacing) for t in (first, second)]
        raise TopographyError(
            f"{first.source} and {second.source} have pixels of {pixels[0]} and {pixels[1]}: "
            "heights can be added only on the same points; resample one (not needed for statistics)"
        )
    nx, ny = np.minimum(first.heights.shape, second.heights.shape)
    same = first.heights.shape == second.heights.shape
    heights = first.heights[:nx, :ny] + second.heights[::-1][:nx, :ny]
    lengths = (float(nx * first.grid.spacing[0]), float(ny * first.grid.spacing[1]))
    step = "heights added" if same else f"cut to {nx} x {ny} points, heights added"
    source, periodic = f"{first.source} on {second.source}", first.periodic and second.periodic and same
    return Topography(heights, lengths, periodic, source, (*first.steps, *second.steps, step))


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
