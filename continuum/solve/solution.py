"""What a solve is asked for, and what it answers: settings, status, residual and work of one equilibrium."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from continuum.inputs.arguments import count, number
from continuum.inputs.errors import StickinessError
from continuum.model.fourier import Real
from continuum.model.laws import Law, evaluate

MOST_THREADS = 1024
"""Threads that a solve may use."""
MOST_SHARDS = 4096
"""Devices over which a solve may divide its points."""
LOOSEST = 0.01
"""Largest tolerance, relative to h'rms E*, that a user may ask for: measured at 3 - 45 % contact, with and without
adhesion, areas are off by up to 3 % and loads by 4 % at 0.01, by 30 % at 0.1, and mean nothing at 0.5."""


class Work(NamedTuple):
    """What was done on one grid."""

    shape: tuple[int, int]
    fft_pairs: float
    """Forward and inverse transforms, halved, of this grid."""
    sweeps: int
    """Evaluations of the line search."""
    fft_seconds: float
    """Time in transforms, of all threads divided by their number."""

    def plus(self, other: Work) -> Work:
        """The work of both, on the same grid."""
        pairs, sweeps = self.fft_pairs + other.fft_pairs, self.sweeps + other.sweeps
        return Work(self.shape, pairs, sweeps, self.fft_seconds + other.fft_seconds)


class Status(enum.StrEnum):
    """How a solve ended.  Each failure names its usual cause and what helps."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit reached: allow more iterations, or take a smaller step along the path"
    LINE_SEARCH = "line search found no minimum: the tolerance is below the rounding error of this problem"
    ENERGY_ROSE = "energy rose: energy and traction of the wall law do not belong to one another"
    NON_FINITE = "a value is not finite: the start or the input is out of range"
    SADDLE = "a saddle, not a minimum, which symmetry of the start may keep: perturb the start or the heights"
    STOPPED = "stopped on the way to a state that is not wanted: a search looks at it nearer to where it began"
    BELOW_CORE = "the surface went below the core of the wall law, where it is only continued: lower the core"

    @property
    def ok(self) -> bool:
        """Whether the state is an equilibrium of the problem as posed."""
        return self is Status.CONVERGED


class NotConvergedError(StickinessError, RuntimeError):
    """A required solution was not found; the message has the residual and advice."""


class NotConvergedWarning(UserWarning):
    """A returned state is not an equilibrium; the message has the reason and the likely cause."""


@dataclass(frozen=True)
class Settings:
    """When to stop, how to precondition, and what to run on.

    Parameters
    ----------
    tolerance : largest root-mean-square gradient, in E*.
    max_iterations : iterations after which a solve gives up.
    shift : c0 of the preconditioner 1/(K + c0) of long waves, in E* over the spacing of the grid; the optimum is flat
        (0.001 - 0.03).
    warm_grids : coarser grids on which a given start is relaxed first, half the work.  0 keeps strictly to the basin
        of the start: an instability that only a coarse grid has may lead out of it.
    threads : of this process that the solver may use; no bit of a result depends on it.
    device : name of the back end, see :data:`continuum.solve.backend.BACK_ENDS`.
    shards : devices over which it divides the points.
    stability : whether the lowest eigenvalue of the Hessian is looked for: a saddle is then no solution.
    """

    tolerance: float
    max_iterations: int = 5000
    shift: float = 0.01
    warm_grids: int = 2
    threads: int = 1
    device: str = "cpu"
    shards: int = 1
    stability: bool = False

    def __post_init__(self) -> None:
        number("tolerance", self.tolerance, above=0)
        count("max_iterations", self.max_iterations)
        number("shift", self.shift, above=0)
        count("warm_grids", self.warm_grids, 0)
        count("threads", self.threads, 1, MOST_THREADS)
        count("shards", self.shards, 1, MOST_SHARDS)

    def coarser(self) -> Settings:
        """The same, with the same c0, on a grid of twice the spacing."""
        return replace(self, shift=2 * self.shift)


class FinerTolerance(NamedTuple):
    """A finer tolerance for a solve that turns out to be worth it, once it has reached that of its settings."""

    tolerance: float
    """In E*."""
    worth: Callable[[Real], bool]
    """Whether to go on, from the gap so far, which is not to be changed or kept."""
    hopeless: Callable[[Real], bool] | None = None
    """Whether to stop where the solve stalls, from the same."""


@dataclass
class Goal:
    """The residual at which a solve ends: that asked for or, once there, a finer one if the gap is worth it."""

    bound: float
    finer: FinerTolerance | None = None
    _loose: float = 0.0
    """The bound before it became finer, else 0."""

    def reached(self, residual: float, look: Callable[[], Real]) -> bool:
        """Whether a state is the one that is sought; ``look`` shows its gap."""
        if self._loose and residual > self._loose:
            # It has snapped into another state, which has to be worth it, too.
            self.bound, self._loose = self._loose, 0.0
        if not residual <= self.bound:
            return False
        finer = self.finer
        if self._loose or finer is None or residual <= finer.tolerance or not finer.worth(look()):
            return True
        self._loose, self.bound = self.bound, finer.tolerance
        return False

    @property
    def last(self) -> float:
        """The residual at which a solve ends that goes on to the finer one."""
        return self.finer.tolerance if self.finer else self.bound

    def hopeless(self, look: Callable[[], Real]) -> bool:
        """Whether a solve that stalls may stop: not once its gap was worth to go on."""
        finer = self.finer
        return bool(finer and not self._loose and finer.hopeless is not None and finer.hopeless(look()))


class Iteration(NamedTuple):
    """One line of the history of a solve, on the finest grid."""

    residual: float
    """Root-mean-square gradient, in E*."""
    energy: float
    """Energy per area relative to the start, in E* a0; NaN once coarser grids have carried it over a snap."""
    step: float
    """Length α of the step along the direction."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What a solve found, and how."""

    gap: Real = field(repr=False)
    """z = offset - u at each point; exactly zero where a bound holds it."""
    status: Status
    residual: float
    """Root-mean-square gradient of the final state, computed afresh, in E*."""
    iterations: int
    """On the finest grid; of a contact that is solved on tiles, the corrections by the whole grid."""
    work: tuple[Work, ...] = ()
    """On each grid, the finest first."""
    seconds: float = field(default=0.0, compare=False)
    history: tuple[Iteration, ...] = field(repr=False, default=())
    law: Law | None = field(repr=False, default=None)
    """Law of the wall, from which the traction follows at each gap; None under a bound."""
    pressure: Real | None = field(repr=False, default=None)
    """Traction under a bound, where no law gives it, in E*; None if it is not known."""
    gap_error: float = 0.0
    """Largest amount by which the gap had to be mended to fulfil its bound exactly, in a0."""
    duality_gap: float = np.nan
    """Under a bound: what the energy of any state of this load is lower at most, per area, in E* a0; else NaN."""
    lowest_eigenvalue: float = np.nan
    """Lowest eigenvalue of the Hessian, in E*/a0, if asked for (see `stability`); negative at a saddle."""
    processes: int = 1
    """Processes among which the points are divided: the gap is that of one of them."""

    @property
    def traction(self) -> Real:
        """Traction of the wall on the surface, in E*, compression positive; NaN if unknown.

        Where a law gives it, it is made anew each time.
        """
        if self.law is not None:
            return evaluate(self.law, self.gap)[1]
        return np.broadcast_to(np.nan, self.gap.shape) if self.pressure is None else self.pressure

    @property
    def fft_pairs(self) -> float:
        """Transforms of all grids, halved and weighted by their numbers of points."""
        return sum(w.fft_pairs * w.shape[0] * w.shape[1] for w in self.work) / self.points

    @property
    def points(self) -> int:
        """Number of points of all processes."""
        return self.gap.size * self.processes

    @property
    def sweeps(self) -> int:
        """Evaluations of the line search on the finest grid."""
        return self.work[0].sweeps if self.work else 0

    def require(self) -> Solution:
        """Return the solution itself, if converged.

        Raises
        ------
        NotConvergedError
            Otherwise.
        """
        if not self.status.ok:
            msg = f"{self.status.value} (residual {self.residual:.2e} after {self.iterations} iterations)"
            raise NotConvergedError(msg)
        return self
