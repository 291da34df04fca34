"""The contact on every second point of its grid, where a search begins, and the way back from there."""

from dataclasses import dataclass

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.path.state import PathState

LOST_SLOPE = 0.01
"""A grid carries a surface if the waves that it cannot resolve hold at most this part of the mean square slope."""


@dataclass(frozen=True, eq=False)
class _Cut:
    """The response of a finer grid on the waves of a coarser one."""

    stiffness_q: Real

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum."""
        assert grid.shape_q_here == self.stiffness_q.shape
        return self.stiffness_q


def coarser_problem(problem: ContactProblem, smallest: int, *, roughly: bool = False) -> ContactProblem | None:
    """The same contact on every second point, if that still shows four points for each wave, or two: roughly."""
    grid, coarse = problem.grid, problem.grid.coarser
    if problem.open_boundary is not None or coarse is None or coarse.coarser is None or coarse.narrowest < smallest:
        return None
    if not coarse.equal_slabs:
        return None
    heights_q = grid.forward(problem.heights)
    power = (heights_q.real**2 + heights_q.imag**2) * grid.mode_weights * grid.wavenumber**2
    (m, n), carrier = grid.mode_numbers, coarse if roughly else coarse.coarser
    carried = (np.abs(m + 0.5) < max(carrier.shape[0] / 2, 1)) & (n < carrier.shape_q[1] - 1)
    if grid.total_q(np.where(carried, power, 0.0)) < (1 - LOST_SLOPE) * grid.total_q(power):
        return None
    response = _Cut(grid.low_q(problem.stiffness_q, coarse))
    return ContactProblem(coarse, problem.wall, coarse.inverse(grid.restricted(heights_q, coarse)), response)


def carried_gap(coarse: ContactProblem, fine: ContactProblem, state: PathState) -> Real:
    """The gap of a coarse state on the finer grid."""
    level = state.mean_gap - coarse.mean_height
    displacement_q = coarse.grid.prolonged(coarse.grid.forward(coarse.heights + level - state.gap), fine.grid)
    gap = fine.grid.inverse(displacement_q, overwrite=True)
    np.subtract(fine.heights, gap, out=gap)
    gap += state.mean_gap - fine.mean_height
    return gap
