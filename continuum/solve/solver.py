"""A solver of one grid and one elastic response, whose arrays live as long as a path."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate
from continuum.solve.backend import back_end
from continuum.solve.grids import BoundGrid, SmoothGrid
from continuum.solve.hard import constrain
from continuum.solve.smooth import COARSE_TOLERANCES, minimise
from continuum.solve.solution import FinerTolerance, Settings, Solution
from continuum.solve.stability import Stability, stability


class Solver:
    """Equilibria of one elastic surface, one after the other, in arrays that are made once.

    Parameters
    ----------
    grid : points and periods.
    stiffness_q : K over the half spectrum, shape ``grid.shape_q``, in E*/a0: at least 0, but for q = 0 positive where
        there is a bound.
    threads : of this process; no bit of a result depends on their number.
    device : name of the back end.
    shards : devices over which it divides the points.
    sampled : whether a coarser grid takes every second point of an offset, as it must of one that jumps, instead of the
        waves that it carries.

    Raises
    ------
    ValueError
        If there is no such device, or it is not made of parts.
    """

    def __init__(
        self,
        grid: Grid,
        stiffness_q: Real,
        threads: int = 1,
        device: str = "cpu",
        *,
        shards: int = 1,
        sampled: bool = False,
    ) -> None:
        self._back_end = back_end(device, shards)
        self._surface, self._sampled = (grid, stiffness_q, threads), sampled
        self._mean_stiffness = grid.first(stiffness_q)

    @property
    def smallest(self) -> int:
        """Grids of no more points along a side are not worth a coarser one."""
        return self._back_end.SMALLEST

    def minimise(
        self,
        law: Law,
        offset: Real,
        start: Real | None,
        settings: Settings,
        *,
        pressure: float = 0.0,
        lift: float = 0.0,
        mean_stiffness: float | None = None,
        finer: FinerTolerance | None = None,
    ) -> Solution:
        """Minimise ½ <u, K u> + <φ(offset + lift - u)> - F <u> over u.

        Parameters
        ----------
        law : φ, per area, as compiled code takes it.
        offset, lift : z at u = 0, an array of shape ``grid.shape`` and a number, in a0.
        start : z at the start, shape ``grid.shape``; None starts on a cascade of coarser grids, from u = 0 on the
            coarsest.
        settings : when to stop; threads and device are those of the solver.
        pressure : F, a uniform pressure along u, in E*; of no effect where the mean of u is held.
        mean_stiffness : K at q = 0 instead of that of ``stiffness_q``; infinite holds the mean of u at zero.
        finer : a finer tolerance, if the gap at that of the settings is worth it.
        """
        mean = self._mean_stiffness if mean_stiffness is None else mean_stiffness
        posed = {"pressure": pressure, "lift": lift, "mean_stiffness": mean}
        settings = replace(settings, shift=self._stiffness(settings.shift))
        return minimise(self._smooth, self._back_end.LEVELS, law, offset, start, settings, finer=finer, **posed)

    def constrain(
        self,
        offset: Real,
        start: Real | None,
        settings: Settings,
        *,
        pressure: float = 0.0,
        lift: float = 0.0,
        mean_stiffness: float | None = None,
        most: float = np.inf,
    ) -> Solution:
        """Minimise ½ <u, K u> - F <u> over u with z = offset + lift - u >= 0 at each point.

        Parameters
        ----------
        offset, lift : z at u = 0, an array of shape ``grid.shape`` and a number, in a0.
        start : z at the start, same shape, from which contact and pressure are guessed; None starts on coarser grids.
        settings : when to stop; of it tolerance and iterations are used.
        pressure : F, a uniform pressure along u, in E*; of no effect where the mean of u is held.
        mean_stiffness : K at q = 0 instead of that of ``stiffness_q``.  Infinite holds the mean of u at zero; with 0
            the mean pressure is F.
        most : pressure at which the wall gives way: where it is reached, z may be negative.

        Returns
        -------
        Solution
            Its gap is exactly zero where its traction is positive, negative where the wall gave way, and positive
            elsewhere.  Its residual is the
            root-mean-square of K e, e being what closing the contact and lifting the overlaps exactly adds to u: the
            traction by which a surface that fulfils the bound, with this traction, misses its equilibrium.

        Raises
        ------
        ValueError
            If no state exists: F < 0 without mean stiffness (a hard wall cannot pull), F at which the wall gives way
            everywhere, or a held mean that overlaps.
        """
        mean = self._mean_stiffness if mean_stiffness is None else mean_stiffness
        posed = {"pressure": pressure, "lift": lift, "mean_stiffness": mean, "most": most}
        return constrain(self._bound, offset, start, settings, **posed)

    def elastic_energy(self, offset: Real, solution: Solution) -> float:
        """½ <u, K u> of a solution's u = offset - gap without its mean, in E* a0, in the arrays that are there."""
        grid = self._bound if "_bound" in vars(self) else self._smooth
        return grid.elastic_energy(offset, solution.gap)

    def stability(self, law: Law, gap: Real, mean_stiffness: float | None = None, shift: float = 0.01) -> Stability:
        """The lowest eigenvalue of the Hessian at a gap: :func:`continuum.solve.stability.stability`."""
        grid, stiffness_q, _ = self._surface
        return stability(grid, stiffness_q, evaluate(law, gap)[2], mean_stiffness, self._stiffness(shift))

    def _stiffness(self, shift: float) -> float:
        """c0 in E*/a0 of one in E* over the spacing, in which the stiffness of waves of the grid is the same always."""
        return shift / self._surface[0].widest_step

    @cached_property
    def _smooth(self) -> SmoothGrid:
        return self._back_end.smooth_grid(*self._surface, len(COARSE_TOLERANCES), sampled=self._sampled)

    @cached_property
    def _bound(self) -> BoundGrid:
        return self._back_end.bound_grid(*self._surface)
