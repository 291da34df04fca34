"""What the lines of a scan leave in a map: lines displaced against their neighbours, and scars along them.

A scanning instrument records line after line.  Between two lines it drifts and loses its zero, so that each line has an
offset of its own; along a line it may stick, which leaves a scar, one or two lines wide.  Neither is seen in the other
direction: a surface differs from its own transpose in no such way, so the two directions are held against each other.

Everything here works on bare arrays; lengths are in any one unit.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_opening

from continuum.arguments import ArgumentError
from continuum.arguments import field as map_of
from continuum.model.fourier import Real

Mask = NDArray[np.bool_]

FAR = 6.0
"""Deviations, in robust standard deviations, beyond which a line or a point is no part of a Gaussian surface."""
LONGEST_SPIKE = 3
"""Points; what is longer along a line is a scar, along both directions a feature."""
INDEPENDENT = -0.45
"""Correlation of successive bends of the line offsets: -2/3 for independent offsets, -1/2 for a random walk; positive
for a smooth profile."""
DIRECTED = 2.0
"""Bend of the offsets of lines over that of columns, above which it is no accident of an isotropic surface."""
SCARRED = 0.05
"""Part of a line that is a scar, from which its offset says nothing."""
AGREEING = 0.8
"""Part of a displaced line that lies to the same side of its neighbours."""
GROOVED = -0.5
"""Skewness of the bends of offsets below which they are grooves, if it is three standard errors below zero: of N
independent Gaussian offsets the skewness of the bends scatters by less than sqrt(9/N)."""
RARE = 1e-3
"""Share of the points beyond which those that stand out belong to the surface."""
_ROBUST = 1.4826  # of the median absolute deviation to the standard deviation of a Gaussian


@dataclass(frozen=True, eq=False)
class ScanLines:
    """Lines of a map against its columns."""

    axis: int
    """Index that runs along a line: 0 if lines run along x."""
    ratio: float
    """Bend of the offsets of lines over the same for columns; 1 for an isotropic surface."""
    correlation: float
    """Correlation of successive bends; see :data:`INDEPENDENT`."""
    noise: float
    """Standard deviation of the offset of a line, beyond that of the surface."""
    outliers: NDArray[np.intp] = field(repr=False)
    """Lines that are displaced against both neighbours by far more than the others."""
    scars: Mask = field(repr=False)
    """Points of scars."""
    skewness: float = 0.0
    """Skewness of the bends of the offsets; negative for grooves."""

    @property
    def independent(self) -> bool:
        """Whether the lines are displaced independently of one another, by more than the surface can."""
        return self.ratio > DIRECTED and self.correlation < INDEPENDENT

    @property
    def grooved(self) -> bool:
        """Whether displaced lines are lower than their neighbours so often that they are grooves of the surface."""
        return bool(self.skewness < min(GROOVED, -3 * np.sqrt(9 / max(self.scars.shape))))


def scan_lines(heights: Real) -> ScanLines:
    """Lines against columns, along the direction in which there is more to find; of at least 3 x 3 heights."""
    heights = map_of("heights", heights)
    from scipy.stats import skew  # a quarter of a second that other commands need not wait

    if min(heights.shape) < 3:
        raise ArgumentError("heights", heights, "at least 3 lines of 3 points: a line is held against its neighbours")
    scars = [_scars(heights, axis) for axis in (0, 1)]
    found = [np.count_nonzero(mask) for mask in scars]
    offsets = [line_offsets(heights, axis, scars[axis]) for axis in (0, 1)]
    bends = [each[1:-1] - (each[:-2] + each[2:]) / 2 for each in offsets]
    spreads = [_spread(bend) for bend in bends]
    limit = FAR * max(*spreads, 1e-300)
    outliers = [
        np.setdiff1d(
            _displaced(bends[axis], limit, _agreement(heights, axis)),
            np.flatnonzero(scars[axis].mean(axis=axis) > SCARRED),
        )
        for axis in (0, 1)
    ]
    # What stands out along both directions alike is a feature of the surface, or of a tip.
    one_sided = max(found) > 4 * min(found) + LONGEST_SPIKE
    evidence: list[float] = [float(n) for n in found] if one_sided else [float(o.size) for o in outliers]
    axis = int(np.argmax(evidence if evidence[0] != evidence[1] else spreads))
    bend, mine, other = bends[axis], spreads[axis], spreads[1 - axis]
    return ScanLines(
        axis=axis,
        ratio=mine / other if other > 0 else np.inf if mine > 0 else 1.0,
        correlation=_correlation(bend),
        noise=float(np.sqrt(max(mine**2 - other**2, 0.0) / 1.5)),
        outliers=outliers[axis],
        scars=scars[axis] if one_sided else np.zeros(heights.shape, dtype=bool),
        skewness=float(skew(bend)) if mine > 0 else 0.0,
    )


def line_offsets(heights: Real, axis: int, scars: Mask | None = None) -> Real:
    """Median height of each line, the lines running along an axis; scars are bridged from the lines beside them."""
    if scars is not None and scars.any():
        heights = np.where(scars, heights - _across(heights, axis), heights)
    return np.asarray(np.median(heights, axis=axis))


def spikes(heights: Real) -> Mask:
    """Points that stand out from all four neighbours by far more than a Gaussian surface does."""
    bend = _across(heights, 0), _across(heights, 1)
    far = [np.abs(b) > FAR * max(_spread(b), 1e-300) for b in bend]
    both = far[0] & far[1] & (bend[0] * bend[1] > 0)
    length = np.ones((LONGEST_SPIKE + 1, 1), dtype=bool)
    wide = binary_opening(both, length) | binary_opening(both, length.T)
    found = both & ~wide
    return found if found.mean() < RARE else np.zeros(heights.shape, dtype=bool)


def raised(heights: Real, marked: Mask, axis: int) -> float:
    """Part of what is marked, by the square of its height, that lies above the lines beside it; 0 of nothing."""
    bend = _across(heights, axis)[marked]
    square = float(np.sum(bend**2))
    return float(np.sum(bend[bend > 0] ** 2)) / square if square > 0 else 0.0


def _across(heights: Real, axis: int) -> Real:
    """Height above the mean of the two neighbours across the lines, which run along an axis; 0 at the edges."""
    lines = np.moveaxis(heights, axis, 1)
    bend = np.zeros_like(lines)
    bend[1:-1] = lines[1:-1] - (lines[:-2] + lines[2:]) / 2
    return np.moveaxis(bend, 1, axis)


def _scars(heights: Real, axis: int) -> Mask:
    """Runs of points along a line that stand out from the lines on both sides, to one side."""
    bend = _across(heights, axis)
    # A displaced line is no scar.
    bend = bend - np.median(bend, axis=axis, keepdims=True)
    limit = FAR * max(_spread(bend), 1e-300)
    run = np.ones((LONGEST_SPIKE + 1, 1) if axis == 0 else (1, LONGEST_SPIKE + 1), dtype=bool)
    mask = np.zeros(heights.shape, dtype=bool)
    for side in (bend > limit, bend < -limit):
        mask |= binary_opening(side, run)
    if not mask.any():
        return mask
    # Of a scar the neighbouring lines bend half as much the other way, and are none.
    size = np.abs(np.where(mask, bend, 0.0))
    lines = np.moveaxis(size, axis, 1)
    beside = np.zeros_like(lines)
    beside[1:] = lines[:-1]
    beside[:-1] = np.maximum(beside[:-1], lines[1:])
    mask &= np.moveaxis(lines >= 0.75 * beside, 1, axis)
    # The ends of a scar are less high.
    return np.asarray(binary_dilation(mask, run, iterations=1))


def _agreement(heights: Real, axis: int) -> Real:
    """Part of the points of each line but the outermost that lie to the same side of the neighbouring lines."""
    above = np.mean(_across(heights, axis) > 0, axis=axis)[1:-1]
    return np.asarray(np.maximum(above, 1 - above))


def _displaced(bend: Real, limit: float, agreement: Real) -> NDArray[np.intp]:
    """Lines that are displaced as a whole: the neighbours of such a one bend half as much the other way."""
    before, after = np.roll(bend, 1), np.roll(bend, -1)
    peak = np.abs(bend) >= np.maximum(np.abs(before), np.abs(after))
    opposite = np.minimum(before * np.sign(bend), after * np.sign(bend)) < -np.abs(bend) / 4
    return np.flatnonzero((np.abs(bend) > limit) & peak & opposite & (agreement > AGREEING)) + 1


def _spread(values: Real) -> float:
    """Standard deviation of a Gaussian with the same median absolute deviation; the plain one if most are equal."""
    robust = _ROBUST * float(np.median(np.abs(values - np.median(values))))
    return robust if robust > 0 else float(np.std(values))


def _correlation(bend: Real) -> float:
    """Correlation of successive values, outliers cut."""
    limit = FAR * max(_spread(bend), 1e-300)
    cut = np.clip(bend - np.median(bend), -limit, limit)
    power = float(np.mean(cut**2))
    return float(np.mean(cut[1:] * cut[:-1])) / power if power > 0 else 0.0
