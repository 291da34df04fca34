"""Equilibria of a part of a half-space, by the solver of a periodic surface of twice the size."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from continuum.model.fourier import Real
from continuum.model.laws import Law, evaluate
from continuum.model.substrates.non_periodic import OpenBoundary
from continuum.solve.solution import FinerTolerance, Settings, Solution
from continuum.solve.solver import Solver
from continuum.solve.stability import ACCURACY, Stability, stability

FARTHER = 4.0
"""Factor by which the wall beside the window is taken away where the surface has reached it."""
ATTEMPTS = 20
"""How often it is."""
UNFELT = 1e-3
"""Traction beside the window, in tolerances, of a law that never ends."""
NEWTON = 8
"""Largest number of steps to the lowest eigenvalue; 3 - 5 were seen to be enough."""


class NonPeriodicSolver(Solver):
    """As :class:`continuum.solve.solver.Solver`, for tractions on the window of an open boundary only.

    Beside the window the wall is farther away than it acts.  Offsets, starts and gaps are those of the window, and so
    are residuals: the root-mean-square over it of what all of the surface has.
    """

    def __init__(self, boundary: OpenBoundary, threads: int = 1, device: str = "cpu", *, shards: int = 1) -> None:
        super().__init__(boundary.grid, boundary.stiffness_q, threads, device, shards=shards, sampled=True)
        self.boundary = boundary

    def minimise(
        self,
        law: Law,
        offset: Real,
        start: Real | None,
        settings: Settings,
        *,
        lift: float = 0.0,
        finer: FinerTolerance | None = None,
        **posed: Any,
    ) -> Solution:
        """Minimise as the periodic solver does.

        Parameters
        ----------
        start : gap of an equilibrium, shape of the window: its displacement is where the surface begins.
        posed : ``pressure``, the mean on the window in E*, and ``mean_stiffness``, 0 under a given load; else that of
            the half-space.

        The rest is as for :meth:`continuum.solve.solver.Solver.minimise`.
        """
        reach = _reach(law, settings.tolerance if finer is None else finer.tolerance)
        if finer is not None:
            worth = finer.worth
            finer = FinerTolerance(finer.tolerance / 2, lambda gap: worth(self.boundary.inside(gap)))
        posed, settings, solve = _of_all(**posed), _for_window(settings), super().minimise
        loaded = posed["mean_stiffness"] == 0

        def solved(around: Real) -> Solution:
            begin = None if start is None else self._start(law, around, start, lift, loaded=loaded)
            return solve(law, around, begin, settings, lift=lift, finer=finer, **posed)

        return self._unfelt(offset, lift, reach, solved)

    def constrain(
        self,
        offset: Real,
        start: Real | None,
        settings: Settings,
        *,
        lift: float = 0.0,
        most: float = np.inf,
        **posed: Any,
    ) -> Solution:
        """As :meth:`minimise`, under a hard wall, where the start makes no difference."""
        posed, settings, solve = _of_all(**posed), _for_window(settings), super().constrain

        def solved(around: Real) -> Solution:
            # The energy is convex, and from the gap of a window alone no pressure follows.
            return solve(around, None, settings, lift=lift, most=most, **posed)

        return self._unfelt(offset, lift, 0.0, solved)

    def elastic_energy(self, offset: Real, solution: Solution) -> float:
        """½ <u, K u> per area of the window, of all of the half-space, in E* a0."""
        del offset
        return self.boundary.elastic_energy(solution.traction)

    def stability(self, law: Law, gap: Real, mean_stiffness: float | None = None, shift: float = 0.01) -> Stability:
        """The lowest eigenvalue λ of the Hessian of the window, beside which the surface follows without traction.

        On all of the surface it is the lowest λ of H v = λ P v, P being the restriction to the window: the root of the
        lowest eigenvalue of H - λ P, which is concave in λ, so that Newton's method comes down to it.
        """
        stiffness, products = evaluate(law, gap)[2], 0
        free = _of_all(mean_stiffness=mean_stiffness)["mean_stiffness"] == 0
        K = np.array(self.boundary.stiffness_q)
        K[0, 0] = 0.0 if free else K[0, 0]
        found: Stability | None = None
        mode: Real | None = None
        for _ in range(NEWTON):
            shifted = stiffness - (found.eigenvalue if found else 0.0)
            lowest = stability(
                self.boundary.grid, K, self.boundary.around(shifted, 0.0), None, self._stiffness(shift), mode
            )
            products, mode = products + lowest.products + 2, lowest.mode
            scale = max(float(-stiffness.min()), lowest.scale if found is None else found.scale)
            last, found = found, self._of_window(K, stiffness, mode, products, scale, free=free)
            if found.error <= ACCURACY * scale or (last is not None and found.eigenvalue >= last.eigenvalue):
                break
        assert found is not None
        return found

    def _of_window(self, K: Real, stiffness: Real, mode: Real, products: int, scale: float, *, free: bool) -> Stability:
        """Rayleigh quotient and residual of the displacement that the tractions of a mode in the window give there:
        those of the half-space itself, however the mode is beside the window.
        """
        boundary = self.boundary
        traction = boundary.inside(boundary.grid.inverse(K * boundary.grid.forward(mode), overwrite=True)).copy()
        traction -= free * traction.mean()
        v = -boundary.inside(boundary.displacement(traction))
        v += free * (boundary.inside(mode).mean() - v.mean())
        image = traction + stiffness * v
        size = float(np.sqrt(np.mean(v**2)))
        value = float(np.mean(v * image)) / size**2
        error = float(np.sqrt(np.mean((image - value * v) ** 2))) / size
        return Stability(value, error, v / size, products, scale)

    def _unfelt(self, offset: Real, lift: float, reach: float, solved: Callable[[Real], Solution]) -> Solution:
        """The solution in the window with the wall beside it so far away that it does not act there.

        Parameters
        ----------
        reach : gap beyond which the wall does not act.
        solved : the solution of an offset all around.
        """
        least, most = float(offset.min()), float(offset.max())
        far = max(most, -lift) + reach + (most - least) + 1.0
        for attempt in range(ATTEMPTS):
            found = solved(self.boundary.around(offset, far * FARTHER**attempt))
            if not found.status.ok or _beside(self.boundary, found.gap).min() > reach:
                break
        return self._inside(found)

    def _start(self, law: Law, around: Real, start: Real, lift: float, *, loaded: bool) -> Real:
        """Gap all around, of the displacement that an equilibrium of this gap has."""
        displacement = self.boundary.displacement(evaluate(law, start)[1])
        if loaded:
            # Counted from another height: that at which the gap is the one given.
            inside = self.boundary.inside
            displacement += float(np.mean(inside(around) + lift - start - inside(displacement)))
        begin: Real = around + lift - displacement
        return begin

    def _inside(self, found: Solution) -> Solution:
        """The solution in the window; its residual as if all of it were there."""
        inside = self.boundary.inside
        pressure = None if found.pressure is None else inside(found.pressure).copy()
        gap, duality_gap = inside(found.gap).copy(), 4 * found.duality_gap
        return replace(found, gap=gap, pressure=pressure, residual=2 * found.residual, duality_gap=duality_gap)


def _of_all(pressure: float = 0.0, mean_stiffness: float | None = None) -> dict[str, Any]:
    """Pressure and mean stiffness of the periodic surface of twice the size: zero under a given load, or its own."""
    if mean_stiffness is not None and np.isinf(mean_stiffness):
        raise ValueError("a part of a half-space has no mean displacement that could be held")
    return {"pressure": pressure / 4, "mean_stiffness": 0.0 if mean_stiffness == 0 else None}


def _reach(law: Law, tolerance: float) -> float:
    """Gap beyond which a law does nothing, or so little that no tolerance sees it."""
    if np.isfinite(law.reach):
        return law.reach
    gaps = np.geomspace(1e-6, 1e12, 400)
    felt = np.abs(evaluate(law, gaps)[1]) > UNFELT * tolerance
    return float(gaps[min(np.flatnonzero(felt)[-1] + 1, gaps.size - 1)]) if felt.any() else float(gaps[0])


def _for_window(settings: Settings) -> Settings:
    """The window is a quarter of the surface: a root-mean-square over it is at most twice that over all."""
    return replace(settings, tolerance=settings.tolerance / 2)


def _beside(boundary: OpenBoundary, gap: Real) -> Real:
    """Gaps beside the window."""
    nx, ny = boundary.window.shape
    return np.concatenate([gap[nx:].ravel(), gap[:, ny:].ravel()])
