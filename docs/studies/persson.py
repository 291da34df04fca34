"""Persson's theory for a Gaussian surface of any spectrum, by quadrature: pressure, separation, gaps, weak adhesion.

Without adhesion the theory gives area, mean gap and distribution of gaps at a pressure.  Two theories of adhesion are
based on it: Persson and Scaraggi's for weak attraction, which acts on the gaps without adhesion, and Ciavarella's
bearing-area model, where it acts on the gaps of the undeformed surface.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Self

import numpy as np
import scipy

from continuum.theory.rough import Real

_NODES = 400
_T = np.geomspace(1e-8, 6.0, 2000)


def persson_area(pressure: float, rms_slope: float, contact_modulus: float = 1.0) -> float:
    """A/A0 = scipy.special.erf(sqrt(2) p/(h' E*)), without adhesion, at a mean pressure p.

    Persson, J. Chem. Phys. 115, 3840 (2001), with the variance of the pressure at full contact, (h' E*/2)².
    Exact at full contact; at small load about 20 % below simulation.
    """
    return float(scipy.special.erf(np.sqrt(2) * pressure / (rms_slope * contact_modulus)))


@dataclass(frozen=True, eq=False)
class PerssonContact:
    """A Gaussian surface whose spectrum is known at increasing wavenumbers; pressures are in E*.

    Parameters
    ----------
    wavenumber : q, increasing and above 0, from the longest wave to the shortest.
    spectrum : C(q) at these wavenumbers, with <h²> = 2π ∫ q C dq.
    gamma : part of the energy of full contact that a small area of contact stores, relative to its area; 0.45 in Yang
        and Persson, J. Phys.: Condens. Matter 20, 215214 (2008), from simulations; 1/2 in Ciavarella (2018).

    Raises ValueError if wavenumbers do not increase, or values are negative.
    """

    wavenumber: Real = field(repr=False)
    spectrum: Real = field(repr=False)
    gamma: float = 0.45

    def __post_init__(self) -> None:
        q, c = (np.asarray(one, dtype=np.float64) for one in (self.wavenumber, self.spectrum))
        if q.ndim != 1 or q.shape != c.shape or q.size < 2 or q[0] <= 0 or np.any(np.diff(q) <= 0) or np.any(c < 0):
            raise ValueError("a spectrum has wavenumbers that increase, and values that are not negative")
        if not 0 < self.gamma <= 1:
            raise ValueError(f"gamma lies between 0 and 1, got {self.gamma}")
        # Finer between the given ones, as powers of q, and evenly in ln q.
        fine = np.geomspace(q[0], q[-1], _NODES)
        with np.errstate(divide="ignore"):
            logs = np.interp(np.log(fine), np.log(q), np.log(np.maximum(c, np.finfo(float).tiny)))
        object.__setattr__(self, "wavenumber", fine)
        object.__setattr__(self, "spectrum", np.exp(logs))

    @classmethod
    def self_affine(
        cls, hurst: float, rms_slope: float, lambda_s: float, lambda_L: float, period: float, gamma: float = 0.45
    ) -> Self:
        """A self-affine surface as :class:`continuum.SelfAffine`: flat from the period to λ_L, then q^(-2-2H)."""
        q = np.geomspace(2 * np.pi / period, 2 * np.pi / lambda_s, _NODES)
        c = np.maximum(q, 2 * np.pi / lambda_L) ** (-2 - 2 * hurst)
        return cls(q, c * rms_slope**2 / (2 * np.pi * np.trapezoid(q**4 * c, np.log(q))), gamma)

    def _sums(self, power: int) -> Real:
        """2π ∫ q^(power + 1) C dq from the longest wave on, at each wavenumber."""
        q = self.wavenumber
        return 2 * np.pi * scipy.integrate.cumulative_trapezoid(q ** (power + 2) * self.spectrum, np.log(q), initial=0)

    @cached_property
    def rms_height(self) -> float:
        return float(np.sqrt(self._sums(0)[-1]))

    @cached_property
    def _squares(self) -> Real:
        """π ∫ q³ C dq from the longest wave on: 1/w²."""
        return self._sums(2) / 2

    @cached_property
    def _approach(self) -> tuple[Real, Real]:
        """Pressures, and the mean gap at each."""
        pressures = self.rms_slope * np.geomspace(1e-12, 3.0, 200)
        return pressures, np.array([self.separation(float(pressure)) for pressure in pressures])

    @cached_property
    def rms_slope(self) -> float:
        return float(np.sqrt(2 * self._squares[-1]))

    def area(self, pressure: float) -> float:
        """A/A0 at a mean pressure in E*."""
        return persson_area(pressure, self.rms_slope)

    def pressure(self, area: float) -> float:
        """Mean pressure in E* at an area A/A0, the inverse of :meth:`area`."""
        return float(scipy.special.erfinv(area) * self.rms_slope / np.sqrt(2))

    def separation(self, pressure: float) -> float:
        """Mean gap at a mean pressure in E*: Yang and Persson, J. Phys.: Condens. Matter 20, 215214 (2008).

        With W(P) = P [γ + (1 - γ) P²] the part of the energy of full contact that is stored in waves that have an area
        P in contact, p = -dU/du gives u = sqrt(π) ∫ q² C w G(w p) dq, w² = 1/(π ∫ q³ C dq) and
        G(x) = ∫ [γ + 3 (1 - γ) erf²(t)] exp(-t²)/t dt from x on.
        """
        return float(self._separations(pressure, 1)[0][0])

    def _separations(self, pressure: float, count: int = _NODES) -> tuple[Real, Real]:
        """Mean gap and apparent contact area at increasing resolution, the longest wave first."""
        q, squares = self.wavenumber, self._squares
        with np.errstate(divide="ignore"):
            areas = scipy.special.erf(pressure / np.sqrt(squares[:count]))
        areas[0] = 1.0
        # Of the waves between two wavenumbers: y = 1/w, in which the integrand is smooth, as q³ C dq = d(y²)/π.
        y = np.sqrt(np.maximum(squares[None, :] - squares[:count, None], 0))
        middle = np.maximum((y[:, 1:] + y[:, :-1]) / 2, np.finfo(float).tiny)
        x = pressure / areas[:, None] / middle
        # G(x): an exponential integral, and a bounded remainder from a table.
        bounded = 3 * (1 - self.gamma) * np.interp(x, _T, _rest(), right=0.0)
        gain = self.gamma * scipy.special.exp1(np.clip(x, 1e-150, 26.0) ** 2) / 2 + bounded
        terms = gain * np.diff(y) / np.sqrt(q[1:] * q[:-1])
        return 2 / np.sqrt(np.pi) * terms.sum(axis=1), areas

    def gaps(self, pressure: float) -> Callable[[Real], Real]:
        """Probability density of the gaps outside the contact at a mean pressure; its integral is the area outside.

        Almqvist, Campañá, Prodanov and Persson, J. Mech. Phys. Solids 59, 2355 (2011): the area that leaves contact
        between two magnifications has a mean gap (uA)'/A' and the roughness of all shorter waves.
        """
        means, areas = self._separations(pressure)
        lost = areas[:-1] - areas[1:]
        known = lost > 1e-15
        centre = np.divide(-np.diff(means * areas), lost, out=np.zeros_like(lost), where=known)[known]
        heights = self._sums(0)
        rough = np.sqrt(np.maximum(heights[-1] - (heights[:-1] + heights[1:]) / 2, 0))[known]
        share = lost[known] / np.sqrt(2 * np.pi) / rough

        def density(gap: Real) -> Real:
            u = np.asarray(gap, dtype=np.float64)[..., None]
            shape = np.exp(-(((u - centre) / rough) ** 2) / 2) + np.exp(-(((u + centre) / rough) ** 2) / 2)
            found: Real = (share * shape).sum(axis=-1)
            return found

        return density

    def weak_adhesion_threshold(self, area: float, tension: Callable[[Real], Real], reach: float) -> float:
        """Work of adhesion, in E*, at which the load at an area vanishes if attraction does not change the gaps.

        Persson and Scaraggi, J. Chem. Phys. 141, 124701 (2014), for hard bodies and weak attraction ("DMT limit").

        Parameters
        ----------
        area : A/A0 of the contact.
        tension : traction over the work of adhesion at gaps above 0, so that its integral is 1.
        reach : gap beyond which the tension vanishes, or is negligible.
        """
        # Denser at small gaps, where both functions vary most.
        x, weights = np.polynomial.legendre.leggauss(200)
        s = (x + 1) / 2
        gap, weights = reach * s**2, weights * reach * s
        pressure = self.pressure(area)
        return float(pressure / np.sum(weights * self.gaps(pressure)(gap) * tension(gap)))

    def bearing_area_threshold(self, reach: float) -> float:
        """Least work of adhesion, in E*, that is sticky in the bearing-area model, for any spectrum.

        Attraction as in :func:`continuum.theory.rough.bearing_area_limit`, a constant tension w/ε where the undeformed
        surface would be nearer than ε; repulsion by :meth:`separation` in full instead of its limit for large gaps, as
        Violano, Papangelo and Ciavarella (2021, arXiv 2012.07040) do for all fractal dimensions; ``reach`` is ε.
        """
        h, (pressures, gaps) = self.rms_height, self._approach

        def needed(gap: Real | float) -> Real:
            """Logarithm of the w at which attraction balances repulsion at a gap."""
            between = scipy.special.erfc((gap - reach) / h / np.sqrt(2)) - scipy.special.erfc(gap / h / np.sqrt(2))
            return np.asarray(np.interp(gap, gaps[::-1], np.log(pressures)[::-1]) + np.log(2 * reach / between))

        steps = np.linspace(gaps[-1], gaps[0], 200)
        best = int(np.argmin(needed(steps)))
        bounds = steps[max(best - 1, 0)], steps[min(best + 1, steps.size - 1)]
        return float(
            np.exp(scipy.optimize.minimize_scalar(lambda gap: float(needed(gap)), bounds=bounds, method="bounded").fun)
        )


@cache
def _rest() -> Real:
    """∫ erf²(t) exp(-t²)/t dt from each of the t in ``_T`` on."""
    values = (scipy.special.erf(_T) ** 2 * np.exp(-_T * _T))[::-1]
    rest: Real = -scipy.integrate.cumulative_trapezoid(values, np.log(_T)[::-1], initial=0)[::-1]
    return rest
