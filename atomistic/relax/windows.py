"""Means over the time windows of a motion, and tests of drift and scatter."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy

from atomistic.lammps.protocol import BLOCKS
from continuum.model.fourier import Real

RARE = 0.01
"""Probability below which drift or scatter is significant."""


@dataclass(frozen=True)
class WindowMean:
    """Mean of a quantity over time windows, in its unit."""

    mean: float
    error: float
    """Standard error: from the blocks within the windows, or from the scatter of the windows and their correlation,
    whichever is larger."""
    count: int
    """Number of windows."""
    drift: float
    """Change of the fitted straight line from the first window to the last; zero for fewer than three."""
    drifts: bool
    """True if windows of a steady state drift as much with a probability below :data:`RARE`."""
    scatter: float
    """Scatter of the windows about their mean, over their own standard errors; 1 is expected."""
    scatters: bool
    """True if windows of a steady state scatter as much with a probability below :data:`RARE`."""

    @classmethod
    def of(cls, values: Real, errors: Real) -> Self:
        """Mean of windows of equal duration.

        Parameters
        ----------
        values, errors : mean of each window and its standard error, shape (windows,), each from :data:`BLOCKS` blocks
            about their straight line.
        """
        values, errors = np.asarray(values, dtype=np.float64), np.asarray(errors, dtype=np.float64)
        count, within = len(values), float(np.mean(errors**2))
        mean, error = float(np.mean(values)), float(np.sqrt(within / count))
        if count < 2 or np.ptp(values) == 0:
            return cls(mean, error, count, 0.0, False, 1.0, False)
        among = float(np.var(values, ddof=1))
        # Two estimates of one variance, with count - 1 degrees of freedom, and with BLOCKS - 2 in each window.
        rare = within == 0 or float(scipy.special.fdtrc(count - 1, (BLOCKS - 2) * count, among / within)) < RARE
        drift, drifts = 0.0, False
        if count > 2:
            line = scipy.stats.linregress(np.arange(count), values)
            drift, drifts = float(line.slope * (count - 1)), bool(line.pvalue < RARE)
        scatter = float(np.sqrt(among / within)) if within else np.inf
        return cls(mean, max(error, correlated_error(values)), count, drift, drifts, scatter, rare)

    @classmethod
    def of_ratio(cls, over: Real, over_errors: Real, under: Real, under_errors: Real) -> Self:
        """Ratio r of the means of two quantities, as a friction coefficient, over windows of equal duration.

        To first order, the error of r is that of the mean of over - r under, divided by the mean of under: by the
        standard errors of the windows, propagated as independent ones (JCGM 100:2008, 5.1.2), or by the scatter of
        over - r under among the windows (W. G. Cochran, Sampling Techniques, 3rd ed., section 2.11), whichever is
        larger.  Drift and scatter are also those of over - r under.

        Parameters
        ----------
        over, over_errors, under, under_errors : mean of each window and its standard error, shape (windows,).

        Raises ValueError if the mean of ``under`` is within three standard errors of zero: the first order is not
        valid there.
        """
        below = cls.of(under, under_errors)
        if not abs(below.mean) > 3 * below.error:
            raise ValueError(f"no ratio to what may be zero: {below.mean:.3g} ± {below.error:.1g}")
        ratio = float(np.mean(over)) / below.mean
        rest = cls.of(
            np.asarray(over) - ratio * np.asarray(under), np.hypot(over_errors, ratio * np.asarray(under_errors))
        )
        size = abs(below.mean)
        return replace(rest, mean=ratio, error=rest.error / size, drift=rest.drift / below.mean)

    @property
    def doubts(self) -> str:
        """Warnings about drift and scatter, in sentences; empty if there are none."""
        found = []
        if self.drifts:
            found.append(f"It drifts by {self.drift:.2g} from the first window to the last: not yet at rest.")
        if self.scatters:
            found.append(
                f"Windows scatter by {self.scatter:.1f} times their standard errors: what is correlated lasts longer "
                "than a tenth of a window, so that longer windows are needed."
            )
        return " ".join(found)


def correlated_error(values: Real) -> float:
    """Standard error of the mean of a series whose values may be correlated, shape (n,), n of 2 or more.

    The statistical inefficiency is g = 1 + 2 Σ (1 - k/n) ρ_k, and the variance of the mean γ_0 g/n.  The sum ends
    before the first ρ_k that is not above n^(-1/2), which is the error of one without correlation.  Covariances about
    the mean of the series itself are too small by the variance of that mean, which is added until it is the one found
    (A. M. Ferrenberg, D. P. Landau and K. Binder, J. Stat. Phys. 63, 867 (1991)); at most half of the values are one.
    """
    n = len(values)
    away, lags = values - np.mean(values), np.arange(n)
    lagged = np.correlate(away, away, "full")[n - 1 :] / n
    variance = lagged[0] / (n - 1)  # of the mean of independent values
    for _ in range(100):
        covariance = lagged + variance * (1 - lags / n)
        rho = covariance / covariance[0]  # with the factor 1 - k/n
        end = 1 + int(np.argmin(np.append(rho[1:], -1.0) > n**-0.5))
        before, inefficiency = variance, min(1 + 2 * float(rho[1:end].sum()), n / 2)
        variance = lagged[0] * inefficiency / (n - inefficiency)
        if abs(variance - before) <= 1e-3 * variance:  # far below its own error, (2/n)^(1/2) of it
            break
    return float(np.sqrt(variance))


def errors_of_one_state(values: Real, errors: Real) -> Real:
    """Standard errors of windows of one state: by their scatter where it is more than their own errors explain.

    What is correlated for longer than a tenth of a window is not seen by the blocks within it.

    Parameters
    ----------
    values, errors : as of :meth:`WindowMean.of`.
    """
    if len(values) < 2 or not WindowMean.of(values, errors).scatters:
        return errors
    return np.maximum(errors, np.std(values, ddof=1))


@dataclass(frozen=True)
class EnergyBalance:
    """Energy that atoms and wall got over time windows, over A0, in E* a0."""

    along: float
    """Work of the wall as it slid."""
    up: float
    """Work of the wall as it moved up or down; of a wall that keeps a load, the work of that load."""
    taken: float
    """Energy that a wall that keeps a load took, beyond that work, by its drag less its noise; else zero."""
    taken_error: float
    """Standard error of the work taken, by the scatter of the windows; infinite for a single one."""
    heat: float
    """Heat from the thermostat."""
    kept: float
    """Change of the energy of atoms and wall, with their motion."""

    @property
    def left(self) -> float:
        """Error of the time steps and of the sampling of forces: the energy kept, less all that was got."""
        return self.kept - (self.along + self.up - self.taken + self.heat)
