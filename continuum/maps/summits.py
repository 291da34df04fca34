"""Summits of a map, which touch first: its upper tenth compared with its lower tenth and with a Gaussian surface.

Height and slope at one point of a Gaussian surface are independent, and it looks the same upside down.  So the highest
tenth of its points has the rms slope and the scatter of the curvature of the lowest tenth.  Worn, polished or honed
summits, pits and grooves in a plateau, and summits rounded by spheres or a blunt tip change these first.  A tenth of a
map has many short waves, so that these ratios scatter little, whereas skewness and kurtosis depend on its few longest
waves.

Standard errors are Tukey's jackknife over :data:`BLOCKS` x :data:`BLOCKS` parts of the map.
"""

from dataclasses import dataclass
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
import scipy

from continuum.maps.map import Topography, once
from continuum.model.fourier import Real

TENTH = 0.1
"""Share of the points in the upper and in the lower part; 1 % of the area touches, and a larger part attracts."""
BLOCKS = 4
"""Parts along each side that are left out, one at a time; a map has at least 16 points a side."""
RATIO = 1.5
"""Smallest ratio, or inverse ratio, of slope or curvature of the upper and the lower tenth that is reported."""
SKEWNESS, KURTOSIS, BEARING = 1.0, 5.0, 1 / 3
"""Skewness and kurtosis above which heights, and height of the upper tenth over the Gaussian's below which summits, are
not Gaussian: on few long waves, a Gaussian surface was seen with 0.8, 5 and 0.4."""
ERRORS = 3.0
"""Standard errors beyond which a difference is significant.  With RATIO, of 2400 clean maps of 32² to 256² points, H
from 0.2 to 0.95, 14 are called not Gaussian (``python -m docs.studies.classes --alarms``)."""
_SMALLEST = 1e-12


class Upper(NamedTuple):
    """Heights of a map, and its upper tenth; a Gaussian surface has 0, 3, 1, 1 and 1."""

    skewness: float
    kurtosis: float
    bearing: float
    """Mean height of the upper tenth above its lower end, over that of a Gaussian."""
    slope: float
    """rms slope of the upper tenth over that of the lower."""
    curvature: float
    """Standard deviation of the laplacian of the upper tenth over that of the lower."""


@dataclass(frozen=True)
class Summits:
    """The numbers of a map, with their standard errors."""

    value: Upper
    error: Upper
    """Standard errors; of the last three, of their logarithms."""

    @property
    def unlike_gaussian(self) -> list[str]:
        """Descriptions of properties that a Gaussian surface does not have."""
        value, error = self.value, self.error
        said = []
        for name, part in (("slope", "rms slope"), ("curvature", "scatter of the curvature")):
            ratio = getattr(value, name)
            if abs(np.log(ratio)) > max(np.log(RATIO), ERRORS * getattr(error, name)):
                said.append(f"the upper tenth has {ratio:.2g} times the {part} of the lower")
        if np.log(value.bearing) < min(np.log(BEARING), -ERRORS * error.bearing):
            said.append(f"the upper tenth is {value.bearing:.2g} times as high as a Gaussian's")
        if abs(value.skewness) > max(SKEWNESS, ERRORS * error.skewness):
            said.append(f"a skewness of {value.skewness:.2g}")
        if value.kurtosis > KURTOSIS:
            said.append(f"a kurtosis of {value.kurtosis:.3g}")
        return said


def excess(share: float) -> float:
    """Mean height of the upper share of a Gaussian above its lower end, in h_rms: 0.473 of the upper tenth."""
    edge = -float(scipy.special.ndtri(share))
    return float(np.exp(-(edge**2) / 2) / np.sqrt(2 * np.pi)) / share - edge


@once
def summits_of(topography: Topography) -> Summits:
    """Compare the upper tenth of a map with its lower tenth and with that of a Gaussian surface."""
    h = topography.heights
    heights = (h - h.mean()) / h.std()
    low, high = (float(q) for q in np.quantile(heights, (TENTH, 1 - TENTH)))
    edges = [np.linspace(1, n - 1, BLOCKS + 1).astype(int) for n in heights.shape]
    parts = [
        _sums(heights[i - 1 : k + 1, j - 1 : m + 1], topography.grid.spacing, low, high)
        for (i, k), (j, m) in product(*(list(pairwise(edge)) for edge in edges))
    ]
    sums = np.array(parts).T
    whole = sums.sum(axis=1, keepdims=True)
    value, without = _numbers(whole, high)[:, 0], _numbers(whole - sums, high)
    # The last three are ratios: their errors are those of logarithms.
    without[2:] = np.log(without[2:])
    count = sums.shape[1]
    return Summits(Upper(*value.tolist()), Upper(*(np.sqrt(count - 1) * without.std(axis=1)).tolist()))


def _sums(h: Real, spacing: tuple[float, float], low: float, high: float) -> list[float]:
    """Sums over the inner points of a part: powers of the heights, squared slopes, powers of the laplacian."""
    inner = h[1:-1, 1:-1]
    (left, right), (back, front) = (
        ((side - inner) / d for side in sides)
        for sides, d in (((h[:-2, 1:-1], h[2:, 1:-1]), spacing[0]), ((h[1:-1, :-2], h[1:-1, 2:]), spacing[1]))
    )
    slope = (left**2 + right**2 + back**2 + front**2) / 2
    bend = (left + right) / spacing[0] + (back + front) / spacing[1]
    square = inner * inner
    powers = (inner, square, square * inner, square * square)
    found = [float(inner.size), *(float(one.sum()) for one in powers)]
    for part in (inner >= high, inner <= low):
        found += [float(part.sum()), *(float(np.sum(one[part])) for one in (inner, slope, bend, bend**2))]
    return found


def _numbers(sums: Real, high: float) -> Real:
    """The numbers of :class:`Upper` from sums over points, one column for each set of parts."""
    count, first, second, third, fourth = sums[:5]
    m, square = first / count, second / count
    variance = square - m**2
    skewness = (third / count - 3 * m * square + 2 * m**3) / variance**1.5
    kurtosis = (fourth / count - 4 * m * third / count + 6 * m**2 * square - 3 * m**4) / variance**2
    (n, heights, slope, bend, bends), (other, _, its_slope, its_bend, its_bends) = sums[5:10], sums[10:]
    n, other = np.maximum(n, 1), np.maximum(other, 1)  # the whole upper tenth may lie in one part
    bearing = (heights / n - high) / np.sqrt(variance) / excess(TENTH)
    slopes = _ratio(slope / n, its_slope / other)
    curvatures = _ratio(bends / n - (bend / n) ** 2, its_bends / other - (its_bend / other) ** 2)
    return np.stack([skewness, kurtosis, np.maximum(bearing, _SMALLEST), slopes, curvatures])


def _ratio(one: Real | float, other: Real | float) -> Real:
    """Root of a ratio; 1 if both are zero but for rounding."""
    least = _SMALLEST * np.maximum(one, other) + 1e-300
    return np.asarray(np.sqrt(np.maximum(one, least) / np.maximum(other, least)))
