"""The seam between mathematics and machine: what a solver asks of one grid, and the back ends that offer it.

The solvers, :mod:`continuum.solve.smooth` and :mod:`continuum.solve.hard`, see scalars only.  A grid of a solve - a
:class:`Level` or a :class:`Face` - owns the fields: where they lie, how they are padded and transformed, in how many
threads or on what device.  It is made once for a path and then takes one problem after the other.  Each operation
below may be one launch on a device, its sums reduced there and read once.

Fields cross the seam in four places: ``pose`` takes an offset and a start, ``take_gap`` and ``take`` hand out what was
found, ``touch`` what needs no solving.  These are host arrays; a back end may recognise what it was given before.

A back end is a module with the names of :class:`BackEnd`, and one line in :data:`BACK_ENDS`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.solve.solution import Work

BACK_ENDS = {
    "cpu": "continuum.solve.cpu",
    "cuda": "continuum.solve.cuda",
}
"""Name of a device, and the module of its back end, imported when it is first asked for."""


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
    found = cast("BackEnd", import_module(BACK_ENDS[device]))
    found.require()
    return found


class BackEnd(Protocol):
    """What the module of a back end offers."""

    SMALLEST: int
    """Grids of no more points along a side have no coarser one."""
    LEVELS: int
    """Grids that a step of the smooth solver uses, at most."""
    CAUTION: str
    """What its user has to know before relying on it; empty for nothing."""

    def require(self) -> None:
        """Raise :class:`continuum.errors.InputError`, with what to install, where this machine cannot run it."""

    def machine(self) -> str:
        """Name of what it runs on, beyond the name of the device; empty for nothing."""

    def devices(self) -> tuple[str, ...]:
        """Names of those that processes should not share; empty where they may."""

    def level(self, grid: Grid, stiffness_q: Real, threads: int, coarser: int) -> Level:
        """A grid of the smooth solver, with up to so many coarser ones.

        ``stiffness_q`` is K in E*/a0, shape ``grid.shape_q``; at q = 0 that of each problem counts.
        """

    def face(self, grid: Grid, stiffness_q: Real, threads: int) -> Face:
        """A grid of the solver under a bound."""


class Level(Protocol):
    """A grid of the smooth solver: gap z, gradient g, direction d, in the words of :mod:`continuum.solve.smooth`.

    g lies in Fourier space.  <a b> is the mean of a product over the points, an equal sum over the modes; sums that
    are an array are six: <g g>, <g s>, <y s>, <y M y>, <s K s>, <s K d>.
    """

    @property
    def coarser(self) -> Level | None:
        """The grid of every second point; None if there is none."""

    @property
    def work(self) -> Work:
        """What was done for the problem at hand."""

    def pose(
        self, law: Law, offset: Real, start: Real | None, *, lift: float, pressure: float, mean_stiffness: float
    ) -> bool:
        """Take a problem, here and on all coarser grids, and forget the last one; False if it is not finite.

        ``offset`` and ``start``, shape ``grid.shape``, in a0, are not changed; ``mean_stiffness`` is K at q = 0,
        infinite where the mean of u is held at zero.
        """

    def pose_coarser(self, *, started: bool) -> None:
        """Give the coarser grid its part of offset and, after :meth:`place`, of the displacement as its start.

        d is lost.
        """

    def place(self) -> None:
        """Go to the start: z, where the mean of u is held moved to that, and g."""

    def rest(self) -> None:
        """Go to u = 0: z and g."""

    def prolong(self) -> None:
        """Go to the displacement of the coarser grid, no waves beyond: z and g; to u = 0 where that is not finite."""

    def gradient(self, shift: float, alpha: float, beta: float, *, coarse: bool, complete: bool) -> Real:
        """Finish the last step, of length ``alpha`` along a direction that kept ``beta`` of the one before.

        With y the change of the gradient by that step, g <- g + y, and s = M g with M = 1/(K + shift) is the new step;
        returns the sums.  With ``coarse`` the modes of the coarser grid take no part in any sum but <g g>.  g that is
        not ``complete`` lacks the traction of z, as after :meth:`place`, :meth:`rest` and :meth:`prolong`, or that of
        the last step; g that is stays what it is.
        """

    def restrict(self) -> None:
        """Let the coarser grid begin from here: at every second z, with its part of g."""

    def low_modes(self, shift: float) -> Real:
        """The modes of the coarser grid: there s is minus how far that has displaced the surface.  Their sums."""

    def low_gradient(self, shift: float) -> Real:
        """The same modes with s = M g after all: of their sums <g s> and <s K s>."""

    def turn(self, beta: float, *, coarse: bool) -> float:
        """Set d <- beta d - s; returns <φ'' d d> over the points near the wall."""

    def line(self, alpha: float) -> tuple[float, float]:
        """At z - alpha d, over the points near the wall: <(change of p) d> and <φ'' d d>."""

    def move(self, step: float, alpha: float) -> tuple[float, float, float]:
        """Set z <- z - step d, the last of several that add up to alpha.

        Returns, of all of these, <(change of p) d>; what φ changes beyond first order, and its size, as means.
        """

    def clear(self) -> None:
        """Forget d, which may not be finite."""

    def residual(self) -> float:
        """Root-mean-square gradient at z, all of it computed afresh; g is this from then on."""

    def take_gap(self) -> Real:
        """Hand z out as an array of the host that nobody else uses, shape ``grid.shape``, in a0."""

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """½ <u K u> of u = offset - gap without its mean, in E* a0, between two problems."""


class Face(Protocol):
    """A grid of the solver under a bound: pressure p, gap z, direction t, in the words of :mod:`continuum.solve.hard`.

    z is held without its level, a number.  s = M z and m, about M 1, vanish off the contact; a trial is a pressure
    that may become p.  Sums are over the points.
    """

    size: int
    """Number of points."""

    @property
    def work(self) -> Work:
        """What was done for the problem at hand."""

    def pose(self, offset: Real, start: Real | None, *, lift: float, sink: float, mean_stiffness: float) -> bool:
        """Take a problem, with p = 0, and forget the last one; False if it is not finite.

        The offset is ``offset + lift - sink``, the arrays of shape ``grid.shape``; ``mean_stiffness`` is K at q = 0,
        infinite where the mean of u is held at zero.
        """

    def pose_coarser(self) -> Face | None:
        """The grid of every second point, with its part of the problem; None if there is none."""

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

    def scale(self, factor: float) -> None:
        """Set p <- factor p."""

    def total(self) -> float:
        """Sum of p."""

    def open(self, window: float) -> None:
        """Make M: K with its kernel in real space cut off by a triangular window, this part of the period wide.

        m = 1.
        """

    def displace(self) -> tuple[float, float]:
        """Set z <- G p + offset; returns the energy of the dual, per point, and the size of what it is the sum of."""

    def clear(self) -> None:
        """Forget t, and the last change of z."""

    def level(self) -> tuple[float, float]:
        """Where p presses: sums of m z and of m."""

    def select(self, level: float) -> tuple[float, float, float, float]:
        """Find the contact: the points that press or overlap.

        Returns how many there are, how many are new or gone, and their sums of m z and of m.
        """

    def renew(self) -> None:
        """Set m <- M 1 on the contact, or 1 if the sum of that is not positive."""

    def precondition(self, level: float) -> float:
        """Set s <- M (z + level) on the contact; returns its sum."""

    def correct(self, weight: float) -> Real:
        """Set s <- s - weight m, t <- 0 off the contact; sums of s s, z s, (last change of z) s, t, z t, z m."""

    def turn(self, beta: float, weight: float) -> None:
        """Set t <- s + beta (t - weight m)."""

    def curvature(self) -> float:
        """<t G t>."""

    def trial(self, step: float) -> tuple[float, float, float]:
        """Try p - step t, cut at zero; sums of what was cut, negative, of p - step t, and of the trial."""

    def advance(self, step: float) -> None:
        """Take a trial that was not cut, the first after :meth:`curvature`: p, and z with it."""

    def arrive(self, factor: float) -> tuple[float, float]:
        """Scale the trial, and find its gap; returns the energy of the dual as :meth:`displace` does."""

    def accept(self) -> None:
        """Take the trial that :meth:`arrive` has looked at: p and z."""

    def misses(self, level: float) -> tuple[float, float]:
        """Of e, what closing the contact and lifting the overlaps adds to u: root mean square of K e, largest e.

        s, t and the last change of z are lost.
        """

    def duality_gap(self) -> tuple[float, float]:
        """<p (z - min z)>, and 2 <p> sqrt(Σ 1/K²) over q ≠ 0: what it is at most, for a residual of one."""

    def take(self, level: float) -> tuple[Real, Real]:
        """Hand out the gap, zero where p presses and positive elsewhere, and p: arrays of the host, in a0 and E*."""

    def elastic_energy(self, offset: Real, gap: Real) -> float:
        """As :meth:`Level.elastic_energy`."""


if TYPE_CHECKING:
    from continuum.solve import cpu, cuda

    _COMPLETE: tuple[BackEnd, ...] = (cpu, cuda)
