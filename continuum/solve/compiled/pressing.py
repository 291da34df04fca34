"""Compiled sweeps of the bound-constrained solver over the points of the surface.

Each is a function of the rows ``start:stop`` of a block, which writes that block's sums.  p is the pressure, z the gap
up to its level ``shift``, t the direction; s is the preconditioned gap and m the preconditioned field of ones, both
zero off the contact.  Where p has its largest value, ``most``, and still overlaps, the wall gives way: no contact in
which p is unknown.

``n`` is the length of a row without its padding.  Most tiles of a rough contact neither press nor overlap: ``touched``
says which do (2), which did and still hold values of then (1), and where p, t, s and m are zero (0).  ``lowest`` is the
least z of each tile: one without contact is not looked at as long as its lowest point does not overlap.
"""

from typing import NamedTuple

from continuum.model.fourier import Real
from continuum.solve.compiled.compiling import TILE, Field, Marks, Mask, compiled
from continuum.solve.compiled.points import untouched


class ContactPoints(NamedTuple):
    """The points in contact."""

    mask: Mask
    m: Real
    n: int
    touched: Marks


@compiled
def level(start: int, stop: int, sums: Real, p: Real, z: Real, most: float, contact: ContactPoints) -> None:
    """Where p presses, less than it may; sums: of m z, of m."""
    _, m, n, touched = contact
    mz = in_m = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            pi, zi, mi = p[i, a:b], z[i, a:b], m[i, a:b]
            for j in range(pi.size):
                here = mi[j] if 0.0 < pi[j] < most else 0.0
                mz += here * zi[j]
                in_m += here
    sums[0], sums[1] = mz, in_m


@compiled
def select(
    start: int, stop: int, sums: Real, p: Real, z: Real, shift: float, most: float, lowest: Real, contact: ContactPoints
) -> None:
    """Contact: the points that press or overlap; sums: how many; how many are new or gone; of m z, m, (z + shift)⁸."""
    mask, m, n, touched = contact
    changed = mz = in_m = count = eighth = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0 and lowest[i, tile] + shift >= 0.0:
                continue
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            pi, zi, mi, marks = p[i, a:b], z[i, a:b], m[i, a:b], mask[i, a:b]
            active = 0
            for j in range(pi.size):
                gap = zi[j] + shift
                touches = ((pi[j] > 0.0) | (gap < 0.0)) & ((pi[j] < most) | (gap > 0.0))
                count += 1.0 if touches else 0.0
                changed += 1.0 if touches != marks[j] else 0.0
                mi[j] = mi[j] if touches else 0.0
                mz += mi[j] * zi[j]
                in_m += mi[j]
                fourth = gap * gap * gap * gap if touches else 0.0
                eighth += fourth * fourth
                marks[j] = touches
                active |= touches | (pi[j] > 0.0)
            if active:
                touched[i, tile] = 2
            elif touched[i, tile] == 2:
                touched[i, tile] = 1
    sums[0], sums[1], sums[2], sums[3], sums[4] = count, changed, mz, in_m, eighth


@compiled
def stiffness(first: int, last: int, sums: Real, work: Field, K: Field, least: float) -> None:
    """Spectrum work <- K work, but for the mean: ``least`` times it."""
    for i in range(K.shape[0]):
        wi, ki = work[i, 2 * first : 2 * last], K[i, first:last]
        for j in range(ki.size):
            k = least if i + first + j == 0 else ki[j]
            wi[2 * j] *= k
            wi[2 * j + 1] *= k


@compiled
def correct(
    start: int, stop: int, sums: Real, z: Real, change: Real, t: Real, s: Real, weight: float, contact: ContactPoints
) -> None:
    """Set s <- s - weight m on the contact, s and t <- 0 off it.  sums: of s², z s, (change of z) s, t, z t, z m."""
    mask, ones, n, touched = contact
    ss = zs = ys = in_t = zt = zm = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            marks, zi, yi = mask[i, a:b], z[i, a:b], change[i, a:b]
            ti, si, mi = t[i, a:b], s[i, a:b], ones[i, a:b]
            for j in range(zi.size):  # without a branch, so that it vectorises
                new = si[j] - weight * mi[j] if marks[j] else 0.0
                along, m = (ti[j], mi[j]) if marks[j] else (0.0, 0.0)
                si[j], ti[j] = new, along
                ss += new * new
                zs += zi[j] * new
                ys += yi[j] * new
                in_t += along
                zt += zi[j] * along
                zm += zi[j] * m
            if touched[i, tile] == 1:
                touched[i, tile] = 0
    sums[0], sums[1], sums[2], sums[3], sums[4], sums[5] = ss, zs, ys, in_t, zt, zm


@compiled
def direction_on_contact(
    start: int, stop: int, sums: Real, t: Real, s: Real, beta: float, weight: float, out: Real, contact: ContactPoints
) -> None:
    """Direction t <- s + beta (t - weight m), copied into the rows of out that have contact."""
    mask, m, n, touched = contact
    for i in range(start, stop):
        if untouched(touched[i]):
            continue
        for tile in range(touched.shape[1]):
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            oi = out[i, a:b]
            if touched[i, tile] == 0:
                oi[:] = 0.0
                continue
            marks, ti, si, mi = mask[i, a:b], t[i, a:b], s[i, a:b], m[i, a:b]
            for j in range(oi.size):
                here = si[j] + beta * (ti[j] - weight * mi[j]) if marks[j] else ti[j]
                ti[j] = here
                oi[j] = here


@compiled
def compliance(first: int, last: int, sums: Real, work: Real, G: Real, weights: Real) -> None:
    """Spectrum work <- G work; sums: <work, G work> as a mean over the grid."""
    total = 0.0
    weight = weights[first:last]
    for i in range(G.shape[0]):
        wi, gi = work[i, 2 * first : 2 * last], G[i, first:last]
        for j in range(gi.size):
            a, b = wi[2 * j], wi[2 * j + 1]
            total += weight[j] * gi[j] * (a * a + b * b)
            wi[2 * j] = gi[j] * a
            wi[2 * j + 1] = gi[j] * b
    sums[0] = total


@compiled
def total_pressure(start: int, stop: int, sums: Real, values: Real, n: int, touched: Marks) -> None:
    """sums: of values, zero where nothing is touched."""
    total = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            vi = values[i, tile * TILE : min(tile * TILE + TILE, n)]
            for j in range(vi.size):
                total += vi[j]
    sums[0] = total


@compiled
def trial(
    start: int, stop: int, sums: Real, p: Real, t: Real, step: float, out: Real, most: float, n: int, touched: Marks
) -> None:
    """Pressure out <- p - step t, cut at 0 and ``most``; sums: of what was cut (negative), of p - step t, of out."""
    below = before = after = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            pi, ti, oi = p[i, a:b], t[i, a:b], out[i, a:b]
            for j in range(pi.size):
                new = pi[j] - step * ti[j]
                below += min(new, 0.0) + min(most - new, 0.0)
                before += new
                new = min(max(new, 0.0), most)
                after += new
                oi[j] = new
    sums[0], sums[1], sums[2] = below, before, after


@compiled
def stretch(
    start: int, stop: int, sums: Real, p: Real, factor: float, out: Real, most: float, n: int, touched: Marks
) -> None:
    """Pressure out <- factor p, at most ``most``, which it stays where it is; sums: of out."""
    total = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            pi, oi = p[i, a:b], out[i, a:b]
            for j in range(pi.size):
                here = pi[j] if pi[j] >= most else min(factor * pi[j], most)
                oi[j] = here
                total += here
    sums[0] = total


@compiled
def advance(start: int, stop: int, sums: Real, z: Real, step: float, out: Real, n: int, lowest: Real) -> None:
    """After a free step, out holding G t: out <- -step G t, the change of z; z <- z + out."""
    for i in range(start, stop):
        for tile in range(lowest.shape[1]):
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            zi, oi = z[i, a:b], out[i, a:b]
            least = zi[0] - step * oi[0]
            for j in range(zi.size):
                change = -step * oi[j]
                new = zi[j] + change
                oi[j] = change
                zi[j] = new
                least = min(least, new)
            lowest[i, tile] = least


@compiled
def arrive(
    start: int, stop: int, sums: Real, p: Real, offset: Real, out: Real, n: int, touched: Marks, lowest: Real
) -> None:
    """Gap out <- out + offset, out holding G p; sums: of p (gap + offset)/2, the energy, and of its size."""
    energy = size = 0.0
    for i in range(start, stop):
        for tile in range(lowest.shape[1]):
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            hi, oi = offset[i, a:b], out[i, a:b]
            least = hi[0] + oi[0]
            for j in range(oi.size):
                gap = oi[j] + hi[j]
                oi[j] = gap
                least = min(least, gap)
            lowest[i, tile] = least
            if touched[i, tile] == 0:
                continue
            pi = p[i, a:b]
            for j in range(oi.size):
                energy += 0.5 * pi[j] * (oi[j] + hi[j])
                size += pi[j] * (abs(oi[j]) + abs(hi[j]))
    sums[0], sums[1] = energy, size


@compiled
def accept(start: int, stop: int, sums: Real, z: Real, new: Real, n: int) -> None:
    """Set z <- new and new <- the change of z."""
    for i in range(start, stop):
        zi, there = z[i, :n], new[i, :n]
        for j in range(zi.size):
            gap = there[j]
            there[j] = gap - zi[j]
            zi[j] = gap


@compiled
def misses(
    start: int, stop: int, sums: Real, p: Real, z: Real, shift: float, out: Real, most: float, n: int, worst: Real
) -> None:
    """Set out <- what closing the contact and lifting the overlaps adds to u; worst <- the largest of each row."""
    for i in range(start, stop):
        pi, zi, oi = p[i, :n], z[i, :n], out[i, :n]
        largest = 0.0
        for j in range(oi.size):
            gap = zi[j] + shift
            oi[j] = gap if ((pi[j] > 0.0) | (gap < 0.0)) & ((pi[j] < most) | (gap > 0.0)) else 0.0
            largest = max(largest, abs(oi[j]))
        worst[i] = largest


@compiled
def missed(first: int, last: int, sums: Real, work: Real, K: Real, weights: Real) -> None:
    """sums: |K work|² as a mean over the grid."""
    total = 0.0
    weight = weights[first:last]
    for i in range(K.shape[0]):
        wi, ki = work[i, 2 * first : 2 * last], K[i, first:last]
        for j in range(ki.size):
            a, b = ki[j] * wi[2 * j], ki[j] * wi[2 * j + 1]
            total += weight[j] * (a * a + b * b)
    sums[0] = total


@compiled
def work_above(start: int, stop: int, sums: Real, p: Real, z: Real, least: float, n: int, touched: Marks) -> None:
    """sums: of p (z - least), of p."""
    work = total = 0.0
    for i in range(start, stop):
        for tile in range(touched.shape[1]):
            if touched[i, tile] == 0:
                continue
            a, b = tile * TILE, min(tile * TILE + TILE, n)
            pi, zi = p[i, a:b], z[i, a:b]
            for j in range(pi.size):
                work += pi[j] * (zi[j] - least)
                total += pi[j]
    sums[0], sums[1] = work, total


@compiled
def finish(
    start: int, stop: int, sums: Real, p: Real, z: Real, by: float, smallest: float, most: float, n: int
) -> None:
    """Gap z <- z + by, exactly zero where p presses, negative where the wall gives way, and positive elsewhere."""
    for i in range(start, stop):
        pi, zi = p[i, :n], z[i, :n]
        for j in range(zi.size):
            gap = zi[j] + by
            if pi[j] > 0.0:
                zi[j] = min(gap, 0.0) if pi[j] >= most else 0.0
            else:
                zi[j] = smallest if gap < smallest else gap


@compiled
def spread(start: int, stop: int, sums: Real, coarse: Real, of: int, fine: Real, n: int) -> None:
    """Pressure of a coarser grid, of rows of ``of`` points, onto the finer one, bilinearly; sums: of it."""
    rows = coarse.shape[0]
    for i in range(start, stop):
        a = i * rows // fine.shape[0]
        b, x = (a + 1) % rows, i * rows / fine.shape[0] - a
        for j in range(n):
            k = j * of // n
            m, y = (k + 1) % of, j * of / n - k
            here = (1 - x) * coarse[a, k] + x * coarse[b, k]
            there = (1 - x) * coarse[a, m] + x * coarse[b, m]
            fine[i, j] = (1 - y) * here + y * there
            sums[0] += fine[i, j]
