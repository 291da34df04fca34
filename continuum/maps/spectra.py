"""Random surfaces that represent scan lines, or several measurements of one surface.

A profile of an isotropic surface has the spectrum C1(q) = ∫ C(√(q² + k²)) dk, Abel's transform of that of the surface.
It is inverted in logarithmic bands, with C constant and not negative in each; deviations are weighted by the fitted
values, as for a periodogram (iteratively reweighted).

Measurements of different size and resolution each have the waves that they resolve: in bands of equal width in log q
the logarithms of their spectral densities are averaged over those with waves there.

All theories need moments of the spectrum only, which are those of the bands, over any number of decades.  Where a map
is drawn, a random surface of that spectrum represents the measurement, Gaussian and isotropic by assumption.
"""

from collections.abc import Callable, Sequence

import numpy as np
import scipy

from continuum.inputs.arguments import ArgumentError, count, flag, instance, number
from continuum.maps.map import Bands, Topography, TopographyError, fault_of, heights_of
from continuum.maps.mending import detrend
from continuum.maps.roughness import BANDS_PER_DECADE, spectrum
from continuum.model.fourier import Real
from continuum.model.grid import Grid

LARGEST = 1024
"""Largest number of points along a side of the surface, which lacks longer waves of a longer scan."""
SHORTEST = 64
"""Smallest number of points of a scan."""
_STEPS = 8
"""Steps of reweighting; the weights change by less than a per cent after five."""
_BANDS_OF_LINES = BANDS_PER_DECADE // 2  # the inversion leaves bands with and without power: two are averaged
_ROUNDING = 1e-20
MOST_POINTS = 2048
"""Largest number of points along a side of the surface, which lacks waves longer than so many of the finest pixels."""
_FINE = 10
"""Number of parts of a band of the joined spectrum, constant in each."""


def profile_spectrum(lines: Real, spacing: float, *, periodic: bool = False) -> tuple[Real, Real]:
    """Average spectrum of profiles: q above zero, ascending, and C1 in length³.

    ∫ C1 dq over both signs of q is the mean square height.  Each line of heights is a profile of equally spaced points,
    which is tilted level and weighted with a Hann window unless it is periodic.
    """
    from scipy import signal  # half a second that other commands need not wait

    lines = np.atleast_2d(lines)
    if periodic:
        frequency, density = signal.welch(lines, 1 / spacing, "boxcar", lines.shape[1])
    else:
        frequency, density = signal.welch(signal.detrend(lines), 1 / spacing, "hann", lines.shape[1])
    return 2 * np.pi * frequency[1:], density.mean(axis=0)[1:] / (4 * np.pi)


def surface_bands(wavenumber: Real, profile: Real) -> Bands:
    """C, constant in bands, of the isotropic surface with a given :func:`profile_spectrum`, by Abel's equation."""
    # In units of the longest wave and its power, so that rounding is the same in all.
    units = float(wavenumber[0]), float(profile.mean())
    wavenumber, profile = wavenumber / units[0], profile / units[1]
    band = np.floor(np.log10(wavenumber) * BANDS_PER_DECADE + 0.5).astype(np.int64)
    count = np.bincount(band)
    filled = count > 0
    q, c = (np.bincount(band, weights=values)[filled] / count[filled] for values in (wavenumber, profile))
    inner = np.sqrt(q[1:] * q[:-1])
    first, last = q[0] ** 2 / inner[0], wavenumber[-1] + (wavenumber[1] - wavenumber[0]) / 2
    edges = np.concatenate([[first], inner, [last]])
    # A ring of C contributes to C1(q) the length of the line at q inside it.
    reach = np.sqrt(np.maximum(edges[None, :] ** 2 - q[:, None] ** 2, 0.0))
    rings = 2 * np.diff(reach, axis=1)
    model = c
    for _ in range(_STEPS):
        # A periodogram scatters in proportion to its mean, which only the fit itself tells: weights are iterated.
        weight = np.sqrt(count[filled]) / model
        found, _ = scipy.optimize.nnls(rings * weight[:, None], c * weight)
        model = np.maximum(rings @ found, 1e-6 * c)
    return edges * units[0], found * (units[1] / units[0])


def random_surface(density: Callable[[Real], Real], spacing: float, n: int, seed: int) -> tuple[Grid, Real]:
    """Grid and heights of an isotropic surface of spectral density C(|q|) on n x n points.

    Only phases are random, so that the moments are those of the spectrum.
    """
    grid = Grid.square(n, spacing)
    power = density(grid.wavenumber) * (2 * np.pi) ** 2 / grid.area
    noise = grid.forward(np.random.default_rng(seed).standard_normal(grid.shape))
    return grid, grid.inverse(noise / np.abs(noise) * np.sqrt(power))


def constant_in(bands: Bands) -> Callable[[Real], Real]:
    """C(|q|) of bands, zero outside."""
    edges, density = bands
    edges = edges * (1 - 1e-9)  # a mode that lies on an edge, as (1, 1) on that of the first band, belongs above it

    def value(q: Real) -> Real:
        ring = np.clip(np.searchsorted(edges, q, side="right") - 1, 0, density.size - 1)
        return np.where((q >= edges[0]) & (q < edges[-1]), density[ring], 0.0)

    return value


def isotropic_surface(
    lines: Real,
    length: float,
    *,
    periodic: bool = False,
    source: str = "array",
    steps: tuple[str, ...] = (),
    seed: int = 0,
) -> Topography:
    """A periodic random surface whose profiles have the spectrum of those that were scanned.

    Slope and curvature are right to 3 % for thirty lines and to about 10 % for one (docs/studies/index.md).

    Parameters
    ----------
    lines : heights in m, one profile of at least :data:`SHORTEST` points, or several in rows.
    length : of the profiles, in m.
    seed : of the random numbers.

    Raises TopographyError if there are too few points, or heights are missing or constant.
    """
    lines = np.atleast_2d(heights_of("lines", lines))
    flag("periodic", periodic)
    length = number("length", length, above=0)
    if lines.ndim != 2 or not len(lines):
        raise ArgumentError("lines", lines, "one profile, or several in rows")
    points = lines.shape[1]
    fault = f"points of the profile: {points}" if points < SHORTEST else fault_of(lines, (length,))
    if fault:
        msg = f"{source}: {fault}; the lines of a scan are at least {SHORTEST} heights, finite and not all the same"
        raise TopographyError(msg)
    spacing = length / points
    bands = surface_bands(*profile_spectrum(lines, spacing, periodic=periodic))
    n = min(points, LARGEST)
    grid, heights = random_surface(constant_in(bands), spacing, n, seed)
    count = f"{len(lines)} line{'s' if len(lines) > 1 else ''} of {points} points"
    told = f"{count}: an isotropic Gaussian surface of that spectrum, drawn on {n} x {n} points{_lacks(n, points)}"
    return Topography(heights, grid.lengths, True, source, (*steps, told), lines=len(lines), bands=bands)


def _lacks(drawn: int, points: int) -> str:
    """Note that a surface with fewer points than the measurement lacks its longest waves."""
    return f"; longer waves count, but are not drawn, of {points} points" if drawn < points else ""


def joined_spectrum(topographies: Sequence[Topography]) -> tuple[Real, Real, float]:
    """Wavenumbers and C of all measurements, and the factor by which they scatter where several overlap.

    A measurement is used from half its longest wavelength, as window and levelling affect longer waves, to half the
    highest wavenumber that it resolves; the largest one from its beginning, and the finest one to its end.
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
        # A band without power from lines, but for rounding, is taken as not measured.
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
    source : description of their origin.
    seed : of the random numbers.

    Raises TopographyError if there is no measurement, or their waves fill less than two bands.
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
        """A power law between two wavenumbers, with the last slope beyond; zero below the first band."""
        x = np.log(np.maximum(wavenumber, q[0] / 10))
        end = steps[1][-1] + (x - steps[0][-1]) * (steps[1][-1] - steps[1][-2]) / (steps[0][-1] - steps[0][-2])
        inside = np.where(x > steps[0][-1], end, np.interp(x, *steps))
        return np.where(wavenumber >= q[0] ** 2 / np.sqrt(q[0] * q[1]) * (1 - 1e-9), np.exp(inside), 0.0)

    spacing = min(max(one.grid.spacing) for one in topographies)
    longest = max(max(one.lengths) for one in topographies)
    points = max(round(longest / spacing), 16)
    n = min(points, MOST_POINTS)
    grid, heights = random_surface(density, spacing, n, seed)
    told = [
        f"{len(topographies)} measurements joined: an isotropic Gaussian surface of their spectrum, drawn on {n} x {n} "
        f"points{_lacks(n, points)}"
    ]
    first, last = q[0] ** 2 / np.sqrt(q[0] * q[1]), max(np.pi / spacing, q[-1])
    edges = np.geomspace(first, last, _FINE * max(2, round(np.log10(last / first) * BANDS_PER_DECADE)) + 1)
    bands = edges, density(np.sqrt(edges[1:] * edges[:-1]))
    if np.isfinite(scatter):
        told.append(f"where several have waves, their spectral densities differ by a factor of {scatter:.2g}")
    return Topography(heights, grid.lengths, True, source, tuple(told), bands=bands,
                      measurements=len(topographies))  # fmt: skip
