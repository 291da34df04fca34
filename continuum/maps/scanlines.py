"""Artefacts of scan lines: lines displaced against their neighbours, and scars along them.

A scanning instrument records line after line.  Between two lines it drifts and loses its zero, so that each line has an
offset of its own; along a line it may stick, which leaves a scar, one or two lines wide.  Neither occurs across the
lines, and an isotropic surface has neither, so that the two directions are compared.

All functions take arrays; lengths are in any one unit.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.inputs.arguments import ArgumentError, field_of
from continuum.model.fourier import Real

Mask = NDArray[np.bool_]

FAR = 6.0
"""Deviation, in robust standard deviations, beyond which a line or a point does not belong to a Gaussian surface."""
LONGEST_SPIKE = 3
"""Number of points: a longer run along lines only is a scar, along both directions a feature of the surface."""
INDEPENDENT = -0.45
"""Correlation of successive bends of the line offsets: -2/3 for independent offsets, -1/2 for a random walk; positive
for a smooth profile."""
DIRECTED = 2.0
"""Ratio of the bends of the offsets of lines and of columns above which an isotropic surface is excluded."""
SCARRED = 0.05
"""Part of a line in scars above which its offset is not used."""
AGREEING = 0.8
"""Smallest part of a displaced line that lies to the same side of its neighbours."""
GROOVED = -0.5
"""Skewness of the bends of offsets below which they are grooves, if it is also three standard errors below zero: for N
independent Gaussian offsets it scatters by less than sqrt(9/N)."""
RARE = 1e-3
"""Share of outliers above which they belong to the surface."""
_ROBUST = 1.4826  # standard deviation of a Gaussian over its median absolute deviation


@dataclass(frozen=True, eq=False)
class ScanLines:
    """Comparison of the lines of a map with its columns."""

    axis: int
    """Index that runs along a line: 0 if lines run along x."""
    ratio: float
    """Bend of the offsets of lines over that of columns; 1 for an isotropic surface."""
    correlation: float
    """Correlation of successive bends; see :data:`INDEPENDENT`."""
    noise: float
    """Standard deviation of the offset of a line, beyond that of the surface."""
    outliers: NDArray[np.intp] = field(repr=False)
    """Lines displaced against both neighbours by far more than the others."""
    scars: Mask = field(repr=False)
    """Points of scars."""
    skewness: float = 0.0
    """Skewness of the bends of the offsets; negative for grooves."""

    @property
    def independent(self) -> bool:
        """True if the lines are displaced independently, by more than the surface explains."""
        return self.ratio > DIRECTED and self.correlation < INDEPENDENT

    @property
    def grooved(self) -> bool:
        """True if displaced lines lie below their neighbours so often that they are grooves of the surface."""
        return bool(self.skewness < min(GROOVED, -3 * np.sqrt(9 / max(self.scars.shape))))


def scan_lines(heights: Real) -> ScanLines:
    """Compare lines with columns, along the direction with more artefacts; at least 3 x 3 heights."""
    heights = field_of("heights", heights)
    if min(heights.shape) < 3:
        raise ArgumentError(
            "heights", heights, "at least 3 lines of 3 points: each line is compared with its neighbours"
        )
    scars = [_scars(heights, axis) for axis in (0, 1)]
    found = [np.count_nonzero(mask) for mask in scars]
    offsets = [line_offsets(heights, axis, scars[axis]) for axis in (0, 1)]
    bends = [each[1:-1] - (each[:-2] + each[2:]) / 2 for each in offsets]
    spreads = [_spread(bend) for bend in bends]
    limit = FAR * max(*spreads, 1e-300)
    outliers = [
        np.setdiff1d(
            _displaced(bends[axis], limit, np.mean(_across(heights, axis) > 0, axis=axis)[1:-1]),
            np.flatnonzero(scars[axis].mean(axis=axis) > SCARRED),
        )
        for axis in (0, 1)
    ]
    # Outliers along both directions alike are features of the surface, or of a tip.
    one_sided = max(found) > 4 * min(found) + LONGEST_SPIKE
    evidence: list[float] = [float(n) for n in found] if one_sided else [float(o.size) for o in outliers]
    # Where neither direction has more artefacts, lines are along the one whose offsets scatter more.
    axis = int(np.argmax(evidence if evidence[0] != evidence[1] else spreads))
    bend, mine, other = bends[axis], spreads[axis], spreads[1 - axis]
    return ScanLines(
        axis=axis,
        ratio=mine / other if other > 0 else np.inf if mine > 0 else 1.0,
        correlation=_correlation(bend),
        # The bend of independent offsets has 3/2 of their variance; that of the columns is the surface's own.
        noise=float(np.sqrt(max(mine**2 - other**2, 0.0) / 1.5)),
        outliers=outliers[axis],
        scars=scars[axis] if one_sided else np.zeros(heights.shape, dtype=bool),
        skewness=float(np.mean((bend - bend.mean()) ** 3) / bend.std() ** 3) if mine > 0 and bend.std() > 0 else 0.0,
    )


def line_offsets(heights: Real, axis: int, scars: Mask | None = None) -> Real:
    """Median height of each line along an axis; scars are interpolated from the lines beside them."""
    if scars is not None and scars.any():
        heights = np.where(scars, heights - _across(heights, axis), heights)
    return np.asarray(np.median(heights, axis=axis))


def spikes(heights: Real) -> Mask:
    """Points that differ from all four neighbours by far more than on a Gaussian surface."""
    bend = _across(heights, 0), _across(heights, 1)
    far = [np.abs(b) > FAR * max(_spread(b), 1e-300) for b in bend]
    both = far[0] & far[1] & (bend[0] * bend[1] > 0)
    if not both.any():
        return both
    length = np.ones((LONGEST_SPIKE + 1, 1), dtype=bool)
    # A longer run is a scar or a feature of the surface, not an outlier.
    wide = scipy.ndimage.binary_opening(both, length) | scipy.ndimage.binary_opening(both, length.T)
    found = both & ~wide
    return found if found.mean() < RARE else np.zeros(heights.shape, dtype=bool)


def raised(heights: Real, marked: Mask, axis: int) -> float:
    """Part of the marked points, weighted by squared height, above the lines beside them; 0 if none."""
    bend = _across(heights, axis)[marked]
    square = float(np.sum(bend**2))
    return float(np.sum(bend[bend > 0] ** 2)) / square if square > 0 else 0.0


def _across(heights: Real, axis: int) -> Real:
    """Height above the mean of the two neighbours across the lines; 0 at the edges."""
    lines = np.moveaxis(heights, axis, 1)
    bend = np.zeros_like(lines)
    bend[1:-1] = lines[1:-1] - (lines[:-2] + lines[2:]) / 2
    return np.moveaxis(bend, 1, axis)


def _scars(heights: Real, axis: int) -> Mask:
    """Runs of points along a line that differ from the lines on both sides, with one sign."""
    bend = _across(heights, axis)
    # A displaced line is not a scar.
    bend = bend - np.median(bend, axis=axis, keepdims=True)
    limit = FAR * max(_spread(bend), 1e-300)
    run = np.ones((LONGEST_SPIKE + 1, 1) if axis == 0 else (1, LONGEST_SPIKE + 1), dtype=bool)
    mask = np.zeros(heights.shape, dtype=bool)
    for side in (bend > limit, bend < -limit):
        if side.any():
            mask |= scipy.ndimage.binary_opening(side, run)
    if not mask.any():
        return mask
    # The lines beside a scar bend half as much the other way, and are not scars.
    size = np.abs(np.where(mask, bend, 0.0))
    mask &= size >= 0.75 * scipy.ndimage.maximum_filter1d(size, 3, 1 - axis, mode="constant")
    # The ends of a scar are lower.
    return np.asarray(scipy.ndimage.binary_dilation(mask, run, iterations=1))


def _displaced(bend: Real, limit: float, above: Real) -> NDArray[np.intp]:
    """Lines displaced as a whole: the neighbours of such a line bend half as much the other way.

    Of each inner line ``above`` is the part of the points that lie above the neighbouring lines.
    """
    before, after = np.roll(bend, 1), np.roll(bend, -1)
    peak = np.abs(bend) >= np.maximum(np.abs(before), np.abs(after))
    opposite = np.minimum(before * np.sign(bend), after * np.sign(bend)) < -np.abs(bend) / 4
    agree = np.maximum(above, 1 - above) > AGREEING
    return np.flatnonzero((np.abs(bend) > limit) & peak & opposite & agree) + 1


def _spread(values: Real) -> float:
    """Standard deviation of a Gaussian of the same median absolute deviation; the plain one if that is 0."""
    robust = _ROBUST * float(np.median(np.abs(values - np.median(values))))
    return robust if robust > 0 else float(np.std(values))


def _correlation(bend: Real) -> float:
    """Correlation of successive values, with outliers clipped."""
    limit = FAR * max(_spread(bend), 1e-300)
    cut = np.clip(bend - np.median(bend), -limit, limit)
    power = float(np.mean(cut**2))
    return float(np.mean(cut[1:] * cut[:-1])) / power if power > 0 else 0.0
