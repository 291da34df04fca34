"""What is wrong with a measured map, as far as the map itself shows it.

Each fault is one that moves moments, and with them verdicts, by more than theories differ.  Each is looked for where
the ones before it have been mended, so that one cause is named once.  The limits are such that on clean self-affine
maps of 256² points hardly any fault is found; a test counts them, and docs/predict.md says how many.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy.ndimage import binary_dilation, label

from continuum import units
from continuum.arguments import instance
from continuum.model.fourier import Real
from continuum.topography.map import FLAT, Topography, TopographyError
from continuum.topography.mending import Detrending, background, cut_off, detrend, fill_outliers
from continuum.topography.roughness import Fit, Roughness, fit_self_affine, roughness_of, spectrum
from continuum.topography.scanlines import Mask, ScanLines, scan_lines, spikes

LINE_SHARE = 0.05
"""Part of the mean square slope across the lines, due to their offsets, that counts."""
BACKGROUND_SHARE = 0.75
"""Part of the variance of heights in a plane, or in a paraboloid, that counts.  A surface without roll-off has up to
nine tenths of it in its longest waves."""
ANISOTROPY = 1.5
"""Ratio of the largest to the smallest rms slope over all directions that counts; theories assume 1."""
NOISE_SHARE = 0.1
"""Part of the mean square slope of waves below the floor of the spectrum that counts."""
SIGNAL = 1.25
"""A cut-off in wavelengths of the floor: there the noise is well below the surface."""
KURTOSIS = 5.0
"""<h⁴>/<h²>² that counts; theories assume 3."""
CUSPS = 1.0
"""Skewness of the laplacian that counts: a blunt tip rounds summits and leaves cusps between them."""
BLUNT = 2.0
"""Ratio of the sharpest valleys to the sharpest summits, in laplacians that one in a thousand exceeds, that counts."""
STEPS = 0.25
"""Part of the neighbouring points of exactly the same height that counts."""
STEEP, COARSE = 3.0, 1e-3
"""A rms slope, and a pixel in m, beyond which size or unit of a map are probably wrong."""
SMOOTHEST = 1.25
"""Hurst exponent beyond which a fit is impossible; some more than 1 is its error."""


@dataclass(frozen=True)
class MapFault:
    """One fault of a map."""

    kind: str
    """In the field's words, short: "line noise"."""
    text: str
    """What was found, with numbers and units."""
    remedy: str = ""
    """Options of the command that mend it; empty if nothing does."""


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
    """Points of scars, and points that stand out."""
    directions: Directions
    kurtosis: float
    mended: Topography | None = field(repr=False)
    """The map as the remedies leave it, if there are any: what a verdict on a faulty map is held against."""


def directions(topography: Topography) -> Directions:
    """Slopes and curvatures by direction, from differences of neighbouring heights."""
    h, (dx, dy) = instance("topography", topography, Topography).heights, topography.grid.spacing
    sx, sy = np.diff(h, axis=0) / dx, np.diff(h, axis=1) / dy
    # In the middle of four points both are known.
    mx, my = (sx[:, 1:] + sx[:, :-1]) / 2, (sy[1:] + sy[:-1]) / 2
    xx, yy, xy = np.mean(sx**2), np.mean(sy**2), np.mean(mx * my)
    radius, mean = np.hypot((xx - yy) / 2, xy), (xx + yy) / 2
    return Directions(
        (float(np.sqrt(xx)), float(np.sqrt(yy))),
        (float(np.std(np.diff(h, 2, axis=0)) / dx**2), float(np.std(np.diff(h, 2, axis=1)) / dy**2)),
        float(np.sqrt((mean + radius) / max(mean - radius, 1e-12 * mean))) if mean > 0 else 1.0,
        float(np.degrees(np.arctan2(2 * xy, xx - yy) / 2)),
    )


def find_faults(topography: Topography) -> Findings:
    """Look for every fault, in the order in which they are mended.

    Parameters
    ----------
    topography : as it is to be judged.
    """
    lines = scan_lines(instance("topography", topography, Topography).heights)
    outside = spikes(topography.heights) & ~binary_dilation(lines.scars, iterations=2)
    marked, clean = lines.scars | outside, topography
    faults = _marks(lines, outside)
    if marked.any():
        clean = _mend(clean, lambda one: fill_outliers(one, 1.0))
    steps: tuple[tuple[Callable[..., list[MapFault]], Detrending], ...]
    steps = (_tilt, "plane"), (_line_faults, "lines"), (_bow, "curvature")
    for looked_for, how in steps:
        found: list[MapFault] = looked_for(clean, lines)
        if found:
            faults += found
            clean = _mend(clean, partial(detrend, how=how))
    roughness, fit = roughness_of(clean), fit_self_affine(*spectrum(clean))
    cutoff, short = _short_waves(clean, roughness, fit)
    if cutoff is not None:
        clean = cut_off(clean, cutoff)
    faults += [*short, *_statistics(clean, fit), *_numbers(clean, roughness)]
    return Findings(
        tuple(faults),
        lines,
        marked,
        directions(topography),
        _kurtosis(topography.heights),
        None if clean is topography else clean,
    )


def _mend(topography: Topography, step: Callable[[Topography], Topography]) -> Topography:
    """The map after a step, or as it was where nothing would be left of it."""
    try:
        return step(topography)
    except TopographyError:
        return topography


def _numbers(topography: Topography, roughness: Roughness) -> list[MapFault]:
    """Numbers that no surface has."""
    found = []
    slope, pixel = roughness.moments.rms_slope, max(topography.grid.spacing)
    if slope > STEEP:
        found.append(MapFault("slope", f"an rms slope of {slope:.3g}: size or unit of the heights are probably wrong"))
    if pixel > COARSE:
        found.append(MapFault("pixel", f"pixels of {_length(pixel)}: the size of the map is probably wrong"))
    return found


def _marks(lines: ScanLines, outside: Mask) -> list[MapFault]:
    found = []
    if lines.scars.any():
        count = int(label(lines.scars)[1])
        share = max(100 * float(lines.scars.mean()), 0.01)
        text = f"{count} scar{'s' if count > 1 else ''} along {'xy'[lines.axis]}, {share:.2g} % of the points"
        found.append(MapFault("scars", text, "--fill 5%"))
    if outside.any():
        found.append(MapFault("spikes", f"{np.count_nonzero(outside)} points that stand out", "--fill 5%"))
    return found


def _line_faults(topography: Topography, lines: ScanLines) -> list[MapFault]:
    """Offsets of the lines: of all, or of some."""
    found, along = [], "xy"[lines.axis]
    across = directions(topography).slopes[1 - lines.axis]
    spacing = topography.grid.spacing[1 - lines.axis]
    share = 2 * (lines.noise / spacing) ** 2 / across**2 if across > 0 else 0.0
    if lines.restless and share > LINE_SHARE:
        text = f"lines along {along} displaced by {_length(lines.noise)} (rms), {100 * min(share, 1):.0f} % of the "
        text += "mean square slope across them"
        found.append(MapFault("line noise", text, "--detrend lines"))
    elif lines.outliers.size:
        some = ", ".join(map(str, lines.outliers[:5])) + (", ..." if lines.outliers.size > 5 else "")
        text = f"{lines.outliers.size} lines along {along} displaced against their neighbours (number {some})"
        found.append(MapFault("outlier lines", text, "--detrend lines"))
    return found


def _tilt(topography: Topography, lines: ScanLines) -> list[MapFault]:
    """A plane that carries most of the heights."""
    plane = float(np.var(background(topography, 1)[0]) / np.var(topography.heights))
    if topography.periodic or plane < BACKGROUND_SHARE:
        return []
    return [MapFault("tilt", f"{100 * plane:.0f} % of the variance of heights is a plane", "--detrend plane")]


def _bow(topography: Topography, lines: ScanLines) -> list[MapFault]:
    """A paraboloid that carries most of what the plane leaves."""
    plane, bowl = (float(np.var(background(topography, degree)[0])) for degree in (1, 2))
    whole = float(np.var(topography.heights))
    left = whole - plane
    # Of a plane nothing is left but rounding errors.
    share = (bowl - plane) / left if left > FLAT * whole else 0.0
    if topography.periodic or share < BACKGROUND_SHARE:
        return []
    text = (
        f"{100 * share:.0f} % of the variance of heights is a paraboloid: the bow of a scanner, the shape of the part, "
    )
    return [MapFault("bow", text + "or waves longer than the map", "--detrend curvature")]


def _short_waves(topography: Topography, roughness: Roughness, fit: Fit | None) -> tuple[float | None, list[MapFault]]:
    """Noise, and what a blunt tip left: both are mended by a cut-off, the longer of the two."""
    if topography.cutoff is not None:
        return None, []
    found, cutoffs = [], []
    slope = roughness.whole.moments.rms_slope
    smallest, largest = 2.2 * max(topography.grid.spacing), min(topography.lengths) / 8
    if fit is not None and fit.floor is not None and slope > 0:
        share = 1 - (roughness.cut(fit.floor).moments.rms_slope / slope) ** 2
        wavelength = SIGNAL * fit.floor
        if share > NOISE_SHARE:
            text = f"below {_length(fit.floor)} the spectrum falls less than that of any surface: {100 * share:.0f} % "
            text += "of the mean square slope are probably noise"
            remedy = f"--cutoff {_option(wavelength)}" if smallest < wavelength < largest else ""
            found.append(MapFault("noise", text, remedy))
            cutoffs += [wavelength] if remedy else []
    tip = _tip(topography)
    if tip is not None:
        # Waves are as sharp as the surface's as long as their curvature is half of the tip's.
        waves = [w for w in roughness.wavelengths if roughness.cut(w).moments.rms_curvature < 1 / tip]
        wavelength = min((w for w in waves if smallest < w < largest), default=0.0)
        text = f"summits are rounded to {_length(tip)}, with cusps between them: probably a blunt tip"
        found.append(MapFault("tip", text, f"--cutoff {_option(wavelength)}" if wavelength else ""))
        cutoffs += [wavelength] if wavelength else []
    return max(cutoffs, default=None), found


def _tip(topography: Topography) -> float | None:
    """Radius to which summits are rounded, if the valleys are so much sharper that a tip must have done it."""
    h, (dx, dy) = topography.heights, topography.grid.spacing
    bend = np.diff(h, 2, axis=0)[:, 1:-1] / dx**2 + np.diff(h, 2, axis=1)[1:-1] / dy**2
    low, high = (float(q) for q in np.quantile(bend, (0.001, 0.999)))
    # Both, since the skewness alone is that of a few points where heights are not Gaussian.
    if bend.std() == 0 or not 0 < -low * BLUNT < high or float(np.mean((bend / bend.std()) ** 3)) < CUSPS:
        return None
    return -2 / low


def _statistics(topography: Topography, fit: Fit | None) -> list[MapFault]:
    """What isotropic Gaussian self-affine surfaces do not show."""
    found, by = [], directions(topography)
    if by.anisotropy > ANISOTROPY:
        text = f"slopes along {by.angle:.0f}° from x are {by.anisotropy:.2g} times those across: theories are of "
        found.append(MapFault("anisotropy", text + "isotropic surfaces"))
    kurtosis = _kurtosis(topography.heights)
    if kurtosis > KURTOSIS:
        found.append(MapFault("non-Gaussian heights", f"a kurtosis of {kurtosis:.3g}, where theories assume 3"))
    equal = np.mean(np.diff(topography.heights, axis=0) == 0)
    if equal > STEPS:
        found.append(
            MapFault("height steps", f"{100 * equal:.0f} % of neighbouring points have exactly the same height")
        )
    if fit is not None and not 0 <= fit.hurst <= SMOOTHEST:
        text = f"the fit finds H = {fit.hurst:.2f}, which no self-affine surface has: filtered, interpolated, or shaped"
        found.append(MapFault("impossible fit", text))
    return found


def _kurtosis(heights: Real) -> float:
    z = heights - heights.mean()
    return float(np.mean(z**4) / np.mean(z**2) ** 2)


def _length(value: float) -> str:
    return units.readable(value, "length", 3)


def _option(value: float) -> str:
    """A length as the command takes it."""
    return _length(value).replace(" ", "").replace("µ", "u")
