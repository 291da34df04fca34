"""Kernels over the points of the surface that need no wall law.

``work`` is the memory of a half spectrum, of whose rows the first numbers are a field; what is to be transformed is
scaled by 1/N.
"""

from __future__ import annotations

import math

from continuum.model.fourier import Real
from continuum.solve.cuda.device import Kernel, Single, Sums, cuda
from continuum.solve.cuda.sums import leave


@Kernel
def _put(values: Real, at_first: float) -> None:
    """One number, in the first place of an array."""
    if cuda.grid(1) == 0:
        values[0, 0] = at_first


@Kernel
def _fill(values: Real, number: float) -> None:
    """The same number everywhere."""
    for i in range(cuda.blockIdx.x, values.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values.shape[1], cuda.blockDim.x):
            values[i, j] = number


@Kernel
def _shift(values: Real, by: float) -> None:
    """Add a number."""
    for i in range(cuda.blockIdx.x, values.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values.shape[1], cuda.blockDim.x):
            values[i, j] += by


@Kernel
def _total(values: Real, sums: Sums) -> None:
    """sums: of the finite values; of how many are not."""
    points = lost = 0.0
    for i in range(cuda.blockIdx.x, values.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values.shape[1], cuda.blockDim.x):
            value = values[i, j]
            if math.isfinite(value):
                points += value
            else:
                lost += 1.0
    leave(sums, (points, lost))


@Kernel
def _copy(work: Real, values: Real, scale: float, sums: Sums) -> None:
    total = 0.0
    for i in range(cuda.blockIdx.x, values.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values.shape[1], cuda.blockDim.x):
            work[i, j] = scale * values[i, j]
            total += values[i, j]
    leave(sums, (total,))


@Kernel
def _keep(values: Real, work: Real) -> None:
    """The field in work."""
    for i in range(cuda.blockIdx.x, values.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, values.shape[1], cuda.blockDim.x):
            values[i, j] = work[i, j]


@Kernel
def _displace(work: Real, z: Real, offset: Real, lift: float, scale: float, sums: Sums) -> None:
    displaced = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            u = offset[i, j] + lift - z[i, j]
            work[i, j] = scale * u
            displaced += u
    leave(sums, (displaced,))


@Kernel
def _lay(z: Real, work: Real, offset: Real, lift: float) -> None:
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            z[i, j] = offset[i, j] + lift - work[i, j]


@Kernel
def _above(z: Real, offset: Real, lift: float) -> None:
    """The same where z holds u."""
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            z[i, j] = offset[i, j] - z[i, j] + lift


@Kernel
def _every_second(z: Real, fine: Real) -> None:
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            z[i, j] = fine[2 * i, 2 * j]


@Kernel
def _sampled(out: Single, fine: Single) -> None:
    """The same in single precision."""
    for i in range(cuda.blockIdx.x, out.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, out.shape[1], cuda.blockDim.x):
            out[i, j] = fine[2 * i, 2 * j]
