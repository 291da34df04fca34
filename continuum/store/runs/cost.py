"""What the input of a run says about its cost: memory, the number of its states, and the points of its grid.

How long it takes depends on the contact; that is measured (:mod:`continuum.store.sweeps.status`).
"""

from dataclasses import dataclass
from typing import Self

from continuum.solve.backend import BOUND_FIELDS, SMOOTH_FIELDS
from continuum.store.runs.config import RunConfig

# Upper bounds of one solve in a fresh process, in bytes; the largest resident size was measured.
LIBRARIES = 2.5e8
"""Imports take 186 MiB, compiled code and small grids 25 to 35 MiB."""
UNDER_A_LAW = 90
"""Of a point of the grid: 73 at 0.7 % of the area and 88 at 8 % (4096²), 88 at 20 % (2048²)."""
UNDER_A_HARD_WALL = 115
"""Of a point of the grid: 82 at 0.9 % of the area (4096²), 114 at 20 % (2048²)."""


ON_A_DEVICE = 1e9
"""Of a process on a GPU beside its fields, for context and kernels: four grids took less (docs/studies/gpu.md)."""


@dataclass(frozen=True)
class Cost:
    """What follows from the input of a run alone."""

    memory: int
    """Peak memory, in bytes."""
    states: int
    """Number of states of the path, without those that searches try."""
    size: int
    """Number of points of the grid."""

    @property
    def work(self) -> float:
        """States times points of the grid: the unit in which systems of one sweep are compared."""
        return float(self.states) * self.size


@dataclass(frozen=True)
class Share:
    """What each of the devices has of a contact that is divided over several."""

    shards: int
    size: int
    """Number of points of the grid."""
    modes: int
    """Numbers of a half spectrum, with the columns that make the parts equal."""
    fields: float
    """Fields of the whole grid that a solve needs."""

    @classmethod
    def of(cls, config: RunConfig) -> Self:
        (nx, ny), shards = config.grid.n, config.solver.shards
        repeats = 1 if config.substrate.repeats else 2
        columns = shards * -(-(repeats * ny // 2 + 1) // shards)
        fields = SMOOTH_FIELDS if config.wall.has_law else BOUND_FIELDS
        return cls(shards, repeats**2 * nx * ny, columns * repeats * nx, fields)

    @property
    def memory(self) -> float:
        """Memory of the solver on a device, in bytes."""
        return 8 * self.fields * self.size / self.shards

    @property
    def sent(self) -> float:
        """Bytes that a device sends to all others in a pair of transforms: of its part of a spectrum all but its own.

        Beside it are sums, and rows at the edges of slabs.
        """
        return 2 * 16 * self.modes * (self.shards - 1) / self.shards**2


def memory_on_device(config: RunConfig) -> float:
    """Memory that a run needs on one GPU, in bytes."""
    return ON_A_DEVICE + Share.of(config).memory


def cost_of(config: RunConfig) -> Cost:
    """Memory, states and points of the grid of a run."""
    nx, ny = config.grid.n
    size, states = nx * ny, config.loading.points
    # Contact maps take two bits per point, fields four bytes, and both are held twice during a rewrite.
    kept = states * size * 2 * (0.25 + (4 if config.output.fields else 0))
    beside = 1 if config.substrate.repeats else 4
    point = UNDER_A_LAW if config.wall.has_law else UNDER_A_HARD_WALL
    return Cost(int(LIBRARIES + beside * size * point + kept), states, size)
