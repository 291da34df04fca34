"""Compiled sweeps over the points of the surface that ask the wall law: its traction, energy and stiffness.

A sweep is a function of the rows ``first:last`` of a block, which writes that block's sums.  Fields are whole arrays
with padded rows, of which n points count; ``out`` and ``s`` are buffers of the block alone, which is transformed
while it stays in the cache.  Tiles of a row are followed by the line search where they are marked as near; points
that are not numbers are near, so that they are not lost.  The stiffness of the law is kept in single precision, which
serves the length of a first step and the linear problems of coarser grids.
"""

from typing import NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.model.laws import Law, respond
from continuum.solve.compiled.compiling import TILE, Mask, Single, compiled, inlined

NEAR = 0.5
"""Points within this distance of the range of the law are near the wall, in a0: the line search asks these alone."""


class Pull(NamedTuple):
    """What is kept of the wall at the gap at hand."""

    near: Mask
    """The tiles near it."""
    traction: Real
    stiffness: Single


@compiled
def direction_near(first: int, last: int, sums: Real, s: Real, d: Real, n: int, beta: float, wall: Pull) -> None:
    """New direction, d <- beta d - s.  sums, over the marked tiles: of stiffness d²."""
    near, _, stiffness = wall
    curvature = 0.0
    for i in range(first, last):
        direction, step = d[i, :n], s[i - first, :n]
        for j in range(n):
            direction[j] = beta * direction[j] - step[j]
        for t in range(near.shape[1]):
            if near[i, t]:
                stiff = stiffness[i, t * TILE : min(n, (t + 1) * TILE)]
                e = d[i, t * TILE : min(n, (t + 1) * TILE)]
                for j in range(stiff.size):
                    curvature += stiff[j] * e[j] * e[j]
    sums[0] = curvature


@compiled
def search_line(
    first: int, last: int, sums: Real, z: Real, d: Real, n: int, alpha: float, law: Law, wall: Pull
) -> None:
    """At z - alpha d.  sums, over the marked tiles: of (change of traction) d; of stiffness d²."""
    near, traction, _ = wall
    slope = curvature = 0.0
    there, trial = np.empty((3, TILE)), np.empty(TILE)
    for i in range(first, last):
        for t in range(near.shape[1]):
            if near[i, t]:
                gap = z[i, t * TILE : min(n, (t + 1) * TILE)]
                e = d[i, t * TILE : min(n, (t + 1) * TILE)]
                here = traction[i, t * TILE : min(n, (t + 1) * TILE)]
                for j in range(gap.size):
                    trial[j] = gap[j] - alpha * e[j]
                respond(law.kind, trial[: gap.size], law.parameters, there)
                for j in range(gap.size):
                    slope += (there[1, j] - here[j]) * e[j]
                    curvature += there[2, j] * e[j] * e[j]
    sums[0], sums[1] = slope, curvature


@compiled
def move_gap(
    first: int,
    last: int,
    sums: Real,
    out: Real,
    z: Real,
    d: Real,
    n: int,
    step: float,
    alpha: float,
    law: Law,
    wall: Pull,
) -> None:
    """Step z <- z - step d, the last of several that add up to alpha.  Marks the tiles anew.

    The change of the traction since alpha = 0 goes into ``out``; traction and stiffness are kept for the new gap.  From
    a traction that is kept as zero, a step of length zero changes it by all of it.
    sums: of that change times d; of the traction at alpha = 0 times d; of the energy; of its size.
    """
    near, traction, stiffness = wall
    slope = before = energy = size = 0.0
    here, there, old = np.empty((3, TILE)), np.empty((3, TILE)), np.empty(TILE)
    for i in range(first, last):
        for t in range(near.shape[1]):
            gap = z[i, t * TILE : min(n, (t + 1) * TILE)]
            e = d[i, t * TILE : min(n, (t + 1) * TILE)]
            change = out[i - first, t * TILE : min(n, (t + 1) * TILE)]
            kept = traction[i, t * TILE : min(n, (t + 1) * TILE)]
            stiff = stiffness[i, t * TILE : min(n, (t + 1) * TILE)]
            close = touching = 0
            for j in range(gap.size):
                gap[j] -= step * e[j]
                old[j] = gap[j] + alpha * e[j]
            for j in range(gap.size):
                lower = old[j] if old[j] < gap[j] else gap[j]
                close += not lower >= law.reach + NEAR
                touching += not lower >= law.reach
            was_near, near[i, t] = near[i, t], close > 0
            if touching:
                if step != alpha:
                    # What is kept is that of an earlier one of the steps.
                    respond(law.kind, old[: gap.size], law.parameters, here)
                    for j in range(gap.size):
                        kept[j] = here[1, j]
                respond(law.kind, gap, law.parameters, there)
                a, b, c, f = _taken(there, e, kept, change, stiff)
                slope += a
                before += b
                energy += c
                size += f
                continue
            change[:] = 0.0
            if was_near:
                kept[:] = 0.0
                stiff[:] = 0.0
    sums[0], sums[1], sums[2], sums[3] = slope, before, energy, size


@inlined
def _taken(there: Real, e: Real, kept: Real, change: Real, stiff: Single) -> tuple[float, float, float, float]:
    """The response of a tile after a step along e: its change, and what is kept; the sums of `move`."""
    slope = before = energy = size = 0.0
    for j in range(e.size):
        change[j] = there[1, j] - kept[j]
        slope += change[j] * e[j]
        before += kept[j] * e[j]
        energy += there[0, j]
        size += abs(there[0, j])
        kept[j] = there[1, j]
        stiff[j] = there[2, j]
    return slope, before, energy, size


@compiled
def advance_traction(
    start: int,
    stop: int,
    sums: Real,
    f: Real,
    z: Real,
    t: Real,
    w: Real,
    step: float,
    law: Law,
    missing: Real,
    stiffness: Single,
) -> None:
    """Set f <- f + step t and z <- z + step w on tiles, missing <- f - the traction of the wall, and its stiffness.

    sums: of missing², of the energy of the wall; of w times what is missing, of w (t + stiffness w).
    """
    squares = energy = slope = curvature = 0.0
    here = np.empty((3, f.shape[1]))
    for i in range(start, stop):
        fi, zi, ti, wi, missed, stiff = f[i], z[i], t[i], w[i], missing[i], stiffness[i]
        for j in range(fi.size):
            fi[j] += step * ti[j]
            zi[j] += step * wi[j]
        respond(law.kind, zi, law.parameters, here)
        for j in range(fi.size):
            missed[j] = fi[j] - here[1, j]
            stiff[j] = here[2, j]
            squares += missed[j] * missed[j]
            energy += here[0, j]
            slope += wi[j] * missed[j]
            curvature += wi[j] * (ti[j] + here[2, j] * wi[j])
    sums[0], sums[1], sums[2], sums[3] = squares, energy, slope, curvature
