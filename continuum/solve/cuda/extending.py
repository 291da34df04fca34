"""Kernels that extend a field from the contact to what lies around it; see :mod:`continuum.solve.cpu.extending`.

Nodes lie in arrays of shape (nodes along x, along y), without repetition, and each gathers from the points around it.
"""

from __future__ import annotations

from continuum.model.fourier import Real
from continuum.solve.cuda.device import Kernel, Mask, Sums, cuda, device_function
from continuum.solve.cuda.sums import leave


@device_function
def _between(values: Real, i: int, j: int, rows: int, columns: int) -> float:
    """A field over the nodes at a point, bilinearly."""
    nx, ny = values.shape
    a, b = i * nx // rows, j * ny // columns
    x, y = (i * nx % rows) / rows, (j * ny % columns) / columns
    c, d = (a + 1) % nx, (b + 1) % ny
    first = (1.0 - y) * values[a, b] + y * values[a, d]
    second = (1.0 - y) * values[c, b] + y * values[c, d]
    value: float = (1.0 - x) * first + x * second
    return value


@Kernel
def _gather(field: Real, density: Real, mask: Mask, z: Real, shift: float, ones: int) -> None:
    """Gather the contact onto the nodes: field <- z + shift, or 1; density <- 1."""
    (rows, columns), (nx, ny) = mask.shape, field.shape
    scale = float(nx) * ny / (float(rows) * columns)
    for a in range(cuda.blockIdx.x, nx, cuda.gridDim.x):
        for b in range(cuda.threadIdx.x, ny, cuda.blockDim.x):
            total = count = 0.0
            for m in range(-(-(a - 1) * rows // nx), -(-(a + 1) * rows // nx)):
                x = 1.0 - abs(m * nx - a * rows) / rows
                i = m % rows
                for n in range(-(-(b - 1) * columns // ny), -(-(b + 1) * columns // ny)):
                    j = n % columns
                    if mask[i, j]:
                        weight = x * (1.0 - abs(n * ny - b * columns) / columns)
                        count += weight
                        total += weight * (1.0 if ones else z[i, j] + shift)
            field[a, b] = scale * total
            density[a, b] = scale * count


@Kernel
def _extend(
    work: Real,
    mask: Mask,
    z: Real,
    shift: float,
    ones: int,
    field: Real,
    density: Real,
    spread: float,
    scale: float,
) -> None:
    """Set work <- z + shift, or 1, on the contact, its extension elsewhere; all times scale."""
    rows, columns = mask.shape
    for i in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, columns, cuda.blockDim.x):
            if mask[i, j]:
                here = 1.0 if ones else z[i, j] + shift
            else:
                here = _between(field, i, j, rows, columns) / (_between(density, i, j, rows, columns) + spread)
            work[i, j] = scale * here


@Kernel
def _withdraw(field: Real, work: Real, mask: Mask, density: Real, spread: float) -> None:
    """From beside the contact, onto the nodes: field <- work over the density and spread."""
    (rows, columns), (nx, ny) = mask.shape, field.shape
    scale = float(nx) * ny / (float(rows) * columns)
    for a in range(cuda.blockIdx.x, nx, cuda.gridDim.x):
        for b in range(cuda.threadIdx.x, ny, cuda.blockDim.x):
            total = 0.0
            for m in range(-(-(a - 1) * rows // nx), -(-(a + 1) * rows // nx)):
                x = 1.0 - abs(m * nx - a * rows) / rows
                i = m % rows
                for n in range(-(-(b - 1) * columns // ny), -(-(b + 1) * columns // ny)):
                    j = n % columns
                    if not mask[i, j]:
                        weight = x * (1.0 - abs(n * ny - b * columns) / columns)
                        total += weight * work[i, j] / (_between(density, i, j, rows, columns) + spread)
            field[a, b] = scale * total


@Kernel
def _give_back(out: Real, mask: Mask, work: Real, field: Real, sums: Sums) -> None:
    """On the contact out <- work + what the nodes give, 0 off it; sums: of out."""
    rows, columns = mask.shape
    total = 0.0
    for i in range(cuda.blockIdx.x, rows, cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, columns, cuda.blockDim.x):
            here = work[i, j] + _between(field, i, j, rows, columns) if mask[i, j] else 0.0
            out[i, j] = here
            total += here
    leave(sums, (total,))
