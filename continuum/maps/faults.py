"""Find artefacts of a measured map in its heights alone.

Each artefact is one function, which looks for the fault, describes it, and names the argument of
:func:`continuum.predict` that corrects it.  :data:`LEVELLING` and :data:`ROUGHENING` list them in the order in which
they are looked for, each after those before it have been corrected, so that one cause is reported once.  Each changes
moments, and with them verdicts, by more than theories differ.  Equal heights are looked for on the map as it was read.
The limits are such that on clean self-affine maps of 256² points hardly any fault is found; a test counts them, and
docs/studies/index.md has the numbers.

Some faults exclude any verdict, as an impossible size.  Heights unlike those of a Gaussian surface are told: theories
are not for them.  On such a surface nothing is called an outlier, and no remedy would remove its features.

Summits touch first: the upper tenth of a map is compared with its lower tenth and with a Gaussian surface.
Height and slope at one point of a Gaussian surface are independent, and it looks the same upside down.  So the highest
tenth of its points has the rms slope and the scatter of the curvature of the lowest tenth.  Worn, polished or honed
summits, pits and grooves in a plateau, and summits rounded by spheres or a blunt tip change these first.  A tenth of a
map has many short waves, so that these ratios scatter little, whereas skewness and kurtosis depend on its few longest
waves.

Standard errors of summits are Tukey's jackknife over :data:`BLOCKS` x :data:`BLOCKS` parts of the map.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np
import scipy

from continuum.inputs import units
from continuum.maps.map import FLAT, Topography, TopographyError, means, once
from continuum.maps.mending import background, cut_off, detrend, fill_outliers
from continuum.maps.roughness import Fit, Roughness, fit_self_affine, level_floor, roughness_of, spectrum
from continuum.maps.scanlines import DIRECTED, Mask, ScanLines, raised, scan_lines, spikes
from continuum.model.fourier import Real

TENTH = 0.1
"""Share of the points in the upper and in the lower part; 1 % of the area touches, and a larger part attracts."""
BLOCKS = 4
"""Parts along each side that are left out, one at a time; a map has at least 16 points a side."""
RATIO = 1.5
"""Smallest ratio, or inverse ratio, of slope or curvature of the upper and the lower tenth that is reported."""
SKEWNESS, KURTOSIS, BEARING = 1.0, 5.0, 1 / 3
"""Skewness and kurtosis above which heights, and height of the upper tenth over the Gaussian's below which summits, are
not Gaussian: on few long waves, a Gaussian surface was seen with 0.8, 5 and 0.4."""
ERRORS = 3.0
"""Standard errors beyond which a difference is significant.  With RATIO, of 2400 clean maps of 32² to 256² points, H
from 0.2 to 0.95, 14 are called not Gaussian (``python -m docs.studies.classes --alarms``)."""
_SMALLEST = 1e-12


class Upper(NamedTuple):
    """Heights of a map, and its upper tenth; a Gaussian surface has 0, 3, 1, 1 and 1."""

    skewness: float
    kurtosis: float
    bearing: float
    """Mean height of the upper tenth above its lower end, over that of a Gaussian."""
    slope: float
    """rms slope of the upper tenth over that of the lower."""
    curvature: float
    """Standard deviation of the laplacian of the upper tenth over that of the lower."""


@dataclass(frozen=True)
class Summits:
    """The numbers of a map, with their standard errors."""

    value: Upper
    error: Upper
    """Standard errors; of the last three, of their logarithms."""

    @property
    def unlike_gaussian(self) -> list[str]:
        """Descriptions of properties that a Gaussian surface does not have."""
        value, error = self.value, self.error
        said = []
        for name, part in (("slope", "rms slope"), ("curvature", "scatter of the curvature")):
            ratio = getattr(value, name)
            if abs(np.log(ratio)) > max(np.log(RATIO), ERRORS * getattr(error, name)):
                said.append(f"the upper tenth has {ratio:.2g} times the {part} of the lower")
        if np.log(value.bearing) < min(np.log(BEARING), -ERRORS * error.bearing):
            said.append(f"the upper tenth is {value.bearing:.2g} times as high as a Gaussian's")
        if abs(value.skewness) > max(SKEWNESS, ERRORS * error.skewness):
            said.append(f"a skewness of {value.skewness:.2g}")
        if value.kurtosis > KURTOSIS:
            said.append(f"a kurtosis of {value.kurtosis:.3g}")
        return said


def excess(share: float) -> float:
    """Mean height of the upper share of a Gaussian above its lower end, in h_rms: 0.473 of the upper tenth."""
    edge = -float(scipy.special.ndtri(share))
    return float(np.exp(-(edge**2) / 2) / np.sqrt(2 * np.pi)) / share - edge


@once
def summits_of(topography: Topography) -> Summits:
    """Compare the upper tenth of a map with its lower tenth and with that of a Gaussian surface."""
    h = topography.heights
    heights = (h - h.mean()) / h.std()
    low, high = (float(q) for q in np.quantile(heights, (TENTH, 1 - TENTH)))
    edges = [np.linspace(1, n - 1, BLOCKS + 1).astype(int) for n in heights.shape]
    parts = [
        _sums(heights[i - 1 : k + 1, j - 1 : m + 1], topography.grid.spacing, low, high)
        for (i, k), (j, m) in product(*(list(pairwise(edge)) for edge in edges))
    ]
    sums = np.array(parts).T
    whole = sums.sum(axis=1, keepdims=True)
    value, without = _numbers(whole, high)[:, 0], _numbers(whole - sums, high)
    # The last three are ratios: their errors are those of logarithms.
    without[2:] = np.log(without[2:])
    count = sums.shape[1]
    return Summits(Upper(*value.tolist()), Upper(*(np.sqrt(count - 1) * without.std(axis=1)).tolist()))


def _sums(h: Real, spacing: tuple[float, float], low: float, high: float) -> list[float]:
    """Sums over the inner points of a part: powers of the heights, squared slopes, powers of the laplacian."""
    inner = h[1:-1, 1:-1]
    (left, right), (back, front) = (
        ((side - inner) / d for side in sides)
        for sides, d in (((h[:-2, 1:-1], h[2:, 1:-1]), spacing[0]), ((h[1:-1, :-2], h[1:-1, 2:]), spacing[1]))
    )
    slope = (left**2 + right**2 + back**2 + front**2) / 2
    bend = (left + right) / spacing[0] + (back + front) / spacing[1]
    square = inner * inner
    powers = (inner, square, square * inner, square * square)
    found = [float(inner.size), *(float(one.sum()) for one in powers)]
    for part in (inner >= high, inner <= low):
        found += [float(part.sum()), *(float(np.sum(one[part])) for one in (inner, slope, bend, bend**2))]
    return found


def _numbers(sums: Real, high: float) -> Real:
    """The numbers of :class:`Upper` from sums over points, one column for each set of parts."""
    count, first, second, third, fourth = sums[:5]
    m, square = first / count, second / count
    variance = square - m**2
    skewness = (third / count - 3 * m * square + 2 * m**3) / variance**1.5
    kurtosis = (fourth / count - 4 * m * third / count + 6 * m**2 * square - 3 * m**4) / variance**2
    (n, heights, slope, bend, bends), (other, _, its_slope, its_bend, its_bends) = sums[5:10], sums[10:]
    n, other = np.maximum(n, 1), np.maximum(other, 1)  # the whole upper tenth may lie in one part
    bearing = (heights / n - high) / np.sqrt(variance) / excess(TENTH)
    slopes = _ratio(slope / n, its_slope / other)
    curvatures = _ratio(bends / n - (bend / n) ** 2, its_bends / other - (its_bend / other) ** 2)
    return np.stack([skewness, kurtosis, np.maximum(bearing, _SMALLEST), slopes, curvatures])


def _ratio(one: Real | float, other: Real | float) -> Real:
    """Root of a ratio; 1 if both are zero but for rounding."""
    least = _SMALLEST * np.maximum(one, other) + 1e-300
    return np.asarray(np.sqrt(np.maximum(one, least) / np.maximum(other, least)))


_length = partial(units.readable, quantity="length", digits=3)
NOT_GAUSSIAN = "non-Gaussian heights"
"""Name of the fault of a map whose summits are not those of a Gaussian surface."""
_CHECK = "check size and unit of the map"
LINE_SHARE = 0.05
"""Smallest part of the mean square slope across the lines due to their offsets that is reported."""
BACKGROUND_SHARE = 0.75
"""Smallest part of the variance of heights in a plane, or in a paraboloid, that is reported.  A surface without
roll-off has up to nine tenths of its variance in its longest waves."""
ANISOTROPY = 1.5
"""Smallest ratio of the largest to the smallest rms slope over all directions that is reported; theories assume 1."""
NOISE_SHARE = 0.1
"""Smallest part of the mean square slope in waves below the floor of the spectrum that is reported."""
SIGNAL = 1.25
"""Advised cut-off, in wavelengths of the floor: there the noise is well below the spectrum of the surface."""
RAISED = 0.25
"""Smallest part of outliers above their neighbours; with less they are pits and grooves of the surface, since scars
and displaced lines lie above as often as below."""
CUSPS = 1.0
"""Smallest skewness of the laplacian that is reported: a blunt tip rounds summits and leaves cusps between them."""
BLUNT = 2.0
"""Smallest ratio of the sharpest valleys to the sharpest summits that is reported, in laplacians exceeded by one point
in a thousand."""
STEPS = 0.25
"""Smallest part of neighbouring points with exactly equal heights that is reported."""
CLIPPED = 0.005
"""Smallest part of the points with exactly the largest, or the smallest, height that is reported."""
STEEP, COARSE = 3.0, 1e-3
"""Rms slope, and pixel in m, beyond which size or unit of a map are probably wrong."""
SMOOTHEST = 1.25
"""Hurst exponent above which a fit is impossible; a little above 1 is within its error."""


@dataclass(frozen=True)
class MapFault:
    """One fault of a map."""

    kind: str
    """Name of the fault, such as "line noise"."""
    text: str
    """Description with numbers and units."""
    remedy: Mapping[str, str | float] = field(default_factory=dict)
    """Argument of :func:`continuum.predict` that corrects it, and its value, lengths in m; empty if there is none."""
    excludes: str = ""
    """Advice if theories of moments cannot judge a map with this fault; empty if they can."""
    of_the_heights: bool = False
    """True if the heights are not those of the surface, so that without a remedy even a solution is doubtful."""

    @property
    def arguments(self) -> dict[str, str]:
        """The remedy as arguments with units, for :func:`continuum.predict` and the command."""
        # A length is typed as 12nm.
        return {
            name: value if isinstance(value, str) else _length(value).replace(" ", "").replace("µ", "u")
            for name, value in self.remedy.items()
        }


class Marks(NamedTuple):
    """Displaced lines and outliers of a map as it was given."""

    lines: ScanLines
    outside: Mask
    """Outliers outside of scars."""


class SpectrumFindings(NamedTuple):
    """Results from the spectrum of a map before short waves are left out."""

    roughness: Roughness
    fit: Fit | None


Artefact = Callable[[Topography, Any], MapFault | None]
"""Function that looks for one fault on a map, given earlier measurements on it."""


@dataclass(frozen=True)
class Directions:
    """Roughness by direction: along x, along y, and where the slope is largest and smallest."""

    slopes: tuple[float, float]
    """rms slope along x and along y."""
    curvatures: tuple[float, float]
    """rms second derivative along x and along y."""
    anisotropy: float
    """Largest over smallest rms slope over all directions."""
    angle: float
    """Direction of the largest slope, in degrees from x, between -90 and 90."""


@dataclass(frozen=True, eq=False)
class Findings:
    """All that was found on one map."""

    faults: tuple[MapFault, ...]
    lines: ScanLines = field(repr=False)
    marked: Mask = field(repr=False)
    """Points of scars, and outliers."""
    directions: Directions
    summits: Summits
    mended: Topography | None = field(repr=False)
    """The corrected map, if there are remedies: the verdict on it is compared with that on the faulty map."""


@once
def directions(topography: Topography) -> Directions:
    """Slopes and curvatures by direction, from differences of neighbouring heights."""
    h, (dx, dy) = topography.heights, topography.grid.spacing

    def between(part: Real) -> tuple[Real, Real]:
        sx, sy = np.diff(part, axis=0) / dx, np.diff(part, axis=1) / dy
        # In the middle of four points both are known.
        return sx**2, (sx[:, 1:] + sx[:, :-1]) * (sy[1:] + sy[:-1]) / 4

    def along(part: Real) -> tuple[Real, Real, Real]:
        slope, bend = np.diff(part, axis=1) / dy, np.diff(part, 2, axis=1) / dy**2
        return slope**2, bend, bend**2

    def across(part: Real) -> tuple[Real, Real]:
        bend = np.diff(part, 2, axis=0) / dx**2
        return bend, bend**2

    (xx, xy), (yy, *along_y), along_x = means(h, between, 1), means(h, along), means(h, across, 2)
    radius, mean = np.hypot((xx - yy) / 2, xy), (xx + yy) / 2
    return Directions(
        (float(np.sqrt(xx)), float(np.sqrt(yy))),
        (_deviation(*along_x), _deviation(*along_y)),
        # Grooves along one direction have no slope along the other: the ratio stays finite.
        float(np.sqrt((mean + radius) / max(mean - radius, 1e-12 * mean))) if mean > 0 else 1.0,
        float(np.degrees(np.arctan2(2 * xy, xx - yy) / 2)),
    )


def _deviation(mean: float, square: float) -> float:
    """Standard deviation of numbers with this mean and mean square."""
    return float(np.sqrt(max(square - mean**2, 0.0)))


@once
def find_faults(topography: Topography) -> Findings:
    """Look for all faults of a map, in the order in which they are corrected."""
    lines = scan_lines(topography.heights)
    marks = Marks(lines, spikes(topography.heights) & ~scipy.ndimage.binary_dilation(lines.scars, iterations=2))
    faults, clean = _looked_for(LEVELLING, topography, marks)
    waves = SpectrumFindings(roughness_of(clean), fit_self_affine(*spectrum(clean)))
    more, clean = _looked_for(ROUGHENING, clean, waves)
    faults += more
    if any(fault.kind == NOT_GAUSSIAN for fault in faults):
        faults, clean = _of_the_surface(faults), topography
    marked, mended = lines.scars | marks.outside, None if clean is topography else clean
    return Findings(tuple(faults), lines, marked, directions(topography), summits_of(topography), mended)


def _of_the_surface(faults: list[MapFault]) -> list[MapFault]:
    """Faults of a non-Gaussian surface: those found by comparison with a Gaussian are dropped, or have no remedy."""
    outliers, waves = ("scars", "spikes", "outlier lines"), ("noise", "tip")
    kept = [fault for fault in faults if fault.kind not in outliers]
    return [replace(fault, remedy={}, of_the_heights=False) if fault.kind in waves else fault for fault in kept]


def _looked_for(stages: Sequence[Stage], topography: Topography, seen: Any) -> tuple[list[MapFault], Topography]:
    """Faults of each stage, found on the map corrected for the stages before, and the corrected map."""
    faults: list[MapFault] = []
    for stage in stages:
        known = {fault.kind for fault in faults}
        found = [one for artefact in stage if (one := artefact(topography, seen)) and one.kind not in known]
        topography, faults = _mended(topography, found), faults + found
    return faults, topography


def _mended(topography: Topography, faults: list[MapFault]) -> Topography:
    """The map after the remedies of its faults (of cut-offs the longest); unchanged if nothing would be left."""
    for argument, mend in MENDING.items():
        values = [fault.remedy[argument] for fault in faults if argument in fault.remedy]
        try:
            topography = mend(topography, max(values)) if values else topography
        except TopographyError:
            continue
    return topography


def _scars(topography: Topography, marks: Marks) -> MapFault | None:
    scars = marks.lines.scars
    if topography.filled or raised(topography.heights, scars, marks.lines.axis) < RAISED:
        return None
    count = int(scipy.ndimage.label(scars)[1])
    share = max(100 * float(scars.mean()), 0.01)
    text = f"{count} scar{'s' if count > 1 else ''} along {'xy'[marks.lines.axis]}, {share:.2g} % of the points"
    return MapFault("scars", text, {"fill": "5%"})


def _spikes(topography: Topography, marks: Marks) -> MapFault | None:
    if topography.filled or raised(topography.heights, marks.outside, marks.lines.axis) < RAISED:
        return None
    return MapFault("spikes", f"{np.count_nonzero(marks.outside)} points that stand out", {"fill": "5%"})


def _line_share(topography: Topography, lines: ScanLines) -> float:
    """Part of the mean square slope across the lines due to their offsets, if all lines are displaced."""
    across = directions(topography).slopes[1 - lines.axis]
    spacing = topography.grid.spacing[1 - lines.axis]
    return 2 * (lines.noise / spacing) ** 2 / across**2 if across > 0 and lines.independent else 0.0


def _line_noise(topography: Topography, marks: Marks) -> MapFault | None:
    lines = marks.lines
    share = _line_share(topography, lines)
    if share <= LINE_SHARE:
        return None
    if lines.grooved:
        return _grooves(lines, "are much lower than their neighbours more often than higher")
    text = f"lines along {'xy'[lines.axis]} displaced by {_length(lines.noise)} (rms), {100 * min(share, 1):.0f} % of "
    return MapFault("line noise", text + "the mean square slope across them", {"detrend": "lines"})


def _outlier_lines(topography: Topography, marks: Marks) -> MapFault | None:
    """Single displaced lines; not reported again if all are displaced."""
    lines = marks.lines
    if not lines.outliers.size or _line_share(topography, lines) > LINE_SHARE:
        return None
    some = ", ".join(map(str, lines.outliers[:5])) + (", ..." if lines.outliers.size > 5 else "")
    marked = np.zeros(topography.heights.shape, dtype=bool)
    np.moveaxis(marked, 1 - lines.axis, 0)[lines.outliers] = True
    if lines.ratio > DIRECTED or raised(topography.heights, marked, lines.axis) < RAISED:
        return _grooves(lines, f"lie below their neighbours (number {some})")
    text = f"{lines.outliers.size} lines along {'xy'[lines.axis]} displaced against their neighbours (number {some})"
    return MapFault("outlier lines", text, {"detrend": "lines"})


def _grooves(lines: ScanLines, text: str) -> MapFault:
    """Grooves, without a remedy: subtracting the median of each line would remove them."""
    return MapFault("grooves", f"lines along {'xy'[lines.axis]} {text}: grooves, or displaced lines")


def _tilt(topography: Topography, marks: Marks) -> MapFault | None:
    plane = 0.0 if topography.periodic else float(np.var(background(topography, 1)[0]) / np.var(topography.heights))
    if plane < BACKGROUND_SHARE:
        return None
    return MapFault("tilt", f"{100 * plane:.0f} % of the variance of heights is a plane", {"detrend": "plane"})


def _bow(topography: Topography, marks: Marks) -> MapFault | None:
    if topography.periodic:
        return None
    plane, bowl = (float(np.var(background(topography, degree)[0])) for degree in (1, 2))
    whole = float(np.var(topography.heights))
    left = whole - plane
    # If the map is a plane, only rounding errors are left.
    share = (bowl - plane) / left if left > FLAT * whole else 0.0
    if share < BACKGROUND_SHARE:
        return None
    text = f"{100 * share:.0f} % of the variance of heights is a paraboloid: the bow of a scanner, the shape of the "
    return MapFault("bow", text + "part, or waves longer than the map", {"detrend": "curvature"})


def _cut(topography: Topography, wavelength: float | None, waves: float = 8.0) -> dict[str, str | float]:
    """The cut-off as a remedy, if it is longer than the pixel and so many waves of it lie along the map."""
    smallest, largest = 2.2 * max(topography.grid.spacing), min(topography.lengths) / waves
    return {"cutoff": wavelength} if wavelength is not None and smallest < wavelength < largest else {}


def _noise(topography: Topography, waves: SpectrumFindings) -> MapFault | None:
    fit, slope = waves.fit, waves.roughness.whole.moments.rms_slope
    if topography.cutoff is not None or topography.bands is not None or not slope > 0:
        return None
    # Noise extends to the pixel: a floor that ends before belongs to the surface, whose cut-off noise may follow.
    beyond = fit is None or fit.cut_off is not None
    floor = level_floor(*spectrum(topography)) if fit is None or beyond else fit.floor
    share = 0.0 if floor is None else 1 - (waves.roughness.cut(floor).moments.rms_slope / slope) ** 2
    if floor is None or share <= NOISE_SHARE:
        return None
    text = f"below {_length(floor)} the spectrum falls less than that of any surface: {100 * share:.0f} % "
    text += "of the mean square slope are probably noise"
    # Beyond its own cut-off there is nothing of the surface, however few waves it has.
    remedy = _cut(topography, floor, 4.0) if beyond else _cut(topography, SIGNAL * floor)
    return MapFault("noise", text, remedy, of_the_heights=True)


def _blunt_tip(topography: Topography, waves: SpectrumFindings) -> MapFault | None:
    """Summits rounded to a radius, if the valleys are so much sharper that a blunt tip is the cause."""
    h, (dx, dy) = topography.heights, topography.grid.spacing

    def bends(part: Real) -> Real:
        return np.asarray(np.diff(part, 2, axis=0)[:, 1:-1] / dx**2 + np.diff(part, 2, axis=1)[1:-1] / dy**2)

    unit = waves.roughness.stencil.rms_curvature
    if topography.cutoff is not None or not unit > 0:
        return None
    mean, square, cube = means(h, lambda part: (bend := bends(part) / unit, bend**2, bend * bend * bend), 2)
    if not cube >= CUSPS * _deviation(mean, square) ** 3:
        return None
    # Both are required, since the skewness alone may be that of a few points if heights are not Gaussian.
    low, high = (float(q) for q in np.quantile(bends(h), (0.001, 0.999)))
    if not 0 < -low * BLUNT < high:
        return None
    tip = -2 / low
    wavelength = min((wave for wave in waves.roughness.followed_by(tip) if _cut(topography, wave)), default=None)
    text = f"summits are rounded to {_length(tip)}, with cusps between them: by a blunt tip, or spheres"
    return MapFault("tip", text, _cut(topography, wavelength), of_the_heights=True)


def _anisotropy(topography: Topography, waves: SpectrumFindings) -> MapFault | None:
    by = directions(topography)
    if by.anisotropy <= ANISOTROPY:
        return None
    text = f"slopes along {by.angle:.0f}° from x are {by.anisotropy:.2g} times those across: theories are of "
    return MapFault("anisotropy", text + "isotropic surfaces")


def _impossible_fit(topography: Topography, waves: SpectrumFindings) -> MapFault | None:
    fit = waves.fit
    if fit is None or 0 <= fit.hurst <= SMOOTHEST:
        return None
    text = f"the fit finds H = {fit.hurst:.2f}, which no self-affine surface has: filtered, interpolated, or shaped"
    return MapFault("impossible fit", text)


def _not_gaussian(topography: Topography, waves: SpectrumFindings) -> MapFault | None:
    found = summits_of(topography).unlike_gaussian
    text = f"{', '.join(found)}: theories of roughness are of Gaussian surfaces"
    return MapFault(NOT_GAUSSIAN, text, excludes="the contact decides, as it is pressed") if found else None


def _equal_neighbours(heights: Real) -> float:
    """Part of neighbouring points with the same height, along the direction with more of them."""
    return float(max(np.mean(np.diff(heights, axis=axis) == 0) for axis in (0, 1)))


def _at_an_end(heights: Real) -> float:
    """Part of the points at the largest height, or at the smallest, whichever is larger."""
    return float(max(np.mean(heights == end) for end in (heights.min(), heights.max())))


def _percent(share: float) -> str:
    return f"{100 * share:.2g}"


def above(
    kind: str,
    quantity: Callable[[Topography, SpectrumFindings], float],
    limit: float,
    text: str,
    shown: Callable[[float], str] = "{:.3g}".format,
    excludes: str = "",
) -> Artefact:
    """An artefact of the heights without remedy: a quantity above a limit; the text has a place for its value."""

    def find(topography: Topography, waves: SpectrumFindings) -> MapFault | None:
        value = quantity(topography, waves)
        fault = MapFault(kind, text.format(shown(value)), excludes=excludes, of_the_heights=True)
        return fault if value > limit else None

    return find


Stage = list[Artefact]
"""Artefacts that are looked for on one map, and then corrected together."""
LEVELLING: list[Stage] = [[_scars, _spikes], [_tilt], [_line_noise, _outlier_lines], [_bow]]
"""Artefacts of the instrument in lines and single points: called with the map and its :class:`Marks`."""
ROUGHENING: list[Stage] = [
    [_not_gaussian],  # repeated below: a cut-off rounds cusps between spheres, and noise is equally steep everywhere
    [_noise, _blunt_tip],
    [
        _anisotropy,
        _not_gaussian,
        above("height steps", lambda topography, _: _equal_neighbours(topography.read), STEPS,
              "{} % of neighbouring points have exactly the same height", _percent),
        above("saturation", lambda topography, _: _at_an_end(topography.read), CLIPPED,
              "{} % of the points have exactly the largest, or the smallest, height: clipped, or flat", _percent),
        _impossible_fit,
        above("slope", lambda _, waves: waves.roughness.moments.rms_slope, STEEP,
              "an rms slope of {}: size or unit of the heights are probably wrong", excludes=_CHECK),
        above("pixel", lambda topography, _: max(topography.grid.spacing), COARSE,
              "pixels of {}: the size of the map is probably wrong", _length, _CHECK),
    ],
]  # fmt: skip
"""Artefacts in the spectrum and in the statistics: called with the map and its :class:`SpectrumFindings`."""
MENDING: dict[str, Callable[[Topography, Any], Topography]] = {
    "fill": lambda topography, share: fill_outliers(topography, 1.0),
    "detrend": detrend,
    "cutoff": cut_off,
}
"""Correction for each argument of a remedy."""
