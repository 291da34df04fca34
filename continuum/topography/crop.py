"""A part of a measured topography as a rigid wall over the atoms of a crystal: cropped, sampled, made periodic."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from scipy.interpolate import RectBivariateSpline

from continuum.arguments import choice, count, instance, number, pair
from continuum.tables import LARGEST_N
from continuum.topography.map import Topography, TopographyError, mirror
from continuum.topography.mending import detrend
from continuum.units import readable

Edges = Literal["mirror", "window"]

_FEWEST = 4
"""Pixels across a part: within fewer a cubic spline is one polynomial, whatever was measured."""
_TAPER = 0.5
"""Part of a side over which a window goes to zero, both ends together."""


def wall_from_map(
    topography: Topography, n: int, spacing: float, edges: Edges, centre: tuple[float, float] = (0.5, 0.5)
) -> Topography:
    """A periodic wall of n x n points, one above each surface atom; its heights are those of a wall.

    The part is cut out, its plane taken off, and interpolated by cubic splines; then it is continued by its mirror
    images (the part is then n/2 spacings wide), or brought to its mean at the edges by a Tukey window; and turned
    over, so that what stands out of the body comes lowest.

    Parameters
    ----------
    topography : as read.
    n : points along a side, even with mirrors.
    spacing : of the atoms, a0, in m.
    edges : how it is made periodic.
    centre : of the part, as fractions of the map.

    Returns
    -------
    Topography
        In m, with every step in words.

    Raises
    ------
    TopographyError
        If the part does not lie within the map, has too few of its pixels, or is a plane.
    """
    instance("topography", topography, Topography)
    spacing = number("spacing", spacing, above=0)
    choice("edges", edges, get_args(Edges))
    for fraction in pair("centre", centre):
        number("centre", fraction, above=0, below=1)
    if count("n", n, 1, LARGEST_N) % 2 and edges == "mirror":
        raise TopographyError(f"{topography.source}: mirrors need an even number n of atoms along a side, got {n}")
    points = n // 2 if edges == "mirror" else n
    level = detrend(_cut(topography, points, spacing, centre))
    if edges == "mirror":
        made = mirror(level)
    else:
        from scipy.signal.windows import tukey

        taper = tukey(points + 1, _TAPER)[:-1]
        step = "brought to its mean at the edges by a Tukey window"
        made = detrend(level.after(level.heights * np.outer(taper, taper), step, periodic=True))
    return made.after(-made.heights, "turned over: what stands out of the body comes lowest")


def _cut(topography: Topography, points: int, spacing: float, centre: tuple[float, float]) -> Topography:
    """The part of a map, sampled above the atoms."""
    side = points * spacing
    pixels = [np.arange(m) * length / m for m, length in zip(topography.heights.shape, topography.lengths, strict=True)]
    start = [c * length - side / 2 for c, length in zip(centre, topography.lengths, strict=True)]
    at = [s + (np.arange(points) + 0.5) * spacing for s in start]
    if any(x[0] < pixel[0] or x[-1] > pixel[-1] for x, pixel in zip(at, pixels, strict=True)):
        size = " x ".join(readable(length, "length") for length in topography.lengths)
        raise TopographyError(
            f"{topography.source}: a part {readable(side, 'length')} wide about {centre} does not lie within the map, "
            f"{size}: a smaller n or spacing, another centre, or another map"
        )
    if any(side < _FEWEST * pixel[1] for pixel in pixels):
        widest = readable(max(pixel[1] for pixel in pixels), "length")
        raise TopographyError(
            f"{topography.source}: a part {readable(side, 'length')} wide has fewer than {_FEWEST} pixels of {widest}: "
            "it holds no roughness that was measured; a larger n or spacing, or a finer map"
        )
    heights = RectBivariateSpline(pixels[0], pixels[1], topography.heights)(at[0], at[1])
    pixel = " x ".join(readable(x[1], "length") for x in pixels)
    cut = topography.after(
        heights, f"{readable(side, 'length')} cut out about the fractions {centre[0]:g}, {centre[1]:g}",
        lengths=(side, side), periodic=False,
    )  # fmt: skip
    return cut.after(heights, f"sampled every {readable(spacing, 'length')} by cubic splines through pixels of {pixel}")
