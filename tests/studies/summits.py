"""How often the summits of a map tell that it is outside of the record's class: worn, polished, honed, pitted, beaded.

``python -m tests.studies.summits`` prints, class by class, the ratio of the rms slope of the highest tenth to that of
the whole and the share of maps that are said to be outside, on maps cut from larger surfaces and detrended, as measured
ones are.  Parameters are other ones than those of the tests.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

import numpy as np

import continuum as c
from continuum.model.fourier import Real
from continuum.topography.faults import SUMMITS, summit_ratio
from continuum.topography.map import Topography
from continuum.topography.mending import detrend

Shape = Callable[[Real, np.random.Generator], Real]
PIXEL = 1e-8


def flattened(part: float, factor: float) -> Shape:
    """Worn: the highest part of the points pressed together."""

    def wear(heights: Real, rng: np.random.Generator) -> Real:
        level = np.quantile(heights, 1 - part)
        return np.where(heights > level, level + (heights - level) / factor, heights)

    return wear


def _around(n: int, at: float) -> Real:
    return (np.arange(n) - at + n / 2) % n - n / 2


def honed(heights: Real, rng: np.random.Generator) -> Real:
    """Fine plateaus between deep grooves."""
    n = heights.shape[0]
    places = zip(rng.uniform(0, n, 12), rng.uniform(2, 6, 12), strict=True)
    grooves = np.sum([np.exp(-((_around(n, at) / width) ** 2)) for at, width in places], axis=0)
    return 0.3 * heights - 3 * heights.std() * grooves[:, None]


def pitted(heights: Real, rng: np.random.Generator) -> Real:
    """Pits four times as deep as the roughness."""
    pits = np.zeros(heights.shape)
    for _ in range(30):
        x, y = (_around(n, rng.uniform(0, n)) for n in heights.shape)
        pits += np.exp(-(x[:, None] ** 2 + y**2) / rng.uniform(3, 8) ** 2)
    return heights - 4 * heights.std() * pits


def beaded(heights: Real, rng: np.random.Generator) -> Real:
    """Spheres of one radius on a plane."""
    radius, n = rng.uniform(12, 40), heights.shape[0]
    found = np.full(heights.shape, -np.inf)
    for _ in range(max(4, int((n / radius) ** 2))):
        x, y = (_around(m, rng.uniform(0, m)) for m in heights.shape)
        found = np.maximum(found, rng.normal() * radius / 24 - (x[:, None] ** 2 + y**2) / (2 * radius))
    return found


CLASSES: dict[str, Shape] = {
    "Gaussian": lambda heights, rng: heights,
    "a top fifth flattened tenfold": flattened(0.2, 10),
    "a top fifth flattened twofold": flattened(0.2, 2),
    "a top tenth flattened threefold": flattened(0.1, 3),
    "a top twentieth flattened tenfold": flattened(0.05, 10),
    "honed": honed,
    "pitted": pitted,
    "beaded": beaded,
}


def maps(seeds: int) -> list[tuple[Real, np.random.Generator]]:
    """Gaussian maps: whole periods, and pieces of larger ones."""
    found = []
    for hurst in (0.3, 0.6, 0.8, 0.95):
        for short, long, n in ((4, 16, 128), (4, 64, 128), (8, 64, 128), (4, 256, 128), (16, 128, 256), (8, 256, 256)):
            for seed in range(seeds):
                rng = np.random.default_rng([seed, int(100 * hurst), short, long, n])
                heights = c.SelfAffine(hurst, 0.1, short, long).synthesise(c.Grid.square(max(n, 2 * long)), rng)
                found.append((heights[:n, :n], rng))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=24, help="maps of each of 24 kinds")
    given = parser.parse_args()
    lines = ["| class | maps | ratio: least, 5, 50, 95 %, largest | outside |", "|---|---|---|---|"]
    for name, shape in CLASSES.items():
        few = given.seeds if name == "Gaussian" else max(given.seeds // 8, 1)
        ratios = []
        for heights, rng in maps(few):
            made = shape(heights, rng) * PIXEL
            made = made - made.mean()
            ratios.append(summit_ratio(detrend(Topography(made, tuple(PIXEL * n for n in made.shape)))))
        found = np.array(ratios)
        outside = int(np.sum((found < SUMMITS) | (found > 1 / SUMMITS)))
        quantiles = ", ".join(f"{q:.2f}" for q in np.percentile(found, [0, 5, 50, 95, 100]))
        lines.append(f"| {name} | {found.size} | {quantiles} | {outside} |")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
