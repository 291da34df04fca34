"""Fourier transforms of fields with two periods on the device: cuFFT, in place; NumPy's in the simulator.

A field to be transformed lies in the memory of its half spectrum, the rows padded to it.  Neither transform divides by
the number of points: who writes a field to be transformed multiplies by 1/N, so that values_q has the convention of
:mod:`continuum.model.fourier`.

cuFFT's own interface is called through nvmath, since here it has strides of 64 bits, which grids of 32768² need, in
place means in place, and one work area serves the plans of all grids.
"""

from __future__ import annotations

import atexit
import weakref
from typing import Any

import numpy as np

from continuum.solve.cuda.device import SIMULATED, Array, empty


class Transforms:
    """Forward and inverse transform of one shape.

    Parameters
    ----------
    shape : (nx, ny) of the field.
    larger : transforms of a larger grid, whose work area is used.
    """

    def __init__(self, shape: tuple[int, int], larger: Transforms | None = None) -> None:
        self.shape = shape
        self.area: Array = None
        self.area_bytes = 0
        if not SIMULATED:
            self._plan(larger)

    def _plan(self, larger: Transforms | None) -> None:
        from nvmath.bindings import cufft

        nx, ny = self.shape
        nq = ny // 2 + 1
        real, half = ([nx, 2 * nq], 1, nx * 2 * nq), ([nx, nq], 1, nx * nq)
        plans, needed = [], 0
        for source, target, kind in ((real, half, cufft.Type.D2Z), (half, real, cufft.Type.Z2D)):
            plan = cufft.create()
            _release_in_time(self, cufft.destroy, plan)
            cufft.set_auto_allocation(plan, 0)
            needed = max(needed, cufft.make_plan_many64(plan, 2, [nx, ny], *source, *target, int(kind), 1))
            plans.append(plan)
        if larger is not None and larger.area_bytes >= needed:
            self.area, self.area_bytes = larger.area, larger.area_bytes
        else:
            self.area, self.area_bytes = empty(1, max(needed, 1), np.uint8), needed
        for plan in plans:
            cufft.set_work_area(plan, _address(self.area))
        self._forward, self._inverse = plans

    def forward(self, memory: Array) -> None:
        """Field to spectrum, shape (nx, 2 (ny//2 + 1)): sums over the points, no mean."""
        if SIMULATED:
            values = memory._ary
            values.view(np.complex128)[...] = np.fft.rfft2(values[:, : self.shape[1]])
        else:
            _cufft().exec_d2z(self._forward, _address(memory), _address(memory))

    def inverse(self, memory: Array) -> None:
        """Spectrum to field: the sum over all modes."""
        if SIMULATED:
            values = memory._ary
            values[:, : self.shape[1]] = np.fft.irfft2(values.view(np.complex128), s=self.shape, norm="forward")
        else:
            _cufft().exec_z2d(self._inverse, _address(memory), _address(memory))


def _release_in_time(owner: Transforms, release: Any, plan: int) -> None:
    """Release a plan when its owner goes, or at exit while the device still has its context.

    At exit the last function that was registered comes first.  What weakref itself registers, when a process first asks
    it for anything, comes later than all that has to do with a device.
    """
    whenever = weakref.finalize(owner, release, plan)
    whenever.atexit = False
    atexit.register(whenever)


def _cufft() -> Any:
    from nvmath.bindings import cufft

    return cufft


def _address(array: Array) -> int:
    return int(array.__cuda_array_interface__["data"][0])
