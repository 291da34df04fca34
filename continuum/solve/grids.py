"""The seam between mathematics and machine: the words of the grids, in which both solvers are written.

The solvers, :mod:`continuum.solve.smooth` and :mod:`continuum.solve.hard`, see scalars only.  A grid names the fields
and owns what they need: memory, transforms, threads or a device.  There are two kinds of grids, compiled ones for
processor cores (:mod:`continuum.solve.compiled`) and those of whole arrays of any library
(:mod:`continuum.solve.arrays`).

<a b> is the mean of a product over the points, an equal sum over the modes; sums that are an array are six: <g g>,
<g s>, <y s>, <y M y>, <s K s>, <s K d>, with y the change of the gradient g by the last step, s = M g and
M = 1/(K + c0): c0 is ``shift``, and larger for short waves beside a coarse step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from continuum.model.fourier import Real
from continuum.model.laws import Law
from continuum.solve.boxes import Boxes
from continuum.solve.solution import Goal, Iteration, Solution, Work


class LinearGrid(Protocol):
    """The linear problem (K + stiffness) x = -g of a grid, for a step of the next finer one."""

    def relax(self, levels: int, shift: float, iterations: int, reduction: float) -> bool:
        """Approach the minimum from x = 0 by a few conjugate directions; whether any step was taken.

        It ends after so many, or when the gradient has fallen by a factor; each is helped by coarser grids, of which
        ``levels`` with this one are used.
        """


class Descending(Protocol):
    """A grid whose steps a coarser one may help."""

    @property
    def linear(self) -> LinearGrid | None:
        """The linear problem of the next coarser grid."""

    def restrict(self, size: float) -> None:
        """Pose that: stiffness of the wall, and gradient over ``size``."""

    def low_modes(self, shift: float, size: float) -> Real:
        """The modes of the coarser grid: there s is minus ``size`` times what that has found.  Their sums."""

    def low_gradient(self, shift: float) -> Real:
        """The same modes with s = M g after all: of their sums <g s> and <s K s>."""


class StiffContact(Protocol):
    """The equations (1/D + G) y = G g of the contact of a grid, D being the stiffness of the wall there and G = 1/K.

    Vectors are over the contact: the residual r, t = M r, the direction p.  The mean of u is held: that of G is zero.
    """

    def find(self, stiff: float, felt: float) -> tuple[float, float]:
        """Find the contact: where the wall is stiffer than the first part of K of the stiffest wave.

        Returns the share of the points where it is stiffer than the second part, and the mean stiffness of the contact
        over that K; zeros where there is none, or the mean of u is not held.
        """

    def gradient(self, alpha: float, *, complete: bool) -> float:
        """Finish the last step, of length ``alpha``: g; returns its root mean square.

        g that is not ``complete`` lacks the traction of z, or that of the last step.
        """

    def set_up(self) -> None:
        """Set y to 0 and r to G g, for the contact that was found last."""

    def precondition(self) -> float:
        """Set t <- M r; returns <r t>, a sum over the contact."""

    def curvature(self, beta: float) -> float:
        """Set p <- t + beta p; returns <p (1/D + G) p>, a sum over the contact."""

    def advance(self, alpha: float) -> None:
        """Set y <- y + alpha p, and r with it."""

    def step(self) -> Real:
        """The step s of the traction y, less r on the contact; <g s>, <s K s>, <s K d>, <s φ'' d> and <d φ'' d>."""

    def new_direction(self, beta: float) -> float:
        """Set d <- beta d - s; returns <φ'' d d> over the points near the wall."""


class SmoothGrid(Descending, Protocol):
    """Gap z and direction d over the points, spectra of the gradient and of d; and the coarser grids."""

    @property
    def contact(self) -> StiffContact | None:
        """The equations of its contact; None on grids for which there is no step of those."""

    @property
    def size(self) -> int:
        """Number of points."""

    @property
    def coarser(self) -> SmoothGrid | None:
        """The nonlinear problem of the next coarser grid."""

    @property
    def boxes(self) -> Boxes | None:
        """The boxes that fit on the grid, where it has any."""

    @property
    def corrected(self) -> bool:
        """Whether corrections on tiles have found z, whose residual is that of their last one."""

    @property
    def work(self) -> list[Work]:
        """What was done for the problem at hand on this grid, on coarser ones, linear problems too, and in boxes."""

    # --- where it starts ---------------------------------------------------------------------------------------

    def set_problem(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        """Set the problem of the grid and of all coarser ones; False if it is not finite.

        ``offset`` and ``start``, shape ``grid.shape``, in a0, are not changed; ``mean_stiffness`` is K at q = 0,
        infinite where the mean of u is held at zero.
        """

    def set_coarser_problem(self, *, started: bool) -> None:
        """Give the coarser grid its part of the offset and, after :meth:`go_to_start`, its start."""

    def go_to_start(self) -> None:
        """Begin at the start: where the mean of u is held it is shifted to that; g without the wall."""

    def go_to_zero(self) -> None:
        """Begin at u = 0: z, and g without the wall."""

    def go_to_coarser(self) -> None:
        """Begin at the displacement of the coarser grid, without shorter waves; at u = 0 where that grid failed."""

    # --- an iteration ------------------------------------------------------------------------------------------

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        """Finish the last step, of length ``alpha`` along a direction that kept ``beta`` of the one before.

        g <- g + y, and s = M g is the new step; returns the sums.  With ``coarse`` the modes of the coarser grid take
        no part in any sum but <g g>.  g that is not ``complete`` lacks the traction of z, as after :meth:`go_to_start`,
        :meth:`go_to_zero` and :meth:`go_to_coarser`, or that of the last step; g that is stays what it is.
        """

    def new_direction(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <φ'' d d> over the points near the wall."""

    def line(self, alpha: float) -> tuple[float, float]:
        """At z - alpha d, over the points near the wall: <(change of p) d> and <φ'' d d>."""

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        """Set z <- z - step d, the last of several that add up to alpha.

        Returns, of all of these, <(change of p) d>; what φ changes beyond first order, and its size, as means.
        """

    def clear(self) -> None:
        """Forget d, which may not be finite."""

    # --- what only processor cores have ------------------------------------------------------------------------

    def has_tiles(self, *, below: bool = False) -> bool:
        """Whether tiles near the wall pay, by the gap at hand or by that of the coarser grid."""

    def correct(self, goal: Goal, history: list[Iteration], iterations: int, *, coarser: bool) -> bool | None:
        """Go to the goal on tiles, as :mod:`continuum.solve.compiled.corrections`; whether that was reached.

        From the traction of the coarser grid, or of the state at hand; None if there is none.
        """

    def hand_down(self) -> bool:
        """After :meth:`gradient`: let the coarser grid begin at the state at hand, if it carries what snaps."""

    def relax_boxes(self, descend: Callable[[SmoothGrid, Law, Real, Real], Solution]) -> float:
        """After :meth:`gradient`: go down in boxes, and begin anew from there; returns the change of the energy."""

    # --- the outcome -------------------------------------------------------------------------------------------

    def residual(self) -> float:
        """Root-mean-square gradient at z, all of it computed afresh; g is this from then on."""

    def look(self) -> Real:
        """The gap z so far, shape ``grid.shape``, in a0: neither to be changed nor to be kept."""

    def hand_out(self) -> Real:
        """Hand z out as an array of the host that nobody else uses, shape ``grid.shape``, in a0."""

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""


class BoundGrid(Protocol):
    """Pressure p, gap z, direction t over the points of one grid, and the preconditioner M.

    z is held without its level, a number.  s = M z and m, about M 1, vanish off the contact; a trial is a pressure that
    may become p.  Sums are over the points.

    M is K between neighbours of the contact, for what deviates from its means near by, and K on nodes for these means:
    :mod:`continuum.solve.compiled.two_levels`.  On tiles M = Eᵀ K E: E extends a displacement of the contact to the
    points around it.
    """

    @property
    def size(self) -> int:
        """Number of points; of tiles, that of the whole grid."""

    @property
    def most(self) -> float:
        """The largest pressure."""

    def level(self) -> tuple[float, float]:
        """Where p presses: sums of m z and of m."""

    def select(self, level: float) -> tuple[float, float, float, float, float]:
        """Find the contact: the points that press or overlap, but for those that yield.

        Returns how many there are, how many are new or gone, their sums of m z and of m, and about the largest gap or
        overlap of them: never less than that, and more by the eighth root of their number at most.
        """

    def renew(self) -> None:
        """Set m <- M 1 on the contact, or 1 if the sum of that is not positive."""

    def precondition(self, level: float) -> float:
        """Set s <- M (z + level) on the contact; returns its sum."""

    def correct(self, weight: float) -> Real | Sequence[float]:
        """Set s <- s - weight m, t <- 0 off the contact; sums of s s, z s, (last change of z) s, t, z t, z m."""

    def clear(self) -> None:
        """Forget t, and the last change of z."""

    def new_direction(self, beta: float, weight: float) -> None:
        """Set t <- s + beta (t - weight m)."""

    def curvature(self) -> float:
        """<t G t>, after :meth:`new_direction`."""

    def trial(self, step: float) -> tuple[float, float, float]:
        """Try p - step t, cut at zero; sums of what was cut, negative, of p - step t, and of the trial."""

    def advance(self, step: float) -> None:
        """Accept a trial that was not cut, the first after :meth:`curvature`: p, and z with it."""

    def arrive(self, before: float, after: float) -> tuple[float, float]:
        """Scale the trial from one sum to another, and find its gap; returns what :meth:`displace` does.

        The energy is NaN if its points cannot carry that sum.
        """

    def accept(self) -> None:
        """Accept the trial whose gap :meth:`arrive` has found: p and z."""

    @property
    def work(self) -> Work:
        """What was done for the problem at hand."""

    @property
    def stiffest(self) -> float:
        """K of the stiffest wave."""

    def set_problem(
        self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float, most: float
    ) -> bool:
        """Set the problem, with p = 0; False if it is not finite.

        The offset is ``offset + lift - sink``, the arrays of shape ``grid.shape``; ``mean_stiffness`` is K at q = 0,
        infinite where the mean of u is held at zero; ``most`` is the largest p.  The start lies in z.
        """

    def set_coarser_problem(self) -> BoundGrid | None:
        """The grid of every second point, with its part of the problem; None if there is none.

        It is made for each cold start and not kept: these are rare on a path.
        """

    def mean_offset(self) -> float:
        """Mean of the offset."""

    def touch(self) -> Real:
        """Gap of the undeformed surface at first touch, positive, as an array of the host."""

    def guess(self, pressure: float | None) -> None:
        """Set p from the start: where the traction that holds it pushes, and it nearly touches.

        Of that traction the mean is ``pressure``, or, with None, such that there is none where the gap is wide.
        """

    def spread(self) -> float:
        """Set p from that of the coarser grid, bilinearly; returns its sum.  That grid is not asked again."""

    def fill(self, pressure: float) -> None:
        """Set p to a number."""

    def scale(self, total: float) -> bool:
        """Scale p, which is positive somewhere, to a sum; False if its points cannot carry that."""

    def total(self) -> float:
        """Sum of p."""

    def tiles(self, level: float, energy: float, size: float) -> BoundGrid | None:
        """The tiles that press or overlap, as a grid whose response is nearly this one's; None where that does not pay.

        The energy is that of the state, and the size of what it is the sum of.
        """

    def take(self, tiles: Any) -> None:
        """Set p and m to those of the tiles, beyond which nothing presses."""

    def displace(self) -> tuple[float, float]:
        """Set z <- G p + offset; returns the energy of the dual, per point, and the size of what it is the sum of."""

    def misses(self, level: float) -> tuple[float, float]:
        """Root mean square of K e, and largest e: what closing the contact and lifting the overlaps adds to u.

        s, t and the last change of z are lost.
        """

    def duality_gap(self) -> tuple[float, float]:
        """<p (z - min z)>, and 2 <p> sqrt(Σ 1/K²) over q ≠ 0: what it is at most, for a residual of one."""

    def hand_out(self, level: float) -> tuple[Real, Real]:
        """The gap, zero where p presses and positive elsewhere, and p: arrays of the host, in a0 and E*."""

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""
