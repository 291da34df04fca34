"""Kernels of the bound-constrained solver; what they do is said in :mod:`continuum.solve.cpu.pressing`.

``work`` is as in :mod:`continuum.solve.cuda.points` and :mod:`continuum.solve.cuda.spectra`.
"""

from __future__ import annotations

from continuum.model.fourier import Real
from continuum.solve.cuda.device import Kernel, Mask, Sums, complex_at, cuda, larger, set_complex, smaller
from continuum.solve.cuda.sums import leave

# --- where it starts -------------------------------------------------------------------------------------------


@Kernel
def _mark(mask: Mask, number: int) -> None:
    """The same mark everywhere."""
    for i in range(cuda.blockIdx.x, mask.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, mask.shape[1], cuda.blockDim.x):
            mask[i, j] = number


@Kernel
def _scale(values: Real, factor: float) -> None:
    """All values times a number."""
    for i in range(cuda.blockIdx.x, values.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values.shape[1], cuda.blockDim.x):
            values[i, j] *= factor


@Kernel
def _wide(work: Real, z: Real, mean: float, sums: Sums) -> None:
    """Where the gap is at least its mean; sums: of the field in work, and how many points."""
    total = count = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            if z[i, j] >= mean:
                total += work[i, j]
                count += 1.0
    leave(sums, (total, count))


@Kernel
def _guess(p: Real, work: Real, z: Real, more: float, stiffest: float, least: float, most: float) -> None:
    """Pressure of a start: where the traction in work, and ``more``, pushes and it nearly touches."""
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            here = work[i, j] + more
            p[i, j] = smaller(larger(here, 0.0), most) if here > stiffest * (z[i, j] - least) else 0.0


@Kernel
def _spread(fine: Real, coarse: Real, sums: Sums) -> None:
    rows, columns = coarse.shape
    total = 0.0
    for i in range(cuda.blockIdx.x, fine.shape[0], cuda.gridDim.x):
        a = i // 2
        b = (a + i % 2) % rows
        for j in range(cuda.threadIdx.x, columns, cuda.blockDim.x):
            k = j + 1 if j + 1 < columns else 0
            here = 0.5 * (coarse[a, j] + coarse[b, j])
            there = 0.5 * (coarse[a, k] + coarse[b, k])
            fine[i, 2 * j] = here
            fine[i, 2 * j + 1] = 0.5 * (here + there)
            total += here + 0.5 * (here + there)
    leave(sums, (total,))


# --- the preconditioner ----------------------------------------------------------------------------------------


@Kernel
def _multiply(work: Real, values_q: Real, factor: float) -> None:
    for i in range(cuda.blockIdx.x, values_q.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values_q.shape[1], cuda.blockDim.x):
            here = factor * values_q[i, j]
            a, b = complex_at(work, i, j)
            set_complex(work, i, j, here * a, here * b)


@Kernel
def _level(p: Real, z: Real, m: Real, most: float, sums: Sums) -> None:
    mz = in_m = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            if 0.0 < p[i, j] < most:
                mz += m[i, j] * z[i, j]
                in_m += m[i, j]
    leave(sums, (mz, in_m))


@Kernel
def _select(p: Real, z: Real, shift: float, mask: Mask, m: Real, most: float, sums: Sums) -> None:
    mz = in_m = count = changed = eighth = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            gap = z[i, j] + shift
            touches = 1 if (p[i, j] > 0.0 or gap < 0.0) and (p[i, j] < most or gap > 0.0) else 0
            if touches != mask[i, j]:
                changed += 1.0
                mask[i, j] = touches
            if touches:
                count += 1.0
                mz += m[i, j] * z[i, j]
                in_m += m[i, j]
                eighth += (gap * gap * gap * gap) ** 2
            else:
                m[i, j] = 0.0
    leave(sums, (count, changed, mz, in_m, eighth))


@Kernel
def _ones(m: Real, mask: Mask) -> None:
    for i in range(cuda.blockIdx.x, mask.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, mask.shape[1], cuda.blockDim.x):
            m[i, j] = 1.0 if mask[i, j] else 0.0


@Kernel
def _correct(mask: Mask, z: Real, change: Real, t: Real, s: Real, m: Real, weight: float, sums: Sums) -> None:
    ss = zs = ys = in_t = zt = zm = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
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
    leave(sums, (ss, zs, ys, in_t, zt, zm))


# --- a step ----------------------------------------------------------------------------------------------------


@Kernel
def _turn_on_contact(
    work: Real, mask: Mask, t: Real, s: Real, m: Real, beta: float, weight: float, scale: float
) -> None:
    for i in range(cuda.blockIdx.x, t.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, t.shape[1], cuda.blockDim.x):
            here = t[i, j]
            if mask[i, j]:
                here = s[i, j] + beta * (here - weight * m[i, j])
                t[i, j] = here
            work[i, j] = scale * here


@Kernel
def _compliance(work: Real, K: Real, single: int, sums: Sums) -> None:
    """Spectrum work <- work/K, zero where K is; sums: <work, work/K> as a mean over the grid."""
    total = 0.0
    for i in range(cuda.blockIdx.x, K.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            k = K[i, j]
            g = 1.0 / k if k > 0.0 else 0.0
            a, b = complex_at(work, i, j)
            set_complex(work, i, j, g * a, g * b)
            both = g * (a * a + b * b)
            total += both if j in (0, single) else 2.0 * both
    leave(sums, (total,))


@Kernel
def _trial(p: Real, t: Real, step: float, out: Real, most: float, sums: Sums) -> None:
    below = before = after = 0.0
    for i in range(cuda.blockIdx.x, p.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, p.shape[1], cuda.blockDim.x):
            new = p[i, j] - step * t[i, j]
            before += new
            if new < 0.0:
                below += new
                new = 0.0
            elif new > most:
                below += most - new
                new = most
            after += new
            out[i, j] = new
    leave(sums, (below, before, after))


@Kernel
def _stretch(p: Real, factor: float, out: Real, most: float, sums: Sums) -> None:
    total = 0.0
    for i in range(cuda.blockIdx.x, p.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, p.shape[1], cuda.blockDim.x):
            here = p[i, j]
            here = here if here >= most else smaller(factor * here, most)
            out[i, j] = here
            total += here
    leave(sums, (total,))


@Kernel
def _advance(z: Real, out: Real, work: Real, step: float) -> None:
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            by = -step * work[i, j]
            out[i, j] = by
            z[i, j] += by


@Kernel
def _arrive(out: Real, p: Real, offset: Real, work: Real, sums: Sums) -> None:
    energy = size = 0.0
    for i in range(cuda.blockIdx.x, p.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, p.shape[1], cuda.blockDim.x):
            rest = offset[i, j]
            gap = work[i, j] + rest
            out[i, j] = gap
            energy += 0.5 * p[i, j] * (gap + rest)
            size += p[i, j] * (abs(gap) + abs(rest))
    leave(sums, (energy, size))


@Kernel
def _accept(z: Real, new: Real) -> None:
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            here = new[i, j]
            new[i, j] = here - z[i, j]
            z[i, j] = here


# --- the outcome -----------------------------------------------------------------------------------------------


@Kernel
def _misses(work: Real, p: Real, z: Real, shift: float, scale: float, most: float, sums: Sums) -> None:
    largest = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            gap = z[i, j] + shift
            right = (p[i, j] <= 0.0 and gap >= 0.0) or (p[i, j] >= most and gap <= 0.0)
            error = 0.0 if right else gap  # also where the gap is no number
            largest = larger(largest, abs(error))
            work[i, j] = scale * error
    leave(sums, (largest,), 0)


@Kernel
def _certificate(p: Real, z: Real, sums: Sums) -> None:
    """sums: p z, p, and of the third the largest part: minus the smallest z."""
    pz = total = 0.0
    depth = -float("inf")
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            pz += p[i, j] * z[i, j]
            total += p[i, j]
            depth = larger(depth, -z[i, j])
    leave(sums, (pz, total, depth), 2)


@Kernel
def _square(work: Real, K: Real, single: int, sums: Sums) -> None:
    """sums: |K e|², the spectrum of e in work."""
    total = 0.0
    for i in range(cuda.blockIdx.x, K.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, K.shape[1], cuda.blockDim.x):
            a, b = complex_at(work, i, j)
            k = K[i, j]
            total += (k * a * k * a + k * b * k * b) * (1.0 if j in (0, single) else 2.0)
    leave(sums, (total,))


@Kernel
def _finish(p: Real, z: Real, by: float, smallest: float, most: float) -> None:
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            gap = z[i, j] + by
            if p[i, j] > 0.0:
                z[i, j] = smaller(gap, 0.0) if p[i, j] >= most else 0.0
            else:
                z[i, j] = larger(gap, smallest)
