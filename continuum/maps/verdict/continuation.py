"""Continuation of the spectrum to atomic wavelengths, below the shortest wave that a map shows.

A map ends at two of its pixels, at its cut-off, where noise begins, or where its tip is too blunt.  Below, the
spectrum is continued as the self-affine fit to the measurement, C ~ q^(-2-2H), to a smallest wavelength.  If the fit
finds a cut-off of the surface above the end of the map, nothing is missing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from continuum.maps.faults import SMOOTHEST
from continuum.maps.map import Topography
from continuum.maps.roughness import Roughness, fit_self_affine, spectrum
from continuum.maps.verdict.criteria import RoughContact
from continuum.model.fourier import Real

OWN = 1.25
"""Factor to the shortest measured wave above which a cut-off belongs to the surface, and not to the map."""
_LEVEL = 4.0
"""Range of wavenumbers, as a factor below the last measured one, over which the level of the spectrum is averaged."""
_FEWEST = 8
"""Smallest number of waves of a spectrum for a power law."""
_END = 8.0
"""Range of wavenumbers, as a factor below the last one, whose power law is continued if none fits the whole
spectrum."""
_FLAT = 1e-9
"""Exponent below which it is taken as zero, so that an integral is a logarithm."""


@dataclass(frozen=True, eq=False)
class Tail:
    """Spectrum of one body below its shortest measured wavelength."""

    roughness: Roughness
    measured: float
    """Shortest measured wavelength of the map."""
    hurst: float | None
    """Exponent of the continuation; None if the surface has a cut-off above, so that nothing is missing."""
    level: float
    """C q^(2+2H) of the continuation."""

    def squares(self, wavelength: float) -> Real:
        """h², h'², h''² and the energy of full contact for E* = 1, of all waves above a wavelength."""
        cut = self.roughness.cut(max(self.measured, wavelength))
        known: Real = np.array([*np.square(cut.moments), cut.conformal_energy])
        if self.hurst is None or wavelength >= self.measured:
            return known
        ends = np.array([2 * np.pi / self.measured, 2 * np.pi / wavelength])

        def integral(exponent: float) -> float:
            """∫ q^exponent C d²q over the continuation."""
            power = exponent - 2 * self.hurst if self.hurst is not None else exponent
            inside = np.log(ends[1] / ends[0]) if abs(power) < _FLAT else float(np.diff(ends**power)[0]) / power
            return float(2 * np.pi * self.level * inside)

        more: Real = np.array([integral(0), integral(2), integral(4), integral(1) / 4])
        return known + more


@dataclass(frozen=True, eq=False)
class Continuation:
    """A contact with the roughness that was not measured."""

    measured: float
    """Wavelength below which nothing was measured, the larger of both maps."""
    smallest: float
    """Wavelength to which the spectrum is continued."""
    tails: tuple[Tail, ...]

    @property
    def hursts(self) -> tuple[float, ...]:
        """Exponents of the bodies that are continued."""
        return tuple(tail.hurst for tail in self.tails if tail.hurst is not None)

    def contact(self, known: RoughContact, wavelength: float | None = None) -> RoughContact:
        """A contact with the roughness of all waves above a wavelength, by default the smallest."""
        wavelength = self.smallest if wavelength is None else wavelength
        total = np.sum([tail.squares(wavelength) for tail in self.tails], axis=0)
        height, slope, curvature = np.sqrt(total[:3]).tolist()
        energy = float(total[3]) * known.contact_modulus
        return replace(known, rms_height=height, rms_slope=slope, rms_curvature=curvature, conformal_energy=energy)


def continuation_of(
    topographies: Sequence[Topography],
    analysed: Sequence[Roughness],
    smallest: float,
    tip: float | None = None,
) -> Continuation | None:
    """Continue the spectra to a smallest wavelength; None if nothing is missing, or no power law was measured.

    Parameters
    ----------
    topographies, analysed : the maps and their roughness.
    smallest : smallest wavelength, in the unit of the maps.
    tip : radius of the tip that measured the maps.
    """
    tails = [_tail(one, mine, tip) for one, mine in zip(topographies, analysed, strict=True)]
    missing = [tail.measured for tail in tails if tail is not None and tail.hurst is not None]
    if any(tail is None for tail in tails) or not missing or max(missing) <= smallest:
        return None
    return Continuation(max(missing), smallest, tuple(tail for tail in tails if tail is not None))


def _tail(topography: Topography, roughness: Roughness, tip: float | None) -> Tail | None:
    """The continuation of one body; None if no power law fits the measurement."""
    end = max(2 * roughness.pixel, topography.cutoff or 0.0, 0.0 if tip is None else sharpest_wave(roughness, tip))
    q, c = spectrum(topography)
    seen = q <= 2 * np.pi / end * (1 + 1e-9)
    q, c = q[seen & (c > 0)], c[seen & (c > 0)]
    if q.size < _FEWEST:
        return None
    fit = fit_self_affine(q, c)
    if fit is None:
        # If no power law fits the whole, that of the last waves.
        last = q >= q[-1] / _END
        exponent = float(np.polyfit(np.log(q[last]), np.log(c[last]), 1, w=np.sqrt(q[last]))[0])
        hurst, own = -exponent / 2 - 1, False
    else:
        hurst, own = fit.hurst, fit.cut_off is not None and fit.cut_off > OWN * end
        end = max(end, fit.floor or 0.0)
    if own or hurst > SMOOTHEST:
        return Tail(roughness, end, None, 0.0)
    hurst = float(np.clip(hurst, 0.0, 1.0))
    last = (q >= 2 * np.pi / end / _LEVEL) & (q <= 2 * np.pi / end * (1 + 1e-9))
    if not last.any():
        return None
    level = float(np.exp(np.mean(np.log(c[last]) + (2 + 2 * hurst) * np.log(q[last]))))
    return Tail(roughness, end, hurst, level)


def sharpest_wave(roughness: Roughness, tip: float) -> float:
    """The shortest wavelength that a tip of a given radius follows; 0 if it follows all."""
    waves, followed = roughness.wavelengths, roughness.followed_by(tip)
    return 0.0 if followed == waves else next(iter(followed), waves[-1])
