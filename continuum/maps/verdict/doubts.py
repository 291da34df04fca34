"""Warnings of a prediction: about the maps, their resolution and size, and the numbers given."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from continuum.inputs import units
from continuum.maps.map import Topography
from continuum.maps.roughness import Fit, Roughness
from continuum.maps.verdict.criteria import AREA, RoughContact

_length = partial(units.readable, quantity="length")
RESOLVED = 8.0
"""Smallest d_rep, in pixels, at which slope and curvature are those of the surface, not of the pixel."""
GROWTH = 0.1
"""Share of the rms slope in the shortest octave above which the slope is not that of the surface."""
FEW = 10.0
"""Smallest number of contacts of size d_rep² in 1 % of the map for an average; the paper shows A_rep above 10 λ_s²
only."""
LINE_ERROR = 0.1
"""Error of slope and curvature from one line, measured on synthetic surfaces; it falls with the root of their
number."""
LINES_ERROR = 0.03
"""Error of slope and curvature from many lines: the largest found for thirty lines, beyond which more do not help."""
DISAGREE = 0.15
"""Difference of two estimates of the rms slope above which it is mentioned."""


def _stands_for(topography: Topography) -> Iterator[str]:
    """Warnings about a random surface that represents lines or several measurements, and about a size."""
    yield from (step for step in topography.steps if "would be square" in step)
    if topography.lines:
        error = max(LINE_ERROR / np.sqrt(topography.lines), LINES_ERROR)
        yield (
            f"from {topography.lines} line{'s' if topography.lines > 1 else ''}: isotropy and Gaussian "
            f"heights are assumed, slope and curvature known to {error:.0%}, faults not looked for"
        )
    if topography.measurements:
        agree = next((step for step in topography.steps if "densities differ" in step), "none has waves of another")
        yield (
            f"from {topography.measurements} measurements: isotropy and Gaussian heights are assumed, "
            f"faults looked for in their joined spectrum only; {agree}"
        )


def prediction_doubts(
    topographies: Sequence[Topography],
    analysed: Sequence[Roughness],
    fits: Sequence[Fit | None],
    roughness: Roughness,
    contact: RoughContact,
) -> list[str]:
    """Warnings of a prediction, in words."""
    found = []
    for topography, mine, fit in zip(topographies, analysed, fits, strict=True):
        name = topography.source
        found += [f"{name}: {doubt}" for doubt in _stands_for(topography)]
        ratio = mine.spectral.rms_slope / mine.stencil.rms_slope
        if abs(ratio - 1) > DISAGREE:
            why = "roughness at the pixel" if ratio > 1 else "a map that is rougher at its edges"
            found.append(
                f"{name}: rms slope {mine.spectral.rms_slope:.3g} from the spectrum, {mine.stencil.rms_slope:.3g} from "
                f"neighbouring points: {why}"
            )
        if fit is not None and fit.roll_off is None:
            found.append(f"{name}: no roll-off: h_rms, and criteria that use it, depend on the size of the map")
    pixels = contact.diameter / roughness.pixel
    if pixels < RESOLVED:
        found.append(
            f"resolution: d_rep is {pixels:.2g} pixels; below about {RESOLVED:g} the curvature is that of the pixel, "
            "not of the surface"
        )
    # Of a map, or of the square that the longest wave of a spectrum spans.
    areas = [one.grid.area if one.bands is None else one.extent**2 for one in topographies]
    contacts = AREA * min(areas) / contact.diameter**2
    if contacts < FEW:
        found.append(
            f"size: {100 * AREA:g} % of the map is {contacts:.2g} d_rep²; below about {FEW:g} single summits decide, "
            "not the average that all theories give"
        )
    whole, octave = roughness.whole.moments, roughness.cut(4 * roughness.pixel).moments
    grown = 1 - octave.rms_slope / whole.rms_slope
    if grown > GROWTH:
        found.append(
            f"resolution: {100 * grown:.0f} % of the rms slope come from wavelengths below 4 pixels "
            f"({_length(4 * roughness.pixel)}): a finer map would be steeper, and less sticky"
        )
    if len({mine.pixel for mine in analysed}) > 1:
        finest = min(mine.pixel for mine in analysed)
        found.append(f"different pixels: from {_length(finest)} to {_length(roughness.pixel)} one map is missing")
    if roughness.pixel > contact.range:
        found.append(
            f"the pixel, {_length(roughness.pixel)}, is larger than the range of adhesion: roughness between the "
            "points is not seen, and can undo a verdict of 'sticky'"
        )
    return found
