"""Roughness of a measured topography: moments, spectrum, dependence on the cut-off, self-affine fit, ISO parameters.

Lengths are in any one unit.  A periodic map has the spectral moments of :mod:`continuum.model.surface`.  A map that is
not periodic has steps at its edges, which are not roughness.  Its slope and curvature are therefore those of
differences between neighbouring points, which weigh all points alike; its spectrum is that of the map times a Hann
window of mean square 1.  That spectrum gives the share of each wavelength in a moment; the whole moment is that of the
map.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from continuum.inputs.arguments import ArgumentError, array, count, field_of, flag, instance, number, pair
from continuum.maps.map import Bands, Topography, means, once
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Moments, power_spectrum
from continuum.theory.rough import conformal_energy

BANDS_PER_DECADE = 12
"""Number of the logarithmic bands in which spectra are averaged."""
_FINE_PER_DECADE = 250
"""Finer bands per decade into which the bands of a spectrum are divided."""
MODEL_ERROR = 0.1
"""Relative deviation of a band from a power law that is taken as zero."""
EMPTY = 1e-3
"""Part of the peak of q⁴ C(q) below which bands beyond the peak are above the upper cut-off of the surface."""
LEVEL = -1.0
"""Smallest slope of the spectrum over its last octave that is called level: white noise has 0, and a surface of H = 0
has -2, or somewhat more if its points are no means over their pixels."""
EDGE = 0.05
"""Fall of a spectrum within two bands that marks its upper cut-off: a slope of -8, where H = 1 has -4."""


@dataclass(frozen=True)
class Cut:
    """Moments of the roughness of wavelengths above a cut-off."""

    wavelength: float
    """The cut-off, the resolution of an instrument that would measure these moments."""
    moments: Moments
    conformal_energy: float
    """Elastic energy per area of full contact, for E* = 1."""


@dataclass(frozen=True)
class Fit:
    """Self-affine spectrum C ~ q^(-2-2H) between two wavelengths, from a fit to the radial average."""

    hurst: float
    hurst_error: float
    """Standard error of the fit, without errors of the model or the instrument."""
    roll_off: float | None
    """λ_L, above which the spectrum is flat; None if the map shows no such wavelength."""
    cut_off: float | None
    """λ_s, below which the spectrum falls faster; None if it does not."""
    floor: float | None
    """Wavelength below which the spectrum falls less steeply, as noise does; None if it does not."""


@dataclass(frozen=True, eq=False)
class Roughness:
    """Statistics of one topography, or of two rough bodies together."""

    moments: Moments
    """Moments: spectral if the map is periodic; else the rms height of the map and differences of its points."""
    stencil: Moments
    """Slope and curvature from differences of neighbouring heights."""
    spectral: Moments
    """Slope and curvature from the spectrum; windowed if the map is not periodic."""
    conformal_energy: float
    """Elastic energy per area of full contact, for E* = 1."""
    wavenumber: Real = field(repr=False)
    """|q| of every mode, ascending."""
    shares: tuple[Real, Real, Real, Real] = field(repr=False)
    """Contribution of each mode to h², h'², h''² and the energy of full contact."""
    pixel: float
    """The larger spacing of the points."""
    size: float
    """The smaller side of the map."""

    @cached_property
    def _sums(self) -> tuple[Real, ...]:
        return tuple(np.cumsum(share) for share in self.shares)

    def cut(self, wavelength: float) -> Cut:
        wavelength = number("wavelength", wavelength, above=0)
        # One part in 1e9: a mode that lies on the cut-off belongs to the surface.
        count = int(np.searchsorted(self.wavenumber, 2 * np.pi / wavelength * (1 + 1e-9), "right"))
        height, slope, curvature, energy = (float(s[count - 1]) if count else 0.0 for s in self._sums)
        return Cut(wavelength, Moments(*(float(np.sqrt(m)) for m in (height, slope, curvature))), energy)

    def followed_by(self, tip: float) -> list[float]:
        """Shortest wavelength that a tip of a given radius follows: the roughness of all longer waves has half its
        curvature.

        h''_rms, the laplacian, is twice the mean curvature.
        """
        return [wave for wave in self.wavelengths if self.cut(wave).moments.rms_curvature < 1 / tip]

    @property
    def whole(self) -> Cut:
        """The roughness of all wavelengths of the map."""
        return self.cut(self.wavelengths[0])

    @property
    def wavelengths(self) -> list[float]:
        """Cut-offs from the shortest wavelength of the map to a quarter of its size, four per octave."""
        shortest = float(2 * np.pi / self.wavenumber[-1])
        octaves = np.log2(max(self.size / 4 / shortest, 1.0))
        return [float(wavelength) for wavelength in shortest * 2.0 ** np.arange(0, octaves + 1e-9, 0.25)]


def hann(shape: tuple[int, int]) -> Real:
    """Hann window of a map, a product of two, with a mean square of 1."""
    along, across = (np.sin(np.pi * (np.arange(count("shape", n)) + 0.5) / n) ** 2 for n in pair("shape", shape))
    return np.outer(along / np.sqrt(np.mean(along**2)), across / np.sqrt(np.mean(across**2)))


def windowed(topography: Topography) -> Real:
    """The heights for the Fourier transform: windowed unless periodic, with mean zero."""
    heights = topography.heights
    window = 1.0 if topography.periodic else hann(topography.grid.shape)
    level: Real = heights - np.mean(window * heights) / np.mean(window)
    return window * level


@once
def spectrum(topography: Topography) -> tuple[Real, Real]:
    """Radially averaged power spectral density (:func:`continuum.model.surface.power_spectrum`), up to Nyquist.

    Returns wavenumbers and C(q); h_rms² = ∫ C d²q.
    """
    if (bands := topography.bands) is not None:
        edges, c = _fine(bands)
        return np.sqrt(edges[1:] * edges[:-1])[c > 0], c[c > 0]
    q, c = power_spectrum(topography.grid, windowed(topography))
    # Rings beyond lie only partly in the Brillouin zone.
    whole = q <= np.pi / max(topography.grid.spacing)
    return q[whole], c[whole]


def stencil_moments(grid: Grid, heights: Real, periodic: bool) -> Moments:
    """Moments from differences of neighbours (slope), and of a point and its four neighbours (curvature).

    Differences underestimate wavelengths near two points: they agree with the spectrum if these do not matter.
    """
    heights = field_of("heights", heights, instance("grid", grid, Grid).shape)
    if flag("periodic", periodic):
        heights = np.pad(heights, 1, mode="wrap")
    dx, dy = grid.spacing

    def squares(part: Real) -> tuple[Real]:
        return ((np.diff(part, 2, axis=0)[:, 1:-1] / dx**2 + np.diff(part, 2, axis=1)[1:-1] / dy**2) ** 2,)

    (along_x,) = means(heights, lambda part: ((np.diff(part, axis=0) / dx) ** 2,), 1)
    (along_y,) = means(heights, lambda part: ((np.diff(part, axis=1) / dy) ** 2,))
    (bend,) = means(heights, squares, 2)
    inner = heights[1:-1, 1:-1] if periodic else heights
    return Moments(float(inner.std()), float(np.sqrt(along_x + along_y)), float(np.sqrt(bend)))


def _fine(bands: Bands) -> Bands:
    """The spectrum in bands of less than a per cent, so that a cut-off falls between two of them."""
    edges, density = bands
    parts = np.maximum(np.ceil(np.diff(np.log10(edges)) * _FINE_PER_DECADE).astype(np.int64), 1)
    inner = [np.geomspace(a, b, n + 1)[:-1] for a, b, n in zip(edges[:-1], edges[1:], parts, strict=True)]
    return np.concatenate([*inner, edges[-1:]]), np.repeat(density, parts)


def _roughness_of_bands(bands: Bands, topography: Topography) -> Roughness:
    """Statistics of a spectrum from lines or several measurements: integrals over its bands."""
    edges, density = _fine(bands)

    def share(exponent: int) -> Real:
        """Contribution of each band to ∫ q^exponent C d²q."""
        return 2 * np.pi * density * np.diff(edges ** (exponent + 2)) / (exponent + 2)

    height, slope, curvature, energy = share(0), share(2), share(4), share(1) / 4
    whole = Moments(*(float(np.sqrt(one.sum())) for one in (height, slope, curvature)))
    stencil = stencil_moments(topography.grid, topography.heights, topography.periodic)
    return Roughness(
        whole, stencil, whole, float(energy.sum()), np.sqrt(edges[1:] * edges[:-1]),
        (height, slope, curvature, energy), max(topography.grid.spacing), topography.extent,
    )  # fmt: skip


def _energy_of_mirrored(topography: Topography) -> float:
    """Energy of full contact of a map with its mirror images, for E* = 1: a cosine transform of the map itself.

    A window would reduce the longest waves, which carry the energy; mirror images keep them.
    """
    heights = topography.heights - topography.heights.mean()
    amplitude = scipy.fft.dctn(heights, norm="ortho", overwrite_x=True)
    qx, qy = (np.pi * np.arange(n) / length for n, length in zip(heights.shape, topography.lengths, strict=True))
    # Row by row, as they are in the cache.
    energies = [conformal_energy(np.hypot(x, qy), row**2) for x, row in zip(qx, amplitude, strict=True)]
    return sum(energies) / topography.heights.size


@once
def roughness_of(topography: Topography) -> Roughness:
    """Statistics of a detrended topography."""
    if (bands := topography.bands) is not None:
        return _roughness_of_bands(bands, topography)
    grid, heights = topography.grid, topography.heights
    amplitude = grid.forward(windowed(topography))
    power_q = (amplitude.real**2 + amplitude.imag**2) * grid.mode_weights
    q = grid.wavenumber.ravel()
    order = np.argsort(q)[1:]  # q = 0 is a mean, not roughness
    wavenumber, power = q[order], power_q.ravel()[order]
    stencil = stencil_moments(grid, heights, topography.periodic)
    square = wavenumber * wavenumber
    weights = power, square * power, square * square * power, wavenumber * power
    sums = [float(np.sum(one)) for one in weights]
    spectral = Moments(*np.sqrt(sums[:3]).tolist())
    whole = spectral if topography.periodic else stencil
    energy = conformal_energy(wavenumber, power) if topography.periodic else _energy_of_mirrored(topography)

    totals = *(moment**2 for moment in whole), energy
    height, slope, curvature, elastic = (
        one * (total / of) for one, total, of in zip(weights, totals, sums, strict=True)
    )
    return Roughness(
        whole, stencil, spectral, energy, wavenumber, (height, slope, curvature, elastic),
        max(grid.spacing), min(grid.lengths),
    )  # fmt: skip


def together(first: Roughness, second: Roughness) -> Roughness:
    """Two rough bodies as one: for uncorrelated heights the spectra, and so the squared moments, add."""
    instance("first", first, Roughness)
    instance("second", second, Roughness)
    wavenumber = np.concatenate([first.wavenumber, second.wavenumber])
    order = np.argsort(wavenumber, kind="stable")
    a, b, c, d = (np.concatenate(pair)[order] for pair in zip(first.shares, second.shares, strict=True))
    kinds = ((one.moments, one.stencil, one.spectral) for one in (first, second))
    whole, stencil, spectral = (Moments(*np.hypot(*both).tolist()) for both in zip(*kinds, strict=True))
    return Roughness(
        whole, stencil, spectral, first.conformal_energy + second.conformal_energy, wavenumber[order], (a, b, c, d),
        max(first.pixel, second.pixel), min(first.size, second.size),
    )  # fmt: skip


def fit_self_affine(wavenumber: Real, density: Real) -> Fit | None:
    """Fit a flat part, a power law and a part of another slope to a radially averaged spectrum in logarithmic bands.

    The two corners minimise the squared deviations; each is kept only if Schwarz's criterion improves.  None if fewer
    than six bands are filled, or no power law with positive H fits.
    """
    wavenumber, density = array("wavenumber", wavenumber), array("density", density)
    if wavenumber.ndim != 1 or not np.all(np.diff(wavenumber, prepend=0.0) > 0):
        raise ArgumentError("wavenumber", wavenumber, "positive numbers in ascending order")
    if density.shape != wavenumber.shape:
        raise ArgumentError("density", density, f"one for each wavenumber, {wavenumber.size} numbers")
    x, y, weight = _bands(wavenumber, density)
    if x.size < 6:
        return None
    best: tuple[float, float, Real, Real, float, float] | None = None
    # A corner at the end of the data does not count; at least three bands lie on the power law.
    for low in (-np.inf, *x[1:-3].tolist()):
        for high in (*x[3:-1].tolist(), np.inf):
            if np.count_nonzero((x >= low) & (x <= high)) < 3:
                continue
            columns = [np.ones_like(x), np.clip(x, low, high)]
            columns += [np.maximum(x - high, 0.0)] if np.isfinite(high) else []
            design = np.stack(columns, axis=1) * weight[:, None]
            found = np.asarray(np.linalg.lstsq(design, y * weight, rcond=None)[0], dtype=np.float64)
            if found[1] >= -2:  # H would be negative, which no surface has
                continue
            if found.size > 2 and -4 <= found[2] <= -2:  # 0 < H < 1 again: neither a cut-off nor a floor
                continue
            rest = float(np.sum((y * weight - design @ found) ** 2)) + 1e-300
            parameters = found.size + bool(np.isfinite(low)) + bool(np.isfinite(high))
            score = float(x.size * np.log(rest / x.size) + parameters * np.log(x.size))
            if best is None or score < best[0]:
                best = (score, rest / max(x.size - parameters, 1), found, design, low, high)
    if best is None:
        return None
    _, variance, found, design, low, high = best
    end = float(2 * np.pi / 10**high) if np.isfinite(high) else None
    steeper = end is not None and found[2] < found[1]
    # Empty bands also mark a cut-off, in the partly filled band where C falls to EDGE.
    filled = wavenumber[density >= EDGE * 10 ** y[-1]]
    last = float(2 * np.pi / filled[-1]) if 10 ** x[-1] < 0.8 * wavenumber[-1] else None
    return Fit(
        hurst=float(-found[1] / 2 - 1),
        hurst_error=float(np.sqrt(np.linalg.inv(design.T @ design)[1, 1] * variance) / 2),
        roll_off=float(2 * np.pi / 10**low) if np.isfinite(low) else None,
        cut_off=end if steeper else last,
        floor=None if steeper else end,
    )


def level_floor(wavenumber: Real, density: Real) -> float | None:
    """Wavelength from which a radially averaged spectrum is level to its end, as white noise is; None if it is not.

    It begins where the spectrum is last twice as high as in its last octave.
    """
    octave = (wavenumber >= wavenumber[-1] / 2) & (density > 0) if wavenumber.size else np.array([], dtype=bool)
    if np.count_nonzero(octave) < 2:
        return None
    q, c = np.log(wavenumber[octave]), np.log(density[octave])
    if not np.polyfit(q, c, 1)[0] > LEVEL:
        return None
    higher = np.flatnonzero(density > 2 * np.exp(c.mean()))
    return float(2 * np.pi / wavenumber[higher[-1] if higher.size else 0])


def _bands(wavenumber: Real, density: Real) -> tuple[Real, Real, Real]:
    """Decimal logarithms of q and C averaged over bands, and weights, without bands beyond the cut-off."""
    if not wavenumber.size:
        return wavenumber, density, wavenumber
    band = np.floor(np.log10(wavenumber / wavenumber[0]) * BANDS_PER_DECADE + 0.5).astype(np.int64)
    count = np.bincount(band)
    filled = count > 0
    q, c = (np.bincount(band, weights=values)[filled] / count[filled] for values in (wavenumber, density))
    flow = q**4 * c
    peak = int(np.argmax(flow))
    empty = np.flatnonzero(flow[peak:] < EMPTY * flow[peak])
    # Beyond an edge of the spectrum are only residues of windows and filled points.
    edge = np.flatnonzero(c[2:] < EDGE * c[:-2])
    # The band in which the spectrum ends is only partly filled.
    end = min(peak + int(empty[0]) - 1 if empty.size else q.size, int(edge[0]) + 1 if edge.size else q.size)
    # The mean square of n Gaussian modes scatters by 2/n; no power law holds better than MODEL_ERROR.
    modes = np.bincount(band, weights=np.pi * wavenumber / wavenumber[0])[filled]
    weight = 1 / np.sqrt(2 / modes + MODEL_ERROR**2)
    kept = np.flatnonzero(c[:end] > 0)
    return np.log10(q[kept]), np.log10(c[kept]), weight[kept]


class ArealParameters(NamedTuple):
    """Parameters of the whole map, without the filters of the standard; lengths in the unit of the map."""

    Sq: float
    """Root mean square height."""
    Sa: float
    """Arithmetic mean height."""
    Sz: float
    """Maximum height: from the lowest to the highest point."""
    Ssk: float
    """Skewness of the heights."""
    Sku: float
    """Kurtosis of the heights: 3 for a Gaussian surface."""
    Sdq: float
    """Root mean square gradient."""
    Sdr: float
    """Developed area over the projected one, less one."""


@once
def areal_parameters(topography: Topography) -> ArealParameters:
    """The parameters of a map; gradients and areas are those of the triangles between neighbouring points.

    Raises ArgumentError if it is no topography.
    """
    heights = topography.heights
    z = heights - heights.mean()

    def powers(part: Real) -> tuple[Real, ...]:
        square = part * part
        return square, np.abs(part), square * part, square * square

    def gradients(part: Real) -> tuple[Real, Real]:
        """Squared gradients of two triangles between four points, each with an edge along x and one along y; areas."""
        along_x, along_y = (np.square(np.diff(part, axis=axis) / topography.grid.spacing[axis]) for axis in (0, 1))
        squares = np.concatenate([along_x[:, :-1] + along_y[:-1], along_x[:, 1:] + along_y[1:]])
        return squares, np.sqrt(1 + squares) - 1

    (square, mean, third, fourth), (gradient, area) = means(z, powers), means(z, gradients, 1)
    rms = float(np.sqrt(square))
    return ArealParameters(
        Sq=rms,
        Sa=float(mean),
        Sz=float(np.ptp(z)),
        Ssk=float(third) / rms**3,
        Sku=float(fourth) / rms**4,
        Sdq=float(np.sqrt(gradient)),
        Sdr=float(area),
    )
