"""Kernels over the points of the surface that ask the wall law: its traction, energy and stiffness.

The formulas are those of :mod:`continuum.model.laws`, compiled anew: one source for both devices.  Points beyond the
reach of the law are not computed; points that are not numbers are, so that they are not lost.  ``work`` is the memory
of a half spectrum, of whose rows ``z.shape[1]`` numbers are the field; what is to be transformed is scaled by 1/N.
What they do is said in :mod:`continuum.solve.cpu.tractions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from continuum.model import laws
from continuum.model.fourier import Real
from continuum.solve.cuda.device import Kernel, Parameters, Single, Sums, cuda, device_function
from continuum.solve.cuda.sums import leave

Formula = Callable[[float, Real], tuple[float, float, float]]
Response = Callable[[int, float, Real], tuple[float, float, float]]


@device_function
def _no_law(kind: int, z: float, p: Parameters) -> tuple[float, float, float]:
    return math.nan, math.nan, math.nan


def _or(kind: int, formula: Formula, others: Response) -> Response:
    """Energy, traction and stiffness per area at one gap: by the formula if the law is of this kind."""

    @device_function
    def respond(asked: int, z: float, p: Parameters) -> tuple[float, float, float]:
        return formula(z, p) if asked == kind else others(asked, z, p)

    return respond


_known: Response = _no_law
for _kind, _formula in reversed(list(enumerate(laws.FORMULAS))):
    _known = _or(_kind, device_function(_formula), _known)


@device_function
def _respond(kind: int, z: float, p: Parameters) -> tuple[float, float, float]:
    """Energy, traction and stiffness per area of a law; NaN where the gap is, of which some formulas make numbers."""
    return _known(kind, z, p) if z == z else (z, z, z)  # only NaN differs from itself


@Kernel
def _press(
    work: Real, z: Real, traction: Real, stiffness: Single, kind: int, parameters: Parameters, reach: float,
    scale: float, sums: Sums,
) -> None:  # fmt: skip
    energy = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            gap = z[i, j]
            push = stiff = 0.0
            if not gap >= reach:
                here = _respond(kind, gap, parameters)
                push, stiff = here[1], here[2]
                energy += here[0]
            work[i, j] = scale * push
            traction[i, j], stiffness[i, j] = push, stiff
    leave(sums, (energy,))


@Kernel
def _turn(d: Real, work: Real, stiffness: Single, beta: float, sums: Sums) -> None:
    curvature = 0.0
    for i in range(cuda.blockIdx.x, d.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, d.shape[1], cuda.blockDim.x):
            e = beta * d[i, j] - work[i, j]
            d[i, j] = e
            curvature += stiffness[i, j] * e * e
    leave(sums, (curvature,))


@Kernel
def _line(
    z: Real, d: Real, traction: Real, alpha: float, kind: int, parameters: Parameters, reach: float, sums: Sums
) -> None:
    slope = curvature = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            gap, e = z[i, j], d[i, j]
            trial = gap - alpha * e
            if not gap >= reach or not trial >= reach:
                there = _respond(kind, trial, parameters)
                slope += (there[1] - traction[i, j]) * e
                curvature += there[2] * e * e
    leave(sums, (slope, curvature))


@Kernel
def _move(
    work: Real, z: Real, d: Real, traction: Real, stiffness: Single, step: float, alpha: float, kind: int,
    parameters: Parameters, reach: float, scale: float, sums: Sums,
) -> None:  # fmt: skip
    slope = before = energy = size = 0.0
    for i in range(cuda.blockIdx.x, z.shape[0], cuda.gridDim.x):
        for j in range(cuda.threadIdx.x, z.shape[1], cuda.blockDim.x):
            e, last = d[i, j], z[i, j]
            gap = last - step * e
            z[i, j] = gap
            old = gap + alpha * e
            change = 0.0
            if not gap >= reach or not old >= reach or not last >= reach:
                # What is kept is that of an earlier one of the steps, if there was one.
                here = traction[i, j] if step == alpha else _respond(kind, old, parameters)[1]
                there = _respond(kind, gap, parameters)
                change = there[1] - here
                slope += change * e
                before += here * e
                energy += there[0]
                size += abs(there[0])
                traction[i, j], stiffness[i, j] = there[1], there[2]
            work[i, j] = scale * change
    leave(sums, (slope, before, energy, size))
