"""What a map does not show: waves shorter than it resolves, and the rest of the surface from which it was cut.

**Shorter waves.**  A map ends at two of its pixels, at its cut-off, where noise begins, or where its tip is too blunt.
Below, the spectrum is continued as the self-affine fit to the measurement, C ~ q^(-2-2H), to a smallest wavelength.  If
the fit finds a cut-off of the surface above the end of the map, nothing is missing.

**The rest of the surface**, or the sampling error of a threshold.  A spot of a surface has its own summits.  Its state
is cut into blocks of one roll-off length, which are nearly independent samples of the surface.  Block b has the load
N_b, the attraction T_b = <τ>_b and the contact area A_b, per its own area.  The threshold at a given area is w_c = N/T,
which changes with the area as A^s, where s is known from a second state.  At the area of the map, to first order in its
blocks::

    ln w_c = ln w + mean of e_b,    e_b = N_b/N - T_b/T - s A_b/A

so that the scatter of e_b over the root of their number is the standard error.  Waves longer than the map are not in
it: without a roll-off inside the map nothing is known of the surface.  Stated and tested in docs/studies/spots.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from continuum.maps.faults import SMOOTHEST
from continuum.maps.map import Topography
from continuum.maps.roughness import Roughness, fit_self_affine, spectrum
from continuum.maps.verdict.criteria import RoughContact
from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.path.threshold import PressedState

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
FEWEST_BLOCKS = 16
"""Blocks that a map needs: four roll-off lengths along each side.  Of fewer a fit also finds some where there are none,
by chance of the longest waves (docs/studies/spots.md)."""
FLOOR = 0.03
"""Relative error that is added in quadrature, of the area and of what the blocks share."""
WHOLE = 0.15
"""Part of a block that may be missing at the end of a map: a fitted roll-off is known to a band of its spectrum."""
ERRORS, CONFIDENCE = 2.0, 0.95
"""Standard errors of an interval, and how often it holds."""


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


class Blocks(NamedTuple):
    """Numbers of blocks, one roll-off length long, along each side of a map."""

    nx: int
    ny: int

    @property
    def enough(self) -> bool:
        """True if they tell a sampling error."""
        return self.nx * self.ny >= FEWEST_BLOCKS

    @classmethod
    def of(cls, lengths: tuple[float, float], roll_off: float) -> "Blocks":
        """Blocks of a map, at least one along each side."""
        nx, ny = (max(1, int(length / roll_off + WHOLE)) for length in lengths)
        return cls(nx, ny)

    def means(self, values: Real) -> Real:
        """Means of a field over each block, shape (nx, ny)."""
        for axis, count in enumerate(self):
            edges = np.rint(np.linspace(0, values.shape[axis], count + 1)).astype(int)
            sizes = np.diff(edges).reshape((-1, 1) if axis == 0 else (1, -1))
            values = np.add.reduceat(values, edges[:-1], axis) / sizes
        return values


def sampling_error(
    state: PressedState, beside: PressedState, wall: Wall, shape: tuple[int, int], blocks: Blocks
) -> float:
    """Standard error of the logarithm of w_c, as of another spot of the same size; NaN without enough blocks.

    Two such errors hold the threshold of the surface with 95 %: where blocks are few the error is that of Student.

    Parameters
    ----------
    state, beside : of the map at its area, and at another one.
    wall : the law.
    shape : points of the map itself, without its mirror images.
    blocks : of one roll-off length each.
    """
    if not blocks.enough or min(shape[0] // blocks.nx, shape[1] // blocks.ny) < 1:
        return np.nan
    pull, load, area = _fields(state, wall)
    ratios = [np.log(one.load / one.grid.mean(tau)) for one, tau in ((state, pull), (beside, _fields(beside, wall)[0]))]
    slope = (ratios[0] - ratios[1]) / np.log(state.area_rep / beside.area_rep)
    own = np.s_[: shape[0], : shape[1]]
    parts = [blocks.means(field[own]) / field.mean() for field in (load, pull, area)]
    scatter = parts[0] - parts[1] - slope * parts[2]
    student = float(scipy.special.stdtrit(scatter.size - 1, (1 + CONFIDENCE) / 2)) / ERRORS
    return float(np.hypot(student * scatter.std(ddof=1) / np.sqrt(scatter.size), FLOOR))


def _fields(state: PressedState, wall: Wall) -> tuple[Real, Real, Real]:
    """Attraction per work, pressure, and contact of each point."""
    return state.attraction(wall)[0], np.maximum(-state.distance, 0.0), state.contact.astype(np.float64)
