"""Derivatives of the numbers of an equilibrium: by the height of every point, by how near the wall is, by its work.

At an equilibrium z = D + h - u, K u + p(z) = 0.  Of a number whose change is the mean of f(x) dz(x), one linear solve
with the Hessian, (K + φ''(z)) λ = f, has the derivative by all heights at once,

    dF/dh(x) = (f - φ'' λ)(x)/n        n: points of the grid

at given separation; its sum is that by the separation.  At given mean gap the same holds for fields without mean, and
the sum is the derivative by the mean gap.  For the load f = -φ''.  Under a hard wall φ'' is infinite on the contact:
with y the pressures there that displace the contact by one, which outside of it vanish, dN/dh(x) = -y(x)/n.

Derivatives at a given load or area follow from those at a given mean gap: it changes by as much as keeps the number.
By the work of adhesion w, which changes the tractions by ∂p/∂w at a given gap, dF/dw is the mean of λ ∂p/∂w.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.arguments import ArgumentError
from continuum.measure.contact import area_by_lines
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.equilibrium import NO_MEAN_GAP
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import NotConvergedError
from continuum.solve.tangent import SHIFT, solve_hessian

ACCURACY = 1e-10
"""Residual of the linear solves, relative: derivatives are then as good as the equilibrium."""
CONTACT_ITERATIONS = 2000
WORK_STEP = 1e-4
"""Step of w by which ∂p/∂w is found, relative: the error is about its square."""
NO_EDGE = "a law: at the edge of a contact under a hard wall the gap has no slope, and the area no derivative"


class Derivative(NamedTuple):
    """The derivative of one number of an equilibrium."""

    heights: Real
    """By the height of each point where the wall is held as near as it is, shape ``grid.shape``, per a0."""
    nearness: float
    """By the mean gap, or without periodic images by the separation, per a0."""
    work: float = 0.0
    """By the work of adhesion, per E* a0."""

    def holding(self, other: Derivative) -> Derivative:
        """The same where another number is held in place of the nearness.

        Raises NotConvergedError where the other is stationary, as a load at pull-off, or an area without contact.
        """
        if other.nearness == 0:
            raise NotConvergedError("no derivative: what is held does not depend here on how near the wall is")
        share = self.nearness / other.nearness
        return Derivative(self.heights - share * other.heights, 0.0, self.work - share * other.work)


@dataclass(frozen=True, eq=False)
class Tangent:
    """An equilibrium and all that lie next to it.

    Parameters
    ----------
    problem, gap : the contact, and the gap of its equilibrium, shape ``grid.shape``, in a0.
    wall_of : law of each work of adhesion, for derivatives by it; None to leave them zero.
    """

    problem: ContactProblem
    gap: Real
    wall_of: WallOfWork | None = None

    def of(self, slope: Real, by_work: float = 0.0) -> Derivative:
        """The derivative of a number whose change is the mean of ``slope`` dz + ``by_work`` dw.

        Raises
        ------
        NotConvergedError
            If the linear solve does not converge: the state is at the edge of its stability.
        """
        problem, stiffness = self.problem, self._stiffness
        boundary = problem.open_boundary
        if boundary is None:
            beyond = solve_hessian(problem.grid, problem.stiffness_q, stiffness, slope, SHIFT, ACCURACY)
        else:
            around = boundary.around(stiffness, 0.0), boundary.around(slope, 0.0)
            beyond = solve_hessian(boundary.grid, boundary.stiffness_q, *around, SHIFT, ACCURACY, mean_free=False)
            beyond = boundary.inside(beyond)
        if not np.isfinite(beyond).all():
            raise NotConvergedError("no derivative: the linear solve with the Hessian did not converge, as the state "
                                    "is about to jump; take one a little before")  # fmt: skip
        work = by_work + (0.0 if self.wall_of is None else problem.grid.mean(beyond * self._by_work[0]))
        return self._derivative(slope - stiffness * beyond, work)

    @cached_property
    def load(self) -> Derivative:
        """The derivative of the load per A0, in E*."""
        if self.problem.wall.law is None:
            return self._derivative(-self._pressures_that_lift())
        work = 0.0 if self.wall_of is None else self.problem.grid.mean(self._by_work[0])
        return self.of(-self._stiffness, work)

    @cached_property
    def area(self) -> Derivative:
        """The derivative of the repulsive area of :func:`continuum.measure.contact.area_by_lines`, a fraction of A0."""
        wall, boundary = self.problem.wall, self.problem.open_boundary
        if wall.law is None:
            raise ArgumentError("wall", wall, NO_EDGE)
        _, slope = area_by_lines(self.gap - wall.zero_gap, periodic=boundary is None)
        work = 0.0 if self.wall_of is None else -float(slope.sum()) * self._by_work[1]
        return self.of(slope * slope.size, work)

    @property
    def mean_gap(self) -> Derivative:
        """The derivative of the mean gap."""
        if self.problem.open_boundary is not None:
            raise ArgumentError("at", "mean_gap", NO_MEAN_GAP)
        return self._itself

    @property
    def separation(self) -> Derivative:
        """The derivative of the separation."""
        if self.problem.open_boundary is not None:
            return self._itself
        k, load = self.problem.mean_stiffness, self.load
        if k == 0:
            raise ArgumentError("at", "separation", "mean_gap where the mean displacement of the substrate is free")
        # The separation is the mean gap less the mean height, less the load over k.
        return Derivative(-1 / self.gap.size - load.heights / k, 1.0 - load.nearness / k, -load.work / k)

    @property
    def _itself(self) -> Derivative:
        """The derivative of what says how near the wall is."""
        return Derivative(np.zeros(self.gap.shape), 1.0)

    @cached_property
    def _stiffness(self) -> Real:
        return self.problem.wall.evaluate(self.gap).stiffness

    @cached_property
    def _by_work(self) -> tuple[Real, float]:
        """Derivatives by w of the traction at each gap, per a0, and of the gap where it vanishes, per E*."""
        assert self.wall_of is not None
        work = self.problem.wall.work_of_adhesion
        less, more = (self.wall_of(work * (1 + sign * WORK_STEP)) for sign in (-1, 1))
        step = more.work_of_adhesion - less.work_of_adhesion
        tractions = more.evaluate(self.gap).traction - less.evaluate(self.gap).traction
        return tractions / step, (more.zero_gap - less.zero_gap) / step

    def _derivative(self, by_gap: Real, work: float = 0.0) -> Derivative:
        """From what a number changes by where the gap would at each point, were it not for the elastic response."""
        mean = self.problem.grid.mean(by_gap)
        heights = by_gap - mean if self.problem.open_boundary is None else by_gap
        return Derivative(heights / by_gap.size, mean, work)

    def _pressures_that_lift(self) -> Real:
        """Pressures on the contact of a hard wall that displace it by one, in E*/a0; zero elsewhere.

        By conjugate gradients for the compliance between the points of the contact, with the stiffness between them as
        preconditioner.  Where a wall yields its traction is given, and the gap negative.
        """
        problem, boundary, inside = self.problem, self.problem.open_boundary, self.gap == 0
        pressures = np.zeros(self.gap.shape)
        if not inside.any():
            return pressures
        grid = problem.grid if boundary is None else boundary.grid
        K = np.array(problem.stiffness_q if boundary is None else boundary.stiffness_q)
        if boundary is None:
            K[0, 0] = np.inf
        compliance = 1 / K
        K[0, 0] = K[0, 0] if np.isfinite(K[0, 0]) else 0.0
        filled = np.zeros(grid.shape)
        window = filled[: inside.shape[0], : inside.shape[1]]

        def between(v: NDArray[np.float64], response_q: Real) -> NDArray[np.float64]:
            window[inside] = v
            found = grid.inverse(response_q * grid.forward(filled), overwrite=True)
            image: Real = found[: inside.shape[0], : inside.shape[1]][inside]
            return image

        linalg, size = scipy.sparse.linalg, 2 * (int(np.count_nonzero(inside)),)
        compliant, stiff = (
            linalg.LinearOperator(size, matvec=partial(between, response_q=q), dtype=np.float64)
            for q in (compliance, K)
        )
        found, failed = linalg.cg(compliant, np.ones(size[0]), M=stiff, rtol=ACCURACY, maxiter=CONTACT_ITERATIONS)
        if failed or size[0] == grid.size:
            raise NotConvergedError("no derivative: at full contact under a hard wall the mean gap is no longer free")
        pressures[inside] = found
        return pressures
