"""The seam between mathematics and machine: what the grids of the solvers ask of a device, and the devices.

The solvers, :mod:`continuum.solve.smooth` and :mod:`continuum.solve.hard`, see scalars only.  A grid of a solve,
:mod:`continuum.solve.smooth_grid` or :mod:`continuum.solve.bound_grid`, names the fields and the order of the
operations.  An :class:`Engine` owns the memory: where fields lie, how they are padded and transformed, in how many
threads or on what device.  It is made once for a path and then takes one problem after the other.

A back end is a subclass of :class:`BackEnd`, and one line in :data:`BACK_ENDS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from importlib import import_module
from math import prod
from typing import Any, Protocol

import numpy as np

from continuum.model.fourier import Real, low_rows
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.solution import Work

Array = Any
"""An array of an engine, which nobody else looks into."""

BACK_ENDS = {
    "cpu": "continuum.solve.cpu",
    **dict.fromkeys(
        ("numpy", "torch", "torch:cuda", "torch:mps", "cupy", "jax", "cuda"),
        "continuum.solve.arrays",
    ),
}
"""Name of a device, and the module of its back end, imported when it is first asked for; "cuda" is the first of the
libraries that sees a GPU."""
SHORT_WAVES = 0.5
"""c0 of the preconditioner 1/(K + c0) for the waves that no coarser grid carries, in units of the largest K.

A step of the coarser grid brings its own waves to where the wall and the substrate hold them.  Beside it 1/K is too
long a step for the others, as in a contact the wall adds a stiffness of its own: 0.3 to 0.8 are about equally good.
"""


def back_end(device: str) -> BackEnd:
    """The back end of a device, ready to be used.

    Raises
    ------
    ValueError
        If there is none of that name.
    InputError
        If this machine has no such device, or a library is missing.
    """
    if device not in BACK_ENDS:
        msg = f"there is no device {device!r}: there is {', '.join(BACK_ENDS)}"
        raise ValueError(msg)
    found: BackEnd = import_module(BACK_ENDS[device]).back_end(device)
    found.require()
    return found


def all_modes(c0: float) -> dict[str, Any]:
    """What :func:`low_part` says where no coarser grid takes part: all modes are swept alike."""
    return {"low_rows": 0, "low_columns": 0, "c0": c0}


def low_part(K: Real, below: Grid | None) -> dict[str, Any]:
    """Which modes of a grid the next coarser one carries, and c0 for the others, as :attr:`Engine.low_part`."""
    if below is None:
        return all_modes(0.0)
    # K of the mean may be anything, and lies in the first column.
    short_waves = SHORT_WAVES * float(K[:, 1:].max())
    return {"low_rows": low_rows(below.shape_q[0]), "low_columns": below.shape_q[1] - 1, "c0": short_waves}


class BackEnd(ABC):
    """A device; its module makes one by its name, in a function ``back_end``."""

    SMALLEST: int
    """Grids of no more points along a side have no coarser one."""
    LEVELS = 3
    """Grids that a step of the smooth solver uses, at most."""
    CAUTION = ""
    """What its user has to know before relying on it; empty for nothing."""

    def require(self) -> None:  # noqa: B027 (by default nothing is missing)
        """Raise :class:`continuum.errors.InputError`, with what to install, where this machine cannot run it."""

    def machine(self) -> str:
        """Name of what it runs on, beyond the name of the device; empty for nothing."""
        return ""

    def devices(self) -> tuple[str, ...]:
        """Names of those that processes should not share; empty where they may."""
        return ()

    @abstractmethod
    def smooth_grid(self, grid: Grid, K: Real, threads: int, coarser: int, *, sampled: bool) -> Any:
        """The grid of the smooth solver and its coarser ones, as :class:`continuum.solve.smooth_grid.SmoothGrid`.

        K in E*/a0, shape ``grid.shape_q``, is not changed.  Raises MemoryError where it does not fit on the device.
        """

    @abstractmethod
    def bound_grid(self, grid: Grid, K: Real, threads: int) -> Any:
        """The same for the bound-constrained solver, as :class:`continuum.solve.bound_grid.BoundGrid`."""


class Engine(Protocol):
    """The arrays of one grid on one device, and sweeps of named kernels over them.

    A kernel gets by their names what is given, and what the engine has: K, the spectrum ``work``, the wall law, the
    scale of the transforms.  Sums are an array of six numbers.  A transform goes by way of one spectrum, ``w``: a
    field is made by :meth:`into` (half a transform), :meth:`spectral` goes over the modes (the other halves),
    :meth:`out_of` uses the field that was transformed back.  What an engine does when is its own: on processor cores
    each half is done block by block with its sweep, on a device :meth:`spectral` and :meth:`out_of` begin with the
    whole transform.
    """

    KEEPS_FIELDS: bool
    """Whether fields in real space are made once; else anew for each problem, and what is handed out is that memory."""
    w: Array
    """The spectrum that is transformed, real and imaginary parts in turn."""
    trials: int
    """Evaluations of the line search."""
    transforms: int
    """Halves of pairs of transforms."""
    low_part: dict[str, Any]
    """``low_rows`` and ``low_columns``: where the modes of the coarser grid lie; ``c0`` of the preconditioner for the
    others, where a step of that grid stands beside it."""

    @property
    def work(self) -> Work:
        """What was done for the problem at hand."""

    def forget_work(self) -> None:
        """Count the work from zero again."""

    def set_law(self, law: Law) -> None:
        """The wall law that kernels ask."""

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        """Set K at q = 0; where the mean is held, its mode vanishes after each forward transform in a sweep."""

    def rows(self) -> Array:
        """Memory of a field, with padded rows where that is faster."""

    def single_rows(self) -> Array:
        """The same in single precision."""

    def spectrum(self) -> Array:
        """Memory of a half spectrum."""

    def hold(self, values: Real, kept: Array) -> Array | None:
        """An array of the host, in the memory ``kept`` of a device that keeps its fields; None if it is not finite."""

    def upload(self, field: Array, values: Real) -> bool:
        """Copy an array of the host into a field; returns whether it is finite."""

    def download(self, field: Array) -> Real:
        """A field as an array of the host, shape ``grid.shape``."""

    def fill(self, values: Array, number: float) -> None:
        """The same number everywhere in a field or spectrum."""

    def shift(self, field: Array, by: float) -> None:
        """Add a number to a field."""

    def reflect(self, field: Array, offset: Array, lift: float) -> None:
        """Set field <- offset - field + lift: a gap of a displacement."""

    def set_mean(self, mean: float) -> None:
        """Set the mode q = 0 of ``w``."""

    def sample(self, fine: Array, coarse: Array) -> None:
        """Set a field of this grid to every second point of that of the finer one."""

    def restrict(self, spectrum: Array, below: Any, coarse: Array, size: float = 1.0) -> None:
        """Set a spectrum of the coarser engine to the modes of this one's over ``size``, without Nyquist modes."""

    def prolong(self, below: Any) -> None:
        """Set ``w`` to that of the coarser engine, zero beyond its modes."""

    def into(self, name: str, **given: Any) -> Real:
        """A kernel makes a field that is going to be transformed; returns its sums."""

    def spectral(
        self, name: str = "", *, forward: bool = False, inverse: bool = False, keep_low: bool = False, **given: Any
    ) -> Real:
        """A kernel over the modes, after a forward transform of ``w`` and before an inverse one; returns its sums.

        With ``keep_low`` the modes of the coarser grid are not transformed back yet: :meth:`low` does so.
        """

    def low(self, name: str, *, inverse: bool = False, **given: Any) -> Real:
        """A kernel over the modes of the coarser grid; returns its sums."""

    def out_of(self, name: str, **given: Any) -> Real:
        """A kernel uses the field that was transformed back; returns its sums."""

    def sweep(self, name: str, **given: Any) -> Real:
        """A kernel over the points without a transform; returns its sums."""

    def inverse(self, field: Array) -> None:
        """Transform ``w`` back into a field; not counted."""

    def elastic_energy(self, offset: Real, gap: Real, one: Array, other: Array) -> float:
        """½ <u K u> of u = offset - gap without its mean; in the memory of two arrays that are not in use."""


class SmoothEngine(Engine, Protocol):
    """What the smooth solver asks for beyond :class:`Engine`."""

    def has_tiles(self, engine: Any, z: Array, law: Law) -> bool:
        """Whether tiles near a wall pay, by a gap of this or the next coarser engine."""

    def near_wall(self, f: Array, z: Array, law: Law) -> Any:
        """A :class:`WallTileEngine` of the tiles where f is, or z in reach; None where that does not pay."""

    def forget_tiles(self) -> None:
        """Give the memory of tiles back that is kept from one to the next."""


class LinearEngine(Engine, Protocol):
    """What linear problems of coarser grids ask for beyond :class:`Engine`."""

    def through(self, name: str, **given: Any) -> Real:
        """A kernel over the field that was transformed back, which is transformed forward again; returns its sums."""

    def fields(self, spectra: tuple[Array, Array, Array]) -> tuple[Array, Array, Array, Array, Array]:
        """Three spectra and two fields, where possible in the memory of three spectra of the same grid's engine."""

    def level(self, g: Array, d: Array, x: Array, stiffness: Array, direction: Array) -> Any:
        """The arrays of a grid for :meth:`relax`; None where that is not one call."""

    def relax(
        self, levels: tuple[Any, ...], depth: int, shift: float, iterations: int, reduction: float
    ) -> tuple[bool, list[int]]:
        """All of :func:`continuum.solve.smooth.minimise_linear`; whether a step was taken, and the transforms made."""


class BoundEngine(Engine, Protocol):
    """What the bound-constrained solver asks for beyond :class:`Engine`.

    The kernels that make and use a transformed field are given the field ``out``, through which it may go.
    """

    def field(self) -> Array:
        """Memory of a field, whose rows may be padded."""

    def mask(self) -> Array:
        """Memory of the marks of the points in contact."""

    def clear_mask(self, mask: Array) -> None:
        """Take the mark from every point."""

    def scale(self, field: Array, factor: float) -> None:
        """Multiply a field by a number."""

    def total(self, field: Array) -> float:
        """Sum over the points."""

    def mean(self, field: Array) -> float:
        """Mean over the points."""

    def coarsen(self, fine: Array, below: Any, coarse: Array) -> None:
        """Set a field of the coarser engine to every second point of this one's, shifted to the same mean."""

    def load(self, field: Array) -> None:
        """Begin to transform a field as it is."""

    def comply(self, *, inverse: bool = False) -> float:
        """Multiply the spectrum of the field f at hand by G = 1/K, zero where K is; returns <f G f>.

        After the forward transform, and with ``inverse`` before the other one.
        """

    def guess(
        self, p: Array, start: Array, offset: Array, traction: Array, pressure: float | None, wide: float, least: float
    ) -> None:
        """Set p as :meth:`continuum.solve.bound_grid.BoundGrid.guess` says; ``traction`` is memory for a field.

        A gap of ``wide`` and more is wide, and of the start ``least`` is the smallest one.
        """

    def stiffen(self, mask: Array, out: Array, least: float, z: Array | None = None, shift: float = 0.0) -> float:
        """Set out <- M f on the contact, 0 off it, of f = z + shift, or 1 without z; returns its sum.

        M = Eᵀ K E, with ``least`` for K at q = 0.  For E, which uses :func:`nodes`, see
        :mod:`continuum.solve.cpu.extending`.
        """

    def misses(self, p: Array, z: Array, level: float, error: Array, spare: tuple[Array, Array]) -> tuple[float, float]:
        """The same as :meth:`continuum.solve.bound_grid.BoundGrid.misses`, in the memory of three fields."""

    def tiles(self, p: Array, z: Array, below: float) -> Any:
        """A :class:`TileEngine` of the tiles where p presses or z lies below a level; None where that does not pay."""

    def take(self, tiles: Any, values: Array, field: Array) -> None:
        """Take a field from the engine of some tiles; beyond these it stays as it is, and nothing presses."""

    def set_largest_pressure(self, most: float) -> None:
        """The pressure at which the wall gives way; infinite where it does not."""

    def duality_gap(self, p: Array, z: Array, spare: tuple[Array, Array]) -> tuple[float, float]:
        """The same as :meth:`continuum.solve.bound_grid.BoundGrid.duality_gap`, in the memory of two fields."""


class TileEngine(BoundEngine, Protocol):
    """What the bound-constrained solver asks for on tiles: what its iteration asks of :class:`BoundEngine`, and this.

    It has a model of the response, G.
    """

    def gather(self, whole: Array) -> Array:
        """The tiles of a field of the whole grid."""

    def alter(self, step: float, factor: float, **given: Array) -> float:
        """Set out <- the gap under the pressure new, ``factor`` times p - ``step`` t cut at zero, after :meth:`comply`.

        Returns by how much the energy rises, summed over the points.  Given are p, z, offset, t, new and out.
        """


class WallTileEngine(Engine, Protocol):
    """What the smooth solver asks for on tiles, beside a model of the response, G.  Fields are arrays of NumPy."""

    shape: tuple[int, int]
    """Of a field."""
    answer: Array
    """Memory of a field in single precision."""

    def field(self) -> Real:
        """A field of zeros."""

    def gather(self, whole: Array) -> Real:
        """The tiles of a field of the whole grid."""

    def scatter(self, values: Real, whole: Array) -> None:
        """The tiles back into a field of the whole grid."""

    def comply_with(self, values: Real, out: Array) -> Array:
        """Set out <- G times values, and return it."""

    def relent(self, missing: Real, stiffness: Array, out: Real) -> None:
        """Set out to about (1 + φ'' G)^-1 missing, φ'' being the stiffness."""

    def advance(self, step: float, law: Law, **given: Array) -> tuple[float, float]:
        """Set f <- f + step t and z <- z + step w, missing <- f - p(z), and the stiffness.

        Returns the sums of missing² and of the energy of the wall.  Given are these six.
        """

    def along(self, step: float, law: Law, **given: Array) -> tuple[float, float]:
        """Slope and curvature of the energy after such a step, summed.  Given are f, z, t and w."""


STEEPEST = 1e30
"""By more no pressure is scaled: as many of its points press as can."""
SMALLEST_GAP = float(np.finfo(np.float64).tiny)
"""Gap off the contact, at least: zero marks the contact."""
SPACING = 8
"""Points between the nodes on which the preconditioner under a bound extends the contact, nearly."""
SPREAD = 0.1
"""Share of contact near by at which that extension is half the mean of the contact there."""


def nodes(grid: Grid) -> tuple[int, int]:
    """Numbers of these nodes along x and y."""
    nx, ny = (max(round(points / SPACING), 1) for points in grid.shape)
    return nx, ny


def most_work(height: Real, mean: float, most: float) -> float:
    """Least mean of p times a height above the lowest point, over all p from 0 to ``most`` of a mean.

    It presses as hard as it may where the height is least.
    """
    filled = mean / most * height.size
    whole = min(int(filled), height.size - 1)
    lowest = np.partition(height.ravel(), whole)[: whole + 1]
    return float(most * (lowest[:whole].sum() + (filled - whole) * lowest[whole]) / height.size)


def reused(whole: Array, *shape: int) -> Array:
    """Memory that is not in use, as an array of this shape."""
    return whole.ravel()[: prod(shape)].reshape(shape)
