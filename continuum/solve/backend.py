"""The devices on which a solve may run: what makes its grids, and the constants that all kinds of grids share.

A back end is a subclass of :class:`BackEnd`, and a line in :data:`BACK_ENDS`.  What its grids are asked for stands in
:mod:`continuum.solve.grids`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from importlib import import_module

import numpy as np
import scipy

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.shared_grid import Company
from continuum.solve.grids import BoundGrid, SmoothGrid

BACK_ENDS = {
    "cpu": "continuum.solve.compiled.back_end",
    **dict.fromkeys(
        ("numpy", "torch", "torch:cuda", "cupy", "jax", "cuda"),
        "continuum.solve.arrays.back_end",
    ),
}
"""Name of a device, and the module of its back end, imported when it is first asked for; "cuda" is the first of the
libraries that sees a GPU."""
SMOOTH_FIELDS, BOUND_FIELDS = 22.0, 16.0
"""Memory that a solve on whole arrays needs under a law and under a bound, in fields of the finest grid, where a pass
has no intermediate ones."""
SHORT_WAVES = 0.5
"""c0 of the preconditioner 1/(K + c0) for the waves that no coarser grid carries, in units of the largest K.

A step of the coarser grid brings its own waves to where the wall and the substrate hold them.  Beside it 1/K is too
long a step for the others, as in a contact the wall adds a stiffness of its own: 0.3 to 0.8 are about equally good.
"""


SHARDED = "jax"
"""The device whose fields may lie in slabs on several."""


def back_end(device: str, parts: int = 1) -> BackEnd:
    """The back end of a device, ready to be used, or of one that is several, each with a part of the points.

    Raises
    ------
    ValueError
        If there is none of that name, or it is not made of parts.
    InputError
        If this machine has no such device, or a library is missing.
    """
    if device not in BACK_ENDS:
        msg = f"there is no device {device!r}: there is {', '.join(BACK_ENDS)}"
        raise ValueError(msg)
    if parts > 1 and device != SHARDED:
        msg = f'shards = {parts} needs device = "{SHARDED}", not {device!r}'
        raise ValueError(msg)
    found: BackEnd = import_module(BACK_ENDS[device]).BACK_END(*((device, parts) if parts > 1 else (device,)))
    found.require()
    return found


class BackEnd(ABC):
    """A device, by its name; its module has the class, or what makes one, as ``BACK_END``."""

    SMALLEST = 128
    """Grids of no more points along a side have no coarser one: there calls, not points, would take the time."""
    LEVELS = 3
    """Grids that a step of the smooth solver uses, at most."""

    def __init__(self, device: str, parts: int = 1) -> None:
        self.device, self.parts = device, parts

    def require(self) -> None:  # noqa: B027 (by default nothing is missing)
        """Raise :class:`continuum.inputs.errors.InputError`, with what to install, where this machine cannot run it."""

    def machine(self) -> str:
        """Name of what it runs on, beyond the name of the device; empty for nothing."""
        return ""

    def memory(self) -> float:
        """Bytes that are free on one device; infinite where nobody knows."""
        return np.inf

    def company(self) -> Company | None:
        """The processes that share its points, each with slabs of them; None where it has no parts."""
        return None

    def devices(self) -> tuple[str, ...]:
        """Names of those that processes should not share; empty where they may."""
        return ()

    @abstractmethod
    def smooth_grid(self, grid: Grid, K: Real, threads: int, coarser: int, *, sampled: bool) -> SmoothGrid:
        """The grid of the smooth solver and its coarser ones.

        K in E*/a0, shape ``grid.shape_q``, is not changed.  Raises MemoryError where it does not fit on the device.
        """

    @abstractmethod
    def bound_grid(self, grid: Grid, K: Real, threads: int) -> BoundGrid:
        """The same for the bound-constrained solver."""


STEEPEST = 1e30
"""By more no pressure is scaled: as many of its points press as can."""
SMALLEST_GAP = float(np.finfo(np.float64).tiny)
"""Gap off the contact, at least: zero marks the contact."""
SPACING = 8
"""Points between the nodes on which the preconditioner under a bound takes means of the contact, nearly.

Of a contact of 512² points at 0.4 to 18 % of the area, 4 and 16 need up to two iterations more.
"""
SPREAD = 0.1
"""Share of contact near by at which such a mean is half that of the contact there: 0.05 to 0.2 are equally good."""
BESIDE = 2
"""Points that the neighbours of a point reach in that preconditioner: 3 and 5 need as many iterations."""
NEIGHBOURHOOD = 64
"""Period in points, or more, in which K between neighbours is found."""
DOMINANT = 1e-3
"""By so much the stiffness of a point alone exceeds, at least, that between it and its neighbours: M is positive."""
REACH = 3
"""Points that the kernel of the preconditioner of a contact's own step reaches."""


def kernel_points(grid: Grid, reach: int = REACH) -> tuple[tuple[int, int], list[tuple[int, int]]]:
    """How far a kernel reaches along x and y, and its points: those of a disc."""
    rows, columns = (min(reach, (n - 1) // 2) for n in grid.shape)
    square = [(i, j) for i in range(-rows, rows + 1) for j in range(-columns, columns + 1)]
    return (rows, columns), [(i, j) for i, j in square if i * i + j * j <= reach * reach]


def near_kernel(grid: Grid, K: Real) -> Real:
    """K between a point and its neighbours, shape (5, 5), with the point in the middle: positive whatever K is."""
    _, near = kernel_points(grid, BESIDE)
    # In a smaller period, where all but the nearest waves of that many points are the same.
    period = _halved(grid.shape[0]), _halved(grid.shape[1])
    waves = grid.waves_of(K, period)
    waves[0, 0] = 0.0  # the mean, which is that of each problem, tells no neighbours apart
    box, around = Grid(period, grid.lengths), np.arange(-BESIDE, BESIDE + 1)
    m, n = box.mode_numbers
    along = np.exp(2j * np.pi / period[0] * np.outer(around, m))
    beside = np.exp(2j * np.pi / period[1] * np.outer(n, around))
    # Not by products of matrices, whose bits depend on the number of threads.
    every = np.einsum("in,nj->ij", np.einsum("im,mn->in", along, waves * box.mode_weights), beside)
    kernel: Real = np.zeros(every.shape)
    for i, j in near:
        kernel[BESIDE + i, BESIDE + j] = every[BESIDE + i, BESIDE + j].real / box.size
    others = np.abs(kernel).sum() - abs(kernel[BESIDE, BESIDE])
    kernel[BESIDE, BESIDE] = max(kernel[BESIDE, BESIDE], (1 + DOMINANT) * others)
    return kernel


def _halved(points: int) -> int:
    """Points of the shortest period, a half or a quarter and so on, in which neighbours are nearly the same."""
    while points % 2 == 0 and points > NEIGHBOURHOOD:
        points //= 2
    return points


def node_stiffness(grid: Grid, K: Real) -> tuple[Grid, Real]:
    """The grid of the nodes, and K of its waves; the mean has that of the softest wave."""
    coarse = grid.of_points(nodes(grid))
    found = grid.low_q(K, coarse)
    coarse.mean_mode(found)[...] = grid.least_wave(K)
    return coarse, found


def factor_of(excess: Callable[[float], float]) -> float | None:
    """The factor of a pressure at which an excess vanishes that grows with it; None if there is none."""
    low, high = 0.0, 1.0
    while excess(high) < 0:
        if high > STEEPEST:
            return None
        low, high = high, 4 * high
    return None if excess(low) > 0 else float(scipy.optimize.brentq(excess, low, high, xtol=1e-300, rtol=1e-15))


def nodes(grid: Grid) -> tuple[int, int]:
    """Numbers of these nodes along x and y."""
    nx, ny = (max(round(points / SPACING), least) for points, least in zip(grid.shape, (1, 2), strict=True))
    return nx, ny


def most_work(height: Real, mean: float, most: float) -> float:
    """Least mean of p times a height above the lowest point, over all p from 0 to ``most`` of a mean.

    It presses as hard as it may where the height is least.
    """
    filled = mean / most * height.size
    whole = min(int(filled), height.size - 1)
    lowest = np.partition(height.ravel(), whole)[: whole + 1]
    return float(most * (lowest[:whole].sum() + (filled - whole) * lowest[whole]) / height.size)
