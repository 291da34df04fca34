"""Compiled sweeps over the points of the surface that need no wall law.

A sweep is a function of the rows ``first:last`` of a block, as those of :mod:`continuum.solve.compiled.tractions`.
"""

from continuum.model.fourier import Real
from continuum.solve.compiled.compiling import Field, Marks, Single, compiled, inlined


@compiled
def sampled(first: int, last: int, sums: Real, fine: Field, of: int, out: Field, n: int) -> None:
    """Values of a field of the finer grid, whose rows have ``of`` points, at or just before those of this one."""
    for i in range(first, last):
        row = fine[i * fine.shape[0] // out.shape[0]]
        if of == 2 * n:
            for j in range(n):
                out[i, j] = row[2 * j]
        else:
            for j in range(n):
                out[i, j] = row[j * of // n]


@compiled
def linear_direction(
    first: int, last: int, sums: Real, s: Field, d: Field, n: int, beta: float, stiffness: Single
) -> None:
    """New direction, d <- beta d - s, and the traction of the wall along it, stiffness d, in place of s.

    sums: of stiffness d².
    """
    b = d.dtype.type(beta)
    for i in range(first, last):
        direction, step, stiff = d[i, :n], s[i - first, :n], stiffness[i, :n]
        for j in range(direction.size):
            direction[j] = b * direction[j] - step[j]
        # Two loops vectorise where one does not.
        curvature = d.dtype.type(0.0)
        for j in range(direction.size):
            pull = stiff[j] * direction[j]
            step[j] = pull
            curvature += pull * direction[j]
        sums[0] += curvature


@compiled
def displace(first: int, last: int, sums: Real, out: Real, z: Real, n: int, offset: Real, lift: float) -> None:
    """Displacement u = offset + lift - z into ``out``, or z from u.  sums: of it."""
    total = 0.0
    for i in range(first, last):
        for j in range(n):
            u = offset[i, j] + lift - z[i, j]
            out[i - first, j] = u
            total += u
    sums[0] = total


@compiled
def copy(first: int, last: int, sums: Real, out: Real, values: Real, n: int) -> None:
    """The values themselves into ``out``.  sums: of them."""
    total = 0.0
    for i in range(first, last):
        for j in range(n):
            out[i - first, j] = values[i, j]
            total += values[i, j]
    sums[0] = total


@inlined
def untouched(marks: Marks) -> bool:
    """Whether all tiles of a row are marked 0.  A loop: the maximum of an array takes numba seconds to compile."""
    touched = False
    for tile in range(marks.size):
        touched |= marks[tile] != 0
    return not touched
