"""Several measurements of one surface, each of its own size and resolution, joined into one spectrum.

Each tells of the waves that it resolves: in bands of equal width of log q the logarithms of the spectral densities are
averaged over the measurements that have waves there.  An isotropic random surface of that spectrum stands for all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from continuum.arguments import count, instance
from continuum.model.fourier import Real
from continuum.topography.linescan import BANDS_PER_DECADE, random_surface
from continuum.topography.map import Topography, TopographyError
from continuum.topography.mending import detrend
from continuum.topography.roughness import spectrum

_BANDS_OF_LINES = BANDS_PER_DECADE // 2  # a profile leaves bands with power or without: two are averaged
_ROUNDING = 1e-20
MOST_POINTS = 2048
"""Points a side of the surface, at most: waves longer than so many of the finest pixels are left out."""


def joined_spectrum(topographies: Sequence[Topography]) -> tuple[Real, Real, float]:
    """Wavenumbers and C of all measurements, and the factor by which they scatter where several have waves.

    A measurement counts from twice its longest wave, where its window and its levelling show, to half the highest
    wavenumber that it resolves; but the largest one from its beginning, and the finest one to its end.
    """
    spectra = [spectrum(detrend(one)) for one in topographies]
    first, last = (np.array([float(q[i]) for q, _ in spectra]) for i in (0, -1))
    low, high = float(first.min()), float(last.max())
    per_decade = _BANDS_OF_LINES if any(one.lines for one in topographies) else BANDS_PER_DECADE
    count = max(2, round(np.log10(high / low) * per_decade))
    edges = np.geomspace(low, high * (1 + 1e-9), count + 1)
    found = np.full((len(spectra), count), np.nan)
    for i, (q, c) in enumerate(spectra):
        own = (q >= first[i] * (2 if first[i] > low else 1)) & (q <= last[i] / (2 if last[i] < high else 1))
        band = np.clip(np.searchsorted(edges, q[own], side="right") - 1, 0, count - 1)
        # A ring has as many modes as it is long.
        mean = np.bincount(band, c[own] * q[own], count) / np.maximum(np.bincount(band, q[own], count), low)
        # A band that lines leave without power, but for rounding, is one of which they do not tell.
        told = mean > _ROUNDING * c.max()
        found[i, told] = np.log(mean[told])
    has = np.isfinite(found)
    several, some = has.sum(axis=0) > 1, has.any(axis=0)
    mean = np.nansum(found, axis=0)[some] / has.sum(axis=0)[some]
    scatter = np.nanvar(found[:, several], axis=0, ddof=1).mean() if several.any() else np.nan
    return np.sqrt(edges[1:] * edges[:-1])[some], np.exp(mean), float(np.exp(np.sqrt(scatter)))


def joined(topographies: Sequence[Topography], source: str = "measurements", seed: int = 0) -> Topography:
    """A periodic random surface with the spectrum of several measurements of one surface.

    Parameters
    ----------
    topographies : as read; each is levelled first.
    source : where they come from, in words.
    seed : of the random numbers.

    Raises
    ------
    TopographyError
        If there is none, or their waves fill less than two bands.
    """
    if not (isinstance(topographies, Sequence) and topographies):
        raise TopographyError(f"{source}: topographies: no measurement to join")
    for one in topographies:
        instance("topographies", one, Topography)
    count("seed", seed, 0)
    q, c, scatter = joined_spectrum(topographies)
    if q.size < 2:
        raise TopographyError(f"{source}: too few waves to join: a map of at least 16 x 16 points has enough")
    steps = np.log(q), np.log(c)

    def density(wavenumber: Real) -> Real:
        """A power law between two wavenumbers, and as steep beyond the last; zero below the first band."""
        x = np.log(np.maximum(wavenumber, q[0] / 10))
        end = steps[1][-1] + (x - steps[0][-1]) * (steps[1][-1] - steps[1][-2]) / (steps[0][-1] - steps[0][-2])
        inside = np.where(x > steps[0][-1], end, np.interp(x, *steps))
        return np.where(wavenumber >= q[0] ** 2 / np.sqrt(q[0] * q[1]) * (1 - 1e-9), np.exp(inside), 0.0)

    spacing = min(max(one.grid.spacing) for one in topographies)
    longest = max(max(one.lengths) for one in topographies)
    n = int(np.clip(round(longest / spacing), 16, MOST_POINTS))
    grid, heights = random_surface(density, spacing, n, seed)
    told = [
        f"{len(topographies)} measurements joined: an isotropic Gaussian surface of their spectrum, {n} x {n} points"
    ]
    if longest / spacing > n + 0.5:
        told.append(f"waves longer than {n} of the finest pixels left out")
    if np.isfinite(scatter):
        told.append(f"where several have waves, their spectral densities differ by a factor of {scatter:.2g}")
    return Topography(heights, grid.lengths, True, source, tuple(told), measurements=len(topographies))
