"""The engine of NVIDIA GPUs: fields that stay on the device, a launch for each sweep, transforms at the right place."""

from __future__ import annotations

from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.backend import low_part, reused
from continuum.solve.cuda import extending, points, pressing, relax, spectra, sums, walls
from continuum.solve.cuda.device import Array, Kernel, empty, to_device
from continuum.solve.cuda.sums import Reduction
from continuum.solve.cuda.transforms import Transforms
from continuum.solve.solution import Work

KERNELS = {
    name.removeprefix("_"): kernel
    for module in (sums, points, spectra, walls, relax, pressing, extending)
    for name, kernel in vars(module).items()
    if isinstance(kernel, Kernel)
}
"""All kernels by their names."""
NO_SUMS = np.empty(0)
"""The sums of a kernel that makes none."""


class CudaEngine:
    """What :class:`continuum.solve.backend.Engine` asks for; all fields are of shape ``grid.shape``, without padding.

    Parameters
    ----------
    grid : gives the shape.
    K : over the half spectrum, shape ``grid.shape_q``; what is not finite counts as zero.
    below : the next coarser grid, whose modes are swept apart.
    finer : the engine of a finer grid, or another one of the same, whose memory for transforms and sums is used, and
        whose K if it is of the same.
    """

    KEEPS_FIELDS = True

    def __init__(self, grid: Grid, K: Real, below: Grid | None = None, finer: CudaEngine | None = None) -> None:
        self.grid, self.size, self.per_point = grid, grid.size, 1.0 / grid.size
        self.w = self.spectrum()
        same = finer if finer and finer.grid.shape == grid.shape else None
        self.transform: Transforms = (
            same.transform if same else Transforms(grid.shape, finer.transform if finer else None)
        )
        self.K: Array = same.K if same else to_device(np.where(np.isfinite(K), K, 0.0))
        self.reduction: Reduction = finer.reduction if finer else Reduction(grid.shape[0])
        self.low_part = low_part(K, below)
        self._own: dict[str, Any] = {
            "K": self.K,
            "work": self.w,
            "single": -1 if grid.shape[1] % 2 else grid.shape_q[1] - 1,
            "scale": self.per_point,
            **self.low_part,
        }
        self._held = False
        self._known: Real | None = None
        """The last array of the host that was held, if nobody can have changed it, and where it lies."""
        self._there: Array = None
        self.transforms = self.trials = 0

    @property
    def work(self) -> Work:
        """What was done on this grid for the problem at hand; transforms are started and not waited for: no times."""
        return Work(self.grid.shape, self.transforms / 2, self.trials, 0.0)

    def forget_work(self) -> None:
        """Count the work from zero again."""
        self.transforms = self.trials = 0

    # --- the problem ---------------------------------------------------------------------------------------

    def set_law(self, law: Law) -> None:
        self._own |= {"kind": law.kind, "parameters": to_device(law.parameters), "reach": law.reach}

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        KERNELS["put"](1, self.K, stiffness)
        self._held = held
        self._own["held"] = int(held)

    # --- arrays --------------------------------------------------------------------------------------------

    def rows(self, kind: Any = np.float64) -> Array:
        return empty(*self.grid.shape, kind)

    def single_rows(self) -> Array:
        return self.rows(np.float32)

    def spectrum(self) -> Array:
        return empty(self.grid.shape[0], 2 * self.grid.shape_q[1])

    def hold(self, values: Real, kept: Array) -> Array | None:
        # An array that nobody can have changed since the last problem is there already.
        if values is self._known:
            return kept
        self._known = None
        finite = self.upload(kept, values)
        if finite and not values.flags.writeable and values.base is None:
            self._known, self._there = values, kept
        return kept if finite else None

    def upload(self, field: Array, values: Real) -> bool:
        field.copy_to_device(np.ascontiguousarray(values, dtype=np.float64))
        return bool(self.sweep("total", values=field)[1] == 0)

    def download(self, field: Array) -> Real:
        values: Real = field.copy_to_host()
        return values

    def fill(self, values: Array, number: float) -> None:
        self.sweep("fill", values=values, number=number)

    def shift(self, field: Array, by: float) -> None:
        self.sweep("shift", values=field, by=by)

    def reflect(self, field: Array, offset: Array, lift: float) -> None:
        self.sweep("above", z=field, offset=offset, lift=lift)

    def set_mean(self, mean: float) -> None:
        KERNELS["put"](1, self.w, mean)

    def sample(self, fine: Array, coarse: Array) -> None:
        if coarse.dtype == np.float32:
            self.sweep("sampled", fine=fine, out=coarse)
        else:
            self.sweep("every_second", fine=fine, z=coarse)

    def restrict(self, spectrum: Array, below: CudaEngine, coarse: Array, size: float = 1.0) -> None:
        below.sweep("restrict", coarse=coarse, fine=spectrum, factor=1.0 / size)

    def prolong(self, below: CudaEngine) -> None:
        self.sweep("prolong", fine=self.w, coarse=below.w)

    # --- sweeps --------------------------------------------------------------------------------------------

    def sweep(self, name: str, *, largest: int = -1, **given: Any) -> Real:
        """With ``largest`` the largest part of the sum of that number is wanted."""
        return self._start(KERNELS[name], self.grid.shape[0], given, largest)

    def into(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        return self.sweep(name, **given)

    def out_of(self, name: str, **given: Any) -> Real:
        self.transforms += 1
        self.transform.inverse(self.w)
        return self.sweep(name, **given)

    def spectral(
        self, name: str = "", *, forward: bool = False, inverse: bool = False, keep_low: bool = False, **given: Any
    ) -> Real:
        kernel = KERNELS[name] if name else None
        if forward:
            self.transform.forward(self.w)
            if self._held and not (kernel and "held" in kernel.needs):
                self.set_mean(0.0)
        return self._start(kernel, self.grid.shape[0], given) if kernel else NO_SUMS

    def low(self, name: str, *, inverse: bool = False, **given: Any) -> Real:
        return self._start(KERNELS[name], 2 * self.low_part["low_rows"] - 1, given)

    def _start(self, kernel: Kernel, rows: int, given: dict[str, Any], largest: int = -1) -> Real:
        """Start a kernel with what is given, and else with what the engine has of that name; wait for its sums."""
        arguments = [given[name] if name in given else self._own[name] for name in kernel.needs]
        if kernel.summed:
            return self.reduction(kernel, rows, *arguments, largest=largest)
        kernel(rows, *arguments)
        return NO_SUMS

    # --- whole fields --------------------------------------------------------------------------------------

    def has_tiles(self, engine: object, z: Array, law: Law) -> bool:
        """Never."""
        return False

    def near_wall(self, f: Array, z: Array, law: Law) -> None:
        """None: there are no tiles."""

    def forget_tiles(self) -> None:
        """Nothing: there are none."""

    def inverse(self, field: Array) -> None:
        self.transform.inverse(self.w)
        self.sweep("keep", values=field)

    def elastic_energy(self, offset: Real, gap: Real, one: Array, other: Array) -> float:
        z, there = reused(one, *self.grid.shape), self._there
        self.upload(z, gap)
        if offset is not self._known:
            there = reused(other, *self.grid.shape)
            self.upload(there, offset)
        self.sweep("displace", z=z, offset=there, lift=0.0)
        self.transform.forward(self.w)
        return 0.5 * float(self.sweep("energy")[0])
