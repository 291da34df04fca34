"""The law of stickiness as the record has it: w_c = U F(range/h_rms), one F for each shape of the attraction.

    python -m docs.studies.law        prints the thresholds, D and m

U is the elastic energy of full contact per area, F(Δ) = ½/(1 + (Δ/D)^m).  Fitted by least squares of ln w to the
thresholds of ``docs/studies/record/record.csv`` with λ_L/λ_s of 16 or more, with a factor for each surface whose mean
logarithm is zero: D and m are those of F, the factors tell surfaces apart, not laws.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Real = NDArray[np.float64]
PLATEAU = 0.5
"""F of a vanishing range: half of the energy, as Müser's group has it; not fitted."""
FEWEST_WAVES = 16
"""Smallest λ_L/λ_s: below, U of a surface is that of a few waves."""
RANGES = (0.04, 0.08, 0.16, 0.5, 1.6)
"""Ranges, in h_rms, at which F is written down."""


@dataclass(frozen=True)
class Thresholds:
    """Thresholds on record under one shape of the law, one value for each."""

    range: Real
    """Over h_rms."""
    work: Real
    """Over U."""
    energy: Real
    """U λ_L/h_rms², in E*."""
    hurst: Real
    seed: NDArray[np.int64]


@dataclass(frozen=True)
class Law:
    """F as it was fitted, with what is left over."""

    crossover: float
    """D, in h_rms."""
    exponent: float
    """m."""
    errors: tuple[float, float]
    """Standard errors of ln D and of m, thresholds taken as independent: too small."""
    factors: Real
    """Of each surface."""
    scatter: float
    """exp of the root-mean-square residual of ln w, with the factors of the surfaces."""
    power_of_energy: float
    """Exponent of U if that is left free; 1 is the law."""
    bias: dict[float, float]
    """Mean of w over U F and the surface's factor, by Hurst exponent."""

    def __call__(self, range: Real | float) -> Real:
        """F(range/h_rms)."""
        return PLATEAU / (1 + (np.asarray(range) / self.crossover) ** self.exponent)


def thresholds(shape: str) -> Thresholds:
    """Thresholds under a law of a shape, "spline" or "exponential"."""
    text = (Path(__file__).parent / "record" / "record.csv").read_text()
    rows = [row for row in csv.DictReader(text.splitlines()) if (row["source"], row["law"]) == ("threshold", shape)]
    every = {
        name: np.array([float(row[name]) for row in rows])
        for name in rows[0]
        if name not in ("source", "law", "sticky")
    }
    kept = every["lambda_L"] / every["lambda_s"] >= FEWEST_WAVES
    r = {name: values[kept] for name, values in every.items()}
    energy = r["conformal_energy"]
    return Thresholds(
        r["range"] / r["rms_height"], r["work"] / energy, energy * r["lambda_L"] / r["rms_height"] ** 2,
        r["hurst"], r["seed"].astype(np.int64),
    )  # fmt: skip


def fit(found: Thresholds) -> Law:
    """D, m and the factors of the surfaces."""
    seeds, of_seed = np.unique(found.seed, return_inverse=True)

    def left(free: Real) -> Real:
        crossover, exponent, factors = np.exp(free[0]), free[1], free[2:] - free[2:].mean()
        law = np.log(PLATEAU / (1 + (found.range / crossover) ** exponent))
        return np.log(found.work) - law - factors[of_seed]

    best = least_squares(left, [0.0, 1.0, *np.zeros(seeds.size)])
    residual, factors = left(best.x), best.x[2:] - best.x[2:].mean()
    covariance = np.linalg.pinv(best.jac.T @ best.jac) * residual.var()
    # What is left over, against ln U, a constant for each surface.
    sides = np.column_stack([np.log(found.energy), *(of_seed == k for k in range(seeds.size))])
    beyond = np.linalg.lstsq(sides, residual, rcond=None)[0][0]
    return Law(
        float(np.exp(best.x[0])), float(best.x[1]), (float(covariance[0, 0] ** 0.5), float(covariance[1, 1] ** 0.5)),
        np.exp(factors), float(np.exp(residual.std())), float(1 + beyond),
        {float(h): float(np.exp(residual[found.hurst == h].mean())) for h in np.unique(found.hurst)},
    )  # fmt: skip


def values() -> str:
    """D, m and F at some ranges, of each shape."""
    laws = {shape: fit(thresholds(shape)) for shape in ("spline", "exponential")}
    return "\n".join([
        f"| shape | D | m | {' | '.join(f'F({r:g})' for r in RANGES)} |", f"|---|---|---|{'---|' * len(RANGES)}",
        *(
            f"| {shape} | {law.crossover:.3f} | {law.exponent:.3f} | "
            f"{' | '.join(f'{f:.3f}' for f in law(np.array(RANGES)))} |"
            for shape, law in laws.items()
        ),
    ])  # fmt: skip


def tables() -> str:
    """The thresholds, D and m, and how they were fitted."""
    laws = {shape: (thresholds(shape), fit(thresholds(shape))) for shape in ("spline", "exponential")}
    head = [
        "| shape | thresholds | D | m | scatter | exponent of U | bias at each H | factors of the surfaces |",
        "|---|---|---|---|---|---|---|---|",
    ]
    rows = [
        f"| {shape} | {found.work.size} | {law.crossover:.3f} | {law.exponent:.3f} | {law.scatter:.3f} "
        f"| {law.power_of_energy:.3f} | {', '.join(f'{h:g}: {bias:.2f}' for h, bias in law.bias.items())} "
        f"| {', '.join(f'{factor:.2f}' for factor in law.factors)} |"
        for shape, (found, law) in laws.items()
    ]
    values = [
        f"| Δr/h_rms | {' | '.join(f'{r:g}' for r in RANGES)} |",
        f"|---|{'---|' * len(RANGES)}",
        *(
            f"| F, {shape} | {' | '.join(f'{f:.3f}' for f in law(np.array(RANGES)))} |"
            for shape, (_, law) in laws.items()
        ),
    ]
    return "\n".join([*head, *rows, "", *values])


if __name__ == "__main__":
    sys.stdout.write(tables() + "\n")
