"""Sums of kernels: the same bits from run to run on one device, since nothing is added in the order of arrival.

The threads of a block add what they have in the memory that they share, in a fixed order, and leave one part for each
block.  One small kernel adds the parts, and six numbers are read.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.solve.cuda.device import (
    THREADS,
    Array,
    DeviceError,
    Kernel,
    Sums,
    cuda,
    device_function,
    driver_error,
    empty,
    larger,
    pinned,
)

SUMS = 6
"""Sums of a kernel, at most."""


@device_function
def leave(sums: Sums, parts: tuple[float, ...], largest: int = -1) -> None:
    """Leave the parts of a block, of which each thread has some: they are added by halves.

    Of the sum number ``largest`` the largest part is left.  All threads of the block have to come here.
    """
    shared = cuda.shared.array((SUMS, THREADS), np.float64)
    t, block = cuda.threadIdx.x, cuda.blockIdx.x
    for k in range(len(parts)):
        shared[k, t] = parts[k]
    half = THREADS // 2
    while half > 0:
        cuda.syncthreads()
        if t < half:
            for k in range(len(parts)):
                other = shared[k, t + half]
                shared[k, t] = larger(shared[k, t], other) if k == largest else shared[k, t] + other
        half //= 2
    if t == 0:
        for k in range(len(parts)):
            sums[k, block] = shared[k, 0]


@Kernel
def sum_parts(parts: Sums, count: int, largest: int, totals: Sums) -> None:
    """Add the first ``count`` parts of every sum; of the sum of that number take the largest part instead.

    A block adds one sum at a time.
    """
    shared = cuda.shared.array(THREADS, np.float64)
    t = cuda.threadIdx.x
    for slot in range(cuda.blockIdx.x, parts.shape[0], cuda.gridDim.x):
        total = -math.inf if slot == largest else 0.0
        for k in range(t, count, cuda.blockDim.x):
            total = larger(total, parts[slot, k]) if slot == largest else total + parts[slot, k]
        shared[t] = total
        half = THREADS // 2
        while half > 0:
            cuda.syncthreads()
            if t < half:
                shared[t] = larger(shared[t], shared[t + half]) if slot == largest else shared[t] + shared[t + half]
            half //= 2
        if t == 0:
            totals[slot, 0] = shared[0]
        cuda.syncthreads()


def wait_for(there: Array, read: Real) -> None:
    """Copy what the device has computed into an array of the host, which is pinned.

    Raises
    ------
    DeviceError
        If a launch failed: what it did wrong shows where it is waited for.
    """
    try:
        there.copy_to_host(read)
    except driver_error() as error:
        msg = f'the GPU failed: {error}; run again, which goes on from what is stored, or take device = "cpu"'
        raise DeviceError(msg) from error


class Reduction:
    """Memory for the sums of kernels, one after the other.

    Parameters
    ----------
    rows : over which a kernel goes, at most.
    """

    def __init__(self, rows: int) -> None:
        self.parts, self.totals, self.read = empty(SUMS, rows), empty(SUMS, 1), pinned(SUMS, 1)

    def __call__(self, kernel: Kernel, rows: int, *arguments: Any, largest: int = -1) -> Real:
        """Start a kernel over so many rows and wait for its sums, shape (SUMS,); those that it does not make are void.

        ``largest`` is the number of one of which the largest part is wanted.
        """
        kernel(rows, *arguments, self.parts)
        sum_parts(SUMS, self.parts, kernel.blocks(rows), largest, self.totals)
        wait_for(self.totals, self.read)
        totals: Real = self.read[:, 0].copy()
        return totals
