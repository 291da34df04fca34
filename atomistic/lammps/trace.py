"""Traces and windows: what LAMMPS wrote every few steps or as an average, means, standard errors, drift and scatter."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, Self

import numpy as np
import scipy

from atomistic.lammps.protocol import BLOCKS
from continuum.inputs.arguments import ArgumentError, choice, number
from continuum.model.fourier import Real

RARE = 0.01
"""Probability below which drift or scatter is significant."""


@dataclass(frozen=True, eq=False)
class WallTrace(Mapping[str, Real]):
    """Samples of a wall in a script, by name: lengths in Å, forces in nN, energies in eV, temperatures in K.

    Shape (samples,) each.  ``distance`` is that of the lowest point of the wall from the surface at rest; ``load`` is
    positive in compression, ``lateral_x`` the force of the wall on the atoms, ``pull_x`` that of a spring on the wall;
    ``taken_by_wall`` is what a wall that moves by its load took from the atoms.
    """

    columns: Mapping[str, Real] = field(repr=False)

    def __getitem__(self, name: str) -> Real:
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.columns["step"])

    def after(self, step: float) -> Self:
        """The samples after a time step, as when the wall has come to rest or slides steadily."""
        late = self.columns["step"] > number("step", step)
        return type(self)({name: values[late] for name, values in self.columns.items()})

    def mean(self, name: str) -> tuple[float, float]:
        """Mean of a quantity and its standard error, of as many samples as make whole blocks, up to the last.

        Raises ArgumentError if there is no such quantity, or there are fewer samples than two for each block.
        """
        return mean_and_error(self._whole(choice("name", name, self.columns)))

    def friction(self, along: Literal["x", "y"] = "x") -> tuple[float, float]:
        """Friction coefficient, mean friction over mean load, and its standard error.

        Raises ArgumentError as :meth:`mean`, or if the mean load is zero.
        """
        drag, load = (self._whole(name) for name in (f"lateral_{choice('along', along, ('x', 'y'))}", "load"))
        mean = float(load.mean())
        if not mean:
            raise ArgumentError("load", mean, "a load, which friction is divided by")
        ratio = float(drag.mean()) / mean
        return ratio, mean_and_error(drag - ratio * load)[1] / abs(mean)

    def _whole(self, name: str) -> Real:
        count = self.samples // BLOCKS * BLOCKS
        if count < 2 * BLOCKS:
            raise ArgumentError("samples", self.samples, f"at least {2 * BLOCKS}, for means and their errors")
        return self.columns[name][self.samples - count :]


def trace_of(path: Path) -> WallTrace:
    """The trace that a wall in a script has written; a last line that is not whole yet does not count.

    Raises ValueError if the file is none.
    """
    with path.open(encoding="utf-8") as file:
        names = _names(file)
        rows = [line.split() for line in file if line.endswith("\n")]
    if not {"step", "load"} <= {*names} or not rows:
        raise ValueError("it is not the trace of a wall, or has no samples yet")
    values = np.array(rows, np.float64)
    if values.shape[1] != len(names) or not np.isfinite(values).all():
        raise ValueError("it has numbers that are not finite, or lines of another length")
    return WallTrace(dict(zip(names, values.T.copy(), strict=True)))


def _names(file: Iterator[str]) -> list[str]:
    """Names of columns, from the second line."""
    return [next(file, "") for _ in range(2)][1].split()[1:]


def trace_of_window(path: Path) -> dict[str, Real]:
    """Columns of a ``trace.N.txt`` by the names in its second line, shape (samples,).

    Raises ValueError if it has other columns, or no whole blocks of samples.
    """
    with path.open(encoding="utf-8") as file:
        names = _names(file)
    rows = np.loadtxt(path, ndmin=2)
    rows = rows[rows[:, 0] > 0]  # the state where the window begins is the end of the one before
    if rows.shape[1] != len(names) or len(rows) % BLOCKS or not len(rows):
        raise ValueError(f"{path} does not hold the samples of a whole window")
    if not np.isfinite(rows).all():
        raise ValueError("it has numbers that are not finite: check separation and start")
    return dict(zip(names, rows.T.copy(), strict=True))


def mean_and_error(samples: Real) -> tuple[float, float]:
    """Mean of samples, shape (n,), and its standard error, from the means of :data:`BLOCKS` blocks about their line.

    With b the means of the blocks and t their distances from the middle, the variance about the line is
    <b²> - <b>² - <b t>²/<t²>, <t²> = (BLOCKS² - 1)/12, of which BLOCKS - 2 degrees of freedom are left.
    """
    block = np.reshape(samples, (BLOCKS, -1)).mean(axis=1)
    mean = float(block.mean())
    t = np.arange(BLOCKS) - (BLOCKS - 1) / 2
    rest = float(np.mean((block - mean) ** 2) - np.mean((block - mean) * t) ** 2 / np.mean(t**2))
    return mean, float(np.sqrt(max(rest, 0.0) / (BLOCKS - 2)))


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
