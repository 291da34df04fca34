"""Compiled sweeps of the bound-constrained solver over the points of the surface.

Each is a function of the rows ``start:stop`` of a block, which writes that block's sums.  p is the pressure, z the gap
up to its level ``shift``, t the direction; s is the preconditioned gap and m the preconditioned field of ones, both
zero off the contact.  Where p has its largest value, ``most``, and still overlaps, the wall gives way: no contact in
which p is unknown.
"""

from __future__ import annotations

from continuum.model.fourier import Real
from continuum.solve.cpu.compiled import Mask, compiled


@compiled
def _level(start: int, stop: int, sums: Real, p: Real, z: Real, m: Real, most: float) -> None:
    """Where p presses, less than it may; sums: of m z, of m."""
    mz = in_m = 0.0
    for i in range(start, stop):
        for j in range(z.shape[1]):
            if 0.0 < p[i, j] < most:
                mz += m[i, j] * z[i, j]
                in_m += m[i, j]
    sums[0] = mz
    sums[1] = in_m


@compiled
def _select(
    start: int, stop: int, sums: Real, p: Real, z: Real, shift: float, mask: Mask, m: Real, most: float
) -> None:
    """Contact: the points that press or overlap.  sums: of those, how many are new; that are gone; of m z, of m."""
    entered = left = mz = in_m = count = 0.0
    for i in range(start, stop):
        for j in range(z.shape[1]):
            gap = z[i, j] + shift
            touches = (p[i, j] > 0.0 or gap < 0.0) and (p[i, j] < most or gap > 0.0)
            if touches:
                count += 1.0
                if not mask[i, j]:
                    entered += 1.0
                mz += m[i, j] * z[i, j]
                in_m += m[i, j]
            else:
                if mask[i, j]:
                    left += 1.0
                m[i, j] = 0.0
            mask[i, j] = touches
    sums[0] = count
    sums[1] = entered + left
    sums[2] = mz
    sums[3] = in_m


@compiled
def _contact(start: int, stop: int, sums: Real, mask: Mask, z: Real, shift: float, out: Real) -> None:
    """Set out <- z + shift on the contact, 0 off it."""
    for i in range(start, stop):
        for j in range(z.shape[1]):
            out[i, j] = z[i, j] + shift if mask[i, j] else 0.0


@compiled
def _ones(start: int, stop: int, sums: Real, mask: Mask, m: Real) -> None:
    """Set m <- 1 on the contact, 0 off it."""
    for i in range(start, stop):
        for j in range(m.shape[1]):
            m[i, j] = 1.0 if mask[i, j] else 0.0


@compiled
def _multiply(first: int, last: int, sums: Real, work: Real, values_q: Real) -> None:
    """Spectrum in work, times values for each mode."""
    for i in range(values_q.shape[0]):
        for j in range(first, last):
            work[i, 2 * j] *= values_q[i, j]
            work[i, 2 * j + 1] *= values_q[i, j]


@compiled
def _narrow(start: int, stop: int, sums: Real, mask: Mask, out: Real) -> None:
    """Set out <- 0 off the contact; sums: of out."""
    total = 0.0
    for i in range(start, stop):
        for j in range(out.shape[1]):
            if mask[i, j]:
                total += out[i, j]
            else:
                out[i, j] = 0.0
    sums[0] = total


@compiled
def _correct(
    start: int, stop: int, sums: Real, mask: Mask, z: Real, change: Real, t: Real, s: Real, m: Real, weight: float
) -> None:
    """Set s <- s - weight m on the contact, t <- 0 off it.  sums: of s², z s, (change of z) s, t, z t, z m."""
    ss = zs = ys = in_t = zt = zm = 0.0
    for i in range(start, stop):
        for j in range(z.shape[1]):
            if mask[i, j]:
                new = s[i, j] - weight * m[i, j]
                s[i, j] = new
                ss += new * new
                zs += z[i, j] * new
                ys += change[i, j] * new
                in_t += t[i, j]
                zt += z[i, j] * t[i, j]
                zm += z[i, j] * m[i, j]
            else:
                t[i, j] = 0.0
    sums[0] = ss
    sums[1] = zs
    sums[2] = ys
    sums[3] = in_t
    sums[4] = zt
    sums[5] = zm


@compiled
def _turn_on_contact(
    start: int, stop: int, sums: Real, mask: Mask, t: Real, s: Real, m: Real, beta: float, weight: float, out: Real
) -> None:
    """Direction t <- s + beta (t - weight m), copied into out."""
    for i in range(start, stop):
        for j in range(t.shape[1]):
            if mask[i, j]:
                t[i, j] = s[i, j] + beta * (t[i, j] - weight * m[i, j])
            out[i, j] = t[i, j]


@compiled
def _compliance(start: int, stop: int, sums: Real, work: Real, G: Real, single: int) -> None:
    """Spectrum work <- G work; sums: <work, G work> as a mean over the grid.

    ``single`` is the index of the last column if it counts once, else -1.
    """
    total = 0.0
    for i in range(start, stop):
        once = 0.0
        row = 0.0
        for j in range(G.shape[1]):
            g = G[i, j]
            a = work[i, 2 * j]
            b = work[i, 2 * j + 1]
            work[i, 2 * j] = g * a
            work[i, 2 * j + 1] = g * b
            both = g * (a * a + b * b)
            row += both
            if j == 0 or j == single:
                once += both
        total += 2.0 * row - once
    sums[0] = total


@compiled
def _trial(start: int, stop: int, sums: Real, p: Real, t: Real, step: float, out: Real, most: float) -> None:
    """Pressure out <- p - step t, cut at 0 and ``most``; sums: of what was cut (negative), of p - step t, of out."""
    below = before = after = 0.0
    for i in range(start, stop):
        for j in range(p.shape[1]):
            new = p[i, j] - step * t[i, j]
            below += min(new, 0.0) + min(most - new, 0.0)
            before += new
            new = min(max(new, 0.0), most)
            after += new
            out[i, j] = new
    sums[0] = below
    sums[1] = before
    sums[2] = after


@compiled
def _stretch(start: int, stop: int, sums: Real, p: Real, factor: float, out: Real, most: float) -> None:
    """Pressure out <- factor p, at most ``most``, which it stays where it is; sums: of out."""
    total = 0.0
    for i in range(start, stop):
        for j in range(p.shape[1]):
            here = p[i, j]
            here = here if here >= most else min(factor * here, most)
            out[i, j] = here
            total += here
    sums[0] = total


@compiled
def _advance(start: int, stop: int, sums: Real, z: Real, step: float, out: Real) -> None:
    """After a free step, out holding G t: out <- -step G t, the change of z; z <- z + out."""
    for i in range(start, stop):
        for j in range(z.shape[1]):
            out[i, j] *= -step
            z[i, j] += out[i, j]


@compiled
def _arrive(start: int, stop: int, sums: Real, p: Real, offset: Real, out: Real) -> None:
    """Gap out <- out + offset, out holding G p; sums: of p (gap + offset)/2, the energy, and of its size."""
    energy = size = 0.0
    for i in range(start, stop):
        for j in range(p.shape[1]):
            gap = out[i, j] + offset[i, j]
            out[i, j] = gap
            energy += 0.5 * p[i, j] * (gap + offset[i, j])
            size += p[i, j] * (abs(gap) + abs(offset[i, j]))
    sums[0] = energy
    sums[1] = size


@compiled
def _accept(start: int, stop: int, sums: Real, z: Real, new: Real) -> None:
    """Set z <- new and new <- the change of z."""
    for i in range(start, stop):
        for j in range(z.shape[1]):
            change = new[i, j] - z[i, j]
            z[i, j] = new[i, j]
            new[i, j] = change


@compiled
def _misses(start: int, stop: int, sums: Real, p: Real, z: Real, shift: float, out: Real, most: float) -> None:
    """Set out <- what closing the contact and lifting the overlaps adds to u."""
    for i in range(start, stop):
        for j in range(z.shape[1]):
            gap = z[i, j] + shift
            out[i, j] = gap if (p[i, j] > 0.0 or gap < 0.0) and (p[i, j] < most or gap > 0.0) else 0.0


@compiled
def _finish(start: int, stop: int, sums: Real, p: Real, z: Real, by: float, smallest: float, most: float) -> None:
    """Gap z <- z + by, exactly zero where p presses, negative where the wall gives way, and positive elsewhere."""
    for i in range(start, stop):
        for j in range(z.shape[1]):
            gap = z[i, j] + by
            if p[i, j] > 0.0:
                z[i, j] = min(gap, 0.0) if p[i, j] >= most else 0.0
            else:
                z[i, j] = smallest if gap < smallest else gap


@compiled
def _spread(start: int, stop: int, sums: Real, coarse: Real, fine: Real) -> None:
    """Pressure of the grid of every second point onto the finer one, bilinearly; sums: of it."""
    rows, columns = coarse.shape
    for i in range(start, stop):
        a = i // 2
        b = (a + i % 2) % rows
        for j in range(columns):
            k = j + 1 if j + 1 < columns else 0
            here = 0.5 * (coarse[a, j] + coarse[b, j])
            there = 0.5 * (coarse[a, k] + coarse[b, k])
            fine[i, 2 * j] = here
            fine[i, 2 * j + 1] = 0.5 * (here + there)
            sums[0] += here + 0.5 * (here + there)
