"""Prepare a map before it is judged or becomes a wall: crop, fill holes, subtract background, remove short waves.

Each step is explicit, changes heights only, and is recorded in the steps of the map.  TopographyError is raised if
nothing would be left, or more would have to be filled than is allowed.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
import scipy

from continuum.inputs import units
from continuum.inputs.arguments import ArgumentError, array, choice, count, instance, number, pair
from continuum.inputs.keys import LARGEST_N
from continuum.maps.map import FLAT, Topography, TopographyError, length_of, mirror
from continuum.maps.scanlines import Mask, line_offsets, scan_lines, spikes
from continuum.model.fourier import Real

Detrending = Literal["plane", "curvature", "lines", "none"]
Edges = Literal["mirror", "window"]
_FEWEST = 4
"""Smallest number of pixels across a part: a cubic spline through fewer is one polynomial."""
_TAPER = 0.5
"""Part of a side over which a window falls to zero, both ends together."""


def detrend(topography: Topography, how: Detrending | None = None) -> Topography:
    """Subtract the tilt of the sample, the bow of the scanner or the offsets of its lines.

    Parameters
    ----------
    topography : as read.
    how : "plane" and "curvature" subtract the least-squares polynomial of first or second degree, "lines" the plane
        and then the median of each line, "none" the mean only.  None subtracts the plane, or the mean of a periodic
        map, which must remain periodic.
    """
    instance("topography", topography, Topography)
    if how is not None:
        choice("how", how, get_args(Detrending))
    heights = topography.heights - topography.heights.mean()
    step = "mean height taken off"
    if how in ("plane", "curvature", "lines") or (how is None and not topography.periodic):
        fitted, slopes = background(topography, 2 if how == "curvature" else 1)
        heights = heights - fitted
        step = f"mean plane taken off, of slopes {slopes[0]:.3g} and {slopes[1]:.3g}"
        if how == "curvature":
            step = f"paraboloid of least squares taken off, {units.readable(float(np.ptp(fitted)), 'length', 3)} high"
    if how == "lines":
        found = scan_lines(heights)
        offsets = np.expand_dims(line_offsets(heights, found.axis, found.scars), found.axis)
        heights = heights - offsets
        heights = heights - heights.mean()
        step += f", then the median of each line along {'xy'[found.axis]}"
    if np.abs(heights).max() <= FLAT * max(np.abs(topography.heights).max(), np.ptp(topography.heights)) * 1e2:
        raise TopographyError(f"{topography.source}: the map is a plane: nothing is left after subtracting it")
    return topography.after(heights, step)


def prepare(
    topography: Topography, how: Detrending | None = None, *, fill: float = 0.0, cutoff: str | None = None
) -> Topography:
    """A map ready to be judged: after :func:`fill_outliers` (unless 0), :func:`detrend` and :func:`cut_off`.

    The cut-off is a text with its unit; None keeps all waves.
    """
    if fill and topography.bands is None:  # a random surface has no background
        topography = fill_outliers(topography, fill)
    topography, wavelength = detrend(topography, how), length_of("cutoff", cutoff)
    return topography if wavelength is None else cut_off(topography, wavelength)


def background(topography: Topography, degree: Literal[1, 2]) -> tuple[Real, tuple[float, float]]:
    """Polynomial of least squares without its mean, and its mean slopes along x and y.

    On a full rectangle 1, x, y, x² - <x²>, y² - <y²> and xy are orthogonal, so that each is projected out separately.
    """
    heights = instance("topography", topography, Topography).heights
    spacing = topography.grid.spacing
    x, y = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(heights.shape, spacing, strict=True))
    along, across = np.ones_like(x), np.ones_like(y)
    terms = [(x, across), (along, y)]
    if degree == 2:
        terms += [(x**2 - np.mean(x**2), across), (along, y**2 - np.mean(y**2)), (x, y)]
    parts = [float(f @ heights @ g / (f @ f) / (g @ g)) for f, g in terms]
    columns = np.stack([part * f for part, (f, _) in zip(parts, terms, strict=True)], axis=1)
    fitted: Real = columns @ np.stack([g for _, g in terms])
    return fitted, (parts[0], parts[1])


def crop(heights: Real, lengths: tuple[float, float], corners: tuple[float, float, float, float]) -> Real:
    """Heights with x0 <= x < x1 and y0 <= y < y1, where points are centres of pixels.

    The corners (x0, x1, y0, y1) are in the unit of the lengths, the size of the map.
    """
    heights = array("heights", heights)
    sides = [number("lengths", length, above=0) for length in pair("lengths", lengths)]
    if heights.ndim != 2:
        raise ArgumentError("heights", heights, "a two-dimensional map")
    if not isinstance(corners, Sequence) or len(corners) != 4:
        raise ArgumentError("corners", corners, "four lengths, x0, x1, y0 and y1")
    edges = [number("corners", edge) for edge in corners]
    part = []
    for name, n, length, low, high in zip("xy", heights.shape, sides, edges[::2], edges[1::2], strict=True):
        if not 0 <= low < high <= length * (1 + 1e-9):  # an end that was given in another unit is rounded
            inside, asked = (units.readable(value, "length", 3) for value in (length, high))
            msg = f"corners: the part to be cut out along {name} begins at 0 or beyond and ends after that, inside "
            msg += f"{inside}; asked for: up to {asked}"
            raise ValueError(msg)
        part.append(slice(*(round(edge / length * n) for edge in (low, high))))
    return heights[tuple(part)]


def harmonic(heights: Real, holes: Mask) -> Real:
    """Heights with holes filled by the solution of Laplace's equation between the known points around them.

    No filled point is above or below all known ones.  Edges of the map are free.
    """
    heights = array("heights", heights)
    holes = array("holes", holes, kinds="b")
    if holes.shape != heights.shape:
        raise ArgumentError("holes", holes, f"a mask of the shape of the heights, {heights.shape}")
    if not holes.any():
        return heights.copy()
    if holes.all():
        raise ValueError("all heights are missing")
    unknown = np.full(heights.shape, -1)
    unknown[holes] = np.arange(np.count_nonzero(holes))
    padded, numbers = np.pad(heights, 1), np.pad(unknown, 1, constant_values=-2)  # -1 is known, -2 beyond the edge
    i, j = np.nonzero(holes)
    beside = [(i, j + 1), (i + 2, j + 1), (i + 1, j), (i + 1, j + 2)]
    its = np.array([numbers[place] for place in beside])
    known = np.where(its == -1, [padded[place] for place in beside], 0.0).sum(axis=0)
    _, rows = np.nonzero(its >= 0)
    links = scipy.sparse.csr_array((np.full(rows.size, -1.0), (rows, its[its >= 0])), shape=(i.size, i.size))
    filled = heights.copy()
    # The diagonal counts neighbours on the map only, so that its edges are free.
    filled[holes] = scipy.sparse.linalg.spsolve(
        (scipy.sparse.diags_array((its > -2).sum(axis=0).astype(float)) + links).tocsc(), known
    )
    return filled


def fill_outliers(topography: Topography, limit: float) -> Topography:
    """Fill scars and outliers as if they had not been measured, up to a share of the points."""
    number("limit", limit, least=0, most=1)
    mask = scan_lines(instance("topography", topography, Topography).heights).scars | spikes(topography.heights)
    share = float(mask.mean())
    if share > limit:
        msg = f"{topography.source}: {100 * share:.2g} % of the points are scars or stand out, `fill` allows "
        msg += f"{100 * limit:.3g} %"
        raise TopographyError(msg)
    if not mask.any():
        # The mark says that outliers have been dealt with, so that none is reported again.
        return replace(topography, filled=True)
    step = f"{100 * share:.2g} % of the points, scars or standing out, filled harmonically"
    return topography.after(harmonic(topography.heights, mask), step, filled=True)


def cut_off(topography: Topography, wavelength: float) -> Topography:
    """Remove waves shorter than a cut-off.

    A map that is not periodic is filtered with its mirror images, which have no steps at the edges.
    """
    wavelength = number("wavelength", wavelength, above=0)
    pixel, size = max(instance("topography", topography, Topography).grid.spacing), min(topography.lengths)
    if not 2 * pixel < wavelength < size / 2:
        ends = " and ".join(units.readable(value, "length", 3) for value in (2 * pixel, size / 2))
        msg = (
            f"{topography.source}: a cut-off wavelength lies between two pixels and half the size of the map, {ends}; "
        )
        msg += f"got {units.readable(wavelength, 'length', 3)}"
        raise TopographyError(msg)
    closed = topography if topography.periodic else mirror(topography)
    grid = closed.grid
    heights_q = grid.forward(closed.heights)
    # A wave exactly at the cut-off stays, whatever rounding says.
    heights_q[grid.wavenumber > 2 * np.pi / wavelength * (1 + 1e-9)] = 0
    nx, ny = topography.heights.shape
    heights = grid.inverse(heights_q)[:nx, :ny]
    step = f"waves shorter than {units.readable(wavelength, 'length', 3)} left out"
    bands = topography.bands
    if bands is not None:
        (edges, density), last = bands, 2 * np.pi / wavelength
        kept = edges[:-1] < last
        bands = np.append(edges[:-1][kept], min(last, float(edges[-1]))), density[kept]
    return topography.after(heights, step, cutoff=wavelength, bands=bands)


def wall_from_map(
    topography: Topography,
    n: int | tuple[int, int],
    spacing: float | tuple[float, float],
    edges: Edges,
    centre: tuple[float, float] = (0.5, 0.5),
) -> Topography:
    """A periodic wall of n x n points, or of two numbers of them, from a part of a map; heights are in m.

    The part is cut out, its plane subtracted, and interpolated by cubic splines; then it is continued by its mirror
    images (the part is then n/2 spacings wide), or brought to its mean at the edges by a Tukey window; and turned
    over, so that its summits are lowest.

    Parameters
    ----------
    topography : as read.
    n : points along a side, even with mirrors; or along x and along y.
    spacing : of the points, as a0 of atoms, in m; or along x and along y.
    edges : method to make it periodic.
    centre : centre of the part, as fractions of the map.

    Raises TopographyError if the part does not lie within the map, has too few of its pixels, or is a plane.
    """
    instance("topography", topography, Topography)
    steps = [number("spacing", step, above=0) for step in (spacing if isinstance(spacing, tuple) else (spacing,) * 2)]
    counts = [count("n", size, 1, LARGEST_N) for size in (n if isinstance(n, tuple) else (n, n))]
    choice("edges", edges, get_args(Edges))
    for fraction in pair("centre", centre):
        number("centre", fraction, above=0, below=1)
    if any(size % 2 for size in counts) and edges == "mirror":
        raise TopographyError(f"{topography.source}: mirrors need an even number n of atoms along a side, got {n}")
    points = [size // 2 if edges == "mirror" else size for size in counts]
    level = detrend(_cut(topography, points, steps, centre))
    if edges == "mirror":
        made = mirror(level)
    else:
        from scipy.signal.windows import tukey

        # The point after the last is the first one again, so that the window is one point longer than the part.
        tapers = [tukey(size + 1, _TAPER)[:-1] for size in points]
        step = "brought to its mean at the edges by a Tukey window"
        made = detrend(level.after(level.heights * np.outer(*tapers), step, periodic=True))
    return made.after(-made.heights, "turned over: what stands out of the body comes lowest")


def _cut(
    topography: Topography, points: Sequence[int], spacing: Sequence[float], centre: tuple[float, float]
) -> Topography:
    """The part of a map, sampled above the atoms."""
    sides = [size * step for size, step in zip(points, spacing, strict=True)]
    width = " x ".join(dict.fromkeys(units.readable(side, "length") for side in sides))
    pixels = [np.arange(m) * length / m for m, length in zip(topography.heights.shape, topography.lengths, strict=True)]
    start = [c * length - side / 2 for c, length, side in zip(centre, topography.lengths, sides, strict=True)]
    at = [s + (np.arange(size) + 0.5) * step for s, size, step in zip(start, points, spacing, strict=True)]
    if any(x[0] < pixel[0] or x[-1] > pixel[-1] for x, pixel in zip(at, pixels, strict=True)):
        size = " x ".join(units.readable(length, "length") for length in topography.lengths)
        raise TopographyError(
            f"{topography.source}: a part {width} wide about {centre} does not lie within the map, "
            f"{size}: choose a smaller n or spacing, another centre, or another map"
        )
    if any(side < _FEWEST * pixel[1] for side, pixel in zip(sides, pixels, strict=True)):
        widest = units.readable(max(pixel[1] for pixel in pixels), "length")
        raise TopographyError(
            f"{topography.source}: a part {width} wide has fewer than {_FEWEST} pixels of {widest}: "
            "it contains no measured roughness: choose a larger n or spacing, or a finer map"
        )
    heights = scipy.interpolate.RectBivariateSpline(pixels[0], pixels[1], topography.heights)(at[0], at[1])
    pixel = " x ".join(units.readable(x[1], "length") for x in pixels)
    cut = topography.after(
        heights, f"{width} cut out about the fractions {centre[0]:g}, {centre[1]:g}",
        lengths=(sides[0], sides[1]), periodic=False,
    )  # fmt: skip
    return cut.after(
        heights,
        f"sampled every {' x '.join(dict.fromkeys(units.readable(step, 'length') for step in spacing))} by cubic "
        f"splines through pixels of {pixel}",
    )
